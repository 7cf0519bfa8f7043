use super::*;
// The crate as others see it, which is another one than that with the tests.
use doubles::{Fmus, TestHome};

fn table(fence: &str) -> Table {
    let mut table = (*TestHome::default().table("PID").unwrap().unwrap()).clone();
    table.docs = format!(" A block.\n\n ```dialog\n{fence}\n ```\n\n More.");
    table
}

const REST: &str = "SP, PV_IN, MAN_ON, MAN, STOP_HIGH, P_SEL, GAIN, TI, HIGH, BITS, CYCLE";

fn error(fence: &str) -> String {
    format!("{:#}", read(&table(fence)).unwrap_err())
}

#[test]
fn a_block_says_what_its_variables_are_in_a_loop() {
    let home = TestHome::default();
    let (roles, groups) = read(&home.table("PID").unwrap().unwrap()).unwrap();
    let text = |name: &str| Some(name.to_string());
    let list = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
    let expected = Roles {
        setpoint: text("SP"),
        process_value: text("PV_IN"),
        shown_process_value: text("PV"),
        manipulated_value: text("OUT"),
        manual: Some(("MAN_ON".into(), "MAN".into())),
        controller: list(&["GAIN", "TI"]),
        structure: list(&["P_SEL", "I_SEL"]),
        pulses: list(&["UP", "DOWN"]),
        signals: vec![("high stop".into(), "STOP_HIGH".into())],
        ..Roles::default()
    };
    assert_eq!(roles, expected);
    assert_eq!(roles.part(&home.table("PID").unwrap().unwrap()), LoopRole::Controller);
    let titles: Vec<_> = groups.iter().map(|group| group.title.as_str()).collect();
    assert_eq!(titles, ["Process value", "Gain and time", "Manual and limits"]);

    let table = home.table("LAG").unwrap().unwrap();
    let (roles, _) = read(&table).unwrap();
    assert_eq!((roles.process_value.as_deref(), roles.shown_process_value.as_deref()), (Some("TEMP"), Some("TEMP")));
    assert_eq!((roles.disturbances.as_slice(), roles.part(&table)), (list(&["LOAD"]).as_slice(), LoopRole::Plant));
}

#[test]
fn and_binds_tighter_than_or() {
    let (_, groups) = read(&table(&format!("[A]\nI_SEL if P_SEL and not MAN_ON or STOP_HIGH\n{REST}"))).unwrap();
    let field = &groups[0].fields[0];
    let switch = |name: &str, wanted| (name.to_string(), wanted);
    assert_eq!(field.used_if, [vec![switch("P_SEL", true), switch("MAN_ON", false)], vec![switch("STOP_HIGH", true)]]);
    let is_used = |on: &[&str]| field.is_used(|name| on.contains(&name));
    assert!(is_used(&["P_SEL"]) && is_used(&["STOP_HIGH", "MAN_ON"]));
    assert!(!is_used(&["P_SEL", "MAN_ON"]) && !is_used(&[]));
    assert!(groups[0].fields[1].is_used(|_| false), "without a condition it is always used");
}

#[test]
fn a_block_without_a_dialog_has_its_inputs_and_its_parameters() {
    let mut table = table("");
    table.docs = "A block.".into();
    let (roles, groups) = read(&table).unwrap();
    assert_eq!(roles, Roles::default());
    let names = |group: &Group| group.fields.iter().map(|field| field.name.clone()).collect::<Vec<_>>().join(", ");
    assert_eq!((groups[0].title.as_str(), names(&groups[0]).as_str()), ("Inputs", "SP, PV_IN, MAN_ON, MAN, STOP_HIGH"));
    assert_eq!(
        (groups[1].title.as_str(), names(&groups[1]).as_str()),
        ("Parameters", "P_SEL, I_SEL, GAIN, TI, HIGH, BITS, CYCLE")
    );
}

#[test]
fn what_cannot_be_read_is_named_with_its_line() {
    let all = format!("[A]\n{REST}, I_SEL");
    let begins = "PID: the dialog line ";
    let cases = [
        ("setpoint: SPP", r#"the dialog line "setpoint: SPP": no variable "SPP"; did you mean SP?"#),
        (
            "set point: SP",
            r#"the dialog line "set point: SP": "set point" is not a role; available: setpoint, process value"#,
        ),
        ("setpoint: SP, MAN", "setpoint can have at most one name"),
        ("manual: MAN", "manual needs two names: the switch and the value"),
        ("SP, PV_IN", "write ROLE: NAMES, or [Title] to begin a group"),
        ("signal : SP", "is not a role"),
        ("[A", "a title must end with ]"),
        ("[ ]", "the title is empty"),
    ];
    for (line, expected) in cases {
        let error = error(&format!("{line}\n{all}"));
        assert!(error.starts_with(begins) && error.contains(expected), "{line}: {error}");
    }
    let cases = [
        ("GAIN if", r#"no variable "GAIN if""#),
        ("GAIN if P_SEL and", "write NAME or `not NAME`"),
        ("GAIN if P_SEL I_SEL", "write NAME or `not NAME`"),
        ("GAIN if OUT", "OUT is neither an input nor a parameter"),
        ("OUT", "OUT is output: only inputs and parameters can be in groups"),
    ];
    for (line, expected) in cases {
        let error = error(&format!("{all}\n{line}"));
        assert!(error.contains(expected), "{line}: {error}");
    }
}

#[test]
fn each_setting_is_in_one_group() {
    assert_eq!(error(&format!("[A]\n{REST}")), "PID: I_SEL is not in any group of its dialog: add it to one");
    assert_eq!(
        error(&format!("[A]\n{REST}, I_SEL\n[B]\nSP")),
        "PID: SP appears in its dialog more than once: keep it in one group"
    );
}

#[test]
fn a_dialog_ends_and_there_is_one() {
    let mut table = table("");
    table.docs = "```dialog\n[A]\n".into();
    assert_eq!(read(&table).unwrap_err().to_string(), "a dialog must end with the line ```");
    table.docs = "```dialog\n```\n```dialog\n```\n".into();
    assert_eq!(read(&table).unwrap_err().to_string(), "there are two dialogs: remove one");
}
