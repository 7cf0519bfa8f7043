//! The picture of a run, arranged by the roles of the variables in its loop.

use super::kept::Kept;
use crate::colors;
use anyhow::Result;
use draw::picture;
use draw::plot::{self, COLOR_COUNT, Chart, Curve, Panel, axis_label};
use draw::response::Colors;
use host::instance::Type;
use run::plan::{Column, Plan};

/// The maximum number of panels, of curves per panel and of lanes, unless the user chose the variables.
const MOST_PANELS: usize = 5;
const MOST_CURVES: usize = 6;
const MOST_LANES: usize = 10;

/// The picture, and the number of recorded variables left out of it.
pub(super) struct Picture {
    /// The file's content.
    pub bytes: Vec<u8>,
    /// The number of variables that do not fit.
    pub left_out: usize,
}

/// Draws a run: setpoint and process value in one panel, the manipulated value in the next, then the other numbers, one
/// panel per unit, and the Booleans. If the user chose the variables (`is_chosen`), all are drawn. Otherwise a
/// connected input, which repeats its output, is left out, as is everything that does not fit on a page.
///
/// # Errors
/// The picture cannot be drawn.
pub(super) fn draw(kept: &Kept, plan: &Plan, title: String, is_chosen: bool, is_svg: bool) -> Result<Picture> {
    let Some((time, curves)) = kept.curves() else { return Ok(Picture { bytes: Vec::new(), left_out: 0 }) };
    let setpoint = kept.column(kept.roles.setpoint.as_ref());
    let output = kept.column(kept.roles.manipulated_value.as_ref());
    let roles = [setpoint, kept.process_value(), output];
    // The colour of the role in the loop, else the colour that the page uses for a block variable of this name, else a
    // free one.
    let known = |at: usize| {
        let role = roles.iter().position(|role| *role == Some(at)).map(|role| Colors::OF_ROLES[role]);
        role.or_else(|| colors::known(plan.columns[at].name.rsplit_once('.')?.1))
    };
    let mut used = Vec::new();
    let mut curves_of = |of: &[usize]| -> Vec<Curve> {
        let mut taken = Vec::new();
        let mut colors: Vec<Option<usize>> = Vec::new();
        for at in of {
            let color = known(*at).filter(|color| !taken.contains(color));
            taken.extend(color);
            colors.push(color);
        }
        let curve = |(at, color): (&usize, Option<usize>)| {
            let Column { name, is_input, kind, .. } = &plan.columns[*at];
            let color = color.unwrap_or_else(|| {
                // A colour that no panel uses yet or, if none is left, one that is free in this panel.
                let free = |taken: &[usize]| Colors::free(*kind == Type::Boolean, taken);
                let new = free(&[taken.as_slice(), used.as_slice()].concat());
                let color = if new < COLOR_COUNT { new } else { free(&taken) };
                taken.push(color);
                color
            });
            used.push(color);
            Curve { name: name.clone(), values: curves[*at].clone(), is_input: *is_input, color: Some(color) }
        };
        of.iter().zip(colors).map(curve).collect()
    };
    // A controller's signals often have no unit: they are then labelled with the plant's.
    let label = |of: &[usize]| {
        let has = |column: Option<usize>| column.is_some_and(|at| of.contains(&at));
        let of_plant = if has(kept.process_value()) {
            kept.unit.as_deref()
        } else if has(output) {
            kept.travel_unit.as_deref()
        } else {
            None
        };
        let names: Vec<_> = of.iter().filter_map(|at| plan.columns[*at].name.rsplit('.').next()).collect();
        axis_label(&names, of.iter().find_map(|at| plan.columns[*at].unit.as_deref()).or(of_plant))
    };
    // Without a setpoint, the first FMU is not a controller, and its variables have no roles in a loop.
    let first: Vec<usize> = setpoint.into_iter().chain(kept.process_value().filter(|_| setpoint.is_some())).collect();
    let second: Vec<usize> = output.filter(|_| setpoint.is_some()).into_iter().collect();
    let mut panels: Vec<(Vec<usize>, bool)> =
        [first, second].into_iter().filter(|of| !of.is_empty()).map(|of| (of, true)).collect();
    let mut lanes = Vec::new();
    let mut left_out = 0;
    for (at, column) in plan.columns.iter().enumerate() {
        let is_repeated = !is_chosen && plan.source_of(column).is_some();
        if panels.iter().any(|(of, _)| of.contains(&at)) || is_repeated {
            continue;
        }
        if column.kind == Type::Boolean {
            if is_chosen || lanes.len() < MOST_LANES {
                lanes.push(at);
            } else {
                left_out += 1;
            }
            continue;
        }
        let is_alike =
            |other: usize| (plan.columns[other].kind, &plan.columns[other].unit) == (column.kind, &column.unit);
        let has_room = is_chosen || panels.len() < MOST_PANELS;
        match panels.iter_mut().find(|(of, is_role)| !is_role && is_alike(of[0])) {
            Some((of, _)) if is_chosen || of.len() < MOST_CURVES => of.push(at),
            None if has_room => panels.push((vec![at], false)),
            _ => left_out += 1,
        }
    }
    let panel = |(of, _): (Vec<usize>, bool)| Panel { label: label(&of), curves: curves_of(&of), ..Panel::default() };
    let panels = panels.into_iter().map(panel).collect();
    let lanes = curves_of(&lanes);
    let chart = Chart { title, time, panels, lanes, ..Chart::default() };
    let svg = plot::svg(&chart)?;
    let bytes = if is_svg { svg.into_bytes() } else { picture::png(&svg)? };
    Ok(Picture { bytes, left_out })
}
