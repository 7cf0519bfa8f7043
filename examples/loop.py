"""What the closed loops share: FMUs opened by name, a table of what they did, quality figures, CSV
and pictures.

Every loop is wired like a PLC program. In each communication step, which is the controller's CYCLE,
first the controller is stepped from t to t + CYCLE: its call at t sees the process value of t. Then
the plant is stepped over the same time with the manipulated value that this call has given. Stepped
the other way round the loop works too, but has one CYCLE more of dead time.
"""

import argparse
import csv
import difflib
import os
import pathlib
import shutil
import sys
import tempfile
import time

import fmpy
import fmpy.fmi2
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]


class Fmus:
    """The FMUs of a folder.

    with Fmus("target/fmu") as fmus:
        furnace = fmus.start("HEATER", T_START=170.0)
    """

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.unpacked = {}
        self.instances = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def start(self, fmu, settings=None, start_time=0.0, **more_settings):
        """A new instance of FMU.fmu with these start values, after its restart call.

        Names with a dot go into `settings`: {"DI_CONT_C.GAIN": 2.0}.
        """
        if fmu not in self.unpacked:
            path = self.folder / f"{fmu}.fmu"
            if not path.is_file():
                raise SystemExit(
                    f"there is no {path}: make it with `cargo xtask fmu {fmu}`, or name another folder with --fmu"
                )
            self.unpacked[fmu] = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
        instance = Instance(
            fmu, *self.unpacked[fmu], start_time, {**(settings or {}), **more_settings}
        )
        self.instances.append(instance)
        return instance

    def close(self):
        """Frees all instances."""
        for instance in self.instances:
            instance.slave.terminate()
            instance.slave.freeInstance()
        for _, folder in self.unpacked.values():
            shutil.rmtree(folder, ignore_errors=True)
        self.instances, self.unpacked = [], {}


class Instance:
    """One FMU that runs: `furnace["TEMP"]` reads, `furnace.step(t, h, POWER=50.0)` sets inputs and steps."""

    def __init__(self, fmu, description, folder, start_time, settings):
        self.fmu = fmu
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.slave = fmpy.fmi2.FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folder,
            instanceName=fmu,
        )
        slave = self.slave
        self.setters = {
            "Real": (slave.setReal, float),
            "Integer": (slave.setInteger, int),
            "Boolean": (slave.setBoolean, bool),
        }
        self.getters = {
            "Real": slave.getReal,
            "Integer": slave.getInteger,
            "Boolean": slave.getBoolean,
        }
        slave.instantiate(loggingOn=True)
        slave.setupExperiment(startTime=start_time)
        self.set(**settings)
        slave.enterInitializationMode()
        slave.exitInitializationMode()

    def variable(self, name):
        if name not in self.variables:
            near = difflib.get_close_matches(name, self.variables, 1)
            hint = f"; did you mean {near[0]}?" if near else f": it has {', '.join(self.variables)}"
            raise KeyError(f"{self.fmu} has no variable {name}{hint}")
        return self.variables[name]

    def __getitem__(self, name):
        variable = self.variable(name)
        return self.getters[variable.type]([variable.valueReference])[0]

    def get(self, names):
        """Several variables by name: get("LMN LMN_P LMN_I")."""
        return {name: self[name] for name in names.split()}

    def set(self, **values):
        for name, value in values.items():
            variable = self.variable(name)
            setter, convert = self.setters[variable.type]
            setter([variable.valueReference], [convert(value)])

    def step(self, t, h, **inputs):
        """Sets inputs and steps from t to t + h."""
        self.set(**inputs)
        self.slave.doStep(t, h)


def clock(duration, step, what):
    """The times 0, step, 2 step ... before `duration`, with a progress bar if somebody is watching."""
    count = round(duration / step)
    watched = sys.stderr.isatty()
    shown, started = -1, time.monotonic()
    for number in range(count):
        percent = 100 * number // count
        if watched and percent != shown:
            shown = percent
            bar = "#" * (percent // 4)
            print(f"\r{what:40} |{bar:25}| {percent:3} %", end="", file=sys.stderr, flush=True)
        yield number * step
    if watched:
        print(
            f"\r{what:40} |{'#' * 25}| 100 %  {time.monotonic() - started:.1f} s", file=sys.stderr
        )


class Result:
    """What a run of a loop gives: the time in seconds, the signals over it, and the quality figures.

    A row holds what the controller saw and gave in its call at that time.
    """

    def __init__(self):
        self.rows = []
        self.figures = []
        self.columns = None

    def add(self, time, **signals):
        self.rows.append({"time": time, **signals})
        self.columns = None

    def __getitem__(self, name):
        if self.columns is None:
            self.columns = {
                key: np.array([float(row[key]) for row in self.rows]) for key in self.rows[0]
            }
        return self.columns[name]

    @property
    def time(self):
        return self["time"]

    def between(self, start, end):
        """The rows of start <= time < end, as a result of its own. Rounding of the times does not matter."""
        part = Result()
        part.rows = [row for row in self.rows if start - 1e-6 <= row["time"] < end - 1e-6]
        return part

    def figure(self, name, value, unit, theory=None):
        """Adds a quality figure, with what control theory predicts for it."""
        self.figures.append((name, value, unit, theory))

    def step_figures(self, part, pv, sp, start, end, unit, prefix="", theory=(None,) * 4):
        """Adds the four figures of a setpoint step from `start` to `end`, which `part` begins with: rise
        time, overshoot, settling time and integral of the absolute error, the last in `unit`."""
        for name, value, its_unit, predicted in (
            ("rise time, 10 ... 90 %", rise_time(part, pv, start, end), "s", theory[0]),
            ("overshoot", overshoot(part, pv, start, end), "%", theory[1]),
            ("settling time to 2 %", settling_time(part, pv, start, end), "s", theory[2]),
            ("integral of the absolute error", absolute_error(part, pv, sp), unit, theory[3]),
        ):
            self.figure(prefix + name, value, its_unit, predicted)

    def value(self, name):
        """A quality figure by name."""
        return {figure[0]: figure[1] for figure in self.figures}[name]

    def print_figures(self):
        for name, value, unit, theory in self.figures:
            predicted = "" if theory is None else f"   theory {number(theory)} {unit}"
            print(f"  {name:52} {number(value):>9} {unit:7}{predicted}".rstrip())


def number(value):
    return (
        str(value)
        if isinstance(value, (int, str))
        else f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"
    )


# Quality figures of a setpoint step, as control engineering defines them. `result` begins with the step.


def rise_time(result, pv, start, end):
    """From 10 % to 90 % of the way from `start` to `end`."""
    share = (result[pv] - start) / (end - start)
    reached = [first_crossing(result.time, share, level) for level in (0.1, 0.9)]
    return reached[1] - reached[0]


def first_crossing(times, values, level):
    """When `values` first reach `level`, between two rows by straight line."""
    above = np.nonzero(values >= level)[0]
    if len(above) == 0:
        return float("nan")
    i = above[0]
    if i == 0:
        return times[0]
    return times[i - 1] + (level - values[i - 1]) / (values[i] - values[i - 1]) * (
        times[i] - times[i - 1]
    )


def overshoot(result, pv, start, end):
    """How far beyond `end`, in percent of the way from `start`."""
    return max(0.0, 100.0 * float(np.max((result[pv] - end) / (end - start))))


def settling_time(result, pv, start, end, band=0.02):
    """When it is within `band` (2 %) of the way for good, counted from the step."""
    outside = np.nonzero(np.abs(result[pv] - end) > band * abs(end - start))[0]
    if len(outside) == 0:
        return 0.0
    if outside[-1] == len(result.time) - 1:
        return float("nan")
    return result.time[outside[-1] + 1] - result.time[0]


def absolute_error(result, pv, sp):
    """Integral of |sp - pv| over time (IAE)."""
    return float(np.sum(np.abs(result[sp] - result[pv])[:-1] * np.diff(result.time)))


def control_error(result, pv, sp):
    """Integral of sp - pv over time, with its sign."""
    return float(np.sum((result[sp] - result[pv])[:-1] * np.diff(result.time)))


# Files


def arguments(description):
    """The folder of the FMUs and the folder for CSV and PNG, from the command line."""
    parser = argparse.ArgumentParser(description=description.split("\n\n")[0])
    parser.add_argument(
        "--fmu",
        default=ROOT / "target" / "fmu",
        type=pathlib.Path,
        help="folder of the FMUs (default: target/fmu)",
    )
    parser.add_argument(
        "--out",
        default=ROOT / "target" / "demo",
        type=pathlib.Path,
        help="folder for CSV and PNG (default: target/demo)",
    )
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    return given.fmu, given.out


def written_beside(path, write):
    """Lets `write` fill a file beside `path` and renames it: there is the old file or the new one, never half of one."""
    handle, beside = tempfile.mkstemp(dir=path.parent, prefix=path.stem, suffix=path.suffix)
    os.close(handle)
    try:
        write(beside)
        os.chmod(beside, 0o644)
        os.replace(beside, path)
    except BaseException:
        os.unlink(beside)
        raise
    here = pathlib.Path.cwd()
    print(f"  {path.relative_to(here) if here in path.parents else path}")


def save_csv(result, path):
    """The time and all signals, one row a step; FALSE and TRUE as 0 and 1."""

    def write(beside):
        with open(beside, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            names = list(result.rows[0])
            table.writerow(names)
            for row in result.rows:
                table.writerow([f"{float(row[name]):.9g}" for name in names])

    written_beside(path, write)


# Pictures: the same colour for the same thing in all of them

SETPOINT = {"color": "#333333", "linestyle": (0, (5, 2)), "linewidth": 1.3}
PROCESS_VALUE = {"color": "#0b62a4", "linewidth": 1.8}
MANIPULATED = {"color": "#c8102e", "linewidth": 1.6}
P_PART = {"color": "#e08a00", "linewidth": 1.1}
I_PART = {"color": "#2e8b57", "linewidth": 1.1}
D_PART = {"color": "#8a5fbf", "linewidth": 1.1}
COMPARED = {"color": "#9a9a9a", "linewidth": 1.4}
DISTURBANCE = {"color": "#faf0da", "linewidth": 0}
MANUAL = {"color": "#e6edf5", "linewidth": 0}


def picture(title, labels, heights=None, size=(9.0, 6.0), columns=1, same_time=True):
    """A figure with one set of axes under the other, time along; `labels` are those of the vertical axes."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update(
        {
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
    )
    figure, axes = pyplot.subplots(
        len(labels),
        columns,
        sharex="col" if same_time else False,
        sharey="row" if columns > 1 else False,
        figsize=size,
        squeeze=False,
        layout="constrained",
        gridspec_kw={"height_ratios": heights or [1] * len(labels)},
    )
    figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
    for row, label in zip(axes, labels):
        row[0].set_ylabel(label)
    for bottom in axes[-1] if same_time else axes.flat:
        bottom.set_xlabel("time in s")
    return figure, axes[:, 0] if columns == 1 else axes


def legend(axes, **options):
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


def mark(axes, start, end, text, style=DISTURBANCE, at=None):
    """Marks a time, such as that of a disturbance, in all axes, and names it in the first: at its upper left corner, or
    at (time, share of the height)."""
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


def save_picture(figure, path):
    """Saves the picture, 900 pixels wide."""
    from matplotlib import pyplot

    written_beside(
        path,
        lambda beside: figure.savefig(
            beside, dpi=100, metadata={"Software": None}, pil_kwargs={"optimize": True}
        ),
    )
    pyplot.close(figure)
