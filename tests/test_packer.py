"""`cargo xtask fmu` in another folder: the same sources give the same bytes; whenever the packer is killed, the FMU that
was there is still there and whole; and a block of one's own is made as the READMEs say. `plcfmu new` and `plcfmu build`
outside the repository."""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

import fmpy
import markdown_it
import pytest
from fmpy.validation import validate_fmu

import host

ROOT = pathlib.Path(__file__).parents[1]
NAME = "HLG"
LAW = "blocks/src/abb/hlg/mod.rs"


class Clone:
    """A copy of the sources with a target folder of its own, where one FMU is packed."""

    def __init__(self, folder, packer):
        self.folder = folder
        self.packer = packer
        self.fmus = folder / "target" / "fmu"
        self.fmu = self.fmus / f"{NAME}.fmu"
        without = shutil.ignore_patterns("target", "corpus", "__pycache__", ".*_cache", ".git")
        shutil.copytree(ROOT, folder, ignore=without)
        (folder / "target").mkdir()
        (folder / "target" / "venv").symlink_to(sys.prefix)

    def pack(self, *arguments, **options):
        variables = {**os.environ, "CARGO_TARGET_DIR": str(self.folder / "target"), "TZ": "Asia/Tokyo"}
        command = [self.packer, "fmu", *(arguments or [NAME])]
        return subprocess.run(command, cwd=self.folder, env=variables, capture_output=True, text=True, **options)

    def change_the_law(self):
        law = self.folder / LAW
        text = law.read_text(encoding="utf-8")
        assert "Ramp function generator" in text
        law.write_text(text.replace("Ramp function generator", "Ramp-function generator"), encoding="utf-8")

    def left(self):
        """Everything beside the FMU and what stands there for the packer."""
        return sorted(path.name for path in self.fmus.iterdir() if path.name not in (self.fmu.name, ".lock", "test-only"))


@pytest.fixture(scope="module")
def clone(tmp_path_factory, packer):
    if sys.platform == "win32":
        pytest.skip("takes links and the limits of a process, as Linux and macOS have them")
    clone = Clone(tmp_path_factory.mktemp("another user's") / "a longer path to plcfmu", packer)
    packed = clone.pack()
    assert packed.returncode == 0, packed.stderr
    return clone


def test_the_same_sources_give_the_same_fmu_in_another_folder(clone, open_fmu):
    """From the source to the archive: compiled, linked, run for the reference results, drawn and packed anew."""
    assert clone.fmu.read_bytes() == open_fmu(NAME).path.read_bytes()


def test_a_packer_killed_at_any_moment_leaves_the_old_fmu_whole(clone):
    """The system ends the packer where a file passes a length: within the archive or, longer than that, within the
    library that it unpacks to check the archive. Nothing that runs later can mend what is there then."""
    import resource

    old = clone.fmu.read_bytes()
    clone.change_the_law()
    assert clone.pack().returncode == 0
    new = clone.fmu.read_bytes()
    assert new != old
    built = (clone.folder / "target").rglob(f"library/*{fmpy.sharedLibraryExtension}")
    library = max(path.stat().st_size for path in built)
    assert library > 1.2 * len(new)

    clone.fmu.write_bytes(old)
    lengths = [len(new) * part // 8 for part in range(2, 8)] + [len(new) - 1, len(new) + 1, library - 1]
    for length in lengths:

        def limited():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_FSIZE, (length, length))

        killed = clone.pack(preexec_fn=limited)
        assert killed.returncode == -signal.SIGXFSZ, f"{length}: {killed.stderr}"
        assert clone.left() != [], f"{length}: killed before it wrote anything"
        assert clone.fmu.read_bytes() == old, f"killed at {length} bytes"

    assert clone.pack().returncode == 0
    assert clone.fmu.read_bytes() == new
    assert clone.left() == []
    assert fmpy.read_model_description(str(clone.fmu)).modelName == NAME


def test_a_source_that_does_not_compile_leaves_the_old_fmu(clone):
    old = clone.fmu.read_bytes()
    law = clone.folder / LAW
    good = law.read_text(encoding="utf-8")
    law.write_text(good + "fn broken(", encoding="utf-8")
    failed = clone.pack()
    law.write_text(good, encoding="utf-8")
    assert failed.returncode == 1
    assert "mod.rs" in failed.stderr
    assert clone.fmu.read_bytes() == old
    assert clone.left() == []


def test_an_unknown_fmu_is_refused_before_anything_is_made(packer, tmp_path):
    target = tmp_path / "target"
    variables = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    command = [packer, "fmu", "NOSUCH"]
    refused = subprocess.run(command, cwd=ROOT, env=variables, capture_output=True, text=True)
    assert refused.returncode == 1
    assert refused.stderr.startswith("error: no FMU NOSUCH; available packages: cont_c, cont_s, ")
    assert not target.exists()


def listing(readme, heading):
    """The Rust code in a section of a README."""
    (section,) = re.findall(rf"^## {heading}$(.*?)(?=^## |\Z)", readme.read_text(encoding="utf-8"), re.M | re.S)
    (code,) = re.findall(r"^```rust$(.*?)^```$", section, re.M | re.S)
    return code


def test_a_block_of_ones_own_is_made_as_the_readme_says(clone):
    """Copy the folder, change the name, add it to the workspace, write the block, pack it."""
    package, name = "pump", "TWO_POINT"
    folder = clone.folder / "examples" / package
    shutil.copytree(clone.folder / "examples" / "my_block", folder)
    manifest = folder / "Cargo.toml"
    manifest.write_text(manifest.read_text(encoding="utf-8").replace('"my_block"', f'"{package}"'), encoding="utf-8")
    (folder / "src" / "lib.rs").write_text(listing(ROOT / "examples" / "README.md", "Your own block"), encoding="utf-8")
    workspace = clone.folder / "Cargo.toml"
    lists = workspace.read_text(encoding="utf-8")
    added = lists.replace('    "examples/my_block",\n', f'    "examples/my_block",\n    "examples/{package}",\n')
    assert added != lists
    workspace.write_text(added, encoding="utf-8")

    packed = clone.pack("-p", package)
    assert packed.returncode == 0, packed.stderr
    fmu = clone.fmus / f"{name}.fmu"
    assert fmpy.read_model_description(str(fmu)).modelName == name
    fmu.unlink()


# The listings of blocks/README.md by their first lines.
SUMP = {
    "//! SUMP: switches the pump of a sump.": "blocks/src/acme/sump/mod.rs",
    "//! The runs that the documentation of SUMP shows.": "blocks/src/acme/sump/responses.rs",
    "# Purpose": "blocks/src/acme/sump/page.md",
    "# What SUMP does, clause by clause. How to read it: blocks/README.md, \"Tapes\".": "blocks/src/acme/sump/clauses.txt",
    "//! Function blocks of ACME.": "blocks/src/acme/mod.rs",
    "//! SUMP of ACME as an FMU.": "fmu/libraries/sump/src/lib.rs",
    "class SUMP(Block):": "tests/oracle.py",
}


def test_a_block_of_a_vendor_is_made_as_the_readme_of_blocks_says(clone, command):
    tokens = markdown_it.MarkdownIt("commonmark").parse((ROOT / "blocks/README.md").read_text("utf-8"))
    listings = {token.content.partition("\n")[0]: token.content for token in tokens if token.type == "fence"}
    library = clone.folder / "fmu/libraries"
    shutil.copytree(library / "hlg", library / "sump")
    manifest = library / "sump/Cargo.toml"
    manifest.write_text(manifest.read_text("utf-8").replace('"hlg"', '"sump"'), "utf-8")
    for first, path in SUMP.items():
        file = clone.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        text = listings[first]
        if file.suffix == ".py":
            above, below = file.read_text("utf-8").split("# All of them by name.")
            text = f"{above}{text}\n\n# All of them by name.{below}"
        file.write_text(text, "utf-8")
    blocks = clone.folder / "blocks/src/lib.rs"
    text = blocks.read_text("utf-8")
    for line in ("mod abb;", "pub use abb::*;", "abb::for_each_block(what);"):
        text = text.replace(line, f"{line}\n{line.replace('abb', 'acme')}")
    blocks.write_text(text, "utf-8")

    # The tables, and the tape on the law.
    variables = {**os.environ, "CARGO_TARGET_DIR": str(clone.folder / "target"), "CARGO_NET_OFFLINE": "true"}
    tested = subprocess.run(["cargo", "test", "-p", "blocks"], cwd=clone.folder, env=variables, capture_output=True, text=True)
    assert tested.returncode == 0, tested.stdout + tested.stderr
    newer = clone.folder / "newer"
    for arguments in ([], ["--fmi", "3", "--out", str(newer)]):
        packed = clone.pack("SUMP", *arguments)
        assert packed.returncode == 0, packed.stderr
    # The tape on the FMU and on the second version, and random runs of both.
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "SUMP", "test_tapes.py", "test_random.py"]
    # The command is that of this folder: building it once more would take minutes.
    variables = {**os.environ, "PLCFMU_FMUS": str(clone.fmus), "PLCFMU_FMI3": str(newer), "PLCFMU_COMMAND": command}
    tested = subprocess.run(tests, cwd=clone.folder / "tests", env=variables, capture_output=True, text=True)
    assert tested.returncode == 0, tested.stdout
    assert int(re.search(r"^(\d+) passed", tested.stdout, re.M)[1]) > 4
    (clone.fmus / "SUMP.fmu").unlink()


@pytest.fixture(scope="module")
def plcfmu(command):
    """Runs the command `plcfmu`, without a connection and without a terminal."""

    def run(*arguments, cwd, **variables):
        variables = {**os.environ, "CARGO_NET_OFFLINE": "true", **variables}
        variables.pop("CARGO_TARGET_DIR", None)
        return subprocess.run([command, *arguments], cwd=cwd, env=variables, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True)

    return run


@pytest.fixture(scope="module")
def new_crate(plcfmu, tmp_path_factory):
    """A crate that was made outside the repository."""
    folder = tmp_path_factory.mktemp("somewhere else")
    made = plcfmu("new", "my-pump", cwd=folder)
    assert made.returncode == 0, made.stderr
    return folder / "my-pump"


@pytest.fixture(scope="module")
def new_fmu(plcfmu, new_crate):
    packed = plcfmu("build", cwd=new_crate)
    assert packed.returncode == 0, packed.stderr
    return new_crate / "target" / "fmu" / "MY_PUMP.fmu"


def test_a_new_crate_is_built_and_packed_as_it_stands(new_fmu):
    assert validate_fmu(str(new_fmu)) == []
    description = fmpy.read_model_description(str(new_fmu))
    assert description.modelName == "MY_PUMP"
    assert description.license is None  # the user has named none


def test_the_fmu_of_a_new_crate_passes_the_conformance_tests(new_fmu, plcfmu, new_crate, tmp_path):
    packed = plcfmu("build", "--fmi", "3", "--out", str(tmp_path), cwd=new_crate)
    assert packed.returncode == 0, packed.stderr
    files = ["test_conformance.py", "test_fmu_state.py", "test_model_description.py", "test_package.py", "test_time.py"]
    # The tests of one FMU each; the others are about certain FMUs of the repository.
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "MY_PUMP", *files]
    variables = {**os.environ, "PLCFMU_FMUS": str(new_fmu.parent), "PLCFMU_FMI3": str(tmp_path)}
    tested = subprocess.run(command, cwd=ROOT / "tests", env=variables, capture_output=True, text=True)
    assert tested.returncode == 0, tested.stdout
    passed = re.search(r"^(\d+) passed", tested.stdout, re.M)
    assert int(passed.group(1)) > 300


def test_the_unit_tests_of_a_new_crate_pass(new_crate, new_fmu):
    variables = {name: value for name, value in os.environ.items() if name != "CARGO_TARGET_DIR"}
    tested = subprocess.run(["cargo", "test", "--offline"], cwd=new_crate, env=variables, capture_output=True, text=True)
    assert tested.returncode == 0, tested.stderr
    assert "test result: ok. 4 passed" in tested.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a C library of another version on each system")
def test_without_zig_the_packer_says_which_glibc_the_fmu_needs(plcfmu, new_crate, tmp_path):
    python = tmp_path / "python3"
    python.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    python.chmod(0o755)
    folders = [folder for folder in os.get_exec_path() if not pathlib.Path(folder, "zig").exists()]
    packed = plcfmu("build", "--out", str(tmp_path), cwd=new_crate, VIRTUAL_ENV="",
                    PATH=os.pathsep.join([str(tmp_path), *folders]))
    assert packed.returncode == 0, packed.stderr
    note = packed.stderr.splitlines()[-1]
    assert re.fullmatch(r"note: linked with this machine's C library: the FMUs need glibc 2\.\d+ or newer; for 2\.17, install "
                        r"zig and cargo-zigbuild \(pip install ziglang cargo-zigbuild\)", note)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["MY_PUMP.fmu", "python3"]


def test_a_folder_that_exists_is_not_touched(plcfmu, tmp_path):
    folder = tmp_path / "valve"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine", encoding="utf-8")
    refused = plcfmu("new", "valve", cwd=tmp_path)
    assert refused.returncode == 1
    assert refused.stderr == "error: valve already exists: choose another name, or another folder with --out\n"
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]


def test_a_folder_without_a_package_is_told_in_one_sentence(plcfmu, tmp_path):
    refused = plcfmu("build", cwd=tmp_path)
    assert refused.returncode == 1
    assert refused.stderr.startswith("error: cargo cannot read the package in this folder: could not find `Cargo.toml` in ")
    assert refused.stderr.count("\n") == 1
