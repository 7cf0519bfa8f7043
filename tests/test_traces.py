"""The recordings in traces/, replayed through the FMUs: every output of every call, bit for bit.

Row 0 of a recording is the restart call: the values set before initialization ends, and the outputs
after it. Times are in milliseconds there.
"""

import pathlib

import numpy as np
import pytest

import host
from files import rows

TRACES = sorted((pathlib.Path(__file__).parent / "traces").glob("*.csv"))


def values(fmu, row):
    """What a row has at the inputs, as FMI has it."""
    found = {}
    for column, text in row.items():
        if column.startswith("in_"):
            name = column[len("in_") :]
            scale = 1000 if fmu.kinds[name] == "TIME" else 1
            found[name] = float(text) / scale if fmu.variables[name].type == "Real" else int(text)
    return found


def bits(number):
    return int(np.float32(number).view(np.int32))


def differences(instance, row):
    found = []
    for column, text in row.items():
        if column.startswith("out_"):
            name = column[len("out_") :]
            value = instance[name]
            real = instance.fmu.variables[name].type == "Real"
            if (bits(value) != bits(float(text))) if real else (value != int(text)):
                found.append(f"call {row['call']}: {name} = {value!r}, recorded {text}")
    return found


def test_both_measured_blocks_have_recordings_and_all_are_replayed():
    assert {trace.name[:6] for trace in TRACES} == {"CONT_C", "CONT_S"}
    calls = sum(len(rows(trace)) for trace in TRACES)
    assert calls > 700
    for page in ("README.md", "tests/README.md"):
        text = (TRACES[0].parents[2] / page).read_text("utf-8")
        assert f"| {calls} recorded calls, every bit" in text or f"recorded calls of real blocks, replayed | {calls} |" in text, calls


@pytest.mark.parametrize("version", host.versions([""]))
@pytest.mark.parametrize("trace", TRACES, ids=lambda trace: trace.stem)
def test_the_fmu_repeats_the_recording_bit_for_bit(trace, version, open_fmu):
    fmu = open_fmu(version + trace.name[:6])
    first, *rest = rows(trace)
    instance = fmu.instance()
    instance.start(**values(fmu, first))
    found = differences(instance, first)
    cycle = instance.cycle
    for row in rest:
        now = values(fmu, row)
        assert now.pop("CYCLE") == cycle
        instance.step(cycle, **now)
        found += differences(instance, row)
    assert found == []
