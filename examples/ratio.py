"""Ratio control with CONT_C: the second of two flows follows the first in a given ratio.

    PRES, operator --> VALVE A --FLOW---> x ratio --SP_INT--> CONT_C --LMN--> DRIVE  VALVE B --FLOW--+
                                                                ^                                    |
                                                                +-------------PV_IN------------------+

Flow A is uncontrolled: an operator moves its valve, and its pressure drops. The setpoint of CONT_C
for flow B is the measured flow A times the ratio, as in a burner (air and fuel) or when two liquids
are blended. The multiplication before SP_INT belongs to the user's program; here it is part of the
loop.

Call order: every 100 ms, the controller is called with both flows at t, then both valves are
stepped to t + 100 ms.

Tuning: flow B follows its valve (with positioner) without lag, 0.4 l/min per 1 %. So the controller
is an I controller (P_SEL off) with GAIN / TI = 1 / (0.4 l/min/% * LAMBDA), for a closed-loop time
constant LAMBDA = 1.5 s.

Theory, for a first-order loop: while flow A rises at a constant slope, flow B lags by slope * ratio
* LAMBDA; the response to a step in the ratio has a rise time of 2.2 LAMBDA and no overshoot,
settles within 2 % after 3.9 LAMBDA, and its error integral is step * LAMBDA. A pressure drop to 2.5
bar reduces flow B by 21 % immediately; it recovers with LAMBDA / 0.79, because the gain of the
valve is then lower.
"""

import math

import numpy as np

import plcfmu
from plcfmu import plot
from plcfmu.figures import integral_error

CYCLE = 0.1
FLOW_PER_PERCENT = 0.4
LAMBDA = 1.5
STROKE_TIME_A = 30.0

# Flow A: its valve opens from 40 to 70 %, then its pressure drops. Flow B: the ratio changes, then its pressure drops.
OPENS, STOPS, DROP_A, NEW_RATIO, DROP_B, END = 10.0, 19.0, 40.0, 60.0, 80.0, 100.0
PRESSURE, LOW_PRESSURE = 4.0, 2.5


def run(fmus):
    """Flow A rises, then falls with its pressure; then the ratio changes, and then the pressure of B drops."""
    valve_a = fmus.start("VALVE", name="A", MTR_TM=STROKE_TIME_A, POS_START=40.0, CYCLE=CYCLE)
    valve_b = fmus.start("VALVE", name="B", POS_ON=True, MTR_TM=5.0, POS_START=20.0, CYCLE=CYCLE)
    controller = fmus.start(
        "CONT_C", MAN_ON=False, CYCLE=CYCLE, P_SEL=False, GAIN=1.0, TI=FLOW_PER_PERCENT * LAMBDA, I_ITLVAL=20.0
    )

    def ratio(t):
        return 0.6 if t >= NEW_RATIO else 0.5

    def flow_a(t):
        # VALVE outputs its flow only after the first step.
        return valve_a["FLOW"] if t > 0.0 else 16.0

    def flow_b(t):
        return valve_b["FLOW"] if t > 0.0 else 8.0

    result = plcfmu.simulate(
        controller,
        [valve_a, valve_b],
        {"CONT_C.LMN": "B.DRIVE"},
        inputs={
            "CONT_C.SP_INT": lambda t: ratio(t) * flow_a(t),
            "CONT_C.PV_IN": flow_b,
            "A.UP": lambda t: OPENS - CYCLE / 2 <= t < STOPS - CYCLE / 2,
            "A.PRES": [(0.0, PRESSURE), (DROP_A, LOW_PRESSURE)],
            "B.PRES": [(0.0, PRESSURE), (DROP_B, LOW_PRESSURE)],
        },
        record={
            "FLOW_A": flow_a,
            "FLOW_B": flow_b,
            "SP_INT": lambda t: controller["SP_INT"],
            "LMN": "CONT_C.LMN",
            "RATIO_SET": ratio,
            "RATIO": lambda t: flow_b(t) / flow_a(t),
            "PRES_A": "A.PRES",
            "PRES_B": "B.PRES",
        },
        step=CYCLE,
        duration=END,
        title="ratio control",
    )

    slope = 0.5 * FLOW_PER_PERCENT * 100.0 / STROKE_TIME_A
    rising = result.between(STOPS - 1.0, STOPS)
    result.quality.add(
        "flow A rises: flow B is behind", float(np.mean(rising["SP_INT"] - rising["FLOW_B"])), "l/min", slope * LAMBDA
    )

    step = result.between(NEW_RATIO, DROP_B)
    before, after = 0.5 * step["FLOW_A"][-1], 0.6 * step["FLOW_A"][-1]
    settling, iae = math.log(50) * LAMBDA, (after - before) * LAMBDA
    theory = {"rise": 2.2 * LAMBDA, "overshoot": 0.0, "settling": settling, "iae": iae}
    prefix = "new ratio: "
    result.quality += step.figures("FLOW_B", "SP_INT", before, after, unit="l/min", prefix=prefix, theory=theory)

    drop = result.between(DROP_B, END)
    left = math.sqrt(LOW_PRESSURE / PRESSURE)
    result.quality.add(
        "pressure drop of B: largest deviation", float(max(after - drop["FLOW_B"])), "l/min", after * (1 - left)
    )
    result.quality.add(
        "pressure drop of B: integral of the error",
        integral_error(drop.time, drop["FLOW_B"], drop["SP_INT"]),
        "l/min s",
        after * (1 - left) * LAMBDA / left,
    )
    return result


def draw(result, path):
    title = (
        f"Flow B stays {result.quality['flow A rises: flow B is behind']:.1f} l/min behind while flow A rises, "
        f"and takes a new ratio in {result.quality['new ratio: rise']:.1f} s (10 to 90 %)"
    )
    with plot.picture(path, title, ["flow in l/min", "flow B in % of flow A", "valve B in %"], [1.5, 1, 0.8]) as axes:
        time = result.time
        axes[0].plot(time, result["FLOW_A"], label="flow A", **plot.COMPARED)
        axes[0].plot(time, result["SP_INT"], label="SP_INT", **plot.SETPOINT)
        axes[0].plot(time, result["FLOW_B"], label="flow B", **plot.PROCESS_VALUE)
        axes[1].plot(time, 100.0 * result["RATIO_SET"], label="ratio wanted", drawstyle="steps-post", **plot.SETPOINT)
        axes[1].plot(time, 100.0 * result["RATIO"], label="ratio", **plot.PROCESS_VALUE)
        axes[2].plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **plot.MANIPULATED)
        axes[0].set_ylim(0, 40)
        plot.mark(axes, OPENS, STOPS, "valve A opens")
        drop = f"{PRESSURE:g} → {LOW_PRESSURE:g} bar"
        plot.event(axes, DROP_A, f"pressure A\n{drop}")
        plot.event(axes, NEW_RATIO, "new ratio")
        plot.event(axes, DROP_B, f"pressure B\n{drop}")
        for each in axes:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"Ratio control: I controller, TI {FLOW_PER_PERCENT * LAMBDA:.2f} s for {LAMBDA} s")
        result = run(fmus)
        print(result.quality)
        result.to_csv(out / "ratio.csv", digits=9)
        draw(result, out / "ratio")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
