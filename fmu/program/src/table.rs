//! The table of a program: its variables as seen by the host.

use blocks::table::number::{number, to_value};
use blocks::{Class, Kind, Response, Role, Row, Table, Text, TextType, Time, Value};
use manifest::Manifest;
use scl::interface::{self, Variable};
use scl::ir::{Scalar, Type};
use scl::{Compiled, Root};
use std::collections::{HashMap, HashSet};

/// A row's location in memory and the value it holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowMemory {
    pub ty: Scalar,
    pub offset: usize,
    pub held: Held,
}

/// A text's location in memory.
#[derive(Clone, Copy, Debug)]
pub struct TextPlace {
    /// Its offset, in bytes. A 16-bit number of characters is followed by the characters.
    pub offset: usize,
    /// Its type; a character of a WSTRING has 16 bits, of a STRING 8.
    pub ty: TextType,
}

impl TextPlace {
    /// The size of a character, in bytes.
    fn width(self) -> usize {
        1 + usize::from(self.ty.is_wide)
    }

    /// Its total size, in bytes.
    pub fn size(self) -> usize {
        2 + usize::from(self.ty.most) * self.width()
    }

    /// Reads the text from memory.
    pub fn read(self, memory: &[u8]) -> String {
        let unit = |at: usize| match memory.get(at..) {
            Some([low, high, ..]) => u16::from_le_bytes([*low, *high]),
            _ => 0,
        };
        let length = usize::from(unit(self.offset).min(self.ty.most));
        let start = self.offset + 2;
        match self.ty.is_wide {
            true => String::from_utf16_lossy(&(0..length).map(|at| unit(start + 2 * at)).collect::<Vec<_>>()),
            false => memory[start..start + length].iter().map(|byte| char::from(*byte)).collect(),
        }
    }

    /// Writes at most [`TextType::most`] characters to memory. The rest of the text's memory is left unchanged.
    pub fn write(self, memory: &mut [u8], units: &[u16]) {
        let length = units.len().min(self.ty.most.into());
        memory[self.offset..self.offset + 2].copy_from_slice(&(length as u16).to_le_bytes());
        let start = self.offset + 2;
        for (at, unit) in units[..length].iter().enumerate() {
            let bytes = unit.to_le_bytes();
            memory[start + at * self.width()..][..self.width()].copy_from_slice(&bytes[..self.width()]);
        }
    }
}

/// The variables seen by the host, and their locations in memory.
pub(crate) struct Shown {
    pub table: Table,
    /// The location of each row except the cycle's.
    pub places: Vec<RowMemory>,
    /// The location of each text.
    pub texts: Vec<TextPlace>,
    /// The address of the block's own CYCLE, if it has one.
    pub own_cycle: Option<usize>,
}

/// Which value a row holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Held {
    /// The program's value.
    Memory,
    /// The host's value before each call, for a variable that the program also writes.
    InOut,
    /// The value that a retentive variable has at the start, as set by the host.
    Start,
}

/// The maximum number of names in an error message.
const MOST_NAMES: usize = 20;

/// The maximum number of inputs, and of outputs, that are recorded and plotted.
const MOST_DRAWN: usize = 50;

/// The name of the row that holds the time between two calls.
const CYCLE: &str = "CYCLE";

/// Builds the table of a program. If `is_unit` does not accept the unit in a variable's comment, the unit is added to
/// the description instead.
///
/// # Errors
/// The manifest contains a name that the program does not have, or turns a text that the program writes into an input.
pub(crate) fn build(
    manifest: &Manifest,
    compiled: &Compiled,
    root: &Root,
    is_unit: fn(&str) -> bool,
) -> Result<Shown, String> {
    let mut rows: Vec<Row> = Vec::new();
    let mut places: Vec<RowMemory> = Vec::new();
    let mut texts: Vec<(Text, TextPlace)> = Vec::new();
    let mut own_cycle = None;
    let variables: Vec<&Variable> = root.variables.iter().chain(&compiled.globals).collect();
    let chosen = chosen(manifest, root, &variables)?;
    let milliseconds = manifest.cycle.ok_or("the time between two calls is missing")?;
    let variables = || variables.iter().enumerate().filter(|(at, of)| !of.is_hidden || chosen.contains_key(at));
    let start = &compiled.program.records[compiled.program.memory].start;
    // Declared names take precedence over derived ones: `x_out` may be declared in addition to an in-out parameter x.
    let mut names = Names(HashSet::from([CYCLE.to_string()]));
    let is_own_cycle = |of: &Variable, role: Role| {
        of.name.eq_ignore_ascii_case(CYCLE) && kind(of.of) == Some(Kind::Time) && role.is_settable()
    };
    let mut named = Vec::new();
    for (at, variable) in variables() {
        let role = chosen.get(&at).copied().unwrap_or_else(|| role(variable.role));
        if own_cycle.is_none() && is_own_cycle(variable, role) {
            own_cycle = Some(variable.offset);
        } else {
            named.push((*variable, role, names.free(variable.name.clone())));
        }
    }
    for (variable, role, name) in named {
        let offset = variable.offset;
        let ty = match variable.ty {
            Type::Scalar(ty) => ty,
            Type::Text { capacity: most, wide: is_wide } => {
                let place = TextPlace { offset, ty: TextType { most, is_wide } };
                texts.push((text(&name, variable, role, place, &place.read(start))?, place));
                continue;
            }
            _ => return Err(format!("{name} is neither a number nor a string")),
        };
        let kind = kind(variable.of).ok_or_else(|| format!("{name}: an FMU cannot represent a {}", variable.of))?;
        let value = scl::ir::Value::read(ty, &start[offset..]).to_plc(kind);
        let is_written = matches!(variable.role, interface::Role::InOut | interface::Role::Local);
        let held = if is_written && role == Role::Input { Held::InOut } else { Held::Memory };
        let mut add = |name: &str, role, held| {
            rows.push(row(name, variable, role, value, is_unit));
            places.push(RowMemory { ty, offset, held });
        };
        add(&name, role, held);
        if held == Held::InOut {
            add(&names.free(suffixed(&name, "_out")), Role::Output, Held::Memory);
        }
        if variable.is_retained && matches!(role, Role::Local | Role::Output) {
            add(&names.free(suffixed(&name, "_start")), Role::Fixed, Held::Start);
        }
    }
    let cycle = rows.len();
    rows.push(Row {
        description: "Time between two calls".into(),
        min: Some(Value::Time(Time::ms(1))),
        ..Row::new(CYCLE, Role::Cycle, Value::Time(Time::ms(milliseconds as i32)))
    });
    let (texts, text_places) = texts.into_iter().unzip();
    let table = Table {
        name: manifest.name.clone().unwrap_or_else(|| identifier(&root.block)),
        aliases: Vec::new(),
        docs: documentation(manifest, milliseconds, root),
        responses: vec![response(&rows)],
        rows,
        texts,
        tunable_reals: Vec::new(),
        tunable_lreals: Vec::new(),
        cycle,
        mean: None,
        memory: Vec::new(),
        instances: &[],
        characteristics: Vec::new(),
        drawn_unit: None,
    };
    Ok(Shown { table, places, texts: text_places, own_cycle })
}

/// The recorded run: all inputs and outputs, or only the first ones if a plot of all would be unreadable.
fn response(rows: &[Row]) -> Response<String> {
    let at_rest = Response::from(&Response::AT_REST);
    let of = |role: Role| rows.iter().filter(move |row| row.role == role).map(|row| row.name.clone());
    if of(Role::Input).count().max(of(Role::Output).count()) <= MOST_DRAWN {
        return at_rest;
    }
    let title = format!("{}: the first {MOST_DRAWN} inputs and outputs", at_rest.title);
    let show = [Role::Input, Role::Output].into_iter().flat_map(|role| of(role).take(MOST_DRAWN)).collect();
    Response { title, show, ..at_rest }
}

/// The names in use.
struct Names(HashSet<String>);

impl Names {
    /// A unique name for a variable: a tag may have the same name as a variable of the block.
    fn free(&mut self, mut name: String) -> String {
        while !self.0.insert(name.clone()) {
            name.insert_str(0, "PLC.");
        }
        name
    }
}

/// A text as seen by the host. An in-out text becomes a local, which the host can only read, because the program also
/// writes it.
fn text(name: &str, of: &Variable, role: Role, place: TextPlace, start: &str) -> Result<Text, String> {
    let is_written = matches!(of.role, interface::Role::InOut | interface::Role::Local);
    let role = match role {
        Role::Input if of.role == interface::Role::Local => {
            return Err(format!(
                "{} is not an input: the program may write this string, so a host cannot set it; make it a VAR_INPUT",
                of.name
            ));
        }
        Role::Input if is_written => Role::Local,
        // modelDescription.xml cannot represent a start value that contains control characters.
        role if role.is_settable() && start.chars().any(char::is_control) => Role::Local,
        role => role,
    };
    Ok(Text { name: name.into(), description: of.comment.text.clone(), role, start: start.into(), ty: place.ty })
}

/// A name in the form used to compare it with options: in upper case, without quotes and apostrophes.
fn spelled(name: &str) -> String {
    name.replace(['"', '\''], "").to_uppercase()
}

/// The roles that the manifest assigns to variables, by variable index.
///
/// # Errors
/// The program has no variable with a given name that could have the assigned role.
fn chosen(manifest: &Manifest, root: &Root, variables: &[&Variable]) -> Result<HashMap<usize, Role>, String> {
    use interface::Role::{Input, Local, Parameter};
    let mut chosen = HashMap::new();
    for (names, roles, what, (wanted, role)) in [
        (&manifest.outputs, &[Local][..], "local", ("an output", Role::Output)),
        (&manifest.inputs, &[Parameter, Local], "setting or local", ("an input", Role::Input)),
        (&manifest.parameters, &[Input], "input", ("a parameter", Role::Parameter)),
    ] {
        if names.is_empty() {
            continue;
        }
        let able = || variables.iter().enumerate().filter(|(_, of)| roles.contains(&of.role));
        let mut known: HashMap<String, Vec<usize>> = HashMap::new();
        able().for_each(|(at, of)| known.entry(spelled(&of.name)).or_default().push(at));
        for name in names {
            let Some(found) = known.get(&spelled(name)) else {
                let some: Vec<&str> = able().map(|(_, of)| of.name.as_str()).take(MOST_NAMES).collect();
                let block = &root.block;
                if some.is_empty() {
                    return Err(format!("{block} has no {what} that could become {wanted}: remove {name}"));
                }
                return Err(format!(
                    "{block} has no {what} {name} that could become {wanted}; available: {}",
                    some.join(", ")
                ));
            };
            let exact = found.iter().filter(|at| variables[**at].name == *name).copied().collect::<Vec<usize>>();
            let found = if exact.is_empty() { found } else { &exact };
            chosen.extend(found.iter().map(|at| (*at, role)));
        }
    }
    Ok(chosen)
}

fn kind(of: &str) -> Option<Kind> {
    match of {
        "CHAR" => Some(Kind::Byte),
        "WCHAR" | "DATE" => Some(Kind::UInt),
        "TOD" => Some(Kind::UDInt),
        "LTOD" => Some(Kind::ULInt),
        of => Kind::named(of),
    }
}

/// The role of a variable for which the manifest specifies none.
fn role(of: interface::Role) -> Role {
    match of {
        interface::Role::Input | interface::Role::InOut => Role::Input,
        interface::Role::Parameter => Role::Parameter,
        interface::Role::Output => Role::Output,
        interface::Role::Local => Role::Local,
    }
}

fn row(name: &str, variable: &Variable, role: Role, start: Value, is_unit: fn(&str) -> bool) -> Row {
    let (comment, kind) = (&variable.comment, start.kind());
    let is_real = kind.class() == Class::Real;
    let is_time = matches!(kind, Kind::Time | Kind::LTime);
    let unit = comment.unit.as_deref();
    let shown = unit.filter(|unit| is_real && !is_time && is_unit(unit));
    let mut description = comment.text.clone();
    let mut add = |text: String| {
        description += if description.is_empty() { "" } else { "; " };
        description += &text;
    };
    if let Some(unit) = unit.filter(|_| shown.is_none() && !is_time) {
        add(format!("unit {unit}"));
    }
    // Dates and times of day are numbers for a host.
    match variable.of {
        "DATE" => add("days since 1990-01-01".into()),
        "TOD" => add("ms since midnight".into()),
        "LTOD" => add("ns since midnight".into()),
        _ => {}
    }
    let bound = |bound: Option<f64>| bound.filter(|_| kind != Kind::Bool).and_then(|bound| to_value(bound, kind).ok());
    let (mut min, mut max) = (bound(comment.min), bound(comment.max));
    let is_inside =
        min.is_none_or(|min| number(min) <= number(start)) && max.is_none_or(|max| number(start) <= number(max));
    if !is_inside {
        // A CPU also accepts a start value outside the range; FMI does not.
        let shown = |bound: Option<Value>| bound.map_or_else(|| "...".into(), |bound| format!("{:?}", number(bound)));
        add(format!("range {} to {}, which excludes the start value", shown(min), shown(max)));
        (min, max) = (None, None);
    }
    let unit = shown.map(str::to_string);
    Row { description, min, max, unit, ..Row::new(name.to_string(), role, start) }
}

fn documentation(manifest: &Manifest, milliseconds: u32, root: &Root) -> String {
    let cycle = f64::from(milliseconds) / 1000.0;
    let sources: Vec<String> = manifest.sources.iter().map(|source| source.display().to_string()).collect();
    format!(
        "The PLC program {} in SCL, called every {cycle:?} s.\n\nThe sources are in the FMU's resources folder: {}.\n",
        root.block,
        sources.join(", ")
    )
}

/// A name with a suffix, inside an index or a closing quote: `buffer[5]` becomes `buffer_start[5]`, `'a.b'` becomes
/// `'a.b_start'`.
fn suffixed(name: &str, suffix: &str) -> String {
    let end = if name.ends_with(']') { name.rfind('[').unwrap_or(name.len()) } else { name.len() };
    let end = end - usize::from(name[..end].ends_with('\''));
    format!("{}{suffix}{}", &name[..end], &name[end..])
}

/// The name as a C identifier: all characters except ASCII letters and digits become underscores.
pub(crate) fn identifier(name: &str) -> String {
    let mut identifier: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !identifier.starts_with(|c: char| c.is_ascii_alphabetic()) {
        identifier.insert(0, '_');
    }
    identifier
}
