"""`cargo xtask fmu` in another folder: the same sources give the same bytes, and whenever the packer is killed, the
FMU that was there is still there and whole."""

import json
import os
import pathlib
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

    def pack(self, **options):
        variables = {**os.environ, "CARGO_TARGET_DIR": str(self.folder / "target"), "TZ": "Asia/Tokyo"}
        command = [self.packer, "fmu", NAME]
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
