//! Parameter files of the manuals' blocks: the addresses of their instance data blocks, and round trips of all blocks.

use blocks::{Time, Value};
use parameters::layout::addresses;
use parameters::{Block, Format, Loop, Options, Origin, Source, literal, read, write};
use std::sync::Arc;

fn block(name: &str) -> Arc<Block> {
    Block::all().into_iter().find(|block| block.name == name).unwrap()
}

/// The address of each member as the manuals print it.
fn layout(name: &str) -> Vec<String> {
    let block = block(name);
    let (addresses, _) = addresses(&block);
    let members = block.members.iter().zip(addresses);
    members.filter_map(|(member, address)| Some(format!("{} {}", address?, member.name))).collect()
}

#[track_caller]
fn assert_layout(name: &str, expected: &str, size: usize) {
    let expected: Vec<&str> = expected.split(',').map(str::trim).collect();
    assert_eq!(layout(name), expected);
    assert_eq!(addresses(&block(name)).1, size, "{name}: what lies behind the outputs is the block's memory");
}

#[test]
fn cont_c_has_the_addresses_of_its_instance_data_block() {
    let expected = "0.0 COM_RST, 0.1 MAN_ON, 0.2 PVPER_ON, 0.3 P_SEL, 0.4 I_SEL, 0.5 INT_HOLD, 0.6 I_ITL_ON, 0.7 D_SEL, \
                    2 CYCLE, 6 SP_INT, 10 PV_IN, 14 PV_PER, 16 MAN, 20 GAIN, 24 TI, 28 TD, 32 TM_LAG, 36 DEADB_W, 40 LMN_HLM, \
                    44 LMN_LLM, 48 PV_FAC, 52 PV_OFF, 56 LMN_FAC, 60 LMN_OFF, 64 I_ITLVAL, 68 DISV, 72 LMN, 76 LMN_PER, \
                    78.0 QLMN_HLM, 78.1 QLMN_LLM, 80 LMN_P, 84 LMN_I, 88 LMN_D, 92 PV, 96 ER";
    assert_layout("CONT_C", expected, 100);
}

#[test]
fn cont_s_has_the_addresses_of_its_instance_data_block() {
    let expected = "0.0 COM_RST, 0.1 LMNR_HS, 0.2 LMNR_LS, 0.3 LMNS_ON, 0.4 LMNUP, 0.5 LMNDN, 0.6 PVPER_ON, 2 CYCLE, \
                    6 SP_INT, 10 PV_IN, 14 PV_PER, 16 GAIN, 20 TI, 24 DEADB_W, 28 PV_FAC, 32 PV_OFF, 36 PULSE_TM, \
                    40 BREAK_TM, 44 MTR_TM, 48 DISV, 52.0 QLMNUP, 52.1 QLMNDN, 54 PV, 58 ER";
    assert_layout("CONT_S", expected, 62);
}

#[test]
fn pulsegen_has_the_addresses_of_its_instance_data_block() {
    let expected = "0 INV, 4 PER_TM, 8 P_B_TM, 12 RATIOFAC, 16.0 STEP3_ON, 16.1 ST2BI_ON, 16.2 MAN_ON, 16.3 POS_P_ON, \
                    16.4 NEG_P_ON, 16.5 SYN_ON, 16.6 COM_RST, 18 CYCLE, 22.0 QPOS_P, 22.1 QNEG_P";
    assert_layout("PULSEGEN", expected, 24);
}

#[test]
fn puls_ctr_has_the_addresses_of_the_manuals_table() {
    // The instances inside lie behind these.
    assert_layout("PULS_CTR", "0 SP_INT, 4 PV_PER, 6 RED_FAC, 8.0 COM_RST, 10 CYCLE, 14.0 QPOS_P", 16);
}

#[test]
fn the_loops_of_all_blocks_are_recognized_in_one_file_of_json_and_of_ssv() {
    let loops: Vec<Loop> =
        Block::all().into_iter().map(|block| Loop::new(format!("DB_{}", block.name), block)).collect();
    for format in [Format::Json, Format::Ssv] {
        let text = write(format, &loops, "").unwrap();
        let reading = read(format, &Source::new("plant", text), &Block::all(), &Options::default());
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
    let short = read(Format::Dump, &Source::new("DB42.bin", dump), &Block::all(), &options).unwrap_err();
    assert!(short.to_string().contains("CONT_C takes 100 bytes, but the dump has 62 bytes"), "{short}");
    let reading = read(Format::Dump, &Source::new("DB42.bin", longer), &Block::all(), &options).unwrap();
    let advice = reading.loops[0].advice().join("\n");
    assert!(advice.contains("LMN_HLM"), "{advice}");
}

fn loops_of(text: &str) -> Vec<Loop> {
    let reading = read(Format::Step7, &Source::new("plant.awl", text.into()), &Block::all(), &Options::default());
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
    assert_eq!(value(&loops[0], "DI_CONT_C.GAIN"), ("DB5".into(), "PULS_CTR".into(), "1.50000000e+000".into()));
    let text = write(Format::Step7, &loops, "").unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("   DI_CONT_C.GAIN := 1.50000000e+000;\n   DI_CONT_C.TI := T#20S;\n"), "{text}");
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
        let reading = read(format, &Source::new("plant", text), &Block::all(), &Options::default());
        assert_eq!(values(&reading.unwrap_or_else(|problems| panic!("{problems}")).loops), values(&loops));
    }
}
