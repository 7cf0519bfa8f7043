//! Reads the networks of a block: LAD and FBD as graphs, SCL as statements.

use super::{Reader, multilingual};
use crate::front::parser::may_set_eno;
use crate::front::syntax::{ExpressionId, Name, Statement};
use crate::ladder::elements::Law;
use crate::ladder::{self, Call, Network, Owner, Parameter, Source, Way, elements};
use parameters::problem::quoted;
use parameters::xml::Element;
use std::collections::{HashMap, HashSet};

/// The object that the UId of a part, access or call denotes.
enum Node {
    /// An element, by its index in the network.
    Element(usize),
    Operand(ExpressionId),
    Label(Name),
}

impl Reader<'_> {
    /// Reads a block's networks: returns their statements and adds the graphs to the tree.
    pub(super) fn networks(&mut self, block: Element, owner: &Owner) -> Vec<Statement> {
        let Some(list) = block.child("ObjectList") else { return Vec::new() };
        let mut statements = Vec::new();
        let mut graphs: Vec<Network> = Vec::new();
        for (number, unit) in list.children("SW.Blocks.CompileUnit").enumerate() {
            let mut network = Network::new(number as u32 + 1, self.span(unit));
            network.title = multilingual(unit, "Title");
            network.comment = multilingual(unit, "Comment");
            let attributes = unit.child("AttributeList");
            let source = attributes.and_then(|list| list.child("NetworkSource"));
            let Some(content) = source.and_then(|source| source.elements().next()) else { continue };
            let language = attributes.and_then(|list| list.child("ProgrammingLanguage")).map_or("", |of| of.text().0);
            let extent = self.extent(content);
            self.report.locate(extent, ladder::network_title(owner, &network));
            match content.name() {
                "FlgNet" => {
                    self.graph(content, &mut network);
                    if matches!(language, "FBD" | "F_FBD") {
                        jump_always(&mut network);
                    }
                    statements.extend(ladder::lower(&mut network, owner, &mut self.tree, self.report));
                    graphs.push(network);
                }
                "StructuredText" => {
                    statements.extend(ladder::comments(&network));
                    let range = self.structured(content);
                    self.tree.may_set_eno |= self.written.text().get(range.clone()).is_some_and(may_set_eno);
                    statements.extend(self.fragments().statements(range));
                }
                other => {
                    let language = match other {
                        "StatementList" => "STL",
                        "Graph" => "GRAPH",
                        _ if language.is_empty() => other,
                        _ => language,
                    };
                    let message = format!("this network is in {language}, which is not supported");
                    let help = "rewrite it in LAD, FBD or SCL; the other networks are still checked";
                    self.report.error(self.span(content), message, Some(help));
                }
            }
        }
        ladder::lint(&graphs, owner, &self.tree.expressions, self.report);
        let number = self.tree.blocks.len();
        self.tree.networks.extend(graphs.into_iter().map(|network| (number, network)));
        statements
    }

    fn graph(&mut self, content: Element, network: &mut Network) {
        for label in content.children("Labels").flat_map(|labels| labels.children("LabelDeclaration")) {
            if let Some(name) = label.child("Label").and_then(|label| label.attribute("Name")) {
                network.labels.push(Name { text: name.to_string(), span: self.span(label) });
            }
        }
        let mut nodes: HashMap<&str, Node> = HashMap::new();
        let mut uids: HashSet<&str> = HashSet::new();
        let mut parts: Vec<(u64, &str, Element)> = Vec::new();
        for (number, part) in content.children("Parts").flat_map(Element::elements).enumerate() {
            let Some(uid) = part.attribute("UId") else {
                self.report.error(self.span(part), "a part has no UId", Some("export the block again"));
                continue;
            };
            if !uids.insert(uid) {
                let message = format!("two parts of the network share the UId {}", quoted(uid));
                self.report.error(self.span(part), message, Some("export the block again"));
                continue;
            }
            match part.name() {
                "Access" if part.attribute("Scope") == Some("Label") => {
                    let name = part.child("Label").and_then(|label| label.attribute("Name")).unwrap_or_default();
                    nodes.insert(uid, Node::Label(Name { text: name.to_string(), span: self.span(part) }));
                }
                "Access" => {
                    let range = self.access(part);
                    let operand = self.fragments().expression(range);
                    nodes.insert(uid, Node::Operand(operand));
                }
                "Part" | "Call" => parts.push((uid.parse().unwrap_or(number as u64), uid, part)),
                other => {
                    let message = format!("{} is not supported in a network", quoted(other));
                    self.report.error(self.span(part), message, Some("redraw the network"));
                }
            }
        }
        // Fragments must be written in document order.
        let mut elements: Vec<(u64, &str, ladder::Element)> = Vec::new();
        for (order, uid, part) in parts {
            let element = if part.name() == "Call" { self.call(part) } else { self.part(part) };
            elements.push((order, uid, element));
        }
        // Where wires do not determine the order, elements execute in the order of their UIds.
        elements.sort_by_key(|(order, ..)| *order);
        for (_, uid, element) in elements {
            nodes.insert(uid, Node::Element(network.elements.len()));
            network.elements.push(element);
        }
        for wire in content.children("Wires").flat_map(|wires| wires.children("Wire")) {
            self.wire(wire, &nodes, network);
        }
    }

    fn part(&mut self, part: Element) -> ladder::Element {
        let mut element = ladder::Element::new(part.attribute("Name").unwrap_or_default(), self.span(part));
        element.has_eno = part.attribute("DisabledENO") != Some("true");
        for child in part.elements() {
            let name = child.attribute("Name").unwrap_or_default();
            match child.name() {
                "Negated" => element.negated.push(name.to_uppercase()),
                "TemplateValue" => element.settings.push((name.to_uppercase(), child.text().0.to_string())),
                "Instance" => {
                    let range = self.instance(child);
                    element.called = Some(self.fragments().expression(range));
                }
                "Equation" => {
                    let (text, range) = child.text();
                    // `OUT := IN1 + IN2`, or only the right-hand side.
                    let text = text.split_once(":=").map_or(text, |(_, value)| value);
                    let range = self.fragment(range.start.max(child.span().start), text.trim_end_matches([';', ' ']));
                    element.equation = Some(self.fragments().expression(range));
                }
                // Ignored: display settings, and types that follow from the operands.
                _ => {}
            }
        }
        element
    }

    fn call(&mut self, call: Element) -> ladder::Element {
        let span = self.span(call);
        let Some(info) = call.child("CallInfo") else {
            self.report.error(span, "a call has no CallInfo", Some("redraw the call"));
            return ladder::Element::new("Call", span);
        };
        let name = info.attribute("Name").unwrap_or_default();
        let mut element = ladder::Element::new(name, span);
        element.has_eno = true;
        let instance = info.child("Instance");
        element.called = match instance {
            Some(instance) => {
                let range = self.instance(instance);
                Some(self.fragments().expression(range))
            }
            None => {
                let range = self.fragment(info.span().start, &format!("\"{name}\""));
                Some(self.fragments().expression(range))
            }
        };
        let parameters = info.children("Parameter").map(|parameter| Parameter {
            name: parameter.attribute("Name").unwrap_or_default().to_string(),
            way: match parameter.attribute("Section").unwrap_or_default() {
                "Output" => Way::Output,
                "InOut" => Way::InOut,
                "Return" => Way::Value,
                _ => Way::Input,
            },
            of: parameter.attribute("Type").map(str::to_string),
        });
        let is_function = instance.is_none();
        element.call = Some(Call { is_function, parameters: parameters.collect() });
        for negated in call.children("Negated") {
            element.negated.extend(negated.attribute("Name").map(str::to_uppercase));
        }
        element
    }

    /// Reads a wire: one source and the pins connected to it.
    fn wire(&mut self, wire: Element, nodes: &HashMap<&str, Node>, network: &mut Network) {
        let mut to = wire.elements();
        let Some(from) = to.next() else { return };
        let source = match from.name() {
            "Powerrail" => Some(Source::Rail),
            "IdentCon" | "NameCon" => match from.attribute("UId").and_then(|uid| nodes.get(uid)) {
                Some(Node::Operand(operand)) => Some(Source::Operand(*operand)),
                Some(Node::Element(number)) => {
                    Some(Source::Pin(*number, from.attribute("Name").unwrap_or_default().to_uppercase()))
                }
                Some(Node::Label(label)) => {
                    for end in to {
                        if let Some(Node::Element(number)) = end.attribute("UId").and_then(|uid| nodes.get(uid)) {
                            network.elements[*number].label = Some(label.clone());
                        }
                    }
                    return;
                }
                None => return self.unknown(from),
            },
            // An open pin receives no value.
            "OpenCon" | "Openbranch" => None,
            other => {
                let message = format!("a wire cannot start at {}", quoted(other));
                return self.report.error(self.span(from), message, Some("export the block again"));
            }
        };
        let Some(source) = source else { return };
        for end in to {
            if self.is_full(end, &source, nodes, network) {
                return;
            }
            match end.name() {
                "NameCon" => match end.attribute("UId").and_then(|uid| nodes.get(uid)) {
                    Some(Node::Element(number)) => {
                        let element = &mut network.elements[*number];
                        let law = elements::named(&element.name).map(|row| row.law).filter(|_| element.call.is_none());
                        let pin = end.attribute("Name").unwrap_or_default().to_uppercase();
                        element.connect(elements::pin_of(law, &pin), source.clone());
                    }
                    _ => self.unknown(end),
                },
                "IdentCon" => match (end.attribute("UId").and_then(|uid| nodes.get(uid)), &source) {
                    // The variable of a coil may be drawn as if it were its output.
                    (Some(Node::Operand(target)), Source::Pin(number, pin))
                        if matches!(pin.as_str(), "OPERAND" | "BIT") =>
                    {
                        network.elements[*number].connect(pin, Source::Operand(*target));
                    }
                    (Some(Node::Operand(target)), Source::Pin(number, pin)) => {
                        network.elements[*number].write(pin, *target);
                    }
                    (Some(Node::Operand(_)), _) => {
                        let message = "a wire connects two operands without an element between them";
                        self.report.error(self.span(end), message, Some("put a coil between them"));
                    }
                    _ => self.unknown(end),
                },
                "OpenCon" | "Openbranch" => {
                    if let Source::Pin(number, pin) = &source {
                        network.elements[*number].open.push(pin.clone());
                    }
                }
                other => {
                    let message = format!("a wire cannot end at {}", quoted(other));
                    self.report.error(self.span(end), message, Some("export the block again"));
                }
            }
        }
    }

    /// Whether an element at either end of a wire already has the maximum number of pins; if so, reports an error.
    fn is_full(&mut self, end: Element, source: &Source, nodes: &HashMap<&str, Node>, network: &Network) -> bool {
        let target = match end.attribute("UId").and_then(|uid| nodes.get(uid)) {
            Some(Node::Element(number)) => Some(*number),
            _ => None,
        };
        let from = match source {
            Source::Pin(number, _) => Some(*number),
            _ => None,
        };
        let is_full = |number: &usize| {
            let element = &network.elements[*number];
            element.inputs.len().max(element.outputs.len()).max(element.open.len()) >= ladder::MOST_PINS
        };
        let full = target.into_iter().chain(from).find(is_full);
        if let Some(number) = full {
            let message = format!("{} has more than {} pins", network.elements[number].name, ladder::MOST_PINS);
            self.report.error(self.span(end), message, Some("use several elements"));
        }
        full.is_some()
    }

    fn unknown(&mut self, end: Element) {
        let uid = end.attribute("UId").unwrap_or_default();
        let message = format!("a wire leads to UId {}, which does not exist in the network", quoted(uid));
        self.report.error(self.span(end), message, Some("export the block again"));
    }
}

/// Connects each FBD jump without an input to TRUE, so that it always jumps.
fn jump_always(network: &mut Network) {
    for element in network.elements.iter_mut().filter(|element| element.call.is_none() && element.inputs.is_empty()) {
        if matches!(elements::named(&element.name).map(|row| row.law), Some(Law::Jump(_) | Law::Return(_))) {
            element.connect("IN", Source::Rail);
        }
    }
}
