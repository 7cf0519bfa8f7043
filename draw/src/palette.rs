//! The colours of curves, from a file that is shared with the pages, the site, the parameter tool and Python.

/// The style sheet with a variable for each colour on a light and on a dark background.
pub const STYLE: &str = include_str!("../../plcfmu/python/plcfmu/palette.css");

/// The light-background colour of a style sheet variable, named without `--` and `-light`, such as `curve-1`. In a
/// constant, an unknown name is a compile error.
pub const fn color(name: &str) -> &'static str {
    let (text, name) = (STYLE.as_bytes(), name.as_bytes());
    let end = b"-light: ";
    let mut at = 2;
    while at + name.len() + end.len() < text.len() {
        if text[at - 1] == b'-' && text[at - 2] == b'-' && is_at(text, at, name) && is_at(text, at + name.len(), end) {
            return STYLE.split_at(at + name.len() + end.len()).1.split_at("#rrggbb".len()).0;
        }
        at += 1;
    }
    panic!("the palette has no such colour")
}

/// Whether `text` contains `wanted` at this position.
const fn is_at(text: &[u8], at: usize, wanted: &[u8]) -> bool {
    let mut same = 0;
    while same < wanted.len() && at + same < text.len() && text[at + same] == wanted[same] {
        same += 1;
    }
    same == wanted.len()
}

/// The colour of the process value.
pub const PROCESS_VALUE: &str = color("curve-1");
/// The colour of the manipulated value.
pub const MANIPULATED_VALUE: &str = color("curve-2");
/// The colour of limits, and of anything other than these two signals.
pub const INK: &str = color("curve-7");
