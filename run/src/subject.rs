//! What an error is about: whoever has the file of a loop or a study finds the line by the keys that the error carries.

use anyhow::{Error, Result};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// What an error is about.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Subject {
    /// A part of the file: the keys and indices that lead to it.
    Part(Vec<Key>),
    /// Something outside of the file, which the message names.
    Outside,
}

/// A key or an index in a file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Key {
    /// The key of a table.
    Name(Cow<'static, str>),
    /// The index in a list, from 0.
    Item(usize),
}

impl From<&'static str> for Key {
    fn from(name: &'static str) -> Key {
        Key::Name(name.into())
    }
}

impl From<usize> for Key {
    fn from(index: usize) -> Key {
        Key::Item(index)
    }
}

/// An error that carries its subject; its text is that of the error.
#[derive(Debug)]
struct WithSubject {
    subject: Subject,
    error: Error,
}

impl fmt::Display for WithSubject {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{:#}", self.error)
    }
}

impl std::error::Error for WithSubject {}

impl Subject {
    /// What an error is about, if it carries that.
    pub fn find(error: &Error) -> Option<&Subject> {
        error.downcast_ref::<WithSubject>().map(|of| &of.subject)
    }

    /// The error with this subject.
    pub fn attach(self, error: Error) -> Error {
        WithSubject { subject: self, error }.into()
    }
}

/// Attaches subjects to errors.
pub trait About {
    /// Says that an error is about this part of the file, or about what it says already inside this part.
    #[must_use]
    fn at(self, key: impl Into<Key>) -> Self;
}

impl<T> About for Result<T> {
    fn at(self, key: impl Into<Key>) -> Result<T> {
        self.map_err(|mut error| match error.downcast_mut() {
            Some(WithSubject { subject: Subject::Part(keys), .. }) => {
                keys.insert(0, key.into());
                error
            }
            _ => Subject::Part(vec![key.into()]).attach(error),
        })
    }
}

/// Returns an error about a key: `bail_at!("step", "the step is {step} s")`.
#[macro_export]
macro_rules! bail_at {
    ($key:expr, $($message:tt)+) => {
        return $crate::subject::About::at(Err(anyhow::anyhow!($($message)+)), $key)
    };
}
