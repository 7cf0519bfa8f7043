//! The C source in a block's FMU: the block's table, its law, translated from the Rust source, and the FMI functions.
//! The C code compares a hash of its results for a sequence of calls with that of the library built from the Rust
//! source.

use crate::build::workspace::{FmuCrate, Workspace};
use anyhow::{Context, Result, anyhow, ensure};
use blocks::table::fingerprint;
use blocks::table::number::{number, to_value};
use fmu::sources::{self, Check, Door, Field, Of, Parts, Subject, TakesEffect};
use host::instance::{Instance, Type};
use host::library::Library;
use laws::{Law, Sources};
use modeldescription::Interface;
use scl::ir::{self, Program, Scalar};
use scl::machine::{Code, Machine};
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// The C file of a block's FMU, for an FMI version.
///
/// # Errors
/// The law uses something that cannot be translated, in which case the error states file, line and column; or its
/// results differ from the library's.
pub(super) fn generate(
    workspace: &Workspace,
    fmu_crate: &FmuCrate,
    library: &Library,
    interface: &Interface,
    door: &'static Door,
) -> Result<String> {
    let table = &interface.table;
    let law = laws::read_whole(&rust(workspace, fmu_crate)?, &table.name)?;
    let printed = scl::c::print(&law.program).map_err(anyhow::Error::msg)?;
    let name = |function: usize| scl::c::name(&law.program, function);
    let mut places = Vec::new();
    for row in &table.rows {
        let path = format!("{}.{}", law.name, row.name);
        let offset = at(&law.program, &path).with_context(|| format!("the law of {} has no {}", law.name, row.name))?;
        places.push((offset, TakesEffect::AtOnce));
    }
    let pulse = match (table.mean, law.pulse) {
        (Some(mean), Some(pulse)) => Some((places[mean].0, at(&law.program, "pulse").unwrap_or_default(), name(pulse))),
        _ => None,
    };
    let check = law.check.as_ref().map(|check| (name(check.function), &check.messages));
    let mut fields = Vec::new();
    let record = ir::Type::Record(law.record);
    collect(&law.program, &record, at(&law.program, &law.name).unwrap_or_default(), "", &mut fields);
    let (call, restart) = (name(law.call), name(law.restart));
    let expected = sources::tape(&table.rows, &mut OfLibrary::new(library, interface)?)?;
    let found = sources::tape(&table.rows, &mut OfLaw::new(&law, interface, &places)?)?;
    ensure!(
        expected == found,
        "the law read from the source and the library return different values: they were built from different sources"
    );
    Ok(sources::file(&Parts {
        door,
        name: &table.name,
        variables: &table.rows,
        cycle: (table.cycle, (table.rows[table.cycle].start() * 1000.0).round()),
        hash: hash(&interface.guid),
        law: &printed,
        call: &call,
        places: &places,
        layout: None,
        texts: &[],
        memory: law.program.records[law.program.memory].start.len(),
        tape: expected,
        of: Of::Block {
            restart: &restart,
            mean: pulse.as_ref().map(|(mean, pulse, call)| (*mean, *pulse, call.as_str())),
            check: check.as_ref().map(|(call, messages)| Check {
                call,
                refusal: at(&law.program, "refusal").unwrap_or_default(),
                numbers: at(&law.program, "refusal_1").unwrap_or_default(),
                messages,
            }),
            fields: &fields,
        },
    }))
}

/// The offset of a number or a structure in memory.
fn at(program: &Program, path: &str) -> Option<usize> {
    program.find(path).map(|(offset, _)| offset)
}

/// The hash that a GUID encodes.
fn hash(guid: &str) -> u128 {
    let digits: String = guid.chars().filter(char::is_ascii_hexdigit).collect();
    let hash = u128::from_str_radix(&digits, 16).unwrap_or_default();
    debug_assert_eq!(fingerprint::text(hash), guid.as_bytes());
    hash
}

/// Collects the numbers in a structure, in the order in which a block stores them.
fn collect(program: &Program, ty: &ir::Type, offset: usize, name: &str, into: &mut Vec<Field>) {
    match ty {
        ir::Type::Scalar(ty) => {
            into.push(Field { name: name.into(), offset, size: ty.size(), is_truth: *ty == Scalar::Bool });
        }
        ir::Type::Record(record) => {
            for member in &program.records[*record].members {
                let name = if name.is_empty() { member.name.clone() } else { format!("{name}.{}", member.name) };
                collect(program, &member.ty, offset + member.offset, &name, into);
            }
        }
        _ => {}
    }
}

/// The Rust sources of a package's block: the blocks shipped with plcfmu, and the files in its folders.
fn rust(workspace: &Workspace, fmu_crate: &FmuCrate) -> Result<Sources> {
    let mut sources = Sources::of_blocks();
    for folder in &fmu_crate.folders {
        add(workspace, folder, &mut sources)?;
    }
    Ok(sources)
}

/// Adds the .rs and .md files in a folder and its subfolders, under their paths in the workspace.
fn add(workspace: &Workspace, folder: &Path, sources: &mut Sources) -> Result<()> {
    let unread = || format!("{} cannot be read", folder.display());
    let mut paths =
        fs::read_dir(folder).with_context(unread)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    paths.sort();
    for path in paths {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if path.is_dir() {
            add(workspace, &path, sources)?;
        } else if ["rs", "md"].contains(&extension) {
            let text = fs::read_to_string(&path).with_context(|| format!("{} cannot be read", path.display()))?;
            let shown = path.strip_prefix(&workspace.root).unwrap_or(&path);
            sources.add(shown.to_string_lossy().replace('\\', "/"), text);
        }
    }
    Ok(())
}

/// The library, called as a host would call it: one step per call.
struct OfLibrary<'a> {
    instance: Instance,
    interface: &'a Interface,
    calls: u32,
}

impl OfLibrary<'_> {
    fn new<'a>(library: &Library, interface: &'a Interface) -> Result<OfLibrary<'a>> {
        let mut instance = Instance::instantiate(library, "plcfmu", &interface.guid, None)?;
        instance.setup(0.0, None)?;
        instance.enter_initialization()?;
        instance.exit_initialization()?;
        Ok(OfLibrary { instance, interface, calls: 0 })
    }
}

impl Subject for OfLibrary<'_> {
    type Error = anyhow::Error;

    fn set(&mut self, row: usize, number: f64) -> Result<()> {
        self.instance.set(Type::from_kind(self.interface.table.rows[row].kind), row as u32, number)
    }

    fn call(&mut self) -> Result<bool> {
        let table = &self.interface.table;
        let cycle = (table.rows[table.cycle].start() * 1000.0).round();
        self.instance.step(f64::from(self.calls) * cycle / 1000.0, cycle / 1000.0)?;
        self.calls += 1;
        Ok(true)
    }

    fn get(&mut self, row: usize) -> Result<f64> {
        self.instance.get(Type::from_kind(self.interface.table.rows[row].kind), row as u32)
    }
}

/// The law that was read from the Rust source, run by an interpreter.
struct OfLaw<'a> {
    law: &'a Law,
    interface: &'a Interface,
    machine: Machine,
    places: &'a [(usize, TakesEffect)],
}

impl OfLaw<'_> {
    fn new<'a>(law: &'a Law, interface: &'a Interface, places: &'a [(usize, TakesEffect)]) -> Result<OfLaw<'a>> {
        let code = Code::compile(&law.program).map_err(|error| anyhow!("{error}"))?;
        let mut of = OfLaw { law, interface, machine: Machine::new(Arc::new(code)), places };
        of.run(law.restart)?;
        Ok(of)
    }

    /// Calls a function of the law, and sets the block's mean, if it has one, to the pulse of this call in percent.
    fn run(&mut self, function: usize) -> Result<()> {
        self.machine.call(function, 0).map_err(|stop| anyhow!("{stop:?}"))?;
        if let (Some(mean), Some(pulse)) = (self.interface.table.mean, at(&self.law.program, "pulse")) {
            let percent = 100.0 * self.machine.get(Scalar::I32, pulse).number();
            self.machine.set(ir::Value::from(percent), self.places[mean].0);
        }
        Ok(())
    }

    /// The type of a variable in memory.
    fn ty(&self, row: usize) -> Result<Scalar> {
        let path = format!("{}.{}", self.law.name, self.interface.table.rows[row].name);
        match self.law.program.find(&path) {
            Some((_, ir::Type::Scalar(ty))) => Ok(ty),
            _ => Err(anyhow!("{path} is not a number")),
        }
    }
}

impl Subject for OfLaw<'_> {
    type Error = anyhow::Error;

    fn set(&mut self, row: usize, number: f64) -> Result<()> {
        let value = to_value(number, self.interface.table.rows[row].kind).map_err(|range| anyhow!("{range}"))?;
        let value = ir::Value::new(self.ty(row)?, ir::Value::of_plc(value).bits());
        self.machine.set(value, self.places[row].0);
        Ok(())
    }

    fn call(&mut self) -> Result<bool> {
        self.run(self.law.call).map(|()| true)
    }

    fn get(&mut self, row: usize) -> Result<f64> {
        let value = self.machine.get(self.ty(row)?, self.places[row].0);
        Ok(number(value.to_plc(self.interface.table.rows[row].kind)))
    }
}
