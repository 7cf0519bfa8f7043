//! The order in which elements take effect.

use super::Ran;
use super::formats::both;
use super::xml::{From, Net, int, local, typed};

const BOOLS: &[(&str, &str)] =
    &[("Input", "a : Bool; b : Bool"), ("Output", "x : Bool; y : Bool"), ("Static", "m : Bool")];

/// TIA Portal's help on networks: "from top to bottom and from left to right". A contact below reads what a coil above
/// writes.
#[test]
fn a_contact_after_a_coil_reads_its_new_value_one_before_it_the_old_one() {
    let mut net = Net::new("order");
    let early = net.part("Contact", "", &[("in", From::Rail), ("operand", local("m"))]);
    let a = net.part("Contact", "", &[("in", From::Rail), ("operand", local("a"))]);
    net.part("Coil", "", &[("in", From::Pin(a, "out")), ("operand", local("m"))]);
    net.part("Coil", "", &[("in", From::Pin(early, "out")), ("operand", local("x"))]);
    let late = net.part("Contact", "", &[("in", From::Rail), ("operand", local("m"))]);
    net.part("Coil", "", &[("in", From::Pin(late, "out")), ("operand", local("y"))]);
    let mut ran = Ran::of(BOOLS, vec![net]);
    ran.set("a", 1).call();
    assert_eq!((ran.get("x"), ran.get("y")), (0, 1));
    ran.set("a", 0).call();
    assert_eq!((ran.get("x"), ran.get("y")), (1, 0));
}

const NUMBERS: &[(&str, &str)] = &[("Output", "x : Bool"), ("Static", "n : Int := 1")];
const ADD: &str = "{ S7_Templates := \"SrcType := Int\" } Add( in1 := #n, in2 := 1, out => #n )";
const MUL: &str = "{ S7_Templates := \"SrcType := Int\" } Mul( in1 := #n, in2 := 2, out => #n )";

/// Adds n + 1 and n * 2, in this drawing order, as boxes with these UIds.
fn sum_and_product(net: &mut Net, sum: u32, product: u32) {
    for (uid, name, by) in [(sum, "Add", 1), (product, "Mul", 2)] {
        let of = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Int</TemplateValue>";
        net.part_at(uid, name, of, &[("en", From::Rail), ("in1", local("n")), ("in2", int(by))]);
        net.write(uid, "out", local("n"));
    }
}

/// The specification's order is "by UId of the coil or box": a junction is neither, and SIMATIC SD has no element for
/// it. The product therefore waits for its turn, although a junction with a lower UId needs it: (1 + 1) * 2, not 1 * 2
/// + 1.
#[test]
fn a_box_comes_no_earlier_because_a_junction_needs_it() {
    let mut net = Net::new("junction");
    let [junction, sum, product] = [(); 3].map(|()| net.next());
    let card = "<TemplateValue Name=\"Card\" Type=\"Cardinality\">2</TemplateValue>";
    let wires = [("in1", From::Pin(sum, "eno")), ("in2", From::Pin(product, "eno"))];
    net.part_at(junction, "O", card, &wires);
    sum_and_product(&mut net, sum, product);
    net.part("Coil", "", &[("in", From::Pin(junction, "out")), ("operand", local("x"))]);
    let rungs = format!(
        "RUNG wire#powerrail {ADD} END_RUNG wire#j\nRUNG wire#powerrail {MUL} END_RUNG wire#j\nRUNG wire#j Coil( #x ) END_RUNG"
    );
    for (format, mut ran) in both(NUMBERS, vec![net], &[&rungs], "") {
        assert_eq!(ran.call().get("n"), 4, "{format}");
    }
}

/// In FBD an OR gate has TRUE where a junction has the power rail. The order is the same: (1 + 1) * 2.
#[test]
fn a_constant_at_a_gate_makes_no_box_come_earlier() {
    let mut net = Net::new("gate");
    let [gate, sum, product] = [(); 3].map(|()| net.next());
    let card = "<TemplateValue Name=\"Card\" Type=\"Cardinality\">2</TemplateValue>";
    net.part_at(gate, "O", card, &[("in1", From::Pin(product, "eno")), ("in2", typed("BOOL#TRUE"))]);
    sum_and_product(&mut net, sum, product);
    net.part("Coil", "", &[("in", From::Pin(gate, "out")), ("operand", local("x"))]);
    assert_eq!(Ran::of(NUMBERS, vec![net]).call().get("n"), 4);
}

/// The same order holds for the inputs of one element: a flip-flop precedes both boxes, and its second pin leads to the
/// first.
#[test]
fn what_an_element_needs_keeps_its_order_whichever_pins_ask() {
    let mut net = Net::new("pins");
    let [flip_flop, sum, product] = [(); 3].map(|()| net.next());
    let wires = [("s", From::Pin(product, "eno")), ("r1", From::Pin(sum, "eno")), ("operand", local("x"))];
    net.part_at(flip_flop, "Sr", "", &wires);
    sum_and_product(&mut net, sum, product);
    let rungs = format!(
        "RUNG wire#product #x.S_SR( wire#sum ) END_RUNG\nRUNG wire#powerrail {ADD} END_RUNG wire#sum\n\
         RUNG wire#powerrail {MUL} END_RUNG wire#product"
    );
    for (format, mut ran) in both(NUMBERS, vec![net], &[&rungs], "") {
        assert_eq!(ran.call().get("n"), 4, "{format}");
    }
}
