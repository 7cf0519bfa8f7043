"""In Initialization Mode outputs have the values that the restart gives with what is set so far.

A host may read them there to set the inputs of another FMU, as PyFMI does. InitialUnknowns says on which parameters
each depends, and a host need not read again where only others have changed.
"""

import random

import pytest

from host import OK


@pytest.fixture
def initializing(fmu):
    instance = fmu.instance()
    instance.setup()
    instance.do("fmi2EnterInitializationMode")
    return instance


def declared(fmu):
    """The parameters on which each output depends, as InitialUnknowns says."""
    unknowns = fmu.description.initialUnknowns
    return {unknown.variable.name: {setting.name for setting in unknown.dependencies} for unknown in unknowns}


def restart_values(instance):
    """The outputs in Initialization Mode, which must be those after it; None where the settings are refused."""
    state = instance.save()
    read = instance.outputs()
    assert instance.outputs() == read
    status = instance.call("fmi2ExitInitializationMode")
    assert status != OK or instance.outputs() == read
    instance.restore(state)
    instance.free(state)
    return read if status == OK else None


def some_value(generator, variable):
    """A value about the start value, within the range, or a limit of the range."""
    if variable.type == "Boolean":
        return generator.randrange(2)
    limits = [float(limit) for limit in (variable.min, variable.max) if limit is not None]
    if limits and generator.random() < 0.2:
        limit = generator.choice(limits)
        return round(limit) if variable.type == "Integer" else limit
    start = float({"false": 0, "true": 1}.get(variable.start, variable.start))
    wide = abs(start) or 1.0
    low = start - wide if variable.min is None else max(float(variable.min), start - wide)
    high = start + wide if variable.max is None else min(float(variable.max), start + wide)
    value = generator.uniform(low, high)
    return round(value) if variable.type == "Integer" else max(value, 0.001) if variable.unit == "s" else value


def changed_by(instance, name, generator, rounds):
    """The outputs whose restart values a variable changes, whatever the others are."""
    fmu = instance.fmu
    changed = set()
    for _ in range(rounds):
        values = {other: some_value(generator, fmu.variables[other]) for other in fmu.of("input", "parameter")}
        instance.set(**values)
        before = restart_values(instance)
        instance.set(**{name: some_value(generator, fmu.variables[name])})
        after = restart_values(instance)
        if before and after:
            changed |= {output for output in before if before[output] != after[output]}
    return changed


def test_initial_unknowns_name_the_parameters_on_which_the_outputs_depend_and_no_other(fmu, initializing):
    generator = random.Random(fmu.name)
    dependencies = declared(fmu)
    assert set(dependencies) == set(fmu.of("output"))
    for name in fmu.of("parameter"):
        is_named = any(name in settings for settings in dependencies.values())
        changed = changed_by(initializing, name, generator, 60 if is_named else 10)
        assert changed == {output for output, settings in dependencies.items() if name in settings}, name


def test_no_input_changes_an_output_in_initialization_mode(fmu, initializing):
    generator = random.Random(fmu.name)
    for name in fmu.of("input"):
        assert changed_by(initializing, name, generator, 10) == set(), name


def test_reading_in_initialization_mode_changes_nothing(fmu, initializing):
    before = initializing.content()
    initializing.values()
    assert initializing.content() == before


def test_what_is_set_reads_back_in_initialization_mode(fmu, initializing):
    generator = random.Random(fmu.name)
    names = fmu.of("input", "parameter")
    initializing.set(**{name: some_value(generator, fmu.variables[name]) for name in names})
    read = initializing.get(names)
    initializing.do("fmi2ExitInitializationMode")
    assert initializing.get(names) == read


def test_before_initialization_mode_the_outputs_have_their_start_values(open_fmu):
    heater = open_fmu("HEATER").instance()
    heater.set(T_START=80.0)
    assert heater["TEMP"] == 0.0
    heater.setup()
    heater.do("fmi2EnterInitializationMode")
    assert heater["TEMP"] == 80.0


def test_outputs_are_0_where_the_settings_are_refused(open_fmu):
    heater = open_fmu("HEATER").instance()
    heater.setup()
    heater.do("fmi2EnterInitializationMode")
    heater.set(T_START=80.0, CYCLE=0.001, DELAY_MAX=1e9)
    assert (heater["TEMP"], heater["T_PER"]) == (0.0, 0)
    heater.set(DELAY_MAX=60.0)
    assert heater["TEMP"] == 80.0


def closed_loop(open_fmu, reads_first):
    """CONT_C and HEATER as a host connects them; LMN in each step."""
    controller, heater = open_fmu("CONT_C").instance(), open_fmu("HEATER").instance()
    controller.set(MAN_ON=0, SP_INT=20.0, GAIN=1.4, TI=80.0)
    heater.set(CYCLE=1.0)

    def exchange():
        power, temp = controller["LMN"], heater["TEMP"]
        controller.set(PV_IN=temp)
        heater.set(POWER=power)

    for each in (controller, heater):
        each.setup()
    for each in (controller, heater):
        each.do("fmi2EnterInitializationMode")
    if reads_first:
        exchange()
    for each in (controller, heater):
        each.do("fmi2ExitInitializationMode")
    if not reads_first:
        exchange()
    lmn = []
    for k in range(100):
        controller.set(SP_INT=20.0 if k < 30 else 50.0)
        for each in (controller, heater):
            each.step()
        exchange()
        lmn.append(controller["LMN"])
    return lmn


def test_a_host_that_connects_in_initialization_mode_sees_no_kick(open_fmu):
    """PyFMI's order of calls: set up, enter, get outputs, set inputs, exit, step and exchange."""
    lmn = closed_loop(open_fmu, reads_first=True)
    assert lmn[:30] == [0.0] * 30
    assert lmn[30] > 40.0
    assert lmn == closed_loop(open_fmu, reads_first=False)
