"""`plcfmu params` over files of every format. The files in `parameters/` are synthetic: made for these tests, not taken from a
plant or from a PLC tool. `right/` covers what the formats can hold; what is said of each file in `wrong/` stands in
`expected/params/wrong/`."""

import json
import os
import pathlib
import struct
import subprocess

import fmpy
import lxml.etree
import pytest

import host

FILES = pathlib.Path(__file__).parent / "parameters"
DUMPS = {"DB41.bin": ["--block=FB 41"], "multi.bin": ["--block=CONT_C", "--offset=20"]}

# What each file gives, as far as it is not the start value of the block.
TIC101 = {"GAIN": 2.5, "TI": 60.0, "MAN_ON": False, "PV_PER": 27648}
RIGHT = {
    "generated.awl": {"TIC101": {"MAN_ON": False, "CYCLE": 0.1, "GAIN": 2.5, "TI": 90.0, "PV_PER": 27648}},
    "number.awl": {"DB41": {"GAIN": 3.0}},
    "by_hand.scl": {"TIC1": {"GAIN": -42.0, "TI": 90.0, "MAN_ON": False}, "PULSE1": {"PER_TM": 2.5}},
    "literals.awl": {
        "TIC101": {
            "SP_INT": 100.0,
            "PV_IN": 1000.5,
            "GAIN": 0.001,
            "PV_PER": 255,
            "MAN_ON": False,
            "CYCLE": 0.5,
            "TI": 86400 + 2 * 3600 + 3 * 60 + 4.005,
            "TD": 1.5,
            "TM_LAG": 2147483.647,
        }
    },
    "lost_names.awl": {"TIC101": {"MAN_ON": False, "GAIN": 7.5}},
    "utf16.awl": {"GRÖSSE": {"GAIN": 4.0}},
    "multi_instance.awl": {"TIC_A": {"GAIN": 1.5}, "TIC_B": {"MTR_TM": 40.0}},
    "tia.db": {"TIC201": {"GAIN": 1.25, "TI": 12.0}, "TIC202": {}},
    "openness.xml": {"TIC101": TIC101},
    "openness_v2.xml": {"TIC101": TIC101},
    "openness_multi.xml": {"TIC_A": TIC101},
    "DB41.bin": {"DB41": {"GAIN": 2.5, "MAN_ON": False, "PV_PER": 27648}},
    "multi.bin": {"multi": {"GAIN": 0.1, "MAN_ON": False, "PV_PER": 27648}},
    "loops.json": {"TIC101": {"GAIN": 2.5, "MAN_ON": False, "PV_PER": -1}, "YC1": {"PER_TM": 2.5}},
    "flat.json": {"flat": {"GAIN": 0.1, "LMN_HLM": 80.0}},
    "one.ssv": {"TIC101": {"GAIN": 2.5, "MAN_ON": False, "LMN_HLM": 80.0, "PV_PER": -1}},
    "two.ssv": {
        "A": {"MAN_ON": False, "GAIN": 3.0, "TD": 1.0},
        "B": {"DI_CONT_C.GAIN": 4.0, "RED_FAC": 20},
    },
}

WRONG = sorted(file.name for file in (FILES / "wrong").iterdir())


@pytest.fixture
def params(command, tmp_path):
    """Runs `plcfmu params` in an empty folder."""

    def params(*arguments):
        arguments = [command, "params", *map(str, arguments)]
        return subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, encoding="utf-8")

    return params


@pytest.fixture
def values(params):
    """The values of a file's loops, by loop and name."""

    def values(*arguments):
        done = params(*arguments, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return values


def rows(table):
    """The lines of a table as dictionaries: columns begin where their heads do."""
    head, *lines = table.splitlines()
    names = head.split()
    starts = [head.index(name) for name in names] + [None]
    cells = [[line[start:end].strip() for start, end in zip(starts, starts[1:])] for line in lines]
    return [dict(zip(names, line)) for line in cells]


def test_every_file_has_an_expectation():
    assert {file.name for file in (FILES / "right").iterdir()} == RIGHT.keys()
    expected = pathlib.Path(__file__).parent / "expected/params/wrong"
    assert sorted(file.stem for file in expected.iterdir()) == WRONG


@pytest.mark.parametrize("file", RIGHT)
def test_a_right_file_gives_its_values_and_else_the_start_values_of_the_block(params, values, file):
    arguments = [FILES / "right" / file, *DUMPS.get(file, [])]
    found = values(*arguments)
    assert list(found) == list(RIGHT[file])
    table = rows(params(*arguments).stdout)
    for loop, expected in RIGHT[file].items():
        assert {name: found[loop][name] for name in expected} == expected
        starts = {row["Parameter"]: row["Start"] for row in table if row["Loop"] == loop}
        assert list(starts) == list(found[loop])
        for name in found[loop].keys() - expected.keys():
            assert json.loads(starts[name]) == found[loop][name], name


@pytest.mark.parametrize("file", WRONG)
def test_a_wrong_file_is_refused_with_its_sentences_and_nothing_is_written(params, expect, tmp_path, file):
    block = ["--block=CONT_C"] if file.endswith(".bin") else []
    done = params(FILES / "wrong" / file, *block, "--out", "out.json")
    assert (done.returncode, done.stdout) == (3, "")
    assert list(tmp_path.iterdir()) == []
    expect(f"params/wrong/{file}.txt", local(done.stderr))


def local(text):
    """A text of a command with the paths below parameters/ as they are there."""
    return text.replace(f"{FILES}{os.sep}", "")


@pytest.mark.parametrize("ending", ["awl", "scl", "db", "xml", "json", "ssv", "bin"])
def test_a_loop_converted_to_any_format_reads_back_the_same(params, values, tmp_path, ending):
    given = [FILES / "right" / "two.ssv", "--loop", "A"]
    done = params(*given, "--out", f"A.{ending}")
    assert (done.returncode, done.stdout) == (0, f"A.{ending}: 1 loop, 26 values\n"), done.stderr
    block = ["--block=CONT_C"] if ending == "bin" else []
    assert values(f"A.{ending}", *block) == values(*given)
    assert params(*given, "--diff", f"A.{ending}", *block).stdout == "no differences\n"


@pytest.mark.parametrize("file", ["one.ssv", "multi.bin"])
def test_origins_units_and_start_values_stand_in_the_table(params, expect, file):
    done = params(FILES / "right" / file, *DUMPS.get(file, []))
    assert done.returncode == 0
    expect(f"params/table/{file}.txt", "\n".join(line.rstrip() for line in local(done.stdout).splitlines()) + "\n")


def test_what_the_block_will_do_with_the_values_is_said(params, expect, tmp_path):
    loop = {"GAIN": 0, "TI": 0.1, "TD": 1, "LMN_HLM": -5, "LMN_FAC": 30}
    (tmp_path / "a.json").write_text(json.dumps({"TIC101": loop, "YC1": {"PER_TM": 0.05, "CYCLE": 0.01}}))
    expect("params/advice.txt", params("a.json").stderr)


def test_a_dump_that_does_not_look_like_the_block_is_remarked(params, tmp_path):
    data = bytearray((FILES / "right" / "DB41.bin").read_bytes())
    data[1] = 4
    struct.pack_into(">i", data, 2, 0)
    struct.pack_into(">f", data, 20, float("nan"))
    (tmp_path / "DB41.bin").write_bytes(data)
    done = params("DB41.bin", "--block=FB41")
    for sentence in ["byte 20: GAIN is not a finite number", "byte 2: CYCLE is not greater than 0", "byte 1: bits are set"]:
        assert f"remark: DB41.bin: {sentence}" in done.stderr
    refused = params("DB41.bin", "--block=FB41", "--out", "a.json")
    assert refused.stderr.endswith("error: a.json: DB41: GAIN is NaN, but JSON has only finite numbers\n")
    assert not (tmp_path / "a.json").exists()


def test_differences_are_told_by_loop_and_parameter(params, tmp_path):
    params(FILES / "right" / "two.ssv", "--out", "before.awl", "--loop", "A")
    after = {"A": {"MAN_ON": False, "GAIN": 3.5, "TD": 1, "TI": 25}, "NEW": {"PER_TM": 1}}
    (tmp_path / "after.json").write_text(json.dumps(after))
    done = params("before.awl", "--diff", "after.json")
    assert done.returncode == 1 and "may differ from the PLC's values by one bit" in done.stderr
    told = json.loads(params("before.awl", "--diff", "after.json", "--json").stdout)
    assert told["differences"][0] == {"loop": "A", "parameter": "GAIN", "before": "3.0", "after": "3.5", "unit": None}
    assert told["only_in"] == [{"loop": "NEW", "file": "after.json"}]
    table = done.stdout.replace("NEW is only in after.json\n", "")
    assert table != done.stdout
    assert [list(row.values()) for row in rows(table)] == [["A", "GAIN", "3.0", "3.5", ""], ["A", "TI", "20.0", "25.0", "s"]]


def test_a_loop_that_the_file_does_not_have_is_refused_with_those_that_it_has(params):
    done = params(FILES / "right" / "loops.json", "--loop", "TIC999")
    assert done.stderr == f"error: no loop TIC999 in {FILES / 'right' / 'loops.json'}; available: TIC101, YC1\n"


def test_the_input_is_not_overwritten_and_an_unknown_ending_is_refused(params, tmp_path):
    text = (FILES / "right" / "loops.json").read_bytes()
    (tmp_path / "a.json").write_bytes(text)
    assert params("a.json", "--out", "./a.json").stderr.endswith(
        "error: ./a.json is read by this command: write to another file\n"
    )
    assert (tmp_path / "a.json").read_bytes() == text
    assert "a.txt: not a parameter file; its extension must be one of .awl" in params("a.txt").stderr
    (tmp_path / "a.txt").write_bytes(text)
    assert params("a.txt", "--format", "json").returncode == 0


def test_a_written_ssv_is_valid_by_the_public_schema(params, tmp_path):
    schema = lxml.etree.XMLSchema(file=pathlib.Path(fmpy.__file__).parent / "ssp/schema/SystemStructureParameterValues.xsd")
    for arguments in [["two.ssv"], ["two.ssv", "--loop", "B"], ["loops.json"]]:
        file, *loop = arguments
        assert params(FILES / "right" / file, *loop, "--out", "out.ssv").returncode == 0
        schema.assertValid(lxml.etree.parse(tmp_path / "out.ssv"))


def test_json_of_an_fmu_goes_into_fmpy_as_start_values(open_fmu, values):
    path = open_fmu("CONT_C").path
    ((name, start),) = values(path, "--loop=TIC101").items()
    assert name == "TIC101"
    start = {**start, "MAN": 37.5}
    result = fmpy.simulate_fmu(str(path), start_values=start, stop_time=2, output_interval=1, output=["LMN"])
    assert result["LMN"][-1] == 37.5


def test_the_block_of_somebody_s_fmu_is_known_by_its_table(params, values, open_fmu, tmp_path):
    path = open_fmu("HEATER").path
    (tmp_path / "a.json").write_text('{"FURNACE": {"RISE": 250, "T_AMB": 18}}')
    assert "no block has these inputs" in params("a.json").stderr
    loop = values("a.json", "--fmus", path)["FURNACE"]
    assert (loop["RISE"], loop["T_AMB"], loop["FURN_TM"]) == (250.0, 18.0, 120.0)
    own = values(path)
    assert list(own) == ["HEATER"] and own["HEATER"]["T_PER_100"] == 400.0


def test_the_offset_of_a_dump_is_that_of_its_own_file(params):
    multi = [FILES / "right" / "multi.bin", *DUMPS["multi.bin"]]
    assert params(*multi, "--out", "own.bin").returncode == 0
    done = params(*multi, "--diff", "own.bin")
    assert (done.returncode, done.stdout) == (0, "no differences\n"), done.stderr
    assert "--offset applies only to dumps" in params(FILES / "right" / "loops.json", "--offset", "4").stderr


SLIP = "DATA_BLOCK DB 41 FB 41 BEGIN GAIN := 3.0; END_DATA_BLOCK DATA_BLOCK DB 42 FB 41 BEGIN GAIN := T#3S; END_DATA_BLOCK"


def test_a_loop_that_cannot_be_read_does_not_cost_the_others(params, tmp_path):
    (tmp_path / "plant.awl").write_text(SLIP)
    done = params("plant.awl", "--json")
    assert done.returncode == 3
    assert list(json.loads(done.stdout)) == ["DB41"]
    assert "error: plant.awl:1:95: GAIN: expected a REAL" in done.stderr


def test_the_files_of_a_folder_are_read_together(params, tmp_path):
    folder = tmp_path / "export"
    folder.mkdir()
    (folder / "a.awl").write_text(SLIP.split("DATA_BLOCK DB 42")[0])
    (folder / "b.xml").write_bytes((FILES / "right" / "openness.xml").read_bytes())
    # Openness exports more than instance data blocks.
    (folder / "c.xml").write_text('<?xml version="1.0"?><Document><SW.Tags.PlcTagTable ID="0"/></Document>')
    (folder / "d.txt").write_text("notes")
    done = params("export", FILES / "right" / "by_hand.scl", "--json")
    assert done.returncode == 0, done.stderr
    assert {"DB41", *RIGHT["openness.xml"], *RIGHT["by_hand.scl"]} == set(json.loads(done.stdout))
    (line,) = [line for line in done.stderr.splitlines() if "c.xml" in line]
    assert line.startswith("remark: export") and line.endswith("found none (skipped)")
    (tmp_path / "empty").mkdir()
    assert "error: empty has no parameter files" in params("empty").stderr


def test_standard_input_is_a_file(command):
    given = [command, "params", "-", "--format", "json", "--json"]
    done = subprocess.run(given, input='{"A": {"GAIN": 3.0, "LMN_HLM": 90.0}}', capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["A"]["GAIN"] == 3.0


def test_characters_that_a_terminal_takes_for_orders_are_shown(params, tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({"\x1b[31mred": {"GAIN": 3.0, "MAN_ON": True, "LMN_HLM": 90.0}}))
    done = params("a.json")
    assert done.returncode == 0
    assert "\x1b" not in done.stdout + done.stderr
    assert "\\u{1b}[31mred" in done.stdout


def test_what_is_to_be_said_of_many_loops_is_said_once(params, tmp_path):
    loops = {f"P{number}": {"GAIN": 3.0, "LMN_HLM": 90.0, "TD": 1.0} for number in range(40)}
    (tmp_path / "a.json").write_text(json.dumps(loops))
    lines = params("a.json").stderr.splitlines()
    assert len(lines) == len(set(lines)) < 10
    assert any(line.startswith("warning: P0, P1, P2 and 37 more: MAN_ON is TRUE") for line in lines), lines


@pytest.mark.parametrize("value", ["1e-50", "-1e-60"])
def test_a_value_too_small_for_its_type_is_refused(params, tmp_path, value):
    (tmp_path / "a.json").write_text(f'{{"A": {{"GAIN": {value}, "LMN_HLM": 90.0}}}}')
    assert "a REAL accepts 0 and magnitudes of at least 1.4e-45" in params("a.json").stderr
    (tmp_path / "b.json").write_text('{"A": {"TI": 0.0004, "LMN_HLM": 90.0}}')
    assert "a TIME is a whole number of milliseconds" in params("b.json").stderr
