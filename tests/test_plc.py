"""`plcfmu params s7://...`: a data block read from the server of python-snap7, which answers as a PLC does, on this machine."""

import json
import socket
import struct
import subprocess

import pytest

snap7 = pytest.importorskip("snap7", reason="python-snap7 is not installed (tests/requirements.txt; Python 3.10 or newer)")

# An instance of CONT_C up to its memory, 100 bytes, which the block's memory follows.
LENGTH, MEMORY = 100, 26


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def instance():
    """The bytes of an instance with GAIN = 2.5, TI = 12.345 s, CYCLE = 0.1 s, LMN_HLM = 95, PV_PER = -1, P_SEL and I_SEL."""
    data = bytearray(LENGTH + MEMORY)
    data[0] = 1 << 3 | 1 << 4
    for address, value in ((2, 100), (24, 12_345)):
        struct.pack_into(">i", data, address, value)
    for address, value in ((20, 2.5), (40, 95.0)):
        struct.pack_into(">f", data, address, value)
    struct.pack_into(">h", data, 14, -1)
    # The memory behind is none of ours.
    data[LENGTH:] = b"\xff" * MEMORY
    return data


@pytest.fixture
def plc():
    """A server with DB41, an instance; DB42, one in the middle of a multi-instance; and DB7, which is short. Gives its port."""
    from snap7.server import Server
    from snap7.type import SrvArea

    server = Server(log=False)
    blocks = {41: instance(), 42: bytearray(200) + instance(), 7: bytearray(99)}
    for number, data in blocks.items():
        server.register_area(SrvArea.DB, number, data)
    port = free_port()
    server.start(tcp_port=port)
    before = {number: bytes(data) for number, data in blocks.items()}
    yield port
    server.stop()
    server.destroy()
    assert {number: bytes(data) for number, data in blocks.items()} == before, "something was written to the PLC"


@pytest.fixture
def params(command):
    def params(*arguments):
        return subprocess.run([command, "params", *map(str, arguments)], capture_output=True, text=True)

    return params


def refusal(done):
    assert done.returncode == 1
    assert done.stdout == ""
    return done.stderr.splitlines()[-1].removeprefix("error: ")


def test_a_data_block_is_read_from_the_plc(params, plc):
    done = params(f"s7://127.0.0.1:{plc}/0/2/DB41", "--block", "CONT_C", "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines()[0] == "reading DB41 of 127.0.0.1"
    loops = json.loads(done.stdout)
    assert list(loops) == ["DB41"]
    values = loops["DB41"]
    expected = {"GAIN": 2.5, "TI": 12.345, "CYCLE": 0.1, "LMN_HLM": 95.0, "PV_PER": -1, "P_SEL": True, "MAN_ON": False}
    assert {name: values[name] for name in expected} == expected


def test_an_instance_in_a_data_block_begins_at_the_offset(params, plc):
    done = params(f"s7://127.0.0.1:{plc}/0/2/DB42", "--block", "FB 41", "--offset", 200, "--loop", "TIC102")
    assert done.returncode == 0, done.stderr
    (row,) = (line.split() for line in done.stdout.splitlines() if line.split()[2] == "GAIN")
    assert row[:4] == ["TIC102", "CONT_C", "GAIN", "2.5"]
    assert row[-1].endswith("220"), "the origin is the address in the data block"


def test_what_was_read_becomes_a_source_text(params, plc, tmp_path):
    address = f"s7://127.0.0.1:{plc}/0/2/DB41"
    text = tmp_path / "db41.awl"
    assert params(address, "--block", "CONT_C", "--out", text).returncode == 0
    again = params(text, "--json", "--loop", "DB41")
    assert again.returncode == 0, again.stderr
    assert json.loads(again.stdout) == json.loads(params(address, "--block", "CONT_C", "--json").stdout)


@pytest.mark.parametrize(
    ("place", "arguments", "sentence"),
    [
        ("0/2/DB5", ["--block=CONT_C"], "no DB5 in the PLC, or it is an optimized data block"),
        ("0/2/DB7", ["--block=CONT_C"], "DB7 is shorter than 100 bytes, so it is not an instance of this block"),
        ("0/2/DB41", ["--block=CONT_C", "--offset=30"], "DB41 is shorter than 130 bytes"),
        ("0/2/DB41", [], "a PLC does not state which block a data block belongs to: specify it with --block (available: "),
        ("0/2/DB41", ["--block=PUMP"], 'no block is called "PUMP"; available: '),
        ("0/2/TIC101", ["--block=CONT_C"], '"TIC101" is not a data block such as DB41'),
    ],
)
def test_a_data_block_that_cannot_be_read_is_refused(params, plc, place, arguments, sentence):
    assert sentence in refusal(params(f"s7://127.0.0.1:{plc}/{place}", *arguments))


def test_a_host_without_a_plc_is_said(params):
    done = params(f"s7://127.0.0.1:{free_port()}/0/2/DB41", "--block=CONT_C")
    assert "127.0.0.1 refuses connections to port" in refusal(done)


def test_a_plc_is_never_written_to(params, plc, tmp_path):
    file = tmp_path / "one.json"
    file.write_text('{"GAIN": 3.0}', encoding="utf-8")
    done = params(file, "--block=CONT_C", "--out", f"s7://127.0.0.1:{plc}/0/2/DB41")
    assert "plcfmu never writes to a PLC: write a source, such as" in refusal(done)
