"""Signals over time: the result of a run."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from .figures import Figures, step_figures
from .files import replacing
from .find import Path

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

# Times that differ by less than this, in seconds, are equal: they are rounded sums of steps.
TOLERANCE = 1e-6


class Signal(NamedTuple):
    """The properties of a signal that a picture needs."""

    unit: Optional[str] = None  # physical unit, such as "degC"
    is_boolean: bool = False
    is_input: bool = False


class Result:
    """Signals over time, all as numbers: the time in seconds, FALSE as 0 and TRUE as 1.

    `result["CONT_C.LMN"]` is a signal and `result.time` the time, each a numpy array with one value per row. `quality`
    may hold figures of the run.
    """

    def __init__(self) -> None:
        self.quality = Figures()
        self._rows: dict[str, list[float]] = {}
        self._arrays: dict[str, NDArray[np.float64]] = {}
        self._signals: dict[str, Signal] = {}

    def describe(self, name: str, unit: Optional[str] = None, is_boolean: bool = False, is_input: bool = False) -> None:
        """Sets the properties of a signal that a picture needs.

        They are its physical unit, such as "degC"; whether it is a Boolean; and whether it is an input of the loop,
        such as a setpoint, which is drawn dashed.
        """
        self._signals[name] = Signal(unit, is_boolean, is_input)

    def signal(self, name: str) -> Signal:
        """The properties set by `describe`."""
        return self._signals.get(name, Signal())

    def add(self, time: float, signals: Optional[Mapping[str, Any]] = None, /, **more_signals: Any) -> None:
        """Adds a row. Raises ValueError if its signals differ from those of other rows, or a value is not a number."""
        row = {"time": time, **(signals or {}), **more_signals}
        values = {name: float(value) for name, value in row.items()}
        if not self._rows:
            self._rows = {name: [] for name in values}
        if values.keys() != self._rows.keys():
            raise ValueError(f"a row with {', '.join(values)} does not match rows with {', '.join(self._rows)}")
        for name, value in values.items():
            self._rows[name].append(value)
        self._arrays.clear()

    @property
    def names(self) -> list[str]:
        """The names of the signals."""
        return [name for name in self._rows if name != "time"]

    def __len__(self) -> int:
        """The number of rows."""
        return len(self._rows["time"]) if self._rows else 0

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._arrays:
            if name not in self._rows:
                raise KeyError(f"no signal {name}; available: {', '.join(self.names)}")
            self._arrays[name] = np.array(self._rows[name])
        return self._arrays[name]

    @property
    def time(self) -> NDArray[np.float64]:
        """The time of each row in seconds."""
        return self["time"]

    def between(self, start: float, end: float) -> Result:
        """A new result with the rows of start <= time < end, in seconds. Times within TOLERANCE of a limit equal it."""
        part = Result()
        part._signals = self._signals
        if self._rows:
            chosen = (self.time >= start - TOLERANCE) & (self.time < end - TOLERANCE)
            part._rows = {name: self[name][chosen].tolist() for name in self._rows}
        return part

    def figures(
        self,
        pv: str,
        sp: str,
        start: Optional[float] = None,
        end: Optional[float] = None,
        *,
        lmn: Optional[str] = None,
        unit: str = "",
        disturbances: Iterable[float] = (),
        prefix: str = "",
        theory: Optional[Mapping[str, Any]] = None,
    ) -> Figures:
        """The quality figures of the setpoint step at the beginning of the rows, see `figures.step_figures`.

        The process value `pv` goes from `start` to `end`; by default, from its first value to the last setpoint. `lmn`
        is the manipulated value; `disturbances` are the times of disturbances. `unit` is the unit of a difference of
        process values, such as "K"; by default, that of `pv`.
        """
        start = float(self[pv][0]) if start is None else start
        end = float(self[sp][-1]) if end is None else end
        of_pv = self.signal(pv).unit or ""
        return step_figures(
            self.time,
            self[pv],
            self[sp],
            start,
            end,
            lmn=None if lmn is None else self[lmn],
            unit=unit or ("K" if of_pv == "degC" else of_pv),
            travel_unit="" if lmn is None else self.signal(lmn).unit or "",
            disturbances=disturbances,
            prefix=prefix,
            theory=theory,
        )

    def to_csv(self, path: Path, digits: Optional[int] = None) -> None:
        """Writes the time and all signals, one row per line.

        `digits` is the number of significant digits; 9 are enough for a REAL. By default, reading the file returns
        bit-identical numbers. The file is written completely or not at all.
        """
        with replacing(path) as beside, open(beside, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(self._rows)
            for row in zip(*self._rows.values()):
                table.writerow([_text(value, digits) for value in row])

    @classmethod
    def from_csv(cls, path: Path) -> Result:
        """Reads a file written by `to_csv`, or any CSV file of numbers with a column "time"."""
        result = cls()
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                time = row.pop("time", None)
                if time is None:
                    raise ValueError(f"{path} has no column named time")
                result.add(float(time), row)
        return result

    def plot(
        self,
        path: Optional[Path] = None,
        panels: Union[None, Sequence[Sequence[str]], Mapping[str, Sequence[str]]] = None,
        title: str = "",
    ) -> Picture:
        """Draws the signals over time, held from row to row, and returns the matplotlib figure.

        `panels` are the names of the signals in each panel, or a mapping from panel labels to them; by default, signals
        with the same unit share a panel, and so do the Booleans. With a path, the picture is written there, as PNG, SVG
        or PDF depending on its suffix; without a suffix, as PNG and SVG.
        """
        from . import plot

        return plot.draw(self, panels or self._panels(), path, title)

    def _panels(self) -> list[list[str]]:
        panels: dict[str, list[str]] = {}
        for name in self.names:
            signal = self.signal(name)
            panels.setdefault("Boolean" if signal.is_boolean else signal.unit or name, []).append(name)
        return list(panels.values())


def _text(value: float, digits: Optional[int]) -> str:
    if digits is not None:
        return f"{value:.{digits}g}"
    text = repr(value)
    return text[:-2] if text.endswith(".0") else text
