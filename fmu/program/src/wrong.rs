//! The reasons why a program cannot be run.

use parameters::{Problems, problem};
use std::fmt;

/// The reason why a program cannot be run.
#[derive(Clone, Debug, PartialEq)]
pub enum Wrong {
    /// Errors in the sources.
    Sources(Vec<Problems>),
    /// The block to run cannot be determined: no block, or more than one, is left uncalled by the others, or the only
    /// such block cannot run on its own. The sources are otherwise correct.
    Choice {
        /// The names of the candidate blocks.
        blocks: Vec<String>,
        /// Warnings for the author.
        warnings: Vec<Problems>,
    },
    /// Anything else, as a sentence.
    Other(String),
}

impl From<String> for Wrong {
    fn from(what: String) -> Wrong {
        Wrong::Other(what)
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Wrong::Sources(problems) => {
                formatter.write_str(problems.iter().map(problem::drawn).collect::<String>().trim_end())
            }
            Wrong::Choice { blocks, .. } if blocks.is_empty() => formatter
                .write_str("the sources contain no block to run: neither a FUNCTION_BLOCK nor an ORGANIZATION_BLOCK"),
            Wrong::Choice { blocks, .. } if blocks.len() == 1 => write!(
                formatter,
                "{} cannot run on its own: its array parameters take their bounds from the caller; call it from another block",
                blocks[0]
            ),
            Wrong::Choice { blocks, .. } => write!(
                formatter,
                "several blocks are not called by any other: {}; choose the one to run",
                blocks.join(", ")
            ),
            Wrong::Other(what) => formatter.write_str(what),
        }
    }
}

impl std::error::Error for Wrong {}
