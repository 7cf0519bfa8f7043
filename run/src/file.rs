//! A system as a hand-written TOML file, such as `loop.toml`.
//!
//! ```toml
//! step = 1.0
//! stop = 600.0
//! record = ["PID.OUT", "FURNACE.TEMP"]
//!
//! [fmus]                                  # in the order in which they are stepped
//! PID = "PID.fmu"                         # relative to this file
//! FURNACE = "FURNACE.fmu"
//! MACHINE = { sources = ["machine.scl"], cycle = "100ms" }    # a PLC program: `manifest`
//!
//! [connections]                           # from an output to an input, or to several
//! PID.OUT = "FURNACE.POWER"
//! FURNACE.TEMP = "PID.PV"
//!
//! [settings]
//! PID.GAIN = 2.0
//! FURNACE = { AMBIENT = 15.0 }            # the same as FURNACE.AMBIENT = 15.0
//!
//! [[events]]
//! time = 300.0
//! set.PID.SP = 80.0
//! ```
//!
//! Variable names contain dots, and so do TOML keys: both spellings denote the same name.

mod write;

use crate::plan::{near, suggestion};
use crate::subject::Key;
use crate::system::{Connection, EXACT, Exchange, FilePosition, Member, Recorded, Setting, System, Value, whole};
use anyhow::{Context, Error, Result, anyhow, bail};
use manifest::Manifest;
use parameters::{Options, Reading, Source};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, DeserializeOwned, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::fs;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
pub use write::write;

/// The maximum size of the file, in bytes.
const LARGEST: u64 = 1 << 20;

/// A function that reads a parameter file, given the path as specified by the user.
pub type ReadParameters = fn(&str, &Options) -> Result<Reading>;

/// The remarks about a parameter file, one sentence each.
pub fn remarks(reading: &Reading) -> Vec<String> {
    reading.remarks.to_string().lines().map(str::to_string).collect()
}

/// The grammar of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    start: Option<Spanned<Node>>,
    stop: Option<Spanned<Node>>,
    step: Option<Spanned<Node>>,
    #[serde(default)]
    exchange: Exchange,
    #[serde(default = "yes")]
    event_mode: bool,
    #[serde(default)]
    record: Vec<Spanned<String>>,
    fmus: Entries<Spanned<MadeOf>>,
    #[serde(default)]
    connections: Entries<Spanned<Node>>,
    #[serde(default)]
    parameters: Entries<Spanned<ParametersOf>>,
    #[serde(default)]
    settings: Entries<Spanned<Node>>,
    #[serde(default)]
    events: Vec<Event>,
}

fn yes() -> bool {
    true
}

/// An entry of `[parameters]`: the parameter file of an FMU.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParametersOf {
    file: Spanned<String>,
    #[serde(rename = "loop")]
    name: Option<Spanned<String>>,
    block: Option<String>,
    #[serde(default)]
    offset: usize,
}

/// The settings at one time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    time: Spanned<Node>,
    set: Entries<Spanned<Node>>,
}

/// The source of a member.
enum MadeOf {
    /// The path of an FMU, or of the only source of a program.
    File(String),
    Program(Box<Manifest>),
}

impl<'de> Deserialize<'de> for MadeOf {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<MadeOf, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = MadeOf;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("\"FILE.fmu\", or { sources = [\"FILE.scl\"] }")
            }

            fn visit_str<E>(self, file: &str) -> Result<MadeOf, E> {
                Ok(MadeOf::File(file.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MadeOf, A::Error> {
                Manifest::deserialize(MapAccessDeserializer::new(map)).map(|of| MadeOf::Program(Box::new(of)))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// A value, a list, or a table of them.
pub enum Node {
    /// `true` or `false`.
    Boolean(bool),
    /// An integer or a floating-point number.
    Number(f64),
    /// An integer with more digits than a floating-point number can hold.
    Whole(i128),
    /// A quoted string.
    Text(String),
    /// Values in brackets.
    List(Vec<Spanned<Node>>),
    /// A table, written as a section or in braces.
    Table(Entries<Spanned<Node>>),
}

/// The keys of a table with their values, in the order of the file.
pub struct Entries<T>(Vec<(Spanned<String>, T)>);

impl<T> Default for Entries<T> {
    fn default() -> Entries<T> {
        Entries(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Entries<T>, D::Error> {
        struct Table<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Table<T> {
            type Value = Entries<T>;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("a table")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Entries<T>, A::Error> {
                entries(map)
            }
        }
        deserializer.deserialize_map(Table(std::marker::PhantomData))
    }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Node, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Node;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("a number, true, false, or a string")
            }

            fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
                Ok(Node::Boolean(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
                let whole = i128::from(value);
                Ok(if whole.abs() > EXACT { Node::Whole(whole) } else { Node::Number(value as f64) })
            }

            fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
                Ok(Node::Number(value))
            }

            fn visit_str<E>(self, text: &str) -> Result<Node, E> {
                Ok(Node::Text(text.into()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Node, A::Error> {
                let mut nodes = Vec::new();
                while let Some(node) = list.next_element()? {
                    nodes.push(node);
                }
                Ok(Node::List(nodes))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Node, A::Error> {
                Ok(Node::Table(entries(map)?))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

fn entries<'de, T: Deserialize<'de>, A: MapAccess<'de>>(mut map: A) -> Result<Entries<T>, A::Error> {
    let mut entries = Vec::new();
    while let Some(entry) = map.next_entry()? {
        entries.push(entry);
    }
    Ok(Entries(entries))
}

/// Reads a system from a file. The paths of FMUs are relative to `fmus`, if given, otherwise to the file's folder.
/// Those of parameter files, which `parameters` reads, are always relative to the file's folder.
///
/// # Errors
/// The file is faulty; the message states file, line and column.
pub fn read(path: &Path, fmus: Option<&Path>, parameters: ReadParameters) -> Result<System> {
    Reader::open(path, fmus, parameters)?.system()
}

/// Parses a system from the text of a file, called `name` in errors. The FMUs need not exist, and their paths are kept
/// as written.
///
/// # Errors
/// The text is faulty (the message states line and column) or names a parameter file.
pub fn parse(name: &str, text: &str) -> Result<System> {
    let parameters: ReadParameters =
        |file, _| bail!("{file}: parameter files cannot be read here; write the values in [settings]");
    let source = Source::new(name, text.as_bytes().to_vec());
    Reader { source, folder: Path::new(""), fmus: None, parameters }.system()
}

/// A value in nested tables.
struct Entry<'a> {
    /// Its keys, joined by dots.
    name: String,
    /// The location of the last key.
    place: FilePosition,
    node: &'a Spanned<Node>,
}

/// A file reader; its errors state line and column.
pub struct Reader<'a> {
    source: Source,
    folder: &'a Path,
    /// The folder of the FMUs; `None` if they need not exist.
    fmus: Option<&'a Path>,
    parameters: ReadParameters,
}

impl<'a> Reader<'a> {
    /// Opens the file at `path`, or standard input if that is `-`; see [`read`] for `fmus`.
    pub fn open(path: &'a Path, fmus: Option<&'a Path>, parameters: ReadParameters) -> Result<Reader<'a>> {
        let (shown, bytes) = Source::load(path, LARGEST).map_err(Error::msg)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(Reader { source: Source::new(shown, bytes), folder, fmus: fmus.or(Some(folder)), parameters })
    }

    /// The name and text of the file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The function that reads parameter files.
    pub fn parameters(&self) -> ReadParameters {
        self.parameters
    }

    /// The parsed content of the file.
    pub fn content<T: DeserializeOwned>(&self) -> Result<T> {
        content(&self.source)
    }

    fn system(&self) -> Result<System> {
        let content: Content = self.content()?;
        let seconds = |node: &Option<Spanned<Node>>| node.as_ref().map(|node| self.seconds(node)).transpose();
        let mut system = System {
            start: seconds(&content.start)?,
            stop: seconds(&content.stop)?,
            step: seconds(&content.step)?,
            exchange: content.exchange,
            no_events: !content.event_mode,
            sources: vec![self.source.file.clone().into()],
            ..System::default()
        };
        for (name, node) in &content.fmus.0 {
            match node.get_ref() {
                MadeOf::File(file) => system.members.push(self.member(name, file, node.span())?),
                MadeOf::Program(manifest) => {
                    let program = self.program(manifest, node.span())?;
                    system.members.push(Member { name: name.get_ref().clone(), path: program.sources[0].clone() });
                    system.programs.insert(name.get_ref().clone(), program);
                }
            }
        }
        if system.members.is_empty() {
            bail!("{}: [fmus] is empty: write a line NAME = \"FILE.fmu\" for each FMU", self.source.file);
        }
        for entry in self.flat(&content.connections) {
            for to in self.inputs(entry.node)? {
                let place = Some(entry.place.clone());
                system.connections.push(Connection { from: entry.name.clone(), to, place });
            }
        }
        for (name, parameters) in &content.parameters.0 {
            let known: Vec<_> = system.members.iter().map(|member| member.name.as_str()).collect();
            self.known(name, &known)?;
            self.add_parameters(name.get_ref(), parameters.get_ref(), &mut system)?;
        }
        system.settings.extend(self.all_settings(&content.settings, &content.events)?);
        for name in &content.record {
            let place = Some(self.place(name.span()));
            system.record.push(Recorded { variable: name.get_ref().clone(), place });
        }
        Ok(system)
    }

    /// The program with its source paths resolved against the folder of the file.
    fn program(&self, manifest: &Manifest, at: Range<usize>) -> Result<Manifest> {
        if manifest.sources.is_empty() {
            bail!("{}: a program needs sources = [\"FILE.scl\"]", self.place(at));
        }
        let sources = manifest.sources.iter().map(|file| self.folder.join(file)).collect();
        Ok(Manifest { sources, ..manifest.clone() })
    }

    fn member(&self, name: &Spanned<String>, file: &str, at: Range<usize>) -> Result<Member> {
        if name.get_ref().is_empty() {
            bail!("{}: an FMU needs a name: write NAME = \"FILE.fmu\"", self.place(name.span()));
        }
        let Some(folder) = self.fmus else {
            return Ok(Member { name: name.get_ref().clone(), path: file.into() });
        };
        let path = folder.join(file);
        if !path.is_file() {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let files = fs::read_dir(folder).into_iter().flatten().flatten();
            let names: Vec<String> = files
                .map(|file| file.file_name().to_string_lossy().into_owned())
                .filter(|name| name.ends_with(".fmu"))
                .collect();
            let wanted = path.file_name().unwrap_or_default().to_string_lossy();
            let hint = near(&wanted, names.iter().map(String::as_str)).map_or_else(
                || match self.fmus == Some(self.folder) {
                    true => "FMU paths are relative to the folder of this file, or to --fmus FOLDER".into(),
                    false => "specify their folder with --fmus, or correct the path".into(),
                },
                |near| format!("did you mean {near}?"),
            );
            bail!("{}: no file {}; {hint}", self.place(at), path.display());
        }
        Ok(Member { name: name.get_ref().clone(), path })
    }

    /// Adds an FMU's values from a parameter file.
    fn add_parameters(&self, member: &str, of: &ParametersOf, system: &mut System) -> Result<()> {
        let here = self.place(of.file.span());
        let options = Options { block: of.block.clone(), offset: of.offset, ..Options::default() };
        let path = self.folder.join(of.file.get_ref()).display().to_string();
        let reading = (self.parameters)(&path, &options).with_context(|| here.to_string())?;
        let names: Vec<_> = reading.loops.iter().map(|of| of.name.as_str()).collect();
        if let Some(name) = &of.name {
            self.known(name, &names)?;
        } else if names.len() != 1 {
            let (file, count, names) = (of.file.get_ref(), names.len(), names.join(", "));
            bail!("{here}: {file} has {count} loops: write loop = \"NAME\", where NAME is one of {names}");
        }
        let name = of.name.as_ref().map(Spanned::get_ref);
        for found in reading.loops.iter().filter(|of| name.is_none_or(|name| of.name == *name)) {
            system.settings.extend(Setting::of_loop(found, member, Some(&here)));
        }
        system.remarks.extend(remarks(&reading));
        system.sources.push(path.into());
        Ok(())
    }

    /// Checks that `names` contains the name; the error suggests the most similar one.
    fn known(&self, name: &Spanned<String>, names: &[&str]) -> Result<()> {
        let wrong = name.get_ref();
        if names.contains(&wrong.as_str()) {
            return Ok(());
        }
        let hint = suggestion(wrong, names.iter().copied());
        bail!("{}: no {wrong}; available: {}{hint}", self.place(name.span()), names.join(", "))
    }

    /// The inputs connected to an output.
    fn inputs(&self, node: &Spanned<Node>) -> Result<Vec<String>> {
        let one = |node: &Spanned<Node>, expected| match node.get_ref() {
            Node::Text(name) => Ok(name.clone()),
            other => Err(self.wrong(node, expected, other)),
        };
        match node.get_ref() {
            Node::List(list) if !list.is_empty() => {
                list.iter().map(|node| one(node, "the name of an input, \"FMU.INPUT\"")).collect()
            }
            _ => Ok(vec![one(node, "the name of an input, \"FMU.INPUT\", or a list of such names")?]),
        }
    }

    /// The settings at the start and at later times.
    pub fn all_settings(&self, table: &Entries<Spanned<Node>>, events: &[Event]) -> Result<Vec<Setting>> {
        let mut settings = Vec::new();
        self.settings(table, None, &mut settings)?;
        for event in events {
            self.settings(&event.set, Some(self.seconds(&event.time)?), &mut settings)?;
        }
        Ok(settings)
    }

    fn settings(&self, table: &Entries<Spanned<Node>>, time: Option<f64>, settings: &mut Vec<Setting>) -> Result<()> {
        for Entry { name, place, node } in self.flat(table) {
            let value = self.value(node)?;
            settings.push(Setting { variable: name, value, time, is_preliminary: false, place: Some(place) });
        }
        Ok(())
    }

    /// Converts a node to the value of a variable.
    pub fn value(&self, node: &Spanned<Node>) -> Result<Value> {
        match node.get_ref() {
            Node::Boolean(value) => Ok(Value::Boolean(*value)),
            Node::Number(number) if number.is_finite() => Ok(Value::Number(*number)),
            Node::Whole(whole) => Ok(Value::Whole(*whole)),
            // Large unsigned 64-bit numbers are written as strings, since TOML's integers do not cover them.
            other => {
                let whole = if let Node::Text(text) = other { whole(text) } else { None };
                whole.map(Value::Whole).ok_or_else(|| self.wrong(node, "a finite number, true or false", other))
            }
        }
    }

    /// The values in a table and the tables inside it.
    fn flat<'t>(&self, table: &'t Entries<Spanned<Node>>) -> Vec<Entry<'t>> {
        let mut flat = Vec::new();
        self.add(&mut flat, "", table);
        flat
    }

    fn add<'t>(&self, flat: &mut Vec<Entry<'t>>, prefix: &str, table: &'t Entries<Spanned<Node>>) {
        for (key, node) in &table.0 {
            let name = format!("{prefix}{}", key.get_ref());
            match node.get_ref() {
                // The recursion is bounded: TOML's parser limits the nesting depth.
                Node::Table(inner) => self.add(flat, &format!("{name}."), inner),
                _ => flat.push(Entry { name, place: self.place(key.span()), node }),
            }
        }
    }

    /// Converts a node to a time in seconds.
    ///
    /// # Errors
    /// It is not a finite number; the message states line and column.
    pub fn seconds(&self, node: &Spanned<Node>) -> Result<f64> {
        match node.get_ref() {
            Node::Number(number) if number.is_finite() => Ok(*number),
            other => bail!(self.wrong(node, "a finite number, the time in seconds", other)),
        }
    }

    /// The error for a value of an unexpected kind.
    pub fn wrong(&self, node: &Spanned<Node>, expected: &str, found: &Node) -> anyhow::Error {
        let found = match found {
            Node::Boolean(value) => value.to_string(),
            Node::Number(number) => number.to_string(),
            Node::Whole(whole) => whole.to_string(),
            Node::Text(text) => format!("the string {text:?}"),
            Node::List(_) => "a list".into(),
            Node::Table(_) => "a table".into(),
        };
        anyhow!("{}: expected {expected}; found {found}", self.place(node.span()))
    }

    /// The line and column of a part of the file.
    pub fn place(&self, span: Range<usize>) -> FilePosition {
        place(&self.source, span)
    }
}

/// The location at which a range of a file starts.
pub fn place(source: &Source, span: Range<usize>) -> FilePosition {
    let parameters::TextPosition { line, column, .. } = source.place(span);
    FilePosition { file: source.file.clone(), line, column }
}

/// The location of the part of a TOML file to which these keys lead, or of the last key that the file contains; `None`
/// if it does not contain the first one, or an index is too high.
pub fn find(source: &Source, keys: &[Key]) -> Option<FilePosition> {
    let root: Node = toml::from_str(&source.text).ok()?;
    let (mut node, mut span) = (&root, None);
    for key in keys {
        let inner = match (node, key) {
            (Node::Table(table), Key::Name(name)) => {
                table.0.iter().find(|(own, _)| own.get_ref() == name).map(|(_, node)| node)
            }
            (Node::List(list), Key::Item(index)) => Some(list.get(*index)?),
            _ => None,
        };
        let Some(inner) = inner else { break };
        (node, span) = (inner.get_ref(), Some(inner.span()));
    }
    span.map(|span| place(source, span))
}

/// Parses the contents of a TOML file.
///
/// # Errors
/// The syntax error, after file, line and column.
pub fn content<T: DeserializeOwned>(source: &Source) -> Result<T> {
    toml::from_str(&source.text).map_err(|error| {
        let message = anyhow!("{}", plain(error.message()));
        match error.span() {
            Some(span) => message.context(place(source, span).to_string()),
            None => message.context(source.file.clone()),
        }
    })
}

/// The TOML parser's error in the user's terms: "expected a list; found the string \"max\"".
pub fn plain(message: &str) -> String {
    let message = message.trim().replace('\n', "; ");
    if let Some((name, expected)) = message.strip_prefix("unknown ").and_then(|rest| rest.split_once(", expected ")) {
        let name = name.split('`').nth(1).unwrap_or_default();
        let hint = suggestion(name, expected.split('`').skip(1).step_by(2));
        return message.clone() + &hint;
    }
    let wrong = ["invalid type: ", "invalid value: "].iter().find_map(|kind| message.strip_prefix(kind));
    let Some((found, expected)) = wrong.and_then(|rest| rest.rsplit_once(", expected ")) else { return message };
    let (expected, rest) =
        expected.split_once("; ").map_or((expected, String::new()), |(expected, rest)| (expected, format!("; {rest}")));
    let hint = if (found, expected) == ("map", "a sequence") { ": write [[NAME]] instead of [NAME]" } else { "" };
    let expected = match expected {
        "u64" | "usize" => "a whole number >= 0",
        "f64" => "a number",
        "a sequence" => "a list",
        "a map" => "a table { NAME = VALUE, ... }",
        "a string" => "a string in quotation marks",
        other => other,
    };
    let value = || found.split_once('`').map(|(_, value)| value.trim_end_matches('`'));
    let found = match found.split_once(' ') {
        Some(("string", text)) => format!("the string {text}"),
        Some(("integer" | "floating" | "boolean", _)) => value().unwrap_or(found).to_string(),
        None if found == "map" => "a table".into(),
        None if found == "sequence" => "a list".into(),
        _ => found.to_string(),
    };
    format!("expected {expected}; found {found}{hint}{rest}")
}

#[cfg(test)]
mod tests;
