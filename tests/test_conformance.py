"""The C interface of every FMU: what is refused, how, and that a refused call changes nothing.

What is allowed when is the state table of FMI 2.0, section 4.2.4. Two rows are more lenient,
because real hosts need it: Get works, and inputs may be set, in state instantiated.
"""

import ctypes
import math
import re
import struct
from ctypes import byref, c_char_p, c_double, c_int, c_uint, c_void_p

import fmpy
import pytest

import host
from calls import STATES, arguments, instance_in, refused
from host import DISCARD, ERROR, OK

EVERY = "I N C T"
ALLOWED = {
    "fmi2SetDebugLogging": EVERY,
    "fmi2SetupExperiment": "I",
    "fmi2EnterInitializationMode": "I",
    "fmi2ExitInitializationMode": "N",
    "fmi2Terminate": "C",
    "fmi2Reset": EVERY,
    "fmi2GetReal": EVERY,
    "fmi2GetInteger": EVERY,
    "fmi2GetBoolean": EVERY,
    "fmi2GetString": EVERY,
    "fmi2SetReal": "I N C",
    "fmi2SetInteger": "I N C",
    "fmi2SetBoolean": "I N C",
    "fmi2SetString": "I N C",
    "fmi2GetFMUstate": EVERY,
    "fmi2SetFMUstate": EVERY,
    "fmi2FreeFMUstate": EVERY,
    "fmi2SerializedFMUstateSize": EVERY,
    "fmi2SerializeFMUstate": EVERY,
    "fmi2DeSerializeFMUstate": EVERY,
    "fmi2GetDirectionalDerivative": "",  # N C in the table, but none are provided
    "fmi2SetRealInputDerivatives": "I N C",
    "fmi2GetRealOutputDerivatives": "C T",
    "fmi2DoStep": "C",
    "fmi2CancelStep": "",  # only while a step is in progress, which it never is
    "fmi2GetStatus": "",  # C T in the table, but there is nothing to tell
    "fmi2GetRealStatus": "C T",
    "fmi2GetIntegerStatus": "",
    "fmi2GetBooleanStatus": "C T",
    "fmi2GetStringStatus": "",
}
INQUIRIES_WITHOUT_AN_ANSWER = ("fmi2GetStatus", "fmi2GetIntegerStatus", "fmi2GetStringStatus")


def test_the_table_names_every_function_on_a_component():
    others = {"fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate", "fmi2FreeInstance"}
    assert set(ALLOWED) | others == set(host.FUNCTIONS)
    assert len(host.FUNCTIONS) == 34


def test_platform_and_version_can_be_asked_without_an_instance(fmu):
    slave = fmu.slave()
    assert slave.getTypesPlatform() == "default"
    assert slave.getVersion() == "2.0"


# --- Which call is allowed when ---------------------------------------------------------------


@pytest.mark.parametrize("function", ALLOWED)
def test_a_call_is_allowed_in_the_states_of_the_table_and_refused_in_all_others(fmu, function):
    for state in STATES:
        instance = instance_in(fmu, state)
        given = arguments(instance, function)
        letter = {"instantiated": "I", "Initialization Mode": "N", "stepComplete": "C", "terminated": "T"}
        if letter[state] in ALLOWED[function]:
            assert instance.call(function, *given) == OK, (state, instance.messages)
            assert instance.messages == []
        elif function in INQUIRIES_WITHOUT_AN_ANSWER and letter[state] in "C T":
            refused(instance, function, *given, status=DISCARD)
        else:
            text = refused(instance, function, *given)
            if ALLOWED[function]:
                assert state in text


def test_the_start_time_must_be_known_before_initialization_mode(fmu):
    instance = fmu.instance()
    refused(instance, "fmi2EnterInitializationMode", saying=["fmi2SetupExperiment"])


@pytest.mark.parametrize(
    "start, stop",
    [(math.nan, None), (math.inf, None), (-math.inf, None), (0.0, math.nan), (1.0, 0.5), (0.0, -math.inf)],
)
def test_an_experiment_needs_a_start_and_a_stop_after_it(fmu, start, stop):
    instance = fmu.instance()
    bad = start if stop is None else stop
    given = (0, 0.0, start, stop is not None, stop or 0.0)
    text = refused(instance, "fmi2SetupExperiment", *given)
    assert re.search("startTime|stopTime", text)
    assert str(bad).lower().strip("-") in text.lower()


def test_an_undefined_stop_time_is_not_looked_at(fmu):
    instance = fmu.instance()
    instance.do("fmi2SetupExperiment", 0, 0.0, 5.0, 0, math.nan)


def test_setting_up_again_replaces_the_start_time(fmu):
    instance = fmu.instance()
    instance.setup(start_time=5.0)
    instance.start(start_time=7.0)
    refused(instance, "fmi2DoStep", 5.0, instance.cycle, 1)
    instance.step()


# --- Pointers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("function", ALLOWED)
def test_a_null_instance_is_refused(fmu, function):
    instance = instance_in(fmu, "stepComplete")
    given = arguments(instance, function)
    assert getattr(instance.slave.dll, function)(None, *given) == ERROR


def test_freeing_null_does_nothing(fmu):
    fmu.slave().fmi2FreeInstance(None)


def is_pointer(argument):
    return (
        isinstance(argument, (ctypes.Array, c_void_p))
        or argument is not None
        and (type(argument) is type(byref(c_int())))
    )


@pytest.mark.parametrize("function", ALLOWED)
def test_a_null_pointer_in_place_of_any_argument_is_refused(fmu, function):
    state = next(
        (state for state in STATES[::-1] if "INCT"[STATES.index(state)] in ALLOWED[function]), STATES[2]
    )
    instance = instance_in(fmu, state)
    given = list(arguments(instance, function))
    if function in ("fmi2GetString", "fmi2SetString", "fmi2GetRealOutputDerivatives"):
        given[1] = 1
    for place, argument in enumerate(given):
        if is_pointer(argument) and 0 not in given[1:2]:
            refused(instance, function, *given[:place], None, *given[place + 1 :])


@pytest.mark.parametrize(
    "function", [name for name in ALLOWED if re.match("fmi2[GS]et(Re|Int|Bo|Str)", name)]
)
def test_null_arrays_without_elements_are_fine(fmu, function):
    if function.endswith("Status"):
        return
    count = sum(isinstance(a, ctypes.Array) for a in arguments(fmu.instance(), function))
    instance = instance_in(fmu, "stepComplete")
    assert instance.call(function, None, 0, *[None] * (count - 1)) == OK


def test_a_state_pointer_that_holds_null_is_freed_without_complaint(fmu):
    instance = instance_in(fmu, "stepComplete")
    assert instance.call("fmi2FreeFMUstate", byref(c_void_p())) == OK
    assert instance.messages == []


# --- Instantiation ---------------------------------------------------------------------------------


class Instantiation:
    """One call of fmi2Instantiate, good unless told otherwise."""

    def __init__(self, fmu, **other):
        self.slave = fmu.slave()
        self.log = host.Log(memory=False)
        self.messages = self.log.messages
        self.callbacks = self.log.callbacks
        given = {
            "name": b"instance",
            "kind": 1,
            "guid": fmu.description.guid.encode(),
            "resources": fmu.resources.encode(),
            "callbacks": byref(self.callbacks),
            "visible": 0,
            "logging_on": 0,
        }
        given.update(other)
        self.component = self.slave.dll.fmi2Instantiate(*given.values())

    def refused(self, *words):
        """No instance, and the reason logged, though logging is off."""
        assert self.component is None
        assert len(self.messages) == 1, self.messages
        _, status, category, text = self.messages[0]
        assert (status, category) == (ERROR, "logStatusError")
        assert text.startswith("fmi2Instantiate: ")
        for word in words:
            assert word in text
        return True


def test_a_wrong_guid_is_refused_with_both_guids(fmu):
    other = "{12345678-1234-1234-1234-123456789abc}"
    assert Instantiation(fmu, guid=other.encode()).refused(other, fmu.description.guid)


@pytest.mark.parametrize("guid", [None, b"", b"{}"])
def test_no_guid_is_refused(fmu, guid):
    # The program library knows no GUID without a program.
    own = "modelDescription.xml" if fmu.is_program else fmu.interface["guid"]
    expected = own if guid is None else fmu.description.guid
    assert Instantiation(fmu, guid=guid).refused(expected)


@pytest.mark.parametrize("kind", [0, 2, -1])
def test_any_type_but_co_simulation_is_refused(fmu, kind):
    assert Instantiation(fmu, kind=kind).refused(str(kind), "co-simulation")


@pytest.mark.parametrize("name", [None, b""])
def test_an_instance_needs_a_name(fmu, name):
    assert Instantiation(fmu, name=name).refused("instanceName")


def test_without_callbacks_there_is_no_instance(fmu):
    assert Instantiation(fmu, callbacks=None).component is None


def test_without_a_logger_there_is_no_instance(fmu):
    callbacks = host.fmi2.fmi2CallbackFunctions()
    assert Instantiation(fmu, callbacks=byref(callbacks)).component is None


@pytest.mark.parametrize("resources", [None, b"", b"http://nowhere/"])
def test_the_resource_location_is_needed_by_presets_and_programs_alone(fmu, resources):
    instantiation = Instantiation(fmu, resources=resources)
    if fmu.is_preset or fmu.is_program:
        file = "program.txt" if fmu.is_program else "start.txt"
        assert instantiation.refused("fmuResourceLocation", f"resources/{file}")
        return
    assert instantiation.component is not None
    instantiation.slave.fmi2FreeInstance(instantiation.component)


def test_callbacks_and_strings_are_copied(fmu):
    """What the host passed to fmi2Instantiate may be gone afterwards."""
    name = ctypes.create_string_buffer(b"first")
    guid = ctypes.create_string_buffer(fmu.description.guid.encode())
    i = Instantiation(fmu, name=name, guid=guid, logging_on=1)
    for gone in (name, guid, i.callbacks):
        ctypes.memset(byref(gone), 0, ctypes.sizeof(gone))
    assert i.slave.dll.fmi2DoStep(i.component, 0.0, 1.0, 1) == ERROR
    assert [message[0] for message in i.messages] == ["first"]
    i.slave.fmi2FreeInstance(i.component)


# --- Logging ---------------------------------------------------------------------------------------


def provoke(instance):
    """One refusal of each of the two kinds that a host can cause."""
    count = len(instance.messages)
    assert instance.call("fmi2CancelStep") == ERROR
    assert instance.call("fmi2GetStatus", host.DO_STEP_STATUS, byref(c_int())) == DISCARD
    return [category for _, _, category, _ in instance.messages[count:]]


def debug_logging(instance, on, *categories):
    array = (c_char_p * len(categories))(*categories)
    return instance.call("fmi2SetDebugLogging", on, len(categories), array)


def test_errors_are_logged_even_if_the_host_instantiates_with_logging_off(fmu):
    """FMPy does so by default: its user would see that a call failed, and not why."""
    instance = fmu.instance(logging_on=False)
    instance.start()
    assert provoke(instance) == ["logStatusError"]
    assert instance.advice == []


def test_logging_on_logs_all_categories(fmu):
    assert provoke(fmu.start()) == ["logStatusError", "logStatusDiscard"]


def test_debug_logging_of_no_category_means_all(fmu):
    instance = fmu.instance(logging_on=False)
    instance.start()
    assert debug_logging(instance, 1) == OK
    assert provoke(instance) == ["logStatusError", "logStatusDiscard"]
    assert debug_logging(instance, 0) == OK
    assert provoke(instance) == [], "off is off, errors included"


def test_debug_logging_of_a_category_logs_this_one_alone(fmu):
    instance = fmu.start()
    assert debug_logging(instance, 1, b"logStatusDiscard") == OK
    assert provoke(instance) == ["logStatusDiscard"]


def test_logging_off_is_off_whatever_category_is_named(fmu):
    """Categories select what is logged; without loggingOn nothing is."""
    instance = fmu.start()
    assert debug_logging(instance, 0, b"logStatusDiscard") == OK
    assert provoke(instance) == []
    assert debug_logging(instance, 1, b"logStatusError") == OK
    assert provoke(instance) == ["logStatusError"]


def advice_of(instance):
    for name, status, category, _ in instance.advice:
        assert (name, status, category) == ("instance", OK, "logAdvice")
    return [text for *_, text in instance.advice]


def test_at_the_end_of_initialization_a_block_says_what_it_will_do_with_its_settings(open_fmu):
    instance = open_fmu("CONT_C").start(MAN=30.0, TI=0.2)
    assert advice_of(instance) == [
        "fmi2ExitInitializationMode: MAN_ON is TRUE: LMN follows MAN = 30 within its limits until MAN_ON is FALSE",
        "fmi2ExitInitializationMode: TI = 0.2 s is below CYCLE / 2: the block uses 0.5 s",
    ]


def test_settings_as_a_user_means_them_get_no_advice(open_fmu):
    assert open_fmu("CONT_C").start(MAN_ON=0, SP_INT=1.0).advice == []
    assert open_fmu("HLG").start(TH_TZ=10, TR_TZ=10).advice == []


def test_advice_is_given_only_while_its_category_is_logged(open_fmu):
    for categories, expected in ([(b"logStatusError",), 0], [(b"logAdvice",), 1], [(), 1]):
        instance = open_fmu("CONT_C").instance()
        assert debug_logging(instance, 1, *categories) == OK
        instance.start()
        assert len(instance.advice) == expected


def test_a_step_far_below_cycle_gets_advice_once(fmu):
    instance = fmu.instance()
    instance.start(**{fmu.cycle_name: 10.0})
    before = len(instance.advice)
    for _ in range(3):
        instance.step(0.01)
    (text,) = advice_of(instance)[before:]
    assert text.startswith("fmi2DoStep: ") and f"{fmu.cycle_name} = 10.0 s" in text and "in ms instead of s?" in text
    assert instance.messages == []


def test_steps_of_0_and_of_a_hundredth_of_cycle_get_no_advice(fmu):
    instance = fmu.instance()
    instance.start(**{fmu.cycle_name: 10.0})
    before = len(instance.advice)
    for h in (0.1, 0.0, 1e-16, 10.0):
        instance.step(h)
    assert len(instance.advice) == before


@pytest.mark.parametrize("categories", [(b"logAll",), (b"logStatusError", b""), (b"logStatusDiscard", None)])
def test_an_unknown_category_is_refused_and_changes_nothing(fmu, categories):
    instance = fmu.start()
    array = (c_char_p * len(categories))(*categories)
    refused(instance, "fmi2SetDebugLogging", 0, len(categories), array)
    refused(instance, "fmi2SetDebugLogging", 1, len(categories), array)
    assert provoke(instance) == ["logStatusError", "logStatusDiscard"]


def test_the_categories_are_those_that_the_model_description_declares(fmu):
    for name in fmu.xml.xpath("LogCategories/Category/@name"):
        instance = fmu.start()
        assert debug_logging(instance, 1, name.encode()) == OK


def test_reset_keeps_the_logging_as_it_was_set(fmu):
    instance = fmu.start()
    debug_logging(instance, 1, b"logStatusDiscard")
    instance.do("fmi2Reset")
    instance.start()
    assert provoke(instance) == ["logStatusDiscard"]


def test_a_number_sign_is_doubled_and_a_percent_sign_is_no_format(fmu):
    """In a message `#` begins a reference to a variable, and the message is passed as an argument
    of "%s", not as the format."""
    instantiation = Instantiation(fmu, guid=b"#%s%n%d")
    assert instantiation.refused("##%s%n%d")


def test_a_message_has_no_line_break(fmu):
    instantiation = Instantiation(fmu, guid=b"one\ntwo")
    assert instantiation.refused()
    assert "\n" not in instantiation.messages[0][3]


# --- Value references and what may be set ---------------------------------------------------


@pytest.mark.parametrize("type", ["Real", "Integer", "Boolean", "String"])
@pytest.mark.parametrize("access", ["Get", "Set"])
def test_an_unknown_value_reference_is_refused(fmu, access, type):
    instance = instance_in(fmu, "stepComplete")
    c_type = host.C_TYPES.get(type, c_char_p)
    for reference in (len(fmu.variables), 0x7FFF_FFFF, 0xFFFF_FFFF):
        refused(
            instance,
            f"fmi2{access}{type}",
            (c_uint * 1)(reference),
            1,
            (c_type * 1)(),
            saying=[str(reference)],
        )


@pytest.mark.parametrize("type", ["Real", "Integer", "Boolean", "String"])
@pytest.mark.parametrize("access", ["Get", "Set"])
def test_a_value_reference_of_another_type_is_refused(fmu, access, type):
    instance = instance_in(fmu, "instantiated")
    c_type = host.C_TYPES.get(type, c_char_p)
    for name, variable in fmu.variables.items():
        # As Reals there are all of them.
        if variable.type != type and type != "Real":
            refused(
                instance,
                f"fmi2{access}{type}",
                host.references(fmu, [name]),
                1,
                (c_type * 1)(),
                saying=[name],
            )


def test_integers_and_booleans_are_reals_for_a_host_that_knows_no_other_type(fmu):
    """Some hosts read and write all variables as Reals."""
    instance = instance_in(fmu, "stepComplete")
    names = list(fmu.variables)
    values = (c_double * len(names))()
    instance.do("fmi2GetReal", host.references(fmu, names), len(names), values)
    assert list(values) == [float(value) for value in instance.get(names).values()]
    others = [name for name in fmu.of("input") if fmu.variables[name].type != "Real"]
    for name in others:
        reference = host.references(fmu, [name])
        instance.do("fmi2SetReal", reference, 1, (c_double * 1)(1.0))
        assert instance[name] == 1
        refused(instance, "fmi2SetReal", reference, 1, (c_double * 1)(0.5), saying=[f"{name} = 0.5: "])
        assert instance[name] == 1
    # It is said once.
    count = [message.text for message in instance.advice if "is accessed as a Real" in message.text]
    assert len(count) == (1 if {fmu.variables[name].type for name in names} - {"Real"} else 0)


@pytest.mark.parametrize("state", STATES[:3])
def test_what_the_block_computes_cannot_be_set(fmu, state):
    instance = instance_in(fmu, state)
    names = fmu.of("output", "local")
    assert names
    for name in names:
        type = fmu.variables[name].type
        value = (host.C_TYPES[type] * 1)(1)
        refused(instance, f"fmi2Set{type}", host.references(fmu, [name]), 1, value, saying=[name])


def test_a_fixed_parameter_cannot_be_set_after_initialization(fmu):
    instance = instance_in(fmu, "stepComplete")
    names = fmu.of("parameter", variability="fixed")
    assert fmu.cycle_name in names
    for name in names:
        type = fmu.variables[name].type
        value = (host.C_TYPES[type] * 1)(1)
        refused(instance, f"fmi2Set{type}", host.references(fmu, [name]), 1, value, saying=[name, "fixed"])


def test_inputs_and_tunable_parameters_can_be_set_from_instantiation_to_termination(fmu):
    for state in STATES[:3]:
        instance = instance_in(fmu, state)
        start = instance.get(fmu.of("input") + fmu.of("parameter", variability="tunable"))
        instance.set(**start)


# --- Values ----------------------------------------------------------------------------------------


def binary32(value):
    return struct.unpack("f", struct.pack("f", value))[0]


LARGEST_REAL = 3.4028234663852886e38
HALF_A_BIT_ABOVE = 3.4028235677973366e38  # from here on a double rounds to no finite binary32
TAKEN = {
    # kind: value set, value read
    "REAL": [
        (0.1, binary32(0.1)),
        (-0.0, -0.0),
        (LARGEST_REAL, LARGEST_REAL),
        (-LARGEST_REAL, -LARGEST_REAL),
        (math.nextafter(HALF_A_BIT_ABOVE, 0) if hasattr(math, "nextafter") else LARGEST_REAL, LARGEST_REAL),
        (16777217.0, 16777216.0),
        (1e-45, binary32(1e-45)),
        (1e-46, 0.0),
    ],
    "LREAL": [(0.1, 0.1), (-0.0, -0.0), (1e300, 1e300), (5e-324, 5e-324)],
    "TIME": [
        (0.0, 0.0),
        (0.0004, 0.0),
        (0.0006, 0.001),
        (1.2344, 1.234),
        (1.2346, 1.235),
        (0.029, 0.029),
        (2147483.647, 2147483.647),
    ],
    "WORD": [(-32768, -32768), (32767, 32767), (32768, -32768), (65535, -1), (-1, -1)],
    "INT": [(-32768, -32768), (32767, 32767)],
    "BOOL": [(0, 0), (1, 1), (2, 1), (-1, 1), (256, 1)],
}
REFUSED = {
    "REAL": [math.nan, math.inf, -math.inf, 1e39, -1e39, HALF_A_BIT_ABOVE, 1.7e308],
    "LREAL": [math.nan, math.inf, -math.inf],
    "TIME": [math.nan, math.inf, -math.inf, -0.001, -1.0, 2147483.648, 1e30],
    "WORD": [-32769, 65536, 2**31 - 1, -(2**31)],
    "INT": [-32769, 32768, 65535, 2**31 - 1, -(2**31)],
    "BOOL": [],
}


def test_every_value_that_a_type_holds_reads_back(fmu):
    instance = instance_in(fmu, "instantiated")
    for name in fmu.of("input", "parameter"):
        for value, read in TAKEN[fmu.kinds[name]]:
            instance.set(**{name: value})
            assert host.exact({name: instance[name]}) == host.exact({name: read}), value


def test_a_value_that_a_type_does_not_hold_is_refused(fmu):
    instance = instance_in(fmu, "instantiated")
    for name in fmu.of("input", "parameter"):
        type = fmu.variables[name].type
        for value in REFUSED[fmu.kinds[name]]:
            given = (host.C_TYPES[type] * 1)(value)
            text = refused(instance, f"fmi2Set{type}", host.references(fmu, [name]), 1, given, saying=[name])
            number = re.search(re.escape(name) + r" = (\S+):", text)[1]
            assert float(number) == value or math.isnan(value)


@pytest.mark.parametrize("type", host.C_TYPES)
def test_one_bad_element_refuses_the_whole_array(fmu, type):
    names = fmu.of("input", "parameter", type=type)
    output = fmu.of("output")[0]
    instance = instance_in(fmu, "instantiated")
    for name in names:
        now = instance[name]
        other = 1 - now if type == "Boolean" else now + 1
        bad = host.references(fmu, [name, output])
        refused(instance, f"fmi2Set{type}", bad, 2, (host.C_TYPES[type] * 2)(other, other))
        for value in REFUSED[fmu.kinds[name]]:
            twice = host.references(fmu, [name, name])
            refused(instance, f"fmi2Set{type}", twice, 2, (host.C_TYPES[type] * 2)(other, value))


@pytest.mark.parametrize("type", host.C_TYPES)
def test_one_bad_reference_leaves_the_whole_result_untouched(fmu, type):
    names = [name for name, variable in fmu.variables.items() if variable.type == type]
    instance = instance_in(fmu, "instantiated")
    given = (c_uint * 2)(fmu.variables[names[0]].valueReference if names else 0, len(fmu.variables))
    result = (host.C_TYPES[type] * 2)(77, 78)
    refused(instance, f"fmi2Get{type}", given, 2, result)
    assert list(result) == [77, 78]


def test_the_last_of_several_values_for_one_variable_counts(fmu):
    name = fmu.of("input", "parameter")[0]
    instance = instance_in(fmu, "instantiated")
    type = fmu.variables[name].type
    instance.do(f"fmi2Set{type}", host.references(fmu, [name, name]), 2, (host.C_TYPES[type] * 2)(0, 1))
    assert instance[name] == 1


def test_start_values_are_those_of_the_model_description(fmu):
    read = fmu.instance().get(fmu.variables)
    for name, variable in fmu.variables.items():
        if variable.start is None:
            assert variable.causality == "local" or read[name] == 0, name
        elif variable.type == "Boolean":
            assert read[name] == {"false": 0, "true": 1}[variable.start], name
        else:
            assert read[name] == float(variable.start), name


@pytest.mark.parametrize("cycle", [0.0, 0.0004])
def test_a_cycle_below_a_millisecond_is_refused_at_the_end_of_initialization(fmu, cycle):
    instance = fmu.instance()
    instance.setup()
    instance.set(**{fmu.cycle_name: cycle})
    instance.do("fmi2EnterInitializationMode")
    refused(instance, "fmi2ExitInitializationMode", saying=[fmu.cycle_name, "0.001"])
    instance.set(**{fmu.cycle_name: 0.001})
    instance.do("fmi2ExitInitializationMode")
    instance.step()


# --- Derivatives and status -----------------------------------------------------------------------


def derivatives_refused(instance, name, order=1, value=1.0, **expected):
    given = host.references(instance.fmu, [name]), 1, (c_int * 1)(order), (c_double * 1)(value)
    return refused(instance, "fmi2SetRealInputDerivatives", *given, **expected)


def test_only_real_inputs_have_derivatives(fmu):
    instance = fmu.start()
    for name, variable in fmu.variables.items():
        if variable.causality != "input" or variable.type != "Real":
            derivatives_refused(instance, name, saying=[name])


def test_a_derivative_needs_an_order_of_at_least_1_and_a_finite_value(fmu):
    instance = fmu.start()
    for name in fmu.of("input", type="Real"):
        for order in (0, -1, 5, 2**31 - 1):
            derivatives_refused(instance, name, order=order, saying=[name, str(order)])
        for value in (math.nan, math.inf, -math.inf):
            derivatives_refused(instance, name, value=value, saying=[name])


def test_outputs_have_no_derivatives(fmu):
    instance = fmu.start()
    for name in fmu.of("output"):
        given = host.references(fmu, [name]), 1, (c_int * 1)(1), (c_double * 1)()
        refused(instance, "fmi2GetRealOutputDerivatives", *given)


def test_directional_derivatives_are_refused_as_the_model_description_says(fmu):
    instance = fmu.start()
    refused(instance, "fmi2GetDirectionalDerivative", *arguments(instance, "fmi2GetDirectionalDerivative"))


def test_the_last_successful_time_is_the_end_of_the_last_step(fmu):
    instance = fmu.start(start_time=3.0)
    time = c_double()
    instance.do("fmi2GetRealStatus", host.LAST_SUCCESSFUL_TIME, byref(time))
    assert time.value == 3.0
    instance.step()
    instance.call("fmi2DoStep", 1.0, 1.0, 1)  # refused: behind
    instance.do("fmi2GetRealStatus", host.LAST_SUCCESSFUL_TIME, byref(time))
    assert time.value == instance.time


def test_a_block_never_ends_the_simulation(fmu):
    instance = fmu.start()
    instance.step()
    terminated = c_int(7)
    instance.do("fmi2GetBooleanStatus", host.TERMINATED, byref(terminated))
    assert terminated.value == 0


@pytest.mark.parametrize(
    "function, answered, value",
    [
        ("fmi2GetStatus", None, c_int),
        ("fmi2GetRealStatus", host.LAST_SUCCESSFUL_TIME, c_double),
        ("fmi2GetIntegerStatus", None, c_int),
        ("fmi2GetBooleanStatus", host.TERMINATED, c_int),
        ("fmi2GetStringStatus", None, c_char_p),
    ],
)
def test_every_other_kind_of_status_is_discarded(fmu, function, answered, value):
    instance = fmu.start()
    for kind in (0, 1, 2, 3, 4, -1, 2**31 - 1):
        if kind != answered:
            refused(instance, function, kind, byref(value()), status=DISCARD, saying=[str(kind)])


# --- FMPy's own simulation --------------------------------------------------------------------------


@host.in_fmpy
def test_simulate_fmu_runs_with_its_own_defaults(fmu):
    """Validation, default step size and stop time; no status but fmi2OK, and every value a number."""
    calls = []
    result = fmpy.simulate_fmu(str(fmu.path), debug_logging=True, fmi_call_logger=calls.append)
    assert len(result) > 1
    assert not any(re.search("-> (WARNING|DISCARD|ERROR|FATAL|PENDING)", call) for call in calls)
    for name in result.dtype.names:
        assert all(math.isfinite(value) for value in result[name])
