"""Files in the parameter tool's page: what is opened, how it is listed, what is refused, and what a file can do to the page."""

import base64
import json
import zipfile

import pytest

import host
import test_tool_parameters
from test_tool_parameters import (  # noqa: F401
    FILES,
    PLANT,
    ask,
    browser,
    checked,
    data_block,
    field,
    make_calls,
    new_loop,
    open_file,
    open_tool,
    page,
    row,
    saved,
    tag,
    write,
)

pytestmark = test_tool_parameters.pytestmark

HOSTILE = "<img src=x onerror='document.title=1'>"


def loop_names(page):
    return page.locator("table.loops button.loop").all_inner_texts()


def test_a_file_of_forty_loops_becomes_a_table_with_block_cycle_and_warnings(page):
    page.set_input_files("#open-files", PLANT)
    page.locator("table.loops").wait_for()
    assert page.locator("#notices").inner_text() == ""
    read = ask(page, do="read", file="plant.awl", content=base64_of(PLANT))
    assert len(read["loops"]) == 40
    shown = []
    while True:
        for line in page.locator("table.loops tbody tr").all():
            shown.append([cell.strip() for cell in line.locator("td").all_inner_texts()])
        if not page.get_by_role("button", name="Next").is_enabled():
            break
        page.get_by_role("button", name="Next").click()
    names = [loop["name"] for loop in read["loops"]]
    # A title stands below the name.
    assert [line[0].split("\n")[0] for line in shown] == names
    assert [line[1] for line in shown] == [loop["block"] for loop in read["loops"]]
    assert [float(line[2].removesuffix(" s")) for line in shown] == pytest.approx([loop["cycle"] for loop in read["loops"]])
    # What one compares loops by: empty where a block has none, such as the gain of a pulse former.
    for at, name in ((3, "GAIN"), (4, "TI"), (6, "SP_INT")):
        values = [{one["name"]: one["value"] for one in loop["settings"]}.get(name) for loop in read["loops"]]
        texts = [line[at].removesuffix(" s") for line in shown]
        assert [text == "" for text in texts] == [value is None for value in values], name
        wanted = [value for value in values if value is not None]
        assert [float(text) for text in texts if text] == pytest.approx(wanted, rel=1e-4) and len(set(wanted)) > 1, name
    warnings = [f"! {len(loop['warnings'])}" if loop["warnings"] else "" for loop in read["loops"]]
    assert [line[-1] for line in shown] == warnings
    assert any(warnings)


def test_a_table_of_loops_is_sorted_by_a_click_on_a_title_and_shows_the_mode(page):
    blocks = [("TIC101", 1.5, "TRUE"), ("TIC102", 0.5, "FALSE"), ("TIC103", 12.0, "TRUE")]
    open_file(page, "plant.awl", "".join(data_block(name, GAIN=gain, MAN_ON=manual) for name, gain, manual in blocks))
    page.locator("table.loops").get_by_text("MANUAL").first.wait_for()
    rows = page.locator("table.loops tbody tr")
    assert [row.split("\t")[5].strip() for row in rows.all_inner_texts()] == ["MANUAL", "AUTO", "MANUAL"]
    by_gain = page.locator("table.loops th").get_by_role("button", name="GAIN")
    for wanted, order in ((["TIC102", "TIC101", "TIC103"], "ascending"), (["TIC103", "TIC101", "TIC102"], "descending")):
        by_gain.click()
        assert loop_names(page) == wanted
        assert page.locator("table.loops th", has_text="GAIN").get_attribute("aria-sort") == order
    # The third click leaves the order of the file.
    by_gain.click()
    assert loop_names(page) == ["TIC101", "TIC102", "TIC103"]


def base64_of(path):
    return base64.b64encode(path.read_bytes()).decode()


def test_a_wrong_file_says_line_column_and_what_to_do_and_nothing_is_lost(page):
    new_loop(page, "CONT_C", "KEPT")
    write(page, "GAIN", "3.5")
    page.click("#open-button")
    for path in sorted((FILES / "wrong").iterdir()):
        page.set_input_files("#open-files", path)
        box = page.locator(".file", has=page.get_by_text(path.name, exact=True))
        box.wait_for()
        said = ask(page, do="read", file=path.name, content=base64_of(path))
        for problem in said["problems"][:20]:
            assert problem["message"] in box.inner_text(), path.name
            if problem["place"]:
                line, column = problem["place"]
                assert f"line {line}, column {column}" in box.inner_text(), path.name
            if problem["help"]:
                # The page has no options.
                assert "--" not in problem["help"], path.name
                assert problem["help"] in box.inner_text(), path.name
        box.get_by_role("button", name="Close").click()
    assert loop_names(page)[0] == "KEPT"
    assert field(page, "GAIN").input_value() == "3.5"


def test_a_file_of_another_kind_is_refused_in_a_sentence(page):
    open_file(page, "picture.png", b"\x89PNG\r\n")
    page.locator(".file.is-refused").wait_for()
    assert "picture.png" in page.locator(".file.is-refused").inner_text()
    open_file(page, "no.fmu", b"nothing packed")
    page.get_by_text("it is not a ZIP archive").wait_for()
    # What was refused before has gone, and its choices of a block with it.
    assert page.locator(".file.is-refused").count() == 1
    assert page.locator(".file.is-refused select").count() == 0


def test_a_file_that_does_not_say_its_block_is_read_as_the_block_of_choice(page):
    open_file(page, "flat.json", json.dumps({"GAIN": 2.5}))
    refused = page.locator(".file.is-refused")
    refused.wait_for()
    # In the words of the page, which has no options.
    assert "choose" in refused.inner_text() and "--block" not in refused.inner_text()
    # PULSEGEN has no GAIN: another block can be chosen.
    refused.locator("select").select_option("PULSEGEN")
    page.click("text=Read again")
    page.locator(".file.is-refused", has_text="PULSEGEN").wait_for()
    refused.locator("select").select_option("CONT_C")
    page.click("text=Read again")
    field(page, "GAIN").wait_for()
    assert field(page, "GAIN").input_value() == "2.5"


def test_an_fmu_is_read_as_the_parameters_of_its_block(page):
    page.set_input_files("#open-files", host.FOLDER / "CONT_C.fmu")
    field(page, "GAIN").wait_for()
    assert page.locator("#what").inner_text().split()[:2] == ["CONT_C", "CYCLE"]
    assert field(page, "TI").input_value() == "20"


def test_a_foreign_fmu_is_refused_with_the_way_to_run_it(page, tmp_path):
    path = tmp_path / "other.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        text = '<fmiModelDescription modelName="Other"><CoSimulation modelIdentifier="Other"/></fmiModelDescription>'
        archive.writestr("modelDescription.xml", text)
    page.set_input_files("#open-files", path)
    page.get_by_text("Open it with plcfmu tool other.fmu").wait_for()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("0,60,20\n1,60,21\n", "line 1 has values but no header line above it: add one, such as time,SP,PV,LMN"),
        ("time,SP,PV\n0,60,20\n1,60,2x\n2,60,22\n", 'line 3, column 3 (PV): "2x" is not a number'),
        (b"PK\3\4" + bytes(range(1, 256)), "the file is not text: it contains the character"),
    ],
    ids=["without a header", "a typing error", "no text"],
)
def test_a_file_that_is_no_recording_is_refused_when_it_is_chosen(page, text, why):
    open_file(page, "step.csv", text)
    page.get_by_text(why).wait_for()
    # There are no tabs yet.
    assert page.get_by_text("see Replay and Tune").count() == 0
    new_loop(page, "CONT_C", "TIC1")
    page.get_by_role("tab", name="Replay").click()
    chosen = text if isinstance(text, bytes) else text.encode()
    page.set_input_files("#replay-file", {"name": "step.csv", "mimeType": "text/csv", "buffer": chosen})
    page.locator("#notices").get_by_text(why).wait_for()
    assert page.get_by_role("button", name="Replay", exact=True).count() == 0


def test_a_recording_that_is_opened_before_a_loop_waits_for_it(page):
    open_file(page, "step.csv", "time,SP_INT,PV_IN,LMN\n0,60,20,80\n1,60,,80\n")
    page.get_by_text("step.csv is a recording: open or create a loop, then see Replay and Tune.").wait_for()
    new_loop(page, "CONT_C", "TIC1")
    page.get_by_role("tab", name="Replay").click()
    page.get_by_role("button", name="Replay", exact=True).click()
    page.get_by_text("Line 3, column PV_IN: no value; the previous value is used.").wait_for()


def test_files_are_dropped_anywhere(page):
    drop = """(text) => {
        const data = new DataTransfer();
        data.items.add(new File([text], "dropped.awl"));
        document.querySelector("header").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    }"""
    page.evaluate(drop, data_block("DROPPED", GAIN="1.5"))
    field(page, "GAIN").wait_for()
    assert page.locator("#what strong").inner_text() == "DROPPED"


def test_several_files_are_open_at_once(page):
    for name in ("one", "two"):
        open_file(page, f"{name}.awl", data_block(name.upper()) + data_block(f"{name.upper()}_B"))
        page.locator(".file-name", has_text=name).wait_for()
    assert loop_names(page) == ["ONE", "ONE_B", "TWO", "TWO_B"]


def test_two_loops_of_one_name_are_told_apart_by_their_files(page):
    for name in ("one", "two"):
        open_file(page, f"{name}.awl", data_block("TIC101") + data_block(name.upper()))
        page.locator(".file-name", has_text=name).wait_for()
    rows = page.locator("table.loops tbody tr td:first-child").all_inner_texts()
    assert rows == ["TIC101\none.awl", "ONE", "TIC101\ntwo.awl", "TWO"]


def test_ten_thousand_loops_are_turned_over_and_filtered(page):
    open_file(page, "many.awl", "".join(data_block(f"LOOP{number}", GAIN="2.0") for number in range(10_000)))
    page.get_by_text("1 to 25 of 10000").wait_for()
    page.fill("#loops input[type=search]", "loop9999")
    assert loop_names(page) == ["LOOP9999"]
    page.click("text=LOOP9999")
    field(page, "GAIN").wait_for()
    assert field(page, "GAIN").input_value() == "2"


def test_a_million_loops_and_a_hundred_megabytes_are_refused_and_the_page_lives(page):
    drop = """([name, part, count]) => {
        const data = new DataTransfer();
        data.items.add(new File([part.repeat(count)], name));
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    }"""
    page.evaluate(drop, ["million.awl", "DATA_BLOCK DB1\n", 1_000_000])
    page.get_by_text("The file has 1000000 blocks").wait_for()
    page.evaluate(drop, ["million.json", '"A": {},\n', 1_000_000])
    page.locator(".file.is-refused", has_text="million.json").get_by_text("The file has 1000000 blocks").wait_for()
    page.evaluate(drop, ["large.awl", "x" * 1000, 100_000])
    page.get_by_text("The file is 100 MB").wait_for()
    new_loop(page, "CONT_C", "ALIVE")
    assert field(page, "GAIN").input_value() == "2"


def test_a_hostile_name_is_text(page):
    open_file(page, "<img src=x onerror=alert(1)>.awl", data_block(HOSTILE, GAIN="4.0") + data_block("B"))
    page.locator("table.loops").wait_for()
    page.locator("table.loops button.loop").first.click()
    field(page, "GAIN").wait_for()
    page.click("#compare-button")
    write(page, "GAIN", "5")
    assert page.locator("#what strong").inner_text() == HOSTILE
    assert page.locator("img").count() == 0
    assert page.title().startswith(HOSTILE)
    make_calls(page, 1)
    new = "</script><script>document.title=1</script>"
    page.click("#open-button")
    new_loop(page, "CONT_C", new)
    assert page.locator("#what strong").inner_text() == new
    open_file(page, "quote.json", json.dumps({"block": HOSTILE}))
    page.locator(".is-refused").wait_for()
    assert page.locator("img, script[src]").count() == 0


def test_before_a_file_is_saved_every_difference_of_each_loop_is_shown(page):
    text = data_block("A", GAIN="4.0") + data_block("B", GAIN="6.0", TI="T#30S")
    open_file(page, "two.awl", text)
    page.get_by_role("button", name="A", exact=True).click()
    field(page, "GAIN").wait_for()
    write(page, "GAIN", "5")
    field(page, "GAIN").press("Enter")
    page.get_by_role("button", name="B", exact=True).click()
    page.locator('#what:has-text("B")').wait_for()
    checked(page)
    write(page, "TI", "44")
    page.get_by_role("button", name="A", exact=True).click()
    page.click("#away-button")
    rows = page.locator(".to-save tbody tr")
    assert [row.locator("td").all_inner_texts() for row in rows.all()] == [["A: GAIN", "4", "5"]]
    (unsent,) = page.locator(".unsent li").all_inner_texts()
    assert unsent == "B: TI has an edit (44) that is not applied and will not be saved; the file will contain 30."
    page.get_by_role("button", name="Apply all edits").click()
    page.locator(".unsent").wait_for(state="detached")
    assert [row.locator("td").all_inner_texts() for row in rows.all()] == [["A: GAIN", "4", "5"], ["B: TI", "30", "44"]]
    assert saved(page, "Save two.awl") == text.replace("4.0", "5.0").replace("T#30S", "T#44S")


def test_before_a_file_is_saved_a_loop_that_stays_in_manual_mode_is_named(page):
    open_file(page, "two.awl", data_block("A", GAIN="4.0", MAN_ON="TRUE") + data_block("B", GAIN="6.0", MAN_ON="TRUE"))
    page.get_by_role("button", name="A", exact=True).click()
    field(page, "GAIN").wait_for()
    page.click("#away-button")
    told = page.locator(".content-of-file .note li")
    # Nothing of the file is touched: nothing is said.
    assert told.count() == 0
    page.keyboard.press("Escape")
    page.locator("#run").get_by_role("checkbox", name="Manual").click()
    page.click("#away-button")
    told.first.wait_for()
    assert told.all_inner_texts() == ["MAN_ON is TRUE in the saved file: the controller starts in manual mode, with MAN 0."]
    page.get_by_role("checkbox", name="also MAN_ON as in the run").check()
    told.first.wait_for(state="detached")


def test_a_file_with_changes_is_closed_after_a_question_and_can_be_opened_again(page):
    open_file(page, "two.awl", data_block("A", GAIN="4.0") + data_block("B", GAIN="6.0"))
    page.get_by_role("button", name="A", exact=True).click()
    field(page, "GAIN").wait_for()
    write(page, "GAIN", "5")
    page.get_by_role("button", name="Close two.awl").click()
    question = page.get_by_role("group", name="Question")
    assert "two.awl has changes that are not saved in a file: A (1). Close it anyway?" in question.inner_text()
    question.get_by_role("button", name="Keep it").click()
    assert loop_names(page) == ["A", "B"]
    page.get_by_role("button", name="Close two.awl").click()
    question.get_by_role("button", name="Close it").click()
    assert "B" not in loop_names(page)
    question.get_by_role("button", name="Open it again").click()
    assert loop_names(page) == ["A", "B"]
    assert field(page, "GAIN").input_value() == "5"


def test_the_comparison_shows_what_differs_from_the_file(page):
    open_file(page, "a.awl", data_block("A", GAIN="4.0", TI="T#30S"))
    field(page, "GAIN").wait_for()
    write(page, "GAIN", "5")
    field(page, "GAIN").press("Enter")
    write(page, "TI", "40")
    page.click("#compare-button")
    rows = [line.inner_text().split("\t")[:4] for line in page.locator("#compare tbody tr").all()]
    assert [[cell.strip() for cell in line] for line in rows] == [["GAIN", "4", "5", "5"], ["TI", "30", "40", "30"]]
    page.get_by_role("button", name="Restore 4 in GAIN").click()
    assert field(page, "GAIN").input_value() == "4"
    assert tag(page, "GAIN") == "edited"
    page.keyboard.press("Escape")
    assert page.locator("#compare").is_hidden()
