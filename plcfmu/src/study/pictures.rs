//! The pictures of a study: how a figure is distributed, over which coordinates, and the curves of single runs.
//!
//! The same results give the same bytes. However many runs there are, a picture stays small: points are put together in cells,
//! curves are thinned to what half a pixel can show.

use crate::page::plot::{self, Chart, Curve, Panel};
use crate::page::scale::{Scale, is_drawn, round_step, tick_label};
use crate::page::svg::Pixels;
use anyhow::{Context, Result};
use askama::Template;
use engine::digits::short;
use engine::run::Recording;
use engine::study::Signals;
use engine::study::expect::with_unit;
use engine::study::results::{Quantity, Results};
use engine::study::summary::{Distribution, Summary, percentile};
use std::fmt::Write;

// In pixels.
const WIDTH: f64 = 760.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 24.0;
const BOTTOM: f64 = 46.0;
const HISTOGRAM: (f64, f64) = (78.0, 230.0);
const SCATTER: (f64, f64) = (54.0, 360.0);
/// A row of texts.
const ROW: f64 = 15.0;

/// At most so many bars has a histogram.
const MOST_BARS: f64 = 80.0;

/// More points than these are put together in cells.
const MOST_POINTS: usize = 4000;
/// The width and the height of a cell.
const CELL: f64 = 6.0;
/// At most so many runs without the figure are marked.
const MOST_ABSENT: usize = 500;

/// The number of the colour of setpoints: black.
const SETPOINT: usize = 6;

/// From the best to the worst: from blue to vermilion, which people with a colour vision deficiency can tell apart.
const LEVELS: [&str; 7] = ["#0072b2", "#3c82ac", "#7292a5", "#a0a0a0", "#b28b6e", "#c4753d", "#d55e00"];

/// What both drawings have in common.
struct Frame {
    title: String,
    width: Pixels,
    height: Pixels,
    left: Pixels,
    right: Pixels,
    top: Pixels,
    bottom: Pixels,
    title_y: Pixels,
    label_x: Pixels,
    tick_x: Pixels,
    middle_x: Pixels,
    middle_y: Pixels,
    horizontal_y: Pixels,
    horizontal: String,
    vertical: String,
    rows: Vec<Tick>,
    columns: Vec<Tick>,
}

struct Tick {
    at: Pixels,
    text_y: Pixels,
    label: String,
}

struct Label {
    x: Pixels,
    text_x: Pixels,
    text_y: Pixels,
    anchor: &'static str,
    text: String,
}

/// Where values are in a drawing.
struct Place {
    horizontal: Scale,
    vertical: Scale,
    top: f64,
    height: f64,
}

impl Place {
    fn x(&self, value: f64) -> f64 {
        LEFT + self.horizontal.part(value) * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, value: f64) -> f64 {
        self.top + (1.0 - self.vertical.part(value)) * self.height
    }

    fn frame(&self, title: String, horizontal: String, vertical: String) -> Frame {
        let bottom = self.top + self.height;
        let row = |tick: f64| {
            let y = self.y(tick);
            Tick { at: Pixels(y), text_y: Pixels(y + 4.0), label: tick_label(tick) }
        };
        let column =
            |tick: f64| Tick { at: Pixels(self.x(tick)), text_y: Pixels(bottom + 16.0), label: tick_label(tick) };
        Frame {
            title,
            width: Pixels(WIDTH),
            height: Pixels(bottom + BOTTOM),
            left: Pixels(LEFT),
            right: Pixels(WIDTH - RIGHT),
            top: Pixels(self.top),
            bottom: Pixels(bottom),
            title_y: Pixels(18.0),
            label_x: Pixels(16.0),
            tick_x: Pixels(LEFT - 8.0),
            middle_x: Pixels((LEFT + WIDTH - RIGHT) / 2.0),
            middle_y: Pixels(self.top + self.height / 2.0),
            horizontal_y: Pixels(bottom + 36.0),
            horizontal,
            vertical,
            rows: self.vertical.ticks(6.0).into_iter().map(row).collect(),
            columns: self.horizontal.ticks(8.0).into_iter().map(column).collect(),
        }
    }
}

/// A quantity as the text of an axis: `settling in s`.
pub fn axis(of: &Quantity) -> String {
    match &of.unit {
        Some(unit) => format!("{} in {unit}", of.name),
        None => of.name.clone(),
    }
}

#[derive(Template)]
#[template(path = "histogram.svg")]
struct Histogram {
    frame: Frame,
    bars: String,
    marks: Vec<Label>,
}

/// How many runs have which value of a figure, with the percentiles 5, 50 and 95; none if no run has the figure.
///
/// The width of a bar is a round number: the next above 2 (p75 - p25) / n^(1/3) (Freedman and Diaconis), and more where
/// there would be over 80 bars.
///
/// # Errors
/// It cannot be drawn.
pub fn histogram(distribution: &Distribution, values: impl Iterator<Item = f64>) -> Result<Option<String>> {
    let mut values: Vec<f64> = values.filter(|value| is_drawn(*value)).collect();
    values.sort_unstable_by(f64::total_cmp);
    let Some(width) = bar_width(&values) else { return Ok(None) };
    let (first, last) = ((values[0] / width).floor(), (values[values.len() - 1] / width).floor());
    let mut counts = vec![0u64; (last - first) as usize + 1];
    for value in &values {
        counts[((value / width).floor() - first) as usize] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0);
    let place = Place {
        // A quarter of a bar on both sides.
        horizontal: Scale { from: (first - 0.25) * width, to: (last + 1.25) * width },
        vertical: Scale { from: 0.0, to: most as f64 * 1.05 },
        top: HISTOGRAM.0,
        height: HISTOGRAM.1,
    };
    let bottom = Pixels(place.y(0.0));
    let mut bars = String::new();
    for (bar, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let at = first + bar as f64;
        let (left, right) = (place.x(at * width) + 0.5, place.x((at + 1.0) * width) - 0.5);
        write!(bars, "M{} {bottom}V{}H{}V{bottom}Z", Pixels(left), Pixels(place.y(*count as f64)), Pixels(right))?;
    }
    let mark = |(row, percent): (usize, f64)| {
        let value = percentile(&values, percent)?;
        let x = place.x(value);
        let (anchor, text_x) = if x > WIDTH / 2.0 { ("end", x - 5.0) } else { ("start", x + 5.0) };
        let name = if percent == 50.0 { "median".into() } else { format!("{percent} %") };
        let text = format!("{name}: {}", with_unit(value, &distribution.figure));
        let text_y = Pixels(HISTOGRAM.0 - 6.0 - (2 - row) as f64 * ROW);
        Some(Label { x: Pixels(x), text_x: Pixels(text_x), text_y, anchor, text })
    };
    let marks = [5.0, 50.0, 95.0].into_iter().enumerate().filter_map(mark).collect();
    let title = match values.len() {
        1 => format!("{} of 1 run", distribution.figure.name),
        count => format!("{} of {count} runs", distribution.figure.name),
    };
    let mut frame = place.frame(title, axis(&distribution.figure), "runs".into());
    frame.rows.retain(|tick| !tick.label.contains('.'));
    Ok(Some(Histogram { frame, bars, marks }.render()?))
}

/// How wide the bars of a histogram are; none without values, which are in ascending order.
fn bar_width(values: &[f64]) -> Option<f64> {
    let (min, max) = (*values.first()?, *values.last()?);
    if min == max {
        return Some(round_step(if min == 0.0 { 1.0 } else { min.abs() / 20.0 }));
    }
    let quartiles = percentile(values, 75.0)? - percentile(values, 25.0)?;
    let rule = 2.0 * quartiles / (values.len() as f64).cbrt();
    // Where most values are equal, the rule says nothing.
    let rule = if rule > 0.0 { rule } else { (max - min) / 40.0 };
    let are_whole = values.iter().all(|value| value.fract() == 0.0);
    let least = if are_whole { 1.0 } else { 0.0 };
    Some(round_step(rule.max((max - min) / MOST_BARS).max(least)))
}

#[derive(Template)]
#[template(path = "scatter.svg")]
struct Scatter {
    frame: Frame,
    classes: Vec<Class>,
    is_binned: bool,
    diameter: Pixels,
    /// A path of crosses.
    absent: String,
    keys: Vec<Key>,
    key_y: Pixels,
    key_texts: Vec<Label>,
}

struct Class {
    number: usize,
    color: &'static str,
    path: String,
}

struct Key {
    number: usize,
    color: &'static str,
    x: Pixels,
    width: Pixels,
}

/// The runs over the two coordinates that correlate most with a figure, coloured by it; over one coordinate if there
/// is but one, with the figure as the height. None if nothing varies or no run has the figure.
///
/// The colours divide the range from the percentile 5 to the percentile 95 evenly. More than 4000 points are put together
/// in cells with the mean of their runs.
///
/// # Errors
/// It cannot be drawn.
pub fn scatter(results: &Results, summary: &Summary, figure: usize) -> Result<Option<String>> {
    let distribution = &summary.figures[figure];
    let of = &distribution.figure;
    let coordinates = summary.strongest(figure);
    let Some(&first) = coordinates.first() else { return Ok(None) };
    let value = |run: u64| results.figures_of(run)[figure];
    let mut values: Vec<f64> = results.figure(figure).filter(|value| is_drawn(*value)).collect();
    values.sort_unstable_by(f64::total_cmp);
    let (Some(low), Some(high)) = (percentile(&values, 5.0), percentile(&values, 95.0)) else { return Ok(None) };
    let at = |run: u64| {
        let point = results.point(run);
        (point[first], coordinates.get(1).map_or_else(|| value(run), |second| point[*second]))
    };
    let runs = || (0..results.count()).map(|run| (at(run), value(run)));
    let all = || runs().map(|(at, _)| at).filter(|(x, y)| is_drawn(*x) && is_drawn(*y));
    let place = Place {
        horizontal: Scale::around(all().map(|(x, _)| x)),
        vertical: Scale::around(all().map(|(_, y)| y)),
        top: SCATTER.0,
        height: SCATTER.1,
    };
    let points = runs().filter(|((x, y), value)| is_drawn(*x) && is_drawn(*y) && is_drawn(*value));
    let points: Vec<(f64, f64, f64)> = points.map(|((x, y), value)| (place.x(x), place.y(y), value)).collect();
    let is_binned = points.len() > MOST_POINTS;
    let level = |value: f64| {
        let part = if high > low { (value - low) / (high - low) } else { 0.5 };
        let part = if engine::study::summary::is_lower_better(&of.name) { part } else { 1.0 - part };
        ((part * LEVELS.len() as f64) as usize).min(LEVELS.len() - 1)
    };
    let mut paths = vec![String::new(); LEVELS.len()];
    if is_binned {
        for (x, y, value) in cells(&points, place.top) {
            let (x, y) = (Pixels(x), Pixels(y));
            write!(paths[level(value)], "M{x} {y}h{CELL}v{CELL}h-{CELL}z")?;
        }
    } else {
        for (x, y, value) in &points {
            write!(paths[level(*value)], "M{} {}h0", Pixels(*x), Pixels(*y))?;
        }
    }
    let class = |(level, path): (usize, String)| Class { number: level + 1, color: LEVELS[level], path };
    let classes = paths.into_iter().enumerate().filter(|(_, path)| !path.is_empty()).map(class).collect();
    let without = runs().filter(|((x, y), value)| is_drawn(*x) && is_drawn(*y) && !is_drawn(*value));
    let mut absent = String::new();
    for ((x, y), _) in without.take(MOST_ABSENT) {
        write!(absent, "M{} {}l6 6m0-6l-6 6", Pixels(place.x(x) - 3.0), Pixels(place.y(y) - 3.0))?;
    }
    let others = results.count() as usize - points.len();
    let (keys, key_texts) = keys(of, low, high, is_binned, if absent.is_empty() { 0 } else { others });
    let vertical = coordinates.get(1).map_or(of, |second| &results.coordinates[*second]);
    let title = format!("{} over {}", axis(of), coordinates_text(results, &coordinates));
    let frame = place.frame(title, axis(&results.coordinates[first]), axis(vertical));
    let diameter = Pixels(if points.len() > 500 { 4.0 } else { 7.0 });
    let drawing = Scatter { frame, classes, is_binned, diameter, absent, keys, key_y: Pixels(36.0), key_texts };
    Ok(Some(drawing.render()?))
}

fn coordinates_text(results: &Results, coordinates: &[usize]) -> String {
    let names: Vec<&str> = coordinates.iter().map(|of| results.coordinates[*of].name.as_str()).collect();
    names.join(" and ")
}

/// The cells with points: left, top and the mean of their values, column by column.
fn cells(points: &[(f64, f64, f64)], top: f64) -> Vec<(f64, f64, f64)> {
    let mut cells = std::collections::BTreeMap::<(i64, i64), (f64, f64)>::new();
    for (x, y, value) in points {
        let cell = (((x - LEFT) / CELL).floor() as i64, ((y - top) / CELL).floor() as i64);
        let (sum, count) = cells.entry(cell).or_default();
        (*sum, *count) = (*sum + value, *count + 1.0);
    }
    let place = |((column, row), (sum, count)): ((i64, i64), (f64, f64))| {
        (LEFT + column as f64 * CELL, top + row as f64 * CELL, sum / count)
    };
    cells.into_iter().map(place).collect()
}

/// The scale of the colours.
fn keys(of: &Quantity, low: f64, high: f64, is_binned: bool, absent: usize) -> (Vec<Key>, Vec<Label>) {
    let text =
        |x: f64, anchor, text: String| Label { x: Pixels(x), text_x: Pixels(x), text_y: Pixels(40.0), anchor, text };
    let is_lower_better = engine::study::summary::is_lower_better(&of.name);
    let (best, worst) = if is_lower_better { (low, high) } else { (high, low) };
    let (before, after) = if is_lower_better { ("≤", "≥") } else { ("≥", "≤") };
    let best = format!("{before} {}", short(best));
    let begin = LEFT + best.chars().count() as f64 * 7.0 + 8.0;
    let width = 26.0;
    let key = |level: usize| Key {
        number: level + 1,
        color: LEVELS[level],
        x: Pixels(begin + level as f64 * width),
        width: Pixels(width),
    };
    let mut end = format!("{after} {}", short(worst));
    if let Some(unit) = &of.unit {
        let _ = write!(end, " {unit}");
    }
    if is_binned {
        end.push_str("; a cell has the mean of its runs");
    }
    if absent > 0 {
        let runs = if absent == 1 { "run".into() } else { format!("{absent} runs") };
        let _ = write!(end, "; ×: {runs} without {}", of.name);
    }
    let texts = vec![text(LEFT, "start", best), text(begin + LEVELS.len() as f64 * width + 8.0, "start", end)];
    ((0..LEVELS.len()).map(key).collect(), texts)
}

/// The curves of some runs in one chart: what the figure is of above what the controller does. `runs` have a word each, such
/// as `worst`. None if nothing of the loop is recorded.
///
/// # Errors
/// It cannot be drawn.
pub fn curves(
    title: &str,
    signals: &Signals,
    figure: &Quantity,
    runs: &[(&str, u64, &Recording)],
) -> Result<Option<String>> {
    let Some((_, _, first)) = runs.first() else { return Ok(None) };
    let rows = runs.iter().map(|(_, _, recording)| recording.times.len()).min().unwrap_or(0);
    let column = |name: &str| first.columns.iter().position(|column| column.name == name);
    let values = |recording: &Recording, name: &str| -> Option<Vec<f64>> {
        let column = recording.columns.iter().position(|column| column.name == name)?;
        Some(recording.column(column).take(rows).collect())
    };
    let of_each = |name: &str| -> Vec<Curve> {
        let curve = |(place, (word, run, recording)): (usize, &(&str, u64, &Recording))| {
            let name_of_run = format!("{word}: run {run}");
            // A run has the same colour everywhere: vermilion, blue, green.
            let color = Some([1, 0, 2].get(place).copied().unwrap_or(place));
            Some(Curve { name: name_of_run, values: values(recording, name)?, is_input: false, color })
        };
        runs.iter().enumerate().filter_map(curve).collect()
    };
    let label = |name: &str| match column(name).and_then(|column| first.columns[column].unit.as_ref()) {
        Some(unit) => format!("{name} in {unit}"),
        None => name.to_string(),
    };
    let mut panels = Vec::new();
    if let Some(name) = &signals.process_value {
        let mut curves = of_each(name);
        if let Some(setpoint) = &signals.setpoint {
            let all: Vec<_> = runs.iter().filter_map(|(_, _, recording)| values(recording, setpoint)).collect();
            let are_equal = all.windows(2).all(|pair| pair[0] == pair[1]);
            let shown = if are_equal { 1 } else { all.len() };
            for (values, (word, ..)) in all.into_iter().zip(runs).take(shown) {
                let name = if are_equal { "setpoint".into() } else { format!("setpoint ({word})") };
                curves.push(Curve { name, values, is_input: true, color: Some(SETPOINT) });
            }
        }
        panels.push(Panel { label: label(name), curves });
    }
    let own = ["min", "max", "mean", "last", "violation"]
        .iter()
        .find_map(|of| figure.name.strip_suffix(of)?.strip_suffix('.'));
    let shown = |name: &&str| {
        Some(*name) != signals.process_value.as_deref() && Some(*name) != signals.manipulated_value.as_deref()
    };
    for name in own.filter(shown).into_iter().chain(signals.manipulated_value.as_deref()) {
        panels.push(Panel { label: label(name), curves: of_each(name) });
    }
    panels.retain(|panel| !panel.curves.is_empty());
    let is_pulsed = signals.manipulated_value.is_none();
    let pulses = signals.pulses.iter().flatten().filter(|_| is_pulsed);
    let lanes = pulses.flat_map(|name| {
        of_each(name).into_iter().map(move |curve| Curve { name: format!("{name}, {}", curve.name), ..curve })
    });
    let lanes: Vec<Curve> = lanes.collect();
    if panels.is_empty() && lanes.is_empty() {
        return Ok(None);
    }
    let chart = Chart { title: title.into(), time: first.times[..rows].to_vec(), over: None, panels, lanes };
    plot::svg(&chart).context("the curves cannot be drawn").map(Some)
}
