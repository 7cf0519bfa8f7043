"""The same closed loops run by other co-simulation masters: the recordings are equal, bit for bit.

The loops are the descriptions in plants/loops. `plcfmu run` runs them, `plcfmu ssp` packs them for libcosim and Ecos.

The reference is a loop in this file, which drives the FMUs by FMPy: before each step every connected input gets what the
output has now, then all FMUs step. `plcfmu run` with `exchange = "parallel"`, libcosim, Ecos and the masters made of the Rust
crates `fmi` and `fmi-rs` exchange signals in the same order. What else they do differently does not show, and must not: libcosim counts time in whole
nanoseconds, Ecos adds it up, the others multiply; libcosim and Ecos already pass on outputs in Initialization Mode, before
the restart, and once more after it; libcosim steps on several threads.

Where a recording differs, a test says why:

- FMPy's own master for SSP files begins with 0 on every connection instead of what the outputs are after the restart.
- The examples step one FMU after the other, so that the plant sees the output of the same call; it is the loop with a
  step less of dead time.
- libcosim and Ecos connect no Boolean to a Real. QLMN_MEAN and Q_MEAN are Reals, and also say in a step of many calls what
  the pulses have been.
"""

import copy
import functools
import importlib
import json
import os
import pathlib
import platform
import re
import subprocess
import sys
import types
import zipfile

import pytest

import host
from files import rows


if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

LOOPS = pathlib.Path(__file__).parents[1] / "plants" / "loops"


class Loop:
    """FMUs with their start values, which outputs go to which inputs, and how many steps of which length: a description as
    those in plants/loops."""

    def __init__(self, path):
        self.path = path
        description = tomllib.loads(self.path.read_text(encoding="utf-8"))
        assert description["exchange"] == "parallel"
        self.fmus = {fmu: dict(flat(description["settings"].get(fmu, {}))) for fmu in description["fmus"]}
        self.connections = [
            (*output.split("."), *input.split(".")) for output, input in flat(description["connections"])
        ]
        self.step = description["step"]
        self.steps = round(description["stop"] / self.step)

    def with_start(self, fmu, **values):
        """The same loop with other start values of an FMU."""
        changed = copy.copy(self)
        changed.fmus = {**self.fmus, fmu: {**self.fmus[fmu], **values}}
        return changed


def flat(table, prefix=""):
    """The values of nested tables by their names, joined with points."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


# Reals and analog words; pulses as they are, in steps of a call; pulses as their mean, in steps of many calls.
@pytest.fixture(params=["furnace", "valve", "valve_mean", "chamber", "chamber_mean"])
def loop(request):
    return Loop(LOOPS / f"{request.param}.toml")


@pytest.fixture
def pack(command, tmp_path):
    """Packs a loop as an SSP file, by `plcfmu ssp`."""

    def pack(loop, *options):
        path = tmp_path / f"{loop.path.stem}.ssp"
        arguments = [command, "ssp", loop.path, "--fmus", host.FOLDER, "--out", path, *options]
        subprocess.run(list(map(str, arguments)), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return path

    return pack


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


def by_plcfmu(loop, open_fmu, pack, command):
    arguments = [command, "run", loop.path, "--fmus", host.FOLDER, "--stop", loop.steps * loop.step, "--out", "-"]
    for name in loop.fmus:
        arguments += [f"--record={name}.{output}" for output in open_fmu(name).of("output")]
    run = subprocess.run(list(map(str, arguments)), check=True, stdout=subprocess.PIPE, universal_newlines=True)
    read = {
        f"{name}.{output}": {"Real": float, "Integer": int, "Boolean": lambda text: text == "1"}[variables[output].type]
        for name in loop.fmus
        for variables in [open_fmu(name).variables]
        for output in open_fmu(name).of("output")
    }
    _, *recorded = rows(run.stdout)
    return [{column: read_value(row[column]) for column, read_value in read.items()} for row in recorded]


def by_libcosim(loop, open_fmu, pack, command):
    libcosimpy = package("libcosimpy", (3, 11))
    libcosimpy.CosimLogging.log_output_level(libcosimpy.CosimLogging.CosimLogLevel.ERROR)
    nanoseconds = round(loop.step * 1e9)
    execution = libcosimpy.CosimExecution.CosimExecution.from_ssp_file(str(pack(loop)), nanoseconds)
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


def ecos():
    """The package of Ecos, which loads TBB."""
    try:
        return package("ecospy", (3, 10))
    except OSError as error:
        if "libtbb" not in str(error):
            raise
        pytest.skip(f"Ecos needs TBB, on Debian and Ubuntu 'apt install libtbb12': {error}")


def by_ecos(loop, open_fmu, pack, command):
    ecospy = ecos()
    # Unpacked, for of what Ecos unpacks itself it leaves a copy behind.
    path = pack(loop)
    unpacked = path.parent / "unpacked"
    with zipfile.ZipFile(path) as archive:
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


def by_fmi(loop, open_fmu, pack, command):
    return by_crate("fmi", loop, open_fmu)


def by_fmi_rs(loop, open_fmu, pack, command):
    return by_crate("fmi-rs", loop, open_fmu)


def by_crate(crate, loop, open_fmu):
    description = {"fmus": loop.fmus, "connections": loop.connections, "step": loop.step, "steps": loop.steps}
    run = subprocess.run([closed_loop(), crate], input=json.dumps(description), stdout=subprocess.PIPE,
                         env={**os.environ, "PLCFMU_FMUS": str(host.FOLDER)}, universal_newlines=True)
    assert run.returncode == 0, f"closed_loop {crate} failed; see its standard error"
    return [json.loads(line) for line in run.stdout.splitlines()]


def by_fmpy_for_ssp(loop, open_fmu, pack):
    from fmpy.ssp.simulation import simulate_ssp

    # It takes start values as an argument; those in the file are not read.
    start = [
        types.SimpleNamespace(name=f"{name}.{variable}", value=value)
        for name, values in loop.fmus.items()
        for variable, value in values.items()
    ]
    table = simulate_ssp(
        str(pack(loop, "--only-connected")),
        stop_time=(loop.steps - 0.5) * loop.step,  # it steps until the sum of the steps is no longer below
        step_size=loop.step,
        parameter_set=types.SimpleNamespace(parameters=start),
    )
    columns = [f"{name}.{output}" for name in loop.fmus for output in open_fmu(name).of("output")]
    return [{column: row[column].item() for column in columns} for row in table]


MASTERS = {"plcfmu run": by_plcfmu, "libcosim": by_libcosim, "Ecos": by_ecos, "fmi": by_fmi, "fmi-rs": by_fmi_rs}


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
    build = [os.environ.get("CARGO", "cargo"), "build", "--locked", "--bin", "closed_loop", "--manifest-path", str(manifest),
             "--target-dir", str(manifest.parents[2] / "target")]
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


def assert_equal(recorded, expected):
    """Equal to the last bit: 0.0 and -0.0 differ."""
    assert len(recorded) == len(expected)
    for number, (row, wanted) in enumerate(zip(recorded, expected), 1):
        assert host.exact(row) == host.exact(wanted), f"after step {number}"


@pytest.mark.parametrize("master", MASTERS)
def test_a_master_that_exchanges_all_signals_between_the_steps_records_the_same_bits(
    loop, master, open_fmu, pack, command
):
    assert_equal(MASTERS[master](loop, open_fmu, pack, command), by_fmpy(loop, open_fmu))


@pytest.mark.parametrize("master", ["plcfmu run", "libcosim", "Ecos"])
def test_a_master_does_not_mind_that_initial_unknowns_leave_out_all_outputs(master, open_fmu, pack, command, tmp_path, monkeypatch):
    """What `plcfmu check` calls a departure from the standard that these tools run."""
    loop = Loop(LOOPS / "furnace.toml")
    expected = by_fmpy(loop, open_fmu)
    for name in loop.fmus:
        with zipfile.ZipFile(host.FOLDER / f"{name}.fmu") as old, zipfile.ZipFile(tmp_path / f"{name}.fmu", "w") as new:
            for file in old.namelist():
                new.writestr(file, re.sub(b"<InitialUnknowns>.*</InitialUnknowns>", b"", old.read(file), flags=re.DOTALL))
    monkeypatch.setattr(host, "FOLDER", tmp_path)
    assert_equal(MASTERS[master](loop, open_fmu, pack, command), expected)


def test_each_loop_brings_its_temperature_to_the_setpoint(loop, open_fmu):
    controller, plant = loop.fmus
    setpoint = loop.fmus[controller]["SP_INT"]
    temperature = [row[f"{plant}.TEMP"] for row in by_fmpy(loop, open_fmu)]
    assert temperature[0] < 21.0
    assert temperature[-1] == pytest.approx(setpoint, abs=0.2)


def test_fmpys_master_for_ssp_files_begins_with_0_on_every_connection(loop, open_fmu, pack):
    assert_equal(by_fmpy_for_ssp(loop, open_fmu, pack), by_fmpy(loop, open_fmu, begin_with_0=True))


def test_the_first_call_of_cont_c_tells_whether_a_master_passes_on_the_outputs_of_the_restart(open_fmu, pack):
    # T_PER is 27648 * 20 / 400 = 1382 after the restart, and PV = 4 * 1382 / 276.48 = 19.994; LMN_P = 0.7 * (60 - PV).
    loop = Loop(LOOPS / "furnace.toml")
    assert by_fmpy(loop, open_fmu)[0]["CONT_C.LMN_P"] == pytest.approx(28.004, abs=1e-3)
    assert by_fmpy_for_ssp(loop, open_fmu, pack)[0]["CONT_C.LMN_P"] == host.real(42.0)


def test_in_sequence_a_loop_is_the_same_with_a_step_less_of_dead_time(open_fmu):
    loop = Loop(LOOPS / "furnace.toml")
    at_once = by_fmpy(loop.with_start("HEATER", DELAY_TM=5.0), open_fmu)
    assert_equal(by_fmpy(loop.with_start("HEATER", DELAY_TM=6.0), open_fmu, in_sequence=True), at_once)

    # With the same dead time the power that comes first, in step 1, acts in step 6 and not in step 7.
    in_sequence = by_fmpy(loop.with_start("HEATER", DELAY_TM=5.0), open_fmu, in_sequence=True)
    assert [row["HEATER.T_FURN"] > 20.0 for row in in_sequence[:7]] == [False] * 5 + [True] * 2
    assert [row["HEATER.T_FURN"] > 20.0 for row in at_once[:7]] == [False] * 6 + [True]


@pytest.fixture
def pack_boolean_to_real(pack):
    """Packs valve_mean with QLMNUP on VALVE.DRIVE, which `plcfmu ssp` refuses."""

    def pack_changed(loop, *options):
        path = pack(loop, *options)
        changed = path.with_name("changed.ssp")
        with zipfile.ZipFile(path) as old, zipfile.ZipFile(changed, "w") as new:
            for name in old.namelist():
                content = old.read(name)
                new.writestr(name, content.replace(b'startConnector="QLMN_MEAN"', b'startConnector="QLMNUP"'))
        return changed

    return pack_changed


@pytest.mark.parametrize(
    "master, refusal", [("libcosim", "Unable to create execution"), ("Ecos", "Incompatible connector types")]
)
def test_libcosim_and_ecos_connect_no_boolean_to_a_real(master, refusal, open_fmu, pack_boolean_to_real, command):
    with pytest.raises(Exception, match=refusal):
        MASTERS[master](Loop(LOOPS / "valve_mean.toml"), open_fmu, pack_boolean_to_real, command)


def test_fmpys_master_for_ssp_files_makes_1_of_true_where_the_mean_is_100_percent(
    open_fmu, pack, pack_boolean_to_real
):
    # SP_INT = 50 keeps QLMNUP on for two seconds, and VALVE travels 100 % in 30 s.
    loop = Loop(LOOPS / "valve_mean.toml")
    loop.step, loop.steps = 0.1, 20
    mean, true = (by_fmpy_for_ssp(loop, open_fmu, packed)[-1] for packed in (pack, pack_boolean_to_real))
    # The valve has moved in 19 steps of 0.1 s: in the first one QLMNUP was not yet there.
    assert true["VALVE.LMNR"] == pytest.approx(0.01 * 100.0 * 1.9 / 30.0)
    assert mean["VALVE.LMNR"] == pytest.approx(100.0 * 1.9 / 30.0)
