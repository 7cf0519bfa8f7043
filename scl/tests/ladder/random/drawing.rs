//! Random networks as parts and wires; in FBD, gates replace contacts, and a constant replaces the power rail.

use super::{COMPARISONS, Element, Flow, Kind, Number, OF_WORDS, OPERATIONS, SECTIONS, SHIFTS, TIMERS, labels};
use crate::xml::{self, From, Net, int, local, typed};

const INT: &str = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Int</TemplateValue>";
const WORD: &str = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Word</TemplateValue>";

fn value(of: &Number) -> From {
    match of {
        Number::Variable(at) => local(&format!("n{at}")),
        Number::Constant(value) => int(*value),
    }
}

fn negated(is: bool, pin: &str) -> String {
    if is { format!("<Negated Name=\"{pin}\" />") } else { String::new() }
}

/// Returns a part whose ENO reports failures, or equals EN.
fn with_eno(name: &str, has_eno: bool) -> String {
    format!("{name}{}", if has_eno { "" } else { " DisabledENO=\"true\"" })
}

fn instance(name: &str, net: &mut Net) -> String {
    format!("<Instance Scope=\"LocalVariable\" UId=\"{}\"><Component Name=\"{name}\" /></Instance>", net.next())
}

/// Returns the pin at which the flow leaves.
fn exit(kind: &Kind) -> &'static str {
    match kind {
        Kind::FlipFlop(..) => "q",
        Kind::Timer(..) | Kind::Counter(..) => "Q",
        Kind::Call(_, _, _, false) | Kind::Function(_, _, _, false) => "y",
        Kind::Move(..) | Kind::Calculate(..) | Kind::Formula(..) | Kind::Step(..) | Kind::Select(..) => "eno",
        Kind::Words(..) | Kind::Shift(..) | Kind::Call(..) | Kind::Function(..) => "eno",
        _ => "out",
    }
}

fn bits(net: &mut Net, uid: u32, kind: &Kind, f: From, flow: impl Fn(Flow) -> From, is_fbd: bool) {
    let bit = |bit: &usize| local(&format!("m{bit}"));
    match kind {
        Kind::Contact(name, is_negated) if is_fbd => {
            net.part_at(uid, "A", &negated(*is_negated, "in2"), &[("in1", f), ("in2", local(name))]);
        }
        Kind::Contact(name, is_negated) => {
            net.part_at(uid, "Contact", &negated(*is_negated, "operand"), &[("in", f), ("operand", local(name))]);
        }
        Kind::Or(flows) => {
            let card = format!("<TemplateValue Name=\"Card\" Type=\"Cardinality\">{}</TemplateValue>", flows.len());
            let pins = ["in1", "in2", "in3"].into_iter().zip(flows.iter().map(|from| flow(*from)));
            net.part_at(uid, "O", &card, &pins.collect::<Vec<_>>());
        }
        Kind::Not => net.part_at(uid, "Not", "", &[("in", f)]),
        Kind::Edge(is_rising, name, memory) => {
            let part = if *is_rising { "PContact" } else { "NContact" };
            net.part_at(uid, part, "", &[("pre", f), ("operand", local(name)), ("bit", bit(memory))]);
        }
        Kind::Trigger(is_rising, memory) => {
            net.part_at(uid, if *is_rising { "PBox" } else { "NBox" }, "", &[("in", f), ("bit", bit(memory))]);
        }
        Kind::Compare(which, left, right) => {
            let pins = [("pre", f), ("in1", value(left)), ("in2", value(right))];
            net.part_at(uid, COMPARISONS[*which].0, INT, &pins);
        }
        Kind::Coil(name, is_negated) => {
            net.part_at(uid, "Coil", &negated(*is_negated, "operand"), &[("in", f), ("operand", local(name))]);
        }
        Kind::Set(is_set, name) => {
            net.part_at(uid, if *is_set { "SCoil" } else { "RCoil" }, "", &[("in", f), ("operand", local(name))]);
        }
        Kind::Pulse(is_rising, name, memory) => {
            let part = if *is_rising { "PCoil" } else { "NCoil" };
            net.part_at(uid, part, "", &[("in", f), ("operand", local(name)), ("bit", bit(memory))]);
        }
        Kind::FlipFlop(is_set_dominant, name, other) => {
            let (part, first, second) = if *is_set_dominant { ("Rs", "r", "s1") } else { ("Sr", "s", "r1") };
            net.part_at(uid, part, "", &[(first, f), (second, flow(*other)), ("operand", local(name))]);
        }
        Kind::Jump(is_if, to) => {
            net.part_at(uid, if *is_if { "Jump" } else { "JumpNot" }, "", &[("in", f)]);
            net.jump_to(uid, &format!("L{to}"));
        }
        other => boxed(net, uid, other, f),
    }
}

fn boxed(net: &mut Net, uid: u32, kind: &Kind, f: From) {
    let (number, word) = (|at: &usize| local(&format!("n{at}")), |at: &usize| local(&format!("w{at}")));
    let en = ("en", f);
    match kind {
        Kind::Timer(which, ms) => {
            let inner = instance(&format!("t{which}"), net);
            net.part_at(uid, TIMERS[*which], &inner, &[("IN", en.1), ("PT", typed(&format!("T#{ms}ms")))]);
        }
        Kind::Counter(reset, most) => {
            let inner = instance("c0", net);
            net.part_at(uid, "CTU", &inner, &[("CU", en.1), ("R", local(reset)), ("PV", int(*most))]);
        }
        Kind::Move(from, to) => {
            net.part_at(uid, "Move", "", &[en, ("in", value(from))]);
            net.write(uid, "out1", number(to));
        }
        Kind::Calculate(which, has_eno, left, right, to) => {
            let pins = [en, ("in1", value(left)), ("in2", value(right))];
            net.part_at(uid, &with_eno(OPERATIONS[*which].0, *has_eno), INT, &pins);
            net.write(uid, "out", number(to));
        }
        Kind::Formula(has_eno, values, to) => {
            let inner = format!("{INT}<Equation>(IN1 + IN2) * IN3 - IN1</Equation>");
            let [a, b, c] = values.each_ref().map(value);
            net.part_at(uid, &with_eno("Calc", *has_eno), &inner, &[en, ("in1", a), ("in2", b), ("in3", c)]);
            net.write(uid, "out", number(to));
        }
        Kind::Step(is_up, at) => {
            let of = INT.replace("SrcType", "DestType");
            net.part_at(uid, if *is_up { "Inc" } else { "Dec" }, &of, &[en, ("operand", number(at))]);
        }
        Kind::Select(name, no, yes, to) => {
            let pins = [en, ("G", local(name)), ("IN0", value(no)), ("IN1", value(yes))];
            net.part_at(uid, "SEL", &INT.replace("SrcType", "value_type"), &pins);
            net.write(uid, "OUT", number(to));
        }
        Kind::Words(which, words, to) => {
            let pins = ["in1", "in2", "in3"].into_iter().zip(words.iter().map(word));
            let pins: Vec<_> = [en].into_iter().chain(pins).collect();
            net.part_at(uid, OF_WORDS[*which], WORD, &pins);
            net.write(uid, "out", word(to));
        }
        Kind::Shift(which, from, by, to) => {
            net.part_at(uid, SHIFTS[*which], WORD, &[en, ("in", word(from)), ("n", int(*by as i64))]);
            net.write(uid, "out", word(to));
        }
        Kind::Call(which, x, k, _) => {
            let inner = instance(&format!("s{which}"), net);
            net.call_at(uid, "FB", "Sub", &inner, &[en, ("x", local(x)), ("k", value(k))]);
        }
        Kind::Function(x, k, to, _) => {
            let inner = "<Parameter Name=\"y\" Section=\"Output\" Type=\"Bool\" /><Parameter Name=\"Ret_Val\" Section=\"Return\" Type=\"Int\" />";
            net.call_at(uid, "FC", "Fun", inner, &[en, ("x", local(x)), ("k", value(k))]);
            net.write(uid, "Ret_Val", number(to));
            net.write(uid, "y", local("truth"));
        }
        other => unreachable!("{other:?}"),
    }
}

fn drawn(elements: &[Element], is_fbd: bool) -> Net {
    let mut net = Net::new("random");
    // The UIds follow the order in the file, where an element may precede those it needs, so they are assigned first.
    let mut places: Vec<usize> = (0..elements.len()).collect();
    places.sort_by_key(|at| elements[*at].place);
    let mut uids = vec![0; elements.len()];
    for at in &places {
        uids[*at] = net.next();
    }
    let flow = |from: Flow| match from {
        Some(at) => From::Pin(uids[at], exit(&elements[at].kind)),
        None if is_fbd => typed("BOOL#TRUE"),
        None => From::Rail,
    };
    for at in places {
        bits(&mut net, uids[at], &elements[at].kind, flow(elements[at].flow), flow, is_fbd);
    }
    net
}

/// Returns all networks as a document in a language.
pub(super) fn document(networks: &[Vec<Element>], language: &str) -> String {
    let is_label = labels(networks);
    let nets = networks.iter().enumerate().map(|(number, elements)| {
        let mut net = drawn(elements, language == "FBD");
        if is_label[number] {
            net.label(&format!("L{number}"));
        }
        net
    });
    let sections = [SECTIONS[0], SECTIONS[1], ("Temp", "truth : Bool")];
    xml::block("FB", "B", &sections, nets.collect(), language)
}
