//! Blocks of one kind that are called together, one for each of several runs with different values.
//!
//! A `Vec` stores them block by block. [`Lanes`] stores them variable by variable (structure of arrays), so that the
//! compiler turns a loop over [`LANES`] calls into vector instructions (SIMD). The law itself is not rewritten: the
//! compiler vectorizes it across the blocks. Vector instructions add, multiply and divide each number as scalar ones do
//! (IEEE 754), so the results are identical to the last bit.
//!
//! This pays off if the law consists of arithmetic and conditions, without loops over memory and with all functions
//! inlined: [`for_each_in_lanes`](crate::for_each_in_lanes) lists these blocks; others are slower in lanes. A call that
//! occasionally does more, such as recomputing an exponential after a setting has changed, skips that work and reports
//! it ([`Lane::is_steady`]); the block is then called separately.

use crate::table::number::{number, to_value};
use crate::table::{Block, Time, Word};
use std::array::from_fn;

/// The maximum number of blocks in lanes: two vector registers of 256 bits hold this many REALs.
pub const LANES: usize = 16;

/// Blocks that are called together.
pub trait Abreast<B>: Sized + 'static {
    /// Groups blocks, at most [`LANES`].
    fn from_blocks(blocks: Vec<B>) -> Self;

    /// Returns the blocks in their original order.
    fn into_blocks(self) -> Vec<B>;

    /// Calls each block.
    fn each(&mut self, call: impl Fn(&mut B));

    /// Returns the function that reads the numbers in row `index`, converted by [`number`]; `None` if the row cannot be
    /// read this way.
    fn reader(index: usize) -> Option<Reader<Self>>;

    /// Returns the function that writes numbers to row `index`, whatever its role, converted by [`to_value`]; `None` if
    /// the row cannot be written this way.
    fn writer(index: usize) -> Option<Writer<Self>>;
}

/// Reads a number from each block of a group.
pub type Reader<G> = Box<dyn Fn(&G, &mut [f64])>;

/// Writes a number to each block of a group. Returns false if a number is out of range: that block and the ones after
/// it may then have any value.
pub type Writer<G> = Box<dyn Fn(&mut G, &[f64]) -> bool>;

impl<B: Block> Abreast<B> for Vec<B> {
    fn from_blocks(blocks: Vec<B>) -> Vec<B> {
        blocks
    }

    fn into_blocks(self) -> Vec<B> {
        self
    }

    #[inline(always)]
    fn each(&mut self, call: impl Fn(&mut B)) {
        self.iter_mut().for_each(call);
    }

    fn reader(index: usize) -> Option<Reader<Vec<B>>> {
        let read = move |blocks: &Vec<B>, numbers: &mut [f64]| {
            blocks.iter().zip(numbers).for_each(|(block, to)| *to = block.get(index).map_or(f64::NAN, number));
        };
        (index < B::TABLE.rows.len()).then(|| Box::new(read) as _)
    }

    fn writer(index: usize) -> Option<Writer<Vec<B>>> {
        let kind = B::TABLE.rows.get(index)?.kind;
        let set = move |block: &mut B, number| to_value(number, kind).is_ok_and(|value| block.set(index, value));
        Some(Box::new(move |blocks, numbers| blocks.iter_mut().zip(numbers).all(|(block, to)| set(block, *to))))
    }
}

/// A block that can be stored in lanes, as can its memory.
pub trait InLanes: Block + Lane {
    /// Returns the function of [`Abreast::reader`]; `None` for a row of an inner block.
    fn reader(index: usize) -> Option<ReadLanes<Self>>;

    /// Returns the function of [`Abreast::writer`]; `None` for a row of an inner block and for the mean.
    fn writer(index: usize) -> Option<WriteLanes<Self>>;
}

/// A [`Reader`] of lanes.
pub type ReadLanes<B> = fn(&Lanes<B>, &mut [f64]);

/// A [`Writer`] of lanes.
pub type WriteLanes<B> = fn(&mut Lanes<B>, &[f64]) -> bool;

/// An operation on each block that is faster in lanes, for [`for_each_in_lanes`](crate::for_each_in_lanes).
pub trait EachInLanes {
    /// Performs the operation on one block.
    fn block<B: InLanes>(&mut self);
}

/// A value that can be stored in lanes.
pub trait Lane: Sized {
    /// The storage for all lanes.
    type Lanes;

    /// Creates empty lanes.
    fn lanes() -> Self::Lanes;

    /// Stores the value in a lane.
    fn put(self, lanes: &mut Self::Lanes, lane: usize);

    /// Takes the value out of a lane.
    #[inline(always)]
    fn take(lanes: &mut Self::Lanes, lane: usize) -> Self {
        Self::load(lanes, lane)
    }

    /// Loads the parts of the value that a steady call needs.
    fn load(lanes: &Self::Lanes, lane: usize) -> Self;

    /// Whether the last call was complete: it skipped none of the work that is only occasionally needed.
    #[inline(always)]
    fn is_steady(&self) -> bool {
        true
    }

    /// Stores the parts that a call may have changed, if the call was steady.
    fn store(self, lanes: &mut Self::Lanes, lane: usize, is_steady: bool);

    /// Completes the work that a steady call defers, lane by lane.
    #[inline(always)]
    fn settle(_lanes: &mut Self::Lanes, _lane: usize) {}
}

macro_rules! lane_of_numbers {
    ($( $Type:ty as $Number:ty: $value:ident => $into:expr, $number:ident => $from:expr; )*) => { $(
        impl Lane for $Type {
            type Lanes = [$Number; LANES];

            fn lanes() -> Self::Lanes {
                [Default::default(); LANES]
            }

            #[inline(always)]
            fn put(self, lanes: &mut Self::Lanes, lane: usize) {
                let $value = self;
                lanes[lane] = $into;
            }

            #[inline(always)]
            fn load(lanes: &Self::Lanes, lane: usize) -> Self {
                let $number = lanes[lane];
                $from
            }

            #[inline(always)]
            fn store(self, lanes: &mut Self::Lanes, lane: usize, is_steady: bool) {
                // Written unconditionally, so that the compiler can vectorize it.
                let before = Self::load(lanes, lane);
                (if is_steady { self } else { before }).put(lanes, lane);
            }
        }
    )* };
}

// Narrow types are stored in 32 bits: a vector of conditions is then as wide as the REALs that it selects.
lane_of_numbers! {
    f32 as f32: value => value, number => number;
    f64 as f64: value => value, number => number;
    i32 as i32: value => value, number => number;
    u32 as u32: value => value, number => number;
    usize as usize: value => value, number => number;
    bool as u32: value => u32::from(value), number => number != 0;
    i16 as i32: value => i32::from(value), number => number as i16;
    Time as i32: value => value.milliseconds(), number => Time::ms(number);
    Word as i32: value => i32::from(value.value()), number => Word::new(number as i16);
}

impl<T: Lane, const N: usize> Lane for [T; N] {
    type Lanes = [T::Lanes; N];

    fn lanes() -> Self::Lanes {
        from_fn(|_| T::lanes())
    }

    #[inline(always)]
    fn put(self, lanes: &mut Self::Lanes, lane: usize) {
        lanes.iter_mut().zip(self).for_each(|(lanes, value)| value.put(lanes, lane));
    }

    #[inline(always)]
    fn take(lanes: &mut Self::Lanes, lane: usize) -> Self {
        from_fn(|place| T::take(&mut lanes[place], lane))
    }

    #[inline(always)]
    fn load(lanes: &Self::Lanes, lane: usize) -> Self {
        from_fn(|place| T::load(&lanes[place], lane))
    }

    #[inline(always)]
    fn is_steady(&self) -> bool {
        self.iter().fold(true, |is_steady, value| is_steady & value.is_steady())
    }

    #[inline(always)]
    fn store(self, lanes: &mut Self::Lanes, lane: usize, is_steady: bool) {
        lanes.iter_mut().zip(self).for_each(|(lanes, value)| value.store(lanes, lane, is_steady));
    }

    #[inline(always)]
    fn settle(lanes: &mut Self::Lanes, lane: usize) {
        lanes.iter_mut().for_each(|lanes| T::settle(lanes, lane));
    }
}

/// Implements [`Lane`] for a struct, field by field. Of the rows of a block, `[section] field: Type`, only outputs and
/// locals are stored after a call. With `where [Type, ...]`, the implementation applies only if these types implement
/// [`Lane`] too. The lifetime `'always` in these conditions prevents Rust from rejecting one that is never met.
#[macro_export]
macro_rules! lane {
    ($Struct:ident $(where [$($Part:ty),* $(,)?])? { $( $([$section:ident])? $field:ident: $Type:ty ),* $(,)? }) => {
        const _: () = {
            use $crate::table::abreast::Lane;

            /// The lanes of each field.
            #[allow(unreachable_pub)]
            pub struct Lanes $(where $(for<'always> $Part: Lane,)*)? { $(
                /// The lanes of the field with this name.
                pub $field: <$Type as Lane>::Lanes,
            )* }

            impl Lane for $Struct $(where $(for<'always> $Part: Lane,)*)? {
                type Lanes = Lanes;

                fn lanes() -> Lanes {
                    Lanes { $( $field: <$Type as Lane>::lanes(), )* }
                }

                #[inline(always)]
                fn put(self, lanes: &mut Lanes, lane: usize) {
                    $( <$Type as Lane>::put(self.$field, &mut lanes.$field, lane); )*
                }

                #[inline(always)]
                fn take(lanes: &mut Lanes, lane: usize) -> Self {
                    $Struct { $( $field: <$Type as Lane>::take(&mut lanes.$field, lane), )* }
                }

                #[inline(always)]
                fn load(lanes: &Lanes, lane: usize) -> Self {
                    $Struct { $( $field: <$Type as Lane>::load(&lanes.$field, lane), )* }
                }

                #[inline(always)]
                fn is_steady(&self) -> bool {
                    true $( & <$Type as Lane>::is_steady(&self.$field) )*
                }

                #[inline(always)]
                fn store(self, lanes: &mut Lanes, lane: usize, is_steady: bool) {
                    $( $crate::lane!(@store $($section)? $Type, self.$field, &mut lanes.$field, lane, is_steady); )*
                }

                #[inline(always)]
                fn settle(lanes: &mut Lanes, lane: usize) {
                    $( <$Type as Lane>::settle(&mut lanes.$field, lane); )*
                }
            }
        };
    };
    (@store input $($rest:tt)*) => {};
    (@store parameter $($rest:tt)*) => {};
    (@store fixed $($rest:tt)*) => {};
    (@store cycle $($rest:tt)*) => {};
    (@store output $($rest:tt)*) => { $crate::lane!(@store $($rest)*) };
    (@store local $($rest:tt)*) => { $crate::lane!(@store $($rest)*) };
    (@store $Type:ty, $($arguments:expr),*) => { <$Type as Lane>::store($($arguments),*) };
}

/// Blocks stored variable by variable.
pub struct Lanes<B: Lane> {
    lanes: B::Lanes,
    count: usize,
}

impl<B: InLanes> Abreast<B> for Lanes<B> {
    fn from_blocks(blocks: Vec<B>) -> Lanes<B> {
        let (mut lanes, count) = (B::lanes(), blocks.len());
        assert!(count <= LANES, "more blocks than lanes");
        blocks.into_iter().enumerate().for_each(|(lane, block)| block.put(&mut lanes, lane));
        Lanes { lanes, count }
    }

    fn into_blocks(mut self) -> Vec<B> {
        (0..self.count).map(|lane| B::take(&mut self.lanes, lane)).collect()
    }

    #[inline(always)]
    fn each(&mut self, call: impl Fn(&mut B)) {
        let mut steady = bool::lanes();
        // Runs over all lanes, because the compiler needs a fixed count; the contents after the last block are ignored.
        for lane in 0..LANES {
            let mut block = B::load(&self.lanes, lane);
            call(&mut block);
            let is_steady = block.is_steady();
            block.store(&mut self.lanes, lane, is_steady);
            is_steady.put(&mut steady, lane);
        }
        for lane in 0..self.count {
            if bool::load(&steady, lane) {
                B::settle(&mut self.lanes, lane);
            } else {
                let mut block = B::take(&mut self.lanes, lane);
                call(&mut block);
                block.put(&mut self.lanes, lane);
            }
        }
    }

    fn reader(index: usize) -> Option<Reader<Lanes<B>>> {
        B::reader(index).map(|read| Box::new(read) as _)
    }

    fn writer(index: usize) -> Option<Writer<Lanes<B>>> {
        B::writer(index).map(|write| Box::new(write) as _)
    }
}

impl<B: Lane> Lanes<B> {
    /// Reads a variable of each block as a number.
    #[inline(always)]
    pub fn read<T: Lane>(
        &self,
        numbers: &mut [f64],
        field: impl Fn(&B::Lanes) -> &T::Lanes,
        number: impl Fn(T) -> f64,
    ) {
        let lanes = field(&self.lanes);
        for (lane, to) in numbers.iter_mut().enumerate().take(LANES) {
            *to = number(T::load(lanes, lane));
        }
    }

    /// Writes a variable of each block; returns false if a number cannot be converted.
    #[inline(always)]
    pub fn write<T: Lane + Default>(
        &mut self,
        numbers: &[f64],
        field: impl Fn(&mut B::Lanes) -> &mut T::Lanes,
        value: impl Fn(f64) -> Option<T>,
    ) -> bool {
        let (lanes, mut all) = (field(&mut self.lanes), true);
        // Without an early exit, which would prevent vectorization.
        for (lane, number) in numbers.iter().enumerate().take(LANES) {
            let value = value(*number);
            all &= value.is_some();
            value.unwrap_or_default().put(lanes, lane);
        }
        all
    }
}
