//! In which order elements take effect.

use super::Ran;
use super::xml::{From, Net, local};

const BOOLS: &[(&str, &str)] =
    &[("Input", "a : Bool; b : Bool"), ("Output", "x : Bool; y : Bool"), ("Static", "m : Bool")];

/// TIA Portal's help on networks: "from top to bottom and from left to right". A coil above writes what a contact below reads.
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
