//! The PID control blocks of SIMATIC S7.

mod advice;
mod cont_c;
mod cont_s;
mod error_signal;
mod puls_ctr;
mod pulsegen;

pub use cont_c::ContC;
pub use cont_s::ContS;
pub use puls_ctr::PulsCtr;
pub use pulsegen::Pulsegen;
