//! A PLC program in SCL that an FMU calls every CYCLE.
//!
//! The FMU's resources contain the sources and the [`Manifest`], which states how to build the program from them. The
//! library compiles them when it creates instances; the GUID is a hash of all of them, so that no other program can be
//! mistaken for this one.
//!
//! ```text
//! Manifest, sources --Loaded::new--> Table, Code --Program::new--> Program: a machine with its memory, called by fmu
//! ```

mod inside;
pub mod project;
mod sources;
pub mod survey;
mod table;
mod wrong;

pub use inside::InnerInstance;
pub use table::TextPlace;
pub use wrong::Wrong;

use blocks::table::{fingerprint, start};
use blocks::{LReal, Real, Table, Time, Value};
use fmu::component::{Library, Origin};
use fmu::cyclic::Cyclic;
use fmu::layout::Layout;
use fmu::preset::{self, Argument, Identity};
use fmu::refusal::Refusal;
use fmu::resources;
use manifest::{FILE, Manifest};
use parameters::{Problems, Source};
use scl::machine::{Code, Machine};
use scl::{Compiled, Note, compile, compile_watched};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use table::Held;

/// The maximum size of a program file, in bytes.
pub const LARGEST: u64 = 16 << 20;

/// A compiled program with its table.
pub struct Loaded {
    /// The program's interface to the host.
    pub table: Table,
    /// The hash from which the GUID is formed.
    pub hash: u128,
    /// Warnings for the author, with file and line.
    pub warnings: Vec<Problems>,
    /// The locals in which a watched program records the values of its wires.
    notes: Vec<Note>,
    /// The arrays in the table.
    layout: Option<Layout>,
    program: scl::ir::Program,
    code: Arc<Code>,
    /// The index of the function called every cycle.
    cycle: usize,
    places: Vec<table::RowMemory>,
    texts: Vec<table::TextPlace>,
    /// The rows that both the host and the program write.
    in_outs: Vec<usize>,
    /// The index of the function called once at the start.
    startup: Option<usize>,
    /// The address of the block's own variable for the time between two calls, if it has one.
    own_cycle: Option<usize>,
    /// The name of the block, or of the first of several.
    block: String,
    /// The name of the instance in memory; empty unless a single instance runs.
    instance: String,
    budget: u32,
}

impl Loaded {
    /// Compiles a program. A unit stated in a variable's comment is entered in the table if `is_unit` accepts it.
    ///
    /// # Errors
    /// The sources contain errors (all are returned, with file, line and column), or there is no block to run.
    pub fn new(manifest: &Manifest, sources: &[Source], is_unit: fn(&str) -> bool) -> Result<Loaded, Wrong> {
        Loaded::from_compiled(compile(sources, manifest).map_err(Wrong::Sources)?, manifest, sources, is_unit)
    }

    /// Like [`Loaded::new`], but the program also records the values of its wires and the operands of its conditions.
    /// Its results are the same.
    ///
    /// # Errors
    /// As [`Loaded::new`].
    pub fn watched(manifest: &Manifest, sources: &[Source], is_unit: fn(&str) -> bool) -> Result<Loaded, Wrong> {
        Loaded::from_compiled(compile_watched(sources, manifest).map_err(Wrong::Sources)?, manifest, sources, is_unit)
    }

    fn from_compiled(
        compiled: Compiled,
        manifest: &Manifest,
        sources: &[Source],
        is_unit: fn(&str) -> bool,
    ) -> Result<Loaded, Wrong> {
        let code = Code::compile(&compiled.program)?;
        let root = compiled.root.as_ref().ok_or_else(|| Wrong::Choice {
            blocks: compiled.candidates.clone(),
            warnings: compiled.warnings.clone(),
        })?;
        let table::Shown { table, places, texts, own_cycle } = table::build(manifest, &compiled, root, is_unit)?;
        let in_outs = (0..places.len()).filter(|row| places[*row].held == Held::InOut).collect();
        let mut bytes = manifest.to_string().into_bytes();
        for source in sources {
            bytes.extend((source.text.len() as u64).to_le_bytes());
            bytes.extend(source.text.as_bytes());
        }
        Ok(Loaded {
            layout: Layout::new(&table),
            table,
            hash: fingerprint::checksum(&bytes),
            warnings: compiled.warnings,
            notes: compiled.notes,
            code: Arc::new(code),
            cycle: root.cycle,
            startup: root.startup,
            program: compiled.program,
            places,
            texts,
            in_outs,
            own_cycle,
            block: root.block.clone(),
            instance: root.instance.clone(),
            budget: manifest.budget.unwrap_or(Machine::BUDGET),
        })
    }

    /// The GUID of its FMU.
    pub fn guid(&self) -> String {
        String::from_utf8_lossy(&fingerprint::text(self.hash)).into_owned()
    }
}

/// A program with its memory.
#[derive(Clone)]
pub struct Program {
    loaded: Arc<Loaded>,
    machine: Machine,
    /// The time between two calls, in milliseconds.
    cycle: i32,
    /// The number of calls since the restart.
    calls: u64,
    /// The values set by the host, as bits: one per row, but used only for rows that the program also writes or that
    /// apply at the start.
    set: Vec<u64>,
    stopped: Option<String>,
    /// Whether to record which lines the last call executed.
    is_watched: bool,
}

impl Program {
    /// A program with its start values.
    pub fn new(loaded: Arc<Loaded>) -> Program {
        let mut machine = Machine::new(loaded.code.clone());
        machine.budget = loaded.budget;
        let cycle = match loaded.table.rows[loaded.table.cycle].start {
            Value::Time(time) => time.milliseconds(),
            _ => 0,
        };
        let set = loaded.places.iter().map(|place| machine.get(place.ty, place.offset).bits()).collect();
        Program { machine, cycle, calls: 0, set, stopped: None, is_watched: false, loaded }
    }

    /// Copies to the machine the time between two calls and the host's values of variables that the program also
    /// writes.
    fn give(&mut self) {
        for row in &self.loaded.in_outs {
            let place = self.loaded.places[*row];
            self.machine.set(scl::ir::Value::new(place.ty, self.set[*row]), place.offset);
        }
        if let Some(offset) = self.loaded.own_cycle {
            self.machine.set(self.cycle.into(), offset);
        }
    }

    /// Calls a function at a time in nanoseconds since the start. If the program stops in it, records the reason, and
    /// no further calls are made until the next restart.
    fn run(&mut self, function: usize, now: i64) {
        if let Err(stop) = self.machine.call(function, now) {
            let seconds = now as f64 / 1e9;
            self.stopped = Some(format!("{stop} (call {}, {seconds:?} s after the start)", self.calls));
        }
    }
}

impl Cyclic for Program {
    const IS_SURE: bool = false;

    type StartValues = Program;

    type Text = String;

    fn new(start: &Program) -> Program {
        start.clone()
    }

    fn table(&self) -> &Table {
        &self.loaded.table
    }

    fn layout(&self) -> Option<&Layout> {
        self.loaded.layout.as_ref()
    }

    fn cycle(&self) -> Time {
        Time::ms(self.cycle)
    }

    fn get(&self, row: usize) -> Option<Value> {
        let kind = self.loaded.table.rows.get(row)?.kind;
        if row == self.loaded.table.cycle {
            return Some(Value::Time(Time::ms(self.cycle)));
        }
        let place = self.loaded.places.get(row)?;
        let value = match place.held {
            Held::Memory => self.machine.get(place.ty, place.offset),
            Held::InOut | Held::Start => scl::ir::Value::new(place.ty, self.set[row]),
        };
        Some(value.to_plc(kind))
    }

    fn set(&mut self, row: usize, value: Value) -> bool {
        if self.loaded.table.rows.get(row).is_none_or(|row| row.kind != value.kind()) {
            return false;
        }
        match (value, self.loaded.places.get(row)) {
            (Value::Time(time), _) if row == self.loaded.table.cycle => self.cycle = time.milliseconds(),
            (_, Some(place)) if place.held != Held::Memory => self.set[row] = scl::ir::Value::of_plc(value).bits(),
            (_, Some(place)) => self.machine.set(scl::ir::Value::of_plc(value), place.offset),
            _ => return false,
        }
        true
    }

    fn real(&self, row: usize) -> Option<Real> {
        match self.get(row)? {
            Value::Real(real) => Some(real),
            _ => None,
        }
    }

    // The machine's memory consists of bytes, so there is no number to return a reference to; `set` writes values.
    fn real_mut(&mut self, _row: usize) -> Option<&mut Real> {
        None
    }

    fn lreal(&self, row: usize) -> Option<LReal> {
        match self.get(row)? {
            Value::LReal(lreal) => Some(lreal),
            _ => None,
        }
    }

    fn lreal_mut(&mut self, _row: usize) -> Option<&mut LReal> {
        None
    }

    fn set_mean(&mut self, _percent: LReal) {}

    /// A warm restart: all variables are reset to their start values, except those set by the host.
    fn restart(&mut self) {
        let rows = &self.loaded.table.rows;
        let is_kept = |row: &usize| *row != self.loaded.table.cycle && rows[*row].role.is_settable();
        let kept: Vec<_> = (0..rows.len()).filter(is_kept).filter_map(|row| Some((row, self.get(row)?))).collect();
        let is_given = |text: &usize| self.loaded.table.texts[*text].role.is_settable();
        let texts = (0..self.loaded.texts.len()).filter(is_given).map(|text| self.loaded.texts[text]);
        let texts: Vec<_> =
            texts.map(|at| (at.offset, self.machine.state()[at.offset..][..at.size()].to_vec())).collect();
        self.machine.restart();
        for (row, value) in kept {
            self.set(row, value);
        }
        for (offset, bytes) in texts {
            self.machine.state_mut()[offset..][..bytes.len()].copy_from_slice(&bytes);
        }
        (self.calls, self.stopped) = (0, None);
        for (place, set) in self.loaded.places.iter().zip(&self.set).filter(|(place, _)| place.held == Held::Start) {
            self.machine.set(scl::ir::Value::new(place.ty, *set), place.offset);
        }
        self.give();
        if let Some(startup) = self.loaded.startup {
            self.run(startup, 0);
        }
    }

    fn call(&mut self) {
        if self.stopped.is_some() {
            return;
        }
        self.give();
        if self.is_watched {
            self.machine.forget_coverage();
        }
        let now = (self.calls as i64).wrapping_mul(i64::from(self.cycle)).wrapping_mul(1_000_000);
        self.run(self.loaded.cycle, now);
        self.calls += u64::from(self.stopped.is_none());
    }

    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    fn advice(&self) -> Vec<String> {
        Vec::new()
    }

    fn pulse(&self) -> i32 {
        0
    }

    fn stopped(&self) -> Option<&str> {
        self.stopped.as_deref()
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.machine.take_warnings().iter().map(ToString::to_string).collect()
    }

    fn text(&self, number: usize) -> Option<String> {
        Some(self.loaded.texts.get(number)?.read(self.machine.state()))
    }

    fn set_text(&mut self, number: usize, units: &[u16]) {
        if let Some(place) = self.loaded.texts.get(number) {
            place.write(self.machine.state_mut(), units);
        }
    }

    fn store(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.cycle.to_le_bytes());
        bytes.extend(self.calls.to_le_bytes());
        self.set.iter().for_each(|set| bytes.extend(set.to_le_bytes()));
        let stopped = self.stopped.as_deref().unwrap_or_default();
        bytes.extend((stopped.len() as u64).to_le_bytes());
        bytes.extend(stopped.as_bytes());
        bytes.extend(self.machine.state());
    }

    fn restored(&self, bytes: &mut &[u8]) -> Option<Program> {
        let mut restored = Program::new(self.loaded.clone());
        restored.cycle = i32::from_le_bytes(take(bytes)?);
        restored.calls = u64::from_le_bytes(take(bytes)?);
        for set in &mut restored.set {
            *set = u64::from_le_bytes(take(bytes)?);
        }
        let length = usize::try_from(u64::from_le_bytes(take(bytes)?)).ok()?;
        let (stopped, rest) = bytes.split_at_checked(length)?;
        restored.stopped = Some(String::from_utf8(stopped.to_vec()).ok()?).filter(|reason| !reason.is_empty());
        let (state, rest) = rest.split_at_checked(restored.machine.state().len())?;
        restored.machine.state_mut().copy_from_slice(state);
        *bytes = rest;
        Some(restored)
    }
}

/// Splits off the first `N` bytes.
fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

/// The programs compiled by this process, keyed by manifest and sources. Instances of the same FMU share one.
static LOADED: Mutex<Option<HashMap<Vec<u8>, Arc<Loaded>>>> = Mutex::new(None);

impl Library for Program {
    type Block = Program;

    /// The program is in the resources. The identifier that the host read in modelDescription.xml must belong to
    /// the program or to one of its presets; a preset's start values are also in the resources.
    fn open(identity: Identity, location: Argument) -> Result<Origin<Program>, Refusal> {
        if identity.value.is_none() {
            return Err(format!("{} = NULL: pass the value from the FMU's modelDescription.xml", identity.name).into());
        }
        let file = |name: &str| {
            resources::read(location, name, LARGEST).map_err(|why| {
                format!("the FMU's program cannot be read from resources/{name}: {why}; unpack the FMU again")
            })
        };
        let (path, bytes) = file(FILE)?;
        let damaged = |why: String| format!("{path}: {why}; unpack the FMU again");
        let text = String::from_utf8(bytes).map_err(|_| damaged("it is not UTF-8".into()))?;
        let manifest = Manifest::parse(&text).map_err(damaged)?;
        let mut key = text.into_bytes();
        let mut sources = Vec::new();
        for name in manifest.sources.iter().map(|source| source.display().to_string()) {
            let (_, bytes) = file(&name)?;
            key.extend((bytes.len() as u64).to_le_bytes());
            key.extend_from_slice(&bytes);
            sources.push((name, bytes));
        }
        let mut known = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
        let known = known.get_or_insert_default();
        let loaded = match known.get(&key) {
            Some(loaded) => loaded.clone(),
            None => {
                let sources: Vec<Source> = sources.into_iter().map(|(name, bytes)| Source::new(name, bytes)).collect();
                let loaded = Arc::new(Loaded::new(&manifest, &sources, |_| false).map_err(|wrong| wrong.to_string())?);
                known.insert(key, loaded.clone());
                loaded
            }
        };
        let mut program = Program::new(loaded.clone());
        if let Some((form, hash)) = identity.form(loaded.hash) {
            return Ok(Origin { hash, form, start: program });
        }
        if resources::read(location, start::FILE, start::LARGEST).is_err() {
            return Err(format!(
                "{} = {}: the program in resources has the identifier {}, so it was changed or replaced; unpack the FMU again",
                identity.name,
                identity.shown(),
                identity.text(loaded.hash)
            )
            .into());
        }
        let (form, hash, settings) = preset::read(identity, location, &loaded.table, loaded.hash)?;
        for (row, value) in settings {
            program.set(row, value);
        }
        Ok(Origin { hash, form, start: program })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmu::component::Component;

    const SOURCE: &str = "FUNCTION_BLOCK Pump VAR_INPUT level : REAL := 1.5; on : BOOL; END_VAR
        VAR_OUTPUT flow : REAL; END_VAR VAR_IN_OUT sum : DINT; END_VAR
        BEGIN flow := level * 2.0; sum := sum + 1; END_FUNCTION_BLOCK";

    fn pump() -> Program {
        program(SOURCE)
    }

    fn program(source: &str) -> Program {
        let manifest = Manifest { cycle: Some(100), sources: vec!["pump.scl".into()], ..Manifest::default() };
        let loaded = Loaded::new(&manifest, &[Source::new("pump.scl", source.into())], |_| true);
        Program::new(Arc::new(loaded.unwrap_or_else(|error| panic!("{error}"))))
    }

    fn row(program: &Program, name: &str) -> usize {
        program.table().find(name).unwrap_or_else(|| panic!("{name}"))
    }

    #[test]
    fn what_is_set_is_read_and_computed_with_and_an_in_out_is_an_input_and_an_output() {
        let mut pump = pump();
        let [level, flow, sum, sum_out] = ["level", "flow", "sum", "sum_out"].map(|name| row(&pump, name));
        assert_eq!(pump.get(level), Some(Value::Real(1.5)));
        assert!(pump.set(level, Value::Real(4.0)) && pump.set(sum, Value::Whole(blocks::Kind::DInt, 7)));
        pump.restart();
        for _ in 0..2 {
            pump.call();
            assert_eq!((pump.get(level), pump.real(flow)), (Some(Value::Real(4.0)), Some(8.0)));
            let whole = |whole| Some(Value::Whole(blocks::Kind::DInt, whole));
            assert_eq!((pump.get(sum), pump.get(sum_out)), (whole(7), whole(8)));
        }
        assert!(!pump.set(level, Value::Bool(true)) && !pump.set(99, Value::Real(1.0)));
    }

    #[test]
    fn a_warning_of_a_call_leaves_room_for_the_advice_on_a_short_step() {
        let source = "FUNCTION_BLOCK Pump VAR_INPUT rate : DINT; END_VAR VAR_OUTPUT flow : DINT; END_VAR
            BEGIN flow := 60 / rate; END_FUNCTION_BLOCK";
        let mut component = Component::<Program>::new(Origin { hash: 0, form: 0, start: program(source) }, true);
        component.instance.setup_experiment(0.0, None).unwrap();
        component.exit_initialization_mode().unwrap();
        let mut advice = [(0.0, 0.1), (0.1, 0.0005), (0.1005, 0.0005)].map(|(tc, h)| {
            component.do_step(tc, h).unwrap();
            std::mem::take(&mut component.advice)
        });
        assert_eq!(advice[0], ["pump.scl:2: division by 0: the result is 0"]);
        assert!(advice[1].pop().unwrap().contains("0.0005"), "{advice:?}");
        assert!(advice[1].is_empty() && advice[2].is_empty(), "{advice:?}");
    }

    #[test]
    fn a_name_is_refused_without_a_list_where_there_is_none_to_choose_from() {
        let refused = |source: &str, manifest: Manifest| {
            let manifest = Manifest { cycle: Some(100), sources: vec!["pump.scl".into()], ..manifest };
            Loaded::new(&manifest, &[Source::new("pump.scl", source.into())], |_| true).err().unwrap().to_string()
        };
        let block = "FUNCTION_BLOCK Pump VAR_OUTPUT on : BOOL; END_VAR BEGIN on := TRUE; END_FUNCTION_BLOCK";
        let refusal = refused(block, Manifest { parameters: vec!["level".into()], ..Manifest::default() });
        assert_eq!(refusal, "Pump has no input that could become a parameter: remove level");
        let ty = "TYPE Level STRUCT low : REAL; END_STRUCT END_TYPE";
        let refusal = refused(ty, Manifest { block: Some("Pump".into()), ..Manifest::default() });
        assert!(refusal.contains(": no function block named Pump: the sources declare none"), "{refusal}");
    }

    #[test]
    fn all_rows_of_a_variable_of_a_data_block_that_is_called_as_one_of_the_block_say_so() {
        let source = "DATA_BLOCK tank VAR RETAIN level : REAL; END_VAR BEGIN END_DATA_BLOCK
            FUNCTION_BLOCK Pump VAR_OUTPUT flow : REAL; END_VAR VAR tank : STRUCT level : REAL; END_STRUCT; END_VAR
            BEGIN flow := #tank.level; \"tank\".level := \"tank\".level + 1.0; END_FUNCTION_BLOCK";
        let manifest = Manifest { cycle: Some(100), sources: vec!["pump.scl".into()], ..Manifest::default() };
        let loaded = Loaded::new(&manifest, &[Source::new("pump.scl", source.into())], |_| true);
        let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
        let names: Vec<_> = loaded.table.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["flow", "tank.level", "PLC.tank.level", "PLC.tank.level_start", "CYCLE"]);
    }

    #[test]
    fn dates_and_times_of_day_are_whole_numbers() {
        let source = "FUNCTION_BLOCK Night VAR_INPUT day : DATE := D#1990-01-03; from : TOD := TOD#00:00:01.5; END_VAR
            VAR_OUTPUT late : BOOL; END_VAR BEGIN late := from > TOD#22:00:00; END_FUNCTION_BLOCK";
        let manifest = Manifest { cycle: Some(100), sources: vec!["night.scl".into()], ..Manifest::default() };
        let loaded = Loaded::new(&manifest, &[Source::new("night.scl", source.into())], |_| true);
        let mut night = Program::new(Arc::new(loaded.unwrap_or_else(|error| panic!("{error}"))));
        let [day, from, late] = ["day", "from", "late"].map(|name| row(&night, name));
        assert_eq!(night.get(day), Some(Value::Whole(blocks::Kind::UInt, 2)));
        assert_eq!(night.get(from), Some(Value::Whole(blocks::Kind::UDInt, 1500)));
        assert_eq!(night.table().rows[from].description, "ms since midnight");
        assert!(night.set(from, Value::Whole(blocks::Kind::UDInt, 23 * 3_600_000)));
        night.call();
        assert_eq!(night.get(late), Some(Value::Bool(true)));
    }
}
