//! The requests of the page, each with its answer and the function that computes it.

use crate::experiment::{self, RelayTested, Settled, StepTested};
use crate::export::{self, Exported};
use crate::home::Home;
use crate::message::{
    Act, Catalogue, Checked, Curves, Description, Events, Figures, FiguresRequest, KnownLoop, Loops, Member, Program,
    Proposal, ReadFile, Setup, State, Tried, Values, View,
};
use crate::preset::{self, Preset};
use crate::program::{self, Compiled, Looked, Monitored, Programs};
use crate::report::{self, Forecasted, RulesTable, Tuning};
use crate::session::{Session, Until};
use crate::{connect, describe, known, signals};
use anyhow::Result;
use control::bode::{self, Bode};
use control::characteristic::{self, Characteristics};
use control::csv;
use control::identify::{self, Identified};
use control::in_force;
use control::replay::{self, Replayed};
use control::tune::{self, Ratio, Tuned};
use serde::{Deserialize, Serialize};

/// Each entry reads `request -> type of the answer = expression`. The TypeScript types of requests and answers are
/// generated from these entries.
macro_rules! requests {
    (|$home:ident, $session:ident| $(
        $(#[$docs:meta])*
        $Name:ident $({ $( $(#[$about:meta])* $field:ident: $Field:ty, )* })? $(($given:ident: $Given:ty))? -> $Answer:ty = $answer:expr;
    )*) => {
        /// A request of the page.
        #[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
        #[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
        #[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
        pub enum Request { $(
            $(#[$docs])*
            #[doc = concat!("Answer: `", stringify!($Answer), "`.")]
            $Name $({ $( $(#[$about])* $field: $Field, )* })? $(($Given))?,
        )* }

        impl Request {
            /// Answers the request.
            ///
            /// # Errors
            /// The problem, with name and value, and the remedy.
            pub(crate) fn answer<H: Home>(self, $home: &Programs<H>, $session: &mut Session) -> Result<serde_json::Value> {
                Ok(match self { $(
                    Request::$Name $({ $($field),* })? $(($given))? => serde_json::to_value::<$Answer>($answer)?,
                )* })
            }
        }

        /// Adds the type of each request's answer.
        #[cfg(test)]
        fn each_answer(types: &mut typescript::Types) {
            $( types.answer::<$Answer>(stringify!($Name)); )*
        }
    };
}

requests! { |home, session|
    /// The available FMUs.
    Catalogue -> Catalogue = describe::catalogue(home);
    /// An FMU with its variables, groups and roles.
    Describe {
        /// The FMU's name in the catalogue.
        fmu: String,
    } -> Description = describe::describe(home, &fmu)?;
    /// Reads a parameter file.
    Read(file: ReadFile) -> Loops = describe::read(home, &file)?;
    /// Reads a description of a loop, as accepted by `plcfmu run`.
    Described {
        /// The file name, for messages.
        file: String,
        /// The text of the file.
        text: String,
    } -> KnownLoop = known::described(&file, &text)?;
    /// Translates a PLC program and, if there are no errors, adds it to the catalogue.
    Compile(of: Program) -> Compiled = program::compile(home, &of)?;
    /// The activity of a program during one call of the current run, line by line.
    Monitor {
        /// Its name in the loop.
        member: String,
        /// The 0-based index of the call; by default the last call. For an earlier call, the run is repeated up to it.
        #[serde(default)]
        call: Option<usize>,
        /// The block whose networks are displayed, and the path of its instance, which is empty for a function.
        #[serde(default)]
        networks: Option<(String, String)>,
        /// The blocks whose decisions are requested, each with the path of its instance.
        #[serde(default)]
        why: Option<Vec<(String, String)>>,
    } -> Monitored = {
        let looked = Looked { networks: networks.as_ref(), why: why.as_deref().unwrap_or_default() };
        program::monitor(home, session, &member, call, looked)?
    };
    /// Checks settings of a block before they are sent.
    Check {
        /// The FMU's name in the catalogue.
        fmu: String,
        /// Its settings; the others have their start values.
        values: Values,
    } -> Checked = describe::check(home, &fmu, &values)?;
    /// Proposes how to connect a controller and a plant.
    Propose {
        /// The controller.
        controller: Member,
        /// The plant to connect to it.
        plant: Member,
    } -> Proposal = connect::propose(home, &controller, &plant)?;
    /// Starts a run; the current run, if any, becomes an earlier run.
    Start(setup: Setup) -> State = session.start(home, setup)?;
    /// The state of the current run, for example after a reload of the page.
    State -> State = session.state()?;
    /// Sets variables before the next call.
    Send {
        /// The values, by `MEMBER.VARIABLE`.
        values: Values,
    } -> State = session.send(&values)?;
    /// Writes variables of blocks and programs, outputs and local variables included: once before the next call, or for
    /// every call until they are released.
    Force {
        /// `write`, `force` or `release`. For `set`, use [`Request::Send`].
        act: Act,
        /// The values, by `MEMBER.VARIABLE`; ignored for a release.
        values: Values,
    } -> State = session.force(act, &values)?;
    /// Ramps a variable linearly to a value, call by call.
    Ramp {
        /// `MEMBER.VARIABLE`
        variable: String,
        /// The last value.
        to: f64,
        /// The duration, in seconds.
        seconds: f64,
    } -> State = session.ramp(&variable, to, seconds)?;
    /// Makes calls.
    Run {
        /// The maximum number of calls, at least one.
        calls: usize,
        /// A condition; the call in which it becomes true is the last.
        #[serde(default)]
        until: Option<Until>,
    } -> State = session.run_until(calls, until.as_ref())?;
    /// Makes calls until the loop has settled.
    Settle(of: experiment::Settle) -> Settled = experiment::settle(home, session, &of)?;
    /// Settles the loop in automatic mode at a setpoint, from which a step can begin.
    RestAt(of: experiment::RestAt) -> Settled = experiment::rest_at(home, session, &of)?;
    /// Replaces all members but the first, the controller, which continues; the new members start now.
    Exchange {
        /// The new members.
        members: Vec<Member>,
        /// All connections.
        connections: Vec<(String, String)>,
    } -> State = session.exchange(home, members, connections)?;
    /// The curves of a run, thinned out.
    View(view: View) -> Curves = session.view(&view)?;
    /// The setup of a run, and its events.
    Events {
        /// The run; by default the current one.
        run: Option<usize>,
    } -> Events = session.record(run)?.events();
    /// Repeats a run with the same setup, calls and events; the results are bit-identical.
    SameBits {
        /// The run to repeat; by default the current one.
        #[serde(default)]
        run: Option<usize>,
    } -> State = session.same_bits(home, run)?;
    /// Repeats the test of a run with other settings: its stimuli (setpoint, manual value, disturbances, noise) recur
    /// at the same times. Plant and connections at the end of that run, and the settings, apply from the beginning.
    SameTest {
        /// The run whose test is repeated; by default the current one.
        #[serde(default)]
        run: Option<usize>,
        /// The new settings, by `MEMBER.VARIABLE`; all others have their value at the end of that run. Stimuli are
        /// ignored.
        #[serde(default)]
        values: Values,
    } -> State = session.same_test(home, run, &values)?;
    /// Curves and figures that the test of the current run would have with other settings. The current run is not
    /// affected.
    Try {
        /// The settings, by `MEMBER.VARIABLE`; stimuli are ignored.
        values: Values,
        /// The curves to draw; its `run` is ignored.
        view: View,
        /// The window and units of the figures; its `run` is ignored.
        #[serde(default)]
        figures: FiguresRequest,
    } -> Tried = home.beside(|| signals::tried(home, session, &values, view, figures))?;
    /// The figures of a run.
    Figures(of: FiguresRequest) -> Figures = signals::figures(home, session, &of)?;
    /// The last setpoint step in a run as predicted by the identified plant with the settings in force at that time,
    /// for comparison with the run's figures; `None` if it was not a step in automatic mode.
    Forecast {
        /// The run; by default the current one.
        #[serde(default)]
        run: Option<usize>,
        /// The plant to connect to it.
        tuning: Box<Tuning>,
    } -> Option<Forecasted> = report::forecast(home, session, run, &tuning)?;
    /// Identifies a plant's model from a step in a run or in a CSV file.
    Identify(of: identify::IdentifyRequest) -> Identified = signals::identify(home, session, &of)?;
    /// Computes settings for a plant's model by a tuning rule, and predicts their effects.
    Tune(of: tune::TuneRequest) -> Tuned = tune::tune(home, &of)?;
    /// The settings by all rules for a plant's model and one structure, with their predicted effects on the same
    /// setpoint step and the same load. The rule in the request is ignored.
    Rules(of: tune::TuneRequest) -> RulesTable = tune::table(home, &of)?.into();
    /// The controller's current settings, with their predicted effects on the same step.
    InForce(of: tune::TuneRequest) -> Tuned = in_force::in_force(home, &of)?;
    /// The frequency response and margins of the open loop of controller and plant model, for the controller's settings
    /// and for others.
    Bode(of: bode::BodeRequest) -> Bode = bode::bode(home, &of)?;
    /// Step test: holds the manipulated value until the process value has settled, steps it, waits until the process
    /// value has settled again, and identifies the plant.
    StepTest(of: experiment::StepTest) -> StepTested = experiment::step(home, session, &of)?;
    /// Relay test: holds the manipulated value until the process value has settled, switches it up and down, and
    /// returns the ultimate gain and period.
    RelayTest(of: experiment::RelayTest) -> RelayTested = experiment::relay(home, session, &of)?;
    /// RATIOFAC, from a heating step and a cooling step.
    Ratio(of: tune::RatioRequest) -> Ratio = tune::ratio(&of.heating, &of.cooling)?;
    /// The characteristic of a block with pulses: the mean of the pulses as a function of its input.
    Characteristic(of: characteristic::CharacteristicRequest) -> Characteristics = home.beside(|| characteristic::characteristics(home, &of.member))?;
    /// The column names in the header of a CSV file.
    Columns {
        /// The file's text.
        text: String,
    } -> Vec<String> = csv::CsvTable::read(&text)?.headers();
    /// Replays a recording through the block.
    Replay(of: replay::ReplayRequest) -> Replayed = home.beside(|| replay::replay(home, &of))?;
    /// The files in which a preset differs from its block's FMU.
    Preset(of: preset::PresetRequest) -> Preset = preset::make(home, &of)?;
    /// A file to export.
    Export(of: export::ExportRequest) -> Exported = home.beside(|| export::export(home, session, &of))?;
}

#[cfg(test)]
mod typescript;
