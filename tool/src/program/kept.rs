//! The programs opened by the page, as FMUs of the catalogue in addition to the home's own.

use super::Kept;
use crate::home::Home;
use crate::linked::Instance;
use crate::message::{Entry, KnownLoop};
use anyhow::{Context, Result};
use fmu::component::Origin;
use manifest::Manifest;
use modeldescription::{Description, Table, shortened};
use parameters::{BlockType, Loop, Source};
use program::{Loaded, Program};
use run::component::{Component, Force, Type};
use run::dialog::{Group, Roles};
use run::fmus::Fmus;
use scl::watch::CodeBlock;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

/// The maximum number of warnings kept of a running program.
const MOST_WARNINGS: usize = 200;

/// A home whose catalogue also contains the programs opened by the page.
pub struct Programs<H> {
    home: H,
    kept: RefCell<Vec<Arc<Kept>>>,
    /// The program last instantiated under each member name.
    running: RefCell<BTreeMap<String, Rc<RefCell<Running>>>>,
}

/// A program instantiated in a loop.
struct Running {
    instance: Instance<Program>,
    warnings: Vec<String>,
    blocks: Arc<Vec<CodeBlock>>,
}

/// The running program as seen by the loop, which owns its members; the page watches the same instance.
struct Shared(Rc<RefCell<Running>>);

impl<H: Home> Programs<H> {
    /// A home without programs.
    pub fn new(home: H) -> Programs<H> {
        Programs { home, kept: RefCell::default(), running: RefCell::default() }
    }

    /// Adds a program to the catalogue and returns its name, which is also passed to `make`. A program that is already
    /// in the catalogue keeps its name; a changed program gets a new name, so that runs of the earlier one can still be
    /// repeated.
    pub(super) fn admit(
        &self,
        loaded: Loaded,
        make: impl FnOnce(Arc<Loaded>, String) -> Result<Kept>,
    ) -> Result<String> {
        let same = |kept: &&Arc<Kept>| kept.loaded.hash == loaded.hash;
        if let Some(kept) = self.kept.borrow().iter().find(same) {
            return Ok(kept.name.clone());
        }
        let own = loaded.table.name.clone();
        let taken = self.entries();
        let mut name = own.clone();
        let mut number = 1;
        while taken.iter().any(|entry| entry.name == name) {
            number += 1;
            name = format!("{own}_{number}");
        }
        let kept = make(Arc::new(loaded), name)?;
        let name = kept.name.clone();
        self.kept.borrow_mut().push(Arc::new(kept));
        Ok(name)
    }

    /// Passes a running program, its warnings and its blocks to `look`.
    pub(super) fn with_running<T>(
        &self,
        member: &str,
        look: impl FnOnce(&Program, &[String], &[CodeBlock]) -> T,
    ) -> Result<T> {
        let all = self.running.borrow();
        let running =
            all.get(member).with_context(|| format!("no program is running as {:?}", shortened(member)))?.borrow();
        Ok(look(running.instance.block(), &running.warnings, &running.blocks))
    }

    /// Calls `run`, which may instantiate programs; then the programs of the current run are watched again.
    pub(crate) fn beside<T>(&self, run: impl FnOnce() -> T) -> T {
        let present = self.running.borrow().clone();
        let done = run();
        self.running.replace(present);
        done
    }

    fn find(&self, fmu: &str) -> Option<Arc<Kept>> {
        self.kept.borrow().iter().find(|kept| kept.name == fmu).cloned()
    }
}

impl<H: Home> Fmus for Programs<H> {
    fn description(&self, fmu: &str) -> Result<Arc<Description>> {
        self.find(fmu).map_or_else(|| self.home.description(fmu), |kept| Ok(kept.description.clone()))
    }

    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>> {
        self.find(fmu).map_or_else(|| self.home.table(fmu), |kept| Ok(Some(kept.table.clone())))
    }

    fn dialog(&self, fmu: &str, table: &Table) -> Result<(Roles, Vec<Group>)> {
        let known = self.find(fmu).and_then(|kept| kept.dialog.clone());
        known.map_or_else(|| self.home.dialog(fmu, table), Ok)
    }

    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>> {
        let Some(kept) = self.find(fmu) else { return self.home.instantiate(fmu, name) };
        let program = Program::new(kept.loaded.clone()).watched();
        let origin = Origin { hash: kept.loaded.hash, form: 0, start: program };
        let instance = Instance::from_origin(name, origin)?;
        let running = Running { instance, warnings: Vec::new(), blocks: kept.blocks.clone() };
        let running = Rc::new(RefCell::new(running));
        self.running.borrow_mut().insert(name.to_string(), running.clone());
        Ok(Box::new(Shared(running)))
    }
}

impl<H: Home> Home for Programs<H> {
    fn entries(&self) -> Vec<Entry> {
        let entry = |kept: &Arc<Kept>| Entry {
            name: kept.name.clone(),
            summary: kept.table.summary(),
            part: kept.part(),
            is_foreign: false,
        };
        let mut entries = self.home.entries();
        entries.extend(self.kept.borrow().iter().map(entry));
        entries
    }

    fn known_loops(&self) -> Vec<KnownLoop> {
        self.home.known_loops()
    }

    fn blocks(&self) -> Vec<Arc<BlockType>> {
        self.home.blocks()
    }

    fn preset(&self, of: &Loop) -> Result<Vec<u8>> {
        self.home.preset(of)
    }

    fn program(&self, fmu: &str) -> Option<Manifest> {
        Some(self.find(fmu)?.manifest.clone())
    }

    fn sources(&self, fmu: &str) -> Vec<Source> {
        self.find(fmu).map(|kept| kept.sources.clone()).unwrap_or_default()
    }
}

impl Component for Shared {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.0.borrow_mut().instance.setup(start, stop)
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.0.borrow_mut().instance.enter_initialization()
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.0.borrow_mut().instance.exit_initialization()
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.0.borrow_mut().instance.read(kind, references, values)
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        self.0.borrow_mut().instance.write(kind, references, values)
    }

    fn force(&mut self, reference: u32, how: Force) -> Result<()> {
        self.0.borrow_mut().instance.force(reference, how)
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        let Running { instance, warnings, .. } = &mut *self.0.borrow_mut();
        let done = instance.step(time, size);
        let room = MOST_WARNINGS - warnings.len().min(MOST_WARNINGS);
        warnings.extend(instance.take_advice().into_iter().take(room));
        done
    }

    fn terminate(&mut self) -> Result<()> {
        self.0.borrow_mut().instance.terminate()
    }
}
