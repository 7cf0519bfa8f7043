//! VALVE: a motor-driven valve and the heat exchanger it feeds, a plant for CONT_S.

use crate::dynamics::{Kept, Lags, analog, exp, exp_m1, limited, ln, seconds};
use blocks::{Characteristic, Law, Response};

blocks::block! {
    /// Motor-driven valve with limit switches and the heat exchanger it feeds: pulses in, temperature out.
    ///
    /// # Purpose
    ///
    /// A valve with a motor, limit switches, backlash and a fault, and the heat exchanger that it feeds: the plant for
    /// CONT_S. With a positioner it suits a continuous controller. It shows the behaviour of a step controller without
    /// position feedback.
    ///
    /// # Quick start
    ///
    /// 1. Connect QLMN_MEAN of CONT_S to DRIVE, or QLMNUP and QLMNDN to UP and DOWN with a communication step of the
    ///    controller's CYCLE; TEMP to PV_IN; LMNR_HS and LMNR_LS to the inputs of the same names.
    /// 2. MTR_TM: the same in both blocks.
    /// 3. Set PRES or T_IN during the run for a disturbance, BACKLASH and STUCK for a faulty valve.
    ///
    /// For CONT_S: with degC for setpoint and process value, CYCLE 100 ms, PULSE_TM and BREAK_TM 300 ms (a pulse of 300
    /// ms moves the valve by 1 %, which is 0.8 K) the defaults of CONT_S, GAIN 2, TI 20 s, DEADB_W 1 and MTR_TM 30 s,
    /// bring the temperature from 20 to 60 degC in 90 s with about ten pulses, and correct a pressure drop to 3 bar in
    /// 70 s with about five.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon curve
    /// input UP 0,5
    /// input DOWN 0,9
    /// input DRIVE 0,13
    /// box MOTOR 18,9 in UP DOWN DRIVE out TRAVEL with MTR_TM POS_ON
    /// box STEM 33,7 "0 ... 100 %" with BACKLASH POS_START STUCK
    /// output LMNR_HS 35,-4
    /// output LMNR_LS 35,17
    /// output LMNR 43,0
    /// box CURVE 50,7 curve with CURVE
    /// box ROOT 65,7 "x sqrt(PRES /" "PRES_NOM)" with PRES_NOM
    /// input PRES 53,17
    /// box SCALE 83,7 multiply with FLOW_MAX
    /// output FLOW 92,7
    /// text 74.5,6.2 "F"
    /// UP > x9 > MOTOR.UP
    /// DOWN > MOTOR.DOWN
    /// DRIVE > x9 > MOTOR.DRIVE
    /// MOTOR.TRAVEL > STEM > CURVE > ROOT
    /// STEM.top > y-4 > LMNR_HS
    /// STEM.bottom > y17 > LMNR_LS
    /// 41,7 > y0 > LMNR
    /// PRES > ROOT.bottom
    ///
    /// // the heat exchanger
    /// ROOT > x74 > y22 > x4 > y28 > RISE
    /// 74,7 > SCALE > FLOW
    /// box RISE 12,28 multiply with RISE
    /// input T_IN 10,36
    /// sum TARGET 21,28 left + bottom +
    /// box EXCHANGER 32,28 lag with HX_TM T_START
    /// box SENSOR 50,28 lag with SENS_TM
    /// box ANALOG 68,28 "0 ... 27648" with T_PER_0 T_PER_100
    /// output T_HX 42,35
    /// output TEMP 60,36
    /// output T_PER 78,28
    /// box CALL 32,39 "every CYCLE" with CYCLE
    /// RISE > TARGET > EXCHANGER > SENSOR > ANALOG > T_PER
    /// T_IN > TARGET.bottom
    /// 40,28 > y35 > T_HX
    /// 58,28 > y36 > TEMP
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: TEMP
    /// manipulated value: DRIVE
    /// pulses: UP, DOWN
    /// disturbances: PRES, T_IN
    /// signal process value peripheral: T_PER
    /// signal high stop: LMNR_HS
    /// signal low stop: LMNR_LS
    ///
    /// [Manipulated value]
    /// POS_ON
    /// UP, DOWN if not POS_ON
    /// DRIVE
    /// [Disturbance]
    /// PRES, T_IN
    /// [Valve]
    /// MTR_TM, BACKLASH, STUCK, CURVE, FLOW_MAX, PRES_NOM
    /// [Heat exchanger]
    /// RISE, HX_TM, SENS_TM
    /// [Start]
    /// POS_START, T_START
    /// [Peripheral process value]
    /// T_PER_0, T_PER_100
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// ```math
    /// \begin{aligned}
    /// F &= f(x)\,\sqrt{\dfrac{\text{PRES}}{\text{PRES_NOM}}} \\
    /// f(x) &= \begin{cases} \dfrac{\text{CURVE}^x - 1}{\text{CURVE} - 1} & \text{CURVE} \ne 1 \\ x & \text{CURVE} = 1 \end{cases}
    /// \end{aligned}
    /// ```
    ///
    /// ```math
    /// \begin{aligned}
    /// \text{FLOW} &= \text{FLOW_MAX}\,F \\
    /// \text{HX_TM}\,\dfrac{d\,\text{T_HX}}{dt} &= \text{T_IN} + \text{RISE}\,F - \text{T_HX}
    /// \end{aligned}
    /// ```
    ///
    /// The equations:
    ///
    /// ```text
    /// v    = (UP ? 100 % : 0) - (DOWN ? 100 % : 0) + DRIVE      within -100 ... 100 %
    /// motor: travels v / MTR_TM, BACKLASH of it idle after each reversal; the stem stops at 0 and at 100 %
    /// x    = LMNR / 100 %
    /// f(x) = (CURVE^x - 1) / (CURVE - 1)                        f(x) = x for CURVE = 1
    /// F    = f(x) sqrt(PRES / PRES_NOM)
    /// FLOW = FLOW_MAX F
    /// HX_TM   dT_HX/dt = T_IN + RISE F - T_HX
    /// SENS_TM dTEMP/dt = T_HX - TEMP
    /// T_PER = 27648 (TEMP - T_PER_0) / (T_PER_100 - T_PER_0), rounded, within 0 ... 27648
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k covers the time from k to k + 1 times CYCLE, with the inputs held; after the call, the outputs are
    ///    those at the end of that time. So use a communication step of CYCLE or a multiple of it; with shorter steps
    ///    the outputs run ahead by part of a CYCLE.
    /// 2. Start: the stem is at POS_START and last moved in the closing direction, so opening first takes up the whole
    ///    backlash; exchanger and sensor are at T_START. FLOW is 0 until the first call: it depends on the pressure, an
    ///    input.
    /// 3. UP and DOWN run the motor while they are TRUE, one stroke in MTR_TM; both together cancel out. DRIVE is the
    ///    speed in percent, such as QLMN_MEAN of CONT_S, and adds to them: connect one or the other. With a DRIVE of 30
    ///    % the valve travels as far as with pulses that are on for 30 % of the time.
    /// 4. The motor is simulated exactly within a CYCLE: it stops when it reaches the stop, and moves at part speed if
    ///    DRIVE demands it.
    /// 5. LMNR_HS and LMNR_LS are TRUE while the stem is at 100 % and at 0 % respectively, for the inputs of CONT_S
    ///    with the same names. The motor does not keep running against the stop.
    /// 6. Backlash: after a reversal the motor runs BACKLASH percent of the stroke before the stem follows.
    /// 7. STUCK: nothing moves, whatever the demand; no limit switch indicates it.
    /// 8. POS_ON adds a positioner, for a continuous controller: DRIVE is the demanded position, 0 ... 100 %, to which
    ///    the stem moves at full speed, with compensated backlash; UP and DOWN have no effect.
    /// 9. FLOW is the flow of the heating medium. Its pressure PRES is one disturbance, T_IN, the inlet temperature of
    ///    the heated medium, another. Steady state: TEMP = T_IN + RISE F.
    /// 10. CURVE = 1 is a linear characteristic, 30 to 50 an equal percentage one with tight shut-off, below 1 a
    ///     quick-opening one.
    /// 11. T_PER is TEMP as an analog input word, for PV_PER, without overrange: it saturates at the ends of its range.
    ///
    /// # Limits of use
    ///
    /// Solved in closed form for held inputs; while the stem moves, the exchanger is solved by a quadrature accurate to
    /// a few parts in 10^12 if HX_TM and SENS_TM are 0 or at least a hundredth of CYCLE (otherwise, to a percent of the
    /// target's movement in a hundredth of CYCLE). The result depends on CYCLE only through this error. The results are
    /// the same to the last bit on every platform.
    ///
    /// The temperature rise is proportional to the flow, as with condensing steam; the flow of the heated medium is
    /// constant.
    ///
    /// Bad input: HX_TM or SENS_TM not above 0 means no lag; with MTR_TM not above 0 the valve moves at once; CURVE not
    /// above 0 counts as 1; PRES or BACKLASH below 0 counts as 0; with PRES_NOM not above 0 the pressure has no
    /// influence.
    pub struct Valve as "VALVE" {
        input {
            /// Opens the valve
            ///
            /// Connect QLMNUP of CONT_S. While it is TRUE the motor runs up: with MTR_TM = 30 s, one second opens the
            /// valve by 3.3 %. It is sampled at the start of a communication step, so use a step of the controller's
            /// CYCLE, or DRIVE.
            up: Bool = false;
            /// Closes the valve
            ///
            /// Connect QLMNDN of CONT_S. If UP is also TRUE, the motor stands still.
            down: Bool = false;
            /// Speed of the motor, positive opens; with POS_ON the demanded position
            ///
            /// Connect QLMN_MEAN of CONT_S: 30 in a step moves the valve as far as pulses that are on for 30 % of the
            /// step. With POS_ON = TRUE it is the demanded position, 0 ... 100 %: connect LMN of CONT_C.
            drive: LReal = 0.0, min -100.0, max 100.0, unit "%";
            /// Disturbance: pressure of the heating medium
            ///
            /// The usual disturbance of a valve loop. The flow is proportional to the square root of PRES / PRES_NOM: a
            /// drop from 4 to 1 bar halves it.
            pres: LReal = 4.0, min 0.0, unit "bar";
            /// Disturbance: inlet temperature of the heated medium
            ///
            /// TEMP is T_IN plus the rise caused by the flow. A step in T_IN reaches TEMP through HX_TM and SENS_TM.
            t_in: LReal = 20.0, min -273.15, unit "degC";
        }
        parameter {
            /// The valve has a positioner: DRIVE is the demanded position
            ///
            /// FALSE: only a motor, for CONT_S. TRUE: a positioner, for a continuous controller, which moves the stem
            /// to DRIVE at full speed and compensates for backlash.
            pos_on: Bool = false;
            /// Fault: the valve is stuck
            ///
            /// Set it during a run to see how the controller copes with a valve that does not move: no limit switch
            /// indicates it, and a step controller keeps pulsing.
            stuck: Bool = false;
            /// Motor actuating time: how long the valve takes from stop to stop
            ///
            /// Set MTR_TM of CONT_S to the same value, or to a different one to see the effect of a wrong data sheet.
            /// With 0 the valve moves at once.
            mtr_tm: LReal = 30.0, min 0.0, unit "s";
            /// Idle travel of the motor after a reversal
            ///
            /// The part of the stroke that the motor runs after a reversal before the stem follows: 5 with MTR_TM = 30
            /// s is 1.5 s without effect. A dead band in the controller prevents hunting.
            backlash: LReal = 0.0, min 0.0, max 100.0, unit "%";
            /// Position at the start
            ///
            /// The position of the stem before the first call. At 0 LMNR_LS is TRUE, at 100 LMNR_HS. The last movement
            /// was closing, so opening first takes up the whole backlash.
            pos_start: LReal = 0.0, min 0.0, max 100.0, unit "%";
            /// Temperature of heat exchanger and sensor at the start
            ///
            /// Temperature before the first call, of the heat exchanger and of its sensor.
            t_start: LReal = 20.0, min -273.15, unit "degC";
            /// Characteristic of the valve: the ratio of its slopes when open and when closed; 1: linear
            ///
            /// 1 is linear: half open is half of the flow. 30 ... 50 is equal percentage with tight shut-off: with 30,
            /// half open is 15 % of the flow, so the loop gain depends on the position. Below 1 is quick-opening.
            curve: LReal = 1.0, min 0.0;
            /// Flow of the heating medium with the valve open, at the pressure PRES_NOM
            ///
            /// Scales FLOW only; the temperature follows from RISE.
            flow_max: LReal = 40.0, unit "l/min";
            /// Pressure to which FLOW_MAX and RISE refer
            ///
            /// At PRES = PRES_NOM the open valve gives FLOW_MAX and RISE.
            pres_nom: LReal = 4.0, min 0.0, unit "bar";
            /// Temperature rise with the valve open, at the pressure PRES_NOM
            ///
            /// The gain of the plant: RISE / 100, 0.8 K per percent of position with the start values and a linear
            /// characteristic.
            rise: LReal = 80.0, unit "K";
            /// Time constant of the heat exchanger; 0: none
            ///
            /// The dominant time constant for a tuning rule: a good first value for TI of CONT_S, 20 s.
            hx_tm: LReal = 20.0, min 0.0, unit "s";
            /// Time constant of the sensor; 0: none
            ///
            /// TEMP follows T_HX with this lag. It adds to the dead time that the controller sees.
            sens_tm: LReal = 5.0, min 0.0, unit "s";
            /// Temperature at which T_PER is 0
            ///
            /// One end of the analog input's range: at this temperature and below, T_PER is 0. Set PV_OFF of the
            /// controller to the same value.
            t_per_0: LReal = 0.0, unit "degC";
            /// Temperature at which T_PER is 27648
            ///
            /// The other end of the range: at this temperature and above, T_PER is 27648. Set PV_FAC of the controller
            /// to a hundredth of the span, 1 with the start values.
            t_per_100: LReal = 100.0, unit "degC";
        }
        cycle {
            /// Time by which a call advances the valve and the heat exchanger
            ///
            /// The plant is solved exactly between two calls, so this time affects the result only through rounding.
            /// Set it to the controller's CYCLE or a fraction of it, and use a communication step of this time or a
            /// multiple of it.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Position of the valve: 100 % is open
            ///
            /// The reading of a position transmitter. CONT_S does not need it; compare it with the travel that CONT_S
            /// assumes.
            lmnr: LReal, from pos_start, unit "%";
            /// High limit switch: the valve is at its upper stop
            ///
            /// Connect it to LMNR_HS of CONT_S, which then outputs no pulse up.
            lmnr_hs: Bool, from pos_start;
            /// Low limit switch: the valve is at its lower stop
            ///
            /// Connect it to LMNR_LS of CONT_S, which then outputs no pulse down. With the start values it is TRUE: the
            /// valve is closed.
            lmnr_ls: Bool, from pos_start;
            /// Flow of the heating medium
            ///
            /// FLOW_MAX times the characteristic times the square root of PRES / PRES_NOM; 0 until the first call,
            /// because it depends on an input.
            flow: LReal, unit "l/min";
            /// Temperature measured by the sensor, for PV_IN
            ///
            /// Connect it to PV_IN of the controller for a process value in degC.
            temp: LReal, from t_start, unit "degC";
            /// Temperature measured by the sensor as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE; PV_FAC = 1 and PV_OFF = 0 convert it to
            /// degC.
            t_per: Word, from t_start t_per_0 t_per_100;
            /// Temperature at the outlet of the heat exchanger itself
            ///
            /// The true temperature, without the sensor lag; the controller does not see it.
            t_hx: LReal, from t_start, unit "degC";
        }
    }
    memory Memory {
        /// How far the motor has run into the backlash from its closing end, in percent of the stroke.
        slack: f64;
        /// The valve's characteristic.
        passage: Kept<3, Passage>;
        /// The fraction of FLOW_MAX that flows at the current stem position and pressure.
        share: Kept<4, f64>;
        /// The lags of exchanger and sensor while the stem stands still, before and after it moves.
        lags_at_rest: [Lags; 2];
        /// The lags of exchanger and sensor while the stem moves: over a part of the travel, and from each Gaussian
        /// node to the end of the part.
        lags_moving: [Lags; 6];
    }
}

/// The steady-state flow as a function of the position, in steps of 1 %.
const FLOW_OVER_POSITION: Characteristic = Characteristic {
    title: "",
    variable: "POS_START",
    range: (0.0, 100.0),
    points: 101,
    calls: 1,
    set: &[],
    show: &["FLOW"],
};

impl Law for Valve {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[
        Response {
            title: "An opening pulse of 18 s and a closing pulse of 9 s, both with 10 % backlash; then the pressure drops",
            calls: 400,
            set: &[
                (0, "CYCLE", 1.0),
                (0, "BACKLASH", 10.0),
                (10, "UP", 1.0),
                (28, "UP", 0.0),
                (150, "DOWN", 1.0),
                (159, "DOWN", 0.0),
                (280, "PRES", 2.0),
            ],
            show: &["LMNR", "FLOW", "TEMP"],
        },
        Response {
            title: "Full stroke in MTR_TM = 30 s, equal percentage characteristic: half open is 15 % of the flow",
            calls: 60,
            set: &[(0, "CYCLE", 1.0), (0, "CURVE", 30.0), (10, "UP", 1.0)],
            show: &["UP", "LMNR", "LMNR_HS", "FLOW"],
        },
    ];

    const CHARACTERISTICS: &'static [Characteristic] = &[
        Characteristic { title: "Linear characteristic, CURVE = 1", set: &[], ..FLOW_OVER_POSITION },
        Characteristic {
            title: "Equal percentage characteristic, CURVE = 30: half open is 15 % of the flow",
            set: &[("CURVE", 30.0)],
            ..FLOW_OVER_POSITION
        },
    ];

    fn restart(&mut self) {
        self.clear();
        self.lmnr = limited(self.pos_start, 0.0, 100.0);
        self.show([self.t_start; 2]);
    }

    fn call(&mut self) {
        let Run { idle, moving, to } = self.run_motor();
        let mut temperatures = self.exchange_at_rest([self.t_hx, self.temp], idle, 0);
        temperatures = self.exchange_while_moving(temperatures, to, moving);
        self.lmnr = to;
        temperatures = self.exchange_at_rest(temperatures, seconds(self.cycle) - idle - moving, 1);
        self.flow = self.flow_max * self.flow_share();
        self.show(temperatures);
    }
}

/// The movement of the motor in a cycle: the stem stays still for `idle` seconds, moves `to` its new position in
/// `moving` seconds, and stays still for the rest.
struct Run {
    idle: f64,
    moving: f64,
    to: f64,
}

/// The flow characteristic of the valve at the current pressure.
#[derive(Clone, Copy, Debug, Default)]
struct Passage {
    /// The natural logarithm of CURVE.
    steepness: f64,
    /// The value of the characteristic when fully open, before it is scaled to 1.
    full: f64,
    pressure_factor: f64,
}

impl Passage {
    fn new(curve: f64, pres: f64, pres_nom: f64) -> Passage {
        let steepness = if curve > 0.0 { ln(curve) } else { 0.0 };
        let pressure_factor = if pres_nom > 0.0 { (pres.max(0.0) / pres_nom).sqrt() } else { 1.0 };
        Passage { steepness, full: exp_m1(steepness), pressure_factor }
    }

    /// Returns the fraction of FLOW_MAX at a position in percent.
    fn share(self, position: f64) -> f64 {
        let x = position / 100.0;
        let characteristic = if self.steepness == 0.0 { x } else { exp_m1(self.steepness * x) / self.full };
        characteristic * self.pressure_factor
    }

    /// Returns the slope of that fraction, per percent of travel.
    fn slope(self, position: f64) -> f64 {
        let x = position / 100.0;
        let slope = if self.steepness == 0.0 { 1.0 } else { self.steepness * exp(self.steepness * x) / self.full };
        slope * self.pressure_factor / 100.0
    }
}

impl Valve {
    /// Runs the motor for a cycle, including the backlash.
    fn run_motor(&mut self) -> Run {
        /// The maximum rounding error between the stem and its stop, in percent of the stroke.
        const ROUNDING: f64 = 1e-9;

        let from = self.lmnr;
        let (speed, stop) = if self.pos_on {
            let demand = limited(self.drive, 0.0, 100.0);
            (if demand < from { -100.0 } else { 100.0 }, demand)
        } else {
            let pulses = if self.up { 100.0 } else { 0.0 } - if self.down { 100.0 } else { 0.0 };
            let speed = limited(pulses + limited(self.drive, -100.0, 100.0), -100.0, 100.0);
            (speed, if speed < 0.0 { 0.0 } else { 100.0 })
        };
        let cycle = seconds(self.cycle);
        if self.stuck || speed == 0.0 || stop == from {
            return Run { idle: cycle, moving: 0.0, to: from };
        }

        let backlash = self.backlash.max(0.0);
        let slack = limited(self.memory.slack, 0.0, backlash);
        let seconds_per_percent = self.mtr_tm.max(0.0) / speed.abs();
        let reach = cycle / seconds_per_percent;
        let idle = reach.min(if speed > 0.0 { backlash - slack } else { slack });
        let travel = (reach - idle).min((stop - from).abs());
        self.memory.slack = if speed > 0.0 { slack + idle } else { slack - idle };
        let mut to = if speed > 0.0 { from + travel } else { from - travel };
        if (to - stop).abs() < ROUNDING {
            to = stop;
        }
        Run { idle: idle * seconds_per_percent, moving: travel * seconds_per_percent, to }
    }

    fn passage(&mut self) -> Passage {
        let settings = [self.curve, self.pres, self.pres_nom];
        self.memory.passage.get_or_compute(settings, |[curve, pres, pres_nom]| Passage::new(curve, pres, pres_nom))
    }

    /// Returns the fraction of FLOW_MAX at the current stem position and pressure.
    fn flow_share(&mut self) -> f64 {
        let settings = [self.lmnr, self.curve, self.pres, self.pres_nom];
        self.memory.share.get_or_compute(settings, |[position, curve, pres, pres_nom]| {
            Passage::new(curve, pres, pres_nom).share(position)
        })
    }

    /// Returns the temperatures of exchanger and sensor after the stem has stayed still for `duration`, before (0) or
    /// after (1) it moves.
    fn exchange_at_rest(&mut self, temperatures: [f64; 2], duration: f64, part: usize) -> [f64; 2] {
        let target = self.t_in + self.rise * self.flow_share();
        self.memory.lags_at_rest[part].step(temperatures, target, [self.hx_tm, self.sens_tm], duration)
    }

    /// Returns the temperatures of exchanger and sensor after the stem has moved `to` a position in `duration`.
    ///
    /// The movement is treated as a sequence of small flow steps. Exchanger and sensor respond to each of them as two
    /// lags, and the responses add up to an integral over the time of the step. It is evaluated by five-point Gaussian
    /// quadrature over parts that are short compared to the lags and over which the characteristic is nearly straight.
    fn exchange_while_moving(&mut self, mut temperatures: [f64; 2], to: f64, duration: f64) -> [f64; 2] {
        const PLACES_AND_WEIGHTS: [(f64, f64); 5] = [
            (0.046_910_077_030_668, 0.118_463_442_528_094_54),
            (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
            (0.5, 0.284_444_444_444_444_44),
            (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
            (0.953_089_922_969_332, 0.118_463_442_528_094_54),
        ];
        if duration <= 0.0 {
            return temperatures;
        }
        let lag_times = [self.hx_tm, self.sens_tm];
        let shortest_lag = lag_times.into_iter().filter(|&time| time > 0.0).fold(duration, f64::min);
        let parts = limited((duration / shortest_lag).max((to - self.lmnr).abs() / 10.0).ceil(), 1.0, 100.0);
        let stroke = (to - self.lmnr) / parts;
        let part_duration = duration / parts;
        let passage = self.passage();
        let [whole_part, rests @ ..] = &mut self.memory.lags_moving;
        for part in 0..parts as u32 {
            let from = self.lmnr + f64::from(part) * stroke;
            let target = self.t_in + self.rise * passage.share(from);
            temperatures = whole_part.step(temperatures, target, lag_times, part_duration);
            for ((place, weight), rest) in PLACES_AND_WEIGHTS.into_iter().zip(&mut *rests) {
                let step = weight * stroke * self.rise * passage.slope(from + place * stroke);
                let answer = rest.step([0.0, 0.0], step, lag_times, (1.0 - place) * part_duration);
                temperatures = [temperatures[0] + answer[0], temperatures[1] + answer[1]];
            }
        }
        temperatures
    }

    fn show(&mut self, [t_hx, temp]: [f64; 2]) {
        self.lmnr_hs = self.lmnr >= 100.0;
        self.lmnr_ls = self.lmnr <= 0.0;
        self.t_hx = t_hx;
        self.temp = temp;
        self.t_per = analog(temp, self.t_per_0, self.t_per_100);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Block, ContS, Stored, Time};

    fn started(valve: Valve) -> Valve {
        let mut valve = valve;
        valve.restart();
        valve
    }

    fn run(valve: &mut Valve, seconds: f64) {
        let calls = (seconds / crate::dynamics::seconds(valve.cycle)).round() as u32;
        (0..calls).for_each(|_| valve.call());
    }

    #[track_caller]
    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    #[test]
    fn it_starts_at_its_start_position_and_temperature_whatever_the_inputs_are() {
        let valve =
            Valve { pos_start: 40.0, t_start: 52.0, up: true, drive: 9.0, t_in: 7.0, pres: 1.0, ..Valve::default() };
        let valve = started(valve);
        assert_eq!((valve.lmnr, valve.temp, valve.t_hx, valve.flow), (40.0, 52.0, 52.0, 0.0));
        assert_eq!(valve.t_per.value(), 14377, "27648 * 0.52 = 14376.96");
        assert!(!valve.lmnr_hs && !valve.lmnr_ls);
        assert!(started(Valve::default()).lmnr_ls);
        assert!(started(Valve { pos_start: 1e9, ..Valve::default() }).lmnr_hs);
    }

    #[test]
    fn at_rest_it_stays_at_rest_to_the_last_bit() {
        // 20 degC + 80 K * 40 %.
        let mut valve = started(Valve { pos_start: 40.0, t_start: 52.0, ..Valve::default() });
        run(&mut valve, 1000.0);
        assert_eq!((valve.lmnr, valve.temp, valve.t_hx, valve.flow), (40.0, 52.0, 52.0, 16.0));
    }

    #[test]
    fn the_motor_takes_the_actuating_time_from_stop_to_stop_and_the_switches_close_there() {
        let mut valve = started(Valve { up: true, ..Valve::default() });
        run(&mut valve, 29.9);
        assert_close(valve.lmnr, 100.0 * 29.9 / 30.0, 1e-9);
        assert!(!valve.lmnr_hs && !valve.lmnr_ls);
        valve.call();
        assert_eq!(valve.lmnr, 100.0);
        assert!(valve.lmnr_hs);
        run(&mut valve, 10.0);
        assert_eq!(valve.lmnr, 100.0, "it does not keep running");

        (valve.up, valve.down) = (false, true);
        valve.call();
        assert!(!valve.lmnr_hs && valve.lmnr < 100.0);
        run(&mut valve, 29.8);
        assert!(!valve.lmnr_ls);
        valve.call();
        assert_eq!(valve.lmnr, 0.0);
        assert!(valve.lmnr_ls);
    }

    #[test]
    fn up_and_down_together_cancel() {
        let mut valve = started(Valve { up: true, down: true, pos_start: 50.0, ..Valve::default() });
        run(&mut valve, 10.0);
        assert_eq!(valve.lmnr, 50.0);
    }

    #[test]
    fn a_drive_of_30_percent_travels_as_far_as_pulses_that_are_on_for_30_percent_of_the_time() {
        let mut driven = started(Valve { drive: 30.0, ..Valve::default() });
        let mut pulsed = started(Valve::default());
        for call in 0..100 {
            pulsed.up = call % 10 < 3;
            pulsed.call();
            driven.call();
        }
        assert_close(driven.lmnr, 10.0, 1e-12);
        assert_close(pulsed.lmnr, 10.0, 1e-12);
    }

    #[test]
    fn drive_adds_to_the_pulses_within_the_speed_of_the_motor() {
        let after_3_s = |up, down, drive| {
            let mut valve = started(Valve { up, down, drive, pos_start: 50.0, ..Valve::default() });
            run(&mut valve, 3.0);
            valve.lmnr
        };
        assert_close(after_3_s(false, false, -1e9), 40.0, 1e-9);
        assert_close(after_3_s(true, false, 50.0), 60.0, 1e-9);
        assert_close(after_3_s(false, true, 50.0), 45.0, 1e-9);
        assert_eq!(after_3_s(true, false, -1e9), 50.0, "DRIVE itself is limited to -100 ... 100 %");
        assert_eq!(after_3_s(false, false, f64::NAN), after_3_s(false, true, 0.0), "NaN counts as the low limit");
    }

    #[test]
    fn a_reversal_takes_up_the_backlash_first() {
        // 6 % of 30 s is 1.8 s.
        let mut valve = started(Valve { up: true, backlash: 6.0, ..Valve::default() });
        run(&mut valve, 1.8);
        assert_close(valve.lmnr, 0.0, 1e-9);
        run(&mut valve, 6.0);
        assert_close(valve.lmnr, 20.0, 1e-9);
        valve.up = false;
        valve.down = true;
        run(&mut valve, 0.9);
        assert_close(valve.lmnr, 20.0, 1e-9);
        // Halfway through the backlash and back again: half of it remains to be taken up.
        valve.up = true;
        valve.down = false;
        run(&mut valve, 0.9);
        assert_close(valve.lmnr, 20.0, 1e-9);
        run(&mut valve, 3.0);
        assert_close(valve.lmnr, 30.0, 1e-9);
        // No reversal, no backlash.
        valve.up = false;
        run(&mut valve, 5.0);
        valve.up = true;
        run(&mut valve, 3.0);
        assert_close(valve.lmnr, 40.0, 1e-9);
    }

    #[test]
    fn against_a_stop_the_motor_does_not_take_up_backlash_either() {
        let mut valve = started(Valve { pos_start: 100.0, backlash: 6.0, up: true, ..Valve::default() });
        run(&mut valve, 10.0);
        (valve.up, valve.down) = (false, true);
        run(&mut valve, 3.0);
        assert_close(valve.lmnr, 90.0, 1e-9);
    }

    #[test]
    fn backlash_tuned_smaller_leaves_no_more_of_it_to_take_up() {
        let mut valve = started(Valve { up: true, backlash: 6.0, ..Valve::default() });
        run(&mut valve, 7.8);
        valve.backlash = 2.0;
        (valve.up, valve.down) = (false, true);
        run(&mut valve, 3.6);
        assert_close(valve.lmnr, 10.0, 1e-9);
    }

    #[test]
    fn with_backlash_both_stops_are_reached() {
        let mut valve = started(Valve { up: true, backlash: 50.0, ..Valve::default() });
        run(&mut valve, 45.0);
        assert_eq!(valve.lmnr, 100.0);
        (valve.up, valve.down) = (false, true);
        run(&mut valve, 44.9);
        assert!(valve.lmnr > 0.0);
        valve.call();
        assert_eq!(valve.lmnr, 0.0);
    }

    #[test]
    fn a_stuck_valve_does_not_move_and_goes_on_when_it_is_free() {
        let mut valve = started(Valve { up: true, stuck: true, pos_start: 10.0, ..Valve::default() });
        run(&mut valve, 60.0);
        assert_eq!(valve.lmnr, 10.0);
        assert!(!valve.lmnr_hs);
        valve.stuck = false;
        run(&mut valve, 3.0);
        assert_close(valve.lmnr, 20.0, 1e-9);
    }

    #[test]
    fn with_a_positioner_it_goes_to_the_position_asked_for_with_full_speed() {
        let mut valve = started(Valve { pos_on: true, drive: 50.05, up: false, down: true, ..Valve::default() });
        run(&mut valve, 15.0);
        assert_close(valve.lmnr, 50.0, 1e-9);
        valve.call();
        assert_eq!(valve.lmnr, 50.05, "exactly, within the cycle");
        valve.drive = -20.0;
        run(&mut valve, 60.0);
        assert_eq!(valve.lmnr, 0.0);
        // Backlash is compensated for.
        (valve.backlash, valve.drive) = (6.0, 10.0);
        run(&mut valve, 4.7);
        assert!(valve.lmnr < 10.0);
        valve.call();
        assert_eq!(valve.lmnr, 10.0);
    }

    #[test]
    fn the_characteristic_goes_from_0_to_1_and_is_curve_times_steeper_when_open() {
        let flow = |curve, position, pres| {
            let mut valve = started(Valve { curve, pos_start: position, pres, ..Valve::default() });
            valve.call();
            valve.flow
        };
        assert_eq!(flow(1.0, 25.0, 4.0), 10.0);
        // (25^0.5 - 1) / (25 - 1) = 1/6.
        assert_close(flow(25.0, 50.0, 4.0), 40.0 / 6.0, 1e-13);
        assert_close(flow(25.0, 50.0, 1.0), 20.0 / 6.0, 1e-13);
        // (0.25^0.5 - 1) / (0.25 - 1) = 2/3.
        assert_close(flow(0.25, 50.0, 4.0), 80.0 / 3.0, 1e-13);
        assert_close(flow(1.0 + 1e-12, 50.0, 4.0), 20.0, 1e-9);
        for curve in [0.1, 1.0, 30.0, 0.0, -1.0] {
            assert_eq!(flow(curve, 0.0, 4.0), 0.0);
            assert_close(flow(curve, 100.0, 4.0), 40.0, 1e-13);
        }
        let valve = Valve { curve: 30.0, ..Valve::default() };
        let passage = Passage::new(valve.curve, valve.pres, valve.pres_nom);
        assert_close(passage.slope(100.0) / passage.slope(0.0), 30.0, 1e-12);
    }

    #[test]
    fn pressure_acts_by_its_root_and_the_inlet_temperature_as_it_is() {
        // 15 degC + 80 K * 50 % * sqrt(1 / 4).
        let mut valve = started(Valve { pos_start: 50.0, pres: 1.0, t_in: 15.0, ..Valve::default() });
        run(&mut valve, 2000.0);
        assert_close(valve.temp, 35.0, 1e-9);
        valve.pres = -1.0;
        run(&mut valve, 2000.0);
        assert_close(valve.temp, 15.0, 1e-9);
        valve.pres_nom = 0.0;
        run(&mut valve, 2000.0);
        assert_close(valve.temp, 55.0, 1e-9);
    }

    #[test]
    fn a_moving_linear_valve_gives_the_response_of_two_lags_to_a_ramp() {
        let mut valve = started(Valve { up: true, ..Valve::default() });
        for k in 1..=300 {
            valve.call();
            let t = f64::from(k) / 10.0;
            let (a, b) = ((-t / 20.0).exp(), (-t / 5.0).exp());
            assert_close(valve.t_hx, 20.0 + 80.0 / 30.0 * (t - 20.0 + 20.0 * a), 1e-10);
            assert_close(valve.temp, 20.0 + 80.0 / 30.0 * (t - 25.0 + (400.0 * a - 25.0 * b) / 15.0), 1e-10);
        }
    }

    #[test]
    fn a_moving_equal_percentage_valve_gives_the_response_of_a_lag_to_an_exponential() {
        let mut valve = started(Valve { up: true, curve: 30.0, ..Valve::default() });
        let rate = 30.0_f64.ln() / 30.0;
        for k in 1..=300 {
            valve.call();
            let t = f64::from(k) / 10.0;
            let decay = (-t / 20.0).exp();
            let rise = ((rate * t).exp() - decay) / (1.0 + 20.0 * rate) - (1.0 - decay);
            assert_close(valve.t_hx, 20.0 + 80.0 / 29.0 * rise, 1e-10);
        }
    }

    #[test]
    fn the_result_does_not_depend_on_the_cycle() {
        let end = |cycle| {
            let mut valve =
                Valve { cycle: Time::ms(cycle), curve: 30.0, backlash: 3.3, mtr_tm: 29.0, ..Valve::default() };
            valve = started(Valve { hx_tm: 7.0, sens_tm: 0.5, ..valve });
            let mut results = vec![];
            for second in 0..600 {
                valve.up = second * 7 % 23 < 9;
                valve.drive = f64::from(second * 37 % 201 - if second / 100 % 2 == 0 { 50 } else { 200 });
                valve.pres = f64::from(second % 5);
                run(&mut valve, 1.0);
                results.push((valve.lmnr, valve.flow, valve.t_hx, valve.temp));
            }
            results
        };
        let (coarse, fine) = (end(1000), end(10));
        assert!(coarse.iter().any(|result| result.0 == 100.0) && coarse.iter().any(|result| result.0 == 0.0));
        for (coarse, fine) in coarse.iter().zip(fine) {
            assert_close(coarse.0, fine.0, 1e-9);
            assert_close(coarse.1, fine.1, 1e-9);
            assert_close(coarse.2, fine.2, 1e-10);
            assert_close(coarse.3, fine.3, 1e-10);
        }
    }

    #[test]
    fn a_cycle_longer_than_the_stroke_is_exact_too() {
        // Opening from 0 s to 30 s, then 70 s at 100 %.
        let mut valve = started(Valve { up: true, cycle: Time::ms(100_000), sens_tm: 0.0, ..Valve::default() });
        valve.call();
        let decay = (-30.0_f64 / 20.0).exp();
        let at_30_s = 20.0 + 80.0 / 30.0 * (30.0 - 20.0 + 20.0 * decay);
        assert_close(valve.temp, 100.0 + (at_30_s - 100.0) * (-70.0_f64 / 20.0).exp(), 1e-10);
        assert!(valve.lmnr_hs);

        // A steep characteristic followed by a slow lag: the whole stroke in one call.
        let valve =
            Valve { up: true, cycle: Time::ms(30_000), curve: 50.0, hx_tm: 300.0, sens_tm: 0.0, ..Valve::default() };
        let mut valve = started(valve);
        valve.call();
        let (rate, decay) = (50.0_f64.ln() / 30.0, (-30.0_f64 / 300.0).exp());
        let rise = (50.0 - decay) / (1.0 + 300.0 * rate) - (1.0 - decay);
        assert_close(valve.temp, 20.0 + 80.0 / 49.0 * rise, 1e-11);
    }

    #[test]
    fn lags_much_shorter_than_the_cycle_are_exact_down_to_a_hundredth_of_it() {
        // The temperature lags a ramp of 80/30 K/s by 10 ms.
        let mut valve =
            started(Valve { up: true, cycle: Time::ms(1000), hx_tm: 0.01, sens_tm: 0.0, ..Valve::default() });
        for second in 1..=20 {
            valve.call();
            assert_close(valve.temp, 20.0 + 80.0 / 30.0 * (f64::from(second) - 0.01), 1e-10);
        }
    }

    #[test]
    fn bad_parameters_give_no_nan() {
        for bad in [0.0, -1.0] {
            let mut valve = started(Valve {
                up: true,
                mtr_tm: bad,
                backlash: bad,
                pos_start: bad,
                curve: bad,
                flow_max: bad,
                pres_nom: bad,
                hx_tm: bad,
                sens_tm: bad,
                t_per_0: bad,
                t_per_100: bad,
                ..Valve::default()
            });
            valve.call();
            assert_eq!((valve.lmnr, valve.temp, valve.flow), (100.0, 100.0, bad), "at once");
            valve.mtr_tm = 30.0;
            (valve.up, valve.down) = (false, true);
            run(&mut valve, 3.0);
            assert_close(valve.temp, 92.0, 1e-9);
        }
        let mut valve = started(Valve { up: true, hx_tm: 1e-300, sens_tm: 1e-6, ..Valve::default() });
        run(&mut valve, 15.0);
        assert!((59.0..60.1).contains(&valve.temp), "{}", valve.temp);
    }

    #[test]
    fn saved_and_read_back_it_goes_on_bit_for_bit() {
        let mut valve = started(Valve { up: true, backlash: 20.0, curve: 9.0, ..Valve::default() });
        run(&mut valve, 4.0);
        let mut bytes = vec![];
        valve.write(&mut bytes);
        let mut again = Valve::read(&mut &bytes[..]).unwrap();
        for _ in 0..100 {
            valve.call();
            again.call();
            for row in 0..Valve::TABLE.rows.len() {
                assert_eq!(valve.get(row), again.get(row));
            }
        }
    }

    #[test]
    fn cont_s_with_the_settings_of_the_documentation_controls_it_well() {
        let mut valve = started(Valve::default());
        let mut controller = ContS { cycle: Time::ms(100), sp_int: 60.0, ..ContS::default() };
        controller.pulse_tm = Time::ms(300);
        controller.break_tm = Time::ms(300);
        controller.restart();
        let mut settled = [0; 2];
        let mut switched = [0; 2];
        for call in 0..6000 {
            let part = call / 3000;
            valve.pres = if part == 0 { 4.0 } else { 3.0 };
            controller.pv_in = valve.temp as f32;
            (controller.lmnr_hs, controller.lmnr_ls) = (valve.lmnr_hs, valve.lmnr_ls);
            controller.call();
            switched[part] += u32::from(controller.qlmnup && !valve.up) + u32::from(controller.qlmndn && !valve.down);
            (valve.up, valve.down) = (controller.qlmnup, controller.qlmndn);
            valve.call();
            if (valve.temp - 60.0).abs() > 1.5 {
                settled[part] = call % 3000 + 1;
            }
        }
        assert!(settled[0] < 900 && settled[1] < 700, "settled after {settled:?} calls");
        assert!(switched[0] <= 12 && switched[1] <= 7, "pulses: {switched:?}");
    }
}
