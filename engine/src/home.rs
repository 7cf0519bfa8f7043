//! Where the engine lives: what FMUs there are, and how an instance is made of one.

use crate::component::Component;
use crate::message::{Entry, KnownLoop};
use anyhow::Result;
use modeldescription::Table;
use modeldescription::v2::ModelDescription;
use parameters::Block;
use std::sync::Arc;

/// A home of the engine: the page with the blocks linked in, or the command with FMUs.
pub trait Home {
    /// The FMUs that there are.
    fn entries(&self) -> Vec<Entry>;

    /// Loops that are known to work.
    fn known_loops(&self) -> Vec<KnownLoop>;

    /// What an FMU's modelDescription.xml says.
    ///
    /// # Errors
    /// There is no such FMU, or it cannot be read.
    fn description(&self, fmu: &str) -> Result<Arc<ModelDescription>>;

    /// The table of an FMU that was made with `fmu::export!`; a foreign FMU has none.
    ///
    /// # Errors
    /// There is no such FMU, or it cannot be read.
    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>>;

    /// The blocks that parameter files are read and written for, those of the catalogue.
    fn blocks(&self) -> Vec<Arc<Block>>;

    /// A new instance of an FMU.
    ///
    /// # Errors
    /// There is no such FMU, or it refuses.
    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>>;

    /// The home's FMU of a block with other start values, as bytes.
    ///
    /// # Errors
    /// There is no such FMU here, or a value does not fit.
    fn preset(&self, of: &parameters::Loop) -> Result<Vec<u8>>;
}
