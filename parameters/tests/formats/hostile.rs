//! Files designed to exhaust memory or time, or to overflow the stack, are rejected; figures are in tests/README.md.

use super::*;

/// More than a small file may contain, and less than the limit of a file.
const MANY: usize = 1_000_000;

#[test]
fn deep_nesting_is_refused() {
    for text in ["[".repeat(MANY), "{\"a\":".repeat(MANY)] {
        let error = refusal(Format::Json, text);
        assert!(error.contains("this is not JSON"), "{error}");
    }
    for format in [Format::Ssv, Format::Openness] {
        let error = refusal(format, "<a>".repeat(MANY));
        assert!(error.contains("elements are nested more than 64 deep"), "{error}");
    }
}

#[test]
fn a_document_type_definition_is_refused() {
    let mut laughs = String::from("<!DOCTYPE a [<!ENTITY l0 \"ha\">");
    for level in 1..20 {
        let before = format!("&l{};", level - 1);
        laughs.push_str(&format!("<!ENTITY l{level} \"{}\">", before.repeat(10)));
    }
    laughs.push_str("]><a>&l19;</a>");
    for format in [Format::Ssv, Format::Openness] {
        assert_eq!(
            refusal(format, &laughs),
            format!(
                "plant.{}:1:1: a document type definition (DTD) is not supported: remove it",
                format.extensions()[0]
            )
        );
    }
}

#[test]
fn json_and_xml_above_16_mib_are_not_read() {
    let source = Source::new("plant", vec![b' '; 17 << 20]);
    for format in [Format::Json, Format::Ssv, Format::Openness] {
        let error = read(format, &source, &all(), &Options::default()).unwrap_err().to_string();
        assert!(error.ends_with(" is 16 MiB"), "{error}");
    }
}

#[test]
fn a_line_of_16_mib_is_read_in_one_pass() {
    let loops: String = (0..9000).map(|loop_| format!("\"A{loop_}\": {{{}\"MAN\": 1.5}},", " ".repeat(1800))).collect();
    let text = format!("{{{}}}", loops.trim_end_matches(','));
    assert!(text.len() > 15 << 20);
    let last = text.rfind("1.5").unwrap() + 1;
    let loops = reading(Format::Json, text, &Options::default()).unwrap().loops;
    assert_eq!(loops.len(), 9000);
    assert_eq!(origin(&loops[8999], "MAN"), format!("plant.json:1:{last}"));
}

#[test]
fn of_many_errors_the_first_are_told() {
    let entry = "\"A\": {\"MAN\": 1.5},";
    let error = refusal(Format::Json, format!("{{{}\"B\": {{}}}}", entry.repeat(10_000)));
    assert!(error.contains("appears twice") && error.ends_with(" more, not shown"), "{error}");
    assert_eq!(error.lines().count(), 51);
}

#[test]
fn too_many_loops_elements_and_attributes_are_refused() {
    let loops: String = (0..10_001).map(|loop_| format!("\"A{loop_}\": {{\"MAN\": 1}},")).collect();
    let error = refusal(Format::Json, format!("{{{}}}", loops.trim_end_matches(',')));
    assert!(error.contains("the file has more than 10000 loops"), "{error}");

    let parameters: String =
        (0..10_001).map(|loop_| format!("<Parameter name=\"A{loop_}.MAN\"><Real value=\"1\"/></Parameter>")).collect();
    let error = refusal(
        Format::Ssv,
        format!("<ParameterSet version=\"1.0\"><Parameters>{parameters}</Parameters></ParameterSet>"),
    );
    assert!(error.contains("the file has more than 10000 loops"), "{error}");

    let error = refusal(Format::Ssv, format!("<a>{}</a>", "<b/>".repeat(500_001)));
    assert!(error.contains("the file has more than 500000 elements"), "{error}");
    let attributes: String = (0..100_000).map(|number| format!(" a{number}='1'")).collect();
    let error = refusal(Format::Openness, format!("<a{attributes}/>"));
    assert!(error.contains("the element has more than 64 attributes"), "{error}");
}

#[test]
fn long_names_are_shortened_in_messages() {
    let error = refusal(Format::Json, format!("{{\"A\": {{\"MAN\": 1, \"{}\": 2}}}}", "X.".repeat(MANY)));
    assert!(error.len() < 200, "{}", error.len());
    let name = "X.".repeat(MANY);
    let error = refusal(
        Format::Ssv,
        format!(
            "<ParameterSet version=\"1.0\"><Parameters><Parameter name=\"{name}\"><Real value=\"1\"/></Parameter></Parameters></ParameterSet>"
        ),
    );
    assert!(error.len() < 400, "{}", error.len());
}

proptest::proptest! {
    #[test]
    fn any_text_and_any_bytes_are_read_or_refused(text in "\\PC{0,200}", bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..80)) {
        for format in [Format::Json, Format::Ssv, Format::Openness] {
            let _ = reading(format, &text, &Options::default());
            let _ = reading(format, &bytes, &Options::default());
        }
        let _ = reading(Format::Dump, &bytes, &of_block("PUMP"));
    }
}
