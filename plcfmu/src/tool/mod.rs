//! The parameter tool: the page, and the command that serves it.

pub mod assets;
#[cfg(feature = "server")]
pub mod child;
#[cfg(feature = "server")]
pub mod connections;
#[cfg(feature = "server")]
pub mod home;
pub mod make;
pub mod page;
#[cfg(feature = "server")]
pub mod server;
