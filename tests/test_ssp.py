"""`plcfmu ssp`: valid files with everything in them, and plants of many loops that start from a parameter file's values in
other masters, with nothing set by hand. That these compute the bits of `plcfmu run`, test_masters.py says."""

import json
import pathlib
import subprocess
import zipfile

import fmpy
import pytest
from fmpy.ssp.ssd import get_connections, read_ssd
from lxml import etree

import host
from test_masters import ecos, package

LOOPS = sorted((pathlib.Path(__file__).parents[1] / "plants" / "loops").glob("*.toml"))
FURNACE = next(path for path in LOOPS if path.stem == "furnace")
SCHEMA = pathlib.Path(fmpy.__file__).parent / "ssp" / "schema"
SPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
}


@pytest.fixture
def ssp(command, tmp_path):
    """Calls `plcfmu ssp` in an empty folder."""

    def ssp(*arguments):
        run = [command, "ssp", *map(str, arguments), f"--fmus={host.FOLDER}"]
        return subprocess.run(run, cwd=tmp_path, capture_output=True, text=True)

    return ssp


@pytest.fixture
def packed(ssp, tmp_path):
    """Packs plant.ssp; gives its path and what was remarked."""

    def packed(*arguments):
        done = ssp(*arguments, "--out=plant.ssp")
        assert done.returncode == 0, done.stderr
        remarks = done.stderr.splitlines()
        noted = [line for line in remarks if line != "note: plant.ssp was replaced"]
        assert all(line.startswith("remark: ") for line in noted)
        return tmp_path / "plant.ssp", [line[len("remark: ") :] for line in noted]

    return packed


def structure(path):
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read("SystemStructure.ssd"))


def refused(ssp, tmp_path, *arguments):
    done = ssp(*arguments, "--out=plant.ssp")
    assert done.returncode == 1 and not (tmp_path / "plant.ssp").exists()
    *_, sentence = done.stderr.splitlines()
    return sentence[len("error: ") :]


@pytest.mark.parametrize("path", LOOPS, ids=lambda path: path.stem)
def test_a_file_is_valid_by_the_schemas_of_ssp_1_0(packed, path):
    xml = structure(packed(path)[0])
    etree.XMLSchema(etree.parse(SCHEMA / "SystemStructureDescription.xsd")).assertValid(xml)
    values = etree.XMLSchema(etree.parse(SCHEMA / "SystemStructureParameterValues.xsd"))
    for parameter_set in xml.iterfind(".//ssv:ParameterSet", SPACES):
        values.assertValid(parameter_set)


@pytest.mark.parametrize("path", LOOPS, ids=lambda path: path.stem)
def test_all_inputs_and_outputs_are_connectors_with_their_type_and_unit(packed, path, open_fmu):
    xml = structure(packed(path)[0])
    units = {unit.get("name") for unit in xml.iterfind("ssd:Units/ssc:Unit", SPACES)}
    for component in xml.iterfind(".//ssd:Component", SPACES):
        fmu = open_fmu(component.get("name"))
        found = {
            (connector.get("name"), connector.get("kind"), etree.QName(connector[0]).localname, connector[0].get("unit"))
            for connector in component.iterfind("ssd:Connectors/ssd:Connector", SPACES)
        }
        assert found == {
            (name, causality, variable.type, variable.unit)
            for name, variable in fmu.variables.items()
            for causality in [variable.causality]
            if causality in ("input", "output")
        }
        assert {unit for *_, unit in found if unit} <= units


def test_a_unit_is_defined_as_in_the_fmus(packed, open_fmu):
    xml = structure(packed(FURNACE)[0])
    (celsius,) = xml.iterfind("ssd:Units/ssc:Unit[@name='degC']/ssc:BaseUnit", SPACES)
    assert dict(celsius.attrib) == {"K": "1", "offset": "273.15"}


def test_fmpy_reads_components_connections_and_the_experiment(packed):
    # It looks for a connection of every input that has a connector.
    path, _ = packed(FURNACE, "--only-connected")
    system = read_ssd(str(path)).system
    assert [(component.name, component.source) for component in system.elements] == [
        ("CONT_C", "resources/CONT_C.fmu"), ("HEATER", "resources/HEATER.fmu"),
    ]  # fmt: skip
    ends = {tuple(f"{end.parent.name}.{end.name}" for end in connection) for connection in get_connections(system)}
    assert ends == {("CONT_C.LMN", "HEATER.POWER"), ("HEATER.T_PER", "CONT_C.PV_PER")}
    experiment = structure(path).find("ssd:DefaultExperiment", SPACES)
    assert (float(experiment.get("startTime")), float(experiment.get("stopTime"))) == (0.0, 600.0)


def test_version_2_0_is_the_same_but_for_the_version(packed):
    first = etree.tostring(structure(packed(LOOPS[0])[0]))
    second = etree.tostring(structure(packed(LOOPS[0], "--ssp-version=2.0")[0]))
    assert second == first.replace(b'version="1.0"', b'version="2.0"') != first


def test_the_same_loop_gives_the_same_bytes(packed):
    path, _ = packed(LOOPS[0])
    first = path.read_bytes()
    path.unlink()
    assert packed(LOOPS[0])[0].read_bytes() == first


def plant(tmp_path):
    """Forty loops, one file: the REALs are not round."""
    loops = {f"TIC{number}": {"GAIN": number / 7, "TI": 20.0 + number, "TD": 1.5} for number in range(101, 140)}
    loops["FEED"] = {"PER_TM": 2.5, "P_B_TM": 0.02}
    for loop in loops.values():
        if "GAIN" in loop:
            loop.update(MAN_ON=False, SP_INT=50.25, PV_IN=49.125)
    path = tmp_path / "plant.json"
    path.write_text(json.dumps(loops))
    return path, loops


def test_a_plant_of_forty_loops_holds_each_fmu_once(packed, tmp_path):
    path, loops = plant(tmp_path)
    plant_ssp, _ = packed(path)
    xml = structure(plant_ssp)
    assert [component.get("name") for component in xml.iterfind(".//ssd:Component", SPACES)] == list(loops)
    with zipfile.ZipFile(plant_ssp) as archive:
        assert archive.namelist() == ["SystemStructure.ssd", "resources/CONT_C.fmu", "resources/PULSEGEN.fmu"]
        assert archive.read("resources/CONT_C.fmu") == (host.FOLDER / "CONT_C.fmu").read_bytes()


def recording(command, tmp_path, path, variables):
    """The rows that `plcfmu run` records of the plant after each step, in parallel."""
    record = [f"--record={variable}" for variable in variables]
    run = [command, "run", path, f"--fmus={host.FOLDER}", "--parallel", "--step=0.5", "--stop=5.0", "--out=-", *record]
    text = subprocess.run(list(map(str, run)), check=True, capture_output=True, text=True, cwd=tmp_path).stdout
    header, _, *rows = text.splitlines()
    assert header == ",".join(["time", *variables])
    return [dict(zip(variables, map(float, row.split(",")[1:]))) for row in rows]


def test_libcosim_runs_the_plant_with_the_values_of_the_file(command, packed, tmp_path, open_fmu):
    libcosimpy = package("libcosimpy", (3, 11))
    libcosimpy.CosimLogging.log_output_level(libcosimpy.CosimLogging.CosimLogLevel.ERROR)
    path, loops = plant(tmp_path)
    names = [name for name in loops if name != "FEED"]
    execution = libcosimpy.CosimExecution.CosimExecution.from_ssp_file(str(packed(path)[0]), 500_000_000)
    observer = libcosimpy.CosimObserver.CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    reference = {name: open_fmu("CONT_C").variables[name].valueReference for name in ("GAIN", "LMN")}
    expected = recording(command, tmp_path, path, [f"{name}.{variable}" for name in names for variable in reference])
    for row in expected:
        assert execution.step()
        for name in names:
            slave = execution.slave_index_from_instance_name(name)
            values = observer.last_real_values(slave, list(reference.values()))
            assert values == [row[f"{name}.{variable}"] for variable in reference]
            assert values[0] == host.real(loops[name]["GAIN"])


def test_ecos_runs_the_plant_with_the_values_of_the_file(command, packed, tmp_path):
    ecospy = ecos()
    path, loops = plant(tmp_path)
    names = [name for name in loops if name != "FEED"]
    with zipfile.ZipFile(packed(path)[0]) as archive:
        archive.extractall(tmp_path / "unpacked")
    columns = [f"{name}.{variable}" for name in names for variable in ("GAIN", "LMN")]
    with ecospy.EcosSimulation(step_size=0.5, ssp_path=str(tmp_path / "unpacked")) as simulation:
        assert simulation.init(parameter_set="start")
        for row in recording(command, tmp_path, path, columns):
            simulation.step()
            assert {column: simulation.get_real(column.replace(".", "::")) for column in columns} == row
        simulation.terminate()


def test_loops_of_a_parameter_file_are_connected_on_the_command_line(packed, tmp_path):
    path, _ = plant(tmp_path)
    plant_ssp, _ = packed(path, "--connect=TIC101.LMN=FEED.INV")
    (connection,) = structure(plant_ssp).iterfind(".//ssd:Connection", SPACES)
    assert list(connection.values()) == ["TIC101", "LMN", "FEED", "INV"]
    (feed,) = structure(plant_ssp).iterfind(".//ssd:Component[@name='FEED']", SPACES)
    names = [parameter.get("name") for parameter in feed.iterfind(".//ssv:Parameter", SPACES)]
    assert "PER_TM" in names and "INV" not in names, "a connected input has no value of its own"


def test_names_that_tools_confuse_are_changed_and_told(packed, tmp_path):
    values = {"GAIN": 1.0, "TD": 1.0}
    (tmp_path / "plant.json").write_text(json.dumps({"DB4": values, "DB41": values, "1-A ä": values}))
    path, remarks = packed("plant.json")
    names = [component.get("name") for component in structure(path).iterfind(".//ssd:Component", SPACES)]
    assert names == ["DB4_", "DB41", "_1_A__"]
    assert remarks[:2] == ["DB4 is named DB4_ in the SSP file", "1-A ä is named _1_A__ in the SSP file"]


def test_what_an_ssp_file_does_not_hold_is_told(packed, tmp_path):
    description = FURNACE.read_text(encoding="utf-8").replace("parallel", "sequential")
    (tmp_path / "loop.toml").write_text(f"{description}\n[[events]]\ntime = 300.0\nset.CONT_C.SP_INT = 80.0\n")
    path, remarks = packed("loop.toml")
    assert remarks == [
        "an SSP file cannot set values during a run; left out: CONT_C.SP_INT = 80 at 300 s",
        "an SSP file does not specify the order of FMUs: libcosim and Ecos exchange all values at the same time, as plcfmu "
        "run --parallel does",
        "an SSP file has no communication step: set 1 s in the tool that runs it",
    ]
    (setpoint,) = structure(path).iterfind(".//ssv:Parameter[@name='SP_INT']/ssv:Real", SPACES)
    assert setpoint.get("value") == "60.0"


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (["--connect=VALVE.LMNR=CONT_S.SP_INT", "--connect=CONT_S.QLMNUP=VALVE.PRES"], "a mean over the step (available: PV, ER, QLMN_MEAN)"),
        (["--connect=CONT_S.QLMNUP=VALVE.DRIVES"], "did you mean VALVE.DRIVE?"),
        (["--set=CONT_S.GAIN=x"], "is not a finite number"),
    ],
)
def test_what_cannot_be_connected_or_set_is_refused_with_the_remedy(ssp, tmp_path, arguments, sentence):
    done = ssp(host.FOLDER / "CONT_S.fmu", host.FOLDER / "VALVE.fmu", *arguments, "--out=plant.ssp")
    assert done.returncode != 0 and sentence in done.stderr, done.stderr
    assert not (tmp_path / "plant.ssp").exists()


def test_a_file_that_is_no_fmu_is_refused(ssp, tmp_path):
    (tmp_path / "other.fmu").write_text("no archive")
    assert refused(ssp, tmp_path, "other.fmu") == "other.fmu: it is not a ZIP file, or its end is missing"
    assert refused(ssp, tmp_path, "a.fmu").startswith("a.fmu: ")
    assert ssp(host.FOLDER / "HEATER.fmu", "--out=plant.zip").stderr == "error: plant.zip: the name of an SSP file must end in .ssp\n"


