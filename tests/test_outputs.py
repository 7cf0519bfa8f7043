"""Whatever a command writes to: what is no regular file is written into, links and modes stay, and nothing that the command
reads, no folder and no other output is overwritten."""

import os
import pathlib
import stat
import subprocess
import sys
import threading

import pytest

import host

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither FIFOs nor modes")
CONT_C = str(host.FOLDER / "CONT_C.fmu")
RUN = ["run", CONT_C, "--stop=3", "--step=1", "--record=CONT_C.LMN"]


@pytest.fixture
def plcfmu(command, tmp_path):
    """Runs `plcfmu` in a folder of its own."""

    def plcfmu(*arguments):
        return subprocess.run([command, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=60)

    return plcfmu


def refusal(done):
    assert done.returncode != 0
    (line,) = done.stderr.splitlines()
    return line


@posix
def test_a_fifo_is_written_into(plcfmu, tmp_path):
    os.mkfifo(tmp_path / "fifo")
    read = []
    reader = threading.Thread(target=lambda: read.append((tmp_path / "fifo").read_text()))
    reader.daemon = True
    reader.start()
    done = plcfmu(*RUN, "--out", "fifo")
    assert done.returncode == 0, done.stderr
    reader.join()
    assert read[0].startswith("time,CONT_C.LMN\n0.0,")
    assert stat.S_ISFIFO((tmp_path / "fifo").stat().st_mode)


@posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only the superuser can make a device")
def test_a_device_stays_a_device(plcfmu, tmp_path):
    try:
        os.mknod(tmp_path / "null", stat.S_IFCHR | 0o666, os.makedev(1, 3))
        (tmp_path / "null").write_text("")
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    assert plcfmu(*RUN, "--out", "null").returncode == 0
    assert stat.S_ISCHR((tmp_path / "null").stat().st_mode)


OUTPUTS = {
    "run --out": [*RUN, "--out", "output.csv"],
    "run --save": [*RUN, "--save", "output.csv"],
    "run --plot": [*RUN, "--plot", "output.svg"],
    "params --out": ["params", "input.json", "--out", "output.json"],
    "preset --out": ["preset", "input.fmu", "--set=GAIN=1", "--out", "output.fmu"],
    "ssp --out": ["ssp", "input.fmu", "--out", "output.ssp"],
    "merge --out": ["merge", "input.fmu", "input.fmu", "--out", "output.fmu"],
}


@pytest.fixture
def inputs(plcfmu, tmp_path):
    """input.fmu and input.json with the values of a loop."""
    (tmp_path / "input.fmu").write_bytes(pathlib.Path(CONT_C).read_bytes())
    assert plcfmu("params", "input.fmu", "--out", "input.json").returncode == 0


@posix
@pytest.mark.parametrize("arguments", OUTPUTS.values(), ids=OUTPUTS)
def test_a_link_stays_and_its_file_keeps_its_mode(plcfmu, tmp_path, inputs, arguments):
    link = tmp_path / arguments[-1]
    (tmp_path / "file").write_text("old")
    (tmp_path / "file").chmod(0o600)
    link.symlink_to("file")
    done = plcfmu(*arguments)
    assert done.returncode == 0, done.stderr
    assert link.is_symlink()
    assert (tmp_path / "file").read_bytes() != b"old"
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o600


@pytest.mark.parametrize("arguments", OUTPUTS.values(), ids=OUTPUTS)
def test_a_folder_is_refused(plcfmu, tmp_path, inputs, arguments):
    (tmp_path / arguments[-1]).mkdir()
    assert refusal(plcfmu(*arguments)) == f"error: {arguments[-1]} cannot be written: it is a folder: name a file in it"


LOOP = '# by hand\nstop = 3.0\nstep = 1.0\n[fmus]\nCONT_C = "input.fmu"\n[parameters]\nCONT_C = { file = "input.json" }\n'


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "input.fmu", "--stop=3", "--step=1", "--out", "input.fmu"],
        ["run", "loop.toml", "--save", "loop.toml"],
        ["run", "loop.toml", "--out", "./input.json"],
        ["params", "input.json", "--out", "input.json"],
        ["preset", "input.json", "--fmus", "input.fmu", "--out", "input.fmu"],
        ["preset", "input.json", "--fmus", "input.fmu", "--out", "input.json"],
        ["ssp", "NAME=input.ssp", "--out", "input.ssp"],
    ],
    ids=" ".join,
)
def test_an_input_is_not_overwritten(plcfmu, tmp_path, inputs, arguments):
    (tmp_path / "loop.toml").write_text(LOOP)
    (tmp_path / "input.ssp").write_bytes(pathlib.Path(CONT_C).read_bytes())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert refusal(plcfmu(*arguments)).endswith(f"{arguments[-1]} is read by this command: write to another file")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_two_outputs_do_not_have_one_name(plcfmu, tmp_path):
    done = plcfmu(*RUN, "--out", "one.svg", "--plot", "./one.svg")
    assert refusal(done) == "error: ./one.svg is given for two outputs: give each its own file"
    assert list(tmp_path.iterdir()) == []
