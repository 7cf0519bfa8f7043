use super::*;
use proptest::prelude::*;

fn table(file: &str, text: &str) -> Result<Tags, Problems> {
    read(&Source::new(file, text.as_bytes().to_vec()))
}

fn tag(name: &str, of: &str, address: Option<&str>, comment: &str) -> Tag {
    Tag { name: name.into(), of: of.into(), address: address.map(str::to_string), comment: comment.into() }
}

fn constant(name: &str, value: &str) -> Constant {
    Constant { name: name.into(), value: value.into() }
}

/// Two tags and a constant of a mixer.
const OPENNESS: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<Document>
  <Engineering version="V18" />
  <SW.Tags.PlcTagTable ID="0">
    <AttributeList><Name>Mixer</Name></AttributeList>
    <ObjectList>
      <SW.Tags.PlcUserConstant ID="1" CompositionName="UserConstants">
        <AttributeList><DataTypeName>Int</DataTypeName><Name>BATCHES</Name><Value>12</Value></AttributeList>
      </SW.Tags.PlcUserConstant>
      <SW.Tags.PlcTag ID="2" CompositionName="Tags">
        <AttributeList>
          <DataTypeName>Bool</DataTypeName>
          <LogicalAddress>%I2.5</LogicalAddress>
          <Name>Lid closed</Name>
        </AttributeList>
        <ObjectList>
          <MultilingualText ID="3" CompositionName="Comment">
            <ObjectList>
              <MultilingualTextItem ID="4" CompositionName="Items">
                <AttributeList><Culture>de-DE</Culture><Text>Deckel &amp; Riegel zu</Text></AttributeList>
              </MultilingualTextItem>
              <MultilingualTextItem ID="5" CompositionName="Items">
                <AttributeList><Culture>en-US</Culture><Text>lid &amp; latch
                closed</Text></AttributeList>
              </MultilingualTextItem>
            </ObjectList>
          </MultilingualText>
        </ObjectList>
      </SW.Tags.PlcTag>
      <SW.Tags.PlcTag ID="6" CompositionName="Tags">
        <AttributeList>
          <DataTypeName>"mixerState"</DataTypeName>
          <LogicalAddress />
          <Name>State</Name>
        </AttributeList>
      </SW.Tags.PlcTag>
    </ObjectList>
  </SW.Tags.PlcTagTable>
</Document>
"#;

const SDF: &str = "\"Lid\",\"%I2.5\",\"Bool\",\"True\",\"True\",\"False\",\"lid, and \"\"latch\"\"\",\"\",\"True\"\r\n\
    \"Speed\",\"%QW64\",\"Int\",\"True\",\"True\",\"False\",\"\",\"\",\"True\"\r\n\
    \"BATCHES\",\"CONSTANT\",\"Int\",\"\",\"\",\"\",\"per shift\",\"12\",\"\"\r\n";

#[test]
fn tags_and_constants_of_openness_xml_are_read_with_an_english_comment() {
    assert!(is_table(OPENNESS));
    let expected = Tags {
        tags: vec![
            tag("Lid closed", "Bool", Some("%I2.5"), "lid & latch closed"),
            tag("State", "mixerState", None, ""),
        ],
        constants: vec![constant("BATCHES", "Int#12")],
    };
    assert_eq!(table("Mixer.xml", OPENNESS), Ok(expected));
}

#[test]
fn a_damaged_document_is_refused_with_its_line() {
    let wrong = |text: &str| table("Mixer.xml", text).unwrap_err().to_string();
    let without = OPENNESS.replace("<DataTypeName>Bool</DataTypeName>", "");
    assert_eq!(wrong(&without), "Mixer.xml:10:7: SW.Tags.PlcTag `Lid closed` has no DataTypeName");
    let entity = format!("<!DOCTYPE a [<!ENTITY b \"c\">]>{OPENNESS}");
    assert!(wrong(&entity).contains("a document type definition (DTD) is not supported"), "{}", wrong(&entity));
    assert!(wrong(&OPENNESS.replace("&amp;", "&b;")).contains("the entity `&b;` is unknown"));
    assert!(wrong("<Document/>").contains("expected a Document with an SW.Tags.PlcTagTable"));
}

#[test]
fn rows_of_an_sdf_have_nine_cells_or_four() {
    let expected = Tags {
        tags: vec![tag("Lid", "Bool", Some("%I2.5"), "lid, and \"latch\""), tag("Speed", "Int", Some("%QW64"), "")],
        constants: vec![constant("BATCHES", "Int#12")],
    };
    assert_eq!(table("PLCTags.sdf", SDF), Ok(expected));
    let step7 = "\"Lid                     \",\"E      2.5\",\"BOOL      \",\"lid\"\n\"Mixer\",\"FB     7\",\"FB     7\",\"\"\n";
    assert_eq!(table("a.SDF", step7).unwrap().tags, [tag("Lid", "BOOL", Some("%I2.5"), "lid")]);
    let wrong = |text: &str| table("a.sdf", text).unwrap_err().to_string();
    let expected = "a.sdf:2:1: expected a name, an address and a type in quotation marks, found `Lid`";
    assert_eq!(wrong("\n\"Lid\"\n"), expected);
    assert_eq!(wrong("\"Lid\",\"%I2.5"), "a.sdf:1:1: the quotation mark is not closed");
    assert!(wrong(&SDF.replace("\"12\"", "\"\"")).contains("a.sdf:3:1: the constant `BATCHES` has no value"));
}

/// Without its address, a tag would silently be neither an input nor an output.
#[test]
fn a_damaged_address_is_told_with_its_row() {
    let wrong = |place: &str| table("a.sdf", &SDF.replace("%QW64", place)).unwrap_err().to_string();
    for damaged in ["%QW6x", "%XW64", "%Q4.8", "%Q1.2.3", "QW", "%QWB4"] {
        let expected = "of `Speed` is not an input, output or memory address such as %I0.0 or %QW4";
        assert_eq!(wrong(damaged), format!("a.sdf:2:1: the address `{damaged}` {expected}"));
    }
    // S5 timers and counters have addresses, too.
    for (place, address) in [("T 5", None), ("%C12", None), ("", None), ("AB 7", Some("%QB7"))] {
        let tags = table("a.sdf", &SDF.replace("%QW64", place)).unwrap().tags;
        assert_eq!(tags[1].address.as_deref(), address, "{place}");
    }
    let xml = table("Mixer.xml", &OPENNESS.replace("%I2.5", "%I2.9")).unwrap_err().to_string();
    assert!(xml.starts_with("Mixer.xml:10:7: the address `%I2.9` of `Lid closed` is not an input"), "{xml}");
    let row = |number, cells: [&str; 3]| (number, cells.map(String::from).to_vec());
    let rows = [row(1, ["Name", "Data Type", "Logical Address"]), row(3, ["Lid", "Bool", "I2,5"])];
    let sheet = of_sheet(&rows, &mut Tags::default()).unwrap_err();
    assert!(sheet.starts_with("row 3: the address `I2,5` of `Lid` is not an input"), "{sheet}");
}

#[test]
fn sheets_are_known_by_their_headings() {
    let row = |number, cells: &[&str]| (number, cells.iter().map(ToString::to_string).collect::<Vec<_>>());
    let tags = [
        row(1, &["Name", "Path", "Data Type", "Logical Address", "Comment", "Hmi Visible"]),
        row(2, &["Lid", "Mixer", "Bool", "%I2.5", "lid\n closed", "True"]),
        row(4, &["", "", ""]),
        row(5, &["State", "Mixer", "\"mixerState\""]),
    ];
    let constants =
        [row(1, &["Name", "Path", "Data Type", "Value", "Comment"]), row(2, &["LIMIT", "Mixer", "Real", "2,5", ""])];
    let mut found = Tags::default();
    assert_eq!(of_sheet(&tags, &mut found), Ok(true));
    assert_eq!(of_sheet(&constants, &mut found), Ok(true));
    assert_eq!(of_sheet(&[row(1, &["Path", "BelongsToUnit"])], &mut found), Ok(false));
    assert_eq!(found.tags, [tag("Lid", "Bool", Some("%I2.5"), "lid closed"), tag("State", "mixerState", None, "")]);
    assert_eq!(found.constants, [constant("LIMIT", "Real#2.5")]);
    let without = [tags[0].clone(), row(7, &["Lid", "Mixer", "", "%I2.5"])];
    let wrong = of_sheet(&without, &mut Tags::default()).unwrap_err();
    assert_eq!(wrong, "row 7 has no data type: `Lid Mixer  %I2.5`");
}

#[test]
fn a_line_declares_a_tag_or_a_constant() {
    let read = |text: &str| table("tags.txt", text).unwrap();
    let list = "// by hand\n\nStart : Bool\n\"Level: 1\" AT EW64 : Int; // Level;  unit: mm\nMAX : Int := 5\n\
        SITE : String := 'a//b' // where\nLamp at %q* : Bool\n";
    let found = read(list);
    let expected = [
        tag("Start", "Bool", None, ""),
        tag("Level: 1", "Int", Some("%IW64"), "Level; unit: mm"),
        tag("Lamp", "Bool", Some("%Q*"), ""),
    ];
    assert_eq!(found.tags, expected);
    assert_eq!(found.tags[2].area(), Some(Area::Output));
    assert_eq!(found.constants, [constant("MAX", "Int#5"), constant("SITE", "'a//b'")]);
    let again: String = found.tags.iter().map(|tag| format!("{tag}\n")).collect();
    assert_eq!(read(&again).tags, expected);
    let wrong = table("tags.txt", "Start : Bool\nStop\nLamp AT DB1.DBX0 : Bool\n").unwrap_err().to_string();
    let lines: Vec<&str> = wrong.lines().collect();
    assert!(lines[0].starts_with("tags.txt:2:1: write a name, a colon and a type, such as Start : Bool"), "{wrong}");
    assert!(lines[1].starts_with("tags.txt:3:1: DB1.DBX0 is not an input, output or memory address"), "{wrong}");
}

#[test]
fn addresses_are_those_of_both_mnemonics() {
    for (written, expected) in [
        ("%I0.0", Some("%I0.0")),
        ("A 4.1", Some("%Q4.1")),
        ("PEW 256", Some("%IW256")),
        ("%QD8:P", Some("%QD8")),
        ("MD 20", Some("%MD20")),
        ("%IX0.1", Some("%IX0.1")),
        ("%T5", None),
        ("DB1.DBW2", None),
        ("MOTOR", None),
        ("", None),
    ] {
        assert_eq!(address(written).as_deref(), expected, "{written}");
    }
}

proptest! {
    #[test]
    fn a_damaged_table_is_read_or_refused(
        which in 0..3usize,
        end in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let (file, text) = [("a.xml", OPENNESS), ("a.sdf", SDF), ("a.txt", "\"a\" AT %I0.0 : Bool // x\nB : Int := 5")][which];
        let mut bytes = text.as_bytes()[..end.index(text.len() + 1)].to_vec();
        if !bytes.is_empty() {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        match read(&Source::new(file, bytes)) {
            // Each table has three entries; a damaged address makes a tag of a constant.
            Ok(tags) => prop_assert!(tags.tags.len() + tags.constants.len() <= 3),
            Err(wrong) => prop_assert!(wrong.problems.iter().all(|problem| problem.place.is_some())),
        }
    }
}
