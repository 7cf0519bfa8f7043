//! Joins FMUs that were packed from the same sources for different platforms.

use crate::package::check;
use anyhow::{Context, Result, bail, ensure};
use host::package::{DESCRIPTION, Package};
use modeldescription::shortened;
use modeldescription::{Description, ModelDescription, Variable};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};

/// The files of an FMU, by path.
pub type Files = BTreeMap<String, Vec<u8>>;

/// The maximum size of a file in an FMU, in bytes.
const LARGEST_FILE: u64 = 1 << 28;

/// FMI 2.0 has no folder for Linux on ARM. Tools on that platform look in one of these two, so an ARM-only FMU has its
/// library in both.
const ARM: &str = "aarch64-linux";
const STAND_IN: &str = "linux64";

/// Reads all files of an FMU.
///
/// # Errors
/// The FMU is faulty: a file is damaged, or a library does not match the model description.
pub fn files<R: Read + Seek>(package: &mut Package<R>) -> Result<Files> {
    let report = check::check(package);
    ensure!(report.errors.is_empty(), report.errors.join("; "));
    let names: Vec<String> = package.archive.entries().iter().map(|entry| entry.name.clone()).collect();
    let mut files = Files::new();
    for name in names.into_iter().filter(|name| !name.ends_with('/')) {
        let content = package.archive.read(&name, LARGEST_FILE)?;
        files.insert(name, content);
    }
    Ok(files)
}

/// Joins the files of two FMUs with the same model description: the libraries of both, and the other files, which must
/// be identical.
///
/// # Errors
/// The FMUs do not match; the error describes the first difference.
pub fn join(mut first: Files, mut second: Files) -> Result<Files> {
    if first.get(DESCRIPTION) != second.get(DESCRIPTION) {
        let text = |files: &Files| files.get(DESCRIPTION).cloned().unwrap_or_default();
        bail!("their model descriptions differ: {}", difference(&text(&first), &text(&second)));
    }
    remove_stand_in(&mut first);
    remove_stand_in(&mut second);
    let common: Vec<String> = platforms(&first).intersection(&platforms(&second)).cloned().collect();
    for platform in common {
        let folder = format!("binaries/{platform}/");
        let own = |files: &Files| -> Files {
            let own = files.iter().filter(|(name, _)| name.starts_with(&folder));
            own.map(|(name, content)| (name.clone(), content.clone())).collect()
        };
        ensure!(own(&first) == own(&second), "both have libraries for {platform}, but from different builds");
    }
    for (name, content) in second {
        match first.get(&name) {
            Some(own) => ensure!(*own == content, "{name} differs: the FMUs are from different builds"),
            None => {
                first.insert(name, content);
            }
        }
    }
    add_stand_in(&mut first);
    Ok(first)
}

/// Copies the libraries of an ARM-only Linux FMU to the folder of 64-bit Linux too, if its FMI version has no folder
/// for Linux on ARM.
pub fn add_stand_in(files: &mut Files) {
    if platforms(files) == BTreeSet::from([ARM.to_string()]) && !has_folder_for_arm(files) {
        let from = format!("binaries/{ARM}/");
        let added: Vec<_> = files
            .iter()
            .filter_map(|(name, content)| Some((name.strip_prefix(&from)?, content)))
            .map(|(name, content)| (format!("binaries/{STAND_IN}/{name}"), content.clone()))
            .collect();
        files.extend(added);
    }
}

/// Whether the FMI version has a folder for Linux on ARM.
fn has_folder_for_arm(files: &Files) -> bool {
    let xml = files.get(DESCRIPTION).map(|xml| ModelDescription::read(xml));
    matches!(xml, Some(Ok(ModelDescription::V3(_))))
}

/// Undoes [`add_stand_in`].
pub fn remove_stand_in(files: &mut Files) {
    let arm = format!("binaries/{ARM}/");
    let stand_in = format!("binaries/{STAND_IN}/");
    let is_stand_in = |name: &String| {
        let original = name.strip_prefix(&stand_in).map(|name| format!("{arm}{name}"));
        original.is_some_and(|original| files.get(&original) == files.get(name))
    };
    let names: Vec<String> = files.keys().filter(|name| is_stand_in(name)).cloned().collect();
    for name in names {
        files.remove(&name);
    }
}

/// The files of an FMU with the libraries for only one platform, or `None` if it has no library for that platform.
pub fn only(files: &Files, platform: &str) -> Option<Files> {
    let folder = format!("binaries/{platform}/");
    let is_kept = |name: &String| !name.starts_with("binaries/") || name.starts_with(&folder);
    let mut kept: Files =
        files.iter().filter(|(name, _)| is_kept(name)).map(|(name, content)| (name.clone(), content.clone())).collect();
    let has_library = kept.keys().any(|name| name.starts_with(&folder));
    add_stand_in(&mut kept);
    has_library.then_some(kept)
}

/// FMI's names of the platforms for which there are libraries among the files.
pub fn platforms(files: &Files) -> BTreeSet<String> {
    let folders = files.keys().filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'));
    folders.map(|(platform, _)| platform.to_string()).collect()
}

/// The first difference between two model descriptions, in words.
fn difference(first: &[u8], second: &[u8]) -> String {
    let described = || -> Result<Option<String>> {
        let read = |xml| Ok::<_, modeldescription::Error>(ModelDescription::read(xml)?.description());
        Ok(difference_of(&read(first)?, &read(second)?))
    };
    described().ok().flatten().unwrap_or_else(|| line_difference(first, second))
}

fn difference_of(first: &Description, second: &Description) -> Option<String> {
    let quoted = |text: &str| format!("{:?}", shortened(text));
    let differ = |what: &str, a: &str, b: &str| (a != b).then(|| format!("{what} is {} vs. {}", quoted(a), quoted(b)));
    let identifier = |description: &Description| description.model_identifier().unwrap_or_default().to_string();
    let license = |description: &Description| description.license.clone().unwrap_or_default();
    differ("the model's name", &first.model_name, &second.model_name)
        .or_else(|| differ("the model identifier", &identifier(first), &identifier(second)))
        .or_else(|| {
            let mut pairs = first.variables.iter().zip(&second.variables);
            let (own, other) = pairs.find(|(own, other)| own != other)?;
            Some(if own.name == other.name {
                format!("variable {} differs in its {}", quoted(&own.name), attribute(own, other))
            } else {
                format!("where one has the variable {}, the other has {}", quoted(&own.name), quoted(&other.name))
            })
        })
        .or_else(|| {
            let (a, b) = (first.variables.len(), second.variables.len());
            (a != b).then(|| format!("they have {a} and {b} variables"))
        })
        .or_else(|| differ("the GUID", &first.guid, &second.guid))
        .or_else(|| differ("the license", &license(first), &license(second)))
}

/// The attribute in which two variables of the same name differ.
fn attribute(own: &Variable, other: &Variable) -> &'static str {
    let value = |of: &Variable| (of.unit.clone(), of.display_unit.clone(), of.min, of.max, of.start);
    let equal = [
        ("description", own.description == other.description),
        ("causality", own.causality == other.causality),
        ("variability", own.variability == other.variability),
        ("value reference", own.value_reference == other.value_reference),
        ("type", own.type_name == other.type_name),
        ("unit, range or start value", value(own) == value(other) && own.start_text == other.start_text),
    ];
    equal.into_iter().find(|(_, is_equal)| !is_equal).map_or("initial attribute", |(attribute, _)| attribute)
}

fn line_difference(first: &[u8], second: &[u8]) -> String {
    let (first, second) = (String::from_utf8_lossy(first), String::from_utf8_lossy(second));
    let equal = first.lines().zip(second.lines()).take_while(|(own, other)| own == other).count();
    let line = |text: &str| shortened(text.lines().nth(equal).unwrap_or_default().trim()).to_string();
    format!("line {} is {:?} vs. {:?}", equal + 1, line(&first), line(&second))
}

/// Joins FMUs. Each is given with its name, which is only used in messages.
///
/// # Errors
/// An FMU does not match the first; the error states which one, and the difference.
pub fn join_all(packages: Vec<(String, Files)>) -> Result<Files> {
    let mut packages = packages.into_iter();
    let (first_name, mut joined) = packages.next().context("no FMU specified")?;
    for (name, files) in packages {
        joined = join(joined, files).with_context(|| format!("{first_name} and {name} cannot be merged"))?;
    }
    Ok(joined)
}

#[cfg(test)]
mod tests {
    use super::*;
    use host::package::archive;
    use modeldescription::v2::{CoSimulation, ModelDescription, Real, Typed, Variable, write};

    fn description(change: impl FnOnce(&mut ModelDescription)) -> ModelDescription {
        let co_simulation = CoSimulation { model_identifier: "PUMP".into(), ..CoSimulation::default() };
        let mut description = ModelDescription {
            model_name: "PUMP".into(),
            guid: "{1}".into(),
            co_simulation: Some(co_simulation),
            ..ModelDescription::default()
        };
        change(&mut description);
        description
    }

    /// An FMU with these libraries: platform and content.
    fn fmu(libraries: &[(&str, &[u8])]) -> Files {
        let mut files = Files::from([
            (DESCRIPTION.to_string(), write(&description(|_| ()))),
            ("documentation/index.html".to_string(), b"pumps".to_vec()),
        ]);
        for (platform, content) in libraries {
            files.insert(format!("binaries/{platform}/PUMP.so"), content.to_vec());
        }
        files
    }

    fn refusal(first: Files, second: Files) -> String {
        join(first, second).unwrap_err().to_string()
    }

    #[test]
    fn a_merged_fmu_has_the_libraries_of_both_and_its_bytes_do_not_depend_on_the_order() {
        let (first, second) = (fmu(&[("linux64", b"1")]), fmu(&[("darwin64", b"2"), ("win64", b"3")]));
        let joined = join(first.clone(), second.clone()).unwrap();
        assert_eq!(joined, fmu(&[("darwin64", b"2"), ("linux64", b"1"), ("win64", b"3")]));
        assert_eq!(archive::write(&joined).unwrap(), archive::write(&join(second, first).unwrap()).unwrap());
    }

    #[test]
    fn a_library_that_both_have_must_be_the_same() {
        let both = fmu(&[("linux64", b"1"), ("win64", b"3")]);
        assert_eq!(join(fmu(&[("linux64", b"1")]), both.clone()).unwrap(), both);
        assert_eq!(
            refusal(fmu(&[("linux64", b"2")]), both),
            "both have libraries for linux64, but from different builds"
        );
    }

    #[test]
    fn another_file_that_differs_is_named() {
        let mut other = fmu(&[("win64", b"3")]);
        other.insert("documentation/index.html".into(), b"fans".to_vec());
        assert_eq!(
            refusal(fmu(&[("linux64", b"1")]), other),
            "documentation/index.html differs: the FMUs are from different builds"
        );
    }

    #[test]
    fn the_first_difference_of_two_model_descriptions_is_told_in_words() {
        let of = |change: &dyn Fn(&mut ModelDescription)| {
            let mut files = fmu(&[("win64", b"3")]);
            files.insert(DESCRIPTION.into(), write(&description(change)));
            refusal(fmu(&[("linux64", b"1")]), files)
        };
        let name = |name: &str| {
            let typed = Typed::Real(Real::default());
            Variable { name: name.into(), typed, ..Variable::default() }
        };
        for (message, told) in [
            (of(&|other| other.guid = "{2}".into()), "the GUID is \"{1}\" vs. \"{2}\""),
            (of(&|other| other.model_name = "FAN".into()), "the model's name is \"PUMP\" vs. \"FAN\""),
            (of(&|other| other.model_variables.push(name("Q"))), "they have 0 and 1 variables"),
        ] {
            assert_eq!(message, format!("their model descriptions differ: {told}"));
        }
        // Other differences are reported by line.
        let error = of(&|other| other.author = Some("x".into()));
        assert!(error.starts_with("their model descriptions differ: line "), "{error}");
    }

    #[test]
    fn a_variable_that_differs_is_named_with_its_attribute() {
        let pump = |change: &dyn Fn(&mut Real)| {
            let mut real = Real::default();
            change(&mut real);
            let variable = Variable { name: "Q".into(), typed: Typed::Real(real), ..Variable::default() };
            description(|description| description.model_variables = vec![variable])
        };
        let other = pump(&|real| real.start = Some(1.0));
        assert_eq!(
            difference_of(&pump(&|_| ()).description(), &other.description()),
            Some("variable \"Q\" differs in its unit, range or start value".into())
        );
        let mut text = pump(&|_| ());
        text.model_variables[0].description = Some("Flow".into());
        assert_eq!(
            difference_of(&pump(&|_| ()).description(), &text.description()),
            Some("variable \"Q\" differs in its description".into())
        );
        text.model_variables[0].name = "P".into();
        assert_eq!(
            difference_of(&pump(&|_| ()).description(), &text.description()),
            Some("where one has the variable \"Q\", the other has \"P\"".into())
        );
    }

    #[test]
    fn an_fmu_for_arm_alone_has_both_folders_until_there_is_a_library_for_linux64() {
        let mut arm = fmu(&[("aarch64-linux", b"4")]);
        add_stand_in(&mut arm);
        assert_eq!(arm, fmu(&[("aarch64-linux", b"4"), ("linux64", b"4")]));
        let all = fmu(&[("aarch64-linux", b"4"), ("linux64", b"1")]);
        assert_eq!(join(arm.clone(), fmu(&[("linux64", b"1")])).unwrap(), all);
        assert_eq!(join(fmu(&[("linux64", b"1")]), arm.clone()).unwrap(), all);
        assert_eq!(join(arm.clone(), arm.clone()).unwrap(), arm);
        assert_eq!(only(&all, "aarch64-linux"), Some(arm));
        assert_eq!(only(&all, "win64"), None);
    }
}
