//! The simulated loop: the real block with a plant model, after a setpoint step.
//!
//! The block is called as in a run of the tool: once per CYCLE, before the plant, which then advances by one CYCLE with
//! the manipulated value held. First, the loop is brought to steady state in manual mode. If the block has a manual
//! value, it is 50 % unless the user specifies another; the plant starts in steady state with the resulting output of
//! the block. Then the controller is switched to automatic mode, and the setpoint steps. By default, the step is 10 %
//! times the plant's gain, so that the manipulated value has moved by 10 % in the new steady state. For an integrating
//! plant, it is 10 % divided by GAIN, so that the manipulated value initially moves by 10 %. The target of a default
//! step is rounded.
//!
//! After a load, the loop has recovered once the process value stays within a band around the setpoint. The request
//! specifies the band, which after a run depends on the run's last step; by default, the band is that of the default
//! step, so that the size of the predicted step does not affect the figures of a load.
//!
//! The rows are those of a run of the loop. If all members run in parallel, a row holds the controller's output of the
//! previous call next to the setpoint of the current one: a run of this loop lags by one call, and so does the
//! prediction. A model identified in the loop includes this delay of one call in its dead time.
//!
//! Pulses drive the model directly, as 100 %, 0 or -100 %. The pulses of a step controller move a valve, which starts
//! at mid-travel and takes the motor time from stop to stop.

use crate::extremes;
use crate::figures::{BAND, OVERSHOOT, SETTLING, Signals, Span, Window, find};
use crate::identify::Model;
use crate::process::Process;
use crate::tune::{Controller, Load, Predicted, TuneRequest};
use anyhow::{Context, Result, bail};
use blocks::{Kind, Role};
use modeldescription::digits::short;
use modeldescription::{Causality, Description, Support, Variability, Variable};
use run::component::{Component, Type};
use run::fmus::Fmus;
use run::fmus::Values;
use run::master::Run;
use run::plan::Plan;
use run::system::{Connection, Exchange, Member, Recorded, Setting, System, Value};
use std::collections::BTreeMap;

/// The manual value before the step, in percent.
const MANUAL: f64 = 50.0;
/// The movement of the manipulated value that the default setpoint step causes, in percent.
const STEP: f64 = 10.0;
/// The size of the load, in percent of the manipulated value.
const LOAD: f64 = 10.0;
/// The maximum number of calls to simulate after the step.
const MOST_CALLS: usize = 200_000;
/// The factors by which the simulated time is extended, tried in this order until the loop settles.
const LONGER: [usize; 6] = [2, 4, 8, 16, 32, 64];
/// Extensions up to this factor are always tried; longer ones only if the plant itself takes that long.
const SURELY_LONGER: usize = 4;
/// A manipulated value that equals its last value in more than this fraction of the calls in the second half is at a
/// limit.
const STAYS: f64 = 0.9;
/// Up to this many calls before the step and as many after it are shown; of the later calls, at most four times as
/// many.
const ALL_SHOWN: usize = 200;
/// The names of the two members of the simulated loop.
const CONTROLLER: &str = "CONTROLLER";
const PROCESS: &str = "PROCESS";

/// The variables of the process; their indices are their value references.
const INPUT: u32 = 0;
const UP: u32 = 1;
const DOWN: u32 = 2;
const OUTPUT: u32 = 3;
const WORD: u32 = 4;
const POSITION: u32 = 5;
const VARIABLES: [(&str, Type, Causality); 6] = [
    ("INPUT", Type::Real, Causality::Input),
    ("UP", Type::Boolean, Causality::Input),
    ("DOWN", Type::Boolean, Causality::Input),
    ("OUTPUT", Type::Real, Causality::Output),
    ("WORD", Type::Integer, Causality::Output),
    ("POSITION", Type::Real, Causality::Output),
];

/// A model as a member of a run.
#[derive(Clone)]
struct Plant {
    process: Process,
    /// The process value in steady state.
    level: f64,
    /// The factor and offset that convert a process value to a word of an analog input: word = (value - offset) /
    /// factor.
    scaling: Option<(f64, f64)>,
    /// The time that a valve takes from stop to stop; `None` if the input acts on the model directly.
    motor_time: Option<f64>,
    /// The time from which a load is added to the input, in seconds, and its size in percent of the manipulated value.
    load: Option<(f64, f64)>,
    /// The time in seconds until which the plant is kept in steady state, and the length of the interval before that
    /// time over which its input is averaged.
    rest: (f64, f64),
    /// The sum and the number of the inputs during that interval; their mean is the input in steady state.
    resting: (f64, f64),
    /// The values of all variables; true is 1.
    values: [f64; VARIABLES.len()],
}

impl Plant {
    /// Moves the valve during a step of `size` seconds and returns the mean input of the model.
    fn drive(&mut self, size: f64) -> f64 {
        let pulses = 100.0 * (self.values[UP as usize] - self.values[DOWN as usize]);
        let Some(motor_time) = self.motor_time else {
            let input = self.values[INPUT as usize] + pulses;
            self.values[POSITION as usize] = input;
            return input;
        };
        let before = self.values[POSITION as usize];
        let after = if motor_time > 0.0 { before + pulses * size / motor_time } else { before + pulses };
        let after = after.clamp(0.0, 100.0);
        self.values[POSITION as usize] = after;
        f64::midpoint(before, after)
    }

    fn show(&mut self, deviation: f64) {
        let value = self.level + deviation;
        self.values[OUTPUT as usize] = value;
        if let Some((factor, offset)) = self.scaling {
            let word = ((value - offset) / factor).round();
            self.values[WORD as usize] = word.clamp(f64::from(i16::MIN), f64::from(i16::MAX));
        }
    }
}

impl Component for Plant {
    fn setup(&mut self, _: f64, _: Option<f64>) -> Result<()> {
        self.values[POSITION as usize] = MANUAL;
        self.show(0.0);
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn read(&mut self, _: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        for (value, reference) in values.iter_mut().zip(references) {
            *value = self.values[*reference as usize];
        }
        Ok(())
    }

    fn write(&mut self, _: Type, references: &[u32], values: &[f64]) -> Result<()> {
        for (value, reference) in values.iter().zip(references) {
            self.values[*reference as usize] = *value;
        }
        Ok(())
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        let input = self.drive(size);
        let (until, length) = self.rest;
        // A tolerance of half a step makes rounding irrelevant.
        if time < until - size / 2.0 {
            if time >= until - length - size / 2.0 {
                self.resting = (self.resting.0 + input, self.resting.1 + 1.0);
            }
            return Ok(());
        }
        let load = self.load.filter(|(from, _)| time >= from - size / 2.0).map_or(0.0, |(_, load)| load);
        self.process.put(time, input + load - self.resting.0 / self.resting.1.max(1.0));
        let deviation = self.process.output_at(time + size);
        self.show(deviation);
        Ok(())
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

/// The process as an FMU would describe it.
fn description() -> Description {
    let variable = |(reference, (name, kind, causality)): (usize, &(&str, Type, Causality))| Variable {
        name: (*name).into(),
        value_reference: reference as u32,
        causality: *causality,
        variability: Variability::Discrete,
        kind: Some(*kind),
        type_name: kind.name(),
        ..Variable::default()
    };
    Description {
        co_simulation: Some(Support::default()),
        variables: VARIABLES.iter().enumerate().map(variable).collect(),
        ..Description::default()
    }
}

/// The call numbers of the events.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Schedule {
    cycle: f64,
    /// The first call in automatic mode, from which the plant responds to its input.
    automatic: usize,
    /// The call with the new setpoint.
    step: usize,
    /// The number of calls, including those before the step.
    calls: usize,
}

impl Schedule {
    /// # Errors
    /// The pulses are too long to be simulated.
    fn new(
        controller: &Controller,
        request: &TuneRequest,
        dead_time: f64,
        values: &Values,
        longer: usize,
    ) -> Result<Schedule> {
        let cycle = controller.cycle();
        let calls = |time: f64| (time / cycle).ceil() as usize;
        let period = controller.own_period().unwrap_or(cycle).max(controller.sampling());
        if period > cycle * MOST_CALLS as f64 / 10.0 {
            bail!(
                "the pulse period is {period} s and the block's CYCLE {cycle} s: the simulation would take \
                 too many calls: shorten the pulse period"
            );
        }
        let rest = 2 * calls(period).max(1);
        let ti = controller.roles.controller.get(1).and_then(|name| values.get(name));
        let lag = request.model.time_constant + request.model.second_time_constant;
        let slow = match ti {
            Some(Value::Number(ti)) => 5.0 * ti,
            _ => 5.0 * lag,
        };
        let motor_time = controller.motor_time().unwrap_or_default();
        let duration = slow + 15.0 * dead_time + 2.0 * motor_time + 10.0 * period;
        let step = rest + rest.max(5);
        let wanted = if duration / cycle < MOST_CALLS as f64 { calls(duration) } else { MOST_CALLS };
        let wanted = (wanted.max(20) * longer).min(MOST_CALLS.max(20));
        Ok(Schedule { cycle, automatic: rest, step, calls: step + wanted })
    }

    /// Returns the schedule of a step whose response lasts this many seconds.
    ///
    /// # Errors
    /// The response lasts too long.
    fn lasting(controller: &Controller, request: &TuneRequest, values: &Values, duration: f64) -> Result<Schedule> {
        let dead_time = request.model.dead_time + controller.cycle() / 2.0;
        let schedule = Schedule::new(controller, request, dead_time, values, 1)?;
        let calls = (duration / schedule.cycle).round() + 1.0;
        if calls > MOST_CALLS as f64 {
            bail!("the measured response lasts {} s, but at most {MOST_CALLS} calls can be predicted", short(duration));
        }
        Ok(Schedule { calls: schedule.step + calls as usize, ..schedule })
    }

    fn time(&self, call: usize) -> f64 {
        call as f64 * self.cycle
    }
}

/// What the user is told about a prediction.
#[derive(Debug, Default)]
pub struct Told {
    /// The remarks, one sentence each.
    pub remarks: Vec<String>,
    /// The reasons for missing metrics, as in [`Tuned::absent`](crate::tune::Tuned::absent).
    pub absent: BTreeMap<String, String>,
}

/// Simulates the loop with these settings.
///
/// # Errors
/// The block cannot be simulated with the model; the message states the reason.
pub fn predict(
    home: &dyn Fmus,
    controller: &Controller,
    request: &TuneRequest,
    values: &Values,
) -> Result<(Predicted, Told)> {
    let step = |simulation: &Simulation| {
        let (predicted, mut told) = shown(&simulation.step()?, &simulation.schedule, controller, simulation.height);
        told.remarks.extend(simulation.terminal.remark());
        Ok((predicted, told))
    };
    let load = |simulation: &Simulation| {
        let size = LOAD * simulation.roomier();
        let rows = simulation.load(size)?;
        let load = Load::new(&rows, &simulation.schedule, simulation.band, size);
        let why = load.recovery.is_none().then(|| unrecovered(&rows[simulation.schedule.step..], controller));
        Ok((load, why))
    };
    let simulate = |longer| Simulation::longer(home, controller, request, values, longer);
    let (mut predicted, mut told) = resting(request, simulate, step, |(of, _)| of.settling.is_some())?;
    let (load, why) = resting(request, simulate, load, |(_, why)| why.is_none())?;
    if let Some(why) = why {
        told.absent.extend(["recovery", "iae"].map(|metric| (metric.to_string(), why.clone())));
    }
    predicted.load = Some(load);
    Ok((predicted, told))
}

/// Evaluates the loop over the usual time or, if it has not settled by then, over the first of the longer times
/// ([`LONGER`]) within which it settles; over the usual time if it settles within none of them. A calm loop takes
/// longer after a load than after a setpoint step, a fast loop whose manipulated value is at its limit takes as long as
/// its plant, and an oscillating loop never does.
fn resting<'a, T>(
    request: &TuneRequest,
    simulate: impl Fn(usize) -> Result<Simulation<'a>>,
    make: impl Fn(&Simulation<'a>) -> Result<T>,
    rests: impl Fn(&T) -> bool,
) -> Result<T> {
    let simulation = simulate(1)?;
    let mut found = make(&simulation)?;
    let Schedule { cycle, step, calls, .. } = simulation.schedule;
    let usual = (calls - step) as f64 * cycle;
    let Model { gain, time_constant, second_time_constant, is_integrating, .. } = request.model;
    let slow = match is_integrating {
        true => (simulation.height / (gain * STEP)).abs(),
        false => 5.0 * (time_constant + second_time_constant),
    };
    for longer in LONGER {
        if rests(&found) || longer > SURELY_LONGER && usual * longer as f64 > 2.0 * slow {
            break;
        }
        let later = make(&simulate(longer)?)?;
        if rests(&later) {
            found = later;
        }
    }
    Ok(found)
}

/// A predicted step to compare with a measured one.
pub struct Forecast {
    /// The process value in each call since the step.
    pub process_value: Vec<f64>,
    /// The manipulated value in these calls; empty if pulses drive the plant.
    pub manipulated_value: Vec<f64>,
    /// The time between two calls in seconds.
    pub cycle: f64,
    /// The figures that can be computed, by key.
    pub figures: Vec<(&'static str, f64)>,
}

/// Predicts a step over `duration` seconds, the time for which it was measured, so that the figures are comparable.
///
/// # Errors
/// As in [`predict`].
pub fn forecast(
    home: &dyn Fmus,
    controller: &Controller,
    request: &TuneRequest,
    values: &Values,
    duration: f64,
) -> Result<Forecast> {
    let schedule = Schedule::lasting(controller, request, values, duration)?;
    let (cycle, step) = (schedule.cycle, schedule.step);
    let rows = Simulation::new(home, controller, request, values, schedule)?.step()?;
    let times: Vec<f64> = (0..rows.len()).map(|call| schedule.time(call)).collect();
    let columns: [Vec<f64>; 3] = [0, 1, 2].map(|column| rows.iter().map(|row| row[column]).collect());
    let [setpoint, process_value, manipulated_value] = &columns;
    let manipulated_value = if controller.roles.pulses.is_empty() { manipulated_value } else { &Vec::new() };
    let signals = Signals { times: &times, setpoint, process_value, manipulated_value, ..Signals::default() };
    let window = Window::measure(signals, &Span { from: Some(schedule.time(step)), ..Span::default() });
    let figures = window.figures().filter_map(|figure| Some((figure.key, figure.value(&window).ok()?))).collect();
    let manipulated_value = manipulated_value.get(step..).unwrap_or_default().to_vec();
    Ok(Forecast { process_value: process_value[step..].to_vec(), manipulated_value, cycle, figures })
}

/// Predicts the figures of a disturbance, by key: a load of `size` at the plant's input, in the unit of the manipulated
/// value, over `duration` seconds, the time for which it acted in a run. The request specifies the recovery band.
///
/// # Errors
/// As in [`predict`].
pub fn forecast_load(
    home: &dyn Fmus,
    controller: &Controller,
    request: &TuneRequest,
    values: &Values,
    (duration, size): (f64, f64),
) -> Result<Vec<(&'static str, f64)>> {
    let schedule = Schedule::lasting(controller, request, values, duration)?;
    let simulation = Simulation::new(home, controller, request, values, schedule)?;
    Ok(figures_after(&simulation.load(size)?, &schedule, simulation.band))
}

/// A simulation of the loop.
struct Simulation<'a> {
    home: &'a dyn Fmus,
    controller: &'a Controller,
    schedule: Schedule,
    terminal: Terminal,
    /// The plant, to which a load can be added.
    plant: Plant,
    /// The loop, to which the setpoint step can be added.
    system: System,
    setpoint: &'a str,
    level: f64,
    height: f64,
    /// The manual value at which the plant is in steady state.
    manual: f64,
    /// Half the width of the band in which the loop counts as recovered from a load, in the unit of the process value.
    band: f64,
    /// When the predicted loop exchanges its values.
    exchange: Exchange,
}

impl<'a> Simulation<'a> {
    /// Creates a simulation of the loop over a multiple of the usual time.
    fn longer(
        home: &'a dyn Fmus,
        controller: &'a Controller,
        request: &'a TuneRequest,
        values: &Values,
        times: usize,
    ) -> Result<Simulation<'a>> {
        let dead_time = request.model.dead_time + controller.cycle() / 2.0;
        let schedule = Schedule::new(controller, request, dead_time, values, times)?;
        Simulation::new(home, controller, request, values, schedule)
    }

    fn new(
        home: &'a dyn Fmus,
        controller: &'a Controller,
        request: &TuneRequest,
        values: &Values,
        schedule: Schedule,
    ) -> Result<Simulation<'a>> {
        let setpoint = controller.roles.setpoint.as_ref().context("the controller's setpoint is unknown")?;
        let drawn = controller.roles.manipulated_value.as_ref();
        let terminal = Terminal::new(controller)?;
        let scaling = if terminal.is_word { Some(word_scaling(home, controller, &terminal)?) } else { None };
        let motor_time = controller.motor_time();
        if controller.is_step_controller() && motor_time.is_none() {
            bail!("the motor time of the actuator is unknown: specify it");
        }
        let gain = controller.roles.controller.first().and_then(|name| values.get(name));
        let usual = usual_height(request, gain);
        let level = request.step.from.unwrap_or_else(|| controller.value(setpoint));
        let height = request.step.size.unwrap_or_else(|| to_round_target(level, usual));
        let band = request.band.unwrap_or(BAND * usual.abs());
        let manual = request.step.manual.unwrap_or(MANUAL);
        if height == 0.0 || ![height, level].iter().all(|number| number.is_finite()) {
            bail!("the step is {height} from {level}: it must be a number other than 0");
        }
        if !manual.is_finite() {
            bail!("the manipulated value before the step is {manual}: it must be a finite number");
        }
        if !(band > 0.0 && band.is_finite()) {
            bail!("the recovery band is {band}: it must be above 0");
        }
        let mut values = values.clone();
        values.insert(setpoint.clone(), Value::Number(level));
        if let Some((factor, offset)) = scaling {
            let word = |value: f64| (value - offset) / factor;
            let range = f64::from(i16::MIN)..=f64::from(i16::MAX);
            if let Some(value) = [level, level + height].into_iter().find(|value| !range.contains(&word(*value))) {
                bail!(
                    "a process value of {value} is outside the range of {}: change the setpoint or the step",
                    terminal.name
                );
            }
        }
        let plant = Plant {
            process: Process::at_rest(request.model, schedule.time(schedule.automatic)),
            level,
            scaling,
            motor_time,
            load: None,
            rest: (schedule.time(schedule.automatic), schedule.time(schedule.automatic / 2)),
            resting: (0.0, 0.0),
            values: [0.0; VARIABLES.len()],
        };
        let mut system = system(controller, &values, &terminal, &schedule, manual)?;
        let manipulated = match drawn {
            Some(name) => format!("{CONTROLLER}.{name}"),
            None => format!("{PROCESS}.POSITION"),
        };
        let recorded = [format!("{CONTROLLER}.{setpoint}"), format!("{PROCESS}.OUTPUT"), manipulated];
        system.record = recorded.iter().map(|name| Recorded::from(name.as_str())).collect();
        let exchange = request.exchange;
        Ok(Simulation {
            home,
            controller,
            schedule,
            terminal,
            plant,
            system,
            setpoint,
            level,
            height,
            manual,
            band,
            exchange,
        })
    }

    /// Returns the sign of the load for which the manipulated value has more room to compensate: 1 (the manipulated
    /// value must fall) or -1 (it must rise).
    fn roomier(&self) -> f64 {
        let Some((high, low)) = &self.controller.roles.limits else { return 1.0 };
        let [above, below] =
            [(high, 1.0), (low, -1.0)].map(|(name, way)| way * (self.controller.value(name) - self.manual));
        if below >= above { 1.0 } else { -1.0 }
    }

    /// Returns the rows of setpoint, process value and manipulated value if, instead of the setpoint step, a load of
    /// this size begins at that time.
    fn load(&self, size: f64) -> Result<Vec<[f64; 3]>> {
        let load = Some((self.schedule.time(self.schedule.step), size));
        self.rows(&self.system, Plant { load, ..self.plant.clone() })
    }

    /// Returns the rows of setpoint, process value and manipulated value with the setpoint step.
    fn step(&self) -> Result<Vec<[f64; 3]>> {
        let mut system = self.system.clone();
        let time = Some(self.schedule.time(self.schedule.step));
        system.settings.push(Setting { time, ..setting(self.setpoint, Value::Number(self.level + self.height)) });
        self.rows(&system, self.plant.clone())
    }

    fn rows(&self, system: &System, plant: Plant) -> Result<Vec<[f64; 3]>> {
        let fmu = &self.controller.member.fmu;
        let plan = Plan::new(system, &[&*self.home.description(fmu)?, &description()])?;
        let mut rows = simulate(&plan, vec![self.home.instantiate(fmu, CONTROLLER)?, Box::new(plant)])?;
        if self.exchange == Exchange::Parallel {
            for row in (1..rows.len()).rev() {
                let [_, process_value, manipulated_value] = rows[row - 1];
                rows[row] = [rows[row][0], process_value, manipulated_value];
            }
        }
        Ok(rows)
    }
}

impl Load {
    /// Evaluates a load step at a constant setpoint; the figures are those of a disturbance in a run.
    fn new(rows: &[[f64; 3]], schedule: &Schedule, band: f64, size: f64) -> Load {
        let of = figures_after(rows, schedule, band);
        let figure = |key: &str| of.iter().find(|(name, _)| *name == key).map(|(_, value)| *value);
        let recovery = figure("recovery");
        Load {
            size,
            deviation: figure("disturbed_peak").unwrap_or(f64::NAN),
            recovery,
            iae: recovery.and_then(|_| figure("disturbed_iae")),
            band,
        }
    }
}

/// Returns the figures of a disturbance that begins in the call of the step, by key.
fn figures_after(rows: &[[f64; 3]], schedule: &Schedule, band: f64) -> Vec<(&'static str, f64)> {
    let times: Vec<f64> = (0..rows.len()).map(|call| schedule.time(call)).collect();
    let [setpoint, process_value] = [0, 1].map(|column| rows.iter().map(|row| row[column]).collect::<Vec<f64>>());
    let signals = Signals { times: &times, setpoint: &setpoint, process_value: &process_value, ..Signals::default() };
    let window = Window::of_disturbance(signals, schedule.step, band);
    window.figures().filter_map(|figure| Some((figure.key, figure.value(&window).ok()?))).collect()
}

/// Returns the reason why the process value does not recover after a load. The manipulated value cannot compensate
/// while it is at a limit, even if it briefly leaves the limit as the process value moves.
fn unrecovered(rows: &[[f64; 3]], controller: &Controller) -> String {
    let later: Vec<f64> = rows[rows.len() / 2..].iter().map(|[_, _, manipulated_value]| *manipulated_value).collect();
    let last = later.last().copied().unwrap_or_default();
    let stays = later.iter().filter(|value| **value == last).count() as f64 > STAYS * later.len() as f64;
    if controller.roles.pulses.is_empty() && stays {
        return format!("the manipulated value stays at its limit of {}", short(last));
    }
    find("recovery").map(|figure| figure.absent).unwrap_or_default().into()
}

/// Returns the default setpoint step, in the unit of the process value: [`STEP`] percent times the plant's gain;
/// for an integrating plant, the step that initially moves the manipulated value by [`STEP`] percent.
fn usual_height(request: &TuneRequest, gain: Option<&Value>) -> f64 {
    match gain {
        Some(Value::Number(gain)) if request.model.is_integrating => STEP / gain,
        _ => STEP * request.model.gain,
    }
}

/// Adjusts the height of a step so that its target is a multiple of the height's second significant digit: a step of
/// 7.9 from 50.13 becomes one of 7.87, to 58.
fn to_round_target(level: f64, height: f64) -> f64 {
    let digit = 10f64.powf(height.abs().log10().floor() - 1.0);
    let target = ((level + height) / digit).round() * digit;
    if target.is_finite() { target - level } else { height }
}

/// The variable that receives the process value.
#[derive(Debug, PartialEq)]
struct Terminal {
    name: String,
    /// Whether it is an analog input word.
    is_word: bool,
    /// The switches that must be set for the block to use it, with their states.
    switches: Vec<(String, bool)>,
}

impl Terminal {
    /// Finds the process value input in use; if none is, the first one, with the switches that make the block use it.
    fn new(controller: &Controller) -> Result<Terminal> {
        let peripheral = controller.roles.signals.iter().filter(|(meaning, _)| meaning.starts_with("process value"));
        let names = controller.roles.process_value.iter().chain(peripheral.map(|(_, name)| name));
        let inputs: Vec<&String> = names.filter(|name| controller.role(name) == Some(Role::Input)).collect();
        let field = |name: &str| {
            let mut fields = controller.groups.iter().flat_map(|group| &group.fields);
            fields.find(|field| field.name == name)
        };
        let is_on = |name: &str| controller.value(name) != 0.0;
        let in_use = inputs.iter().find(|name| field(name).is_none_or(|field| field.is_used(is_on)));
        let name = in_use.or(inputs.first()).context("the controller has no input for the process value")?;
        let switches = match (in_use, field(name)) {
            (None, Some(field)) => field.used_if.first().cloned().unwrap_or_default(),
            _ => Vec::new(),
        };
        let is_word = matches!(controller.kind(name), Some(Kind::Word | Kind::Int));
        Ok(Terminal { name: (*name).clone(), is_word, switches })
    }

    /// Returns a remark if switches are set only for the simulation.
    fn remark(&self) -> Option<String> {
        let state = |(name, is_on): &(String, bool)| format!("{name} = {}", if *is_on { "TRUE" } else { "FALSE" });
        let switches: Vec<String> = self.switches.iter().map(state).collect();
        let name = &self.name;
        (!switches.is_empty())
            .then(|| format!("Predicted with the process value at {name}, that is, with {}.", switches.join(" and ")))
    }
}

fn setting(name: &str, value: Value) -> Setting {
    Setting { variable: format!("{CONTROLLER}.{name}"), value, time: None, is_preliminary: false, place: None }
}

/// Returns the loop with all settings except the setpoint step.
fn system(
    controller: &Controller,
    values: &Values,
    terminal: &Terminal,
    schedule: &Schedule,
    manual: f64,
) -> Result<System> {
    let mut all = controller.member.values.clone();
    all.extend(values.clone());
    all.extend(terminal.switches.iter().map(|(name, is_on)| (name.clone(), Value::Boolean(*is_on))));
    // Outputs and the connected input are not settings.
    all.retain(|name, _| *name != terminal.name && controller.role(name) != Some(Role::Output));
    let mut events = Vec::new();
    if let Some((switch, value)) = &controller.roles.manual {
        all.insert(switch.clone(), Value::Boolean(true));
        all.insert(value.clone(), Value::Number(manual));
        let automatic = Some(schedule.time(schedule.automatic));
        events.push(Setting { time: automatic, ..setting(switch, Value::Boolean(false)) });
    }
    if controller.is_step_controller() {
        // A step controller must be in automatic mode, with no end stop reported.
        let switches = controller.roles.manual_switch().into_iter().chain(controller.roles.stops());
        all.extend(switches.map(|name| (name.clone(), Value::Boolean(false))));
    }
    let mut settings: Vec<Setting> = all.iter().map(|(name, value)| setting(name, *value)).collect();
    settings.extend(events);
    let wire = |from: String, to: String| Connection { from, to, place: None };
    let output = if terminal.is_word { "WORD" } else { "OUTPUT" };
    let mut connections = vec![wire(format!("{PROCESS}.{output}"), format!("{CONTROLLER}.{}", terminal.name))];
    match &controller.roles.manipulated_value {
        Some(name) => connections.push(wire(format!("{CONTROLLER}.{name}"), format!("{PROCESS}.INPUT"))),
        None if controller.roles.pulses.is_empty() => bail!("the controller has no manipulated value or pulses"),
        None => {
            let pulses = controller.roles.pulses.iter().zip(["UP", "DOWN"]);
            connections
                .extend(pulses.map(|(name, to)| wire(format!("{CONTROLLER}.{name}"), format!("{PROCESS}.{to}"))));
        }
    }
    let member = |name: &str| Member { name: name.into(), path: name.into() };
    Ok(System {
        members: vec![member(CONTROLLER), member(PROCESS)],
        settings,
        connections,
        start: Some(0.0),
        stop: Some(schedule.time(schedule.calls)),
        step: Some(schedule.cycle),
        ..System::default()
    })
}

/// Runs the simulation and returns the recorded rows: setpoint, process value, manipulated value.
fn simulate(plan: &Plan, components: Vec<Box<dyn Component>>) -> Result<Vec<[f64; 3]>> {
    let mut run = Run::begin(plan, components, None)?;
    let mut rows = Vec::with_capacity(plan.steps);
    for _ in 0..plan.steps {
        run.step(plan)?;
        let row = run.row();
        rows.push([row[0], row[1], row[2]]);
    }
    run.terminate(plan)?;
    Ok(rows)
}

/// Returns the prediction to draw, beginning shortly before the step, and remarks on it.
fn shown(rows: &[[f64; 3]], schedule: &Schedule, controller: &Controller, height: f64) -> (Predicted, Told) {
    let begin = schedule.automatic;
    let manipulated_value = averaged(rows, controller.period_in_calls(schedule.cycle)).split_off(begin);
    let rows = &rows[begin..];
    let step = schedule.step - begin;
    let times: Vec<f64> = (0..rows.len()).map(|call| schedule.time(call)).collect();
    let column = |column: usize| rows.iter().map(|row| row[column]).collect::<Vec<f64>>();
    let (setpoint, process_value) = (column(0), column(1));
    let signals = Signals {
        times: &times,
        setpoint: &setpoint,
        process_value: &process_value,
        // No travel is computed for pulses.
        manipulated_value: if controller.roles.pulses.is_empty() { &manipulated_value } else { &[] },
        ..Signals::default()
    };
    let window = Window::measure(signals, &Span::default());
    let told = window.remarks(&[&OVERSHOOT, &SETTLING]);
    let mut remarks: Vec<String> = told.into_iter().map(|remark| format!("Predicted: {remark}.")).collect();
    if controller.roles.pulses.is_empty() {
        remarks.extend(saturation(&manipulated_value[step..], schedule, height));
    }
    let rest = rows.len().saturating_sub(step + ALL_SHOWN);
    let stride = rest.div_ceil(4 * ALL_SHOWN).max(1);
    let is_shown = |call: &usize| *call < step + ALL_SHOWN || (call - step - ALL_SHOWN).is_multiple_of(stride);
    let from = step.saturating_sub(ALL_SHOWN);
    let pick = |values: &[f64]| (from..rows.len()).filter(is_shown).map(|call| values[call]).collect::<Vec<f64>>();
    let mut absent = BTreeMap::new();
    let mut known = |key: &str| match find(key)?.value(&window) {
        Ok(value) => Some(value),
        Err(_) if key == "travel" && !controller.roles.pulses.is_empty() => {
            absent.insert(key.into(), "pulses drive the plant".into());
            None
        }
        Err(why) => {
            absent.insert(key.into(), why);
            None
        }
    };
    let predicted = Predicted {
        times: pick(&times),
        setpoint: pick(&setpoint),
        process_value: pick(&process_value),
        manipulated_value: pick(&manipulated_value),
        overshoot: known("overshoot"),
        settling: known("settling"),
        load: None,
        travel: known("travel"),
    };
    (predicted, Told { remarks, absent })
}

/// Returns the moving average of the manipulated value over the last `length` calls; over fewer at the beginning.
fn averaged(rows: &[[f64; 3]], length: usize) -> Vec<f64> {
    let mean = |end: usize| {
        let part = &rows[(end + 1).saturating_sub(length)..=end];
        part.iter().map(|[_, _, manipulated_value]| manipulated_value).sum::<f64>() / part.len() as f64
    };
    (0..rows.len()).map(mean).collect()
}

/// Returns a remark if the manipulated value stays at its highest or lowest value for several calls after the step: it
/// is then at a limit, and the loop is slower than a linear one.
fn saturation(manipulated: &[f64], schedule: &Schedule, height: f64) -> Option<String> {
    let (low, high) = extremes(manipulated);
    let last = *manipulated.last()?;
    let longest =
        [low, high].into_iter().filter(|limit| (limit - last).abs() > 1e-6 * (high - low)).find_map(|limit| {
            let calls = manipulated.chunk_by(|a, b| a == b).filter(|run| run[0] == limit).map(<[f64]>::len).max()?;
            (calls >= 3).then_some((limit, calls))
        });
    longest.map(|(limit, calls)| {
        format!(
            "Predicted: for a setpoint step of {}, the manipulated value stays at its limit of {} for {} s; a smaller \
             step avoids the limit.",
            short(height),
            short(limit),
            short(schedule.time(calls))
        )
    })
}

/// A single block, called outside a loop.
struct Bench<'a> {
    component: Box<dyn Component>,
    controller: &'a Controller,
    calls: usize,
}

impl<'a> Bench<'a> {
    fn new(home: &dyn Fmus, controller: &'a Controller, settings: &[(&str, f64)]) -> Result<Bench<'a>> {
        let component = home.instantiate(&controller.member.fmu, CONTROLLER)?;
        let mut bench = Bench { component, controller, calls: 0 };
        bench.component.setup(0.0, None)?;
        let mut values: Vec<(&str, f64)> =
            controller.member.values.keys().map(|name| (name.as_str(), controller.value(name))).collect();
        values.retain(|(name, _)| settings.iter().all(|(other, _)| other != name));
        values.extend(settings);
        let is_input = |name: &str| controller.role(name) == Some(Role::Input);
        for (name, value) in values.iter().filter(|(name, _)| !is_input(name)) {
            bench.set(name, *value)?;
        }
        bench.component.enter_initialization()?;
        for (name, value) in values.iter().filter(|(name, _)| is_input(name)) {
            bench.set(name, *value)?;
        }
        bench.component.exit_initialization()?;
        Ok(bench)
    }

    fn place(&self, name: &str) -> Result<(Type, u32)> {
        let row = self.controller.table.find(name).with_context(|| format!("no variable {name}"))?;
        Ok((Type::from_kind(self.controller.table.rows[row].kind), row as u32))
    }

    fn set(&mut self, name: &str, value: f64) -> Result<()> {
        let (kind, reference) = self.place(name)?;
        self.component.write(kind, &[reference], &[value])
    }

    /// Calls the block once and then reads a variable.
    fn call(&mut self, name: &str) -> Result<f64> {
        let cycle = self.controller.cycle();
        self.component.step(self.calls as f64 * cycle, cycle)?;
        self.calls += 1;
        let (kind, reference) = self.place(name)?;
        let mut value = [0.0];
        self.component.read(kind, &[reference], &mut value)?;
        Ok(value[0])
    }
}

/// Measures, in manual mode, the factor that the block applies to its manipulated value between the GAIN and the
/// output; `None` if the block has no manual mode, outputs pulses, or its output does not respond.
///
/// # Errors
/// The FMU reports an error.
pub fn output_factor(home: &dyn Fmus, controller: &Controller) -> Result<Option<f64>> {
    let (Some((switch, manual)), Some(output)) = (&controller.roles.manual, &controller.roles.manipulated_value) else {
        return Ok(None);
    };
    if !controller.roles.pulses.is_empty() {
        return Ok(None);
    }
    let mut bench = Bench::new(home, controller, &[(switch, 1.0), (manual, 0.0)])?;
    let mut outputs = Vec::new();
    for percent in -100..=100_i32 {
        bench.set(manual, f64::from(percent))?;
        outputs.push(bench.call(output)?);
    }
    // At a limit, the output does not change; the change that reaches the limit may be smaller than the others.
    let mut changes: Vec<f64> =
        outputs.windows(2).map(|pair| pair[1] - pair[0]).filter(|change| change.abs() > 1e-9).collect();
    if changes.is_empty() {
        return Ok(None);
    }
    let middle = changes.len() / 2;
    let typical = *changes.select_nth_unstable_by(middle, f64::total_cmp).1;
    let near: Vec<f64> = changes.into_iter().filter(|change| (change / typical - 1.0).abs() < 1e-3).collect();
    let factor = near.iter().sum::<f64>() / near.len() as f64;
    Ok(Some(crate::tune::rounded(factor, 5)).filter(|factor| factor.is_finite() && *factor != 0.0))
}

/// Measures the scaling from an analog input word to the process value. Returns the factor per count and the offset.
fn word_scaling(home: &dyn Fmus, controller: &Controller, terminal: &Terminal) -> Result<(f64, f64)> {
    const COUNTS: f64 = 16384.0;
    let shown =
        controller.roles.shown_process_value.as_ref().context("the controller's computed process value is unknown")?;
    let calls = (controller.sampling() / controller.cycle()).ceil() as usize;
    let at = |word: f64| {
        let switches = terminal.switches.iter().map(|(name, is_on)| (name.as_str(), f64::from(u8::from(*is_on))));
        let settings: Vec<(&str, f64)> = switches.chain([(terminal.name.as_str(), word)]).collect();
        let mut bench = Bench::new(home, controller, &settings)?;
        // A block that runs its controller only in every n-th call updates the process value only in that call.
        (0..calls.max(1)).map(|_| bench.call(shown)).last().context("no call")?
    };
    let (zero, some) = (at(0.0)?, at(COUNTS)?);
    if zero == some {
        bail!("{} does not affect {shown}", terminal.name);
    }
    Ok(((some - zero) / COUNTS, zero))
}
