"""Fixtures. `fmu` is every FMU that `cargo xtask fmu` has made, one after the other, so a new block is tested as soon as
its FMU is there. `open_fmu(NAME)` is a certain one."""

import pytest

import host
import plcfmu
import site_pages

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


@pytest.fixture(scope="session", params=host.names() or [NONE])
def fmu(request, open_fmu):
    if request.param == NONE:
        pytest.fail(f"there is no FMU in {host.FOLDER}: make them with `cargo xtask fmu`", pytrace=False)
    return open_fmu(request.param)


@pytest.fixture(scope="session", params=host.CONTROLLERS)
def controller(request, open_fmu):
    """The FMUs of the manuals' blocks, one after the other."""
    return open_fmu(request.param)


@pytest.fixture(scope="session")
def site():
    """The folder of the project's site, made anew."""
    site_pages.write(site_pages.SITE)
    return site_pages.SITE
