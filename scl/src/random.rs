//! Random numbers that are the same on every machine, for the tapes of [`prove`](crate::prove) and for tests of laws.

/// The generator SplitMix64 (Steele, Lea, Flood).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Starts the sequence for a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// Returns an integer below `count`.
    pub fn below(&mut self, count: u64) -> u64 {
        (self.bits() >> 11) % count
    }

    /// Returns true with a probability of 1 in `count`.
    pub fn once_in(&mut self, count: u64) -> bool {
        self.below(count) == 0
    }

    /// Returns one of 2^24 equally spaced numbers from `-most` up to, but not including, `most`.
    pub fn real(&mut self, most: f32) -> f32 {
        (self.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0) * most
    }

    /// Returns one of several values.
    pub fn one_of<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u64) as usize]
    }
}
