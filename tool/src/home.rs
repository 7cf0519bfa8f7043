//! The home of the engine: where its catalogue of FMUs, blocks and loops comes from.

use crate::message::{Entry, KnownLoop};
use anyhow::Result;
use manifest::Manifest;
use parameters::BlockType;
use run::fmus::Fmus;
use std::sync::Arc;

/// The environment of the engine: the page, with the blocks linked in, or the command, with FMUs.
pub trait Home: Fmus {
    /// The available FMUs.
    fn entries(&self) -> Vec<Entry>;

    /// Loops that are known to work.
    fn known_loops(&self) -> Vec<KnownLoop>;

    /// The blocks whose parameter files can be read and written.
    fn blocks(&self) -> Vec<Arc<BlockType>>;

    /// The home's FMU for the loop's block, with the loop's values as start values, as bytes.
    ///
    /// # Errors
    /// The home has no such FMU, or a value does not fit.
    fn preset(&self, of: &parameters::Loop) -> Result<Vec<u8>>;

    /// How a PLC program is built from its sources; `None` for any other FMU.
    fn program(&self, _fmu: &str) -> Option<Manifest> {
        None
    }

    /// The sources of a PLC program; empty for any other FMU.
    fn sources(&self, _fmu: &str) -> Vec<parameters::Source> {
        Vec::new()
    }
}
