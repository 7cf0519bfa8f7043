"""An FMU as a host sees it, made short for tests: values by name, every status and message kept.

`Fmu` is a packed FMU that FMPy has unpacked, `Instance` one instance of it, driven through
FMPy's `FMU2Slave`. A call that the FMU refuses raises `Refused`, with the status and what the FMU
logged; `Instance.call` gives the bare status instead.

An FMU of FMI 3.0 is driven through the calls of FMI 2.0 (newer.py), so that a suite runs over both versions.

With PLCFMU_PLATFORM=win64 (or aarch64-linux) the instances are those of the library for that platform, in a loader
under Wine or qemu.
"""

import ctypes
import functools
import json
import math
import os
import pathlib
import re
import struct
import sys
import weakref
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import fmpy
from fmpy import fmi2
from lxml import etree

import newer
import oracle
import plcfmu
import pytest
import remote
from plcfmu import messages
from plcfmu.messages import Log

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED = range(4)

COMMON = """
    fmi2GetTypesPlatform fmi2GetVersion fmi2SetDebugLogging fmi2Instantiate fmi2FreeInstance
    fmi2SetupExperiment fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate
    fmi2Reset fmi2GetReal fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2SetReal fmi2SetInteger
    fmi2SetBoolean fmi2SetString fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
    fmi2GetDirectionalDerivative
""".split()
CO_SIMULATION = """
    fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives fmi2DoStep fmi2CancelStep
    fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus fmi2GetBooleanStatus fmi2GetStringStatus
""".split()
FUNCTIONS = COMMON + CO_SIMULATION

# The functions of FMI 3.0, which a library has, too.
FMI3 = [f"fmi3{access}{of}" for access in ("Get", "Set") for of in """
    Float32 Float64 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Binary Clock
""".split()] + """
    fmi3ActivateModelPartition fmi3CompletedIntegratorStep fmi3DeserializeFMUState fmi3DoStep
    fmi3EnterConfigurationMode fmi3EnterContinuousTimeMode fmi3EnterEventMode
    fmi3EnterInitializationMode fmi3EnterStepMode fmi3EvaluateDiscreteStates fmi3ExitConfigurationMode
    fmi3ExitInitializationMode fmi3FreeFMUState fmi3FreeInstance fmi3GetAdjointDerivative
    fmi3GetContinuousStateDerivatives fmi3GetContinuousStates fmi3GetDirectionalDerivative
    fmi3GetEventIndicators fmi3GetFMUState fmi3GetIntervalDecimal fmi3GetIntervalFraction
    fmi3GetNominalsOfContinuousStates fmi3GetNumberOfContinuousStates fmi3GetNumberOfEventIndicators
    fmi3GetNumberOfVariableDependencies fmi3GetOutputDerivatives fmi3GetShiftDecimal
    fmi3GetShiftFraction fmi3GetVariableDependencies fmi3GetVersion fmi3InstantiateCoSimulation
    fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution fmi3Reset fmi3SerializeFMUState
    fmi3SerializedFMUStateSize fmi3SetContinuousStates fmi3SetDebugLogging fmi3SetFMUState
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction fmi3SetTime
    fmi3Terminate fmi3UpdateDiscreteStates
""".split()

# The FMUs of the manuals' blocks, and which of them tell the mean of their pulses.
CONTROLLERS = tuple(oracle.BLOCKS)
MEAN = {name: block.MEAN for name, block in oracle.BLOCKS.items() if block.MEAN}

# The platform whose libraries are tested; "" is this machine.
PLATFORM = os.environ.get("PLCFMU_PLATFORM", "")

# A test in which FMPy itself loads the library.
in_fmpy = pytest.mark.skipif(PLATFORM != "", reason="FMPy loads libraries of this machine alone")

C_TYPES = {"Real": c_double, "Integer": c_int, "Boolean": c_int}

FOLDER = plcfmu.find.fmu_folder()


# What the name of an FMU of FMI 3.0 begins with, for `open_fmu`.
NEWER = "FMI 3.0 "


def names():
    """The names of all FMUs that there are."""
    return plcfmu.fmu_names(FOLDER)


def versions(names, has_newer=True):
    """These, and those of FMI 3.0; they are built for this machine alone."""
    return [*names, *(NEWER + name for name in names if has_newer and not PLATFORM)]


def environment():
    """The environment variables of a Python that a test starts, which finds the modules that the test finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PLCFMU_FMUS": str(FOLDER)}


class Refused(Exception):
    """A call that did not return fmi2OK."""

    def __init__(self, function, status, messages):
        super().__init__(f"{function} gives status {status}: {messages}")
        self.function = function
        self.status = status
        self.messages = messages


class Fmu:
    """A packed FMU, unpacked to `folder`. Its instances are those of the library for `platform`."""

    def __init__(self, path, folder, platform=PLATFORM):
        self.path = pathlib.Path(path)
        self.name = self.path.stem
        self.folder = pathlib.Path(folder)
        self.platform = platform
        fmpy.extract(self.path, self.folder)
        self.description = fmpy.read_model_description(str(self.path))
        self.is_newer = self.description.fmiVersion.startswith("3")
        if self.is_newer:
            self.description.guid = self.description.instantiationToken
            self.description.modelVariables.pop()  # the time
        self.xml = etree.parse(self.folder / "modelDescription.xml").getroot()
        self.variables = {v.name: v for v in self.description.modelVariables}
        told = self.told()
        self.table, self.interface = told["table"], told["interface"]
        self.kinds = {row["name"]: row["kind"] for row in self.table["variables"]}
        if self.is_newer:
            self.types = {}
            for name, variable in self.variables.items():
                own = variable.type
                newer.as_older(variable, self.kinds[name])
                self.types[variable.valueReference] = (own, variable.type)
        self.is_preset = (self.folder / "resources/start.txt").exists()
        self.cycle_name = self.table["variables"][self.table["cycle"]]["name"]

    def __repr__(self):
        return self.name

    @functools.cached_property
    def remote(self):
        """The library for another platform, in a loader."""
        return remote.Library(self.platform, self.library(), messages._log)

    @functools.cached_property
    def newer(self):
        """Its library, with the functions of FMI 2.0."""
        return newer.Library(self.library(), self.types)

    def slave(self, name="instance"):
        if self.is_newer:
            return newer.Slave(self.newer, self.description.guid, name, f"{self.folder}/resources/")
        if self.platform:
            return remote.Slave(self.remote, self.description.guid, name, self.resources)
        return fmi2.FMU2Slave(
            guid=self.description.guid,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            unzipDirectory=str(self.folder),
            instanceName=name,
        )

    @property
    def resources(self):
        """The URI of its resources, as the library's platform has it. Wine has the root of this machine as drive Z."""
        uri = (self.folder / "resources").as_uri()
        return uri.replace("file:///", "file:///Z:/") if self.platform.startswith("win") else uri

    def library(self):
        """The library's file."""
        if self.platform:
            return remote.library(self.platform, self.folder)
        name = self.description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
        return self.folder / "binaries" / (fmpy.platform_tuple if self.is_newer else fmpy.platform) / name

    @property
    def is_program(self):
        """Whether it is a program in SCL, which its library reads from the resources."""
        return (self.folder / "resources/program.txt").exists()

    def told(self):
        """What the library says of itself: its table has the PLC types, the XML only FMI's. That of programs says nothing."""
        if self.is_program:
            return self.told_by_sources()
        if self.platform:
            interface = self.remote.plcfmu_interface
        else:
            interface = ctypes.CDLL(str(self.library())).plcfmu_interface
            interface.restype, interface.argtypes = c_size_t, [c_char_p, c_size_t]
        buffer = ctypes.create_string_buffer(interface(None, 0))
        interface(buffer, len(buffer))
        return json.loads(buffer.raw)

    def told_by_sources(self):
        """The same of a program: the types of its inputs and parameters are in its sources."""
        texts = [path.read_text(encoding="utf-8") for path in (self.folder / "resources").glob("*.scl")]
        declared = {name: kind.upper() for text in texts for name, kind in re.findall(r"^ *(\w+) *: *(\w+)", text, re.M)}
        of_type = {"Real": "REAL", "Integer": "INT", "Boolean": "BOOL"}
        rows = []
        for variable in self.description.modelVariables:
            older = newer.OLDER.get(variable.type, "Integer") if self.is_newer else variable.type
            is_time = variable.unit == "s" or variable.name == "CYCLE"
            kind = "TIME" if is_time else declared.get(variable.name, of_type[older])
            rows.append({"name": variable.name, "kind": kind})
        start = self.folder / "resources/start.txt"
        guid = re.search(r"{.*}", start.read_text(encoding="utf-8"))[0] if start.exists() else self.description.guid
        names = [row["name"] for row in rows]
        table = {"name": self.description.coSimulation.modelIdentifier, "variables": rows, "cycle": names.index("CYCLE")}
        return {"table": table, "interface": {"guid": guid}}

    @property
    def cycle(self):
        """The default time between two calls in seconds."""
        return float(self.variables[self.cycle_name].start)

    def of(self, *causalities, variability=None, type=None):
        """The names of the variables of these causalities."""
        return [
            v.name
            for v in self.description.modelVariables
            if v.causality in causalities and variability in (None, v.variability) and type in (None, v.type)
        ]

    def instance(self, **options):
        return Instance(self, **options)

    def start(self, **values):
        """An instance after its restart call, ready for the first step."""
        instance = Instance(self)
        instance.start(**values)
        return instance


class Instance:
    """One instance. `instance["LMN"]` reads, `instance.set(SP_INT=1.0)` writes."""

    def __init__(self, fmu, name="instance", logging_on=True):
        self.fmu = fmu
        self.slave = fmu.slave(name)
        # Without functions for memory: the FMUs say that they need none.
        self.log = Log(memory=False)
        self.slave.instantiate(callbacks=self.log.callbacks, loggingOn=logging_on)
        self.time = 0.0
        weakref.finalize(self, self.slave.freeInstance)

    # Messages: (instance name, status, category, text) of each

    @property
    def messages(self):
        """Those of calls that were refused."""
        return [message for message in self.log.messages if message.category != "logAdvice"]

    @property
    def advice(self):
        """Those of calls that were made."""
        return [message for message in self.log.messages if message.category == "logAdvice"]

    # Any function

    def call(self, function, *arguments):
        """The status that a function gives for these arguments after the component."""
        return getattr(self.slave.dll, function)(self.slave.component, *arguments)

    def do(self, function, *arguments):
        """The same for a call that must succeed."""
        count = len(self.messages)
        status = self.call(function, *arguments)
        if status != OK:
            raise Refused(function, status, [text for *_, text in self.messages[count:]])

    # Values

    def set(self, **values):
        """Writes variables by name, those of one type in one call."""
        for type, c_type in C_TYPES.items():
            names = [name for name in values if self.fmu.variables[name].type == type]
            if names:
                given = [values[name] for name in names]
                self.do(
                    f"fmi2Set{type}", references(self.fmu, names), len(names), (c_type * len(names))(*given)
                )

    def get(self, names):
        """Reads variables by name: Reals as float, Integers as int, Booleans as 0 or 1."""
        got = {}
        for type, c_type in C_TYPES.items():
            chosen = [name for name in names if self.fmu.variables[name].type == type]
            if chosen:
                values = (c_type * len(chosen))()
                self.do(f"fmi2Get{type}", references(self.fmu, chosen), len(chosen), values)
                got.update(zip(chosen, values))
        return {name: got[name] for name in names}

    def __getitem__(self, name):
        return self.get([name])[name]

    def outputs(self):
        """All outputs, to be compared bit for bit."""
        return exact(self.get(self.fmu.of("output")))

    def values(self):
        """All variables, to be compared bit for bit."""
        return exact(self.get(self.fmu.variables))

    # Modes and steps

    def start(self, start_time=0.0, stop_time=None, **values):
        """Sets values and goes through initialization."""
        self.setup(start_time, stop_time)
        self.set(**values)
        self.do("fmi2EnterInitializationMode")
        self.do("fmi2ExitInitializationMode")

    def setup(self, start_time=0.0, stop_time=None):
        self.do("fmi2SetupExperiment", 0, 0.0, start_time, stop_time is not None, stop_time or 0.0)
        self.time = start_time

    @property
    def cycle(self):
        return self[self.fmu.cycle_name]

    def step(self, h=None, **values):
        """One communication step, of CYCLE unless told otherwise, after writing values."""
        if values:
            self.set(**values)
        h = self.cycle if h is None else h
        self.do("fmi2DoStep", self.time, h, 1)
        self.time += h

    def record(self, *outputs, calls, **sequences):
        """Makes calls, one a step, and gives the outputs after each. A sequence gives an input's
        value call by call."""
        h = self.cycle
        rows = []
        for number in range(calls):
            self.step(h, **{name: values[number] for name, values in sequences.items()})
            got = self.get(outputs)
            rows.append(tuple(got.values()) if len(outputs) > 1 else got[outputs[0]])
        return rows

    # FMU states

    def save(self):
        state = c_void_p()
        self.do("fmi2GetFMUstate", byref(state))
        return state

    def restore(self, state):
        self.do("fmi2SetFMUstate", state)

    def free(self, state):
        self.do("fmi2FreeFMUstate", byref(state))

    def serialize(self, state):
        size = c_size_t()
        self.do("fmi2SerializedFMUstateSize", state, byref(size))
        buffer = ctypes.create_string_buffer(size.value)
        self.do("fmi2SerializeFMUstate", state, buffer, size)
        return buffer.raw

    def deserialize(self, serialized):
        state = c_void_p()
        buffer = ctypes.create_string_buffer(serialized, len(serialized))
        self.do("fmi2DeSerializeFMUstate", buffer, len(serialized), byref(state))
        return state

    def content(self):
        """All that the instance is: block, clock, mode. Equal contents behave alike ever after."""
        state = self.save()
        serialized = self.serialize(state)
        self.free(state)
        return serialized


def other_values(fmu):
    """Values for all inputs and parameters that are numbers: near the start values, and different from them. Times of pulses
    stay in proportion."""
    values = {}
    for name in fmu.of("input", "parameter"):
        variable, kind = fmu.variables[name], fmu.kinds[name]
        if kind == "BOOL":
            continue
        start = float(variable.start)
        low, high = (-math.inf if variable.min is None else float(variable.min),
                     math.inf if variable.max is None else float(variable.max))
        others = [2 * start] if kind == "TIME" else [start + 1, start - 1] if kind in ("INT", "WORD") else [
            1.25 * start + 0.0625, 0.75 * start - 0.0625]
        fitting = [other for other in others if low <= other <= high and other != start]
        if fitting:
            values[name] = int(fitting[0]) if variable.type == "Integer" else fitting[0]
    return values


def references(fmu, names):
    return (c_uint * len(names))(*(fmu.variables[name].valueReference for name in names))


def exact(values):
    """Values that are equal only if their bits are: 0.0 and -0.0 differ, NaN equals NaN."""
    return {name: v.hex() if isinstance(v, float) else v for name, v in values.items()}


def real(*numbers):
    """Decimal numbers as a REAL holds them, to compare with what the block gives, bit for bit."""
    rounded = [struct.unpack("f", struct.pack("f", number))[0] for number in numbers]
    return rounded if len(numbers) > 1 else rounded[0]
