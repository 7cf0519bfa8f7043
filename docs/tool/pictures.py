"""Takes the pictures of README.md and docs/tool.md: a session with the parameter tool, from a parameter file to the result.

    cargo xtask tool
    target/venv/bin/python docs/tool/pictures.py target/tool/plcfmu-tool.html
"""

import pathlib
import shutil
import sys

from playwright.sync_api import sync_playwright

FOLDER = pathlib.Path(__file__).resolve().parent
LOOPS = FOLDER.parents[1] / "tests/parameters/plant.awl"
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
SIZE = {"width": 1366, "height": 768}


def run_for(page, seconds):
    """Runs the loop as fast as it goes."""
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    page.locator("#run-for").fill(str(seconds))
    page.get_by_role("button", name="Run", exact=True).click()
    page.get_by_role("button", name="Pause", exact=True).wait_for(state="hidden")
    page.get_by_role("button", name="Run", exact=True).wait_for()
    page.locator("#run-for").fill("")


def set_now(page, field, value):
    """Types a value into a field of the run bar and sends it."""
    page.locator(field).fill(str(value))
    page.locator(field).press("Enter")


def show_tab(page, name):
    """Shows a tab of the page."""
    page.get_by_role("tab", name=name, exact=True).click()


def session(page):
    """The steps of a user; gives the name of each picture when it is to be taken."""
    page.locator("#open-files").set_input_files(LOOPS)
    page.get_by_role("button", name="TIC105", exact=True).wait_for()
    yield "open"
    page.get_by_role("button", name="TIC105", exact=True).click()
    plant = page.locator("#plant")
    for label, value in (("Gain", "0.5"), ("Time constant", "60"), ("Dead time", "5")):
        plant.get_by_label(label).fill(value)
    plant.get_by_role("button", name="Use this plant").click()
    plant.get_by_text("goes to").first.wait_for()
    dead_band = page.locator("#parameters").get_by_label("DEADB_W", exact=True)
    dead_band.fill("0")
    show_tab(page, "Diagram")
    yield "edit"
    dead_band.press("Enter")
    manual = page.locator("#run").get_by_role("checkbox", name="Manual")
    manual.check()
    run_for(page, 744.1)
    set_now(page, "#manual-value", 60)
    run_for(page, 637.8)
    show_tab(page, "Tune")
    page.locator("#split").focus()
    for _ in range(8):
        page.keyboard.press("ArrowUp")
    page.locator("#tune").get_by_role("button", name="Identify from this step").click()
    page.locator("#tune .fit").get_by_text("fit").wait_for()
    page.wait_for_function("() => document.querySelectorAll('#tune .rules tbody tr').length === 8")
    page.locator("#tune-rule").scroll_into_view_if_needed()
    yield "tune"
    page.locator("#split").dblclick()
    page.locator("#tune").get_by_role("button", name="Apply").first.click()
    page.keyboard.press("Control+Enter")
    set_now(page, "#setpoint", 35)
    manual.uncheck()
    run_for(page, 318.9)
    show_tab(page, "Runs")
    page.wait_for_function("() => document.querySelectorAll('#glance > div').length > 2")
    yield "run"
    page.locator("#away-button").click()
    yield "take"


def main():
    """Takes them all."""
    page_file = pathlib.Path(sys.argv[1]).resolve()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        page = browser.new_page(viewport=SIZE)
        page.goto(page_file.as_uri())
        for name in session(page):
            page.screenshot(path=FOLDER / f"{name}.png")
        browser.close()


if __name__ == "__main__":
    main()
