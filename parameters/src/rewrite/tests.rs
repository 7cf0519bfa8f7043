use super::*;
use crate::encoding::Encoding;
use blocks::Time;

const AWL: &str = "DATA_BLOCK \"TIC101\"\r\n{ S7_m_c := 'true' }\r\nTITLE = Öfen, Linie 1\r\nAUTHOR : Mü\r\n FB 41\r\nBEGIN\r\n  \
                   GAIN := 2.0; // from 1998\r\n  TI := T#20S;\r\nEND_DATA_BLOCK\r\nDATA_BLOCK DB 7\r\n FB 99\r\nBEGIN\r\n  GAIN := \
                   7.0;\r\nEND_DATA_BLOCK\r\n";

fn blocks() -> Vec<Arc<BlockType>> {
    BlockType::all()
}

/// Returns the loops of a source.
fn loops(format: Format, source: &Source) -> Vec<Loop> {
    read(format, source, &blocks(), &Options::default()).unwrap_or_else(|wrong| panic!("{wrong}")).loops
}

/// Returns the source with these values in its first loop.
fn changed(format: Format, source: &Source, values: &[(&str, Value)]) -> Result<(Vec<u8>, Vec<Replaced>), String> {
    let mut one = loops(format, source).swap_remove(0);
    for (name, value) in values {
        one.set(one.block.find(name).unwrap(), *value, Origin::Default);
    }
    rewrite(format, source, &blocks(), &Options::default(), &[one])
}

fn real(value: f32) -> Value {
    Value::Real(value)
}

#[test]
fn only_the_value_that_was_changed_is_another_one_in_any_encoding() {
    for (name, encoding, mark) in [
        ("Windows-1252", Encoding::Windows1252, &b""[..]),
        ("UTF-8", Encoding::Utf8, b""),
        ("UTF-8 with its mark", Encoding::Utf8, b"\xEF\xBB\xBF"),
        ("UTF-16", Encoding::Utf16Le, b"\xFF\xFE"),
        ("UTF-16, big-endian", Encoding::Utf16Be, b"\xFE\xFF"),
    ] {
        let encode = |text: &str| [mark, &encoding.encode(text).unwrap()].concat();
        let source = Source::new("plant.awl", encode(AWL));
        let (bytes, replaced) = changed(Format::Step7, &source, &[("GAIN", real(0.67))]).unwrap();
        assert!(bytes == encode(&AWL.replacen("2.0", "0.67", 1)), "{name}");
        let origin = Origin::Text {
            file: "plant.awl".into(),
            line: 7,
            column: 11,
            span: source.text.find("2.0").map(|at| at..at + 3).unwrap(),
        };
        assert_eq!(replaced, [Replaced { loop_name: "TIC101".into(), member: "GAIN".into(), origin }]);
        let (bytes, replaced) = changed(Format::Step7, &source, &[("GAIN", real(2.0))]).unwrap();
        assert!(bytes == source.bytes && replaced.is_empty(), "{name}");
    }
}

#[test]
fn a_value_is_written_as_the_one_before_it() {
    let awl = |value: &str| format!("DATA_BLOCK DB 1 FB 41 BEGIN GAIN := {value}; TI := T#20S; END_DATA_BLOCK");
    let written = |value: &str, new: f32| {
        let source = Source::new("a.awl", awl(value).into_bytes());
        String::from_utf8(changed(Format::Step7, &source, &[("GAIN", real(new))]).unwrap().0).unwrap()
    };
    assert_eq!(written("2.0", 1.4), awl("1.4"));
    assert_eq!(written("2.000000e+000", 1.4), awl("1.400000e+000"));
    assert_eq!(written("1.400000e+000", 0.9), awl("9.000000e-001"));
    assert_eq!(written("2.0E1", 1234.5), awl("1.2345E3"));
    assert_eq!(written("1E+01", 0.7), awl("7E-01"));
    assert_eq!(written("2.0", 1e-9), awl("1.000000e-009"));
}

#[test]
fn a_value_that_the_source_does_not_have_gets_a_line_beside_another() {
    let source = Source::new("plant.awl", Encoding::Windows1252.encode(AWL).unwrap());
    let (bytes, replaced) =
        changed(Format::Step7, &source, &[("LMN_HLM", real(90.0)), ("MAN_ON", Value::Bool(false))]).unwrap();
    let expected = AWL
        .replace("  TI := T#20S;\r\n", "  TI := T#20S;\r\n  LMN_HLM := 90.0;\r\n")
        .replace("from 1998\r\n", "from 1998\r\n  MAN_ON := FALSE;\r\n");
    assert_eq!(Encoding::Windows1252.decode(&bytes), expected);
    assert!(replaced.iter().all(|of| of.origin == Origin::Default));

    let multi = "FUNCTION_BLOCK FB 100\nVAR\n \"T 1\" : FB 41;\nEND_VAR\nEND_FUNCTION_BLOCK\nDATA_BLOCK DB 3 FB 100\nBEGIN\n \
                 \"T 1\".GAIN := 3.0;\nEND_DATA_BLOCK\n";
    let source = Source::new("a.awl", multi.into());
    let (bytes, _) = changed(Format::Step7, &source, &[("TI", Value::Time(Time::ms(90_000)))]).unwrap();
    assert_eq!(String::from_utf8(bytes).unwrap(), multi.replace("3.0;\n", "3.0;\n \"T 1\".TI := T#1M30S;\n"));

    let line = "DATA_BLOCK DB 1 FB 41 BEGIN GAIN := 2.0; END_DATA_BLOCK";
    let refused = changed(Format::Step7, &Source::new("a.awl", line.into()), &[("TI", Value::Time(Time::ms(1)))]);
    assert_eq!(refused.unwrap_err(), "a.awl has no replaceable value of TI in DB1: write a new parameter file");
}

#[test]
fn files_of_every_text_format_come_back_whole() {
    let json = "{\n  \"TIC\": {\n    \"GAIN\": 2.0,\n    \"TI\": 20.0\n  }\n}\n";
    let block = blocks().into_iter().find(|block| block.is_called("FB 41")).unwrap();
    let loops = [Loop::new("TIC", block)];
    for (format, text, written, new) in [
        (Format::Json, json.to_string(), "\"GAIN\": 2.0", "\"GAIN\": 1.4"),
        (Format::Ssv, of_write(Format::Ssv, &loops), "<ssv:Real value=\"2.0\"/>", "<ssv:Real value=\"1.4\"/>"),
        (Format::Openness, of_write(Format::Openness, &loops), "2.000000e+000", "1.400000e+000"),
        (Format::Tia, of_write(Format::Tia, &loops), "2.000000e+000", "1.400000e+000"),
    ] {
        let file = format!("a.{}", format.extensions()[0]);
        let source = Source::new(file, text.clone().into_bytes());
        let options = Options { block: Some("FB 41".into()), ..Options::default() };
        let mut one =
            read(format, &source, &blocks(), &options).unwrap_or_else(|wrong| panic!("{wrong}")).loops.swap_remove(0);
        one.set(one.block.find("GAIN").unwrap(), real(1.4), Origin::Default);
        let (bytes, replaced) = rewrite(format, &source, &blocks(), &options, &[one]).unwrap();
        let gain = text.find("GAIN").unwrap();
        let expected = format!(
            "{}{}",
            &text[..gain],
            text[gain..].replacen(written.trim_start_matches("\"GAIN\": "), new.trim_start_matches("\"GAIN\": "), 1)
        );
        assert_eq!(String::from_utf8(bytes).unwrap(), expected, "{format:?}");
        assert_eq!(replaced.len(), 1);
    }
    let source = Source::new("a.json", json.into());
    let options = Options { block: Some("FB 41".into()), ..Options::default() };
    let mut one = read(Format::Json, &source, &blocks(), &options).unwrap().loops.swap_remove(0);
    one.set(one.block.find("LMN_HLM").unwrap(), real(80.0), Origin::Default);
    let (bytes, _) = rewrite(Format::Json, &source, &blocks(), &options, &[one]).unwrap();
    assert_eq!(String::from_utf8(bytes).unwrap(), json.replace("20.0\n", "20.0,\n    \"LMN_HLM\": 80.0\n"));
}

fn of_write(format: Format, loops: &[Loop]) -> String {
    String::from_utf8(crate::write(format, loops, "x").unwrap()).unwrap()
}

#[test]
fn a_loop_that_is_not_in_the_source_is_refused() {
    let source = Source::new("plant.awl", Encoding::Windows1252.encode(AWL).unwrap());
    let mut one = loops(Format::Step7, &source).swap_remove(0);
    one.name = "TIC999".into();
    let error = rewrite(Format::Step7, &source, &blocks(), &Options::default(), &[one]).unwrap_err();
    assert!(error.starts_with("plant.awl has no loop `TIC999` of type "), "{error}");
}
