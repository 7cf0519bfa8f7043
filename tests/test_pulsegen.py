"""PULSEGEN (FB 43): one test per clause and figure of the manual.

A period is PER_TM / CYCLE calls. `pulses` writes one letter a call: P for QPOS_P, N for QNEG_P, B for both,
a dot for none.
"""

import pytest

import figures

LETTER = {(0, 0): ".", (1, 0): "P", (0, 1): "N", (1, 1): "B"}


@pytest.fixture
def start(open_fmu):
    """A generator with periods of ten calls of 100 ms and no minimum pulse, unless told otherwise."""

    def start(**values):
        return open_fmu("PULSEGEN").start(**{"CYCLE": 0.1, "PER_TM": 1.0, "P_B_TM": 0.0, **values})

    return start


def pulses(generator, calls, **sequences):
    return "".join(LETTER[pair] for pair in generator.record("QPOS_P", "QNEG_P", calls=calls, **sequences))


# --- Pulse duration ---------------------------------------------------------------------------------


def test_figure_3_3_thirty_percent_of_ten_calls_are_three(start):
    assert pulses(start(INV=30.0), 20) == "PPP.......PPP......."


def test_a_negative_input_pulses_on_the_negative_output(start):
    assert pulses(start(INV=-30.0), 20) == "NNN.......NNN......."


def test_0_is_no_pulse_and_100_percent_a_pulse_without_end(start):
    assert pulses(start(INV=0.0), 20) == "." * 20
    assert pulses(start(INV=100.0), 20) == "P" * 20
    assert pulses(start(INV=-100.0), 20) == "N" * 20


def test_the_input_is_sampled_at_the_begin_of_a_period(start):
    generator = start(SYN_ON=0)
    inv = [30.0] + [80.0] * 9 + [50.0] + [0.0] * 9
    assert pulses(generator, 20, INV=inv) == "PPP.......PPPPP....."


@pytest.mark.parametrize("per_tm, calls", [(0.2, 2), (0.5, 5), (1.0, 10), (10.0, 100)])
def test_the_period_is_per_tm(start, per_tm, calls):
    got = pulses(start(INV=50.0, PER_TM=per_tm), 3 * calls)
    on = {2: 1, 5: 2}.get(calls, calls // 2)  # 2.5 is rounded to the even 2
    assert got == 3 * ("P" * on + "." * (calls - on))


def test_halves_are_rounded_to_the_even_number_of_calls(start):
    for inv, on in ((34.0, 3), (35.0, 4), (36.0, 4), (45.0, 4), (46.0, 5)):
        assert pulses(start(INV=inv), 10).count("P") == on


@pytest.mark.parametrize("ratio", [10, 20, 100, 200])
def test_the_accuracy_is_one_part_in_the_sampling_ratio(start, ratio):
    """With ten calls a period INV comes out in steps of 10 %, with 100 calls of 1 %."""
    step = 100 / ratio
    for tenths in range(0, 1001, 7):
        inv = tenths / 10
        generator = start(INV=inv, PER_TM=ratio * 0.1)
        generator.step(ratio * 0.1)
        mean = generator["Q_MEAN"]
        assert abs(mean - inv) <= step / 2 + 1e-5
        assert round(mean / step, 6) == round(mean / step)


# --- Minimum pulse and break ------------------------------------------------------------------------


def width(generator, output):
    return pulses(generator, 10).count(output)


@pytest.mark.parametrize("inv, on", [(19.99, 0), (20.0, 2), (25.0, 2), (75.0, 8), (80.0, 8), (80.01, 10)])
def test_pulses_and_breaks_shorter_than_p_b_tm_are_left_out(start, inv, on):
    assert width(start(P_B_TM=0.2, INV=inv), "P") == on
    assert width(start(P_B_TM=0.2, INV=-inv), "N") == on


def test_a_p_b_tm_above_half_the_period_leaves_only_off_and_on(start):
    got = {inv: width(start(P_B_TM=0.6, INV=inv), "P") for inv in (30.0, 39.0, 41.0, 50.0, 61.0)}
    assert got == {30.0: 0, 39.0: 0, 41.0: 10, 50.0: 10, 61.0: 10}


# --- The characteristics, swept ---------------------------------------------------------------------


@pytest.mark.parametrize("figure", figures.CHARACTERISTICS)
def test_the_characteristic_of_the_figure(open_fmu, figure):
    """INV from -110 to 110 in steps of 0.5: the mean of one period for each, as in the reference file,
    which is computed from the manual's formulas."""
    settings = figures.CHARACTERISTICS[figure]
    generator = open_fmu("PULSEGEN").instance()
    got = []
    for inv in figures.SWEEP:
        generator.do("fmi2Reset")
        generator.start(**settings, INV=inv)
        generator.step(settings["PER_TM"])
        got.append((inv, generator["Q_MEAN"]))
    assert got == figures.read(figure)


@pytest.mark.parametrize("figure", figures.CHARACTERISTICS)
def test_the_reference_of_a_figure_is_what_the_manuals_formulas_give(figure):
    assert figures.read(figure) == figures.characteristic(figures.CHARACTERISTICS[figure])
    assert len(figures.read(figure)) == 441


def test_the_mean_of_a_characteristic_is_that_of_the_pulses(open_fmu):
    settings = figures.CHARACTERISTICS["figure_3_7"]
    calls = round(settings["PER_TM"] / settings["CYCLE"])
    reference = dict(figures.read("figure_3_7"))
    for inv in (-110.0, -60.5, -20.0, 0.0, 33.5, 95.0):
        got = pulses(open_fmu("PULSEGEN").start(**settings, INV=inv), calls)
        assert 100 * (got.count("P") - got.count("N")) / calls == reference[inv]


# --- Ratio factor -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "inv, negative, positive", [(-19.0, 0, 0), (-20.0, 1, 0), (-80.0, 4, 0), (-80.01, 5, 0), (50.0, 0, 5)]
)
def test_a_ratio_factor_below_1_shortens_negative_pulses_and_their_minimum(start, inv, negative, positive):
    got = pulses(start(P_B_TM=0.2, RATIOFAC=0.5, INV=inv), 10)
    assert (got.count("N"), got.count("P")) == (negative, positive)


@pytest.mark.parametrize("inv, negative, positive", [(20.0, 0, 1), (81.0, 0, 5), (-50.0, 5, 0), (19.0, 0, 0)])
def test_a_ratio_factor_above_1_shortens_positive_pulses_and_their_minimum(start, inv, negative, positive):
    got = pulses(start(P_B_TM=0.2, RATIOFAC=2.0, INV=inv), 10)
    assert (got.count("N"), got.count("P")) == (negative, positive)


def test_the_ratio_factor_has_no_effect_with_two_steps(start):
    for two_step in (0, 1):
        plain = start(STEP3_ON=0, ST2BI_ON=two_step, INV=50.0)
        with_ratio = start(STEP3_ON=0, ST2BI_ON=two_step, INV=50.0, RATIOFAC=0.5)
        assert pulses(plain, 10) == pulses(with_ratio, 10)


# --- Two-step control --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "inv, on",
    [(-100.0, 0), (-60.01, 0), (-60.0, 2), (0.0, 5), (60.0, 8), (60.01, 10), (100.0, 10), (-150.0, 0)],
)
def test_bipolar_control_pulses_for_half_of_100_percent_plus_inv(start, inv, on):
    assert width(start(STEP3_ON=0, ST2BI_ON=1, P_B_TM=0.2, INV=inv), "P") == on


@pytest.mark.parametrize(
    "inv, on", [(-150.0, 0), (-50.0, 0), (0.0, 0), (10.0, 0), (20.0, 2), (80.0, 8), (81.0, 10), (100.0, 10)]
)
def test_monopolar_control_pulses_for_inv_percent(start, inv, on):
    assert width(start(STEP3_ON=0, ST2BI_ON=0, P_B_TM=0.2, INV=inv), "P") == on


@pytest.mark.parametrize("bipolar", [0, 1])
def test_with_two_steps_qneg_p_is_the_opposite_of_qpos_p(start, bipolar):
    got = pulses(start(STEP3_ON=0, ST2BI_ON=bipolar, INV=30.0), 20)
    assert got == 2 * ("PPPPPPNNNN" if bipolar else "PPPNNNNNNN")


def test_st2bi_on_has_no_effect_with_three_steps(start):
    assert pulses(start(STEP3_ON=1, ST2BI_ON=1, INV=-30.0), 10) == "NNN......."


def test_with_two_steps_the_mean_is_the_share_of_qpos_p(start):
    """QNEG_P is no pulse of its own there: the mean goes from 0 to +100."""
    generator = start(STEP3_ON=0, INV=30.0)
    generator.step(1.0)
    assert generator["Q_MEAN"] == 30.0
    generator = start(STEP3_ON=0, ST2BI_ON=1, INV=-100.0)
    generator.step(1.0)
    assert generator["Q_MEAN"] == 0.0


def test_with_three_steps_the_mean_counts_negative_pulses_negative(start):
    generator = start(INV=-30.0)
    generator.step(1.0)
    assert generator["Q_MEAN"] == -30.0


# --- Manual mode ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "step3_on, pos_p_on, neg_p_on, letter",
    [
        (1, 0, 0, "."),
        (1, 1, 0, "P"),
        (1, 0, 1, "N"),
        (1, 1, 1, "."),
        (0, 0, 0, "N"),
        (0, 0, 1, "N"),
        (0, 1, 0, "P"),
        (0, 1, 1, "P"),
    ],
)
@pytest.mark.parametrize("st2bi_on", [0, 1])
@pytest.mark.parametrize("inv", [-100.0, 0.0, 30.0])
def test_the_manual_mode_table(start, step3_on, st2bi_on, pos_p_on, neg_p_on, letter, inv):
    generator = start(
        MAN_ON=1, STEP3_ON=step3_on, ST2BI_ON=st2bi_on, POS_P_ON=pos_p_on, NEG_P_ON=neg_p_on, INV=inv
    )
    assert pulses(generator, 15) == letter * 15


def test_manual_mode_acts_in_the_same_call(start):
    generator = start(INV=30.0, NEG_P_ON=1)
    assert pulses(generator, 4, MAN_ON=[0, 1, 1, 1]) == "PNNN"


def test_after_manual_mode_a_period_starts(start):
    generator = start(INV=30.0)
    assert pulses(generator, 18, MAN_ON=[0] * 5 + [1] * 3 + [0] * 10) == "PPP.....PPP......."


# --- Synchronization ----------------------------------------------------------------------------------

# The old pulse of 30 % and, from call m on, INV = 80 %: the call from which the new period counts.
NEW_PERIOD = {0: 0, 1: 2, 2: 3, 3: 4, 4: 5, 5: 6, 6: 7, 7: 8, 8: 10, 9: 10}


@pytest.mark.parametrize("m", range(10))
def test_figure_3_5_a_change_of_inv_starts_a_new_period(start, m):
    """Not in the first and in the last two calls of a period."""
    begin = NEW_PERIOD[m]
    inv = [30.0] * m + [80.0] * (30 - m)
    expected = "PPP.......PPP......."[:begin] + "PPPPPPPP.." * 3
    assert pulses(start(), 30, INV=inv) == expected[:30]


@pytest.mark.parametrize("m", range(10))
def test_without_syn_on_a_change_of_inv_waits_for_the_end_of_the_period(start, m):
    inv = [30.0] * m + [80.0] * (30 - m)
    first = "PPPPPPPP.." if m == 0 else "PPP......."
    assert pulses(start(SYN_ON=0), 30, INV=inv) == first + "PPPPPPPP.." * 2


def test_an_inv_that_stays_does_not_synchronize(start):
    assert pulses(start(INV=30.0), 30) == "PPP......." * 3


def test_an_inv_that_changes_in_every_call_makes_periods_of_two_calls(start):
    """30 % and a bit: always on. INV should change once a period."""
    inv = [30.0 + call / 100 for call in range(20)]
    assert pulses(start(), 20, INV=inv) == "P" * 20


def test_synchronization_works_with_two_steps_and_negative_pulses_too(start):
    assert pulses(start(STEP3_ON=0), 14, INV=[30.0] * 4 + [80.0] * 10) == "PPPNN" + "PPPPPPPPN"
    assert pulses(start(), 14, INV=[-30.0] * 4 + [80.0] * 10) == "NNN.." + "PPPPPPPP."


# --- Restart --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("step3_on", [0, 1])
def test_com_rst_sets_both_outputs_to_0_in_every_mode(start, step3_on):
    generator = start(STEP3_ON=step3_on, INV=100.0)
    assert pulses(generator, 4, COM_RST=[0, 1, 1, 0]) == "P..P"


def test_after_com_rst_a_period_starts(start):
    generator = start(INV=30.0)
    assert pulses(generator, 16, COM_RST=[0] * 5 + [1] + [0] * 10) == "PPP..." + "PPP......."


def test_com_rst_comes_before_manual_mode(start):
    generator = start(MAN_ON=1, POS_P_ON=1)
    assert pulses(generator, 3, COM_RST=[0, 1, 0]) == "P.P"


def test_after_a_restart_the_mean_is_0(start):
    generator = start(INV=100.0)
    assert generator.record("Q_MEAN", calls=3, COM_RST=[0, 1, 0]) == [100.0, 0.0, 100.0]


# --- Parameters are not checked ----------------------------------------------------------------------


def test_inv_beyond_100_percent_is_always_on(start):
    assert pulses(start(INV=150.0), 10) == "P" * 10
    assert pulses(start(INV=-150.0), 10) == "N" * 10


def test_a_period_shorter_than_a_cycle_goes_on(start):
    generator = start(PER_TM=0.0, INV=100.0)
    generator.record("QPOS_P", calls=20)
    generator.set(PER_TM=1.0, INV=30.0)
    assert pulses(generator, 22)[-20:].count("P") == 6
