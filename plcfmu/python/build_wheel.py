"""Builds the Python wheel of plcfmu: the command, the FMUs and the Python package; and archives of the command alone.

    target/venv/bin/python plcfmu/python/build_wheel.py --fmus target/fmu --out target/dist --archive

Needs Rust and, in the Python that runs this program, maturin and (for Linux) ziglang. `cargo xtask fmu` installs both
in target/venv. The environment variable PLCFMU_CROSS_CARGO may name another cargo, which is used for targets other than
this machine. The same sources and FMUs yield a byte-identical wheel.
"""

from __future__ import annotations

import argparse
import gzip
import importlib.util
import io
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import zipfile

import notices

PYTHON = pathlib.Path(__file__).resolve().parent
ROOT = PYTHON.parents[1]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()

# The licence files in the wheel.
LICENSES = ("LICENSE-MIT", "LICENSE-APACHE")
# The line in pyproject.toml that stage() replaces with the absolute path.
MANIFEST = 'manifest-path = "../Cargo.toml"'

# FMI's names of the platforms for which the command is built, by Rust target.
PLATFORMS = {
    "x86_64-unknown-linux-gnu": "linux64",
    "aarch64-unknown-linux-gnu": "aarch64-linux",
    "x86_64-pc-windows-gnu": "win64",
    "x86_64-pc-windows-msvc": "win64",
    "x86_64-apple-darwin": "darwin64",
    "aarch64-apple-darwin": "aarch64-darwin",
}


def host() -> str:
    """The default target of rustc, such as x86_64-unknown-linux-gnu."""
    rustc = os.environ.get("RUSTC", "rustc")
    try:
        version = subprocess.run([rustc, "-vV"], stdout=subprocess.PIPE, text=True, check=True).stdout
    except FileNotFoundError:
        sys.exit(f"error: {rustc} was not found: install Rust (rustup.rs)")
    return next(line.partition(" ")[2] for line in version.splitlines() if line.startswith("host: "))


# Where an installed command finds the program libraries, relative to the environment's folder.
PROGRAMS = pathlib.PurePosixPath("share/plcfmu/programs")


def stage(fmus: list[pathlib.Path], programs: pathlib.Path, folder: pathlib.Path, target: str) -> None:
    """Assembles the contents of the wheel in a new folder, with the FMUs and the program libraries.

    The FMUs are not added to the sources: a package imported from the checkout would use them instead of target/fmu.
    """
    if folder.exists():
        shutil.rmtree(folder)
    package = folder / "plcfmu"
    shutil.copytree(PYTHON / "plcfmu", package, ignore=shutil.ignore_patterns("__pycache__", "fmus"))
    (package / "fmus").mkdir()
    for fmu in fmus:
        shutil.copyfile(fmu, package / "fmus" / fmu.name)
    shutil.copytree(programs, folder / "data" / "data" / PROGRAMS)
    shutil.copyfile(PYTHON / "README.md", folder / "README.md")
    for license in LICENSES:
        shutil.copyfile(ROOT / license, folder / license)
    (folder / notices.NAME).write_text(notices.notices(target), encoding="utf-8", newline="\n")
    project = (PYTHON / "pyproject.toml").read_text(encoding="utf-8")
    if MANIFEST not in project:
        sys.exit(f"error: {PYTHON / 'pyproject.toml'} lacks the line {MANIFEST}")
    manifest = f"manifest-path = '{ROOT / 'plcfmu' / 'Cargo.toml'}'\ndata = 'data'"
    (folder / "pyproject.toml").write_text(project.replace(MANIFEST, manifest), encoding="utf-8")


def environment(target: str) -> dict[str, str]:
    """The environment variables for maturin, which keep this machine's paths and the build time out of the wheel."""
    cargo_home = os.environ.get("CARGO_HOME") or pathlib.Path.home() / ".cargo"
    flags = [f"--remap-path-prefix={cargo_home}=/cargo", f"--remap-path-prefix={ROOT}=/plcfmu"]
    if target.endswith("-windows-gnu"):
        flags.append("-Clink-arg=-Wl,--no-insert-timestamp")
    variables = {**os.environ, "CARGO_ENCODED_RUSTFLAGS": "\x1f".join(flags)}
    variables.pop("RUSTFLAGS", None)
    # The program libraries, for all platforms, are next to the command instead of inside it.
    variables["PLCFMU_PROGRAMS"] = "beside"
    cache = str(TARGET / "portable" / "zig")
    variables.update(ZIG_GLOBAL_CACHE_DIR=cache, ZIG_LOCAL_CACHE_DIR=cache, CARGO_ZIGBUILD_CACHE_DIR=cache)
    variables["CARGO_ZIGBUILD_PYTHON_PATH"] = sys.executable
    cross_cargo = os.environ.get("PLCFMU_CROSS_CARGO")
    if cross_cargo and target != host():
        variables["CARGO"] = cross_cargo
    return variables


def build(fmus: list[pathlib.Path], programs: pathlib.Path, out: pathlib.Path, target: str) -> pathlib.Path:
    """Builds the wheel in the folder `out` and returns its path."""
    staged = TARGET / "wheel" / "source"
    built = TARGET / "wheel" / "built"
    stage(fmus, programs, staged, target)
    if built.exists():
        shutil.rmtree(built)
    command = [sys.executable, "-m", "maturin", "build", "--target", target, "--out", str(built)]
    own = TARGET / "portable" if target == host() else TARGET / "platforms" / PLATFORMS[target]
    command += ["--target-dir", str(own)]
    if "-linux-" in target:
        # The command then runs with glibc 2.17 or newer, like the FMUs.
        command += ["--zig", "--compatibility", "manylinux2014"]
    done = subprocess.run(command, cwd=staged, env=environment(target))
    if done.returncode != 0:
        sys.exit(f"error: maturin exited with status {done.returncode}")
    (wheel,) = built.glob("*.whl")
    return place(wheel.read_bytes(), out / wheel.name)


def place(content: bytes, path: pathlib.Path) -> pathlib.Path:
    """Writes a file under a temporary name and renames it when complete, so that it is never half written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.part")
    part.write_bytes(content)
    return part.replace(path)


def archive(wheel: pathlib.Path, target: str) -> pathlib.Path:
    """Packs a wheel's command and licences into an archive next to the wheel: .zip for Windows, otherwise .tar.gz."""
    folder = f"plcfmu-{wheel.name.split('-')[1]}-{PLATFORMS[target]}"
    files = {f"{folder}/README.md": (ROOT / "plcfmu" / "README.md").read_bytes()}
    with zipfile.ZipFile(wheel) as packed:
        for name in packed.namelist():
            if ".data/scripts/" in name or ".dist-info/licenses/" in name:
                files[f"{folder}/{pathlib.PurePosixPath(name).name}"] = packed.read(name)
            elif f".data/data/{PROGRAMS}/" in name:
                # In the archive, the libraries are in the folder `programs` next to the command.
                files[f"{folder}/programs/{name.partition(f'{PROGRAMS}/')[2]}"] = packed.read(name)
    buffer = io.BytesIO()
    if "-windows-" in target:
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as zipped:
            for name, content in sorted(files.items()):
                # Without a timestamp, which would make each archive different.
                zipped.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
        return place(buffer.getvalue(), wheel.with_name(f"{folder}.zip"))
    with gzip.GzipFile(fileobj=buffer, mode="wb", mtime=0) as zipped, tarfile.open(fileobj=zipped, mode="w") as packed:
        for name, content in sorted(files.items()):
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            entry.mode = 0o755 if name == f"{folder}/plcfmu" else 0o644
            packed.addfile(entry, io.BytesIO(content))
    return place(buffer.getvalue(), wheel.with_name(f"{folder}.tar.gz"))


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
    parser.add_argument(
        "--target",
        action="append",
        choices=PLATFORMS,
        help="Rust target to build the command for; may be repeated (default: this machine)",
    )
    parser.add_argument("--archive", action="store_true", help="also write an archive with only the command, and its bill of materials")
    options = parser.parse_args()
    fmus = sorted(options.fmus.glob("*.fmu"))
    if not fmus:
        sys.exit(
            f"error: no FMU in {options.fmus}: build them with `cargo xtask fmu`, "
            "or name another folder with --fmus"
        )
    targets = options.target or [host()]
    needed = ["maturin", "ziglang"] if any("-linux-" in target for target in targets) else ["maturin"]
    for module in needed:
        if importlib.util.find_spec(module) is None:
            sys.exit(f"error: {module} is missing from {sys.executable}: install it (pip install {module})")
    programs = options.fmus / "programs"
    for target in targets:
        if not any((programs / PLATFORMS[target]).glob("program.*")):
            sys.exit(
                f"error: no program library in {programs / PLATFORMS[target]}, without which the command cannot build "
                "programs in SCL: `cargo xtask fmu` builds it together with all FMUs"
            )
    for target in targets:
        wheel = build(fmus, programs, options.out.resolve(), target)
        print(wheel)
        if options.archive:
            packed = archive(wheel, target)
            print(packed)
            version = wheel.name.split("-")[1]
            bill = packed.with_name(f"plcfmu-{version}-{PLATFORMS[target]}.cdx.json")
            print(place(notices.bill_of_materials(target, version).encode(), bill))


if __name__ == "__main__":
    main()
