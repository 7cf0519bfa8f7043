//! The icon of a block for small spaces: a symbol and the name, legible at 64 pixels.

use super::model::Icon;
use super::read;
use super::symbol::Symbol;
use crate::svg::Pixels;
use anyhow::Result;
use askama::Template;
use modeldescription::Table;

/// The width and height of the drawing in pixels.
const SIZE: f64 = 128.0;
/// The width of the left and right borders together, in pixels.
const BORDER: f64 = 24.0;
/// The width of a character in a monospaced font, relative to the font size.
const CHARACTER: f64 = 0.602;
/// The maximum number of characters of a name on one line; longer names are split at an underscore if possible.
const LONGEST: usize = 8;

#[derive(Template)]
#[template(path = "icon.svg")]
struct Drawing<'a> {
    name: &'a str,
    lines: Vec<(Pixels, &'a str)>,
    font_size: Pixels,
    symbol: Option<&'static Symbol>,
    /// The vertical position of the middle of the symbol.
    symbol_y: Pixels,
    /// The magnification of the symbol.
    scale: f64,
    text: &'a str,
    text_y: Pixels,
    text_size: Pixels,
}

/// Renders the icon as SVG.
///
/// # Errors
/// The description of the block's diagram is faulty.
pub fn svg(table: &Table) -> Result<String> {
    let icon = read(table)?.and_then(|checked| checked.diagram.icon);
    let (symbol, text) = match icon {
        Some(Icon::Symbol(symbol)) => (Some(symbol), String::new()),
        Some(Icon::Text(text)) => (None, text),
        None => (None, table.name.chars().take(3).collect()),
    };
    let lines = lines(&table.name);
    let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(1);
    // Two lines leave less space for the symbol.
    let (first, most, symbol_y, scale) =
        if lines.len() == 1 { (109.0, 27.0, 45.0, 2.3) } else { (86.0, 24.0, 36.0, 2.0) };
    let drawing = Drawing {
        name: &table.name,
        lines: lines.iter().enumerate().map(|(row, line)| (Pixels(first + row as f64 * 27.0), *line)).collect(),
        font_size: Pixels(size(longest, most)),
        symbol,
        symbol_y: Pixels(symbol_y),
        scale,
        text: &text,
        text_y: Pixels(symbol_y + 17.0),
        text_size: Pixels(size(text.chars().count(), 20.0 * scale)),
    };
    Ok(drawing.render()?)
}

/// The largest font size in pixels at which this many characters fit, at most `most`.
fn size(characters: usize, most: f64) -> f64 {
    ((SIZE - BORDER) / (characters.max(1) as f64 * CHARACTER)).min(most)
}

/// The lines of a name: one, or two if it is long and contains an underscore.
fn lines(name: &str) -> Vec<&str> {
    let middle = name.len() / 2;
    let parts = name.match_indices('_').map(|(place, _)| place);
    match parts.min_by_key(|place| place.abs_diff(middle)) {
        Some(place) if name.chars().count() > LONGEST => vec![&name[..=place], &name[place + 1..]],
        _ => vec![name],
    }
}
