"""Writes every state of the parameter tool as a picture, to be looked at: `python tests/screenshots.py [FOLDER]`.

The page is that of PLCFMU_TOOL, or target/tool/plcfmu-tool.html (`cargo xtask tool`). The pictures are in
target/tool/screenshots by default, each as STATE-WIDTHxHEIGHT-SCHEME.png.
"""

import pathlib
import sys

from playwright.sync_api import sync_playwright

from tool import ARGUMENTS, CHROMIUM, PAGE, new_loop, show_tab, take_generic_plant

# The usual laptop, with and without the browser's bars; a phone; a large screen; 200 % zoom of the laptop.
SIZES = [
    *((1366, 768, scheme) for scheme in ("light", "dark")),
    *((390, 844, scheme) for scheme in ("light", "dark")),
    (1366, 650, "light"),
    (1920, 1000, "light"),
    (683, 384, "light"),
]


def open_example(page, title):
    page.evaluate("document.querySelector('.all-examples').open = true")
    page.locator(".card").filter(has_text=title).click()
    page.wait_for_function("() => [...document.querySelectorAll('#curves [role=slider]')].some(one => one.ariaValueMax > 0)")


def first_page(page):
    page.wait_for_function("() => document.querySelectorAll('.card .spark svg').length === 16")
    page.wait_for_function("() => document.querySelector('.living svg')")


def new(page):
    new_loop(page, "TIC101")


def furnace(page):
    open_example(page, "Furnace with a continuous")


def pulses(page):
    open_example(page, "Chamber with heating pulses")


def step_controller(page):
    open_example(page, "Heat exchanger with a step")


def drive(page):
    open_example(page, "Drive behind a ramp")


def diagram(page):
    furnace(page)
    show_tab(page, "Diagram")


def tuned(page):
    new_loop(page, "TIC101")
    take_generic_plant(page, "2", "20", "2")
    show_tab(page, "Tune")
    page.locator("#step-test").click()
    page.wait_for_function("() => document.querySelectorAll('#tune .rules .all tr').length === 9")


def runs(page):
    furnace(page)
    for name, value in (("GAIN", "1.4"), ("TI", "80")):
        if page.locator("#tab-side").is_visible():
            show_tab(page, "Parameters")
        page.locator(f"#field-{name}").fill(value)
        page.locator(f"#field-{name}").press("Enter")
        show_tab(page, "Runs")
        page.locator("#runs").get_by_role("button", name="Same test").click()
        page.get_by_text(f"{name} {value}").first.wait_for()


def take_away(page):
    furnace(page)
    page.locator("#away-button").click()


def field_help(page):
    furnace(page)
    if page.locator("#tab-side").is_visible():
        show_tab(page, "Parameters")
    page.locator("#field-GAIN").focus()
    page.keyboard.press("F1")
    page.get_by_role("region", name="Help on GAIN").wait_for()


STATES = [first_page, new, furnace, pulses, step_controller, drive, diagram, tuned, runs, take_away, field_help]


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        for width, height, scheme in SIZES:
            for state in STATES:
                context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
                page = context.new_page()
                page.goto(PAGE.as_uri())
                page.locator("#new-block option").first.wait_for(state="attached")
                state(page)
                page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
                path = folder / f"{state.__name__}-{width}x{height}-{scheme}.png"
                page.screenshot(path=path)
                print(path)
                context.close()
        browser.close()


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE.parent / "screenshots")
