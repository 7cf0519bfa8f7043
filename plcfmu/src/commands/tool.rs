//! `plcfmu tool`: the parameter tool in the browser, with FMUs.

use super::{print, time_limit};
use crate::interruption;
use crate::program::{files_below, is_source};
use crate::tell;
use crate::tool::assets;
use crate::tool::home::{Collection, File, Known};
use crate::tool::page::{self, Content, Home};
use crate::tool::server::{self, Server};
use anyhow::{Context, Result, bail, ensure};
use askama::filters::Escaper as _;
use draw::escape::Named;
use host::child::Starter;
use host::package::temporary;
use parameters::Format;
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The maximum size of a parameter file, in bytes; its Base64 encoding must fit into a request.
const LARGEST_FILE: u64 = 40 << 20;

/// The environment variable that names the folder of the FMUs; the Python package also uses it.
const FMUS: &str = "PLCFMU_FMUS";

/// Set up, run and tune control loops in the browser
///
/// Opens loops from a parameter file or creates new ones, runs them against a plant, records, tunes and compares them,
/// and writes presets and parameter files. The page is served only to this machine, and to one browser for each printed
/// address. The native code of the FMUs is executed: use FMUs that you trust.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = HELP)]
pub struct Options {
    /// Parameter files to open (.awl, .scl, .db, .xml, .json, .ssv), the sources of a PLC program (.scl, .udt, .db) or
    /// a project folder, and FMUs of blocks
    #[arg(value_name = "FILE or FOLDER")]
    files: Vec<PathBuf>,
    /// An FMU to control, from any tool; it runs in a separate process
    #[arg(long, value_name = "FILE.fmu")]
    plant: Option<PathBuf>,
    /// The folder of the FMUs [default: PLCFMU_FMUS, those installed with plcfmu, or target/fmu]
    #[arg(long, value_name = "FOLDER")]
    fmus: Option<PathBuf>,
    /// The port on 127.0.0.1; by default, any free port
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the address without opening a browser
    #[arg(long)]
    no_browser: bool,
    /// Time limit for each call of a foreign FMU, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = time_limit)]
    time_limit: f64,
}

const HELP: &str = "\
Examples:
  plcfmu tool plant.awl
  plcfmu tool machine.scl types.udt
  plcfmu tool project
  plcfmu tool --plant BOILER.fmu plant.awl";

/// Serves the tool until it is interrupted.
///
/// # Errors
/// No block's FMU is found, a file cannot be opened, or the port is taken.
pub fn run(options: &Options) -> Result<()> {
    let limit = Duration::from_secs_f64(options.time_limit);
    // The flag is held until the end: otherwise, the first signal would end the process immediately.
    let interrupted = interruption::flag();
    let starter = Starter { limit, interrupted: interrupted.clone(), ..Starter::new()? };
    let Opened { collection, start } = open(options, starter)?;
    let server = Server::bind(options.port)?;
    let url = server.address()?;
    let door = if options.no_browser { None } else { Some(door(&server.address()?)?) };
    let page = start.put_into(&page(&collection)?, server.secret())?;
    let named = options.files.clone();
    let given = move || {
        let all = named.iter().filter(|path| !is_fmu(path)).map(|path| files(path)).collect::<Result<Vec<_>>>()?;
        Ok(all.concat())
    };
    server.run(page, collection, Box::new(given), || {
        // A closed standard output does not stop the server.
        let _ = print(&format!("{url}\n"));
        tell::raw("Press Ctrl-C to stop.\n");
        if let Some(door) = &door
            && open::that_detached(door.path()).is_err()
        {
            tell::remark("no browser could be opened: open the address above in one");
        }
    })
}

/// A file that redirects the browser to an address. Other users of this machine may see the file's name in the
/// browser's command line, but cannot read the file.
fn door(address: &str) -> Result<temporary::Document> {
    temporary::Document::new(Some(".html"), server::leading_to(address).as_bytes())
}

/// The available FMUs, and the page's initial content.
struct Opened {
    collection: Collection,
    start: Start,
}

/// The initial content of the page.
#[derive(Debug, Default)]
struct Start {
    /// Parameter files to open.
    files: Vec<File>,
    /// The FMU for which a new loop is created.
    block: Option<String>,
    /// The FMU that is the plant of every new loop.
    plant: Option<String>,
}

fn open(options: &Options, starter: Starter) -> Result<Opened> {
    let mut fmus: Vec<Known> = Vec::new();
    let (mut start, mut presets) = (Start::default(), Vec::new());
    for path in &options.files {
        let shown = || path.display().to_string();
        if !is_fmu(path) {
            start.files.extend(files(path)?);
        } else if is_preset(path).with_context(shown)? {
            presets.push(path);
        } else {
            let known = Known::open(path, Some(&starter)).with_context(shown)?;
            if !known.is_foreign() {
                start.block.get_or_insert_with(|| known.name.clone());
            }
            add(&mut fmus, known)?;
        }
    }
    if let Some(path) = &options.plant {
        let known = Known::open(path, Some(&starter)).with_context(|| path.display().to_string())?.into_plant();
        start.plant = Some(known.name.clone());
        add(&mut fmus, known)?;
    }
    let folder = folder(options.fmus.as_deref(), has_fmus);
    if let Some(folder) = &folder {
        // The code of FMUs in a default folder, which the user did not name, is not run.
        let is_named = options.fmus.is_some() || env::var_os(FMUS).is_some_and(|folder| !folder.is_empty());
        add_folder(&mut fmus, folder, is_named.then_some(&starter))?;
    }
    ensure!(
        fmus.iter().any(|known| !known.is_foreign()),
        "no FMU of a block{}: specify the folder of the FMUs with --fmus, or set {FMUS} to it",
        folder.map_or_else(String::new, |folder| format!(" in {}", folder.display()))
    );
    let collection = Collection::new(fmus, starter);
    for path in presets {
        let shown = || path.display().to_string();
        let file = collection.preset(path).with_context(shown)?;
        start.files.push(file.with_context(|| format!("{}: no FMU for its block: specify it too", path.display()))?);
    }
    Ok(Opened { collection, start })
}

fn is_fmu(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu"))
}

fn is_preset(path: &Path) -> Result<bool> {
    Ok(crate::package::preset::Original::open(path)?.is_preset)
}

fn add(fmus: &mut Vec<Known>, known: Known) -> Result<()> {
    if fmus.iter().any(|other| other.name == known.name) {
        bail!("two FMUs are named {}: rename the file of one of them", known.name);
    }
    fmus.push(known);
    Ok(())
}

/// Adds the FMUs in a folder, except presets and foreign FMUs. FMUs of the same name that were added earlier are kept.
fn add_folder(fmus: &mut Vec<Known>, folder: &Path, starter: Option<&Starter>) -> Result<()> {
    for path in paths(folder).with_context(|| folder.display().to_string())? {
        let is_named = |known: &Known| path.file_stem().is_some_and(|stem| stem.to_string_lossy() == *known.name);
        if fmus.iter().any(is_named) {
            continue;
        }
        match is_preset(&path)
            .and_then(|is_preset| if is_preset { Ok(None) } else { Known::open(&path, starter).map(Some) })
        {
            Ok(Some(known)) if known.is_foreign() => {
                tell::remark(&format!(
                    "{} is a foreign FMU: to use it, specify its file on the command line",
                    path.display()
                ));
            }
            Ok(known) => fmus.extend(known),
            Err(error) => tell::warning(&format!("{}: {error:#}", path.display())),
        }
    }
    Ok(())
}

/// The paths of the FMUs in a folder, sorted.
fn paths(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.collect::<std::io::Result<Vec<_>>>()?;
    let mut paths: Vec<_> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu")));
    paths.sort();
    Ok(paths)
}

fn has_fmus(folder: &Path) -> bool {
    paths(folder).is_ok_and(|paths| !paths.is_empty())
}

/// The FMU folder: from the option or the environment, or else the first default folder that contains FMUs.
fn folder(given: Option<&Path>, has_fmus: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    if let Some(folder) = given {
        return Some(folder.into());
    }
    if let Some(folder) = env::var_os(FMUS).filter(|folder| !folder.is_empty()) {
        return Some(folder.into());
    }
    let program = env::current_exe().and_then(fs::canonicalize).unwrap_or_default();
    let beside = program.parent().unwrap_or(Path::new("."));
    // A wheel's program is in bin (on Windows: Scripts), its package in lib/python3.x/site-packages
    // (Lib\site-packages).
    let environment = beside.parent().unwrap_or(beside);
    let versions = fs::read_dir(environment.join("lib")).into_iter().flatten().flatten();
    let mut libraries: Vec<_> = versions.map(|entry| entry.path()).collect();
    libraries.sort();
    libraries.push(environment.join("Lib"));
    let packages = libraries.into_iter().map(|library| library.join("site-packages").join("plcfmu").join("fmus"));
    let mut usual =
        [beside.join("fmus"), beside.into()].into_iter().chain(packages).chain([PathBuf::from("target/fmu")]);
    usual.find(|folder| has_fmus(folder))
}

/// The files that the page reads from a path: one file, or the program files below a folder, whose names include the
/// folder.
fn files(path: &Path) -> Result<Vec<File>> {
    if path.is_dir() {
        // A folder such as `.` gets its name from its absolute path.
        let absolute = path.canonicalize().with_context(|| path.display().to_string())?;
        let parent = absolute.parent().unwrap_or(&absolute);
        let name = |file: &Path| {
            let parts = file.strip_prefix(parent).unwrap_or(file).components();
            parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
        };
        return files_below(path)?.iter().map(|file| read(file, name(&file.canonicalize()?))).collect();
    }
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let is_known = Format::of_file(&name).is_some()
        || is_source(path)
        || path.extension().is_some_and(|extension| extension == "csv");
    ensure!(
        is_known,
        "{} is neither a parameter file, a program source, a recording (.csv), an FMU nor a folder",
        path.display()
    );
    Ok(vec![read(path, name)?])
}

/// Reads a file for the page, which knows it as `name`.
fn read(path: &Path, name: String) -> Result<File> {
    let read = || -> Result<File> {
        let size = fs::metadata(path)?.len();
        ensure!(size <= LARGEST_FILE, "the file has {size} bytes; at most {LARGEST_FILE} are accepted");
        Ok(File::new(name, &fs::read(path)?))
    };
    read().with_context(|| path.display().to_string())
}

impl Start {
    /// Returns the page with this content in its head.
    fn put_into(&self, page: &str, secret: &str) -> Result<String> {
        let files = page::packed(&serde_json::to_vec(&self.files)?, Home::Server)?;
        let mut own = format!("<script type=\"text/plain\" id=\"files\">{files}</script>\n");
        let (open, plant) = (self.block.as_deref(), self.plant.as_deref());
        for (name, content) in [("plcfmu-open", open), ("plcfmu-plant", plant), ("plcfmu-secret", Some(secret))] {
            if let Some(content) = content {
                write!(own, "<meta name=\"{name}\" content=\"")?;
                Named.write_escaped_str(&mut own, content)?;
                own.push_str("\">\n");
            }
        }
        let (head, rest) = page.split_once("</head>").context("the page has no head")?;
        Ok(format!("{head}{own}</head>{rest}"))
    }
}

/// The page without the server's additions.
fn page(collection: &Collection) -> Result<String> {
    let assets = assets::json(collection.tables())?;
    page::assemble(&page::embedded(), &Content { home: Home::Server, data: &[("assets", &assets)] })
}
