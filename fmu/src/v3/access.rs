//! FMI 3.0 variables by value reference: an array is a single variable with the values of its elements in order, and
//! the time is a variable, too.

use super::{Choice, messages};
use crate::component::Component;
use crate::cyclic::Cyclic;
use crate::host_type::HostType;
use crate::layout::Referent;
use crate::refusal::Refusal;
use blocks::{Role, Table, TableText};
use std::borrow::Cow;

/// The value reference of the time, which follows those of all other variables.
pub fn time_reference<S: TableText>(table: &Table<S>) -> u32 {
    (table.rows.len() + table.texts.len()) as u32
}

/// The references of all elements of these variables. Refuses a reference inside an array, and any number of elements
/// other than `count`.
fn elements<'a, V: Choice, B: Cyclic>(
    block: &B,
    references: &'a [u32],
    count: usize,
) -> Result<Cow<'a, [u32]>, Refusal> {
    let layout = block.layout().filter(|_| V::TYPES.has_arrays());
    let all = match layout {
        None => Cow::Borrowed(references),
        Some(layout) => {
            let mut all = Vec::with_capacity(count);
            for reference in references {
                match layout.part(*reference) {
                    Referent::Single => all.push(*reference),
                    Referent::Array(elements) => all.extend(elements),
                    Referent::Inside(first) => {
                        return Err(messages::inside_array(*reference, *first).into());
                    }
                }
            }
            Cow::Owned(all)
        }
    };
    if all.len() != count {
        return Err(messages::wrong_count(count, all.len()).into());
    }
    Ok(all)
}

/// Whether each variable has exactly one value because the block has no arrays and the host passes as many values as
/// references.
#[inline(always)]
fn has_single_values<B: Cyclic>(component: &Component<B>, references: &[u32], count: usize) -> bool {
    references.len() == count && component.instance.block().layout().is_none()
}

/// Reads variables.
///
/// # Errors
/// A reference is unknown or has a different type, or the number of values is not that of the variables.
#[inline(always)]
pub fn get<V: Choice, B: Cyclic, T: HostType<V>>(
    component: &Component<B>,
    references: &[u32],
    values: &mut [T],
) -> Result<(), Refusal> {
    if has_single_values(component, references, values.len()) && component.instance.get_ordinary(references, values) {
        return Ok(());
    }
    get_elements::<V, B, T>(component, references, values)
}

#[inline(never)]
fn get_elements<V: Choice, B: Cyclic, T: HostType<V>>(
    component: &Component<B>,
    references: &[u32],
    values: &mut [T],
) -> Result<(), Refusal> {
    let instance = &component.instance;
    let elements = elements::<V, B>(instance.block(), references, values.len())?;
    refuse_time(instance.block(), &elements, "Get")?;
    instance.get(&elements, values)
}

/// Reads variables, possibly including the time.
///
/// # Errors
/// As [`get`].
#[inline(always)]
pub fn get_with_time<V: Choice, B: Cyclic>(
    component: &Component<B>,
    references: &[u32],
    values: &mut [f64],
) -> Result<(), Refusal>
where
    f64: HostType<V>,
{
    if has_single_values(component, references, values.len()) && component.instance.get_ordinary(references, values) {
        return Ok(());
    }
    get_elements_with_time(component, references, values)
}

#[inline(never)]
fn get_elements_with_time<V: Choice, B: Cyclic>(
    component: &Component<B>,
    references: &[u32],
    values: &mut [f64],
) -> Result<(), Refusal>
where
    f64: HostType<V>,
{
    let instance = &component.instance;
    let time = time_reference(instance.block().table());
    let elements = elements::<V, B>(instance.block(), references, values.len())?;
    if !elements.contains(&time) {
        return instance.get(&elements, values);
    }
    let others: Vec<u32> = elements.iter().copied().filter(|reference| *reference != time).collect();
    let mut got = vec![0.0; others.len()];
    instance.get(&others, &mut got)?;
    let mut got = got.into_iter();
    for (reference, value) in elements.iter().zip(values) {
        *value = if *reference == time { instance.time() } else { got.next().unwrap_or_default() };
    }
    Ok(())
}

/// Writes variables.
///
/// # Errors
/// A reference is unknown, has a different type or cannot be set now; the number of values is not that of the
/// variables; or a value is outside the range of its type. In these cases, nothing is written.
#[inline(always)]
pub fn set<V: Choice, B: Cyclic, T: HostType<V>>(
    component: &mut Component<B>,
    references: &[u32],
    values: &[T],
) -> Result<(), Refusal> {
    if has_single_values(component, references, values.len()) && component.instance.set_ordinary(references, values) {
        return Ok(());
    }
    set_elements::<V, B, T>(component, references, values)
}

#[inline(never)]
fn set_elements<V: Choice, B: Cyclic, T: HostType<V>>(
    component: &mut Component<B>,
    references: &[u32],
    values: &[T],
) -> Result<(), Refusal> {
    let elements = elements::<V, B>(component.instance.block(), references, values.len())?;
    refuse_time(component.instance.block(), &elements, "Set")?;
    component.instance.set(&elements, values)
}

/// The references of the elements of these text variables, `count` in total.
///
/// # Errors
/// A reference is inside an array or is that of the time, or the variables do not have `count` elements.
pub fn texts<'a, V: Choice, B: Cyclic>(
    component: &Component<B>,
    references: &'a [u32],
    count: usize,
    access: &str,
) -> Result<Cow<'a, [u32]>, Refusal> {
    let elements = elements::<V, B>(component.instance.block(), references, count)?;
    refuse_time(component.instance.block(), &elements, access)?;
    Ok(elements)
}

fn refuse_time<B: Cyclic>(block: &B, references: &[u32], access: &str) -> Result<(), Refusal> {
    let time = time_reference(block.table());
    if references.contains(&time) {
        let is_read = access == "Get";
        return Err(if is_read { messages::time_is_float64(time) } else { messages::time_is_read(time) }.into());
    }
    Ok(())
}

/// The value references of the variables that an output depends on in the current state.
///
/// # Errors
/// The reference does not refer to an output.
pub fn dependencies<V: Choice, B: Cyclic>(component: &Component<B>, reference: u32) -> Result<Vec<u32>, Refusal> {
    let block = component.instance.block();
    let table = block.table();
    let place = reference as usize;
    let is_output = match (table.rows.get(place), crate::texts::text(table, reference)) {
        (Some(row), _) => row.role == Role::Output,
        (None, Some((_, text))) => text.role == Role::Output,
        (None, None) => false,
    };
    let layout = block.layout().filter(|_| V::TYPES.has_arrays());
    let part = layout.map_or(&Referent::Single, |layout| layout.part(reference));
    if !is_output || matches!(part, Referent::Inside(_)) {
        return Err(messages::no_dependencies(reference).into());
    }
    // Once started, outputs are the results of past calls and depend on no current value. Before that, they are the
    // results of a restart, which depend on settings.
    if !component.instance.is_before_start() {
        return Ok(Vec::new());
    }
    let one = [reference];
    let elements = match part {
        Referent::Array(elements) => elements.as_slice(),
        _ => &one,
    };
    let settings =
        elements.iter().filter_map(|element| table.rows.get(*element as usize)).flat_map(|row| row.from.iter());
    let first = |setting: &usize| match layout.map(|layout| layout.part(*setting as u32)) {
        Some(Referent::Inside(first)) => *first,
        _ => *setting as u32,
    };
    let mut found: Vec<u32> = settings.map(first).collect();
    found.sort_unstable();
    found.dedup();
    Ok(found)
}
