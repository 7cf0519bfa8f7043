//! From a model description to XML.

use crate::sample::{everything, smallest, variable};
use modeldescription::v2::*;

fn text(description: &ModelDescription) -> String {
    String::from_utf8(write(description)).unwrap()
}

/// Returns the XML of a model whose only variable is a Real with this start value.
fn with_start(start: f64) -> String {
    let real = Typed::Real(Real { start: Some(start), ..Real::default() });
    text(&ModelDescription { model_variables: vec![variable("X", 0, real)], ..smallest() })
}

#[test]
fn a_small_model_is_this_text() {
    let expected = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="SMALL" guid="{1}" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="SMALL" needsExecutionTool="false" canHandleVariableCommunicationStepSize="false" canInterpolateInputs="false" maxOutputDerivativeOrder="0" canRunAsynchronuously="false" canBeInstantiatedOnlyOncePerProcess="false" canNotUseMemoryManagementFunctions="false" canGetAndSetFMUstate="false" canSerializeFMUstate="false" providesDirectionalDerivative="false"/>
  <ModelVariables>
    <ScalarVariable name="OUT" valueReference="0" causality="output" variability="discrete">
      <Real/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="1" dependencies=""/>
    </Outputs>
    <InitialUnknowns>
      <Unknown index="1" dependencies=""/>
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"#;
    assert_eq!(text(&smallest()), expected);
}

/// The reader and the writer use the same definition of each name, so that a misspelled name would pass a round trip.
#[test]
fn every_element_and_attribute_has_the_name_and_the_place_that_the_standard_gives_it() {
    assert_eq!(text(&everything()), include_str!("everything.xml"));
}

#[test]
fn the_root_has_the_version_2_0_and_no_namespace() {
    let xml = text(&everything());
    assert!(xml.contains("<fmiModelDescription fmiVersion=\"2.0\" "));
    assert!(!xml.contains("xmlns"));
}

#[test]
fn the_children_of_the_root_are_in_the_order_of_the_schema() {
    let xml = text(&everything());
    let places = [
        "<ModelExchange ",
        "<CoSimulation ",
        "<UnitDefinitions>",
        "<TypeDefinitions>",
        "<LogCategories>",
        "<DefaultExperiment ",
        "<ModelVariables>",
        "<ModelStructure>",
        "<Outputs>",
        "<Derivatives>",
        "<InitialUnknowns>",
    ]
    .map(|tag| xml.find(tag).unwrap());
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn lists_without_items_are_left_out() {
    let description = ModelDescription {
        model_exchange: Some(ModelExchange::default()),
        unit_definitions: vec![Unit { name: "1".into(), ..Unit::default() }],
        model_structure: ModelStructure::default(),
        ..smallest()
    };
    let xml = text(&description);
    for list in ["SourceFiles", "TypeDefinitions", "LogCategories", "Outputs", "Derivatives", "InitialUnknowns"] {
        assert!(!xml.contains(list), "{list}");
    }
    assert!(xml.contains("<Unit name=\"1\"/>") && xml.contains("<ModelStructure/>"));
}

#[test]
fn the_list_of_variables_is_written_even_if_it_is_empty() {
    let xml = text(&ModelDescription { model_variables: Vec::new(), ..smallest() });
    assert!(xml.contains("<ModelVariables>\n  </ModelVariables>"), "{xml}");
}

#[test]
fn no_dependencies_are_written_as_an_empty_list_and_unknown_ones_not_at_all() {
    let xml = text(&everything());
    assert!(xml.contains("<Unknown index=\"1\" dependencies=\"\"/>"));
    assert!(xml.contains("<Unknown index=\"2\"/>"));
    assert!(
        xml.contains("dependencies=\"3 5 6 7 8\" dependenciesKind=\"dependent constant fixed tunable discrete\"/>")
    );
}

#[test]
fn markup_quotes_and_line_breaks_in_texts_are_escaped() {
    let description = Some("a<b>c & \"d\" 'e'\nf\tg\rh".to_string());
    let xml = text(&ModelDescription { description, ..smallest() });
    let expected = "description=\"a&lt;b&gt;c &amp; &quot;d&quot; &apos;e&apos;&#10;f&#9;g&#13;h\"";
    assert!(xml.contains(expected), "{xml}");
}

#[test]
fn characters_that_xml_cannot_hold_are_replaced() {
    let description = Some("a\u{1}b\u{fffe}c".to_string());
    assert!(text(&ModelDescription { description, ..smallest() }).contains("description=\"a\u{fffd}b\u{fffd}c\""));
}

#[test]
fn numbers_have_the_fewest_digits_that_read_back_the_same() {
    assert!(with_start(0.1).contains("start=\"0.1\""));
    assert!(with_start(f64::from(0.1_f32)).contains("start=\"0.10000000149011612\""));
    assert!(with_start(20.0).contains("start=\"20.0\""));
    assert!(with_start(-0.0).contains("start=\"-0.0\""));
    assert!(with_start(f64::MAX).contains("start=\"1.7976931348623157e308\""));
    assert!(with_start(f64::NEG_INFINITY).contains("start=\"-INF\""));
}

#[test]
fn what_is_zero_or_one_by_default_is_left_out_of_units() {
    let base_unit = Some(BaseUnit { m: 2, s: -1, ..BaseUnit::default() });
    let display_units = vec![DisplayUnit { name: "d".into(), factor: 1.0, offset: 0.0 }];
    let unit = Unit { name: "u".into(), base_unit, display_units };
    let xml = text(&ModelDescription { unit_definitions: vec![unit], ..smallest() });
    assert!(xml.contains("<BaseUnit m=\"2\" s=\"-1\"/>") && xml.contains("<DisplayUnit name=\"d\"/>"), "{xml}");
}

#[test]
fn the_same_description_gives_the_same_bytes() {
    assert_eq!(write(&everything()), write(&everything().clone()));
}
