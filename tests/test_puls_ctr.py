"""PULS_CTR, the manual's example of section 3.4: CONT_C every RED_FAC calls, PULSEGEN in every call.

Unless told otherwise: ten calls of 100 ms a period, pulses without a minimum, P action alone with GAIN 1,
so that LMN is SP_INT less the process value. `pulses` writes one letter a call: P for QPOS_P, a dot for none.
"""

import pytest

import host

PERIOD = {"CYCLE": 0.1, "RED_FAC": 10, "DI_PULSEGEN.P_B_TM": 0.0}
P_ACTION = {"DI_CONT_C.I_SEL": 0, "DI_CONT_C.GAIN": 1.0}


@pytest.fixture
def start(open_fmu):
    def start(**values):
        return open_fmu("PULS_CTR").start(**{**PERIOD, **P_ACTION, **values})

    return start


def pulses(controller, calls, output="QPOS_P", **sequences):
    return "".join("P" if on else "." for on in controller.record(output, calls=calls, **sequences))


# --- The calls ----------------------------------------------------------------------------------------


def test_after_a_restart_the_controller_first_runs_in_call_red_fac(start):
    """Its LMN is pulsed from the next call on, which begins a period."""
    controller = start(SP_INT=30.0)
    got = controller.record("DI_CONT_C.LMN", calls=25)
    assert got == [0.0] * 9 + [30.0] * 16


def test_the_controller_then_runs_every_red_fac_calls(start):
    controller = start()
    setpoints = [float(call) for call in range(1, 36)]
    got = controller.record("DI_CONT_C.LMN", calls=35, SP_INT=setpoints)
    assert got == [0.0] * 9 + [10.0] * 10 + [20.0] * 10 + [30.0] * 6


def test_lmn_is_pulsed_in_the_period_after_the_controllers_call(start):
    assert pulses(start(SP_INT=30.0), 30) == "." * 10 + "PPP......." * 2


def test_a_new_setpoint_comes_out_one_period_later(start):
    """The controller runs in the last call of a period, when it is too late to synchronize."""
    controller = start()
    got = pulses(controller, 40, SP_INT=[30.0] * 15 + [70.0] * 25)
    assert got == "." * 10 + "PPP......." + "PPPPPPP..." * 2


@pytest.mark.parametrize("red_fac", [1, 2, 5, 200])
def test_the_pulse_period_is_cycle_times_red_fac(start, red_fac):
    """50 % of RED_FAC calls; of a single call the half is rounded to none."""
    controller = start(SP_INT=50.0, RED_FAC=red_fac)
    pulses(controller, red_fac)
    on = {1: 0, 5: 2}.get(red_fac, red_fac // 2)
    assert pulses(controller, 3 * red_fac) == 3 * ("P" * on + "." * (red_fac - on))


def test_the_controller_computes_with_cycle_times_red_fac(start):
    """T = 1 s, TI = 20 s: the I action of the first two calls, as in CONT_C."""
    controller = start(SP_INT=1.0, **{"DI_CONT_C.I_SEL": 1, "DI_CONT_C.TI": 20.0})
    got = controller.record("DI_CONT_C.LMN_I", calls=20)
    assert (got[9], got[19]) == (host.real(0.025), host.real(0.075))
    assert controller["DI_CONT_C.CYCLE"] == controller["DI_PULSEGEN.PER_TM"] == 1.0
    assert controller["DI_PULSEGEN.CYCLE"] == 0.1


def test_the_process_value_comes_in_peripheral_format(start):
    controller = start(SP_INT=80.0, PV_PER=13824)
    assert controller.record("DI_CONT_C.PV", "DI_CONT_C.LMN", calls=10)[-1] == (50.0, 30.0)


def test_by_default_the_example_does_what_the_manual_says(open_fmu):
    """2 s and 10 ms, controller in automatic and on PV_PER: it reacts to the setpoint by itself."""
    controller = open_fmu("PULS_CTR").start(SP_INT=20.0)
    assert controller["CYCLE"] * controller["RED_FAC"] == 2.0
    controller.step(2.0)
    assert controller["DI_CONT_C.LMN_P"] == 40.0
    controller.step(2.0)
    assert controller["Q_MEAN"] == 42.0  # LMN_P 40 and LMN_I (2 s / 20 s) 40 / 2


# --- Restart ------------------------------------------------------------------------------------------


def test_com_rst_restarts_both_blocks_and_the_counter(start):
    controller = start(SP_INT=30.0)
    got = pulses(controller, 45, COM_RST=[0] * 12 + [1, 1] + [0] * 31)
    assert got == "." * 10 + "PP" + ".." + "." * 9 + "." + "PPP......." * 2 + "P"


def test_com_rst_sets_the_outputs_to_0(start):
    controller = start(SP_INT=100.0)
    controller.record("QPOS_P", calls=11)
    assert controller["QPOS_P"] == 1
    controller.step(COM_RST=1)
    inner = ["DI_CONT_C.LMN", "DI_CONT_C.ER", "DI_PULSEGEN.QPOS_P", "DI_PULSEGEN.QNEG_P"]
    assert set(controller.get(["QPOS_P", "Q_MEAN", *inner]).values()) == {0}


def test_while_com_rst_is_set_every_call_is_a_restart(start):
    controller = start(SP_INT=100.0, COM_RST=1)
    assert pulses(controller, 30) == "." * 30
    controller.set(COM_RST=0)
    assert pulses(controller, 12) == "." * 10 + "PP"


def test_com_rst_makes_the_block_as_new(start):
    settings = {"DI_CONT_C.I_SEL": 1, "SP_INT": 7.0}
    used, new = start(**settings), start(**settings)
    pulses(used, 57, SP_INT=[90.0] * 57)
    used.step(COM_RST=1, SP_INT=7.0)
    used.set(COM_RST=0)
    names = ["QPOS_P", "DI_CONT_C.LMN", "DI_CONT_C.LMN_I"]
    assert used.record(*names, calls=100) == new.record(*names, calls=100)


# --- The nested instances ------------------------------------------------------------------------------


def test_every_setting_of_the_controller_inside_acts(start):
    controller = start(
        SP_INT=50.0, **{"DI_CONT_C.GAIN": 3.0, "DI_CONT_C.LMN_HLM": 90.0, "DI_CONT_C.DISV": -100.0}
    )
    assert controller.record("DI_CONT_C.LMN", calls=10)[-1] == 50.0


def test_manual_mode_of_the_controller_inside(start):
    controller = start(**{"DI_CONT_C.MAN_ON": 1, "DI_CONT_C.MAN": 40.0})
    assert pulses(controller, 20) == "." * 10 + "PPPP......"


def test_a_setting_can_be_tuned_while_the_loop_runs(start):
    controller = start(SP_INT=20.0)
    pulses(controller, 15)
    controller.set(**{"DI_CONT_C.GAIN": 4.0})
    assert pulses(controller, 15) == "....." + "PPPPPPPP.."


def test_the_minimum_pulse_of_the_generator_inside(start):
    controller = start(SP_INT=30.0, **{"DI_PULSEGEN.P_B_TM": 0.4})
    assert pulses(controller, 30) == "." * 30


def test_manual_mode_of_the_generator_inside(start):
    controller = start(**{"DI_PULSEGEN.MAN_ON": 1, "DI_PULSEGEN.POS_P_ON": 1})
    assert pulses(controller, 3) == "PPP"


def test_negative_pulses_can_be_read_inside(start):
    """QNEG_P is no output of the example, and LMN needs a lower limit below 0."""
    controller = start(SP_INT=-30.0, **{"DI_CONT_C.LMN_LLM": -100.0})
    assert pulses(controller, 20, output="DI_PULSEGEN.QNEG_P") == "." * 10 + "PPP......."
    assert controller["QPOS_P"] == 0


def test_the_mean_counts_the_negative_pulses_inside(start):
    controller = start(SP_INT=-30.0, **{"DI_CONT_C.LMN_LLM": -100.0})
    controller.step(1.0)
    controller.step(1.0)
    assert controller["Q_MEAN"] == -30.0


# --- The same from two FMUs ------------------------------------------------------------------------


def test_the_pulses_equal_those_of_the_two_blocks_called_in_the_manuals_order(start, open_fmu):
    """CONT_C.fmu every RED_FAC calls, its LMN to PULSEGEN.fmu in the same call. In call 0, the restart,
    the example runs both; then the controller again in calls 10, 20 and so on."""
    whole = start(**{"DI_CONT_C.I_SEL": 1, "DI_CONT_C.TI": 5.0})
    controller = open_fmu("CONT_C").start(MAN_ON=0, PVPER_ON=1, GAIN=1.0, TI=5.0, CYCLE=1.0)
    generator = open_fmu("PULSEGEN").start(CYCLE=0.1, PER_TM=1.0, P_B_TM=0.0)
    for call in range(1, 401):
        signals = {"SP_INT": 20.0 + call % 37, "PV_PER": call * 7 % 3000}
        whole.step(**signals)
        if call % 10 == 0:
            controller.step(**signals)
        generator.step(INV=controller["LMN"])
        assert whole["QPOS_P"] == generator["QPOS_P"], call
        assert whole["DI_CONT_C.LMN"] == controller["LMN"], call


# --- What is refused -------------------------------------------------------------------------------------


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
