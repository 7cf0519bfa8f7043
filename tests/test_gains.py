"""`plcfmu gains`: what a user of Simulink, TwinCAT, CODESYS or a book types and gets; and the block responds as the formula
says. The conversions themselves are tested in `control/src/gains/tests.rs`."""

import cmath
import json
import math
import subprocess

import pytest


@pytest.fixture
def gains(command):
    def gains(*arguments):
        return subprocess.run([command, "gains", *arguments], capture_output=True, text=True)

    return gains


def test_gains_become_settings_of_the_block(gains):
    done = gains("--parallel", "Kp=2,Ki=0.1,Kd=4,N=10")
    assert done.stdout.split("\n") == [
        "GAIN    2",
        "TI      20 s",
        "TD      2 s",
        "TM_LAG  0.2 s",
        "P_SEL   TRUE",
        "I_SEL   TRUE",
        "D_SEL   TRUE",
        "",
    ]


def test_what_the_plc_makes_of_them_is_remarked(gains):
    done = gains("--ideal", "Kp=2,Ti=0.0404,Td=1", "--cycle", "0.1")
    assert done.stdout.splitlines()[7:] == [
        "remark: TI = 0.0404 s becomes 0.04 s: a TIME is a whole number of milliseconds",
        "remark: the D action has no filter: TM_LAG = 0 s is below CYCLE / 2, so the block uses CYCLE / 2",
        "remark: TI = 0.04 s is below CYCLE / 2: the block uses 0.05 s",
        "remark: TM_LAG = 0 s is below CYCLE / 2: the block uses 0.05 s",
    ]


def test_another_form_with_a_cycle_is_that_of_what_the_block_computes(gains):
    done = gains("--from", "GAIN=2,TI=0.04", "--to", "parallel", "--cycle", "0.1", "--json")
    assert json.loads(done.stdout) == {"Kp": 2.0, "Ki": 40.0, "Kd": 0.0}
    assert "TI = 0.04 s is below CYCLE / 2" in done.stderr


def test_the_settings_go_back_to_each_form(gains):
    settings = "GAIN=2,TI=20,TD=2,TM_LAG=0.2"
    for form in ("parallel", "ideal", "series", "simulink", "simulink-ideal", "twincat"):
        numbers = json.loads(gains("--from", settings, "--to", form, "--json").stdout)
        given = ",".join(f"{name}={value}" for name, value in numbers.items())
        again = json.loads(gains(f"--{form}", given, "--json").stdout)
        assert {name: again[name] for name in ("GAIN", "TI", "TD", "TM_LAG")} == {
            "GAIN": 2.0,
            "TI": 20.0,
            "TD": 2.0,
            "TM_LAG": 0.2,
        }, form


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["--from", "GAIN=2,TI=20,TD=6", "--to", "series"], 1, "no series form has this response: it would need TI >= 4 TD"),
        (["--simulink", "P=2,D=1"], 1, "N is missing: specify the filter coefficient in 1/s; Simulink's default is 100"),
        (["--ideal", "P=2"], 1, "the form ideal has no P: its parameters are Kp, Ti, Td, N, Tf"),
        (["--ideal", "Kp=2", "--cycle", "0"], 1, "--cycle 0: CYCLE must be greater than 0 s"),
        (["--ideal", "Kp"], 2, '"Kp" is not NAME=NUMBER, such as Kp=2'),
        (["--ideal", "Kp=x"], 2, '"x" is not a number, such as 2 or 1.5e-3'),
        (["--ideal", "Kp=1", "--series", "Kp=1"], 2, "cannot be used with"),
        ([], 2, "required arguments were not provided"),
    ],
)
def test_what_cannot_be_converted_is_refused_in_a_sentence(gains, arguments, status, sentence):
    done = gains(*arguments)
    assert (done.returncode, done.stdout) == (status, "")
    assert sentence in done.stderr


def test_the_block_with_these_settings_has_the_frequency_response_of_the_gains(gains, open_fmu):
    # Simulink's form with its N in 1/s, which a relative N would miss by a factor of 50.
    p, i, d, n = 2.0, 0.5, 1.0, 4.0
    settings = json.loads(gains("--simulink", f"P={p},I={i},D={d},N={n}", "--json").stdout)
    h, frequency, cycles = 0.01, 1.5, 40
    limits = {"LMN_HLM": 1e6, "LMN_LLM": -1e6}
    controller = open_fmu("CONT_C").start(**settings, **limits, CYCLE=h, MAN_ON=False)
    count = round(cycles * 2 * math.pi / frequency / h)
    half = count // 2
    samples = []
    for step in range(count):
        angle = frequency * step * h
        controller.step(SP_INT=math.sin(angle))
        samples.append((angle, controller["LMN"]))
    # Least squares of a constant, which the integral keeps from the start, a sine and a cosine, over whole periods.
    period = round(2 * math.pi / frequency / h)
    window = samples[half : half + period * ((count - half) // period)]
    mean = sum(value for _, value in window) / len(window)
    response = sum((value - mean) * cmath.exp(-1j * angle) for angle, value in window) * 2j / len(window)
    s = 1j * frequency
    expected = p + i / s + d * n / (1 + n / s)
    assert abs(response - expected) < 0.02 * abs(expected)
