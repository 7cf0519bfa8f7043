"""`plcfmu run`: what it writes is, bit for bit, what the same FMUs give when FMPy steps them; it wires FMUs as it says,
refuses in one sentence what cannot be wired, and runs FMUs that others have made."""

import os
import re
import subprocess
import zipfile

import pytest

import host
from files import rows

LOOP = {"CONT_C.LMN": "HEATER.POWER", "HEATER.T_PER": "CONT_C.PV_PER"}
CONTROLLER = {"PVPER_ON": True, "PV_FAC": 4.0, "GAIN": 1.6, "TI": 135.0, "MAN": 50.0, "CYCLE": 1.0}


@pytest.fixture
def run(command, tmp_path):
    """Runs `plcfmu run` in an empty folder. An FMU of ours is named without its folder and `.fmu`."""

    def run(*fmus, connect=None, set=None, **options):
        (tmp_path / "tmp").mkdir(exist_ok=True)
        arguments = [command, "run", *(packed(fmu) for fmu in fmus)]
        arguments += [f"--connect={source}={target}" for source, target in (connect or {}).items()]
        arguments += [f"--set={variable}={value}" for variable, value in (set or {}).items()]
        for name, value in options.items():
            for each in value if isinstance(value, list) else [value]:
                arguments.append(f"--{name}" if each is True else f"--{name}={each}")
        environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
        done = subprocess.run(arguments, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert list((tmp_path / "tmp").iterdir()) == [], "temporary files are left"
        return done

    return run


def packed(fmu):
    name, separator, file = fmu.rpartition("=")
    if file.endswith(".fmu"):
        return fmu
    path = host.FOLDER / f"{file}.fmu"
    assert path.is_file(), host.REMEDY % path.name
    return f"{name}{separator}{path}"


def recorded(run, *fmus, **options):
    """The rows of a run that succeeds."""
    done = run(*fmus, out="-", **options)
    assert done.returncode == 0, done.stderr
    return rows(done.stdout)


def refusal(run, *fmus, **options):
    """The one sentence that a run is refused with."""
    done = run(*fmus, **options)
    assert done.returncode == 1, done.stderr
    assert done.stdout == ""
    *_, sentence = done.stderr.splitlines()
    assert sentence.startswith("error: ")
    return sentence.removeprefix("error: ")


def written(value):
    """A value as the CSV has it, to be compared bit for bit."""
    return float(value).hex() if isinstance(value, float) else str(int(value))


def same(row, expected):
    """Asserts that a row has these values bit for bit."""
    got = {name: float(row[name]).hex() if "." in row[name] or "e" in row[name] else row[name] for name in expected}
    assert got == {name: written(value) for name, value in expected.items()}


def test_the_loop_of_controller_and_plant_is_that_of_fmpy_bit_for_bit(run, open_fmu):
    # As examples/cont_c_heater.py: to automatic at 30 s, a setpoint step at 60 s, the door at 150 s.
    table = recorded(
        run,
        "CONT_C",
        "HEATER",
        connect=LOOP,
        set={
            **{f"CONT_C.{name}": value for name, value in CONTROLLER.items()},
            "HEATER.T_START": 170,
            "CONT_C.SP_INT": 170,
            "CONT_C.MAN_ON": "false@30",
            "HEATER.DOOR": "50@150",
        },
        step=1,
        stop=300,
        record=["CONT_C.PV_PER", "CONT_C.LMN", "CONT_C.QLMN_HLM", "HEATER.POWER", "HEATER.TEMP", "HEATER.DOOR"],
    )
    controller = open_fmu("CONT_C").start(**CONTROLLER, SP_INT=170.0)
    furnace = open_fmu("HEATER").start(T_START=170.0)
    assert [float(row["time"]) for row in table] == [float(number) for number in range(301)]
    for row in table[:-1]:
        time = float(row["time"])
        seen = furnace["T_PER"]
        controller.step(1.0, PV_PER=seen, MAN_ON=time < 30)
        # A row holds what the controller saw and gave in its call, and the plant before its step.
        expected = {"CONT_C.PV_PER": seen, "CONT_C.LMN": controller["LMN"], "HEATER.TEMP": furnace["TEMP"]}
        expected["CONT_C.QLMN_HLM"] = controller["QLMN_HLM"]
        furnace.step(1.0, POWER=controller["LMN"], DOOR=50.0 if time >= 150 else 0.0)
        expected["HEATER.POWER"] = furnace["POWER"]
        expected["HEATER.DOOR"] = furnace["DOOR"]
        same(row, expected)
    # At the end there is no call: the controller would see what the plant gives now.
    expected = {"CONT_C.PV_PER": furnace["T_PER"], "HEATER.TEMP": furnace["TEMP"], "CONT_C.LMN": controller["LMN"]}
    same(table[-1], expected)


def test_pulses_are_those_of_fmpy_bit_for_bit(run, open_fmu):
    """Booleans go from one FMU to the other; the controller is called in one step of 100."""
    connections = {
        "CONT_C.LMN": "PULSEGEN.INV",
        "PULSEGEN.QPOS_P": "THERMO.HEAT",
        "THERMO.T_PER": "CONT_C.PV_PER",
    }
    settings = {"MAN_ON": False, "PVPER_ON": True, "PV_FAC": 2.0, "PV_OFF": -100.0, "SP_INT": 30.0, "GAIN": 2.0}
    table = recorded(
        run,
        "CONT_C",
        "PULSEGEN",
        "THERMO",
        connect=connections,
        set={
            **{f"CONT_C.{name}": value for name, value in settings.items()},
            "PULSEGEN.PER_TM": 1,
            "PULSEGEN.STEP3_ON": "FALSE",
            "THERMO.CYCLE": 0.01,
        },
        step=0.01,
        stop=12,
    )
    controller = open_fmu("CONT_C").start(**settings)
    pulses = open_fmu("PULSEGEN").start(PER_TM=1.0, STEP3_ON=False)
    chamber = open_fmu("THERMO").start(CYCLE=0.01)
    assert len(table) == 1201
    for number, row in enumerate(table[:-1]):
        for instance in (controller, pulses, chamber):
            instance.time = number * 0.01
        controller.step(0.01, PV_PER=chamber["T_PER"])
        pulses.step(0.01, INV=controller["LMN"])
        expected = {
            "CONT_C.LMN": controller["LMN"],
            "PULSEGEN.QPOS_P": pulses["QPOS_P"],
            "THERMO.HEAT": pulses["QPOS_P"],
            "THERMO.TEMP": chamber["TEMP"],
        }
        chamber.step(0.01, HEAT=pulses["QPOS_P"])
        same(row, expected)
    assert {row["PULSEGEN.QPOS_P"] for row in table} == {"0", "1"}


def test_in_parallel_every_connection_delays_by_one_step(run, open_fmu):
    settings = {**CONTROLLER, "MAN_ON": False, "SP_INT": 100.0}
    table = recorded(
        run,
        "CONT_C",
        "HEATER",
        connect=LOOP,
        set={f"CONT_C.{name}": value for name, value in settings.items()},
        step=1,
        stop=50,
        parallel=True,
    )
    controller, furnace = open_fmu("CONT_C").start(**settings), open_fmu("HEATER").start()
    for row in table:
        seen, power = furnace["T_PER"], controller["LMN"]
        same(row, {"CONT_C.PV_PER": seen, "CONT_C.LMN": power, "HEATER.POWER": power, "HEATER.T_PER": seen})
        controller.step(1.0, PV_PER=seen)
        furnace.step(1.0, POWER=power)


def test_every_fmu_runs_alone_with_what_it_proposes(run, fmu):
    experiment = fmu.description.defaultExperiment
    table = recorded(run, str(fmu.path))
    assert len(table) == round(float(experiment.stopTime) / float(experiment.stepSize)) + 1
    assert list(table[0]) == ["time"] + [f"{fmu.name}.{name}" for name in fmu.of("output")]
    instance = fmu.start()
    for row in table[:20]:
        same(row, {f"{fmu.name}.{name}": value for name, value in instance.get(fmu.of("output")).items()})
        instance.time = float(row["time"])
        instance.step(float(experiment.stepSize))


def test_the_same_file_runs_twice_under_two_names(run):
    table = recorded(
        run,
        "cold=HEATER",
        "warm=HEATER",
        set={"cold.T_START": 10, "warm.T_START": 90},
        stop=1,
        record=["warm.TEMP", "cold.TEMP"],
    )
    assert list(table[0]) == ["time", "warm.TEMP", "cold.TEMP"]
    assert float(table[0]["warm.TEMP"]) > 80 > 20 > float(table[0]["cold.TEMP"])


def test_two_fmus_of_one_name_are_refused(run):
    assert refusal(run, "HEATER", "HEATER").startswith("two FMUs are named HEATER: rename one with NAME=")


def test_an_fmu_that_can_run_only_once_in_a_process_is_refused_twice(run, tmp_path):
    path = tmp_path / "once.fmu"
    flag = 'canBeInstantiatedOnlyOncePerProcess="false"'
    with zipfile.ZipFile(host.FOLDER / "HEATER.fmu") as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                text = content.decode().replace(flag, "")
                content = text.replace("<CoSimulation ", f'<CoSimulation {flag.replace("false", "true")} ', 1).encode()
            new.writestr(name, content)
    assert run(str(path), stop=1).returncode == 0
    assert "can be instantiated only once per process" in refusal(run, f"a={path}", f"b={path}")


@pytest.mark.parametrize(
    "options, sentence",
    [
        ({"connect": {"CONT_C.LMM": "HEATER.POWER"}}, "CONT_C has no variable LMM; did you mean CONT_C.LMN?"),
        ({"connect": {"CONT_C.QLMN_HLM": "HEATER.POWER"}}, "such as a mean over the step (available: LMN, "),
        ({"connect": {"HEATER.TEMP": "HEATER.POWER"}}, "it is in degC, but the input is in %: values are not converted"),
        ({"connect": {"HEATER.TEMP": "CONT_C.GAIN"}}, "the causality of CONT_C.GAIN is parameter"),
        ({"set": {"GAIN": 2}}, "GAIN does not name its FMU: write CONT_C.GAIN"),
        ({"set": {"CONT_C.CYCLE": "2@5"}}, "CONT_C.CYCLE cannot be set at 5.0 s: it is a fixed parameter"),
        ({"record": "HEATER.X"}, "HEATER has no variable X"),
        ({"step": 0}, "the communication step is 0.0 s: it must be positive and finite"),
        ({"plot": "result.gif"}, "result.gif: the file name of a plot must end in .png or .svg"),
        ({"out": "no/such/folder/result.csv"}, "no/such/folder is not a folder"),
    ],
)
def test_what_cannot_be_run_is_refused_with_the_remedy(run, options, sentence):
    assert sentence in refusal(run, "CONT_C", "HEATER", **options)


def test_an_error_of_an_fmu_names_it_with_the_time_and_its_own_message(run, tmp_path):
    (tmp_path / "result.csv").write_text("old")
    sentence = refusal(run, "CONT_C", set={"CONT_C.GAIN": "1e300@7"}, step=1, out="result.csv")
    assert sentence.startswith("CONT_C at 7.0 s: fmi2SetReal returned fmi2Error: GAIN = 1e300"), sentence
    assert (tmp_path / "result.csv").read_text() == "old"


def test_a_value_outside_its_range_is_set_with_a_warning(run):
    done = run("HEATER", set={"HEATER.POWER": 200}, stop=1)
    assert done.returncode == 0
    assert "warning: HEATER.POWER = 200.0 is outside the range declared by the FMU, 0.0 to 100.0" in done.stderr


def test_the_recording_goes_to_a_file_and_the_summary_to_standard_output(run, tmp_path):
    automatic = {"CONT_C.MAN_ON": "false"}
    done = run("CONT_C", "HEATER", connect=LOOP, set=automatic, stop=2, out="result.csv", plot=["result.png"])
    assert done.returncode == 0 and done.stderr == ""
    first, second, third, *_ = done.stdout.splitlines()
    assert first.startswith("20 steps of 0.1 s, as HEATER proposes, from 0 s to 2 s, in ")
    assert second == "result.csv: 21 rows with the time and 15 variables"
    assert third == "result.png"
    assert len(rows(tmp_path / "result.csv")) == 21
    assert (tmp_path / "result.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["result.csv", "result.png", "tmp"]


def test_the_advice_of_an_fmu_goes_to_standard_error(run):
    done = run("CONT_C", "HEATER", connect=LOOP, stop=2)
    assert done.returncode == 0
    assert "MAN_ON is TRUE: LMN follows MAN = 0 within its limits until MAN_ON is FALSE" in done.stderr


def test_the_figures_do_not_depend_on_what_is_recorded(run):
    """A step while the loop is in manual mode is none: automatic mode at 300 s begins it."""
    record = ["CONT_C.SP_INT", "CONT_C.PV", "CONT_C.LMN"]
    given = {"CONT_C.GAIN": 0.7, "CONT_C.TI": 130, "CONT_C.SP_INT": "60@60", "CONT_C.MAN_ON": "false@300", "CONT_C.CYCLE": 1}

    def figures(*more):
        done = run("CONT_C", "HEATER", connect=LOOP, set=given, record=[*record, *more], step=1, stop=900)
        assert done.returncode == 0, done.stderr
        return [line for line in done.stdout.splitlines() if re.match(r" *(Rise|Settling|Overshoot|setpoint step)", line)]

    assert figures() == figures("CONT_C.MAN_ON") != []


def test_a_drawing_can_be_svg(run, tmp_path):
    assert run("HEATER", stop=2, plot="result.svg").returncode == 0
    assert (tmp_path / "result.svg").read_text().startswith("<svg ")


def test_a_drawing_has_the_colours_of_the_pages(run, tmp_path):
    record = ["CONT_C.SP_INT", "CONT_C.PV", "CONT_C.LMN", "CONT_C.LMN_P", "CONT_C.LMN_I", "HEATER.TEMP", "HEATER.T_FURN"]
    assert run("CONT_C", "HEATER", connect=LOOP, record=record, stop=2, plot="result.svg").returncode == 0
    entry = r'<path class="(curve-\d)" [^>]*/><text[^>]*>([\w.]+)<'
    colors = {name: color for color, name in re.findall(entry, (tmp_path / "result.svg").read_text())}
    # Black, blue and vermilion; LMN_P and LMN_I as in the responses of CONT_C, TEMP and T_FURN as in those of HEATER.
    assert colors == dict(zip(record, [f"curve-{number}" for number in (7, 1, 2, 4, 3, 1, 3)]))


def test_a_drawing_has_the_units_of_the_plant_and_says_what_happens(run, tmp_path):
    record = ["CONT_C.SP_INT", "CONT_C.PV", "CONT_C.LMN", "CONT_C.GAIN", "CONT_C.ER", "CONT_C.LMN_P", "CONT_C.LMN_I"]
    wires = {"CONT_C.LMN": "HEATER.POWER", "HEATER.TEMP": "CONT_C.PV_IN"}
    step = {"CONT_C.MAN_ON": "false", "CONT_C.SP_INT": 60}
    assert run("CONT_C", "HEATER", connect=wires, set=step, record=record, stop=5, plot="result.svg").returncode == 0
    texts = re.findall("<text[^>]*>([^<]*)<", (tmp_path / "result.svg").read_text())
    assert "CONT_C with HEATER: step at the start, from 20 to 60 °C" in texts
    # The controller has no units of its own; those of the plant are TEMP in degC and POWER in %.
    assert {"SP_INT, PV in °C", "LMN in %", "GAIN, ER, LMN_P, LMN_I"} <= set(texts)


# An FMU of somebody else


@pytest.fixture(scope="module")
def integrator(pack_foreign, tmp_path_factory):
    """tests/foreign/integrator.c as an FMU with a resource."""
    path = pack_foreign("integrator", tmp_path_factory.mktemp("foreign"))
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr("resources/gain.txt", "0.5")
    return str(path)


def test_an_fmu_of_others_with_the_least_functions_runs_and_finds_its_resources(run, integrator):
    table = recorded(run, integrator, set={"INTEGRATOR.U": 4, "INTEGRATOR.ON": "true@1"}, step=0.5, stop=2)
    assert [row["INTEGRATOR.Y"] for row in table] == ["0.0", "0.0", "0.0", "1.0", "2.0"]
    assert [row["INTEGRATOR.STEPS"] for row in table] == ["0", "1", "2", "3", "4"]
    assert [row["INTEGRATOR.ON"] for row in table] == ["0", "0", "1", "1", "1"]


def test_an_integer_goes_to_a_real(run, integrator):
    table = recorded(
        run,
        f"a={integrator}",
        f"b={integrator}",
        connect={"a.STEPS": "b.U"},
        set={"b.ON": 1},
        step=1,
        stop=3,
        record=["b.U", "b.Y"],
    )
    assert [row["b.U"] for row in table] == ["1.0", "2.0", "3.0", "3.0"]
    assert [row["b.Y"] for row in table] == ["0.0", "0.5", "1.5", "3.0"]


def test_a_discarded_step_is_an_error_with_the_fmus_message(run, integrator):
    settings = {"INTEGRATOR.U": 1, "INTEGRATOR.ON": 1, "INTEGRATOR.LIMIT": 1.2}
    sentence = refusal(run, integrator, set=settings, step=1, stop=9)
    # The message's format: its variables cannot be read.
    assert sentence == "INTEGRATOR: at 2.0 s, step 1.0 s: fmi2DoStep returned fmi2Discard: Y is above %g"


def test_an_fmu_that_proposes_no_times_asks_for_them(run, integrator):
    assert refusal(run, integrator) == "no FMU proposes a communication step: specify one, such as step = 0.1"
