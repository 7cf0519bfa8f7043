"""`plcfmu mcp`: an agent checks, builds, tests and runs a program over the Model Context Protocol, as the commands do, and sees no file
outside of its folder."""

import json
import pathlib
import shutil
import subprocess

import host
import pytest

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples/programs"

MOTOR = """FUNCTION_BLOCK "Motor"
VAR_INPUT start : BOOL; stop : BOOL; END_VAR
VAR_OUTPUT running : BOOL; END_VAR
BEGIN
#running := (#start OR #running) AND NOT #stop;
END_FUNCTION_BLOCK
"""
CASES = """sources = ["motor.scl"]
cycle = "100ms"

[[case]]
name = "it starts"
steps = [{ at = "0s", set = { start = true }, expect = { running = true } }]

[[case]]
name = "it stops by itself"
steps = [
  { at = "0s", set = { start = true } },
  { at = "1s", set = { start = false }, expect = { running = false } },
]
"""
SECRET = 'FUNCTION_BLOCK "Secret"\nVAR x : WRONG_TYPE; END_VAR\nBEGIN\nEND_FUNCTION_BLOCK\n'
# A run that would take days.
ENDLESS = {"files": ["motor.scl"], "cycle": "100ms", "step": 0.1, "stop": 1e9}


class Client:
    """Speaks the protocol line by line. Whatever is on standard output is a line of it."""

    def __init__(self, command, folder, *options):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        given = [command, "mcp", *options]
        self.process = subprocess.Popen(given, cwd=folder, env=host.environment(), text=True, **pipes)
        self.number = 0
        named = {"clientInfo": {"name": "test", "version": "1"}, "capabilities": {}}
        self.greeting = self.request("initialize", protocolVersion="2025-06-18", **named)["result"]
        self.send(method="notifications/initialized")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        assert self.process.wait() == 0 and self.process.stdout.read() == ""

    def send(self, **message):
        self.process.stdin.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
        self.process.stdin.flush()

    def request(self, method, **params):
        """The answer to a request: its result, or its error."""
        self.number += 1
        self.send(id=self.number, method=method, params=params)
        answer = json.loads(self.process.stdout.readline())
        assert answer["id"] == self.number
        return answer

    def call(self, name, **arguments):
        """The texts that a tool answers, and whether that is an error."""
        result = self.request("tools/call", name=name, arguments=arguments)["result"]
        return [part["text"] for part in result["content"]], result["isError"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of a client, with a file beside it that it must not see."""
    outside = tmp_path_factory.mktemp("outside")
    folder = outside / "project"
    (folder / "sub").mkdir(parents=True)
    (folder / "motor.scl").write_text(MOTOR)
    (folder / "motor.toml").write_text(CASES)
    (folder / "a.csv").touch()
    (folder / "lamp.scl").write_text(MOTOR.replace("NOT #stop", 'NOT "Halt"'))
    (outside / "secret.scl").write_text(SECRET)
    (folder / "link.scl").symlink_to(outside / "secret.scl")
    (folder / "up").symlink_to(outside)
    (folder / "nowhere").symlink_to(outside / "new")
    (folder / "sd").mkdir()
    shutil.copy(EXAMPLES / "interlock.s7dcl", folder / "sd")
    (folder / "sd/interlock.s7res").symlink_to(outside / "secret.scl")
    for number, source in enumerate(["../secret.scl", "link.scl", str(outside / "secret.scl")]):
        (folder / f"sub/{number}.toml").write_text(f'sources = ["../{source}"]\ncycle = "1s"\n[[case]]\nname = "a"\nsteps = [{{ at = "0s" }}]\n')
        (folder / f"{number}_loop.toml").write_text(f'[fmus.B]\nsources = ["{source}"]\ncycle = "1s"\n')
        (folder / f"{number}.txt").write_text(f'sources = ["{source}"]\ncycle = "1s"\n')
    return folder


@pytest.fixture(scope="module")
def client(command, folder):
    with Client(command, folder) as client:
        yield client


def test_the_tools_say_what_they_take(client):
    assert client.greeting["serverInfo"]["name"] == "plcfmu"
    tools = {tool["name"]: tool["inputSchema"] for tool in client.request("tools/list")["result"]["tools"]}
    assert sorted(tools) == ["build", "check", "run", "show", "test"]
    assert tools["build"]["required"] == ["files", "cycle"]
    settings = tools["run"]["properties"]
    assert settings["set"]["description"].startswith("FMU.VARIABLE=VALUE[@TIME]: Set an input")
    kinds = {name: settings[name]["type"] for name in ("files", "out", "stop", "parallel")}
    assert kinds == {"files": "array", "out": "string", "stop": "number", "parallel": "boolean"}
    # What compiles, loads libraries of its own accord or looks elsewhere is not offered.
    assert not {"native", "library", "platform", "run", "fmus", "json", "time-limit"} & {name for of in tools.values() for name in of["properties"]}


STIMULI = ["motor.start=true", "motor.start=false@0.5", "motor.stop=true@0.8"]


@pytest.mark.parametrize(
    ("tool", "arguments", "line"),
    [
        ("check", {"files": ["motor.scl"]}, "check motor.scl --json"),
        ("check", {"files": ["lamp.scl"]}, "check lamp.scl --json"),
        ("check", {"files": "lamp.scl", "tag": ["Halt : Bool"]}, "check lamp.scl --tag=Halt:Bool --json"),
        ("show", {"files": ["motor.scl"]}, "show motor.scl"),
        ("build", {"files": ["motor.scl"], "cycle": ["100ms"], "out": "made"}, "build motor.scl --cycle=100ms --out=made"),
        ("check", {"files": ["made/Motor.fmu"]}, "check made/Motor.fmu --json"),
        ("test", {"file": "motor.toml"}, "test motor.toml --json"),
        (
            "run",
            {"files": ["motor.scl"], "cycle": "100ms", "set": STIMULI, "step": 0.1, "stop": 1, "out": "a.csv", "record": None},
            f"run motor.scl --cycle=100ms {' '.join(f'--set={one}' for one in STIMULI)} --step=0.1 --stop=1 --out=a.csv --json",
        ),
    ],
)
def test_a_tool_answers_what_its_command_prints(client, command, folder, tool, arguments, line):
    done = subprocess.run([command, *line.split()], cwd=folder, env=host.environment(), capture_output=True, text=True)
    assert done.stdout
    assert client.call(tool, **arguments) == ([text for text in (done.stdout, done.stderr) if text], False)


def test_what_is_said_of_a_program_is_data(client, folder):
    def told(tool, **arguments):
        return json.loads(client.call(tool, **arguments)[0][0])

    assert told("check", files=["motor.scl"]) == {"block": "Motor", "errors": [], "warnings": [], "remark": None}
    (error,) = told("check", files=["lamp.scl"])["errors"]
    assert (error["file"], error["line"], error["message"]) == ("lamp.scl", 5, 'no source declares the tag "Halt" : BOOL')
    assert error["help"].startswith('--tag "Halt : BOOL"')
    assert told("check", files=["lamp.scl"], assume="assumed.scl")["errors"] == []
    assert '"Halt"' in (folder / "assumed.scl").read_text()
    (tested,) = told("test", file="motor.toml")
    assert [case["problem"] is None for case in tested["cases"]] == [True, False]
    assert (tested["lines"], tested["lines_run"]) == (1, 1)
    ran = told("run", files=["motor.scl"], cycle="100ms", set=STIMULI, step=0.1, stop=1, out="a.csv")
    # The row of 0.1 s is the first with what the call at 0 s gave; the motor runs on without the start button, until the stop.
    header, *rows = (folder / "a.csv").read_text().splitlines()
    column = header.split(",").index("motor.running")
    assert [row.split(",")[column] for row in rows] == ["0"] + ["1"] * 8 + ["0"] * 2
    assert ran["last"]["motor.running"] is False and ran["written"] == ["a.csv"]


OUTSIDE = ["../secret.scl", "/etc/hostname", "link.scl", "up", "up/secret.scl", "sub/../../secret.scl", "x=../secret.scl"]
PROGRAM = {"files": ["motor.scl"], "cycle": ["1s"]}


@pytest.mark.parametrize(
    ("tool", "arguments"),
    [
        *[(tool, {"files": ["motor.scl", path]}) for path in OUTSIDE for tool in ("check", "run")],
        ("show", {"files": ["link.scl"]}),
        *[("build", {**PROGRAM, "out": path}) for path in ("..", "nowhere", "up/new", "/tmp", "new/../../out")],
        ("run", {**PROGRAM, "out": "up/a.csv"}),
        ("check", {"files": ["motor.scl"], "assume": "../a.scl"}),
        ("check", {"files": ["motor.scl"], "tag": ["up/secret.scl"]}),
        ("test", {"file": "../motor.toml"}),
        *[("test", {"file": file}) for file in ("0.txt", "1.txt", "2.txt", "sub/0.toml", "sub")],
        *[("run", {"files": [file]}) for file in ("0_loop.toml", "1_loop.toml", "B=2_loop.toml")],
        ("check", {"files": ["s7://127.0.0.1/0/1/DB1"]}),
    ],
)
def test_no_path_leads_out_of_the_folder(client, folder, tool, arguments):
    before = sorted(path.name for path in folder.parent.iterdir())
    (told,), is_error = client.call(tool, **arguments)
    assert is_error and ("is outside " in told or "is the address of a PLC" in told), told
    assert sorted(path.name for path in folder.parent.iterdir()) == before


def test_no_file_beside_another_leads_out_of_the_folder(client):
    """The texts of a document would be read with it; here they are a link."""
    assert json.loads(client.call("check", files=["sd"])[0][0])["errors"] == []


@pytest.mark.parametrize(
    ("tool", "arguments", "expected"),
    [
        ("check", {"file": "motor.scl"}, 'check has no argument "file"; available: files, cycle, '),
        ("check", {}, "check needs files"),
        ("check", {"files": [{}]}, "files: [{}]: expected a value or a list of values"),
        # No option is smuggled in, and no crate built.
        ("check", {"files": ["--run"]}, '"file": "--run"'),
        ("build", {"files": ["motor.scl"]}, "build needs cycle"),
        ("build", {"files": ["motor"], "cycle": "1s"}, "--cycle is for programs in SCL: specify the program's sources"),
        ("build", {"files": ["motor.scl"], "cycle": "soon"}, "invalid value 'soon' for '--cycle <TIME>'"),
        ("run", {**PROGRAM, "parallel": "yes"}, 'parallel: expected true or false, found "yes"'),
        ("show", {"files": ["lamp.scl"]}, "lamp.scl:5:"),
        ("run", {"files": ["-"]}, "stdin"),
    ],
)
def test_a_wrong_request_is_an_error_that_says_why(client, tool, arguments, expected):
    texts, is_error = client.call(tool, **arguments)
    assert expected in "".join(texts) and (is_error or tool == "check"), texts


def test_what_is_no_tool_or_no_method_is_refused(client):
    error = client.request("tools/call", name="delete", arguments={})["error"]
    assert error["message"] == 'no tool "delete"; available: check, show, build, test, run'
    assert "error" in client.request("no/such/method")


def test_a_run_ends_when_it_is_cancelled_or_takes_too_long(client, command, folder):
    client.number += 1
    client.send(id=client.number, method="tools/call", params={"name": "run", "arguments": ENDLESS})
    client.send(method="notifications/cancelled", params={"requestId": client.number})
    assert client.call("show", files=["motor.scl"])[1] is False
    with Client(command, folder, "--time-limit=0.5") as impatient:
        told = ["run was stopped after 0.5 s; 'plcfmu mcp --time-limit SECONDS' allows more"]
        assert impatient.call("run", **ENDLESS) == (told, True)
