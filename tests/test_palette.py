"""The colours of curves are in one file: a change of the process value's is one edit."""

import pathlib
import re
import subprocess
import zipfile

import host
from plcfmu import plot

ROOT = pathlib.Path(__file__).parents[1]
PALETTE = ROOT / "plcfmu/python/plcfmu/palette.css"
COLORS = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", PALETTE.read_text()))
# Black and greys are in use for text and lines, too.
SIGNALS = {color for name, color in COLORS.items() if name.startswith(("curve", "level", "choice", "run")) and len({*re.findall("..", color[1:])}) > 1} - {
    COLORS["choice-4-light"],
    COLORS["choice-4-dark"],
    COLORS["curve-7-dark"],
}


def test_no_source_but_the_palette_has_the_colour_of_a_curve():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=True)
    files = [ROOT / name for name in listed.stdout.splitlines() if name.endswith((".rs", ".js", ".css", ".html", ".py"))]
    assert len(files) > 500 and len(SIGNALS) > 25
    found = []
    for file in files:
        of_product = not file.is_relative_to(ROOT / "tests") and not file.is_relative_to(ROOT / "examples")
        if file != PALETTE and of_product and "/vendor/" not in str(file) and "/tests" not in str(file) and file.is_file():
            text = file.read_text(encoding="utf-8").lower()
            found += [f"{file.relative_to(ROOT)}: {color}" for color in SIGNALS if color in text]
    assert found == []


def test_pages_charts_and_python_have_the_palettes_colours():
    blue, vermilion = COLORS["curve-1-light"], COLORS["curve-2-light"]
    assert (plot.PROCESS_VALUE["color"], plot.MANIPULATED["color"]) == (blue, vermilion)
    with zipfile.ZipFile(host.FOLDER / "CONT_C.fmu") as fmu:
        page = fmu.read("documentation/index.html").decode()
    assert f"--curve-1-light: {blue}" in page
    assert "svg .curve-1 { color: var(--curve-1-dark); }" in page
