"""The parameter tool in a browser, from its file: parameters, diagram, help and keys.

The page is target/tool/plcfmu-tool.html (`cargo xtask tool`), or the file that PLCFMU_TOOL names.
"""

import json
import pathlib
import subprocess

import pytest

import host
from tool import CHROMIUM, PAGE, needs_browser, needs_page, show_tab

ROOT = pathlib.Path(__file__).parents[1]
pytestmark = [*needs_browser, needs_page]

FILES = ROOT / "tests/parameters"
PLANT = FILES / "plant.awl"
DESKTOP, PHONE = 1280, 390
# As a server describes a block: enough for a loop with one setting.
GAIN = {"name": "GAIN", "description": "Gain", "kind": "REAL", "role": "parameter", "is_tunable": True, "start": 2.0}
DESCRIPTION = {
    **{"name": "CONT_C", "block": "CONT_C", "summary": "", "aliases": [], "part": "controller", "cycle": None},
    "variables": [{**GAIN, "min": None, "max": None, "unit": None}],
    "roles": {
        **dict.fromkeys(("setpoint", "process_value", "shown_process_value", "manipulated_value", "manual")),
        **{name: [] for name in ("controller", "structure", "pulses", "pulse_former", "disturbances", "signals")},
    },
    "groups": [{"title": "Gain", "fields": [{"name": "GAIN", "used_if": []}]}],
}


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        arguments = "--no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-component-update"
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*arguments.split(), "--disable-sync"])
        yield browser
        browser.close()


@pytest.fixture
def open_tool(browser):
    """Opens the page in a window of its own. Any message of the browser, and any request to elsewhere, is a failure."""
    contexts, messages = [], []

    def open_tool(width=DESKTOP, height=900, scheme="light"):
        context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
        context.set_default_timeout(10_000)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: messages.append(message.text))
        page.on("pageerror", lambda error: messages.append(str(error)))
        page.on("request", lambda request: None if is_inside(request.url) else messages.append(request.url))
        page.goto(PAGE.as_uri())
        page.locator("#new-block option").first.wait_for(state="attached")
        return page

    yield open_tool
    for context in contexts:
        context.close()
    assert messages == []


@pytest.fixture
def page(open_tool):
    return open_tool()


def is_inside(url):
    return url.startswith(("file:", "data:", "blob:"))


def new_loop(page, block, name=""):
    page.fill("#new-name", name)
    page.select_option("#new-block", block)
    page.click("text=New loop")
    page.locator("#fields .field").first.wait_for()
    checked(page)


def checked(page):
    """Waits until the engine has answered all that was asked."""
    page.evaluate('async () => { const { ask } = await moduleOf("tool/engine.js"); await ask({ do: "catalogue" }); }')
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def ask(page, **request):
    return page.evaluate('async (request) => (await moduleOf("tool/engine.js")).ask(request)', request)


def make_calls(page, calls):
    page.evaluate('async (calls) => { const { store } = await moduleOf("tool/store.js"); await store.calls(calls); }', calls)
    checked(page)


def field(page, name):
    return page.locator(f'[id="field-{name}"]')


def row(page, name):
    return page.locator(f'.field[data-name="{name}"]')


def write(page, name, text):
    field(page, name).fill(text)
    checked(page)


def tag(page, name):
    return row(page, name).locator(".tag").inner_text()


def in_force(page, name):
    return page.evaluate(
        'async (name) => (await moduleOf("tool/store.js")).store.loop.settings[name].sent', name
    )


def open_file(page, name, text):
    content = text if isinstance(text, bytes) else text.encode()
    page.set_input_files("#open-files", {"name": name, "mimeType": "text/plain", "buffer": content})


def data_block(name, number=41, **values):
    lines = "".join(f"  {key} := {value};\n" for key, value in values.items())
    return f'DATA_BLOCK "{name}"\nTITLE =\nVERSION : 0.1\n FB {number}\nBEGIN\n{lines}END_DATA_BLOCK\n'


def test_the_fields_of_a_loop_have_the_values_of_the_file(page, command, tmp_path):
    page.set_input_files("#open-files", PLANT)
    page.click("table.loops >> text=TIC101")
    field(page, "GAIN").wait_for()
    checked(page)
    fmus = [f"--fmus={host.FOLDER / name}.fmu" for name in ("CONT_C", "CONT_S", "PULSEGEN")]
    out = tmp_path / "plant.json"
    done = subprocess.run([command, "params", PLANT, *fmus, f"--out={out}"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for name, value in json.loads(out.read_text())["TIC101"].items():
        if isinstance(value, bool):
            assert field(page, name).is_checked() == value, name
        else:
            assert float(field(page, name).input_value()) == pytest.approx(value, rel=1e-7), name
        if name not in ("P_SEL", "I_SEL", "D_SEL"):
            assert row(page, name).locator(".tag").text_content() == "file", name


def test_numbers_keep_all_their_digits(page):
    open_file(page, "a.awl", data_block("A", GAIN="3.1415927e+000", MAN="-1.2345679e-007", TI="T#1D2H3M4S5MS"))
    field(page, "GAIN").wait_for()
    assert field(page, "GAIN").input_value() == "3.1415927"
    assert field(page, "MAN").input_value() == "-1.2345679e-7"
    assert field(page, "TI").input_value() == "93784.005"
    assert "T#1D2H3M4S5MS" in row(page, "TI").inner_text()


def test_every_setting_of_every_block_has_one_field_with_a_label_and_help(page):
    catalogue = ask(page, do="catalogue")
    controllers = page.locator("#new-block option").all_inner_texts()
    assert controllers == [entry["name"] for entry in catalogue["fmus"] if entry["part"] != "plant"]
    for block in controllers:
        if page.locator("#opening").is_hidden():
            page.click("#open-button")
        new_loop(page, block)
        variables = ask(page, do="describe", fmu=block)["variables"]
        settable = [one["name"] for one in variables if one["role"] not in ("output", "local")]
        for name in settable:
            assert page.locator(f'[id="field-{name}"]').count() == 1, f"{block}.{name}"
            assert page.locator(f'label[for="field-{name}"]').text_content() == name
        assert page.locator("#fields input").count() == len(settable), block


# Parameters


def test_an_edited_value_is_marked_until_enter_sends_it(page):
    new_loop(page, "CONT_C")
    assert tag(page, "GAIN") == "start"
    write(page, "GAIN", "3,1")
    assert tag(page, "GAIN") == "edited"
    assert in_force(page, "GAIN") == 2
    assert page.locator("#edited-count").inner_text() == "1 edited, not applied"
    # Nothing is changed before it is applied.
    assert "unchanged" in page.locator("#what").inner_text()
    field(page, "GAIN").press("Enter")
    checked(page)
    assert in_force(page, "GAIN") == 3.1
    assert tag(page, "GAIN") == "changed"
    assert "1 changed" in page.locator("#what").inner_text()
    assert page.locator("#edited-count").inner_text() == "All in force"


def test_esc_takes_an_edit_back(page):
    new_loop(page, "CONT_C")
    write(page, "GAIN", "3.1")
    field(page, "GAIN").press("Escape")
    assert field(page, "GAIN").input_value() == "2"
    assert tag(page, "GAIN") == "start"


def test_a_wrong_text_stays_with_a_sentence_and_the_value_in_force_stays(page):
    new_loop(page, "CONT_C")
    for text, why in [("2.5.1", "is not a number"), ("", "needs a value"), ("1e39", "exceeds the range of type REAL")]:
        write(page, "GAIN", text)
        assert why in row(page, "GAIN").inner_text()
        field(page, "GAIN").press("Enter")
        field(page, "GAIN").blur()
        assert field(page, "GAIN").input_value() == text
        assert field(page, "GAIN").get_attribute("aria-invalid") == "true"
        assert in_force(page, "GAIN") == 2
    write(page, "TI", "20 apples")
    assert "is not a time" in row(page, "TI").inner_text()


def test_send_puts_all_edited_values_in_force_and_the_run_has_them_in_its_next_call(page):
    new_loop(page, "CONT_C", "TIC")
    make_calls(page, 3)
    write(page, "GAIN", "3.1")
    write(page, "MAN", "40")
    page.click("#send")
    checked(page)
    make_calls(page, 1)
    events = ask(page, do="events")["events"]
    assert [(one["call"], one["variable"], round(one["value"], 6)) for one in events] == [
        (3, "TIC.GAIN", 3.1),
        (3, "TIC.MAN", 40),
    ]


def test_a_time_is_typed_in_seconds_or_as_the_plc_writes_it(page):
    new_loop(page, "CONT_C")
    for text, seconds in [("1.5", 1.5), ("T#1M30S", 90), ("500 ms", 0.5), ("2min", 120), ("t#1h_1s", 3601)]:
        write(page, "TI", text)
        field(page, "TI").press("Enter")
        checked(page)
        assert in_force(page, "TI") == seconds
        assert field(page, "TI").input_value() == f"{seconds:g}"
    write(page, "TI", "0.0005")
    assert "whole milliseconds" in row(page, "TI").inner_text()


def test_what_the_block_does_with_a_value_is_said_while_it_is_typed(page):
    new_loop(page, "CONT_C")
    write(page, "TI", "0.02")
    said = ask(page, do="check", fmu="CONT_C", values={"TI": 0.02})
    (remark,) = [one["text"] for one in said["remarks"] if "TI" in one["variables"]]
    assert remark in row(page, "TI").inner_text()
    write(page, "TI", "20")
    assert remark not in row(page, "TI").inner_text()


def test_settings_without_effect_are_folded(page):
    new_loop(page, "CONT_C")
    folds = page.locator("details", has=field(page, "TD"))
    assert "without effect in PI: show" in folds.locator("summary").inner_text()
    assert not field(page, "TD").is_visible()
    folds.locator("summary").click()
    assert field(page, "TD").is_visible()
    page.select_option("#structure", "PID")
    checked(page)
    assert page.locator("details", has=field(page, "TD")).count() == 0
    assert field(page, "TD").is_visible()


def test_the_structure_is_chosen_as_p_pi_pd_or_pid(page):
    new_loop(page, "CONT_C")
    for structure in ("P", "PD", "PID", "PI"):
        page.select_option("#structure", structure)
        if page.locator("#send").is_enabled():
            page.click("#send")
        checked(page)
        values = {letter: in_force(page, f"{letter}_SEL") for letter in "PID"}
        assert values == {letter: letter in structure for letter in "PID"}


def test_undo_and_redo_go_through_the_edits(page):
    new_loop(page, "CONT_C")
    field(page, "GAIN").click()
    field(page, "GAIN").fill("")
    field(page, "GAIN").press_sequentially("3.25")
    page.select_option("#structure", "PID")
    checked(page)
    page.click("#undo-button")
    assert page.locator("#structure").input_value() == "PI"
    page.click("#undo-button")
    assert field(page, "GAIN").input_value() == "2"
    assert page.locator("#undo-button").is_disabled()
    page.click("#redo-button")
    page.click("#redo-button")
    assert field(page, "GAIN").input_value() == "3.25"
    assert page.locator("#structure").input_value() == "PID"
    assert page.locator("#edited-count").inner_text() == "2 edited, not applied"


def saved(page, button):
    """The file that a button of Export saves, as text."""
    with page.expect_download() as download:
        page.locator("#takeaway").get_by_role("button", name=button).click()
    return pathlib.Path(download.value.path()).read_text("latin-1")


def test_undo_and_redo_reach_the_value_in_force_and_the_saved_file(page):
    text = data_block("A", GAIN="1.400000e+000", TI="T#30S")
    open_file(page, "a.awl", text)
    field(page, "GAIN").wait_for()
    write(page, "GAIN", "0.9")
    field(page, "GAIN").press("Enter")
    checked(page)
    page.click("#undo-button")
    checked(page)
    assert (field(page, "GAIN").input_value(), in_force(page, "GAIN")) == ("1.4", pytest.approx(1.4, rel=1e-6))
    assert page.locator("#what").inner_text().endswith("unchanged")
    page.click("#away-button")
    assert saved(page, "Save a.awl") == text
    page.keyboard.press("Escape")
    page.click("#redo-button")
    checked(page)
    assert in_force(page, "GAIN") == 0.9
    page.click("#away-button")
    assert saved(page, "Save a.awl") == text.replace("1.400000e+000", "9.000000e-001")
    page.keyboard.press("Escape")
    write(page, "TI", "40")
    page.click("#undo-button")
    page.click("#redo-button")
    checked(page)
    assert (field(page, "TI").input_value(), in_force(page, "TI")) == ("40", 30)


def test_enter_applies_all_that_is_edited(page):
    new_loop(page, "CONT_C")
    write(page, "TI", "44")
    write(page, "GAIN", "3.1")
    field(page, "GAIN").press("Enter")
    checked(page)
    assert (in_force(page, "GAIN"), in_force(page, "TI")) == (3.1, 44)


@pytest.mark.parametrize("key", ["F1", "?"])
def test_a_key_opens_the_help_of_the_field_and_esc_closes_it(page, key):
    new_loop(page, "CONT_C")
    field(page, "DEADB_W").focus()
    page.keyboard.press(key)
    help = page.get_by_role("region", name="Help on DEADB_W")
    help.wait_for()
    assert "band" in help.inner_text()
    assert "Start value 0" in help.inner_text()
    page.keyboard.press("Escape")
    assert help.count() == 0
    assert field(page, "DEADB_W").evaluate("field => field === document.activeElement")


def test_the_characteristic_of_the_pulse_former_follows_its_settings(page):
    new_loop(page, "PULSEGEN")
    page.locator(".characteristic svg").first.wait_for()
    curve = page.locator(".characteristic polyline").first
    before = curve.get_attribute("points")
    name = "P_B_TM"
    write(page, name, "0.2")
    page.wait_for_function(
        "before => document.querySelector('.characteristic polyline')?.getAttribute('points') !== before", arg=before
    )


def test_a_curve_that_is_flat_is_not_drawn(page):
    new_loop(page, "CONT_C")
    flat = page.locator(".characteristic").get_by_text("LMN over MAN")
    # In manual mode, the output follows the manual value; in automatic mode it does not.
    flat.first.wait_for()
    field(page, "MAN_ON").uncheck()
    flat.first.wait_for(state="detached")


# The diagram


def test_the_diagram_shows_the_values_that_plcfmu_run_computes(page, command, tmp_path):
    new_loop(page, "CONT_C", "TIC")
    show_tab(page, "Diagram")
    for name, text in {"SP_INT": "60", "PV_IN": "20.1", "GAIN": "1.7", "TI": "7.5"}.items():
        write(page, name, text)
    page.click("#send")
    checked(page)
    make_calls(page, 5)
    page.locator('#diagram [data-variable="MAN_ON"][role="button"]').click()
    checked(page)
    make_calls(page, 7)
    given = [command, "run", f"TIC={host.FOLDER / 'CONT_C.fmu'}", "--step=1", "--stop=12", "--out=-"]
    settings = {"SP_INT": 60, "PV_IN": 20.1, "GAIN": 1.7, "TI": 7.5, "MAN_ON": "false@5"}
    given += [f"--set=TIC.{name}={value}" for name, value in settings.items()]
    outputs = ["PV", "ER", "LMN_P", "LMN_I", "LMN_D", "LMN", "LMN_PER"]
    given += [f"--record=TIC.{name}" for name in outputs]
    done = subprocess.run(given, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    head, *_, last = done.stdout.splitlines()
    expected = dict(zip(head.split(","), last.split(","), strict=True))
    values = page.evaluate('async () => (await moduleOf("tool/store.js")).store.state.values')
    for name in outputs:
        text = page.locator(f'#diagram [id$="value-{name}"]').text_content()
        (column,) = [column for column in expected if column.split(" ")[0] == f"TIC.{name}"]
        assert float(values[f"TIC.{name}"]).hex() == float(expected[column]).hex(), name
        assert float(text) == pytest.approx(float(expected[column]), rel=1e-5), name


def test_a_switch_of_the_diagram_is_thrown_by_a_click_and_by_enter(page):
    new_loop(page, "CONT_C")
    show_tab(page, "Diagram")
    switch = page.locator('#diagram [data-variable="D_SEL"][role="button"]')
    assert switch.get_attribute("aria-pressed") == "false"
    switch.click()
    checked(page)
    assert in_force(page, "D_SEL") is True
    assert switch.get_attribute("aria-pressed") == "true"
    assert switch.locator('[data-value="TRUE"]').get_attribute("visibility") is None
    assert switch.locator('[data-value="FALSE"]').get_attribute("visibility") == "hidden"
    assert page.locator("#structure").input_value() == "PID"
    switch.focus()
    page.keyboard.press("Enter")
    checked(page)
    assert in_force(page, "D_SEL") is False


def test_a_click_on_a_value_of_the_diagram_goes_to_its_field(page):
    new_loop(page, "CONT_C")
    show_tab(page, "Diagram")
    page.locator('#diagram [id$="value-LMN_HLM"]').click()
    assert field(page, "LMN_HLM").evaluate("field => field === document.activeElement")
    page.locator('#diagram [id$="value-TD"]').click()
    assert field(page, "TD").evaluate("field => field === document.activeElement"), "out of its fold"


def test_a_limit_is_lit_while_it_acts(page):
    new_loop(page, "CONT_C")
    show_tab(page, "Diagram")
    limit = page.locator('#diagram [id$="terminal-QLMN_HLM"]')
    write(page, "MAN", "120")
    field(page, "MAN").press("Enter")
    checked(page)
    make_calls(page, 1)
    assert "is-true" in (limit.get_attribute("class") or "")
    write(page, "MAN", "50")
    field(page, "MAN").press("Enter")
    checked(page)
    make_calls(page, 1)
    assert "is-true" not in (limit.get_attribute("class") or "")


# Keys


def test_a_loop_is_opened_edited_and_sent_by_keyboard_alone(page):
    def until(selector):
        for _ in range(200):
            if page.evaluate("selector => document.activeElement.matches(selector)", selector):
                return
            page.keyboard.press("Tab")
        pytest.fail(f"Tab does not come to {selector}")

    until("#new-name")
    page.keyboard.type("KEYS")
    page.keyboard.press("Enter")
    field(page, "GAIN").wait_for()
    checked(page)
    until("#field-GAIN")
    page.keyboard.press("Control+A")
    page.keyboard.type("7.5")
    page.keyboard.press("Enter")
    checked(page)
    assert in_force(page, "GAIN") == 7.5
    page.keyboard.press("Control+Z")
    assert field(page, "GAIN").input_value() == "2"
    page.keyboard.press("Control+Y")
    assert field(page, "GAIN").input_value() == "7.5"
    until("#structure")
    page.keyboard.press("p")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Control+Enter")
    checked(page)
    assert page.locator("#edited-count").inner_text() == "All in force"
    until("#tab-plant")
    page.keyboard.press("ArrowLeft")
    until('#diagram [data-variable="MAN_ON"]')
    page.keyboard.press("Enter")
    checked(page)
    assert in_force(page, "MAN_ON") is False


def test_keys_outside_of_fields_reach_the_panels_and_in_fields_they_do_not(page):
    new_loop(page, "CONT_C")
    listen = """async () => {
        const { store } = await moduleOf("tool/store.js");
        window.heard = [];
        for (const key of ["run", "call", "manual", "left", "right"]) store.on(`key-${key}`, () => window.heard.push(key));
    }"""
    page.evaluate(listen)
    field(page, "GAIN").focus()
    page.keyboard.type("m.")
    assert page.evaluate("window.heard") == []
    page.keyboard.press("Escape")
    page.evaluate("document.activeElement.blur()")
    for key in (" ", ".", "m", "ArrowLeft", "ArrowRight"):
        page.keyboard.press(key)
    assert page.evaluate("window.heard") == ["run", "call", "manual", "left", "right"]


def test_the_list_of_keys_opens_and_closes(page):
    new_loop(page, "CONT_C")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("?")
    assert "runs one cycle" in page.locator("#help").inner_text()
    assert "anti-windup" in page.locator("#help").inner_text()
    page.keyboard.press("Escape")
    assert page.locator("#help").is_hidden()


# The page


def test_two_tabs_do_not_disturb_each_other(page):
    new_loop(page, "CONT_C", "FIRST")
    other = page.context.new_page()
    other.goto(PAGE.as_uri())
    other.locator("#new-block option").first.wait_for(state="attached")
    assert other.locator("table.loops").count() == 0
    new_loop(other, "CONT_C", "SECOND")
    make_calls(page, 5)
    make_calls(other, 2)
    write(other, "GAIN", "9")
    assert ask(page, do="events")["calls"] == 5
    assert field(page, "GAIN").input_value() == "2"


def test_a_lost_server_is_said_and_the_page_goes_on_by_itself(browser):
    """The page is that of the server; what it asks is answered here, until the server is lost."""
    html = PAGE.read_text().replace('name="plcfmu-home" content="page"', 'name="plcfmu-home" content="server"')
    html = html.replace("connect-src 'none'", "connect-src 'self'")
    context = browser.new_context(viewport={"width": DESKTOP, "height": 900})
    context.set_default_timeout(10_000)
    page = context.new_page()
    answers = {
        "catalogue": {"fmus": [{"name": "CONT_C", "summary": "", "part": "controller", "is_foreign": False}], "loops": [], "formats": []},
        "describe": DESCRIPTION,
        "check": {"remarks": [], "unused": [], "rounded": {}},
    }
    is_there = True

    def answer(route):
        if not is_there:
            route.abort()
        elif not route.request.url.endswith("/message"):
            route.fulfill(body=html, content_type="text/html")
        elif route.request.post_data_json["do"] in answers:
            route.fulfill(body=json.dumps({"ok": answers[route.request.post_data_json["do"]]}))
        else:
            route.fulfill(body=json.dumps({"error": {"message": "The server of this test cannot do that."}}))

    page.route("**/*", answer)
    page.goto("http://127.0.0.1:9/token/")
    page.locator("#new-block option").first.wait_for(state="attached")
    page.fill("#new-name", "SERVED")
    page.click("text=New loop")
    field(page, "GAIN").wait_for()
    is_there = False
    field(page, "GAIN").fill("5")
    page.locator("#lost").wait_for()
    assert field(page, "GAIN").input_value() == "5"
    assert page.locator("#what strong").inner_text() == "SERVED"
    page.click("text=Continue in the page without FMUs")
    page.locator("#lost").wait_for(state="detached")
    page.click("#send")
    checked(page)
    assert in_force(page, "GAIN") == 5
    make_calls(page, 2)
    assert ask(page, do="events")["calls"] == 2
    context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_axe_finds_nothing_and_nothing_scrolls_sideways(open_tool, width, scheme):
    page = open_tool(width, scheme=scheme)
    look(page, f"empty-{width}-{scheme}")
    open_file(page, "wrong.awl", 'DATA_BLOCK "A"\n FB 41\nBEGIN\n GAIN := x;\nEND_DATA_BLOCK\n')
    page.locator(".is-refused").wait_for()
    look(page, f"refused-{width}-{scheme}")
    page.set_input_files("#open-files", PLANT)
    page.click("table.loops >> text=TIC101")
    field(page, "GAIN").wait_for()
    write(page, "GAIN", "3.1")
    write(page, "LMN_HLM", "wrong")
    make_calls(page, 3)
    look(page, f"loop-{width}-{scheme}")
    page.click("#compare-button")
    look(page, f"compare-{width}-{scheme}")
    page.click("#help-button")
    look(page, f"help-{width}-{scheme}")
    page.keyboard.press("Escape")
    row(page, "TI").get_by_role("button").click()
    look(page, f"panels-{width}-{scheme}")


def look(page, name):
    """Keeps a screenshot in target/screenshots, and looks for what is hard to read or to reach."""
    from axe_playwright_python.sync_playwright import Axe

    folder = ROOT / "target/screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=folder / f"tool-{name}.png")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
    findings = Axe().run(page).response["violations"]
    nodes = [(one["id"], node["html"][:160], node["failureSummary"]) for one in findings for node in one["nodes"]]
    assert nodes == [], name


def test_print_shows_parameters_and_diagram(page):
    new_loop(page, "CONT_C")
    page.emulate_media(media="print")
    assert page.locator("#parameters").is_visible()
    assert page.locator("#diagram svg").is_visible()
    assert not page.locator("#commands").is_visible()
    assert page.pdf(format="A4").startswith(b"%PDF")
