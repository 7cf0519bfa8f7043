"""The engine of the parameter tool in its homes: the WebAssembly of the page, the FMUs behind `plcfmu tool`, and `plcfmu run` of
what the engine writes. All compute the same bits, and both engines answer in the same words.

A session is a file of `sessions`: requests, one after the other. The WebAssembly runs under Node here; the tests of the page run it
in a browser."""

import base64
import json
import pathlib
import re
import shutil
import subprocess

import pytest

import host
import tool
from files import rows

ROOT = pathlib.Path(__file__).parents[1]
NODE = shutil.which("node")
SESSIONS = sorted(path.stem for path in (ROOT / "tests/sessions").glob("*.json"))

# Nothing that one description can say: members are exchanged, nothing runs.
NO_DESCRIPTION = ("descriptions", "exchange", "refusals")

LARGEST = 1_600_000

pytestmark = [
    pytest.mark.skipif(NODE is None, reason="no node: on Debian and Ubuntu 'apt install nodejs'"),
    tool.needs_page,
    host.in_fmpy,
]


def requests(session):
    return json.loads((ROOT / f"tests/sessions/{session}.json").read_text())


def in_the_page(page, asked):
    """The answers of the page's WebAssembly, as texts."""
    lines = "".join(json.dumps(request) + "\n" for request in asked)
    node = [NODE, ROOT / "tests/engine.mjs", page]
    done = subprocess.run(node, input=lines, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    answers = done.stdout.splitlines()
    assert len(answers) == len(asked)
    return answers


@pytest.fixture(scope="session")
def page():
    return tool.PAGE


@pytest.fixture(scope="module")
def server(command, tmp_path_factory):
    """Asks the engine behind `plcfmu tool`, each session in a tab of its own."""
    with tool.Server(command, tmp_path_factory.mktemp("server"), "--fmus", host.FOLDER) as server:
        yield server


@pytest.mark.parametrize("session", SESSIONS)
def test_the_page_and_the_server_give_the_same_answers(session, page, server):
    asked = requests(session)
    in_page = in_the_page(page, asked)
    for request, answer in zip(asked, in_page):
        # As texts: a number is written with all its digits.
        assert comparable(server.ask(request, tab=session)) == comparable(answer), request


def comparable(answer):
    """An answer without what differs between the homes: the order of the FMUs, and the one that is an example only."""
    read = json.loads(answer)
    if "fmus" not in read.get("ok", []):
        return answer
    fmus = [entry for entry in read["ok"]["fmus"] if entry["name"] != "TWO_POINT"]
    return {**read["ok"], "fmus": sorted(fmus, key=lambda entry: entry["name"])}


@pytest.mark.parametrize("session", [name for name in SESSIONS if name not in NO_DESCRIPTION])
def test_a_run_has_the_bits_of_plcfmu_run_of_its_description(session, page, command, tmp_path):
    asked = requests(session)
    state = json.loads(in_the_page(page, asked)[-1])["ok"]
    if "values" not in state:
        asked.append({"do": "state"})
        state = json.loads(in_the_page(page, asked)[-1])["ok"]
    variables = sorted(state["values"])
    view = {"do": "view", "variables": variables, "points": max(2, state["calls"])}
    description = {"do": "export", "what": "description", "run": None}
    *_, curves, exported = map(json.loads, in_the_page(page, [*asked, view, description]))
    curves, exported = curves["ok"], exported["ok"]
    assert curves["is_exact"] and len(curves["times"]) == state["calls"] > 100
    file = tmp_path / exported["file"]
    file.write_bytes(base64.b64decode(exported["content"]))
    # The sources of a program belong beside its description.
    for source in (of for request in asked if request["do"] == "compile" for of in request["files"]):
        (tmp_path / source["file"]).write_bytes(base64.b64decode(source["content"]))
    given = [command, "run", file, "--fmus", host.FOLDER, "--out", "-", *(f"--record={name}" for name in variables)]
    done = subprocess.run(given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    # The last row is that of the end, at which there is no call.
    *recorded, _ = rows(done.stdout)
    assert [float(row["time"]).hex() for row in recorded] == [float(time).hex() for time in curves["times"]]
    for name, values in zip(variables, curves["values"]):
        assert [float(row[name]).hex() for row in recorded] == [float(value).hex() for value in values], name


def test_the_page_has_every_fmu_of_a_block_and_of_a_plant(page):
    (catalogue,) = in_the_page(page, [{"do": "catalogue"}])
    fmus = {entry["name"]: entry["part"] for entry in json.loads(catalogue)["ok"]["fmus"]}
    # TWO_POINT shows how one's own block is made.
    assert set(fmus) == set(host.names()) - {"TWO_POINT"}
    assert {name for name, part in fmus.items() if part == "controller"} == {*host.CONTROLLERS}


def test_the_page_knows_the_loops_of_the_plants(page):
    (catalogue,) = in_the_page(page, [{"do": "catalogue"}])
    loops = json.loads(catalogue)["ok"]["loops"]
    assert len(loops) == len(list((ROOT / "plants/loops").glob("*.toml")))
    for known in loops:
        started, ran = in_the_page(page, [{"do": "start", **known["setup"]}, {"do": "run", "calls": 100}])
        assert json.loads(ran)["ok"]["calls"] == 100, started


def test_a_request_of_any_bytes_gets_an_answer(page):
    for request in ["", "x", "{", "null", '{"do":1}', "\U0001f4a3 " * 1000, '{"do":"run","calls":-1}', "[" * 100_000]:
        node = [NODE, ROOT / "tests/engine.mjs", page]
        done = subprocess.run(node, input=request + "\n", capture_output=True, encoding="utf-8")
        assert done.returncode == 0, done.stderr
        assert list(json.loads(done.stdout)) == ["error"], request[:20]


def test_the_page_is_one_small_file_that_loads_nothing(page):
    text = page.read_text(encoding="utf-8")
    assert len(text.encode()) <= LARGEST
    # What a browser would fetch. The namespaces of SVG and MathML are names only.
    markup = re.sub(r"<script.*?</script>|<style.*?</style>", "", text, flags=re.DOTALL)
    assert re.findall(r"""(?:src|href|action|poster|data)\s*=\s*["']?(?!#|data:)[^"'>\s]+""", markup) == []
    assert re.findall(r"@import|url\((?!['\"]?data:)", "".join(re.findall(r"<style>(.*?)</style>", text, re.DOTALL))) == []
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    directives = {name: sources for name, *sources in (part.split() for part in policy.split(";"))}
    assert directives["default-src"] == ["'none'"] and directives["connect-src"] == ["'none'"]
    assert all(source == "blob:" or source.startswith("'") for source in directives["script-src"])
    assert "'unsafe-inline'" not in directives["script-src"] and "'unsafe-eval'" not in directives["script-src"]


def test_the_engine_imports_nothing(page):
    node = [NODE, ROOT / "tests/engine.mjs", page, "--terminals"]
    done = subprocess.run(node, capture_output=True, text=True, check=True)
    imports, exports = json.loads(done.stdout)
    assert imports == []
    names = {export["name"] for export in exports if export["kind"] in ("function", "memory")}
    assert names == {"memory", "room", "message", "answer"}


@pytest.mark.parametrize(
    ("plant", "values", "to"),
    [
        ("HEATER", {}, 60.0),
        ("THERMO", {}, 60.0),
        # One lag and a dead time; two lags.
        ("PROCESS", {}, 60.0),
        ("PROCESS", {"T1": 10.0, "T2": 8.0, "DEAD_TM": 1.0}, 60.0),
        ("PROCESS", {"GAIN": 2.0, "T1": 30.0, "T2": 30.0, "DEAD_TM": 5.0}, 60.0),
    ],
)
def test_what_is_offered_first_after_a_step_test_overshoots_by_less_than_5_percent(page, plant, values, to):
    controller, of = [{"name": name, "fmu": fmu, "values": {}} for name, fmu in (("C", "CONT_C"), ("P", plant))]
    (proposed,) = in_the_page(page, [{"do": "propose", "controller": controller, "plant": of}])
    proposed = json.loads(proposed)["ok"]
    for name, value in proposed["values"].items():
        member, variable = name.split(".")
        (controller if member == "C" else of)["values"][variable] = value
    of["values"] |= values
    setup = {
        "connections": [[wire["from"], wire["to"]] for wire in proposed["connections"]],
        "step": proposed["step"],
        "exchange": proposed["exchange"],
    }
    test = {"do": "step_test", "size": 10.0, "method": "least_squares", "is_integrating": False}
    *_, tested = in_the_page(page, [{"do": "start", "members": [controller, of], **setup}, test])
    tuning = {"model": json.loads(tested)["ok"]["identified"]["model"], "rule": "simc", "structure": "pi"}
    (table,) = in_the_page(page, [{"do": "rules", "controller": controller, **tuning}])
    simc = next(row for row in json.loads(table)["ok"]["rows"] if row["rule"] == "simc")["tuned"]
    # From cold, in automatic mode from the first call on.
    settings = {**controller["values"], **simc["values"], "MAN_ON": False, "SP_INT": to}
    members = [{**controller, "values": settings}, of]
    run = [{"do": "start", "members": members, **setup}, {"do": "settle", "calls": 20_000, "from": 0.0}]
    *_, settled, figures = in_the_page(page, [*run, {"do": "figures"}])
    settled = json.loads(settled)["ok"]
    assert settled["is_at_rest"] and not settled["swings"] and settled["state"]["values"]["C.PV"] == pytest.approx(to, abs=0.1)
    overshoot = next(one["value"] for one in json.loads(figures)["ok"]["figures"] if one["key"] == "overshoot")
    assert 0 <= overshoot < 3.5
