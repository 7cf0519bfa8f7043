//! The layout of a block diagram: elements with positions and sizes, and the wires between them.

use super::symbol::Symbol;
use super::wire::Wire;

/// The grid unit in pixels.
pub(super) const GRID: f64 = 10.0;
/// The width of a character in the 12-pixel monospaced font of terminals and titles.
pub(super) const CHARACTER: f64 = 12.0 * 0.602;
/// The width of a character in the 11-pixel font of settings, labels and values.
pub(super) const SMALL_CHARACTER: f64 = 11.0 * 0.602;
/// The width of a character in the 10-pixel font of contacts.
pub(super) const LABEL_CHARACTER: f64 = 10.0 * 0.602;
/// The height of a terminal.
pub(super) const TERMINAL: f64 = 18.0;
/// The space below a terminal for its value.
pub(super) const VALUE: f64 = 12.0;
/// The height of a box's title.
pub(super) const TITLE: f64 = 18.0;
/// Half the height of the part of a box that contains the symbol.
pub(super) const HALF_SYMBOL: f64 = 17.0;
/// The height of a setting in a box.
pub(super) const SETTING: f64 = 16.0;
/// The minimum space for a setting's value, in characters.
pub(super) const LEAST_VALUE: usize = 5;
/// The height of a line of text in a box.
pub(super) const LINE: f64 = 14.0;
/// The distance between pins of an inner block.
pub(super) const PIN: f64 = 20.0;
/// The radius of a summing point.
pub(super) const RADIUS: f64 = 9.0;
/// The horizontal and vertical distance from the middle of a switch to its contacts.
pub(super) const CONTACT: (f64, f64) = (20.0, 10.0);
/// The vertical distance from the middle of a switch to the terminal that controls it.
pub(super) const CONTROL: f64 = 36.0;

/// A position in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub x: f64,
    pub y: f64,
}

/// A rectangle of the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    pub(super) fn around(at: Point, width: f64, height: f64) -> Area {
        Area {
            left: at.x - width / 2.0,
            top: at.y - height / 2.0,
            right: at.x + width / 2.0,
            bottom: at.y + height / 2.0,
        }
    }

    /// Whether two areas overlap by more than a border.
    pub(super) fn overlaps(&self, other: &Area) -> bool {
        const BORDER: f64 = 0.6;
        self.left + BORDER < other.right
            && other.left + BORDER < self.right
            && self.top + BORDER < other.bottom
            && other.top + BORDER < self.bottom
    }
}

/// A block diagram.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Diagram {
    pub icon: Option<Icon>,
    pub elements: Vec<Element>,
    pub wires: Vec<Wire>,
    /// The names of the signals that the wires carry; empty for unnamed ones.
    pub signals: Vec<String>,
}

/// The icon of a block for small spaces.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Icon {
    Symbol(&'static Symbol),
    Text(String),
}

/// An element of the drawing; the shape determines which of its points is at `at`.
#[derive(Debug, PartialEq)]
pub(super) struct Element {
    /// Its 1-based line number in the description.
    pub line: usize,
    /// The name by which wires refer to it; empty if it cannot have wires.
    pub name: String,
    pub at: Point,
    pub shape: Shape,
}

/// The shape of an element.
#[derive(Debug, PartialEq)]
pub(super) enum Shape {
    /// An input terminal; `at` is the middle of its left edge.
    Input,
    /// An output terminal; `at` is the middle of its left edge.
    Output,
    /// A function; `at` is the middle of its symbol.
    Box { content: Content, settings: Vec<DrawnSetting> },
    /// A summing point with signs at its sides; `at` is its middle.
    Sum { signs: Vec<(Side, Sign)> },
    /// A switch; `at` is midway between its contacts.
    Switch { variable: String, true_is_upper: bool, constant: Option<(bool, String)>, control: Control },
    /// A text; `at` is the start, middle or end of its line.
    Text { text: String, anchor: Anchor },
    /// The name and value of a variable that is not a terminal; `at` is its left end.
    Value,
    /// A border around other elements; `at` is its upper left corner.
    Frame { width: f64, height: f64, title: String },
}

/// The contents of a box.
#[derive(Debug, PartialEq)]
pub(super) enum Content {
    Symbol(&'static Symbol),
    Lines(Vec<String>),
    /// The inputs and outputs of an inner block; wires connect to them by name.
    Pins {
        inputs: Vec<String>,
        outputs: Vec<String>,
    },
}

/// A variable that acts on a box.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DrawnSetting {
    pub name: String,
    /// Its start value; empty until the table is known.
    pub start: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Side {
    Left,
    Right,
    Top,
    Bottom,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sign {
    Plus,
    Minus,
}

/// The position of the terminal that controls a switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Control {
    Above,
    Below,
    /// The terminal belongs to another switch of the same variable.
    Elsewhere,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Side {
    pub(super) const ALL: [(&'static str, Side); 4] =
        [("left", Side::Left), ("right", Side::Right), ("top", Side::Top), ("bottom", Side::Bottom)];
}

/// The width of a monospaced text in pixels, given that of a character.
pub(super) fn width(text: &str, character: f64) -> f64 {
    text.chars().count() as f64 * character
}

fn even(width: f64) -> f64 {
    (width / GRID).ceil() * GRID
}

impl Element {
    /// The width in pixels of the terminal of a variable with this name.
    pub(super) fn terminal_width(name: &str) -> f64 {
        even(width(name, CHARACTER) + 15.0)
    }

    /// The areas of the drawing that no other element and no wire may cover.
    pub(super) fn areas(&self) -> Vec<Area> {
        let Point { x, y } = self.at;
        match &self.shape {
            Shape::Input | Shape::Output => vec![Area {
                left: x,
                top: y - TERMINAL / 2.0,
                right: x + Self::terminal_width(&self.name),
                bottom: y + TERMINAL / 2.0 + VALUE,
            }],
            Shape::Box { .. } => vec![self.body()],
            Shape::Sum { .. } => vec![Area::around(self.at, 2.0 * RADIUS, 2.0 * RADIUS)],
            Shape::Switch { constant, .. } => {
                let mut areas = vec![Area::around(self.at, 2.0 * CONTACT.0, 2.0 * CONTACT.1 + 6.0)];
                areas.extend(self.control().map(|at| {
                    let name = self.variable().unwrap_or_default();
                    Area::around(at, Self::terminal_width(name), TERMINAL)
                }));
                if let Some((is_true, text)) = constant {
                    let contact = self.contact(*is_true).unwrap_or(y);
                    let right = x - CONTACT.0;
                    let left = right - width(text, SMALL_CHARACTER) - 5.0;
                    areas.push(Area { left, top: contact - 6.0, right, bottom: contact + 6.0 });
                }
                areas
            }
            Shape::Text { text, anchor } => {
                let width = width(text, SMALL_CHARACTER);
                let left = match anchor {
                    Anchor::Start => x,
                    Anchor::Middle => x - width / 2.0,
                    Anchor::End => x - width,
                };
                vec![Area { left, top: y - 6.0, right: left + width, bottom: y + 6.0 }]
            }
            Shape::Value => {
                // The wire to which the value belongs may pass between name and value.
                let right = x + width(&self.name, SMALL_CHARACTER);
                vec![
                    Area { left: x, top: y - 15.0, right, bottom: y - 3.0 },
                    Area { left: x, top: y + 3.0, right, bottom: y + 15.0 },
                ]
            }
            Shape::Frame { .. } => Vec::new(),
        }
    }

    /// The rectangle of a box; for any other element, an empty area at `at`.
    pub(super) fn body(&self) -> Area {
        let Shape::Box { content, settings } = &self.shape else { return Area::around(self.at, 0.0, 0.0) };
        let row = |setting: &DrawnSetting| {
            let value = setting.start.chars().count().max(LEAST_VALUE) + 1;
            width(&setting.name, SMALL_CHARACTER) + value as f64 * SMALL_CHARACTER
        };
        let (inside, half) = match content {
            Content::Symbol(_) => (42.0, HALF_SYMBOL),
            Content::Lines(lines) => {
                let widest = lines.iter().map(|line| width(line, SMALL_CHARACTER)).fold(0.0, f64::max);
                (widest, (lines.len() as f64 * LINE / 2.0 + 4.0).max(HALF_SYMBOL))
            }
            Content::Pins { inputs, outputs } => {
                let widest =
                    |names: &[String]| names.iter().map(|name| width(name, SMALL_CHARACTER)).fold(0.0, f64::max);
                (widest(inputs) + widest(outputs) + 24.0, inputs.len().max(outputs.len()) as f64 * PIN / 2.0)
            }
        };
        let widest = settings.iter().map(row).fold(inside, f64::max).max(width(&self.name, CHARACTER));
        let half_width = even(widest + 12.0) / 2.0;
        let below = if settings.is_empty() { 0.0 } else { settings.len() as f64 * SETTING + 4.0 };
        Area {
            left: self.at.x - half_width,
            top: self.at.y - half - TITLE,
            right: self.at.x + half_width,
            bottom: self.at.y + half + below,
        }
    }

    /// Whether wires can start or end at the element.
    pub(super) fn has_wires(&self) -> bool {
        !matches!(self.shape, Shape::Text { .. } | Shape::Value | Shape::Frame { .. })
    }

    /// The variable that controls a switch.
    pub(super) fn variable(&self) -> Option<&str> {
        match &self.shape {
            Shape::Switch { variable, .. } => Some(variable),
            _ => None,
        }
    }

    /// The vertical position of a switch's contact for FALSE or TRUE.
    pub(super) fn contact(&self, is_true: bool) -> Option<f64> {
        match &self.shape {
            Shape::Switch { true_is_upper, .. } => {
                Some(self.at.y + if is_true == *true_is_upper { -CONTACT.1 } else { CONTACT.1 })
            }
            _ => None,
        }
    }

    /// The middle of the terminal that controls a switch.
    pub(super) fn control(&self) -> Option<Point> {
        let Shape::Switch { control, .. } = &self.shape else { return None };
        let away = match control {
            Control::Above => -CONTROL,
            Control::Below => CONTROL,
            Control::Elsewhere => return None,
        };
        Some(Point { x: self.at.x, y: self.at.y + away })
    }

    /// The point at which a wire connects to a pin of an inner block.
    pub(super) fn pin(&self, name: &str) -> Option<Point> {
        let Shape::Box { content: Content::Pins { inputs, outputs }, .. } = &self.shape else { return None };
        let area = self.body();
        let place = |names: &[String], x: f64| {
            let row = names.iter().position(|pin| pin == name)?;
            Some(Point { x, y: self.first_pin() + row as f64 * PIN })
        };
        place(inputs, area.left).or_else(|| place(outputs, area.right))
    }

    /// The vertical position of the uppermost pins.
    pub(super) fn first_pin(&self) -> f64 {
        self.body().top + TITLE + PIN / 2.0
    }

    /// The point at which a wire connects to this side of the element, `offset` pixels to the right of its middle or
    /// below it.
    pub(super) fn side(&self, side: Side, offset: f64) -> Option<Point> {
        let Point { x, y } = self.at;
        let area = match &self.shape {
            Shape::Box { .. } => self.body(),
            Shape::Sum { .. } => Area::around(self.at, 2.0 * RADIUS, 2.0 * RADIUS),
            Shape::Input if side == Side::Right && offset == 0.0 => {
                return Some(Point { x: x + Self::terminal_width(&self.name), y });
            }
            Shape::Output if side == Side::Left && offset == 0.0 => return Some(self.at),
            Shape::Switch { .. } if side == Side::Right && offset == 0.0 => return Some(Point { x: x + CONTACT.0, y }),
            _ => return None,
        };
        Some(match side {
            Side::Left => Point { x: area.left, y: y + offset },
            Side::Right => Point { x: area.right, y: y + offset },
            Side::Top => Point { x: x + offset, y: area.top },
            Side::Bottom => Point { x: x + offset, y: area.bottom },
        })
    }
}

impl Diagram {
    /// The variables shown in the diagram, each with its element; a variable that controls several switches is listed
    /// once.
    pub(super) fn terminals(&self) -> Vec<(&str, &Element)> {
        let mut terminals = Vec::new();
        for element in &self.elements {
            match &element.shape {
                Shape::Input | Shape::Output => terminals.push((element.name.as_str(), element)),
                Shape::Box { settings, .. } => {
                    terminals.extend(settings.iter().map(|setting| (setting.name.as_str(), element)));
                }
                Shape::Switch { variable, control, .. } if *control != Control::Elsewhere => {
                    terminals.push((variable, element));
                }
                _ => {}
            }
        }
        terminals
    }

    /// The index of the element with this name.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.elements.iter().position(|element| element.has_wires() && element.name == name)
    }
}
