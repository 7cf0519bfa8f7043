//! Declarations, data, texts and networks in SCL: the result is the same as from the same blocks in SCL.

use super::problems;
use parameters::Source;
use scl::{Compiled, Options, compile};

/// A block with constructs that documents have and sources lack: attributes before the item they belong to, separate
/// texts, `_.` before the names of other blocks, networks.
const BLOCK: &str = include_str!("data/Tank.s7dcl");

const TYPE: &str = include_str!("data/Sample.s7dcl");

const DATA: &str = include_str!("data/Offsets.s7dcl");

const TEXTS: &str = include_str!("data/Tank.s7res");

/// The same blocks in SCL.
const SOURCE: &str = include_str!("data/tank.scl");

fn options() -> Options {
    Options { constants: vec![("COUNT".to_string(), "2".to_string())], ..Options::default() }
}

/// Compiles files with their names.
fn compiled(files: &[(&str, &str)]) -> Result<Compiled, String> {
    let sources: Vec<Source> = files.iter().map(|(name, text)| Source::new(*name, text.as_bytes().to_vec())).collect();
    compile(&sources, &options()).map_err(|errors| problems(&errors))
}

/// Returns a program as C without comments and line numbers, and its memory before the first call.
fn printed(compiled: &Compiled) -> (String, &[u8]) {
    let program = &compiled.program;
    let text = scl::c::print(program).unwrap();
    // Titles of networks are printed as comments.
    let text: String = text.lines().filter(|line| !line.trim().starts_with("/*")).collect();
    let parts: Vec<&str> =
        text.split(')').map(|part| part.trim_end_matches(|last: char| last.is_ascii_digit())).collect();
    (parts.join(")"), &program.records[program.memory].start)
}

#[test]
fn blocks_types_and_data_are_those_of_the_same_source() {
    let documents = compiled(&[
        ("Tank.s7dcl", &format!("\u{feff}{BLOCK}")),
        ("Tank.s7res", &format!("\u{feff}{TEXTS}")),
        ("Sample.s7dcl", TYPE),
        ("Offsets.s7dcl", DATA),
    ])
    .unwrap();
    let source = compiled(&[("tank.scl", SOURCE)]).unwrap();
    assert_eq!(printed(&documents), printed(&source));
    let has = |value: f32| printed(&source).1.windows(4).any(|bytes| bytes == value.to_le_bytes());
    assert!(has(0.25) && has(3.0) && has(1.5), "the start values are in the memory");
}

#[test]
fn texts_describe_variables_and_pragmas_say_what_is_set_and_hidden() {
    let files = [("a/Tank.s7dcl", BLOCK), ("a/Tank.s7res", TEXTS), ("a/Sample.s7dcl", TYPE), ("a/Offsets.s7dcl", DATA)];
    let root = compiled(&files).unwrap().root.unwrap();
    let of = |name: &str| root.variables.iter().find(|variable| variable.name == name).unwrap();
    let level = &of("level").comment;
    assert_eq!((level.text.as_str(), level.unit.as_deref(), level.max), ("Fill level", Some("bar"), Some(10.0)));
    assert_eq!(of("gain").comment.text, "Factor");
    assert_eq!(of("gain").role, scl::interface::Role::Parameter);
    assert!(of("inner").is_hidden && !of("gain").is_hidden);
    // The texts of another document do not apply.
    let alone = compiled(&[files[0], ("b/Tank.s7res", TEXTS), files[2], files[3]]).unwrap().root.unwrap();
    assert_eq!(alone.variables.iter().find(|variable| variable.name == "level").unwrap().comment.text, "");
}

#[test]
fn a_network_in_a_language_that_is_not_read_is_named_and_the_others_are_checked() {
    let text = BLOCK
        .replacen("S7_Language := \"SCL\"", "S7_Language := \"STL\"", 1)
        .replace("#mean := (", "#mean := (#nothing + ");
    let errors = compiled(&[("T.s7dcl", &text), ("T.s7res", TEXTS), ("S.s7dcl", TYPE), ("O.s7dcl", DATA)]).unwrap_err();
    assert_eq!(
        errors.lines().collect::<Vec<_>>(),
        [
            "T.s7dcl:37:5: FB Tank, network 1 \"Valve and mean\": networks in STL are not supported; rewrite the network in LAD, FBD or SCL, or leave the file out",
            "T.s7dcl:50:23: FB Tank, network 2: #nothing is not declared in this block",
        ]
    );
}

#[test]
fn what_is_wrong_has_block_network_line_and_column() {
    let of = |from: &str, to: &str| {
        assert!(BLOCK.contains(from));
        compiled(&[("T.s7dcl", &BLOCK.replace(from, to)), ("S.s7dcl", TYPE), ("O.s7dcl", DATA)]).unwrap_err()
    };
    assert_eq!(
        of("#mean := (", "#mean = ("),
        "T.s7dcl:50:13: FB Tank, network 2: this comparison has no effect; write := to assign\n"
    );
    assert!(of("    END_NETWORK\nEND_FUNCTION_BLOCK", "END_FUNCTION_BLOCK").starts_with(
        "T.s7dcl:52:1: FB Tank, network 2: expected END_NETWORK, found `END_FUNCTION_BLOCK`; the NETWORK on line 48 is not closed\n"
    ));
    assert_eq!(of("_.Sample", "_.5").lines().next(), Some("T.s7dcl:26:41: expected a name, found `5`"));
    let starts =
        compiled(&[("O.s7dcl", &DATA.replace("sample.value := 3.0", "sample.value = 3.0")), ("S.s7dcl", TYPE)]);
    assert_eq!(starts.unwrap_err().lines().next(), Some("O.s7dcl:17:27: expected `:=`, found `;`"));
}
