"""The Bode plot of the open loop: amplitude, phase, margins and Ms are computed a second time, from the difference equations of block
and plant, over a dense grid of frequencies."""

import json
import math

import numpy as np
import pytest

import tool
from test_engine import in_the_page

pytestmark = tool.needs_page

CYCLE = 1.0
MODEL = {"gain": 2.0, "time_constant": 20.0, "second_time_constant": 0.0, "dead_time": 3.3, "is_integrating": False}
IN_FORCE = {"CYCLE": CYCLE, "GAIN": 1.2, "TI": 15.0, "D_SEL": False}
OTHERS = {
    "PID": {"GAIN": 1.8, "TI": 12.0, "TD": 2.0, "TM_LAG": 1.0, "D_SEL": True},
    "P": {"GAIN": 1.5, "I_SEL": False},
    "unstable": {"GAIN": 6.0},
    # The block computes with half of CYCLE, and the I action takes over.
    "TI is raised": {"GAIN": 0.02, "TI": 0.2},
}


def plant(back):
    """K (1 - exp(-(t - L)/T)) at the calls after a unit step, as a power series: the rest of a call after L, then a geometric one."""
    gain, lag, dead = (MODEL[name] for name in ("gain", "time_constant", "dead_time"))
    first = math.floor(dead / CYCLE) + 1
    left = math.exp(-(first * CYCLE - dead) / lag)
    a = math.exp(-CYCLE / lag)
    return gain * back**first * ((1 - left) + left * (1 - a) * back / (1 - a * back))


def block(values, back):
    """LMN = P + I + D of an error, with the sums of the block."""
    law = np.ones_like(back)
    if values.get("I_SEL", True):
        law = law + CYCLE / max(values["TI"], CYCLE / 2) * (1 + back) / 2 / (1 - back)
    if values["D_SEL"]:
        kick = values["TD"] / (values["TM_LAG"] + CYCLE / 2)
        law = law + kick * (1 - back) / (1 - (1 - CYCLE / values["TD"] * kick) * back)
    return values["GAIN"] * law


def open_loop(values, frequency):
    back = np.exp(-1j * frequency * CYCLE)
    return block(values, back) * plant(back)


def crossings(values):
    """Where a function changes its sign, by its places in the grid."""
    return np.nonzero(np.diff(np.sign(values)))[0]


@pytest.fixture(scope="module")
def answer():
    controller = {"name": "TIC101", "fmu": "CONT_C", "values": IN_FORCE}
    asked = {"do": "bode", "model": MODEL, "controller": controller, "others": list(OTHERS.values())}
    return json.loads(in_the_page(tool.PAGE, [asked])[0])["ok"]


LOOPS = {"in force": {}, **OTHERS}


@pytest.mark.parametrize("name", LOOPS)
def test_the_curves_and_margins_are_those_of_the_difference_equations(answer, name):
    values = {**IN_FORCE, **LOOPS[name]}
    told = answer["loops"][list(LOOPS).index(name)]
    frequency = np.array(answer["frequencies"])
    loop = open_loop(values, frequency)
    assert told["amplitude"] == pytest.approx(20 * np.log10(np.abs(loop)), abs=1e-6)
    assert np.exp(1j * np.radians(told["phase"])) == pytest.approx(loop / np.abs(loop), abs=1e-8)
    assert np.max(np.abs(np.diff(told["phase"]))) < 180

    dense = np.geomspace(1e-5, math.pi / CYCLE, 2_000_000)
    loop = open_loop(values, dense)
    phase = np.unwrap(np.angle(loop))
    at_gain = crossings(np.abs(loop) - 1)
    margins = np.degrees(phase[at_gain]) + 180
    at_phase = [at for at in crossings(loop.imag) if loop.real[at] < 0 and loop.imag[at] < 0]
    gains = 1 / np.abs(loop[at_phase])
    assert told["phase_margin"] == pytest.approx(margins.min(), abs=0.02)
    assert told["gain_crossover"] == pytest.approx(dense[at_gain[margins.argmin()]], rel=1e-3)
    assert told["gain_margin"] == pytest.approx(gains.min(), rel=1e-3)
    assert told["phase_crossover"] == pytest.approx(dense[at_phase[gains.argmin()]], rel=1e-3)
    if name == "unstable":
        assert told["sensitivity"] is None and told["gain_margin"] < 1 and told["phase_margin"] < 0
    else:
        assert told["sensitivity"] == pytest.approx(1 / np.abs(1 + loop).min(), rel=1e-3)


def test_a_block_without_its_p_action_is_refused_by_name():
    controller = {"name": "TIC101", "fmu": "CONT_C", "values": {**IN_FORCE, "P_SEL": False}}
    answer = in_the_page(tool.PAGE, [{"do": "bode", "model": MODEL, "controller": controller, "others": []}])[0]
    assert json.loads(answer)["error"]["message"] == (
        "P_SEL is FALSE, but the margins and the Bode plot of CONT_C need the P action: set P_SEL to TRUE"
    )
