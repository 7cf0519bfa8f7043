//! `AT`: the bytes of a variable as a different type, as a CPU stores them.

use super::{compiled, runs};

const DECLARED: &str = "
    VAR
        dw : DWord; bytes AT dw : Array[0..3] of Byte; words AT dw : Array[1..2] of Word;
        bits AT dw : Array[0..31] of Bool; r AT dw : Real; first AT dw : Byte;
        s AT dw : Struct a : Bool; b : Bool; c : Byte; n : Int; END_STRUCT;
        raw : Array[0..5] of Byte; mixed AT raw : Struct small : SInt; large : DInt; END_STRUCT;
        text : String[5] := 'Pump'; chars AT text : Array[0..6] of Byte;
        head AT text : Struct most : Byte; length : Byte; letters : Array[1..5] of Char; END_STRUCT;
        w : Word; flags AT w : Struct b0, b1, b2, b3, b4, b5, b6, b7, b8 : Bool; END_STRUCT;
    END_VAR
    VAR_TEMP i : Int; n : Int; END_VAR";

fn source(statements: &str) -> String {
    format!(
        "FUNCTION_BLOCK \"B\" {{ S7_Optimized_Access := 'FALSE' }} VAR_OUTPUT y : Bool; END_VAR {DECLARED}
        BEGIN {statements} END_FUNCTION_BLOCK"
    )
}

/// Whether `y` is TRUE after the statements.
fn holds(statements: &str) -> bool {
    runs(&source(statements))
}

#[test]
fn the_highest_byte_of_a_number_comes_first() {
    for condition in [
        "#bytes[0] = 16#11 AND #bytes[1] = 16#22 AND #bytes[3] = 16#44",
        "#words[1] = 16#1122 AND #words[2] = 16#3344",
        "#first = 16#11",
        // Bit 0 of an array is the lowest bit of byte 0, which is the highest byte of the number: 16#11 has the bits 0
        // and 4.
        "#bits[0] AND NOT #bits[1] AND #bits[4] AND NOT #bits[8] AND #bits[9] AND #bits[13] AND #bits[26] AND NOT #bits[31]",
        // BOOLs share a byte, and an INT begins at the next even one.
        "#s.a AND NOT #s.b AND #s.c = 16#22 AND #s.n = 16#3344",
    ] {
        assert!(holds(&format!("#dw := 16#11223344; #y := {condition};")), "{condition}");
    }
    assert!(holds("#dw := 16#41200000; #y := #r = 10.0;"));
    assert!(holds("#w := 16#0100; #y := #flags.b0 AND NOT #flags.b8;"));
    assert!(holds("#w := 16#0001; #y := #flags.b8 AND NOT #flags.b0;"));
}

#[test]
fn what_is_written_to_a_view_is_written_to_the_variable_behind_it() {
    for (written, condition) in [
        ("#bytes[3] := 16#7F;", "#dw = 16#1122337F"),
        ("#words[1] := 0;", "#dw = 16#00003344"),
        ("#bits[8] := TRUE;", "#dw = 16#11233344"),
        ("#r := 1.0;", "#dw = 16#3F800000 AND #bytes[0] = 16#3F"),
        // The remaining bits of the variable are unchanged.
        ("#first := 16#55;", "#dw = 16#55223344"),
        ("#s.n := -2; #s.b := TRUE;", "#dw = 16#1322FFFE"),
        ("#bytes[2] += 1;", "#dw = 16#11223444"),
    ] {
        assert!(holds(&format!("#dw := 16#11223344; {written} #y := {condition};")), "{written}");
    }
    // A number of 4 bytes begins at an even byte.
    assert!(holds(
        "#mixed.small := -1; #mixed.large := 16#01020304;
        #y := #raw[0] = 16#FF AND #raw[1] = 0 AND #raw[2] = 1 AND #raw[5] = 4;"
    ));
}

#[test]
fn a_string_has_its_room_its_length_and_its_characters() {
    for (written, condition) in [
        ("", "#chars[0] = 5 AND #chars[1] = 4 AND #chars[2] = 16#50 AND #chars[5] = 16#70"),
        ("", "#head.most = 5 AND #head.length = 4 AND #head.letters[1] = 'P' AND #head.letters[4] = 'p'"),
        ("#head.length := 2;", "#text = 'Pu' AND LEN(#text) = 2"),
        ("#chars[2] := 16#4C;", "#text = 'Lump'"),
        ("#head.letters[5] := 's'; #head.length := 5;", "#text = 'Pumps'"),
        // Characters beyond the capacity of a text do not become part of it, and the capacity is unchanged.
        ("#head.length := 200; #head.letters[5] := 'x';", "LEN(#text) = 5 AND #text = 'Pumpx' AND #chars[1] = 5"),
        ("#chars[0] := 99;", "#chars[0] = 5 AND #text = 'Pump'"),
        ("FOR #i := 2 TO 5 DO #chars[#i] := #chars[#i] AND 16#DF; END_FOR;", "#text = 'PUMP'"),
    ] {
        assert!(holds(&format!("{written} #y := {condition};")), "{written} {condition}");
    }
}

#[test]
fn a_view_is_current_wherever_it_is_used() {
    assert!(holds(
        "#dw := 1; WHILE #bytes[3] < 9 DO #dw := #dw + 1; #n := #n + 1; END_WHILE; #y := #dw = 9 AND #n = 8;"
    ));
    assert!(holds("#dw := 1; REPEAT #dw := #dw + 1; UNTIL #bytes[3] = 5 END_REPEAT; #y := #dw = 5;"));
    assert!(holds("IF #dw <> 0 THEN ; ELSIF #bytes[0] = 0 THEN #bytes[0] := 1; END_IF; #y := #dw = 16#01000000;"));
    assert!(holds("FOR #i := 0 TO 3 DO #bytes[#i] := INT_TO_BYTE(#i + 1); END_FOR; #y := #dw = 16#01020304;"));
    assert!(holds("#dw := 16#02000000; CASE #bytes[0] OF 2: #y := TRUE; END_CASE;"));
}

#[test]
fn what_has_no_bytes_of_a_cpu_is_refused() {
    for (declared, message) in [
        ("s : WString; x AT s : Array[0..3] of Byte;", "a WSTRING cannot be viewed through AT"),
        (
            "a : Array[0..9] of Byte; x AT a : Struct n : Int; s : String[4]; END_STRUCT;",
            "a STRING, because a view has no length field, cannot be a view",
        ),
        ("s : String[9]; x AT s : Array[0..12] of Byte;", "the view has 14 bytes, but its variable has only 12"),
        ("a : Byte; x AT a : Word;", "the view has 2 bytes, but its variable has only 1"),
        ("a : Word; x AT b : Word;", "AT needs a variable of this block"),
        ("a : Word; x AT a : Byte; z AT x : Byte;", "AT needs a variable of this block"),
        ("a : LReal; x AT a : Array[0..1, 0..3] of Byte;", "a multidimensional array"),
        ("a : Array[0..9999] of Byte; x AT a : Array[0..9999] of Byte;", "a variable with more than 4096 numbers"),
    ] {
        let text = format!("FUNCTION_BLOCK \"B\" VAR {declared} END_VAR BEGIN ; END_FUNCTION_BLOCK");
        let errors = compiled(&text).unwrap_err();
        assert!(errors[0].to_string().contains(message), "{declared}: {}", errors[0]);
    }
    let errors = compiled(&source("FOR #first := 0 TO 3 DO ; END_FOR;")).unwrap_err();
    assert!(errors[0].to_string().contains("a loop variable cannot be a view"), "{}", errors[0]);
}
