"""A project on the page, and its networks in LAD and FBD with power flow."""

import io
import shutil
import zipfile

import pytest

from test_tool_diagram import one_cycle, run_case
from test_tool_program import COUNTER, LAPTOP, PROGRAMS, drop, line, set_input
from test_tool_run import PHONE, open_tool, saved, screenshot
from test_tool_run import browser, pytestmark  # noqa: F401
from tool import show_tab

# A gate, an assignment and a comparison, in FBD.
FBD = """FUNCTION_BLOCK "Gate"
VAR_INPUT a : Bool; b : Bool; n : Int; END_VAR
VAR_OUTPUT both : Bool; many : Bool; END_VAR
    { S7_Language := "FBD"; S7_NetworkTitle := "" }
    NETWORK
        RUNG #a
            A( in2 := #b )
            Coil( #both )
        END_RUNG
    END_NETWORK
END_FUNCTION_BLOCK
"""


def wires(page, network):
    """How many wires of a network conduct, and how many do not."""
    drawn = page.locator(f'[data-network="{network}"]')
    return drawn.locator("path.wire.is-on").count(), drawn.locator("path.wire.is-off").count()


def shows(page, network, name, text):
    """Waits until the first value of this name in a network is a text."""
    page.wait_for_function(
        """([network, name, text]) => [...document.querySelectorAll(`[data-network="${network}"] .operand`)].some((label) =>
          label.firstChild.textContent === name && label.nextElementSibling?.textContent === text)""",
        arg=[network, name, text],
    )


def interlock(open_tool, size=LAPTOP, form="s7dcl", **options):
    page = open_tool(size, **options)
    names = {"s7dcl": ["interlock.s7dcl", "interlock.s7res"], "xml": ["interlock.xml"]}[form]
    drop(page, *[PROGRAMS / name for name in names])
    page.locator(".network").first.wait_for()
    return page


@pytest.mark.parametrize("form", ["s7dcl", "xml"])
def test_networks_are_drawn_with_titles_and_what_conducts(open_tool, form):
    page = interlock(open_tool, form=form)
    titles = page.locator(".network h3").all_inner_texts()
    assert titles == ["Network 1: Level", "Network 2: Dry run", "Network 3: Fault", "Network 4: Run", "Network 5: Starts"]
    assert "27648 is 100 %" in page.locator('[data-network="1"]').inner_text()
    # Before the first call nothing is known.
    assert wires(page, 4) == (0, 0)
    # The level is 50 %: 13824 of 27648.
    set_input(page, "raw", 13824)
    set_input(page, "start", True)
    one_cycle(page)
    shows(page, 1, "#level", "50")
    shows(page, 4, "#start", "TRUE")
    # The contact of run was open when it was looked at, although the coil has closed it by the end of the call.
    shows(page, 4, "#run", "FALSE")
    shows(page, 4, "#run", "TRUE")
    one_cycle(page)
    set_input(page, "start", False)
    one_cycle(page)
    shows(page, 4, "#start", "FALSE")
    page.wait_for_function("""() => [...document.querySelectorAll('[data-network="4"] .operand')].filter((label) =>
      label.firstChild.textContent === "#run" && label.nextElementSibling.textContent === "TRUE").length === 2""")
    # It holds itself: start is the only contact that does not conduct.
    on, off = wires(page, 4)
    assert off == 2 and on >= 8, (on, off)


def test_a_name_leads_to_why_to_the_watch_table_and_to_the_networks_that_use_it(open_tool):
    page = interlock(open_tool)
    set_input(page, "raw", 13824)
    set_input(page, "start", True)
    one_cycle(page, 2)
    page.locator('[data-network="4"] .operand', has_text="#fault").first.focus()
    page.keyboard.press("Enter")
    bar = page.locator(".ladder-bar")
    bar.get_by_role("button", name="Network 3 writes it").wait_for()
    bar.get_by_role("button", name="Network 4 reads it").wait_for()
    bar.get_by_role("button", name="Why").click()
    page.locator(".why", has_text="Why is fault FALSE").wait_for()
    bar.get_by_role("button", name="Watch").click()
    page.locator("#watch", has_text="fault").wait_for()
    show_tab(page, "Program")
    page.locator('[data-network="4"] .operand', has_text="#run").last.click()
    bar.get_by_role("button", name="Why").click()
    wrote = page.locator(".why .why-statement", has_text="#run := ").first
    wrote.get_by_role("button", name="network 4: ").wait_for()
    # Start and the contact of run stand beside each other: either holds the coil. Each of the three in the way would open it.
    decided, shared = wrote.locator("p .has-decided").all_inner_texts()
    assert decided.startswith("each of these decided:") and [name in decided for name in ("stop", "fault", "low")] == [True] * 3
    assert shared.startswith("none of these decided alone:") and "start TRUE" in shared and "run TRUE" in shared
    assert page.locator('[data-network="4"] .symbol.is-deciding').count() == 5
    assert page.locator('[data-network="3"] .symbol.is-deciding').count() == 0
    # What declares it stands in the text.
    bar.get_by_role("button", name="declares it").click()
    assert "run : Bool;" in page.locator(".program .line.is-target").text_content()


def test_fbd_is_drawn_as_boxes_and_the_text_is_there_too(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("gate.s7dcl", FBD))
    page.locator(".network").first.wait_for()
    assert page.locator(".network rect.box").count() == 2
    assert page.locator(".network .box-title").all_text_contents() == ["&", "="]
    set_input(page, "a", True)
    set_input(page, "b", True)
    one_cycle(page)
    # A wire that is level has no height, and so cannot be "visible".
    page.locator(".network path.wire.is-on").first.wait_for(state="attached")
    page.get_by_role("button", name="Text", exact=True).click()
    page.locator('.program [data-line="7"]', has_text="A( in2 := #b )").wait_for()


def zipped(folder):
    """A folder as an archive, with a file that belongs to no program."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                archive.write(path, path.relative_to(folder.parent))
        archive.writestr("mixer/readme.md", "About it.")
    return content.getvalue()


def test_a_zip_of_a_project_opens_as_a_whole_with_its_tags(open_tool, command, tmp_path):
    page = open_tool(LAPTOP)
    archive = tmp_path / "mixer.zip"
    archive.write_bytes(zipped(PROGRAMS / "mixer"))
    drop(page, archive)
    page.get_by_text("The project: 3 sources").click()
    survey = page.locator(".survey").inner_text()
    assert "1 organization block, 1 function block" in survey
    assert "10 tags, 9 in use; 1 constant, from 1 table" in survey
    # Inputs have the names of the tag table.
    set_input(page, "'Lid closed'", True)
    set_input(page, "Start", True)
    one_cycle(page, 2)
    values = page.evaluate("async () => (await moduleOf('tool/store.js')).store.state.values")
    assert values["Main.'Fill valve'"] is True and values["Main.Ready"] is False
    # A test of it names no source: it lies in the project's folder, whose tag table has a folder of its own.
    show_tab(page, "Log")
    page.get_by_role("button", name="Save as test").click()
    _, content = saved(page, "Save Main_test.toml", "#done")
    shutil.copytree(PROGRAMS / "mixer", tmp_path / "mixer")
    done = run_case(command, tmp_path / "mixer", content)
    assert done.returncode == 0 and ": ok" in done.stdout, done.stdout + done.stderr + content.decode()


def test_what_a_project_lacks_is_assumed_after_a_look_at_the_list(open_tool, tmp_path):
    page = open_tool(LAPTOP)
    folder = PROGRAMS / "mixer"
    drop(page, folder / "Main.scl", folder / "Mixer.scl", folder / "Data.db")
    # Without the tag table its tags and the constant are missing.
    button = page.locator(".assumptions button.primary")
    button.wait_for()
    assert "names without a declaration" in page.locator(".assumptions summary").inner_text()
    assert "Batch running is an output of type BOOL Main.scl, line 13" in page.locator(".assumption-list").inner_text()
    # What is only read is taken for an input; who knows better writes what it is.
    page.get_by_label("Declaration of EMPTY").fill("VAR_GLOBAL CONSTANT\n   EMPTY : REAL := 2.0;\nEND_VAR")
    button.click()
    page.locator(".program-head strong", has_text="Main").wait_for()
    page.locator(".assumptions summary", has_text="10 names are assumed").wait_for()
    names = page.evaluate("async () => (await moduleOf('tool/store.js')).store.loop.description.variables.map(({ name }) => name)")
    assert "Start" in names and "EMPTY" not in names


def test_a_breakpoint_pauses_the_run_in_the_call_in_which_it_begins_to_hold(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("counter.scl", COUNTER.replace("#a[#count] := #count;", "")))
    set_input(page, "up", True)
    show_tab(page, "Watch")
    page.get_by_label("Pause when").fill("count >= 7")
    page.get_by_label("Pause when").press("Enter")
    page.get_by_role("button", name="Run", exact=True).click()
    page.get_by_text("Paused: count >= 7.").wait_for()
    state = page.evaluate("async () => (await moduleOf('tool/store.js')).store.state")
    assert (state["calls"], state["values"]["Counter.count"]) == (7, 7)
    page.get_by_label("Pause when").fill("cuont >= 7")
    page.get_by_label("Pause when").press("Enter")
    page.get_by_text("cuont is not a variable").wait_for()


NESTED = """FUNCTION_BLOCK "Inner"
VAR_INPUT on : Bool; END_VAR
VAR_OUTPUT lamp : Bool; END_VAR
VAR CONSTANT LIMIT : Int := 3; END_VAR
VAR count : Int; END_VAR
BEGIN
  IF #on THEN #count += 1; END_IF;
  #lamp := #count > #LIMIT;
END_FUNCTION_BLOCK

FUNCTION_BLOCK "Outer"
VAR_INPUT on : Bool; END_VAR
VAR_OUTPUT lamp : Bool; END_VAR
VAR left : "Inner"; right : "Inner"; END_VAR
BEGIN
  #left(on := #on);
  #right(on := NOT #on);
  #lamp := #left.lamp OR #right.lamp;
END_FUNCTION_BLOCK
"""


def test_the_tree_of_blocks_leads_to_an_instance_and_a_constant_has_its_value_in_why(open_tool):
    page = open_tool(LAPTOP)
    drop(page, ("nested.scl", NESTED))
    set_input(page, "on", True)
    one_cycle(page, 4)
    page.locator(".block-tree summary").click()
    assert page.locator(".block-tree button").all_inner_texts() == ["Outer", "left: Inner", "right: Inner"]
    page.locator(".block-tree button", has_text="right").click()
    # The right one counts the cycles in which `on` is FALSE.
    line(page, 7).locator(".value", has_text="count 0").wait_for()
    page.locator(".block-tree button", has_text="left").click()
    line(page, 7).locator(".value", has_text="count 4").wait_for()
    line(page, 8).locator('.value[data-name="Outer.left.lamp"]').click()
    page.locator(".why", has_text="Why is left.lamp TRUE").wait_for()
    page.locator(".why .value", has_text="LIMIT 3").wait_for()
    # A name leads to where it is declared, written and read; an input is written where the block is called.
    line(page, 7).get_by_text("#count", exact=True).click()
    usage = page.locator(".usage")
    assert usage.get_by_role("button", name="it").all_inner_texts() == ["line 5", "line 7", "line 7", "line 8"]
    line(page, 7).get_by_text("#on", exact=True).focus()
    page.keyboard.press("Enter")
    usage.get_by_role("button", name="line 17 writes it").wait_for()
    assert usage.get_by_role("button", name="it").all_inner_texts() == ["line 2", "line 16", "line 17", "line 7"]
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    usage.get_by_role("button", name="line 5 declares it").click()
    assert "is-target" in line(page, 5).get_attribute("class")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_ladder_fits_a_laptop(open_tool, scheme):
    page = interlock(open_tool, scheme=scheme)
    set_input(page, "raw", 13824)
    set_input(page, "start", True)
    one_cycle(page, 2)
    shows(page, 4, "#start", "TRUE")
    assert page.evaluate("document.documentElement.scrollWidth") <= LAPTOP[0]
    screenshot(page, f"ladder-{scheme}")
    # On a phone a wide network is scrolled inside of its pane, and names are as large as before.
    page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    pane = page.locator('[data-network="4"] .wide')
    assert pane.evaluate("one => [one.scrollWidth > one.clientWidth, getComputedStyle(one).overflowX]") == [True, "auto"]
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    assert pane.locator("text.operand").first.evaluate("one => one.getBoundingClientRect().height") >= 9
    screenshot(page, f"ladder-phone-{scheme}")
