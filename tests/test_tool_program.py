"""PLC programs in the parameter tool's page: a source is dropped, runs, is watched line by line, and stops where it is wrong.

What the page computes is compared with `plcfmu run` of the same sources, bit for bit.
"""

import base64
import pathlib
import subprocess

import pytest

import host
from test_tool_run import PHONE, assert_same_bits, made, manual, number, open_tool, recorded, run_calls, saved, screenshot, wait_for_calls
from test_tool_run import browser, pytestmark, run_described  # noqa: F401
from tool import new_loop, show_tab, until

ROOT = pathlib.Path(__file__).parents[1]
PROGRAMS = ROOT / "examples/programs"
LAPTOP = (1366, 768)

DROP = """files => {
  const transfer = new DataTransfer();
  for (const [name, content] of files) {
    const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0));
    transfer.items.add(new File([bytes], name));
  }
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
}"""

COUNTER = """FUNCTION_BLOCK "Counter"
VAR_INPUT up : Bool; step : Int := 1; END_VAR
VAR_OUTPUT count : Int; END_VAR
VAR a : ARRAY[1..3] OF Int; END_VAR
BEGIN
  IF #up THEN
    #count += #step;
    #a[#count] := #count;
  END_IF;
END_FUNCTION_BLOCK
"""


def drop(page, *files):
    """Drops files on the page: paths, or names with texts."""
    named = [(of.name, of.read_bytes()) if isinstance(of, pathlib.Path) else (of[0], of[1].encode()) for of in files]
    page.evaluate(DROP, [[name, base64.b64encode(content).decode()] for name, content in named])


def line(page, number):
    """A line of the source. Read it with text_content: inner_text is empty until a frame lays out the section of the line."""
    return page.locator(f'.program [data-line="{number}"]')


def set_input(page, name, value):
    """Sets an input of the program, which acts at once; what springs back is made a switch first."""
    row = page.locator(f'[data-input="{name}"]')
    if isinstance(value, bool):
        row.locator(".push, [role=switch]").wait_for()
        if row.locator(".push").count():
            row.get_by_role("button", name=f"Make {name} a toggle switch").click()
        row.get_by_role("switch").set_checked(value)
    else:
        row.locator("input.number").fill(str(value))
        row.locator("input.number").press("Enter")
    is_in_force = "async ([name, value]) => (await moduleOf('tool/store.js')).store.loop.settings[name].sent === value"
    page.wait_for_function(is_in_force, arg=[name, value])


@pytest.fixture
def by_command(command, tmp_path):
    """Runs a program with `plcfmu run`, without packing it, and gives what it records."""

    def by_command(source, cycle, seconds):
        given = [command, "run", source, "--cycle", cycle, "--stop", str(seconds), "--out", "-"]
        done = subprocess.run(given, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return recorded(done.stdout)

    return by_command


@pytest.mark.parametrize("name, cycle", [("furnace", "1s"), ("tank", "500ms"), ("conveyor", "100ms")])
def test_one_drop_and_one_click_lead_from_a_source_to_a_curve_with_the_bits_of_plcfmu_run(
    open_tool, by_command, name, cycle
):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / f"{name}.scl")
    page.get_by_role("button", name="Run", exact=True).click()
    wait_for_calls(page, 3)
    page.get_by_role("button", name="Pause").click()
    page.locator(".timing-plot").first.wait_for()
    calls = made(page)
    _, table = saved(page, "CSV of everything")
    shown = recorded(table.decode())
    step = {"1s": 1.0, "500ms": 0.5, "100ms": 0.1}[cycle]
    ran = by_command(PROGRAMS / f"{name}.scl", cycle, calls * step)
    # The page names the program by its block, the command by its file.
    own = {column.split(".", 1)[-1]: values for column, values in shown.items()}
    assert len(ran) >= 7
    for column, values in ran.items():
        here = own[column.split(".", 1)[-1]]
        assert [float(value) for value in values[:-1]] == [float(value) for value in here[: len(values) - 1]], column


def test_a_program_runs_against_a_plant_with_the_bits_of_its_description(open_tool, run_described, tmp_path):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "furnace.scl")
    show_tab(page, "Plant")
    page.locator("#plant-choice").select_option("HEATER")
    plant = page.locator("#plant")
    plant.get_by_text("goes to").first.wait_for()
    # What the controller inside is given, and gives, is what the plant has and takes.
    assert page.locator('[id="wire-to-FurnaceZone.temperature"]').input_value() != ""
    set_input(page, "enable", True)
    set_input(page, "setpoint", 60)
    run_calls(page, 120)
    (tmp_path / "furnace.scl").write_bytes((PROGRAMS / "furnace.scl").read_bytes())
    shown = assert_same_bits(page, run_described)
    # The ramp leads to the setpoint with 60 K/min, 1 K a call.
    assert float(shown["FurnaceZone.rampSetpoint"][-1]) == 60.0
    assert float(shown["FurnaceZone.temperature"][-1]) > 40.0
    screenshot(page, "program-plant")


def test_errors_stand_at_their_lines_and_the_corrected_source_runs(open_tool):
    page = open_tool(LAPTOP)
    damaged = (PROGRAMS / "furnace.scl").read_text().replace("#tTrip.Q", "#tTirp.Q").replace("#manual;", "#manual")
    drop(page, ("furnace.scl", damaged))
    refused = page.locator("#refused")
    refused.locator(".line.is-wrong").first.wait_for()
    at = next(number for number, text in enumerate(damaged.splitlines(), 1) if "#tTirp.Q" in text)
    assert "is-wrong" in line(page, at).get_attribute("class")
    assert line(page, at).locator("mark").text_content() == "#tTirp"
    findings = refused.locator(".finding")
    assert findings.count() >= 2
    findings.last.click()
    assert "is-target" in page.locator(".line.is-target").get_attribute("class")
    screenshot(page, "program-errors")
    drop(page, PROGRAMS / "furnace.scl")
    page.get_by_role("button", name="Run", exact=True).click()
    wait_for_calls(page, 1)
    assert refused.is_hidden()


def test_the_values_of_a_line_stand_beside_it_while_the_program_runs(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("counter.scl", COUNTER))
    press = page.get_by_role("button", name="One cycle")
    press.click()
    line(page, 6).locator(".value.is-false").wait_for()
    assert line(page, 6).locator(".value").text_content() == "up FALSE"
    assert "has-run" not in line(page, 7).get_attribute("class")
    set_input(page, "up", True)
    press.click()
    page.locator('.program [data-line="7"].has-run').wait_for()
    assert line(page, 6).locator(".value").text_content() == "up TRUE"
    assert line(page, 7).locator(".value").all_text_contents() == ["count 1", "step 1"]
    # The element that the index names.
    assert line(page, 8).locator(".value").all_text_contents() == ["a[count] 1", "count 1"]
    assert line(page, 7).locator(".is-changed").count() == 1
    screenshot(page, "program-values")


def test_a_program_that_stops_says_so_at_its_line_and_begins_again(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("counter.scl", COUNTER))
    set_input(page, "up", True)
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    page.get_by_role("button", name="Run", exact=True).click()
    stop = page.locator(".line-note.is-stop")
    stop.wait_for()
    assert "index 4 is outside 1..3" in stop.text_content()
    # It follows the line of the access.
    assert stop.evaluate("note => note.previousElementSibling.dataset.line") == "8"
    stop.get_by_role("button", name="Restart").click()
    stop.wait_for(state="detached")
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 1)


def test_a_loop_without_end_leaves_the_page_alive(open_tool):
    page = open_tool(LAPTOP)
    endless = COUNTER.replace("#count += #step;", "WHILE TRUE DO #count += 1; END_WHILE;")
    drop(page, ("counter.scl", endless))
    set_input(page, "up", True)
    page.get_by_role("button", name="Run", exact=True).click()
    stop = page.locator(".line-note.is-stop")
    stop.wait_for()
    assert "1000000 statements" in stop.text_content()
    set_input(page, "up", False)
    stop.get_by_role("button", name="Restart").click()
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 1)


def test_several_sources_are_one_program_and_the_block_that_runs_is_chosen(open_tool):
    page = open_tool(LAPTOP)
    types = "TYPE \"Limits\" STRUCT low : Real := 1.0; END_STRUCT; END_TYPE"
    user = COUNTER.replace("VAR a :", "VAR limits : \"Limits\"; a :")
    drop(page, ("limits.udt", types), ("counter.scl", user + COUNTER.replace('"Counter"', '"Other"')))
    page.get_by_role("button", name="Run Other", exact=True).click()
    page.locator("#what").get_by_text("Other", exact=True).first.wait_for()
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 1)


def test_a_program_survives_a_reload_and_a_link_carries_it(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("counter.scl", COUNTER))
    set_input(page, "up", True)
    for _ in range(2):
        page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 2)
    page.wait_for_function("() => (sessionStorage.getItem('plcfmu') ?? '').includes('\"calls\":2')")
    page.reload()
    wait_for_calls(page, 2)
    assert page.locator(".program .source").text_content().count("#count") == 3
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.locator("#away-button").click()
    page.get_by_role("button", name="Copy link").click()
    page.get_by_text("The link is on the clipboard. It works only on this computer: to share it, put the page on a server").wait_for()
    link = page.evaluate("navigator.clipboard.readText()")
    other = open_tool(LAPTOP)
    other.goto(link)
    wait_for_calls(other, 2)
    _, table = saved(other, "CSV of everything")
    assert recorded(table.decode())["Counter.count"] == ["1", "2"]


def test_a_parameter_file_and_a_damaged_file_are_no_programs(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("noise.scl", "FUNCTION_BLOCK \0\x01 ((((" * 50))
    page.get_by_text("noise.scl").wait_for()
    page.get_by_text("This is not a text file").wait_for()
    drop(page, ("wide.scl", "FUNCTION_BLOCK".encode("utf-16-le").decode("latin-1")))
    page.get_by_text("This is UTF-16 text without a byte order mark").wait_for()
    drop(page, ("empty.scl", ""))
    page.get_by_text("the file is empty").wait_for()
    # The page goes on.
    new_loop(page, "TIC101")
    page.get_by_role("button", name="Run", exact=True).wait_for()


def test_on_a_phone_the_program_is_a_tab(open_tool):
    page = open_tool(PHONE)
    drop(page, ("counter.scl", COUNTER))
    show_tab(page, "Program")
    line(page, 7).wait_for()
    # A narrower one, too: a line that is too long wraps, and nothing is beyond the edge.
    page.set_viewport_size({"width": 350, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 350
    head = line(page, 1).locator("code").bounding_box()
    assert head["x"] >= 0 and head["x"] + head["width"] <= 350


def test_a_block_inside_is_shown_with_its_diagram_and_opens_as_a_loop(open_tool):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "furnace.scl")
    show_tab(page, "Plant")
    page.locator("#plant-choice").select_option("HEATER")
    page.locator("#plant").get_by_text("goes to").first.wait_for()
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 1)
    show_tab(page, "Diagram")
    inside = page.locator("#diagram")
    assert inside.locator("#inside-choice option").all_inner_texts() == ["controller: CONT_C", "pulses: PULSEGEN"]
    inside.locator("svg").first.wait_for()
    # The program passes GAIN := 4.0 in this line.
    source = (PROGRAMS / "furnace.scl").read_text().splitlines()
    at = next(number for number, text in enumerate(source, 1) if "GAIN := 4.0" in text)
    row = inside.locator("tr", has=page.get_by_text("GAIN", exact=True))
    assert row.inner_text().split() == ["GAIN", "4", "line", str(at)]
    screenshot(page, "program-inside")
    inside.get_by_role("button", name="Open as a separate loop").click()
    page.locator("#what").get_by_text("CONT_C", exact=True).wait_for()
    assert page.locator('[data-name="GAIN"] input').input_value() == "4"
    assert page.locator('[data-name="TI"] input').input_value() == "200"
    show_tab(page, "Plant")
    assert page.locator("#plant-choice").input_value() == "HEATER"
    page.locator('[id$=".PV_IN"]').first.wait_for(state="attached")
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 1)


def test_a_corrected_program_takes_the_place_of_the_earlier_one_with_its_values(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("counter.scl", COUNTER))
    set_input(page, "step", 2)
    page.evaluate("async () => (await moduleOf('tool/store.js')).store.now({ CYCLE: 0.5 })")
    press = page.get_by_role("button", name="One cycle")
    press.click()
    wait_for_calls(page, 1)
    drop(page, ("counter.scl", COUNTER.replace("IF #up THEN", "IF NOT #up THEN")))
    line(page, 6).get_by_text("NOT #up").wait_for()
    assert page.locator("#input-step").input_value() == "2"
    assert page.evaluate("async () => (await moduleOf('tool/store.js')).store.loop.settings.CYCLE.sent") == 0.5
    press.click()
    page.locator('.program [data-line="7"].has-run').wait_for()
    assert line(page, 7).locator(".value").all_text_contents() == ["count 2", "step 2"]


def test_the_card_of_the_first_page_runs_a_program(open_tool):
    page = open_tool(LAPTOP)
    page.locator("#program-card").click()
    wait_for_calls(page, 700)
    page.locator(".line.has-run").first.wait_for()
    _, table = saved(page, "CSV of everything")
    shown = recorded(table.decode())
    # It has reached both setpoints, and is in its band.
    assert abs(float(shown["Oven.temperature"][419]) - 80) < 2 and abs(float(shown["Oven.temperature"][-1]) - 120) < 5
    screenshot(page, "program-card")


def test_texts_of_a_program_stand_beside_its_lines(open_tool):
    page = open_tool(LAPTOP)
    source = "FUNCTION_BLOCK Line VAR name : String := 'pump'; END_VAR BEGIN\nname := CONCAT(IN1 := name, IN2 := '!');\nEND_FUNCTION_BLOCK"
    drop(page, ("line.scl", source))
    line(page, 2).wait_for()
    page.get_by_role("button", name="One cycle").click()
    line(page, 2).locator(".values").get_by_text("'pump!'").wait_for()


def test_a_word_is_shown_in_hexadecimal_and_a_function_has_no_values_of_another_block(open_tool):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "tank.scl")
    source = (PROGRAMS / "tank.scl").read_text().splitlines()

    def row(text):
        return next(number for number, line in enumerate(source, 1) if text in line)

    # The source begins with types and an interlock: the block that runs is on top, each number in a line.
    page.wait_for_function("() => document.querySelector('.program .source')?.scrollTop > 0")
    place = "one => one.getBoundingClientRect().y"
    top = page.locator(".program .source").evaluate(place)
    assert 0 <= line(page, row('FUNCTION_BLOCK "TankFilling"')).evaluate(place) - top <= 2
    digits = line(page, 100).locator(".line-number")
    parts = "one => { const text = new Range(); text.selectNodeContents(one); return text.getClientRects().length; }"
    assert digits.inner_text() == "100" and digits.evaluate(parts) == 1
    # A comment that is too long wraps: its number stands at its first row, and the next line below its last one.
    number = row("// the outlet opens when the level is above its setpoint")
    line(page, number).scroll_into_view_if_needed()
    height = line(page, number).evaluate("one => one.getBoundingClientRect().height")
    assert height > 20 and line(page, number + 1).evaluate(place) - line(page, number).evaluate(place) == height
    assert line(page, number).locator(".line-number").evaluate(place) == line(page, number).evaluate(place)
    set_input(page, "eStopOk", False)
    page.get_by_role("button", name="One cycle").click()
    # Values stand beside the lines that are in sight.
    fault = line(page, row("#fault := #faultCode <> 16#0"))
    fault.scroll_into_view_if_needed()
    fault.locator(".values").get_by_text("16#0001").wait_for()
    page.locator('.timing [data-signal="TankFilling.faultCode"]').get_by_text("16#0001").wait_for()
    # Its inputs are those of a call that is over; TankFilling has variables of the same names.
    function = line(page, row("#Interlock := #eStopOk"))
    function.scroll_into_view_if_needed()
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 2)
    assert function.locator(".value").count() == 0
    # Words of the language, comments and literals are told apart.
    looks = "line => [...line.querySelectorAll('code span')].map(span => [span.className, span.textContent])"
    assert ["is-word", "VAR_INPUT"] in line(page, row("VAR_INPUT")).evaluate(looks)
    comment = line(page, row("// push button")).evaluate(looks)
    assert ["is-comment", "// push button"] in comment
    assert ["is-literal", "T#10s"] in line(page, row("fillTimeout : Time")).evaluate(looks)


def test_a_machine_and_its_plant_are_dropped_together_and_a_push_button_fills_the_tank(open_tool, run_described, tmp_path):
    page = open_tool(LAPTOP)
    # Three actions: drop, Run, start.
    drop(page, PROGRAMS / "tank.scl", PROGRAMS / "tank_plant.scl")
    start = page.locator('[data-input="start"] .push')
    start.wait_for()
    until(page, "async () => (await moduleOf('tool/store.js')).store.loop.connections.length === 5")
    page.get_by_role("button", name="Run", exact=True).click()
    wait_for_calls(page, 1)
    start.click()
    values = "async () => (await moduleOf('tool/store.js')).store.state.values"
    # The pump adds 5 % a call; the row of the last call has the level before it.
    until(page, f"async () => (await ({values})())['PLANT.level'] > 30")
    page.get_by_role("button", name="Pause").click()
    # What was connected is not set by hand any more; what is left is.
    names = page.locator("[data-input]").evaluate_all("rows => rows.map(row => row.dataset.input)")
    assert names == ["start", "stop", "reset", "eStopOk"]
    for source in ("tank.scl", "tank_plant.scl"):
        (tmp_path / source).write_bytes((PROGRAMS / source).read_bytes())
    shown = assert_same_bits(page, run_described)
    # The button was TRUE in one call at least, and sprang back.
    pressed = [number(value) == 1 for value in shown["TankFilling.start"]]
    assert any(pressed) and not pressed[-1]
    assert float(shown["PLANT.level"][-1]) > 20.0
    screenshot(page, "program-machine")


def test_a_description_and_the_sources_of_its_programs_are_dropped_together(open_tool, run_described, tmp_path):
    page = open_tool(LAPTOP)
    drop(page, *(PROGRAMS / name for name in ("tank_plant.scl", "tank_loop.toml", "tank.scl")))
    # It runs as it says: 120 s in steps of 0.5 s.
    wait_for_calls(page, 240)
    assert page.locator("#what strong").inner_text() == "FILLING"
    values = page.evaluate("async () => (await moduleOf('tool/store.js')).store.state.values")
    assert values["FILLING.levelSp"] == 50 and values["TANK.level"] == pytest.approx(50, abs=1)
    for source in ("tank.scl", "tank_plant.scl"):
        (tmp_path / source).write_bytes((PROGRAMS / source).read_bytes())
    assert_same_bits(page, run_described)


def test_a_press_between_two_calls_is_seen_by_one_call(open_tool):
    page = open_tool(LAPTOP)
    drop(page, PROGRAMS / "tank.scl")
    start = page.locator('[data-input="start"] .push')
    start.wait_for()
    # Nothing runs: the button stays down until a call has seen it.
    start.click()
    sent = "async () => (await moduleOf('tool/store.js')).store.loop.settings.start.sent"
    until(page, f"async () => (await ({sent})()) === true")
    assert start.get_attribute("aria-pressed") == "true"
    page.get_by_role("button", name="One cycle").click()
    until(page, f"async () => (await ({sent})()) === false")
    page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 2)
    _, table = saved(page, "CSV of everything")
    assert [number(value) for value in recorded(table.decode())["TankFilling.start"]] == [1, 0]


def test_two_blocks_of_which_no_name_says_which_is_the_plant_are_a_question(open_tool):
    page = open_tool(LAPTOP)
    valve = 'FUNCTION_BLOCK "Valve" VAR_INPUT open : Bool; END_VAR VAR_OUTPUT level : Real; END_VAR BEGIN\nIF open THEN level := level + 1.0; END_IF; END_FUNCTION_BLOCK'
    logic = 'FUNCTION_BLOCK "Logic" VAR_INPUT level : Real; END_VAR VAR_OUTPUT open : Bool; END_VAR BEGIN\nopen := level < 3.0; END_FUNCTION_BLOCK'
    drop(page, ("valve.scl", valve), ("logic.scl", logic))
    refused = page.locator("#refused")
    refused.get_by_text("Which block runs?").wait_for()
    # The options have a place for an error; nothing is said there either.
    assert "".join(refused.locator(".error").all_text_contents()) == ""
    assert refused.locator(".findings, .line-note").count() == 0
    refused.get_by_role("button", name="Run Logic with Valve as its plant").click()
    until(page, "async () => (await moduleOf('tool/store.js')).store.loop?.connections.length === 2")
    for _ in range(6):
        page.get_by_role("button", name="One cycle").click()
    wait_for_calls(page, 6)
    values = page.evaluate("async () => (await moduleOf('tool/store.js')).store.state.values")
    assert values["Logic.level"] == 3 and values["Logic.open"] is False
