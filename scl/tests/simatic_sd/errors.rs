//! Errors in a network name the block, the network, the element, the line and the column.

use super::{compiled, pair};

/// Returns the errors of rungs, without the file name.
fn errors(rungs: &str) -> String {
    let networks = format!(
        "    {{ S7_Language := \"LAD\"; S7_NetworkTitle := \"Start\" }}\n    NETWORK\n{rungs}\n    END_NETWORK"
    );
    let (document, _) = pair("VAR t : TON_TIME; m : Bool; END_VAR", &networks, "");
    compiled(&[("B.s7dcl", &document)]).err().unwrap_or_default()
}

#[test]
fn errors_of_networks_name_the_place() {
    for (rungs, expected) in [
        (
            "RUNG wire#powerrail Contact( #none ) Coil( #y ) END_RUNG",
            "B.s7dcl:8:30: FB B, network 1 \"Start\": Contact #none: #none is not declared in this block",
        ),
        (
            "RUNG wire#w1 Coil( #y ) END_RUNG",
            "B.s7dcl:8:6: FB B, network 1 \"Start\": nothing leads to wire#w1; end a rung with END_RUNG and this wire, or write it after an element",
        ),
        (
            "RUNG wire#w1 wire#w2 Coil( #y ) END_RUNG RUNG wire#w2 END_RUNG wire#w1",
            "B.s7dcl:8:47: FB B, network 1 \"Start\": wire#w2 leads to itself; put a variable in between",
        ),
        (
            "RUNG A( in2 := #a ) Coil( #y ) END_RUNG",
            "B.s7dcl:8:6: FB B, network 1 \"Start\": A: nothing is connected to in1; start the rung with an operand, or delete the rung",
        ),
        (
            "RUNG wire#powerrail Contact( NOT #a ) Coil( #y ) END_RUNG",
            "B.s7dcl:8:30: FB B, network 1 \"Start\": Contact ...: an operand cannot be negated with NOT; use I_Contact or I_Coil",
        ),
        (
            "RUNG wire#powerrail Contact( #a ) Switch( k := #i, EQ 3 => one, else => two ) END_RUNG",
            "B.s7dcl:8:35: FB B, network 1 \"Start\": Switch is not supported; use contacts to compare and JumpCoil to jump",
        ),
        (
            "RUNG wire#powerrail Contact( #a, #b ) Coil( #y ) END_RUNG",
            "B.s7dcl:8:34: FB B, network 1 \"Start\": Contact #a: this pin has no name; write PIN := before it",
        ),
        (
            "RUNG wire#powerrail Contact( #a )\nCoil( #y END_RUNG",
            "B.s7dcl:9:10: FB B, network 1 \"Start\": expected `,` or `)`, found `END_RUNG`",
        ),
        (
            "RUNG wire#powerrail Contact( #a ) Coil( #y )",
            "B.s7dcl:9:5: FB B, network 1 \"Start\": expected END_RUNG, found `END_NETWORK`",
        ),
        (
            "RUNG wire#powerrail Contact( #a ) #m.S_SR( r1 := #r, s := #b ) END_RUNG",
            "B.s7dcl:8:35: FB B, network 1 \"Start\": S_SR #m: both power flow and a value are connected to s; remove one of them",
        ),
        (
            "RUNG Coil( #y ) END_RUNG",
            "B.s7dcl:8:6: FB B, network 1 \"Start\": Coil #y: nothing is connected to in; start the rung with an operand, or delete the rung",
        ),
    ] {
        let found = errors(rungs);
        assert!(found.starts_with(expected), "{rungs}\n{found}");
    }
}

#[test]
fn what_is_no_instruction_is_named() {
    let found = errors("RUNG wire#powerrail Contact( #a ) Blink( in := #a ) END_RUNG");
    let expected = "B.s7dcl:8:35: FB B, network 1 \"Start\": Blink #Blink: no source declares the function \"Blink\"";
    assert!(found.starts_with(expected), "{found}");
    let found = errors("RUNG wire#powerrail #m.Blink( in := #a ) END_RUNG");
    assert!(found.starts_with("B.s7dcl:8:"), "{found}");
    let found = errors("RUNG wire#powerrail Frobnicate_Coil( #a ) END_RUNG");
    assert!(found.contains("Frobnicate_Coil"), "{found}");
}
