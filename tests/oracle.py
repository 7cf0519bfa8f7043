"""The laws of the blocks, written a second time.

The library computes every block in Rust. This module computes the same blocks again, in
Python, from the documents and not from the Rust text, so that random runs can hold two
independent texts against each other, bit for bit. It is meant to be read: each `call`
follows the signal through the block from the inputs to the outputs.

What the laws rest on:

* CONT_C and CONT_S are measured. Every recording in `traces/`, taken call by call at the
  terminals of a real block, comes out of the laws below to the last bit. Where the manual
  is silent or says something else (the integral's clamp, the peripheral value that wraps,
  which LMN manual mode matches to, the numbers in CONT_S's thresholds and in its
  integrator), the measurement decides.
* PULSEGEN and PULS_CTR are documented by the manual of the PID control blocks (1996).
  Our decisions: a new period begins in the call after the one that noticed a changed INV;
  the ratio factor scales the upper threshold and the full pulse as it does the lower
  threshold; inside PULS_CTR the controller starts in automatic and on PV_PER.
  That halves round to the even number of calls is measured.
* HLG is documented by ABB's library page. Our decisions: the pins SET and INIT, which the
  page describes without a name; FALSE selects S0; a ramp of no calls is a jump; a
  remainder makes the integer ramp arrive in exactly the calls that were asked for.

Numbers: a REAL is a numpy.float32, and every single operation rounds to it (each constant
is one too, so that no version of numpy widens an expression). A TIME is a whole number of
milliseconds, WORD and INT are signed 16-bit numbers.

Names: inputs and outputs bear the PLC's names in capitals, what a block remembers from call
to call is in lower case. Assign through `set`, which converts to the terminal's type.
The mean outputs belong to the FMU and are not here.
"""

import numpy as np

REAL = np.float32
TIME = int
BOOL = bool


def low_word(value):
    """The low 16 bits as a signed number: how WORD and INT take any integer."""
    return ((int(value) + 0x8000) & 0xFFFF) - 0x8000


def WORD(value):
    return low_word(value)


def INT(value):
    return low_word(value)

ZERO, ONE, HALF, TENTH, HUNDREDTH = REAL(0), REAL(1), REAL(0.5), REAL(0.1), REAL(0.01)
TEN, FIFTY_FIVE, HUNDRED, THOUSAND = REAL(10), REAL(55), REAL(100), REAL(1000)
# Measured: one multiplication by the binary32 number nearest to 100 / 27648, no division.
PERCENT_PER_WORD = REAL(0.003616898)
WORD_PER_PERCENT = REAL(276.48)

# Numbers may become infinite or NaN, as in the PLC. No warning then; one for a division by zero.
calculation = np.errstate(over="ignore", invalid="ignore")


def seconds(time):
    return REAL(time) / THOUSAND


def rnd(value):
    """The S7 instruction RND: REAL to a 32-bit integer, halves to the even neighbour.

    Measured: what does not fit is not converted, its bits stay. NaN gives all ones.
    """
    if np.isnan(value):
        return -1
    nearest = np.rint(value)
    if -(2.0**31) <= nearest < 2.0**31:
        return int(nearest)
    return int(value.view(np.int32))


def process_value_and_error(block):
    """PV and ER, the branch that CONT_C and CONT_S have in common."""
    if block.PVPER_ON:
        percent = REAL(block.PV_PER) * PERCENT_PER_WORD
        block.PV = percent * block.PV_FAC + block.PV_OFF
    else:
        block.PV = block.PV_IN
    error = block.SP_INT - block.PV
    if error < -block.DEADB_W:
        block.ER = error + block.DEADB_W
    elif error > block.DEADB_W:
        block.ER = error - block.DEADB_W
    else:
        block.ER = ZERO


def terminals(data_type, **starts):
    return {name: (data_type, start) for name, start in starts.items()}


class Block:
    """Terminals by name; INPUTS and OUTPUTS say the type and the start value of each."""

    INPUTS = {}
    OUTPUTS = {}
    # The FMU's output that tells the mean of the pulses, if it has one; `pulse` is that of one call: +1, -1 or 0.
    MEAN = None

    def __init__(self):
        for name, (data_type, start) in self.INPUTS.items():
            setattr(self, name, data_type(start))
        self.clear()

    def clear(self):
        """All outputs and all memory 0 or FALSE."""
        for name, (data_type, start) in self.OUTPUTS.items():
            setattr(self, name, data_type(start))
        self.clear_memory()

    def clear_memory(self):
        raise NotImplementedError

    def restart(self):
        """The call that an FMU makes when initialization ends."""
        before, self.COM_RST = self.COM_RST, True
        self.call()
        self.COM_RST = before

    def owner_of(self, name):
        """The block that has the terminal, and the terminal's own name: `DI_CONT_C.GAIN` lies in
        a block inside this one."""
        block = self
        *path, terminal = name.split(".")
        for step in path:
            block = vars(block).get(step)
        if not isinstance(block, Block) or not (
            terminal in block.INPUTS or terminal in block.OUTPUTS
        ):
            raise KeyError(f"{type(self).__name__} has no terminal {name}: see INPUTS and OUTPUTS")
        return block, terminal

    def set(self, name, value):
        block, terminal = self.owner_of(name)
        if terminal in block.OUTPUTS:
            raise KeyError(f"{name} is an output of {type(block).__name__}; only inputs can be set")
        data_type, _ = block.INPUTS[terminal]
        setattr(block, terminal, data_type(value))

    def get(self, name):
        block, terminal = self.owner_of(name)
        return getattr(block, terminal)


class CONT_C(Block):
    """FB 41, the continuous PID controller."""

    INPUTS = {
        **terminals(BOOL, COM_RST=False, MAN_ON=True, PVPER_ON=False, P_SEL=True, I_SEL=True),
        **terminals(BOOL, INT_HOLD=False, I_ITL_ON=False, D_SEL=False),
        **terminals(TIME, CYCLE=1000, TI=20000, TD=10000, TM_LAG=2000),
        **terminals(REAL, SP_INT=0.0, PV_IN=0.0, MAN=0.0, GAIN=2.0, DEADB_W=0.0),
        **terminals(REAL, LMN_HLM=100.0, LMN_LLM=0.0, PV_FAC=1.0, PV_OFF=0.0),
        **terminals(REAL, LMN_FAC=1.0, LMN_OFF=0.0, I_ITLVAL=0.0, DISV=0.0),
        **terminals(WORD, PV_PER=0),
    }
    OUTPUTS = {
        **terminals(REAL, LMN=0.0, LMN_P=0.0, LMN_I=0.0, LMN_D=0.0, PV=0.0, ER=0.0),
        **terminals(WORD, LMN_PER=0),
        **terminals(BOOL, QLMN_HLM=False, QLMN_LLM=False),
    }

    def clear_memory(self):
        self.e_last = ZERO  # e of the last call
        self.i_last = ZERO  # I of the last call; after a restart I_ITLVAL
        self.y_last = ZERO  # the limited value of the last call, before LMN_FAC and LMN_OFF
        self.rest = ZERO  # what rounding took from the integral
        self.free = False  # the clamp is disarmed: the integral was put where it is
        self.w = ZERO  # the lagged error of the D action
        self.rest_d = ZERO  # what rounding took from w

    @calculation
    def call(self):
        if self.COM_RST:
            self.clear()
            self.i_last = self.I_ITLVAL  # LMN_I is 0 all the same (measured)
            return
        process_value_and_error(self)
        e = self.ER * self.GAIN
        self.LMN_P = e if self.P_SEL else ZERO
        self.LMN_I = self.integral(e)
        self.LMN_D = self.derivative(e)
        self.e_last = e
        self.i_last = self.LMN_I

        if self.MAN_ON:
            u = self.MAN
        else:
            u = ((self.LMN_P + self.LMN_I) + self.LMN_D) + self.DISV
        # Reaching a limit already reports it, and the high limit is asked first.
        self.QLMN_HLM = bool(u >= self.LMN_HLM)
        self.QLMN_LLM = bool(not self.QLMN_HLM and u <= self.LMN_LLM)
        if self.QLMN_HLM:
            y = self.LMN_HLM
        elif self.QLMN_LLM:
            y = self.LMN_LLM
        else:
            y = u
        self.y_last = y
        self.LMN = (y * self.LMN_FAC) + self.LMN_OFF
        self.LMN_PER = low_word(rnd(self.LMN * WORD_PER_PERCENT))  # not clipped (measured)

    def integral(self, e):
        """The I action. QLMN_HLM and QLMN_LLM still are those of the last call here."""
        if not self.I_SEL or self.I_ITL_ON or self.MAN_ON:
            self.rest = ZERO
            self.free = True
            if not self.I_SEL:
                return ZERO
            if self.I_ITL_ON:
                return self.I_ITLVAL
            return (self.y_last - self.LMN_P) - self.DISV  # one call late (measured)

        t = seconds(self.CYCLE)
        ti = max(seconds(self.TI), t * HALF)
        q = (((t / ti) * (e + self.e_last)) * HALF) + self.rest
        winds_up = (q > ZERO and self.QLMN_HLM) or (q < ZERO and self.QLMN_LLM)
        if self.INT_HOLD or winds_up:
            q = ZERO
        integral = self.i_last + q
        self.rest = (self.i_last - integral) + q

        # Measured: the clamp holds the I action alone within the limits, whatever P, D and DISV
        # are, but leaves an integral that was put outside alone until it has come back.
        passed_high = integral > self.LMN_HLM
        passed_low = integral < self.LMN_LLM
        if not (passed_high or passed_low):
            self.free = False
            return integral
        self.rest = ZERO
        if self.free:
            return integral
        return self.LMN_HLM if passed_high else self.LMN_LLM

    def derivative(self, e):
        if not self.D_SEL or self.MAN_ON:
            self.w = e  # matched, so that switching on does not kick
            self.rest_d = ZERO
            return ZERO
        t = seconds(self.CYCLE)
        td = max(seconds(self.TD), t)
        lag = max(seconds(self.TM_LAG), t * HALF)
        d = (e - self.w) * (td / ((t * HALF) + lag))
        q = ((t / td) * d) + self.rest_d
        w = q + self.w
        self.rest_d = (self.w - w) + q
        self.w = w
        return d


class CONT_S(Block):
    """FB 42, the PI step controller for a motor-driven valve without position feedback."""

    INPUTS = {
        **terminals(BOOL, COM_RST=False, LMNR_HS=False, LMNR_LS=False),
        **terminals(BOOL, LMNS_ON=False, LMNUP=False, LMNDN=False, PVPER_ON=False),
        **terminals(TIME, CYCLE=1000, TI=20000, PULSE_TM=3000, BREAK_TM=3000, MTR_TM=30000),
        **terminals(REAL, SP_INT=0.0, PV_IN=0.0, GAIN=2.0, DEADB_W=1.0),
        **terminals(REAL, PV_FAC=1.0, PV_OFF=0.0, DISV=0.0),
        **terminals(WORD, PV_PER=0),
    }
    OUTPUTS = {
        **terminals(BOOL, QLMNUP=False, QLMNDN=False),
        **terminals(REAL, PV=0.0, ER=0.0),
    }
    MEAN = "QLMN_MEAN"

    def clear_memory(self):
        self.a = 0  # the running pulse: +1 up, -1 down, 0 none
        self.f = ZERO  # the one integrator: assumed valve position less the I action
        self.on = ZERO  # the adapted switch-on threshold
        self.pulse_timer = 0  # ms of the minimum pulse still to come
        self.break_timer = 0  # ms of the minimum break still to come

    @calculation
    def call(self):
        if self.COM_RST:
            self.clear()
            return
        process_value_and_error(self)
        e = self.ER * self.GAIN
        t = seconds(self.CYCLE)
        motor = max(seconds(self.MTR_TM), t)
        self.integrate(e, t, motor)
        self.adapt_threshold(e, motor)
        self.pulse_stage(self.demand(e, t, motor))
        self.QLMNUP = self.a == +1
        self.QLMNDN = self.a == -1

    def pulse(self):
        return int(self.QLMNUP) - int(self.QLMNDN)

    def at_stop(self, direction):
        """Is the valve reported at the stop that lies in this direction?"""
        return (direction > 0 and self.LMNR_HS) or (direction < 0 and self.LMNR_LS)

    def integrate(self, e, t, motor):
        if self.LMNS_ON:
            self.f = ZERO
        elif self.a != 0:
            self.f = self.f + (((HUNDRED * REAL(self.a)) * t) / motor)
        elif self.TI > 0 and not self.at_stop(e):
            # Measured: the error counts in the pauses only, with a reset time that is shorter
            # by what the pulses take.
            ti = max(seconds(self.TI), t * HALF)
            pauses_only = max(ti - abs((HUNDREDTH * e) * motor), TENTH * ti)
            self.f = self.f - ((e * t) / pauses_only)
        if self.TI == 0:  # without the I action f is the position and nothing else
            self.f = min(max(self.f, ZERO), HUNDRED)

    def adapt_threshold(self, e, motor):
        """Few pulses while the error is large, fine ones near the setpoint; also in manual."""
        lowest = (HUNDRED * seconds(max(self.PULSE_TM, self.CYCLE))) / motor
        if self.LMNR_HS or self.LMNR_LS:
            self.on = lowest
        elif self.a == 0:
            if self.TI > 0:
                want = min(abs(e), abs(self.f))
            else:
                want = ZERO if self.PV == ZERO else abs(e) * HALF
            self.on = max(min(want, TEN), lowest)

    def demand(self, e, t, motor):
        """The three-step element, or the manual signals in its place."""
        if self.LMNS_ON:
            demand = int(self.LMNUP) - int(self.LMNDN)
        else:
            z = (e - self.f) + self.DISV
            off = (FIFTY_FIVE * t) / motor
            if (self.a == +1 and z > off) or z >= self.on:
                demand = +1
            elif (self.a == -1 and z < -off) or z <= -self.on:
                demand = -1
            else:
                demand = 0
        if self.at_stop(demand) or demand * self.a == -1:
            return 0
        return demand

    def pulse_stage(self, demand):
        """Minimum pulse and minimum break, for manual pulses too."""
        against_stop = self.at_stop(self.a)
        if self.a != 0 and (against_stop or (demand == 0 and self.pulse_timer == 0)):
            # Measured: a stop inside the minimum pulse asks for no break.
            cut_short = against_stop and self.pulse_timer > 0
            self.break_timer = 0 if cut_short else self.BREAK_TM
            self.pulse_timer = 0
            self.a = 0
        elif self.a == 0 and demand != 0 and self.break_timer == 0:
            self.a = demand
            self.pulse_timer = self.PULSE_TM
        self.pulse_timer = max(0, self.pulse_timer - self.CYCLE)
        self.break_timer = max(0, self.break_timer - self.CYCLE)


class PULSEGEN(Block):
    """FB 43, pulse duration modulation."""

    INPUTS = {
        **terminals(REAL, INV=0.0, RATIOFAC=1.0),
        **terminals(TIME, PER_TM=1000, P_B_TM=50, CYCLE=10),
        **terminals(BOOL, STEP3_ON=True, ST2BI_ON=False, SYN_ON=True, COM_RST=False),
        **terminals(BOOL, MAN_ON=False, POS_P_ON=False, NEG_P_ON=False),
    }
    OUTPUTS = terminals(BOOL, QPOS_P=False, QNEG_P=False)
    MEAN = "Q_MEAN"

    def clear_memory(self):
        self.inv_last = ZERO  # INV of the last call
        self.r = 0  # calls left in the period
        self.k = 0  # calls left in the pulse
        self.negative = False  # the pulse's polarity

    @calculation
    def call(self):
        if self.COM_RST:
            self.clear()  # both outputs FALSE in two-step mode too, as the manual says
        elif self.MAN_ON:
            self.manual()
        else:
            self.automatic()
        self.inv_last = self.INV

    def pulse(self):
        """With two steps QNEG_P is no pulse, only the opposite of QPOS_P."""
        return int(self.QPOS_P) - int(self.QNEG_P and self.STEP3_ON)

    def manual(self):
        if self.STEP3_ON:
            self.QPOS_P = self.POS_P_ON and not self.NEG_P_ON
            self.QNEG_P = self.NEG_P_ON and not self.POS_P_ON
        else:
            self.QPOS_P = self.POS_P_ON
            self.QNEG_P = not self.POS_P_ON
        self.r = 0

    def automatic(self):
        inv_changed = self.INV < self.inv_last or self.INV > self.inv_last
        if self.r <= 0:
            self.r = max(0, rnd(REAL(self.PER_TM) / REAL(self.CYCLE)))
            self.k = rnd(self.pulse_width() / REAL(self.CYCLE))
        elif self.SYN_ON and inv_changed and self.r > 2:
            self.r = 1  # decided: this call is the last of the old period
        on = self.k > 0
        if self.STEP3_ON:
            self.QPOS_P = on and not self.negative
            self.QNEG_P = on and self.negative
        else:
            self.QPOS_P = on
            self.QNEG_P = not on
        self.r = self.r - 1
        self.k = max(0, self.k - 1)

    def pulse_width(self):
        """The pulse in ms. Sets the polarity."""
        period = REAL(self.PER_TM)
        shortest = REAL(self.P_B_TM)
        offset = ZERO
        scale = ONE  # decided: of the upper threshold and of the full pulse too
        self.negative = False
        if self.STEP3_ON:
            if self.INV > ZERO:
                factor = ONE / self.RATIOFAC if self.RATIOFAC > ONE else ONE
            else:
                factor = ONE if self.RATIOFAC > ONE else self.RATIOFAC
                self.negative = True
            scale = factor
        elif self.ST2BI_ON:
            if self.INV < -HUNDRED:
                factor = ZERO
            else:
                factor = HALF
                offset = HALF * period
        else:
            factor = ZERO if self.INV < ZERO else ONE

        width = abs((((self.INV * factor) * period) * HUNDREDTH) + offset)
        if width > scale * (period - shortest):
            return scale * period
        if width < scale * shortest:
            return ZERO
        return width


class PULS_CTR(Block):
    """The manual's example: CONT_C every RED_FAC calls, PULSEGEN in every call."""

    INPUTS = {
        **terminals(REAL, SP_INT=0.0),
        **terminals(WORD, PV_PER=0),
        **terminals(INT, RED_FAC=200),
        **terminals(BOOL, COM_RST=False),
        **terminals(TIME, CYCLE=10),
    }
    OUTPUTS = terminals(BOOL, QPOS_P=False)
    MEAN = "Q_MEAN"

    def __init__(self):
        super().__init__()
        self.DI_CONT_C = CONT_C()
        self.DI_PULSEGEN = PULSEGEN()
        # Decided: with the controller's own defaults the example could not control anything.
        self.DI_CONT_C.PVPER_ON = True
        self.DI_CONT_C.MAN_ON = False

    def clear_memory(self):
        self.scount = 0  # calls until CONT_C is called again

    def call(self):
        controller, generator = self.DI_CONT_C, self.DI_PULSEGEN
        if self.COM_RST:
            self.scount = 0
        sampling_time = self.CYCLE * self.RED_FAC
        self.scount = self.scount - 1
        if self.scount <= 0:
            controller.COM_RST = self.COM_RST
            controller.CYCLE = sampling_time
            controller.SP_INT = self.SP_INT
            controller.PV_PER = self.PV_PER
            controller.call()
            self.scount = self.RED_FAC
        generator.INV = controller.LMN
        generator.PER_TM = sampling_time
        generator.COM_RST = self.COM_RST
        generator.CYCLE = self.CYCLE
        generator.call()
        self.QPOS_P = generator.QPOS_P

    def pulse(self):
        return self.DI_PULSEGEN.pulse()


class HLG(Block):
    """The ramp function generator of ABB's Serie90 library, in whole numbers."""

    INPUTS = {
        **terminals(BOOL, E01=False, STOP=False, SET=False, R=False),
        **terminals(INT, S0=0, S1=0, TH_TZ=0, TR_TZ=0, INIT=0),
        **terminals(TIME, TZ=10),
    }
    OUTPUTS = terminals(INT, HLG=0)

    restart = Block.clear

    def clear_memory(self):
        self.remainder = 0  # what the last step's division left
        self.ramp = None  # setpoint, direction and calls of the ramp it belongs to

    def call(self):
        if self.STOP:
            return
        if self.SET:
            self.HLG = max(-32767, self.INIT)
            self.remainder = 0
            return
        if self.R:
            self.HLG = 0
            self.remainder = 0
            return

        w = max(-32767, self.S1 if self.E01 else self.S0)
        if w == 0 or w == self.HLG:  # a setpoint of 0 means no slope
            self.remainder = 0
            return
        direction = +1 if w > self.HLG else -1
        n = self.TH_TZ if direction > 0 else self.TR_TZ
        if n <= 0:
            self.HLG = w
            self.remainder = 0
            return
        if self.ramp != (w, direction, n):
            self.ramp = (w, direction, n)
            self.remainder = 0
        step, self.remainder = divmod(abs(w) + self.remainder, n)
        if step >= abs(w - self.HLG):
            self.HLG = w
            self.remainder = 0
        else:
            self.HLG = self.HLG + direction * step


# All of them by name.
BLOCKS = {block.__name__: block for block in Block.__subclasses__()}
