//! Test cases of a program: inputs over time, and expectations.

use ::program::TextPlace;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use blocks::TextType;
use draw::escape::Text;
use manifest::{Manifest, constant, declaration, tag};
use parameters::tags::Tag;
use parameters::{Source, literal};
use run::file;
use scl::Compiled;
use scl::ir::{Program, Scalar, Type, Value};
use scl::machine::{Code, Machine};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

/// A file with test cases.
#[derive(Debug)]
pub struct File {
    source: Source,
    /// How the program is built from its sources.
    pub manifest: Manifest,
    /// The test cases.
    pub cases: Vec<Case>,
    cycle: i64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    /// By default, the sources in the file's folder.
    #[serde(default)]
    sources: Vec<PathBuf>,
    cycle: Spanned<String>,
    cpu: Option<Spanned<String>>,
    fb: Option<String>,
    #[serde(default)]
    tags: Vec<Spanned<String>>,
    #[serde(default)]
    stubs: Vec<String>,
    #[serde(default)]
    instances: Vec<Spanned<String>>,
    #[serde(default)]
    constants: Vec<Spanned<String>>,
    #[serde(default)]
    case: Vec<Case>,
}

/// A test case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name.
    pub name: String,
    steps: Spanned<Vec<Spanned<Step>>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    at: String,
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
    #[serde(default)]
    expect: BTreeMap<String, toml::Value>,
    within: Option<String>,
    until: Option<String>,
    tolerance: Option<f64>,
}

impl File {
    /// Reads a test file.
    ///
    /// # Errors
    /// It cannot be read, or is faulty; the message includes file, line and column.
    pub fn read(path: &Path) -> Result<File> {
        let (shown, bytes) = Source::load(path, Source::LARGEST).map_err(Error::msg)?;
        let source = Source::new(shown, bytes);
        let content: Content = file::content(&source)?;
        let at = |text: &Spanned<String>| file::place(&source, text.span());
        let read = |text: &Spanned<String>, wrong: String| anyhow!("{}: {wrong}", at(text));
        let pairs = |texts: &[Spanned<String>], of: fn(&str) -> Result<(String, String), String>| {
            texts.iter().map(|text| of(text.get_ref()).map_err(|wrong| read(text, wrong))).collect::<Result<Vec<_>>>()
        };
        let tags = content.tags.iter().map(|text| tag(text.get_ref()).map_err(|wrong| read(text, wrong)));
        let instances = pairs(&content.instances, declaration)?.into_iter().map(|(name, of)| Ok(Tag::new(name, of)));
        let folder = Path::new(&source.file).parent().unwrap_or(Path::new(""));
        let sources = match content.sources.is_empty() {
            true if folder.as_os_str().is_empty() => vec![PathBuf::from(".")],
            true => vec![folder.to_path_buf()],
            false => content.sources.iter().map(|source| folder.join(source)).collect(),
        };
        let cpu = |text: &Spanned<String>| text.get_ref().parse().map_err(|wrong| anyhow!("{}: {wrong}", at(text)));
        let manifest = Manifest {
            cpu: content.cpu.as_ref().map(cpu).transpose()?,
            block: content.fb.clone(),
            sources,
            declared: tags.chain(instances).collect::<Result<_>>()?,
            stubs: content.stubs.clone(),
            constants: pairs(&content.constants, constant)?,
            ..Manifest::default()
        };
        let cycle = nanoseconds(content.cycle.get_ref()).with_context(|| format!("{}: cycle", at(&content.cycle)))?;
        if cycle <= 0 {
            bail!("{}: the cycle must be greater than 0", at(&content.cycle));
        }
        let cases = content.case;
        if cases.is_empty() {
            bail!("{}: the file has no test case: add [[case]] with a name and steps", source.file);
        }
        if let Some(empty) = cases.iter().find(|case| case.steps.get_ref().is_empty()) {
            bail!("{}: {} has no steps: add at least one", file::place(&source, empty.steps.span()), empty.name);
        }
        Ok(File { source, manifest, cases, cycle })
    }

    /// `FILE:LINE` of a step.
    fn place(&self, step: &Spanned<Step>) -> String {
        let place = file::place(&self.source, step.span());
        format!("{}:{}", place.file, place.line)
    }

    /// The number of the first call at or after a time, such as `2s`. Call 0 is at 0 s.
    fn call(&self, time: &str) -> Result<i64> {
        let nanoseconds = nanoseconds(time)?;
        ensure!(nanoseconds >= 0, "{time:?} is negative: a case begins at 0s");
        Ok(nanoseconds.div_euclid(self.cycle) + i64::from(nanoseconds.rem_euclid(self.cycle) > 0))
    }
}

/// Parses a duration such as `2s` or `1m30s`; returns nanoseconds.
pub(crate) fn nanoseconds(text: &str) -> Result<i64> {
    let count =
        literal::duration(text, 1).map_err(|_| anyhow!("{text:?} is not a duration: write 2s, 100ms or 1m30s"))?;
    i64::try_from(count).with_context(|| format!("{text:?} is too long"))
}

/// A program that is prepared for running test cases, and the coverage of those that were run.
pub struct Trial {
    program: Program,
    machine: Machine,
    instance: String,
    cycle: usize,
    startup: Option<usize>,
    lines: BTreeMap<(u16, u32), bool>,
}

/// The expectation of a step, and the calls to which it applies.
struct Expectation<'a> {
    step: &'a Spanned<Step>,
    first: i64,
    last: i64,
    /// Whether it must hold at least once, rather than in every call.
    is_once: bool,
    values: Vec<(&'a str, Given)>,
}

/// The location and type of a variable.
#[derive(Clone, Copy)]
enum Slot {
    Number(usize, Scalar),
    Text(TextPlace),
}

/// A value in a case, and the location of its variable.
enum Given {
    Number(usize, Value),
    Text(TextPlace, String),
}

impl Trial {
    /// Prepares a program for testing.
    ///
    /// # Errors
    /// The program has no block to run, or several.
    pub fn new(compiled: Compiled) -> Result<Trial> {
        let root = compiled.root.context(
            "no block to run: several blocks are not called by any other; choose a function block with fb = \"NAME\"",
        )?;
        let code = Code::compile(&compiled.program).map_err(|error| anyhow!(error))?;
        let mut machine = Machine::new(Arc::new(code));
        machine.forget_coverage();
        Ok(Trial {
            program: compiled.program,
            machine,
            instance: root.instance,
            cycle: root.cycle,
            startup: root.startup,
            lines: BTreeMap::new(),
        })
    }

    fn variable(&self, name: &str) -> Result<Slot> {
        let found = self.program.find(&format!("{}.{name}", self.instance)).or_else(|| self.program.find(name));
        match found {
            Some((offset, Type::Scalar(of))) => Ok(Slot::Number(offset, of)),
            Some((offset, Type::Text { capacity: most, wide: is_wide })) => {
                Ok(Slot::Text(TextPlace { offset, ty: TextType { most, is_wide } }))
            }
            Some(_) => bail!("{name} is neither a number nor a string: specify one of its members or elements"),
            None => bail!("the program has no variable {name}"),
        }
    }

    /// Runs a test case; returns what failed, if anything did.
    ///
    /// # Errors
    /// The test case is invalid; the message includes file and line.
    pub fn run(&mut self, file: &File, case: &Case) -> Result<Option<String>> {
        self.machine.restart();
        let mut settings: BTreeMap<i64, Vec<Given>> = BTreeMap::new();
        let mut expectations = Vec::new();
        for step in case.steps.get_ref() {
            let (setting, expectation) = self.step(file, step).with_context(|| file.place(step))?;
            settings.entry(expectation.first).or_default().extend(setting);
            expectations.push(expectation);
        }
        let last = expectations.iter().map(|expectation| expectation.last).max().unwrap_or(0);
        let mut held = vec![false; expectations.len()];
        let mut problem = None;
        if let Some(Err(stop)) = self.startup.map(|startup| self.machine.call(startup, 0)) {
            return Ok(Some(format!("the program stops at startup: {stop}")));
        }
        for call in 0..=last {
            for setting in settings.remove(&call).unwrap_or_default() {
                match setting {
                    Given::Number(offset, value) => self.machine.set(value, offset),
                    Given::Text(place, text) => {
                        place.write(self.machine.state_mut(), &text.encode_utf16().collect::<Vec<_>>());
                    }
                }
            }
            if let Err(stop) = self.machine.call(self.cycle, call * file.cycle) {
                problem = Some(format!("the program stops at {}: {stop}", time(call * file.cycle)));
                break;
            }
            problem = self.check(file, call, &expectations, &mut held);
            if problem.is_some() {
                break;
            }
        }
        // The last file is the timer library.
        let sources = self.program.files.len() - 1;
        for (at, is_run) in self.machine.coverage().filter(|(at, _)| at.line > 0 && usize::from(at.file) < sources) {
            *self.lines.entry((at.file, at.line)).or_default() |= is_run;
        }
        Ok(problem)
    }

    fn step<'a>(&self, file: &File, step: &'a Spanned<Step>) -> Result<(Vec<Given>, Expectation<'a>)> {
        let content = step.get_ref();
        let first = file.call(&content.at)?;
        let last = match (&content.within, &content.until) {
            (Some(within), None) => file.call(&content.at)? + file.call(within)?,
            (None, Some(until)) => file.call(until)?,
            (None, None) => first,
            (Some(_), Some(_)) => bail!("a step can have `within` or `until`, but not both"),
        };
        ensure!(last >= first, "`until` is before `at`");
        let is_range = content.within.is_some() || content.until.is_some() || content.tolerance.is_some();
        ensure!(
            !(is_range && content.expect.is_empty()),
            "`within`, `until` and `tolerance` are for expected values: add `expect`"
        );
        if let Some(tolerance) = content.tolerance.filter(|tolerance| !(tolerance.is_finite() && *tolerance >= 0.0)) {
            bail!("the tolerance must be 0 or more, not {tolerance}");
        }
        let mut setting = Vec::new();
        for (name, given) in &content.set {
            setting.push(self.variable(name)?.given(name, given)?);
        }
        let mut values = Vec::new();
        for (name, expected) in &content.expect {
            values.push((name.as_str(), self.variable(name)?.given(name, expected)?));
        }
        Ok((setting, Expectation { step, first, last, is_once: content.within.is_some(), values }))
    }

    /// Describes the first deviation in this call that makes an expectation fail. `held` marks the expectations that
    /// need to hold only once and have done so.
    fn check(&self, file: &File, call: i64, expectations: &[Expectation], held: &mut [bool]) -> Option<String> {
        for (expectation, held) in expectations.iter().zip(held) {
            if !(expectation.first..=expectation.last).contains(&call) || *held {
                continue;
            }
            let tolerance = expectation.step.get_ref().tolerance;
            let missed = expectation.values.iter().find_map(|(name, expected)| match expected {
                Given::Number(offset, expected) => {
                    let found = self.machine.get(expected.ty(), *offset);
                    (!is_equal(found, *expected, tolerance)).then(|| format!("{name} is {found}, expected {expected}"))
                }
                Given::Text(place, expected) => {
                    let found = place.read(self.machine.state());
                    (found != *expected).then(|| format!("{name} is {found:?}, expected {expected:?}"))
                }
            });
            match missed {
                None => *held = expectation.is_once,
                Some(missed) if !expectation.is_once || call == expectation.last => {
                    return Some(format!("{}: at {}: {missed}", file.place(expectation.step), time(call * file.cycle)));
                }
                Some(_) => {}
            }
        }
        None
    }

    /// Which lines of the sources were executed in the test cases run.
    pub fn coverage(self) -> Coverage {
        Coverage { lines: self.lines }
    }
}

/// A time, formatted for a message.
fn time(nanoseconds: i64) -> String {
    format!("{} s", nanoseconds as f64 / 1e9)
}

impl Slot {
    /// A value of a test case, converted for this variable.
    fn given(self, name: &str, given: &toml::Value) -> Result<Given> {
        match (self, given) {
            (Slot::Number(offset, of), given) => Ok(Given::Number(offset, value(name, given, of)?)),
            (Slot::Text(place), toml::Value::String(text)) => {
                place.ty.units(text).map_err(|why| anyhow!("{name} = {given}: {why}"))?;
                Ok(Given::Text(place, text.clone()))
            }
            (Slot::Text(_), given) => {
                bail!("{given} is not a valid value for {name}, which is a string: write it in quotation marks")
            }
        }
    }
}

/// A value of a test case, converted to the type of its variable.
fn value(name: &str, given: &toml::Value, of: Scalar) -> Result<Value> {
    let valid = match of {
        Scalar::Bool => "true or false",
        Scalar::F32 | Scalar::F64 => "a number",
        Scalar::I32 | Scalar::I64 => "an integer that fits its type, or a duration such as \"2s\"",
        _ => "an integer that fits its type",
    };
    let wrong = || anyhow!("{given} is not a valid value for {name}: write {valid}");
    let number = |number: f64| match of {
        Scalar::F32 => Some(Value::from(number as f32)),
        Scalar::F64 => Some(Value::from(number)),
        _ => None,
    };
    let integer = |integer: i64| Value::new(of, integer as u64);
    match given {
        toml::Value::Boolean(truth) if of == Scalar::Bool => Ok(Value::from(*truth)),
        toml::Value::Integer(whole) if of.is_integer() => {
            let is_same = integer(*whole).bits() as i64 == *whole;
            if is_same { Ok(integer(*whole)) } else { Err(wrong()) }
        }
        toml::Value::Integer(whole) => number(*whole as f64).ok_or_else(wrong),
        toml::Value::Float(real) if !real.is_nan() => number(*real).ok_or_else(wrong),
        // A TIME, in ms, or an LTIME, in ns.
        toml::Value::String(text) if matches!(of, Scalar::I32 | Scalar::I64) => {
            let text = text.rsplit('#').next().unwrap_or(text);
            let nanoseconds = nanoseconds(text).map_err(|_| wrong())?;
            Ok(integer(if of == Scalar::I32 { nanoseconds / 1_000_000 } else { nanoseconds }))
        }
        _ => Err(wrong()),
    }
}

fn is_equal(found: Value, expected: Value, tolerance: Option<f64>) -> bool {
    if !found.ty().is_float() && tolerance.is_none() {
        return found == expected;
    }
    // The default tolerance: a REAL has about seven significant digits.
    let tolerance = tolerance.unwrap_or(1e-6 * expected.number().abs());
    found == expected || (found.number() - expected.number()).abs() <= tolerance
}

/// The lines of a program that contain statements, by file and line number, and whether they were executed.
#[derive(Debug)]
pub struct Coverage {
    lines: BTreeMap<(u16, u32), bool>,
}

impl Coverage {
    /// The number of lines with statements in the sources.
    pub fn all(&self) -> usize {
        self.lines.len()
    }

    /// The number of these lines that were executed.
    pub fn run(&self) -> usize {
        self.lines.values().filter(|is_run| **is_run).count()
    }

    /// A page with the program sources, which distinguishes executed lines from lines that were not executed.
    pub fn page(&self, sources: &[Source]) -> String {
        let mut page = String::from(
            "<!doctype html>\n<meta charset=\"utf-8\">\n<title>Coverage</title>\n\
             <style>pre { counter-reset: line } i { font-style: normal; display: block; white-space: pre; min-height: 1.2em } \
             i::before { counter-increment: line; content: counter(line); display: inline-block; width: 4em; color: #777 } \
             .run { background: #dff2df } .not { background: #f9dede }</style>\n",
        );
        for (file, source) in sources.iter().enumerate() {
            page += &format!("<h1>{}</h1>\n<pre>", Text(&source.file));
            for (number, line) in source.text.lines().enumerate() {
                let class = match self.lines.get(&(file as u16, number as u32 + 1)) {
                    Some(true) => " class=\"run\"",
                    Some(false) => " class=\"not\"",
                    None => "",
                };
                page += &format!("<i{class}>{}</i>", Text(line));
            }
            page += "</pre>\n";
        }
        page
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const PROGRAM: &str = "FUNCTION_BLOCK \"Main\"\nVAR_INPUT start : Bool; level : Real; name : String[4] := 'A'; END_VAR\n\
        VAR_OUTPUT valve : Bool; half : Real; END_VAR\nVAR t : TON_TIME; END_VAR\nBEGIN\n\
        #t(IN := #start, PT := T#1s);\nIF #t.Q THEN\n#valve := TRUE;\nEND_IF;\n#half := #level / 2.0;\n\
        IF #level > 100.0 THEN\n#valve := FALSE;\nEND_IF;\nEND_FUNCTION_BLOCK\n";

    fn compiled(file: &File) -> Compiled {
        let parts = super::super::parts(&file.manifest).unwrap();
        scl::compile(&parts.sources, &parts.manifest).unwrap()
    }

    fn results(cases: &str) -> (Vec<Option<String>>, Coverage, PathBuf, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("main.scl");
        fs::write(&source, PROGRAM).unwrap();
        let path = folder.path().join("main.toml");
        fs::write(&path, format!("sources = [\"main.scl\"]\ncycle = \"100ms\"\n{cases}")).unwrap();
        let file = File::read(&path).unwrap();
        let mut trial = Trial::new(compiled(&file)).unwrap();
        let results = file.cases.iter().map(|case| trial.run(&file, case).unwrap()).collect();
        (results, trial.coverage(), source, folder)
    }

    #[test]
    fn what_is_wrong_with_a_file_is_told_with_line_and_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("main.toml");
        let error = |text: &str| {
            fs::write(&path, text).unwrap();
            let error = format!("{:#}", File::read(&path).unwrap_err());
            error.strip_prefix(&format!("{}:", path.display())).unwrap().to_string()
        };
        let rest = "sources = [\"main.scl\"]\n";
        assert!(error("DATA_BLOCK x\n").starts_with("1:12: "), "{}", error("DATA_BLOCK x\n"));
        assert_eq!(error(&format!("{rest}cycle = 5\n")), "2:9: expected a string in quotation marks; found 5");
        assert_eq!(
            error(&format!("{rest}cycle = \"soon\"\n")),
            "2:9: cycle: \"soon\" is not a duration: write 2s, 100ms or 1m30s"
        );
        let cycle = "cycle = \"1s\"\n";
        assert_eq!(
            error(&format!("{rest}{cycle}cpu = \"9\"\n")),
            "3:7: the CPU must be 300, 400, 1200 or 1500, not \"9\""
        );
        assert_eq!(
            error(&format!("{rest}{cycle}tags = [\"A : Bool\",\n  \"B\"]\n")),
            "4:3: \"B\": write a name, a colon and a type, such as Start : Bool"
        );
        assert_eq!(error(&format!("{rest}{cycle}")), " the file has no test case: add [[case]] with a name and steps");
        assert_eq!(
            error(&format!("{rest}{cycle}[[case]]\nname = \"opens\"\nsteps = []\n")),
            "5:9: opens has no steps: add at least one"
        );
    }

    #[test]
    fn what_is_expected_holds_at_a_time_within_one_or_until_one() {
        let (results, coverage, source, _folder) = results(
            r#"
[[case]]
name = "opens"
steps = [
  { at = "0s", set = { start = true, level = 3 }, expect = { half = 1.5, "t.ET" = "0s" } },
  { at = "0s", until = "900ms", expect = { valve = false } },
  { at = "0s", within = "1s", expect = { valve = true } },
  { at = "2s", expect = { half = 1.6 }, tolerance = 0.2 },
]
[[case]]
name = "too early"
steps = [
  { at = "0s", set = { start = true } },
  { at = "0s", within = "900ms", expect = { valve = true } },
]
[[case]]
name = "begins anew"
steps = [{ at = "0s", expect = { valve = false } }]
"#,
        );
        assert_eq!((&results[0], &results[2]), (&None, &None));
        let problem = results[1].as_ref().unwrap();
        assert!(problem.ends_with("main.toml:16: at 0.9 s: valve is false, expected true"), "{problem}");
        // The branch above 100 % is never taken.
        assert_eq!((coverage.run(), coverage.all()), (5, 6));
        let page = coverage.page(&[Source::read(&source, None).unwrap()]);
        assert!(
            page.contains("<i class=\"not\">#valve := FALSE;</i>")
                && page.contains("<i class=\"run\">#valve := TRUE;</i>")
        );
    }

    #[test]
    fn a_step_that_tests_nothing_is_refused() {
        let refused = |step: &str| {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("main.scl"), PROGRAM).unwrap();
            let path = folder.path().join("main.toml");
            let case = format!("[[case]]\nname = \"x\"\nsteps = [{{ {step} }}]\n");
            fs::write(&path, format!("cycle = \"100ms\"\n{case}")).unwrap();
            let file = File::read(&path).unwrap();
            let error = Trial::new(compiled(&file)).unwrap().run(&file, &file.cases[0]).unwrap_err();
            format!("{error:#}").split_once("main.toml:4: ").unwrap().1.to_string()
        };
        assert_eq!(refused("at = \"-2s\", expect = { valve = true }"), "\"-2s\" is negative: a case begins at 0s");
        assert_eq!(
            refused("at = \"0s\", within = \"-5s\", expect = { valve = true }"),
            "\"-5s\" is negative: a case begins at 0s"
        );
        assert_eq!(
            refused("at = \"0s\", within = \"1s\""),
            "`within`, `until` and `tolerance` are for expected values: add `expect`"
        );
        assert_eq!(
            refused("at = \"0s\", expect = { half = 1.0 }, tolerance = -1.0"),
            "the tolerance must be 0 or more, not -1"
        );
        assert_eq!(refused("at = \"0s\", set = { level = nan }"), "nan is not a valid value for level: write a number");
    }

    #[test]
    fn a_text_is_set_and_compared() {
        let (results, ..) = results(
            r#"
[[case]]
name = "kept"
steps = [
  { at = "0s", expect = { name = "A" } },
  { at = "1s", set = { name = "Größ" }, expect = { name = "Größ" } },
]
[[case]]
name = "another"
steps = [{ at = "0s", set = { name = "x" }, expect = { name = "y" } }]
"#,
        );
        assert_eq!(results[0], None);
        let problem = results[1].as_deref().unwrap();
        assert!(problem.ends_with(r#"at 0 s: name is "x", expected "y""#), "{problem}");
        let slot = Slot::Text(TextPlace { offset: 0, ty: TextType { most: 4, is_wide: false } });
        let refused = |given: toml::Value| slot.given("name", &given).err().unwrap().to_string();
        assert_eq!(refused("Valve".into()), "name = \"Valve\": STRING[4] holds at most 4 characters, not 5");
        assert!(refused(toml::Value::Integer(1)).ends_with("which is a string: write it in quotation marks"));
    }

    #[test]
    fn a_value_that_does_not_fit_is_told() {
        assert!(value("x", &toml::Value::Integer(40_000), Scalar::I16).is_err());
        assert!(value("x", &toml::Value::Boolean(true), Scalar::I16).is_err());
        assert_eq!(value("x", &toml::Value::String("T#1s500ms".into()), Scalar::I32).unwrap(), Value::from(1500i32));
    }
}
