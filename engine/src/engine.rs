//! From a request to an answer.

use crate::home::Home;
use crate::message::{Answer, Catalogue, Error, Request};
use anyhow::{Result, bail};
use serde::Serialize;

/// The engine of one page.
#[derive(Debug)]
pub struct Engine<H> {
    home: H,
}

impl<H: Home> Engine<H> {
    /// A new one, with nothing opened.
    pub fn new(home: H) -> Engine<H> {
        Engine { home }
    }

    /// Answers a request, both as JSON. It always gives an answer.
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
    /// What is wrong, with name and value, and what to do.
    pub fn answer(&mut self, request: Request) -> Result<serde_json::Value> {
        match request {
            Request::Catalogue => json(Catalogue { fmus: self.home.entries(), loops: self.home.known_loops() }),
            other => bail!("not there yet: {other:?}"),
        }
    }
}

fn json(content: impl Serialize) -> Result<serde_json::Value> {
    Ok(serde_json::to_value(content)?)
}
