"""Level control of a tank with CONT_C: the effect of the reset time on a process with little
self-regulation.

    setpoint --SP_INT--> CONT_C --LMN----> VALVE  TANK --L_PER--+
                           ^                ^                   |
                           |              DRAIN                 |
                           +----------PV_PER--------------------+

The level is the analog word L_PER, 0 ... 27648 for 0 ... 2 m; PV_FAC = 0.02 converts it to m, so
GAIN is in % per m.

The outflow follows the square root of the level, so gain and time constant depend on the operating
point. At 1 m with the drain half open they are K = 6.3 cm/% and T = 752 s: to a loop with a time
constant of half a minute, the tank is an integrator of K / T = 0.083 mm/s per percent. GAIN = T /
(K LAMBDA) gives the proportional loop a time constant LAMBDA = 40 s (SIMC, without delay).

Theory, with K / T as an integrator:
- TI = T: the controller cancels the tank's own time constant. The response to a setpoint step is a
  lag of LAMBDA, without overshoot, but the effect of a disturbance decays no faster than in the
  uncontrolled tank, with TI.
- TI = 4 LAMBDA, the SIMC rule: the loop is critically damped, with two time constants of TI / 2,
  and the zero of the controller makes the setpoint response overshoot by at most exp(-2) = 13.5 %
  (less, because the tank has some self-regulation). A disturbance decays in a fifth of the time.

In both cases, the integral of the error that compensates for the drain is d_LMN TI / GAIN (a
fraction exp(-t / TI) of it remains at time t after the change).
"""

import math

import plcfmu
from plcfmu import plot
from plcfmu.figures import integral_error

CYCLE = 1.0
# TANK with its start values, at 1 m with the drain half open.
LEVEL, AREA, FLOW_MAX, A_OUT, CD, DRAIN, G = 1.0, 0.2, 100.0 / 60000.0, 0.0004, 0.6, 0.5, 9.81
OUTFLOW = CD * A_OUT * DRAIN * math.sqrt(2 * G * LEVEL)
T = AREA * 2 * LEVEL / OUTFLOW
K = FLOW_MAX / 100.0 / AREA * T

LAMBDA = 40.0
GAIN = T / (K * LAMBDA)
FAST_TI = 4 * LAMBDA

LOW, HIGH = 0.9, 1.0
STEP, DRAINS, END = 50.0, 700.0, 2000.0
MORE_DRAIN = 65.0


def run(fmus, ti):
    """The setpoint rises from 0.9 to 1 m; later the drain is opened from 50 to 65 %."""
    valve_at_start = 100.0 * OUTFLOW * math.sqrt(LOW / LEVEL) / FLOW_MAX
    tank = fmus.start("TANK", L_START=LOW, VALVE=valve_at_start)
    controller = fmus.start(
        "CONT_C", MAN_ON=False, CYCLE=CYCLE, GAIN=GAIN, TI=ti, PVPER_ON=True, PV_FAC=0.02, I_ITLVAL=valve_at_start
    )
    result = plcfmu.simulate(
        controller,
        tank,
        {"CONT_C.LMN": "TANK.VALVE", "TANK.L_PER": "CONT_C.PV_PER"},
        inputs={
            "CONT_C.SP_INT": [(0.0, LOW), (STEP, HIGH)],
            "TANK.DRAIN": [(0.0, 100.0 * DRAIN), (DRAINS, MORE_DRAIN)],
        },
        record={
            **{name: f"CONT_C.{name}" for name in ("SP_INT", "PV", "LMN", "LMN_P", "LMN_I")},
            **{name: f"TANK.{name}" for name in ("DRAIN", "LEVEL", "OUTFLOW")},
        },
        step=CYCLE,
        duration=END,
        title=f"level control, TI {ti:.0f} s",
    )

    name = f"TI {ti:.0f} s"
    step, drained = result.between(STEP, DRAINS), result.between(DRAINS, END)
    if ti == T:
        settling, iae = math.log(50) * LAMBDA, (HIGH - LOW) * LAMBDA
        theory = {"rise": 2.2 * LAMBDA, "overshoot": 0.0, "settling": settling, "iae": iae}
    else:
        theory = {"overshoot": f"at most {100.0 * math.exp(-2):.1f}"}
    result.quality += step.figures("LEVEL", "SP_INT", LOW, HIGH, unit="m", prefix=f"{name}: ", theory=theory)
    more = 100.0 * OUTFLOW / FLOW_MAX * (MORE_DRAIN / (100.0 * DRAIN) - 1.0)
    result.quality.add(f"{name}: drain, largest deviation", 100.0 * float(max(HIGH - drained["LEVEL"])), "cm")
    result.quality.add(
        f"{name}: drain, integral of the error",
        integral_error(drained.time, drained["PV"], drained["SP_INT"]),
        "m s",
        more * ti / GAIN * (1.0 - math.exp(-(END - DRAINS) / ti)),
    )
    return result


def draw(slow, fast, path):
    fast_name, slow_name = f"TI {FAST_TI:.0f} s", f"TI {T:.0f} s"
    drained = "drain, integral of the error"
    share = fast.quality[f"{fast_name}: {drained}"] / slow.quality[f"{slow_name}: {drained}"]
    title = (
        f"{fast_name} instead of {T:.0f} s leaves {100.0 * share:.0f} % of the drain's error integral, "
        f"but overshoots by {fast.quality[f'{fast_name}: overshoot']:.0f} %"
    )
    with plot.picture(path, title, ["level in m", "inflow valve in %"], [1.4, 1]) as axes:
        axes[0].plot(fast.time, fast["SP_INT"], label="SP_INT", drawstyle="steps-post", **plot.SETPOINT)
        axes[0].plot(slow.time, slow["LEVEL"], label=f"level, {slow_name}", **plot.COMPARED)
        axes[0].plot(fast.time, fast["LEVEL"], label=f"level, {fast_name}", **plot.PROCESS_VALUE)
        axes[1].plot(slow.time, slow["LMN"], label=f"LMN, {slow_name}", drawstyle="steps-post", **plot.COMPARED)
        axes[1].plot(fast.time, fast["LMN"], label=f"LMN, {fast_name}", drawstyle="steps-post", **plot.MANIPULATED)
        plot.event(axes, DRAINS, f"drain {100.0 * DRAIN:.0f} → {MORE_DRAIN:.0f} % open", 0.3)
        for each in axes:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"Level of a tank with CONT_C: GAIN {GAIN:.0f} %/m, TI {T:.0f} s or {FAST_TI:.0f} s")
        slow, fast = run(fmus, T), run(fmus, FAST_TI)
        for each in (slow, fast):
            print(each.quality)
        fast.to_csv(out / "tank.csv", digits=9)
        slow.to_csv(out / "tank_slow.csv", digits=9)
        draw(slow, fast, out / "tank")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
