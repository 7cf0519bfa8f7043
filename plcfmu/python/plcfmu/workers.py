"""Studies on the workers of a Dask cluster: the files sent to them, the runs that they make, and how work is
distributed.

Loaded only with the first study, because it needs the package `distributed`.
"""

from __future__ import annotations

import contextlib
import pathlib
import signal
import tempfile
import threading
import time
from collections.abc import Generator, Iterable
from typing import Any, Callable, NamedTuple, Optional

from distributed import Client, Future, KilledWorker, Worker, as_completed, get_worker
from distributed.diagnostics.plugin import WorkerPlugin

from .files import replacing
from .messages import LOGGER
from .parameters import CommandNotFoundError, called, command, reason

# How long one range of runs should keep a worker busy, in seconds: WORK, plus WORK_PER_THREAD for each thread in the
# cluster, so that a large cluster does not request ranges faster than the client can hand them out.
WORK = 2.0
WORK_PER_THREAD = 0.02
# The maximum ratio of a range's size to that of the last measured range.
GROWTH = 16
# How many ranges each thread has at a time: the running one and the next.
OUTSTANDING = 2
# How often a range is retried if a worker could not run it. Dask itself limits retries after a worker has died.
RETRIES = 2
# In a long study, a range should take at least this share of the time elapsed so far, to limit the number of parts.
WORK_SHARE = 0.01
# The interval at which the client queries the number of threads and checks for workers, in seconds.
PATIENCE = 1.0
# A cluster that has been without workers for this many seconds is reported.
LONELY = 5.0
# The folder for the files of studies, in a worker's local directory.
FOLDER = "plcfmu"


class WorkerError(RuntimeError):
    """A worker cannot run a range of runs; the message states why."""


class Span(NamedTuple):
    """The runs from `first` to `end` - 1."""

    first: int
    end: int

    def __str__(self) -> str:
        return f"run {self.first}" if len(range(*self)) == 1 else f"runs {self.first} to {self.end - 1}"


class Task(NamedTuple):
    """The data common to all ranges of a study."""

    fingerprint: str
    # The output of `plcfmu --version`.
    version: str
    # The time limit for one run, in seconds.
    limit: float


class Files(WorkerPlugin):
    """The files of a study's bundle, sent to all current and future workers.

    FMUs are named after their content, so a worker that has an FMU from another study does not get it again.
    """

    # A scheduler that has a plugin with this name does not send it again.
    idempotent = True

    def __init__(self, fingerprint: str, owner: str, bundle: pathlib.Path) -> None:
        self.fingerprint = fingerprint
        # Includes the client's ID, because another client may run the same study, and unregisters its plugin at the
        # end.
        self.name = f"plcfmu-{fingerprint}-{owner}"
        self.contents = {f"fmus/{path.name}": path.read_bytes() for path in sorted((bundle / "fmus").iterdir())}
        self.contents[f"{fingerprint}.json"] = (bundle / "study.json").read_bytes()

    def setup(self, worker: Worker) -> None:
        """Called by Dask on each worker."""
        self.write(folder_of(worker))

    def write(self, folder: pathlib.Path) -> None:
        """Writes the files that are missing from the folder."""
        for name, content in self.contents.items():
            path = folder / name
            if not path.is_file() or path.read_bytes() != content:
                with replacing(path) as beside:
                    beside.write_bytes(content)


class Uninterrupted(WorkerPlugin):
    """Leaves Ctrl-C to the client, which terminates the workers of its own cluster."""

    idempotent = True
    name = "plcfmu-uninterrupted"

    def setup(self, worker: Worker) -> None:
        """Called by Dask in the main thread of each worker's process."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def folder_of(worker: Worker) -> pathlib.Path:
    """The folder in which a worker keeps the files of studies."""
    return pathlib.Path(worker.local_directory) / FOLDER


def run(task: Task, span: Span) -> tuple[bytes, float]:
    """Executes the runs of a range on the calling worker; returns the part with their results, and the time in seconds.

    Raises WorkerError, which names the worker.
    """
    worker = get_worker()
    begin = time.monotonic()
    try:
        return part(worker, task, span), time.monotonic() - begin
    except (WorkerError, OSError) as error:
        raise WorkerError(f"{worker.address}: {error}") from None


def part(worker: Worker, task: Task, span: Span) -> bytes:
    """The results of a range of runs, as written by the command."""
    program = program_of(task.version)
    folder = folder_of(worker)
    # Written again because a worker may run for weeks in a temporary folder, which the system cleans up.
    for plugin in list(worker.plugins.values()):
        if isinstance(plugin, Files) and plugin.fingerprint == task.fingerprint:
            plugin.write(folder)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        file = pathlib.Path(scratch) / "part"
        options = [f"--runs={span.first}..{span.end}", "--jobs=1", f"--time-limit={task.limit}", f"--part={file}"]
        done = called(program, "study", str(folder / f"{task.fingerprint}.json"), *options)
        if done.returncode != 0:
            raise WorkerError(reason(done))
        return file.read_bytes()


def program_of(version: str) -> pathlib.Path:
    """The program plcfmu on this machine. Raises WorkerError if it is missing or has a different version."""
    try:
        program = command()
    except CommandNotFoundError as error:
        raise WorkerError(str(error)) from None
    found = called(program, "--version").stdout.strip()
    if found != version:
        raise WorkerError(
            f"{program} is {found}, but the client has {version}: install the same wheel of plcfmu for the client and all "
            "workers"
        )
    return program


class Share:
    """Divides the remaining runs into ranges: small at first, then large enough to be worth the overhead."""

    def __init__(self, gaps: Iterable[Span]) -> None:
        self._gaps = list(reversed([gap for gap in gaps if gap.first < gap.end]))
        self._size = 1

    def next(self) -> Optional[Span]:
        """The next range, if any run is left."""
        if not self._gaps:
            return None
        gap = self._gaps.pop()
        cut = Span(gap.first, min(gap.first + self._size, gap.end))
        if cut.end < gap.end:
            self._gaps.append(Span(cut.end, gap.end))
        return cut

    def learn(self, span: Span, seconds: float, work: float) -> None:
        """Adapts the size to the time that a range took: the next should take about `work` seconds, including the
        command's start."""
        count = span.end - span.first
        if seconds > 2 * work:
            self._size = max(1, int(count * work / seconds))
        elif seconds < work and count >= self._size:
            # At least twice as many runs: how much of this time the command's start took is unknown.
            self._size = int(count * min(max(work / seconds, 2), GROWTH))


def results(
    client: Client, files: Files, task: Task, gaps: Iterable[Span]
) -> Generator[tuple[Span, bytes], None, None]:
    """Distributes the runs of `gaps` to the workers, and yields the result of each range when it is done.

    If the caller stops early, no more ranges are started. Raises WorkerError, which names the runs.
    """
    begin, share, threads = time.monotonic(), Share(gaps), Threads(client)
    completed = as_completed(loop=client.loop, with_results=True, raise_errors=False)
    pending: dict[Future[Any], Span] = {}
    over = threading.Event()
    threading.Thread(target=watch, args=(Lonely(client), over), daemon=True).start()
    try:
        register(client, files)
        while True:
            while len(pending) < OUTSTANDING * threads.count() and (span := share.next()) is not None:
                # The result depends only on what the key states: if a worker dies, Dask assigns its task to another.
                key = f"plcfmu-{task.fingerprint}-{span.first}-{span.end}"
                future = client.submit(run, task, span, key=key, retries=RETRIES)
                pending[future] = span
                completed.add(future)
            if not pending:
                return
            future, result = next(completed)
            if future.status != "finished":
                # It remains in `pending` and is cancelled: otherwise, Dask would cache the error and return it to the
                # next call.
                raise WorkerError(f"{pending[future]}: {failure(result)}")
            span = pending.pop(future)
            content, seconds = result
            work = max(WORK + WORK_PER_THREAD * threads.count(), WORK_SHARE * (time.monotonic() - begin))
            share.learn(span, seconds, work)
            yield span, content
    finally:
        over.set()
        # If the cluster is gone, or Ctrl-C has ended it too, the resulting error must not hide the original one.
        with contextlib.suppress(Exception):
            client.cancel(list(pending))
            client.unregister_worker_plugin(files.name)


def register(client: Client, files: Files) -> None:
    """Sends the files to the workers. Raises WorkerError if a worker cannot accept them."""
    for attempt in range(1 + RETRIES):
        try:
            client.register_plugin(files)
            return
        except Exception as error:
            # A worker that dies during the call makes it fail for all workers, which is no reason to end the study.
            if not isinstance(error, OSError) or attempt == RETRIES:
                raise WorkerError(
                    f"a worker cannot load the study: {error}; install the same wheel of plcfmu for the client, the "
                    "scheduler and all workers"
                ) from error
            with contextlib.suppress(OSError):
                client.unregister_worker_plugin(files.name)


def failure(result: Any) -> str:
    """Why a task has no result: the exception with which it ended."""
    error = result[1] if isinstance(result, tuple) else result
    if isinstance(error, KilledWorker):
        died = error.allowed_failures + 1
        count = "1 worker died while running it" if died == 1 else f"{died} workers died while running it"
        return f"{count}: see the logs, most recently on {error.last_worker.address} (out of memory?)"
    return str(error) or type(error).__name__


class Threads:
    """The number of threads in the cluster, which may change; at least 1, so that work waits for the first worker."""

    def __init__(self, client: Client, clock: Callable[[], float] = time.monotonic) -> None:
        self._client = client
        self._clock = clock
        self._asked: Optional[float] = None
        self._count = 1

    def count(self) -> int:
        """The number of threads, at most a second old."""
        now = self._clock()
        if self._asked is None or now - self._asked > PATIENCE:
            self._asked = now
            self._count = max(1, sum(self._client.nthreads().values()))
        return self._count


class Lonely:
    """Warns once whenever a cluster has had no workers for five seconds."""

    def __init__(self, client: Client, clock: Callable[[], float] = time.monotonic) -> None:
        self._client = client
        self._clock = clock
        self._since: Optional[float] = clock()

    def look(self) -> None:
        """Checks the cluster; to be called regularly."""
        if self._client.nthreads():
            self._since = None
        elif self._since is None:
            self._since = self._clock()
        elif self._clock() - self._since >= LONELY:
            self._since = float("inf")
            LOGGER.warning("the cluster %s has no workers: the study waits for the first one", self._client.scheduler.address)


def watch(lonely: Lonely, over: threading.Event) -> None:
    """Checks once a second until `over` is set."""
    while not over.wait(PATIENCE):
        # Errors are ignored: if the scheduler does not answer, the study itself reports it.
        with contextlib.suppress(Exception):
            lonely.look()
