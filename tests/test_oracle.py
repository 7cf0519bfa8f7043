"""The second version of the laws, held to the recordings in `traces/`, to the last bit; its machine and its interface.

`oracle.py` judges the library, so something must judge `oracle.py`. Its laws are held to numbers that can be checked by
hand in `test_tapes.py`.
"""

import pathlib
import random

import numpy as np
import pytest

import oracle
from files import rows
from oracle import CONT_C, CONT_S

TRACES = sorted((pathlib.Path(__file__).parent / "traces").glob("*.csv"))


def assign(block, values):
    for name, value in values.items():
        block.set(name, value)


# --- The recordings -------------------------------------------------------------------------


def bits(value):
    """What two REALs must share to be the same, a zero's sign included."""
    return int(np.float32(value).view(np.int32))


def is_recorded(value, text):
    if isinstance(value, np.float32):
        return bits(value) == bits(float(text))
    return value == int(text)


def test_both_measured_blocks_have_recordings():
    assert {trace.name[:6] for trace in TRACES} == {"CONT_C", "CONT_S"}


@pytest.mark.parametrize("trace", TRACES, ids=lambda trace: trace.stem)
def test_the_oracle_repeats_the_recording_bit_for_bit(trace):
    block = getattr(oracle, trace.name[:6])()
    recorded = rows(trace)
    assert recorded
    differences = []
    for row in recorded:
        for column, text in row.items():
            if column.startswith("in_"):
                block.set(column[len("in_"):], float(text))
        block.call()
        for column, text in row.items():
            if column.startswith("out_"):
                value = block.get(column[len("out_"):])
                if not is_recorded(value, text):
                    differences.append((row["call"], column, text, value))
    assert differences == []


# --- The machine ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value, integer",
    [(0.5, 0), (1.5, 2), (2.5, 2), (-0.5, 0), (-1.5, -2), (-2147483648.0, -2147483648)],
)
def test_rounding_takes_halves_to_the_even_neighbour(value, integer):
    assert oracle.rnd(np.float32(value)) == integer


@pytest.mark.parametrize("value, pattern", [(2.0**31, 0x4F000000), (float("inf"), 0x7F800000)])
def test_rounding_leaves_the_bits_of_what_does_not_fit(value, pattern):
    assert oracle.rnd(np.float32(value)) == pattern


def test_rounding_nan_gives_all_ones():
    assert oracle.low_word(oracle.rnd(np.float32("nan"))) == -1


@pytest.mark.parametrize("value, word", [(32767, 32767), (32768, -32768), (65535, -1), (-1, -1)])
def test_a_word_is_twos_complement(value, word):
    block = CONT_C()
    block.set("PV_PER", value)
    assert block.get("PV_PER") == word


@pytest.mark.parametrize("block_type", oracle.BLOCKS.values())
def test_everything_is_zero_before_the_first_call(block_type):
    block = block_type()
    assert all(block.get(name) == 0 for name in block.OUTPUTS)


def test_an_unknown_terminal_is_named():
    with pytest.raises(KeyError, match="CONT_C has no terminal LMN_HIM"):
        CONT_C().set("LMN_HIM", 90.0)


def test_an_output_cannot_be_set():
    with pytest.raises(KeyError, match="LMN is an output of CONT_C"):
        CONT_C().set("LMN", 1.0)


def random_cont_c_inputs(random_numbers):
    switches = "MAN_ON PVPER_ON P_SEL I_SEL INT_HOLD I_ITL_ON D_SEL".split()
    signals = "SP_INT PV_IN MAN I_ITLVAL DISV".split()
    return {
        **{name: random_numbers.random() < 0.5 for name in switches},
        **{name: random_numbers.uniform(-120, 120) for name in signals},
        "PV_PER": random_numbers.randint(-32768, 32767),
    }


def random_cont_s_inputs(random_numbers):
    switches = "LMNR_HS LMNR_LS LMNS_ON LMNUP LMNDN".split()
    return {
        **{name: random_numbers.random() < 0.2 for name in switches},
        "SP_INT": random_numbers.uniform(-60, 60),
        "DISV": random_numbers.uniform(-20, 20),
    }


@pytest.mark.parametrize(
    "block_type, random_inputs",
    [(CONT_C, random_cont_c_inputs), (CONT_S, random_cont_s_inputs)],
    ids=["CONT_C", "CONT_S"],
)
def test_every_real_stays_binary32(block_type, random_inputs):
    random_numbers = random.Random(41)
    block = block_type()
    block.restart()
    reals = {name for name, value in vars(block).items() if isinstance(value, np.float32)}
    for _ in range(300):
        assign(block, random_inputs(random_numbers))
        block.call()
        assert {n for n, value in vars(block).items() if isinstance(value, np.float32)} == reals
        assert not any(isinstance(value, (float, np.float64)) for value in vars(block).values())
