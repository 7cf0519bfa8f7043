//! The interface of a program's FMU.

use parameters::Source;
use parameters::tags::{Declared, Tag, declaration};
use scl::interface::{Role, Variable};
use scl::ir::{Scalar, Type};
use scl::machine::{Code, Machine};
use scl::{Options, compile};
use std::sync::Arc;

const PROGRAM: &str = r#"
TYPE "Limits"
   STRUCT
      high { S7_SetPoint := 'True'} : Real := 80.0;   // unit: bar
      low : Real;
   END_STRUCT;
END_TYPE
DATA_BLOCK "Plant"
   VAR
      speed : Int := 7;
      counts : Array[1..2] of Int;
   END_VAR
BEGIN
END_DATA_BLOCK
FUNCTION_BLOCK "Main"
{ S7_Optimized_Access := 'TRUE' }
   VAR_INPUT
      level : Real;   // of the tank; unit: %, min 0, max 100
      gain { S7_SetPoint := 'True'} : Real := 2.0;
      on : Array[1..2] of Bool;
   END_VAR
   VAR_OUTPUT
      name : String[8];
      out : Word;
   END_VAR
   VAR_IN_OUT
      total : DInt;
   END_VAR
   VAR RETAIN
      limits : "Limits";
      secret { ExternalVisible := 'False'} : Int;
      timer : TON_TIME;
   END_VAR
   VAR_TEMP
      i : Int;
   END_VAR
   VAR CONSTANT
      TEN : Int := 10;
   END_VAR
BEGIN
   #out := INT_TO_WORD("Plant".speed);
   "Plant".counts[1] := #TEN;
   "Lamp" := "Button";
END_FUNCTION_BLOCK
"#;

fn shown(variables: &[Variable]) -> Vec<(&str, &str, Role)> {
    variables.iter().map(|variable| (variable.name.as_str(), variable.of, variable.role)).collect()
}

#[test]
fn each_number_of_a_block_has_a_name_a_type_and_a_role() {
    let tag = |name: &str| Tag::new(name, "Bool");
    let options = Options { declared: vec![tag("Lamp"), tag("Button")], ..Options::default() };
    let compiled = compile(&[Source::new("main.scl", PROGRAM.into())], &options).unwrap();
    let root = compiled.root.unwrap();
    let variables = shown(&root.variables);
    assert_eq!(
        variables[..11],
        [
            ("level", "REAL", Role::Input),
            ("gain", "REAL", Role::Parameter),
            ("on[1]", "BOOL", Role::Input),
            ("on[2]", "BOOL", Role::Input),
            ("name", "STRING", Role::Output),
            ("out", "WORD", Role::Output),
            ("total", "DINT", Role::InOut),
            ("limits.high", "REAL", Role::Parameter),
            ("limits.low", "REAL", Role::Local),
            ("secret", "INT", Role::Local),
            ("timer.IN", "BOOL", Role::Local),
        ]
    );
    assert!(variables.iter().all(|(name, ..)| !["i", "TEN"].contains(name)));
    let hidden: Vec<&str> = root.variables.iter().filter(|of| of.is_hidden).map(|of| of.name.as_str()).collect();
    assert_eq!(hidden, ["secret"]);
    let level = &root.variables[0].comment;
    assert_eq!((level.text.as_str(), level.unit.as_deref()), ("of the tank", Some("%")));
    assert_eq!((level.min, level.max), (Some(0.0), Some(100.0)));
    assert_eq!(root.variables[7].comment.unit.as_deref(), Some("bar"));
    assert!(root.variables[7].is_retained && !root.variables[0].is_retained);
    // Each variable has its own place in the memory.
    for variable in &root.variables {
        let path = format!("{}.{}", root.instance, variable.name);
        assert_eq!(compiled.program.find(&path), Some((variable.offset, variable.ty.clone())), "{path}");
    }
    assert_eq!(root.variables[5].ty, Type::Scalar(Scalar::U16));
    assert_eq!(
        shown(&compiled.globals),
        [
            ("Plant.speed", "INT", Role::Parameter),
            ("Plant.counts[1]", "INT", Role::Local),
            ("Plant.counts[2]", "INT", Role::Parameter),
            ("Lamp", "BOOL", Role::Output),
            ("Button", "BOOL", Role::Input),
        ]
    );
}

#[test]
fn a_structured_in_out_of_the_block_that_is_run_has_a_variable_of_its_own() {
    let source = "TYPE Pair STRUCT a : INT; b : REAL := 2.5; END_STRUCT; END_TYPE
        FUNCTION_BLOCK B VAR_IN_OUT p : Pair; s : STRING; END_VAR VAR_OUTPUT y : REAL; n : INT; END_VAR
        BEGIN p.a := p.a + 1; y := p.b; s := CONCAT(IN1 := s, IN2 := 'x'); n := LEN(s); END_FUNCTION_BLOCK";
    let compiled = compile(&[Source::new("b.scl", source.into())], &Options::default()).unwrap();
    let root = compiled.root.unwrap();
    let mut machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
    for _ in 0..3 {
        machine.call(root.cycle, 0).unwrap();
    }
    let get = |path: &str, of: Scalar| machine.get(of, compiled.program.find(path).unwrap().0);
    assert_eq!(get("p.a", Scalar::I16), 3_i16.into());
    assert_eq!(get("B.y", Scalar::F32), 2.5_f32.into());
    assert_eq!(get("B.n", Scalar::I16), 3_i16.into());
    assert_eq!(
        shown(&compiled.globals),
        [("p.a", "INT", Role::Local), ("p.b", "REAL", Role::Local), ("s", "STRING", Role::Local)]
    );

    let source = "FUNCTION_BLOCK B VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR BEGIN a[1] := 1; END_FUNCTION_BLOCK";
    let compiled = compile(&[Source::new("b.scl", source.into())], &Options::default()).unwrap();
    assert!(compiled.root.is_none());
    let warning = compiled.warnings[0].to_string();
    assert!(warning.contains("the bounds of the parameter a come from the caller"), "{warning}");
}

/// A buffer before the output: 200,000 elements, and a structure with an array of 1,000 and one of 1,001.
#[test]
fn large_local_arrays_are_inside_and_what_stands_behind_them_is_shown() {
    let source = "TYPE Log STRUCT kept : ARRAY[1..1000] OF INT; more : ARRAY[0..1, 0..500] OF INT; END_STRUCT; END_TYPE
        FUNCTION_BLOCK B VAR buffer : ARRAY[0..199999] OF INT; log : Log; END_VAR VAR_OUTPUT y : INT; END_VAR
        BEGIN buffer[7] := buffer[7] + 1; log.more[1, 500] := 5; y := buffer[7]; END_FUNCTION_BLOCK";
    let compiled = compile(&[Source::new("b.scl", source.into())], &Options::default()).unwrap();
    let variables = compiled.root.unwrap().variables;
    let variables = shown(&variables);
    assert_eq!(variables.len(), 1001);
    assert_eq!(variables[999], ("log.kept[1000]", "INT", Role::Local));
    assert_eq!(variables[1000], ("y", "INT", Role::Output));
}

#[test]
fn an_interface_that_no_host_could_show_is_refused() {
    let refused = |last: u32| {
        let source =
            format!("FUNCTION_BLOCK B VAR_INPUT x : ARRAY[1..{last}] OF INT; END_VAR BEGIN END_FUNCTION_BLOCK");
        compile(&[Source::new("b.scl", source.into())], &Options::default()).err().map(|errors| errors[0].to_string())
    };
    assert_eq!(refused(100_000), None);
    let message = refused(100_001).unwrap();
    assert!(message.starts_with("b.scl:1:16: B has more than 100000 inputs, outputs and settings; keep"), "{message}");
}

#[test]
fn a_tag_is_what_its_address_says() {
    let text = "FUNCTION_BLOCK \"Main\"\nBEGIN\n\"Lamp\" := \"Button\" AND \"Flag\";\n\"Edge\" := \"Spare\";\n\"Level\" := 1.0;\nEND_FUNCTION_BLOCK";
    let lines = [
        "Lamp AT %Q0.0 : Bool // signal lamp",
        "Button AT %I0.0 : Bool",
        "Flag AT %M1.0 : Bool",
        "Edge AT %M1.1 : Bool",
        "Spare AT %Q0.1 : Bool",
        "Level AT %ID4 : Real // unit: m, min 0, max 5",
        "Other AT %I0.7 : Bool",
    ];
    let tag = |line: &&str| match declaration(line) {
        Ok(Declared::Tag(tag)) => tag,
        other => panic!("{line}: {other:?}"),
    };
    let options = Options { declared: lines.iter().map(tag).collect(), ..Options::default() };
    let compiled = compile(&[Source::new("main.scl", text.into())], &options).unwrap();
    // A tag that no block uses is left out; an input that the program writes to is an output, too.
    assert_eq!(
        shown(&compiled.globals),
        [
            ("Lamp", "BOOL", Role::Output),
            ("Button", "BOOL", Role::Input),
            ("Flag", "BOOL", Role::Local),
            ("Edge", "BOOL", Role::Local),
            ("Spare", "BOOL", Role::Output),
            ("Level", "REAL", Role::InOut),
        ]
    );
    let of = |name: &str| &compiled.globals.iter().find(|of| of.name == name).unwrap().comment;
    assert_eq!(of("Lamp").text, "signal lamp");
    assert_eq!((of("Level").unit.as_deref(), of("Level").max), (Some("m"), Some(5.0)));
}
