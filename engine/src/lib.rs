//! What the parameter tool computes: opening, checking, running, recording, figures, identification, tuning, replay, export.
//!
//! [`Engine`] takes a [`Request`](message::Request) and gives an [`Answer`](message::Answer). It has no files, sockets, clocks
//! or threads: what FMUs there are, and how they are stepped, is up to its [`Home`](home::Home). One home is the page, where
//! the blocks are linked in as WebAssembly; the other is the command, which steps FMUs through their C interface. Both compute
//! the same bits.

pub mod characteristic;
pub mod component;
pub mod connect;
pub mod csv;
pub mod describe;
pub mod dialog;
pub mod digits;
mod engine;
pub mod export;
pub mod figures;
pub mod home;
pub mod identify;
pub mod known;
pub mod margins;
pub mod message;
pub mod plan;
mod predict;
pub mod preset;
pub mod process;
pub mod replay;
mod report;
pub mod rules;
pub mod run;
pub mod session;
pub mod signals;
pub mod study;
pub mod system;
#[cfg(test)]
mod test_home;
pub mod trace;
mod travel;
pub mod tune;

pub use engine::Engine;
