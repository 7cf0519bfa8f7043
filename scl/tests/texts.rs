//! Functions of texts.

use parameters::Source;
use scl::machine::{Code, Machine};
use scl::program::{Scalar, Type};
use scl::{Options, compile};
use std::sync::Arc;

/// Whether `y` is TRUE behind statements with the text `s` = 'Valve 7' and the character `c` = 'x'.
fn runs(statements: &str) -> bool {
    let source = format!(
        "FUNCTION_BLOCK \"B\" {{ S7_Optimized_Access := 'TRUE' }} VAR_OUTPUT y : Bool; n : DInt; END_VAR
        VAR s : String := 'Valve 7'; short : String[4]; c : Char := 'x'; END_VAR
        BEGIN #short := #s; {statements} END_FUNCTION_BLOCK"
    );
    let compiled = compile(&[Source::new("b.scl", source.into())], &Options::default());
    let compiled = compiled.unwrap_or_else(|errors| panic!("{statements}: {}", errors[0]));
    let root = compiled.root.unwrap();
    let mut machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
    machine.call(root.cycle, 0).unwrap();
    let Some((offset, Type::Scalar(Scalar::Bool))) = compiled.program.find(&format!("{}.y", root.instance)) else {
        panic!("y is no BOOL")
    };
    machine.get(Scalar::Bool, offset) == true.into()
}

/// Whether a condition holds.
fn holds(condition: &str) -> bool {
    runs(&format!("#y := {condition};"))
}

#[test]
fn a_text_in_the_condition_of_a_loop_is_calculated_in_each_run() {
    let shortened = "#s := MID(IN := #s, L := 99, P := 2); #n := #n + 1;";
    for loops in [
        format!("WHILE LEFT(IN := #s, L := 1) <> '7' DO {shortened} END_WHILE;"),
        format!("REPEAT {shortened} UNTIL LEFT(IN := #s, L := 1) = '7' END_REPEAT;"),
    ] {
        assert!(runs(&format!("{loops} #y := #n = 6 AND #s = '7';")), "{loops}");
    }
}

#[test]
fn parts_of_texts_are_taken_and_what_lies_outside_is_empty() {
    for condition in [
        "LEN(#s) = 7",
        "LEN(S := '') = 0",
        "MAX_LEN(#short) = 4",
        "LEFT(IN := #s, L := 5) = 'Valve'",
        "LEFT(IN := #s, L := 99) = 'Valve 7'",
        "LEFT(IN := #s, L := -1) = ''",
        "RIGHT(IN := #s, L := 1) = '7'",
        "RIGHT(IN := #s, L := 0) = ''",
        "MID(IN := #s, L := 2, P := 2) = 'al'",
        "MID(IN := #s, L := 99, P := 7) = '7'",
        "MID(IN := #s, L := 1, P := 8) = ''",
        "MID(IN := #s, L := 1, P := 0) = ''",
        "#short = 'Valv'",
    ] {
        assert!(holds(condition), "{condition}");
    }
    assert!(!holds("LEFT(IN := #s, L := 5) = 'Valva'"));
}

#[test]
fn texts_are_put_together_searched_and_changed() {
    for condition in [
        "CONCAT(IN1 := #s, IN2 := ' open') = 'Valve 7 open'",
        "CONCAT(IN1 := #s, IN2 := #c, IN3 := '!') = 'Valve 7x!'",
        "LEN(CONCAT(IN1 := #s, IN2 := CONCAT(IN1 := #s, IN2 := #s))) = 21",
        "FIND(IN1 := #s, IN2 := 've') = 4",
        "FIND(IN1 := #s, IN2 := 'open') = 0",
        "FIND(IN1 := #s, IN2 := '7') = 7",
        "DELETE(IN := #s, L := 2, P := 6) = 'Valve'",
        "DELETE(IN := #s, L := 99, P := 1) = ''",
        "INSERT(IN1 := #s, IN2 := 'X', P := 0) = 'XValve 7'",
        "INSERT(IN1 := #s, IN2 := 'X', P := 7) = 'Valve 7X'",
        "REPLACE(IN1 := #s, IN2 := 'Pump', L := 5, P := 1) = 'Pump 7'",
        "REPLACE(IN1 := #s, IN2 := '', L := 5, P := 1) = ' 7'",
    ] {
        assert!(holds(condition), "{condition}");
    }
}

#[test]
fn texts_of_both_kinds_are_compared_with_what_has_no_kind_and_not_with_each_other() {
    let of = |condition: &str| {
        let source = format!(
            "FUNCTION_BLOCK \"B\" VAR_OUTPUT y : Bool; END_VAR VAR w : WString := WSTRING#'abc'; s : String; END_VAR
            BEGIN y := {condition}; END_FUNCTION_BLOCK"
        );
        compile(&[Source::new("b.scl", source.into())], &Options::default())
    };
    for condition in ["w = 'abc'", "'abc' <= w", "s = 'abc'"] {
        assert!(Code::compile(&of(condition).unwrap().program).is_ok(), "{condition}");
    }
    let refused = of("w = s").unwrap_err()[0].to_string();
    assert!(refused.contains("WSTRING = STRING is not possible; a STRING is not compared with a WSTRING"), "{refused}");
}

#[test]
fn s_conv_converts_to_the_type_of_its_output() {
    assert!(runs("S_CONV(IN := '  42 kg', OUT => #n); #y := #n = 42;"));
    assert!(runs("#n := -7; S_CONV(IN := #n, OUT => #s); #y := #s = '         -7';"));
    assert!(runs("S_CONV(IN := 'Pump', OUT => #short); #y := #short = 'Pump';"));
}
