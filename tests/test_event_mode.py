"""FMUs of FMI 3.0 in `plcfmu run`, `check` and `info`: Event Mode, arrays, exact types, what a broken FMU costs. The FMUs are
tests/foreign/sampled.c, a controller with Y = SP - PV, and held.c, a plant that adds its step times U to Y."""

import csv
import io
import json
import subprocess
import zipfile

import plcfmu
import pytest

SP = 8
# Of the loop with a step of 0.5: the distance from the setpoint halves with each call.
LOOP = [(0.0, 8, 0.0), (0.5, 4, 4.0), (1.0, 2, 6.0), (1.5, 1, 7.0), (2.0, 1, 7.5)]
# The same with the plant first, without Event Mode: it gets the output of the call before.
LATE = [(0.0, 0, 0.0), (0.5, 8, 4.0), (1.0, 4, 6.0), (1.5, 2, 7.0), (2.0, 1, 7.0)]
FIRST_COUNT = 2**53 + 1
CONNECTED = ["--connect=S.Y=P.U", "--connect=P.Y=S.PV"]
NOT_A_NUMBER, ENDLESS, BACKWARDS, STANDING, ENDING = range(1, 6)


def with_resource(path, text):
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr("resources/gain.txt", text)
    return path


@pytest.fixture(scope="module")
def sampled(pack_foreign, tmp_path_factory):
    return with_resource(pack_foreign("sampled", tmp_path_factory.mktemp("sampled")), "2.5")


@pytest.fixture(scope="module")
def held(pack_foreign, tmp_path_factory):
    return pack_foreign("held", tmp_path_factory.mktemp("held"))


@pytest.fixture(scope="module")
def integrator(pack_foreign, tmp_path_factory):
    """The same plant as `held`, of FMI 2.0; ON switches it on."""
    return with_resource(pack_foreign("integrator", tmp_path_factory.mktemp("integrator")), "1")


@pytest.fixture
def run_command(command, tmp_path):
    """Runs `plcfmu`."""

    def run_command(*arguments, check=False):
        return subprocess.run([command, *arguments], cwd=tmp_path, text=True, capture_output=True, check=check)

    return run_command


@pytest.fixture
def record(run_command):
    """Runs FMUs and gives the header and the rows as they are written."""

    def record(*arguments):
        done = run_command("run", *arguments, "--out=-")
        assert done.returncode == 0, done.stderr
        header, *rows = csv.reader(io.StringIO(done.stdout))
        return header, rows

    return record


@pytest.fixture
def loop(record, sampled, held):
    def loop(*fmus, settings=()):
        _, rows = record(*fmus, *CONNECTED, f"--set=S.SP={SP}", "--record=S.Y", "--record=P.Y", "--step=0.5", "--stop=2", *settings)
        return [tuple(map(float, row)) for row in rows]

    return loop


def test_a_loop_in_event_mode_has_no_delay_in_either_order(loop, sampled, held):
    for fmus in [(f"S={sampled}", f"P={held}"), (f"P={held}", f"S={sampled}")]:
        assert loop(*fmus) == LOOP
        assert loop(*fmus, settings=["--parallel"]) == LOOP


def test_without_event_mode_the_order_decides(loop, sampled, held):
    assert loop(f"S={sampled}", f"P={held}", settings=["--no-events"]) == LOOP
    assert loop(f"P={held}", f"S={sampled}", settings=["--no-events"]) == LATE


def test_a_plant_of_fmi_2_gets_the_output_of_the_same_instant_in_either_order(loop, sampled, integrator):
    for fmus in [(f"S={sampled}", f"P={integrator}"), (f"P={integrator}", f"S={sampled}")]:
        assert loop(*fmus, settings=["--set=P.ON=true"]) == LOOP
        # The input is what the call got, wherever the plant stands.
        rows = loop(*fmus, settings=["--set=P.ON=true", "--record=S.PV"])
        assert [row[3] for row in rows] == [row[2] for row in LOOP]


def test_a_description_says_whether_events_are_used(record, sampled, held, tmp_path, run_command):
    file = tmp_path / "loop.toml"
    arguments = [f"P={held}", f"S={sampled}", *CONNECTED, f"--set=S.SP={SP}", "--record=S.Y", "--record=P.Y", "--step=0.5", "--stop=2"]
    run_command("run", *arguments, "--no-events", f"--save={file}", check=True)
    assert "event_mode = false" in file.read_text()
    assert [tuple(map(float, row)) for row in record(str(file))[1]] == LATE


def test_calls_within_a_step_are_made_at_their_times(record, sampled):
    for events in [[], ["--no-events"]]:
        _, rows = record(f"S={sampled}", "--set=S.PERIOD=0.25", "--record=S.COUNT", "--step=1", "--stop=2", *events)
        # The call at the time of a row is made in Event Mode already; the others are made in the steps.
        first = FIRST_COUNT + (0 if events else 1)
        assert [row[1] for row in rows] == [str(count) for count in [first, first + 4, FIRST_COUNT + 8]]


def test_arrays_are_set_connected_and_recorded_whole_or_by_element(record, sampled):
    header, rows = record(f"S={sampled}", "--set=S.A=2", "--set=S.A[1,2]=-1@1", "--record=S.B", "--step=0.5", "--stop=1.5")
    assert header == ["time", "S.B[1,1]", "S.B[1,2]", "S.B[2,1]", "S.B[2,2]"]
    assert rows[0][1:] == ["5.0"] * 4
    assert rows[2][1:] == ["5.0", "-2.5", "5.0", "5.0"]
    header, rows = record(
        f"S={sampled}", f"T={sampled}", "--connect=S.B=T.A", "--set=S.A[2,2]=1", "--record=T.B[2,2]", "--record=T.B[1,1]"
    )
    assert header == ["time", "T.B[2,2]", "T.B[1,1]"]
    # Both are called at 0, the one that feeds the other first.
    assert rows[0] == ["0.0", "6.25", "0.0"]


def test_an_event_waits_for_those_of_the_fmus_that_feed_it(record, sampled):
    _, rows = record(f"T={sampled}", f"S={sampled}", "--connect=S.B=T.A", "--set=S.A[1,1]=2@1", "--record=T.B[1,1]")
    assert [row[1] for row in rows] == ["0.0", "0.0", "12.5", "12.5", "12.5"]


def test_integers_of_64_bits_are_exact_in_recordings_and_connections(record, sampled):
    arguments = [f"S={sampled}", f"T={sampled}", "--connect=S.COUNT=T.OFFSET", "--record=S.COUNT", "--record=T.OFFSET"]
    _, rows = record(*arguments, "--step=0.5", "--stop=1")
    assert [row[1:] for row in rows] == [[str(FIRST_COUNT + calls)] * 2 for calls in [1, 2, 2]]


def test_a_setting_of_64_bits_is_exact_in_a_description_too(record, run_command, sampled, tmp_path):
    arguments = [f"S={sampled}", f"--set=S.OFFSET={FIRST_COUNT}", f"--set=S.OFFSET={-FIRST_COUNT}@0.5", "--record=S.OFFSET"]
    expected = [[str(FIRST_COUNT)], [str(-FIRST_COUNT)]]
    assert [row[1:] for row in record(*arguments, "--step=0.5", "--stop=1")[1]][:2] == expected
    file = tmp_path / "loop.toml"
    run_command("run", *arguments, "--step=0.5", "--stop=1", f"--save={file}", check=True)
    assert [row[1:] for row in record(str(file))[1]][:2] == expected


@pytest.mark.parametrize(
    "setting, error",
    [
        ("S.OFFSET=9223372036854775808", "it is Int64; 9223372036854775808 is not a whole number from -9223372036854775808 to 9223372036854775807"),
        ("S.SP=9007199254740993", "it is Real, which cannot represent 9007199254740993; the nearest number is 9007199254740992"),
        ("S.BYTE=256", "S.BYTE cannot be set: it is UInt8; 256.0 is not a whole number from 0 to 255"),
        ("S.BYTE=0.5", "S.BYTE cannot be set: it is UInt8; 0.5 is not a whole number from 0 to 255"),
        ("S.BLOB=1", "S.BLOB is a Binary, which cannot be set or recorded"),
        ("S.A[3,1]=1", "S has no variable A[3,1]; did you mean S.A["),
    ],
)
def test_what_a_variable_cannot_hold_is_told(run_command, sampled, setting, error):
    done = run_command("run", f"S={sampled}", f"--set={setting}")
    assert done.returncode in (1, 2)
    assert error in done.stderr


@pytest.mark.parametrize(
    "connection, error",
    [
        ("S.B=T.SP", "it has 4 values, but the input has a single value: connect elements, such as S.B[1]"),
        ("S.COUNT=T.SP", "it is Int64, but the input is Float64"),
    ],
)
def test_what_does_not_fit_is_not_connected(run_command, sampled, connection, error):
    done = run_command("run", f"S={sampled}", f"T={sampled}", f"--connect={connection}")
    assert done.returncode == 1
    assert error in done.stderr


@pytest.mark.parametrize(
    "fault, settings, error",
    [
        (NOT_A_NUMBER, [], "S at 0.0 s: fmi3UpdateDiscreteStates returned NaN as the time of the next event"),
        (ENDLESS, [], "S at 0.0 s: event iteration does not end: outputs still change after 100 updates; step the loop without Event Mode"),
        (BACKWARDS, ["--set=S.PERIOD=0.25"], "fmi3DoStep returned early at -1.0 s, which is outside the step"),
        (STANDING, ["--set=S.PERIOD=0.25"], "fmi3DoStep repeatedly returned early at 0.0 s"),
    ],
)
def test_an_fmu_whose_answers_make_no_sense_is_named(run_command, sampled, fault, settings, error):
    done = run_command("run", f"S={sampled}", f"--set=S.FAULT={fault}", *settings)
    assert done.returncode == 1
    assert error in done.stderr


def test_an_fmu_may_end_the_run_in_event_mode(record, sampled):
    _, rows = record(f"S={sampled}", f"--set=S.FAULT={ENDING}", "--record=S.COUNT")
    assert [row[0] for row in rows] == ["0.0", "0.5", "1.0"]


def test_a_wrong_token_and_a_missing_function_are_told(run_command, pack_foreign, sampled, tmp_path):
    wrong = tmp_path / "wrong.fmu"
    with zipfile.ZipFile(sampled) as fmu, zipfile.ZipFile(wrong, "w") as other:
        for name in fmu.namelist():
            other.writestr(name, fmu.read(name).replace(b'Token="{sampled}"', b'Token="{other}"'))
    done = run_command("run", f"S={wrong}")
    assert done.returncode == 1
    assert "fmi3InstantiateCoSimulation returned no instance: the instantiation token is not {sampled}" in done.stderr
    lacking = with_resource(pack_foreign("sampled", tmp_path, "-DLACKS"), "1")
    done = run_command("run", f"S={lacking}", "--set=S.BYTE=1")
    assert "its library lacks fmi3SetUInt8" in done.stderr
    assert "it does not export" in run_command("check", str(lacking)).stdout


def test_an_fmu_with_clocks_is_refused_by_their_names(run_command, sampled, tmp_path):
    ticking = tmp_path / "ticking.fmu"
    clock = b'<Clock name="tick" valueReference="20" causality="input" intervalVariability="triggered"/></ModelVariables>'
    with zipfile.ZipFile(sampled) as fmu, zipfile.ZipFile(ticking, "w") as other:
        for name in fmu.namelist():
            other.writestr(name, fmu.read(name).replace(b"</ModelVariables>", clock))
    done = run_command("run", str(ticking))
    assert done.returncode == 1
    assert "the FMU has Clocks (tick), which this program does not support: export it without Clocks" in done.stderr
    assert run_command("info", str(ticking)).returncode == 0


def test_a_foreign_fmu_is_checked_with_and_without_event_mode(run_command, held, sampled):
    done = run_command("check", "--run", str(sampled))
    assert done.stdout.rstrip().endswith("all variables read, freed\n  ok")
    done = run_command("check", "--run", str(held))
    assert done.returncode == 1 and "it does not export fmi3" in done.stdout
    described = json.loads(run_command("info", "--json", str(sampled), check=True).stdout)
    described = described[0] if isinstance(described, list) else described
    types = {variable["name"]: variable["type"] for variable in described["variables"]}
    assert types["COUNT"] == "Int64" and types["A"] == "Float64"


def test_the_python_package_steps_an_fmu_of_fmi_3(sampled):
    with plcfmu.Fmus() as fmus:
        one = fmus.start(sampled, {"SP": SP, "A": [1, 2, 3, 4]})
        one.step(0.0, 0.5, PV=2.0)
        assert one.get("Y COUNT B") == {"Y": 6.0, "COUNT": FIRST_COUNT + 1, "B": [2.5, 5.0, 7.5, 10.0]}
        with pytest.raises(TypeError, match="BYTE is a UInt8, which cannot be 256; assign an integer of 8 bits"):
            one["BYTE"] = 256
        with pytest.raises(TypeError, match="A is an array of 4 values; assign a list of that length"):
            one["A"] = 1.0
        with pytest.raises(plcfmu.FmuError, match="BLOB is a Binary, which can be neither read nor written"):
            one["BLOB"]
