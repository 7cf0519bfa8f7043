//! Writes the verdicts on a study's expectations as JUnit XML, which CI servers show as tests.

use crate::report::{Report, listed, printable};
use anyhow::Result;
use askama::Template;
use host::package::temporary;
use std::io::Write;
use std::path::Path;

#[derive(Template)]
#[template(path = "junit.xml")]
struct Suite {
    name: String,
    cases: Vec<Case>,
    failures: usize,
}

/// A test case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name, such as the text of an expectation.
    pub name: String,
    /// The problem, in a sentence; `None` if the test has passed.
    pub problem: Option<String>,
    /// Details of the problem, such as the runs that caused it.
    pub text: String,
}

/// Writes a test for each expectation, and one that checks that no run ends with an error. A failure lists the first
/// ten runs that caused it, with their settings.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, report: &Report) -> Result<()> {
    let xml = xml(report)?;
    place(path, &xml)
}

/// Writes a test suite of these cases.
///
/// # Errors
/// The file cannot be written.
pub fn write_suite(path: &Path, name: &str, cases: Vec<Case>) -> Result<()> {
    place(path, &suite(name, cases)?)
}

fn place(path: &Path, xml: &str) -> Result<()> {
    temporary::place(path, |writer| Ok(writer.write_all(xml.as_bytes())?), |_| Ok(()))
}

fn suite(name: &str, cases: Vec<Case>) -> Result<String> {
    let failures = cases.iter().filter(|case| case.problem.is_some()).count();
    Ok(Suite { name: printable(name), cases, failures }.render()?)
}

/// The document.
fn xml(report: &Report) -> Result<String> {
    let results = report.results;
    let failed = results.errors.iter().map(|(run, error)| (*run, error.clone()));
    let problem = report.failure_text();
    let mut cases = vec![Case {
        name: "every run ends without an error".into(),
        problem,
        text: printable(&listed(results, results.errors.len(), failed)?),
    }];
    for (expectation, verdict) in report.verdicts {
        let runs = verdict.offending.iter().cloned();
        cases.push(Case {
            name: printable(&expectation.text),
            problem: verdict.problem.as_deref().map(printable),
            text: printable(&listed(results, verdict.count, runs)?),
        });
    }
    suite(report.name, cases)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::Sample;
    use std::fs;

    #[test]
    fn a_failure_names_the_runs_with_their_settings() {
        let sample = Sample::new(&["overshoot < 10 %", "p50(overshoot) < 20 %"]);
        let xml = xml(&sample.report()).unwrap();
        let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
            <testsuites tests=\"3\" failures=\"2\" errors=\"0\">\n\
            <testsuite name=\"furnace &lt;A&gt;\" tests=\"3\" failures=\"2\" errors=\"0\" skipped=\"0\">\n\
            <testcase classname=\"furnace &lt;A&gt;\" name=\"every run ends without an error\">\n\
            <failure message=\"1 of 4 runs failed: HEATER: it &lt;broke&gt;\u{fffd}\">run 2: HEATER: it &lt;broke&gt;\u{fffd}\n    HEATER.GAIN = 3 K/%, PID.TI = 30 s</failure>\n\
            </testcase>\n\
            <testcase classname=\"furnace &lt;A&gt;\" name=\"overshoot &lt; 10 %\">\n\
            <failure message=\"2 of 4 runs fail; worst: run 3: overshoot is 12 %\">run 3: overshoot is 12 %\n    HEATER.GAIN = 4 K/%, PID.TI = 40 s\n\
            run 2: it failed: HEATER: it &lt;broke&gt;\u{fffd}\n    HEATER.GAIN = 3 K/%, PID.TI = 30 s</failure>\n\
            </testcase>\n\
            <testcase classname=\"furnace &lt;A&gt;\" name=\"p50(overshoot) &lt; 20 %\"></testcase>\n\
            </testsuite>\n</testsuites>";
        assert_eq!(xml, expected);
    }

    #[test]
    fn a_long_list_of_runs_is_cut() {
        let text =
            listed(&Sample::new(&[]).results, 4, (0..4).cycle().take(12).map(|run| (run, "x".to_string()))).unwrap();
        assert_eq!(text.matches("run ").count(), 10);
        let text =
            listed(&Sample::new(&[]).results, 12, (0..4).cycle().take(12).map(|run| (run, "x".to_string()))).unwrap();
        assert!(text.ends_with("\nand 2 more"), "{text}");
    }

    #[test]
    fn the_file_is_well_formed_and_takes_the_place_of_an_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results/junit.xml");
        let sample = Sample::new(&["iae < 1"]);
        write(&path, &sample.report()).unwrap();
        write(&path, &sample.report()).unwrap();
        let xml = fs::read_to_string(&path).unwrap();
        // The XML parser of the SVG library reads any XML.
        let document = resvg::usvg::roxmltree::Document::parse(&xml).unwrap();
        let cases = document.descendants().filter(|node| node.has_tag_name("testcase"));
        let failed: Vec<bool> = cases.map(|case| case.children().any(|child| child.has_tag_name("failure"))).collect();
        assert_eq!(failed, [true, true]);
        assert_eq!(fs::read_dir(folder.path().join("results")).unwrap().count(), 1);
    }
}
