"""How many actions the tool asks for: each click, choice, file, typed text and key is one, as an engineer makes them who has never
seen the page. The numbers are what the project promises."""

import difflib
import pathlib
import re

import pytest
from test_tool_run import LOOPS, browser, contents, open_tool, pytestmark, wait_for_calls  # noqa: F401

import host

SCREEN = (1366, 768)


class User:
    """Does what one does with a mouse and a keyboard, and counts it."""

    def __init__(self, page):
        self.page = page
        self.actions = 0

    def click(self, where):
        self.actions += 1
        where.click()

    def tab(self, name):
        self.click(self.page.get_by_role("tab", name=name, exact=True))

    def button(self, name, within="body"):
        self.click(self.page.locator(within).get_by_role("button", name=name, exact=True).first)

    def choose(self, where, value):
        self.actions += 1
        self.page.locator(where).select_option(value)

    def type(self, where, text):
        self.actions += 1
        self.page.locator(where).fill(text)

    def press(self, key):
        self.actions += 1
        self.page.keyboard.press(key)

    def open(self, where, file):
        self.actions += 1
        self.page.locator(where).set_input_files(file)

    def saved(self, act):
        with self.page.expect_download() as download:
            act()
        return download.value.suggested_filename, pathlib.Path(download.value.path()).read_bytes()


def test_from_nothing_to_a_tuned_loop_saved_for_plc_and_simulation_in_20_actions(open_tool, tmp_path):  # noqa: F811
    page = open_tool(SCREEN)
    user = User(page)
    user.button("New loop")
    user.choose("#plant-choice", "HEATER")
    user.tab("Tune")
    user.button("Step test")
    page.locator("#tune .fit").get_by_text("fit").wait_for()
    user.button("Apply")
    user.press("Control+Enter")
    user.type("#setpoint", "60")
    user.press("Enter")
    user.click(page.locator("#run").get_by_role("checkbox", name="Manual"))
    user.button("max", "#run")
    user.type("#run-for", "2000")
    calls = page.evaluate("async () => (await moduleOf('tool/store.js')).store.state.calls")
    user.button("Run", "#run")
    wait_for_calls(page, calls + 2000)
    page.locator("#run").get_by_role("button", name="Run", exact=True).wait_for()
    value = "async name => { const { store } = await moduleOf('tool/store.js'); return store.state.values[`${store.loop.member}.${name}`]; }"
    assert page.evaluate(value, "PV") == pytest.approx(60, abs=0.5) and page.evaluate(value, "MAN_ON") is False
    page.wait_for_function("() => /Overshoot\\s*[0-9.]+ %/i.test(document.querySelector('#figures').textContent)")
    overshoot = re.search(r"Overshoot\s*([\d.]+) %", page.locator("#figures").text_content(), re.IGNORECASE)
    assert float(overshoot[1]) < 5
    user.click(page.locator("#away-button"))
    name, awl = user.saved(lambda: user.button("Save parameters"))
    assert name.endswith(".awl")
    name, fmu = user.saved(lambda: user.open("#preset-fmu", host.FOLDER / "CONT_C.fmu"))
    (gain,) = re.findall(r"GAIN := ([\d.e+-]+);", awl.decode())
    archive = tmp_path / name
    archive.write_bytes(fmu)
    starts = contents(archive)["resources/start.txt"].decode()
    assert float(re.search(r"^GAIN = (\S+)", starts, re.MULTILINE)[1]) == pytest.approx(float(gain), rel=1e-6)
    assert user.actions <= 20


def test_one_of_forty_loops_is_changed_and_taken_back_in_6_actions_with_one_line_that_differs(open_tool):  # noqa: F811
    page = open_tool(SCREEN)
    user = User(page)
    user.open("#open-files", LOOPS)
    user.button("TIC103")
    user.type("#field-GAIN", "3.25")
    user.press("Enter")
    user.click(page.locator("#away-button"))
    name, source = user.saved(lambda: user.button(f"Save {LOOPS.name}"))
    assert name == LOOPS.name
    before, after = LOOPS.read_bytes().decode("latin-1"), source.decode("latin-1")
    changed = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]
    assert len(changed) == 2 and changed[1].startswith("+") and "GAIN" in changed[1] and "3.25" in changed[1], changed
    assert user.actions <= 6
