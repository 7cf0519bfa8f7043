"""Reads the parameters of control loops from the files of a PLC project with the command `plcfmu`.

The command is searched for in this order:

1. the program named by the environment variable PLCFMU_COMMAND;
2. the one installed with this package, in the same Python environment;
3. the latest result of `cargo build` in the repository, if the package is imported from a checkout;
4. `plcfmu` on PATH.
"""

from __future__ import annotations

import json
import os
import pathlib
import re
import shutil
import subprocess
import sysconfig
from typing import Optional, Union

from .find import Path, checkout
from .messages import LOGGER

Value = Union[bool, int, float]

VARIABLE = "PLCFMU_COMMAND"
PROGRAM = "plcfmu.exe" if os.name == "nt" else "plcfmu"


class CommandNotFoundError(FileNotFoundError):
    """The command `plcfmu` was not found; the message explains how to get it."""


class ParameterError(ValueError):
    """A file has no usable parameters. The text is the command's error, with file, line and column."""


def params(
    file: Path, *, block: Optional[str] = None, loop: Optional[str] = None, offset: int = 0
) -> dict[str, dict[str, Value]]:
    """The inputs and parameters of the loops in a file, by FMU variable name: `params("plant.awl")["TIC101"]["GAIN"]`.

    `file` is a STEP 7 or TIA Portal source, TIA Openness XML, a data block dump, JSON, SSV, an FMU, or a data block of
    a PLC ("s7://192.168.0.1/0/2/DB41"). `block` is the block of the loops, if the file does not specify it ("CONT_C",
    "FB 41"). `loop` selects one of several loops, or names a loop that the file leaves unnamed. `offset` is the byte at
    which the instance begins in a dump or in a PLC's data block.

    A TIME is in seconds. Variables that the file does not set have the block's start values, so each loop is complete.
    The command's remarks and warnings go to the logger "plcfmu".

    Raises ParameterError, and CommandNotFoundError if the command `plcfmu` is not found.
    """
    arguments = ["params", "--json", f"--offset={offset}"]
    if block is not None:
        arguments.append(f"--block={block}")
    if loop is not None:
        arguments.append(f"--loop={loop}")
    done = called(command(), *arguments, "--", os.fspath(file))
    if done.returncode != 0:
        raise ParameterError(reason(done))
    for line in done.stderr.strip().splitlines():
        LOGGER.warning("%s", line)
    loops: dict[str, dict[str, Value]] = json.loads(done.stdout)
    return loops


def command() -> pathlib.Path:
    """The program `plcfmu`. Raises CommandNotFoundError if it is not in any of the places listed in this module."""
    if os.environ.get(VARIABLE):
        given = pathlib.Path(os.environ[VARIABLE])
        if not given.is_file():
            raise CommandNotFoundError(f"{VARIABLE} is {given}, which is not a file: set it to the program plcfmu, or unset it")
        return given
    installed = pathlib.Path(sysconfig.get_path("scripts")) / PROGRAM
    if installed.is_file():
        return installed
    root = checkout()
    if root is not None:
        built = [path for path in (root / "target").glob(f"*/{PROGRAM}") if path.is_file()]
        if built:
            return max(built, key=lambda path: path.stat().st_mtime)
    found = shutil.which("plcfmu")
    if found is not None:
        return pathlib.Path(found)
    remedy = "`cargo build --release -p plcfmu` in the repository builds it" if root else "the wheel of plcfmu contains it"
    raise CommandNotFoundError(f"the command plcfmu was not found: {remedy}; or set {VARIABLE} to it")


def called(program: pathlib.Path, *arguments: str, given: str = "") -> subprocess.CompletedProcess[str]:
    """Runs the program and returns its output. `given` is its standard input."""
    call = [os.fspath(program), *arguments]
    return subprocess.run(call, input=given, capture_output=True, text=True, encoding="utf-8")


def reason(done: subprocess.CompletedProcess[str]) -> str:
    """Why a program failed: its error without the warnings before it, or how it ended if it printed nothing."""
    said = re.split(r"^error: ", done.stderr, maxsplit=1, flags=re.MULTILINE)[-1].strip()
    if done.returncode < 0:
        said = f"{said} ({done.args[0]} was terminated by signal {-done.returncode})".strip()
    return said or f"{' '.join(done.args)} returned {done.returncode}"
