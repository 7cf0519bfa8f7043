//! Orders the elements of a network and translates them into statements.

use super::Pin;
use super::elements::Law;
use super::flow::{Value, Values, shown};
use super::{Element, Network, Source, elements};
use crate::front::lexer::Span;
use crate::front::syntax::{
    Binary, ExpressionId, ExpressionKind, Expressions, Name, SectionKind, SourceBlock, Statement, StatementKind, Tree,
};
use crate::report::Report;
use parameters::problem::quoted;
use std::collections::{BTreeMap, BTreeSet};

/// The block that owns the networks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Owner {
    /// Its title in messages: `FB Motor`.
    pub title: String,
    /// The names of its variables, in upper case.
    pub names: BTreeSet<String>,
    /// Its variables that may alias others: in-outs, views and the variables they overlay.
    pub shared: BTreeSet<String>,
}

impl Owner {
    /// Collects the properties of a block that its networks need.
    pub(crate) fn new(block: &SourceBlock) -> Owner {
        let mut owner = Owner { title: block.title(), ..Owner::default() };
        for section in &block.sections {
            for name in section.members.iter().flat_map(|member| &member.names) {
                owner.names.insert(name.key());
                if section.kind == SectionKind::InOut {
                    owner.shared.insert(name.key());
                }
            }
            for member in &section.members {
                // A view (AT) and the variable it overlays may alias each other and any further view.
                if let Some(at) = &member.at {
                    owner.shared.insert(at.key());
                    owner.shared.extend(member.names.iter().map(Name::key));
                }
            }
        }
        owner
    }
}

/// The translation of the networks of one block.
pub(super) struct Lowerer<'a> {
    pub owner: &'a Owner,
    pub tree: &'a mut Tree,
    pub report: &'a mut Report,
    pub code: Vec<Statement>,
    /// The number of the network, and the number of temporaries created in it.
    pub number: u32,
    pub count: u32,
    /// The names of the network's temporaries, in upper case.
    pub temporaries: BTreeSet<String>,
    /// The values of those output pins of the network that are still needed.
    pub values: Values,
    /// The number of pending uses of each output pin.
    pub uses: BTreeMap<Pin, usize>,
    /// The source location of each element.
    pub spans: Vec<Span>,
    /// The pins of the current element read by its law, and those set by it.
    asked: BTreeSet<String>,
    given: BTreeSet<String>,
    /// The values of the pins, for watching the network while it runs.
    carried: Vec<(Pin, Option<ExpressionId>)>,
}

/// Translates a network into statements.
pub(crate) fn lower(network: &mut Network, owner: &Owner, tree: &mut Tree, report: &mut Report) -> Vec<Statement> {
    let mut lowerer = Lowerer {
        owner,
        tree,
        report,
        code: Vec::new(),
        number: network.number,
        count: 0,
        temporaries: BTreeSet::new(),
        values: Values::default(),
        uses: uses(network),
        spans: network.elements.iter().map(|element| element.span).collect(),
        asked: BTreeSet::new(),
        given: BTreeSet::new(),
        carried: Vec::new(),
    };
    lowerer.network(network);
    let Lowerer { code, carried, .. } = lowerer;
    network.carried = carried;
    code
}

/// The title and comment of a network as comment statements.
pub(crate) fn comments(network: &Network) -> Vec<Statement> {
    let title = format!("Network {}: {}", network.number, network.title);
    let title = title.trim_end_matches([' ', ':']).to_string();
    let texts = [title, network.comment.clone()].into_iter().filter(|text| !text.is_empty());
    texts.map(|text| Statement { kind: StatementKind::Comment(text), span: network.span }).collect()
}

/// The title of a network in messages.
pub(crate) fn network_title(owner: &Owner, network: &Network) -> String {
    let title = if network.title.is_empty() { String::new() } else { format!(" \"{}\"", network.title) };
    format!("{}, network {}{title}", owner.title, network.number)
}

impl Lowerer<'_> {
    fn network(&mut self, network: &Network) {
        let place = network_title(self.owner, network);
        self.report.locate(network.span, place.clone());
        self.code.extend(comments(network));
        for label in &network.labels {
            self.push(StatementKind::Label(label.clone()), label.span);
        }
        for element in &network.elements {
            let title = self.element_title(element);
            self.locate(element, &format!("{place}: {title}"));
        }
        for number in self.order(network) {
            self.element(&network.elements, number);
        }
    }

    /// The title of an element in messages: `Contact "Ready"`.
    fn element_title(&self, element: &Element) -> String {
        let operand = element.inputs.iter().filter(|input| input.pin == "OPERAND").flat_map(|input| &input.sources);
        let operand = operand.filter_map(|source| match source {
            Source::Operand(operand) => Some(*operand),
            _ => None,
        });
        match operand.chain(element.called).next() {
            Some(operand) => format!("{} {}", element.name, shown(&self.tree.expressions, operand)),
            None => element.name.clone(),
        }
    }

    /// Records the location of an element and its operands, for messages.
    fn locate(&mut self, element: &Element, place: &str) {
        self.report.locate(element.span, place.to_string());
        let inputs = element.inputs.iter().flat_map(|input| &input.sources).filter_map(|source| match source {
            Source::Operand(operand) => Some(*operand),
            _ => None,
        });
        let outputs = element.outputs.iter().map(|(_, target)| *target);
        for operand in inputs.chain(outputs).chain(element.called).chain(element.equation) {
            self.report.locate(self.tree.expressions[operand].span, place.to_string());
        }
    }

    /// The execution order of a network: each element after those whose pins it needs.
    fn order(&mut self, network: &Network) -> Vec<usize> {
        let elements = &network.elements;
        let mut needed: Vec<Vec<usize>> = elements.iter().map(needed).collect();
        let (any, circles) = each_after_its_needs(0..elements.len(), &needed);
        for number in circles {
            let message = "the wires form a cycle: this element depends on its own result";
            let help = "break the cycle with a variable that a coil writes and a contact reads";
            self.report.error(elements[number].span, message, Some(help));
        }
        // The elements that an element needs execute in the order of the network, not of its pins; a junction is placed
        // at its first source.
        let mut places: Vec<usize> = (0..elements.len()).collect();
        let is_junction = |number: &usize| is_junction(&elements[*number], &self.tree.expressions);
        for number in any.into_iter().filter(is_junction) {
            places[number] = needed[number].iter().map(|needed| places[*needed]).min().unwrap_or(number);
        }
        needed.iter_mut().for_each(|needed| needed.sort_by_key(|number| places[*number]));
        // A junction of wires must not move anything forward: not every format has an element for it.
        let (junctions, others): (Vec<usize>, Vec<usize>) = (0..elements.len()).partition(is_junction);
        each_after_its_needs(others.into_iter().chain(junctions), &needed).0
    }

    /// Whether a pin still has pending uses.
    pub(super) fn is_awaited(&self, pin: &Pin) -> bool {
        self.uses.get(pin).is_some_and(|uses| *uses > 0)
    }

    /// The value at an input pin of an element; `None` if it is unconnected.
    pub(super) fn input(&mut self, element: &Element, pin: &str) -> Option<Value> {
        let input = element.inputs.iter().find(|input| input.pin == pin)?;
        self.asked.insert(pin.to_string());
        let mut all: Option<Value> = None;
        for source in &input.sources {
            let value = match source {
                Source::Rail => Value::TRUE,
                Source::Operand(operand) => self.value(*operand),
                Source::Pin(number, pin) => {
                    let pin = (*number, pin.to_uppercase());
                    let uses = self.uses.get_mut(&pin).map_or(0, |uses| {
                        *uses = uses.saturating_sub(1);
                        *uses
                    });
                    let value = if uses == 0 { self.values.remove(&pin) } else { self.values.get(&pin).cloned() };
                    value.unwrap_or_else(|| self.no_value(&pin.1, element))
                }
            };
            all = Some(match all {
                None => value,
                Some(before) => self.joined(Binary::Or, before, value, element.span),
            });
        }
        let value = all?;
        let is_negated = element.negated.iter().any(|negated| negated == pin);
        Some(if is_negated { self.negated(value, element.span) } else { value })
    }

    /// The value used for a pin that carries none, which is reported as an error unless there are errors already.
    fn no_value(&mut self, pin: &str, element: &Element) -> Value {
        if !self.report.has_errors() {
            let message = format!("{} is wired to pin {pin}, which carries no value", element.name);
            self.report.error(element.span, message, None);
        }
        let of = self.tree.expressions.add(ExpressionKind::Wrong, element.span);
        self.value(of)
    }

    /// The power flow at the first of these pins that is connected.
    pub(super) fn flow(&mut self, element: &Element, pins: &[&str]) -> Value {
        match pins.iter().find_map(|pin| self.input(element, pin)) {
            Some(value) => value,
            None => {
                // A box with unconnected EN runs, as do comparisons in FBD. A coil without a source is an error unless
                // one was already reported.
                if pins == ["IN"] || pins.first() == Some(&"IN") && !self.report.has_errors() {
                    let message = format!("{} has no power flow: its input is not connected", element.name);
                    self.report.error(element.span, message, Some("wire it, or delete it"));
                }
                Value::TRUE
            }
        }
    }

    /// The operand of an element at a pin; a missing one is reported as an error.
    pub(super) fn operand(&mut self, element: &Element, pin: &str) -> Option<ExpressionId> {
        let value = self.input(element, pin);
        if value.is_none() {
            let message = format!("{} has no {}", element.name, pin.to_lowercase());
            self.report.error(element.span, message, Some("connect a variable"));
        }
        let span = element.span;
        value.map(|value| self.expression(&value, span))
    }

    /// Sets the value of an output pin and writes it to the pin's variables.
    pub(super) fn set(&mut self, elements: &[Element], number: usize, pin: &str, value: Value) {
        let element = &elements[number];
        self.given.insert(pin.to_string());
        let is_negated = element.negated.iter().any(|negated| negated == pin);
        let mut value = if is_negated { self.negated(value, element.span) } else { value };
        let targets: Vec<ExpressionId> =
            element.outputs.iter().filter(|(own, _)| own == pin).map(|(_, target)| *target).collect();
        let pin = (number, pin.to_string());
        let uses = self.uses.get(&pin).copied().unwrap_or(0) + targets.len();
        if uses > 1 {
            value = self.shared(value, element.span);
        }
        if !targets.is_empty() {
            let roots = self.roots(targets.iter().copied());
            value = self.apart(value, &roots, element.span);
        }
        for target in targets {
            let from = self.expression(&value, element.span);
            self.assign(target, from, element.span);
        }
        if self.is_awaited(&pin) {
            self.carry(pin, value);
        }
    }

    /// Sets the value of an output pin that another element needs.
    pub(super) fn carry(&mut self, pin: Pin, value: Value) {
        self.carried.push((pin.clone(), value.of));
        self.values.insert(pin, value);
    }

    /// Saves a value in a temporary for several uses, unless it is a single variable, which can be read again.
    pub(super) fn shared(&mut self, value: Value, span: Span) -> Value {
        let is_plain = value.of.is_none_or(|of| {
            matches!(
                self.tree.expressions[of].kind,
                ExpressionKind::Name(..) | ExpressionKind::Literal(_) | ExpressionKind::Member(..)
            )
        });
        if is_plain { value } else { self.kept(value, span) }
    }

    /// Adds a jump to a label.
    pub(super) fn jump(&mut self, to: &Name, span: Span) {
        self.push(StatementKind::Goto(to.clone()), span);
    }

    fn element(&mut self, elements: &[Element], number: usize) {
        let element = &elements[number];
        let errors = self.report.errors();
        self.asked.clear();
        self.given.clear();
        let row = if element.call.is_some() { None } else { elements::named(&element.name) };
        match row {
            _ if element.call.is_some() => self.call_of(elements, number),
            Some(row) => self.law(row.law, elements, number),
            None => self.other(elements, number),
        }
        if self.report.errors() == errors {
            self.check_pins(element, row.map(|row| row.law));
        }
    }

    /// Rejects a pin that the element does not have, which would otherwise be ignored silently.
    fn check_pins(&mut self, element: &Element, law: Option<Law>) {
        let is_asked = |pin: &&str| !matches!(law, Some(Law::Label)) && !self.asked.contains(*pin);
        let input = element.inputs.iter().map(|input| input.pin.as_str()).find(is_asked);
        // Outputs of calls are arguments, and boxes write whatever they are connected to.
        let is_passed = matches!(
            law,
            None | Some(Law::Box(..) | Law::Demultiplex | Law::Statement(_) | Law::Instance(_) | Law::System)
        );
        let mut outputs = element.outputs.iter().map(|(pin, _)| pin.as_str());
        let output = outputs.find(|pin| !is_passed && !self.given.contains(*pin));
        if let Some(pin) = input.or(output) {
            let message = format!("{} has no pin {}", element.name, pin.to_lowercase());
            self.report.error(element.span, message, Some("disconnect that pin"));
        }
    }

    /// Rejects a gate or box with fewer connected inputs than its setting CARD specifies.
    pub(super) fn check_cardinality(&mut self, element: &Element) {
        let Some(card) = element.setting("CARD") else { return };
        let wired = numbered(element).len();
        match card.trim().parse::<usize>() {
            Ok(card) if card <= wired => {}
            Ok(card) => {
                let message = format!("{} has {card} inputs, but only {wired} are wired", element.name);
                self.report.error(element.span, message, Some("wire all of them, or remove the unconnected ones"));
            }
            Err(_) => {
                let message = format!("{}: {} is not a valid number of inputs", element.name, quoted(card));
                self.report.error(element.span, message, Some("export the block again"));
            }
        }
    }
}

/// The pins IN0, IN1, IN2 and so on of an element, in numeric order.
pub(super) fn numbered(element: &Element) -> Vec<String> {
    let number = |pin: &str| pin.strip_prefix("IN").and_then(|number| number.parse::<u32>().ok());
    let mut pins: Vec<(u32, String)> =
        element.inputs.iter().filter_map(|input| Some((number(&input.pin)?, input.pin.clone()))).collect();
    pins.sort();
    pins.into_iter().map(|(_, pin)| pin).collect()
}

/// Sorts elements topologically, each after those it needs. The second list contains an element of each cycle found.
fn each_after_its_needs(roots: impl Iterator<Item = usize>, needed: &[Vec<usize>]) -> (Vec<usize>, Vec<usize>) {
    let (mut order, mut circles) = (Vec::new(), Vec::new());
    // 1 while the elements that an element needs are visited, 2 afterwards.
    let mut state = vec![0u8; needed.len()];
    for root in roots {
        let mut open = vec![(root, 0)];
        while let Some((number, next)) = open.pop() {
            if state[number] == 2 {
                continue;
            }
            state[number] = 1;
            match needed[number].get(next).copied() {
                None => {
                    state[number] = 2;
                    order.push(number);
                }
                Some(needed) => {
                    open.push((number, next + 1));
                    match state.get(needed) {
                        Some(0) => open.push((needed, 0)),
                        Some(1) => circles.push(number),
                        _ => {}
                    }
                }
            }
        }
    }
    (order, circles)
}

/// Whether an element is merely a junction of wires. In FBD, a literal TRUE takes the place of the power rail.
fn is_junction(element: &Element, expressions: &Expressions) -> bool {
    let mut sources = element.inputs.iter().flat_map(|input| &input.sources);
    let is_read = |id: ExpressionId| !matches!(expressions[id].kind, ExpressionKind::Literal(_));
    let is_gate = element.call.is_none()
        && matches!(elements::named(&element.name).map(|row| row.law), Some(Law::Gate(Binary::Or)));
    let is_at_place = sources.any(|source| matches!(source, Source::Operand(id) if is_read(*id)));
    is_gate && element.outputs.is_empty() && !is_at_place
}

/// The elements to whose output pins an element is wired, once per wire.
fn needed(element: &Element) -> Vec<usize> {
    let sources = element.inputs.iter().flat_map(|input| &input.sources);
    let numbers = sources.filter_map(|source| match source {
        Source::Pin(number, _) => Some(*number),
        _ => None,
    });
    numbers.collect()
}

/// The number of inputs wired to each output pin.
fn uses(network: &Network) -> BTreeMap<Pin, usize> {
    let mut uses = BTreeMap::new();
    let sources = network.elements.iter().flat_map(|element| &element.inputs).flat_map(|input| &input.sources);
    for source in sources {
        if let Source::Pin(number, pin) = source {
            *uses.entry((*number, pin.to_uppercase())).or_insert(0) += 1;
        }
    }
    uses
}
