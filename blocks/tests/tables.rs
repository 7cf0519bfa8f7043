//! What holds for the table of every block. Those of the manuals are compared in `tests/rust/parameters.rs`.

use blocks::table::number::number;
use blocks::{Block, Characteristic, EachBlock, Kind, Role, StaticTable, Value, for_each_block};

/// The tables of all blocks.
fn tables() -> Vec<&'static StaticTable> {
    struct Tables(Vec<&'static StaticTable>);
    impl EachBlock for Tables {
        fn block<B: Block>(&mut self) {
            self.0.push(B::TABLE);
        }
    }
    let mut tables = Tables(Vec::new());
    for_each_block(&mut tables);
    assert!(tables.0.len() >= 5);
    tables.0
}

#[test]
fn names_are_those_of_a_plc_and_occur_once() {
    for table in tables() {
        let mut names: Vec<_> = table.rows.iter().map(|row| row.name).collect();
        for name in &names {
            let allowed = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_' || c == '.';
            assert!(name.chars().all(allowed), "{} in {}", name, table.name);
        }
        names.sort();
        names.dedup();
        assert_eq!(names.len(), table.rows.len(), "{} has a name twice", table.name);
    }
}

#[test]
fn every_variable_has_a_description_of_one_line_without_a_full_stop() {
    for table in tables() {
        for row in table.rows {
            let text = row.description;
            assert!(!text.is_empty() && !text.contains('\n') && !text.ends_with('.'), "{}: {text}", row.name);
        }
    }
}

#[test]
fn every_variable_has_help_that_says_more_than_its_description() {
    let words = |text: &str| text.split_whitespace().map(str::to_lowercase).collect::<Vec<_>>();
    let mut findings = Vec::new();
    for table in tables() {
        for row in table.rows {
            let (name, help) = (row.name, row.help);
            if help.chars().count() < 60 {
                findings.push(format!("{} of {}: the help has less than 60 characters: {help:?}", name, table.name));
            } else if words(help).starts_with(&words(row.description)) {
                findings.push(format!("{} of {}: the help begins with the description", name, table.name));
            } else if help.lines().any(|line| ["+ ", "* ", "- "].iter().any(|sign| line.trim_start().starts_with(sign)))
            {
                findings
                    .push(format!("{} of {}: a line that begins with a sign is an item of a list", name, table.name));
            } else if !help.ends_with('.') {
                findings.push(format!("{} of {}: the help does not end with a sentence: {help:?}", name, table.name));
            }
        }
    }
    assert!(findings.is_empty(), "\n{}", findings.join("\n"));
}

#[test]
fn start_values_lie_within_their_range() {
    for table in tables() {
        for row in table.rows {
            let start = number(row.start);
            assert!(row.min.is_none_or(|min| number(min) <= start), "{} of {}", row.name, table.name);
            assert!(row.max.is_none_or(|max| start <= number(max)), "{} of {}", row.name, table.name);
        }
    }
}

#[test]
fn outputs_and_locals_have_no_start_of_their_own_unless_they_are_wired() {
    for table in tables() {
        for row in table.rows {
            let is_own = !row.is_inner();
            if row.role == Role::Output || (is_own && row.role == Role::Local) {
                assert_eq!(row.start, Value::zero(row.kind), "{} of {}", row.name, table.name);
            }
        }
    }
}

#[test]
fn the_time_between_two_calls_is_at_least_a_millisecond() {
    for table in tables() {
        let row = &table.rows[table.cycle];
        assert_eq!((row.kind, row.role, row.min.map(number)), (Kind::Time, Role::Cycle, Some(0.001)), "{}", table.name);
    }
}

#[test]
fn what_a_response_sets_and_shows_exists_and_is_set_in_time() {
    for table in tables() {
        for response in table.responses {
            assert!(!response.title.is_empty() && !response.show.is_empty(), "{}", table.name);
            assert!((60..=200).contains(&response.calls), "{}", table.name);
            for name in response.show {
                assert!(table.find(name).is_some(), "{} has no {name}", table.name);
            }
            for (call, name, _) in response.set {
                let row = table.find(name).unwrap_or_else(|| panic!("{} has no {name}", table.name));
                assert!(*call < response.calls, "{name} of {} is set too late", table.name);
                let may_change = matches!(table.rows[row].role, Role::Input | Role::Parameter);
                assert!(may_change || *call == 0, "{name} of {} cannot be set in a run", table.name);
            }
        }
    }
}

#[test]
fn what_a_characteristic_sets_and_shows_exists() {
    for table in tables() {
        for characteristic in table.characteristics {
            let row =
                |name: &str| &table.rows[table.find(name).unwrap_or_else(|| panic!("{} has no {name}", table.name))];
            let Characteristic { title, variable, range, points, calls, set, show } = characteristic;
            assert!(!title.is_empty() && !show.is_empty() && *points > 1 && *calls > 0, "{}: {title}", table.name);
            assert!(range.0 < range.1, "{}: {title}", table.name);
            assert_ne!(row(variable).kind, Kind::Bool, "{variable} of {} is not a number", table.name);
            for name in set.iter().map(|(name, _)| name).chain([variable]) {
                assert!(row(name).role.is_settable(), "{name} of {} cannot be set", table.name);
            }
            for name in *show {
                assert_ne!(row(name).role, Role::Cycle, "{name} of {} does not change", table.name);
            }
        }
    }
}
