//! The example in LAD behaves like its form in SCL.

use super::{Ran, compiled};
use parameters::Source;
use scl::Compiled;
use scl::Dialect;
use scl::random::Random;

#[test]
fn the_interlocks_in_lad_have_the_bits_of_those_in_scl() {
    let file = |name: &str| {
        std::fs::read_to_string(format!("{}/../examples/programs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
    };
    let lad = [("interlock.xml", file("interlock.xml"))];
    let program = compiled(&lad).unwrap_or_else(|errors| panic!("{}", errors[0]));
    assert_eq!(program.warnings.iter().map(ToString::to_string).collect::<String>(), "");
    let shown = scl::print(&program.program, &program.blocks(), Dialect::Tia).unwrap();
    for text in [
        "// Network 3: Fault",
        "// Kept until it is acknowledged.",
        "#run := (#start OR #run) AND NOT #stop AND NOT #fault AND NOT #low;",
    ] {
        assert!(shown.contains(text), "{text}\n{shown}");
    }
    let names = ["interlock.s7dcl", "interlock.s7res"];
    let document = names.map(|name| (name, file(name).trim_start_matches('\u{feff}').to_string()));
    let same = compiled(&document).unwrap_or_else(|errors| panic!("{}", errors[0]));
    assert_eq!(same.warnings.iter().map(ToString::to_string).collect::<String>(), "");
    let of = |compiled: &Compiled| {
        let variables = compiled.root.as_ref().unwrap().variables.iter();
        variables.map(|variable| (variable.name.clone(), variable.comment.text.clone())).collect::<Vec<_>>()
    };
    assert_eq!(of(&same), of(&program), "names and comments");
    let mut all = [
        Ran::new(&lad),
        Ran::new(&[("interlock.scl", file("interlock.scl"))]),
        Ran::new(&[("shown.scl", shown)]),
        Ran::new(&document),
    ];
    let mut random = Random::new(41);
    let mut faults = 0;
    for call in 0..2000 {
        let mut inputs: Vec<(&str, i64)> = ["start", "stop", "reset", "overload", "flow"]
            .iter()
            .zip([3, 40, 5, 60, 2])
            .map(|(name, once)| (*name, i64::from(random.once_in(once))))
            .collect();
        // The flow changes at intervals longer than the delay.
        inputs[4].1 = i64::from(call / 100 % 2 == 0);
        inputs.push(("raw", if random.once_in(50) { 3000 } else { 4148 + random.below(23_500) as i64 }));
        let states = all.each_mut().map(|ran| {
            for (name, value) in &inputs {
                ran.set(name, *value);
            }
            ran.call();
            ["run", "fault", "low", "starts"]
                .map(|name| ran.get(name))
                .into_iter()
                .chain([ran.bits("level")])
                .collect::<Vec<i64>>()
        });
        assert_eq!(states[0], states[1], "call {call}");
        assert_eq!(states[0], states[2], "call {call}");
        assert_eq!(states[0], states[3], "call {call}");
        faults += states[0][1];
    }
    assert!((100..1900).contains(&faults), "{faults} calls with a fault");
}

#[test]
fn both_formats_are_drawn_as_the_same_networks() {
    let drawn = |names: &[&str]| {
        let read = |name: &&str| {
            let path = format!("{}/../examples/programs/{name}", env!("CARGO_MANIFEST_DIR"));
            Source::new(*name, std::fs::read(path).unwrap())
        };
        let sources: Vec<Source> = names.iter().map(read).collect();
        let block = scl::watch::watched(&sources).remove(0);
        let network = |of: &scl::watch::Network| {
            let above =
                |of: &scl::watch::Element| of.above.as_ref().map(|above| above.text.clone()).unwrap_or_default();
            let mut elements: Vec<String> =
                of.elements.iter().map(|of| format!("{:?} {:?} {}", of.shape, of.sign, above(of))).collect();
            elements.retain(|of| !of.starts_with("Junction"));
            elements.sort();
            (of.title.clone(), of.has_rail, elements)
        };
        block.networks.iter().map(network).collect::<Vec<_>>()
    };
    let document = drawn(&["interlock.s7dcl", "interlock.s7res"]);
    assert_eq!(drawn(&["interlock.xml"]), document);
    let (title, has_rail, elements) = &document[3];
    assert_eq!((title.as_str(), has_rail), ("Run", &true));
    let expected = [
        "Coil \"\" #run",
        "Contact \"\" #run",
        "Contact \"\" #start",
        "Contact \"/\" #fault",
        "Contact \"/\" #low",
        "Contact \"/\" #stop",
    ];
    assert_eq!(elements, &expected);
}
