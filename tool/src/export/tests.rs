use super::*;
use crate::message::{LoopValue, Setup, Values};
use crate::test_home::TestHome;
use run::fmus::Fmus;
use run::master::{self, Recording};
use run::system;

fn home() -> TestHome {
    TestHome::default()
}

fn values(given: &[(&str, f64)]) -> Values {
    given.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect()
}

fn member(name: &str, fmu: &str, given: &[(&str, f64)]) -> Member {
    Member { name: name.into(), fmu: fmu.into(), values: values(given) }
}

fn setup(name: &str) -> Setup {
    let wire = |from: &str, to: &str| (from.to_string(), to.to_string());
    Setup {
        members: vec![
            member(name, "PID", &[("GAIN", 0.7), ("SP", 40.0), ("PV_IN", 3.0)]),
            member("P", "LAG", &[("CYCLE", 0.5)]),
        ],
        connections: vec![wire(&format!("{name}.OUT"), "P.POWER"), wire("P.TEMP", &format!("{name}.PV_IN"))],
        ..Setup::default()
    }
}

/// A run with a step, a ramp, manual and a setting of the plant.
fn session(name: &str) -> Session {
    let mut session = Session::default();
    session.start(&home(), setup(name)).unwrap();
    session.run(10).unwrap();
    session.send(&values(&[(&format!("{name}.SP"), 61.1), (&format!("{name}.GAIN"), 1.3)])).unwrap();
    session.ramp(&format!("{name}.SP"), 20.0, 7.0).unwrap();
    session.run(40).unwrap();
    let manual = [(format!("{name}.MAN_ON"), Value::Boolean(true)), (format!("{name}.MAN"), Value::Number(33.3))];
    session.send(&manual.into_iter().collect()).unwrap();
    session.run(30).unwrap();
    session
}

fn take(session: &Session, request: &ExportRequest) -> Exported {
    export(&home(), session, request).unwrap_or_else(|error| panic!("{error:#}"))
}

fn text(exported: &Exported) -> String {
    String::from_utf8(STANDARD.decode(&exported.content).unwrap()).unwrap()
}

fn error(session: &Session, request: &ExportRequest) -> String {
    format!("{:#}", export(&home(), session, request).unwrap_err())
}

fn one(name: &str, settings: &[(&str, f64)]) -> Loop {
    let setting = |(name, value): &(&str, f64)| LoopValue {
        name: name.to_string(),
        value: Value::Number(*value),
        origin: Some("plant.awl:3:4".into()),
        file: None,
    };
    Loop {
        name: name.into(),
        title: None,
        block: "PID".into(),
        cycle: Some(0.5),
        settings: settings.iter().map(setting).collect(),
        warnings: Vec::new(),
    }
}

fn csv_of(session: &Session) -> String {
    text(&take(session, &ExportRequest::Csv { run: None, variables: Vec::new(), inputs: false }))
}

/// Runs a description as `plcfmu run` does, and records what the session does.
fn run_description(text: &str, session: &Session) -> Recording {
    let content: toml::Table = text.parse().unwrap();
    let number = |name: &str| Some(content[name].as_float().unwrap());
    let value = |value: &toml::Value| match value {
        toml::Value::Boolean(value) => Value::Boolean(*value),
        value => Value::Number(value.as_float().unwrap()),
    };
    let setting = |(variable, given): (&String, &toml::Value), time| system::Setting {
        variable: variable.clone(),
        value: value(given),
        time,
        is_preliminary: false,
        place: None,
    };
    let table = |name: &str| content.get(name).map(|of| of.as_table().unwrap().clone()).unwrap_or_default();
    let mut system = System {
        start: number("start"),
        step: number("step"),
        stop: number("stop"),
        record: session.record(None).unwrap().columns().iter().map(|column| column.name.as_str().into()).collect(),
        ..System::default()
    };
    // The table of this crate sorts its keys, the command keeps their order: that of the text.
    let mut fmus: Vec<_> = table("fmus").into_iter().collect();
    fmus.sort_by_key(|(name, file)| text.find(&format!("{name} = {file}")).or(text.find(&format!("= {file}"))));
    for (name, file) in &fmus {
        system.members.push(system::Member { name: name.clone(), path: file.as_str().unwrap().into() });
    }
    for (from, to) in &table("connections") {
        let inputs = to.as_array().cloned().unwrap_or_else(|| vec![to.clone()]);
        system.connections.extend(inputs.iter().map(|to| Connection {
            from: from.clone(),
            to: to.as_str().unwrap().into(),
            place: None,
        }));
    }
    system.settings.extend(table("settings").iter().map(|entry| setting(entry, None)));
    for event in content.get("events").and_then(toml::Value::as_array).into_iter().flatten() {
        let time = event["time"].as_float();
        system.settings.extend(event["set"].as_table().unwrap().iter().map(|entry| setting(entry, time)));
    }
    let home = home();
    let fmu = |path: &std::path::Path| path.to_str().unwrap().strip_suffix(".fmu").unwrap().to_string();
    let names: Vec<String> = system.members.iter().map(|member| fmu(&member.path)).collect();
    let descriptions: Vec<_> = names.iter().map(|name| home.description(name).unwrap()).collect();
    let descriptions: Vec<_> = descriptions.iter().map(|of| &**of).collect();
    let plan = run::plan::Plan::new(&system, &descriptions).unwrap();
    let mut components: Vec<_> = names.iter().map(|name| home.instantiate(name, name).unwrap()).collect();
    master::run(&plan, &mut components, |_| {}).unwrap()
}

#[test]
fn a_description_runs_with_the_bits_of_the_session() {
    let session = session("C");
    let exported = take(&session, &ExportRequest::Description { run: None });
    assert_eq!((exported.file.as_str(), exported.media_type.as_str()), ("C.toml", "application/toml"));
    let text = text(&exported);
    let recording = run_description(&text, &session);
    // A row for each call, and one for the end.
    assert_eq!(recording.times.len(), 81);
    let mut csv = Vec::new();
    recording.write_csv(&mut csv).unwrap();
    let own = csv_of(&session);
    assert_eq!(String::from_utf8(csv).unwrap().lines().next(), own.lines().next());
    for ((time, row), line) in recording.rows().zip(own.lines().skip(1)) {
        let own: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(own[0].to_bits(), time.to_bits());
        assert_eq!(
            own[1..].iter().map(|value| value.to_bits()).collect::<Vec<_>>(),
            row.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        );
    }
    // The value that the connection replaces is not in it, which the command would refuse.
    assert!(!text.contains("\"C.PV_IN\" = 3"), "{text}");
    assert!(text.contains("\"C.GAIN\" = 0.7\n") && text.contains("set.\"C.MAN_ON\" = true\n"), "{text}");
}

#[test]
fn names_of_any_kind_are_quoted_in_a_description() {
    for name in ["Tank 1", "\"q\" = [", "ü'\\\n#", "a=b"] {
        let session = session(name);
        let exported = take(&session, &ExportRequest::Description { run: None });
        assert_eq!(run_description(&text(&exported), &session).times.len(), 81, "{name}");
        assert!(!exported.file.contains(['/', '\\', '"', '\n', ' ']), "{}", exported.file);
    }
}

#[test]
fn one_output_may_go_to_several_inputs() {
    let mut session = Session::default();
    let mut setup = setup("C");
    setup.connections.push(("C.OUT".into(), "P.LOAD".into()));
    session.start(&home(), setup).unwrap();
    session.run(3).unwrap();
    let text = text(&take(&session, &ExportRequest::Description { run: None }));
    assert!(text.contains("\"C.OUT\" = [\"P.POWER\", \"P.LOAD\"]"), "{text}");
    assert_eq!(run_description(&text, &session).times.len(), 4);
}

#[test]
fn a_description_ends_where_the_plant_was_exchanged() {
    let mut session = session("C");
    session.exchange(&home(), vec![member("Q", "LAG", &[])], Vec::new()).unwrap();
    session.run(5).unwrap();
    let exported = take(&session, &ExportRequest::Description { run: None });
    assert!(exported.remarks[0].contains("call 80"), "{:?}", exported.remarks);
    assert!(text(&exported).contains("stop = 40.0"));
    let mut fresh = Session::default();
    fresh.start(&home(), setup("C")).unwrap();
    assert!(error(&fresh, &ExportRequest::Description { run: None }).contains("no call"));
    assert!(error(&Session::default(), &ExportRequest::Description { run: None }).contains("start one first"));
}

#[test]
fn csv_has_the_columns_that_are_asked_for_and_reads_back() {
    let session = session("C");
    let variables = vec!["C.OUT".to_string(), "C.UP".to_string()];
    let text = text(&take(&session, &ExportRequest::Csv { run: None, variables, inputs: false }));
    assert!(text.starts_with("time,C.OUT,C.UP\n0.0,"), "{text}");
    let table = control::csv::CsvTable::read(&text).unwrap();
    let record = session.record(None).unwrap();
    let out = record.column("C.OUT").unwrap();
    for (call, value) in table.column("C.OUT").unwrap().values.iter().enumerate() {
        assert_eq!(value.to_bits(), record.trace().get(out, call).to_bits());
    }
    let wrong = ExportRequest::Csv { run: None, variables: vec!["C.OUR".into()], inputs: false };
    assert!(error(&session, &wrong).contains("did you mean C.OUT?"));
}

#[test]
fn csv_of_a_curve_has_what_a_replay_needs_and_all_that_acted() {
    let mut session = session("C");
    let header = |session: &Session| {
        let request = ExportRequest::Csv { run: None, variables: vec!["C.OUT".into()], inputs: true };
        text(&take(session, &request)).lines().next().unwrap().to_string()
    };
    let columns = |session: &Session| header(session).split(',').map(str::to_string).collect::<Vec<_>>();
    for name in ["C.OUT", "C.SP", "C.PV_IN", "C.MAN_ON", "C.MAN"] {
        assert!(columns(&session).contains(&name.to_string()), "{name}: {}", header(&session));
    }
    // GAIN was changed in the run, TI was not.
    assert!(header(&session).contains("C.GAIN") && !header(&session).contains("C.TI"), "{}", header(&session));
    assert!(!header(&session).contains("C.HIGH") && !header(&session).contains("P.LOAD"));
    session.send(&values(&[("C.HIGH", 90.0), ("P.LOAD", 5.0)])).unwrap();
    session.run(2).unwrap();
    assert!(header(&session).contains("C.HIGH") && header(&session).contains("P.LOAD"), "{}", header(&session));
}

#[test]
fn parameter_files_read_back_with_the_same_values() {
    let session = Session::default();
    let loops = vec![one("TIC101", &[("GAIN", 0.1), ("TI", 12.345), ("MAN_ON", 1.0)]), one("TIC102", &[])];
    for format in ["awl", "scl", "db", "json", "ssv"] {
        let loops = if format == "ssv" { loops[..1].to_vec() } else { loops.clone() };
        let origin = "plant\nawl".into();
        let request = ExportRequest::Parameters { format: format.into(), loops: loops.clone(), origin, stimuli: true };
        let exported = take(&session, &request);
        assert!(exported.file.ends_with(&format!(".{format}")), "{}", exported.file);
        let read = crate::describe::read(
            &home(),
            &crate::message::ReadFile {
                file: exported.file.clone(),
                content: exported.content.clone(),
                block: None,
                name: None,
            },
        );
        let read = read.unwrap();
        assert!(!read.is_refused, "{format}: {:?}", read.problems);
        assert_eq!(read.loops.len(), loops.len(), "{format}");
        let value = |name: &str| read.loops[0].settings.iter().find(|of| of.name == name).unwrap().value;
        assert_eq!(value("GAIN"), Value::Number(f64::from(0.1f32)), "{format}");
        assert_eq!(value("TI"), Value::Number(12.345), "{format}");
        assert_eq!(value("MAN_ON"), Value::Boolean(true), "{format}");
    }
    let request = |format: &str, loops: Vec<Loop>| ExportRequest::Parameters {
        format: format.into(),
        loops,
        origin: String::new(),
        stimuli: false,
    };
    assert!(error(&session, &request("docx", loops.clone())).contains("awl, scl"));
    assert!(error(&session, &request("awl", Vec::new())).contains("no loop"));
    assert!(error(&session, &request("awl", vec![one("A", &[("NOPE", 1.0)])])).contains("no setting \"NOPE\""));
}

#[test]
fn a_parameter_file_has_the_settings_and_not_what_they_were_tried_with() {
    let mut tried = one("TIC101", &[("GAIN", 0.1), ("SP", 60.0), ("MAN", 20.0), ("MAN_ON", 1.0)]);
    tried.settings[1].file = Some(Value::Number(42.0));
    let written = |stimuli: bool| {
        let (format, origin) = ("json".into(), String::new());
        let request = ExportRequest::Parameters { format, loops: vec![tried.clone()], origin, stimuli };
        let json: serde_json::Value = serde_json::from_str(&text(&take(&Session::default(), &request))).unwrap();
        ["GAIN", "SP", "MAN", "MAN_ON"].map(|name| json["TIC101"][name].to_string())
    };
    assert_eq!(written(true), ["0.1", "60.0", "20.0", "true"]);
    assert_eq!(written(false), ["0.1", "42.0", "0.0", "false"]);
}

#[test]
fn an_opened_source_comes_back_with_one_value_changed() {
    let awl = "DATA_BLOCK \"TIC101\"\nTITLE = \u{d6}fen\nPID\nBEGIN\n GAIN := 2.0; SP := 42.0;\nEND_DATA_BLOCK\n";
    let bytes: Vec<u8> = awl.chars().map(|letter| letter as u8).collect();
    let content = STANDARD.encode(&bytes);
    let file = ReadFile { file: "lines/plant.awl".into(), content, block: None, name: None };
    let mut tried = one("TIC101", &[("GAIN", 0.1), ("SP", 60.0), ("MAN", 20.0)]);
    tried.settings[1].file = Some(Value::Number(42.0));
    let request = ExportRequest::Source { file: file.clone(), loops: vec![tried.clone()], stimuli: false };
    let exported = take(&Session::default(), &request);
    assert_eq!((exported.file.as_str(), exported.media_type.as_str()), ("plant.awl", "text/plain"));
    let expected: Vec<u8> = awl.replace(":= 2.0", ":= 0.1").chars().map(|letter| letter as u8).collect();
    assert_eq!(STANDARD.decode(&exported.content).unwrap(), expected);
    assert_eq!(exported.remarks, ["TIC101: GAIN was changed (lines/plant.awl:5:10)"]);
    let request = ExportRequest::Source { file: file.clone(), loops: vec![tried], stimuli: true };
    assert!(error(&Session::default(), &request).contains("no replaceable value of MAN in TIC101"));
    let request = ExportRequest::Source { file, loops: vec![one("TIC9", &[])], stimuli: false };
    assert_eq!(error(&Session::default(), &request), "lines/plant.awl has no loop \"TIC9\" with the block PID");
}

#[test]
fn a_preset_is_what_the_home_makes() {
    let session = Session::default();
    let exported = take(&session, &ExportRequest::Preset { of: one("../TIC 101", &[]) });
    assert_eq!((exported.file.as_str(), text(&exported).as_str()), ("_TIC_101.fmu", "../TIC 101"));
}

#[test]
fn requests_are_read_as_the_page_writes_them() {
    let json =
        r#"{"what": "report", "of": {"name": "A", "block": "PID", "cycle": 0.5, "settings": [], "warnings": []}}"#;
    assert!(matches!(serde_json::from_str(json).unwrap(), ExportRequest::Report { run: None, .. }));
    assert!(serde_json::from_str::<ExportRequest>(r#"{"what": "csv"}"#).is_ok());
}
