//! Damaged documents result in an error with a position, or in a program, and never in a panic.

use super::xml::{self, From, Net, int, local, typed};
use parameters::Source;
use scl::random::Random;
use scl::{Options, compile};

/// Returns a document with a network that contains every kind of wire.
fn sample() -> String {
    let mut net = Net::new("Start");
    let a = net.part("Contact", "<Negated Name=\"operand\" />", &[("in", From::Rail), ("operand", local("s.a"))]);
    let uid = net.next();
    let inner = format!("<Instance Scope=\"LocalVariable\" UId=\"{uid}\"><Component Name=\"t\" /></Instance>");
    let timer = net.part("TON", &inner, &[("IN", From::Pin(a, "out")), ("PT", typed("T#1s"))]);
    let types = "<TemplateValue Name=\"SrcType\" Type=\"Type\">Int</TemplateValue>";
    let add = net.part("Add", types, &[("en", From::Pin(timer, "Q")), ("in1", local("list[n]")), ("in2", int(5))]);
    net.write(add, "out", local("n"));
    net.part("Coil", "", &[("in", From::Pin(add, "eno")), ("operand", local("y"))]);
    let inner = "<Parameter Name=\"x\" Section=\"Input\" Type=\"Int\" />";
    net.call("FC", "F", inner, &[("en", From::Pin(a, "out")), ("x", local("n"))]);
    let mut jump = Net::new("");
    let uid = jump.part("Jump", "", &[("in", From::Rail)]);
    jump.jump_to(uid, "far");
    let mut far = Net::of_source("", "<StructuredText><Token Text=\"RETURN\" /><Token Text=\";\" /></StructuredText>");
    far.label("far");
    let sections = [
        ("Output", "y : Bool; n : Int"),
        ("Static", "t : TON_TIME; list : Array[0..9] of Int; s : \"T\""),
        ("Constant", "c : Int := 3"),
    ];
    xml::block("FB", "B", &sections, vec![net, jump, far], "LAD")
}

fn read(bytes: Vec<u8>) -> Result<(), ()> {
    read_as("b.xml", bytes)
}

fn read_as(name: &str, bytes: Vec<u8>) -> Result<(), ()> {
    let length = bytes.len();
    match compile(&[Source::new(name, bytes)], &Options::default()) {
        Ok(_) => Ok(()),
        Err(errors) => {
            let problems = errors.iter().flat_map(|problems| &problems.problems);
            assert!(problems.clone().count() > 0);
            let places = problems.filter_map(|problem| problem.place.as_ref());
            places.for_each(|place| assert!(place.line <= length + 1, "{place:?}"));
            Err(())
        }
    }
}

#[test]
fn a_document_that_ends_anywhere_is_an_error() {
    let bytes = sample().into_bytes();
    let end = bytes.len() - "</Document>\n".len();
    for length in (0..=end).step_by(if cfg!(debug_assertions) { 7 } else { 1 }) {
        assert_eq!(read(bytes[..length].to_vec()), Err(()), "{length} bytes");
    }
}

#[test]
fn a_document_with_other_bytes_does_no_harm() {
    let bytes = sample().into_bytes();
    let mut random = Random::new(7);
    for _ in 0..300 {
        let mut damaged = bytes.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(damaged.len() as u64) as usize;
            match random.below(4) {
                0 => damaged[at] = random.below(256) as u8,
                1 => drop(damaged.remove(at)),
                // A character that changes a number or a name, or breaks the markup.
                2 => damaged[at] = b"0123456789abcinoqstyQ\"<>/"[random.below(25) as usize],
                _ => {
                    let from = random.below(damaged.len() as u64) as usize;
                    let part = damaged[from..(from + 40).min(damaged.len())].to_vec();
                    damaged.splice(at..at, part);
                }
            }
        }
        let _ = read(damaged);
    }
}

/// Splits a text into pieces, each of which begins with one of these characters.
fn pieces<'t>(text: &'t str, begins: &[char]) -> Vec<&'t str> {
    let mut starts: Vec<usize> = text.char_indices().filter(|(_, at)| begins.contains(at)).map(|(at, _)| at).collect();
    starts.insert(0, 0);
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    starts.iter().zip(ends).map(|(start, end)| &text[*start..end]).collect()
}

/// Whole tags and words are lost, duplicated, swapped, or replaced by those of another document: `DAMAGES=100000` makes
/// more.
#[test]
fn examples_with_other_pieces_are_read_or_told() {
    let count = std::env::var("DAMAGES").ok().and_then(|count| count.parse().ok()).unwrap_or(100u64);
    let file = |name: &str| {
        let path = format!("{}/../examples/programs/{name}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).unwrap().trim_start_matches('\u{feff}').to_string()
    };
    let (drawn, own) = (file("interlock.xml"), sample());
    let written = file("interlock.s7dcl");
    let tags = [pieces(&drawn, &['<', '"']), pieces(&own, &['<', '"'])];
    let words = [pieces(&written, &[' ', '#', '(', '"', ';', '\n']), pieces(&own, &[' '])];
    let mut random = Random::new(11);
    for number in 0..count {
        let (name, [one, other]) = if number % 2 == 0 { ("b.xml", &tags) } else { ("b.s7dcl", &words) };
        let mut damaged = one.clone();
        for _ in 0..=random.below(5) {
            let mut at = || random.below(damaged.len() as u64) as usize;
            let (to, from) = (at(), at());
            match random.below(5) {
                0 => drop(damaged.remove(to)),
                1 => damaged.insert(to, damaged[from]),
                2 => damaged.swap(to, from),
                3 => damaged[to] = other[random.below(other.len() as u64) as usize],
                _ => {
                    damaged[to] =
                        ["\"99999999999999999999", "\"-1", "\"", "<", "&#0;", "\u{0}"][random.below(6) as usize]
                }
            }
            if damaged.is_empty() {
                break;
            }
        }
        let _ = read_as(name, damaged.concat().into_bytes());
    }
}

/// Each branch that joins another would double the expression if it were expanded.
#[test]
fn branches_that_meet_again_and_again_stay_small() {
    let mut net = Net::new("");
    let mut flow = From::Rail;
    for _ in 0..200 {
        let left = net.part("Contact", "", &[("in", flow.clone()), ("operand", local("a"))]);
        let right = net.part("Contact", "", &[("in", flow), ("operand", local("b"))]);
        flow =
            From::Pin(net.part("O", "", &[("in1", From::Pin(left, "out")), ("in2", From::Pin(right, "out"))]), "out");
    }
    net.part("Coil", "", &[("in", flow), ("operand", local("y"))]);
    let text = xml::block("FB", "B", &[("Input", "a : Bool; b : Bool"), ("Output", "y : Bool")], vec![net], "LAD");
    assert_eq!(read(text.into_bytes()), Ok(()));
}

#[test]
fn circles_entities_and_deep_elements_are_refused() {
    let mut net = Net::new("");
    let a = net.part("Contact", "", &[("operand", local("a"))]);
    let b = net.part("Contact", "", &[("in", From::Pin(a, "out")), ("operand", local("a"))]);
    net.wire(From::Pin(b, "out"), &format!("<NameCon UId=\"{a}\" Name=\"in\" />"));
    let circle = xml::block("FB", "B", &[("Input", "a : Bool")], vec![net], "LAD");
    let dtd = "<!DOCTYPE Document [<!ENTITY a \"aaaa\">]><Document />".to_string();
    let deep = format!("<Document>{}", "<a>".repeat(100_000));
    for (text, message) in [
        (circle, "FB B, network 1: Contact #a: the wires form a cycle: this element depends on its own result"),
        (dtd, "a document type definition (DTD) is not supported: remove it"),
        (deep, "elements are nested more than 64 deep"),
        ("<Document />".into(), "no block is declared here"),
        ("<html></html>".into(), "the root element is `html`, not Document: this is not a block export"),
    ] {
        let errors = compile(&[Source::new("b.xml", text.into_bytes())], &Options::default()).unwrap_err();
        assert_eq!(errors[0].problems[0].message, message);
    }
}
