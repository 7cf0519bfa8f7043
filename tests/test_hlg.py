"""HLG, the ramp function generator of ABB's Serie90 library: one test per clause.

The output starts at 0, the set point is S0 unless told otherwise, and N is TH_TZ or TR_TZ, the number of
calls in which the output moves by the amount of the set point.
"""

import pytest


@pytest.fixture
def start(open_fmu):
    def start(**values):
        return open_fmu("HLG").start(**values)

    return start


def ramp(generator, calls, **sequences):
    return generator.record("HLG", calls=calls, **sequences)


def at(start, value, **values):
    """A generator whose output stands at a value."""
    generator = start(**values)
    generator.step(SET=1, INIT=value)
    generator.set(SET=0)
    return generator


# --- The ramp -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "set_point, n, expected",
    [
        (10, 4, [2, 5, 7, 10, 10]),
        (10, 3, [3, 6, 10, 10]),
        (3, 7, [0, 0, 1, 1, 2, 2, 3, 3]),
        (10, 1, [10, 10]),
        (1, 5, [0, 0, 0, 0, 1, 1]),
        (1000, 5, [200, 400, 600, 800, 1000, 1000]),
    ],
)
def test_from_0_the_set_point_is_reached_in_exactly_n_calls(start, set_point, n, expected):
    assert ramp(start(S0=set_point, TH_TZ=n), len(expected)) == expected
    assert ramp(start(S0=-set_point, TR_TZ=n), len(expected)) == [-value for value in expected]


@pytest.mark.parametrize("set_point", [1, 2, 7, 100, 9999, 32767])
@pytest.mark.parametrize("n", [1, 2, 3, 10, 97, 1000])
def test_the_last_step_of_any_ramp_from_0_is_call_n(start, set_point, n):
    got = ramp(start(S0=set_point, TH_TZ=n), n + 1)
    assert got[-2:] == [set_point, set_point]
    assert n == 1 or got[-3] < set_point
    assert got == sorted(got)


def test_the_slope_is_the_amount_of_the_set_point_by_the_time_not_the_distance(start):
    """From 1000 to -500 with N = 5: 100 a call, so 15 calls."""
    generator = at(start, 1000, S0=-500, TR_TZ=5)
    got = ramp(generator, 16)
    assert got == [1000 - 100 * call for call in range(1, 16)] + [-500]


def test_th_counts_upwards_and_tr_downwards(start):
    generator = start(TH_TZ=10, TR_TZ=2)
    assert ramp(generator, 3, S0=[100, 100, 100]) == [10, 20, 30]
    assert ramp(generator, 3, S0=[20, 20, 20]) == [20, 20, 20]
    assert ramp(generator, 2, S0=[-20, -20]) == [10, 0]


def test_the_direction_is_that_to_the_set_point_not_its_sign(start):
    """From -100 up to -50: TH counts, 50 / 5 a call. From 100 down to 50: TR."""
    assert ramp(at(start, -100, S0=-50, TH_TZ=5, TR_TZ=1), 6) == [-90, -80, -70, -60, -50, -50]
    assert ramp(at(start, 100, S0=50, TH_TZ=1, TR_TZ=5), 6) == [90, 80, 70, 60, 50, 50]


def test_at_the_set_point_the_output_stays(start):
    generator = start(S0=10, TH_TZ=2)
    assert ramp(generator, 10) == [5] + [10] * 9


def test_the_output_never_passes_the_set_point(start):
    assert ramp(at(start, 95, S0=100, TH_TZ=10), 2) == [100, 100]


def test_set_point_0_means_slope_0(start):
    """The output stays where it is, it does not go to 0."""
    generator = at(start, 77, TH_TZ=1, TR_TZ=1)
    assert ramp(generator, 5) == [77] * 5


def test_a_time_of_0_jumps(start):
    generator = start()
    assert ramp(generator, 3, S0=[500, -500, 32767]) == [500, -500, 32767]


@pytest.mark.parametrize("time", [-1, -32768])
def test_a_negative_time_jumps_too(start, time):
    generator = start(TH_TZ=time, TR_TZ=time)
    assert ramp(generator, 2, S0=[500, -500]) == [500, -500]


# --- The remainder ------------------------------------------------------------------------------------


def test_the_remainder_of_the_division_is_kept_from_call_to_call(start):
    """10 / 4 = 2.5: the halves of two calls make one."""
    assert ramp(start(S0=10, TH_TZ=4), 2) == [2, 5]


def test_a_new_set_point_begins_without_a_remainder(start):
    """10 / 4 leaves 2; 11 / 4 = 2 leaves 3, and not 2 + 3 which would make 3 of it."""
    generator = start(TH_TZ=4)
    assert ramp(generator, 2, S0=[10, 11]) == [2, 4]


def test_a_new_time_begins_without_a_remainder(start):
    """10 / 4 leaves 2; 10 / 6 = 1 leaves 4, where 12 / 6 would be 2."""
    assert ramp(start(S0=10), 2, TH_TZ=[4, 6]) == [2, 3]


def test_stop_keeps_the_remainder(start):
    assert ramp(start(S0=10, TH_TZ=4), 6, STOP=[0, 1, 1, 0, 0, 0]) == [2, 2, 2, 5, 7, 10]


@pytest.mark.parametrize("pin", ["SET", "R"])
def test_set_and_r_clear_the_remainder(start, pin):
    generator = start(S0=10, TH_TZ=4)
    assert ramp(generator, 6, **{pin: [0, 1, 0, 0, 0, 0]}) == [2, 0, 2, 5, 7, 10]


def test_arrival_clears_the_remainder(start):
    """10 of 15 in 4 calls leaves 2 at arrival; back from 0 the same ramp is as the first."""
    generator = start(TH_TZ=4, S0=10)
    assert ramp(generator, 4) == [2, 5, 7, 10]
    assert ramp(generator, 1, R=[1]) == [0]
    generator.set(R=0)
    assert ramp(generator, 4) == [2, 5, 7, 10]


# --- Set point selection ---------------------------------------------------------------------------


def test_e01_selects_s0_or_s1(start):
    generator = start(S0=100, S1=200)
    assert ramp(generator, 3, E01=[0, 1, 0]) == [100, 200, 100]


def test_the_set_point_can_change_at_any_time(start):
    generator = start(TH_TZ=10)
    assert ramp(generator, 4, S0=[100, 200, 50, 400]) == [10, 30, 35, 75]


# --- STOP, SET, R ------------------------------------------------------------------------------------


def test_stop_holds_the_output(start):
    generator = start(S0=100, TH_TZ=10)
    assert ramp(generator, 5, STOP=[0, 1, 1, 0, 0]) == [10, 10, 10, 20, 30]


def test_set_makes_the_output_init(start):
    generator = start(S0=100, TH_TZ=10)
    assert ramp(generator, 4, SET=[0, 1, 0, 0], INIT=[0, 55, 55, 55]) == [10, 55, 65, 75]


def test_r_makes_the_output_0(start):
    generator = start(S0=100, TH_TZ=10)
    assert ramp(generator, 4, R=[0, 0, 1, 0]) == [10, 20, 0, 10]


@pytest.mark.parametrize(
    "stop, set, r, expected",
    [
        (1, 1, 1, 40),
        (1, 1, 0, 40),
        (1, 0, 1, 40),
        (1, 0, 0, 40),
        (0, 1, 1, 7),
        (0, 1, 0, 7),
        (0, 0, 1, 0),
        (0, 0, 0, 50),
    ],
)
def test_stop_goes_before_set_and_set_before_r(start, stop, set, r, expected):
    generator = at(start, 40, S0=100, TH_TZ=10)
    assert ramp(generator, 1, STOP=[stop], SET=[set], R=[r], INIT=[7]) == [expected]


# --- Extremes ----------------------------------------------------------------------------------------


def test_from_end_to_end(start):
    assert ramp(at(start, -32767, S0=32767, TH_TZ=2), 5) == [-16384, 0, 16383, 32767, 32767]


def test_from_end_to_end_downwards(start):
    assert ramp(at(start, 32767, S0=-32767, TR_TZ=1), 3) == [0, -32767, -32767]


@pytest.mark.parametrize("pin", ["S0", "S1", "INIT"])
def test_minus_32768_counts_as_minus_32767(start, pin):
    generator = start(E01=pin == "S1", SET=pin == "INIT")
    assert ramp(generator, 2, **{pin: [-32768, -32768]}) == [-32767, -32767]


def test_the_slowest_ramp(start):
    """1 in 32767 calls."""
    generator = start(S0=1, TH_TZ=32767)
    generator.step(32766 * 0.01)
    assert generator["HLG"] == 0
    generator.step()
    assert generator["HLG"] == 1


def test_the_longest_ramp_is_exact(start):
    generator = start(S0=32767, TH_TZ=32766)
    generator.step(32765 * 0.01)
    assert generator["HLG"] == 32765
    generator.step()
    assert generator["HLG"] == 32767


def test_the_cycle_time_only_says_when_the_block_is_called(start):
    for tz in (0.001, 0.01, 3.0):
        assert ramp(start(S0=10, TH_TZ=4, TZ=tz), 4) == [2, 5, 7, 10]


def test_at_the_start_the_output_is_0_whatever_the_pins_are(start):
    generator = start(SET=1, INIT=99, S0=50)
    assert generator["HLG"] == 0
    assert ramp(generator, 1) == [99]
