//! Draws charts, block diagrams and icons as SVG, and converts SVG to PNG. The input is a block's table or numbers.

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
