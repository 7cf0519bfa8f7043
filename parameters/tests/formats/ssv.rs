use super::*;

const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";

fn set(parameters: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<s:ParameterSet xmlns:s=\"{NAMESPACE}\" version=\"1.0\" name=\"TIC101\">\n<s:Parameters>\n\
         {parameters}</s:Parameters>\n</s:ParameterSet>"
    )
}

fn parameter(name: &str, value: &str) -> String {
    format!("<s:Parameter name=\"{name}\"><s:{value}/></s:Parameter>\n")
}

#[test]
fn a_set_without_prefixes_is_one_loop_called_as_the_set() {
    let text = set(&(parameter("MAN_ON", "Boolean value=\"false\"")
        + &parameter("ON", "Boolean value=\"1\"")
        + &parameter("TI", "Real value=\" 1.5 \"")
        + &parameter("MAN", "Integer value=\"7\"")
        + &parameter("PV_PER", "Integer value=\"-1\"")));
    let loops = loops(Format::Ssv, text);
    let [one] = loops.as_slice() else { panic!("{loops:?}") };
    assert_eq!((one.name.as_str(), one.block.name.as_str()), ("TIC101", "PUMP"));
    assert_eq!(given(one), ["ON", "MAN_ON", "MAN", "PV_PER", "TI"]);
    assert_eq!(one.get("ON"), Some(Value::Bool(true)));
    assert_eq!(one.get("TI"), Some(Value::Time(Time::ms(1500))));
    assert_eq!(one.get("MAN"), Some(Value::Real(7.0)));
    assert_eq!(origin(one, "TI"), "plant.ssv:6:24");
}

#[test]
fn prefixes_are_loops_and_inner_names_are_none() {
    let text = set(&(parameter("A.MAN", "Real value=\"1\"")
        + &parameter("DB1.B.TRAVEL", "Real value=\"2\"")
        + &parameter("A.COUNT", "Integer value=\"4\"")
        + &parameter("C.STROKE", "Real value=\"5\"")
        + &parameter("C.DI_PUMP.GAIN", "Real value=\"6\"")));
    let loops = loops(Format::Ssv, text);
    let names: Vec<_> = loops.iter().map(|one| (one.name.as_str(), one.block.name.as_str(), given(one))).collect();
    assert_eq!(
        names,
        [
            ("A", "PUMP", vec!["MAN", "COUNT"]),
            ("DB1.B", "VALVE", vec!["TRAVEL"]),
            ("C", "STATION", vec!["STROKE", "DI_PUMP.GAIN"])
        ]
    );
}

#[test]
fn a_unit_has_to_be_that_of_the_fmu() {
    let right =
        set(&(parameter("TI", "Real value=\"2\" unit=\"s\"") + &parameter("MAN", "Real value=\"2\" unit=\"%\"")));
    assert_eq!(loops(Format::Ssv, right)[0].get("TI"), Some(Value::Time(Time::ms(2000))));
    assert_eq!(
        refusal(Format::Ssv, set(&parameter("TI", "Real value=\"2000\" unit=\"ms\""))),
        "plant.ssv:4:24: `TI` is given in `ms`, but s is expected; convert the value: units are not converted here"
    );
}

#[test]
fn annotations_and_descriptions_are_skipped() {
    let text = set(
        "<s:Parameter name=\"MAN\" description=\"x\"><s:Real value=\"1\"/><s:Annotations><x y=\"1\"/></s:Annotations>\
                    </s:Parameter>",
    );
    assert_eq!(given(&loops(Format::Ssv, text)[0]), ["MAN"]);
}

#[test]
fn what_no_block_has_is_refused_with_its_place() {
    for (parameters, sentence) in [
        (parameter("MAN", "String value=\"a\""), "plant.ssv:4:25: MAN: expected a number, found String"),
        (parameter("MAN", "Enumeration value=\"a\""), "plant.ssv:4:25: MAN: expected a number, found Enumeration"),
        (parameter("MAN", "Real value=\"a\""), "plant.ssv:4:25: MAN: expected a number, found `a`"),
        (parameter("MAN", "Real"), "plant.ssv:4:25: MAN: expected a number, found ``"),
        (parameter("MAN", "Boolean value=\"true\""), "plant.ssv:4:25: MAN: expected a number, found true"),
        (parameter("MAN", "Real value=\"INF\""), "plant.ssv:4:25: MAN: found `INF`, but a REAL accepts finite numbers"),
        (parameter("ON", "Boolean value=\"yes\""), "plant.ssv:4:24: ON: expected true or false, found yes"),
        (
            "<s:Parameter name=\"MAN\"/>".into(),
            "plant.ssv:4:1: `MAN`: expected a Real, an Integer or a Boolean, found none",
        ),
        ("<s:Parameter><s:Real/></s:Parameter>".into(), "plant.ssv:4:1: this Parameter has no name: add one"),
        (parameter("MAN", "Real value=\"1\"").repeat(2), "plant.ssv:5:1: MAN appears twice: remove one"),
        (parameter("P.MANN", "Real value=\"1\""), "plant.ssv:4:1: `P`: no block has these inputs and parameters"),
        (
            parameter("GAIN", "Real value=\"1\""),
            "plant.ssv:4:1: `TIC101`: several blocks have these inputs and parameters",
        ),
        (String::new(), "plant.ssv: the file contains no loop"),
    ] {
        let error = refusal(Format::Ssv, set(&parameters));
        assert!(error.starts_with(sentence), "{parameters}: {error}");
    }
}

#[test]
fn a_file_that_is_no_parameter_set_is_refused() {
    for (text, sentence) in [
        ("", "plant.ssv:1:1: the file has no XML element"),
        ("<a/>", "plant.ssv:1:1: expected the root element ParameterSet, found `a`"),
        (
            "<ParameterSet version=\"0.9\"/>",
            "plant.ssv:1:1: expected a ParameterSet of version 1.0 or 2.0, found `0.9`",
        ),
        ("<ParameterSet/>", "plant.ssv:1:1: expected a ParameterSet of version 1.0 or 2.0, found ``"),
        ("<a>\n<b></a>", "plant.ssv:2:4: this is not XML"),
        ("<a><b></b>", "plant.ssv:1:1: the element `a` is not closed"),
        ("<a/>\n<b/>", "plant.ssv:2:1: a second root element"),
        ("<a/>\nb", "plant.ssv:2:1: text outside the root element: `b`"),
        ("<a>&x;</a>", "plant.ssv:1:4: the entity `&x;` is unknown"),
        ("<a b='1' b='2'/>", "plant.ssv:1:1: `a`: "),
    ] {
        let error = refusal(Format::Ssv, text);
        assert!(error.starts_with(sentence), "{text}: {error}");
    }
}

#[test]
fn one_loop_is_written_without_prefix_and_several_with_it() {
    let text = String::from_utf8(parameters::write(Format::Ssv, &[Loop::new("V<1>", valve())], "").unwrap()).unwrap();
    let expected = format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\
         <ssv:ParameterSet version=\"1.0\" name=\"V&lt;1&gt;\" xmlns:ssv=\"{NAMESPACE}\">\n  <ssv:Parameters>\n    \
         <ssv:Parameter name=\"GAIN\">\n      <ssv:Real value=\"1.0\"/>\n    </ssv:Parameter>\n    \
         <ssv:Parameter name=\"TRAVEL\">\n      <ssv:Real value=\"1.0\"/>\n    </ssv:Parameter>\n    \
         <ssv:Parameter name=\"CYCLE\">\n      <ssv:Real value=\"1.0\"/>\n    </ssv:Parameter>\n  \
         </ssv:Parameters>\n</ssv:ParameterSet>\n"
    );
    assert_eq!(text, expected);
    let two = parameters::write(Format::Ssv, &[Loop::new("A", valve()), Loop::new("B", pump())], "").unwrap();
    let two = String::from_utf8(two).unwrap();
    assert!(
        two.contains("<ssv:Parameter name=\"A.TRAVEL\">") && two.contains("<ssv:Parameter name=\"B.SUM\">"),
        "{two}"
    );
}
