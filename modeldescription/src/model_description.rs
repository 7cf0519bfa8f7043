//! A modelDescription.xml, in the version of FMI in which it is written.

use crate::description::{DefaultExperiment, Description};
use crate::error::Error;
pub use crate::findings::{Findings, MOST_FINDINGS};
use crate::interface::Interface;
use crate::{v2, v3};
use blocks::Value;
use blocks::table::number::number;

/// The versions of FMI that are supported, as `fmiVersion` states them.
pub const VERSIONS: &[&str] = &[v2::FMI_VERSION, v3::FMI_VERSION];

type Read = fn(&[u8]) -> Result<ModelDescription, Error>;

/// The parsers for [`VERSIONS`], in the same order.
const READ: [Read; VERSIONS.len()] =
    [|bytes| v2::read(bytes).map(ModelDescription::from), |bytes| v3::read(bytes).map(ModelDescription::from)];

/// A modelDescription.xml, for writing and checking the file itself; its contents are available as a [`Description`].
#[derive(Clone, Debug, PartialEq)]
pub enum ModelDescription {
    /// A file of FMI 2.0.
    V2(Box<v2::ModelDescription>),
    /// A file of FMI 3.0.
    V3(Box<v3::ModelDescription>),
}

/// The parts of a preset that replace those of the original.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preset {
    /// The model's name.
    pub model_name: String,
    /// The GUID.
    pub guid: String,
    /// The indices of variables (one for each element of an array), with their start values.
    pub starts: Vec<(usize, Value)>,
    /// The proposed simulation.
    pub default_experiment: Option<DefaultExperiment>,
}

impl ModelDescription {
    /// Creates the model description of the FMU with this library.
    ///
    /// # Errors
    /// The table has an entry that a model description forbids: an unknown unit, a start value out of range, a
    /// duplicate name.
    pub fn from_interface(interface: &Interface) -> Result<ModelDescription, Error> {
        match interface.version.as_str() {
            v3::FMI_VERSION => v3::ModelDescription::from_interface(interface).map(ModelDescription::from),
            _ => v2::ModelDescription::from_interface(interface).map(ModelDescription::from),
        }
    }

    /// Reads a modelDescription.xml, made by any tool.
    ///
    /// # Errors
    /// As [`v2::read`].
    pub fn read(bytes: &[u8]) -> Result<ModelDescription, Error> {
        READ[crate::xml::read::version(bytes, VERSIONS)?](bytes)
    }

    /// Writes the file. The same model description always yields the same bytes.
    pub fn write(&self) -> Vec<u8> {
        match self {
            ModelDescription::V2(own) => v2::write(own),
            ModelDescription::V3(own) => v3::write(own),
        }
    }

    /// The description of the FMU that it contains.
    pub fn description(&self) -> Description {
        match self {
            ModelDescription::V2(own) => own.description(),
            ModelDescription::V3(own) => own.description(),
        }
    }

    /// All mistakes that a schema does not detect, one sentence each. In a preset, the model's name differs from that
    /// of the library.
    pub fn check(&self, is_preset: bool) -> Findings {
        match self {
            ModelDescription::V2(own) if is_preset => {
                let mut own = own.clone();
                own.model_name = own.model_identifier().unwrap_or_default().to_string();
                v2::check(&own)
            }
            ModelDescription::V3(own) if is_preset => {
                let mut own = own.clone();
                own.model_name = own.model_identifier().unwrap_or_default().to_string();
                v3::check(&own)
            }
            ModelDescription::V2(own) => v2::check(own),
            ModelDescription::V3(own) => v3::check(own),
        }
    }

    /// Sets the licence.
    pub fn with_license(mut self, license: Option<String>) -> ModelDescription {
        match &mut self {
            ModelDescription::V2(own) => own.license = license,
            ModelDescription::V3(own) => own.license = license,
        }
        self
    }

    /// Adds source files, to be placed in the FMU's folder `sources`.
    pub fn with_sources(mut self, names: &[String]) -> ModelDescription {
        // FMI 3.0 lists them in a separate file.
        if let ModelDescription::V2(own) = &mut self
            && let Some(co_simulation) = &mut own.co_simulation
        {
            co_simulation.source_files = names.iter().map(|name| v2::SourceFile { name: name.clone() }).collect();
        }
        self
    }

    /// The source files in the FMU's folder `sources`.
    pub fn sources(&self) -> Vec<&str> {
        let ModelDescription::V2(own) = self else { return Vec::new() };
        let exchange = own.model_exchange.iter().flat_map(|own| &own.source_files);
        let files = own.co_simulation.iter().flat_map(|own| &own.source_files).chain(exchange);
        files.map(|file| file.name.as_str()).collect()
    }

    /// The model description of a preset, without source files. Declared ranges are widened to include the start
    /// values: FMI requires that, whereas the blocks accept any value.
    ///
    /// # Panics
    /// A start value refers to an unknown variable.
    pub fn with(&self, preset: Preset) -> ModelDescription {
        match self {
            ModelDescription::V2(own) => {
                let mut own = own.clone();
                own.model_name = preset.model_name;
                own.guid = preset.guid;
                own.default_experiment = preset.default_experiment;
                for (place, start) in preset.starts {
                    own.set_start(place, number(start));
                }
                // They contain the block's own start values.
                ModelDescription::V2(own).with_sources(&[])
            }
            ModelDescription::V3(own) => {
                let mut own = own.clone();
                own.model_name = preset.model_name;
                own.instantiation_token = preset.guid;
                own.default_experiment = preset.default_experiment;
                own.set_starts(preset.starts);
                ModelDescription::V3(own)
            }
        }
    }
}

impl From<v2::ModelDescription> for ModelDescription {
    fn from(own: v2::ModelDescription) -> ModelDescription {
        ModelDescription::V2(Box::new(own))
    }
}

impl From<v3::ModelDescription> for ModelDescription {
    fn from(own: v3::ModelDescription) -> ModelDescription {
        ModelDescription::V3(Box::new(own))
    }
}
