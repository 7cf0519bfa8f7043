//! What follows from settings, kept from call to call.

use blocks::{LReal, Stored};

/// A value that is computed from numbers, and computed again only when one of them has changed: for `exp` and the like of
/// settings, which stay the same for most of a run.
///
/// It never differs from the value computed anew, so it is not part of a saved state: read back, it is computed again when
/// it is next asked for.
///
/// ```
/// use plants::dynamics::{Kept, exp};
///
/// let mut decay = Kept::default();
/// assert_eq!(decay.of([-2.0], |[x]| exp(x)), exp(-2.0));
/// assert_eq!(decay.of([-2.0], |_| unreachable!("nothing has changed")), exp(-2.0));
/// assert_eq!(decay.of([-3.0], |[x]| exp(x)), exp(-3.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Kept<const N: usize, T> {
    from: [LReal; N],
    value: Option<T>,
}

impl<const N: usize, T: Copy> Kept<N, T> {
    /// The value that `compute` gives for these numbers. It is a plain function, so that it depends on nothing else; ask one
    /// kept value always with the same.
    #[inline(always)]
    pub fn of(&mut self, numbers: [LReal; N], compute: fn([LReal; N]) -> T) -> T {
        // By their bits, NaN is equal to itself, and -0 differs from 0.
        let is_same = (0..N).all(|place| self.from[place].to_bits() == numbers[place].to_bits());
        match self.value {
            Some(value) if is_same => value,
            _ => self.compute(numbers, compute),
        }
    }

    #[cold]
    fn compute(&mut self, numbers: [LReal; N], compute: fn([LReal; N]) -> T) -> T {
        let value = compute(numbers);
        *self = Kept { from: numbers, value: Some(value) };
        value
    }
}

impl<const N: usize, T> Default for Kept<N, T> {
    /// Nothing is computed yet.
    fn default() -> Self {
        Kept { from: [0.0; N], value: None }
    }
}

/// What is kept follows from something else: of two things that differ in it alone, neither differs from the other.
impl<const N: usize, T> PartialEq for Kept<N, T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<const N: usize, T> Stored for Kept<N, T> {
    fn write(&self, _bytes: &mut Vec<u8>) {}

    fn read(_bytes: &mut &[u8]) -> Option<Self> {
        Some(Kept::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_value_is_computed_again_when_any_bit_of_a_number_has_changed() {
        let mut kept = Kept::default();
        let sign_of_first = |[first, _]: [LReal; 2]| first.signum();
        assert_eq!(kept.of([0.0, 1.0], sign_of_first), 1.0);
        assert_eq!(kept.of([-0.0, 1.0], sign_of_first), -1.0);
        assert!(kept.of([LReal::NAN, 1.0], sign_of_first).is_nan());
        assert_eq!(kept.of([LReal::NAN, 2.0], |_| 7.0), 7.0);
        assert_eq!(kept.of([LReal::NAN, 2.0], |_| 8.0), 7.0, "nothing has changed");
    }

    #[test]
    fn a_kept_value_is_no_part_of_a_saved_state() {
        let (mut kept, mut bytes) = (Kept::default(), vec![]);
        kept.of([1.0], |[x]| x);
        kept.write(&mut bytes);
        assert!(bytes.is_empty());
        assert_eq!(Kept::read(&mut &bytes[..]).map(|mut read: Kept<1, LReal>| read.of([1.0], |_| 2.0)), Some(2.0));
    }
}
