//! From XML to a model description: files of other tools, and rejected files.

use crate::sample::{everything, smallest};
use modeldescription::v2::*;

/// A model description as other tools write it: with comments, with other quotes and another order, and with foreign
/// attributes and elements.
const FOREIGN: &str = r#"<?xml version='1.0' encoding='utf-8' standalone="yes"?>
<!-- made by <hand> & foot -->
<?xml-stylesheet href="look.css"?>
<fmiModelDescription xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="fmi2.xsd"
  guid='{2}' modelName="Foreign.Model"
  fmiVersion="2.0"
  description="two
lines &#x3c;&#60;&lt;&apos;&quot;&gt;&amp;&#10;end" numberOfEventIndicators=" 3 " >
  <ModelExchange modelIdentifier="Foreign_Model" canGetAndSetFMUstate="1" canSerializeFMUstate="0">
    <SourceFiles><File name="a.c"/><File name="b.c"></File></SourceFiles>
  </ModelExchange>
  <DefaultExperiment stopTime=" 1E3 "/>
  <TypeDefinitions>
    <SimpleType name="Level" description="of &lt;!-- no comment --> water">
      <Real quantity="Length" unit="m" displayUnit="cm" min="0" max="+2.5E0" relativeQuantity="true"/>
    </SimpleType>
    <SimpleType name="Colour"><Enumeration><Item name="red" value="1" description="Stop"/><Item name="green" value="-2"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1"/><DisplayUnit name="cm" factor="100"/></Unit>
  </UnitDefinitions>
  <VendorAnnotations>
    <Tool name="X" xmlns:x="urn:x"><x:deep a="1" a:b='2'><x:deeper>text &amp; &#65; <![CDATA[ <x> & ]]></x:deeper><y/></x:deep></Tool>
  </VendorAnnotations>
  <ModelVariables>
    <!-- 1 -->
    <ScalarVariable name="level" valueReference="4294967295" causality="output">
      <Real declaredType="Level" unit="m"/>
      <Annotations><Tool name="X"><x><ScalarVariable/></x></Tool></Annotations>
    </ScalarVariable>
    <ScalarVariable name="text" valueReference="0" variability="fixed" causality="parameter">
      <String start="&#9;a  b	c&#13;&#10;"/>
    </ScalarVariable>
    <ScalarVariable name="choice" valueReference="0" variability="discrete" causality="input">
      <Enumeration start="-2" declaredType="Colour"/>
    </ScalarVariable>
    <ScalarVariable name="alias of choice" valueReference="0" variability="discrete"><Integer min="-5" max="+5"/></ScalarVariable>
    <ScalarVariable name="limits" valueReference="1"><Real min="-INF" max="INF" nominal="NaN"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="0" variability="discrete" causality="input"><Boolean start=" 1 "/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="1" dependencies=" 3
        6 " dependenciesKind="dependent  fixed"/>
    </Outputs>
    <Derivatives/>
    <InitialUnknowns></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
<!-- the end -->
"#;

fn parsed(xml: &str) -> ModelDescription {
    read(xml.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the error for the foreign description after a text that occurs in it once has been replaced.
fn refused(from: &str, to: &str) -> String {
    assert_eq!(FOREIGN.matches(from).count(), 1, "{from}");
    match read(FOREIGN.replacen(from, to, 1).as_bytes()) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{to} is taken"),
    }
}

/// Asserts that a change is rejected at this line, with these words.
fn assert_refused(from: &str, to: &str, line: usize, words: &[&str]) {
    let error = refused(from, to);
    assert!(error.starts_with(&format!("line {line}: ")), "{error}");
    for word in words {
        assert!(error.contains(word), "{word:?} is not in: {error}");
    }
    assert!(!error.contains('\n'), "{error}");
}

#[test]
fn everything_that_can_be_written_reads_back() {
    assert_eq!(parsed(std::str::from_utf8(&write(&everything())).unwrap()), everything());
    assert_eq!(read(&write(&smallest())), Ok(smallest()));
}

#[test]
fn the_description_of_another_tool_is_read_whole() {
    let description = parsed(FOREIGN);
    assert_eq!(description.model_name, "Foreign.Model");
    assert_eq!(description.guid, "{2}");
    assert_eq!(description.description.as_deref(), Some("two lines <<<'\">&\nend"));
    assert_eq!(description.number_of_event_indicators, Some(3));
    assert_eq!(description.model_identifier(), Some("Foreign_Model"));
    let model_exchange = description.model_exchange.clone().unwrap();
    assert!(model_exchange.can_get_and_set_fmu_state && !model_exchange.can_serialize_fmu_state);
    assert_eq!(model_exchange.source_files, ["a.c", "b.c"].map(|name| SourceFile { name: name.into() }));
    assert_eq!(description.co_simulation, None);
    let experiment = DefaultExperiment { stop_time: Some(1000.0), ..DefaultExperiment::default() };
    assert_eq!(description.default_experiment, Some(experiment));
    let level = &description.type_definitions[0];
    assert_eq!((level.name.as_str(), level.description.as_deref()), ("Level", Some("of <!-- no comment --> water")));
    let expected = RealAttributes {
        quantity: Some("Length".into()),
        unit: Some("m".into()),
        display_unit: Some("cm".into()),
        relative_quantity: Some(true),
        min: Some(0.0),
        max: Some(2.5),
        ..RealAttributes::default()
    };
    assert_eq!(level.attributes, TypeAttributes::Real(expected));
    let TypeAttributes::Enumeration(EnumerationType { items, .. }) = &description.type_definitions[1].attributes else {
        panic!()
    };
    assert_eq!((items[0].value, items[0].description.as_deref(), items[1].value), (1, Some("Stop"), -2));
    assert_eq!(description.unit_definitions[0].display_units[0].factor, 100.0);
    let names: Vec<&str> = description.model_variables.iter().map(|variable| variable.name.as_str()).collect();
    assert_eq!(names, ["level", "text", "choice", "alias of choice", "limits", "on"]);
    assert_eq!(description.model_variables[0].value_reference, u32::MAX);
    let Typed::String(text) = &description.variable("text").unwrap().typed else { panic!() };
    // A literal tab is read as a blank, whereas &#9; is read as a tab.
    assert_eq!(text.start.as_deref(), Some("\ta  b c\r\n"));
    let Typed::Enumeration(choice) = &description.variable("choice").unwrap().typed else { panic!() };
    assert_eq!((choice.declared_type.as_str(), choice.start), ("Colour", Some(-2)));
    let Typed::Real(limits) = &description.variable("limits").unwrap().typed else { panic!() };
    assert_eq!((limits.attributes.min, limits.attributes.max), (Some(f64::NEG_INFINITY), Some(f64::INFINITY)));
    assert!(limits.attributes.nominal.unwrap().is_nan());
    let Typed::Boolean(on) = &description.variable("on").unwrap().typed else { panic!() };
    assert_eq!(on.start, Some(true));
    let expected = Unknown {
        index: 1,
        dependencies: Some(vec![3, 6]),
        dependencies_kind: Some(vec![DependencyKind::Dependent, DependencyKind::Fixed]),
    };
    assert_eq!(description.model_structure.outputs, [expected]);
}

#[test]
fn what_is_absent_has_the_standards_default() {
    let xml = r#"<fmiModelDescription fmiVersion="2.0" modelName="" guid=""><CoSimulation modelIdentifier="A"/>
        <UnitDefinitions><Unit name="u"><BaseUnit/><DisplayUnit name="d"/></Unit></UnitDefinitions>
        <ModelVariables><ScalarVariable name="x" valueReference="0"><Real/></ScalarVariable></ModelVariables>
        <ModelStructure/></fmiModelDescription>"#;
    let description = parsed(xml);
    assert_eq!(description.variable_naming_convention, VariableNamingConvention::Flat);
    assert_eq!(
        description.co_simulation,
        Some(CoSimulation { model_identifier: "A".into(), ..CoSimulation::default() })
    );
    let unit = &description.unit_definitions[0];
    let base = unit.base_unit.unwrap();
    assert_eq!((base.factor, base.offset, base.kg), (1.0, 0.0, 0));
    assert_eq!((unit.display_units[0].factor, unit.display_units[0].offset), (1.0, 0.0));
    let variable = &description.model_variables[0];
    assert_eq!((variable.causality, variable.variability), (Causality::Local, Variability::Continuous));
    assert_eq!((variable.initial, variable.initial_or_default()), (None, Some(Initial::Calculated)));
    assert_eq!(variable.typed, Typed::Real(Real::default()));
    assert_eq!(description.model_structure, ModelStructure::default());
}

#[test]
fn a_byte_order_mark_and_windows_line_ends_make_no_difference() {
    let windows = format!("\u{feff}{}", FOREIGN.replace('\n', "\r\n"));
    assert_eq!(write(&parsed(&windows)), write(&parsed(FOREIGN)));
}

#[test]
fn another_encoding_is_read_as_long_as_there_is_nothing_but_ascii() {
    let latin = FOREIGN.replace("encoding='utf-8'", "encoding='ISO-8859-1'");
    assert_eq!(write(&parsed(&latin)), write(&parsed(FOREIGN)));
    let umlaut = latin.replace("water", "Wasserstände");
    let error = read(umlaut.as_bytes()).unwrap_err().to_string();
    assert_eq!(error, "line 1: encoding = \"ISO-8859-1\": save the file as UTF-8");
}

#[test]
fn a_file_that_is_cut_off_anywhere_is_refused() {
    let whole = FOREIGN.find("<!-- the end").unwrap() - 1;
    for length in 0..whole {
        assert!(read(&FOREIGN.as_bytes()[..length]).is_err(), "{length}");
    }
    assert!(read(&FOREIGN.as_bytes()[..whole]).is_ok());
}

#[test]
fn every_single_byte_damaged_is_refused_or_reads_as_something_that_can_be_written() {
    for xml in [FOREIGN.as_bytes().to_vec(), write(&everything())] {
        for place in 0..xml.len() {
            let bytes = [xml[place] ^ 1, xml[place] ^ 0x80, b'<', b'"', b'&', b' ', 0];
            let mut damaged = xml.clone();
            damaged[place] = bytes[place % bytes.len()];
            if let Ok(description) = read(&damaged) {
                let again = read(&write(&description)).unwrap_or_else(|error| panic!("byte {place}: {error}"));
                assert_eq!(write(&again), write(&description), "byte {place}");
            }
        }
    }
}

#[test]
fn what_is_no_model_description_of_fmi_2_0_is_refused() {
    let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    for nothing in ["", " \n", "PK\u{3}\u{4}", "{}", "<!-- -->", "<?xml version=\"1.0\"?>"] {
        assert!(
            error(nothing.as_bytes()).contains("a model description begins with <fmiModelDescription"),
            "{nothing}"
        );
    }
    assert_eq!(error(b"\xff\xfe<\0f\0"), "line 1: byte 0xff is not UTF-8: save the file as UTF-8");
    assert_eq!(error(b"<a>\n\n\xc3</a>"), "line 3: byte 0xc3 is not UTF-8: save the file as UTF-8");
    assert_eq!(
        error(b"\n<SystemStructureDescription/>"),
        "line 2: SystemStructureDescription: this is not a model description, which begins with <fmiModelDescription"
    );
    assert_refused(
        "fmiVersion=\"2.0\"",
        "fmiVersion=\"3.0\"",
        4,
        &["fmiModelDescription: fmiVersion = \"3.0\" is not supported: it must be 2.0"],
    );
    assert_refused("fmiVersion=\"2.0\"", "fmiVersion=\"2.0.4\"", 4, &["fmiVersion = \"2.0.4\""]);
    assert_refused("fmiVersion=\"2.0\"", "", 4, &["fmiVersion is missing"]);
    let fmi_3 = "<fmiModelDescription fmiVersion=\"3.0\" instantiationToken=\"x\"/>";
    assert_eq!(
        error(fmi_3.as_bytes()),
        "line 1: fmiModelDescription: fmiVersion = \"3.0\" is not supported: it must be 2.0"
    );
}

#[test]
fn a_name_of_any_length_makes_no_long_sentence() {
    let error = refused("</Outputs>", &format!("</{}>", "x".repeat(100_000)));
    assert!(error.len() < 500, "{error}");
}

#[test]
fn what_is_no_xml_is_refused() {
    assert_refused("</Outputs>", "</Output>", 45, &["this is not XML", "Outputs", "Output"]);
    assert_refused("<Derivatives/>", "<Derivatives", 46, &["repair the tag"]);
    assert_refused("guid='{2}'", "guid={2}", 4, &["fmiModelDescription", "repair the tag"]);
    assert_refused("guid='{2}'", "guid", 4, &["fmiModelDescription", "repair the tag"]);
    assert_refused("guid='{2}'", "guid='{2}' guid='{2}'", 4, &["guid = \"{2}\": the attribute occurs twice"]);
    assert_refused("guid='{2}'", "guid='<2>'", 4, &["guid = \"<2>\"", "&lt;"]);
    assert_refused("guid='{2}'", "guid='&#1;'", 4, &["guid = \"&#1;\": "]);
    assert_refused("guid='{2}'", "guid='&#x110000;'", 4, &["guid = "]);
    assert_refused("guid='{2}'", "guid='\u{b}'", 4, &["guid = \"\\u{b}\": XML cannot represent the character"]);
    assert_refused("<Derivatives/>", "derivatives", 46, &["text inside ModelStructure"]);
    assert_refused("<Derivatives/>", "&amp;", 46, &["text inside ModelStructure"]);
    assert_refused("<Derivatives/>", "<![CDATA[x]]>", 46, &["text inside ModelStructure"]);
    assert_refused(
        "<!-- the end -->",
        "<fmiModelDescription/>",
        50,
        &["unexpected content after </fmiModelDescription>"],
    );
    assert_refused("<!-- the end -->", "the end", 50, &["unexpected content after"]);
    assert_refused("version='1.0'", "version='1.1'", 1, &["XML \"1.1\" is not supported"]);
    assert_refused("<!-- 1 -->", "<?xml version='1.0'?>", 26, &["the XML declaration is not at the start"]);
}

#[test]
fn entities_are_not_expanded_and_nothing_outside_is_opened() {
    for declaration in [
        "<!DOCTYPE a [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]>",
        "<!DOCTYPE a [<!ENTITY a SYSTEM \"file:///etc/passwd\">]>",
        "<!DOCTYPE a SYSTEM \"http://localhost/a.dtd\">",
        "<!DOCTYPE html>",
    ] {
        assert_refused("<!-- made by <hand> & foot -->", declaration, 2, &["<!DOCTYPE", "not supported"]);
    }
    assert_refused("guid='{2}'", "guid='&a;'", 4, &["guid = \"&a;\": only &lt; &gt;", "may follow an &"]);
    assert_refused("text &amp;", "text &a;", 23, &["entity &a; is not supported"]);
}

#[test]
fn elements_and_attributes_that_fmi_2_0_has_not_are_refused() {
    assert_refused(
        "<Derivatives/>",
        "<EventIndicators/>",
        46,
        &["EventIndicators: FMI 2.0 has no such element inside ModelStructure"],
    );
    assert_refused(
        "<DefaultExperiment stopTime=\" 1E3 \"/>",
        "<Default/>",
        12,
        &["Default: FMI 2.0 has no such element"],
    );
    assert_refused("<BaseUnit m=\"1\"/>", "<Base/>", 20, &["Base: FMI 2.0 has no such element inside Unit"]);
    assert_refused(
        "<BaseUnit m=\"1\"/>",
        "<BaseUnit m=\"1\"><x/></BaseUnit>",
        20,
        &["x: FMI 2.0 has no such element inside BaseUnit"],
    );
    assert_refused("<File name=\"a.c\"/>", "<Directory name=\"a.c\"/>", 10, &["Directory"]);
    assert_refused(
        "<SourceFiles><File name=\"a.c\"/>",
        "<Files/><SourceFiles>",
        10,
        &["Files: FMI 2.0 has no such element inside ModelExchange"],
    );
    assert_refused(
        "<Item name=\"green\" value=\"-2\"/>",
        "<Literal/>",
        17,
        &["Literal: FMI 2.0 has no such element inside Enumeration"],
    );
    assert_refused(
        "<Boolean start=\" 1 \"/>",
        "<Float64/>",
        39,
        &["Float64: FMI 2.0 has no such element inside ScalarVariable"],
    );
    assert_refused("<Enumeration><Item name=\"red\"", "<Binary/><Enumeration><Item name=\"red\"", 17, &["Binary"]);
    assert_refused(
        "<Boolean start=\" 1 \"/>",
        "<Boolean strat=\"1\"/>",
        39,
        &["Boolean: attribute \"strat\" is unknown: FMI 2.0 defines declaredType, start"],
    );
    assert_refused(
        "modelName=",
        "instantiationToken=\"\" modelName=",
        4,
        &["attribute \"instantiationToken\" is unknown"],
    );
    assert_refused(
        "<Outputs>",
        "<Outputs x=\"1\">",
        42,
        &["Outputs: attribute \"x\" is unknown: FMI 2.0 defines none"],
    );
}

#[test]
fn words_and_numbers_that_the_standard_has_not_are_refused_with_those_that_it_has() {
    let words = &[
        "ScalarVariable: causality = \"outptu\": expected one of parameter, calculatedParameter, input, output, local, independent",
    ];
    assert_refused("causality=\"output\"", "causality=\"outptu\"", 27, words);
    assert_refused(
        "variability=\"fixed\"",
        "variability=\"const\"",
        31,
        &["expected one of constant, fixed, tunable, discrete, continuous"],
    );
    assert_refused(
        "variability=\"fixed\"",
        "initial=\"Exact\"",
        31,
        &["initial = \"Exact\": expected one of exact, approx, calculated"],
    );
    assert_refused(
        "guid='{2}'",
        "guid='{2}' variableNamingConvention='free'",
        4,
        &["expected one of flat, structured"],
    );
    assert_refused(
        "dependent  fixed",
        "dependent linear",
        43,
        &[
            "dependenciesKind = \"dependent linear\": expected a list separated by spaces, with each item one of dependent, constant, fixed",
        ],
    );
    assert_refused(
        "stopTime=\" 1E3 \"",
        "stopTime=\"inf\"",
        12,
        &["DefaultExperiment: stopTime = \"inf\": expected a number"],
    );
    assert_refused("factor=\"100\"", "factor=\"1,5\"", 20, &["DisplayUnit: factor = \"1,5\""]);
    assert_refused(
        "max=\"+5\"",
        "max=\"5.0\"",
        37,
        &["Integer: max = \"5.0\": expected an integer from -2147483648 to 2147483647"],
    );
    assert_refused("max=\"+5\"", "max=\"2147483648\"", 37, &["max = \"2147483648\""]);
    assert_refused(
        "4294967295",
        "4294967296",
        27,
        &["valueReference = \"4294967296\": expected an integer from 0 to 4294967295"],
    );
    assert_refused("4294967295", "-1", 27, &["valueReference = \"-1\""]);
    assert_refused(
        "canGetAndSetFMUstate=\"1\"",
        "canGetAndSetFMUstate=\"yes\"",
        9,
        &["ModelExchange: canGetAndSetFMUstate = \"yes\": expected true or false"],
    );
    assert_refused("dependencies=\" 3", "dependencies=\" 3,", 43, &["dependencies = ", "expected a list"]);
}

#[test]
fn what_has_to_be_there_is_missed() {
    assert_refused("modelName=\"Foreign.Model\"", "", 4, &["fmiModelDescription: attribute modelName is missing"]);
    assert_refused("guid='{2}'", "", 4, &["attribute guid is missing"]);
    assert_refused(
        "modelIdentifier=\"Foreign_Model\"",
        "",
        9,
        &["ModelExchange: attribute modelIdentifier is missing"],
    );
    assert_refused("name=\"choice\"", "", 34, &["ScalarVariable: attribute name is missing"]);
    assert_refused("valueReference=\"4294967295\"", "", 27, &["attribute valueReference is missing"]);
    assert_refused("declaredType=\"Colour\"", "", 35, &["Enumeration: attribute declaredType is missing"]);
    assert_refused("index=\"1\"", "", 43, &["Unknown: attribute index is missing"]);
    assert_refused("<Boolean start=\" 1 \"/>", "", 39, &["ScalarVariable: the type is missing"]);
    assert_refused(
        "<Item name=\"green\" value=\"-2\"/>",
        "<Item name=\"green\"/>",
        17,
        &["Item: attribute value is missing"],
    );
    assert_refused("<Unit name=\"m\">", "<Unit>", 20, &["Unit: attribute name is missing"]);
    let without = |begin: &str, end: &str| {
        let (from, to) = (FOREIGN.find(begin).unwrap(), FOREIGN.find(end).unwrap() + end.len());
        read(format!("{}{}", &FOREIGN[..from], &FOREIGN[to..]).as_bytes()).unwrap_err().to_string()
    };
    assert_eq!(
        without("<ModelStructure>", "</ModelStructure>"),
        "line 4: fmiModelDescription: element ModelStructure is missing: add it"
    );
    assert_eq!(
        without("<ModelVariables>", "</ModelVariables>"),
        "line 4: fmiModelDescription: element ModelVariables is missing: add it"
    );
    assert!(
        without("<ModelExchange ", "</ModelExchange>").contains("neither ModelExchange nor CoSimulation is present")
    );
}

#[test]
fn elements_that_may_be_there_once_are_refused_the_second_time() {
    let twice = |element: &str, line: usize| {
        assert_refused(element, &format!("{element}\n{element}"), line + 1, &["occurs twice"])
    };
    twice("<DefaultExperiment stopTime=\" 1E3 \"/>", 12);
    twice("<BaseUnit m=\"1\"/>", 20);
    twice("<Derivatives/>", 46);
    assert_refused(
        "<Boolean start=\" 1 \"/>",
        "<Boolean start=\"1\"/><Boolean/>",
        39,
        &["Boolean: a variable can have only one type"],
    );
    assert_refused(
        "<Enumeration><Item name=\"red\"",
        "<Boolean/><Enumeration><Item name=\"red\"",
        17,
        &["a SimpleType can have only one type"],
    );
    assert_refused("</Annotations>", "</Annotations><Annotations/>", 29, &["Annotations: the element occurs twice"]);
    assert_refused("</SourceFiles>", "</SourceFiles><SourceFiles/>", 10, &["SourceFiles: the element occurs twice"]);
}

#[test]
fn a_description_that_contradicts_itself_is_refused() {
    assert_refused("name=\"text\"", "name=\"level\"", 31, &["variable \"level\": the name is used twice"]);
    assert_refused(
        "Real declaredType=\"Level\" unit=\"m\"",
        "Real unit=\"mm\"",
        27,
        &["variable \"level\": unit = \"mm\" is not defined"],
    );
    assert_refused(
        "declaredType=\"Level\"",
        "declaredType=\"level\"",
        27,
        &["declaredType = \"level\" is not defined"],
    );
    assert_refused(
        "declaredType=\"Colour\"",
        "declaredType=\"Level\"",
        34,
        &["declaredType = \"Level\" is not of type Enumeration"],
    );
    assert_refused(
        "declaredType=\"Level\" unit=\"m\"",
        "declaredType=\"Level\" start=\"3\"",
        27,
        &["start = 3.0 is above max = 2.5"],
    );
    assert_refused("min=\"-5\"", "min=\"6\"", 37, &["variable \"alias of choice\": min = 6 is above max = 5"]);
    assert_refused("min=\"-INF\"", "min=\"NaN\"", 38, &["min = NaN"]);
    let alias = "\"alias of choice\" valueReference=\"0\"";
    assert_refused(
        alias,
        &format!("{alias} causality=\"input\""),
        37,
        &["valueReference = 0 is also used by \"choice\""],
    );
    assert!(
        refused("index=\"1\"", "index=\"7\"")
            .contains("Outputs: Unknown with index = 7: no such variable; the indices are 1 to 6")
    );
    assert!(refused("dependencies=\" 3", "dependencies=\" 0").contains("dependencies has 0"));
    assert!(
        refused("dependent  fixed", "fixed").contains("dependenciesKind and dependencies differ in length (1 and 2)")
    );
    assert!(
        refused("<Unit name=\"m\">", "<Unit name=\"m\"/><Unit name=\"m\">").contains("Unit \"m\" is defined twice")
    );
}

#[test]
fn aliases_are_read_and_so_is_a_start_that_is_no_item() {
    // Variables of one type that share a value reference are aliases; variables of different types are distinct.
    let description = parsed(FOREIGN);
    assert_eq!(description.model_variables.iter().filter(|variable| variable.value_reference == 0).count(), 4);
    // Some tools write 0 for "no start value", although the range of the type begins with 1.
    parsed(&FOREIGN.replace("start=\"-2\"", "start=\"0\""));
}

#[test]
fn a_long_value_is_shortened_in_the_message() {
    let error = refused("4294967295", &"9".repeat(100_000));
    assert!(error.len() < 300 && error.contains("99…\""), "{error}");
    let error = refused("<Derivatives/>", &format!("<{}/>", "ä".repeat(100_000)));
    assert!(error.len() < 400 && error.contains("ää…:"), "{error}");
}

/// Returns the error for the foreign description within these limits.
fn beyond(change: impl FnOnce(&mut Limits)) -> Option<String> {
    let mut limits = Limits::default();
    change(&mut limits);
    read_within(FOREIGN.as_bytes(), limits).err().map(|error| error.to_string())
}

#[test]
fn what_is_larger_than_the_limits_is_refused() {
    let size = FOREIGN.len();
    assert_eq!(beyond(|limits| limits.bytes = size), None);
    let expected = format!("the model description has {size} bytes: the limit is {}", size - 1);
    assert_eq!(beyond(|limits| limits.bytes = size - 1), Some(expected));
    assert_eq!(beyond(|limits| limits.variables = 6), None);
    let expected = "line 39: ScalarVariable: too many variables: the limit is 5";
    assert_eq!(beyond(|limits| limits.variables = 5), Some(expected.into()));
    // Each ends with /> or has an end tag.
    let elements = FOREIGN.matches("/>").count() + FOREIGN.matches("</").count();
    assert_eq!(beyond(|limits| limits.elements = elements), None);
    let found = beyond(|limits| limits.elements = elements - 1).unwrap();
    assert!(found.starts_with("line 47: too many elements: the limit is "), "{found}");
    // Tool, x:deep, and x:deeper or y.
    assert_eq!(beyond(|limits| limits.depth = 3), None);
    let expected = "line 22: VendorAnnotations: the elements inside are nested too deeply: the limit is 2";
    assert_eq!(beyond(|limits| limits.depth = 2), Some(expected.into()));
}

#[test]
fn elements_within_elements_without_end_are_refused_and_do_not_exhaust_the_stack() {
    let deep = "<x>".repeat(1_000_000);
    assert_refused(
        "<y/>",
        &deep,
        22,
        &["VendorAnnotations: the elements inside are nested too deeply: the limit is 64"],
    );
    assert_refused("<Derivatives/>", &deep, 46, &["x: FMI 2.0 has no such element inside ModelStructure"]);
}
