"""The relay test of the parameter tool behind a sensor with noise: ultimate gain and period of 100 plants."""

import cmath
import json
import math
import random

import host
import pytest
import tool

CYCLE = 0.1


def exact(gain, lags, dead_calls, integrates):
    """Gain and period of P control at the stability limit: a scan of the sampled plant's frequency response.

    The step response between two calls is that of its partial fractions, behind a hold and a dead time of whole calls.
    """
    first, second = lags
    if integrates:
        constant, ramp, parts = -first, 1.0, [(first, first)]
    elif second > 0:
        parts = [(-first / (first - second), first), (second / (first - second), second)]
        constant, ramp = 1.0, 0.0
    else:
        constant, ramp, parts = 1.0, 0.0, [(-1.0, first)]

    def response(angle):
        back = cmath.exp(-1j * angle)
        sum_ = constant + ramp * CYCLE * back / (1 - back)
        sum_ += sum(part * (1 - back) / (1 - math.exp(-CYCLE / lag) * back) for part, lag in parts)
        return gain * sum_

    angle, turned, before = 1e-4, None, None
    while True:
        now = response(angle)
        phase = cmath.phase(now)
        turned = phase if before is None else turned + (phase - before + math.pi) % math.tau - math.pi
        before = phase
        if turned - angle * dead_calls <= -math.pi:
            return 1 / abs(now), math.tau / angle * CYCLE
        angle *= 1.0005


def plants():
    """Parameters of PROCESS, and a noise of a hundredth to a twentieth of what the relay moves in the end."""
    of = random.Random(7)
    for number in range(100):
        between = lambda low, high: low * (high / low) ** of.random()  # noqa: E731
        integrates = number % 4 == 3
        lag = between(1.0, 20.0)
        second = lag * between(0.1, 0.9) if number % 4 == 2 else 0.0
        dead = round(min(max(between(0.05, 1.5) * lag / CYCLE, 4), 60))
        gain = between(0.02, 0.1) if integrates else between(0.5, 1.5)
        noise = between(0.02, 0.1)
        yield gain, (lag, second), dead, integrates, noise, number


def relayed(server, gain, lags, dead, integrates, noise, seed):
    def ask(**request):
        answer = json.loads(server.ask(request, "relay"))
        assert "ok" in answer, (answer, gain, lags, dead, integrates, noise)
        return answer["ok"]

    values = {"GAIN": gain, "T1": lags[0], "T2": lags[1], "DEAD_TM": dead * CYCLE, "DEAD_MAX": 20.0, "U_0": 40.0, "PV_0": 50.0}
    members = [
        {"name": "C", "fmu": "CONT_C", "values": {"CYCLE": CYCLE, "MAN": 40.0}},
        {"name": "P", "fmu": "PROCESS", "values": {**values, "CYCLE": CYCLE, "INTEG": integrates}},
        {"name": "S", "fmu": "SENSOR", "values": {"CYCLE": CYCLE, "NOISE": noise, "SEED": seed + 1, "Y_START": 50.0}},
    ]
    connections = [["C.LMN", "P.U"], ["P.PV", "S.U"], ["S.Y", "C.PV_IN"]]
    ask(do="start", members=members, connections=connections, step=CYCLE)
    return ask(do="relay_test", amplitude=10.0)


def test_ultimate_gain_and_period_of_100_plants_are_found_within_10_percent_behind_noise(command, tmp_path):
    with tool.Server(command, tmp_path, "--fmus", host.FOLDER) as server:
        for of in plants():
            found = relayed(server, *of)
            gain, period = exact(*of[:4])
            assert found["ultimate"] == pytest.approx([gain, period], rel=0.1), of
            # Four times the noise, as far as some dozen values show it.
            assert 1 < found["hysteresis"] / of[4] < 8, (of, found["hysteresis"])
