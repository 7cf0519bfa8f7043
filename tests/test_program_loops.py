"""The loops of the example programs: what happens in them, the same bits in other masters, and the guide that shows them."""

import pathlib
import shutil
import subprocess
import xml.etree.ElementTree
import zipfile

import fmpy
import pytest
from fmpy import fmi2

import host
import test_masters
from files import rows

ROOT = pathlib.Path(__file__).parents[1]
PROGRAMS = ROOT / "examples" / "programs"
LOOPS = ["tank", "furnace", "conveyor"]


class Packed:
    """The FMU of a member of a loop, unpacked."""

    def __init__(self, folder):
        self.folder = folder
        self.description = fmpy.read_model_description(str(folder))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}

    def of(self, causality):
        return [name for name, variable in self.variables.items() if variable.causality == causality]

    def start(self, values):
        identifier = self.description.coSimulation.modelIdentifier
        self.slave = fmi2.FMU2Slave(guid=self.description.guid, unzipDirectory=str(self.folder),
                                    modelIdentifier=identifier, instanceName="member")
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.set(values)
        self.slave.exitInitializationMode()

    def set(self, values):
        for name, value in values.items():
            variable = self.variables[name]
            getattr(self.slave, f"set{variable.type}")([variable.valueReference], [value])

    def get(self, name):
        variable = self.variables[name]
        value = getattr(self.slave, f"get{variable.type}")([variable.valueReference])[0]
        return bool(value) if variable.type == "Boolean" else value


@pytest.fixture(params=LOOPS)
def loop(request):
    return test_masters.Loop(PROGRAMS / f"{request.param}_loop.toml")


@pytest.fixture
def packed(loop, command, tmp_path):
    """The loop as an SSP file, and its FMUs by the names of the members."""
    path = tmp_path / "loop.ssp"
    subprocess.run([command, "ssp", str(loop.path), "--fmus", str(host.FOLDER), "--out", str(path)], check=True,
                   capture_output=True)
    fmus = {}
    with zipfile.ZipFile(path) as archive:
        system = xml.etree.ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        archive.extractall(tmp_path / "ssp")
    for component in (element for element in system.iter() if element.tag.endswith("}Component")):
        name = component.get("name")
        folder = tmp_path / name
        fmpy.extract(str(tmp_path / "ssp" / component.get("source")), str(folder))
        fmus[name] = Packed(folder)
    return path, fmus


def by_fmpy(loop, fmus):
    """Before each step every connected input gets what the output has now, then all FMUs step."""
    for name, values in loop.fmus.items():
        fmus[name].start(values)
    rows = []
    for number in range(loop.steps):
        signals = [(target, input, fmus[source].get(output)) for source, output, target, input in loop.connections]
        for target, input, value in signals:
            fmus[target].set({input: value})
        for fmu in fmus.values():
            fmu.slave.doStep(number * loop.step, loop.step)
        rows.append({f"{name}.{output}": fmu.get(output) for name, fmu in fmus.items() for output in fmu.of("output")})
    for fmu in fmus.values():
        fmu.slave.terminate()
        fmu.slave.freeInstance()
    return rows


@pytest.mark.parametrize("master", ["plcfmu run", "libcosim", "Ecos"])
def test_a_master_records_the_bits_of_the_others(loop, packed, master, command):
    path, fmus = packed
    recorded = test_masters.MASTERS[master](loop, fmus.__getitem__, lambda loop: path, command)
    test_masters.assert_equal(recorded, by_fmpy(loop, fmus))


def changes(command, folder, name, column):
    """When a column of a loop's recording changes, and to what."""
    out = folder / "out.csv"
    arguments = [command, "run", str(PROGRAMS / f"{name}_loop.toml"), "--fmus", str(host.FOLDER), "--out", str(out)]
    subprocess.run(arguments, check=True, capture_output=True)
    found = []
    for row in rows(out):
        if not found or found[-1][1] != float(row[column]):
            found.append((float(row["time"]), float(row[column])))
    return found


def test_the_tank_is_filled_settles_and_is_held(command, tmp_path):
    # The valve has opened 1 s behind the start. From then on 5 % come with each call: 80 % are passed 6.5 s later, for the loop
    # exchanges signals once a step. It settles for 2 s.
    steps = changes(command, tmp_path, "tank", "FILLING.step")
    assert steps == [(0.0, 0), (0.5, 10), (2.0, 20), (8.5, 30), (11.0, 40)]
    assert changes(command, tmp_path, "tank", "TANK.level")[-1][1] == pytest.approx(50.0, abs=0.1)


def test_the_furnace_follows_its_ramp(command, tmp_path):
    # The zone is enabled in its first call, in which the ramp is at 0: up to 60 degC at 6 K/min it takes 600 s.
    ramp = changes(command, tmp_path, "furnace", "ZONE.rampSetpoint")
    end = next(time for time, value in ramp if value == 60.0)
    assert end - ramp[0][0] == pytest.approx(600.0, abs=1.5)
    assert changes(command, tmp_path, "furnace", "HEATER.TEMP")[-1][1] == pytest.approx(60.0, abs=0.2)


def test_the_belts_start_against_the_flow_behind_the_horn_and_count_parts(command, tmp_path):
    # 3 s of horn, 1 s for each belt, and a call for each change of a step.
    states = changes(command, tmp_path, "conveyor", "CONVEYOR.state")
    assert [state for _, state in states] == [0, 1, 2, 3]
    assert states[2][0] - states[1][0] == pytest.approx(3.1) and 3.0 <= states[3][0] - states[2][0] <= 3.7
    parts = [time for time, _ in changes(command, tmp_path, "conveyor", "CONVEYOR.parts")]
    assert all(later - earlier == pytest.approx(4.2) for earlier, later in zip(parts[1:], parts[2:]))


def test_the_commands_of_the_guide_run_as_printed_and_draw_its_pictures(command, tmp_path):
    folder = tmp_path / "examples" / "programs"
    shutil.copytree(PROGRAMS, folder)
    fmus = tmp_path / "target" / "fmu"
    fmus.mkdir(parents=True)
    shutil.copy(host.FOLDER / "HEATER.fmu", fmus)
    guide = (ROOT / "docs" / "tia.md").read_text(encoding="utf-8")
    commands = [line.split("#")[0].split() for line in guide.splitlines() if line.startswith("    plcfmu ")]
    assert [words[1] for words in commands] == ["check", "build", "info", "test", "run", "show", "run", "run"]
    for words in commands:
        done = subprocess.run([command, *words[1:]], cwd=folder, env=host.environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    for name in LOOPS:
        picture = f"tia_{name}.svg"
        assert f"({picture})" in guide
        drawn = (folder / picture).read_text(encoding="utf-8")
        assert drawn == (ROOT / "docs" / picture).read_text(encoding="utf-8"), f"renew docs/{picture}"
