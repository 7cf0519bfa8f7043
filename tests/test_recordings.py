"""What the replay says of tests/recordings, which recordings.py makes: loops whose controller has other settings than its file."""

import json

import host
import pytest
import recordings
import tool

# What a recording cannot tell: pulses alone do not tell a period from a shortest pulse, nor all of two settings of a step controller; a
# manipulated value at its limit hides what a controller does.
UNTOLD = [
    ("furnace", {"GAIN": 0.5, "TI": 60.0}, "clock", None),
    ("process", {"GAIN": 3.0, "TI": 12.0}, "run", 3),
    ("valve", {"GAIN": 1.8, "TI": 9.0}, "run", None),
    ("valve", {"BREAK_TM": 0.5}, "run", None),
    ("chamber", {"DI_PULSEGEN.P_B_TM": 0.04}, "run", None),
    ("pulses", {"PER_TM": 3.0}, "run", None),
    ("pulses", {"P_B_TM": 0.4}, "page", 3),
]


@pytest.fixture(scope="module")
def server(command, tmp_path_factory):
    with tool.Server(command, tmp_path_factory.mktemp("replay"), "--fmus", host.FOLDER) as server:
        yield server


def replayed(server, loop, wrong, way, decimals):
    controller, *_ = recordings.LOOPS[loop]
    text = (recordings.FOLDER / recordings.file_name(loop, wrong, way, decimals)).read_text()
    member = {"name": controller, "fmu": controller, "values": recordings.settings(loop)}
    request = {"do": "replay", "text": text, "columns": [], "try_suspects": True, "controller": member}
    return json.loads(server.ask(request, "replay"))["ok"]


@pytest.mark.parametrize("of", recordings.RECORDINGS, ids=lambda of: recordings.file_name(*of).removesuffix(".csv"))
def test_what_is_wrong_is_named_and_nothing_else(server, of):
    _, wrong, *_ = of
    told = replayed(server, *of)
    if not wrong:
        assert told["conclusion"] == "equal" and not told["suspects"], told["suspects"]
        return
    if of in UNTOLD:
        assert told["conclusion"] in ("ambiguous", "unexplained"), told["suspects"]
        return
    assert told["conclusion"] in ("cause", "likely_cause"), told["suspects"]
    values = told["suspects"][0]["values"]
    assert values.keys() == wrong.keys(), told["suspects"]
    for name, value in wrong.items():
        assert values[name] == pytest.approx(value, rel=0.005), told["suspects"]


def test_at_least_40_recordings_of_all_blocks_are_judged_and_five_of_six_are_told():
    assert len(recordings.RECORDINGS) >= 40 and len(UNTOLD) / len(recordings.RECORDINGS) < 1 / 6
    assert {recordings.LOOPS[loop][0] for loop, *_ in recordings.RECORDINGS} == {"CONT_C", "CONT_S", "PULSEGEN", "PULS_CTR", "HLG"}
    files = {path.name for path in recordings.FOLDER.iterdir()}
    assert files == {recordings.file_name(*of) for of in recordings.RECORDINGS}
