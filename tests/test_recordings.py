"""What the replay says of tests/recordings, which recordings.py makes: loops whose controller has other settings than its file."""

import json

import host
import pytest
import recordings
import tool

# What a recording cannot tell, with other values that do the same calls: a shortest pulse is known only as far as pulses come near it, and
# pulses that are rounded to three decimals do not tell it from the period.
UNTOLD = [
    (("chamber", {"DI_PULSEGEN.P_B_TM": 0.04}, "run", None), {"DI_PULSEGEN.P_B_TM": 0.05}),
    (("pulses", {"P_B_TM": 0.4}, "page", 3), {"PER_TM": 0.6}),
]


@pytest.fixture(scope="module")
def server(command, tmp_path_factory):
    with tool.Server(command, tmp_path_factory.mktemp("replay"), "--fmus", host.FOLDER) as server:
        yield server


def replayed(server, of, **own):
    """What the replay of a recording says of the loop's file, with other settings in it."""
    loop, *_ = of
    controller, *_ = recordings.LOOPS[loop]
    text = (recordings.FOLDER / recordings.file_name(*of)).read_text()
    member = {"name": controller, "fmu": controller, "values": recordings.settings(loop) | own}
    request = {"do": "replay", "text": text, "columns": [], "try_suspects": True, "controller": member}
    return json.loads(server.ask(request, "replay"))["ok"]


@pytest.mark.parametrize("of", recordings.RECORDINGS, ids=lambda of: recordings.file_name(*of).removesuffix(".csv"))
def test_what_is_wrong_is_named_and_nothing_else(server, of):
    _, wrong, *_ = of
    told = replayed(server, of)
    if not wrong:
        assert told["conclusion"] == "equal" and not told["suspects"], told["suspects"]
        return
    if of in [untold for untold, _ in UNTOLD]:
        assert told["conclusion"] in ("ambiguous", "unexplained"), told["suspects"]
        return
    assert told["conclusion"] in ("cause", "likely_cause"), told["suspects"]
    values = told["suspects"][0]["values"]
    assert values.keys() == wrong.keys(), told["suspects"]
    for name, value in wrong.items():
        assert values[name] == pytest.approx(value, rel=0.005), told["suspects"]


@pytest.mark.parametrize(("of", "other"), UNTOLD, ids=lambda of: None if isinstance(of, dict) else of[0])
def test_what_is_not_told_has_another_explanation_that_does_the_same_calls(server, of, other):
    _, wrong, *_ = of
    assert wrong != other
    for settings in (wrong, other):
        assert replayed(server, of, **settings)["conclusion"] == "equal"


def test_at_least_40_recordings_of_all_blocks_are_judged_and_nine_of_ten_are_told():
    assert len(recordings.RECORDINGS) >= 40 and len(UNTOLD) / len(recordings.RECORDINGS) < 1 / 10
    assert {recordings.LOOPS[loop][0] for loop, *_ in recordings.RECORDINGS} == {"CONT_C", "CONT_S", "PULSEGEN", "PULS_CTR", "HLG"}
    files = {path.name for path in recordings.FOLDER.iterdir()}
    assert files == {recordings.file_name(*of) for of in recordings.RECORDINGS}
