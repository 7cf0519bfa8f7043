"""Descriptions of loops: what `plcfmu run` makes of them is what it makes of the same options, and an error has its place.
test_masters.py runs the descriptions of plants/loops in other masters."""

import json
import os
import pathlib
import subprocess

import pytest

import host
from files import rows

EXAMPLES = sorted((pathlib.Path(__file__).parents[1] / "plants" / "loops").glob("*.toml"))
# Of each example: the variable that ends at a value, and how near.
ENDS = {
    "chamber": ("THERMO.TEMP", 50.0, 0.5),
    "chamber_mean": ("THERMO.TEMP", 50.0, 0.5),
    "furnace": ("HEATER.TEMP", 60.0, 0.1),
    "furnace_pulses": ("HEATER.TEMP", 200.0, 1.0),
    "level": ("TANK.LEVEL", 1.0, 0.01),
    "level_pulses": ("TANK.LEVEL", 1.0, 0.01),
    "positioner": ("VALVE.TEMP", 60.0, 0.1),
    "process": ("PROCESS.PV", 20.0, 0.1),
    "process_integrating": ("PROCESS.PV", 20.0, 0.1),
    "process_pulses": ("PROCESS.PV", 20.0, 0.5),
    "sensor": ("PROCESS.PV", 20.0, 0.2),
    "speed": ("DRIVE.SPEED", 5000 * 1500 / 32767, 0.1),
    "valve": ("VALVE.TEMP", 50.0, 0.3),
    "valve_mean": ("VALVE.TEMP", 50.0, 0.3),
    "zone": ("THERMO.TEMP", 0.0, 0.1),
}

DESCRIPTION = """\
step = 1.0
stop = 40
record = ["CONT_C.LMN", "CONT_C.SP_INT", "HEATER.TEMP"]

[fmus]
CONT_C = "CONT_C.fmu"
HEATER = "HEATER.fmu"

[connections]
CONT_C.LMN = "HEATER.POWER"
HEATER.T_PER = ["CONT_C.PV_PER"]

[settings]
CONT_C.GAIN = 1.5
CONT_C.MAN_ON = false
CONT_C.SP_INT = 60.0
CONT_C.PVPER_ON = true
CONT_C.PV_FAC = 4.0
HEATER = { CYCLE = 1 }

[[events]]
time = 20.0
set = { CONT_C.SP_INT = 30, HEATER.DOOR = 50.0 }
"""
OPTIONS = [
    "--connect=CONT_C.LMN=HEATER.POWER", "--connect=HEATER.T_PER=CONT_C.PV_PER", "--set=CONT_C.MAN_ON=false",
    "--set=CONT_C.SP_INT=60", "--set=CONT_C.PVPER_ON=true", "--set=CONT_C.PV_FAC=4", "--set=CONT_C.GAIN=1.5",
    "--set=HEATER.CYCLE=1", "--set=CONT_C.SP_INT=30@20", "--set=HEATER.DOOR=50@20", "--step=1", "--stop=40",
    "--record=CONT_C.LMN", "--record=CONT_C.SP_INT", "--record=HEATER.TEMP",
]  # fmt: skip


@pytest.fixture
def call(command, tmp_path):
    """Calls `plcfmu` in an empty folder, with PLCFMU_FMUS for the folder of the FMUs."""

    def call(*arguments):
        run = [str(argument).replace("PLCFMU_FMUS", str(host.FOLDER)) for argument in arguments]
        return subprocess.run([command, *run], cwd=tmp_path, capture_output=True, text=True)

    return call


def recorded(done):
    assert done.returncode == 0, done.stderr
    return done.stdout


def refused(done, *codes):
    """The sentence that a command is refused with: a description cannot be read, or names what is not there."""
    assert done.returncode in (codes or (1, 3)) and done.stdout == "", done.stderr
    *_, sentence = done.stderr.splitlines()
    return sentence.removeprefix("error: ")


def test_a_description_runs_as_the_same_options_do(call, tmp_path):
    (tmp_path / "loop.toml").write_text(DESCRIPTION)
    described = recorded(call("run", "loop.toml", "--fmus=PLCFMU_FMUS", "--out=-"))
    assert described == recorded(call("run", "PLCFMU_FMUS/CONT_C.fmu", "PLCFMU_FMUS/HEATER.fmu", *OPTIONS, "--out=-"))
    # T_PER is 1382 at 20 degC, and LMN = 1.5 * (60 - 4 * 1382 / 276.48) and a little of the integrator.
    assert described.startswith("time,CONT_C.LMN,CONT_C.SP_INT,HEATER.TEMP\n0.0,61.5")


def test_options_come_on_top_of_a_description(call, tmp_path):
    (tmp_path / "loop.toml").write_text(DESCRIPTION)
    top = ["--set=CONT_C.SP_INT=80@20", "--set=CONT_C.GAIN=2", "--stop=30", "--record=CONT_C.SP_INT"]
    text = recorded(call("run", "loop.toml", "--fmus=PLCFMU_FMUS", "--out=-", *top, "--record=CONT_C.LMN_P"))
    table = rows(text)
    assert list(table[0]) == ["time", "CONT_C.SP_INT", "CONT_C.LMN_P"]
    assert [float(row["CONT_C.SP_INT"]) for row in table] == [60.0] * 20 + [80.0] * 11
    assert float(table[0]["CONT_C.LMN_P"]) == pytest.approx(2 * 40, abs=0.1)


def test_fmus_and_parameter_files_are_found_beside_the_description(call, tmp_path):
    folder = tmp_path / "my loops"
    folder.mkdir()
    for name in ("CONT_C", "HEATER"):
        (folder / f"{name}.fmu").write_bytes((host.FOLDER / f"{name}.fmu").read_bytes())
    (folder / "plant.json").write_text(json.dumps({"TIC101": {"GAIN": 0.1, "TI": 12.5, "TD": 1, "PV_PER": 7, "SP_INT": 33.0}}))
    (folder / "loop.toml").write_text(
        DESCRIPTION.replace("[settings]", '[parameters]\nCONT_C = { file = "plant.json", loop = "TIC101" }\n\n[settings]')
    )
    options = ["--record=CONT_C.GAIN", "--record=CONT_C.TI", "--record=CONT_C.SP_INT", "--record=CONT_C.PV_PER"]
    row, *_ = rows(recorded(call("run", "my loops/loop.toml", "--out=-", *options)))
    # The description's own settings and connections come before the values of the file.
    assert row == {
        "time": "0.0", "CONT_C.GAIN": "1.5", "CONT_C.TI": "12.5", "CONT_C.SP_INT": "60.0", "CONT_C.PV_PER": "1382",
    }  # fmt: skip
    wrong = DESCRIPTION.replace("[settings]", '[parameters]\nCONT_C.file = "plant.awk"\n\n[settings]')
    (folder / "wrong.toml").write_text(wrong)
    assert refused(call("run", "my loops/wrong.toml")).startswith(f"my loops{os.sep}wrong.toml:14:15: ")


def test_what_is_saved_runs_again_and_gives_the_same_file(call, tmp_path):
    first = call("run", "PLCFMU_FMUS/CONT_C.fmu", "PLCFMU_FMUS/HEATER.fmu", *OPTIONS, "--out=a.csv", "--save=saved.toml")
    assert "saved.toml\n" in recorded(first)
    assert recorded(call("run", "saved.toml", "--out=-")) == (tmp_path / "a.csv").read_text()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_loops_of_the_examples_end_at_their_setpoint(call, path):
    """From a start that is away from it, and after the disturbance that most of them have."""
    variable, setpoint, near = ENDS[path.stem]
    first, *_, last = rows(recorded(call("run", path, "--fmus=PLCFMU_FMUS", "--out=-")))
    assert abs(float(first[variable]) - setpoint) > 10 * near
    assert float(last[variable]) == pytest.approx(setpoint, abs=near)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_loops_of_the_examples_begin_with_a_title_of_their_own(path):
    """The parameter tool shows it."""
    titles = {example: example.read_text(encoding="utf-8").splitlines()[0] for example in EXAMPLES}
    title = titles[path]
    assert title.startswith("# ") and len(title) < 90 and not title.endswith(".")
    assert list(titles.values()).count(title) == 1


@pytest.mark.parametrize(
    "old, new, sentence",
    [
        ("stop", "stopp", "loop.toml:2:1: unknown field `stopp`, expected one of `start`, `stop`"),
        ("GAIN", "GAIM", "loop.toml:14:8: CONT_C has no variable GAIM; did you mean CONT_C.GAIN?"),
        ("= 1.5", '= "1.5"', 'loop.toml:14:15: expected a finite number, true or false; found the string "1.5"'),
        ("CONT_C.fmu", "CONTC.fmu", "did you mean CONT_C.fmu?"),
        ("CONT_C.LMN =", "CONT_C.QLMN_HLM =", "loop.toml:10:8: CONT_C.QLMN_HLM cannot be connected to HEATER.POWER"),
        ("time = 20.0", "time = 200.0", "loop.toml:23:16: CONT_C.SP_INT cannot be set at 200.0 s"),
        ('"HEATER.TEMP"]', '"HEATER.TEMPO"]', "loop.toml:3:42: HEATER has no variable TEMPO"),
        ("GAIN = 1.5", "GAIN = 1.5 # twice\nCONT_C.GAIN = 2", "loop.toml:15:8: duplicate key"),
    ],
)
def test_an_error_in_a_description_has_its_place(call, tmp_path, old, new, sentence):
    assert DESCRIPTION.count(old) >= 1
    (tmp_path / "loop.toml").write_text(DESCRIPTION.replace(old, new, 1))
    assert sentence in refused(call("run", "loop.toml", "--fmus=PLCFMU_FMUS"))


def test_the_loops_of_a_parameter_file_run_with_its_values(call, tmp_path):
    (tmp_path / "plant.json").write_text(json.dumps({"TIC1": {"GAIN": 0.1, "TD": 1.0}, "TIC2": {"GAIN": 0.7, "TD": 2.0}, "P1": {"PER_TM": 2}}))
    record = ["--record=TIC1.GAIN", "--record=TIC2.GAIN", "--record=P1.PER_TM"]
    text = recorded(call("run", "plant.json", "--fmus=PLCFMU_FMUS", "--stop=1", "--out=-", *record))
    assert text.splitlines()[:2] == ["time,TIC1.GAIN,TIC2.GAIN,P1.PER_TM", f"0.0,{host.real(0.1)},{host.real(0.7)},2.0"]
    assert refused(call("run", "plant.json"), 1) == (
        "plant.json is a parameter file: specify the folder with the FMUs of its blocks with --fmus FOLDER"
    )
