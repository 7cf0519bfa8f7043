//! The setup, calls and events of a run, to be repeated.

use super::{Exchanged, Record};
use crate::describe::describe;
use crate::home::Home;
use crate::message::{self, Act, Event, Events, Setup, Values};
use anyhow::{Context, Result};
use run::system::own_name;
use std::collections::HashSet;

/// The setup, calls and events of a run, to be repeated.
pub(super) struct Script {
    pub(super) setup: Setup,
    pub(super) calls: usize,
    pub(super) events: Vec<Event>,
    pub(super) exchanges: Vec<Exchanged>,
}

impl Script {
    pub(super) fn new(record: &Record) -> Script {
        let Events { setup, events, calls } = record.events();
        Script { setup, calls, events, exchanges: record.exchanges.clone() }
    }

    /// Turns the script into a test with other settings. Of the events, only stimuli and forced variables recur; all
    /// other settings apply from the beginning, with their last values or those in `values`. If members were replaced,
    /// the last ones take part from the beginning.
    pub(super) fn put_settings(&mut self, home: &dyn Home, values: &Values) -> Result<()> {
        if let Some(last) = self.exchanges.pop() {
            self.exchanges.clear();
            let before = self.setup.members.split_off(1);
            self.setup.members.extend(last.members);
            self.setup.connections = last.connections;
            for member in &mut self.setup.members[1..] {
                let stimuli = stimuli(home, member)?;
                let Some(same) = before.iter().find(|of| of.name == member.name && of.fmu == member.fmu) else {
                    continue;
                };
                member.values.retain(|name, _| !stimuli.contains(name));
                let begin = same.values.iter().filter(|(name, _)| stimuli.contains(*name));
                member.values.extend(begin.map(|(name, value)| (name.clone(), *value)));
            }
        }
        let members = &mut self.setup.members;
        let names = |name: &str, members: &[message::Member]| {
            // This is unambiguous: no member's name begins with another's name followed by a dot.
            members.iter().position(|of| own_name(name, &of.name).is_some())
        };
        let all = members.clone();
        let stimuli = all.iter().map(|of| stimuli(home, of)).collect::<Result<Vec<_>>>()?;
        let is_stimulus = |name: &str| {
            names(name, &all).is_some_and(|place| stimuli[place].contains(&name[all[place].name.len() + 1..]))
        };
        let mut in_force = Values::new();
        self.events.retain(|event| {
            // Forced variables are part of the test if their members still exist.
            let keeps = match event.act {
                Act::Set => is_stimulus(&event.variable),
                _ => return names(&event.variable, &all).is_some(),
            };
            // Settings of a removed member are dropped.
            if !keeps && names(&event.variable, &all).is_some() {
                in_force.insert(event.variable.clone(), event.value);
            }
            keeps
        });
        in_force
            .extend(values.iter().filter(|(name, _)| !is_stimulus(name)).map(|(name, value)| (name.clone(), *value)));
        for (name, value) in in_force {
            let place = names(&name, members);
            let place = place.with_context(|| format!("the run has no member with the variable {name:?}"))?;
            let own = name[members[place].name.len() + 1..].to_string();
            members[place].values.insert(own, value);
        }
        Ok(())
    }
}

/// The names of a member's stimuli.
fn stimuli(home: &dyn Home, member: &message::Member) -> Result<HashSet<String>> {
    let variables = describe(home, &member.fmu)?.variables;
    Ok(variables.into_iter().filter(|of| of.is_stimulus).map(|of| of.name).collect())
}
