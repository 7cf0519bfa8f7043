//! Charts of signals over time: numbers with the same unit share a panel, and each Boolean has its own lane. Values are
//! held from point to point, so curves have steps. Characteristics are drawn as functions of a variable, with straight
//! lines from point to point.
//!
//! The crate `plotters` is not used: it rounds to whole pixels, writes every dash as a separate element, and assigns
//! curves no class with which a page could recolour them in dark mode.

use crate::palette;
use crate::scale::{Scale, is_drawn, tick_label};
use crate::svg::Pixels;
use anyhow::bail;
use askama::Template;
use modeldescription::units;
use std::fmt::Write;

// Lengths in pixels.
const WIDTH: f64 = 760.0;
/// The width of a narrow chart. A phone shows it at three quarters of this width, at which the numbers on the axes are
/// still legible.
const NARROW: f64 = 500.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 24.0;
const TITLE: f64 = 26.0;
const PANEL: f64 = 190.0;
const PANEL_GAP: f64 = 8.0;
/// The height of a line in a legend.
const LEGEND: f64 = 18.0;
/// The length of a curve's sample in a legend.
const SAMPLE: f64 = 22.0;
const LANE: f64 = 15.0;
const LANE_GAP: f64 = 21.0;
const BOTTOM: f64 = 42.0;

/// The colours of curves, in order.
const COLORS: [&str; 7] = [
    palette::PROCESS_VALUE,
    palette::MANIPULATED_VALUE,
    palette::color("curve-3"),
    palette::color("curve-4"),
    palette::color("curve-5"),
    palette::color("curve-6"),
    palette::INK,
];

/// The number of colours; additional curves reuse them with dotted lines.
pub const COLOR_COUNT: usize = COLORS.len();

/// The class names by which a page's style sheet can change the colours, in the order of [`COLORS`].
const CLASSES: &[&str] = &["curve-1", "curve-2", "curve-3", "curve-4", "curve-5", "curve-6", "curve-7"];

/// A chart: panels with numeric curves above lanes with Booleans, over a common time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// The title above the drawing; may be empty.
    pub title: String,
    /// The times of the points in seconds, in ascending order; the last one ends the drawing.
    pub time: Vec<f64>,
    /// The name and unit of the horizontal variable, if `time` holds values of a variable instead of times. Curves then
    /// have straight lines from point to point.
    pub over: Option<String>,
    /// The label of the time axis; by default `time in s`.
    pub time_label: Option<String>,
    /// The panels, from top to bottom.
    pub panels: Vec<Panel>,
    /// The Boolean curves: 0 is FALSE, anything else TRUE.
    pub lanes: Vec<Curve>,
    /// The relevant time window; everything outside it is shaded.
    pub window: Option<(f64, f64)>,
    /// Whether points are drawn as unconnected dots, because there are no values between them.
    pub has_dots: bool,
    /// Whether the drawing must fit the width of a phone.
    pub is_narrow: bool,
}

impl Chart {
    fn width(&self) -> f64 {
        if self.is_narrow { NARROW } else { WIDTH }
    }
}

/// Curves that share an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// The label of the axis: a unit, or the names of the curves; may be empty.
    pub label: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// The bands behind the curves.
    pub bands: Vec<Band>,
}

/// The label beside a panel: names and unit, or only the unit if the names do not fit. If the names do not fit and
/// there is no unit, only the first name is shown, followed by an ellipsis.
pub fn axis_label(names: &[&str], unit: Option<&str>) -> String {
    let all = names.join(", ");
    let long = unit.map_or_else(|| all.clone(), |unit| format!("{all} in {unit}"));
    match (unit, names) {
        _ if long.chars().count() <= LONGEST_LABEL => long,
        (Some(unit), _) => unit.to_string(),
        (None, [first, _, ..]) => format!("{first}, ..."),
        (None, _) => all,
    }
}

/// The maximum length of a label beside a panel, in characters.
const LONGEST_LABEL: usize = 28;

/// A band between two curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Its name in the legend.
    pub name: String,
    /// The times of its points in seconds, in ascending order.
    pub times: Vec<f64>,
    /// The lower bound at each point.
    pub low: Vec<f64>,
    /// The upper bound at each point.
    pub high: Vec<f64>,
    /// The 0-based index of its colour.
    pub color: usize,
}

/// A curve of a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its name in the drawing.
    pub name: String,
    /// The value at each point in time, held until the next one. A value that is not finite leaves a gap.
    pub values: Vec<f64>,
    /// Whether it is an input, which is drawn as a dashed line.
    pub is_input: bool,
    /// The 0-based index of its colour, if it is fixed, such as for curves that share one; by default, the next colour.
    pub color: Option<usize>,
}

/// Renders the chart as SVG, with identical bytes on every machine: fonts are not measured.
///
/// # Errors
/// The time decreases or is not finite, or a curve does not have one value per point.
pub fn svg(chart: &Chart) -> anyhow::Result<String> {
    svg_named(chart, &chart.title)
}

/// Like [`svg`], with a separate accessible name, for a page whose text already contains the title.
///
/// # Errors
/// As for [`svg`].
pub fn svg_named(chart: &Chart, name: &str) -> anyhow::Result<String> {
    check(chart)?;
    let width = chart.width();
    let time = Across { scale: Scale::of_time(&chart.time), right: width - RIGHT };
    let mut pens = pens();
    let mut top = if chart.title.is_empty() { 0.0 } else { TITLE };
    let mut panels = Vec::new();
    for panel in &chart.panels {
        let pens: Vec<Pen> = panel.curves.iter().map(&mut pens).collect();
        if !panels.is_empty() {
            top += PANEL_GAP;
        }
        let legend_top = top;
        top += legend_height(panel, width);
        panels.push(draw_panel(panel, &pens, chart, &time, legend_top, top));
        top += PANEL;
    }
    let mut lanes = Vec::new();
    if !panels.is_empty() && !chart.lanes.is_empty() {
        top += PANEL_GAP;
    }
    for lane in &chart.lanes {
        top += LANE_GAP;
        lanes.push(draw_lane(lane, pens(lane), &chart.time, &time, top));
        top += LANE;
    }
    if !lanes.is_empty() {
        top += LANE_GAP / 2.0;
    }
    let times = time.scale.ticks_to_the_ends(if chart.is_narrow { 6.0 } else { 8.0 }).into_iter().map(|tick| Tick {
        at: Pixels(time.x(tick)),
        text_y: Pixels(top + 16.0),
        label: tick_label(tick),
    });
    let shade = |(from, to): (f64, f64)| {
        // A window end outside the time range leaves nothing to shade on that side.
        let [from, to] = [from, to].map(|at| Pixels(time.x(at.clamp(time.scale.from, time.scale.to))));
        let (left, right) = (Pixels(LEFT), Pixels(time.right));
        let drawn = |panel: &DrawnPanel| {
            let (top, bottom) = (panel.top, Pixels(panel.top.0 + PANEL));
            format!("M{left} {top}H{from}V{bottom}H{left}zM{to} {top}H{right}V{bottom}H{to}z")
        };
        panels.iter().map(drawn).collect::<String>()
    };
    let shade = chart.window.map(shade).unwrap_or_default();
    let drawing = Drawing {
        shade,
        name,
        title: &chart.title,
        title_y: Pixels(17.0),
        width: Pixels(width),
        height: Pixels(top + BOTTOM),
        left: Pixels(LEFT),
        right: Pixels(time.right),
        middle: Pixels((LEFT + time.right) / 2.0),
        plot_width: Pixels(time.right - LEFT),
        panel_height: Pixels(PANEL),
        lane_grid: Pixels(LANE + 4.0),
        sample: Pixels(SAMPLE),
        label_x: Pixels(16.0),
        tick_x: Pixels(LEFT - 8.0),
        axis: Pixels(top),
        time_y: Pixels(top + 34.0),
        over: chart.over.as_deref().or(chart.time_label.as_deref()).unwrap_or("time in s"),
        times: times.collect(),
        panels,
        lanes,
    };
    Ok(drawing.render()?)
}

fn check(chart: &Chart) -> anyhow::Result<()> {
    if let Some(point) = chart.time.iter().find(|time| !is_drawn(**time)) {
        bail!("the chart's time has the value {point}; every time must be a finite number");
    }
    if let Some(pair) = chart.time.windows(2).find(|pair| pair[0] > pair[1]) {
        bail!("the chart's time decreases from {} s to {} s; it must not decrease", pair[0], pair[1]);
    }
    let points = chart.time.len();
    for curve in chart.panels.iter().flat_map(|panel| &panel.curves).chain(&chart.lanes) {
        if curve.values.len() != points {
            bail!(
                "{} has {} values for {points} points in time; it must have one per point",
                curve.name,
                curve.values.len()
            );
        }
    }
    Ok(())
}

/// The values for the template.
#[derive(Template)]
#[template(path = "chart.svg")]
struct Drawing<'a> {
    name: &'a str,
    title: &'a str,
    title_y: Pixels,
    width: Pixels,
    height: Pixels,
    left: Pixels,
    right: Pixels,
    middle: Pixels,
    plot_width: Pixels,
    panel_height: Pixels,
    lane_grid: Pixels,
    sample: Pixels,
    /// The horizontal middle of the axis labels.
    label_x: Pixels,
    /// The right end of the tick labels.
    tick_x: Pixels,
    /// The vertical position of the time axis.
    axis: Pixels,
    time_y: Pixels,
    /// The quantity on the horizontal axis.
    over: &'a str,
    times: Vec<Tick>,
    panels: Vec<DrawnPanel<'a>>,
    lanes: Vec<DrawnLane<'a>>,
    /// The path of the area outside the window.
    shade: String,
}

struct DrawnPanel<'a> {
    label: String,
    top: Pixels,
    middle: Pixels,
    legend: Vec<LegendEntry<'a>>,
    ticks: Vec<Tick>,
    bands: Vec<DrawnCurve>,
    curves: Vec<DrawnCurve>,
    dots: Vec<DrawnCurve>,
}

struct LegendEntry<'a> {
    name: &'a str,
    pen: Pen,
    is_band: bool,
    x: Pixels,
    line_y: Pixels,
    text_x: Pixels,
    text_y: Pixels,
}

struct DrawnLane<'a> {
    name: &'a str,
    name_y: Pixels,
    grid_top: Pixels,
    curve: DrawnCurve,
    /// The paths of the areas between the line and FALSE.
    areas: Vec<String>,
}

struct DrawnCurve {
    pen: Pen,
    path: String,
}

struct Tick {
    at: Pixels,
    text_y: Pixels,
    label: String,
}

/// The style of a curve.
#[derive(Clone, Copy)]
struct Pen {
    class: &'static str,
    color: &'static str,
    dashes: Option<&'static str>,
}

/// Returns a function that assigns styles to successive curves; a curve with a fixed colour keeps it. When the colours
/// repeat, the lines are dotted.
fn pens() -> impl FnMut(&Curve) -> Pen {
    let mut taken = 0;
    move |curve| {
        let number = curve.color.unwrap_or(taken);
        if curve.color.is_none() {
            taken += 1;
        }
        pen_of(number, curve.is_input)
    }
}

/// The style with this index; from [`COLOR_COUNT`] onward, the colours repeat with dotted lines.
fn pen_of(number: usize, is_input: bool) -> Pen {
    let color = number % COLORS.len();
    let dashes = match (is_input, number >= COLORS.len()) {
        (true, false) => Some("6 3"),
        (true, true) => Some("6 3 1.5 3"),
        (false, true) => Some("1.5 1.5"),
        (false, false) => None,
    };
    Pen { class: CLASSES[color], color: COLORS[color], dashes }
}

fn draw_panel<'a>(
    panel: &'a Panel,
    pens: &[Pen],
    chart: &Chart,
    time: &Across,
    legend_top: f64,
    top: f64,
) -> DrawnPanel<'a> {
    let scale = range(panel);
    let band_pen = |band: &Band| pen_of(band.color, false);
    let all_pens = pens.iter().copied().chain(panel.bands.iter().map(band_pen));
    let legend = names(panel).zip(all_pens).zip(legend_places(panel, chart.width())).enumerate();
    let legend = legend.map(|(place, ((name, pen), (x, line)))| {
        let y = legend_top + (line + 1) as f64 * LEGEND - 2.0;
        LegendEntry {
            name,
            pen,
            is_band: place >= panel.curves.len(),
            x: Pixels(x),
            line_y: Pixels(y - 4.0),
            text_x: Pixels(x + SAMPLE + 6.0),
            text_y: Pixels(y),
        }
    });
    let ticks = values_ticks(panel, &scale).into_iter().map(|tick| {
        let y = scale.y(tick, top);
        Tick { at: Pixels(y), text_y: Pixels(y + 4.0), label: tick_label(tick) }
    });
    let path = if chart.over.is_some() { lines } else { stairs };
    // Dashed lines are drawn last: a solid one on top would hide them.
    let solid = panel.curves.iter().zip(pens).filter(|(curve, _)| !curve.is_input);
    let joined =
        solid.chain(panel.curves.iter().zip(pens).filter(|(curve, _)| curve.is_input)).filter(|_| !chart.has_dots);
    let curves = joined.map(|(curve, pen)| DrawnCurve {
        pen: *pen,
        path: path(&points(&chart.time, &curve.values, time), time, &|value| scale.y(value, top)),
    });
    let bands = panel.bands.iter().map(|band| {
        let line = |values: &[f64]| -> Vec<String> {
            let points = band.times.iter().zip(values).filter(|(_, value)| is_drawn(**value));
            points.map(|(at, value)| format!("{} {}", Pixels(time.x(*at)), Pixels(scale.y(*value, top)))).collect()
        };
        let (there, mut back) = (line(&band.low), line(&band.high));
        back.reverse();
        let path = if there.is_empty() { String::new() } else { format!("M{}L{}z", there.join("L"), back.join("L")) };
        DrawnCurve { pen: band_pen(band), path }
    });
    let dots = panel.curves.iter().zip(pens).filter(|_| chart.has_dots).map(|(curve, pen)| {
        let points = chart.time.iter().zip(&curve.values).filter(|(_, value)| is_drawn(**value));
        let path = points.map(|(at, value)| format!("M{} {}h0", Pixels(time.x(*at)), Pixels(scale.y(*value, top))));
        DrawnCurve { pen: *pen, path: path.collect() }
    });
    DrawnPanel {
        label: units::shown(&panel.label),
        top: Pixels(top),
        middle: Pixels(top + PANEL / 2.0),
        legend: legend.collect(),
        ticks: ticks.collect(),
        bands: bands.collect(),
        curves: curves.collect(),
        dots: dots.collect(),
    }
}

/// Draws a Boolean: high where it is TRUE.
fn draw_lane<'a>(lane: &'a Curve, pen: Pen, times: &[f64], time: &Across, top: f64) -> DrawnLane<'a> {
    let bottom = top + LANE;
    let points = points(times, &lane.values, time);
    let path = stairs(&points, time, &|value| if value == 0.0 { bottom } else { top });
    // A gap in the line ends an area.
    let area = |line: &str| {
        let start = line.split(' ').next().unwrap_or_default();
        format!("M{line}V{}H{start}Z", Pixels(bottom))
    };
    let areas = path.split('M').filter(|line| line.contains('H')).map(area).collect();
    DrawnLane {
        name: &lane.name,
        // Leave room below the name: an underscore extends four pixels below the baseline.
        name_y: Pixels(top - 6.5),
        grid_top: Pixels(top - 2.0),
        curve: DrawnCurve { pen, path },
        areas,
    }
}

impl Scale {
    /// The whole time range; one second if it is empty.
    fn of_time(times: &[f64]) -> Scale {
        match (times.first(), times.last()) {
            (Some(from), Some(to)) if from < to => Scale { from: *from, to: *to },
            (Some(from), _) => Scale { from: *from, to: from + 1.0 },
            _ => Scale { from: 0.0, to: 1.0 },
        }
    }

    /// The vertical position of a value in a panel.
    fn y(&self, value: f64, top: f64) -> f64 {
        top + PANEL - self.part(value) * PANEL
    }
}

/// The horizontal axis.
struct Across {
    scale: Scale,
    /// The right end in pixels.
    right: f64,
}

impl Across {
    /// The horizontal position of a time.
    fn x(&self, time: f64) -> f64 {
        LEFT + self.scale.part(time) * (self.right - LEFT)
    }
}

/// The range of a panel: all drawable values, with some margin.
fn range(panel: &Panel) -> Scale {
    let bands = panel.bands.iter().flat_map(|band| band.low.iter().chain(&band.high));
    Scale::around(panel.curves.iter().flat_map(|curve| &curve.values).chain(bands).copied())
}

/// The ticks of a panel. If all values are integers, such as the states of a program, there are no ticks between
/// integers, provided that at least two ticks remain.
fn values_ticks(panel: &Panel, scale: &Scale) -> Vec<f64> {
    let ticks = scale.ticks(5.0);
    let mut values = panel.curves.iter().flat_map(|curve| &curve.values).filter(|value| is_drawn(**value));
    let whole: Vec<f64> = ticks.iter().copied().filter(|tick| tick.fract() == 0.0).collect();
    if whole.len() > 1 && values.all(|value| value.fract() == 0.0) { whole } else { ticks }
}

/// The names in a legend: curves, then bands.
fn names(panel: &Panel) -> impl Iterator<Item = &str> {
    let bands = panel.bands.iter().map(|band| band.name.as_str());
    panel.curves.iter().map(|curve| curve.name.as_str()).chain(bands)
}

/// The position of each name in a legend: horizontal offset and line.
fn legend_places(panel: &Panel, right: f64) -> Vec<(f64, usize)> {
    let (mut x, mut line) = (LEFT, 0);
    let place = |name: &str| {
        let width = 28.0 + name.chars().count() as f64 * 7.3 + 18.0;
        if x > LEFT && x + width > right {
            (x, line) = (LEFT, line + 1);
        }
        let place = (x, line);
        x += width;
        place
    };
    names(panel).map(place).collect()
}

fn legend_height(panel: &Panel, right: f64) -> f64 {
    let lines = legend_places(panel, right).last().map_or(0, |(_, line)| line + 1);
    lines as f64 * LEGEND + 6.0
}

/// The visible points of a curve: of all points in each half pixel of the time axis, only the first, the last, the
/// lowest, the highest and one that is not drawable, if any.
fn points(times: &[f64], values: &[f64], time: &Across) -> Vec<(f64, f64)> {
    let column = |index: &usize| (time.x(times[*index]) * 2.0) as i64;
    let order = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
    let indices: Vec<usize> = (0..times.len()).collect();
    let mut seen = Vec::new();
    for column in indices.chunk_by(|a, b| column(a) == column(b)) {
        let drawn = || column.iter().copied().filter(|index| is_drawn(values[*index]));
        let gap = column.iter().copied().find(|index| !is_drawn(values[*index]));
        let ends = [column.first().copied(), column.last().copied()];
        let mut kept: Vec<usize> =
            ends.into_iter().chain([drawn().min_by(order), drawn().max_by(order), gap]).flatten().collect();
        kept.sort_unstable();
        kept.dedup();
        seen.extend(kept.into_iter().map(|index| (times[index], values[index])));
    }
    seen
}

/// A path that holds each value until the next point.
fn stairs(points: &[(f64, f64)], time: &Across, y: &dyn Fn(f64) -> f64) -> String {
    let mut path = String::new();
    let mut last = None;
    for (place, (from, value)) in points.iter().enumerate() {
        if !is_drawn(*value) {
            last = None;
            continue;
        }
        let y = Pixels(y(*value)).to_string();
        let held_to = points.get(place + 1).map(|(to, _)| Pixels(time.x(*to)));
        match &last {
            // An unchanged value extends the horizontal line.
            Some(before) if *before == y && held_to.is_some() => path.truncate(path.rfind('H').unwrap_or(path.len())),
            Some(before) if *before == y => {}
            Some(_) => {
                let _ = write!(path, "V{y}");
            }
            None => {
                let _ = write!(path, "M{} {y}", Pixels(time.x(*from)));
            }
        }
        if let Some(to) = held_to {
            let _ = write!(path, "H{to}");
        }
        last = Some(y);
    }
    path
}

/// A path with straight lines from point to point, vertical where the value jumps.
fn lines(points: &[(f64, f64)], over: &Across, y: &dyn Fn(f64) -> f64) -> String {
    let mut path = String::new();
    let mut is_gap = true;
    for (place, (at, value)) in points.iter().enumerate() {
        if is_drawn(*value) {
            if is_jump(points, place) {
                let (before, held) = points[place - 1];
                let x = Pixels(over.x((before + at) / 2.0));
                let _ = write!(path, "L{x} {}V{}", Pixels(y(held)), Pixels(y(*value)));
            }
            let _ = write!(path, "{}{} {}", if is_gap { 'M' } else { 'L' }, Pixels(over.x(*at)), Pixels(y(*value)));
        }
        is_gap = !is_drawn(*value);
    }
    path
}

/// Whether the value jumps to this point: the slope leading to it is more than three times the slope before it and the
/// slope after it.
fn is_jump(points: &[(f64, f64)], place: usize) -> bool {
    const TIMES: f64 = 3.0;
    let slope = |place: usize| {
        let ((from, before), (to, after)) = (points.get(place.checked_sub(1)?)?, points.get(place)?);
        Some(((after - before) / (to - from)).abs()).filter(|slope| slope.is_finite())
    };
    let beside = [place.checked_sub(1).and_then(slope), slope(place + 1)];
    match (slope(place), beside) {
        (Some(slope), [Some(before), Some(after)]) => slope > TIMES * before.max(after) && slope > 0.0,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, values: &[f64]) -> Curve {
        Curve { name: name.into(), values: values.to_vec(), is_input: false, color: None }
    }

    fn across(scale: Scale) -> Across {
        Across { scale, right: WIDTH - RIGHT }
    }

    fn chart(values: &[f64]) -> Chart {
        let time = (0..values.len()).map(|point| point as f64).collect();
        let panels = vec![Panel { label: "l/min".into(), curves: vec![curve("FLOW", values)], bands: Vec::new() }];
        Chart { title: "A <pump>".into(), time, panels, lanes: vec![curve("ON", values)], ..Chart::default() }
    }

    #[test]
    fn a_long_legend_takes_several_lines() {
        let curves: Vec<Curve> = std::iter::repeat_with(|| curve("A_LONG_NAME_OF_A_SIGNAL", &[])).take(7).collect();
        let panel = Panel { curves, ..Panel::default() };
        let lines: Vec<usize> = legend_places(&panel, WIDTH).iter().map(|(_, line)| *line).collect();
        assert_eq!(lines, [0, 0, 0, 1, 1, 1, 2]);
        assert_eq!(legend_height(&panel, WIDTH), 60.0);
        assert_eq!(legend_places(&panel, NARROW)[2], (LEFT, 2), "one in a line");
        assert!(legend_places(&panel, WIDTH).iter().all(|(x, _)| *x < WIDTH / 1.5));
    }

    #[test]
    fn a_panel_shows_all_finite_values() {
        let range = |curves: &[Curve]| range(&Panel { curves: curves.to_vec(), ..Panel::default() });
        let scale = range(&[curve("X", &[1.0, f64::NAN]), curve("X", &[3.0, f64::INFINITY])]);
        assert!(scale.from < 1.0 && scale.from > 0.8 && scale.to > 3.0 && scale.to < 3.2);
        let scale = range(&[curve("X", &[0.0, 0.0])]);
        assert_eq!((scale.from, scale.to), (-0.5, 0.5));
        let scale = range(&[curve("X", &[f64::NAN])]);
        assert_eq!((scale.from, scale.to), (0.0, 1.0));
    }

    #[test]
    fn values_are_held_until_the_next_point() {
        let time = across(Scale { from: 0.0, to: 4.0 });
        let at = |seconds| Pixels(time.x(seconds));
        let path = |values: [f64; 5]| {
            let points: Vec<(f64, f64)> = (0..5).map(f64::from).zip(values).collect();
            stairs(&points, &time, &|value| value)
        };
        assert_eq!(path([1.0, 1.0, 2.0, 2.0, 2.0]), format!("M{} 1H{}V2H{}", at(0.0), at(2.0), at(4.0)));
        assert_eq!(
            path([1.0, f64::NAN, 2.0, 2.0, 2.0]),
            format!("M{} 1H{}M{} 2H{}", at(0.0), at(1.0), at(2.0), at(4.0))
        );
        assert_eq!(path([1.0, 1.0, 1.0, 1.0, 3.0]), format!("M{} 1H{}V3", at(0.0), at(4.0)));
    }

    #[test]
    fn a_characteristic_is_a_line_over_its_variable() {
        let over = across(Scale { from: -1.0, to: 1.0 });
        let points = [(-1.0, 5.0), (0.0, 7.0), (0.5, f64::NAN), (1.0, 9.0)];
        let at = |value| Pixels(over.x(value));
        assert_eq!(lines(&points, &over, &|value| value), format!("M{} 5L{} 7M{} 9", at(-1.0), at(0.0), at(1.0)));
        let steps: Vec<(f64, f64)> = [(-1.0, 0.0), (-0.5, 1.0), (0.0, 2.0), (0.5, 20.0), (1.0, 21.0)].to_vec();
        let jump = format!("L{} 2L{} 2V20L{} 20", at(0.0), at(0.25), at(0.5));
        assert!(lines(&steps, &over, &|value| value).contains(&jump));
        let mut chart = chart(&[0.0, 1.0]);
        chart.over = Some("VALVE in %".into());
        let drawing = svg(&chart).unwrap();
        assert!(drawing.contains(">VALVE in %</text>") && !drawing.contains("time in s"));
    }

    #[test]
    fn every_point_is_drawn_where_there_are_few_and_extremes_and_gaps_where_there_are_many() {
        let time = across(Scale { from: 0.0, to: 1000.0 });
        let few: Vec<f64> = (0..=1000).map(f64::from).collect();
        assert_eq!(points(&few, &few, &time).len(), few.len());

        let many: Vec<f64> = (0..=100_000).map(|point| f64::from(point) / 100.0).collect();
        let mut values = vec![1.0; many.len()];
        (values[50_010], values[50_020], values[70_000]) = (9.0, -9.0, f64::NAN);
        let seen = points(&many, &values, &time);
        assert!(seen.len() < 4 * WIDTH as usize, "{}", seen.len());
        assert!(seen.contains(&(500.1, 9.0)) && seen.contains(&(500.2, -9.0)));
        assert!(seen.iter().any(|(at, value)| *at == 700.0 && value.is_nan()));
        assert_eq!((seen[0], seen[seen.len() - 1]), ((0.0, 1.0), (1000.0, 1.0)));
    }

    #[test]
    fn inputs_alone_are_dashed_and_no_two_curves_look_alike() {
        let mut pens = pens();
        let mut looks = Vec::new();
        for is_input in [true, false].repeat(7) {
            let pen = pens(&Curve { is_input, ..curve("X", &[]) });
            assert_eq!(pen.dashes.is_some_and(|dashes| dashes.starts_with('6')), is_input);
            assert!(!looks.contains(&(pen.color, pen.dashes)));
            looks.push((pen.color, pen.dashes));
        }
    }

    #[test]
    fn a_curve_that_says_its_colour_takes_none_from_the_others() {
        let mut pens = pens();
        let of = |color| Curve { color, ..curve("X", &[]) };
        let colors = [None, Some(0), Some(5), None].map(|color| pens(&of(color)).color);
        assert_eq!(colors, [COLORS[0], COLORS[0], COLORS[5], COLORS[1]]);
    }

    #[test]
    fn a_chart_has_its_title_its_axes_and_the_names_of_its_curves() {
        let drawing = svg(&chart(&[0.0, 1.0, 1.0])).unwrap();
        assert!(drawing.contains("aria-label=\"A &lt;pump&gt;\"") && drawing.contains(">A &lt;pump&gt;</text>"));
        for text in ["l/min", "FLOW", "ON", "time in s"] {
            assert_eq!(drawing.matches(&format!(">{text}</text>")).count(), 1, "{text}");
        }
        assert!(!drawing.contains("stroke-dasharray"));
        assert_eq!(drawing, svg(&chart(&[0.0, 1.0, 1.0])).unwrap());
    }

    #[test]
    fn a_band_is_an_area_behind_the_curves_with_its_name_and_what_is_outside_of_the_window_is_shaded() {
        let mut chart = chart(&[0.0, 4.0, 4.0]);
        let band = |name: &str, high: f64| Band {
            name: name.into(),
            times: vec![0.0, 2.0],
            low: vec![1.0, 1.0],
            high: vec![high; 2],
            color: 0,
        };
        chart.panels[0].bands = vec![band("5 to 95 %", 8.0)];
        chart.window = Some((1.0, 9.0));
        let drawing = svg(&chart).unwrap();
        assert!(drawing.contains(">5 to 95 %</text>"));
        // The panel reaches from -0.48 to 8.48, 190 pixels high below title and legend.
        let y = |value: f64| Pixels(50.0 + 190.0 - (value + 0.48) / 8.96 * 190.0);
        let area = format!("M76 {0}L736 {0}L736 {1}L76 {1}z", y(1.0), y(8.0));
        assert!(drawing.find(&area).unwrap() < drawing.find("stroke-width=\"1.8\"").unwrap(), "{area}");
        // From the left end to the middle; nothing at the right, where the window reaches beyond the time.
        assert!(drawing.contains("M76 50H406V240H76zM736 50H736V240H736z"), "{drawing}");
    }

    #[test]
    fn a_narrow_chart_ends_where_a_phone_does_and_has_fewer_ticks() {
        let mut chart = chart(&[0.0; 25]);
        // From 76 to 736 is 0 s to 24 s, by 3 s; narrow to 476, by 4 s.
        let drawing = svg(&chart).unwrap();
        assert!(
            drawing.contains(r#"viewBox="0 0 760 "#)
                && drawing.contains(r#"<text x="736" y="310.5" text-anchor="middle">24<"#)
        );
        assert!(drawing.contains(">21</text>"), "{drawing}");
        chart.is_narrow = true;
        let drawing = svg(&chart).unwrap();
        assert!(
            drawing.contains(r#"viewBox="0 0 500 "#)
                && drawing.contains(r#"<text x="476" y="310.5" text-anchor="middle">24<"#)
        );
        assert!(drawing.contains(">20</text>") && !drawing.contains(">21</text>"), "{drawing}");
    }

    #[test]
    fn the_ticks_of_whole_numbers_are_whole() {
        let ticks = |values: &[f64]| {
            let panel = Panel { curves: vec![curve("STATE", values)], ..Panel::default() };
            values_ticks(&panel, &range(&panel))
        };
        assert_eq!(ticks(&[0.0, 1.0, 2.0, f64::NAN]), [0.0, 1.0, 2.0]);
        assert_eq!(ticks(&[0.0, 1.0, 1.9]), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(ticks(&[0.0, 40.0]), [0.0, 10.0, 20.0, 30.0, 40.0]);
        // One tick is no axis.
        assert!(ticks(&[3.0, 3.0]).len() > 1 && ticks(&[0.0, 0.0]).len() > 1);
    }

    #[test]
    fn dots_are_drawn_where_a_chart_asks_for_them() {
        let mut chart = chart(&[0.0, f64::NAN, 1.0]);
        assert!(!svg(&chart).unwrap().contains("h0"));
        chart.has_dots = true;
        assert_eq!(svg(&chart).unwrap().matches("h0").count(), 2);
    }

    #[test]
    fn any_values_give_a_drawing_without_a_number_that_is_none() {
        let values = [f64::NAN, f64::INFINITY, f64::MAX, f64::MIN, 0.0, 1e300, -1e300, 5e-324];
        let charts = [chart(&values), chart(&[3.0]), chart(&[]), chart(&[f64::NAN; 2]), chart(&[1e300; 3])];
        for chart in charts {
            let drawing = svg(&chart).unwrap();
            assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
        }
        #[cfg(feature = "png")]
        crate::picture::png(&svg(&chart(&values)).unwrap()).unwrap();
    }

    #[test]
    fn a_chart_that_does_not_fit_its_time_is_refused() {
        let error = |chart: &Chart| format!("{:#}", svg(chart).unwrap_err());
        let mut short = chart(&[0.0, 1.0, 2.0]);
        short.lanes[0].values.pop();
        assert_eq!(error(&short), "ON has 2 values for 3 points in time; it must have one per point");
        let mut back = chart(&[0.0, 1.0, 2.0]);
        back.time[2] = 0.5;
        assert_eq!(error(&back), "the chart's time decreases from 1 s to 0.5 s; it must not decrease");
        back.time[2] = f64::INFINITY;
        assert_eq!(error(&back), "the chart's time has the value inf; every time must be a finite number");
    }
}
