//! Data blocks, instances and types as documents.

use super::xml::{self, From, Net, local};
use super::{Ran, compiled};
use scl::interface::Role;
use scl::ir::Scalar;
use scl::machine::{Code, Machine};
use std::sync::Arc;

/// Returns a document with a data block or a type: the element such as `SW.Blocks.GlobalDB`, the content of its
/// attributes, and its members.
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

/// `SW.Blocks.InstanceDB`: an instance of a block with its own start values, and an instance of a timer.
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
        "FB B, network 1: Coil \"Flag\": no source declares the tag \"Flag\" : BOOL"
    );
    let sources: Vec<parameters::Source> =
        sources.into_iter().map(|(name, text)| parameters::Source::new(name, text.into_bytes())).collect();
    let declared = vec![parameters::tags::Tag::new("Flag", "Bool")];
    let options = scl::Options { declared, ..scl::Options::default() };
    let mut ran = Ran::from_compiled(scl::compile(&sources, &options).unwrap());
    assert_eq!([ran.call().get("y"), ran.call().get("y")], [0, 1]);
}

/// An export states which event calls an organization block, but not how often: Main and other cyclic ones run in each
/// cycle, Main last; blocks called by an event do not run.
#[test]
fn a_project_with_several_organization_blocks_runs_without_naming_them() {
    let network = |add: &str| {
        let source = format!("\"Data\".n := \"Data\".n * 10 + {add};");
        Net::of_source("", &format!("<StructuredText><Text>{source}</Text></StructuredText>"))
    };
    let block = |name: &str, kind: &str, add: &str| {
        let text = xml::block("OB", name, &[], vec![network(add)], "SCL");
        (format!("{name}.xml"), text.replace("<Number>", &format!("<SecondaryType>{kind}</SecondaryType><Number>")))
    };
    let named = [
        block("Main", "ProgramCycle", "3"),
        block("Fast", "CyclicInterrupt", "2"),
        block("Edge", "HardwareInterrupt", "9"),
        block("Begin", "Startup", "1"),
    ];
    let data = "DATA_BLOCK \"Data\" STRUCT n : DINT; END_STRUCT; BEGIN END_DATA_BLOCK\n\
                ORGANIZATION_BLOCK \"Diagnostic error interrupt\" BEGIN \"Data\".n := -1; END_ORGANIZATION_BLOCK\n";
    let mut sources: Vec<(&str, String)> = named.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    sources.push(("data.scl", data.to_string()));
    let compiled = compiled(&sources).unwrap_or_else(|errors| panic!("{}", errors[0]));
    let root = compiled.root.clone().unwrap();
    assert_eq!(root.block, "Main");
    let warned: Vec<String> = compiled.warnings.iter().map(ToString::to_string).collect();
    for (file, says) in [
        ("Fast.xml", "Fast is called as often as Main: the sources do not specify its period; specify both"),
        ("Edge.xml", "Edge is not called: its event never occurs here"),
        ("data.scl", "Diagnostic error interrupt is not called"),
    ] {
        assert!(warned.iter().any(|text| text.starts_with(file) && text.contains(says)), "{file}: {warned:#?}");
    }
    let mut machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
    let (offset, _) = compiled.program.find("Data.n").unwrap();
    machine.call(root.startup.unwrap(), 0).unwrap();
    machine.call(root.cycle, 0).unwrap();
    machine.call(root.cycle, 100_000_000).unwrap();
    assert_eq!(machine.get(Scalar::I32, offset).bits() as i32, 12323);
}

/// The call in a network lists a block's parameters, and an instance repeats the whole interface: the stub of a block that was not
/// exported has both.
#[test]
fn a_missing_block_has_the_interface_that_its_call_and_its_instance_show() {
    let parameter = |(name, section, of): (&str, &str, &str)| {
        format!("<Parameter Name=\"{name}\" Section=\"{section}\" Type=\"{of}\" />")
    };
    let listed = |all: &[(&str, &str, &str)]| all.iter().map(|of| parameter(*of)).collect::<String>();
    let instance = |name: &str| {
        format!("<Instance Scope=\"GlobalVariable\" UId=\"9{}\"><Component Name=\"{name}\" /></Instance>", name.len())
    };
    let mut net = Net::new("");
    let all = [("rawValue", "Input", "UInt"), ("total", "InOut", "DInt"), ("Ret_Val", "Return", "Real")];
    net.call("FC", "scaled", &listed(&all), &[("en", From::Rail), ("rawValue", local("a")), ("total", local("n"))]);
    let inner = instance("G1")
        + &listed(&[("start", "Input", "Bool"), ("openInput", "Input", "Real"), ("done", "Output", "Bool")]);
    let gone = net.call("FB", "Gone", &inner, &[("en", From::Rail)]);
    net.write(gone, "done", local("y"));
    let inner = instance("Drive_DB") + &listed(&[("speed", "Input", "Real")]);
    net.call("FB", "Drive", &inner, &[("en", From::Rail)]);
    let sections = [("Input", "a : UInt"), ("Output", "y : Bool"), ("Static", "n : DInt")];
    let block = xml::block("FB", "B", &sections, vec![net], "LAD");
    let data = "<Name>Drive_DB</Name><InstanceOfName>Drive</InstanceOfName><InstanceOfType>FB</InstanceOfType>";
    let member = "<Member Name=\"speed\" Datatype=\"Real\"><StartValue>7.5</StartValue></Member></Section>\
                  <Section Name=\"Output\"><Member Name=\"faultWord\" Datatype=\"Word\" /></Section>\
                  <Section Name=\"Static\"><Member Name=\"memory\" Datatype=\"Array[0..1] of Int\" />";
    let data = document("SW.Blocks.InstanceDB", data, "Input", member);
    let mut sources: Vec<parameters::Source> =
        [("b.xml", block), ("d.xml", data)].map(|(name, text)| parameters::Source::new(name, text.into_bytes())).into();
    let errors = scl::compile(&sources, &scl::Options::default()).unwrap_err();
    let all: Vec<&str> = errors.iter().flat_map(|of| &of.problems).map(|problem| problem.message.as_str()).collect();
    let message =
        "DB Drive_DB: no source declares the function block \"Drive\": only an instance reveals its interface";
    assert!(all.contains(&message), "{all:?}");

    let missing = scl::survey(&sources, &scl::Options::default()).missing;
    assert!(missing.contains(&("Drive".to_string(), "function blocks")), "{missing:?}");
    let shown: Vec<String> = scl::watch::watched(&sources).into_iter().map(|of| of.name).collect();
    assert_eq!(shown, ["B"]);

    let assumed = scl::assumed(&scl::assume(&sources, &scl::Options::default(), None));
    assert!(!assumed.contains("ORGANIZATION_BLOCK"), "B can be run");
    for text in [
        "FUNCTION \"scaled\" : Real\n{ STUB := 'TRUE' }\nVAR_INPUT\n   rawValue : UInt;\nEND_VAR\nVAR_IN_OUT\n   total : DInt;\nEND_VAR\n",
        "FUNCTION_BLOCK \"Gone\"\n{ STUB := 'TRUE' }\nVAR_INPUT\n   start : Bool;\n   openInput : Real;\nEND_VAR\nVAR_OUTPUT\n   \
         done : Bool;\nEND_VAR\n",
        "VAR_GLOBAL\n   \"G1\" : \"Gone\";\nEND_VAR\n",
        "FUNCTION_BLOCK \"Drive\"\n{ STUB := 'TRUE' }\nVAR_INPUT\n   speed : REAL;\nEND_VAR\nVAR_OUTPUT\n   faultWord : WORD;\nEND_VAR\n\
         VAR\n   memory : ARRAY[0..1] OF INT;\nEND_VAR\n",
    ] {
        assert!(assumed.contains(text), "{text}\n-- in --\n{assumed}");
    }
    sources.push(parameters::Source::new("assumed.scl", assumed.into_bytes()));
    let compiled = scl::compile(&sources, &scl::Options::default()).unwrap_or_else(|errors| panic!("{}", errors[0]));
    let role = |name: &str| compiled.globals.iter().find(|of| of.name == name).map(|of| of.role);
    assert_eq!(
        ["Drive_DB.speed", "Drive_DB.faultWord", "G1.openInput"].map(role),
        [Some(Role::Output), Some(Role::Input), Some(Role::Output)]
    );
}
