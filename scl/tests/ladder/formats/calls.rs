//! Calls of blocks: outputs on wires, negated and unconnected ones, in-outs.

use super::{Sections, both, coil, contact, document, instance, tape};
use crate::xml::{self, From, Net, local};
use crate::{Ran, compiled};

const OTHERS: &str = "FUNCTION_BLOCK \"Motor\"\nVAR_INPUT start : BOOL; END_VAR\nVAR_OUTPUT run : BOOL; END_VAR\nBEGIN\n\
                      #run := #start;\nEND_FUNCTION_BLOCK\n\
                      FUNCTION \"Split\" : INT\nVAR_INPUT x : INT; END_VAR\nVAR_OUTPUT half : INT; odd : BOOL; name : STRING[4]; END_VAR\n\
                      VAR_IN_OUT count : INT; END_VAR\nBEGIN\n#half := #x / 2; #odd := #x MOD 2 <> 0; #name := 'ab'; \
                      #count := #count + 1; #Split := #x * 2;\nEND_FUNCTION\n";

/// "Calling function blocks", "Calling functions": results on wires, at variables and unconnected.
#[test]
fn outputs_of_calls() {
    let sections: Sections = &[
        ("Input", "f : Bool; x : Int"),
        ("Output", "half : Int; twice : Int; big : Bool; even : Bool; still : Bool; count : Int"),
        ("Static", "m : \"Motor\""),
    ];
    let parameters = "<Parameter Name=\"x\" Section=\"Input\" Type=\"Int\" /><Parameter Name=\"count\" Section=\"InOut\" Type=\"Int\" />\
                      <Parameter Name=\"half\" Section=\"Output\" Type=\"Int\" /><Parameter Name=\"odd\" Section=\"Output\" Type=\"Bool\" />\
                      <Parameter Name=\"name\" Section=\"Output\" Type=\"String\" />\
                      <Parameter Name=\"Ret_Val\" Section=\"Return\" Type=\"Int\" />";
    let mut net = Net::new("");
    let flow = contact(&mut net, "f");
    let split = net.call("FC", "Split", parameters, &[("en", flow), ("x", local("x"))]);
    // The variable of an in-out at the output side, an unconnected output, and one with two targets.
    net.write(split, "count", local("count"));
    net.wire(From::Pin(split, "name"), "<OpenCon UId=\"900\" />");
    net.write(split, "half", local("half"));
    net.write(split, "Ret_Val", local("twice"));
    let int = super::of_type("SrcType", "Int");
    let more = net.part("Gt", &int, &[("pre", From::Rail), ("in1", From::Pin(split, "half")), ("in2", xml::int(5))]);
    coil(&mut net, "big", From::Pin(more, "out"));
    let odd = net.part("Not", "", &[("in", From::Pin(split, "odd"))]);
    coil(&mut net, "even", From::Pin(odd, "out"));
    let inner = instance("m", &mut net);
    let flow = contact(&mut net, "f");
    let motor = net.call("FB", "Motor", &inner, &[("en", From::Rail), ("start", flow)]);
    let run = net.part("Not", "", &[("in", From::Pin(motor, "run"))]);
    coil(&mut net, "still", From::Pin(run, "out"));
    let rungs = "RUNG wire#powerrail Contact( #f )
        \"Split\"( x := #x, count := #count, half => wire#w1, odd => wire#w2, name => , Ret_Val => #twice ) END_RUNG
        RUNG wire#powerrail { S7_Templates := \"SrcType := Int\" } Gt_Contact( in1 := wire#w1, in2 := 5 ) Coil( #big ) END_RUNG
        RUNG wire#powerrail Contact( #f ) Move( in := wire#w1, out1 => #half ) END_RUNG
        RUNG wire#w2 Not() Coil( #even ) END_RUNG
        RUNG wire#powerrail #m( start := #f, run => wire#w3 ) END_RUNG
        RUNG wire#w3 Not() Coil( #still ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], OTHERS),
        ["f", "x"],
        ["half", "twice", "big", "even", "still", "count"],
        &[([1, 13], [6, 26, 1, 0, 0, 1]), ([1, 4], [2, 8, 0, 1, 0, 2]), ([0, 99], [2, 8, 0, 1, 1, 2])],
    );
}

/// "Programming examples, inverting binary outputs": a negated output writes the inverted value to its variable.
#[test]
fn negated_outputs_of_calls() {
    let sections: Sections = &[
        ("Input", "a : Bool; x : Int"),
        ("Output", "y : Bool; z : Bool; w : Bool; half : Int"),
        ("Static", "m : \"Motor\"; n : Int"),
    ];
    let mut net = Net::new("");
    let inner = instance("m", &mut net);
    let motor = net.call("FB", "Motor", &inner, &[("start", local("a"))]);
    net.write(motor, "run", local("y"));
    let parameters = "<Parameter Name=\"count\" Section=\"InOut\" Type=\"Int\" />";
    let split = net.call("FC", "Split", parameters, &[("x", local("x")), ("count", local("n"))]);
    net.write(split, "odd", local("z"));
    net.write(split, "half", local("half"));
    net.wire(From::Pin(split, "name"), "<OpenCon UId=\"900\" />");
    coil(&mut net, "w", From::Pin(split, "odd"));
    let text = xml::block("FB", "B", sections, vec![net], "FBD");
    let text = text.replace("</CallInfo></Call>", "</CallInfo><Negated Name=\"run\" /><Negated Name=\"odd\" /></Call>");
    let mut ran = Ran::new(&[("b.xml", text), ("others.scl", OTHERS.to_string())]);
    for (a, x, all) in [(1, 3, [0, 0, 0, 1]), (0, 8, [1, 1, 1, 4])] {
        ran.set("a", a).set("x", x).call();
        assert_eq!(["y", "z", "w", "half"].map(|name| ran.get(name)), all);
    }
}

/// "Supplying block parameters": a function requires all its inputs.
#[test]
fn an_open_input_of_a_function_is_an_error() {
    let mut net = Net::new("Call");
    let split = net.call("FC", "Split", "", &[("en", From::Rail), ("count", local("n"))]);
    for pin in ["half", "odd", "name"] {
        net.wire(From::Pin(split, pin), "<OpenCon UId=\"900\" />");
    }
    let sections: Sections = &[("Static", "n : Int")];
    let rungs = "RUNG wire#powerrail \"Split\"( count := #n, half => , odd => , name => ) END_RUNG";
    for (name, text) in
        [("b.xml", xml::block("FB", "B", sections, vec![net], "LAD")), ("b.s7dcl", document(sections, &[rungs]))]
    {
        let errors = compiled(&[(name, text), ("others.scl", OTHERS.to_string())]).unwrap_err();
        let message = &errors[0].problems[0].message;
        assert!(message.starts_with("FB B, network 1") && message.ends_with("Split is called without x"), "{message}");
    }
}

/// The message concerns only the block, not the wires at its outputs.
#[test]
fn a_function_that_no_source_declares() {
    let mut net = Net::new("");
    let parameters = "<Parameter Name=\"x\" Section=\"Input\" Type=\"Int\" /><Parameter Name=\"odd\" Section=\"Output\" Type=\"Bool\" />";
    let call = net.call("FC", "Nowhere", parameters, &[("en", From::Rail), ("x", xml::int(1))]);
    coil(&mut net, "y", From::Pin(call, "odd"));
    let sections: Sections = &[("Output", "y : Bool")];
    let rungs = "RUNG wire#powerrail \"Nowhere\"( x := 1, odd => wire#w1 ) END_RUNG RUNG wire#w1 Coil( #y ) END_RUNG";
    for (name, text) in
        [("b.xml", xml::block("FB", "B", sections, vec![net], "LAD")), ("b.s7dcl", document(sections, &[rungs]))]
    {
        let errors = compiled(&[(name, text)]).unwrap_err();
        let messages: Vec<&str> = errors[0].problems.iter().map(|problem| problem.message.as_str()).collect();
        assert!(
            messages.len() == 1 && messages[0].contains("no source declares the function \"Nowhere\""),
            "{messages:?}"
        );
    }
}
