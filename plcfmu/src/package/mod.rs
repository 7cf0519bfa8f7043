//! Packing, reading and checking the files of FMUs.

pub mod apart;
pub mod check;
pub mod dist;
pub mod merge;
pub mod pack;
pub mod preset;
pub mod program;
pub mod program_library;
pub mod reference;
mod sources;
pub mod ssp;
mod terminals;
pub mod version;
