//! Runs FMU code that a command needs once, in a separate process: a crash or an endless loop becomes an error message.

use crate::package::check;
use anyhow::{Result, bail};
use host::child::{End, Prints, Starter, serve};
use host::fmu::{Fmu, has_table};
use host::machine::Failure;
use host::package::Package;
use modeldescription::Interface;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The role of the process.
pub const ROLE: &str = "apart";

/// The task of the process.
#[derive(Deserialize, Serialize)]
enum Request {
    /// [`check::run()`]
    Run(PathBuf),
    /// Return the library's description of its block, as JSON.
    Interface(PathBuf),
}

/// [`check::run()`] in a separate process.
///
/// # Errors
/// As for [`check::run()`]; if the FMU ended the process, how, with its messages and output.
pub fn run(starter: &Starter, path: &Path) -> Result<()> {
    ask(starter, &Request::Run(path.into())).map(drop)
}

/// The block's description in the library of the FMU at `path`. A library without a table is not loaded.
///
/// # Errors
/// It has no table, cannot be loaded here, or ends its process.
pub fn interface(starter: &Starter, path: &Path) -> Result<Interface> {
    if !has_table(&mut Package::open(path)?)? {
        bail!(
            "it was not made by plcfmu: the PLC types of its variables are unknown; `plcfmu info` shows its start values"
        );
    }
    Ok(Interface::parse(&ask(starter, &Request::Interface(path.into()))?)?)
}

fn ask(starter: &Starter, request: &Request) -> Result<String> {
    let mut process = starter.start(ROLE, Prints::Kept)?;
    process.send(request);
    match process.receive::<Result<String, Failure>>(|_| false) {
        Ok(reply) => reply.map_err(Failure::into_error),
        Err(End::Interrupted) => bail!("interrupted"),
        Err(End::Ended(what)) => bail!("the FMU {what}{}", process.last_words(None)),
    }
}

/// The child process: answers one request.
///
/// # Errors
/// The parent process has ended.
pub fn child(folder: &Path) -> Result<()> {
    serve(folder, |channel| {
        let Some(request) = channel.next::<Request>()? else { return Ok(()) };
        channel.tell_messages();
        let done = match request {
            Request::Run(path) => {
                Package::open(&path).and_then(|mut package| check::run(&mut package, folder)).map(|()| String::new())
            }
            Request::Interface(path) => Package::open(&path)
                .and_then(|mut package| Fmu::load(&mut package, folder))
                .and_then(|fmu| fmu.library.interface()),
        };
        channel.send(&done.map_err(Failure::from))
    })
}
