//! The tables of docs/scl.md: each row has samples that compile, are rejected with the stated message, or have the
//! decided result.

use super::{Ran, is_y_true};
use parameters::Source;
use parameters::tags::Tag;
use scl::{Compiled, Options, compile};

/// Declarations available to every sample.
const AROUND: &str = r#"
TYPE "Pair" STRUCT x : Int; y : Int; END_STRUCT; END_TYPE
DATA_BLOCK "D" STRUCT a : Int; b : Array[1..3] of Pair; END_STRUCT; BEGIN a := 3; END_DATA_BLOCK
FUNCTION "Twice" : Int VAR_INPUT a : Int; END_VAR BEGIN #Twice := #a * 2; END_FUNCTION
FUNCTION "Count" : Bool BEGIN "D".a := "D".a + 1; #Count := TRUE; END_FUNCTION
FUNCTION_BLOCK "Sub" VAR_INPUT a : Int; END_VAR VAR_OUTPUT b : Int; END_VAR VAR_IN_OUT p : "Pair"; END_VAR
BEGIN #b := #a; END_FUNCTION_BLOCK
"#;

/// The variables of the block that contains a sample of statements.
const VARIABLES: &str = r#"
VAR_OUTPUT y : Bool; END_VAR
VAR i : Int; n : Int; small : SInt; d : DInt; wide : LInt; w : Word; r : Real; zero : Real; one : Real := 1.0; s : String;
    c : Char; t : Time; a : Array[1..3] of Int; chars : Array[0..9] of Char; flags : Array[0..15] of Bool; pair : "Pair"; other : "Pair"; sub : "Sub";
    subs : Array[1..2] of "Sub"; timer : TON_TIME; any : IEC_TIMER; ctu : CTU; edge : R_TRIG; now : DTL; ws : WString;
    control : CONT_C; pulses : PULSEGEN; END_VAR
VAR_TEMP temp : Int; END_VAR
VAR CONSTANT TEN : Int := 10; END_VAR
"#;

/// A row of the table "The language".
struct Row {
    what: &'static str,
    /// Statements, or whole sources, which begin with a block keyword.
    works: &'static [&'static str],
    /// Rejected samples, with their messages.
    refused: &'static [(&'static str, &'static str)],
}

const ROWS: &[Row] = &[
    Row {
        what: "files",
        works: &["REGION one\n #i := 1; // a\n (* b *) /* c */ (/* d */)\nEND_REGION {PRAGMA_BEGIN}"],
        refused: &[
            ("FUNCTION_BLOCK \"P\" KNOW_HOW_PROTECT BEGIN END_FUNCTION_BLOCK", "protected block without source"),
            ("FUNCTION \"L\" : Void BEGIN NETWORK\n A #x; END_FUNCTION", "this block is in STL or LAD, not in SCL"),
        ],
    },
    Row {
        what: "blocks",
        works: &[
            "ORGANIZATION_BLOCK \"Main\" BEGIN \"Twice\"(a := 1); END_ORGANIZATION_BLOCK",
            "DATA_BLOCK \"OfType\" \"Pair\" BEGIN x := 1; END_DATA_BLOCK
             DATA_BLOCK \"OfArray\" ARRAY[0..3] OF Int BEGIN END_DATA_BLOCK DATA_BLOCK \"OfBlock\" TON_TIME BEGIN END_DATA_BLOCK",
        ],
        refused: &[("FUNCTION \"F\" : Int BEGIN #F := \"F\"(); END_FUNCTION", "calls itself")],
    },
    Row {
        what: "sections",
        works: &[
            "FUNCTION_BLOCK S VAR_OUTPUT q : BOOL; END_VAR CONST N := 3; END_CONST LABEL out; END_LABEL VAR RETAIN k : INT; END_VAR
             VAR DB_SPECIFIC l : INT; END_VAR BEGIN k := N; GOTO out; out: q := TRUE; END_FUNCTION_BLOCK",
            "FUNCTION_BLOCK S VAR w : WORD; b AT w : ARRAY[0..1] OF BYTE; END_VAR BEGIN b[0] := 1; END_FUNCTION_BLOCK",
            "FUNCTION_BLOCK S VAR s : STRING; b AT s : ARRAY[0..1] OF BYTE; END_VAR BEGIN b[1] := 1; END_FUNCTION_BLOCK",
        ],
        refused: &[(
            "FUNCTION_BLOCK S VAR s : WSTRING; b AT s : ARRAY[0..1] OF BYTE; END_VAR BEGIN b[0] := 1; END_FUNCTION_BLOCK",
            "a WSTRING cannot be viewed through AT",
        ), (
            "FUNCTION_BLOCK S VAR d : DT; b AT d : ARRAY[0..7] OF BYTE; END_VAR BEGIN b[0] := 1; END_FUNCTION_BLOCK",
            "which a CPU stores in BCD",
        )],
    },
    Row {
        what: "types",
        works: &["FUNCTION_BLOCK S VAR a : LWORD; b : ULINT; c : LREAL; d : LTIME; e : WCHAR; f : STRING[9]; g : WSTRING; h : DATE; i : TOD;
            j : LTOD; k : LDT; l : DTL; dt : DT; m : ARRAY[1..2, 0..1, 0..1, 0..1, 0..1, 0..1] OF INT; n : STRUCT x : INT; END_STRUCT; END_VAR
            BEGIN l := l + T#1s; END_FUNCTION_BLOCK"],
        refused: &[
            ("FUNCTION_BLOCK S VAR x : S5TIME; END_VAR BEGIN END_FUNCTION_BLOCK", "use IEC timers and counters: TON, TOF, TP, "),
            ("FUNCTION_BLOCK S VAR_INPUT x : COUNTER; END_VAR BEGIN END_FUNCTION_BLOCK", "use IEC timers and counters: TON, TOF, TP, "),
            ("FUNCTION_BLOCK S VAR_TEMP x : VARIANT; END_VAR BEGIN END_FUNCTION_BLOCK", "pass the variable itself; for an array of any length, declare ARRAY[*]"),
            ("FUNCTION_BLOCK S VAR_INPUT x : DB_ANY; END_VAR BEGIN END_FUNCTION_BLOCK", "pass the variable itself; for an array of any length, declare ARRAY[*]"),
            ("FUNCTION_BLOCK S VAR x : TO_SpeedAxis; END_VAR BEGIN END_FUNCTION_BLOCK", "supply its values through inputs"),
        ],
    },
    Row {
        what: "start values",
        works: &[
            "FUNCTION_BLOCK S VAR a : ARRAY[1..5] OF INT := [1, 2, 3(0)]; p : \"Pair\" := (6, 7); q : \"Pair\" := (x := 1); pairs : ARRAY[0..1] OF \"Pair\" := [(), (3, ())]; END_VAR
             BEGIN END_FUNCTION_BLOCK",
            "FUNCTION_BLOCK S VAR a : ARRAY[1..5] OF INT := 1, 2, 3(0); END_VAR BEGIN END_FUNCTION_BLOCK",
        ],
        refused: &[],
    },
    Row {
        what: "operators",
        works: &["#i := -(#n + 3) * 2 / 3 MOD 4; #y := NOT #y AND #i <> 3 XOR #y OR #i >= 2; #r := #one ** 2; #y := #pair = #other;
            #y := #a <> #a; #y := #s < 'b';"],
        refused: &[("#r := -#one ** 2;", "write -(a ** b) or (-a) ** b")],
    },
    Row {
        what: "access",
        works: &["#i := \"D\".b[2].x; #y := #w.%X3; #w.%B1 := 1; #i := #sub.b;"],
        refused: &[
            ("#y := %I0.0;", "an absolute address has no value in an FMU; make it an input"),
            ("#w := MW10;", "an absolute address has no value in an FMU; make it an input"),
            ("DB5.DBW2 := 1;", "an absolute address has no value in an FMU; make it an input"),
        ],
    },
    Row {
        what: "statements",
        works: &["#i := #n := 3; #i += 1; #r /= 2.0; IF #y THEN ; ELSIF #i = 1 THEN ; ELSE ; END_IF;
            CASE #i OF -1: ; 0, 5..7: ; TEN: ; ELSE ; END_CASE; FOR #i := 1 TO 9 BY 2 DO CONTINUE; END_FOR;
            WHILE #i < 3 DO #i := #i + 1; END_WHILE; REPEAT EXIT; UNTIL TRUE END_REPEAT; GOTO out; out: RETURN;"],
        refused: &[
            ("FOR #i := 1 TO 3 DO #i := 5; END_FOR;", "must not be written inside its loop"),
            ("GOTO inner; FOR #i := 1 TO 3 DO inner: ; END_FOR;", "GOTO jumps into the loop"),
        ],
    },
    Row {
        what: "calls",
        works: &["#sub(a := 1, p := #pair, b => #i); #subs[2](a := 1, p := #pair); #i := \"Twice\"(3); #i := \"Twice\"(a := 3, EN := #y);
            ENO := FALSE;"],
        refused: &[],
    },
    Row {
        what: "timers, counters",
        works: &["#timer(IN := TRUE, PT := T#1s); #any.TP(IN := TRUE, PT := T#1s); #ctu(CU := TRUE, R := FALSE, PV := 3);
            #edge(CLK := TRUE); RESET_TIMER(#timer); PRESET_TIMER(PT := T#1s, TIMER := #timer);"],
        refused: &[
            ("#i := S_ODT(T_NO := 1);", "use TON, TOF or TP"),
            ("#i := S_CU(C_NO := 1);", "instead of S5 counters, CTU, CTD or CTUD"),
        ],
    },
    Row {
        what: "functions",
        works: &["#r := LIMIT(MN := 0.0, IN := ABS(#r), MX := SQRT(#one)); #i := MUX(K := #n, IN0 := 1, IN1 := 2); #w := SWAP(SHL(IN := #w, N := 1));
            #r := SCALE_X(MIN := 0.0, VALUE := NORM_X(MIN := 0, VALUE := #i, MAX := 27648), MAX := 100.0); #d := ROUND(#r);
            MOVE_BLK(IN := #a[1], COUNT := 2, OUT => #a[2]); FILL_BLK(IN := 0, COUNT := 3, OUT => #a[1]); #t := TIME_TCK();
            SCATTER(IN := #w, OUT => #flags); #w := DECO(#i); #i := ENCO(#w); #i := BITSUM(#w); #s := CONCAT(IN1 := 'a', IN2 := #s);
            #i := FIND(IN1 := #s, IN2 := 'b'); #s := INT_TO_STRING(#i); S_CONV(IN := #s, OUT => #i); #d := COUNTOFELEMENTS(#a);
            #i := RD_SYS_T(#now); #d := UPPER_BOUND(ARR := #a, DIM := 1);
            #ws := CONCAT(IN1 := #ws, IN2 := 'a'); #ws := STRING_TO_WSTRING(#s); #i := SCALE(IN := #i, HI_LIM := 1.0, LO_LIM := 0.0, BIPOLAR := #y, OUT => #r);
            VAL_STRG(IN := #i, SIZE := 3, PREC := 0, FORMAT := 0, P := 1, OUT => #s); STRG_VAL(IN := #s, FORMAT := 0, P := 1, OUT => #i);
            Strg_TO_Chars(Strg := #s, pChars := 0, Cnt => #i, Chars := #chars); Chars_TO_Strg(Chars := #chars, pChars := 0, Cnt := 0, Strg => #s);
            #t := T_CONV(#d); #i := MOVE_BLK_VARIANT(SRC := #a, COUNT := 1, SRC_INDEX := 0, DEST_INDEX := 2, DEST => #a);
            #i := BLKMOV(SRCBLK := #pair, DSTBLK => #other); BLKMOV(SRCBLK := #a, DSTBLK => #a);"],
        refused: &[
            ("#i := PEEK(area := 16#84, dbNumber := 1, byteOffset := 0);", "assign the variables themselves"),
            ("#i := BLKMOV(SRCBLK := #a, DSTBLK => #pair);", "BLKMOV copies between variables of the same type"),
            ("#i := MOVE_BLK_VARIANT(SRC := #a, COUNT := 1, SRC_INDEX := 0, DEST_INDEX := 0, DEST => #chars);", "found INT and CHAR; copy them in a loop"),
            ("#i := MOVE_BLK_VARIANT(SRC := #a, COUNT := 1, SRC_INDEX := 0, DEST_INDEX := 0, DEST => #i);", "between one-dimensional arrays, found INT"),
            ("#w := GET_ERR_ID();", "stops the FMU, which reports file and line"),
            ("#y := IS_ARRAY(#a);", "write the block once for each type"),
            ("#i := Serialize(SRC_VARIABLE := #pair);", "assign the variables themselves"),
            ("#i := RDREC(REQ := TRUE);", "supply its values through inputs"),
            ("\"MC_Power\"(Axis := 1);", "supply its values through inputs"),
            ("#i := BCD16_TO_INT(#w);", "use INT and TIME"),
        ],
    },
    Row {
        what: "control blocks",
        works: &["#control(PV_IN := 1.0, SP_INT := 2.0, LMN => #r); #pulses(INV := #r, PER_TM := T#1s);"],
        refused: &[(
            "FUNCTION_BLOCK S VAR p : PID_Compact; END_VAR BEGIN END_FUNCTION_BLOCK",
            "its control law is not published",
        )],
    },
];

/// Decided behavior: the row, and statements after which `y` is TRUE.
const DECIDED: &[(&str, &str)] = &[
    ("AND, OR", "#y := FALSE AND \"Count\"(); #y := \"D\".a = 4;"),
    ("FOR, after the loop", "FOR #i := 1 TO 3 DO ; END_FOR; #y := #i = 4;"),
    ("FOR up to the limit of the type", "FOR #small := 120 TO 127 DO #n += 1; END_FOR; #y := #n = 8;"),
    ("a real divided by 0.0", "#r := #one / #zero; #y := #r > 3.4E38 AND NOT (#zero / #zero = #zero / #zero);"),
    ("an integer divided by 0", "#y := 5 / #i = 0 AND 5 MOD #i = 0;"),
    ("denormal numbers", "#r := 1.0E-40; #y := #r > 0.0;"),
    ("the bits of NaN", "#y := (REAL_TO_DWORD(#zero / #zero) AND DW#16#7FC0_0000) = DW#16#7FC0_0000;"),
    ("SIN, EXP, LN, `**` ...", "#r := SIN(#one); #y := #r = 0.84147096;"),
    ("the clock of RD_SYS_T", "#i := RD_SYS_T(#now); #y := #now.YEAR = 2000 AND #now.MONTH = 1 AND #now.HOUR = 0;"),
    (
        "`INT_TO_STRING`, `REAL_TO_STRING`",
        "#y := INT_TO_STRING(123) = '   123' AND REAL_TO_STRING(REAL#1234.5) = ' +1.234500E+03';",
    ),
    (
        "`STRING_TO_INT`",
        "#y := STRING_TO_INT('  12 mm') = 12 AND STRING_TO_INT('mm') = 0 AND STRING_TO_INT('99999') = 0;",
    ),
    (
        "MOVE_BLK_VARIANT, BLKMOV",
        "#a[1] := 7; #i := 5; #i := MOVE_BLK_VARIANT(SRC := #a, COUNT := 1, SRC_INDEX := 0, DEST_INDEX := 2, DEST => #a);
        #y := #i = 0 AND #a[3] = 7 AND BLKMOV(SRCBLK := #pair, DSTBLK => #other) = 0;",
    ),
    (
        "VAL_STRG of a number longer than SIZE",
        "#s := 'abc'; VAL_STRG(IN := 1000, SIZE := 3, PREC := 0, FORMAT := 0, P := 1, OUT => #s); #y := #s = 'abc';",
    ),
    (
        "functions of WSTRING",
        "#ws := 'x'; FOR #i := 1 TO 8 DO #ws := CONCAT(IN1 := #ws, IN2 := #ws); END_FOR; #y := LEN(#ws) = 254;",
    ),
    ("a function with EN = FALSE", "#i := \"Twice\"(EN := FALSE, a := 5); #y := #i = 0;"),
    ("`\"Tag\":P`", "\"Tag\":P := TRUE; #y := \"Tag\";"),
    ("PT = 0", "#timer(IN := TRUE, PT := T#0s); #any.TP(IN := TRUE, PT := T#0s); #y := #timer.Q AND NOT #any.Q;"),
    ("IEC check, *Set ENO automatically*", "#d := 70000; #i := #d; #y := #i = 4464 AND ENO;"),
    ("temporaries read before they are written", "#y := #temp = 0;"),
    ("the type of an untyped constant: `3`, `2.5`", "#wide := 2147483647 + 1; #y := #wide = LINT#2147483648;"),
];

/// Returns the first cells of the table that follows a title on the page.
fn rows(title: &str) -> Vec<String> {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/scl.md")).unwrap();
    let section = page.split(&format!("\n## {title}\n")).nth(1).unwrap_or_else(|| panic!("{title}"));
    let lines = section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    lines.skip(2).map(|line| line.split('|').nth(1).unwrap().trim().to_string()).collect()
}

fn compiled(sample: &str) -> Result<Compiled, String> {
    let is_source = ["FUNCTION", "DATA_BLOCK", "ORGANIZATION_BLOCK"].iter().any(|word| sample.starts_with(word));
    let text = if is_source {
        format!("{AROUND}{sample}")
    } else {
        format!(
            "{AROUND}FUNCTION_BLOCK \"Sample\" {{ S7_Optimized_Access := 'TRUE' }} {VARIABLES} BEGIN\n{sample}\nEND_FUNCTION_BLOCK"
        )
    };
    let block = (!is_source).then(|| "Sample".to_string());
    let options = Options { block, declared: vec![Tag::new("Tag", "Bool")], ..Options::default() };
    compile(&[Source::new("a.scl", text.into())], &options)
        .map_err(|errors| errors.iter().map(|problems| format!("{problems}\n")).collect())
}

#[test]
fn each_row_of_the_language_has_samples_that_work_and_samples_that_are_refused() {
    let known: Vec<&str> = ROWS.iter().map(|row| row.what).collect();
    assert_eq!(rows("The language"), known);
    for row in ROWS {
        for sample in row.works {
            let compiled = compiled(sample).unwrap_or_else(|errors| panic!("{}: {sample}\n{errors}", row.what));
            Ran::new(compiled);
        }
        for (sample, message) in row.refused {
            let errors = compiled(sample).err().unwrap_or_else(|| panic!("{}: {sample} is not refused", row.what));
            assert!(errors.contains(message), "{}: {sample}\nexpected {message}, found\n{errors}", row.what);
        }
    }
}

#[test]
fn what_is_decided_is_done() {
    let known: Vec<&str> = DECIDED.iter().map(|(what, _)| *what).collect();
    assert_eq!(rows("Where the documentation is silent"), known);
    for (what, statements) in DECIDED {
        let compiled = compiled(statements).unwrap_or_else(|errors| panic!("{what}: {statements}\n{errors}"));
        assert!(is_y_true(compiled), "{what}: {statements}");
    }
}
