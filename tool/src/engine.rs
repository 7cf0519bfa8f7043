//! Dispatches requests and returns answers.

use crate::home::Home;
use crate::message::{Answer, Error};
use crate::program::Programs;
use crate::request::Request;
use crate::session::Session;
use anyhow::Result;

/// The engine of one page.
pub struct Engine<H> {
    home: Programs<H>,
    session: Session,
}

impl<H: Home> Engine<H> {
    /// Creates an empty engine.
    pub fn new(home: H) -> Engine<H> {
        Engine { home: Programs::new(home), session: Session::default() }
    }

    /// Answers a request; both are JSON. A problem becomes an [`Answer::Error`].
    pub fn message(&mut self, request: &str) -> String {
        let answer =
            match serde_json::from_str(request).map_err(anyhow::Error::from).and_then(|request| self.answer(request)) {
                Ok(value) => Answer::Ok(value),
                Err(error) => Answer::Error(Error { message: format!("{error:#}") }),
            };
        serde_json::to_string(&answer).unwrap_or_else(|error| format!(r#"{{"error":{{"message":"{error}"}}}}"#))
    }

    /// Answers a request.
    ///
    /// # Errors
    /// The problem, with name and value, and the remedy.
    pub fn answer(&mut self, request: Request) -> Result<serde_json::Value> {
        request.answer(&self.home, &mut self.session)
    }
}

#[cfg(test)]
mod tests;
