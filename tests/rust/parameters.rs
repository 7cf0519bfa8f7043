//! Parameter files of the blocks: their tables against those that the manuals print, addresses of the instance data blocks
//! included, and round trips of all blocks.

#![allow(clippy::unwrap_used)]

use blocks::table::number::number;
use blocks::{EachBlock, StaticRow, StaticTable, Time, Value, for_each_block};
use parameters::layout::addresses;
use parameters::{BlockType, Format, Loop, Options, Origin, Source, literal, read, write};
use std::fs::{self, DirEntry};
use std::path::Path;
use std::sync::Arc;

fn block(name: &str) -> Arc<BlockType> {
    BlockType::all().into_iter().find(|block| block.name == name).unwrap()
}

/// The tables of all blocks of ours.
fn tables() -> Vec<&'static StaticTable> {
    struct Tables(Vec<&'static StaticTable>);
    impl EachBlock for Tables {
        fn block<B: blocks::Block>(&mut self) {
            self.0.push(B::TABLE);
        }
    }
    let mut tables = Tables(Vec::new());
    for_each_block(&mut tables);
    tables.0
}

/// A table as the manual prints it, one line for each terminal: address, name, type, start, range and unit; and what we
/// make of it, its role. The block's own memory and the instances inside lie behind `size`.
fn as_manual(table: &StaticTable) -> Vec<String> {
    let (addresses, size) = addresses(&block(table.name));
    let own = table.rows.iter().enumerate().filter(|(row, of)| !of.is_inner() && table.mean != Some(*row));
    let line = |(row, of): (usize, &StaticRow)| {
        let address = addresses[row].map_or(String::new(), |address| address.to_string());
        let value = |value: Value| match value {
            Value::Time(time) => format!("{}ms", time.milliseconds()),
            Value::Bool(value) => value.to_string().to_uppercase(),
            Value::Real(value) => value.to_string(),
            value => number(value).to_string(),
        };
        let limits = [("min", of.min), ("max", of.max)].into_iter();
        let limits = limits.filter_map(|(word, limit)| Some(format!(" {word} {}", value(limit?)))).collect::<String>();
        let unit = of.unit.map_or(String::new(), |unit| format!(" unit {unit}"));
        let (kind, role, start) = (of.kind.name(), of.role.name(), value(of.start));
        format!("{address:<5}{:<9}{kind:<5}{role:<10}{start}{limits}{unit}", of.name)
    };
    own.map(line).chain([format!("{size:<5}size")]).collect()
}

#[test]
fn the_tables_of_the_blocks_are_those_of_the_manuals() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../blocks/src");
    let mut compared = 0;
    for table in tables() {
        let folder = |vendor: DirEntry| vendor.path().join(table.name.to_lowercase()).join("manual.txt");
        let mut files = fs::read_dir(&sources).unwrap().map(|vendor| folder(vendor.unwrap()));
        // Not every vendor prints a table.
        let Some(file) = files.find(|file| file.is_file()) else { continue };
        let text = fs::read_to_string(&file).unwrap();
        let manual: Vec<_> = text.lines().filter(|line| !line.starts_with('#')).collect();
        let is_without_addresses = text.contains("# no addresses");
        let of = |line: String| if is_without_addresses { line[5..].to_string() } else { line };
        assert_eq!(as_manual(table).into_iter().map(of).collect::<Vec<_>>(), manual, "{}", file.display());
        compared += 1;
    }
    assert!(compared >= 5);
}

#[test]
fn the_loops_of_all_blocks_are_recognized_in_one_file_of_json_and_of_ssv() {
    let loops: Vec<Loop> =
        BlockType::all().into_iter().map(|block| Loop::new(format!("DB_{}", block.name), block)).collect();
    for format in [Format::Json, Format::Ssv] {
        let text = write(format, &loops, "").unwrap();
        let reading = read(format, &Source::new("plant", text), &BlockType::all(), &Options::default());
        let back = reading.unwrap_or_else(|problems| panic!("{problems}")).loops;
        let names =
            |loops: &[Loop]| -> Vec<_> { loops.iter().map(|one| (one.name.clone(), one.block.name.clone())).collect() };
        assert_eq!(names(&back), names(&loops));
        for (one, other) in loops.iter().zip(&back) {
            let values = |one: &Loop| -> Vec<_> { one.settings.iter().map(|setting| setting.value).collect() };
            assert_eq!(values(one), values(other), "{}", one.name);
        }
    }
}

#[test]
fn a_dump_of_cont_c_is_recognized_as_wrong_where_it_is_one_of_cont_s() {
    let dump = write(Format::Dump, &[Loop::new("TIC101", block("CONT_S"))], "").unwrap();
    let mut longer = dump.clone();
    longer.resize(126, 0);
    let options = Options { block: Some("FB 41".into()), ..Options::default() };
    let short = read(Format::Dump, &Source::new("DB42.bin", dump), &BlockType::all(), &options).unwrap_err();
    assert!(short.to_string().contains("CONT_C needs 100 bytes, but the dump has only 62"), "{short}");
    let reading = read(Format::Dump, &Source::new("DB42.bin", longer), &BlockType::all(), &options).unwrap();
    let advice = reading.loops[0].advice().join("\n");
    assert!(advice.contains("LMN_HLM"), "{advice}");
}

fn loops_of(text: &str) -> Vec<Loop> {
    let reading = read(Format::Step7, &Source::new("plant.awl", text.into()), &BlockType::all(), &Options::default());
    reading.unwrap_or_else(|problems| panic!("{problems}")).loops
}

/// Of a loop: its name, its block and a value as the PLC writes it.
fn value(one: &Loop, name: &str) -> (String, String, String) {
    let value = one.get(name).unwrap_or_else(|| panic!("{name}"));
    (one.name.clone(), one.block.name.clone(), literal::text(value))
}

#[test]
fn blocks_are_known_by_number_by_name_and_by_their_name_after_a_migration() {
    for (kind, block) in [
        ("FB 41", "CONT_C"),
        ("SFB42", "CONT_S"),
        ("\"PULSEGEN\"", "PULSEGEN"),
        ("\"CONT_C_1\"", "CONT_C"),
        ("\"HLG\"", "HLG"),
        ("PULS_CTR", "PULS_CTR"),
    ] {
        let loops = loops_of(&format!("DATA_BLOCK \"A\" {kind} BEGIN END_DATA_BLOCK"));
        assert_eq!(loops[0].block.name, block, "{kind}");
    }
}

#[test]
fn the_settings_of_inner_blocks_stand_in_a_source_by_their_full_names() {
    let loops = loops_of("DATA_BLOCK DB 5 \"PULS_CTR\" BEGIN DI_CONT_C.GAIN := 1.5; RED_FAC := 100; END_DATA_BLOCK");
    assert_eq!(value(&loops[0], "DI_CONT_C.GAIN"), ("DB5".into(), "PULS_CTR".into(), "1.500000e+000".into()));
    let text = write(Format::Step7, &loops, "").unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("   DI_CONT_C.GAIN := 1.500000e+000;\n   DI_CONT_C.TI := T#20S;\n"), "{text}");
    assert!(!text.contains("Q_MEAN") && !text.contains("DI_CONT_C.PV_PER"), "{text}");
}

#[test]
fn pins_that_are_instructions_of_the_plc_are_written_in_quotes() {
    let ramp = block("HLG");
    let text = String::from_utf8(write(Format::Step7, &[Loop::new("RAMP", ramp)], "").unwrap()).unwrap();
    assert!(text.contains("\n\"HLG\"\nBEGIN\n   E01 := FALSE;\n") && text.contains("   \"SET\" := FALSE;\n"), "{text}");
    assert!(text.contains("   \"R\" := FALSE;\n"), "{text}");
}

#[test]
fn forty_tuned_loops_return_as_sources_that_read_back_bit_equal() {
    let block = block("CONT_C");
    let (gain, ti) = (block.find("GAIN").unwrap(), block.find("TI").unwrap());
    let loops: Vec<Loop> = (1..=40u16)
        .map(|number| {
            let mut one = Loop::new(format!("TIC{number}"), block.clone());
            one.set(gain, Value::Real(f32::from(number) / 7.0), Origin::Default);
            one.set(ti, Value::Time(Time::ms(1001 * i32::from(number))), Origin::Default);
            one
        })
        .collect();
    let values =
        |loops: &[Loop]| -> Vec<_> { loops.iter().flat_map(|one| [value(one, "GAIN"), value(one, "TI")]).collect() };
    for format in [Format::Step7, Format::Tia] {
        let text = write(format, &loops, "plant.fmu").unwrap();
        let reading = read(format, &Source::new("plant", text), &BlockType::all(), &Options::default());
        assert_eq!(values(&reading.unwrap_or_else(|problems| panic!("{problems}")).loops), values(&loops));
    }
}
