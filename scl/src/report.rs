//! Errors and warnings about a program.

use crate::front::lexer::Span;
use parameters::{Problem, Problems, Remedy, Source};

/// The maximum number of errors kept for a program, and likewise of warnings.
const MOST: usize = 1000;

/// Errors and warnings found in the sources of a program.
#[derive(Debug, Default)]
pub struct Report {
    errors: Vec<Finding>,
    warnings: Vec<Finding>,
    /// Names for parts of a source, such as a block or a network, where line numbers are of little use.
    places: Vec<(Span, String)>,
}

/// An error or a warning.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Finding {
    span: Span,
    message: String,
    help: Option<Remedy>,
}

impl Report {
    /// Adds an error, which makes the program unusable, with an optional remedy in words.
    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.error_with(span, message, help.map(Remedy::from));
    }

    /// Adds an error with any kind of remedy.
    pub fn error_with(&mut self, span: Span, message: impl Into<String>, help: Option<Remedy>) {
        add(&mut self.errors, span, message.into(), help);
    }

    /// Adds a warning about something that the program's author may not expect.
    pub fn warning(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        add(&mut self.warnings, span, message.into(), help.map(Remedy::from));
    }

    /// Names this span: messages about it or any part of it are prefixed with the name of the innermost such place.
    pub fn locate(&mut self, span: Span, place: String) {
        self.places.push((span, place));
    }

    /// Discards the errors that start in this span.
    pub fn forget(&mut self, span: Span) {
        self.errors.retain(|finding| !span.holds(finding.span));
    }

    /// The first error that starts in this span.
    pub fn first_error(&self, span: Span) -> Option<&str> {
        let found = self.errors.iter().filter(|finding| span.holds(finding.span));
        found.min_by_key(|finding| finding.span.start).map(|finding| finding.message.as_str())
    }

    /// Whether there is an error.
    pub fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// The number of errors.
    pub fn errors(&self) -> usize {
        self.errors.len()
    }

    /// The errors and the warnings, by source.
    pub fn problems(mut self, sources: &[Source]) -> (Vec<Problems>, Vec<Problems>) {
        // Sorted like this, the innermost place around a finding is the last one that does not start after the finding
        // and does not end before it.
        self.places.sort_by_key(|(span, _)| (span.file, span.start, std::cmp::Reverse(span.end)));
        for finding in self.errors.iter_mut().chain(&mut self.warnings) {
            let before = self
                .places
                .partition_point(|(span, _)| (span.file, span.start) <= (finding.span.file, finding.span.start));
            let holds = |(span, _): &&(Span, String)| {
                span.file == finding.span.file && span.end >= finding.span.end.min(finding.span.start + 1)
            };
            if let Some((_, place)) = self.places[..before].iter().rev().take(MOST).find(holds) {
                finding.message = format!("{place}: {}", finding.message);
            }
        }
        (of_sources(&mut self.errors, sources), of_sources(&mut self.warnings, sources))
    }
}

fn add(findings: &mut Vec<Finding>, span: Span, message: String, help: Option<Remedy>) {
    if findings.len() < MOST {
        findings.push(Finding { span, message, help });
    }
}

fn of_sources(findings: &mut Vec<Finding>, sources: &[Source]) -> Vec<Problems> {
    findings.sort_unstable();
    findings.dedup();
    let of_source = |(file, source): (usize, &Source)| {
        let problems: Vec<Problem> = findings
            .iter()
            .filter(|finding| finding.span.file as usize == file)
            .map(|finding| Problem {
                place: Some(source.place(finding.span.range())),
                message: finding.message.clone(),
                help: finding.help.clone(),
            })
            .collect();
        (!problems.is_empty()).then(|| Problems { file: source.file.clone(), text: source.text.clone(), problems })
    };
    sources.iter().enumerate().filter_map(of_source).collect()
}
