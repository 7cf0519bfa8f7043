"""`plcfmu tune-study` as a user sees it: settings that are better than the loop's own ones and keep the constraints for every
plant, a front of two figures, and the same bytes with any number of jobs."""

import cmath
import math
import pathlib
import re
import subprocess

import pytest

import host
from files import rows

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"


@pytest.fixture(scope="module")
def run(command):
    """Runs a command of `plcfmu`."""

    def run(*arguments):
        given = [command, *map(str, arguments)]
        return subprocess.run(given, capture_output=True, text=True)

    return run


def written(folder, **changes):
    """The example's study in a folder, with four of the plants, fewer candidates, and what is changed."""
    text = (EXAMPLES / "studies/furnace_tuning.toml").read_text()
    changes = {
        'loop = "../..': f'loop = "{EXAMPLES.parent.as_posix()}',
        "values = [0.8, 1.0, 1.2]": "values = [0.8, 1.2]",
        "values = [3.0, 5.0, 8.0]": "values = [3.0, 8.0]",
        "evaluations = 400": "evaluations = 100",
        **changes,
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / "study.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def tuned(run, tmp_path_factory):
    """The study, the folder of its result with one job and with two, and what the commands printed."""
    folder = tmp_path_factory.mktemp("tuned")
    study = written(folder)
    folders = [folder / "one", folder / "two"]
    outputs = []
    for jobs, out in enumerate(folders, 1):
        done = run("tune-study", study, "--fmus", host.FOLDER, "--jobs", jobs, "--out", out)
        assert done.returncode == 0, done.stderr
        outputs.append(done.stdout)
    return study, folders, outputs


def test_the_result_has_the_same_bytes_with_any_number_of_jobs(tuned, expect):
    _, (one, two), outputs = tuned
    names = sorted(path.name for path in one.iterdir())
    assert names == ["front.csv", "front.png", "front.svg", "settings.csv", "tuned.json", "tuned.toml"]
    assert [path.name for path in sorted(two.iterdir())] == names
    for name in names:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name
    expect("study/tuned.txt", outputs[0].replace(str(one), "out"))
    expect("study/tuned.txt", outputs[1].replace(str(two), "out"))


def figures(run, path, settings, plant):
    """IAE, overshoot in percent and travel of the setpoint step with these settings and this plant, from the loop's recording."""
    record = ["CONT_C.SP_INT", "HEATER.TEMP", "HEATER.POWER"]
    given = [f"--set=CONT_C.{name}={value!r}" for name, value in settings.items()]
    given += [f"--set=HEATER.{name}={value!r}" for name, value in plant.items()]
    done = run("run", path.parent / "one/tuned.toml", *given, *(f"--record={name}" for name in record), "--out", path)
    assert done.returncode == 0, done.stderr
    # The door is opened at 300 s.
    calls = [row for row in rows(path) if float(row["time"]) < 300.0]
    setpoint, value, manipulated = ([float(row[name]) for row in calls] for name in record)
    step = setpoint.index(60.0)
    start = value[step]
    iae = sum(abs(w - x) for w, x in zip(setpoint[step:], value[step:]))
    overshoot = 100 * (max(value[step:]) - 60.0) / (60.0 - start)
    travel = sum(abs(b - a) for a, b in zip(manipulated[step - 1 :], manipulated[step:]))
    return iae, overshoot, travel


def test_the_settings_found_are_better_than_those_of_the_loop_and_keep_the_constraints_for_all_plants(tuned, run):
    study, (folder, _), outputs = tuned
    settings = {row["setting"].removeprefix("CONT_C."): row for row in rows(folder / "settings.csv")}
    assert {name: float(row["now"]) for name, row in settings.items()} == {"GAIN": 0.5, "TI": 100.0, "TD": 1.0}
    plants = [{"RISE": rise, "DELAY_TM": delay} for rise in (240.0, 360.0) for delay in (3.0, 8.0)]
    highest = {}
    for column in ("found", "now"):
        values = {name: float(row[column]) for name, row in settings.items()}
        of_plants = [figures(run, study.parent / "run.csv", values, plant) for plant in plants]
        highest[column] = [max(of_plant) for of_plant in zip(*of_plants)]
    iae, overshoot, travel = highest["found"]
    assert iae < 0.85 * highest["now"][0]
    assert overshoot < 10 and travel < 250
    front = rows(folder / "front.csv")[0]
    told = [float(front[f"{name}.highest"]) for name in ("iae", "overshoot", "travel")]
    assert told == pytest.approx(highest["found"], rel=1e-9)
    assert re.search(r"^iae +{:.6g} ".format(iae), outputs[0], re.M), outputs[0]
    sensitivity = re.search(r"^ms < 1.8 +([\d.]+) ", outputs[0], re.M)
    assert sensitivity and float(sensitivity[1]) < 1.8, outputs[0]


def test_no_settings_of_the_front_are_better_in_both_figures_than_others(tuned):
    _, (folder, _), _ = tuned
    front = [(float(row["iae.highest"]), float(row["travel.highest"])) for row in rows(folder / "front.csv")]
    assert len(front) >= 10
    assert all(low[0] < high[0] and low[1] > high[1] for low, high in zip(front, front[1:])), front
    assert all(float(row["ms.highest"]) < 1.8 for row in rows(folder / "front.csv"))


def test_the_tuned_loop_runs_and_its_parameters_are_a_parameter_file(tuned, run, tmp_path):
    _, (folder, _), _ = tuned
    found = {row["setting"].removeprefix("CONT_C."): float(row["found"]) for row in rows(folder / "settings.csv")}
    record = ["--record=CONT_C.GAIN", "--record=CONT_C.TI"]
    done = run("run", folder / "tuned.toml", *record, "--out", tmp_path / "run.csv")
    assert done.returncode == 0, done.stderr
    last = rows(tmp_path / "run.csv")[-1]
    assert float(last["CONT_C.GAIN"]) == pytest.approx(found["GAIN"], rel=1e-6)
    assert float(last["CONT_C.TI"]) == found["TI"]
    shown = run("params", folder / "tuned.json", "--json")
    assert shown.returncode == 0, shown.stderr
    for name, value in found.items():
        assert f'"{name}": {value!r}' in shown.stdout, shown.stdout


def test_without_settings_that_keep_the_constraints_the_exit_code_is_1_and_nothing_is_written(run, tmp_path):
    study = written(tmp_path, **{"overshoot < 10 %": "settling < 1 s", "evaluations = 400": "evaluations = 20"})
    out = tmp_path / "out"
    done = run("tune-study", study, "--fmus", host.FOLDER, "--out", out)
    assert done.returncode == 1
    assert "no candidate meets all constraints" in done.stderr and "settling < 1 s" in done.stderr
    assert "closest" in done.stdout and not out.exists()


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("[tune]", "[[values]]\nvariable = 'HEATER.TEMP'\ntake = ['max']\n[nothing]", "unknown field `nothing`"),
        ('minimize = "iae"', 'minimize = "isa"', "no figure isa"),
        ('variable = "CONT_C.TI"', 'variable = "CONT_C.TII"', "CONT_C has no variable TII; did you mean TI?"),
        ('variable = "CONT_C.TI"', 'variable = "CONT_C.P_SEL"', "it is neither a Real nor an Integer"),
        ('variable = "CONT_C.TI"', 'variable = "HEATER.RISE"', "is both searched and varied by an axis"),
    ],
)
def test_a_study_that_cannot_be_searched_is_refused_with_what_is_wrong(run, tmp_path, old, new, message):
    done = run("tune-study", written(tmp_path, **{old: new}), "--fmus", host.FOLDER)
    assert done.returncode == 1
    assert message in done.stderr


def exact_sensitivity(gain, ti, td, tm_lag, rise, delay, lags=(120.0, 20.0), cycle=1.0):
    """Ms of CONT_C with HEATER from their formulas: the answer of two lags behind a dead time to a held step, call by call, and
    the controller with s replaced by 2/CYCLE (z - 1)/(z + 1). The exchange costs a call."""

    def answer(call):
        time = (call - 1) * cycle - delay
        one, two = lags
        moved = 1 - (one * math.exp(-time / one) - two * math.exp(-time / two)) / (one - two)
        return rise / 100 * moved if time > 0 else 0.0

    answers = [answer(call) for call in range(2000)]
    steps = [after - before for before, after in zip(answers, answers[1:])]
    ms = 0.0
    for point in range(400):
        back = cmath.exp(-1j * math.pi * 1e-3 ** (1 - (point + 0.5) / 400))
        s = 2 / cycle * (1 - back) / (1 + back)
        plant = 0.0
        for step in reversed(steps):
            plant = plant * back + step
        controller = gain * (1 + 1 / (s * ti) + s * td / (1 + s * tm_lag))
        ms = max(ms, 1 / abs(1 + controller * plant * back))
    return ms


@pytest.fixture(scope="module")
def example(run, tmp_path_factory):
    """What the command prints of the guide's example, and the folder of its results."""
    folder = tmp_path_factory.mktemp("example")
    done = run("tune-study", EXAMPLES / "studies/furnace_tuning.toml", "--fmus", host.FOLDER, "--out", folder)
    assert done.returncode == 0, done.stderr
    return done.stdout, folder


def test_the_picture_in_the_guide_is_that_of_its_example(example):
    drawn = (example[1] / "front.png").read_bytes()
    assert drawn == (EXAMPLES.parent / "docs/tune_study.png").read_bytes(), "renew docs/tune_study.png"


def test_ms_of_the_example_is_that_of_the_exact_loop(example):
    printed, folder = example
    found, now = ({row["setting"]: float(row[which]) for row in rows(folder / "settings.csv")} for which in ("found", "now"))
    told = re.search(r"^ms +(\S+) +\S+ +(\S+)", printed, re.M)
    for settings, ms in zip((found, now), told.groups()):
        of_worst = exact_sensitivity(*settings.values(), tm_lag=1.0, rise=360.0, delay=8.0)
        assert float(ms) == pytest.approx(of_worst, rel=0.01)


CHAMBER = """
exchange = "parallel"
step = 0.05
stop = 120.0
[fmus]
CONT_C = "CONT_C.fmu"
PULSEGEN = "PULSEGEN.fmu"
THERMO = "THERMO.fmu"
[connections]
CONT_C.LMN = "PULSEGEN.INV"
PULSEGEN.QPOS_P = "THERMO.HEAT"
PULSEGEN.QNEG_P = "THERMO.COOL"
THERMO.TEMP = "CONT_C.PV_IN"
[settings]
CONT_C = { MAN_ON = false, SP_INT = 20.0, LMN_LLM = -100.0, GAIN = 2.0, TI = 60.0, CYCLE = 1.0 }
PULSEGEN = { CYCLE = 0.05, PER_TM = 4.0, P_B_TM = 0.05 }
THERMO = { CYCLE = 0.05, ZONE_TM = 30.0 }
[[events]]
time = 1.0
set = { CONT_C.SP_INT = 30.0 }
[[events]]
time = 60.0
set = { CONT_C.SP_INT = 10.0 }
"""
PULSES = """
loop = "chamber.toml"
[signals]
pulses = ["PULSEGEN.QPOS_P", "PULSEGEN.QNEG_P"]
[window]
from = 1.0
to = 120.0
[tune]
minimize = "iae"
constraints = ["pulses < 60", "ms < 3"]
evaluations = 40
model = { gain = 0.6, time_constant = 30.0, dead_time = 5.0 }
search = [
    { variable = "CONT_C.GAIN", min = 1.0, max = 20.0 },
    { variable = "CONT_C.TI", min = 10.0, max = 100.0 },
    { variable = "PULSEGEN.RATIOFAC", min = 0.2, max = 5.0 },
    { variable = "PULSEGEN.P_B_TM", min = 0.05, max = 1.0 },
]
"""


def test_heating_and_cooling_pulses_are_searched_for_with_a_bound_on_their_number(run, tmp_path):
    (tmp_path / "chamber.toml").write_text(CHAMBER)
    (tmp_path / "pulses.toml").write_text(PULSES)
    done = run("tune-study", tmp_path / "pulses.toml", "--fmus", host.FOLDER, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "Ms does not depend on PULSEGEN.RATIOFAC and PULSEGEN.P_B_TM here" in done.stderr
    iae, pulses = (re.search(rf"^{name} +(\S+) +\S+ +(\S+)", done.stdout, re.M) for name in ("iae", "pulses"))
    assert float(pulses[1]) < 60 <= float(pulses[2]), done.stdout
    assert float(iae[1]) < float(iae[2]), done.stdout
    # Without a pulse generator, half of its period is more dead time of the plant.
    sensitivity = re.search(r"^ms +\S+ +\S+ +(\S+)", done.stdout, re.M)
    mean = CHAMBER.replace('PULSEGEN = "PULSEGEN.fmu"\n', "").replace('"PULSEGEN.INV"', '"THERMO.DRIVE"')
    (tmp_path / "chamber.toml").write_text("\n".join(line for line in mean.splitlines() if "PULSEGEN" not in line))
    without = "\n".join(line for line in PULSES.splitlines() if "PULSEGEN" not in line)
    without = without.replace('"pulses < 60", ', "").replace("dead_time = 5.0", "dead_time = 7.0")
    (tmp_path / "mean.toml").write_text(without.replace("evaluations = 40", "evaluations = 10"))
    done = run("tune-study", tmp_path / "mean.toml", "--fmus", host.FOLDER, "--out", tmp_path / "mean")
    assert done.returncode == 0, done.stderr
    assert re.search(r"^ms +\S+ +\S+ +(\S+)", done.stdout, re.M)[1] == sensitivity[1]


def test_each_loop_of_a_plc_source_is_tuned_with_its_own_plant_and_written_back(run, tmp_path):
    source = EXAMPLES / "studies/ovens.awl"
    done = run("tune-study", EXAMPLES / "studies/ovens.toml", "--fmus", host.FOLDER, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("4 of 4 loops tuned\n")
    loops = rows(tmp_path / "settings.csv")
    assert [one["loop"] for one in loops] == ["TIC201", "TIC202", "TIC203", "TIC204"]
    # All began with the settings of the source, and the ovens ask for different ones.
    assert {(one["CONT_C.GAIN.now"], one["CONT_C.TI.now"]) for one in loops} == {("1.399999976158142", "80.0")}
    assert len({one["CONT_C.GAIN"] for one in loops}) == 4
    before, after = source.read_text().splitlines(), (tmp_path / "ovens.awl").read_text().splitlines()
    changed = [new for old, new in zip(before, after) if old != new]
    assert len(before) == len(after) and len(changed) == 8
    assert all(re.match(r" +(GAIN|TI) := ", line) for line in changed)
    assert changed[0].endswith("// all four as the first one was commissioned")
    # What is written is what was found, to the digits of a REAL.
    gains = [float(line.split(":=")[1].split(";")[0]) for line in after if "GAIN" in line]
    assert gains == pytest.approx([float(one["CONT_C.GAIN"]) for one in loops], rel=1e-6)
    # The study of the table has a row for each loop, with its name, and what the present settings come to there.
    done = run("study", EXAMPLES / "studies/ovens.toml", "--fmus", host.FOLDER, "--out", tmp_path, "--format", "csv")
    assert done.returncode == 0, done.stderr
    assert [(one["loop"], one["iae"]) for one in rows(tmp_path / "runs.csv")] == [
        (one["loop"], one["iae.now"]) for one in loops
    ]
