//! The project's commands as a library: `main` only dispatches, and tests use what is here.

pub mod archive;
pub mod binary;
pub mod check;
pub mod command;
pub mod compile;
pub mod deep;
pub mod demo;
pub mod diagram;
pub mod fmu;
pub mod library;
pub mod package;
pub mod page;
pub mod picture;
pub mod plot;
pub mod progress;
pub mod python;
pub mod reference;
pub mod slave;
pub mod svg;
pub mod temporary;
pub mod test;
pub mod text;
pub mod workspace;
