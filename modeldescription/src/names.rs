//! Variable names, for hosts that accept any name and for those that accept only identifiers.

use std::borrow::Cow;
use std::collections::HashMap;

/// How the variables of an FMU are named.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Names {
    /// As in the PLC: `par.level`, `feedback[1]`.
    #[default]
    Structured,
    /// Without dots and indices: `par_level`, `feedback_1`.
    Flat,
}

impl Names {
    /// Returns the name seen by the host.
    ///
    /// A flat name consists of letters, digits and underscores only: the minus of an index becomes `m`, quotes and
    /// closing brackets are dropped, and anything else becomes an underscore.
    pub fn convert(self, name: &str) -> Cow<'_, str> {
        let is_kept = |character: char| character.is_alphanumeric() || character == '_';
        if self == Names::Structured || name.chars().all(is_kept) {
            return name.into();
        }
        let mut flat: String = name
            .chars()
            .filter_map(|character| match character {
                ']' | '\'' | '"' => None,
                '-' => Some('m'),
                kept if is_kept(kept) => Some(kept),
                _ => Some('_'),
            })
            .collect();
        if !flat.starts_with(|first: char| first.is_alphabetic() || first == '_') {
            flat.insert(0, '_');
        }
        flat.into()
    }

    /// Rejects two different names that [`Names::convert`] would make identical.
    pub(crate) fn check<'a>(self, names: impl Iterator<Item = &'a str>) -> Result<(), String> {
        if self == Names::Structured {
            return Ok(());
        }
        let mut known: HashMap<Cow<'a, str>, &str> = HashMap::new();
        for name in names {
            let flat = self.convert(name);
            if let Some(other) = known.insert(flat.clone(), name).filter(|other| *other != name) {
                return Err(format!("{other} and {name} both have the flat name {flat}: rename one of them"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_names_are_identifiers() {
        for (name, flat) in [
            ("LEVEL_2", "LEVEL_2"),
            ("par.level", "par_level"),
            ("feedback[1]", "feedback_1"),
            ("axis[2].m[-1,10]", "axis_2_m_m1_10"),
            ("'V1.0'.'1st level [m]'", "V1_0_1st_level__m"),
            ("'1st'", "_1st"),
            ("Füllstand", "Füllstand"),
        ] {
            assert_eq!((Names::Structured.convert(name), Names::Flat.convert(name)), (name.into(), flat.into()));
        }
    }

    #[test]
    fn two_names_that_become_one_are_refused_with_both() {
        let check = |names: Names| names.check(["par.level", "x", "par_level"].into_iter());
        assert_eq!(check(Names::Structured), Ok(()));
        assert_eq!(
            check(Names::Flat).unwrap_err(),
            "par.level and par_level both have the flat name par_level: rename one of them"
        );
    }
}
