//! The home of the engine in `plcfmu tool`: the FMUs that it can use. FMU libraries are never loaded into this process:
//! plcfmu's blocks are linked into it, and instances of other FMUs run in separate processes.

use crate::linked;
use crate::package::apart;
use crate::package::preset::Original;
use crate::parameter_file;
use crate::tool::child;
use anyhow::{Context, Result, bail, ensure};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use host::child::Starter;
use host::fmu::{has_table, has_text};
use host::package::{Package, temporary};
use modeldescription::{Description, Table, shortened};
use parameters::{BlockType, Format, Loop};
use run::component::Component;
use run::fmus::Fmus;
use serde::Serialize;
use std::cell::RefCell;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use study::worker;
use tool::home::Home;
use tool::message::{Entry, KnownLoop, LoopRole};

/// The maximum number of FMUs that a page may upload.
const MOST_UPLOADS: usize = 20;

/// An FMU, and where its instances run.
#[derive(Debug)]
pub struct Known {
    /// Its name in the catalogue.
    pub name: String,
    description: Arc<Description>,
    /// The table of its block; `None` for a foreign FMU.
    table: Option<Arc<Table>>,
    part: LoopRole,
    source: Source,
}

#[derive(Debug)]
enum Source {
    /// In this process: its library was compiled from the same code that is linked into this program.
    Linked(Box<worker::Linked>, PathBuf),
    /// Each in a separate process.
    Apart(PathBuf),
    /// Each in a separate process, for an FMU sent by a page; the file is deleted when this is dropped.
    Uploaded(temporary::Document),
}

impl Known {
    /// Opens an FMU. If it was made with `fmu::export!` and this program does not contain its block, its table is read
    /// by running its library with `starter`. Without a starter, the FMU counts as foreign.
    ///
    /// # Errors
    /// The FMU is damaged, or has no library for this platform.
    pub fn open(path: &Path, starter: Option<&Starter>) -> Result<Known> {
        let mut package = Package::open(path)?;
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let has_table = has_table(&mut package)?;
        let linked = linked::find(&package.description).filter(|_| has_table);
        let table = match (&linked, starter.filter(|_| has_table)) {
            (Some(linked), _) => Some(linked.table.clone()),
            (None, Some(starter)) => Some(apart::interface(starter, path)?.table),
            (None, None) => None,
        };
        let mut is_same =
            |of: &worker::Linked| of.code.is_some_and(|code| has_text(&mut package, code).unwrap_or(false));
        let source = match linked.filter(&mut is_same) {
            Some(linked) => Source::Linked(Box::new(linked), path.into()),
            None => Source::Apart(path.into()),
        };
        let part = table.as_ref().map_or(LoopRole::Other, part);
        Ok(Known { name, description: Arc::new(package.description), table: table.map(Arc::new), part, source })
    }

    /// Marks the FMU as a plant, unless it specifies a role itself.
    pub fn into_plant(mut self) -> Known {
        if self.part == LoopRole::Other {
            self.part = LoopRole::Plant;
        }
        self
    }

    /// Whether its block is unknown: it was not made with `fmu::export!`, or its library may not be run.
    pub fn is_foreign(&self) -> bool {
        self.table.is_none()
    }

    /// Its entry in the catalogue.
    fn entry(&self) -> Entry {
        Entry {
            name: self.name.clone(),
            summary: self.description.description.as_deref().map(short).unwrap_or_default(),
            part: self.part,
            is_foreign: self.is_foreign() || matches!(self.source, Source::Uploaded(_)),
        }
    }
}

/// The role of an FMU in a loop, according to the dialog in its documentation.
fn part(table: &Table) -> LoopRole {
    run::dialog::read(table).map_or(LoopRole::Other, |(roles, _)| roles.part(table))
}

/// A string from a foreign FMU, shortened for display.
fn short(text: &str) -> String {
    const MOST: usize = 400;
    text.chars().take(MOST).collect()
}

/// Asks the user whether an uploaded FMU may run. Text from the FMU is quoted and shortened, so that it cannot be
/// mistaken for the tool's own.
fn question(name: &str, description: &Description) -> String {
    let said = [("tool", &description.generation_tool), ("author", &description.author)];
    let said = said.map(|(what, text)| text.as_deref().map(|text| format!("{what} {:?}", shortened(text))));
    let said: Vec<String> = said.into_iter().flatten().collect();
    let origin =
        if said.is_empty() { "It does not name its origin".into() } else { format!("It names {}", said.join(", ")) };
    format!(
        "The FMU {:?} is third-party native code. {origin}; nothing has been verified. Let \
         it run on this machine, with all your permissions?",
        shortened(name)
    )
}

/// The state shared by all pages of a server.
#[derive(Debug)]
pub struct Collection {
    fmus: Vec<Arc<Known>>,
    blocks: Vec<Arc<BlockType>>,
    loops: Vec<KnownLoop>,
    starter: Starter,
}

impl Collection {
    /// Creates a collection with the FMUs in this order: controllers, plants, others, each sorted by name.
    pub fn new(mut fmus: Vec<Known>, starter: Starter) -> Collection {
        let rank = |part: LoopRole| {
            [LoopRole::Controller, LoopRole::Plant, LoopRole::Other].iter().position(|other| *other == part)
        };
        fmus.sort_by(|a, b| (rank(a.part), &a.name).cmp(&(rank(b.part), &b.name)));
        let mut blocks = BlockType::all();
        for table in fmus.iter().filter_map(|known| known.table.as_ref()) {
            if !blocks.iter().any(|block| block.name == table.name) {
                blocks.push(Arc::new(BlockType::from(&**table)));
            }
        }
        let is_there = |name: &str| fmus.iter().any(|known| known.name == name && known.table.is_some());
        let loops = tool::known::loops(is_there);
        Collection { fmus: fmus.into_iter().map(Arc::new).collect(), blocks, loops, starter }
    }

    /// The tables of the FMUs that have one.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.fmus.iter().filter_map(|known| known.table.as_deref())
    }

    /// The start values of a known block's FMU, as a parameter file; `None` for any other FMU.
    fn parameters(&self, description: &Description, name: &str) -> Option<File> {
        let of_block = |block: &Arc<BlockType>| parameter_file::start_values(description, block, name, name).ok();
        let mut blocks = self.blocks.iter().filter(|block| parameter_file::is_of(description, block));
        let one = blocks.find_map(of_block)?;
        let content = parameters::write(Format::Json, &[one], name).ok()?;
        Some(File::new(format!("{name}.json"), &content))
    }

    /// The start values of a preset at `path`, as a parameter file; `None` for any other FMU.
    ///
    /// # Errors
    /// The FMU is damaged.
    pub fn preset(&self, path: &Path) -> Result<Option<File>> {
        let original = Original::open(path)?;
        let description = Package::open(path)?.description;
        Ok(self.parameters(&description, &description.model_name).filter(|_| original.is_preset))
    }
}

/// A file to open in the page.
#[derive(Clone, Debug, Serialize)]
pub struct File {
    file: String,
    /// The content in Base64.
    content: String,
}

impl File {
    /// A file with this name and content.
    pub fn new(file: String, content: &[u8]) -> File {
        File { file, content: BASE64_STANDARD.encode(content) }
    }
}

/// The description of an uploaded FMU for the page. None of its code has run.
#[derive(Clone, Debug, Serialize)]
pub struct Inspected {
    name: String,
    model: String,
    summary: String,
    tool: Option<String>,
    author: Option<String>,
    /// The question to the user before it runs, which quotes text from the FMU.
    question: String,
    platforms: Vec<String>,
    /// Why it cannot run here.
    problem: Option<String>,
    /// The start values, if the FMU's block is known.
    parameters: Option<File>,
}

/// The home of one page's engine. Clones share their state.
#[derive(Clone, Debug)]
pub struct FmuHome {
    collection: Arc<Collection>,
    uploads: Rc<RefCell<Uploads>>,
}

#[derive(Debug, Default)]
struct Uploads {
    /// The uploads that the user has not accepted yet.
    waiting: Vec<(String, temporary::Document)>,
    accepted: Vec<Arc<Known>>,
}

impl FmuHome {
    /// The home of a new page.
    pub fn new(collection: Arc<Collection>) -> FmuHome {
        FmuHome { collection, uploads: Rc::default() }
    }

    /// Receives an FMU from the page, and reads it. It is not used until the user accepts it.
    ///
    /// # Errors
    /// The file is damaged or not an FMU, or there are too many uploads.
    pub fn upload(&self, file: &str, bytes: &[u8]) -> Result<Inspected> {
        let name = Path::new(file).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let shown = || short(&name);
        let mut package = Package::read(Cursor::new(bytes)).with_context(shown)?;
        let name = self.free_name(name.strip_suffix(".fmu").unwrap_or(&name));
        let problem = has_table(&mut package).err().map(|error| format!("{error:#}"));
        let description = &package.description;
        let inspected = Inspected {
            model: shortened(&description.model_name).into_owned(),
            summary: description.description.as_deref().map(short).unwrap_or_default(),
            tool: description.generation_tool.as_deref().map(short),
            author: description.author.as_deref().map(short),
            question: question(&name, description),
            platforms: package.libraries.iter().map(|library| short(&library.platform)).collect(),
            problem,
            parameters: self.collection.parameters(description, &description.model_name),
            name,
        };
        let uploads = &mut *self.uploads.borrow_mut();
        uploads.waiting.retain(|(other, _)| *other != inspected.name);
        ensure!(
            uploads.waiting.len() + uploads.accepted.len() < MOST_UPLOADS,
            "a page can upload at most {MOST_UPLOADS} FMUs: reload it to start over"
        );
        uploads.waiting.push((inspected.name.clone(), temporary::Document::new(None, bytes)?));
        Ok(inspected)
    }

    /// Records that the user allows the code of an uploaded FMU to run.
    ///
    /// # Errors
    /// The page has uploaded no FMU with this name, or it cannot be loaded here.
    pub fn accept(&self, name: &str) -> Result<Entry> {
        let uploads = &mut *self.uploads.borrow_mut();
        if let Some(known) = uploads.accepted.iter().find(|known| known.name == name) {
            return Ok(known.entry());
        }
        let place = uploads.waiting.iter().position(|(other, _)| other == name);
        let place = place.with_context(|| format!("no FMU {:?} has been uploaded", shortened(name)))?;
        let path = uploads.waiting[place].1.path();
        let mut package = Package::open(path)?;
        let mut table = None;
        if has_table(&mut package)? {
            table = Some(Arc::new(apart::interface(&self.collection.starter, path)?.table));
        }
        let (name, file) = uploads.waiting.remove(place);
        let known = Known {
            name,
            description: Arc::new(package.description),
            part: table.as_deref().map_or(LoopRole::Other, part),
            table,
            source: Source::Uploaded(file),
        };
        let entry = known.entry();
        uploads.accepted.push(Arc::new(known));
        Ok(entry)
    }

    /// The name, with a number appended if another FMU has it. Uploads that have not been accepted do not reserve their
    /// names.
    fn free_name(&self, name: &str) -> String {
        let name = shortened(if name.is_empty() { "FMU" } else { name }).replace(|c: char| c.is_control(), "");
        let is_taken = |name: &String| self.known(name).is_ok();
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        std::iter::once(name.clone()).chain(numbered).find(|name| !is_taken(name)).unwrap_or(name)
    }

    fn known(&self, name: &str) -> Result<Arc<Known>> {
        let uploads = self.uploads.borrow();
        let mut all = self.collection.fmus.iter().chain(&uploads.accepted);
        match all.find(|known| known.name == name) {
            Some(known) => Ok(known.clone()),
            None if uploads.waiting.iter().any(|(other, _)| other == name) => {
                bail!("{} is native code that the user has not allowed to run", shortened(name))
            }
            None => bail!("no FMU {:?}", shortened(name)),
        }
    }
}

impl Fmus for FmuHome {
    fn description(&self, fmu: &str) -> Result<Arc<Description>> {
        Ok(self.known(fmu)?.description.clone())
    }

    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>> {
        Ok(self.known(fmu)?.table.clone())
    }

    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>> {
        let known = self.known(fmu)?;
        let starter = &self.collection.starter;
        Ok(match &known.source {
            Source::Linked(block, _) => (block.instantiate)(name)?,
            Source::Apart(path) => Box::new(child::instantiate(starter, path, name)?),
            Source::Uploaded(file) => Box::new(child::instantiate(starter, file.path(), name)?),
        })
    }
}

impl Home for FmuHome {
    fn entries(&self) -> Vec<Entry> {
        self.collection.fmus.iter().chain(&self.uploads.borrow().accepted).map(|known| known.entry()).collect()
    }

    fn known_loops(&self) -> Vec<KnownLoop> {
        self.collection.loops.clone()
    }

    fn blocks(&self) -> Vec<Arc<BlockType>> {
        self.collection.blocks.clone()
    }

    fn preset(&self, of: &Loop) -> Result<Vec<u8>> {
        let block = &of.block.name;
        let is_of_block = |known: &&Arc<Known>| known.table.as_ref().is_some_and(|table| table.name == *block);
        let known = self.collection.fmus.iter().find(is_of_block).map(|known| &known.source);
        let Some(Source::Linked(_, path) | Source::Apart(path)) = known else {
            bail!("no FMU for {block}: start plcfmu tool with its file, or with --fmus FOLDER")
        };
        let preset = Original::open(path).and_then(|mut original| original.preset(of));
        Ok(preset.with_context(|| path.display().to_string())?.bytes)
    }
}
