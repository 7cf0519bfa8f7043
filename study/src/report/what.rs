//! The section of the report on the study itself: the loop, how to repeat it, and the axes.

use super::{Report, printable, seen};
use crate::ran::{Ran, RanFmu, Set};
use crate::{Along, Axis, Correlation};
use modeldescription::digits::short;
use run::system::Value;
use std::fmt::Write as _;

/// The maximum number of values or rows listed for an axis.
const MOST_ROWS: usize = 40;

/// The loop that was run, and how to repeat it.
pub(super) struct RanPart<'a> {
    pub(super) of: &'a Ran,
    /// The time span and the steps.
    pub(super) span: String,
    /// The FMUs: name, model, version or tool, hash.
    pub(super) fmus: Vec<[String; 4]>,
    /// Whether any FMU declares a version or a tool.
    pub(super) has_versions: bool,
    pub(super) connections: Vec<String>,
    pub(super) settings: Vec<String>,
    pub(super) events: Vec<(String, String)>,
    /// The folder in which to run the commands, in words.
    pub(super) folder: String,
    pub(super) command: String,
    /// The command that records the curves of the main figure's worst run; empty if there is none.
    pub(super) curves: String,
    pub(super) fingerprint: &'a str,
}

impl<'a> RanPart<'a> {
    pub(super) fn new(report: &Report<'a>) -> RanPart<'a> {
        let ran = report.ran;
        let seconds = |value: f64| format!("{} s", short(value));
        let fmu = |of: &RanFmu| {
            let version =
                [&of.version, &of.tool].into_iter().flatten().map(String::as_str).collect::<Vec<_>>().join(", ");
            [&of.name, &of.model, &version, &of.sha256].map(|text| printable(text))
        };
        let event = |of: &Set| (seconds(of.time.unwrap_or_default()), seen(&of.text()));
        let file = format!("{}.toml", report.name);
        let mut command = format!("plcfmu study {}", quoted(&file));
        if let Some(fmus) = &ran.folder {
            let _ = write!(command, " --fmus {}", quoted(fmus));
        }
        if report.table.file.ends_with(".csv") {
            command += " --format csv";
        }
        let curves = report.main.and_then(|main| report.summary.figures[main].worst.first());
        let curves = curves.map_or_else(String::new, |run| format!("{command} --resume --curves {run}"));
        for (of, _) in report.verdicts {
            let _ = write!(command, " --expect {}", quoted(&of.text));
        }
        RanPart {
            of: ran,
            span: format!("from {} to {} in steps of {}", seconds(ran.start), seconds(ran.stop), seconds(ran.step)),
            fmus: ran.fmus.iter().map(fmu).collect(),
            has_versions: ran.fmus.iter().any(|of| of.version.is_some() || of.tool.is_some()),
            connections: ran.connections.iter().map(|(from, to)| printable(&format!("{from} → {to}"))).collect(),
            settings: ran.settings.iter().map(|of| seen(&of.text())).collect(),
            events: ran.events.iter().map(event).collect(),
            folder: printable(&format!("the folder of {file}")),
            command: printable(&command),
            curves: printable(&curves),
            fingerprint: report.fingerprint,
        }
    }
}

/// A word of a command, quoted for a shell where necessary.
fn quoted(text: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "._-/:=@%+,".contains(letter);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.into()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// A sentence that lists the correlations between axes; `None` if there are none.
pub(super) fn correlation_text(correlations: &[Correlation]) -> Option<String> {
    let one = |of: &Correlation| format!("{} and {} {}", of.variables[0], of.variables[1], short(of.rank));
    let all = correlations.iter().map(one).collect::<Vec<_>>().join(", ");
    (!all.is_empty()).then(|| printable(&format!("Rank correlations: {all}.")))
}

pub(super) struct AxisPart {
    pub(super) variables: String,
    pub(super) values: String,
    pub(super) when: String,
}

pub(super) fn is_sampled(along: &Along) -> bool {
    !matches!(along, Along::Values(_) | Along::Rows(_) | Along::Range { .. })
}

/// The description of an axis.
pub(super) fn axis_part(axis: &Axis) -> AxisPart {
    let value = |value: &Value| match value {
        Value::Boolean(value) => value.to_string(),
        Value::Whole(value) => value.to_string(),
        Value::Number(value) => short(*value),
    };
    let list = |values: &[Value]| values.iter().map(value).collect::<Vec<_>>().join(", ");
    let ends = |min: Option<f64>, max: Option<f64>| match (min, max) {
        (Some(min), Some(max)) => format!(", from {} to {}", short(min), short(max)),
        (Some(min), None) => format!(", at least {}", short(min)),
        (None, Some(max)) => format!(", at most {}", short(max)),
        (None, None) => String::new(),
    };
    let mut values = match &axis.along {
        Along::Values(values) if values.len() > MOST_ROWS => format!("{} values", values.len()),
        Along::Values(values) => list(values),
        Along::Rows(rows) if rows.len() > MOST_ROWS => format!("{} rows", rows.len()),
        Along::Rows(rows) => rows.iter().map(|row| format!("({})", list(row))).collect::<Vec<_>>().join(", "),
        Along::Range { from, to, count, logarithmic } => {
            let ratios = if *logarithmic { ", with equal ratios" } else { "" };
            format!("{count} values from {} to {}{ratios}", short(*from), short(*to))
        }
        Along::Uniform { min, max } => format!("uniform from {} to {}", short(*min), short(*max)),
        Along::Normal { mean, deviation, min, max } => {
            format!("normal, mean {}, deviation {}{}", short(*mean), short(*deviation), ends(*min, *max))
        }
        Along::LogNormal { median, deviation } => {
            format!("log-normal, median {}, standard deviation of the logarithm {}", short(*median), short(*deviation))
        }
        Along::Triangular { min, mode, max } => {
            format!("triangular from {} to {}, mode {}", short(*min), short(*max), short(*mode))
        }
    };
    if axis.whole {
        values.push_str(", whole numbers");
    }
    if axis.relative {
        values.push_str(", times the loop's value");
    }
    let when = axis.time.map_or_else(|| "from the start".into(), |time| format!("at {} s", short(time)));
    AxisPart { variables: printable(&axis.variables.join(", ")), values, when }
}
