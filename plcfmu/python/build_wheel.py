"""Builds the Python wheel of plcfmu: the command, the FMUs and the Python package.

    target/venv/bin/python plcfmu/python/build_wheel.py --fmus target/fmu --out target/dist

Needs Rust and, in the Python that runs this program, maturin and (for Linux) ziglang. `cargo xtask fmu` installs both
in target/venv. The same sources and FMUs give the same bytes.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

PYTHON = pathlib.Path(__file__).resolve().parent
ROOT = PYTHON.parents[1]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()

# What the wheel contains beside the FMUs and the command.
LICENSES = ("LICENSE-MIT", "LICENSE-APACHE")
MANIFEST = 'manifest-path = "../Cargo.toml"'


def host() -> str:
    """The target that rustc builds for by itself, such as x86_64-unknown-linux-gnu."""
    rustc = os.environ.get("RUSTC", "rustc")
    try:
        version = subprocess.run([rustc, "-vV"], stdout=subprocess.PIPE, text=True, check=True).stdout
    except FileNotFoundError:
        sys.exit(f"error: {rustc} was not found: install Rust (rustup.rs)")
    return next(line.partition(" ")[2] for line in version.splitlines() if line.startswith("host: "))


def stage(fmus: list[pathlib.Path], folder: pathlib.Path) -> None:
    """Puts what goes into the wheel together in a new folder.

    The FMUs do not go into the sources: a package imported from the checkout would find them there, not in target/fmu.
    """
    if folder.exists():
        shutil.rmtree(folder)
    package = folder / "plcfmu"
    shutil.copytree(PYTHON / "plcfmu", package, ignore=shutil.ignore_patterns("__pycache__", "fmus"))
    (package / "fmus").mkdir()
    for fmu in fmus:
        shutil.copyfile(fmu, package / "fmus" / fmu.name)
    shutil.copyfile(PYTHON / "README.md", folder / "README.md")
    for license in LICENSES:
        shutil.copyfile(ROOT / license, folder / license)
    project = (PYTHON / "pyproject.toml").read_text(encoding="utf-8")
    if MANIFEST not in project:
        sys.exit(f"error: {PYTHON / 'pyproject.toml'} has no line {MANIFEST}")
    manifest = f"manifest-path = '{ROOT / 'plcfmu' / 'Cargo.toml'}'"
    (folder / "pyproject.toml").write_text(project.replace(MANIFEST, manifest), encoding="utf-8")


def environment() -> dict[str, str]:
    """The environment variables for maturin, which keep this machine's paths out of the wheel."""
    cargo_home = os.environ.get("CARGO_HOME") or pathlib.Path.home() / ".cargo"
    flags = [f"--remap-path-prefix={cargo_home}=/cargo", f"--remap-path-prefix={ROOT}=/plcfmu"]
    variables = {**os.environ, "CARGO_ENCODED_RUSTFLAGS": "\x1f".join(flags)}
    variables.pop("RUSTFLAGS", None)
    cache = str(TARGET / "portable" / "zig")
    variables.update(ZIG_GLOBAL_CACHE_DIR=cache, ZIG_LOCAL_CACHE_DIR=cache, CARGO_ZIGBUILD_CACHE_DIR=cache)
    variables["CARGO_ZIGBUILD_PYTHON_PATH"] = sys.executable
    return variables


def build(fmus: list[pathlib.Path], out: pathlib.Path, target: str) -> pathlib.Path:
    """Builds the wheel in the folder `out` and returns its path."""
    staged = TARGET / "wheel" / "source"
    built = TARGET / "wheel" / "built"
    stage(fmus, staged)
    if built.exists():
        shutil.rmtree(built)
    command = [sys.executable, "-m", "maturin", "build", "--target", target, "--out", str(built)]
    command += ["--target-dir", str(TARGET / "portable")]
    if "-linux-" in target:
        # Runs with glibc 2.17 or newer, as the FMUs do.
        command += ["--zig", "--compatibility", "manylinux2014"]
    done = subprocess.run(command, cwd=staged, env=environment())
    if done.returncode != 0:
        sys.exit(f"error: maturin ended with status {done.returncode}")
    (wheel,) = built.glob("*.whl")
    out.mkdir(parents=True, exist_ok=True)
    # Renamed when it is whole, so that a wheel in `out` is never half written.
    part = out / f"{wheel.name}.part"
    shutil.copyfile(wheel, part)
    return part.replace(out / wheel.name)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument(
        "--fmus",
        type=pathlib.Path,
        metavar="FOLDER",
        default=TARGET / "fmu",
        help="folder of the FMUs (default: %(default)s)",
    )
    parser.add_argument(
        "--out",
        type=pathlib.Path,
        metavar="FOLDER",
        default=TARGET / "dist",
        help="folder for the wheel (default: %(default)s)",
    )
    parser.add_argument("--target", help="the command's Rust target (default: this machine)")
    options = parser.parse_args()
    fmus = sorted(options.fmus.glob("*.fmu"))
    if not fmus:
        sys.exit(
            f"error: there is no FMU in {options.fmus}: make them with `cargo xtask fmu`, "
            "or name another folder with --fmus"
        )
    target = options.target or host()
    needed = ["maturin", "ziglang"] if "-linux-" in target else ["maturin"]
    for module in needed:
        if importlib.util.find_spec(module) is None:
            sys.exit(f"error: {sys.executable} has no {module}: install it (pip install {module})")
    print(build(fmus, options.out.resolve(), target))


if __name__ == "__main__":
    main()
