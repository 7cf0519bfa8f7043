"""The timing diagram of a program, its watch table, what is forced, and a session that becomes a test."""

import math
import re
import shutil
import subprocess

from test_tool_program import COUNTER, LAPTOP, PROGRAMS, drop, line, set_input
from test_tool_run import PHONE, made, open_tool, run_calls, saved, screenshot, wait_for_calls
from test_tool_run import browser, pytestmark  # noqa: F401
from tool import show_tab, until

# Its lamp is TRUE in every other call, from the second one after `on` was set.
BLINK = """FUNCTION_BLOCK "Blink"
VAR_INPUT on : Bool; END_VAR
VAR_OUTPUT
  lamp : Bool;
  step : Int;
  level : Real;   // unit: %
  mask : Word;
END_VAR
VAR CONSTANT IDLE : Int := 0; LIT : Int := 1; END_VAR
BEGIN
  CASE #step OF
    #IDLE:
      IF #on THEN #step := #LIT; END_IF;
    #LIT:   // the comment of a constant is not its name
      #lamp := NOT #lamp;
      #level := #level + 1.5;
      IF NOT #on THEN #step := 2; #mask := 16#8001; END_IF;
    2:   // done
      #lamp := FALSE;
  END_CASE;
END_FUNCTION_BLOCK
"""
VALUES = "async () => (await moduleOf('tool/store.js')).store.state.values"
STATE = "async () => (await moduleOf('tool/store.js')).store.state"


def label(page, name):
    return page.locator(f'.timing [data-signal="{name}"]')


def value(page, name):
    return label(page, name).locator(".value").inner_text()


def lane(page, name):
    """The plot of a lane."""
    return page.locator(f'.timing-row:has([data-signal="{name}"]) .timing-plot')


def one_cycle(page, times=1):
    before = made(page)
    for _ in range(times):
        page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, before + times)


def drawn(page):
    """Waits until what the engine has is drawn."""
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_edges_stand_exactly_at_the_calls_in_which_they_happened(open_tool):
    # Wide enough for the name of a step that lasts 0.3 s.
    page = open_tool((1920, 900))
    drop(page, ("blink.scl", BLINK))
    set_input(page, "on", False)
    one_cycle(page, 3)
    set_input(page, "on", True)
    one_cycle(page, 3)
    stroke = lane(page, "Blink.lamp").locator(".stroke")
    stroke.wait_for()
    page.wait_for_function("() => document.querySelectorAll('[data-signal=\"Blink.step\"]').length === 1")
    page.wait_for_function("""() => /V4/.test(document.querySelector('.timing-row:has([data-signal="Blink.lamp"]) .stroke').getAttribute('d'))""")
    # 20 cycles of 0.1 s are the least that is shown. The step is 1 from call 3 on, the lamp TRUE in call 4, FALSE in call 5.
    width = float(lane(page, "Blink.lamp").get_attribute("width"))
    path = re.findall(r"([MVH])([\d.]+)", stroke.get_attribute("d"))
    ends = [float(at) for letter, at in path if letter == "H"]
    assert [round(end / width * 2.0, 2) for end in ends] == [0.4, 0.5, 0.6]
    assert [at for letter, at in path if letter == "V"] == ["4", "17"]
    texts = lane(page, "Blink.step").locator("text").all_text_contents()
    assert texts == ["0 IDLE", "1 LIT"]
    assert value(page, "Blink.step") == "1 LIT" and value(page, "Blink.lamp") == "FALSE"
    # A number without a constant has the comment after it; bit strings are hexadecimal.
    set_input(page, "on", False)
    one_cycle(page, 1)
    page.wait_for_function("() => document.querySelector('[data-signal=\"Blink.step\"] .value').textContent === '2 done'")
    assert value(page, "Blink.mask") == "16#8001"
    # 1.5 % in each of the calls 4, 5 and 6.
    assert value(page, "Blink.level") == "4.5"
    assert page.locator(".timing-row.is-panel .timing-unit").inner_text() == "%"
    screenshot(page, "diagram-blink")


def test_a_lane_that_is_denser_than_pixels_is_a_band_that_says_how_many_changes(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("blink.scl", BLINK))
    set_input(page, "on", True)
    run_calls(page, 1000, 0.1)
    band = lane(page, "Blink.lamp").locator(".dense")
    band.wait_for()
    # The first call lights nothing; in each of the other 999 the lamp changes.
    page.wait_for_function("""() => document.querySelector('.timing-row:has([data-signal="Blink.lamp"]) text')?.textContent === '999 changes'""")
    # Nearer by, each change is drawn.
    for _ in range(6):
        page.get_by_role("button", name="+", exact=True).click()
    lane(page, "Blink.lamp").locator(".high").wait_for()
    assert band.count() == 0


def test_the_cursor_shows_its_values_in_the_diagram_at_the_inputs_and_in_the_source(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("blink.scl", BLINK))
    set_input(page, "on", False)
    one_cycle(page, 3)
    set_input(page, "on", True)
    one_cycle(page, 4)
    slider = page.get_by_role("slider", name="Cursor in the timing diagram")
    slider.focus()
    page.keyboard.press("Home")
    moment = page.locator(".timing-moment")
    page.wait_for_function("() => document.querySelector('[data-input=\"on\"] .at-moment')?.textContent === 'FALSE at 0 s'")
    assert moment.inner_text() == "at 0 s" and value(page, "Blink.step") == "0 IDLE"
    assert line(page, 13).locator(".values").get_by_text("FALSE").count() == 1
    # To the next change of a lane or a step, then a call on.
    page.keyboard.press("PageDown")
    page.wait_for_function("() => document.querySelector('.timing-moment').textContent === 'at 0.3 s'")
    page.keyboard.press("ArrowRight")
    page.wait_for_function("() => document.querySelector('[data-signal=\"Blink.lamp\"] .value').textContent === 'TRUE'")
    assert moment.inner_text() == "at 0.4 s" and value(page, "Blink.step") == "1 LIT" and value(page, "Blink.level") == "1.5"
    page.wait_for_function("() => document.querySelector('.program [data-line=\"16\"] .values').textContent.includes('1.5')")
    # The lines are those that ran in that call: what lights the lamp, and nothing of the step before.
    page.locator('.program [data-line="15"].has-run').wait_for()
    assert "has-run" not in line(page, 13).get_attribute("class")
    screenshot(page, "diagram-cursor")
    page.keyboard.press("Escape")
    page.wait_for_function("() => document.querySelector('.timing-moment').textContent === ''")
    assert value(page, "Blink.level") == "4.5" and page.locator('[data-input="on"] .at-moment').is_hidden()
    # The pointer does the same, and a click leaves the cursor where it is.
    box = lane(page, "Blink.lamp").bounding_box()
    page.mouse.move(box["x"] + box["width"] * 0.45 / 2.0, box["y"] + 5)
    page.wait_for_function("() => document.querySelector('.timing-moment').textContent === 'at 0.4 s'")
    page.mouse.down()
    page.mouse.up()
    page.mouse.move(box["x"] + 10, box["y"] - 60)
    assert moment.inner_text() == "at 0.4 s"
    # A drag zooms.
    page.mouse.move(box["x"] + box["width"] * 0.2, box["y"] + 5)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.3, box["y"] + 5, steps=4)
    page.mouse.up()
    part = page.evaluate("async () => (await moduleOf('tool/moment.js')).range()")
    assert math.isclose(part[0], 0.4, abs_tol=0.01) and math.isclose(part[1], 0.6, abs_tol=0.01)


def test_signals_are_chosen_from_a_list_that_is_searched_and_the_choice_is_kept(open_tool):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "tank.scl")
    label(page, "TankFilling.inletValve").wait_for()
    # Inputs and outputs at first.
    assert page.locator(".timing-label").count() == 14
    page.locator(".signals-chooser > summary").click()
    search = page.get_by_role("searchbox", name="Search signals")
    search.fill("tfill.")
    choices = page.locator(".choices label")
    page.wait_for_function("() => document.querySelectorAll('.choices label').length === 10")
    choices.filter(has_text="tFill.Q").get_by_role("checkbox").check()
    label(page, "TankFilling.tFill.Q").wait_for()
    search.fill("inletValve")
    choices.filter(has_text="inletValve").get_by_role("checkbox").uncheck()
    label(page, "TankFilling.inletValve").wait_for(state="detached")
    search.fill("nothing has this")
    page.get_by_text("No signal has this text in its name or comment.").wait_for()
    page.keyboard.press("Escape")
    assert page.locator(".choices").is_hidden()
    page.wait_for_function("() => (sessionStorage.getItem('plcfmu') ?? '').includes('tFill.Q')")
    page.reload()
    label(page, "TankFilling.tFill.Q").wait_for()
    assert label(page, "TankFilling.inletValve").count() == 0
    # Below them stand steps of CASE with the names of their constants, and panels by unit.
    one_cycle(page)
    assert value(page, "TankFilling.step") == "0 IDLE" and value(page, "TankFilling.faultCode") == "16#0000"
    assert page.locator(".timing-unit").all_inner_texts() == ["%", "without a unit"]


def test_lanes_that_do_not_fit_are_scrolled_and_never_squeezed(open_tool):
    page = open_tool((1366, 600))
    outputs = " ".join(f"q{at} : Bool;" for at in range(40))
    source = f"FUNCTION_BLOCK Many VAR_OUTPUT {outputs} END_VAR BEGIN q0 := NOT q0; END_FUNCTION_BLOCK"
    drop(page, ("many.scl", source))
    one_cycle(page)
    rows = page.locator(".timing-row")
    assert rows.count() == 24
    assert {round(row.bounding_box()["height"]) for row in rows.all()} == {22}
    # The axis stands below what is scrolled.
    sizes = page.locator(".timing-rows").evaluate("one => [one.scrollHeight, one.clientHeight]")
    assert sizes[0] == 24 * 22 > sizes[1]
    assert page.locator(".timing-slider").bounding_box()["y"] < 600


def test_a_program_without_a_controller_has_no_setpoint_no_step_no_figures_and_no_tuning(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("counter.scl", COUNTER))
    one_cycle(page, 2)
    run = page.locator("#run")
    for name in ("Step", "Ramp"):
        assert run.get_by_role("button", name=name, exact=True).count() == 0
    assert run.locator("#setpoint").count() == 0 and page.locator("#glance").inner_text() == ""
    visible = [tab.inner_text() for tab in page.get_by_role("tab").all() if tab.is_visible()]
    assert visible == ["Program", "Watch", "Plant", "Runs", "Log"]
    show_tab(page, "Runs")
    assert page.locator("#figures").is_hidden()
    # One with a controller has all of it.
    other = open_tool(LAPTOP)
    drop(other, PROGRAMS / "tank.scl")
    other.locator("#setpoint").wait_for()
    assert other.get_by_role("tab", name="Replay").is_visible() and other.get_by_role("tab", name="Diagram").is_visible()


def test_the_diagram_stands_on_a_phone_and_in_the_dark(open_tool):
    for size, scheme in ((PHONE, "dark"), (PHONE, "light"), (LAPTOP, "dark")):
        page = open_tool(size, scheme)
        drop(page, PROGRAMS / "tank.scl", PROGRAMS / "tank_plant.scl")
        until(page, "async () => (await moduleOf('tool/store.js')).store.loop?.connections.length === 5")
        if size == PHONE:
            show_tab(page, "Parameters")
            page.get_by_role("button", name="More").click()
        page.locator('[data-input="start"] .push').wait_for()
        run_calls(page, 40, 0.5)
        page.locator('[data-input="start"] .push').click()
        run_calls(page, 300, 0.5)
        label(page, "TankFilling.pump").wait_for()
        drawn(page)
        screenshot(page, f"diagram-{size[0]}-{scheme}")


def test_an_output_is_forced_for_every_call_marked_wherever_it_is_shown_and_released_in_one_click(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("blink.scl", BLINK))
    set_input(page, "on", False)
    one_cycle(page, 2)
    show_tab(page, "Watch")
    for name in ("lamp", "step", "on"):
        page.get_by_label("Add a variable").fill(name)
        page.get_by_label("Add a variable").press("Enter")
    rows = page.locator("[data-watch]")
    page.locator('[data-watch="Blink.on"]').wait_for()
    assert rows.count() == 3
    lamp = page.locator('[data-watch="Blink.lamp"]')
    lamp.get_by_label("New value of lamp").select_option("TRUE")
    lamp.get_by_role("button", name="Force").click()
    header = page.locator("#what").get_by_role("button", name="1 forced")
    header.wait_for()
    one_cycle(page, 3)
    # IDLE lights nothing.
    assert page.evaluate(VALUES)["Blink.lamp"] is True
    assert "is-forced" in label(page, "Blink.lamp").get_attribute("class")
    # The bar begins at the call in which it was forced.
    width = float(lane(page, "Blink.lamp").get_attribute("width"))
    begin, end = map(float, re.findall(r"[MH]([\d.]+)", lane(page, "Blink.lamp").locator(".held").get_attribute("d")))
    assert [round(at / width * 2.0, 2) for at in (begin, end)] == [0.2, 0.5]
    # An input that is forced says so where it is set; set once is what a field does.
    on = page.locator('[data-watch="Blink.on"]')
    on.get_by_label("New value of on").select_option("TRUE")
    on.get_by_role("button", name="Force").click()
    page.locator('[data-input="on"] .at-moment').get_by_text("forced TRUE").wait_for()
    show_tab(page, "Program")
    one_cycle(page)
    line(page, 13).locator(".value.is-forced").get_by_text("TRUE").wait_for()
    assert page.evaluate(VALUES)["Blink.step"] == 1
    screenshot(page, "diagram-forced")
    page.locator("#what").get_by_role("button", name="2 forced").click()
    page.locator("#what").get_by_role("button", name="forced").wait_for(state="detached")
    # The program goes on from what was forced: the lamp changes in each call again.
    one_cycle(page)
    assert page.evaluate(VALUES)["Blink.lamp"] is False
    show_tab(page, "Watch")
    step = page.locator('[data-watch="Blink.step"]')
    step.get_by_label("New value of step").fill("2")
    step.get_by_role("button", name="Set", exact=True).click()
    one_cycle(page)
    page.wait_for_function("() => document.querySelector('[data-watch=\"Blink.step\"] .value').textContent === '2'")
    screenshot(page, "diagram-watch")


def test_what_is_forced_and_watched_survives_a_reload_and_goes_with_the_link(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("blink.scl", BLINK))
    set_input(page, "on", False)
    one_cycle(page, 2)
    show_tab(page, "Watch")
    page.get_by_label("Add a variable").fill("level")
    page.get_by_label("Add a variable").press("Enter")
    row = page.locator('[data-watch="Blink.level"]')
    row.get_by_label("New value of level").fill("12.5")
    row.get_by_role("button", name="Force").click()
    one_cycle(page, 2)
    page.wait_for_function("() => (sessionStorage.getItem('plcfmu') ?? '').includes('\"calls\":4')")
    page.reload()
    wait_for_calls(page, 4)
    row.locator(".value").get_by_text("12.5").wait_for()
    assert page.evaluate(STATE)["forced"] == {"Blink.level": 12.5}
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.locator("#away-button").click()
    page.get_by_role("button", name="Copy link").click()
    page.get_by_text("The link is on the clipboard").wait_for()
    link = page.evaluate("navigator.clipboard.readText()")
    other = open_tool(LAPTOP)
    other.goto(link)
    wait_for_calls(other, 4)
    show_tab(other, "Watch")
    other.locator('[data-watch="Blink.level"] .value').get_by_text("12.5").wait_for()
    # A new run begins with what is forced.
    other.get_by_role("button", name="Reset", exact=True).click()
    one_cycle(other)
    assert other.evaluate(VALUES)["Blink.level"] == 12.5


def run_case(command, folder, content):
    (folder / "recorded.toml").write_bytes(content)
    return subprocess.run([command, "test", "recorded.toml"], cwd=folder, capture_output=True, text=True)


def test_a_session_with_a_plant_becomes_a_test_that_plcfmu_test_runs(open_tool, command, tmp_path):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "tank.scl", PROGRAMS / "tank_plant.scl")
    until(page, "async () => (await moduleOf('tool/store.js')).store.loop?.connections.length === 5")
    start = page.locator('[data-input="start"] .push')
    start.wait_for()
    run_calls(page, 5, 0.5)
    start.click()
    run_calls(page, 400, 0.5)
    values = page.evaluate(VALUES)
    assert values["TankFilling.step"] == 40 and values["TankFilling.fillings"] == 1
    # Log, Save as test, Save.
    show_tab(page, "Log")
    page.get_by_role("button", name="Save as test").click()
    listed = page.locator(".test-steps li")
    listed.first.wait_for()
    assert listed.filter(has_text="set start TRUE").count() == 1
    assert listed.filter(has_text="expect").filter(has_text="fillings 1").count() == 1
    screenshot(page, "diagram-test")
    name, content = saved(page, "Save TankFilling_test.toml", "#done")
    for source in ("tank.scl", "tank_plant.scl"):
        shutil.copy(PROGRAMS / source, tmp_path)
    done = run_case(command, tmp_path, content)
    assert done.returncode == 0 and "what was recorded on the page: ok" in done.stdout, done.stdout + done.stderr + content.decode()
    # It fails if the program does something else: a tank that is full at 70 % is full earlier.
    source = tmp_path / "tank.scl"
    text = source.read_text()
    source.write_text(text.replace("levelFull : Real := 80.0", "levelFull : Real := 70.0"))
    done = run_case(command, tmp_path, content)
    assert done.returncode != 0 and re.search(r"(step|pump|inletValve|fillings) is .*, expected", done.stdout), done.stdout
    # With half the gain, only an analog output differs.
    source.write_text(text.replace("GAIN := -2.0", "GAIN := -1.0"))
    done = run_case(command, tmp_path, content)
    assert done.returncode != 0 and re.search(r"outlet is .*, expected", done.stdout), done.stdout
    # What is struck out is not expected.
    page.get_by_role("button", name="Keep none").click()
    _, none = saved(page, "Save TankFilling_test.toml", "#done")
    assert b"expect" not in none and b"set" in none
    assert run_case(command, tmp_path, none).returncode == 0


def test_in_a_parallel_loop_a_call_has_what_it_left(open_tool, command, tmp_path):
    """A row of the recording has the outputs of the call before; the source, the diagram and the test have those of the call."""
    page = open_tool(LAPTOP)
    drop(page, *(PROGRAMS / name for name in ("tank_loop.toml", "tank.scl", "tank_plant.scl")))
    until(page, "async () => (await moduleOf('tool/store.js')).store.loop?.connections.length === 5")
    assert page.evaluate("async () => (await moduleOf('tool/store.js')).store.loop.exchange") == "parallel"
    run_calls(page, 60, 0.5)
    # It starts in the first call.
    page.evaluate("async () => (await moduleOf('tool/moment.js')).lookAt(0)")
    step = "async () => (await moduleOf('tool/moment.js')).momentValues()['FILLING.step']"
    until(page, f"async () => (await ({step})()) === 10")
    show_tab(page, "Log")
    page.get_by_role("button", name="Save as test").click()
    _, content = saved(page, "Save TankFilling_test.toml", "#done")
    for source in ("tank.scl", "tank_plant.scl"):
        shutil.copy(PROGRAMS / source, tmp_path)
    done = run_case(command, tmp_path, content)
    assert done.returncode == 0 and ": ok" in done.stdout, done.stdout + done.stderr + content.decode()


def test_same_again_after_the_program_was_changed_marks_what_differs(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("blink.scl", BLINK))
    set_input(page, "on", False)
    one_cycle(page, 3)
    set_input(page, "on", True)
    one_cycle(page, 4)
    again = page.get_by_role("button", name="Same again")
    again.click()
    verdict = page.locator(".timing-verdict")
    verdict.get_by_text("Same as Run 1: every variable, in 7 cycles").wait_for()
    assert page.locator(".timing .differs").count() == 0
    drop(page, ("blink.scl", BLINK.replace("#level + 1.5", "#level + 2.0").replace("#lamp := NOT #lamp", "#lamp := TRUE")))
    line(page, 15).get_by_text("TRUE").wait_for()
    again.click()
    # The lamp goes out in call 5 of the run before, the level rises by another amount from call 4 on.
    verdict.get_by_text("Differs from Run 2 from 0.4 s onward: level and 1 more").wait_for()
    assert made(page) == 7
    width = float(lane(page, "Blink.lamp").get_attribute("width"))
    marks = lane(page, "Blink.lamp").locator(".differs")
    # A line has no height.
    marks.wait_for(state="attached")
    begin, end = map(float, re.findall(r"[MH]([\d.]+)", marks.get_attribute("d")))
    assert [round(at / width * 2.0, 2) for at in (begin, end)] == [0.5, 0.6]
    assert "is-different" in label(page, "Blink.level").get_attribute("class")
    assert "is-different" not in label(page, "Blink.step").get_attribute("class")
    screenshot(page, "diagram-same-again")


def test_a_wrong_value_is_followed_to_the_input_that_caused_it(open_tool):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "tank.scl")
    set_input(page, "eStopOk", False)
    one_cycle(page)
    why = page.locator(".why")
    label(page, "TankFilling.inletValve").get_by_role("button", name="Why inletValve?").click()
    why.get_by_text("Why is inletValve FALSE at 0 s?").wait_for()
    source = (PROGRAMS / "tank.scl").read_text().splitlines()

    def row(text):
        return next(number for number, line in enumerate(source, 1) if text in line)

    wrote = why.locator(".why-statement").first
    assert f"this wrote it: line {row('#inletValve := ')}: #inletValve := #step = #OPEN OR #step = #FILL" in wrote.inner_text()
    # Each operand can be asked in turn.
    wrote.get_by_role("button", name="step 90").click()
    why.get_by_text("Why is step 90 at 0 s?").wait_for()
    assert f"line {row('#step := #FAULTED')}: #step := #FAULTED" in wrote.inner_text()
    assert wrote.locator("li").inner_text().startswith(f"if line {row('IF #fault THEN')}: #fault")
    # What would start the filling did not run.
    others = why.locator(".why-statement", has_text="This did not run:")
    idle = others.filter(has_text="#startEdge.Q AND #released").inner_text()
    # The CASE went by what the step was before: IDLE, not the 90 that another statement wrote after it.
    assert "#step := #OPEN" in idle and f"in the CASE of line {row('CASE #step OF')}: #step step 0" in idle, idle
    screenshot(page, "diagram-why")
    wrote.get_by_role("button", name="fault TRUE").click()
    wrote.get_by_role("button", name="faultCode 16#0001").click()
    stop = why.locator(".why-statement", has_text="OR NOT #eStopOk")
    # The bit was FALSE before; of two operands, the emergency stop is the one that set it.
    assert "decided: eStopOk FALSE" in stop.locator("p .has-decided").inner_text()
    assert stop.locator("p .is-idle").inner_text() == "made no difference: faultCode 16#0000"
    stop.get_by_role("button", name="eStopOk FALSE").click()
    why.get_by_text("It is an input or parameter that you set: it has had this value since the beginning of the run.").wait_for()
    why.get_by_role("button", name="Back").click()
    why.get_by_text("Why is faultCode 16#0001 at 0 s?").wait_for()
    # A click on a line goes there, and one on a value of the source asks why.
    stop.get_by_role("button", name=re.compile("^line")).click()
    assert "is-target" in line(page, row("#faultCode.%X0")).get_attribute("class")
    line(page, row("#faultCode.%X0")).locator(".value", has_text="eStopOk").click()
    why.get_by_text("Why is eStopOk FALSE at 0 s?").wait_for()
    # What is asked in turn is asked of the cycle in which it counted, though others followed: reset, then start, and it opens.
    for name, value in (("eStopOk", True), ("reset", True)):
        set_input(page, name, value)
    one_cycle(page)
    set_input(page, "reset", False)
    one_cycle(page)
    set_input(page, "start", True)
    one_cycle(page)
    set_input(page, "start", False)
    one_cycle(page)
    label(page, "TankFilling.step").get_by_role("button", name="Why step?").click()
    why.get_by_text(re.compile("^Why is step 10 at 2 s")).wait_for()
    assert re.search("At 1.5 s this wrote it: .*#step := #OPEN", wrote.inner_text(), re.S)
    assert re.search(r"in the CASE of .*step 0$", wrote.locator("li", has_text="CASE").inner_text(), re.S)
    wrote.get_by_role("button", name="startEdge.Q TRUE").click()
    why.get_by_text("Why is startEdge.Q TRUE at 1.5 s?").wait_for()
    # Connected inputs say where they come from; what is forced says so.
    other = open_tool(LAPTOP)
    drop(other, PROGRAMS / "tank.scl", PROGRAMS / "tank_plant.scl")
    until(other, "async () => (await moduleOf('tool/store.js')).store.loop?.connections.length === 5")
    one_cycle(other, 2)
    label(other, "TankFilling.level").get_by_role("button", name="Why level?").click()
    answer = other.locator(".why")
    answer.get_by_text("It comes from").wait_for()
    answer.get_by_role("button", name="PLANT.level").click()
    assert "#level := LIMIT" in answer.locator(".why-statement").first.inner_text()
