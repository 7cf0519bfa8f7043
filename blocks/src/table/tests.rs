//! Tables made by [`block!`](crate::block!), as their users see them.

use super::*;
use abreast::Abreast;

crate::block! {
    /// Adds two words.
    ///
    /// More about it.
    pub struct Inner as "INNER" {
        input {
            /// First word
            first: Word = Word::new(3);
            /// Second word
            second: Word;
        }
        cycle {
            /// Time between calls
            cycle: Time = Time::ms(20);
        }
        fixed {
            /// Cannot be tuned
            order: Int = 2, min 1, max 9;
        }
        output {
            /// Sum
            sum: Int;
        }
    }
    mean {
        /// Mean of the pulse
        inner_mean;
    }
    memory InnerMemory {
        /// Calls since the restart.
        calls: u32;
    }
}

impl Law for Inner {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        self.memory.calls += 1;
        self.sum = self.first.value() + self.second.value();
    }
}

crate::block! {
    /// Has one of everything.
    pub struct Outer as "OUTER" {
        parameter {
            /// A number
            ///
            /// Twice as much makes twice
            /// as much of it.
            ///
            /// 1.5 is a good beginning.
            gain: Real = 1.5, min 0.0, max 10.0, unit "degC";
        }
        cycle {
            /// Time between calls
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// A wide number
            state: LReal, from cycle gain, unit "degC";
            /// A bit
            q: Bool;
        }
        local {
            /// In between
            between: Real;
        }
    }
    mean {
        /// Mean of the pulse
        outer_mean;
    }
    instances {
        /// One of two.
        di_a: Inner {
            wired: first cycle;
            start: second = Word(Word::new(7)), order = Int(4);
        }
        /// The other.
        di_b: Inner {
            wired: ;
        }
    }
    memory OuterMemory {
        /// A flag.
        started: bool;
        /// A table.
        history: [i16; 2];
    }
}

impl Law for Outer {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        self.memory.started = true;
        self.di_a.call();
        self.di_b.call();
    }
}

crate::block! {
    /// Holds a block that holds blocks.
    pub struct Outermost as "OUTERMOST" {
        cycle {
            /// Time between calls
            cycle: Time = Time::ms(10);
        }
    }
    instances {
        /// Two levels.
        di_outer: Outer {
            wired: cycle;
            start: gain = Real(2.5);
        }
    }
}

impl Law for Outermost {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        self.di_outer.call();
    }
}

fn row(name: &str) -> usize {
    Outer::TABLE.find(name).unwrap_or_else(|| panic!("no row {name}"))
}

#[test]
fn the_first_line_of_a_variables_documentation_is_its_short_text_and_the_rest_its_help() {
    let gain = Outer::TABLE.rows[0];
    assert_eq!(gain.description, "A number");
    assert_eq!(gain.help, "Twice as much makes twice\n as much of it.\n\n 1.5 is a good beginning.");
    assert_eq!(Outer::TABLE.rows[1].help, "");
}

#[test]
fn an_output_names_the_settings_of_its_restart_value_and_an_inner_one_does_not() {
    assert_eq!(Outer::TABLE.rows[row("STATE")].from, [row("CYCLE"), row("GAIN")]);
    assert_eq!(Outer::TABLE.rows[row("STATE")].unit, Some("degC"));
    assert!(Outer::TABLE.rows[row("Q")].from.is_empty());
    let inner = Outermost::TABLE.find("DI_OUTER.STATE").unwrap();
    assert!(Outermost::TABLE.rows[inner].from.is_empty(), "it is a local there");
}

#[test]
#[should_panic(expected = "`from` accepts only settings")]
fn a_restart_value_cannot_depend_on_a_signal() {
    let signal = StaticRow { role: Role::Input, ..StaticRow::EMPTY };
    check_restart_values(&[signal, StaticRow { role: Role::Output, from: &[0], ..StaticRow::EMPTY }]);
}

#[test]
#[should_panic(expected = "`from` is only for outputs")]
fn a_setting_has_no_restart_value() {
    let setting = StaticRow { role: Role::Parameter, ..StaticRow::EMPTY };
    check_restart_values(&[setting, StaticRow { from: &[0], ..setting }]);
}

#[test]
fn rows_stand_in_the_order_of_the_table_then_the_instances_then_the_mean() {
    let names: Vec<_> = Outer::TABLE.rows.iter().map(|row| row.name).collect();
    let own = ["GAIN", "CYCLE", "STATE", "Q", "BETWEEN"];
    let inner = ["FIRST", "SECOND", "CYCLE", "ORDER", "SUM"];
    let mut expected: Vec<_> = own.map(String::from).to_vec();
    expected.extend(inner.map(|name| format!("DI_A.{name}")));
    expected.extend(inner.map(|name| format!("DI_B.{name}")));
    expected.push("OUTER_MEAN".into());
    assert_eq!(names, expected);
}

#[test]
fn a_row_says_what_the_table_says() {
    let row = &Outer::TABLE.rows[row("GAIN")];
    assert_eq!((row.description, row.kind, row.role), ("A number", Kind::Real, Role::Parameter));
    assert_eq!((row.start, row.min, row.max), (Value::Real(1.5), Some(Value::Real(0.0)), Some(Value::Real(10.0))));
    assert_eq!(row.unit, Some("degC"));
}

#[test]
fn what_a_table_leaves_out_is_0_or_nothing() {
    let row = &Outer::TABLE.rows[row("Q")];
    assert_eq!((row.start, row.min, row.max, row.unit), (Value::Bool(false), None, None, None));
}

#[test]
fn the_table_has_name_docs_cycle_mean_memory_and_instances() {
    let table = Outer::TABLE;
    assert_eq!((table.name, table.docs), ("OUTER", " Has one of everything.\n"));
    assert_eq!((table.cycle, table.mean), (row("CYCLE"), Some(table.rows.len() - 1)));
    assert_eq!(table.memory, [("started", "bool"), ("history", "[i16; 2]")]);
    assert_eq!(table.instances.iter().map(|inner| inner.name).collect::<Vec<_>>(), ["INNER", "INNER"]);
    assert_eq!(Inner::TABLE.docs, " Adds two words.\n\n More about it.\n");
}

#[test]
fn the_mean_row_is_an_output_without_a_unit() {
    let row = &Outer::TABLE.rows[row("OUTER_MEAN")];
    assert_eq!((row.kind, row.role, row.unit), (Kind::LReal, Role::Output, None));
}

#[test]
fn inside_another_block_inputs_become_parameters_outputs_locals_and_the_cycle_fixed() {
    let role = |name| Outer::TABLE.rows[row(name)].role;
    assert_eq!(role("DI_B.FIRST"), Role::Parameter);
    assert_eq!(role("DI_B.CYCLE"), Role::Fixed);
    assert_eq!(role("DI_B.ORDER"), Role::Fixed);
    assert_eq!(role("DI_B.SUM"), Role::Local);
    assert_eq!(role("DI_A.SECOND"), Role::Parameter);
    assert_eq!([role("DI_A.FIRST"), role("DI_A.CYCLE")], [Role::Local; 2]);
}

#[test]
fn inside_another_block_a_start_value_may_be_another() {
    let start = |name| Outer::TABLE.rows[row(name)].start;
    assert_eq!((start("DI_A.SECOND"), start("DI_A.ORDER")), (Value::Word(Word::new(7)), Value::Int(4)));
    assert_eq!((start("DI_B.SECOND"), start("DI_B.ORDER")), (Value::Word(Word::new(0)), Value::Int(2)));
}

#[test]
fn instances_inside_instances_keep_their_path_role_and_values() {
    let find = |name| Outermost::TABLE.find(name).unwrap_or_else(|| panic!("no row {name}"));
    let role = |name| Outermost::TABLE.rows[find(name)].role;
    assert_eq!(Outermost::TABLE.rows.len(), 1 + 5 + 2 * 5);
    // `wired` means the terminal of the block itself, not one of the same name further in.
    assert_eq!((role("DI_OUTER.CYCLE"), role("DI_OUTER.DI_B.CYCLE")), (Role::Local, Role::Fixed));
    assert_eq!((role("DI_OUTER.DI_A.SECOND"), role("DI_OUTER.DI_A.FIRST")), (Role::Parameter, Role::Local));

    let mut block = Outermost::default();
    assert_eq!(block.get(find("DI_OUTER.GAIN")), Some(Value::Real(2.5)));
    assert_eq!(block.get(find("DI_OUTER.DI_A.SECOND")), Some(Value::Word(Word::new(7))));
    assert!(block.set(find("DI_OUTER.DI_B.FIRST"), Value::Word(Word::new(40))));
    block.call();
    assert_eq!(block.get(find("DI_OUTER.DI_B.SUM")), Some(Value::Int(40)));
}

#[test]
fn a_new_block_holds_the_start_values_of_its_table() {
    let block = Outer::default();
    for (index, row) in Outer::TABLE.rows.iter().enumerate() {
        assert_eq!(block.get(index), Some(row.start), "{}", row.name);
    }
}

#[test]
fn every_row_can_be_written_and_read_back_and_changes_no_other() {
    let other = |kind| match kind {
        Kind::Real => Value::Real(-2.5),
        Kind::LReal => Value::LReal(-3.5),
        Kind::Time => Value::Time(Time::ms(1234)),
        Kind::Word => Value::Word(Word::new(-99)),
        Kind::Int => Value::Int(-77),
        Kind::Bool => Value::Bool(true),
        other => Value::Whole(other, 55),
    };
    for (index, row) in Outer::TABLE.rows.iter().enumerate() {
        let mut block = Outer::default();
        assert!(block.set(index, other(row.kind)));
        for (read, row) in Outer::TABLE.rows.iter().enumerate() {
            let expected = if read == index { other(row.kind) } else { row.start };
            assert_eq!(block.get(read), Some(expected), "{} after setting row {index}", row.name);
        }
    }
}

#[test]
fn a_value_of_another_type_or_a_row_that_is_none_is_refused_and_changes_nothing() {
    let mut block = Outer::default();
    let before = format!("{block:?}");
    let rows = Outer::TABLE.rows.len();
    for (index, row) in Outer::TABLE.rows.iter().enumerate() {
        let wrong = if row.kind == Kind::Bool { Value::Int(1) } else { Value::Bool(true) };
        assert!(!block.set(index, wrong), "{}", row.name);
    }
    assert!(!block.set(rows, Value::LReal(1.0)));
    assert!(!block.set(usize::MAX, Value::LReal(1.0)));
    assert_eq!((block.get(rows), block.get(usize::MAX)), (None, None));
    assert_eq!(format!("{block:?}"), before);
}

#[test]
fn a_real_is_read_and_written_as_any_value_and_no_other_row_is_one() {
    for (index, row) in Outer::TABLE.rows.iter().enumerate() {
        let mut block = Outer::default();
        let before = block.get(index);
        let is_real = row.kind == Kind::Real;
        assert_eq!(block.real(index).map(Value::Real), before.filter(|_| is_real), "{}", row.name);
        block.real_mut(index).into_iter().for_each(|real| *real = -2.5);
        assert_eq!(block.get(index), if is_real { Some(Value::Real(-2.5)) } else { before }, "{}", row.name);
    }
    let mut block = Outermost::default();
    let gain = Outermost::TABLE.find("DI_OUTER.GAIN").unwrap();
    *block.real_mut(gain).unwrap() = 7.5;
    assert_eq!((block.real(gain), block.di_outer.gain), (Some(7.5), 7.5));
    let rows = Outermost::TABLE.rows.len();
    assert_eq!((block.real(rows), block.real_mut(rows)), (None, None));
}

#[test]
fn an_lreal_is_read_and_written_as_any_value_and_no_other_row_is_one() {
    for (index, row) in Outer::TABLE.rows.iter().enumerate() {
        let mut block = Outer::default();
        let before = block.get(index);
        let is_lreal = row.kind == Kind::LReal;
        assert_eq!(block.lreal(index).map(Value::LReal), before.filter(|_| is_lreal), "{}", row.name);
        block.lreal_mut(index).into_iter().for_each(|lreal| *lreal = -2.5);
        assert_eq!(block.get(index), if is_lreal { Some(Value::LReal(-2.5)) } else { before }, "{}", row.name);
    }
    let rows = Outermost::TABLE.rows.len();
    assert_eq!((Outermost::default().lreal(rows), Outermost::default().lreal_mut(rows)), (None, None));
}

fn assert_a_host_reads_and_writes<G: Abreast<Outer>>() -> usize {
    let mut count = 0;
    for (index, row) in Outer::TABLE.rows.iter().enumerate() {
        let mut other = Outer::default();
        let mut blocks = G::from_blocks(vec![Outer::default(); 2]);
        let (Some(read), Some(write)) = (G::reader(index), G::writer(index)) else { continue };
        for number in [1.0, 0.0, -7.0, 0.25, 40_000.0, 1e39, f64::NAN, f64::INFINITY] {
            let value = number::to_value(number, row.kind);
            assert_eq!(write(&mut blocks, &[0.0, number]), value.is_ok(), "{} = {number}", row.name);
            let Ok(value) = value else {
                // Any value may stand there now.
                blocks = G::from_blocks(vec![Outer::default(), other.clone()]);
                continue;
            };
            assert!(other.set(index, value));
            let mut numbers = [f64::NAN; 2];
            read(&blocks, &mut numbers);
            let now = other.get(index).map(number::number).unwrap();
            assert_eq!(numbers, [0.0, now], "{} = {number}", row.name);
        }
        assert_eq!(format!("{:?}", blocks.into_blocks()[1]), format!("{other:?}"), "{}", row.name);
        count += 1;
    }
    count
}

#[test]
fn a_reader_and_a_writer_do_what_a_host_does_with_numbers() {
    assert_eq!(assert_a_host_reads_and_writes::<Vec<Outer>>(), Outer::TABLE.rows.len());
    assert_eq!(assert_a_host_reads_and_writes::<abreast::Lanes<Outer>>(), 5);
}

#[test]
fn reals_that_are_inputs_or_parameters_may_be_set_at_any_time() {
    let names = |table: &StaticTable| -> Vec<&str> {
        let rows = table.rows.iter().zip(table.tunable_reals);
        rows.filter(|(_, is_tunable)| **is_tunable).map(|(row, _)| row.name).collect()
    };
    assert_eq!(names(Outer::TABLE), ["GAIN"]);
    assert_eq!(names(Outermost::TABLE), ["DI_OUTER.GAIN"]);
    assert!(names(Inner::TABLE).is_empty(), "it has no REAL");
}

#[test]
fn the_mean_can_be_written() {
    let mut block = Outer::default();
    block.set_mean(12.5);
    assert_eq!(block.get(row("OUTER_MEAN")), Some(Value::LReal(12.5)));
}

#[test]
fn the_cycle_is_the_value_of_its_row() {
    let mut block = Outer::default();
    assert_eq!(block.cycle(), Time::ms(10));
    block.set(Outer::TABLE.cycle, Value::Time(Time::ms(35)));
    assert_eq!(block.cycle(), Time::ms(35));
}

#[test]
fn clear_takes_outputs_locals_mean_and_memory_back_and_leaves_settings_and_instances() {
    let mut block = Outer { gain: 2.0, state: 1.0, q: true, between: 3.0, outer_mean: 4.0, ..Outer::default() };
    block.call();
    block.memory.history = [1, 2];
    block.clear();
    assert_eq!((block.state, block.q, block.between, block.outer_mean), (0.0, false, 0.0, 0.0));
    assert_eq!((block.memory.started, block.memory.history), (false, [0, 0]));
    assert_eq!((block.gain, block.di_a.sum, block.di_a.memory.calls), (2.0, 10, 1));
}

#[test]
fn a_stored_block_comes_back_with_instances_mean_and_memory() {
    let mut block = Outer { gain: 2.0, outer_mean: -4.0, ..Outer::default() };
    block.di_b.inner_mean = 9.0;
    block.memory.history = [1, -2];
    block.call();
    let mut bytes = Vec::new();
    block.write(&mut bytes);
    let mut rest = &bytes[..];
    let read = Outer::read(&mut rest).unwrap();
    assert_eq!((format!("{read:?}"), rest.len()), (format!("{block:?}"), 0));
    assert!(Outer::read(&mut &bytes[..bytes.len() - 1]).is_none());
}

#[test]
fn find_knows_full_names_only() {
    assert_eq!(Outer::TABLE.find("DI_A.SUM"), Some(9));
    assert_eq!((Outer::TABLE.find("SUM"), Outer::TABLE.find("gain")), (None, None));
}

#[test]
fn a_block_that_says_nothing_of_them_accepts_its_parameters_and_has_no_pulse() {
    assert_eq!((Outer::default().check(), Outer::default().pulse()), (Ok(()), 0));
}

#[test]
fn a_type_and_a_role_have_one_name_each_and_are_found_by_it() {
    let types: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
    assert_eq!(types[..8], ["REAL", "LREAL", "TIME", "WORD", "INT", "BOOL", "SINT", "USINT"]);
    let roles: Vec<&str> = Role::ALL.iter().map(|role| role.name()).collect();
    assert_eq!(roles, ["input", "parameter", "fixed", "cycle", "output", "local"]);
    assert!(Kind::ALL.iter().all(|kind| Kind::named(kind.name()) == Some(*kind)));
    assert!(Role::ALL.iter().all(|role| Role::named(role.name()) == Some(*role)));
    assert_eq!((Kind::named("S5TIME"), Role::named("Input")), (None, None));
}

#[test]
fn inputs_and_settings_can_be_set_and_results_cannot() {
    let settable: Vec<&str> = Role::ALL.iter().filter(|role| role.is_settable()).map(|role| role.name()).collect();
    assert_eq!(settable, ["input", "parameter", "fixed", "cycle"]);
}
