//! A network of LAD or FBD as a graph of elements and wires, whatever format it was read from.

use crate::lexer::Span;
use crate::syntax::{ExpressionId, Name};

/// A network of a block.
#[derive(Debug)]
pub struct Network {
    /// Its number in the block, from 1.
    pub number: u32,
    /// Its title, or nothing.
    pub title: String,
    /// Its comment, or nothing.
    pub comment: String,
    /// Where it begins.
    pub span: Span,
    /// The labels at its beginning.
    pub labels: Vec<Name>,
    /// Its elements, in the order in which they take effect where no wire says another one.
    pub elements: Vec<Element>,
    /// What its output pins carry, once it is translated: an expression; `None` is TRUE, straight from the power rail.
    pub carried: Vec<(Pin, Option<ExpressionId>)>,
}

/// A pin of an element: the number of the element, and the name of the pin in capitals.
pub type Pin = (usize, String);

impl Network {
    /// A network without elements.
    pub fn new(number: u32, span: Span) -> Network {
        Network {
            number,
            title: String::new(),
            comment: String::new(),
            span,
            labels: Vec::new(),
            elements: Vec::new(),
            carried: Vec::new(),
        }
    }
}

/// A contact, a coil, a gate, a box or a call.
#[derive(Debug)]
pub struct Element {
    /// The name of the instruction, in any case: `Contact`, `S_Coil`, `Add`; of a call the block's.
    pub name: String,
    /// Where it stands.
    pub span: Span,
    /// What its input pins get, its operands included.
    pub inputs: Vec<Input>,
    /// The variables that its output pins are written to: pins in capitals, and variables.
    pub outputs: Vec<(String, ExpressionId)>,
    /// Output pins that are drawn and lead nowhere, in capitals.
    pub open: Vec<String>,
    /// Pins that are negated, in capitals.
    pub negated: Vec<String>,
    /// Its types and other settings, by their names in capitals: `SRCTYPE`, `DESTTYPE`, `TIME_TYPE`, `VALUE_TYPE`.
    pub settings: Vec<(String, String)>,
    /// Whether ENO says if the box failed; else it is EN.
    pub has_eno: bool,
    /// The instance of a timer, a counter or an edge; of a call the instance or the function that is called.
    pub called: Option<ExpressionId>,
    /// What is known of a call.
    pub call: Option<Call>,
    /// The expression of a Calculate box, of the names of its pins.
    pub equation: Option<ExpressionId>,
    /// Where a jump goes, or the name of a label among the elements.
    pub label: Option<Name>,
}

impl Element {
    /// An element without wires.
    pub fn new(name: impl Into<String>, span: Span) -> Element {
        Element {
            name: name.into(),
            span,
            inputs: Vec::new(),
            outputs: Vec::new(),
            open: Vec::new(),
            negated: Vec::new(),
            settings: Vec::new(),
            has_eno: false,
            called: None,
            call: None,
            equation: None,
            label: None,
        }
    }

    /// Wires a source to an input pin; several sources of one pin are joined by OR.
    pub fn connect(&mut self, pin: &str, source: Source) {
        let pin = pin.to_uppercase();
        match self.inputs.iter_mut().find(|input| input.pin == pin) {
            Some(input) => input.sources.push(source),
            None => self.inputs.push(Input { pin, sources: vec![source] }),
        }
    }

    /// Writes an output pin to a variable.
    pub fn write(&mut self, pin: &str, target: ExpressionId) {
        self.outputs.push((pin.to_uppercase(), target));
    }

    /// A setting, by its name in capitals.
    pub fn setting(&self, name: &str) -> Option<&str> {
        self.settings.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }
}

/// What an input pin gets.
#[derive(Debug)]
pub struct Input {
    /// The pin, in capitals.
    pub pin: String,
    /// Where its value comes from: the OR of these.
    pub sources: Vec<Source>,
}

/// Where a value comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// The power rail: TRUE.
    Rail,
    /// A variable or a constant.
    Operand(ExpressionId),
    /// A pin of another element: its number, and the pin.
    Pin(usize, String),
}

/// A call of a block.
#[derive(Clone, Debug)]
pub struct Call {
    /// Whether a function is called, not an instance of a function block.
    pub is_function: bool,
    /// The parameters that the call names; what is wired goes to the parameter of the pin's name in any case.
    pub parameters: Vec<Parameter>,
}

/// A parameter of a block that is called.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// What it is.
    pub way: Way,
    /// Its type, where the call says it.
    pub of: Option<String>,
}

/// Which way a parameter goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Way {
    Input,
    Output,
    InOut,
    /// The value of a function.
    Value,
}
