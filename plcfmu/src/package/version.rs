//! The FMI version, types and names of a packed FMU.

use crate::build::platform;
use crate::package::merge::{self, Files};
use crate::package::terminals;
use anyhow::{Result, ensure};
use blocks::{Class, Kind, Types};
use draw::{diagram, picture};
use fmu::sources::Door;
use modeldescription::v3::{
    BUILD_DESCRIPTION, BuildConfiguration, BuildDescription, PreprocessorDefinition, SourceFile, SourceFileSet,
};
use modeldescription::{Interface, Names, Row, Table};

/// How the single C file of an FMU is compiled. The optional definition omits the function prefix, for a shared
/// library; a host that links several FMUs statically leaves this definition out.
fn build_description(name: &str, file: &str) -> BuildDescription {
    let prefix = PreprocessorDefinition {
        name: "FMI3_OVERRIDE_FUNCTION_PREFIX".into(),
        optional: true,
        value: Some(String::new()),
        description: Some("No prefix, for a shared library".into()),
        ..PreprocessorDefinition::default()
    };
    let files = SourceFileSet {
        language: Some("C99".into()),
        source_files: vec![SourceFile { name: file.into() }],
        preprocessor_definitions: vec![prefix],
        ..SourceFileSet::default()
    };
    let configuration = BuildConfiguration {
        model_identifier: name.into(),
        source_file_sets: vec![files],
        ..BuildConfiguration::default()
    };
    BuildDescription { configurations: vec![configuration] }
}

/// A version of FMI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Fmi {
    /// FMI 2.0
    #[default]
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

/// The version of FMI, the types and the names.
#[derive(clap::Args, Clone, Copy, Debug, Default, PartialEq)]
#[group(skip)] // clap names a group after its type, and another type has the same name
pub struct Version {
    /// FMI version: 2.0, which every tool reads, or 3.0, with PLC types, arrays and Event Mode
    #[arg(long, value_name = "VERSION", value_enum, default_value = "2", hide_possible_values = true)]
    pub fmi: Fmi,
    /// Types of an FMI 3.0 FMU: native, the PLC's types; or wide, for tools that mishandle them: Float64 for REAL and
    /// TIME, Int32 for integers up to 32 bits, and a variable for each array element [default: native]
    #[arg(long, value_name = "TYPES", value_parser = types)]
    pub types: Option<Types>,
    /// Names of variables: structured, as in the PLC, such as par.level; or flat, such as par_level, for tools that
    /// turn structured names into buses or reject them
    #[arg(id = "naming", long = "names", value_name = "NAMES", value_parser = names, default_value = "structured")]
    pub names: Names,
}

/// Parses an argument that chooses types.
fn types(argument: &str) -> Result<Types, String> {
    Types::named(argument).ok_or_else(|| "expected native or wide".to_string())
}

/// Parses an argument that chooses names.
fn names(argument: &str) -> Result<Names, String> {
    match argument {
        "structured" => Ok(Names::Structured),
        "flat" => Ok(Names::Flat),
        _ => Err("expected structured or flat".into()),
    }
}

impl Version {
    /// Rejects a choice of types for FMI 2.0.
    ///
    /// # Errors
    /// Types are specified for FMI 2.0.
    pub fn check(self) -> Result<()> {
        ensure!(
            self.fmi == Fmi::Three || self.types.is_none(),
            "--types is for FMI 3.0: FMI 2.0 offers no choice; add --fmi 3"
        );
        Ok(())
    }

    /// A library's self-description, adapted to an FMU of this version.
    pub fn adapt(self, interface: &Interface) -> Interface {
        let version = match self.fmi {
            Fmi::Two => interface.version.clone(),
            Fmi::Three => modeldescription::v3::FMI_VERSION.into(),
        };
        Interface { version, types: self.types.unwrap_or(Types::Native), names: self.names, ..interface.clone() }
    }

    /// The FMI functions in C (the door) for FMUs of this version.
    pub fn door(self) -> &'static Door {
        let types = (self.fmi == Fmi::Three).then(|| self.types.unwrap_or(Types::Native));
        fmu::door(types)
    }

    /// The files in the folder `sources`: the C source of an FMU and, for FMI 3.0, the build description.
    pub fn sources(self, name: &str, text: String) -> Files {
        let file = format!("{name}.c");
        let mut files = Files::from([(format!("sources/{file}"), text.into_bytes())]);
        if self.fmi == Fmi::Three {
            files.insert(BUILD_DESCRIPTION.into(), build_description(name, &file).write());
        }
        files
    }

    /// The model's picture and, for FMI 3.0, its terminals.
    ///
    /// # Errors
    /// The block's documentation is faulty.
    pub fn pictures(self, table: &Table) -> Result<Files> {
        match self.fmi {
            Fmi::Two => Ok(Files::from([("model.png".into(), picture::png(&diagram::icon::svg(table)?)?)])),
            Fmi::Three => terminals::files(table, self.types.unwrap_or(Types::Native), self.names),
        }
    }

    /// Moves the files of an FMI 2.0 FMU to their paths in this version.
    pub fn placed(self, mut files: Files) -> Files {
        match self.fmi {
            Fmi::Two => merge::add_stand_in(&mut files),
            Fmi::Three => {
                let libraries: Vec<String> =
                    files.keys().filter(|path| path.starts_with("binaries/")).cloned().collect();
                for path in libraries {
                    let Some(content) = files.remove(&path) else { continue };
                    let Some((folder, name)) = path["binaries/".len()..].split_once('/') else { continue };
                    for folder in platform::newer(folder) {
                        files.insert(format!("binaries/{folder}/{name}"), content.clone());
                    }
                }
            }
        }
        files
    }

    /// Converts a row's value, recorded through FMI 2.0, to this version's type: in native types, a TIME counts
    /// milliseconds, an LTIME nanoseconds, and words are unsigned.
    pub fn value(self, row: &Row, value: f64) -> f64 {
        let native = self.fmi == Fmi::Three && self.types != Some(Types::Wide);
        match row.kind {
            Kind::Word if native && !row.is_analog => f64::from(value as i64 as u16),
            Kind::Time if native => (value * 1e3).round(),
            Kind::LTime if native => (value * 1e9).round(),
            Kind::DWord if native => f64::from(value as i64 as u32),
            _ => value,
        }
    }

    /// Whether this version represents a PLC type as an integer or a Boolean.
    pub fn is_whole(self, kind: Kind) -> bool {
        match self.fmi {
            Fmi::Two => kind.class() != Class::Real,
            Fmi::Three => !self.types.unwrap_or(Types::Native).host_type(kind, false).starts_with("Float"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NATIVE: Version = Version { fmi: Fmi::Three, types: None, names: Names::Structured };

    #[test]
    fn libraries_have_the_folders_of_the_version() {
        let files = || {
            let paths = ["linux64/A.so", "win64/A.dll", "darwin64/A.dylib", "aarch64-linux/A.so", "linux32/A.so"];
            let libraries = paths.iter().map(|path| (format!("binaries/{path}"), path.as_bytes().to_vec()));
            libraries.collect::<Files>()
        };
        assert_eq!(Version::default().placed(files()), files());
        let placed = NATIVE.placed(files());
        let names: Vec<&str> = placed.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            [
                "binaries/aarch64-darwin/A.dylib",
                "binaries/aarch64-linux/A.so",
                "binaries/x86-linux/A.so",
                "binaries/x86_64-darwin/A.dylib",
                "binaries/x86_64-linux/A.so",
                "binaries/x86_64-windows/A.dll"
            ]
        );
    }

    #[test]
    fn recorded_values_are_those_of_the_types() {
        let wide = Version { types: Some(Types::Wide), ..NATIVE };
        let row = |kind| Row::new("X", blocks::Role::Output, blocks::Value::zero(kind));
        let of = |version: Version| {
            [Kind::Time, Kind::DWord, Kind::Word, Kind::Int].map(|kind| version.value(&row(kind), -1.0))
        };
        assert_eq!(
            [of(Version::default()), of(NATIVE), of(wide)],
            [[-1.0; 4], [-1000.0, 4_294_967_295.0, 65535.0, -1.0], [-1.0; 4]]
        );
        let whole = |version: Version| [Kind::Time, Kind::Real, Kind::LInt].map(|kind| version.is_whole(kind));
        assert_eq!(
            [whole(Version::default()), whole(NATIVE), whole(wide)],
            [[false; 3], [true, false, true], [false, false, true]]
        );
    }

    #[test]
    fn types_without_the_version_that_has_them_are_refused() {
        let error = Version { types: Some(Types::Wide), ..Version::default() }.check().unwrap_err().to_string();
        assert_eq!(error, "--types is for FMI 3.0: FMI 2.0 offers no choice; add --fmi 3");
        assert!(NATIVE.check().is_ok() && types("double").is_err() && names("dotted").is_err());
    }
}
