"""Which commands run code of an FMU of somebody else: those that say so, in a process of their own, and no other. What goes wrong there,
in the FMU or on this machine, is a sentence and an exit code."""

import json
import os
import pathlib
import re
import select
import struct
import subprocess
import sys
import zipfile

import pytest

import host
from test_mutants import packed, unpacked

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the FMU and how its processes are watched are for Linux")

LOOP = """
step = 1.0
stop = 3.0
[fmus]
C = "CONT_C.fmu"
P = "PLANTED.fmu"
[connections]
C.LMN = "P.U"
P.Y = "C.PV_IN"
[settings]
C = { MAN_ON = false, SP_INT = 30.0, GAIN = 2.0, TI = 10.0, CYCLE = 1.0 }
"""
STUDY = """
loop = "loop.toml"
[[axes]]
variable = "C.TI"
values = [10.0, 20.0]
[signals]
process_value = "P.Y"
manipulated_value = "P.U"
"""
TUNED = """
[tune]
minimize = "iae"
evaluations = 10
[[tune.search]]
variable = "C.GAIN"
min = 1.0
max = 2.0
"""

# Each way to hand an FMU to each command, and whether its code runs: as it is, and if it claims to be made by plcfmu.
CALLS = {
    "info": [("info PLANTED.fmu", False, False)],
    "check": [("check PLANTED.fmu", False, False), ("check --run PLANTED.fmu", True, True)],
    "test": [("test PLANTED.fmu", False, False)],
    "run": [("run PLANTED.fmu --step=1 --stop=2", True, True), ("run loop.toml", True, True)],
    "ssp": [("ssp loop.toml --out=loop.ssp", False, False)],
    "study": [("study study.toml", True, True), ("study study.toml --bundle=b.zip", True, True)],
    "tune-study": [("tune-study tuned.toml --out=tuned", True, True)],
    "params": [
        ("params PLANTED.fmu", False, True),
        ("params CONT_C.fmu --fmus=.", False, True),
        ("params CONT_C.fmu --fmus=PLANTED.fmu", False, True),
    ],
    "gains": [("gains --from PLANTED.fmu", False, False)],
    "figures": [("figures PLANTED.fmu", False, False)],
    "completions": [("completions bash", False, False)],
    "manual": [("manual pages", False, False)],
    "new": [("new PLANTED.fmu", False, False)],
    "build": [("build PLANTED.fmu", False, False)],
    "show": [("show PLANTED.fmu", False, False)],
    "merge": [("merge PLANTED.fmu PLANTED.fmu --out=m.fmu", False, False)],
    "preset": [
        ("preset PLANTED.fmu --set=AT=1 --out=p.fmu", False, True),
        ("preset CONT_C.fmu --set=GAIN=3 --fmus=. --out=p.fmu", False, True),
    ],
    "prove": [("prove PLANTED.fmu --out=p.scl", False, False)],
    # It serves until it is interrupted; what is run there is the next test.
    "tool": [("tool", False, False), ("tool --fmus=.", False, True), ("tool PLANTED.fmu", False, True)],
    # It answers a client, which test_mcp.py is: its tool `run` is the command.
    "mcp": [("mcp", False, False)],
    "help": [("help params", False, False)],
}
EACH = [(call, *runs) for calls in CALLS.values() for call, *runs in calls]


@pytest.fixture(scope="module")
def planted(pack_foreign, tmp_path_factory):
    """The FMU as it is, and one that claims to be made by plcfmu."""
    made = {}
    for is_claimed, options in [(False, []), (True, ["-DTABLE"])]:
        made[is_claimed] = pack_foreign("planted", tmp_path_factory.mktemp("planted"), *options)
    return made


@pytest.fixture
def lay(planted, tmp_path):
    """A folder with the FMU and all that commands take it in."""

    def lay(is_claimed=False):
        folder = tmp_path / f"claimed_{is_claimed}"
        (folder / "target/fmu").mkdir(parents=True)
        (folder / "tmp").mkdir()
        for name, source in [("PLANTED.fmu", planted[is_claimed]), ("CONT_C.fmu", host.FOLDER / "CONT_C.fmu")]:
            for place in [folder, folder / "target/fmu"]:
                (place / name).write_bytes(source.read_bytes())
        for name, text in [("loop.toml", LOOP), ("study.toml", STUDY), ("tuned.toml", STUDY + TUNED)]:
            (folder / name).write_text(text)
        return folder

    return lay


def environment(folder, plant=""):
    own = {"PLCFMU_MARK": str(folder / "mark"), "PLCFMU_PLANT": plant, "TMPDIR": str(folder / "tmp")}
    return {**{name: value for name, value in os.environ.items() if name != "PLCFMU_FMUS"}, **own}


def called(command, folder, call, plant=""):
    """The return code, output and errors of a call. The tool is ended as soon as it serves."""
    given = [command, *call.split()]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(given, cwd=folder, env=environment(folder, plant), **pipes)
    if call.startswith("tool"):
        process.stdout.readline()
        process.terminate()
    output, errors = process.communicate(timeout=120)
    return process.returncode, output, errors


def test_each_command_is_tried(command):
    """A new one is in this list before it is released."""
    text = subprocess.run([command, "--help"], capture_output=True, text=True, check=True).stdout
    listed = text.split("Commands:\n")[1].split("\n\n")[0]
    hidden = {"figures"}
    assert set(re.findall(r"^  ([a-z-]+) ", listed, re.MULTILINE)) | hidden == set(CALLS)


def test_those_commands_are_named_that_run_code(command):
    """By SECURITY.md and --help, and no other."""
    runs = {name for name, calls in CALLS.items() if any(any(runs) for _, *runs in calls)} | {"mcp"}
    text = (pathlib.Path(__file__).parents[1] / "SECURITY.md").read_text()
    paragraph = text.split("## What is not a fault\n")[1].split("No other command runs an FMU's code.")[0]
    assert set(re.findall(r"`plcfmu ([a-z-]+)", paragraph)) == runs
    text = subprocess.run([command, "--help"], capture_output=True, text=True, check=True).stdout
    words = set(re.findall(r"[a-z-]+", text[text.index("Native FMU code runs"):]))
    assert words & set(CALLS) == runs


@pytest.mark.parametrize(("call", "runs", "runs_claimed"), EACH, ids=[call for call, *_ in EACH])
def test_code_runs_only_where_it_is_said(command, lay, call, runs, runs_claimed):
    for is_claimed, expected in [(False, runs), (True, runs_claimed)]:
        folder = lay(is_claimed)
        called(command, folder, call)
        assert (folder / "mark").exists() == expected, (is_claimed, expected)


LOADED = [(call, at == 1) for call, *runs in EACH for at in range(2) if runs[at] and not call.startswith("tool")]


@pytest.mark.parametrize(("call", "is_claimed"), LOADED)
def test_a_library_that_crashes_while_it_is_loaded_costs_a_process_of_its_own(command, lay, call, is_claimed):
    folder = lay(is_claimed)
    code, output, errors = called(command, folder, call, "crash")
    assert code in (1, 3), (code, output, errors)
    assert "crashed: signal 6 (abort)" in output + errors
    assert list((folder / "tmp").iterdir()) == []


@pytest.mark.parametrize("call", ["run loop.toml --time-limit=1", "study study.toml --time-limit=1 --jobs=1"])
def test_the_time_limit_holds_while_a_library_is_loaded(command, lay, call):
    code, _, errors = called(command, lay(), call, "hang")
    assert code == 1
    assert re.search(r"P\b.* did not return within 1 s", errors), errors


def ends(process):
    """Waits for the end of a process that is told to end, whoever has started it."""
    try:
        watched = os.pidfd_open(process)
    except ProcessLookupError:
        return True
    is_over = bool(select.select([watched], [], [], 60)[0])
    os.close(watched)
    return is_over


@pytest.mark.parametrize("call", ["run loop.toml", "study study.toml --jobs=1", "check --run PLANTED.fmu"])
def test_a_process_that_an_fmu_has_started_ends_with_the_command(command, lay, call):
    folder = lay()
    code, output, errors = called(command, folder, call, "fork")
    assert code == 0, output + errors
    started = [int(line) for line in (folder / "mark").read_text().split()]
    assert started and all(map(ends, started))


@pytest.mark.parametrize("call", ["run loop.toml", "study study.toml --jobs=1", "check --run PLANTED.fmu"])
def test_a_process_that_holds_the_output_of_one_that_has_ended_is_not_waited_for(command, lay, call):
    folder = lay()
    code, output, errors = called(command, folder, f"{call} --time-limit=60", "orphan")
    assert code == 1
    assert "ended its process with exit code 3" in output + errors
    assert all(map(ends, map(int, (folder / "mark").read_text().split())))


def test_a_function_that_a_library_lacks_is_named_once(command, pack_foreign, tmp_path):
    pack_foreign("planted", tmp_path, "-DTABLE", "-Dfmi2GetTypesPlatform=fmi2Other")
    (tmp_path / "tmp").mkdir()
    code, _, errors = called(command, tmp_path, "params PLANTED.fmu")
    assert (code, errors) == (3, "error: PLANTED.fmu: its library lacks fmi2GetTypesPlatform\n")


@pytest.mark.parametrize("name", ["check", "info"])
def test_a_folder_in_place_of_an_fmu_is_told_with_the_remedy(command, tmp_path, name):
    (tmp_path / "fmus").mkdir()
    given = {"cwd": tmp_path, "capture_output": True, "text": True}
    done = subprocess.run([command, name, "fmus"], **given)
    assert (done.returncode, done.stdout, done.stderr) == (3, "", "error: fmus is a folder: specify FMUs, such as fmus/*.fmu\n")


# A machine that cannot do it


# Without room at all, with room for the smallest file alone, and with room where no program runs.
PLACES = {
    "no room": ("size=64k", "fill", "free up space there, or set TMPDIR to another folder"),
    "hardly room": ("size=16k", "", "free up space there, or set TMPDIR to another folder"),
    "noexec": ("noexec", "", "(it is mounted noexec): set TMPDIR to another folder"),
}


def on_a_place(command, folder, place, call):
    """Calls the command with a temporary folder of its own kind, which is gone with the process. What is left in it comes last."""
    options, fill, _ = PLACES[place]
    mount = f"mount -t tmpfs -o {options} none {folder}/tmp"
    script = f"{mount} || exit 99; {f'head -c 99999 /dev/zero > {folder}/tmp/full;' if fill else ''} "
    script += f"{command} {call}; code=$?; rm -f {folder}/tmp/full; ls -A {folder}/tmp; exit $code"
    given = {"cwd": folder, "env": environment(folder), "capture_output": True, "text": True}
    try:
        done = subprocess.run(["unshare", "--mount", "--user", "--map-root-user", "sh", "-c", script], **given)
    except FileNotFoundError:
        pytest.skip("no unshare: on Debian and Ubuntu 'apt install util-linux'")
    if done.returncode == 99 or "unshare failed" in done.stderr or "unshare:" in done.stderr:
        pytest.skip("this user may mount nothing, not even in a namespace")
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("place", PLACES)
def test_a_temporary_folder_that_cannot_be_used_is_a_fault_of_the_machine(command, lay, place):
    folder = lay()
    code, output, errors = on_a_place(command, folder, place, "run PLANTED.fmu --step=1 --stop=2 --out=o.csv")
    assert (code, output) == (3, ""), errors
    assert PLACES[place][2] in errors and f"the folder for temporary files {folder}/tmp" in errors, errors
    assert not (folder / "o.csv").exists()


@pytest.mark.parametrize("place", PLACES)
def test_an_fmu_that_cannot_be_tried_here_is_not_called_wrong(command, lay, place):
    folder = lay()
    code, output, errors = on_a_place(command, folder, place, "check --run PLANTED.fmu")
    assert code == 3, output + errors
    assert "WRONG" not in output and "\n  ok" not in output
    assert re.search(rf"\n  could not be tried: .*{re.escape(PLACES[place][2])}", output), output
    assert errors.endswith("error: 1 of 1 FMUs could not be tried on this machine\n")
    assert on_a_place(command, folder, place, "check PLANTED.fmu")[0] == 0
    _, output, _ = on_a_place(command, folder, place, "check --run PLANTED.fmu --json")
    (verdict,) = json.loads(output)
    assert (verdict["errors"], verdict["run"]) == ([], None) and PLACES[place][2] in verdict["untried"]


# What is packed


def with_identifier(planted, path, identifier):
    """The FMU with this modelIdentifier and a source in place of its library, which could not have this name."""
    files = unpacked(planted[False])
    xml = files["modelDescription.xml"].replace(b'modelIdentifier="planted"', f'modelIdentifier="{identifier}"'.encode())
    return packed({"modelDescription.xml": xml, "sources/planted.c": b"int planted;"}, path)


@pytest.mark.parametrize(
    "identifier",
    ["../../tmp/evil", "/tmp/evil", "a/b", "a\\b", "..", ".", "$(id)", "a;id", "a b", "1a", "a-b", "a\u202eb"],
)
def test_ssp_packs_nothing_that_check_calls_wrong(command, planted, tmp_path, identifier):
    with_identifier(planted, tmp_path / "evil.fmu", identifier)
    code, output, _ = called(command, tmp_path, "check evil.fmu")
    assert code == 1 and "is not a C identifier" in output
    code, output, errors = called(command, tmp_path, "ssp evil.fmu --step=1 --stop=2 --out=evil.ssp")
    assert code == 1 and "evil.fmu: the FMU is faulty: modelDescription.xml: modelIdentifier = " in errors, errors
    assert not (tmp_path / "evil.ssp").exists()


def lying(source, path):
    """The FMU with a packed file of 4 bytes whose headers both say that it has 5."""
    packed(unpacked(source), path)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("resources/text.txt", "text")
    data = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        entry = archive.getinfo("resources/text.txt")
    table = data.rindex(b"resources/text.txt") - 46
    assert data[table : table + 4] == b"PK\x01\x02"
    for place in [entry.header_offset + 22, table + 24]:
        data[place : place + 4] = struct.pack("<I", 5)
    path.write_bytes(data)


def test_check_and_run_agree_on_a_file_that_is_not_as_long_as_it_says(command, planted, tmp_path):
    (tmp_path / "tmp").mkdir()
    lying(planted[False], tmp_path / "lying.fmu")
    code, output, _ = called(command, tmp_path, "check lying.fmu")
    assert code == 1 and "WRONG: resources/text.txt is damaged" in output, output
    code, _, errors = called(command, tmp_path, "run lying.fmu --step=1 --stop=2")
    assert code == 1 and "resources/text.txt is damaged" in errors, errors


def test_the_name_of_an_fmu_gives_no_orders_to_a_terminal(command, planted, tmp_path):
    name = "a\u202eb\u200fc\u009bd.fmu"
    (tmp_path / name).write_bytes(planted[False].read_bytes())
    for call in ["check", "info"]:
        output = subprocess.run([command, call, name], cwd=tmp_path, capture_output=True, text=True).stdout
        assert output.startswith("a\\u{202e}b\\u{200f}c\\u{9b}d.fmu\n"), output
