"""The Python package plcfmu: FMUs by name, instances by variable name, closed loops, figures, CSV and pictures."""

import io
import logging
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import host
import plcfmu
from plcfmu import figures, find, messages, parameters

ROOT = pathlib.Path(__file__).parents[1]
PACKAGE = ROOT / "plcfmu" / "python"


@pytest.fixture
def fmus():
    with plcfmu.Fmus(host.FOLDER) as fmus:
        yield fmus


def near(value, expected, share):
    """Is it the expected value within this share of it?"""
    return abs(value - expected) <= share * abs(expected)


# FMUs by name


@pytest.fixture
def places(tmp_path, monkeypatch):
    """A folder for each place in which FMUs are looked for, each with an FMU of that name."""
    folders = {place: tmp_path / place for place in ("given", "variable", "installed")}
    for place, folder in folders.items():
        folder.mkdir()
        (folder / f"{place}.fmu").touch()
    monkeypatch.setenv("PLCFMU_FMUS", str(folders["variable"]))
    monkeypatch.setattr(find, "INSTALLED", folders["installed"])
    return folders


def test_an_fmu_is_looked_for_in_the_given_folder_then_the_variables_then_the_package_then_the_checkout(
    places, monkeypatch
):
    assert plcfmu.fmu("given", places["given"]) == places["given"] / "given.fmu"
    assert plcfmu.fmu("variable") == places["variable"] / "variable.fmu"
    monkeypatch.delenv("PLCFMU_FMUS")
    assert plcfmu.fmu("installed") == places["installed"] / "installed.fmu"
    (places["installed"] / "installed.fmu").unlink()
    assert find.fmu_folder() == ROOT / "target" / "fmu"


def test_with_a_given_folder_no_other_is_looked_in(places):
    with pytest.raises(plcfmu.FmuNotFoundError):
        plcfmu.fmu("variable", places["given"])
    assert plcfmu.fmu_names(places["given"]) == ["given"]


def test_without_any_folder_the_error_says_how_to_get_fmus(places, monkeypatch):
    monkeypatch.delenv("PLCFMU_FMUS")
    (places["installed"] / "installed.fmu").unlink()
    monkeypatch.setattr(find, "checkout", lambda: None)
    with pytest.raises(plcfmu.FmuNotFoundError, match="set PLCFMU_FMUS to it; `cargo xtask fmu` .* builds them"):
        plcfmu.fmu("CONT_C")


def test_a_missing_fmu_is_named_with_the_command_that_makes_it(tmp_path):
    with plcfmu.Fmus(tmp_path) as nothing:
        with pytest.raises(FileNotFoundError, match="no .*HEATER.fmu: build it with `cargo xtask fmu HEATER`"):
            nothing.start("HEATER")


def test_a_wrong_name_is_refused_with_the_nearest_one_and_all_that_there_are(fmus):
    with pytest.raises(plcfmu.FmuNotFoundError) as error:
        fmus.start("cont-c")
    assert "did you mean CONT_C?" in str(error.value)
    for name in host.names():
        assert name in str(error.value)


def test_a_plant_of_ones_own_is_opened_by_its_path(fmus, tmp_path):
    path = shutil.copy(plcfmu.fmu("HEATER", host.FOLDER), tmp_path / "my plant.v2.fmu")
    assert fmus.start(path, T_START=90.0)["TEMP"] == fmus.start("HEATER", T_START=90.0)["TEMP"]
    assert fmus.start(str(path)).name == "my plant.v2"
    with pytest.raises(plcfmu.FmuNotFoundError, match="no .*elsewhere.fmu"):
        fmus.start(tmp_path / "elsewhere.fmu")


def repacked(path, replace):
    """CONT_C with the text of each file passed through `replace(name, content)`; None leaves it out."""
    with zipfile.ZipFile(plcfmu.fmu("CONT_C", host.FOLDER)) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = replace(name, old.read(name))
            if content is not None:
                new.writestr(name, content)
    return path


def test_what_cannot_run_here_is_refused_with_the_reason(fmus, tmp_path):
    def without_libraries(name, content):
        return None if name.startswith("binaries/") and not name.endswith("/") else content

    def for_model_exchange(name, content):
        return content.replace(b"CoSimulation", b"ModelExchange") if name == "modelDescription.xml" else content

    (tmp_path / "text.fmu").write_text("no archive")
    with pytest.raises(plcfmu.FmuError, match="text.fmu is not an FMU"):
        fmus.start(tmp_path / "text.fmu")
    with pytest.raises(plcfmu.FmuError, match=r"empty.fmu has no library for \w+; available: none"):
        fmus.start(repacked(tmp_path / "empty.fmu", without_libraries))
    with pytest.raises(
        plcfmu.FmuError, match="other.fmu is an FMI 2.0 FMU for model exchange only; export it as FMI 2.0 or 3.0 for co-sim"
    ):
        fmus.start(repacked(tmp_path / "other.fmu", for_model_exchange))


# Instances


def test_variables_are_read_and_written_by_name_with_the_type_of_the_model_description(fmus):
    controller = fmus.start("CONT_C", MAN_ON=False, GAIN=3.0)
    controller["GAIN"] = 2.5
    controller.set({"TI": 7.0}, PV_PER=12.0)
    got = controller.get("GAIN MAN_ON TI PV_PER")
    assert got == {"GAIN": 2.5, "MAN_ON": False, "TI": 7.0, "PV_PER": 12}
    assert list(got) == ["GAIN", "MAN_ON", "TI", "PV_PER"]
    assert [type(value) for value in got.values()] == [float, bool, float, int]
    assert controller["TI"] == 7.0 and controller.get(["TI"]) == {"TI": 7.0}
    assert "GAIN" in controller and "GAINS" not in controller


def test_a_wrong_variable_is_refused_with_the_nearest_ones(fmus):
    furnace = fmus.start("HEATER")
    with pytest.raises(KeyError, match="HEATER has no variable POWRE; did you mean POWER"):
        furnace.step(0.0, 0.1, POWRE=50.0)
    with pytest.raises(plcfmu.UnknownVariableError, match="HEATER has no variable xyz; available: .*POWER, .*TEMP"):
        furnace["xyz"]


@pytest.mark.parametrize(
    "name, value, wants",
    [
        ("GAIN", "two", "GAIN is a Real, which cannot be 'two'; assign a number"),
        ("PV_PER", 2.5, "PV_PER is an Integer, which cannot be 2.5; assign an integer"),
        ("MAN_ON", 2, "MAN_ON is a Boolean, which cannot be 2; assign True or False"),
    ],
)
def test_a_value_of_another_type_is_refused_and_nothing_is_set(fmus, name, value, wants):
    controller = fmus.start("CONT_C", TI=5.0)
    with pytest.raises(TypeError, match=f"CONT_C: {wants}"):
        controller.set({"TI": 9.0, name: value})
    assert controller["TI"] == 5.0


def test_whole_numbers_and_truth_values_of_numpy_are_taken(fmus):
    controller = fmus.start("CONT_C", MAN_ON=np.bool_(False), PV_PER=np.int16(7), GAIN=np.float32(0.5))
    assert controller.get("MAN_ON PV_PER GAIN") == {"MAN_ON": False, "PV_PER": 7, "GAIN": 0.5}
    controller["PV_PER"] = 8.0
    assert controller["PV_PER"] == 8


def test_what_an_fmu_refuses_is_an_error_with_its_own_message(fmus):
    controller = fmus.start("CONT_C")
    with pytest.raises(plcfmu.FmuError) as error:
        controller["LMN"] = 1.0
    assert (error.value.function, error.value.status) == ("fmi2SetReal", host.ERROR)
    assert len(error.value.messages) == 1 and "LMN" in error.value.messages[0]
    assert str(error.value) == f"CONT_C: fmi2SetReal returned fmi2Error: {error.value.messages[0]}"
    with pytest.raises(plcfmu.FmuError, match="fmi2DoStep returned fmi2Error: fmi2DoStep: "):
        controller.step(0.0, -1.0)
    controller.step(0.0, 1.0)


def test_a_start_value_that_is_refused_ends_in_an_error_and_frees_the_instance():
    with plcfmu.Fmus(host.FOLDER) as fmus:
        with pytest.raises(plcfmu.FmuError, match="CONT_C: fmi2SetReal .*CYCLE"):
            fmus.start("CONT_C", CYCLE=-1.0)
        folders = [package.folder for package in fmus._packages.values()]
    assert folders and not any(folder.exists() for folder in folders)


def test_messages_go_to_the_instance_that_they_belong_to_also_beside_another_host(fmus, open_fmu):
    ours, another, theirs = fmus.start("CONT_C"), fmus.start("CONT_C"), open_fmu("CONT_C").start()
    for instance in (ours, another):
        with pytest.raises(plcfmu.FmuError) as error:
            instance["LMN_P"] = 1.0
        assert len(error.value.messages) == 1
    assert theirs.messages == []
    with pytest.raises(host.Refused):
        theirs.set(LMN_P=1.0)
    assert [message.instance for message in theirs.messages] == ["instance"]


def test_a_message_of_a_call_that_succeeds_goes_to_the_logger_plcfmu(fmus, caplog):
    controller = fmus.start("CONT_C")
    controller._log.messages.append(messages.Message("CONT_C", 1, "logStatusWarning", "be careful"))
    with caplog.at_level(logging.INFO, logger="plcfmu"):
        controller["LMN"]
    assert caplog.record_tuples == [("plcfmu", logging.WARNING, "CONT_C: be careful")]


def test_instances_of_one_fmu_are_apart_and_closing_twice_does_nothing():
    with plcfmu.Fmus(host.FOLDER) as fmus:
        one, other = fmus.start("CONT_C", GAIN=1.0), fmus.start("CONT_C", GAIN=2.0, name="other")
        assert (one["GAIN"], other["GAIN"]) == (1.0, 2.0) and other.name == "other"
        one.close()
        one.close()
        assert other["GAIN"] == 2.0
        folder = fmus._packages[plcfmu.fmu("CONT_C", host.FOLDER).resolve()].folder
        assert folder.exists()
    assert not folder.exists()
    fmus.close()


def test_a_start_time_is_where_the_first_step_begins(fmus):
    controller = fmus.start("CONT_C", start_time=7.0)
    with pytest.raises(plcfmu.FmuError):
        controller.step(0.0, 1.0)
    controller.step(7.0, 1.0)


# Parameters


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """A folder for each place in which the command is looked for, with a program that does nothing."""
    folders = {place: tmp_path / place for place in ("variable", "installed", "checkout", "path")}
    built = folders["checkout"] / "target" / "release"
    for folder in (folders["variable"], folders["installed"], built, folders["path"]):
        folder.mkdir(parents=True)
        program = folder / parameters.PROGRAM
        program.write_text("#!/bin/sh\n", encoding="utf-8")
        program.chmod(0o755)
    monkeypatch.setenv("PLCFMU_COMMAND", str(folders["variable"] / parameters.PROGRAM))
    monkeypatch.setattr(parameters.sysconfig, "get_path", lambda _: str(folders["installed"]))
    monkeypatch.setattr(parameters, "checkout", lambda: folders["checkout"])
    monkeypatch.setenv("PATH", str(folders["path"]))
    return folders


def test_the_command_is_that_of_the_variable_then_of_the_package_then_of_the_checkout_then_of_the_path(
    programs, monkeypatch
):
    program = parameters.PROGRAM
    assert parameters.command() == programs["variable"] / program
    monkeypatch.delenv("PLCFMU_COMMAND")
    assert parameters.command() == programs["installed"] / program
    (programs["installed"] / program).unlink()
    assert parameters.command() == programs["checkout"] / "target" / "release" / program
    (programs["checkout"] / "target" / "release" / program).unlink()
    assert parameters.command() == programs["path"] / program


def test_of_two_commands_in_a_checkout_the_one_that_was_built_last_is_taken(programs, monkeypatch):
    monkeypatch.delenv("PLCFMU_COMMAND")
    (programs["installed"] / parameters.PROGRAM).unlink()
    old = programs["checkout"] / "target" / "release" / parameters.PROGRAM
    new = programs["checkout"] / "target" / "debug" / parameters.PROGRAM
    new.parent.mkdir()
    shutil.copy(old, new)
    os.utime(old, (1000, 1000))
    assert parameters.command() == new
    os.utime(old, None)
    os.utime(new, (1000, 1000))
    assert parameters.command() == old


def test_without_the_command_the_error_says_how_to_get_it(programs, monkeypatch, tmp_path):
    monkeypatch.setenv("PLCFMU_COMMAND", "/nowhere/plcfmu")
    with pytest.raises(plcfmu.CommandNotFoundError, match="PLCFMU_COMMAND is .*plcfmu, which is not a file"):
        plcfmu.params("plant.awl")
    monkeypatch.delenv("PLCFMU_COMMAND")
    monkeypatch.setenv("PATH", str(tmp_path))
    (programs["installed"] / parameters.PROGRAM).unlink()
    monkeypatch.setattr(parameters, "checkout", lambda: None)
    with pytest.raises(plcfmu.CommandNotFoundError, match="the wheel of plcfmu contains it; or set PLCFMU_COMMAND"):
        plcfmu.params("plant.awl")
    monkeypatch.setattr(parameters, "checkout", lambda: tmp_path)
    with pytest.raises(plcfmu.CommandNotFoundError, match="`cargo build --release -p plcfmu` in the repository"):
        plcfmu.params("plant.awl")


@pytest.fixture
def source(tmp_path, command, monkeypatch):
    """Writes a source text with one data block, and has the command found."""
    monkeypatch.setenv("PLCFMU_COMMAND", str(command))

    def source(values, name='"TIC101"'):
        file = tmp_path / "plant.awl"
        file.write_text(f"DATA_BLOCK {name}\n FB 41\nBEGIN\n  {values}\nEND_DATA_BLOCK\n", encoding="utf-8")
        return file

    return source


def test_the_parameters_of_a_file_have_the_names_and_numbers_of_the_fmu(source, fmus):
    loops = plcfmu.params(source("GAIN := 1.5; TI := T#1M20S; PV_PER := W#16#FFFF; MAN_ON := FALSE;"))
    assert list(loops) == ["TIC101"]
    values = loops["TIC101"]
    assert (values["GAIN"], values["TI"], values["PV_PER"], values["MAN_ON"]) == (1.5, 80.0, -1, False)
    assert values["LMN_HLM"] == 100.0, "what the file does not set has the block's start value"
    controller = fmus.start("CONT_C", values, TI=90.0)
    assert (controller["GAIN"], controller["TI"], controller["MAN_ON"]) == (1.5, 90.0, False)


def test_block_loop_and_offset_are_those_of_the_command(source, tmp_path):
    one = plcfmu.params(source("GAIN := 1.5;"), loop="TIC101")
    dump = tmp_path / "db41.bin"
    subprocess.run([parameters.command(), "params", tmp_path / "plant.awl", "--out", dump], check=True, capture_output=True)
    dump.write_bytes(bytes(10) + dump.read_bytes())
    assert plcfmu.params(dump, block="FB 41", loop="TIC101", offset=10) == one


def test_an_error_has_file_line_and_column(source):
    file = source("GAIN := 1.5;\n  TI := 20;")
    with pytest.raises(plcfmu.ParameterError) as error:
        plcfmu.params(file)
    assert re.match(rf"{re.escape(str(file))}:5:\d+: ", str(error.value)), str(error.value)
    with pytest.raises(plcfmu.ParameterError, match="nowhere.awl"):
        plcfmu.params("nowhere.awl")


def test_what_the_command_warns_of_is_logged(source, caplog):
    with caplog.at_level(logging.WARNING, logger="plcfmu"):
        plcfmu.params(source("MAN_ON := TRUE;"))
    assert any("TIC101: MAN_ON is TRUE" in message for message in caplog.messages)


# Loops

PI = {"MAN_ON": False, "CYCLE": 1.0, "GAIN": 1.2, "TI": 130.0, "I_ITLVAL": 50.0}


def test_a_simulated_loop_is_the_one_stepped_by_hand_bit_for_bit(fmus):
    controller, furnace = fmus.start("CONT_C", PI), fmus.start("HEATER", T_START=170.0)
    by_hand = []
    for second in range(600):
        controller.step(second, 1.0, SP_INT=180.0 if second >= 60 else 170.0, PV_IN=furnace["TEMP"])
        by_hand.append((furnace["TEMP"], controller["LMN"], controller["LMN_P"]))
        furnace.step(second, 1.0, POWER=controller["LMN"])
    result = plcfmu.simulate(
        fmus.start("CONT_C", PI),
        fmus.start("HEATER", T_START=170.0),
        {"CONT_C.LMN": "HEATER.POWER", "HEATER.TEMP": "CONT_C.PV_IN"},
        inputs={"CONT_C.SP_INT": [(0.0, 170.0), (60.0, 180.0)]},
        record="HEATER.TEMP CONT_C.LMN CONT_C.LMN_P",
        step=1.0,
        duration=600.0,
    )
    assert len(result) == 600
    for number, name in enumerate(result.names):
        assert result[name].tobytes() == np.array([row[number] for row in by_hand]).tobytes(), name
    assert np.ptp(result["HEATER.TEMP"]) > 5.0


def test_inputs_are_constants_or_steps_or_functions_and_are_recorded_as_given(fmus):
    result = plcfmu.simulate(
        fmus.start("CONT_C"),
        [],
        {},
        inputs={
            "CONT_C.SP_INT": 0.9,
            # The third step begins at 3 * 0.7, which as a double is less than 2.1.
            "CONT_C.DISV": [(2.1, 7.0), (0.0, 5.0)],
            "CONT_C.MAN": lambda t: 10 * t,
        },
        step=0.7,
        duration=3.5,
    )
    assert result.names == ["CONT_C.SP_INT", "CONT_C.DISV", "CONT_C.MAN"]
    assert set(result["CONT_C.SP_INT"]) == {0.9}
    assert list(result["CONT_C.DISV"]) == [5.0, 5.0, 5.0, 7.0, 7.0]
    assert list(result["CONT_C.MAN"]) == [10 * (number * 0.7) for number in range(5)]


def test_a_function_of_a_controllers_input_sees_what_the_controllers_before_it_gave_in_this_call(fmus):
    first = fmus.start("CONT_C", name="first", CYCLE=1.0, MAN_ON=True)
    second = fmus.start("CONT_C", name="second", CYCLE=1.0, MAN_ON=True)
    result = plcfmu.simulate(
        [first, second],
        [],
        {"first.LMN": ["second.MAN", "second.DISV"]},
        inputs={"first.MAN": lambda t: 10.0 + t, "second.SP_INT": lambda t: first["LMN"]},
        record={"given": "first.LMN", "connected": "second.LMN", "seen": "second.SP_INT", "also": "second.DISV"},
        step=1.0,
        duration=3.0,
    )
    for name in ("given", "connected", "seen", "also"):
        assert list(result[name]) == [10.0, 11.0, 12.0], name


def test_names_of_instances_may_have_dots_and_begin_alike(fmus):
    plants = [fmus.start("HEATER", name=name, T_START=start) for name, start in (("my", 30.0), ("my.plant", 40.0))]
    result = plcfmu.simulate([], plants, {}, record="my.TEMP my.plant.TEMP", step=0.1, duration=0.1)
    assert (result["my.TEMP"][0], result["my.plant.TEMP"][0]) == (30.0, 40.0)


def test_a_loop_that_is_not_wired_well_is_refused(fmus):
    controller, furnace = fmus.start("CONT_C"), fmus.start("HEATER")

    def wired(connections, plants=furnace, **more):
        plcfmu.simulate(controller, plants, connections, step=1.0, duration=1.0, **more)

    with pytest.raises(ValueError, match="'FURNACE.TEMP' is not .* one of the instances CONT_C, HEATER"):
        wired({"FURNACE.TEMP": "CONT_C.PV_IN"})
    with pytest.raises(plcfmu.UnknownVariableError, match="HEATER has no variable TMEP; did you mean TEMP"):
        wired({"HEATER.TMEP": "CONT_C.PV_IN"})
    with pytest.raises(ValueError, match="CONT_C.PV_IN gets its value from two sources"):
        wired({"HEATER.TEMP": "CONT_C.PV_IN"}, inputs={"CONT_C.PV_IN": 1.0})
    with pytest.raises(ValueError, match='two FMUs of the loop are named CONT_C: .* name="CONT_C_2"'):
        wired({}, plants=fmus.start("CONT_C"))
    with pytest.raises(ValueError, match="must begin at time 0"):
        wired({}, inputs={"CONT_C.SP_INT": [(1.0, 5.0)]})
    with pytest.raises(ValueError, match="the step must be greater than 0"):
        list(plcfmu.clock(10.0, 0.0))


def test_the_clock_gives_multiples_of_the_step_and_not_their_sum():
    assert list(plcfmu.clock(1.0, 0.1)) == [number * 0.1 for number in range(10)]


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_is_shown_to_who_watches_and_to_nobody_else(monkeypatch):
    for stream, shown in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        list(plcfmu.clock(5.0, 1.0, "furnace"))
        assert ("furnace: 100%" in stream.getvalue()) == shown


# Quality figures of signals whose figures are known


def answer(signal, end=100.0, h=0.01):
    """`signal(t)` as the answer to a setpoint step from 0 to 1 at t = 0: the times and the process values."""
    time = np.arange(0, end, h)
    return time, np.array([signal(t) for t in time])


def lag(t):
    return 1 - math.exp(-t / 5)


def test_a_first_order_lag_has_the_figures_of_the_textbook():
    time, pv = answer(lag)
    given = figures.step_figures(time, pv, np.ones_like(pv), 0, 1)
    assert near(given["rise"], 5 * math.log(9), 1e-4)
    assert near(given["settling"], 5 * math.log(50), 1e-3)
    assert given["overshoot"] == 0.0
    assert near(given["iae"], 5.0, 2e-3)
    # exp(-2 t / 5)
    assert near(given["ise"], 2.5, 3e-3)
    assert given["peak"] == 1.0


def test_an_error_that_changes_its_sign_counts_whole_in_the_absolute_error_and_cancels_in_the_other():
    time, pv, sp = np.arange(5.0), np.array([2.0, 0.0, 2.0, 0.0, 1.0]), np.ones(5)
    given = figures.step_figures(time, pv, sp, 0, 1, lmn=pv, unit="K", travel_unit="%")
    assert (given["iae"], given["travel"]) == (4.0, 7.0)
    units = {figure.name: figure.unit for figure in given}
    assert [units[name] for name in ("rise", "overshoot", "ise", "travel")] == ["s", "%", "K^2 s", "%"]
    assert figures.integral_error(time, pv, sp) == 0.0


def test_a_figure_that_a_run_does_not_have_is_nan():
    time, stays = answer(lambda t: 0.5, 10)
    given = figures.step_figures(time, stays, np.ones_like(stays), 0, 1)
    assert math.isnan(given["rise"]) and math.isnan(given["settling"]) and given["peak"] == 0.5
    stays[3] = math.nan
    assert all(math.isnan(figure.value) for figure in figures.step_figures(time, stays, np.ones_like(stays), 0, 1))
    with pytest.raises(ValueError, match="theory has unknown figures: settled"):
        figures.step_figures(time, stays, stays, 0, 1, theory={"settled": 5.0})


def recorded(signal=lag, end=100.0):
    result = plcfmu.Result()
    for t, pv in zip(*answer(signal, end)):
        result.add(t, SP=1.0, PV=pv)
    return result


def test_a_result_gives_the_figures_of_a_step_by_name_and_as_a_table():
    result = recorded()
    given = result.figures("PV", "SP", unit="K", prefix="lag: ", theory={"rise": 10.99, "overshoot": 0.0, "iae": 5.0})
    assert [figure.name for figure in given][:3] == ["lag: rise", "lag: overshoot", "lag: settling"]
    # By default from the first process value, 0, to the last setpoint.
    assert near(given["lag: rise"], 5 * math.log(9), 1e-4)
    lines = str(given).splitlines()
    assert re.fullmatch(r"  lag: rise +11 s +theory 11 s", lines[0])
    assert re.fullmatch(r"  lag: settling +19\.6 s", lines[2])
    with pytest.raises(KeyError, match="no figure 'rise'; available: lag: rise"):
        given["rise"]


# Results


def test_rows_are_taken_between_times_that_may_be_rounded():
    result = plcfmu.Result()
    for number in range(10):
        result.add(number * 0.1, N=number)
    assert list(result.between(0.3, 0.7)["N"]) == [3, 4, 5, 6]
    assert len(result.between(5.0, 6.0)) == 0


def test_a_row_with_other_signals_or_without_a_number_is_refused_and_not_added():
    result = plcfmu.Result()
    result.add(0.0, {"CONT_C.LMN": 1.0}, PV=2.0)
    with pytest.raises(ValueError, match="a row with time, PV does not match rows with time, CONT_C.LMN, PV"):
        result.add(1.0, PV=2.0)
    with pytest.raises(ValueError):
        result.add(1.0, {"CONT_C.LMN": "no number"}, PV=2.0)
    assert len(result) == 1 and len(result["PV"]) == 1
    with pytest.raises(KeyError, match="no signal SP; available: CONT_C.LMN, PV"):
        result["SP"]


def test_a_signal_grows_with_the_rows_also_after_it_was_read():
    result = plcfmu.Result()
    for number in range(3):
        result.add(number, N=number)
        assert list(result["N"]) == list(range(number + 1))


def test_a_csv_has_the_time_and_all_signals_with_true_as_1(tmp_path):
    result = plcfmu.Result()
    result.add(0.0, PV=1.5, Q=True)
    result.add(0.1, PV=-0.1, Q=False)
    result.to_csv(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text() == "time,PV,Q\n0,1.5,1\n0.1,-0.1,0\n"
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_a_csv_reads_back_bit_for_bit(tmp_path):
    values = [0.1 + 0.2, -0.0, 1e-310, 1.7976931348623157e308, math.inf, -math.inf, math.nan, 1 / 3, 2**53, 5e-324]
    result = plcfmu.Result()
    for number, value in enumerate(values):
        result.add(number * 0.1, {"a, b": value})
    result.to_csv(tmp_path / "new" / "a.csv")
    back = plcfmu.Result.from_csv(tmp_path / "new" / "a.csv")
    assert back.names == ["a, b"]
    assert back["a, b"].tobytes() == result["a, b"].tobytes()
    assert back.time.tobytes() == result.time.tobytes()


def test_nine_digits_of_a_csv_are_enough_for_a_real(tmp_path):
    reals = np.random.default_rng(1).integers(0, 0x7F80_0000, 1000, dtype=np.uint32).view(np.float32)
    result = plcfmu.Result()
    for number, value in enumerate(reals):
        result.add(number, REAL=value)
    result.to_csv(tmp_path / "a.csv", digits=9)
    assert "1.00000001" not in (tmp_path / "a.csv").read_text()
    back = plcfmu.Result.from_csv(tmp_path / "a.csv")["REAL"].astype(np.float32)
    assert back.tobytes() == reals.tobytes()


def test_a_csv_without_time_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("t,PV\n0,1\n")
    with pytest.raises(ValueError, match="a.csv has no column named time"):
        plcfmu.Result.from_csv(tmp_path / "a.csv")


def test_a_csv_that_cannot_be_written_leaves_the_old_one(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")
    result = recorded(end=1.0)
    with pytest.raises(ValueError):
        result.to_csv(path, digits=-1)  # fails after the line of the names
    assert path.read_text() == "old" and [path.name for path in tmp_path.iterdir()] == ["a.csv"]


# Pictures


def test_a_result_draws_itself_with_booleans_as_lanes(tmp_path):
    result = recorded(end=2.0)
    both = plcfmu.Result()
    for number, t in enumerate(result.time):
        both.add(t, SP=1.0, PV=result["PV"][number], UP=number % 20 < 10, DOWN=number % 20 >= 15)
    both.describe("SP", "degC", is_input=True)
    both.describe("PV", "degC")
    both.describe("UP", is_boolean=True)
    both.describe("DOWN", is_boolean=True)
    figure = both.plot(tmp_path / "a.png", title="A lag")
    temperature, pulses = figure.axes
    assert temperature.get_ylabel() == "in °C" and pulses.get_xlabel() == "time in s"
    assert [line.get_label() for line in temperature.lines] == ["SP", "PV"]
    assert [label.get_text() for label in pulses.get_yticklabels()] == ["UP", "DOWN"]
    assert (tmp_path / "a.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    for path in (tmp_path / "a.svg", tmp_path / "a.pdf"):
        both.plot(path, [["PV"], ["SP", "UP"]])
        assert path.stat().st_size > 1000


def test_a_picture_without_a_suffix_is_png_and_svg_fit_for_a_report_and_the_same_each_time(tmp_path):
    result = recorded(end=2.0)
    for name in ("a", "b"):
        figure = result.plot(tmp_path / name, {"temperature in °C": ["SP", "PV"]}, "A lag")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.svg", "b.png", "b.svg"]
    assert figure.axes[0].get_ylabel() == "temperature in °C"
    for suffix in ("png", "svg"):
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    # 8 x 4.5 inches at 200 dpi
    assert struct.unpack(">II", (tmp_path / "a.png").read_bytes()[16:24]) == (1600, 900)
    assert "A lag" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_pulses_are_bars_from_the_rise_to_the_fall_and_the_last_row_ends_them():
    time, signal = np.array([0.0, 0.5, 1.0, 1.5, 2.0]), np.array([0, 1, 0, 1, 1])
    with plcfmu.plot.picture(None, "Pulses", ["Q"]) as axes:
        plcfmu.plot.pulses(axes[0], time, signal, base=1.0, height=2.0, **plcfmu.plot.PULSE)
        plcfmu.plot.pulses(axes[0], time, np.zeros(5), **plcfmu.plot.PULSE)
    (bars, none) = axes[0].collections
    corners = [path.get_extents().extents.tolist() for path in bars.get_paths()]
    assert corners == [[0.5, 1.0, 1.0, 3.0], [1.5, 1.0, 2.0, 3.0]] and not none.get_paths()


def test_drawing_leaves_matplotlibs_settings_alone(tmp_path):
    import matplotlib

    before = dict(matplotlib.rcParams)
    recorded(end=1.0).plot(tmp_path / "a.png")
    assert dict(matplotlib.rcParams) == before


def test_matplotlib_is_loaded_with_the_first_picture_only():
    check = "import sys, plcfmu; print('matplotlib' in sys.modules)"
    command = [sys.executable, "-c", check]
    assert subprocess.run(command, env=host.environment(), capture_output=True, text=True).stdout == "False\n"


# The package


def test_the_package_has_the_version_of_the_workspace():
    """maturin takes it from cargo; test_wheel.py checks the wheel's."""
    project = (PACKAGE / "pyproject.toml").read_text(encoding="utf-8")
    assert 'dynamic = ["version"]' in project
    assert 'manifest-path = "../Cargo.toml"' in project
    assert "version.workspace = true" in (PACKAGE.parent / "Cargo.toml").read_text(encoding="utf-8")
