//! The parameter tool: the page, and the command that serves it.

pub mod assets;
#[cfg(feature = "tool")]
pub mod child;
#[cfg(feature = "tool")]
pub mod home;
pub mod make;
pub mod page;
#[cfg(feature = "tool")]
pub mod server;
