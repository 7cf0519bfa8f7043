"""Temporary files: they are their owner's alone, a signal leaves none, and the next command removes those of a killed one. Each
command is held where it waits for the reader of a FIFO."""

import os
import pathlib
import signal
import stat
import subprocess
import sys

import pytest

import host

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither FIFOs nor modes nor these signals")
CONT_C = str(host.FOLDER / "CONT_C.fmu")
# Each writes `fifo`, of the extension that it wants.
COMMANDS = {
    "run": (["run", CONT_C, "--stop=3", "--step=1", "--out"], "fifo.csv"),
    "params": (["params", "input.json", "--out"], "fifo.json"),
    "preset": (["preset", "input.json", "--fmus", str(host.FOLDER), "--out"], "fifo.fmu"),
    "ssp": (["ssp", CONT_C, "--out"], "fifo.ssp"),
    "merge": (["merge", CONT_C, CONT_C, "--out"], "fifo.fmu"),
    "prove": (["prove", "CONT_C", "--out"], "fifo.scl"),
}


@pytest.fixture
def folders(command, tmp_path):
    """The folder where a command works, with input.json, and the one for its temporary files."""
    work, temporary = tmp_path / "work", tmp_path / "temporary"
    work.mkdir()
    temporary.mkdir()
    subprocess.run([command, "params", CONT_C, "--out", "input.json"], cwd=work, check=True, capture_output=True)
    return work, temporary


@pytest.fixture
def held(command, folders):
    """Starts a command that waits for the reader of its output, and gives it with the FIFO."""
    work, temporary = folders
    started = []

    def held(name, umask=0o022):
        arguments, output = COMMANDS[name]
        os.mkfifo(work / output)
        started.append(
            subprocess.Popen(
                [command, *arguments, output], cwd=work, env={**os.environ, "TMPDIR": str(temporary)},
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=lambda: os.umask(umask),
            )
        )
        process = started[-1]
        while process.poll() is None and not any(temporary.iterdir()):
            pass
        assert process.poll() is None, process.stderr.read()
        return process, work / output

    yield held
    for process in started:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_one_signal_ends_a_command_that_waits_for_a_reader_and_leaves_nothing(held, folders, name, kind):
    work, temporary = folders
    before = set(work.iterdir())
    process, fifo = held(name)
    process.send_signal(kind)
    process.communicate(timeout=60)
    # The run itself is over, or is ended by the signal.
    assert process.returncode == 130
    assert list(temporary.iterdir()) == []
    assert set(work.iterdir()) == before | {fifo} and stat.S_ISFIFO(fifo.stat().st_mode)


def test_what_a_killed_command_has_left_is_removed_by_the_next_one(command, held, folders):
    work, temporary = folders
    process, _ = held("params")
    process.kill()
    process.wait()
    assert len(list(temporary.iterdir())) == 1
    # Beside an output, too; and what other programs have made stays.
    left, other = work / ".plcfmu-left.tmp", work / ".other.tmp"
    left.write_text("half of it")
    other.write_text("")
    done = subprocess.run([command, "params", "input.json", "--out", "output.json"], cwd=work, capture_output=True, text=True,
                          env={**os.environ, "TMPDIR": str(temporary)})
    assert done.returncode == 0, done.stderr
    assert list(temporary.iterdir()) == []
    assert not left.exists() and other.exists() and (work / "output.json").exists()


def test_what_another_command_uses_stays(command, held, folders):
    work, temporary = folders
    process, fifo = held("params")
    used = list(temporary.iterdir())
    subprocess.run([command, "params", "input.json"], cwd=work, check=True, capture_output=True,
                   env={**os.environ, "TMPDIR": str(temporary)})
    assert list(temporary.iterdir()) == used
    with fifo.open() as reader:
        assert reader.read() == (work / "input.json").read_text()
    assert process.wait(timeout=60) == 0


@pytest.mark.parametrize("umask", [0o000, 0o022, 0o077])
def test_temporary_files_are_their_owners_alone_and_results_as_the_umask_says(command, held, folders, umask):
    work, temporary = folders
    held("prove", umask)
    assert {stat.S_IMODE(path.stat().st_mode) for path in temporary.rglob("*")} == {0o600}
    subprocess.run([command, "params", "input.json", "--out", "output.json"], cwd=work, check=True, capture_output=True,
                   preexec_fn=lambda: os.umask(umask))
    assert stat.S_IMODE((work / "output.json").stat().st_mode) == 0o666 & ~umask


@pytest.mark.parametrize("arguments", [
    ["run", CONT_C, "--stop=3", "--step=1", "--out", "-"], ["info", CONT_C], ["params", "input.json"], ["gains", "--ideal=Kp=2"],
])
def test_a_result_for_a_closed_standard_output_is_not_lost_without_a_word(command, folders, arguments):
    closed = subprocess.run([command, *arguments], cwd=folders[0], stderr=subprocess.PIPE, text=True, preexec_fn=lambda: os.close(1))
    assert closed.returncode != 0
    assert closed.stderr.splitlines()[-1] == "error: standard output is closed: redirect it to a file, or to /dev/null"
