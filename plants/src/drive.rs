//! DRIVE: a speed-controlled drive that trips on too fast a setpoint change, a plant for HLG.

use crate::dynamics::{Lag, limited, seconds};
use blocks::{Law, Response};

blocks::block! {
    /// Speed-controlled drive that trips if its setpoint changes faster than it can follow: counts in, speed out.
    ///
    /// # Purpose
    ///
    /// A speed-controlled drive that trips if its setpoint changes faster than it can follow and therefore needs a ramp
    /// generator: the plant for HLG. Inertia, torque limit and monitoring are like those of an inverter drive, as
    /// simple as possible.
    ///
    /// # Quick start
    ///
    /// 1. Connect HLG to SP, N_ACT to INIT of HLG, and a reset button to both SET of HLG and RESET.
    /// 2. CYCLE: the same as TZ of the ramp generator.
    /// 3. Choose TH_TZ and TR_TZ of HLG so that the ramp stays below ERR_MAX / CTRL_TM, 750 rpm/s with the start
    ///    values; set LOAD for a disturbance.
    ///
    /// For HLG: with S1 = 20000, a TH of 400 calls at 10 ms brings the drive to 916 rpm in 4 s; a TH of 100 calls trips
    /// it, and so does S1 connected directly.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon "M"
    /// input SP 0,8
    /// box SCALE 13,8 "x N_MAX /" "32767" with N_MAX
    /// sum ER 26,8 left + bottom -
    /// box CONTROL 36,8 proportional with CTRL_TM
    /// input LOAD 33,15
    /// sum DEMAND 45,8 left + bottom +
    /// box LIMIT 54,8 limit with M_MAX
    /// sum NET 64,8 left + bottom -
    /// box INERTIA 74,8 integrate with ACC_TM COAST_TM
    /// output SP_RPM 23,2
    /// output TORQUE 63,2
    /// output SPEED 87,8
    /// box COUNTS 84,25 "32767 /" "N_MAX"
    /// output N_ACT 90,25
    /// input RESET 0,28
    /// box MONITOR 41,27 "|SP_RPM - SPEED|" "> ERR_MAX" with ERR_MAX
    /// output TRIP 52,27
    /// text 52,30 "TRIP: no torque"
    /// box CALL 12,19 "every CYCLE" with CYCLE
    /// SP > SCALE > ER > CONTROL > DEMAND > LIMIT > NET > INERTIA > SPEED
    /// LOAD > DEMAND.bottom
    /// 43,15 > y16.5 > NET.bottom
    /// 20.5,8 > y2 > SP_RPM
    /// 61,8 > y2 > TORQUE
    /// 82,8 > y18 > ER.bottom
    /// 84,8 > COUNTS.top
    /// COUNTS > N_ACT
    /// 22.5,8 > y26 > MONITOR.left-1
    /// 41,18 > MONITOR.top
    /// RESET > MONITOR.left+1
    /// MONITOR > TRIP
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: SPEED
    /// manipulated value: SP
    /// disturbances: LOAD
    /// signal actual value: N_ACT
    /// signal fault: TRIP
    ///
    /// [Setpoint]
    /// SP
    /// [Disturbance]
    /// LOAD
    /// [Drive]
    /// N_MAX, CTRL_TM, ACC_TM, M_MAX
    /// [Monitoring]
    /// ERR_MAX, COAST_TM, RESET
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// ```math
    /// \begin{aligned}
    /// \dfrac{d\,\text{SPEED}}{dt} &= \dfrac{\text{SP_RPM} - \text{SPEED}}{\text{CTRL_TM}} \\
    /// \text{within} & \quad \pm\dfrac{\text{N_MAX}}{\text{ACC_TM}}\,\dfrac{\text{M_MAX} \mp \text{M_L}}{100\,\%}
    /// \end{aligned}
    /// ```
    ///
    /// One call, where `M_L` is the effective load:
    ///
    /// ```text
    /// SP_RPM = N_MAX (SP / 32767)
    /// TRIP   = FALSE on a rising edge of RESET;  TRUE if |SP_RPM - SPEED| > ERR_MAX;  else unchanged
    /// M_L    = LOAD within -M_MAX ... M_MAX,  A = N_MAX / ACC_TM
    /// dSPEED/dt = (SP_RPM - SPEED) / CTRL_TM   within  A (-M_MAX - M_L) / 100 % ... A (M_MAX - M_L) / 100 %
    /// TORQUE = M_L + 100 % (dSPEED/dt) / A
    /// N_ACT  = 32767 SPEED / N_MAX, rounded
    /// tripped:  dSPEED/dt = -SPEED / COAST_TM,  TORQUE = 0
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k covers the time from k to k + 1 times CYCLE, with the inputs held; after the call, the outputs are
    ///    those at the end of that time. So use a communication step of CYCLE or a multiple of it; with shorter steps
    ///    the outputs run ahead by part of a CYCLE.
    /// 2. Start: standstill, not tripped, whatever the setpoint.
    /// 3. The speed follows the setpoint with a first-order lag CTRL_TM, within the torque limit: on a ramp of r rpm/s
    ///    it stays r CTRL_TM behind, and on one steeper than A (M_MAX - M_L) / 100 % per second it falls further and
    ///    further behind. The control compensates for the load.
    /// 4. Monitoring: setpoint and speed are compared once per call, before the drive moves. If they are more than
    ///    ERR_MAX apart, the drive trips. So a jump of more than ERR_MAX trips it at once, and a ramp of more than
    ///    ERR_MAX / CTRL_TM per second (with the defaults 750 rpm/s: 0 to 1500 rpm in 2 s) trips it as soon as the
    ///    speed is that far behind; so does a slower ramp if the load leaves too little torque.
    /// 5. Once tripped, the drive has no torque and coasts to a standstill. A rising edge of RESET clears the trip; a
    ///    setpoint too far from the speed trips it again in the same call. So bring the setpoint to N_ACT first (SET
    ///    and INIT, or R, of HLG).
    /// 6. LOAD is limited to the torque limit: an overhauling load is not modelled.
    ///
    /// # Limits of use
    ///
    /// Solved in closed form for held inputs, including the change from the torque limit to the lag within a CYCLE, so
    /// the speed depends on CYCLE only through rounding (a few parts in 10^14). The results are the same to the last
    /// bit on every platform.
    ///
    /// The speed control compensates for the load immediately and without error; its dynamics are a single lag.
    ///
    /// Bad input: with CTRL_TM not above 0 the speed follows as fast as the torque allows; ACC_TM not above 0 means no
    /// inertia; with COAST_TM not above 0 the drive stops at once; M_MAX or ERR_MAX below 0 counts as 0; a negative
    /// N_MAX reverses the direction.
    pub struct Drive as "DRIVE" {
        input {
            /// Speed setpoint in counts: 32767 is N_MAX
            ///
            /// Connect the output of HLG here: 20000 counts are 916 rpm with the start value of N_MAX. A jump of more
            /// than ERR_MAX trips the drive in the same call: 75 rpm are 1638 counts.
            sp: Int = 0, min -32767, max 32767;
            /// Rising edge: clears a trip
            ///
            /// A change from FALSE to TRUE clears the trip, provided that setpoint and speed are close enough by then.
            /// Bring the setpoint to N_ACT first, with SET and INIT of HLG.
            reset: Bool = false;
            /// Disturbance: load torque in percent of the rated torque
            ///
            /// The speed control compensates for it within the torque limit: 130 % with M_MAX = 150 % leaves 20 % for
            /// acceleration, so a fast ramp trips the drive.
            load: LReal = 0.0, unit "%";
        }
        parameter {
            /// Speed at 32767 counts
            ///
            /// Scales counts to speed. A negative value reverses the direction.
            n_max: LReal = 1500.0, unit "rpm";
            /// Time constant of the speed control; 0: none
            ///
            /// On a ramp of r rpm/s the speed stays r CTRL_TM behind: 50 rpm for 500 rpm/s and 0.1 s. ERR_MAX must be
            /// larger.
            ctrl_tm: LReal = 0.1, min 0.0, unit "s";
            /// Inertia: time in which the rated torque accelerates the drive from standstill to N_MAX
            ///
            /// With 150 % torque it takes two thirds of this time. It limits the slope of a ramp.
            acc_tm: LReal = 2.0, min 0.0, unit "s";
            /// Torque limit in percent of the rated torque
            ///
            /// The short-time torque of the inverter. Torque taken by the load is not available for acceleration.
            m_max: LReal = 150.0, min 0.0, unit "%";
            /// Largest allowed difference between setpoint and speed
            ///
            /// The monitoring that makes a ramp generator necessary: the drive trips if setpoint and speed are further
            /// apart than this. Divided by CTRL_TM it is the steepest ramp, 750 rpm/s with the start values.
            err_max: LReal = 75.0, min 0.0, unit "rpm";
            /// Time constant of coasting to a standstill after a trip
            ///
            /// A tripped drive has no torque: its speed falls to 37 % in this time.
            coast_tm: LReal = 2.0, min 0.0, unit "s";
        }
        cycle {
            /// Time by which a call advances the drive
            ///
            /// The drive is solved exactly between two calls; the monitoring runs once per call. Set it to the cycle of
            /// the ramp generator, 10 ms.
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Speed
            ///
            /// Actual speed in rpm. It follows SP_RPM with the lag CTRL_TM, within the torque limit.
            speed: LReal, unit "rpm";
            /// Speed in counts: 32767 is N_MAX; for INIT of HLG
            ///
            /// With SET of HLG the ramp then starts at the current speed, so that the drive does not trip again after a
            /// reset.
            n_act: Int;
            /// Tripped: setpoint and speed were too far apart
            ///
            /// TRUE from the call in which setpoint and speed are more than ERR_MAX apart until a rising edge of RESET.
            /// Meanwhile, the drive coasts.
            trip: Bool;
            /// Speed setpoint
            ///
            /// The setpoint in rpm, for plotting alongside SPEED.
            sp_rpm: LReal, unit "rpm";
            /// Torque in percent of the rated torque
            ///
            /// Load plus acceleration, within M_MAX. At M_MAX the speed falls behind the ramp.
            torque: LReal, unit "%";
        }
    }
    memory Memory {
        /// RESET in the previous call.
        reset: bool;
        /// The lag of the control loop.
        control: Lag;
        /// The lag of coasting to a standstill.
        coasting: Lag;
    }
}

impl Law for Drive {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[Response {
        title: "Small setpoint steps with and without load, then one too large, then a reset",
        calls: 600,
        set: &[
            (50, "SP", 1600.0),
            (150, "LOAD", 130.0),
            (200, "SP", 3200.0),
            (300, "SP", 8000.0),
            (450, "SP", 0.0),
            (500, "RESET", 1.0),
            (520, "SP", 1600.0),
        ],
        show: &["SP_RPM", "SPEED", "TORQUE", "TRIP"],
    }];

    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        let cycle = seconds(self.cycle);
        self.sp_rpm = self.n_max * f64::from(self.sp) / 32767.0;
        if self.reset && !self.memory.reset {
            self.trip = false;
        }
        self.memory.reset = self.reset;
        if (self.sp_rpm - self.speed).abs() > self.err_max.max(0.0) {
            self.trip = true;
        }

        if self.trip {
            self.speed = self.memory.coasting.step(self.speed, 0.0, self.coast_tm, cycle);
            self.torque = 0.0;
        } else {
            self.follow(cycle);
        }
        let counts = 32767.0 * self.speed / self.n_max;
        // The cast saturates at the range of an INT, and turns the NaN that an N_MAX of 0 causes into 0.
        self.n_act = (counts + 0.5_f64.copysign(counts)) as i16;
    }
}

impl Drive {
    /// Moves the speed towards the setpoint for a cycle: first with constant acceleration, while the torque is at its
    /// limit, then as a lag.
    fn follow(&mut self, cycle: f64) {
        let torque_limit = self.m_max.max(0.0);
        let load = limited(self.load, -torque_limit, torque_limit);
        let ctrl_tm = self.ctrl_tm.max(0.0);
        let (per_percent, has_inertia) = (self.n_max.abs() / (100.0 * self.acc_tm), self.acc_tm > 0.0);

        let error = self.sp_rpm - self.speed;
        let spare_torque = if error > 0.0 { torque_limit - load } else { torque_limit + load };
        let most = if has_inertia { spare_torque * per_percent } else { f64::INFINITY };
        // The lag requires |error| / CTRL_TM, which exceeds `most` until the error has fallen to most * CTRL_TM.
        let at_limit = limited(error.abs() / most - ctrl_tm, 0.0, cycle);
        if at_limit > 0.0 {
            self.speed += most.copysign(error) * at_limit;
        }
        self.speed = self.memory.control.step(self.speed, self.sp_rpm, ctrl_tm, cycle - at_limit);

        let error = self.sp_rpm - self.speed;
        let acceleration = if error == 0.0 { 0.0 } else { (error / ctrl_tm).abs().min(most).copysign(error) };
        self.torque = if has_inertia && per_percent > 0.0 { load + acceleration / per_percent } else { load };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Block, Hlg, Stored, Time};

    fn started(drive: Drive) -> Drive {
        let mut drive = drive;
        drive.restart();
        drive
    }

    fn run(drive: &mut Drive, seconds: f64) {
        let calls = (seconds / crate::dynamics::seconds(drive.cycle)).round() as u32;
        (0..calls).for_each(|_| drive.call());
    }

    #[track_caller]
    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    /// A drive that never trips and whose counts are rpm.
    fn untripped() -> Drive {
        Drive { err_max: 1e9, n_max: 32767.0, ..Drive::default() }
    }

    #[test]
    fn it_starts_at_rest_whatever_the_inputs_are() {
        let drive = started(Drive { sp: 20_000, reset: true, load: 50.0, ..Drive::default() });
        assert_eq!((drive.speed, drive.sp_rpm, drive.torque, drive.n_act, drive.trip), (0.0, 0.0, 0.0, 0, false));
    }

    #[test]
    fn at_rest_it_stays_at_rest_to_the_last_bit() {
        let mut drive = started(Drive::default());
        run(&mut drive, 100.0);
        assert_eq!((drive.speed, drive.torque, drive.trip), (0.0, 0.0, false));
    }

    #[test]
    fn a_count_is_n_max_over_32767() {
        let mut drive = started(Drive { sp: 32767, err_max: 1e9, ..Drive::default() });
        drive.call();
        assert_eq!(drive.sp_rpm, 1500.0);
        run(&mut drive, 20.0);
        assert_close(drive.speed, 1500.0, 1e-9);
        assert_eq!(drive.n_act, 32767);
        drive.sp = -1;
        run(&mut drive, 20.0);
        assert_close(drive.speed, -1500.0 / 32767.0, 1e-9);
        assert_eq!(drive.n_act, -1);
    }

    #[test]
    fn a_small_step_is_followed_as_a_lag() {
        // 1000 counts are 45.8 rpm, which demand 458 rpm/s; the torque allows 1125 rpm/s.
        let mut drive = started(Drive { sp: 1000, ..Drive::default() });
        for call in 1..=100 {
            drive.call();
            let t = f64::from(call) / 100.0;
            let decay = (-t / 0.1).exp();
            assert_close(drive.speed, 1_500_000.0 / 32767.0 * (1.0 - decay), 1e-11);
            // 100 % torque accelerates by 750 rpm/s.
            assert_close(drive.torque, 1_500_000.0 / 32767.0 * decay / 0.1 / 7.5, 1e-9);
        }
        assert!(!drive.trip);
    }

    #[test]
    fn a_large_step_is_followed_with_the_torque_limit_first() {
        // 100 % torque reaches 32767 rpm in 2 s, so 150 % less a load of 50 % accelerates by 16383.5 rpm/s. The lag
        // takes over when 1638.35 rpm are left, at (10000 - 1638.35) / 16383.5 s, in the middle of a cycle.
        let mut drive = started(Drive { sp: 10_000, load: 50.0, ..untripped() });
        let change = (10_000.0 - 1638.35) / 16383.5;
        for call in 1..=100 {
            drive.call();
            let t = f64::from(call) / 100.0;
            let lag = 10_000.0 - 1638.35 * (-(t - change) / 0.1).exp();
            assert_close(drive.speed, if t < change { 16383.5 * t } else { lag }, 1e-8);
            assert_close(drive.torque, if t < change { 150.0 } else { 50.0 + (10_000.0 - lag) / 0.1 / 163.835 }, 1e-8);
        }
        // The load helps with braking: 200 % is 32767 rpm/s.
        drive.sp = -10_000;
        let before = drive.speed;
        drive.call();
        assert_close(before - drive.speed, 327.67, 1e-9);
        assert_close(drive.torque, -150.0, 1e-9);
    }

    #[test]
    fn a_load_above_the_torque_limit_stops_it_from_accelerating_and_no_more() {
        for load in [150.0, 1e9] {
            let mut drive = started(Drive { sp: 10_000, load, ..untripped() });
            run(&mut drive, 1.0);
            assert_eq!((drive.speed, drive.torque), (0.0, 150.0));
            (drive.sp, drive.load) = (-10_000, -load);
            run(&mut drive, 1.0);
            assert_eq!((drive.speed, drive.torque), (0.0, -150.0));
        }
    }

    #[test]
    fn a_setpoint_jump_above_the_largest_difference_trips_it_at_once() {
        // 75 rpm are 1638.35 counts.
        let mut drive = started(Drive { sp: 1638, ..Drive::default() });
        run(&mut drive, 5.0);
        assert!(!drive.trip);
        drive.sp = 1638 + 1639;
        drive.call();
        assert!(drive.trip);
        assert_eq!(drive.torque, 0.0);
        let mut drive = started(Drive { sp: -1639, ..Drive::default() });
        drive.call();
        assert!(drive.trip);
    }

    #[test]
    fn a_ramp_of_more_than_the_largest_difference_per_lag_trips_it() {
        // 750 rpm/s is 163.8 counts per call of 10 ms. On the ramp the speed lags by r CTRL_TM.
        let trips = |counts_per_call: i16, load| {
            let mut drive = started(Drive { load, ..Drive::default() });
            (0..190).any(|_| {
                drive.sp += counts_per_call;
                drive.call();
                drive.trip
            })
        };
        assert!(!trips(150, 0.0));
        assert!(trips(170, 0.0));
        // A load of 100 % leaves 50 %: 375 rpm/s, or 81.9 counts per call.
        assert!(!trips(80, 100.0));
        assert!(trips(110, 100.0));
    }

    #[test]
    fn tripped_it_coasts_to_rest_and_only_a_rising_edge_of_reset_makes_it_go_on() {
        let mut drive = started(Drive { sp: 1600, reset: true, ..Drive::default() });
        run(&mut drive, 5.0);
        let speed = drive.speed;
        drive.sp = 20_000;
        run(&mut drive, 2.0);
        assert!(drive.trip, "RESET was TRUE before: no edge");
        assert_close(drive.speed, speed * (-1.0_f64).exp(), 1e-10);

        drive.reset = false;
        drive.call();
        drive.reset = true;
        drive.call();
        assert!(drive.trip, "the setpoint is still too far away");

        drive.sp = drive.n_act;
        (0..2).for_each(|_| drive.call());
        assert!(drive.trip, "no edge");
        drive.reset = false;
        drive.call();
        drive.reset = true;
        drive.call();
        assert!(!drive.trip);
    }

    #[test]
    fn the_result_does_not_depend_on_the_cycle() {
        let end = |cycle| {
            let mut drive = started(Drive { cycle: Time::ms(cycle), ..untripped() });
            let mut results = vec![];
            for second in 0..300 {
                drive.sp = ((second * 7919) % 65535 - 32767) as i16;
                drive.load = f64::from(second * 37 % 301 - 150);
                run(&mut drive, 1.0);
                results.push((drive.speed, drive.torque));
            }
            results
        };
        for (coarse, fine) in end(1000).iter().zip(end(10)) {
            assert_close(coarse.0, fine.0, 1e-8);
            assert_close(coarse.1, fine.1, 1e-8);
        }
    }

    #[test]
    fn bad_parameters_give_no_nan() {
        for bad in [0.0, -1.0] {
            let drive = Drive { ctrl_tm: bad, acc_tm: bad, coast_tm: bad, sp: 1600, load: 30.0, ..Drive::default() };
            let mut drive = started(drive);
            drive.call();
            assert_eq!((drive.speed, drive.torque, drive.n_act), (drive.sp_rpm, 30.0, 1600), "at once");
            drive.sp = 20_000;
            drive.call();
            assert_eq!((drive.speed, drive.torque, drive.n_act), (0.0, 0.0, 0));

            // No speed control lag: 1125 rpm/s up to the setpoint, where the speed stays.
            let mut drive = started(Drive { ctrl_tm: bad, sp: 1600, ..Drive::default() });
            drive.call();
            assert_close(drive.speed, 11.25, 1e-12);
            run(&mut drive, 0.1);
            assert_eq!((drive.speed, drive.torque), (drive.sp_rpm, 0.0));

            let mut drive = started(Drive { m_max: bad, err_max: 1e9, sp: 1600, load: 5.0, ..Drive::default() });
            drive.call();
            assert_eq!((drive.speed, drive.torque), (0.0, 0.0));
            let mut drive = started(Drive { acc_tm: bad, sp: 1600, ..Drive::default() });
            drive.call();
            assert_close(drive.speed, drive.sp_rpm * (1.0 - (-0.1_f64).exp()), 1e-12);
            let mut drive = started(Drive { err_max: bad, ..Drive::default() });
            drive.call();
            assert!(!drive.trip, "no difference is allowed, and there is none");
            drive.sp = 1;
            drive.call();
            assert!(drive.trip);
        }
        let mut drive = started(Drive { n_max: 0.0, load: 5.0, sp: 1600, ..Drive::default() });
        drive.call();
        assert_eq!((drive.speed, drive.torque, drive.n_act), (0.0, 5.0, 0));
        let mut drive = started(Drive { n_max: -1500.0, sp: 1600, ..Drive::default() });
        run(&mut drive, 5.0);
        assert_close(drive.speed, -1500.0 * 1600.0 / 32767.0, 1e-9);
        assert_eq!(drive.n_act, 1600);
        let [mut drive, mut mirrored] =
            [32767.0, -32767.0].map(|n_max| started(Drive { n_max, sp: 10_000, ..untripped() }));
        drive.call();
        mirrored.call();
        assert_eq!((mirrored.speed, mirrored.torque), (-drive.speed, -drive.torque));
        let mut drive = started(Drive { load: f64::NAN, sp: 1600, ..Drive::default() });
        drive.call();
        assert!(drive.speed.is_finite());
    }

    #[test]
    fn saved_and_read_back_it_goes_on_bit_for_bit() {
        let mut drive = started(Drive { sp: 20_000, load: 20.0, reset: true, ..untripped() });
        run(&mut drive, 0.4);
        let mut bytes = vec![];
        drive.write(&mut bytes);
        let mut again = Drive::read(&mut &bytes[..]).unwrap();
        for _ in 0..100 {
            drive.call();
            again.call();
            for row in 0..Drive::TABLE.rows.len() {
                assert_eq!(drive.get(row), again.get(row));
            }
        }
    }

    #[test]
    fn hlg_with_the_settings_of_the_documentation_keeps_it_from_tripping() {
        let ramped = |th_tz| {
            let mut ramp = Hlg { e01: true, s1: 20_000, th_tz, tr_tz: th_tz, ..Hlg::default() };
            let mut drive = started(Drive::default());
            ramp.restart();
            for _ in 0..500 {
                ramp.call();
                drive.sp = ramp.hlg;
                drive.call();
            }
            (drive.trip, drive.speed)
        };
        let (trip, speed) = ramped(400);
        assert!(!trip);
        assert_close(speed, 1500.0 * 20_000.0 / 32767.0, 0.01);
        assert!(ramped(100).0);
        assert!(ramped(0).0, "without a ramp");
    }
}
