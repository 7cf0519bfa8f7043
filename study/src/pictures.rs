//! The pictures of a study: how a figure is distributed, over which coordinates, and the curves of single runs.
//!
//! The same results give the same bytes. However many runs there are, a picture stays small: points are put together in cells,
//! curves are thinned to what half a pixel can show.

use crate::Signals;
use crate::expect::{runs_text, with_unit};
use crate::results::{Quantity, Results};
use crate::summary::{Distribution, Summary, is_lower_better, percentile};
use anyhow::{Context, Result};
use askama::Template;
use draw::plot::{self, Chart, Curve, Panel};
use draw::scale::{Scale, is_drawn, round_step, tick_label};
use draw::svg::Pixels;
use modeldescription::digits::short;
use run::master::Recording;
use std::collections::BTreeMap;
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

/// A scale, of the values or of their logarithms.
struct Axis {
    scale: Scale,
    is_logarithmic: bool,
}

impl Axis {
    /// All values, with some room. Logarithms are of values above 0.
    fn around(values: impl Iterator<Item = f64> + Clone, is_logarithmic: bool) -> Axis {
        let is_logarithmic = is_logarithmic && values.clone().all(|value| value > 0.0);
        let scale = Scale::around(values.map(|value| if is_logarithmic { value.log10() } else { value }));
        Axis { scale, is_logarithmic }
    }

    fn part(&self, value: f64) -> f64 {
        self.scale.part(if self.is_logarithmic { value.log10() } else { value })
    }

    /// Round numbers within, about `count` of them; of logarithms 1, 2, 5, 10 and so on.
    fn ticks(&self, count: f64) -> Vec<f64> {
        if !self.is_logarithmic {
            return self.scale.ticks(count);
        }
        let decades = self.scale.from.floor() as i32..=self.scale.to.ceil() as i32;
        let are_few = self.scale.to - self.scale.from <= 4.0;
        let factors: &[f64] = if are_few { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let all = decades.flat_map(|decade| factors.iter().map(move |factor| factor * 10f64.powi(decade)));
        all.filter(|tick| (0.0..=1.0).contains(&self.part(*tick))).collect()
    }
}

impl From<Scale> for Axis {
    fn from(scale: Scale) -> Axis {
        Axis { scale, is_logarithmic: false }
    }
}

/// Where values are in a drawing.
struct Place {
    horizontal: Axis,
    vertical: Axis,
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
        horizontal: Scale { from: (first - 0.25) * width, to: (last + 1.25) * width }.into(),
        vertical: Scale { from: 0.0, to: most as f64 * 1.05 }.into(),
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
    let title = format!("{} of {}", distribution.figure.name, runs_text(values.len() as u64));
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
    /// Cells in place of points.
    has_cells: bool,
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
/// is but one, with the figure as the height. None if nothing varies or no run has the figure. `logarithmic` says of
/// each coordinate whether its axis shows logarithms.
///
/// The colours divide the range from the percentile 5 to the percentile 95 evenly. Runs at the same place are one point with
/// their mean; a grid is drawn in cells, and more than 4000 points are put together in cells.
///
/// # Errors
/// It cannot be drawn.
pub fn scatter(results: &Results, summary: &Summary, figure: usize, logarithmic: &[bool]) -> Result<Option<String>> {
    let of = &summary.figures[figure].figure;
    let coordinates = summary.strongest(figure);
    let Some(&first) = coordinates.first() else { return Ok(None) };
    let second = coordinates.get(1).copied();
    let value = |run: u64| results.figures_of(run)[figure];
    let mut values: Vec<f64> = results.figure(figure).filter(|value| is_drawn(*value)).collect();
    values.sort_unstable_by(f64::total_cmp);
    let (Some(low), Some(high)) = (percentile(&values, 5.0), percentile(&values, 95.0)) else { return Ok(None) };
    let at = |run: u64| {
        let point = results.point(run);
        (point[first], second.map_or_else(|| value(run), |second| point[second]))
    };
    let runs = (0..results.count()).map(|run| (at(run), value(run)));
    let runs = runs.filter(|((x, y), _)| is_drawn(*x) && is_drawn(*y));
    let is_logarithmic = |coordinate: usize| logarithmic.get(coordinate).copied().unwrap_or(false);
    let place = Place {
        horizontal: Axis::around(runs.clone().map(|((x, _), _)| x), is_logarithmic(first)),
        vertical: Axis::around(runs.clone().map(|((_, y), _)| y), second.is_some_and(is_logarithmic)),
        top: SCATTER.0,
        height: SCATTER.1,
    };
    let points = runs.clone().filter(|(_, value)| is_drawn(*value));
    let points: Vec<(f64, f64, f64)> = points.map(|((x, y), value)| (place.x(x), place.y(y), value)).collect();
    let mut drawn = cells(&points, 0.01, place.top);
    let is_binned = drawn.len() > MOST_POINTS;
    let size = if is_binned { Some((CELL, CELL)) } else { pitch(&drawn) };
    if is_binned {
        drawn = cells(&points, CELL, place.top);
        drawn.iter_mut().for_each(|(x, y, _)| (*x, *y) = (*x + CELL / 2.0, *y + CELL / 2.0));
    }
    let level = |value: f64| {
        let part = if high > low { (value - low) / (high - low) } else { 0.5 };
        let part = if is_lower_better(&of.name) { part } else { 1.0 - part };
        ((part * LEVELS.len() as f64) as usize).min(LEVELS.len() - 1)
    };
    let mut paths = vec![String::new(); LEVELS.len()];
    for (x, y, value) in &drawn {
        let path = &mut paths[level(*value)];
        match size {
            Some((width, height)) => {
                let (left, top) = (Pixels(x - width / 2.0), Pixels(y - height / 2.0));
                let (width, height) = (Pixels(width), Pixels(height));
                write!(path, "M{left} {top}h{width}v{height}h-{width}z")?;
            }
            None => write!(path, "M{} {}h0", Pixels(*x), Pixels(*y))?,
        }
    }
    let class = |(level, path): (usize, String)| Class { number: level + 1, color: LEVELS[level], path };
    let classes = paths.into_iter().enumerate().filter(|(_, path)| !path.is_empty()).map(class).collect();
    let without = runs.filter(|(_, value)| !is_drawn(*value));
    let mut absent = String::new();
    for ((x, y), _) in without.clone().take(MOST_ABSENT) {
        write!(absent, "M{} {}l6 6m0-6l-6 6", Pixels(place.x(x) - 3.0), Pixels(place.y(y) - 3.0))?;
    }
    let mean_of = (drawn.len() < points.len()).then_some(if size.is_some() { "a cell" } else { "a point" });
    let (keys, key_texts) = keys(of, low, high, mean_of, without.count());
    let vertical = second.map_or(of, |second| &results.coordinates[second]);
    let title = format!("{} over {}", axis(of), coordinates_text(results, &coordinates));
    let frame = place.frame(title, axis(&results.coordinates[first]), axis(vertical));
    let diameter = Pixels(if drawn.len() > 500 { 5.0 } else { 8.0 });
    let drawing =
        Scatter { frame, classes, has_cells: size.is_some(), diameter, absent, keys, key_y: Pixels(36.0), key_texts };
    Ok(Some(drawing.render()?))
}

fn coordinates_text(results: &Results, coordinates: &[usize]) -> String {
    let names: Vec<&str> = coordinates.iter().map(|of| results.coordinates[*of].name.as_str()).collect();
    names.join(" and ")
}

/// The cells of this size that have points: left, top and the mean of their values, column by column.
fn cells(points: &[(f64, f64, f64)], size: f64, top: f64) -> Vec<(f64, f64, f64)> {
    let mut cells = BTreeMap::<(i64, i64), (f64, f64)>::new();
    for (x, y, value) in points {
        let cell = (((x - LEFT) / size).floor() as i64, ((y - top) / size).floor() as i64);
        let (sum, count) = cells.entry(cell).or_default();
        (*sum, *count) = (*sum + value, *count + 1.0);
    }
    let place = |((column, row), (sum, count)): ((i64, i64), (f64, f64))| {
        (LEFT + column as f64 * size, top + row as f64 * size, sum / count)
    };
    cells.into_iter().map(place).collect()
}

/// The size of the cells of a grid with a point at each place; none if the points are no such grid, or too close.
fn pitch(points: &[(f64, f64, f64)]) -> Option<(f64, f64)> {
    let along = |place: fn(&(f64, f64, f64)) -> f64| {
        let mut places: Vec<f64> = points.iter().map(place).collect();
        places.sort_unstable_by(f64::total_cmp);
        places.dedup();
        let least = places.windows(2).map(|pair| pair[1] - pair[0]).reduce(f64::min);
        (places.len(), least.filter(|pitch| *pitch >= CELL))
    };
    let ((columns, width), (rows, height)) = (along(|point| point.0), along(|point| point.1));
    (columns * rows == points.len()).then_some(())?;
    Some((width?, height?))
}

/// The scale of the colours, and what the marks are.
fn keys(of: &Quantity, low: f64, high: f64, mean_of: Option<&str>, absent: usize) -> (Vec<Key>, Vec<Label>) {
    let label =
        |x: f64, text: String| Label { x: Pixels(x), text_x: Pixels(x), text_y: Pixels(40.0), anchor: "start", text };
    let (best, worst) = if is_lower_better(&of.name) {
        (format!("≤ {}", short(low)), format!("≥ {}", with_unit(high, of)))
    } else {
        (format!("≥ {}", short(high)), format!("≤ {}", with_unit(low, of)))
    };
    let (begin, width) = (LEFT + best.chars().count() as f64 * 7.0 + 8.0, 26.0);
    let key = |level: usize| Key {
        number: level + 1,
        color: LEVELS[level],
        x: Pixels(begin + level as f64 * width),
        width: Pixels(width),
    };
    let mut end = worst;
    if let Some(mark) = mean_of {
        let _ = write!(end, "; {mark} has the mean of its runs");
    }
    if absent > 0 {
        let _ = write!(end, "; ×: {} without {}", runs_text(absent as u64), of.name);
    }
    let texts = vec![label(LEFT, best), label(begin + LEVELS.len() as f64 * width + 8.0, end)];
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::recording;
    use crate::results::Row;

    fn quantity(name: &str) -> Quantity {
        Quantity { name: name.into(), unit: Some("s".into()) }
    }

    /// Results over `width` coordinates, which are those of a spiral.
    fn results(width: usize, values: &[f64]) -> Results {
        let coordinates = ["P.A", "P.B", "P.C"].map(quantity)[..width].to_vec();
        let mut results = Results::new(coordinates, vec![quantity("settling")]);
        for (run, value) in values.iter().enumerate() {
            let (along, angle) = (run as f64 / values.len() as f64, run as f64 * 2.4);
            let point = [along * angle.cos(), along * angle.sin(), 1.0];
            results.push(&point[..width], &Row { figures: vec![*value], error: None });
        }
        results
    }

    fn of(values: &[f64]) -> Option<String> {
        let results = results(0, values);
        histogram(&Summary::of(&results, 1).figures[0], results.figure(0)).unwrap()
    }

    #[test]
    fn the_bars_of_a_histogram_have_a_round_width_and_hold_all_runs() {
        // Quartiles 24.75 and 74.25: 2 * 49.5 / 100^(1/3) = 21.3.
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(bar_width(&values), Some(50.0));
        // An outlier does not make thousands of bars.
        let outlier: Vec<f64> = values.iter().copied().chain([1e6]).collect();
        assert_eq!(bar_width(&outlier), Some(20_000.0));
        // Whole numbers are not divided; where most are equal there are forty bars.
        assert_eq!(bar_width(&[1.0, 1.0, 2.0, 2.0, 3.0]), Some(2.0));
        let mut mostly = vec![0.0; 99];
        mostly.push(0.5);
        assert_eq!(bar_width(&mostly), Some(0.02));
        assert_eq!((bar_width(&[5.0]), bar_width(&[0.0; 3]), bar_width(&[])), (Some(0.5), Some(1.0), None));
    }

    #[test]
    fn a_histogram_marks_its_percentiles_and_names_its_axes() {
        let drawing = of(&(0..=100).map(f64::from).collect::<Vec<_>>()).unwrap();
        for text in ["settling of 101 runs", "settling in s", "runs", "5 %: 5 s", "median: 50 s", "95 %: 95 s"] {
            assert!(drawing.contains(&format!(">{text}</text>")), "{text}");
        }
        assert_eq!(of(&[f64::NAN]), None);
    }

    #[test]
    fn any_values_give_a_histogram_without_a_number_that_is_none() {
        for values in [&[f64::NAN, 3.0, f64::INFINITY][..], &[0.0], &[-5.0; 9], &[1e300, -1e300], &[5e-324, 1.0]] {
            let drawing = of(values).unwrap();
            assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{values:?}");
            resvg::usvg::roxmltree::Document::parse(&drawing).unwrap();
        }
    }

    #[test]
    fn few_runs_are_points_and_many_are_cells_of_a_small_file() {
        let draw = |count: usize| {
            let values: Vec<f64> = (0..count).map(|run| run as f64).collect();
            let results = results(2, &values);
            scatter(&results, &Summary::of(&results, 1), 0, &[]).unwrap().unwrap()
        };
        let few = draw(1000);
        assert_eq!(few.matches("h0").count(), 1000);
        let many = draw(100_000);
        assert!(many.len() < 300_000, "{}", many.len());
        assert!(many.contains("a cell has the mean of its runs") && !few.contains("a cell"));
        assert_eq!(many, draw(100_000));
    }

    #[test]
    fn a_scatter_plot_marks_runs_without_the_figure() {
        let results = results(3, &[1.0, f64::NAN, 3.0, 5.0]);
        let drawing = scatter(&results, &Summary::of(&results, 1), 0, &[]).unwrap().unwrap();
        assert!(drawing.contains("×: 1 run without settling"), "{drawing}");
        for text in ["settling in s over P.A and P.B", "P.A in s", "P.B in s"] {
            assert!(drawing.contains(&format!(">{text}</text>")), "{text}");
        }
    }

    #[test]
    fn a_grid_is_drawn_in_cells() {
        let mut results = Results::new(vec![quantity("P.A"), quantity("P.B")], vec![quantity("settling")]);
        for run in 0..12_u32 {
            let point = [f64::from(run / 4), f64::from(run % 4)];
            results.push(&point, &Row { figures: vec![f64::from(run)], error: None });
        }
        let drawing = scatter(&results, &Summary::of(&results, 1), 0, &[]).unwrap().unwrap();
        assert_eq!((drawing.matches("h0").count(), drawing.matches("h-").count()), (0, 12));
        assert!(!drawing.contains("mean of its runs"));
    }

    #[test]
    fn runs_at_the_same_place_are_one_point_and_a_logarithmic_axis_has_round_ticks() {
        let mut results = Results::new(vec![quantity("P.A"), quantity("P.B")], vec![quantity("settling")]);
        for (run, value) in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].into_iter().enumerate() {
            let point = [10f64.powi(run as i32 % 3), f64::from(run as u32 % 3)];
            results.push(&point, &Row { figures: vec![value], error: None });
        }
        let drawing = scatter(&results, &Summary::of(&results, 1), 0, &[true, false]).unwrap().unwrap();
        assert_eq!(drawing.matches("h0").count(), 3);
        assert!(drawing.contains("a point has the mean of its runs"));
        for tick in ["1", "2", "5", "10", "20", "50", "100"] {
            assert!(drawing.contains(&format!("text-anchor=\"middle\">{tick}</text>")), "{tick}");
        }
    }

    #[test]
    fn over_one_coordinate_the_figure_is_the_height() {
        let draw = |width| {
            let results = results(width, &[1.0, 2.0, 4.0]);
            scatter(&results, &Summary::of(&results, 1), 0, &[]).unwrap()
        };
        let one = draw(1).unwrap();
        assert!(one.contains(">P.A in s</text>") && one.contains(">settling in s</text>"));
        assert_eq!(draw(0), None);
    }

    #[test]
    fn the_curves_of_runs_share_axes_and_the_setpoint_is_drawn_once() {
        let signals = Signals {
            setpoint: Some("PID.SP".into()),
            process_value: Some("HEATER.TEMP".into()),
            manipulated_value: Some("PID.LMN".into()),
            pulses: None,
        };
        let (worst, best) = (recording(80.0), recording(60.0));
        let runs = [("worst", 7, &worst), ("best", 2, &best)];
        let drawing = curves("Runs", &signals, &quantity("iae"), &runs).unwrap().unwrap();
        for (text, count) in
            [("worst: run 7", 2), ("best: run 2", 2), ("setpoint", 1), ("HEATER.TEMP in °C", 1), ("PID.LMN in %", 1)]
        {
            assert_eq!(drawing.matches(&format!(">{text}</text>")).count(), count, "{text}");
        }
        // A run has one colour: a line in the legend and one in the panel, twice.
        assert_eq!(drawing.matches("class=\"curve-2\"").count(), 4);
        assert_eq!(curves("Runs", &Signals::default(), &quantity("iae"), &runs).unwrap(), None);
        let drawing = curves("Runs", &Signals::default(), &quantity("HEATER.TEMP.max"), &runs).unwrap().unwrap();
        assert!(drawing.contains(">HEATER.TEMP in °C</text>"));
    }
}
