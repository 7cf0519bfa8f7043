//! How a controller and a plant are connected: a proposal, with the reason for each connection.

use crate::home::Home;
use crate::message::{Member, Proposal};
use anyhow::Result;

/// Proposes connections.
///
/// # Errors
/// There is no such FMU.
pub fn propose(home: &dyn Home, controller: &Member, plant: &Member) -> Result<Proposal> {
    home.description(&controller.fmu)?;
    home.description(&plant.fmu)?;
    Ok(Proposal::default())
}
