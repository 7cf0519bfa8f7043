"""Setpoint ramps from HLG: for a furnace with CONT_C, and for a drive that trips without a ramp.

    S1 --> HLG --HLG--> x 400/27648 --SP_INT--> CONT_C --LMN--> POWER  HEATER --T_PER--+
                                                  ^                                    |
                                                  +---------------PV_PER---------------+

    S1 --> HLG --HLG--> SP  DRIVE --> SPEED, TRIP

HLG counts in integers: here 27648 is 400 degC (for the furnace) and 32767 is 1500 rpm (for the
drive). It is called every second (furnace) or every 10 ms (drive), and TH_TZ is the number of calls
in which its output moves by the magnitude of its setpoint.

Call order: HLG, then CONT_C, then the plant. HLG starts with SET and with INIT at the furnace's
temperature, so that the ramp begins there.

Furnace: from 100 to 200 degC in a step or in 200 s, which takes TH_TZ = 400 calls, because the
slope is S1 / TH: 200 K / 400 s = 0.5 K/s. Tuning: SIMC's PI rule for the lag of 120 s and half of
the lag of 20 s, whose other half counts as delay; LAMBDA = 30 s. Theory: on a ramp a PI loop lags
by slope * TI / (K GAIN), and the power is what holds the temperature plus slope * 120 s / K = 20 %,
which is 80 % at the end. The step demands GAIN * 100 K = 95 % more immediately and hits the limit.

Drive: the speed follows with a lag CTRL_TM = 0.1 s, so on the ramp of 229 rpm/s it is 23 rpm behind
(plus half a call), and with an inertia of 2 s it takes 30.5 % torque. The monitor trips at 75 rpm:
the ramp of 100 calls, 916 rpm/s, would put the speed 92 rpm behind and trips the drive after 0.17
s; a setpoint step without a ramp trips it in the first call.
"""

import math

import numpy as np

import plcfmu
from plcfmu import plot

# The furnace: HEATER's parameters, SIMC's PI.
CYCLE = 1.0
K, T1, T2, DELAY = 3.0, 120.0, 20.0, 5.0
LAMBDA = 30.0
THETA = DELAY + T2 / 2 + CYCLE / 2
GAIN = (T1 + T2 / 2) / (K * (LAMBDA + THETA))
TI = T1 + T2 / 2
COLD, HOT = 100.0, 200.0
TH_TZ = 400
STEP, END = 30.0, 600.0
SLOPE = HOT / (TH_TZ * CYCLE)

# The drive.
DRIVE_CYCLE = 0.01
COUNTS, DRIVE_TH_TZ, STEEP_TH_TZ = 20000, 400, 100
CTRL_TM, ERR_MAX = 0.1, 75.0
RPM = 1500.0 * COUNTS / 32767
DRIVE_STEP, DRIVE_END = 0.5, 6.0


def counts(temperature):
    return round(27648 * temperature / 400.0)


def furnace(fmus, with_ramp):
    """From 100 to 200 degC, as a step or along the ramp."""
    power = (COLD - 20.0) / K
    ramp = fmus.start("HLG", TZ=CYCLE, TH_TZ=TH_TZ if with_ramp else 0, INIT=counts(COLD), S1=counts(HOT), E01=True)
    controller = fmus.start(
        "CONT_C", MAN_ON=False, CYCLE=CYCLE, GAIN=GAIN, TI=TI, PVPER_ON=True, PV_FAC=4.0, I_ITLVAL=power
    )
    heater = fmus.start("HEATER", T_START=COLD)
    result = plcfmu.simulate(
        [ramp, controller],
        heater,
        {"CONT_C.LMN": "HEATER.POWER", "HEATER.T_PER": "CONT_C.PV_PER"},
        inputs={"HLG.SET": [(0.0, True), (STEP, False)], "CONT_C.SP_INT": lambda t: ramp["HLG"] * 400.0 / 27648},
        record={**{name: f"CONT_C.{name}" for name in "SP_INT PV LMN LMN_P LMN_I QLMN_HLM".split()}, "HLG": "HLG.HLG"},
        step=CYCLE,
        duration=END,
        title="furnace with a ramp" if with_ramp else "furnace with a step",
    )

    way = "ramp" if with_ramp else "step"
    rising = result.between(STEP, END)
    if with_ramp:
        late = result.between(STEP + (HOT - COLD) / SLOPE - 5.0, STEP + (HOT - COLD) / SLOPE)
        result.quality.add(
            f"furnace, {way}: behind the setpoint at its end",
            float(np.mean(late["SP_INT"] - late["PV"])),
            "K",
            SLOPE * TI / (K * GAIN),
        )
    error = (HOT - COLD) / K * TI / GAIN if with_ramp else None
    prefix = f"furnace, {way}: "
    theory = {"overshoot": "at most 2", "iae": error}
    result.quality += rising.figures("PV", "SP_INT", COLD, HOT, unit="K", prefix=prefix, theory=theory)
    result.quality.add(
        f"furnace, {way}: largest LMN",
        float(max(result["LMN"])),
        "%",
        (HOT - 20.0 + SLOPE * T1) / K if with_ramp else 100.0,
    )
    return result


def drive(fmus, th_tz):
    """From standstill to 916 rpm along a ramp of `th_tz` calls; 0 means a step."""
    ramp = fmus.start("HLG", TZ=DRIVE_CYCLE, TH_TZ=th_tz, E01=True)
    motor = fmus.start("DRIVE", CYCLE=DRIVE_CYCLE)
    result = plcfmu.Result()
    for t in plcfmu.clock(DRIVE_END, DRIVE_CYCLE, f"drive, TH_TZ {th_tz}"):
        ramp.step(t, DRIVE_CYCLE, S1=COUNTS if t >= DRIVE_STEP - DRIVE_CYCLE / 2 else 0)
        speed = motor["SPEED"]
        motor.step(t, DRIVE_CYCLE, SP=ramp["HLG"])
        result.add(t, HLG=ramp["HLG"], SP_RPM=motor["SP_RPM"], SPEED=speed, TORQUE=motor["TORQUE"], TRIP=motor["TRIP"])

    name = f"drive, TH_TZ {th_tz}"
    slope = RPM / (th_tz * DRIVE_CYCLE) if th_tz else math.inf
    trips = CTRL_TM * slope > ERR_MAX
    result.quality.add(f"{name}: tripped", "yes" if result["TRIP"][-1] else "no", "", "yes" if trips else "no")
    if trips:
        when = 0.0 if th_tz == 0 else -CTRL_TM * math.log(1.0 - ERR_MAX / (CTRL_TM * slope))
        result.quality.add(f"{name}: tripped after", float(result.time[result["TRIP"] == 1][0]) - DRIVE_STEP, "s", when)
    else:
        middle = result.between(2.0, 4.0)
        behind = float(np.mean(middle["SP_RPM"] - middle["SPEED"]))
        result.quality.add(f"{name}: behind the setpoint", behind, "rpm", (CTRL_TM + DRIVE_CYCLE / 2) * slope)
        result.quality.add(f"{name}: torque", float(np.mean(middle["TORQUE"])), "%", 100.0 * slope / 750.0)
    result.quality.add(f"{name}: speed at the end", float(result["SPEED"][-1]), "rpm", None if trips else RPM)
    return result


def draw_furnace(ramp, step, path):
    behind = ramp.quality["furnace, ramp: behind the setpoint at its end"]
    largest = [result.quality[f"furnace, {way}: largest LMN"] for result, way in ((ramp, "ramp"), (step, "step"))]
    title = (
        f"On HLG's ramp the furnace stays {behind:.0f} K behind, with {largest[0]:.0f} % power at most; "
        f"a step takes {largest[1]:.0f} %"
    )
    with plot.picture(path, title, ["temperature in °C", "LMN in %"], [1.3, 1]) as axes:
        axes[0].plot(ramp.time, ramp["SP_INT"], label="SP_INT from HLG", **plot.SETPOINT)
        axes[0].plot(step.time, step["SP_INT"], drawstyle="steps-post", linestyle="--", **plot.COMPARED)
        axes[0].plot(step.time, step["PV"], label="PV, setpoint at once", **plot.COMPARED)
        axes[0].plot(ramp.time, ramp["PV"], label="PV, ramp", **plot.PROCESS_VALUE)
        axes[1].plot(step.time, step["LMN"], label="LMN, setpoint at once", drawstyle="steps-post", **plot.COMPARED)
        axes[1].plot(ramp.time, ramp["LMN"], label="LMN, ramp", drawstyle="steps-post", **plot.MANIPULATED)
        axes[0].set_ylim(92, 215)
        axes[1].set_ylim(0, 106)
        plot.mark(axes, STEP, STEP + (HOT - COLD) / SLOPE, "HLG runs up")
        for each in axes:
            plot.legend(each)


def draw_drive(ramp, steep, path):
    title = (
        f"The ramp of {DRIVE_TH_TZ} calls leaves the speed "
        f"{ramp.quality[f'drive, TH_TZ {DRIVE_TH_TZ}: behind the setpoint']:.0f} rpm behind; "
        f"that of {STEEP_TH_TZ} calls trips after {steep.quality[f'drive, TH_TZ {STEEP_TH_TZ}: tripped after']:.2f} s"
    )
    ways = f"TH_TZ = {DRIVE_TH_TZ}", f"TH_TZ = {STEEP_TH_TZ}"
    labels = [f"{ways[0]}: speed in rpm", f"{ways[1]}: speed in rpm", "torque in %"]
    with plot.picture(path, title, labels, [1, 1, 0.9]) as axes:
        for each, result in ((axes[0], ramp), (axes[1], steep)):
            each.plot(result.time, result["SP_RPM"], label="setpoint from HLG", drawstyle="steps-post", **plot.SETPOINT)
            each.plot(result.time, result["SPEED"], label="speed", **plot.PROCESS_VALUE)
            each.set_ylim(-40, 1050)
        for result, way, style in ((steep, ways[1], plot.COMPARED), (ramp, ways[0], plot.MANIPULATED)):
            axes[2].plot(result.time, result["TORQUE"], label=f"torque, {way}", drawstyle="steps-post", **style)
        tripped = steep.time[steep["TRIP"] == 1]
        text = f"TRIP: speed more than {ERR_MAX:.0f} rpm behind the setpoint; the drive coasts"
        plot.mark([axes[1]], tripped[0], DRIVE_END, text, at=(1.6, 0.6))
        for each in axes:
            plot.legend(each)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print(f"Setpoint ramp of HLG into CONT_C: GAIN {GAIN:.3f}, TI {TI:.0f} s, {SLOPE} K/s")
        ramp, step = furnace(fmus, True), furnace(fmus, False)
        drive_ramp, drive_steep, drive_step = (drive(fmus, DRIVE_TH_TZ), drive(fmus, STEEP_TH_TZ), drive(fmus, 0))
        for each in (ramp, step, drive_ramp, drive_steep, drive_step):
            print(each.quality)
        ramp.to_csv(out / "ramp.csv", digits=9)
        step.to_csv(out / "ramp_none.csv", digits=9)
        drive_ramp.to_csv(out / "ramp_drive.csv", digits=9)
        drive_steep.to_csv(out / "ramp_drive_steep.csv", digits=9)
        draw_furnace(ramp, step, out / "ramp")
        draw_drive(drive_ramp, drive_steep, out / "ramp_drive")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
