//! CONT_C (FB 41): the continuous PID controller.

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Characteristic, Int, Law, Real, Response, Word, low_word, rnd};

crate::block! {
    /// Continuous PID controller with manual mode, anti-windup, feedforward and analog value conversion (FB 41).
    ///
    /// # Purpose
    ///
    /// CONT_C holds a process value at its setpoint by means of an actuator that takes any value between two limits:
    /// every CYCLE it compares setpoint and process value and computes the manipulated value by a PID law. It is used
    /// for temperature, pressure, flow, level and speed, alone, in cascades and in ratio control; with PULSEGEN behind
    /// it, also for heaters and valves that are only switched on and off. It leaves to others what comes before and after:
    /// the ramp of the setpoint, the filter and the supervision of the sensor, alarms, and the choice of its settings.
    ///
    /// # Quick start
    ///
    /// 1. Sampling time: CYCLE at most a tenth of the plant's time constant; 1 s for a plant of 100 s is ample.
    /// 2. Process value: connect PV_IN, in the unit of SP_INT. If it comes as an analog word, set PVPER_ON = TRUE, connect
    ///    PV_PER, and set PV_FAC and PV_OFF: 4 and 0 for a transmitter of 0 ... 400 degC.
    /// 3. Limits: LMN_LLM and LMN_HLM as the actuator has them: 0 and 100 % for a heater or a valve, -100 and 100 % for
    ///    heating and cooling.
    /// 4. Tuning: in manual mode, change MAN and watch PV. K is the change of PV divided by that of MAN, L the time until
    ///    PV begins to move plus CYCLE / 2, T the time from there to 63 % of the change. Set GAIN = T / (2 K L) and TI to
    ///    the smaller one of T and 8 L: GAIN = 2.5 and TI = 80 s for K = 2, T = 100 s, L = 10 s. Leave D_SEL = FALSE.
    /// 5. Automatic mode: set SP_INT, then MAN_ON = FALSE. MAN_ON starts TRUE, so LMN follows MAN until you do.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon "PID"
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
    /// // e goes to the three actions
    /// GAIN > x65 > y19.5 > x2 > y24 > P_SEL.TRUE
    /// 2,24 > y33 > INT > I_SEL.TRUE
    /// 2,33 > y48 > DIF > D_SEL.TRUE
    /// text 3,23.2 "e"
    /// switch P_SEL 20,25 TRUE upper constant FALSE 0.0
    /// box INT 9.5,33 integrate with TI INT_HOLD I_ITL_ON I_ITLVAL
    /// switch I_SEL 20,34 TRUE upper constant FALSE 0.0
    /// box DIF 9.5,48 differentiate with TD TM_LAG
    /// switch D_SEL 20,49 TRUE upper constant FALSE 0.0
    /// output LMN_P 25.5,22
    /// output LMN_I 25.5,31
    /// output LMN_D 25.5,46
    /// sum PID 32.5,34 top + left + bottom +
    /// LMN_P: P_SEL > PID.top
    /// LMN_I: I_SEL > PID
    /// LMN_D: D_SEL > PID.bottom
    /// 24,25 > y22 > LMN_P
    /// 24,34 > y31 > LMN_I
    /// 24,49 > y46 > LMN_D
    ///
    /// input DISV 33.5,28
    /// sum FF 40,34 left + top +
    /// input MAN 35,40
    /// switch MAN_ON 46,35 TRUE lower
    /// box LMNLIMIT 55,35 limit with LMN_HLM LMN_LLM
    /// box LMN_NORM 67,35 normalize with LMN_FAC LMN_OFF
    /// box CRP_OUT 67,46 analog_output
    /// output QLMN_HLM 57,27
    /// output QLMN_LLM 53,45
    /// output LMN 75.5,35
    /// output LMN_PER 69,52
    /// DISV > FF.top
    /// PID > FF > MAN_ON.FALSE
    /// MAN > x42 > MAN_ON.TRUE
    /// MAN_ON > LMNLIMIT > LMN_NORM > LMN
    /// LMNLIMIT.top > y27 > QLMN_HLM
    /// LMNLIMIT.bottom-3.5 > y45 > QLMN_LLM
    /// 73.5,35 > y46 > CRP_OUT.right
    /// CRP_OUT.bottom > y52 > LMN_PER
    ///
    /// box RESTART 74,3 "outputs = 0" "INT = I_ITLVAL" with COM_RST
    /// box CALL 74,13 "every CYCLE" with CYCLE
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// setpoint: SP_INT
    /// process value: PV_IN, PV
    /// manipulated value: LMN
    /// manual: MAN_ON, MAN
    /// controller: GAIN, TI, TD, TM_LAG
    /// structure: P_SEL, I_SEL, D_SEL
    /// signal process value peripheral: PV_PER
    ///
    /// [Setpoint]
    /// SP_INT
    /// [Process value]
    /// PVPER_ON
    /// PV_IN if not PVPER_ON
    /// PV_PER, PV_FAC, PV_OFF if PVPER_ON
    /// [Dead band]
    /// DEADB_W
    /// [Structure]
    /// P_SEL, I_SEL, D_SEL
    /// [Gain and times]
    /// GAIN if P_SEL or I_SEL or D_SEL
    /// TI if I_SEL and not INT_HOLD and not I_ITL_ON
    /// TD, TM_LAG if D_SEL
    /// [Manual]
    /// MAN_ON
    /// MAN if MAN_ON
    /// [Limits]
    /// LMN_HLM, LMN_LLM
    /// [Normalization]
    /// LMN_FAC, LMN_OFF
    /// [Integral action]
    /// INT_HOLD if I_SEL and not I_ITL_ON
    /// I_ITL_ON, I_ITLVAL if I_SEL
    /// [Disturbance]
    /// DISV
    /// [Sampling]
    /// CYCLE, COM_RST
    /// ```
    ///
    /// # Law
    ///
    /// In automatic mode and between the limits, GAIN multiplies all three parts:
    ///
    /// ```math
    /// \begin{aligned}
    /// u(t) &= \text{GAIN} \left( \text{ER}(t) + \dfrac{1}{\text{TI}} \int_0^t \text{ER}(\tau) \, d\tau
    ///     + \text{TD} \, \dfrac{d}{dt} \, \text{ER}_\text{lag}(t) \right) + \text{DISV}(t) \\
    /// \text{ER}(t) &= \text{ER}_\text{lag}(t) + \text{TM_LAG} \, \dfrac{d}{dt} \, \text{ER}_\text{lag}(t)
    /// \end{aligned}
    /// ```
    ///
    /// As a transfer function:
    ///
    /// ```math
    /// u(s) = \text{GAIN} \left( 1 + \dfrac{1}{\text{TI} \, s}
    ///     + \dfrac{\text{TD} \, s}{1 + \text{TM_LAG} \, s} \right) \text{ER}(s) + \text{DISV}(s)
    /// ```
    ///
    /// The block computes it call by call, with `T` = CYCLE. The integral is a sum of trapezoids, and the derivative follows
    /// from `w`, which is `e` after the lag:
    ///
    /// ```math
    /// \begin{aligned}
    /// \text{PV} &= \dfrac{100}{27648} \, \text{PV_PER} \cdot \text{PV_FAC} + \text{PV_OFF}
    ///     \quad \text{or} \quad \text{PV} = \text{PV_IN} \\
    /// x &= \text{SP_INT} - \text{PV}, \qquad \text{ER} = \begin{cases}
    ///     x + \text{DEADB_W} & x < -\text{DEADB_W} \\
    ///     0 & |x| \le \text{DEADB_W} \\
    ///     x - \text{DEADB_W} & x > \text{DEADB_W} \end{cases} \\
    /// e_k &= \text{GAIN} \cdot \text{ER}_k \\
    /// \text{LMN_P}_k &= e_k \\
    /// \text{LMN_I}_k &= \text{LMN_I}_{k-1} + \dfrac{T}{\text{TI}} \cdot \dfrac{e_k + e_{k-1}}{2} \\
    /// \text{LMN_D}_k &= \dfrac{\text{TD}}{T / 2 + \text{TM_LAG}} ( e_k - w_{k-1} ),
    ///     \qquad w_k = w_{k-1} + \dfrac{T}{\text{TD}} \, \text{LMN_D}_k \\
    /// u_k &= \text{LMN_P}_k + \text{LMN_I}_k + \text{LMN_D}_k + \text{DISV}_k
    ///     \quad \text{or, in manual mode,} \quad u_k = \text{MAN}_k \\
    /// y_k &= \min ( \max ( u_k, \text{LMN_LLM} ), \text{LMN_HLM} ) \\
    /// \text{LMN}_k &= \text{LMN_FAC} \cdot y_k + \text{LMN_OFF},
    ///     \qquad \text{LMN_PER}_k = \dfrac{27648}{100} \, \text{LMN}_k
    /// \end{aligned}
    /// ```
    ///
    /// The exact order of operations of a call, with the lower bounds of the times and with `rest`, the round-off error of
    /// the previous call. Every operation rounds to a 32-bit REAL, `[k-1]` is the value of the previous call:
    ///
    /// ```text
    /// PV    = PVPER_ON ? ((PV_PER * 0.003616898) * PV_FAC) + PV_OFF : PV_IN
    /// ER    = dead band of half width DEADB_W over SP_INT - PV
    /// e     = ER * GAIN
    /// T     = CYCLE,  Ti = max(TI, T / 2),  Td = max(TD, T),  Tl = max(TM_LAG, T / 2)         in seconds
    /// LMN_P = P_SEL ? e : 0
    /// LMN_I = I[k-1] + q,  q = (((T / Ti) * (e + e[k-1])) * 0.5) + rest
    /// LMN_D = (e - w) * V,  V = Td / ((T * 0.5) + Tl),  w = w + (((T / Td) * LMN_D) + restD)
    /// u     = MAN_ON ? MAN : ((LMN_P + LMN_I) + LMN_D) + DISV
    /// y     = u within LMN_LLM ... LMN_HLM
    /// LMN   = (y * LMN_FAC) + LMN_OFF
    /// LMN_PER = low word of RND(LMN * 276.48)
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Restart (COM_RST): all outputs are 0 / FALSE, the integrator's memory is I_ITLVAL, all other memory is 0.
    ///    MAN, the limits, LMN_OFF and DISV have no effect. I_ITLVAL takes effect in the first automatic call after the
    ///    restart. The block does not reset COM_RST: while it is TRUE, every call is a restart. (manual)
    /// 2. Process value: PV_FAC and PV_OFF act on the analog value PV_PER only (manual). 100/27648 is multiplied as a
    ///    REAL; a division would differ in the last bit for one word in five (measured).
    /// 3. Dead band: ER = x + DEADB_W below -DEADB_W, x - DEADB_W above DEADB_W, else 0. (vendor)
    /// 4. P, I and D act on e = ER * GAIN (manual). If D is selected, a change of GAIN therefore kicks LMN_D once.
    /// 5. Times have lower bounds: TI is at least CYCLE / 2, TD at least CYCLE, TM_LAG at least CYCLE / 2. TI = 0 does
    ///    not switch the I action off; I_SEL does. (vendor)
    /// 6. Integral: trapezoidal rule; the round-off error of a call is added in the next one, so that small increments
    ///    on a large integral are not lost (vendor). INT_HOLD stops it. If the previous call, manual or automatic,
    ///    ended at a limit, the integral does not move further in that direction (anti-windup; vendor, observed).
    /// 7. The integral is held within LMN_LLM ... LMN_HLM, whatever P, D and DISV are. If I_ITL_ON, manual mode or
    ///    I_SEL has set it outside, it stays free until an automatic call finds it inside. (measured)
    /// 8. I_ITL_ON sets LMN_I = I_ITLVAL, in manual mode too (vendor); I_SEL = FALSE sets it to 0.
    /// 9. Manual mode: LMN follows MAN within the limits. The integral becomes y of the *previous* call - LMN_P - DISV,
    ///    so the change to automatic is bumpless if MAN was constant for two calls (manual; that it is the previous
    ///    call's: measured). With I_SEL off or I_ITL_ON on nothing is matched, and the change may bump.
    /// 10. Derivative: a first-order lag TM_LAG, step height e TD / (CYCLE / 2 + TM_LAG); in manual mode or with D_SEL
    ///     off it is 0 and follows e, so that switching it on is bumpless. (vendor, observed)
    /// 11. Limits: at or above LMN_HLM, y = LMN_HLM and only QLMN_HLM is TRUE; otherwise, at or below LMN_LLM, y =
    ///     LMN_LLM and only QLMN_LLM is TRUE. MAN is limited too. With the defaults LMN = 0 sets QLMN_LLM. (vendor,
    ///     measured)
    /// 12. LMN_PER is not clipped: LMN above 118.5 % wraps to a negative word (118.515 gives 32767, 118.52 gives
    ///     -32768, 150 gives -24064), below -118.5 % to a positive one. Keep both limits, times LMN_FAC plus LMN_OFF,
    ///     within -118.5 ... 118.5 %. (measured)
    ///
    /// # Sampling
    ///
    /// The block computes with CYCLE and must be called that often. After a restart, with constant e:
    /// `LMN_I(k) = I_ITLVAL + (T / Ti) e (k - 1/2)`, `LMN_D(k) = e V a^(k-1)` with `a = 1 - T / (T / 2 + Tl)`.
    ///
    /// If a host steps ten times CYCLE, the block makes ten calls in that step, all with the inputs from its beginning (or as
    /// the host extrapolates them), and the host sees the outputs of the last one. The integral then grows ten times on
    /// the same error, and LMN_D has decayed before the plant sees it, as if the sampling time were ten times as long. The
    /// loop of the quick start shows it: no overshoot at steps of 1 s, 8 % of the setpoint at steps of 10 s, and 33 % if
    /// the host exchanges all values before each step instead of stepping the controller first. So step CYCLE or a whole
    /// fraction of it. If a host steps a tenth of CYCLE, one step of ten makes a call; in the other nine the outputs keep
    /// their values and the inputs have no effect.
    ///
    /// # Limits of use
    ///
    /// Bad input: the block checks no parameter. An internal overflow may leave NaN in LMN; COM_RST clears it. If
    /// LMN_HLM is below LMN_LLM, LMN is one of the two, and LMN_I jumps between them.
    ///
    /// LMN_PER wraps beyond 118.5 % (clause 12), and PV_PER at 32767 or -32768 is a process value like any other: the
    /// block does not know a broken wire.
    ///
    /// The block has no setpoint ramp and no setpoint limits, no filter of the process value, no alarms and no limit on the
    /// slope of LMN. The D action acts on the error, so setpoint steps kick it. The change from automatic to manual mode
    /// is not bumpless: LMN jumps to MAN. A change of GAIN, P_SEL, PVPER_ON, LMN_FAC or LMN_OFF in
    /// automatic mode makes LMN jump.
    ///
    /// # Sources
    ///
    /// Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.1, figure 3-1,
    /// tables 3-1 and 3-2; recordings at the terminals of real blocks. The rule for GAIN and TI in the quick start is
    /// Skogestad's (SIMC), with the closed loop as slow as the dead time.
    pub struct ContC as "CONT_C" | "FB 41" | "SFB 41" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            ///
            /// While it is TRUE, every call is a restart: all outputs are 0 or FALSE, the integral becomes I_ITLVAL,
            /// and the rest of the memory is cleared. LMN is 0 then, even if LMN_LLM is 20. The block does not reset
            /// COM_RST. Every run begins with a restart; set COM_RST for a restart during the run, for example after a
            /// standstill or when LMN is NaN.
            com_rst: Bool = false;
            /// Manual mode: the loop is open and MAN is the manipulated value
            ///
            /// In manual mode LMN follows MAN within the limits, LMN_D is 0, and LMN_I is set so that LMN_P + LMN_I +
            /// DISV is the manipulated value of the previous call. That is why LMN does not jump when MAN_ON falls:
            /// with MAN = 40, ER = 10 and the start values GAIN 2 and TI 20 s, the first automatic call gives 41, one
            /// step of the integral more.
            ///
            /// LMN does jump if MAN has changed in the last manual call (it returns to the former value), if SP_INT,
            /// the process value, DISV or GAIN changes in the call in which MAN_ON falls, and if I_SEL is FALSE or
            /// I_ITL_ON is TRUE, because nothing is matched then. In the other direction LMN jumps to MAN: set MAN to
            /// LMN before.
            man_on: Bool = true;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// FALSE takes PV_IN as it is. TRUE takes the analog word PV_PER, converts it to percent and scales it by
            /// PV_FAC and PV_OFF. The other input has no effect. Take PV_IN if the plant model gives a physical value,
            /// and PV_PER if the steps of the analog input (0.0036 %) and its range are to be part of the simulation.
            /// Switching in automatic mode is a step of the process value: if the two differ by 5, LMN_P jumps by 10
            /// with GAIN 2.
            pvper_on: Bool = false;
            /// Proportional action on
            ///
            /// FALSE makes LMN_P 0; I and D action still act on GAIN * ER. A controller with I action alone suits
            /// plants that follow at once or have little but dead time: with ER = 10, GAIN 2 and TI 20 s, LMN moves by
            /// 1 per second. If P_SEL falls in automatic mode, LMN loses LMN_P at once; in manual mode LMN_I is matched
            /// to the new sum.
            p_sel: Bool = true;
            /// Integral action on
            ///
            /// FALSE sets LMN_I to 0 and leaves a P or PD controller, at which an error remains: with GAIN 2, a plant
            /// whose gain is 1 and SP_INT = 60, PV stops at 40, unless DISV supplies the manipulated value that the
            /// plant needs. If I_SEL falls in automatic mode, LMN loses LMN_I at once; if it rises, the integral starts
            /// from 0. While it is FALSE, the change from manual to automatic mode is not bumpless.
            i_sel: Bool = true;
        }
        input {
            /// Holds the integral action
            ///
            /// While it is TRUE, LMN_I keeps its value and P and D action go on; afterwards the integral continues from
            /// there. Use it while LMN has no effect for a reason that the block does not see: a closed gate, or, in
            /// the primary controller of a cascade, a secondary controller in manual mode. I_SEL = FALSE, I_ITL_ON and
            /// MAN_ON take precedence and set LMN_I. So do the limits: if LMN_HLM falls to 10, an LMN_I held at 30
            /// becomes 10.
            int_hold: Bool = false;
            /// Sets the integral action to I_ITLVAL
            ///
            /// While it is TRUE, LMN_I is I_ITLVAL, in manual mode too; with I_SEL = FALSE it has no effect. When it
            /// falls, the integral continues from there, even from beyond a limit: 120 stays 120 until the error brings
            /// it below LMN_HLM = 100. Use it to preset the integral, for example 40 before a batch is heated, or to
            /// hand LMN over from elsewhere, with I_ITLVAL = LMN - LMN_P - DISV. In manual mode it replaces the
            /// matching of LMN_I, so the change to automatic mode may bump.
            i_itl_on: Bool = false;
        }
        parameter {
            /// Derivative action on
            ///
            /// TRUE adds LMN_D, the lagged derivative of GAIN * ER. It makes loops with two or more lags faster and
            /// better damped, a temperature behind a slow sensor for example; where the process value is noisy, such as
            /// a flow, it mostly moves the actuator. It acts on the setpoint too: with GAIN 2, TD 10 s, TM_LAG 2 s and
            /// CYCLE 1 s, a setpoint step of 1 makes LMN_D 8. Switching it on is bumpless; switching it off takes LMN_D
            /// away at once.
            d_sel: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The block measures no time: it integrates and differentiates with CYCLE, so CYCLE must be the time
            /// between two calls. Called every 2 s with CYCLE = 1 s it would integrate at half the rate. Choose a tenth
            /// of the plant's time constant or less, 1 s for 10 s and more: sampling acts like an additional dead time
            /// of CYCLE / 2. TI and TM_LAG below CYCLE / 2 and TD below CYCLE are raised to these values.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// The value that PV is to reach, in the unit of PV: percent, or a physical unit. A step of 10 moves LMN_P
            /// by 20 with GAIN 2 in the next call and, with D_SEL and the start values, LMN_D by 80; a ramp before the
            /// setpoint avoids both. The block does not limit it: if the plant cannot reach the setpoint, LMN stays at
            /// a limit.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// The process value while PVPER_ON is FALSE, in the unit of SP_INT; PV_FAC and PV_OFF do not act on it.
            /// The block neither filters nor checks it: noise of 0.5 moves LMN_P by 1 with GAIN 2, and a value that
            /// fails to 0 is a large error that drives LMN to a limit.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// The process value while PVPER_ON is TRUE: PV = PV_PER * 100 / 27648 * PV_FAC + PV_OFF. One count is
            /// 0.0036 %; 32767 gives 118.51 %, -32768 gives -118.52 %, with PV_FAC 1 and PV_OFF 0. Analog inputs report
            /// overflow and underflow by these two words. The block takes them for process values, so check for a
            /// broken wire outside and switch to manual mode.
            pv_per: Word = Word::new(0);
            /// Manual value, -100 ... 100 % or a physical value
            ///
            /// LMN in manual mode, before the limits, LMN_FAC and LMN_OFF: 130 gives 100 with LMN_HLM = 100. In
            /// automatic mode it has no effect, but when MAN_ON rises, LMN jumps to it; keep it at LMN until then.
            /// LMN_I follows it one call later, so leave MAN unchanged for two calls before MAN_ON falls: if it goes
            /// from 40 to 50 in the last manual call, LMN returns to 40.
            man: Real = 0.0;
        }
        parameter {
            /// Proportional gain
            ///
            /// GAIN multiplies the error before it goes to all three parts: LMN_P is GAIN * ER, LMN_I grows by GAIN *
            /// ER in every TI, and LMN_D starts at GAIN * ER * TD / (TM_LAG + CYCLE / 2). An error step of 10 with the
            /// start values (GAIN 2, TI 20 s, TD 10 s, TM_LAG 2 s, CYCLE 1 s) gives LMN_P = 20, an LMN_I that rises by
            /// 1 per second, and LMN_D = 80 at first; GAIN 4 doubles each of them.
            ///
            /// Its unit is percent of LMN per unit of PV. If PV falls when LMN rises, as in cooling, GAIN must be
            /// negative. Begin with T / (2 K L): 2.5 for a plant with gain K = 2, time constant T = 100 s and dead time
            /// L = 10 s. A change of GAIN while there is an error moves LMN_P at once and kicks LMN_D once; LMN_I
            /// stays.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE
            ///
            /// The time in which LMN_I grows by GAIN * ER at a constant error: with GAIN 2, ER = 10 and TI = 20 s by 20
            /// in 20 s, 1 per second. A shorter TI removes an error faster, a too short one makes the loop oscillate.
            /// Begin with the plant's dominant time constant T, but at most 8 times its dead time L: 80 s for T = 100 s
            /// and L = 10 s. A TI below CYCLE / 2 counts as CYCLE / 2; TI = 0 does not switch the I action off, I_SEL
            /// does. A change of TI does not make LMN jump.
            ti: Time = Time::ms(20_000);
            /// Derivative time; range: TD >= CYCLE
            ///
            /// How far ahead the D action looks, with D_SEL: if the error changes by 0.5 per second, LMN_D settles at
            /// GAIN * TD * 0.5, 5 with GAIN 1 and TD = 10 s. Begin with half the plant's dead time or with its second
            /// largest time constant, 5 s for a dead time of 10 s, and stay below TI / 4. Choose TM_LAG along with it.
            /// A TD below CYCLE counts as CYCLE, so TD = 0 does not switch the D action off; D_SEL does.
            td: Time = Time::ms(10_000);
            /// Time lag of the derivative action; range: TM_LAG >= CYCLE / 2
            ///
            /// The time constant with which LMN_D decays. It limits the kick: at an error step LMN_D is TD / (TM_LAG +
            /// CYCLE / 2) times LMN_P, and each further call leaves the same share of it: 8, 4.8, 2.88 for GAIN * ER =
            /// 2, TD 10 s, TM_LAG 2 s, CYCLE 1 s. Choose TD / 10 ... TD / 5; larger if noise moves the actuator. A
            /// value below CYCLE / 2 counts as CYCLE / 2: the whole kick then falls into one call, 20, 0, 0.
            tm_lag: Time = Time::ms(2_000);
            /// Dead band: half the width of the band in which the error counts as 0
            ///
            /// While SP_INT - PV is within -DEADB_W ... DEADB_W, ER is 0; beyond, ER is smaller by DEADB_W, so that
            /// nothing jumps at the edge: a difference of 5 with DEADB_W = 2 gives ER = 3. PV may rest anywhere within
            /// the band. Use it against a limit cycle behind a coarse actuator: if the pulses resolve 1 % and the
            /// plant's gain is 2, PV moves in steps of 2, and 1 is enough. It has the unit of PV. 0 switches it off; a
            /// value below 0 makes every error larger.
            deadb_w: Real = 0.0, min 0.0;
            /// High limit of the manipulated value; range: LMN_LLM ... 100 % or a physical value
            ///
            /// The manipulated value is held at or below it, in manual mode too, before LMN_FAC and LMN_OFF. Once LMN
            /// is there, QLMN_HLM is TRUE and the integral does not rise further (anti-windup): LMN leaves the limit as
            /// soon as LMN_P or LMN_D falls, and not only after a grown integral has been worked off. LMN_I alone does
            /// not exceed it either, unless manual mode or I_ITL_ON has set it there. If LMN_HLM is lowered during a
            /// run, to 10 for example, LMN and LMN_I go down to 10 at once. Keep it above LMN_LLM, and if LMN_PER is
            /// used, keep LMN_HLM * LMN_FAC + LMN_OFF within 118.5 %.
            lmn_hlm: Real = 100.0;
            /// Low limit of the manipulated value; range: -100 % ... LMN_HLM or a physical value
            ///
            /// The manipulated value is held at or above it, in manual mode too, before LMN_FAC and LMN_OFF, and the
            /// integral does not fall further while LMN is there. The start value 0 is for actuators with one
            /// direction: heating and cooling, or negative pulses behind the block, need -100. With LMN_LLM = 0, LMN =
            /// 0 counts as at the limit and QLMN_LLM is TRUE. A restart gives LMN = 0 whatever it is.
            lmn_llm: Real = 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// PV is the percentage of PV_PER times PV_FAC plus PV_OFF. PV_FAC is the span of the transmitter divided
            /// by 100: 4 for 0 ... 400 degC, so that 13824 (50 %) reads 200. It does not act on PV_IN. GAIN is in
            /// percent of LMN per unit of PV: with PV_FAC = 4 instead of 1, a quarter of the GAIN gives the same loop.
            /// A change during a run is a step of the process value.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// What PV is at PV_PER = 0: for a transmitter whose 0 ... 27648 means -50 ... 150 degC, PV_OFF is -50 and
            /// PV_FAC 2, and 13824 reads 50. It can also correct a known error of the sensor. It does not act on PV_IN.
            /// A change during a run is a step of the process value: 1 moves LMN_P by 2 with GAIN 2.
            pv_off: Real = 0.0;
            /// Factor of the manipulated value
            ///
            /// LMN is the limited value times LMN_FAC plus LMN_OFF, so the limits and the integral know nothing of it.
            /// It is part of the loop's gain: with LMN_FAC = 0.5, the loop needs twice the GAIN. -1 with LMN_OFF = 100
            /// reverses an actuator: 30 becomes 70. LMN_PER is made of LMN, as percent: with LMN_FAC = 15 it wraps
            /// where the limited value passes 7.9. A change during a run makes LMN jump.
            lmn_fac: Real = 1.0;
            /// Offset of the manipulated value; LMN_PER wraps where LMN passes 118.5 %
            ///
            /// Added last, in manual mode too: MAN = 40 and LMN_OFF = 10 give LMN = 50. With LMN_FAC = 0.5 and LMN_OFF
            /// = 50, limits of -100 and 100 become 0 and 100. With LMN_HLM = 100 an offset of 20 allows LMN = 120, and
            /// LMN_PER is -32358 there: lower LMN_HLM by as much. After a restart LMN is 0, not LMN_OFF.
            lmn_off: Real = 0.0;
        }
        input {
            /// Value of the integral action at the restart and with I_ITL_ON, -100 ... 100 % or a physical value
            ///
            /// Where the integral starts after a restart, if the first call is an automatic one, and what it is while
            /// I_ITL_ON is TRUE. The first call adds half a step: with I_ITLVAL = 40, GAIN 2, TI 20 s, CYCLE 1 s and ER
            /// = 10, LMN_I is 40.5. Choose the LMN that the plant needs at its usual setpoint, 40 for a furnace that
            /// takes 40 % to stay hot. Beyond the limits it is held at the limit after a restart, 120 at 100; with
            /// I_ITL_ON it is not. A manual call after the restart discards it.
            i_itlval: Real = 0.0;
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// Added to the sum of P, I and D action in automatic mode: if it rises by 10, LMN rises by 10 in the same
            /// call, without an error. Connect a measured disturbance times the LMN that makes up for it: if 1 m3/h
            /// more needs 4 % more LMN, 4 times the flow. It has no dynamics of its own. The limits apply to the sum,
            /// and stop the integral there. In manual mode LMN_I is matched to it, so a constant DISV causes no bump.
            disv: Real = 0.0;
        }
        output {
            /// Manipulated value
            ///
            /// What the actuator gets: the limited sum, or MAN, times LMN_FAC plus LMN_OFF. With LMN_FAC 1 and LMN_OFF
            /// 0 it is LMN_P + LMN_I + LMN_D + DISV while neither QLMN_HLM nor QLMN_LLM is TRUE and MAN_ON is FALSE. It
            /// keeps its value between two calls and is 0 after a restart. If bad inputs have made it NaN, COM_RST
            /// clears that.
            lmn: Real;
            /// Manipulated value as an analog output word: 27648 is 100 %; wraps beyond 118.5 %
            ///
            /// LMN * 276.48, rounded to a whole number: 50 % is 13824, 100 % is 27648, one count 0.0036 %. It is not
            /// clipped. Up to 118.515 %, which is 32767, it rises; 118.52 % gives -32768 and 150 % gives -24064, which
            /// a valve reads as -87 %. Below -118.5 % it wraps to positive words. Keep both limits, times LMN_FAC plus
            /// LMN_OFF, within -118.5 ... 118.5 %. If LMN is a physical value, scale it to percent outside and leave
            /// LMN_PER unconnected.
            lmn_per: Word;
            /// The manipulated value is at its high limit
            ///
            /// TRUE if the value to be limited, MAN in manual mode, is LMN_HLM or more; the integral then does not rise
            /// in the next call. If it stays TRUE in automatic mode, the actuator is too weak for the setpoint or the
            /// limit too low. The comparison comes before LMN_FAC and LMN_OFF. QLMN_LLM is never TRUE at the same time,
            /// even if LMN_HLM is 10 and LMN_LLM 90.
            qlmn_hlm: Bool;
            /// The manipulated value is at its low limit
            ///
            /// TRUE if the value to be limited, MAN in manual mode, is LMN_LLM or less; the integral then does not fall
            /// in the next call. With LMN_LLM = 0 it is TRUE whenever that value is 0, as in the first call with all
            /// start values; that is no fault. It is compared before LMN_FAC and LMN_OFF.
            qlmn_llm: Bool;
            /// Proportional component of the manipulated value
            ///
            /// GAIN * ER, or 0 with P_SEL = FALSE. It is computed in manual mode too and is not limited: with GAIN 2
            /// and ER = 80 it is 160 while LMN stays at 100. Compare it with LMN_I and LMN_D to see which part moves
            /// the actuator.
            lmn_p: Real;
            /// Integral component of the manipulated value
            ///
            /// What the past errors have added up to. When the loop is at rest, ER and LMN_D are 0, and LMN_I + DISV is
            /// the LMN that the load needs. In automatic mode it stays within LMN_LLM ... LMN_HLM and stops while LMN
            /// is at a limit: with LMN_P = 80 and LMN_HLM = 100 it does not rise to 100, it stops as soon as the sum
            /// reaches 100. In manual mode it follows MAN - LMN_P - DISV one call later: with MAN = 40 and ER = 10 at
            /// GAIN 2 it is 20.
            lmn_i: Real;
            /// Derivative component of the manipulated value
            ///
            /// A kick at each change of the error, which decays with TM_LAG. At a constant error it returns to 0, and
            /// in manual mode or with D_SEL = FALSE it is 0. At an error that changes steadily it is GAIN * TD times
            /// the change per second, 5 for GAIN 1, TD 10 s and 0.5 per second. It is not limited.
            lmn_d: Real;
            /// Process value in use
            ///
            /// What is compared with SP_INT: PV_IN, or PV_PER scaled by PV_FAC and PV_OFF. Show this one, and not the
            /// input, to operators and alarms: a word of 13824 is 200 here with PV_FAC 4. It is computed in manual mode
            /// too, and is 0 from a restart until the first call.
            pv: Real;
            /// Error after the dead band
            ///
            /// SP_INT - PV, less DEADB_W: positive while PV is too low. With DEADB_W = 1 a difference of 3 is 2 here,
            /// and one of 0.5 is 0. GAIN is not in it. It is computed in manual mode too. If it stays away from 0 in
            /// automatic mode, LMN is at a limit, the I action is off or on hold, or the setpoint or a disturbance
            /// keeps changing.
            er: Real;
        }
    }
    memory Memory {
        /// Error times gain of the previous call.
        e: Real;
        /// Integral of the previous call.
        i: Real;
        /// Round-off error of the integral.
        rest: Real;
        /// The integral was set outside the limits and is not held within them until it is back inside.
        free: bool;
        /// Limited value of the previous call, before LMN_FAC and LMN_OFF.
        y: Real;
        /// Feedback of the derivative action: e after the time lag.
        w: Real;
        /// Round-off error of the feedback.
        rest_d: Real;
    }
}

impl Law for ContC {
    const RESPONSES: &'static [Response] = &[
        Response {
            title: "Setpoint step to 5, P, I and D action; the derivative time is 1 s, its lag 2 s",
            calls: 60,
            set: &[(0, "MAN_ON", 0.0), (0, "D_SEL", 1.0), (0, "TD", 1.0), (5, "SP_INT", 5.0), (40, "SP_INT", 0.0)],
            show: &["SP_INT", "LMN", "LMN_P", "LMN_I", "LMN_D"],
        },
        Response {
            title: "P action alone: LMN is GAIN = 2 times the error, and 0 when there is no error",
            calls: 60,
            set: &[
                (0, "MAN_ON", 0.0),
                (0, "I_SEL", 0.0),
                (5, "SP_INT", 10.0),
                (25, "SP_INT", 20.0),
                (45, "SP_INT", 0.0),
            ],
            show: &["SP_INT", "LMN"],
        },
        Response {
            title: "P and I action: at a constant error LMN_I grows by LMN_P in every TI = 20 s, and it keeps its value when \
                    the error is gone",
            calls: 60,
            set: &[(0, "MAN_ON", 0.0), (5, "SP_INT", 10.0), (45, "SP_INT", 0.0)],
            show: &["SP_INT", "LMN", "LMN_P", "LMN_I"],
        },
        Response {
            title: "GAIN rises from 1 to 2 at a constant error of 10: LMN_P doubles at once, LMN_I grows twice as fast from \
                    then on, LMN_D kicks once",
            calls: 60,
            set: &[
                (0, "MAN_ON", 0.0),
                (0, "D_SEL", 1.0),
                (0, "TD", 5.0),
                (0, "GAIN", 1.0),
                (5, "SP_INT", 10.0),
                (30, "GAIN", 2.0),
            ],
            show: &["GAIN", "LMN_P", "LMN_I", "LMN_D"],
        },
        Response {
            title: "P, I and D action at a limit: LMN_I stops while LMN is at 100, and LMN leaves the limit in the call in \
                    which the error changes its sign",
            calls: 80,
            set: &[(0, "MAN_ON", 0.0), (0, "D_SEL", 1.0), (0, "TD", 1.0), (5, "SP_INT", 40.0), (40, "SP_INT", -5.0)],
            show: &["SP_INT", "LMN", "LMN_P", "LMN_I", "LMN_D", "QLMN_HLM", "QLMN_LLM"],
        },
        Response {
            title: "MAN_ON falls after 20 s: LMN goes on from 40 without a jump, because LMN_I is already MAN - LMN_P",
            calls: 60,
            set: &[(0, "MAN", 40.0), (0, "SP_INT", 5.0), (20, "MAN_ON", 0.0)],
            show: &["LMN", "LMN_P", "LMN_I", "MAN_ON"],
        },
        Response {
            title: "MAN jumps from 40 to 60 in the last manual call: LMN returns to 40, because LMN_I follows MAN one call \
                    later; when MAN_ON rises again, LMN jumps to MAN",
            calls: 60,
            set: &[(0, "MAN", 40.0), (0, "SP_INT", 5.0), (19, "MAN", 60.0), (20, "MAN_ON", 0.0), (40, "MAN_ON", 1.0)],
            show: &["MAN", "LMN", "LMN_I", "MAN_ON"],
        },
        Response {
            title: "INT_HOLD stops LMN_I, and I_ITL_ON sets it to I_ITLVAL = 40, from where it goes on",
            calls: 60,
            set: &[
                (0, "MAN_ON", 0.0),
                (0, "SP_INT", 5.0),
                (0, "I_ITLVAL", 40.0),
                (15, "INT_HOLD", 1.0),
                (30, "INT_HOLD", 0.0),
                (45, "I_ITL_ON", 1.0),
                (50, "I_ITL_ON", 0.0),
            ],
            show: &["LMN", "LMN_I", "INT_HOLD", "I_ITL_ON"],
        },
        Response {
            title: "Dead band DEADB_W = 2: a difference of 2 counts as no error, one of 5 as 3",
            calls: 60,
            set: &[
                (0, "DEADB_W", 2.0),
                (5, "SP_INT", 1.0),
                (15, "SP_INT", 2.0),
                (25, "SP_INT", 5.0),
                (40, "SP_INT", -5.0),
                (50, "SP_INT", 0.0),
            ],
            show: &["SP_INT", "ER"],
        },
        Response {
            title: "LMN_PER is 27648 at 100 % and wraps to the other sign where LMN passes 118.5 % or -118.5 %",
            calls: 60,
            set: &[
                (0, "LMN_HLM", 200.0),
                (0, "LMN_LLM", -200.0),
                (0, "MAN", 50.0),
                (10, "MAN", 100.0),
                (20, "MAN", 118.0),
                (30, "MAN", 120.0),
                (40, "MAN", 150.0),
                (50, "MAN", -120.0),
            ],
            show: &["LMN", "LMN_PER"],
        },
    ];

    const CHARACTERISTICS: &'static [Characteristic] = &[
        Characteristic {
            title: "Dead band DEADB_W = 10: ER is 0 up to a difference of 10 and begins at 0 beyond it",
            variable: "SP_INT",
            range: (-50.0, 50.0),
            points: 101,
            calls: 1,
            set: &[("DEADB_W", 10.0)],
            show: &["ER"],
        },
        Characteristic {
            title: "Limits 0 and 80, LMN_FAC = 0.5, LMN_OFF = 10: LMN goes from 10 to 50, and the limits act before the factor",
            variable: "MAN",
            range: (-50.0, 150.0),
            points: 201,
            calls: 1,
            set: &[("LMN_HLM", 80.0), ("LMN_FAC", 0.5), ("LMN_OFF", 10.0)],
            show: &["LMN"],
        },
        Characteristic {
            title: "LMN_PER rises with LMN between -118.5 and 118.5 %, and wraps to the other sign beyond",
            variable: "MAN",
            range: (-150.0, 150.0),
            points: 601,
            calls: 1,
            set: &[("LMN_HLM", 200.0), ("LMN_LLM", -200.0)],
            show: &["LMN_PER"],
        },
    ];

    fn restart(&mut self) {
        self.clear();
        self.memory.i = self.i_itlval;
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        let e = self.er * self.gain;

        self.lmn_p = if self.p_sel { e } else { 0.0 };
        self.lmn_i = self.integral(e);
        self.lmn_d = self.derivative(e);
        let u = if self.man_on { self.man } else { ((self.lmn_p + self.lmn_i) + self.lmn_d) + self.disv };

        self.qlmn_hlm = u >= self.lmn_hlm;
        self.qlmn_llm = !self.qlmn_hlm && u <= self.lmn_llm;
        let y = if self.qlmn_hlm {
            self.lmn_hlm
        } else if self.qlmn_llm {
            self.lmn_llm
        } else {
            u
        };
        self.lmn = (y * self.lmn_fac) + self.lmn_off;
        self.lmn_per = Word::new(analog_output(self.lmn));

        self.memory.e = e;
        self.memory.i = self.lmn_i;
        self.memory.y = y;
    }

    fn advice(&self) -> Vec<String> {
        advice::cont_c(self, "")
    }
}

impl ContC {
    /// INT: the integral after this call.
    fn integral(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        let put = if !self.i_sel {
            Some(0.0)
        } else if self.i_itl_on {
            Some(self.i_itlval)
        } else if self.man_on {
            Some((memory.y - self.lmn_p) - self.disv)
        } else {
            None
        };
        if let Some(i) = put {
            memory.rest = 0.0;
            memory.free = true;
            return i;
        }

        let t = self.cycle.seconds();
        let ti = self.ti.seconds().max(t * 0.5);
        let mut q = (((t / ti) * (e + memory.e)) * 0.5) + memory.rest;
        // The limit outputs are still those of the previous call.
        if self.int_hold || (q > 0.0 && self.qlmn_hlm) || (q < 0.0 && self.qlmn_llm) {
            q = 0.0;
        }
        let i = memory.i + q;
        memory.rest = (memory.i - i) + q;
        let limit = if i > self.lmn_hlm {
            self.lmn_hlm
        } else if i < self.lmn_llm {
            self.lmn_llm
        } else {
            memory.free = false;
            return i;
        };
        memory.rest = 0.0;
        if memory.free { i } else { limit }
    }

    /// DIF: the derivative component of this call.
    fn derivative(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        if !self.d_sel || self.man_on {
            memory.rest_d = 0.0;
            memory.w = e;
            return 0.0;
        }
        let t = self.cycle.seconds();
        let td = self.td.seconds().max(t);
        let tl = self.tm_lag.seconds().max(t * 0.5);
        let v = td / ((t * 0.5) + tl);
        let d = (e - memory.w) * v;
        let q = ((t / td) * d) + memory.rest_d;
        let w = q + memory.w;
        memory.rest_d = (memory.w - w) + q;
        memory.w = w;
        d
    }
}

/// CRP_OUT: a manipulated value as an analog word.
fn analog_output(lmn: Real) -> Int {
    low_word(rnd(lmn * 276.48))
}

#[cfg(test)]
mod tests;
