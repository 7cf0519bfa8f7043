//! The colours of curves, from one file that pages, the site, the parameter tool and Python also read.

/// The file: a style sheet with a variable for each colour on a light and on a dark background.
pub const STYLE: &str = include_str!("../../plcfmu/python/plcfmu/palette.css");

/// The colour on a light background of a variable, named without `--` and `-light`, such as `curve-1`. In a constant, a
/// name that is not in the file is a compile error.
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

/// Whether a text occurs at a position of another.
const fn is_at(text: &[u8], at: usize, wanted: &[u8]) -> bool {
    let mut same = 0;
    while same < wanted.len() && at + same < text.len() && text[at + same] == wanted[same] {
        same += 1;
    }
    same == wanted.len()
}

/// The process value.
pub const PROCESS_VALUE: &str = color("curve-1");
/// The manipulated value.
pub const MANIPULATED_VALUE: &str = color("curve-2");
/// The colour of limits, and of anything other than these signals.
pub const INK: &str = color("curve-7");
