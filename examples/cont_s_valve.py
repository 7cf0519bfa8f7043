"""Motor-driven valve and heat exchanger with CONT_S: in automatic mode, in manual mode, and against
the limit stop.

    setpoint --SP_INT-----> CONT_S --QLMNUP--> UP    VALVE --TEMP--+
    by hand --LMNS_ON-->           --QLMNDN--> DOWN    ^           |
              LMNUP       ^  ^                        PRES         |
              LMNDN       |  +--LMNR_HS, LMNR_LS-------------------+
                          +-----PV_IN------------------------------+

CONT_S infers the position only from how long it has run the motor (MTR_TM) and from the two limit
switches. LMNR of VALVE is the position that results from the pulses.

Call order: every 100 ms, CONT_S is called with the temperature and limit switches at t, then the
valve is stepped to t + 100 ms with the pulses of this call.

Tuning: SIMC's PI rule for the exchanger's gain of 0.8 K/% and its lags of 20 s and 5 s, for a
closed loop with LAMBDA = 12 s. A pulse of PULSE_TM = 300 ms moves the valve by 1 % and the
temperature by 0.8 K; a dead band of 0.5 K on either side is more than half of that, so there is
always a position within it.

Theory: a setpoint step has a rise time of about 2.2 LAMBDA; the pulses approximate the PI law in
steps of 1 %, so times agree within a fifth. In steady state the temperature is within the dead band, and no
more pulses are output. A setpoint that cannot be reached drives the valve to its upper stop; there
LMNR_HS ends the pulse, and the integrator is held (only the proportional component, which shrinks
as the temperature rises, briefly moves the valve off the stop). So the valve starts closing
immediately at the next setpoint.
"""

import numpy as np

import plcfmu
from plcfmu import plot

CYCLE = 0.1
K, T1, T2 = 0.8, 20.0, 5.0
LAMBDA = 12.0
THETA = T2 / 2 + 0.3 + CYCLE / 2  # a minimum pulse or break counts as delay
GAIN = (T1 + T2 / 2) / (K * (LAMBDA + THETA))
TI = T1 + T2 / 2
PULSE_TM, MTR_TM, DEADB_W = 0.3, 30.0, 0.5

STEP, DROP, MANUAL, AUTOMATIC, TOO_HIGH, BACK, END = 20.0, 120.0, 240.0, 280.0, 400.0, 480.0, 600.0
BY_HAND_UP, BY_HAND_DOWN = (245.0, 257.0), (265.0, 268.0)


def run(fmus):
    """A setpoint step; a pressure drop; manually to the upper stop and back; a setpoint out of reach; and back."""
    controller = fmus.start(
        "CONT_S", CYCLE=CYCLE, GAIN=GAIN, TI=TI, DEADB_W=DEADB_W, PULSE_TM=PULSE_TM, BREAK_TM=PULSE_TM, MTR_TM=MTR_TM
    )
    valve = fmus.start("VALVE", CYCLE=CYCLE, MTR_TM=MTR_TM, POS_START=50.0, T_START=60.0)
    of_controller = "SP_INT PV ER QLMNUP QLMNDN LMNR_HS LMNR_LS LMNS_ON LMNUP LMNDN"
    result = plcfmu.simulate(
        controller,
        valve,
        {
            "CONT_S.QLMNUP": "VALVE.UP",
            "CONT_S.QLMNDN": "VALVE.DOWN",
            "VALVE.TEMP": "CONT_S.PV_IN",
            "VALVE.LMNR_HS": "CONT_S.LMNR_HS",
            "VALVE.LMNR_LS": "CONT_S.LMNR_LS",
        },
        inputs={
            "CONT_S.SP_INT": [(0.0, 60.0), (STEP, 70.0), (TOO_HIGH, 95.0), (BACK, 70.0)],
            "CONT_S.LMNS_ON": lambda t: MANUAL <= t < AUTOMATIC,
            "CONT_S.LMNUP": lambda t: BY_HAND_UP[0] <= t < BY_HAND_UP[1],
            "CONT_S.LMNDN": lambda t: BY_HAND_DOWN[0] <= t < BY_HAND_DOWN[1],
            "VALVE.PRES": [(0.0, 4.0), (DROP, 3.0)],
        },
        record={
            **{name: f"CONT_S.{name}" for name in of_controller.split()},
            "LMNR": "VALVE.LMNR",
            "PRES": "VALVE.PRES",
        },
        step=CYCLE,
        duration=END,
        title="valve with CONT_S",
    )

    step = result.between(STEP, DROP)
    # PV settles within the dead band, which is wider than 2 % of the step, so there may be no settling time.
    result.quality += step.figures("PV", "SP_INT", 60.0, 70.0, unit="K", theory={"rise": 2.2 * LAMBDA})
    result.quality.add("highest beyond the setpoint", float(max(step["PV"])) - 70.0, "K", "at most 0.5")
    result.quality.add("within 1 K after", float(step.time[abs(step["PV"] - 70.0) > 1.0][-1]) - STEP, "s")
    rest = result.between(MANUAL - 20.0, MANUAL)
    result.quality.add("steady-state deviation", float(max(abs(rest["SP_INT"] - rest["PV"]))), "K", f"at most {DEADB_W}")
    for name, start, end in (("setpoint step", STEP, DROP), ("pressure drop", DROP, MANUAL)):
        part = result.between(start, end)
        result.quality.add(f"pulses for the {name}", pulses(part["QLMNUP"]) + pulses(part["QLMNDN"]), "")
    against = (result["QLMNUP"] * result["LMNR_HS"] + result["QLMNDN"] * result["LMNR_LS"]) > 0
    result.quality.add("calls with a pulse against a stop", int(np.sum(against)), "", 0)
    stopped = result.between(TOO_HIGH, BACK)
    result.quality.add("setpoint too high: at the stop", CYCLE * float(np.sum(stopped["LMNR_HS"])), "s")
    back = result.between(BACK, END)
    first_down = back.time[back["QLMNDN"] == 1][0] - BACK
    result.quality.add("setpoint back: the valve closes after", float(first_down), "s", 0.0)
    return result


def pulses(signal):
    """The number of rising edges."""
    return int(np.sum(np.diff(np.concatenate([[0], signal])) > 0))


def draw(result, path):
    title = (
        f"{result.quality['pulses for the setpoint step']} pulses for a step of 10 K, "
        f"{result.quality['pulses for the pressure drop']} for the pressure drop; "
        f"{result.quality['calls with a pulse against a stop'] or 'no'} pulse against a limit stop"
    )
    with plot.picture(path, title, ["temperature in °C", "valve position in %", "pulses"], [1.3, 1, 0.75]) as axes:
        time = result.time
        axes[0].plot(time, result["SP_INT"], label="SP_INT", drawstyle="steps-post", **plot.SETPOINT)
        axes[0].plot(time, result["PV"], label="PV", **plot.PROCESS_VALUE)
        axes[1].plot(time, result["LMNR"], label="LMNR", **plot.P_PART)
        plot.pulses(
            axes[1], time, result["LMNR_HS"], 40, 70, label="at the limit stop, LMNR_HS", zorder=0.1, **plot.SPAN
        )
        plot.pulses(axes[2], time, result["QLMNUP"], label="QLMNUP", **plot.PULSE)
        plot.pulses(axes[2], time, result["QLMNDN"], height=-1.0, label="QLMNDN", **plot.OPPOSITE_PULSE)
        axes[0].set_ylim(55, 112)
        axes[1].set_ylim(40, 110)
        axes[2].set_yticks([-0.5, 0.5], ["down", "up"])
        axes[2].set_ylim(-1.2, 1.2)
        plot.event(axes, STEP, "setpoint + 10 K")
        plot.event(axes, DROP, "pressure\n4 → 3 bar")
        plot.mark(axes, MANUAL, AUTOMATIC, "manual", plot.MANUAL)
        plot.event(axes, TOO_HIGH, "setpoint\nout of reach")
        plot.event(axes, BACK, "setpoint back")
        for each in axes:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"Valve with CONT_S: GAIN {GAIN:.2f} %/K, TI {TI:.1f} s, DEADB_W {DEADB_W} K, PULSE_TM {PULSE_TM} s")
        result = run(fmus)
        print(result.quality)
        result.to_csv(out / "cont_s_valve.csv", digits=9)
        draw(result, out / "cont_s_valve")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
