"""The command as people and scripts call it: what is printed as JSON, return codes, rows that are chosen, signals from a file,
completions and manual pages."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

import host
from files import rows

LOOP = ["--connect=CONT_C.LMN=HEATER.POWER", "--connect=HEATER.TEMP=CONT_C.PV_IN"]
STEP = ["--set=CONT_C.MAN_ON=false", "--set=CONT_C.GAIN=0.7", "--set=CONT_C.TI=130", "--set=CONT_C.SP_INT=60"]
ROOT = Path(__file__).parent.parent
FMUS = [str(host.FOLDER / f"{name}.fmu") for name in ("CONT_C", "HEATER")]


@pytest.fixture
def plcfmu(command, tmp_path):
    def plcfmu(*arguments):
        return subprocess.run([command, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True)

    return plcfmu


def schema(name):
    """What the documentation says that a command prints."""
    whole = json.loads((ROOT / "plcfmu/json.schema.json").read_text())
    return {"$ref": f"#/$defs/{name}", "$defs": whole["$defs"]}


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("info", ["info", *FMUS]),
        ("info", ["info", str(host.FOLDER / "PROCESS.fmu"), "preset.fmu"]),
        ("check", ["check", "--run", FMUS[0], "bad.fmu"]),
        ("check_program", ["check", "bad.scl"]),
        ("check_program", ["check", str(ROOT / "examples/programs/tank.scl")]),
        ("test", ["test", str(ROOT / "examples/programs/tank.toml")]),
        ("run", ["run", *FMUS, *LOOP, *STEP, "--set=CONT_C.SP_INT=80@20", "--step=1", "--stop=40", "--out=o.csv"]),
        ("run", ["run", FMUS[1], "--stop=2"]),
        ("params", ["params", "loops.awl"]),
        ("params_diff", ["params", "loops.awl", "--diff", "other.awl"]),
        ("preset", ["preset", "loops.awl", "--fmus", FMUS[0]]),
        ("gains", ["gains", "--ideal", "Kp=2,Ti=20"]),
        ("gains", ["gains", "--from", "GAIN=2,TI=20", "--to", "codesys"]),
    ],
)
def test_what_is_printed_as_json_is_as_documented(plcfmu, tmp_path, name, given):
    (tmp_path / "bad.fmu").write_bytes(b"no archive")
    (tmp_path / "bad.scl").write_text('FUNCTION_BLOCK "B"\nBEGIN\n"Lamp" := 5 +;\nEND_FUNCTION_BLOCK\n')
    block = 'DATA_BLOCK "{}" CONT_C BEGIN GAIN := {}; END_DATA_BLOCK\n'
    (tmp_path / "loops.awl").write_text(block.format("TIC1", "2.0") + block.format("TIC2", "2.0"))
    (tmp_path / "other.awl").write_text(block.format("TIC1", "2.5"))
    assert plcfmu("preset", FMUS[0], "--set=GAIN=3", "--out=preset.fmu").returncode == 0
    told = json.loads(plcfmu(*given, "--json").stdout)
    assert told
    jsonschema.validate(told, schema(name))


def test_a_schema_is_no_empty_one():
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate([{"file": "a.fmu", "errors": []}], schema("check"))


def test_a_description_comes_from_standard_input(plcfmu, command, tmp_path):
    loop = (ROOT / "plants/loops/furnace.toml").read_text()
    (tmp_path / "furnace.toml").write_text(loop)
    given = [f"--fmus={host.FOLDER}", "--stop=20", "--out=-"]
    piped = subprocess.run([command, "run", "-", *given], cwd=tmp_path, input=loop, capture_output=True, text=True)
    assert piped.returncode == 0 and len(rows(piped.stdout)) == 21
    assert piped.stdout == plcfmu("run", "furnace.toml", *given).stdout
    wrong = subprocess.run([command, "run", "-"], cwd=tmp_path, input="[fmus]\nA = 1\n", capture_output=True, text=True)
    assert wrong.returncode == 3 and wrong.stderr.startswith("error: stdin:2:5: ")


def test_quiet_leaves_results_and_errors(plcfmu):
    preset = ["preset", FMUS[0], "--set=GAIN=0", "--out=a.fmu"]
    assert plcfmu(*preset).stderr.startswith("warning: a: MAN_ON is TRUE")
    for quiet in ("-q", "--quiet"):
        done = plcfmu(*preset, quiet)
        assert (done.stderr, done.stdout[:9]) == ("", "a  CONT_C")
    assert plcfmu("-q", "params", "missing.awl").stderr.startswith("error: missing.awl cannot be read")


@pytest.mark.parametrize(
    ("out", "given"),
    [
        ("all.json", ["params", "loops.awl", "--out=all.json"]),
        ("prove.scl", ["prove", "CONT_C", "--calls=10", "--out=prove.scl"]),
        ("fast.fmu", ["preset", FMUS[0], "--set=GAIN=3", "--out=fast.fmu"]),
        ("loop.ssp", ["ssp", *FMUS, *LOOP, "--out=loop.ssp"]),
        ("one.fmu", ["merge", FMUS[1], FMUS[1], "--out=one.fmu"]),
        ("o.csv", ["run", FMUS[1], "--stop=2", "--out=o.csv"]),
        ("o.svg", ["run", FMUS[1], "--stop=2", "--plot=o.svg"]),
        ("o.toml", ["run", FMUS[1], "--stop=2", "--save=o.toml"]),
    ],
    ids=lambda given: given if isinstance(given, str) else given[0],
)
def test_a_file_that_takes_the_place_of_another_is_noted(plcfmu, tmp_path, out, given):
    (tmp_path / "loops.awl").write_text('DATA_BLOCK "TIC1" CONT_C BEGIN GAIN := 2.0; END_DATA_BLOCK\n')
    note = f"note: {out} was replaced\n"
    first = plcfmu(*given)
    assert first.returncode == 0 and "replaced" not in first.stderr, first.stderr
    # Whatever the file had, such as comments.
    (tmp_path / out).write_text("by hand")
    assert note in plcfmu(*given).stderr
    assert (tmp_path / out).read_bytes() != b"by hand"
    assert note not in plcfmu(*given, "--quiet").stderr


def test_colour_is_for_terminals_and_for_whoever_asks(plcfmu):
    assert "\x1b" not in plcfmu("params", "missing.awl").stderr
    assert plcfmu("params", "missing.awl", "--color=always").stderr.startswith("\x1b[1m\x1b[31merror:\x1b[0m missing.awl ")


@pytest.mark.parametrize("name", ["run", "study", "tune-study", "build", "preset", "tool"])
def test_help_is_wrapped_for_the_terminal_and_not_before(command, name):
    given = {"capture_output": True, "text": True, "env": {**os.environ, "COLUMNS": "70"}}
    lines = subprocess.run([command, name, "--help"], **given).stdout.splitlines()
    assert max(map(len, lines)) <= 100
    for line, next_line in zip(lines, lines[1:]):
        # A sentence that goes on, and no sample.
        if re.search(r"[a-z,] \w+,? \w+$", line) and re.match(r" *[a-z]+ [a-z]+", next_line) and "plcfmu" not in next_line + line:
            assert len(line) + 1 + len(next_line.split()[0]) > 65, (line, next_line)


def test_without_cargo_the_remedy_is_said(command, tmp_path):
    (tmp_path / "Cargo.toml").write_text("[package]\nname = 'a'\n")
    done = subprocess.run([command, "build"], cwd=tmp_path, env={"PATH": str(tmp_path)}, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.endswith(": cargo was not found: to build FMUs from crates, install Rust (https://rustup.rs)\n")


@pytest.mark.skipif(sys.platform != "linux", reason="wait4 tells the memory of a process in kB on Linux")
def test_a_recording_does_not_fill_the_memory(command, tmp_path):
    def peak(steps):
        given = ["run", FMUS[0], f"--stop={steps}", "--out=o.csv", "--quiet"]
        with subprocess.Popen([command, *given], cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = status
        assert status == 0
        return usage.ru_maxrss

    peaks = peak(1_000), peak(200_000)
    columns = len((tmp_path / "o.csv").open().readline().split(",")) - 1
    # In memory, the values alone would take 8 bytes each.
    assert columns * 200_000 * 8 / 1024 > 14_000
    assert peaks[1] - peaks[0] < 6_000, peaks


def test_one_variable_is_one(plcfmu):
    done = plcfmu("run", FMUS[1], "--step=1", "--stop=4", "--record=HEATER.TEMP", "--out=o.csv")
    assert "o.csv: 5 rows with the time and 1 variable\n" in done.stdout


def test_a_check_is_a_list_of_verdicts(plcfmu, tmp_path):
    (tmp_path / "bad.fmu").write_bytes(b"no archive")
    done = plcfmu("check", "--run", "--json", FMUS[0], "bad.fmu")
    good, bad = json.loads(done.stdout)
    assert done.returncode == 1
    assert (good["errors"], good["remarks"], good["file"]) == ([], [], FMUS[0])
    assert good["run"].endswith("all variables read, freed") and good["libraries"]
    assert bad["what"] is None and bad["errors"] == ["it is not a ZIP file, or its end is missing"]


def test_a_good_fmu_is_ok(plcfmu):
    done = plcfmu("check", FMUS[0])
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "  ok")


def test_the_return_code_says_what_is_wrong(plcfmu):
    assert plcfmu("run", FMUS[0], "--stop=2").returncode == 0
    assert plcfmu("run", FMUS[0], "--set=CONT_C.GIAN=2").returncode == 1
    assert plcfmu("run", FMUS[0], "--setp=1").returncode == 2
    assert plcfmu("run", "missing.fmu").returncode == 3
    assert plcfmu("params", "missing.awl").returncode == 3
    assert plcfmu("check", "missing.fmu").returncode == 3


def test_a_negative_number_is_a_value_and_no_option(plcfmu):
    done = plcfmu("run", FMUS[0], "--step", "-1", "--stop", "2")
    assert "the communication step is -1.0 s: it must be positive and finite" in done.stderr


def test_a_run_tells_the_figures_of_its_loop(plcfmu):
    given = ["run", *FMUS, *LOOP, *STEP, "--set=CONT_C.SP_INT=80@600", "--step=1", "--stop=1800"]
    lines = plcfmu(*given).stdout.splitlines()
    heads = [line.split(", ")[0] for line in lines[1:] if not line.startswith(" ")]
    assert heads == ["step at the start", "setpoint step at 600 s"]
    assert [line.split()[0] for line in lines[2:6]] == ["Rise", "Overshoot", "Settling", "IAE"]
    assert lines[5].endswith(" K·s") and lines[6].endswith(" K²·s")
    told = json.loads(plcfmu(*given, "--json").stdout)
    assert (told["steps"], told["step"], told["stop"]) == (1800, 1.0, 1800.0)
    figures = {figure["key"]: figure for figure in told["figures"]}
    # From 60 to 80: the deviation is 20 at first and decreases.
    assert 100 < figures["iae"]["value"] < 20 * 1200
    assert told["last"]["CONT_C.SP_INT"] == 80.0 and told["last"]["CONT_C.QLMN_HLM"] is False


def test_a_run_of_a_plant_alone_has_no_figures(plcfmu):
    lines = plcfmu("run", FMUS[1], "--stop=2").stdout.splitlines()
    assert lines[1:] == ["no figures: setpoint and process value of the first FMU are not recorded"]


def test_rows_are_recorded_as_often_as_wanted(plcfmu):
    given = ["run", FMUS[1], "--step=0.5", "--stop=5.5", "--set=HEATER.POWER=100", "--record=HEATER.TEMP", "--out=-"]
    every = rows(plcfmu(*given).stdout)
    some = rows(plcfmu(*given, "--every=2").stdout)
    assert [row["time"] for row in some] == ["0.0", "2.0", "4.0", "5.5"]
    assert some == [every[0], every[4], every[8], every[11]]
    assert "the interval must be a whole number of steps" in plcfmu(*given, "--every=0.7").stderr


def test_inputs_come_from_a_file_of_signals(plcfmu, tmp_path):
    (tmp_path / "power.csv").write_text("time,HEATER.POWER\n0,10\n1.0,10\n2.0,50\n")
    given = ["run", FMUS[1], "--step=1", "--stop=4", "--out=-", "--record=HEATER.POWER", "--record=HEATER.T_FURN"]
    read = plcfmu(*given, "--signals=power.csv")
    assert [row["HEATER.POWER"] for row in rows(read.stdout)] == ["10.0", "10.0", "50.0", "50.0", "50.0"]
    assert read.stdout == plcfmu(*given, "--set=HEATER.POWER=10", "--set=HEATER.POWER=50@2").stdout
    # What a run has written is a file of signals.
    (tmp_path / "again.csv").write_text(plcfmu(*given, "--signals=power.csv", "--record=HEATER.POWER").stdout.replace("T_FURN", "DOOR"))
    assert plcfmu("run", FMUS[1], "--step=1", "--stop=5", "--signals=again.csv").returncode == 0


def test_a_picture_has_setpoint_and_process_value_in_one_panel_and_fits_on_a_page(plcfmu, tmp_path):
    assert plcfmu("run", *FMUS, *LOOP, *STEP, "--stop=300", "--plot=loop.svg").returncode == 0
    svg = (tmp_path / "loop.svg").read_text()
    names = [name for name in ("CONT_C.SP_INT", "CONT_C.PV", "CONT_C.LMN", "CONT_C.LMN_P") if f">{name}<" in svg]
    assert names == ["CONT_C.SP_INT", "CONT_C.PV", "CONT_C.LMN", "CONT_C.LMN_P"]
    assert svg.index(">CONT_C.SP_INT<") < svg.index(">CONT_C.PV<") < svg.index(">CONT_C.LMN<") < svg.index(">CONT_C.LMN_P<")
    # A connected input repeats its output.
    assert ">HEATER.POWER<" not in svg
    assert plcfmu("run", *FMUS, *LOOP, "--stop=3", "--plot=one.svg", "--record=HEATER.POWER").returncode == 0
    assert ">HEATER.POWER<" in (tmp_path / "one.svg").read_text()


def test_a_preset_that_the_fmu_refuses_is_not_made(plcfmu, tmp_path):
    done = plcfmu("preset", host.FOLDER / "PULS_CTR.fmu", "--set=RED_FAC=0", "--out=red.fmu")
    assert done.returncode == 1
    assert "error: red.fmu would not run: " in done.stderr and "RED_FAC is 0" in done.stderr
    assert list(tmp_path.iterdir()) == []
    dead = plcfmu("preset", host.FOLDER / "PROCESS.fmu", "--set=DEAD_MAX=1e9", "--out=dead.fmu")
    assert dead.returncode == 1 and "error: dead.fmu would not run: " in dead.stderr and "DEAD_MAX is 1000000000 s" in dead.stderr
    assert list(tmp_path.iterdir()) == []
    twice = plcfmu("preset", FMUS[0], "--set=GAIN=1", "--set=GAIN=2", "--out=two.fmu")
    assert "GAIN is set twice: remove one of the settings" in twice.stderr


def test_presets_are_told_as_json(plcfmu):
    done = plcfmu("preset", FMUS[0], "--set=GAIN=3", "--out=FAST.fmu", "--json")
    (told,) = json.loads(done.stdout)
    assert (told["name"], told["block"], told["file"]) == ("FAST", "CONT_C", "FAST.fmu")
    assert any("MAN_ON is TRUE" in warning for warning in told["warnings"])


def test_the_step_of_a_loop_is_its_cycle_wherever_it_is_said(plcfmu, tmp_path):
    (tmp_path / "fast.awl").write_text("DATA_BLOCK FAST CONT_C BEGIN CYCLE := T#100MS; END_DATA_BLOCK")
    expected = "30 steps of 0.1 s, as {} proposes, from 0 s to 3 s"
    assert plcfmu("run", "fast.awl", f"--fmus={host.FOLDER}", "--stop=3").stdout.startswith(expected.format("FAST"))
    assert plcfmu("run", FMUS[0], "--set=CONT_C.CYCLE=0.1", "--stop=3").stdout.startswith(expected.format("CONT_C"))
    assert plcfmu("preset", "fast.awl", "--fmus", FMUS[0], "--out=F.fmu").returncode == 0
    assert plcfmu("run", "F.fmu", "--stop=3").stdout.startswith(expected.format("F"))


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell", "elvish"])
def test_a_shell_can_complete_the_options(plcfmu, shell):
    done = plcfmu("completions", shell)
    assert done.returncode == 0 and "time-limit" in done.stdout


def test_there_is_a_manual_page_for_each_command(plcfmu, tmp_path):
    assert plcfmu("manual", "--out=man1").returncode == 0
    pages = {page.name for page in (tmp_path / "man1").iterdir()}
    assert {"plcfmu.1", "plcfmu-run.1", "plcfmu-check.1", "plcfmu-tune-study.1"} <= pages
    assert "plcfmu-child.1" not in pages
    assert (tmp_path / "man1/plcfmu-run.1").read_text().splitlines()[2].startswith(".TH plcfmu-run 1")


MISTAKEN = {
    "study CONT_C.fmu": "CONT_C.fmu is an FMU: a study is a .toml that names a loop; 'plcfmu run CONT_C.fmu' runs an FMU",
    "tune-study CONT_C.fmu": "CONT_C.fmu is an FMU: a study is a .toml that names a loop; 'plcfmu run CONT_C.fmu' runs an FMU",
    "study tank.scl": "tank.scl is a program: a study is a .toml that names a loop, which may contain a program",
    "test tank.scl": "tank.scl is a program: specify its test file, a .toml; 'plcfmu new --scl NAME' creates a program with a test",
    "build notes.md": "notes.md is neither a program source (.scl, .udt, .db, .s7dcl, .xml, .awl) nor a workspace package",
    "run notes.md": "notes.md is neither an FMU (.fmu), a loop (.toml), a parameter file (.awl, .db, .xml, ...) nor a program (.scl)",
    "preset CONT_C.fmu --out p.zip": "p.zip: a preset's file name must end in .fmu; for a folder, write p.zip/",
    "run loop.toml": "loop.toml:2:5: no file NOTHING_LIKE_IT.fmu; FMU paths are relative to the folder of this file, or to --fmus FOLDER",
}


@pytest.mark.parametrize("given", MISTAKEN)
def test_a_file_of_another_kind_is_told_with_what_to_name(given, plcfmu, tmp_path):
    (tmp_path / "CONT_C.fmu").symlink_to(FMUS[0])
    (tmp_path / "tank.scl").write_text("FUNCTION_BLOCK A\nBEGIN\nEND_FUNCTION_BLOCK\n")
    (tmp_path / "notes.md").write_text("# Notes\n")
    (tmp_path / "loop.toml").write_text('[fmus]\nP = "NOTHING_LIKE_IT.fmu"\n')
    done = plcfmu(*given.split())
    assert done.returncode == (3 if given.startswith("run") else 1)
    assert (done.stdout, done.stderr) == ("", f"error: {MISTAKEN[given]}\n")
    assert not (tmp_path / "p.zip").exists()


def test_a_preset_goes_into_a_folder_whose_name_has_an_ending_if_it_is_written_as_one(plcfmu, tmp_path):
    done = plcfmu("preset", FMUS[0], "--out", "p.zip/")
    assert done.returncode == 0, done.stderr
    assert [path.suffix for path in (tmp_path / "p.zip").iterdir()] == [".fmu"]
