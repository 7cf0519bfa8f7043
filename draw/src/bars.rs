//! Tornado charts: horizontal bars below one another, which extend from a middle to both sides.

use crate::field::{Axis, Field, Label, ROW, Shape, Style};
use crate::palette;
use crate::scale::Scale;
use crate::svg::Pixels;
use std::fmt::Write;

// Lengths in pixels.
const BAR: f64 = 26.0;
/// The approximate width of a letter in a name.
const LETTER: f64 = 7.0;
const GAP: f64 = 5.0;

/// A bar of a tornado chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// The label to its left.
    pub name: String,
    /// The values at the ends of its two halves, which start at the middle.
    pub ends: [f64; 2],
}

/// Draws a tornado chart with the bars from top to bottom. `label` is the label of the axis, `middle` the value at
/// which the bars start, and `halves` the labels of their two halves. `None` if there are no bars.
///
/// # Errors
/// The chart cannot be drawn.
pub fn tornado(
    title: &str,
    label: &str,
    middle: f64,
    bars: &[Bar],
    halves: [&str; 2],
) -> anyhow::Result<Option<String>> {
    if bars.is_empty() {
        return Ok(None);
    }
    let longest = bars.iter().map(|bar| bar.name.chars().count()).max().unwrap_or(0);
    let values = bars.iter().flat_map(|bar| bar.ends).chain([middle]);
    let horizontal = Axis { scale: Scale::around(values), ..Axis::linear(label, 0.0, 1.0) };
    let count = bars.len() as f64;
    let place = |number: usize| count - number as f64 - 0.5;
    let names = bars.iter().enumerate().map(|(number, bar)| (place(number), bar.name.clone()));
    let vertical = Axis { ticks: Some(names.collect()), ..Axis::linear("", 0.0, count) };
    let left = 24.0 + longest as f64 * LETTER;
    let field = Field { title, horizontal, vertical, left, top: 33.0 + ROW, height: count * BAR };
    let mut paths = [String::new(), String::new()];
    let zero = Pixels(field.x(middle));
    for (number, bar) in bars.iter().enumerate() {
        let (top, bottom) = (field.y(place(number) + 0.5) + GAP, field.y(place(number) - 0.5) - GAP);
        // If both halves extend to the same side, each gets half of the height.
        let is_one_sided = (bar.ends[0] - middle) * (bar.ends[1] - middle) > 0.0;
        let between = if is_one_sided { (top + bottom) / 2.0 } else { bottom };
        let spans = if is_one_sided { [(top, between), (between, bottom)] } else { [(top, bottom); 2] };
        for ((path, end), (top, bottom)) in paths.iter_mut().zip(bar.ends).zip(spans) {
            write!(path, "M{zero} {}H{}V{}H{zero}z", Pixels(top), Pixels(field.x(end)), Pixels(bottom))?;
        }
    }
    let looks = [("level-1", palette::PROCESS_VALUE), ("level-7", palette::MANIPULATED_VALUE)];
    let mut shapes = Vec::new();
    let (mut labels, mut x) = (Vec::new(), left);
    for ((path, (class, color)), name) in paths.into_iter().zip(looks).zip(halves) {
        let path = format!("{path}M{} 30h12v9h-12z", Pixels(x));
        shapes.push(Shape { class: class.into(), color, path, style: Style::Area(0.8) });
        labels.push(Label { x: x + 18.0, y: 39.0, anchor: "start", text: name.into(), of: None });
        x += 18.0 + name.chars().count() as f64 * LETTER + 20.0;
    }
    let path = format!("M{zero} {}V{}", Pixels(field.top), Pixels(field.y(0.0)));
    shapes.push(Shape { class: "curve-7".into(), color: palette::INK, path, style: Style::Line(1.2) });
    field.svg(&shapes, &labels).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_reach_from_the_middle_to_both_ends_in_their_order() {
        let bar = |name: &str, ends| Bar { name: name.into(), ends };
        let bars = [bar("P.LAG", [0.0, 10.0]), bar("P.GAIN", [6.0, 4.0])];
        let drawing = tornado("T", "overshoot in %", 5.0, &bars, ["low", "high"]).unwrap().unwrap();
        for text in ["T", "P.LAG", "P.GAIN", "low", "high", "overshoot in %"] {
            assert_eq!(drawing.matches(&format!(">{text}</text>")).count(), 1, "{text}");
        }
        assert!(drawing.find(">P.LAG<") < drawing.find(">P.GAIN<"));
        // From -0.6 to 10.6 over 770 - 100 pixels; names have six letters at most: the field begins at 66.
        let x = |value: f64| Pixels(66.0 + (value + 0.6) / 11.2 * (760.0 - 24.0 - 66.0));
        let low = format!("M{} 53H{}V69", x(5.0), x(0.0));
        let high = format!("M{} 53H{}V69", x(5.0), x(10.0));
        assert!(drawing.contains(&low) && drawing.contains(&high), "{low} {drawing}");
        assert_eq!(tornado("T", "", 0.0, &[], ["", ""]).unwrap(), None);
    }
}
