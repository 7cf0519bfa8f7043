"""modelDescription.xml of every FMU: FMPy's checks, and what no validator looks at."""

import math
import os
import re
import struct

import pytest
from fmpy.validation import validate_fmu

import host

FMI_TYPE = {
    "REAL": "Real",
    "LREAL": "Real",
    "TIME": "Real",
    "WORD": "Integer",
    "INT": "Integer",
    "BOOL": "Boolean",
}


def typed(xml):
    """The element with a variable's type, its only one."""
    (element,) = xml
    return element


def scalar_variables(fmu):
    return fmu.xml.findall("ModelVariables/ScalarVariable")


def number(element, attribute):
    """A number of the XML as the FMI type holds it."""
    text = element.get(attribute)
    if text is None:
        return None
    return {"true": 1, "false": 0}[text] if element.tag == "Boolean" else float(text)


# --- The whole --------------------------------------------------------------------------------------


def test_fmpy_finds_nothing_wrong(fmu):
    """The schema, legal and unique names, structure, start values, units."""
    assert validate_fmu(str(fmu.path)) == []


def test_the_root_has_no_namespace_and_only_attributes_of_the_standard(fmu):
    """fmi-sim refuses others."""
    assert fmu.xml.nsmap == {}
    assert b"xmlns" not in (fmu.folder / "modelDescription.xml").read_bytes()
    assert set(fmu.xml.attrib) <= {
        "fmiVersion",
        "modelName",
        "guid",
        "description",
        "author",
        "version",
        "copyright",
        "license",
        "generationTool",
        "generationDateAndTime",
        "variableNamingConvention",
        "numberOfEventIndicators",
    }


def test_it_is_fmi_2_0_with_structured_names(fmu):
    assert fmu.xml.get("fmiVersion") == "2.0"
    assert fmu.xml.get("variableNamingConvention") == "structured"
    assert fmu.xml.get("modelName") == fmu.name
    assert fmu.xml.find("ModelExchange") is None


def test_there_is_no_date_but_that_of_the_sources(fmu):
    """The same sources give the same bytes."""
    date = fmu.xml.get("generationDateAndTime")
    assert date is None or "SOURCE_DATE_EPOCH" in os.environ


def test_the_block_is_described(fmu):
    assert len(fmu.xml.get("description")) > 20
    assert fmu.xml.get("generationTool")


def test_no_list_is_empty(fmu):
    """The schema forbids it for some, and readers stumble over the others."""
    leaves = {"Category", "DefaultExperiment", "CoSimulation", "Unknown", "BaseUnit", "DisplayUnit"}
    leaves |= {"Real", "Integer", "Boolean", "File"}
    assert {element.tag for element in fmu.xml.iter() if len(element) == 0} <= leaves | {"Unit"}


def test_nothing_stands_twice_in_an_element_of_the_schema(fmu):
    tags = [child.tag for child in fmu.xml]
    assert len(tags) == len(set(tags))


# --- Co-simulation ---------------------------------------------------------------------------------


def test_the_model_identifier_is_the_name_of_every_library(fmu):
    identifier = fmu.xml.find("CoSimulation").get("modelIdentifier")
    libraries = [path for path in (fmu.folder / "binaries").glob("*/*") if path.is_file()]
    assert libraries
    assert {path.stem for path in libraries} == {identifier}
    assert re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", identifier)


def test_the_capabilities_are_those_that_the_tests_prove(fmu):
    """test_time: variable steps, input derivatives. test_fmu_state: states, several instances.
    test_conformance: memory functions are NULL, no derivatives."""
    flags = dict(fmu.xml.find("CoSimulation").attrib)
    del flags["modelIdentifier"]
    yes = {
        "canHandleVariableCommunicationStepSize",
        "canInterpolateInputs",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
        "canNotUseMemoryManagementFunctions",
    }
    assert {name for name, value in flags.items() if value == "true"} == yes
    assert all(flags[name] in ("false", "0") for name in set(flags) - yes)


def test_the_source_files_are_those_of_the_archive(fmu):
    """Of a block one file of C, of a plant and a preset none."""
    declared = [file.get("name") for file in fmu.xml.findall("CoSimulation/SourceFiles/File")]
    assert declared == [path.name for path in (fmu.folder / "sources").glob("*")]
    assert declared in ([], [f"{fmu.description.coSimulation.modelIdentifier}.c"])


def test_the_step_size_is_the_default_cycle(fmu):
    experiment = fmu.xml.find("DefaultExperiment")
    assert float(experiment.get("stepSize")) == fmu.cycle > 0
    assert float(experiment.get("startTime", "0")) == 0
    assert float(experiment.get("stopTime")) >= float(experiment.get("stepSize"))


def test_the_log_categories_are_declared_with_a_description(fmu):
    categories = fmu.xml.findall("LogCategories/Category")
    assert [c.get("name") for c in categories] == ["logStatusError", "logStatusDiscard", "logStatusFatal", "logAdvice"]
    assert all(c.get("description") for c in categories)


def test_the_guid_is_the_librarys_and_no_other_fmus(fmu, open_fmu):
    guid = fmu.xml.get("guid")
    assert re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", guid)
    assert guid == fmu.interface["guid"]
    assert [name for name in host.names() if open_fmu(name).xml.get("guid") == guid] == [fmu.name]


# --- Variables -----------------------------------------------------------------------------------------


def test_every_variable_of_the_library_stands_there_in_its_order(fmu):
    rows = fmu.table["variables"]
    xml = scalar_variables(fmu)
    assert [x.get("name") for x in xml] == [row["name"] for row in rows]
    assert [int(x.get("valueReference")) for x in xml] == list(range(len(rows)))
    assert [typed(x).tag for x in xml] == [FMI_TYPE[row["kind"]] for row in rows]
    assert [x.get("description") for x in xml] == [row["description"] for row in rows]


CAUSALITY = {
    # role in the library: causality, variability, initial
    "input": ("input", "discrete", None),
    "parameter": ("parameter", "tunable", "exact"),
    "fixed": ("parameter", "fixed", "exact"),
    "cycle": ("parameter", "fixed", "exact"),
    "output": ("output", "discrete", "calculated"),
    "local": ("local", "discrete", "calculated"),
}


def test_causality_and_variability_are_explicit_and_match_what_the_library_allows(fmu):
    for row, x in zip(fmu.table["variables"], scalar_variables(fmu)):
        causality, variability, initial = CAUSALITY[row["role"]]
        assert x.get("causality") == causality
        assert x.get("variability") == variability
        # exact is the default of a parameter; for an input initial is forbidden
        assert x.get("initial") in ((initial, None) if initial == "exact" else (initial,))


def test_inputs_and_parameters_have_a_start_and_nothing_else_has_one(fmu):
    for x in scalar_variables(fmu):
        has_start = typed(x).get("start") is not None
        assert has_start == (x.get("causality") in ("input", "parameter")), x.get("name")


def test_there_is_no_independent_variable(fmu):
    """libcosim logs errors about it."""
    assert fmu.of("independent") == []


def test_numbers_read_back_bit_for_bit(fmu):
    """As the type that the library keeps them in."""
    for row, x in zip(fmu.table["variables"], scalar_variables(fmu)):
        bits = "f" if row["kind"] == "REAL" else "d"
        for attribute in ("start", "min", "max"):
            in_xml = number(typed(x), attribute)
            if in_xml is not None:
                assert struct.pack(bits, in_xml) == struct.pack(bits, row[attribute]), row["name"]
            elif attribute != "start" and typed(x).tag != "Boolean":
                assert row[attribute] is None


def test_every_start_lies_within_min_and_max(fmu):
    for x in scalar_variables(fmu):
        low, high, start = (number(typed(x), attribute) for attribute in ("min", "max", "start"))
        for value in (low, high, start):
            assert value is None or math.isfinite(value)
        values = [value for value in (low, start, high) if value is not None]
        assert values == sorted(values), x.get("name")


def test_every_min_and_max_can_be_set(fmu):
    instance = fmu.instance()
    for name in fmu.of("input", "parameter"):
        variable = fmu.variables[name]
        for limit in (variable.min, variable.max):
            if limit is not None:
                instance.set(**{name: type(instance[name])(limit)})
                held = host.real(float(limit)) if fmu.kinds[name] == "REAL" else float(limit)
                assert instance[name] == held


def test_every_variable_is_described_in_a_sentence_of_its_own(fmu):
    descriptions = [x.get("description") for x in scalar_variables(fmu)]
    assert all(len(text) > 3 and text == text.strip() for text in descriptions)


# --- Units ---------------------------------------------------------------------------------------------


def test_every_unit_is_defined_and_every_definition_is_used(fmu):
    defined = fmu.xml.xpath("UnitDefinitions/Unit/@name")
    assert len(defined) == len(set(defined))
    used = fmu.xml.xpath("ModelVariables/ScalarVariable/Real/@unit")
    assert set(used) == set(defined)
    for real in fmu.xml.xpath("ModelVariables/ScalarVariable/Real[@displayUnit]"):
        unit = fmu.xml.xpath("UnitDefinitions/Unit[@name=$name]", name=real.get("unit"))[0]
        assert real.get("displayUnit") in unit.xpath("DisplayUnit/@name")


def test_the_units_are_those_of_the_library(fmu):
    for row, x in zip(fmu.table["variables"], scalar_variables(fmu)):
        assert typed(x).get("unit") == ("s" if row["kind"] == "TIME" else row["unit"]), row["name"]


def test_times_are_in_seconds_and_shown_in_milliseconds(fmu):
    for row, x in zip(fmu.table["variables"], scalar_variables(fmu)):
        if row["kind"] == "TIME":
            assert (typed(x).get("unit"), typed(x).get("displayUnit")) == ("s", "ms")
    second = fmu.xml.find("UnitDefinitions/Unit[@name='s']")
    assert dict(second.find("BaseUnit").attrib) == {"s": "1"}
    milliseconds = second.find("DisplayUnit[@name='ms']")
    assert float(milliseconds.get("factor")) == 1000
    assert float(milliseconds.get("offset", "0")) == 0


def test_a_percent_is_a_hundredth(fmu):
    for unit in fmu.xml.xpath("UnitDefinitions/Unit[@name='%']"):
        assert float(unit.find("BaseUnit").get("factor")) == 0.01
        assert set(unit.find("BaseUnit").attrib) == {"factor"}


# --- Structure ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ["Outputs", "InitialUnknowns"])
def test_every_output_is_listed_once_in_order_and_depends_on_no_signal(fmu, element):
    """Without the attribute an output would depend on every input, and masters would see
    algebraic loops. It changes in fmi2DoStep alone, and has its restart value before."""
    unknowns = fmu.xml.findall(f"ModelStructure/{element}/Unknown")
    outputs = [i for i, x in enumerate(scalar_variables(fmu), 1) if x.get("causality") == "output"]
    assert [int(unknown.get("index")) for unknown in unknowns] == outputs
    settings = [i for i, x in enumerate(scalar_variables(fmu), 1) if x.get("causality") == "parameter"]
    for unknown in unknowns:
        if element == "InitialUnknowns" and unknown.get("dependencies"):
            # On settings alone: test_restart_values.py shows that these are the right ones.
            dependencies = [int(index) for index in unknown.get("dependencies").split(" ")]
            assert dependencies == sorted(set(dependencies) & set(settings))
        else:
            assert unknown.get("dependencies") == ""
        assert unknown.get("dependenciesKind") in (None, "")


def test_there_are_no_continuous_states(fmu):
    assert fmu.xml.find("ModelStructure/Derivatives") is None


# --- The manuals' blocks ------------------------------------------------------------------------------


def test_a_signal_in_percent_says_so(controller):
    """The manual leaves it to the user whether the controllers' REALs are percent or physical values, so they have no unit."""
    for name, variable in controller.variables.items():
        if name.split(".")[-1] in ("INV", "Q_MEAN", "QLMN_MEAN"):
            assert "percent" in variable.description


def test_a_range_that_names_another_terminal_stands_in_the_description(controller):
    relations = {
        "CONT_C": {
            "TI": "CYCLE",
            "TD": "CYCLE",
            "TM_LAG": "CYCLE",
            "LMN_HLM": "LMN_LLM",
            "LMN_LLM": "LMN_HLM",
        },
        "CONT_S": {"TI": "CYCLE", "PULSE_TM": "CYCLE", "BREAK_TM": "CYCLE", "MTR_TM": "CYCLE"},
        "PULSEGEN": {"PER_TM": "CYCLE", "P_B_TM": "CYCLE"},
    }
    for name, other in relations.get(controller.name, {}).items():
        assert other in controller.variables[name].description
