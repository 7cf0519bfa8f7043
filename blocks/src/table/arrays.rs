//! Arrays in a table, which has one row per element: `a[1]`, `a[2]`.

/// The rows of one variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The name; for an array, without the indices.
    pub name: String,
    /// The rows of the elements, with the last index varying fastest; a single row if the variable is not an array.
    pub rows: Vec<usize>,
    /// The lower and upper bound of each dimension; empty if the variable is not an array.
    pub bounds: Vec<(i64, i64)>,
}

/// A row with the indices at the end of its name.
type Element = (usize, Vec<i64>);

impl Group {
    /// Returns the number of elements in each dimension.
    pub fn sizes(&self) -> impl Iterator<Item = usize> {
        self.bounds.iter().map(|(low, high)| (high - low + 1) as usize)
    }
}

/// Groups rows into variables. Each row has a name and a key that all elements of an array must share. Rows form an
/// array if their names differ only in the indices at the end, no element is missing, they are ordered by index, and
/// arrays are `wanted`. The variables are in the order of their first rows.
pub fn grouped<'a, K: PartialEq>(rows: impl Iterator<Item = (&'a str, K)>, wanted: bool) -> Vec<Group> {
    let rows: Vec<(&str, K)> = rows.collect();
    let single = |row: usize| Group { name: rows[row].0.into(), rows: vec![row], bounds: Vec::new() };
    if !wanted {
        return (0..rows.len()).map(single).collect();
    }
    // The rows by base name, in the order of their first rows.
    let mut found: Vec<(&str, Vec<Element>)> = Vec::new();
    let mut known = std::collections::HashMap::new();
    for (row, (name, _)) in rows.iter().enumerate() {
        let (base, indices) = indexed(name).unwrap_or((name, Vec::new()));
        let place = *known.entry((base, indices.is_empty())).or_insert_with(|| {
            found.push((base, Vec::new()));
            found.len() - 1
        });
        found[place].1.push((row, indices));
    }
    let mut groups = Vec::new();
    for (base, elements) in found {
        let is_alike = elements.iter().all(|(row, _)| rows[*row].1 == rows[elements[0].0].1);
        // A variable that is not an array may have the same name.
        let is_taken = known.contains_key(&(base, true)) && known.contains_key(&(base, false));
        match bounds(&elements).filter(|_| is_alike && !is_taken) {
            Some(bounds) => {
                groups.push(Group { name: base.into(), rows: elements.iter().map(|(row, _)| *row).collect(), bounds })
            }
            None => groups.extend(elements.iter().map(|(row, _)| single(*row))),
        }
    }
    groups.sort_by_key(|group| group.rows[0]);
    groups
}

/// Splits a name into its base and the indices at its end.
fn indexed(name: &str) -> Option<(&str, Vec<i64>)> {
    let (base, indices) = name.strip_suffix(']')?.rsplit_once('[')?;
    let indices: Option<Vec<i64>> = indices.split(',').map(|index| index.trim().parse().ok()).collect();
    Some((base, indices?))
}

/// Returns the bounds of the elements, if they form a complete array in order.
fn bounds(elements: &[Element]) -> Option<Vec<(i64, i64)>> {
    let (first, last) = (&elements.first()?.1, &elements.last()?.1);
    if first.is_empty() || first.len() != last.len() {
        return None;
    }
    let bounds: Vec<(i64, i64)> = first.iter().copied().zip(last.iter().copied()).collect();
    let mut expected = first.clone();
    for (place, (_, indices)) in elements.iter().enumerate() {
        if *indices != expected {
            return None;
        }
        let is_last = place + 1 == elements.len();
        for (index, (low, high)) in expected.iter_mut().zip(&bounds).rev() {
            if *index < *high {
                *index += 1;
                break;
            }
            *index = *low;
        }
        // No element may follow the one with the upper bound of every dimension.
        if !is_last && expected == *first {
            return None;
        }
    }
    (expected == *first).then_some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(name: &str, rows: &[usize], bounds: &[(i64, i64)]) -> Group {
        Group { name: name.into(), rows: rows.to_vec(), bounds: bounds.to_vec() }
    }

    fn of(names: &[&str]) -> Vec<Group> {
        grouped(names.iter().map(|name| (*name, ())), true)
    }

    fn single(name: &str, row: usize) -> Group {
        group(name, &[row], &[])
    }

    #[test]
    fn the_rows_of_an_array_are_one_variable_where_its_first_is() {
        let a = group("a", &[1, 3, 4], &[(-1, 1)]);
        assert_eq!(of(&["x", "a[-1]", "y", "a[0]", "a[1]"]), [single("x", 0), a, single("y", 2)]);
        let matrix = ["m[1,0]", "m[1,1]", "m[2,0]", "m[2,1]"];
        assert_eq!(of(&matrix), [group("m", &[0, 1, 2, 3], &[(1, 2), (0, 1)])]);
        let unwanted: Vec<_> =
            grouped(matrix.iter().map(|name| (*name, ())), false).into_iter().map(|of| of.name).collect();
        assert_eq!(unwanted, matrix);
        assert_eq!(of(&["p[7].q"]), [single("p[7].q", 0)]);
    }

    #[test]
    fn what_is_not_a_whole_array_stays_element_by_element() {
        for names in [["a[1]", "a[3]"], ["a[2]", "a[1]"], ["a[1]", "a[1,2]"], ["a[1]", "a[1]"], ["a", "a[1]"]] {
            assert_eq!(of(&names), [single(names[0], 0), single(names[1], 1)], "{names:?}");
        }
        assert_eq!(of(&["m[1,1]", "m[1,2]", "m[2,2]"]).len(), 3);
        let unlike = grouped([("a[1]", 1), ("a[2]", 2)].into_iter(), true);
        assert_eq!(unlike.len(), 2);
    }
}
