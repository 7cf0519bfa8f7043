//! A study as a hand-written TOML file, such as `study.toml`: the variations between the runs, and what is computed
//! from each run.
//!
//! ```toml
//! loop = "furnace.toml"                   # a description as for `plcfmu run`, relative to this file
//! samples = 1000
//! seed = 1
//!
//! [[axes]]
//! variable = "FURNACE.TM_LAG"
//! relative = true
//! normal = { mean = 1.0, deviation = 0.2, min = 0.5 }
//!
//! [[limits]]
//! variable = "FURNACE.TEMP"
//! max = 90.0
//! ```

use crate::table::{self, Rows};
use crate::tune::Tune;
use crate::{Along, Axis, Correlation, Job, Limit, Sampling, Signals, Study, Taken, Window};
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use parameters::Source;
use run::file::{self, Entries, Event, Node, ReadParameters, Reader, plain};
use run::subject::Subject;
use run::system::{FilePosition, Setting, System, Value};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::path::{Component, Path, PathBuf};
use toml::{Spanned, Table};

/// The permitted number of samples.
const SAMPLES: std::ops::RangeInclusive<u64> = 1..=1_000_000_000;

/// The ways to specify an axis' values, for messages.
const KINDS: &str = "values = [...], range, uniform, normal, log_normal or triangular";

/// The contents of a study.toml.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The name of the study: its file name without extension.
    pub name: String,
    /// The file name of the loop.
    pub description: String,
    /// The job to run.
    pub job: Job,
    /// The folder of the FMUs, relative to the folder of the file, if one was given with `--fmus`.
    pub fmus: Option<String>,
    /// The axes whose rows were read from a file, by index.
    pub tables: Vec<(usize, Rows)>,
    /// Whether each run needs new instances; known only for a bundle.
    pub renews: Option<bool>,
    /// The file, for the locations of errors; `None` for a bundle.
    pub source: Option<Source>,
}

impl Reading {
    /// Prefixes an error with the location of its subject in the file, or with the file's name if the location is
    /// unknown.
    pub fn located(&self, error: Error, path: &Path) -> Error {
        let Some(source) = &self.source else { return error.context(path.display().to_string()) };
        located(source, &self.tables, error)
    }

    /// The study's table `[tune]`, for `plcfmu tune-study`.
    ///
    /// # Errors
    /// The study has no such table, or a faulty one; the message has the location.
    pub fn tune(&self) -> Result<Tune> {
        #[derive(Deserialize)]
        struct Content {
            tune: Option<Tune>,
        }
        let content = self.source.as_ref().map(file::content::<Content>).transpose();
        let tune = content.map_err(|error| Subject::Outside.attach(error))?.and_then(|content| content.tune);
        tune.context(
            "the study has no [tune] table: add one with minimize = \"iae\" and a [[tune.search]] table for each \
             setting",
        )
    }
}

fn located(source: &Source, tables: &[(usize, Rows)], mut error: Error) -> Error {
    let mut keys = match Subject::find(&error) {
        Some(Subject::Outside) => return error,
        Some(Subject::Part(keys)) => keys.clone(),
        None => Vec::new(),
    };
    // Any problem with an axis read from a file is a problem with the contents of that file.
    let is_of = |(axis, _): &&(usize, Rows)| keys.starts_with(&["axes".into(), (*axis).into()]);
    if let Some((_, rows)) = tables.iter().find(is_of) {
        keys.splice(2.., ["file".into()]);
        error = error.context(rows.path.display().to_string());
    }
    // A subject that the file does not contain is in the loop.
    let place = file::find(source, &keys).or_else(|| file::find(source, &["loop".into()]));
    error.context(place.map_or_else(|| source.file.clone(), |place| place.to_string()))
}

/// The grammar of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    #[serde(rename = "loop")]
    description: Option<Spanned<String>>,
    start: Option<Spanned<Node>>,
    stop: Option<Spanned<Node>>,
    step: Option<Spanned<Node>>,
    #[serde(default)]
    settings: Entries<Spanned<Node>>,
    #[serde(default)]
    events: Vec<Event>,
    samples: Option<Spanned<u64>>,
    #[serde(default)]
    seed: u64,
    sampling: Option<Spanned<Sampling>>,
    #[serde(default)]
    axes: Vec<Spanned<AxisOf>>,
    #[serde(default)]
    correlations: Vec<Spanned<CorrelationOf>>,
    signals: Option<Spanned<Signals>>,
    window: Option<Spanned<Window>>,
    #[serde(default)]
    values: Vec<Spanned<Taken>>,
    #[serde(default)]
    limits: Vec<Spanned<Limit>>,
    main: Option<Spanned<String>>,
    /// For [`Reading::tune`].
    #[serde(rename = "tune")]
    _tune: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CorrelationOf {
    variables: Spanned<Vec<String>>,
    rank: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisOf {
    variable: Option<String>,
    variables: Option<Vec<String>>,
    time: Option<Spanned<Node>>,
    #[serde(default)]
    relative: bool,
    #[serde(default)]
    whole: bool,
    group: Option<String>,
    file: Option<Spanned<String>>,
    fmu: Option<String>,
    values: Option<Spanned<Node>>,
    range: Option<Spanned<Table>>,
    uniform: Option<Spanned<Table>>,
    normal: Option<Spanned<Table>>,
    log_normal: Option<Spanned<Table>>,
    triangular: Option<Spanned<Table>>,
}

impl AxisOf {
    /// The keys that specify its values by a table, with these tables.
    fn tables(&self) -> Vec<(&'static str, &Spanned<Table>)> {
        let tables = [
            ("range", &self.range),
            ("uniform", &self.uniform),
            ("normal", &self.normal),
            ("log_normal", &self.log_normal),
            ("triangular", &self.triangular),
        ];
        tables.into_iter().filter_map(|(name, table)| Some((name, table.as_ref()?))).collect()
    }
}

/// Reads a study from a file. The path of the loop is relative to the folder of the file; the paths of FMUs are
/// resolved as in [`file::read`].
///
/// # Errors
/// The file is faulty; the message contains file, line and column.
pub fn read(path: &Path, fmus: Option<&Path>, parameters: ReadParameters) -> Result<Reading> {
    let reader = Reader::open(path, fmus, parameters)?;
    let content: Content = reader.content()?;
    let seconds = |node: &Option<Spanned<Node>>| node.as_ref().map(|node| reader.seconds(node)).transpose();
    let mut system = description(&reader, path, fmus, content.description.as_ref())?;
    system.start = seconds(&content.start)?.or(system.start);
    system.stop = seconds(&content.stop)?.or(system.stop);
    system.step = seconds(&content.step)?.or(system.step);
    system.sources.push(path.to_path_buf());
    let settings = reader.all_settings(&content.settings, &content.events)?;
    for of in &settings {
        let is_fmu = system.members.iter().any(|member| member.name == of.variable);
        let place = of.place.as_ref().filter(|_| is_fmu);
        ensure!(
            place.is_none(),
            "{}: {name} is an FMU: set one of its variables, {name}.VARIABLE = VALUE",
            place.map_or_else(String::new, FilePosition::to_string),
            name = of.variable
        );
    }
    replace(&mut system.settings, settings);
    if let Some(samples) = &content.samples {
        let (least, most) = (SAMPLES.start(), SAMPLES.end());
        let place = reader.place(samples.span());
        ensure!(SAMPLES.contains(samples.get_ref()), "{place}: samples must be between {least} and {most}");
    }
    let fixed: Vec<String> = reader.all_settings(&content.settings, &[])?.into_iter().map(|of| of.variable).collect();
    let mut tables = Vec::new();
    let mut axes = Vec::new();
    for (number, axis) in content.axes.iter().enumerate() {
        let Some(file) = &axis.get_ref().file else {
            axes.push(self::axis(&reader, axis)?);
            continue;
        };
        let rows = of_file(&reader, path, axis.get_ref(), file, (&system, &fixed))?;
        system.sources.push(path.with_file_name(file.get_ref()));
        system.remarks.extend(rows.remarks.iter().cloned());
        axes.push(rows.axis.clone());
        tables.push((number, rows));
    }
    let correlations = content.correlations.iter().map(|of| correlation(&reader, of.get_ref()));
    let correlations = correlations.collect::<Result<_>>()?;
    let study = Study {
        axes,
        correlations,
        samples: content.samples.map_or(Study::default().samples, Spanned::into_inner),
        seed: content.seed,
        sampling: content.sampling.map(Spanned::into_inner).unwrap_or_default(),
        signals: content.signals.map(Spanned::into_inner).unwrap_or_default(),
        window: content.window.map(Spanned::into_inner).unwrap_or_default(),
        values: content.values.into_iter().map(Spanned::into_inner).collect(),
        limits: content.limits.into_iter().map(Spanned::into_inner).collect(),
        main: content.main.map(Spanned::into_inner),
    };
    // Check before the numbers are written as JSON, which has no NaN.
    study.check().map_err(|error| located(reader.source(), &tables, error))?;
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let description = content.description.map(Spanned::into_inner).unwrap_or_default();
    let description = description.rsplit(['/', '\\']).next().unwrap_or_default().to_string();
    let fmus = fmus.map(|fmus| relative(fmus, path.parent().unwrap_or(Path::new(""))));
    let source = Some(reader.source().clone());
    Ok(Reading { name, description, fmus, job: Job { system, study }, tables, renews: None, source })
}

/// A path relative to a folder, so that the result is the same on each machine with the same relative layout. The path
/// is unchanged if it or the folder does not exist, or if they have no common parent.
fn relative(path: &Path, folder: &Path) -> String {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let from_folder = || {
        let (path, folder) = (path.canonicalize().ok()?, folder.canonicalize().ok()?);
        let common = path.components().zip(folder.components()).take_while(|(one, other)| one == other).count();
        let up = folder.components().skip(common).map(|_| Component::ParentDir);
        let found: PathBuf = up.chain(path.components().skip(common)).collect();
        (common > 0).then(|| if found.as_os_str().is_empty() { PathBuf::from(".") } else { found })
    };
    // Use `/` on every platform.
    from_folder().unwrap_or_else(|| path.to_path_buf()).display().to_string().replace('\\', "/")
}

/// Reads the loop of a study.
fn description(reader: &Reader, path: &Path, fmus: Option<&Path>, file: Option<&Spanned<String>>) -> Result<System> {
    let shown = path.display();
    let file = file.with_context(|| {
        let place = reader.place(0..0);
        format!("{place}: the study has no loop: write loop = \"FILE.toml\", a loop description as for plcfmu run")
    })?;
    let place = reader.place(file.span());
    let path = path.with_file_name(file.get_ref());
    ensure!(
        path.is_file(),
        "{place}: no file {}: write the path of the loop's description, relative to {shown}",
        path.display()
    );
    file::read(&path, fmus, reader.parameters())
}

fn correlation(reader: &Reader, of: &CorrelationOf) -> Result<Correlation> {
    let variables = of.variables.get_ref();
    let Ok(pair) = <[String; 2]>::try_from(variables.clone()) else {
        let (place, count) = (reader.place(of.variables.span()), variables.len());
        bail!(
            "{place}: a correlation relates two variables, but `variables` has {count}: add a [[correlations]] table \
             for each pair"
        )
    };
    Ok(Correlation { variables: pair, rank: of.rank })
}

/// Adds settings, which replace existing ones of the same variable and time unless these are from a parameter file.
fn replace(settings: &mut Vec<Setting>, by: Vec<Setting>) {
    let is_replaced = |of: &Setting| {
        by.iter().any(|other| !of.is_preliminary && of.variable == other.variable && of.time == other.time)
    };
    settings.retain(|of| !is_replaced(of));
    settings.extend(by);
}

fn axis(reader: &Reader, axis: &Spanned<AxisOf>) -> Result<Axis> {
    let place = reader.place(axis.span());
    let axis = axis.get_ref();
    let variables = match (&axis.variable, &axis.variables) {
        (Some(variable), None) => vec![variable.clone()],
        (None, Some(variables)) if !variables.is_empty() => variables.clone(),
        (Some(_), Some(_)) => bail!("{place}: an axis has either `variable` or `variables`: remove one of them"),
        _ => bail!("{place}: the axis has no variable: write variable = \"FMU.VARIABLE\""),
    };
    let along = match (&axis.values, axis.tables().as_slice()) {
        (Some(values), []) => self::values(reader, values, variables.len())?,
        (None, [(name, table)]) => {
            let one = Table::from_iter([((*name).to_string(), toml::Value::Table(table.get_ref().clone()))]);
            Along::deserialize(toml::Value::Table(one))
                .map_err(|error| anyhow!("{}: {name}: {}", reader.place(table.span()), plain(&error.to_string())))?
        }
        (None, []) => bail!("{place}: the axis of {} has no values: write one of {KINDS}", variables.join(", ")),
        (values, tables) => {
            let names = values.iter().map(|_| "values").chain(tables.iter().map(|(name, _)| *name));
            let names: Vec<_> = names.collect();
            bail!(
                "{place}: the axis of {} has {}: an axis can have only one kind of values; add another [[axes]] for \
                 the other",
                variables.join(", "),
                names.join(" and ")
            )
        }
    };
    let time = axis.time.as_ref().map(|node| reader.seconds(node)).transpose()?;
    let (whole, group) = (axis.whole, axis.group.clone());
    Ok(Axis { variables, time, relative: axis.relative, whole, group, names: Vec::new(), along })
}

/// An axis whose rows are read from a file.
fn of_file(
    reader: &Reader,
    path: &Path,
    axis: &AxisOf,
    file: &Spanned<String>,
    (system, fixed): (&System, &[String]),
) -> Result<Rows> {
    let place = reader.place(file.span());
    let has_values = axis.values.is_some() || !axis.tables().is_empty();
    ensure!(
        axis.variable.is_none() && axis.variables.is_none() && !has_values && !axis.whole,
        "{place}: the file specifies the variables and their values: omit the keys for these"
    );
    let rows =
        table::read(&path.with_file_name(file.get_ref()), axis.fmu.as_deref(), system, fixed, reader.parameters());
    let mut rows = rows.with_context(|| place.to_string())?;
    rows.axis.time = axis.time.as_ref().map(|node| reader.seconds(node)).transpose()?;
    (rows.axis.relative, rows.axis.group) = (axis.relative, axis.group.clone());
    Ok(rows)
}

/// A list of values, or of rows with a value for each variable.
fn values(reader: &Reader, node: &Spanned<Node>, width: usize) -> Result<Along> {
    let expected = "a list of values or, for several variables, of rows [VALUE, ...]";
    let Node::List(list) = node.get_ref() else { bail!(reader.wrong(node, expected, node.get_ref())) };
    if list.is_empty() {
        bail!("{}: `values` is empty: write at least one value", reader.place(node.span()));
    }
    if !matches!(list[0].get_ref(), Node::List(_)) {
        return Ok(Along::Values(list.iter().map(|node| reader.value(node)).collect::<Result<_>>()?));
    }
    let row = |node: &Spanned<Node>| -> Result<Vec<Value>> {
        match node.get_ref() {
            Node::List(row) if row.len() == width => row.iter().map(|node| reader.value(node)).collect(),
            Node::List(row) => {
                let (place, count) = (reader.place(node.span()), row.len());
                bail!("{place}: values in this row: {count}; variables: {width}: write one value for each variable")
            }
            other => bail!(reader.wrong(node, "a row [VALUE, ...] like the first one", other)),
        }
    };
    Ok(Along::Rows(list.iter().map(row).collect::<Result<_>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use run::subject::Key;
    use std::fs;

    const LOOP: &str = "step = 1.0\nstop = 60.0\n[fmus]\nC = \"C.fmu\"\n[settings]\nC.GAIN = 2.0\nC.TI = 9.0\n\
                        [[events]]\ntime = 5.0\nset.C.SP = 60.0\n";

    fn read_text(text: &str) -> Result<Reading> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("C.fmu"), "").unwrap();
        fs::write(folder.path().join("loop.toml"), LOOP).unwrap();
        let path = folder.path().join("study.toml");
        fs::write(&path, text).unwrap();
        read(&path, None, |_, _| unreachable!())
    }

    fn error(text: &str) -> String {
        let error = format!("{:#}", read_text(text).unwrap_err());
        error[error.find("study.toml").unwrap_or(0)..].to_string()
    }

    #[test]
    fn a_study_is_read_on_top_of_its_loop() {
        let text = r#"
            loop = "loop.toml"
            stop = 30
            samples = 10
            sampling = "sobol"
            settings = { C = { GAIN = 3 } }
            tune = { anything = 1 }
            window = { from = 5 }
            limits = [{ variable = "C.PV", max = 90 }]
            values = [{ variable = "C.LMN", take = ["min", "last"] }]
            [[events]]
            time = 5
            set.C.SP = 70
            [[axes]]
            variable = "C.TI"
            values = [1, 2.5]
            [[axes]]
            variables = ["C.A", "C.B"]
            values = [[1, true], [2, false]]
            [[axes]]
            variable = "C.SP"
            time = 7
            relative = true
            normal = { mean = 1, deviation = 0.1 }
        "#;
        let Reading { name, job, .. } = read_text(text).unwrap();
        assert_eq!(name, "study");
        let settings: Vec<_> = job.system.settings.iter().map(|of| (&*of.variable, of.value, of.time)).collect();
        assert_eq!(
            settings,
            [
                ("C.TI", Value::Number(9.0), None),
                ("C.GAIN", Value::Number(3.0), None),
                ("C.SP", Value::Number(70.0), Some(5.0))
            ]
        );
        assert_eq!((job.system.step, job.system.stop), (Some(1.0), Some(30.0)));
        let [list, rows, normal] = job.study.axes.as_slice() else { panic!("{:?}", job.study.axes) };
        assert_eq!(list.along, Along::Values(vec![Value::Number(1.0), Value::Number(2.5)]));
        let row = |number, flag| vec![Value::Number(number), Value::Boolean(flag)];
        assert_eq!(rows.along, Along::Rows(vec![row(1.0, true), row(2.0, false)]));
        assert_eq!(normal.along, Along::Normal { mean: 1.0, deviation: 0.1, min: None, max: None });
        assert_eq!((normal.time, normal.relative, rows.variables.len()), (Some(7.0), true, 2));
        assert_eq!((job.study.samples, job.study.sampling), (10, Sampling::Sobol));
    }

    /// The location for an error about a part of a study.
    fn place(reading: &Reading, keys: &[Key]) -> String {
        let error = Subject::Part(keys.to_vec()).attach(anyhow!("wrong"));
        let text = format!("{:#}", reading.located(error, Path::new("study.toml")));
        text.rsplit('/').next().unwrap().strip_suffix(": wrong").unwrap().to_string()
    }

    #[test]
    fn an_error_of_a_later_check_gets_the_line_of_the_key_that_it_is_about() {
        let text = "loop = \"loop.toml\"\nstop = -1\nstep = 0\n[[values]]\nvariable = \"C.LMM\"\ntake = [\"max\"]\n[tune]\n\
                    minimize = \"iaee\"\nconstraints = [\"ms < 2\"]\n[[tune.search]]\nvariable = \"C.GIAN\"\n";
        let reading = read_text(text).unwrap();
        for (keys, expected) in [
            (vec!["stop".into()], "study.toml:2:8"),
            (vec!["step".into()], "study.toml:3:8"),
            (vec!["values".into(), 0.into()], "study.toml:4:1"),
            (vec!["tune".into(), "minimize".into()], "study.toml:8:12"),
            (vec!["tune".into(), "constraints".into(), 0.into()], "study.toml:9:16"),
            (vec!["tune".into(), "search".into(), 0.into(), "variable".into()], "study.toml:11:12"),
            // What the file lacks is in the enclosing part, or in the loop.
            (vec!["tune".into(), "front".into()], "study.toml:7:1"),
            (vec!["axes".into(), 0.into()], "study.toml:1:8"),
            (vec!["values".into(), 1.into()], "study.toml:1:8"),
            (vec![], "study.toml:1:8"),
        ] {
            assert_eq!(place(&reading, &keys), expected, "{keys:?}");
        }
        let named = Subject::Outside.attach(anyhow!("loop.toml:6:1: C has no variable X"));
        let named = reading.located(named, Path::new("study.toml"));
        assert_eq!(format!("{named:#}"), "loop.toml:6:1: C has no variable X");
        let wrong = format!("{:#}", reading.tune().unwrap_err());
        assert!(wrong.ends_with("study.toml:10:1: missing field `min`"), "{wrong}");
    }

    #[test]
    fn a_folder_is_named_from_that_of_the_study() {
        let place = tempfile::tempdir().unwrap();
        let [studies, fmus] = ["plant/studies", "target/fmu"].map(|name| place.path().join(name));
        for folder in [&studies, &fmus] {
            fs::create_dir_all(folder).unwrap();
        }
        assert_eq!(relative(&fmus, &studies), "../../target/fmu");
        assert_eq!(relative(&studies, &studies), ".");
        assert_eq!(relative(Path::new("none"), &studies), "none");
    }

    const CORRELATED: &str = "loop = \"loop.toml\"\nsampling = \"sobol\"\n\
        [[axes]]\nvariable = \"C.A\"\nuniform = { min = 0, max = 1 }\n\
        [[axes]]\nvariable = \"C.B\"\nuniform = { min = 0, max = 1 }\n\
        [[correlations]]\nvariables = [\"C.A\", \"C.B\"]\nrank = 0.9\n";

    #[test]
    fn a_correlation_is_of_two_variables_and_its_errors_are_told_at_it() {
        let three = CORRELATED.replace("\"C.B\"]", "\"C.B\", \"C.D\"]");
        assert_eq!(
            error(&three),
            "study.toml:10:13: a correlation relates two variables, but `variables` has 3: add a \
             [[correlations]] table for each pair"
        );
        let again = "[[correlations]]\nvariables = [\"C.B\", \"C.A\"]\nrank = -0.9\n";
        let reading = read_text(&format!("{CORRELATED}{again}")).unwrap();
        let wrong = crate::correlation::mixing(&reading.job.study).unwrap_err();
        let wrong = format!("{:#}", reading.located(wrong, Path::new("study.toml")));
        assert!(wrong.contains("study.toml:12:1: correlations: C.B and C.A: "), "{wrong}");
        assert_eq!(place(&reading, &["correlations".into()]), "study.toml:9:1");
        assert_eq!(place(&reading, &["sampling".into()]), "study.toml:2:12");
    }

    #[test]
    fn an_error_about_an_axis_is_told_at_its_key_and_one_of_a_table_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("C.fmu", ""), ("loop.toml", LOOP), ("loops.csv", "loop,C.GIAN\nTIC1,2\n")] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        let path = folder.path().join("study.toml");
        let text = "loop = \"loop.toml\"\n[[axes]]\nfile = \"loops.csv\"\n[[axes]]\nvariable = \"C.A\"\ntime = 900\nvalues = [1]\n";
        fs::write(&path, text).unwrap();
        let reading = read(&path, None, |_, _| unreachable!()).unwrap();
        let located = |error: &str, keys: &[Key]| {
            let error = Subject::Part(keys.to_vec()).attach(anyhow!("{error}"));
            let text = format!("{:#}", reading.located(error, &path));
            text.replace(&folder.path().join("").display().to_string(), "")
        };
        assert_eq!(
            located("axis 1 (C.GIAN): C has no variable GIAN; did you mean C.GAIN?", &["axes".into(), 0.into()]),
            "study.toml:3:8: loops.csv: axis 1 (C.GIAN): C has no variable GIAN; did you mean C.GAIN?"
        );
        let time = located("C.A cannot be set at 900.0 s", &["axes".into(), 1.into(), "time".into()]);
        assert!(time.starts_with("study.toml:6:8: C.A cannot"), "{time}");
        assert!(located("C has no variable A", &["axes".into(), 1.into()]).starts_with("study.toml:4:1: C has"));
    }

    #[test]
    fn what_is_wrong_has_its_place_and_a_remedy() {
        assert_eq!(
            error("stop = 1"),
            "study.toml:1:1: the study has no loop: write loop = \"FILE.toml\", a loop description as for plcfmu run"
        );
        assert!(error("loop = \"none.toml\"").starts_with("study.toml:1:8: no file "));
        let axis = |text: &str| error(&format!("loop = \"loop.toml\"\n[[axes]]\n{text}"));
        assert_eq!(
            axis("variable = \"C.A\"\nvalues = [1]\nuniform = { min = 0, max = 1 }"),
            "study.toml:2:1: the axis of C.A has values and uniform: an axis can have only one kind of values; add \
             another [[axes]] for the other"
        );
        assert!(axis("variable = \"C.A\"\nvariables = [\"C.B\"]\nvalues = [1]").contains("remove one of them"));
        assert!(axis("values = [1]").contains("write variable = \"FMU.VARIABLE\""));
        assert!(axis("variable = \"C.A\"").contains("write one of values = [...], range"));
        assert_eq!(
            axis("variable = \"C.A\"\nvalues = [1, \"x\"]"),
            "study.toml:4:14: expected a finite number, true or false; found the string \"x\""
        );
        assert!(axis("variables = [\"C.A\", \"C.B\"]\nvalues = [[1]]").contains("values in this row: 1; variables: 2"));
        let wrong = axis("variable = \"C.A\"\nuniform = { min = 0, most = 1 }");
        assert!(wrong.starts_with("study.toml:4:11: uniform: unknown field `most`"), "{wrong}");
        assert_eq!(
            axis("variable = \"C.A\"\nwhole = true\nuniform = { min = 1.2, max = 1.8 }"),
            "study.toml:5:11: axis 1 (C.A): uniform: no whole number lies between min = 1.2 and max = 1.8: choose \
             bounds with one between them, or remove `whole`"
        );
        for none in [
            "normal = { mean = 0.5, deviation = 0.2, min = 0.4, max = 0.6 }",
            "triangular = { min = 1.1, mode = 1.5, max = 1.9 }",
        ] {
            assert!(
                axis(&format!("variable = \"C.A\"\nwhole = true\n{none}")).contains("no whole number lies between"),
                "{none}"
            );
        }
        let wrong = axis("variable = \"C.A\"\nuniform = { min = nan, max = 1 }");
        assert_eq!(wrong, "study.toml:4:11: axis 1 (C.A): uniform: min = NaN: use a finite number");
        let other = |text: &str| error(&format!("loop = \"loop.toml\"\n{text}"));
        // Workers receive their job as JSON, which has no NaN: this check precedes the conversion.
        assert_eq!(
            other("[[limits]]\nvariable = \"C.PV\"\nmax = 1\n[[limits]]\nvariable = \"C.LMN\"\nmax = nan"),
            "study.toml:5:1: limits: C.LMN: max is not a finite number: omit it if there is no such limit"
        );
        assert_eq!(
            other("[window]\nfrom = inf"),
            "study.toml:2:1: window: specify finite times in seconds, or omit `from` or `to`"
        );
        assert!(other("samples = 5").starts_with("study.toml:2:11: samples = 5, but no axis has a distribution"));
        let wrong = axis("variable = \"C.A\"\nvalue = [1]");
        assert!(wrong.starts_with("study.toml:4:1: unknown field `value`, expected one of"), "{wrong}");
        assert!(wrong.ends_with("; did you mean values?"), "{wrong}");
        assert_eq!(
            other("[settings]\nC = 3"),
            "study.toml:3:1: C is an FMU: set one of its variables, C.VARIABLE = VALUE"
        );
        assert!(error("loop = \"loop.toml\"\nsamples = 0").ends_with("samples must be between 1 and 1000000000"));
    }
}
