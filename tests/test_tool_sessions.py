"""What a reload and a closed tab leave of the parameter tool's work."""

import test_tool_parameters
from test_tool_files import loop_names
from test_tool_parameters import (
    browser,  # noqa: F401
    checked,
    data_block,
    field,
    make_calls,
    new_loop,
    open_file,
    tag,
    write,
    open_tool,  # noqa: F401
    page,  # noqa: F401
)
from tool import PAGE, until

pytestmark = test_tool_parameters.pytestmark


def test_a_reload_keeps_loops_values_edits_and_the_run(page):  # noqa: F811
    open_file(page, "two.awl", data_block("A", GAIN="4.0") + data_block("B", GAIN="6.0"))
    for name in ("A", "B"):
        page.get_by_role("button", name=name, exact=True).click()
        page.locator(f'#what:has-text("{name}")').wait_for()
        checked(page)
    write(page, "GAIN", "7")
    field(page, "GAIN").press("Enter")
    checked(page)
    make_calls(page, 10)
    write(page, "MAN", "55")
    field(page, "MAN").press("Enter")
    checked(page)
    make_calls(page, 5)
    write(page, "TI", "44")
    write(page, "LMN_HLM", "x")
    page.get_by_role("group", name="Speed").get_by_role("button", name="max").click()
    before = page.evaluate('async () => (await moduleOf("tool/store.js")).store.state')
    page.wait_for_function("() => JSON.parse(sessionStorage.getItem('plcfmu')).run?.events.length === 1")
    page.reload()
    field(page, "GAIN").wait_for()
    until(page, 'async () => (await moduleOf("tool/store.js")).store.state?.calls === 15')
    checked(page)
    after = page.evaluate('async () => (await moduleOf("tool/store.js")).store.state')
    assert after["values"] == before["values"]
    assert page.locator("#what strong").inner_text() == "B"
    assert (field(page, "GAIN").input_value(), tag(page, "GAIN")) == ("7", "changed")
    assert (field(page, "TI").input_value(), tag(page, "TI")) == ("44", "edited")
    assert field(page, "LMN_HLM").input_value() == "x"
    assert page.get_by_role("group", name="Speed").get_by_role("button", name="max").get_attribute("aria-pressed") == "true"
    page.get_by_role("button", name="Undo", exact=True).click()
    assert (field(page, "TI").input_value(), tag(page, "TI")) == ("20", "start")
    assert loop_names(page) == ["A", "B"]
    page.get_by_role("button", name="A", exact=True).click()
    assert (field(page, "GAIN").input_value(), tag(page, "GAIN")) == ("4", "file")


def test_a_session_outlives_its_tab_and_is_offered_on_the_first_page(page):  # noqa: F811
    new_loop(page, "CONT_C", "TIC101")
    write(page, "GAIN", "7")
    field(page, "GAIN").press("Enter")
    checked(page)
    make_calls(page, 10)
    # What a tab does when it is closed.
    page.evaluate("dispatchEvent(new Event('pagehide'))")
    other = page.context.new_page()
    page.close()
    other.goto(PAGE.as_uri())
    other.locator(".recent .session").get_by_text("TIC101").click()
    # After the reload.
    field(other, "GAIN").wait_for()
    until(other, 'async () => (await moduleOf("tool/store.js")).store.state?.calls === 10')
    assert field(other, "GAIN").input_value() == "7" and other.locator("#what strong").inner_text() == "TIC101"
    # It is the same session, and not another one; it can be forgotten.
    other.evaluate("dispatchEvent(new Event('pagehide'))")
    third = other.context.new_page()
    third.goto(PAGE.as_uri())
    third.locator(".recent .session").wait_for()
    assert third.locator(".recent .session").count() == 1
    third.get_by_role("button", name="Forget TIC101").click()
    third.locator(".recent").wait_for(state="detached")
    assert third.evaluate("localStorage.getItem('plcfmu-sessions')") is None


def test_five_sessions_are_kept_and_none_that_is_too_large(page):  # noqa: F811
    kept = page.evaluate("""async () => {
        const { keepSession, keptSessions } = await moduleOf("tool/kept.js");
        for (let at = 0; at < 7; at += 1) {
            sessionStorage.removeItem("plcfmu-session");
            keepSession(`loop ${at}`, "x".repeat(at === 5 ? 2_000_000 : 100));
        }
        return keptSessions().map(({ title }) => title);
    }""")
    assert kept == ["loop 6", "loop 4", "loop 3", "loop 2", "loop 1"]
