"""`cargo xtask fmu` in another folder: the same sources give the same bytes; whenever the packer is killed, the FMU that
was there is still there and whole; and a block of one's own is made as the READMEs say."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

import fmpy
import pytest

import host

ROOT = pathlib.Path(__file__).parents[1]
NAME = "HLG"
LAW = "blocks/src/hlg.rs"


@pytest.fixture(scope="module")
def packer():
    """The program behind `cargo xtask`."""
    build = ["cargo", "build", "--quiet", "--package", "xtask", "--message-format=json-render-diagnostics"]
    messages = subprocess.run(build, stdout=subprocess.PIPE, text=True, check=True, cwd=ROOT).stdout
    executables = [json.loads(line).get("executable") for line in messages.splitlines()]
    (executable,) = filter(None, executables)
    return executable


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
    library = max(path.stat().st_size for path in (clone.folder / "target" / "portable").rglob("release/*.so"))
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
    assert "hlg.rs" in failed.stderr
    assert clone.fmu.read_bytes() == old
    assert clone.left() == []


def listing(readme, heading):
    """The Rust code in a section of a README."""
    (section,) = re.findall(rf"^## {heading}$(.*?)(?=^## |\Z)", readme.read_text(encoding="utf-8"), re.M | re.S)
    (code,) = re.findall(r"^```rust$(.*?)^```$", section, re.M | re.S)
    return code


@pytest.mark.parametrize(
    "readme, heading, package, name",
    [
        ("README.md", "Add a block", "switch", "MY_BLOCK"),
        ("examples/README.md", "Your own block", "pump", "TWO_POINT"),
    ],
)
def test_a_block_of_ones_own_is_made_as_the_readmes_say(clone, readme, heading, package, name):
    """Copy the folder, change the name, add it to the workspace, write the block, pack it."""
    folder = clone.folder / "examples" / package
    shutil.copytree(clone.folder / "examples" / "my_block", folder)
    manifest = folder / "Cargo.toml"
    manifest.write_text(manifest.read_text(encoding="utf-8").replace('"my_block"', f'"{package}"'), encoding="utf-8")
    (folder / "src" / "lib.rs").write_text(listing(ROOT / readme, heading), encoding="utf-8")
    workspace = clone.folder / "Cargo.toml"
    lists = workspace.read_text(encoding="utf-8")
    added = lists.replace('    "examples/my_block",\n', f'    "examples/my_block",\n    "examples/{package}",\n')
    assert added.count(f'"examples/{package}"') == 2  # members and default-members
    workspace.write_text(added, encoding="utf-8")

    packed = clone.pack("-p", package)
    assert packed.returncode == 0, packed.stderr
    fmu = clone.fmus / f"{name}.fmu"
    assert fmpy.read_model_description(str(fmu)).modelName == name
    fmu.unlink()
