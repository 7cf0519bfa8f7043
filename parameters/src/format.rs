//! The formats of parameter files.

use crate::block::BlockType;
use crate::loops::Loop;
use crate::problem::{Problem, Problems};
use crate::reading::{Options, Reading};
use crate::source::Source;
use crate::{dump, json, openness, ssv, step7};
use std::sync::Arc;

/// A format of parameter files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// STEP 7 source text (`.awl`, `.scl`), generated or written by hand.
    Step7,
    /// TIA Portal external source (`.db`).
    Tia,
    /// TIA Openness XML of an instance data block (`.xml`).
    Openness,
    /// The bytes of a data block (`.bin`, `.dump`).
    Dump,
    /// JSON: an object per loop (`.json`).
    Json,
    /// An SSP parameter set (`.ssv`).
    Ssv,
}

/// The static properties of a format.
struct About {
    name: &'static str,
    extensions: &'static [&'static str],
    media_type: &'static str,
    offered: &'static [(&'static str, &'static str)],
}

impl Format {
    /// All formats.
    pub const ALL: &'static [Format] =
        &[Format::Step7, Format::Tia, Format::Openness, Format::Dump, Format::Json, Format::Ssv];

    const fn about(self) -> About {
        match self {
            Format::Step7 => About {
                name: "STEP 7 source",
                extensions: &["awl", "scl", "stl"],
                media_type: "text/plain",
                // SCL's compiler has a different syntax for TITLE and VERSION and was not available for testing;
                // untested output is not offered.
                offered: &[("awl", "STEP 7 AWL source")],
            },
            Format::Tia => About {
                name: "TIA Portal source",
                extensions: &["db"],
                media_type: "text/plain",
                offered: &[("db", "TIA Portal data block source")],
            },
            Format::Openness => About {
                name: "TIA Openness XML",
                extensions: &["xml"],
                media_type: "application/xml",
                offered: &[("xml", "TIA Portal XML")],
            },
            Format::Dump => About {
                name: "data block dump",
                extensions: &["bin", "dump"],
                media_type: "application/octet-stream",
                offered: &[],
            },
            Format::Json => About {
                name: "JSON",
                extensions: &["json"],
                media_type: "application/json",
                offered: &[("json", "JSON")],
            },
            Format::Ssv => About {
                name: "SSV",
                extensions: &["ssv"],
                media_type: "application/xml",
                offered: &[("ssv", "SSP parameter values (SSV)")],
            },
        }
    }

    /// The format's name in messages.
    pub const fn name(self) -> &'static str {
        self.about().name
    }

    /// The file extensions, the most common one first.
    pub const fn extensions(self) -> &'static [&'static str] {
        self.about().extensions
    }

    /// Its media type.
    pub const fn media_type(self) -> &'static str {
        self.about().media_type
    }

    /// The file types offered for writing loops: extension and title.
    pub const fn offered(self) -> &'static [(&'static str, &'static str)] {
        self.about().offered
    }

    /// The format of a file, by its extension, ignoring case.
    pub fn of_file(name: &str) -> Option<Format> {
        let extension = name.rsplit(['/', '\\']).next()?.rsplit_once('.')?.1.to_lowercase();
        Format::ALL.iter().copied().find(|format| format.extensions().contains(&extension.as_str()))
    }
}

/// Reads the loops of a file.
///
/// # Errors
/// The problems in the file. If [`Options::is_partial`] is set, they are an error only if no loop is correct.
pub fn read(
    format: Format,
    source: &Source,
    blocks: &[Arc<BlockType>],
    options: &Options,
) -> Result<Reading, Problems> {
    let is_tree = matches!(format, Format::Openness | Format::Json | Format::Ssv);
    if is_tree && source.bytes.len() > LARGEST_TREE {
        let (length, most) = (source.bytes.len(), LARGEST_TREE >> 20);
        let message = format!("the file has {length} bytes: the limit for {} is {most} MiB", format.name());
        let problems = vec![Problem { place: None, message, help: None }];
        return Err(Problems { file: source.file.clone(), text: String::new(), problems });
    }
    match format {
        Format::Step7 | Format::Tia => step7::read(source, blocks, options),
        Format::Openness => openness::read(source, blocks, options),
        Format::Dump => dump::read(source, blocks, options),
        Format::Json => json::read(source, blocks, options),
        Format::Ssv => ssv::read(source, blocks, options),
    }
}

/// The maximum size of a JSON or XML file in bytes. It is lower than [`Source::LARGEST`] because the parsed file takes
/// more memory. Forty loops need a hundredth of it.
const LARGEST_TREE: usize = 16 << 20;

/// Writes loops as a file in this format. The file reads back to the same values, bit for bit. If the format has
/// comments, one states the `origin` of the file.
///
/// # Errors
/// The format cannot represent the loops: one sentence that states why.
pub fn write(format: Format, loops: &[Loop], origin: &str) -> Result<Vec<u8>, String> {
    match format {
        Format::Step7 => step7::write(loops, origin),
        Format::Tia => step7::write_tia(loops, origin).map(String::into_bytes),
        Format::Openness => openness::write(loops, origin).map(String::into_bytes),
        Format::Dump => dump::write(loops),
        Format::Json => json::write(loops).map(String::into_bytes),
        Format::Ssv => ssv::write(loops).map(String::into_bytes),
    }
}
