"""Furnace with CONT_C: a setpoint step, an opened door, and two ways to heat up from cold.

    setpoint --SP_INT--> CONT_C --LMN----> POWER  HEATER --T_PER--+
                           ^                                      |
                           +----------PV_PER----------------------+

The process value takes the whole way of a PLC: the analog word T_PER, 0 ... 27648 for 0 ... 400
degC, goes to PV_PER, and PVPER_ON, PV_FAC = 4 make degC of it.

Tuning: SIMC (Skogestad, internal model control made simple) for the furnace's documented gain K = 3
K/%, lags of 120 s and 20 s and delay of 5 s, for a closed loop with the time constant LAMBDA = 20
s. The loop without the controller is then cancelled down to

    L(s) = exp(-5.5 s) / ((LAMBDA + THETA) s (TM_LAG s + 1)),   THETA = 5 s delay + 0.5 s CYCLE / 2 + 5 s TM_LAG

so theory predicts a first-order answer to the setpoint: rise time 2.2 LAMBDA, no overshoot (LAMBDA
+ THETA is more than e THETA), within 2 % after the delay and 3.9 LAMBDA, and an error that adds up
to step * (LAMBDA + THETA). An opened door asks for a LMN that is larger by dLMN; the integrator has
to make it, and integrates an error of dLMN TI / GAIN for it.
"""

import math

import loop

CYCLE = 1.0
# The furnace: HEATER's parameters as they are.
K, T1, T2, DELAY = 3.0, 120.0, 20.0, 5.0
# The loop.
LAMBDA = 20.0
TM_LAG = 5.0
THETA = DELAY + CYCLE / 2 + TM_LAG
# SIMC gives a controller KC (1 + 1 / (T1 s)) (1 + T2 s) / (1 + TM_LAG s); CONT_C adds its parts, and this is the same:
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
SIGNALS = "PV LMN LMN_P LMN_I LMN_D QLMN_HLM"

AUTOMATIC, STEP, DOOR, END = 30.0, 60.0, 300.0, 720.0
COLD, HOT, COLD_END = 20.0, 200.0, 500.0


def run(fmus):
    """In manual mode at rest at 170 degC, to automatic, 10 K more, and then the door half open."""
    controller = fmus.start("CONT_C", PID, MAN_ON=True, MAN=50.0)
    furnace = fmus.start("HEATER", T_START=170.0)
    result = loop.Result()
    for t in loop.clock(END, CYCLE, "furnace with CONT_C"):
        setpoint = 180.0 if t >= STEP else 170.0
        door = 50.0 if t >= DOOR else 0.0
        controller.step(t, CYCLE, SP_INT=setpoint, PV_PER=furnace["T_PER"], MAN_ON=t < AUTOMATIC)
        result.add(t, SP_INT=setpoint, **controller.get(SIGNALS), DOOR=door, TEMP=furnace["TEMP"])
        furnace.step(t, CYCLE, POWER=controller["LMN"], DOOR=door)

    step = result.between(STEP, DOOR)
    settled = DELAY + CYCLE / 2 + math.log(50) * LAMBDA
    theory = 2.2 * LAMBDA, 0.0, settled, 10.0 * (LAMBDA + THETA)
    result.step_figures(step, "PV", "SP_INT", 170.0, 180.0, "K s", theory=theory)

    door = result.between(DOOR, END)
    more_power = 0.25 * (180.0 - 20.0) / K  # the door half open: a quarter more loss
    peak = math.log(T1 / LAMBDA) * T1 * LAMBDA / (T1 - LAMBDA)
    share = (math.exp(-peak / T1) - math.exp(-peak / LAMBDA)) / (T1 - LAMBDA)
    result.figure(
        "door: largest deviation",
        float(max(180.0 - door["PV"])),
        "K",
        K * more_power * (LAMBDA + THETA) * share,
    )
    result.figure(
        "door: integral of the error",
        loop.control_error(door, "PV", "SP_INT"),
        "K s",
        more_power * TI / GAIN,
    )
    return result


def cold_start(fmus, by_hand):
    """From 20 to 200 degC: in automatic mode, or with full power by hand up to 170 degC and automatic from there."""
    controller = fmus.start("CONT_C", PID, MAN=100.0)
    furnace = fmus.start("HEATER", T_START=COLD)
    result = loop.Result()
    manual = by_hand
    for t in loop.clock(
        COLD_END, CYCLE, "cold start by hand" if by_hand else "cold start in automatic mode"
    ):
        manual = manual and furnace["TEMP"] < 170.0
        controller.step(t, CYCLE, SP_INT=HOT, PV_PER=furnace["T_PER"], MAN_ON=manual)
        result.add(t, SP_INT=HOT, **controller.get(SIGNALS), MAN_ON=manual)
        furnace.step(t, CYCLE, POWER=controller["LMN"])

    way = "by hand" if by_hand else "automatic"
    prefix = f"cold start {way}: "
    theory = None, 0.0, None, None
    result.step_figures(result, "PV", "SP_INT", COLD, HOT, "K s", prefix, theory)
    return result


def draw(result, path):
    figure, axes = loop.picture(
        "Furnace with CONT_C: a setpoint step of 10 K, then the door opens by half",
        ["temperature in °C", "manipulated value in %", "its parts in %"],
        [1.25, 1, 1],
    )
    time = result.time
    axes[0].plot(time, result["SP_INT"], label="SP_INT", drawstyle="steps-post", **loop.SETPOINT)
    axes[0].plot(time, result["PV"], label="PV", **loop.PROCESS_VALUE)
    axes[1].plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **loop.MANIPULATED)
    axes[2].plot(time, result["LMN_I"], label="LMN_I", drawstyle="steps-post", **loop.I_PART)
    axes[2].plot(time, result["LMN_P"], label="LMN_P", drawstyle="steps-post", **loop.P_PART)
    axes[2].plot(time, result["LMN_D"], label="LMN_D", drawstyle="steps-post", **loop.D_PART)
    axes[0].set_ylim(168, 183.5)
    axes[1].set_ylim(40, 105)
    loop.mark(axes, 0.0, AUTOMATIC, "manual", loop.MANUAL)
    loop.mark(axes, DOOR, END, "disturbance: door half open")
    for each in axes:
        loop.legend(each)
    loop.save_picture(figure, path)


def draw_cold_start(automatic, by_hand, path):
    figure, axes = loop.picture(
        "Cold start of the furnace: integrator stopped at the limit, or heated by hand and handed over",
        [
            "temperature in °C",
            "automatic from the start:\nLMN and LMN_I in %",
            "by hand up to 170 °C:\nLMN and LMN_I in %",
        ],
        [1.25, 1, 1],
    )
    time = automatic.time
    axes[0].plot(time, automatic["SP_INT"], label="SP_INT", **loop.SETPOINT)
    axes[0].plot(
        time,
        automatic["PV"],
        label="PV, automatic from the start",
        **{**loop.PROCESS_VALUE, "color": loop.COMPARED["color"]},
    )
    axes[0].plot(time, by_hand["PV"], label="PV, by hand up to 170 °C", **loop.PROCESS_VALUE)
    for each, result in ((axes[1], automatic), (axes[2], by_hand)):
        each.plot(time, result["LMN"], label="LMN", drawstyle="steps-post", **loop.MANIPULATED)
        each.plot(time, result["LMN_I"], label="LMN_I", drawstyle="steps-post", **loop.I_PART)
        each.set_ylim(-5, 109)
    limited = time[automatic["QLMN_HLM"] == 1]
    loop.mark(
        [axes[1]],
        limited[0],
        limited[-1] + CYCLE,
        "shaded: LMN at its limit, the integrator stands still",
        at=(110.0, 1.0),
    )
    manual = time[by_hand["MAN_ON"] == 1]
    loop.mark(
        [axes[2]],
        manual[0],
        manual[-1] + CYCLE,
        "shaded: manual, MAN = 100 %; LMN_I follows as MAN - LMN_P",
        loop.MANUAL,
        at=(110.0, 1.0),
    )
    for each in axes:
        loop.legend(each)
    loop.save_picture(figure, path)


def main():
    folder, out = loop.arguments(__doc__)
    with loop.Fmus(folder) as fmus:
        print(
            f"Furnace with CONT_C: GAIN {GAIN:.3f}, TI {TI:.1f} s, TD {TD:.2f} s, TM_LAG {TM_LAG:.0f} s"
        )
        result = run(fmus)
        automatic, by_hand = cold_start(fmus, False), cold_start(fmus, True)
        for each in (result, automatic, by_hand):
            each.print_figures()
        loop.save_csv(result, out / "cont_c_heater.csv")
        loop.save_csv(automatic, out / "cont_c_heater_cold_start.csv")
        loop.save_csv(by_hand, out / "cont_c_heater_cold_start_by_hand.csv")
        draw(result, out / "cont_c_heater.png")
        draw_cold_start(automatic, by_hand, out / "cont_c_heater_cold_start.png")


if __name__ == "__main__":
    main()
