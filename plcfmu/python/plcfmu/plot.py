"""Pictures of loops for reports, with consistent colours.

matplotlib is loaded with the first picture.

    with plot.picture("loop", "The furnace settles in 76 s", ["temperature in °C", "LMN in %"]) as axes:
        axes[0].plot(result.time, result["PV"], label="PV", **plot.PROCESS_VALUE)
        axes[1].plot(result.time, result["LMN"], label="LMN", **plot.MANIPULATED)
        for each in axes:
            plot.legend(each)
"""

from __future__ import annotations

import contextlib
import itertools
import math
import pathlib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from .files import replacing
from .find import Path

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from numpy.typing import NDArray

    from .result import Result

# The colours of curves, as in the charts and pages of this project.
PALETTE = (pathlib.Path(__file__).parent / "palette.css").read_text(encoding="utf-8")


def color(number: int) -> str:
    """The colour of a curve on a light background; `number` begins at 1."""
    found = re.search(rf"--curve-{number}-light: (#\w+);", PALETTE)
    assert found, number
    return found[1]


# How the signals of a loop are drawn: arguments of matplotlib's plot(). The colours are from Okabe and Ito, which
# people with any kind of colour blindness can tell apart; two are darker here, for contrast on white. The charts on the
# FMUs' pages use the same colours for the parts of LMN.
SETPOINT: dict[str, Any] = {"color": "#333333", "linestyle": (0, (4, 2)), "linewidth": 1.1}
PROCESS_VALUE: dict[str, Any] = {"color": color(1), "linewidth": 1.6}
MANIPULATED: dict[str, Any] = {"color": color(2), "linewidth": 1.4}
P_PART: dict[str, Any] = {"color": color(4), "linewidth": 1.2}
I_PART: dict[str, Any] = {"color": color(3), "linewidth": 1.2}
D_PART: dict[str, Any] = {"color": color(5), "linewidth": 1.2}
# A signal for comparison, such as the same signal with other settings.
COMPARED: dict[str, Any] = {"color": "#8c8c8c", "linewidth": 1.2}

# How pulses are drawn: arguments of pulses() and fill_between(). The second style is for the opposite pulses: cooling
# as opposed to heating, closing as opposed to opening.
PULSE: dict[str, Any] = {"color": MANIPULATED["color"], "linewidth": 0.3}
OPPOSITE_PULSE: dict[str, Any] = {"color": color(6), "linewidth": 0.3}

# How time spans are shaded: arguments of mark().
SPAN: dict[str, Any] = {"color": "#f6eedb", "linewidth": 0}
MANUAL: dict[str, Any] = {"color": "#e3ecf5", "linewidth": 0}

# The size of a picture in inches (16:9), and the resolution of PNG files in pixels per inch.
SIZE = (8.0, 4.5)
DOTS_PER_INCH = 200

# The matplotlib settings for drawing a picture.
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "axes.edgecolor": "#666666",
    "axes.xmargin": 0.0,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "figure.constrained_layout.h_pad": 0.05,
    "figure.constrained_layout.w_pad": 0.06,
    "figure.dpi": DOTS_PER_INCH,
    # The same picture yields the same bytes.
    "svg.hashsalt": "plcfmu",
}
TEXT_COLOR = "#4d4d4d"


@contextlib.contextmanager
def picture(
    path: Optional[Path],
    title: str,
    labels: Sequence[str],
    heights: Optional[Sequence[float]] = None,
    size: tuple[float, float] = SIZE,
    columns: int = 1,
    same_time: bool = True,
) -> Iterator[Any]:
    """Yields axes to draw on, stacked vertically, and writes the picture to `path` at the end.

    `title` is the picture's heading. `labels` are the labels of the vertical axes, with units; they are placed above
    the axes. `heights` are the shares of the height. The horizontal axis is the time in seconds, shared by all axes
    unless `same_time` is False. `size` is in inches. With more than one column, the axes are an array of rows and
    columns, with one label per row. The formats are the same as for `save`; None writes no file.
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
        figure.suptitle(title, x=0.012, ha="left", fontsize=10.5, fontweight="bold")
        for row, text in zip(axes, labels):
            label(row[0], text)
        for bottom in axes[-1] if same_time else axes.flat:
            bottom.set_xlabel("time in s")
        yield axes[:, 0] if columns == 1 else axes
        for each in axes.flat:
            _end_at_tick(each)
        if path is not None:
            save(figure, path)


def _end_at_tick(axes: Any) -> None:
    """Extends the horizontal axis to a tick if, with a round spacing, one is less than 1 % beyond the data.

    For example, an axis ends at 600 s if the last row is at 599 s, since that row is held until 600 s.
    """
    from matplotlib.ticker import FixedLocator, MultipleLocator

    left, right = axes.get_xlim()
    if isinstance(axes.xaxis.get_major_locator(), FixedLocator):
        return
    power = 10.0 ** math.floor(math.log10((right - left) / 10.0))
    for factor in (1, 2, 5, 10, 2.5, 3, 4, 6, 8):
        step = factor * power
        last = math.ceil(right / step - 1e-6) * step
        is_tick = abs(left / step - round(left / step)) < 1e-6
        if is_tick and last - right < 0.01 * (right - left) and 4.9 < (last - left) / step < 10.1:
            axes.set_xlim(right=last)
            axes.xaxis.set_major_locator(MultipleLocator(step))
            return


def label(axes: Any, text: str) -> None:
    """Places the label of the vertical axis above the axis, where it has room and need not be rotated."""
    from matplotlib.transforms import ScaledTranslation

    above = axes.transAxes + ScaledTranslation(0.0, 3.5 / 72.0, axes.figure.dpi_scale_trans)
    axes.set_ylabel(text, rotation=0, ha="left", va="bottom")
    axes.yaxis.set_label_coords(0.0, 1.0, transform=above)


def legend(axes: Any, **options: Any) -> None:
    """Adds a legend above the axes on the right, where it covers no curve."""
    handles, labels = axes.get_legend_handles_labels()
    settings = {
        "loc": "lower right",
        "bbox_to_anchor": (1.0, 1.0),
        "ncol": len(labels),
        "handlelength": 1.8,
        "columnspacing": 1.4,
        "borderpad": 0.0,
        "borderaxespad": 0.35,
    }
    axes.legend(handles, labels, **{**settings, **options})


def mark(
    axes: Iterable[Any],
    start: float,
    end: float,
    text: str,
    style: Optional[dict[str, Any]] = None,
    at: Optional[tuple[float, float]] = None,
) -> None:
    """Shades a time span, such as manual mode, in all axes, and labels it in the first.

    The text is in the upper left corner of the span, or at `at`: (time, share of the height). `style` is SPAN by
    default, or MANUAL.
    """
    axes = list(axes)
    for each in axes:
        each.axvspan(start, end, zorder=0, **(style or SPAN))
    _name(axes[0], text, at or (start, 1.0))


def event(axes: Iterable[Any], time: float, text: str, height: float = 1.0) -> None:
    """Draws a line in all axes at the time of an event, such as a disturbance, and its name in the first.

    The text is to the right of the line; `height` is the height of its upper edge, as a share of the axes' height.
    """
    axes = list(axes)
    for each in axes:
        each.axvline(time, zorder=1, color=TEXT_COLOR, linewidth=0.9, linestyle=(0, (1, 1.5)))
    _name(axes[0], text, (time, height))


def _name(axes: Any, text: str, at: tuple[float, float]) -> None:
    place = {"xycoords": ("data", "axes fraction"), "xytext": (4, -3), "textcoords": "offset points"}
    axes.annotate(text, at, va="top", fontsize=8.5, linespacing=1.1, color=TEXT_COLOR, **place)


def pulses(
    axes: Any,
    time: NDArray[np.float64],
    signal: NDArray[np.float64],
    base: float = 0.0,
    height: float = 1.0,
    **style: Any,
) -> None:
    """Draws a Boolean signal as bars from `base`, `height` high; each value is held until the next time."""
    is_on = np.concatenate([[False], np.asarray(signal) > 0.5, [False]])
    starts, ends = np.flatnonzero(np.diff(is_on)).reshape(-1, 2).T
    # The last value has no duration.
    until = np.append(time, time[-1:])
    spans = np.column_stack([time[starts], until[ends] - time[starts]])
    axes.broken_barh(spans, (base, height), **style)


def save(figure: Picture, path: Path) -> None:
    """Writes a picture in the format of the path's suffix; without a suffix, as .png and as .svg.

    A PNG has 200 pixels per inch. Each file is written completely or not at all, and the same picture yields the same
    bytes.
    """
    import matplotlib

    path = pathlib.Path(path)
    for each in [path] if path.suffix else [path.with_suffix(".png"), path.with_suffix(".svg")]:
        options: dict[str, Any] = {}
        if each.suffix == ".png":
            options = {"metadata": {"Software": None}, "pil_kwargs": {"optimize": True}}
        elif each.suffix == ".svg":
            options = {"metadata": {"Date": None, "Creator": None, "Title": figure.get_suptitle().replace("\n", " ")}}
        elif each.suffix == ".pdf":
            options = {"metadata": {"CreationDate": None}}
        with replacing(each) as beside, matplotlib.rc_context(STYLE), _settled(figure):
            figure.savefig(beside, dpi=DOTS_PER_INCH, **options)


@contextlib.contextmanager
def _settled(figure: Picture) -> Iterator[None]:
    """Rounds the positions of the axes while a picture is drawn.

    The computed layout differs in the last bits from run to run, which would change the names in an SVG.
    """
    engine = figure.get_layout_engine()
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(tuple(round(number, 6) for number in axes.get_position().bounds))
        axes.set_in_layout(True)
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def draw(
    result: Result,
    panels: Union[Sequence[Sequence[str]], Mapping[str, Sequence[str]]],
    path: Optional[Path],
    title: str,
) -> Picture:
    """Draws signals over time, held from row to row, in panels below each other; Booleans as lanes.

    `panels` are the signals of each panel, or a mapping from its label to them.
    """
    colors = itertools.cycle(style["color"] for style in (PROCESS_VALUE, MANIPULATED, I_PART, P_PART, D_PART, COMPARED))
    if isinstance(panels, Mapping):
        labels, panels = list(panels), list(panels.values())
    else:
        labels = [_label(result, names) for names in panels]
    lanes = [all(result.signal(name).is_boolean for name in names) for names in panels]
    heights = [0.2 + 0.15 * len(names) if is_lanes else 1.0 for is_lanes, names in zip(lanes, panels)]
    # More than three panels need more height than 16:9 allows.
    size = SIZE[0], max(SIZE[1], 0.9 + 1.2 * sum(heights))
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
        style = {**PULSE, "color": COMPARED["color"]} if result.signal(name).is_input else PULSE
        pulses(axes, result.time, result[name], base, **style)
    axes.set_yticks([base + 0.5 for base in bases], names)
    axes.set_ylim(bases[-1] - 0.2, 1.2)
    axes.set_xlim(result.time[0], result.time[-1])
    axes.grid(axis="y", visible=False)


def _label(result: Result, names: Sequence[str]) -> str:
    """The label of an axis: the common unit of the signals, otherwise their names; empty for Booleans."""
    if all(result.signal(name).is_boolean for name in names):
        return ""
    units = {result.signal(name).unit for name in names} - {None}
    return (
        f"in {units.pop()}".replace("degC", "°C")
        if len(units) == 1
        else ", ".join(name.split(".")[-1] for name in names)
    )
