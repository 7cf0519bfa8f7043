//! From text to tree: parses each source of a program, in SCL, SIMATIC SD or SimaticML, into a [`Tree`] and reports
//! its errors. Any text yields a tree. The tree contains LAD and FBD networks twice: as graphs, and as the statements
//! into which [`ladder`](crate::ladder) translates them.

pub(crate) mod lexer;
pub(crate) mod parser;
mod simatic_ml;
pub(crate) mod simatic_sd;
pub(crate) mod syntax;

use crate::report::Report;
use parameters::Source;
use simatic_sd::Texts;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use syntax::Tree;

/// The format of a source that is recognized by its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Scl,
    /// A TIA Openness document in XML.
    SimaticMl,
}

impl Format {
    pub(crate) fn detect(text: &str) -> Format {
        if simatic_ml::is_it(text) { Format::SimaticMl } else { Format::Scl }
    }

    pub(crate) fn parse(self, text: &str, file: u32, report: &mut Report) -> Tree {
        match self {
            Format::Scl => parser::parse(text, file, report),
            Format::SimaticMl => simatic_ml::parse(text, file, report),
        }
    }
}

/// Parses sources. SIMATIC SD documents and their text files are recognized by file extension, all others by content.
pub(crate) fn trees(sources: &[Source], report: &mut Report) -> Vec<Tree> {
    let mut texts: HashMap<PathBuf, Texts> = HashMap::new();
    for (file, source) in sources.iter().enumerate().filter(|(_, source)| ends_in(source, "s7res")) {
        texts.insert(Path::new(&source.file).with_extension(""), Texts::read(&source.text, file as u32, report));
    }
    let none = Texts::default();
    let tree = |(file, source): (usize, &Source)| match source {
        _ if ends_in(source, "s7res") => Tree::default(),
        _ if ends_in(source, "s7dcl") => {
            let texts = texts.get(&Path::new(&source.file).with_extension("")).unwrap_or(&none);
            simatic_sd::parse(&source.text, file as u32, texts, report)
        }
        _ => Format::detect(&source.text).parse(&source.text, file as u32, report),
    };
    sources.iter().enumerate().map(tree).collect()
}

fn ends_in(source: &Source, ending: &str) -> bool {
    Path::new(&source.file).extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}
