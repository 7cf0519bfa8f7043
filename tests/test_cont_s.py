"""CONT_S (FB 42): one test per clause of the manual, with pulses that can be counted by hand.

Unless told otherwise: GAIN 2, TI 20 s, DEADB_W 1, PULSE_TM = BREAK_TM = 3 s, MTR_TM 30 s, CYCLE 1 s, after a
restart. `pulses` writes one letter a call: U for QLMNUP, D for QLMNDN, B for both, a dot for none.
"""

import re

import pytest

import signals
from host import real

LETTER = {(0, 0): ".", (1, 0): "U", (0, 1): "D", (1, 1): "B"}


@pytest.fixture
def start(open_fmu):
    def start(**values):
        return open_fmu("CONT_S").start(**values)

    return start


@pytest.fixture
def fine(start):
    """The valve's assumed position follows the law closely: pulses and breaks of a single call of 100 ms."""

    def fine(**values):
        settings = {"GAIN": 1.0, "DEADB_W": 0.0, "CYCLE": 0.1, "PULSE_TM": 0.1, "BREAK_TM": 0.1}
        return start(**{**settings, **values})

    return fine


def pulses(controller, calls, **sequences):
    return "".join(LETTER[pair] for pair in controller.record("QLMNUP", "QLMNDN", calls=calls, **sequences))


def runs(pattern, letter):
    """The lengths of all runs of a letter that are over."""
    return [len(run) for run in re.findall(f"{re.escape(letter)}+(?=[^{letter}])", pattern)]


# --- Setpoint, process value, error ------------------------------------------------------------------


def test_the_dead_band_takes_its_half_width_from_the_error(start):
    controller = start(DEADB_W=1.0)
    errors = [-3.0, -1.0, 0.5, 1.0, 3.0]
    assert controller.record("ER", calls=5, SP_INT=errors) == [-2.0, 0.0, 0.0, 0.0, 2.0]


def test_the_process_value_comes_from_pv_in_or_normalized_from_pv_per(start):
    controller = start(PV_IN=7.0, PV_PER=13824, PV_FAC=2.0, PV_OFF=-50.0)
    assert controller.record("PV", calls=2, PVPER_ON=[0, 1]) == [7.0, 50.0]


def test_within_the_dead_band_the_valve_rests(start):
    assert pulses(start(SP_INT=1.0), 200) == "." * 200


# --- The step controller as it was measured -----------------------------------------------------------


def test_a_setpoint_step_gives_a_long_pulse_and_then_minimum_pulses(start):
    expected = "UUUUUU......UUU.......UUU.......UUU.......UUU.......UUU....."
    assert pulses(start(SP_INT=11.0), 60) == expected


def test_a_negative_error_closes_the_valve(start):
    assert pulses(start(SP_INT=-6.0), 37) == "DDD................DDD.................D"[:37]


def test_a_dead_band_error_of_0_stops_the_pulses(start):
    controller = start(SP_INT=11.0)
    pulses(controller, 60)
    controller.set(PV_IN=11.0)
    assert pulses(controller, 200)[-100:] == "." * 100


# --- P action: the valve moves by GAIN ER percent --------------------------------------------------


def travel(pattern, cycle, motor):
    """Percent by which a pattern of pulses opens the valve."""
    return 100 * cycle * (pattern.count("U") - pattern.count("D")) / motor


def test_without_i_action_the_valve_travels_by_the_p_action_and_rests(start):
    controller = start(TI=0.0, GAIN=1.0, DEADB_W=0.0, MTR_TM=10.0, PULSE_TM=1.0, BREAK_TM=1.0)
    assert pulses(controller, 50, SP_INT=[40.0] * 50) == "UUUU" + "." * 46


@pytest.mark.parametrize("percent", [10.0, 25.0, 60.0, 100.0])
def test_without_i_action_travel_is_gain_times_error_up_and_down(fine, percent):
    controller = fine(TI=0.0, GAIN=2.0, MTR_TM=20.0)
    up = pulses(controller, 1000, SP_INT=[percent / 2] * 1000)
    assert travel(up, 0.1, 20.0) == pytest.approx(percent, abs=1.0)
    down = pulses(controller, 1000, SP_INT=[0.0] * 1000)
    assert travel(down, 0.1, 20.0) == pytest.approx(-percent, abs=1.0)


def test_without_i_action_the_position_stays_within_0_and_100(fine):
    """At P = 150 % the valve drives up without end; back at 0 the position counts down from 100, not 150."""
    controller = fine(TI=0.0, MTR_TM=10.0)
    assert pulses(controller, 200, SP_INT=[150.0] * 200).count("U") == 200
    down = pulses(controller, 300, SP_INT=[0.0] * 300)
    assert travel(down, 0.1, 10.0) == pytest.approx(-100, abs=2.0)


# --- The I action --------------------------------------------------------------------------------------


@pytest.mark.parametrize("e, first_pulse", [(1.0, 3), (5.0, 15), (20.0, 60)])
def test_travel_equals_the_ideal_pi_law(fine, e, first_pulse):
    """The first pulse is the P action, e MTR_TM / 100. From pulse start to pulse start the valve then moves
    at e / TI: 0.05, 0.25, 1.0 % a second within 2 parts in 10^4."""
    controller = fine(SP_INT=e, MTR_TM=30.0, TI=20.0)
    pattern = pulses(controller, 30_000)
    assert runs(pattern, "U")[0] == first_pulse
    starts = [match.start() for match in re.finditer(r"(?<=\.)U", pattern)]
    first, last = starts[0], starts[-1]
    rate = travel(pattern[first:last], 0.1, 30.0) / ((last - first) * 0.1)
    assert rate == pytest.approx(e / 20, rel=2e-4)


@pytest.mark.parametrize("e, behind", [(10.0, 1.5), (20.0, 6.0)])
def test_travel_stays_behind_the_ideal_law_by_what_the_first_pulse_did_not_integrate(fine, e, behind):
    """e^2 MTR_TM / (100 TI) behind e (1 + t / TI) whenever a pulse has ended, to the 1/3 % of a call."""
    controller = fine(SP_INT=e, MTR_TM=30.0, TI=20.0)
    pattern = pulses(controller, 20_000)
    ends = [match.end() for match in re.finditer(r"U(?=\.)", pattern)]
    assert len(ends) > 50
    for end in ends[1:]:
        ideal = e * (1 + end * 0.1 / 20)
        assert ideal - travel(pattern[:end], 0.1, 30.0) == pytest.approx(behind, abs=1 / 3)


def test_the_error_is_integrated_in_the_pauses_only(fine):
    """While the first pulse runs F counts the valve alone: 20 % take 60 calls of 1/3 %, with TI = 20 s as
    with 5000 s. An integrator that went on would have asked for 26 % in the meantime."""
    for ti in (20.0, 5000.0):
        assert runs(pulses(fine(SP_INT=20.0, MTR_TM=30.0, TI=ti), 100) + ".", "U")[0] == 60


def test_ti_has_a_floor_of_half_a_cycle_unless_it_is_0(start):
    """An error of 0.1 asks for a pulse of one call, 10/3 %, every 17 s at TI = 0.5 s, and half as often at 1 s."""

    def count(ti):
        controller = start(SP_INT=0.1, GAIN=1.0, DEADB_W=0.0, PULSE_TM=0.0, BREAK_TM=0.0, TI=ti)
        return pulses(controller, 1000).count("U")

    assert count(0.001) == count(0.25) == count(0.5) == 2 * count(1.0) == pytest.approx(60, abs=6)


def test_mtr_tm_has_a_floor_of_a_cycle(start):
    settings = {"SP_INT": 60.0, "PULSE_TM": 0.0, "BREAK_TM": 0.0, "DEADB_W": 0.0}
    assert pulses(start(MTR_TM=0.0, **settings), 100) == pulses(start(MTR_TM=1.0, **settings), 100)


# --- Feedforward ----------------------------------------------------------------------------------------


def test_disv_moves_the_valve_like_a_p_action(fine):
    controller = fine(TI=0.0, MTR_TM=20.0)
    assert travel(pulses(controller, 300, DISV=[30.0] * 300), 0.1, 20.0) == pytest.approx(30, abs=1)


# --- Minimum pulse and break, reversal ---------------------------------------------------------------


@pytest.mark.parametrize("pulse_tm, calls", [(0.0, 1), (1.0, 1), (2.0, 2), (3.0, 3), (7.0, 7)])
def test_a_pulse_lasts_at_least_pulse_tm(start, pulse_tm, calls):
    controller = start(LMNS_ON=1, PULSE_TM=pulse_tm, BREAK_TM=1.0)
    assert pulses(controller, 12, LMNUP=[0, 1] + [0] * 10) == "." + ("U" * calls).ljust(11, ".")


@pytest.mark.parametrize("break_tm, calls", [(0.0, 1), (1.0, 1), (2.0, 2), (5.0, 5)])
def test_a_break_lasts_at_least_break_tm(start, break_tm, calls):
    controller = start(LMNS_ON=1, PULSE_TM=1.0, BREAK_TM=break_tm)
    assert pulses(controller, 10, LMNUP=[1, 0] + [1] * 8) == "U" + "." * calls + "U" * (9 - calls)


def test_a_break_stands_between_up_and_down_too(start):
    controller = start(LMNS_ON=1)
    lmnup = [0, 1] + [0] * 14
    lmndn = [0] * 3 + [1] * 9 + [0] * 4
    assert pulses(controller, 16, LMNUP=lmnup, LMNDN=lmndn) == ".UUU...DDDDD...."


def test_minimum_times_hold_in_automatic_mode(open_fmu):
    """Random setpoints: no pulse and no break is shorter, but at the ends of the run."""
    for cycle, pulse_tm, break_tm in ((1.0, 3.0, 4.0), (0.1, 0.5, 0.2), (0.5, 2.0, 2.0)):
        fmu = open_fmu("CONT_S")
        controller = fmu.start(CYCLE=cycle, PULSE_TM=pulse_tm, BREAK_TM=break_tm, MTR_TM=20 * cycle)
        setpoints = [row["SP_INT"] for row in signals.rows(fmu, 2000)]
        pattern = pulses(controller, 2000, SP_INT=setpoints)
        assert "UD" not in pattern and "DU" not in pattern
        for letter in "UD":
            assert len(runs(pattern, letter)) > 20
            assert min(runs(pattern, letter)) * cycle >= pulse_tm
        breaks = runs(pattern.lstrip("."), ".")
        assert min(breaks) * cycle >= break_tm


def test_a_reversed_demand_ends_the_pulse_first(start):
    controller = start(LMNS_ON=1, PULSE_TM=0.0, BREAK_TM=0.0)
    assert pulses(controller, 6, LMNUP=[1, 1, 0, 0, 0, 0], LMNDN=[0, 0, 1, 1, 1, 1]) == "UU.DDD"


# --- Manual pulses -----------------------------------------------------------------------------------------


def test_manual_signals_make_the_pulses(start):
    controller = start(LMNS_ON=1, PULSE_TM=1.0, BREAK_TM=1.0, SP_INT=50.0)
    assert pulses(controller, 8, LMNUP=[1, 1, 1, 0, 0, 0, 0, 0], LMNDN=[0, 0, 0, 0, 1, 1, 0, 0]) == "UUU.DD.."


def test_both_manual_signals_or_neither_make_no_pulse(start):
    controller = start(LMNS_ON=1, SP_INT=50.0)
    assert pulses(controller, 6, LMNUP=[0, 0, 0, 1, 1, 1], LMNDN=[0, 0, 0, 1, 1, 1]) == "......"


def test_manual_signals_do_nothing_in_automatic_mode(start):
    assert pulses(start(LMNUP=1), 20) == "." * 20


def test_manual_mode_clears_the_integrator(start):
    """Automatic after a manual call starts as after a restart."""
    controller = start(SP_INT=11.0, BREAK_TM=0.0, PULSE_TM=0.0)
    pulses(controller, 40)
    pulses(controller, 4, LMNS_ON=[1, 1, 1, 1])
    controller.set(LMNS_ON=0)
    assert pulses(controller, 40) == pulses(start(SP_INT=11.0, BREAK_TM=0.0, PULSE_TM=0.0), 40)


# --- Limit stops -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stop, demand, letter", [("LMNR_HS", "LMNUP", "U"), ("LMNR_LS", "LMNDN", "D")])
def test_no_pulse_starts_against_a_reported_stop(start, stop, demand, letter):
    controller = start(LMNS_ON=1, **{demand: 1})
    assert pulses(controller, 6, **{stop: [1, 1, 1, 0, 0, 0]}) == "..." + letter * 3


@pytest.mark.parametrize("stop, demand, letter", [("LMNR_HS", "LMNDN", "D"), ("LMNR_LS", "LMNUP", "U")])
def test_a_stop_does_not_keep_the_valve_from_leaving_it(start, stop, demand, letter):
    assert pulses(start(LMNS_ON=1, **{demand: 1, stop: 1}), 5) == letter * 5


def test_a_stop_within_the_minimum_pulse_cuts_it_and_asks_for_no_break(start):
    controller = start(LMNS_ON=1)
    lmnup = [0] + [1] * 15
    stop = [0, 0, 1, 1] + [0] * 12
    assert pulses(controller, 16, LMNUP=lmnup, LMNR_HS=stop) == ".U..UUUUUUUUUUUU"


def test_a_stop_after_the_minimum_pulse_cuts_it_and_the_break_follows(start):
    controller = start(LMNS_ON=1)
    lmnup = [1] * 16
    stop = [0] * 5 + [1] + [0] * 10
    assert pulses(controller, 16, LMNUP=lmnup, LMNR_HS=stop) == "UUUUU...UUUUUUUU"


def test_a_stop_in_automatic_mode(start):
    controller = start(SP_INT=21.0)
    stop = [0] * 7 + [1] * 5 + [0] * 12
    assert pulses(controller, 24, LMNR_HS=stop) == "UUUUUUU.....UUUUUUUU...U"


@pytest.mark.parametrize("stop, sign", [("LMNR_HS", 1), ("LMNR_LS", -1)])
def test_at_a_stop_the_integrator_does_not_wind_up(fine, stop, sign):
    """However long the stop was reported against the error: the pulses after it are the same."""
    after = []
    for calls in (10, 1000):
        controller = fine(SP_INT=sign * 5.0, MTR_TM=30.0)
        pulses(controller, calls, **{stop: [1] * calls})
        controller.set(**{stop: 0})
        after.append(pulses(controller, 200))
    assert after[0] == after[1]
    assert set(after[0]) == {".", "U" if sign > 0 else "D"}


def test_never_both_outputs_never_an_immediate_reversal_never_against_a_stop(open_fmu):
    fmu = open_fmu("CONT_S")
    controller = fmu.start(PULSE_TM=2.0, BREAK_TM=1.0)
    rows = signals.rows(fmu, 5000)
    sequences = {name: [row[name] for row in rows] for name in rows[0] if name != "COM_RST"}
    pattern = pulses(controller, 5000, **sequences)
    assert "B" not in pattern and "UD" not in pattern and "DU" not in pattern
    for letter, row in zip(pattern, rows):
        assert not (letter == "U" and row["LMNR_HS"])
        assert not (letter == "D" and row["LMNR_LS"])
    assert pattern.count("U") > 500 and pattern.count("D") > 500


# --- Switch-on threshold ---------------------------------------------------------------------------------


def test_the_threshold_grows_with_the_error_so_that_few_pulses_are_made(fine):
    """Pulses a percent of travel at a small and at a large error."""
    few = pulses(fine(SP_INT=20.0, MTR_TM=100.0, TI=100.0), 20_000)
    many = pulses(fine(SP_INT=1.0, MTR_TM=100.0, TI=100.0), 20_000)
    per_percent = [len(runs(pattern, "U")) / travel(pattern, 0.1, 100.0) for pattern in (few, many)]
    assert per_percent[0] < per_percent[1] / 2


def test_the_smallest_threshold_is_the_travel_of_a_minimum_pulse(start):
    """100 PULSE_TM / MTR_TM = 10 %: an error of 9.9 % moves nothing without I action, one of 10 % does."""
    for e, pattern in ((9.9, "." * 20), (10.0, "UUU" + "." * 17)):
        controller = start(TI=0.0, GAIN=1.0, DEADB_W=0.0)
        assert pulses(controller, 20, SP_INT=[e] * 20) == pattern


@pytest.mark.parametrize("e, calls", [(10.54, 10), (10.56, 11)])
def test_a_pulse_ends_where_less_than_55_percent_of_a_calls_travel_is_left(start, e, calls):
    """A call moves the valve by 1 %: after ten of them 0.54 % is too little for another, 0.56 % is not."""
    controller = start(TI=0.0, GAIN=1.0, DEADB_W=0.0, MTR_TM=100.0, PULSE_TM=0.0, BREAK_TM=0.0)
    assert pulses(controller, 30, SP_INT=[e] * 30) == ("U" * calls).ljust(30, ".")


# --- Restart -------------------------------------------------------------------------------------------------


def test_com_rst_cuts_a_running_pulse_at_once_and_sets_all_outputs_to_0(start):
    controller = start(SP_INT=50.0)
    assert pulses(controller, 2) == "UU"
    controller.step(COM_RST=1)
    assert set(controller.get(["QLMNUP", "QLMNDN", "PV", "ER", "QLMN_MEAN"]).values()) == {0}


def test_com_rst_makes_the_controller_as_new(start):
    used = start(SP_INT=11.0)
    pulses(used, 33)
    used.step(COM_RST=1)
    used.set(COM_RST=0)
    assert pulses(used, 60) == pulses(start(SP_INT=11.0), 60)


# --- Mean -------------------------------------------------------------------------------------------------------


def test_the_mean_is_the_share_of_up_less_that_of_down(start):
    controller = start(SP_INT=11.0)
    controller.step(12.0)  # UUUUUU......
    assert controller["QLMN_MEAN"] == 50.0
    controller = start(SP_INT=-6.0)
    controller.step(4.0)  # DDD.
    assert controller["QLMN_MEAN"] == -75.0


def test_outputs_are_values_of_32_bits(start):
    controller = start(SP_INT=0.3, PV_IN=0.1, DEADB_W=0.0)
    controller.step()
    assert controller["ER"] == real(real(0.3) - real(0.1))
