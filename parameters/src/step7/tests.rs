use super::*;
use crate::{BlockType, Loop, Options, Origin, Problems, Reading, Source};
use blocks::{Kind, Role, Row, Time, Value, Word};
use proptest::prelude::*;
use std::sync::Arc;

fn member(name: &str, role: Role, start: Value) -> Row {
    Row::new(name, role, start)
}

/// PUMP is FB 41, FAN is a user's block, STATION contains a PUMP, and MIXER has an LREAL.
fn blocks() -> Vec<Arc<BlockType>> {
    let pump = [
        member("MAN_ON", Role::Input, Value::Bool(true)),
        member("CYCLE", Role::Cycle, Value::Time(Time::ms(1000))),
        member("PV_PER", Role::Input, Value::Word(Word::new(0))),
        member("GAIN", Role::Parameter, Value::Real(2.0)),
        member("STEPS", Role::Fixed, Value::Int(200)),
        member("SP_INT", Role::Input, Value::Real(0.0)),
        member("LMN", Role::Output, Value::Real(0.0)),
        member("QHLM", Role::Output, Value::Bool(false)),
    ];
    let fan = [
        member("SET", Role::Input, Value::Bool(false)),
        member("TH_TZ", Role::Parameter, Value::Int(0)),
        member("TR_TZ", Role::Parameter, Value::Int(0)),
        member("OUT", Role::Output, Value::Int(0)),
    ];
    let station = [
        member("RED_FAC", Role::Fixed, Value::Int(200)),
        member("CYCLE", Role::Cycle, Value::Time(Time::ms(10))),
        member("QPOS", Role::Output, Value::Bool(false)),
        member("DI_PUMP.CYCLE", Role::Local, Value::Time(Time::ms(10))),
        member("DI_PUMP.GAIN", Role::Parameter, Value::Real(2.0)),
        member("DI_PUMP.SP_INT", Role::Input, Value::Real(0.0)),
        member("DI_PUMP.LMN", Role::Local, Value::Real(0.0)),
        member("Q_MEAN", Role::Output, Value::LReal(0.0)),
    ];
    let mixer = [member("LEVEL", Role::Parameter, Value::LReal(0.5))];
    let block = |name: &str, aliases: &[&str], members: &[Row]| {
        let aliases = aliases.iter().map(|alias| alias.to_string()).collect();
        let mean = members.iter().position(|member| member.name == "Q_MEAN");
        let mut block = BlockType::new(name.into(), aliases, members.to_vec());
        block.mean = mean;
        Arc::new(block)
    };
    vec![
        block("PUMP", &["FB 41", "SFB 41"], &pump),
        block("FAN", &[], &fan),
        block("STATION", &[], &station),
        block("MIXER", &[], &mixer),
    ]
}

fn read_text(text: &str) -> Result<Reading, Problems> {
    read(&Source::new("plant.awl", text.into()), &blocks(), &Options::default())
}

fn loops(text: &str) -> Vec<Loop> {
    read_text(text).unwrap_or_else(|problems| panic!("{problems}")).loops
}

fn one(text: &str) -> Loop {
    let mut loops = loops(text);
    assert_eq!(loops.len(), 1);
    loops.remove(0)
}

fn remarks(text: &str) -> String {
    read_text(text).unwrap_or_else(|problems| panic!("{problems}")).remarks.to_string()
}

#[track_caller]
fn assert_refused(text: &str, lines: &[&str]) {
    match read_text(text) {
        Ok(reading) => panic!("{:?}", reading.loops),
        Err(problems) => assert_eq!(problems.to_string().lines().collect::<Vec<_>>(), lines),
    }
}

const PUMP: &str = "\
DATA_BLOCK DB 41
TITLE = any text ; to the end of the line \"even quotes // and so on
{ S7_m_c := 'true' }
AUTHOR : X   FAMILY : Y   NAME : Z   VERSION : 0.1   KNOW_HOW_PROTECT
FB 41
BEGIN
   GAIN := 3.5e+000;  CYCLE := T#20S;  MAN_ON := FALSE;  PV_PER := W#16#6C00; // comment
   STEPS := 7;
END_DATA_BLOCK
";

#[test]
fn a_data_block_is_a_loop_with_the_values_of_its_text() {
    let pump = one(PUMP);
    assert_eq!((pump.name.as_str(), pump.block.name.as_str()), ("DB41", "PUMP"));
    assert_eq!(pump.title.as_deref(), Some("any text ; to the end of the line \"even quotes // and so on"));
    let titled =
        |title: &str| one(&PUMP.replace("any text ; to the end of the line \"even quotes // and so on", title)).title;
    assert_eq!((titled("'Öfen'\r"), titled("''"), titled(" ")), (Some("Öfen".into()), None, None));
    assert_eq!(pump.get("GAIN"), Some(Value::Real(3.5)));
    assert_eq!(pump.get("CYCLE"), Some(Value::Time(Time::ms(20_000))));
    assert_eq!(pump.get("MAN_ON"), Some(Value::Bool(false)));
    assert_eq!(pump.get("PV_PER"), Some(Value::Word(Word::new(27648))));
    assert_eq!(pump.get("STEPS"), Some(Value::Int(7)));
}

#[test]
fn every_value_says_whether_it_is_from_the_text_or_the_default() {
    let pump = one(PUMP);
    let origin = |name: &str| {
        let member = pump.block.find(name).unwrap();
        pump.settings.iter().find(|setting| setting.member == member).unwrap().origin.clone()
    };
    assert_eq!(origin("GAIN").to_string(), "plant.awl:7:12");
    assert_eq!(origin("SP_INT"), Origin::Default);
    assert_eq!(pump.get("SP_INT"), Some(Value::Real(0.0)));
}

#[test]
fn the_type_is_a_number_or_a_name_before_or_after_the_properties() {
    for header in [
        "DATA_BLOCK \"TIC101\"\nFB 41",
        "DATA_BLOCK \"TIC101\" FB41",
        "data_block tic101 sfb 41\nversion : 1.0",
        "DATA_BLOCK TIC101 \"PUMP\"",
        "DATA_BLOCK TIC101\nPUMP\nTITLE =x",
        "DATA_BLOCK TIC101\nSFB41\nAUTHOR : Karl-Heinz\nNAME :\nFAMILY : 'a b'\nNON_RETAIN",
    ] {
        let pump = one(&format!("{header}\nBEGIN GAIN := 1.5; END_DATA_BLOCK"));
        assert_eq!(pump.name.to_uppercase(), "TIC101", "{header}");
        assert_eq!(pump.get("GAIN"), Some(Value::Real(1.5)), "{header}");
    }
}

#[test]
fn case_and_line_ends_do_not_matter() {
    assert_eq!(loops(&PUMP.to_lowercase())[0].get("GAIN"), Some(Value::Real(3.5)));
    assert_eq!(loops(&PUMP.replace('\n', "\r\n"))[0].get("STEPS"), Some(Value::Int(7)));
}

#[test]
fn comments_of_all_tools_are_passed_over() {
    let text = "/// TIA\nDATA_BLOCK DB1 PUMP (* SCL\n *) BEGIN // GAIN := 9.0;\n /* GAIN := 8.0; */ GAIN := 7.0; END_DATA_BLOCK";
    assert_eq!(one(text).get("GAIN"), Some(Value::Real(7.0)));
}

#[test]
fn outputs_and_memory_of_a_generated_text_are_not_taken() {
    let text = "DATA_BLOCK DB1 PUMP BEGIN GAIN := 3.0; LMN := 55.0; QHLM := TRUE; sRestInt := 1.0; END_DATA_BLOCK";
    let mut expected = Loop::new("DB1", blocks()[0].clone());
    let origin = Origin::Text { file: "plant.awl".into(), line: 1, column: 35, span: 34..37 };
    expected.set(3, Value::Real(3.0), origin);
    assert_eq!(one(text), expected);
    assert_refused(&text.replace("QHLM := TRUE; ", ""), &["plant.awl:1:53: PUMP has no member `sRestInt`"]);
}

#[test]
fn a_slip_behind_the_outputs_is_not_taken_for_memory() {
    assert_refused(
        "DATA_BLOCK DB1 PUMP BEGIN QHLM := TRUE; GIAN := 2.0; END_DATA_BLOCK",
        &["plant.awl:1:41: PUMP has no member `GIAN`; did you mean GAIN?"],
    );
}

#[test]
fn other_blocks_are_skipped_by_name() {
    let text = format!(
        "FUNCTION FC 1 : VOID\nBEGIN\n L \"TIC101\".GAIN;\n T#5S;\nEND_FUNCTION\n{PUMP}DATA_BLOCK DB 7\nSTRUCT\n GAIN : REAL := 5.0;\nEND_STRUCT\n\
         BEGIN\nEND_DATA_BLOCK\nTYPE UDT 3 STRUCT a : INT; END_STRUCT END_TYPE\nDATA_BLOCK DB 8 FB 200 BEGIN x[1] := 'y'; END_DATA_BLOCK"
    );
    assert_eq!(one(&text).name, "DB41");
    assert_eq!(remarks(&text), "plant.awl: skipped FC1, DB7, UDT3, DB8 (FB200): not instances of known blocks");
}

#[test]
fn a_block_of_the_project_under_the_number_of_a_known_block_is_skipped() {
    let text = format!("{PUMP}DATA_BLOCK DB 9 FB 41 BEGIN speed := 5; ramp := T#5S; END_DATA_BLOCK");
    assert_eq!(one(&text).name, "DB41");
    assert_eq!(remarks(&text), "plant.awl: skipped DB9 (FB41): not instances of known blocks");
    assert_refused(
        "DATA_BLOCK DB 9 FB 41 BEGIN speed := 5; END_DATA_BLOCK",
        &["plant.awl:1:17: DB9 is an instance of `FB41`, but has no member of PUMP; known blocks: PUMP (FB 41, SFB \
           41), FAN, STATION, MIXER"],
    );
    assert_refused(
        "DATA_BLOCK DB 9 FB 41 BEGIN gian := 5.0; END_DATA_BLOCK",
        &["plant.awl:1:29: PUMP has no member `gian`; did you mean GAIN?"],
    );
}

#[test]
fn an_empty_data_block_of_a_type_with_a_similar_name_is_skipped() {
    let text = format!("{PUMP}DATA_BLOCK DB 9 PUMA BEGIN END_DATA_BLOCK");
    assert_eq!(remarks(&text), "plant.awl: skipped DB9 (PUMA): not instances of known blocks");
}

#[test]
fn several_data_blocks_are_several_loops() {
    let text = format!("{PUMP}\nDATA_BLOCK \"RAMP\" \"FAN\" BEGIN \"TH_TZ\" := 5; END_DATA_BLOCK");
    let names: Vec<String> = loops(&text).into_iter().map(|one| one.name).collect();
    assert_eq!(names, ["DB41", "RAMP"]);
}

const MULTI_INSTANCE: &str = "\
FUNCTION_BLOCK FB 100
VAR_INPUT
   start : BOOL;
END_VAR
VAR
   TIC {OriginalPartName := 'X'} : FB 41;
   FIC, LIC : \"PUMP\";
   limits : STRUCT low : REAL; high : STRUCT a : INT; END_STRUCT; END_STRUCT;
   inner : FB 101;
END_VAR
BEGIN
   CALL #TIC;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB 101 VAR
   QIC : PUMP;
END_VAR

END_FUNCTION_BLOCK
DATA_BLOCK DB 100
FB 100
BEGIN
   start := TRUE;
   TIC.GAIN := 3.0;
   \"FIC\".\"GAIN\" := 4.0;
   inner.QIC.GAIN := 5.0;
END_DATA_BLOCK
";

#[test]
fn multi_instances_are_loops_with_the_names_of_their_members() {
    let read: Vec<_> =
        loops(MULTI_INSTANCE).into_iter().map(|one| (one.name.clone(), one.get("GAIN").unwrap())).collect();
    let expected = [("TIC", 3.0), ("FIC", 4.0), ("LIC", 2.0), ("QIC", 5.0)];
    assert_eq!(read, expected.map(|(name, gain)| (name.to_string(), Value::Real(gain))));
}

#[test]
fn multi_instances_of_two_data_blocks_are_told_apart_by_these() {
    let text = format!("{MULTI_INSTANCE}DATA_BLOCK DB 101 FB 101 BEGIN QIC.GAIN := 6.0; END_DATA_BLOCK");
    let names: Vec<String> = loops(&text).into_iter().map(|one| one.name).collect();
    assert_eq!(names, ["TIC", "FIC", "LIC", "DB100.inner.QIC", "DB101.QIC"]);
}

#[test]
fn a_member_that_the_function_block_does_not_declare_is_an_error() {
    assert_refused(
        &MULTI_INSTANCE.replace("TIC.GAIN", "TCI.GAIN"),
        &["plant.awl:23:4: FB100 has no member `TCI`; did you mean TIC?"],
    );
}

#[test]
fn instances_with_values_in_the_declaration_are_refused() {
    assert_refused(
        &MULTI_INSTANCE.replace("QIC : PUMP;", "QIC : PUMP := (GAIN := 3.0);"),
        &["plant.awl:15:4: `QIC` is an instance with values in the declaration; write them in the data block"],
    );
}

#[test]
fn each_element_of_an_array_of_instances_is_a_loop() {
    let gains = |text: &str| -> Vec<(String, Value)> {
        loops(text).into_iter().map(|one| (one.name.clone(), one.get("GAIN").unwrap())).collect()
    };
    let expected = |values: &[(&str, f32)]| -> Vec<(String, Value)> {
        values.iter().map(|(name, gain)| (name.to_string(), Value::Real(*gain))).collect()
    };
    let body = "DATA_BLOCK DB 9 FB 100 BEGIN x[3] := 5; r[2, 0].GAIN := 3.0; R[2,1].GAIN := 4.0; END_DATA_BLOCK";
    let with = |members: &str| format!("FUNCTION_BLOCK FB 100 VAR {members} END_VAR BEGIN END_FUNCTION_BLOCK {body}");
    assert_eq!(
        gains(&with("r : ARRAY [2..3, 0..1] OF PUMP; x : ARRAY [0..9] OF INT;")),
        expected(&[("r[2,0]", 3.0), ("r[2,1]", 4.0), ("r[3,0]", 2.0), ("r[3,1]", 2.0)])
    );
    // Without the function block, only members with values are known.
    let body =
        "DATA_BLOCK DB 9 FB 100 BEGIN r[2, 0].CYCLE := T#1S; r[2,0].SP_INT := 1.0; r[2,0].GAIN := 3.0; END_DATA_BLOCK";
    assert_eq!(gains(body), expected(&[("r[2,0]", 3.0)]));
    // An array of function blocks, with an instance data block for each element.
    let nested = "FUNCTION_BLOCK FB 7 VAR P : FB 41; END_VAR BEGIN END_FUNCTION_BLOCK
        FUNCTION_BLOCK FB 8 VAR line : ARRAY [1..2] OF FB 7; END_VAR BEGIN END_FUNCTION_BLOCK
        DATA_BLOCK DB 9 FB 8 BEGIN line[2].P.GAIN := 3.0; END_DATA_BLOCK";
    assert_eq!(gains(nested), expected(&[("DB9.line[1].P", 2.0), ("DB9.line[2].P", 3.0)]));
    assert_refused(
        &MULTI_INSTANCE.replace("QIC : PUMP;", "QIC : ARRAY [1..COUNT] OF PUMP;"),
        &[
            "plant.awl:15:4: `QIC` is an array of instances whose bounds are not numbers, or that has too many elements; \
           declare each instance separately",
        ],
    );
}

#[test]
fn a_loop_that_is_wrong_does_not_cost_the_others_if_that_is_wanted() {
    let text = MULTI_INSTANCE.replace("\"FIC\".\"GAIN\" := 4.0", "\"FIC\".\"GAIN\" := T#4S")
        + "DATA_BLOCK DB 41 PUMP BEGIN GAIN := 1,5; END_DATA_BLOCK DATA_BLOCK DB 42 PUMP BEGIN END_DATA_BLOCK";
    let options = Options { is_partial: true, ..Options::default() };
    let reading = read(&Source::new("plant.awl", text.clone().into()), &blocks(), &options).unwrap();
    let names: Vec<&str> = reading.loops.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["TIC", "LIC", "QIC", "DB42"]);
    assert_eq!(reading.wrong.problems.len(), 2, "{}", reading.wrong);
    assert_eq!(read_text(&text).unwrap_err(), reading.wrong);
    // If a block is not terminated, the assignment of members is ambiguous.
    let open = text + "DATA_BLOCK DB 43 PUMP BEGIN (* GAIN := 1.0; END_DATA_BLOCK";
    assert!(read(&Source::new("plant.awl", open.into()), &blocks(), &options).is_err());
}

#[test]
fn a_function_block_inside_itself_is_refused() {
    let text = MULTI_INSTANCE.replace("QIC : PUMP;", "QIC : PUMP; again : FB 100;");
    assert_refused(&text, &["plant.awl:9:4: `inner` is nested more than 32 levels deep, or contains itself"]);
}

#[test]
fn multi_instances_without_their_function_block_are_recognized_by_their_members() {
    let text =
        "DATA_BLOCK DB 9 FB 900 BEGIN x := 5; TIC.GAIN := 3.0; TIC.CYCLE := T#1S; TIC.SP_INT := 2.0; END_DATA_BLOCK";
    let tic = one(text);
    assert_eq!((tic.name.as_str(), tic.get("GAIN")), ("TIC", Some(Value::Real(3.0))));
    assert_eq!(remarks(text), "plant.awl:1:12: DB9: `TIC` is recognized as PUMP by its members");
}

#[test]
fn the_inner_blocks_of_a_known_block_are_its_own() {
    let text = "DATA_BLOCK DB 9 STATION BEGIN RED_FAC := 5; DI_PUMP.GAIN := 3.0; DI_PUMP.LMN := 0.0; DI_PUMP.sOld := 1.0; END_DATA_BLOCK";
    let station = one(text);
    assert_eq!(station.block.name, "STATION");
    assert_eq!(station.get("DI_PUMP.GAIN"), Some(Value::Real(3.0)));
    assert_eq!(
        one(&text.replace("DB 9 STATION", "DB 9 FB 900").replace("DI_PUMP.LMN", "CYCLE := T#1S; DI_PUMP.LMN"))
            .block
            .name,
        "STATION"
    );
    assert_refused(&text.replace("RED_FAC", "Q_MEAN"), &["plant.awl:1:31: STATION has no member `Q_MEAN`"]);
}

#[test]
fn a_tia_text_is_a_list_of_differences() {
    let text = "\
DATA_BLOCK \"TIC101\"
{InstructionName := 'PUMP';
LibVersion := '1.1';
S7_Optimized_Access := 'FALSE' }
VERSION : 0.1
NON_RETAIN
PUMP

BEGIN
   \"GAIN\" { S7_SetPoint := 'True'} := 4.0;
   PV_PER := 16#0;
END_DATA_BLOCK
";
    let pump = one(text);
    assert_eq!((pump.get("GAIN"), pump.get("CYCLE")), (Some(Value::Real(4.0)), Some(Value::Time(Time::ms(1000)))));
    let empty = one("DATA_BLOCK \"TIC101\" PUMP BEGIN END_DATA_BLOCK");
    assert_eq!(empty, Loop::new("TIC101", blocks()[0].clone()));
}

#[test]
fn a_type_with_a_number_behind_it_is_the_block_after_a_migration() {
    let text = "DATA_BLOCK \"TIC101\"\n\"PUMP_1\"\nBEGIN\n GAIN := 4.0;\nEND_DATA_BLOCK";
    assert_eq!(one(text).block.name, "PUMP");
    assert_eq!(remarks(text), "plant.awl:2:1: TIC101: `PUMP_1` is treated as PUMP");
    assert_refused(&text.replace("GAIN", "SPEED"), &["plant.awl:4:2: PUMP has no member `SPEED`"]);
}

#[test]
fn an_unknown_type_is_recognized_by_its_members() {
    let text = "DATA_BLOCK DB 3\nFB 333\nBEGIN\n TH_TZ := 4; TR_TZ := 5; SET := TRUE;\nEND_DATA_BLOCK";
    assert_eq!(one(text).block.name, "FAN");
    assert_eq!(remarks(text), "plant.awl:2:1: DB3: `FB333` is treated as FAN");
}

#[test]
fn another_block_with_some_of_the_same_names_is_not_taken_for_one_of_these() {
    assert_refused(
        "DATA_BLOCK \"T1\"\nTCONTROL\nBEGIN\n GAIN := 3.0; STEPS := 9; SP_INT := 1.0;\nEND_DATA_BLOCK",
        &[
            "plant.awl:2:1: `TCONTROL` is not a known block; if it is PUMP, which has the same members, specify --block PUMP",
        ],
    );
}

#[test]
fn a_slip_in_a_block_with_another_number_is_told_and_does_not_cost_the_loop() {
    assert_refused(
        "DATA_BLOCK DB 3\nFB 333\nBEGIN\n TH_TZ := 4; TR_TZ := 5,5; SET := TRUE;\nEND_DATA_BLOCK",
        &[
            "plant.awl:2:1: `FB333` is not a known block; if it is FAN, which has the same members, specify --block FAN",
            "plant.awl:4:24: expected `;` after this value, found `,`; write a decimal point, not a comma",
        ],
    );
}

#[test]
fn the_user_can_name_the_block_of_unknown_types() {
    let source = Source::new("plant.awl", b"DATA_BLOCK DB 3 FB 333 BEGIN SP_INT := 4.0; END_DATA_BLOCK".to_vec());
    assert!(read(&source, &blocks(), &Options::default()).is_err());
    let options = Options { block: Some("PUMP".into()), ..Options::default() };
    assert_eq!(read(&source, &blocks(), &options).unwrap().loops[0].get("SP_INT"), Some(Value::Real(4.0)));
}

const LOST: &str = "\
DATA_BLOCK DB 41
FB 41
BEGIN
   IN0 := FALSE; IN1 := T#5S; IN2 := W#16#1; IN3 := 3.5; IN4 := 9; IN5 := 1.0;
   OUT6 := 0.0; OUT7 := TRUE; STAT8 := 0.0; STAT9 := FALSE;
END_DATA_BLOCK
";

#[test]
fn lost_names_are_taken_by_position() {
    let pump = one(LOST);
    assert_eq!((pump.get("GAIN"), pump.get("CYCLE")), (Some(Value::Real(3.5)), Some(Value::Time(Time::ms(5000)))));
    assert_eq!(pump.get("STEPS"), Some(Value::Int(9)));
    assert_eq!(remarks(LOST), "plant.awl:1:12: DB41: the member names are lost; the values were assigned by position");
}

#[test]
fn lost_names_whose_types_do_not_fit_are_refused() {
    assert_refused(
        &LOST.replace("T#5S", "5.0"),
        &["plant.awl:4:18: the member names are lost: in PUMP, expected CYCLE (TIME) at this position, found \
           `IN1` := `5.0`"],
    );
    assert_refused(
        &LOST.replace("IN5 := 1.0;", "").replace("OUT6 := 0.0; OUT7 := TRUE; STAT8 := 0.0; STAT9 := FALSE;", ""),
        &["plant.awl:1:12: the member names are lost: PUMP has 6 inputs and parameters, found 5 values"],
    );
    assert_refused(
        &LOST.replace("IN4", "IN2"),
        &["plant.awl:4:58: the member names are lost: in PUMP, expected STEPS (INT) at this position, found \
           `IN2` := `9`"],
    );
}

#[test]
fn a_text_with_seven_digits_says_once_that_it_is_lossy() {
    let text = "DATA_BLOCK DB1 PUMP BEGIN GAIN := 1.234567e+000; SP_INT := 2.000000e+000; END_DATA_BLOCK";
    assert_eq!(
        remarks(text),
        "plant.awl:1:35: REALs with seven digits, as here, may differ from the PLC's values by one bit; a dump of the data \
         block is exact"
    );
}

#[test]
fn every_error_of_a_file_is_told_with_its_place() {
    assert_refused(
        "\
DATA_BLOCK \"TIC101\"
FB 41
BEGIN
   GIAN := 2.0;
   CYCLE := S5T#20S;
   STEPS := 40000;
   MAN_ON = TRUE;
   PV_PER := 1,5;
   SP_INT := 1.0
END_DATA_BLOCK
",
        &[
            "plant.awl:4:4: PUMP has no member `GIAN`; did you mean GAIN?",
            "plant.awl:5:13: CYCLE: expected a TIME such as T#20S or T#1M30S500MS, with units in descending order, found \
             `S5T#20S`, which is an S5TIME; write T# instead of S5T#",
            "plant.awl:6:13: STEPS: expected an INT from -32768 to 32767, found `40000`",
            "plant.awl:7:11: expected `:=` after `MAN_ON`, found `=`",
            "plant.awl:8:15: expected `;` after this value, found `,`; write a decimal point, not a comma",
            "plant.awl:9:17: expected `;` after this value",
        ],
    );
}

#[test]
fn a_member_that_is_assigned_twice_is_an_error() {
    assert_refused(
        "DATA_BLOCK DB1 PUMP BEGIN\nGAIN := 2.0;\ngain := 2.0;\nEND_DATA_BLOCK",
        &["plant.awl:3:1: GAIN is assigned twice; the first assignment is on line 2"],
    );
}

#[test]
fn two_loops_of_one_name_are_an_error() {
    assert_refused(
        "DATA_BLOCK \"Tic\" PUMP BEGIN END_DATA_BLOCK\nDATA_BLOCK \"TIC\" PUMP BEGIN END_DATA_BLOCK",
        &["plant.awl:2:12: `TIC` occurs twice; the first is on line 1"],
    );
}

#[test]
fn a_file_without_a_known_block_is_an_error() {
    assert_refused(
        "DATA_BLOCK DB 8\nFB 200\nBEGIN x := 1; END_DATA_BLOCK",
        &["plant.awl:2:1: DB8 is an instance of `FB200`, which is not a known block; known blocks: PUMP (FB 41, SFB \
           41), FAN, STATION, MIXER"],
    );
    assert_refused(" \r\n", &["plant.awl: the file is empty"]);
    assert_refused(
        "(* nothing *)",
        &[
            "plant.awl: the file contains no instance data block; expected DATA_BLOCK ... END_DATA_BLOCK with the name of a block \
           before BEGIN",
        ],
    );
}

#[test]
fn a_slip_in_the_type_is_an_error_though_other_loops_can_be_read() {
    assert_refused(
        &format!("{PUMP}DATA_BLOCK DB 8\nPUPM\nBEGIN GAIN := 1.0; END_DATA_BLOCK"),
        &["plant.awl:11:1: `PUPM` is not a known block; did you mean PUMP?"],
    );
}

#[test]
fn broken_structure_is_told_and_what_follows_is_read() {
    for (text, lines) in [
        ("DATA_BLOCK DB1 PUMP BEGIN", &["plant.awl:1:12: `DB1` has no END_DATA_BLOCK"] as &[_]),
        (
            "DATA_BLOCK DB1 PUMP BEGIN\nDATA_BLOCK DB2 PUMP BEGIN X := 1; END_DATA_BLOCK",
            &["plant.awl:1:12: `DB1` has no END_DATA_BLOCK", "plant.awl:2:27: PUMP has no member `X`"],
        ),
        (
            "DATA_BLOCK DB1 PUMP GAIN := 1.0; END_DATA_BLOCK",
            &["plant.awl:1:26: expected BEGIN in the data block `DB1`, found `:=`"],
        ),
        (
            "DATA_BLOCK DB1 BEGIN END_DATA_BLOCK",
            &[
                "plant.awl:1:12: the data block `DB1` does not state which block it is an instance of; specify the block before BEGIN",
            ],
        ),
        (
            "DATA_BLOCK DB1 PUMP FAN BEGIN END_DATA_BLOCK",
            &["plant.awl:1:16: expected one block as the type of `DB1`, found several"],
        ),
        ("DATA_BLOCK ; END_DATA_BLOCK", &["plant.awl:1:12: expected a name after DATA_BLOCK, found `;`"]),
        ("hello", &["plant.awl:1:1: expected DATA_BLOCK or another block, found `hello`"]),
        ("DATA_BLOCK DB1 PUMP (* BEGIN END_DATA_BLOCK", &["plant.awl:1:21: this comment is not closed"]),
        ("DATA_BLOCK DB1 PUMP BEGIN (* END_DATA_BLOCK", &["plant.awl:1:27: this comment is not closed"]),
        (
            "DATA_BLOCK \"DB1 PUMP\nBEGIN END_DATA_BLOCK",
            &["plant.awl:1:12: expected a name after DATA_BLOCK, found `\"DB1 PUMP`, which has no closing quote"],
        ),
        (
            "DATA_BLOCK DB1 PUMP { a := 'b' BEGIN END_DATA_BLOCK",
            &[
                "plant.awl:1:21: expected `}` after these attributes, found the end",
                "plant.awl:1:52: expected BEGIN in the data block `DB1`, found the end",
            ],
        ),
        ("FUNCTION_BLOCK FB1\nVAR\n a : PUMP;\nEND_FUNCTION_BLOCK", &["plant.awl:2:1: this section has no END_VAR"]),
        (
            "DATA_BLOCK DB1 PUMP BEGIN GAIN := ;\nGAIN :=\nSP_INT := 1.0;END_DATA_BLOCK",
            &[
                "plant.awl:1:35: expected a value for `GAIN`, found `;`",
                "plant.awl:3:1: expected a value for `GAIN`, found `SP_INT`",
            ],
        ),
        (
            "DATA_BLOCK DB1 PUMP BEGIN 5 := 1.0; .x := 2; END_DATA_BLOCK",
            &["plant.awl:1:27: PUMP has no member `5`", "plant.awl:1:37: expected a member name, found `.`"],
        ),
    ] {
        assert_refused(text, lines);
    }
}

#[test]
fn an_awl_source_has_all_inputs_and_parameters() {
    let mut pump = Loop::new("DB41", blocks()[0].clone());
    pump.set(3, Value::Real(0.1), Origin::Default);
    let text = String::from_utf8(write(&[pump], "plant.awl\nloop TIC101").unwrap()).unwrap();
    let expected = "\
// plant.awl
// loop TIC101

DATA_BLOCK DB 41
TITLE =
VERSION : 0.1
FB 41
BEGIN
   MAN_ON := TRUE;
   CYCLE := T#1S;
   PV_PER := W#16#0000;
   GAIN := 1.000000e-001;
   STEPS := 200;
   SP_INT := 0.000000e+000;
END_DATA_BLOCK
";
    assert_eq!(text, expected);
}

#[test]
fn a_tia_source_quotes_what_is_the_users() {
    let loops = [Loop::new("TIC 101", blocks()[0].clone()), Loop::new("RAMP", blocks()[1].clone())];
    let text = write_tia(&loops, "").unwrap();
    assert!(text.starts_with("\u{feff}\nDATA_BLOCK \"TIC 101\"\n{ S7_Optimized_Access := 'FALSE' }\n"), "{text}");
    assert!(text.contains("\nPUMP\nBEGIN\n") && text.contains("\n\"FAN\"\nBEGIN\n   \"SET\" := FALSE;\n"), "{text}");
}

#[test]
fn what_a_source_cannot_hold_is_a_sentence() {
    let named = |name: &str| Loop::new(name, blocks()[0].clone());
    let mixer = [Loop::new("MIX", blocks()[3].clone())];
    assert_eq!(
        write(&mixer, "").unwrap_err(),
        "MIX: LEVEL is an LREAL, which STEP 7 does not support; write a source for TIA Portal"
    );
    assert!(write_tia(&mixer, "").is_ok());
    assert!(
        write(&[named(&"x".repeat(25))], "").unwrap_err().contains("STEP 7 accepts names of at most 24 characters")
    );
    assert!(write_tia(&[named("a\"b")], "").unwrap_err().contains("is not a valid data block name"));
    assert!(write(&[named("tic"), named("TIC")], "").unwrap_err().starts_with("two loops are named `TIC`"));
    assert!(write(&[named("ПИД")], "").unwrap_err().contains("rename the loop"));
    assert!(write(&[named("Ã¤")], "").unwrap_err().contains("would be read as UTF-8"));
    let mut pump = named("DB1");
    pump.set(3, Value::Real(f32::NAN), Origin::Default);
    assert_eq!(write(&[pump], "").unwrap_err(), "DB1: GAIN is NaN, which a source text cannot represent");
}

#[test]
fn names_with_umlauts_are_written_as_step_7_reads_them() {
    let bytes = write(&[Loop::new("Füllstand", blocks()[0].clone())], "für ПИД").unwrap();
    assert!(bytes.windows(9).any(|part| part == b"F\xFCllstand") && bytes.starts_with(b"// f\xFCr ???\n"));
    assert_eq!(read(&Source::new("a.awl", bytes), &blocks(), &Options::default()).unwrap().loops[0].name, "Füllstand");
}

/// A value of a type, of every size.
fn value(kind: Kind) -> BoxedStrategy<Value> {
    match kind {
        Kind::Real => {
            any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |r| r.is_finite()).prop_map(Value::Real).boxed()
        }
        Kind::LReal => any::<u64>()
            .prop_map(f64::from_bits)
            .prop_filter("finite", |r| r.is_finite())
            .prop_map(Value::LReal)
            .boxed(),
        Kind::Time => any::<i32>().prop_map(|ms| Value::Time(Time::ms(ms))).boxed(),
        Kind::Word => any::<i16>().prop_map(|word| Value::Word(Word::new(word))).boxed(),
        Kind::Int => any::<i16>().prop_map(Value::Int).boxed(),
        Kind::Bool => any::<bool>().prop_map(Value::Bool).boxed(),
        _ => unreachable!("no block has such a type"),
    }
}

/// A loop of any block with arbitrary values.
fn any_loop(blocks: Vec<Arc<BlockType>>) -> impl Strategy<Value = Loop> {
    prop::sample::select(blocks).prop_flat_map(|block| {
        let values: Vec<_> = block.members.iter().map(|member| value(member.kind)).collect();
        ("[A-Za-zäß][A-Za-z0-9_ .-]{0,20}|DB[0-9]{1,5}", values).prop_map(move |(name, values)| {
            let mut one = Loop::new(name, block.clone());
            for (member, value) in values.into_iter().enumerate() {
                one.set(member, value, Origin::Default);
            }
            one
        })
    })
}

/// Returns the name, block and values, with REALs as bits.
fn content(one: &Loop) -> (String, String, Vec<String>) {
    let values = one.settings.iter().map(|setting| match setting.value {
        Value::Real(real) => format!("{:08x}", real.to_bits()),
        Value::LReal(real) => format!("{:016x}", real.to_bits()),
        other => format!("{other:?}"),
    });
    (one.name.clone(), one.block.name.clone(), values.collect())
}

fn all_blocks() -> Vec<Arc<BlockType>> {
    blocks().into_iter().chain(BlockType::all().into_iter().filter(|block| !block.is_called("FB 41"))).collect()
}

fn assert_reads_back(bytes: Vec<u8>, one: &Loop) {
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let reading = read(&Source::new("plant", bytes), std::slice::from_ref(&one.block), &Options::default());
    let reading = reading.unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    assert_eq!(reading.loops.iter().map(content).collect::<Vec<_>>(), [content(one)], "{text}");
}

proptest! {
    #[test]
    fn an_awl_source_reads_back_bit_equal(one in any_loop([all_blocks(), BlockType::all()].concat())) {
        let has_lreal = one.block.members.iter().any(|member| member.kind == Kind::LReal && member.role.is_settable());
        match write(std::slice::from_ref(&one), "origin") {
            Ok(bytes) => assert_reads_back(bytes, &one),
            Err(message) => prop_assert!(has_lreal, "{message}"),
        }
    }

    #[test]
    fn a_tia_source_reads_back_bit_equal(one in any_loop([all_blocks(), BlockType::all()].concat())) {
        assert_reads_back(write_tia(std::slice::from_ref(&one), "origin").unwrap().into_bytes(), &one);
    }

    #[test]
    fn any_text_is_loops_or_problems(text in "(?s).{0,200}") {
        let _ = read_text(&text);
    }

    #[test]
    fn any_tokens_are_loops_or_problems(words in prop::collection::vec(prop::sample::select(WORDS), 0..60)) {
        let text = words.join(" ");
        if let Err(problems) = read_text(&text) {
            prop_assert!(!problems.problems.is_empty());
            crate::problem::drawn(&problems);
        }
    }

    #[test]
    fn a_text_with_one_damaged_byte_is_the_same_loop_or_an_error(at in 0..PUMP.len(), byte in 0x20u8..0x7F) {
        let mut bytes = PUMP.as_bytes().to_vec();
        bytes[at] = byte;
        // Whatever can be parsed has a value for each member, and nothing panics.
        if let Ok(reading) = read(&Source::new("plant.awl", bytes), &blocks(), &Options::default()) {
            prop_assert!(reading.loops.iter().all(|one| one.settings.len() == 6));
        }
    }
}

const WORDS: &[&str] = &[
    "DATA_BLOCK",
    "END_DATA_BLOCK",
    "BEGIN",
    "FB 41",
    "PUMP",
    "DB1",
    "\"TIC\"",
    "GAIN",
    ":=",
    "2.0",
    ";",
    "\n",
    ".",
    "VAR",
    "END_VAR",
    "FUNCTION_BLOCK",
    "END_FUNCTION_BLOCK",
    "TIC",
    ":",
    "STRUCT",
    "END_STRUCT",
    "{",
    "}",
    "TITLE = x",
    "FB 7",
    ",",
    "ARRAY",
    "OF",
    "T#1S",
    "IN0",
    "TRUE",
    "VERSION",
    "TYPE",
    "END_TYPE",
    "'",
    "(*",
    "*)",
    "//",
    "-",
    "STATION",
    "DI_PUMP",
];
