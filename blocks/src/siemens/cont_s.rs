//! CONT_S (FB 42): the PI step controller.

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Law, Real, Response, Time};

crate::block! {
    /// PI step controller for a motor-driven actuator without position feedback, with manual pulses (FB 42).
    ///
    /// # Purpose
    ///
    /// The block controls a process value with a valve, damper or other actuator that a motor opens and closes, such as
    /// a mixing valve or a gas flap. It needs neither a position feedback nor an analog output: it computes from the
    /// time of its pulses where the valve should be. It is no controller for heating by pulses; that is CONT_C with
    /// PULSEGEN, or PULS_CTR.
    ///
    /// # Quick start
    ///
    /// 1. MTR_TM: the time of the actuator from stop to stop, from its data sheet; 30 s by default.
    /// 2. CYCLE, PULSE_TM and BREAK_TM: 100 ms, and what motor and contactors need, for example 0.5 s each. The
    ///    shortest pulse moves the valve by 100 PULSE_TM / MTR_TM percent.
    /// 3. GAIN and TI: GAIN = T / (2 K L) and TI = T, at most 8 L, for a plant with gain K, time constant T and dead
    ///    time L.
    /// 4. DEADB_W: at least K 50 PULSE_TM / MTR_TM, so that the loop comes to rest.
    /// 5. PV_IN from the plant, or PVPER_ON = TRUE with PV_FAC and PV_OFF for an analog word; SP_INT. Connect
    ///    QLMN_MEAN, or QLMNUP and QLMNDN, to the valve.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon three_step
    /// input SP_INT 0,3
    /// input PV_IN 0,8
    /// input PV_PER 0,13
    /// box CRP_IN 11,13 analog_input
    /// box PV_NORM 21,13 normalize with PV_FAC PV_OFF
    /// switch PVPER_ON 31,9 TRUE lower
    /// sum E 37,3 left + bottom -
    /// box DEADBAND 45,3 dead_band with DEADB_W
    /// box GAIN 58,3 multiply with GAIN
    /// output PV 40,9
    /// output ER 54,9
    /// SP_INT > E > DEADBAND
    /// PV_IN > PVPER_ON.FALSE
    /// PV_PER > CRP_IN > PV_NORM > x28 > PVPER_ON.TRUE
    /// PV: PVPER_ON > E.bottom
    /// 37,9 > PV
    /// ER: DEADBAND > GAIN
    /// 52,3 > y9 > ER
    /// text 63,2.2 "e"
    ///
    /// // e, minus position and I action, plus DISV, to the pulses
    /// GAIN > x65 > y19.5 > x2 > y29 > STEP
    /// text 3,28.2 "e"
    /// sum STEP 10,29 left + bottom -
    /// input DISV 8,24
    /// sum FF 16,29 left + top +
    /// box THREE_ST 24,29 three_step
    /// text 17.7,28.2 "z"
    /// switch LMNS_ON 40,25 TRUE lower
    /// switch DOWN 40,34 TRUE lower by LMNS_ON
    /// input LMNUP 31,26
    /// input LMNDN 31,35
    /// box PULSEOUT 52,29 pulses with PULSE_TM BREAK_TM LMNR_HS LMNR_LS
    /// output QLMNUP 66,26
    /// output QLMNDN 66,32
    /// DISV > FF.top
    /// STEP > FF > THREE_ST
    /// THREE_ST.right-1 > x29 > LMNS_ON.FALSE
    /// THREE_ST.right+1 > x29 > DOWN.FALSE
    /// LMNUP > LMNS_ON.TRUE
    /// LMNDN > DOWN.TRUE
    /// LMNS_ON > x44 > PULSEOUT.left-1
    /// DOWN > x44 > PULSEOUT.left+1
    /// PULSEOUT.right-1 > x60 > QLMNUP
    /// PULSEOUT.right+1 > x60 > QLMNDN
    ///
    /// // the pulses back: the assumed travel of the valve
    /// box MEAN 69,40 mean
    /// output QLMN_MEAN 73,40
    /// box MOTOR 52,46 "+100, 0, -100 %" with MTR_TM
    /// sum RATE 36,46 right + bottom -
    /// box INT 22,46 integrate
    /// box PAUSE 22,55 "e / Te," "in pauses" with TI
    /// 63,26 > y39.5 > MEAN.left-0.5
    /// 62,32 > y40.5 > MEAN.left+0.5
    /// MEAN > QLMN_MEAN
    /// 63,39.5 > y45.5 > MOTOR.right-0.5
    /// 62,40.5 > y46.5 > MOTOR.right+0.5
    /// MOTOR.left > RATE.right
    /// RATE.left > INT.right
    /// INT.left > STEP.bottom
    /// 2,29 > y55 > PAUSE
    /// PAUSE > RATE.bottom
    /// text 11,45.2 "F"
    /// text 22,48.8 "F = 0 with LMNS_ON" middle
    ///
    /// box RESTART 75,3 "outputs = 0" "memory = 0" with COM_RST
    /// box CALL 75,13 "every CYCLE" with CYCLE
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// setpoint: SP_INT
    /// process value: PV_IN, PV
    /// controller: GAIN, TI
    /// pulses: QLMNUP, QLMNDN
    /// signal process value peripheral: PV_PER
    /// signal high stop: LMNR_HS
    /// signal low stop: LMNR_LS
    ///
    /// [Setpoint]
    /// SP_INT
    /// [Process value]
    /// PVPER_ON
    /// PV_IN if not PVPER_ON
    /// PV_PER, PV_FAC, PV_OFF if PVPER_ON
    /// [Dead band]
    /// DEADB_W
    /// [Gain and times]
    /// GAIN, TI
    /// [Manual]
    /// LMNS_ON
    /// LMNUP, LMNDN if LMNS_ON
    /// [Actuator]
    /// MTR_TM, LMNR_HS, LMNR_LS
    /// [Pulse former]
    /// PULSE_TM, BREAK_TM
    /// [Disturbance]
    /// DISV
    /// [Sampling]
    /// CYCLE, COM_RST
    /// ```
    ///
    /// # Law
    ///
    /// Seen over many pulses the valve follows a PI controller with the feedforward DISV:
    ///
    /// ```math
    /// \text{travel} = \text{GAIN}\left(\text{ER} + \frac{1}{\text{TI}}\int \text{ER}\,dt\right) + \text{DISV}
    /// ```
    ///
    /// A pulse begins when the demand exceeds the on threshold, and ends at the off threshold:
    ///
    /// ```math
    /// z \ge \max\left(\min(|e|, |F|, 10),\ \frac{100\,\text{PULSE_TM}}{\text{MTR_TM}}\right), \qquad z \le \frac{55\,\text{CYCLE}}{\text{MTR_TM}}, \qquad z = e - F + \text{DISV}
    /// ```
    ///
    /// The law of a call, in this order; every operation rounds to a 32-bit REAL, `a` is the pulse that has been
    /// running since an earlier call (+1 up, -1 down, 0 none):
    ///
    /// ```text
    /// PV     = PVPER_ON ? ((PV_PER * 0.003616898) * PV_FAC) + PV_OFF : PV_IN
    /// ER     = dead band of half width DEADB_W over SP_INT - PV
    /// e      = ER * GAIN
    /// T      = CYCLE,  M = max(MTR_TM, T),  Ti = max(TI, T / 2)                                in seconds
    /// F      = 0                              with LMNS_ON
    ///          F + (((100 * a) * T) / M)      while a pulse runs
    ///          F - ((e * T) / Te)             in pauses,      Te = max(Ti - |(0.01 * e) * M|, 0.1 * Ti)
    /// z      = (e - F) + DISV
    /// off    = (55 * T) / M
    /// lowest = (100 * max(PULSE_TM, CYCLE)) / M
    /// on     = max(min(|e|, |F|, 10), lowest)
    /// demand = +1 if z >= on, or still if z > off
    ///          -1 if z <= -on, or still if z < -off
    ///          0 otherwise;  with LMNS_ON: LMNUP - LMNDN
    /// a      = demand, as far as the stops, PULSE_TM and BREAK_TM allow
    /// QLMNUP = (a = +1),  QLMNDN = (a = -1)
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Restart (COM_RST): all outputs are FALSE / 0, and so is all memory: a running pulse ends at once, whatever is
    ///    left of PULSE_TM. The block does not reset COM_RST: while it is TRUE, every call is a restart. (manual)
    /// 2. Process value: PV_FAC and PV_OFF act on the analog value PV_PER only (manual). 100/27648 is multiplied as a
    ///    REAL (measured). Dead band: ER = x + DEADB_W below -DEADB_W, x - DEADB_W above DEADB_W, else 0. (vendor)
    /// 3. Times have lower bounds: MTR_TM is at least CYCLE, TI at least CYCLE / 2. (vendor)
    /// 4. One integrator F holds both the assumed position of the valve and the I action (manual). During a pulse it
    ///    moves with the motor, and the error is not integrated; in pauses it integrates the error with the shorter
    ///    reset time Te, which compensates for the pulses: the mean rate is e / TI while |e| MTR_TM / 100 stays below
    ///    0.9 TI (measured). The I action that is missed during the first pulse is not compensated: at the end of a
    ///    pulse the travel is e^2 MTR_TM / (100 TI) behind e (1 + t / TI), and further behind between pulses. The first
    ///    pulse lasts e MTR_TM / 100 only if |e| MTR_TM / 100 is well below TI, otherwise longer.
    /// 5. Pauses integrate nothing while the valve is reported at the stop that e pushes against. (measured)
    /// 6. LMNS_ON holds F at 0, so the change back to automatic may bump. (vendor)
    /// 7. TI = 0 switches the I action off. Then F is the position only, and is held within 0 ... 100. (vendor; numbers
    ///    measured)
    /// 8. The on threshold is adapted: few long pulses while the error is large, short ones near the setpoint. With TI
    ///    above 0 it follows the formula; with TI = 0, |e| / 2 replaces min(|e|, |F|), or 0 if PV is 0. If either stop
    ///    is reported, it is `lowest`, also during a pulse; otherwise a pulse keeps the threshold it began with. It is
    ///    adapted in manual mode too. (that it is adapted: vendor; numbers measured)
    /// 9. Three-step element: on at the on threshold, off at the off threshold, with z compared as in the formula.
    ///    (vendor)
    /// 10. Manual pulses: with LMNS_ON, LMNUP alone demands a pulse up, LMNDN alone a pulse down, both or neither
    ///     demand none. (manual, vendor)
    /// 11. A demand against a reported stop is ignored, and so is a demand against the running pulse: between up and
    ///     down there is at least one call with both outputs FALSE. (vendor)
    /// 12. A pulse lasts at least PULSE_TM even if the demand ends earlier, and the break after it at least BREAK_TM;
    ///     this holds for manual pulses too. Both times are counted in calls: with CYCLE 1 s, 3 s are three calls.
    ///     (manual, vendor)
    /// 13. A pulse against a reported stop ends at once, whatever is left of PULSE_TM (vendor). If something was left,
    ///     no break is needed after it; otherwise BREAK_TM applies (measured).
    /// 14. It follows from clauses 11 to 13 that both outputs are never TRUE together, that up and down never follow
    ///     each other in consecutive calls, and that no pulse runs against a reported stop.
    /// 15. QLMN_MEAN is ours, not the manual's: the mean of the pulses over the last communication step, +100 % if up
    ///     all the time, -100 % if down all the time; in a step without a call, the state of the outputs. A Real plant
    ///     input and steps longer than CYCLE need it, because QLMNUP and QLMNDN show only the last call. (decided)
    ///
    /// # Sampling
    ///
    /// The block computes with CYCLE and must be called that often. A pulse is a whole number of calls, so the valve
    /// moves in steps of 100 CYCLE / MTR_TM percent.
    ///
    /// A communication step of ten times CYCLE makes ten calls with the inputs of its start, so the loop reacts up to
    /// ten CYCLE later: a dead time that a tuned loop has to bear. A step of CYCLE / 10 makes a call in one step of ten
    /// and none in the others.
    ///
    /// # Limits of use
    ///
    /// The block checks no parameter. An internal overflow may leave the integrator infinite or NaN, and the automatic
    /// mode stops working; COM_RST or LMNS_ON clears it.
    ///
    /// The block does not know the position of the valve. A valve that is slower than MTR_TM says, or that a hand
    /// moves, is found again by the I action alone; with TI = 0 it is lost until it reaches a stop that LMNR_HS or
    /// LMNR_LS reports. There is no D action.
    ///
    /// # Sources
    ///
    /// Decided: QLMN_MEAN. The manual's table says that QLMNDN opens the valve; this is a misprint: QLMNDN closes it.
    ///
    /// Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.2,
    /// figure 3-2, tables 3-3 and 3-4; recordings at the terminals of real blocks.
    pub struct ContS as "CONT_S" | "FB 42" | "SFB 42" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            ///
            /// While it is TRUE, every call is a restart: both pulses end at once, even within PULSE_TM, the outputs
            /// are 0 and the integrator is empty. The block does not reset it. Nothing has to be set at the start of a
            /// simulation, because the FMU restarts the block when the initialization ends; a pulse of one call is the
            /// remedy after a NaN has reached the integrator.
            com_rst: Bool = false;
            /// The actuator is at its upper limit stop
            ///
            /// TRUE blocks QLMNUP: a pulse up ends at once, and pauses no longer integrate an error that pushes
            /// upwards. Wire it to the limit switch of the valve, or to that of a simulated one. Without limit switches
            /// leave it FALSE: the block then goes on pulsing against the stop, because it has no position feedback,
            /// and finds its way back without harm. While either stop is reported, the on threshold is at its lowest,
            /// 100 PULSE_TM / MTR_TM percent.
            lmnr_hs: Bool = false;
            /// The actuator is at its lower limit stop
            ///
            /// TRUE blocks QLMNDN: a pulse down ends at once, and pauses no longer integrate an error that pushes
            /// downwards. It is the counterpart of LMNR_HS. Both TRUE at the same time block every pulse, which is a
            /// wiring fault in most plants.
            lmnr_ls: Bool = false;
            /// Manual mode: LMNUP and LMNDN make the pulses
            ///
            /// While it is TRUE, only LMNUP and LMNDN move the valve, within PULSE_TM, BREAK_TM and the limit stops;
            /// setpoint and error are ignored. The integrator is held at 0. When it becomes FALSE, the controller
            /// begins with F = 0 and acts on the error as after a restart: with GAIN = 2, an error of 8 beyond the dead
            /// band demands 16 % of travel at once. For a smooth change let the setpoint be near the process value.
            /// Unlike CONT_C, the block starts in automatic mode.
            lmns_on: Bool = false;
            /// Manual pulse up
            ///
            /// Acts only with LMNS_ON = TRUE. The pulse lasts as long as LMNUP is TRUE, but at least PULSE_TM and in
            /// whole calls: with MTR_TM = 30 s, LMNUP for 6 s opens the valve by 20 %. Together with LMNDN it demands
            /// nothing. LMNR_HS stops it.
            lmnup: Bool = false;
            /// Manual pulse down
            ///
            /// Acts only with LMNS_ON = TRUE. The pulse lasts as long as LMNDN is TRUE, but at least PULSE_TM and in
            /// whole calls. Together with LMNUP it demands nothing. LMNR_LS stops it.
            lmndn: Bool = false;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// FALSE takes PV_IN as it is, in percent or in a physical unit. TRUE takes the analog word PV_PER, where
            /// 27648 is 100, times PV_FAC plus PV_OFF. Setpoint, dead band and PV always have the unit of the process
            /// value that is chosen here.
            pvper_on: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The block computes with this time and the FMU calls it that often, whatever the communication step is. A
            /// pulse is a whole number of calls, so the valve moves in steps of 100 CYCLE / MTR_TM percent: 3.3 % with
            /// the start values of 1 s and 30 s, 0.33 % with 0.1 s. Choose CYCLE at most PULSE_TM, a tenth of the
            /// plant's dominant time constant, and as in the PLC. 100 ms is usual.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// Has the unit of PV. A step of the setpoint acts on the P action at once: a step of 10 with GAIN = 2 and
            /// no dead band demands 20 % of travel, which is a pulse of 6 s with MTR_TM = 30 s and TI = 0. If that is
            /// too rough, ramp the setpoint before the block.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// Used while PVPER_ON is FALSE. Connect the output of the plant here if it is a Real in percent or in a
            /// physical unit. It is not limited and not filtered: noise larger than DEADB_W makes the valve work.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// Used while PVPER_ON is TRUE: what an analog input module gives for 0 ... 100 % is 0 ... 27648; overflow
            /// of the module ends at 32511, which is 117.6 %. Words from 32768 on are negative: 65535 is -1. Scale with
            /// PV_FAC and PV_OFF.
            pv_per: Word = Word::new(0);
        }
        parameter {
            /// Proportional gain
            ///
            /// Percent of valve travel for each unit of the error, and for the I action as well: GAIN acts on P and I
            /// together. With GAIN = 2 an error of 5 beyond the dead band demands 10 % of travel, which is the smallest
            /// demand that makes a pulse with the start values. A negative GAIN is for plants in which opening the
            /// valve lowers the process value. Begin with the SIMC rule GAIN = T / (K 2 L), at most, for a plant with
            /// gain K, time constant T and dead time L: K = 2, T = 60 s, L = 10 s give 1.5. GAIN = 0 makes no pulses
            /// from the error.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE, 0 switches the integral action off
            ///
            /// The I action repeats the travel of the P action every TI while the error stays: with GAIN = 2 and an
            /// error of 10 it adds 20 % of travel in each TI. Begin with the plant's time constant, but not more than 8
            /// times its dead time. A TI far below the time that the valve takes for the P action, |e| MTR_TM / 100, is
            /// not reached: the effective reset time is not shortened below a tenth of TI. 0 switches the I action off,
            /// unlike in CONT_C; the valve then follows GAIN times the error, with a permanent error. Between 0 and
            /// CYCLE / 2 the block uses CYCLE / 2.
            ti: Time = Time::ms(20_000);
            /// Dead band: half the width of the band in which the error counts as 0, 0 ... 100 % or a physical value
            ///
            /// Within SP_INT - DEADB_W ... SP_INT + DEADB_W the error is 0 and the valve rests; beyond it the error is
            /// counted from the edge of the band. It spares the motor. Choose it larger than the noise of PV and at
            /// least half as large as the change of PV that the shortest pulse causes: K 100 PULSE_TM / MTR_TM with the
            /// plant's gain K, else the loop hunts. The start value is 1, not 0 as in CONT_C. A negative value widens
            /// the error instead.
            deadb_w: Real = 1.0, min 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// Acts on PV_PER only: PV = PV_PER * 100 / 27648 * PV_FAC + PV_OFF. For a transmitter of 0 ... 400 degC
            /// set 4 and PV_OFF = 0; then setpoint and dead band are in degC. With PV_IN it has no effect.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// Acts on PV_PER only, behind PV_FAC: for a transmitter of -50 ... 150 degC set PV_FAC = 2 and PV_OFF =
            /// -50. With PV_IN it has no effect.
            pv_off: Real = 0.0;
            /// Minimum length of a pulse; range: PULSE_TM >= CYCLE
            ///
            /// No pulse is shorter, manual ones included; only a limit stop or a restart ends it earlier. It is counted
            /// in calls and rounded up: 3 s are 3 calls of 1 s. It sets the smallest move of the valve and the lowest
            /// on threshold, 100 PULSE_TM / MTR_TM percent: 10 % with the start values, which is coarse. For a
            /// contactor or a motor with run-up take what its data sheet asks for, often 0.1 ... 1 s. Below CYCLE it is
            /// CYCLE.
            pulse_tm: Time = Time::ms(3_000);
            /// Minimum length of the break between pulses; range: BREAK_TM >= CYCLE
            ///
            /// The rest between two pulses, in any direction, so that the motor can stop and the contactors can release
            /// before it reverses. It is counted in calls; even with 0 there is one call without a pulse between up and
            /// down. A long break slows the loop: with PULSE_TM = BREAK_TM and short pulses the valve moves half of the
            /// time. After a pulse that a limit stop has cut within PULSE_TM, no break is needed.
            break_tm: Time = Time::ms(3_000);
            /// Time the actuator needs from limit stop to limit stop; range: MTR_TM >= CYCLE
            ///
            /// From the data sheet of the actuator, or measured with a stop watch from closed to open. The block has no
            /// position feedback: it computes the travel from the time of its pulses, 100 CYCLE / MTR_TM percent a
            /// call. If the true time is 30 % longer, each pulse moves 30 % / 1.3 = 23 % less than the block assumes,
            /// and the I action makes up for it more slowly. Below CYCLE it is CYCLE.
            mtr_tm: Time = Time::ms(30_000);
        }
        input {
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// Added to the demanded travel, behind GAIN and the dead band: a change of DISV by 10 moves the valve by
            /// 10 % without waiting for an error. Connect a measured disturbance, scaled by how much valve it needs. It
            /// acts in automatic mode only.
            disv: Real = 0.0;
        }
        output {
            /// Pulse up: opens the valve
            ///
            /// TRUE while the motor has to open the valve. It shows the last call of the communication step: for steps
            /// longer than CYCLE and for a plant with a Real input use QLMN_MEAN. Never TRUE together with QLMNDN, and
            /// between up and down there is at least one call with both FALSE.
            qlmnup: Bool;
            /// Pulse down: closes the valve
            ///
            /// TRUE while the motor has to close the valve. It shows the last call of the communication step: for steps
            /// longer than CYCLE and for a plant with a Real input use QLMN_MEAN.
            qlmndn: Bool;
            /// Process value in use
            ///
            /// The process value that the last call used: PV_IN, or PV_PER scaled by PV_FAC and PV_OFF. It is 0 until
            /// the first call.
            pv: Real;
            /// Error after the dead band
            ///
            /// SP_INT - PV behind the dead band: 0 within it, otherwise smaller by DEADB_W than the true error. With
            /// SP_INT = 11, PV = 0 and DEADB_W = 1 it is 10. It is not multiplied by GAIN.
            er: Real;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, up positive (not in the manual)
        ///
        /// Connects the pulses to a plant with one Real input for the motor. 100 means up in every call of the step,
        /// -100 down in every call; a step of ten calls with four calls up gives 40. A valve that integrates QLMN_MEAN
        /// / MTR_TM moves exactly as far as the pulses say, at any communication step.
        qlmn_mean;
    }
    memory Memory {
        /// The running pulse: +1 up, -1 down, 0 none.
        pulse: i32;
        /// The integrator: assumed valve position and I action in one.
        f: Real;
        /// The adapted on threshold.
        on: Real;
        /// Rest of the minimum pulse time, in milliseconds.
        pulse_left: i32;
        /// Rest of the minimum break time, in milliseconds.
        break_left: i32;
    }
}

impl Law for ContS {
    const RESPONSES: &'static [Response] = &[
        Response {
            title: "Setpoint 11: a long pulse for the P action, then short ones for the I action; back at 0 the P action is \
                taken back and the I action stays; at -6 the I action moves down",
            calls: 140,
            set: &[(5, "SP_INT", 11.0), (48, "SP_INT", 0.0), (70, "SP_INT", -6.0)],
            show: &["SP_INT", "ER", "QLMNUP", "QLMNDN"],
        },
        Response {
            title: "P action alone (TI = 0, no dead band): an error of 10 opens the valve by 20 %, 6 calls of 3.3 %; half of the \
                error takes half of it back",
            calls: 60,
            set: &[(0, "TI", 0.0), (0, "DEADB_W", 0.0), (5, "SP_INT", 10.0), (30, "SP_INT", 5.0)],
            show: &["SP_INT", "ER", "QLMNUP", "QLMNDN"],
        },
        Response {
            title: "By hand: LMNUP for 6 calls makes a pulse of 6, LMNDN for one call makes one of PULSE_TM = 3 s; both together \
                make none",
            calls: 60,
            set: &[
                (0, "LMNS_ON", 1.0),
                (5, "LMNUP", 1.0),
                (11, "LMNUP", 0.0),
                (25, "LMNDN", 1.0),
                (26, "LMNDN", 0.0),
                (40, "LMNUP", 1.0),
                (40, "LMNDN", 1.0),
                (50, "LMNUP", 0.0),
                (50, "LMNDN", 0.0),
            ],
            show: &["LMNUP", "LMNDN", "QLMNUP", "QLMNDN"],
        },
        Response {
            title: "The upper stop cuts a pulse at once; the way down is free",
            calls: 60,
            set: &[(5, "SP_INT", 40.0), (15, "LMNR_HS", 1.0), (30, "SP_INT", -40.0), (34, "LMNR_HS", 0.0)],
            show: &["ER", "LMNR_HS", "QLMNUP", "QLMNDN"],
        },
    ];

    fn restart(&mut self) {
        self.clear();
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        let e = self.er * self.gain;

        let t = self.cycle.seconds();
        let m = self.mtr_tm.seconds().max(t);

        self.memory.f = self.integral(e, t, m);
        self.memory.on = self.on_threshold(e, m);
        let demand = if self.lmns_on {
            i32::from(self.lmnup) - i32::from(self.lmndn)
        } else {
            self.three_step((e - self.memory.f) + self.disv, (55.0 * t) / m)
        };
        let reversal = demand * self.memory.pulse < 0;
        self.pulse_stage(if reversal || self.at_stop(demand > 0, demand < 0) { 0 } else { demand });

        self.qlmnup = self.memory.pulse > 0;
        self.qlmndn = self.memory.pulse < 0;
    }

    fn advice(&self) -> Vec<String> {
        advice::cont_s(self)
    }

    fn pulse(&self) -> i32 {
        self.memory.pulse
    }
}

impl ContS {
    /// Whether the valve is reported at the stop that lies in this direction.
    fn at_stop(&self, up: bool, down: bool) -> bool {
        (up && self.lmnr_hs) || (down && self.lmnr_ls)
    }

    /// The integrator F after this call.
    fn integral(&self, e: Real, t: Real, m: Real) -> Real {
        let Memory { f, pulse, .. } = self.memory;
        if self.lmns_on {
            return 0.0;
        }
        if self.ti > Time::ZERO {
            if pulse != 0 {
                f + (((100.0 * pulse as Real) * t) / m)
            } else if self.at_stop(e > 0.0, e < 0.0) {
                f
            } else {
                let ti = self.ti.seconds().max(t * 0.5);
                let te = (ti - ((0.01 * e) * m).abs()).max(0.1 * ti);
                f - ((e * t) / te)
            }
        } else {
            (f + (((100.0 * pulse as Real) * t) / m)).clamp(0.0, 100.0)
        }
    }

    /// The on threshold in this call.
    fn on_threshold(&self, e: Real, m: Real) -> Real {
        let lowest = (100.0 * self.pulse_tm.max(self.cycle).seconds()) / m;
        if self.lmnr_hs || self.lmnr_ls {
            lowest
        } else if self.memory.pulse != 0 {
            self.memory.on
        } else {
            let want = if self.ti > Time::ZERO {
                e.abs().min(self.memory.f.abs())
            } else if self.pv == 0.0 {
                0.0
            } else {
                e.abs() * 0.5
            };
            want.min(10.0).max(lowest)
        }
    }

    /// THREE_ST: the direction in which the valve should go.
    fn three_step(&self, z: Real, off: Real) -> i32 {
        let Memory { pulse, on, .. } = self.memory;
        if (pulse > 0 && z > off) || z >= on {
            1
        } else if (pulse < 0 && z < -off) || z <= -on {
            -1
        } else {
            0
        }
    }

    /// PULSEOUT: minimum pulse and minimum break, and the stops.
    fn pulse_stage(&mut self, demand: i32) {
        let stopped = self.at_stop(self.memory.pulse > 0, self.memory.pulse < 0);
        let memory = &mut self.memory;
        if stopped || (memory.pulse != 0 && demand == 0 && memory.pulse_left == 0) {
            memory.break_left = if memory.pulse_left > 0 { 0 } else { self.break_tm.milliseconds() };
            memory.pulse_left = 0;
            memory.pulse = 0;
        } else if memory.pulse == 0 && demand != 0 && memory.break_left == 0 {
            memory.pulse_left = self.pulse_tm.milliseconds();
            memory.pulse = demand;
        }
        memory.pulse_left = memory.pulse_left.saturating_sub(self.cycle.milliseconds()).max(0);
        memory.break_left = memory.break_left.saturating_sub(self.cycle.milliseconds()).max(0);
    }
}

#[cfg(test)]
mod tests;
