"""The FMUs of FMI 3.0 (`--fmi 3`), in FMPy: they are valid, give the bits of those of FMI 2.0, have the types of the PLC, and make their
calls as events where the master has Event Mode."""

import ctypes
import math
import pathlib
import random
import struct
import subprocess
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from fmpy.validation import validate_fmu
from lxml import etree

import host
import plcfmu
from test_masters import ecos

pytestmark = host.in_fmpy


class Fmu:
    """A packed FMU of FMI 3.0, unpacked to a folder."""

    def __init__(self, path, folder):
        self.path = pathlib.Path(path)
        self.folder = pathlib.Path(folder)
        fmpy.extract(self.path, self.folder)
        self.description = fmpy.read_model_description(str(self.path))
        self.variables = {v.name: v for v in self.description.modelVariables}

    def slave(self, token=None):
        co_simulation = self.description.coSimulation
        token = self.description.instantiationToken if token is None else token
        return fmi3.FMU3Slave(
            guid=token, modelIdentifier=co_simulation.modelIdentifier, unzipDirectory=str(self.folder), instanceName="x"
        )

    def instance(self, **options):
        return Instance(self, **options)


class Instance:
    """An instance, with variables by their names."""

    def __init__(self, fmu, events=False, early=False, token=None):
        self.fmu, self.messages = fmu, []
        self.slave = fmu.slave(token)
        log = lambda environment, status, category, message: self.messages.append((status, message.decode()))
        self.slave.instantiate(loggingOn=False, eventModeUsed=events, earlyReturnAllowed=early, logMessage=log)

    def initialize(self, start=0.0, stop=None, **values):
        for name, value in values.items():
            self.set(name, value)
        self.slave.enterInitializationMode(startTime=start, stopTime=stop)
        self.slave.exitInitializationMode()
        return self

    def set(self, name, value):
        variable = self.fmu.variables[name]
        values = value if isinstance(value, list) else [value]
        getattr(self.slave, f"set{variable.type}")([variable.valueReference], values)

    def get(self, name):
        variable = self.fmu.variables[name]
        count = math.prod(int(of.start) for of in variable.dimensions)
        values = getattr(self.slave, f"get{variable.type}")([variable.valueReference], nValues=count)
        return values if variable.dimensions else values[0]

    def step(self, tc, h):
        return self.slave.doStep(tc, h)

    def event(self):
        """What fmi3UpdateDiscreteStates says: the time of the next event, if there is one."""
        *flags, is_defined, time = self.slave.updateDiscreteStates()
        assert flags == [False] * 4
        return time if is_defined else None

    def refused(self, call):
        """What is logged when a call is refused."""
        self.messages.clear()
        with pytest.raises(Exception):
            call()
        ((status, message),) = self.messages
        assert status == 3
        return message


@pytest.fixture(scope="session")
def open_fmi3(packed, tmp_path_factory):
    opened = {}

    def open_fmi3(name, types="native"):
        if (name, types) not in opened:
            opened[name, types] = Fmu(packed(types) / f"{name}.fmu", tmp_path_factory.mktemp(f"{name}_{types}"))
        return opened[name, types]

    return open_fmi3


@pytest.fixture(scope="session")
def build(command, tmp_path_factory):
    """Builds a program in SCL as an FMU of FMI 3.0."""

    def build(source, *options):
        folder = tmp_path_factory.mktemp("program")
        (folder / "program.scl").write_text(source)
        done = subprocess.run(
            [command, "build", str(folder / "program.scl"), "--fmi=3", "--cycle=100ms", "--out", str(folder), *options],
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        (path,) = folder.glob("*.fmu")
        return Fmu(path, folder / "unpacked")

    return build


def bits(value):
    """A number, to be compared bit by bit."""
    return struct.pack("d", float(value))


def in_fmi2(kind, value):
    """A value of FMI 3.0 as FMI 2.0 has it."""
    return value / 1000 if kind == "TIME" else float(np.float32(value)) if kind == "REAL" else float(value)


# The files


def test_fmpy_finds_nothing(fmu, open_fmi3):
    for types in ("native", "wide"):
        of = open_fmi3(fmu.name, types)
        assert validate_fmu(str(of.path)) == []
        assert [v.name for v in of.description.modelVariables][-1] == "time"
        assert of.description.coSimulation.hasEventMode
    tokens = {open_fmi3(fmu.name, types).description.instantiationToken for types in ("native", "wide")}
    assert len(tokens | {fmu.description.guid}) == 3


def test_types_are_those_of_the_plc_or_few(fmu, open_fmi3):
    native = {"REAL": "Float32", "LREAL": "Float64", "TIME": "Int32", "WORD": "Int16", "INT": "Int16", "BOOL": "Boolean"}
    wide = {"REAL": "Float64", "LREAL": "Float64", "TIME": "Float64", "WORD": "Int32", "INT": "Int32", "BOOL": "Boolean"}
    for types, expected in [("native", native), ("wide", wide)]:
        found = {name: v.type for name, v in open_fmi3(fmu.name, types).variables.items() if name != "time"}
        assert found == {name: expected[kind] for name, kind in fmu.kinds.items()}


# The same bits


@pytest.mark.parametrize("types", ["native", "wide"])
def test_without_events_each_step_gives_the_bits_of_fmi_2(fmu, open_fmi3, types):
    chance = random.Random(fmu.name)
    of = open_fmi3(fmu.name, types)
    rows = {row["name"]: row for row in fmu.table["variables"]}
    cycle = rows[fmu.cycle_name]["start"]
    outputs = [name for name, row in rows.items() if row["role"] in ("output", "local")]
    inputs = [name for name, row in rows.items() if row["role"] == "input"]

    older, newer = fmu.slave(), of.instance()
    older.instantiate()
    older.setupExperiment(startTime=0.0)
    older.enterInitializationMode()
    newer.slave.enterInitializationMode(startTime=0.0)
    older.exitInitializationMode()
    newer.slave.exitInitializationMode()

    def read_older(name):
        kind, reference = rows[name]["kind"], fmu.variables[name].valueReference
        get = {"BOOL": older.getBoolean, "WORD": older.getInteger, "INT": older.getInteger}.get(kind, older.getReal)
        return get([reference])[0]

    def write(name):
        kind, row = rows[name]["kind"], rows[name]
        low, high = row["min"] if row["min"] is not None else -100, row["max"] if row["max"] is not None else 100
        reference = fmu.variables[name].valueReference
        if kind == "BOOL":
            value = chance.random() < 0.3
            older.setBoolean([reference], [value])
        elif kind in ("INT", "WORD"):
            value = chance.randint(int(low), int(high))
            older.setInteger([reference], [value])
        else:
            value = float(np.float32(chance.uniform(low, high)))
            value = chance.randint(1, 5000) if kind == "TIME" else value
            older.setReal([reference], [value / 1000 if kind == "TIME" else value])
            value = value / 1000 if (kind, types) == ("TIME", "wide") else value
        newer.set(name, value)

    time = 0.0
    for _ in range(150):
        for name in inputs:
            if chance.random() < 0.3:
                write(name)
        h = chance.choice([cycle, cycle, cycle, 3 * cycle, cycle / 4, cycle * 0.75])
        older.doStep(time, h)
        assert newer.step(time, h) == (False, False, False, time + h)
        time += h
        for name in outputs:
            value = newer.get(name)
            value = value if types == "wide" and rows[name]["kind"] != "REAL" else in_fmi2(rows[name]["kind"], value)
            assert bits(value) == bits(read_older(name)), (name, time)
    assert newer.get("time") == time


# Event Mode


def test_the_call_and_what_it_answers_stand_at_the_same_instant(open_fmi3):
    """FMPy's own master, with Event Mode: the outputs that it has one step later without."""
    fmu = open_fmi3("CONT_C")
    start = {"CYCLE": 100, "TI": 2000, "I_SEL": True, "SP_INT": 10.0, "MAN_ON": False}

    def run(events):
        found = []

        def seen(time, recorder):
            found.append(recorder.fmu.getFloat32([fmu.variables["LMN"].valueReference])[0])
            return True

        result = fmpy.simulate_fmu(
            str(fmu.path),
            stop_time=2.0,
            output_interval=0.1,
            start_values=start,
            output=["LMN"],
            use_event_mode=events,
            step_finished=seen,
        )
        return result["LMN"][0], found

    (first, plain), (first_event, events) = run(False), run(True)
    assert (first, len(plain), len(events)) == (0.0, 20, 20)
    assert [first_event, *events[:-1]] == plain
    assert plain[0] != 0.0 and plain[0] != plain[-1]


def two_zero_loop(open_fmu, steps):
    """CONT_C and HEATER in FMI 2.0, the controller first: the temperature and the manipulated value after each step."""
    controller, heater = open_fmu("CONT_C"), open_fmu("HEATER")
    c, h = controller.slave(), heater.slave()
    reference = lambda fmu, name: [fmu.variables[name].valueReference]
    for slave in (c, h):
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
    c.setReal(reference(controller, "CYCLE") + reference(controller, "TI") + reference(controller, "GAIN"), [1.0, 130.0, 0.7])
    c.setReal(reference(controller, "SP_INT"), [60.0])
    c.setBoolean(reference(controller, "MAN_ON"), [False])
    h.setReal(reference(heater, "CYCLE"), [1.0])
    temperature = h.getReal(reference(heater, "TEMP"))
    for slave in (c, h):
        slave.exitInitializationMode()
    found = []
    for k in range(steps):
        c.setReal(reference(controller, "PV_IN"), temperature)
        c.doStep(float(k), 1.0)
        lmn = c.getReal(reference(controller, "LMN"))
        h.setReal(reference(heater, "POWER"), lmn)
        h.doStep(float(k), 1.0)
        temperature = h.getReal(reference(heater, "TEMP"))
        found.append((lmn[0], temperature[0]))
    return found


@pytest.mark.parametrize("order", [("CONT_C", "HEATER"), ("HEATER", "CONT_C")])
def test_a_loop_with_events_has_neither_a_delay_nor_an_order(open_fmi3, open_fmu, order):
    settings = {"CONT_C": {"CYCLE": 1000, "TI": 130_000, "GAIN": 0.7, "SP_INT": 60.0, "MAN_ON": False}, "HEATER": {"CYCLE": 1000}}
    members = {name: open_fmi3(name).instance(events=True, early=True).initialize(**settings[name]) for name in order}
    wires = [("HEATER", "TEMP", "CONT_C", "PV_IN"), ("CONT_C", "LMN", "HEATER", "POWER")]

    def exchange():
        for source, output, target, name in wires:
            members[target].set(name, members[source].get(output))

    def handle(time):
        exchange()
        due = [members[name].event() for name in order]
        # What an event has changed goes on at the same instant, at which there is no second call.
        exchange()
        again = [members[name].event() for name in order]
        assert again == due
        next_time = min(next for next in due if next is not None)
        assert next_time == time + 1.0
        return next_time

    found, time, steps = [], 0.0, 400
    for k in range(steps):
        next_time = handle(time)
        for name in order:
            members[name].slave.enterStepMode()
        for name in order:
            is_event, terminates, is_early, last = members[name].step(time, next_time - time)
            assert (is_event, terminates, is_early, last) == (name == "CONT_C", False, False, next_time)
        time = next_time
        found.append((members["CONT_C"].get("LMN"), members["HEATER"].get("TEMP")))
        for name in order:
            members[name].slave.enterEventMode()
    expected = two_zero_loop(open_fmu, steps)
    assert [(bits(lmn), bits(temperature)) for lmn, temperature in found] == [
        (bits(lmn), bits(temperature)) for lmn, temperature in expected
    ]
    assert found[-1][1] > 50.0


COUNTER = """FUNCTION_BLOCK Counter VAR_INPUT up : BOOL := TRUE; END_VAR VAR_OUTPUT count : DINT; END_VAR
BEGIN IF up THEN count := count + 1; END_IF; END_FUNCTION_BLOCK"""


@pytest.fixture(scope="session")
def counter(build):
    return build(COUNTER)


def test_a_step_beyond_a_call_returns_early_there_if_it_may(counter):
    instance = counter.instance(events=True, early=True).initialize()
    assert (instance.event(), instance.get("count")) == (0.1, 1)
    instance.slave.enterStepMode()
    assert instance.step(0.0, 0.25) == (True, False, True, 0.1)
    assert instance.get("count") == 1
    instance.slave.enterEventMode()
    assert (instance.event(), instance.event(), instance.get("count")) == (0.2, 0.2, 2)
    instance.slave.enterStepMode()
    # A step that ends before the next call makes none, and is no event.
    assert instance.step(0.1, 0.05) == (False, False, False, pytest.approx(0.15))
    # An event of somebody else: no call.
    instance.slave.enterEventMode()
    assert (instance.event(), instance.get("count")) == (0.2, 2)
    instance.slave.enterStepMode()
    # Of rounding a step may be left.
    assert instance.step(0.15, 0.05 - 1e-16)[0] is True
    instance.slave.enterEventMode()
    assert (instance.event(), instance.get("count")) == (pytest.approx(0.3), 3)


def test_a_step_that_may_not_return_early_makes_the_calls_in_between(counter):
    instance = counter.instance(events=True).initialize()
    instance.event()
    instance.slave.enterStepMode()
    assert instance.step(0.0, 0.3) == (True, False, False, 0.3)
    # Those at 0.1 and 0.2; that at 0.3 is an event.
    assert instance.get("count") == 3
    instance.slave.enterEventMode()
    assert (instance.event(), instance.get("count")) == (0.4, 4)
    # A master that does not handle an event: the call is made in its next step.
    instance.slave.enterStepMode()
    instance.step(0.3, 0.1)
    instance.step(0.4, 0.05)
    assert instance.get("count") == 5


def test_a_step_of_0_and_one_back_are_refused(counter):
    instance = counter.instance().initialize()
    assert instance.refused(lambda: instance.step(0.0, 0.0)) == "fmi3DoStep: communicationStepSize = 0.0: must be above 0"
    instance.step(0.0, 0.1)
    assert "is before 0.1" in instance.refused(lambda: instance.step(0.0, 0.1))
    assert "without Event Mode" in instance.refused(instance.slave.enterEventMode)


# Types

ALL = """FUNCTION_BLOCK All
VAR_INPUT count : LINT := 9007199254740993; bits : DWORD; wait : TIME; name : STRING[20]; long : LTIME; END_VAR
VAR_INPUT mask : WORD := 16#FFFE; small : BYTE; letter : CHAR; day : DATE; END_VAR
VAR_INPUT values : ARRAY[1..1000] OF REAL; END_VAR
VAR_OUTPUT count_out : LINT; bits_out : DWORD; wait_out : TIME; name_out : STRING[20]; values_out : ARRAY[1..1000] OF REAL; END_VAR
VAR_OUTPUT mask_out : WORD; END_VAR
VAR_TEMP i : INT; END_VAR
BEGIN
  count_out := count + 1; bits_out := bits; wait_out := wait; name_out := name; mask_out := mask;
  FOR i := 1 TO 1000 DO values_out[i] := values[i]; END_FOR;
END_FUNCTION_BLOCK"""


def test_a_program_keeps_all_bits_of_its_types(build):
    fmu = build(ALL)
    assert validate_fmu(str(fmu.path)) == []
    assert fmu.variables["count"].start == "9007199254740993"
    names = ["count", "bits", "wait", "name", "values", "CYCLE", "mask", "small", "letter", "day", "long"]
    types = ["Int64", "UInt32", "Int32", "String", "Float32", "Int32", "UInt16", "UInt8", "UInt8", "UInt16", "Int64"]
    assert {name: fmu.variables[name].type for name in names} == dict(zip(names, types, strict=True))
    assert fmu.variables["mask"].start == str(0xFFFE)
    instance = fmu.instance().initialize()
    values = [float(np.float32(0.1 * i)) for i in range(1000)]
    for name, value in [("count", 2**53 + 3), ("bits", 2**31 + 1), ("wait", -1), ("name", "Größe"), ("values", values), ("mask", 0x8001)]:
        instance.set(name, value)
        assert instance.get(name) == value
    instance.step(0.0, 0.1)
    assert instance.get("count_out") == 2**53 + 4
    assert (instance.get("bits_out"), instance.get("wait_out"), instance.get("mask_out")) == (2**31 + 1, -1, 0x8001)
    assert (instance.get("name_out"), instance.get("values_out")) == ("Größe", values)
    # All elements or none.
    reference = fmu.variables["values"].valueReference
    assert "nValues = 3: must be 1000 for these variables" in instance.refused(
        lambda: instance.slave.setFloat32([reference], [1.0, 2.0, 3.0])
    )
    assert "is an element of an array: use" in instance.refused(lambda: instance.slave.getFloat32([reference + 1]))
    for name, other in [("mask", "Int16"), ("bits", "Int32"), ("small", "Int8")]:
        reference = fmu.variables[name].valueReference
        assert f"use fmi3GetU{other}" in instance.refused(lambda: getattr(instance.slave, f"get{other}")([reference]))
        assert f"use fmi3SetU{other}" in instance.refused(lambda: getattr(instance.slave, f"set{other}")([reference], [1]))


def test_with_wide_types_there_are_doubles_and_elements(build):
    fmu = build(ALL, "--types=wide")
    assert validate_fmu(str(fmu.path)) == []
    assert fmu.variables["values[1000]"].type == fmu.variables["wait"].type == "Float64"
    instance = fmu.instance().initialize()
    instance.set("wait", -0.001)
    instance.set("values[1000]", 0.5)
    instance.set("bits", -1)
    instance.set("count", 2**53 + 1)
    instance.step(0.0, 0.1)
    assert (instance.get("wait_out"), instance.get("values_out[1000]"), instance.get("bits_out")) == (-0.001, 0.5, -1)
    assert instance.get("count_out") == 2**53 + 2


# What is refused, and states


def test_another_kind_of_simulation_or_token_is_refused_with_a_reason(open_fmi3, open_fmu):
    fmu = open_fmi3("CONT_C")
    slave = fmu.slave()
    said = []
    logger = fmi3.fmi3LogMessageCallback(lambda environment, status, category, message: said.append(message.decode()))
    token = fmu.description.instantiationToken.encode()
    exchange = slave.fmi3InstantiateModelExchange(b"x", token, None, False, False, None, logger)
    assert not exchange and "co-simulation only" in said[-1]
    with pytest.raises(Exception):
        fmu.instance(token=open_fmu("CONT_C").description.guid)
    with pytest.raises(Exception):
        fmu.instance(token="")
    instance = fmu.instance()
    assert "co-simulation only" in instance.refused(lambda: instance.slave.fmi3SetTime(instance.slave.component, 1.0))
    wrong = instance.refused(lambda: instance.slave.setFloat64([fmu.variables["SP_INT"].valueReference], [1.0]))
    assert wrong.endswith("is SP_INT, of type Float32: use fmi3SetFloat32")
    assert "NaN" in instance.refused(lambda: instance.set("SP_INT", math.nan))
    instance.initialize()
    assert "CYCLE is a fixed parameter" in instance.refused(lambda: instance.set("CYCLE", 10))


def dependencies(slave, reference):
    """The variables that one depends on. FMPy's own call passes a type where C wants a number."""
    count = ctypes.c_size_t()
    slave.fmi3GetNumberOfVariableDependencies(slave.component, reference, ctypes.byref(count))
    sizes = [(ctypes.c_size_t * count.value)() for _ in range(2)]
    independents, kinds = (ctypes.c_uint * count.value)(), (ctypes.c_int * count.value)()
    slave.fmi3GetVariableDependencies(slave.component, reference, sizes[0], independents, sizes[1], kinds, count.value)
    return list(independents)


def test_outputs_depend_on_nothing_and_at_the_start_on_settings(open_fmi3):
    instance = open_fmi3("HEATER").instance()
    reference = instance.fmu.variables["TEMP"].valueReference
    instance.slave.enterInitializationMode(startTime=0.0)
    settings = dependencies(instance.slave, reference)
    names = {v.valueReference: name for name, v in instance.fmu.variables.items()}
    (unknown,) = [of for of in instance.fmu.description.initialUnknowns if of.variable.name == "TEMP"]
    assert [names[of] for of in settings] == [of.name for of in unknown.dependencies] != []
    instance.slave.exitInitializationMode()
    assert dependencies(instance.slave, reference) == []


def test_a_state_goes_on_bit_by_bit_and_is_not_one_of_fmi_2(open_fmi3, open_fmu):
    instance = open_fmi3("HEATER").instance(events=True).initialize(POWER=70.0)
    instance.event()
    instance.slave.enterStepMode()
    for k in range(50):
        instance.step(k * 0.1, 0.1)
    state = instance.slave.getFMUState()
    saved = bytes(instance.slave.serializeFMUState(state))

    def rest(instance):
        found = []
        for k in range(50, 100):
            instance.step(k * 0.1, 0.1)
            found.append(bits(instance.get("TEMP")))
        return found

    first = rest(instance)
    instance.slave.setFMUState(state)
    assert rest(instance) == first
    other = open_fmi3("HEATER").instance(events=True)
    other.slave.setFMUState(other.slave.deserializeFMUState(saved))
    assert rest(other) == first
    older = open_fmu("HEATER").slave()
    older.instantiate()
    with pytest.raises(fmpy.fmi1.FMICallException):
        older.deSerializeFMUstate(saved)


# The program's own host, presets and packages

LOOP = """step = 1.0
stop = 300.0
record = ["C.LMN", "C.PV_IN", "P.TEMP"]
[fmus]
{fmus}
[connections]
C.LMN = "P.POWER"
P.TEMP = "C.PV_IN"
[settings]
C = {{ MAN_ON = false, SP_INT = 60.0, GAIN = 0.7, TI = 130.0, CYCLE = 1.0 }}
P.CYCLE = 1.0
"""


@pytest.fixture
def loop(tmp_path, packed):
    """The description of the furnace under CONT_C: `order` has the letters of the members, small ones for FMI 2.0."""

    def loop(order):
        names = {"c": "CONT_C", "p": "HEATER"}
        folders = [packed("wide") if of.isupper() else host.FOLDER for of in order]
        fmus = [f'{of.upper()} = "{folder}/{names[of.lower()]}.fmu"' for of, folder in zip(order, folders, strict=True)]
        path = tmp_path / f"{order}.toml"
        path.write_text(LOOP.format(fmus="\n".join(fmus)))
        return path

    return loop


@pytest.fixture
def record(command):
    def record(loop, *options):
        done = subprocess.run([command, "run", loop, "--out=-", *options], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return record


def test_plcfmu_gives_the_bits_of_fmi_2_in_event_mode_and_mixed_in_either_order(loop, record):
    expected = record(loop("cp"))
    assert len(expected.splitlines()) == 302
    for order in ["CP", "PC", "Cp", "pC", "cP"]:
        assert record(loop(order)) == expected, order
    assert record(loop("CP"), "--no-events") == expected
    assert record(loop("PC"), "--no-events") == record(loop("pc")) != expected


def test_ecos_runs_the_loop_with_wide_types(loop, record, command, tmp_path):
    ecospy = ecos()
    path, packed = loop("CP"), tmp_path / "loop.ssp"
    subprocess.run([command, "ssp", path, "--out", packed], check=True, capture_output=True)
    # Unpacked, for of what Ecos unpacks itself it leaves a copy behind.
    with zipfile.ZipFile(packed) as archive:
        archive.extractall(tmp_path / "unpacked")
    rows = [line.split(",") for line in record(path, "--parallel", "--no-events").splitlines()]
    assert rows[0] == ["time", "C.LMN", "C.PV_IN", "P.TEMP"] and len(rows) == 302
    with ecospy.EcosSimulation(step_size=1.0, ssp_path=str(tmp_path / "unpacked")) as simulation:
        assert simulation.init(parameter_set="start")
        for _, lmn, _, temperature in rows[2:]:
            simulation.step()
            assert (simulation.get_real("C::LMN"), simulation.get_real("P::TEMP")) == (float(lmn), float(temperature))
        simulation.terminate()
    assert float(rows[-1][3]) > 50.0


def test_a_study_of_fmi_3_has_the_results_of_fmi_2(loop, command, tmp_path):
    results = {}
    for order in ["cp", "CP", "PC"]:
        study = tmp_path / f"study_{order}.toml"
        study.write_text(f"""loop = "{loop(order)}"
samples = 12
seed = 1
[signals]
setpoint = "C.SP_INT"
process_value = "P.TEMP"
manipulated_value = "C.LMN"
[[axes]]
variable = "P.RISE"
relative = true
uniform = {{ min = 0.75, max = 1.25 }}
""")
        out = tmp_path / order
        done = subprocess.run([command, "study", study, "--format=csv", "--out", out], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        (table,) = out.glob("*.csv")
        results[order] = table.read_text()
    assert results["cp"] == results["CP"] == results["PC"]
    assert len(set(results["cp"].splitlines())) == 13


PLANT = """FUNCTION_BLOCK Plant
VAR_INPUT par : STRUCT level : REAL := 2.5; on : BOOL; END_STRUCT; table : ARRAY[0..2] OF INT := [1, 2, 3]; END_VAR
VAR_INPUT mask : DWORD; wait : TIME := T#1s; long : LINT; name : STRING[8] := 'a'; END_VAR
VAR_OUTPUT sum : INT; level : REAL; END_VAR
BEGIN sum := table[0] + table[1] + table[2]; level := par.level; END_FUNCTION_BLOCK"""


def test_a_preset_of_a_program_has_elements_of_arrays_and_exact_integers(build, command, tmp_path):
    for types in ["native", "wide"]:
        original = build(PLANT, f"--types={types}")
        path = tmp_path / f"{types}.fmu"
        settings = ["table[0]=-5", "mask=4294967295", "wait=0.25", "long=-7", "par.level=0.1", "par.on=true", "CYCLE=0.2"]
        done = subprocess.run([command, "preset", original.path, *(f"--set={of}" for of in settings), "--out", path], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert validate_fmu(str(path)) == []
        preset = Fmu(path, tmp_path / f"unpacked_{types}")
        assert preset.description.instantiationToken != original.description.instantiationToken
        instance = preset.instance().initialize()
        instance.step(0.0, 0.2)
        assert (instance.get("sum"), instance.get("level")) == (0, float(np.float32(0.1)))
        if types == "native":
            assert preset.variables["table"].start == "-5 2 3"
            found = [instance.get(name) for name in ("mask", "wait", "long", "par.on", "CYCLE")]
            assert found == [2**32 - 1, 250, -7, True, 200]
            assert preset.variables["par.level"].start == "0.1"
        # Its start values belong to it.
        start = preset.folder / "resources/start.txt"
        start.write_text(start.read_text().replace("long = -7", "long = -8"))
        with pytest.raises(Exception):
            preset.instance()


FLAT = """step = 0.1
stop = 0.3
record = ["A.level", "A.sum"]
fmus = {{ A = "{preset}", B = "{path}" }}
connections = {{ "B.level" = "A.par_level" }}
settings = {{ "B.par_level" = 0.5 }}
"""


def test_flat_names_are_those_of_hosts_loops_and_terminals(build, command, tmp_path):
    (tmp_path / "plant.scl").write_text(PLANT)
    older = plcfmu.build(tmp_path / "plant.scl", cycle="100ms", out=tmp_path, names="flat")
    native = build(PLANT, "--names=flat")
    elements = ["table_0", "table_1", "table_2"]
    for path, table in [(older, elements), (native.path, ["table"]), (build(PLANT, "--names=flat", "--types=wide").path, elements)]:
        assert validate_fmu(str(path)) == []
        # A preset keeps the names; its values are those of the PLC.
        preset = tmp_path / "preset.fmu"
        settings = ["--set=par.level=7", "--set=table[0]=-5"]
        subprocess.run([command, "preset", path, *settings, "--out", preset], capture_output=True, check=True)
        for of in (path, preset):
            description = fmpy.read_model_description(str(of))
            assert description.variableNamingConvention == "flat"
            assert [v.name for v in description.modelVariables][: 2 + len(table)] == ["par_level", "par_on", *table]
        (tmp_path / "loop.toml").write_text(FLAT.format(path=path, preset=preset))
        done = subprocess.run([command, "run", tmp_path / "loop.toml", "--out=-"], capture_output=True, text=True)
        # 0.5 passes from member to member; -5 + 2 + 3 is 0.
        assert done.stdout.splitlines()[-1].split(",")[1:] == ["0.5", "0"], done.stderr
        with zipfile.ZipFile(path) as fmu:
            header = fmu.read("extra/org.fmi-standard.fmi-ls-ref/Plant_in.csv").decode().splitlines()[0]
        assert header.startswith("time,par_level,par_on,table_0,")
    assert terminals(native) == {"par": {"level": "par_level", "on": "par_on"}}


def test_two_names_that_become_one_flat_name_are_refused_with_both(command, tmp_path):
    (tmp_path / "plant.scl").write_text(PLANT.replace("mask :", "par_level :"))
    arguments = [command, "build", tmp_path / "plant.scl", "--cycle=100ms", "--names=flat", "--out", tmp_path]
    done = subprocess.run(arguments, capture_output=True, text=True)
    assert done.returncode != 0 and not list(tmp_path.glob("*.fmu"))
    assert "Plant: par.level and par_level both have the flat name par_level: rename one of them" in done.stderr


def test_a_preset_is_not_one_of_other_types(open_fmi3, make_preset, tmp_path):
    native, wide = (Fmu(make_preset(open_fmi3("CONT_C", types), tmp_path / f"{types}.fmu", GAIN=5.0), tmp_path / types) for types in ("native", "wide"))
    assert (native.instance().get("GAIN"), wide.instance().get("GAIN")) == (5.0, 5.0)
    tokens = [fmu.description.instantiationToken for fmu in (native, wide)]
    with pytest.raises(Exception):
        native.instance(token=tokens[1])


def test_merging_keeps_an_fmu_of_fmi_3_as_it_is(open_fmi3, command, tmp_path):
    fmu, path = open_fmi3("CONT_C"), tmp_path / "merged.fmu"
    subprocess.run([command, "merge", fmu.path, fmu.path, "--out", path], check=True, capture_output=True)
    assert path.read_bytes() == fmu.path.read_bytes()


def test_the_python_package_builds_for_fmi_3(tmp_path):
    (tmp_path / "counter.scl").write_text(COUNTER)
    path = plcfmu.build(tmp_path / "counter.scl", cycle="100ms", out=tmp_path, fmi=3, types="wide")
    with plcfmu.Fmus() as fmus:
        counter = fmus.start(path)
        counter.step(0.0, 1.0)
        assert counter["count"] == 10
    assert fmpy.read_model_description(str(path)).fmiVersion == "3.0"


def terminals(fmu):
    """The terminals with the variables of their members, after the file was checked with the schema of the standard."""
    folder = fmu.folder / "terminalsAndIcons"
    xml = etree.parse(folder / "terminalsAndIcons.xml")
    schema = pathlib.Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(etree.parse(schema)).assertValid(xml)
    assert (folder / "icon.svg").exists() and (folder / "icon.png").read_bytes()[:4] == b"\x89PNG"
    for icon in xml.iter("TerminalGraphicalRepresentation"):
        assert (folder / f"{icon.get('iconBaseName')}.png").exists()
    found = {
        of.get("name"): {member.get("memberName"): member.get("variableName") for member in of.iter("TerminalMemberVariable")}
        for of in xml.iter("Terminal")
    }
    assert {name for of in found.values() for name in of.values()} <= set(fmu.variables)
    return found


def test_terminals_are_what_one_wires_together(fmu, open_fmi3):
    found = terminals(open_fmi3(fmu.name))
    if fmu.name == "CONT_C":
        assert found == {"SP": {"SP": "SP_INT"}, "PV": {"PV": "PV_IN"}, "LMN": {"LMN": "LMN"}}
    if fmu.name == "HEATER":
        assert found["PV"] == {"PV": "TEMP"} and found["LMN"] == {"LMN": "POWER"}


def test_a_structure_of_a_program_is_a_terminal(build):
    assert terminals(build(PLANT)) == {"par": {"level": "par.level", "on": "par.on"}}
