"""The libraries for other platforms: the same functions, the same table, and the same bits as this machine's library.

PLCFMU_PLATFORM names the platform. The other tests of the C interface run with it too; `.ci/platforms` does all of it.
"""

import ctypes
import pathlib
import random
import shutil
import subprocess
import zipfile
from ctypes import byref

import pytest

import host
import remote
import signals
from libraries import exports
from plcfmu.messages import Log
from test_run import CONTROLLER, LOOP

pytestmark = pytest.mark.skipif(
    host.PLATFORM == "", reason="PLCFMU_PLATFORM is not set: `cargo xtask test --platforms` tests other platforms"
)

TAPES = 6
STEPS = 300


@pytest.fixture(scope="session")
def here(tmp_path_factory):
    """The same FMU with the library of this machine."""
    opened = {}

    def here(fmu):
        if fmu.name not in opened:
            opened[fmu.name] = host.Fmu(fmu.path, tmp_path_factory.mktemp(fmu.name), platform="")
        return opened[fmu.name]

    return here


def test_the_library_exports_the_34_functions_and_the_packers(fmu):
    assert exports(fmu.library()) == {*host.FUNCTIONS, *host.FMI3, "plcfmu_interface"}


def test_the_library_tells_of_itself_what_the_one_of_this_machine_tells(fmu, here):
    assert fmu.told() == here(fmu).told()


# --- The same bits ----------------------------------------------------------------------------------


class Tape:
    """What a host does with an instance, drawn from one seed: settings, then for each step values and a step size."""

    def __init__(self, fmu, seed):
        generator = random.Random(f"{fmu.name} {seed}")
        self.cycle = generator.choice([0.001, 0.01, 0.1, 1.0])
        some = [name for name in fmu.of("input", "parameter") if generator.random() < 0.5]
        self.settings = {name: self.draw(fmu, name, generator) for name in some}
        if "RED_FAC" in self.settings:
            self.settings["RED_FAC"] = generator.randint(1, 20)
        self.settings[fmu.cycle_name] = self.cycle
        inputs, parameters = fmu.of("input"), fmu.of("parameter", variability="tunable")
        self.steps = []
        for _ in range(STEPS):
            changed = [name for name in inputs if generator.random() < 0.3]
            changed += [name for name in parameters if generator.random() < 0.02]
            values = {name: self.draw(fmu, name, generator) for name in changed}
            if "COM_RST" in values:
                values["COM_RST"] = generator.random() < 0.02
            self.steps.append((values, self.cycle * generator.choice([1, 1, 1, 1, 2, 0.5, 10])))

    @staticmethod
    def draw(fmu, name, generator):
        """A value of the variable's type: now and then one far away, mostly one that leaves the block working."""
        if generator.random() < 0.01 and fmu.kinds[name] in ("REAL", "LREAL"):
            return generator.choice([0.0, -0.0, 1e-45, -1e-38, 1e10, -1e30])
        return signals.draw(fmu, name, generator)

    def play(self, fmu):
        """The bits of all variables after initialization and after every step; a refusal is an answer too."""
        instance = fmu.instance()
        seen = []
        for calls in (lambda: instance.start(**self.settings), *(self.step(instance, *step) for step in self.steps)):
            try:
                calls()
            except host.Refused as refusal:
                seen.append((refusal.function, refusal.status, refusal.messages))
            seen.append(instance.values())
        return seen

    @staticmethod
    def step(instance, values, h):
        return lambda: instance.step(h, **values)


@pytest.mark.parametrize("seed", range(TAPES))
def test_a_random_tape_gives_the_bits_of_the_library_of_this_machine(fmu, here, seed):
    tape = Tape(fmu, seed)
    expected = tape.play(here(fmu))
    got = tape.play(fmu)
    for number, (one, other) in enumerate(zip(got, expected)):
        assert one == other, f"answer {number} of tape {seed}"
    assert len(got) == len(expected)


def test_most_tapes_are_played_and_not_refused(fmu, here):
    """A tape of nothing but refusals would prove little."""
    whole = 0
    for seed in range(TAPES):
        seen = Tape(fmu, seed).play(here(fmu))
        whole += not any(isinstance(answer, tuple) for answer in seen)
        values = {name: {answer[name] for answer in seen if isinstance(answer, dict)} for name in fmu.of("output")}
        assert any(len(different) > 1 for different in values.values()), f"tape {seed} moves no output"
    assert whole > TAPES / 2


# --- Panics -----------------------------------------------------------------------------------------


@pytest.fixture
def panicking(tmp_path):
    """The FMU of tests/fmus/panicking, and an instance of it that steps."""
    log = Log(memory=False)
    fmu = host.Fmu(host.FOLDER / "test-only" / "PANICKING.fmu", tmp_path)
    slave = fmu.slave()
    slave.instantiate(log.callbacks, True)
    slave.references = {name: variable.valueReference for name, variable in fmu.variables.items()}
    slave.log = log
    yield slave
    fmu.remote.close()


def test_a_panic_is_fatal_and_leaves_the_host_and_the_other_instances_alive(panicking):
    library, component = panicking.dll, panicking.component
    other = remote.Slave(library, panicking.guid, "other")
    other_log = Log(memory=False)
    other.instantiate(other_log.callbacks, True)
    reference = (ctypes.c_uint * 1)(panicking.references["AT_CALL"])
    assert library.fmi2SetInteger(component, reference, 1, (ctypes.c_int * 1)(3)) == host.OK
    for each in (component, other.component):
        assert library.fmi2SetupExperiment(each, 0, 0.0, 0.0, 0, 0.0) == host.OK
        assert library.fmi2EnterInitializationMode(each) == host.OK
        assert library.fmi2ExitInitializationMode(each) == host.OK
    assert library.fmi2DoStep(component, 0.0, 2.0, 1) == host.OK
    assert library.fmi2DoStep(component, 2.0, 1.0, 1) == host.FATAL
    ((_, status, category, text),) = panicking.log.messages
    assert (status, category) == (host.FATAL, "logStatusFatal")
    assert text.startswith("fmi2DoStep: panic in the block: call"), text
    state = ctypes.c_void_p()
    assert library.fmi2GetFMUstate(component, byref(state)) == host.FATAL
    for time in range(10):
        assert library.fmi2DoStep(other.component, float(time), 1.0, 1) == host.OK
    other.freeInstance()
    panicking.freeInstance()
    assert library.fmi2GetVersion() == b"2.0"


# --- The command --------------------------------------------------------------------------------------


@pytest.fixture
def run_there(tmp_path):
    """Runs the command `plcfmu` for Windows, out of its archive, in an empty folder; returns what it prints."""
    if host.PLATFORM != "win64":
        pytest.skip("the command is built for Windows and for this machine")
    packed = next((remote.BUILT / "win64" / "wheel").glob("plcfmu-*-win64.zip"), None)
    if not packed:
        pytest.skip("there is no archive of the command: `.ci/platforms build` makes it")
    with zipfile.ZipFile(packed) as archive:
        archive.extractall(tmp_path)
    program = tmp_path / packed.stem / "plcfmu.exe"

    def run_there(*arguments):
        pipe = subprocess.PIPE
        process = remote.run(host.PLATFORM, program, *arguments, stdout=pipe, stderr=pipe, cwd=tmp_path, text=True)
        output, errors = process.communicate()
        assert process.returncode == 0, errors
        return output

    return run_there


@pytest.fixture
def copied(open_fmu, tmp_path):
    """A copy of a packed FMU by its name, in the folder where `run_there` runs."""
    return lambda name: pathlib.Path(shutil.copy(open_fmu(name).path, tmp_path))


def test_the_command_writes_the_same_file_as_here(run_there, copied, command):
    fmus = [copied(name) for name in ("CONT_C", "HEATER")]
    arguments = ["run", *(fmu.name for fmu in fmus), "--stop=100", "--step=1", "--out=-"]
    arguments += [f"--connect={source}={target}" for source, target in LOOP.items()]
    arguments += [f"--set=CONT_C.{name}={value}" for name, value in CONTROLLER.items()]
    here = subprocess.run([command, *arguments], cwd=fmus[0].parent, stdout=subprocess.PIPE, check=True, text=True).stdout
    assert here.count("\n") > 50
    assert run_there(*arguments) == here


def test_the_command_reads_and_checks_an_fmu(run_there, copied):
    fmu = copied("CONT_C")
    assert "CONT_C" in run_there("info", fmu.name)
    assert "WRONG" not in run_there("check", "--run", fmu.name)
