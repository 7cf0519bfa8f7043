"""Fixtures. `fmu` is each FMU that `cargo xtask fmu` has built, in turn, so a new block is tested as soon as its FMU exists.
`open_fmu(NAME)` is a specific one.

In the modules of `PRESETS_TOO`, `fmu` is also a program in SCL, and a preset of each FMU, with its own start values. In the
modules of `VERSIONS_TOO`, it is each of these in FMI 3.0 as well."""

import collections
import json
import os
import pathlib
import subprocess
import zipfile

import fmpy
import pytest

import host
import plcfmu
import results
import site_pages

pytest.register_assert_rewrite("calls")

PRESETS_TOO = ("test_conformance", "test_fmu_state", "test_time")
VERSIONS_TOO = ("test_fmu_state", "test_time", "test_restart_values")
PRESET = "preset of "
PROGRAM = "program "

# Each of these files takes minutes, with few tests.
LONGEST = ("test_c_sources", "test_packer", "test_wheel")

NONE = "none"  # the parameter if there are no FMUs, so that every test fails and says what to do


@pytest.fixture(scope="session")
def open_fmu(request, tmp_path_factory):
    """Unpacks an FMU by its name, once. `program NAME` is the FMU of `tests/programs/NAME.scl`."""
    opened = {}

    def built(name, *options):
        folder = tmp_path_factory.mktemp(name)
        source = pathlib.Path(__file__).parent / "programs" / f"{name}.scl"
        build = [request.getfixturevalue("command"), "build", str(source), "--cycle=100ms", "--out", str(folder), *options]
        subprocess.run(build, check=True, capture_output=True)
        (path,) = folder.glob("*.fmu")
        return path

    def open_fmu(name):
        if name not in opened:
            try:
                own = name.removeprefix(host.NEWER)
                if own.startswith(PROGRAM):
                    path = built(own.removeprefix(PROGRAM), *(["--fmi=3", "--types=wide"] if own != name else []))
                else:
                    path = plcfmu.fmu(own, host.FOLDER if own == name else request.getfixturevalue("packed")())
            except plcfmu.FmuNotFoundError as error:
                pytest.fail(str(error), pytrace=False)
            opened[name] = host.Fmu(path, tmp_path_factory.mktemp(name.replace(" ", "_")))
        return opened[name]

    return open_fmu


def pytest_generate_tests(metafunc):
    if "fmu" in metafunc.fixturenames:
        has_presets = metafunc.module.__name__ in PRESETS_TOO
        programs = [PROGRAM + "mixer"] if has_presets and host.names() and not host.PLATFORM else []
        is_newer_too = metafunc.module.__name__ in VERSIONS_TOO
        originals = host.versions(host.names() + programs, is_newer_too)
        # How a preset starts does not depend on the block: in FMI 3.0, the preset of a program represents all.
        presets = [PRESET + name for name in host.names() + host.versions(programs, is_newer_too)] if has_presets else []
        metafunc.parametrize("fmu", originals + presets or [NONE], indirect=True, scope="session")


@pytest.hookimpl(trylast=True)  # pytest itself sorts by fixtures
def pytest_collection_modifyitems(items):
    """Puts the longest files first: at the end, one of them would leave the other processors idle."""
    items.sort(key=lambda item: item.path.stem not in LONGEST)


def pytest_terminal_summary(terminalreporter):
    """Lists the skipped tests, one line for each reason, which says what to install."""
    reasons = collections.defaultdict(collections.Counter)
    for report in terminalreporter.stats.get("skipped", []):
        file, _, reason = report.longrepr
        reasons[reason.removeprefix("Skipped: ")][pathlib.Path(file).name] += 1
    for reason, files in sorted(reasons.items()):
        tests = ", ".join(f"{count} of {file}" for file, count in sorted(files.items()))
        terminalreporter.write_line(f"skipped: {tests}: {reason}")
    if folder := os.environ.get("PLCFMU_RESULTS"):
        results.write(pathlib.Path(folder), terminalreporter.stats)


@pytest.fixture(scope="session")
def expect():
    """Compares a text with the file of this name in `expected/`. Writes the file instead if UPDATE_EXPECT=1."""
    folder = pathlib.Path(__file__).parent / "expected"

    def expect(name, text):
        path = folder / name
        if os.environ.get("UPDATE_EXPECT"):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text.encode())
        expected = path.read_text(encoding="utf-8") if path.exists() else ""
        assert text == expected, f"{path.relative_to(folder.parents[1])}: UPDATE_EXPECT=1 writes the current text"

    return expect


def built(program):
    """The path of a program of the workspace. Builds both packages, so that cargo compiles with the features of both."""
    build = ["cargo", "build", "--quiet", "--package", "plcfmu", "--package", "xtask", "--bin", program]
    build.append("--message-format=json-render-diagnostics")
    root = pathlib.Path(__file__).parents[1]
    messages = subprocess.run(build, stdout=subprocess.PIPE, text=True, check=True, cwd=root).stdout
    executables = [json.loads(line).get("executable") for line in messages.splitlines()]
    (executable,) = filter(None, executables)
    return executable


@pytest.fixture(scope="session")
def command():
    """The program `plcfmu`: PLCFMU_COMMAND, or built."""
    return os.environ.get("PLCFMU_COMMAND") or built("plcfmu")


@pytest.fixture(scope="session")
def packer():
    """The program behind `cargo xtask`."""
    return built("xtask")


@pytest.fixture(scope="session")
def packed(request, tmp_path_factory):
    """The folder of all FMUs in FMI 3.0 with these types. PLCFMU_FMI3 names one with native types, like PLCFMU_FMUS for FMI 2.0."""
    folders = {}
    if given := os.environ.get("PLCFMU_FMI3"):
        folders["native"] = pathlib.Path(given)

    def packed(types="native"):
        if types not in folders:
            folders[types] = tmp_path_factory.mktemp(f"fmi3_{types}")
            # Requested only here, because building it takes minutes.
            packer = request.getfixturevalue("packer")
            command = [packer, "fmu", "--fmi", "3", "--types", types, "--out", str(folders[types])]
            done = subprocess.run(command, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
        return folders[types]

    return packed


@pytest.fixture(scope="session")
def make_preset(command):
    """Makes a preset of an FMU with `plcfmu preset --set` and returns its path."""

    def make_preset(fmu, path, **values):
        settings = [f"--set={name}={value!r}" for name, value in values.items()]
        given = [command, "preset", str(fmu.path), *settings, "--out", str(path)]
        done = subprocess.run(given, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return path

    return make_preset


@pytest.fixture(scope="session")
def open_preset(open_fmu, make_preset, tmp_path_factory):
    """A preset of an FMU, given by its name, in which every number differs; made once."""
    opened = {}

    def open_preset(name):
        if name not in opened:
            fmu = open_fmu(name)
            folder = tmp_path_factory.mktemp("preset")
            path = make_preset(fmu, folder / f"{fmu.name}_PRESET.fmu", **host.other_values(fmu))
            opened[name] = host.Fmu(path, folder / "unpacked")
        return opened[name]

    return open_preset


@pytest.fixture(scope="session")
def fmu(request, open_fmu, open_preset):
    if request.param.startswith(PRESET):
        return open_preset(request.param[len(PRESET):])
    if request.param == NONE:
        pytest.fail(f"no FMU in {host.FOLDER}: make them with `cargo xtask fmu`", pytrace=False)
    return open_fmu(request.param)


@pytest.fixture(scope="session", params=host.CONTROLLERS)
def controller(request, open_fmu):
    """Each FMU of the manuals' blocks, in turn."""
    return open_fmu(request.param)


@pytest.fixture(scope="session")
def pack_foreign():
    """Builds an FMU in a folder from the source and description of this name in tests/foreign;
    `defines` are compiler options."""

    def pack_foreign(name, folder, *defines):
        source = pathlib.Path(__file__).parent / "foreign"
        library = folder / f"{name}{fmpy.sharedLibraryExtension}"
        compiler = os.environ.get("CC", "cc")
        subprocess.run([compiler, *defines, "-shared", "-fPIC", "-o", library, source / f"{name}.c"], check=True)
        path = folder / f"{name.upper()}.fmu"
        description = (source / f"{name}.xml").read_text()
        # FMI 3.0 names platforms by processor and operating system.
        platform = fmpy.platform_tuple if 'fmiVersion="3.0"' in description else fmpy.platform
        with zipfile.ZipFile(path, "w") as fmu:
            fmu.writestr("modelDescription.xml", description)
            fmu.write(library, f"binaries/{platform}/{library.name}")
        return path

    return pack_foreign


@pytest.fixture(scope="session")
def faulty(pack_foreign, tmp_path_factory):
    """tests/foreign/faulty.c as an FMU."""
    return pack_foreign("faulty", tmp_path_factory.mktemp("faulty"))


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder of the project's site, newly built."""
    folder = tmp_path_factory.mktemp("site")
    site_pages.write(folder)
    return folder
