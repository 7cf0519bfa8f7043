//! A block that is defined in two files, in two formats.

use super::compiled;
use super::xml::{self, From, Net, local};

const SCL: &str = "FUNCTION_BLOCK \"B\"\nVAR_INPUT a : BOOL; b : BOOL; END_VAR\nVAR_OUTPUT y : BOOL; END_VAR\nVAR n : INT := 3; END_VAR\n\
                   BEGIN\n// by hand\n#y := #a AND NOT #b;\nEND_FUNCTION_BLOCK\n";

const SD: &str = "FUNCTION_BLOCK \"B\"\nVAR_INPUT a : Bool; b : Bool; END_VAR\nVAR_OUTPUT y : Bool; END_VAR\nVAR n : Int := 3; END_VAR\n\
                  { S7_Language := \"LAD\" }\nNETWORK\nRUNG wire#powerrail Contact( #a ) I_Contact( #b ) Coil( #y ) END_RUNG\n\
                  END_NETWORK\nEND_FUNCTION_BLOCK\n";

fn drawn() -> String {
    let mut net = Net::new("Run");
    let a = net.part("Contact", "", &[("in", From::Rail), ("operand", local("a"))]);
    let inner = "<Negated Name=\"operand\" />";
    let b = net.part("Contact", inner, &[("in", From::Pin(a, "out")), ("operand", local("b"))]);
    net.part("Coil", "", &[("in", From::Pin(b, "out")), ("operand", local("y"))]);
    let sections = [("Input", "a : Bool; b : Bool"), ("Output", "y : Bool"), ("Static", "n : Int := 3")];
    xml::block("FB", "B", &sections, vec![net], "LAD")
}

fn errors(files: &[(&str, String)]) -> String {
    compiled(files).err().unwrap_or_default().iter().map(ToString::to_string).collect()
}

#[test]
fn the_same_program_in_two_formats_is_one_block() {
    let (scl, document) = (SCL.to_string(), SD.to_string());
    for files in [
        vec![("B.xml", drawn()), ("B.scl", scl.clone())],
        vec![("B.scl", scl.clone()), ("B.s7dcl", document.clone())],
        vec![("B.s7dcl", document), ("other/B.xml", drawn()), ("B.scl", scl), ("B2.xml", drawn())],
    ] {
        assert_eq!(errors(&files), "");
    }
}

#[test]
fn another_program_of_the_same_name_is_an_error_that_names_both_files() {
    for (from, to) in [("AND NOT #b", "AND #b"), ("n : INT := 3", "n : INT := 4"), ("b : BOOL; END_VAR", "END_VAR")] {
        let scl = SCL.replace(from, to).replace("AND NOT #b", if to == "END_VAR" { "" } else { "AND NOT #b" });
        let found = errors(&[("B.xml", drawn()), ("B.scl", scl)]);
        let expected = "B.scl:1:16: B is declared twice: first in B.xml:19; rename one of them, or leave one file out; \
             if there are several PLCs, specify the folder of one";
        assert!(found.contains(expected), "{to}\n{found}");
    }
    // The whole text is compared.
    let of = |text: &str| {
        format!("FUNCTION_BLOCK \"B\"\nVAR_OUTPUT s : STRING; END_VAR\nBEGIN\n#s := '{text}';\nEND_FUNCTION_BLOCK\n")
    };
    assert_eq!(errors(&[("B.scl", of("a//b")), ("C.scl", of("a//b") + "// the same\n")]), "");
    let found = errors(&[("B.scl", of("a//b")), ("C.scl", of("a//c"))]);
    assert!(found.contains("B is declared twice: first in B.scl:1"), "{found}");
    // Data and types.
    let user = "FUNCTION_BLOCK \"B\"\nVAR p : \"Point\"; END_VAR\nBEGIN\n#p.x := \"Data\".x;\nEND_FUNCTION_BLOCK\n"
        .to_string();
    let of = |ty: &str, data: &str| {
        let files = [
            ("B.scl", user.clone()),
            ("a.udt", "TYPE \"Point\"\nSTRUCT x : Int; END_STRUCT;\nEND_TYPE\n".to_string()),
            ("a.db", "DATA_BLOCK \"Data\"\nSTRUCT x : Int := 5; END_STRUCT;\nBEGIN\nEND_DATA_BLOCK\n".to_string()),
            ("b.udt", format!("TYPE \"Point\"\nSTRUCT x : {ty}; END_STRUCT;\nEND_TYPE\n")),
            ("b.db", format!("DATA_BLOCK \"Data\"\nSTRUCT x : Int{data}; END_STRUCT;\nBEGIN\nEND_DATA_BLOCK\n")),
        ];
        errors(&files)
    };
    assert_eq!(of("INT", " := 16#5"), "");
    assert!(of("Int := 1", " := 5").contains("Point is declared twice: first in a.udt:1"));
    assert!(of("Int", "").contains("Data is declared twice: first in a.db:1"));
}
