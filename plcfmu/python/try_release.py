"""Tries the wheel and the archive for this machine as a user would: the wheel in an empty environment, the archive in
an empty folder, without Rust, other packages or settings. In each, the command builds a program in SCL and runs it.

    target/venv/bin/python plcfmu/python/try_release.py target/dist
"""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile

import build_wheel

PROGRAM = pathlib.Path("examples/programs/tank.scl")
BUILD = ["build", PROGRAM.name, "--cycle=500ms"]
# A tank at 20 % is filled after a start: its inlet opens.
RUN = ["run", "TankFilling.fmu", "--stop=1", "--set=TankFilling.level=20", "--set=TankFilling.start=true"]
RUN += ["--record=TankFilling.inletValve", "--out=-"]


def of_wheel(wheel: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """Installs the wheel, without its Python dependencies, in a new environment; returns the path of the command."""
    venv.create(folder, with_pip=False)
    programs = folder / ("Scripts" if os.name == "nt" else "bin")
    pip = [sys.executable, "-m", "pip", "--python", str(programs / "python"), "install", "--quiet"]
    subprocess.run([*pip, "--no-deps", "--no-index", str(wheel)], check=True)
    return programs / "plcfmu"


def of_archive(archive: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """Unpacks the archive in a new folder and returns the path of the command."""
    if archive.suffix == ".zip":
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)
    else:
        with tarfile.open(archive) as packed:
            packed.extractall(folder)
    (inside,) = folder.iterdir()
    return inside / "plcfmu"


def attempt(command: pathlib.Path, what: pathlib.Path, folder: pathlib.Path) -> None:
    """Builds the program and runs it in a new folder."""
    folder.mkdir()
    (folder / PROGRAM.name).write_bytes((build_wheel.ROOT / PROGRAM).read_bytes())
    # Windows needs its system folder; no other setting of this machine is passed on.
    variables = {name: value for name, value in os.environ.items() if name.upper() == "SYSTEMROOT"}
    variables.update(PATH=str(folder), HOME=str(folder), USERPROFILE=str(folder), TMPDIR=str(folder), TEMP=str(folder))
    for arguments in (BUILD, RUN):
        done = subprocess.run([str(command), *arguments], cwd=folder, env=variables, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"error: {what.name}: plcfmu {' '.join(arguments)} exited with status {done.returncode}:\n{done.stderr}")
    last = done.stdout.split()[-1]
    if last.partition(",")[2] not in ("true", "1"):
        sys.exit(f"error: {what.name}: after the start, the inlet of a tank at 20 % is not open: the run ended with {last}")


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("error: specify the folder with the wheels and archives: try_release.py FOLDER")
    folder = pathlib.Path(sys.argv[1]).resolve()
    platform = build_wheel.PLATFORMS[build_wheel.host()]
    archives = [path for path in folder.glob(f"plcfmu-*-{platform}.*") if path.name.endswith((".tar.gz", ".zip"))]
    tags = {"linux64": "*linux*_x86_64", "aarch64-linux": "*linux*_aarch64", "win64": "win_amd64"}
    wheels = list(folder.glob(f"plcfmu-*-{tags.get(platform, 'macosx*')}.whl"))
    for kind, found in (("wheel", wheels), ("archive", archives)):
        if len(found) != 1:
            sys.exit(f"error: {folder} has {len(found)} {kind}s for {platform}: expected one")
    with tempfile.TemporaryDirectory() as name:
        place = pathlib.Path(name)
        for what, install in ((wheels[0], of_wheel), (archives[0], of_archive)):
            (place / what.name).mkdir()
            attempt(install(what, place / what.name / "installed"), what, place / what.name / "empty")
            print(f"{what.name}: builds a program and runs it")


if __name__ == "__main__":
    main()
