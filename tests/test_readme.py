"""The commands of README.md do what it says of them. Its lines of Python are run by test_wheel.py."""

import csv
import pathlib
import re
import shlex
import subprocess

import host

ROOT = pathlib.Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def printed(beginning):
    """The command of README that begins so, as its words, with the FMUs where they are."""
    (found,) = re.findall(rf"^    {beginning}((?:.*\\\n)*.*)$", TEXT, re.MULTILINE)
    words = shlex.split(beginning + found.replace("\\\n", " "))
    return [word.replace("target/fmu", str(host.FOLDER)) for word in words[1:]]


def test_the_loop_of_the_picture_settles_when_the_caption_says_and_survives_the_door(command, tmp_path):
    given = [command, *printed("plcfmu run"), "--out=loop.csv"]
    subprocess.run(given, cwd=tmp_path, check=True, capture_output=True)
    temperatures = [float(row["HEATER.TEMP"]) for row in csv.DictReader((tmp_path / "loop.csv").open())]
    assert "60 °C after 133 s; at 300 s the door" in TEXT
    # Within 2 % of the step of 40 K.
    is_off = [abs(temperature - 60.0) > 0.8 for temperature in temperatures[:300]]
    assert max(second for second, off in enumerate(is_off) if off) + 1 == 133
    assert 57.0 < min(temperatures[300:]) < 57.2 and temperatures[-1] > 59.8
    assert (tmp_path / "loop.png").read_bytes()[:4] == b"\x89PNG"


def test_a_plant_of_five_loops_goes_from_the_plc_and_back(command, tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for beginning in ("plcfmu preset", "plcfmu ssp", "plcfmu params examples/plant/tuned.json"):
        done = subprocess.run([command, *printed(beginning)], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    presets = {path.stem for path in (tmp_path / "presets").glob("*.fmu")}
    assert presets == {"TIC101", "LIC201", "FIC301", "SIC401", "TIC501"}
    compared = [command, "params", "tuned.awl", "--diff", "examples/plant/tuned.json"]
    done = subprocess.run(compared, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout == "no differences\n"
