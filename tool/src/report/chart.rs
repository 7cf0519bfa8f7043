//! Curves over time as an SVG.

use super::Text;
use modeldescription::digits::short;
use std::fmt::{self, Write};

/// The size of the drawing, and of its margins.
const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 340.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 62.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 40.0;
/// The height of a lane of a switch.
const LANE: f64 = 22.0;

/// The colours of Okabe and Ito, which can be told apart without red or green.
const COLOURS: [&str; 6] = ["#4b5563", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"];

/// Where a curve has its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    Left,
    Right,
    /// A lane of its own below: a switch.
    Lane,
}

/// A curve.
pub(super) struct Curve<'a> {
    pub(super) name: &'a str,
    pub(super) unit: Option<&'a str>,
    /// One for each time; what is not a number interrupts the curve.
    pub(super) values: &'a [f64],
    pub(super) axis: Axis,
}

/// Curves with common times.
pub(super) struct Chart<'a> {
    /// In seconds, at least two.
    pub(super) times: &'a [f64],
    pub(super) curves: Vec<Curve<'a>>,
}

/// An axis with its ends and marks.
struct Scale {
    low: f64,
    high: f64,
    marks: Vec<f64>,
}

impl Scale {
    /// An axis that holds all values, with round ends.
    fn of(values: impl Iterator<Item = f64>) -> Scale {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if high - low <= 1e-9 * high.abs().max(low.abs()).max(1e-300) {
            let half = (high.abs() * 0.05).max(0.5);
            (low, high) = (low - half, high + half);
        }
        let step = round_step((high - low) / 5.0);
        let (low, high) = ((low / step - 1e-9).floor() * step, (high / step + 1e-9).ceil() * step);
        let count = ((high - low) / step).round() as i32;
        Scale { low, high, marks: (0..=count.min(20)).map(|mark| low + f64::from(mark) * step).collect() }
    }

    /// The time axis, which ends with the values.
    fn of_times(first: f64, last: f64) -> Scale {
        let last = if last > first { last } else { first + 1.0 };
        let step = round_step((last - first) / 8.0);
        let begin = (first / step - 1e-9).ceil();
        let marks = (0..30).map(|mark| (begin + f64::from(mark)) * step).take_while(|mark| *mark <= last + 1e-9 * step);
        Scale { low: first, high: last, marks: marks.collect() }
    }

    /// Where a value is, from 0 to 1.
    fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// The smallest of 1, 2, 5, 10 ... that is not less.
fn round_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|step| step * decade).find(|step| *step >= least * 0.999).unwrap_or(10.0 * decade)
}

impl Chart<'_> {
    /// The drawing.
    pub(super) fn svg(&self) -> Result<String, fmt::Error> {
        let lanes = self.curves.iter().filter(|curve| curve.axis == Axis::Lane).count();
        let height = HEIGHT + lanes as f64 * LANE;
        let mut svg = String::new();
        let names: Vec<_> = self.curves.iter().map(|curve| curve.name).collect();
        writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{} over time\" \
             font-family=\"system-ui, sans-serif\" font-size=\"12\">\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>",
            Text(&names.join(", "))
        )?;
        let (first, last) = (self.times.first().copied().unwrap_or(0.0), self.times.last().copied().unwrap_or(1.0));
        let times = Scale::of_times(first, last);
        self.frame(&mut svg, &times, height)?;
        for axis in [Axis::Left, Axis::Right] {
            let curves: Vec<_> = self.numbered().filter(|(_, curve)| curve.axis == axis).collect();
            if curves.is_empty() {
                continue;
            }
            let scale = Scale::of(curves.iter().flat_map(|(_, curve)| curve.values.iter().copied()));
            marks(&mut svg, &scale, axis, &curves)?;
            for (number, curve) in curves {
                let y = |value: f64| HEIGHT - BOTTOM - scale.place(value) * (HEIGHT - TOP - BOTTOM);
                self.line(&mut svg, &times, curve, colour(number), y)?;
            }
        }
        for (lane, (number, curve)) in self.numbered().filter(|(_, curve)| curve.axis == Axis::Lane).enumerate() {
            let base = HEIGHT - BOTTOM + (lane + 1) as f64 * LANE;
            writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{}\">{}</text>",
                LEFT - 8.0,
                base - 2.0,
                colour(number),
                Text(curve.name)
            )?;
            self.line(&mut svg, &times, curve, colour(number), |value| base - value.clamp(0.0, 1.0) * (LANE - 8.0))?;
        }
        self.legend(&mut svg)?;
        svg.push_str("</svg>\n");
        Ok(svg)
    }

    fn numbered(&self) -> impl Iterator<Item = (usize, &Curve<'_>)> {
        self.curves.iter().enumerate()
    }

    /// The frame with the marks of the time.
    fn frame(&self, svg: &mut String, times: &Scale, height: f64) -> fmt::Result {
        let (bottom, right) = (height - BOTTOM, WIDTH - RIGHT);
        for mark in &times.marks {
            let x = LEFT + times.place(*mark) * (right - LEFT);
            writeln!(
                svg,
                "<path d=\"M{x:.1} {TOP}V{bottom}\" stroke=\"#e5e7eb\"/>\
                 <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"#4b5563\">{}</text>",
                bottom + 16.0,
                short(*mark)
            )?;
        }
        writeln!(
            svg,
            "<path d=\"M{LEFT} {TOP}V{bottom}H{right}V{TOP}\" fill=\"none\" stroke=\"#6b7280\"/>\
             <text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"#4b5563\">Time in s</text>",
            (LEFT + right) / 2.0,
            bottom + 33.0
        )
    }

    fn line(
        &self,
        svg: &mut String,
        times: &Scale,
        curve: &Curve,
        colour: &str,
        y: impl Fn(f64) -> f64,
    ) -> fmt::Result {
        let end = self.times.last().copied().unwrap_or(0.0);
        let is_lane = curve.axis == Axis::Lane;
        let mut path = String::new();
        let (mut is_drawing, mut last) = (false, 0.0);
        for (time, value) in self.times.iter().zip(curve.values) {
            if !value.is_finite() {
                is_drawing = false;
                continue;
            }
            let x = LEFT + times.place(*time) * (WIDTH - LEFT - RIGHT);
            let y = y(*value);
            match is_drawing {
                false => write!(path, "M{x:.1} {y:.1}")?,
                // A switch stays until the next call; where it does not change, nothing needs to be said.
                true if is_lane && y != last => write!(path, "H{x:.1}V{y:.1}")?,
                true if is_lane && *time < end => {}
                true => write!(path, "L{x:.1} {y:.1}")?,
            }
            (is_drawing, last) = (true, y);
        }
        writeln!(
            svg,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\" stroke-linejoin=\"round\"/>"
        )
    }

    /// The names of the curves above the frame.
    fn legend(&self, svg: &mut String) -> fmt::Result {
        let mut x = LEFT;
        for (number, curve) in self.numbered().filter(|(_, curve)| curve.axis != Axis::Lane) {
            let side = if curve.axis == Axis::Right { " (right)" } else { "" };
            writeln!(
                svg,
                "<path d=\"M{x:.1} 16h18\" stroke=\"{}\" stroke-width=\"2.5\"/>\
                 <text x=\"{:.1}\" y=\"20\" fill=\"#1f2937\">{}{side}</text>",
                colour(number),
                x + 24.0,
                Text(curve.name)
            )?;
            x += 54.0 + 7.5 * (curve.name.chars().count() + side.len()) as f64;
        }
        Ok(())
    }
}

/// The marks of an axis and its unit.
fn marks(svg: &mut String, scale: &Scale, axis: Axis, curves: &[(usize, &Curve)]) -> fmt::Result {
    let (x, anchor) = if axis == Axis::Left { (LEFT - 8.0, "end") } else { (WIDTH - RIGHT + 8.0, "start") };
    for mark in &scale.marks {
        let y = HEIGHT - BOTTOM - scale.place(*mark) * (HEIGHT - TOP - BOTTOM);
        if axis == Axis::Left {
            writeln!(svg, "<path d=\"M{LEFT} {y:.1}H{}\" stroke=\"#e5e7eb\"/>", WIDTH - RIGHT)?;
        }
        // What is left of a subtraction is no mark of its own.
        let mark = if mark.abs() < 1e-9 * (scale.high - scale.low) { 0.0 } else { *mark };
        writeln!(
            svg,
            "<text x=\"{x}\" y=\"{:.1}\" text-anchor=\"{anchor}\" fill=\"#4b5563\">{}</text>",
            y + 4.0,
            short(mark)
        )?;
    }
    let mut units: Vec<&str> = curves.iter().filter_map(|(_, curve)| curve.unit).collect();
    units.dedup();
    writeln!(
        svg,
        "<text x=\"{x}\" y=\"{}\" text-anchor=\"{anchor}\" fill=\"#1f2937\">{}</text>",
        TOP - 14.0,
        Text(&units.join(", "))
    )
}

fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}
