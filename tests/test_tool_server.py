"""`plcfmu tool` as a page sees it: who is answered and who is not, an engine for each tab, the bits of `plcfmu run`, and
foreign FMUs that crash, hang or refuse without harm to the rest."""

import base64
import contextlib
import csv
import gzip
import http.client
import io
import json
import os
import pathlib
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import urllib.parse
import zipfile

import fmpy
import psutil
import pytest

import host

ROOT = pathlib.Path(__file__).parents[1]
JSON = "application/json"
BYTES = "application/octet-stream"
MIB = 1 << 20

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs signals and cc")

CONTROLLER = {"PVPER_ON": True, "PV_FAC": 4.0, "GAIN": 1.6, "TI": 135.0, "MAN": 50.0, "CYCLE": 1.0, "SP_INT": 170.0}
FURNACE = {
    "members": [
        {"name": "C", "fmu": "CONT_C", "values": CONTROLLER},
        {"name": "P", "fmu": "HEATER", "values": {"T_START": 170.0}},
    ],
    "connections": [["C.LMN", "P.POWER"], ["P.T_PER", "C.PV_PER"]],
}


class Tool:
    """A server, and what a page asks it."""

    def __init__(self, command, folder, *arguments, environment=None):
        self.temporary = folder / "tmp"
        self.temporary.mkdir(exist_ok=True)
        given = {**os.environ, "TMPDIR": str(self.temporary), "PLCFMU_FMUS": str(host.FOLDER), **(environment or {})}
        self.process = subprocess.Popen(
            [command, "tool", "--no-browser", *map(str, arguments)],
            cwd=folder,
            env=given,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.errors = queue.Queue()
        threading.Thread(target=self.listen, daemon=True).start()
        # It is printed when the server answers.
        self.url = self.process.stdout.readline().strip()
        if self.url:
            self.host, way = self.url.removeprefix("http://").split("/", 1)
            self.path = way.split("open?")[0]
        self.cookie = None

    def enter(self):
        """Opens the printed address as a browser does, and gives the answer."""
        answer, content = self.request("GET", "/" + self.url.split("/", 3)[3])
        self.cookie = answer.headers.get("Set-Cookie", "").split(";")[0]
        return answer, content

    def listen(self):
        for line in self.process.stderr:
            self.errors.put(line)
        self.errors.put(None)

    def request(self, method, path, body=None, **headers):
        """The answer to a request as it stands, with the cookie if there is one, and its body."""
        if self.cookie:
            headers.setdefault("Cookie", self.cookie)
        connection = http.client.HTTPConnection(self.host)
        connection.request(method, path, body, {name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer, content

    def presence(self, **headers):
        """The answer to the request for a WebSocket of a tab."""
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13", "Sec_WebSocket_Key": "eA=="}
        return self.request("GET", f"/{self.path}presence?tab=tab-1", **upgrade, **headers)

    def post(self, what, body, kind=JSON, tab="tab-1"):
        return self.request("POST", f"/{self.path}{what}", body, Content_Type=kind, X_Page=tab)

    def answer(self, what, body, kind=JSON, tab="tab-1"):
        answer, content = self.post(what, body, kind, tab)
        assert answer.status == 200, content
        return json.loads(content)

    def ask(self, tab="tab-1", **request):
        """What the engine answers."""
        answer = self.answer("message", json.dumps(request), tab=tab)
        assert "ok" in answer, answer
        return answer["ok"]

    def refusal(self, tab="tab-1", **request):
        """The sentence with which the engine refuses."""
        return self.answer("message", json.dumps(request), tab=tab)["error"]["message"]

    def upload(self, path, name=None, tab="tab-1"):
        name = urllib.parse.quote(name or pathlib.Path(path).name)
        return self.answer(f"upload?file={name}", pathlib.Path(path).read_bytes(), BYTES, tab)

    def accept(self, name, tab="tab-1"):
        """Lets an FMU run that was uploaded, as the page does."""
        page = self.request("GET", f"/{self.path}")[1].decode()
        (secret,) = re.findall('<meta name="plcfmu-secret" content="([0-9a-f]{32})">', page)
        return self.answer("accept", json.dumps({"fmu": name, "secret": secret}), tab=tab)

    def children(self):
        """The processes that it has started."""
        try:
            return {child.pid for child in psutil.Process(self.process.pid).children()}
        except psutil.NoSuchProcess:
            return set()

    def wait_for(self, text):
        """Waits until it prints a line with this text to standard error."""
        lines = []
        while line := self.errors.get():
            lines.append(line)
            if text in line:
                return
        pytest.fail(f"it has not printed {text!r}, only {lines}")

    def stop(self):
        """Interrupts it as Ctrl-C does, and gives the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait()


@pytest.fixture
def start(command, tmp_path):
    """Starts servers. At the end of a test none has left a process or a file."""
    tools = []

    def start(*arguments, **options):
        tools.append(Tool(command, tmp_path, *arguments, **options))
        assert tools[-1].url, list(iter(tools[-1].errors.get, None))
        tools[-1].enter()
        return tools[-1]

    yield start
    children = [child for tool in tools for child in tool.children()]
    statuses = [tool.stop() for tool in tools if tool.process.poll() is None]
    assert set(statuses) <= {0, 130}
    assert not [child for child in children if is_alive(child)], "a process is left"
    assert list((tmp_path / "tmp").glob("*")) == [], "temporary files are left"


@pytest.fixture
def tool(start):
    return start()


def is_alive(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def with_faulty(fault=0, at=0):
    """A loop of a controller with that FMU."""
    plant = {"name": "P", "fmu": "FAULTY", "values": {"FAULT": fault, "AT": at}}
    controller = {"MAN_ON": False, "SP_INT": 60.0, "GAIN": 2.0, "TI": 10.0, "CYCLE": 1.0}
    return {
        "members": [{"name": "C", "fmu": "CONT_C", "values": controller}, plant],
        "connections": [["C.LMN", "P.U"], ["P.Y", "C.PV_IN"]],
    }


def rows(tool, variables, tab="tab-1"):
    """What a run has recorded: all calls, as numbers by variable."""
    curves = tool.ask(tab, do="view", variables=variables, points=10_000)
    assert curves["is_exact"]
    return dict(zip(variables, curves["values"]))


def bits(values):
    return [float(value).hex() for value in values]


# The page


def test_the_address_is_printed_and_leads_to_the_page(tool):
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[0-9a-f]{32}/open\?code=[0-9a-f]{32}", tool.url)
    answer, content = tool.request("GET", f"/{tool.path}")
    assert answer.status == 200
    page = content.decode()
    assert '<meta name="plcfmu-home" content="server">' in page
    assert files(page) == []
    assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    for name, value in [
        ("X-Frame-Options", "DENY"),
        ("X-Content-Type-Options", "nosniff"),
        ("Referrer-Policy", "no-referrer"),
        ("Cache-Control", "no-store"),
    ]:
        assert answer.headers[name] == value
    assert not [name for name in answer.headers if name.lower().startswith("access-control")]


def files(page):
    """The parameter files that the page opens at once."""
    (content,) = re.findall(r'<script type="text/plain" id="files">([^<]*)</script>', page)
    return json.loads(gzip.decompress(of_base93(content)))


def of_base93(text):
    """The bytes of the page's base 93, whose digits are the characters from ! to ~ but for <: two of them are 13 bits, or 14."""
    digits = [chr(code) for code in range(33, 127) if chr(code) != "<"]
    bits = count = 0
    for at in range(0, len(text), 2):
        pair = text[at : at + 2]
        value = sum(digits.index(digit) * 93**place for place, digit in enumerate(pair))
        bits |= value << count
        count += 8 - count % 8 if len(pair) == 1 else 14 if value % 8192 < 93 * 93 - 8192 else 13
    return bits.to_bytes(count // 8 + 1, "little")[: count // 8]


def test_each_server_has_an_address_of_its_own(start):
    assert start().path != start().path


def test_files_of_the_command_line_are_in_the_page(start, faulty, tmp_path, make_preset, open_fmu):
    (tmp_path / "plant.awl").write_bytes(b"DATA_BLOCK <!-- \xe4")
    preset = make_preset(open_fmu("CONT_C"), tmp_path / "TIC101.fmu", GAIN=2.5)
    tool = start("plant.awl", preset, host.FOLDER / "PULSEGEN.fmu", "--plant", faulty)
    page = tool.request("GET", f"/{tool.path}")[1].decode()
    assert 'name="plcfmu-plant" content="FAULTY"' in page
    assert 'name="plcfmu-open" content="PULSEGEN"' in page
    source, values = files(page)
    assert source["file"] == "plant.awl" and base64.b64decode(source["content"]) == b"DATA_BLOCK <!-- \xe4"
    (loop,) = tool.ask(do="read", **values)["loops"]
    assert (loop["name"], loop["block"]) == ("TIC101", "CONT_C")
    assert {"GAIN": 2.5}.items() <= {setting["name"]: setting["value"] for setting in loop["settings"]}.items()


# Who is answered


def test_another_token_is_not_found_and_told_nothing(tool):
    other = "0" * 32
    for path in ("/", f"/{other}/", f"/{other}/message", "/message", f"/{tool.path[:-1]}", f"/{tool.path}other"):
        for method in ("GET", "POST"):
            answer, content = tool.request(method, path, "{}", Content_Type=JSON, X_Page="tab-1")
            assert (answer.status, content) == (404, b""), path


def test_two_hosts_are_refused(tool):
    connection = http.client.HTTPConnection(tool.host)
    connection.putrequest("GET", f"/{tool.path}", skip_host=True)
    for name in (tool.host, "evil.example"):
        connection.putheader("Host", name)
    connection.putheader("Cookie", tool.cookie)
    connection.endheaders()
    assert connection.getresponse().status == 400
    connection.close()


def test_another_host_is_refused(tool):
    port = tool.host.split(":")[1]
    for name in ("evil.example", f"evil.example:{port}", "127.0.0.1", f"127.0.0.1:{port}.evil.example", ""):
        assert tool.request("GET", f"/{tool.path}", Host=name)[0].status == 403, name
    assert tool.request("GET", f"/{tool.path}", Host=f"localhost:{port}")[0].status == 200


def test_a_page_from_elsewhere_is_refused(tool):
    headers = {"Content_Type": JSON, "X_Page": "tab-1"}
    for origin in ("http://evil.example", "null", f"https://{tool.host}", "http://127.0.0.1", f"http://{tool.host}.example"):
        for method, path in (("POST", f"/{tool.path}message"), ("GET", f"/{tool.path}"), ("OPTIONS", f"/{tool.path}message")):
            answer, content = tool.request(method, path, '{"do": "catalogue"}', Origin=origin, **headers)
            assert (answer.status, content) == (403, b""), origin
            assert "Access-Control-Allow-Origin" not in answer.headers
        assert tool.presence(Origin=origin)[0].status == 403
    answer, _ = tool.request("POST", f"/{tool.path}message", '{"do": "catalogue"}', Origin=f"http://{tool.host}", **headers)
    assert answer.status == 200


def test_only_a_post_of_the_right_type_from_a_tab_is_a_request(tool):
    request = '{"do": "catalogue"}'
    path = f"/{tool.path}message"
    assert tool.request("GET", path)[0].status == 405
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "application/json; x=y"):
        assert tool.request("POST", path, request, Content_Type=kind, X_Page="tab-1")[0].status == 415, kind
    assert tool.request("POST", path, request, X_Page="tab-1")[0].status == 415
    for tab in ({}, {"X_Page": ""}, {"X_Page": "a/b"}, {"X_Page": "x" * 65}):
        answer, content = tool.request("POST", path, request, Content_Type=JSON, **tab)
        assert answer.status == 400 and "X-Page" in json.loads(content)["error"]["message"]


def test_what_is_no_request_is_refused_in_a_sentence(tool):
    for body in ("", "hello", "[]", "{}", '{"do": "dance"}', '{"do": "run", "calls": -1}', "[" * 100_000):
        assert list(tool.answer("message", body)) == ["error"]
    assert tool.post("message", b"\xff")[0].status == 400
    assert tool.request("GET", f"/{tool.path}presence?tab=tab-1")[0].status == 400
    assert tool.ask(do="catalogue")["fmus"]


@pytest.mark.parametrize("what, kind, most", [("message", JSON, 64), ("upload?file=A.fmu", BYTES, 256)])
def test_a_body_that_is_too_large_is_refused_before_it_is_sent(tool, what, kind, most):
    connection = http.client.HTTPConnection(tool.host)
    connection.putrequest("POST", f"/{tool.path}{what}")
    for name, value in (
        ("Content-Type", kind),
        ("X-Page", "tab-1"),
        ("Cookie", tool.cookie),
        ("Content-Length", str(most * MIB + 1)),
    ):
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    assert answer.status == 413
    assert json.loads(answer.read())["error"]["message"] == f"the request is larger than {most} MiB, the maximum that the server accepts"
    connection.close()


def test_a_body_without_a_length_has_the_same_limit(tool):
    connection = http.client.HTTPConnection(tool.host)
    blocks = (b" " * MIB for _ in range(66))
    headers = {"Content-Type": JSON, "X-Page": "tab-1", "Cookie": tool.cookie}
    with pytest.raises((BrokenPipeError, ConnectionResetError, AssertionError)):
        connection.request("POST", f"/{tool.path}message", blocks, headers, encode_chunked=True)
        assert connection.getresponse().status != 413
    connection.close()
    assert tool.ask(do="catalogue")["fmus"]


# Another user of the machine

NOBODY = 65534


def as_another(*arguments, **options):
    """What a command of another user gives."""
    if not hasattr(os, "geteuid") or os.geteuid() != 0:
        pytest.skip("only root can act as another user")
    return subprocess.run(arguments, user=NOBODY, group=NOBODY, extra_groups=[], capture_output=True, text=True, **options)


def test_another_user_cannot_use_an_address_that_was_used(tool):
    ask = "import sys, urllib.request; print(urllib.request.urlopen(sys.argv[1]).status)"
    for address in (tool.url, f"http://{tool.host}/{tool.path}"):
        done = as_another("/usr/bin/python3", "-c", ask, address)
        assert done.returncode == 1 and "HTTP Error 403" in done.stderr, done


def test_a_code_is_good_once_and_the_next_one_is_printed(tool):
    assert tool.cookie.startswith("plcfmu=")
    answer, content = tool.enter()
    assert (answer.status, "Set-Cookie" in answer.headers) == (403, False)
    assert content == b"This address has already been used. plcfmu tool has printed another one in its terminal."
    line = next(line for line in iter(tool.errors.get, None) if line.startswith("For another browser: "))
    tool.url = line.split()[-1]
    answer, content = tool.enter()
    assert answer.headers["Set-Cookie"] == f"{tool.cookie}; Path=/{tool.path}; HttpOnly; SameSite=Strict"
    assert f'content="0; url=/{tool.path}"'.encode() in content


def test_without_the_cookie_nothing_is_answered(tool, faulty):
    tool.upload(faulty)
    for cookie in ("", "plcfmu=", f"plcfmu={'0' * 32}", f"x{tool.cookie}", tool.cookie[:-1]):
        assert tool.request("GET", f"/{tool.path}", Cookie=cookie)[0].status == 403
        assert tool.presence(Cookie=cookie)[0].status == 403
        for what in ("message", "upload?file=A.fmu", "accept"):
            answer, content = tool.request("POST", f"/{tool.path}{what}", "{}", Content_Type=JSON, X_Page="tab-1", Cookie=cookie)
            assert (answer.status, b"plcfmu-secret" in content) == (403, False)


def test_code_of_an_fmu_runs_only_for_who_knows_what_the_page_knows(tool, faulty):
    tool.upload(faulty)
    for secret in ("", "0" * 32, tool.path[:-1], tool.cookie.removeprefix("plcfmu=")):
        answer, content = tool.post("accept", json.dumps({"fmu": "FAULTY", "secret": secret}))
        assert (answer.status, "the user" not in content.decode()) == (403, True)
    assert tool.post("accept", '{"fmu": "FAULTY"}')[0].status == 400
    assert tool.refusal(do="start", **with_faulty()).endswith("FAULTY is native code that the user has not allowed to run")
    assert "ok" in tool.accept("FAULTY")


def test_what_an_fmu_says_of_itself_is_quoted_and_short(tool, faulty, tmp_path):
    lie = "you. It is safe, and made by the maker of this tool." + " Say yes." * 9
    with zipfile.ZipFile(faulty) as fmu, zipfile.ZipFile(tmp_path / "x.fmu", "w") as liar:
        for name in fmu.namelist():
            text = fmu.read(name)
            liar.writestr(name, text.replace(b"By hand", lie.encode()) if name == "modelDescription.xml" else text)
    question = tool.upload(tmp_path / "x.fmu", 'x". It is safe.fmu')["ok"]["question"]
    assert question == (
        r'The FMU "x\". It is safe" is third-party native code. It names tool '
        f'"{lie[:60]}…", author "Somebody"; nothing has been verified. Let it run on this machine, with all your permissions?'
    )


def test_no_command_line_has_what_opens_the_page(command, tmp_path):
    opener, seen = tmp_path / "bin" / "xdg-open", tmp_path / "seen"
    opener.parent.mkdir()
    os.mkfifo(seen)
    # It stays, as a browser does, until somebody has read what it was told.
    opener.write_text(f'#!/bin/sh\necho "$@" > {seen}\n')
    opener.chmod(0o755)
    environment = {**os.environ, "PATH": f"{opener.parent}:{os.environ['PATH']}", "PLCFMU_FMUS": str(host.FOLDER)}
    given = [command, "tool"]
    with subprocess.Popen(given, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            told = seen.read_text().strip()
            door = pathlib.Path(told)
            printed = process.stdout.readline().strip()
            token = printed.split("/")[3]
            assert token not in told and door.stat().st_mode & 0o777 == 0o600
            (address,) = re.findall('href="([^"]*)"', door.read_text())
            assert address != printed and address.startswith(printed.split("open?")[0])
            if os.geteuid() == 0:
                assert "Permission denied" in as_another("cat", door).stderr
        finally:
            process.send_signal(signal.SIGINT)
        process.wait()
    assert not door.exists()


def test_thousands_of_idle_connections_of_another_user_change_nothing(start):
    import resource

    hold = """
import resource, socket, sys
resource.setrlimit(resource.RLIMIT_NOFILE, (4096, 4096))
held = [socket.create_connection(("127.0.0.1", int(sys.argv[1]))) for _ in range(2000)]
print(len(held), flush=True)
sys.stdin.read()
"""
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, limits[1]))
    try:
        tool = start()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    other = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.geteuid() == 0 else {}
    given = ["/usr/bin/python3", "-c", hold, tool.host.split(":")[1]]
    with subprocess.Popen(given, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, **other) as holder:
        assert holder.stdout.readline() == "2000\n"
        assert tool.ask(do="catalogue")["fmus"]
        assert len(psutil.Process(tool.process.pid).net_connections()) < 80
        holder.stdin.close()
    assert tool.ask(do="catalogue")["fmus"]


# Engines


def with_plants(tool, open_page, count):
    """Pages, in each of which a loop is started, and the process of its plant, in the order of starting."""
    processes = []
    for _ in range(count):
        page = open_page(tool)
        setup = json.dumps({"do": "start", **with_faulty()})
        page.evaluate(f"async () => {{ await (await moduleOf('tool/engine.js')).ask({setup}) }}")
        (process,) = tool.children() - {process for _, process in processes}
        processes.append((page, process))
    return processes


def end_of(process):
    """Waits for it."""
    with contextlib.suppress(psutil.NoSuchProcess):
        psutil.Process(process).wait(timeout=60)


def test_the_processes_of_a_closed_tab_end(start, faulty, open_page):
    tool = start("--plant", faulty)
    (_, other), (closed, first), (crashed, second) = with_plants(tool, open_page, 3)
    # As a user closes it.
    closed.close(run_before_unload=True)
    # As when the system ends its process: it can do nothing.
    with pytest.raises(Exception, match="crash"):
        crashed.goto("chrome://crash")
    end_of(first)
    end_of(second)
    assert tool.children() == {other}


def test_a_tab_that_is_still_there_keeps_its_processes(start, faulty, open_page):
    tool = start("--plant", faulty)
    (lonely, first), (frozen, second), (closed, third) = with_plants(tool, open_page, 3)
    lonely.evaluate("connections[0].close()")
    lonely.wait_for_function("() => connections[1]?.readyState === WebSocket.OPEN")
    # As the browser does with what has been in the background for long.
    frozen.context.new_cdp_session(frozen).send("Page.setWebLifecycleState", {"state": "frozen"})
    # When the process of a tab has ended that was closed later, theirs would have, too.
    closed.close()
    end_of(third)
    assert tool.children() == {first, second}


def test_more_tabs_than_a_browser_has_connections_are_answered(tool, open_page):
    context = open_page(tool).context
    for _ in range(8):
        open_page(tool, context)


def test_a_session_has_the_bits_of_the_same_run_on_the_command_line(tool, command, tmp_path):
    tool.ask(do="start", **FURNACE)
    tool.ask(do="run", calls=30)
    tool.ask(do="send", values={"C.MAN_ON": False})
    tool.ask(do="run", calls=70)
    tool.ask(do="send", values={"C.SP_INT": 180.0, "P.DOOR": 50.0})
    tool.ask(do="run", calls=200)
    same_as_run(tool, command, tmp_path, FURNACE, {"C.MAN_ON": "false@30", "C.SP_INT": "180@100", "P.DOOR": "50@100"}, 300)


def test_a_session_with_a_foreign_fmu_has_the_bits_of_the_same_run(start, command, tmp_path, faulty):
    tool = start("--plant", faulty)
    tool.ask(do="start", **with_faulty())
    tool.ask(do="run", calls=40)
    tool.ask(do="send", values={"C.SP_INT": 20.0})
    tool.ask(do="run", calls=60)
    assert len(tool.children()) == 1
    same_as_run(tool, command, tmp_path, with_faulty(), {"C.SP_INT": "20@40"}, 100, {"FAULTY": faulty})


def same_as_run(tool, command, folder, loop, events, calls, fmus={}):
    """Compares all that is recorded with `plcfmu run`."""
    settings = {f"{of['name']}.{name}": value for of in loop["members"] for name, value in of["values"].items()}
    given = [command, "run", *(f"{of['name']}={fmus.get(of['fmu'], host.FOLDER / (of['fmu'] + '.fmu'))}" for of in loop["members"])]
    given += [f"--connect={source}={target}" for source, target in loop["connections"]]
    given += [f"--set={name}={value}" for name, value in {**settings}.items()]
    given += [f"--set={name}={value}" for name, value in events.items()]
    variables = [name for name in tool.ask(do="state")["values"]]
    given += [f"--record={name}" for name in variables] + ["--step=1", f"--stop={calls}", "--out=run.csv"]
    done = subprocess.run(given, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    # The last row is that of the end, at which there is no call.
    *expected, _ = csv.DictReader(io.StringIO((folder / "run.csv").read_text()))
    recorded = rows(tool, variables)
    assert len(expected) == calls and len(variables) > 4
    for name in variables:
        assert bits(recorded[name]) == bits(row[name] for row in expected), name


def test_two_tabs_do_not_disturb_each_other(tool):
    tool.ask("tab-1", do="start", **FURNACE)
    tool.ask("tab-2", do="start", **FURNACE)
    tool.ask("tab-2", do="send", values={"C.MAN": 80.0})
    for _ in range(10):
        tool.ask("tab-1", do="run", calls=10)
        tool.ask("tab-2", do="run", calls=7)
    assert (tool.ask("tab-1", do="state")["calls"], tool.ask("tab-2", do="state")["calls"]) == (100, 70)
    assert tool.ask("tab-1", do="state")["values"]["C.LMN"] == 50.0
    assert tool.ask("tab-2", do="state")["values"]["C.LMN"] == 80.0


def test_of_too_many_tabs_the_one_that_was_idle_for_longest_loses_its_engine(tool):
    def engine(tab):
        return tool.post("message", '{"do": "catalogue"}', tab=tab)[0].headers["X-Engine"]

    engines = {number: engine(f"tab-{number}") for number in range(16)}
    assert len(set(engines.values())) == 16
    # The first is not the oldest any more.
    assert engine("tab-0") == engines[0]
    engine("tab-16")
    assert engine("tab-0") == engines[0] and engine("tab-2") == engines[2]
    assert engine("tab-1") not in engines.values()


def test_a_preset_of_a_loop_is_made_of_the_fmu_that_was_found(tool):
    names = {entry["name"]: entry for entry in tool.ask(do="catalogue")["fmus"]}
    assert set(host.names()) == set(names)
    assert names["CONT_C"]["part"] == "controller" and names["HEATER"]["part"] == "plant"
    assert not any(entry["is_foreign"] for entry in names.values())


# Foreign FMUs


def test_an_fmu_that_is_sent_runs_only_after_it_was_accepted(tool, faulty):
    inspected = tool.upload(faulty)["ok"]
    assert inspected == {
        "name": "FAULTY",
        "model": "Faulty",
        "summary": "A lag that fails",
        "tool": "By hand",
        "author": "Somebody",
        "question": 'The FMU "FAULTY" is third-party native code. It names tool "By hand", author "Somebody"; nothing has '
        "been verified. Let it run on this machine, with all your permissions?",
        "platforms": [fmpy.platform],
        "problem": None,
        "parameters": None,
    }
    assert "FAULTY" not in {entry["name"] for entry in tool.ask(do="catalogue")["fmus"]}
    assert tool.refusal(do="start", **with_faulty()).endswith("FAULTY is native code that the user has not allowed to run")
    assert tool.children() == set()
    accepted = tool.accept("FAULTY")["ok"]
    assert (accepted["name"], accepted["is_foreign"]) == ("FAULTY", True)
    assert accepted in tool.ask(do="catalogue")["fmus"]
    assert accepted not in tool.ask("tab-2", do="catalogue")["fmus"]
    tool.ask(do="start", **with_faulty())
    assert tool.ask(do="run", calls=5)["failure"] is None
    # What the FMU prints goes to standard error.
    for _ in range(5):
        tool.wait_for("a step")


def test_a_file_that_is_no_fmu_is_refused(tool, tmp_path):
    (tmp_path / "x.fmu").write_bytes(b"hello")
    assert tool.upload(tmp_path / "x.fmu")["error"]["message"] == "x.fmu: it is not a ZIP file, or its end is missing"
    refused = tool.accept("x")["error"]["message"]
    assert refused == 'no FMU "x" has been uploaded'


def test_the_name_of_an_fmu_that_is_sent_is_no_path(tool, faulty):
    for name, expected in [("../../x/A.fmu", "A"), ("<img>.fmu", "<img>"), ("", "FMU"), ("CONT_C.fmu", "CONT_C_2")]:
        sent = tool.answer(f"upload?file={urllib.parse.quote(name, safe='')}", faulty.read_bytes(), BYTES)
        assert sent["ok"]["name"] == expected


def test_an_fmu_for_another_machine_says_so(tool, faulty, tmp_path):
    with zipfile.ZipFile(faulty) as fmu, zipfile.ZipFile(tmp_path / "far.fmu", "w") as far:
        far.writestr("modelDescription.xml", fmu.read("modelDescription.xml"))
        far.writestr("binaries/plan9/faulty.so", b"x")
    inspected = tool.upload(tmp_path / "far.fmu")["ok"]
    assert inspected["problem"].startswith("the FMU has no library for this platform")
    assert "no library for this platform" in tool.accept("far")["error"]["message"]


def test_a_preset_that_is_sent_gives_its_values_without_running(tool, tmp_path, make_preset, open_fmu):
    preset = make_preset(open_fmu("CONT_C"), tmp_path / "TIC101.fmu", GAIN=2.5, TI=7.0)
    sent = tool.upload(preset)["ok"]
    (loop,) = tool.ask(do="read", **sent["parameters"])["loops"]
    values = {setting["name"]: setting["value"] for setting in loop["settings"]}
    assert (loop["name"], loop["block"], values["GAIN"], values["TI"]) == ("TIC101", "CONT_C", 2.5, 7.0)
    assert tool.children() == set()


def test_a_block_that_is_sent_has_its_dialog_and_runs_in_a_process_of_its_own(tool, open_fmu):
    assert tool.upload(open_fmu("CONT_C").path, "OTHER.fmu")["ok"]["name"] == "OTHER"
    accepted = tool.accept("OTHER")["ok"]
    assert accepted["part"] == "controller"
    assert tool.ask(do="describe", fmu="OTHER")["roles"] == tool.ask(do="describe", fmu="CONT_C")["roles"]
    tool.ask(do="start", members=[{"name": "C", "fmu": "OTHER", "values": CONTROLLER}], connections=[])
    assert tool.ask(do="run", calls=3)["values"]["C.LMN"] == 50.0
    assert len(tool.children()) == 1


# abort, hang, fmi2Error, exit
FAULTS = {
    1: r"P: .*the FMU crashed: signal 6 \(abort\) while it was making a step",
    2: r"P: .*the FMU did not return within 5 s while it was making a step",
    3: r"P: at 10\.0 s, step 1\.0 s: fmi2DoStep returned fmi2Error: the sensor is broken",
    4: r"P: .*the FMU ended its process with exit code 3 while it was making a step",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_after_a_plant_has_failed_the_controller_goes_on_with_another(start, faulty, open_fmu, fault):
    tool = start("--plant", faulty, "--time-limit", "5")
    tool.ask("other", do="start", **FURNACE)
    tool.ask(do="start", **with_faulty(fault, at=10))
    state = tool.ask(do="run", calls=50)
    assert re.fullmatch(FAULTS[fault], state["failure"]), state["failure"]
    calls = state["calls"]
    assert calls in (10, 11)
    assert "the run has ended" in tool.refusal(do="run", calls=1)
    # Another tab has seen nothing of it.
    assert tool.ask("other", do="run", calls=5)["failure"] is None

    plant = [{"name": "P", "fmu": "FAULTY", "values": {}}]
    state = tool.ask(do="exchange", members=plant, connections=with_faulty()["connections"])
    assert (state["failure"], state["calls"]) == (None, calls)
    tool.ask(do="run", calls=20)
    assert len(tool.children()) == 1

    # The same with FMPy: the controller is called on, the plant begins anew.
    controller = open_fmu("CONT_C").start(**with_faulty()["members"][0]["values"])
    y, expected = 0.0, []
    for call in range(calls + 20):
        y = 0.0 if call == calls else y
        controller.step(1.0, PV_IN=y)
        expected.append(controller["LMN"])
        y += (controller["LMN"] - y) * 1.0 / 8.0
    assert bits(rows(tool, ["C.LMN"])["C.LMN"]) == bits(expected)


# The page in a browser


# The connections that a page has made.
CONNECTIONS = """globalThis.connections = [];
WebSocket = class extends WebSocket {
  constructor(address) {
    super(address);
    connections.push(this);
  }
};"""


@pytest.fixture
def open_page():
    """Opens the page of a server in a browser."""
    pytest.importorskip("playwright", reason="playwright is not installed (tests/requirements.txt)")
    from playwright.sync_api import sync_playwright

    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if chromium is None:
        pytest.skip("no chromium: on Debian and Ubuntu 'apt install chromium'")
    arguments = "--no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-component-update"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=[*arguments.split(), "--disable-sync"])

        def open_page(tool, context=None):
            page = (context or browser.new_context()).new_page()
            page.add_init_script(CONNECTIONS)
            token, value = tool.path.strip("/"), tool.cookie.removeprefix("plcfmu=")
            page.context.add_cookies([{"name": "plcfmu", "value": value, "domain": "127.0.0.1", "path": f"/{token}/"}])
            page.goto(f"http://{tool.host}/{tool.path}")
            page.locator("#new-block option").first.wait_for(state="attached")
            return page

        yield open_page
        browser.close()


def test_a_browser_gets_to_the_page_by_the_file_that_it_is_given(tool, open_page, tmp_path):
    tool.request("GET", "/" + tool.path)
    address = next(line for line in iter(tool.errors.get, None) if line.startswith("For another browser: ")).split()[-1]
    (tmp_path / "door.html").write_text(f'<meta http-equiv="refresh" content="0; url={address}">')
    browser = open_page(tool).context.browser
    page = browser.new_context().new_page()
    page.goto((tmp_path / "door.html").as_uri())
    page.locator("#new-block option").first.wait_for(state="attached")
    assert page.url == f"http://{tool.host}/{tool.path}"


def test_the_page_opens_what_the_command_line_names(start, open_page):
    from playwright import sync_api

    page = open_page(start(ROOT / "tests/parameters/plant.awl", "--plant", host.FOLDER / "TANK.fmu"))
    page.get_by_text("TIC103").first.click()
    sync_api.expect(page.locator("#plant select").first).to_have_value("TANK")


def test_a_source_that_is_saved_opens_again_with_its_inputs(start, open_page, tmp_path):
    text = """FUNCTION_BLOCK "Steps"
VAR_INPUT step : Int := 1; END_VAR
VAR_OUTPUT sum : Int; END_VAR
BEGIN
  #sum += #step;
END_FUNCTION_BLOCK
"""
    source = tmp_path / "steps.scl"
    source.write_text(text)
    page = open_page(start(source))
    page.locator('[data-input="step"] input.number').fill("5")
    page.locator('[data-input="step"] input.number').press("Enter")
    source.write_text(text.replace("#sum += #step", "#sum += 2 * #step"))
    page.locator(".program .line", has_text="2 * #step").wait_for()
    page.get_by_role("button", name="One cycle").click()
    total = "() => moduleOf('tool/store.js').then(({ store }) => store.state?.values['Steps.sum'] === 10)"
    page.wait_for_function(total)


def test_a_folder_opens_as_a_whole_and_again_when_a_file_below_it_is_saved(start, open_page, tmp_path):
    folder = shutil.copytree(ROOT / "examples/programs/mixer", tmp_path / "mixer")
    page = open_page(start(folder))
    page.get_by_text("The project: 3 sources").click()
    # Its tag table, which is in a folder below it, makes inputs of the tags.
    page.get_by_text("10 tags, 9 in use; 1 constant, from 1 table").wait_for()
    page.locator('[data-input="\'Lid closed\'"]').wait_for()
    source = folder / "Mixer.scl"
    source.write_text(source.read_text().replace("END_FUNCTION_BLOCK", "// saved again\nEND_FUNCTION_BLOCK"))
    page.get_by_label("Source", exact=True).select_option("Mixer.scl")
    page.locator(".program .line", has_text="// saved again").wait_for()
    # A source that is new belongs to the same program.
    (folder / "More.scl").write_text("FUNCTION \"More\" : Int\nBEGIN\n  #More := 1;\nEND_FUNCTION\n")
    page.get_by_text("The project: 4 sources").wait_for()
    assert page.evaluate("() => moduleOf('tool/store.js').then(({ store }) => store.loops.length)") == 1


def test_the_page_asks_before_an_fmu_that_is_dropped_runs(tool, open_page, faulty):
    page = open_page(tool)
    names = "async () => (await (await moduleOf('tool/engine.js')).ask({ do: 'catalogue' })).fmus.map(({ name }) => name)"
    page.set_input_files("#open-files", faulty)
    page.get_by_text('It names tool "By hand", author "Somebody"').wait_for()
    assert "FAULTY" not in page.evaluate(names)
    page.get_by_text("Run it", exact=True).click()
    page.get_by_text("FAULTY can now be chosen as a plant").wait_for()
    assert "FAULTY" in page.evaluate(names)


def test_a_foreign_plant_whose_names_say_nothing_is_connected_by_what_is_open(start, open_page, faulty):
    from playwright import sync_api

    page = open_page(start("--plant", faulty))
    page.get_by_role("button", name="New loop").click()
    plant = page.locator("#plant")
    sync_api.expect(plant.locator("#plant-choice")).to_have_value("FAULTY")
    notes = plant.locator(".sentences .note")
    missing = "nothing is connected to CONT_C_1.PV_IN"
    sync_api.expect(notes).to_have_text(["No output clearly matches an input: choose below.", missing])
    # What has to be chosen is not folded away.
    process_value = plant.get_by_label("Source of PV_IN", exact=True)
    process_value.select_option("PLANT.Y")
    sync_api.expect(plant.get_by_text("goes to PV_IN")).to_be_visible()
    sync_api.expect(notes).to_have_count(0)
    process_value.select_option("")
    sync_api.expect(notes.last).to_have_text(missing)


def test_the_page_says_that_the_server_is_gone_and_keeps_what_it_shows(start, open_page):
    from playwright import sync_api

    tool = start(ROOT / "tests/parameters/plant.awl", "--plant", host.FOLDER / "TANK.fmu")
    page = open_page(tool)
    page.get_by_text("TIC103").first.click()
    sync_api.expect(page.locator("#plant select").first).to_have_value("TANK")
    page.locator("#fields .field").first.wait_for()
    tool.stop()
    # One call.
    page.keyboard.press(".")
    page.get_by_text("plcfmu tool is not responding").first.wait_for()
    assert page.locator("#fields .field").count() > 10


# The end


def test_ctrl_c_ends_it_with_all_that_it_has_started(start, faulty):
    tool = start("--plant", faulty)
    tool.ask(do="start", **with_faulty())
    tool.ask("tab-2", do="start", **with_faulty())
    children = tool.children()
    assert len(children) == 2
    assert tool.stop() in (0, 130)
    assert not [child for child in children if is_alive(child)]
    assert list(tool.temporary.iterdir()) == []


def test_ctrl_c_does_not_wait_for_an_fmu_that_hangs(start, faulty):
    tool = start("--plant", faulty, "--time-limit", "86400")
    tool.ask(do="start", **with_faulty(2))
    connection = http.client.HTTPConnection(tool.host)
    headers = {"Content-Type": JSON, "X-Page": "tab-1", "Cookie": tool.cookie}
    connection.request("POST", f"/{tool.path}message", '{"do": "run", "calls": 1}', headers)
    # It prints when it is in the step.
    tool.wait_for("a step")
    assert tool.stop() in (0, 130)
    connection.close()


def test_it_starts_again_on_the_same_port(start):
    first = start()
    port = first.host.split(":")[1]
    assert first.ask(do="catalogue")["fmus"]
    first.stop()
    again = start("--port", port)
    assert again.host == first.host and again.path != first.path
    assert again.ask(do="catalogue")["fmus"]


def refused(command, folder, *arguments):
    environment = {**os.environ, "PLCFMU_FMUS": str(host.FOLDER)}
    done = subprocess.run(
        [command, "tool", "--no-browser", *map(str, arguments)], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 1 and done.stdout == ""
    return done.stderr.splitlines()[-1].removeprefix("error: ")


def test_what_cannot_be_served_is_refused_in_a_sentence(command, tool, tmp_path):
    port = tool.host.split(":")[1]
    assert refused(command, tmp_path, "--port", port) == (
        f"port {port} is in use by another program: choose another with --port, or omit --port"
    )
    assert refused(command, tmp_path, "none.awl").startswith("none.awl: ")
    assert refused(command, tmp_path, "none.fmu").startswith("none.fmu: ")
    (tmp_path / "notes.odt").write_text("x")
    assert refused(command, tmp_path, "notes.odt").endswith("is neither a parameter file, a program source, a recording (.csv), an FMU nor a folder")
    (tmp_path / "empty").mkdir()
    assert refused(command, tmp_path, "empty") == (
        "empty has no program source: export one there, as .scl, .udt, .db, .s7dcl, .xml or .awl"
    )
    assert refused(command, tmp_path, "--fmus", "empty") == (
        "no FMU of a block in empty: specify the folder of the FMUs with --fmus, or set PLCFMU_FMUS to it"
    )
