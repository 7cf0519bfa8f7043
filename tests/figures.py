"""The manual's figures as numbers: characteristics of PULSEGEN, computed from its formulas.

The manual's text gives the formulas, and its figures 3-6 to 3-9 show the curves. This module knows
nothing of REALs and calls: it computes in fractions what share of a period is a pulse. The results
lie in `traces/figures/`; `python tests/figures.py` writes them anew.

    duration = |INV| / 100 * PER_TM, for the negative pulse times RATIOFAC (RATIOFAC < 1), for the
               positive one divided by it (RATIOFAC > 1)
    a pulse shorter than P_B_TM is suppressed, one longer than PER_TM - P_B_TM becomes PER_TM;
    both thresholds, and by our decision the full pulse, are scaled with RATIOFAC as the pulse is
    bipolar two-step: (INV + 100) / 2 percent; monopolar: INV percent, none below 0
"""

import pathlib
from fractions import Fraction

from files import rows

FOLDER = pathlib.Path(__file__).parent / "traces" / "figures"
SWEEP = [half / 2 for half in range(-220, 221)]

# 400 calls a period, so that half a percent is a whole number of calls in every mode.
PERIOD = {"CYCLE": 0.01, "PER_TM": 4.0, "P_B_TM": 0.4}
CHARACTERISTICS = {
    "figure_3_6": {**PERIOD, "STEP3_ON": 1, "RATIOFAC": 1.0},
    "figure_3_7": {**PERIOD, "STEP3_ON": 1, "RATIOFAC": 0.5},
    "figure_3_8": {**PERIOD, "STEP3_ON": 0, "ST2BI_ON": 1},
    "figure_3_9": {**PERIOD, "STEP3_ON": 0, "ST2BI_ON": 0},
    "ratio_factor_2": {**PERIOD, "STEP3_ON": 1, "RATIOFAC": 2.0},
}
SHOWS = {
    "figure_3_6": "Figure 3-6: three-step control, symmetrical (RATIOFAC 1)",
    "figure_3_7": "Figure 3-7: three-step control, asymmetrical (RATIOFAC 0.5)",
    "figure_3_8": "Figure 3-8: two-step control, bipolar",
    "figure_3_9": "Figure 3-9: two-step control, monopolar",
    "ratio_factor_2": "No figure, but the manual's formula: three-step control, RATIOFAC 2",
}


def pulse(share, shortest, scale=1):
    """What becomes of a pulse of this share of the period."""
    if share > scale * (1 - shortest):
        return scale
    if share < scale * shortest:
        return 0
    return share


def mean(inv, settings):
    """The mean of the pulses over a period in percent, negative ones negative."""
    share = Fraction(inv) / 100
    shortest = (
        Fraction(settings["P_B_TM"]).limit_denominator() / Fraction(settings["PER_TM"]).limit_denominator()
    )
    if settings["STEP3_ON"]:
        ratio = Fraction(settings["RATIOFAC"])
        positive, negative = (1 / ratio, 1) if ratio > 1 else (1, ratio)
        if inv > 0:
            return 100 * pulse(share * positive, shortest, positive)
        return -100 * pulse(-share * negative, shortest, negative)
    if settings["ST2BI_ON"]:
        return 100 * pulse(max(0, (share + 1) / 2), shortest)
    return 100 * pulse(max(0, share), shortest)


def characteristic(settings):
    return [(inv, float(mean(inv, settings))) for inv in SWEEP]


def read(figure):
    return [(float(row["INV"]), float(row["mean"])) for row in rows(FOLDER / f"{figure}.csv")]


def write():
    FOLDER.mkdir(parents=True, exist_ok=True)
    for figure, settings in CHARACTERISTICS.items():
        given = ", ".join(f"{name} {value:g}" for name, value in settings.items() if name != "CYCLE")
        lines = [
            "# Computed from the formulas of the manual's section 3.3 by tests/figures.py, not measured.",
            f"# {SHOWS[figure]}; {given}. mean: pulses over a period in percent, negative ones negative.",
            "INV,mean",
            *(f"{inv:g},{value:g}" for inv, value in characteristic(settings)),
        ]
        (FOLDER / f"{figure}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write()
