use super::*;
use blocks::Role;
use modeldescription::Interface;
use parameters::Origin;
use std::sync::Arc;

/// What the library of a small block tells of it.
const TABLE: &str = r#"{"table":{"name":"PUMP","docs":"Pumps.","cycle":1,"variables":[
    {"name":"FLOW","description":"x","kind":"REAL","role":"input","start":1.0,"min":0.0,"max":2.0,"unit":null},
    {"name":"CYCLE","description":"x","kind":"TIME","role":"cycle","start":1.0,"min":0.001,"max":null,"unit":null}],
    "responses":[{"title":"x","calls":3,"set":[],"show":[]}]},
    "interface":{"version":"2.0","guid":"{1}","capabilities":{},"log_categories":[]}}"#;

fn values() -> parameters::Loop {
    let members = vec![
        Row::new("FLOW", Role::Input, Value::Real(1.0)),
        Row::new("CYCLE", Role::Cycle, Value::Time(blocks::Time::ms(1000))),
    ];
    let mut values = parameters::Loop::new("P 1", Arc::new(BlockType::new("PUMP".into(), Vec::new(), members)));
    values.set(0, Value::Real(7.5), Origin::Default);
    values
}

#[test]
fn a_preset_is_three_files_with_one_guid_and_leaves_the_recorded_results_out() {
    let xml = ModelDescription::from_interface(&Interface::parse(TABLE).unwrap()).unwrap();
    let page = "<p>{1}</p><!-- preset --><!-- end of preset --><!-- recorded -->x<!-- end of recorded -->";
    let original = Original { xml: &xml, description: &xml.description(), library: "{1}", page: Some(page) };
    let preset = original.preset(&values()).unwrap();
    assert_eq!(preset.name, "P_1");
    assert_eq!(preset.files.keys().collect::<Vec<_>>(), [PAGE, DESCRIPTION, "resources/start.txt"]);
    let start = &preset.files["resources/start.txt"];
    assert!(start.contains("library = {1}\n") && start.contains("FLOW = 7.5\n"), "{start}");
    assert_eq!(preset.guid, guid_of(start));
    let declared = ModelDescription::read(preset.files[DESCRIPTION].as_bytes()).unwrap().description();
    assert_eq!((declared.guid.as_str(), declared.model_name.as_str()), (preset.guid.as_str(), "P_1"));
    assert!(preset.files[PAGE].starts_with(&format!("<p>{}</p>", preset.guid)));
    assert_eq!(preset.left_out, ["extra/org.fmi-standard.fmi-ls-ref/", "documentation/fmi-ls-ref.txt", "sources/"]);
}

#[test]
fn a_name_becomes_an_identifier_that_is_a_file_name_everywhere() {
    for (name, expected) in [
        ("TIC101", "TIC101"),
        ("TIC 10-1/A", "TIC_10_1_A"),
        ("41", "_41"),
        ("Öl", "_l"),
        ("", "_"),
        ("nul", "nul_"),
        ("COM1", "COM1_"),
        ("COMB", "COMB"),
    ] {
        assert_eq!(identifier(name), expected);
    }
}
