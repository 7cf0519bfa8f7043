//! Infers the roles of a program's variables in a loop from its controller calls: the variable passed as a controller's
//! process value is the program's process value.

use super::Instance;
use crate::home::Home;
use blocks::{Kind, Role};
use modeldescription::{Row, Table};
use run::dialog::{self, Group, MANUAL_MODE, Roles};
use scl::watch::{Called, CodeBlock};

/// The dialog of a program without one in its own documentation; `None` if it has one, or if no roles can be inferred.
pub(super) fn dialog(
    home: &dyn Home,
    table: &Table,
    blocks: &[CodeBlock],
    parts: &[Instance],
) -> Option<(Roles, Vec<Group>)> {
    let (own, _) = dialog::read(table).ok()?;
    let roles = roles(home, table, blocks, parts).filter(|_| own == Roles::default())?;
    Some((roles, dialog::groups(table, "Settings")))
}

/// The roles inferred from the first call of a controller in the program's main block.
fn roles(home: &dyn Home, table: &Table, blocks: &[CodeBlock], parts: &[Instance]) -> Option<Roles> {
    let own = parts.first().map(|part| part.block.as_str())?;
    let block = blocks.iter().find(|block| block.name.eq_ignore_ascii_case(own))?;
    block.calls.iter().find_map(|call| {
        let instance = parts.iter().find(|part| part.is_native && part.path.eq_ignore_ascii_case(&call.instance))?;
        let native = home.table(&instance.block).ok()??;
        let (of_native, _) = dialog::read(&native).ok()?;
        of_native.process_value.as_ref()?;
        Some(through(table, call, &of_native))
    })
}

/// The roles of a block's parameters, transferred to the variables passed for them.
fn through(table: &Table, call: &Called, of_native: &Roles) -> Roles {
    let passed = |formal: &Option<String>, is: fn(Role) -> bool| {
        let formal = formal.as_ref()?;
        let actual = call.arguments.iter().find(|of| of.formal.eq_ignore_ascii_case(formal))?.path.as_ref()?;
        let row = table.rows.iter().find(|row| row.name.eq_ignore_ascii_case(actual))?;
        is(row.role).then(|| row.name.clone())
    };
    let settable = |formal: &Option<String>| passed(formal, Role::is_settable);
    let manual = of_native
        .manual
        .as_ref()
        .and_then(|(on, value)| Some((settable(&Some(on.clone()))?, settable(&Some(value.clone()))?)));
    // Many programs switch the mode themselves: then the mode is only displayed.
    let switch =
        of_native.manual.as_ref().filter(|_| manual.is_none()).map(|(on, _)| format!("{}.{on}", call.instance));
    let switch = switch.and_then(|name| table.rows.iter().find(|row| row.name.eq_ignore_ascii_case(&name)));
    let process_value = passed(&of_native.process_value, |role| role == Role::Input);
    Roles {
        // A ramp or a setpoint selector often separates the program's setpoint from the controller's.
        setpoint: settable(&of_native.setpoint).or_else(|| named_setpoint(table)),
        shown_process_value: process_value.clone(),
        process_value,
        manipulated_value: passed(&of_native.manipulated_value, |role| role == Role::Output),
        manual,
        signals: switch.map(|row| (MANUAL_MODE.into(), row.name.clone())).into_iter().collect(),
        ..Roles::default()
    }
}

/// The first settable number whose name suggests a setpoint.
fn named_setpoint(table: &Table) -> Option<String> {
    let is_setpoint = |name: &str| {
        let small = name.to_ascii_lowercase();
        small.contains("setpoint") || small.contains("sollwert") || name.ends_with("Sp") || name.ends_with("SP")
    };
    let is_number = |row: &&Row| row.role.is_settable() && matches!(row.kind, Kind::Real | Kind::LReal);
    table.rows.iter().filter(is_number).find(|row| is_setpoint(&row.name)).map(|row| row.name.clone())
}
