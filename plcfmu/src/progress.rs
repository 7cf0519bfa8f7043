//! Shows progress on standard error if it is a terminal. Otherwise, only permanent lines are written.

use crate::tell;
use indicatif::{HumanFloatCount, ProgressBar, ProgressState, ProgressStyle};
use std::fmt;
use std::io::{IsTerminal, stderr};
use std::time::Duration;

/// A bar or a spinner that disappears when it is dropped.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A spinner for work of unknown length. Without a terminal, the text is written as a line.
    pub fn spinner(text: &str) -> Progress {
        if !stderr().is_terminal() {
            tell::text(text);
        }
        let bar = if tell::is_quiet() { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        bar.set_message(text.to_string());
        bar.enable_steady_tick(Duration::from_millis(100));
        Progress { bar }
    }

    /// A bar for `length` items.
    pub fn bar(length: usize) -> Progress {
        Progress::styled(length, "{bar:30} {pos}/{len} {msg}")
    }

    /// A bar for `length` steps, with the remaining time.
    pub fn steps(length: usize) -> Progress {
        Progress::styled(length, "{bar:30} {percent:>3} %  {pos}/{len} steps, {eta} left")
    }

    /// A bar for `length` candidates of a search, with the remaining time and the text of [`Progress::begin`].
    pub fn candidates(length: usize) -> Progress {
        Progress::styled(length, "{bar:30} {pos}/{len} candidates, {eta} left, {msg}")
    }

    /// A bar for `length` runs of `cycles` control cycles each, of which `done` runs are already finished, with the
    /// rates of both and the remaining time.
    pub fn runs(length: u64, done: u64, cycles: usize) -> Progress {
        let rate = move |state: &ProgressState, to: &mut dyn fmt::Write| {
            // A failed write to the terminal can be ignored.
            let _ = write!(to, "{}", HumanFloatCount((state.per_sec() * cycles as f64).round()));
        };
        let runs_rate = |state: &ProgressState, to: &mut dyn fmt::Write| {
            let _ = write!(to, "{}", rate_of(state.per_sec()));
        };
        let template =
            "{bar:30} {percent:>3} %  {human_pos}/{human_len} runs, {rate}, {cycles} control cycles/s, {eta} left";
        let bar = Progress::new_bar(length);
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("cycles", rate).with_key("rate", runs_rate));
        }
        bar.set_position(done);
        bar.reset_eta();
        Progress { bar }
    }

    fn new_bar(length: u64) -> ProgressBar {
        if tell::is_quiet() { ProgressBar::hidden() } else { ProgressBar::new(length) }
    }

    fn styled(length: usize, template: &str) -> Progress {
        let bar = Progress::new_bar(length as u64);
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// Shows a text about the current item.
    pub fn begin(&self, text: &str) {
        self.bar.set_message(text.to_string());
        self.bar.tick();
    }

    /// Counts one finished item.
    pub fn done(&self) {
        self.bar.inc(1);
    }

    /// Sets the number of finished items.
    pub fn set(&self, done: usize) {
        self.bar.set_position(done as u64);
    }

    /// Writes a permanent line above the bar.
    pub fn line(&self, text: &str) {
        self.bar.suspend(|| println!("{text}"));
    }
}

/// A rate: a whole number, or one decimal below 10 per second.
fn rate_of(per_second: f64) -> String {
    if per_second >= 10.0 { format!("{}/s", HumanFloatCount(per_second.round())) } else { format!("{per_second:.1}/s") }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_has_no_digits_that_nobody_reads() {
        assert_eq!([2663.8913, 25.49, 0.3].map(rate_of), ["2,664/s", "25/s", "0.3/s"]);
    }
}
