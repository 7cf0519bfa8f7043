"""Builds FMUs from PLC programs in SCL with the command `plcfmu`."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Sequence
from typing import Union

from .find import Path
from .messages import LOGGER
from .parameters import called, command, reason

Option = Union[str, int, Sequence[str]]


class BuildError(ValueError):
    """A program has errors. The text is the command's output, with file, line and column."""


def build(
    sources: Union[Path, Sequence[Path]], *, cycle: Union[str, Sequence[str]], out: Path = ".", **options: Option
) -> pathlib.Path:
    """Packs a program as an FMU in the folder `out`, and returns its path: build("machine.scl", cycle="100ms").

    `sources` is one file or all files of the program. `options` are the options of `plcfmu build` by name, each a
    string or a list of strings: fb="Motor", tag=["Start : Bool", "Lamp : Bool"]. The command's warnings go to the
    logger "plcfmu".

    Raises BuildError, and CommandNotFoundError if the command `plcfmu` is not found.
    """
    files = [sources] if isinstance(sources, (str, os.PathLike)) else list(sources)
    arguments = ["build", f"--out={os.fspath(out)}"]
    for name, values in {"cycle": cycle, **options}.items():
        listed = [values] if isinstance(values, (str, int)) else values
        arguments += [f"--{name}={value}" for value in listed]
    done = called(command(), *arguments, "--", *map(os.fspath, files))
    if done.returncode != 0:
        raise BuildError(reason(done))
    for line in done.stderr.strip().splitlines():
        LOGGER.warning("%s", line)
    return pathlib.Path(done.stdout.strip().splitlines()[-1])
