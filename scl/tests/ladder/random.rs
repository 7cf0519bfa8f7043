//! Random networks, written as LAD and as FBD in SimaticML, and as SCL by a writer that shares nothing with the product: equal bits
//! of all variables in each call. What `plcfmu show` prints of them gives the same bits, too.
//!
//! `LADDER_NETWORKS=100000 cargo test --release -p scl --test ladder random` makes more.

use super::xml::{self, From, Net, int, local, typed};
use super::{Ran, compiled};
use scl::random::Random;
use scl::scl::Dialect;
use std::fmt::Write;

const INPUTS: usize = 4;
const BOOLS: usize = 6;
const BITS: usize = 8;
const NUMBERS: usize = 4;
/// Networks of a program, and elements of a network.
const NETWORKS: usize = 10;
const ELEMENTS: u64 = 14;
const CALLS: usize = 12;

const SECTIONS: [(&str, &str); 2] = [
    ("Input", "i0 : Bool; i1 : Bool; i2 : Bool; i3 : Bool"),
    (
        "Static",
        "q0 : Bool; q1 : Bool; q2 : Bool; q3 : Bool; q4 : Bool; q5 : Bool; m0 : Bool; m1 : Bool; m2 : Bool; m3 : Bool; m4 : Bool; \
         m5 : Bool; m6 : Bool; m7 : Bool; n0 : Int := 5; n1 : Int := -3; n2 : Int := 300; n3 : Int; t0 : TON_TIME; t1 : TOF_TIME; \
         t2 : TP_TIME; c0 : CTU_INT; s0 : \"Sub\"; s1 : \"Sub\"",
    ),
];

/// The block that the networks call.
const SUB: &str = "FUNCTION_BLOCK \"Sub\"\nVAR_INPUT x : BOOL; k : INT := 2; END_VAR\nVAR_OUTPUT y : BOOL; n : INT; END_VAR\nBEGIN\n\
                   IF #x THEN #n := #n + #k; END_IF;\n#y := #n > 3 AND #x;\nEND_FUNCTION_BLOCK\n";

/// Where a flow comes from: the power rail, or an element.
type Flow = Option<usize>;

#[derive(Clone, Debug)]
enum Number {
    Variable(usize),
    Constant(i64),
}

#[derive(Clone, Debug)]
enum Kind {
    Contact(String, bool),
    Or(Vec<Flow>),
    Not,
    Edge(bool, String, usize),
    Trigger(bool, usize),
    Compare(usize, Number, Number),
    Coil(String, bool),
    Set(bool, String),
    Pulse(bool, String, usize),
    FlipFlop(bool, String, Flow),
    Timer(usize, i64),
    Counter(String, i64),
    Move(Number, usize),
    Calculate(usize, bool, Number, Number, usize),
    Call(usize, String, Number, bool),
}

#[derive(Clone, Debug)]
struct Element {
    kind: Kind,
    flow: Flow,
    /// Its place in the order of the file: elements may stand after what needs them.
    place: u64,
}

const COMPARISONS: [(&str, &str); 6] =
    [("Eq", "="), ("Ne", "<>"), ("Gt", ">"), ("Ge", ">="), ("Lt", "<"), ("Le", "<=")];
const OPERATIONS: [(&str, &str); 5] = [("Add", "+"), ("Sub", "-"), ("Mul", "*"), ("Div", "/"), ("Mod", "MOD")];
const TIMERS: [&str; 3] = ["TON", "TOF", "TP"];

fn network(random: &mut Random) -> Vec<Element> {
    let mut elements: Vec<Element> = Vec::new();
    let count = 2 + random.below(ELEMENTS) as usize;
    for at in 0..count {
        let flow = |random: &mut Random| match at {
            0 => None,
            _ if random.once_in(4) => None,
            // Most often the flow of one of the last elements goes on.
            _ => Some(at - 1 - random.below(at.min(4) as u64) as usize),
        };
        let from = flow(random);
        let read = |random: &mut Random| match random.below(10) as usize {
            at if at < INPUTS => format!("i{at}"),
            at => format!("q{}", at - INPUTS),
        };
        let written = |random: &mut Random| format!("q{}", random.below(BOOLS as u64));
        let bit = |random: &mut Random| random.below(BITS as u64) as usize;
        let number = |random: &mut Random| match random.below(3) {
            0 => Number::Constant(random.one_of(&[-1, 0, 1, 2, 7, 100, 32767, -32768])),
            _ => Number::Variable(random.below(NUMBERS as u64) as usize),
        };
        let truth = |random: &mut Random| random.once_in(2);
        let target = |random: &mut Random| random.below(NUMBERS as u64) as usize;
        let kind = match random.below(22) {
            0..=5 => Kind::Contact(read(random), truth(random)),
            6 => Kind::Or((0..2 + random.below(2)).map(|_| flow(random)).collect()),
            7 => Kind::Not,
            8 => Kind::Edge(truth(random), read(random), bit(random)),
            9 => Kind::Trigger(truth(random), bit(random)),
            10 => Kind::Compare(random.below(6) as usize, number(random), number(random)),
            11..=13 => Kind::Coil(written(random), random.once_in(4)),
            14 => Kind::Set(truth(random), written(random)),
            15 => Kind::Pulse(truth(random), written(random), bit(random)),
            16 => Kind::FlipFlop(truth(random), written(random), flow(random)),
            17 => Kind::Timer(random.below(3) as usize, 100 * random.below(4) as i64),
            18 => Kind::Counter(read(random), random.below(4) as i64),
            19 => Kind::Move(number(random), target(random)),
            20 => {
                Kind::Calculate(random.below(5) as usize, truth(random), number(random), number(random), target(random))
            }
            _ => Kind::Call(random.below(2) as usize, read(random), number(random), truth(random)),
        };
        let is_last = random.once_in(8);
        let place = if is_last { 1000 + random.below(1000) } else { at as u64 };
        elements.push(Element { kind, flow: from, place });
    }
    elements
}

/// The elements in the order in which they take effect: by their places, each after what it needs.
fn order(elements: &[Element]) -> Vec<usize> {
    fn visit(elements: &[Element], at: usize, order: &mut Vec<usize>) {
        if order.contains(&at) {
            return;
        }
        let mut needed = vec![elements[at].flow];
        match &elements[at].kind {
            Kind::Or(flows) => needed = flows.clone(),
            Kind::FlipFlop(_, _, other) => needed.push(*other),
            _ => {}
        }
        needed.into_iter().flatten().for_each(|other| visit(elements, other, order));
        order.push(at);
    }
    let mut places: Vec<usize> = (0..elements.len()).collect();
    places.sort_by_key(|at| elements[*at].place);
    let mut order = Vec::new();
    places.into_iter().for_each(|at| visit(elements, at, &mut order));
    order
}

/// The network in SCL: a flag for the flow of each element, a statement or two for each law.
fn scl(elements: &[Element], number: usize) -> String {
    let mut all = String::new();
    let flow = |from: Flow| from.map_or("TRUE".to_string(), |at| format!("#f{number}_{at}"));
    let value = |of: &Number| match of {
        Number::Variable(at) => format!("#n{at}"),
        Number::Constant(value) => format!("INT#{value}"),
    };
    for at in order(elements) {
        let (f, e) = (flow(elements[at].flow), flow(Some(at)));
        let line = match &elements[at].kind {
            Kind::Contact(name, true) => format!("{e} := {f} AND NOT #{name};"),
            Kind::Contact(name, false) => format!("{e} := {f} AND #{name};"),
            Kind::Or(flows) => {
                let flows: Vec<String> = flows.iter().map(|from| flow(*from)).collect();
                format!("{e} := {};", flows.join(" OR "))
            }
            Kind::Not => format!("{e} := NOT {f};"),
            Kind::Edge(true, name, bit) => format!("{e} := {f} AND (#{name} AND NOT #m{bit}); #m{bit} := #{name};"),
            Kind::Edge(false, name, bit) => format!("{e} := {f} AND (NOT #{name} AND #m{bit}); #m{bit} := #{name};"),
            Kind::Trigger(true, bit) => format!("{e} := {f} AND NOT #m{bit}; #m{bit} := {f};"),
            Kind::Trigger(false, bit) => format!("{e} := NOT {f} AND #m{bit}; #m{bit} := {f};"),
            Kind::Compare(which, left, right) => {
                format!("{e} := {f} AND ({} {} {});", value(left), COMPARISONS[*which].1, value(right))
            }
            Kind::Coil(name, is_negated) => {
                format!("#{name} := {}{f}; {e} := {f};", if *is_negated { "NOT " } else { "" })
            }
            Kind::Set(is_set, name) => format!("IF {f} THEN #{name} := {is_set}; END_IF; {e} := {f};"),
            Kind::Pulse(true, name, bit) => format!("#{name} := {f} AND NOT #m{bit}; #m{bit} := {f}; {e} := {f};"),
            Kind::Pulse(false, name, bit) => format!("#{name} := NOT {f} AND #m{bit}; #m{bit} := {f}; {e} := {f};"),
            Kind::FlipFlop(is_set_dominant, name, other) => {
                let (set, reset) = (
                    format!("IF {f} THEN #{name} := TRUE; END_IF;"),
                    format!("IF {} THEN #{name} := FALSE; END_IF;", flow(*other)),
                );
                let [first, last] = if *is_set_dominant { [reset, set] } else { [set, reset] };
                format!("{first} {last} {e} := #{name};")
            }
            Kind::Timer(which, ms) => format!("#t{which}(IN := {f}, PT := T#{ms}ms); {e} := #t{which}.Q;"),
            Kind::Counter(reset, most) => format!("#c0(CU := {f}, R := #{reset}, PV := {most}); {e} := #c0.Q;"),
            Kind::Move(from, to) => format!("IF {f} THEN #n{to} := {}; END_IF; {e} := {f};", value(from)),
            Kind::Calculate(which, false, left, right, to) => {
                let sum = format!("{} {} {}", value(left), OPERATIONS[*which].1, value(right));
                format!("IF {f} THEN #n{to} := {sum}; END_IF; {e} := {f};")
            }
            Kind::Calculate(which, true, left, right, to) => {
                // What overflows in INT does not in DINT.
                let (left, right) = (value(left), value(right));
                let wide = format!("INT_TO_DINT({left}) {} INT_TO_DINT({right})", OPERATIONS[*which].1);
                let has_quotient = if *which > 2 { format!("{right} <> 0") } else { "TRUE".to_string() };
                format!(
                    "IF {f} THEN #wide := {wide}; {e} := #wide >= -32768 AND #wide <= 32767 AND {has_quotient}; \
                     #n{to} := {left} {} {right}; ELSE {e} := FALSE; END_IF;",
                    OPERATIONS[*which].1
                )
            }
            Kind::Call(which, x, k, of_eno) => {
                let result = if *of_eno { f.clone() } else { format!("#s{which}.y") };
                format!("IF {f} THEN #s{which}(x := #{x}, k := {}); END_IF; {e} := {result};", value(k))
            }
        };
        writeln!(all, "{line}").unwrap();
    }
    all
}

/// All networks as a source in SCL.
fn source(networks: &[Vec<Element>]) -> String {
    let members =
        |text: &str| text.replace("\"Sub\"", "Sub").split(';').map(|one| format!("{one};\n")).collect::<String>();
    let mut all = String::from("FUNCTION_BLOCK \"B\"\n");
    for (section, text) in SECTIONS {
        let section = if section == "Input" { "VAR_INPUT" } else { "VAR" };
        writeln!(all, "{section}\n{}END_VAR", members(text).replace("Sub", "\"Sub\"")).unwrap();
    }
    all += "VAR_TEMP\nwide : DINT;\n";
    for (number, elements) in networks.iter().enumerate() {
        (0..elements.len()).for_each(|at| writeln!(all, "f{number}_{at} : BOOL;").unwrap());
    }
    all += "END_VAR\nBEGIN\n";
    networks.iter().enumerate().for_each(|(number, elements)| all += &scl(elements, number));
    all + "END_FUNCTION_BLOCK\n"
}

/// A network as parts and wires; in FBD gates take the place of contacts, and a constant that of the power rail.
fn drawn(elements: &[Element], is_fbd: bool) -> Net {
    let mut net = Net::new("random");
    // The UIds follow the order in the file, in which an element may come before what it needs: numbers are given out first.
    let mut places: Vec<usize> = (0..elements.len()).collect();
    places.sort_by_key(|at| elements[*at].place);
    let mut uids = vec![0; elements.len()];
    for at in &places {
        uids[*at] = net.next();
    }
    let pin = |at: usize| match &elements[at].kind {
        Kind::FlipFlop(..) => "q",
        Kind::Timer(..) | Kind::Counter(..) => "Q",
        Kind::Move(..) | Kind::Calculate(..) | Kind::Call(_, _, _, true) => "eno",
        Kind::Call(..) => "y",
        _ => "out",
    };
    let flow = |from: Flow| match from {
        Some(at) => From::Pin(uids[at], pin(at)),
        None if is_fbd => typed("BOOL#TRUE"),
        None => From::Rail,
    };
    let value = |of: &Number| match of {
        Number::Variable(at) => local(&format!("n{at}")),
        Number::Constant(value) => int(*value),
    };
    let int_type = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Int</TemplateValue>";
    let negated = |is: bool, pin: &str| if is { format!("<Negated Name=\"{pin}\" />") } else { String::new() };
    for at in places {
        let f = flow(elements[at].flow);
        let uid = uids[at];
        let bit = |bit: &usize| local(&format!("m{bit}"));
        let instance = |name: String, net: &mut Net| {
            format!("<Instance Scope=\"LocalVariable\" UId=\"{}\"><Component Name=\"{name}\" /></Instance>", net.next())
        };
        match &elements[at].kind {
            Kind::Contact(name, is_negated) if is_fbd => {
                net.part_at(uid, "A", &negated(*is_negated, "in2"), &[("in1", f), ("in2", local(name))]);
            }
            Kind::Contact(name, is_negated) => {
                net.part_at(uid, "Contact", &negated(*is_negated, "operand"), &[("in", f), ("operand", local(name))]);
            }
            Kind::Or(flows) => {
                let pins = ["in1", "in2", "in3"].into_iter().zip(flows.iter().map(|from| flow(*from)));
                net.part_at(uid, "O", "", &pins.collect::<Vec<_>>());
            }
            Kind::Not => net.part_at(uid, "Not", "", &[("in", f)]),
            Kind::Edge(is_rising, name, memory) => {
                let part = if *is_rising { "PContact" } else { "NContact" };
                net.part_at(uid, part, "", &[("pre", f), ("operand", local(name)), ("bit", bit(memory))]);
            }
            Kind::Trigger(is_rising, memory) => {
                let part = if *is_rising { "PBox" } else { "NBox" };
                net.part_at(uid, part, "", &[("in", f), ("bit", bit(memory))]);
            }
            Kind::Compare(which, left, right) => {
                let pins = [("pre", f), ("in1", value(left)), ("in2", value(right))];
                net.part_at(uid, COMPARISONS[*which].0, int_type, &pins);
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
                let (part, set, reset) = if *is_set_dominant { ("Rs", "s1", "r") } else { ("Sr", "s", "r1") };
                net.part_at(uid, part, "", &[(set, f), (reset, flow(*other)), ("operand", local(name))]);
            }
            Kind::Timer(which, ms) => {
                let inner = instance(format!("t{which}"), &mut net);
                net.part_at(uid, TIMERS[*which], &inner, &[("IN", f), ("PT", typed(&format!("T#{ms}ms")))]);
            }
            Kind::Counter(reset, most) => {
                let inner = instance("c0".to_string(), &mut net);
                net.part_at(uid, "CTU", &inner, &[("CU", f), ("R", local(reset)), ("PV", int(*most))]);
            }
            Kind::Move(from, to) => {
                net.part_at(uid, "Move", "", &[("en", f), ("in", value(from))]);
                net.write(uid, "out1", local(&format!("n{to}")));
            }
            Kind::Calculate(which, has_eno, left, right, to) => {
                let attribute = if *has_eno { "" } else { " DisabledENO=\"true\"" };
                let pins = [("en", f), ("in1", value(left)), ("in2", value(right))];
                net.part_at(uid, &format!("{}{attribute}", OPERATIONS[*which].0), int_type, &pins);
                net.write(uid, "out", local(&format!("n{to}")));
            }
            Kind::Call(which, x, k, _) => {
                let inner = instance(format!("s{which}"), &mut net);
                net.call_at(uid, "FB", "Sub", &inner, &[("en", f), ("x", local(x)), ("k", value(k))]);
            }
        }
    }
    net
}

fn state(ran: &Ran) -> Vec<i64> {
    let names = (0..INPUTS).map(|at| format!("i{at}")).chain((0..BOOLS).map(|at| format!("q{at}")));
    let names = names.chain((0..BITS).map(|at| format!("m{at}"))).chain((0..NUMBERS).map(|at| format!("n{at}")));
    let instances = ["t0.Q", "t1.Q", "t2.Q", "t0.ET", "t1.ET", "t2.ET", "c0.CV", "s0.n", "s1.n"].map(String::from);
    names.chain(instances).map(|name| ran.get(&name)).collect()
}

#[test]
fn random_networks_give_the_same_bits_in_every_language() {
    let count = std::env::var("LADDER_NETWORKS").ok().and_then(|count| count.parse().ok()).unwrap_or(200usize);
    let mut random = Random::new(20_261_125);
    for program in 0..count.div_ceil(NETWORKS) {
        let networks: Vec<Vec<Element>> = (0..NETWORKS).map(|_| network(&mut random)).collect();
        let sub = ("sub.scl", SUB.to_string());
        let document = |language: &str| {
            let nets = networks.iter().map(|elements| drawn(elements, language == "FBD")).collect();
            xml::block("FB", "B", &SECTIONS, nets, language)
        };
        let lad = compiled(&[("b.xml", document("LAD")), sub.clone()]).unwrap_or_else(|errors| panic!("{}", errors[0]));
        let shown = scl::scl::print(&lad.program, &lad.blocks(), Dialect::Tia).unwrap();
        let mut all = [
            ("LAD", Ran::from_compiled(lad)),
            ("FBD", Ran::new(&[("b.xml", document("FBD")), sub.clone()])),
            ("SCL", Ran::new(&[("b.scl", source(&networks)), sub])),
            ("shown", Ran::new(&[("shown.scl", shown.clone())])),
        ];
        for call in 0..CALLS {
            let inputs = [0; INPUTS].map(|_| random.below(2) as i64);
            let states = all.each_mut().map(|(name, ran)| {
                for (at, value) in inputs.iter().enumerate() {
                    ran.set(&format!("i{at}"), *value);
                }
                (*name, state(ran.call()))
            });
            for (name, state) in &states {
                assert_eq!(
                    *state,
                    states[2].1,
                    "program {program}, call {call}: {name}\n{}\n{shown}",
                    source(&networks)
                );
            }
        }
    }
}
