//! Coordinates in drawings.

use std::fmt::{Display, Formatter, Result};

/// A coordinate or length in pixels, rounded to a hundredth when printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixels(pub f64);

impl Display for Pixels {
    fn fmt(&self, formatter: &mut Formatter) -> Result {
        // Adding 0 turns -0 into 0.
        write!(formatter, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        assert_eq!(Pixels(1.0 / 3.0).to_string(), "0.33");
        assert_eq!(Pixels(12.0).to_string(), "12");
        assert_eq!(Pixels(-0.001).to_string(), "0");
    }
}
