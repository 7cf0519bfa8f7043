//! Messages in addition to a command's results: errors, warnings, remarks and notes, on standard error.

use crate::exit::{Differs, Wrong};
use anyhow::Error;
use clap::builder::styling::{AnsiColor, Style};
use parameters::problem::each_drawn;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use study::Interrupted;

/// Whether only results and errors are printed.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// The help heading of these options, after those of the command.
const HEADING: &str = "Output";

/// Which messages are printed, and whether they are coloured.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Options {
    /// Print results and errors only: no warnings, remarks, notes and progress
    #[arg(short, long, global = true, help_heading = HEADING)]
    quiet: bool,
    /// Colour of messages on a terminal; auto follows NO_COLOR and CLICOLOR
    #[arg(long, global = true, value_name = "WHEN", default_value_t, help_heading = HEADING)]
    color: clap::ColorChoice,
}

impl Options {
    /// Applies the options to all subsequent messages.
    pub fn apply(self) {
        IS_QUIET.store(self.quiet, Ordering::Relaxed);
        let color = match self.color {
            clap::ColorChoice::Auto => anstream::ColorChoice::Auto,
            clap::ColorChoice::Always => anstream::ColorChoice::Always,
            clap::ColorChoice::Never => anstream::ColorChoice::Never,
        };
        color.write_global();
    }
}

/// Whether warnings, remarks, notes and progress are suppressed.
pub fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

/// Prints an error: for problems of a file, a line for each; for an interruption, its text alone; otherwise, one line
/// with all causes. Prints nothing for [`Differs`], since the differences have already been printed.
pub fn error(error: &Error) {
    if let Some(Wrong(problems)) = error.downcast_ref() {
        each_drawn(problems).for_each(|problem| line("error", AnsiColor::Red, &problem));
    } else if error.is::<Interrupted>() {
        raw(&format!("{error}\n"));
    } else if !error.is::<Differs>() {
        line("error", AnsiColor::Red, &format!("{error:#}"));
    }
}

/// Prints a warning: something is probably not as intended.
pub fn warning(text: &str) {
    beside("warning", AnsiColor::Yellow, text);
}

/// Prints a remark: something may surprise the user.
pub fn remark(text: &str) {
    beside("remark", AnsiColor::Cyan, text);
}

/// Prints a note: something was done differently from what a user might expect, and why.
pub fn note(text: &str) {
    beside("note", AnsiColor::Cyan, text);
}

/// Prints a line of text without a kind, such as a message logged by an FMU.
pub fn text(text: &str) {
    if !is_quiet() {
        raw(&format!("{}\n", plain(text)));
    }
}

/// Prints text on standard error. If nobody reads it any more, such as after `2>&1 | head`, the command goes on.
pub fn raw(text: &str) {
    let _ = anstream::stderr().write_all(text.as_bytes());
}

fn beside(kind: &str, color: AnsiColor, text: &str) {
    if !is_quiet() {
        line(kind, color, text);
    }
}

fn line(kind: &str, color: AnsiColor, text: &str) {
    let style = Style::new().bold().fg_color(Some(color.into()));
    raw(&format!("{style}{kind}:{style:#} {}\n", shortened(&plain(text.trim_end()))));
}

/// Shortens words of more than 5000 bytes, such as a name in a damaged file, to 200 characters. No path is that long.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 5000;
    const KEPT: usize = 200;
    let cut = |piece: &str| match piece.char_indices().nth(KEPT) {
        Some((end, _)) if piece.len() > LONGEST => {
            let rest = piece.trim_end();
            format!("{}… ({} characters){}", &piece[..end], rest.chars().count(), &piece[rest.len()..])
        }
        _ => piece.to_string(),
    };
    text.split_inclusive(char::is_whitespace).map(cut).collect()
}

/// Replaces characters that a terminal interprets as commands with escape sequences. Line breaks and tabs are kept.
pub fn plain(text: &str) -> String {
    let is_order = |c: char| {
        c.is_control() && c != '\n' && c != '\t'
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let shown = |c: char| if is_order(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_that_nobody_reads_to_its_end_is_cut() {
        let path = format!("{} cannot be read\n", "/folder".repeat(600));
        assert_eq!(shortened(&path), path);
        let long = format!("unknown name \"{}\" here", "ä".repeat(100_000));
        assert_eq!(shortened(&long), format!("unknown name \"{}… (100002 characters) here", "ä".repeat(199)));
    }

    #[test]
    fn orders_for_a_terminal_are_shown() {
        assert_eq!(plain("a\u{1b}[31mred\u{9b}\u{202e} µ\n\tb"), "a\\u{1b}[31mred\\u{9b}\\u{202e} µ\n\tb");
    }
}
