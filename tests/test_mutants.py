"""`plcfmu check` on copies of an FMU with one defect each, which some host refuses or misreads. The defect is found; what the
standard allows is not called wrong."""

import re
import subprocess
import sys
import zipfile

import pytest

import host

XML = "modelDescription.xml"
LIBRARY = "binaries/linux64/CONT_C.so"
START = "resources/start.txt"
AARCH64 = 0xB7

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the defects are those of a library of Linux")


def unpacked(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(files, path):
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def replaced(pattern, by):
    """Replaces the first match in the model description."""

    def change(files):
        text, count = re.subn(pattern, by, files[XML].decode(), count=1, flags=re.DOTALL)
        assert count == 1, pattern
        files[XML] = text.encode()

    return change


def variable(name, pattern, by):
    """Replaces in the element of a variable."""
    return replaced(rf'(<ScalarVariable name="{name}"(?:(?!</ScalarVariable>).)*?){pattern}', rf"\g<1>{by}")


def for_arm(library):
    return library[:18] + AARCH64.to_bytes(2, "little") + library[20:]


def arm(files):
    files[LIBRARY] = for_arm(files[LIBRARY])


def elf_for_windows(files):
    files["binaries/win64/CONT_C.dll"] = files[LIBRARY]


def cut_off(files):
    files[LIBRARY] = files[LIBRARY][:1000]


def without_a_function(files):
    files[LIBRARY] = files[LIBRARY].replace(b"fmi2DoStep\0", b"fmi2NoStep\0")


UNKNOWN = r"(<InitialUnknowns>)"

# What is changed, and what is said.
MUTANTS = {
    "an input without a start value": (variable("PV_IN", ' start="0.0"', ""), "start is missing"),
    "an unknown attribute": (variable("PV_IN", "causality", "kausality"), "kausality"),
    "an output that Outputs lacks": (replaced(r'(<Outputs>\s*)<Unknown index="27"[^>]*/>', r"\1"), "Outputs: variable"),
    "the GUID of nothing": (replaced('guid="[^"]*"', f'guid="{{{"-".join("0" * n for n in (8, 4, 4, 4, 12))}}}"'), "GUID"),
    "another GUID": (replaced('guid="{.', 'guid="{9'), "it does not contain the GUID"),
    "a name twice": (replaced('name="PV_IN"', 'name="MAN"'), "used twice"),
    "two inputs with one value reference": (variable("PV_IN", 'Reference="10"', 'Reference="9"'), "is also used by"),
    "a unit that is not defined": (variable("CYCLE", 'unit="s"', 'unit="h"'), "is not defined"),
    "an exact parameter without a start value": (variable("GAIN", ' start="2.0"', ""), "start is missing"),
    "a calculated output with a start value": (variable("LMN_I", "<Real/>", '<Real start="1.0"/>'), "is calculated"),
    "a start value below its range": (variable("CYCLE", 'start="1.0"', 'start="0.0"'), "below min"),
    "an index that there is not": (replaced(r'<Unknown index="35"', '<Unknown index="99"'), "no such variable"),
    "a continuous parameter": (variable("GAIN", "tunable", "continuous"), "not allowed together"),
    "a continuous Boolean": (variable("MAN_ON", "discrete", "continuous"), "only a Real can be continuous"),
    "a name that is no identifier": (replaced('name="PV_IN"', 'name="PV IN"'), "structured naming convention"),
    "a library of another name": (replaced('Identifier="CONT_C"', 'Identifier="PID"'), "it is not named PID"),
    "a library that is cut off": (cut_off, "it is not a library"),
    "a library without a function": (without_a_function, "it does not export fmi2DoStep"),
    "a library for another processor": (arm, "linux64 needs a Linux library for x86_64"),
    "a library of Linux for Windows": (elf_for_windows, "win64 needs a Windows library"),
    "a start value that the library does not have": (variable("GAIN", 'start="2.0"', 'start="9.0"'), "GAIN"),
    "an output with the value reference of an input": (
        variable("LMN_I", 'Reference="31"', 'Reference="10"'),
        'valueReference = 10 is also used by "PV_IN"',
    ),
    "an unknown that does not exist": (replaced(UNKNOWN, r'\1<Unknown index="14"/>'), "does not belong here"),
}


@pytest.fixture
def check(command, tmp_path):
    """Checks files as an FMU, which runs: the return code and what is said."""

    def check(files):
        path = packed(files, tmp_path / "CONT_C.fmu")
        done = subprocess.run([command, "check", "--run", path], capture_output=True, text=True)
        return done.returncode, done.stdout

    return check


@pytest.mark.parametrize("defect", MUTANTS)
def test_a_defect_is_found(check, defect):
    files = unpacked(host.FOLDER / "CONT_C.fmu")
    change, said = MUTANTS[defect]
    change(files)
    code, output = check(files)
    wrong = [line for line in output.splitlines() if line.startswith("  WRONG: ")]
    assert code == 1
    assert len(wrong) == 1 and said in wrong[0], output


def test_an_output_that_initial_unknowns_leave_out_departs_from_the_standard_and_is_not_wrong(check):
    """As in every FMU of PythonFMU."""
    files = unpacked(host.FOLDER / "CONT_C.fmu")
    replaced(r'(<InitialUnknowns>\s*)<Unknown index="27"[^>]*/>', r"\1")(files)
    code, output = check(files)
    assert code == 0
    departures = [line for line in output.splitlines() if "DEPARTS" in line]
    assert departures == ['  DEPARTS: modelDescription.xml: InitialUnknowns: variable "LMN" (index 27) is missing: add it']
    assert "run: instantiated, initialized, 10 steps" in output
    assert output.endswith("\n  departs from the standard, but runs in the tools tested\n")


def other_guid(files, original):
    guid = re.search('guid="[^"]*"', original[XML].decode())[0]
    replaced('guid="[^"]*"', guid)(files)


PRESETS = {
    "the GUID of the original": (other_guid, "start.txt has the start values of"),
    "a start value of the description": (
        lambda files, _: variable("GAIN", 'start="1.5"', 'start="3.5"')(files),
        "GAIN is 1.5 in resources/start.txt, but 3.5",
    ),
    "a start value of the file": (
        lambda files, _: files.update({START: files[START].replace(b"GAIN = 1.5", b"GAIN = 3.5")}),
        "one of them was changed",
    ),
}


@pytest.mark.parametrize("defect", PRESETS)
def test_a_defect_of_a_preset_is_found(check, open_fmu, make_preset, tmp_path, defect):
    path = make_preset(open_fmu("CONT_C"), tmp_path / "preset.fmu", GAIN=1.5)
    change, said = PRESETS[defect]
    files = unpacked(path)
    assert check(files)[0] == 0
    change(files, unpacked(host.FOLDER / "CONT_C.fmu"))
    code, output = check(files)
    assert code == 1
    assert said in output


def move(files, path, content):
    del files[LIBRARY]
    files[path] = content


def model_exchange(files):
    replaced("<CoSimulation.*</CoSimulation>", '<ModelExchange modelIdentifier="CONT_C"/>')(files)


RIGHT = {
    "for another platform": (
        lambda files: move(files, "binaries/aarch64-linux/CONT_C.so", for_arm(files[LIBRARY])),
        "not run: the FMU has no library for this platform",
    ),
    "for model exchange": (model_exchange, "not run: the FMU is for model exchange only"),
    "of sources": (lambda files: move(files, "sources/cont_c.c", b"int f;"), "not run: the FMU contains only sources"),
    "without a unit": (variable("CYCLE", ' unit="s" displayUnit="ms"', ""), "all variables read"),
}


@pytest.mark.parametrize("kind", RIGHT)
def test_an_fmu_that_the_standard_allows_is_right(check, kind):
    files = unpacked(host.FOLDER / "CONT_C.fmu")
    change, said = RIGHT[kind]
    change(files)
    code, output = check(files)
    assert (code, "WRONG" in output) == (0, False), output
    assert said in output
