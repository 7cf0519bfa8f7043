//! Presets: FMUs with a block's library but other start values. Here, a preset consists only of the files in which it
//! differs from the block's FMU.
//!
//! The caller packs the archive: the command, or the page's JavaScript, because the WebAssembly has no space for ZIP
//! code.

pub mod page;

use crate::describe::as_loop;
use crate::home::Home;
use crate::message::Loop;
use anyhow::{Context, Result, anyhow, bail, ensure};
use blocks::table::fingerprint;
use blocks::table::number::{beyond_number, number, to_value};
use blocks::table::start::{self, Start};
use blocks::{Row, Types, Value};
use modeldescription::v3::token;
use modeldescription::{self, Causality, Description, ModelDescription, Variable, shortened};
use parameters::BlockType;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The path of the model description in an FMU.
pub const DESCRIPTION: &str = "modelDescription.xml";

/// The path of the documentation in an FMU.
pub const PAGE: &str = "documentation/index.html";

/// The files that a preset leaves out: the recorded results belong to the block's own start values, and so does the C
/// source. A folder ends with `/`.
const LEFT_OUT: [&str; 3] = ["extra/org.fmi-standard.fmi-ls-ref/", "documentation/fmi-ls-ref.txt", "sources/"];

/// Device names in Windows, which cannot be file names, whatever the extension.
const DEVICES: [&str; 4] = ["CON", "PRN", "AUX", "NUL"];

/// The path of the start values in a preset.
pub fn path() -> String {
    format!("resources/{}", start::FILE)
}

/// The GUID of a preset; `text` is its file of start values.
pub fn guid_of(text: &str) -> String {
    String::from_utf8_lossy(&fingerprint::text(start::fingerprint(text.as_bytes()))).into_owned()
}

/// The FMU from which a preset is created, without its archive.
#[derive(Clone, Copy, Debug)]
pub struct Original<'a> {
    /// Its model description.
    pub xml: &'a ModelDescription,
    /// Its model description, expanded.
    pub description: &'a Description,
    /// The GUID or token of the block's own FMU. It differs from this FMU's if this FMU is itself a preset.
    pub library: &'a str,
    /// Its documentation, if it has one.
    pub page: Option<&'a str>,
}

/// The files of a preset that replace the original's.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Preset {
    /// Its name, which is an identifier.
    pub name: String,
    /// Its GUID.
    pub guid: String,
    /// The new and the changed files, by path.
    pub files: BTreeMap<String, String>,
    /// The paths of the omitted files. A folder ends with `/`.
    pub left_out: Vec<String>,
    /// Remarks for the user, a sentence each.
    pub remarks: Vec<String>,
}

impl Original<'_> {
    /// Creates a preset whose start values are the values of a loop.
    ///
    /// # Errors
    /// The FMU is not for the loop's block, or rejects a value.
    pub fn preset(&self, values: &parameters::Loop) -> Result<Preset> {
        let block = self.description.model_identifier().unwrap_or_default();
        let places = self.places(block, &values.block)?;
        let name = identifier(&values.name);
        let members = &values.block.members;
        let setting = |setting: &parameters::MemberValue| {
            let name = &members[setting.member].name;
            let number = number(setting.value);
            let more = beyond_number(setting.value);
            ensure!(more.is_none(), "{name} = {}: {}", start::text(setting.value), setting.value.kind().takes());
            to_value(number, setting.value.kind()).map_err(|why| anyhow!("{name} = {number:?}: {why}"))?;
            Ok((name.clone(), start::text(setting.value)))
        };
        let start = Start {
            preset: name.clone(),
            block: block.into(),
            library: self.library.into(),
            values: values.settings.iter().map(setting).collect::<Result<_>>()?,
        };
        let text = start.to_string();
        let guid = guid_of(&text);
        let description = self.xml.with(self.changes(&name, &guid, values, &places)?).write();
        let description = String::from_utf8(description).context(DESCRIPTION)?;
        let mut files = BTreeMap::from([(DESCRIPTION.to_string(), description), (path(), text)]);
        if let Some(page) = self.page {
            let page = page.replace(&self.description.guid, &guid);
            files.insert(PAGE.into(), page::html(&page, &name, self.library, values).context(PAGE)?);
        }
        let left_out = LEFT_OUT.map(String::from).into();
        Ok(Preset { name, guid, files, left_out, remarks: values.warnings() })
    }

    /// The positions of a block's members among the FMU's variables. Fails if the block is not this FMU's.
    fn places(&self, own: &str, block: &BlockType) -> Result<Vec<usize>> {
        ensure!(block.name == own, "it is an FMU for {own}, not for {}", block.name);
        let variables = &self.description.variables;
        let other = "it was built from another version of the block";
        // The variable for time does not belong to the block, and presets have no strings.
        let is_own = |of: &&Variable| of.kind.is_some() && of.causality != Causality::Independent;
        let count = variables.iter().filter(is_own).count();
        ensure!(count == block.members.len(), "{other}: it has {count} variables");
        let rows = block.members.iter().map(|member| (member.name.as_str(), (member.kind, member.role)));
        let places = self.description.places(rows).into_iter().zip(&block.members);
        let place = |(place, member): (Option<usize>, &Row)| {
            let (name, kind) = (&member.name, member.kind.name());
            let place = place.with_context(|| format!("{other}: the block has {name} ({kind})"))?;
            let variable = &variables[place];
            let own = variable.type_name;
            ensure!(variable.is_of(member.kind), "{other}: where the block has {name} ({kind}), it has a {own}");
            Ok(place)
        };
        places.map(place).collect()
    }

    /// The parts of the model description that differ from the original.
    fn changes(
        &self,
        name: &str,
        guid: &str,
        values: &parameters::Loop,
        places: &[usize],
    ) -> Result<modeldescription::Preset> {
        let mut default_experiment = self.description.default_experiment;
        let cycle =
            values.settings.iter().find(|setting| values.block.members[setting.member].role == blocks::Role::Cycle);
        if let (Some(Value::Time(cycle)), Some(experiment)) =
            (cycle.map(|setting| setting.value), &mut default_experiment)
        {
            let cycle = f64::from(cycle.milliseconds());
            ensure!(cycle >= 1.0, "the time between two calls is {} s: it must be at least 0.001 s", cycle / 1000.0);
            // Keep the number of calls.
            if let (Some(stop), Some(step)) = (experiment.stop_time, experiment.step_size) {
                experiment.stop_time = Some((stop / step).round() * cycle / 1000.0);
            }
            experiment.step_size = Some(cycle / 1000.0);
        }
        let starts = values.settings.iter().map(|setting| (places[setting.member], setting.value)).collect();
        Ok(modeldescription::Preset { model_name: name.into(), guid: guid.into(), starts, default_experiment })
    }
}

/// Converts a name to an identifier that is valid in C and as a file name on any system: ASCII letters, digits and
/// underscores.
pub fn identifier(name: &str) -> String {
    let mut identifier: String =
        name.chars().map(|character| if character.is_ascii_alphanumeric() { character } else { '_' }).collect();
    if identifier.starts_with(|first: char| first.is_ascii_digit()) || identifier.is_empty() {
        identifier.insert(0, '_');
    }
    let upper = identifier.to_uppercase();
    let is_port = |port: &str| upper.strip_prefix(port).is_some_and(|rest| matches!(rest.as_bytes(), [b'0'..=b'9']));
    if DEVICES.contains(&upper.as_str()) || is_port("COM") || is_port("LPT") {
        identifier.push('_');
    }
    identifier
}

/// A request for a preset of an FMU opened by the page.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PresetRequest {
    /// The loop with its values.
    pub of: Loop,
    /// The FMU's `modelDescription.xml`, `documentation/index.html` and `resources/start.txt`, where they exist.
    pub files: BTreeMap<String, String>,
}

/// Creates the preset.
///
/// # Errors
/// The files do not belong to an FMU for the loop's block in the version known to the home, or the FMU rejects a value.
pub fn make(home: &dyn Home, request: &PresetRequest) -> Result<Preset> {
    let values = as_loop(home, &request.of)?;
    let file = |path: &str| request.files.get(path).map(String::as_str);
    let text = file(DESCRIPTION).with_context(|| format!("it is not an FMU: it has no {DESCRIPTION}"))?;
    let xml = ModelDescription::read(text.as_bytes()).context(DESCRIPTION)?;
    let description = xml.description().expanded();
    let path = path();
    let start = file(&path).map(Start::parse).transpose().map_err(|error| anyhow!("{path}: {error}"))?;
    let library = start.map_or_else(|| description.guid.clone(), |start| start.library);
    let original = Original { xml: &xml, description: &description, library: &library, page: file(PAGE) };
    let preset = original.preset(&values)?;
    // A library of another version would reject or misinterpret the start values.
    let name = &values.block.name;
    let own = home.entries().into_iter().map(|entry| entry.name).find_map(|fmu| {
        let is_of_block = home.table(&fmu).ok().flatten().is_some_and(|table| table.name == *name);
        is_of_block.then(|| home.description(&fmu).ok()).flatten()
    });
    let is_of = |own: &Description| {
        let mut tokens = Types::ALL.iter().map(|types| token(&own.guid, *types));
        own.guid == library || description.is_fmi_3() && tokens.any(|token| token == library)
    };
    match own {
        Some(own) if !is_of(&own) => bail!(
            "this {name}.fmu has the GUID {}, but the {name} in the page has {}: use an FMU and a page from the \
             same release",
            shortened(&library),
            own.guid
        ),
        _ => Ok(preset),
    }
}

#[cfg(test)]
mod tests;
