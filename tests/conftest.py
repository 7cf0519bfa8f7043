"""Fixtures. `fmu` is every FMU that `cargo xtask fmu` has made, one after the other, so a new block is tested as soon as
its FMU is there. `open_fmu(NAME)` is a certain one."""

import json
import os
import pathlib
import subprocess

import pytest

import host
import plcfmu

pytest.register_assert_rewrite("calls")

NONE = "none"  # the parameter where there are no FMUs, so that every test fails and says what to do


@pytest.fixture(scope="session")
def open_fmu(tmp_path_factory):
    """Unpacks an FMU by its name, once."""
    opened = {}

    def open_fmu(name):
        if name not in opened:
            try:
                path = plcfmu.fmu(name, host.FOLDER)
            except plcfmu.FmuNotFoundError as error:
                pytest.fail(str(error), pytrace=False)
            opened[name] = host.Fmu(path, tmp_path_factory.mktemp(name))
        return opened[name]

    return open_fmu


@pytest.fixture(scope="session")
def command():
    """The program `plcfmu`: that of PLCFMU_COMMAND, or built."""
    if os.environ.get("PLCFMU_COMMAND"):
        return os.environ["PLCFMU_COMMAND"]
    build = ["cargo", "build", "--quiet", "--package", "plcfmu", "--bin", "plcfmu"]
    build.append("--message-format=json-render-diagnostics")
    messages = subprocess.run(build, stdout=subprocess.PIPE, text=True, check=True, cwd=pathlib.Path(__file__).parents[1]).stdout
    executables = [json.loads(line).get("executable") for line in messages.splitlines()]
    (executable,) = filter(None, executables)
    return executable


@pytest.fixture(scope="session", params=host.names() or [NONE])
def fmu(request, open_fmu):
    if request.param == NONE:
        pytest.fail(f"there is no FMU in {host.FOLDER}: make them with `cargo xtask fmu`", pytrace=False)
    return open_fmu(request.param)


@pytest.fixture(scope="session", params=host.CONTROLLERS)
def controller(request, open_fmu):
    """The FMUs of the manuals' blocks, one after the other."""
    return open_fmu(request.param)
