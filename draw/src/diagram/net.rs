//! The connections in a diagram, for programs that compute with them: the source and the target of each signal.

use super::model::{Diagram, Shape, Side, Sign};
use super::read;
use super::wire::Wire;
use anyhow::Result;
use modeldescription::Table;

/// A connection from one element to another. The names are those in the description.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The name of the source element.
    pub from: String,
    /// The side at which the signal leaves the source.
    pub leaves: Option<&'static str>,
    /// The name of the target element.
    pub to: String,
    /// The side at which the signal enters the target; `None` at a contact or pin.
    pub enters: Option<&'static str>,
    /// Whether the target is a summing point that subtracts the signal.
    pub is_negative: bool,
}

/// The connections of a block's diagram, except dashed ones, which act only in some states. Empty if the block has no
/// diagram.
///
/// # Errors
/// The description of the diagram is faulty.
pub fn links(table: &Table) -> Result<Vec<Link>> {
    let Some(checked) = read(table)? else { return Ok(Vec::new()) };
    let diagram = &checked.diagram;
    let solid = || diagram.wires.iter().filter(|wire| !wire.is_dashed);
    Ok(solid().filter_map(|wire| link(diagram, wire)).collect())
}

fn link(diagram: &Diagram, wire: &Wire) -> Option<Link> {
    // A wire that branches off another carries the same signal.
    let source = diagram.wires.iter().find(|other| other.signal == wire.signal && other.from.is_some())?;
    let (from, to) = (source.from?, wire.to);
    let leaves = side(diagram, from, source.points.first()?);
    let enters = side(diagram, to, wire.points.last()?);
    let is_negative = match &diagram.elements[to].shape {
        Shape::Sum { signs } => signs.iter().any(|(side, sign)| Some(*side) == enters && *sign == Sign::Minus),
        _ => false,
    };
    let name = |element: usize| diagram.elements[element].name.clone();
    let word = |side: Option<Side>| Side::ALL.into_iter().find(|(_, of)| Some(*of) == side).map(|(word, _)| word);
    Some(Link { from: name(from), leaves: word(leaves), to: name(to), enters: word(enters), is_negative })
}

/// The side of an element on which a point is located.
fn side(diagram: &Diagram, element: usize, at: &super::model::Point) -> Option<Side> {
    let element = &diagram.elements[element];
    Side::ALL.into_iter().map(|(_, side)| side).find(|side| {
        element.side(*side, 0.0).is_some_and(|middle| match side {
            Side::Left | Side::Right => middle.x == at.x,
            Side::Top | Side::Bottom => middle.y == at.y,
        })
    })
}
