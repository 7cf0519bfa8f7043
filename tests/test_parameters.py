"""A plant's parameters: forty loops of one STEP 7 source text, which `forty_loops.py` makes up, through `plcfmu params` and the
Python package; and what awlsim, a program of others that runs STEP 7 sources, reads from the same text."""

import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys

import pytest

import forty_loops
import host
import plcfmu

# Of the packages on PyPI, awlsim has no wheel: whoever wants this comparison installs it (tests/README.md).
AWLSIM = os.environ.get("PLCFMU_AWLSIM") or shutil.which(
    "awlsim-test", path=os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ.get("PATH", "")])
)


@pytest.fixture
def params(command):
    def params(*arguments):
        done = subprocess.run([command, "params", *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return params


def bits(values):
    """Values that are equal if they are the same bit for bit."""
    return {name: value.hex() if isinstance(value, float) else value for name, value in values.items()}


@pytest.fixture(scope="module")
def start_values(command):
    """The start values of a block, as its FMU has them."""
    known = {}

    def start_values(block):
        if block not in known:
            file = plcfmu.fmu(block, host.FOLDER)
            done = subprocess.run([command, "params", file, "--json"], capture_output=True, text=True, check=True)
            (known[block],) = json.loads(done.stdout).values()
        return known[block]

    return start_values


def as_real(values):
    """JSON has the shortest decimal of a REAL: the REAL itself is compared."""
    return {
        name: struct.unpack("f", struct.pack("f", value))[0] if isinstance(value, float) else value
        for name, value in values.items()
    }


def test_the_file_is_what_its_program_writes():
    assert forty_loops.FILE.read_bytes().decode() == forty_loops.source(), "run python tests/forty_loops.py"


def test_forty_loops_have_the_values_of_the_file_and_else_the_start_values_of_their_block(params, start_values):
    loops = json.loads(params(forty_loops.FILE, "--json"))
    expected = forty_loops.by_name()
    assert list(loops) == list(expected)
    assert len(loops) == 40
    for name, loop in expected.items():
        values = {**start_values(loop.block), **loop.values}
        times = {member for member, kind in loop.inputs if kind == "TIME"}
        read = {key: value if key in times else as_real({key: value})[key] for key, value in loops[name].items()}
        assert bits(read) == bits(values), name


def test_the_origin_of_a_value_is_its_line_of_the_file(params):
    rows = [line.split() for line in params(forty_loops.FILE).splitlines()[1:]]
    lines = forty_loops.FILE.read_text(encoding="utf-8").splitlines()
    places = [(row[2], row[-1]) for row in rows if forty_loops.FILE.name in row[-1]]
    assert len(places) == sum(len(loop.values) for loop in forty_loops.loops())
    for member, origin in places:
        _, line, column = origin.rsplit(":", 2)
        text = lines[int(line) - 1]
        literal = text.split(":= ")[1].split(";")[0]
        assert f"{member} := " in text
        assert text[int(column) - 1 :].startswith((literal, member, f"{text.split()[0]}")), origin


@pytest.mark.parametrize("ending", ["json", "ssv", "db"])
def test_the_file_comes_back_bit_equal_from_another_format(params, tmp_path, ending):
    other, back = tmp_path / f"plant.{ending}", tmp_path / "back.awl"
    before = params(forty_loops.FILE, "--json")
    params(forty_loops.FILE, "--out", other)
    params(other, "--out", back)
    assert params(back, "--json") == before
    assert params(forty_loops.FILE, "--diff", back) == "no differences\n"


def test_a_loop_of_the_file_starts_as_an_fmu_with_its_values(command, monkeypatch):
    monkeypatch.setenv("PLCFMU_COMMAND", str(command))
    loops = plcfmu.params(forty_loops.FILE)
    with plcfmu.Fmus(host.FOLDER) as fmus:
        for name, loop in forty_loops.by_name().items():
            instance = fmus.start(loop.block, loops[name], name=name)
            assert bits(instance.get(loop.values)) == bits(loop.values)


# awlsim


def data_blocks():
    """A source text with the loops that awlsim can read."""
    lines = []
    for loop in complete():
        lines += [f"DATA_BLOCK DB {loop.number}", f"TITLE ={loop.name}", loop.type()]
        lines += ["BEGIN", *forty_loops.assignments(loop), "END_DATA_BLOCK"]
    return "\r\n".join(lines)


def program(data_blocks, checks):
    """Data blocks, what declares their members, and a program that compares them with bytes."""
    lines = []
    for kind, inputs, outputs in forty_loops.BLOCKS.values():
        lines.append(f"FUNCTION_BLOCK {kind}")
        for section, members in (("VAR_INPUT", inputs), ("VAR_OUTPUT", outputs)):
            lines += [section, *(f"  {member.replace(':', ' : ')};" for member in members.split()), "END_VAR"]
        lines += ["BEGIN", "END_FUNCTION_BLOCK"]
    lines += [data_blocks, "ORGANIZATION_BLOCK OB 1", "BEGIN"]
    for loop in complete():
        if loop.number in checks:
            lines += [f"OPN DB {loop.number}", *comparisons(loop, checks[loop.number])]
    return "\r\n".join([*lines, "CALL SFC 46", "END_ORGANIZATION_BLOCK", ""])


def comparisons(loop, data):
    """Compares each word of the data block with these bytes. Of a TIME awlsim may lose a millisecond: it adds up seconds as
    floating point numbers, and cuts off (T#1M49S528MS is 109527 ms there)."""
    times = {address for address, kind in addresses(loop) if kind == "TIME"}
    place = 0
    while place < len(data):
        if place in times:
            (milliseconds,) = struct.unpack_from(">i", data, place)
            yield f"L DBD {place}"
            yield f"__ASSERT<= __ACCU 1, L#{milliseconds}"
            yield f"__ASSERT>= __ACCU 1, L#{milliseconds - 1}"
        else:
            yield f"L DBW {place}"
            yield f"__ASSERT== __ACCU 1, W#16#{data[place : place + 2].hex()}"
        place += 4 if place in times else 2


def addresses(loop):
    """The byte and the type of each input: BOOLs share a byte, everything else and the first BOOL after it begin at an even one."""
    byte = bit = 0
    for _, kind in loop.inputs:
        if kind == "BOOL":
            yield byte + bit // 8, kind
            bit += 1
        else:
            byte, bit = byte + (bit + 15) // 16 * 2, 0
            yield byte, kind
            byte += 2 if kind == "WORD" else 4


def complete():
    """Loops with a data block of their own in which all members are set: awlsim knows no multi-instances' values."""
    return [loop for loop in forty_loops.loops() if loop.number != 300 and len(loop.values) == len(loop.inputs)]


@pytest.fixture
def awlsim(tmp_path):
    """Runs a source text."""

    def awlsim(text):
        file = tmp_path / "program.awl"
        file.write_text(text, encoding="utf-8")
        run = [AWLSIM, "--no-cpu-dump", "--extended-insns", "--loglevel", "1", "--max-runtime", "60", file]
        return subprocess.run(run, capture_output=True, text=True)

    return awlsim


@pytest.mark.skipif(AWLSIM is None, reason="awlsim is not installed (tests/README.md)")
def test_awlsim_reads_the_same_bytes_from_the_same_text_and_from_the_one_that_is_written(params, awlsim, tmp_path):
    loops = complete()
    assert len(loops) == 26
    file, written = tmp_path / "loops.awl", tmp_path / "written.awl"
    file.write_text(data_blocks(), encoding="utf-8")
    params(file, "--out", written)
    checks = {}
    for loop in loops:
        dump = tmp_path / f"{loop.name}.bin"
        params(file, "--loop", f"DB{loop.number}", "--out", dump)
        checks[loop.number] = dump.read_bytes()
    for text in (file, written):
        done = awlsim(program(text.read_text(encoding="utf-8"), checks))
        assert done.returncode == 0, f"{text.name}: {done.stderr}"

    # It does notice a word that is another.
    last = loops[-1].number
    checks[last] = bytes([checks[last][0] ^ 1, *checks[last][1:]])
    done = awlsim(program(data_blocks(), checks))
    assert done.returncode != 0
    assert "Assertion failed" in done.stderr
