"""CONT_C with PULSEGEN at 200 times its rate, and the same controller as PULS_CTR: the manual's
example, section 3.4.

    every 2 s                          every 10 ms
    setpoint --SP_INT--> CONT_C --LMN--> INV  PULSEGEN --QPOS_P--> HEAT  THERMO --T_PER--+
                           ^                                                             |
                           +---------------------------PV_PER----------------------------+

    setpoint --SP_INT--> PULS_CTR --QPOS_P--> HEAT  THERMO --T_PER--+
                           ^                                        |
                           +-----------------PV_PER-----------------+

The lower loop is the upper one in a single block, with its own chamber. Both run side by side, and
every pulse is compared: they are equal, call by call, and so are the temperatures, bit by bit.

Call order: PULS_CTR counts its calls after a restart and first calls CONT_C in call RED_FAC, the
last call of the first period, and then in every RED_FAC-th call; PULSEGEN follows in the same call
with the new LMN. Counted from 0 this is call 199, at 1.99 s. So CONT_C as a separate FMU is started
at 1.99 s, called there and then every 2 s, and stepped before PULSEGEN and THERMO. LMN changes in
the last call of a period, in which PULSEGEN does not synchronize: it determines the pulse of the
period that starts 10 ms later.

Tuning: SIMC's PI rule for heating with 0.6 K/% and lags of 100 s and 10 s, where half of the second
lag and half a period count as the delay THETA = 6 s; LAMBDA = 21 s. A pulse is a whole number of
calls, so 200 calls resolve the heating in steps of 0.5 %.

Theory: the temperature is slow and responds only to the mean of the pulses, so the response is that
of the continuous controller: rise time 2.2 LAMBDA, negligible overshoot, and an error integral of
step * (LAMBDA + THETA). The ripple of the pulses is less than that of a pulse lasting a full
period: 2 s of 60 K / 100 s, through the heater's lag of 10 s: 0.6 K/s * 2 s * 2 s / (8 * 10 s) =
0.03 K.
"""

import math

import numpy as np

import plcfmu
from plcfmu import plot

CYCLE, RED_FAC = 0.01, 200
PERIOD = CYCLE * RED_FAC
K, T1, T2 = 0.6, 100.0, 10.0
THETA = T2 / 2 + PERIOD / 2
LAMBDA = 21.0
GAIN = (T1 + T2 / 2) / (K * (LAMBDA + THETA))
TI = T1 + T2 / 2
COLD, WARM = 20.0, 30.0
STEP, END = 20.0, 240.0
# T_PER is 0 ... 27648 for -100 ... 100 degC.
PROCESS_VALUE = {"PVPER_ON": True, "PV_FAC": 2.0, "PV_OFF": -100.0}
CONTROL = {"MAN_ON": False, "GAIN": GAIN, "TI": TI, **PROCESS_VALUE}
PULSES = {"P_B_TM": CYCLE, "STEP3_ON": False}


def run(fmus, end=END):
    """From 20 to 30 degC, with the two blocks and with PULS_CTR. A row is a call of PULSEGEN."""
    start_of_controller = (RED_FAC - 1) * CYCLE
    controller = fmus.start("CONT_C", CONTROL, CYCLE=PERIOD, start_time=start_of_controller)
    generator = fmus.start("PULSEGEN", PULSES, CYCLE=CYCLE, PER_TM=PERIOD)
    chamber = fmus.start("THERMO", CYCLE=CYCLE)

    nested = {f"DI_CONT_C.{name}": value for name, value in CONTROL.items()}
    nested.update({f"DI_PULSEGEN.{name}": value for name, value in PULSES.items()})
    both = fmus.start("PULS_CTR", nested, CYCLE=CYCLE, RED_FAC=RED_FAC)
    its_chamber = fmus.start("THERMO", CYCLE=CYCLE)

    result = plcfmu.Result()
    for call, t in enumerate(plcfmu.clock(end, CYCLE, "CONT_C with PULSEGEN, and PULS_CTR")):
        setpoint = WARM if t >= STEP else COLD
        if call % RED_FAC == RED_FAC - 1:
            controller.step(
                start_of_controller + (call // RED_FAC) * PERIOD, PERIOD, SP_INT=setpoint, PV_PER=chamber["T_PER"]
            )
        generator.step(t, CYCLE, INV=controller["LMN"])
        both.step(t, CYCLE, SP_INT=setpoint, PV_PER=its_chamber["T_PER"])
        result.add(
            t,
            SP_INT=setpoint,
            TEMP=chamber["TEMP"],
            LMN=controller["LMN"],
            QPOS_P=generator["QPOS_P"],
            PULS_CTR_TEMP=its_chamber["TEMP"],
            PULS_CTR_LMN=both["DI_CONT_C.LMN"],
            PULS_CTR_QPOS_P=both["QPOS_P"],
        )
        chamber.step(t, CYCLE, HEAT=generator["QPOS_P"])
        its_chamber.step(t, CYCLE, HEAT=both["QPOS_P"])

    for name in ("QPOS_P", "LMN", "TEMP"):
        different = int(np.sum(result[name] != result[f"PULS_CTR_{name}"]))
        result.quality.add(f"calls of {len(result)} with another {name} in PULS_CTR", different, "", 0)
    step = result.between(STEP, end)
    theory = {
        "rise": 2.2 * LAMBDA,
        "overshoot": "at most 2",
        "settling": f"at most {THETA + math.log(50) * LAMBDA:.0f}",
        "iae": (WARM - COLD) * (LAMBDA + THETA),
    }
    result.quality += step.figures("TEMP", "SP_INT", COLD, WARM, unit="K", theory=theory)
    rest = result.between(end - 5 * PERIOD, end)
    result.quality.add("steady-state temperature ripple", float(np.ptp(rest["TEMP"])), "K", "at most 0.03")
    return result


def draw(result, path):
    different = result.quality[f"calls of {len(result)} with another QPOS_P in PULS_CTR"]
    title = f"PULS_CTR makes the pulses of CONT_C with PULSEGEN: {different} of {len(result)} calls differ"
    labels = ["temperature in °C", "LMN in %", "pulses of the shaded time, and their share of the period"]
    with plot.picture(path, title, labels, [1.2, 0.8, 1.2], same_time=False) as axes:
        time = result.time
        axes[0].plot(time, result["SP_INT"], label="SP_INT", drawstyle="steps-post", **plot.SETPOINT)
        axes[0].plot(time, result["TEMP"], label="temperature", **plot.PROCESS_VALUE)
        axes[1].plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **plot.MANIPULATED)
        axes[0].sharex(axes[1])
        axes[0].tick_params(labelbottom=False)
        axes[0].set_xlabel("")

        closely = STEP - PERIOD, STEP + 8 * PERIOD
        plot.mark(axes[:2], *closely, "")
        part = result.between(closely[0], closely[1] + CYCLE)
        plot.pulses(axes[2], part.time, part["QPOS_P"], 1.3, **plot.PULSE)
        plot.pulses(axes[2], part.time, part["PULS_CTR_QPOS_P"], **plot.PULSE)
        periods = np.arange(closely[0], closely[1], PERIOD)
        for start in periods:
            of_period = result.between(start, start + PERIOD)
            share = 100.0 * float(np.mean(of_period["QPOS_P"]))
            axes[2].annotate(
                f"{share:.1f} %", (start + PERIOD / 2, 2.4), ha="center", fontsize=8, color=plot.TEXT_COLOR
            )
        axes[2].set_xticks(np.append(periods, closely[1]))
        axes[2].set_yticks([0.5, 1.8], ["PULS_CTR", "PULSEGEN"])
        axes[2].set_xlim(*closely)
        axes[2].set_ylim(-0.1, 3.0)
        axes[2].grid(axis="y", visible=False)
        for each in axes[:2]:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"CONT_C with PULSEGEN, and PULS_CTR: GAIN {GAIN:.2f} %/K, TI {TI:.0f} s, RED_FAC {RED_FAC}")
        result = run(fmus)
        print(result.quality)
        result.to_csv(out / "pulse_width.csv", digits=9)
        draw(result, out / "pulse_width")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
