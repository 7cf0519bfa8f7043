//! Parameter files of the manuals' blocks: the addresses of their instance data blocks, and round trips of all blocks.

use parameters::layout::addresses;
use parameters::{Block, Format, Loop, Options, Source, read, write};
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
