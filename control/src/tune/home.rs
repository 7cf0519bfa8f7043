//! A home with controllers that are written here: a PID with all that belongs to it, one with pulses, one with steps.

use anyhow::Result;
use blocks::{Block, Int, Law, Real};
use modeldescription::{Description, Interface, ModelDescription, Table};
use run::component::Component;
use run::fmus::Fmus;
use run::test_home::{FOREIGN, Lag, Linked, TestHome};
use std::sync::Arc;

blocks::block! {
    /// A PID controller in 32-bit arithmetic, with limits, manual mode and an analog input.
    ///
    /// ```dialog
    /// setpoint: SP
    /// process value: PV_IN, PV
    /// manipulated value: LMN
    /// manual: MAN_ON, MAN
    /// controller: GAIN, TI, TD, TM_LAG
    /// structure: P_SEL, I_SEL, D_SEL
    /// signal process value peripheral: PV_PER
    ///
    /// [Process value]
    /// SP, WORD_ON
    /// PV_IN if not WORD_ON
    /// PV_PER, PV_FAC if WORD_ON
    /// [Control]
    /// P_SEL, I_SEL, D_SEL, GAIN, TI, TD, TM_LAG, DISV, CYCLE
    /// [Output]
    /// MAN_ON, MAN, HIGH, LOW, LMN_FAC
    /// ```
    pub struct Pid as "PID" {
        input {
            /// Setpoint
            sp: Real = 0.0;
            /// Process value
            pv_in: Real = 0.0;
            /// Process value as a word
            pv_per: Word = blocks::Word::new(0);
            /// Manual
            man_on: Bool = true;
            /// Manual value
            man: Real = 0.0;
            /// Disturbance
            disv: Real = 0.0;
        }
        parameter {
            /// The word is taken
            word_on: Bool = false;
            /// Factor of the word
            pv_fac: Real = 1.0;
            /// P action
            p_sel: Bool = true;
            /// I action
            i_sel: Bool = true;
            /// D action
            d_sel: Bool = false;
            /// Gain
            gain: Real = 2.0;
            /// Reset time
            ti: Time = Time::ms(20_000);
            /// Derivative time
            td: Time = Time::ms(10_000);
            /// Its lag
            tm_lag: Time = Time::ms(2_000);
            /// Upper limit
            high: Real = 100.0;
            /// Lower limit
            low: Real = 0.0;
            /// Factor at the end
            lmn_fac: Real = 1.0;
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Manipulated value
            lmn: Real;
            /// Process value in use
            pv: Real;
        }
    }
    memory PidMemory {
        /// The error of the previous call.
        e: Real;
        /// The integral.
        i: Real;
        /// Its round-off error.
        rest: Real;
        /// Behind the lag.
        w: Real;
        /// The limited value.
        y: Real;
    }
}

impl Law for Pid {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        self.pv = if self.word_on {
            Real::from(self.pv_per.value() as Int) * 0.003_616_898 * self.pv_fac
        } else {
            self.pv_in
        };
        let e = (self.sp - self.pv) * self.gain;
        let t = self.cycle.seconds();
        let p = if self.p_sel { e } else { 0.0 };
        if !self.i_sel {
            self.memory.i = 0.0;
        } else if self.man_on {
            self.memory.i = self.memory.y - p - self.disv;
        } else {
            let mut q = t / self.ti.seconds().max(t * 0.5) * (e + self.memory.e) * 0.5 + self.memory.rest;
            if q > 0.0 && self.memory.y >= self.high || q < 0.0 && self.memory.y <= self.low {
                q = 0.0;
            }
            let i = self.memory.i + q;
            self.memory.rest = (self.memory.i - i) + q;
            self.memory.i = i;
        }
        let d = if self.d_sel && !self.man_on {
            let td = self.td.seconds().max(t);
            let d = (e - self.memory.w) * td / (t * 0.5 + self.tm_lag.seconds().max(t * 0.5));
            self.memory.w += t / td * d;
            d
        } else {
            self.memory.w = e;
            0.0
        };
        let u = if self.man_on { self.man } else { p + self.memory.i + d + self.disv };
        self.memory.y = u.min(self.high).max(self.low);
        self.memory.e = e;
        self.lmn = self.memory.y * self.lmn_fac;
    }
}

blocks::block! {
    /// A PI controller that is called in each n-th call, and pulses in all of them.
    ///
    /// ```dialog
    /// setpoint: SP
    /// process value: PV_IN
    /// manipulated value: MEAN
    /// manual: MAN_ON, MAN
    /// controller: GAIN, TI
    /// structure: P_SEL, I_SEL
    /// pulses: PULSE
    /// pulse former: N
    ///
    /// [All]
    /// SP, PV_IN, MAN_ON, MAN, GAIN, TI, P_SEL, I_SEL, N, CYCLE
    /// ```
    pub struct Pulser as "PULSER" {
        input {
            /// Setpoint
            sp: Real = 0.0;
            /// Process value
            pv_in: Real = 0.0;
            /// Manual
            man_on: Bool = true;
            /// Manual value
            man: Real = 0.0;
        }
        parameter {
            /// P action
            p_sel: Bool = true;
            /// I action
            i_sel: Bool = true;
            /// Gain
            gain: Real = 2.0;
            /// Reset time
            ti: Time = Time::ms(20_000);
            /// Calls of a period
            n: Int = 20, min 1;
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// The pulse
            pulse: Bool;
            /// Its mean
            mean: Real;
        }
    }
    memory PulserMemory {
        /// The call of the period.
        call: Int;
        /// The integral.
        i: Real;
        /// The pulse's length in percent.
        length: Real;
    }
}

impl Law for Pulser {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        if self.memory.call == 0 {
            let e = (self.sp - self.pv_in) * self.gain;
            let p = if self.p_sel { e } else { 0.0 };
            if self.man_on {
                self.memory.i = self.memory.length - p;
            } else if self.i_sel {
                self.memory.i += e * Real::from(self.n) * self.cycle.seconds() / self.ti.seconds();
            } else {
                self.memory.i = 0.0;
            }
            self.memory.length = if self.man_on { self.man } else { p + self.memory.i }.clamp(0.0, 100.0);
        }
        self.pulse = Real::from(self.memory.call) < self.memory.length / 100.0 * Real::from(self.n);
        self.mean = if self.pulse { 100.0 } else { 0.0 };
        self.memory.call = (self.memory.call + 1) % self.n.max(1);
    }
}

blocks::block! {
    /// A step controller: PI by pulses up and down.
    ///
    /// ```dialog
    /// setpoint: SP
    /// process value: PV_IN
    /// controller: GAIN, TI
    /// pulses: UP, DOWN
    /// signal high stop: AT_TOP
    ///
    /// [Control]
    /// SP, PV_IN, GAIN, TI, CYCLE
    /// [Actuator]
    /// AT_TOP, MOTOR_TM
    /// ```
    pub struct Stepper as "STEPPER" {
        input {
            /// Setpoint
            sp: Real = 0.0;
            /// Process value
            pv_in: Real = 0.0;
            /// The valve is at its upper stop
            at_top: Bool = false;
        }
        parameter {
            /// Gain
            gain: Real = 2.0;
            /// Reset time
            ti: Time = Time::ms(20_000);
            /// From stop to stop
            motor_tm: Time = Time::ms(20_000);
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Up
            up: Bool;
            /// Down
            down: Bool;
        }
    }
    memory StepperMemory {
        /// The error of the previous call.
        e: Real;
        /// How far the valve has to go, in percent.
        open: Real;
    }
}

impl Law for Stepper {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        let e = (self.sp - self.pv_in) * self.gain;
        let t = self.cycle.seconds();
        self.memory.open += e - self.memory.e + e * t / self.ti.seconds();
        self.memory.e = e;
        let travel = 100.0 * t / self.motor_tm.seconds();
        self.up = self.memory.open >= travel && !self.at_top;
        self.down = self.memory.open <= -travel;
        self.memory.open -= travel * Real::from(u8::from(self.up)) - travel * Real::from(u8::from(self.down));
    }
}

/// The controllers above, and a plant and a foreign FMU that are not.
#[derive(Debug, Default)]
pub struct Controllers;

fn described<B: Block>() -> Result<Arc<Description>> {
    let interface = Interface::linked(Table::from(B::TABLE), "{0}")?;
    Ok(Arc::new(ModelDescription::of(&interface)?.description()))
}

impl Fmus for Controllers {
    fn description(&self, fmu: &str) -> Result<Arc<Description>> {
        match fmu {
            "PID" => described::<Pid>(),
            "PULSER" => described::<Pulser>(),
            "STEPPER" => described::<Stepper>(),
            other => TestHome::default().description(other),
        }
    }

    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>> {
        Ok(Some(Arc::new(match fmu {
            "PID" => Table::from(Pid::TABLE),
            "PULSER" => Table::from(Pulser::TABLE),
            "STEPPER" => Table::from(Stepper::TABLE),
            "LAG" => Table::from(Lag::TABLE),
            FOREIGN => return Ok(None),
            other => return TestHome::default().table(other),
        })))
    }

    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>> {
        match fmu {
            "PID" => Ok(Box::new(Linked::<Pid>::reliable())),
            "PULSER" => Ok(Box::new(Linked::<Pulser>::reliable())),
            "STEPPER" => Ok(Box::new(Linked::<Stepper>::reliable())),
            other => TestHome::default().instantiate(other, name),
        }
    }
}
