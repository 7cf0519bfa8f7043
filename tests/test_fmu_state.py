"""Reset, saved FMU states and several instances of every FMU: equal to the last bit."""

import ctypes
import os
import subprocess
import sys
from ctypes import byref, c_void_p

import pytest

import host
import signals
from calls import STATES, instance_in, refused

CALLS = 40


def running(fmu, rows, **options):
    """An instance that has made a call for each row."""
    instance = fmu.instance(**options)
    instance.start(**signals.settings(fmu))
    run(instance, rows)
    return instance


def run(instance, rows):
    """A call for each row; all values after each."""
    values = []
    for row in rows:
        instance.step(**row)
        values.append(instance.values())
    return values


# --- Reset -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("state", STATES)
def test_reset_makes_an_instance_as_new(fmu, state):
    instance = instance_in(fmu, state)
    names = fmu.of("parameter", type="Real") + fmu.of("input", type="Boolean")
    if state == "instantiated":
        instance.set(**{name: 1 for name in names})
    instance.do("fmi2Reset")
    assert instance.content() == fmu.instance().content()


def test_a_run_after_reset_equals_a_run_of_a_new_instance(fmu):
    rows = signals.rows(fmu, CALLS)
    instance = running(fmu, signals.rows(fmu, CALLS, seed=1))
    instance.do("fmi2Reset")
    instance.start(**signals.settings(fmu))
    fresh = fmu.start(**signals.settings(fmu))
    assert run(instance, rows) == run(fresh, rows)


def test_reset_takes_input_derivatives_back(fmu):
    names = [name for name in fmu.of("input", type="Real") if fmu.kinds[name] != "TIME"]
    instance = fmu.start()
    count = len(names)
    instance.do(
        "fmi2SetRealInputDerivatives",
        host.references(fmu, names),
        count,
        (ctypes.c_int * count)(*[1] * count),
        (ctypes.c_double * count)(*[1.0] * count),
    )
    instance.do("fmi2Reset")
    assert instance.content() == fmu.instance().content()


# --- FMU states ------------------------------------------------------------------------------------


def test_a_restored_state_goes_on_bit_for_bit(fmu):
    instance = running(fmu, signals.rows(fmu, CALLS))
    state, time = instance.save(), instance.time
    ahead = signals.rows(fmu, CALLS, seed=1)
    first = run(instance, ahead)
    run(instance, signals.rows(fmu, CALLS, seed=2))
    instance.restore(state)
    instance.time = time
    assert run(instance, ahead) == first


def test_a_state_can_be_restored_again_and_again(fmu):
    instance = running(fmu, signals.rows(fmu, 5))
    state, content = instance.save(), instance.content()
    for seed in (1, 2):
        instance.restore(state)
        assert instance.content() == content
        instance.step(**signals.rows(fmu, 1, seed)[0])
        assert instance.content() != content


@pytest.mark.parametrize("saved", STATES)
@pytest.mark.parametrize("restored", STATES)
def test_a_state_brings_the_mode_back_too(fmu, saved, restored):
    source = instance_in(fmu, saved)
    instance = instance_in(fmu, restored)
    instance.restore(instance.deserialize(source.content()))
    assert instance.content() == source.content()
    step = instance.call("fmi2DoStep", source.time, source.cycle, 1)
    assert step == (host.OK if saved == "stepComplete" else host.ERROR)


def test_a_saved_state_can_be_overwritten(fmu):
    """fmi2GetFMUstate with a pointer that it gave before uses that again."""
    instance = fmu.start()
    state = instance.save()
    address = state.value
    instance.step()
    content = instance.content()
    instance.do("fmi2GetFMUstate", byref(state))
    assert state.value == address
    instance.step()
    instance.restore(state)
    assert instance.content() == content


def test_a_freed_state_is_refused(fmu):
    instance = fmu.start()
    state = instance.save()
    address = c_void_p(state.value)
    instance.free(state)
    assert state.value is None
    refused(instance, "fmi2SetFMUstate", address)
    refused(instance, "fmi2FreeFMUstate", byref(c_void_p(address.value)))
    refused(instance, "fmi2SerializedFMUstateSize", address, byref(ctypes.c_size_t()))


def test_a_state_of_another_instance_is_refused(fmu):
    instance, other = fmu.start(), fmu.start()
    state = other.save()
    refused(instance, "fmi2SetFMUstate", state, saying=["serialize"])
    refused(instance, "fmi2FreeFMUstate", byref(state))
    refused(instance, "fmi2GetFMUstate", byref(state))
    other.restore(state)


def test_a_pointer_to_anything_is_no_state(fmu):
    instance = fmu.start()
    buffer = ctypes.create_string_buffer(4096)
    refused(instance, "fmi2SetFMUstate", ctypes.addressof(buffer))
    refused(instance, "fmi2SetFMUstate", 1)


def test_a_serialized_state_goes_on_bit_for_bit_in_another_instance(fmu):
    instance = running(fmu, signals.rows(fmu, CALLS))
    other = running(fmu, signals.rows(fmu, 3, seed=2), name="other")
    other.restore(other.deserialize(instance.content()))
    other.time = instance.time
    ahead = signals.rows(fmu, CALLS, seed=1)
    assert run(other, ahead) == run(instance, ahead)


CONTINUE = """
import sys
import host, signals, test_fmu_state
fmu = host.Fmu(sys.argv[1], sys.argv[2])
instance = fmu.instance()
instance.restore(instance.deserialize(bytes.fromhex(sys.argv[3])))
instance.time = float(sys.argv[4])
print(test_fmu_state.run(instance, signals.rows(fmu, test_fmu_state.CALLS, seed=1)))
"""


def test_a_serialized_state_goes_on_bit_for_bit_in_another_process(fmu, tmp_path):
    instance = running(fmu, signals.rows(fmu, CALLS))
    given = [str(fmu.path), str(tmp_path), instance.content().hex(), repr(instance.time)]
    process = subprocess.run(
        [sys.executable, "-c", CONTINUE, *given],
        cwd=os.path.dirname(__file__),
        env=host.environment(),
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    assert process.stdout.strip() == repr(run(instance, signals.rows(fmu, CALLS, seed=1)))


def test_the_size_of_a_serialized_state_is_exact(fmu):
    instance = fmu.start()
    state = instance.save()
    length = len(instance.serialize(state))
    buffer = ctypes.create_string_buffer(b"\x55" * (length + 8), length + 8)
    refused(instance, "fmi2SerializeFMUstate", state, buffer, length - 1, saying=[str(length)])
    assert buffer.raw == b"\x55" * (length + 8)
    instance.do("fmi2SerializeFMUstate", state, buffer, length)
    assert buffer.raw[length:] == b"\x55" * 8


def deserialization_refused(instance, serialized):
    buffer = ctypes.create_string_buffer(serialized, len(serialized))
    state = c_void_p()
    refused(instance, "fmi2DeSerializeFMUstate", buffer, len(serialized), byref(state))
    assert state.value is None


def some(length):
    """All places, but of a long state (a plant's transport delay) only the ends and every 17th."""
    return sorted({*range(min(length, 300)), *range(0, length, 17), *range(max(0, length - 50), length)})


def test_a_serialized_state_with_any_byte_changed_is_refused(fmu):
    instance = fmu.start()
    content = instance.content()
    for place in some(len(content)):
        damaged = bytearray(content)
        damaged[place] ^= 1 << place % 8
        deserialization_refused(instance, bytes(damaged))


def test_a_serialized_state_of_any_other_length_is_refused(fmu):
    instance = fmu.start()
    content = instance.content()
    for length in some(len(content)):
        deserialization_refused(instance, content[:length])
    deserialization_refused(instance, content + b"\0")
    deserialization_refused(instance, content + content)


def test_a_serialized_state_of_another_fmu_is_refused(fmu, open_fmu):
    for name in host.names():
        if name != fmu.name:
            deserialization_refused(fmu.start(), open_fmu(name).start().content())


# --- Several instances -----------------------------------------------------------------------------


def test_two_instances_do_not_see_each_other(fmu):
    rows = [signals.rows(fmu, CALLS, seed) for seed in (1, 2)]
    alone = [run(fmu.start(**signals.settings(fmu)), mine) for mine in rows]
    pair = [fmu.start(**signals.settings(fmu)) for _ in rows]
    together = [[], []]
    for number in range(CALLS):
        for instance, values, mine in zip(pair, together, rows):
            values += run(instance, mine[number : number + 1])
    assert together == alone
    assert alone[0] != alone[1]


def test_an_instance_survives_the_end_of_another(fmu):
    rows = signals.rows(fmu, CALLS)
    expected = run(fmu.start(), rows)
    kept, other = fmu.start(), fmu.start()
    other.step()
    del other
    assert run(kept, rows) == expected
