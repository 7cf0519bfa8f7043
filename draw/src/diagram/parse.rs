//! Parses the description of a diagram. The documentation of [`super`] defines the language.

use super::model::{Anchor, Content, Control, Diagram, DrawnSetting, Element, GRID, Icon, Point, Shape, Side, Sign};
use super::symbol::{self, SYMBOLS};
use super::wire::{number, point};
use anyhow::{Context, Result, anyhow, bail};

/// The keywords at the start of a line.
const KEYWORDS: [&str; 9] = ["icon", "input", "output", "box", "sum", "switch", "text", "value", "frame"];

/// Parses a description. `start` returns the start value of a variable, on which the width of a box depends.
///
/// # Errors
/// A line has a syntax error or names an unknown element, or a wire does not fit. The error names the line, its text
/// and the remedy.
pub(super) fn parse(text: &str, start: impl Fn(&str) -> String) -> Result<Diagram> {
    let mut diagram = Diagram::default();
    let mut wires = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with("//") {
            continue;
        }
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if KEYWORDS.contains(&keyword) {
            diagram.add(number, keyword, rest).map_err(|error| wrong(number, line, &error))?;
        } else if line.contains('>') {
            wires.push((number, line));
        } else {
            let error = anyhow!(
                "begins with {keyword:?}: a line is a wire such as SP > SUM, or begins with {}",
                KEYWORDS.join(", ")
            );
            return Err(wrong(number, line, &error));
        }
    }
    for element in &mut diagram.elements {
        if let Shape::Box { settings, .. } = &mut element.shape {
            settings.iter_mut().for_each(|setting| setting.start = start(&setting.name));
        }
    }
    for (number, line) in wires {
        diagram.add_wires(number, line).map_err(|error| wrong(number, line, &error))?;
    }
    Ok(diagram)
}

/// The error of a line. The text of `error` continues the sentence whose subject is the line.
pub(super) fn wrong(number: usize, line: &str, error: &anyhow::Error) -> anyhow::Error {
    anyhow!("line {number} of the diagram, `{line}`, {error:#}")
}

/// Iterates over the words of a line; quotes keep words together.
struct Words<'a> {
    words: std::vec::IntoIter<&'a str>,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Result<Words<'a>> {
        let mut words = Vec::new();
        for (place, part) in text.split('"').enumerate() {
            if place % 2 == 1 {
                words.push(part);
            } else {
                words.extend(part.split_whitespace());
            }
        }
        if text.matches('"').count() % 2 == 1 {
            bail!("has an unclosed quote: put text between two quotes");
        }
        Ok(Words { words: words.into_iter() })
    }

    fn next(&mut self) -> Option<&'a str> {
        self.words.next()
    }

    fn need(&mut self, what: &str) -> Result<&'a str> {
        self.words.next().with_context(|| format!("ends too early: add {what}"))
    }

    fn point(&mut self) -> Result<Point> {
        let word = self.need("the position, such as 12,7")?;
        point(word).with_context(|| format!("has {word:?} instead of a position: write x,y, such as 12,7"))
    }

    fn end(&mut self) -> Result<()> {
        match self.words.next() {
            Some(word) => bail!("contains an unexpected {word:?}: remove it"),
            None => Ok(()),
        }
    }
}

impl Diagram {
    fn add(&mut self, line: usize, keyword: &str, rest: &str) -> Result<()> {
        let mut words = Words::new(rest)?;
        if keyword == "icon" {
            let word = words.need("the name of a symbol, or a short text in quotes")?;
            let is_text = rest.trim_start().starts_with('"');
            self.icon = Some(if is_text { Icon::Text(word.to_string()) } else { Icon::Symbol(symbol_of(word)?) });
            return words.end();
        }
        let name = match keyword {
            "text" | "frame" => "",
            _ => words.need("a name")?,
        };
        if let Some(other) = self.find(name).filter(|_| keyword != "value") {
            bail!("reuses the name {name} from line {}: choose another", self.elements[other].line);
        }
        let at = words.point()?;
        let shape = match keyword {
            "input" => Shape::Input,
            "output" => Shape::Output,
            "value" => Shape::Value,
            "box" => function(&mut words, rest)?,
            "sum" => sum(&mut words)?,
            "switch" => self.switch(&mut words, name)?,
            "text" => text(&mut words)?,
            _ => frame(&mut words)?,
        };
        words.end()?;
        self.elements.push(Element { line, name: name.to_string(), at, shape });
        Ok(())
    }

    fn switch(&self, words: &mut Words, name: &str) -> Result<Shape> {
        let word = words.need("TRUE upper or TRUE lower: the contact for TRUE")?;
        let true_is_upper = match (word, words.next()) {
            ("TRUE", Some("upper")) => true,
            ("TRUE", Some("lower")) => false,
            _ => bail!("does not specify the contact for TRUE: write TRUE upper or TRUE lower after the position"),
        };
        let mut variable = name.to_string();
        let mut constant = None;
        let mut control = Control::Above;
        while let Some(word) = words.next() {
            match word {
                "constant" => {
                    const WHAT: &str = "the contact and its value, such as constant FALSE 0.0";
                    let is_true = match words.need(WHAT)? {
                        "TRUE" => true,
                        "FALSE" => false,
                        other => {
                            bail!("has {other:?} after 'constant': write the contact, TRUE or FALSE, and the value")
                        }
                    };
                    constant = Some((is_true, words.need(WHAT)?.to_string()));
                }
                "by" => variable = words.need("the variable that controls it")?.to_string(),
                "below" => control = Control::Below,
                _ => bail!("contains an unexpected {word:?}: only constant, by or below may follow"),
            }
        }
        if self.elements.iter().any(|element| element.variable() == Some(&variable)) {
            control = Control::Elsewhere;
        }
        Ok(Shape::Switch { variable, true_is_upper, constant, control })
    }
}

fn symbol_of(name: &str) -> Result<&'static symbol::Symbol> {
    symbol::named(name).with_context(|| {
        let names: Vec<&str> = SYMBOLS.iter().map(|symbol| symbol.name).collect();
        format!("uses the unknown symbol {name:?}: choose one of {}, or put text in quotes", names.join(", "))
    })
}

fn function(words: &mut Words, rest: &str) -> Result<Shape> {
    let mut first = vec![words.need("a symbol, texts in quotes, or 'in' and the pins of an inner block")?];
    let mut with = None;
    while let Some(word) = words.next() {
        if word == "with" {
            with = Some(words.words.by_ref().map(str::to_string).collect::<Vec<_>>());
        } else {
            first.push(word);
        }
    }
    let texts = |words: &[&str]| words.iter().map(|word| word.to_string()).collect();
    let content = match first.as_slice() {
        lines if rest.contains('"') => Content::Lines(texts(lines)),
        ["in", pins @ ..] => {
            let out = pins.iter().position(|word| *word == "out").unwrap_or(pins.len());
            let outputs = pins.get(out + 1..).unwrap_or_default();
            Content::Pins { inputs: texts(&pins[..out]), outputs: texts(outputs) }
        }
        [symbol] => Content::Symbol(symbol_of(symbol)?),
        [symbol, word, ..] => {
            symbol_of(symbol)?;
            bail!("contains an unexpected {word:?}: write 'with' before the variables that act on the box");
        }
        [] => bail!("has no symbol: add one"),
    };
    if with.as_ref().is_some_and(Vec::is_empty) {
        bail!("ends with 'with': name the variables that act on the box, or remove the word");
    }
    let setting = |name| DrawnSetting { name, start: String::new() };
    Ok(Shape::Box { content, settings: with.unwrap_or_default().into_iter().map(setting).collect() })
}

fn sum(words: &mut Words) -> Result<Shape> {
    let mut signs = Vec::new();
    while let Some(word) = words.next() {
        let side = Side::ALL.into_iter().find(|(name, _)| *name == word);
        let (name, side) =
            side.with_context(|| format!("has {word:?} where left, right, top or bottom is required"))?;
        let sign = match words.need("the sign, + or -")? {
            "+" => Sign::Plus,
            "-" => Sign::Minus,
            other => bail!("has {other:?} instead of a sign for {name}: write + or -"),
        };
        signs.push((side, sign));
    }
    if signs.len() < 2 {
        bail!("adds fewer than two signals: write the sign of each side, such as left + bottom -");
    }
    Ok(Shape::Sum { signs })
}

fn text(words: &mut Words) -> Result<Shape> {
    let text = words.need("the text in quotes")?.to_string();
    let anchor = match words.next() {
        None => Anchor::Start,
        Some("middle") => Anchor::Middle,
        Some("end") => Anchor::End,
        Some(other) => bail!("contains an unexpected {other:?}: only middle or end may follow a text"),
    };
    Ok(Shape::Text { text, anchor })
}

fn frame(words: &mut Words) -> Result<Shape> {
    let size = words.need("width and height, such as 30,20")?;
    let size = size.split_once(',').and_then(|(width, height)| Some((number(width)?, number(height)?)));
    let (width, height) = size.context("has no width and height after the position: write them as 30,20")?;
    let title = words.next().unwrap_or("").to_string();
    Ok(Shape::Frame { width: width * GRID, height: height * GRID, title })
}
