//! What the page asks for: each request with its answer and what computes it.

use crate::experiment::{self, RelayTested, Settled, StepTested};
use crate::export::{self, Exported};
use crate::home::Home;
use crate::message::{
    Act, Catalogue, Checked, Curves, Description, Events, Figures, FiguresRequest, KnownLoop, Loops, Member, Program,
    Proposal, ReadFile, Setup, State, Tried, Values, View,
};
use crate::preset::{self, Preset};
use crate::program::{self, Compiled, Looked, Monitored, Programs};
use crate::report::{self, Forecasted, Tuning};
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

/// `request -> type of the answer = what gives it`. The page's types of requests and answers are made of these lines.
macro_rules! requests {
    (|$home:ident, $session:ident| $(
        $(#[$docs:meta])*
        $Name:ident $({ $( $(#[$about:meta])* $field:ident: $Field:ty, )* })? $(($given:ident: $Given:ty))? -> $Answer:ty = $answer:expr;
    )*) => {
        /// What the page asks for.
        #[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
        #[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
        #[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
        pub enum Request { $(
            $(#[$docs])*
            #[doc = concat!("Answer: `", stringify!($Answer), "`.")]
            $Name $({ $( $(#[$about])* $field: $Field, )* })? $(($Given))?,
        )* }

        impl Request {
            /// Answers it.
            ///
            /// # Errors
            /// What is wrong, with name and value, and what to do.
            pub(crate) fn answer<H: Home>(self, $home: &Programs<H>, $session: &mut Session) -> Result<serde_json::Value> {
                Ok(match self { $(
                    Request::$Name $({ $($field),* })? $(($given))? => serde_json::to_value::<$Answer>($answer)?,
                )* })
            }
        }

        /// Each request with the type of its answer.
        #[cfg(test)]
        fn each_answer(types: &mut typescript::Types) {
            $( types.answer::<$Answer>(stringify!($Name)); )*
        }
    };
}

requests! { |home, session|
    /// Which FMUs there are.
    Catalogue -> Catalogue = describe::catalogue(home);
    /// An FMU with its variables, groups and roles.
    Describe {
        /// The FMU's name in the catalogue.
        fmu: String,
    } -> Description = describe::describe(home, &fmu)?;
    /// Reads a parameter file.
    Read(file: ReadFile) -> Loops = describe::read(home, &file)?;
    /// Reads a description of a loop, as `plcfmu run` takes it.
    Described {
        /// Its file's name, for messages.
        file: String,
        /// Its text.
        text: String,
    } -> KnownLoop = known::described(&file, &text)?;
    /// Translates a PLC program, and takes it into the catalogue.
    Compile(of: Program) -> Compiled = program::compile(home, &of)?;
    /// What a program of the present run did in a call, line by line.
    Monitor {
        /// Its name in the loop.
        member: String,
        /// The call, from 0; the last one without it. For an earlier one the run is made again up to it.
        #[serde(default)]
        call: Option<usize>,
        /// The block whose networks are looked at, and the path of its instance; a function has an empty one.
        #[serde(default)]
        networks: Option<(String, String)>,
        /// The blocks of which it is asked what decided, each with the path of its instance.
        #[serde(default)]
        why: Option<Vec<(String, String)>>,
    } -> Monitored = {
        let looked = Looked { networks: networks.as_ref(), why: why.as_deref().unwrap_or_default() };
        program::monitor(home, session, &member, call, looked)?
    };
    /// What a block does with settings, before they are sent.
    Check {
        /// The FMU's name in the catalogue.
        fmu: String,
        /// Its settings; the others have their start values.
        values: Values,
    } -> Checked = describe::check(home, &fmu, &values)?;
    /// How a controller and a plant are connected.
    Propose {
        /// The controller.
        controller: Member,
        /// The plant.
        plant: Member,
    } -> Proposal = connect::propose(home, &controller, &plant)?;
    /// Begins a run; one that is there is kept as an earlier run.
    Start(setup: Setup) -> State = session.start(home, setup)?;
    /// Where the present run is, as after a reload of the page.
    State -> State = session.state()?;
    /// Sets variables before the next call.
    Send {
        /// The values, by `MEMBER.VARIABLE`.
        values: Values,
    } -> State = session.send(&values)?;
    /// Writes variables of blocks and programs whatever they are: once before the next call, or for every call until they are
    /// released.
    Force {
        /// `write`, `force` or `release`; `set` is what [`Request::Send`] does.
        act: Act,
        /// The values, by `MEMBER.VARIABLE`. Those of a release do not count.
        values: Values,
    } -> State = session.force(act, &values)?;
    /// Moves a variable evenly to a value, call by call.
    Ramp {
        /// `MEMBER.VARIABLE`
        variable: String,
        /// The last value.
        to: f64,
        /// How long it takes.
        seconds: f64,
    } -> State = session.ramp(&variable, to, seconds)?;
    /// Makes calls.
    Run {
        /// How many, one at least.
        calls: usize,
        /// A condition: the call in which it begins to hold is the last one.
        #[serde(default)]
        until: Option<Until>,
    } -> State = session.run_until(calls, until.as_ref())?;
    /// Makes calls until the loop rests.
    Settle(of: experiment::Settle) -> Settled = experiment::settle(home, session, &of)?;
    /// Brings the loop to rest in automatic mode at a setpoint, from where a step can begin.
    RestAt(of: experiment::RestAt) -> Settled = experiment::rest_at(home, session, &of)?;
    /// Replaces all members but the first by others, which begin now; the controller goes on.
    Exchange {
        /// The new members.
        members: Vec<Member>,
        /// All connections.
        connections: Vec<(String, String)>,
    } -> State = session.exchange(home, members, connections)?;
    /// The curves of a run, thinned out.
    View(view: View) -> Curves = session.view(&view)?;
    /// What a run began with, and what was done in it.
    Events {
        /// The run; the present one without it.
        run: Option<usize>,
    } -> Events = session.record(run)?.events();
    /// Repeats a record: the same setup, the same calls with the same events, and so the same bits.
    SameBits {
        /// The run that is repeated; the present one without it.
        #[serde(default)]
        run: Option<usize>,
    } -> State = session.same_bits(home, run)?;
    /// Repeats the test of a run with other settings: its stimuli (setpoint, manual value, disturbances, noise) come again when they
    /// came; settings, plant and connections are from the beginning on those that are in force.
    SameTest {
        /// The run whose test it is; the present one without it.
        #[serde(default)]
        run: Option<usize>,
        /// The settings in force, by `MEMBER.VARIABLE`; those that are left out have the value that they have at the end of
        /// that run. Stimuli are ignored.
        #[serde(default)]
        values: Values,
    } -> State = session.same_test(home, run, &values)?;
    /// Curves and figures of the present run's test with other settings. The present run goes on undisturbed.
    Try {
        /// The settings, by `MEMBER.VARIABLE`; stimuli are ignored.
        values: Values,
        /// What is drawn; its `run` is ignored.
        view: View,
        /// Of which part the figures are, and their units; its `run` is ignored.
        #[serde(default)]
        figures: FiguresRequest,
    } -> Tried = home.beside(|| signals::tried(home, session, &values, view, figures))?;
    /// The figures of a run.
    Figures(of: FiguresRequest) -> Figures = signals::figures(home, session, &of)?;
    /// The last step of the setpoint in a run as the identified plant predicts it with the settings that were in force, to stand beside the
    /// figures of the run; none if it was no step from rest in automatic mode.
    Forecast {
        /// The run; the present one without it.
        #[serde(default)]
        run: Option<usize>,
        /// The plant.
        tuning: Box<Tuning>,
    } -> Option<Forecasted> = report::forecast(home, session, run, &tuning)?;
    /// A plant's model from a step in a run or in a CSV file.
    Identify(of: identify::IdentifyRequest) -> Identified = signals::identify(home, session, &of)?;
    /// Settings for a plant's model by a rule, with what they lead to.
    Tune(of: tune::TuneRequest) -> Tuned = tune::tune(home, &of)?;
    /// All rules for a plant's model and one structure, with what they lead to: Ms, overshoot, settling time and travel for one step.
    /// The rule of the request does not count.
    Rules(of: tune::TuneRequest) -> Vec<tune::RuleOutcome> = tune::table(home, &of)?;
    /// The settings in force, with what they lead to in the same step.
    InForce(of: tune::TuneRequest) -> Tuned = in_force::in_force(home, &of)?;
    /// The open loop of a plant's model with the controller, with its settings and with others, and its margins.
    Bode(of: bode::BodeRequest) -> Bode = bode::bode(home, &of)?;
    /// Holds the plant at the present manipulated value until it rests, steps it, waits until it rests again, and identifies.
    StepTest(of: experiment::StepTest) -> StepTested = experiment::step(home, session, &of)?;
    /// Holds the plant, lets the manipulated value switch up and down, and gives the ultimate gain and period.
    RelayTest(of: experiment::RelayTest) -> RelayTested = experiment::relay(home, session, &of)?;
    /// RATIOFAC from a heating and a cooling step.
    Ratio(of: tune::RatioRequest) -> Ratio = tune::ratio(&of.heating, &of.cooling)?;
    /// The mean of a block's pulses over an input.
    Characteristic(of: characteristic::CharacteristicRequest) -> Characteristics = home.beside(|| characteristic::characteristics(home, &of.member))?;
    /// The names of a CSV file's columns, as its header has them; what is wrong with the file otherwise.
    Columns {
        /// The file's text.
        text: String,
    } -> Vec<String> = csv::CsvTable::read(&text)?.headers();
    /// A recorded file through the block.
    Replay(of: replay::ReplayRequest) -> Replayed = home.beside(|| replay::replay(home, &of))?;
    /// The files in which a preset differs from its block's FMU.
    Preset(of: preset::PresetRequest) -> Preset = preset::make(home, &of)?;
    /// A file to take away.
    Export(of: export::ExportRequest) -> Exported = home.beside(|| export::export(home, session, &of))?;
}

#[cfg(test)]
mod typescript;
