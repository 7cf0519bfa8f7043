"""The guides: every command that they print runs as it is printed, and gives what they show of its output."""

import pathlib
import re
import shutil
import subprocess
import sys

import pytest

import host
import samples

GUIDES = [
    "README.md",
    *(f"docs/{path.name}" for path in sorted((samples.ROOT / "docs").glob("*.md"))),
    *(f"{folder}/README.md" for folder in ("examples", "parameters", "plants", "plcfmu", "plcfmu/python")),
]

# What is not run here, by a pattern of the command, and why.
LEFT_OUT = {
    r"plcfmu tool": "a server that runs until it is stopped: test_tool_server.py",
    r"plcfmu (new|build$)": "compiles a crate: test_packer.py",
    r"plcfmu params s7:": "asks a PLC: test_plc.py",
    r"plcfmu merge": "needs the FMUs of two systems: test_package.py",
    r"plcfmu study .*(/shared/|\$first)": "needs the folder of a cluster: test_study_dask.py",
    r"plcfmu (check|build|run) \S*(machine|line)\.": "a program of the reader's",
}

OVENS = """DATA_BLOCK "OVEN1" "TWO_POINT"
BEGIN
  // as it runs
  SP := 60.0;
  HYS := 4.0;
  CYCLE := T#500MS;
END_DATA_BLOCK
DATA_BLOCK "OVEN2" "TWO_POINT"
BEGIN
  HYS := -1.0;
END_DATA_BLOCK
"""


def prepare(guide, text, folder):
    """The files that a guide speaks of, where a reader has them."""
    for name in ("examples", "plants", "tests"):
        (folder / name).symlink_to(samples.ROOT / name)
    (folder / "target").mkdir()
    (folder / "target/fmu").symlink_to(host.FOLDER)
    for path in host.FOLDER.glob("*.fmu"):
        shutil.copy(path, folder)
    (folder / "damaged.fmu").write_bytes(b"PK")
    if guide == "plcfmu/README.md":
        (folder / "furnace.toml").write_text(samples.block_after(text, "here `furnace.toml`"), "utf-8")
        (folder / "study.toml").write_text(samples.block_after(text, "`study.toml` names the loop"), "utf-8")
        (folder / "plant.awl").write_text(OVENS, "utf-8")
        bad = 'DATA_BLOCK "OVEN1" "TWO_POINT"\n\nBEGIN\n  SP := T#20S;\n  HIS := 4.0;\nEND_DATA_BLOCK\n'
        (folder / "bad.awl").write_text(bad, "utf-8")
    if guide == "parameters/README.md":
        lines = ["DATA_BLOCK DB 41", "FB 41", "BEGIN", "", "", "   TI := S5T#20S;", "   PV_PER := 1,5;", "   LMN_HLM = 90.0;"]
        (folder / "plant.awl").write_text("\n".join([*lines, "END_DATA_BLOCK", ""]), "utf-8")


def is_left_out(sample):
    return any(re.match(pattern, " ".join(sample.words)) for pattern in LEFT_OUT)


def run(guide, sample, command, folder):
    """Runs a sample; what is wrong with it."""
    programs = {"plcfmu": [command], "fmpy": [pathlib.Path(sys.executable).with_name("fmpy")]}
    words = [*programs[sample.words[0]], *sample.words[1:]]
    done = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600)
    said = f"{guide}, {sample}\n{done.stdout}"
    if sample.words[-2:] == ["--out", "plant.json"]:
        # The reader tunes a loop in it.
        tuned = (folder / "plant.json").read_text("utf-8").replace('"HYS": 4.0', '"HYS": 2.5')
        (folder / "plant.json").write_text(tuned, "utf-8")
    # A comparison that finds something says so by its exit code, too.
    if (done.returncode != 0) != (sample.fails or "--diff" in sample.words):
        return said
    missing = samples.shown_in(sample.output, done.stdout)
    return None if missing is None else f"{said}\n--- has no line such as: {missing}"


@pytest.mark.parametrize("guide", GUIDES)
def test_every_command_of_a_guide_runs_as_printed_and_says_what_the_guide_shows(guide, command, tmp_path):
    text = (samples.ROOT / guide).read_text("utf-8")
    prepare(guide, text, tmp_path)
    wrong = [run(guide, one, command, tmp_path) for one in samples.commands(text) if not is_left_out(one)]
    assert not any(wrong), "\n\n".join(filter(None, wrong))


@pytest.mark.parametrize("guide", GUIDES)
def test_every_file_of_the_repository_that_a_command_names_is_there(guide):
    for sample in samples.commands((samples.ROOT / guide).read_text("utf-8")):
        for word in sample.words:
            if re.match(r"(examples|plants|tests)/[\w./-]+\.\w+$", word):
                assert (samples.ROOT / word).is_file(), sample


def test_the_runner_finds_commands_with_their_lines_and_output():
    text = "A\n\n    $ plcfmu run A.fmu \\\n        --stop 2   # short\n    last row:\n      A.X  ...\n\n```\nplcfmu info B.fmu\n```\n"
    first, second = samples.commands(text)
    assert first.words == ["plcfmu", "run", "A.fmu", "--stop", "2"] and first.output == ["last row:", "  A.X  ..."]
    assert second.words == ["plcfmu", "info", "B.fmu"] and second.output == []
    assert samples.shown_in(first.output, "x\nlast row:\n  A.X  5\n") is None
    assert samples.shown_in(first.output, "last row:\n  B.X  5\n") == "  A.X  ..."


def test_every_command_that_is_left_out_is_printed_somewhere():
    printed = [sample for guide in GUIDES for sample in samples.commands((samples.ROOT / guide).read_text("utf-8"))]
    for pattern in LEFT_OUT:
        assert any(re.match(pattern, " ".join(sample.words)) for sample in printed), pattern


def test_the_examples_plant_is_tuned_by_its_json_and_recorded_as_its_csv_says(command, tmp_path):
    plant = samples.ROOT / "examples/plant"
    compared = [command, "params", plant / "plant.awl", "--diff", plant / "tuned.json"]
    done = subprocess.run(compared, capture_output=True, text=True)
    assert [line.split()[:4] for line in done.stdout.splitlines()[1:]] == [
        ["TIC101", "GAIN", "1.4", "0.7"],
        ["TIC101", "TI", "80.0", "130.0"],
    ]
    given = [command, "run", plant / "zone.toml", "--fmus", host.FOLDER, "--out", tmp_path / "recorded.csv"]
    subprocess.run([*given, "--set", "TIC101.GAIN=0.7", "--set", "TIC101.TI=130"], check=True, capture_output=True)
    assert (tmp_path / "recorded.csv").read_bytes() == (plant / "recorded.csv").read_bytes()
