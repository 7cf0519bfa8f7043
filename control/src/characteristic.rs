//! The characteristic of a pulse former: the mean of its pulses as a function of its input, with the current settings.

use anyhow::{Context, Result, bail};
use blocks::{Characteristic, Kind};
use modeldescription::Table;
use run::dialog;
use run::fmus::Fmus;
use run::fmus::Member;
use run::fmus::number_of;
use run::master::Run;
use run::plan::Plan;
use run::system::{self, Setting, System, Value};
use serde::{Deserialize, Serialize};

/// The maximum number of calls for one characteristic; with longer periods, it has fewer points.
const MOST_CALLS: usize = 4_000_000;

/// The minimum number of points of a characteristic.
const FEWEST_POINTS: usize = 11;

/// The block whose characteristics are requested.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CharacteristicRequest {
    /// The block with its settings.
    pub member: Member,
}

/// The characteristics that the block's table describes, with these settings.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Characteristics {
    /// One for each characteristic in the table that differs in the swept variable or in the outputs shown.
    pub sweeps: Vec<Sweep>,
}

/// The means of variables as functions of an input.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Sweep {
    /// The title of the chart.
    pub title: String,
    /// The input that is varied, on the horizontal axis.
    pub variable: String,
    /// The unit of this input.
    pub unit: Option<String>,
    /// Its values, one per point.
    pub inputs: Vec<f64>,
    /// Each variable with its mean at each input value; TRUE counts as 1.
    pub outputs: Vec<(String, Vec<f64>)>,
}

/// Computes the characteristics of a block with the member's settings: one for each sweep in the table that differs in
/// the swept variable or in the outputs shown.
///
/// # Errors
/// The block does not exist or rejects a setting, or a period of its pulses takes too many calls.
pub fn characteristics(home: &dyn Fmus, member: &Member) -> Result<Characteristics> {
    let table = home.table(&member.fmu)?;
    let table = table.with_context(|| format!("{} is a foreign FMU: its characteristics are unknown", member.fmu))?;
    let mut distinct: Vec<&Characteristic<String>> = Vec::new();
    for of in &table.characteristics {
        if !distinct.iter().any(|known| known.variable == of.variable && known.show == of.show) {
            distinct.push(of);
        }
    }
    let sweeps = distinct.into_iter().map(|of| sweep(home, member, &table, of)).collect::<Result<_>>()?;
    Ok(Characteristics { sweeps })
}

/// Returns the member's value of a setting, or its start value if it is not set; TRUE is 1.
fn value(member: &Member, table: &Table, row: usize, description: &modeldescription::Description) -> f64 {
    let row = &table.rows[row];
    let start = || description.start(&row.name).unwrap_or(row.start());
    member.values.get(&row.name).map_or_else(start, |value| number_of(*value))
}

fn sweep(home: &dyn Fmus, member: &Member, table: &Table, of: &Characteristic<String>) -> Result<Sweep> {
    let description = home.description(&member.fmu)?;
    let step = value(member, table, table.cycle, &description);
    let (roles, _) = dialog::read(table)?;
    let period = roles.pulse_former.first().and_then(|name| table.find(name));
    let period = period.map(|row| {
        let given = value(member, table, row, &description);
        // The period is a time or a number of calls.
        if table.rows[row].kind == Kind::Time { given / step.max(0.001) } else { given }
    });
    // The mean is taken over whole periods.
    let period = period.filter(|period| period.is_finite()).map_or(1, |period| period.round().max(1.0) as usize);
    let calls = (of.calls as usize).next_multiple_of(period);
    if calls > MOST_CALLS / FEWEST_POINTS {
        bail!("the pulse period spans {period} calls, so the characteristic would take too long: shorten the period");
    }
    let points = (of.points as usize).min(MOST_CALLS / calls);
    let (from, to) = of.range;
    let inputs: Vec<f64> = (0..points).map(|point| from + (to - from) * point as f64 / (points - 1) as f64).collect();
    let mut outputs: Vec<(String, Vec<f64>)> = of.show.iter().map(|name| (name.clone(), Vec::new())).collect();
    for input in &inputs {
        let swept = (&of.variable, Value::Number(*input));
        let own = member.values.iter().filter(|(name, _)| **name != of.variable).map(|(name, value)| (name, *value));
        let setting = |(name, value): (&String, Value)| Setting {
            variable: format!("{}.{name}", member.name),
            value,
            time: None,
            is_preliminary: false,
            place: None,
        };
        let system = System {
            members: vec![system::Member { name: member.name.clone(), path: member.fmu.clone().into() }],
            settings: own.chain([swept]).map(setting).collect(),
            record: of.show.iter().map(|name| format!("{}.{name}", member.name).as_str().into()).collect(),
            stop: Some(step * calls as f64),
            step: Some(step),
            ..System::default()
        };
        let plan = Plan::new(&system, &[&description])?;
        let mut run = Run::begin(&plan, vec![home.instantiate(&member.fmu, &member.name)?], None)?;
        let mut sums = vec![0.0; of.show.len()];
        for _ in 0..calls {
            run.step(&plan)?;
            sums.iter_mut().zip(run.row()).for_each(|(sum, value)| *sum += value);
        }
        outputs.iter_mut().zip(sums).for_each(|((_, means), sum)| means.push(sum / calls as f64));
    }
    let swept = table.find(&of.variable).map(|row| &table.rows[row]);
    Ok(Sweep {
        // The table's own title names the table's settings, not the member's.
        title: format!("{} over {}", of.show.join(", "), of.variable),
        variable: of.variable.clone(),
        unit: swept.and_then(|row| if row.kind == Kind::Time { Some("s".into()) } else { row.unit.clone() }),
        inputs,
        outputs,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use doubles::TestHome;
    use run::fmus::Values;

    fn member(values: &[(&str, Value)]) -> Member {
        let values: Values = values.iter().map(|(name, value)| (name.to_string(), *value)).collect();
        Member { name: "C".into(), fmu: "PID".into(), values }
    }

    #[test]
    fn a_characteristic_is_that_of_the_members_settings_and_each_is_there_once() {
        let on = ("MAN_ON", Value::Boolean(true));
        let member = member(&[on, ("HIGH", Value::Number(40.0)), ("MAN", Value::Number(7.0))]);
        let all = characteristics(&TestHome::default(), &member).unwrap();
        let [sweep] = all.sweeps.as_slice() else { panic!("{} characteristics", all.sweeps.len()) };
        assert_eq!((sweep.title.as_str(), sweep.unit.as_deref()), ("OUT, UP over MAN", Some("%")));
        assert_eq!(sweep.inputs, [0.0, 25.0, 50.0, 75.0, 100.0]);
        // HIGH is 40, and not the 50 of the table's characteristic.
        assert_eq!(sweep.outputs[0], ("OUT".into(), vec![0.0, 25.0, 40.0, 40.0, 40.0]));
        assert_eq!(sweep.outputs[1], ("UP".into(), vec![0.0; 5]));
    }

    #[test]
    fn what_the_block_refuses_and_what_has_no_table_is_said() {
        let error = |member: &Member| format!("{:#}", characteristics(&TestHome::default(), member).unwrap_err());
        assert!(error(&member(&[("HIG", Value::Number(1.0))])).contains("did you mean C.HIGH?"));
        let foreign = Member { fmu: "FOREIGN".into(), ..member(&[]) };
        assert_eq!(error(&foreign), "FOREIGN is a foreign FMU: its characteristics are unknown");
    }
}
