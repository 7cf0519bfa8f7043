"""The parameter tool as tests use it: its page, and `plcfmu tool` as a page asks it."""

import http.client
import importlib.util
import json
import os
import pathlib
import shutil
import signal
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[1]

# The page with the engine in it.
PAGE = pathlib.Path(os.environ.get("PLCFMU_TOOL") or ROOT / "target/tool/plcfmu-tool.html").resolve()
NO_PAGE = "no page of the parameter tool: 'rustup target add wasm32-unknown-unknown', then 'cargo xtask tool'"
needs_page = pytest.mark.skipif(not PAGE.is_file(), reason=NO_PAGE)

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PACKAGES = ("playwright", "axe_playwright_python")
MISSING = [package for package in PACKAGES if importlib.util.find_spec(package) is None]
# What a module of tests in a browser needs.
needs_browser = [
    pytest.mark.skipif(bool(MISSING), reason=f"{', '.join(MISSING)} not installed (tests/requirements.txt)"),
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian and Ubuntu 'apt install chromium'"),
]
ARGUMENTS = [
    *("--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync"),
    *("--disable-component-update", "--enable-precise-memory-info", "--js-flags=--expose-gc"),
]


def show_tab(page, name):
    """Shows a tab of the page: Diagram, Plant, Tune, Runs, Replay, Log; on a narrow screen Parameters, too."""
    page.get_by_role("tab", name=name, exact=True).click()


def until(page, holds, argument=None):
    """Waits until an asynchronous function of the page says TRUE. `wait_for_function` takes its promise for that, and never waits."""
    page.evaluate(
        f"""async (argument) => {{
            const begun = performance.now();
            while (!(await ({holds})(argument))) {{
                if (performance.now() - begun > 60_000) throw new Error({holds!r} + " does not hold");
                await new Promise(requestAnimationFrame);
            }}
        }}""",
        argument,
    )


def new_loop(page, name, block="CONT_C"):
    page.locator("#new-name").fill(name)
    page.locator("#new-block").select_option(block)
    page.get_by_role("button", name="New loop").click()


def take_generic_plant(page, gain, lag, dead_time):
    show_tab(page, "Plant")
    plant = page.locator("#plant")
    plant.get_by_label("Gain").fill(gain)
    plant.get_by_label("Time constant").fill(lag)
    plant.get_by_label("Dead time").fill(dead_time)
    plant.get_by_role("button", name="Use this plant").click()
    plant.get_by_text("goes to").first.wait_for()


def add_sensor(page):
    """Measures through a sensor, which is what has noise."""
    show_tab(page, "Plant")
    page.locator("#sensor").get_by_text("Measure through a sensor").click()
    page.locator("#noise").wait_for(state="attached")


class Server:
    """A `plcfmu tool` that runs while the `with` block does."""

    def __init__(self, command, folder, *arguments):
        given = [command, "tool", "--no-browser", *map(str, arguments)]
        self.process = subprocess.Popen(given, cwd=folder, stdout=subprocess.PIPE, text=True)
        # It is printed when the server answers.
        self.url = self.process.stdout.readline().strip()
        self.cookie = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.communicate()

    def ask(self, request, tab):
        """The answer to a request of a tab, as text."""
        address, way = self.url.removeprefix("http://").split("/", 1)
        path = way.split("open?")[0]
        connection = http.client.HTTPConnection(address)
        if self.cookie is None:
            connection.request("GET", f"/{way}")
            door = connection.getresponse()
            door.read()
            self.cookie = door.headers["Set-Cookie"].split(";")[0]
        headers = {"Content-Type": "application/json", "X-Page": tab, "Cookie": self.cookie}
        connection.request("POST", f"/{path}message", json.dumps(request), headers)
        answer = connection.getresponse().read().decode()
        connection.close()
        return answer
