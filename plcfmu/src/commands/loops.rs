//! The loops of parameter files, the input of `plcfmu params` and `plcfmu preset`.

use crate::exit::Wrong;
use crate::parameter_file;
use crate::tell;
use anyhow::{Context, Error, Result, bail, ensure};
use host::fmu::has_table;
use host::package::Package;
use parameters::{BlockType, Format, Loop, Options, Problems, Reading};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files to read, and details that they do not specify.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Arguments {
    /// Parameter files, folders with such files, or the address of a data block in a PLC; - is standard input
    ///
    /// STEP 7 sources (.awl, .scl), TIA Portal sources (.db), TIA Openness XML (.xml), dumps of data blocks (.bin),
    /// JSON, SSV, and FMUs, whose start values are read. s7://HOST/RACK/SLOT/DBn reads a data block of an S7, such as
    /// s7://192.168.0.1/0/2/DB41, with --block. In a folder, files with parameters are read, except dumps and FMUs.
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<String>,
    /// FMUs, or folders with FMUs
    ///
    /// A file may contain the blocks of these FMUs, including your own blocks, whose libraries are loaded in a separate
    /// process.
    #[arg(long, value_name = "FOLDER|FILE.fmu")]
    pub fmus: Vec<PathBuf>,
    /// The block of the loops, if the file does not specify it: its name, or a number such as FB 41
    #[arg(long)]
    pub block: Option<String>,
    /// The loop to select, or the name of a loop that the file leaves unnamed; may be repeated
    #[arg(long = "loop", value_name = "NAME")]
    pub names: Vec<String>,
    /// The offset of the instance in a dump or a PLC's data block, in bytes
    #[arg(long, value_name = "BYTES", allow_negative_numbers = true)]
    pub offset: Option<usize>,
    /// The format of the files, if their extensions do not identify it: awl, scl, db, xml, bin, json, ssv
    #[arg(long, value_parser = format)]
    pub format: Option<Format>,
    /// The encoding of text files, such as windows-1251, if not UTF-8, UTF-16 or windows-1252
    #[arg(long)]
    pub encoding: Option<String>,
}

/// The format of files with this extension, given without the dot.
fn format(extension: &str) -> Result<Format, String> {
    Format::of_file(&format!(".{extension}")).ok_or_else(|| {
        let extensions: Vec<&str> = Format::ALL.iter().flat_map(|format| format.extensions()).copied().collect();
        format!("available: {}", extensions.join(", "))
    })
}

/// The loops that could be read, and why others could not.
#[derive(Debug, Default)]
pub struct Found {
    /// The valid loops.
    pub loops: Vec<Loop>,
    /// Why other loops, or whole files, could not be read.
    pub errors: Vec<Error>,
}

impl Found {
    /// Reports the problems of loops that could not be read.
    ///
    /// # Errors
    /// A loop could not be read; the last error is returned, not printed.
    pub fn finish(mut self) -> Result<()> {
        let Some(last) = self.errors.pop() else { return Ok(()) };
        for error in self.errors {
            tell::error(&error);
        }
        Err(last)
    }
}

impl Arguments {
    /// The blocks that files may contain: the known blocks, and those of the FMUs given with --fmus.
    ///
    /// # Errors
    /// An FMU cannot be read, or its library, which is loaded in a separate process, does not contain a table.
    pub fn blocks(&self) -> Result<Vec<Arc<BlockType>>> {
        let mut blocks = BlockType::all();
        for path in fmus(&self.fmus)? {
            let shown = || path.display().to_string();
            let mut package = Package::open(&path).with_context(shown)?;
            let is_known = blocks.iter().any(|block| parameter_file::is_of(&package.description, block));
            let is_named = self.fmus.contains(&path);
            // A folder may contain FMUs that have nothing to do with parameter files.
            if !is_known && (is_named || has_table(&mut package).unwrap_or(false)) {
                blocks.push(Arc::new(parameter_file::block_of_library(&path).with_context(shown)?));
            }
        }
        Ok(blocks)
    }

    /// The loops with one of the given names in all files, or all loops if no name is given. Prints remarks on the
    /// files.
    ///
    /// # Errors
    /// No loop has one of the given names, or an option does not suit the files.
    pub fn read(&self, blocks: &[Arc<BlockType>]) -> Result<Found> {
        let mut found = Found::default();
        for file in &self.files {
            if Path::new(file).is_dir() {
                self.read_folder(Path::new(file), blocks, &mut found)?;
            } else {
                self.read_into(file, blocks, &mut found)?;
            }
        }
        let is_called = |one: &Loop, name: &String| one.name.eq_ignore_ascii_case(name);
        let missing = self.names.iter().find(|name| !found.loops.iter().any(|one| is_called(one, name)));
        if let (Some(missing), true) = (missing, found.errors.is_empty()) {
            let all: Vec<&str> = found.loops.iter().map(|one| one.name.as_str()).collect();
            bail!("no loop {missing} in {}; available: {}", self.files.join(", "), all.join(", "));
        }
        found.loops.retain(|one| self.names.is_empty() || self.names.iter().any(|name| is_called(one, name)));
        Ok(found)
    }

    fn read_into(&self, file: &str, blocks: &[Arc<BlockType>], found: &mut Found) -> Result<()> {
        let format = self.format.or_else(|| Format::of_file(file));
        let is_bytes = format == Some(Format::Dump) || parameter_file::is_plc(file);
        ensure!(
            self.offset.unwrap_or_default() == 0 || is_bytes,
            "--offset applies only to dumps and data blocks of a PLC; {file} is neither"
        );
        let options = Options {
            block: self.block.clone(),
            name: match self.names.as_slice() {
                [name] => Some(name.clone()),
                _ => None,
            },
            offset: self.offset.unwrap_or_default(),
            is_partial: true,
        };
        match parameter_file::read(file, self.format, self.encoding.as_deref(), blocks, &options) {
            Ok(reading) => found.add(reading),
            Err(error) => found.errors.push(error),
        }
        Ok(())
    }

    /// Reads the files of a folder in name order, skipping files without loops.
    fn read_folder(&self, folder: &Path, blocks: &[Arc<BlockType>], found: &mut Found) -> Result<()> {
        let before = (found.loops.len(), found.errors.len());
        for path in entries(folder)? {
            let file = path.display().to_string();
            if !matches!(Format::of_file(&file), None | Some(Format::Dump)) && path.is_file() {
                self.read_into(&file, blocks, found)?;
                let is_empty = |wrong: &Wrong| wrong.0.problems.iter().all(|problem| problem.place.is_none());
                if let Some(wrong) =
                    found.errors.last().and_then(|error| error.downcast_ref::<Wrong>()).filter(|of| is_empty(of))
                {
                    tell::remark(&format!("{} (skipped)", wrong.to_string().lines().next().unwrap_or_default()));
                    found.errors.pop();
                }
            }
        }
        ensure!(before != (found.loops.len(), found.errors.len()), "{} has no parameter files", folder.display());
        Ok(())
    }
}

impl Found {
    fn add(&mut self, reading: Reading) {
        for remark in run::file::remarks(&reading) {
            tell::remark(&remark);
        }
        self.loops.extend(reading.loops);
        let Problems { problems, .. } = &reading.wrong;
        if !problems.is_empty() {
            self.errors.push(Error::new(Wrong(reading.wrong)));
        }
    }
}

/// The named FMUs, and those in the named folders.
///
/// # Errors
/// A folder cannot be read, or has no FMU.
pub fn fmus(named: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut fmus = Vec::new();
    for path in named {
        if !path.is_dir() {
            fmus.push(path.clone());
            continue;
        }
        let mut paths = entries(path)?;
        paths.retain(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu")));
        ensure!(!paths.is_empty(), "{} has no FMUs", path.display());
        fmus.extend(paths);
    }
    Ok(fmus)
}

/// The paths of a folder's entries, sorted by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let mut paths: Vec<PathBuf> =
        entries.with_context(|| folder.display().to_string())?.into_iter().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}
