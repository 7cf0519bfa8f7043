//! What an FMU shows its user: the documentation page, block diagrams, curves, pictures.

#[cfg(feature = "command")]
pub mod diagram;
#[cfg(feature = "command")]
mod document;
pub(crate) mod escape;
#[cfg(feature = "command")]
mod markdown;
#[cfg(feature = "command")]
pub mod picture;
#[cfg(feature = "command")]
pub mod plot;
pub mod preset;
#[cfg(feature = "command")]
mod svg;
pub mod text;

#[cfg(feature = "command")]
pub use document::{help, html, sections};
