//! A block's response as a drawing: numbers of one unit share a panel, Booleans have a lane each. Values are held from
//! call to call, so curves are stairs.

use crate::package::reference::Recording;
use crate::page::svg::{coordinate, escape};
use crate::page::text;
use modeldescription::Interface;
use modeldescription::interface::{Kind, Role};
use std::fmt::Write;

// In pixels.
const WIDTH: f64 = 760.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 16.0;
const PANEL: f64 = 190.0;
/// A line of a legend.
const LEGEND: f64 = 18.0;
const LANE: f64 = 15.0;
const LANE_GAP: f64 = 16.0;
const BOTTOM: f64 = 42.0;

/// Colours that people with a colour vision deficiency can tell apart (Okabe and Ito).
const COLORS: &[&str] = &["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195"];

/// What an input is drawn in: dashed.
const INPUT: &str = "#374151";

/// A variable to be drawn.
struct Curve<'a> {
    name: &'a str,
    color: &'static str,
    is_input: bool,
    /// In each call.
    values: Vec<f64>,
}

/// The drawing as SVG.
pub fn svg(interface: &Interface, recording: &Recording) -> String {
    let (panels, lanes) = curves(interface, recording);
    let scale = Scale { from: 0.0, to: recording.time(recording.calls.len()).max(recording.time(1)) };
    let lanes_height = if lanes.is_empty() { 0.0 } else { LANE_GAP + lanes.len() as f64 * (LANE + LANE_GAP) };
    let panels_height: f64 = panels.iter().map(|(_, curves)| legend_height(curves) + PANEL).sum();
    let height = panels_height + lanes_height + BOTTOM;

    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="Response of {name}">
<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>
<g font-family="sans-serif" font-size="12" fill="#374151">
"##,
        height = coordinate(height),
        name = escape(&interface.name),
    );
    let mut top = 0.0;
    for (unit, curves) in &panels {
        legend(&mut svg, unit, curves, top);
        top += legend_height(curves);
        panel(&mut svg, curves, recording, &scale, top);
        top += PANEL;
    }
    if !lanes.is_empty() {
        top += LANE_GAP;
    }
    for curve in &lanes {
        lane(&mut svg, curve, recording, &scale, top);
        top += LANE + LANE_GAP;
    }
    time_axis(&mut svg, &scale, top, panels.is_empty());
    svg.push_str("</g>\n</svg>\n");
    svg
}

/// The curves by panel, with the panel's unit; and the lanes.
fn curves<'a>(interface: &'a Interface, recording: &Recording) -> (Vec<(String, Vec<Curve<'a>>)>, Vec<Curve<'a>>) {
    let mut panels: Vec<(String, Vec<Curve>)> = Vec::new();
    let mut lanes = Vec::new();
    let mut colors = COLORS.iter().cycle();
    for (column, row) in recording.shown.iter().enumerate() {
        let row = &interface.variables[*row];
        let is_input = row.role == Role::Input;
        let values = recording.calls.iter().map(|values| values[column]).collect();
        let color = if is_input { INPUT } else { colors.next().unwrap_or(&INPUT) };
        let curve = Curve { name: &row.name, color, is_input, values };
        if row.kind == Kind::Bool {
            lanes.push(curve);
            continue;
        }
        let unit = match row.kind {
            Kind::Word | Kind::Int => row.kind.name().to_string(),
            _ => text::unit(row).unwrap_or_default().to_string(),
        };
        match panels.iter_mut().find(|(of, _)| *of == unit) {
            Some((_, curves)) => curves.push(curve),
            None => panels.push((unit, vec![curve])),
        }
    }
    (panels, lanes)
}

/// From a range of values to pixels.
struct Scale {
    from: f64,
    to: f64,
}

impl Scale {
    /// A time's place from the left.
    fn x(&self, time: f64) -> f64 {
        LEFT + (time - self.from) / (self.to - self.from) * (WIDTH - LEFT - RIGHT)
    }

    /// A value's place in a panel, from the top.
    fn y(&self, value: f64, top: f64) -> f64 {
        top + PANEL - (value - self.from) / (self.to - self.from) * PANEL
    }

    /// Round numbers within, about `count` of them.
    fn ticks(&self, count: f64) -> Vec<f64> {
        let rough = (self.to - self.from) / count;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough * 0.999);
        let step = step.unwrap_or(rough);
        let first = (self.from / step - 1e-9).ceil() as i64;
        let last = (self.to / step + 1e-9).floor() as i64;
        (first..=last).map(|tick| tick as f64 * step).collect()
    }
}

/// The range that a panel shows: all finite values, with some room.
fn range(curves: &[Curve]) -> Scale {
    let values = || curves.iter().flat_map(|curve| &curve.values).copied().filter(|value| value.is_finite());
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return Scale { from: 0.0, to: 1.0 };
    }
    let room = if high > low { (high - low) * 0.06 } else { high.abs().max(1.0) * 0.5 };
    Scale { from: low - room, to: high + room }
}

/// Where each name of a legend begins: from the left, and in which line.
fn legend_places(curves: &[Curve]) -> Vec<(f64, usize)> {
    let (mut x, mut line) = (LEFT, 0);
    let place = |curve: &Curve| {
        let width = 28.0 + curve.name.chars().count() as f64 * 7.3 + 18.0;
        if x > LEFT && x + width > WIDTH {
            (x, line) = (LEFT, line + 1);
        }
        let place = (x, line);
        x += width;
        place
    };
    curves.iter().map(place).collect()
}

fn legend_height(curves: &[Curve]) -> f64 {
    let lines = legend_places(curves).last().map_or(0, |(_, line)| line + 1);
    lines as f64 * LEGEND + 6.0
}

fn legend(svg: &mut String, unit: &str, curves: &[Curve], top: f64) {
    if !unit.is_empty() {
        let (x, y) = (coordinate(LEFT - 8.0), coordinate(top + LEGEND - 2.0));
        let _ = writeln!(svg, r#"<text x="{x}" y="{y}" text-anchor="end">{}</text>"#, escape(unit));
    }
    for (curve, (x, line)) in curves.iter().zip(legend_places(curves)) {
        let y = top + (line + 1) as f64 * LEGEND - 2.0;
        let _ = writeln!(
            svg,
            r#"<path d="M{} {}h22" stroke="{}" stroke-width="2"{}/><text x="{}" y="{}" font-family="monospace">{}</text>"#,
            coordinate(x),
            coordinate(y - 4.0),
            curve.color,
            dashes(curve),
            coordinate(x + 28.0),
            coordinate(y),
            escape(curve.name),
        );
    }
}

fn dashes(curve: &Curve) -> &'static str {
    if curve.is_input { r#" stroke-dasharray="5 3""# } else { "" }
}

fn panel(svg: &mut String, curves: &[Curve], recording: &Recording, time: &Scale, top: f64) {
    let scale = range(curves);
    for tick in scale.ticks(5.0) {
        let y = scale.y(tick, top);
        let _ = writeln!(
            svg,
            r##"<path d="M{LEFT} {y}H{right}" stroke="#e5e7eb"/><text x="{x}" y="{text_y}" text-anchor="end">{label}</text>"##,
            y = coordinate(y),
            right = WIDTH - RIGHT,
            x = LEFT - 8.0,
            text_y = coordinate(y + 4.0),
            label = tick_label(tick),
        );
    }
    verticals(svg, time, top, PANEL);
    for curve in curves {
        let _ = writeln!(
            svg,
            r#"<path d="{}" fill="none" stroke="{}" stroke-width="1.8"{}/>"#,
            stairs(&curve.values, recording, time, |value| scale.y(value, top)),
            curve.color,
            dashes(curve),
        );
    }
    let _ = writeln!(
        svg,
        r##"<rect x="{LEFT}" y="{}" width="{}" height="{PANEL}" fill="none" stroke="#9ca3af"/>"##,
        coordinate(top),
        WIDTH - LEFT - RIGHT,
    );
}

/// A Boolean: high where it is TRUE.
fn lane(svg: &mut String, curve: &Curve, recording: &Recording, time: &Scale, top: f64) {
    verticals(svg, time, top - 2.0, LANE + 4.0);
    let bottom = top + LANE;
    let y = |value: f64| if value == 0.0 { bottom } else { top };
    let line = stairs(&curve.values, recording, time, y);
    let (left, bottom) = (coordinate(time.x(0.0)), coordinate(bottom));
    let _ = writeln!(
        svg,
        r#"<path d="{line}V{bottom}H{left}Z" fill="{color}" fill-opacity="0.18"/><path d="{line}" fill="none" stroke="{color}" stroke-width="1.6"/><text x="{LEFT}" y="{y}" font-family="monospace" fill="{color}">{name}</text>"#,
        color = curve.color,
        name = escape(curve.name),
        y = coordinate(top - 3.0),
    );
}

/// A path that holds each value until the next call.
fn stairs(values: &[f64], recording: &Recording, time: &Scale, y: impl Fn(f64) -> f64) -> String {
    let mut path = String::new();
    let mut last = None;
    for (call, value) in values.iter().enumerate() {
        if !value.is_finite() {
            last = None;
            continue;
        }
        let (from, to) = (time.x(recording.time(call)), time.x(recording.time(call + 1)));
        let y = coordinate(y(*value));
        match &last {
            // The same value again makes the stair longer.
            Some(before) if *before == y => path.truncate(path.rfind('H').unwrap_or(path.len())),
            Some(_) => {
                let _ = write!(path, "V{y}");
            }
            None => {
                let _ = write!(path, "M{} {y}", coordinate(from));
            }
        }
        let _ = write!(path, "H{}", coordinate(to));
        last = Some(y);
    }
    path
}

fn verticals(svg: &mut String, time: &Scale, top: f64, height: f64) {
    for tick in time.ticks(8.0) {
        let (x, y) = (coordinate(time.x(tick)), coordinate(top));
        let _ = writeln!(svg, r##"<path d="M{x} {y}v{}" stroke="#e5e7eb"/>"##, coordinate(height));
    }
}

fn time_axis(svg: &mut String, time: &Scale, top: f64, has_no_panel: bool) {
    if has_no_panel {
        let _ = writeln!(svg, r##"<path d="M{LEFT} {}H{}" stroke="#9ca3af"/>"##, coordinate(top), WIDTH - RIGHT);
    }
    for tick in time.ticks(8.0) {
        let (x, y) = (coordinate(time.x(tick)), coordinate(top + 16.0));
        let _ = writeln!(svg, r#"<text x="{x}" y="{y}" text-anchor="middle">{}</text>"#, tick_label(tick));
    }
    let _ = writeln!(
        svg,
        r#"<text x="{}" y="{}" text-anchor="middle">time in s</text>"#,
        coordinate((LEFT + WIDTH - RIGHT) / 2.0),
        coordinate(top + 34.0),
    );
}

/// A round number without the digits that a double adds to it.
fn tick_label(tick: f64) -> String {
    let rounded: f64 = format!("{tick:.9e}").parse().unwrap_or(tick);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) { format!("{rounded:e}") } else { rounded.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let ticks = |from, to, count| Scale { from, to }.ticks(count);
        assert_eq!(ticks(0.0, 60.0, 8.0), [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
        assert_eq!(ticks(-0.6, 10.6, 5.0), [0.0, 5.0, 10.0]);
        assert_eq!(ticks(-2.0, 2.0, 4.0), [-2.0, -1.0, 0.0, 1.0, 2.0]);
        let labels: Vec<_> = ticks(0.0, 0.6, 6.0).into_iter().map(tick_label).collect();
        assert_eq!(labels, ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
    }

    #[test]
    fn a_long_legend_takes_several_lines() {
        let curve = || Curve { name: "A_LONG_NAME_OF_A_SIGNAL", color: INPUT, is_input: false, values: Vec::new() };
        let curves: Vec<Curve> = std::iter::repeat_with(curve).take(7).collect();
        let lines: Vec<usize> = legend_places(&curves).iter().map(|(_, line)| *line).collect();
        assert_eq!(lines, [0, 0, 0, 1, 1, 1, 2]);
        assert_eq!(legend_height(&curves), 60.0);
        assert!(legend_places(&curves).iter().all(|(x, _)| *x < WIDTH / 1.5));
    }

    #[test]
    fn a_panel_shows_all_finite_values() {
        let curve = |values: &[f64]| Curve { name: "X", color: INPUT, is_input: false, values: values.to_vec() };
        let scale = range(&[curve(&[1.0, f64::NAN]), curve(&[3.0, f64::INFINITY])]);
        assert!(scale.from < 1.0 && scale.from > 0.8 && scale.to > 3.0 && scale.to < 3.2);
        let scale = range(&[curve(&[0.0, 0.0])]);
        assert_eq!((scale.from, scale.to), (-0.5, 0.5));
        let scale = range(&[curve(&[f64::NAN])]);
        assert_eq!((scale.from, scale.to), (0.0, 1.0));
    }

    #[test]
    fn values_are_held_until_the_next_call() {
        let recording = Recording { cycle: 1000, shown: vec![0], restart: vec![0.0], calls: vec![vec![0.0]; 4] };
        let time = Scale { from: 0.0, to: 4.0 };
        let at = |seconds| coordinate(time.x(seconds));
        assert_eq!(
            stairs(&[1.0, 1.0, 2.0, 2.0], &recording, &time, |value| value),
            format!("M{} 1H{}V2H{}", at(0.0), at(2.0), at(4.0))
        );
        assert_eq!(
            stairs(&[1.0, f64::NAN, 2.0, 2.0], &recording, &time, |value| value),
            format!("M{} 1H{}M{} 2H{}", at(0.0), at(1.0), at(2.0), at(4.0))
        );
    }
}
