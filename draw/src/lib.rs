//! Charts, block diagrams and icons as SVG, and SVG as PNG. What is drawn comes from a block's table, or as numbers.

pub mod bars;
pub mod diagram;
pub mod escape;
pub mod field;
pub mod histogram;
pub mod palette;
#[cfg(feature = "png")]
pub mod picture;
pub mod plot;
pub mod response;
pub mod scale;
pub mod scatter;
pub mod svg;
pub mod text;
