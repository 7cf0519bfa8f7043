//! The parameter tool: the page, and the command that serves it.

#[cfg(feature = "tool")]
pub mod child;
#[cfg(feature = "tool")]
pub mod home;
#[cfg(feature = "tool")]
pub mod server;
