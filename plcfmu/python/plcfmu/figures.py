"""Quality figures of a loop, as control engineering defines them.

The functions take arrays: the times in seconds and the values at these times. For the figures of a setpoint step the
arrays begin with the step.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rise_time(time: Array, pv: Array, start: float, end: float) -> float:
    """Time in seconds from 10 % to 90 % of the way from `start` to `end`; NaN if it does not get there."""
    share = (pv - start) / (end - start)
    low, high = (first_crossing(time, share, level) for level in (0.1, 0.9))
    return high - low


def first_crossing(time: Array, values: Array, level: float) -> float:
    """When `values` first reach `level` from below, in seconds, linear between two rows; NaN if they do not."""
    above = np.nonzero(values >= level)[0]
    if len(above) == 0:
        return float("nan")
    i = above[0]
    if i == 0:
        return float(time[0])
    share = (level - values[i - 1]) / (values[i] - values[i - 1])
    return float(time[i - 1] + share * (time[i] - time[i - 1]))


def overshoot(pv: Array, start: float, end: float) -> float:
    """How far the process value goes beyond `end`, in percent of the way from `start`; 0 if it does not."""
    return max(0.0, 100.0 * float(np.max((pv - end) / (end - start))))


def settling_time(time: Array, pv: Array, start: float, end: float, band: float = 0.02) -> float:
    """Time in seconds from the step until the process value stays within `band` of the way (2 %) around `end`.

    NaN if it is outside in the last row.
    """
    outside = np.nonzero(np.abs(pv - end) > band * abs(end - start))[0]
    if len(outside) == 0:
        return 0.0
    if outside[-1] == len(time) - 1:
        return float("nan")
    return float(time[outside[-1] + 1] - time[0])


def integral_absolute_error(time: Array, pv: Array, sp: Array) -> float:
    """IAE: the integral of |sp - pv| over time, each row held until the next; in the unit of `pv` times seconds."""
    return float(np.sum(np.abs(sp - pv)[:-1] * np.diff(time)))


def integral_squared_error(time: Array, pv: Array, sp: Array) -> float:
    """ISE: the integral of (sp - pv)^2 over time, each row held until the next; in the unit of `pv` squared, times s."""
    return float(np.sum(((sp - pv) ** 2)[:-1] * np.diff(time)))


def integral_error(time: Array, pv: Array, sp: Array) -> float:
    """The integral of sp - pv over time, with its sign, each row held until the next; in the unit of `pv` times s."""
    return float(np.sum((sp - pv)[:-1] * np.diff(time)))


def travel(lmn: Array) -> float:
    """How far the manipulated value moves in all, up and down, in its unit."""
    return float(np.sum(np.abs(np.diff(lmn))))


class Figure(NamedTuple):
    """A quality figure: its value, and what theory predicts for it."""

    name: str
    value: Union[float, str]
    unit: str = ""
    theory: Union[None, float, str] = None

    def __str__(self) -> str:
        predicted = "" if self.theory is None else f"   theory {_number(self.theory)} {self.unit}"
        return f"  {self.name:52} {_number(self.value):>9} {self.unit:7}{predicted}".rstrip()


class Figures:
    """Quality figures in their order. `figures["overshoot"]` is the value of one, `print(figures)` a table."""

    def __init__(self, figures: Iterable[Figure] = ()) -> None:
        self._figures = list(figures)

    def add(self, name: str, value: Union[float, str], unit: str = "", theory: Union[None, float, str] = None) -> None:
        """Adds a figure, with what theory predicts for it."""
        self._figures.append(Figure(name, value, unit, theory))

    def __iadd__(self, more: Figures) -> Figures:
        self._figures += more._figures
        return self

    def __getitem__(self, name: str) -> Any:
        for figure in self._figures:
            if figure.name == name:
                return figure.value
        raise KeyError(f"there is no figure {name!r}; there are {', '.join(figure.name for figure in self)}")

    def __iter__(self) -> Iterator[Figure]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)

    def __str__(self) -> str:
        return "\n".join(map(str, self._figures))


def step_figures(
    time: Array,
    pv: Array,
    sp: Array,
    start: float,
    end: float,
    unit: str = "",
    prefix: str = "",
    theory: Sequence[Any] = (None,) * 4,
) -> Figures:
    """The four figures of a setpoint step from `start` to `end`: the integral in `unit`, `prefix` before each name."""
    rise, over, settled, error = theory
    figures = Figures()
    figures.add(f"{prefix}rise time, 10 ... 90 %", rise_time(time, pv, start, end), "s", rise)
    figures.add(f"{prefix}overshoot", overshoot(pv, start, end), "%", over)
    figures.add(f"{prefix}settling time to 2 %", settling_time(time, pv, start, end), "s", settled)
    error_name = f"{prefix}integral of the absolute error"
    figures.add(error_name, integral_absolute_error(time, pv, sp), unit, error)
    return figures


def _number(value: Optional[Any]) -> str:
    if isinstance(value, (int, str)):
        return str(value)
    return f"{value:.3g}" if abs(value or 0.0) < 100 else f"{value:.0f}"
