"""The first page of the parameter tool: its living curve, its examples, and what it says of itself."""

import importlib.util
import re

import pytest

import test_tool_run
from test_tool_run import browser, made, open_tool  # noqa: F401
from tool import PAGE
from test_tool_screen import box, open_example

pytestmark = test_tool_run.pytestmark


def test_help_opens_on_the_first_page_too_and_esc_closes_it(open_tool):
    page = open_tool((1366, 768))
    page.keyboard.press("F1")
    assert "runs one cycle" in page.locator("#help").inner_text()
    page.keyboard.press("Escape")
    assert page.locator("#help").is_hidden()


def test_the_first_page_lives_and_an_example_runs_when_it_is_clicked(open_tool):
    page = open_tool((1366, 768))
    assert "bit for bit" in page.locator(".promise").inner_text()
    seconds = "() => Number(/(\\d+) s$/.exec(document.querySelector('.living figcaption')?.innerText)?.[1])"
    page.wait_for_function("() => document.querySelectorAll('.card .spark[data-known] svg').length === 15")
    page.wait_for_function(f"() => ({seconds})() > 155")
    assert "Furnace with a continuous" in page.locator(".card:has([data-known])").first.inner_text()
    open_example(page, "Level of a tank with")
    assert made(page) == 1200
    # What its description sets has come: the drain at 600 s.
    assert page.locator("#disturbance").input_value() == "100"


def test_six_examples_by_question_are_on_the_first_screen_and_the_others_one_click_away(open_tool):
    page = open_tool((1366, 650))
    bottoms = page.locator(".card:visible").evaluate_all("all => all.map(one => one.getBoundingClientRect().bottom)")
    assert len(bottoms) == 6 and max(bottoms) <= 650
    assert all(line.endswith("?") for line in page.locator(".card:visible strong").all_inner_texts())
    page.get_by_text("10 more examples").click()
    assert page.locator(".card:visible").count() == 16


def test_the_first_page_says_which_plc_and_its_picture_has_axes(open_tool):
    page = open_tool((1366, 650))
    promise = page.locator(".promise").inner_text()
    assert all(word in promise for word in ("S7", "FB 41", "FB 42", "FB 43", "SCL", "STEP 7", "TIA Portal")), promise
    high, low = page.locator(".living .mark").all_inner_texts()
    assert float(low.removesuffix(" °C")) < float(high.removesuffix(" °C")) <= 61
    times = [int(text.removesuffix(" s")) for text in page.locator(".living .times span").all_inner_texts()]
    assert [time - times[0] for time in times] == [0, 120, 240, 360]


def test_the_first_page_has_a_curve_before_the_engine_is_ready_and_it_is_the_engines(open_tool, browser):
    page = browser.new_context(viewport={"width": 1366, "height": 768}).new_page()
    # An engine that never comes.
    page.add_init_script("WebAssembly.compile = WebAssembly.instantiate = () => new Promise(() => {}); window.Worker = class { postMessage() {} }")
    page.goto(PAGE.as_uri())
    page.locator(".living svg path").first.wait_for(state="attached")
    shown = page.locator(".living figcaption").inner_text()
    assert re.sub(r"\s+", " ", shown) == "SP 60 °C PV 60.1 °C LMN 13 % 149 s"
    assert page.locator(".card").count() == 0
    page.context.close()

    page = open_tool((1366, 768))
    recorded, (setpoint, value, output) = page.evaluate("""async () => {
        const { EVERY, FIRST, SETPOINT, PROCESS_VALUE, MANIPULATED_VALUE } = await moduleOf('tool/recorded.js');
        const { store } = await moduleOf('tool/store.js');
        const { ask } = await moduleOf('tool/engine.js');
        const { setup } = store.catalogue.loops.find(({ name }) => name === 'furnace');
        // Nothing of the first page runs any more.
        store.live = {};
        await ask({ do: 'start', ...setup });
        await ask({ do: 'run', calls: 150 });
        const variables = ['CONT_C.SP_INT', 'CONT_C.PV', 'CONT_C.LMN'];
        const { values } = await ask({ do: 'view', variables, points: 1000 });
        return [[EVERY, FIRST, SETPOINT, PROCESS_VALUE, MANIPULATED_VALUE], values];
    }""")
    every, first, goal, values, outputs = recorded
    assert {goal} == set(setpoint) and len(values) == len(outputs) == 50
    assert values == pytest.approx(value[first::every], abs=0.0501)
    assert outputs == pytest.approx(output[first::every], abs=0.0501)


def test_the_curve_of_the_first_page_is_there_before_the_panels_that_it_does_not_show(browser):
    page = browser.new_context().new_page()
    page.add_init_script("""new MutationObserver(() => {
        if (globalThis.madeBefore === undefined && document.querySelector('.living svg path'))
            globalThis.madeBefore = document.querySelectorAll('#tabs button, #run button, #tune button').length;
    }).observe(document, { childList: true, subtree: true })""")
    page.goto(PAGE.as_uri())
    page.locator("#new-block option").first.wait_for(state="attached")
    assert page.evaluate("madeBefore") == 0
    assert page.locator("#tabs button, #run button, #tune button").count() >= 8
    page.context.close()


def test_an_example_from_far_down_the_page_of_a_phone_shows_its_curve(open_tool):
    page = open_tool((390, 844))
    open_example(page, "Process behind a sensor")
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    curve = box(page, "#curves")
    assert 0 <= curve["y"] < 200


def test_the_animation_of_the_front_page_shows_what_its_text_says(open_tool):
    folder = test_tool_run.ROOT / "docs/tool"
    spec = importlib.util.spec_from_file_location("pictures", folder / "pictures.py")
    pictures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pictures)
    page = open_tool((1366, 768))
    frames = list(pictures.frames(page))
    assert len(set(frames)) > 40 and (folder / "run.gif").stat().st_size < 2_000_000
    first, second = page.locator("#runs tbody tr").all_inner_texts()
    assert "GAIN 2, TI 20" in first and "85.3 %\t\t" in first, "it overshoots and does not settle"
    assert "GAIN 0.7, TI 130" in second and "0.534 %" in second and "133 s" in second
    text = (test_tool_run.ROOT / "README.md").read_text("utf-8")
    (said,) = re.findall(r"!\[(.*)\]\(docs/tool/run.gif\)", text)
    assert "GAIN 2 and TI 20 s it oscillates" in said and "0.7 and 130 s it settles after 133 s" in said
