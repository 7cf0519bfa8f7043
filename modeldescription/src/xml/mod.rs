//! The XML of a model description in any FMI version: table-driven elements and attributes, read within limits and
//! written.

pub(crate) mod attributes;
pub(crate) mod lexical;
pub(crate) mod read;
pub(crate) mod write;
