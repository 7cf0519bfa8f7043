//! A cache for values derived from settings.

use blocks::table::abreast::Lane;
use blocks::{LReal, Stored};

/// A value computed from numbers and recomputed only when one of them has changed: for functions such as `exp` of
/// settings, which rarely change during a run.
///
/// It always equals the recomputed value, so it is not part of a saved state: after a state has been restored, it is
/// recomputed on its next use.
///
/// ```
/// use plants::dynamics::{Kept, exp};
///
/// let mut decay = Kept::default();
/// assert_eq!(decay.get_or_compute([-2.0], |[x]| exp(x)), exp(-2.0));
/// assert_eq!(decay.get_or_compute([-2.0], |_| unreachable!("nothing has changed")), exp(-2.0));
/// assert_eq!(decay.get_or_compute([-3.0], |[x]| exp(x)), exp(-3.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Kept<const N: usize, T> {
    from: [LReal; N],
    value: T,
    /// Whether a value has been computed.
    is_there: bool,
    /// Whether the cache is in a lane. There it computes nothing; [`Lane::is_steady`] reports afterwards whether its
    /// value was the one for the given numbers.
    is_in_lane: bool,
    /// Whether the value was needed in a lane but was not the one for the given numbers.
    is_stale: bool,
}

impl<const N: usize, T: Copy> Kept<N, T> {
    /// Returns the result of `compute` for these numbers. `compute` is a plain function, so it depends on nothing else;
    /// always pass the same function for a given instance.
    #[inline(always)]
    pub fn get_or_compute(&mut self, numbers: [LReal; N], compute: fn([LReal; N]) -> T) -> T {
        self.get_if(true, numbers, compute).unwrap_or(self.value)
    }

    /// Like [`Kept::get_or_compute`] if the value `is_needed`; otherwise returns `None` or an arbitrary value.
    #[inline(always)]
    pub(super) fn get_if(&mut self, is_needed: bool, numbers: [LReal; N], compute: fn([LReal; N]) -> T) -> Option<T> {
        if self.is_in_lane {
            // No branch, so that the compiler can vectorize it.
            let is_kept = (0..N).fold(self.is_there, |is_kept, place| is_kept & self.is_same(place, numbers));
            self.is_stale |= is_needed & !is_kept;
            return Some(self.value);
        }
        if !is_needed {
            return None;
        }
        let is_kept = self.is_there && (0..N).all(|place| self.is_same(place, numbers));
        Some(if is_kept { self.value } else { self.compute(numbers, compute) })
    }

    /// Returns the value for the last numbers, if there were any.
    #[inline(always)]
    pub fn last(&self) -> Option<T> {
        self.is_there.then_some(self.value)
    }

    #[inline(always)]
    fn is_same(&self, place: usize, numbers: [LReal; N]) -> bool {
        // Bitwise comparison: NaN equals itself, and -0 differs from 0.
        self.from[place].to_bits() == numbers[place].to_bits()
    }

    #[cold]
    fn compute(&mut self, numbers: [LReal; N], compute: fn([LReal; N]) -> T) -> T {
        let value = compute(numbers);
        *self = Kept { from: numbers, value, is_there: true, ..*self };
        value
    }
}

impl<const N: usize, T: Default> Default for Kept<N, T> {
    /// Creates an empty cache.
    fn default() -> Self {
        Kept { from: [0.0; N], value: T::default(), is_there: false, is_in_lane: false, is_stale: false }
    }
}

/// The cache is derived data and ignored when blocks are compared.
impl<const N: usize, T> PartialEq for Kept<N, T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<const N: usize, T: Default> Stored for Kept<N, T> {
    fn write(&self, _bytes: &mut Vec<u8>) {}

    fn read(_bytes: &mut &[u8]) -> Option<Self> {
        Some(Kept::default())
    }
}

/// A call that needs a value not yet computed is not steady.
impl<const N: usize, T: Copy + Lane> Lane for Kept<N, T> {
    type Lanes = (<[LReal; N] as Lane>::Lanes, T::Lanes, <bool as Lane>::Lanes);

    fn lanes() -> Self::Lanes {
        (<[LReal; N]>::lanes(), T::lanes(), bool::lanes())
    }

    fn put(self, (from, value, is_there): &mut Self::Lanes, lane: usize) {
        self.from.put(from, lane);
        self.value.put(value, lane);
        self.is_there.put(is_there, lane);
    }

    fn take(lanes: &mut Self::Lanes, lane: usize) -> Self {
        Kept { is_in_lane: false, ..Self::load(lanes, lane) }
    }

    #[inline(always)]
    fn load((from, value, is_there): &Self::Lanes, lane: usize) -> Self {
        let is_there = Lane::load(is_there, lane);
        let (from, value) = (Lane::load(from, lane), Lane::load(value, lane));
        Kept { from, value, is_there, is_in_lane: true, is_stale: false }
    }

    #[inline(always)]
    fn is_steady(&self) -> bool {
        !self.is_stale
    }

    #[inline(always)]
    fn store(self, _lanes: &mut Self::Lanes, _lane: usize, _is_steady: bool) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_value_is_computed_again_when_any_bit_of_a_number_has_changed() {
        let mut kept = Kept::default();
        let sign_of_first = |[first, _]: [LReal; 2]| first.signum();
        assert_eq!(kept.get_or_compute([0.0, 1.0], sign_of_first), 1.0);
        assert_eq!(kept.get_or_compute([-0.0, 1.0], sign_of_first), -1.0);
        assert!(kept.get_or_compute([LReal::NAN, 1.0], sign_of_first).is_nan());
        assert_eq!(kept.get_or_compute([LReal::NAN, 2.0], |_| 7.0), 7.0);
        assert_eq!(kept.get_or_compute([LReal::NAN, 2.0], |_| 8.0), 7.0, "nothing has changed");
    }

    #[test]
    fn a_kept_value_is_no_part_of_a_saved_state() {
        let (mut kept, mut bytes) = (Kept::default(), vec![]);
        kept.get_or_compute([1.0], |[x]| x);
        kept.write(&mut bytes);
        assert!(bytes.is_empty());
        assert_eq!(
            Kept::read(&mut &bytes[..]).map(|mut read: Kept<1, LReal>| read.get_or_compute([1.0], |_| 2.0)),
            Some(2.0)
        );
    }
}
