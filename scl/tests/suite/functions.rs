//! Functions of the CPU, with values that can be checked by hand.

use super::{Ran, is_y_true};
use parameters::Source;
use scl::{Compiled, Options, compile};

const VARIABLES: &str = "VAR_OUTPUT y : Bool; END_VAR
    VAR
        s : String; c : Char; i : Int; u : USInt; d : DInt; ud : UDInt; r : Real; l : LReal; w : Word; b : Byte; q : Bool;
        now, then : DTL; dt : DT; limit : Real := 1.5; len : Int; word : Word; date : Date; tod : Time_Of_Day; ldt : LDT; t : Time; memory : LReal; run : LReal; tick : Time;
        bits : Array[0..15] of Bool; from : Array[1..5] of Int := [1, 2, 3, 4, 5]; to : Array[0..5] of Int; n : Int := 2;
        on : TON_TIME; off : TON_TIME;
    END_VAR";

/// Compiles a program with these statements.
fn program(statements: &str) -> Compiled {
    let source = format!(
        "FUNCTION \"Checked\" : Int VAR_INPUT a : Int; END_VAR BEGIN #Checked := #a * 2; ENO := #a < 10; END_FUNCTION
        FUNCTION \"Later\" : Bool VAR_INPUT than : DTL; END_VAR BEGIN #Later := #than < DTL#2020-01-01-00:00:01; END_FUNCTION
        FUNCTION_BLOCK \"Sub\" VAR_INPUT x : Int; END_VAR VAR_OUTPUT z : Int; END_VAR BEGIN #z := #z + #x; RETURN #x > 0; END_FUNCTION_BLOCK
        FUNCTION_BLOCK \"B\" {{ S7_Optimized_Access := 'TRUE' }} {VARIABLES} VAR sub : \"Sub\"; END_VAR
        BEGIN {statements} END_FUNCTION_BLOCK"
    );
    let compiled =
        compile(&[Source::new("b.scl", source.into())], &Options { block: Some("B".into()), ..Options::default() });
    compiled.unwrap_or_else(|errors| panic!("{statements}: {}", errors[0]))
}

/// Whether `y` is TRUE after the statements.
fn runs(statements: &str) -> bool {
    is_y_true(program(statements))
}

#[track_caller]
fn holds(statements: &str, conditions: &[&str]) {
    for condition in conditions {
        assert!(runs(&format!("{statements} #y := {condition};")), "{statements} {condition}");
    }
}

#[test]
fn numbers_become_texts_as_wide_as_the_longest_of_their_type() {
    let texts = [
        "INT_TO_STRING(0) = '     0'",
        "INT_TO_STRING(-32768) = '-32768'",
        "USINT_TO_STRING(255) = ' 255'",
        "SINT_TO_STRING(-5) = '  -5'",
        "DINT_TO_STRING(-2147483648) = '-2147483648'",
        "UDINT_TO_STRING(UDINT#4294967295) = ' 4294967295'",
        "ULINT_TO_STRING(ULINT#18446744073709551615) = ' 18446744073709551615'",
        "LINT_TO_STRING(LINT#-9223372036854775808) = ' -9223372036854775808'",
        "REAL_TO_STRING(0.0) = ' +0.000000E+00'",
        "REAL_TO_STRING(-1234.5) = ' -1.234500E+03'",
        "REAL_TO_STRING(9.9999999) = ' +1.000000E+01'",
        "REAL_TO_STRING(0.00025) = ' +2.500000E-04'",
        "LREAL_TO_STRING(0.1) = '+1.0000000000000E-001'",
        "CHAR_TO_STRING('x') = 'x'",
    ];
    holds("", &texts);
}

#[test]
fn texts_become_the_number_with_which_they_begin() {
    let numbers = [
        "STRING_TO_INT('  -123 mm') = -123",
        "STRING_TO_INT('+7') = 7",
        "STRING_TO_INT('x1') = 0",
        "STRING_TO_INT('') = 0",
        "STRING_TO_INT('40000') = 0",
        "STRING_TO_DINT('40000') = 40000",
        "STRING_TO_REAL('12.5') = 12.5",
        "STRING_TO_REAL(' -1.25E2') = -125.0",
        "STRING_TO_REAL('250e-3') = 0.25",
        "STRING_TO_LREAL('0.1') = LREAL#0.1",
        "STRING_TO_CHAR('abc') = 'a'",
        "STRING_TO_INT(INT_TO_STRING(-32768)) = -32768",
    ];
    holds("", &numbers);
    holds("#s := CONCAT_STRING('a', 'b');", &["#s = 'ab'"]);
    holds("S_MOVE(IN := 'abc', OUT => #s);", &["#s = 'abc'"]);
}

#[test]
fn dates_are_calculated_and_compared() {
    let dates = "#now := DTL#2024-02-29-12:30:15.5; #then := DTL#2024-03-01-00:00:00;";
    let conditions = [
        "#now < #then",
        "NOT (#now >= #then)",
        "#now <> #then",
        "T_DIFF(IN1 := #then, IN2 := #now) = T#11h29m44s500ms",
        "T_SUB(IN1 := #then, IN2 := T#1ms) > #now",
        "DTL_TO_TOD(#now) = TOD#12:30:15.500",
        "DTL_TO_DATE(#now) = D#2024-02-29",
        "DTL_TO_DATE(#then) - DTL_TO_DATE(#now) = T#1d",
        "TOD#23:00:00 + T#2h = TOD#01:00:00",
        "LDT_TO_DATE(DTL_TO_LDT(#now)) = D#2024-02-29",
    ];
    holds(dates, &conditions);
    let added =
        "#then := T_ADD(IN1 := #now, IN2 := T#12h); #now := T_COMBINE(IN1 := D#1999-12-31, IN2 := TOD#23:59:59);";
    let members = [
        "#then.DAY = 1 AND #then.MONTH = 3 AND #then.HOUR = 0 AND #then.MINUTE = 30 AND #then.SECOND = 15",
        // A Friday.
        "#then.WEEKDAY = 6 AND #then.NANOSECOND = 500000000",
        "#now.YEAR = 1999 AND #now.DAY = 31 AND #now.WEEKDAY = 6 AND #now.SECOND = 59",
    ];
    holds(&format!("{dates}{added}"), &members);
}

#[test]
fn bits_are_counted_found_and_moved() {
    let conditions = [
        "ENCO(IN := 16#0120) = 5",
        "ENCO(0) = 0",
        "BITSUM(16#F0F1) = 9",
        "DECO(IN := 3) = 8",
        "DECO(IN := 33) = 2",
        "DECO_WORD(IN := 17) = 2",
    ];
    holds("", &conditions);
    let scattered = "#w := 16#8005; SCATTER(IN := #w, OUT => #bits); #bits[1] := TRUE; GATHER(IN := #bits, OUT => #w);";
    holds(scattered, &["#bits[0] AND #bits[2] AND #bits[15] AND NOT #bits[3]", "#w = 16#8007"]);
}

#[test]
fn elements_are_moved_and_filled() {
    let moved = "MOVE_BLK(IN := #from[#n], COUNT := 3, OUT => #to[1]);";
    holds(moved, &["#to[0] = 0 AND #to[1] = 2 AND #to[2] = 3 AND #to[3] = 4 AND #to[4] = 0"]);
    holds("UFILL_BLK(IN := #n + 5, COUNT := 2, OUT => #to[4]);", &["#to[3] = 0 AND #to[4] = 7 AND #to[5] = 7"]);
    let mut ran = Ran::new(program("MOVE_BLK(IN := #from[4], COUNT := 3, OUT => #to[0]);"));
    let stop = ran.call(0).unwrap_err().to_string();
    assert!(stop.ends_with("index 6 is outside 1..5"), "{stop}");
}

#[test]
fn clocks_count_the_time_of_the_calls() {
    let mut ran = Ran::new(program(
        "#tick := TIME_TCK(); #run := RUNTIME(#memory); #on(IN := TRUE, PT := T#10s);
        #off(IN := TRUE, PT := T#10s); IF #tick = T#3s THEN RESET_TIMER(#on); PRESET_TIMER(PT := T#4s, TIMER := #off); END_IF;",
    ));
    let mut seen = Vec::new();
    for seconds in [0, 3, 5] {
        ran.call(seconds * 1_000_000_000).unwrap();
        let numbers = ["tick", "run", "on.ET", "off.ET"].map(|name| ran.get(name).number());
        let is_over = ["on.Q", "off.Q"].map(|name| ran.get(name) == true.into());
        seen.push((numbers, is_over));
    }
    // RESET_TIMER also clears the memory of IN: the timer starts again in the next call.
    let expected = [
        ([0.0, 0.0, 0.0, 0.0], [false; 2]),
        ([3000.0, 3.0, 0.0, 3000.0], [false; 2]),
        ([5000.0, 2.0, 0.0, 4000.0], [false, true]),
    ];
    assert_eq!(seen, expected);
}

#[test]
fn a_call_with_en_is_made_if_it_is_true_and_eno_tells_how_it_went() {
    let called = "#i := \"Checked\"(EN := #n > 1, a := 4, ENO => #q);";
    holds(called, &["#i = 8 AND #q"]);
    holds("#i := 5; #i := \"Checked\"(EN := #n > 2, a := 4, ENO => #q);", &["#i = 0 AND NOT #q"]);
    holds("#i := \"Checked\"(a := 10, ENO => #q);", &["#i = 20 AND NOT #q"]);
    holds("#sub(EN := TRUE, x := 3, z => #i, ENO => #q);", &["#i = 3 AND #q AND #sub.z = 3"]);
    holds("#i := 7; #sub(EN := FALSE, x := 3, z => #i, ENO => #q);", &["#i = 7 AND NOT #q AND #sub.x = 0"]);
    holds("#sub(x := -1, ENO => #q);", &["NOT #q AND #sub.z = -1"]);
    holds("#on(EN := #q, IN := TRUE, PT := T#0s, ENO => #q);", &["NOT #q AND NOT #on.Q"]);
}

#[test]
fn dt_is_calculated_and_converted_and_counts_milliseconds() {
    holds(
        "#dt := DT#2024-02-28-23:59:59.5; #now := DT_TO_DTL(#dt + T#1s);",
        &[
            "#now.MONTH = 2 AND #now.DAY = 29 AND #now.HOUR = 0 AND #now.NANOSECOND = 500000000",
            "DT_TO_DATE(#dt) = D#2024-02-28 AND DATE_AND_TIME_TO_TOD(#dt) = TOD#23:59:59.5",
            "#dt - DT#2024-02-28-23:59:58 = T#1500ms AND #dt > DT#1990-01-01-00:00:00",
            "DTL_TO_DT(DTL#2024-02-28-23:59:59.5009) = #dt",
            "LDT_TO_DT(DT_TO_LDT(#dt)) = #dt",
            "RD_SYS_T(#dt) = 0 AND #dt = DT#2000-01-01-00:00:00",
            "\"Later\"(than := DTL#2020-01-01-00:00:00)",
        ],
    );
    assert!(runs("#y := #dt = DT#1990-01-01-00:00:00;"), "it begins in 1990");
}

#[test]
fn t_conv_converts_to_what_it_is_assigned_to() {
    for statements in [
        "#t := T#1500ms; #d := T_CONV(#t); #y := #d = 1500;",
        "#t := T_CONV(IN := 2500); #y := #t = T#2s500ms;",
        "#now := DTL#2024-02-28-01:02:03; T_CONV(IN := #now, OUT => #tod); #y := #tod = TOD#01:02:03;",
        "#date := D#2024-02-28; #now := T_CONV(#date); #y := #now = DTL#2024-02-28-00:00:00;",
        "#tod := TOD#00:00:05; #t := TOD_TO_TIME(#tod); #y := #t = T#5s;",
    ] {
        assert!(runs(statements), "{statements}");
    }
}

#[test]
fn scale_and_unscale_are_those_of_step_7() {
    holds(
        "",
        &[
            "SCALE(IN := 13824, HI_LIM := 100.0, LO_LIM := 0.0, BIPOLAR := FALSE, OUT => #r) = 0 AND #r = 50.0",
            "SCALE(IN := -27648, HI_LIM := 100.0, LO_LIM := 0.0, BIPOLAR := TRUE, OUT => #r) = 0 AND #r = 0.0",
            "\"SCALE\"(IN := -1, HI_LIM := 100.0, LO_LIM := 20.0, BIPOLAR := FALSE, OUT => #r) = 8 AND #r = 20.0",
            "UNSCALE(IN := 50.0, HI_LIM := 100.0, LO_LIM := 0.0, BIPOLAR := FALSE, OUT => #i) = 0 AND #i = 13824",
            "UNSCALE(IN := 101.0, HI_LIM := 100.0, LO_LIM := 0.0, BIPOLAR := FALSE, OUT => #i) = 8 AND #i = 27648",
        ],
    );
}

#[test]
fn a_variable_called_as_a_function_does_not_hide_it() {
    holds("", &["LIMIT(MN := 0.0, IN := 5.0, MX := #limit) = 1.5", "LEN('abc') = 3 AND #len = 0"]);
}
