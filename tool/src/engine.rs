//! From a request to an answer.

use crate::home::Home;
use crate::message::{Answer, Error, Request};
use crate::session::Session;
use crate::{connect, describe, export, signals};
use anyhow::Result;
use control::{characteristic, csv, replay, tune};
use serde::Serialize;

/// The engine of one page.
pub struct Engine<H> {
    home: H,
    session: Session,
}

impl<H: Home> Engine<H> {
    /// A new one, with nothing opened.
    pub fn new(home: H) -> Engine<H> {
        Engine { home, session: Session::default() }
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
        let (home, session): (&dyn Home, _) = (&self.home, &mut self.session);
        match request {
            Request::Catalogue => json(describe::catalogue(home)),
            Request::Describe { fmu } => json(describe::describe(home, &fmu)?),
            Request::Read(file) => json(describe::read(home, &file)?),
            Request::Check { fmu, values } => json(describe::check(home, &fmu, &values)?),
            Request::Propose { controller, plant } => json(connect::propose(home, &controller, &plant)?),
            Request::Start(setup) => json(session.start(home, setup)?),
            Request::State => json(session.state()?),
            Request::Send { values } => json(session.send(&values)?),
            Request::Ramp { variable, to, seconds } => json(session.ramp(&variable, to, seconds)?),
            Request::Run { calls } => json(session.run(calls)?),
            Request::Exchange { members, connections } => json(session.exchange(home, members, connections)?),
            Request::View(view) => json(session.view(&view)?),
            Request::Events { run } => json(session.record(run)?.events()),
            Request::Again => json(session.again(home)?),
            Request::Figures(of) => json(signals::figures(home, session, &of)?),
            Request::Identify(of) => json(signals::identify(home, session, &of)?),
            Request::Tune(of) => json(tune::tune(home, &of)?),
            Request::Ratio(of) => json(tune::ratio(&of.heating, &of.cooling)?),
            Request::Columns { text } => json(csv::Table::headers(&text)?),
            Request::Replay(of) => json(replay::replay(home, &of)?),
            Request::Characteristic(of) => json(characteristic::characteristics(home, &of.member)?),
            Request::Preset(of) => json(crate::preset::of(home, &of)?),
            Request::Export(of) => json(export::export(home, session, &of)?),
        }
    }
}

fn json(content: impl Serialize) -> Result<serde_json::Value> {
    Ok(serde_json::to_value(content)?)
}

#[cfg(test)]
mod tests;
