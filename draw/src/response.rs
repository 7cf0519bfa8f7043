//! Charts of a block's responses and characteristics.

use crate::plot::{COLOR_COUNT, Chart, Curve, Panel, axis_label};
use blocks::{Characteristic, Class, Kind, Role};
use modeldescription::{Row, Table};

/// A response, as recorded from a library.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The time between two calls, in milliseconds.
    pub cycle: u32,
    /// The rows in the table of the variables that are recorded and drawn.
    pub shown: Vec<usize>,
    /// The values of these variables after the restart.
    pub restart: Vec<f64>,
    /// Their values after each call, one list per call.
    pub calls: Vec<Vec<f64>>,
}

impl Recording {
    /// The time of a call in seconds.
    pub fn time(&self, call: usize) -> f64 {
        call as f64 * f64::from(self.cycle) / 1000.0
    }
}

/// A recorded characteristic: the values of the swept variable, and the mean of each shown variable at each value.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The values of the swept variable.
    pub over: Vec<f64>,
    /// The rows in the table of the shown variables, each with its means.
    pub means: Vec<(usize, Vec<f64>)>,
}

/// The colour index of each row, the same in all charts of a block.
#[derive(Clone, Debug)]
pub struct Colors(Vec<Option<usize>>);

impl Colors {
    /// The colours for roles in a loop, common to all blocks: setpoint, process value, manipulated value.
    pub const OF_ROLES: [usize; 3] = [6, 0, 1];

    /// The order in which colours are assigned to other variables: to numbers, and to Booleans.
    const ORDER: [[usize; COLOR_COUNT]; 2] = [[3, 2, 4, 5, 0, 1, 6], [1, 5, 2, 4, 3, 0, 6]];

    /// Chooses the colours. `roles` are the setpoint, the process value and the manipulated value; `known` returns the
    /// colour that a variable of an inner block has in that block's own charts. Variables that share a chart get
    /// different colours, but a Boolean and a number may share one.
    pub fn new(table: &Table, roles: [Option<&str>; 3], known: impl Fn(&str) -> Option<usize>) -> Colors {
        let inner = |row: &Row| row.name.rsplit_once('.').and_then(|(_, name)| known(name));
        let mut colors: Vec<Option<usize>> = table.rows.iter().map(inner).collect();
        for (name, color) in roles.into_iter().zip(Self::OF_ROLES) {
            if let Some(row) = name.and_then(|name| table.find(name)) {
                colors[row] = Some(color);
            }
        }
        let responses = table.responses.iter().map(|response| table.shown(response));
        let sweeps = table.characteristics.iter().map(|one| table.find_all(&one.show));
        let charts: Vec<Vec<usize>> = responses.chain(sweeps).collect();
        let is_boolean = |row: usize| table.rows[row].kind == Kind::Bool;
        for row in charts.iter().flatten().copied() {
            if colors[row].is_none() {
                let beside = charts.iter().filter(|chart| chart.contains(&row)).flatten();
                let taken: Vec<usize> = beside
                    .filter(|other| is_boolean(**other) == is_boolean(row))
                    .filter_map(|other| colors[*other])
                    .collect();
                colors[row] = Some(Self::free(is_boolean(row), &taken));
            }
        }
        Colors(colors)
    }

    /// The colour of a row, if a chart shows it.
    pub fn of_row(&self, row: usize) -> Option<usize> {
        self.0[row]
    }

    /// The first colour that is not in `taken`, in the order for Booleans or for numbers.
    pub fn free(is_boolean: bool, taken: &[usize]) -> usize {
        let mut numbers = Self::ORDER[usize::from(is_boolean)].into_iter().chain(COLOR_COUNT..);
        numbers.find(|color| !taken.contains(color)).unwrap_or_default()
    }
}

/// Draws a block's response, as recorded from a library.
pub fn of_recording(table: &Table, recording: &Recording, colors: &Colors) -> Chart {
    let mut panels = Vec::new();
    let mut lanes = Vec::new();
    for (column, number) in recording.shown.iter().enumerate() {
        let row = &table.rows[*number];
        // The value of the last call is held for one cycle, like the others.
        let values = recording.calls.iter().chain(recording.calls.last()).map(|values| values[column]).collect();
        let is_input = row.role == Role::Input;
        let curve = Curve { name: row.name.clone(), values, is_input, color: colors.of_row(*number) };
        if row.kind == Kind::Bool {
            lanes.push(curve);
            continue;
        }
        add(&mut panels, Axis::new(row, table), curve);
    }
    let time = match recording.calls.len() {
        0 => Vec::new(),
        calls => (0..=calls).map(|call| recording.time(call)).collect(),
    };
    Chart { time, panels: labelled(panels), lanes, is_narrow: true, ..Chart::default() }
}

/// Draws a block's characteristic, as recorded from a library. A BOOL is drawn as the share of calls in which it was
/// TRUE.
pub fn of_sweep(table: &Table, characteristic: &Characteristic<String>, sweep: &Sweep, colors: &Colors) -> Chart {
    let mut panels = Vec::new();
    for (number, means) in &sweep.means {
        let row = &table.rows[*number];
        let is_boolean = row.kind == Kind::Bool;
        let values = means.iter().map(|mean| if is_boolean { 100.0 * mean } else { *mean }).collect();
        let curve = Curve { name: row.name.clone(), values, is_input: false, color: colors.of_row(*number) };
        add(&mut panels, if is_boolean { Axis::Share } else { Axis::new(row, table) }, curve);
    }
    let row = table.find(&characteristic.variable).map(|row| &table.rows[row]);
    let over = match row.and_then(|row| drawn_unit(row, table)) {
        Some(unit) => format!("{} in {unit}", characteristic.variable),
        None => characteristic.variable.clone(),
    };
    Chart { time: sweep.over.clone(), over: Some(over), panels: labelled(panels), is_narrow: true, ..Chart::default() }
}

/// What the curves of a panel have in common.
#[derive(PartialEq)]
enum Axis<'a> {
    Unit(&'a str),
    /// Integers of the PLC type with this name.
    Whole(&'static str),
    /// Signals without a common unit.
    Plain,
    /// A setting without a unit, by name: its numbers are unrelated to those of the signals.
    Setting(&'a str),
    /// The percentage of calls in which a Boolean is TRUE.
    Share,
}

impl<'a> Axis<'a> {
    fn new(row: &'a Row, table: &'a Table) -> Axis<'a> {
        match (drawn_unit(row, table), row.role) {
            _ if row.kind.class() == Class::Integer => Axis::Whole(row.kind.name()),
            (Some(unit), _) => Axis::Unit(unit),
            (None, Role::Parameter | Role::Fixed) => Axis::Setting(&row.name),
            (None, _) => Axis::Plain,
        }
    }

    /// The label beside the panel.
    fn label(&self, curves: &[Curve]) -> String {
        let names: Vec<_> = curves.iter().map(|curve| curve.name.as_str()).collect();
        match self {
            Axis::Unit(unit) => axis_label(&names, Some(unit)),
            Axis::Whole(kind) => format!("{} ({kind})", axis_label(&names, None)),
            Axis::Plain | Axis::Setting(_) => axis_label(&names, None),
            Axis::Share => "TRUE in % of the calls".into(),
        }
    }
}

/// The unit of a row in a drawing: its own or, for a signal without one, that of the block's signals.
fn drawn_unit<'a>(row: &'a Row, table: &'a Table) -> Option<&'a str> {
    let is_signal = matches!(row.role, Role::Input | Role::Output) && row.kind.class() == Class::Real;
    row.shown_unit().or_else(|| table.drawn_unit.as_deref().filter(|_| is_signal))
}

fn add<'a>(panels: &mut Vec<(Axis<'a>, Vec<Curve>)>, axis: Axis<'a>, curve: Curve) {
    match panels.iter_mut().find(|(of, _)| *of == axis) {
        Some((_, curves)) => curves.push(curve),
        None => panels.push((axis, vec![curve])),
    }
}

fn labelled(panels: Vec<(Axis, Vec<Curve>)>) -> Vec<Panel> {
    panels.into_iter().map(|(axis, curves)| Panel { label: axis.label(&curves), curves, bands: Vec::new() }).collect()
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
        let table: Table = modeldescription::read_table(&format!(
            r#"{{"name":"PUMP","docs":"","cycle":0,"mean":null,"responses":[],"variables":[{}],"characteristics":[
            {{"title":"Flow","variable":"SPEED","range":[0.0,9.0],"points":3,"calls":1,"set":[],"show":["FLOW","ON"]}}]}}"#,
            rows.join(",")
        ))
        .unwrap();
        let means = vec![(1, vec![0.0, 2.0, 6.0]), (2, vec![0.0, 0.5, 1.0])];
        let sweep = Sweep { over: vec![0.0, 4.5, 9.0], means };
        let colors = Colors::new(&table, [None; 3], |_| None);
        let chart = of_sweep(&table, &table.characteristics[0], &sweep, &colors);
        assert_eq!(chart.over.as_deref(), Some("SPEED in 1/min"));
        let labels: Vec<_> = chart.panels.iter().map(|panel| panel.label.as_str()).collect();
        assert_eq!(labels, ["FLOW in l/min", "TRUE in % of the calls"]);
        assert_eq!(chart.panels[1].curves[0].values, [0.0, 50.0, 100.0]);
        let svg = svg(&chart).unwrap();
        assert!(svg.contains(">SPEED in 1/min</text>") && !svg.contains("time in s"));
        // From the left end by the middle to the right end, and no stairs.
        let flow =
            svg.split("class=\"curve-4\"").last().unwrap().split('"').find(|part| part.starts_with('M')).unwrap();
        assert_eq!(flow.matches('L').count(), 2, "{flow}");
        assert!(!flow.contains('H') && !flow.contains('V'), "{flow}");
    }

    #[test]
    fn a_variable_has_one_colour_in_all_charts_and_none_of_those_beside_it() {
        let rows: Vec<String> = ["SP", "PV", "P", "I", "D", "HIGH", "LOW", "PID.MV"]
            .iter()
            .map(|name| {
                let kind = if ["HIGH", "LOW"].contains(name) { "BOOL" } else { "REAL" };
                format!(
                    r#"{{"name":"{name}","description":"","kind":"{kind}","role":"output","start":0.0,"min":null,"max":null,
                    "unit":null}}"#
                )
            })
            .collect();
        let charts =
            [vec!["PV", "I"], vec!["P", "D", "HIGH"], vec!["SP", "PV", "P", "I", "D", "HIGH", "LOW", "PID.MV"]];
        let charts = charts.map(|show| format!(r#"{{"title":"","calls":1,"set":[],"show":{show:?}}}"#)).join(",");
        let json = format!(
            r#"{{"name":"X","docs":"","cycle":0,"mean":null,"responses":[{charts}],"variables":[{}]}}"#,
            rows.join(",")
        );
        let table: Table = modeldescription::read_table(&json).unwrap();
        let known = |name: &str| (name == "MV").then_some(1);
        let colors = Colors::new(&table, [Some("SP"), Some("PV"), None], known).0;
        // I comes first, then P and D beside it; the Booleans have lanes of their own. MV has the colour of its own
        // block's charts.
        assert_eq!(colors, [6, 0, 2, 3, 4, 1, 5, 1].map(Some));
    }

    #[test]
    fn an_axis_says_what_it_shows_in_which_unit_and_a_setting_has_its_own() {
        let row = |name: &str, role: &str, unit: &str| {
            format!(
                r#"{{"name":"{name}","description":"","kind":"REAL","role":"{role}","start":0.0,"min":null,"max":null,
                "unit":{unit}}}"#
            )
        };
        let rows = [
            row("TEMP", "output", "\"degC\""),
            row("LMN", "output", "null"),
            row("GAIN", "parameter", "null"),
            row("A_LONG_NAME_OF_A_SIGNAL", "output", "null"),
            row("AMBIENT_TEMPERATURE_OF_IT", "output", "\"degC\""),
        ];
        let json = r#"{"name":"X","docs":"","cycle":0,"mean":null,"responses":[],"variables":["#;
        let table: Table = modeldescription::read_table(&format!("{json}{}]}}", rows.join(","))).unwrap();
        let labels = |shown: &[usize]| -> Vec<String> {
            let calls = vec![vec![0.0; shown.len()]; 2];
            let recording = Recording { cycle: 100, shown: shown.to_vec(), restart: calls[0].clone(), calls };
            let colors = Colors::new(&table, [None; 3], |_| None);
            of_recording(&table, &recording, &colors).panels.into_iter().map(|panel| panel.label).collect()
        };
        assert_eq!(labels(&[0, 1, 2]), ["TEMP in degC", "LMN", "GAIN"]);
        assert_eq!(labels(&[0, 4, 1, 3]), ["degC", "LMN, A_LONG_NAME_OF_A_SIGNAL"]);
        // A controller's signals have the unit derived from its start values, but its settings have none.
        let table = Table { drawn_unit: Some("%".into()), ..table.clone() };
        let calls = vec![vec![0.0; 3]; 2];
        let recording = Recording { cycle: 100, shown: vec![0, 1, 2], restart: calls[0].clone(), calls };
        let chart = of_recording(&table, &recording, &Colors::new(&table, [None; 3], |_| None));
        let labels: Vec<_> = chart.panels.iter().map(|panel| panel.label.as_str()).collect();
        assert_eq!(labels, ["TEMP in degC", "LMN in %", "GAIN"]);
        let calls = vec![vec![1.0]; 2];
        let recording = Recording { cycle: 100, shown: vec![0], restart: vec![0.0], calls };
        let chart = of_recording(&table, &recording, &Colors::new(&table, [None; 3], |_| None));
        assert!(svg(&chart).unwrap().contains(">TEMP in °C</text>"));
    }
}
