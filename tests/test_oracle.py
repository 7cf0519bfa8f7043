"""The second text of the laws, held to recordings and to numbers that can be checked by hand.

`oracle.py` judges the library, so something must judge `oracle.py`: the recordings in
`traces/`, to the last bit, and below them one example or bound for each rule.
"""

import csv
import pathlib
import random

import numpy as np
import pytest

import oracle
from oracle import CONT_C, CONT_S, HLG, PULS_CTR, PULSEGEN

TRACES = sorted((pathlib.Path(__file__).parent / "traces").glob("*.csv"))


def restarted(block_type, **values):
    """A block after its restart call, as an FMU starts it."""
    block = block_type()
    assign(block, values)
    block.set("COM_RST", True)
    block.call()
    block.set("COM_RST", False)
    return block


def assign(block, values):
    for name, value in values.items():
        block.set(name, value)


def calls(block, count, *outputs, **sequences):
    """`count` calls; the outputs after each. A sequence gives an input's value call by call."""
    rows = []
    for number in range(count):
        assign(block, {name: values[number] for name, values in sequences.items()})
        block.call()
        row = tuple(block.get(name) for name in outputs)
        rows.append(row[0] if len(outputs) == 1 else row)
    return rows


def real(*values):
    return [np.float32(value) for value in values]


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
    with trace.open(newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert rows
    differences = []
    for row in rows:
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


@pytest.mark.parametrize("block_type", [CONT_C, CONT_S, PULSEGEN, PULS_CTR, HLG])
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
    block = restarted(block_type)
    reals = {name for name, value in vars(block).items() if isinstance(value, np.float32)}
    for _ in range(300):
        assign(block, random_inputs(random_numbers))
        block.call()
        assert {n for n, value in vars(block).items() if isinstance(value, np.float32)} == reals
        assert not any(isinstance(value, (float, np.float64)) for value in vars(block).values())


# --- CONT_C ---------------------------------------------------------------------------------


def automatic(**values):
    return restarted(CONT_C, MAN_ON=False, **values)


def test_the_i_action_takes_half_a_step_in_its_first_call():
    rows = calls(automatic(SP_INT=1), 5, "LMN_I", "LMN_PER")
    assert [row[0] for row in rows] == real(0.05, 0.15, 0.25, 0.35, 0.45)
    assert [row[1] for row in rows] == [567, 594, 622, 650, 677]


@pytest.mark.parametrize(
    "tm_lag, lmn_d",
    [(2000, real(8, 4.8, 2.88, 1.7279997, 1.0367999)), (0, real(20, 0, 0))],
    ids=["lag 2 s", "no lag"],
)
def test_the_d_action_kicks_and_decays(tm_lag, lmn_d):
    block = automatic(SP_INT=1, I_SEL=False, D_SEL=True, TM_LAG=tm_lag)
    assert calls(block, len(lmn_d), "LMN_D") == lmn_d


@pytest.mark.parametrize("cycle, ti, e", [(1000, 20000, 2.0), (100, 7000, -3.0), (20, 500, 0.5)])
def test_the_i_action_follows_its_closed_form(cycle, ti, e):
    block = automatic(CYCLE=cycle, TI=ti, GAIN=1, SP_INT=e, I_ITLVAL=50)
    expected = [50 + cycle / ti * e * (k - 0.5) for k in range(1, 101)]
    assert calls(block, 100, "LMN_I") == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("cycle, td, lag", [(1000, 10000, 2000), (100, 3000, 700), (20, 40, 15)])
def test_the_d_action_follows_its_closed_form(cycle, td, lag):
    block = automatic(CYCLE=cycle, GAIN=1, SP_INT=3, I_SEL=False, D_SEL=True, TD=td, TM_LAG=lag)
    gain, decay = td / (cycle / 2 + lag), 1 - cycle / (cycle / 2 + lag)
    expected = [3 * gain * decay ** (k - 1) for k in range(1, 31)]
    assert calls(block, 30, "LMN_D") == pytest.approx(expected, rel=1e-4, abs=1e-5)


def test_small_steps_are_not_lost_on_a_large_integral():
    block = automatic(CYCLE=10, TI=3_600_000, GAIN=1, SP_INT=0.036, I_ITLVAL=50)
    assert calls(block, 100_000, "LMN_I")[-1] == np.float32(50.01)


def test_ti_of_zero_still_integrates():
    # TI counts as half a CYCLE: (T / Ti) * e * 1/2 = e in the first call, 2 e in each later one.
    assert calls(automatic(SP_INT=1, GAIN=1, TI=0), 3, "LMN_I") == real(1, 3, 5)


@pytest.mark.parametrize(
    "lmn, lmn_per",
    [(1, 276), (12.5, 3456), (50, 13824), (100, 27648), (118, 32625), (117.59, 32511)]
    + [(118.515, 32767), (118.52, -32768), (150, -24064), (1e9, -16644)],
)
def test_lmn_per_is_the_low_word_of_the_scaled_value(lmn, lmn_per):
    block = restarted(CONT_C, MAN=lmn, LMN_HLM=1e10, LMN_LLM=-1e10)
    assert calls(block, 1, "LMN_PER") == [lmn_per]


def test_lmn_per_of_nan_is_all_ones():
    assert calls(restarted(CONT_C, MAN=float("nan")), 1, "LMN_PER") == [-1]


@pytest.mark.parametrize(
    "pv_per, pv", [(27648, 100.0), (-27648, -100.0), (32767, 118.5149), (-32768, -118.51852)]
)
def test_a_peripheral_process_value_is_scaled(pv_per, pv):
    assert calls(restarted(CONT_C, PVPER_ON=True, PV_PER=pv_per), 1, "PV") == real(pv)


def test_pv_fac_and_pv_off_act_on_the_peripheral_value_only():
    block = restarted(CONT_C, PV_FAC=2, PV_OFF=5, PV_PER=13824, PV_IN=7)
    assert calls(block, 2, "PV", PVPER_ON=[True, False]) == real(105, 7)


@pytest.mark.parametrize("sp_int, er", [(-5, -3), (-2, 0), (1, 0), (2, 0), (5, 3)])
def test_the_dead_band_takes_its_width_from_the_error(sp_int, er):
    assert calls(restarted(CONT_C, DEADB_W=2, SP_INT=sp_int), 1, "ER") == real(er)


def test_the_integral_follows_the_manual_value_one_call_late():
    man = [40, 40, 50, 60, 60]
    rows = calls(restarted(CONT_C), 5, "LMN", "LMN_I", MAN=man)
    assert [row[0] for row in rows] == real(*man)
    assert [row[1] for row in rows] == real(0, 40, 40, 50, 60)


def test_the_integral_starts_from_i_itlval_after_a_restart():
    block = automatic(I_ITLVAL=30, SP_INT=1)
    assert block.get("LMN_I") == 0
    assert calls(block, 2, "LMN_I") == real(30.05, 30.15)


def test_a_manual_call_overwrites_i_itlval():
    block = restarted(CONT_C, I_ITLVAL=30)
    assert calls(block, 2, "LMN_I", MAN_ON=[True, False]) == real(0, 0)


def test_i_itlval_beyond_the_limits_is_clamped_after_a_restart():
    assert calls(automatic(I_ITLVAL=120), 1, "LMN_I") == real(100)


def test_an_integral_put_outside_by_i_itl_on_stays_free():
    block = automatic(I_ITLVAL=120)
    assert calls(block, 3, "LMN_I", I_ITL_ON=[True, False, False]) == real(120, 120, 120)


def test_the_clamp_takes_hold_again_once_the_integral_was_inside():
    # I falls by 10 a call from 115 (5 in the first) to 90, then DISV keeps LMN off its limit
    # while e turns to +10: 90, 100, and there the clamp holds it.
    block = automatic(I_ITLVAL=115, GAIN=1, TI=1000, P_SEL=False, DISV=-20)
    sequences = {
        "I_ITL_ON": [True] + 7 * [False],
        "SP_INT": [0, -10, -10, -10, 10, 10, 10, 10],
    }
    expected = real(115, 110, 100, 90, 90, 100, 100, 100)
    assert calls(block, 8, "LMN_I", **sequences) == expected


def test_an_integral_on_the_limit_counts_as_inside():
    # Put on 100 by I_ITL_ON, found inside in call 2; the 5 of call 3 meet the clamp.
    block = automatic(I_ITLVAL=100, GAIN=1, TI=1000, P_SEL=False, DISV=-20)
    sequences = {"I_ITL_ON": [True, False, False], "SP_INT": [0, 0, 10]}
    assert calls(block, 3, "LMN_I", **sequences) == real(100, 100, 100)


def test_the_clamp_asks_the_high_limit_first():
    assert calls(automatic(I_ITLVAL=30, LMN_HLM=10, LMN_LLM=50), 1, "LMN_I") == real(10)


def test_an_integral_outside_the_limits_keeps_no_rest():
    # A step of 10^-7 is too small for 120, and nothing adds the steps up.
    block = automatic(I_ITLVAL=120, CYCLE=10, TI=3_600_000, GAIN=1, SP_INT=0.036, DISV=-50)
    assert calls(block, 1000, "LMN_I", I_ITL_ON=[True] + 999 * [False])[-1] == 120


def test_i_sel_goes_before_i_itl_on():
    assert calls(automatic(I_SEL=False, I_ITL_ON=True, I_ITLVAL=30), 1, "LMN_I") == real(0)


def test_an_integral_put_outside_by_i_sel_stays_free():
    block = automatic(LMN_LLM=20)
    assert calls(block, 2, "LMN_I", I_SEL=[False, True]) == real(0, 0)


def test_i_itl_on_goes_before_manual_mode():
    assert calls(restarted(CONT_C, I_ITL_ON=True, I_ITLVAL=30), 2, "LMN_I") == real(30, 30)


@pytest.mark.parametrize("switch, off", [("D_SEL", False), ("MAN_ON", True)])
def test_the_d_action_is_matched_while_it_is_off(switch, off):
    block = automatic(SP_INT=3, D_SEL=True)
    assert calls(block, 3, "LMN_D", **{switch: [off, off, not off]}) == real(0, 0, 0)


def test_a_derivative_time_below_cycle_counts_as_cycle():
    # V = 1 / (0.5 + 2) = 0.4; D = 2 * 0.4, then (2 - 0.8) * 0.4.
    lmn_d = calls(automatic(SP_INT=1, D_SEL=True, TD=0), 2, "LMN_D")
    assert lmn_d == pytest.approx([0.8, 0.48])


def test_the_parts_are_added_one_after_the_other():
    # 2^24 + 1 rounds to 2^24, twice; 1 + 1 first would make it 2^24 + 2.
    block = automatic(SP_INT=2.0**24, GAIN=1, I_ITL_ON=True, I_ITLVAL=1, DISV=1, LMN_HLM=1e9)
    assert calls(block, 1, "LMN") == real(2.0**24)


def test_reaching_a_limit_reports_it():
    block = restarted(CONT_C)
    rows = calls(block, 4, "LMN", "QLMN_HLM", "QLMN_LLM", MAN=[100, 0, 50, 130])
    assert rows == [(100, True, False), (0, False, True), (50, False, False), (100, True, False)]


def test_the_integral_waits_at_the_limit_and_leaves_it_at_once():
    block = automatic(I_ITLVAL=80, TI=2000)
    lmn_i = calls(block, 6, "LMN_I", SP_INT=[6, 6, 6, 6, -1, -1])
    assert lmn_i == real(83, 89, 89, 89, 89, 88)


def test_int_hold_freezes_the_integral():
    block = automatic(SP_INT=1)
    assert calls(block, 3, "LMN_I", INT_HOLD=[False, True, False]) == real(0.05, 0.05, 0.15)


def test_lmn_is_normalized_after_the_limit():
    block = restarted(CONT_C, MAN=130, LMN_FAC=0.5, LMN_OFF=3)
    assert calls(block, 1, "LMN") == real(53)


def test_a_change_of_gain_kicks_the_d_action_once():
    # V = 10 / (0.5 + 0.5): after the product went from 1 to 2, D is 10 for one call.
    block = automatic(SP_INT=1, I_SEL=False, D_SEL=True, TM_LAG=500)
    assert calls(block, 4, "LMN_D", GAIN=[1, 1, 2, 2]) == real(10, 0, 10, 0)


# --- CONT_S ---------------------------------------------------------------------------------


def letters(block, count, **sequences):
    """U, D or a point for each call."""
    rows = calls(block, count, "QLMNUP", "QLMNDN", **sequences)
    return "".join("U" if up else "D" if down else "." for up, down in rows)


def during(first, last, count):
    """TRUE from call `first` to call `last` of `count`, counted from 1."""
    return [first <= number <= last for number in range(1, count + 1)]


@pytest.mark.parametrize(
    "sp_int, pattern",
    [
        (11, "UUUUUU......UUU.......UUU.......UUU.......UUU.......UUU....."),
        (-6, "DDD................DDD.................D"),
    ],
)
def test_a_constant_error_steps_the_valve(sp_int, pattern):
    assert letters(restarted(CONT_S, SP_INT=sp_int), len(pattern)) == pattern


def test_a_manual_pulse_lasts_pulse_tm_and_a_reversal_waits_for_break_tm():
    block = restarted(CONT_S, LMNS_ON=True)
    sequences = {"LMNUP": during(2, 2, 17), "LMNDN": during(4, 12, 17)}
    assert letters(block, 17, **sequences) == ".UUU...DDDDD....."


def test_a_stop_within_the_minimum_pulse_cuts_it_without_a_break():
    block = restarted(CONT_S, LMNS_ON=True)
    sequences = {"LMNUP": during(2, 16, 16), "LMNR_HS": during(3, 4, 16)}
    assert letters(block, 16, **sequences) == ".U..UUUUUUUUUUUU"


def test_a_stop_after_the_minimum_pulse_cuts_the_pulse_in_automatic():
    block = restarted(CONT_S, SP_INT=21)
    assert letters(block, 24, LMNR_HS=during(8, 12, 24)) == "UUUUUUU.....UUUUUUUU...U"


def test_a_stop_after_the_minimum_pulse_asks_for_the_break():
    block = restarted(CONT_S, LMNS_ON=True)
    sequences = {"LMNUP": during(2, 12, 12), "LMNR_HS": during(6, 6, 12)}
    assert letters(block, 12, **sequences) == ".UUUU...UUUU"


def test_a_stop_inside_the_minimum_pulse_lets_the_valve_turn_at_the_next_call():
    block = restarted(CONT_S, LMNS_ON=True)
    sequences = {
        "LMNUP": during(1, 2, 6),
        "LMNR_HS": during(2, 6, 6),
        "LMNDN": during(3, 6, 6),
    }
    assert letters(block, 6, **sequences) == "U.DDDD"


def test_both_manual_signals_together_are_none():
    assert letters(restarted(CONT_S, LMNS_ON=True, LMNUP=True, LMNDN=True), 3) == "..."


# Without I action, with a process value of 0, the switch-on threshold is the lowest one.
POSITION = dict(TI=0, GAIN=1, DEADB_W=0, PULSE_TM=0, BREAK_TM=0)


@pytest.mark.parametrize(
    "mtr_tm, e, letter",
    [(10_000, 10, "U"), (10_000, 9.99, "."), (10_000, -10, "D"), (10_000, -9.99, ".")]
    + [(5_000, 20, "U"), (5_000, 15, "."), (0, 120, "U"), (0, 99, ".")],
)
def test_the_lowest_threshold_is_the_travel_of_one_call(mtr_tm, e, letter):
    # 100 % * 1 s / MTR_TM: 10, 20 and, as the motor time is CYCLE at the least, 100.
    assert letters(restarted(CONT_S, SP_INT=e, MTR_TM=mtr_tm, **POSITION), 1) == letter


def test_the_lowest_threshold_is_the_travel_of_the_minimum_pulse():
    settings = {**POSITION, "PULSE_TM": 3000, "MTR_TM": 30000}
    assert letters(restarted(CONT_S, SP_INT=9.99, **settings), 1) == "."
    assert letters(restarted(CONT_S, SP_INT=10, **settings), 1) == "U"


@pytest.mark.parametrize("stop, letter", [(None, "."), ("LMNR_LS", "U"), ("LMNR_HS", ".")])
def test_a_reported_stop_lowers_the_threshold(stop, letter):
    # e = 30, half of it capped to 10, is the threshold; 1 at a stop. The output asks for 5.
    block = restarted(CONT_S, SP_INT=31, PV_IN=1, DISV=-25, MTR_TM=100_000, **POSITION)
    if stop:
        block.set(stop, True)
    assert letters(block, 1) == letter


def test_a_pulse_ends_when_55_percent_of_a_call_is_left():
    # One call moves 1 %: 3.55, 2.55, 1.55, and 0.55 is not above the threshold of 0.55.
    block = restarted(CONT_S, SP_INT=3, DISV=0.55, MTR_TM=100_000, **POSITION)
    assert letters(block, 5) == "UUU.."


def test_the_threshold_follows_the_smaller_of_error_and_integrator():
    # DISV drives the integrator to about 50, so the error of 2.1 decides. The first pulse ends
    # with 0.22 left (52.1 + 0.117 - 52); at 2.1 / 17.9 a call, 2.1 is reached 17 calls later.
    settings = dict(GAIN=1, DEADB_W=0, PULSE_TM=1000, BREAK_TM=1000, MTR_TM=100_000)
    pattern = letters(restarted(CONT_S, SP_INT=2.1, DISV=50, **settings), 70)
    assert pattern == 52 * "U" + 17 * "." + "U"


def test_a_reset_time_below_half_a_cycle_counts_as_half_a_cycle():
    # Te = 0.5 - 0.01 * 1 * 10 = 0.4, so the integrator falls by 2.5 a call: 1 + 4 * 2.5 > 10.
    settings = dict(GAIN=1, DEADB_W=0, TI=1, PULSE_TM=0, MTR_TM=10_000)
    assert letters(restarted(CONT_S, SP_INT=1, **settings), 4) == "...U"


def test_without_i_action_the_valve_drives_to_the_position_and_rests():
    settings = dict(TI=0, GAIN=1, DEADB_W=0, MTR_TM=10000, PULSE_TM=1000, BREAK_TM=1000)
    assert letters(restarted(CONT_S, SP_INT=40, **settings), 40) == "UUUU" + 36 * "."


FINE = dict(GAIN=1, DEADB_W=0, CYCLE=100, PULSE_TM=100, BREAK_TM=100, MTR_TM=30000, TI=20000)
# The travel of one call, in percent: 100 * 0.1 s / 30 s.
ONE_CALL = 1 / 3


def first_pulse_and_starts(pattern):
    starts = [k for k in range(1, len(pattern)) if pattern[k - 1 : k + 1] == ".U"]
    return len(pattern) - len(pattern.lstrip("U")), starts


@pytest.mark.parametrize("e, first, rate", [(1, 3, 0.05), (5, 15, 0.25), (20, 60, 1.0)])
def test_a_constant_error_moves_the_valve_at_e_over_ti(e, first, rate):
    pattern = letters(restarted(CONT_S, SP_INT=e, **FINE), 20_000)
    first_pulse, starts = first_pulse_and_starts(pattern)
    assert first_pulse == first
    travel = pattern[starts[0] : starts[-1]].count("U") * ONE_CALL
    # The count is of whole pulses, so the mean settles with the number of them: 190 at the least.
    assert len(starts) > 190
    assert travel / ((starts[-1] - starts[0]) * 0.1) == pytest.approx(rate, rel=2e-4)


@pytest.mark.parametrize("e, lag", [(1, 0.015), (5, 0.375), (20, 6.0)])
def test_the_valve_stays_behind_by_what_the_first_pulse_did_not_integrate(e, lag):
    # Within a call's travel, whenever a pulse ends; e (1 + t / TI) is the ideal PI controller.
    pattern = letters(restarted(CONT_S, SP_INT=e, **FINE), 5_000)
    ends = [k for k in range(1, len(pattern)) if pattern[k - 1 : k + 1] == "U."]
    behind = [e * (1 + k * 0.1 / 20) - pattern[:k].count("U") * ONE_CALL for k in ends]
    assert behind[0] == pytest.approx(lag)
    assert all(abs(value - lag) < ONE_CALL for value in behind)


def test_pulses_exclude_each_other_and_never_run_against_a_stop():
    random_numbers = random.Random(42)
    block = restarted(CONT_S, CYCLE=500, PULSE_TM=1000, BREAK_TM=0, DEADB_W=0)
    before = (False, False)
    seen = set()
    for _ in range(5_000):
        assign(block, random_cont_s_inputs(random_numbers))
        block.call()
        up, down = block.QLMNUP, block.QLMNDN
        seen.add((up, down))
        assert not (up and down)
        assert not (up and before[1]) and not (down and before[0])
        assert not (up and block.LMNR_HS) and not (down and block.LMNR_LS)
        before = (up, down)
    assert seen == {(False, False), (True, False), (False, True)}


# --- PULSEGEN -------------------------------------------------------------------------------

# Ten calls a period.
TEN_CALLS = dict(PER_TM=1000, CYCLE=100)
BIPOLAR = dict(STEP3_ON=False, ST2BI_ON=True)
MONOPOLAR = dict(STEP3_ON=False, ST2BI_ON=False)


def pulses(block, count, **sequences):
    """+ for QPOS_P, - for QNEG_P, a point for neither."""
    rows = calls(block, count, "QPOS_P", "QNEG_P", **sequences)
    assert (True, True) not in rows
    return "".join("+" if positive else "-" if negative else "." for positive, negative in rows)


def signed_pulse_calls(inv, **settings):
    """Pulse calls of one three-step period, negative for QNEG_P."""
    pattern = pulses(restarted(PULSEGEN, INV=inv, **TEN_CALLS, **settings), 10)
    return pattern.count("+") - pattern.count("-")


@pytest.mark.parametrize("inv, pattern", [(30, "+++......."), (-30, "---.......")])
def test_thirty_percent_of_ten_calls_are_three(inv, pattern):
    assert pulses(restarted(PULSEGEN, INV=inv, **TEN_CALLS), 20) == pattern + pattern


@pytest.mark.parametrize("inv, count", [(34, 3), (35, 4), (36, 4), (45, 4), (46, 5)])
def test_a_pulse_is_a_whole_number_of_calls(inv, count):
    assert pulses(restarted(PULSEGEN, INV=inv, **TEN_CALLS), 10).count("+") == count


@pytest.mark.parametrize(
    "inv, count", [(19.99, 0), (20, 2), (25, 2), (75, 8), (80, 8), (80.01, 10), (-20, -2)]
)
def test_three_step_pulses_keep_the_minimum_times(inv, count):
    assert signed_pulse_calls(inv, P_B_TM=200) == count


@pytest.mark.parametrize(
    "inv, count", [(-19, 0), (-20, -1), (-80, -4), (-80.01, -5), (50, 5)]
)
def test_a_ratio_factor_below_one_shortens_negative_pulses(inv, count):
    assert signed_pulse_calls(inv, P_B_TM=200, RATIOFAC=0.5) == count


@pytest.mark.parametrize("inv, count", [(20, 1), (81, 5), (-50, -5)])
def test_a_ratio_factor_above_one_shortens_positive_pulses(inv, count):
    assert signed_pulse_calls(inv, P_B_TM=200, RATIOFAC=2) == count


@pytest.mark.parametrize("inv, count", [(-60, 2), (0, 5), (60, 8), (60.01, 10), (-60.01, 0)])
def test_bipolar_two_step_pulses(inv, count):
    block = restarted(PULSEGEN, INV=inv, P_B_TM=200, **TEN_CALLS, **BIPOLAR)
    assert pulses(block, 10) == count * "+" + (10 - count) * "-"


@pytest.mark.parametrize(
    "inv, count", [(-50, 0), (0, 0), (10, 0), (20, 2), (80, 8), (81, 10)]
)
def test_monopolar_two_step_pulses(inv, count):
    block = restarted(PULSEGEN, INV=inv, P_B_TM=200, **TEN_CALLS, **MONOPOLAR)
    assert pulses(block, 10) == count * "+" + (10 - count) * "-"


@pytest.mark.parametrize("mode", [BIPOLAR, MONOPOLAR], ids=["bipolar", "monopolar"])
def test_two_step_control_is_off_below_its_range(mode):
    assert pulses(restarted(PULSEGEN, INV=-150, P_B_TM=0, **TEN_CALLS, **mode), 10) == 10 * "-"


@pytest.mark.parametrize(
    "call, old_period",
    [(1, "++"), (2, "+++"), (5, "+++..."), (7, "+++....."), (8, "+++......."), (9, "+++.......")],
)
def test_a_changed_inv_starts_the_next_period_in_the_next_call(call, old_period):
    block = restarted(PULSEGEN, P_B_TM=0, **TEN_CALLS)
    inv = call * [30] + 30 * [80]
    expected = old_period + "++++++++.."
    assert pulses(block, len(expected), INV=inv) == expected


def test_without_syn_on_a_period_runs_to_its_end():
    block = restarted(PULSEGEN, P_B_TM=0, SYN_ON=False, **TEN_CALLS)
    assert pulses(block, 20, INV=[30] + 19 * [80]) == "+++......." + "++++++++.."


def test_an_inv_that_changes_in_every_call_stays_on():
    block = restarted(PULSEGEN, P_B_TM=0, **TEN_CALLS)
    assert pulses(block, 40, INV=[30 + 0.01 * number for number in range(40)]) == 40 * "+"


@pytest.mark.parametrize("inv, count", [(40, 0), (41, 10)])
def test_a_minimum_time_beyond_half_the_period_leaves_off_and_on(inv, count):
    assert signed_pulse_calls(inv, P_B_TM=600) == count


@pytest.mark.parametrize(
    "mode, requests, outputs",
    [
        ({}, (False, False), "."),
        ({}, (True, False), "+"),
        ({}, (False, True), "-"),
        ({}, (True, True), "."),
        (MONOPOLAR, (False, False), "-"),
        (MONOPOLAR, (False, True), "-"),
        (MONOPOLAR, (True, False), "+"),
        (BIPOLAR, (True, True), "+"),
    ],
)
def test_manual_mode_obeys_the_requests(mode, requests, outputs):
    block = restarted(PULSEGEN, MAN_ON=True, POS_P_ON=requests[0], NEG_P_ON=requests[1], **mode)
    assert pulses(block, 1) == outputs


def test_a_period_starts_after_manual_mode():
    block = restarted(PULSEGEN, INV=30, **TEN_CALLS)
    man_on = 5 * [False] + 2 * [True] + 10 * [False]
    assert pulses(block, 17, MAN_ON=man_on) == "+++.." + ".." + "+++......."


def test_a_restart_switches_both_outputs_off_in_two_step_mode_too():
    block = PULSEGEN()
    assign(block, dict(COM_RST=True, STEP3_ON=False, INV=-50))
    assert calls(block, 1, "QPOS_P", "QNEG_P") == [(False, False)]


# --- PULS_CTR -------------------------------------------------------------------------------


def test_the_example_calls_its_controller_in_every_red_fac_th_call():
    # P action alone: LMN = 2 * 15 = 30 from call 10 on, so the pulses begin with the period
    # that starts in call 11.
    block = restarted(PULS_CTR, SP_INT=15, RED_FAC=10, CYCLE=100)
    block.set("DI_CONT_C.I_SEL", False)
    rows = calls(block, 30, "DI_CONT_C.LMN", "QPOS_P")
    assert [row[0] for row in rows] == 9 * real(0) + 21 * real(30)
    assert "".join("+" if row[1] else "." for row in rows) == 10 * "." + 2 * "+++......."


def test_the_example_controls_the_peripheral_process_value():
    block = restarted(PULS_CTR, PV_PER=13824, RED_FAC=1)
    block.call()
    assert block.get("DI_CONT_C.PV") == 50
    assert block.get("DI_CONT_C.CYCLE") == 10


def test_the_example_starts_with_the_manuals_times():
    block = PULS_CTR()
    assert (block.get("RED_FAC"), block.get("CYCLE")) == (200, 10)
    block.call()
    assert block.get("DI_CONT_C.CYCLE") == block.get("DI_PULSEGEN.PER_TM") == 2000


def test_the_example_restarts_both_its_blocks():
    # A set point far away: without the restart the pulse would last the whole period.
    block = restarted(PULS_CTR, SP_INT=90, RED_FAC=10, CYCLE=100)
    assert calls(block, 11, "QPOS_P")[-1] is True
    block.set("COM_RST", True)
    assert calls(block, 1, "QPOS_P", "DI_CONT_C.LMN") == [(False, 0)]
    block.set("COM_RST", False)
    assert calls(block, 10, "DI_CONT_C.LMN") == 9 * real(0) + real(100)


# --- HLG ------------------------------------------------------------------------------------


def ramp(count, output=0, **values):
    """HLG's output in `count` calls that follow an output of `output`."""
    block = HLG()
    assign(block, dict(SET=True, INIT=output))
    block.call()
    assign(block, dict(SET=False, **values))
    return calls(block, count, "HLG")


@pytest.mark.parametrize(
    "set_point, n, outputs",
    [
        (10, 4, [2, 5, 7, 10, 10]),
        (10, 3, [3, 6, 10, 10]),
        (3, 7, [0, 0, 1, 1, 2, 2, 3]),
        (10, 0, [10]),
        (10, -3, [10]),
    ],
)
def test_the_set_point_is_reached_in_exactly_n_calls(set_point, n, outputs):
    assert ramp(len(outputs), S0=set_point, TH_TZ=n) == outputs
    downwards = ramp(len(outputs), S0=-set_point, TR_TZ=n)
    assert downwards == [-output for output in outputs]


def test_the_amount_of_the_set_point_alone_makes_the_slope():
    assert ramp(15, output=1000, S0=-500, TR_TZ=5) == list(range(900, -501, -100))


def test_the_widest_ramp_does_not_overflow():
    outputs = ramp(4, output=-32767, S0=32767, TH_TZ=2)
    assert outputs == [-16384, 0, 16383, 32767]


@pytest.mark.parametrize("tr_tz", [5, 0])
def test_a_set_point_of_zero_holds_the_output(tr_tz):
    assert ramp(3, output=70, S0=0, TR_TZ=tr_tz) == [70, 70, 70]


def test_the_direction_chooses_the_ramp_time():
    block = HLG()
    assign(block, dict(S0=20, TH_TZ=2, TR_TZ=5))
    assert calls(block, 6, "HLG", S0=[20, 20, -20, -20, -20, -20]) == [10, 20, 16, 12, 8, 4]


def test_e01_chooses_the_set_point():
    block = HLG()
    assign(block, dict(S0=5, S1=9))
    assert calls(block, 2, "HLG", E01=[False, True]) == [5, 9]


def test_stop_goes_before_set_and_set_before_r():
    block = HLG()
    assign(block, dict(S0=100, INIT=40))
    sequences = {
        "STOP": [False, True, False, False, False],
        "SET": [False, True, True, False, False],
        "R": [False, True, True, True, False],
    }
    assert calls(block, 5, "HLG", **sequences) == [100, 100, 40, 0, 100]


def test_stop_keeps_the_remainder():
    block = HLG()
    assign(block, dict(S0=10, TH_TZ=4))
    assert calls(block, 5, "HLG", STOP=[False, True, False, False, False]) == [2, 2, 5, 7, 10]


# A first call towards 10 in 4 calls always goes to 2 and leaves a remainder of 2. Where the
# remainder is kept, the next step is 12 / 4 = 3, where it is forgotten, 10 / 4 = 2.
@pytest.mark.parametrize(
    "sequences, outputs",
    [
        ({"SET": [False, True] + 4 * [False]}, [2, 2, 4, 7, 9, 10]),
        ({"R": [False, True] + 4 * [False]}, [2, 0, 2, 5, 7, 10]),
        ({"S0": [10, 0, 10, 10, 10, 10]}, [2, 2, 4, 7, 9, 10]),
        ({"S0": [10, 11, 11, 11, 11, 11]}, [2, 4, 7, 10, 11, 11]),
        ({"TH_TZ": [4, 3, 3, 3, 3, 3]}, [2, 5, 8, 10, 10, 10]),
    ],
    ids=["SET", "R", "set point 0", "another set point", "another ramp time"],
)
def test_a_new_start_forgets_the_remainder(sequences, outputs):
    block = HLG()
    assign(block, dict(S0=10, TH_TZ=4, INIT=2))
    assert calls(block, 6, "HLG", **sequences) == outputs


@pytest.mark.parametrize("pin", ["S0", "INIT"])
def test_the_lowest_integer_counts_as_its_neighbour(pin):
    block = HLG()
    assign(block, {pin: -32768, "SET": pin == "INIT"})
    assert calls(block, 1, "HLG") == [-32767]
