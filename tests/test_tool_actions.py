"""How many actions the tool asks for: each click, choice, file, typed text and key is one, as an engineer makes them who has never
seen the page. The numbers are what the project promises."""

import difflib
import io
import pathlib
import re
import zipfile

import pytest

import host
from test_tool_run import LOOPS, browser, made, open_tool, pytestmark, wait_for_calls  # noqa: F401

SCREEN = (1366, 768)


class User:
    """Does what one does with a mouse and a keyboard, and counts it."""

    def __init__(self, page):
        self.page = page
        self.actions = 0

    def click(self, where):
        self.actions += 1
        where.click()

    def button(self, name, within="body"):
        self.click(self.page.locator(within).get_by_role("button", name=name, exact=True).first)

    def type(self, where, text):
        self.actions += 1
        self.page.locator(where).fill(text)

    def choose(self, where, value):
        self.actions += 1
        self.page.locator(where).select_option(value)

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


def new_furnace(open_tool):
    """A new loop with HEATER, as a user makes it, and its page."""
    page = open_tool(SCREEN)
    user = User(page)
    user.button("New loop")
    user.button("HEATER", within=".no-run")
    return page, user


def make_step_test(page, user):
    """Until its model is found, and the rules have their settings."""
    user.button("Run a step test")
    page.locator("#tune .fit").get_by_text("fit").wait_for()


def put_in_force(user):
    """What the rule gives."""
    user.button("Apply", within="#tune")


def overshoot(page):
    """That of the run, as the run bar has it."""
    shown = page.locator("#glance div").filter(has_text="overshoot").locator("dd")
    shown.wait_for()
    return float(shown.get_attribute("data-full"))


def wait_for_rest(page):
    """Until the run has ended by itself, and the figures are those of its last call."""
    page.locator("#run .status").get_by_text("settled").wait_for()
    at = "figures => figures.textContent.includes(' to ' + document.querySelector('#run .status').textContent.split(' ')[2])"
    page.wait_for_function(f"() => ({at})(document.querySelector('#figures'))")


def test_from_nothing_to_a_tuned_loop_at_60_degc_saved_as_awl_and_fmu_in_10_actions(open_tool):  # noqa: F811
    page, user = new_furnace(open_tool)
    make_step_test(page, user)
    put_in_force(user)
    user.type("#tune-to", "60")
    user.button("Run the step to 60 °C")
    wait_for_rest(page)
    value = "async () => (await moduleOf('tool/store.js')).store.state.values['CONT_C_1.PV']"
    assert abs(page.evaluate(value) - 60) < 0.1
    # What was predicted for this step, after a rest in automatic mode, is what came.
    predicted = page.evaluate("async () => (await moduleOf('tool/store.js')).store.prediction.curves")
    figures = page.evaluate("async () => (await (await moduleOf('tool/engine.js')).ask({ do: 'figures' })).figures")
    came = {figure["key"]: figure["value"] for figure in figures}
    # The model has both lags of the furnace. A PI controller with these settings, computed apart: 2.7 % and 168 s.
    assert predicted["overshoot"] == pytest.approx(came["overshoot"], abs=0.3)
    assert predicted["settling"] == pytest.approx(came["settling"], abs=3)
    assert overshoot(page) == pytest.approx(2.7, abs=0.5) and came["settling"] == pytest.approx(168, abs=4)
    user.click(page.locator("#away-button"))
    name, awl = user.saved(lambda: user.button("Save parameters"))
    assert name.endswith(".awl")
    set_in_file = dict(re.findall(r"\b(GAIN|TI|SP_INT) := ([^;]+);", awl.decode("latin-1")))
    fields = {name: page.locator(f"#field-{name}").input_value() for name in ("GAIN", "TI")}
    # The fields round to five digits.
    assert float(set_in_file["GAIN"]) == pytest.approx(float(fields["GAIN"]), rel=1e-5)
    # K = 3, T = 120 s, T2 = 20 s and L = 5.5 s with half of CYCLE: 130 / (K (1.5 (L + T2) + L + T2/2)).
    assert float(fields["GAIN"]) == pytest.approx(0.806, abs=0.01) and 129 < float(fields["TI"]) < 131
    name, preset = user.saved(lambda: user.open("#preset-fmu", host.FOLDER / "CONT_C.fmu"))
    start = zipfile.ZipFile(io.BytesIO(preset)).read("modelDescription.xml").decode()
    assert name.endswith(".fmu") and re.search(r'name="GAIN".*?start="0.8\d', start, re.DOTALL)
    assert user.actions <= 10


def test_a_furnace_that_begins_cold_overshoots_by_less_than_5_percent_and_that_is_predicted(open_tool):  # noqa: F811
    page, user = new_furnace(open_tool)
    make_step_test(page, user)
    put_in_force(user)
    user.type("#setpoint", "60")
    user.press("Enter")
    user.click(page.locator("#run").get_by_role("checkbox", name="Manual"))
    user.button("Reset")
    user.button("max")
    # The step that comes is from 20 degC to 60 degC at once, as the loop begins.
    page.wait_for_function("() => document.querySelector('#tune-from').placeholder === '20'")
    predicted = page.evaluate("async () => (await moduleOf('tool/store.js')).store.prediction.curves")
    user.button("Run")
    wait_for_rest(page)
    assert overshoot(page) == pytest.approx(2.7, abs=0.5)
    assert predicted["overshoot"] == pytest.approx(overshoot(page), abs=0.3)


def test_mode_and_setpoint_of_the_run_are_in_the_file_if_the_user_says_so(open_tool):  # noqa: F811
    page, user = new_furnace(open_tool)
    user.type("#setpoint", "60")
    user.press("Enter")
    user.click(page.locator("#run").get_by_role("checkbox", name="Manual"))
    user.click(page.locator("#away-button"))
    also = page.locator("#takeaway").get_by_role("checkbox", name="also MAN_ON, SP_INT as in the run")
    saved = []
    for is_wanted in [False, True]:
        also.set_checked(is_wanted)
        _, awl = user.saved(lambda: user.button("Save parameters"))
        saved.append(dict(re.findall(r"\b(MAN_ON|SP_INT) := ([^;]+);", awl.decode("latin-1"))))
    kept, tried = saved
    assert (kept["MAN_ON"], float(kept["SP_INT"])) == ("TRUE", 0)
    assert (tried["MAN_ON"], float(tried["SP_INT"])) == ("FALSE", 60)


def test_a_target_where_the_step_begins_is_named_and_no_other_step_is_offered(open_tool):  # noqa: F811
    page, user = new_furnace(open_tool)
    make_step_test(page, user)
    user.type("#tune-from", "60")
    user.type("#tune-to", "60")
    page.locator("#tune").get_by_text("Start and target are both 60. Enter a different start or target.").wait_for()
    assert page.get_by_role("button", name=re.compile("^Run the step")).count() == 0


def test_leaving_manual_mode_does_not_change_the_prediction_of_the_step(open_tool):  # noqa: F811
    page, user = new_furnace(open_tool)
    make_step_test(page, user)
    user.type("#setpoint", "60")
    user.press("Enter")
    page.wait_for_function("() => document.querySelector('#tune-to').placeholder === '60'")
    curve = "async () => (await moduleOf('tool/store.js')).store.prediction.curves.process_value"
    before = page.evaluate(curve)
    manual = page.locator("#run").get_by_role("checkbox", name="Manual")
    user.click(manual)
    sent = "async () => (await moduleOf('tool/store.js')).store.loop.settings.MAN_ON.sent === false"
    page.wait_for_function(sent)
    page.locator("#done").get_by_text("MAN_ON").first.wait_for(state="attached")
    assert page.evaluate(curve) == pytest.approx(before, abs=0.01)
