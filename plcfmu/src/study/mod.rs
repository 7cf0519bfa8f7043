//! Studies: one loop, run many times with different values.

pub mod junit;
pub mod pictures;
pub mod report;
