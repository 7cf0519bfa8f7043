//! The subject of an error. A caller that has the loop or study file can locate the line by the attached keys.

use anyhow::{Error, Result};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// The subject of an error.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Subject {
    /// A part of the file: the keys and indices that lead to it.
    Part(Vec<Key>),
    /// Something outside the file, named in the message.
    Outside,
}

/// A key or an index in a file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Key {
    /// The key of a table.
    Name(Cow<'static, str>),
    /// The 0-based index in a list.
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

/// An error with its subject attached; displayed as the error alone.
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
    /// The subject of an error, if attached.
    pub fn find(error: &Error) -> Option<&Subject> {
        error.downcast_ref::<WithSubject>().map(|of| &of.subject)
    }

    /// Attaches this subject to an error.
    pub fn attach(self, error: Error) -> Error {
        WithSubject { subject: self, error }.into()
    }
}

/// Attaches subjects to errors.
pub trait About {
    /// Attaches this part of the file to an error as its subject. A part that is already attached is taken to be inside
    /// this one.
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
