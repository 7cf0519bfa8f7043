"""A folder of somebody else's is no reason to run anything: every command of plcfmu is called in folders that try to have their own
code run, by what cargo, rustup and Python read where they are started. Only `build` of a crate may do so, which is asked to."""

import os
import pathlib
import re
import shutil
import subprocess

import fmpy
import pytest

import host
import test_tune_study
import tool

ROOT = pathlib.Path(__file__).parents[1]

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the planted programs are shell scripts")

BUILD_PROGRAM = ["build", "tank.scl", "--cycle=500ms"]

# What each command is called with, in a folder with these files. `tool` is called apart: it stays.
CALLS = {
    "build": [BUILD_PROGRAM, [*BUILD_PROGRAM, "--native"]],
    "check": [["check", "tank.scl"], ["check", "{fmus}/CONT_C.fmu", "--run"]],
    "child": [["child", "none", "."]],
    "completions": [["completions", "bash"]],
    "figures": [["figures"]],
    "gains": [["gains", "--parallel=KP=2,KI=0.1,KD=0"]],
    "help": [["help"]],
    "info": [["info", "{fmus}/CONT_C.fmu"]],
    "manual": [["manual", "--out=pages"]],
    # Without a client it ends at once.
    "mcp": [["mcp"]],
    "merge": [["merge", "{fmus}/CONT_C.fmu", "{fmus}/CONT_C.fmu", "--out=JOINED.fmu"]],
    "new": [["new", "own"], ["new", "press", "--scl"]],
    "params": [["params", "plant.awl", "--out=plant.json"]],
    "preset": [["preset", "plant.awl", "--fmus={fmus}", "--out=presets"]],
    "prove": [["prove", "CONT_C", "--out=prove.scl"]],
    "run": [["run", "tank_loop.toml", "--stop=1"], ["run", "{fmus}/CONT_C.fmu", "--step=1", "--stop=1"]],
    "show": [["show", "tank.scl", "--as=scl"]],
    "ssp": [["ssp", "tank_loop.toml", "--out=tank.ssp"]],
    "study": [["study", "study.toml", "--out=study"]],
    "test": [["test", "tank.toml"]],
    "tool": [],
    "tune-study": [["tune-study", "tuning.toml", "--fmus={fmus}", "--out=tuning"]],
}

# They are called wrongly: what they need comes from another program.
REFUSE = ("child", "figures", "mcp")

STUDY = """
loop = "tank_loop.toml"
stop = 1.0
samples = 1
seed = 1

[[axes]]
variable = "FILLING.levelSp"
uniform = { min = 40.0, max = 60.0 }

[[values]]
variable = "TANK.level"
take = ["last"]
"""

MANIFEST = """[package]
name = "{name}"
version = "0.1.0"
edition = "2024"
build = "{root}/build.rs"

[lib]
path = "{root}/lib.rs"
crate-type = ["{kind}"]

{rest}
"""


class Folder:
    """A folder with sources of PLC programs, and with what would run code of its own."""

    def __init__(self, path, command):
        self.path, self.command = path / "project", command
        self.marks = path / "marks"
        self.marks.mkdir()
        self.path.mkdir()
        for file in (ROOT / "examples/programs").glob("tank*"):
            shutil.copy(file, self.path)
        shutil.copy(ROOT / "examples/plant/plant.awl", self.path)
        tuning = test_tune_study.written(self.path, **{"evaluations = 400": "evaluations = 10"})
        tuning.rename(self.path / "tuning.toml")
        (self.path / "study.toml").write_text(STUDY, encoding="utf-8")

    def write(self, name, text, mode=0o644):
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        path.chmod(mode)
        return path

    def script(self, name, then="exit 1"):
        """A program that leaves a mark."""
        return self.write(name, f'#!/bin/sh\n: > "{self.marks}/{pathlib.Path(name).name}"\n{then}\n', 0o755)

    def run(self, *arguments, **more):
        # As a user calls it who has no FMUs packed and no cargo around the command.
        hidden = ("PLCFMU_FMUS", "CARGO", "RUSTUP_TOOLCHAIN", "RUSTC", "VIRTUAL_ENV")
        variables = {name: value for name, value in os.environ.items() if name not in hidden} | more
        given = [self.command, *(argument.format(fmus=host.FOLDER) for argument in arguments)]
        return subprocess.run(given, cwd=self.path, env=variables, stdin=subprocess.DEVNULL, capture_output=True, text=True)

    def left(self):
        """The names of the marks, which are taken away."""
        names = {path.name for path in self.marks.iterdir()}
        for name in names:
            (self.marks / name).unlink()
        return names


def plant_packages(folder):
    """Crates whose build scripts leave a mark, a wrapper of the compiler, modules for Python, and a program library."""
    root = folder.path.as_posix()
    marks = folder.marks.as_posix()
    folder.write("build.rs", f'fn main() {{ std::fs::write("{marks}/build.rs", "").unwrap(); }}\n')
    folder.write("lib.rs", "")
    folder.write("fmu/Cargo.toml", MANIFEST.format(root=root, name="fmu", kind="rlib", rest=""))
    needs = '[dependencies]\nfmu.path = "../fmu"\n'
    for name, rest in (("pump", needs), ("program_library", f"{needs}\n[package.metadata.plcfmu]\nprograms = true\n")):
        folder.write(f"{name}/Cargo.toml", MANIFEST.format(root=root, name=name, kind="cdylib", rest=rest))
    folder.write("Cargo.toml", '[workspace]\nresolver = "3"\nmembers = ["fmu", "pump", "program_library"]\n')
    wrapper = folder.script("wrapper", 'exec "$@"')
    folder.write(".cargo/config.toml", f'[build]\nrustc-wrapper = "{wrapper}"\n')
    folder.script("target/venv/bin/python")
    for module in ("sysconfig", "ziglang/__init__", "ziglang/__main__"):
        folder.write(f"{module}.py", f"open({str(folder.marks / 'module')!r}, 'w').close()\n")
    source = folder.write("mark.c", f'#include <stdio.h>\n__attribute__((constructor)) void m(void) {{ fopen("{marks}/library", "w"); }}\n')
    library = folder.path / f"programs/{fmpy.platform}/program{fmpy.sharedLibraryExtension}"
    library.parent.mkdir(parents=True)
    subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o", library, source], check=True)


def plant_toolchain(folder):
    """A toolchain that rustup takes for whatever is started in the folder."""
    folder.write("rust-toolchain.toml", f'[toolchain]\npath = "{folder.path / "tc"}"\n')
    for program in ("cargo", "rustc"):
        folder.script(f"tc/bin/{program}")
    (folder.path / "tc/lib").mkdir()


# What may leave a mark in each folder.
PLANTED = {plant_packages: {"build.rs", "wrapper", "python", "module"}, plant_toolchain: {"cargo"}}


@pytest.fixture(scope="module", params=PLANTED, ids=lambda plant: plant.__name__)
def planted(request, command, tmp_path_factory):
    if request.param is plant_toolchain and not shutil.which("rustup"):
        pytest.skip("rustup is not installed: without it a folder chooses no toolchain")
    folder = Folder(tmp_path_factory.mktemp("somebody"), command)
    request.param(folder)
    # The traps are set: a crate that is built on request springs them.
    folder.run("build")
    assert folder.left() == PLANTED[request.param]
    return folder


def commands(command):
    """The names of all commands, hidden ones too, as the command itself tells a shell."""
    script = subprocess.run([command, "completions", "fish"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r'needs_command" .*-a "([\w-]+)"', script))


def test_every_command_is_called(command):
    assert commands(command) == set(CALLS)


@pytest.mark.parametrize("name", CALLS)
def test_no_command_runs_what_lies_in_the_current_folder(planted, name):
    for arguments in CALLS[name]:
        done = planted.run(*arguments)
        assert planted.left() == set(), arguments
        assert (done.returncode == 0) != (name in REFUSE), done.stderr


def test_the_parameter_tool_runs_nothing_of_the_current_folder(planted):
    with tool.Server(planted.command, planted.path, "tank.scl"):
        pass
    assert planted.left() == set()


@pytest.fixture
def with_cargo(command, tmp_path):
    """Calls the command, which was compiled in this clone, with a cargo that a script stands before."""
    folder = Folder(tmp_path, command)

    def with_cargo(script):
        cargo = folder.write("cargo", f'#!/bin/sh\n{script}\nexec "{shutil.which("cargo")}" "$@"\n', 0o755)
        return folder.run(*BUILD_PROGRAM, CARGO=str(cargo))

    return with_cargo


def test_a_program_is_built_without_a_word_of_cargo_unless_it_has_something_to_say(with_cargo):
    with_cargo("")
    done = with_cargo("")
    assert (done.returncode, done.stdout, done.stderr) == (0, "./TankFilling.fmu\n", "")
    waiting = "    Blocking waiting for file lock on artifact directory"
    done = with_cargo(f'case $1 in build) echo "{waiting}" >&2;; esac')
    assert (done.returncode, done.stderr) == (0, f"{waiting}\n")


def test_why_the_library_of_programs_is_not_built_is_said(with_cargo):
    done = with_cargo('case $1 in metadata) echo "error: no toolchain" >&2; exit 1;; esac')
    reason = f"cargo cannot read the package in {ROOT}: no toolchain"
    assert (done.returncode, done.stderr) == (1, f"error: the program library cannot be built: {reason}\n")
    done = with_cargo('case $1 in build) echo "error: no space left" >&2; exit 101;; esac')
    first, last = done.stderr.splitlines()
    assert done.returncode == 1 and first == "error: no space left"
    assert last.startswith("error: the program library cannot be built: ") and last.endswith("ended with exit status: 101")
