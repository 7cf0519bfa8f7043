//! Progress of a long command: prints the number of the current step.

use plcfmu::command::heading;

/// The steps of a command.
#[derive(Debug)]
pub(crate) struct Steps {
    begun: usize,
    count: usize,
}

impl Steps {
    /// A counter for a command with `count` steps.
    pub(crate) fn new(count: usize) -> Steps {
        Steps { begun: 0, count }
    }

    /// Starts the next step and prints its heading.
    pub(crate) fn begin(&mut self, step: &str) {
        self.begun += 1;
        heading(&self.title(step));
    }

    fn title(&self, step: &str) -> String {
        format!("{} of {}: {step}", self.begun, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_says_its_place_among_all() {
        let mut steps = Steps::new(3);
        steps.begin("FMUs");
        steps.begin("loops");
        assert_eq!(steps.title("loops"), "2 of 3: loops");
    }
}
