//! A plot area with axes at the bottom and left, for histograms, scatter plots and bars.

use crate::scale::{Scale, is_drawn, tick_label};
use crate::svg::Pixels;
use askama::Template;
use modeldescription::units;

// In pixels.
/// The width of a drawing.
pub(crate) const WIDTH: f64 = 760.0;
pub(crate) const LEFT: f64 = 76.0;
pub(crate) const RIGHT: f64 = 24.0;
const BOTTOM: f64 = 46.0;
/// The height of a row of text above the plot area.
pub(crate) const ROW: f64 = 15.0;

/// An axis: its label, and the range of its values.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// The values at its ends; on a logarithmic axis, their logarithms to base 10.
    pub scale: Scale,
    /// Whether the scale is logarithmic.
    pub is_logarithmic: bool,
    /// The labelled values; by default round numbers.
    pub ticks: Option<Vec<(f64, String)>>,
}

impl Axis {
    /// A linear axis between two values.
    pub fn linear(label: impl Into<String>, from: f64, to: f64) -> Axis {
        Axis { label: label.into(), scale: Scale { from, to }, is_logarithmic: false, ticks: None }
    }

    /// An axis that contains all values, with some margin. It is logarithmic only if all values are above 0.
    pub fn around(label: impl Into<String>, values: impl Iterator<Item = f64> + Clone, is_logarithmic: bool) -> Axis {
        let is_logarithmic = is_logarithmic && values.clone().all(|value| value > 0.0);
        let scale = Scale::around(values.map(|value| if is_logarithmic { value.log10() } else { value }));
        Axis { label: label.into(), scale, is_logarithmic, ticks: None }
    }

    /// The position of a value on the scale: the value, or its logarithm to base 10.
    pub(crate) fn place(&self, value: f64) -> f64 {
        if self.is_logarithmic { value.log10() } else { value }
    }

    fn part(&self, value: f64) -> f64 {
        self.scale.part(self.place(value))
    }

    /// About `count` tick values with labels; on a logarithmic axis 1, 2, 5, 10 and so on, or only powers of ten if it
    /// spans more than four decades.
    fn ticks(&self, count: f64) -> Vec<(f64, String)> {
        if let Some(ticks) = &self.ticks {
            return ticks.clone();
        }
        let ticks = if self.is_logarithmic {
            let decades = self.scale.from.floor() as i32..=self.scale.to.ceil() as i32;
            let are_few = self.scale.to - self.scale.from <= 4.0;
            let factors: &[f64] = if are_few { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let all = decades.flat_map(|decade| factors.iter().map(move |factor| factor * 10f64.powi(decade)));
            all.filter(|tick| (0.0..=1.0).contains(&self.part(*tick))).collect()
        } else {
            self.scale.ticks(count)
        };
        ticks.into_iter().map(|tick| (tick, tick_label(tick))).collect()
    }
}

/// The drawing style of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Style {
    /// Filled, with this opacity.
    Area(f64),
    /// A line of this width.
    Line(f64),
    /// A dashed line of this width.
    Dashed(f64),
    /// Points of this diameter.
    Dots(f64),
}

/// A path of a single colour.
pub(crate) struct Shape {
    /// The CSS class with which a page can change the colour.
    pub class: String,
    pub color: &'static str,
    pub path: String,
    pub style: Style,
}

/// A text at a position; `of` holds the class and colour of the shape to which it belongs, if any.
pub(crate) struct Label {
    pub x: f64,
    pub y: f64,
    pub anchor: &'static str,
    pub text: String,
    pub of: Option<(&'static str, &'static str)>,
}

/// The plot area of a drawing.
pub(crate) struct Field<'a> {
    pub title: &'a str,
    pub horizontal: Axis,
    pub vertical: Axis,
    pub left: f64,
    pub top: f64,
    pub height: f64,
}

#[derive(Template)]
#[template(path = "field.svg")]
struct Drawing<'a> {
    title: &'a str,
    width: Pixels,
    height: Pixels,
    left: Pixels,
    right: Pixels,
    top: Pixels,
    bottom: Pixels,
    title_x: Pixels,
    title_y: Pixels,
    label_x: Pixels,
    tick_x: Pixels,
    middle_x: Pixels,
    middle_y: Pixels,
    horizontal_y: Pixels,
    horizontal: &'a str,
    vertical: &'a str,
    rows: Vec<Tick>,
    columns: Vec<Tick>,
    shapes: &'a [Shape],
    labels: Vec<Text<'a>>,
}

struct Tick {
    at: Pixels,
    text_y: Pixels,
    label: String,
}

struct Text<'a> {
    x: Pixels,
    y: Pixels,
    label: &'a Label,
}

impl Field<'_> {
    /// The horizontal position of a value, clamped to the plot area.
    pub(crate) fn x(&self, value: f64) -> f64 {
        self.left + self.horizontal.part(value).clamp(0.0, 1.0) * (WIDTH - self.left - RIGHT)
    }

    /// The vertical position of a value, clamped to the plot area.
    pub(crate) fn y(&self, value: f64) -> f64 {
        self.top + (1.0 - self.vertical.part(value).clamp(0.0, 1.0)) * self.height
    }

    /// Renders the drawing as SVG.
    pub(crate) fn svg(&self, shapes: &[Shape], labels: &[Label]) -> anyhow::Result<String> {
        let bottom = self.top + self.height;
        let row = |(tick, label): (f64, String)| {
            let y = self.y(tick);
            Tick { at: Pixels(y), text_y: Pixels(y + 4.0), label }
        };
        let column =
            |(tick, label): (f64, String)| Tick { at: Pixels(self.x(tick)), text_y: Pixels(bottom + 16.0), label };
        let drawing = Drawing {
            title: self.title,
            width: Pixels(WIDTH),
            height: Pixels(bottom + BOTTOM),
            left: Pixels(self.left),
            right: Pixels(WIDTH - RIGHT),
            top: Pixels(self.top),
            bottom: Pixels(bottom),
            title_x: Pixels(LEFT.min(self.left)),
            title_y: Pixels(18.0),
            label_x: Pixels(16.0),
            tick_x: Pixels(self.left - 8.0),
            middle_x: Pixels((self.left + WIDTH - RIGHT) / 2.0),
            middle_y: Pixels(self.top + self.height / 2.0),
            horizontal_y: Pixels(bottom + 36.0),
            horizontal: &units::shown(&self.horizontal.label),
            vertical: &units::shown(&self.vertical.label),
            rows: self.vertical.ticks(6.0).into_iter().map(row).collect(),
            columns: self.horizontal.ticks(8.0).into_iter().map(column).collect(),
            shapes,
            labels: labels.iter().map(|label| Text { x: Pixels(label.x), y: Pixels(label.y), label }).collect(),
        };
        Ok(drawing.render()?)
    }
}

/// The distance between equidistant values, and their number; `None` if they are not equidistant or fewer than two.
/// Duplicates count once.
pub(crate) fn pitch(values: impl Iterator<Item = f64>) -> Option<(f64, usize)> {
    /// The maximum deviation from the mean distance, as a fraction of it.
    const EVEN: f64 = 0.01;
    let mut values: Vec<f64> = values.filter(|value| is_drawn(*value)).collect();
    values.sort_unstable_by(f64::total_cmp);
    let width = values.last()? - values.first()?;
    values.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * width);
    let gaps = values.len().checked_sub(1).filter(|gaps| *gaps > 0)?;
    let pitch = width / gaps as f64;
    let is_even = values.windows(2).all(|pair| (pair[1] - pair[0] - pitch).abs() <= EVEN * pitch);
    (is_even && pitch > 0.0).then_some((pitch, values.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_even_up_to_round_off_and_two_values_always_are() {
        assert_eq!(pitch([3.0, 1.0, 2.0, 1.0].into_iter()), Some((1.0, 3)));
        assert_eq!(pitch([0.5, 4.5].into_iter()), Some((4.0, 2)));
        let (tenth, count) = pitch([0.1, 0.2, 0.1 + 0.2].into_iter()).unwrap();
        assert!((tenth - 0.1).abs() < 1e-9 && count == 3);
        assert_eq!(pitch([1.0, 2.0, 4.0].into_iter()), None);
        assert_eq!((pitch([2.0, 2.0].into_iter()), pitch(std::iter::empty())), (None, None));
    }

    #[test]
    fn a_logarithmic_axis_names_1_2_5_and_a_linear_one_round_numbers() {
        let labels = |axis: &Axis| axis.ticks(5.0).into_iter().map(|(_, label)| label).collect::<Vec<_>>();
        assert_eq!(labels(&Axis::around("", [1.0, 100.0].into_iter(), true)), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(labels(&Axis::around("", [0.0, 100.0].into_iter(), true)), ["0", "50", "100"]);
    }
}
