//! The block diagrams in the documentation of the blocks.

use blocks::{Block, EachBlock, Role, for_each_block};
use draw::diagram;
use modeldescription::Table;
use std::collections::BTreeSet;

/// The tables of the blocks that have a diagram, as their libraries tell them.
fn tables() -> Vec<Table> {
    struct Tables(Vec<Table>);
    impl EachBlock for Tables {
        fn block<B: Block>(&mut self) {
            self.0.push(Table::from(B::TABLE));
        }
    }
    let mut tables = Tables(Vec::new());
    for_each_block(&mut tables);
    let tables: Vec<Table> = tables.0.into_iter().filter(|table| diagram::find(&table.docs).is_some()).collect();
    assert!(tables.len() >= 5);
    tables
}

/// The names in the ids of a drawing that begin with `kind`.
fn names<'a>(drawing: &'a str, kind: &str) -> BTreeSet<&'a str> {
    let ids = drawing.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    ids.filter_map(|id| id.strip_prefix(kind)).collect()
}

#[test]
fn a_diagram_shows_every_terminal_of_its_block_and_nothing_else() {
    for table in tables() {
        let drawing = diagram::svg(&table).unwrap_or_else(|error| panic!("{error:#}"));
        let own = table.variables.iter().filter(|row| row.role != Role::Local && !row.name.contains('.'));
        let own: BTreeSet<&str> = own.map(|row| row.name.as_str()).collect();
        assert_eq!(names(&drawing, "terminal-"), own, "{}", table.name);
    }
}

#[test]
fn every_output_has_a_wire_in_which_a_program_can_show_its_value() {
    for table in tables() {
        let drawing = diagram::svg(&table).unwrap();
        let wires = names(&drawing, "wire-");
        for row in table.variables.iter().filter(|row| row.role == Role::Output) {
            assert!(wires.contains(row.name.as_str()), "{} of {}: {wires:?}", row.name, table.name);
            assert!(drawing.contains(&format!(r#"id="value-{}""#, row.name)), "{} of {}", row.name, table.name);
        }
    }
}

#[test]
fn a_block_is_drawn_alike_each_time() {
    for table in tables() {
        assert_eq!(diagram::svg(&table).unwrap(), diagram::svg(&table).unwrap());
        assert_eq!(diagram::icon::svg(&table).unwrap(), diagram::icon::svg(&table).unwrap());
    }
}
