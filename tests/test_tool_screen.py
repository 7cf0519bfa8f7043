"""The parameter tool as one screen: what is to be seen where, at each size, and that nothing jumps; links; the words of the page.

The page is that of PLCFMU_TOOL, or target/tool/plcfmu-tool.html (`cargo xtask tool`). `python tests/screenshots.py` writes every
state of it as a picture.
"""

import pathlib
import re

import pytest

import test_tool_run
from test_palette import COLORS
from test_tool_run import browser, manual, open_tool, run_calls, saved, set_now, tool  # noqa: F401
from tool import new_loop, show_tab

pytestmark = test_tool_run.pytestmark


def open_example(page, title):
    page.evaluate("document.querySelector('.all-examples').open = true")
    page.locator(".card").filter(has_text=title).click()
    page.locator("#run .status").get_by_text("cycles").wait_for(state="attached")
    page.wait_for_function("() => [...document.querySelectorAll('#curves [role=slider]')].some(one => one.ariaValueMax > 0)")


def box(page, selector):
    return page.locator(selector).first.bounding_box()


def bottom(of):
    return of["y"] + of["height"]


@pytest.mark.parametrize("height", (768, 650))
def test_curve_run_bar_and_tabs_are_on_one_screen(open_tool, height):
    page = open_tool((1366, height))
    open_example(page, "Furnace with a continuous")
    chart, bar, tabs = (box(page, selector) for selector in ("#curves .chart", "#run", "#tabs"))
    assert chart["height"] >= 360
    assert bar["height"] <= 84 + 1
    assert bottom(chart) <= bar["y"] and bottom(tabs) <= height and bottom(bar) <= height
    if height < 700:
        # No room below the curve: what a tab shows stands beside it.
        assert tabs["x"] >= chart["x"] + chart["width"] and box(page, "#panels")["height"] > 400
    else:
        assert bottom(bar) <= tabs["y"]
    # The time axis is part of the chart, and nothing scrolls but the parameters and what is in a tab.
    assert bottom(box(page, "#curves .u-axis")) <= bottom(chart)
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    assert page.evaluate("(p => p.scrollHeight > p.clientHeight)(document.querySelector('#parameters'))")


# What stands in a row: pairs that overlap, and elements that are cut by the box that holds them, each as its text.
CUT = """() => {
  const shown = (selector) => [...document.querySelectorAll(selector)].filter((one) => one.checkVisibility() && one.textContent.trim());
  const told = (one) => `${one.className || one.tagName}: ${one.textContent}`;
  const found = [];
  for (const signal of document.querySelectorAll("#curves .signal")) {
    const parts = [...signal.children].filter((one) => one.checkVisibility() && one.textContent.trim());
    parts.slice(1).forEach((one, at) => {
      if (one.getBoundingClientRect().left < parts[at].getBoundingClientRect().right - 1) found.push(`${told(parts[at])} | ${told(one)}`);
    });
  }
  const bar = document.querySelector("#curves .curves-bar").getBoundingClientRect();
  // The row of signals scrolls: what is beyond its edge is not seen.
  const row = document.querySelector("#curves .readout");
  const room = row.getBoundingClientRect();
  if (!(room.right <= bar.left || room.bottom <= bar.top + 1) || !["auto", "scroll"].includes(getComputedStyle(row).overflowX))
    found.push(`${told(row)} | bar`);
  const outside = (one, holder) => {
    const [box, room] = [one.getBoundingClientRect(), holder.getBoundingClientRect()];
    if (box.right > room.right + 1) found.push(told(one));
  };
  const commands = document.querySelector("#commands");
  if (commands.scrollWidth > commands.clientWidth) found.push(`#commands: ${commands.scrollWidth} px in ${commands.clientWidth}`);
  for (const one of shown("#run button, #run label")) outside(one, one.closest(".controls") ?? one.closest(".row") ?? one.parentElement);
  for (const one of shown(".field .unit, .field .tag"))
    if (one.scrollWidth > one.clientWidth + 1 || one.getClientRects().length > 1) found.push(told(one));
  return found;
}"""


@pytest.mark.parametrize("size", [(1366, 768), (1366, 650), (1920, 1000), (390, 844)])
@pytest.mark.parametrize("example", ["Furnace with a continuous", "Chamber with heating pulses", "Your own program"])
def test_no_value_lies_on_another_and_no_button_is_cut(open_tool, size, example):
    page = open_tool(size)
    open_example(page, example)
    page.wait_for_function("() => document.querySelector('#glance')?.textContent.includes('rise')")
    assert page.evaluate(CUT) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_the_first_call_of_the_first_example_sees_the_temperature_of_the_furnace_and_it_tells_the_figures_of_its_step(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    page.wait_for_function("() => document.querySelector('#glance').textContent.includes('settles')")
    ask = "async (request) => (await moduleOf('tool/engine.js')).ask(request)"
    told = page.evaluate(ask, {"do": "figures"})
    figures = {figure["key"]: figure["value"] for figure in told["figures"]}
    view = {"do": "view", "variables": ["CONT_C.PV", "CONT_C.LMN"], "from": 0, "to": 599, "points": 600}
    value, output = page.evaluate(ask, view)["values"]
    # Members act in parallel, as in `plcfmu run`: the outputs at 0 s are those before the first call.
    assert (value[0], output[0]) == (0, 0)
    # They are no state of the loop, and are not drawn.
    drawn = page.evaluate("async () => (await moduleOf('tool/curves.js')).shownPicture().values")
    assert all(of[0] is None for of in drawn) and min(one for one in drawn[1] if one is not None) > 19
    # 1382 of 27648 for 0 ... 400 degC are 19.994 degC; LMN = 0.7 (60 - PV) + 0.7 (60 - PV) / 130.
    assert value[1] == pytest.approx(1382 * 400 / 27648) and output[1] == pytest.approx(0.7 * 40.0058 * (1 + 0.5 / 130), abs=0.12)
    assert figures["overshoot"] == pytest.approx(100 * (max(value) - 60) / (60 - value[1]))
    first = {share: next(at for at, one in enumerate(value) if one >= value[1] + share * (60 - value[1])) for share in (0.1, 0.9)}
    assert figures["rise"] == pytest.approx(first[0.9] - first[0.1], abs=1)
    assert figures["peak_deviation" if "peak_deviation" in figures else "peak"] == pytest.approx(60 - value[1])


def test_on_a_phone_the_curve_comes_first_and_parameters_are_a_tab(open_tool):
    page = open_tool((390, 844))
    open_example(page, "Furnace with a continuous")
    chart, bar = box(page, "#curves .chart"), box(page, "#run")
    assert chart["y"] < bar["y"] and chart["height"] >= 844 * 0.45 and bottom(bar) <= 844
    show_tab(page, "Parameters")
    assert page.locator("#field-GAIN").is_visible()
    show_tab(page, "Plant")
    assert page.locator("#field-GAIN").is_hidden()


def test_from_1600_px_on_the_tabs_stand_beside_the_curve(open_tool):
    page = open_tool((1920, 1000))
    open_example(page, "Furnace with a continuous")
    chart, tabs = box(page, "#curves .chart"), box(page, "#tabs")
    assert tabs["x"] >= chart["x"] + chart["width"] and tabs["y"] <= chart["y"]


def test_the_tab_is_remembered_and_the_edge_moves_by_keys(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Level of a tank with")
    show_tab(page, "Runs")
    before = box(page, "#panels")["height"]
    page.locator("#split").focus()
    page.keyboard.press("ArrowUp")
    assert box(page, "#panels")["height"] == before + 24
    page.reload()
    page.locator("#runs .runs").wait_for()
    assert box(page, "#panels")["height"] == before + 24


def test_a_link_makes_the_same_run_to_the_same_bits_elsewhere(tool, open_tool):
    set_now(tool, "setpoint", 60)
    manual(tool).uncheck()
    run_calls(tool, 30)
    set_now(tool, "disturbance", 5)
    tool.locator("#field-GAIN").fill("1.5")
    tool.locator("#field-GAIN").press("Enter")
    run_calls(tool, 30)
    _, first = saved(tool, "CSV of everything")
    link = tool.evaluate("async () => (await moduleOf('tool/link.js')).linkOfLoop()")
    other = open_tool()
    other.evaluate("fragment => { location.hash = fragment; }", link.split("#")[1])
    other.wait_for_function("() => / 60 cycles/.test(document.querySelector('#run .status').textContent)")
    _, second = saved(other, "CSV of everything")
    assert second == first
    assert other.locator("#field-GAIN").input_value() == "1.5"
    other.evaluate("() => { location.hash = 'loop=AAAA'; }")
    other.get_by_text("The link is incomplete").wait_for()


def test_what_is_sent_between_two_calls_stays(tool):
    run_calls(tool, 5)
    for name, value in (("GAIN", "0.7"), ("TI", "120"), ("TD", "3")):
        tool.locator(f"#field-{name}").evaluate("(field, value) => { field.value = value; }", value)
        tool.locator(f"#field-{name}").dispatch_event("input")
        send = "async name => (await moduleOf('tool/store.js')).store.send([name])"
        assert tool.evaluate(send, name) is True
    assert [tool.locator(f"#field-{name}").input_value() for name in ("GAIN", "TI", "TD")] == ["0.7", "120", "3"]
    run_calls(tool, 1)
    _, table = saved(tool, "CSV of everything")
    values = test_tool_run.recorded(table.decode())
    last = [test_tool_run.number(values[f"TIC101.{name}"][-1]) for name in ("GAIN", "TI", "TD")]
    assert last == pytest.approx([0.7, 120, 3])


def test_a_figure_without_a_unit_has_no_square_of_it(open_tool):
    page = open_tool()
    shown = "async unit => (await moduleOf('tool/figures.js')).shownUnit(unit)"
    assert [page.evaluate(shown, unit) for unit in ("degC^2 s", "^2 s", "%", None)] == ["°C²·s", "s", "%", ""]
    # Steps that differ by less than the band in which they settle, 2 % of them, are compared; other sizes and times are not.
    compared = "async other => (await moduleOf('tool/figures.js')).areComparable({ from: 50, to: 60, duration: 600 }, { to: 60, duration: 600, ...other })"
    assert [page.evaluate(compared, other) for other in ({"from": 50.13}, {"from": 50.3}, {"from": 50, "duration": 500})] == [True, False, False]


OVERLAPS = """selectors => [...document.querySelectorAll('.notice')].flatMap(note => {
    const one = note.getBoundingClientRect();
    return selectors.filter(selector => {
        const other = document.querySelector(selector).getBoundingClientRect();
        return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
    });
})"""


@pytest.mark.parametrize("state", ["t = 599 s, 600 cycles", "t = 2182 s, settled, 2183 cycles", "t = 2182 s, swings, 2183 cycles"])
def test_on_a_laptop_the_state_of_the_run_is_read_to_its_end_and_no_unit_is_under_a_button(open_tool, state):
    page = open_tool((1280, 800))
    open_example(page, "Furnace with a continuous")
    words = page.locator("#run .status")
    words.evaluate("(words, state) => { words.textContent = state; }", state)
    assert words.evaluate("one => [one.scrollWidth <= one.clientWidth, one.scrollHeight <= one.clientHeight]") == [True, True]
    unit = box(page, "#run .run-for span")
    assert unit["x"] + unit["width"] <= box(page, "#run button:text-is('Reset')")["x"]


def test_rows_of_controls_have_room_between_them(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    show_tab(page, "Plant")
    page.locator("#away-button").click()
    edges = "all => all.map(one => one.getBoundingClientRect()).map(({ top, bottom }) => [top, bottom])"
    for rows in ("#plant .sentences select", "#takeaway .row button:first-of-type, #takeaway .row .button"):
        places = sorted(page.locator(rows).evaluate_all(edges))
        assert len(places) >= 2
        assert all(below[0] - above[1] >= 7.5 for above, below in zip(places, places[1:])), (rows, places)


def test_at_twice_the_size_a_curve_is_on_the_first_screen(open_tool):
    page = open_tool((683, 384))
    open_example(page, "Furnace with a continuous")
    plot = box(page, "#curves canvas")
    assert min(bottom(plot), 384) - max(plot["y"], 0) >= 150


@pytest.mark.parametrize("height", (768, 650))
def test_what_is_tuned_is_in_sight_below_a_list_of_forty_loops(open_tool, height):
    page = open_tool((1366, height))
    page.locator("#open-files").set_input_files(test_tool_run.LOOPS)
    page.get_by_role("button", name="TIC103", exact=True).click()
    page.locator("#field-GAIN").wait_for()
    for name in ("GAIN", "TI"):
        assert bottom(box(page, f"#field-{name}")) <= height - 48, name
    # The end of the list can be reached above a note.
    page.evaluate("async () => (await moduleOf('tool/store.js')).store.say('Something that one should know.')")
    page.locator(".notice").wait_for()
    page.wait_for_function(f"() => ({OVERLAPS})(['#parameters']).length === 0")


def test_on_a_phone_a_note_covers_neither_the_values_nor_the_curve(open_tool):
    page = open_tool((390, 844))
    new_loop(page, "TIC101")
    page.evaluate("async () => (await moduleOf('tool/store.js')).store.say('Something that one should know.')")
    page.locator(".notice").wait_for()
    assert page.evaluate(OVERLAPS, ["#bar", "#curves .readout", "#curves .chart"]) == []


def test_the_title_of_a_data_block_stands_beside_its_name(open_tool):
    page = open_tool((1366, 768))
    blocks = ["".join([f'DATA_BLOCK "{name}"\nTITLE ={title}\nVERSION : 0.1\n\n FB 41\nBEGIN\n   GAIN := 1.5;\nEND_DATA_BLOCK\n'])
              for name, title in (("TIC101", "Bottom of the column, Süd"), ("TIC102", ""))]
    source = "".join(blocks).encode("latin-1")
    page.locator("#open-files").set_input_files({"name": "plant.awl", "mimeType": "text/plain", "buffer": source})
    row = page.locator("#loops tr").filter(has_text="TIC101")
    assert "Bottom of the column, Süd" in row.inner_text()
    page.get_by_role("button", name="TIC102", exact=True).click()
    assert page.locator("#what .loop-title").count() == 0
    page.get_by_role("button", name="TIC101", exact=True).click()
    page.locator("#what").get_by_text("Bottom of the column, Süd").wait_for()


def test_no_unit_is_written_as_fmi_names_it(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    for tab in ("Plant", "Tune", "Runs", "Log", "Replay", "Diagram"):
        show_tab(page, tab)
        assert "degC" not in page.locator("body").inner_text(), tab
    assert "°C" in page.locator("#curves .readout").inner_text()


def test_a_file_that_is_opened_beside_a_loop_is_seen_at_once(open_tool):
    page = open_tool((1366, 768))
    new_loop(page, "TIC101")
    page.locator("#open-button").click()
    page.locator("#open-files").set_input_files(test_tool_run.LOOPS)
    page.locator(".notice").get_by_text(f"{test_tool_run.LOOPS.name}: 40 loops; choose one in the list").wait_for()
    # The drawer is gone, and the list stands above the parameters, with a filter for what it has no room for.
    assert page.locator("#opening").is_hidden()
    table = page.locator("#loops table")
    assert bottom(table.bounding_box()) - 1 <= page.locator("#parameters").bounding_box()["y"] < page.viewport_size["height"]
    page.get_by_role("searchbox").fill("TIC101")
    # Two of one name are told apart.
    rows = page.locator("#loops tbody tr")
    assert [("plant.awl" in text) for text in rows.all_inner_texts()] == [False, True]
    # What is wrong with another file stands there, too.
    page.locator("#open-files").set_input_files({"name": "other.awl", "mimeType": "text/plain", "buffer": b"DATA_BLOCK"})
    refused = page.locator("#loops .is-refused")
    refused.wait_for()
    assert bottom(refused.bounding_box()) < page.viewport_size["height"] and "other.awl" in refused.inner_text()
    # Help opens over the curves, in sight.
    page.locator("#help-button").click()
    box = page.locator("#help").bounding_box()
    assert box["x"] > 320 and bottom(box) <= page.viewport_size["height"]


def test_a_furnace_with_the_start_values_of_its_controller_keeps_swinging_and_is_not_said_to_rest(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    for name, value in [("GAIN", "2"), ("TI", "20")]:
        page.locator(f"#field-{name}").fill(value)
        page.locator(f"#field-{name}").press("Enter")
    page.get_by_role("button", name="Reset", exact=True).click()
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    page.get_by_role("button", name="Run", exact=True).click()
    page.locator("#run .status").get_by_text(", swings, ").wait_for()


def test_a_run_as_fast_as_it_goes_that_never_rests_ends_and_says_so(open_tool):
    page = open_tool((1366, 768))
    source = "FUNCTION_BLOCK Count VAR_OUTPUT n : DInt; END_VAR BEGIN n := n + 1; END_FUNCTION_BLOCK"
    page.locator("#open-files").set_input_files({"name": "count.scl", "mimeType": "text/plain", "buffer": source.encode()})
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    page.get_by_role("button", name="Run", exact=True).click()
    page.locator("#run .status").get_by_text("paused, not settled, 20000 cycles").wait_for(timeout=180_000)
    # Another Run goes on.
    page.get_by_role("button", name="Run", exact=True).click()
    page.locator("#run .status").get_by_text("40000 cycles").wait_for(timeout=180_000)


PLACES = """() => Object.fromEntries(['#curves', '#curves .chart', '#run', '#panels', '#tabs', '#fields'].map(selector => {
    const { left, top, width, height } = document.querySelector(selector).getBoundingClientRect();
    return [selector, selector === '#fields' ? [left, top] : [left, top, width, height]];
}))"""


@pytest.mark.parametrize("example", ["Your own program", "Furnace with a continuous"])
def test_nothing_jumps_when_a_tab_is_chosen_a_value_edited_or_a_curve_added(open_tool, example):
    page = open_tool((1366, 768))
    open_example(page, example)
    page.locator("#glance dd").first.wait_for()
    if not example.startswith("Furnace"):
        page.get_by_role("group", name="View").get_by_role("button", name="Curves").click()
    before = page.evaluate(PLACES)
    # What has no gain to be tuned has no tab for it.
    is_tunable = example.startswith("Furnace")
    assert page.get_by_role("tab", name="Tune").is_visible() == is_tunable
    for name in ("Diagram", "Plant", *(["Tune"] if is_tunable else []), "Runs", "Replay", "Log"):
        show_tab(page, name)
        assert page.evaluate(PLACES) == before, name
    field = page.locator("#fields .field input[type=text]:not([readonly]):visible").first
    field.fill("55")
    page.locator("#edited-count").get_by_text("not applied").wait_for()
    assert page.evaluate(PLACES) == before
    page.locator("#take-back").click()
    adding = page.locator(".curves-bar select").last
    curve = adding.locator("option").nth(1).get_attribute("value")
    adding.select_option(curve)
    page.locator(".readout .remove").last.wait_for()
    assert page.evaluate(PLACES) == before
    # What does not fit is scrolled to, and no row is higher than one.
    assert box(page, "#curves .readout")["height"] <= 40


def test_an_edit_moves_no_field_of_the_list(open_tool):
    page = open_tool((1366, 768))
    open_example(page, "Furnace with a continuous")
    heights = "() => [...document.querySelectorAll('#fields .field')].map(one => [one.dataset.name, one.getBoundingClientRect().height])"
    before = page.evaluate(heights)
    # A number without a range, one with a unit, a time, and a switch.
    for name, value in (("GAIN", "1.25"), ("SP_INT", "61.5"), ("TI", "120")):
        page.locator(f"#field-{name}").fill(value)
        grey = page.locator(f'.field[data-name="{name}"] .grey')
        assert "in force: " in grey.inner_text()
    page.locator("#field-PVPER_ON").click()
    page.locator("#edited-count").get_by_text("4 edited, not applied").wait_for()
    after = dict(page.evaluate(heights))
    # What has no effect any more is folded away.
    assert {name: height for name, height in before if name in after} == {name: after[name] for name, _ in before if name in after}
    # What is beside the field is read to its end.
    grey = page.locator('.field[data-name="GAIN"] .grey')
    assert grey.inner_text() == "in force: 0.7" and grey.evaluate("one => one.scrollWidth <= one.clientWidth")


# Words of the trade, and what stands for them nowhere in the page's own texts.
REFUSED = {
    "send, sent": "apply, in force",
    "at rest, rests": "settled",
    "figures": "metrics",
    "take back": "discard, restore",
    "nothing answers": "no plant is connected",
    "Same bits": "Repeat exactly",
    "Make again": "Repeat exactly",
    "One call": "One cycle",
}


def own_texts():
    """The texts of the page's scripts with a space or a capital, which people read, by file and line."""
    folder = pathlib.Path(__file__).parents[1] / "tool/web"
    for path in [folder / "index.html", *sorted((folder / "src").glob("*.js"))]:
        code = re.sub(r"/\*.*?\*/", lambda found: "\n" * found[0].count("\n"), path.read_text(), flags=re.S)
        code = re.sub(r"^\s*//.*$", "", code, flags=re.M)
        for found in re.finditer(r'"((?:[^"\\\n]|\\.)*)"|`((?:[^`\\]|\\.)*)`|>([^<>{}]+)<', code):
            # What is computed into a text is no text.
            words = re.sub(r"\$\{[^{}]*\}", "", found[1] or found[2] or (found[3] if path.suffix == ".html" else "") or "")
            if " " in words.strip() or words[:1].isupper():
                yield f"{path.name}:{code[: found.start()].count(chr(10)) + 1}", words


def test_curves_have_the_colours_of_the_palette(open_tool):
    page = open_tool()
    for name in ("curve-1-light", "curve-2-dark", "run-1-light"):
        color = page.evaluate("name => getComputedStyle(document.documentElement).getPropertyValue(name)", f"--{name}")
        assert color.strip() == COLORS[name]


def test_the_page_speaks_the_words_of_the_trade_and_passes_no_option_to_its_user():
    texts = list(own_texts())
    assert len(texts) > 500
    words = "|".join(word for refused in REFUSED for word in refused.split(", "))
    wrong = [(place, text) for place, text in texts if re.search(rf"\b({words})\b|(^|[\s`(])--[a-z]", text, re.I)]
    # The name of a class in a style sheet.
    assert [one for one in wrong if one[1] != "row send"] == []
