"""How many actions the tool asks for: each click, choice, file, typed text and key is one, as an engineer makes them who has never
seen the page. The numbers are what the project promises."""

import difflib
import pathlib

from test_tool_run import LOOPS, browser, open_tool, pytestmark  # noqa: F401

SCREEN = (1366, 768)


class User:
    """Does what one does with a mouse and a keyboard, and counts it."""

    def __init__(self, page):
        self.page = page
        self.actions = 0

    def click(self, where):
        self.actions += 1
        where.click()

    def button(self, name, within="body"):
        self.click(self.page.locator(within).get_by_role("button", name=name, exact=True).first)

    def type(self, where, text):
        self.actions += 1
        self.page.locator(where).fill(text)

    def press(self, key):
        self.actions += 1
        self.page.keyboard.press(key)

    def open(self, where, file):
        self.actions += 1
        self.page.locator(where).set_input_files(file)

    def saved(self, act):
        with self.page.expect_download() as download:
            act()
        return download.value.suggested_filename, pathlib.Path(download.value.path()).read_bytes()


def test_one_of_forty_loops_is_changed_and_taken_back_in_6_actions_with_one_line_that_differs(open_tool):  # noqa: F811
    page = open_tool(SCREEN)
    user = User(page)
    user.open("#open-files", LOOPS)
    user.button("TIC103")
    user.type("#field-GAIN", "3.25")
    user.press("Enter")
    user.click(page.locator("#away-button"))
    name, source = user.saved(lambda: user.button(f"Save {LOOPS.name}"))
    assert name == LOOPS.name
    before, after = LOOPS.read_bytes().decode("latin-1"), source.decode("latin-1")
    changed = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]
    assert len(changed) == 2 and changed[1].startswith("+") and "GAIN" in changed[1] and "3.25" in changed[1], changed
    assert user.actions <= 6
