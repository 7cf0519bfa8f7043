"""The figures of the shipped loops, computed a second time from their recordings: what `plcfmu run` prints and what the parameter
tool shows. The definitions are those of docs/studies.md, written in numpy."""

import json
import pathlib
import subprocess
import tomllib

import numpy as np
import pytest

import host
import second_plants
from tool import Server

LOOPS = pathlib.Path(__file__).parents[1] / "plants" / "loops"
BAND = 0.02
# Known to two or three digits.
PULSED = ("chamber", "furnace_pulses")
# Of each loop: what is recorded of its controller, when its step begins and ends, when it is disturbed, and what is known of it from other
# computations: rise, overshoot, settling and IAE of the step, its largest deviation.
CASES = {
    "furnace": ("PV", 1.0, 600.0, None, {"rise": 80.635, "overshoot": 0.96918, "settling": 130.0, "iae": 2506.88}),
    "chamber": ("DI_CONT_C.PV", None, 40.0, None, {"rise": 9.8, "settling": 20.8, "peak": 30.0}),
    "furnace_pulses": ("DI_CONT_C.PV", None, 700.0, 700.0, {"rise": 120.0, "overshoot": 0.0, "settling": 340.0, "peak": 180.0}),
    "level": ("PV", 0.0, 600.0, 600.0, {"settling": 139.0}),
    "zone": ("PV", 600.0, 1200.0, None, {}),
    "valve": ("PV", 0.1, 60.0, None, {"rise": 12.892, "overshoot": 2.7243, "settling": 33.3, "iae": 350.34, "pulses": 10}),
    "positioner": ("PV", 0.0, 150.0, 150.0, {}),
}


def second(rows, process_value, begin, end, disturbed):
    """The figures of a step in the rows of a recording, whose last row is no call."""
    time, sp, pv = rows["time"][:-1], rows["SP_INT"][:-1], rows[process_value][:-1]
    span = np.append(np.diff(time), time[-1] - time[-2])
    first = int(np.argmax(pv != 0.0)) if begin is None else int(np.argmax(time >= begin - 1e-9))
    step = slice(first, int(np.sum(time < end - 1e-9)))
    t, y, target = time[step] - time[first], pv[step], sp[step][-1]
    height = target - y[0]
    done, error = (y - y[0]) / height, np.abs(sp[step] - y)

    def crossing(level):
        at = int(np.argmax(done >= level))
        return t[at - 1] + (t[at] - t[at - 1]) * (level - done[at - 1]) / (done[at] - done[at - 1])

    outside = np.flatnonzero(np.abs(done - 1.0) > BAND)
    figures = {
        "rise": crossing(0.9) - crossing(0.1),
        "overshoot": max(0.0, float(np.max((y - target) / height))) * 100.0,
        "settling": t[outside[-1] + 1],
        "iae": float(np.sum(error * span[step])),
        "ise": float(np.sum(error**2 * span[step])),
        "peak": float(np.max(error)),
    }
    if disturbed is not None:
        after = time >= disturbed - 1e-9
        error = np.abs(sp - pv)[after]
        outside = np.flatnonzero(error > BAND * abs(height))
        figures |= {
            "recovery": time[after][outside[-1] + 1] - disturbed if outside.size else 0.0,
            "disturbed_peak": float(np.max(error)),
            "disturbed_iae": float(np.sum(error * span[after])),
        }
    return figures


@pytest.fixture(scope="module")
def tool(command, tmp_path_factory):
    with Server(command, tmp_path_factory.mktemp("tool"), "--fmus", host.FOLDER) as tool:
        yield tool


@pytest.mark.parametrize("name", CASES)
def test_figures_are_those_of_a_second_computation(name, command, tmp_path, tool):
    process_value, begin, end, disturbed, known = CASES[name]
    out = tmp_path / "out.csv"
    given = [command, "run", LOOPS / f"{name}.toml", "--fmus", host.FOLDER, "--json", "--out", out]
    if "." in process_value:
        inner = (process_value, "SP_INT", "QPOS_P", "DI_PULSEGEN.QNEG_P")
        given += [f"--record=PULS_CTR.{variable}" for variable in inner]
    told = json.loads(subprocess.run(given, capture_output=True, text=True, check=True, cwd=tmp_path).stdout)
    table = np.genfromtxt(out, delimiter=",", names=True, deletechars="")
    rows = {column.split(".", 1)[-1]: table[column] for column in table.dtype.names}
    of_run = {figure["key"]: figure["value"] for figure in told["figures"]}
    expected = second(rows, process_value, begin, end, disturbed)
    for key, value in expected.items():
        assert of_run[key] == pytest.approx(value, rel=1e-9, abs=1e-9), (name, key)
    for key, value in known.items():
        assert of_run[key] == pytest.approx(value, rel=1e-5 if name not in PULSED else 0.01, abs=1e-3), (name, key)

    ask = lambda **request: json.loads(tool.ask(request, name.replace("_", "-")))["ok"]
    loop = next(loop for loop in ask(do="catalogue")["loops"] if loop["name"] == name)
    state = ask(do="start", **loop["setup"])
    for time, variable, value in [*sorted(loop["events"]), (loop["stop"], None, None)]:
        if calls := round(time / state["step"]) - state["calls"]:
            state = ask(do="run", calls=calls)
        if variable is not None:
            ask(do="send", values={variable: value})
    of_tool = {figure["key"]: figure["value"] for figure in ask(do="figures")["figures"]}
    assert of_tool == of_run


@pytest.mark.parametrize("name", ["furnace", "level", "zone", "valve"])
def test_figures_are_those_of_an_independent_simulation_to_the_digits_that_are_shown(name, command, tmp_path):
    _, begin, end, disturbed, _ = CASES[name]
    tables = tomllib.loads((LOOPS / f"{name}.toml").read_text())
    controller = next(iter(tables["fmus"]))
    recorded = second_plants.simulated(tables, [f"{controller}.SP_INT", f"{controller}.PV"])
    # A recording has a row for the end.
    rows = {of.split(".")[1]: np.array([*map(float, values), np.nan]) for of, values in recorded.items()}
    rows["time"] = np.arange(len(rows["PV"])) * tables["step"]
    given = [command, "run", LOOPS / f"{name}.toml", "--fmus", host.FOLDER, "--json"]
    told = json.loads(subprocess.run(given, capture_output=True, text=True, check=True, cwd=tmp_path).stdout)
    of_run = {figure["key"]: figure["value"] for figure in told["figures"]}
    for key, value in second(rows, "PV", begin, end, disturbed).items():
        assert f"{of_run[key]:.3g}" == f"{value:.3g}", key


def test_what_people_read_names_the_event_and_has_units(command, tmp_path):
    given = [command, "run", LOOPS / "level.toml", "--fmus", host.FOLDER]
    lines = subprocess.run(given, capture_output=True, text=True, check=True, cwd=tmp_path).stdout.splitlines()
    heads = [line for line in lines[1:] if not line.startswith(" ")]
    assert heads == ["step at the start, from 0.5 to 1:", "disturbance at 600 s, TANK.DRAIN = 100:"]
    assert any(line.split()[:2] == ["IAE", lines[5].split()[1]] and line.endswith(" m·s") for line in lines)
