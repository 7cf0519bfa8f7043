"""A folder as a program: its sources and tag tables become an FMU; what nothing declares is assumed and can be corrected."""

import pathlib
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
import zipfile

import host
import pytest

ROOT = pathlib.Path(__file__).parents[1]
MIXER = ROOT / "examples/programs/mixer"


@pytest.fixture
def plcfmu(command, tmp_path):
    def plcfmu(*arguments):
        done = [command, *map(str, arguments)]
        return subprocess.run(done, cwd=tmp_path, env=host.environment(), capture_output=True, text=True)

    return plcfmu


def interface(path):
    """Causality, type and description of the variables of an FMU, by their names without apostrophes."""
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    found = {}
    for variable in root.iter("ScalarVariable"):
        name = variable.get("name").replace("'", "")
        found[name] = (variable.get("causality"), variable[0].tag, variable.get("description", ""))
    return found


def test_the_tags_of_a_folder_are_the_inputs_and_outputs_of_its_fmu(plcfmu, tmp_path):
    done = plcfmu("build", MIXER, "--cycle", "100ms", "--output", "Batch running")
    assert done.returncode == 0, done.stderr
    table = done.stderr.splitlines()
    assert table[0].endswith("mixer: 3 sources")
    assert [line.split(maxsplit=1)[1].strip() for line in table if line.startswith("  SCL")] == [
        "1 organization block, 1 function block"
    ]
    assert "  tags        10 tags, 9 in use; 1 constant, from 1 table" in table
    assert not any("missing" in line for line in table)
    # As in the table of tags itself, read with other code.
    tags = (MIXER / "tags/Mixer.xml").read_text(encoding="utf-8")
    expected = {}
    for part in tags.split("<SW.Tags.PlcTag ")[1:]:
        of, address, name, text = (
            re.search(f"<{key}>(.*?)</{key}>", part).group(1) for key in ("DataTypeName", "LogicalAddress", "Name", "Text")
        )
        causality = {"I": "input", "Q": "output", "M": "output"}[address[1]]
        expected[name] = (causality, "Boolean" if of == "Bool" else "Real", text.split("; unit")[0])
    # Nothing reads this one.
    assert expected.pop("Spare") == ("input", "Boolean", "Not in use")
    found = interface(tmp_path / "Main.fmu")
    assert {name: found[name] for name in expected} == expected
    outside = [name for name, (causality, *_) in found.items() if causality in ("input", "output")]
    assert sorted(outside) == sorted(expected)
    assert found["Recipe.level"] == ("parameter", "Real", "Filling level")


def test_a_folder_is_checked_tested_and_run(plcfmu, tmp_path):
    checked = plcfmu("check", MIXER)
    assert checked.returncode == 0 and checked.stdout.endswith("the FMU runs Main\n"), checked.stdout + checked.stderr
    tested = plcfmu("test", MIXER)
    assert tested.returncode == 0, tested.stdout + tested.stderr
    assert "a batch is filled, stirred for 5 s and drained: ok\nan open lid stops it: ok\n" in tested.stdout
    ran = plcfmu("run", MIXER, "--cycle=100ms", "--stop=1", "--record=mixer.Ready", "--out=out.csv", "--set=mixer.'Lid closed'=true")
    assert ran.returncode == 0, ran.stderr


PROGRAM = """FUNCTION_BLOCK "Main"
VAR
  Connection : TSEND_C;
  data : Array[0..3] of Byte;
END_VAR
BEGIN
  "Lamp" := "Start" AND "Line".ready;
  #Connection(REQ := "Start", DATA := #data);
  IF #Connection.DONE THEN "Line".sent := TRUE; END_IF;
END_FUNCTION_BLOCK
"""


def test_what_no_source_declares_is_assumed_once_written_and_read_again(plcfmu, tmp_path):
    (tmp_path / "line").mkdir()
    (tmp_path / "line/Main.scl").write_text(PROGRAM, encoding="utf-8")
    refused = plcfmu("check", "line")
    assert refused.returncode == 1 and 'no source declares the tags "Lamp"' in refused.stdout
    built = plcfmu("build", "line", "--cycle=10ms", "--assume")
    assert built.returncode == 0, built.stderr
    told = [line for line in built.stderr.splitlines() if "assumed: " in line]
    assert sorted(line.split('"')[1] for line in told) == ["Lamp", "Line", "Start", "TSEND_C"]
    assert 'line/Main.scl:7: assumed: "Lamp" is an output of type BOOL' in [line.replace("\\", "/") for line in told]
    found = interface(tmp_path / "Main.fmu")
    causality = {name: of[0] for name, of in found.items()}
    assert causality["Start"] == causality["Line.ready"] == causality["Connection.DONE"] == "input"
    assert causality["Lamp"] == causality["Line.sent"] == causality["Connection.REQ"] == "output"
    assert causality["Connection.DATA[3]"] == "output"
    # What is corrected there stays.
    assumed = tmp_path / "assumed.scl"
    text = assumed.read_text(encoding="utf-8")
    assert "Nothing here is a statement on safety" in text
    assumed.write_text(text.replace('"Lamp" : BOOL;', '"Lamp" AT %Q0.5 : BOOL; // signal lamp'), encoding="utf-8")
    again = plcfmu("build", "line", "--cycle=10ms", "--assume", "assumed.scl")
    assert again.returncode == 0 and "assumed: " not in again.stderr, again.stderr
    assert interface(tmp_path / "Main.fmu")["Lamp"] == ("output", "Boolean", "signal lamp")
    # It is a source as any other.
    assert plcfmu("check", "line", "assumed.scl").returncode == 0
    # What a change of the program misses is added, below the stubs that are there.
    (tmp_path / "line/Main.scl").write_text(PROGRAM.replace('"Start" AND', '"Start" AND "Ready" AND'), encoding="utf-8")
    more = plcfmu("build", "line", "--cycle=10ms", "--assume", "assumed.scl")
    assert more.returncode == 0 and "1 assumption is in assumed.scl" in more.stderr, more.stderr
    text = assumed.read_text(encoding="utf-8")
    assert "FUNCTION_BLOCK" in text and text.index("FUNCTION_BLOCK") < text.index('"Ready"')


def test_a_block_may_be_a_stub_by_name(plcfmu, tmp_path):
    text = PROGRAM.replace('"Lamp" := "Start" AND "Line".ready;', "").replace('"Start"', "TRUE")
    text = text.replace('"Line".sent := TRUE', "#data[0] := 1")
    (tmp_path / "Main.scl").write_text(text, encoding="utf-8")
    refused = plcfmu("check", "Main.scl")
    assert refused.returncode == 1 and "TSEND_C accesses the PLC's hardware or system" in refused.stdout
    done = plcfmu("build", "Main.scl", "--cycle=10ms", "--stub", "TSEND_C")
    assert done.returncode == 0, done.stderr
    assert interface(tmp_path / "Main.fmu")["Connection.DONE"][0] == "input"


def test_blocks_that_two_sources_have_are_one_if_they_are_the_same(plcfmu, tmp_path):
    folder = tmp_path / "twice"
    shutil.copytree(MIXER, folder)
    block = (MIXER / "Mixer.scl").read_text(encoding="utf-8")
    (folder / "Copy.scl").write_text("// of another export\n" + block.replace("   VAR_INPUT", "\n   VAR_INPUT"), encoding="utf-8")
    same = plcfmu("check", "twice")
    assert same.returncode == 0, same.stdout
    (folder / "Copy.scl").write_text(block.replace("#step := 20;", "#step := 30;"), encoding="utf-8")
    different = plcfmu("check", "twice")
    assert different.returncode == 1
    assert re.search(r"Mixer.scl:1:16: Mixer is declared twice: first in .*Copy.scl:1", different.stdout), different.stdout
