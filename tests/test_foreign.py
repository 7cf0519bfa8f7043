"""Foreign code in `plcfmu run` and `plcfmu check --run`: an FMU that crashes, leaves or hangs is told by its name and costs
neither the command nor the other FMUs; what it prints is no part of a recording; nothing is left behind."""

import os
import signal
import stat
import subprocess
import sys

import fmpy
import pytest

import host

ABORT, HANG, LEAVE, QUIT, END = 1, 2, 4, 5, 6
PID = str(host.FOLDER / "CONT_C.fmu")
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")


@pytest.fixture(scope="module")
def bad(pack_foreign, tmp_path_factory):
    """tests/foreign/faulty.c with a fault compiled in."""
    packed = {}

    def bad(fault):
        if fault not in packed:
            packed[fault] = pack_foreign("faulty", tmp_path_factory.mktemp("bad"), f"-DFAULT={fault}")
        return str(packed[fault])

    return bad


@pytest.fixture
def start(command, tmp_path):
    """Starts `plcfmu` with folders of its own for what it writes and for temporary files."""
    for folder in ["tmp", "out"]:
        (tmp_path / folder).mkdir()

    def start(*arguments):
        environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen([command, *arguments], cwd=tmp_path / "out", env=environment, text=True, **pipes)

    return start


@pytest.fixture
def plcfmu(start, tmp_path):
    """Runs `plcfmu`, and gives its return code, output and errors. No temporary file is left."""

    def plcfmu(*arguments):
        process = start(*arguments)
        output, errors = process.communicate(timeout=60)
        assert list((tmp_path / "tmp").iterdir()) == []
        return process.returncode, output, errors

    return plcfmu


ENDS = {
    ABORT: "crashed: signal 6 (abort)",
    HANG: "did not return within 1 s",
    LEAVE: "ended its process with exit code 3",
    QUIT: "ended its process with exit code 0; it logged: no more water",
}


@posix
@pytest.mark.parametrize("fault", ENDS)
def test_a_run_names_the_fmu_that_ends_it_and_writes_nothing(plcfmu, tmp_path, faulty, fault):
    settings = [f"--set=P.FAULT={fault}", "--set=P.AT=7", "--step=0.5", "--stop=9", "--time-limit=1"]
    code, output, errors = plcfmu("run", PID, f"P={faulty}", *settings, "--out", "run.csv")
    assert (code, output) == (1, "")
    assert errors.splitlines()[-1] == f"error: P: at 3.5 s, the FMU {ENDS[fault]}"
    assert list((tmp_path / "out").iterdir()) == []


@posix
@pytest.mark.parametrize("fault", ENDS)
def test_a_check_names_the_fmu_that_fails_and_checks_the_others(plcfmu, bad, fault):
    code, output, _ = plcfmu("check", "--run", "--time-limit=1", bad(fault), PID)
    assert code == 1
    assert f"WRONG: the FMU {ENDS[fault]}" in output
    assert "it printed: " in output
    assert output.rstrip().endswith("all variables read, freed\n  ok")


def test_a_file_that_cannot_be_read_has_a_return_code_of_its_own(plcfmu):
    code, _, errors = plcfmu("check", PID, "missing.fmu")
    assert code == 3
    assert errors.startswith("error: missing.fmu cannot be read: ")


def test_what_an_fmu_prints_goes_to_standard_error(plcfmu, faulty):
    code, output, errors = plcfmu("run", str(faulty), "--step=1", "--stop=2", "--record=FAULTY.Y", "--out=-")
    assert code == 0
    assert output == "time,FAULTY.Y\n0.0,0.0\n1.0,0.0\n2.0,0.0\n"
    assert "an FMU that talks" in errors


def test_an_fmu_may_end_the_run(plcfmu, faulty):
    settings = [f"--set=FAULTY.FAULT={END}", "--set=FAULTY.AT=3", "--set=FAULTY.U=8", "--record=FAULTY.Y"]
    code, output, errors = plcfmu("run", str(faulty), *settings, "--step=1", "--stop=9", "--out=-")
    assert code == 0
    # Three steps of y += (8 - y) / 8.
    assert output == "time,FAULTY.Y\n0.0,0.0\n1.0,1.0\n2.0,1.875\n3.0,2.640625\n"
    assert "FAULTY: at 3.0 s, step 1.0 s: the FMU ended the simulation" in errors
    assert "3 steps of 1 s" in errors


def test_the_rows_of_an_fmu_alone_are_those_of_fmpy(plcfmu, faulty):
    """From the start to the end, with what the FMU gave before the first step."""
    code, output, _ = plcfmu("run", str(faulty), "--set=FAULTY.U=8", "--record=FAULTY.Y", "--step=0.25", "--stop=9", "--out=-")
    assert code == 0
    rows = [tuple(map(float, line.split(","))) for line in output.splitlines()[1:]]
    options = {"step_size": 0.25, "output_interval": 0.25, "stop_time": 9.0}
    values = fmpy.simulate_fmu(str(faulty), start_values={"U": 8}, output=["Y"], **options)
    assert rows[:3] == [(0.0, 0.0), (0.25, 0.25), (0.5, 0.4921875)]
    assert rows == [(float(row["time"]), float(row["Y"])) for row in values]


def test_a_time_is_written_as_the_decimal_that_it_is(plcfmu, faulty):
    _, output, _ = plcfmu("run", str(faulty), "--record=FAULTY.Y", "--step=0.2", "--stop=600", "--out=-")
    assert [line.split(",")[0] for line in output.splitlines()[1:]] == [f"{step / 5:.1f}" for step in range(3001)]


@posix
def test_what_is_unpacked_is_its_owners_alone(start, tmp_path, faulty):
    """Nobody else can read it, or exchange the library before it is loaded, whatever the umask."""
    usual = os.umask(0)
    try:
        process = start("run", str(faulty), f"--set=FAULTY.FAULT={HANG}", "--step=1", "--stop=9")
    finally:
        os.umask(usual)
    assert process.stderr.readline() == "an FMU that talks\n"
    made = list((tmp_path / "tmp").rglob("*"))
    assert "faulty.so" in {path.name for path in made}
    assert {path: stat.S_IMODE(path.stat().st_mode) for path in made} == {path: 0o700 if path.is_dir() else 0o600 for path in made}


@posix
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_leaves_nothing(start, tmp_path, faulty, name):
    process = start("run", str(faulty), f"--set=FAULTY.FAULT={HANG}", "--step=1", "--stop=9")
    # It prints when it has been unpacked and loaded.
    assert process.stderr.readline() == "an FMU that talks\n"
    process.send_signal(getattr(signal, name))
    process.communicate(timeout=60)
    assert process.returncode == 130
    assert list((tmp_path / "tmp").iterdir()) == []


@posix
def test_what_a_killed_command_leaves_is_removed_by_the_next(start, plcfmu, tmp_path, faulty):
    process = start("run", str(faulty), f"--set=FAULTY.FAULT={HANG}", "--step=1", "--stop=9")
    assert process.stderr.readline() == "an FMU that talks\n"
    process.kill()
    # The output ends with the process that ran the FMU.
    process.communicate(timeout=60)
    (left,) = (tmp_path / "tmp").iterdir()
    assert left.name.startswith(".plcfmu-")
    assert plcfmu("info", PID)[0] == 0
