//! Each input and each output of a program is in its FMU, and carries its value; `check` and `build` say the same.

use super::*;
use blocks::Kind;
use blocks::table::number::to_value;
use modeldescription::Causality::{self, Input, Local, Output, Parameter};
use parameters::tags::Tag;
use scl::random::Random;
use std::collections::BTreeSet;

/// Types with the kind of their number; of the last two a message says why they are not shown.
const NUMBERS: [(&str, Option<Kind>); 25] = [
    ("Bool", Some(Kind::Bool)),
    ("Byte", Some(Kind::Byte)),
    ("Word", Some(Kind::Word)),
    ("DWord", Some(Kind::DWord)),
    ("LWord", Some(Kind::LWord)),
    ("SInt", Some(Kind::SInt)),
    ("Int", Some(Kind::Int)),
    ("DInt", Some(Kind::DInt)),
    ("LInt", Some(Kind::LInt)),
    ("USInt", Some(Kind::USInt)),
    ("UInt", Some(Kind::UInt)),
    ("UDInt", Some(Kind::UDInt)),
    ("ULInt", Some(Kind::ULInt)),
    ("Real", Some(Kind::Real)),
    ("LReal", Some(Kind::LReal)),
    ("Time", Some(Kind::Time)),
    ("LTime", Some(Kind::LTime)),
    ("Char", Some(Kind::Byte)),
    ("WChar", Some(Kind::UInt)),
    ("Date", Some(Kind::UInt)),
    ("Time_Of_Day", Some(Kind::UDInt)),
    ("LTod", Some(Kind::ULInt)),
    ("HW_IO", Some(Kind::UInt)),
    ("LDT", None),
    ("Date_And_Time", None),
];

const NAMES: [&str; 16] = [
    "level",
    "a.b",
    "V1.0",
    "Größe [m]",
    "Füllstand",
    "two words",
    "it's",
    "1st",
    "x[1]",
    "a\\b",
    "日本",
    "100 %",
    "{a}",
    "`",
    "END_VAR",
    "a,b",
];

const ATTRIBUTES: [&str; 4] = [
    "ExternalVisible := 'False'",
    "ExternalAccessible := 'False'",
    "ExternalWritable := 'False'",
    "S7_SetPoint := 'True'",
];

/// A type as it is written, and what it ends in: the rest of each name, and the kind of the number; a text has the kind of none.
#[derive(Clone)]
struct Of {
    text: String,
    leaves: Vec<(String, Leaf)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Leaf {
    Number(Kind),
    Text,
    Unshown,
}

/// A name as FMI's structured convention has it.
fn quoted(name: &str) -> String {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let is_identifier = name.chars().all(is_word) && !name.starts_with(char::is_numeric);
    if is_identifier { name.into() } else { format!("'{}'", name.replace('\\', r"\\").replace('\'', r"\'")) }
}

struct Generator {
    random: Random,
    types: String,
    declared: usize,
}

impl Generator {
    /// A name that this scope does not have yet.
    fn name(&mut self, taken: &mut BTreeSet<String>) -> String {
        let mut name = self.random.one_of(&NAMES).to_string();
        while !taken.insert(name.to_uppercase()) {
            name.push(char::from(b'a' + self.random.below(26) as u8));
        }
        name
    }

    fn attributes(&mut self) -> (String, bool) {
        let given: Vec<&str> = ATTRIBUTES.into_iter().filter(|_| self.random.once_in(3)).collect();
        let is_setting = given.contains(&ATTRIBUTES[3]);
        if given.is_empty() { (String::new(), false) } else { (format!("{{ {} }}", given.join("; ")), is_setting) }
    }

    fn of(&mut self, depth: usize) -> Of {
        match self.random.below(if depth == 0 { 4 } else { 8 }) {
            0..3 => {
                let (text, kind) = self.random.one_of(&NUMBERS);
                let leaf = kind.map_or(Leaf::Unshown, Leaf::Number);
                Of { text: text.into(), leaves: vec![(String::new(), leaf)] }
            }
            3 => {
                let text = self.random.one_of(&["String", "String[7]", "WString[5]"]).to_string();
                Of { text, leaves: vec![(String::new(), Leaf::Text)] }
            }
            4 => {
                let numbers = [("YEAR", Kind::UInt), ("MONTH", Kind::USInt), ("DAY", Kind::USInt)];
                let more = ["WEEKDAY", "HOUR", "MINUTE", "SECOND"].map(|name| (name, Kind::USInt));
                let all = numbers.into_iter().chain(more).chain([("NANOSECOND", Kind::UDInt)]);
                let leaves = all.map(|(name, kind)| (format!(".{name}"), Leaf::Number(kind))).collect();
                Of { text: "DTL".into(), leaves }
            }
            5 => {
                let inner = loop {
                    let of = self.of(depth - 1);
                    if !of.text.starts_with("Array") {
                        break of;
                    }
                };
                let low = self.random.below(5) as i32 - 2;
                let (text, indices): (String, Vec<String>) = match self.random.once_in(2) {
                    true => (format!("{low}..{}", low + 1), vec![low.to_string(), (low + 1).to_string()]),
                    false => (format!("0..1, {low}..{low}"), vec![format!("0,{low}"), format!("1,{low}")]),
                };
                let element = |index: &String| {
                    inner.leaves.iter().map(|(rest, leaf)| (format!("[{index}]{rest}"), *leaf)).collect::<Vec<_>>()
                };
                Of {
                    text: format!("Array[{text}] of {}", inner.text),
                    leaves: indices.iter().flat_map(element).collect(),
                }
            }
            which => {
                let (mut text, mut leaves, mut taken) = (String::from("Struct\n"), Vec::new(), BTreeSet::new());
                for _ in 0..1 + self.random.below(3) {
                    let (name, of) = (self.name(&mut taken), self.of(depth - 1));
                    let (attributes, _) = self.attributes();
                    text += &format!("\"{name}\" {attributes} : {};\n", of.text);
                    leaves.extend(of.leaves.iter().map(|(rest, leaf)| (format!(".{}{rest}", quoted(&name)), *leaf)));
                }
                text += "END_STRUCT";
                if which == 6 {
                    return Of { text, leaves };
                }
                self.declared += 1;
                let name = format!("{}{}", self.random.one_of(&NAMES), self.declared);
                self.types += &format!("TYPE \"{name}\"\n{text};\nEND_TYPE\n");
                Of { text: format!("\"{name}\""), leaves }
            }
        }
    }
}

/// What a leaf must be in the FMU.
#[derive(Debug, PartialEq)]
struct Expected {
    name: String,
    causality: Causality,
}

/// The sources of one program, examined.
fn examined(text: &str, manifest: &Manifest) -> Result<Examined, Refused> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("machine.scl");
    fs::write(&file, text).unwrap();
    examine(&Manifest { sources: vec![file], cycle: Some(100), ..manifest.clone() })
}

fn ok(text: &str, manifest: &Manifest) -> Examined {
    examined(text, manifest).unwrap_or_else(|why| panic!("{:#}\n{text}", anyhow::Error::from(why)))
}

/// The number of a variable in the FMU, by its name; those of the texts come behind the rows.
fn reference(examined: &Examined, name: &str) -> Option<(usize, Causality)> {
    let description = examined.description.description();
    let variable = description.variables.iter().find(|variable| variable.name == name)?;
    Some((variable.value_reference as usize, variable.causality))
}

#[test]
fn each_input_and_output_of_a_block_is_in_its_fmu_or_a_message_names_it() {
    for seed in 0..150 {
        let mut generator = Generator { random: Random::new(seed), types: String::new(), declared: 0 };
        let mut taken = BTreeSet::from(["CYCLE".to_string()]);
        let mut sections = String::new();
        let mut body = String::new();
        let mut pairs: Vec<(Expected, Expected, Leaf)> = Vec::new();
        let mut structured: Vec<String> = Vec::new();
        for _ in 0..1 + generator.random.below(5) {
            let of = generator.of(2);
            let [from, to] = [(); 2].map(|()| generator.name(&mut taken));
            let ((given, is_setting), (shown, _)) = (generator.attributes(), generator.attributes());
            sections += &format!("VAR_INPUT \"{from}\" {given} : {}; END_VAR\n", of.text);
            sections += &format!("VAR_OUTPUT \"{to}\" {shown} : {}; END_VAR\n", of.text);
            body += &format!("#\"{to}\" := #\"{from}\";\n");
            for (rest, leaf) in &of.leaves {
                let at = |name: &str, causality| Expected { name: quoted(name) + rest, causality };
                pairs.push((at(&from, if is_setting { Parameter } else { Input }), at(&to, Output), *leaf));
            }
        }
        for _ in 0..generator.random.below(3) {
            let (of, name, (attributes, _)) = (generator.of(1), generator.name(&mut taken), generator.attributes());
            sections += &format!("VAR_IN_OUT \"{name}\" {attributes} : {}; END_VAR\n", of.text);
            body += &format!("#\"{name}\" := #\"{name}\";\n");
            let name = quoted(&name);
            match of.leaves.as_slice() {
                [(rest, leaf @ Leaf::Number(_))] if rest.is_empty() => {
                    let out = match name.strip_suffix('\'') {
                        Some(open) => format!("{open}_out'"),
                        None => format!("{name}_out"),
                    };
                    let expected = |name, causality| Expected { name, causality };
                    pairs.push((expected(name, Input), expected(out, Output), *leaf));
                }
                [(rest, Leaf::Unshown)] if rest.is_empty() => {}
                leaves => {
                    let shown = leaves.iter().filter(|(_, leaf)| *leaf != Leaf::Unshown);
                    structured.extend(shown.map(|(rest, _)| format!("{name}{rest}")));
                }
            }
        }
        let block = generator.random.one_of(&NAMES);
        sections += "VAR \"inner\" { ExternalVisible := 'False' } : Real; END_VAR\n";
        let types = &generator.types;
        let text = format!("{types}FUNCTION_BLOCK \"{block}\"\n{sections}BEGIN\n{body}END_FUNCTION_BLOCK\n");
        let of = ok(&text, &Manifest::default());
        assert!(reference(&of, "inner").is_none(), "{text}");
        for name in &structured {
            assert_eq!(reference(&of, name).map(|(_, causality)| causality), Some(Local), "{name}\n{text}");
        }
        let mut program = program::Program::new(of.loaded.clone());
        let rows = of.interface.table.rows.len();
        for (number, (input, output, leaf)) in pairs.iter().enumerate() {
            for Expected { name, causality } in [input, output] {
                let found = reference(&of, name);
                if *leaf == Leaf::Unshown {
                    let told = |problems: &Problems| problems.to_string().contains(&format!("{name} is "));
                    assert!(found.is_none() && of.warnings.iter().any(told), "{name}\n{text}");
                } else {
                    assert_eq!(found.map(|(_, causality)| causality), Some(*causality), "{name}\n{text}");
                }
            }
            let Some((at, _)) = reference(&of, &input.name) else { continue };
            match *leaf {
                Leaf::Number(Kind::Bool) => assert!(program.set(at, blocks::Value::Bool(number % 2 == 0))),
                Leaf::Number(kind) => assert!(program.set(at, to_value((number % 127) as f64, kind).unwrap())),
                _ => program.set_text(at - rows, &number.to_string().encode_utf16().collect::<Vec<u16>>()),
            }
        }
        program.restart();
        program.call();
        assert_eq!(program.stopped(), None, "{text}");
        for (number, (_, output, leaf)) in pairs.iter().enumerate() {
            let Some((at, _)) = reference(&of, &output.name) else { continue };
            let name = &output.name;
            match *leaf {
                Leaf::Number(Kind::Bool) => {
                    assert_eq!(program.get(at), Some(blocks::Value::Bool(number % 2 == 0)), "{name}\n{text}");
                }
                Leaf::Number(kind) => {
                    assert_eq!(program.get(at), to_value((number % 127) as f64, kind).ok(), "{name}\n{text}");
                }
                _ => assert_eq!(program.text(at - rows), Some(number.to_string()), "{name}\n{text}"),
            }
        }
    }
}

#[test]
fn what_is_hidden_and_what_is_inside_an_in_out_comes_out_by_its_name() {
    let text = "FUNCTION_BLOCK \"V1.0\"
        VAR_IN_OUT \"tank.1\" : Struct \"level [m]\" { ExternalVisible := 'False' } : Real; END_STRUCT; END_VAR
        VAR \"inner.1\" { ExternalAccessible := 'False' } : Real; buffer : Array[1..1001] of Int; END_VAR
        BEGIN #\"tank.1\".\"level [m]\" := 2.0 * #\"tank.1\".\"level [m]\"; END_FUNCTION_BLOCK";
    let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<String>>();
    let (tank, inner) = ("'tank.1'.'level [m]'", "'inner.1'");
    // In quotes, as SCL writes it, and as the FMU names it.
    for (given, shown) in [("\"tank.1\".\"level [m]\"", "\"inner.1\""), (tank, inner)] {
        let manifest = Manifest { inputs: names(&[given]), outputs: names(&[shown]), ..Manifest::default() };
        let of = ok(text, &manifest);
        assert_eq!(reference(&of, tank).map(|(_, causality)| causality), Some(Input));
        assert_eq!(reference(&of, inner).map(|(_, causality)| causality), Some(Output));
        let mut program = program::Program::new(of.loaded.clone());
        let [(at, _), (out, _)] = [tank, "'tank.1'.'level [m]_out'"].map(|name| reference(&of, name).unwrap());
        assert!(program.set(at, blocks::Value::Real(4.0)));
        program.restart();
        program.call();
        assert_eq!(program.get(out), Some(blocks::Value::Real(8.0)));
    }
    let of = ok(text, &Manifest::default());
    assert!(reference(&of, inner).is_none() && reference(&of, "buffer[1]").is_none());
    // A large array of an interface is shown, whole.
    let text = text.replace("Struct", "Array[1..1500] of Struct").replace("#\"tank.1\"", "#\"tank.1\"[1500]");
    assert!(reference(&ok(&text, &Manifest::default()), "'tank.1'[1500].'level [m]'").is_some());
}

#[test]
fn a_name_that_is_taken_does_not_hide_another() {
    let text = "FUNCTION_BLOCK f VAR_IN_OUT x : INT; END_VAR VAR_OUTPUT x_out : INT; CYCLE : INT; END_VAR
        BEGIN x := x + 1; x_out := x * 10; CYCLE := 7; END_FUNCTION_BLOCK";
    let of = ok(text, &Manifest::default());
    let mut program = program::Program::new(of.loaded.clone());
    program.restart();
    program.call();
    let whole = |name: &str| program.get(reference(&of, name).unwrap_or_else(|| panic!("{name}")).0).unwrap();
    assert_eq!(["x_out", "PLC.x_out", "PLC.CYCLE"].map(whole), [10, 1, 7].map(blocks::Value::Int));
}

#[test]
fn sources_of_one_name_lie_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let texts =
        ["TYPE t : STRUCT a : INT; END_STRUCT; END_TYPE", "FUNCTION_BLOCK f VAR_INPUT x : t; y : END_VAR BEGIN"];
    let files = [("one", texts[0]), ("two", texts[1])].map(|(name, text)| {
        fs::create_dir(folder.path().join(name)).unwrap();
        let file = folder.path().join(name).join("Types.scl");
        fs::write(&file, text).unwrap();
        file
    });
    let manifest = Manifest { sources: files.to_vec(), cycle: Some(100), ..Manifest::default() };
    // A message has the path that the user knows.
    match examine(&manifest) {
        Err(Refused::Sources(problems)) => assert_eq!(problems[0].file, files[1].display().to_string()),
        _ => panic!("y has no type"),
    }
    fs::write(&files[1], "FUNCTION_BLOCK f VAR_INPUT x : t; END_VAR BEGIN ; END_FUNCTION_BLOCK").unwrap();
    let of = examine(&manifest).unwrap_or_else(|why| panic!("{why:?}"));
    assert_eq!(of.sources.iter().map(|source| source.file.as_str()).collect::<Vec<_>>(), ["Types.scl", "Types_2.scl"]);
    assert!(reference(&of, "x.a").is_some());
}

#[test]
fn a_document_and_its_texts_keep_one_name() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["one/Motor.s7dcl", "two/Motor.s7dcl", "two/Motor.s7res", "three/Motor_2.s7dcl"].map(|file| {
        let file = folder.path().join(file);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, "").unwrap();
        file
    });
    let names = |order: &[usize]| -> Vec<String> {
        let sources = order.iter().map(|file| files[*file].clone()).collect();
        let named = read(&Manifest { sources, ..Manifest::default() }).unwrap();
        named.sources.into_iter().map(|source| source.file).collect()
    };
    assert_eq!(names(&[0, 1, 2, 3]), ["Motor.s7dcl", "Motor_2.s7dcl", "Motor_2.s7res", "Motor_2_2.s7dcl"]);
    // Motor.s7res would be that of the first one.
    assert_eq!(names(&[0, 2, 1]), ["Motor.s7dcl", "Motor_2.s7res", "Motor_2.s7dcl"]);
}

/// With ten times as many, what is quadratic in their number takes minutes, and seconds else.
#[test]
fn thousands_of_variables_of_each_kind_are_all_there() {
    const COUNT: usize = 5_000;
    let each = |line: fn(usize) -> String| (0..COUNT).map(line).collect::<String>();
    let members = each(|number| format!("v{number} : Real;\n"));
    let text = format!(
        "DATA_BLOCK \"D\" VAR {members} END_VAR BEGIN END_DATA_BLOCK
        FUNCTION \"F\" : Void BEGIN {} {} END_FUNCTION
        FUNCTION_BLOCK \"B\" VAR_INPUT i : Struct {members} END_STRUCT; END_VAR
        VAR_OUTPUT {} END_VAR VAR {} END_VAR BEGIN \"F\"(); {} END_FUNCTION_BLOCK",
        each(|number| format!("\"D\".v{number} := 1.0;\n")),
        each(|number| format!("\"t{number}\" := 1.0;\n")),
        each(|number| format!("o{number} : Real;\n")),
        each(|number| format!("l{number} : Real;\n")),
        each(|number| format!("#o{number} := #i.v{number};\n")),
    );
    let tag = (0..COUNT).map(|number| Tag::new(format!("t{number}"), "Real")).collect();
    let of = ok(&text, &Manifest { declared: tag, ..Manifest::default() });
    let description = of.description.description();
    for (causality, count) in [(Input, COUNT), (Output, 2 * COUNT), (Local, 2 * COUNT), (Parameter, 1)] {
        let found = description.variables.iter().filter(|variable| variable.causality == causality);
        assert_eq!(found.count(), count, "{causality}");
    }
}

#[test]
fn the_interface_of_a_program_is_the_one_that_its_json_describes() {
    let text = "FUNCTION_BLOCK \"A\"\nVAR_INPUT a : Real := 0.1; // 0.05 .. 0.3 bar\n b : Word := 16#FFFF; c : LInt := 9007199254740993;\n\
                s : String[4] := 'x'; t : LTime := LT#3ns; END_VAR\nVAR_OUTPUT z : LReal; END_VAR\nBEGIN\nz := a;\nEND_FUNCTION_BLOCK\n";
    let manifest = Manifest { cycle: Some(100), sources: vec!["a.scl".into()], ..Manifest::default() };
    let loaded = Loaded::new(&manifest, &[Source::new("a.scl", text.into())], is_unit).unwrap();
    let mut own = interface(&loaded).unwrap();
    own.table.tunable_reals.clear();
    own.table.tunable_lreals.clear();
    assert_eq!(own, Interface::parse(&fmu::describe(&loaded.table, &loaded.guid())).unwrap());
    assert!(own.capabilities.can_serialize_fmu_state && own.log_categories.len() == 4);
}

#[test]
fn a_start_value_that_is_not_finite_is_named_with_its_variable() {
    let text = "FUNCTION_BLOCK \"A\"\nVAR_INPUT x : Real := 1.0E300; END_VAR\nBEGIN\nEND_FUNCTION_BLOCK\n";
    let manifest = Manifest { cycle: Some(100), sources: vec!["a.scl".into()], ..Manifest::default() };
    let loaded = Loaded::new(&manifest, &[Source::new("a.scl", text.into())], is_unit).unwrap();
    let error = interface(&loaded).unwrap_err().to_string();
    assert_eq!(error, "the library's table of A: x starts at inf: every start, min and max must be finite");
    let mut table = loaded.table.clone();
    (table.rows[0].start, table.rows[0].min) = (blocks::Value::Real(0.0), Some(blocks::Value::Real(f32::NEG_INFINITY)));
    let error = Interface::linked(table, &loaded.guid()).unwrap_err().to_string();
    assert_eq!(error, "the library's table of A: x has min -inf: every start, min and max must be finite");
}
