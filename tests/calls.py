"""Calls of the C interface: an instance in each state, a good call of each function, and what a refusal is."""

import ctypes
import re
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import host
from host import DISCARD, ERROR

STATES = ("instantiated", "Initialization Mode", "stepComplete", "terminated")


def instance_in(fmu, state):
    instance = fmu.instance()
    instance.setup()
    if state == "instantiated":
        return instance
    instance.do("fmi2EnterInitializationMode")
    if state == "Initialization Mode":
        return instance
    instance.do("fmi2ExitInitializationMode")
    instance.step()
    if state == "terminated":
        instance.do("fmi2Terminate")
    return instance


def arguments(instance, function):
    """Arguments of a call that succeeds where the function is allowed."""
    fmu = instance.fmu
    type = function[len("fmi2Get") :]
    if function in ("fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean"):
        names = [name for name, v in fmu.variables.items() if v.type == type]
        return (host.references(fmu, names), len(names), (host.C_TYPES[type] * len(names))())
    if function in ("fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean"):
        names = fmu.of("input", type=type)
        return (host.references(fmu, names), len(names), (host.C_TYPES[type] * len(names))())
    if function in ("fmi2GetString", "fmi2SetString"):
        return ((c_uint * 1)(), 0, (c_char_p * 1)())
    if function == "fmi2SetDebugLogging":
        return (1, 1, (c_char_p * 1)(b"logStatusError"))
    if function == "fmi2SetupExperiment":
        return (0, 0.0, 0.0, 0, 0.0)
    if function == "fmi2GetFMUstate":
        return (byref(c_void_p()),)
    if function == "fmi2SetFMUstate":
        return (instance.save(),)
    if function == "fmi2FreeFMUstate":
        return (byref(instance.save()),)
    if function == "fmi2SerializedFMUstateSize":
        return (instance.save(), byref(c_size_t()))
    if function == "fmi2SerializeFMUstate":
        return (instance.save(), ctypes.create_string_buffer(10_000), 10_000)
    if function == "fmi2DeSerializeFMUstate":
        content = instance.content()
        return (ctypes.create_string_buffer(content, len(content)), len(content), byref(c_void_p()))
    if function == "fmi2GetDirectionalDerivative":
        return ((c_uint * 1)(), 1, (c_uint * 1)(), 1, (c_double * 1)(1.0), (c_double * 1)())
    if function == "fmi2SetRealInputDerivatives":
        names = [name for name in fmu.of("input", type="Real") if fmu.kinds[name] != "TIME"]
        count = len(names)
        return (host.references(fmu, names), count, (c_int * count)(*[1] * count), (c_double * count)())
    if function == "fmi2GetRealOutputDerivatives":
        return ((c_uint * 1)(), 0, (c_int * 1)(1), (c_double * 1)())
    if function == "fmi2DoStep":
        return (instance.time, instance.cycle, 1)
    if function == "fmi2GetStatus":
        return (host.DO_STEP_STATUS, byref(c_int()))
    if function == "fmi2GetRealStatus":
        return (host.LAST_SUCCESSFUL_TIME, byref(c_double()))
    if function == "fmi2GetIntegerStatus":
        return (host.DO_STEP_STATUS, byref(c_int()))
    if function == "fmi2GetBooleanStatus":
        return (host.TERMINATED, byref(c_int()))
    if function == "fmi2GetStringStatus":
        return (host.PENDING_STATUS, byref(c_char_p()))
    return ()


def refused(instance, function, *given, status=ERROR, saying=()):
    """Makes a call that must be refused: with the status, one message that names the function and
    has the words, and nothing changed. Returns the message."""
    before = instance.content()
    count = len(instance.messages)
    assert instance.call(function, *given) == status
    new = instance.messages[count:]
    assert len(new) == 1, new
    name, logged_status, category, text = new[0]
    assert name == "instance"
    assert logged_status == status
    assert category == {ERROR: "logStatusError", DISCARD: "logStatusDiscard"}[status]
    assert re.match(f"{function}: .", text), text
    for word in saying:
        assert word in text
    assert instance.content() == before
    return text
