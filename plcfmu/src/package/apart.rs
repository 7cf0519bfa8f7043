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

/// The role of the child process, a command-line argument.
pub const ROLE: &str = "apart";

/// A request to the child process.
#[derive(Deserialize, Serialize)]
enum Request {
    /// Run the FMU, see [`check::run()`].
    Run(PathBuf),
    /// Return the library's description of its block, as JSON.
    Interface(PathBuf),
}

/// Calls [`check::run()`] in a separate process.
///
/// # Errors
/// As for [`check::run()`]; if the FMU ended the process, the error states how, with the FMU's messages and output.
pub fn run(starter: &Starter, path: &Path) -> Result<()> {
    ask(starter, &Request::Run(path.into())).map(drop)
}

/// The description of the block that the library of the FMU at `path` contains. A library without a table is not
/// loaded.
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
