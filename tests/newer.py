"""An FMU of FMI 3.0 behind the calls of FMI 2.0, so that one suite runs over both versions: `Slave` is what FMPy's `FMU2Slave` is to the
tests for FMI 2.0. Times are in seconds there, and milliseconds in the FMU; messages name the functions of FMI 2.0.

FMI 3.0 has no derivatives of inputs, and refuses a step of 0: tests of these are skipped.
"""

import ctypes
import functools
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import numpy as np
import pytest
from fmpy import fmi3

from plcfmu import messages

OK = 0

C_TYPES = {
    "Float32": ctypes.c_float,
    "Float64": c_double,
    "Int8": ctypes.c_int8,
    "UInt8": ctypes.c_uint8,
    "Int16": ctypes.c_int16,
    "UInt16": ctypes.c_uint16,
    "Int32": ctypes.c_int32,
    "UInt32": ctypes.c_uint32,
    "Int64": ctypes.c_int64,
    "UInt64": ctypes.c_uint64,
    "Boolean": c_bool,
}
OLDER = {"Float32": "Real", "Float64": "Real", "Boolean": "Boolean"}

# The functions that have another name, or arguments, in FMI 3.0.
NAMES = {
    "fmi2GetFMUstate": "fmi3GetFMUState",
    "fmi2SetFMUstate": "fmi3SetFMUState",
    "fmi2FreeFMUstate": "fmi3FreeFMUState",
    "fmi2SerializedFMUstateSize": "fmi3SerializedFMUStateSize",
    "fmi2SerializeFMUstate": "fmi3SerializeFMUState",
    "fmi2DeSerializeFMUstate": "fmi3DeserializeFMUState",
    "fmi2ExitInitializationMode": "fmi3ExitInitializationMode",
    "fmi2Terminate": "fmi3Terminate",
    "fmi2Reset": "fmi3Reset",
}


def as_older(variable, kind):
    """Makes a variable what FMI 2.0 says of it."""
    is_time = kind == "TIME" and variable.type == "Int32"
    is_narrow = variable.type == "Float32"
    scale = 1000 if is_time else 1
    variable.type = "Real" if is_time else OLDER.get(variable.type, "Integer")
    if kind == "TIME":
        variable.unit = "s"
    number = {"Real": float, "Integer": int}.get(variable.type)
    for attribute in ("start", "min", "max"):
        text = getattr(variable, attribute)
        if text is not None and number is not None:
            value = number(text) / scale if is_time else number(text)
            setattr(variable, attribute, repr(float(np.float32(value)) if is_narrow and attribute == "start" else value))


class Library:
    """A library of FMI 3.0, with the functions of FMI 2.0."""

    def __init__(self, path, types):
        """`types` are those of the FMU and of FMI 2.0, by value references."""
        self.dll = ctypes.CDLL(str(path))
        self.dll.fmi3InstantiateCoSimulation.restype = c_void_p
        self.types = types
        self.experiments = {}

    def __getattr__(self, name):
        if name not in NAMES:
            raise AttributeError(name)
        function = getattr(self.dll, NAMES[name])

        def call(component, *arguments):
            # The one number that is no address is a size.
            kind = c_size_t if NAMES[name].startswith(("fmi3Ser", "fmi3Des")) else c_void_p
            return function(c_void_p(component), *(kind(of) if type(of) is int else of for of in arguments))

        return call

    # The experiment

    def fmi2SetupExperiment(self, component, is_tolerance, tolerance, start, is_stop, stop):
        self.experiments[component] = (c_bool(is_tolerance), c_double(tolerance), c_double(start), c_bool(is_stop), c_double(stop))
        return OK

    def fmi2EnterInitializationMode(self, component):
        none = (c_bool(False), c_double(0.0), c_double(0.0), c_bool(False), c_double(0.0))
        return self.dll.fmi3EnterInitializationMode(c_void_p(component), *self.experiments.get(component, none))

    def fmi2DoStep(self, component, time, size, no_set):
        if size == 0.0:
            pytest.skip("FMI 3.0 refuses a step of 0, FMI 2.0 does not")
        event, ends, early, last = c_bool(True), c_bool(True), c_bool(True), c_double()
        found = (byref(event), byref(ends), byref(early), byref(last))
        status = self.dll.fmi3DoStep(c_void_p(component), c_double(time), c_double(size), c_bool(no_set), *found)
        if status == OK:
            assert (event.value, ends.value, early.value, last.value) == (False, False, False, time + size)
        return status

    def fmi2SetRealInputDerivatives(self, *_):
        pytest.skip("FMI 3.0 has no derivatives of inputs")

    # Values

    def access(self, what, component, references, count, values):
        groups = {}
        for place in range(count):
            newer, older = self.types[references[place]]
            groups.setdefault((newer, older), []).append(place)
        for (newer, older), places in groups.items():
            scale = 1000 if (newer, older) == ("Int32", "Real") else 1
            room = (C_TYPES[newer] * len(places))()
            chosen = (c_uint * len(places))(*(references[place] for place in places))
            if what == "Set" and scale == 1 and newer[:5] != "Float" and any(values[of] % 1 != 0 for of in places):
                # What no integer is, is given as the double that the host has; FMI 3.0 converts nothing.
                reals = (c_double * len(places))(*(values[place] for place in places))
                return self.dll.fmi3SetFloat64(c_void_p(component), chosen, c_size_t(len(places)), reals, c_size_t(len(places)))
            if what == "Set":
                whole = int if newer[:5] != "Float" else float
                for at, place in enumerate(places):
                    value = values[place]
                    room[at] = round(value * scale) if scale != 1 else whole(value)
            function = getattr(self.dll, f"fmi3{what}{newer}")
            status = function(c_void_p(component), chosen, c_size_t(len(places)), room, c_size_t(len(places)))
            if status != OK:
                return status
            if what == "Get":
                for at, place in enumerate(places):
                    values[place] = room[at] / scale if scale != 1 else room[at]
        return OK


for _of in ("Real", "Integer", "Boolean"):
    for _what in ("Get", "Set"):
        setattr(Library, f"fmi2{_what}{_of}", functools.partialmethod(Library.access, _what))


def as_older_text(text):
    """A message with the names of FMI 2.0."""
    for older, newer in NAMES.items():
        text = text.replace(newer, older)
    return text.replace("fmi3", "fmi2")


class Slave:
    """An instance: what the tests take of FMPy's `FMU2Slave`."""

    def __init__(self, dll, token, name, resources):
        self.dll, self.token, self.name, self.resources = dll, token, name, resources
        self.component = None

    def instantiate(self, callbacks, loggingOn=False):
        environment, name = callbacks.componentEnvironment, self.name.encode()

        def log(_, status, category, message):
            messages._log(environment, name, status, category, as_older_text(message.decode()).encode())

        # Kept as long as the instance.
        self.log = fmi3.fmi3LogMessageCallback(log)
        self.component = self.dll.dll.fmi3InstantiateCoSimulation(
            c_char_p(name),
            c_char_p(self.token.encode()),
            c_char_p(self.resources.encode()),
            c_bool(False),
            c_bool(loggingOn),
            c_bool(False),
            c_bool(False),
            None,
            c_size_t(0),
            None,
            self.log,
            None,
        )
        assert self.component is not None, "there is no instance"

    def freeInstance(self):
        self.dll.dll.fmi3FreeInstance(c_void_p(self.component))
