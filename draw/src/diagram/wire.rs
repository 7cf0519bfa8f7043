//! Parses wires and routes them in the drawing.

use super::model::{CONTACT, Diagram, GRID, Point, Shape, Side};
use anyhow::{Context, Result, bail};

/// A wire from an element, or from a point on another wire, to an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wire {
    /// Its 1-based line number in the description.
    pub line: usize,
    /// The index of its signal in the diagram.
    pub signal: usize,
    /// Its start, corners and end.
    pub points: Vec<Point>,
    /// The element at its start; `None` if it branches off another wire.
    pub from: Option<usize>,
    /// The element at its end.
    pub to: usize,
    /// Whether it acts only in some states of the block.
    pub is_dashed: bool,
}

/// A word of a line that describes wires.
#[derive(Clone, Debug, PartialEq)]
enum Word<'a> {
    /// `PUMP`, `PUMP.top+1` or `PUMP.PIN`. With a pin, `name` is the whole word.
    End { name: &'a str, place: Option<Place<'a>> },
    /// `x12`
    ToX(f64),
    /// `y7`
    ToY(f64),
    /// `12,7`
    Branch(Point),
}

/// The point at which a wire connects to an element.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place<'a> {
    Side(Side, f64),
    Contact(bool),
    Pin(&'a str),
}

/// Parses `12,7` in grid units.
pub(super) fn point(text: &str) -> Option<Point> {
    let (x, y) = text.split_once(',')?;
    Some(Point { x: number(x)? * GRID, y: number(y)? * GRID })
}

/// Parses a number of grid units between -1000 and 1000.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite() && number.abs() <= 1000.0)
}

fn word(text: &str) -> Result<Word<'_>> {
    let corner = |axis: char| text.strip_prefix(axis).and_then(number).map(|number| number * GRID);
    if let Some(x) = corner('x') {
        return Ok(Word::ToX(x));
    }
    if let Some(y) = corner('y') {
        return Ok(Word::ToY(y));
    }
    if text.contains(',') {
        let branch = point(text).with_context(|| format!("{text} is not a point: write x,y, such as 12,7"))?;
        return Ok(Word::Branch(branch));
    }
    let dots = text.match_indices('.').map(|(dot, _)| (&text[..dot], place_of(&text[dot + 1..])));
    let (name, place) = dots.into_iter().find(|(_, place)| place.is_some()).unwrap_or((text, None));
    Ok(Word::End { name, place })
}

fn place_of(text: &str) -> Option<Place<'_>> {
    match text {
        "FALSE" => return Some(Place::Contact(false)),
        "TRUE" => return Some(Place::Contact(true)),
        _ => {}
    }
    let (side, offset) = match text.find(['+', '-']) {
        Some(sign) => (&text[..sign], number(&text[sign..])? * GRID),
        None => (text, 0.0),
    };
    let (_, side) = Side::ALL.into_iter().find(|(name, _)| *name == side)?;
    Some(Place::Side(side, offset))
}

impl<'a> Word<'a> {
    /// The same element without its place, so that the next wire starts at its right side.
    fn right(&self) -> Word<'a> {
        match self {
            Word::End { name, .. } => Word::End { name, place: None },
            other => other.clone(),
        }
    }
}

impl Diagram {
    /// Adds the wires described by a line: `A > B`, `A > x12 > B.top > C`, or `12,7 > C`, which branches off the wire
    /// at that point. The prefix `PV:` names the variable that they carry, and `dashed` makes them dashed.
    pub(super) fn add_wires(&mut self, line: usize, text: &str) -> Result<()> {
        let (is_dashed, text) = match text.strip_prefix("dashed ") {
            Some(text) => (true, text),
            None => (false, text),
        };
        let (name, path) = match text.split_once(':') {
            Some((name, path)) => (Some(name.trim()), path),
            None => (None, text),
        };
        let words = path.split('>').map(|text| word(text.trim())).collect::<Result<Vec<_>>>()?;
        let is_place = |word: &Word| matches!(word, Word::End { .. } | Word::Branch(_));
        if words.len() < 2 || !is_place(&words[0]) || !matches!(words[words.len() - 1], Word::End { .. }) {
            bail!("is not a wire from one element to another: write it as SP > SUM or SP > x12 > SUM.top");
        }
        let mut begin = 0;
        for end in 1..words.len() {
            match &words[end] {
                Word::End { .. } => {
                    // In the middle of a chain, the next wire starts at the element that the previous one entered.
                    let start = if begin == 0 { self.start(&words[0])? } else { self.start(&words[begin].right())? };
                    let wire = Wire { is_dashed, ..self.wire(line, start, &words[begin + 1..end], &words[end])? };
                    self.name(wire.signal, name)?;
                    self.wires.push(wire);
                    begin = end;
                }
                Word::Branch(_) => bail!("has a point in its middle: corners are written as x12 or y7"),
                Word::ToX(_) | Word::ToY(_) => {}
            }
        }
        Ok(())
    }

    /// The start of a wire, the element at this point (`None` at a branch), and the index of the wire's signal.
    fn start(&mut self, word: &Word) -> Result<(Point, Option<usize>, usize)> {
        if let Word::Branch(at) = word {
            let wire = self.wires.iter().find(|wire| passes(&wire.points, *at)).with_context(|| {
                let (x, y) = (at.x / GRID, at.y / GRID);
                format!(
                    "begins at {x},{y}, where no wire from a line above passes: correct the point, or move the line \
                     down"
                )
            })?;
            return Ok((*at, None, wire.signal));
        }
        let (element, place) = self.end(word)?;
        let at = self.meet(element, place.unwrap_or(Place::Side(Side::Right, 0.0)))?;
        if let Some(other) = self.wires.iter().find(|wire| wire.points[0] == at) {
            bail!(
                "begins where the wire on line {} begins: let it branch off that wire, as in {},{} > ...",
                other.line,
                at.x / GRID + 1.0,
                at.y / GRID
            );
        }
        self.signals.push(String::new());
        Ok((at, Some(element), self.signals.len() - 1))
    }

    fn wire(
        &self,
        line: usize,
        (start, from, signal): (Point, Option<usize>, usize),
        corners: &[Word],
        to: &Word,
    ) -> Result<Wire> {
        let (to, place) = self.end(to)?;
        let place = match (place, &self.elements[to].shape) {
            (Some(place), _) => place,
            (None, Shape::Switch { .. }) => {
                let name = &self.elements[to].name;
                bail!("ends at the switch {name}: specify the contact, {name}.FALSE or {name}.TRUE")
            }
            (None, _) => Place::Side(Side::Left, 0.0),
        };
        let is_upright = matches!(place, Place::Side(Side::Top | Side::Bottom, _));
        let points = route(start, corners, self.meet(to, place)?, is_upright)?;
        Ok(Wire { line, signal, points, from, to, is_dashed: false })
    }

    fn name(&mut self, signal: usize, name: Option<&str>) -> Result<()> {
        let Some(name) = name else { return Ok(()) };
        let known = &mut self.signals[signal];
        if !known.is_empty() && known != name {
            bail!("names the signal {name}, which a line above names {known}: keep only one of the names");
        }
        *known = name.to_string();
        Ok(())
    }

    fn end<'a>(&self, word: &Word<'a>) -> Result<(usize, Option<Place<'a>>)> {
        let Word::End { name, place } = word else { bail!("has a corner instead of an element") };
        if let Some(element) = self.find(name) {
            return Ok((element, *place));
        }
        if let Some((block, pin)) = name.rsplit_once('.')
            && let Some(element) = self.find(block)
        {
            return Ok((element, Some(Place::Pin(pin))));
        }
        let ends = self.elements.iter().filter(|element| element.has_wires());
        let names: Vec<&str> = ends.map(|element| element.name.as_str()).collect();
        bail!("names {name:?}, which no line describes; available: {}", names.join(", "))
    }

    fn meet(&self, element: usize, place: Place) -> Result<Point> {
        let element = &self.elements[element];
        let at = match place {
            Place::Side(side, offset) => element.side(side, offset),
            Place::Pin(pin) => element.pin(pin),
            Place::Contact(is_true) => {
                let contact = element.contact(is_true);
                contact.map(|y| Point { x: element.at.x - CONTACT.0, y })
            }
        };
        at.with_context(|| {
            let name = &element.name;
            if let Place::Pin(pin) = place {
                return format!(
                    "uses {name}.{pin}, which does not exist: an end is a pin, a side such as {name}.top, or a contact"
                );
            }
            match element.shape {
                Shape::Input => format!("does not connect to the right side of {name}: wires start at an input"),
                Shape::Output => format!("does not connect to the left side of {name}: wires end at an output"),
                Shape::Switch { .. } => {
                    format!("misuses {name}: write {name}.FALSE or {name}.TRUE for a contact, and {name} otherwise")
                }
                _ => format!("uses {name}, which has no contacts: write {name}, {name}.top or {name}.bottom"),
            }
        })
    }
}

/// The points of a wire from `start` via the corners to `end`. It ends vertically at the top or bottom of an element,
/// and horizontally elsewhere.
fn route(start: Point, corners: &[Word], end: Point, is_upright: bool) -> Result<Vec<Point>> {
    let mut points = vec![start];
    let mut at = start;
    for corner in corners {
        match corner {
            Word::ToX(x) => at.x = *x,
            Word::ToY(y) => at.y = *y,
            _ => bail!("has an element instead of a corner"),
        }
        points.push(at);
    }
    // After x12, the wire continues vertically; after y7, horizontally.
    if !is_same(at.x, end.x) && !is_same(at.y, end.y) {
        points.push(match corners.last() {
            Some(Word::ToX(_)) => Point { x: at.x, y: end.y },
            Some(Word::ToY(_)) => Point { x: end.x, y: at.y },
            _ if is_upright => Point { x: end.x, y: at.y },
            _ => at,
        });
    }
    points.push(end);
    points.dedup_by(|a, b| is_same(a.x, b.x) && is_same(a.y, b.y));
    let last = &points[points.len().saturating_sub(2)..];
    let fits = |[from, to]: [Point; 2]| if is_upright { is_same(from.x, to.x) } else { is_same(from.y, to.y) };
    if last.len() < 2 || !fits([last[0], last[1]]) {
        let (axis, middle) = if is_upright { ('y', (start.y + end.y) / 2.0) } else { ('x', (start.x + end.x) / 2.0) };
        bail!(
            "does not arrive {} at {},{} from {},{}: add a corner such as {axis}{}",
            if is_upright { "vertically" } else { "horizontally" },
            end.x / GRID,
            end.y / GRID,
            start.x / GRID,
            start.y / GRID,
            (middle / GRID).round(),
        );
    }
    Ok(points)
}

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() < 0.01
}

/// Whether a line through these points passes through `at`.
pub(super) fn passes(points: &[Point], at: Point) -> bool {
    points.windows(2).any(|ends| {
        let between = |a: f64, b: f64, x: f64| a.min(b) - 0.01 <= x && x <= a.max(b) + 0.01;
        between(ends[0].x, ends[1].x, at.x) && between(ends[0].y, ends[1].y, at.y)
    })
}
