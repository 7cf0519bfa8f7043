"""Three-step control of a heated and cooled chamber: RATIOFAC 1 and 0.5 side by side.

    setpoint --SP_INT--> CONT_C --LMN--> INV  PULSEGEN --QPOS_P--> HEAT  THERMO --TEMP--+
                           ^                           --QNEG_P--> COOL                 |
                           +----------------------------PV_IN---------------------------+

One percent of cooling changes the temperature twice as much as one percent of heating (DROP 120 K,
RISE 60 K). With RATIOFAC = 0.5, PULSEGEN halves the cooling pulses, and the controller sees the
same gain of 0.6 K/% in both directions.

Call order: CONT_C every 2 s, PULSEGEN (PER_TM = 2 s) and THERMO every 20 ms, so that a pulse has a
resolution of 1 %. In a step in which CONT_C is called, it is called first, so its LMN determines
the pulse of the period that starts there.

Tuning: SIMC's PI rule for the slower direction, cooling, with lags of 100 s and 25 s and a gain of
0.6 K/%: half of the 25 s and half a period count as the delay THETA = 13.5 s, and LAMBDA = THETA.
The same settings apply to both directions.

Theory: with RATIOFAC = 0.5 the loop has a phase margin of 51 degrees in cooling, and the response
to a setpoint step overshoots by only a few percent, slightly more than in heating, which has less
lag. With RATIOFAC = 1 the loop gain in cooling is twice as high: the crossover frequency increases,
the rise time is about halved, the phase margin drops to 36 degrees, and the temperature oscillates:
it overshoots by more than twice as much, and heating has to bring it back. In heating the two are
the same, pulse by pulse.
"""

import math

import numpy as np

import plcfmu
from plcfmu import plot

CYCLE, PULSE_CYCLE = 2.0, 0.02
CALLS = round(CYCLE / PULSE_CYCLE)
K, T1, T2 = 0.6, 100.0, 25.0
THETA = T2 / 2 + CYCLE / 2
LAMBDA = THETA
GAIN = (T1 + T2 / 2) / (K * (LAMBDA + THETA))
TI = T1 + T2 / 2
START, WARM, COLD = 20.0, 26.0, 14.0
HEATING, COOLING, END = 20.0, 260.0, 560.0


def phase_margin(gain):
    """The phase margin in cooling, in degrees, at `gain` times the loop gain it was tuned for."""

    def loop_at(w):
        s = 1j * w
        return gain * K * GAIN * (1 + 1 / (TI * s)) * np.exp(-s * CYCLE / 2) / ((T1 * s + 1) * (T2 * s + 1))

    w = np.linspace(0.001, 0.5, 200000)
    crossover = w[np.nonzero(abs(loop_at(w)) < 1)[0][0]]
    return 180.0 + math.degrees(np.angle(loop_at(crossover)))


def run(fmus, ratiofac):
    """From 20 to 26 degC by heating, then to 14 degC by cooling. A row is a period of the pulses."""
    controller = fmus.start("CONT_C", MAN_ON=False, CYCLE=CYCLE, GAIN=GAIN, TI=TI, LMN_LLM=-100.0)
    generator = fmus.start("PULSEGEN", CYCLE=PULSE_CYCLE, PER_TM=CYCLE, P_B_TM=2 * PULSE_CYCLE, RATIOFAC=ratiofac)
    chamber = fmus.start("THERMO", CYCLE=PULSE_CYCLE)
    result = plcfmu.Result()
    for start in plcfmu.clock(END, CYCLE, f"heating and cooling, RATIOFAC {ratiofac}"):
        setpoint = START if start < HEATING else WARM if start < COOLING else COLD
        controller.step(start, CYCLE, SP_INT=setpoint, PV_IN=chamber["TEMP"])
        heat = cool = 0
        for call in range(CALLS):
            t = start + call * PULSE_CYCLE
            generator.step(t, PULSE_CYCLE, INV=controller["LMN"])
            pulse, negative_pulse = generator["QPOS_P"], generator["QNEG_P"]
            heat, cool = heat + pulse, cool + negative_pulse
            chamber.step(t, PULSE_CYCLE, HEAT=pulse, COOL=negative_pulse)
        result.add(
            start,
            SP_INT=setpoint,
            PV=controller["PV"],
            LMN=controller["LMN"],
            HEAT=100.0 * heat / CALLS,
            COOL=100.0 * cool / CALLS,
        )

    for name, start, end, low, high in (
        ("heating", HEATING, COOLING, START, WARM),
        ("cooling", COOLING, END, WARM, COLD),
    ):
        part = result.between(start, end)
        prefix = f"RATIOFAC {ratiofac}, {name}: "
        result.quality += part.figures("PV", "SP_INT", low, high, unit="K", prefix=prefix)
    gain = 2.0 * ratiofac
    result.quality.add(f"RATIOFAC {ratiofac}: phase margin in cooling, computed", phase_margin(gain), "degrees")
    held = (START - COLD) / (1.2 * ratiofac)
    result.quality.add(f"RATIOFAC {ratiofac}: LMN that holds 14 degC", float(np.mean(result["LMN"][-20:])), "%", -held)
    return result


def draw(whole, half, path):
    over_whole, over_half = (
        result.quality[f"RATIOFAC {ratiofac}, cooling: overshoot"]
        for result, ratiofac in ((whole, "1.0"), (half, "0.5"))
    )
    title = (
        "Cooling twice as strong as heating overshoots "
        f"by {over_whole:.0f} % with RATIOFAC 1, by {over_half:.0f} % with 0.5"
    )
    labels = ["temperature in °C", "LMN in %", "pulse in % of the period"]
    with plot.picture(path, title, labels, [1.4, 1, 1], columns=2) as axes:
        for column, (result, ratiofac) in enumerate(((whole, "1"), (half, "0.5"))):
            top, middle, bottom = axes[:, column]
            plot.label(top, f"RATIOFAC {ratiofac}: temperature in °C")
            top.plot(result.time, result["SP_INT"], label="SP_INT", drawstyle="steps-post", **plot.SETPOINT)
            top.plot(result.time, result["PV"], label="PV", **plot.PROCESS_VALUE)
            middle.plot(result.time, result["LMN"], label="LMN", drawstyle="steps-post", **plot.MANIPULATED)
            for pulse, style, label in (
                (result["HEAT"], plot.PULSE, "QPOS_P"),
                (-result["COOL"], plot.OPPOSITE_PULSE, "QNEG_P"),
            ):
                bottom.fill_between(result.time, 0, pulse, step="post", label=label, **{**style, "linewidth": 0})
            for each in (top, middle, bottom):
                plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"Heating and cooling in three steps: GAIN {GAIN:.2f} %/K, TI {TI:.1f} s")
        whole, half = run(fmus, 1.0), run(fmus, 0.5)
        for each in (whole, half):
            print(each.quality)
        half.to_csv(out / "heat_cool.csv", digits=9)
        whole.to_csv(out / "heat_cool_1.csv", digits=9)
        draw(whole, half, out / "heat_cool")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
