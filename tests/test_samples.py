"""Every sample that the guides print runs as it is printed, and gives what they show of its output.

How a guide says what a sample is, and which are not run, stands in samples.py."""

import csv
import os
import pathlib
import re
import subprocess
import sys

import pytest

import host
import samples

ROOT = samples.ROOT
PATTERNS = ("*.md", "docs/*.md", "*/README.md", "plcfmu/python/README.md", "blocks/src/*/*/page.md")
GUIDES = sorted(str(path.relative_to(ROOT)) for pattern in PATTERNS for path in ROOT.glob(pattern))


def steps(guide):
    return samples.steps((ROOT / guide).read_text("utf-8"))


@pytest.fixture
def reader(tmp_path, command):
    """A folder with the repository's files in it, as a reader has it, and the FMUs; and the variables of its shell."""
    folder = tmp_path / "reader"
    folder.mkdir()
    for path in ROOT.iterdir():
        if path.is_dir() and path.name not in ("target", ".git"):
            (folder / path.name).symlink_to(path)
    (folder / "target").mkdir()
    (folder / "target/fmu").symlink_to(host.FOLDER)
    for path in host.FOLDER.glob("*.fmu"):
        (folder / path.name).symlink_to(path)
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "plcfmu").symlink_to(command)
    (programs / "python").symlink_to(sys.executable)
    paths = [programs, pathlib.Path(sys.executable).parent, os.environ["PATH"]]
    return folder, host.environment() | {"PATH": os.pathsep.join(map(str, paths)), "HOME": str(folder)}


def run(step, folder, shell):
    """Runs a step; what is wrong with it, or nothing."""
    path = folder / step.name
    if step.kind == "unknown":
        return "neither a command nor a program: a comment says what it is (samples.py)"
    if step.kind == "left out":
        return ""
    if step.kind == "from":
        given = [line.strip() for line in (ROOT / step.name).read_text("utf-8").splitlines()]
        absent = [line for line in step.text.splitlines() if line.strip() not in given]
        return f"{step.name} has no line {absent[0]!r}" if absent else ""
    if step.kind in ("file", "add"):
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a" if step.kind == "add" else "w", encoding="utf-8") as file:
            file.write(step.text)
        return ""
    given = ["bash", "-c", step.text]
    if step.kind == "python":
        # As a file, which the processes of a study import.
        (folder / "sample.py").write_text(step.text, "utf-8")
        given = [sys.executable, "sample.py"]
    done = subprocess.run(given, cwd=folder, env=shell, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    fails = any(line.startswith("error: ") for line in step.output)
    # Files that differ are no failure of the comparison.
    allowed = {0, 1} if "--diff" in step.text else {0}
    if fails == (done.returncode in allowed):
        return f"exit code {done.returncode}\n{done.stdout}"
    absent = samples.missing(step.output, done.stdout)
    return "" if absent is None else f"has no line such as {absent!r}:\n{done.stdout}"


@pytest.mark.parametrize("guide", GUIDES)
def test_every_sample_of_a_guide_runs_as_printed_and_says_what_the_guide_shows(guide, reader):
    wrong = [(step, run(step, *reader)) for step in steps(guide)]
    assert not any(what for _, what in wrong), "\n\n".join(
        f"{guide}:{step.line}: {step.text.strip()}\n--- {what}" for step, what in wrong if what
    )
    if guide == "README.md":
        the_readme_holds(*reader)


def the_readme_holds(folder, shell):
    """What README.md says of what its commands write."""
    text = (ROOT / "README.md").read_text("utf-8")
    assert "from 20 to 60 °C, settled after 133 s" in text
    (loop,) = (step for step in steps("README.md") if step.text.startswith("plcfmu run"))

    def recorded(command):
        assert not run(loop._replace(text=f"{command} --out=loop.csv"), folder, shell)
        return [float(row["CONT_C.PV"]) for row in csv.DictReader((folder / "loop.csv").open())]

    assert "with them this loop oscillates between 55 and 66 °C" in text
    swings = recorded(re.sub(r"--set CONT_C\.(GAIN|TI)=\S+ ", "", loop.text).replace("--stop 600", "--stop 3600"))[1800:]
    assert (round(min(swings)), round(max(swings))) == (55, 66)
    temperatures = recorded(loop.text)
    # Within 2 % of the step of 40 K, which is made at 60 s.
    is_off = [abs(temperature - 60.0) > 0.8 for temperature in temperatures]
    assert max(second for second, off in enumerate(is_off) if off) + 1 - 60 == 133
    assert max(temperatures) < 60.4 and temperatures[-1] > 59.9
    assert (folder / "loop.png").read_bytes()[:4] == b"\x89PNG"
    presets = {path.stem for path in (folder / "presets").glob("*.fmu")}
    assert presets == {"TIC101", "LIC201", "FIC301", "SIC401", "TIC501"}
    given = [folder.parent / "bin/plcfmu", "params", "tuned.awl", "--diff", "examples/plant/tuned.json"]
    compared = subprocess.run(given, cwd=folder, capture_output=True, text=True)
    assert compared.stdout == "no differences\n"
    assert (folder / "TankFilling.fmu").is_file()


def test_what_is_not_run_says_why():
    left_out = [(guide, step) for guide in GUIDES for step in steps(guide) if step.kind == "left out"]
    for guide, step in left_out:
        print(f"{guide}:{step.line}: {step.text.splitlines()[0].strip()}: {step.name}")
    # A reason is a sentence; it may name the test that does it instead.
    for guide, step in left_out:
        assert len(step.name.split()) >= 2, (guide, step)
        for test in re.findall(r"test_\w+\.py", step.name):
            assert (ROOT / "tests" / test).is_file(), (guide, step)


def test_the_runner_knows_commands_programs_files_and_what_is_not_run():
    text = """
<!-- file plant.toml
a = 1
-->

    $ plcfmu run A.fmu \\
        --stop 2   # short
    last row:
      A.X  ...

```sh
plcfmu info B.fmu
cargo test
```

<!-- not run: asks a PLC -->

    plcfmu params s7://1.2.3.4

```toml
[what]
```

<!-- before
import os
-->
```python
os.getcwd()
```
"""
    file, first, second, third, left_out, unknown, python = samples.steps(text)
    assert (file.kind, file.name, file.text) == ("file", "plant.toml", "a = 1\n")
    assert first.text == "plcfmu run A.fmu \\\n    --stop 2   # short" and first.output == ["last row:", "  A.X  ..."]
    assert second.text == "plcfmu info B.fmu" and third.text == "cargo test" and third.output == []
    assert (left_out.kind, left_out.name) == ("left out", "asks a PLC")
    assert unknown.kind == "unknown" and python.text == "import os\nos.getcwd()\n"
    assert samples.missing(first.output, "x\nlast row:\n  A.X  5\n") is None
    assert samples.missing(first.output, "last row:\n  B.X  5\n") == "  A.X  ..."


def test_the_plant_of_the_examples_is_tuned_by_its_json_and_recorded_as_its_csv_says(command, tmp_path):
    plant = ROOT / "examples/plant"
    compared = [command, "params", plant / "plant.awl", "--diff", plant / "tuned.json"]
    done = subprocess.run(compared, capture_output=True, text=True)
    assert [line.split()[:4] for line in done.stdout.splitlines()[1:]] == [
        ["TIC101", "GAIN", "1.4", "0.7"],
        ["TIC101", "TI", "80.0", "130.0"],
    ]
    given = [command, "run", plant / "zone.toml", "--fmus", host.FOLDER, "--out", tmp_path / "recorded.csv"]
    subprocess.run([*given, "--set", "TIC101.GAIN=0.7", "--set", "TIC101.TI=130"], check=True, capture_output=True)
    assert (tmp_path / "recorded.csv").read_bytes() == (plant / "recorded.csv").read_bytes()
