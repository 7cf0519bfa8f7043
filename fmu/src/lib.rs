//! What every block's FMU shares.
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
//! `cargo xtask fmu -p PACKAGE` packs it.
//!
//! The core is what a PLC does around a block, without any FMI: [`clock`] says which calls fall into a step, [`session`]
//! makes them, [`mean`] averages the pulse over them, [`refusal`] says why a call is refused,
//! and [`table`] describes the block. [`v2`] is FMI 2.0 for co-simulation over this core, all unsafe code included.
//!
//! Data flows one way: `v2` checks a call and passes it on to the session, the session asks the clock, and the block's law
//! computes. Between the C function and the law there is no dynamic dispatch and no allocation.

pub mod clock;
pub mod mean;
pub mod refusal;
pub mod session;
pub mod table;
#[cfg(test)]
mod test_block;
pub mod v2;
