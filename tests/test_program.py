"""`plcfmu build FILE.scl`: the FMU of a PLC program gives the bits of the cases that judge the language, keeps the promises of
our FMUs on states and restart, and tells with file and line why it stops."""

import json
import os
import pathlib
import struct
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor

import fmpy
import fmpy.validation
import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

import host
import plcfmu
from plcfmu.messages import Log

CASES = pathlib.Path(__file__).parents[1] / "scl/tests/cases"
EXAMPLES = ("tank", "furnace", "conveyor")

pytestmark = host.in_fmpy


def example(name):
    return json.loads((CASES / f"example_{name}.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def build(command, tmp_path_factory):
    """Packs the program of a text; gives the process and the folder."""

    def build(source, *options):
        folder = tmp_path_factory.mktemp("program")
        (folder / "machine.scl").write_text(source, encoding="utf-8")
        arguments = [command, "build", "machine.scl", *options]
        return subprocess.run(arguments, cwd=folder, env=host.environment(), capture_output=True, text=True), folder

    return build


class Running:
    """An instance of a program's FMU, driven by names."""

    def __init__(self, path, before=()):
        self.folder = fmpy.extract(str(path))
        description = fmpy.read_model_description(self.folder)
        self.variables = {variable.name: variable for variable in description.modelVariables}
        identifier = description.coSimulation.modelIdentifier
        self.log = Log()
        self.slave = fmi2.FMU2Slave(
            guid=description.guid, unzipDirectory=self.folder, modelIdentifier=identifier, instanceName="machine"
        )
        self.slave.instantiate(loggingOn=True, callbacks=self.log.callbacks)
        self.start(before)

    def start(self, before=()):
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        for name, value in before:
            self.set(name, value)
        self.slave.exitInitializationMode()
        self.calls = 0

    def set(self, name, value):
        variable = self.variables[name]
        {"Real": self.slave.setReal, "Integer": self.slave.setInteger, "Boolean": self.slave.setBoolean}[variable.type](
            [variable.valueReference], [value]
        )

    def get(self, name):
        variable = self.variables[name]
        get = {"Real": self.slave.getReal, "Integer": self.slave.getInteger, "Boolean": self.slave.getBoolean}
        return get[variable.type]([variable.valueReference])[0]

    def call(self, seconds):
        self.slave.doStep(self.calls * seconds, seconds)
        self.calls += 1


def given(value, of):
    """The value of a case for an FMU: a REAL stands as bits, a TIME in milliseconds."""
    if of in ("REAL", "LREAL"):
        bits = int(value, 16)
        return struct.unpack("<f", struct.pack("<I", bits))[0] if of == "REAL" else struct.unpack("<d", struct.pack("<Q", bits))[0]
    number = int(value, 16) if isinstance(value, str) else int(value)
    if of == "TIME":
        return number / 1000
    return number


def got(value, of):
    """The value of an FMU as a case has it."""
    if of == "REAL":
        return struct.unpack("<I", struct.pack("<f", value))[0]
    if of == "TIME":
        return round(value * 1000)
    if of == "WORD":
        return int(value) & 0xFFFF
    return int(value)


def expected(value, of):
    return int(value, 16) if isinstance(value, str) else int(value)


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_that_ships_is_the_one_that_is_judged(name):
    shipped = CASES.parents[2] / "examples/programs" / f"{name}.scl"
    assert shipped.read_text(encoding="utf-8") == example(name)["scl"]


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_gives_the_bits_of_its_case_in_every_call(build, name):
    case = example(name)
    done, folder = build(case["scl"], f"--cycle={case['cycle_ms']}ms", f"--fb={case['block']}")
    assert done.returncode == 0, done.stderr
    running = Running(folder / f"{case['block']}.fmu")
    for call, (inputs, outputs) in enumerate(zip(case["tape"], case["expected"])):
        for variable, value in zip(case["inputs"], inputs):
            running.set(variable["name"], given(value, variable["type"]))
        running.call(case["cycle_ms"] / 1000)
        for variable, value in zip(case["outputs"], outputs):
            found = got(running.get(variable["name"]), variable["type"])
            assert found == expected(value, variable["type"]), f"call {call}, {variable['name']}"
    running.slave.terminate()
    running.slave.freeInstance()


COUNTER = """
FUNCTION_BLOCK "Counter"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
   VAR_INPUT
      enable : Bool := TRUE;
      limit { S7_SetPoint := 'True'} : DInt := 3;   // the count that stops; min 0, max 100000
      index : Int;
   END_VAR
   VAR_OUTPUT
      count : DInt;
      speed : Real;   // parts made; unit: rpm
   END_VAR
   VAR_IN_OUT
      sum : Real;
   END_VAR
   VAR
      list : Array[0..2] of Int;
      t : TON_TIME;
   END_VAR
BEGIN
    #t(IN := #enable, PT := T#1s);
    IF #enable AND #count < #limit THEN
        #count := #count + 1;
    END_IF;
    #speed := DINT_TO_REAL(#count) * 2.0;
    #sum := #sum + 0.5;
    #list[#index] := 7;
END_FUNCTION_BLOCK
"""


@pytest.fixture(scope="module")
def counter(build):
    done, folder = build(COUNTER, "--cycle=0.5s")
    assert done.returncode == 0, done.stderr
    return folder / "Counter.fmu"


def test_the_model_description_comes_from_the_source(counter):
    assert fmpy.validation.validate_fmu(str(counter)) == []
    description = fmpy.read_model_description(str(counter))
    variables = {variable.name: variable for variable in description.modelVariables}
    limit, speed = variables["limit"], variables["speed"]
    assert (limit.causality, limit.variability, limit.type, limit.start) == ("parameter", "tunable", "Integer", "3")
    assert (limit.min, limit.max, limit.description) == ("0", "100000", "the count that stops")
    assert (speed.causality, speed.unit, speed.description) == ("output", "rpm", "parts made")
    assert (variables["sum"].causality, variables["sum_out"].causality) == ("input", "output")
    assert (variables["t.Q"].causality, variables["list[1]"].causality) == ("local", "local")
    assert (variables["CYCLE"].start, description.defaultExperiment.stepSize) == ("0.5", "0.5")


def test_a_program_counts_by_its_parameter_and_an_in_out_keeps_what_the_host_gives(counter):
    running = Running(counter, [("limit", 2), ("sum", 1.25)])
    for count, is_over in ((1, False), (2, False), (2, True)):
        running.call(0.5)
        # TON: from the first call on, so 1 s later in the third.
        assert (running.get("count"), running.get("speed"), bool(running.get("t.Q"))) == (count, 2.0 * count, is_over)
        assert (running.get("sum"), running.get("sum_out")) == (1.25, 1.75)
    # Tunable: it holds from the next call on.
    running.set("limit", 5)
    running.call(0.5)
    assert running.get("count") == 3


def test_a_state_goes_on_with_the_same_bits_and_in_another_instance(counter):
    running, other = Running(counter), Running(counter)
    running.call(0.5)
    state = running.slave.getFMUstate()
    serialized = running.slave.serializeFMUstate(state)
    running.call(0.5)
    running.call(0.5)
    after = [running.get(name) for name in ("count", "t.ET", "sum_out")]
    running.slave.setFMUstate(state)
    running.calls = other.calls = 1
    other.slave.setFMUstate(other.slave.deSerializeFMUstate(serialized))
    for again in (running, other):
        again.call(0.5)
        again.call(0.5)
        assert [again.get(name) for name in ("count", "t.ET", "sum_out")] == after
    running.slave.freeFMUstate(state)


def test_a_stop_is_an_error_with_file_and_line_and_a_reset_begins_again(counter):
    running = Running(counter)
    running.call(0.5)
    running.set("index", 3)
    with pytest.raises(FMICallException):
        running.call(0.5)
    line = COUNTER.splitlines().index("    #list[#index] := 7;") + 1
    assert f"machine.scl:{line}: index 3 is outside 0..2 (call 1, 0.5 s after the start)" in running.log.take()[-1].text
    assert running.get("count") == 1, "the values are those before the call"
    running.slave.reset()
    running.start()
    running.call(0.5)
    assert running.get("count") == 1


def test_a_preset_of_a_program_starts_from_its_values(counter, command, tmp_path):
    def preset(of, name, *settings):
        given = [command, "preset", of, *(f"--set={setting}" for setting in settings), f"--out={name}.fmu"]
        done = subprocess.run(given, cwd=tmp_path, env=host.environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return tmp_path / f"{name}.fmu"

    small = preset(counter, "SMALL", "limit=2", "sum=1.25", "CYCLE=0.25")
    assert fmpy.validation.validate_fmu(str(small)) == []
    description = fmpy.read_model_description(str(small))
    starts = {variable.name: variable.start for variable in description.modelVariables}
    assert (starts["limit"], starts["sum"], starts["CYCLE"]) == ("2", "1.25", "0.25")
    running = Running(small)
    for count, total in ((1, 1.75), (2, 1.75), (2, 1.75)):
        running.call(0.25)
        assert (running.get("count"), running.get("sum_out")) == (count, total)
    running.slave.reset()
    assert running.get("limit") == 2
    # A preset of it has the values of both.
    running = Running(preset(small, "LARGE", "limit=5"))
    for _ in range(6):
        running.call(0.25)
    assert (running.get("count"), running.get("sum_out")) == (5, 1.75)
    with zipfile.ZipFile(small) as original, zipfile.ZipFile(tmp_path / "changed.fmu", "w") as changed:
        for name in original.namelist():
            content = original.read(name)
            changed.writestr(name, content.replace(b"1.25", b"1.75") if name.endswith("start.txt") else content)
    with pytest.raises(Exception):
        Running(tmp_path / "changed.fmu")


def test_a_source_that_was_changed_by_hand_is_refused(counter, tmp_path):
    with zipfile.ZipFile(counter) as original, zipfile.ZipFile(tmp_path / "Counter.fmu", "w") as changed:
        for name in original.namelist():
            content = original.read(name)
            changed.writestr(name, content.replace(b"* 2.0", b"* 3.0") if name.endswith(".scl") else content)
    with pytest.raises(Exception):
        Running(tmp_path / "Counter.fmu")


def test_the_fmu_says_the_licences_of_the_crates_in_its_library(counter):
    sys.path.insert(0, str(CASES.parents[2] / "plcfmu/python"))
    try:
        import notices
    finally:
        del sys.path[0]
    with zipfile.ZipFile(counter) as package:
        packed = package.read("documentation/licenses/NOTICE-PROGRAM").decode()
    assert packed == notices.of_programs("x86_64-unknown-linux-gnu"), "renew it: python plcfmu/python/notices.py"
    assert "- memchr 2." in packed and "Permission is hereby granted" in packed


def test_what_is_wrong_is_told_with_its_place_and_nothing_is_written(build):
    done, folder = build(COUNTER.replace("#count := #count + 1", "#count := #cuont + 1"), "--cycle=1s")
    line = COUNTER.splitlines().index("        #count := #count + 1;") + 1
    assert done.returncode == 1 and f"machine.scl:{line}:" in done.stderr and "cuont" in done.stderr, done.stderr
    assert list(folder.glob("*.fmu")) == []
    done, _ = build(COUNTER)
    assert done.returncode == 1 and "--cycle 100ms" in done.stderr
    done, _ = build(COUNTER, "--cycle=1s", "--parameter=enabel")
    assert done.returncode == 1 and "Counter has no input enabel that could become a parameter; available: enable" in done.stderr


LINE = """
FUNCTION_BLOCK "Pump"
   VAR_INPUT
      on : Bool;
   END_VAR
   VAR_OUTPUT
      flow : Real;
   END_VAR
   VAR
      rate : Real := 1.5;
   END_VAR
BEGIN
    IF #on THEN #flow := #flow + #rate; END_IF;
END_FUNCTION_BLOCK

DATA_BLOCK "Pump_DB"
"Pump"
BEGIN
    rate := 2.0;
END_DATA_BLOCK

DATA_BLOCK "Plant"
   VAR
      scale : Real := 10.0;   // unit: bar
      total : Real;
      command : Int;
      runs : DInt;
      starts : Int;
   END_VAR
   VAR RETAIN
      hours : DInt := 5;
      "shift sums" : Array[1..2] of Int := [7, 8];
   END_VAR
BEGIN
END_DATA_BLOCK

ORGANIZATION_BLOCK "Main"
BEGIN
    "Pump_DB"(on := "Start");
    "Plant".total := "Pump_DB".flow * "Plant".scale + 1000.0 * INT_TO_REAL("Plant".command);
    "Plant".command := 0;
    "Lamp" := "Start";
    "Plant".hours := "Plant".hours + 1;
    "Plant"."shift sums"[2] := "Plant"."shift sums"[2] + 1;
END_ORGANIZATION_BLOCK

ORGANIZATION_BLOCK "Cyclic"
BEGIN
    // Before Main where both are due: Main sees the new number.
    "Plant".runs := "Plant".runs + 1;
END_ORGANIZATION_BLOCK

ORGANIZATION_BLOCK "Startup"
BEGIN
    "Plant".starts := "Plant".starts + 1;
END_ORGANIZATION_BLOCK
"""
TAGS = ("--tag=Start : Bool", "--tag=Lamp : Bool")


def test_organization_blocks_are_called_with_their_periods_and_the_interface_is_tags_and_data_blocks(build):
    options = ("--call=Main", "--cycle=20ms", "--call=Cyclic", "--cycle=50ms", "--input=Plant.command", "--output=Plant.total")
    done, folder = build(LINE, *TAGS, *options)
    assert done.returncode == 0, done.stderr
    path = folder / "Cyclic.fmu"
    assert fmpy.validation.validate_fmu(str(path)) == []
    running = Running(path, [("Plant.scale", 4.0), ("Plant.hours_start", 100), ("Plant.'shift sums_start'[2]", 9)])
    of = {name: (variable.causality, variable.variability) for name, variable in running.variables.items()}
    assert of["Start"] == ("input", "discrete") and of["Lamp"][0] == of["Plant.total"][0] == "output"
    assert of["Plant.scale"] == ("parameter", "tunable") and of["Plant.hours_start"] == ("parameter", "fixed")
    assert of["Plant.command"][0] == "input" and of["Plant.command_out"][0] == "output"
    assert of["Pump_DB.rate"][0] == "local" and running.variables["CYCLE"].start == "0.01"
    assert (running.get("Plant.starts"), running.get("Plant.runs")) == (1, 0), "the start-up block before the first call"
    assert [running.get(f"Plant.'shift sums'[{index}]") for index in (1, 2)] == [7, 9]
    running.set("Start", True)
    running.set("Plant.command", 3)
    for _ in range(11):
        running.call(0.01)
    # Main at 0, 20, 40, 60, 80 and 100 ms, Cyclic at 0, 50 and 100 ms; the data block's rate is 2.
    assert (running.get("Plant.runs"), running.get("Plant.hours"), running.get("Plant.starts")) == (3, 106, 1)
    assert running.get("Plant.'shift sums'[2]") == 9 + 6
    assert running.get("Plant.total") == 6 * 2.0 * 4.0 + 3000.0 and running.get("Lamp")
    assert (running.get("Plant.command"), running.get("Plant.command_out")) == (3, 0)


def test_an_instance_data_block_gives_the_start_values_of_the_block_that_is_run(build):
    source = LINE[: LINE.index('DATA_BLOCK "Plant"')]
    done, folder = build(source, "--cycle=1s")
    assert done.returncode == 0, done.stderr
    running = Running(folder / "Pump.fmu", [("on", True)])
    running.call(1.0)
    assert running.get("flow") == 2.0
    for option, flow in (("--fb=Pump", 1.5), ("--instance=Pump_DB", 2.0)):
        done, folder = build(source, "--cycle=1s", option)
        assert done.returncode == 0, done.stderr
        running = Running(folder / "Pump.fmu", [("on", True)])
        running.call(1.0)
        assert running.get("flow") == flow


def test_what_does_not_apply_is_refused_and_several_blocks_ask_for_a_choice(build, command, tmp_path):
    done, _ = build(LINE.replace('"Main"', '"Fast"'), *TAGS, "--cycle=1s")
    assert "not called by any other: Fast, Cyclic; choose" in done.stderr, done.stderr
    # Beside Main, it is known who comes last; the period of the other is not.
    done, folder = build(LINE, *TAGS, "--cycle=1s")
    assert done.returncode == 0 and "Cyclic is called as often as Main" in done.stderr, done.stderr
    assert (folder / "Main.fmu").is_file()
    done, _ = build(LINE, *TAGS, "--call=Main", "--call=Cyclic", "--cycle=1s", "--cycle=2s", "--cycle=3s")
    assert "the numbers of cycles (3) and calls (2) differ: specify one for all calls" in done.stderr, done.stderr
    for option in ("--platform=win64", "--library=win64=a.dll", "--update", "--package=pump"):
        done, folder = build(COUNTER, "--cycle=1s", option)
        assert done.returncode == 1 and f"{option.split('=')[0]} is for crates" in done.stderr, done.stderr
        assert list(folder.glob("*.fmu")) == []
    for words in (["build", "--cycle=1s"], ["check", "--cpu=1200", "x.fmu"], ["run", "--budget=5", "x.fmu"]):
        done = subprocess.run([command, *words], cwd=tmp_path, env=host.environment(), capture_output=True, text=True)
        assert done.returncode == 1 and "is for programs in SCL" in done.stderr, done.stderr


def test_a_program_runs_in_a_loop_without_being_packed_first(command, tmp_path):
    (tmp_path / "pump.scl").write_text(LINE[: LINE.index("DATA_BLOCK")], encoding="utf-8")
    (tmp_path / "pump.db").write_text(LINE[LINE.index("DATA_BLOCK") : LINE.index('DATA_BLOCK "Plant"')], encoding="utf-8")

    def run(*words):
        done = subprocess.run([command, *words], cwd=tmp_path, env=host.environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done

    loop = ["--set", "pump.on=true", "--record", "pump.flow", "--stop=3", "--out=run.csv"]
    run("run", "pump.scl", "pump.db", "--cycle=0.5s", *loop, "--save=loop.toml")
    rows = (tmp_path / "run.csv").read_text(encoding="utf-8")
    assert rows.splitlines()[1:4] == ["0.0,0.0", "0.5,2.0", "1.0,4.0"]
    saved = (tmp_path / "loop.toml").read_text(encoding="utf-8")
    assert 'pump.sources = ["pump.scl", "pump.db"]' in saved and 'pump.cycle = "500ms"' in saved
    run("run", "loop.toml", "--out=again.csv")
    assert (tmp_path / "again.csv").read_text(encoding="utf-8") == rows
    # The same as the FMU that is packed, and as a member that is a source alone.
    run("build", "pump.scl", "pump.db", "--cycle=0.5s")
    run("run", "pump=Pump.fmu", *loop)
    assert (tmp_path / "run.csv").read_text(encoding="utf-8") == rows
    (tmp_path / "plain.toml").write_text('stop = 3.0\nrecord = ["P.flow"]\n[fmus]\nP = "pump.scl"\n[settings]\nP.on = true\n')
    run("run", "plain.toml", "--cycle=0.5s", "--out=run.csv")
    assert (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()[2] == "0.5,1.5", "without the data block the rate is 1.5"


def test_a_new_program_checks_passes_its_test_and_is_packed(command, tmp_path):
    def run(folder, *words):
        done = subprocess.run([command, *words], cwd=folder, env=host.environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    said = run(tmp_path, "new", "--scl", "my_pump")
    folder = tmp_path / "my_pump"
    lines = [line.split("#")[0].split() for line in said.splitlines() if line.startswith("  plcfmu ")]
    assert [line[1] for line in lines] == ["check", "test", "build"]
    for line in lines:
        run(folder, *line[1:])
    assert (folder / "MY_PUMP.fmu").is_file()


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (("test", "pump.toml", "--junit=pump.scl"), "pump.scl is read by this command: write to another file"),
        (("test", "pump.toml", "--coverage=pump.toml"), "pump.toml is read by this command: write to another file"),
        (("test", "pump.toml", "--junit=a", "--coverage=a"), "a is given for two outputs: give each its own file"),
        (("check", "pump.scl", "--assume=pump.scl"), "pump.scl is a source of the program: choose another file for --assume"),
    ],
)
def test_a_program_and_its_test_are_not_overwritten(given, says, command, tmp_path):
    source = 'FUNCTION_BLOCK "Pump"\nVAR_OUTPUT on : Bool; END_VAR\nBEGIN\n#on := "Start";\nEND_FUNCTION_BLOCK\n'
    test = 'cycle = "1s"\ntags = ["Start : Bool"]\n[[case]]\nname = "stops"\nsteps = [{ at = "0s", expect = { on = false } }]\n'
    (tmp_path / "pump.scl").write_text(source, encoding="utf-8")
    (tmp_path / "pump.toml").write_text(test, encoding="utf-8")
    done = subprocess.run([command, *given], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and says in done.stderr, done.stderr
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == {"pump.scl": source, "pump.toml": test}


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no device that is always full")
def test_a_message_that_cannot_be_written_changes_no_exit_code(command, tmp_path):
    with open("/dev/full", "wb") as full:
        assert subprocess.run([command, "check", "missing.fmu"], cwd=tmp_path, stderr=full).returncode == 3


def test_python_builds_a_program_and_raises_what_is_wrong_with_it(command, tmp_path, monkeypatch):
    monkeypatch.setenv("PLCFMU_COMMAND", str(command))
    monkeypatch.setenv("PLCFMU_FMUS", str(host.FOLDER))
    source = tmp_path / "counter.scl"
    source.write_text(COUNTER, encoding="utf-8")
    path = plcfmu.build(source, cycle="0.5s", out=tmp_path, parameter=["enable"])
    description = fmpy.read_model_description(str(path))
    of = {variable.name: variable.causality for variable in description.modelVariables}
    assert path == tmp_path / "Counter.fmu" and of["enable"] == "parameter"
    with pytest.raises(plcfmu.BuildError, match="--cycle 100ms"):
        plcfmu.build([source], cycle=[], out=tmp_path)


CLOCK = """
FUNCTION_BLOCK "Clock"
   VAR_INPUT
      delay : Time;
      from : DTL := DTL#2024-02-29-12:00:00;
   END_VAR
   VAR_OUTPUT
      over : Bool;
      until : DTL;
      longer : Time;   // negative
   END_VAR
   VAR
      t : TON_TIME;
   END_VAR
BEGIN
    #t(IN := TRUE, PT := #delay, Q => #over);
    #until := T_SUB(IN1 := #from, IN2 := #delay);
    #longer := T#0s - #delay * 2;
END_FUNCTION_BLOCK
"""


def test_a_time_is_in_seconds_and_the_members_of_a_dtl_go_in_and_out(build):
    done, folder = build(CLOCK, "--cycle=1s")
    assert done.returncode == 0, done.stderr
    running = Running(folder / "Clock.fmu", [("delay", 12.5), ("from.DAY", 28)])
    running.call(1.0)
    # 2024-02-28 12:00 less 12.5 s.
    assert not running.get("over") and running.get("longer") == -25.0
    until = [running.get(f"until.{part}") for part in ("YEAR", "MONTH", "DAY", "HOUR", "MINUTE", "SECOND", "NANOSECOND")]
    assert until == [2024, 2, 28, 11, 59, 47, 500_000_000]


LABEL = """FUNCTION_BLOCK "Label"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
   VAR_INPUT
      article : String[10] := 'A-100';   // of the order
      note : WString[8];
      prefix { S7_SetPoint := 'True'} : String[4] := 'No ';
   END_VAR
   VAR_OUTPUT text : String[20]; wide : WString[12]; length : Int; END_VAR
   VAR list : Array[1..2] of String[6] := ['one', 'two']; raw : String[3] := 'a$00b'; END_VAR
BEGIN
   #text := CONCAT(IN1 := #prefix, IN2 := #article, IN3 := '/ö');
   #wide := CONCAT(IN1 := #note, IN2 := WSTRING#' €');
   #length := LEN(#text);
   #list[1] := #article;
END_FUNCTION_BLOCK
"""


class Latin1(str):
    """A string that FMPy hands over in the wrong encoding."""

    def encode(self, *_):
        return super().encode("latin-1")


@pytest.mark.parametrize("options", [(), ("--native",)], ids=["interpreted", "native"])
def test_texts_are_strings_that_are_set_within_their_length_kept_in_states_and_refused_by_name(build, options):
    built, folder = build(LABEL, "--cycle", "100ms", *options)
    assert built.returncode == 0, built.stderr
    label = Running(folder / "Label.fmu")
    slave, references = label.slave, {name: of.valueReference for name, of in label.variables.items()}
    shown = {name: (of.type, of.causality, of.start) for name, of in label.variables.items()}
    assert shown["article"] == ("String", "input", "A-100") and shown["text"] == ("String", "output", None)
    assert shown["prefix"] == ("String", "parameter", "No ")
    assert label.variables["article"].description == "of the order; STRING[10]"

    def read(*names):
        return [text.decode() for text in slave.getString([references[name] for name in names])]

    def refused(name, text):
        label.log.take()
        with pytest.raises(FMICallException):
            slave.setString([references["note"], references[name]], ["lost", text])
        return label.log.take()[-1].text

    slave.setString([references["article"], references["note"]], ["B-7ö", "日本😀"])
    slave.doStep(0.0, 0.1)
    assert read("article", "text", "wide", "list[1]", "list[2]") == ["B-7ö", "No B-7ö/ö", "日本😀 €", "B-7ö", "two"]
    assert slave.getInteger([references["length"]]) == [9]
    assert read("raw") == ["a"]
    state = slave.getFMUstate()
    slave.setString([references["prefix"]], [""])
    slave.doStep(0.1, 0.1)
    assert read("text", "prefix") == ["B-7ö/ö", ""]
    slave.setFMUstate(slave.deSerializeFMUstate(slave.serializeFMUstate(state)))
    assert read("text", "prefix") == ["No B-7ö/ö", "No "]

    assert "article = \"12345678901\": STRING[10] holds at most 10 characters, not 11" in refused("article", "12345678901")
    assert "a STRING holds only ISO 8859-1 characters, and '€' is not one of them" in refused("article", "€")
    assert "article: the string is not UTF-8: byte 2 is invalid" in refused("article", Latin1("Größe"))
    assert "text is computed by the block and can only be read" in refused("text", "x")
    # A character beyond 16 bits is two of a WSTRING.
    assert "note = \"😀😀😀😀a\": WSTRING[8] holds at most 8 characters, not 9" in refused("note", "😀😀😀😀a")
    assert "length, of type Integer: use fmi2SetInteger" in refused("length", "x")
    assert read("article", "note") == ["B-7ö", "日本😀"]
    slave.reset()
    label.start()
    assert read("article", "text", "wide", "list[2]") == ["A-100", "", "", "two"]


NAMES = """
FUNCTION_BLOCK "V1.0"
   VAR_INPUT
      "a.b" : Real;
      "Größe [m]" { ExternalVisible := 'False'} : Real;
      Füllstand : Array[-1..0] of Real;
   END_VAR
   VAR_OUTPUT
      y { ExternalAccessible := 'False'} : Real;
   END_VAR
BEGIN
    #y := #"a.b" + 10.0 * #"Größe [m]" + 100.0 * #Füllstand[0];
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("options", [(), ("--native",)])
def test_names_that_are_no_identifiers_are_set_and_read_by_name(build, options):
    done, folder = build(NAMES, "--cycle=100ms", *options)
    assert done.returncode == 0, done.stderr
    fmu = folder / "V1_0.fmu"
    assert fmpy.validation.validate_fmu(str(fmu)) == []
    start = {"'a.b'": 1.0, "'Größe [m]'": 2.0, "Füllstand[0]": 3.0}
    result = fmpy.simulate_fmu(str(fmu), start_values=start, stop_time=0.1)
    assert result["y"][-1] == 1.0 + 20.0 + 300.0


def test_a_program_that_stops_with_its_start_values_is_packed_with_a_note(build, command):
    source = """FUNCTION_BLOCK "Recipe" VAR_INPUT number : Int; END_VAR VAR_OUTPUT y : Real; END_VAR
        VAR recipes : Array[1..5] of Real := [5(2.5)]; END_VAR
        BEGIN
          #y := #recipes[#number];
        END_FUNCTION_BLOCK"""
    done, folder = build(source, "--cycle=100ms")
    assert done.returncode == 0, done.stderr
    note = "with its start values, the program stops: machine.scl:4: index 0 is outside 1..5"
    assert note in done.stderr
    checked = subprocess.run([command, "check", folder / "machine.scl"], capture_output=True, text=True)
    assert checked.returncode == 0 and note in checked.stdout
    with zipfile.ZipFile(folder / "Recipe.fmu") as archive:
        assert not any(name.startswith("extra/") for name in archive.namelist())
        assert "Not recorded: with its start values, the program stops." in archive.read("documentation/index.html").decode()
    result = fmpy.simulate_fmu(str(folder / "Recipe.fmu"), start_values={"number": 2}, stop_time=0.1)
    assert result["y"][-1] == 2.5


def committed():
    """Every source in SCL of the repository, with a name."""
    scl = CASES.parent
    for file in sorted(CASES.glob("*.json")):
        content = json.loads(file.read_text(encoding="utf-8"))
        for number, case in enumerate(content.get("cases", [content])):
            yield f"{file.stem}_{number}", case["scl"].encode()
    for file in sorted([*scl.glob("tia/*.scl"), *scl.glob("data/*.scl"), *pathlib.Path(__file__).parent.glob("programs/*.scl")]):
        yield file.stem, file.read_bytes()


def test_check_and_build_say_the_same_of_every_source(command, tmp_path):
    def both(named):
        name, content = named
        file = tmp_path / f"{name}.scl"
        file.write_bytes(content)
        checked, built = (
            subprocess.run([command, *arguments], env=host.environment(), cwd=tmp_path, capture_output=True, text=True)
            for arguments in (["check", file], ["build", file, "--cycle=100ms"])
        )
        return name, checked, built

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        told = list(pool.map(both, committed()))
    assert len(told) > 250 and {built.returncode for _, _, built in told} == {0, 1}
    for name, checked, built in told:
        choice = built.stderr.removeprefix("error: ").strip()
        if checked.returncode == 0 and built.returncode == 1 and choice.startswith(("several blocks", "the sources contain no block")):
            # A library of blocks is right as it is; which of them is run is a matter of `build`.
            assert f"build: {choice}" in checked.stdout, name
            continue
        assert checked.returncode == built.returncode, (name, checked.stdout + checked.stderr, built.stderr)
        if checked.returncode == 1:
            assert checked.stdout.strip() in built.stderr, name


def test_a_file_that_is_no_source_comes_with_what_to_do(command, tmp_path):
    (tmp_path / "plant").mkdir()
    for name in ("blocks.xml", "motor.st"):
        (tmp_path / name).write_text("x")
    (tmp_path / "tags.csv").write_text("Name,Path,Data Type\n")
    (tmp_path / "a.scl").write_text("FUNCTION_BLOCK a BEGIN ; END_FUNCTION_BLOCK")

    def told(*arguments):
        done = subprocess.run([command, *arguments], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode != 0
        return done.stdout + done.stderr

    no_source = "is neither an FMU nor a program source (.scl, .udt, .db, .s7dcl, .xml, .awl) nor a tag table: "
    for verb in ("check", "build"):
        remedy = {"check": "plant is a folder: specify FMUs", "build": "plant is a folder without program sources (.scl, "}
        assert remedy[verb] in told(verb, "plant")
        assert f"motor.st {no_source}rename an SCL source to .scl" in told(verb, "motor.st")
    assert "motor.st" in (mixed := told("build", "a.scl", "motor.st", "--cycle=1s")) and "rename" in mixed
    wrong = told("check", "a.scl", "--tag", "tags.csv")
    assert "tags.csv:1:1: write a name, a colon and a type, such as Start : Bool" in wrong


def test_show_prints_a_block_in_lad_as_a_source_that_builds(command, tmp_path):
    lad = CASES.parents[2] / "examples/programs/interlock.xml"
    done = subprocess.run([command, "show", str(lad), "--as", "scl"], capture_output=True, text=True, check=True)
    assert "// Network 2: Dry run\n" in done.stdout and "#delay(IN := #run AND NOT #flow, PT := T#3s);" in done.stdout
    (tmp_path / "shown.scl").write_text(done.stdout)
    for file in (lad, tmp_path / "shown.scl"):
        subprocess.run([command, "build", str(file), "--cycle", "100ms", "--out", str(tmp_path)], check=True, capture_output=True)
        description = fmpy.read_model_description(str(tmp_path / "PumpInterlock.fmu"))
        causalities = {variable.name: variable.causality for variable in description.modelVariables}
        for name in ("start", "stop", "reset", "overload", "flow", "raw"):
            assert causalities[name] == "input"
        for name in ("run", "fault", "low", "level", "starts"):
            assert causalities[name] == "output"
    wrong = tmp_path / "wrong.xml"
    wrong.write_text(lad.read_text().replace('"overload" />', '"nothing" />', 1))
    done = subprocess.run([command, "check", str(wrong)], capture_output=True, text=True)
    assert done.returncode == 1
    assert 'FB PumpInterlock, network 3 "Fault": Contact #nothing: #nothing is not declared in this block' in done.stdout
