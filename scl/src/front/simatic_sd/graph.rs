//! Builds the graph of a network from its rungs.

use super::rungs::{self, Connection, From, Rung, Step};
use crate::front::lexer::Span;
use crate::front::parser::Parser;
use crate::front::syntax::{ExpressionId, ExpressionKind, Name, Scope, Unary, attribute, key};
use crate::ladder::elements::{self, Law};
use crate::ladder::{Call, Element, Network, Source};
use std::collections::BTreeMap;

/// The variables of a block and their type names, in upper case.
pub(super) type Variables = BTreeMap<String, String>;

/// The maximum number of wires in a row without an element between them.
const MOST_WIRES: usize = 100;

/// The power flow at a position in a rung.
#[derive(Clone, Debug)]
enum Flow {
    /// None: an FBD rung whose first element has no input.
    Nothing,
    /// The value of one source.
    Of(Source),
    /// The value of a wire.
    Wire(Name),
}

/// The graph of a network under construction.
struct Graph<'p, 'a, 's> {
    parser: &'p mut Parser<'a>,
    /// The block's variables and their type names, in upper case.
    variables: &'s Variables,
    network: Network,
    /// The flows into each wire.
    wires: BTreeMap<String, Vec<Flow>>,
    /// The pins fed by wires: the element's index, the pin and the wire.
    pending: Vec<(usize, String, Name)>,
}

impl Parser<'_> {
    /// Builds the graph of a network.
    pub(crate) fn graph(&mut self, written: rungs::Network, mut network: Network, variables: &Variables) -> Network {
        network.labels = written.labels;
        let mut graph = Graph { parser: self, variables, network, wires: BTreeMap::new(), pending: Vec::new() };
        for rung in written.rungs {
            graph.rung(rung);
        }
        graph.join();
        graph.network
    }
}

impl Graph<'_, '_, '_> {
    fn error(&mut self, span: Span, message: impl Into<String>, help: &str) {
        self.parser.report.error(span, message.into(), Some(help));
    }

    fn rung(&mut self, rung: Rung) {
        let mut flow = match rung.from {
            From::Nothing { is_rail: true } => Flow::Of(Source::Rail),
            From::Nothing { is_rail: false } => Flow::Nothing,
            From::Wire(wire) => Flow::Wire(wire),
            From::Operand(operand) => Flow::Of(Source::Operand(operand)),
        };
        for step in rung.steps {
            flow = match step {
                Step::Wire(wire) => self.place(flow, wire),
                Step::Not(span) => {
                    let number = self.add(Element::new("Not", span));
                    self.flow(number, Some(Law::Not), flow, span)
                }
                Step::Element(element) => self.element(element, flow),
            };
        }
        if let Some(wire) = rung.to {
            self.place(flow, wire);
        }
    }

    /// Adds a flow to a wire; returns the flow of the wire, with which the rung continues.
    fn place(&mut self, flow: Flow, wire: Name) -> Flow {
        let into = self.wires.entry(wire.key()).or_default();
        if !matches!(flow, Flow::Nothing) {
            into.push(flow);
        }
        Flow::Wire(wire)
    }

    fn add(&mut self, element: Element) -> usize {
        self.network.elements.push(element);
        self.network.elements.len() - 1
    }

    fn connect(&mut self, number: usize, pin: &str, flow: Flow) {
        match flow {
            Flow::Nothing => {}
            Flow::Of(source) => self.network.elements[number].connect(pin, source),
            Flow::Wire(wire) => self.pending.push((number, pin.to_string(), wire)),
        }
    }

    fn element(&mut self, written: rungs::Element, flow: Flow) -> Flow {
        let (name, scope, instance) = self.called(&written);
        let span = written.span;
        let is_variable = instance.is_none() && self.variables.contains_key(&name.key());
        let row = elements::named(&name.text).filter(|_| scope == Scope::Bare);
        let law = row.map(|row| row.law);
        let mut element = Element::new(&name.text, span);
        self.settings(&mut element, &written);
        match (law, instance) {
            (Some(Law::FlipFlop(_)), Some(_)) => {}
            (Some(Law::Return(_)), _) if written.pins.iter().any(|pin| !matches!(pin.value, Connection::Open)) => {
                element.name = "ReturnValue".to_string();
            }
            (Some(_), instance) => element.called = instance,
            // The instruction is the instance's own type: `#stop.ESTOP1( ... )`.
            (None, Some(instance)) if self.is_type_of(instance, &name) => element.called = Some(instance),
            _ => {
                let is_function = instance.is_none() && scope != Scope::Local && !is_variable;
                element.call = Some(Call { is_function, parameters: Vec::new() });
                element.called = Some(written.callee);
            }
        }
        let number = self.add(element);
        if let (Some(Law::FlipFlop(_)), Some(operand)) = (law, instance) {
            self.network.elements[number].connect("OPERAND", Source::Operand(operand));
        }
        self.pins(number, written.pins, law);
        self.flow(number, law, flow, span)
    }

    /// The name by which an element is called, its notation, and the instance that precedes it, if any.
    fn called(&self, written: &rungs::Element) -> (Name, Scope, Option<ExpressionId>) {
        match &self.parser.tree.expressions[written.callee].kind {
            ExpressionKind::Name(scope, name) => (name.clone(), *scope, None),
            ExpressionKind::Member(instance, name) => (name.clone(), Scope::Bare, Some(*instance)),
            // An element of an array of instances.
            _ => (Name { text: String::new(), span: written.span }, Scope::Local, None),
        }
    }

    /// Whether a name denotes a known function, or the type name of an instance starts with it: `TON` for TON_TIME.
    fn is_type_of(&self, instance: ExpressionId, name: &Name) -> bool {
        let of = match &self.parser.tree.expressions[instance].kind {
            ExpressionKind::Name(_, variable) => self.variables.get(&variable.key()),
            _ => None,
        };
        let is_known = crate::library::is_block(&name.key());
        is_known || of.is_some_and(|of| of.starts_with(&name.key()))
    }

    fn settings(&mut self, element: &mut Element, written: &rungs::Element) {
        let attributes = &written.attributes;
        element.has_eno = attribute(attributes, "S7_GENERATEENO")
            .is_some_and(|value| value.eq_ignore_ascii_case("true"))
            || attribute(attributes, "DISABLEENO").is_some_and(|value| value.eq_ignore_ascii_case("false"));
        let templates = attribute(attributes, "S7_TEMPLATES").unwrap_or_default().trim_matches(['[', ']']);
        for template in templates.split(',') {
            if let Some((name, value)) = template.split_once(":=") {
                element.settings.push((key(name.trim()), value.trim().to_string()));
            }
        }
        let others = attributes.iter().filter(|own| !own.key.starts_with("S7_"));
        element.settings.extend(others.map(|own| (own.key.clone(), own.value.clone())));
        element.equation = written.equation;
    }

    fn pins(&mut self, number: usize, pins: Vec<rungs::Pin>, law: Option<Law>) {
        let by_position = law.map_or(&[][..], positions);
        for (at, pin) in pins.into_iter().enumerate() {
            let name = match (&pin.name, by_position.get(at)) {
                (Some(name), _) => name.key(),
                (None, Some(name)) => (*name).to_string(),
                (None, None) => {
                    self.error(pin.span, "this pin has no name", "write PIN := before it");
                    continue;
                }
            };
            let name = elements::pin_of(law, &name);
            if matches!(law, Some(Law::Jump(_) | Law::Label)) {
                self.label(number, &pin);
                continue;
            }
            let is_output = pin.is_output && !matches!(name, "OPERAND" | "TIMER");
            match (pin.value, is_output) {
                (Connection::Open, false) => {}
                (Connection::Open, true) => self.network.elements[number].open.push(name.to_string()),
                (Connection::Operand(target), true) => self.network.elements[number].write(name, target),
                (Connection::Operand(operand), false) => self.operand(number, name, operand),
                (Connection::Wire(wire, is_negated), true) => {
                    if is_negated {
                        self.error(
                            pin.span,
                            "NOT is not allowed before the wire of an output pin",
                            "move it to where the wire is used",
                        );
                    }
                    // The pin counts as open, too, because the wire may lead nowhere.
                    self.network.elements[number].open.push(name.to_string());
                    self.place(Flow::Of(Source::Pin(number, name.to_string())), wire);
                }
                (Connection::Wire(wire, is_negated), false) => {
                    if is_negated {
                        self.network.elements[number].negated.push(name.to_string());
                    }
                    self.connect(number, name, Flow::Wire(wire));
                }
            }
        }
    }

    fn operand(&mut self, number: usize, pin: &str, operand: ExpressionId) {
        let is_negated = matches!(self.parser.tree.expressions[operand].kind, ExpressionKind::Unary(Unary::Not, _));
        if is_negated && pin == "OPERAND" {
            let span = self.parser.tree.expressions[operand].span;
            self.error(span, "an operand cannot be negated with NOT", "use I_Contact or I_Coil");
        }
        self.network.elements[number].connect(pin, Source::Operand(operand));
    }

    fn label(&mut self, number: usize, pin: &rungs::Pin) {
        if let Connection::Operand(label) = pin.value
            && let ExpressionKind::Name(_, name) = &self.parser.tree.expressions[label].kind
        {
            self.network.elements[number].label = Some(name.clone());
        }
    }

    /// Connects the flow to the pin that accepts it; returns the flow that leaves the element.
    fn flow(&mut self, number: usize, law: Option<Law>, flow: Flow, span: Span) -> Flow {
        let (entrance, exit) = flow_pins(law);
        let element = &self.network.elements[number];
        let is_taken = element.inputs.iter().any(|input| input.pin == entrance)
            || self.pending.iter().rev().take_while(|(of, ..)| *of == number).any(|(_, pin, _)| pin == entrance);
        let is_rail = matches!(flow, Flow::Of(Source::Rail) | Flow::Nothing);
        let is_open = matches!(flow, Flow::Nothing);
        match (is_taken, law) {
            // An FBD jump without an input always jumps.
            (false, Some(Law::Jump(_) | Law::Return(_))) if is_open => {
                self.connect(number, entrance, Flow::Of(Source::Rail));
            }
            (false, Some(law)) if is_open && needs_flow(law) => {
                let message = format!("nothing is connected to {}", entrance.to_lowercase());
                self.error(span, message, "start the rung with an operand, or delete the rung");
            }
            (false, _) => self.connect(number, entrance, flow),
            (true, _) if is_rail => {}
            (true, Some(Law::Instance(_))) => self.connect(number, "EN", flow),
            (true, _) => {
                let message = format!("both power flow and a value are connected to {}", entrance.to_lowercase());
                self.error(span, message, "remove one of them");
            }
        }
        Flow::Of(Source::Pin(number, exit.to_string()))
    }

    /// Connects each pin fed by a wire to the wire's source or, if it has several, to an OR gate that combines them.
    fn join(&mut self) {
        let mut joined: BTreeMap<String, Option<Source>> = BTreeMap::new();
        for (number, pin, wire) in std::mem::take(&mut self.pending) {
            if let Some(source) = self.source(&wire, &mut joined, &mut Vec::new()) {
                self.network.elements[number].connect(&pin, source);
            }
        }
    }

    fn source(
        &mut self,
        wire: &Name,
        joined: &mut BTreeMap<String, Option<Source>>,
        open: &mut Vec<String>,
    ) -> Option<Source> {
        let name = wire.key();
        if let Some(source) = joined.get(&name) {
            return source.clone();
        }
        if open.contains(&name) {
            self.error(wire.span, format!("wire#{} leads to itself", wire.text), "put a variable in between");
            return None;
        }
        if open.len() == MOST_WIRES {
            let message = format!("more than {MOST_WIRES} wires in a row");
            self.error(wire.span, message, "replace several of them with one wire");
            return None;
        }
        let flows = self.wires.get(&name).cloned().unwrap_or_default();
        if flows.is_empty() {
            let message = format!("nothing leads to wire#{}", wire.text);
            self.error(wire.span, message, "end a rung with END_RUNG and this wire, or write it after an element");
        }
        open.push(name.clone());
        let mut sources = Vec::new();
        for flow in flows {
            match flow {
                Flow::Nothing => {}
                Flow::Of(source) => sources.push(source),
                Flow::Wire(other) => sources.extend(self.source(&other, joined, open)),
            }
        }
        open.pop();
        let source = match sources.len() {
            0 => None,
            1 => sources.pop(),
            _ => {
                let mut gate = Element::new("O", wire.span);
                sources.into_iter().for_each(|source| gate.connect("IN1", source));
                Some(Source::Pin(self.add(gate), "OUT".to_string()))
            }
        };
        joined.insert(name, source.clone());
        source
    }
}

/// The pins through which the flow enters and leaves an element.
fn flow_pins(law: Option<Law>) -> (&'static str, &'static str) {
    match law {
        None | Some(Law::Box(..) | Law::Demultiplex | Law::Statement(_) | Law::System) => ("EN", "ENO"),
        Some(Law::Compare(_) | Law::Range(_) | Law::Valid(_)) => ("PRE", "OUT"),
        Some(Law::Gate(_)) => ("IN1", "OUT"),
        Some(Law::FlipFlop(false)) => ("S", "Q"),
        Some(Law::FlipFlop(true)) => ("R", "Q"),
        Some(Law::Instance("CTU")) => ("CU", "Q"),
        Some(Law::Instance("CTD")) => ("CD", "Q"),
        Some(Law::Instance("CTUD")) => ("CU", "QU"),
        Some(Law::Instance(_)) => ("IN", "Q"),
        Some(_) => ("IN", "OUT"),
    }
}

/// Whether an element needs a flow although its law does not require one.
fn needs_flow(law: Law) -> bool {
    let is_timer = matches!(law, Law::TimerCoil(_) | Law::TimerFunction(_));
    is_timer || matches!(law, Law::Gate(_) | Law::Coil(_) | Law::Set(_) | Law::EdgeCoil(_) | Law::SetField(_))
}

/// The pins that may be written without a name, in order of position.
fn positions(law: Law) -> &'static [&'static str] {
    match law {
        Law::EdgeOfFlow(_) => &["BIT"],
        Law::EdgeContact(_) | Law::EdgeCoil(_) => &["OPERAND", "BIT"],
        Law::Compare(_) => &["IN1", "IN2"],
        Law::Range(_) => &["MIN", "IN", "MAX"],
        Law::SetField(_) => &["OPERAND", "N"],
        // The dominant input.
        Law::FlipFlop(false) => &["R1"],
        Law::FlipFlop(true) => &["S1"],
        Law::TimerCoil(_) | Law::TimerFunction(_) => &["TIMER", "PT"],
        _ => &["OPERAND"],
    }
}
