//! Bundles: a study with everything it needs, in one folder that can be moved to any machine (`study.json` and the
//! FMUs).

use super::read::Reading;
use super::{bare, fingerprint, hash, make_folder};
use crate::Job;
use anyhow::{Context, Result, bail, ensure};
use host::package::temporary;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The version of the format.
const VERSION: u32 = 3;

/// The contents of `study.json`.
#[derive(Debug, Deserialize, Serialize)]
struct Content {
    version: u32,
    /// The name of the study.
    name: String,
    /// The file name of the loop.
    #[serde(rename = "loop")]
    description: String,
    /// The folder of the FMUs as shown in the report, if one was given with `--fmus`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fmus: Option<String>,
    fingerprint: String,
    runs: u64,
    /// Whether each run needs new instances, determined for all parts when the bundle was created.
    renews: bool,
    /// The job; paths of FMUs are relative to the bundle's folder.
    job: Job,
}

/// Writes a bundle of a study with this many runs to a folder. `renews` states whether each run needs new instances.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &Path, reading: &Reading, runs: u64, renews: bool) -> Result<()> {
    let fingerprint = fingerprint(&reading.job)?;
    let mut job = bare(&reading.job);
    make_folder(&folder.join("fmus"))?;
    for member in &mut job.system.members {
        let place = PathBuf::from("fmus").join(format!("{}.fmu", hash(&member.path)?));
        let mut from = File::open(&member.path).with_context(|| member.path.display().to_string())?;
        temporary::place(&folder.join(&place), |to| Ok(io::copy(&mut from, to).map(|_| ())?), |_| Ok(()))?;
        // Use `/` on every platform.
        member.path = place.to_string_lossy().replace('\\', "/").into();
    }
    let content = Content {
        version: VERSION,
        name: reading.name.clone(),
        description: reading.description.clone(),
        fmus: reading.fmus.clone(),
        fingerprint,
        runs,
        renews,
        job,
    };
    let content = serde_json::to_vec_pretty(&content)?;
    temporary::place(&folder.join("study.json"), |to| Ok(to.write_all(&content)?), |_| Ok(()))
}

/// Opens a bundle by its `study.json`.
///
/// # Errors
/// The bundle is damaged, has changed, or was created by another version of this program.
pub fn open(path: &Path) -> Result<Reading> {
    let shown = path.display();
    let text = fs::read(path).with_context(|| format!("{shown} cannot be read"))?;
    #[derive(Deserialize)]
    struct Versioned {
        version: u32,
    }
    let again = "create the bundle again with plcfmu study STUDY.toml --bundle";
    let version: Versioned = serde_json::from_slice(&text).with_context(|| format!("{shown} is not a bundle"))?;
    ensure!(version.version == VERSION, "{shown} has the format version {}, not {VERSION}: {again}", version.version);
    let content: Content = serde_json::from_slice(&text)
        .with_context(|| format!("{shown} is damaged or was written by another version of plcfmu: {again}"))?;
    let mut job = content.job;
    for member in &mut job.system.members {
        member.path = path.with_file_name("").join(&member.path);
    }
    if fingerprint(&job)? != content.fingerprint {
        bail!("{shown} has changed since it was created, or was created by another version of plcfmu: {again}");
    }
    Ok(Reading {
        name: content.name,
        description: content.description,
        fmus: content.fmus,
        job,
        tables: Vec::new(),
        renews: Some(content.renews),
        source: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use run::system::{FilePosition, Member, Setting, System, Value};

    #[test]
    fn a_bundle_has_the_fingerprint_of_its_study_wherever_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        fs::write(&path, "an FMU").unwrap();
        let place = Some(FilePosition { file: "loop.toml".into(), line: 3, column: 1 });
        let value = Value::Number(0.1);
        let setting = Setting { variable: "A.GAIN".into(), value, time: None, is_preliminary: false, place };
        let member = |name: &str| Member { name: name.into(), path: path.clone() };
        let system = System {
            members: vec![member("A"), member("B")],
            settings: vec![setting],
            remarks: vec!["read from loop.toml".into()],
            ..System::default()
        };
        let job = Job { system, ..Job::default() };
        let bundle = folder.path().join("bundle");
        let reading = Reading {
            name: "valves".into(),
            description: "valve.toml".into(),
            fmus: Some("../fmu".into()),
            job: job.clone(),
            tables: Vec::new(),
            renews: None,
            source: None,
        };
        write(&bundle, &reading, 7, true).unwrap();
        assert_eq!(fs::read_dir(bundle.join("fmus")).unwrap().count(), 1, "an FMU is there once");
        let moved = folder.path().join("moved");
        fs::rename(&bundle, &moved).unwrap();
        let Reading { name, description, fmus, job: opened, renews, .. } = open(&moved.join("study.json")).unwrap();
        assert_eq!((name.as_str(), description.as_str(), renews), ("valves", "valve.toml", Some(true)));
        assert_eq!(fmus.as_deref(), Some("../fmu"));
        assert_eq!(fingerprint(&opened).unwrap(), fingerprint(&job).unwrap());
        assert_eq!(fs::read(&opened.system.members[1].path).unwrap(), b"an FMU");

        fs::write(&path, "another FMU").unwrap();
        assert_ne!(fingerprint(&opened).unwrap(), fingerprint(&job).unwrap());
        fs::write(&opened.system.members[0].path, "another FMU").unwrap();
        let error = open(&moved.join("study.json")).unwrap_err().to_string();
        assert!(error.contains("has changed since it was created"), "{error}");
    }
}
