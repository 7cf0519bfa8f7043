"""The project's site, for tests."""

import importlib.util
import pathlib

import pytest

import host

ROOT = pathlib.Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "site"

# Where `cargo xtask docs` writes it.
SITE = ROOT / "target" / "docs"

# Results of tests, made up.
RESULTS = ROOT / "tests" / "expected" / "results"

# The page of the parameter tool on it.
TOOL = "plcfmu-tool.html"

GENERATOR = "zensical"
needs_generator = pytest.mark.skipif(
    importlib.util.find_spec(GENERATOR) is None, reason=f"{GENERATOR} not installed: it needs Python 3.11 (tests/requirements.txt)"
)


def build():
    """The module that writes the site."""
    specification = importlib.util.spec_from_file_location("site_build", FOLDER / "build.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def write(out):
    """Writes the site."""
    build().Site(host.FOLDER, out, results=RESULTS).write()
