//! Warns about likely mistakes in networks: several coils on one variable, an edge bit used twice, networks that never
//! run, and results that depend on the order of elements.

use super::elements::{self, Formula, Law};
use super::flow::shown;
use super::lower::network_title;
use super::{Element, Network, Owner, Source};
use crate::front::syntax::{ExpressionId, ExpressionKind, Expressions, Unary};
use crate::report::Report;
use std::collections::{BTreeMap, HashMap};

/// Networks with more elements are not checked for order dependence.
const MOST_ELEMENTS: usize = 1000;

/// Warns about suspicious constructs in the networks of a block.
pub(crate) fn lint(networks: &[Network], owner: &Owner, expressions: &Expressions, report: &mut Report) {
    let blocks = networks.iter().flat_map(|network| network.elements.iter().map(move |element| (network, element)));
    let all: Vec<(&Network, &Element)> = blocks.collect();
    let lint = Lint { owner, expressions };
    lint.written_twice(&all, report);
    lint.shared_bits(&all, report);
    lint.never_run(networks, report);
    for network in networks.iter().filter(|network| network.elements.len() <= MOST_ELEMENTS) {
        lint.order(network, report);
    }
}

struct Lint<'a> {
    owner: &'a Owner,
    expressions: &'a Expressions,
}

/// The variables that an element reads and writes, in source notation.
#[derive(Default)]
struct Uses {
    reads: Vec<String>,
    writes: Vec<String>,
}

fn law(element: &Element) -> Option<Law> {
    elements::named(&element.name).filter(|_| element.call.is_none()).map(|row| row.law)
}

impl Lint<'_> {
    /// The name of a variable in upper case, ignoring the NOT of a negated pin; `None` for any other expression.
    fn name(&self, id: ExpressionId) -> Option<String> {
        match &self.expressions[id].kind {
            ExpressionKind::Unary(Unary::Not, inner) => self.name(*inner),
            ExpressionKind::Name(..) | ExpressionKind::Member(..) | ExpressionKind::Index(..) => {
                Some(shown(self.expressions, id).to_uppercase())
            }
            _ => None,
        }
    }

    fn operands<'e>(&self, element: &'e Element, pin: &'e str) -> impl Iterator<Item = String> + use<'_, 'e> {
        let inputs = element.inputs.iter().filter(move |input| input.pin == pin).flat_map(|input| &input.sources);
        inputs.filter_map(|source| match source {
            Source::Operand(operand) => self.name(*operand),
            _ => None,
        })
    }

    fn written_twice(&self, all: &[(&Network, &Element)], report: &mut Report) {
        let mut first: BTreeMap<String, &Network> = BTreeMap::new();
        // A jump or a return may cause only one of the coils to run.
        if all.iter().any(|(_, element)| matches!(law(element), Some(Law::Jump(_) | Law::Return(_)))) {
            return;
        }
        for (network, element) in all {
            if !matches!(law(element), Some(Law::Coil(_))) {
                continue;
            }
            for name in self.operands(element, "OPERAND") {
                match first.get(&name) {
                    None => drop(first.insert(name, network)),
                    Some(before) => {
                        let message = format!(
                            "a coil in network {} writes the same variable: this one overwrites it",
                            before.number
                        );
                        let help = "write the variable with one coil, after all conditions, or use set and reset coils";
                        report.warning(element.span, message, Some(help));
                    }
                }
            }
        }
    }

    fn shared_bits(&self, all: &[(&Network, &Element)], report: &mut Report) {
        let mut first: BTreeMap<String, &Network> = BTreeMap::new();
        for (network, element) in all {
            for name in self.operands(element, "BIT") {
                match first.get(&name) {
                    None => drop(first.insert(name, network)),
                    Some(before) => {
                        let message = format!(
                            "this edge shares its memory bit with an edge in network {}: edges are missed or \
                             detected twice",
                            before.number
                        );
                        report.warning(element.span, message, Some("use a separate bit for each edge"));
                    }
                }
            }
        }
    }

    fn never_run(&self, networks: &[Network], report: &mut Report) {
        let mut left: Option<u32> = None;
        for network in networks {
            let has_label = !network.labels.is_empty()
                || network.elements.iter().any(|element| matches!(law(element), Some(Law::Label)));
            if has_label {
                left = None;
            }
            if let Some(before) = left {
                let message = format!("this network never runs: network {before} returns or jumps unconditionally");
                let place = network_title(self.owner, network);
                report.warning(network.span, format!("{place}: {message}"), Some("delete it, or give it a label"));
                continue;
            }
            let leaves = network.elements.iter().any(|element| {
                let is_always = element.inputs.iter().any(|input| {
                    input.pin == "IN"
                        && matches!(input.sources.as_slice(), [Source::Rail])
                        && element.negated.is_empty()
                });
                is_always && matches!(law(element), Some(Law::Jump(true) | Law::Return(_)))
            });
            if leaves {
                left = Some(network.number);
            }
        }
    }

    /// The variables that an element reads and writes.
    fn uses(&self, element: &Element) -> Uses {
        let law = law(element);
        let is_written = |pin: &str| match law {
            Some(Law::Coil(_) | Law::Set(_) | Law::SetField(_) | Law::FlipFlop(_)) => pin == "OPERAND",
            Some(Law::EdgeCoil(_)) => pin == "OPERAND" || pin == "BIT",
            Some(Law::EdgeContact(_) | Law::EdgeOfFlow(_)) => pin == "BIT",
            Some(Law::Box(Formula::Step(_), _)) => pin == "OPERAND",
            _ => false,
        };
        let mut uses = Uses::default();
        for input in &element.inputs {
            let names: Vec<String> = self.operands(element, &input.pin).collect();
            if is_written(&input.pin) { uses.writes.extend(names) } else { uses.reads.extend(names) }
        }
        uses.writes.extend(element.outputs.iter().filter_map(|(_, target)| self.name(*target)));
        uses
    }

    /// Warns about a variable that one element writes and another reads, if no wires determine which one runs first.
    fn order(&self, network: &Network, report: &mut Report) {
        let uses: Vec<Uses> = network.elements.iter().map(|element| self.uses(element)).collect();
        let mut readers: HashMap<&str, Vec<usize>> = HashMap::new();
        for (number, uses) in uses.iter().enumerate() {
            uses.reads.iter().for_each(|name| readers.entry(name.as_str()).or_default().push(number));
        }
        for (writer, written) in uses.iter().enumerate() {
            for name in &written.writes {
                let Some(readers) = readers.get(name.as_str()) else { continue };
                let needed = needed(network, writer);
                for reader in readers.iter().filter(|reader| **reader != writer && !needed[**reader]) {
                    let element = &network.elements[*reader];
                    if self::needed(network, *reader)[writer] {
                        continue;
                    }
                    let (which, where_) = if *reader < writer { ("old", "before") } else { ("new", "after") };
                    let message = format!(
                        "this reads the {which} value of a variable written by {} in the same network, \
                         as it runs {where_} that element",
                        network.elements[writer].name
                    );
                    report.warning(element.span, message, Some("put the two in separate networks"));
                }
            }
        }
    }
}

/// Marks the elements whose results an element needs, directly or indirectly.
fn needed(network: &Network, of: usize) -> Vec<bool> {
    let mut is_needed = vec![false; network.elements.len()];
    let mut open = vec![of];
    while let Some(number) = open.pop() {
        let sources = network.elements[number].inputs.iter().flat_map(|input| &input.sources);
        for source in sources {
            if let Source::Pin(other, _) = source
                && let Some(is_known) = is_needed.get_mut(*other)
                && !std::mem::replace(is_known, true)
            {
                open.push(*other);
            }
        }
    }
    is_needed
}
