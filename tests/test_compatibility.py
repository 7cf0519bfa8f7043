"""The folder of `cargo xtask dist` in which others find what to try the FMUs with: FMPy's checker of the FMI cross-check finds
nothing."""

import importlib.util
import json
import re
import zipfile

import numpy as np
import pytest
from fmpy.cross_check.validate_vendor_repo import validate_test_fmu

import host
import site_pages

TOOL_ENTRY = {"name", "license", "url", "vendor", "vendorURL", "description", "platforms", "fmiVersions", "fmuExport", "fmuImport"}


@pytest.fixture(scope="module")
def module():
    path = site_pages.ROOT / "plcfmu/python/compatibility.py"
    specification = importlib.util.spec_from_file_location("compatibility", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def folder(module, tmp_path_factory):
    out = tmp_path_factory.mktemp("compatibility")
    module.write(host.FOLDER, out, "0.1.0", "https://plcfmu.example")
    return out


def test_fmpys_checker_of_the_cross_check_finds_nothing(folder):
    folders = sorted(folder.glob("fmus/2.0/cs/linux64/plcfmu/0.1.0/*"))
    assert [path.name for path in folders] == host.names()
    for path in folders:
        expected = {f"{path.name}{end}" for end in (".fmu", "_in.csv", "_ref.csv", "_ref.opt")} | {"README.md"}
        assert {file.name for file in path.iterdir()} == expected
        assert validate_test_fmu(str(path)) == []


def test_the_checker_finds_what_is_wrong(module, folder, tmp_path):
    (path,) = folder.glob("fmus/2.0/cs/linux64/plcfmu/0.1.0/TANK")
    copy = tmp_path / "fmus/2.0/cs/linux64/plcfmu/0.1.0/TANK"
    copy.mkdir(parents=True)
    for file in path.iterdir():
        (copy / file.name).write_bytes(file.read_bytes())
    (copy / "TANK_ref.opt").write_text("StartTime, 0\n")
    assert any("Missing element" in problem for problem in validate_test_fmu(str(copy)))


@pytest.mark.parametrize("name", host.names())
def test_the_options_fit_the_reference_and_the_read_me_has_the_settings_that_no_input_can_hold(folder, name):
    """That the reference comes out again, bit for bit, is a test of test_package.py."""
    path = folder / "fmus/2.0/cs/linux64/plcfmu/0.1.0" / name
    options = dict(line.split(", ") for line in (path / f"{name}_ref.opt").read_text().splitlines())
    start, stop, step = (float(options[key]) for key in ("StartTime", "StopTime", "StepSize"))
    reference = np.genfromtxt(path / f"{name}_ref.csv", delimiter=",", names=True, deletechars="")
    assert (reference["time"][0], reference["time"][-1]) == (start, stop)
    assert np.diff(reference["time"]) == pytest.approx(step)
    with zipfile.ZipFile(path / f"{name}.fmu") as package:
        text = package.read("documentation/fmi-ls-ref.txt").decode()
    settings = re.findall(r"^Set before the initialization ends: (.+)$", text, re.MULTILINE)
    assert all(setting in (path / "README.md").read_text("utf-8") for setting in settings)


def test_the_entry_of_the_list_of_tools_is_there_only_where_it_has_an_address(module, folder, tmp_path):
    entry = json.loads((folder / "tools.json").read_text("utf-8"))
    assert TOOL_ENTRY <= set(entry) and entry["url"] == "https://plcfmu.example/"
    module.write(host.FOLDER, tmp_path, "0.1.0")
    assert not (tmp_path / "tools.json").exists()
