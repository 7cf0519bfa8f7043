//! The operations in C: returns the text of those that a program uses, with their dependencies.

use super::scalar;
use crate::ir::Scalar;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// All operations: each is a line `# name` followed by its text. `*` in a name matches any type in the class after it;
/// `*_f32` matches any function defined for binary64. `mathematics.h` is also Rust: the input of a macro.
const OPERATIONS: [&str; 2] = [include_str!("operations.h"), include_str!("mathematics.h")];

/// The operations: name, class and text.
static PARTS: LazyLock<Vec<(&str, &str, &str)>> = LazyLock::new(|| {
    let part = |part: &'static str| {
        let (head, text) = part.split_once('\n')?;
        let (name, class) = head.split_once(' ').unwrap_or((head, ""));
        Some((name, class, text))
    };
    let texts = OPERATIONS.iter().map(|text| text.trim_start_matches("# ").trim_end().trim_end_matches("\n\n}"));
    texts.flat_map(|text| text.split("\n# ")).filter_map(part).collect()
});

/// The C text of the operation with this name, for example `add_i16`.
fn text(name: &str) -> Option<String> {
    if let Some((.., text)) = PARTS.iter().find(|(it, ..)| *it == name) {
        return Some(text.to_string());
    }
    let (op, of) = name.rsplit_once('_')?;
    static TYPES: LazyLock<BTreeMap<String, Scalar>> =
        LazyLock::new(|| Scalar::ALL.iter().map(|ty| (ty.to_string(), *ty)).collect());
    let ty = *TYPES.get(of)?;
    let fits = |class: &str| match class {
        "integer" => ty.is_integer(),
        "signed" => ty.is_signed(),
        "unsigned" => ty.is_integer() && !ty.is_signed(),
        _ => true,
    };
    let generic = PARTS.iter().find(|(it, class, _)| it.strip_suffix("_*") == Some(op) && fits(class));
    let is_wide = || ty == Scalar::F32 && PARTS.iter().any(|(it, ..)| it.strip_suffix("_f64") == Some(op));
    let (.., text) = generic.or_else(|| PARTS.iter().find(|(it, ..)| *it == "*_f32" && is_wide()))?;
    let bits = 8 * ty.size();
    let unsigned = format!("u{bits}_t");
    // An unsigned type that C does not promote to `int`.
    let wide = if bits == 64 { "u64_t" } else { "u32_t" };
    let text = text.replace("$T", scalar(ty)).replace("$t", of).replace("$U", &unsigned).replace("$W", wide);
    Some(text.replace("$B", &bits.to_string()).replace("$F", op))
}

/// Whether an operation of this name exists.
pub(super) fn exists(name: &str) -> bool {
    text(name).is_some()
}

/// The text of the operations used in a C text, dependencies first.
pub(super) fn used(by: &str) -> String {
    fn add(by: &str, done: &mut BTreeSet<String>, into: &mut String) {
        let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let mut rest = by;
        while let Some(begin) = rest.find(is_letter) {
            rest = &rest[begin..];
            let (name, behind) = rest.split_at(rest.find(|c| !is_letter(c)).unwrap_or(rest.len()));
            rest = behind;
            // All other names must be followed by a parenthesis, because comments contain such words as well.
            let is_word = ["AT_8", "call_t", "twofold_t", "twofolds_t", "digits_t", "turn_t"].contains(&name);
            if !is_word && !behind.starts_with('(') {
                continue;
            }
            if done.contains(name) {
                continue;
            }
            if let Some(text) = text(name) {
                done.insert(name.to_string());
                add(&text, done, into);
                into.push('\n');
                into.push_str(text.trim_end());
                into.push('\n');
            }
        }
    }
    let mut into = String::new();
    add(by, &mut BTreeSet::new(), &mut into);
    into
}
