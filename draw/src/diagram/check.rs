//! Checks a diagram: it must show all terminals of the block, and its elements and wires must not overlap.

use super::model::{Area, Control, Diagram, Element, GRID, Point, Shape};
use super::parse::wrong;
use super::terminals_of;
use super::wire::passes;
use crate::text;
use anyhow::{Result, anyhow, bail};
use blocks::{Kind, Role};
use modeldescription::{Row, Table};

/// A diagram that matches its table.
pub(super) struct Checked<'a> {
    pub diagram: Diagram,
    pub table: &'a Table,
}

impl<'a> Checked<'a> {
    /// Checks a diagram with the description `source`, and names its signals.
    ///
    /// # Errors
    /// The diagram lacks a terminal or shows something else as one, or parts of it overlap. The error names the line
    /// and the remedy.
    pub(super) fn check(mut diagram: Diagram, source: &str, table: &'a Table) -> Result<Checked<'a>> {
        name_signals(&mut diagram);
        let checked = Checked { diagram, table };
        let at = |(line, what): (usize, String)| {
            let text = source.lines().nth(line - 1).unwrap_or_default().trim();
            wrong(line, text, &anyhow!(what))
        };
        checked.terminals().map_err(at)?;
        checked.connections().map_err(at)?;
        checked.overlaps().map_err(at)?;
        checked.crossings().map_err(at)?;
        checked.completeness()?;
        Ok(checked)
    }

    /// The variable with this name.
    pub(super) fn row(&self, name: &str) -> Option<&'a Row> {
        row(self.table, name)
    }

    /// Whether the variable is a Boolean.
    pub(super) fn is_boolean(&self, name: &str) -> bool {
        self.row(name).is_some_and(|row| row.kind == Kind::Bool)
    }

    /// Checks that every terminal of the diagram is in the table, is shown only once, and is an input or output as in
    /// the table.
    fn terminals(&self) -> Result<(), (usize, String)> {
        let table = &self.table.name;
        let terminals = self.diagram.terminals();
        for (place, (name, element)) in terminals.iter().enumerate() {
            let Some(row) = self.row(name) else {
                let what = format!("shows {name}, which {table} does not have: correct or remove it");
                return Err((element.line, what));
            };
            if let Some((_, other)) = terminals[..place].iter().find(|(other, _)| other == name) {
                return Err((
                    element.line,
                    format!("shows {name}, which line {} already shows: remove one of them", other.line),
                ));
            }
            let is_output = matches!(row.role, Role::Output | Role::Local);
            if is_output != matches!(element.shape, Shape::Output) {
                let role = row.role.name();
                let as_what =
                    if is_output { "on its own line, such as output NAME 12,7" } else { "as an input or in a box" };
                return Err((element.line, format!("shows {name}, which is {role} in the table: show it {as_what}")));
            }
        }
        let values = self.diagram.elements.iter().filter(|element| matches!(element.shape, Shape::Value));
        for element in values {
            if self.row(&element.name).is_none() {
                let what =
                    format!("shows the value of {}, which {table} does not have: correct or remove it", element.name);
                return Err((element.line, what));
            }
        }
        Ok(())
    }

    /// Checks that every terminal of the table is in the diagram.
    fn completeness(&self) -> Result<()> {
        let roles = [Role::Input, Role::Parameter, Role::Fixed, Role::Cycle, Role::Output];
        let shown = self.diagram.terminals();
        let is_missing = |row: &&Row| !shown.iter().any(|(name, _)| *name == row.name);
        let missing: Vec<_> =
            terminals_of(self.table, &roles).into_iter().filter(is_missing).map(|row| row.name.as_str()).collect();
        if !missing.is_empty() {
            bail!(
                "the diagram of {} does not show {}: add each as an input, an output, after the 'with' of a box, or as \
                 a switch",
                self.table.name,
                missing.join(", ")
            );
        }
        Ok(())
    }

    /// Checks that inputs and outputs have wires, and that all switches controlled by the same variable are in one
    /// column.
    fn connections(&self) -> Result<(), (usize, String)> {
        let Diagram { elements, wires, .. } = &self.diagram;
        for (place, element) in elements.iter().enumerate() {
            let is_loose = match element.shape {
                Shape::Input => !wires.iter().any(|wire| wire.from == Some(place)),
                Shape::Output => !wires.iter().any(|wire| wire.to == place),
                _ => false,
            };
            if is_loose {
                let name = &element.name;
                return Err((element.line, format!("has no wire: add one, such as {name} > SUM for an input")));
            }
            if let Shape::Switch { variable, control: Control::Elsewhere, .. } = &element.shape
                && let Some(first) = elements.iter().find(|other| other.variable() == Some(variable))
                && first.at.x != element.at.x
            {
                let (line, x) = (first.line, first.at.x / GRID);
                return Err((
                    element.line,
                    format!("is controlled by {variable}, like the switch on line {line}: place it at x = {x}, too"),
                ));
            }
        }
        Ok(())
    }

    /// Checks that no element covers another.
    fn overlaps(&self) -> Result<(), (usize, String)> {
        let elements = &self.diagram.elements;
        for (place, element) in elements.iter().enumerate() {
            for other in &elements[..place] {
                let areas = element.areas();
                if areas.iter().any(|area| other.areas().iter().any(|covered| area.overlaps(covered))) {
                    let what = format!("overlaps {} on line {}: move one of them", called(other), other.line);
                    return Err((element.line, what));
                }
            }
        }
        Ok(())
    }

    /// Checks that no wire passes through an element or touches the wire of another signal.
    fn crossings(&self) -> Result<(), (usize, String)> {
        let Diagram { elements, wires, .. } = &self.diagram;
        for wire in wires {
            for element in elements {
                let covered = |area: &Area| wire.points.windows(2).any(|ends| area.overlaps(&line(ends[0], ends[1])));
                if element.areas().iter().any(covered) {
                    let what =
                        format!("passes through {} on line {}: add corners around it", called(element), element.line);
                    return Err((wire.line, what));
                }
            }
            for other in wires.iter().filter(|other| other.signal != wire.signal) {
                let touched = other.points.iter().find(|corner| passes(&wire.points, **corner));
                if let Some(Point { x, y }) = touched {
                    let (line, x, y) = (other.line, x / GRID, y / GRID);
                    return Err((wire.line, format!("touches the wire on line {line} at {x},{y}: move one of them")));
                }
            }
        }
        Ok(())
    }
}

fn row<'a>(table: &'a Table, name: &str) -> Option<&'a Row> {
    table.find(name).map(|row| &table.rows[row])
}

/// The start value shown for a setting; empty for a signal.
pub(super) fn start(table: &Table, name: &str) -> String {
    match row(table, name) {
        Some(row) if matches!(row.role, Role::Parameter | Role::Fixed | Role::Cycle) => text::value(row, row.start()),
        _ => String::new(),
    }
}

fn called(element: &Element) -> String {
    match &element.shape {
        Shape::Text { text, .. } => format!("the text {text:?}"),
        _ => element.name.clone(),
    }
}

/// The area covered by a straight segment of a wire.
fn line(from: Point, to: Point) -> Area {
    const HALF: f64 = 1.0;
    // Leave out the ends of the segment, which touch the elements that the wire connects.
    let shorten = |from: f64, to: f64| {
        let (low, high) = (from.min(to), from.max(to));
        if high - low > 2.0 { (low + 1.0, high - 1.0) } else { (low - HALF, high + HALF) }
    };
    let ((left, right), (top, bottom)) = (shorten(from.x, to.x), shorten(from.y, to.y));
    Area { left, top, right, bottom }
}

/// Names unnamed signals after the terminal at which they start or end, or after the element that produces them.
fn name_signals(diagram: &mut Diagram) {
    let Diagram { elements, wires, signals, .. } = diagram;
    for (signal, name) in signals.iter_mut().enumerate().filter(|(_, name)| name.is_empty()) {
        let wires = || wires.iter().filter(|wire| wire.signal == signal);
        let source = wires().find_map(|wire| wire.from).map(|source| &elements[source]);
        let outputs = wires().map(|wire| &elements[wire.to]);
        *name = match source {
            Some(source) if matches!(source.shape, Shape::Input) => source.name.clone(),
            source => match outputs.into_iter().find(|element| matches!(element.shape, Shape::Output)) {
                Some(output) => output.name.clone(),
                None => format!("from-{}", source.map_or("", |source| &source.name)),
            },
        };
    }
}
