//! Parses LAD and FBD rungs as written: elements in the order of the flow, and wires between them.

use crate::front::lexer::{Kind, Span};
use crate::front::parser::{Failed, Parsed, Parser};
use crate::front::syntax::{Attribute, ExpressionId, Name};
use crate::ladder::MOST_PINS;

/// Unsupported instructions, which have a special notation for pins.
const REFUSED: [&str; 2] = ["JUMPLIST", "SWITCH"];

/// A network as written.
#[derive(Debug, Default)]
pub(crate) struct Network {
    /// The labels at its start.
    pub labels: Vec<Name>,
    /// Its rungs, in source order.
    pub rungs: Vec<Rung>,
}

/// `RUNG` to `END_RUNG`.
#[derive(Debug)]
pub(crate) struct Rung {
    /// The source of the flow.
    pub from: From,
    /// The elements and wires it passes through.
    pub steps: Vec<Step>,
    /// The wire it leads to: `END_RUNG wire#w1`.
    pub to: Option<Name>,
}

/// The start of a rung.
#[derive(Debug)]
pub(crate) enum From {
    /// `wire#powerrail` or nothing; if nothing, the first element of the FBD rung has no input.
    Nothing { is_rail: bool },
    /// `wire#w1`.
    Wire(Name),
    /// The value of an operand.
    Operand(ExpressionId),
}

/// A point along the flow.
#[derive(Debug)]
pub(crate) enum Step {
    /// `wire#w1`: other rungs start or end here.
    Wire(Name),
    /// `NOT` before an element.
    Not(Span),
    Element(Element),
}

/// An instruction or a call.
#[derive(Debug)]
pub(crate) struct Element {
    /// `Contact`, `#timer.TON`, `"Block"`.
    pub callee: ExpressionId,
    pub attributes: Vec<Attribute>,
    /// The expression that it calculates, from its attribute S7_EXPRESSION.
    pub equation: Option<ExpressionId>,
    pub pins: Vec<Pin>,
    /// The span of the whole element.
    pub span: Span,
}

/// A pin of an element.
#[derive(Debug)]
pub(crate) struct Pin {
    /// Its name; `None` if its position identifies it.
    pub name: Option<Name>,
    /// Whether it is connected with `=>`.
    pub is_output: bool,
    pub value: Connection,
    pub span: Span,
}

/// The connection of a pin.
#[derive(Debug)]
pub(crate) enum Connection {
    /// Unconnected.
    Open,
    /// A wire, and whether its flow is negated.
    Wire(Name, bool),
    /// A variable, a constant or an expression.
    Operand(ExpressionId),
}

impl Parser<'_> {
    /// Parses the rungs of a network up to its end. After an error, parsing resumes with the next rung.
    pub(crate) fn rungs(&mut self) -> Network {
        let mut network = Network::default();
        while !self.is_end() && !self.is_statement_end() && !self.is_word("NETWORK") && !self.is_exhausted() {
            if self.takes(";") {
                continue;
            }
            let parsed = match self.word_ahead(0).as_str() {
                "RUNG" => self.rung().map(|rung| network.rungs.push(rung)),
                "LABEL" => self.label().map(|label| network.labels.extend(label)),
                _ => self.fail("RUNG or END_NETWORK"),
            };
            if let Err(Failed) = parsed {
                while !self.is_end() && !self.is_statement_end() && !self.is_word("RUNG") && !self.is_word("NETWORK") {
                    self.step();
                }
            }
        }
        network
    }

    /// Parses `Label( here )`; returns `None` for a label without a name.
    fn label(&mut self) -> Parsed<Option<Name>> {
        self.step();
        self.expect("(")?;
        let label = if self.is_symbol(")") { None } else { Some(self.name("a label")?) };
        self.expect(")")?;
        Ok(label)
    }

    fn rung(&mut self) -> Parsed<Rung> {
        self.step();
        let from = self.rung_start()?;
        let mut steps = Vec::new();
        while !self.takes_word("END_RUNG") {
            if self.is_end() || self.is_statement_end() || self.is_word("RUNG") || self.is_word("NETWORK") {
                return self.fail("END_RUNG");
            }
            let step = if let Some(wire) = self.takes_wire() {
                Step::Wire(wire)
            } else if self.is_word("NOT") && self.symbol_ahead(1) != "(" {
                Step::Not(self.step().span)
            } else {
                Step::Element(self.element()?)
            };
            steps.push(step);
        }
        Ok(Rung { from, steps, to: self.takes_wire() })
    }

    fn rung_start(&mut self) -> Parsed<From> {
        if let Some(wire) = self.takes_wire() {
            let is_rail = wire.key() == "POWERRAIL";
            return Ok(if is_rail { From::Nothing { is_rail } } else { From::Wire(wire) });
        }
        let is_element = self.is_word("END_RUNG") || self.is_word("NOT") || self.is_call();
        match is_element {
            true => Ok(From::Nothing { is_rail: false }),
            false => Ok(From::Operand(self.primary()?)),
        }
    }

    /// Whether an element starts here: a name, with members and indices if any, followed by `(`.
    fn is_call(&self) -> bool {
        let mut depth = 0;
        for by in 0.. {
            let token = self.ahead(by);
            match (token.kind, self.symbol_ahead(by)) {
                (Kind::Symbol, "[") => depth += 1,
                (Kind::Symbol, "]") => depth -= 1,
                (Kind::Symbol, "(") if depth == 0 => return by > 0,
                (Kind::Symbol, ".") => {}
                (Kind::End, _) => return false,
                _ if depth > 0 => {}
                // Two names in a row: the first is an operand.
                (Kind::Word | Kind::Local | Kind::Quoted | Kind::Percent | Kind::Literal, _)
                    if by == 0 || self.symbol_ahead(by - 1) == "." => {}
                _ => return false,
            }
        }
        false
    }

    /// Whether `wire#w1`, without spaces, is `by` tokens ahead.
    fn is_wire(&self, by: usize) -> bool {
        let [word, name] = [self.ahead(by), self.ahead(by + 1)];
        self.word_ahead(by) == "WIRE" && name.kind == Kind::Local && name.span.start == word.span.end
    }

    fn takes_wire(&mut self) -> Option<Name> {
        if !self.is_wire(0) {
            return None;
        }
        let start = self.step().span.start;
        let mut wire = self.name("a wire").ok()?;
        wire.span.start = start;
        Some(wire)
    }

    fn element(&mut self) -> Parsed<Element> {
        let (from, start) = (self.end_before(), self.span());
        let mut attributes = self.attributes_within(from, start.start);
        if REFUSED.contains(&self.word_ahead(0).as_str()) {
            let message = format!("{} is not supported", self.text_of(self.token()));
            return self.refuse(start, &message, Some("use contacts to compare and JumpCoil to jump"));
        }
        let callee = self.callee()?;
        let to = self.span().start;
        attributes.extend(self.attributes_within(self.end_before(), to));
        let equation = self.value_within(from, to, "S7_EXPRESSION").map(|range| self.expression_in(range));
        self.expect("(")?;
        let mut pins = Vec::new();
        while !self.takes(")") {
            if pins.len() == MOST_PINS {
                return self.refuse(start, &format!("more than {MOST_PINS} pins"), Some("use several elements"));
            }
            pins.push(self.pin()?);
            if !self.takes(",") && !self.is_symbol(")") {
                return self.fail("`,` or `)`");
            }
        }
        Ok(Element { callee, attributes, equation, pins, span: start.to(self.before()) })
    }

    fn pin(&mut self) -> Parsed<Pin> {
        let start = self.span();
        let is_name = matches!(self.token().kind, Kind::Word | Kind::Quoted | Kind::Local);
        let is_named = is_name && matches!(self.symbol_ahead(1), ":=" | "=>");
        let name = if is_named { Some(self.name("a pin")?) } else { None };
        let is_output = is_named && self.step_symbol() == "=>";
        let is_inverted = self.is_word("NOT") && self.is_wire(1);
        let value = if matches!(self.symbol_ahead(0), "," | ")") {
            Connection::Open
        } else {
            if is_inverted {
                self.step();
            }
            match self.takes_wire() {
                Some(wire) => Connection::Wire(wire, is_inverted),
                None => Connection::Operand(self.expression()?),
            }
        };
        Ok(Pin { name, is_output, value, span: start.to(self.before()) })
    }

    fn step_symbol(&mut self) -> &str {
        let token = self.step();
        self.text_of(token)
    }
}
