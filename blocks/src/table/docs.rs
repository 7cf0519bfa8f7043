//! The part of a block's documentation that is compiled in. A native library contains all of it, from which the packer
//! writes a page. In a browser, the page has the help separately, so the engine contains only the first paragraph and
//! the dialog.

/// Whether only the first paragraph and the dialog are compiled in.
pub const IS_SHORT: bool = cfg!(target_family = "wasm");

/// Returns the byte ranges of the first paragraph and of the dialog, which may be empty.
const fn parts(docs: &[u8]) -> [(usize, usize); 2] {
    let paragraph = past(docs, find(docs, b"\n\n", 0), 2);
    let dialog = find(docs, b"```dialog", paragraph);
    let end = find(docs, b"```\n", dialog);
    [(0, paragraph), (dialog, past(docs, end, 4))]
}

/// Returns the byte offset of the first occurrence of `text` at or after `from`; the length of `docs` if there is none.
const fn find(docs: &[u8], text: &[u8], from: usize) -> usize {
    let mut at = from;
    while at + text.len() <= docs.len() {
        let mut same = 0;
        while same < text.len() && docs[at + same] == text[same] {
            same += 1;
        }
        if same == text.len() {
            return at;
        }
        at += 1;
    }
    docs.len()
}

const fn past(docs: &[u8], at: usize, count: usize) -> usize {
    if at == docs.len() { at } else { at + count }
}

/// Returns the number of bytes of the documentation that are kept.
pub const fn length(docs: &str, is_short: bool) -> usize {
    let [paragraph, dialog] = parts(docs.as_bytes());
    if is_short { paragraph.1 + dialog.1 - dialog.0 } else { docs.len() }
}

/// Returns the bytes that are kept.
pub const fn kept<const LENGTH: usize>(docs: &str) -> [u8; LENGTH] {
    let docs = docs.as_bytes();
    let [(_, paragraph), (dialog, _)] = parts(docs);
    let gap = if LENGTH < docs.len() { dialog - paragraph } else { 0 };
    let mut bytes = [0; LENGTH];
    let mut at = 0;
    while at < LENGTH {
        bytes[at] = docs[if at < paragraph { at } else { at + gap }];
        at += 1;
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::{kept, length};

    const DOCS: &str = "Moves.\n\n# Algorithm\n\nSlowly.\n\n```dialog\nLimits\n```\n\n# Sources\n\nA book.\n";

    #[test]
    fn a_short_documentation_is_the_first_paragraph_and_the_dialog() {
        const LENGTH: usize = length(DOCS, true);
        assert_eq!(&kept::<LENGTH>(DOCS), b"Moves.\n\n```dialog\nLimits\n```\n");
        const BARE: &str = "Moves.\n\nSlowly.\n";
        assert_eq!(&kept::<{ length(BARE, true) }>(BARE), b"Moves.\n\n");
        assert_eq!(&kept::<{ length("Moves.\n", true) }>("Moves.\n"), b"Moves.\n");
    }

    #[test]
    fn a_library_has_all_of_it() {
        assert_eq!(kept::<{ length(DOCS, false) }>(DOCS), DOCS.as_bytes());
    }
}
