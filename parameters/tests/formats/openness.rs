use super::*;

fn document(block: &str) -> String {
    format!(
        "\u{feff}<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Document>\n<Engineering version=\"V17\" />\n{block}\n</Document>"
    )
}

fn instance(attributes: &str, sections: &str) -> String {
    document(&format!(
        "<SW.Blocks.InstanceDB ID=\"0\"><AttributeList>{attributes}<Interface>\
         <Sections xmlns=\"http://www.siemens.com/automation/Openness/SW/Interface/v3\">\n{sections}\n</Sections></Interface>\
         </AttributeList></SW.Blocks.InstanceDB>"
    ))
}

const PUMP: &str = "<InstanceOfName>PUMP</InstanceOfName><Name>TIC101</Name><Number>41</Number>";

#[test]
fn start_values_are_read_and_what_has_none_has_that_of_the_block() {
    let text = instance(
        PUMP,
        "<Section Name=\"Input\"><Member Name=\"GAIN\" Datatype=\"Real\"><StartValue>2.5e0</StartValue></Member>\
         <Member Name=\"ON\" Datatype=\"Bool\"><StartValue Informative=\"true\"> TRUE </StartValue></Member>\
         <Member Name=\"MAN\" Datatype=\"Real\" Accessibility=\"Public\"><AttributeList/></Member>\
         <Member Name=\"TI\" Datatype=\"Time\">\n<StartValue>\n  T#1s500ms</StartValue></Member></Section>\
         <Section Name=\"Output\"><Member Name=\"LMN\" Datatype=\"Real\"><StartValue>9</StartValue></Member></Section>\
         <Section Name=\"Static\"><Member Name=\"sRest\" Datatype=\"Real\"/></Section>",
    );
    let loops = loops(Format::Openness, text);
    let [one] = loops.as_slice() else { panic!("{loops:?}") };
    assert_eq!((one.name.as_str(), one.block.name.as_str()), ("TIC101", "PUMP"));
    assert_eq!(given(one), ["ON", "GAIN", "TI"]);
    assert_eq!(one.get("GAIN"), Some(Value::Real(2.5)));
    assert_eq!(one.get("TI"), Some(Value::Time(Time::ms(1500))));
    assert_eq!(one.get("MAN"), Some(Value::Real(5.0)));
    assert_eq!(origin(one, "TI"), "plant.xml:7:3");
}

#[test]
fn an_instance_without_name_is_called_by_its_number_or_as_the_file() {
    let of = |attributes: &str| loops(Format::Openness, instance(attributes, ""))[0].name.clone();
    assert_eq!(of("<InstanceOfName>\"fb 410\"</InstanceOfName><Number>41</Number>"), "DB41");
    assert_eq!(of("<InstanceOfName>PUMP</InstanceOfName>"), "plant");
}

#[test]
fn a_technology_object_is_an_instance() {
    let object = |attributes: &str| {
        instance(attributes, "<Section Name=\"Input\"><Member Name=\"GAIN\" Datatype=\"Real\"><StartValue>2.5</StartValue></Member></Section>")
            .replace("SW.Blocks.InstanceDB", "SW.TechnologicalObjects.TechnologicalInstanceDB")
    };
    for attributes in [
        "<InstanceOfName>PUMP</InstanceOfName><Name>TIC101</Name>",
        "<Name>TIC101</Name><OfSystemLibElement>PUMP</OfSystemLibElement><OfSystemLibVersion>1.1</OfSystemLibVersion>",
        "<InstanceOfName>PUMP_DB_1</InstanceOfName><Name>TIC101</Name><OfSystemLibElement>PUMP</OfSystemLibElement>",
    ] {
        let loops = loops(Format::Openness, object(attributes));
        assert_eq!((loops[0].name.as_str(), loops[0].get("GAIN")), ("TIC101", Some(Value::Real(2.5))), "{attributes}");
    }
}

#[test]
fn each_element_of_an_array_of_instances_is_a_loop_with_its_own_values() {
    let member = |inner: &str| {
        format!(
            "<Member Name=\"r\" Datatype=\"Array[1..2] of &quot;VALVE&quot;\"><Sections><Section Name=\"Input\">\
             <Member Name=\"TRAVEL\" Datatype=\"Real\">{inner}</Member></Section></Sections></Member>"
        )
    };
    let travels = |sections: String| -> Vec<(String, Option<Value>)> {
        let text = instance(
            "<InstanceOfName>Line</InstanceOfName><Name>DB_Line</Name>",
            &format!("<Section Name=\"Static\">{sections}</Section>"),
        );
        loops(Format::Openness, text).iter().map(|one| (one.name.clone(), one.get("TRAVEL"))).collect()
    };
    let value =
        |path: &str, value: &str| format!("<Subelement Path=\"{path}\"><StartValue>{value}</StartValue></Subelement>");
    let found = travels(member(&(value("1", "3.0") + &value("2", "4.0"))));
    assert_eq!(found, [("r[1]".into(), Some(Value::Real(3.0))), ("r[2]".into(), Some(Value::Real(4.0)))]);
    // A nested array: the path contains both indices.
    let inner = member(&value("5,2", "7.0"));
    let found = travels(format!(
        "<Member Name=\"line\" Datatype=\"Array[5..5] of &quot;Line&quot;\"><Sections><Section Name=\"Static\">{inner}\
         </Section></Sections></Member>"
    ));
    assert_eq!(found[1], ("r[2]".into(), Some(Value::Real(7.0))));
    assert_ne!(found[0].1, found[1].1);
}

#[test]
fn instances_inside_another_block_are_called_as_their_members() {
    let inner = |name: &str, travel: &str| {
        format!(
            "<Member Name=\"{name}\" Datatype=\"&quot;VALVE&quot;\"><Sections><Section Name=\"Input\">\
             <Member Name=\"TRAVEL\" Datatype=\"Real\"><StartValue>{travel}</StartValue></Member></Section></Sections></Member>"
        )
    };
    let sections = format!("<Section Name=\"Static\">{}{}</Section>", inner("LEFT", "3.0"), inner("RIGHT", "4.0"));
    let loops =
        loops(Format::Openness, instance("<InstanceOfName>Line</InstanceOfName><Name>DB_Line</Name>", &sections));
    let found: Vec<_> = loops.iter().map(|one| (one.name.as_str(), one.get("TRAVEL"))).collect();
    assert_eq!(found, [("LEFT", Some(Value::Real(3.0))), ("RIGHT", Some(Value::Real(4.0)))]);
}

#[test]
fn instances_of_one_name_are_told_apart_by_their_data_blocks() {
    let block = |id: u8, name: &str| {
        format!(
            "<SW.Blocks.InstanceDB ID=\"{id}\"><AttributeList><InstanceOfName>Line</InstanceOfName><Name>{name}</Name>\
             <Interface><Sections><Section Name=\"Static\"><Member Name=\"TIC\" Datatype=\"VALVE\"><Sections/></Member>\
             </Section></Sections></Interface></AttributeList></SW.Blocks.InstanceDB>\n"
        )
    };
    let names = |text: &str| -> Vec<String> {
        loops(Format::Openness, document(text)).into_iter().map(|one| one.name).collect()
    };
    assert_eq!(names(&block(0, "L1")), ["TIC"]);
    assert_eq!(names(&(block(0, "L1") + &block(1, "L2"))), ["L1.TIC", "L2.TIC"]);
    assert_eq!(
        refusal(Format::Openness, document(&(block(0, "L1") + &block(1, "L1")))),
        "plant.xml:5:1: the data block `L1` appears twice: remove or rename one"
    );
}

#[test]
fn a_block_under_another_name_is_known_by_its_members() {
    let member = |name: &str, datatype: &str| format!("<Member Name=\"{name}\" Datatype=\"{datatype}\"/>");
    let all = member("GAIN", "Real") + &member("TRAVEL", "Real") + &member("CYCLE", "Time");
    let of = |members: &str| {
        let sections = format!("<Section Name=\"Input\">{members}</Section>");
        instance("<InstanceOfName>VALVE_1</InstanceOfName><Name>A</Name>", &sections)
    };
    assert_eq!(loops(Format::Openness, of(&all))[0].block.name, "VALVE");
    for other in [all.replace("Time", "DInt"), all.clone() + &member("X", "Int")] {
        assert_eq!(
            refusal(Format::Openness, of(&other)),
            "plant.xml: the file contains no instance of a known block; known blocks: PUMP, VALVE, STATION"
        );
    }
    let reading = reading(Format::Openness, of(&member("TRAVEL", "Real")), &of_block("VALVE")).unwrap();
    assert_eq!(reading.loops[0].block.name, "VALVE");
}

#[test]
fn other_blocks_are_skipped_with_a_remark() {
    let of = |id: u8, name: &str, of: &str| {
        format!(
            "<SW.Blocks.InstanceDB ID=\"{id}\"><AttributeList><InstanceOfName>{of}</InstanceOfName><Name>{name}</Name>\
             <Interface><Sections/></Interface></AttributeList></SW.Blocks.InstanceDB>\n"
        )
    };
    let function_block = of(2, "PUMP", "").replace("InstanceDB", "FB");
    let text = document(&(of(0, "M1", "MOTOR") + &of(1, "P1", "PUMP") + &function_block));
    let reading = reading(Format::Openness, text, &Options::default()).unwrap();
    assert_eq!(reading.loops.len(), 1);
    assert_eq!(
        reading.remarks.to_string(),
        "plant.xml:4:1: `M1` (`MOTOR`) is not an instance of a known block: skipped\n\
         plant.xml:6:1: `PUMP` is not a data block: skipped"
    );
}

#[test]
fn a_member_a_type_and_a_value_that_the_block_does_not_have_are_refused_together() {
    let text = instance(
        PUMP,
        "<Section Name=\"Input\">\n<Member Name=\"GAINN\" Datatype=\"Real\"/>\n<Member Name=\"MAN\" Datatype=\"LReal\"/>\n\
         <Member Name=\"GAIN\" Datatype=\"Real\"><StartValue>TRUE</StartValue></Member>\n\
         <Member Name=\"TI\" Datatype=\"Time\"/>\n<Member Name=\"ti\" Datatype=\"Time\"/>\n</Section>",
    );
    assert_eq!(
        refusal(Format::Openness, text),
        "plant.xml:6:1: PUMP has no input or parameter `GAINN`; did you mean GAIN?\n\
         plant.xml:7:1: MAN of PUMP: expected the type REAL, found `LReal`\n\
         plant.xml:8:49: GAIN: expected a REAL such as 2.5 or 1.0e-3, found `TRUE`\n\
         plant.xml:10:1: TI appears twice: remove one"
    );
}

#[test]
fn what_is_no_export_is_refused() {
    let sentence = "expected a TIA Portal Openness Document with an SW.Blocks.InstanceDB or a technology object, found";
    assert_eq!(refusal(Format::Openness, "<a/>"), format!("plant.xml:1:1: {sentence} `a`"));
    // Openness also exports other objects: nothing in the file is wrong, so the error has no position.
    assert_eq!(refusal(Format::Openness, "<Document/>"), format!("plant.xml: {sentence} none"));
}

#[test]
fn a_data_block_is_written_for_each_loop() {
    let loops = [Loop::new("A", valve()), Loop::new("B", valve())];
    let text = String::from_utf8(parameters::write(Format::Openness, &loops, "Made -- by hand").unwrap()).unwrap();
    let start = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- Made - - by hand -->\n<Document>\n  \
                 <SW.Blocks.InstanceDB ID=\"0\">\n    <AttributeList>\n      <InstanceOfName>VALVE</InstanceOfName>\n";
    assert!(text.starts_with(start), "{text}");
    assert!(text.contains("<SW.Blocks.InstanceDB ID=\"1\">"), "{text}");
    assert!(text.contains("<Member Name=\"POSITION\" Datatype=\"Real\"/>"), "{text}");
    assert_eq!(
        parameters::write(Format::Openness, &[Loop::new("S", station())], ""),
        Err("STATION contains other blocks (DI_PUMP.GAIN), which cannot be written as Openness XML: use JSON or SSV"
            .into())
    );
    let error = parameters::write(Format::Openness, &[Loop::new("A\u{1}", valve())], "").unwrap_err();
    assert_eq!(error, "XML cannot represent the character '\\u{1}' in `A\\u{1}`");
}
