"""Furnace with CONT_C: a setpoint step, an opened door, and two ways to heat up from cold.

    setpoint --SP_INT--> CONT_C --LMN----> POWER  HEATER --T_PER--+
                           ^                                      |
                           +----------PV_PER----------------------+

The process value takes the same path as in a PLC: the analog word T_PER, 0 ... 27648 for 0 ... 400
degC, is connected to PV_PER, and PVPER_ON and PV_FAC = 4 convert it to degC.

Tuning: SIMC (Skogestad, internal model control made simple) for the furnace's documented gain K = 3
K/%, lags of 120 s and 20 s and delay of 5 s, and a closed-loop time constant LAMBDA = 20 s. The
controller cancels the lags, which leaves the open loop

    L(s) = exp(-5.5 s) / ((LAMBDA + THETA) s (TM_LAG s + 1)),   THETA = 5 s delay + 0.5 s CYCLE / 2 + 5 s TM_LAG

so theory predicts a first-order response to the setpoint: rise time 2.2 LAMBDA, no overshoot
(LAMBDA + THETA is more than e THETA), settling within 2 % after the delay plus 3.9 LAMBDA, and an
error integral of step * (LAMBDA + THETA). An opened door requires an LMN that is larger by dLMN;
the integrator has to supply it, which takes an error integral of dLMN TI / GAIN.
"""

import math

import plcfmu
from plcfmu import plot
from plcfmu.figures import integral_error

CYCLE = 1.0
# The furnace: HEATER's start values.
K, T1, T2, DELAY = 3.0, 120.0, 20.0, 5.0
# The loop.
LAMBDA = 20.0
TM_LAG = 5.0
THETA = DELAY + CYCLE / 2 + TM_LAG
# SIMC yields a controller KC (1 + 1 / (T1 s)) (1 + T2 s) / (1 + TM_LAG s); CONT_C is parallel, with the equivalent:
KC = T1 / (K * (LAMBDA + THETA))
TI = T1 + T2 - TM_LAG
TD = T1 * T2 / TI - TM_LAG
GAIN = KC * TI / T1

PID = {
    "GAIN": GAIN,
    "TI": TI,
    "TD": TD,
    "TM_LAG": TM_LAG,
    "D_SEL": True,
    "PVPER_ON": True,
    "PV_FAC": 4.0,
    "CYCLE": CYCLE,
}
SIGNALS = {name: f"CONT_C.{name}" for name in "SP_INT PV LMN LMN_P LMN_I LMN_D QLMN_HLM".split()}

AUTOMATIC, STEP, DOOR, END = 30.0, 60.0, 300.0, 1000.0
COLD, HOT, COLD_END = 20.0, 200.0, 500.0


def run(fmus):
    """Steady at 170 degC in manual mode, then automatic mode, a step of 10 K, and then the door half open."""
    controller = fmus.start("CONT_C", PID, MAN_ON=True, MAN=50.0)
    furnace = fmus.start("HEATER", T_START=170.0)
    result = plcfmu.simulate(
        controller,
        furnace,
        {"CONT_C.LMN": "HEATER.POWER", "HEATER.T_PER": "CONT_C.PV_PER"},
        inputs={
            "CONT_C.SP_INT": [(0.0, 170.0), (STEP, 180.0)],
            "CONT_C.MAN_ON": [(0.0, True), (AUTOMATIC, False)],
            "HEATER.DOOR": [(0.0, 0.0), (DOOR, 50.0)],
        },
        record={**SIGNALS, "DOOR": "HEATER.DOOR", "TEMP": "HEATER.TEMP"},
        step=CYCLE,
        duration=END,
        title="furnace with CONT_C",
    )

    step = result.between(STEP, DOOR)
    settled = DELAY + CYCLE / 2 + math.log(50) * LAMBDA
    theory = {"rise": 2.2 * LAMBDA, "overshoot": 0.0, "settling": settled, "iae": 10.0 * (LAMBDA + THETA)}
    result.quality += step.figures("PV", "SP_INT", 170.0, 180.0, unit="K", theory=theory)

    door = result.between(DOOR, END)
    more_power = 0.25 * (180.0 - 20.0) / K  # the door half open: a quarter more heat loss
    peak = math.log(T1 / LAMBDA) * T1 * LAMBDA / (T1 - LAMBDA)
    share = (math.exp(-peak / T1) - math.exp(-peak / LAMBDA)) / (T1 - LAMBDA)
    result.quality.add(
        "door: largest deviation", float(max(180.0 - door["PV"])), "K", K * more_power * (LAMBDA + THETA) * share
    )
    result.quality.add(
        "door: integral of the error",
        integral_error(door.time, door["PV"], door["SP_INT"]),
        "K s",
        more_power * TI / GAIN,
    )
    return result


def cold_start(fmus, by_hand):
    """From 20 to 200 degC: in automatic mode, or with full manual power up to 170 degC and automatic from there."""
    controller = fmus.start("CONT_C", PID, MAN=100.0)
    furnace = fmus.start("HEATER", T_START=COLD)
    result = plcfmu.simulate(
        controller,
        furnace,
        {"CONT_C.LMN": "HEATER.POWER", "HEATER.T_PER": "CONT_C.PV_PER"},
        inputs={
            "CONT_C.SP_INT": HOT,
            # The temperature does not fall below 170 degC again, so this switches to automatic mode once.
            "CONT_C.MAN_ON": lambda t: by_hand and furnace["TEMP"] < 170.0,
        },
        record={**SIGNALS, "MAN_ON": "CONT_C.MAN_ON"},
        step=CYCLE,
        duration=COLD_END,
        title="cold start by hand" if by_hand else "cold start in automatic mode",
    )

    way = "by hand" if by_hand else "automatic"
    prefix = f"cold start {way}: "
    result.quality += result.figures("PV", "SP_INT", COLD, HOT, unit="K", prefix=prefix, theory={"overshoot": 0.0})
    return result


def draw(result, path):
    quality = result.quality
    title = (
        f"A step of 10 K: 10 to 90 % in {quality['rise']:.0f} s, {quality['overshoot']:.1f} % overshoot; "
        f"the open door costs {quality['door: largest deviation']:.1f} K"
    )
    labels = ["temperature in °C", "manipulated value in %", "parts of the manipulated value in %"]
    with plot.picture(path, title, labels, [1.25, 1, 1]) as axes:
        time = result.time
        axes[0].plot(time, result["SP_INT"], label="SP_INT", drawstyle="steps-post", **plot.SETPOINT)
        axes[0].plot(time, result["PV"], label="PV", **plot.PROCESS_VALUE)
        axes[1].plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **plot.MANIPULATED)
        axes[2].plot(time, result["LMN_P"], label="LMN_P", drawstyle="steps-post", **plot.P_PART)
        axes[2].plot(time, result["LMN_I"], label="LMN_I", drawstyle="steps-post", **plot.I_PART)
        axes[2].plot(time, result["LMN_D"], label="LMN_D", drawstyle="steps-post", **plot.D_PART)
        axes[0].set_ylim(168, 188)
        axes[1].set_ylim(40, 105)
        # The span is narrower than its label, which is in the legend instead.
        plot.mark(axes[:1], 0.0, AUTOMATIC, "", {**plot.MANUAL, "label": "manual"})
        plot.mark(axes[1:], 0.0, AUTOMATIC, "", plot.MANUAL)
        plot.event(axes, STEP, "setpoint + 10 K")
        plot.event(axes, DOOR, "door half open")
        for each in axes:
            plot.legend(each)


def draw_cold_start(automatic, by_hand, path):
    title = (
        f"From cold to {HOT:.0f} °C: settled after {by_hand.quality['cold start by hand: settling']:.0f} s "
        "if heated by hand first,\n"
        f"after {automatic.quality['cold start automatic: settling']:.0f} s in automatic mode from the start"
    )
    labels = ["temperature in °C", "LMN in %, automatic from the start", "LMN in %, by hand up to 170 °C"]
    with plot.picture(path, title, labels, [1.1, 0.7, 1.2]) as axes:
        time = automatic.time
        axes[0].plot(time, automatic["SP_INT"], label="SP_INT", **plot.SETPOINT)
        axes[0].plot(time, automatic["PV"], label="PV, automatic from the start", **plot.COMPARED)
        axes[0].plot(time, by_hand["PV"], label="PV, by hand up to 170 °C", **plot.PROCESS_VALUE)
        for each, result in ((axes[1], automatic), (axes[2], by_hand)):
            each.plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **plot.MANIPULATED)
            each.plot(time, result["LMN_I"], label="LMN_I", drawstyle="steps-post", **plot.I_PART)
        axes[0].set_ylim(0, 220)
        axes[1].set_ylim(-8, 150)
        axes[2].set_ylim(-290, 130)
        limited = time[automatic["QLMN_HLM"] == 1]
        text = "shaded: LMN at its limit, the integrator stands still"
        plot.mark([axes[1]], limited[0], limited[-1] + CYCLE, text, at=(limited[-1] + CYCLE, 1.0))
        manual = time[by_hand["MAN_ON"] == 1]
        text = "shaded: manual, MAN = 100 %; LMN_I follows as MAN - LMN_P"
        plot.mark([axes[2]], manual[0], manual[-1] + CYCLE, text, plot.MANUAL, at=(manual[-1] + CYCLE, 0.4))
        for each in axes:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"Furnace with CONT_C: GAIN {GAIN:.3f}, TI {TI:.1f} s, TD {TD:.2f} s, TM_LAG {TM_LAG:.0f} s")
        result = run(fmus)
        automatic, by_hand = cold_start(fmus, False), cold_start(fmus, True)
        for each in (result, automatic, by_hand):
            print(each.quality)
        result.to_csv(out / "cont_c_heater.csv", digits=9)
        automatic.to_csv(out / "cont_c_heater_cold_start.csv", digits=9)
        by_hand.to_csv(out / "cont_c_heater_cold_start_by_hand.csv", digits=9)
        draw(result, out / "cont_c_heater")
        draw_cold_start(automatic, by_hand, out / "cont_c_heater_cold_start")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
