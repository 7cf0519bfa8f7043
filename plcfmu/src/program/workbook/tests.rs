use super::*;
use host::package::archive;
use std::collections::BTreeMap;

/// A workbook with a sheet of tags, whose texts are shared or inline, and one of constants.
fn parts() -> BTreeMap<String, Vec<u8>> {
    let relations = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    let sheet = |rows: &str| format!("<worksheet xmlns=\"{main}\"><sheetData>{rows}</sheetData></worksheet>");
    let inline = |row: u32, cells: &[&str]| {
        let cell = |(column, text): (usize, &&str)| {
            let name = format!("{}{row}", char::from(b'A' + column as u8));
            format!("<c r=\"{name}\" t=\"inlineStr\"><is><t>{text}</t></is></c>")
        };
        format!("<row r=\"{row}\">{}</row>", cells.iter().enumerate().map(cell).collect::<String>())
    };
    let tags = inline(1, &["Name", "Path", "Data Type", "Logical Address", "Comment", "Hmi Visible"])
        + "<row r=\"3\"><c r=\"A3\" t=\"s\"><v>1</v></c><c r=\"C3\" t=\"s\"><v>0</v></c>\
           <c r=\"D3\" t=\"inlineStr\"><is><t>%QW2</t></is></c><c r=\"XFD3\"><v>7</v></c></row>"
        + &inline(4, &["Lid", "Mixer", "Bool", "%I2.5", "lid &amp; latch", "True"]);
    let constants = inline(1, &["Name", "Path", "Data Type", "Value", "Comment"])
        + "<row r=\"2\"><c r=\"A2\" t=\"inlineStr\"><is><t>BATCHES</t></is></c><c r=\"C2\" t=\"s\"><v>0</v></c><c r=\"D2\"><v>12</v></c></row>";
    let files = [
        (
            "[Content_Types].xml",
            "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"/>".to_string(),
        ),
        (
            "_rels/.rels",
            format!(
                "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship \
                 Id=\"rId1\" Type=\"{relations}/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>"
            ),
        ),
        (
            "xl/workbook.xml",
            format!(
                "<workbook xmlns=\"{main}\" xmlns:r=\"{relations}\"><sheets><sheet name=\"PLC Tags\" sheetId=\"1\" \
                 r:id=\"rId1\"/><sheet name=\"Constants\" sheetId=\"2\" r:id=\"rId2\"/></sheets></workbook>"
            ),
        ),
        (
            "xl/_rels/workbook.xml.rels",
            format!(
                "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship \
                 Id=\"rId1\" Type=\"{relations}/worksheet\" Target=\"worksheets/sheet1.xml\"/><Relationship Id=\"rId2\" \
                 Type=\"{relations}/worksheet\" Target=\"worksheets/sheet2.xml\"/></Relationships>"
            ),
        ),
        (
            "xl/sharedStrings.xml",
            format!(
                "<sst xmlns=\"{main}\" count=\"2\" uniqueCount=\"2\"><si><t>Int</t></si><si><t>Speed</t></si></sst>"
            ),
        ),
        ("xl/worksheets/sheet1.xml", sheet(&tags)),
        ("xl/worksheets/sheet2.xml", sheet(&constants)),
    ];
    files.into_iter().map(|(name, text)| (name.to_string(), text.into_bytes())).collect()
}

fn workbook(parts: &BTreeMap<String, Vec<u8>>) -> Vec<u8> {
    archive::write(parts).unwrap()
}

fn with(name: &str, from: &str, to: &str) -> BTreeMap<String, Vec<u8>> {
    let mut parts = parts();
    let text = String::from_utf8(parts[name].clone()).unwrap();
    assert!(text.contains(from));
    parts.insert(name.into(), text.replace(from, to).into_bytes());
    parts
}

#[test]
fn tags_and_constants_of_a_workbook_are_read() {
    let bytes = workbook(&parts());
    assert!(is_table(&bytes) && !is_table(b"PK"));
    let found = read(bytes).unwrap();
    let lines: Vec<String> = found.tags.iter().map(ToString::to_string).collect();
    assert_eq!(lines, ["\"Speed\" AT %QW2 : Int", "\"Lid\" AT %I2.5 : Bool // lid & latch"]);
    assert_eq!((found.constants[0].name.as_str(), found.constants[0].value.as_str()), ("BATCHES", "Int#12"));
}

#[test]
fn a_workbook_that_would_fill_the_memory_is_refused() {
    let wrong = |parts: &BTreeMap<String, Vec<u8>>| format!("{:#}", read(workbook(parts)).unwrap_err());
    let strings = "xl/sharedStrings.xml";
    let entities = wrong(&with(strings, "<sst", "<!DOCTYPE a [<!ENTITY b \"c\">]><sst"));
    assert_eq!(entities, "xl/sharedStrings.xml: a document type definition (DTD) is not supported: remove it");
    let mut bomb = parts();
    bomb.insert(strings.into(), vec![b' '; 40 << 20]);
    assert!(wrong(&bomb).contains("xl/sharedStrings.xml"), "{}", wrong(&bomb));
    let without = wrong(&with("xl/worksheets/sheet1.xml", "<v>1</v>", "<v>7</v>"));
    assert_eq!(without, "xl/worksheets/sheet1.xml: no shared string `7`");
    let other = with("xl/worksheets/sheet1.xml", "Logical Address", "Where");
    // What has no tags may still have constants.
    assert_eq!(read(workbook(&other)).unwrap().tags, []);
    assert!(read(b"Name,Data Type".to_vec()).is_err());
}

#[test]
fn a_damaged_workbook_is_read_or_refused() {
    let bytes = workbook(&parts());
    for end in (0..bytes.len()).step_by(7) {
        assert!(read(bytes[..end].to_vec()).is_err());
    }
    for at in (0..bytes.len()).step_by(3) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        drop(read(damaged));
    }
    for (name, part) in parts() {
        for end in (0..part.len()).step_by(11) {
            let mut damaged = parts();
            damaged.insert(name.clone(), part[..end].to_vec());
            drop(read(workbook(&damaged)));
        }
    }
}
