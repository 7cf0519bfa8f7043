"""A step test of a loop whose controller has pulses and measures once in a pulse period: the plant stays where it is, and the model is
that of the plant."""

import json

import pytest

import host
from tool import Server


@pytest.fixture(scope="module")
def tool(command, tmp_path_factory):
    with Server(command, tmp_path_factory.mktemp("tool"), "--fmus", host.FOLDER) as tool:
        yield tool


# The chamber has 60 K at 100 %, lags of 1 s and 10 s, and a pulse period of 0.2 s; the furnace 300 K, lags of 120 s and 20 s, a dead time of
# 5 s, and a period of 5 s. The model's lag and dead time have their sum, and half a period by which the pulses come late.
@pytest.mark.parametrize("name, seconds, gain, delays", [
    ("chamber", 0.01, 0.6, 11.1),
    ("chamber", 40.0, 0.6, 11.1),
    ("furnace_pulses", 0.1, 3.0, 147.5),
    ("furnace_pulses", 650.0, 3.0, 147.5),
])  # fmt: skip
def test_a_step_test_of_pulses_finds_the_plant_and_leaves_it_where_it_is(tool, name, seconds, gain, delays):
    ask = lambda **request: json.loads(tool.ask(request, name.replace("_", "-")))["ok"]
    loop = next(loop for loop in ask(do="catalogue")["loops"] if loop["name"] == name)
    step = ask(do="start", **loop["setup"])["step"]
    ask(do="run", calls=round(seconds / step))
    tested = ask(do="step_test", size=10.0, method="least_squares", is_integrating=False)
    model = tested["identified"]["model"]
    assert model["gain"] == pytest.approx(gain, rel=0.01)
    assert model["time_constant"] + model["second_time_constant"] + model["dead_time"] == pytest.approx(delays, rel=0.03)
    # Each pulse moves the output by 100 %: nobody asks how far.
    figures = {figure["key"] for figure in ask(do="figures")["figures"]}
    assert "iae" in figures and "travel" not in figures
    if seconds > 1.0:
        value = "PULS_CTR.DI_CONT_C.PV"
        seen = ask(do="view", variables=[value], points=2000, **{"from": tested["from"], "to": tested["step"]})
        (values,) = seen["values"]
        assert max(values) - min(values) < 0.1 * gain * 100
