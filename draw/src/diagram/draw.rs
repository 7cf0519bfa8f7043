//! Draws a checked diagram as SVG.

use super::check::{self, Checked};
use super::model::{
    self, Anchor, Area, CONTACT, Content, Control, Element, HALF_SYMBOL, LABEL_CHARACTER, LINE, PIN, Point, RADIUS,
    SETTING, Shape, Side, Sign, TERMINAL, TITLE, width,
};
use super::symbol::Symbol;
use super::wire::{Wire, passes};
use crate::svg::Pixels;
use askama::Template;
use std::fmt::Write;

/// The margin around the drawing, in pixels.
const MARGIN: f64 = 12.0;
/// The length and half the width of an arrowhead.
const HEAD: (f64, f64) = (8.0, 3.5);
/// The width of a terminal's slanted part.
const TIP: f64 = 7.0;

/// The drawing. Its colours are those for a light page; a page's style sheet can override them by class.
#[derive(Template)]
#[template(path = "diagram.svg")]
struct Drawing<'a> {
    name: &'a str,
    prefix: &'a str,
    is_linked: bool,
    left: Pixels,
    top: Pixels,
    width: Pixels,
    height: Pixels,
    frames: Vec<Frame<'a>>,
    signals: Vec<Signal<'a>>,
    boxes: Vec<Function<'a>>,
    sums: Vec<Sum>,
    switches: Vec<Switch<'a>>,
    terminals: Vec<Terminal<'a>>,
    texts: Vec<Text<'a>>,
    values: Vec<Value<'a>>,
}

struct Frame<'a> {
    area: Rectangle,
    title: &'a str,
    title_x: Pixels,
    title_y: Pixels,
}

struct Rectangle {
    x: Pixels,
    y: Pixels,
    width: Pixels,
    height: Pixels,
}

/// The wires of a signal.
struct Signal<'a> {
    name: &'a str,
    is_variable: bool,
    title: String,
    stroke_width: f64,
    path: String,
    /// The SVG path of its dashed wires.
    dashes: String,
    heads: String,
    /// The points where wires branch off.
    dots: Vec<(Pixels, Pixels)>,
}

struct Function<'a> {
    name: &'a str,
    meaning: &'a str,
    area: Rectangle,
    x: Pixels,
    y: Pixels,
    title_y: Pixels,
    /// The lines below the title and above the settings.
    lines: String,
    symbol: Option<&'static Symbol>,
    words: Vec<Word<'a>>,
    settings: Vec<Setting<'a>>,
}

/// A text in a box.
struct Word<'a> {
    x: Pixels,
    y: Pixels,
    anchor: &'static str,
    text: &'a str,
}

struct Setting<'a> {
    name: &'a str,
    title: String,
    start: &'a str,
    name_x: Pixels,
    value_x: Pixels,
    y: Pixels,
}

struct Sum {
    x: Pixels,
    y: Pixels,
    signs: Vec<(Pixels, Pixels, &'static str)>,
}

struct Switch<'a> {
    name: &'a str,
    id: String,
    title: String,
    /// The blade in each position, and whether that is the initial position.
    blades: [(&'static str, String, bool); 2],
    contacts: [(Pixels, Pixels); 3],
    labels: [(Pixels, Pixels, &'static str); 2],
    constant: Option<(Pixels, Pixels, &'a str)>,
    /// The line to the terminal that controls it.
    control: String,
}

struct Terminal<'a> {
    name: &'a str,
    title: String,
    class: &'static str,
    color: &'static str,
    path: String,
    x: Pixels,
    y: Pixels,
    value_y: Option<Pixels>,
    /// The start value of a setting.
    start: String,
}

struct Text<'a> {
    x: Pixels,
    y: Pixels,
    anchor: &'static str,
    text: &'a str,
}

struct Value<'a> {
    name: &'a str,
    title: String,
    x: Pixels,
    name_y: Pixels,
    value_y: Pixels,
}

/// Renders the drawing. All ids start with `prefix`; if `is_linked`, each variable links to the anchor with its name.
///
/// # Errors
/// The template cannot be rendered.
pub(super) fn svg(checked: &Checked, prefix: &str, is_linked: bool) -> anyhow::Result<String> {
    let elements = &checked.diagram.elements;
    let area = extent(checked);
    let mut drawing = Drawing {
        name: &checked.table.name,
        prefix,
        is_linked,
        left: Pixels(area.left),
        top: Pixels(area.top),
        width: Pixels(area.right - area.left),
        height: Pixels(area.bottom - area.top),
        frames: Vec::new(),
        signals: signals(checked),
        boxes: Vec::new(),
        sums: Vec::new(),
        switches: Vec::new(),
        terminals: Vec::new(),
        texts: Vec::new(),
        values: Vec::new(),
    };
    for element in elements {
        let Point { x, y } = element.at;
        match &element.shape {
            Shape::Input | Shape::Output => {
                let width = Element::terminal_width(&element.name);
                let middle = Point { x: x + width / 2.0, y };
                drawing.terminals.push(terminal(checked, &element.name, middle, flag(x, y, width), true));
            }
            Shape::Box { content, settings } => drawing.boxes.push(function(checked, element, content, settings)),
            Shape::Sum { signs } => drawing.sums.push(sum(element.at, signs)),
            Shape::Switch { .. } => {
                drawing.switches.push(switch(checked, element));
                if let (Some(at), Some(name)) = (element.control(), element.variable()) {
                    let area = Area::around(at, Element::terminal_width(name), TERMINAL);
                    let path = format!(
                        "M{} {}h{}v{}h{}z",
                        Pixels(area.left),
                        Pixels(area.top),
                        Pixels(area.right - area.left),
                        Pixels(TERMINAL),
                        Pixels(area.left - area.right)
                    );
                    drawing.terminals.push(terminal(checked, name, at, path, false));
                }
            }
            Shape::Text { text, anchor } => drawing.texts.push(Text {
                x: Pixels(x),
                y: Pixels(y + 4.0),
                anchor: match anchor {
                    Anchor::Start => "start",
                    Anchor::Middle => "middle",
                    Anchor::End => "end",
                },
                text,
            }),
            Shape::Value => drawing.values.push(Value {
                name: &element.name,
                title: title(checked, &element.name),
                x: Pixels(x),
                name_y: Pixels(y - 5.0),
                value_y: Pixels(y + 13.0),
            }),
            Shape::Frame { width, height, title } => drawing.frames.push(Frame {
                area: Rectangle { x: Pixels(x), y: Pixels(y), width: Pixels(*width), height: Pixels(*height) },
                title,
                title_x: Pixels(x + 8.0),
                title_y: Pixels(y + 15.0),
            }),
        }
    }
    Ok(drawing.render()?)
}

/// The area of everything drawn, including the margin.
fn extent(checked: &Checked) -> Area {
    let elements = &checked.diagram.elements;
    let mut areas: Vec<Area> = elements.iter().flat_map(Element::areas).collect();
    for element in elements {
        if let Shape::Frame { width, height, .. } = element.shape {
            let Point { x, y } = element.at;
            areas.push(Area { left: x, top: y, right: x + width, bottom: y + height });
        }
    }
    areas.extend(checked.diagram.wires.iter().flat_map(|wire| &wire.points).map(|at| Area::around(*at, 2.0, 2.0)));
    let outer = |get: fn(&Area) -> f64, best: fn(f64, f64) -> f64| areas.iter().map(get).reduce(best).unwrap_or(0.0);
    Area {
        left: outer(|area| area.left, f64::min).floor() - MARGIN,
        top: outer(|area| area.top, f64::min).floor() - MARGIN,
        right: outer(|area| area.right, f64::max).ceil() + MARGIN,
        bottom: outer(|area| area.bottom, f64::max).ceil() + MARGIN,
    }
}

fn signals<'a>(checked: &'a Checked) -> Vec<Signal<'a>> {
    let diagram = &checked.diagram;
    let is_boolean = booleans(checked);
    let mut signals: Vec<Signal> = Vec::new();
    for wire in &diagram.wires {
        let name = diagram.signals[wire.signal].as_str();
        let place = signals.iter().position(|signal| signal.name == name).unwrap_or_else(|| {
            let is_variable = checked.row(name).is_some();
            signals.push(Signal {
                name,
                is_variable,
                title: if is_variable { title(checked, name) } else { String::new() },
                // As in function block diagrams, a bit is a thin wire and a number a thick one.
                stroke_width: if is_boolean[wire.signal] { 1.0 } else { 1.8 },
                path: String::new(),
                dashes: String::new(),
                heads: String::new(),
                dots: Vec::new(),
            });
            signals.len() - 1
        });
        let signal = &mut signals[place];
        if wire.from.is_none() && branches(&diagram.wires, wire) {
            signal.dots.push((Pixels(wire.points[0].x), Pixels(wire.points[0].y)));
        }
        draw_wire(signal, wire, &diagram.elements[wire.to]);
    }
    signals
}

/// Whether each signal is Boolean: because it is named after a Boolean variable, or because a switch connects it to a
/// Boolean signal.
fn booleans(checked: &Checked) -> Vec<bool> {
    let diagram = &checked.diagram;
    let mut found: Vec<bool> = diagram.signals.iter().map(|name| checked.is_boolean(name)).collect();
    let is_switch = |element: usize| matches!(diagram.elements[element].shape, Shape::Switch { .. });
    // A Boolean propagates through one switch per iteration.
    for _ in 0..diagram.elements.len() {
        for element in (0..diagram.elements.len()).filter(|element| is_switch(*element)) {
            let wires = diagram.wires.iter().filter(|wire| wire.to == element || wire.from == Some(element));
            let signals: Vec<usize> = wires.map(|wire| wire.signal).collect();
            if signals.iter().any(|signal| found[*signal]) {
                signals.iter().for_each(|signal| found[*signal] = true);
            }
        }
    }
    found
}

/// Whether a wire starts on another one, from which it branches off.
fn branches(wires: &[Wire], wire: &Wire) -> bool {
    wires.iter().any(|other| !std::ptr::eq(other, wire) && passes(&other.points, wire.points[0]))
}

fn draw_wire(signal: &mut Signal, wire: &Wire, to: &Element) {
    let mut points = wire.points.clone();
    let [from, end] = points[points.len() - 2..] else { return };
    // The contact of a switch has a circle, everything else an arrow.
    let is_switch = matches!(to.shape, Shape::Switch { .. });
    let length = (end.x - from.x).abs().max((end.y - from.y).abs());
    let (dx, dy) = ((end.x - from.x) / length, (end.y - from.y) / length);
    let back = if is_switch { 3.0 } else { HEAD.0 - 1.0 };
    if let Some(last) = points.last_mut() {
        *last = Point { x: end.x - dx * back, y: end.y - dy * back };
    }
    let path = if wire.is_dashed { &mut signal.dashes } else { &mut signal.path };
    for (place, Point { x, y }) in points.iter().enumerate() {
        let _ = write!(path, "{}{} {}", if place == 0 { 'M' } else { 'L' }, Pixels(*x), Pixels(*y));
    }
    if !is_switch {
        let base = Point { x: end.x - dx * HEAD.0, y: end.y - dy * HEAD.0 };
        let _ = write!(
            signal.heads,
            "M{} {}L{} {}L{} {}z",
            Pixels(end.x),
            Pixels(end.y),
            Pixels(base.x - dy * HEAD.1),
            Pixels(base.y + dx * HEAD.1),
            Pixels(base.x + dy * HEAD.1),
            Pixels(base.y - dx * HEAD.1)
        );
    }
}

fn function<'a>(
    checked: &Checked,
    element: &'a Element,
    content: &'a Content,
    settings: &'a [model::DrawnSetting],
) -> Function<'a> {
    let Point { x, y } = element.at;
    let area = element.body();
    let head = area.top + TITLE;
    let (half, symbol, words) = match content {
        Content::Symbol(symbol) => (HALF_SYMBOL, Some(*symbol), Vec::new()),
        Content::Lines(lines) => {
            let first = y - (lines.len() as f64 - 1.0) * LINE / 2.0 + 4.0;
            let line = |(row, text): (usize, &'a String)| {
                let y = Pixels(first + row as f64 * LINE);
                Word { x: Pixels(x), y, anchor: "middle", text }
            };
            (y - head, None, lines.iter().enumerate().map(line).collect())
        }
        Content::Pins { inputs, outputs } => {
            let pins = |names: &'a [String], x: f64, anchor: &'static str| {
                let first = element.first_pin() + 4.0;
                let pin = move |(row, text): (usize, &'a String)| Word {
                    x: Pixels(x),
                    y: Pixels(first + row as f64 * PIN),
                    anchor,
                    text,
                };
                names.iter().enumerate().map(pin)
            };
            let words = pins(inputs, area.left + 5.0, "start").chain(pins(outputs, area.right - 5.0, "end"));
            (y - head, None, words.collect())
        }
    };
    let mut lines = format!("M{} {}H{}", Pixels(area.left), Pixels(head), Pixels(area.right));
    if area.bottom - (y + half) > 1.0 {
        let _ = write!(lines, "M{} {}H{}", Pixels(area.left), Pixels(y + half), Pixels(area.right));
    }
    let first_setting = area.bottom - settings.len() as f64 * SETTING + 10.0;
    let setting = |(row, setting): (usize, &'a model::DrawnSetting)| Setting {
        name: &setting.name,
        title: title(checked, &setting.name),
        start: &setting.start,
        name_x: Pixels(area.left + 6.0),
        value_x: Pixels(area.right - 6.0),
        y: Pixels(first_setting + row as f64 * SETTING),
    };
    Function {
        name: &element.name,
        meaning: symbol.map_or("", |symbol| symbol.meaning),
        area: rectangle(&area),
        x: Pixels(x),
        y: Pixels(y),
        title_y: Pixels(area.top + 13.0),
        lines,
        symbol,
        words,
        settings: settings.iter().enumerate().map(setting).collect(),
    }
}

fn sum(at: Point, signs: &[(Side, Sign)]) -> Sum {
    let sign = |(side, sign): &(Side, Sign)| {
        let (dx, dy) = match side {
            Side::Left => (-RADIUS - 6.0, -5.0),
            Side::Right => (RADIUS + 6.0, -5.0),
            Side::Top => (9.0, -RADIUS - 2.0),
            Side::Bottom => (10.0, RADIUS + 9.0),
        };
        let sign = if *sign == Sign::Plus { "+" } else { "\u{2212}" };
        (Pixels(at.x + dx), Pixels(at.y + dy), sign)
    };
    Sum { x: Pixels(at.x), y: Pixels(at.y), signs: signs.iter().map(sign).collect() }
}

fn switch<'a>(checked: &'a Checked, element: &'a Element) -> Switch<'a> {
    let Point { x, y } = element.at;
    let variable = element.variable().unwrap_or_default();
    let Shape::Switch { constant, control, true_is_upper, .. } = &element.shape else { unreachable!("it is a switch") };
    let is_on = checked.row(variable).is_some_and(|row| row.start() != 0.0);
    let (left, right) = (x - CONTACT.0 + 3.0, x + CONTACT.0 - 3.0);
    let contact = |is_true: bool| element.contact(is_true).unwrap_or(y);
    let blade =
        |is_true: bool| format!("M{} {}L{} {}", Pixels(right), Pixels(y), Pixels(left), Pixels(contact(is_true)));
    let label = |is_true: bool| {
        let at = contact(is_true);
        let text = if is_true { "TRUE" } else { "FALSE" };
        // The label ends before the wire from the control terminal, away from the number at the contact.
        let apart = if constant.as_ref().is_some_and(|(of, _)| *of == is_true) { 3.5 } else { 0.0 };
        let baseline = if at < y { at - 5.0 - apart } else { at + 12.5 + apart };
        (Pixels(x - 4.0 - width(text, LABEL_CHARACTER) / 2.0), Pixels(baseline), text)
    };
    let end = match control {
        Control::Above => element.control().map(|at| at.y + TERMINAL / 2.0),
        Control::Below => element.control().map(|at| at.y - TERMINAL / 2.0),
        Control::Elsewhere => {
            let is_before = |other: &&Element| other.line < element.line && other.variable() == Some(variable);
            checked.diagram.elements.iter().rfind(is_before).map(|other| other.at.y)
        }
    };
    Switch {
        name: variable,
        id: if *control == Control::Elsewhere { element.name.clone() } else { variable.to_string() },
        title: format!(
            "{}. TRUE: {} contact.",
            title(checked, variable),
            if *true_is_upper { "upper" } else { "lower" }
        ),
        blades: [("FALSE", blade(false), !is_on), ("TRUE", blade(true), is_on)],
        contacts: [
            (Pixels(left), Pixels(contact(false))),
            (Pixels(left), Pixels(contact(true))),
            (Pixels(right), Pixels(y)),
        ],
        labels: [label(false), label(true)],
        constant: constant
            .as_ref()
            .map(|(is_true, text)| (Pixels(x - CONTACT.0 - 4.0), Pixels(contact(*is_true) + 4.0), text.as_str())),
        control: end.map_or_else(String::new, |end| format!("M{} {}V{}", Pixels(x), Pixels(end), Pixels(y))),
    }
}

fn terminal<'a>(checked: &Checked, name: &'a str, middle: Point, path: String, has_value: bool) -> Terminal<'a> {
    let (class, color) = class(checked, name);
    Terminal {
        name,
        title: title(checked, name),
        class,
        color,
        path,
        x: Pixels(middle.x - if has_value { TIP / 2.0 } else { 0.0 }),
        y: Pixels(middle.y + 4.0),
        value_y: has_value.then_some(Pixels(middle.y + TERMINAL / 2.0 + 11.0)),
        start: check::start(checked.table, name),
    }
}

/// The outline of a terminal that points to the right.
fn flag(x: f64, y: f64, width: f64) -> String {
    let half = TERMINAL / 2.0;
    format!(
        "M{} {}h{}l{} {}l{} {}h{}z",
        Pixels(x),
        Pixels(y - half),
        Pixels(width - TIP),
        Pixels(TIP),
        Pixels(half),
        Pixels(-TIP),
        Pixels(half),
        Pixels(TIP - width)
    )
}

/// The CSS class of a variable, `signal` or `setting`, and its colour on a light page.
fn class(checked: &Checked, name: &str) -> (&'static str, &'static str) {
    use blocks::Role;
    match checked.row(name).map(|row| row.role) {
        Some(Role::Parameter | Role::Fixed | Role::Cycle) => ("setting", "#8a97a8"),
        _ => ("signal", "#1f3a5f"),
    }
}

fn title(checked: &Checked, name: &str) -> String {
    match checked.row(name) {
        Some(row) => format!("{name}: {}", row.description),
        None => name.to_string(),
    }
}

fn rectangle(area: &Area) -> Rectangle {
    Rectangle {
        x: Pixels(area.left),
        y: Pixels(area.top),
        width: Pixels(area.right - area.left),
        height: Pixels(area.bottom - area.top),
    }
}
