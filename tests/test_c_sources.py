"""The C in an FMU: it compiles without warnings in every dialect, keeps the promises of the library that plcfmu packs (the same
suites run over it), has its bits and its saved states, and refuses to be compiled with options that change results.

Of programs a few are enough: they have a variable of every type, and the door is the same in every FMU. Of blocks there are all."""

import ctypes
import functools
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import zipfile

import fmpy
import fmpy.build
import fmpy.fmi1
import fmpy.fmi2
import fmpy.fmi3
import fmpy.validation
import pytest
from lxml import etree

import c_builds
import host
import newer

ROOT = pathlib.Path(__file__).parents[1]
# The programs with the periods of their calls.
PROGRAMS = {
    ROOT / "tests/programs/mixer.scl": "100ms",
    ROOT / "tests/programs/kinds.scl": "100ms",
    ROOT / "examples/programs/conveyor.scl": "50ms",
    # It has an instance of CONT_C.
    ROOT / "examples/programs/tank.scl": "100ms",
}
RUN = pathlib.Path(__file__).parent / "c" / "run.c"
HEADERS = c_builds.HEADERS
# The standard's own header pastes prefixes, which FMPy's does not.
PREFIXING = ROOT / "fmu/src/v2/c"
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"]
SUITES = ["test_conformance.py", "test_fmu_state.py", "test_time.py", "test_restart_values.py"]
# What is there of blocks only: their recordings, their clauses, and random runs against the second version of their laws.
SUITES_OF_BLOCKS = [*SUITES, "test_traces.py", "test_tapes.py", "test_random.py"]
BLOCKS = [name for name in host.names() if c_builds.sources(host.FOLDER / f"{name}.fmu")]

pytestmark = host.in_fmpy


def run(*words, **options):
    done = subprocess.run([*map(str, words)], capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def programs(command, tmp_path_factory):
    """Packs the programs; a native one has the C as its library. In FMI 3.0 they have `types`."""

    @functools.cache
    def programs(native, types=None):
        folder = tmp_path_factory.mktemp("native" if native else "packed")
        more = [*(["--native"] if native else []), *(["--fmi=3", f"--types={types}"] if types else [])]
        for source, cycle in PROGRAMS.items():
            run(command, "build", source, f"--cycle={cycle}", f"--out={folder}", *more, env=host.environment())
        return folder

    return programs


@pytest.fixture(scope="module")
def blocks(tmp_path_factory):
    """A folder of the blocks' FMUs that have their C as their library."""
    folder = tmp_path_factory.mktemp("blocks")
    c_builds.all_compiled(host.FOLDER, folder)
    return folder


@pytest.fixture(scope="module")
def newer_blocks(packed, tmp_path_factory):
    """The same of FMI 3.0, with the types of the PLC."""
    folder = tmp_path_factory.mktemp("newer_blocks")
    c_builds.all_compiled(packed(), folder)
    return folder


@pytest.fixture(scope="module")
def native(programs, tmp_path_factory):
    return host.Fmu(programs(True) / "Mixer.fmu", tmp_path_factory.mktemp("unpacked"))


class InRust(host.Fmu):
    """An FMU with the library of all programs, which does not say what it is; that in C does."""

    def __init__(self, native, path, folder):
        self.native = native
        super().__init__(path, folder)

    def told(self):
        return {"table": self.native.table, "interface": self.native.interface}


@pytest.fixture(scope="module")
def both(programs, blocks, packed, newer_blocks, tmp_path_factory):
    """An FMU by its name, in Rust and in C."""

    @functools.cache
    def both(name):
        own, is_newer = name.removeprefix(host.NEWER), name.startswith(host.NEWER)
        if own in BLOCKS:
            of = [(packed(), "rust"), (newer_blocks, "c")] if is_newer else [(host.FOLDER, "rust"), (blocks, "c")]
            return tuple(host.Fmu(folder / f"{own}.fmu", tmp_path_factory.mktemp(door)) for folder, door in of)
        # Types of all widths, and no arrays, which FMI 2.0 does not have.
        types = "wide" if is_newer else None
        native = host.Fmu(programs(True, types) / f"{own}.fmu", tmp_path_factory.mktemp("c"))
        return InRust(native, programs(False, types) / f"{own}.fmu", tmp_path_factory.mktemp("rust")), native

    return both


@pytest.fixture(scope="module")
def source(native):
    return native.folder / "sources" / "Mixer.c"


@pytest.fixture(scope="module")
def newer_source(programs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("newer")
    fmpy.extract(str(programs(False, "wide") / "Mixer.fmu"), folder)
    return folder / "sources" / "Mixer.c"


def compiler(words):
    """The command of a compiler; the test is skipped if it is not there."""
    program, *rest = words.split()
    if program == "zig":
        # Of the Python environment.
        pytest.importorskip("ziglang", reason="zig is missing: pip install ziglang")
        return [sys.executable, "-m", "ziglang", *rest]
    if not shutil.which(program):
        pytest.skip(f"{program} is missing: install it (Debian, Ubuntu: apt install gcc g++ clang gcc-mingw-w64)")
    return [program, *rest]


# --- The file in the package ---------------------------------------------------------------------------------------


def test_an_fmu_has_its_sources_without_headers_of_fmi(programs):
    for folder in (programs(False), programs(True)):
        with zipfile.ZipFile(folder / "Mixer.fmu") as fmu:
            assert [name for name in fmu.namelist() if name.startswith("sources/")] == ["sources/Mixer.c"]
            assert b'<SourceFiles>\n      <File name="Mixer.c"/>' in fmu.read("modelDescription.xml")
        assert fmpy.validation.validate_fmu(str(folder / "Mixer.fmu")) == []


BUILD = """<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{name}">
    <SourceFileSet language="C99">
      <SourceFile name="{name}.c"/>
      <PreprocessorDefinition name="FMI3_OVERRIDE_FUNCTION_PREFIX" optional="true" value="" description="No prefix, for a shared library"/>
    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""


@pytest.mark.parametrize("name", ["Mixer", *BLOCKS])
def test_an_fmu_of_fmi_3_has_its_c_and_a_description_of_how_it_is_built(name, programs, packed):
    path = (packed() if name in BLOCKS else programs(False, "wide")) / f"{name}.fmu"
    with zipfile.ZipFile(path) as fmu:
        found = [file for file in fmu.namelist() if file.startswith("sources/")]
        assert found == [f"sources/{name}.c", "sources/buildDescription.xml"]
        text, build = fmu.read(f"sources/{name}.c").decode("ascii"), fmu.read("sources/buildDescription.xml").decode()
        assert f"<code>sources/{name}.c</code>" in fmu.read("documentation/index.html").decode()
    assert build == BUILD.format(name=name)
    schema = etree.XMLSchema(etree.parse(pathlib.Path(fmpy.__file__).parent / "schema/fmi3/fmi3BuildDescription.xsd"))
    schema.assertValid(etree.fromstring(build.encode()))
    assert sorted(re.findall(r"#include (.*)", text)) == ['"fmi3Functions.h"', "<stddef.h>", "<stdlib.h>", "<string.h>"]
    assert "fmi2" not in text and f"#define FMI3_FUNCTION_PREFIX {name}_\n" in text
    assert fmpy.validation.validate_fmu(str(path)) == []


@pytest.mark.parametrize(
    "options, prefix",
    [
        ([], "Mixer_"),
        (["-DDISABLE_PREFIX"], ""),
        (["-DFMI3_FUNCTION_PREFIX=A_"], "A_"),
        (["-DFMI3_OVERRIDE_FUNCTION_PREFIX"], ""),
        (["-DFMI3_OVERRIDE_FUNCTION_PREFIX", "-DFMI3_ACTUAL_FUNCTION_PREFIX=B_"], "B_"),
    ],
    ids=["its own", "none", "another", "overridden by none", "overridden by another"],
)
@pytest.mark.parametrize("headers", [HEADERS, ROOT / "fmu/src/v3/c"], ids=["of the standard", "of plcfmu"])
def test_the_names_of_the_functions_of_fmi_3_have_the_prefix_that_is_asked_for(headers, options, prefix, newer_source, tmp_path):
    run("gcc", "-std=c99", *options, "-I", headers, "-c", newer_source, "-o", tmp_path / "out.o")
    symbols = {line.split()[-1] for line in run("nm", "--defined-only", "--extern-only", tmp_path / "out.o").splitlines()}
    assert symbols == {prefix + name for name in host.FMI3}


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block_has_its_c_under_its_name_with_the_headers_that_any_compiler_has(name):
    with zipfile.ZipFile(host.FOLDER / f"{name}.fmu") as fmu:
        assert c_builds.sources(host.FOLDER / f"{name}.fmu") == [f"sources/{name}.c"]
        text = fmu.read(f"sources/{name}.c").decode("ascii")
        assert f'<SourceFiles>\n      <File name="{name}.c"/>' in fmu.read("modelDescription.xml").decode()
        assert f"<code>sources/{name}.c</code>" in fmu.read("documentation/index.html").decode()
    included = re.findall(r"#include (.*)", text)
    assert sorted(included) == ['"fmi2Functions.h"', "<stddef.h>", "<stdlib.h>", "<string.h>"]
    assert f"#define FMI2_FUNCTION_PREFIX {name}_\n" in text
    assert fmpy.validation.validate_fmu(str(host.FOLDER / f"{name}.fmu")) == []


def test_all_blocks_of_manuals_and_a_block_of_ones_own_have_c():
    assert {"CONT_C", "CONT_S", "HLG", "PULSEGEN", "PULS_CTR", "TWO_POINT"} <= set(BLOCKS)


def test_a_preset_has_no_c(make_preset, open_fmu, tmp_path):
    preset = make_preset(open_fmu("CONT_C"), tmp_path / "SLOW.fmu", TI=60.0)
    assert c_builds.sources(preset) == []
    with zipfile.ZipFile(preset) as fmu:
        assert b"SourceFiles" not in fmu.read("modelDescription.xml")
        assert "This preset has no C" in fmu.read("documentation/index.html").decode()
    assert fmpy.validation.validate_fmu(str(preset)) == []


def test_a_source_file_that_is_missing_is_found_by_check(programs, command, tmp_path):
    with zipfile.ZipFile(programs(False) / "Mixer.fmu") as original, zipfile.ZipFile(tmp_path / "Mixer.fmu", "w") as changed:
        for name in original.namelist():
            if not name.startswith("sources/"):
                changed.writestr(name, original.read(name))
    done = subprocess.run([command, "check", tmp_path / "Mixer.fmu"], capture_output=True, text=True)
    assert done.returncode != 0 and 'SourceFiles names "Mixer.c", but "sources/Mixer.c" is missing' in done.stdout + done.stderr


@pytest.mark.parametrize(
    "words",
    [
        "gcc -std=c99",
        "gcc -std=gnu17",
        "g++ -x c++ -std=c++98 -Wno-long-long",
        "g++ -x c++ -std=c++17",
        "clang -std=c99",
        "clang -x c++ -std=c++14",
        "x86_64-w64-mingw32-gcc -std=c99",
        "zig cc -target aarch64-linux-musl",
    ],
)
def test_the_file_compiles_without_a_warning(words, source, newer_source, tmp_path):
    for file in (source, newer_source):
        run(*compiler(words), *WARNINGS, "-O2", "-isystem", HEADERS, "-c", file, "-o", tmp_path / "out.o")


@pytest.mark.parametrize(
    "words, why",
    [
        ("gcc -ffast-math", "compile without -ffast-math"),
        ("clang -ffast-math", "compile without -ffast-math"),
        ("gcc -mfpmath=387", "x87 changes the results"),
        ("gcc -fassociative-math -fno-signed-zeros -fno-trapping-math", "compile without -fassociative-math"),
        ("gcc -freciprocal-math", "compile without -freciprocal-math"),
        ("gcc -fno-signed-zeros", "compile without -fno-signed-zeros"),
        ("gcc -ffinite-math-only", "compile without -ffinite-math-only"),
        ("gcc -funsafe-math-optimizations", "compile without -fassociative-math"),
    ],
)
def test_options_that_change_results_do_not_compile(words, why, source, tmp_path):
    words = [*compiler(words), "-std=gnu99", "-O2", "-I", HEADERS, "-c", source, "-o", tmp_path / "out.o"]
    done = subprocess.run([*map(str, words)], capture_output=True, text=True)
    assert done.returncode != 0 and why in done.stderr


# --- The same suites ------------------------------------------------------------------------------------------------


def passes(suite, which, **variables):
    """Runs a suite over other FMUs. Which versions it is run over it says itself."""
    tests = [sys.executable, "-m", "pytest", suite, "-q", "-p", "no:cacheprovider", "-k", which]
    done = subprocess.run(tests, cwd=ROOT / "tests", env={**host.environment(), **variables}, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-5000:]
    assert re.search(r"[1-9]\d* passed", done.stdout) and "failed" not in done.stdout, done.stdout[-500:]


@pytest.mark.parametrize("suite", SUITES)
def test_the_suites_of_the_c_interface_pass_over_the_c(suite, programs):
    passes(suite, "Mixer and not preset", PLCFMU_FMUS=str(programs(True)), PLCFMU_FMI3=str(programs(True, "wide")))


@pytest.mark.parametrize("suite", SUITES_OF_BLOCKS)
def test_the_suites_pass_over_the_c_of_the_blocks(suite, blocks, newer_blocks):
    # Presets have no C, and advice on settings is not told; its tests name no FMU.
    others = [name for name in host.names() if name not in BLOCKS]
    left_out = " and ".join(f"not {text}" for text in ["preset", "says_what_it_will_do", "advice_is_given_only", *others])
    passes(suite, left_out, PLCFMU_FMUS=str(blocks), PLCFMU_FMI3=str(newer_blocks), PLCFMU_RANDOM="0.25")


def test_hostile_calls_are_refused_by_the_c_of_the_blocks_as_the_standard_says(packer, blocks, packed, tmp_path):
    # The suite in Rust, over the C of the blocks; beside them a library whose saved states are foreign to them.
    run(packer, "fmu", "--package", "counter", "--out", tmp_path, cwd=ROOT)
    libraries = tmp_path / "lib"
    shutil.copytree(blocks / "lib", libraries)
    name = f"COUNTER{fmpy.sharedLibraryExtension}"
    with zipfile.ZipFile(tmp_path / "test-only/COUNTER.fmu") as fmu:
        (libraries / f"lib{name.lower()}").write_bytes(fmu.read(f"binaries/{fmpy.platform}/{name}"))
    # As `cargo xtask test` does, so that nothing is compiled anew; other rooms have suites of the same name.
    build = ["cargo", "test", "--workspace", "--test", "hostile", "--no-run", "--message-format=json-render-diagnostics"]
    told = [json.loads(line) for line in run(*build, cwd=ROOT).splitlines()]
    (suite,) = [of["executable"] for of in told if of.get("executable") and "/tests/rust/" in of["target"]["src_path"]]

    def attack(folder, calls, *which):
        environment = {**os.environ, "PLCFMU_LIBRARIES": str(folder), "PLCFMU_HOSTILE_CALLS": str(calls), "PLCFMU_HOSTILE_TYPES": "native"}
        return run(suite, "--nocapture", *which, cwd=ROOT / "tests", env=environment)

    told = attack(libraries, 50_000, "--skip", "newer")
    assert "test result: ok. 7 passed" in told and told.count("calls on instances") == len(BLOCKS), told
    # In FMI 3.0 one block stands for all, as they share their functions. Its library has both versions, as those in Rust.
    both = tmp_path / "both"
    both.mkdir()
    shutil.copy(libraries / f"lib{name.lower()}", both)
    c_builds.joined([host.FOLDER / "CONT_C.fmu", packed() / "CONT_C.fmu"], both)
    assert "test result: ok. 1 passed" in attack(both, 20_000, "newer")


# --- Both doors -----------------------------------------------------------------------------------------------------

ODD = [0.0, -0.0, 1e-45, 0.1, -3.5, 1e30, 3.4e38, 3.5e38, 1e300, float("nan"), float("inf"), 65535.0, -32768.0, 0.5]


def answer(instance, function, *given):
    """The status of a call and why it is refused. Advice is not the same in both."""
    count = len(instance.messages)
    status = instance.call(function, *given)
    return status, [message.text for message in instance.messages[count:]]


def change(generator, fmu):
    """Some call that sets something, as (function, arguments)."""
    def of(type):
        """Times are whole milliseconds in FMI 3.0, where what is not a number cannot be given."""
        return [name for name in fmu.of("input", "parameter", type=type) if not fmu.is_newer or fmu.kinds[name] != "TIME"]

    types = [type for type in ("Real", "Real", "Integer", "Boolean") if of(type)]
    type = generator.choice(types)
    names = generator.sample([name for name in fmu.variables if not fmu.is_newer or fmu.kinds[name] != "TIME"], 2) if generator.random() < 0.2 else [
        generator.choice(of(type))
    ]
    number = generator.choice(ODD) if generator.random() < 0.3 else generator.uniform(-50, 50)
    values = [number if type == "Real" else int(min(max(number if number == number else 0, -1e9), 1e9)) for _ in names]
    return f"fmi2Set{type}", (host.references(fmu, names), len(names), (host.C_TYPES[type] * len(names))(*values))


DOORS = ["Mixer", "Kinds", "Conveyor", "TankFilling", *BLOCKS]


@pytest.mark.parametrize(
    "name, seed", [*((name, seed) for name in DOORS for seed in range(3)), *((host.NEWER + name, 3) for name in DOORS)]
)
def test_both_doors_answer_alike_and_have_the_same_states(seed, name, both):
    """Random calls, refused ones among them: status, message, all values and the bytes of the saved state are equal; and each
    goes on from the state of the other."""
    rust, native = both(name)
    generator = random.Random(seed)
    pair = [fmu.instance() for fmu in (rust, native)]
    for instance in pair:
        instance.start(start_time=generator.choice([0.0]))
    time, refused = 0.0, 0
    for _ in range(300):
        function, given = change(generator, native)
        if generator.random() < 0.4:
            h = generator.choice([0.1, 0.1, 0.1, 0.05, 0.3, 1.0, 0.1 + 1e-9, 0.2 if rust.is_newer else 0.0, -1.0, float("nan")])
            tc = time if generator.random() < 0.9 else generator.choice([time + 0.25, time - 1.0, float("inf")])
            function, given = "fmi2DoStep", (tc, h, 1)
        answers = [answer(instance, function, *given) for instance in pair]
        assert answers[0] == answers[1], (function, given)
        refused += answers[0][0] != host.OK
        if function == "fmi2DoStep" and answers[0][0] == host.OK:
            time = max(time, tc + h)
        assert pair[0].values() == pair[1].values()
        contents = [instance.content() for instance in pair]
        assert contents[0] == contents[1]
        if generator.random() < 0.1:
            for instance, content in zip(pair, reversed(contents)):
                instance.restore(instance.deserialize(content))
    assert refused > 10


ARRAYS = """FUNCTION_BLOCK Arrays
VAR_INPUT table : ARRAY[0..2] OF INT := [1, 2, 3]; mask : DWORD; word : WORD; wait : TIME := T#-1s; long : LINT; big : ULINT;
  small : USINT; x : REAL; y : LREAL; on : BOOL; name : STRING[8] := 'a'; END_VAR
VAR_OUTPUT sum : LINT; turned : ARRAY[1..3] OF INT; told : STRING[8]; left : TIME; z : REAL; calls : UDINT; END_VAR
VAR i : INT; END_VAR
BEGIN calls := calls + 1; sum := sum + long + table[0] + table[1] + table[2]; told := name; left := wait; z := x + 1.0;
FOR i := 1 TO 3 DO turned[i] := table[3 - i]; END_FOR; END_FUNCTION_BLOCK"""


class Events:
    """An instance with Event Mode, called as by C: each call gives the status and what was said."""

    def __init__(self, path, folder, may_return_early):
        fmpy.extract(str(path), str(folder))
        self.description = fmpy.read_model_description(str(path))
        self.variables = self.description.modelVariables
        library = folder / "binaries" / fmpy.platform_tuple / f"{path.stem}{fmpy.sharedLibraryExtension}"
        self.dll, self.said = ctypes.CDLL(str(library)), []
        self.log = fmpy.fmi3.fmi3LogMessageCallback(lambda _, status, category, text: self.said.append((status, category, text)))
        self.dll.fmi3InstantiateCoSimulation.restype = ctypes.c_void_p
        given = (b"x", self.description.instantiationToken.encode(), str(folder / "resources").encode() + b"/", False, True, True)
        self.component = ctypes.c_void_p(
            self.dll.fmi3InstantiateCoSimulation(*given, may_return_early, None, ctypes.c_size_t(0), None, self.log, None)
        )
        assert self.component, self.said

    def call(self, function, *given):
        self.said.clear()
        status = getattr(self.dll, f"fmi3{function}")(self.component, *given)
        # Advice is not the same in both.
        return status, [message for message in self.said if message[1] != b"logAdvice"]

    def set(self, type, references, values):
        return self.call(f"Set{type}", references, ctypes.c_size_t(len(references)), values, ctypes.c_size_t(len(values)))

    def get(self, type, references, count):
        values = (newer.C_TYPES.get(type, ctypes.c_char_p) * count)()
        answer = self.call(f"Get{type}", references, ctypes.c_size_t(len(references)), values, ctypes.c_size_t(count))
        return answer, [repr(value) for value in values]

    def values(self):
        """All variables."""
        found = []
        for variable in self.variables:
            count = int(variable.dimensions[0].start) if variable.dimensions else 1
            found.append(self.get(variable.type, (ctypes.c_uint * 1)(variable.valueReference), count))
        return found

    def step(self, tc, h):
        flags, last = [ctypes.c_bool(True) for _ in range(3)], ctypes.c_double()
        given = (ctypes.c_double(tc), ctypes.c_double(h), True, *map(ctypes.byref, flags), ctypes.byref(last))
        return self.call("DoStep", *given), [flag.value for flag in flags], last.value

    def event(self):
        flags, following = [ctypes.c_bool(True) for _ in range(5)], ctypes.c_double()
        return self.call("UpdateDiscreteStates", *map(ctypes.byref, flags), ctypes.byref(following)), [of.value for of in flags], following.value

    def content(self):
        state, size = ctypes.c_void_p(), ctypes.c_size_t()
        assert self.call("GetFMUState", ctypes.byref(state))[0] == self.call("SerializedFMUStateSize", state, ctypes.byref(size))[0] == 0
        buffer = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUState", state, buffer, size)[0] == self.call("FreeFMUState", ctypes.byref(state))[0] == 0
        return buffer.raw

    def restore(self, content):
        state = ctypes.c_void_p()
        answers = [self.call("DeserializeFMUState", content, ctypes.c_size_t(len(content)), ctypes.byref(state)), self.call("SetFMUState", state)]
        self.call("FreeFMUState", ctypes.byref(state))
        return answers

    def depends(self, reference):
        count = ctypes.c_size_t()
        answer = self.call("GetNumberOfVariableDependencies", reference, ctypes.byref(count))
        sizes = [(ctypes.c_size_t * count.value)() for _ in range(2)]
        independents, kinds = (ctypes.c_uint * count.value)(), (ctypes.c_int * count.value)()
        more = self.call("GetVariableDependencies", reference, sizes[0], independents, sizes[1], kinds, count)
        return answer, more, list(independents), list(kinds)


def random_set(generator, variables):
    """A call that sets variables, some of them wrongly, as (type, references, values)."""
    variable = generator.choice(variables)
    type, count = variable.type, int(variable.dimensions[0].start) if variable.dimensions else 1
    if generator.random() < 0.1:
        type = generator.choice([of.type for of in variables])
    if generator.random() < 0.1:
        count = generator.choice([0, 1, 2, 3])
    reference = variable.valueReference + (generator.choice([1, 2, 100]) if generator.random() < 0.1 else 0)
    if type == "String":
        values = (ctypes.c_char_p * count)(*[generator.choice([b"b", b"longer than eight", "\u20ac".encode(), None])] * count)
    elif type in ("Float32", "Float64"):
        values = (newer.C_TYPES[type] * count)(*(generator.choice(ODD) for _ in range(count)))
    else:
        values = (newer.C_TYPES[type] * count)(*(generator.choice([0, 1, -1, 2**15, 2**31, 2**53 + 1, 2**63]) for _ in range(count)))
    return type, (ctypes.c_uint * 1)(reference), values


@pytest.mark.parametrize("early", [False, True], ids=["whole steps", "early return"])
def test_both_doors_answer_alike_in_event_mode_with_arrays_and_exact_types(early, command, tmp_path):
    (tmp_path / "arrays.scl").write_text(ARRAYS)
    pair = []
    for more in ([], ["--native"]):
        folder = tmp_path / f"of{len(more)}"
        run(command, "build", "arrays.scl", "--fmi=3", "--cycle=100ms", f"--out={folder}", *more, cwd=tmp_path, env=host.environment())
        pair.append(Events(folder / "Arrays.fmu", folder, early))
    generator, time, refused = random.Random(1), 0.0, 0

    def same(ask):
        answers = [ask(of) for of in pair]
        assert answers[0] == answers[1]
        return answers[0]

    initialization = (False, ctypes.c_double(0.0), ctypes.c_double(0.0), False, ctypes.c_double(0.0))
    for function, given in [("EnterStepMode", ()), ("EnterInitializationMode", initialization), ("ExitInitializationMode", ())]:
        same(lambda of: of.call(function, *given))
        same(Events.values)
        for variable in pair[0].variables:
            same(lambda of: of.depends(variable.valueReference))
    assert same(Events.event)[1:] == ([False, False, False, False, True], 0.1)
    for _ in range(300):
        given = random_set(generator, pair[0].variables)
        refused += same(lambda of: of.set(*given))[0] != 0
        what = generator.choice(["EnterEventMode", "event", "EnterStepMode", "step", "step", "step", "restore"])
        if what == "event":
            same(Events.event)
        elif what == "step":
            h = generator.choice([0.1, 0.05, 0.2, 0.35, 0.0, -1.0])
            (status, _), _, last = same(lambda of: of.step(time, h))
            time = last if status == 0 else time
        elif what == "restore":
            contents = [of.content() for of in pair]
            assert contents[0] == contents[1]
            same(lambda of: of.restore(contents[0]))
        else:
            same(lambda of: of.call(what))
        same(Events.values)
    assert refused > 30 and time > 2.0
    category = (ctypes.c_char_p * 1)(b'a\x01"\n\x1f\x7f')
    told = same(lambda of: of.call("SetDebugLogging", True, ctypes.c_size_t(1), category))[1]
    assert rb'category "a\u{1}\"\n\u{1f}\u{7f}" is unknown' in told[0][2]
    for function, given in [("GetFMUState", (None,)), ("FreeFMUState", (None,)), ("DeserializeFMUState", (b"", ctypes.c_size_t(0), None))]:
        assert same(lambda of: of.call(function, *given))[1][0][2].endswith(b": FMUState is NULL; it must point to a variable")
    same(lambda of: of.call("SetFMUState", ctypes.c_void_p(8)))


def test_a_stop_is_told_alike_and_is_in_the_state(command, tmp_path):
    text = 'FUNCTION_BLOCK "Stop" VAR_INPUT i : Int; END_VAR VAR_OUTPUT n : Int; END_VAR VAR a : Array[0..2] of Int; END_VAR\n' \
        "BEGIN #n := #n + 1;\n#a[#i] := 1;\nEND_FUNCTION_BLOCK"
    (tmp_path / "stop.scl").write_text(text, encoding="utf-8")
    told = []
    for more in ([], ["--native"]):
        folder = tmp_path / f"of{len(more)}"
        run(command, "build", "stop.scl", "--cycle=0.5s", f"--out={folder}", *more, cwd=tmp_path, env=host.environment())
        unpacked = fmpy.extract(str(folder / "Stop.fmu"))
        description = fmpy.read_model_description(unpacked)
        slave = fmpy.fmi2.FMU2Slave(
            guid=description.guid, modelIdentifier="Stop", unzipDirectory=unpacked, instanceName="stop"
        )
        log = host.Log()
        slave.instantiate(callbacks=log.callbacks)
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slave.doStep(0.0, 0.5)
        slave.setInteger([0], [3])
        with pytest.raises(fmpy.fmi1.FMICallException):
            slave.doStep(0.5, 0.5)
        told.append((log.take()[-1].text, slave.serializeFMUstate(slave.getFMUstate())))
        slave.freeInstance()
    assert told[0] == told[1]
    assert "stop.scl:3: index 3 is outside 0..2 (call 1, 0.5 s after the start)" in told[0][0]


# --- Self-test and memory ---------------------------------------------------------------------------------------------


def library_of(source, folder, change=lambda text: text, *options):
    """Compiles the file, changed, as a library that has no prefix."""
    text = source.read_text(encoding="utf-8")
    changed = change(text)
    path = folder / source.name
    path.write_text(changed, encoding="utf-8")
    library = folder / f"changed{fmpy.sharedLibraryExtension}"
    words = ["gcc -std=c99", "-O2", "-shared", "-fPIC", "-DDISABLE_PREFIX", "-I", HEADERS, *options]
    run(*compiler(words[0]), *words[1:], path, "-o", library)
    return ctypes.CDLL(str(library))


def instantiate(library, guid):
    library.fmi2Instantiate.restype = ctypes.c_void_p
    log = host.Log(memory=False)
    given = (b"x", 1, guid.encode(), None, ctypes.byref(log.callbacks), 0, 0)
    return library.fmi2Instantiate(*given), [message.text for message in log.messages]


@pytest.mark.parametrize(
    "change, is_refused",
    [
        (lambda text: text, False),
        (lambda text: text.replace("27648.0f", "27647.0f"), True),
        (lambda text: re.sub(r"(PLCFMU_TEST_LOW 0x\w*)(\w)ull", lambda of: f"{of[1]}{int(of[2], 16) ^ 1:x}ull", text), True),
    ],
    ids=["as it is", "one constant", "another hash"],
)
def test_the_self_test_refuses_another_result(change, is_refused, source, native, tmp_path):
    assert change("") == "" or change(source.read_text(encoding="utf-8")) != source.read_text(encoding="utf-8")
    component, told = instantiate(library_of(source, tmp_path, change), native.description.guid)
    assert (component is None) == is_refused
    assert bool(told) == is_refused and all("compiled with options that change its results" in text for text in told)


@pytest.mark.parametrize("name", ["CONT_C", "HLG", "PULSEGEN", "PULS_CTR"])
def test_the_self_test_finds_fused_multiplication_and_addition(both, name, tmp_path):
    cpu = pathlib.Path("/proc/cpuinfo")
    if not cpu.exists() or " fma " not in cpu.read_text():
        pytest.skip("this processor has no fused multiplication and addition for x86")
    fmu, _ = both(name)
    pragma = '#pragma GCC optimize("fp-contract=off")'
    source = fmu.folder / "sources" / f"{name}.c"
    for options, is_refused in [((), False), (("-mfma", "-ffp-contract=fast"), True)]:
        (tmp_path / str(is_refused)).mkdir()
        library = library_of(source, tmp_path / str(is_refused), lambda text: text.replace(pragma, ""), *options)
        assert (instantiate(library, fmu.description.guid)[0] is None) == is_refused


def test_a_static_pool_has_as_many_instances_as_it_says(source, native, tmp_path):
    library = library_of(source, tmp_path, lambda text: text, "-DPLCFMU_MAX_INSTANCES=2")
    made = [instantiate(library, native.description.guid) for _ in range(3)]
    assert [component is None for component, _ in made] == [False, False, True]
    assert "PLCFMU_MAX_INSTANCES" in made[2][1][0]
    library.fmi2FreeInstance(ctypes.c_void_p(made[0][0]))
    assert instantiate(library, native.description.guid)[0] == made[0][0]


# --- One hash -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def program(programs, blocks, tmp_path_factory):
    """The folder of a program that links all FMUs statically, each under its prefix, and its C files."""
    folder = tmp_path_factory.mktemp("program")
    header, runs = [], []
    for path in sorted([*programs(True).glob("*.fmu"), *(blocks / f"{name}.fmu" for name in BLOCKS)]):
        fmu = host.Fmu(path, folder / path.stem)
        letters = ""
        for name, variable in fmu.variables.items():
            kind = fmu.kinds[name]
            is_whole = kind in ("TIME", "LTIME", "UDINT", "LINT", "ULINT", "LWORD")
            letter = "W" if is_whole else variable.type[0]
            letters += letter if variable.causality == "input" else "-"
        name = fmu.name
        header.append(
            f'FMU({name})\nconst char *const {name}_guid = "{fmu.description.guid}";\n'
            f'const char {name}_types[] = "{letters}";\nconst double {name}_cycle = {fmu.cycle!r};\n'
        )
        runs.append(f"run_{name}();")
    (folder / "fmus.h").write_text("".join(header) + f"#define RUN {' '.join(runs)}\n")
    return folder, [RUN, *sorted(folder.glob("*/sources/*.c"))]


BUILDS = {
    **{f"gcc {level}": f"gcc -std=c99 {level}" for level in ("-O0", "-O2", "-O3")},
    **{f"clang {level}": f"clang -std=c99 {level}" for level in ("-O0", "-O3")},
    "gcc -O3 -march=native": "gcc -O3 -march=native",
    "gcc -O2 -mfma": "gcc -O2 -mavx2 -mfma",
    "clang -O3 -march=native": "clang -O3 -march=native",
    "zig": "zig cc -O2",
    "i386 with SSE": "zig cc -target x86-linux-musl -mcpu=pentium4 -O2 -static",
    "aarch64": "zig cc -target aarch64-linux-musl -O3 -static",
    "win64": "zig cc -target x86_64-windows-gnu -O2",
    "win64 by mingw": "x86_64-w64-mingw32-gcc -std=c99 -O2",
}
# One of each kind is enough for every day: the others are compiled by `cargo xtask test --deep`.
DEEP = ["gcc -O3", "clang -O0", "clang -O3 -march=native", "gcc -O2 -mfma", "zig", "i386 with SSE", "aarch64", "win64"]
RUNNERS = {"aarch64": ["qemu-aarch64"], "win64": [host.remote.RUNNERS["win64"]]}


@pytest.fixture(scope="module")
def expected(program, tmp_path_factory):
    """What the program of gcc -O0 prints."""
    return hashes(program, "gcc -std=c99 -O0", [], tmp_path_factory.mktemp("expected"))


def hashes(program, words, runner, folder):
    sources, files = program
    built = folder / ("run.exe" if "windows" in words or "mingw" in words else "run")
    run(*compiler(words), "-I", PREFIXING, "-I", sources, *files, "-o", built)
    if runner and not shutil.which(runner[0]):
        pytest.skip(f"{runner[0]} is missing: install qemu-user and wine64")
    wine = host.remote.BUILT / "wine"
    wine.parent.mkdir(parents=True, exist_ok=True)
    environment = {**os.environ, "WINEPREFIX": str(wine), "WINEDEBUG": "-all"}
    return run(*runner, built, env=environment).split()


@pytest.mark.parametrize("build", [pytest.param(name, marks=[pytest.mark.deep] * (name in DEEP)) for name in BUILDS])
def test_every_compiler_option_and_platform_gives_the_same_states(build, program, expected, tmp_path):
    assert hashes(program, BUILDS[build], RUNNERS.get(build.split(" by")[0], []), tmp_path) == expected


@pytest.mark.parametrize("types", [None, "wide"], ids=["FMI 2.0", "FMI 3.0"])
def test_fmpy_compiles_an_fmu_that_has_sources_alone(types, programs, tmp_path):
    cmake = pathlib.Path(sys.executable).parent
    if not (cmake / "cmake").exists() and not shutil.which("cmake"):
        pytest.skip("cmake is missing: pip install cmake")
    unpacked = tmp_path / "unpacked"
    fmpy.extract(str(programs(False, types) / "Mixer.fmu"), unpacked)
    shutil.rmtree(unpacked / "binaries")
    path = os.environ["PATH"]
    os.environ["PATH"] = f"{cmake}{os.pathsep}{path}"
    try:
        fmpy.build.build_platform_binary(unpacked)
    finally:
        os.environ["PATH"] = path
    result = fmpy.simulate_fmu(str(unpacked), stop_time=1.0, output_interval=0.1)
    assert len(result) == 11


def test_cmake_links_all_fmus_statically(program, expected, tmp_path):
    cmake = pathlib.Path(sys.executable).parent / "cmake"
    cmake = cmake if cmake.exists() else shutil.which("cmake")
    if not cmake:
        pytest.skip("cmake is missing: pip install cmake")
    sources, files = program
    libraries = "\n".join(f"add_library({file.stem} STATIC {file})" for file in files[1:])
    names = " ".join(file.stem for file in files[1:])
    (tmp_path / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.10)\nproject(fmus C)\ninclude_directories({PREFIXING} {sources})\n{libraries}\n"
        f"add_executable(fmus {files[0]})\ntarget_link_libraries(fmus {names})\n"
    )
    run(cmake, "-S", tmp_path, "-B", tmp_path / "build", "-DCMAKE_BUILD_TYPE=Release")
    run(cmake, "--build", tmp_path / "build")
    assert run(tmp_path / "build" / "fmus").split() == expected
