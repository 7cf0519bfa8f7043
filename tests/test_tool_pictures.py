"""What the page draws of a run: axes, bands, lanes, earlier runs, and the picture and report that are saved."""

import base64
import re

import pytest

import test_tool_run
from test_tool_run import automatic, browser, open_tool, readout, run_calls, saved, set_now, tool  # noqa: F401
from tool import add_sensor, new_loop, show_tab, until
from test_tool_screen import box, open_example

pytestmark = test_tool_run.pytestmark


def test_numbers_of_an_axis_are_told_apart_and_there_is_always_a_time(open_tool):
    page = open_tool()
    ask = "async ([name, splits, length]) => (await moduleOf('tool/charts.js'))[name](splits, length)"
    assert page.evaluate(ask, ["ticks", [59.99, 59.9925, 59.995], None]) == ["59.9900", "59.9925", "59.9950"]
    assert page.evaluate(ask, ["ticks", [0, 50, 100], None]) == ["0", "50", "100"]
    assert page.evaluate(ask, ["ticks", [1e7, 1.00001e7], None]) == ["1.000000e+7", "1.000010e+7"]
    # 10 000 000 s are 115 days and 17:46:40.
    assert page.evaluate(ask, ["clock", 10_000_000, 10_000_000]) == "115 d 18 h"
    steps = page.evaluate("async () => (await moduleOf('tool/charts.js')).TIME_STEPS")
    assert max(steps) >= 1e9


def test_an_overview_is_a_band_from_the_lowest_to_the_highest(open_tool):
    page = open_tool()
    draw = """async ([times, values, isExact]) => (await moduleOf('tool/outline.js'))
        .outline(times, values, { isExact, isStepped: false }, one => one, one => 100 - one)"""
    band = page.evaluate(draw, [[0, 1, 2, 3], [10, 30, 25, 5], False])
    assert band["fill"] == "M0 70H2V90H0ZM2 75H3V95H2Z"
    assert band["stroke"] == "M0 70H2V75H3M0 90H2V95H3"
    line = page.evaluate(draw, [[0, 1, 2, 3], [10, 30, None, 5], True])
    assert line == {"stroke": "M0 90L1 70M3 95", "fill": ""}


def test_a_thinned_picture_says_so_and_the_cursor_reads_a_range(tool):
    add_sensor(tool)
    set_now(tool, "noise", 0.25)
    run_calls(tool, 5000)
    tool.get_by_text(re.compile(r"min to max of every \d+ cycles")).wait_for()
    tool.locator("#curves").get_by_role("slider").focus()
    tool.keyboard.press("Home")
    tool.keyboard.press("ArrowRight")
    assert "…" in readout(tool)["PV"]
    tool.keyboard.press("End")
    tool.keyboard.press("Escape")
    tool.wait_for_function("() => !document.querySelector('#curves .readout').innerText.includes('…')")


def axes(page):
    """The axes by their scale: label and whether they are at the left."""
    return page.evaluate("""async () => (await moduleOf('tool/curves.js')).shownPicture().plot.axes.slice(1)
        .map(axis => [axis.scale, typeof axis.label === 'function' ? axis.label() : axis.label])""")


# The picture between two columns has room for one axis at the right, that on a laptop for several.
@pytest.mark.parametrize("size", ((1366, 768), (1366, 650), (390, 844)))
def test_one_unit_has_one_axis_and_what_the_plant_controls_is_drawn(open_tool, size):
    page = open_tool(size)
    open_example(page, "Drive behind a ramp")
    # The ramp and its setpoint are of one kind, the speed is another one.
    assert axes(page) == [["left", "S0, HLG"], ["unit rpm", "DRIVE.SPEED  rpm"]]


def test_the_mean_of_pulses_is_that_of_their_period(open_tool):
    page = open_tool()
    open_example(page, "Chamber with heating pulses")
    mean = float(readout(page)["Q_MEAN"])
    # One period are 20 calls, each of which is a pulse or none.
    assert 40 < mean < 60 and (mean * 20 / 100) == pytest.approx(round(mean * 20 / 100))
    show_tab(page, "Log")
    page.get_by_role("button", name="= Q_MEAN").click()
    page.wait_for_function("() => document.querySelector('#manual-value').value !== '0'")
    assert float(page.locator("#manual-value").input_value()) == pytest.approx(mean)


def test_a_picture_has_title_date_legend_and_marks(tool):
    run_calls(tool, 20)
    set_now(tool, "setpoint", 60)
    run_calls(tool, 20)
    _, picture = saved(tool, "Picture (SVG)")
    text = picture.decode()
    assert ">TIC101  CONT_C<" in text and re.search(r">\d{4}-\d\d-\d\d \d\d:\d\d UTC<", text)
    for words in ("SP_INT", "PV", "LMN in %", "SP_INT 60", "plant: PROCESS"):
        assert f">{words}<" in text, words


def test_words_of_a_picture_do_not_lie_on_each_other(tool):
    run_calls(tool, 20)
    # All of it before the same call, and more than there is room for.
    for name, value in (("GAIN", "1.5"), ("TI", "30"), ("LMN_HLM", "90"), ("LMN_LLM", "5"), ("DEADB_W", "0.1")):
        tool.locator(f"#field-{name}").fill(value)
        tool.locator(f"#field-{name}").press("Enter")
    set_now(tool, "setpoint", 60)
    run_calls(tool, 20)
    _, picture = saved(tool, "Picture (SVG)")
    boxes = tool.evaluate(
        """svg => {
            document.body.insertAdjacentHTML("beforeend", `<div id="shown-picture">${svg}</div>`);
            return [...document.querySelectorAll("#shown-picture text")].map(text => {
                const { left, right, top, bottom } = text.getBoundingClientRect();
                return { words: text.textContent, left, right, top, bottom };
            });
        }""",
        picture.decode(),
    )
    assert {"GAIN 1.5", "TI 30"} <= {box["words"] for box in boxes}
    assert any(re.search(r" \+\d$", box["words"]) for box in boxes)
    for at, one in enumerate(boxes):
        for other in boxes[at + 1 :]:
            across = min(one["right"], other["right"]) - max(one["left"], other["left"])
            down = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
            assert across <= 1 or down <= 3, (one, other)


def test_a_report_has_the_plant_the_runs_before_and_after_and_numbers_of_three_digits(open_tool):
    tool = open_tool()
    new_loop(tool, "TIC101")
    tool.locator("#curves").get_by_role("button", name="HEATER").click()
    automatic(tool)
    set_now(tool, "setpoint", 60)
    tool.locator("#field-TI").fill("30")
    tool.locator("#field-TI").press("Enter")
    for gain, start in (("1.5", lambda: run_calls(tool, 60)), ("1", tool.locator("#run-again").click)):
        tool.locator("#field-GAIN").fill(gain)
        tool.locator("#field-GAIN").press("Enter")
        start()
    tool.wait_for_function("() => document.querySelectorAll('.earlier span').length === 1")
    tool.wait_for_function("() => !document.querySelector('#glance').textContent.includes('–') && document.querySelector('#glance dd')")
    _, report = saved(tool, "Report (HTML)")
    text = report.decode()
    head = re.search(r"Before and after</h2>.*?</thead>", text, re.S)[0]
    assert "Run 1<br>GAIN 1.5" in head and "Run 2<br>GAIN 1<" in head
    # Before was what the loop ran with, not the block's start value.
    gain = re.search(r'<td class="name">GAIN</td>(.*)', text)[1]
    assert re.findall(r"number\">([^<]*)<", gain) == ["1", "1.5", "2"], gain
    # Nor what was in force before that run.
    assert "Before (Run 1)</th>" in text
    assert re.findall(r'<td class="name">TI</td>.*', text)[0].count('number">30<') == 2
    assert re.search(r"<td>Setpoint step</td>(<td[^>]*>20 to 60 °C, at 0 s</td>){2}", text)
    # A connected input has a source, and what the table of the block leaves open has the plant's unit.
    assert re.search(r'"name">PV_IN</td><td class="number">–</td>.*connected to \w+\.TEMP<', text)
    assert re.search(r'"name">SP_INT</td><td class="number">60</td><td>°C</td>', text)
    assert re.search(r'"name">LMN_HLM</td><td class="number">100</td><td>%</td>', text)
    iae = re.search(r"<tr><td>IAE</td>(.*?)</tr>", text)[1]
    values = re.findall(r">([\d.]+) K·s<", iae)
    assert len(values) == 2 and all(len(value.replace(".", "").strip("0")) <= 3 for value in values), iae
    assert "<p>Run 2: " in text and "HEATER</h2>" in text
    # The picture is that of the page: both runs.
    encoded = re.search(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]+)", text)[1]
    picture = base64.b64decode(encoded).decode()
    assert ">Run 1</text>" in picture
    # What is only predicted or tried is in no report.
    drawn = """async () => {
        const { store } = await moduleOf("tool/store.js");
        const { svgPicture } = await moduleOf("tool/picture.js");
        const pictures = () => Promise.all([true, false].map(isReport => svgPicture({ isReport, date: new Date(0) })));
        const before = await pictures();
        const [setpoint, process_value, manipulated_value] = [[60, 110, 110], [60, 61, 70], [10, 60, 60]];
        const curves = { ...{ times: [0, 1, 30], setpoint, process_value, manipulated_value } };
        const origin = { time: 10, processValue: 60, manipulatedValue: 10 };
        store.predict({ title: "SIMC", curves, origin });
        const after = await pictures();
        store.predict(undefined);
        return after.map((one, at) => one === before[at]);
    }"""
    assert tool.evaluate(drawn) == [True, False]


@pytest.mark.parametrize("example", ["Furnace with a continuous", "Drive behind a ramp", "Chamber with heating pulses"])
def test_the_numbers_of_the_right_axis_stand_at_the_lines_of_the_left(open_tool, example):
    page = open_tool((1366, 768))
    open_example(page, example)
    places = """async () => {
        const { plot } = (await moduleOf('tool/curves.js')).shownPicture();
        return plot.axes.slice(1).map(axis => axis.filter(plot, axis._splits).flatMap(split =>
            split === null ? [] : [plot.valToPos(split, axis.scale)]));
    }"""
    left, right = page.evaluate(places)
    assert len(left) >= 4 and right == pytest.approx(left, abs=0.5)


def test_runs_behind_the_present_one_have_no_row_before_the_first_call(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    page.locator("#field-GAIN").fill("1.4")
    page.locator("#field-GAIN").press("Enter")
    show_tab(page, "Runs")
    page.locator("#runs").get_by_role("button", name="Same test").click()
    behind = "async () => (await moduleOf('tool/curves.js')).shownPicture().behind.map(({ values }) => values.slice(0, 2))"
    until(page, f"async () => (await ({behind})()).length === 2")
    # Members act in parallel: at 0 s the controller has not been called, and PV is no temperature of the furnace.
    (no_value, value), (no_output, _) = page.evaluate(behind)
    assert (no_value, no_output) == (None, None) and value == pytest.approx(1382 * 400 / 27648)


def test_the_table_of_runs_fits_on_a_laptop_and_earlier_runs_are_named_in_the_picture(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    for name, value in (("GAIN", "1.4"), ("TI", "80"), ("DEADB_W", "0.5")):
        page.locator(f"#field-{name}").fill(value)
        page.locator(f"#field-{name}").press("Enter")
    show_tab(page, "Runs")
    page.locator("#runs").get_by_role("button", name="Same test").click()
    page.get_by_text("DEADB_W 0.5").wait_for()
    page.locator("#curves .earlier").get_by_text("Run 1").wait_for()
    assert page.locator("#runs .wide").evaluate("one => one.scrollWidth - one.clientWidth") <= 0
    # A run that is not drawn is not named.
    page.locator("#runs").get_by_role("checkbox", name="Show Run 1").click()
    page.locator("#curves .earlier").get_by_text("Run 1").wait_for(state="detached")


def test_the_mean_of_the_pulses_of_an_earlier_run_is_a_curve_in_percent(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Chamber with heating pulses")
    show_tab(page, "Runs")
    page.locator("#runs").get_by_role("button", name="Same test").click()
    page.locator("#curves .earlier").get_by_text("Run 1").wait_for()
    shown = "async () => (await moduleOf('tool/curves.js')).shownPicture()"
    behind, present = page.evaluate(f"""async () => {{
        const {{ behind, values, curves }} = await ({shown})();
        const at = curves.findIndex(({{ label }}) => label === 'Q_MEAN');
        return [behind[1].values.filter(value => value !== null), values[at]];
    }}""")
    # Pulses are 0 or 100; their mean over the last period is 50.
    assert behind[-1] == present[-1] == 50
    assert axes(page)[1] == ["right", "Q_MEAN  %"]


def test_a_curve_without_an_axis_of_its_own_lies_on_one_that_names_it(open_tool):
    source = """FUNCTION_BLOCK Three VAR_OUTPUT a : Real; // unit: degC
        b : Real; // unit: %
        state : Int; END_VAR BEGIN a := 50.0; b := 70.0; state := 0; END_FUNCTION_BLOCK"""
    page = open_tool((390, 844))
    page.locator("#open-files").set_input_files({"name": "three.scl", "mimeType": "text/plain", "buffer": source.encode()})
    page.get_by_role("button", name="One cycle").or_(page.get_by_role("button", name="Run", exact=True)).first.wait_for()
    page.evaluate("async () => (await moduleOf('tool/store.js')).store.calls(20)")
    page.wait_for_function("() => [...document.querySelectorAll('#curves [role=slider]')].some(one => one.ariaValueMax > 0)")
    named = ", ".join(label for _, label in axes(page))
    assert all(name in named for name in ("a", "b", "state")), named
    # What is drawn at the height of a number has that value.
    at = """async () => { const { bringUpToDate, shownPicture } = await moduleOf('tool/curves.js');
        await bringUpToDate();
        const { plot, curves } = shownPicture();
        return curves.map(({ label }, at) => [label, plot.posToVal(plot.valToPos(plot.data[at + 1].at(-1), plot.series[at + 1].scale), plot.series[at + 1].scale)]) }"""
    values = dict(page.evaluate(at))
    assert values["state"] == pytest.approx(0, abs=1e-6) and values["a"] == pytest.approx(50, abs=1e-6)


def test_an_axis_of_percent_ends_at_100_and_an_empty_one_has_no_numbers(open_tool):
    page = open_tool((1366, 768))
    new_loop(page, "TIC101")
    numbers = """async () => {
        const { plot } = (await moduleOf('tool/curves.js')).shownPicture();
        return plot.axes.slice(1).map(axis => axis._values.filter(value => value)) }"""
    assert page.evaluate(numbers) == [[], []]
    for example in ("Furnace with a continuous", "Level of a tank with", "Zone of a furnace"):
        page = open_tool((1366, 768))
        if page.locator(".card").filter(has_text=example).count() == 0:
            continue
        open_example(page, example)
        left, right = page.evaluate(numbers)
        assert len(left) >= 3 and max(map(float, right)) <= 100, example
