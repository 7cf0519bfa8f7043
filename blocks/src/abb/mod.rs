//! Function blocks of ABB.

mod hlg;

pub use hlg::Hlg;
