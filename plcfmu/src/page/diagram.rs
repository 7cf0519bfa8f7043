//! A block as a function block diagram shows it: a box with its name, inputs and settings on the left, outputs on the
//! right.

use crate::page::svg::{coordinate, escape};
use crate::page::text;
use modeldescription::Interface;
use modeldescription::interface::{Kind, Role, Row};
use std::fmt::Write;

// In pixels.
const FONT: f64 = 12.0;
/// Width of a character of a monospaced font.
const CHARACTER: f64 = FONT * 0.602;
const ROW: f64 = 19.0;
const HEAD: f64 = 40.0;
const STUB: f64 = 18.0;
const MARGIN: f64 = 10.0;

/// The diagram as SVG. The settings of blocks inside the block have no terminals of their own and are left out.
pub fn svg(interface: &Interface) -> String {
    let of = |roles: &[Role]| -> Vec<&Row> {
        let rows = interface.variables.iter();
        rows.filter(|row| roles.contains(&row.role) && !row.name.contains('.')).collect()
    };
    let inputs = of(&[Role::Input]);
    let parameters = of(&[Role::Parameter, Role::Fixed, Role::Cycle]);
    let outputs = of(&[Role::Output]);

    let left_names = widest(inputs.iter().chain(&parameters).map(|row| row.name.clone()));
    let right_names = widest(outputs.iter().map(|row| row.name.clone()));
    let left_labels = widest(inputs.iter().map(|row| label(row)).chain(parameters.iter().map(|row| start(row))));
    let right_labels = widest(outputs.iter().map(|row| label(row)));
    let title = interface.name.chars().count() as f64 * 18.0 * 0.66;

    let gap = if parameters.is_empty() { 0.0 } else { ROW * 0.6 };
    let left_rows = (inputs.len() + parameters.len()) as f64 * ROW + gap;
    let rows = left_rows.max(outputs.len() as f64 * ROW);
    let left = MARGIN + left_labels + STUB + 6.0;
    let box_width = (left_names + right_names + 40.0).max(title + 30.0);
    let box_height = HEAD + rows + 10.0;
    let right = left + box_width;
    let width = right + STUB + 6.0 + right_labels + MARGIN;
    let height = box_height + 2.0 * MARGIN;

    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" role="img" aria-label="Terminals of {name}">
<rect width="{width}" height="{height}" fill="#ffffff"/>
<rect x="{left}" y="{MARGIN}" width="{box_width}" height="{box_height}" rx="3" fill="#f4f7fb" stroke="#1f3a5f" stroke-width="1.5"/>
<path d="M{left} {head}H{right}" stroke="#1f3a5f"/>
<text x="{middle}" y="{title_y}" font-family="sans-serif" font-size="18" text-anchor="middle" fill="#1f3a5f">{name}</text>
<g font-family="monospace" font-size="{FONT}">
"##,
        width = coordinate(width),
        height = coordinate(height),
        name = escape(&interface.name),
        left = coordinate(left),
        right = coordinate(right),
        box_width = coordinate(box_width),
        box_height = coordinate(box_height),
        head = coordinate(MARGIN + HEAD - 10.0),
        middle = coordinate(left + box_width / 2.0),
        title_y = coordinate(MARGIN + 21.0),
    );
    let mut y = MARGIN + HEAD + ROW / 2.0;
    for row in &inputs {
        terminal(&mut svg, row, Side::Left { x: left }, y, &label(row), "#1f3a5f");
        y += ROW;
    }
    y += gap;
    for row in &parameters {
        terminal(&mut svg, row, Side::Left { x: left }, y, &start(row), "#8a97a8");
        y += ROW;
    }
    y = MARGIN + HEAD + ROW / 2.0;
    for row in &outputs {
        terminal(&mut svg, row, Side::Right { x: right }, y, &label(row), "#1f3a5f");
        y += ROW;
    }
    svg.push_str("</g>\n</svg>\n");
    svg
}

/// The edge of the box that a terminal is at.
enum Side {
    Left { x: f64 },
    Right { x: f64 },
}

/// A wire that ends at the box, the terminal's name inside, a label outside.
fn terminal(svg: &mut String, row: &Row, side: Side, y: f64, label: &str, color: &str) {
    let (edge, direction, inside, outside) = match side {
        Side::Left { x } => (x, -1.0, "start", "end"),
        Side::Right { x } => (x, 1.0, "end", "start"),
    };
    let _ = writeln!(
        svg,
        r##"<g><title>{description}</title><path d="M{from} {y}H{edge}" stroke="{color}" stroke-width="{stroke}"/><text x="{name_x}" y="{text_y}" text-anchor="{inside}" fill="#111827">{name}</text><text x="{label_x}" y="{text_y}" text-anchor="{outside}" fill="#5b6675">{label}</text></g>"##,
        description = escape(&row.description),
        from = coordinate(edge + direction * STUB),
        edge = coordinate(edge),
        y = coordinate(y),
        // As in function block diagrams: a bit is a thin wire, a number a thick one.
        stroke = if row.kind == Kind::Bool { 1 } else { 2 },
        name_x = coordinate(edge - direction * 7.0),
        text_y = coordinate(y + FONT * 0.34),
        name = escape(&row.name),
        label_x = coordinate(edge + direction * (STUB + 5.0)),
        label = escape(label),
    );
}

fn widest(texts: impl Iterator<Item = String>) -> f64 {
    texts.map(|text| text.chars().count() as f64 * CHARACTER).fold(0.0, f64::max)
}

/// Type and unit of a signal.
fn label(row: &Row) -> String {
    match &row.unit {
        Some(unit) => format!("{} {unit}", row.kind.name()),
        None => row.kind.name().to_string(),
    }
}

/// The start value of a setting.
fn start(row: &Row) -> String {
    text::value(row, row.start)
}
