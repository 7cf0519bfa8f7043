//! Damaged documents always result in a tree and in error messages.

use super::{Texts, parse};
use crate::report::Report;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Valid documents.
const DOCUMENTS: [&str; 4] = [
    include_str!("../../../../examples/programs/interlock.s7dcl"),
    include_str!("../../../tests/simatic_sd/data/Tank.s7dcl"),
    include_str!("../../../tests/simatic_sd/data/Sample.s7dcl"),
    include_str!("../../../tests/simatic_sd/data/Offsets.s7dcl"),
];

/// Returns the number of blocks and the number of errors.
fn read(text: &str) -> (usize, usize) {
    let mut report = Report::default();
    let tree = parse(text, 0, &Texts::default(), &mut report);
    (tree.blocks.len(), report.errors())
}

/// Splits a document into words with the separators after them.
fn words(text: &str) -> Vec<&str> {
    text.split_inclusive([' ', '\n', ';', '(', ')', ',', '.', '#', '[', ']', '{', '}', '"']).collect()
}

#[test]
fn a_document_that_is_cut_anywhere_is_told() {
    for text in DOCUMENTS {
        let text = text.trim_start_matches('\u{feff}');
        assert_eq!(read(text), (1, 0));
        for end in 1..text.trim_end().len() {
            let (blocks, errors) = read(&text[..end]);
            assert!(errors > 0 || blocks == 0, "{}", &text[..end]);
        }
    }
}

/// Networks that would take quadratic time, or one stack level for each wire.
#[test]
fn a_network_may_be_large_but_not_deep() {
    let of = |rungs: String| {
        format!("FUNCTION_BLOCK \"B\"\nVAR a : Bool; END_VAR\nNETWORK\n{rungs}\nEND_NETWORK\nEND_FUNCTION_BLOCK")
    };
    let all = 20_000;
    let branches: String = (0..all).map(|_| "RUNG wire#powerrail Contact( #a ) END_RUNG wire#w\n").collect();
    assert_eq!(read(&of(format!("RUNG wire#w Coil( #a ) END_RUNG\n{branches}"))), (1, 0));
    let chain: String = (1..all).map(|at| format!("RUNG wire#w{at} END_RUNG wire#w{}\n", at - 1)).collect();
    assert_eq!(read(&of(format!("RUNG wire#w0 Coil( #a ) END_RUNG\n{chain}"))), (1, 1));
    let pins: String = (0..all).map(|at| format!("in{at} := #a, ")).collect();
    assert_eq!(read(&of(format!("RUNG #a A( {pins} ) END_RUNG"))), (1, 1));
}

#[test]
fn the_texts_of_a_file_that_is_cut_anywhere_are_read_or_told() {
    let text = include_str!("../../../tests/simatic_sd/data/Tank.s7res");
    for end in 0..text.len() {
        let mut report = Report::default();
        let texts = Texts::read(&text[..end], 0, &mut report);
        assert!(texts.all("MLC_1").len() <= 2);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(41), ..ProptestConfig::default() })]

    #[test]
    fn a_document_with_words_of_another_is_told(
        one in 0..DOCUMENTS.len(),
        other in 0..DOCUMENTS.len(),
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<bool>()), 1..6),
    ) {
        let (mut mixed, other) = (words(DOCUMENTS[one]), words(DOCUMENTS[other]));
        for (to, from, is_removed) in places {
            let to = to.index(mixed.len());
            if is_removed && mixed.len() > 1 {
                mixed.remove(to);
            } else {
                mixed[to] = other[from.index(other.len())];
            }
        }
        read(&mixed.concat());
    }
}
