//! From a request to an answer.

use crate::export::Exported;
use crate::home::Home;
use crate::message::{
    Answer, Catalogue, Checked, Curves, Description, Error, Events, Figures, Loops, Proposal, Request, State,
};
use crate::preset::Preset;
use crate::session::Session;
use crate::{connect, describe, export, signals};
use anyhow::Result;
use control::characteristic::Characteristics;
use control::identify::Identified;
use control::replay::Replayed;
use control::tune::{Ratio, Tuned};
use control::{characteristic, csv, replay, tune};

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
        answer(&self.home, &mut self.session, request)
    }
}

/// `request => type of the answer = what gives it`. The page's types of requests and answers are made of these lines.
macro_rules! answers {
    (|$home:ident, $session:ident| $($request:pat => $Answer:ty = $given:expr,)*) => {
        fn answer($home: &dyn Home, $session: &mut Session, request: Request) -> Result<serde_json::Value> {
            Ok(match request { $($request => serde_json::to_value::<$Answer>($given)?,)* })
        }

        /// Each request with the type of its answer.
        #[cfg(test)]
        fn each_answer(types: &mut typescript::Types) {
            $(types.answer::<$Answer>(stringify!($request));)*
        }
    };
}

answers! { |home, session|
    Request::Catalogue => Catalogue = describe::catalogue(home),
    Request::Describe { fmu } => Description = describe::describe(home, &fmu)?,
    Request::Read(file) => Loops = describe::read(home, &file)?,
    Request::Check { fmu, values } => Checked = describe::check(home, &fmu, &values)?,
    Request::Propose { controller, plant } => Proposal = connect::propose(home, &controller, &plant)?,
    Request::Start(setup) => State = session.start(home, setup)?,
    Request::State => State = session.state()?,
    Request::Send { values } => State = session.send(&values)?,
    Request::Ramp { variable, to, seconds } => State = session.ramp(&variable, to, seconds)?,
    Request::Run { calls } => State = session.run(calls)?,
    Request::Exchange { members, connections } => State = session.exchange(home, members, connections)?,
    Request::View(view) => Curves = session.view(&view)?,
    Request::Events { run } => Events = session.record(run)?.events(),
    Request::Again => State = session.again(home)?,
    Request::Figures(of) => Figures = signals::figures(home, session, &of)?,
    Request::Identify(of) => Identified = signals::identify(home, session, &of)?,
    Request::Tune(of) => Tuned = tune::tune(home, &of)?,
    Request::Ratio(of) => Ratio = tune::ratio(&of.heating, &of.cooling)?,
    Request::Columns { text } => Vec<String> = csv::Table::headers(&text)?,
    Request::Replay(of) => Replayed = replay::replay(home, &of)?,
    Request::Characteristic(of) => Characteristics = characteristic::characteristics(home, &of.member)?,
    Request::Preset(of) => Preset = crate::preset::of(home, &of)?,
    Request::Export(of) => Exported = export::export(home, session, &of)?,
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod typescript;
