//! Event Mode at a communication point, before any FMU steps.

use super::{Run, Running, at_time};
use crate::component::{Component, MOST_UPDATES};
use crate::plan::Plan;
use anyhow::{Result, anyhow};

/// The state of an FMU's own events.
#[derive(Clone, Copy, Debug)]
pub(super) struct Own {
    /// The time of its next event in seconds; infinity if it has not announced one.
    next: f64,
    /// Whether it must be updated.
    is_needed: bool,
    /// Whether its event must wait for those of other FMUs.
    waits: bool,
}

impl Default for Own {
    /// An FMU may have an event immediately, before it has announced one.
    fn default() -> Own {
        Own { next: f64::NEG_INFINITY, is_needed: false, waits: false }
    }
}

impl<C: Component> Run<C> {
    /// Handles the events of a communication point.
    pub(super) fn handle_events(&mut self, plan: &Plan, time: f64, due: f64) -> Result<()> {
        self.keep();
        let mut waiting = Vec::new();
        for (member, (of, own)) in self.members.iter_mut().zip(&plan.members).enumerate() {
            let Some(events) = &mut of.own else { continue };
            self.at = member;
            (events.is_needed, events.waits) = (true, events.next <= due);
            if events.waits {
                waiting.push(member);
            }
            of.component.enter_events().map_err(|error| at_time(error, own, time))?;
            if of.next <= due {
                of.assign_due(own, due).map_err(|error| at_time(error, own, time))?;
            }
        }
        while !waiting.is_empty() {
            self.settle(plan, time)?;
            // The next event is that of the FMU with the fewest sources still waiting; among equals, of the first FMU.
            let feeds = |member: usize| {
                let sources = plan.members[member].sources.iter().map(|source| source.0);
                sources.filter(|from| *from != member && waiting.contains(from)).count()
            };
            let first = (0..waiting.len()).min_by_key(|place| feeds(waiting[*place])).unwrap_or_default();
            let member = waiting.remove(first);
            if let Some(events) = &mut self.members[member].own {
                events.waits = false;
            }
        }
        self.settle(plan, time)?;
        for (member, (of, own)) in self.members.iter_mut().zip(&plan.members).enumerate() {
            if of.own.is_some() {
                self.at = member;
                of.component.leave_events().map_err(|error| at_time(error, own, time))?;
            }
        }
        if std::mem::take(&mut self.is_new) {
            self.record_what_is_called_with(plan);
        }
        Ok(())
    }

    /// FMUs that have announced an event are called with the values from before the step. Switches the columns of their
    /// inputs to these values, and the columns of outputs that only they or earlier FMUs read.
    fn record_what_is_called_with(&mut self, plan: &Plan) {
        let count = self.values.len() / 2;
        let has_calls = |member: usize| self.members[member].own.is_some_and(|events| events.next.is_finite());
        for (place, column) in self.recorded.iter_mut().zip(&plan.columns).filter(|(place, _)| **place < count) {
            let reads = |member: &usize| plan.members[*member].sources.contains(&column.source);
            let mut readers = (0..plan.members.len()).filter(reads).peekable();
            let is_read = readers.peek().is_some();
            let is_read_before = is_read && readers.all(|member| member <= column.source.0 || has_calls(member));
            if is_read_before || column.is_input && has_calls(column.source.0) {
                *place += count;
            }
        }
    }

    /// Updates the FMUs that are not waiting until none requests another update and no output changes.
    fn settle(&mut self, plan: &Plan, time: f64) -> Result<()> {
        let count = self.values.len() / 2;
        for _ in 0..MOST_UPDATES {
            let mut is_settled = true;
            for (member, (of, own)) in self.members.iter_mut().zip(&plan.members).enumerate() {
                let Some(events) = of.own.filter(|events| !events.waits) else { continue };
                let is_changed = of.inputs_differ(&self.values, |source| source % count);
                if !(is_changed || events.is_needed) {
                    continue;
                }
                self.at = member;
                let places = of.wiring.own.clone();
                self.kept.clear();
                self.kept.extend_from_slice(&self.values[places.clone()]);
                of.update(is_changed.then_some((&self.values, count))).map_err(|error| at_time(error, own, time))?;
                of.observe(&mut self.values).map_err(|error| at_time(error, own, time))?;
                let is_same = self.values[places].iter().zip(&self.kept).all(|(a, b)| a.to_bits() == b.to_bits());
                is_settled &= is_same && !of.own.is_some_and(|events| events.is_needed);
            }
            if is_settled {
                return Ok(());
            }
        }
        let error = anyhow!(
            "event iteration does not end: outputs still change after {MOST_UPDATES} updates; step the loop \
             without Event Mode (event_mode = false)"
        );
        Err(at_time(error, &plan.members[self.at], time))
    }
}

impl<C: Component> Running<C> {
    /// Whether any input would receive a new value; `place` maps a source to its position.
    fn inputs_differ(&self, values: &[f64], place: impl Fn(usize) -> usize) -> bool {
        self.wiring.written.iter().any(|group| {
            let mut sources = group.seen.iter().zip(&group.sources);
            sources.any(|(seen, source)| seen.to_bits() != values[place(*source)].to_bits())
        })
    }

    /// Updates the FMU in Event Mode. `inputs`, if given, are the run's values and the number of current ones among
    /// them; the connected inputs are written from these first.
    fn update(&mut self, inputs: Option<(&[f64], usize)>) -> Result<()> {
        if let Some((values, count)) = inputs {
            self.write_inputs_at(values, |source| source % count)?;
        }
        let update = self.component.update()?;
        if let Some(events) = &mut self.own {
            (events.is_needed, events.next) = (update.is_needed, update.next.unwrap_or(f64::INFINITY));
        }
        Ok(())
    }

    /// Applies the inputs that earlier FMUs without Event Mode have changed in this step.
    pub(super) fn take_over(&mut self, values: &[f64]) -> Result<()> {
        if !self.inputs_differ(values, |source| source) {
            return Ok(());
        }
        self.component.enter_events()?;
        self.write_inputs(values)?;
        for _ in 0..MOST_UPDATES {
            self.update(None)?;
            if !self.own.is_some_and(|events| events.is_needed) {
                return self.component.leave_events();
            }
        }
        Err(anyhow!(
            "event iteration does not end: the FMU requests more than {MOST_UPDATES} updates; step the loop without \
             Event Mode (event_mode = false)"
        ))
    }
}
