//! Random networks, written as LAD and as FBD in SimaticML and in SIMATIC SD, and as SCL by a writer that shares no
//! code with the product, have equal bits in all variables after each call. So does the SCL that `plcfmu show` prints
//! of them.
//!
//! `LADDER_NETWORKS=100000 cargo test --release -p scl --test ladder random` tests more; `LADDER_PROGRAM=3941` runs
//! only that program.

mod document;
mod drawing;
mod source;

use super::{Ran, compiled};
use scl::Dialect;
use scl::random::Random;

const INPUTS: usize = 4;
const BOOLS: usize = 6;
const BITS: usize = 8;
const NUMBERS: usize = 4;
const WORDS: usize = 3;
/// The number of networks of a program, and of elements of a network.
const NETWORKS: usize = 10;
const ELEMENTS: u64 = 14;
const CALLS: usize = 12;

const SECTIONS: [(&str, &str); 2] = [
    ("Input", "i0 : Bool; i1 : Bool; i2 : Bool; i3 : Bool"),
    (
        "Static",
        "q0 : Bool; q1 : Bool; q2 : Bool; q3 : Bool; q4 : Bool; q5 : Bool; m0 : Bool; m1 : Bool; m2 : Bool; m3 : Bool; m4 : Bool; \
         m5 : Bool; m6 : Bool; m7 : Bool; n0 : Int := 5; n1 : Int := -3; n2 : Int := 300; n3 : Int; w0 : Word := 16#8001; w1 : Word; \
         w2 : Word := 16#0F0F; t0 : TON_TIME; t1 : TOF_TIME; t2 : TP_TIME; c0 : CTU_INT; s0 : \"Sub\"; s1 : \"Sub\"",
    ),
];

/// The blocks called by the networks.
const OTHERS: &str = "FUNCTION_BLOCK \"Sub\"\nVAR_INPUT x : BOOL; k : INT := 2; END_VAR\nVAR_OUTPUT y : BOOL; n : INT; END_VAR\nBEGIN\n\
                      IF #x THEN #n := #n + #k; END_IF;\n#y := #n > 3 AND #x;\nEND_FUNCTION_BLOCK\n\
                      FUNCTION \"Fun\" : INT\nVAR_INPUT x : BOOL; k : INT; END_VAR\nVAR_OUTPUT y : BOOL; END_VAR\nBEGIN\n\
                      #y := #x OR #k > 100;\nIF #x THEN #Fun := #k * 3; ELSE #Fun := #k - 7; END_IF;\nEND_FUNCTION\n";

/// The source of a flow: the power rail, or an element.
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
    /// `(IN1 + IN2) * IN3 - IN1`, and whether ENO reports an overflow.
    Formula(bool, [Number; 3], usize),
    /// INC or DEC, with ENO.
    Step(bool, usize),
    Select(String, Number, Number, usize),
    /// AND, OR, XOR of two or three words.
    Words(usize, Vec<usize>, usize),
    /// SHL, SHR, ROL, ROR.
    Shift(usize, usize, u64, usize),
    /// A call to an instance that passes on y or ENO.
    Call(usize, String, Number, bool),
    /// A call to a function that writes its value, and passes on y or ENO.
    Function(String, Number, usize, bool),
    /// A jump to a network, if the flow is TRUE, or if it is FALSE.
    Jump(bool, usize),
}

#[derive(Clone, Debug)]
struct Element {
    kind: Kind,
    flow: Flow,
    /// The position in the file: elements may come after those that need them.
    place: u64,
}

const COMPARISONS: [(&str, &str); 6] =
    [("Eq", "="), ("Ne", "<>"), ("Gt", ">"), ("Ge", ">="), ("Lt", "<"), ("Le", "<=")];
const OPERATIONS: [(&str, &str); 5] = [("Add", "+"), ("Sub", "-"), ("Mul", "*"), ("Div", "/"), ("Mod", "MOD")];
const TIMERS: [&str; 3] = ["TON", "TOF", "TP"];
const OF_WORDS: [&str; 3] = ["And", "Or", "Xor"];
const SHIFTS: [&str; 4] = ["Shl", "Shr", "Rol", "Ror"];

fn network(random: &mut Random, number: usize) -> Vec<Element> {
    let mut elements: Vec<Element> = Vec::new();
    let count = 2 + random.below(ELEMENTS) as usize;
    for at in 0..count {
        let flow = |random: &mut Random| match at {
            0 => None,
            _ if random.once_in(4) => None,
            // Usually the flow of one of the last elements is passed on.
            _ => Some(at - 1 - random.below(at.min(4) as u64) as usize),
        };
        let from = flow(random);
        let read = |random: &mut Random| match random.below(10) as usize {
            at if at < INPUTS => format!("i{at}"),
            at => format!("q{}", at - INPUTS),
        };
        let written = |random: &mut Random| format!("q{}", random.below(BOOLS as u64));
        let bit = |random: &mut Random| random.below(BITS as u64) as usize;
        let value = |random: &mut Random| match random.below(3) {
            0 => Number::Constant(random.one_of(&[-1, 0, 1, 2, 7, 100, 32767, -32768])),
            _ => Number::Variable(random.below(NUMBERS as u64) as usize),
        };
        let truth = |random: &mut Random| random.once_in(2);
        let target = |random: &mut Random| random.below(NUMBERS as u64) as usize;
        let word = |random: &mut Random| random.below(WORDS as u64) as usize;
        let kind = match random.below(30) {
            0..=5 => Kind::Contact(read(random), truth(random)),
            6 => Kind::Or((0..2 + random.below(2)).map(|_| flow(random)).collect()),
            7 => Kind::Not,
            8 => Kind::Edge(truth(random), read(random), bit(random)),
            9 => Kind::Trigger(truth(random), bit(random)),
            10 => Kind::Compare(random.below(6) as usize, value(random), value(random)),
            11..=13 => Kind::Coil(written(random), random.once_in(4)),
            14 => Kind::Set(truth(random), written(random)),
            15 => Kind::Pulse(truth(random), written(random), bit(random)),
            16 => Kind::FlipFlop(truth(random), written(random), flow(random)),
            17 => Kind::Timer(random.below(3) as usize, 100 * random.below(4) as i64),
            18 => Kind::Counter(read(random), random.below(4) as i64),
            19 => Kind::Move(value(random), target(random)),
            20 | 21 => {
                Kind::Calculate(random.below(5) as usize, truth(random), value(random), value(random), target(random))
            }
            22 => Kind::Formula(truth(random), [(); 3].map(|()| value(random)), target(random)),
            23 => Kind::Step(truth(random), target(random)),
            24 => Kind::Select(read(random), value(random), value(random), target(random)),
            25 => {
                let words = (0..2 + random.below(2)).map(|_| word(random)).collect();
                Kind::Words(random.below(3) as usize, words, word(random))
            }
            26 => Kind::Shift(random.below(4) as usize, word(random), random.below(20), word(random)),
            27 => Kind::Function(read(random), value(random), target(random), truth(random)),
            _ => Kind::Call(random.below(2) as usize, read(random), value(random), truth(random)),
        };
        let is_last = random.once_in(8);
        let place = if is_last { 1000 + random.below(1000) } else { at as u64 };
        elements.push(Element { kind, flow: from, place });
    }
    if number + 1 < NETWORKS && random.once_in(3) {
        let to = number + 1 + random.below((NETWORKS - number - 1) as u64) as usize;
        let flow = Some(count - 1 - random.below(count as u64) as usize);
        elements.push(Element { kind: Kind::Jump(random.once_in(2), to), flow, place: count as u64 });
    }
    elements
}

/// Returns which networks are targets of jumps.
fn labels(networks: &[Vec<Element>]) -> Vec<bool> {
    let mut is_label = vec![false; networks.len()];
    for element in networks.iter().flatten() {
        if let Kind::Jump(_, to) = element.kind {
            is_label[to] = true;
        }
    }
    is_label
}

fn state(ran: &Ran) -> Vec<i64> {
    let names = (0..INPUTS).map(|at| format!("i{at}")).chain((0..BOOLS).map(|at| format!("q{at}")));
    let names = names.chain((0..BITS).map(|at| format!("m{at}"))).chain((0..NUMBERS).map(|at| format!("n{at}")));
    let names = names.chain((0..WORDS).map(|at| format!("w{at}")));
    let instances = ["t0.Q", "t1.Q", "t2.Q", "t0.ET", "t1.ET", "t2.ET", "c0.CV", "s0.n", "s1.n"].map(String::from);
    names.chain(instances).map(|name| ran.get(&name)).collect()
}

#[test]
fn random_networks_give_the_same_bits_in_every_language() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<usize>().unwrap());
    let programs = number("LADDER_NETWORKS").unwrap_or(200).div_ceil(NETWORKS);
    let only = number("LADDER_PROGRAM");
    for program in only.map_or(0..programs, |only| only..only + 1) {
        let mut random = Random::new(20_261_125 ^ (program as u64) << 32);
        let networks: Vec<Vec<Element>> = (0..NETWORKS).map(|number| network(&mut random, number)).collect();
        let scl = source::source(&networks);
        let of = |name: &'static str, text: String| {
            let compiled = compiled(&[(name, text.clone()), ("others.scl", OTHERS.to_string())]);
            compiled.unwrap_or_else(|errors| panic!("program {program}\n{}\n{text}\n{scl}", errors[0]))
        };
        let lad = of("b.xml", drawing::document(&networks, "LAD"));
        let shown = scl::print(&lad.program, &lad.blocks(), Dialect::Tia).unwrap();
        let mut all = [
            ("LAD", Ran::from_compiled(lad)),
            ("FBD", Ran::from_compiled(of("b.xml", drawing::document(&networks, "FBD")))),
            ("SCL", Ran::from_compiled(of("b.scl", scl.clone()))),
            ("LAD in SD", Ran::from_compiled(of("b.s7dcl", document::document(&networks, "LAD")))),
            ("FBD in SD", Ran::from_compiled(of("b.s7dcl", document::document(&networks, "FBD")))),
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
                assert_eq!(*state, states[2].1, "program {program}, call {call}: {name}\n{scl}\n{shown}");
            }
        }
    }
}

/// Returns a block's sections as declared in SCL and in documents.
fn declarations() -> String {
    let section = |(name, text): &(&str, &str)| {
        let keyword = if *name == "Input" { "VAR_INPUT" } else { "VAR" };
        let members: String = text.split(';').map(|one| format!("{};\n", one.trim())).collect();
        format!("{keyword}\n{members}END_VAR\n")
    };
    SECTIONS.iter().map(section).collect()
}
