//! The behavior of each element, with values that can be checked by hand. The quoted titles are those of the pages on
//! LAD instructions for S7-1200 and S7-1500 in TIA Portal's help, V19.

use super::xml::{From, Net, int, local, typed};
use super::{Ran, compiled, xml};

const REAL: &str = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Real</TemplateValue>";
const INT: &str = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Int</TemplateValue>";

/// Adds a contact at the power rail, and returns its output pin.
fn contact(net: &mut Net, name: &str) -> From {
    From::Pin(net.part("Contact", "", &[("in", From::Rail), ("operand", local(name))]), "out")
}

fn coil(net: &mut Net, name: &str, flow: From) {
    net.part("Coil", "", &[("in", flow), ("operand", local(name))]);
}

/// Returns the value of a variable after each call with these inputs.
fn tape<const N: usize>(ran: &mut Ran, inputs: [&str; N], values: &[[i64; N]], output: &str) -> Vec<i64> {
    let call = |values: &[i64; N]| {
        for (input, value) in inputs.iter().zip(values) {
            ran.set(input, *value);
        }
        ran.call().get(output)
    };
    values.iter().map(call).collect()
}

/// "Normally open contact", "Normally closed contact", "Assignment".
#[test]
fn contacts_in_series_and_in_parallel() {
    let mut net = Net::new("Start");
    let (start, held) = (contact(&mut net, "start"), contact(&mut net, "run"));
    let either = net.part(
        "O",
        "<TemplateValue Name=\"Card\" Type=\"Cardinality\">2</TemplateValue>",
        &[("in1", start), ("in2", held)],
    );
    let stop = net.part(
        "Contact",
        "<Negated Name=\"operand\" />",
        &[("in", From::Pin(either, "out")), ("operand", local("stop"))],
    );
    coil(&mut net, "run", From::Pin(stop, "out"));
    let mut ran = Ran::of(&[("Input", "start : Bool; stop : Bool"), ("Output", "run : Bool")], vec![net]);
    let run = tape(&mut ran, ["start", "stop"], &[[0, 0], [1, 0], [0, 0], [1, 1], [0, 0], [1, 0]], "run");
    assert_eq!(run, [0, 1, 1, 0, 0, 1]);
}

/// "Scan operand for positive signal edge", "... negative ...": the memory bit follows the operand at every execution, so an edge
/// without flow is lost.
#[test]
fn edges_of_operands_update_their_memory_without_flow() {
    let mut net = Net::new("");
    for (part, bit, output) in [("PContact", "m1", "x"), ("NContact", "m2", "y")] {
        let flow = contact(&mut net, "f");
        let edge = net.part(part, "", &[("pre", flow), ("operand", local("a")), ("bit", local(bit))]);
        coil(&mut net, output, From::Pin(edge, "out"));
    }
    let sections =
        [("Input", "f : Bool; a : Bool"), ("Output", "x : Bool; y : Bool"), ("Static", "m1 : Bool; m2 : Bool")];
    let values = [[1, 0], [1, 1], [1, 1], [1, 0], [0, 1], [1, 1], [0, 0], [1, 0]];
    let mut ran = Ran::of(&sections, vec![net.clone()]);
    assert_eq!(tape(&mut ran, ["f", "a"], &values, "x"), [0, 1, 0, 0, 0, 0, 0, 0]);
    let mut ran = Ran::of(&sections, vec![net]);
    assert_eq!(tape(&mut ran, ["f", "a"], &values, "y"), [0, 0, 0, 1, 0, 0, 0, 0]);
}

/// "Scan RLO for positive signal edge", "Set operand on positive signal edge": the coil is TRUE for the call of the
/// edge, and passes the flow on.
#[test]
fn edges_of_the_flow() {
    let mut net = Net::new("");
    let flow = contact(&mut net, "a");
    let edge = net.part("PBox", "", &[("in", flow.clone()), ("bit", local("m1"))]);
    coil(&mut net, "x", From::Pin(edge, "out"));
    let falling = net.part("NBox", "", &[("in", flow.clone()), ("bit", local("m2"))]);
    coil(&mut net, "y", From::Pin(falling, "out"));
    let pulse = net.part("PCoil", "", &[("in", flow), ("operand", local("p")), ("bit", local("m3"))]);
    let last = net.part("NCoil", "", &[("in", From::Pin(pulse, "out")), ("operand", local("n")), ("bit", local("m4"))]);
    coil(&mut net, "z", From::Pin(last, "out"));
    let mut ran = Ran::of(
        &[
            ("Input", "a : Bool"),
            ("Output", "x : Bool; y : Bool; p : Bool; n : Bool; z : Bool"),
            ("Static", "m1 : Bool; m2 : Bool; m3 : Bool; m4 : Bool"),
        ],
        vec![net],
    );
    for (a, all) in [(0, [0, 0, 0, 0, 0]), (1, [1, 0, 1, 0, 1]), (1, [0, 0, 0, 0, 1]), (0, [0, 1, 0, 1, 0])] {
        ran.set("a", a).call();
        assert_eq!(["x", "y", "p", "n", "z"].map(|name| ran.get(name)), all, "a is {a}");
    }
}

/// "Comparator operations", "IN_RANGE", "OUT_RANGE", "OK", "NOT_OK".
#[test]
fn comparisons_let_the_flow_through() {
    let mut net = Net::new("");
    let names = ["eq", "ne", "gt", "ge", "lt", "le"];
    for (part, output) in ["Eq", "Ne", "Gt", "Ge", "Lt", "Le"].iter().zip(names) {
        let flow = contact(&mut net, "f");
        let compare = net.part(part, INT, &[("pre", flow), ("in1", local("a")), ("in2", int(5))]);
        coil(&mut net, output, From::Pin(compare, "out"));
    }
    for (part, output) in [("InRange", "inside"), ("OutRange", "outside")] {
        let range = net.part(part, INT, &[("pre", From::Rail), ("min", int(2)), ("in", local("a")), ("max", int(6))]);
        coil(&mut net, output, From::Pin(range, "out"));
    }
    for (part, output) in [("OK", "ok"), ("NotOK", "not_ok")] {
        let valid = net.part(part, REAL, &[("in", From::Rail), ("operand", local("r"))]);
        coil(&mut net, output, From::Pin(valid, "out"));
    }
    let outputs = "eq : Bool; ne : Bool; gt : Bool; ge : Bool; lt : Bool; le : Bool; inside : Bool; outside : Bool; ok : Bool; \
                   not_ok : Bool";
    let mut ran = Ran::of(&[("Input", "f : Bool; a : Int; r : Real"), ("Output", outputs)], vec![net]);
    for (f, a, all) in
        [(1, 5, [1, 0, 0, 1, 0, 1]), (1, 6, [0, 1, 1, 1, 0, 0]), (1, -7, [0, 1, 0, 0, 1, 1]), (0, 5, [0; 6])]
    {
        ran.set("f", f).set("a", a).call();
        assert_eq!(names.map(|name| ran.get(name)), all, "a is {a}");
        let is_inside = i64::from((2..=6).contains(&a));
        assert_eq!([ran.get("inside"), ran.get("outside")], [is_inside, 1 - is_inside]);
    }
    assert_eq!([ran.get("ok"), ran.get("not_ok")], [1, 0]);
    let (offset, _) = ran.place("r");
    for invalid in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        ran.machine.set(invalid.into(), offset);
        ran.call();
        assert_eq!([ran.get("ok"), ran.get("not_ok")], [0, 1], "{invalid}");
    }
}

/// "Invert RLO", "AND logic operation", "OR ...", "EXCLUSIVE OR ...": FBD; the operands are at the pins, one of them
/// negated.
#[test]
fn gates_of_function_block_diagrams() {
    let mut net = Net::new("");
    for (part, output) in [("A", "and"), ("O", "or"), ("X", "xor")] {
        let pins = [("in1", local("a")), ("in2", local("b")), ("in3", local("c"))];
        let gate = net.part(part, "<Negated Name=\"in3\" />", &pins);
        coil(&mut net, output, From::Pin(gate, "out"));
    }
    let not = net.part("Not", "", &[("in", local("a"))]);
    coil(&mut net, "no", From::Pin(not, "out"));
    let sections =
        [("Input", "a : Bool; b : Bool; c : Bool"), ("Output", "and : Bool; or : Bool; xor : Bool; no : Bool")];
    let mut ran = Ran::new(&[("b.xml", xml::block("FB", "B", &sections, vec![net], "FBD"))]);
    for bits in 0..8 {
        let [a, b, c] = [bits & 1, bits >> 1 & 1, bits >> 2 & 1];
        ran.set("a", a).set("b", b).set("c", c).call();
        let not_c = 1 - c;
        let expected = [a & b & not_c, a | b | not_c, a ^ b ^ not_c, 1 - a];
        assert_eq!(["and", "or", "xor", "no"].map(|name| ran.get(name)), expected, "{bits:03b}");
    }
}

/// "Negate assignment", "Set output", "Reset output", "SET_BF", "RESET_BF".
#[test]
fn coils_negate_set_and_reset() {
    let mut net = Net::new("");
    let (set, reset) = (contact(&mut net, "s"), contact(&mut net, "r"));
    net.part("Coil", "<Negated Name=\"operand\" />", &[("in", set.clone()), ("operand", local("no"))]);
    net.part("SCoil", "", &[("in", set.clone()), ("operand", local("y"))]);
    net.part("RCoil", "", &[("in", reset.clone()), ("operand", local("y"))]);
    net.part("SBitfield", "", &[("in", set), ("operand", local("field[2]")), ("n", int(3))]);
    net.part("RBitfield", "", &[("in", reset), ("operand", local("field[3]")), ("n", int(1))]);
    let sections =
        [("Input", "s : Bool; r : Bool"), ("Output", "no : Bool; y : Bool"), ("Static", "field : Array[0..6] of Bool")];
    let mut ran = Ran::of(&sections, vec![net]);
    for (s, r, no, y, field) in [
        (0, 0, 1, 0, [0; 7]),
        (1, 0, 0, 1, [0, 0, 1, 1, 1, 0, 0]),
        (0, 0, 1, 1, [0, 0, 1, 1, 1, 0, 0]),
        (1, 1, 0, 0, [0, 0, 1, 0, 1, 0, 0]),
    ] {
        ran.set("s", s).set("r", r).call();
        assert_eq!([ran.get("no"), ran.get("y")], [no, y]);
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(|at| ran.get(&format!("field[{at}]"))), field);
    }
}

/// "TON: Generate on-delay", "TOF", "TP", "TONR": calls every 100 ms, PT 200 ms.
#[test]
fn timers_with_instances() {
    let mut net = Net::new("");
    for (part, output) in [("TON", "on"), ("TOF", "off"), ("TP", "pulse")] {
        let flow = contact(&mut net, "a");
        let inner = format!(
            "<Instance Scope=\"LocalVariable\" UId=\"{}\"><Component Name=\"t_{output}\" /></Instance>\
             <TemplateValue Name=\"time_type\" Type=\"Type\">Time</TemplateValue>",
            net.next()
        );
        let timer = net.part(&format!("{part} Version=\"1.0\""), &inner, &[("IN", flow), ("PT", typed("T#200ms"))]);
        coil(&mut net, output, From::Pin(timer, "Q"));
        if output == "on" {
            net.write(timer, "ET", local("et"));
        }
    }
    let sections = [
        ("Input", "a : Bool"),
        ("Output", "on : Bool; off : Bool; pulse : Bool; et : Time"),
        ("Static", "t_on : TON_TIME; t_off : TOF_TIME; t_pulse : IEC_TIMER"),
    ];
    let mut ran = Ran::of(&sections, vec![net]);
    let expected = [
        (1, [0, 1, 1, 0]),
        (1, [0, 1, 1, 100]),
        (1, [1, 1, 0, 200]),
        (0, [0, 1, 0, 0]),
        (0, [0, 1, 0, 0]),
        (0, [0, 0, 0, 0]),
    ];
    for (number, (a, all)) in expected.into_iter().enumerate() {
        ran.set("a", a).call();
        assert_eq!(["on", "off", "pulse", "et"].map(|name| ran.get(name)), all, "call {number}");
    }
}

/// "TON: Start on-delay timer", "RT: Reset timer", "PT: Load time duration": coils of a timer.
#[test]
fn coils_of_timers() {
    let mut net = Net::new("");
    let flow = contact(&mut net, "a");
    net.part("TonCoil", "", &[("in", flow), ("operand", local("t")), ("value", typed("T#200ms"))]);
    let reset = contact(&mut net, "r");
    net.part("ResetIECTimerCoil", "", &[("in", reset), ("operand", local("t"))]);
    let done = contact(&mut net, "t.Q");
    coil(&mut net, "y", done);
    let mut ran =
        Ran::of(&[("Input", "a : Bool; r : Bool"), ("Output", "y : Bool"), ("Static", "t : TON_TIME")], vec![net]);
    let values = [[1, 0], [1, 0], [1, 0], [1, 1], [1, 0], [1, 0], [1, 0], [0, 0]];
    assert_eq!(tape(&mut ran, ["a", "r"], &values, "y"), [0, 0, 1, 0, 0, 0, 1, 0]);
}

/// "CTU: Count up", "CTD", "CTUD".
#[test]
fn counters_with_instances() {
    let mut net = Net::new("");
    let (up, reset) = (contact(&mut net, "up"), contact(&mut net, "r"));
    let uid = net.next();
    let inner = format!(
        "<Instance Scope=\"LocalVariable\" UId=\"{uid}\"><Component Name=\"c\" /></Instance>\
         <TemplateValue Name=\"value_type\" Type=\"Type\">Int</TemplateValue>"
    );
    let counter = net.part("CTU", &inner, &[("CU", up), ("R", reset), ("PV", int(2))]);
    coil(&mut net, "y", From::Pin(counter, "Q"));
    net.write(counter, "CV", local("cv"));
    let sections = [("Input", "up : Bool; r : Bool"), ("Output", "y : Bool; cv : Int"), ("Static", "c : CTU_INT")];
    let mut ran = Ran::of(&sections, vec![net]);
    for (up, r, y, cv) in [(1, 0, 0, 1), (1, 0, 0, 1), (0, 0, 0, 1), (1, 0, 1, 2), (0, 1, 0, 0)] {
        ran.set("up", up).set("r", r).call();
        assert_eq!([ran.get("y"), ran.get("cv")], [y, cv]);
    }
}

/// "Basics of the EN/ENO mechanism", "MOVE", "ADD": a box whose EN is FALSE leaves its output unchanged; ENO is FALSE
/// if the sum overflows, and equals EN where ENO is not generated.
#[test]
fn boxes_are_executed_with_en_and_tell_of_failures_with_eno() {
    let mut net = Net::new("");
    let flow = contact(&mut net, "f");
    let add = net.part("Add", INT, &[("en", flow.clone()), ("in1", local("a")), ("in2", local("b"))]);
    net.write(add, "out", local("sum"));
    coil(&mut net, "fits", From::Pin(add, "eno"));
    let quiet =
        net.part("Mul DisabledENO=\"true\"", INT, &[("en", flow.clone()), ("in1", local("a")), ("in2", local("b"))]);
    net.write(quiet, "out", local("product"));
    coil(&mut net, "done", From::Pin(quiet, "eno"));
    let copy = net.part("Move", "", &[("en", flow), ("in", local("a"))]);
    net.write(copy, "out1", local("one"));
    net.write(copy, "out2", local("two"));
    let sections = [
        ("Input", "f : Bool; a : Int; b : Int"),
        ("Output", "sum : Int; fits : Bool; product : Int; done : Bool; one : Int; two : Int"),
    ];
    let mut ran = Ran::of(&sections, vec![net]);
    let names = ["sum", "fits", "product", "done", "one", "two"];
    for (f, a, b, all) in [
        (1, 3, 4, [7, 1, 12, 1, 3, 3]),
        (0, 5, 5, [7, 0, 12, 0, 3, 3]),
        (1, 32767, 1, [-32768, 0, 32767, 1, 32767, 32767]),
        (1, 300, 300, [600, 1, 24464, 1, 300, 300]),
    ] {
        ran.set("f", f).set("a", a).set("b", b).call();
        assert_eq!(names.map(|name| ran.get(name)), all, "f {f}, a {a}, b {b}");
    }
}

/// The pages of ADD to MOD, NEG, INC, DEC, ABS, MIN, MAX, LIMIT, SEL, MUX, SHL to ROR, AND to XOR, INV, SQR, CONVERT,
/// ROUND to TRUNC, NORM_X, SCALE_X, CALCULATE: one result of each for in1 = 13 and in2 = 4.
#[test]
fn boxes_calculate() {
    let real_to_int = format!("{REAL}<TemplateValue Name=\"DestType\" Type=\"Type\">Int</TemplateValue>");
    let int_to_real = format!("{INT}<TemplateValue Name=\"DestType\" Type=\"Type\">Real</TemplateValue>");
    let word = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Word</TemplateValue>";
    let calculate = format!("{INT}<Equation>(IN1 + IN2) * IN2 - IN1</Equation>");
    let (a, b) = (local("a"), local("b"));
    let pair = || vec![("in1", a.clone()), ("in2", b.clone())];
    let one = || vec![("in", a.clone())];
    let real = |pin: &'static str| vec![(pin, local("r"))];
    let limits = |pin: &'static str, of: From| vec![("min", int(0)), (pin, of), ("max", int(20))];
    let cases = [
        ("Add", INT, pair(), 17),
        ("Sub", INT, pair(), 9),
        ("Mul", INT, pair(), 52),
        ("Div", INT, pair(), 3),
        ("Mod", INT, pair(), 1),
        ("Neg", INT, one(), -13),
        ("Abs", INT, vec![("in", local("c"))], 7),
        ("Min", INT, pair(), 4),
        ("Max", INT, pair(), 13),
        ("Limit", INT, vec![("MN", int(0)), ("IN", a.clone()), ("MX", int(10))], 10),
        ("Sel", INT, vec![("g", local("f")), ("in0", a.clone()), ("in1", b.clone())], 4),
        ("Mux", INT, vec![("k", int(1)), ("in0", a.clone()), ("in1", b.clone())], 4),
        ("Shl", word, vec![("in", local("w")), ("n", int(2))], 52),
        ("Shr", word, vec![("in", local("w")), ("n", int(2))], 3),
        ("Rol", word, vec![("in", local("w")), ("n", int(15))], 0x8006 - 65536),
        ("Ror", word, vec![("in", local("w")), ("n", int(1))], 0x8006 - 65536),
        ("And", word, vec![("in1", local("w")), ("in2", int(6))], 4),
        ("Or", word, vec![("in1", local("w")), ("in2", int(6))], 15),
        ("Xor", word, vec![("in1", local("w")), ("in2", int(6))], 11),
        ("Inv", word, vec![("in", local("w"))], -14),
        ("Swap", word, vec![("in", local("w"))], 0x0d00),
        ("Round", &real_to_int, real("in"), 2),
        ("Trunc", &real_to_int, real("in"), 2),
        ("Ceil", &real_to_int, real("in"), 3),
        ("Floor", &real_to_int, real("in"), 2),
        ("Convert", &real_to_int, real("in"), 2),
        ("Sqr", REAL, real("in"), 6),
        ("Norm_X", &int_to_real, limits("value", local("c100")), 5),
        ("Calculate", &calculate, pair(), 55),
    ];
    for (part, inner, pins, expected) in cases {
        let mut net = Net::new("");
        let pins: Vec<(&str, From)> = [("en", From::Rail)].into_iter().chain(pins).collect();
        let uid = net.part(part, inner, &pins);
        net.write(uid, "out", local("y"));
        let statics = "a : Int := 13; b : Int := 4; c : Int := -7; w : Word := 16#D; r : Real := 2.5; f : Bool := true; c100 : Int := 100";
        let mut ran = Ran::of(&[("Output", "y : Int"), ("Static", statics)], vec![net]);
        assert_eq!(ran.call().get("y"), expected, "{part}");
    }
}

/// "INC: Increment", "DEC: Decrement", "SCALE_X": the operand is read and written; 0.25 in the range 0..200 is 50.
#[test]
fn steps_and_scaling() {
    let mut net = Net::new("");
    let flow = contact(&mut net, "f");
    let inc = net.part("Inc", INT, &[("en", flow), ("operand", local("n"))]);
    coil(&mut net, "fits", From::Pin(inc, "eno"));
    let types = format!("{REAL}<TemplateValue Name=\"DestType\" Type=\"Type\">Int</TemplateValue>");
    let pins =
        [("en", From::Rail), ("min", int(0)), ("value", From::Constant("Real", "0.25".into())), ("max", int(200))];
    let scale = net.part("Scale_X", &types, &pins);
    net.write(scale, "out", local("y"));
    let sections = [("Input", "f : Bool"), ("Output", "fits : Bool; y : Int"), ("Static", "n : Int := 32765")];
    let mut ran = Ran::of(&sections, vec![net]);
    for (f, n, fits) in [(0, 32765, 0), (1, 32766, 1), (1, 32767, 1), (1, -32768, 0)] {
        ran.set("f", f).call();
        assert_eq!([ran.get("n"), ran.get("fits"), ran.get("y")], [n, fits, 50]);
    }
}

/// "JMP: Jump if RLO = 1", "JMPN", "LABEL", "RET: Return".
#[test]
fn jumps_leave_networks_out_and_return_leaves_the_block() {
    let mut one = Net::new("leap");
    let flow = contact(&mut one, "a");
    let jump = one.part("Jump", "", &[("in", flow)]);
    one.jump_to(jump, "far");
    let mut two = Net::new("between");
    let add = two.part("Add", INT, &[("en", From::Rail), ("in1", local("n")), ("in2", int(1))]);
    two.write(add, "out", local("n"));
    let mut three = Net::new("after");
    three.label("far");
    let stop = contact(&mut three, "b");
    three.part("Return", "", &[("in", stop)]);
    let mut four = Net::new("end");
    let add = four.part("Add", INT, &[("en", From::Rail), ("in1", local("n")), ("in2", int(10))]);
    four.write(add, "out", local("n"));
    let mut ran = Ran::of(&[("Input", "a : Bool; b : Bool"), ("Output", "n : Int")], vec![one, two, three, four]);
    assert_eq!(tape(&mut ran, ["a", "b"], &[[0, 0], [1, 0], [0, 1], [1, 1]], "n"), [11, 21, 22, 22]);
}

/// "Calling function blocks", "Calling functions": if EN is FALSE, an instance keeps its values and ENO is FALSE; an
/// unconnected input keeps the instance's value.
#[test]
fn calls_of_blocks_in_other_files() {
    let motor = "FUNCTION_BLOCK \"Motor\"\nVAR_INPUT start : BOOL; add : INT := 2; END_VAR\nVAR_OUTPUT run : BOOL; sum : INT; END_VAR\n\
                 BEGIN\n#run := #start; #sum := #sum + #add;\nEND_FUNCTION_BLOCK\n\
                 FUNCTION \"Twice\" : INT\nVAR_INPUT x : INT; END_VAR\nBEGIN\n#Twice := #x * 2;\nEND_FUNCTION\n";
    let mut net = Net::new("");
    let (flow, start) = (contact(&mut net, "f"), contact(&mut net, "s"));
    let uid = net.next();
    let inner = format!(
        "<Instance Scope=\"LocalVariable\" UId=\"{uid}\"><Component Name=\"m\" /></Instance>\
         <Parameter Name=\"start\" Section=\"Input\" Type=\"Bool\" /><Parameter Name=\"run\" Section=\"Output\" Type=\"Bool\" />"
    );
    let call = net.call("FB", "Motor", &inner, &[("en", flow.clone()), ("start", start)]);
    net.write(call, "sum", local("sum"));
    coil(&mut net, "run", From::Pin(call, "run"));
    coil(&mut net, "eno", From::Pin(call, "eno"));
    let inner = "<Parameter Name=\"x\" Section=\"Input\" Type=\"Int\" /><Parameter Name=\"Ret_Val\" Section=\"Return\" Type=\"Int\" />";
    let twice = net.call("FC", "Twice", inner, &[("en", flow), ("x", local("sum"))]);
    net.write(twice, "Ret_Val", local("y"));
    let sections = [
        ("Input", "f : Bool; s : Bool"),
        ("Output", "run : Bool; sum : Int; eno : Bool; y : Int"),
        ("Static", "m : \"Motor\""),
    ];
    let sources = [("b.xml", xml::block("FB", "B", &sections, vec![net], "LAD")), ("motor.scl", motor.to_string())];
    let mut ran = Ran::new(&sources);
    for (f, s, all) in [(1, 1, [1, 2, 1, 4]), (0, 0, [1, 2, 0, 4]), (1, 0, [0, 4, 1, 8])] {
        ran.set("f", f).set("s", s).call();
        assert_eq!(["run", "sum", "eno", "y"].map(|name| ran.get(name)), all);
    }
}

/// A network in SCL, given as tokens, among other networks of a block.
#[test]
fn a_network_in_scl() {
    let tokens = |attribute: &str| {
        format!(
            "<StructuredText xmlns=\"http://www.siemens.com/automation/Openness/SW/NetworkSource/StructuredText/v3\">\
        <Token Text=\"IF\" UId=\"21\" /><Blank UId=\"22\" />\n<Access Scope=\"LocalVariable\" UId=\"23\"><Symbol UId=\"24\">\
        <Component Name=\"a\" UId=\"25\" /></Symbol></Access><Blank UId=\"26\" /><Token Text=\"THEN\" UId=\"27\" />\
        <LineComment UId=\"28\"><Text UId=\"29\"> counts; (* all of it</Text></LineComment><NewLine UId=\"30\" />\n\
        <Access Scope=\"LocalVariable\" UId=\"31\"><Symbol UId=\"32\"><Component Name=\"list\" {attribute}UId=\"33\">\
        <Token Text=\"[\" UId=\"34\" /><Access Scope=\"LocalVariable\" UId=\"35\"><Symbol UId=\"36\"><Component Name=\"i\" UId=\"37\" />\
        </Symbol></Access><Token Text=\"]\" UId=\"38\" /></Component></Symbol></Access><Blank UId=\"39\" /><Token Text=\":=\" UId=\"40\" />\
        <Access Scope=\"Call\" UId=\"41\"><Instruction Name=\"MAX\" UId=\"42\"><Token Text=\"(\" UId=\"43\" /><Parameter Name=\"IN1\" UId=\"44\">\
        <Token Text=\":=\" UId=\"45\" /><Access Scope=\"LiteralConstant\" UId=\"46\"><Constant UId=\"47\"><ConstantValue UId=\"48\">3</ConstantValue>\
        </Constant></Access></Parameter><Token Text=\",\" UId=\"49\" /><Parameter Name=\"IN2\" UId=\"50\"><Token Text=\":=\" UId=\"51\" />\
        <Access Scope=\"LocalVariable\" UId=\"52\"><Symbol UId=\"53\"><Component Name=\"i\" UId=\"54\" /></Symbol></Access></Parameter>\
        <Token Text=\")\" UId=\"55\" /></Instruction></Access><Token Text=\";\" UId=\"56\" /><NewLine UId=\"57\" />\n\
        <Token Text=\"END_IF\" UId=\"58\" /><Token Text=\";\" UId=\"59\" /></StructuredText>"
        )
    };
    let sections = [("Input", "a : Bool; i : Int"), ("Output", "y : Bool"), ("Static", "list : Array[0..9] of Int")];
    // TIA Portal V17 leaves the attribute out.
    for attribute in ["AccessModifier=\"Array\" ", ""] {
        let mut lad = Net::new("");
        let flow = contact(&mut lad, "a");
        coil(&mut lad, "y", flow);
        let mut ran = Ran::of(&sections, vec![lad, Net::of_source("", &tokens(attribute))]);
        ran.set("a", 1).set("i", 7).call();
        assert_eq!([ran.get("y"), ran.get("list[7]"), ran.get("list[3]")], [1, 7, 0]);
        ran.set("i", 1).call();
        assert_eq!([ran.get("list[1]"), ran.get("list[7]")], [3, 7]);
    }
}

/// A slice comes as tokens, and what is not known is refused: it could be a NOT.
#[test]
fn a_slice_in_tokens_and_an_unknown_element() {
    let variable = |name: &str, rest: &str| {
        format!("<Access Scope=\"LocalVariable\"><Symbol><Component Name=\"{name}\" />{rest}</Symbol></Access>")
    };
    let text = |before: &str| {
        let slice = variable("w", "<Token Text=\".\" /><Token Text=\"%X9\" />");
        format!(
            "<StructuredText xmlns=\"http://www.siemens.com/automation/Openness/SW/NetworkSource/StructuredText/v3\">{}\
             <Token Text=\":=\" />{before}{slice}<Token Text=\";\" /></StructuredText>",
            variable("y", "")
        )
    };
    let sections = [("Input", "w : Word"), ("Output", "y : Bool")];
    let mut ran = Ran::of(&sections, vec![Net::of_source("", &text(""))]);
    assert_eq!([0x0200, 0x0100].map(|word| ran.set("w", word).call().get("y")), [1, 0]);
    let block = xml::block("FB", "Pump", &sections, vec![Net::of_source("", &text("<Inverted />"))], "LAD");
    let errors = compiled(&[("pump.xml", block)]).unwrap_err();
    assert_eq!(errors[0].problems[0].message, "FB Pump, network 1: `Inverted` is not supported in a statement");
}

/// Unsupported elements are rejected by name, with block, network and element, and other errors are still reported.
#[test]
fn errors_name_block_network_and_element() {
    let list =
        "<StatementList xmlns=\"http://www.siemens.com/automation/Openness/SW/NetworkSource/StatementList/v3\" />";
    let mut lad = Net::new("Start");
    let flow = contact(&mut lad, "nothing");
    coil(&mut lad, "y", flow);
    let networks = vec![Net::of_source("Old", list), lad];
    let text = xml::block("FB", "Pump", &[("Output", "y : Bool")], networks, "LAD");
    let errors = compiled(&[("pump.xml", text.clone())]).unwrap_err();
    let messages: Vec<&str> = errors[0].problems.iter().map(|problem| problem.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "FB Pump, network 1 \"Old\": this network is in STL, which is not supported",
            "FB Pump, network 2 \"Start\": Contact #nothing: #nothing is not declared in this block"
        ]
    );
    let line = errors[0].problems[1].place.as_ref().map_or(0, |place| place.line);
    assert!(text.lines().nth(line - 1).is_some_and(|line| line.contains("Name=\"nothing\"")), "{}", errors[0]);
}
