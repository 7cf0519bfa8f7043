//! Presets: FMUs of the same library with start values of their own.
//!
//! The start values are in `resources/start.txt`, and the preset's GUID is the fingerprint of that file. So the library knows by
//! the GUID that it gets whether it has the values that modelDescription.xml declares; with its own GUID it reads no file.

use crate::refusal::Refusal;
use crate::resources;
use crate::table::Guid;
use blocks::table::fingerprint;
use blocks::table::start::{self, FILE, LARGEST, Start};
use blocks::{Block, Table, Value};
use std::ffi::CStr;

/// A text that a host passes, by the name that the standard gives it; `None` stands for NULL.
#[derive(Clone, Copy, Debug)]
pub struct Argument<'a> {
    /// Its name, for messages.
    pub name: &'static str,
    /// What the host passes.
    pub value: Option<&'a CStr>,
}

/// What an instance of a preset starts from.
#[derive(Debug)]
pub struct Preset<B> {
    /// The fingerprint of the start values, whose text is the GUID.
    pub hash: u128,
    /// The block with these values.
    pub block: B,
}

impl<B: Block> Preset<B> {
    /// The preset with this GUID, whose start values are read from the folder of the resources.
    ///
    /// # Errors
    /// As [`read`].
    pub fn read(name: &str, guid: &CStr, resources: Argument) -> Result<Preset<B>, Refusal> {
        let (hash, settings) = read(name, guid, resources, B::TABLE, Guid::<B>::TEXT)?;
        let mut block = B::default();
        for (row, value) in settings {
            block.set(row, value);
        }
        Ok(Preset { hash, block })
    }
}

/// The start values of the preset with this GUID, by the rows of a table, and their fingerprint. `own` is the GUID of the FMU of
/// which it is a preset.
///
/// # Errors
/// There are no start values, or they are damaged, or those of another preset or library.
pub fn read(
    name: &str,
    guid: &CStr,
    resources: Argument,
    table: &Table,
    own: &str,
) -> Result<(u128, Vec<(usize, Value)>), Refusal> {
    let given = guid.to_string_lossy();
    let (path, bytes) = resources::read(resources, FILE, LARGEST).map_err(|why| {
        format!(
            "{name} = {given:?}: this library is {own}; take the modelDescription.xml that came with it; if the FMU is a \
             preset, its start values belong into resources/{FILE}, but {why}"
        )
    })?;
    let refused = |why: String| format!("{name} = {given:?}: {path}: {why}; unpack the FMU again");
    let text = std::str::from_utf8(&bytes).map_err(|_| refused("the start values are damaged: not UTF-8".into()))?;
    let damaged = |why: String| refused(format!("the start values are damaged: {why}"));
    let start = Start::parse(text).map_err(damaged)?;
    let Start { preset, block, library, .. } = &start;
    if library != own {
        let own_block = table.name;
        return Err(refused(format!(
            "the start values are for {block} {library}, but this library is {own_block} {own}"
        ))
        .into());
    }
    let hash = start::fingerprint(&bytes);
    if fingerprint::text(hash) != guid.to_bytes() {
        let text = fingerprint::text(hash);
        let text = String::from_utf8_lossy(&text);
        let why = format!("the start values are those of {preset:?} {text}: they were changed or replaced");
        return Err(refused(why).into());
    }
    Ok((hash, start.settings(table).map_err(damaged)?))
}
