"""The licences of the code linked into the command `plcfmu`: the file NOTICE.txt in the wheel and the archives.

The crates are listed by cargo; their licence texts are in the source folders from which cargo builds them.
"""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys
from typing import Any

PLCFMU = pathlib.Path(__file__).resolve().parents[1]

NAME = "NOTICE.txt"

# The beginnings of licence file names, in capitals.
BEGINNINGS = ("LICENSE", "LICENCE", "UNLICENSE", "COPYING", "COPYRIGHT", "NOTICE")

INTRODUCTION = """\
The command plcfmu is built from the plcfmu project's sources (MIT OR Apache-2.0) and the crates below. It also contains
the Rust standard library and its components, as do the libraries in the FMUs: see the end of this file.
"""


def cargo(*arguments: str) -> str:
    command = [os.environ.get("CARGO", "cargo"), *arguments, "--locked", "--manifest-path", str(PLCFMU / "Cargo.toml")]
    done = subprocess.run(command, stdout=subprocess.PIPE, encoding="utf-8")
    if done.returncode != 0:
        sys.exit(f"error: {' '.join(command)} exited with status {done.returncode}")
    return done.stdout


PROGRAM = """\
The library in the FMU of a PLC program is built from the plcfmu project's sources (MIT OR Apache-2.0), the crates below, and the
components listed in NOTICE.
"""


def crates(target: str, package: str = "plcfmu") -> dict[str, dict[str, Any]]:
    """The third-party crates linked into a package, by `name version`: their entries in `cargo metadata`."""
    options = ["--package", package, "--edges", "normal,no-proc-macro", "--target", target, "--no-dedupe"]
    lines = cargo("tree", *options, "--prefix", "none", "--format", "{p}").splitlines()
    linked = {" ".join(line.split()[:2]) for line in lines}
    metadata = json.loads(cargo("metadata", "--format-version", "1", "--filter-platform", target))
    found = {}
    for one in metadata["packages"]:
        if one["source"] and f"{one['name']} v{one['version']}" in linked:
            found[f"{one['name']} {one['version']}"] = one
    return dict(sorted(found.items()))


def texts(folder: pathlib.Path) -> list[str]:
    """The licence texts in the folder of a crate's sources."""
    files = [path for path in folder.iterdir() if path.is_file() and path.name.upper().startswith(BEGINNINGS)]
    # A font crate has the licences next to the fonts; other crates have a folder for the licences of their parts.
    files += [*folder.glob("fonts/*.txt"), *folder.glob("licenses/*.txt")]
    return [path.read_text(encoding="utf-8", errors="replace").strip() for path in sorted(files)]


RULE = "-" * 100


def licences(linked: dict[str, dict[str, Any]]) -> list[str]:
    """A line for each crate, then each different licence text once, with the crates to which it applies."""
    # Copies of the same text may differ in white space.
    different: dict[str, tuple[str, list[str]]] = {}
    for crate, package in linked.items():
        folder = pathlib.Path(package["manifest_path"]).parent
        its = texts(folder)
        if not its and "Apache-2.0" in (package["license"] or "").split(" OR "):
            # The text of this licence is the same for every licensor.
            its = [(PLCFMU.parent / "LICENSE-APACHE").read_text(encoding="utf-8").strip()]
        if not its:
            sys.exit(f"error: {folder} has no licence text, which {NAME} requires: choose another version of {crate}")
        for text in its:
            different.setdefault(" ".join(text.split()), (text, []))[1].append(crate)
    parts = [f"- {crate}: {package['license'] or package['license_file']}" for crate, package in linked.items()]
    for text, its_crates in different.values():
        parts += ["", RULE, f"{', '.join(its_crates)}:", "", text]
    return parts


def notices(target: str) -> str:
    """All licence notices of the command for a Rust target."""
    parts = [INTRODUCTION, *licences(crates(target))]
    for heading, file in (("The notice in each FMU", "NOTICE"), ("The Unicode licence", "LICENSE-UNICODE")):
        parts += ["", RULE, f"{heading}:", "", (PLCFMU / file).read_text(encoding="utf-8").strip()]
    return "\n".join(parts) + "\n"


def of_programs(target: str) -> str:
    """The notices of the library in a PLC program's FMU: the file NOTICE-PROGRAM, written by `python notices.py`."""
    text = "\n".join([PROGRAM, *licences(crates(target, "program_library"))])
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def bill_of_materials(target: str, version: str) -> str:
    """The third-party crates in the command for a Rust target, as CycloneDX 1.6, without a timestamp."""
    command = {"type": "application", "bom-ref": "plcfmu", "name": "plcfmu", "version": version}
    components = [
        {
            "type": "library",
            "bom-ref": f"pkg:cargo/{package['name']}@{package['version']}",
            "name": package["name"],
            "version": package["version"],
            "licenses": [{"expression": package["license"]}] if package["license"] else [],
            "purl": f"pkg:cargo/{package['name']}@{package['version']}",
        }
        for package in crates(target).values()
    ]
    bill = {"bomFormat": "CycloneDX", "specVersion": "1.6", "version": 1, "metadata": {"component": command}}
    return json.dumps({**bill, "components": components}, indent=2) + "\n"


if __name__ == "__main__":
    (PLCFMU / "NOTICE-PROGRAM").write_text(of_programs("x86_64-unknown-linux-gnu"), encoding="utf-8", newline="\n")
