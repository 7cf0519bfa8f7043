//! FMUs for tests: a controller and a plant that are written here, and a foreign FMU that fails when it is told to.

#![allow(clippy::unwrap_used)]
#![allow(missing_docs)]

mod macos;

use anyhow::{Context, Result, bail};
use blocks::table::number::{number, to_value};
use blocks::{Block, Characteristic, Kind, Law, Real};
pub use macos::macos;
use modeldescription::{Description, Interface, ModelDescription, Table};
use run::component::{Component, Reset, Type};
pub use run::fmus::Fmus;
use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

blocks::block! {
    /// A PI controller.
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// setpoint: SP
    /// process value: PV_IN, PV
    /// manipulated value: OUT
    /// manual: MAN_ON, MAN
    /// controller: GAIN, TI
    /// structure: P_SEL, I_SEL
    /// pulses: UP, DOWN
    /// signal high stop: STOP_HIGH
    ///
    /// [Process value]
    /// SP, PV_IN, STOP_HIGH
    /// [Gain and time]
    /// P_SEL, I_SEL, CYCLE, BITS
    /// GAIN if P_SEL or I_SEL
    /// TI if I_SEL
    /// [Manual and limits]
    /// MAN_ON
    /// MAN if MAN_ON
    /// HIGH if not MAN_ON
    /// ```
    pub struct Pid as "PID" | "FB 7" {
        input {
            /// Setpoint
            sp: Real = 0.0, min -100.0, max 100.0, unit "degC";
            /// Process value
            pv_in: Real = 0.0, unit "degC";
            /// Manual
            man_on: Bool = false;
            /// Manual value
            man: Real = 0.0, unit "%";
            /// The actuator is at its upper stop
            stop_high: Bool = false;
        }
        parameter {
            /// P action on
            p_sel: Bool = true;
            /// I action on
            i_sel: Bool = true;
            /// Gain
            gain: Real = 2.0;
            /// Reset time
            ti: Time = Time::ms(20_000);
            /// Upper limit
            high: Real = 100.0, unit "%";
        }
        fixed {
            /// How many bits there are
            bits: Int = 3;
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(500), min Time::ms(1);
        }
        output {
            /// Manipulated value
            out: Real, unit "%";
            /// Process value that is shown
            pv: Real, unit "degC";
            /// Up
            up: Bool;
            /// Down
            down: Bool;
        }
    }
    memory PidMemory {
        /// The integral.
        i: Real;
    }
}

impl Law for Pid {
    const CHARACTERISTICS: &'static [Characteristic] = &[
        Characteristic {
            title: "The output over the manual value",
            variable: "MAN",
            range: (0.0, 100.0),
            points: 5,
            calls: 2,
            set: &[("MAN_ON", 1.0), ("HIGH", 50.0)],
            show: &["OUT", "UP"],
        },
        Characteristic {
            title: "The same with other settings",
            variable: "MAN",
            range: (0.0, 100.0),
            points: 5,
            calls: 2,
            set: &[("HIGH", 60.0)],
            show: &["OUT", "UP"],
        },
    ];

    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        let e = self.sp - self.pv_in;
        self.pv = self.pv_in;
        if self.i_sel && !self.stop_high {
            self.memory.i += e * (self.cycle.seconds() / self.ti.seconds().max(0.001)) * self.gain;
        }
        let p = if self.p_sel { self.gain * e } else { 0.0 };
        self.out = if self.man_on { self.man } else { p + self.memory.i }.clamp(0.0, self.high.max(0.0));
        self.up = self.out >= 50.0;
        self.down = !self.up;
    }

    fn advice(&self) -> Vec<String> {
        let is_short = self.ti.milliseconds() * 2 < self.cycle.milliseconds();
        let raised =
            || format!("TI = {:?} s is raised to CYCLE/2 = {:?} s.", self.ti.seconds(), self.cycle.seconds() / 2.0);
        is_short.then(raised).into_iter().collect()
    }
}

blocks::block! {
    /// A first-order lag.
    ///
    /// ```dialog
    /// process value: TEMP
    /// manipulated value: POWER
    /// pulses: HEAT, COOL
    /// disturbances: LOAD
    /// signal high stop: AT_TOP
    ///
    /// [Plant]
    /// POWER, LOAD, HEAT, COOL, K, T, CYCLE
    /// ```
    pub struct Lag as "LAG" {
        input {
            /// Power
            power: LReal = 0.0, unit "%";
            /// Load
            load: LReal = 0.0, unit "%";
            /// Heat
            heat: Bool = false;
            /// Cool
            cool: Bool = false;
        }
        parameter {
            /// Gain
            k: LReal = 1.5;
            /// Time constant
            t: Time = Time::ms(10_000);
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Temperature
            temp: LReal, unit "degC";
            /// At the upper stop
            at_top: Bool;
        }
    }
    memory LagMemory {
        /// The state.
        x: f64;
    }
}

impl Law for Lag {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        let pulses = f64::from(u8::from(self.heat)) - f64::from(u8::from(self.cool));
        let input = self.power + self.load + 10.0 * pulses;
        let share = f64::from(self.cycle.milliseconds()) / f64::from(self.t.milliseconds().max(1));
        self.memory.x += (self.k * input - self.memory.x) * share;
        self.temp = self.memory.x;
        self.at_top = self.temp > 120.0;
    }
}

/// Blocks, and a foreign FMU that is a lag.
#[derive(Debug)]
pub struct TestHome {
    /// The foreign FMU fails in the step that begins at this time in seconds.
    pub fails_at: Rc<Cell<f64>>,
    /// The foreign FMU does not get through its initialization.
    pub fails_early: Rc<Cell<bool>>,
}

impl Default for TestHome {
    fn default() -> TestHome {
        TestHome { fails_at: Rc::new(Cell::new(f64::NAN)), fails_early: Rc::default() }
    }
}

pub const FOREIGN: &str = "FOREIGN";

impl Fmus for TestHome {
    fn description(&self, fmu: &str) -> Result<Arc<Description>> {
        let table = match fmu {
            "PID" => Table::from(Pid::TABLE),
            "LAG" | FOREIGN => Table::from(Lag::TABLE),
            _ => bail!("no FMU {fmu:?} here"),
        };
        Ok(Arc::new(ModelDescription::from_interface(&Interface::linked(table, "{0}")?)?.description()))
    }

    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>> {
        match fmu {
            "PID" => Ok(Some(Arc::new(Table::from(Pid::TABLE)))),
            "LAG" => Ok(Some(Arc::new(Table::from(Lag::TABLE)))),
            FOREIGN => Ok(None),
            _ => bail!("no FMU {fmu:?} here"),
        }
    }

    fn instantiate(&self, fmu: &str, _: &str) -> Result<Box<dyn Component>> {
        let lag = |fails_at, fails_early| Linked { block: Lag::default(), next: 0, fails_at, fails_early };
        match fmu {
            "PID" => Ok(Box::new(Linked::<Pid>::reliable())),
            "LAG" => Ok(Box::new(lag(Rc::new(Cell::new(f64::NAN)), Rc::default()))),
            FOREIGN => Ok(Box::new(lag(self.fails_at.clone(), self.fails_early.clone()))),
            _ => bail!("no FMU {fmu:?} here"),
        }
    }
}

/// A block that is linked in.
pub struct Linked<B> {
    block: B,
    /// When the next call is, in milliseconds.
    next: i64,
    fails_at: Rc<Cell<f64>>,
    fails_early: Rc<Cell<bool>>,
}

impl<B: Block> Linked<B> {
    /// A new one that never fails.
    pub fn reliable() -> Linked<B> {
        Linked { block: B::default(), next: 0, fails_at: Rc::new(Cell::new(f64::NAN)), fails_early: Rc::default() }
    }
}

fn milliseconds(seconds: f64) -> i64 {
    (seconds * 1000.0).round() as i64
}

impl<B: Block> Component for Linked<B> {
    fn setup(&mut self, start: f64, _: Option<f64>) -> Result<()> {
        self.next = milliseconds(start);
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.block.restart();
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        if self.fails_early.get() {
            bail!("the initialization returned an error: not today");
        }
        self.block.restart();
        Ok(())
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        for (value, reference) in values.iter_mut().zip(references) {
            let own = self.block.get(*reference as usize).context("no such variable")?;
            let is_of = match own.kind() {
                Kind::Bool => Type::Boolean,
                Kind::Int | Kind::Word => Type::Integer,
                _ => Type::Real,
            };
            assert_eq!(is_of, kind);
            *value = number(own);
        }
        Ok(())
    }

    fn write(&mut self, _: Type, references: &[u32], values: &[f64]) -> Result<()> {
        for (value, reference) in values.iter().zip(references) {
            let row = *reference as usize;
            let kind = B::TABLE.rows[row].kind;
            let own = to_value(*value, kind).map_err(|range| anyhow::anyhow!("it cannot be set: {range}"))?;
            assert!(self.block.set(row, own));
        }
        Ok(())
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        if time == self.fails_at.get() {
            bail!("the step returned an error: it is enough");
        }
        let end = milliseconds(time + size);
        assert!(self.next >= milliseconds(time), "no call is left out");
        while self.next < end {
            self.block.call();
            self.next += i64::from(self.block.cycle().milliseconds());
        }
        Ok(())
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

impl<B: Block> Reset for Linked<B> {
    fn reset(&mut self) -> Result<()> {
        self.block = B::default();
        Ok(())
    }
}
