//! Damaged documents: whatever they hold, there is a tree, and what is wrong is told.

use super::{Texts, parse};
use crate::report::Report;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Documents that are right.
const DOCUMENTS: [&str; 3] = [
    include_str!("../../tests/simatic_sd/data/Tank.s7dcl"),
    include_str!("../../tests/simatic_sd/data/Sample.s7dcl"),
    include_str!("../../tests/simatic_sd/data/Offsets.s7dcl"),
];

/// How many blocks there are, and how many errors.
fn read(text: &str) -> (usize, usize) {
    let mut report = Report::default();
    let tree = parse(text, 0, &Texts::default(), &mut report);
    (tree.blocks.len(), report.errors())
}

/// The words of a document, with what is between them.
fn words(text: &str) -> Vec<&str> {
    text.split_inclusive([' ', '\n', ';', '(', ')', ',', '.', '#', '[', ']', '{', '}', '"']).collect()
}

#[test]
fn a_document_that_is_cut_anywhere_is_told() {
    for text in DOCUMENTS {
        assert_eq!(read(text), (1, 0));
        for end in 1..text.trim_end().len() {
            let (blocks, errors) = read(&text[..end]);
            assert!(errors > 0 || blocks == 0, "{}", &text[..end]);
        }
    }
}

#[test]
fn the_texts_of_a_file_that_is_cut_anywhere_are_read_or_told() {
    let text = include_str!("../../tests/simatic_sd/data/Tank.s7res");
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
