"""Takes the screenshots for README.md and docs/tool.md: a session with the parameter tool, from a parameter file to the result, and a
short animation of a run.

    cargo xtask tool
    target/venv/bin/python docs/tool/pictures.py target/tool/plcfmu-tool.html
"""

import io
import pathlib
import shutil
import sys

import PIL.Image
from playwright.sync_api import sync_playwright

FOLDER = pathlib.Path(__file__).resolve().parent
# The controllers of a plant, in groups: block, letters of the names, number of loops, and the members that the file sets.
CONTROLLERS = [
    ("FB 41", "TIC", 12, [("MAN_ON", "FALSE"), ("SP_INT", "40.0"), ("GAIN", "1.5"), ("TI", "T#2M"), ("DEADB_W", "0.5")]),
    ("FB 41", "LIC", 6, [("MAN_ON", "FALSE"), ("CYCLE", "T#500MS"), ("SP_INT", "50.0"), ("GAIN", "4.0"), ("TI", "T#90S")]),
    ("FB 42", "FIC", 14, [("CYCLE", "T#200MS"), ("SP_INT", "40.0"), ("GAIN", "0.8"), ("TI", "T#15S")]),
    ("FB 43", "YC", 8, [("CYCLE", "T#100MS"), ("PER_TM", "T#10S"), ("P_B_TM", "T#200MS")]),
]
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
SIZE = {"width": 1366, "height": 768}


def loops():
    """The plant's parameter file."""
    text = ""
    for block, letters, count, members in CONTROLLERS:
        for number in range(101, 101 + count):
            text += f'DATA_BLOCK "{letters}{number}"\nTITLE =\nVERSION : 0.1\n\n {block}\nBEGIN\n'
            text += "".join(f"   {name} := {value};\n" for name, value in members) + "END_DATA_BLOCK\n\n"
    return {"name": "plant.awl", "mimeType": "text/plain", "buffer": text.encode()}


def run_for(page, seconds):
    """Runs the loop at full speed."""
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    page.locator("#run-for").fill(str(seconds))
    # After settings have been applied, the button is labelled Resume.
    page.locator("#run-go").click()
    page.wait_for_function("() => document.querySelector('#run-go').textContent !== 'Pause'")
    page.locator("#run-for").fill("")


def set_now(page, field, value):
    """Types a value into a field of the run bar and applies it."""
    page.locator(field).fill(str(value))
    page.locator(field).press("Enter")


def show_tab(page, name):
    """Shows a tab of the page."""
    page.get_by_role("tab", name=name, exact=True).click()


def session(page):
    """Performs a user's session; yields the name of each picture when the page is ready for it."""
    page.locator("#open-files").set_input_files(loops())
    page.get_by_role("button", name="TIC105", exact=True).wait_for()
    yield "open"
    page.get_by_role("button", name="TIC105", exact=True).click()
    page.locator("#plant-choice").select_option("HEATER")
    page.locator("#plant").get_by_text("goes to").first.wait_for()
    dead_band = page.locator("#parameters").get_by_label("DEADB_W", exact=True)
    dead_band.fill("0")
    show_tab(page, "Diagram")
    dead_band.evaluate("one => one.closest('.field').scrollIntoView({ block: 'center' })")
    yield "edit"
    dead_band.press("Enter")
    # A step test begins in steady state at the setpoint.
    run_for(page, 1500)
    show_tab(page, "Tune")
    page.locator("#split").focus()
    for _ in range(8):
        page.keyboard.press("ArrowUp")
    page.locator("#step-test").click()
    page.locator("#tune .fit").get_by_text("fit").wait_for()
    page.wait_for_function("() => document.querySelectorAll('#tune .rules .all tr').length === 9")
    page.locator("#tune .rules").evaluate("one => one.scrollIntoView()")
    yield "tune"
    page.wait_for_function("() => document.querySelectorAll('.bode canvas').length === 2")
    page.locator(".bode").evaluate("one => one.scrollIntoView()")
    yield "bode"
    page.locator("#split").dblclick()
    page.locator("#tune").get_by_role("button", name="Apply").first.click()
    page.locator("#tune p.row").get_by_text("in force", exact=True).wait_for()
    page.locator("#tune-to").fill("60")
    page.get_by_role("button", name="Run the step to 60").click()
    page.locator("#run .status").get_by_text("settled").wait_for()
    page.locator("#glance").get_by_text("settles").wait_for()
    show_tab(page, "Runs")
    # The metrics are those of the step.
    page.locator("#runs tbody tr").filter(has_text="40 to 60").get_by_text("168 s").wait_for()
    yield "run"
    page.locator("#away-button").click()
    yield "take"


# The settings in the animation: the PLC's start values, and settings that suit the furnace.
BEFORE, AFTER = {"GAIN": 2, "TI": 20}, {"GAIN": 0.7, "TI": 130}


def frames(page):
    """The frames of the animation: a furnace oscillates with the PLC's start values; after tuning, the same test shows the difference."""
    page.locator("#new-block option").first.wait_for(state="attached")
    page.get_by_role("button", name="New loop").click()
    page.locator("#plant-choice").select_option("HEATER")
    page.get_by_role("button", name="Run a step test").wait_for()
    for name, value in BEFORE.items():
        assert float(page.locator(f"#field-{name}").input_value()) == value
    set_now(page, "#setpoint", 60)
    page.locator("#run").get_by_role("checkbox", name="Manual").uncheck()
    run_for(page, 600)
    show_tab(page, "Runs")
    # Room for both runs.
    page.locator("#split").focus()
    for _ in range(2):
        page.keyboard.press("ArrowUp")
    page.wait_for_function("() => document.querySelector('#runs tbody td:nth-child(5)')?.textContent.includes('%')")
    for _ in range(8):
        yield page.screenshot()
    for name, value in AFTER.items():
        page.locator(f"#field-{name}").fill(str(value))
        for _ in range(4):
            yield page.screenshot()
        page.locator(f"#field-{name}").press("Enter")
    page.get_by_role("button", name="Reset").click()
    for seconds in [5] * 12 + [10] * 12 + [20] * 21:
        page.locator("#run-for").fill(str(seconds))
        page.get_by_role("button", name="Run", exact=True).click()
        page.get_by_role("button", name="Pause", exact=True).wait_for(state="hidden")
        page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        yield page.screenshot()
    page.wait_for_function("() => document.querySelectorAll('#runs tbody tr').length === 2")
    for _ in range(20):
        yield page.screenshot()


def animate(taken, path):
    """Combines frames into an animation; identical consecutive frames become one that is shown longer."""
    first, *others = [
        PIL.Image.open(io.BytesIO(frame)).convert("RGB").resize((1024, 576), PIL.Image.Resampling.LANCZOS)
        for frame in taken
    ]
    # Large areas keep their exact colours; the rest of the palette is for lines and letters.
    areas = [colour for _, colour in sorted(others[-1].getcolors(1 << 20), reverse=True)[:32]]
    lines = others[-1].quantize(208, method=PIL.Image.Quantize.MAXCOVERAGE, dither=PIL.Image.Dither.NONE)
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette([*sum(areas, ()), *lines.getpalette()[: 3 * 208]])
    first, *others = [one.quantize(palette=palette, dither=PIL.Image.Dither.NONE) for one in (first, *others)]
    first.save(path, save_all=True, append_images=others, duration=110, loop=0, optimize=True)


def main():
    """Takes all pictures."""
    page_file = pathlib.Path(sys.argv[1]).resolve()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        page = browser.new_page(viewport=SIZE)
        page.goto(page_file.as_uri())
        for name in session(page):
            page.screenshot(path=FOLDER / f"{name}.png")
        page = browser.new_page(viewport=SIZE)
        page.goto(page_file.as_uri())
        animate(list(frames(page)), FOLDER / "run.gif")
        browser.close()


if __name__ == "__main__":
    main()
