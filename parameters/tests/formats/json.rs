use super::*;

#[test]
fn an_object_for_each_loop_has_the_names_and_numbers_of_the_fmu() {
    let text = r#"{
  "TIC101": {"ON": true, "TI": 0.021, "GAIN": 1e-3, "COUNT": -7},
  "TIC 102": {"TRAVEL": 3}
}"#;
    let loops = loops(Format::Json, text);
    let [pump, valve] = loops.as_slice() else { panic!("{loops:?}") };
    assert_eq!((pump.name.as_str(), pump.block.name.as_str()), ("TIC101", "PUMP"));
    assert_eq!(pump.get("ON"), Some(Value::Bool(true)));
    assert_eq!(pump.get("TI"), Some(Value::Time(Time::ms(21))));
    assert_eq!(pump.get("GAIN"), Some(Value::Real(0.001)));
    assert_eq!(pump.get("COUNT"), Some(Value::Int(-7)));
    assert_eq!((valve.name.as_str(), valve.block.name.as_str()), ("TIC 102", "VALVE"));
    assert_eq!(origin(pump, "GAIN"), "plant.json:2:47");
}

#[test]
fn a_missing_member_has_the_start_value_of_the_block() {
    let one = &loops(Format::Json, r#"{"A": {"MAN_ON": false}}"#)[0];
    assert_eq!(given(one), ["MAN_ON"]);
    assert_eq!(one.get("GAIN"), Some(Value::Real(2.0)));
    assert_eq!(origin(one, "GAIN"), "default");
}

#[test]
fn an_object_of_numbers_alone_is_a_loop_called_as_the_file_or_as_the_user_says() {
    let text = r#"{"MAN": 3}"#;
    assert_eq!(loops(Format::Json, text)[0].name, "plant");
    let options = Options { name: Some("TIC7".into()), ..Options::default() };
    assert_eq!(reading(Format::Json, text, &options).unwrap().loops[0].name, "TIC7");
}

#[test]
fn a_word_is_signed_or_unsigned() {
    for (text, value) in [("65535", -1), ("-32768", -32768), ("27648", 27648)] {
        let one = &loops(Format::Json, format!(r#"{{"PV_PER": {text}}}"#))[0];
        assert_eq!(one.get("PV_PER"), Some(Value::Word(Word::new(value))));
    }
}

#[test]
fn a_loop_whose_names_fit_several_blocks_needs_the_block() {
    let text = r#"{"TIC101": {"GAIN": 3}}"#;
    assert_eq!(
        refusal(Format::Json, text),
        "plant.json:1:2: `TIC101`: several blocks have these inputs and parameters; specify it with --block (available: PUMP, VALVE)"
    );
    assert_eq!(reading(Format::Json, text, &of_block("VALVE")).unwrap().loops[0].block.name, "VALVE");
}

#[test]
fn the_block_of_the_user_is_that_of_the_only_loop_and_of_several_that_of_those_which_it_fits() {
    let alone = reading(Format::Json, r#"{"A": {"TRAVEL": 3}}"#, &of_block("PUMP")).unwrap_err().to_string();
    assert_eq!(alone, "plant.json:1:8: PUMP has no input or parameter `TRAVEL`");
    let several = r#"{"A": {"TRAVEL": 3}, "B": {"GAIN": 1}}"#;
    let loops = reading(Format::Json, several, &of_block("PUMP")).unwrap().loops;
    let blocks: Vec<_> = loops.iter().map(|one| one.block.name.as_str()).collect();
    assert_eq!(blocks, ["VALVE", "PUMP"]);
}

#[test]
fn of_blocks_that_have_all_names_the_one_that_misses_none_is_meant() {
    let small = BlockType::new("SMALL".into(), Vec::new(), vec![Row::new("GAIN", Role::Parameter, Value::Real(1.0))]);
    let mut blocks = all();
    blocks.push(Arc::new(small));
    let source = Source::new("a.json", br#"{"GAIN": 3}"#.to_vec());
    let reading = read(Format::Json, &source, &blocks, &Options::default()).unwrap();
    assert_eq!(reading.loops[0].block.name, "SMALL");
}

#[test]
fn every_error_has_its_place_and_all_are_told() {
    let text = "{\n  \"A\": {\n    \"GAINN\": 1,\n    \"TI\": \"x\",\n    \"LMN\": 3,\n    \"MAN_ON\": 1,\n    \"PV_PER\": 0.5,\n    \
                \"gain\": 2, \"GAIN\": 2,\n    \"MAN\": 1e39,\n    \"SUM\": null\n  },\n  \"B\": 3\n}";
    assert_eq!(
        refusal(Format::Json, text),
        "plant.json:3:5: PUMP has no input or parameter `GAINN`; did you mean GAIN?\n\
         plant.json:4:11: TI: expected a number of seconds, found a string\n\
         plant.json:5:5: LMN of PUMP is an output: only inputs and parameters can be set\n\
         plant.json:6:15: MAN_ON: expected true or false, found `1`\n\
         plant.json:7:15: PV_PER: found `0.5`, but a WORD accepts -32768 ... 65535\n\
         plant.json:8:16: GAIN appears twice: remove one\n\
         plant.json:9:12: MAN: found `1e39`, but a REAL accepts finite numbers with a magnitude of at most 3.4028235e38\n\
         plant.json:10:12: SUM: expected a number, found null\n\
         plant.json:12:8: `B`: expected an object with the values of a loop, found a number; move it into the loop to which it belongs, or remove it"
    );
}

#[test]
fn a_loop_that_no_block_fits_is_refused() {
    assert_eq!(
        refusal(Format::Json, r#"{"A": {"X": 1, "Y": 2, "GAIN": 1}}"#),
        "plant.json:1:2: `A`: no block has these inputs and parameters; specify it with --block (available: PUMP, VALVE, STATION)"
    );
}

#[test]
fn what_is_not_json_is_refused_with_its_place() {
    for (text, sentence) in [
        ("", "plant.json: expected a JSON object with loops, found an empty file"),
        ("[1]", "plant.json:1:1: expected an object with loops, found an array"),
        ("{}", "plant.json: the file contains no loop"),
        ("{\"A\": {\"GAIN\": 1}, \"A\": {}}", "plant.json:1:20: the loop `A` appears twice: remove or rename one"),
        ("{\"A\": {\"MAN\": 1,}}", "plant.json:1:16: this is not JSON"),
        ("{\"A\": {\"MAN\": NaN}}", "plant.json:1:15: this is not JSON"),
        ("{\"A\": {\"MAN\": 1} // no\n}", "plant.json:1:18: this is not JSON"),
        ("{\"MAN\": 1} {}", "plant.json:1:12: this is not JSON"),
        ("{\n \"ä\": {'MAN': 1}}", "plant.json:2:8: this is not JSON"),
    ] {
        let error = refusal(Format::Json, text);
        assert!(error.lines().any(|line| line.starts_with(sentence)), "{text}: {error}");
    }
}

#[test]
fn a_byte_order_mark_is_skipped_and_places_stay_right() {
    let one = &loops(Format::Json, "\u{feff}{\n\"MAN\": 3}")[0];
    assert_eq!(origin(one, "MAN"), "plant.json:2:8");
}

#[test]
fn a_file_is_written_in_the_order_of_the_block_with_the_shortest_decimals() {
    let mut one = Loop::new("TIC \"101\"", pump());
    one.set(5, Value::Real(0.1), Origin::Default);
    let expected = r#"{
  "TIC \"101\"": {
    "ON": false,
    "MAN_ON": true,
    "MAN": 5.0,
    "PV_PER": 0,
    "COUNT": 3,
    "GAIN": 0.1,
    "SUM": 0.1,
    "TI": 20.0,
    "CYCLE": 1.0
  }
}
"#;
    assert_eq!(String::from_utf8(parameters::write(Format::Json, &[one], "").unwrap()).unwrap(), expected);
}

#[test]
fn what_the_file_cannot_hold_is_not_written() {
    let mut one = Loop::new("A", pump());
    one.set(5, Value::Real(f32::INFINITY), Origin::Default);
    assert_eq!(
        parameters::write(Format::Json, &[one], ""),
        Err("A: GAIN is inf, but JSON has only finite numbers".into())
    );
    for format in [Format::Json, Format::Ssv, Format::Openness] {
        let error = parameters::write(format, &[Loop::new("A", pump()), Loop::new("A", valve())], "").unwrap_err();
        assert_eq!(error, "two loops are called A: rename one, or write only one");
    }
}
