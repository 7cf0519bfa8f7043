"""Pictures of loops: the same colour for the same thing in all of them.

matplotlib is loaded with the first picture.

    with plot.picture("loop.png", "Furnace with CONT_C", ["temperature in °C", "LMN in %"]) as axes:
        axes[0].plot(result.time, result["PV"], label="PV", **plot.PROCESS_VALUE)
        axes[1].plot(result.time, result["LMN"], label="LMN", **plot.MANIPULATED)
"""

from __future__ import annotations

import contextlib
import itertools
import pathlib
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Optional

from .files import replacing
from .find import Path

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

    from .result import Result

# How the signals of a loop are drawn: arguments of matplotlib's plot(), or of axvspan() for spans of time.
SETPOINT: dict[str, Any] = {"color": "#333333", "linestyle": (0, (5, 2)), "linewidth": 1.3}
PROCESS_VALUE: dict[str, Any] = {"color": "#0b62a4", "linewidth": 1.8}
MANIPULATED: dict[str, Any] = {"color": "#c8102e", "linewidth": 1.6}
P_PART: dict[str, Any] = {"color": "#e08a00", "linewidth": 1.1}
I_PART: dict[str, Any] = {"color": "#2e8b57", "linewidth": 1.1}
D_PART: dict[str, Any] = {"color": "#8a5fbf", "linewidth": 1.1}
COMPARED: dict[str, Any] = {"color": "#9a9a9a", "linewidth": 1.4}
DISTURBANCE: dict[str, Any] = {"color": "#faf0da", "linewidth": 0}
MANUAL: dict[str, Any] = {"color": "#e6edf5", "linewidth": 0}

# Matplotlib's settings while a picture is drawn.
STYLE: Any = {
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "axes.edgecolor": "#666666",
    "axes.xmargin": 0.0,
}


@contextlib.contextmanager
def picture(
    path: Optional[Path],
    title: str,
    labels: Sequence[str],
    heights: Optional[Sequence[float]] = None,
    size: tuple[float, float] = (9.0, 6.0),
    columns: int = 1,
    same_time: bool = True,
) -> Iterator[Any]:
    """Gives one set of axes under the other to draw on, and writes the picture to `path` at the end.

    `labels` are those of the vertical axes, `heights` their shares of the height; the horizontal axis is the time in
    seconds, shared by all unless `same_time` is False. `size` is in units of 100 pixels. With more than one column the
    axes are an array of rows and columns. The format is that of the suffix, such as .png; None writes no file.
    """
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots(
            len(labels),
            columns,
            sharex="col" if same_time else False,
            sharey="row" if columns > 1 else False,
            squeeze=False,
            gridspec_kw={"height_ratios": heights or [1] * len(labels)},
        )
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
        for row, label in zip(axes, labels):
            row[0].set_ylabel(label)
        for bottom in axes[-1] if same_time else axes.flat:
            bottom.set_xlabel("time in s")
        yield axes[:, 0] if columns == 1 else axes
        if path is not None:
            save(figure, path)


def legend(axes: Any, **options: Any) -> None:
    """A legend above the axes, where it covers no curve."""
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(
        handles,
        labels,
        loc="lower right",
        bbox_to_anchor=(1.005, 1.0),
        ncol=len(labels),
        handlelength=1.8,
        columnspacing=1.4,
        borderaxespad=0.1,
        fontsize=9,
        **options,
    )


def mark(
    axes: Iterable[Any],
    start: float,
    end: float,
    text: str,
    style: Optional[dict[str, Any]] = None,
    at: Optional[tuple[float, float]] = None,
) -> None:
    """Shades a span of time, such as that of a disturbance, in all axes, and names it in the first one.

    The text is at the upper left corner of the span, or at (time, share of the height). `style` is DISTURBANCE by
    default, or MANUAL.
    """
    axes = list(axes)
    style = style or DISTURBANCE
    for each in axes:
        each.axvspan(start, end, zorder=0, **style)
    axes[0].annotate(
        text,
        at or (start, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(4, -4),
        va="top",
        textcoords="offset points",
        fontsize=8.5,
        color="#5a4a20" if style is DISTURBANCE else "#3c5573",
    )


def save(figure: Picture, path: Path) -> None:
    """Writes a picture, 100 pixels to the inch, complete or not at all; the same picture gives the same bytes."""
    options: dict[str, Any] = {}
    if pathlib.Path(path).suffix == ".png":
        options = {"metadata": {"Software": None}, "pil_kwargs": {"optimize": True}}
    with replacing(path) as beside:
        figure.savefig(beside, dpi=100, **options)


def draw(result: Result, panels: Sequence[Sequence[str]], path: Optional[Path], title: str) -> Picture:
    """Draws signals over time, held from row to row, one panel under the other; Booleans as lanes."""
    colors = itertools.cycle(style["color"] for style in (PROCESS_VALUE, MANIPULATED, I_PART, P_PART, D_PART, COMPARED))
    lanes = [all(result.signal(name).is_boolean for name in names) for names in panels]
    labels = ["" if is_lanes else _label(result, names) for is_lanes, names in zip(lanes, panels)]
    heights = [0.2 + 0.15 * len(names) if is_lanes else 1.0 for is_lanes, names in zip(lanes, panels)]
    size = 9.0, max(2.5, 0.7 + 2.0 * sum(heights))
    with picture(path, title, labels, heights, size) as axes:
        for each, names, is_lanes in zip(axes, panels, lanes):
            if is_lanes:
                _draw_lanes(each, result, names)
                continue
            for name in names:
                style = SETPOINT if result.signal(name).is_input else {**PROCESS_VALUE, "color": next(colors)}
                each.plot(result.time, result[name], label=name, drawstyle="steps-post", **style)
            legend(each)
    figure: Picture = axes[0].figure
    return figure


def _draw_lanes(axes: Any, result: Result, names: Sequence[str]) -> None:
    bases = [-1.3 * number for number in range(len(names))]
    for base, name in zip(bases, names):
        color = COMPARED["color"] if result.signal(name).is_input else MANIPULATED["color"]
        axes.fill_between(result.time, base, base + result[name], step="post", color=color, linewidth=0)
    axes.set_yticks([base + 0.5 for base in bases], names)
    axes.set_ylim(bases[-1] - 0.2, 1.2)
    axes.grid(axis="y", visible=False)


def _label(result: Result, names: Sequence[str]) -> str:
    """The label of an axis: the unit, if the signals have one in common, else their names."""
    units = {result.signal(name).unit for name in names} - {None}
    return f"in {units.pop()}" if len(units) == 1 else ", ".join(name.split(".")[-1] for name in names)
