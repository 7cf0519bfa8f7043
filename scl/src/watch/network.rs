//! The networks of a block as drawn: elements with their pins, and the recorded value of each wire.

use super::{path, written};
use crate::front::lexer::Span;
use crate::front::syntax::{Binary, ExpressionId, Expressions};
use crate::ladder::elements::{self, Law};
use crate::ladder::{self, Source};
use parameters::Source as Text;
use std::collections::HashMap;

/// A network.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Network {
    /// Its number within the block, counted from 1.
    pub number: u32,
    /// Its title, possibly empty.
    pub title: String,
    /// Its comment, possibly empty.
    pub comment: String,
    /// Its first line number (1-based).
    pub line: usize,
    /// The labels at its beginning.
    pub labels: Vec<String>,
    /// Whether it has a power rail, as in LAD.
    pub has_rail: bool,
    /// Its elements; inputs refer to them by index.
    pub elements: Vec<Element>,
}

/// The shape of an element in LAD; in FBD, all elements are boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Shape {
    /// Two bars around a sign, with the operand above.
    Contact,
    /// Two bars around a sign, with one operand above and one below.
    Compare,
    /// Round brackets around a sign, with the operand above.
    Coil,
    /// A rectangle with pins.
    Box,
    /// A junction of wires.
    Junction,
}

/// An element.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Element {
    /// Its shape.
    #[cfg_attr(feature = "typescript", ts(type = "\"contact\" | \"compare\" | \"coil\" | \"box\" | \"junction\""))]
    pub shape: Shape,
    /// The sign inside it, or the title of its box.
    pub sign: String,
    /// Its 1-based line number.
    pub line: usize,
    /// The text above it: its operand, its instance, or the label of a jump.
    pub above: Option<Operand>,
    /// Its input pins, except the one drawn above it.
    pub inputs: Vec<Input>,
    /// Its output pins.
    pub outputs: Vec<Output>,
}

/// A variable, a constant or a label.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Operand {
    /// The text as written.
    pub text: String,
    /// The path of the variable; `None` for anything else.
    pub path: Option<String>,
    /// Whether it is a global variable.
    pub is_global: bool,
    /// The number under which its value is recorded, if it is read as a truth value.
    pub wire: Option<u32>,
}

/// An input pin.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Input {
    /// Its name in upper case.
    pub pin: String,
    /// Whether its value is negated.
    pub is_negated: bool,
    /// Its sources, combined by OR.
    pub sources: Vec<From>,
}

/// The source of an input pin: an operand, the output pin of another element or, if neither, the power rail.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct From {
    /// The variable or the constant.
    pub operand: Option<Operand>,
    /// The index of the element.
    pub element: Option<usize>,
    /// The name of its output pin.
    pub pin: String,
}

/// An output pin.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Output {
    /// Its name in upper case.
    pub pin: String,
    /// Whether its value is negated.
    pub is_negated: bool,
    /// The variables it writes.
    pub targets: Vec<Operand>,
    /// The number under which its value is recorded; `None` if it is unconnected or carries the power rail.
    pub wire: Option<u32>,
    /// Whether it carries the power rail's value.
    pub is_rail: bool,
}

/// A network as drawn, with the numbers under which its values are recorded.
pub(super) fn drawn(of: &ladder::Network, expressions: &Expressions, source: &Text) -> Network {
    let line = |span: Span| source.place(span.range()).line;
    let is_fed = |element: &ladder::Element| {
        let mut sources = element.inputs.iter().flat_map(|input| &input.sources);
        !matches!(law(element), Some(Law::Jump(_) | Law::Return(_)))
            && sources.any(|source| matches!(source, Source::Rail))
    };
    let has_rail = of.elements.iter().any(is_fed);
    let elements = of.elements.iter().enumerate().map(|(number, element)| {
        let operand = |id: ExpressionId| operand(expressions, id);
        let above = above(element, expressions);
        let inputs = element.inputs.iter().filter(|input| !is_above(element, &input.pin));
        Element {
            shape: shape(element, has_rail),
            sign: sign(element, has_rail),
            line: line(element.span),
            inputs: inputs
                .map(|input| Input {
                    pin: input.pin.clone(),
                    is_negated: element.negated.contains(&input.pin),
                    sources: input
                        .sources
                        .iter()
                        .map(|from| match from {
                            Source::Rail => From::default(),
                            Source::Operand(id) => From { operand: Some(operand(*id)), ..From::default() },
                            Source::Pin(number, pin) => {
                                From { element: Some(*number), pin: pin.to_uppercase(), operand: None }
                            }
                        })
                        .collect(),
                })
                .collect(),
            outputs: outputs(of, number, element, &operand),
            above,
        }
    });
    Network {
        number: of.number,
        title: of.title.clone(),
        comment: of.comment.clone(),
        line: line(of.span),
        labels: of.labels.iter().map(|label| label.text.clone()).collect(),
        has_rail,
        elements: elements.collect(),
    }
}

fn law(element: &ladder::Element) -> Option<Law> {
    elements::named(&element.name).map(|row| row.law).filter(|_| element.call.is_none())
}

fn operand(expressions: &Expressions, id: ExpressionId) -> Operand {
    let (path, is_global) = path(expressions, id).unzip();
    let text = written(expressions, &HashMap::new(), id);
    Operand { text, path, is_global: is_global.unwrap_or(false), wire: Some(id.0) }
}

/// Whether the operand of an input pin is drawn above the element.
fn is_above(element: &ladder::Element, pin: &str) -> bool {
    match law(element) {
        Some(Law::Compare(_)) => pin == "IN1",
        Some(Law::TimerCoil(_) | Law::TimerFunction(_)) => matches!(pin, "OPERAND" | "TIMER"),
        _ => pin == "OPERAND",
    }
}

fn above(element: &ladder::Element, expressions: &Expressions) -> Option<Operand> {
    if let Some(label) = &element.label {
        return Some(Operand { text: label.text.clone(), path: None, is_global: false, wire: None });
    }
    let mut inputs = element.inputs.iter().filter(|input| is_above(element, &input.pin));
    let of_pin = inputs.next().and_then(|input| match input.sources.first() {
        Some(Source::Operand(id)) => Some(*id),
        _ => None,
    });
    let is_function = element.call.as_ref().is_some_and(|call| call.is_function);
    of_pin.or(element.called.filter(|_| !is_function)).map(|id| operand(expressions, id))
}

/// The connected output pins, in drawing order.
fn outputs(
    of: &ladder::Network,
    number: usize,
    element: &ladder::Element,
    operand: &dyn Fn(ExpressionId) -> Operand,
) -> Vec<Output> {
    let mut outputs: Vec<Output> = Vec::new();
    let pins = element.outputs.iter().map(|(pin, _)| pin).chain(&element.open);
    let carried = of.carried.iter().filter(|((of, _), _)| *of == number);
    for pin in carried.clone().map(|((_, pin), _)| pin).chain(pins) {
        if outputs.iter().any(|output| output.pin == *pin) {
            continue;
        }
        // Only the first value counts: the value of a pin may be set again when it is written to a variable.
        let carries = carried.clone().find(|((_, own), _)| own == pin).map(|(_, carries)| *carries);
        let targets = element.outputs.iter().filter(|(own, _)| own == pin);
        outputs.push(Output {
            pin: pin.clone(),
            is_negated: element.negated.contains(pin),
            targets: targets.map(|(_, target)| operand(*target)).collect(),
            wire: carries.flatten().map(|id| id.0),
            is_rail: carries == Some(None),
        });
    }
    outputs
}

fn shape(element: &ladder::Element, has_rail: bool) -> Shape {
    match law(element) {
        Some(Law::Contact(_) | Law::EdgeContact(_) | Law::Not) => Shape::Contact,
        Some(Law::Valid(_)) if element.inputs.iter().any(|input| input.pin == "OPERAND") => Shape::Contact,
        Some(Law::Compare(_)) => Shape::Compare,
        Some(Law::Gate(Binary::Or)) if has_rail => Shape::Junction,
        Some(
            Law::Coil(_)
            | Law::Set(_)
            | Law::SetField(_)
            | Law::EdgeCoil(_)
            | Law::TimerCoil(_)
            | Law::TimerFunction(_)
            | Law::Jump(_)
            | Law::Return(_),
        ) => Shape::Coil,
        _ => Shape::Box,
    }
}

fn sign(element: &ladder::Element, has_rail: bool) -> String {
    let edge = |is_rising| if is_rising { "P" } else { "N" };
    // In SimaticML, a negated contact or coil may have a negated operand.
    let is_operand_negated = element.negated.iter().any(|pin| pin == "OPERAND");
    let sign = match law(element) {
        Some(Law::Contact(is_negated)) => ["", "/"][usize::from(is_negated != is_operand_negated)],
        Some(Law::EdgeContact(is_rising) | Law::EdgeCoil(is_rising)) => edge(is_rising),
        Some(Law::EdgeOfFlow(is_rising)) => ["N_TRIG", "P_TRIG"][usize::from(is_rising)],
        Some(Law::Not) => "NOT",
        Some(Law::Compare(operator)) => match operator {
            Binary::Equal => "==",
            Binary::NotEqual => "<>",
            Binary::Greater => ">",
            Binary::GreaterOrEqual => ">=",
            Binary::Less => "<",
            _ => "<=",
        },
        Some(Law::Range(is_inside)) => ["OUT_RANGE", "IN_RANGE"][usize::from(is_inside)],
        Some(Law::Valid(is_valid)) => ["NOT_OK", "OK"][usize::from(is_valid)],
        Some(Law::Gate(Binary::And)) => "&",
        Some(Law::Gate(Binary::Xor)) => "XOR",
        Some(Law::Gate(_)) => ">=1",
        Some(Law::Coil(is_negated)) => match (is_negated != is_operand_negated, has_rail) {
            (false, true) => "",
            (false, false) => "=",
            (true, _) => "/",
        },
        Some(Law::Set(is_set)) => ["R", "S"][usize::from(is_set)],
        Some(Law::SetField(is_set)) => ["RESET_BF", "SET_BF"][usize::from(is_set)],
        Some(Law::FlipFlop(is_set_dominant)) => ["SR", "RS"][usize::from(is_set_dominant)],
        Some(Law::Instance(kind) | Law::TimerCoil(kind)) => kind,
        Some(Law::TimerFunction("RESET_TIMER")) => "RT",
        Some(Law::TimerFunction(_)) => "PT",
        Some(Law::Jump(is_if_true)) => ["JMPN", "JMP"][usize::from(is_if_true)],
        Some(Law::Return(_)) => "RET",
        _ if element.call.is_some() => return element.name.clone(),
        _ => return elements::named(&element.name).map_or(&*element.name, |row| row.names[0]).to_uppercase(),
    };
    sign.to_string()
}
