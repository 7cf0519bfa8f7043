//! Boxes that compute, and the conditions under which their ENO is FALSE.

use super::{Sections, both, coil, contact, of_type, tape};
use crate::xml::{self, From, Net, int, local};

/// A box: its types, its inputs as pins with variables or constants, and the pin of its result.
struct Boxed {
    part: &'static str,
    /// The name in a document, if it differs.
    name: &'static str,
    types: &'static [(&'static str, &'static str)],
    pins: &'static [(&'static str, &'static str)],
    out: &'static str,
}

/// Parses an operand: a variable of the block, or a constant preceded by its type: `Int 5`.
fn drawn(of: &'static str) -> From {
    match of.split_once(' ') {
        Some((ty, value)) => From::Constant(ty, value.to_string()),
        None => local(of),
    }
}

fn written(of: &str) -> String {
    of.split_once(' ').map_or(format!("#{of}"), |(_, value)| value.to_string())
}

impl Boxed {
    fn draw(&self, net: &mut Net, flow: From) -> u32 {
        let types: String = self.types.iter().map(|(name, of)| of_type(name, of)).collect();
        let mut pins = vec![("en", flow)];
        pins.extend(self.pins.iter().map(|(pin, of)| (*pin, drawn(of))));
        net.part(self.part, &types, &pins)
    }

    fn write(&self) -> String {
        let types: Vec<String> = self.types.iter().map(|(name, of)| format!("{name} := {of}")).collect();
        let pins: String = self.pins.iter().map(|(pin, of)| format!("{pin} := {}, ", written(of))).collect();
        let name = if self.name.is_empty() { self.part } else { self.name };
        let settings = format!("S7_Templates := \"[{}]\"; S7_GenerateENO := \"TRUE\"", types.join(", "));
        format!("{{ {settings} }} {name}( {pins}{} => #y )", self.out.to_lowercase())
    }
}

/// Checks, in both formats, the result and ENO for each of these values of the inputs `a` and `b`.
#[track_caller]
fn gives(boxed: &Boxed, inputs: [&str; 2], output: &str, rows: &[([i64; 2], [i64; 2])]) {
    let sections = [
        ("Input", format!("a : {}; b : {}; en : Bool := true", inputs[0], inputs[1])),
        ("Output", format!("y : {output}; ok : Bool")),
        ("Static", "r : Real := 2.5; w : Word := 16#D".to_string()),
    ];
    let sections: Vec<(&str, &str)> = sections.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let mut net = Net::new("");
    let flow = contact(&mut net, "en");
    let uid = boxed.draw(&mut net, flow);
    net.write(uid, boxed.out, From::Local("y".to_string()));
    coil(&mut net, "ok", From::Pin(uid, "eno"));
    let rungs = format!("RUNG wire#powerrail Contact( #en ) {} Coil( #ok ) END_RUNG", boxed.write());
    for (format, mut ran) in both(&sections, vec![net], &[&rungs], "") {
        for (values, expected) in rows {
            ran.set("a", values[0]).set("b", values[1]).set("en", 1).call();
            assert_eq!([ran.get("y"), ran.get("ok")], *expected, "{format} {} of {values:?}", boxed.part);
        }
        // If EN is FALSE, the result remains unchanged.
        let before = ran.get("y");
        ran.set("a", 1).set("b", 1).set("en", 0).call();
        assert_eq!([ran.get("y"), ran.get("ok")], [before, 0], "{format} {} without EN", boxed.part);
    }
}

const INT: &[(&str, &str)] = &[("SrcType", "Int")];
const REAL: &[(&str, &str)] = &[("SrcType", "Real")];
const WORD: &[(&str, &str)] = &[("SrcType", "Word")];
const PAIR: &[(&str, &str)] = &[("in1", "a"), ("in2", "b")];
const ONE: &[(&str, &str)] = &[("in", "a")];

fn of(
    part: &'static str,
    types: &'static [(&'static str, &'static str)],
    pins: &'static [(&'static str, &'static str)],
) -> Boxed {
    Boxed { part, name: "", types, pins, out: "out" }
}

/// "ADD" to "MOD", "NEG", "ABS": ENO is FALSE if the result overflows, or if a divisor is 0.
#[test]
fn arithmetic() {
    let int = ["Int", "Int"];
    gives(&of("Add", INT, PAIR), int, "Int", &[([3, 4], [7, 1]), ([32767, 1], [-32768, 0])]);
    gives(&of("Sub", INT, PAIR), int, "Int", &[([3, 4], [-1, 1]), ([-32768, 1], [32767, 0])]);
    gives(&of("Mul", INT, PAIR), int, "Int", &[([3, -4], [-12, 1]), ([300, 300], [24464, 0])]);
    gives(&of("Div", INT, PAIR), int, "Int", &[([-7, 2], [-3, 1]), ([7, 0], [0, 0]), ([-32768, -1], [-32768, 0])]);
    gives(&of("Mod", INT, PAIR), int, "Int", &[([-7, 2], [-1, 1]), ([7, 0], [0, 0])]);
    gives(&of("Neg", INT, ONE), int, "Int", &[([5, 0], [-5, 1]), ([-32768, 0], [-32768, 0])]);
    gives(&of("Abs", INT, ONE), int, "Int", &[([-5, 0], [5, 1]), ([-32768, 0], [-32768, 0])]);
    const THREE: &[(&str, &str)] = &[("in1", "a"), ("in2", "b"), ("in3", "Int 7")];
    gives(
        &of("Add", INT, THREE),
        int,
        "Int",
        &[([3, 4], [14, 1]), ([32767, -7], [32767, 1]), ([32760, 1], [-32768, 0])],
    );
    // A box whose type follows from its operands computes in the wider type.
    gives(
        &of("Add", &[], PAIR),
        ["Int", "DInt"],
        "DInt",
        &[([32767, 1], [32768, 1]), ([1, 2147483647], [-2147483648, 0])],
    );
}

/// "SQR", "SQRT", "LN", "EXPT", "FRAC": ENO is FALSE if the result is not a valid floating-point number.
#[test]
fn floating_point() {
    let real = ["Real", "Real"];
    gives(&of("Sqrt", REAL, ONE), real, "Real", &[([16, 0], [4, 1])]);
    gives(&of("Sqr", REAL, ONE), real, "Real", &[([-3, 0], [9, 1])]);
    gives(&of("Expt", REAL, PAIR), real, "Real", &[([2, 10], [1024, 1]), ([10, 2], [100, 1])]);
    gives(&of("Exp", REAL, ONE), real, "Real", &[([0, 0], [1, 1])]);
    gives(&of("Mul", REAL, &[("in1", "a"), ("in2", "r")]), real, "Real", &[([4, 0], [10, 1])]);
    let mut net = Net::new("");
    let root = net.part("Sqrt", &of_type("SrcType", "Real"), &[("en", From::Rail), ("in", local("x"))]);
    net.write(root, "out", local("y"));
    coil(&mut net, "ok", From::Pin(root, "eno"));
    let part = net.part("Frac", &of_type("SrcType", "Real"), &[("en", From::Rail), ("in", local("z"))]);
    net.write(part, "out", local("rest"));
    let large = net.part("Exp", &of_type("SrcType", "Real"), &[("en", From::Rail), ("in", local("x"))]);
    net.write(large, "out", local("y"));
    coil(&mut net, "exp", From::Pin(large, "eno"));
    let sections: Sections = &[
        ("Input", "x : Real"),
        ("Output", "y : Real; ok : Bool; exp : Bool; rest : Real"),
        ("Static", "z : Real := 123.25"),
    ];
    let real = "S7_Templates := \"SrcType := Real\"";
    let rungs = format!(
        "RUNG wire#powerrail {{ {real}; S7_GenerateENO := \"TRUE\" }} Sqrt( in := #x, out => #y ) Coil( #ok ) END_RUNG
         RUNG wire#powerrail {{ {real} }} Frac( in := #z, out => #rest ) END_RUNG
         RUNG wire#powerrail {{ {real}; S7_GenerateENO := \"TRUE\" }} Exp( in := #x, out => #y ) Coil( #exp ) END_RUNG"
    );
    for (format, mut ran) in both(sections, vec![net], &[&rungs], "") {
        for (x, ok, exp) in [(4, 1, 1), (-4, 0, 1), (1000, 1, 0)] {
            ran.set("x", x).call();
            assert_eq!([ran.get("ok"), ran.get("exp")], [ok, exp], "{format}, x is {x}");
            assert_eq!(ran.bits("rest") as u32, 0.25f32.to_bits(), "{format}");
        }
    }
}

/// "SIN" to "ATAN": angles in radians; ENO is FALSE outside the domain of ACOS and ASIN.
#[test]
fn angles() {
    for (part, rows) in [
        ("Sin", &[([0, 0], [0, 1])][..]),
        ("Cos", &[([0, 0], [1, 1])]),
        ("Tan", &[([0, 0], [0, 1])]),
        ("Asin", &[([0, 0], [0, 1]), ([2, 0], [0, 0])]),
        ("Acos", &[([1, 0], [0, 1]), ([2, 0], [0, 0])]),
        ("Atan", &[([0, 0], [0, 1])]),
    ] {
        gives(&of(part, REAL, ONE), ["Real", "Real"], "Real", rows);
    }
}

/// "CONVERT", "ROUND", "CEIL", "FLOOR", "TRUNC": ENO is FALSE if the number is out of range.
#[test]
fn conversions() {
    const TO_INT: &[(&str, &str)] = &[("SrcType", "DInt"), ("DestType", "Int")];
    gives(&of("Convert", TO_INT, ONE), ["DInt", "Int"], "Int", &[([-5, 0], [-5, 1]), ([40000, 0], [-25536, 0])]);
    // The type of the result is that of its variable.
    gives(&of("Convert", &[], ONE), ["DInt", "Int"], "Int", &[([-5, 0], [-5, 1]), ([40000, 0], [-25536, 0])]);
    const TO_UINT: &[(&str, &str)] = &[("SrcType", "Int"), ("DestType", "UInt")];
    gives(&of("Convert", TO_UINT, ONE), ["Int", "Int"], "UInt", &[([5, 0], [5, 1]), ([-1, 0], [65535, 0])]);
    const ROUNDED: &[(&str, &str)] = &[("SrcType", "Real"), ("DestType", "Int")];
    for (part, value) in [("Round", 2), ("Trunc", 2), ("Ceil", 3), ("Floor", 2)] {
        gives(&of(part, ROUNDED, &[("in", "r")]), ["Int", "Int"], "Int", &[([0, 0], [value, 1])]);
        gives(&of(part, ROUNDED, ONE), ["Real", "Int"], "Int", &[([32767, 0], [32767, 1]), ([-32768, 0], [-32768, 1])]);
        let boxed = of(part, ROUNDED, ONE);
        gives(&boxed, ["Real", "Int"], "Int", &[([32768, 0], [-32768, 0])]);
    }
}

/// "NORM_X: Normalize", "SCALE_X: Scale": ENO is FALSE if MIN is not below MAX, or if the result overflows.
#[test]
fn scales() {
    const NORM: &[(&str, &str)] = &[("SrcType", "Int"), ("DestType", "Real")];
    let norm = Boxed {
        part: "Normalize",
        name: "",
        types: NORM,
        pins: &[("min", "Int 10"), ("value", "a"), ("max", "b")],
        out: "out",
    };
    gives(&norm, ["Int", "Int"], "Real", &[([60, 20], [5, 1]), ([10, 5], [0, 0])]);
    const SCALE: &[(&str, &str)] = &[("SrcType", "Real"), ("DestType", "Int")];
    let scale = Boxed {
        part: "Scale",
        name: "",
        types: SCALE,
        pins: &[("min", "Int 0"), ("value", "a"), ("max", "b")],
        out: "out",
    };
    // 2 * 20000 exceeds an INT.
    gives(&scale, ["Real", "Int"], "Int", &[([1, 20000], [20000, 1]), ([2, 20000], [-25536, 0]), ([0, 0], [0, 0])]);
}

/// "MIN", "MAX", "LIMIT", "SEL", "MUX": ENO of LIMIT and MUX reports invalid limits and selectors.
#[test]
fn choices() {
    const VALUE: &[(&str, &str)] = &[("value_type", "Int")];
    let int = ["Int", "Int"];
    const UP: &[(&str, &str)] = &[("IN1", "a"), ("IN2", "b"), ("IN3", "Int 4")];
    let system = |part: &'static str, pins: &'static [(&'static str, &'static str)]| Boxed {
        part,
        name: "",
        types: VALUE,
        pins,
        out: "OUT",
    };
    gives(&system("MIN", UP), int, "Int", &[([3, 9], [3, 1]), ([30, 9], [4, 1])]);
    gives(&system("MAX", UP), int, "Int", &[([3, 9], [9, 1]), ([3, -9], [4, 1])]);
    gives(
        &system("LIMIT", &[("MN", "Int 2"), ("IN", "a"), ("MX", "b")]),
        int,
        "Int",
        &[([1, 5], [2, 1]), ([9, 5], [5, 1]), ([3, 5], [3, 1]), ([3, 1], [3, 0])],
    );
    let named = system("Limit", &[("min", "Int 2"), ("in", "a"), ("max", "b")]);
    gives(&named, int, "Int", &[([1, 5], [2, 1]), ([9, 5], [5, 1])]);
    gives(
        &system("SEL", &[("G", "a"), ("IN0", "b"), ("IN1", "Int 8")]),
        ["Bool", "Int"],
        "Int",
        &[([0, 5], [5, 1]), ([1, 5], [8, 1])],
    );
    let mux = |pins| Boxed { part: "Mux", name: "", types: INT, pins, out: "out" };
    let with_else = mux(&[("k", "a"), ("in0", "b"), ("in1", "Int 20"), ("else", "Int -1")]);
    gives(&with_else, int, "Int", &[([0, 5], [5, 1]), ([1, 5], [20, 1]), ([2, 5], [-1, 0]), ([-1, 5], [-1, 0])]);
}

/// "DEMUX: Demultiplex": the other outputs keep their values; if K matches no output, ELSE receives the value and ENO
/// is FALSE. One output is unconnected here.
#[test]
fn the_selected_output_alone_is_written() {
    let sections: Sections = &[
        ("Input", "k : Int; v : Int; en : Bool"),
        ("Output", "zero : Int; one : Int; other : Int := -1; ok : Bool; sure : Bool"),
    ];
    let mut net = Net::new("");
    let flow = contact(&mut net, "en");
    let inner = of_type("SrcType", "Int") + "<TemplateValue Name=\"Card\" Type=\"Cardinality\">3</TemplateValue>";
    for (part, ok) in [("Demux", "ok"), ("Demux DisabledENO=\"true\"", "sure")] {
        let demux = net.part(part, &inner, &[("en", flow.clone()), ("k", local("k")), ("in", local("v"))]);
        for (pin, target) in [("out0", "zero"), ("out1", "one"), ("else", "other")] {
            net.write(demux, pin, local(target));
        }
        coil(&mut net, ok, From::Pin(demux, "eno"));
    }
    let pins = "k := #k, in := #v, out0 => #zero, out1 => #one, out2 =>, else => #other";
    let int = "S7_Templates := \"SrcType := Int\"";
    let rungs = format!(
        "RUNG wire#powerrail Contact( #en ) wire#w1 {{ {int}; S7_GenerateENO := \"TRUE\" }} Demux( {pins} ) Coil( #ok ) END_RUNG
         RUNG wire#w1 {{ {int} }} Demux( {pins} ) Coil( #sure ) END_RUNG"
    );
    tape(
        both(sections, vec![net], &[&rungs], ""),
        ["k", "v", "en"],
        ["zero", "one", "other", "ok", "sure"],
        &[
            ([0, 5, 1], [5, 0, -1, 1, 1]),
            ([1, 6, 1], [5, 6, -1, 1, 1]),
            ([2, 7, 1], [5, 6, -1, 1, 1]),
            ([3, 8, 1], [5, 6, 8, 0, 1]),
            ([-1, 9, 1], [5, 6, 9, 0, 1]),
            ([0, 10, 0], [5, 6, 9, 0, 0]),
        ],
    );
}

/// "SHL", "SHR", "ROL", "ROR", "AND", "OR", "XOR", "INV", "DECO", "ENCO", "SWAP".
#[test]
fn words() {
    let word = ["Word", "Int"];
    const SHIFT: &[(&str, &str)] = &[("in", "a"), ("n", "b")];
    gives(&of("Shl", WORD, SHIFT), word, "Word", &[([0x8001, 1], [2, 1]), ([0x8001, 16], [0, 1])]);
    gives(&of("Shr", WORD, SHIFT), word, "Word", &[([0x8001, 1], [0x4000, 1]), ([0x8001, 20], [0, 1])]);
    // A signed number is sign-extended.
    gives(&of("Shr", INT, SHIFT), ["Int", "Int"], "Int", &[([-8, 1], [-4, 1]), ([-8, 20], [-1, 1])]);
    gives(&of("Rol", WORD, SHIFT), word, "Word", &[([0x8001, 1], [3, 1]), ([0x8001, 17], [3, 1])]);
    gives(&of("Ror", WORD, SHIFT), word, "Word", &[([0x8001, 1], [0xc000, 1])]);
    const THREE: &[(&str, &str)] = &[("in1", "a"), ("in2", "b"), ("in3", "w")];
    let words = ["Word", "Word"];
    gives(&of("And", WORD, THREE), words, "Word", &[([0xff, 0x7], [0x5, 1])]);
    gives(&of("Or", WORD, THREE), words, "Word", &[([0x100, 0x2], [0x10f, 1])]);
    gives(&of("Xor", WORD, THREE), words, "Word", &[([0xff, 0x7], [0xf5, 1])]);
    gives(
        &Boxed { part: "Inv", name: "", types: WORD, pins: ONE, out: "out" },
        words,
        "Word",
        &[([1, 0], [0xfffe, 1])],
    );
    gives(&of("Swap", WORD, ONE), words, "Word", &[([0x1234, 0], [0x3412, 1])]);
    const DECO: &[(&str, &str)] = &[("DestType", "Word")];
    gives(&of("Deco", DECO, ONE), ["UInt", "Int"], "Word", &[([3, 0], [8, 1]), ([17, 0], [2, 1])]);
    gives(&of("Enco", WORD, ONE), ["Word", "Int"], "Int", &[([0x28, 0], [3, 1])]);
}

/// "CALCULATE": computed in the type of the box; ENO reports an intermediate overflow.
#[test]
fn an_expression() {
    let sections: Sections = &[("Input", "a : Int; b : Int"), ("Output", "y : Int; ok : Bool; z : Int; sure : Bool")];
    let mut net = Net::new("");
    let inner = of_type("SrcType", "Int") + "<Equation>OUT := (IN1 + IN2) / IN3 - -IN1</Equation>";
    for (part, output, coil_of) in [("Calc", "y", "ok"), ("Calc DisabledENO=\"true\"", "z", "sure")] {
        let pins = [("en", From::Rail), ("IN1", local("a")), ("IN2", local("b")), ("IN3", int(2))];
        let calculated = net.part(part, &inner, &pins);
        net.write(calculated, "OUT", local(output));
        coil(&mut net, coil_of, From::Pin(calculated, "eno"));
    }
    let expression = "S7_Templates := \"SrcType := Int\"; S7_Expression := \"(in1 + in2) / in3 - -in1\"";
    let pins = "in1 := #a, in2 := #b, in3 := 2";
    let rungs = format!(
        "RUNG wire#powerrail {{ {expression}; S7_GenerateENO := \"TRUE\" }} Calculate( {pins}, out => #y ) Coil( #ok ) END_RUNG
         RUNG wire#powerrail {{ {expression} }} Calculate( {pins}, out => #z ) Coil( #sure ) END_RUNG"
    );
    let rows = [
        ([3, 5], [7, 1, 7, 1]),
        // 32767 + 1 = -32768; / 2 = -16384; + 32767 = 16383.
        ([32767, 1], [16383, 0, 16383, 1]),
        // -32768 / 2 = -16384; - -(-32768) = - -32768, which is -32768: the sum wraps to 16384.
        ([-32768, 0], [16384, 0, 16384, 1]),
    ];
    tape(both(sections, vec![net], &[&rungs], ""), ["a", "b"], ["y", "ok", "z", "sure"], &rows);
}

/// "INC: Increment", "DEC: Decrement".
#[test]
fn steps() {
    let sections: Sections =
        &[("Input", "f : Bool"), ("Output", "n : Int := 32766; k : USInt := 1; up : Bool; down : Bool")];
    let mut net = Net::new("");
    let flow = contact(&mut net, "f");
    let inc = net.part("Inc", &of_type("DestType", "Int"), &[("en", flow.clone()), ("operand", local("n"))]);
    coil(&mut net, "up", From::Pin(inc, "eno"));
    let dec = net.part("Dec", &of_type("DestType", "USInt"), &[("en", flow), ("operand", local("k"))]);
    coil(&mut net, "down", From::Pin(dec, "eno"));
    let rungs = "RUNG wire#powerrail Contact( #f ) wire#w1 { S7_Templates := \"DestType := Int\"; S7_GenerateENO := \"TRUE\" }
        Inc( #n ) Coil( #up ) END_RUNG
        RUNG wire#w1 { S7_Templates := \"DestType := USInt\"; S7_GenerateENO := \"TRUE\" } Dec( in_out := #k ) Coil( #down ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["f"],
        ["n", "up", "k", "down"],
        &[([0], [32766, 0, 1, 0]), ([1], [32767, 1, 0, 1]), ([1], [-32768, 0, 255, 0])],
    );
}

/// "MOVE: Move value", "Addressing array elements", "Slice access": structures, several outputs, an index that is
/// itself an element.
#[test]
fn variables() {
    let sections: Sections = &[
        ("Input", "i : Int"),
        ("Output", "y : Int; z : Int; bit : Bool; byte : Byte"),
        (
            "Static",
            "list : Array[0..3] of Int; at : Array[0..3] of Int; w : Word := 16#A500; p : \"Point\"; q : \"Point\"; o : \"Point\"",
        ),
    ];
    let point = "TYPE \"Point\"\nSTRUCT x : Int := 6; n : Int; END_STRUCT;\nEND_TYPE\n";
    let mut net = Net::new("");
    for (from, to) in [(xml::int(3), "at[i]"), (xml::int(44), "list[at[i]]"), (local("list[at[i]]"), "y")] {
        let copy = net.part("Move", "", &[("en", From::Rail), ("in", from)]);
        net.write(copy, "out1", local(to));
    }
    let copy = net.part("Move", "", &[("en", From::Rail), ("in", local("p"))]);
    net.write(copy, "out1", local("q"));
    net.write(copy, "out2", local("o"));
    let copy = net.part("Move", "", &[("en", From::Rail), ("in", local("o.x"))]);
    net.write(copy, "out1", local("z"));
    let flow = contact(&mut net, "w%X8");
    coil(&mut net, "bit", flow);
    let copy = net.part("Move", "", &[("en", From::Rail), ("in", local("w%B1"))]);
    net.write(copy, "out1", local("byte"));
    let rungs = "RUNG wire#powerrail Move( in := 3, out1 => #at[#i] ) Move( in := 44, out1 => #list[#at[#i]] )
        Move( in := #list[#at[#i]], out1 => #y ) Move( in := #p, out1 => #q, out2 => #o ) Move( in := #o.x, out1 => #z ) END_RUNG
        RUNG wire#powerrail Contact( #w.%X8 ) Coil( #bit ) END_RUNG
        RUNG wire#powerrail Move( in := #w.%B1, out1 => #byte ) END_RUNG";
    for (format, mut ran) in both(sections, vec![net], &[rungs], point) {
        ran.set("i", 2).call();
        let found = ["at[2]", "list[3]", "y", "z", "q.x", "bit", "byte"].map(|name| ran.get(name));
        assert_eq!(found, [3, 44, 44, 6, 6, 1, 0xa5], "{format}");
    }
}
