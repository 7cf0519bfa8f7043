//! Each element as written in a document, compared with equivalent SCL statements. The syntax is that of SIMATIC SD,
//! LADDER format description (entry 109994073, 09/2025); the behavior is that in TIA Portal's help, V19, on the
//! instructions of S7-1200 and S7-1500.

use super::{compare, pair};

/// Blocks called by others.
const OTHERS: &str = r#"
FUNCTION "Double" : Int
VAR_INPUT value : Int; END_VAR
VAR_OUTPUT is_large : Bool; END_VAR
BEGIN
  #Double := #value * 2;
  #is_large := #value > 50;
END_FUNCTION
FUNCTION "Copy" : Void
VAR_INPUT from : Int; END_VAR
VAR_OUTPUT to : Int; END_VAR
VAR_IN_OUT count : Int; END_VAR
BEGIN
  #to := #from;
  #count := #count + 1;
END_FUNCTION
FUNCTION_BLOCK "Latch"
VAR_INPUT set : Bool; step : Int := 3; END_VAR
VAR_OUTPUT on : Bool; sum : Int; END_VAR
BEGIN
  #on := #on OR #set;
  #sum := #sum + #step;
END_FUNCTION_BLOCK
DATA_BLOCK "Data"
VAR flag : Bool; level : Int := 4; END_VAR
BEGIN
END_DATA_BLOCK
"#;

#[track_caller]
fn same(sections: &str, rungs: &str, statements: &str) {
    same_networks(sections, &network("LAD", rungs), statements);
}

#[track_caller]
fn same_in_fbd(sections: &str, rungs: &str, statements: &str) {
    same_networks(sections, &network("FBD", rungs), statements);
}

#[track_caller]
fn same_networks(sections: &str, networks: &str, statements: &str) {
    let (document, source) = pair(sections, networks, statements);
    compare(&document, &source, OTHERS, 60, 7);
}

fn network(language: &str, rungs: &str) -> String {
    format!("    {{ S7_Language := \"{language}\" }}\n    NETWORK\n{rungs}\n    END_NETWORK\n")
}

#[test]
fn contacts_branches_and_coils() {
    same("", "RUNG wire#powerrail Contact( #a ) I_Contact( #b ) Coil( #y ) END_RUNG", "#y := #a AND NOT #b;");
    same(
        "",
        "RUNG wire#powerrail Contact( #a ) wire#w1 I_Contact( #c ) Coil( #y ) I_Coil( #z ) END_RUNG
         RUNG wire#powerrail Contact( #b ) END_RUNG wire#w1
         RUNG wire#powerrail Contact( #y ) END_RUNG wire#w1",
        "#y := (#a OR #b OR #y) AND NOT #c; #z := NOT #y;",
    );
    // Two positions, a branch between them, and one that begins at the second.
    same(
        "",
        "RUNG wire#powerrail Contact( #a ) wire#w1 Contact( #b ) wire#w2 Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #c ) END_RUNG wire#w1
         RUNG wire#w1 I_Contact( #s ) END_RUNG wire#w2
         RUNG wire#w2 Not() Contact( #r ) Coil( #z ) END_RUNG",
        "#y := (#a OR #c) AND #b OR (#a OR #c) AND NOT #s; #z := NOT #y AND #r;",
    );
    same("", "RUNG wire#powerrail Coil( #y ) END_RUNG RUNG wire#powerrail END_RUNG", "#y := TRUE;");
    // A later element reads what an earlier one wrote; the branch of a coil is evaluated before it.
    same(
        "",
        "RUNG wire#powerrail Contact( #a ) Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #y ) wire#w1 Coil( #z ) END_RUNG
         RUNG wire#powerrail Contact( #z ) END_RUNG wire#w1",
        "#y := #a; #z := #y OR #z;",
    );
}

#[test]
fn coils_set_reset_and_bits_of_fields() {
    same(
        "VAR bits : Array[0..5] of Bool; END_VAR",
        "RUNG wire#powerrail Contact( #s ) S_Coil( #y ) S_BitfieldCoil( operand => #bits[1], n := 3 ) END_RUNG
         RUNG wire#powerrail Contact( #r ) R_Coil( #y ) R_BitfieldCoil( #bits[2], 1 ) END_RUNG",
        "IF #s THEN #y := TRUE; #bits[1] := TRUE; #bits[2] := TRUE; #bits[3] := TRUE; END_IF;
         IF #r THEN #y := FALSE; #bits[2] := FALSE; END_IF;",
    );
    same(
        "VAR m : Bool; o : Bool; e1 : Bool; e2 : Bool; END_VAR",
        "RUNG wire#powerrail Contact( #a ) P_Coil( operand => #m, bit := #e1 ) N_Coil( #o, #e2 ) Coil( #y ) END_RUNG",
        "#m := #a AND NOT #e1; #e1 := #a; #o := NOT #a AND #e2; #e2 := #a; #y := #a;",
    );
}

/// A flow that reads a variable keeps its value when an element then writes to the variable.
#[test]
fn the_flow_passes_what_is_written() {
    same(
        "VAR m : Bool; END_VAR",
        "RUNG wire#powerrail Contact( #y ) R_Coil( #y ) Coil( #z ) END_RUNG
         RUNG wire#powerrail Contact( #m ) I_Coil( #m ) S_Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #s ) #m.S_SR( r1 := #r ) R_Coil( #m ) Move( in := #i, out1 => #n ) END_RUNG
         RUNG wire#powerrail Contact( #a ) Coil( #y ) END_RUNG",
        "#z := #y; IF #y THEN #y := FALSE; END_IF;
         IF #m THEN #y := TRUE; END_IF; #m := NOT #m;
         #m := (#s OR #m) AND NOT #r; IF #m THEN #n := #i; END_IF; IF #m THEN #m := FALSE; END_IF;
         #y := #a;",
    );
}

#[test]
fn edges() {
    same(
        "VAR e1 : Bool; e2 : Bool; END_VAR",
        "RUNG wire#powerrail Contact( #c ) P_Contact( operand := #a, bit := #e1 ) Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #c ) n_contact( #b, #e2 ) Coil( #z ) END_RUNG",
        "#y := #c AND #a AND NOT #e1; #e1 := #a; #z := #c AND NOT #b AND #e2; #e2 := #b;",
    );
    same(
        "VAR e1 : Bool; e2 : Bool; END_VAR",
        "RUNG wire#powerrail Contact( #a ) wire#w1 P_Trig( #e1 ) Coil( #y ) END_RUNG
         RUNG wire#w1 N_Trig( #e2 ) Coil( #z ) END_RUNG",
        "#y := #a AND NOT #e1; #e1 := #a; #z := NOT #a AND #e2; #e2 := #a;",
    );
    same(
        "VAR rise : R_TRIG; fall : F_TRIG; END_VAR",
        "RUNG wire#powerrail #rise.R_TRIG( clk := #a, q => #y ) END_RUNG
         RUNG wire#powerrail Contact( #b ) #fall.F_TRIG( CLK := #a, Q => #z ) END_RUNG",
        "#rise(CLK := #a, Q => #y); IF #b THEN #fall(CLK := #a, Q => #z); END_IF;",
    );
}

#[test]
fn comparisons() {
    for (name, operator) in [("Eq", "="), ("NE", "<>"), ("GT", ">"), ("Ge", ">="), ("Lt", "<"), ("LE", "<=")] {
        same(
            "",
            &format!(
                "RUNG wire#powerrail Contact( #a ) {{ S7_Templates := \"SrcType := Int\" }} {name}_Contact( in1 := #i, in2 := #j )
                 Coil( #y ) END_RUNG
                 RUNG wire#powerrail {name}{{ SrcType := Real }}( IN1 := #x, IN2 := 0.5 ) Coil( #z ) END_RUNG"
            ),
            &format!("#y := #a AND #i {operator} #j; #z := #x {operator} 0.5;"),
        );
    }
    same(
        "",
        "RUNG wire#powerrail Gt_Contact( #i, #j ) Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #a ) { S7_Templates := \"SrcType := Int\" } InRange( min := 1, in := #i, max := #j )
         Coil( #z ) END_RUNG",
        "#y := #i > #j; #z := #a AND #i >= 1 AND #i <= #j;",
    );
    same(
        "VAR o : Bool; END_VAR",
        "RUNG wire#powerrail { S7_Templates := \"SrcType := Int\" } OutRange( min := 1, in := #i, max := 5 ) Coil( #o ) END_RUNG
         RUNG wire#powerrail Ok( #x ) Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #a ) NOK( #x ) Coil( #z ) END_RUNG",
        "#o := #i < 1 OR #i > 5; #y := #x = #x AND ABS(#x) <= 3.4028235E+38; #z := #a AND NOT #y;",
    );
}

#[test]
fn gates_of_function_block_diagrams() {
    same_in_fbd(
        "",
        "RUNG #a A( in2 := #b, in3 := NOT #c ) Coil( #y ) END_RUNG
         RUNG #a O( in2 := wire#w1 ) NOT Coil( #z ) END_RUNG
         RUNG #b X( in2 := #c, in3 := #s ) END_RUNG wire#w1",
        "#y := #a AND #b AND NOT #c; #z := NOT (#a OR (#b XOR #c XOR #s));",
    );
    // A pass-through, an inverter before a gate, a wire tapped in the middle and inverted at a pin.
    same_in_fbd(
        "",
        "RUNG #a A() wire#w1 NOT A( in2 := #b ) Coil( #y ) END_RUNG
         RUNG #c A( in2 := NOT wire#w1 ) Move( in := #i, out1 => #n ) END_RUNG
         RUNG { S7_Templates := \"SrcType := Int\" } EQ_Contact( in1 := #i, in2 := #j ) A( in2 := #s ) Coil( #z ) END_RUNG",
        "#y := NOT #a AND #b; IF #c AND NOT #a THEN #n := #i; END_IF; #z := #i = #j AND #s;",
    );
    // Boxes without an input are executed; a rung may begin at a member or a constant.
    same_in_fbd(
        "",
        "RUNG Move( in := #i, out1 => #n ) Move( in := #j, out1 => #k ) END_RUNG
         RUNG \"Data\".flag O( in2 := #a ) Coil( \"Data\".flag ) Coil( #y ) END_RUNG
         RUNG TRUE Coil( #z ) END_RUNG
         RUNG END_RUNG",
        "#n := #i; #k := #j; \"Data\".flag := \"Data\".flag OR #a; #y := \"Data\".flag; #z := TRUE;",
    );
}

#[test]
fn flip_flops() {
    let (sr, rs) = ("#m := (#s OR #m) AND NOT #r;", "#m := #s OR #m AND NOT #r;");
    let reset = "RUNG wire#powerrail Contact( #r ) END_RUNG wire#w1";
    let set = "RUNG wire#powerrail Contact( #s ) END_RUNG wire#w1";
    for (element, branch, law) in [
        ("Contact( #s ) #m.S_SR( wire#w1 )", reset, sr),
        ("Contact( #r ) #m.S_RS( wire#w1 )", set, rs),
        ("Contact( #s ) S_SR( operand := #m, r1 := wire#w1 )", reset, sr),
        ("Contact( #r ) S_RS( operand := #m, s1 := #s )", "", rs),
        ("SR( operand := #m, s := #s, r := #r )", "", sr),
        ("RS( operand := #m, s := #s, r := #r )", "", rs),
    ] {
        let rungs = format!("RUNG wire#powerrail {element} Coil( #y ) END_RUNG {branch}");
        same("VAR m : Bool; END_VAR", &rungs, &format!("{law} #y := #m;"));
    }
}

#[test]
fn timers() {
    for kind in ["TON", "TOF", "TP"] {
        same(
            &format!("VAR t : {kind}_TIME; END_VAR"),
            &format!(
                "RUNG wire#powerrail Contact( #a ) {{ S7_Templates := \"time_type := Time\" }} #t.{kind}( pt := T#250ms, et => #et )
                 Coil( #y ) END_RUNG
                 RUNG wire#powerrail Contact( #t.Q ) Coil( #z ) END_RUNG"
            ),
            &format!("#t.{kind}(IN := #a, PT := T#250ms, ET => #et); #y := #t.Q; #z := #t.Q;"),
        );
    }
    same_in_fbd(
        "VAR t : TONR_TIME; END_VAR",
        "RUNG #a NOT #t.TONR( r := #r, PT := T#300ms, ET =>  ) NOT Coil( #y ) END_RUNG",
        "#t.TONR(IN := NOT #a, R := #r, PT := T#300ms); #y := NOT #t.Q;",
    );
    same(
        "VAR t : TON_TIME; u : IEC_TIMER; END_VAR",
        "RUNG wire#powerrail Contact( #a ) { S7_Templates := \"time_type := Time\" } TON_Coil( timer => #t, pt := T#200ms ) END_RUNG
         RUNG wire#powerrail Contact( #b ) TOf_Coil( #u, T#200ms ) END_RUNG
         RUNG wire#powerrail Contact( #r ) RT_Coil( #t ) END_RUNG
         RUNG wire#powerrail Contact( #s ) PT_Coil( timer => #t, PT := T#400ms ) END_RUNG
         RUNG wire#powerrail Contact( #t.Q ) Coil( #y ) END_RUNG
         RUNG wire#powerrail Contact( #u.Q ) Coil( #z ) END_RUNG",
        "#t.TON(IN := #a, PT := T#200ms); #u.TOF(IN := #b, PT := T#200ms); IF #r THEN RESET_TIMER(#t); END_IF;
         IF #s THEN PRESET_TIMER(PT := T#400ms, TIMER := #t); END_IF; #y := #t.Q; #z := #u.Q;",
    );
    // A timer in an undeclared data block.
    same(
        "",
        "RUNG wire#powerrail Contact( #a ) { S7_Templates := \"time_type := Time\" } \"T_DB\".TON( PT := T#200ms, et => #et )
         Coil( #y ) END_RUNG",
        "\"T_DB\".TON(IN := #a, PT := T#200ms, ET => #et); #y := \"T_DB\".Q;",
    );
}

#[test]
fn counters() {
    let counter = "{ S7_Templates := \"value_type := Int\" }";
    same(
        "VAR c1 : CTU_INT; END_VAR",
        &format!(
            "RUNG wire#powerrail Contact( #a ) {counter} #c1.Ctu( r := #r, pv := 3, cv => #cv ) Coil( #y ) END_RUNG"
        ),
        "#c1.CTU(CU := #a, R := #r, PV := 3, CV => #cv); #y := #c1.Q;",
    );
    same(
        "VAR c1 : CTD_INT; END_VAR",
        &format!(
            "RUNG wire#powerrail Contact( #a ) {counter} #c1.CTD( LD := #s, PV := #j, CV => #cv ) Coil( #y ) END_RUNG"
        ),
        "#c1.CTD(CD := #a, LD := #s, PV := #j, CV => #cv); #y := #c1.Q;",
    );
    same(
        "VAR c1 : CTUD_INT; END_VAR",
        &format!(
            "RUNG wire#powerrail Contact( #a ) {counter} #c1.CTUD( cd := #b, r := #r, ld := wire#w1, pv := 3, qd => #z, cv => #cv )
             Coil( #y ) END_RUNG RUNG wire#powerrail Contact( #s ) I_Contact( #c ) END_RUNG wire#w1"
        ),
        "#c1.CTUD(CU := #a, CD := #b, R := #r, LD := #s AND NOT #c, PV := 3, QD => #z, CV => #cv); #y := #c1.QU;",
    );
}

#[test]
fn boxes() {
    let int = "{ S7_Templates := \"SrcType := Int\" }";
    for (element, value) in [
        ("Add( in1 := #i, in2 := #j, in3 := 7, out => #n )", "#i + #j + 7"),
        ("Sub( in1 := #i, in2 := #j, out => #n )", "#i - #j"),
        ("Mul( IN1 := #i, IN2 := #j, OUT => #n )", "#i * #j"),
        ("Div( in1 := #i, in2 := #j, out => #n )", "#i / #j"),
        ("Mod( in1 := #i, in2 := #j, out => #n )", "#i MOD #j"),
        ("Neg( in := #i, out => #n )", "-#i"),
        ("Abs( in := #i, out => #n )", "ABS(#i)"),
        (
            "Mux( k := #i, in0 := 10, in1 := #j, else := -1, out => #n )",
            "MUX(K := #i, IN0 := 10, IN1 := #j, INELSE := -1)",
        ),
    ] {
        let statements = format!("IF #a THEN #n := {value}; END_IF;");
        same("", &format!("RUNG wire#powerrail Contact( #a ) {int} {element} END_RUNG"), &statements);
    }
    let value = "{ S7_Templates := \"value_type := Int\"; S7_GenerateENO := \"TRUE\" }";
    for (element, value_of) in [
        ("MIN( in1 := #i, in2 := #j, out => #n )", "MIN(IN1 := #i, IN2 := #j)"),
        ("Max( in1 := #i, in2 := #j, in3 := 3, out => #n )", "MAX(IN1 := #i, IN2 := #j, IN3 := 3)"),
        ("Limit( min := 0, in := #i, max := 10, out => #n )", "LIMIT(MN := 0, IN := #i, MX := 10)"),
        ("SEL( g := #b, in0 := #i, in1 := #j, out => #n )", "SEL(G := #b, IN0 := #i, IN1 := #j)"),
    ] {
        same("", &format!("RUNG wire#powerrail {value} {element} END_RUNG"), &format!("#n := {value_of};"));
    }
    for (element, value) in [
        ("And( in1 := #w, in2 := 16#FF, out => #v )", "#w AND 16#FF"),
        ("Or( in1 := #w, in2 := 16#F, out => #v )", "#w OR 16#F"),
        ("Xor( in1 := #w, in2 := #v, out => #v )", "#w XOR #v"),
        ("Inv( in := #w, out => #v )", "NOT #w"),
        ("Shl( in := #w, n := 3, out => #v )", "SHL(IN := #w, N := 3)"),
        ("Shr( in := #w, n := 3, out => #v )", "SHR(IN := #w, N := 3)"),
        ("Rol( in := #w, n := 3, out => #v )", "ROL(IN := #w, N := 3)"),
        ("Ror( in := #w, n := 3, out => #v )", "ROR(IN := #w, N := 3)"),
        ("Swap( in := #w, out => #v )", "SWAP(#w)"),
    ] {
        let rungs = format!("RUNG wire#powerrail {{ S7_Templates := \"SrcType := Word\" }} {element} END_RUNG");
        same("", &rungs, &format!("#v := {value};"));
    }
    let real = "{ S7_Templates := \"SrcType := Real\" }";
    for name in ["Sqr", "Sqrt", "Exp", "Ln", "Sin", "Cos", "Tan", "Asin", "Acos", "Atan"] {
        same(
            "",
            &format!("RUNG wire#powerrail {real} {name}( in := #x, out => #q ) END_RUNG"),
            &format!("#q := {}(#x);", name.to_uppercase()),
        );
    }
}

#[test]
fn boxes_with_two_types() {
    let types = |from: &str, to: &str| format!("{{ S7_Templates := \"[SrcType := {from}, DestType := {to}]\" }}");
    for (templates, element, statement) in [
        (types("Int", "Real"), "Convert( in := #i, out => #q )", "#q := INT_TO_REAL(#i);"),
        (types("Real", "Int"), "Round( in := #x, out => #n )", "#n := ROUND_INT(#x);"),
        (types("Real", "Int"), "Trunc( in := #x, out => #n )", "#n := TRUNC_INT(#x);"),
        (types("Real", "Int"), "Ceil( in := #x, out => #n )", "#n := CEIL_INT(#x);"),
        (types("Real", "Int"), "Floor( in := #x, out => #n )", "#n := FLOOR_INT(#x);"),
        (
            types("Int", "Real"),
            "Normalize( min := 0, value := #i, max := 200, out => #q )",
            "#q := NORM_X(MIN := 0, VALUE := #i, MAX := 200);",
        ),
        (
            types("Real", "Real"),
            "Scale( min := 10.0, value := #x, max := 20.0, out => #q )",
            "#q := SCALE_X(MIN := 10.0, VALUE := #x, MAX := 20.0);",
        ),
    ] {
        same("", &format!("RUNG wire#powerrail {templates} {element} END_RUNG"), statement);
    }
    same(
        "",
        "RUNG wire#powerrail Contact( #a )
         { S7_Templates := \"SrcType := Real\"; S7_Expression := \"sqr( sin( in1 )) + sqr( cos( in2 )) / 2.0\" }
         Calculate( in1 := #x, in2 := #q, out => #q ) END_RUNG",
        "IF #a THEN #q := SQR(SIN(#x)) + SQR(COS(#q)) / 2.0; END_IF;",
    );
}

#[test]
fn eno_and_what_hangs_on_it() {
    // Without S7_GenerateENO, ENO equals EN; with it, ENO is FALSE if the sum overflows.
    same(
        "",
        "RUNG wire#powerrail Contact( #a ) { S7_Templates := \"SrcType := Int\" } Add( in1 := #i, in2 := #j, out => #n ) Coil( #y )
         END_RUNG
         RUNG wire#powerrail Contact( #b ) { S7_Templates := \"SrcType := Int\"; S7_GenerateENO := \"TRUE\" }
         Add( in1 := #i, in2 := #j, out => #k ) Coil( #z ) END_RUNG",
        "IF #a THEN #n := #i + #j; END_IF; #y := #a;
         #z := #b AND INT_TO_DINT(#i) + INT_TO_DINT(#j) = INT_TO_DINT(#i + #j); IF #b THEN #k := #i + #j; END_IF;",
    );
    // Results of boxes on wires.
    same_in_fbd(
        "",
        "RUNG { S7_Templates := \"SrcType := Int\" } Add( in1 := #i, in2 := 1, out => wire#w1 )
         { S7_Templates := \"SrcType := Int\" } Mul( in1 := wire#w1, in2 := 2, out => #n ) END_RUNG",
        "#n := (#i + 1) * 2;",
    );
    same(
        "VAR steps : Int; END_VAR",
        "RUNG wire#powerrail Contact( #a ) { S7_Templates := \"SrcType := Int\" } Inc( #steps ) Move( in := #steps, out1 => #n, out2 => #k )
         END_RUNG",
        "IF #a THEN #steps := #steps + 1; #n := #steps; #k := #steps; END_IF;",
    );
}

#[test]
fn calls() {
    same(
        "VAR latch : _.Latch; other : \"Latch\"; all : Array[0..1] of _.Latch; END_VAR",
        "RUNG wire#powerrail Contact( #a ) #latch( set := #b, step := , on => #y, sum => #n ) Coil( #z ) END_RUNG
         RUNG wire#powerrail other( SET := wire#w1, sum => #k ) END_RUNG
         RUNG wire#powerrail Contact( #s ) Contact( #r ) END_RUNG wire#w1
         RUNG wire#powerrail #all[1]( set := #c ) END_RUNG",
        "IF #a THEN #latch(set := #b, on => #y, sum => #n); END_IF; #z := #a;
         #other(set := #s AND #r, sum => #k); #all[1](set := #c);",
    );
    same(
        "VAR count : Int; END_VAR",
        "RUNG wire#powerrail Contact( #a ) \"Copy\"( from := #i, to => #n, count := #count ) END_RUNG
         RUNG wire#powerrail Double( value := #j, is_large => #y, Ret_Val => #k ) END_RUNG
         RUNG wire#powerrail Contact( #b ) _.Copy( from := #j, to => \"Data\".level, count := #count ) END_RUNG",
        "IF #a THEN \"Copy\"(from := #i, to => #n, count := #count); END_IF;
         #k := \"Double\"(value := #j, is_large => #y);
         IF #b THEN \"Copy\"(from := #j, to => \"Data\".level, count := #count); END_IF;",
    );
}

#[test]
fn jumps_labels_and_returns() {
    let networks = [
        "RUNG wire#powerrail Contact( #a ) JumpCoil( far ) END_RUNG",
        "RUNG wire#powerrail { S7_Templates := \"SrcType := Int\" } Add( in1 := #n, in2 := 1, out => #n ) END_RUNG",
        "Label( far ) RUNG wire#powerrail Contact( #b ) I_JumpCoil( end ) END_RUNG",
        "RUNG wire#powerrail { S7_Templates := \"SrcType := Int\" } Add( in1 := #k, in2 := 1, out => #k ) END_RUNG",
        "Label( end ) RUNG wire#powerrail Contact( #c ) Return() END_RUNG",
        "Label() RUNG wire#powerrail Contact( #s ) Coil( #y ) END_RUNG",
    ];
    let networks: String = networks.map(|rungs| network("LAD", rungs)).concat();
    same_networks(
        "",
        &networks,
        "IF NOT #a THEN #n := #n + 1; END_IF; IF #b THEN #k := #k + 1; END_IF; IF #c THEN RETURN; END_IF; #y := #s;",
    );
}

#[test]
fn networks_of_several_languages_stand_in_one_block() {
    let networks = [
        network("LAD", "RUNG wire#powerrail Contact( #a ) Coil( #y ) END_RUNG"),
        network("SCL", "#n := #i + 1; IF #y THEN #n := #n * 2; END_IF;"),
        network("F_FBD", "RUNG #y A( in2 := #b ) Coil( #z ) END_RUNG"),
    ];
    same_networks("", &networks.concat(), "#y := #a; #n := #i + 1; IF #y THEN #n := #n * 2; END_IF; #z := #y AND #b;");
}
