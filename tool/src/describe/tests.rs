use super::*;
use crate::test_home::{FOREIGN, TestHome};

fn check_pid(given: &[(&str, Value)]) -> Checked {
    let values: Values = given.iter().map(|(name, value)| (name.to_string(), *value)).collect();
    check(&TestHome::default(), "PID", &values).unwrap()
}

fn texts(checked: &Checked) -> Vec<(&str, bool)> {
    checked.remarks.iter().map(|remark| (remark.text.as_str(), remark.is_error)).collect()
}

fn file(name: &str, text: &str) -> ReadFile {
    ReadFile { file: name.into(), content: STANDARD.encode(text), block: None, name: None }
}

#[test]
fn an_fmu_has_its_variables_groups_and_roles() {
    let description = describe(&TestHome::default(), "PID").unwrap();
    assert_eq!((description.block.as_str(), description.summary.as_str()), ("PID", "A PI controller."));
    assert_eq!(
        (description.aliases.as_slice(), description.cycle.as_deref()),
        (["FB 7".to_string()].as_slice(), Some("CYCLE"))
    );
    let of = |name: &str| description.variables.iter().find(|of| of.name == name).unwrap();
    let sp = Variable {
        name: "SP".into(),
        description: "Setpoint".into(),
        kind: "REAL".into(),
        role: "input".into(),
        is_tunable: true,
        is_stimulus: true,
        start: Value::Number(0.0),
        min: Some(-100.0),
        max: Some(100.0),
        unit: Some("degC".into()),
    };
    assert_eq!(of("SP"), &sp);
    let ti = of("TI");
    assert_eq!((ti.start, ti.unit.as_deref(), ti.is_tunable), (Value::Number(20.0), Some("s"), true));
    assert_eq!((of("P_SEL").start, of("P_SEL").role.as_str()), (Value::Boolean(true), "parameter"));
    assert!(!of("BITS").is_tunable && !of("CYCLE").is_tunable && !of("OUT").is_tunable);
    assert_eq!(description.groups[1].title, "Gain and time");
    assert_eq!(description.roles.setpoint.as_deref(), Some("SP"));
}

#[test]
fn a_foreign_fmu_has_what_its_model_description_says() {
    let description = describe(&TestHome::default(), FOREIGN).unwrap();
    assert_eq!((description.part, description.cycle), (LoopRole::Plant, None));
    let of = |name: &str| description.variables.iter().find(|of| of.name == name).unwrap();
    assert_eq!((of("POWER").kind.as_str(), of("POWER").unit.as_deref()), ("Real", Some("%")));
    assert_eq!((of("HEAT").kind.as_str(), of("HEAT").start), ("Boolean", Value::Boolean(false)));
    assert_eq!((of("CYCLE").role.as_str(), of("CYCLE").min), ("fixed", Some(0.001)));
    let groups: Vec<_> = description.groups.iter().map(|group| (group.title.as_str(), group.fields.len())).collect();
    assert_eq!(groups, [("Inputs", 4), ("Parameters", 3)]);
    assert!(describe(&TestHome::default(), "NO_SUCH").is_err());
}

#[test]
fn settings_without_effect_are_named() {
    assert_eq!(check_pid(&[]).unused, ["MAN"]);
    assert_eq!(check_pid(&[("I_SEL", Value::Boolean(false)), ("MAN_ON", Value::Boolean(true))]).unused, ["TI", "HIGH"]);
    let none = [("I_SEL", Value::Boolean(false)), ("P_SEL", Value::Number(0.0))];
    assert_eq!(check_pid(&none).unused, ["GAIN", "TI", "MAN"]);
}

#[test]
fn what_the_block_will_do_names_the_settings_that_it_is_about() {
    let checked = check_pid(&[("TI", Value::Number(0.02))]);
    assert_eq!(texts(&checked), [("TI = 0.02 s is raised to CYCLE/2 = 0.25 s.", false)]);
    assert_eq!(checked.remarks[0].variables, ["TI", "CYCLE"]);
    // With a shorter cycle it is not raised.
    assert!(check_pid(&[("TI", Value::Number(0.02)), ("CYCLE", Value::Number(0.01))]).remarks.is_empty());
}

#[test]
fn values_that_the_type_does_not_hold_are_errors_and_others_are_rounded() {
    let checked = check_pid(&[
        ("GAIN", Value::Number(0.1)),
        ("TI", Value::Number(1.23456)),
        ("HIGH", Value::Number(0.5)),
        ("SP", Value::Number(101.0)),
    ]);
    let rounded =
        Values::from([("GAIN".into(), Value::Number(f64::from(0.1f32))), ("TI".into(), Value::Number(1.235))]);
    assert_eq!(checked.rounded, rounded);
    assert_eq!(texts(&checked), [("SP = 101 °C: the highest sensible value is 100 °C", false)]);
    let cases = [
        (
            "GAIN",
            Value::Number(1e39),
            "GAIN = 1e39: a REAL accepts finite numbers with a magnitude of at most 3.4028235e38",
        ),
        ("GAIN", Value::Number(f64::NAN), "GAIN = NaN: not a finite number"),
        ("GAIN", Value::Boolean(true), "GAIN is of type REAL: true is not a number"),
        ("TI", Value::Number(-1.0), "TI = -1.0: a TIME accepts 0 ... 2147483.647 s"),
        ("BITS", Value::Number(0.5), "BITS = 0.5: an INT accepts -32768 ... 32767"),
        ("MAN_ON", Value::Number(2.0), "MAN_ON = 2.0: a BOOL accepts 0 and 1"),
        ("CYCLE", Value::Number(0.0001), "CYCLE = 0.0001 s: the time between two calls must be at least 0.001 s"),
        ("OUT", Value::Number(1.0), "OUT cannot be set: its role is output; only inputs and parameters can be set"),
        ("<i>", Value::Number(1.0), "no variable \"<i>\""),
    ];
    for (name, value, expected) in cases {
        let checked = check_pid(&[(name, value)]);
        assert_eq!(texts(&checked), [(expected, true)]);
        assert_eq!(checked.remarks[0].variables, [name]);
    }
}

#[test]
fn a_foreign_fmu_is_checked_by_its_model_description() {
    let of = |name: &str, value| check(&TestHome::default(), FOREIGN, &Values::from([(name.into(), value)])).unwrap();
    assert_eq!(texts(&of("CYCLE", Value::Number(0.0))), [("CYCLE = 0 s: the lowest sensible value is 0.001 s", false)]);
    assert_eq!(texts(&of("HEAT", Value::Number(0.5))), [("HEAT = 0.5: a Boolean must be 0 (FALSE) or 1 (TRUE)", true)]);
    assert_eq!(of("K", Value::Number(0.1)), Checked::default());
}

const JSON: &str = r#"{"TIC101": {"block": "PID", "values": {"GAIN": 3.5, "TI": 0.02, "MAN_ON": true}}}"#;

#[test]
fn a_file_is_read_with_the_origin_of_each_value_and_what_the_block_will_do() {
    let source =
        parameters::write(Format::Json, &[parameters::Loop::new("TIC101", TestHome::default().blocks().remove(0))], "")
            .map(|bytes| String::from_utf8(bytes).unwrap())
            .unwrap();
    let loops = read(&TestHome::default(), &file("plant.JSON", &source.replace("20.0", "0.02"))).unwrap();
    assert!(!loops.is_refused && loops.problems.is_empty(), "{loops:?} {JSON}");
    let one = &loops.loops[0];
    assert_eq!((one.name.as_str(), one.block.as_str(), one.cycle), ("TIC101", "PID", Some(0.5)));
    let ti = one.settings.iter().find(|setting| setting.name == "TI").unwrap();
    assert_eq!(ti.value, Value::Number(0.02));
    assert!(ti.origin.as_ref().unwrap().starts_with("plant.JSON:"), "{ti:?}");
    assert_eq!(one.warnings, ["TI = 0.02 s is raised to CYCLE/2 = 0.25 s."]);

    let back = as_loop(&TestHome::default(), one).unwrap();
    assert_eq!(
        as_message(&back).settings.iter().map(|of| of.value).collect::<Vec<_>>(),
        one.settings.iter().map(|of| of.value).collect::<Vec<_>>()
    );
}

#[test]
fn a_file_that_cannot_be_used_says_where_and_what_to_do() {
    let home = TestHome::default();
    let wrong = read(&home, &file("plant.json", "{\n  \"TIC101\": oops\n}")).unwrap();
    assert!(wrong.is_refused && wrong.loops.is_empty());
    assert_eq!(wrong.problems[0].place.unwrap().0, 2);
    for name in ["plant.exe", "plant", "<script>.html", ""] {
        let wrong = read(&home, &file(name, "x")).unwrap();
        assert!(wrong.is_refused && wrong.problems[0].message.ends_with(": not a parameter file (unknown extension)"));
        assert!(wrong.problems[0].help.as_ref().unwrap().contains(".awl"));
    }
    let not_base64 = ReadFile { content: "?".into(), ..file("plant.awl", "") };
    assert!(
        format!("{:#}", read(&home, &not_base64).unwrap_err()).starts_with("the content of plant.awl is not Base64")
    );
}

#[test]
fn a_loop_of_an_unknown_block_or_with_an_unknown_setting_is_refused() {
    let setting =
        |name: &str, value| LoopValue { name: name.into(), value: Value::Number(value), origin: None, file: None };
    let one = |block: &str, settings| Loop {
        name: "A".into(),
        title: None,
        block: block.into(),
        cycle: None,
        settings,
        warnings: vec![],
    };
    let error = |one: &Loop| format!("{:#}", as_loop(&TestHome::default(), one).unwrap_err());
    assert_eq!(error(&one("PUMP", vec![])), "A: no block \"PUMP\" in the catalogue");
    assert_eq!(error(&one("fb7", vec![setting("OUT", 1.0)])), "A: PID has no setting \"OUT\"");
    assert_eq!(error(&one("PID", vec![setting("BITS", 0.5)])), "A: BITS = 0.5: an INT accepts -32768 ... 32767");
}
