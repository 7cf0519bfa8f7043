//! The code shared by the FMUs of all blocks.
//!
//! A crate of type `cdylib` becomes the library of an FMU by its last line:
//!
//! ```
//! blocks::block! {
//!     /// Doubles its input.
//!     pub struct Twice as "TWICE" {
//!         input {
//!             /// Input value
//!             u: Real = 0.0;
//!         }
//!         cycle {
//!             /// Time between two calls
//!             cycle: Time = Time::ms(100), min Time::ms(1);
//!         }
//!         output {
//!             /// Output value
//!             y: Real;
//!         }
//!     }
//! }
//!
//! impl blocks::Law for Twice {
//!     fn restart(&mut self) {
//!         self.clear();
//!     }
//!
//!     fn call(&mut self) {
//!         self.y = self.u * 2.0;
//!     }
//! }
//!
//! fmu::export!(Twice);
//! # fn main() {}
//! ```
//!
//! `cargo xtask fmu -p PACKAGE` packs it as an FMU.
//!
//! The core does what a PLC does around a block and what a host may request, independently of the FMI version:
//! [`clock`] determines the calls in a step, [`session`] makes them, [`mean`] averages the pulse over them;
//! [`instance`] gets and sets values by number, [`state`] defines what is allowed when, [`component`] saves states,
//! [`preset`] reads other start values, [`mod@door`] catches panics and logs; [`refusal`] states why a call is refused,
//! and [`describe`] prints the library's interface from the block's [`table`]. [`ordinary`] is the fast path for the
//! calls of every cycle, and [`abreast`] the same for several instances at a time. On top of this core, [`v2`] is FMI
//! 2.0 for co-simulation, a table of C functions, and [`v3`] is FMI 3.0; most of their unsafe code is shared, in
//! `pointers`.
//!
//! Data flows one way: `v2` turns pointers into references, the door checks the state, the session asks the clock, and
//! the block's law computes. Between the C function and the law there is no dynamic dispatch and no allocation.
//!
//! All of this works on [`cyclic::Cyclic`], which every block implements. A program known only at run time is another
//! implementation, and its library another [`component::Library`].

pub mod abreast;
pub mod clock;
pub mod component;
pub mod cyclic;
pub mod door;
pub mod host_type;
pub mod instance;
pub mod layout;
pub mod log;
pub mod mean;
mod messages;
pub mod ordinary;
#[macro_use]
mod pointers;
pub mod preset;
pub mod refusal;
pub mod resources;
pub mod session;
pub mod sources;
pub mod state;
pub mod table;
#[cfg(test)]
mod test_block;
pub mod texts;
pub mod v2;
pub mod v3;

pub use v2::{CAPABILITIES, describe};

/// The FMI 3.0 C door with these types; the FMI 2.0 one if `types` is `None`.
pub fn door(types: Option<blocks::Types>) -> &'static sources::Door {
    match types {
        None => &v2::sources::DOOR,
        Some(blocks::Types::Native) => &v3::sources::NATIVE,
        Some(blocks::Types::Wide) => &v3::sources::WIDE,
    }
}

/// The last line of an FMU's library: adds the C functions for FMI co-simulation of one block, and
/// `plcfmu_interface`, from which the packer reads the library's description of itself. `export!(functions LIBRARY)`
/// omits the latter: for the program library, the description depends on the program.
#[macro_export]
macro_rules! export {
    ($Library:ty) => {
        $crate::export!(functions $Library);
        $crate::export_interface!($Library);
    };
    (functions $Library:ty) => {
        $crate::export_fmi2!($Library);
        $crate::export_fmi3!($Library);
    };
}
