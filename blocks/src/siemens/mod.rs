//! The PID control blocks of SIMATIC S7.

mod advice;
mod cont_c;
mod cont_s;
mod error_signal;
mod puls_ctr;
mod pulsegen;

vendor!(cont_c::ContC, cont_s::ContS, pulsegen::Pulsegen, puls_ctr::PulsCtr);
