"""Your own plant in the loop: CONT_C with any FMI 2.0 co-simulation FMU.

Replace "HEATER" with the path of your FMU, POWER with the name of its input for the manipulated
value, and TEMP with the name of its output for the process value.

The settings follow SIMC for the furnace: lags of 120 s and 20 s, a delay of 5 s, a gain of 3 K/%,
and LAMBDA = 30 s.
"""

import plcfmu


def run(fmus, plant="HEATER"):
    """From steady state at 20 degC to 80 degC."""
    controller = fmus.start("CONT_C", MAN_ON=False, CYCLE=1.0, GAIN=0.95, TI=130.0)
    plant = fmus.start(plant, name="PLANT")
    connections = {"CONT_C.LMN": "PLANT.POWER", "PLANT.TEMP": "CONT_C.PV_IN"}
    setpoint = {"CONT_C.SP_INT": [(0.0, 20.0), (30.0, 80.0)]}
    return plcfmu.simulate(controller, plant, connections, inputs=setpoint, step=1.0, duration=600.0)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        result = run(fmus)
    quality = result.between(30.0, 600.0).figures("PLANT.TEMP", "CONT_C.SP_INT", start=20.0, end=80.0)
    print(quality)
    result.to_csv(out / "own_plant.csv")
    title = "Your plant, here HEATER: 60 K more, 10 to 90 % in {:.0f} s, with {:.0f} % overshoot"
    title = title.format(quality["rise"], quality["overshoot"])
    panels = {"temperature in °C": ["CONT_C.SP_INT", "PLANT.TEMP"], "LMN in %": ["CONT_C.LMN"]}
    result.plot(out / "own_plant", panels, title)
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
