"""Cascade of two CONT_C, temperature over flow: the benefit of the second controller when the
pressure drops.

    setpoint --SP_INT--> CONT_C ---LMN---> SP_INT  CONT_C --LMN--> DRIVE  VALVE --FLOW--+
                       temperature                  flow    |       ^                   |--TEMP--+
                           ^                        ^       |      PRES                 |        |
                           |                        +-------|---PV_IN-------------------+        |
                           +--------------------------------|---PV_IN----------------------------+

The temperature controller does not move the valve: it demands a flow of heating medium, in l/min,
and the flow controller finds the position for it. The cascade is compared with a single CONT_C that
moves the valve itself.

Call order, every 100 ms: temperature controller, flow controller, valve. The temperature controller
has CYCLE = 1 s; it is stepped with the others, and its block is called in every tenth step.

Tuning: the flow follows the valve without lag, so the flow controller is an I controller (P_SEL
off) with GAIN / TI = 1 / (0.4 l/min/% * 2 s), which gives the flow loop the time constant
FLOW_LAMBDA = 2 s. The temperature controller is a PI controller tuned by SIMC for the gain of 2
K/(l/min), lags of 20 s and 5 s and the flow loop, with LAMBDA = 10 s. The single controller has the
same settings, with the valve's 0.4 l/min/% included in the gain.

Theory: both respond alike to the setpoint, with a rise time of 2.2 LAMBDA. After the pressure drop,
the single controller has to find a new position by integrating an error of d_position TI / GAIN. In
the cascade the required flow is unchanged, so the temperature error integrates to 0, and the
largest deviation is the effect of the missing flow through the two lags while it decays. At 2.5 bar
the valve has 0.79 of its gain, so the missing flow decays with FLOW_LAMBDA / 0.79 = 2.5 s, and
causes at most 0.16 K per l/min.
"""

import math

import plcfmu
from plcfmu import plot
from plcfmu.figures import integral_error

STEP_SIZE = 0.1
# The process: VALVE's parameters, and its steady state.
FLOW_PER_PERCENT, RISE_PER_FLOW = 0.4, 2.0
T1, T2 = 20.0, 5.0
# The loops.
FLOW_LAMBDA, LAMBDA, CYCLE = 2.0, 10.0, 1.0
THETA = T2 / 2 + FLOW_LAMBDA + CYCLE / 2
GAIN = (T1 + T2 / 2) / (RISE_PER_FLOW * (LAMBDA + THETA))
TI = T1 + T2 / 2

AT_START, SETPOINT = 60.0, 65.0
STEP, DROP, END = 20.0, 150.0, 300.0
PRESSURE, LOW_PRESSURE = 4.0, 2.5


def run(fmus, with_flow_controller):
    """A setpoint step of 5 K at 20 s, and the pressure of the heating medium dropping from 4 to 2.5 bar at 150 s."""
    valve = fmus.start("VALVE", POS_ON=True, MTR_TM=5.0, POS_START=50.0, T_START=AT_START, CYCLE=STEP_SIZE)

    def measured_flow(t):
        # VALVE outputs its flow only after the first step.
        return valve["FLOW"] if t > 0.0 else 20.0

    settings = {"MAN_ON": False, "CYCLE": CYCLE, "TI": TI}
    inputs = {"TC.SP_INT": [(0.0, AT_START), (STEP, SETPOINT)], "VALVE.PRES": [(0.0, PRESSURE), (DROP, LOW_PRESSURE)]}
    record = {"SP_INT": "TC.SP_INT", "TEMP": "VALVE.TEMP"}
    if with_flow_controller:
        temperature = fmus.start("CONT_C", settings, name="TC", GAIN=GAIN, LMN_HLM=40.0, I_ITLVAL=20.0)
        flow_ti = FLOW_PER_PERCENT * FLOW_LAMBDA
        flow = fmus.start(
            "CONT_C", name="FC", MAN_ON=False, CYCLE=STEP_SIZE, P_SEL=False, GAIN=1.0, TI=flow_ti, I_ITLVAL=50.0
        )
        controllers = [temperature, flow]
        connections = {"VALVE.TEMP": "TC.PV_IN", "TC.LMN": "FC.SP_INT", "FC.LMN": "VALVE.DRIVE"}
        inputs["FC.PV_IN"] = measured_flow
        record.update({"FLOW_SP": "TC.LMN", "FLOW": measured_flow, "POSITION": "FC.LMN"})
    else:
        controllers = fmus.start("CONT_C", settings, name="TC", GAIN=GAIN / FLOW_PER_PERCENT, I_ITLVAL=50.0)
        connections = {"VALVE.TEMP": "TC.PV_IN", "TC.LMN": "VALVE.DRIVE"}
        record.update({"FLOW": measured_flow, "POSITION": "TC.LMN"})
    result = plcfmu.simulate(
        controllers,
        valve,
        connections,
        inputs=inputs,
        record={**record, "PRES": "VALVE.PRES"},
        step=STEP_SIZE,
        duration=END,
        title="cascade" if with_flow_controller else "single controller",
    )

    way = "cascade" if with_flow_controller else "single"
    step, drop = result.between(STEP, DROP), result.between(DROP, END)
    step_size = SETPOINT - AT_START
    theory = {"rise": 2.2 * LAMBDA, "iae": step_size * (LAMBDA + THETA)}
    result.quality += step.figures("TEMP", "SP_INT", AT_START, SETPOINT, unit="K", prefix=f"{way}: ", theory=theory)
    steady_flow = (SETPOINT - 20.0) / RISE_PER_FLOW
    left = math.sqrt(LOW_PRESSURE / PRESSURE)
    if with_flow_controller:
        missing = steady_flow * (1 - left)
        most = RISE_PER_FLOW * missing * FLOW_LAMBDA / left * largest_of_two_lags(T1, T2)
        result.quality.add(
            f"{way}: pressure drop, largest deviation", float(max(SETPOINT - drop["TEMP"])), "K", f"at most {most:.2f}"
        )
        error = 0.0
    else:
        result.quality.add(f"{way}: pressure drop, largest deviation", float(max(SETPOINT - drop["TEMP"])), "K")
        more = steady_flow / FLOW_PER_PERCENT * (1 / left - 1)
        error = more * TI / (GAIN / FLOW_PER_PERCENT)
    result.quality.add(
        f"{way}: pressure drop, integral of the error",
        integral_error(drop.time, drop["TEMP"], drop["SP_INT"]),
        "K s",
        error,
    )
    return result


def largest_of_two_lags(t1, t2):
    """The peak of the response of two lags to an impulse of area 1."""
    when = math.log(t1 / t2) * t1 * t2 / (t1 - t2)
    return (math.exp(-when / t1) - math.exp(-when / t2)) / (t1 - t2)


def draw(cascade, single, path):
    of_cascade, of_single = (
        result.quality[f"{way}: pressure drop, largest deviation"]
        for result, way in ((cascade, "cascade"), (single, "single"))
    )
    title = f"The pressure drop costs the cascade {of_cascade:.1f} K, the single controller {of_single:.1f} K"
    with plot.picture(path, title, ["temperature in °C", "flow in l/min", "valve position in %"], [1.3, 1, 1]) as axes:
        axes[0].plot(cascade.time, cascade["SP_INT"], label="setpoint", drawstyle="steps-post", **plot.SETPOINT)
        axes[0].plot(single.time, single["TEMP"], label="temperature, single", **plot.COMPARED)
        axes[0].plot(cascade.time, cascade["TEMP"], label="temperature, cascade", **plot.PROCESS_VALUE)
        axes[1].plot(
            cascade.time, cascade["FLOW_SP"], label="flow setpoint, cascade", drawstyle="steps-post", **plot.SETPOINT
        )
        axes[1].plot(single.time, single["FLOW"], label="flow, single", **plot.COMPARED)
        axes[1].plot(cascade.time, cascade["FLOW"], label="flow, cascade", **plot.PROCESS_VALUE)
        for result, style, way in ((single, plot.COMPARED, "single"), (cascade, plot.MANIPULATED, "cascade")):
            axes[2].plot(result.time, result["POSITION"], label=f"position, {way}", drawstyle="steps-post", **style)
        plot.event(axes, DROP, f"pressure {PRESSURE:g} → {LOW_PRESSURE:g} bar", 0.3)
        for each in axes:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(
            f"Cascade, temperature over flow: GAIN {GAIN:.3f} l/min/K, TI {TI:.1f} s; "
            f"flow I controller, {FLOW_LAMBDA:.0f} s"
        )
        cascade, single = run(fmus, True), run(fmus, False)
        print(cascade.quality)
        print(single.quality)
        cascade.to_csv(out / "cascade.csv", digits=9)
        single.to_csv(out / "cascade_single.csv", digits=9)
        draw(cascade, single, out / "cascade")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
