"""Finds the file of an FMU by its name.

FMUs are searched for in one folder, the first of these:

1. the folder specified by the caller;
2. the folder named by the environment variable PLCFMU_FMUS;
3. the FMUs that were installed with this package;
4. `target/fmu` in the repository, if the package is imported from a checkout.
"""

from __future__ import annotations

import difflib
import os
import pathlib
from typing import Optional, Union

Path = Union[str, "os.PathLike[str]"]

VARIABLE = "PLCFMU_FMUS"
INSTALLED = pathlib.Path(__file__).resolve().parent / "fmus"


class FmuNotFoundError(FileNotFoundError):
    """No FMU has this name; the message lists the FMUs and explains how to build one."""


def checkout() -> Optional[pathlib.Path]:
    """The repository's root, if the package is imported from a checkout."""
    parents = pathlib.Path(__file__).resolve().parents
    if len(parents) > 3 and (parents[3] / "xtask" / "Cargo.toml").is_file():
        return parents[3]
    return None


def fmu_folder(folder: Optional[Path] = None) -> pathlib.Path:
    """The folder that is searched for FMUs. It need not exist.

    Raises FmuNotFoundError if no folder is specified, PLCFMU_FMUS is not set, no FMU was installed with the package,
    and the package is not part of a checkout.
    """
    if folder is not None:
        return pathlib.Path(folder)
    if os.environ.get(VARIABLE):
        return pathlib.Path(os.environ[VARIABLE])
    if any(INSTALLED.glob("*.fmu")):
        return INSTALLED
    root = checkout()
    if root is not None:
        return root / "target" / "fmu"
    raise FmuNotFoundError(
        f"no FMUs were installed with plcfmu: specify their folder, or set {VARIABLE} to it; "
        "`cargo xtask fmu` in the plcfmu repository builds them"
    )


def fmu_names(folder: Optional[Path] = None) -> list[str]:
    """The names of all available FMUs, sorted: ["CONT_C", "CONT_S", ...]."""
    return sorted(path.stem for path in fmu_folder(folder).glob("*.fmu"))


def fmu(name: str, folder: Optional[Path] = None) -> pathlib.Path:
    """The path of an FMU by its name: fmu("CONT_C").

    Raises FmuNotFoundError if it does not exist; the message lists the FMUs and explains how to build one.
    """
    place = fmu_folder(folder)
    path = place / f"{name}.fmu"
    if path.is_file():
        return path
    names = fmu_names(place)
    near = difflib.get_close_matches(name.upper(), names, 1)
    if near:
        remedy = f"did you mean {near[0]}?"
    else:
        remedy = f"build it with `cargo xtask fmu {name}`, or name another folder (argument or {VARIABLE})"
    there = f"; available: {', '.join(names)}" if names else ""
    raise FmuNotFoundError(f"no {path}: {remedy}{there}")
