"""The closed loops of examples/: what they print lies where control theory puts it, and what their pages and pictures
say is so. The numbers stand here once more, worked out by hand from the plants' parameters and the settings.

The first part holds for every file of examples/, and a new one is taken up as soon as it is there.
"""

import contextlib
import csv
import importlib.util
import io
import itertools
import math
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree
import zipfile

import numpy as np
import pytest

import host
import plcfmu

TESTS = pathlib.Path(__file__).parent
EXAMPLES = TESTS.parent / "examples"
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.py"))


def load(name):
    """A file of examples/ as a module."""
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


cascade = load("cascade")
cont_c_heater = load("cont_c_heater")
cont_s_valve = load("cont_s_valve")
figures = load("figures")
heat_cool = load("heat_cool")
own_plant = load("own_plant")
pulse_width = load("pulse_width")
ramp = load("ramp")
ratio = load("ratio")
tank = load("tank")
two_point = load("two_point")


@pytest.fixture(scope="module")
def fmus():
    with plcfmu.Fmus(host.FOLDER) as fmus:
        yield fmus


@pytest.fixture(scope="module")
def run(fmus):
    """The result of an example's function, computed once: run(tank.run, 160.0)."""
    results = {}

    def run(function, *arguments):
        key = (function, *arguments)
        if key not in results:
            results[key] = function(fmus, *arguments)
        return results[key]

    return run


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """What an example prints when it is started as a program, and the folder with the files that it writes; once."""
    runs = {}

    def program(name):
        if name not in runs:
            runs[name] = started(name, tmp_path_factory.mktemp(name))
        return runs[name]

    return program


def started(name, folder):
    """Starts an example as `cargo xtask demo` does."""
    command = [sys.executable, EXAMPLES / f"{name}.py", "--fmus", host.FOLDER, "--out", "demo"]
    process = subprocess.run(
        command, cwd=folder, env=host.environment(), capture_output=True, text=True, encoding="utf-8"
    )
    assert process.returncode == 0, process.stderr
    return process.stdout, folder / "demo"


@pytest.fixture(scope="module")
def again(tmp_path_factory):
    """What an example prints when it runs once more, in this process, its folder, and its pictures by name; once."""
    runs = {}

    def again(name):
        if name not in runs:
            runs[name] = run_here(name, tmp_path_factory.mktemp(f"{name}_again"))
        return runs[name]

    return again


def run_here(name, folder):
    drawn = {}
    save = plcfmu.plot.save

    def keep(figure, path):
        save(figure, path)
        drawn[pathlib.Path(path).stem] = figure

    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()) as printed:
        patch.chdir(folder)
        patch.setattr(sys, "argv", [f"{name}.py", "--fmus", str(host.FOLDER), "--out", "demo"])
        patch.setattr(plcfmu.plot, "save", keep)
        load(name).main()
    return printed.getvalue(), folder / "demo", drawn


def near(value, expected, share):
    """Is it the expected value within this share of it?"""
    return abs(value - expected) <= share * abs(expected)


# Every example


@pytest.mark.parametrize("name", NAMES)
def test_an_example_prints_its_figures_and_writes_csv_png_and_svg(program, name):
    printed, folder = program(name)
    assert re.search(r"^  \S.*\d", printed, re.MULTILINE)
    suffixes = {path.suffix for path in folder.iterdir()}
    assert suffixes == {".csv", ".png", ".svg"}
    for path in folder.glob("*.csv"):
        with open(path, newline="", encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        assert names[0] == "time" and len(names) > 1 and len(rows) > 1
        assert all(len(row) == len(names) for row in rows)
        assert np.isfinite(np.array(rows, dtype=float)).all()
    for path in folder.glob("*.png"):
        assert png_size(path) == (1600, 900) and path.with_suffix(".svg").exists()
    for path in folder.glob("*.svg"):
        svg = xml.etree.ElementTree.parse(path).getroot()
        assert (svg.get("width"), svg.get("height")) == ("576pt", "324pt") and path.with_suffix(".png").exists()


@pytest.mark.parametrize("name", NAMES)
def test_an_example_prints_and_writes_the_same_bytes_each_time(program, again, name):
    (printed, folder), (printed_again, folder_again, _) = program(name), again(name)
    assert printed_again == printed
    assert contents(folder_again) == contents(folder)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("name", NAMES)
def test_an_example_says_what_it_shows(name):
    assert len(load(name).__doc__.split("\n\n")) > 2


@pytest.mark.parametrize("name", NAMES)
def test_an_example_with_a_picture_on_the_page_is_on_the_page_with_all_its_pictures(program, name):
    _, folder = program(name)
    written = {path.name for path in folder.glob("*.png")}
    if written & pictures():
        assert f"({name}.py)" in page()
        assert written <= pictures()


def page():
    return (EXAMPLES / "README.md").read_text(encoding="utf-8")


def pictures():
    """The pictures that are kept for the page."""
    return {path.name for path in (EXAMPLES / "pictures").glob("*.png")}


def test_the_page_shows_the_pictures_that_the_examples_draw(program):
    written = {path.name for name in NAMES for path in program(name)[1].glob("*.png")}
    assert set(re.findall(r"\(pictures/(.*)\)", page())) == pictures()
    assert pictures() <= written


def test_every_example_that_the_page_links_to_is_there():
    assert set(re.findall(r"\((\w+)\.py\)", page())) <= set(NAMES)


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


def test_the_pictures_on_the_page_are_16_by_9_at_200_dpi_and_small():
    for path in (EXAMPLES / "pictures").iterdir():
        assert path.suffix == ".png", f"{path.name}: the page shows PNG, and the demos write SVG"
        assert png_size(path) == (1600, 900) and path.stat().st_size < 150_000, path.name


def title(figure):
    return figure.get_suptitle().replace("\n", " ")


@pytest.mark.parametrize("name", NAMES)
def test_the_title_of_a_picture_is_a_finding_with_a_number_and_stands_on_the_page(again, name):
    on_page = {picture: text for text, picture in re.findall(r"!\[(.*)\]\(pictures/(.*)\.png\)", page())}
    for picture, figure in again(name)[2].items():
        assert re.search(r"\d", title(figure)), title(figure)
        assert on_page.get(picture, title(figure)) == title(figure)


@pytest.mark.parametrize("name", NAMES)
def test_a_title_with_a_rise_time_says_from_where_to_where_it_is(name):
    text = (EXAMPLES / f"{name}.py").read_text("utf-8")
    for said in re.findall(r"^ +title = .*?\n(?=    with |    result)", text, re.MULTILINE | re.DOTALL):
        assert not re.search(r"\brise['\"]", said) or "10 to 90 %" in said, said


@pytest.mark.parametrize("name", NAMES)
def test_no_text_of_a_picture_is_clipped_or_covers_a_curve_or_another_text(again, name):
    for picture, figure in again(name)[2].items():
        figure.draw_without_rendering()
        size, drawn = figure.get_size_inches(), figure.get_tightbbox()
        assert 0 <= drawn.x0 and 0 <= drawn.y0 and drawn.x1 <= size[0] and drawn.y1 <= size[1], picture

        for legend, axes in itertools.product(legends(figure), figure.axes):
            assert not legend.get_window_extent().overlaps(axes.bbox), f"{picture}: a legend covers curves"
        texts = [figure._suptitle, *legends(figure)]
        for axes in figure.axes:
            notes = [text for text in axes.texts if text.get_text()]
            texts += notes + [label for label in (axes.xaxis.label, axes.yaxis.label) if label.get_text()]
            for text, line in itertools.product(notes, curves(axes)):
                path = line.get_transform().transform_path(line.get_path())
                assert not path.intersects_bbox(text.get_window_extent(), filled=False), f"{picture}: {text}"
        for one, other in itertools.combinations(texts, 2):
            # The boxes of two lines of text may touch.
            assert not one.get_window_extent().padded(-2).overlaps(other.get_window_extent()), (
                f"{picture}: {one} {other}"
            )


def legends(figure):
    return [axes.get_legend() for axes in figure.axes if axes.get_legend()] + figure.legends


def curves(axes):
    """The signals of a panel, without the lines that mark a time or a level."""
    return [line for line in axes.lines if line.get_transform() == axes.transData and len(line.get_xdata())]


@pytest.mark.parametrize("name", NAMES)
def test_every_curve_of_a_picture_is_within_its_panel_and_every_panel_has_its_units(again, name):
    unit = re.compile(r"\bin (%|°C|s|m|l/min|rpm|call)(?!\w)")
    for picture, figure in again(name)[2].items():
        for axes in figure.axes:
            for line in curves(axes):
                for data, limits in ((line.get_xdata(), axes.get_xlim()), (line.get_ydata(), axes.get_ylim())):
                    assert min(limits) <= min(data) and max(data) <= max(limits), f"{picture}: {line.get_label()}"
            place = axes.get_subplotspec()
            named = any(re.search("[a-zA-Z]", tick.get_text()) for tick in axes.get_yticklabels())
            if place.is_first_col() and not named:
                assert unit.search(axes.get_ylabel()), f"{picture}: {axes.get_ylabel()}"
            left, right = axes.get_xlim()
            ticks = axes.xaxis.get_major_locator().tick_values(left, right)
            # The last row is a cycle before the end, and the tick of the end would be missing.
            if axes.get_xlabel() == "time in s":
                assert min(abs(ticks - right)) < 1e-6 * (right - left), f"{picture}: {right}"
            if place.is_last_row():
                assert unit.search(axes.get_xlabel()) or "call, counted" in axes.get_xlabel(), picture


def test_a_signal_has_the_same_colour_in_all_pictures(again):
    from matplotlib.colors import to_hex

    colors = {}
    for name in NAMES:
        for figure in again(name)[2].values():
            for legend in legends(figure):
                for handle, text in zip(legend.legend_handles, legend.get_texts()):
                    color = handle.get_color() if hasattr(handle, "get_color") else handle.get_facecolor()
                    colors.setdefault(text.get_text().split(".")[-1], set()).add(to_hex(color))
    assert {"SP_INT", "PV", "LMN", "QPOS_P", "QNEG_P"} <= colors.keys()
    assert {label: found for label, found in colors.items() if len(found) > 1} == {}
    # A signal that a page draws has its colour there, too. The setpoint is black there and, on white, dark grey here.
    known = {}
    for fmu in host.names():
        with zipfile.ZipFile(host.FOLDER / f"{fmu}.fmu") as package:
            page = package.read("documentation/index.html").decode()
        entry = r'<path class="curve-\d" color="(#\w+)" d="[^"]*" stroke="currentColor" stroke-width="2"[^>]*/><text[^>]*>([\w.]+)<'
        known |= {name.split(".")[-1]: color for color, name in re.findall(entry, page)}
    assert {"LMN", "LMN_P", "LMNR", "INV", "QPOS_P"} <= known.keys()
    both = {name: (colors[name], known[name]) for name in colors.keys() & known.keys() if known[name] != "#000000"}
    assert {name: pair for name, pair in both.items() if pair[0] != {pair[1]}} == {}


ADDED = '''
"""A new example.

It runs CONT_C alone.

So it is short.
"""

import plcfmu


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        controller = fmus.start("CONT_C", MAN_ON=False)
        inputs = {"CONT_C.SP_INT": 1.0}
        result = plcfmu.simulate(controller, [], {}, inputs=inputs, record="CONT_C.LMN", step=1.0, duration=5)
    print(f"  LMN in the end: {result['CONT_C.LMN'][-1]} %")
    result.to_csv(out / "added.csv")
    title = f"LMN rises to {result['CONT_C.LMN'][-1]} %"
    result.plot(out / "added", {"LMN in %": ["CONT_C.LMN"]}, title)


if __name__ == "__main__":
    main()
'''


def test_a_new_file_is_taken_up_without_an_edit_elsewhere(tmp_path):
    shutil.copytree(EXAMPLES, tmp_path / "examples", ignore=shutil.ignore_patterns("my_block", "__pycache__"))
    (tmp_path / "tests").mkdir()
    for path in [*TESTS.glob("*.py"), TESTS / "pytest.ini"]:
        shutil.copy(path, tmp_path / "tests")
    (tmp_path / "examples" / "added.py").write_text(ADDED.lstrip(), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "added", "tests/test_examples.py"]
    process = subprocess.run(command, cwd=tmp_path, env=host.environment(), capture_output=True, text=True)
    assert process.returncode == 0, process.stdout
    assert "8 passed" in process.stdout


# What the loops stand on


def test_with_the_plant_first_the_loop_has_a_cycle_more_of_dead_time(fmus):
    def first_heat(plant_first):
        controller = fmus.start("CONT_C", MAN_ON=False, CYCLE=1.0)
        furnace = fmus.start("HEATER", DELAY_TM=5.0)
        for second in range(20):
            if plant_first:
                furnace.step(second, 1.0, POWER=controller["LMN"])
            controller.step(second, 1.0, SP_INT=100.0, PV_IN=furnace["TEMP"])
            if not plant_first:
                furnace.step(second, 1.0, POWER=controller["LMN"])
            if furnace["TEMP"] > 20.0:
                return second

    assert first_heat(plant_first=True) == first_heat(plant_first=False) + 1


def test_the_heater_example_prints_its_figures_and_keeps_every_signal(program):
    printed, folder = program("cont_c_heater")
    for figure in ("rise", "overshoot", "settling", "iae"):
        assert figure in printed
    names = {path.name for path in folder.iterdir()}
    pictures = {f"cont_c_heater{way}.{suffix}" for way in ("", "_cold_start") for suffix in ("png", "svg")}
    signals = {f"cont_c_heater{way}.csv" for way in ("", "_cold_start", "_cold_start_by_hand")}
    assert names == pictures | signals
    with open(folder / "cont_c_heater.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 1000
    assert {"time", "SP_INT", "PV", "LMN", "LMN_P", "LMN_I", "LMN_D", "DOOR"} <= set(rows[0])


# own_plant: K 3 K/%, lags 120 s and 20 s, delay 5 s. LAMBDA 30 s, THETA 5 + 10 + 0.5 = 15.5 s.


def test_own_plant_is_in_the_loop_in_under_20_lines():
    """Without imports, the docstring and blank lines."""
    text = (EXAMPLES / "own_plant.py").read_text(encoding="utf-8").split('"""\n')[1].partition("if __name__")[0]
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("import")]
    assert len(lines) < 20


def test_own_plant_answers_the_setpoint_nearly_like_a_lag_of_30_s(run):
    step = run(own_plant.run).between(30.0, 600.0).figures("PLANT.TEMP", "CONT_C.SP_INT", start=20.0, end=80.0)
    assert near(step["rise"], 2.2 * 30, 0.15)
    assert step["overshoot"] < 8.0
    # GAIN = 130 s / (3 K/% * 45.5 s) = 0.95; the integrator makes 60 K / 3 K/% = 20 %.
    assert step["iae"] >= 20 * 130 / 0.95 * 0.99
    assert run(own_plant.run)["CONT_C.LMN"][-1] == pytest.approx(20.0, abs=0.1)


def test_own_plant_takes_the_path_of_an_fmu(fmus, run, tmp_path):
    path = shutil.copy(plcfmu.fmu("HEATER", host.FOLDER), tmp_path / "my own plant.fmu")
    result, by_name = own_plant.run(fmus, path), run(own_plant.run)
    for name in by_name.names:
        assert (result[name] == by_name[name]).all(), name


# cont_c_heater: K 3 K/%, lags 120 s and 20 s, delay 5 s. LAMBDA 20 s, THETA 5 + 0.5 + 5 = 10.5 s.


def test_heater_the_settings_are_those_of_the_rule():
    # KC = 120 / (3 * 30.5); TI = 120 + 20 - 5; TD = 120 * 20 / 135 - 5; GAIN = KC * 135 / 120
    settings = cont_c_heater.PID
    assert near(settings["GAIN"], 1.4754, 1e-4) and settings["TI"] == 135.0
    assert near(settings["TD"], 12.778, 1e-4) and settings["TM_LAG"] == 5.0


def test_heater_the_setpoint_step_is_answered_like_a_lag_of_20_s(run):
    result = run(cont_c_heater.run)
    assert near(result.quality["rise"], 2.2 * 20, 0.1)
    assert result.quality["overshoot"] < 0.5
    # After 5.5 s, ln 50 = 3.9 time constants.
    assert near(result.quality["settling"], 5.5 + 78.2, 0.12)


def test_heater_the_error_adds_up_to_the_step_times_lambda_and_theta(run):
    assert near(run(cont_c_heater.run).quality["iae"], 10 * 30.5, 0.01)


def test_heater_the_step_makes_the_p_and_d_parts_jump_as_the_settings_say(run):
    result = run(cont_c_heater.run)
    at = {name: result[name][60] - result[name][59] for name in ("LMN_P", "LMN_D", "LMN")}
    # P: GAIN * 10 K; D: that times TD / (CYCLE / 2 + TM_LAG) = 12.78 / 5.5
    assert near(at["LMN_P"], 14.754, 1e-3) and near(at["LMN_D"], 34.28, 1e-2) and near(at["LMN"], 49.0, 1e-2)


def test_heater_the_open_door_takes_what_it_takes_and_no_more(run):
    result = run(cont_c_heater.run)
    # A quarter more loss of 160 K: 40 K, or 13.3 % power. 40 K * 30.5 s / 100 s * (6^-0.2 - 6^-1.2) = 7.1 K
    assert near(result.quality["door: largest deviation"], 40 * 0.305 * (6**-0.2 - 6**-1.2), 0.15)
    assert near(result.quality["door: integral of the error"], 13.333 * 135 / 1.4754, 0.08)
    assert near(result["LMN"][-1], 160 / 3 * 1.25, 0.01)
    # Within 1 % of the step: the picture ends when the furnace is back.
    assert abs(result["PV"][-1] - 180.0) < 0.1


def test_heater_the_change_from_manual_to_automatic_has_no_bump(run):
    result = run(cont_c_heater.run)
    assert result["LMN"][29] == 50.0
    assert abs(result["LMN"][30] - 50.0) < 0.05


def test_heater_the_parts_add_up_to_the_manipulated_value(run):
    part = run(cont_c_heater.run).between(30.0, 1000.0)
    assert part["LMN_P"] + part["LMN_I"] + part["LMN_D"] == pytest.approx(part["LMN"], abs=1e-4)


def test_heater_the_process_value_has_come_as_an_analog_word(run):
    # A count is 400 K / 27648 = 0.0145 K; rounded to the nearest.
    result = run(cont_c_heater.run)
    error = result["PV"] - result["TEMP"]
    assert 0.004 < max(abs(error)) < 0.00724


def test_heater_at_the_limit_the_integrator_stands_still_and_nothing_overshoots(run):
    result = run(cont_c_heater.cold_start, False)
    limited = result["QLMN_HLM"] == 1
    assert 60 < np.count_nonzero(limited) < 90
    assert np.ptp(result["LMN_I"][limited]) == 0.0
    assert result.quality["cold start automatic: overshoot"] == 0.0


def test_heater_handed_over_by_hand_it_arrives_sooner_and_without_overshoot(run):
    automatic, by_hand = run(cont_c_heater.cold_start, False), run(cont_c_heater.cold_start, True)
    settling = automatic.quality["cold start automatic: settling"]
    assert by_hand.quality["cold start by hand: settling"] < 0.5 * settling
    assert by_hand.quality["cold start by hand: overshoot"] < 0.5
    # The integrator goes on from where manual mode has put it: 100 % - LMN_P of the last manual call.
    last = np.nonzero(by_hand["MAN_ON"])[0][-1]
    assert by_hand["LMN_I"][last] == pytest.approx(100.0 - by_hand["LMN_P"][last], abs=1e-4)
    # That call ended at the limit, so the next one does not integrate upwards yet.
    assert by_hand["LMN_I"][last + 1] == by_hand["LMN_I"][last] < by_hand["LMN_I"][last + 2]


# cascade: 2 K/(l/min), lags 20 s and 5 s, flow loop 2 s. LAMBDA 10 s, THETA 2.5 + 2 + 0.5 = 5 s.


@pytest.mark.parametrize("with_flow_controller, way", [(True, "cascade"), (False, "single")])
def test_cascade_both_answer_the_setpoint_like_a_lag_of_10_s(run, with_flow_controller, way):
    result = run(cascade.run, with_flow_controller)
    assert near(result.quality[f"{way}: rise"], 2.2 * 10, 0.2)
    assert result.quality[f"{way}: overshoot"] < 5.0
    assert near(result.quality[f"{way}: iae"], 5 * 15, 0.05)


def test_cascade_the_pressure_drop_costs_the_cascade_a_fifth_of_what_it_costs_the_single_controller(
    run,
):
    cascaded, single = run(cascade.run, True), run(cascade.run, False)
    largest = "pressure drop, largest deviation"
    assert cascaded.quality[f"cascade: {largest}"] < 0.2 * single.quality[f"single: {largest}"]
    # 4.71 of 22.5 l/min are missing; 0.16 K for each l/min
    assert 0.3 < cascaded.quality[f"cascade: {largest}"] < 4.71 * 0.16


def test_cascade_the_temperature_error_adds_up_to_what_the_integrator_has_to_move(run):
    integral = "pressure drop, integral of the error"
    # Single: the position goes from 56.25 to 56.25 / 0.7906 = 71.15 %; 14.9 % * 22.5 s / 1.875 %/K
    assert near(run(cascade.run, False).quality[f"single: {integral}"], 14.9 * 12.0, 0.02)
    # Cascade: the wanted flow stays what it was.
    assert abs(run(cascade.run, True).quality[f"cascade: {integral}"]) < 1.0


def test_cascade_the_flow_follows_its_setpoint_with_2_s(run):
    result = run(cascade.run, True)
    drop = result.between(150.1, 300.0)
    # At 2.5 bar the valve has 0.79 of its gain: 2.53 s. The setpoint moves a little meanwhile.
    missing = (drop["FLOW_SP"] - drop["FLOW"])[[0, 25]]
    assert near(missing[1] / missing[0], math.exp(-2.5 / 2.53), 0.25)


# ratio: a first-order loop with 1.5 s.


def test_ratio_on_a_ramp_flow_b_is_behind_by_the_slope_times_1_5_s(run):
    # 30 % of 40 l/min in 9 s, half of it: 0.667 l/min/s
    assert near(run(ratio.run).quality["flow A rises: flow B is behind"], 0.6667 * 1.5, 0.02)


def test_ratio_a_new_ratio_is_answered_like_a_lag_of_1_5_s(run):
    result = run(ratio.run)
    assert near(result.quality["new ratio: rise"], 3.3, 0.1)
    assert result.quality["new ratio: overshoot"] < 0.1
    assert near(result.quality["new ratio: settling"], 5.87, 0.1)
    # Flow A is 28 l/min * 0.7906; 0.1 of it * 1.5 s
    assert near(result.quality["new ratio: iae"], 2.2137 * 1.5, 0.01)


def test_ratio_flow_b_makes_up_for_its_pressure(run):
    result = run(ratio.run)
    # 0.6 * 22.137 l/min * (1 - 0.7906); it fades with 1.5 s / 0.7906
    assert near(result.quality["pressure drop of B: largest deviation"], 2.781, 0.01)
    assert near(result.quality["pressure drop of B: integral of the error"], 2.781 * 1.897, 0.01)
    assert near(result["RATIO"][-1], 0.6, 0.001)


# tank: at 1 m with half the drain K 6.27 cm/% and T 752.6 s; LAMBDA 40 s.


def test_tank_the_operating_point_is_that_of_the_formulas():
    # Outflow 0.6 * 2 cm2 * sqrt(2 g) = 0.5315 l/s; T = 2 * 0.2 m3 / that; K = T * 0.01667 l/s / 0.2 m2
    assert near(tank.T, 752.6, 1e-3) and near(tank.K, 0.06271, 1e-3)
    # T / K is the area over the valve's 0.01667 l/s per percent, whatever the level is.
    assert near(tank.GAIN, 300.0, 1e-9)


def test_tank_with_its_own_time_constant_it_answers_like_a_lag_of_40_s(run):
    result = run(tank.run, tank.T)
    assert near(result.quality["TI 753 s: rise"], 88.0, 0.05)
    assert result.quality["TI 753 s: overshoot"] < 0.5
    assert near(result.quality["TI 753 s: settling"], 156.5, 0.05)
    assert near(result.quality["TI 753 s: iae"], 0.1 * 40, 0.03)


def test_tank_with_a_quick_integrator_it_overshoots_but_by_no_more_than_13_5_percent(run):
    assert 7.0 < run(tank.run, tank.FAST_TI).quality["TI 160 s: overshoot"] < 13.5


def test_tank_the_drain_costs_an_error_in_proportion_to_the_reset_time(run):
    # 15 of 50 % more drain: 0.3 * 31.89 % more inflow; * TI / 300 %/m
    assert near(
        run(tank.run, tank.FAST_TI).quality["TI 160 s: drain, integral of the error"],
        9.567 * 160 / 300,
        0.02,
    )
    # The slow one still has exp(-1300 / 753) = 18 % to go.
    assert near(
        run(tank.run, tank.T).quality["TI 753 s: drain, integral of the error"],
        9.567 * 752.6 / 300 * 0.822,
        0.03,
    )


# cont_s_valve: 0.8 K/%, lags 20 s and 5 s, LAMBDA 12 s; a pulse of 0.3 s is 1 %.


def test_valve_the_setpoint_step_rises_within_a_fifth_of_2_2_lambda(run):
    result = run(cont_s_valve.run)
    assert near(result.quality["rise"], 26.4, 0.2)
    assert result.quality["highest beyond the setpoint"] < 0.5
    assert result.quality["within 1 K after"] < 60.0


def test_valve_at_rest_it_is_within_the_dead_band_and_no_pulse_comes(run):
    result = run(cont_s_valve.run)
    assert result.quality["steady-state deviation"] <= 0.5
    for start, end in ((0.0, 20.0), (220.0, 240.0), (360.0, 400.0), (560.0, 600.0)):
        part = result.between(start, end)
        assert not part["QLMNUP"].any() and not part["QLMNDN"].any()


def test_valve_it_gets_along_with_few_pulses(run):
    result = run(cont_s_valve.run)
    assert 2 <= result.quality["pulses for the setpoint step"] <= 10
    assert 2 <= result.quality["pulses for the pressure drop"] <= 10


def test_valve_it_never_gets_a_pulse_against_its_stop(run):
    result = run(cont_s_valve.run)
    assert result["LMNR_HS"].any(), "it was at the stop"
    assert not ((result["QLMNUP"] == 1) & (result["LMNR_HS"] == 1)).any()
    assert not ((result["QLMNDN"] == 1) & (result["LMNR_LS"] == 1)).any()


def test_valve_pulses_and_breaks_last_300_ms_and_directions_never_meet(run):
    result = run(cont_s_valve.run)
    motor = result["QLMNUP"] - result["QLMNDN"]
    assert not ((result["QLMNUP"] == 1) & (result["QLMNDN"] == 1)).any()
    starts = np.nonzero(np.diff(motor, prepend=0.0))[0]
    lengths = np.diff(starts)
    assert len(lengths) > 30
    # At a stop a pulse may end at once; elsewhere pulses and breaks are three calls at least.
    at_stop = result["LMNR_HS"][starts[1:]] == 1
    assert (lengths[~at_stop] >= 3).all()


def test_valve_by_hand_it_runs_to_the_stop_and_back_by_the_time_of_the_pulses(run):
    result = run(cont_s_valve.run)
    up, down = result.between(245.0, 257.0), result.between(265.0, 268.0)
    at_stop = up["LMNR_HS"] == 1
    assert up["QLMNUP"][~at_stop].all() and not up["QLMNUP"][at_stop].any()
    assert at_stop[-1] and up["LMNR"][-1] == 100.0
    assert down["QLMNDN"].all()
    # 3 s of 30 s
    assert result.between(268.0, 270.0)["LMNR"][1] == pytest.approx(90.0, abs=1e-6)


def test_valve_after_a_setpoint_that_is_too_high_it_closes_at_once(run):
    result = run(cont_s_valve.run)
    # At the stop from 408.3 s on, but for 12.2 s in between: one pulse takes the valve off it.
    stopped = result.between(400.0, 480.0)
    assert cont_s_valve.pulses(stopped["QLMNDN"]) == 1
    assert result.quality["setpoint too high: at the stop"] == pytest.approx(80.0 - 8.3 - 12.2, abs=1e-6)
    assert result.quality["setpoint back: the valve closes after"] == pytest.approx(0.0, abs=1e-6)


# heat_cool: 0.6 K/% heating, 1.2 K/% cooling; GAIN for 0.6 K/%.


def test_heat_cool_in_heating_the_ratio_factor_does_not_matter(run):
    whole, half = (run(heat_cool.run, ratiofac).between(0.0, 260.0) for ratiofac in (1.0, 0.5))
    assert (whole["HEAT"] == half["HEAT"]).all() and (whole["PV"] == half["PV"]).all()
    assert not whole["COOL"].any()


def test_heat_cool_with_half_the_pulse_cooling_is_like_heating(run):
    result = run(heat_cool.run, 0.5)
    assert near(result.quality["RATIOFAC 0.5, cooling: rise"], result.quality["RATIOFAC 0.5, heating: rise"], 0.1)
    assert result.quality["RATIOFAC 0.5, cooling: overshoot"] < 8.0
    assert not result.between(300.0, 560.0)["HEAT"].any(), "it never has to heat back"


def test_heat_cool_with_the_whole_pulse_the_loop_gain_is_twice_that_and_cooling_swings(run):
    whole, half = run(heat_cool.run, 1.0), run(heat_cool.run, 0.5)
    overshoot, rise = "cooling: overshoot", "cooling: rise"
    assert whole.quality[f"RATIOFAC 1.0, {overshoot}"] > 2 * half.quality[f"RATIOFAC 0.5, {overshoot}"]
    assert 0.45 < whole.quality[f"RATIOFAC 1.0, {rise}"] / half.quality[f"RATIOFAC 0.5, {rise}"] < 0.65
    assert whole.between(280.0, 400.0)["HEAT"].any(), "heating has to bring it back"
    assert heat_cool.phase_margin(1.0) == pytest.approx(51.2, abs=0.1)
    assert heat_cool.phase_margin(2.0) == pytest.approx(36.3, abs=0.1)


@pytest.mark.parametrize("ratiofac, lmn", [(1.0, -5.0), (0.5, -10.0)])
def test_heat_cool_what_holds_14_degc_is_6_k_of_cooling(run, ratiofac, lmn):
    # 6 K / 1.2 K/%, and 1 / RATIOFAC times that. Pulses are known to 1 %.
    result = run(heat_cool.run, ratiofac)
    assert result.quality[f"RATIOFAC {ratiofac}: LMN that holds 14 degC"] == pytest.approx(lmn, abs=1.0)
    assert np.mean(result["COOL"][-20:]) == pytest.approx(5.0, abs=0.5)


# pulse_width: 0.6 K/%, lags 100 s and 10 s, LAMBDA 21 s, THETA 6 s.


def test_pulse_width_puls_ctr_makes_the_pulses_of_the_two_blocks_call_by_call(run):
    result = run(pulse_width.run)
    assert len(result) == 24_000 and np.ptp(result["QPOS_P"]) == 1
    for name in ("QPOS_P", "LMN", "TEMP"):
        assert (result[name] == result[f"PULS_CTR_{name}"]).all(), name


def test_pulse_width_the_controller_is_called_in_call_199_and_every_200_after_it(run):
    changes = np.nonzero(np.diff(run(pulse_width.run)["LMN"]))[0] + 1
    assert set(changes % 200) == {199}
    # The setpoint rises at 20 s, call 2000.
    assert changes[changes >= 2000][0] == 2199


def test_pulse_width_each_pulse_is_as_long_as_the_manipulated_value_says(run):
    result = run(pulse_width.run)
    for period in range(1, 120):
        pulses = result["QPOS_P"][200 * period : 200 * period + 200]
        lmn = result["LMN"][200 * period]
        # A whole number of the 200 calls, at the start of the period.
        assert abs(pulses.sum() - 2 * lmn) <= 0.5 + 1e-4
        assert (np.diff(pulses) <= 0).all()


def test_pulse_width_the_pulses_act_as_their_mean(run):
    result = run(pulse_width.run)
    assert near(result.quality["rise"], 46.2, 0.2)
    assert result.quality["overshoot"] < 2.0
    assert result.quality["settling"] < 88.0
    assert near(result.quality["iae"], 270.0, 0.1)
    assert 0.0 < result.quality["steady-state temperature ripple"] < 0.03


# ramp: 0.5 K/s; PI with GAIN 0.952, TI 130 s; drive with 0.1 s, 75 rpm.


def test_ramp_the_furnace_stays_behind_by_the_slope_over_the_velocity_constant(run):
    result = run(ramp.furnace, True)
    # 0.5 K/s * 130 s / (3 K/% * 0.9524 %/K), reached but for what 200 s leave
    assert near(result.quality["furnace, ramp: behind the setpoint at its end"], 22.75, 0.05)
    assert near(result.quality["furnace, ramp: iae"], 100 / 3 * 130 / 0.9524, 0.03)


def test_ramp_the_setpoint_runs_through_100_k_in_200_s(run):
    setpoint = run(ramp.furnace, True)["SP_INT"]
    count = 400 / 27648
    assert setpoint[29] == pytest.approx(100.0, abs=count)
    assert setpoint[129] == pytest.approx(150.0, abs=2 * count)
    assert np.nonzero(setpoint == setpoint[-1])[0][0] in (229, 230)
    assert setpoint[-1] == pytest.approx(200.0, abs=count)


def test_ramp_only_the_step_drives_the_power_to_its_limit(run):
    with_ramp, with_step = run(ramp.furnace, True), run(ramp.furnace, False)
    assert with_step["QLMN_HLM"].any() and not with_ramp["QLMN_HLM"].any()
    # 60 % hold 200 degC; 0.5 K/s * 120 s / 3 K/% = 20 % more raise it
    assert near(with_ramp.quality["furnace, ramp: largest LMN"], 80.0, 0.06)
    assert with_ramp.quality["furnace, ramp: overshoot"] < 2.0


def test_ramp_the_drive_follows_400_calls_23_rpm_behind_with_30_percent_torque(run):
    result = run(ramp.drive, 400)
    assert result.quality["drive, TH_TZ 400: tripped"] == "no"
    # 915.55 rpm / 4 s = 228.9 rpm/s; * (0.1 s + half a call); / 750 rpm/s at full torque
    assert near(result.quality["drive, TH_TZ 400: behind the setpoint"], 228.9 * 0.105, 0.02)
    assert near(result.quality["drive, TH_TZ 400: torque"], 30.5, 0.06)
    assert near(result.quality["drive, TH_TZ 400: speed at the end"], 915.55, 0.001)


def test_ramp_the_drive_trips_on_100_calls_after_0_17_s_and_without_a_ramp_at_once(run):
    steep, none = run(ramp.drive, 100), run(ramp.drive, 0)
    assert steep.quality["drive, TH_TZ 100: tripped"] == "yes" and none.quality["drive, TH_TZ 0: tripped"] == "yes"
    # 91.6 rpm (1 - exp(-t / 0.1 s)) = 75 rpm; the calls see it 10 ms and half a call sooner
    assert steep.quality["drive, TH_TZ 100: tripped after"] == pytest.approx(0.171, abs=0.025)
    assert none.quality["drive, TH_TZ 0: tripped after"] == pytest.approx(0.0, abs=1e-6)
    assert max(none["SPEED"]) == 0.0 and max(steep["SPEED"]) < 0.1 * 916


# figures


def sweep(fmus, number):
    return figures.characteristic(fmus, figures.CHARACTERISTICS[number][1])


def test_figure_3_3_30_percent_of_ten_calls_is_three_calls_on_and_seven_off(run):
    pulse = run(figures.modulation)["QPOS_P"].astype(int)
    assert list(pulse) == [1] * 3 + [0] * 7 + [1] * 6 + [0] * 4 + [1] * 9 + [0]


def test_figure_3_5_the_new_pulse_begins_in_the_next_call_but_for_the_first_and_the_last_two(run):
    starts = [figures.new_period(run(figures.synchronization, call, True)) for call in range(10)]
    assert starts == [0, 2, 3, 4, 5, 6, 7, 8, 10, 10]


def test_figure_3_5_without_synchronization_the_new_pulse_begins_with_the_next_period(run):
    starts = [figures.new_period(run(figures.synchronization, call, False)) for call in range(10)]
    assert starts == [0] + [10] * 9


# Pulse in percent of PER_TM over INV, with P_B_TM 10 % of it: (mode, INV, pulse)
POINTS = {
    "3-6": [
        (-110, -100),
        (-90.5, -100),
        (-90, -90),
        (-50, -50),
        (-10, -10),
        (-9.5, 0),
        (0, 0),
        (9.5, 0),
        (10, 10),
        (55.5, 55.5),
        (90, 90),
        (90.5, 100),
        (110, 100),
    ],
    "3-7": [
        (-110, -50),
        (-90.5, -50),
        (-90, -45),
        (-50, -25),
        (-10, -5),
        (-9.5, 0),
        (0, 0),
        (9.5, 0),
        (10, 10),
        (90, 90),
        (90.5, 100),
    ],
    "3-8": [
        (-110, 0),
        (-100, 0),
        (-80.5, 0),
        (-80, 10),
        (-50, 25),
        (0, 50),
        (0.5, 50.25),
        (50, 75),
        (80, 90),
        (80.5, 100),
        (110, 100),
    ],
    "3-9": [
        (-110, 0),
        (-50, 0),
        (0, 0),
        (9.5, 0),
        (10, 10),
        (55.5, 55.5),
        (90, 90),
        (90.5, 100),
        (110, 100),
    ],
}


@pytest.mark.parametrize("number", POINTS)
def test_figures_3_6_to_3_9_have_their_slopes_and_doglegs(run, number):
    result = run(sweep, number)
    assert list(result["INV"]) == [half / 2 for half in range(-220, 221)]
    pulse = dict(zip(result["INV"], result["PULSE"]))
    for inv, expected in POINTS[number]:
        assert pulse[inv] == pytest.approx(expected, abs=1e-9), inv


@pytest.mark.parametrize("number, slopes", [("3-6", (1, 1)), ("3-7", (0.5, 1)), ("3-8", (0.5, 0.5)), ("3-9", (0, 1))])
def test_figures_3_6_to_3_9_are_straight_between_the_doglegs(run, number, slopes):
    result = run(sweep, number)
    for low, high, slope in ((-80, -10.5, slopes[0]), (10.5, 80, slopes[1])):
        chosen = (result["INV"] >= low) & (result["INV"] <= high)
        assert np.diff(result["PULSE"][chosen]) == pytest.approx(0.5 * slope, abs=1e-9)


# two_point, with the FMU of examples/my_block


def test_two_point_the_temperature_swings_as_far_as_the_delays_let_it(run):
    result = run(two_point.run)
    # HYS + 2.5 K/s * 5 ... 7 s, and that way up with 1.167 and down with 1.333 K/s
    assert 16.5 < result.quality["swing of the temperature"] < 21.5
    assert 26.5 < result.quality["period"] < 34.6


def test_two_point_the_mean_of_the_power_holds_the_mean_of_the_temperature(run):
    assert run(two_point.run).quality["mean of the power"] == pytest.approx(160 / 3, abs=0.5)


def test_two_point_it_switches_at_the_ends_of_the_band(run):
    result = run(two_point.run)
    switched = np.nonzero(np.diff(result["Q"]))[0] + 1
    assert len(switched) > 10
    for i in switched:
        if result["Q"][i] == 1:
            assert result["PV"][i] < 178.0 <= result["PV"][i - 1]
        else:
            assert result["PV"][i] > 182.0 >= result["PV"][i - 1]
