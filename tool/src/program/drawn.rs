//! The networks of a block, as the page draws them.

use scl::watch;
use serde::{Deserialize, Serialize};

/// A network in LAD or FBD.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Network {
    /// Its number in the block, from 1.
    pub number: u32,
    /// Its title, or nothing.
    pub title: String,
    /// Its comment, or nothing.
    pub comment: String,
    /// Its first line, from 1.
    pub line: usize,
    /// The labels at its beginning.
    pub labels: Vec<String>,
    /// Whether a power rail feeds it: it is in LAD.
    pub has_rail: bool,
    /// Its elements.
    pub elements: Vec<Element>,
}

/// An element of a network.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Element {
    /// How it looks in LAD: `contact`, `compare`, `coil`, `box`, `junction`. In FBD all are boxes.
    #[cfg_attr(test, ts(type = "\"contact\" | \"compare\" | \"coil\" | \"box\" | \"junction\""))]
    pub shape: String,
    /// The sign in it, or the title of its box.
    pub sign: String,
    /// Its line, from 1.
    pub line: usize,
    /// What stands above it: its operand, its instance, or the label of a jump.
    pub above: Option<Operand>,
    /// Its input pins, without what stands above it.
    pub inputs: Vec<Input>,
    /// Its output pins.
    pub outputs: Vec<Output>,
}

/// A variable, a constant or a label.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Operand {
    /// As it is written.
    pub text: String,
    /// The path of a variable; anything else has none.
    pub path: Option<String>,
    /// Whether it is a variable that all blocks see.
    pub is_global: bool,
    /// The number of its truth value in what is told of a call.
    pub wire: Option<u32>,
}

/// An input pin.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Input {
    /// Its name in capitals.
    pub pin: String,
    /// Whether its value is negated.
    pub is_negated: bool,
    /// What is wired to it: the OR of these.
    pub sources: Vec<From>,
}

/// Where a wire comes from: an operand, the output pin of an element, else the power rail.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct From {
    /// The variable or the constant.
    pub operand: Option<Operand>,
    /// The number of the element in its network.
    pub element: Option<usize>,
    /// The name of the output pin.
    pub pin: String,
}

/// An output pin.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Output {
    /// Its name in capitals.
    pub pin: String,
    /// Whether its value is negated.
    pub is_negated: bool,
    /// The variables that it is written to.
    pub targets: Vec<Operand>,
    /// The number of its truth value in what is told of a call.
    pub wire: Option<u32>,
    /// Whether it carries what the power rail does.
    pub is_rail: bool,
}

/// A network as a message.
pub fn as_message(of: &watch::Network) -> Network {
    Network {
        number: of.number,
        title: of.title.clone(),
        comment: of.comment.clone(),
        line: of.line,
        labels: of.labels.clone(),
        has_rail: of.has_rail,
        elements: of.elements.iter().map(element).collect(),
    }
}

fn element(of: &watch::Element) -> Element {
    let shape = match of.shape {
        watch::Shape::Contact => "contact",
        watch::Shape::Compare => "compare",
        watch::Shape::Coil => "coil",
        watch::Shape::Box => "box",
        watch::Shape::Junction => "junction",
    };
    let from = |of: &watch::From| match of {
        watch::From::Rail => From::default(),
        watch::From::Operand(of) => From { operand: Some(operand(of)), ..From::default() },
        watch::From::Pin(element, pin) => From { element: Some(*element), pin: pin.clone(), operand: None },
    };
    let input = |of: &watch::Input| Input {
        pin: of.pin.clone(),
        is_negated: of.is_negated,
        sources: of.sources.iter().map(from).collect(),
    };
    let output = |of: &watch::Output| Output {
        pin: of.pin.clone(),
        is_negated: of.is_negated,
        targets: of.targets.iter().map(operand).collect(),
        wire: of.wire,
        is_rail: of.is_rail,
    };
    Element {
        shape: shape.to_string(),
        sign: of.sign.clone(),
        line: of.line,
        above: of.above.as_ref().map(operand),
        inputs: of.inputs.iter().map(input).collect(),
        outputs: of.outputs.iter().map(output).collect(),
    }
}

fn operand(of: &watch::Operand) -> Operand {
    Operand {
        text: of.text.clone(),
        path: of.path.as_ref().map(|(path, _)| path.clone()),
        is_global: of.path.as_ref().is_some_and(|(_, is_global)| *is_global),
        wire: of.wire,
    }
}
