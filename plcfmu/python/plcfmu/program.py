"""The command line of a program that runs a loop."""

from __future__ import annotations

import argparse
import pathlib
from typing import Optional

from .find import checkout


def arguments(description: str) -> tuple[Optional[pathlib.Path], pathlib.Path]:
    """The folder of the FMUs and the folder for results, from --fmus and --out.

    Without --fmus, the first is None, so that `Fmus` searches for them; without --out, the second is `target/demo` in
    the repository, or `results` outside a checkout. The program's help shows the first paragraph of `description`.
    """
    root = checkout()
    parser = argparse.ArgumentParser(description=description.split("\n\n")[0])
    parser.add_argument(
        "--fmus", type=pathlib.Path, metavar="FOLDER", help="folder of the FMUs (default: PLCFMU_FMUS, or target/fmu)"
    )
    parser.add_argument(
        "--out",
        type=pathlib.Path,
        metavar="FOLDER",
        default=root / "target" / "demo" if root else pathlib.Path("results"),
        help="folder for CSV, PNG and SVG (default: %(default)s)",
    )
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    return given.fmus, given.out
