"""The parameter tool as tests use it: its page, and `plcfmu tool` as a page asks it."""

import http.client
import json
import os
import pathlib
import signal
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[1]

# The page with the engine in it.
PAGE = pathlib.Path(os.environ.get("PLCFMU_TOOL") or ROOT / "target/tool/plcfmu-tool.html").resolve()
NO_PAGE = "no page of the parameter tool: 'rustup target add wasm32-unknown-unknown', then 'cargo xtask tool'"
needs_page = pytest.mark.skipif(not PAGE.is_file(), reason=NO_PAGE)


def show_tab(page, name):
    """Shows a tab of the page: Diagram, Plant, Tune, Runs, Replay, Log; on a narrow screen Parameters, too."""
    page.get_by_role("tab", name=name, exact=True).click()


class Server:
    """A `plcfmu tool` that runs while the `with` block does."""

    def __init__(self, command, folder, *arguments):
        given = [command, "tool", "--no-browser", *map(str, arguments)]
        self.process = subprocess.Popen(given, cwd=folder, stdout=subprocess.PIPE, text=True)
        # It is printed when the server answers.
        self.url = self.process.stdout.readline().strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.communicate()

    def ask(self, request, tab):
        """The answer to a request of a tab, as text."""
        address, path = self.url.removeprefix("http://").split("/", 1)
        connection = http.client.HTTPConnection(address)
        headers = {"Content-Type": "application/json", "X-Page": tab}
        connection.request("POST", f"/{path}message", json.dumps(request), headers)
        answer = connection.getresponse().read().decode()
        connection.close()
        return answer
