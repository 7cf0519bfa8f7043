"""Ratio control with CONT_C: the second of two flows follows the first one in a given proportion.

    PRES, operator --> VALVE A --FLOW---> x ratio --SP_INT--> CONT_C --LMN--> DRIVE  VALVE B --FLOW--+
                                                                ^                                    |
                                                                +-------------PV_IN------------------+

Flow A is what it is: an operator moves its valve, its pressure drops. The setpoint of CONT_C for
flow B is the measured flow A times the ratio, as in a burner (air and fuel) or when two liquids are
blended. The multiplication stands in front of SP_INT, in the user's program; here, in the loop.

Call order: every 100 ms the controller sees both flows of t, then both valves run to t + 100 ms.

Tuning: flow B follows its valve (with positioner) at once, 0.4 l/min for 1 %. So the controller is
an I controller (P_SEL off) with GAIN / TI = 1 / (0.4 l/min/% * LAMBDA), for a closed loop with the
time constant LAMBDA = 1.5 s.

Theory, of a first-order loop: while flow A rises with a slope, flow B stays slope * ratio * LAMBDA
behind; a step of the ratio is answered in a rise time of 2.2 LAMBDA without overshoot, within 2 %
after 3.9 LAMBDA, and the error adds up to step * LAMBDA. A pressure drop to 2.5 bar costs flow B 21
% at once; it comes back with LAMBDA / 0.79, for the valve has less gain then.
"""

import math

import numpy as np

import loop

CYCLE = 0.1
FLOW_PER_PERCENT = 0.4
LAMBDA = 1.5
STROKE_TIME_A = 30.0

# Flow A: its valve opens from 40 to 70 %, later its pressure drops. Flow B: another ratio, later its pressure drops.
OPENS, STOPS, DROP_A, NEW_RATIO, DROP_B, END = 10.0, 19.0, 40.0, 60.0, 80.0, 100.0
PRESSURE, LOW_PRESSURE = 4.0, 2.5


def run(fmus):
    """Flow A rises, falls with its pressure; then the ratio is changed, and then the pressure of B drops."""
    wild = fmus.start("VALVE", MTR_TM=STROKE_TIME_A, POS_START=40.0, CYCLE=CYCLE)
    valve = fmus.start("VALVE", POS_ON=True, MTR_TM=5.0, POS_START=20.0, CYCLE=CYCLE)
    controller = fmus.start(
        "CONT_C",
        MAN_ON=False,
        CYCLE=CYCLE,
        P_SEL=False,
        GAIN=1.0,
        TI=FLOW_PER_PERCENT * LAMBDA,
        I_ITLVAL=20.0,
    )
    result = loop.Result()
    flow_a, flow_b = 16.0, 8.0
    for t in loop.clock(END, CYCLE, "ratio control"):
        ratio = 0.6 if t >= NEW_RATIO else 0.5
        pressure_a = LOW_PRESSURE if t >= DROP_A else PRESSURE
        pressure_b = LOW_PRESSURE if t >= DROP_B else PRESSURE
        controller.step(t, CYCLE, SP_INT=ratio * flow_a, PV_IN=flow_b)
        result.add(
            t,
            FLOW_A=flow_a,
            FLOW_B=flow_b,
            SP_INT=controller["SP_INT"],
            LMN=controller["LMN"],
            RATIO_SET=ratio,
            RATIO=flow_b / flow_a,
            PRES_A=pressure_a,
            PRES_B=pressure_b,
        )
        wild.step(t, CYCLE, UP=OPENS - CYCLE / 2 <= t < STOPS - CYCLE / 2, PRES=pressure_a)
        valve.step(t, CYCLE, DRIVE=controller["LMN"], PRES=pressure_b)
        flow_a, flow_b = wild["FLOW"], valve["FLOW"]

    slope = 0.5 * FLOW_PER_PERCENT * 100.0 / STROKE_TIME_A
    rising = result.between(STOPS - 1.0, STOPS)
    result.figure(
        "flow A rises: flow B is behind",
        float(np.mean(rising["SP_INT"] - rising["FLOW_B"])),
        "l/min",
        slope * LAMBDA,
    )

    step = result.between(NEW_RATIO, DROP_B)
    before, after = 0.5 * step["FLOW_A"][-1], 0.6 * step["FLOW_A"][-1]
    theory = 2.2 * LAMBDA, 0.0, math.log(50) * LAMBDA, (after - before) * LAMBDA
    prefix = "new ratio: "
    result.step_figures(step, "FLOW_B", "SP_INT", before, after, "l/min s", prefix, theory)

    drop = result.between(DROP_B, END)
    left = math.sqrt(LOW_PRESSURE / PRESSURE)
    result.figure(
        "pressure drop of B: largest deviation",
        float(max(after - drop["FLOW_B"])),
        "l/min",
        after * (1 - left),
    )
    result.figure(
        "pressure drop of B: integral of the error",
        loop.control_error(drop, "FLOW_B", "SP_INT"),
        "l/min s",
        after * (1 - left) * LAMBDA / left,
    )
    return result


def draw(result, path):
    figure, axes = loop.picture(
        "Ratio control: flow B follows flow A at half, later at 0.6 of it",
        ["flow in l/min", "ratio B : A", "valve B in %"],
        [1.4, 1, 0.8],
    )
    time = result.time
    axes[0].plot(time, result["FLOW_A"], label="flow A", **loop.COMPARED)
    axes[0].plot(time, result["SP_INT"], label="SP_INT", **loop.SETPOINT)
    axes[0].plot(time, result["FLOW_B"], label="flow B", **loop.PROCESS_VALUE)
    axes[1].plot(
        time, result["RATIO_SET"], label="ratio asked for", drawstyle="steps-post", **loop.SETPOINT
    )
    axes[1].plot(time, result["RATIO"], label="ratio", **loop.PROCESS_VALUE)
    axes[2].plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **loop.MANIPULATED)
    axes[0].set_ylim(0, 33)
    loop.mark(axes, OPENS, STOPS, "valve A opens")
    loop.mark(axes, DROP_A, DROP_A + 0.4, "  pressure of A\n  4 → 2.5 bar")
    loop.mark(axes, NEW_RATIO, NEW_RATIO + 0.4, "  new ratio", loop.MANUAL)
    loop.mark(axes, DROP_B, DROP_B + 0.4, "  pressure of B\n  4 → 2.5 bar")
    for each in axes:
        loop.legend(each)
    loop.save_picture(figure, path)


def main():
    folder, out = loop.arguments(__doc__)
    with loop.Fmus(folder) as fmus:
        print(f"Ratio control: I controller, TI {FLOW_PER_PERCENT * LAMBDA:.2f} s for {LAMBDA} s")
        result = run(fmus)
        result.print_figures()
        loop.save_csv(result, out / "ratio.csv")
        draw(result, out / "ratio.png")


if __name__ == "__main__":
    main()
