"""CONT_C (FB 41): one test per clause of the manual, with numbers that can be checked by hand.

Unless told otherwise: automatic mode, GAIN 2, TI 20 s, TD 10 s, TM_LAG 2 s, CYCLE 1 s, limits 0 ... 100,
after a restart.
"""

import fmpy
import numpy as np
import pytest

import host
from host import real


@pytest.fixture
def start(open_fmu):
    """A controller in automatic mode after its restart."""

    def start(**values):
        return open_fmu("CONT_C").start(**{"MAN_ON": 0, **values})

    return start


def close(*numbers):
    return pytest.approx(numbers, rel=1e-6, abs=1e-6)


# --- Setpoint, process value, error ----------------------------------------------------------------


def test_the_error_is_setpoint_minus_process_value(start):
    controller = start()
    controller.step(SP_INT=30.0, PV_IN=12.5)
    assert controller["PV"] == 12.5
    assert controller["ER"] == 17.5


WORDS = [
    (27648, 100.0),
    (-27648, -100.0),
    (13824, 50.0),
    (0, 0.0),
    (32767, 118.5149),
    (-32768, -118.51852),
    (65535, -0.003616898),
]


@pytest.mark.parametrize("word, percent", WORDS)
def test_pv_per_is_a_percentage_of_27648(start, word, percent):
    controller = start(PVPER_ON=1)
    controller.step(PV_PER=word)
    assert controller["PV"] == real(percent)


def test_pv_fac_and_pv_off_normalize_the_peripheral_value(start):
    """0 ... 27648 as -50 ... 150 degrees: PV_FAC 2, PV_OFF -50."""
    controller = start(PVPER_ON=1, PV_FAC=2.0, PV_OFF=-50.0)
    assert controller.record("PV", calls=3, PV_PER=[0, 13824, 27648]) == [-50.0, 50.0, 150.0]


def test_pv_fac_and_pv_off_leave_pv_in_alone(start):
    controller = start(PV_FAC=2.0, PV_OFF=-50.0)
    assert controller.record("PV", calls=1, PV_IN=[10.0]) == [10.0]


def test_pvper_on_selects_the_process_value(start):
    controller = start(PV_IN=7.0, PV_PER=27648)
    assert controller.record("PV", calls=3, PVPER_ON=[0, 1, 0]) == [7.0, 100.0, 7.0]


def test_the_dead_band_takes_its_half_width_from_the_error(start):
    controller = start(DEADB_W=1.0)
    errors = [-3.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 3.0]
    expected = [-2.0, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 2.0]
    assert controller.record("ER", calls=9, SP_INT=errors) == expected


def test_a_dead_band_of_0_is_none(start):
    controller = start(DEADB_W=0.0)
    assert controller.record("ER", calls=3, SP_INT=[-0.001, 0.0, 0.001]) == real(-0.001, 0.0, 0.001)


# --- P, I, D and their sums -------------------------------------------------------------------------


def test_p_action_is_gain_times_error(start):
    controller = start(I_SEL=0, GAIN=2.5)
    controller.step(SP_INT=10.0, PV_IN=4.0)
    assert controller["LMN_P"] == controller["LMN"] == 15.0
    controller.step(P_SEL=0)
    assert controller["LMN_P"] == controller["LMN"] == 0.0


def test_a_negative_gain_reverses_the_action(start):
    controller = start(I_SEL=0, GAIN=-2.0)
    assert controller.record("LMN", calls=2, SP_INT=[0.0, 0.0], PV_IN=[5.0, 7.0]) == [10.0, 14.0]


def test_i_action_is_a_trapezoid_from_the_first_call_on(start):
    """LMN_I(k) = (CYCLE / TI) e (k - 1/2) for e = GAIN ER constant from call 1 on."""
    controller = start(SP_INT=1.0)
    got = controller.record("LMN_I", "LMN_PER", calls=5)
    assert [i for i, _ in got] == real(0.05, 0.15, 0.25, 0.35, 0.45)
    assert [per for _, per in got] == [567, 594, 622, 650, 677]


def test_pure_i_action(start):
    controller = start(P_SEL=0, SP_INT=4.0, TI=2.0)
    assert controller.record("LMN", calls=4) == [2.0, 6.0, 10.0, 14.0]


def test_the_i_action_follows_the_mean_of_two_errors(start):
    """CYCLE / TI = 1/20, GAIN 2: a triangle of errors 1, 3, 2, 0 gives 0.05 (1 + 4 + 5 + 2)."""
    controller = start()
    got = controller.record("LMN_I", calls=4, SP_INT=[1.0, 3.0, 2.0, 0.0])
    assert got == close(0.05, 0.25, 0.5, 0.6)


def test_after_the_reset_time_the_i_action_equals_the_p_action(start):
    """What TI means: 20.5 calls of 1 s after the step, counted with the trapezoid's half call."""
    controller = start(SP_INT=1.0, TI=20.0)
    i = controller.record("LMN_I", calls=21)
    assert (i[19] + i[20]) / 2 == pytest.approx(controller["LMN_P"], rel=1e-6)


def test_d_action_kicks_and_decays(start):
    """LMN_D(k) = e V a^(k-1) with V = TD / (CYCLE/2 + TM_LAG) = 4, a = 1 - CYCLE / (CYCLE/2 + TM_LAG) = 0.6."""
    controller = start(I_SEL=0, D_SEL=1, SP_INT=1.0)
    got = controller.record("LMN_D", calls=20)
    assert got[:5] == real(8.0, 4.8, 2.88, 1.7279997, 1.0367999)
    assert got == close(*[2 * 4 * 0.6**k for k in range(20)])


def test_d_action_without_lag_lasts_one_call(start):
    controller = start(I_SEL=0, D_SEL=1, TM_LAG=0.0, SP_INT=1.0)
    assert controller.record("LMN_D", calls=3) == [20.0, 0.0, 0.0]


def test_d_action_of_a_ramp_settles_at_its_slope_times_td(start):
    """e rises by 2 a second: LMN_D goes to 2 * TD = 20."""
    controller = start(I_SEL=0, D_SEL=1, LMN_HLM=1000.0)
    got = controller.record("LMN_D", calls=60, SP_INT=[float(k) for k in range(60)])
    assert got[-1] == pytest.approx(20.0, rel=1e-4)


def test_pi_action_is_the_sum(start):
    controller = start(SP_INT=1.0)
    assert controller.record("LMN", calls=3) == close(2.05, 2.15, 2.25)


def test_pd_action_is_the_sum(start):
    controller = start(SP_INT=1.0, I_SEL=0, D_SEL=1)
    assert controller.record("LMN", calls=3) == close(2 + 8, 2 + 4.8, 2 + 2.88)


def test_pid_action_is_the_sum(start):
    controller = start(SP_INT=1.0, D_SEL=1)
    got = controller.record("LMN", "LMN_P", "LMN_I", "LMN_D", calls=10)
    for k, (lmn, p, i, d) in enumerate(got, 1):
        assert (p, i, d) == close(2.0, 0.1 * (k - 0.5), 8 * 0.6 ** (k - 1))
        assert [lmn] == close(p + i + d)


def test_pure_d_action(start):
    controller = start(P_SEL=0, I_SEL=0, D_SEL=1, SP_INT=1.0)
    assert controller.record("LMN", calls=2) == close(8.0, 4.8)


def test_with_all_actions_off_only_the_feedforward_is_left(start):
    controller = start(P_SEL=0, I_SEL=0, D_SEL=0, SP_INT=50.0)
    assert controller.record("LMN", calls=2, DISV=[0.0, 12.5]) == [0.0, 12.5]


def test_gain_acts_on_p_i_and_d(start):
    one = start(GAIN=1.0, D_SEL=1, SP_INT=1.0)
    three = start(GAIN=3.0, D_SEL=1, SP_INT=1.0)
    for values in zip(*(c.record("LMN_P", "LMN_I", "LMN_D", calls=5) for c in (one, three))):
        assert values[1] == close(*[3 * value for value in values[0]])


def test_a_change_of_gain_kicks_the_d_action_once(start):
    """e = 10, then 20 without a change of the error: V = 4 times the difference, and it decays."""
    controller = start(I_SEL=0, D_SEL=1, GAIN=1.0)
    controller.record("LMN_D", calls=100, SP_INT=[10.0] * 100)
    assert controller["LMN_D"] == pytest.approx(0.0, abs=1e-5)
    controller.set(GAIN=2.0)
    assert controller.record("LMN_D", calls=2) == pytest.approx([40.0, 24.0], abs=1e-4)


def test_small_increments_on_a_large_integral_are_not_lost(start):
    """100 000 calls that add 1e-7 each to 50, where a REAL's last bit is 3.8e-6."""
    controller = start(CYCLE=0.01, TI=3600.0, GAIN=1.0, SP_INT=0.036, I_ITLVAL=50.0)
    controller.step(1000.0)
    assert controller["LMN_I"] == real(50.01)


# --- Floors of the times ----------------------------------------------------------------------------


def test_ti_has_a_floor_of_half_a_cycle(start):
    """TI = 0 does not switch the I action off: q = (1 / 0.5) e / 2 = e in the first call."""
    controller = start(P_SEL=0, TI=0.0, SP_INT=1.0)
    assert controller.record("LMN_I", calls=2) == [2.0, 6.0]


def test_td_has_a_floor_of_a_cycle(start):
    """V = 1 / (0.5 + 2) = 0.4 for TD = 0."""
    controller = start(I_SEL=0, D_SEL=1, TD=0.0, SP_INT=1.0)
    assert controller.record("LMN_D", calls=1) == close(0.8)


def test_tm_lag_has_a_floor_of_half_a_cycle(start):
    """V = 10 / (0.5 + 0.5) for any TM_LAG up to 0.5 s."""
    for lag in (0.0, 0.1, 0.5):
        assert start(I_SEL=0, D_SEL=1, TM_LAG=lag, SP_INT=1.0).record("LMN_D", calls=1) == close(20.0)
    assert start(I_SEL=0, D_SEL=1, TM_LAG=0.75, SP_INT=1.0).record("LMN_D", calls=1) == close(16.0)


@pytest.mark.parametrize("cycle", [0.01, 0.1, 1.0, 2.5])
def test_the_i_action_over_a_time_does_not_depend_on_the_sampling_time(start, cycle):
    """After t = 10 s: e (t - CYCLE/2) / TI."""
    controller = start(CYCLE=cycle, SP_INT=1.0)
    controller.step(10.0)
    assert controller["LMN_I"] == pytest.approx(2 * (10 - cycle / 2) / 20, rel=1e-5)


@pytest.mark.parametrize("cycle", [0.01, 0.1, 0.5])
def test_the_d_action_decays_with_its_lag_at_any_sampling_time(start, cycle):
    """From 2 TD / TM_LAG = 10 by e^-t/TM_LAG; at small CYCLE the sampled law comes close to that."""
    controller = start(CYCLE=cycle, I_SEL=0, D_SEL=1, SP_INT=1.0)
    controller.step(4.0)
    assert controller["LMN_D"] == pytest.approx(10 * np.exp(-(4 - cycle / 2) / 2), rel=cycle / 5)


# --- Limits -----------------------------------------------------------------------------------------


def test_lmn_stays_within_its_limits_and_the_flags_tell_which_is_reached(start):
    controller = start(I_SEL=0, GAIN=1.0, LMN_HLM=60.0, LMN_LLM=-20.0)
    got = controller.record("LMN", "QLMN_HLM", "QLMN_LLM", calls=5, SP_INT=[59.5, 60.0, 75.0, -19.5, -35.0])
    assert got == [(59.5, 0, 0), (60.0, 1, 0), (60.0, 1, 0), (-19.5, 0, 0), (-20.0, 0, 1)]


def test_reaching_a_limit_is_reported_like_passing_it(start):
    """With the default limits LMN = 0 lies at the low one."""
    controller = start(I_SEL=0)
    assert controller.record("LMN", "QLMN_HLM", "QLMN_LLM", calls=1) == [(0.0, 0, 1)]


def test_with_limits_the_wrong_way_round_the_high_one_is_asked_first(start):
    controller = start(I_SEL=0, GAIN=1.0, LMN_HLM=10.0, LMN_LLM=20.0)
    got = controller.record("LMN", "QLMN_HLM", "QLMN_LLM", calls=3, SP_INT=[5.0, 15.0, 25.0])
    assert got == [(20.0, 0, 1), (10.0, 1, 0), (10.0, 1, 0)]


def test_at_the_high_limit_the_integral_only_goes_down(start):
    """P 80, I by 8 a call (4 in the first): call 3 reaches 100, and I stops. When the error turns to -10,
    the first trapezoid, (80 - 10) / 2, is still upwards and counts for nothing."""
    controller = start(GAIN=1.0, TI=10.0, SP_INT=80.0)
    got = controller.record("LMN_I", "LMN", "QLMN_HLM", calls=6)
    assert got == [(4.0, 84.0, 0), (12.0, 92.0, 0)] + 4 * [(20.0, 100.0, 1)]
    controller.set(PV_IN=90.0)
    assert controller.record("LMN_I", "LMN", "QLMN_HLM", calls=2) == [(20.0, 10.0, 0), (19.0, 9.0, 0)]


def test_anti_windup_leaves_the_limit_in_the_call_in_which_the_error_turns(start):
    """Error 10 for 100 calls at TI 5 s: I goes 1, 3, ... 91 and stops there. Wound up it would stand at 199,
    and at an error of -1 LMN would stay at its limit for 500 calls more."""
    controller = start(GAIN=1.0, TI=5.0, SP_INT=10.0)
    controller.record("LMN", calls=100)
    assert (controller["LMN"], controller["QLMN_HLM"]) == (100.0, 1)
    controller.step(PV_IN=11.0)
    assert (controller["LMN"], controller["QLMN_HLM"]) == (91.0 - 1.0, 0)


def test_at_the_low_limit_the_integral_only_goes_up(start):
    """e = -2 of GAIN 2: LMN is 0 and I stays where the first trapezoid put it; then e = 2."""
    controller = start(SP_INT=-1.0, LMN_LLM=-50.0, LMN_OFF=0.0, DISV=-48.0)
    assert controller.record("LMN_I", "QLMN_LLM", calls=3) == [(real(-0.05), 1)] * 3
    controller.set(SP_INT=1.0)
    assert controller.record("LMN_I", calls=3) == close(-0.05, 0.05, 0.15)


def test_the_integral_alone_stays_within_the_limits(start):
    """DISV of -10 keeps LMN at 90 while the integral stands at LMN_HLM itself."""
    controller = start(P_SEL=0, TI=2.0, SP_INT=10.0, DISV=-10.0)
    controller.record("LMN", calls=30)
    assert controller["LMN_I"] == 100.0
    assert (controller["LMN"], controller["QLMN_HLM"]) == (90.0, 0)


def test_an_integral_put_outside_by_the_restart_comes_back_to_the_limit(start):
    controller = start(I_ITLVAL=120.0)
    assert controller.record("LMN_I", calls=2) == [100.0, 100.0]


def test_an_integral_put_outside_on_purpose_moves_freely_until_it_comes_back_by_itself(start):
    """CYCLE / TI = 1/4, LMN = LMN_I - 50: from 120 up by 1 and down to the limit of 100. Then it is held there."""
    controller = start(I_ITLVAL=120.0, I_ITL_ON=1, TI=4.0, GAIN=1.0, P_SEL=0, DISV=-50.0)
    assert controller.record("LMN_I", calls=1) == [120.0]
    controller.set(I_ITL_ON=0)
    assert controller.record("LMN_I", calls=3, SP_INT=[0.0, 0.0, 8.0]) == [120.0, 120.0, 121.0]
    down = controller.record("LMN_I", calls=6, SP_INT=[-16.0] * 6)
    assert down == [120.0, 116.0, 112.0, 108.0, 104.0, 100.0]
    assert controller.record("LMN_I", "LMN", calls=3, SP_INT=[16.0] * 3) == [(100.0, 50.0)] * 3


# --- Manual mode -----------------------------------------------------------------------------------


def test_in_manual_mode_lmn_follows_man_at_once_and_the_integral_one_call_later(start):
    controller = start(MAN_ON=1)
    got = controller.record("LMN", "LMN_I", calls=5, MAN=[40.0, 40.0, 50.0, 60.0, 60.0])
    assert [lmn for lmn, _ in got] == [40.0, 40.0, 50.0, 60.0, 60.0]
    assert [i for _, i in got] == [0.0, 40.0, 40.0, 50.0, 60.0]


def test_the_manual_value_is_limited_too(start):
    controller = start(MAN_ON=1, LMN_HLM=80.0, LMN_LLM=10.0)
    got = controller.record("LMN", "QLMN_HLM", "QLMN_LLM", calls=4, MAN=[50.0, 90.0, 80.0, 5.0])
    assert got == [(50.0, 0, 0), (80.0, 1, 0), (80.0, 1, 0), (10.0, 0, 1)]


def test_in_manual_mode_the_integral_is_lmn_less_lmn_p_less_disv(start):
    controller = start(MAN_ON=1, MAN=40.0, SP_INT=3.0, DISV=5.0)
    controller.record("LMN", calls=2)
    assert controller["LMN_P"] == 6.0
    assert controller["LMN_I"] == 40.0 - 6.0 - 5.0
    assert controller["LMN"] == 40.0


def test_manual_mode_matches_to_the_value_before_lmn_fac_and_lmn_off(start):
    controller = start(MAN_ON=1, MAN=40.0, LMN_FAC=2.0, LMN_OFF=7.0)
    controller.record("LMN", calls=2)
    assert (controller["LMN"], controller["LMN_I"]) == (87.0, 40.0)


def test_the_change_to_automatic_has_no_bump(start):
    """MAN stood still for two calls: LMN goes on where it was, but for the I action's next increment."""
    controller = start(MAN_ON=1, MAN=40.0, SP_INT=3.0, DISV=5.0, D_SEL=1)
    controller.record("LMN", calls=3)
    controller.set(MAN_ON=0)
    assert controller.record("LMN", calls=2) == close(40.0 + 6 / 20, 40.0 + 2 * 6 / 20)
    assert controller["LMN_D"] == 0.0


def test_the_change_to_automatic_bumps_if_man_moved_in_the_last_call(start):
    controller = start(MAN_ON=1)
    controller.record("LMN", calls=3, MAN=[40.0, 40.0, 60.0])
    controller.set(MAN_ON=0)
    assert controller.record("LMN", calls=1) == [40.0]


def test_in_manual_mode_the_d_action_is_0_and_matched(start):
    """An error that was there all the time does not kick at the change to automatic."""
    controller = start(MAN_ON=1, MAN=50.0, D_SEL=1, SP_INT=1.0)
    assert controller.record("LMN_D", calls=3) == [0.0, 0.0, 0.0]
    controller.set(MAN_ON=0)
    assert controller.record("LMN_D", calls=2) == [0.0, 0.0]
    controller.set(SP_INT=2.0)
    assert controller.record("LMN_D", calls=1) == close(8.0)


def test_the_change_to_manual_takes_man_in_the_same_call(start):
    controller = start(SP_INT=10.0, MAN=33.0)
    controller.record("LMN", calls=3)
    controller.step(MAN_ON=1)
    assert controller["LMN"] == 33.0


def test_manual_mode_is_the_default(open_fmu):
    controller = open_fmu("CONT_C").start(MAN=12.0, SP_INT=50.0)
    controller.step()
    assert controller["LMN"] == 12.0


# --- I_ITL_ON, INT_HOLD, I_SEL ---------------------------------------------------------------------


def test_i_itl_on_connects_the_integral_to_i_itlval(start):
    controller = start(SP_INT=1.0)
    got = controller.record("LMN_I", "LMN", calls=3, I_ITL_ON=[1, 1, 0], I_ITLVAL=[30.0, 35.0, 35.0])
    assert [i for i, _ in got] == close(30.0, 35.0, 35.1)
    assert [lmn for _, lmn in got] == close(32.0, 37.0, 37.1)


def test_i_itl_on_works_in_manual_mode_too(start):
    controller = start(MAN_ON=1, MAN=40.0, I_ITL_ON=1, I_ITLVAL=25.0)
    controller.record("LMN", calls=3)
    assert (controller["LMN"], controller["LMN_I"]) == (40.0, 25.0)


def test_int_hold_freezes_the_integral(start):
    controller = start(SP_INT=1.0)
    got = controller.record("LMN_I", calls=5, INT_HOLD=[0, 0, 1, 1, 0])
    assert got == real(0.05, 0.15, 0.15, 0.15, 0.25)


def test_i_sel_off_sets_the_integral_to_0(start):
    controller = start(SP_INT=1.0, I_ITLVAL=20.0)
    got = controller.record("LMN_I", calls=3, I_SEL=[1, 0, 1])
    assert got == close(20.05, 0.0, 0.1)


# --- Restart ----------------------------------------------------------------------------------------

OUTPUTS = ["LMN", "LMN_PER", "QLMN_HLM", "QLMN_LLM", "LMN_P", "LMN_I", "LMN_D", "PV", "ER"]


def test_com_rst_sets_all_outputs_to_0(start):
    controller = start(SP_INT=30.0, PV_IN=5.0, D_SEL=1, LMN_HLM=40.0, MAN=10.0, LMN_OFF=3.0)
    controller.record("LMN", calls=3)
    assert 0 not in set(controller.get(["LMN", "LMN_PER", "QLMN_HLM", "LMN_P", "LMN_I", "PV", "ER"]).values())
    controller.step(COM_RST=1)
    assert set(controller.get(OUTPUTS).values()) == {0}


def test_after_com_rst_the_integral_starts_at_i_itlval(start):
    controller = start(SP_INT=1.0, I_ITLVAL=30.0)
    assert controller.record("LMN_I", calls=4, COM_RST=[0, 1, 1, 0]) == close(30.05, 0.0, 0.0, 30.05)


def test_a_manual_call_after_the_restart_overwrites_i_itlval(start):
    controller = start(MAN_ON=1, MAN=12.0, I_ITLVAL=30.0)
    assert controller.record("LMN_I", calls=3, MAN_ON=[1, 1, 0]) == [0.0, 12.0, 12.0]


def test_com_rst_is_not_taken_back_by_the_block(start):
    controller = start(SP_INT=10.0, COM_RST=1)
    assert controller.record("LMN", calls=3) == [0.0, 0.0, 0.0]
    assert controller["COM_RST"] == 1


def test_com_rst_makes_the_controller_as_new(start):
    settings = {"SP_INT": 3.0, "D_SEL": 1, "I_ITLVAL": 5.0}
    used, new = start(**settings), start(**settings)
    used.record("LMN", calls=7, PV_IN=[1.0, -4.0, 2.0, 50.0, -30.0, 0.0, 1.0])
    used.step(COM_RST=1, PV_IN=0.0)
    used.set(COM_RST=0)
    names = OUTPUTS
    assert used.record(*names, calls=20) == new.record(*names, calls=20)


# --- Manipulated value -----------------------------------------------------------------------------


def test_disv_is_added_to_the_manipulated_value(start):
    controller = start(I_SEL=0, SP_INT=10.0)
    assert controller.record("LMN", calls=3, DISV=[0.0, 15.0, -5.0]) == [20.0, 35.0, 15.0]


def test_disv_is_limited_with_the_rest(start):
    controller = start(I_SEL=0, SP_INT=10.0, DISV=90.0)
    assert controller.record("LMN", "QLMN_HLM", calls=1) == [(100.0, 1)]


def test_lmn_fac_and_lmn_off_normalize_behind_the_limits(start):
    controller = start(I_SEL=0, GAIN=1.0, LMN_FAC=0.5, LMN_OFF=20.0)
    got = controller.record("LMN", "QLMN_HLM", calls=3, SP_INT=[0.0, 50.0, 150.0])
    assert got == [(20.0, 0), (45.0, 0), (70.0, 1)]


@pytest.mark.parametrize(
    "lmn, per", [(1.0, 276), (12.5, 3456), (50.0, 13824), (100.0, 27648), (118.0, 32625), (-100.0, -27648)]
)
def test_lmn_per_is_lmn_in_parts_of_27648(start, lmn, per):
    controller = start(MAN_ON=1, MAN=lmn, LMN_HLM=200.0, LMN_LLM=-200.0)
    assert controller.record("LMN_PER", calls=1) == [per]


@pytest.mark.parametrize(
    "lmn, per",
    [(117.59, 32511), (118.515, 32767), (118.52, -32768), (150.0, -24064), (1e9, -16644)],
)
def test_lmn_per_wraps_beyond_118_5_percent(start, lmn, per):
    """Nothing clips the word; of a number that fits no 32-bit integer the low bits are left."""
    controller = start(MAN_ON=1, MAN=lmn, LMN_HLM=1e10, LMN_LLM=-1e10)
    assert controller.record("LMN_PER", calls=1) == [per]


def test_lmn_per_follows_lmn_fac_and_lmn_off(start):
    controller = start(MAN_ON=1, MAN=50.0, LMN_FAC=0.5, LMN_OFF=-50.0)
    assert controller.record("LMN_PER", calls=1) == [-6912]


# --- In FMPy, as its own functions run it -----------------------------------------------------------


@host.in_fmpy
def test_simulate_fmu_runs_with_its_own_defaults(open_fmu):
    result = fmpy.simulate_fmu(str(open_fmu("CONT_C").path))
    assert len(result) > 1
    assert set(result["LMN"]) == {0.0}


@host.in_fmpy
def test_simulate_fmu_gives_the_closed_form(open_fmu):
    """Step of the setpoint between the calls at 1 s and 2 s; the output at a point is that of the call one CYCLE
    earlier. FMPy makes a step to the event and one from there on."""
    signals = np.array([(0.0, 0.0), (1.5, 0.0), (1.5, 1.0)], dtype=[("time", "f8"), ("SP_INT", "f8")])
    result = fmpy.simulate_fmu(
        str(open_fmu("CONT_C").path),
        stop_time=6.0,
        output_interval=1.0,
        start_values={"MAN_ON": False, "LMN_LLM": -100.0},
        input=signals,
        output=["LMN"],
    )
    lmn = dict(zip(result["time"], result["LMN"]))
    assert [lmn[t] for t in range(7)] == real(0.0, 0.0, 0.0, 2.05, 2.15, 2.25, 2.35)


@host.in_fmpy
def test_simulate_fmu_with_long_steps_calls_the_block_every_cycle(open_fmu):
    result = fmpy.simulate_fmu(
        str(open_fmu("CONT_C").path),
        stop_time=100.0,
        output_interval=50.0,
        start_values={"MAN_ON": False, "SP_INT": 1.0, "TI": 100.0},
        output=["LMN_I"],
    )
    assert list(result["LMN_I"]) == pytest.approx([0.0, 2 * 49.5 / 100, 2 * 99.5 / 100], rel=1e-5)
