//! Problems in files, with their locations.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;

/// A location in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextPosition {
    /// The 1-based line number.
    pub line: usize,
    /// The 1-based column, in characters.
    pub column: usize,
    /// The byte range in the file's text ([`crate::Source::text`]), to be underlined.
    pub span: Range<usize>,
}

/// An error or remark for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Its location; `None` if it concerns the whole file, or a file that is not text.
    pub place: Option<TextPosition>,
    /// One sentence, without a full stop, on what was found and what was expected.
    pub message: String,
    /// The remedy, unless the message contains it.
    pub help: Option<Remedy>,
}

/// A remedy. Where the command has an option, the page has a field: [`fmt::Display`] uses the wording of the command,
/// and the page has its own.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Remedy {
    /// A sentence that applies to both the command and the page.
    Sentence(String),
    /// Choose the block of a loop from these.
    ChooseBlock(String),
    /// Choose this block if it is the intended one: it has these members.
    ChooseThisBlock(String),
    /// Declare a constant with this name.
    DeclareConstant(String),
    /// Declare an instance with this name.
    DeclareInstance(String),
    /// List all undeclared names, of which the message contains only some.
    ListMissing,
    /// Use only the interface of this block, of which the source contains no statements.
    Stub(String),
    /// Declare a tag of this type, or a constant.
    DeclareTag {
        /// Its name.
        name: String,
        /// Its type.
        of: String,
    },
}

impl fmt::Display for Remedy {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Remedy::Sentence(text) => formatter.write_str(text),
            Remedy::ChooseBlock(blocks) => write!(formatter, "specify it with --block (available: {blocks})"),
            Remedy::ChooseThisBlock(block) => {
                write!(formatter, "if it is {block}, which has the same members, specify --block {block}")
            }
            Remedy::DeclareConstant(name) => write!(formatter, "--constant {name}=5 declares it"),
            Remedy::DeclareInstance(name) => {
                write!(formatter, "name the block it is an instance of: --instance \"{name} : Block\"")
            }
            Remedy::ListMissing => {
                formatter.write_str("plcfmu check --assume lists them all, with the declarations their use implies")
            }
            Remedy::Stub(name) => {
                write!(formatter, "ask its author for the source, or use only its interface with --stub {name}")
            }
            Remedy::DeclareTag { name, of } => {
                write!(formatter, "--tag \"{name} : {of}\" makes it an input or output, --constant {name}=5 a constant")
            }
        }
    }
}

impl From<String> for Remedy {
    fn from(text: String) -> Remedy {
        Remedy::Sentence(text)
    }
}

impl From<&str> for Remedy {
    fn from(text: &str) -> Remedy {
        text.to_string().into()
    }
}

/// The problems in a file, or the remarks on it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems {
    /// The file's name, as the user gave it.
    pub file: String,
    /// The file's text, for displaying locations; empty if it is not text.
    pub text: String,
    /// The problems, in file order.
    pub problems: Vec<Problem>,
}

impl Problems {
    /// A problem as one line, `FILE:LINE:COLUMN: message; help`.
    fn line(&self, problem: &Problem) -> String {
        let place = match problem.place {
            Some(TextPosition { line, column, .. }) => format!("{line}:{column}:"),
            None => String::new(),
        };
        let help = problem.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
        format!("{}:{place} {}{help}", self.file, problem.message)
    }
}

impl fmt::Display for Problems {
    /// Displays a line for each problem, `FILE:LINE:COLUMN: message`.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let lines: Vec<String> = self.problems.iter().map(|problem| self.line(problem)).collect();
        formatter.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for Problems {}

/// The problems for a terminal: the line of each as [`Problems`] displays it, followed by the line of the file with the
/// location underlined.
///
/// ```
/// # use parameters::{Problem, Problems, Source, problem};
/// let source = Source::new("plant.awl", b"BEGIN\n  GAIN := T#20S;\n".to_vec());
/// let message = "GAIN: expected a REAL, found `T#20S`".to_string();
/// let problem = Problem { place: Some(source.place(16..21)), message, help: None };
/// let problems = Problems { file: source.file, text: source.text, problems: vec![problem] };
/// assert_eq!(problem::drawn(&problems), "\
/// plant.awl:2:11: GAIN: expected a REAL, found `T#20S`
///   |
/// 2 |   GAIN := T#20S;
///   |           ^^^^^
/// ");
/// ```
pub fn drawn(problems: &Problems) -> String {
    each_drawn(problems).collect()
}

/// Like [`drawn`], one string per problem.
pub fn each_drawn(problems: &Problems) -> impl Iterator<Item = String> {
    problems.problems.iter().map(|problem| {
        let place = problem.place.as_ref().filter(|_| !problems.text.is_empty());
        format!(
            "{}\n{}",
            problems.line(problem),
            place.map_or_else(String::new, |place| underlined(&problems.text, place))
        )
    })
}

/// The line of a location, with the location underlined.
fn underlined(text: &str, place: &TextPosition) -> String {
    /// The number of bytes of a long line that are displayed before and after the location.
    const AROUND: usize = 60;
    let start = text.floor_char_boundary(place.span.start);
    let end = text.floor_char_boundary(place.span.end);
    // The search for the line's ends is limited, because a line may be as long as 100 MB.
    let first = text.floor_char_boundary(start.saturating_sub(AROUND));
    let last = text.ceil_char_boundary(start + AROUND);
    let from = text[first..start].rfind('\n').map_or(first, |newline| first + newline + 1);
    let to = text[start..last].find('\n').map_or(last, |newline| start + newline);
    let line = text[from..to].trim_end_matches('\r');
    let span = start - from..(end.clamp(start, to) - from).min(line.len()).max(start - from);
    let snippet = Snippet::source(line).line_start(place.line).annotation(AnnotationKind::Primary.span(span));
    let drawing = Renderer::plain().render(&[Group::with_level(Level::ERROR).element(snippet)]);
    drawing + "\n"
}

/// The candidate most similar to a name, if it is similar enough to be meant.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// No name of a block or member is longer.
    const LONGEST: usize = 60;
    if name.len() > LONGEST {
        return None;
    }
    let name = name.to_uppercase();
    candidates
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(&name, &candidate.to_uppercase()), candidate))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, candidate)| *distance <= candidate.chars().count().min(name.chars().count()) / 3)
        .map(|(_, candidate)| candidate)
}

/// A noun or the name of a PLC type with its article: an input, a REAL, an INT, an LREAL, an S5TIME.
///
/// ```
/// let spoken = ["input", "REAL", "UINT", "ARRAY[1..3] OF INT", "LREAL", "\"Pair\""].map(parameters::problem::with_article);
/// assert_eq!(spoken, ["an input", "a REAL", "a UINT", "an ARRAY[1..3] OF INT", "an LREAL", "a \"Pair\""]);
/// ```
pub fn with_article(noun: impl fmt::Display) -> String {
    let noun = noun.to_string();
    // The L of LREAL and LINT and the S of S5TIME are pronounced as letters.
    let is_an = noun.starts_with(['a', 'e', 'i', 'o', 'u', 'A', 'E', 'I', 'O', 'L']) || noun.starts_with("S5");
    format!("{} {noun}", if is_an { "an" } else { "a" })
}

/// A string in backquotes for a message: shortened, and with control characters escaped.
pub fn quoted(text: &str) -> String {
    const MOST_CHARACTERS: usize = 40;
    let mut shown: String = text.chars().take(MOST_CHARACTERS).flat_map(escaped).collect();
    if text.chars().nth(MOST_CHARACTERS).is_some() {
        shown.push_str("...");
    }
    format!("`{shown}`")
}

/// A control character as an escape sequence, any other unchanged.
fn escaped(character: char) -> Vec<char> {
    if character.is_control() { character.escape_default().collect() } else { vec![character] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Source;

    fn problems(text: &str, span: Range<usize>) -> Problems {
        let source = Source::new("a.awl", text.into());
        let problem =
            Problem { place: Some(source.place(span)), message: "wrong".into(), help: Some("mend it".into()) };
        Problems { file: source.file, text: source.text, problems: vec![problem] }
    }

    #[test]
    fn every_problem_has_a_line_with_file_line_and_column() {
        let mut problems = problems("ä\n  x", 5..6);
        problems.problems.push(Problem { place: None, message: "no loops".into(), help: None });
        assert_eq!(problems.to_string(), "a.awl:2:3: wrong; mend it\na.awl: no loops");
    }

    #[test]
    fn the_line_of_the_file_is_drawn_below_the_message() {
        let drawing = drawn(&problems("first\r\n\tGäIN = 5;\r\nlast", 14..15));
        assert_eq!(drawing, "a.awl:2:7: wrong; mend it\n  |\n2 |     GäIN = 5;\n  |          ^\n");
    }

    #[test]
    fn a_place_at_the_end_of_the_file_or_beyond_its_line_is_drawn() {
        assert!(drawn(&problems("a\nb", 3..3)).ends_with("2 | b\n  |  ^\n"));
        assert!(drawn(&problems("ab\ncd", 0..5)).ends_with("1 | ab\n  | ^^\n"));
        assert!(drawn(&problems("ab\r\ncd", 3..4)).contains("1 | ab\n"));
    }

    #[test]
    fn of_a_long_line_only_the_part_around_the_place_is_drawn() {
        let text = "x".repeat(100_000);
        let drawing = drawn(&problems(&text, 50_000..50_100));
        assert!(drawing.starts_with("a.awl:1:50001: "), "{drawing}");
        assert!(drawing.len() < 500, "{drawing}");
    }

    #[test]
    fn a_drawing_has_no_control_characters_of_the_file() {
        let drawing = drawn(&problems("\u{1b}[31mGAIN\u{7}\u{202e}", 5..9));
        assert!(!drawing.contains(['\u{1b}', '\u{7}', '\u{202e}']), "{drawing:?}");
        assert_eq!(quoted("\u{1b}[31m"), "`\\u{1b}[31m`");
    }
}
