//! The dialogs in the documentation of the blocks: all settings are in them, and those that they call unused are.

#![allow(clippy::unwrap_used)]

use blocks::{Block, EachBlock, Kind, Role, StaticRow, Time, Value, Word, for_each_block};
use modeldescription::Table;
use run::dialog::{self, Field};
use std::collections::BTreeSet;

fn table<B: Block>() -> Table {
    Table::from(B::TABLE)
}

#[test]
fn every_block_has_a_dialog_with_each_setting_in_one_group() {
    struct Check;
    impl EachBlock for Check {
        fn block<B: Block>(&mut self) {
            let table = table::<B>();
            assert!(table.docs.contains("```dialog"), "{} has no dialog", table.name);
            let (_, groups) = dialog::read(&table).unwrap_or_else(|error| panic!("{error:#}"));
            let mut settings: Vec<&str> =
                groups.iter().flat_map(|group| &group.fields).map(|field| field.name.as_str()).collect();
            settings.sort_unstable();
            let settable = table.rows.iter().filter(|row| row.role.is_settable());
            let mut expected: Vec<&str> = settable.map(|row| row.name.as_str()).collect();
            expected.sort_unstable();
            assert_eq!(settings, expected, "{}", table.name);
            let titles: BTreeSet<&str> = groups.iter().map(|group| group.title.as_str()).collect();
            assert_eq!(titles.len(), groups.len(), "{}: two groups have one title", table.name);
        }
    }
    for_each_block(&mut Check);
}

/// Numbers that look random and are the same in each run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, count: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % count
    }

    fn value(&mut self, kind: Kind) -> Value {
        match kind {
            Kind::Bool => Value::Bool(self.below(2) == 1),
            Kind::Real => Value::Real(self.below(1000) as f32 / 10.0 - 50.0),
            Kind::LReal => Value::LReal(self.below(1000) as f64 / 10.0 - 50.0),
            Kind::Time => Value::Time(Time::ms(1 + self.below(2000) as i32)),
            Kind::Word => Value::Word(Word::new(self.below(27_000) as i16)),
            Kind::Int => Value::Int(1 + self.below(12) as i16),
            _ => unreachable!("no block has such a type"),
        }
    }
}

/// The rows of the outputs, those of the blocks inside too. What a block inside gets by a wire is no result.
fn results<B: Block>() -> Vec<usize> {
    let is_inner_output = |name: &str| {
        let mut rows = B::TABLE.instances.iter().flat_map(|table| table.rows);
        rows.any(|row| name.ends_with(&format!(".{}", row.name)) && row.role == Role::Output)
    };
    let is_result =
        |row: &StaticRow| row.role == Role::Output || (row.role == Role::Local && is_inner_output(row.name));
    (0..B::TABLE.rows.len()).filter(|place| is_result(&B::TABLE.rows[*place])).collect()
}

/// Whether two values of a setting make the block do different things in a run with settings by chance, and whether the
/// dialog says that the setting is used there.
fn run<B: Block>(field: &Field, dice: &mut Dice) -> (bool, bool) {
    let row_of = |name: &str| B::TABLE.find(name).unwrap();
    let row = row_of(&field.name);
    let settable = |role: Role, kind: Kind| role.is_settable() && !(role == Role::Input && kind == Kind::Real);
    let mut first = B::default();
    for (place, of) in B::TABLE.rows.iter().enumerate().filter(|(_, of)| settable(of.role, of.kind)) {
        // A restart in every call shows nothing.
        let value = if of.name.ends_with("COM_RST") { Value::Bool(false) } else { dice.value(of.kind) };
        assert!(first.set(place, value));
    }
    let mut second = first.clone();
    let kind = B::TABLE.rows[row].kind;
    let value = match first.get(row) {
        Some(Value::Bool(value)) => Value::Bool(!value),
        _ => dice.value(kind),
    };
    assert!(second.set(row, value));
    let is_used = field.is_used(|name| first.get(row_of(name)) == Some(Value::Bool(true)));
    let mut is_different = false;
    let results = results::<B>();
    first.restart();
    second.restart();
    for _ in 0..40 {
        for (place, of) in B::TABLE.rows.iter().enumerate() {
            if of.role == Role::Input && of.kind == Kind::Real && place != row && dice.below(8) == 0 {
                let value = dice.value(of.kind);
                assert!(first.set(place, value) && second.set(place, value));
            }
        }
        first.call();
        second.call();
        // As text, in which NaN is itself.
        is_different |= results.iter().any(|row| format!("{:?}", first.get(*row)) != format!("{:?}", second.get(*row)));
    }
    (is_different, is_used)
}

#[test]
fn a_setting_that_is_unused_by_its_dialog_has_no_effect_and_the_others_have_one() {
    struct Check;
    impl EachBlock for Check {
        fn block<B: Block>(&mut self) {
            let (_, groups) = dialog::read(&table::<B>()).unwrap();
            let mut dice = Dice(1);
            for field in groups.iter().flat_map(|group| &group.fields).filter(|field| !field.used_if.is_empty()) {
                let name = format!("{} of {}", field.name, B::TABLE.name);
                let (mut runs, mut unused, mut effects) = (0, 0, 0);
                while runs < 200 || (effects == 0 && runs < 5000) {
                    let (is_different, is_used) = run::<B>(field, &mut dice);
                    assert!(is_used || !is_different, "{name} has an effect where its dialog says that it is unused");
                    runs += 1;
                    unused += usize::from(!is_used);
                    effects += usize::from(is_different);
                }
                assert!(
                    unused > 10 && effects > 0,
                    "{name}: unused in {unused} runs of {runs}, of effect in {effects}"
                );
            }
        }
    }
    for_each_block(&mut Check);
}
