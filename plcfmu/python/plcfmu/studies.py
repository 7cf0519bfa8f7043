"""Studies: one loop, run many times with different values, in processes of this machine or on a cluster.

The runs are always made by `plcfmu study`, so the same study yields the same files on any cluster.
"""

from __future__ import annotations

import contextlib
import csv
import hashlib
import html
import json
import math
import pathlib
import re
import tempfile
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from .files import replacing
from .find import Path
from .messages import LOGGER
from .parameters import called, command, reason

if TYPE_CHECKING:
    from distributed import Client

    from .workers import Span


class StudyError(RuntimeError):
    """A study cannot be run or completed; the message states the reason and the remedy."""


@dataclass(frozen=True, repr=False)
class StudyResult:
    """The result of a study: the files in `folder`, and `summary`, the content of its summary.json."""

    folder: pathlib.Path
    summary: dict[str, Any]

    def __repr__(self) -> str:
        expected = f", {len(self.unmet)} of {many} expectations not met" if (many := len(self.summary["expectations"])) else ""
        return f"<StudyResult {str(self.folder)!r}: {self.count} runs, {self.summary['failed']} failed{expected}>"

    @property
    def count(self) -> int:
        """The number of runs."""
        return int(self.summary["runs"])

    @property
    def unmet(self) -> list[str]:
        """The expectations that are not met, one sentence each."""
        return [one["problem"] for one in self.summary["expectations"] if not one["met"]]

    @property
    def errors(self) -> dict[int, str]:
        """The errors of failed runs, by run number."""
        if not self.summary["failed"]:
            return {}
        table = self.table()
        return {int(run): error for run, error in zip(table["run"], table["error"]) if error}

    def table(self) -> NDArray[np.void]:
        """One row per run: its number, input values, figures (NaN for a figure without a value) and error.

        `frame()` returns the same table for pandas or polars. Raises StudyError if the file is runs.parquet and the
        package pyarrow is missing.
        """
        columns = _parquet(path) if (path := self.folder / "runs.parquet").is_file() else _csv(self.folder / "runs.csv")
        kinds: dict[str, Any] = {"run": np.int64, "loop": object, "error": object}
        table = np.empty(len(columns["run"]), [(name, kinds.get(name, np.float64)) for name in columns])
        for name, column in columns.items():
            table[name] = column
        return table

    def frame(self, library: str = "pandas") -> Any:
        """The same table as a data frame of "pandas" or "polars", or as a pyarrow.Table for "arrow".

        A file runs.parquet is passed through Arrow without copying if the library supports it. Raises StudyError if the
        package is missing, and ValueError for any other library.
        """
        if library not in ("pandas", "polars", "arrow"):
            raise ValueError(f"library={library!r}: must be pandas, polars or arrow")
        try:
            if library == "arrow" or (self.folder / "runs.parquet").is_file():
                return _from_arrow(_arrow(self), library)
            if library == "pandas":
                import pandas

                return pandas.DataFrame(self.table())
            import polars

            table = self.table()
            return polars.DataFrame({name: table[name] for name in table.dtype.names or ()})
        except ModuleNotFoundError as error:
            raise StudyError(f"frame({library!r}) needs the package {error.name}: pip install {error.name}") from error

    def _repr_html_(self) -> str:
        """The display in a notebook: expectations, percentiles of each figure, and pictures of the main figure."""
        summary, text = self.summary, html.escape
        failed = f"; {summary['failed']} failed" if summary["failed"] else ""
        parts = [f"<h3>{text(summary['study'])}: {summary['runs']} runs{failed}</h3>"]
        for one in summary["expectations"]:
            word = "undecided" if one.get("undecided") else "not met"
            verdict = "met" if one["met"] else f"<b>{word}</b>: {text(one['problem'])}"
            parts.append(f"<p>{text(one['expectation'])}: {verdict}</p>")
        parts.append("<table><tr><th>Figure</th><th>5 %</th><th>Median</th><th>95 %</th><th>Worst run</th></tr>")
        for figure in summary["figures"]:
            # The same notation as in the pictures below.
            unit = f" in {figure['unit']}".replace("degC", "°C") if figure["unit"] else ""
            numbers = [figure["percentiles"].get(name) for name in ("p5", "p50", "p95")]
            cells = [text(figure["name"] + unit), *("" if number is None else f"{number:.6g}" for number in numbers)]
            worst = figure["worst"][:1]
            cells += [f"{one['value']:.6g} (run {one['run']})" for one in worst] or [""]
            parts.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        parts.append("</table>")
        for name in ("curves", "tornado", "scatter"):
            with contextlib.suppress(FileNotFoundError):
                parts.append((self.folder / "pictures" / f"{name}.svg").read_text(encoding="utf-8"))
        return "\n".join(parts)


def _arrow(result: StudyResult) -> Any:
    """The runs as an Arrow table. Raises ModuleNotFoundError without pyarrow."""
    import pyarrow
    from pyarrow import parquet

    path = result.folder / "runs.parquet"
    if path.is_file():
        return parquet.read_table(path)
    table = result.table()
    return pyarrow.table({name: list(table[name]) for name in table.dtype.names or ()})


def _from_arrow(table: Any, library: str) -> Any:
    """Converts an Arrow table to a data frame."""
    if library == "pandas":
        return table.to_pandas()
    if library == "polars":
        import polars

        return polars.from_arrow(table)
    return table


def _csv(path: pathlib.Path) -> dict[str, Sequence[Any]]:
    with path.open(newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    columns: dict[str, Sequence[Any]] = dict(zip(names, zip(*rows)))
    return {
        name: column if name in ("loop", "error") else [float(text) if text else math.nan for text in column]
        for name, column in columns.items()
    }


def _parquet(path: pathlib.Path) -> dict[str, Sequence[Any]]:
    try:
        from pyarrow import parquet
    except ModuleNotFoundError as error:
        raise StudyError(
            f"reading {path} needs the package pyarrow: pip install pyarrow, or run the study with "
            'format="csv"'
        ) from error
    table = parquet.read_table(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def study(
    path: Path,
    out: Union[Path, None] = None,
    *,
    client: Union[Client, str, None] = None,
    fmus: Union[Path, None] = None,
    expect: Union[str, Sequence[str]] = (),
    curves: Sequence[int] = (),
    limit: float = 300.0,
    resume: bool = False,
    format: str = "parquet",
    progress: bool = True,
) -> StudyResult:
    """Runs a study on a Dask cluster: study("tolerance.toml", client="tcp://10.0.0.5:8786").

    `path` is a study.toml, or the study.json of a bundle. `out` is the folder for the results; by default, NAME_results
    in the current folder. The final results are identical to those of `plcfmu study` on one machine, to the last byte.

    - `client`: where the study runs. A Dask `Client`; the address of a scheduler; or None for a cluster on this
      machine's cores, which is closed at the end.
    - `fmus`: the folder of the loop's FMUs; by default, that of the loop's description.
    - `expect`: one or several expectations of the runs, such as "overshoot < 10 %"; `StudyResult.unmet` lists those
      that are not met.
    - `curves`: the numbers of the runs whose signals over time are also written.
    - `limit`: the time limit for one run, in seconds (0.1 to 1e6), after which its FMU is considered hung.
    - `resume`: continues an earlier, interrupted call with the same `out`. Finished runs are not repeated.
    - `format`: the format of the run table, "parquet" or "csv".
    - `progress`: shows a progress bar.

    The cluster needs this package, including the program, in the same version everywhere. A worker that dies costs only
    time: Dask assigns its runs to another worker. If the call ends early, the finished runs are kept in `out`.

    Raises StudyError, ValueError for any other format, CommandNotFoundError if the command `plcfmu` is not found, and
    ModuleNotFoundError without Dask.
    """
    # Checked first, because the command gets the format only after all runs.
    if format not in ("parquet", "csv"):
        raise ValueError(f"format={format!r}: must be parquet or csv")
    expectations = [expect] if isinstance(expect, str) else list(expect)
    try:
        from . import workers
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in ("dask", "distributed"):
            raise
        raise ModuleNotFoundError(
            "studies need Dask's package distributed: pip install 'plcfmu[dask]', or run `plcfmu study`, "
            "which needs no packages",
            name=error.name,
        ) from error
    program = command()
    given = ["study", str(path), f"--time-limit={limit}", *(f"--expect={text}" for text in expectations)]
    if fmus is not None:
        given.append(f"--fmus={fmus}")
    if curves:
        given.append(f"--curves={','.join(map(str, curves))}")
    with tempfile.TemporaryDirectory() as scratch:
        bundle = pathlib.Path(scratch) / "bundle"
        _call(program, *given, f"--bundle={bundle}")
        description = json.loads((bundle / "study.json").read_text(encoding="utf-8"))
        folder = pathlib.Path(f"{description['name']}_results" if out is None else out)
        parts = _Parts(folder / "parts", description["fingerprint"], description["runs"])
        parts.check(resume)
        if gaps := [] if resume and parts.are_finished() else parts.gaps():
            task = workers.Task(description["fingerprint"], _call(program, "--version"), limit)
            try:
                with _connected(client) as connected:
                    files = workers.Files(task.fingerprint, connected.id, bundle)
                    _collect(parts, workers.results(connected, files, task, gaps), progress)
            except KeyboardInterrupt:
                LOGGER.warning("interrupted; %s", parts)
                raise
            except Exception as error:
                raise StudyError(f"{error}; {parts}") from error
    done = called(program, *given, f"--out={folder}", "--resume", f"--format={format}")
    # The command removes the parts once it has written all files. If it fails after that, the reason is in the summary:
    # failed runs, or expectations that are not met.
    if done.returncode != 0 and parts.folder.exists():
        raise StudyError(f"{reason(done)}; {parts}")
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return StudyResult(folder, summary)


def _call(program: pathlib.Path, *arguments: str) -> str:
    """The command's output; its warnings go to the logger. Raises StudyError with its error if it fails."""
    done = called(program, *arguments)
    if done.returncode != 0:
        raise StudyError(reason(done))
    for line in done.stderr.strip().splitlines():
        LOGGER.warning("%s", line)
    return done.stdout.strip()


@contextlib.contextmanager
def _connected(client: Union[Client, str, None]) -> Iterator[Client]:
    """A client of the caller's cluster; everything created here is closed at the end."""
    from dask.system import CPU_COUNT
    from distributed import Client, LocalCluster

    from .workers import Uninterrupted

    with contextlib.ExitStack() as stack:
        if isinstance(client, Client):
            mine = client
        elif client is not None:
            mine = stack.enter_context(Client(client, set_as_default=False))
        else:
            local = LocalCluster(n_workers=CPU_COUNT, threads_per_worker=1, processes=True, dashboard_address=None)
            mine = stack.enter_context(Client(stack.enter_context(local), set_as_default=False))
            mine.register_plugin(Uninterrupted())
        if mine.asynchronous:
            raise StudyError("the client is asynchronous, but a study waits for its runs: use Client(asynchronous=False)")
        yield mine


class _Parts:
    """The finished runs of a study: files `FIRST-END.part`, each with the rows of the runs FIRST to END - 1."""

    def __init__(self, folder: pathlib.Path, fingerprint: str, count: int) -> None:
        self.folder = folder
        self.fingerprint = fingerprint
        self.count = count

    def __str__(self) -> str:
        return f"the finished runs are kept in {self.folder}: continue with study(..., resume=True)"

    def check(self, resume: bool) -> None:
        """Raises StudyError for parts of another study, or for any parts unless the study is resumed."""
        for path in sorted(self.folder.glob("*.part")):
            if not resume:
                raise StudyError(
                    f"{self.folder} has runs of an earlier call: continue with resume=True, or remove the folder"
                )
            with path.open("rb") as file:
                # The file begins with a line of text and a line of JSON.
                _, header = file.readline(), file.readline()
            if f'"fingerprint":"{self.fingerprint}"'.encode() not in header:
                raise StudyError(
                    f"{path} belongs to another study, or the study, an FMU or plcfmu has changed since; remove "
                    f"{self.folder}, or choose another folder"
                )

    def are_finished(self) -> bool:
        """Whether the results of this study already exist. Raises StudyError for results of another study."""
        results = self.folder.parent
        try:
            summary = json.loads((results / "summary.json").read_text(encoding="utf-8"))
        except FileNotFoundError:
            return False
        with contextlib.suppress(KeyError, FileNotFoundError):
            table = summary["table"]
            digest = hashlib.sha256((results / table["file"]).read_bytes()).hexdigest()
            if (summary["fingerprint"], table["sha256"]) == (self.fingerprint, digest):
                return True
        if any(self.folder.glob("*.part")):
            return False
        raise StudyError(
            f"{results} contains the results of another study, or the study, an FMU, plcfmu or the run table has changed since; "
            "choose another folder, or start over without resume=True"
        )

    def gaps(self) -> list[Span]:
        """The ranges of runs that are not in any part."""
        from .workers import Span

        names = (re.fullmatch(r"(\d+)-(\d+)\.part", path.name) for path in self.folder.glob("*.part"))
        gaps, next_run = [], 0
        for first, end in [*sorted((int(name[1]), int(name[2])) for name in names if name), (self.count, self.count)]:
            if first > next_run:
                gaps.append(Span(next_run, first))
            next_run = max(next_run, end)
        return gaps

    def add(self, span: Span, content: bytes) -> None:
        """Writes a part, completely or not at all."""
        with replacing(self.folder / f"{span.first}-{span.end}.part") as beside:
            beside.write_bytes(content)


def _collect(parts: _Parts, results: Generator[tuple[Span, bytes], None, None], progress: bool) -> None:
    """Writes each part as it arrives."""
    from tqdm.auto import tqdm

    left = sum(end - first for first, end in parts.gaps())
    with contextlib.closing(results), tqdm(
        total=parts.count, initial=parts.count - left, unit=" runs", disable=not progress
    ) as bar:
        for span, content in results:
            parts.add(span, content)
            bar.update(span.end - span.first)
