"""The parameter tool as tests use it: its page, and `plcfmu tool` as a page asks it."""

import http.client
import json
import os
import pathlib
import signal
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[1]
REMEDY = "there is no %s: make it with `cargo xtask tool`, or set PLCFMU_TOOL to it"


def page():
    """The path of the page with the engine in it."""
    path = pathlib.Path(os.environ.get("PLCFMU_TOOL") or ROOT / "target/tool/plcfmu-tool.html")
    if not path.is_file():
        pytest.fail(REMEDY % path, pytrace=False)
    return path


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
