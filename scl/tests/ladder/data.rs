//! Data blocks, instances and types as documents.

use super::xml::{self, From, Net, local};
use super::{Ran, compiled};

/// A document with a data block or a type: `SW.Blocks.GlobalDB`, what stands in its attributes, and its members.
fn document(of: &str, attributes: &str, section: &str, members: &str) -> String {
    format!(
        "<Document>\n<{of} ID=\"0\"><AttributeList>{attributes}<Interface><Sections>\n<Section Name=\"{section}\">\n{members}\n\
         </Section></Sections></Interface></AttributeList></{of}>\n</Document>"
    )
}

/// `SW.Interface`, `Subelement`: the start values of elements, of members of a type and of elements of arrays of structures.
#[test]
fn start_values_reach_every_part_of_a_data_block() {
    let point = document(
        "SW.Types.PlcStruct",
        "<Name>Point</Name>",
        "None",
        "<Member Name=\"x\" Datatype=\"Int\"><StartValue>7</StartValue></Member><Member Name=\"y\" Datatype=\"Int\" />",
    );
    let data = document(
        "SW.Blocks.GlobalDB",
        "<Name>Data</Name>",
        "Static",
        "<Member Name=\"list\" Datatype=\"Array[1..2, 0..1] of Int\"><Subelement Path=\"2,1\"><StartValue>21</StartValue>\
         </Subelement></Member>\n<Member Name=\"p\" Datatype=\"&quot;Point&quot;\"><Sections><Section Name=\"None\"><Member Name=\"y\" \
         Datatype=\"Int\"><StartValue>5</StartValue></Member></Section></Sections></Member>\n<Member Name=\"many\" \
         Datatype=\"Array[0..3] of Struct\"><Member Name=\"a\" Datatype=\"Bool\" /><Member Name=\"n\" Datatype=\"Array[0..1] of Int\">\
         <Subelement Path=\"3,1\"><StartValue>31</StartValue></Subelement></Member></Member>\n<Member Name=\"s\" Datatype=\"Struct\">\
         <Member Name=\"t\" Datatype=\"Time\"><StartValue>T#2s</StartValue></Member></Member>",
    );
    let scl = "FUNCTION_BLOCK \"B\"\nVAR_OUTPUT y : ARRAY[0..7] OF INT; t : TIME; END_VAR\nBEGIN\n#y[0] := \"Data\".list[2, 1]; \
               #y[1] := \"Data\".list[1, 1]; #y[2] := \"Data\".p.x; #y[3] := \"Data\".p.y; #y[4] := \"Data\".many[3].n[1]; \
               #y[5] := \"Data\".many[2].n[1]; #t := \"Data\".s.t;\nEND_FUNCTION_BLOCK\n";
    let mut ran = Ran::new(&[("p.xml", point), ("d.xml", data), ("b.scl", scl.to_string())]);
    ran.call();
    assert_eq!([0, 1, 2, 3, 4, 5].map(|at| ran.get(&format!("y[{at}]"))), [21, 0, 7, 5, 31, 0]);
    assert_eq!(ran.get("t"), 2000);
}

/// `SW.Blocks.InstanceDB`: the instance of a block, with its own start values; one of a timer.
#[test]
fn instances_have_their_start_values() {
    let mut net = Net::new("");
    let flow = net.part("Contact", "", &[("in", From::Rail), ("operand", local("a"))]);
    let inner = "<Instance Scope=\"GlobalVariable\" UId=\"90\"><Component Name=\"Delay\" /></Instance>";
    let timer = net.part("TON", inner, &[("IN", From::Pin(flow, "out")), ("PT", local("pt"))]);
    net.part("Coil", "", &[("in", From::Pin(timer, "Q")), ("operand", From::Global("Flag".into()))]);
    let flag = net.part("Contact", "", &[("in", From::Rail), ("operand", From::Global("Flag".into()))]);
    net.part("Coil", "", &[("in", From::Pin(flag, "out")), ("operand", local("y"))]);
    let sections = [("Input", "a : Bool := true"), ("Output", "y : Bool"), ("Static", "pt : Time := T#9s")];
    let block = xml::block("FB", "B", &sections, vec![net], "LAD");
    let instance = "<Name>B_DB</Name><InstanceOfName>B</InstanceOfName><InstanceOfType>FB</InstanceOfType>";
    let member = "<Member Name=\"pt\" Datatype=\"Time\"><StartValue>T#100ms</StartValue></Member>";
    let instance = document("SW.Blocks.InstanceDB", instance, "Static", member);
    let timer = "<Name>Delay</Name><InstanceOfName>IEC_TIMER</InstanceOfName><InstanceOfType>SDB</InstanceOfType>";
    let timer = document("SW.Blocks.InstanceDB", timer, "Static", "<Member Name=\"PT\" Datatype=\"Time\" />");
    let tag = "DATA_BLOCK \"Unused\" STRUCT a : BOOL; END_STRUCT; BEGIN END_DATA_BLOCK";
    let sources = [("b.xml", block), ("i.xml", instance), ("t.xml", timer), ("u.db", tag.to_string())];
    let errors = compiled(&sources).unwrap_err();
    assert_eq!(
        errors[0].problems[0].message,
        "FB B, network 1: Coil \"Flag\": no source declares the tags \"Flag\" : BOOL"
    );
    let sources: Vec<parameters::Source> =
        sources.into_iter().map(|(name, text)| parameters::Source::new(name, text.into_bytes())).collect();
    let declared = vec![parameters::tags::Tag::new("Flag", "Bool")];
    let options = scl::Options { declared, ..scl::Options::default() };
    let mut ran = Ran::from_compiled(scl::compile(&sources, &options).unwrap());
    assert_eq!([ran.call().get("y"), ran.call().get("y")], [0, 1]);
}
