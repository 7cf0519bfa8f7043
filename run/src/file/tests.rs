use super::*;
use crate::system::Setting;
use std::path::PathBuf;

/// A folder with the files of FMUs, which need no content to be named, and a description.
/// Reads the text formats alone.
fn parameters(name: &str, options: &Options) -> Result<Reading> {
    let source = Source::read(Path::new(name), None).map_err(anyhow::Error::msg)?;
    let format = parameters::Format::of_file(name).unwrap();
    Ok(parameters::read(format, &source, &parameters::BlockType::all(), options)?)
}

fn folder(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for name in ["PID.fmu", "FURNACE.fmu"] {
        fs::write(folder.path().join(name), "").unwrap();
    }
    let path = folder.path().join("loop.toml");
    fs::write(&path, text).unwrap();
    (folder, path)
}

fn system(text: &str) -> System {
    let (_folder, path) = folder(text);
    read(&path, None, parameters).unwrap()
}

/// Returns the error, with `loop.toml` in place of the path.
fn error(text: &str) -> String {
    let (folder, path) = folder(text);
    let sentence = format!("{:#}", read(&path, None, parameters).unwrap_err());
    sentence.replace(&format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR), "")
}

const FMUS: &str = "[fmus]\nPID = \"PID.fmu\"\nFURNACE = \"FURNACE.fmu\"\n";

fn names(system: &System) -> Vec<(&str, Value, Option<f64>)> {
    system.settings.iter().map(|of| (of.variable.as_str(), of.value, of.time)).collect()
}

#[test]
fn a_description_says_all_that_a_run_needs() {
    let system = system(
        r#"
        start = 1
        stop = 600.0
        step = 0.5
        exchange = "parallel"
        record = ["FURNACE.TEMP", "PID.OUT"]
        fmus = { FURNACE = "FURNACE.fmu", PID = "PID.fmu" }
        [connections]
        PID.OUT = ["FURNACE.POWER", "PID.TRACK"]
        [settings]
        PID.GAIN = 2
        PID.ON = true
        [[events]]
        time = 300.0
        set = { PID.SP = 80.0, FURNACE.DOOR = 50.0 }
        "#,
    );
    assert_eq!((system.start, system.stop, system.step), (Some(1.0), Some(600.0), Some(0.5)));
    assert_eq!(system.exchange, Exchange::Parallel);
    let members: Vec<_> = system.members.iter().map(|member| member.name.as_str()).collect();
    assert_eq!(members, ["FURNACE", "PID"], "the order of the file, not that of the alphabet");
    assert!(system.members[0].path.ends_with("FURNACE.fmu") && system.members[0].path.is_absolute());
    let record: Vec<_> = system.record.iter().map(|of| of.variable.as_str()).collect();
    assert_eq!(record, ["FURNACE.TEMP", "PID.OUT"]);
    let connections: Vec<_> = system.connections.iter().map(|of| (of.from.as_str(), of.to.as_str())).collect();
    assert_eq!(connections, [("PID.OUT", "FURNACE.POWER"), ("PID.OUT", "PID.TRACK")]);
    assert_eq!(
        names(&system),
        [
            ("PID.GAIN", Value::Number(2.0), None),
            ("PID.ON", Value::Boolean(true), None),
            ("PID.SP", Value::Number(80.0), Some(300.0)),
            ("FURNACE.DOOR", Value::Number(50.0), Some(300.0)),
        ]
    );
}

#[test]
fn points_of_names_are_points_of_keys_or_tables() {
    let written = |settings: &str| {
        let system = system(&format!("{FMUS}{settings}"));
        names(&system).into_iter().map(|(name, ..)| name.to_string()).collect::<Vec<_>>()
    };
    for settings in [
        "[settings]\nPID.INNER.GAIN = 2\n",
        "[settings]\n\"PID.INNER.GAIN\" = 2\n",
        "[settings]\nPID = { INNER = { GAIN = 2 } }\n",
        "[settings.PID]\nINNER.GAIN = 2\n",
        "[settings.PID.INNER]\nGAIN = 2\n",
    ] {
        assert_eq!(written(settings), ["PID.INNER.GAIN"], "{settings}");
    }
}

#[test]
fn messages_of_the_reader_name_types_in_the_words_of_a_user() {
    for (message, expected) in [
        ("invalid type: string \"max\", expected a sequence", "expected a list; found the string \"max\""),
        ("invalid type: map, expected a sequence", "expected a list; found a table: write [[NAME]] instead of [NAME]"),
        ("invalid value: integer `-3`, expected u64", "expected a whole number >= 0; found -3"),
        ("invalid type: floating point `5.5`, expected u64", "expected a whole number >= 0; found 5.5"),
        ("invalid type: string \"x\", expected f64\nin `min`\n", "expected a number; found the string \"x\"; in `min`"),
        ("unknown field `a`, expected `b` or `c`", "unknown field `a`, expected `b` or `c`"),
    ] {
        assert_eq!(super::plain(message), expected);
    }
}

#[test]
fn an_error_names_the_place_and_what_is_expected() {
    for (text, expected) in [
        ("step = \n", "loop.toml:1:8: "),
        ("stp = 1\n", "loop.toml:1:1: unknown field `stp`, expected one of `start`, `stop`, `step`"),
        ("step = \"1\"\n", "loop.toml:1:8: expected a finite number, the time in seconds; found the string \"1\""),
        ("stop = inf\n", "loop.toml:1:8: expected a finite number, the time in seconds; found inf"),
        ("exchange = \"jacobi\"\n", "loop.toml:1:12: unknown variant `jacobi`, expected `sequential` or `parallel`"),
        ("record = [\"A.B\", 1]\n", "loop.toml:1:18: "),
    ] {
        let sentence = error(&format!("{text}{FMUS}"));
        assert!(sentence.starts_with(expected), "{text}: {sentence}");
        assert!(!sentence.contains('\n'), "{sentence}");
    }
    for (text, expected) in [
        (
            "[settings]\nPID.GAIN = \"2\"\n",
            "loop.toml:5:12: expected a finite number, true or false; found the string \"2\"",
        ),
        ("[settings]\nPID.GAIN = [2]\n", "loop.toml:5:12: expected a finite number, true or false; found a list"),
        (
            "[connections]\nPID.OUT = 5\n",
            "loop.toml:5:11: expected the name of an input, \"FMU.INPUT\", or a list of such names; found 5",
        ),
        ("[[events]]\nset.PID.SP = 5\n", "loop.toml:4:1: missing field `time`"),
        (
            "[parameters]\nPDI = { file = \"x.json\" }\n",
            "loop.toml:5:1: no PDI; available: PID, FURNACE; did you mean PID?",
        ),
    ] {
        let sentence = error(&format!("{FMUS}{text}"));
        assert_eq!(sentence.lines().next().unwrap(), expected);
    }
    assert_eq!(error("[fmus]\nPID = \"PDI.fmu\"\n"), "loop.toml:2:7: no file PDI.fmu; did you mean PID.fmu?");
    assert_eq!(error("fmus = {}\n"), "loop.toml: [fmus] is empty: write a line NAME = \"FILE.fmu\" for each FMU");
    assert!(error("").contains("missing field `fmus`"));
}

#[test]
fn fmus_may_be_in_another_folder() {
    let (fmus, _) = folder("");
    let (folder, path) = folder(FMUS);
    for name in ["PID.fmu", "FURNACE.fmu"] {
        fs::remove_file(folder.path().join(name)).unwrap();
    }
    let system = read(&path, Some(fmus.path()), parameters).unwrap();
    assert_eq!(system.members[0].path, fmus.path().join("PID.fmu"));
    let sentence = format!("{:#}", read(&path, None, parameters).unwrap_err());
    assert!(
        sentence.ends_with("; FMU paths are relative to the folder of this file, or to --fmus FOLDER"),
        "{sentence}"
    );
    let sentence = format!("{:#}", read(&path, Some(&folder.path().join("none")), parameters).unwrap_err());
    assert!(sentence.ends_with("; specify their folder with --fmus, or correct the path"), "{sentence}");
}

/// Returns the system without positions in a file.
fn plain(mut system: System) -> System {
    system.settings.iter_mut().for_each(|of| of.place = None);
    system.connections.iter_mut().for_each(|of| of.place = None);
    system.record.iter_mut().for_each(|of| of.place = None);
    system
}

#[test]
fn what_is_written_reads_back() {
    let (folder, path) = folder("");
    let setting = |text: &str| text.parse::<Setting>().unwrap();
    let at = |name: &str| folder.path().canonicalize().unwrap().join(name);
    let system = System {
        members: [("b", "PID.fmu"), ("a", "FURNACE.fmu")]
            .map(|(name, file)| Member { name: name.into(), path: at(file) })
            .into(),
        settings: vec![
            setting("b.GAIN=0.1"),
            setting("b.INNER.TI=1e-300"),
            setting("b.ON=true"),
            setting("b.SP=50@5"),
            setting("b.SP=60@5"),
            setting("a.DOOR=1@5"),
        ],
        connections: vec!["b.OUT=a.POWER".parse().unwrap(), "b.OUT=b.TRACK".parse().unwrap()],
        record: vec!["a.TEMP".into()],
        start: Some(-1.0),
        stop: None,
        step: Some(0.1),
        exchange: Exchange::Parallel,
        remarks: Vec::new(),
        ..System::default()
    };
    let text = write(&system.as_in(folder.path())).unwrap();
    assert!(text.contains("b = \"PID.fmu\""), "{text}");
    fs::write(&path, text).unwrap();
    // The first value of SP at 5 s is overwritten.
    let mut expected = plain(system);
    expected.settings.remove(3);
    let mut read_back = plain(read(&path, None, parameters).unwrap());
    assert_eq!(std::mem::take(&mut read_back.sources), std::slice::from_ref(&path));
    for member in &mut read_back.members {
        member.path = member.path.canonicalize().unwrap();
    }
    assert_eq!(read_back, expected);
}

#[test]
fn values_of_a_parameter_file_give_way_to_settings() {
    let block = parameters::BlockType::all().remove(0);
    let member = block.members.iter().position(|member| member.role.is_settable()).unwrap();
    let name = block.members[member].name.clone();
    let one = parameters::Loop::new("LOOP", block);
    let json = parameters::write(parameters::Format::Json, &[one], "").unwrap();
    let text = format!("{FMUS}[parameters]\nPID = {{ file = \"plant.json\", loop = \"LOOPS\" }}\n");
    let (folder, path) = folder(&text);
    fs::write(folder.path().join("plant.json"), json).unwrap();
    let sentence = format!("{:#}", read(&path, None, parameters).unwrap_err());
    assert!(sentence.ends_with("loop.toml:5:37: no LOOPS; available: LOOP; did you mean LOOP?"), "{sentence}");
    fs::write(&path, text.replace("LOOPS", "LOOP") + &format!("[settings]\nPID.{name} = 1\n")).unwrap();
    let system = read(&path, None, parameters).unwrap();
    let (of_file, own): (Vec<_>, Vec<_>) = system.settings.iter().partition(|of| of.is_preliminary);
    assert!(of_file.iter().any(|of| of.variable == format!("PID.{name}")));
    assert_eq!(own.len(), 1);
    assert_eq!(own[0].place.as_ref().unwrap().line, 7);
}

#[test]
fn a_program_has_its_sources_and_the_options_of_its_fmu_and_is_written_so() {
    let text = "[fmus]\nPID = \"PID.fmu\"\nMACHINE = { sources = [\"a.scl\", \"b.db\"], cycle = \"10ms\", tag = [\"A : Bool\", \"B : Int\"] }\n";
    let (folder, path) = folder(text);
    let system = read(&path, None, parameters).unwrap();
    let program = &system.programs["MACHINE"];
    assert_eq!(program.sources, ["a.scl", "b.db"].map(|file| folder.path().join(file)));
    assert_eq!(program.cycle, Some(10));
    let tags: Vec<_> = program.declared.iter().map(|tag| (tag.name.as_str(), tag.of.as_str())).collect();
    assert_eq!(tags, [("A", "Bool"), ("B", "Int")]);
    assert_eq!(system.members[1].path, program.sources[0]);
    let written = write(&system.as_in(folder.path())).unwrap();
    let lines = "MACHINE.sources = [\"a.scl\", \"b.db\"]\nMACHINE.cycle = \"10ms\"\n\
        MACHINE.tags = ['\"A\" : Bool', '\"B\" : Int']\n";
    assert!(written.contains(lines), "{written}");
    fs::write(&path, written).unwrap();
    assert_eq!(read(&path, None, parameters).unwrap().programs, system.programs);
    let wrong = error("[fmus]\nMACHINE = { cycle = \"10ms\" }\n");
    assert_eq!(wrong, "loop.toml:2:11: a program needs sources = [\"FILE.scl\"]");
    let wrong = error("[fmus]\nMACHINE = { sources = [\"a.scl\"], cycle = \"10\" }\n");
    assert_eq!(wrong, "loop.toml:2:42: \"10\" is not a duration: write 2s, 100ms or 1m30s");
    let wrong = error("[fmus]\nMACHINE = { sources = [\"a.scl\"], cycel = \"10ms\" }\n");
    assert!(
        wrong.starts_with("loop.toml:2:34: unknown field `cycel`") && wrong.ends_with("did you mean cycle?"),
        "{wrong}"
    );
}
