//! Draws a block without a diagram in its documentation: a box with its name, inputs and settings on the left, outputs
//! on the right.

use super::terminals_of;
use crate::svg::Pixels;
use crate::text;
use askama::Template;
use blocks::{Kind, Role};
use modeldescription::Row;
use modeldescription::Table;

// Lengths in pixels.
const FONT: f64 = 12.0;
/// The width of a character in a monospaced font.
const CHARACTER: f64 = FONT * 0.602;
const ROW: f64 = 19.0;
const HEAD: f64 = 40.0;
const STUB: f64 = 18.0;
const MARGIN: f64 = 10.0;

/// The drawing. Its colours are for a light page; the page's style sheet can override them by class.
#[derive(Template)]
#[template(path = "pins.svg")]
struct Pins<'a> {
    name: &'a str,
    width: Pixels,
    height: Pixels,
    left: Pixels,
    right: Pixels,
    top: Pixels,
    box_width: Pixels,
    box_height: Pixels,
    head: Pixels,
    middle: Pixels,
    title_y: Pixels,
    font_size: Pixels,
    terminals: Vec<Terminal<'a>>,
}

/// A terminal: a wire that ends at the box, the name inside the box, and a label outside.
struct Terminal<'a> {
    class: &'static str,
    color: &'static str,
    name: &'a str,
    description: &'a str,
    label: String,
    y: Pixels,
    text_y: Pixels,
    wire_from: Pixels,
    wire_to: Pixels,
    stroke_width: u8,
    name_x: Pixels,
    label_x: Pixels,
    inside: &'static str,
    outside: &'static str,
}

/// Renders the diagram as SVG. Variables of inner blocks have no terminals and are left out.
///
/// # Errors
/// The template cannot be rendered.
pub fn svg(table: &Table) -> anyhow::Result<String> {
    let inputs = terminals_of(table, &[Role::Input]);
    let parameters = terminals_of(table, &[Role::Parameter, Role::Fixed, Role::Cycle]);
    let outputs = terminals_of(table, &[Role::Output]);

    let left_names = widest(inputs.iter().chain(&parameters).map(|row| row.name.clone()));
    let right_names = widest(outputs.iter().map(|row| row.name.clone()));
    let left_labels = widest(inputs.iter().map(|row| label(row)).chain(parameters.iter().map(|row| start(row))));
    let right_labels = widest(outputs.iter().map(|row| label(row)));
    let title = table.name.chars().count() as f64 * 18.0 * 0.66;

    let gap = if parameters.is_empty() { 0.0 } else { ROW * 0.6 };
    let left_rows = (inputs.len() + parameters.len()) as f64 * ROW + gap;
    let rows = left_rows.max(outputs.len() as f64 * ROW);
    let left = MARGIN + left_labels + STUB + 6.0;
    let box_width = (left_names + right_names + 50.0).max(title + 30.0);
    let box_height = HEAD + rows + 10.0;
    let right = left + box_width;

    let first = MARGIN + HEAD + ROW / 2.0;
    let first_parameter = first + inputs.len() as f64 * ROW + gap;
    let column = |rows: &[&'_ Row], first: f64| -> Vec<f64> {
        (0..rows.len()).map(|place| first + place as f64 * ROW).collect()
    };
    let mut terminals = Vec::new();
    for (row, y) in inputs.iter().zip(column(&inputs, first)) {
        terminals.push(terminal(row, Side::Left { x: left }, y, label(row), Wire::Signal));
    }
    for (row, y) in parameters.iter().zip(column(&parameters, first_parameter)) {
        terminals.push(terminal(row, Side::Left { x: left }, y, start(row), Wire::Setting));
    }
    for (row, y) in outputs.iter().zip(column(&outputs, first)) {
        terminals.push(terminal(row, Side::Right { x: right }, y, label(row), Wire::Signal));
    }
    let pins = Pins {
        name: &table.name,
        width: Pixels(right + STUB + 6.0 + right_labels + MARGIN),
        height: Pixels(box_height + 2.0 * MARGIN),
        left: Pixels(left),
        right: Pixels(right),
        top: Pixels(MARGIN),
        box_width: Pixels(box_width),
        box_height: Pixels(box_height),
        head: Pixels(MARGIN + HEAD - 10.0),
        middle: Pixels(left + box_width / 2.0),
        title_y: Pixels(MARGIN + 21.0),
        font_size: Pixels(FONT),
        terminals,
    };
    Ok(pins.render()?)
}

/// The side of the box at which a terminal is placed, with the horizontal position of the edge.
enum Side {
    Left { x: f64 },
    Right { x: f64 },
}

/// The kind of value that a wire carries.
enum Wire {
    Signal,
    Setting,
}

fn terminal(row: &Row, side: Side, y: f64, label: String, wire: Wire) -> Terminal<'_> {
    let (edge, direction, inside, outside) = match side {
        Side::Left { x } => (x, -1.0, "start", "end"),
        Side::Right { x } => (x, 1.0, "end", "start"),
    };
    let (class, color) = match wire {
        Wire::Signal => ("signal", "#1f3a5f"),
        Wire::Setting => ("setting", "#8a97a8"),
    };
    Terminal {
        class,
        color,
        name: &row.name,
        description: &row.description,
        label,
        y: Pixels(y),
        text_y: Pixels(y + FONT * 0.34),
        wire_from: Pixels(edge + direction * STUB),
        wire_to: Pixels(edge),
        // As in function block diagrams, a bit is a thin wire and a number a thick one.
        stroke_width: if row.kind == Kind::Bool { 1 } else { 2 },
        name_x: Pixels(edge - direction * 7.0),
        label_x: Pixels(edge + direction * (STUB + 5.0)),
        inside,
        outside,
    }
}

fn widest(texts: impl Iterator<Item = String>) -> f64 {
    texts.map(|text| text.chars().count() as f64 * CHARACTER).fold(0.0, f64::max)
}

/// The type and unit of a signal.
fn label(row: &Row) -> String {
    match &row.unit {
        Some(unit) => format!("{} {unit}", row.kind.name()),
        None => row.kind.name().to_string(),
    }
}

/// The start value of a setting.
fn start(row: &Row) -> String {
    text::value(row, row.start())
}
