"""Random signals for the inputs of any FMU, the same for the same seed."""

import random

# Where the starts would let nothing happen in a short run.
SETTINGS = {
    "CONT_C": {"D_SEL": 1},
    "PULSEGEN": {"PER_TM": 0.1, "P_B_TM": 0.0},
    "PULS_CTR": {"RED_FAC": 5, "DI_PULSEGEN.P_B_TM": 0.0},
}


def settings(fmu):
    return dict(SETTINGS.get(fmu.table["name"], {}))


def draw(fmu, name, generator):
    """A value for a variable, of its type and within its range."""
    kind = fmu.kinds[name]
    variable = fmu.variables[name]
    if kind == "BOOL":
        return int(generator.random() < 0.2)
    low = -100.0 if variable.min is None else float(variable.min)
    high = max(low, 0.0) + 100.0 if variable.max is None else float(variable.max)
    if kind in ("INT", "WORD"):
        return generator.randint(int(low), int(high))
    if kind == "TIME":
        return generator.randint(0, 10_000) / 1000
    return generator.uniform(low, high)


def rows(fmu, count, seed=0):
    """`count` sets of values for all inputs; in each only some of them change."""
    generator = random.Random(f"{fmu.name} {seed}")
    inputs = fmu.of("input")
    values = {name: draw(fmu, name, generator) for name in inputs}
    drawn = [dict(values)]
    while len(drawn) < count:
        for name in inputs:
            if generator.random() < 0.3:
                values[name] = draw(fmu, name, generator)
        drawn.append(dict(values))
    return drawn
