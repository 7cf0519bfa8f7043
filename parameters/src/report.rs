//! Collects a reader's findings: problems with locations, and origins of values.

use crate::block::BlockType;
use crate::loops::{Loop, Origin};
use crate::problem::{Problem, Problems, Remedy, TextPosition};
use crate::reading::{Options, Reading};
use crate::source::Source;
use std::ops::Range;
use std::sync::Arc;

/// The maximum number of loops in a file, so that a hostile file cannot exhaust memory.
pub(crate) const MOST_LOOPS: usize = 10_000;

/// The maximum number of problems reported for a file.
const MOST_PROBLEMS: usize = 50;

/// The problems and remarks of the file being read.
pub(crate) struct Report<'a> {
    source: &'a Source,
    problems: Vec<Problem>,
    remarks: Vec<Problem>,
    omitted: usize,
    is_partial: bool,
}

impl<'a> Report<'a> {
    pub(crate) fn new(source: &'a Source, options: &Options) -> Report<'a> {
        Report { source, problems: Vec::new(), remarks: Vec::new(), omitted: 0, is_partial: options.is_partial }
    }

    /// The number of problems, including those not reported.
    pub(crate) fn count(&self) -> usize {
        self.problems.len() + self.omitted
    }

    /// The line at which a range of the text starts.
    pub(crate) fn line(&self, span: Range<usize>) -> usize {
        self.source.place(span).line
    }

    /// The origin of a value in the text.
    pub(crate) fn origin(&self, span: Range<usize>) -> Origin {
        let TextPosition { line, column, span } = self.source.place(span);
        Origin::Text { file: self.source.file.clone(), line, column, span }
    }

    /// Reports an error at a location. The same error at the same location is reported only once.
    pub(crate) fn wrong(&mut self, span: Range<usize>, message: impl Into<String>, help: Option<String>) {
        self.wrong_with(span, message, help.map(Remedy::from));
    }

    /// As [`Report::wrong`], with a remedy of any kind.
    pub(crate) fn wrong_with(&mut self, span: Range<usize>, message: impl Into<String>, help: Option<Remedy>) {
        if self.problems.len() == MOST_PROBLEMS {
            self.omitted += 1;
            return;
        }
        let problem = Problem { place: Some(self.source.place(span)), message: message.into(), help };
        if !self.problems.contains(&problem) {
            self.problems.push(problem);
        }
    }

    /// Adds to the number of problems that are not reported.
    pub(crate) fn omit(&mut self, count: usize) {
        self.omitted += count;
    }

    /// Whether another problem would be reported, so that its message is worth composing.
    pub(crate) fn has_room(&self) -> bool {
        self.problems.len() < MOST_PROBLEMS
    }

    /// Whether there are problems.
    pub(crate) fn is_wrong(&self) -> bool {
        !self.problems.is_empty()
    }

    /// Reports a problem with the file as a whole.
    pub(crate) fn wrong_file(&mut self, message: impl Into<String>, help: Option<Remedy>) {
        self.problems.push(Problem { place: None, message: message.into(), help });
    }

    /// Adds a remark for the user, without a location if it concerns the file as a whole.
    pub(crate) fn remark(&mut self, span: Option<Range<usize>>, message: impl Into<String>) {
        if self.remarks.len() < MOST_PROBLEMS {
            let place = span.map(|span| self.source.place(span));
            self.remarks.push(Problem { place, message: message.into(), help: None });
        }
    }

    /// Returns the loops if there are no problems or if, with [`Options::is_partial`], some loops are correct;
    /// otherwise the problems.
    pub(crate) fn finish(mut self, loops: Vec<Loop>) -> Result<Reading, Problems> {
        if self.problems.is_empty() && loops.is_empty() {
            self.wrong_file("the file contains no loop", None);
        }
        self.problems.sort_by_key(|problem| problem.place.as_ref().map_or(usize::MAX, |place| place.span.start));
        if self.omitted > 0 {
            let message = format!("and {} more, not shown", self.omitted);
            self.problems.push(Problem { place: None, message, help: None });
        }
        let of = |problems: Vec<Problem>| {
            // The text, which may be large, is needed only to display the locations of problems.
            let text = if problems.is_empty() { String::new() } else { self.source.text.clone() };
            Problems { file: self.source.file.clone(), text, problems }
        };
        if self.problems.is_empty() || self.is_partial && !loops.is_empty() {
            Ok(Reading { loops, remarks: of(self.remarks), wrong: of(self.problems) })
        } else {
            Err(of(self.problems))
        }
    }

    /// The block named by the user; `None` if the user named none.
    ///
    /// # Errors
    /// No block has this name, which is reported.
    pub(crate) fn chosen(
        &mut self,
        blocks: &[Arc<BlockType>],
        options: &Options,
    ) -> Result<Option<Arc<BlockType>>, ()> {
        let Some(name) = &options.block else { return Ok(None) };
        if let Some(block) = blocks.iter().find(|block| block.is_called(name)) {
            return Ok(Some(block.clone()));
        }
        self.wrong_file(format!("no block is called {name:?}"), Some(format!("available: {}", list(blocks)).into()));
        Err(())
    }

    /// The name of a loop that the file does not name: [`Options::name`], or the file name without folder and
    /// extension.
    pub(crate) fn loop_name(&self, options: &Options) -> String {
        options.name.clone().unwrap_or_else(|| {
            let file = self.source.file.trim_end_matches(['/', '\\']);
            let file = file.rsplit(['/', '\\']).next().unwrap_or(file);
            file.rsplit_once('.').map_or(file, |(stem, _)| stem).to_string()
        })
    }
}

/// The indices of an array's elements, such as `[1,0]`, from its bounds `1..2, 0..7`; `None` if these are not numbers,
/// or if there are more elements than a file may have loops.
pub(crate) fn elements(bounds: &str) -> Option<Vec<String>> {
    let mut all = vec![String::new()];
    for dimension in bounds.split(',') {
        let (low, high) = dimension.split_once("..")?;
        let (low, high): (i64, i64) = (low.trim().parse().ok()?, high.trim().parse().ok()?);
        let count = usize::try_from(high.checked_sub(low)?.checked_add(1)?).ok()?;
        if count == 0 || all.len().checked_mul(count)? > MOST_LOOPS {
            return None;
        }
        let add = |before: &String| (low..=high).map(move |at| format!("{before},{at}")).collect::<Vec<_>>();
        all = all.iter().flat_map(add).collect();
    }
    Some(all.into_iter().map(|index| format!("[{}]", &index[1..])).collect())
}

/// The names of blocks, for a message.
pub(crate) fn list(blocks: &[Arc<BlockType>]) -> String {
    let names: Vec<&str> = blocks.iter().map(|block| block.name.as_str()).collect();
    names.join(", ")
}
