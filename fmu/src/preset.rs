//! Presets: FMUs of the same library with their own start values.
//!
//! The start values are in `resources/start.txt`, and the preset's GUID is the fingerprint of that file. The GUID
//! passed by the host thus lets the library check that it has the values declared in modelDescription.xml; with its own
//! GUID, it reads no file. The file contains the identifier of the FMU from which the preset was created; the preset's
//! identifier has the same form.

use crate::messages;
use crate::refusal::Refusal;
use crate::resources;
use crate::table::{Fingerprint, Guid};
use blocks::table::fingerprint;
use blocks::table::start::{self, FILE, LARGEST, Start};
use blocks::{Block, Table, TableText, Types, Value};
use std::borrow::Borrow;
use std::ffi::CStr;

/// A string passed by a host, with its argument name in the standard; `None` means NULL.
#[derive(Clone, Copy, Debug)]
pub struct Argument<'a> {
    /// The argument name, for messages.
    pub name: &'static str,
    /// The string passed by the host.
    pub value: Option<&'a CStr>,
}

/// The string by which a host identifies the FMU. It is formed from a hash, in one of several ways if the FMU comes in
/// several forms.
#[derive(Clone, Copy, Debug)]
pub struct Identity<'a> {
    /// The argument name, for messages.
    pub name: &'static str,
    /// The string passed by the host.
    pub value: Option<&'a CStr>,
    /// The forms that the host may pass.
    pub forms: &'static [Form],
}

/// A form of the string by which a host identifies an FMU.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// The hash itself.
    Guid,
    /// The instantiation token for this choice of types.
    Token(Types),
}

impl Form {
    /// The value derived from a hash.
    pub const fn derive(self, hash: u128) -> u128 {
        match self {
            Form::Guid => hash,
            Form::Token(types) => types.token(hash),
        }
    }
}

impl Identity<'_> {
    /// A single form: the hash itself.
    pub const GUID: &'static [Form] = &[Form::Guid];

    /// The form in which the host passed this hash: its index in `forms`, and the value derived from the hash. `None`
    /// if the host passed another identifier.
    pub fn form(&self, hash: u128) -> Option<(usize, u128)> {
        self.find(hash, |form| fingerprint::text(form.derive(hash)))
    }

    /// Like [`Identity::form`], for a block's own hash. Compares with strings computed at compile time, so that no hash
    /// is formatted when an instance is created.
    pub fn own_form<B: Block>(&self) -> Option<(usize, u128)> {
        self.find(Fingerprint::<B>::HASH, Guid::<B>::text)
    }

    fn find<T: Borrow<[u8; 38]>>(&self, hash: u128, text: impl Fn(Form) -> T) -> Option<(usize, u128)> {
        let given = self.value?.to_bytes();
        let (number, form) = self.forms.iter().enumerate().find(|(_, form)| text(**form).borrow() == given)?;
        Some((number, form.derive(hash)))
    }

    /// The string that a host should pass for this hash, in the first form.
    pub fn text(&self, hash: u128) -> String {
        let hash = self.forms.first().map_or(hash, |form| form.derive(hash));
        String::from_utf8_lossy(&fingerprint::text(hash)).into_owned()
    }

    /// The string passed by the host, for messages.
    pub fn shown(&self) -> String {
        self.value.map_or_else(|| "NULL".into(), |given| format!("{:?}", given.to_string_lossy()))
    }
}

/// The initial state of an instance of a preset.
#[derive(Debug)]
pub struct Preset<B> {
    /// The fingerprint of the start values, from which the identifier is derived.
    pub hash: u128,
    /// The form of the identifier, as an index into [`Identity::forms`].
    pub form: usize,
    /// The block with these values.
    pub block: B,
}

impl<B: Block> Preset<B> {
    /// Reads the preset with this identifier from the resources folder.
    ///
    /// # Errors
    /// See [`read`].
    pub fn read(identity: Identity, resources: Argument) -> Result<Preset<B>, Refusal> {
        let (form, hash, settings) = read(identity, resources, B::TABLE, Fingerprint::<B>::HASH)?;
        let mut block = B::default();
        for (row, value) in settings {
            block.set(row, value);
        }
        Ok(Preset { hash, form, block })
    }
}

/// The start values of a preset: the index of its form, the hash for its identifier, and the values by row.
pub type Settings = (usize, u128, Vec<(usize, Value)>);

/// Reads the start values of the preset with this identifier. `table` is the block's table, and `own` is the hash of
/// the original FMU.
///
/// # Errors
/// The start values are missing, damaged, or belong to another preset or library.
pub fn read<S: TableText>(
    identity: Identity,
    resources: Argument,
    table: &Table<S>,
    own: u128,
) -> Result<Settings, Refusal> {
    let (name, given) = (identity.name, identity.shown());
    let (path, bytes) = resources::read(resources, FILE, LARGEST).map_err(|why| {
        let other = messages::other_library(name, &given, &identity.text(own));
        format!("{other}; if the FMU is a preset, its start values belong in resources/{FILE}, but {why}")
    })?;
    let refused = |why: String| format!("{name} = {given}: {path}: {why}; unpack the FMU again");
    let text = std::str::from_utf8(&bytes).map_err(|_| refused("the start values are damaged: not UTF-8".into()))?;
    let damaged = |why: String| refused(format!("the start values are damaged: {why}"));
    let start = Start::parse(text).map_err(damaged)?;
    let Start { preset, block, library, .. } = &start;
    let form = identity.forms.iter().position(|form| fingerprint::text(form.derive(own)) == library.as_bytes());
    let Some(form) = form else {
        let (own_block, own) = (&table.name, identity.text(own));
        return Err(refused(format!(
            "the start values are for {block} {library}, but this library is {own_block} {own}"
        ))
        .into());
    };
    let hash = start::fingerprint(&bytes);
    let expected = fingerprint::text(hash);
    if identity.value.map(CStr::to_bytes) != Some(&expected[..]) {
        let expected = String::from_utf8_lossy(&expected);
        let why =
            format!("the start values have the identifier {expected} ({preset:?}): the file was changed or replaced");
        return Err(refused(why).into());
    }
    Ok((form, hash, start.settings(table).map_err(damaged)?))
}
