//! TODO
use crate::*;
use std::sync::Arc;
/// Reads.
pub fn read(source: &Source, blocks: &[Arc<Block>], options: &Options) -> Result<Reading, Problems> {
    let _ = (source, blocks, options);
    todo!()
}
/// Writes.
pub fn write(loops: &[Loop]) -> Result<String, String> {
    let _ = loops;
    todo!()
}
