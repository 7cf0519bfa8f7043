"""When the block is called: at start + k CYCLE, whatever the communication steps.

A step from tc to tc + h makes every call with tc <= t_k < tc + h. Each test drives every FMU with the
same held signals, once with steps of CYCLE and once otherwise, and compares all outputs bit for bit
where both have a communication point on the CYCLE grid.
"""

import ctypes
import math
import random
import re

import pytest

import host
import signals
from calls import refused
from host import MEAN

HOLD = 10  # calls for which the signals are held
SEGMENTS = 12
STARTS = [0.0, 1234.5, 1e5, 1e7]


def outputs(instance):
    """All outputs but the means, which tell of the last step and so depend on its length."""
    values = instance.outputs()
    return {name: value for name, value in values.items() if name not in MEAN.values()}


def drive(fmu, start, points, step_to):
    """Holds each row of signals for HOLD calls. `points(k)` gives the communication points, in calls,
    from call k to call k + HOLD, the last one included; `step_to(tc, time)` makes the step.
    Returns the outputs by the number of calls made."""
    instance = fmu.start(start_time=start, **signals.settings(fmu))
    cycle = instance.cycle
    seen = {0: outputs(instance)}
    for segment, row in enumerate(signals.rows(fmu, SEGMENTS)):
        instance.set(**row)
        for point in points(segment * HOLD):
            step_to(instance, start + point * cycle)
            if point == int(point):
                seen[int(point)] = outputs(instance)
    assert instance.messages == []
    return seen


def exactly(instance, time):
    """A step from the point that the last one reached."""
    instance.step(time - instance.time)
    instance.time = time


def grid(per_call):
    return lambda call: [call + i / per_call for i in range(1, HOLD * per_call + 1)]


REFERENCES = {}


def reference(fmu):
    """The outputs after every call, for steps of CYCLE from 0."""
    if fmu.name not in REFERENCES:
        REFERENCES[fmu.name] = drive(fmu, 0.0, grid(1), exactly)
        assert len(REFERENCES[fmu.name]) == HOLD * SEGMENTS + 1
    return REFERENCES[fmu.name]


def same(fmu, seen):
    expected = reference(fmu)
    for call, values in seen.items():
        assert values == expected[call], f"after {call} calls"


def test_the_signals_move_the_outputs(fmu):
    """Otherwise the tests below would compare nothing."""
    expected = reference(fmu)
    changes = sum(expected[call] != expected[call + 1] for call in range(HOLD * SEGMENTS))
    assert changes >= 4


@pytest.mark.parametrize("start", STARTS)
def test_steps_of_a_cycle(fmu, start):
    same(fmu, drive(fmu, start, grid(1), exactly))


@pytest.mark.parametrize("start", STARTS)
def test_steps_of_a_tenth_of_a_cycle(fmu, start):
    same(fmu, drive(fmu, start, grid(10), exactly))


@pytest.mark.parametrize("start", STARTS)
def test_steps_of_a_third_of_a_cycle(fmu, start):
    same(fmu, drive(fmu, start, grid(3), exactly))


@pytest.mark.parametrize("start", STARTS)
def test_steps_of_ten_cycles(fmu, start):
    seen = drive(fmu, start, lambda call: [call + HOLD], exactly)
    assert len(seen) == SEGMENTS + 1
    same(fmu, seen)


@pytest.mark.parametrize("start", STARTS)
def test_random_steps(fmu, start):
    generator = random.Random(f"{fmu.name} {start}")

    def points(call):
        inside = sorted(generator.uniform(0, HOLD) for _ in range(generator.randint(0, 12)))
        return [call + point for point in inside] + [call + HOLD]

    same(fmu, drive(fmu, start, points, exactly))


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("per_call", [1, 10])
def test_times_that_the_host_adds_up(fmu, start, per_call):
    """tc = tc + h, as most masters count: 0.01 s added a hundred times is not 1 s."""

    def add(instance, time):
        h = instance.cycle / per_call
        instance.step(h)

    same(fmu, drive(fmu, start, grid(per_call), add))


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("per_call", [1, 3])
def test_noise_on_the_communication_points(fmu, start, per_call):
    """3e-12 s to either side, in tc and in h."""
    generator = random.Random(f"{fmu.name} {start}")

    def noisy(instance, time):
        tc = instance.time + generator.uniform(-3e-12, 3e-12)
        h = time - instance.time + generator.uniform(-3e-12, 3e-12)
        instance.do("fmi2DoStep", tc, h, 1)
        instance.time = time

    same(fmu, drive(fmu, start, grid(per_call), noisy))


@pytest.mark.parametrize("start", STARTS)
def test_residual_steps_pass_and_make_no_call(fmu, start):
    """OMSimulator makes extra steps of 1e-16 s."""

    def with_residue(instance, time):
        exactly(instance, time)
        before = outputs(instance)
        for _ in range(3):
            instance.do("fmi2DoStep", instance.time, 1e-16, 1)
        assert outputs(instance) == before

    same(fmu, drive(fmu, start, grid(1), with_residue))
    same(fmu, drive(fmu, start, grid(10), with_residue))


def test_a_time_with_a_last_digit_too_many_is_no_other_time(fmu):
    """2.9500000000030000 for 2.95."""

    def longer(instance, time):
        exactly(instance, time)
        instance.time = time + 3e-12

    same(fmu, drive(fmu, 0.0, grid(1), longer))


def test_the_first_call_is_at_the_start_time(fmu):
    """A step of a thousandth of a CYCLE from the start makes it, the rest of the CYCLE no other."""
    short, long = (fmu.start(**signals.settings(fmu)) for _ in range(2))
    row = signals.rows(fmu, 1)[0]
    short.set(**row)
    long.set(**row)
    short.step(short.cycle / 1000)
    after_the_call = outputs(short)
    short.step(short.cycle * 0.999)
    long.step()
    assert after_the_call == outputs(short) == outputs(long)
    short.step(short.cycle / 1000)
    long.step()
    assert outputs(short) == outputs(long)


def test_inputs_count_as_they_are_when_the_step_begins(fmu):
    """What is set after a call waits for the next one: between them outputs hold."""
    instance = fmu.start(**signals.settings(fmu))
    first, second = signals.rows(fmu, 2)
    instance.step(instance.cycle / 2, **first)
    held = outputs(instance)
    instance.step(instance.cycle / 2, **second)
    assert outputs(instance) == held
    other = fmu.start(**signals.settings(fmu))
    other.step(**first)
    assert outputs(other) == held


# --- Counting calls ----------------------------------------------------------------------------------


@pytest.fixture
def counter(open_fmu):
    """HLG counts its calls: a ramp of 32767 in 32767 calls."""

    def start(**options):
        return open_fmu("HLG").start(S0=32767, TH_TZ=32767, **options)

    return start


@pytest.mark.parametrize("start", [0.0, 1e4, 1e5, 1e7, 1e9, -1e5])
@pytest.mark.parametrize("cycle", [0.001, 0.1])
def test_every_step_of_a_cycle_makes_one_call_at_any_start_time(counter, start, cycle):
    """A tolerance relative to |t| would make 11 calls in a step of 0.1 s at 1e5 s."""
    instance = counter(start_time=start, TZ=cycle)
    for number in range(1, 3001):
        instance.step(cycle)
        assert instance["HLG"] == number


@pytest.mark.parametrize("start", [0.0, 1e4])
@pytest.mark.parametrize("cycle", [0.001, 0.01, 0.1, 0.2])
def test_a_step_that_is_rounded_to_32_bits_makes_one_call(counter, start, cycle):
    """0.1 s is 0.10000000149 s then: a step that is taken for longer than a CYCLE makes two calls some day."""
    rounded = ctypes.c_float(cycle).value
    instance = counter(start_time=start, TZ=cycle)
    for number in range(3000):
        instance.do("fmi2DoStep", start + number * cycle, rounded, 1)
        assert instance["HLG"] == number + 1


@pytest.mark.parametrize("start", [0.0, 1e5])
@pytest.mark.parametrize("cycle", [0.001, 0.1, 3.0])
def test_steps_of_a_cycle_that_begin_between_two_calls(counter, start, cycle):
    """Half a CYCLE first: then every step has its call in the middle."""
    instance = counter(start_time=start, TZ=cycle)
    instance.step(cycle / 2)
    for number in range(1, 1000):
        assert instance["HLG"] == number
        instance.step(cycle)
    instance.step(cycle / 2)
    assert instance["HLG"] == 1000


@pytest.mark.parametrize("start", [0.0, 1e5])
def test_a_step_of_many_cycles_makes_them_all(counter, start):
    instance = counter(start_time=start, TZ=0.001)
    for calls, total in ((1, 1), (9, 10), (990, 1000), (29000, 30000)):
        instance.step(calls * 0.001)
        assert instance["HLG"] == total


def test_the_tolerance_is_a_millionth_of_a_cycle(counter):
    """A step that ends 0.5e-6 CYCLE late does not make the next call, one that ends 1e-5 CYCLE late does."""
    for late, calls in ((0.5e-6, 1), (1e-5, 2)):
        instance = counter(TZ=1.0)
        instance.step(1.0 + late)
        assert instance["HLG"] == calls


def test_a_call_is_made_in_the_step_that_begins_within_the_tolerance(counter):
    """The step that ends early by less is as good as whole: its successor makes the call, and not twice."""
    for early in (0.5e-6, 1e-5):
        instance = counter(TZ=1.0)
        instance.step(1.0 - early)
        assert instance["HLG"] == 1
        instance.step(1.0)
        assert instance["HLG"] == 2
        instance.step(early)
        assert instance["HLG"] == 2


def test_calls_and_steps_of_incommensurable_lengths(counter):
    """Steps of 0.07 s, calls every 0.03 s: after n steps ceil(7 n / 3) calls."""
    instance = counter(TZ=0.03)
    for number in range(1, 1000):
        instance.step(0.07)
        assert instance["HLG"] == -(-7 * number // 3)


# --- tc that differs from the expected one --------------------------------------------------------


def test_a_point_within_rounding_is_the_expected_one(counter):
    instance = counter(TZ=1.0)
    instance.step(1.0)
    for behind in (0.5e-6, -0.5e-6):
        instance.time -= behind
        instance.step(1.0)
        instance.time += behind
    assert instance["HLG"] == 3
    refused(instance, "fmi2DoStep", 3.0 - 1e-5, 1.0, 1)


def test_a_point_ahead_makes_up_for_the_calls_in_between(fmu):
    jumped, walked = (fmu.start(**signals.settings(fmu)) for _ in range(2))
    for instance in (jumped, walked):
        instance.set(**signals.rows(fmu, 1)[0])
    cycle = jumped.cycle
    jumped.step()
    jumped.time = 7 * cycle
    jumped.step()
    for _ in range(8):
        walked.step()
    assert outputs(jumped) == outputs(walked)


def test_a_point_behind_is_refused_with_both_points(fmu):
    instance = fmu.start(start_time=1000.0)
    instance.step()
    instance.step()
    end = 1000.0 + 2 * instance.cycle
    text = refused(instance, "fmi2DoStep", 1000.0 + instance.cycle, instance.cycle, 1)
    numbers = [float(number) for number in re.findall(r"\d+\.\d+", text)]
    assert any(math.isclose(number, end, rel_tol=1e-12) for number in numbers)
    assert any(math.isclose(number, 1000.0 + instance.cycle, rel_tol=1e-12) for number in numbers)
    instance.step()


def test_a_point_far_behind_is_refused(fmu):
    instance = fmu.start(start_time=10.0)
    instance.step()
    for tc in (10.0, 0.0, -1e9):
        refused(instance, "fmi2DoStep", tc, instance.cycle, 1)


def test_a_step_of_0_makes_no_call_and_changes_no_output(fmu):
    """PyFMI ends some runs with one."""
    for with_derivatives in (False, True):
        instance, twin = fmu.start(), fmu.start()
        if with_derivatives:
            for each in (instance, twin):
                for name in real_inputs(fmu):
                    given = host.references(fmu, [name]), 1, (ctypes.c_int * 1)(1), (ctypes.c_double * 1)(0.5)
                    each.do("fmi2SetRealInputDerivatives", *given)
        for _ in range(3):
            instance.step(0.0)
            for each in (instance, twin):
                each.step()
            before = instance.outputs()
            instance.step(0.0)
            instance.step(-0.0)
            assert instance.outputs() == before == twin.outputs()
        assert instance.content() == twin.content()


def test_a_step_of_0_at_the_stop_time_is_the_last(fmu):
    instance = fmu.instance()
    instance.start(stop_time=3 * fmu.cycle)
    for _ in range(3):
        instance.step()
    instance.do("fmi2DoStep", 3 * fmu.cycle, 0.0, 1)
    refused(instance, "fmi2DoStep", 4 * fmu.cycle, 0.0, 1, saying=["stopTime"])
    refused(instance, "fmi2DoStep", 2 * fmu.cycle, 0.0, 1)


def test_the_mean_of_a_step_of_0_is_the_held_pulse(open_fmu):
    instance = open_fmu("PULSEGEN").start(INV=30.0)
    instance.step(1.0)
    assert instance["Q_MEAN"] == 30.0
    instance.step(0.0)
    assert (instance["QPOS_P"], instance["Q_MEAN"]) == (0, 0.0)
    instance.step()
    instance.step(0.0)
    assert (instance["QPOS_P"], instance["Q_MEAN"]) == (1, 100.0)


@pytest.mark.parametrize("h", [-5e-324, -1e-9, -1.0, math.nan, math.inf, -math.inf])
def test_a_step_is_finite_and_goes_forward(fmu, h):
    instance = fmu.start()
    refused(instance, "fmi2DoStep", 0.0, h, 1, saying=["communicationStepSize"])
    instance.step()


@pytest.mark.parametrize("tc", [math.nan, math.inf, -math.inf])
def test_a_communication_point_is_finite(fmu, tc):
    instance = fmu.start()
    refused(instance, "fmi2DoStep", tc, instance.cycle, 1, saying=["currentCommunicationPoint"])


# --- Stop time -------------------------------------------------------------------------------------


@pytest.mark.parametrize("start", STARTS)
def test_a_defined_stop_time_is_reached_but_not_passed(fmu, start):
    instance = fmu.start(start_time=start, stop_time=start + 100 * fmu.cycle)
    for _ in range(100):
        instance.step()
    refused(instance, "fmi2DoStep", instance.time, instance.cycle, 1, saying=["stopTime"])


def test_a_step_over_the_stop_time_is_refused_whole(fmu):
    instance = fmu.start(stop_time=2.5 * fmu.cycle)
    instance.step()
    instance.step()
    refused(instance, "fmi2DoStep", instance.time, instance.cycle, 1, saying=["stopTime"])
    instance.step(0.5 * instance.cycle)


def test_without_a_stop_time_a_run_has_no_end(fmu):
    instance = fmu.start()
    instance.step(10_000 * instance.cycle)
    instance.step()


# --- Restart -----------------------------------------------------------------------------------------


def test_at_the_start_a_controllers_outputs_are_0_and_depend_on_nothing(controller):
    """The restart call ran, and no other yet."""
    for row in signals.rows(controller, 20):
        instance = controller.instance()
        instance.setup()
        instance.set(**row)
        instance.do("fmi2EnterInitializationMode")
        in_initialization = instance.get(controller.of("output"))
        instance.do("fmi2ExitInitializationMode")
        at_the_start = instance.get(controller.of("output"))
        assert set(in_initialization.values()) == set(at_the_start.values()) == {0}


def test_in_initialization_mode_outputs_have_their_restart_values_whatever_inputs_are_set(fmu):
    restarted = fmu.start().outputs()
    for row in signals.rows(fmu, 20):
        instance = fmu.instance()
        instance.setup()
        instance.do("fmi2EnterInitializationMode")
        instance.set(**row)
        assert instance.outputs() == restarted


def test_outputs_at_the_start_do_not_depend_on_inputs(fmu):
    starts = [fmu.start(**row).outputs() for row in signals.rows(fmu, 20)]
    assert starts.count(starts[0]) == len(starts)


def test_setting_inputs_changes_no_output_before_the_step(fmu):
    instance = fmu.start(**signals.settings(fmu))
    for row in signals.rows(fmu, 20):
        before = instance.outputs()
        instance.set(**row)
        assert instance.outputs() == before
        instance.step()


# --- Means -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name, mean", MEAN.items())
def test_a_mean_is_that_of_the_calls_of_the_step(open_fmu, name, mean):
    fmu = open_fmu(name)
    single, tenfold = (fmu.start(**signals.settings(fmu)) for _ in range(2))
    seen = set()
    for row in signals.rows(fmu, 200):
        single.set(**row)
        means = single.record(mean, calls=HOLD)
        assert set(means) <= {-100.0, 0.0, 100.0}
        tenfold.step(HOLD * tenfold.cycle, **row)
        assert tenfold[mean] == sum(means) / HOLD
        seen.add(tenfold[mean])
    assert len(seen) > 3


@pytest.mark.parametrize("name, mean", MEAN.items())
def test_in_a_step_without_a_call_the_mean_is_the_held_state(open_fmu, name, mean):
    fmu = open_fmu(name)
    instance = fmu.start(**signals.settings(fmu))
    seen = set()
    for row in signals.rows(fmu, 200):
        instance.step(instance.cycle / 2, **row)
        state = instance[mean]
        instance.step(instance.cycle / 2)
        assert instance[mean] == state
        seen.add(state)
    assert len(seen) > 1


# --- Input derivatives ------------------------------------------------------------------------------


def derivatives(instance, order, **values):
    names = list(values)
    count = len(names)
    instance.do(
        "fmi2SetRealInputDerivatives",
        host.references(instance.fmu, names),
        count,
        (ctypes.c_int * count)(*[order] * count),
        (ctypes.c_double * count)(*values.values()),
    )


def real_inputs(fmu):
    return [name for name in fmu.of("input", type="Real") if fmu.kinds[name] != "TIME"]


def within(fmu, name, share):
    """A value at this share of the range."""
    variable = fmu.variables[name]
    low = -64.0 if variable.min is None else float(variable.min)
    high = 64.0 if variable.max is None else float(variable.max)
    return low + (high - low) * share


def test_with_derivatives_each_call_sees_the_extrapolated_input(fmu):
    """u + u' t + u'' t^2 / 2 over a step of eight calls: as eight steps with that input."""
    extrapolated, computed = (fmu.start(**signals.settings(fmu)) for _ in range(2))
    cycle = extrapolated.cycle
    names = real_inputs(fmu)
    for segment, row in enumerate(signals.rows(fmu, 4)):
        u = {name: within(fmu, name, 0.25 + 0.125 * segment) for name in names}
        slope = {name: (within(fmu, name, 0.5) - within(fmu, name, 0.25)) / (8 * cycle) for name in names}
        bend = {name: slope[name] / (16 * cycle) for name in names}
        row.update(u)
        extrapolated.set(**row)
        if names:
            derivatives(extrapolated, 1, **slope)
            derivatives(extrapolated, 2, **bend)
        extrapolated.step(8 * cycle)
        for call in range(8):
            t = call * cycle
            row.update({name: u[name] + slope[name] * t + bend[name] * (t * (t / 2)) for name in names})
            computed.step(**row)
        assert outputs(extrapolated) == outputs(computed)


def test_the_input_is_extrapolated_to_the_instant_of_the_call_wherever_the_step_begins(fmu):
    """A step from a quarter of a CYCLE behind a call on: the next three calls see 3/4, 7/4 and 11/4 CYCLE of slope."""
    extrapolated, computed = (fmu.start(**signals.settings(fmu)) for _ in range(2))
    cycle = extrapolated.cycle
    row = signals.rows(fmu, 1)[0]
    u = {name: within(fmu, name, 0.5) for name in real_inputs(fmu)}
    slope = {name: (within(fmu, name, 0.75) - within(fmu, name, 0.5)) / (4 * cycle) for name in u}
    row.update(u)
    extrapolated.step(cycle / 4, **row)
    computed.step(**row)
    if u:
        derivatives(extrapolated, 1, **slope)
    extrapolated.step(3 * cycle)
    for call in range(3):
        t = (call + 0.75) * cycle
        computed.step(**{name: u[name] + slope[name] * t for name in u})
    alike(extrapolated, computed)


def alike(one, other):
    """Equal outputs, but for the last bits of an LREAL that two ways of counting the time may differ in."""
    other = other.get(other.fmu.of("output"))
    for name, value in one.get(one.fmu.of("output")).items():
        if name not in MEAN.values():
            assert value == pytest.approx(other[name], rel=1e-9), name


def test_a_derivative_of_0_takes_an_extrapolation_back(fmu):
    plain, taken_back = (fmu.start(**signals.settings(fmu)) for _ in range(2))
    row = signals.rows(fmu, 1)[0]
    names = real_inputs(fmu)
    if names:
        derivatives(taken_back, 1, **{name: 1.0 for name in names})
        derivatives(taken_back, 1, **{name: 0.0 for name in names})
    assert plain.content() == taken_back.content()
    for instance in (plain, taken_back):
        instance.step(5 * instance.cycle, **row)
    assert outputs(plain) == outputs(taken_back)
    assert plain.get(names) == taken_back.get(names)


def test_after_an_extrapolated_step_the_input_reads_as_it_was_set(fmu):
    instance = fmu.start(**signals.settings(fmu))
    names = real_inputs(fmu)
    instance.set(**{name: within(fmu, name, 0.5) for name in names})
    before = instance.get(names)
    if names:
        derivatives(instance, 1, **{name: 0.25 for name in names})
    instance.step(3 * instance.cycle)
    assert instance.get(names) == before


def test_an_extrapolation_beyond_the_type_is_refused(fmu):
    instance = fmu.start()
    for name in real_inputs(fmu):
        derivatives(instance, 1, **{name: 1.7e308})
        refused(instance, "fmi2DoStep", 0.0, 1e6 * instance.cycle, 1, saying=[name])
        derivatives(instance, 1, **{name: 0.0})
