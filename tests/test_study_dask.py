"""Studies on a Dask cluster: the same bytes as the command gives, whatever happens to the workers."""

import concurrent.futures
import contextlib
import hashlib
import os
import pathlib
import re
import shutil
import signal
import stat
import subprocess
import sys
import types

import pytest

import host
from files import contents
import plcfmu
from plcfmu import parameters, studies

distributed = pytest.importorskip("distributed", reason="distributed is not installed (tests/requirements.txt)")

from plcfmu import workers  # noqa: E402 -- it imports distributed

ROOT = pathlib.Path(__file__).parents[1]

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the programs that stand between are shell scripts")

RUNS = 15
# Some runs fail.
EXPECTATION = "HEATER.TEMP.max < 45 degC"
CURVE = 5
STUDY = """
loop = "{loop}"
stop = 30.0
samples = {samples}
seed = {seed}
sampling = "latin_hypercube"

[[axes]]
variable = "CONT_C.GAIN"
values = [0.7, 1.4, 2.8]

[[axes]]
variable = "HEATER.T_START"
uniform = {{ min = 10.0, max = 30.0 }}

[[values]]
variable = "HEATER.TEMP"
take = ["max", "last"]
"""


def write_study(path, seed=1):
    loop = ROOT / "plants" / "loops" / "furnace.toml"
    path.write_text(STUDY.format(loop=loop, samples=RUNS // 3, seed=seed), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def tolerance(place):
    """A study of this many runs."""
    return write_study(place / "tolerance.toml")


@pytest.fixture(scope="module")
def expected(command, tolerance, place):
    """What the command makes of the study in one process."""
    out = place / "expected"
    given = [command, "study", str(tolerance), f"--fmus={host.FOLDER}", "--format=csv", "--jobs=1", f"--out={out}"]
    done = subprocess.run([*given, f"--expect={EXPECTATION}", f"--curves={CURVE}"], capture_output=True, text=True)
    assert done.returncode == 1 and "HEATER.TEMP.max" in done.stderr, done.stderr
    return contents(out)


class Between:
    """A program between the workers and the command: it notes each range of runs, and does to it what a test wants.

    `orders` is a shell script that sees the first run of the range as $first, and the worker's process as $PPID. Each range is
    noted in a file of its own.
    """

    def __init__(self, folder, command):
        self.program = folder / "plcfmu"
        self.log = folder / "log"
        self.orders = folder / "orders"
        lines = [
            "#!/bin/sh",
            'for argument; do case $argument in --runs=*) runs=${argument#--runs=}; first=${runs%%.*};; esac; done',
            f'[ -z "$runs" ] || {{ : > "{self.log}/$runs $$"; . "{self.orders}"; }}',
            f'exec "{command}" "$@"',
        ]
        self.program.write_text("\n".join(lines) + "\n", encoding="utf-8")
        self.program.chmod(self.program.stat().st_mode | stat.S_IXUSR)
        self.begin()

    def begin(self, orders=":"):
        """Forgets what it has noted."""
        shutil.rmtree(self.log, ignore_errors=True)
        self.log.mkdir()
        self.orders.write_text(orders + "\n", encoding="utf-8")

    def ranges(self):
        """The ranges of runs that workers were told to make."""
        noted = (re.fullmatch(r"(\d+)\.\.(\d+) \d+", path.name) for path in self.log.iterdir())
        return [range(int(found[1]), int(found[2])) for found in noted]


@pytest.fixture(scope="module")
def stage(command, tmp_path_factory):
    """A cluster of four processes, and what stands between them and the command."""
    between = Between(tmp_path_factory.mktemp("between"), command)
    # Of the nannies, too: a worker that is started again must not take what a test has set in this process since.
    variables = {"PLCFMU_COMMAND": str(between.program)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(ROOT / "plcfmu" / "python"))
        with distributed.LocalCluster(
            n_workers=4,
            threads_per_worker=1,
            dashboard_address=None,
            local_directory=str(between.program.parent),
            env=variables,
        ) as cluster:
            with distributed.Client(cluster, set_as_default=False) as client:
                yield between, client


@pytest.fixture
def between(stage, monkeypatch, command):
    monkeypatch.setenv("PLCFMU_COMMAND", command)
    stage[0].begin()
    return stage[0]


@pytest.fixture
def client(stage):
    return stage[1]


def run(path, out, client, **options):
    options = {"expect": [EXPECTATION], "curves": [CURVE], "format": "csv", "progress": False, **options}
    return plcfmu.study(path, out, client=client, fmus=host.FOLDER, **options)


@pytest.fixture
def only_runs(monkeypatch):
    """Lets a study end when all runs are made: drawing the final files takes long."""

    def called(program, *arguments):
        if "--resume" in arguments:
            return subprocess.CompletedProcess([program, *arguments], 1, "", "error: all runs are made\n")
        return parameters.called(program, *arguments)

    def only_runs(path, out, client, **options):
        with monkeypatch.context() as patch, pytest.raises(plcfmu.StudyError, match="^all runs are made; "):
            patch.setattr(studies, "called", called)
            run(path, out, client, **options)
        return sorted(run for part in spans(out) for run in part)

    return only_runs


def spans(out):
    """The runs of each part that there is."""
    names = (re.fullmatch(r"(\d+)-(\d+)\.part", path.name) for path in (out / "parts").iterdir())
    return [range(int(found[1]), int(found[2])) for found in names]


# The same bytes


def test_two_processes_of_this_machine_give_the_bytes_of_the_command(tolerance, expected, tmp_path, monkeypatch, command):
    monkeypatch.setenv("PLCFMU_COMMAND", command)
    monkeypatch.setattr("dask.system.CPU_COUNT", 2)
    result = run(tolerance, tmp_path / "out", None)
    assert contents(tmp_path / "out") == expected
    assert (result.count, result.errors) == (RUNS, {})
    assert len(result.unmet) == 1 and "HEATER.TEMP.max" in result.unmet[0]
    table = result.table()
    assert list(table["run"]) == list(range(RUNS))
    assert list(table["CONT_C.GAIN"]) == [0.7] * 5 + [1.4] * 5 + [2.8] * 5
    assert (table["HEATER.TEMP.max"] >= table["HEATER.TEMP.last"]).all()


def test_what_an_interrupted_call_has_made_is_not_made_again(tmp_path, between, client, only_runs, monkeypatch, caplog):
    study, out = write_study(tmp_path / "interrupted.toml", seed=2), tmp_path / "out"
    add = studies._Parts.add

    def add_three(parts, span, content):
        if len(list(parts.folder.glob("*.part"))) == 3:
            raise KeyboardInterrupt
        add(parts, span, content)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(studies._Parts, "add", add_three)
        run(study, out, client)
    assert "parts: continue with study(..., resume=True)" in caplog.text
    done = [run for part in spans(out) for run in part]
    assert len(done) >= 3
    with pytest.raises(plcfmu.StudyError, match="parts has runs of an earlier call: continue with resume=True, or remove"):
        run(study, out, client)
    assert only_runs(study, out, client, resume=True) == list(range(RUNS))
    made = [run for each in between.ranges() for run in each]
    assert [made.count(run) for run in done] == [1] * len(done)


def test_a_finished_study_is_not_made_again(tolerance, expected, tmp_path, between, client):
    out = tmp_path / "out"
    for path, content in expected.items():
        (out / path).parent.mkdir(parents=True, exist_ok=True)
        (out / path).write_bytes(content)
    assert run(tolerance, out, client, resume=True).count == RUNS
    assert between.ranges() == [] and contents(out) == expected
    (out / "runs.csv").write_bytes(expected["runs.csv"] + b"\n")
    with pytest.raises(plcfmu.StudyError, match="the run table has changed since; choose another folder"):
        run(tolerance, out, client, resume=True)


def test_parts_of_another_study_are_refused_before_any_run(tolerance, tmp_path, between, client):
    part = tmp_path / "out" / "parts" / "0-48.part"
    part.parent.mkdir(parents=True)
    part.write_bytes(b'plcfmu part 1\n{"fingerprint":"0123","first":0,"end":48}\n')
    with pytest.raises(plcfmu.StudyError, match="0-48.part belongs to another study, or .*; remove .*parts, or choose another folder"):
        run(tolerance, tmp_path / "out", client, resume=True)
    assert between.ranges() == []


def test_an_expectation_without_sense_is_refused_before_any_run(tolerance, tmp_path, between, client):
    with pytest.raises(plcfmu.StudyError, match="overshoots"):
        run(tolerance, tmp_path / "out", client, expect=["overshoots < 3 %"])
    assert between.ranges() == [] and not (tmp_path / "out").exists()


# What travels


def fmus_of(dask_worker):
    """The FMUs that a worker has, with what tells a file from a later one in its place."""
    folder = pathlib.Path(dask_worker.local_directory) / "plcfmu" / "fmus"
    return {path.name: path.stat().st_ino for path in folder.glob("*.fmu")}


def test_each_worker_gets_each_fmu_once_though_there_are_two_studies(tmp_path, between, client, only_runs):
    one, other = (write_study(tmp_path / f"{seed}.toml", seed) for seed in (3, 4))
    assert only_runs(one, tmp_path / "one", client) == list(range(RUNS))
    first = client.run(fmus_of)
    assert only_runs(other, tmp_path / "other", client) == list(range(RUNS))
    assert client.run(fmus_of) == first
    wanted = {hashlib.sha256(plcfmu.fmu(name, host.FOLDER).read_bytes()).hexdigest() + ".fmu" for name in ("CONT_C", "HEATER")}
    assert len(first) == 4 and all(set(fmus) == wanted for fmus in first.values())
    # What a study has sent is not kept for workers that come later.
    plugins = client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.worker_plugins))
    assert [name for name in plugins if name.startswith("plcfmu")] == []


def test_a_worker_that_its_nanny_restarts_gets_the_files_again(tolerance, tmp_path, between, client, command):
    bundle = tmp_path / "bundle"
    subprocess.run([command, "study", tolerance, f"--fmus={host.FOLDER}", f"--bundle={bundle}"], check=True)
    files = workers.Files("0123", client.id, bundle)
    workers.register(client, files)
    try:
        before = client.run(fmus_of)
        address = next(iter(before))
        process = client.run(os.getpid, workers=[address])
        client.restart_workers([address])
        client.wait_for_workers(4)
        after = client.run(fmus_of)
        assert process[address] not in client.run(os.getpid).values(), "it is another process"
        # The other tests of this file need it there.
        assert set(client.run(os.getenv, "PLCFMU_COMMAND").values()) == {str(between.program)}
    finally:
        client.unregister_worker_plugin(files.name)
    wanted = {path.name for path in (bundle / "fmus").iterdir()}
    assert len(wanted) == 2 and [set(fmus) for fmus in after.values()] == [wanted] * 4


# What can go wrong


@contextlib.contextmanager
def command_of_the_workers(client, program):
    """Lets all workers take another program."""

    def take(program):
        before, os.environ["PLCFMU_COMMAND"] = os.environ["PLCFMU_COMMAND"], str(program)
        return before

    (before,) = set(client.run(take, program).values())
    yield
    client.run(take, before)


def test_workers_with_another_version_of_the_program_are_refused(tmp_path, between, client, only_runs):
    study, old = write_study(tmp_path / "version.toml", seed=5), tmp_path / "plcfmu"
    old.write_text("#!/bin/sh\necho plcfmu 0.0.1\n", encoding="utf-8")
    old.chmod(0o755)
    wanted = rf"run \d+: tcp://\S+: {old} is plcfmu 0.0.1, but the client has plcfmu [\d.]+: install the same wheel of plcfmu"
    with command_of_the_workers(client, old), pytest.raises(plcfmu.StudyError, match=wanted) as error:
        run(study, tmp_path / "out", client)
    # While the error is kept, as in a notebook, the next call tries again.
    assert only_runs(study, tmp_path / "out", client, resume=True) == list(range(RUNS)) and error.value


def test_workers_without_the_program_are_refused(tmp_path, between, client):
    study, nothing = write_study(tmp_path / "nothing.toml", seed=6), tmp_path / "nothing"
    wanted = r"run \d+: tcp://\S+: PLCFMU_COMMAND is .*nothing, which is not a file"
    with command_of_the_workers(client, nothing), pytest.raises(plcfmu.StudyError, match=wanted):
        run(study, tmp_path / "out", client)


def test_without_dask_the_error_says_how_to_get_it(tolerance, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "plcfmu.workers")
    monkeypatch.delattr(plcfmu, "workers")
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'plcfmu\[dask\]', or run `plcfmu study`"):
        plcfmu.study(tolerance, tmp_path / "out")


# Ranges of runs


def cut(share, seconds_a_run, start):
    """The ranges that a share is cut into, if a run takes so long, and the start of the command before each range."""
    ranges = []
    while (span := share.next()) is not None:
        ranges.append(span)
        share.learn(span, start + seconds_a_run * (span.end - span.first), work=2.0)
    return ranges


@pytest.mark.parametrize("start", [0.05, 1.0])
@pytest.mark.parametrize("seconds_a_run", [1e-6, 1e-3, 0.4, 1.1, 30.0])
def test_ranges_have_each_run_once_and_are_soon_worth_their_way(seconds_a_run, start):
    ranges = cut(workers.Share([workers.Span(0, 7), workers.Span(9, 9), workers.Span(100, 20_000)]), seconds_a_run, start)
    assert [run for span in ranges for run in range(*span)] == [*range(7), *range(100, 20_000)]
    # Small ones until it is known how long a run takes; then one for each second of work at most.
    assert ranges[0] == (0, 1) and len(ranges) <= 16 + 20_000 * seconds_a_run
    assert max(span.end - span.first for span in ranges) * seconds_a_run <= max(4.0, 1.5 * seconds_a_run)


def test_one_range_that_takes_long_makes_the_next_ones_shorter():
    share = workers.Share([workers.Span(0, 1000)])
    for _ in range(3):
        span = share.next()
        share.learn(span, 0.1, work=2.0)
    assert span.end - span.first == 256
    share.learn(span, 200.0, work=2.0)
    span = share.next()
    assert span.end - span.first == 2


# Workers that die: at the end, so that the tests before have all four


def test_a_worker_that_is_killed_costs_no_run_and_doubles_none(tolerance, expected, tmp_path, between, client):
    """The first worker with a run from 8 on, after others, says who it is, waits, and is killed while it works."""
    begun, go_on = tmp_path / "begun", tmp_path / "go_on"
    os.mkfifo(begun)
    os.mkfifo(go_on)
    between.begin(
        f'if [ "$first" -ge 8 ] && mkdir "{tmp_path}/taken" 2>/dev/null; then\n'
        f'echo "$PPID $first" > "{begun}"; read -r _ < "{go_on}"; exit 1; fi'
    )
    before = client.run(os.getpid)
    with concurrent.futures.ThreadPoolExecutor() as threads:
        study = threads.submit(run, tolerance, tmp_path / "out", client.scheduler.address)

        def unblock(_):
            # If the study ends before any worker has said so, the test must not wait for one.
            with contextlib.suppress(OSError):
                os.close(os.open(begun, os.O_WRONLY | os.O_NONBLOCK))

        study.add_done_callback(unblock)
        process, first = map(int, begun.read_text().split())
        assert process in before.values()
        os.kill(process, signal.SIGKILL)
        go_on.write_text("\n")
        assert study.result().count == RUNS
    assert contents(tmp_path / "out") == expected
    made = between.ranges()
    assert sorted({run for each in made for run in each}) == list(range(RUNS))
    # So may be others that the worker had made, if it was killed before the client had fetched them.
    assert sum(each.start == first for each in made) > 1, "the range that the worker was at is made again"


def test_runs_that_kill_every_worker_are_named(tmp_path, between, client, monkeypatch):
    monkeypatch.setattr(client.cluster.scheduler, "allowed_failures", 0)
    between.begin('[ "$first" != 2 ] || kill -9 "$PPID"')
    # The worker had another range besides, which Dask suspects as well.
    wanted = r"^runs? \d+( to \d+)?: 1 worker died while running it: .*tcp://\S+ .*; the finished runs are kept in .*parts: "
    with pytest.raises(plcfmu.StudyError, match=wanted):
        run(write_study(tmp_path / "deadly.toml", seed=7), tmp_path / "out", client)


class Cluster:
    """A client of a cluster with this many threads."""

    class scheduler:
        address = "tcp://127.0.0.1:8786"

    def __init__(self):
        self.threads = {}

    def nthreads(self):
        return self.threads


def test_a_cluster_without_workers_is_told_once_after_five_seconds(caplog):
    cluster, seconds = Cluster(), [0.0]
    lonely = workers.Lonely(cluster, lambda: seconds[0])

    def told(at, threads):
        seconds[0], cluster.threads = at, threads
        caplog.clear()
        lonely.look()
        return caplog.messages

    message = "the cluster tcp://127.0.0.1:8786 has no workers: the study waits for the first one"
    assert told(4.9, {}) == []
    assert told(5.0, {}) == [message]
    assert told(60.0, {}) == []
    # The next time begins when the last worker is gone.
    assert told(61.0, {"tcp://worker": 1}) == []
    assert told(62.0, {}) == [] and told(66.9, {}) == []
    assert told(67.0, {}) == [message]


def result(tmp_path, runs="run,C.GAIN,iae,error\n0,0.5,3.0,\n1,2.0,,dry\n"):
    """What a study with two runs, of which one has failed, leaves."""
    figure = {"name": "iae", "unit": "s", "percentiles": {"p5": 3.0, "p50": 3.0, "p95": 3.0}, "worst": [{"run": 0, "value": 3.0}]}
    expectation = {"expectation": "iae < 2", "met": False, "problem": "1 of 2 runs fails"}
    summary = {"study": "a <b>", "runs": 2, "failed": 1, "figures": [figure], "expectations": [expectation]}
    (tmp_path / "runs.csv").write_text(runs)
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures/curves.svg").write_text("<svg>curves</svg>")
    return plcfmu.StudyResult(tmp_path, summary)


def test_a_result_is_a_line_and_what_is_wrong_with_the_call_is_refused_before_anything_runs(tmp_path, monkeypatch):
    line = repr(result(tmp_path))
    assert line.endswith("2 runs, 1 failed, 1 of 1 expectations not met>") and "\n" not in line and len(line) < 300
    called = []
    monkeypatch.setattr(studies, "_call", lambda program, *given: called.append(given) or (_ for _ in ()).throw(studies.StudyError("stop")))
    with pytest.raises(ValueError, match="format='xls': must be parquet or csv"):
        plcfmu.study("study.toml", format="xls")
    assert not called
    # One text is one expectation.
    with pytest.raises(studies.StudyError, match="stop"):
        plcfmu.study("study.toml", expect="overshoot < 10 %")
    assert [text for text in called[0] if text.startswith("--expect")] == ["--expect=overshoot < 10 %"]


def test_the_runs_are_a_data_frame_of_the_library_that_there_is(tmp_path, monkeypatch):
    """With stand-ins for pandas and polars, which tests/requirements.txt does not have: what they are called with."""
    runs = result(tmp_path)
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=lambda table: ("frame", table)))
    kind, table = runs.frame()
    assert kind == "frame" and list(table["C.GAIN"]) == [0.5, 2.0] and list(table["error"]) == ["", "dry"]
    monkeypatch.setitem(sys.modules, "polars", types.SimpleNamespace(DataFrame=lambda columns: columns))
    assert list(runs.frame("polars")) == ["run", "C.GAIN", "iae", "error"]
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(plcfmu.StudyError, match=r"frame\('arrow'\) needs the package pyarrow: pip install pyarrow"):
        runs.frame("arrow")
    with pytest.raises(ValueError, match="must be pandas, polars or arrow"):
        runs.frame("numpy")


def test_a_notebook_shows_the_figures_the_verdicts_and_the_pictures(tmp_path):
    page = result(tmp_path)._repr_html_()
    for text in ["a &lt;b&gt;: 2 runs; 1 failed", "iae &lt; 2: <b>not met</b>: 1 of 2 runs fails", "<td>iae in s</td><td>3</td>"]:
        assert text in page
    assert "<td>3 (run 0)</td>" in page and page.endswith("<svg>curves</svg>")
