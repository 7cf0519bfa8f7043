"""Your own block in a loop: the two-point controller TWO_POINT of examples/my_block switches the
furnace on and off.

    setpoint --SP--> TWO_POINT --Q_MEAN--> POWER  HEATER --TEMP--+
                        ^                                        |
                        +------------------PV--------------------+

Q is a Boolean and POWER a Real in percent: Q_MEAN, here 0 or 100 %, connects them.

Call order: every 100 ms, TWO_POINT is called with the temperature at t, then the furnace is stepped
to t + 100 ms with its output.

The furnace has a fast sensor here (SENS_TM = 2 s). Holding 180 degC takes 53.3 % of full power;
with the heating on, the temperature rises at 300 K / 120 s * (1 - 0.533) = 1.17 K/s, and with it
off, it falls at 1.33 K/s.

Theory: the output oscillates forever, because the temperature keeps rising or falling until a
switch takes effect: for the delay of 5 s plus up to 2 s of sensor lag. So the temperature swings
over HYS plus 5 to 7 s of both slopes, 4 K + 2.5 K/s * 5 ... 7 s = 16.5 to 21.5 K, and a period
lasts as long as this swing up and down, 27 to 35 s. The mean power is the power that holds the mean
temperature.
"""

import numpy as np

import plcfmu
from plcfmu import plot

CYCLE = 0.1
SETPOINT, HYS = 180.0, 4.0
ON, OFF = 300.0 / 120.0 * (1.0 - 160.0 / 300.0), 160.0 / 120.0
SETTLED, END = 120.0, 360.0


def run(fmus):
    """From steady state at 170 degC to 180 degC. A row is a call."""
    controller = fmus.start("TWO_POINT", CYCLE=CYCLE, HYS=HYS)
    furnace = fmus.start("HEATER", CYCLE=CYCLE, T_START=170.0, SENS_TM=2.0)
    result = plcfmu.simulate(
        controller,
        furnace,
        {"TWO_POINT.Q_MEAN": "HEATER.POWER", "HEATER.TEMP": "TWO_POINT.PV"},
        inputs={"TWO_POINT.SP": SETPOINT},
        record={"SP": "TWO_POINT.SP", "PV": "HEATER.TEMP", "Q": "TWO_POINT.Q", "Q_MEAN": "TWO_POINT.Q_MEAN"},
        step=CYCLE,
        duration=END,
        title="furnace with TWO_POINT",
    )

    swinging = result.between(SETTLED, END)
    switched_on = swinging.time[1:][np.diff(swinging["Q"]) == 1]
    whole = result.between(switched_on[0], switched_on[-1])
    result.quality.add(
        "swing of the temperature",
        float(np.ptp(whole["PV"])),
        "K",
        f"{HYS + (ON + OFF) * 5:.1f} ... {HYS + (ON + OFF) * 7:.1f}",
    )
    shortest, longest = ((HYS + (ON + OFF) * late) * (1 / ON + 1 / OFF) for late in (5, 7))
    result.quality.add("period", float(np.mean(np.diff(switched_on))), "s", f"{shortest:.0f} ... {longest:.0f}")
    result.quality.add(
        "mean of the power", float(np.mean(whole["Q_MEAN"])), "%", float(np.mean(whole["PV"]) - 20.0) / 3.0
    )
    return result


def draw(result, path):
    title = (
        f"The temperature swings by {result.quality['swing of the temperature']:.0f} K around a band of {HYS:.0f} K, "
        f"once in {result.quality['period']:.0f} s"
    )
    with plot.picture(path, title, ["temperature in °C", "output Q"], [1.6, 0.5]) as axes:
        time = result.time
        axes[0].axhspan(SETPOINT - HYS / 2, SETPOINT + HYS / 2, zorder=0, label="band HYS", **plot.SPAN)
        axes[0].plot(time, result["SP"], label="SP", **plot.SETPOINT)
        axes[0].plot(time, result["PV"], label="PV", **plot.PROCESS_VALUE)
        axes[0].set_yticks(range(170, 191, 5))
        plot.pulses(axes[1], time, result["Q"], **plot.PULSE)
        axes[1].set_yticks([0, 1], ["off", "on"])
        plot.legend(axes[0])


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print("Furnace with TWO_POINT, the block of examples/my_block")
        result = run(fmus)
        print(result.quality)
        result.to_csv(out / "two_point.csv", digits=9)
        draw(result, out / "two_point")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
