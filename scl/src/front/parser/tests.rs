use super::*;
use parameters::Source;
use proptest::prelude::*;
use std::sync::OnceLock;

/// Returns the sources of the cases.
fn cases() -> &'static [(String, String)] {
    static CASES: OnceLock<Vec<(String, String)>> = OnceLock::new();
    CASES.get_or_init(read_cases)
}

fn read_cases() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let cases = value["cases"].as_array().cloned().unwrap_or_else(|| vec![value.clone()]);
        found.extend(
            cases
                .iter()
                .map(|case| (case["name"].as_str().unwrap().to_string(), case["scl"].as_str().unwrap().to_string())),
        );
    }
    found
}

/// Returns the errors of a text, one per line.
fn errors(text: &str) -> String {
    let source = Source::new("a.scl", text.into());
    let mut report = Report::default();
    parse(&source.text, 0, &mut report);
    report.problems(&[source]).0.iter().map(|problems| format!("{problems}\n")).collect()
}

fn in_body(statements: &str) -> String {
    format!("FUNCTION_BLOCK \"F\"\nBEGIN\n{statements}\nEND_FUNCTION_BLOCK\n")
}

#[test]
fn all_cases_are_read() {
    let cases = cases();
    assert!(cases.len() >= 160);
    for (name, text) in cases {
        assert_eq!(errors(text), "", "{name}");
    }
}

#[test]
fn what_real_exports_contain_is_read() {
    let text = r#"
TYPE "T" VERSION : 0.1
   STRUCT // c
      "a b" { S7_SetPoint := 'False'} : Array[0..3, 1.."N"] of Struct (* c *)
         x : Bool := true;   // c
      END_STRUCT := [4((x := FALSE))];
      t {InstructionName := 'TON_TIME'; LibVersion := '1.0'} : TON_TIME;
   END_STRUCT;
END_TYPE

DATA_BLOCK "D" { S7_Optimized_Access := 'TRUE' } AUTHOR : Me Myself VERSION : 0.1 NON_RETAIN
"F"
BEGIN
   a.b[1] := 16#FF;
END_DATA_BLOCK

DATA_BLOCK DB 5 TITLE = it's a title
  STRUCT
   f : ARRAY [1..3] OF REAL := 1.0, 2(0.5);
   s : STRING [20] := 'it$'s';
  END_STRUCT ;
BEGIN
END_DATA_BLOCK

FUNCTION "f" : Void
TITLE = no 'end
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
//Comment
   VAR_INPUT RETAIN
      EN1 : Int; IN : Real;
   END_VAR
   VAR DB_SPECIFIC
      p {EXTERNALWRITABLE := 'false'} AT IN : DWord;
   END_VAR
   VAR CONSTANT
      K : Int := -3 + 2 * 4;
   END_VAR
BEGIN
   {PRAGMA_BEGIN x}
	REGION Anything goes 'here
	IF #a THEN ; END_IF // no semicolon
	#b := 1;
	END_REGION done
	#a.TON(IN := #IN >= 5.0 AND NOT #x, PT := T#2S, Q => #"q q"[1].z.%X3, ET => );
	CASE #s OF
	  "K", 3..5, -1: #s := #K ** -2;
	  #C.x: "DB".x."y z"[#i + 1, 2] += FB10.y;
	  'a': ;
	  ELSE: RETURN;
	END_CASE;
	FOR #i := 0 TO 5 BY -1 DO CONTINUE; END_FOR;
	{PRAGMA_END}
	L1: GOTO L1;
END_FUNCTION
"#;
    assert_eq!(errors(text), "");
}

#[test]
fn every_statement_with_an_error_is_told() {
    let text = in_body("#a := ;\n#b := 1 +;\nIF #c > THEN #d := 1; END_IF;\n#e = 1;\n#f := (1;\n#g := 1;\nFOO;");
    assert_eq!(
        errors(&text),
        "a.scl:3:7: expected an expression, found `;`\n\
         a.scl:4:10: expected an expression, found `;`\n\
         a.scl:5:9: expected an expression, found `THEN`\n\
         a.scl:6:1: this comparison has no effect; write := to assign\n\
         a.scl:7:9: expected `)`, found `;`\n\
         a.scl:9:4: expected `:=`, found `;`\n"
    );
}

#[test]
fn a_sign_before_a_power_needs_brackets() {
    assert!(errors(&in_body("#a := -#b ** 2.0;")).contains("write -(a ** b) or (-a) ** b"));
    assert_eq!(errors(&in_body("#a := (-#b) ** 2.0 - #c ** -1;")), "");
}

#[test]
fn no_depth_is_too_deep() {
    let deep =
        |open: &str, close: &str| errors(&in_body(&format!("#a := {}1{};", open.repeat(50_000), close.repeat(50_000))));
    for (open, close) in [("(", ")"), ("-", ""), ("NOT ", ""), ("#a[", "]"), ("f(x := ", ")"), ("2 ** (", ")")] {
        let told = deep(open, close);
        assert!(told.contains("more than 100 levels of nesting") && told.lines().count() == 1, "{open}\n{told}");
    }
    assert!(deep("1 + ", "").contains("more than 300 chained operators"));
    let members = in_body(&format!("#a{} := 1;", ".b".repeat(50_000)));
    assert!(errors(&members).contains("more than 300 chained operators"));
    let told = errors(&in_body(&"IF #a THEN ".repeat(50_000)));
    assert!(told.contains("more than 100 levels") && told.lines().count() == 1, "{told}");
    let structures = format!("TYPE \"T\" {} END_TYPE", "STRUCT a : ".repeat(50_000));
    assert!(errors(&structures).contains("more than 100 levels"));
    let starts = format!("TYPE \"T\" STRUCT a : INT := {} END_TYPE", "[".repeat(50_000));
    assert!(errors(&starts).contains("more than 100 levels"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        errors(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn any_words_are_read(words in prop::collection::vec(prop::sample::select(&[
        "FUNCTION_BLOCK", "a", "VAR", "END_VAR", ":", ":=", ";", "STRUCT", "END_STRUCT", "(", ")", "[", "]", "IF", "THEN",
        "END_IF", "CASE", "OF", "1", "..", ",", "END_CASE", "#x", "\"y\"", "'", "T#1s", "{", "}", "(*", "*)", "//", "\n",
        "BEGIN", "END_FUNCTION_BLOCK", "DATA_BLOCK", "TYPE", "FOR", "TO", "DO", "=>", "REGION", "GOTO", "+", "NOT",
        "CONST", "END_CONST", "LABEL", "END_LABEL", "ARRAY", "REF_TO", "STRING", "ELSE", "END_TYPE", "%I0.0",
    ][..]), 0..80)) {
        errors(&words.join(" "));
    }

    #[test]
    fn a_damaged_program_is_read(case: prop::sample::Index, cut: prop::sample::Index, at: prop::sample::Index, with in "[;:()'\"{}*/#A-Z ]{0,3}") {
        let cases = cases();
        let (_, text) = case.get(cases);
        let cut = text.floor_char_boundary(cut.index(text.len()));
        let at = text.floor_char_boundary(at.index(text.len()));
        errors(&text[..cut]);
        errors(&format!("{}{with}{}", &text[..cut], &text[at..]));
    }
}
