//! The colours of curves: those of one file, which pages, the site, the parameter tool and Python read too.

/// The file, as a style sheet with a variable for each colour on light and on dark paper.
pub const STYLE: &str = include_str!("../../plcfmu/python/plcfmu/palette.css");

/// A colour on light paper by its variable without `--` and `-light`, such as `curve-1`. A name that is not in the file is an error
/// of the compiler where this gives a constant.
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

/// Whether a text is at a place of another.
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
/// What is neither, and limits.
pub const INK: &str = color("curve-7");
