//! What is made of FMUs' files, and what is checked in them.

pub mod check;
pub mod dist;
pub mod merge;
pub mod pack;
pub mod preset;
pub mod reference;
pub mod ssp;
