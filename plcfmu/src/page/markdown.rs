//! Converts a block's Markdown documentation to HTML. LaTeX formulas become MathML.

use anyhow::{Context, Result, anyhow};
use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Storage, mathml};

/// The language of a fenced code block that contains a LaTeX formula.
const FORMULA: &str = "math";

/// The language of a fenced code block that contains a block diagram, which is drawn elsewhere on the page.
const DIAGRAM: &str = "diagram";

/// The language of a fenced code block that contains the machine-readable part of a block's dialog.
const DIALOG: &str = "dialog";

/// The documentation of a block, split at its headings.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Sections<'a> {
    /// Headings and texts, in order. The text before the first heading has an empty heading.
    sections: Vec<(&'a str, &'a str)>,
}

impl<'a> Sections<'a> {
    /// Splits Markdown at its first-level headings.
    pub(super) fn new(docs: &'a str) -> Sections<'a> {
        let mut sections = Vec::new();
        let (mut heading, mut begin, mut place, mut is_fenced) = ("", 0, 0, false);
        for line in docs.split_inclusive('\n') {
            let text = line.trim();
            is_fenced ^= text.starts_with("```");
            if let Some(title) = text.strip_prefix("# ").filter(|_| !is_fenced) {
                sections.push((heading, docs[begin..place].trim_matches('\n')));
                (heading, begin) = (title.trim(), place + line.len());
            }
            place += line.len();
        }
        sections.push((heading, docs[begin..].trim_matches('\n')));
        sections.retain(|(heading, text)| !heading.is_empty() || !text.is_empty());
        Sections { sections }
    }

    /// Removes the section with this heading and returns its text.
    pub(super) fn take(&mut self, heading: &str) -> Option<&'a str> {
        let place = self.sections.iter().position(|(own, _)| *own == heading)?;
        Some(self.sections.remove(place).1)
    }

    /// Removes and returns all remaining sections.
    pub(super) fn take_all(&mut self) -> Vec<(&'a str, &'a str)> {
        std::mem::take(&mut self.sections)
    }
}

/// Markdown as HTML. Variable names in `linked` become links to their anchors where they first occur in the text.
///
/// # Errors
/// A formula is not in the supported subset of LaTeX.
pub(super) fn html(markdown: &str, linked: &[&str]) -> Result<String> {
    let mut events = Vec::new();
    let mut fence: Option<(String, String)> = None;
    let (mut is_linked, mut is_code) = (!linked.is_empty(), false);
    let mut named = Vec::new();
    for event in Parser::new_ext(markdown, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(ref language)))
                if [FORMULA, DIAGRAM, DIALOG].contains(&&**language) =>
            {
                fence = Some((language.to_string(), String::new()));
            }
            Event::Text(ref text) if fence.is_some() => fence.iter_mut().for_each(|(_, code)| code.push_str(text)),
            Event::End(TagEnd::CodeBlock) if fence.is_some() => {
                if let Some((_, code)) = fence.take().filter(|(language, _)| language == FORMULA) {
                    events.push(Event::Html(formula(&code)?.into()));
                }
            }
            Event::Start(Tag::CodeBlock(_) | Tag::Link { .. }) | Event::End(TagEnd::CodeBlock | TagEnd::Link) => {
                is_linked = matches!(event, Event::End(_)) && !linked.is_empty();
                is_code = matches!(event, Event::Start(Tag::CodeBlock(_)));
                events.push(event);
            }
            Event::Text(ref text) if is_linked => events.extend(with_links(&shown(text), linked, &mut named)),
            Event::Text(ref text) if !is_code => events.push(Event::Text(shown(text).into())),
            other => events.push(other),
        }
    }
    let mut html = String::new();
    pulldown_cmark::html::push_html(&mut html, events.into_iter());
    // Wide lines scroll; the attribute makes them reachable from the keyboard.
    Ok(html.replace("<pre>", r#"<pre tabindex="0">"#))
}

/// Text for display: no line break between a number and its percent sign or unit, °C for degC, and m² for m2.
pub(super) fn shown(text: &str) -> String {
    const UNITS: [&str; 14] = ["%", "°C", "K", "s", "ms", "h", "rpm", "min", "m", "cm", "m²", "m³/h", "l/min", "bar"];
    let text = modeldescription::units::shown(text);
    let mut printed = String::with_capacity(text.len());
    for (place, character) in text.char_indices() {
        let unit = text[place..].strip_prefix(' ').map(|rest| {
            let end = rest.find(|one: char| !one.is_alphanumeric() && !"%°/".contains(one)).unwrap_or(rest.len());
            &rest[..end]
        });
        let is_unit = unit.is_some_and(|unit| UNITS.contains(&unit));
        let is_parted = is_unit && printed.ends_with(|before: char| before.is_ascii_digit());
        printed.push(if is_parted { '\u{a0}' } else { character });
    }
    printed
}

/// Turns variable names in a text into links, except those already in `named`.
fn with_links(text: &str, linked: &[&str], named: &mut Vec<String>) -> Vec<Event<'static>> {
    let is_in_name = |character: char| character.is_ascii_alphanumeric() || "_.".contains(character);
    let mut events = Vec::new();
    for piece in text.split_inclusive(|character| !is_in_name(character)) {
        // A dot that ends a sentence is not part of a name.
        let name = piece.trim_end_matches(|character| !is_in_name(character) || character == '.');
        if linked.contains(&name) && !named.iter().any(|before| before == name) {
            named.push(name.to_string());
            events.push(Event::InlineHtml(format!(r##"<a class="variable" href="#{name}">{name}</a>"##).into()));
            events.push(Event::Text(piece[name.len()..].to_string().into()));
        } else {
            events.push(Event::Text(piece.to_string().into()));
        }
    }
    events
}

/// A formula as MathML that scrolls if it is too wide.
fn formula(latex: &str) -> Result<String> {
    let latex = latex.split_whitespace().collect::<Vec<_>>().join(" ");
    let storage = Storage::new();
    let config = RenderConfig { display_mode: DisplayMode::Block, ..RenderConfig::default() };
    let mut events = Vec::new();
    for event in pulldown_latex::Parser::new(&latex, &storage) {
        events.push(event.map_err(|error| anyhow!("the formula {latex:?} is not LaTeX: {error}"))?);
    }
    let mut mathml = String::new();
    let events = events.into_iter().map(Ok::<_, std::convert::Infallible>);
    mathml::push_mathml(&mut mathml, events, config).with_context(|| format!("the formula {latex:?}"))?;
    let mathml = with_names(&mathml);
    Ok(format!("<div class=\"formula\" tabindex=\"0\" role=\"group\" aria-label=\"Formula\">{mathml}</div>\n"))
}

/// Turns variable names in a formula from text (`mtext`) into identifiers (`mi`): text counts as space, so a minus sign
/// next to it is set without spacing.
fn with_names(mathml: &str) -> String {
    let mut pieces = mathml.split("<mtext>");
    let mut named = pieces.next().unwrap_or_default().to_string();
    for (text, rest) in pieces.filter_map(|piece| piece.split_once("</mtext>")) {
        let is_name = text.chars().all(|one| one.is_ascii_uppercase() || one.is_ascii_digit() || one == '_');
        // A single letter would be set in italics.
        let (tag, upright) = if is_name { ("mi", " mathvariant=\"normal\"") } else { ("mtext", "") };
        named.push_str(&format!("<{tag}{upright}>{text}</{tag}>{rest}"));
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_in_a_formula_is_an_identifier_and_words_are_text() {
        let html = html("```math\n\\text{T_IN} - \\text{U} \\quad \\text{later}\n```", &[]).unwrap();
        let name = |name: &str| format!("<mi mathvariant=\"normal\">{name}</mi>");
        assert!(html.contains(&format!("{}<mo>−</mo>{}", name("T_IN"), name("U"))), "{html}");
        assert!(html.contains("<mtext>later</mtext>"), "{html}");
    }

    #[test]
    fn documentation_is_taken_apart_at_its_headings() {
        let docs = " First.\n\n # Algorithm\n\n ```text\n # no heading\n ```\n\n # Limits of use\n\n None.\n";
        let mut sections = Sections::new(docs);
        assert_eq!(sections.take("Algorithm"), Some(" ```text\n # no heading\n ```"));
        assert_eq!(sections.take("Algorithm"), None);
        assert_eq!(sections.take_all(), [("", " First."), ("Limits of use", " None.")]);
    }

    #[test]
    fn a_formula_is_mathml() {
        let html = html("```math\n\\frac{\\text{MTR_TM}}{2}\n```", &[]).unwrap();
        assert!(html.contains("<math") && html.contains("<mfrac>") && html.contains("MTR_TM"), "{html}");
    }

    #[test]
    fn a_number_stays_with_its_unit_and_degrees_have_their_sign() {
        assert_eq!(
            shown("30 % of 400 degC, 5 s of 20 and 3 sets, 0.2 m2, 10 l/min"),
            "30\u{a0}% of 400\u{a0}°C, 5\u{a0}s of 20 and 3 sets, 0.2\u{a0}m², 10\u{a0}l/min"
        );
        let html = html("X is 5 %:\n\n```text\nX = 5 % degC\n```", &["X"]).unwrap();
        assert!(html.contains("is 5\u{a0}%:") && html.contains("X = 5 % degC"), "{html}");
    }

    #[test]
    fn a_formula_that_is_wrong_is_named() {
        let error = html("```math\n\\frac{1}{\n```", &[]).unwrap_err();
        assert!(format!("{error:#}").starts_with(r#"the formula "\\frac{1}{" is not LaTeX: "#), "{error:#}");
    }

    #[test]
    fn diagrams_are_left_out_and_other_code_stays() {
        let html = html("a\n\n```diagram\nbox\n```\n\n```text\nPV = 1 < 2\n```", &["PV"]).unwrap();
        assert!(!html.contains("box"), "{html}");
        assert!(html.contains("<pre tabindex=\"0\"><code class=\"language-text\">PV = 1 &lt; 2"), "{html}");
    }

    #[test]
    fn names_of_variables_are_links_where_a_text_has_them_first() {
        let html = html("Above TI, as PI.GAIN. Not TITLE, TI.\n\nTI again.", &["TI", "PI.GAIN"]).unwrap();
        let link = |name: &str| format!(r##"<a class="variable" href="#{name}">{name}</a>"##);
        let (ti, gain) = (link("TI"), link("PI.GAIN"));
        assert_eq!(html, format!("<p>Above {ti}, as {gain}. Not TITLE, TI.</p>\n<p>TI again.</p>\n"));
    }
}
