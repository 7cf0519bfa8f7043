//! Elements in both formats, SimaticML and SIMATIC SD, with values that can be checked by hand. The quoted titles are
//! those of the pages on instructions for S7-1200 and S7-1500 in TIA Portal's help, V19.

mod boxes;
mod calls;
mod refused;
mod texts;

use crate::xml::{self, From, Net, local};
use crate::{Ran, compiled};

/// The sections of a block: their names in SimaticML, and their members.
type Sections<'a> = &'a [(&'a str, &'a str)];

/// Returns a block B as a document with these networks.
fn document(sections: Sections, networks: &[&str]) -> String {
    let section = |(name, text): &(&str, &str)| {
        let keyword = match *name {
            "Static" => "VAR".to_string(),
            name => format!("VAR_{}", name.to_uppercase()),
        };
        format!("{keyword} {text}; END_VAR\n")
    };
    let sections: String = sections.iter().map(section).collect();
    let network = |rungs: &&str| format!("{{ S7_Language := \"LAD\" }}\nNETWORK\n{rungs}\nEND_NETWORK\n");
    let networks: String = networks.iter().map(network).collect();
    format!("FUNCTION_BLOCK \"B\"\n{sections}{networks}END_FUNCTION_BLOCK\n")
}

/// Runs a block in both formats, together with other sources.
#[track_caller]
pub(crate) fn both(sections: Sections, nets: Vec<Net>, networks: &[&str], others: &str) -> [(&'static str, Ran); 2] {
    let of = |name: &'static str, text: String| {
        let mut files = vec![(name, text.clone())];
        if !others.is_empty() {
            files.push(("others.scl", others.to_string()));
        }
        (name, Ran::from_compiled(compiled(&files).unwrap_or_else(|errors| panic!("{}\n{text}", errors[0]))))
    };
    let drawn = xml::block("FB", "B", sections, nets, "LAD");
    [of("b.xml", drawn), of("b.s7dcl", document(sections, networks))]
}

/// Makes calls with these inputs, 100 ms apart, and checks the outputs after each.
#[track_caller]
fn tape<const N: usize, const M: usize>(
    both: [(&'static str, Ran); 2],
    inputs: [&str; N],
    outputs: [&str; M],
    rows: &[([i64; N], [i64; M])],
) {
    for (format, mut ran) in both {
        for (number, (values, expected)) in rows.iter().enumerate() {
            for (name, value) in inputs.iter().zip(values) {
                ran.set(name, *value);
            }
            ran.call();
            assert_eq!(outputs.map(|name| ran.get(name)), *expected, "{format}, call {number} with {values:?}");
        }
    }
}

fn contact(net: &mut Net, name: &str) -> From {
    From::Pin(net.part("Contact", "", &[("in", From::Rail), ("operand", local(name))]), "out")
}

fn coil(net: &mut Net, name: &str, flow: From) {
    net.part("Coil", "", &[("in", flow), ("operand", local(name))]);
}

fn of_type(name: &str, of: &str) -> String {
    format!("<TemplateValue Name=\"{name}\" Type=\"Type\">{of}</TemplateValue>")
}

fn instance(name: &str, net: &mut Net) -> String {
    format!("<Instance Scope=\"LocalVariable\" UId=\"{}\"><Component Name=\"{name}\" /></Instance>", net.next())
}

/// "TOF: Start off-delay timer", "TP: Start pulse timer", "TONR: Time accumulator", "RT: Reset timer", "PT: Load time duration": coils.
#[test]
fn coils_of_timers() {
    use crate::xml::typed;
    let sections: Sections = &[
        ("Input", "a : Bool; r : Bool; p : Bool"),
        ("Output", "off : Bool; pulse : Bool; sum : Bool; on : Bool"),
        ("Static", "t1 : TOF_TIME; t2 : TP_TIME; t3 : TONR_TIME; t4 : TON_TIME"),
    ];
    let mut net = Net::new("");
    for (part, timer) in [("TofCoil", "t1"), ("TpCoil", "t2"), ("TonrCoil", "t3"), ("TonCoil", "t4")] {
        let flow = contact(&mut net, "a");
        net.part(part, "", &[("in", flow), ("operand", local(timer)), ("value", typed("T#200ms"))]);
    }
    let flow = contact(&mut net, "r");
    net.part("RtCoil", "", &[("in", flow), ("operand", local("t3"))]);
    let flow = contact(&mut net, "p");
    net.part("PtCoil", "", &[("in", flow), ("operand", local("t4")), ("value", typed("T#400ms"))]);
    for (timer, output) in [("t1.Q", "off"), ("t2.Q", "pulse"), ("t3.Q", "sum"), ("t4.Q", "on")] {
        let flow = contact(&mut net, timer);
        coil(&mut net, output, flow);
    }
    let rungs = "RUNG wire#powerrail Contact( #a ) TOf_Coil( timer => #t1, pt := T#200ms ) TP_Coil( #t2, T#200ms )
        TOnR_Coil( timer => #t3, pt := T#200ms ) TOn_Coil( #t4, T#200ms ) END_RUNG
        RUNG wire#powerrail Contact( #r ) RT_Coil( #t3 ) END_RUNG
        RUNG wire#powerrail Contact( #p ) PT_Coil( timer => #t4, pt := T#400ms ) END_RUNG
        RUNG wire#powerrail Contact( #t1.Q ) Coil( #off ) END_RUNG RUNG wire#powerrail Contact( #t2.Q ) Coil( #pulse ) END_RUNG
        RUNG wire#powerrail Contact( #t3.Q ) Coil( #sum ) END_RUNG RUNG wire#powerrail Contact( #t4.Q ) Coil( #on ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["a", "r", "p"],
        ["off", "pulse", "sum", "on"],
        &[
            ([1, 0, 0], [1, 1, 0, 0]),
            // From here on, the 200 ms have become the 400 ms of the start value.
            ([1, 0, 1], [1, 1, 0, 0]),
            ([1, 0, 0], [1, 0, 1, 0]),
            ([1, 0, 0], [1, 0, 1, 0]),
            ([1, 0, 0], [1, 0, 1, 1]),
            ([0, 0, 0], [1, 0, 1, 0]),
            ([0, 1, 0], [1, 0, 0, 0]),
            ([0, 0, 0], [0, 0, 0, 0]),
        ],
    );
}

/// "CTD: Count down", "CTUD: Count up and down".
#[test]
fn counters() {
    let sections: Sections = &[
        ("Input", "up : Bool; down : Bool; r : Bool; ld : Bool"),
        ("Output", "empty : Bool; cv : Int; full : Bool; none : Bool; both : Int"),
        ("Static", "c1 : CTD_INT; c2 : CTUD_INT"),
    ];
    let mut net = Net::new("");
    let (down, load) = (contact(&mut net, "down"), contact(&mut net, "ld"));
    let inner = instance("c1", &mut net);
    let pins = [("CD", down.clone()), ("LD", load.clone()), ("PV", xml::int(2))];
    let counter = net.part("CTD", &(inner + &of_type("value_type", "Int")), &pins);
    coil(&mut net, "empty", From::Pin(counter, "Q"));
    net.write(counter, "CV", local("cv"));
    let (up, reset) = (contact(&mut net, "up"), contact(&mut net, "r"));
    let inner = instance("c2", &mut net);
    let pins = [("CU", up), ("CD", down), ("R", reset), ("LD", load), ("PV", xml::int(2))];
    let counter = net.part("CTUD", &(inner + &of_type("value_type", "Int")), &pins);
    coil(&mut net, "full", From::Pin(counter, "QU"));
    coil(&mut net, "none", From::Pin(counter, "QD"));
    net.write(counter, "CV", local("both"));
    let rungs = "RUNG wire#powerrail Contact( #down ) { S7_Templates := \"value_type := Int\" }
        #c1.CTD( ld := #ld, pv := 2, cv => #cv ) Coil( #empty ) END_RUNG
        RUNG wire#powerrail Contact( #up ) { S7_Templates := \"value_type := Int\" }
        #c2.CTUD( cd := #down, r := #r, ld := #ld, pv := 2, qd => #none, cv => #both ) Coil( #full ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["up", "down", "r", "ld"],
        ["empty", "cv", "full", "none", "both"],
        &[
            ([0, 0, 0, 1], [0, 2, 1, 0, 2]),
            ([0, 1, 0, 0], [0, 1, 0, 0, 1]),
            ([0, 0, 0, 0], [0, 1, 0, 0, 1]),
            ([0, 1, 0, 0], [1, 0, 0, 1, 0]),
            ([1, 1, 0, 0], [1, 0, 0, 0, 1]),
            ([0, 0, 0, 0], [1, 0, 0, 0, 1]),
            // Both edges: no change. A counter may count below 0.
            ([1, 1, 0, 0], [1, -1, 0, 0, 1]),
            ([0, 0, 1, 0], [1, -1, 0, 1, 0]),
        ],
    );
}

/// "TONR: Time accumulator", "R_TRIG: Detect positive signal edge", "F_TRIG": boxes with instances; a call with EN.
#[test]
fn instances_of_the_system() {
    let sections: Sections = &[
        ("Input", "a : Bool; r : Bool; f : Bool"),
        ("Output", "q : Bool; et : Time; up : Bool; down : Bool"),
        ("Static", "t : TONR_TIME; rise : R_TRIG; fall : F_TRIG"),
    ];
    let mut net = Net::new("");
    let (a, r) = (contact(&mut net, "a"), contact(&mut net, "r"));
    let inner = instance("t", &mut net);
    let timer = net.part("TONR", &inner, &[("IN", a), ("R", r), ("PT", xml::typed("T#200ms"))]);
    coil(&mut net, "q", From::Pin(timer, "Q"));
    net.write(timer, "ET", local("et"));
    for (part, name, output) in [("R_TRIG", "rise", "up"), ("F_TRIG", "fall", "down")] {
        let flow = contact(&mut net, "f");
        let inner = instance(name, &mut net);
        let edge = net.part(part, &inner, &[("en", flow), ("CLK", local("a"))]);
        net.write(edge, "Q", local(output));
    }
    let rungs = "RUNG wire#powerrail Contact( #a ) #t.TONR( r := #r, pt := T#200ms, et => #et ) Coil( #q ) END_RUNG
        RUNG wire#powerrail Contact( #f ) #rise.R_TRIG( clk := #a, q => #up ) #fall.F_TRIG( clk := #a, q => #down ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["a", "r", "f"],
        ["q", "et", "up", "down"],
        &[
            ([1, 0, 1], [0, 0, 1, 0]),
            ([1, 0, 1], [0, 100, 0, 0]),
            ([1, 0, 1], [1, 200, 0, 0]),
            ([0, 0, 1], [1, 200, 0, 1]),
            ([1, 0, 0], [1, 200, 0, 1]),
            ([1, 1, 1], [0, 0, 1, 0]),
        ],
    );
}

/// "TON: Generate on-delay", "CTU: Count up" with LTIME and DINT, in the block and in undeclared data blocks.
#[test]
fn timers_and_counters_of_other_types() {
    let sections: Sections = &[
        ("Input", "a : Bool"),
        ("Output", "x : Bool; y : Bool; n : DInt; m : DInt; et : LTime"),
        ("Static", "t : TON_LTIME; c : CTU_DINT"),
    ];
    let mut net = Net::new("");
    let global = |name: &str, net: &mut Net| instance(name, net).replace("LocalVariable", "GlobalVariable");
    for (is_own, timer, counter, output, count) in [(true, "t", "c", "x", "n"), (false, "T_DB", "C_DB", "y", "m")] {
        let flow = contact(&mut net, "a");
        let name = |name, net: &mut Net| if is_own { instance(name, net) } else { global(name, net) };
        let inner = name(timer, &mut net) + &of_type("time_type", "LTime");
        let uid = net.part("TON", &inner, &[("IN", flow.clone()), ("PT", xml::typed("LT#100ms"))]);
        coil(&mut net, output, From::Pin(uid, "Q"));
        if is_own {
            net.write(uid, "ET", local("et"));
        }
        let inner = name(counter, &mut net) + &of_type("value_type", "DInt");
        let uid = net.part("CTU", &inner, &[("CU", flow), ("R", xml::typed("BOOL#0")), ("PV", xml::int(70000))]);
        net.write(uid, "CV", local(count));
    }
    let rungs = "RUNG wire#powerrail Contact( #a ) wire#w1 { S7_Templates := \"time_type := LTime\" } #t.TON( pt := LT#100ms, et => #et )
        Coil( #x ) END_RUNG
        RUNG wire#w1 { S7_Templates := \"value_type := DInt\" } #c.CTU( r := FALSE, pv := 70000, cv => #n ) END_RUNG
        RUNG wire#w1 { S7_Templates := \"time_type := LTime\" } \"T_DB\".TON( pt := LT#100ms ) Coil( #y ) END_RUNG
        RUNG wire#w1 { S7_Templates := \"value_type := DInt\" } \"C_DB\".CTU( r := FALSE, pv := 70000, cv => #m ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["a"],
        ["x", "y", "n", "m", "et"],
        &[([1], [0, 0, 1, 1, 0]), ([1], [1, 1, 1, 1, 100_000_000]), ([0], [0, 0, 1, 1, 0])],
    );
}

/// "SR: Set/reset flip-flop", "RS: Reset/set flip-flop": the input marked 1 is dominant.
#[test]
fn flip_flops() {
    let sections: Sections =
        &[("Input", "s : Bool; r : Bool"), ("Output", "x : Bool; y : Bool"), ("Static", "m : Bool; n : Bool")];
    let mut net = Net::new("");
    let (set, reset) = (contact(&mut net, "s"), contact(&mut net, "r"));
    let sr = net.part("Sr", "", &[("s", set.clone()), ("r1", reset.clone()), ("operand", local("m"))]);
    coil(&mut net, "x", From::Pin(sr, "q"));
    let rs = net.part("Rs", "", &[("r", reset), ("s1", set), ("operand", local("n"))]);
    coil(&mut net, "y", From::Pin(rs, "q"));
    let rungs = "RUNG wire#powerrail Contact( #s ) #m.S_SR( #r ) Coil( #x ) END_RUNG
        RUNG wire#powerrail Contact( #r ) #n.S_RS( s1 := wire#w1 ) Coil( #y ) END_RUNG
        RUNG wire#powerrail Contact( #s ) END_RUNG wire#w1";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["s", "r"],
        ["x", "y"],
        &[([1, 0], [1, 1]), ([0, 0], [1, 1]), ([0, 1], [0, 0]), ([1, 1], [0, 1]), ([0, 0], [0, 1])],
    );
}

/// "SET_BF: Set bit field", "RESET_BF: Reset bit field": elements of an array, also starting at an index, and bits of a
/// word.
#[test]
fn fields_of_bits() {
    let sections: Sections = &[
        ("Input", "s : Bool; r : Bool; i : Int; n : Int"),
        ("Static", "w : Word := 16#8000; bits : Array[0..7] of Bool"),
    ];
    let mut net = Net::new("");
    let (set, reset) = (contact(&mut net, "s"), contact(&mut net, "r"));
    net.part("SBitfield", "", &[("en", set.clone()), ("operand", local("w%X2")), ("n", xml::int(4))]);
    net.part("SBitfield", "", &[("en", set), ("operand", local("bits[i]")), ("n", local("n"))]);
    net.part("RBitfield", "", &[("en", reset.clone()), ("operand", local("w%x3")), ("n", xml::int(2))]);
    net.part("RBitfield", "", &[("en", reset), ("operand", local("bits[3]")), ("n", xml::int(1))]);
    let rungs = "RUNG wire#powerrail Contact( #s ) S_BitfieldCoil( operand => #w.%X2, n := 4 ) S_BitfieldCoil( #bits[#i], #n ) END_RUNG
        RUNG wire#powerrail Contact( #r ) R_BitfieldCoil( operand => #w.%X3, n := 2 ) R_BitfieldCoil( #bits[3], 1 ) END_RUNG";
    let word = |bits: i64| bits - if bits > 32767 { 65536 } else { 0 };
    for (format, mut ran) in both(sections, vec![net], &[rungs], "") {
        for (s, r, w, bits) in [
            (0, 0, 0x8000, [0; 8]),
            (1, 0, 0x803c, [0, 0, 1, 1, 1, 0, 0, 0]),
            (0, 1, 0x8024, [0, 0, 1, 0, 1, 0, 0, 0]),
            (1, 1, 0x8024, [0, 0, 1, 0, 1, 0, 0, 0]),
        ] {
            ran.set("s", s).set("r", r).set("i", 2).set("n", 3).call();
            let found = [0, 1, 2, 3, 4, 5, 6, 7].map(|at| ran.get(&format!("bits[{at}]")));
            assert_eq!((word(ran.get("w") & 0xffff), found), (word(w), bits), "{format}");
        }
    }
}

/// "JMPN: Jump if RLO = 0", "LABEL", and a jump back.
#[test]
fn jumps() {
    let sections: Sections = &[("Input", "a : Bool"), ("Output", "n : Int; k : Int")];
    let int = of_type("SrcType", "Int");
    let mut one = Net::new("");
    let flow = contact(&mut one, "a");
    let jump = one.part("JumpNot", "", &[("in", flow)]);
    one.jump_to(jump, "far");
    let mut two = Net::new("");
    two.label("again");
    let add = two.part("Add", &int, &[("en", From::Rail), ("in1", local("n")), ("in2", xml::int(1))]);
    two.write(add, "out", local("n"));
    let less = two.part("Lt", &int, &[("pre", From::Rail), ("in1", local("n")), ("in2", xml::int(3))]);
    let back = two.part("Jump", "", &[("in", From::Pin(less, "out"))]);
    two.jump_to(back, "again");
    let mut three = Net::new("");
    three.label("far");
    let add = three.part("Add", &int, &[("en", From::Rail), ("in1", local("k")), ("in2", xml::int(1))]);
    three.write(add, "out", local("k"));
    let int = "{ S7_Templates := \"SrcType := Int\" }";
    let two_again = format!(
        "Label( again ) RUNG wire#powerrail {int} Add( in1 := #n, in2 := 1, out => #n ) END_RUNG
         RUNG wire#powerrail {int} Lt_Contact( in1 := #n, in2 := 3 ) JumpCoil( again ) END_RUNG"
    );
    let three_far = format!("Label( far ) RUNG wire#powerrail {int} Add( in1 := #k, in2 := 1, out => #k ) END_RUNG");
    let networks = ["RUNG wire#powerrail Contact( #a ) I_JumpCoil( far ) END_RUNG", &two_again, &three_far];
    tape(
        both(sections, vec![one, two, three], &networks, ""),
        ["a"],
        ["n", "k"],
        &[([0], [0, 1]), ([1], [3, 2]), ([1], [4, 3]), ([0], [4, 4])],
    );
}

/// "JMP: Jump if RLO = 1" in FBD: without an input, it jumps in each call.
#[test]
fn a_jump_without_an_input() {
    let mut one = Net::new("");
    let jump = one.part("Jump", "", &[]);
    one.jump_to(jump, "far");
    let mut two = Net::new("");
    two.part("Coil", "", &[("in", xml::typed("TRUE")), ("operand", local("y"))]);
    let mut three = Net::new("");
    three.label("far");
    three.part("Coil", "", &[("in", xml::typed("TRUE")), ("operand", local("z"))]);
    let sections: Sections = &[("Output", "y : Bool; z : Bool")];
    let mut ran = Ran::new(&[("b.xml", xml::block("FB", "B", sections, vec![one, two, three], "FBD"))]);
    ran.call();
    assert_eq!([ran.get("y"), ran.get("z")], [0, 1]);
}

/// "RET: Return": the block's ENO is set to the value of the operand; without a return it is TRUE.
#[test]
fn a_return_with_a_value_sets_eno_of_the_block() {
    let sections: Sections = &[("Input", "leave : Bool; good : Bool"), ("Output", "n : Int")];
    let mut net = Net::new("");
    let flow = contact(&mut net, "leave");
    net.part("ReturnValue", "", &[("in", flow), ("operand", local("good"))]);
    let mut two = Net::new("");
    let add =
        two.part("Add", &of_type("SrcType", "Int"), &[("en", From::Rail), ("in1", local("n")), ("in2", xml::int(1))]);
    two.write(add, "out", local("n"));
    let rungs = [
        "RUNG wire#powerrail Contact( #leave ) Return( #good ) END_RUNG",
        "RUNG wire#powerrail { S7_Templates := \"SrcType := Int\" } Add( in1 := #n, in2 := 1, out => #n ) END_RUNG",
    ];
    let caller = "FUNCTION_BLOCK \"B\"\nVAR_INPUT leave : BOOL; good : BOOL; END_VAR\nVAR_OUTPUT eno_of : BOOL; n : INT; END_VAR\n\
                  VAR inner : \"Inner\"; END_VAR\nBEGIN\n#inner(leave := #leave, good := #good, n => #n, ENO => #eno_of);\nEND_FUNCTION_BLOCK\n";
    for (name, text) in [
        ("Inner.xml", xml::block("FB", "Inner", sections, vec![net, two], "LAD")),
        ("Inner.s7dcl", document(sections, &rungs).replace("\"B\"", "\"Inner\"")),
    ] {
        let mut ran = Ran::new(&[(name, text), ("b.scl", caller.to_string())]);
        for (leave, good, eno, n) in [(0, 0, 1, 1), (1, 0, 0, 1), (1, 1, 1, 1), (0, 0, 1, 2)] {
            ran.set("leave", leave).set("good", good).call();
            assert_eq!([ran.get("eno_of"), ran.get("n")], [eno, n], "{name}");
        }
    }
}

/// "RET: Return", the options True and False: the block's ENO is set to this value.
#[test]
fn a_return_with_a_constant_sets_eno_of_the_block() {
    let caller = "FUNCTION_BLOCK \"B\"\nVAR_INPUT leave : BOOL; END_VAR\nVAR_OUTPUT eno_of : BOOL; END_VAR\n\
                  VAR inner : \"Inner\"; END_VAR\nBEGIN\n#inner(leave := #leave, ENO => #eno_of);\nEND_FUNCTION_BLOCK\n";
    for (part, eno) in [("ReturnTrue", 1), ("ReturnFalse", 0)] {
        let mut net = Net::new("");
        let flow = contact(&mut net, "leave");
        net.part(part, "", &[("in", flow)]);
        let inner = xml::block("FB", "Inner", &[("Input", "leave : Bool")], vec![net], "LAD");
        let mut ran = Ran::new(&[("Inner.xml", inner), ("b.scl", caller.to_string())]);
        assert_eq!(ran.set("leave", 1).call().get("eno_of"), eno, "{part}");
        assert_eq!(ran.set("leave", 0).call().get("eno_of"), 1, "{part} without flow");
    }
}

/// "Programming examples, inverting binary inputs": any pin may be negated.
#[test]
fn every_pin_may_be_negated() {
    let sections: Sections = &[
        ("Input", "a : Bool; b : Bool"),
        ("Output", "gate : Bool; coil : Bool; moved : Int; q : Bool; down : Bool; edge : Bool; box : Bool"),
        ("Static", "m : Bool; bit : Bool; t : TOF_TIME"),
    ];
    let negated = |pins: &[&str]| pins.iter().map(|pin| format!("<Negated Name=\"{pin}\" />")).collect::<String>();
    let mut net = Net::new("");
    let gate = net.part("A", &negated(&["in1", "out"]), &[("in1", local("a")), ("in2", local("b"))]);
    coil(&mut net, "gate", From::Pin(gate, "out"));
    net.part("Coil", &negated(&["in"]), &[("in", local("a")), ("operand", local("coil"))]);
    let copy = net.part("Move", &negated(&["en"]), &[("en", local("a")), ("in", xml::int(7))]);
    net.write(copy, "out1", local("moved"));
    let sr =
        net.part("Sr", &negated(&["s", "r1", "q"]), &[("s", local("a")), ("r1", local("b")), ("operand", local("m"))]);
    coil(&mut net, "q", From::Pin(sr, "q"));
    let inner = instance("t", &mut net) + &negated(&["IN", "Q"]);
    let timer = net.part("TOF", &inner, &[("IN", local("a")), ("PT", xml::typed("T#0ms"))]);
    net.write(timer, "Q", local("down"));
    let edge = net.part("PBox", &negated(&["in"]), &[("in", local("a")), ("bit", local("bit"))]);
    coil(&mut net, "edge", From::Pin(edge, "out"));
    let inverted = net.part("Move", &negated(&["out1"]), &[("en", local("b")), ("in", local("a"))]);
    net.write(inverted, "out1", local("box"));
    let mut ran = Ran::new(&[("b.xml", xml::block("FB", "B", sections, vec![net], "FBD"))]);
    let outputs = ["gate", "coil", "moved", "m", "q", "down", "edge", "box"];
    for (a, b, all) in [
        (1, 1, [1, 0, 0, 0, 1, 1, 0, 0]),
        (0, 1, [0, 1, 7, 1, 0, 0, 1, 1]),
        (0, 0, [1, 1, 7, 0, 1, 0, 0, 1]),
        (1, 0, [1, 0, 7, 0, 1, 1, 0, 1]),
    ] {
        ran.set("a", a).set("b", b).call();
        assert_eq!(outputs.map(|name| ran.get(name)), all, "a {a}, b {b}");
    }
}
