use super::*;

/// PUMP with the values of `values`, at the addresses determined by the packing rule: ON 0.0, MAN_ON 0.1, MAN 2, PV_PER
/// 6, COUNT 8, GAIN 10, SUM 14, TI 22, CYCLE 26, LMN 30, QMIN 34.0.
fn pump_bytes() -> Vec<u8> {
    let mut bytes = vec![0; 36];
    bytes[0] = 0b01;
    bytes[2..6].copy_from_slice(&7.5f32.to_be_bytes());
    bytes[6..8].copy_from_slice(&[0x93, 0x00]);
    bytes[8..10].copy_from_slice(&(-2i16).to_be_bytes());
    bytes[10..14].copy_from_slice(&2.5f32.to_be_bytes());
    bytes[14..22].copy_from_slice(&0.3f64.to_be_bytes());
    bytes[22..26].copy_from_slice(&20_500i32.to_be_bytes());
    bytes[26..30].copy_from_slice(&100i32.to_be_bytes());
    bytes
}

#[track_caller]
fn dump(bytes: &[u8], offset: usize) -> Result<Reading, Problems> {
    reading(Format::Dump, bytes, &Options { offset, ..of_block("PUMP") })
}

#[test]
fn each_value_is_read_from_its_address_big_endian() {
    let reading = dump(&pump_bytes(), 0).unwrap();
    let one = &reading.loops[0];
    assert_eq!(one.name, "plant");
    for (name, value) in [
        ("ON", Value::Bool(true)),
        ("MAN_ON", Value::Bool(false)),
        ("MAN", Value::Real(7.5)),
        ("PV_PER", Value::Word(Word::new(-27904))),
        ("COUNT", Value::Int(-2)),
        ("GAIN", Value::Real(2.5)),
        ("SUM", Value::LReal(0.3)),
        ("TI", Value::Time(Time::ms(20_500))),
        ("CYCLE", Value::Time(Time::ms(100))),
    ] {
        assert_eq!(one.get(name), Some(value), "{name}");
    }
    assert_eq!(reading.remarks.problems, []);
    assert_eq!(origin(one, "MAN_ON"), "plant.bin, byte 0.1");
    assert_eq!(origin(one, "GAIN"), "plant.bin, byte 10");
}

#[test]
fn an_instance_inside_a_longer_data_block_is_read_at_its_offset() {
    let mut bytes = vec![0xFF; 20];
    bytes.extend(pump_bytes());
    bytes.extend([0xFF; 9]);
    let reading = dump(&bytes, 20).unwrap();
    assert_eq!(reading.loops[0].get("GAIN"), Some(Value::Real(2.5)));
    assert_eq!(reading.remarks.problems, []);
    assert_eq!(origin(&reading.loops[0], "GAIN"), "plant.bin, byte 30");
}

#[test]
fn the_loop_has_the_name_that_the_user_gives() {
    let options = Options { name: Some("TIC101".into()), ..of_block("fb410") };
    assert_eq!(reading(Format::Dump, pump_bytes(), &options).unwrap().loops[0].name, "TIC101");
}

#[test]
fn a_dump_needs_the_block_and_the_error_names_the_blocks() {
    assert_eq!(
        refusal(Format::Dump, pump_bytes()),
        "plant.bin: a dump does not state which block it belongs to; specify it with --block (available: PUMP, VALVE, STATION)"
    );
}

#[test]
fn a_short_dump_is_refused_with_both_lengths() {
    let error = dump(&pump_bytes()[..35], 0).unwrap_err().to_string();
    assert!(error.starts_with("plant.bin: PUMP needs 36 bytes, but the dump has only 35"), "{error}");
    let error = dump(&pump_bytes(), 2).unwrap_err().to_string();
    assert!(error.starts_with("plant.bin: PUMP needs 36 bytes from byte 2, but the dump has only 36"), "{error}");
    assert!(dump(&pump_bytes(), usize::MAX - 1).is_err());
    let error = dump(&pump_bytes(), 1).unwrap_err().to_string();
    assert_eq!(error, "plant.bin: the offset is 1: an instance starts at an even byte");
}

#[test]
fn what_does_not_look_like_the_block_is_remarked() {
    let mut bytes = pump_bytes();
    bytes[1] = 1;
    bytes[34] = 0b10;
    bytes[10..14].copy_from_slice(&f32::NAN.to_be_bytes());
    bytes[26..30].fill(0);
    assert_eq!(
        dump(&bytes, 0).unwrap().remarks.to_string(),
        "plant.bin: byte 10: GAIN is not a finite number\n\
         plant.bin: byte 26: CYCLE is not greater than 0: a running instance never has this value\n\
         plant.bin: byte 1: bits are set that PUMP does not use: the block or the offset may be wrong\n\
         plant.bin: byte 34: bits are set that PUMP does not use: the block or the offset may be wrong"
    );
}

#[test]
fn a_dump_is_written_with_outputs_of_0() {
    let mut bytes = pump_bytes();
    let loops = dump(&bytes, 0).unwrap().loops;
    bytes[30] = 0x42;
    bytes[34] = 1;
    assert_eq!(dump(&bytes, 0).unwrap().remarks.problems, [], "outputs may have any value");
    assert_eq!(parameters::write(Format::Dump, &loops, "").unwrap(), pump_bytes());
}

#[test]
fn a_block_with_blocks_inside_is_not_dumped() {
    let sentence = "STATION contains other blocks (DI_PUMP.GAIN), whose location in a data block is unknown: use a format \
                    other than a dump";
    let problems = reading(Format::Dump, [0; 100], &of_block("STATION")).unwrap_err();
    assert_eq!(problems.to_string(), format!("plant.bin: {sentence}"));
    assert_eq!(parameters::write(Format::Dump, &[Loop::new("S", station())], ""), Err(sentence.into()));
}

#[test]
fn a_dump_holds_one_loop() {
    let loops = [Loop::new("A", pump()), Loop::new("B", pump())];
    assert_eq!(parameters::write(Format::Dump, &loops, ""), Err("a dump holds one loop, not 2: write only one".into()));
}
