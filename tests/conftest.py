"""Fixtures. `fmu` is every FMU that `cargo xtask fmu` has made, one after the other: a new block is
tested by being there. `open_fmu(NAME)` is a certain one."""

import pytest

import host

pytest.register_assert_rewrite("calls")

NONE = "none"  # stands for the FMUs where there is no one, so that every test says what to do


@pytest.fixture(scope="session")
def open_fmu(tmp_path_factory):
    """Unpacks an FMU by its name, once."""
    opened = {}

    def open_fmu(name):
        if name not in opened:
            path = host.FOLDER / f"{name}.fmu"
            if not path.is_file():
                pytest.fail(host.REMEDY % path.name, pytrace=False)
            opened[name] = host.Fmu(path, tmp_path_factory.mktemp(name))
        return opened[name]

    return open_fmu


@pytest.fixture(scope="session", params=host.names() or [NONE])
def fmu(request, open_fmu):
    if request.param == NONE:
        pytest.fail(host.REMEDY % "FMU", pytrace=False)
    return open_fmu(request.param)


@pytest.fixture(scope="session", params=host.CONTROLLERS)
def controller(request, open_fmu):
    """The FMUs of the manuals' blocks, one after the other."""
    return open_fmu(request.param)
