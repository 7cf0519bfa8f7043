//! The contents of `sources/buildDescription.xml` of FMI 3.0: how the sources of an FMU are compiled.

use super::SCHEMA;
use super::description::FMI_VERSION;
use crate::error::Error;
use crate::xml::attributes::*;
use crate::xml::read::{Attribute, Document, Limits, Schema, Tag, read_root};
use crate::xml::write::Xml;

/// Its path in an FMU.
pub const BUILD_DESCRIPTION: &str = "sources/buildDescription.xml";

elements! {
    /// A build description: the element `fmiBuildDescription`.
    BuildDescription "fmiBuildDescription" with "fmiVersion" = FMI_VERSION {
    }, children {
        /// The ways to compile the FMU, for example one for each platform.
        configurations: Vec<BuildConfiguration>;
    }

    /// `BuildConfiguration`: a way to compile the FMU.
    BuildConfiguration "BuildConfiguration" {
        /// The name of the library.
        model_identifier "modelIdentifier": String;
        /// The platform, if it is for one alone.
        platform "platform": Option<String>;
        /// A short description.
        description "description": Option<String>;
    }, children {
        /// The files to compile.
        source_file_sets: Vec<SourceFileSet>;
        /// The libraries to link.
        libraries: Vec<Library>;
    }

    /// `SourceFileSet`: files that are compiled alike.
    SourceFileSet "SourceFileSet" {
        /// Its name.
        name "name": Option<String>;
        /// The programming language.
        language "language": Option<String>;
        /// The compiler.
        compiler "compiler": Option<String>;
        /// The compiler's options.
        compiler_options "compilerOptions": Option<String>;
    }, children {
        /// The files.
        source_files: Vec<SourceFile>;
        /// The macros to define.
        preprocessor_definitions: Vec<PreprocessorDefinition>;
        /// Where to look for headers.
        include_directories: Vec<IncludeDirectory>;
    }

    /// `SourceFile`: a file in `sources`.
    SourceFile "SourceFile" {
        /// Its path there.
        name "name": String;
    }

    /// `PreprocessorDefinition`: a macro.
    PreprocessorDefinition "PreprocessorDefinition" {
        /// Its name.
        name "name": String;
        /// Whether it may be left out.
        optional "optional": bool = false, omitted;
        /// Its value.
        value "value": Option<String>;
        /// A short description.
        description "description": Option<String>;
    }, children {
        /// The values that it may have.
        options: Vec<PreprocessorOption>;
    }

    /// `Option`: a value of a macro.
    PreprocessorOption "Option" {
        /// The value.
        value "value": Option<String>;
        /// A short description.
        description "description": Option<String>;
    }

    /// `IncludeDirectory`: a folder with headers.
    IncludeDirectory "IncludeDirectory" {
        /// Its path in `sources`.
        name "name": String;
    }

    /// `Library`: a library to link.
    Library "Library" {
        /// Its name.
        name "name": String;
        /// Its version.
        version "version": Option<String>;
        /// Whether it is not in the FMU.
        external "external": bool = false, omitted;
        /// A short description.
        description "description": Option<String>;
    }
}

impl BuildDescription {
    /// Reads a build description, made by any tool. Annotations are skipped.
    ///
    /// # Errors
    /// The file is malformed or has no build configuration: one sentence with the line.
    pub fn read(bytes: &[u8]) -> Result<BuildDescription, Error> {
        let root = ("fmiBuildDescription", "build description");
        read_root(bytes, Limits::default(), Schema { root, ..SCHEMA }, |own: &BuildDescription| {
            own.configurations.is_empty().then(|| (None, missing("BuildConfiguration")))
        })
    }

    /// Writes it. The same description always yields the same bytes.
    pub fn write(&self) -> Vec<u8> {
        crate::xml::write::write(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOREIGN: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="A" platform="x86_64-linux" description="d">
    <SourceFileSet name="n" language="C99" compiler="gcc" compilerOptions="-O2">
      <SourceFile name="a.c"/>
      <SourceFile name="b/c.c"/>
      <PreprocessorDefinition name="DEBUG" optional="true" value="1" description="d">
        <Option value="0" description="off"/>
        <Annotations><Annotation type="x">any</Annotation></Annotations>
      </PreprocessorDefinition>
      <IncludeDirectory name="include"/>
    </SourceFileSet>
    <Library name="hdf5" version="&gt;=1.8" external="true" description="d"/>
  </BuildConfiguration>
</fmiBuildDescription>
"#;

    #[test]
    fn a_build_description_of_another_tool_is_read_and_written() {
        let description = BuildDescription::read(FOREIGN.as_bytes()).unwrap();
        let [configuration] = &description.configurations[..] else { panic!("{description:?}") };
        assert_eq!(configuration.model_identifier, "A");
        let [set] = &configuration.source_file_sets[..] else { panic!("{configuration:?}") };
        let files: Vec<&str> = set.source_files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(files, ["a.c", "b/c.c"]);
        let written = String::from_utf8(description.write()).unwrap();
        assert_eq!(
            written,
            FOREIGN.replace("        <Annotations><Annotation type=\"x\">any</Annotation></Annotations>\n", "")
        );
    }

    #[test]
    fn a_damaged_one_is_refused_with_the_line() {
        for (from, to, words) in [
            ("</BuildConfiguration>", "", "line 15: this is not XML"),
            (
                "fmiBuildDescription",
                "fmiModelDescription",
                "line 2: fmiModelDescription: this is not a build description",
            ),
            ("modelIdentifier=\"A\"", "", "line 3: BuildConfiguration: attribute modelIdentifier is missing"),
            ("<SourceFile name=\"a.c\"/>", "<SourceFile/>", "line 5: SourceFile: attribute name is missing"),
            ("fmiVersion=\"3.0\"", "fmiVersion=\"2.0\"", "only FMI 3.0 is supported"),
        ] {
            let error = BuildDescription::read(FOREIGN.replace(from, to).as_bytes()).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        let empty = b"<fmiBuildDescription fmiVersion=\"3.0\"/>";
        assert_eq!(
            BuildDescription::read(empty).unwrap_err().to_string(),
            "element BuildConfiguration is missing: add it"
        );
    }
}
