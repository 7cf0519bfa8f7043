//! Unsupported elements and drawing errors: an error with block, network, element and line.

use super::{Sections, document};
use crate::compiled;
use crate::xml::{self, From, Net, int, local};

/// Returns the first error of a network with one element, without its file, and the line that it names.
fn error(name: &str, text: String) -> (String, String) {
    let errors = compiled(&[(name, text.clone())]).unwrap_err();
    let problem = &errors[0].problems[0];
    let line = problem.place.as_ref().map_or(0, |place| place.line);
    (problem.message.clone(), text.lines().nth(line.saturating_sub(1)).unwrap_or_default().to_string())
}

/// A part, its content, the sources of its pins, the output pin, and the message.
type Case<'a> = (&'a str, String, Vec<(&'a str, From)>, &'a str, &'a str);

const SECTIONS: Sections = &[("Input", "a : Bool; n : Int"), ("Output", "y : Bool; k : Int"), ("Static", "w : Word")];

#[test]
fn elements_that_are_not_read_are_named() {
    for (part, written) in [
        ("JumpList", "JumpList( k := #n, dest0 => one )"),
        ("Switch", "Switch( k := #n, EQ 3 => one, else => two )"),
        ("SdCoil", "SD_Coil( #w, S5T#2s )"),
        ("SpCoil", "SP_Coil( #w, S5T#2s )"),
        ("S_ODT", "S_ODT( s := #a )"),
        ("CuCoil", "CU_Coil( #w )"),
        ("S_CU", "S_CU( cu := #a )"),
        ("McrA", "McrA()"),
        ("Save", "Save()"),
    ] {
        let mut net = Net::new("Old");
        net.part(part, "", &[("en", From::Rail)]);
        let (message, line) = error("b.xml", xml::block("FB", "B", SECTIONS, vec![net], "LAD"));
        assert_eq!(message, format!("FB B, network 1 \"Old\": {part}: {part} is not supported"));
        assert!(line.contains(part), "{line}");
        let (message, line) =
            error("b.s7dcl", document(SECTIONS, &[&format!("RUNG wire#powerrail\n{written} END_RUNG")]));
        let name = written.split('(').next().unwrap();
        assert!(
            message.starts_with("FB B, network 1: ") && message.ends_with(&format!("{name} is not supported")),
            "{message}"
        );
        assert!(line.contains(name), "{line}");
    }
}

#[test]
fn pins_that_an_element_does_not_have_and_inputs_that_are_open_are_told() {
    let card = |count: &str| format!("<TemplateValue Name=\"Card\" Type=\"Cardinality\">{count}</TemplateValue>");
    let bools = || vec![("in1", local("a")), ("in2", local("a"))];
    let cases: Vec<Case<'_>> = vec![
        ("A", card("3"), bools(), "out", "A: A has 3 inputs, but only 2 are wired"),
        (
            "O",
            card("99999999999999999999"),
            bools(),
            "out",
            "O: O: `99999999999999999999` is not a valid number of inputs",
        ),
        ("O", card("4000000000"), bools(), "out", "O: O has 4000000000 inputs, but only 2 are wired"),
        ("A", String::new(), vec![("in1", local("a")), ("operand", local("a"))], "q", "A #a: A has no pin q"),
        ("Add", String::new(), vec![("in1", int(1)), ("in2", int(2)), ("x", int(3))], "out", "Add: Add has no pin x"),
        ("Add", String::new(), vec![("in1", int(1)), ("in2", int(2))], "sum", "Add: Add has no pin sum"),
        ("Add", String::new(), vec![("in1", int(1))], "out", "Add: Add has fewer than two inputs"),
        ("Move", String::new(), vec![], "out1", "Move: Move has no in"),
        ("Gt", String::new(), vec![("in1", int(1))], "out", "Gt: Gt has no in2"),
        ("TON", String::new(), vec![("IN", local("a"))], "Q", "TON: TON has no instance"),
        (
            "Coil",
            String::new(),
            vec![("operand", local("y"))],
            "out",
            "Coil #y: Coil has no power flow: its input is not connected",
        ),
        (
            "SBitfield",
            String::new(),
            vec![("en", local("a")), ("operand", local("y")), ("n", int(2))],
            "eno",
            "SBitfield #y: SBitfield: the operand is neither an element of an array of Bool nor a bit of a word",
        ),
        (
            "SBitfield",
            String::new(),
            vec![("en", local("a")), ("operand", local("w%X0")), ("n", int(0))],
            "eno",
            "SBitfield #w.%X0: SBitfield: 0 is not a valid number of bits",
        ),
        (
            "SCoil",
            "<Negated Name=\"operand\" />".to_string(),
            vec![("in", local("a")), ("operand", local("y"))],
            "out",
            "SCoil #y: SCoil has a negated operand",
        ),
    ];
    for (part, inner, pins, output, expected) in cases {
        let mut net = Net::new("");
        let uid = net.part(part, &inner, &pins);
        net.write(
            uid,
            output,
            local(if matches!(part, "A" | "O" | "SBitfield" | "SCoil" | "Coil") { "y" } else { "k" }),
        );
        let (message, line) = error("b.xml", xml::block("FB", "B", SECTIONS, vec![net], "FBD"));
        assert_eq!(message, format!("FB B, network 1: {expected}"));
        assert!(line.contains(&format!("<Part Name=\"{part}\"")), "{line}");
    }
}

/// No wire can carry the value of a DEMUX output while another one is selected.
#[test]
fn an_output_of_demux_that_leads_to_an_element_is_told() {
    let mut net = Net::new("");
    let demux = net.part("Demux", "", &[("en", From::Rail), ("k", local("n")), ("in", local("n"))]);
    let copy = net.part("Move", "", &[("en", From::Rail), ("in", From::Pin(demux, "out0"))]);
    net.write(copy, "out1", local("k"));
    let (message, line) = error("b.xml", xml::block("FB", "B", SECTIONS, vec![net], "LAD"));
    assert_eq!(message, "FB B, network 1: Demux: Demux: out0 is wired to another element");
    assert!(line.contains("Demux"), "{line}");
}

#[test]
fn parts_without_a_number_of_their_own_are_told() {
    let of = |from: &str, to: &str| {
        let mut net = Net::new("");
        net.part_at(77, "Contact", "", &[("in", From::Rail), ("operand", local("a"))]);
        net.part_at(78, "Coil", "", &[("in", From::Pin(77, "out")), ("operand", local("y"))]);
        error("b.xml", xml::block("FB", "B", SECTIONS, vec![net], "LAD").replace(from, to)).0
    };
    assert_eq!(
        of("Name=\"Coil\" UId=\"78\"", "Name=\"Coil\" UId=\"77\""),
        "FB B, network 1: two parts of the network share the UId `77`"
    );
    assert_eq!(of("Name=\"Coil\" UId=\"78\"", "Name=\"Coil\""), "FB B, network 1: a part has no UId");
    assert_eq!(
        of("LocalVariable", "Statusword"),
        "FB B, network 1: Contact 0: an operand of scope Statusword is not supported"
    );
}
