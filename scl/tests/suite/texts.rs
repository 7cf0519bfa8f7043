//! Text functions.

use super::{Ran, compiled};

/// Whether `y` is TRUE after statements with the text `s` = 'Valve 7' and the character `c` = 'x'.
fn runs(statements: &str) -> bool {
    super::runs(&format!(
        "FUNCTION_BLOCK \"B\" {{ S7_Optimized_Access := 'TRUE' }} VAR_OUTPUT y : Bool; n : DInt; END_VAR
        VAR s : String := 'Valve 7'; short : String[4]; c : Char := 'x'; w : WString := WSTRING#'Größe €'; wc : WChar;
            i : Int; u : UInt; ul : ULInt; r : Real; bytes : Array[3..7] of Byte; chars : Array[0..9] of WChar;
            words : Array[0..9] of Word; END_VAR
        BEGIN #short := #s; {statements} END_FUNCTION_BLOCK"
    ))
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
        compiled(&format!(
            "FUNCTION_BLOCK \"B\" VAR_OUTPUT y : Bool; END_VAR VAR w : WString := WSTRING#'abc'; s : String; END_VAR
            BEGIN y := {condition}; END_FUNCTION_BLOCK"
        ))
    };
    for condition in ["w = 'abc'", "'abc' <= w", "s = 'abc'"] {
        Ran::new(of(condition).unwrap_or_else(|errors| panic!("{condition}: {}", errors[0])));
    }
    let refused = of("w = s").unwrap_err()[0].to_string();
    assert!(
        refused.contains("= cannot be applied to WSTRING and STRING; a STRING cannot be compared with a WSTRING"),
        "{refused}"
    );
}

#[test]
fn s_conv_converts_to_the_type_of_its_output() {
    assert!(runs("S_CONV(IN := '  42 kg', OUT => #n); #y := #n = 42;"));
    assert!(runs("#n := -7; S_CONV(IN := #n, OUT => #s); #y := #s = '         -7';"));
    assert!(runs("S_CONV(IN := 'Pump', OUT => #short); #y := #short = 'Pump';"));
}

#[test]
fn val_strg_writes_a_number_into_a_text() {
    // The examples of the system manual of the S7-1200: a field of 10 characters from position 16 on, between 14 blanks.
    let of = |declared: &str, size: i32, prec: i32, format: i32| {
        format!(
            "#s := 'Current Temp = xxxxxxxxxx C';
            VAL_STRG(IN := {declared}, SIZE := {size}, PREC := {prec}, FORMAT := {format}, P := 16, OUT => #s);"
        )
    };
    for (value, prec, format, field) in [
        ("UINT#123", 0, 0, "       123"),
        ("UINT#0", 2, 0, "      0.00"),
        ("UDINT#12345678", 3, 0, " 12345.678"),
        ("UDINT#12345678", 3, 1, " 12345,678"),
        ("INT#123", 3, 4, "    +0.123"),
        ("INT#-123", 0, 0, "      -123"),
        ("REAL#-0.00123", 4, 4, "   -0.0012"),
        ("REAL#-0.00123", 4, 6, "-1.2300E-3"),
        ("LINT#-9223372036854775808", 10, 0, "xxxxxxxxxx"),
        ("REAL#2.5", 1, 0, "       2.5"),
        ("REAL#99.96", 1, 0, "     100.0"),
        ("REAL#99.96", 1, 2, "    1.0E+2"),
        ("REAL#1.0E30", 1, 0, "xxxxxxxxxx"),
    ] {
        let check = format!("#y := #s = 'Current Temp = {field} C';");
        assert!(runs(&(of(value, 10, prec, format) + &check)), "{value}, {prec}, {format}: {field}");
    }
    // A shorter text is padded with blanks.
    assert!(runs(
        "#s := 'a'; VAL_STRG(IN := 5, SIZE := 2, PREC := 0, FORMAT := 0, P := 4, OUT => #s); #y := #s = 'a   5';"
    ));
}

#[test]
fn strg_val_reads_a_number_of_a_text() {
    for (text, format, position, read) in [
        ("123", 0, 1, 123.0),
        ("-00456", 0, 1, -456.0),
        ("+2345", 0, 1, 2345.0),
        ("00123AbC", 0, 1, 123.0),
        ("AbC", 0, 1, 0.0),
        ("T = 12.5 C", 0, 5, 12.5),
        ("1.25e-2", 0, 1, 1.25),
        ("1.25e-2", 2, 1, 0.0125),
        ("1,234.5", 0, 1, 1234.5),
        ("1.234,5", 1, 1, 1234.5),
        ("1-2", 0, 1, 1.0),
    ] {
        let read = format!(
            "STRG_VAL(IN := '{text}', FORMAT := {format}, P := {position}, OUT => #r); #y := #r = REAL#{read:?};"
        );
        assert!(runs(&read), "{read}");
    }
    assert!(runs("STRG_VAL(IN := '12.7', FORMAT := 0, P := 1, OUT => #i); #y := #i = 12;"));
    assert!(runs("#i := 5; STRG_VAL(IN := '70000', FORMAT := 0, P := 1, OUT => #i); #y := #i = 0;"));
}

#[test]
fn texts_are_moved_to_arrays_and_back() {
    assert!(runs(
        "Strg_TO_Chars(Strg := #s, pChars := 1, Cnt => #u, Chars := #bytes);
        #y := #u = 4 AND #bytes[3] = 0 AND #bytes[4] = 16#56 AND #bytes[7] = 16#76;"
    ));
    assert!(runs(
        "Strg_TO_Chars(Strg := #s, pChars := 0, Cnt => #u, Chars := #bytes);
        Chars_TO_Strg(Chars := #bytes, pChars := 1, Cnt := 3, Strg => #s); #y := #s = 'alv';"
    ));
    // Up to the first NUL character.
    assert!(runs(
        "Strg_TO_Chars(Strg := #w, pChars := 0, Cnt => #u, Chars := #chars); #chars[3] := WORD_TO_WCHAR(0);
        Chars_TO_Strg(Chars := #chars, pChars := 0, Cnt := 0, Strg => #w); #y := #u = 7 AND #w = 'Grö';"
    ));
    assert!(runs(
        "Strg_TO_Chars(Strg := #w, pChars := 0, Cnt => #u, Chars := #words);
        Chars_TO_Strg(Chars := #words, pChars := 1, Cnt := 2, Strg => #w); #y := #words[6] = WORD#16#20AC AND #w = 'rö';"
    ));
}

#[test]
fn texts_of_both_kinds_have_the_same_functions_and_are_converted() {
    for condition in [
        "LEN(#w) = 7",
        "LEFT(IN := #w, L := 2) = WSTRING#'Gr'",
        "CONCAT(IN1 := #w, IN2 := '!', IN3 := WCHAR#'?') = WSTRING#'Größe €!?'",
        "CONCAT_WSTRING(IN1 := 'a', IN2 := 'b') = WSTRING#'ab'",
        "FIND(IN1 := #w, IN2 := '€') = 7",
        "REPLACE(IN1 := #w, IN2 := 'EUR', L := 1, P := 7) = WSTRING#'Größe EUR'",
        "WSTRING_TO_STRING(#w) = 'Größe ?'",
        "STRING_TO_WSTRING(#s) = WSTRING#'Valve 7'",
        "INT_TO_WSTRING(-5) = WSTRING#'    -5'",
        "WSTRING_TO_INT(WSTRING#' 12') = 12",
        "WCHAR_TO_STRING(#w[1]) = 'G'",
        "SEL(G := TRUE, IN0 := #short, IN1 := 'longer than four') = 'longer than four'",
        "MUX(K := 1, IN0 := #short, IN1 := #s, INELSE := 'none') = 'Valve 7'",
        "MUX(K := -1, IN0 := #short, IN1 := #s, INELSE := 'none') = 'none'",
        "MUX(K := 2, IN0 := #short, IN1 := #s) = ''",
    ] {
        assert!(holds(condition), "{condition}");
    }
    assert!(runs("#s := #c; #y := #s = 'x';"));
    assert!(runs("#wc := #w[7]; #w := #wc; #y := #w = '€' AND WCHAR_TO_WORD(#wc) = 16#20AC;"));
}
