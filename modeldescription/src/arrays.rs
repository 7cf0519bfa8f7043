//! Expands arrays: each element becomes a variable that can be set, connected and recorded.

use crate::description::{Description, Type, Variable};
use std::collections::HashSet;

/// The maximum number of elements that are expanded; a larger array remains a single variable that can be neither set
/// nor recorded.
pub const MOST_ELEMENTS: u64 = 1 << 16;

/// An array of an FMU. Its elements are consecutive variables in row-major order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// Its name.
    pub name: String,
    /// Its value reference in the C functions, which read and write all elements in one call.
    pub value_reference: u32,
    /// The number of elements in each dimension.
    pub dimensions: Vec<u64>,
    /// The value reference assigned to the first element; those of the others follow. The C functions do not know these
    /// references.
    pub first_reference: u32,
    /// The index of the first element among the variables.
    pub first: usize,
    /// The number of elements.
    pub count: usize,
}

impl Description {
    /// Replaces each array with its elements, named `a[1]` or `m[1,2]`, and sets the type of each FMI 3.0 variable to
    /// that of its C functions.
    pub fn expanded(mut self) -> Description {
        if self.is_fmi_3() {
            for variable in &mut self.variables {
                variable.kind = variable.kind.map(|kind| exact(variable.type_name).unwrap_or(kind));
            }
        }
        (self.variables, self.arrays) = expand(std::mem::take(&mut self.variables));
        self
    }
}

/// The type with this name in FMI 3.0, where an enumeration is an Int64.
fn exact(name: &str) -> Option<Type> {
    let name = if name == "Enumeration" { Type::Int64.name() } else { name };
    Type::ALL.into_iter().find(|kind| kind.name_v3() == name)
}

fn expand(declared: Vec<Variable>) -> (Vec<Variable>, Vec<Array>) {
    let used: HashSet<u32> = declared.iter().map(|of| of.value_reference).collect();
    let (mut variables, mut arrays) = (Vec::with_capacity(declared.len()), Vec::new());
    let mut next = 0;
    for of in declared {
        if of.dimensions.is_empty() {
            variables.push(of);
            continue;
        }
        let count = of.dimensions.iter().try_fold(1u64, |product, size| product.checked_mul(*size));
        let count = count.filter(|count| *count <= MOST_ELEMENTS && of.kind.is_some());
        let Some((count, first_reference)) = count.and_then(|of| Some((of, free(&used, &mut next, of as u32)?))) else {
            variables.push(Variable { kind: None, ..of });
            continue;
        };
        let first = variables.len();
        let bare = Variable { dimensions: Vec::new(), starts: Vec::new(), exact: Vec::new(), ..of.clone() };
        for element in 0..count {
            let start = at(&of.starts, element);
            variables.push(Variable {
                name: format!("{}[{}]", of.name, index(element, &of.dimensions)),
                value_reference: first_reference + element as u32,
                start,
                exact: at(&of.exact, element).into_iter().collect(),
                ..bare.clone()
            });
        }
        arrays.push(Array {
            name: of.name,
            value_reference: of.value_reference,
            dimensions: of.dimensions,
            first_reference,
            first,
            count: count as usize,
        });
    }
    (variables, arrays)
}

/// The value of an element; a single value applies to all.
fn at<T: Copy>(values: &[T], element: u64) -> Option<T> {
    if let [all] = values { Some(*all) } else { values.get(element as usize).copied() }
}

/// The first of `count` consecutive unused numbers, starting the search at `next`, which is then set to the number
/// after them.
fn free(used: &HashSet<u32>, next: &mut u32, count: u32) -> Option<u32> {
    let mut first = *next;
    let mut at = first;
    while at - first < count {
        let is_used = used.contains(&at);
        at = at.checked_add(1)?;
        if is_used {
            first = at;
        }
    }
    *next = at;
    Some(first)
}

/// The index of an element, counted from 1 in each dimension, with the last dimension varying fastest.
fn index(mut element: u64, dimensions: &[u64]) -> String {
    let mut indices: Vec<String> = Vec::with_capacity(dimensions.len());
    for size in dimensions.iter().rev() {
        indices.push((element % size + 1).to_string());
        element /= size;
    }
    indices.reverse();
    indices.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn declared(name: &str, value_reference: u32, dimensions: &[u64], starts: &[f64]) -> Variable {
        let (dimensions, starts) = (dimensions.to_vec(), starts.to_vec());
        Variable { name: name.into(), value_reference, dimensions, starts, ..Variable::default() }
    }

    #[test]
    fn an_array_is_its_elements_row_by_row_with_numbers_that_nobody_has() {
        let starts = [1.0, 2.0, 3.0, 4.0];
        let of = vec![declared("x", 1, &[], &[]), declared("m", 4, &[2, 2], &starts), declared("a", 0, &[3], &[7.0])];
        let (variables, arrays) = expand(of);
        let told: Vec<_> = variables.iter().map(|of| (of.name.as_str(), of.value_reference, of.start)).collect();
        assert_eq!(
            told,
            [
                ("x", 1, None),
                ("m[1,1]", 5, Some(1.0)),
                ("m[1,2]", 6, Some(2.0)),
                ("m[2,1]", 7, Some(3.0)),
                ("m[2,2]", 8, Some(4.0)),
                ("a[1]", 9, Some(7.0)),
                ("a[2]", 10, Some(7.0)),
                ("a[3]", 11, Some(7.0)),
            ]
        );
        let of = |array: &Array| (array.value_reference, array.first_reference, array.first, array.count);
        assert_eq!(arrays.iter().map(of).collect::<Vec<_>>(), [(4, 5, 1, 4), (0, 9, 5, 3)]);
    }

    #[test]
    fn an_array_without_end_stays_one_variable() {
        for size in [MOST_ELEMENTS + 1, u64::MAX] {
            let (variables, arrays) = expand(vec![declared("a", 0, &[size, 2], &[])]);
            assert_eq!((variables.len(), variables[0].kind, arrays.len()), (1, None, 0));
        }
        let (variables, arrays) = expand(vec![declared("a", 0, &[3, 0], &[])]);
        assert_eq!((variables.len(), arrays[0].count), (0, 0));
    }
}
