"""What a tape cannot say of the FMUs of the manuals' blocks: the mean of their pulses, the manual's characteristics, what is
refused, and how FMPy's own functions run them."""

import re

import fmpy
import numpy as np
import pytest

import figures
import host
import signals
from host import real


@pytest.fixture
def generator(open_fmu):
    """Starts a PULSEGEN with periods of ten calls of 100 ms and no minimum pulse, unless told otherwise."""

    def start(**values):
        return open_fmu("PULSEGEN").start(**{"CYCLE": 0.1, "PER_TM": 1.0, "P_B_TM": 0.0, **values})

    return start


@pytest.fixture
def example(open_fmu):
    """Starts a PULS_CTR with periods of ten calls of 100 ms, no minimum pulse and the P action alone with GAIN 1."""
    settings = {"CYCLE": 0.1, "RED_FAC": 10, "DI_PULSEGEN.P_B_TM": 0.0, "DI_CONT_C.I_SEL": 0, "DI_CONT_C.GAIN": 1.0}

    def start(**values):
        return open_fmu("PULS_CTR").start(**{**settings, **values})

    return start


# --- The mean of the pulses over a communication step ------------------------------------------------


def test_the_mean_of_cont_s_is_the_share_of_up_less_that_of_down(open_fmu):
    controller = open_fmu("CONT_S").start(SP_INT=11.0)
    controller.step(12.0)  # six calls up, six at rest
    assert controller["QLMN_MEAN"] == 50.0
    controller.step(1.0, COM_RST=1)
    assert controller["QLMN_MEAN"] == 0.0
    controller = open_fmu("CONT_S").start(SP_INT=-6.0)
    controller.step(4.0)  # three calls down, one at rest
    assert controller["QLMN_MEAN"] == -75.0


def test_with_three_steps_the_mean_counts_negative_pulses_negative(generator):
    pulses = generator(INV=-30.0)
    pulses.step(1.0)
    assert pulses["Q_MEAN"] == -30.0


def test_with_two_steps_the_mean_is_the_share_of_qpos_p(generator):
    """QNEG_P is no pulse of its own there: the mean goes from 0 to +100."""
    for inv, bipolar, mean in ((30.0, 0, 30.0), (-100.0, 1, 0.0)):
        pulses = generator(STEP3_ON=0, ST2BI_ON=bipolar, INV=inv)
        pulses.step(1.0)
        assert pulses["Q_MEAN"] == mean


def test_after_a_restart_the_mean_is_0(generator):
    assert generator(INV=100.0).record("Q_MEAN", calls=3, COM_RST=[0, 1, 0]) == [100.0, 0.0, 100.0]


def test_the_mean_of_puls_ctr_counts_the_negative_pulses_inside(example):
    controller = example(SP_INT=-30.0, **{"DI_CONT_C.LMN_LLM": -100.0})
    controller.step(1.0)
    controller.step(1.0)
    assert controller["Q_MEAN"] == -30.0


def test_by_default_puls_ctr_does_what_the_manual_says(open_fmu):
    """2 s and 10 ms, controller in automatic and on PV_PER: it reacts to the setpoint by itself."""
    controller = open_fmu("PULS_CTR").start(SP_INT=20.0)
    assert controller["CYCLE"] * controller["RED_FAC"] == 2.0
    controller.step(2.0)
    assert controller["DI_CONT_C.LMN_P"] == 40.0
    controller.step(2.0)
    assert controller["Q_MEAN"] == 42.0  # LMN_P 40 and LMN_I (2 s / 20 s) 40 / 2


@pytest.mark.parametrize("ratio", [10, 20, 100, 200])
def test_the_accuracy_is_one_part_in_the_sampling_ratio(generator, ratio):
    """With ten calls a period INV comes out in steps of 10 %, with 100 calls of 1 %."""
    step = 100 / ratio
    for tenths in range(0, 1001, 7):
        inv = tenths / 10
        pulses = generator(INV=inv, PER_TM=ratio * 0.1)
        pulses.step(ratio * 0.1)
        mean = pulses["Q_MEAN"]
        assert abs(mean - inv) <= step / 2 + 1e-5
        assert round(mean / step, 6) == round(mean / step)


# --- The characteristics of the manual's figures ------------------------------------------------------


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


# --- Minimum times -----------------------------------------------------------------------------------


def test_the_minimum_times_of_cont_s_hold_in_automatic_mode(open_fmu):
    """Random setpoints: no pulse and no break is shorter, but at the ends of the run."""
    letters = {(0, 0): ".", (1, 0): "U", (0, 1): "D"}
    for cycle, pulse_tm, break_tm in ((1.0, 3.0, 4.0), (0.1, 0.5, 0.2), (0.5, 2.0, 2.0)):
        fmu = open_fmu("CONT_S")
        controller = fmu.start(CYCLE=cycle, PULSE_TM=pulse_tm, BREAK_TM=break_tm, MTR_TM=20 * cycle)
        setpoints = [row["SP_INT"] for row in signals.rows(fmu, 2000)]
        pattern = "".join(letters[pair] for pair in controller.record("QLMNUP", "QLMNDN", calls=2000, SP_INT=setpoints))
        assert "UD" not in pattern and "DU" not in pattern
        for letter, shortest in (("U", pulse_tm), ("D", pulse_tm), (".", break_tm)):
            lengths = [len(run) for run in re.findall(f"{re.escape(letter)}+(?=[^{letter}])", pattern.lstrip("."))]
            assert len(lengths) > 20
            assert min(lengths) * cycle >= shortest


# --- What is refused ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "values, words",
    [
        ({"RED_FAC": 0}, ["RED_FAC", "0"]),
        ({"RED_FAC": -1}, ["RED_FAC", "-1"]),
        ({"RED_FAC": 32767, "CYCLE": 65.54}, ["RED_FAC", "32767", "CYCLE", "65.54"]),
        ({"RED_FAC": 2, "CYCLE": 1073741.824}, ["RED_FAC", "CYCLE", "1073741.824"]),
    ],
)
def test_a_sampling_time_that_is_none_is_refused_at_the_end_of_initialization(open_fmu, values, words):
    controller = open_fmu("PULS_CTR").instance()
    with pytest.raises(host.Refused) as refusal:
        controller.start(**values)
    assert refusal.value.function == "fmi2ExitInitializationMode"
    assert refusal.value.status == host.ERROR
    for word in words:
        assert word in refusal.value.messages[0]
    controller.set(RED_FAC=10, CYCLE=0.1)
    controller.do("fmi2ExitInitializationMode")


def test_the_longest_sampling_time_is_taken(open_fmu):
    open_fmu("PULS_CTR").start(RED_FAC=32767, CYCLE=65.538)


# --- In FMPy, as its own functions run it -------------------------------------------------------------


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
