"""The parameter tool's page in a browser: a loop is run, judged, tuned and taken away, as a user does it.

The page is that of PLCFMU_TOOL, or target/tool/plcfmu-tool.html (`cargo xtask tool`). What it computes is compared with
`plcfmu run` of the description that it saves. Screenshots are in target/tool/screenshots afterwards.
"""

import base64
import csv
import json
import math
import pathlib
import re
import shutil
import subprocess
import zipfile

import pytest

import host
from tool import ARGUMENTS, CHROMIUM, PAGE, add_sensor, needs_browser, needs_page, new_loop, show_tab, take_generic_plant, until

ROOT = pathlib.Path(__file__).parents[1]
pytestmark = [*needs_browser, needs_page]

DESKTOP, PHONE = (1280, 900), (390, 844)
LOOPS = ROOT / "tests/parameters/plant.awl"


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def open_tool(browser):
    """Opens the page. Whatever the browser complains of, and a page that scrolls sideways, is a failure."""
    pages, messages = [], []

    def open_tool(size=DESKTOP, scheme="light"):
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme=scheme, accept_downloads=True
        )
        page = context.new_page()
        page.set_default_timeout(10_000)
        page.on("console", lambda message: messages.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: messages.append(str(error)))
        page.goto(PAGE.as_uri())
        page.locator("#new-block option").first.wait_for(state="attached")
        pages.append(page)
        return page

    yield open_tool
    sideways = [page.evaluate("document.documentElement.scrollWidth - innerWidth") for page in pages]
    for page in pages:
        page.context.close()
    assert messages == []
    assert all(excess <= 0 for excess in sideways), f"scrolls sideways by {sideways} px"


@pytest.fixture
def tool(open_tool):
    """The page with a new controller TIC101 and the generic plant: 2 degC for 1 %, 20 s, 2 s."""
    page = open_tool()
    new_loop(page, "TIC101")
    take_generic_plant(page, gain="2", lag="20", dead_time="2")
    return page


def manual(page):
    """The switch to manual mode in the run bar."""
    return page.locator("#run").get_by_role("checkbox", name="Manual")


def automatic(page):
    """Ends manual mode. Before that, the page may make a call with what was set since the last one."""
    manual(page).uncheck()
    until(page, "async () => (await moduleOf('tool/store.js')).store.loop.settings.MAN_ON.sent === false")


def press_calls(page, calls):
    """Makes calls, one by one, by the key that makes one."""
    before = made(page)
    page.locator("#curves").get_by_role("slider").focus()
    for _ in range(calls):
        page.keyboard.press(".")
    wait_for_calls(page, before + calls)


def made(page):
    """How many calls the run has made."""
    found = re.search(r"(\d+) cycles?", page.locator("#run .status").inner_text())
    return int(found[1]) if found else 0


def wait_for_calls(page, calls):
    page.wait_for_function(
        "calls => Number(/(\\d+) cycle/.exec(document.querySelector('#run .status')?.textContent ?? '')?.[1] ?? 0) >= calls",
        arg=calls,
        timeout=300_000,
    )


def run_calls(page, calls, cycle=1.0, fresh=False):
    """Makes this many calls as fast as it goes; after a reset, the run is a fresh one."""
    if fresh:
        page.locator("#run .status").get_by_text("0 cycles").wait_for()
    before = made(page)
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    page.locator("#run-for").fill(repr(calls * cycle))
    # After settings were applied it says Resume.
    page.locator("#run-go").click()
    wait_for_calls(page, before + calls)
    page.wait_for_function("() => document.querySelector('#run-go').textContent !== 'Pause'")
    page.locator("#run-for").fill("")
    assert made(page) == before + calls


FIELDS = {"setpoint": "#setpoint", "disturbance": "#disturbance", "noise": "#noise", "MAN": "#manual-value"}


def set_now(page, field, value):
    """Types a value into a field of the run bar and presses Enter."""
    page.locator(FIELDS[field]).fill(str(value))
    page.locator(FIELDS[field]).press("Enter")


def saved(page, button, panel="#takeaway"):
    """The file that a button saves: name and bytes."""
    if panel == "#takeaway":
        page.locator("#away-button").click()
    with page.expect_download() as download:
        page.locator(panel).get_by_role("button", name=button).click()
    if panel == "#takeaway":
        page.keyboard.press("Escape")
    return download.value.suggested_filename, pathlib.Path(download.value.path()).read_bytes()


def readout(page):
    """The values beside the curves, with all digits, by the curve's name."""
    rows = page.locator("#curves .readout .signal")
    values = "rows => rows.map(row => [row.children[0].innerText.trim(), row.children[1].dataset.full])"
    return dict(rows.evaluate_all(values))


def recorded(text):
    """A CSV as lists of texts by column."""
    header, *rows = csv.reader(text.splitlines())
    return {name: [row[at] for row in rows] for at, name in enumerate(header)}


@pytest.fixture
def run_described(command, tmp_path):
    """Runs a description with the packed FMUs and gives the recording of all variables."""

    def run_described(description):
        for fmu in set(re.findall(r'"([\w.]+\.fmu)"', description)):
            shutil.copy(host.FOLDER / fmu, tmp_path / fmu)
        (tmp_path / "loops.toml").write_text(description)
        done = subprocess.run(
            [command, "run", "loops.toml", "--out", "-"], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return recorded(done.stdout)

    return run_described


def assert_same_bits(page, run_described):
    """The run of the page and `plcfmu run` of its description have the same values, in every variable and call."""
    _, description = saved(page, "Save as TOML")
    _, table = saved(page, "CSV of everything")
    shown, ran = recorded(table.decode()), run_described(description.decode())
    assert set(ran) <= set(shown)
    for name, values in ran.items():
        # The last row is that of the end, at which there is no call.
        assert [number(value) for value in values[:-1]] == [number(value) for value in shown[name]], name
    return shown


def number(text):
    return {"true": 1.0, "false": 0.0}.get(text.lower()) if text.lower() in ("true", "false") else float(text)


def screenshot(page, name):
    folder = PAGE.parent / "screenshots"
    folder.mkdir(exist_ok=True)
    page.screenshot(path=folder / f"{name}.png", full_page=True)


def test_a_loop_without_a_plant_says_so_and_offers_the_generic_one(open_tool):
    page = open_tool()
    new_loop(page, "TIC101")
    plant = page.locator("#plant")
    assert "No plant is connected" in plant.inner_text()
    plant.get_by_label("Time constant").fill("twenty")
    plant.get_by_role("button", name="Use this plant").click()
    assert '"twenty" is not a' in plant.get_by_role("alert").first.inner_text()
    take_generic_plant(page, "2", "20", "2")
    assert page.locator("#plant-choice").input_value() == "PROCESS"


def test_connections_are_sentences_that_can_be_changed(tool):
    sentences = tool.locator("#plant .sentences").first
    assert re.search(r"goes to PLANT\.U", sentences.inner_text())
    source = tool.get_by_label("Source of PLANT.U")
    assert source.input_value() == "TIC101.LMN"
    source.select_option("")
    tool.locator("#free-inputs summary").click()
    assert tool.get_by_label("Source of PLANT.U").input_value() == ""


def test_calls_show_the_values_of_plcfmu_run_bit_for_bit(tool, run_described):
    add_sensor(tool)
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    press_calls(tool, 25)
    set_now(tool, "disturbance", 5)
    set_now(tool, "noise", 0.25)
    run_calls(tool, 25)
    set_now(tool, "setpoint", 80)
    manual(tool).check()
    set_now(tool, "MAN", 12.5)
    run_calls(tool, 30)
    shown = assert_same_bits(tool, run_described)
    last = readout(tool)
    assert float(last["LMN"]) == 12.5 == number(shown["TIC101.LMN"][-1])
    assert host.real(float(last["PV"])) == host.real(number(shown["TIC101.PV"][-1]))


def test_the_first_call_behind_a_measuring_chain_sees_the_plant(open_tool, run_described):
    page = open_tool()
    new_loop(page, "TIC101")
    show_tab(page, "Plant")
    page.locator("#plant-choice").select_option("HEATER")
    page.locator("#plant").get_by_text("goes to").first.wait_for()
    add_sensor(page)
    run_calls(page, 5)
    shown = assert_same_bits(page, run_described)
    # A furnace of 20 degC, not one of 0 degC that becomes one of 20 degC.
    assert shown["SENSOR.Y"][0] == shown["TIC101.PV"][0] == "20.0"


def test_a_measuring_chain_begins_with_the_plant_of_each_run_unless_a_user_sets_its_beginning(open_tool):
    page = open_tool()

    def ask(**request):
        return page.evaluate("async (request) => (await moduleOf('tool/engine.js')).ask(request)", request)

    def members(temperature, chain):
        plant = {"CYCLE": 1.0, "T_START": temperature}
        of = [("TIC101", "CONT_C", {}), ("PLANT", "HEATER", plant), ("SENSOR", "SENSOR", chain)]
        return [{"name": name, "fmu": fmu, "values": values} for name, fmu, values in of]

    wires = [["TIC101.LMN", "PLANT.POWER"], ["PLANT.TEMP", "SENSOR.U"], ["SENSOR.Y", "TIC101.PV_IN"]]

    def first(variable="TIC101.PV_IN"):
        ask(do="run", calls=2)
        return ask(do="view", variables=[variable], points=10)["values"][0][0]

    setup = {"connections": wires, "step": 1.0, "exchange": "sequential"}
    # Nothing of the first page runs any more.
    page.evaluate("async () => { (await moduleOf('tool/store.js')).store.live = {}; }")
    ask(do="start", members=members(20.0, {"CYCLE": 1.0}), **setup)
    assert first() == 20
    # Another temperature of the plant for the same test: what the chain begins with follows, and is no setting of the user.
    assert "Y_START" not in ask(do="events")["setup"]["members"][2]["values"]
    ask(do="same_test", values={"PLANT.T_START": 35.0})
    assert first() == 35
    description = base64.b64decode(ask(do="export", what="description")["content"]).decode()
    assert '"SENSOR.Y_START" = 35.0' in description
    # What the user sets stays.
    ask(do="start", members=members(20.0, {"CYCLE": 1.0, "Y_START": 7.0}), **setup)
    assert first() == 7
    ask(do="same_test", values={"PLANT.T_START": 35.0})
    assert first() == 7


def test_a_ramp_moves_the_setpoint_evenly(tool, run_described):
    run_calls(tool, 5)
    tool.locator("#setpoint").fill("50")
    tool.locator("#ramp-time").fill("20")
    tool.get_by_role("button", name="Ramp").click()
    run_calls(tool, 30)
    setpoints = [number(value) for value in assert_same_bits(tool, run_described)["TIC101.SP_INT"]]
    steps = [later - earlier for earlier, later in zip(setpoints, setpoints[1:]) if later != earlier]
    assert setpoints[4] == 0 and setpoints[-1] == 50
    assert len(steps) == 20 and steps == pytest.approx([2.5] * 20)
    show_tab(tool, "Log")
    assert "moved to 50" in tool.locator("#done").inner_text()


def test_what_was_done_is_a_list_that_repeats_to_the_same_bits_with_what_was_sent_last(tool):
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 30)
    set_now(tool, "setpoint", 40)
    run_calls(tool, 30)
    _, first = saved(tool, "CSV of everything")
    show_tab(tool, "Log")
    assert "SP_INT 40" in tool.locator("#done .done-list").inner_text()
    tool.locator("#field-GAIN").fill("3.5")
    tool.locator("#field-GAIN").press("Enter")
    tool.locator("#done").get_by_role("button", name="Repeat exactly").click()
    wait_for_runs(tool, 2)
    _, second = saved(tool, "CSV of everything")
    assert second == first
    assert tool.locator("#field-GAIN").input_value() == "3.5"


def test_what_is_typed_is_part_of_the_values_with_which_to_run_again(tool):
    again = tool.get_by_role("button", name="Run again with these values")
    field = tool.locator("#field-GAIN")
    field.fill("0.5")
    # There is no run yet to be made again.
    assert again.is_hidden()
    field.press("Escape")
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 30)
    assert again.is_hidden() and "primary" in tool.locator("#run-go").get_attribute("class")
    field.fill("0.5")
    again.wait_for()
    assert "primary" not in (tool.locator("#run-go").get_attribute("class") or "")
    field.press("Escape")
    again.wait_for(state="hidden")
    field.fill("0.5")
    again.click()
    again.wait_for(state="hidden")
    values = tool.evaluate("async () => (await moduleOf('tool/store.js')).store.state.values")
    assert made(tool) == 30 and values["TIC101.GAIN"] == 0.5


def test_the_field_of_a_disturbance_shows_the_value_that_acts(tool):
    shown = lambda value: tool.wait_for_function(
        "value => document.querySelector('#disturbance').value === value", arg=value, timeout=5000
    )
    manual(tool).uncheck()
    run_calls(tool, 10)
    # The button takes the focus; no call has been made with it yet.
    tool.locator("#disturbance").fill("5")
    tool.get_by_role("button", name="Disturb", exact=True).click()
    tool.locator("#done").get_by_text("LOAD").first.wait_for(state="attached")
    shown("5")
    run_calls(tool, 10)
    shown("5")
    # What is set elsewhere, too.
    tool.evaluate("""async () => {
        const { store } = await moduleOf('tool/store.js');
        const { ask } = await moduleOf('tool/engine.js');
        await store.take(ask({ do: 'force', act: 'force', values: { 'PLANT.LOAD': 7 } }));
    }""")
    run_calls(tool, 10)
    shown("7")


def test_the_same_test_has_the_stimuli_of_before_and_the_settings_of_now(tool, run_described):
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 30)
    set_now(tool, "setpoint", 40)
    set_now(tool, "disturbance", 5)
    run_calls(tool, 30)
    tool.locator("#field-GAIN").fill("0.5")
    tool.locator("#field-GAIN").press("Enter")
    show_tab(tool, "Runs")
    tool.locator("#runs").get_by_role("button", name="Same test").click()
    wait_for_runs(tool, 2)
    assert made(tool) == 60
    assert tool.locator("#field-GAIN").input_value() == "0.5"
    table = assert_same_bits(tool, run_described)
    assert [number(table["TIC101.SP_INT"][call]) for call in (0, 29, 30)] == [60, 60, 40]
    assert [number(table["PLANT.LOAD"][call]) for call in (29, 30)] == [0, 5]
    assert {number(value) for value in table["TIC101.GAIN"]} == {0.5}
    names = tool.locator("#runs tbody tr").evaluate_all("rows => rows.map(row => row.cells[1].innerText)")
    assert names == ["GAIN 2", "GAIN 0.5"]
    # A disturbance belongs to its run: the next one begins without it.
    tool.get_by_role("button", name="Reset", exact=True).click()
    tool.wait_for_function("() => Number(document.querySelector('#disturbance').value) === 0")
    begins = tool.evaluate("async () => (await moduleOf('tool/store.js')).store.setup().members[1].values")
    assert begins.get("LOAD", 0) == 0


def test_an_applied_setting_is_tried_with_one_button_and_drawn_while_it_is_typed(tool, run_described):
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 40)
    again = tool.get_by_role("button", name="Run again with these values")
    assert again.is_hidden()
    tool.locator("#field-GAIN").fill("0.5")
    ghost = "async () => (await moduleOf('tool/store.js')).store.ghost?.curves.values[0]"
    typed = next(filter(None, (tool.evaluate(ghost) for _ in range(10_000))))
    # The dashed curve has a name, and figures of its own.
    tool.locator(".earlier .ghost").get_by_text(re.compile(r"^GAIN 0\.5: .*IAE [\d.]+")).wait_for()
    # Nothing has happened to the run.
    assert made(tool) == 40 and tool.evaluate("async () => (await moduleOf('tool/store.js')).store.loop.runs.length") == 1
    tool.locator("#field-GAIN").press("Enter")
    again.wait_for()
    assert tool.locator("#run-go").inner_text() == "Resume"
    # It stays until the run is made.
    assert tool.evaluate(ghost) == typed
    again.click()
    wait_for_runs(tool, 2)
    assert tool.evaluate(ghost) is None
    assert made(tool) == 40 and again.is_hidden() and tool.locator("#run-go").inner_text() == "Run"
    table = assert_same_bits(tool, run_described)
    assert {number(value) for value in table["TIC101.GAIN"]} == {0.5}
    assert [number(value) for value in table["TIC101.PV"]] == typed
    # What is typed and not applied is one of "these values", too.
    tool.locator("#field-GAIN").fill("0.75")
    tool.locator("#field-GAIN").press("Enter")
    again.wait_for()
    tool.locator("#field-GAIN").fill("0.25")
    again.click()
    wait_for_runs(tool, 3)
    until(tool, "async () => (await moduleOf('tool/store.js')).store.loop.settings.GAIN.sent === 0.25")
    # Run does not leave it out either; the run is then named by all that it had, one after the other.
    tool.locator("#field-GAIN").fill("0.125")
    run_calls(tool, 5)
    until(tool, "async () => (await moduleOf('tool/store.js')).store.loop.settings.GAIN.sent === 0.125")
    show_tab(tool, "Runs")
    names = tool.locator("#runs tbody tr").evaluate_all("rows => rows.map(row => row.cells[1].innerText)")
    assert names == ["GAIN 2", "GAIN 0.5", "GAIN 0.25, then 0.125"]
    # A text that is no value is not passed over: nothing runs.
    tool.locator("#field-GAIN").fill("fast")
    tool.locator("#run-go").click()
    tool.get_by_text("GAIN cannot be applied. Correct the value, or discard it with Esc.").wait_for()
    assert made(tool) == 45


def test_a_saved_description_opens_again_with_the_same_bits(open_tool, tool, tmp_path):
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 30)
    set_now(tool, "setpoint", 40)
    run_calls(tool, 30)
    values = "async () => (await moduleOf('tool/store.js')).store.state.values"
    name, description = saved(tool, "Save as TOML")
    (tmp_path / name).write_bytes(description)
    page = open_tool()
    page.locator("#open-files").set_input_files(tmp_path / name)
    wait_for_calls(page, 60)
    assert page.locator("#what strong").inner_text() == "TIC101"
    assert page.evaluate(values) == tool.evaluate(values)
    (tmp_path / "program.toml").write_text('[fmus]\nA = { sources = ["tank.scl"], cycle = "500ms" }\n')
    page.locator("#open-button").click()
    page.locator("#open-files").set_input_files(tmp_path / "program.toml")
    refused = page.locator("#loops .is-refused")
    refused.get_by_text("A is a program: drop tank.scl together with this description.").wait_for()


def wait_for_runs(page, count):
    """Waits until the list of runs has so many."""
    runs = "async count => (await moduleOf('tool/store.js')).store.loop.notes.runs?.length === count"
    page.wait_for_function(runs, arg=count)
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_the_clock_is_kept(tool):
    """At x1 each call is made when the wall clock, here that of the test, says so: nothing adds up in five minutes."""
    tool.get_by_role("button", name="×1", exact=True).click()
    tool.clock.install()
    tool.get_by_role("button", name="Run", exact=True).click()
    tool.locator("#run").get_by_role("button", name="Pause").wait_for()
    tool.clock.run_for(1_000)
    first = made(tool)
    # Steps that are no multiple of the frames, of the cycle or of each other.
    for milliseconds in (59_500, 33_250, 207_000):
        tool.clock.run_for(milliseconds)
    assert made(tool) - first in (299, 300)
    tool.clock.resume()
    tool.get_by_role("button", name="Pause").click()


def test_as_fast_as_it_goes_the_page_still_answers(tool):
    """While calls are made without a pause, a frame is drawn between few of them, and Pause is obeyed."""
    tool.get_by_role("button", name="max").click()
    tool.locator("#run-for").fill("5000000")
    tool.get_by_role("button", name="Run", exact=True).click()
    wait_for_calls(tool, 5000)
    tool.evaluate("async () => { for (let frame = 0; frame < 20; frame += 1) await new Promise(requestAnimationFrame); }")
    tool.get_by_role("button", name="Pause").click()
    tool.get_by_role("button", name="Run", exact=True).wait_for()
    paused = made(tool)
    assert 5000 <= paused < 5_000_000
    tool.evaluate("async () => { for (let frame = 0; frame < 20; frame += 1) await new Promise(requestAnimationFrame); }")
    assert made(tool) == paused


def test_the_curves_can_be_read_by_keys(tool):
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 40)
    cursor = tool.locator("#curves").get_by_role("slider")
    cursor.focus()
    tool.keyboard.press("Home")
    assert cursor.get_attribute("aria-valuenow") == "0"
    tool.keyboard.press("ArrowRight")
    tool.keyboard.press("ArrowRight")
    _, table = saved(tool, "CSV of everything")
    table = recorded(table.decode())
    assert float(cursor.get_attribute("aria-valuenow")) == float(table["time"][2])
    assert host.real(float(readout(tool)["LMN"])) == number(table["TIC101.LMN"][2])
    assert "SP_INT 60" in cursor.get_attribute("aria-valuetext")
    cursor.focus()
    tool.keyboard.press("+")
    assert tool.get_by_role("button", name="Follow").get_attribute("aria-pressed") == "false"
    tool.keyboard.press("Escape")
    assert tool.get_by_role("button", name="Follow").get_attribute("aria-pressed") == "true"
    assert made(tool) == 40


def test_values_are_those_of_now_once_the_pointer_has_left_the_curves(tool):
    run_calls(tool, 30)
    now = readout(tool)
    over = tool.locator("#curves .u-over").bounding_box()
    tool.mouse.move(over["x"] + over["width"] * 0.3, over["y"] + over["height"] / 2)
    tool.locator("#curves .readout").get_by_text(re.compile(r"at [\d.]+ s")).wait_for()
    tool.locator("#run-go").hover()
    tool.locator("#curves .readout").get_by_text(re.compile(r"at [\d.]+ s")).wait_for(state="detached")
    assert readout(tool) == now


@pytest.mark.parametrize(("block", "plant"), [("CONT_C", "TANK"), ("CONT_S", "VALVE"), ("HLG", "DRIVE")])
def test_a_step_test_is_offered_to_a_loop_that_can_make_one_and_to_no_other(open_tool, block, plant):
    page = open_tool()
    new_loop(page, "LOOP", block)
    page.locator(".no-run").get_by_role("button", name=plant).click()
    page.locator(".no-run").get_by_text("Ready: run the loop").wait_for()
    is_tunable = block != "HLG"
    assert page.get_by_role("button", name="Run a step test").count() == is_tunable
    ready = "Ready: run the loop, or run a step test to tune it." if is_tunable else "Ready: run the loop."
    assert page.locator(".no-run p").inner_text() == ready


def test_dragging_zooms_and_a_double_click_follows_again(tool):
    run_calls(tool, 60)
    follow = tool.get_by_role("button", name="Follow")
    plot = tool.locator("#curves .u-over").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    middle = box["y"] + box["height"] / 3
    tool.mouse.move(box["x"] + 20, middle)
    tool.mouse.down()
    tool.mouse.move(box["x"] + 80, middle, steps=4)
    tool.mouse.up()
    tool.locator("#curves .curves-bar button[aria-pressed=false]").wait_for()
    slider = tool.locator("#curves").get_by_role("slider")
    tool.wait_for_function("() => document.querySelector('#curves [role=slider]').ariaValueMin > 0")
    # What is asked for is what is to be seen, and every call of it.
    assert 0 < float(slider.get_attribute("aria-valuemin")) < float(slider.get_attribute("aria-valuemax")) < 59
    plot.dblclick()
    tool.locator("#curves .curves-bar button[aria-pressed=true]").wait_for()
    assert follow.is_visible()


def test_earlier_runs_stay_in_the_list_with_name_and_colour_through_a_reload(tool):
    run_calls(tool, 20)
    for count in (2, 3):
        tool.get_by_role("button", name="Reset").click()
        run_calls(tool, 20, fresh=True)
        wait_for_runs(tool, count)
    show_tab(tool, "Runs")
    tool.get_by_label("Name of Run 1").fill("before")
    tool.get_by_label("Name of Run 1").press("Enter")
    tool.get_by_label("Show Run 2").uncheck()
    kept = "() => JSON.parse(sessionStorage.getItem('plcfmu'))?.loops[0].notes.runs?.map(run => [run.name, run.isShown])"
    tool.evaluate("() => dispatchEvent(new Event('pagehide'))")
    expected = [["before", True], ["Run 2", False], ["Run 3", True]]
    assert tool.evaluate(kept) == expected
    tool.reload()
    tool.locator("#runs tbody tr").nth(2).wait_for()
    rows = tool.locator("#runs tbody tr")
    shown = "rows => rows.map(row => [row.querySelector('.run-name').value, row.querySelector('[type=checkbox]').checked])"
    assert rows.evaluate_all(shown) == expected


def test_a_curve_of_choice_is_added_hidden_and_removed(tool):
    run_calls(tool, 10)
    adding = tool.locator("select", has=tool.locator("option", has_text="Add a curve"))
    adding.select_option("TIC101.LMN_P")
    adding.select_option("TIC101.QLMN_HLM")
    assert {"LMN_P", "QLMN_HLM"} <= set(readout(tool))
    button = tool.locator("#curves .readout").get_by_role("button", name="LMN_P", exact=True)
    assert button.get_attribute("aria-pressed") == "true"
    button.click()
    button = tool.locator("#curves .readout").get_by_role("button", name="LMN_P", exact=True)
    assert button.get_attribute("aria-pressed") == "false"
    tool.get_by_role("button", name="Remove TIC101.LMN_P").click()
    tool.wait_for_function("() => !document.querySelector('#curves .readout').innerText.includes('LMN_P')")


def test_figures_are_there_with_units_or_with_a_reason(tool):
    set_now(tool, "setpoint", 60)
    run_calls(tool, 3)
    show_tab(tool, "Runs")
    tool.locator("#figures .remarks li").first.wait_for()
    manual(tool).uncheck()
    run_calls(tool, 400)
    figures = tool.locator("#figures")
    tool.wait_for_function("() => /IAE\\s*[0-9]/.test(document.querySelector('#figures').innerText)")
    assert re.search(r"IAE\s*[\d.]+", figures.inner_text()), figures.inner_text()
    assert re.search(r"Travel\s*[\d.]+ %", figures.inner_text()), figures.inner_text()


def identify_from_a_step(page, calls=200, cycle=1.0, rest=10):
    """Rest in manual, a step of the manual value, until the process value rests again; then identify."""
    manual(page).check()
    run_calls(page, rest, cycle)
    set_now(page, "MAN", 40)
    run_calls(page, calls, cycle)
    show_tab(page, "Tune")
    page.get_by_role("button", name="Identify from this step").click()
    page.locator("#tune .fit").get_by_text("fit").wait_for()


def settings_of_rule(page):
    """The rule's settings as they are written, by name."""
    rows = page.locator("#tune .tuned > :first-child tbody tr")
    return dict(rows.evaluate_all("rows => rows.map(row => [row.cells[0].innerText, row.cells[2].title])"))


def test_tuning_without_a_step_says_why(tool):
    show_tab(tool, "Tune")
    tool.get_by_role("button", name="Identify from this step").click()
    assert "There is no run yet" in tool.locator("#tune").inner_text()
    run_calls(tool, 10)
    tool.get_by_role("button", name="Identify from this step").click()
    tool.locator("#tune .error").wait_for()
    assert len(tool.locator("#tune .error").inner_text()) > 20


def test_a_step_gives_the_plant_and_a_rule_its_settings(tool):
    identify_from_a_step(tool)
    gain, lag, dead_time = (
        float(tool.locator(f"#model-{name}").input_value()) for name in ("gain", "time_constant", "dead_time")
    )
    assert gain == pytest.approx(2, rel=0.01)
    assert lag == pytest.approx(20, rel=0.03)
    assert dead_time == pytest.approx(2, abs=1)
    tune = tool.locator("#tune")
    tune.get_by_label("PI", exact=True).check()
    tune.get_by_role("button", name="AMIGO").click()
    tune.locator(".tuned").wait_for()
    rows = settings_of_rule(tool)
    assert float(rows["GAIN"]) > 0 and rows["I_SEL"] == "true" and rows["D_SEL"] == "false"
    assert re.search(r"Ms\s*1\.\d", tune.inner_text())
    assert tune.locator("p.row .faint").inner_text() == ""
    tune.get_by_role("button", name="Apply").first.click()
    tune.locator("p.row").get_by_text("in force", exact=True).wait_for()
    assert tool.evaluate("async () => (await moduleOf('tool/store.js')).store.loop.settings.GAIN.sent") == pytest.approx(
        float(rows["GAIN"]), rel=1e-3
    )


def test_a_csv_of_the_plant_gives_the_same_model_as_the_run(tool, tmp_path):
    identify_from_a_step(tool)
    names = ("gain", "time_constant", "dead_time")
    of_run = [float(tool.locator(f"#model-{name}").input_value()) for name in names]
    _, table = saved(tool, "CSV of everything")
    columns = recorded(table.decode())
    chosen = zip(columns["time"], columns["TIC101.LMN"], columns["TIC101.PV"])
    rows = ["when;out;measured", *(";".join(row).replace(".", ",") for row in chosen)]
    path = tmp_path / "step.csv"
    path.write_text("\n".join(rows))
    tool.locator("#tune-file").set_input_files(path)
    for name, column in (("time", "when"), ("input", "out"), ("output", "measured")):
        tool.locator(f"#tune-{name}").select_option(column)
    tool.locator("#tune .fit").get_by_text("fit").wait_for()
    assert [float(tool.locator(f"#model-{name}").input_value()) for name in names] == pytest.approx(of_run, rel=1e-3)


def test_a_csv_of_a_recorder_is_identified_by_its_names_and_its_columns_can_be_chosen(tool, tmp_path):
    """As a recorder in Germany writes it: a title, units in the header, semicolons, decimal commas, dates."""
    rows = ["Recorder 7", "Datum/Uhrzeit;Sollwert [°C];Istwert [°C];Stellwert [%]"]
    for second in range(300):
        value = 20 + (0 if second < 62 else 16 * (1 - math.exp(-(second - 62) / 30)))
        row = f"04.03.2026 10:{second // 60:02}:{second % 60:02};50.0;{value:.4f};{30.0 if second < 60 else 40.0:.1f}"
        rows.append(row[:10] + row[10:].replace(".", ","))
    path = tmp_path / "recorder.csv"
    path.write_bytes("\r\n".join(rows).encode("cp1252"))
    # Dropped on the page, the file is offered, too.
    tool.locator("#open-files").set_input_files(path)
    show_tab(tool, "Tune")
    tune = tool.locator("#tune")
    for name, column in (("input", "Stellwert [%]"), ("output", "Istwert [°C]"), ("time", "Datum/Uhrzeit")):
        tool.locator(f"#tune-{name}").select_option(column)
        tune.get_by_text("The manipulated value is Stellwert [%], the process value Istwert [°C].").wait_for()
    values = [float(tool.locator(f"#model-{name}").input_value()) for name in ("gain", "time_constant", "dead_time")]
    assert values == pytest.approx([1.6, 30, 2], rel=0.02)
    assert tune.locator(".error").count() == 0


def test_from_a_db_file_to_a_tuned_awl_and_preset(open_tool, run_described, command, tmp_path):
    """The order of work of a user: open, plant, step in manual, identify, rule, apply, send, judge, take away."""
    page = open_tool()
    page.locator("#open-files").set_input_files(LOOPS)
    page.get_by_role("button", name="TIC105", exact=True).click()
    take_generic_plant(page, "0.5", "60", "5")
    identify_from_a_step(page, 600, 1.063, rest=700)
    page.locator("#tune").get_by_role("button", name="Apply").first.click()
    page.locator("#tune p.row").get_by_text("in force", exact=True).wait_for()
    rows = settings_of_rule(page)
    set_now(page, "setpoint", 30)
    automatic(page)
    run_calls(page, 300, 1.063)
    assert_same_bits(page, run_described)
    page.locator("#away-button").click()
    page.get_by_label("Format of the parameter file").select_option("awl")
    page.keyboard.press("Escape")
    name, awl = saved(page, "Save parameters")
    assert name.endswith(".awl")
    gain = re.search(r"\bGAIN := ([\d.e+-]+);", awl.decode())
    assert float(gain[1]) == pytest.approx(float(rows["GAIN"]), rel=1e-6)
    # The preset that the page makes of the block's FMU is the one that `plcfmu preset` makes of it.
    name, preset = preset_of(page, host.FOLDER / "CONT_C.fmu")
    assert name == "TIC105.fmu"
    (tmp_path / "page.fmu").write_bytes(preset)
    (tmp_path / "tuned.awl").write_bytes(awl)
    given = [command, "preset", "tuned.awl", "--fmus", host.FOLDER / "CONT_C.fmu", "--out", "command.fmu"]
    assert_success(given, tmp_path)
    of_page, of_command = (contents(tmp_path / file) for file in ("page.fmu", "command.fmu"))
    assert sorted(of_page) == sorted(of_command)
    # The documentation names the files that the values come from; a parameter file has no stimuli: setpoint and manual value.
    differing = {path for path in of_page if of_page[path] != of_command[path]}
    assert differing == {"documentation/index.html", "modelDescription.xml", "resources/start.txt"}
    starts = [
        {line for line in of["resources/start.txt"].decode().splitlines() if "=" in line} for of in (of_page, of_command)
    ]
    assert {line.split("=")[0].strip() for line in starts[0] ^ starts[1]} == {"MAN", "SP_INT"}
    assert_success([command, "check", "--run", "page.fmu"], tmp_path)


def test_a_preset_is_made_of_the_right_fmu_only(tool, tmp_path):
    for file, reason in (
        (host.FOLDER / "PULSEGEN.fmu", "PULSEGEN.fmu: it is an FMU for PULSEGEN, not for CONT_C"),
        (LOOPS, "plant.awl: it is not a ZIP archive"),
    ):
        tool.locator("#preset-fmu").set_input_files(file)
        tool.get_by_text(reason).wait_for()
    old = tmp_path / "CONT_C.fmu"
    with zipfile.ZipFile(host.FOLDER / "CONT_C.fmu") as archive, zipfile.ZipFile(old, "w") as written:
        guid = re.search(rb'guid="([^"]+)"', archive.read("modelDescription.xml"))[1]
        other = b"{00000000" + guid[9:]
        for path in archive.namelist():
            written.writestr(path, archive.read(path).replace(guid, other))
    tool.locator("#preset-fmu").set_input_files(old)
    tool.get_by_text("use an FMU and a page from the same release").wait_for()


def preset_of(page, fmu):
    """The preset that the page makes of an FMU: name and bytes."""
    with page.expect_download() as download:
        page.locator("#preset-fmu").set_input_files(fmu)
    return download.value.suggested_filename, pathlib.Path(download.value.path()).read_bytes()


def contents(path):
    """The files of an archive, whose sums Python checks."""
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


def assert_success(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_downloads_have_proper_names_and_contents(tool):
    run_calls(tool, 20)
    for button, name, begin in (
        ("CSV of the curves", r"TIC101\.csv", b"time"),
        ("CSV of everything", r"TIC101_all\.csv", b"time"),
        ("Save as TOML", r".*\.toml", b""),
        ("Report (HTML)", r".*\.html", b"<!DOCTYPE html>"),
        ("Picture (SVG)", r"TIC101\.svg", b"<svg "),
        ("Picture (PNG)", r"TIC101\.png", b"\x89PNG"),
    ):
        got, content = saved(tool, button)
        assert re.fullmatch(name, got), got
        assert content.startswith(begin), got


# A test of its own: Chromium lets a page save ten files, and then one a second.
def test_parameters_are_saved_in_every_format(tool):
    for form in ("awl", "db", "xml", "json", "ssv"):
        tool.get_by_label("Format of the parameter file").select_option(form, force=True)
        got, content = saved(tool, "Save parameters")
        assert got.endswith(f".{form}") and b"GAIN" in content


def test_a_million_calls_do_not_grow_the_memory(tool):
    """The recording is bounded: the engine's memory and the page's after a million calls are those of 300 000."""
    session = tool.context.new_cdp_session(tool)
    session.send("Performance.enable")

    def memory():
        tool.evaluate("() => globalThis.gc?.()")
        metrics = {metric["name"]: metric["value"] for metric in session.send("Performance.getMetrics")["metrics"]}
        engine = tool.evaluate("async () => (await moduleOf('tool/engine.js')).memory()")
        return engine, metrics["JSHeapUsedSize"]

    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 300_000)
    engine, heap = memory()
    run_calls(tool, 700_000)
    later_engine, later_heap = memory()
    assert later_engine <= engine * 1.05 + 2**20, (engine, later_engine)
    assert later_heap <= heap + 8 * 2**20, (heap, later_heap)


def test_everything_goes_by_keyboard_alone(open_tool):
    page = open_tool()
    new_loop(page, "TIC101")
    page.locator("#tab-plant").press("Enter")
    page.locator("#generic-GAIN").focus()
    page.keyboard.press("Enter")
    page.get_by_text("goes to").first.wait_for()
    page.locator("#curves").get_by_role("slider").focus()
    page.keyboard.press("m")
    page.keyboard.press(".")
    wait_for_calls(page, 1)
    assert not manual(page).is_checked()
    page.keyboard.press(" ")
    wait_for_calls(page, 2)
    page.keyboard.press(" ")
    calls = made(page)
    assert page.get_by_role("button", name="Run", exact=True).is_visible()
    page.locator("#setpoint").focus()
    page.keyboard.press("Control+A")
    page.keyboard.type("42")
    page.keyboard.press("Enter")
    page.locator("#curves").get_by_role("slider").focus()
    page.keyboard.press(".")
    wait_for_calls(page, calls + 1)
    # The curves are drawn in the next frame; the first call is at 0 s, CYCLE is 1 s.
    page.wait_for_function("time => document.querySelector('#curves [role=slider]').ariaValueMax >= time", arg=calls)
    page.keyboard.press("End")
    assert "SP_INT 42" in page.locator("#curves").get_by_role("slider").get_attribute("aria-valuetext")


@pytest.mark.parametrize("scheme", ("light", "dark"))
@pytest.mark.parametrize("size", (DESKTOP, PHONE), ids=("desktop", "phone"))
def test_panels_have_no_accessibility_findings(open_tool, size, scheme):
    from axe_playwright_python.sync_playwright import Axe

    page = open_tool(size, scheme)
    new_loop(page, "TIC101")
    take_generic_plant(page, "2", "20", "2")
    if size == PHONE:
        page.get_by_role("button", name="More").click()
    set_now(page, "setpoint", 60)
    identify_from_a_step(page)
    manual(page).uncheck()
    run_calls(page, 100)
    show_tab(page, "Runs")
    page.locator("#runs").get_by_role("button", name="Repeat exactly").click()
    wait_for_runs(page, 2)
    screenshot(page, f"run-{size[0]}-{scheme}")
    found = Axe().run(page).response["violations"]
    assert found == [], json.dumps(found, indent=1)[:4000]
