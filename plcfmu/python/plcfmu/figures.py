"""Quality figures of a loop, computed by the command `plcfmu`, as in the parameter tool and in studies.

The functions take arrays: the times in seconds and the values at these times.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from .parameters import called, command, reason

Array = NDArray[np.float64]


def integral_error(time: Array, pv: Array, sp: Array) -> float:
    """The signed integral of sp - pv over time, each row held until the next, in the unit of `pv` times s."""
    return float(np.sum((sp - pv)[:-1] * np.diff(time)))


class Figure(NamedTuple):
    """A quality figure: its value, and the value predicted by theory, if any."""

    name: str
    value: Union[float, str]
    unit: str = ""
    theory: Union[None, float, str] = None

    def __str__(self) -> str:
        predicted = "" if self.theory is None else f"   theory {_number(self.theory)} {self.unit}"
        return f"  {self.name:52} {_number(self.value):>9} {self.unit:7}{predicted}".rstrip()


class Figures:
    """Quality figures in the order in which they were added. `figures["overshoot"]` is the value of one figure;
    `print(figures)` prints a table."""

    def __init__(self, figures: Iterable[Figure] = ()) -> None:
        self._figures = list(figures)

    def add(self, name: str, value: Union[float, str], unit: str = "", theory: Union[None, float, str] = None) -> None:
        """Adds a figure, optionally with the value predicted by theory."""
        self._figures.append(Figure(name, value, unit, theory))

    def __iadd__(self, more: Figures) -> Figures:
        self._figures += more._figures
        return self

    def __getitem__(self, name: str) -> Any:
        for figure in self._figures:
            if figure.name == name:
                return figure.value
        raise KeyError(f"no figure {name!r}; available: {', '.join(figure.name for figure in self)}")

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
    *,
    lmn: Optional[Array] = None,
    unit: str = "",
    travel_unit: str = "",
    disturbances: Iterable[float] = (),
    prefix: str = "",
    theory: Optional[Mapping[str, Any]] = None,
) -> Figures:
    """The figures of a setpoint step from `start` to `end` at the beginning of the arrays.

    They have the same names as in the parameter tool and in studies: rise, overshoot, settling, iae, ise and peak, and
    with the manipulated value `lmn` also travel. `disturbances` are the times of disturbances of the loop: the figures
    of the step end at the first, and recovery, disturbed_peak and disturbed_iae describe the last. A figure without a
    value is NaN, such as the settling time of a loop that has not settled. `unit` is the unit of the process value,
    such as "K", `travel_unit` that of `lmn`; `prefix` is prepended to each name; `theory` maps names to predicted
    values.

    Raises CommandNotFoundError if the command `plcfmu`, which computes the figures, is not found.
    """
    recorded = {
        "times": np.asarray(time, float).tolist(),
        "setpoint": _numbers(sp),
        "process_value": _numbers(pv),
        "manipulated_value": _numbers(() if lmn is None else lmn),
        "step": (float(start), float(end)),
        "disturbances": [float(at) for at in disturbances],
        "unit": unit or None,
        "travel_unit": travel_unit or None,
    }
    done = called(command(), "figures", given=json.dumps(recorded))
    if done.returncode != 0:
        raise ValueError(reason(done))
    predicted = dict(theory or {})
    figures = Figures()
    for told in json.loads(done.stdout):
        value = math.nan if told["value"] is None else told["value"]
        figures.add(prefix + told["key"], value, told["unit"] or "", predicted.pop(told["key"], None))
    if predicted:
        raise ValueError(f"theory has unknown figures: {', '.join(predicted)}")
    return figures


def _numbers(values: Any) -> list[Optional[float]]:
    return [value if math.isfinite(value) else None for value in np.asarray(values, float).tolist()]


def _number(value: Optional[Any]) -> str:
    if isinstance(value, (int, str)):
        return str(value)
    return f"{value:.3g}" if abs(value or 0.0) < 100 else f"{value:.0f}"
