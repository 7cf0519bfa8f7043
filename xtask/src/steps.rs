//! The steps of a long command, so that whoever waits sees which of how many it is at.

use plcfmu::command::heading;

/// The steps of a command.
#[derive(Debug)]
pub struct Steps {
    begun: usize,
    count: usize,
}

impl Steps {
    /// So many steps are to come.
    pub fn new(count: usize) -> Steps {
        Steps { begun: 0, count }
    }

    /// The next step begins.
    pub fn begin(&mut self, step: &str) {
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
