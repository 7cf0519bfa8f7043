"""The same closed loops run by other co-simulation masters: the recordings are equal, bit for bit.

The reference is a loop in this file, which drives the FMUs by FMPy: before each step every connected input gets what the
output has now, then all FMUs step. libcosim, Ecos and the masters made of the Rust crates `fmi` and `fmi-rs` exchange
signals in the same order. What else they do differently does not show, and must not: libcosim counts time in whole
nanoseconds, Ecos adds it up, the others multiply; libcosim and Ecos already pass on outputs in Initialization Mode, before
the restart, and once more after it; libcosim steps on several threads.

Where a recording differs, a test says why:

- FMPy's own master for SSP files begins with 0 on every connection instead of what the outputs are after the restart.
- The examples step one FMU after the other, so that the plant sees the output of the same call; it is the loop with a
  step less of dead time.
- libcosim and Ecos connect no Boolean to a Real. QLMN_MEAN and Q_MEAN are Reals, and also say in a step of many calls what
  the pulses have been.
"""

import functools
import importlib
import json
import os
import pathlib
import platform
import subprocess
import sys
import types
import zipfile

import pytest

import host


class Loop:
    """FMUs with their start values, which outputs go to which inputs, and how many steps of which length."""

    def __init__(self, fmus, connections, step, steps):
        self.fmus = fmus
        self.connections = [(*output.split("."), *input.split(".")) for output, input in connections.items()]
        self.step = step
        self.steps = steps

    def with_start(self, fmu, **values):
        """The same loop with other start values of an FMU."""
        changed = Loop({**self.fmus, fmu: {**self.fmus[fmu], **values}}, {}, self.step, self.steps)
        changed.connections = self.connections
        return changed


CONT_C = {"MAN_ON": False, "SP_INT": 60.0, "PVPER_ON": True, "PV_FAC": 4.0, "GAIN": 1.4, "TI": 80.0}
CONT_S = {"SP_INT": 50.0, "GAIN": 1.2, "TI": 6.0, "DEADB_W": 0.2, "MTR_TM": 30.0, "PULSE_TM": 0.1, "BREAK_TM": 0.1,
          "CYCLE": 0.1}
VALVE = {"MTR_TM": 30.0, "HX_TM": 5.0, "SENS_TM": 1.0, "CYCLE": 0.1}
PULS_CTR = {"SP_INT": 50.0, "RED_FAC": 20, "DI_CONT_C.PV_FAC": 2.0, "DI_CONT_C.PV_OFF": -100.0, "DI_CONT_C.GAIN": 3.0,
            "DI_CONT_C.TI": 10.0, "DI_PULSEGEN.P_B_TM": 0.01}
THERMO = {"HEAT_TM": 1.0, "ZONE_TM": 10.0}

# Reals and analog words; pulses as they are, in steps of a call; pulses as their mean, in steps of many calls.
LOOPS = {
    "CONT_C with HEATER": Loop(
        {"CONT_C": CONT_C, "HEATER": {"CYCLE": 1.0}},
        {"CONT_C.LMN": "HEATER.POWER", "HEATER.T_PER": "CONT_C.PV_PER"},
        step=1.0, steps=600),
    "CONT_S with VALVE": Loop(
        {"CONT_S": CONT_S, "VALVE": VALVE},
        {"CONT_S.QLMNUP": "VALVE.UP", "CONT_S.QLMNDN": "VALVE.DOWN", "VALVE.TEMP": "CONT_S.PV_IN",
         "VALVE.LMNR_HS": "CONT_S.LMNR_HS", "VALVE.LMNR_LS": "CONT_S.LMNR_LS"},
        step=0.1, steps=600),
    "CONT_S with VALVE by QLMN_MEAN": Loop(
        {"CONT_S": CONT_S, "VALVE": VALVE},
        {"CONT_S.QLMN_MEAN": "VALVE.DRIVE", "VALVE.TEMP": "CONT_S.PV_IN",
         "VALVE.LMNR_HS": "CONT_S.LMNR_HS", "VALVE.LMNR_LS": "CONT_S.LMNR_LS"},
        step=0.3, steps=200),
    "PULS_CTR with THERMO": Loop(
        {"PULS_CTR": PULS_CTR, "THERMO": THERMO},
        {"PULS_CTR.QPOS_P": "THERMO.HEAT", "THERMO.T_PER": "PULS_CTR.PV_PER"},
        step=0.01, steps=4000),
    "PULS_CTR with THERMO by Q_MEAN": Loop(
        {"PULS_CTR": PULS_CTR, "THERMO": THERMO},
        {"PULS_CTR.Q_MEAN": "THERMO.DRIVE", "THERMO.T_PER": "PULS_CTR.PV_PER"},
        step=0.2, steps=200),
}


@pytest.fixture(params=LOOPS)
def loop(request):
    return LOOPS[request.param]


# The masters: each gives the outputs after every step, as a dictionary like {"CONT_C.LMN": 84.0, ...}


def by_fmpy(loop, open_fmu, in_sequence=False, begin_with_0=False):
    """The reference. `in_sequence` is the order of the examples, `begin_with_0` that of FMPy's master for SSP files."""
    fmus = {name: open_fmu(name).start(**start) for name, start in loop.fmus.items()}
    signals = {}

    def read():
        for source, output, target, input in loop.connections:
            signals[target, input] = fmus[source][output]

    rows = []
    for number in range(loop.steps):
        read()
        if begin_with_0 and number == 0:
            signals = dict.fromkeys(signals, 0)
        for name, fmu in fmus.items():
            if in_sequence:
                read()
            fmu.set(**{input: value for (target, input), value in signals.items() if target == name})
            fmu.do("fmi2DoStep", number * loop.step, loop.step, 1)
        rows.append({
            f"{name}.{output}": value
            for name, fmu in fmus.items()
            for output, value in fmu.get(fmu.fmu.of("output")).items()
        })
    return rows


def by_libcosim(loop, open_fmu, folder):
    libcosimpy = package("libcosimpy", (3, 11))
    libcosimpy.CosimLogging.log_output_level(libcosimpy.CosimLogging.CosimLogLevel.ERROR)
    nanoseconds = round(loop.step * 1e9)
    execution = libcosimpy.CosimExecution.CosimExecution.from_ssp_file(str(ssp(loop, open_fmu, folder)), nanoseconds)
    observer = libcosimpy.CosimObserver.CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    read = {
        "Real": observer.last_real_values,
        "Integer": observer.last_integer_values,
        "Boolean": observer.last_boolean_values,
    }
    slaves = {name: execution.slave_index_from_instance_name(name) for name in loop.fmus}
    columns = [
        (f"{name}.{variable.name}", read[variable.type], slave, [variable.valueReference])
        for name, slave in slaves.items()
        for variable in map(open_fmu(name).variables.get, open_fmu(name).of("output"))
    ]
    rows = []
    for _ in range(loop.steps):
        assert execution.step()
        rows.append({column: read_values(slave, reference)[0] for column, read_values, slave, reference in columns})
    return rows


def by_ecos(loop, open_fmu, folder):
    try:
        ecospy = package("ecospy", (3, 10))
    except OSError as error:
        if "libtbb" not in str(error):
            raise
        pytest.skip(f"Ecos needs TBB, on Debian and Ubuntu 'apt install libtbb12': {error}")
    # Unpacked, for of what Ecos unpacks itself it leaves a copy behind.
    unpacked = folder / "unpacked"
    with zipfile.ZipFile(ssp(loop, open_fmu, folder)) as archive:
        archive.extractall(unpacked)
    with ecospy.EcosSimulation(step_size=loop.step, ssp_path=str(unpacked)) as simulation:
        read = {"Real": simulation.get_real, "Integer": simulation.get_integer, "Boolean": simulation.get_bool}
        columns = [
            (f"{name}.{output}", f"{name}::{output}", read[open_fmu(name).variables[output].type])
            for name in loop.fmus
            for output in open_fmu(name).of("output")
        ]
        assert simulation.init(parameter_set="start")
        rows = []
        for _ in range(loop.steps):
            simulation.step()
            rows.append({column: read_value(identifier) for column, identifier, read_value in columns})
        simulation.terminate()
        return rows


def by_fmi(loop, open_fmu, folder):
    return by_crate("fmi", loop, open_fmu)


def by_fmi_rs(loop, open_fmu, folder):
    return by_crate("fmi-rs", loop, open_fmu)


def by_crate(crate, loop, open_fmu):
    description = {"fmus": loop.fmus, "connections": loop.connections, "step": loop.step, "steps": loop.steps}
    run = subprocess.run([closed_loop(), crate], input=json.dumps(description), stdout=subprocess.PIPE,
                         env={**os.environ, "PLCFMU_FMUS": str(host.FOLDER)}, universal_newlines=True)
    assert run.returncode == 0, f"closed_loop {crate} failed; see its standard error"
    return [json.loads(line) for line in run.stdout.splitlines()]


def by_fmpy_for_ssp(loop, open_fmu, folder):
    from fmpy.ssp.simulation import simulate_ssp

    # It takes start values as an argument; those in the file are not read.
    start = [
        types.SimpleNamespace(name=f"{name}.{variable}", value=value)
        for name, values in loop.fmus.items()
        for variable, value in values.items()
    ]
    table = simulate_ssp(
        str(ssp(loop, open_fmu, folder)),
        stop_time=(loop.steps - 0.5) * loop.step,  # it steps until the sum of the steps is no longer below
        step_size=loop.step,
        parameter_set=types.SimpleNamespace(parameters=start),
    )
    columns = [f"{name}.{output}" for name in loop.fmus for output in open_fmu(name).of("output")]
    return [{column: row[column].item() for column in columns} for row in table]


MASTERS = {"libcosim": by_libcosim, "Ecos": by_ecos, "fmi": by_fmi, "fmi-rs": by_fmi_rs}


def package(name, oldest):
    """A Python package; skips the test where tests/requirements.txt has none, and only there."""
    if sys.version_info < oldest or (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        pytest.skip(f"{name} is for Linux on x86_64 with Python {'.'.join(map(str, oldest))} or newer")
    module = importlib.import_module(name)
    if name == "libcosimpy":
        for part in ("CosimExecution", "CosimLogging", "CosimObserver"):
            importlib.import_module(f"{name}.{part}")
    return module


@functools.lru_cache(maxsize=None)
def closed_loop():
    """The program of tests/importers that runs a loop by a crate; built here, once, where `cargo xtask test` has not."""
    manifest = pathlib.Path(__file__).parent / "importers" / "Cargo.toml"
    build = [os.environ.get("CARGO", "cargo"), "build", "--bin", "closed_loop", "--manifest-path", str(manifest)]
    run = subprocess.run([*build, "--message-format=json-render-diagnostics"], stdout=subprocess.PIPE,
                         env={**os.environ, **libclang()}, universal_newlines=True)
    assert run.returncode == 0, f"{' '.join(build)} failed; see its standard error"
    built = [json.loads(line).get("executable") for line in run.stdout.splitlines()]
    return next(filter(None, built))


def libclang():
    """What the crate `fmi` needs to be built: the libclang of PyPI, which comes without the compiler's own headers."""
    if "LIBCLANG_PATH" in os.environ:
        return {}
    headers = subprocess.run([os.environ.get("CC", "cc"), "-print-file-name=include"], stdout=subprocess.PIPE,
                             check=True, universal_newlines=True).stdout.strip()
    folder = pathlib.Path(importlib.import_module("clang").__file__).parent
    return {"LIBCLANG_PATH": str(folder / "native"), "BINDGEN_EXTRA_CLANG_ARGS": f"-I{headers}"}


def ssp(loop, open_fmu, folder):
    """The loop as an SSP file (System Structure and Parameterization): its FMUs, start values and connections."""

    def type(name, variable):
        return open_fmu(name).variables[variable].type

    def connector(name, variable, kind):
        return f'<ssd:Connector name="{variable}" kind="{kind}"><ssc:{type(name, variable)}/></ssd:Connector>'

    def parameter(name, variable, value):
        value = json.dumps(value)  # as XML writes it too: 1.0, 20, true
        return f'<ssv:Parameter name="{variable}"><ssv:{type(name, variable)} value="{value}"/></ssv:Parameter>'

    def component(name, start):
        inputs = [input for _, _, target, input in loop.connections if target == name]
        connectors = [connector(name, variable, "input") for variable in inputs]
        connectors += [connector(name, variable, "output") for variable in open_fmu(name).of("output")]
        parameters = [parameter(name, *value) for value in start.items()]
        return f"""
      <ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="resources/{name}.fmu">
        <ssd:Connectors>{"".join(connectors)}</ssd:Connectors>
        <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
          <ssv:ParameterSet version="1.0" name="start"><ssv:Parameters>{"".join(parameters)}</ssv:Parameters></ssv:ParameterSet>
        </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
      </ssd:Component>"""

    def connection(source, output, target, input):
        return f"""
      <ssd:Connection startElement="{source}" startConnector="{output}" endElement="{target}" endConnector="{input}"/>"""

    path = folder / "loop.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        for name in loop.fmus:
            archive.write(open_fmu(name).path, f"resources/{name}.fmu")
        archive.writestr("SystemStructure.ssd", f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="loop"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
  <ssd:System name="loop">
    <ssd:Elements>{"".join(component(*fmu) for fmu in loop.fmus.items())}
    </ssd:Elements>
    <ssd:Connections>{"".join(connection(*each) for each in loop.connections)}
    </ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
""")
    return path


def assert_equal(recorded, expected):
    """Equal to the last bit: 0.0 and -0.0 differ."""
    assert len(recorded) == len(expected)
    for number, (row, wanted) in enumerate(zip(recorded, expected), 1):
        assert host.exact(row) == host.exact(wanted), f"after step {number}"


@pytest.mark.parametrize("master", MASTERS)
def test_a_master_that_exchanges_all_signals_between_the_steps_records_the_same_bits(loop, master, open_fmu, tmp_path):
    assert_equal(MASTERS[master](loop, open_fmu, tmp_path), by_fmpy(loop, open_fmu))


def test_each_loop_brings_its_temperature_to_the_setpoint(loop, open_fmu):
    controller, plant = loop.fmus
    setpoint = loop.fmus[controller]["SP_INT"]
    temperature = [row[f"{plant}.TEMP"] for row in by_fmpy(loop, open_fmu)]
    assert temperature[0] < 21.0
    assert temperature[-1] == pytest.approx(setpoint, abs=0.2)


def test_fmpys_master_for_ssp_files_begins_with_0_on_every_connection(loop, open_fmu, tmp_path):
    assert_equal(by_fmpy_for_ssp(loop, open_fmu, tmp_path), by_fmpy(loop, open_fmu, begin_with_0=True))


def test_the_first_call_of_cont_c_tells_whether_a_master_passes_on_the_outputs_of_the_restart(open_fmu, tmp_path):
    # T_PER is 27648 * 20 / 400 = 1382 after the restart, and PV = 4 * 1382 / 276.48 = 19.994; LMN_P = 1.4 * (60 - PV).
    loop = LOOPS["CONT_C with HEATER"]
    assert by_fmpy(loop, open_fmu)[0]["CONT_C.LMN_P"] == pytest.approx(56.008, abs=1e-3)
    assert by_fmpy_for_ssp(loop, open_fmu, tmp_path)[0]["CONT_C.LMN_P"] == host.real(84.0)


def test_in_sequence_a_loop_is_the_same_with_a_step_less_of_dead_time(open_fmu):
    loop = LOOPS["CONT_C with HEATER"]
    at_once = by_fmpy(loop.with_start("HEATER", DELAY_TM=5.0), open_fmu)
    assert_equal(by_fmpy(loop.with_start("HEATER", DELAY_TM=6.0), open_fmu, in_sequence=True), at_once)

    # With the same dead time the power that comes first, in step 1, acts in step 6 and not in step 7.
    in_sequence = by_fmpy(loop.with_start("HEATER", DELAY_TM=5.0), open_fmu, in_sequence=True)
    assert [row["HEATER.T_FURN"] > 20.0 for row in in_sequence[:7]] == [False] * 5 + [True] * 2
    assert [row["HEATER.T_FURN"] > 20.0 for row in at_once[:7]] == [False] * 6 + [True]


# SP_INT = 50 keeps QLMNUP on for two seconds, and VALVE travels 100 % in 30 s.
BOOLEAN_TO_REAL = Loop({"CONT_S": CONT_S, "VALVE": VALVE}, {"CONT_S.QLMNUP": "VALVE.DRIVE"}, step=0.1, steps=20)


@pytest.mark.parametrize(
    "master, refusal", [("libcosim", "Unable to create execution"), ("Ecos", "Incompatible connector types")]
)
def test_libcosim_and_ecos_connect_no_boolean_to_a_real(master, refusal, open_fmu, tmp_path):
    with pytest.raises(Exception, match=refusal):
        MASTERS[master](BOOLEAN_TO_REAL, open_fmu, tmp_path)


def test_fmpys_master_for_ssp_files_makes_1_of_true_where_the_mean_is_100_percent(open_fmu, tmp_path):
    mean = Loop(BOOLEAN_TO_REAL.fmus, {"CONT_S.QLMN_MEAN": "VALVE.DRIVE"}, BOOLEAN_TO_REAL.step, BOOLEAN_TO_REAL.steps)
    true, full = (by_fmpy_for_ssp(loop, open_fmu, tmp_path)[-1] for loop in (BOOLEAN_TO_REAL, mean))
    # The valve has moved in 19 steps of 0.1 s: in the first one QLMNUP was not yet there.
    assert true["VALVE.LMNR"] == pytest.approx(0.01 * 100.0 * 1.9 / 30.0)
    assert full["VALVE.LMNR"] == pytest.approx(100.0 * 1.9 / 30.0)
