//! The computations of the parameter tool: opening, checking, running, recording, figures, identification, tuning,
//! replay, export.
//!
//! [`Engine`] takes a [`Request`] and returns an [`Answer`](message::Answer). It has no files, sockets, clocks or
//! threads: the available FMUs, and how they are stepped, depend on its [`Home`](home::Home). One home is the page,
//! where the blocks are linked in as WebAssembly; the other is the command, which steps FMUs through their C interface.
//! Both compute the same bits.

mod abreast;
mod chain;
pub mod connect;
pub mod describe;
mod engine;
pub mod experiment;
pub mod export;
pub mod home;
pub mod known;
pub mod linked;
pub mod message;
pub mod preset;
pub mod program;
mod report;
mod request;
pub mod session;
pub mod signals;
#[cfg(test)]
mod test_home;
mod travel;

pub use engine::Engine;
pub use request::Request;
