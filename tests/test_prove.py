"""`plcfmu prove`: the source that it writes, and what it says of a result. What the source finds is tested in
`laws/tests/prove.rs`."""

import re
import struct
import subprocess

import pytest


@pytest.fixture
def prove(command):
    def prove(*arguments):
        return subprocess.run([command, "prove", *map(str, arguments)], capture_output=True, text=True)

    return prove


@pytest.fixture
def source(prove, tmp_path):
    """A source of 300 calls; gives the start values of its result by name, and the names of its data blocks."""
    path = tmp_path / "prove.scl"
    done = prove("CONT_C", "--calls", 300, "--out", path)
    assert done.returncode == 0, done.stderr
    assert "cycles   300: 3 s at a cycle time of 10 ms" in done.stdout
    assert 'call     "PROVE_CONT_C_DB"(); once per cycle' in done.stdout
    text = path.read_text()
    starts = dict(re.findall(r"^    (magic|layout|seed|tape|calls) := (?:DW#16#)?(\w+);$", text, re.M))
    return text, starts


def result(starts, state, done=0, output=0, expected=0, found=0):
    """The bytes of the result's data block."""
    hexadecimal = [int(starts[name], 16) for name in ("magic", "seed", "tape")]
    return struct.pack(
        ">IhhIIiihhII",
        hexadecimal[0],
        int(starts["layout"]),
        state,
        *hexadecimal[1:],
        int(starts["calls"]),
        done,
        output,
        0,
        expected,
        found,
    )


def test_the_source_calls_the_block_of_the_plc_and_says_how_to_run_it(source):
    text, starts = source
    assert "tested {InstructionName := 'CONT_C'; LibVersion := '1.1'} : CONT_C;" in text
    assert 'once per cycle: "PROVE_CONT_C_DB"();' in text
    assert (starts["magic"], starts["calls"]) == ("504C4346", "300")


@pytest.mark.parametrize(
    ("state", "more", "code", "says"),
    [
        (1, {"done": 300}, 0, "CONT_C: 300 calls, 0 differ\n"),
        (0, {"done": 120}, 1, "CONT_C: 120 of 300 calls, 0 differ so far; the proof is still running\n"),
        (
            2,
            {"done": 17, "output": 1, "expected": 0x41480000, "found": 0x41480001},
            1,
            "CONT_C: call 17 of 300 differs: LMN is 12.500001 (16#41480001), expected 12.5 (16#41480000)\n",
        ),
    ],
)
def test_a_result_is_told_in_words(prove, source, tmp_path, state, more, code, says):
    path = tmp_path / "result.bin"
    path.write_bytes(result(source[1], state, **more))
    done = prove("--read", path)
    assert (done.returncode, done.stdout.splitlines(keepends=True)[0]) == (code, says)
    assert ("  GAIN " in done.stdout) == (state == 2)


def test_what_is_no_result_cannot_be_read(prove, tmp_path):
    path = tmp_path / "result.bin"
    path.write_bytes(b"\0" * 36)
    done = prove("--read", path)
    assert done.returncode == 3 and "PLCF" in done.stderr
    path.write_bytes(b"PLCF")
    done = prove("--read", path)
    assert done.returncode == 3 and "it has 4 bytes; a proof result has 36" in done.stderr
    assert prove("--read", tmp_path / "none.bin").returncode == 3


def test_a_block_without_a_number_in_step_7_is_named_by_the_user(prove, tmp_path):
    path = tmp_path / "prove.scl"
    done = prove("HLG", "--calls", 50, "--dialect", "step7", "--out", path)
    assert done.returncode == 1 and "--block FB200" in done.stderr and not path.exists()
    done = prove("HLG", "--calls", 50, "--dialect", "step7", "--block", "FB200", "--number", 50, "--out", path)
    assert done.returncode == 0 and "call     FB50.DB50();" in done.stdout and "result   DB51" in done.stdout
    assert "tested : FB200;" in path.read_text()
    assert prove("PUMP", "--out", path).returncode == 2
