//! A LAD or FBD network as a graph of elements and wires, independent of the file format.

use crate::front::lexer::Span;
use crate::front::syntax::{ExpressionId, Name};

/// A network of a block.
#[derive(Debug)]
pub struct Network {
    /// Its number within the block, counted from 1.
    pub number: u32,
    /// Its title, possibly empty.
    pub title: String,
    /// Its comment, possibly empty.
    pub comment: String,
    /// Its start in the source.
    pub span: Span,
    /// The labels at its beginning.
    pub labels: Vec<Name>,
    /// Its elements, in execution order unless wires require a different order.
    pub elements: Vec<Element>,
    /// The values of its output pins that other elements need, once it has been translated; `None` is TRUE, directly
    /// from the power rail.
    pub carried: Vec<(Pin, Option<ExpressionId>)>,
}

/// A pin of an element: the element's index, and the pin's name in upper case.
pub(crate) type Pin = (usize, String);

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
    /// The instruction, in any letter case: `Contact`, `S_Coil`, `Add`; for a call, the block.
    pub name: String,
    /// Its location.
    pub span: Span,
    /// The connections of its input pins, including operands.
    pub inputs: Vec<Input>,
    /// The variables written by its output pins; pin names in upper case.
    pub outputs: Vec<(String, ExpressionId)>,
    /// Unconnected output pins that are drawn, in upper case.
    pub open: Vec<String>,
    /// Negated pins, in upper case.
    pub negated: Vec<String>,
    /// Its types and other settings, by upper-case name: `SRCTYPE`, `DESTTYPE`, `TIME_TYPE`, `VALUE_TYPE`.
    pub settings: Vec<(String, String)>,
    /// Whether ENO reports failure; otherwise it equals EN.
    pub has_eno: bool,
    /// The instance of a timer, counter or edge; for a call, the called instance or function.
    pub called: Option<ExpressionId>,
    /// Details of a call.
    pub call: Option<Call>,
    /// The expression of a Calculate box, in terms of its pin names.
    pub equation: Option<ExpressionId>,
    /// The target of a jump, or the name of a label among the elements.
    pub label: Option<Name>,
}

impl Element {
    /// An element without connections.
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

    /// Connects a source to an input pin; several sources of one pin are combined by OR.
    pub fn connect(&mut self, pin: &str, source: Source) {
        let pin = pin.to_uppercase();
        match self.inputs.iter_mut().find(|input| input.pin == pin) {
            Some(input) => input.sources.push(source),
            None => self.inputs.push(Input { pin, sources: vec![source] }),
        }
    }

    /// Connects an output pin to a variable, which the element writes.
    pub fn write(&mut self, pin: &str, target: ExpressionId) {
        self.outputs.push((pin.to_uppercase(), target));
    }

    /// The value of a setting, by its upper-case name.
    pub fn setting(&self, name: &str) -> Option<&str> {
        self.settings.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }
}

/// A connected input pin.
#[derive(Debug)]
pub struct Input {
    /// The pin, in upper case.
    pub pin: String,
    /// The sources of its value, combined by OR.
    pub sources: Vec<Source>,
}

/// The source of a value.
#[derive(Clone, Debug)]
pub enum Source {
    /// The power rail, which is always TRUE.
    Rail,
    /// A variable or a constant.
    Operand(ExpressionId),
    /// An output pin of another element: the element's index, and the pin.
    Pin(usize, String),
}

/// A call to a block.
#[derive(Clone, Debug)]
pub struct Call {
    /// Whether the callee is a function, not an instance of a function block.
    pub is_function: bool,
    /// The parameters listed in the call; a connected pin always belongs to the parameter of the same name.
    pub parameters: Vec<Parameter>,
}

/// A parameter of a called block.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its direction.
    pub way: Way,
    /// Its type, if the call specifies it.
    pub of: Option<String>,
}

/// The direction of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Way {
    Input,
    Output,
    InOut,
    /// The return value of a function.
    Value,
}
