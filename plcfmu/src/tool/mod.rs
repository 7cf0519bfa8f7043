//! The parameter tool: the page, and the command that serves it.

pub mod assets;
pub mod make;
pub mod page;
