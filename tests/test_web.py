"""The scripts of the parameter tool's page, checked by tsc and biome from npm, in the versions that package-lock.json pins."""

import hashlib
import os
import pathlib
import re
import shutil
import subprocess

import pytest

WEB = pathlib.Path(__file__).parents[1] / "tool/web"
NPM = shutil.which("npm")


@pytest.fixture(scope="module")
def web(tmp_path_factory):
    """A copy of the page's sources with the packages of npm."""
    if NPM is None and not os.environ.get("CI"):
        pytest.skip("no npm: on Debian and Ubuntu 'apt install npm'")
    folder = tmp_path_factory.mktemp("page") / "web"
    shutil.copytree(WEB, folder, ignore=shutil.ignore_patterns("node_modules"))
    # Not `npm ci`, which insists on the packages for all other systems, that not every registry has.
    npm(folder, "install", "--no-save", "--ignore-scripts", "--no-audit", "--no-fund")
    return folder


def npm(folder, *arguments):
    done = subprocess.run([NPM, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout


def test_the_scripts_have_no_error_and_are_formatted(web):
    npm(web, "run", "check")


def test_a_wrong_type_is_found(web):
    wrong = web / "src/wrong.js"
    wrong.write_text('/** @type {number} */\nexport const wrong = "text";\n')
    done = subprocess.run([NPM, "run", "check"], cwd=web, capture_output=True, text=True)
    wrong.unlink()
    assert done.returncode != 0
    assert "wrong.js" in done.stdout


def test_what_others_have_made_is_what_its_readme_says():
    text = (WEB / "vendor/README.md").read_text()
    sums = dict(re.findall(r"^\| `(\S+)` \|.*\| `([0-9a-f]{64})` \|$", text, re.MULTILINE))
    others = [path for path in (WEB / "vendor").iterdir() if path.name != "README.md"]
    files = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in others}
    assert sums == files
