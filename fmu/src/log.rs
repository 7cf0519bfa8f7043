//! Logging: categories, their selection, and the message text.

use crate::messages;
use crate::refusal::{Answer, Refusal};
use crate::state::Function;
use std::ffi::{CStr, CString};

/// A log category.
#[derive(Debug)]
pub struct Category {
    /// Its name in modelDescription.xml and in every message.
    pub name: &'static CStr,
    /// A description of its messages, for modelDescription.xml.
    pub description: &'static str,
    bit: u8,
}

impl Category {
    /// Calls that were refused.
    pub const STATUS_ERROR: Category = Category {
        name: c"logStatusError",
        description: "Refused calls, which changed nothing, with the reason",
        bit: 1,
    };

    /// Queries that the FMU cannot answer.
    pub const STATUS_DISCARD: Category = Category {
        name: c"logStatusDiscard",
        description: "Queries that this FMU cannot answer, with the reason",
        bit: 2,
    };

    /// Panics.
    pub const STATUS_FATAL: Category = Category {
        name: c"logStatusFatal",
        description: "Internal errors of the FMU: the instance can only be freed",
        bit: 4,
    };

    /// Settings, steps and conversions that are allowed but may be unintended.
    pub const ADVICE: Category = Category {
        name: c"logAdvice",
        description: "Settings that are allowed but may have unexpected effects",
        bit: 8,
    };

    /// All categories.
    pub const ALL: &[Category] =
        &[Category::STATUS_ERROR, Category::STATUS_DISCARD, Category::STATUS_FATAL, Category::ADVICE];

    /// The category in which a refusal with this answer is logged.
    pub fn for_answer(answer: Answer) -> &'static Category {
        match answer {
            Answer::Error => &Category::STATUS_ERROR,
            Answer::Discard => &Category::STATUS_DISCARD,
            Answer::Fatal => &Category::STATUS_FATAL,
        }
    }
}

/// The categories that are logged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection(u8);

impl Selection {
    /// No category.
    pub const NONE: Selection = Selection(0);

    /// Every category.
    pub const ALL: Selection = Selection(15);

    /// Errors and fatal errors, which a new instance logs even with logging off. Otherwise, a user would see that a
    /// call failed, but not why.
    pub const ERRORS: Selection = Selection(Category::STATUS_ERROR.bit | Category::STATUS_FATAL.bit);

    /// Whether a category is selected.
    pub fn contains(self, category: &Category) -> bool {
        self.0 & category.bit != 0
    }

    /// The categories with these names, `None` meaning NULL; all if no name is given.
    ///
    /// # Errors
    /// A category is NULL or unknown; the message lists the existing ones.
    pub fn named<'a>(names: impl ExactSizeIterator<Item = Option<&'a CStr>>) -> Result<Selection, Refusal> {
        if names.len() == 0 {
            return Ok(Selection::ALL);
        }
        let mut selection = Selection::NONE;
        for name in names {
            let name = name.ok_or_else(messages::no_category)?;
            let category = Category::ALL.iter().find(|category| category.name == name);
            let category = category.ok_or_else(|| messages::unknown_category(&name.to_string_lossy()))?;
            selection.0 |= category.bit;
        }
        Ok(selection)
    }
}

/// The text of a log message: the function's name and the message, without NUL and with each `#` doubled.
pub fn text(function: &Function, message: &str) -> CString {
    // A NUL would end the text early; `#` would start a reference to a variable.
    let text = format!("{}: {message}", function.name).replace('\0', "").replace('#', "##");
    CString::new(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[Option<&CStr>]) -> Result<Selection, Refusal> {
        Selection::named(names.iter().copied())
    }

    #[test]
    fn named_categories_are_selected_and_all_without_a_name() {
        assert_eq!(named(&[]).unwrap(), Selection::ALL);
        let selection = named(&[Some(c"logStatusFatal"), Some(c"logStatusError")]).unwrap();
        let selected: Vec<bool> = Category::ALL.iter().map(|category| selection.contains(category)).collect();
        assert_eq!(selected, [true, false, true, false]);
        assert!(Category::ALL.iter().all(|category| Selection::ALL.contains(category)));
        assert!(!Category::ALL.iter().any(|category| Selection::NONE.contains(category)));
        let errors: Vec<bool> = Category::ALL.iter().map(|category| Selection::ERRORS.contains(category)).collect();
        assert_eq!(errors, [true, false, true, false]);
    }

    #[test]
    fn an_unknown_category_is_refused_with_those_that_exist() {
        let refusal = named(&[Some(c"logAll")]).unwrap_err();
        assert_eq!(
            refusal.reason(),
            "category \"logAll\" is unknown: the categories are logStatusError, logStatusDiscard, logStatusFatal, logAdvice"
        );
        assert_eq!(named(&[None]).unwrap_err().reason(), "a category is NULL");
    }

    #[test]
    fn a_text_has_no_nul_and_no_reference_to_a_variable() {
        let text = text(&Function::new("step", &[], ""), "a \0 #1 %s");
        assert_eq!(text.as_c_str(), c"step: a  ##1 %s");
    }
}
