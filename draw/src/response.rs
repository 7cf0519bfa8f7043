//! A block's responses and characteristics as charts.

use crate::plot::{Chart, Curve, Panel};
use blocks::{Class, Kind, Role};
use modeldescription::{Characteristic, Row, Table};

/// A response: what a library was recorded doing.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The time between two calls, in milliseconds.
    pub cycle: u32,
    /// The variables that are recorded and drawn, by row.
    pub shown: Vec<usize>,
    /// Their values after the restart.
    pub restart: Vec<f64>,
    /// Their values in each call.
    pub calls: Vec<Vec<f64>>,
}

impl Recording {
    /// The time of a call in seconds.
    pub fn time(&self, call: usize) -> f64 {
        call as f64 * f64::from(self.cycle) / 1000.0
    }
}

/// A characteristic, as it was recorded: the values of its variable, and the mean of each shown variable at each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The values of the variable.
    pub over: Vec<f64>,
    /// The shown variables, by row, and their means.
    pub means: Vec<(usize, Vec<f64>)>,
}

/// A block's response, as a library has answered it.
pub fn of_recording(table: &Table, recording: &Recording) -> Chart {
    let mut panels: Vec<(String, Panel)> = Vec::new();
    let mut lanes = Vec::new();
    for (column, row) in recording.shown.iter().enumerate() {
        let row = &table.variables[*row];
        // The value of the last call is held for a cycle, as those before it.
        let values = recording.calls.iter().chain(recording.calls.last()).map(|values| values[column]).collect();
        let curve = Curve { name: row.name.clone(), values, is_input: row.role == Role::Input, color: None };
        if row.kind == Kind::Bool {
            lanes.push(curve);
            continue;
        }
        add(&mut panels, unit(row), curve);
    }
    let time = match recording.calls.len() {
        0 => Vec::new(),
        calls => (0..=calls).map(|call| recording.time(call)).collect(),
    };
    let panels = panels.into_iter().map(|(_, panel)| panel.labelled()).collect();
    Chart { title: format!("Response of {}", table.name), time, over: None, panels, lanes }
}

/// A block's characteristic, as a library has answered it. A BOOL is drawn as the share of calls in which it was TRUE.
pub fn of_sweep(table: &Table, characteristic: &Characteristic, sweep: &Sweep) -> Chart {
    let mut panels: Vec<(String, Panel)> = Vec::new();
    for (row, means) in &sweep.means {
        let row = &table.variables[*row];
        let curve = Curve { name: row.name.clone(), values: means.clone(), is_input: false, color: None };
        add(&mut panels, if row.kind == Kind::Bool { "share of the calls" } else { unit(row) }, curve);
    }
    let row = table.find(&characteristic.variable).map(|row| &table.variables[row]);
    let over = match row.and_then(Row::shown_unit) {
        Some(unit) => format!("{} in {unit}", characteristic.variable),
        None => characteristic.variable.clone(),
    };
    Chart {
        title: format!("Characteristic of {}", table.name),
        time: sweep.over.clone(),
        over: Some(over),
        panels: panels.into_iter().map(|(_, panel)| panel.labelled()).collect(),
        lanes: Vec::new(),
    }
}

/// What a panel is named by: curves with the same unit share one.
fn unit(row: &Row) -> &str {
    match row.kind {
        kind if kind.class() == Class::Integer => kind.name(),
        _ => row.shown_unit().unwrap_or_default(),
    }
}

fn add(panels: &mut Vec<(String, Panel)>, unit: &str, curve: Curve) {
    match panels.iter_mut().find(|(of, _)| of == unit) {
        Some((_, panel)) => panel.curves.push(curve),
        None => panels.push((unit.to_string(), Panel { label: unit.to_string(), curves: vec![curve] })),
    }
}

impl Panel {
    /// With the names of the curves for a label where there is no unit, if they fit beside the panel.
    fn labelled(mut self) -> Panel {
        if self.label.is_empty() {
            let names = self.curves.iter().map(|curve| curve.name.as_str()).collect::<Vec<_>>().join(", ");
            if names.chars().count() <= 26 {
                self.label = names;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

    #[test]
    fn a_characteristic_has_straight_lines_over_its_variable_with_its_unit() {
        let row = |name: &str, kind: &str, unit: &str| {
            format!(
                r#"{{"name":"{name}","description":"","kind":"{kind}","role":"input","start":0.0,"min":null,"max":null,
                "unit":{unit}}}"#
            )
        };
        let rows = [row("SPEED", "LREAL", "\"1/min\""), row("FLOW", "LREAL", "\"l/min\""), row("ON", "BOOL", "null")];
        let table: Table = serde_json::from_str(&format!(
            r#"{{"name":"PUMP","docs":"","cycle":0,"mean":null,"responses":[],"variables":[{}],"characteristics":[
            {{"title":"Flow","variable":"SPEED","range":[0.0,9.0],"points":3,"calls":1,"set":[],"show":["FLOW","ON"]}}]}}"#,
            rows.join(",")
        ))
        .unwrap();
        let means = vec![(1, vec![0.0, 2.0, 6.0]), (2, vec![0.0, 0.5, 1.0])];
        let sweep = Sweep { over: vec![0.0, 4.5, 9.0], means };
        let chart = of_sweep(&table, &table.characteristics[0], &sweep);
        assert_eq!(chart.over.as_deref(), Some("SPEED in 1/min"));
        let labels: Vec<_> = chart.panels.iter().map(|panel| panel.label.as_str()).collect();
        assert_eq!(labels, ["l/min", "share of the calls"]);
        let svg = svg(&chart).unwrap();
        assert!(svg.contains(">SPEED in 1/min</text>") && !svg.contains("time in s"));
        // From the left end by the middle to the right end, and no stairs.
        let flow =
            svg.split("class=\"curve-1\"").last().unwrap().split('"').find(|part| part.starts_with('M')).unwrap();
        assert_eq!(flow.matches('L').count(), 2, "{flow}");
        assert!(!flow.contains('H') && !flow.contains('V'), "{flow}");
    }
}
