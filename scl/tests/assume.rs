//! Assumptions about undeclared names.

#![allow(clippy::unwrap_used)]

use parameters::Source;
use scl::interface::Role;
use scl::{Assumption, Compiled, Options, assume, assumed, compile};

fn assumptions(text: &str) -> Vec<Assumption> {
    assume(&[Source::new("main.scl", text.into())], &Options::default(), None)
}

/// Compiles the program with its assumptions, which are printed if it does not compile.
fn compiled(text: &str) -> Compiled {
    let assumed = assumed(&assumptions(text));
    let sources = [Source::new("main.scl", text.into()), Source::new("assumed.scl", assumed.clone().into())];
    let told = |errors: Vec<parameters::Problems>| errors.iter().map(|of| format!("{of}\n")).collect::<String>();
    compile(&sources, &Options::default()).unwrap_or_else(|errors| panic!("{}\n{assumed}", told(errors)))
}

/// Returns the variables of the interface, except locals, with their types.
fn interface(compiled: &Compiled) -> Vec<(String, String, Role)> {
    let root = compiled.root.as_ref().unwrap();
    let all = root.variables.iter().chain(&compiled.globals);
    let shown = all.filter(|of| of.role != Role::Local).map(|of| (of.name.clone(), of.of.to_string(), of.role));
    let mut shown: Vec<_> = shown.collect();
    shown.sort_by(|one, other| one.0.cmp(&other.0));
    shown
}

fn expected(rows: &[(&str, &str, Role)]) -> Vec<(String, String, Role)> {
    rows.iter().map(|(name, of, role)| (name.to_string(), of.to_string(), *role)).collect()
}

fn block(body: &str) -> String {
    format!(
        "FUNCTION_BLOCK \"Main\"\nVAR\n  level : Real;\n  on : Bool;\n  count : DInt;\nEND_VAR\nBEGIN\n{body}\nEND_FUNCTION_BLOCK\n"
    )
}

#[test]
fn tags_are_inputs_or_outputs_by_their_use() {
    let text = block(
        "\"Lamp\" := \"Start\" AND NOT \"Stop\";\n#level := \"Level\" * 2.0;\nIF \"Count\" > 5 THEN \"Speed\" := #level; END_IF;\n\
         \"Next\" := \"Lamp2\";",
    );
    let expected = expected(&[
        ("Count", "INT", Role::Input),
        ("Lamp", "BOOL", Role::Output),
        ("Lamp2", "BOOL", Role::Input),
        ("Level", "REAL", Role::Input),
        ("Next", "BOOL", Role::Output),
        ("Speed", "REAL", Role::Output),
        ("Start", "BOOL", Role::Input),
        ("Stop", "BOOL", Role::Input),
    ]);
    assert_eq!(interface(&compiled(&text)), expected);
    // What the CPU writes is no input, and holds.
    let text = block("\"Lamp\" := \"AlwaysTRUE\" AND \"Start\";");
    assert_eq!(
        interface(&compiled(&text)).iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>(),
        ["Lamp", "Start"]
    );
    let always = assumptions(&text).into_iter().find(|of| of.name == "AlwaysTRUE").unwrap();
    assert_eq!(always.what, "system or clock memory at %M1.2");
    let text = block("\"Lamp\" := \"Start\";");
    let lamp = assumptions(&text).into_iter().find(|of| of.name == "Lamp").unwrap();
    assert_eq!((lamp.what.as_str(), lamp.at), ("an output of type BOOL", (0, text.find("\"Lamp\"").unwrap() as u32)));
}

#[test]
fn data_blocks_have_the_members_and_elements_that_are_used() {
    let text = block(
        "#level := \"Data\".tank.level;\n\"Data\".tank.pump[2].on := \"Data\".tank.pump[1].ready;\nFOR #count := 0 TO 3 DO\n\
         \"Data\".log[#count] := #level;\nEND_FOR;",
    );
    let shown = interface(&compiled(&text));
    let named = |name: &str| shown.iter().find(|of| of.0 == name).map(|of| (of.1.as_str(), of.2));
    assert_eq!(named("Data.tank.level"), Some(("REAL", Role::Input)));
    assert_eq!(named("Data.tank.pump[2].on"), Some(("BOOL", Role::Output)));
    assert_eq!(named("Data.tank.pump[1].ready"), Some(("BOOL", Role::Input)));
    // A computed index may have any value.
    assert_eq!(named("Data.log[99]"), Some(("REAL", Role::Output)));
}

#[test]
fn an_instance_of_a_block_of_the_system_is_a_stub_that_who_uses_the_fmu_plays() {
    let text = "FUNCTION_BLOCK \"Main\"\nVAR\n  Connection : TSEND_C;\n  data : Array[0..3] of Byte;\n  sent : Bool;\nEND_VAR\nBEGIN\n\
        #Connection(REQ := TRUE, DATA := #data);\nIF #Connection.DONE THEN #sent := TRUE; END_IF;\nEND_FUNCTION_BLOCK\n";
    let compiled = compiled(text);
    let shown = interface(&compiled);
    let named = |name: &str| shown.iter().find(|of| of.0 == name).map(|of| (of.1.as_str(), of.2));
    assert_eq!(named("Connection.DONE"), Some(("BOOL", Role::Input)));
    assert_eq!(named("Connection.STATUS"), Some(("WORD", Role::Input)));
    assert_eq!(named("Connection.REQ"), Some(("BOOL", Role::Output)));
    assert_eq!(named("Connection.DATA[3]"), Some(("BYTE", Role::Output)));
    // A parameter without a type in the table, and to which no call passes a value, is left out.
    assert_eq!(named("Connection.ADDR"), None);
    assert_eq!(compiled.root.unwrap().block, "Main");
}

#[test]
fn functions_types_blocks_and_instances_are_taken_from_their_calls() {
    let text = block(
        "#level := \"Mix\"(raw := #count, factor := 2.0);\n\"Motor_DB\"(start := #on, speed => #level);\n#on := \"Motor_DB\".fault;\n\
         \"Report\"(code := 5);\n#count := DPRD_DAT(LADDR := 16#10, RECORD => \"Raw\".value);",
    );
    let shown = interface(&compiled(&text));
    let named = |name: &str| shown.iter().find(|of| of.0 == name).map(|of| (of.1.as_str(), of.2));
    assert_eq!(named("Mix_call.raw"), Some(("DINT", Role::Output)));
    assert_eq!(named("Mix_call.RET_VAL"), Some(("REAL", Role::Input)));
    assert_eq!(named("Motor_DB.start"), Some(("BOOL", Role::Output)));
    assert_eq!(named("Motor_DB.speed"), Some(("REAL", Role::Input)));
    assert_eq!(named("Motor_DB.fault"), Some(("BOOL", Role::Input)));
    assert_eq!(named("DPRD_DAT_call.LADDR"), Some(("WORD", Role::Output)));
    let typed = "FUNCTION_BLOCK \"Main\"\nVAR_INPUT\n  par : \"Limits\";\nEND_VAR\nVAR\n  motor : Array[1..2] of \"Drive\";\nEND_VAR\n\
        BEGIN\n#motor[1](on := #par.low > 1.5);\nIF #motor[2].busy THEN RETURN; END_IF;\nEND_FUNCTION_BLOCK\n";
    let shown = interface(&self::compiled(typed));
    let named = |name: &str| shown.iter().find(|of| of.0 == name).map(|of| (of.1.as_str(), of.2));
    assert_eq!(named("par.low"), Some(("REAL", Role::Input)));
    assert_eq!(named("motor[2].on"), Some(("BOOL", Role::Output)));
    assert_eq!(named("motor[1].busy"), Some(("BOOL", Role::Input)));
}

#[test]
fn a_constant_gets_a_value_that_is_to_be_corrected_and_only_the_names_that_are_asked_for_are_assumed() {
    let text = "FUNCTION_BLOCK \"Main\"\nVAR\n  list : Array[1..\"MAX\"] of Int;\nEND_VAR\nBEGIN\n\"Lamp\" := TRUE;\nEND_FUNCTION_BLOCK\n";
    let all = assumptions(text);
    let max = all.iter().find(|of| of.name == "MAX").unwrap();
    assert!(max.what.contains("a placeholder"), "{}", max.what);
    drop(compiled(text));
    let only = assume(&[Source::new("a.scl", text.into())], &Options::default(), Some(&["lamp".to_string()]));
    assert_eq!(only.iter().map(|of| of.name.as_str()).collect::<Vec<_>>(), ["Lamp"]);
}

#[test]
fn a_program_that_lacks_nothing_has_no_assumptions() {
    assert_eq!(assumptions(&block("#level := 1.0;")), []);
    assert_eq!(assumptions("FUNCTION_BLOCK \"Main\"\nBEGIN\nIF #x THEN"), []);
}

/// Determines the parameters of a system block with a program that declares an instance and reads the parameters that
/// it does not pass.
#[test]
fn the_documentation_lists_the_parameters_of_the_blocks_that_are_known() {
    let docs = include_str!("../../docs/scl.md");
    let row = docs.lines().find(|line| line.starts_with("| TRCV |")).unwrap();
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let text = "FUNCTION_BLOCK \"Main\"\nVAR\n  receive : TRCV;\n  data : Array[0..3] of Byte;\nEND_VAR\nBEGIN\n\
        #receive(EN_R := TRUE, DATA := #data, ADDR := #data);\nEND_FUNCTION_BLOCK\n";
    let shown = interface(&compiled(text));
    let named = |role| {
        let own = shown.iter().filter(move |of| of.2 == role);
        let names = own.filter_map(|of| of.0.strip_prefix("receive.")).map(|name| name.split('[').next().unwrap());
        names.collect::<std::collections::BTreeSet<_>>()
    };
    let listed = |cell: &'static str| cell.split(", ").collect::<std::collections::BTreeSet<_>>();
    assert_eq!((named(Role::Output), named(Role::Input)), (listed(cells[2]), listed(cells[3])));
}

/// Its outputs are FMU inputs, so the host supplies them.
#[test]
fn a_block_that_cannot_be_read_is_a_stub_by_its_interface() {
    let text = "FUNCTION_BLOCK \"Clock\"\nVAR_INPUT raw : Word; any : Variant; END_VAR\nVAR_OUTPUT hour : Int; END_VAR\nBEGIN\n\
        #hour := BCD16_TO_INT(#raw);\nEND_FUNCTION_BLOCK\n\
        FUNCTION \"Digits\" : Int\nVAR_INPUT raw : Word; END_VAR\nBEGIN\n  #Digits := BCD16_TO_INT(#raw);\nEND_FUNCTION\n\
        FUNCTION_BLOCK \"Main\"\nVAR_INPUT raw : Word; END_VAR\nVAR_OUTPUT y : Int; END_VAR\nVAR clock : \"Clock\"; END_VAR\nBEGIN\n\
        #clock(raw := #raw, any := #raw);\n  #y := #clock.hour + \"Digits\"(#raw);\nEND_FUNCTION_BLOCK\n";
    let told: Vec<(String, String)> = assumptions(text).into_iter().map(|of| (of.name, of.what)).collect();
    let what = "a stub, because it cannot be read: BCD16_TO_INT is not supported";
    let names: Vec<&str> = told.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Clock", "Digits"], "{told:?}");
    assert_eq!(told[1].1, what);
    let program = compiled(text);
    let warned: Vec<&String> =
        program.warnings.iter().flat_map(|of| &of.problems).map(|problem| &problem.message).collect();
    assert!(warned.iter().any(|of| **of == "Clock does not run: the stub in assumed.scl replaces it"), "{warned:?}");
    let expected = expected(&[
        ("Digits_call.RET_VAL", "INT", Role::Input),
        ("Digits_call.raw", "WORD", Role::Output),
        ("clock.hour", "INT", Role::Input),
        ("clock.raw", "WORD", Role::Output),
        ("raw", "WORD", Role::Input),
        ("y", "INT", Role::Output),
    ]);
    assert_eq!(interface(&program), expected);
}

#[test]
fn a_bit_is_one_though_a_0_or_1_is_written_to_it() {
    let text = block(
        "\"Alarm\" := 1;\nIF \"Reset\" AND NOT \"Alarm\" THEN \"Alarm\" := 0; END_IF;\n\"Step\" := 1;\n\"Next\" := 7;",
    );
    let expected = expected(&[
        ("Alarm", "BOOL", Role::Output),
        ("Next", "INT", Role::Output),
        ("Reset", "BOOL", Role::Input),
        ("Step", "INT", Role::Output),
    ]);
    assert_eq!(interface(&compiled(&text)), expected);
}

/// A stub has no parameter for a structure without a name; a single argument needs no name.
#[test]
fn structures_are_left_out_of_a_stub() {
    let text = "FUNCTION_BLOCK \"Main\"\nVAR\n  go : Bool;\n  frame : STRUCT a : Int; b : Int; END_STRUCT;\nEND_VAR\nBEGIN\n\
        \"Sender\"(go := #go, frame := #frame);\n  \"Ping\"(#go);\nEND_FUNCTION_BLOCK\n";
    let names: Vec<String> = interface(&compiled(text)).into_iter().map(|(name, ..)| name).collect();
    assert_eq!(names, ["Ping_call.IN", "Sender_call.go"]);
}

#[test]
fn a_library_without_an_organization_block_gets_one() {
    let text = "TYPE \"limits\"\nSTRUCT\n  low : Real; high : Real;\nEND_STRUCT;\nEND_TYPE\n\
        FUNCTION_BLOCK \"Pump\"\nVAR_INPUT start : Bool; END_VAR\nVAR_OUTPUT run : Bool; END_VAR\nBEGIN\n#run := #start;\n\
        END_FUNCTION_BLOCK\n\
        FUNCTION_BLOCK \"Count\"\nVAR_IN_OUT of : \"limits\"; END_VAR\nVAR_OUTPUT n : Int; END_VAR\nBEGIN\n#n := #n + 1;\n\
        #of.high := INT_TO_REAL(#n);\nEND_FUNCTION_BLOCK\n\
        FUNCTION \"Double\" : Real\nVAR_INPUT x : Real; END_VAR\nBEGIN\n#Double := #x * 2.0;\nEND_FUNCTION\n\
        FUNCTION \"Sum\" : Real\nVAR_INPUT v : Array[*] of Real; END_VAR\nBEGIN\n#Sum := #v[0];\nEND_FUNCTION\n\
        DATA_BLOCK \"Pump_DB\"\n\"Pump\"\nBEGIN\nEND_DATA_BLOCK\n";
    let found = assumptions(text);
    let told: Vec<String> = found.iter().map(|of| format!("{}: {}", of.name, of.what)).collect();
    let calls =
        "an organization block that calls each block not called by any other (3), with a tag for each parameter";
    assert_eq!(told, [format!("Main: {calls}")]);
    let expected_calls = "BEGIN\n   \"Pump_DB\"(start := \"Pump_start\", run => \"Pump_run\");\n   \
        \"Count_DB\"(of := \"Count_of\", n => \"Count_n\");\n   \"Double_value\" := \"Double\"(x := \"Double_x\");\n";
    assert!(found[0].text.contains(expected_calls), "{}", found[0].text);
    let compiled = compiled(text);
    let inputs = interface(&compiled).into_iter().filter(|(.., role)| *role == Role::Input).map(|(name, ..)| name);
    assert_eq!(inputs.collect::<Vec<_>>(), ["Double_x", "Pump_start"]);

    // One block that can be run is run by itself; with another that cannot be read, an organization block calls it.
    let one = "FUNCTION_BLOCK \"Pump\"\nBEGIN\n;\nEND_FUNCTION_BLOCK\n";
    assert_eq!(assumptions(one), []);
    let two = format!("{one}FUNCTION_BLOCK \"Old\"\nVAR_INPUT p : Pointer; END_VAR\nBEGIN\n;\nEND_FUNCTION_BLOCK\n");
    let names: Vec<String> = assumptions(&two).into_iter().map(|of| of.name).collect();
    assert_eq!(names, ["Main", "Old"]);
}

/// A tag is the variable at its address, however wide an assumed one is; its type is the one that the context requires.
#[test]
fn an_absolute_address_is_the_tag_that_has_it() {
    let text = "VAR_GLOBAL \"Start\" AT %E0.3 : Bool; END_VAR\n".to_string()
        + &block("\"Lamp\" := %I0.3 AND %I0.4;\n#level := INT_TO_REAL(%IW64);\n%QB2 := 5;\n%MW10 := %IW64:P;");
    let told: Vec<String> = assumptions(&text).iter().map(|of| format!("{} is {}", of.name, of.what)).collect();
    assert_eq!(
        told,
        [
            "%I0.4 is a tag at %I0.4",
            "%IW64 is a tag at %IW64",
            "%QB2 is a tag at %QB2",
            "Lamp is an output of type BOOL",
            "%MW10 is a tag at %MW10"
        ]
    );
    let expected = expected(&[
        ("I0_4", "BOOL", Role::Input),
        ("IW64", "INT", Role::Input),
        ("Lamp", "BOOL", Role::Output),
        ("QB2", "BYTE", Role::Output),
        ("Start", "BOOL", Role::Input),
    ]);
    assert_eq!(interface(&compiled(&text)), expected);
}

/// Where several uses tell a type, a certain one wins: texts where a text is required, a number in an ordering or a sum.
#[test]
fn members_of_a_missing_type_have_the_types_that_their_uses_require() {
    let text = "FUNCTION_BLOCK \"Main\"\nVAR_INPUT c : \"typeMotor\"; list : Array[0..9] of \"typeEvent\"; i : Int; END_VAR\n\
        VAR_OUTPUT q : Bool; s : String[40]; END_VAR\nVAR moment : DTL; END_VAR\nBEGIN\n\
        #q := #c.speed > #c.limit;\n#s := #list[#i].message;\n#s := CONCAT(IN1 := #c.name, IN2 := 'x');\n#q := #c.a + #c.b > 0.5;\n\
        #c.b := 3;\n#q := #c.text = #s;\n#moment := DT#1990-1-1-0:0:0.0;\nEND_FUNCTION_BLOCK\n";
    let types: Vec<String> = assumptions(text).into_iter().map(|of| of.text).collect();
    let motor = "a : REAL;\n   b : INT;\n   limit : REAL;\n   name : STRING;\n   speed : REAL;\n   text : STRING;\n";
    assert!(types.iter().any(|text| text.contains(motor)), "{types:#?}");
    assert!(types.iter().any(|text| text.contains("STRUCT\n   message : STRING;\n")), "{types:#?}");
    compiled(text);
}

/// The interface of a block that is to be a stub is known: what its calls lack is an error as ever.
#[test]
fn a_call_of_a_chosen_stub_needs_its_structured_in_outs() {
    let text = "TYPE \"limits\"\nSTRUCT\n  low : Real;\nEND_STRUCT;\nEND_TYPE\n\
        FUNCTION_BLOCK \"Sub\"\nVAR_IN_OUT of : \"limits\"; END_VAR\nBEGIN\n;\nEND_FUNCTION_BLOCK\n\
        FUNCTION_BLOCK \"Main\"\nVAR sub : \"Sub\"; END_VAR\nBEGIN\n#sub();\nEND_FUNCTION_BLOCK\n";
    let options = Options { stubs: vec!["Sub".into()], ..Options::default() };
    let errors = compile(&[Source::new("main.scl", text.into())], &options).unwrap_err();
    assert_eq!(errors[0].problems[0].message, "the in-out parameter of is missing");
}
