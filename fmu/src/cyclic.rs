//! The object that an instance calls every CYCLE: a block whose table is compiled in, or a program whose table is known
//! only at run time.

use crate::layout::Layout;
use blocks::{Block, LReal, Real, StaticTable, Stored, Table, TableText, Time, Value};

/// The start values of new instances of a block.
#[derive(Debug)]
pub enum StartValues<B> {
    /// The library's own. Creating a block from them in place is faster than copying one.
    Own,
    /// Those of a preset.
    Preset(Box<B>),
}

macro_rules! cyclic {
    ($( $(#[$doc:meta])* fn $this:ident.$name:ident($($receiver:tt)+) ($($argument:ident: $type:ty),*) $(-> $result:ty)? = $Trait:ident; )*) => {
        /// The object that an instance calls every CYCLE. Its variables are accessed by their row number in the table.
        /// Every [`Block`] implements this at no cost: calls are resolved at compile time, and the table is a constant.
        /// So does a PLC program read at run time, with its own table.
        ///
        /// A clone is a saved state.
        pub trait Cyclic: Clone + Send + 'static {
            /// Whether every call is certain to complete: true for a block, but not for a program, which may stop.
            const IS_SURE: bool = true;

            /// Whether the table has a `mean` row. A program's has none.
            const HAS_MEAN: bool = false;

            /// See [`blocks::Law::HOLDS_INPUTS`].
            const HOLDS_INPUTS: bool = false;

            /// The start values of new instances.
            type StartValues;

            /// The type of the strings in its table, which is compiled in or built at run time.
            type Text: TableText;

            /// A new object with these start values.
            fn new(start: &Self::StartValues) -> Self;
            /// The table.
            fn table(&self) -> &Table<Self::Text>;
            /// The arrays among the rows and texts; `None` if there are none. A block has none.
            fn layout(&self) -> Option<&Layout> {
                None
            }
            /// The reason why the program has stopped; `None` if it has not. After a stop, calls do nothing until the
            /// next restart.
            fn stopped(&self) -> Option<&str> {
                None
            }
            /// Takes the warnings accumulated since this was last called.
            fn take_warnings(&mut self) -> Vec<String> {
                Vec::new()
            }
            /// The text with this index in the table.
            fn text(&self, _number: usize) -> Option<String> {
                None
            }
            /// Writes a text, given as the code units returned by [`blocks::TextType::units`].
            fn set_text(&mut self, _number: usize, _units: &[u16]) {}
            /// Appends all values and the internal memory to `bytes`.
            fn store(&self, bytes: &mut Vec<u8>);
            /// Restores the object that [`Cyclic::store`] wrote and removes it from the front of `bytes`; `None` if
            /// `bytes` does not begin with one.
            fn restored(&self, bytes: &mut &[u8]) -> Option<Self>;
            $( $(#[$doc])* fn $name($($receiver)+, $($argument: $type),*) $(-> $result)?; )*
        }

        impl<B: Block> Cyclic for B {
            const HAS_MEAN: bool = B::TABLE.mean.is_some();

            const HOLDS_INPUTS: bool = <B as blocks::Law>::HOLDS_INPUTS;

            type StartValues = StartValues<B>;

            type Text = &'static str;

            #[inline(always)]
            fn new(start: &StartValues<B>) -> B {
                match start {
                    StartValues::Own => B::default(),
                    StartValues::Preset(block) => (**block).clone(),
                }
            }

            #[inline(always)]
            fn table(&self) -> &StaticTable {
                B::TABLE
            }

            fn store(&self, bytes: &mut Vec<u8>) {
                self.write(bytes);
            }

            fn restored(&self, bytes: &mut &[u8]) -> Option<Self> {
                <B as Stored>::read(bytes)
            }

            $(
                #[inline(always)]
                fn $name($($receiver)+, $($argument: $type),*) $(-> $result)? {
                    blocks::$Trait::$name($this, $($argument),*)
                }
            )*
        }
    };
}

cyclic! {
    /// The time between two calls.
    fn self.cycle(&self) () -> Time = Block;
    /// See [`Block::get`].
    fn self.get(&self) (row: usize) -> Option<Value> = Block;
    /// See [`Block::set`].
    fn self.set(&mut self) (row: usize, value: Value) -> bool = Block;
    /// See [`Block::real`].
    fn self.real(&self) (row: usize) -> Option<Real> = Block;
    /// See [`Block::real_mut`].
    fn self.real_mut(&mut self) (row: usize) -> Option<&mut Real> = Block;
    /// See [`Block::lreal`].
    fn self.lreal(&self) (row: usize) -> Option<LReal> = Block;
    /// See [`Block::lreal_mut`].
    fn self.lreal_mut(&mut self) (row: usize) -> Option<&mut LReal> = Block;
    /// See [`Block::set_mean`].
    fn self.set_mean(&mut self) (percent: LReal) = Block;
    /// See [`blocks::Law::restart`].
    fn self.restart(&mut self) () = Law;
    /// See [`blocks::Law::call`].
    fn self.call(&mut self) () = Law;
    /// See [`blocks::Law::check`].
    fn self.check(&self) () -> Result<(), String> = Law;
    /// See [`blocks::Law::advice`].
    fn self.advice(&self) () -> Vec<String> = Law;
    /// See [`blocks::Law::pulse`].
    fn self.pulse(&self) () -> i32 = Law;
}
