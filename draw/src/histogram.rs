//! Histograms: bars whose width is a round number, and marked values.

use crate::field::{Axis, Field, LEFT, Label, ROW, Shape, Style, WIDTH};
use crate::palette;
use crate::scale::{Scale, is_drawn, round_step};
use crate::svg::Pixels;
use modeldescription::units;
use std::fmt::Write;

/// The height of the plot area in pixels.
const HEIGHT: f64 = 230.0;

/// The approximate maximum number of bars.
const MOST_BARS: f64 = 80.0;

/// A value marked by a line, with a label.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The value.
    pub at: f64,
    /// Its label.
    pub text: String,
    /// Whether it is a limit, drawn in black; a mark computed from the values is vermilion.
    pub is_limit: bool,
}

/// Draws a histogram of values in ascending order; `None` if there are no drawable values.
///
/// The width of a bar is a round number: the next one above 2 (p75 - p25) / n^(1/3) (D. Freedman and P. Diaconis, "On
/// the histogram as a density estimator", 1981), or larger to limit the number of bars to about 80. If all values are
/// integers, the edges of the bars are midway between integers.
///
/// # Errors
/// The histogram cannot be drawn.
pub fn svg(title: &str, label: &str, sorted: &[f64], marks: &[Mark]) -> anyhow::Result<Option<String>> {
    let values: Vec<f64> = sorted.iter().copied().filter(|value| is_drawn(*value)).collect();
    let Some(Bars { width, shift }) = Bars::new(&values) else { return Ok(None) };
    let bar = |value: f64| ((value - shift) / width).floor();
    let (first, last) = (bar(values[0]), bar(values[values.len() - 1]));
    let mut counts = vec![0u64; (last - first) as usize + 1];
    for value in &values {
        counts[(bar(*value) - first) as usize] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0);
    let is_constant = values[0] == values[values.len() - 1];
    // A margin of a quarter bar on both sides, or of five bars if all values are equal, so that the only bar is narrow.
    let room = if is_constant { 5.0 } else { 0.25 };
    let mut horizontal = Axis::linear(label, (first - room) * width + shift, (last + 1.0 + room) * width + shift);
    // Leave out distant marks, for which the bars would have to shrink too much.
    let (from, to) = (horizontal.scale.from, horizontal.scale.to);
    let is_near = |mark: &&Mark| mark.at > from - (to - from) && mark.at < to + (to - from);
    let marks: Vec<&Mark> = marks.iter().filter(is_near).collect();
    let least = marks.iter().map(|mark| mark.at - 0.25 * width).fold(from, f64::min);
    let greatest = marks.iter().map(|mark| mark.at + 0.25 * width).fold(to, f64::max);
    horizontal.scale = Scale { from: least, to: greatest };
    if is_constant {
        horizontal.ticks = Some(vec![(values[0], modeldescription::digits::short(values[0]))]);
    }
    let mut vertical = Axis::linear("runs", 0.0, most as f64 * 1.05);
    let ticks = vertical.scale.ticks(6.0).into_iter().filter(|tick| tick.fract() == 0.0);
    vertical.ticks = Some(ticks.map(|tick| (tick, tick.to_string())).collect());
    let top = 18.0 + ROW * (marks.len() + 1) as f64;
    let field = Field { title, horizontal, vertical, left: LEFT, top, height: HEIGHT };
    let bottom = Pixels(field.y(0.0));
    let mut path = String::new();
    for (number, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let begin = (first + number as f64) * width + shift;
        let (left, right) = (field.x(begin) + 0.5, field.x(begin + width) - 0.5);
        write!(path, "M{} {bottom}V{}H{}V{bottom}Z", Pixels(left), Pixels(field.y(*count as f64)), Pixels(right))?;
    }
    let mut shapes =
        vec![Shape { class: "curve-1".into(), color: palette::PROCESS_VALUE, path, style: Style::Area(0.6) }];
    let mut labels = Vec::new();
    for (row, mark) in marks.iter().enumerate() {
        let x = field.x(mark.at);
        let of = if mark.is_limit { ("curve-7", palette::INK) } else { ("curve-2", palette::MANIPULATED_VALUE) };
        let y = top - 6.0 - (marks.len() - 1 - row) as f64 * ROW;
        let path = format!("M{} {}V{bottom}", Pixels(x), Pixels(y + 3.0));
        shapes.push(Shape { class: of.0.into(), color: of.1, path, style: Style::Dashed(1.6) });
        let (anchor, x) = if x > WIDTH / 2.0 { ("end", x - 5.0) } else { ("start", x + 5.0) };
        labels.push(Label { x, y, anchor, text: units::shown(&mark.text), of: Some(of) });
    }
    field.svg(&shapes, &labels).map(Some)
}

/// The layout of a histogram's bars.
#[derive(Debug, PartialEq)]
struct Bars {
    width: f64,
    /// The start of one of the bars.
    shift: f64,
}

impl Bars {
    /// The bars for values in ascending order; `None` without values.
    fn new(values: &[f64]) -> Option<Bars> {
        let (min, max) = (*values.first()?, *values.last()?);
        if min == max {
            let width = round_step(if min == 0.0 { 1.0 } else { min.abs() / 20.0 });
            return Some(Bars { width, shift: min - width / 2.0 });
        }
        let at = |part: f64| values[((values.len() - 1) as f64 * part).round() as usize];
        let rule = 2.0 * (at(0.75) - at(0.25)) / (values.len() as f64).cbrt();
        // If the middle half of the values are equal, the rule yields 0: divide the range by 40 instead.
        let rule = if rule > 0.0 { rule } else { (max - min) / 40.0 };
        let are_whole = values.iter().all(|value| value.fract() == 0.0);
        let width = match are_whole {
            true if max - min <= MOST_BARS / 2.0 => 1.0,
            true => round_step(rule.max((max - min) / MOST_BARS).max(1.0)),
            false => round_step(rule.max((max - min) / MOST_BARS)),
        };
        Some(Bars { width, shift: if are_whole { -0.5 } else { 0.0 } })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Option<String> {
        svg("settling of all runs", "settling in s", values, &[]).unwrap()
    }

    #[test]
    fn bars_have_a_round_width_and_whole_numbers_in_their_middle() {
        // Quartiles 24.5 and 74.5, to the next value 25 and 74: 2 * 49 / 100^(1/3) = 21.1.
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(Bars::new(&values), Some(Bars { width: 50.0, shift: -0.5 }));
        // An outlier must not result in thousands of bars.
        let outlier: Vec<f64> = values.iter().copied().chain([1e6]).collect();
        assert_eq!(Bars::new(&outlier).unwrap().width, 20_000.0);
        assert_eq!(Bars::new(&[1.0, 1.0, 2.0, 2.0, 3.0]), Some(Bars { width: 1.0, shift: -0.5 }));
        let mut mostly = vec![0.0; 99];
        mostly.push(0.5);
        assert_eq!(Bars::new(&mostly), Some(Bars { width: 0.02, shift: 0.0 }));
        assert_eq!(Bars::new(&[]), None);
    }

    #[test]
    fn a_constant_is_a_narrow_bar_around_its_value_which_the_axis_names() {
        assert_eq!(Bars::new(&[100.0; 3]), Some(Bars { width: 5.0, shift: 97.5 }));
        let drawing = of(&[100.0; 3]).unwrap();
        // An eleventh of the width of 660 pixels, around the middle at 406, less half a pixel on both sides.
        assert!(drawing.contains("M376.5 ") && drawing.contains("H435.5V"), "{drawing}");
        assert_eq!(drawing.matches("text-anchor=\"middle\">100</text>").count(), 1);
    }

    #[test]
    fn marks_have_a_line_and_a_text_each_and_a_limit_far_away_is_not_shown() {
        let mark = |at, text: &str, is_limit| Mark { at, text: text.into(), is_limit };
        let marks = [mark(5.0, "median: 5 s", false), mark(12.0, "limit: 12 s", true), mark(900.0, "far", true)];
        let values: Vec<f64> = (0..=10).map(f64::from).collect();
        let drawing = svg("T", "settling in degC", &values, &marks).unwrap().unwrap();
        for text in ["T", "settling in °C", "runs", "median: 5 s", "limit: 12 s"] {
            assert!(drawing.contains(&format!(">{text}</text>")), "{text}");
        }
        assert!(!drawing.contains("far") && drawing.matches("stroke-dasharray").count() == 2);
    }

    #[test]
    fn any_values_give_a_histogram_without_a_number_that_is_none() {
        assert_eq!(of(&[]), None);
        for values in [&[3.0, f64::INFINITY, f64::NAN][..], &[0.0], &[-5.0; 9], &[-1e300, 1e300], &[5e-324, 1.0]] {
            let drawing = of(values).unwrap();
            assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{values:?}");
        }
    }
}
