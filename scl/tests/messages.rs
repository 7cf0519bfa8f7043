//! Errors and warnings: each with its position, the problem and the remedy.

use parameters::{Problems, Source};
use scl::{Cpu, Options, compile};

const HEAD: &str = r#"TYPE "Pair"
   STRUCT
      x : Int;
      y : Int;
   END_STRUCT;
END_TYPE
FUNCTION "Twice" : Int
   VAR_INPUT
      a : Int;
   END_VAR
BEGIN
   #Twice := #a * 2;
END_FUNCTION
FUNCTION_BLOCK "Sub"
{ S7_Optimized_Access := 'TRUE' }
   VAR_INPUT
      a : Int;
   END_VAR
   VAR_OUTPUT
      b : Int;
   END_VAR
   VAR_IN_OUT
      p : "Pair";
   END_VAR
BEGIN
   #b := #a;
END_FUNCTION_BLOCK
"#;

const VARIABLES: &str = r#"   VAR_INPUT
      in : Int;
   END_VAR
   VAR
      flag : Bool; b : Byte; w : Word; dw : DWord; i : Int; d : DInt; u : UInt; r : Real; l : LReal; t : Time;
      s : String[10]; array : Array[1..3] of Int; pair : "Pair"; sub : "Sub"; timer : TON_TIME; any : IEC_TIMER;
   END_VAR
   VAR_TEMP
      temp : Int;
   END_VAR
   VAR CONSTANT
      TEN : Int := 10;
   END_VAR
"#;

fn lines(problems: &[Problems]) -> Vec<String> {
    problems.iter().flat_map(|problems| problems.to_string().lines().map(str::to_string).collect::<Vec<_>>()).collect()
}

/// Returns the errors and the warnings of a text.
fn told(text: &str, cpu: Option<Cpu>) -> (Vec<String>, Vec<String>) {
    let source = Source::new("a.scl", text.into());
    match compile(&[source], &Options { cpu, ..Options::default() }) {
        Ok(compiled) => (Vec::new(), lines(&compiled.warnings)),
        Err(errors) => (lines(&errors), Vec::new()),
    }
}

#[test]
fn tags_that_share_memory_are_named() {
    let of = |start: &str| {
        let text = format!(
            "VAR_GLOBAL\n  Cmd AT %MW10 : Word;\n  Start AT {start} : Bool;\nEND_VAR\nFUNCTION_BLOCK F\nVAR_OUTPUT y : Bool; \
             END_VAR\nBEGIN\n  \"Cmd\" := 1;\n  #y := \"Start\";\nEND_FUNCTION_BLOCK\n"
        );
        told(&text, None).1
    };
    let warned = of("%M11.0");
    assert!(warned[0].contains("separate variables in the FMU: Cmd (%MW10) and Start (%M11.0)"), "{warned:?}");
    assert_eq!(of("%M12.0"), [""; 0]);
}

/// A program with these declarations and statements; the statements begin in the line that is returned.
fn program(declarations: &str, statements: &str) -> (String, usize) {
    let before = format!("{HEAD}FUNCTION_BLOCK \"Main\"\n{VARIABLES}{declarations}BEGIN\n");
    let line = before.lines().count() + 1;
    (format!("{before}{statements}\nEND_FUNCTION_BLOCK\n"), line)
}

#[track_caller]
fn refused(statements: &str, says: &str) {
    let (text, line) = program("", statements);
    let (errors, _) = told(&text, None);
    let place = format!("a.scl:{line}:");
    assert!(
        errors.len() == 1 && errors[0].starts_with(&place) && errors[0].contains(says),
        "{statements}\n{errors:#?}"
    );
}

#[track_caller]
fn undeclarable(member: &str, says: &str) {
    let (text, _) = program(&format!("   VAR\n{member}\n   END_VAR\n"), "");
    let (errors, _) = told(&text, None);
    assert!(errors.len() == 1 && errors[0].contains(says), "{member}\n{errors:#?}");
}

#[track_caller]
fn warned(statements: &str, says: &str) {
    let (text, line) = program("", statements);
    let (errors, warnings) = told(&text, None);
    assert_eq!(errors, Vec::<String>::new(), "{statements}");
    let place = format!("a.scl:{line}:");
    let found = warnings.iter().filter(|warning| warning.starts_with(&place)).collect::<Vec<_>>();
    assert!(found.len() == 1 && found[0].contains(says), "{statements}\n{warnings:#?}");
}

#[track_caller]
fn silent(statements: &str) {
    let (text, _) = program("", statements);
    assert_eq!(told(&text, None), (Vec::new(), Vec::new()), "{statements}");
}

#[test]
fn what_has_no_value_outside_of_a_plc_is_refused() {
    let address = "an absolute address has no value in an FMU; make it an input of the block";
    for statement in ["#flag := I0.0;", "DB5.DBW2 := 1;", "\"D\".%DBX0.0 := TRUE;"] {
        refused(statement, address);
    }
    refused("#flag := %I0.0:P;", &format!("{address}, or declare a tag there: \"I0_0\" AT %I0.0 : BOOL"));
    refused("#w := %MW10;", &format!("{address}, or declare a tag there: \"MW10\" AT %MW10 : WORD"));
    refused("#w := MW10;", &format!("{address}, or declare a tag there: \"MW10\" AT %MW10 : WORD"));
    refused(
        "DEMUX(K := #i, IN := #i, OUT0 => #i);",
        "DEMUX is not supported; use CASE to write the output selected by K",
    );
    refused(
        "#i := PEEK(area := 16#84, dbNumber := 1, byteOffset := 0);",
        "PEEK is not supported; assign the variables themselves",
    );
    refused(
        "\"MC_Power\"(Axis := 1);",
        "MC_POWER accesses the PLC's hardware or system; supply its values through inputs",
    );
    refused("\"Fill\"();", "no source declares the function \"Fill\"");
    refused("#i := RDREC(REQ := TRUE);", "accesses the PLC's hardware or system");
    refused("#i := S_ODT(T_NO := 1);", "use TON, TOF or TP");
    refused("#t := S5T#2S;", "expected a TIME instead of an S5TIME, found `S5T#2S`; use TON, TOF or TP with T#");
    refused("#i := BCD16_TO_INT(#w);", "instead of BCD and S5TIME, use INT and TIME");
    refused("#i := #i^;", "references (^) are not supported; pass the variable itself, or ARRAY[*]");
    refused("#i ?= 1;", "assignment attempts (?=) are not supported");
    refused("#i := P#DB1.DBX0.0;", "expected a value instead of a pointer");
}

#[test]
fn types_without_a_meaning_here_are_refused() {
    for of in ["Variant", "Any", "Pointer", "DB_ANY", "REF_TO Int"] {
        undeclarable(
            &format!("x : {of};"),
            "is not supported; pass the variable itself; for an array of any length, declare ARRAY[*]",
        );
    }
    for of in ["S5Time", "Timer", "Counter"] {
        undeclarable(&format!("x : {of};"), "use IEC timers and counters: TON, TOF, TP, CTU, CTD, CTUD");
    }
    undeclarable("x : TO_SpeedAxis;", "it depends on hardware: supply its values through inputs");
    undeclarable("x : PID_Compact;", "its control law is not published; use one of CONT_C");
    undeclarable("x : Array[3..1] of Int;", "3..1 is not a range of DINT values; write the lower bound first");
    undeclarable("x : Array[0..2000000000] of LReal;", "this array needs more than 64 MiB, more than any CPU has");
    undeclarable("x : Array[0..1] of Array[0..1] of Int;", "use multiple dimensions");
    undeclarable("x : Int := 'text';", "expected INT, found a string");
    undeclarable("x : Array[0..1] of Int := [1, 2, 3];", "more start values than elements: the array has 2");
    undeclarable("x : Array[0..1] of Int := [5(1)];", "more start values than elements");
    undeclarable("i : Int;", "i is declared twice; rename or delete one of them");
    undeclarable("x : Struct speed : Int; END_STRUCT := (sped := 1);", "has no member sped; did you mean speed?");
    undeclarable("x : CONT_C := (GIAN := 2.5);", "the instance has no member GIAN; did you mean GAIN?");
    undeclarable("x : \"Main\";", "Main contains an instance of itself");
}

#[test]
fn types_that_do_not_fit_are_refused() {
    refused("#flag := #i;", "INT cannot be converted implicitly to BOOL; write INT_TO_BOOL(...)");
    refused("#i := #flag;", "BOOL cannot be converted implicitly to INT; write BOOL_TO_INT(...)");
    refused("IF #i THEN #i := 0; END_IF;", "a condition must be a BOOL, not INT; compare it, for example with `<> 0`");
    refused("#r := #t;", "TIME cannot be converted implicitly to REAL; convert through DINT");
    refused("#t := #t * #r;", "* cannot be applied to TIME and REAL");
    refused("#t := #t * #t;", "* cannot be applied to TIME and TIME; add TIME to TIME");
    refused(
        "#t := DATE_TO_TIME(D#2024-02-28);",
        "there is no function DATE_TO_TIME; a date is not a duration: subtract another date from it",
    );
    refused("#i := TIME_TO_DATE(#t);", "there is no function TIME_TO_DATE; a time has no date: combine it with one");
    refused("#flag := #flag AND #i;", "AND cannot be applied to BOOL and INT; both sides must be BOOL");
    refused("#r := #r MOD 2.0;", "MOD needs integers");
    refused("#i := #array;", "expected INT, found ARRAY[1..3] OF INT");
    refused("#pair := #array;", "expected \"Pair\", found ARRAY[1..3] OF INT");
    refused("#i := #array[4];", "index 4 is outside 1..3");
    refused("#i := #array[1, 2];", "wrong number of indices: 2 instead of 1");
    refused("#i := #i[1];", "INT has no elements");
    refused("#i := #array[#r];", "an index must be an integer, not a REAL");
    refused("#i := #pair.z;", "\"Pair\" has no member z");
    refused("#flag := #w.%X16;", "WORD has no member %X16");
    refused("#TEN := 1;", "a constant cannot be written");
    refused("#i := 10ms;", "a duration begins with T#");
    refused("#r := -#r ** 2.0;", "write -(a ** b) or (-a) ** b");
    refused("CASE #r OF 1: ; END_CASE;", "CASE selects by an integer or a bit string, not by REAL; use IF");
    refused("FOR #r := 1 TO 2 DO ; END_FOR;", "a loop variable must be an integer, not REAL");
    refused("FOR #i := 1 TO 2 BY 0 DO ; END_FOR;", "a loop with step 0 never ends");
    refused("FOR #i := 1 TO 2 DO #i := 3; END_FOR;", "the loop variable i must not be written inside its loop");
    refused("EXIT;", "EXIT is not inside a loop; to leave the block, use RETURN");
    refused("GOTO L1;", "no label L1 in this block");
    refused("GOTO L1; WHILE #flag DO L1: #i := 1; END_WHILE;", "GOTO jumps into the loop that contains the label L1");
}

#[test]
fn calls_that_do_not_fit_are_refused() {
    refused("#sub(c := 1, p := #pair);", "Sub has no parameter c; it has a, b, p");
    refused("#sub(a => #i, p := #pair);", "a must be passed with :=");
    refused("#sub(b := #i, p := #pair);", "b must be passed with =>");
    refused("#sub(a := 1);", "the in-out parameter p is missing");
    refused("#sub(a := 1, p := #array);", "p is a \"Pair\", not an ARRAY[1..3] OF INT");
    refused("#i := \"Twice\"();", "Twice is called without a; every parameter of a function must be passed");
    refused("#i := \"Twice\"(#i, #i);", "the parameters of Twice must be passed by name");
    refused("\"Sub\"(a := 1);", "Sub is called without an instance; declare an instance");
    refused(
        "#i := #sub(a := 1, p := #pair);",
        "an instance of Sub has no value; call it as a statement and read its outputs",
    );
    refused("#timer.CTU(CU := TRUE);", "cannot be called as CTU");
    refused("#i();", "INT cannot be called");
    refused("#y := 1;", "#y is not declared in this block");
    refused("#tmer(IN := TRUE);", "#tmer is not declared in this block");
}

#[test]
fn names_that_no_source_declares_are_told_with_what_to_do() {
    refused(
        "#flag := \"Start\";",
        "no source declares the tag \"Start\" : BOOL; --tag \"Start : BOOL\" makes it an input or output",
    );
    refused("IF \"A\" AND NOT \"B\" THEN \"C\" := 2.5; END_IF;", "the tags \"A\" : BOOL, \"B\" : BOOL, \"C\" : REAL;");
    refused("\"Data\".x := \"Data\".y[1].z;", "the data block \"Data\": Data.x, Data.y; export this DB as a source");
    refused(
        "\"Other\"(x := 1);",
        "no source declares the function \"Other\"; in TIA Portal: Generate source from blocks",
    );
    refused(
        "\"Motor_DB\"(x := 1);",
        "no source declares the instance \"Motor_DB\"; name the block it is an instance of",
    );
    // Of many names, ten are listed, with the command that lists the rest.
    let many = |name: &str| (1..=12).map(|at| format!("#i := \"{name}{at:02}\";")).collect::<String>();
    let rest = "and 2 more; plcfmu check --assume lists them all, with the declarations their use implies";
    refused(&many("Tag"), &format!("\"Tag10\" : INT, {rest}"));
    refused(&many("Data\".\"m"), &format!("Data.m10, {rest}"));
    let calls: String = (1..=12).map(|at| format!("\"Other{at:02}\"();")).collect();
    let (errors, _) = told(&program("", &calls).0, None);
    assert_eq!(errors.len(), 11);
    let rest = "no source declares 2 more functions; plcfmu check --assume lists them all";
    assert!(errors[10].contains(rest), "{}", errors[10]);
    // The last of eleven is named like the others.
    let calls: String = (1..=11).map(|at| format!("\"Other{at:02}\"();")).collect();
    let (errors, _) = told(&program("", &calls).0, None);
    assert!(errors.len() == 11 && errors[10].contains("\"Other11\""), "{errors:?}");
    undeclarable(
        "x : \"typeMotor\";",
        "no source declares the type \"typeMotor\"; in TIA Portal: Generate source from blocks",
    );
    undeclarable("x : \"Pairs\";", "no source declares the type \"Pairs\"; did you mean \"Pair\"?");
    // Where only a constant is allowed, the name is not a tag.
    let constant = "no source declares the constant \"MOST\"; --constant MOST=5 declares it";
    undeclarable("x : Array[1..\"MOST\"] of Int;", constant);
    undeclarable("x : Int := \"MOST\";", constant);
    // The type inferred from its use is assumed.
    silent("\"X\".TON(IN := TRUE, PT := T#1s); #flag := \"X\".Q;");
    silent("\"R_TRIG_DB_1\"(CLK := #flag, Q => #flag);");
    warned("\"Sub_DB\"(a := 1, p := #pair);", "no source declares \"Sub_DB\": it is assumed to be an instance of Sub");
    refused(
        "\"X\".TON(IN := TRUE, PT := T#1s); \"X\".TOF(IN := TRUE, PT := T#1s);",
        "X is called both as TON and as TOF",
    );
}

#[test]
fn addresses_of_step_7_are_told_as_such_and_a_call_names_its_block() {
    let address = "an absolute address has no value in an FMU; make it an input of the block";
    for read in ["DB11.DX[6,0]", "DB11.DBX[6,1]", "DB21.DBX7.7", "WORD_TO_BLOCK_DB(w).DX[i,0]"] {
        refused(&format!("flag := {read};"), address);
    }
    refused("FB7.DB10(a := 1);", "no source declares the function block \"FB7\"; in TIA Portal");
    // These belong to the CPU: they have no source.
    for call in ["READ_BIG(SRC_ARRAY := array)", "GetBlockName(SIZE := 1)", "WAIT(WT := 1)"] {
        let name = call.split('(').next().unwrap_or_default().to_uppercase();
        refused(&format!("i := {call};"), &name);
    }
}

#[test]
fn blocks_that_cannot_be_are_refused() {
    let (errors, _) = told("FUNCTION_BLOCK \"A\"\nKNOW_HOW_PROTECT\nBEGIN\nEND_FUNCTION_BLOCK\n", None);
    assert_eq!(
        errors,
        [
            "a.scl:2:1: A: protected block without source code; ask its author for the source, or use only its interface with --stub A"
        ]
    );
    let (errors, _) =
        told("TYPE \"A\"\nSTRUCT x : Int; END_STRUCT;\nEND_TYPE\nDATA_BLOCK \"a\"\nBEGIN\nEND_DATA_BLOCK", None);
    assert_eq!(errors, ["a.scl:4:12: a is declared twice: first in a.scl:1; rename or delete one of them"]);
    let (errors, _) = told("FUNCTION \"A\" : Void\nBEGIN\nNETWORK\nTITLE =\n  A I0.0;\nEND_FUNCTION", None);
    assert!(errors[0].starts_with("a.scl:3:1: this block is in STL or LAD, not in SCL"), "{errors:#?}");
    let two =
        "FUNCTION \"A\" : Void\nBEGIN\n\"B\"();\nEND_FUNCTION\nFUNCTION \"B\" : Void\nBEGIN\n\"A\"();\nEND_FUNCTION";
    let (errors, _) = told(two, None);
    assert!(errors.iter().any(|error| error == "a.scl:7:1: A calls itself through B; use a loop"), "{errors:#?}");
}

#[test]
fn what_may_surprise_is_told() {
    warned(
        "#d := #i * 1000;",
        "this is computed in INT and may overflow before it is converted to DINT; convert an operand first",
    );
    warned("#r := #i / 2;", "integer division: the fraction is lost before the result becomes REAL");
    warned("#r := #i * 0.1;", "LREAL is converted to REAL: the value is rounded");
    warned(
        "#i := INT#1 + 50000;",
        "50000 does not fit in INT: it becomes -15536; use a wider type for the variable, such as DINT",
    );
    warned(
        "#i := DINT#40000;",
        "40000 does not fit in INT: it becomes -25536; use a wider type for the variable, such as DINT",
    );
    warned("#i := #d;", "DINT is converted to INT: the high bits are lost");
    warned("#u := #i;", "INT is converted to UINT: a negative number becomes a large one");
    warned(
        "#i := #r;",
        "REAL is converted to INT: the value is rounded, and its high bits are lost if it does not fit",
    );
    warned("#r := #dw;", "DWORD is converted to REAL: the value is converted, not the bit pattern");
    warned("#flag := #r = 0.1;", "REAL values are compared for equality; rounding may keep them from being equal");
    warned("#flag := #r < #l;", "REAL is compared with LREAL");
    warned("#i := #temp;", "the temporary temp may be read before it is written; if so, it is 0");
    warned("IF #flag THEN #temp := 1; END_IF; #i := #temp;", "the temporary temp may be read before it is written");
    warned("CASE #i OF 1..3: ; 2: ; END_CASE;", "this CASE value occurs twice: the first one applies");
    warned(
        "#timer(IN := #flag, PT := T#1s); #timer(IN := TRUE, PT := T#1s);",
        "#timer is called a second time in this cycle",
    );
    warned("#i := #i / 0;", "division by 0: the result is 0");
    warned("#i := #i MOD 0;", "division by 0: the result is 0");
    warned("WHILE TRUE DO #i := 1; END_WHILE;", "this loop never ends; leave it with EXIT or RETURN");
    warned("REPEAT #i := 1; UNTIL FALSE END_REPEAT;", "this loop never ends");
    silent("WHILE TRUE DO IF #flag THEN EXIT; END_IF; END_WHILE;");
    silent("REPEAT #i := 1; UNTIL TRUE END_REPEAT;");
    warned("#in := 1;", "an input is written, but the caller does not see the change");
    warned(
        "FOR #i := 1 TO 32767 DO ; END_FOR;",
        "the loop counts to the limit of INT: it ends in the FMU, but perhaps not on a CPU",
    );
    warned("#i := LIMIT_REAL(MN := 0.0, IN := #r, MX := 5);", "REAL is converted to INT: the value is rounded");
    warned("ABS(#i);", "the value of ABS is not used");
}

#[test]
fn what_is_clear_is_not_told() {
    silent("#d := INT_TO_DINT(#i) * 1000; #r := #r * 0.1 + 2; #w := 16#FFFF; #i := -32768; #i := W#16#FFFF;");
    silent("IF #flag THEN #temp := 1; ELSE #temp := 2; END_IF; #i := #temp;");
    silent("FOR #temp := 1 TO 3 DO #array[#temp] := #temp; END_FOR; #b := 255; #t := T#1s * 2 + #t / 3;");
    silent("CASE #i OF #TEN: #r := 1; 0..5, 7: #r := 2; ELSE #r := 3; END_CASE; #pair := #pair; #s := 'text';");
    silent(
        "IF #s = 'text' AND #s[1] = 't' THEN #flag := 1; END_IF; #any.TON(IN := #flag, PT := T#1s); #flag := #any.Q;",
    );
}

#[test]
fn the_dialect_of_step_7_has_its_own_rules() {
    let text = "FUNCTION_BLOCK FB1\nVAR_TEMP\n i : INT;\nEND_VAR\nBEGIN\nFOR i := 1 TO 3 DO\n i := i;\nEND_FOR;\nEND_FUNCTION_BLOCK";
    let (errors, warnings) = told(text, None);
    assert_eq!(errors, Vec::<String>::new());
    assert_eq!(warnings, ["a.scl:7:2: the loop variable i is written inside its loop: the new value is used"]);
    let (errors, _) = told(text, Some(Cpu::S71500));
    assert_eq!(errors.len(), 1);
}

#[test]
fn all_errors_of_all_sources_are_told_at_once() {
    let source = |name: &str, text: &str| Source::new(name, text.into());
    let sources = [
        source("a.scl", "FUNCTION_BLOCK \"A\"\nVAR x : Foo; END_VAR\nBEGIN\n#y := 1;\n#x := ;\nEND_FUNCTION_BLOCK"),
        source("b.udt", "TYPE \"B\"\nSTRUCT\n z : Variant;\nEND_STRUCT;\nEND_TYPE"),
    ];
    let errors = lines(&compile(&sources, &Options::default()).unwrap_err());
    let places: Vec<&str> = errors.iter().map(|error| error.split(": ").next().unwrap()).collect();
    assert_eq!(places, ["a.scl:2:9", "a.scl:4:1", "a.scl:5:7", "b.udt:3:6"]);
}

#[test]
fn the_value_of_a_function_has_its_name_with_a_hash() {
    let (errors, _) = told("FUNCTION \"F\" : Int\nBEGIN\n\"F\" := 3;\nEND_FUNCTION\n", None);
    assert_eq!(errors, ["a.scl:3:1: F is a block, not a variable; its return value is #F"]);
}

#[test]
fn an_instance_of_the_block_itself_is_told_where_it_is_declared() {
    let text = "FUNCTION_BLOCK \"A\"\nVAR\n  b : \"B\";\nEND_VAR\nBEGIN\nEND_FUNCTION_BLOCK
FUNCTION_BLOCK \"B\"\nVAR\n  a : \"A\";\nEND_VAR\nBEGIN\nEND_FUNCTION_BLOCK\n";
    assert_eq!(told(text, None).0, ["a.scl:9:7: A contains an instance of itself"]);
}

#[test]
fn a_file_without_a_block_and_one_that_is_no_text_are_refused() {
    for text in ["", "// nothing yet\n"] {
        let message = "a.scl:1:1: no block is declared here; declare one, for example with FUNCTION_BLOCK";
        assert_eq!(told(text, None).0, [message], "{text}");
    }
    let no_mark: Vec<u8> = "FUNCTION".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [no_mark, b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec()] {
        let errors = compile(&[Source::new("a.scl", bytes)], &Options::default()).unwrap_err();
        let errors = lines(&errors);
        let says = "this is not text: it contains a null character; save the source as text in UTF-8";
        assert!(errors.len() == 1 && errors[0].contains(says), "{errors:#?}");
    }
}

#[test]
fn typical_slips_are_told_as_what_they_are() {
    let all = |statements: &str| told(&program("", statements).0, None).0.join("\n");
    let line = program("", "").1;
    for (statements, says) in [
        ("#i = 1;", "this comparison has no effect; write := to assign".to_string()),
        ("IF #i == 1 THEN ; END_IF;", "SCL has no ==; = compares, := assigns".into()),
        ("IF #flag THEN ; ELSEIF #flag THEN ; END_IF;", "SCL has no ELSEIF; write ELSIF".into()),
        ("#i := 1;\nIF #flag THEN\n#i := 2;", format!("the IF on line {} is not closed", line + 1)),
        ("CASE #i OF\n1: #i := 2;", format!("the CASE on line {line} is not closed")),
        ("WHILE #flag DO\n#i := 2;", format!("the WHILE on line {line} is not closed")),
        ("FOR #i := 1 TO 3 DO\n;", format!("the FOR on line {line} is not closed")),
    ] {
        let found = all(statements);
        assert!(found.contains(&says) && found.lines().count() == 1, "{statements}\n{found}");
    }
}

#[test]
fn an_argument_that_a_function_does_not_have_is_refused() {
    for (statement, says) in [
        ("#r := SQRT(#r, #r);", "SQRT has no parameter for this argument"),
        ("#w := SHL(IN := #w, N := 1, FOO := 1);", "SHL has no parameter FOO"),
        ("#r := LIMIT(MN := 0.0, IN := #r, MX := 1.0, MAX := 2.0);", "LIMIT has no parameter MAX"),
        ("#i := REAL_TO_INT(#r, #r);", "REAL_TO_INT has no parameter for this argument"),
        ("#s := LEFT(IN := #s, L := 2, P := 3);", "LEFT has no parameter P"),
    ] {
        refused(statement, says);
    }
    silent("#r := LIMIT(MN := 0.0, IN := #r, MX := 1.0); #i := MIN(#i, 1, 2, 3); #s := LEFT(IN := #s, L := 2);");
}

#[test]
fn a_comment_in_a_comment_is_read_to_its_end_with_a_warning() {
    let warning = "a nested comment";
    warned("#i := 1; (* a (* b *) #i := ; *)", warning);
    // In hand-written code that closes the comment only once, the inner mark is text.
    silent("#i := 1; (* a (* b *) #flag := TRUE;");
}

#[test]
fn a_missing_type_is_not_said_to_be_a_function() {
    let (errors, _) = told(
        "FUNCTION Motor : INT BEGIN ; END_FUNCTION FUNCTION_BLOCK f VAR x : Motr; END_VAR BEGIN ; END_FUNCTION_BLOCK",
        None,
    );
    assert!(errors.len() == 1 && !errors[0].contains("did you mean"), "{errors:#?}");
    refused("#r := Filter_PT1(#r);", "FILTER_PT1 is not supported");
    refused("T_COMP(IN1 := #t);", "T_COMP is not supported");
}
