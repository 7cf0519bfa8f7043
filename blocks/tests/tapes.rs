//! The tapes of each block, `clauses.txt` in its folder, played on the law. blocks/README.md says how to read them;
//! tests/tapes.py plays them on the FMU and on the second version of the law.

#![allow(clippy::unwrap_used)]

use blocks::table::number::{number, to_value};
use blocks::{Block, EachBlock, Kind, Real, StaticTable, for_each_block};
use std::fs;
use std::path::{Path, PathBuf};

/// One value of a sequence; a TIME in seconds, a BOOL as 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Expected {
    Anything,
    Exactly(f64),
    Nearly(f64),
}

/// A variable with its value in each call.
type Sequence = (String, Vec<Expected>);

/// A run: what is set before the restart and before later calls, and what the block answers.
#[derive(Clone, Debug, Default)]
struct Run {
    title: String,
    set: Vec<Sequence>,
    answers: Vec<Sequence>,
}

impl Run {
    /// The settings of a heading without answers, for the cases below it, with those of a case.
    fn over(&self, common: &Run) -> Run {
        let is_new = |(name, _): &&Sequence| !self.set.iter().any(|(own, _)| own == name);
        let set = common.set.iter().filter(is_new).chain(&self.set).cloned().collect();
        Run { set, ..self.clone() }
    }

    /// With the settings of the run or the characteristic of the documentation that its heading names, `Response 2. ...`.
    fn as_documented<B: Block>(&self) -> Run {
        let number = |word| self.title.strip_prefix(word)?.split(". ").next()?.parse::<usize>().ok();
        let set = if let Some(number) = number("Response ") {
            B::TABLE.responses[number - 1].set.to_vec()
        } else if let Some(number) = number("Characteristic ") {
            B::TABLE.characteristics[number - 1].set.iter().map(|(name, value)| (0, *name, *value)).collect()
        } else {
            return self.clone();
        };
        let sequence = |(call, name, value): &(u32, &str, f64)| {
            let mut values = vec![Expected::Anything; *call as usize];
            values.push(Expected::Exactly(*value));
            ((*name).to_string(), values)
        };
        Run { set: set.iter().map(sequence).chain(self.set.iter().cloned()).collect(), ..self.clone() }
    }

    fn calls(&self) -> usize {
        self.set.iter().chain(&self.answers).map(|(_, values)| values.len()).max().unwrap_or(0)
    }

    /// Plays it, and says in which call which variable is wrong.
    fn play<B: Block>(&self) -> Result<(), String> {
        let mut block = B::default();
        self.set_for_call(&mut block, 0);
        block.restart();
        for call in 0..self.calls() {
            if call > 0 {
                self.set_for_call(&mut block, call);
            }
            block.call();
            for (name, values) in &self.answers {
                let (row, kind) = row::<B>(name);
                let value = number(block.get(row).unwrap());
                let is_right = match values.get(call) {
                    None | Some(Expected::Anything) => true,
                    Some(Expected::Exactly(of)) if kind == Kind::Real => value as Real == *of as Real,
                    Some(Expected::Exactly(of)) => value == *of,
                    Some(Expected::Nearly(of)) => (value - of).abs() <= 1e-4 * of.abs().max(1.0),
                };
                if !is_right {
                    return Err(format!("{name} is {value} in call {}, not {:?}", call + 1, values[call]));
                }
            }
        }
        Ok(())
    }

    fn set_for_call<B: Block>(&self, block: &mut B, call: usize) {
        for (name, values) in &self.set {
            if let Some(Expected::Exactly(value)) = values.get(call) {
                let (row, kind) = row::<B>(name);
                assert!(block.set(row, to_value(*value, kind).unwrap()), "{name}");
            }
        }
    }
}

fn row<B: Block>(name: &str) -> (usize, Kind) {
    let row = B::TABLE.find(name).unwrap_or_else(|| panic!("{} has no {name}", B::TABLE.name));
    (row, B::TABLE.rows[row].kind)
}

/// The runs of a tape.
fn runs(text: &str) -> Vec<Run> {
    let mut common = Run::default();
    let mut runs = Vec::new();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let text = lines.collect::<Vec<_>>().join("\n");
    for case in text.split("\n\n").map(str::trim).filter(|case| !case.is_empty()) {
        let (title, body) = case.split_once('\n').unwrap_or((case, ""));
        let count = body.lines().map(|line| line.matches('|').count()).max().unwrap_or(0);
        let (settings, answers): (Vec<_>, Vec<_>) = body.lines().partition(|line| !line.contains("->"));
        let settings: Vec<_> = settings.iter().flat_map(|line| line.split(',')).map(|one| sides(one, "=")).collect();
        let answers: Vec<_> = answers.iter().map(|line| sides(line, "->")).collect();
        let variants = settings.iter().map(|(_, values)| values.split('|').count()).max().unwrap_or(1);
        assert!(variants > 1 || count == 0, "{title}: only settings make variants");
        for variant in 0..variants {
            let of = |lines: &[(&str, &str)]| {
                lines.iter().flat_map(|(names, values)| sequences(names, values, variant)).collect()
            };
            let title = if variants > 1 { format!("{title} [{}]", variant + 1) } else { title.to_string() };
            let run = Run { title, set: of(&settings), answers: of(&answers) };
            if run.answers.is_empty() {
                common = run;
            } else {
                runs.push(run.over(&common));
            }
        }
    }
    runs
}

fn sides<'a>(line: &'a str, sign: &str) -> (&'a str, &'a str) {
    let (names, values) = line.split_once(sign).unwrap_or_else(|| panic!("{line:?} has no {sign}"));
    (names.trim(), values.trim())
}

/// The sequence of a name, or of two with a slash between them: `+` is TRUE of the first, `-` of the second.
fn sequences(names: &str, values: &str, variant: usize) -> Vec<Sequence> {
    let variants: Vec<_> = values.split('|').collect();
    let values = variants[if variants.len() == 1 { 0 } else { variant }];
    let signs = if names.contains('/') { vec!['+', '-'] } else { vec!['+'] };
    let one = |(name, sign): (&str, &char)| {
        let values = values.split_whitespace().flat_map(|token| repeated(token, *sign)).collect();
        (name.to_string(), values)
    };
    names.split('/').zip(&signs).map(one).collect()
}

/// `0.5*3` is 0.5 in three calls, `+.*3` is TRUE and FALSE three times.
fn repeated(token: &str, sign: char) -> Vec<Expected> {
    let (token, count) = token.split_once('*').map_or((token, 1), |(token, count)| (token, count.parse().unwrap()));
    let values = if token.chars().all(|c| "+-.".contains(c)) {
        token.chars().map(|c| Expected::Exactly(f64::from(u8::from(c == sign)))).collect()
    } else {
        vec![value(token)]
    };
    values.repeat(count)
}

fn value(token: &str) -> Expected {
    let read = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("{token:?} is not a value of a tape"));
    match token {
        "_" => Expected::Anything,
        "TRUE" => Expected::Exactly(1.0),
        "FALSE" => Expected::Exactly(0.0),
        _ => match (token.strip_prefix('~'), token.strip_suffix("ms"), token.strip_suffix('s')) {
            (Some(number), ..) => Expected::Nearly(read(number)),
            (_, Some(time), _) => Expected::Exactly(read(time) / 1000.0),
            (.., Some(time)) => Expected::Exactly(read(time)),
            _ => Expected::Exactly(read(token)),
        },
    }
}

/// The folder of a block.
fn folder(block: &str) -> PathBuf {
    let vendors = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap();
    let mut folders = vendors.map(|entry| entry.unwrap().path().join(block.to_lowercase()));
    folders.find(|folder| folder.is_dir()).unwrap_or_else(|| panic!("{block} has no folder in blocks/src"))
}

/// A block with the runs of its tape, and what is wrong in them.
struct Played {
    table: &'static StaticTable,
    runs: Vec<Run>,
    wrong: Vec<String>,
}

/// All blocks.
fn played() -> Vec<Played> {
    struct Play(Vec<Played>);
    impl EachBlock for Play {
        fn block<B: Block>(&mut self) {
            let file = folder(B::TABLE.name).join("clauses.txt");
            let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            let runs = runs(&text);
            let failed = runs.iter().filter_map(|run| Some((run, run.as_documented::<B>().play::<B>().err()?)));
            let wrong = failed.map(|(run, error)| format!("{}: {}: {error}", B::TABLE.name, run.title)).collect();
            self.0.push(Played { table: B::TABLE, runs, wrong });
        }
    }
    let mut play = Play(Vec::new());
    for_each_block(&mut play);
    assert!(play.0.len() >= 5);
    play.0
}

#[test]
fn every_block_does_what_its_tape_says() {
    let wrong: Vec<_> = played().into_iter().flat_map(|block| block.wrong).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_clause_and_every_run_of_the_documentation_has_a_test() {
    for Played { table, runs, .. } in played() {
        let name = table.name;
        let has_run = |heading: &str| runs.iter().any(|run| run.title.starts_with(heading));
        let tests = fs::read_to_string(folder(name).join("tests.rs")).unwrap_or_default();
        let clauses = table.docs.split("# Clauses\n").nth(1).unwrap_or("").split("\n# ").next().unwrap_or("");
        for number in clauses.lines().filter_map(|line| line.split_once(". ")?.0.trim().parse::<usize>().ok()) {
            let is_tested = has_run(&format!("{number}. ")) || tests.contains(&format!("fn clause_{number}_"));
            assert!(is_tested, "{name}: clause {number} is neither on the tape nor in tests.rs");
        }
        for (word, count) in [("Response", table.responses.len()), ("Characteristic", table.characteristics.len())] {
            for heading in (1..=count).map(|number| format!("{word} {number}. ")) {
                assert!(has_run(&heading), "{name}: the tape has no case {heading:?}");
            }
        }
    }
}
