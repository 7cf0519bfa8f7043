//! Steps several runs side by side.

use super::{Run, due};
use crate::component::{Abreast, Component, Wiring};
use crate::plan::Plan;
use anyhow::{Result, bail};

/// Runs are stepped side by side only if no setting is due within this many steps.
const FEWEST: usize = 16;

impl<C: Component> Run<C> {
    /// Steps several runs of a plan side by side until the next setting is due or a step is not ordinary; performs none
    /// if a setting is due within the next few steps. Afterwards, each run is in the same state as after that number of
    /// [`Run::step`] calls. Returns false if the components do not support it or the first step is not ordinary. The
    /// runs must differ only in values. `record` receives, step by step, each column of the plan with its value in each
    /// run.
    ///
    /// # Errors
    /// An input was refused in the middle of a step, after some members had completed it: the runs cannot continue.
    /// Repeating each run alone shows which one failed.
    pub fn steps_abreast(runs: &mut [Run<C>], plan: &Plan, mut record: impl FnMut(usize, &[f64])) -> Result<bool> {
        let Some(first) = runs.first().filter(|_| !plan.members.iter().any(|of| of.has_events)) else {
            return Ok(false);
        };
        let (begin, count) = (first.steps, runs.len());
        let next = first.members.iter().map(|member| member.next).fold(f64::INFINITY, f64::min);
        if next <= due(plan, plan.time(begin + FEWEST)) {
            return Ok(true);
        }
        let recorded = first.recorded.clone();
        let mut values = vec![0.0; first.values.len() * count];
        for (number, run) in runs.iter().enumerate() {
            values.iter_mut().skip(number).step_by(count).zip(&run.values).for_each(|(to, value)| *to = *value);
        }

        let wirings: Vec<Wiring> = (0..plan.members.len()).map(|member| Wiring::new(plan, member)).collect();
        let mut members: Vec<Vec<&mut C>> = wirings.iter().map(|_| Vec::with_capacity(count)).collect();
        for run in &mut *runs {
            members.iter_mut().zip(&mut run.members).for_each(|(of, member)| of.push(&mut member.component));
        }
        let members = members.into_iter().zip(&wirings).map(|(of, wiring)| abreast(of, wiring));
        let Some(mut members) = members.collect::<Option<Vec<_>>>() else { return Ok(false) };
        let places = values.len() / 2;
        let (mut step, mut time) = (begin, plan.time(begin));
        while step < plan.steps && next > due(plan, time) && members.iter().all(|of| of.is_ordinary(time, plan.step)) {
            let (now, before) = values.split_at_mut(places);
            before.copy_from_slice(now);
            if !members.iter_mut().all(|of| of.cycle(&mut values, time, plan.step)) {
                bail!("an input was refused while stepping runs side by side");
            }
            for (column, place) in recorded.iter().enumerate() {
                record(column, &values[place * count..][..count]);
            }
            step += 1;
            time = plan.time(step);
        }
        members.into_iter().for_each(Abreast::end);

        for (number, run) in runs.iter_mut().enumerate().filter(|_| step > begin) {
            run.values.iter_mut().zip(values.iter().skip(number).step_by(count)).for_each(|(to, value)| *to = *value);
            (run.stepped, run.at, run.time) = (run.members.len(), run.members.len() - 1, plan.time(step - 1));
            run.steps = step;
            run.record();
        }
        Ok(step > begin)
    }
}

/// Combines the same member of all runs.
fn abreast<'a, C: Component>(of: Vec<&'a mut C>, wiring: &Wiring) -> Option<Box<dyn Abreast + 'a>> {
    let sides = of.into_iter().map(C::side).collect::<Option<Vec<_>>>()?;
    let combine = sides.first()?.combine;
    combine(sides.into_iter().map(|side| side.component).collect(), wiring)
}
