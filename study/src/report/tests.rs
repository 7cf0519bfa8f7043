use super::*;
use crate::Study;
use crate::junit;
use crate::ran::{RanFmu, Set};
use crate::results::RunResult;
use serde_json::{Value as Json, json};
use std::fs;

/// A small study with everything that a report needs.
pub(crate) struct Sample {
    job: Job,
    table: RunsTable,
    signals: Signals,
    pub(crate) results: Results,
    summary: Summary,
    verdicts: Vec<(Expectation, Verdict)>,
    curves: Vec<(u64, Recording)>,
    ran: Ran,
}

fn quantity(name: &str, unit: &str) -> Quantity {
    Quantity::new(name, Some(unit).filter(|unit| !unit.is_empty()))
}

fn set(variable: &str, value: &str, time: Option<f64>) -> Set {
    Set { variable: variable.into(), value: value.into(), unit: Some("degC".into()), time }
}

/// A recording of three calls.
pub(crate) fn recording(top: f64) -> Recording {
    let column = |name: &str, unit: &str| json!({"name": name, "unit": unit, "kind": "Real", "is_input": false, "source": [0, 0], "is_before_step": false, "is_unread": false});
    let columns = [column("PID.SP", "degC"), column("HEATER.TEMP", "degC"), column("PID.LMN", "%")];
    let values = [60.0, 20.0, 90.0, 60.0, top, 40.0, 60.0, 60.0, 35.0];
    serde_json::from_value(json!({"columns": columns, "times": [0.0, 1.0, 2.0], "values": values})).unwrap()
}

impl Sample {
    /// Creates four runs, one of which failed, with the given expectations.
    pub(crate) fn new(expected: &[&str]) -> Sample {
        let axis = |variable: &str, along: Along| Axis { variables: vec![variable.into()], along, ..Axis::default() };
        let axes = vec![
            axis("HEATER.GAIN", Along::Normal { mean: 2.5, deviation: 1.0, min: Some(1.0), max: None }),
            Axis { whole: true, ..axis("PID.TI", Along::Uniform { min: 5.0, max: 45.0 }) },
        ];
        let correlations = vec![Correlation { variables: ["HEATER.GAIN".into(), "PID.TI".into()], rank: 0.5 }];
        let coordinates = vec![quantity("HEATER.GAIN", "K/%"), quantity("PID.TI", "s")];
        let mut results = Results::new(coordinates, vec![quantity("overshoot", "%"), quantity("iae", "degC s")]);
        let error = Some("HEATER: it <broke>\u{1b}".to_string());
        let rows = [([4.0, 100.0], None), ([8.0, 300.0], None), ([f64::NAN; 2], error), ([12.0, 200.0], None)];
        for (run, (figures, error)) in rows.into_iter().enumerate() {
            let run = run as f64 + 1.0;
            results.push(&[run, 10.0 * run], &RunResult { figures: figures.to_vec(), error }).unwrap();
        }
        let expectation = |text: &&str| {
            let expectation = Expectation::parse(text, &results.figures).unwrap();
            let verdict = expectation.verdict(&results, false).unwrap();
            (expectation, verdict)
        };
        Sample {
            job: Job { study: Study { axes, correlations, samples: 4, seed: 7, ..Study::default() }, ..Job::default() },
            table: RunsTable { file: "runs.csv".into(), sha256: "4567".into() },
            signals: Signals {
                setpoint: Some("PID.SP".into()),
                process_value: Some("HEATER.TEMP".into()),
                manipulated_value: Some("PID.LMN".into()),
                pulses: None,
            },
            summary: Summary::new(&results, MOST_RUNS).unwrap(),
            verdicts: expected.iter().map(expectation).collect(),
            curves: vec![(1, recording(80.0)), (3, recording(65.0)), (0, recording(60.0))],
            ran: Ran {
                plcfmu: "9.8.7".into(),
                description: "furnace.toml".into(),
                stop: 3600.0,
                step: 1.0,
                fmus: vec![RanFmu {
                    name: "HEATER".into(),
                    model: "HEATER".into(),
                    version: Some("1.2".into()),
                    tool: Some("Modeller 3".into()),
                    sha256: "89ab".into(),
                }],
                folder: Some("../fmu".into()),
                settings: vec![set("PID.GAIN", "2", None)],
                events: vec![set("PID.SP", "60", Some(10.0))],
                connections: vec![("PID.LMN".into(), "HEATER.POWER".into())],
                ..Ran::default()
            },
            results,
        }
    }

    pub(crate) fn report(&self) -> Report<'_> {
        Report {
            name: "furnace <A>",
            job: &self.job,
            fingerprint: "0123",
            table: &self.table,
            signals: &self.signals,
            disturbances: &[],
            results: &self.results,
            summary: &self.summary,
            main: main_figure(&self.job, &self.results.figures).unwrap(),
            verdicts: &self.verdicts,
            curves: &self.curves,
            ran: &self.ran,
            envelope: None,
        }
    }
}

#[test]
fn the_main_figure_is_the_studys_else_iae_else_the_first() {
    let figures = [quantity("overshoot", "%"), quantity("iae", "K s")];
    let mut job = Job::default();
    assert_eq!(main_figure(&job, &figures).unwrap(), Some(1));
    assert_eq!(main_figure(&job, &figures[..1]).unwrap(), Some(0));
    assert_eq!(main_figure(&job, &[]).unwrap(), None);
    job.study.main = Some("overshoot".into());
    assert_eq!(main_figure(&job, &figures).unwrap(), Some(0));
    job.study.main = Some("overshot".into());
    let error = main_figure(&job, &figures).unwrap_err().to_string();
    assert_eq!(error, "main = \"overshot\": the study has no such figure; did you mean overshoot?");
    job.study.main = Some("x".into());
    let error = main_figure(&job, &figures).unwrap_err().to_string();
    assert_eq!(error, "main = \"x\": the study has no such figure; the figures are overshoot, iae");
}

#[test]
fn the_curves_are_those_of_the_worst_the_middle_and_the_best_run() {
    let sample = Sample::new(&[]);
    assert_eq!(curves_wanted(&sample.summary, Some(1)), [1, 3, 0]);
    assert_eq!(curves_wanted(&sample.summary, None), [0; 0]);
}

#[test]
fn the_command_prints_percentiles_failures_and_verdicts() {
    let text = text(&Sample::new(&["overshoot < 10 %", "p50(iae) < 1000"]).report()).unwrap();
    let expected = "\
furnace <A>: 4 runs, 1 failed
                  5 %  median  95 %  worst  run
  overshoot in %  4.4       8  11.6     12    3
  iae in degC s   110     200   290    300    1
  too few runs for 95 % confidence intervals
  failed: run 2: HEATER: it <broke>\u{fffd}
not met: overshoot < 10 %: 2 of 4 runs fail; worst: run 3: overshoot is 12 %
    50 % (15 to 85 %) of the runs meet it
    run 3: overshoot is 12 %
        HEATER.GAIN = 4 K/%, PID.TI = 40 s
    run 2: it failed: HEATER: it <broke>\u{fffd}
        HEATER.GAIN = 3 K/%, PID.TI = 30 s
met: p50(iae) < 1000
";
    assert_eq!(text, expected);
}

#[test]
fn runs_without_a_figure_are_counted_and_named() {
    let mut results = Results::new(Vec::new(), vec![quantity("settling", "s")]);
    for value in [1.0, f64::NAN, 3.0, f64::NAN, f64::NAN, f64::NAN, f64::INFINITY] {
        results.push(&[], &RunResult { figures: vec![value], error: None }).unwrap();
    }
    let summary = Summary::new(&results, MOST_RUNS).unwrap();
    let sample = Sample::new(&[]);
    let report = Report { results: &results, summary: &summary, ..sample.report() };
    assert_eq!(
        absent_texts(&report, 0).unwrap(),
        [
            "4 runs have no settling: runs 1, 3, 4 and 1 more",
            "1 run has an infinite settling, excluded from the statistics: run 6"
        ]
    );
}

#[test]
fn the_summary_for_programs_has_settings_by_name() {
    let sample = Sample::new(&["overshoot < 10 %"]);
    let summary: Json = serde_json::from_str(&json(&sample.report()).unwrap()).unwrap();
    let overshoot = &summary["figures"][0];
    assert_eq!(summary["runs"], 4);
    assert_eq!(summary["main"], "iae");
    assert_eq!(overshoot["percentiles"]["p50"], 8.0);
    assert_eq!(overshoot["correlations"]["PID.TI"], 1.0);
    let settings = json!({"HEATER.GAIN": 4.0, "PID.TI": 40.0});
    assert_eq!(overshoot["worst"][0], json!({"run": 3, "value": 12.0, "settings": settings}));
    let expectation = &summary["expectations"][0];
    assert_eq!((&expectation["met"], &expectation["count"]), (&json!(false), &json!(2)));
    assert_eq!(expectation["runs"][0], json!({"run": 3, "reason": "overshoot is 12 %", "settings": settings}));
    assert_eq!((&summary["loop"], &summary["fmus"][0]["sha256"]), (&json!("furnace.toml"), &json!("89ab")));
    assert_eq!(summary["axes"][1]["along"]["uniform"]["max"], 45.0);
    assert_eq!(summary["correlations"], json!([{"variables": ["HEATER.GAIN", "PID.TI"], "rank": 0.5}]));
}

#[test]
fn an_fmu_that_says_no_version_leaves_no_empty_column() {
    let mut sample = Sample::new(&[]);
    (sample.ran.fmus[0].version, sample.ran.fmus[0].tool) = (None, None);
    let page = html(&sample.report(), &[]).unwrap();
    assert!(page.contains("<td>HEATER</td><td>HEATER</td><td>89ab</td>") && !page.contains("Version"), "{page}");
}

#[test]
fn numbers_have_the_digits_of_their_spread_and_an_interval_those_of_its_width() {
    let mut results = Results::new(vec![quantity("P.A", "")], vec![quantity("travel", "%")]);
    for run in 0..100 {
        // From 144 to 153.9; the interval of the median is from the 40th to the 61st value.
        results
            .push(&[f64::from(run)], &RunResult { figures: vec![144.0 + f64::from(run) / 10.0 + 0.01234], error: None })
            .unwrap();
    }
    let summary = Summary::new(&results, 3).unwrap();
    let mut sample = Sample::new(&[]);
    sample.job.study.correlations.clear();
    let report = Report { results: &results, summary: &summary, main: Some(0), curves: &[], ..sample.report() };
    assert_eq!(intervals(&report)[0].1[1], "147.91 to 150.01");
    let lines = text(&report).unwrap();
    assert_eq!(number(&summary.figures[0], 150.0), "150");
    let narrow = Distribution { min: Some(179.9961), max: Some(179.9972), ..Distribution::default() };
    assert_eq!(number(&narrow, 179.99648), "179.996");
    assert!(lines.contains("travel in %  144.5     149  153.4  153.9   99"), "{lines}");
}

#[test]
fn the_page_shows_everything_and_loads_nothing() {
    let sample = Sample::new(&["overshoot < 10 %", "p50(iae) < 1000"]);
    let report = sample.report();
    let page = html(&report, &pictures(&report).unwrap().0).unwrap();
    for text in [
        "<title>furnace &lt;A&gt;</title>",
        "<p class=\"summary\">4 runs; 1 failed.</p>",
        "<td class=\"not-met\">not met</td>",
        "<td class=\"met\">met</td>",
        "HEATER: it &lt;broke&gt;\u{fffd}",
        "normal, mean 2.5, deviation 1, at least 1",
        "4 samples at random, seed 7.",
        "iae is 300 °C s (worst), 200 °C s (median), 100 °C s (best); 1 of 4 runs have none",
        "iae rises with HEATER.GAIN (0.50) and PID.TI (0.50)",
        "overshoot of 3 runs: 4 to 12 %",
        ">overshoot &lt; 10 %</text>",
        "furnace.toml, from 0 s to 3600 s in steps of 1 s",
        "PID.LMN → HEATER.POWER",
        "PID.GAIN = 2 °C",
        "at 10 s: PID.SP = 60 °C",
        "<a href=\"#figure-1\">iae in °C s</a>",
        "<td>HEATER</td><td>1.2, Modeller 3</td><td>89ab</td>",
        "produces the same bytes, in the folder of furnace &lt;A&gt;.toml, with: <code>plcfmu study &#39;furnace &lt;A&gt;.toml&#39; --fmus ../fmu \
         --format csv --expect",
        "furnace &lt;A&gt;.toml&#39; --fmus ../fmu --format csv --resume --curves 1</code>",
        "uniform from 5 to 45, whole numbers",
        "<p>Rank correlations: HEATER.GAIN and PID.TI 0.5.</p>",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert_eq!(page.matches("<svg ").count(), 4);
    for outside in ["http:", "https:", "src=", "@import"] {
        let own = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!own.contains(outside), "{outside}");
    }
    assert_eq!(page, html(&report, &pictures(&report).unwrap().0).unwrap());
}

#[test]
fn a_report_is_a_page_a_file_for_programs_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let sample = Sample::new(&[]);
    assert_eq!(write(folder.path(), &sample.report()).unwrap(), [""; 0]);
    for name in
        ["summary.json", "summary.html", "pictures/curves.svg", "pictures/curves.png", "pictures/histogram_iae.png"]
    {
        assert!(fs::metadata(folder.path().join(name)).unwrap().len() > 500, "{name}");
    }
    junit::write(&folder.path().join("junit.xml"), &sample.report()).unwrap();
}

#[test]
fn pictures_that_cannot_be_written_cost_nothing_but_themselves() {
    let folder = tempfile::tempdir().unwrap();
    // A file is at the path of the pictures' folder.
    fs::write(folder.path().join("pictures"), "").unwrap();
    let problems = write(folder.path(), &Sample::new(&[]).report()).unwrap();
    // Curves, the scatter plot and two histograms, each as SVG and PNG.
    assert_eq!(problems.len(), 8, "{problems:?}");
    assert!(problems[0].contains("curves.svg cannot be written: "), "{}", problems[0]);
    for name in ["summary.json", "summary.html"] {
        assert!(fs::metadata(folder.path().join(name)).unwrap().len() > 500, "{name}");
    }
}
