"""Presets: FMUs that start from somebody's values. With nothing set they do what the original does with these values set by hand,
bit for bit, in every importer and however the host writes the URI of the resources; with damaged values they do not start.
"""

import ctypes
import itertools
import json
import os
import pathlib
import shutil
import subprocess
import zipfile
from ctypes import byref, c_void_p

import fmpy
import pytest

import host
import signals
import test_masters
from test_masters import pack  # noqa: F401, a fixture
from calls import refused
from host import ERROR

START = "resources/start.txt"
VALUES = {"MAN_ON": 0, "SP_INT": 60.5, "GAIN": 2.7182817, "TI": 12.345, "CYCLE": 0.1, "LMN_HLM": 81.0, "PV_PER": -7}


@pytest.fixture
def preset(open_fmu, make_preset, tmp_path):
    """A preset of CONT_C, unpacked."""
    path = make_preset(open_fmu("CONT_C"), tmp_path / "TIC101.fmu", **VALUES)
    return host.Fmu(path, tmp_path / "unpacked")


def run(instance, rows):
    outputs = []
    for row in rows:
        instance.step(**row)
        outputs.append(instance.values())
    return outputs


# --- The values ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", host.versions(host.names()))
def test_a_preset_with_nothing_set_does_what_the_original_does_with_its_values_set(name, open_fmu, open_preset):
    original, preset = open_fmu(name), open_preset(name)
    by_hand = original.start(**host.other_values(original))
    by_itself = preset.start()
    assert by_itself.values() == by_hand.values()
    rows = signals.rows(original, 100)
    assert run(by_itself, rows) == run(by_hand, rows)


@pytest.mark.parametrize("name", host.versions(host.names()))
def test_the_model_description_declares_the_values_that_an_instance_starts_from(name, open_preset):
    preset = open_preset(name)
    settings = preset.of("input", "parameter")
    types = {"Real": float, "Integer": int, "Boolean": lambda text: int(text == "true")}
    declared = {name: types[preset.variables[name].type](preset.variables[name].start) for name in settings}
    assert host.exact(preset.instance().get(settings)) == host.exact(declared)


def test_reset_gives_the_values_of_the_preset_back(preset):
    instance = preset.start(GAIN=1.0)
    instance.do("fmi2Reset")
    assert instance.values() == preset.instance().values()
    assert instance["GAIN"] == host.real(2.7182817)


def test_the_proposed_step_is_the_presets_time_between_two_calls(preset, open_fmu):
    original = open_fmu("CONT_C").description.defaultExperiment
    experiment = preset.description.defaultExperiment
    assert float(experiment.stepSize) == 0.1
    assert float(experiment.stopTime) == pytest.approx(float(original.stopTime) * 0.1)


def test_a_preset_keeps_the_library_and_its_name(preset, open_fmu):
    original = open_fmu("CONT_C")
    assert preset.description.modelName == "TIC101"
    assert preset.description.coSimulation.modelIdentifier == "CONT_C"
    assert preset.library().read_bytes() == original.library().read_bytes()


def test_a_preset_of_a_preset_has_the_values_of_both(preset, open_fmu, make_preset, tmp_path):
    second = host.Fmu(make_preset(preset, tmp_path / "TIC102.fmu", GAIN=5.0), tmp_path / "second")
    values = second.start().values()
    assert values == open_fmu("CONT_C").start(**{**VALUES, "GAIN": 5.0}).values()
    assert len({fmu.description.guid for fmu in (second, preset, open_fmu("CONT_C"))}) == 3


def test_presets_with_the_same_values_and_other_names_differ(preset, open_fmu, make_preset, tmp_path):
    other = host.Fmu(make_preset(open_fmu("CONT_C"), tmp_path / "TIC103.fmu", **VALUES), tmp_path / "other")
    assert other.description.guid != preset.description.guid


def test_two_presets_run_side_by_side(preset, open_fmu, make_preset, tmp_path):
    other = host.Fmu(make_preset(open_fmu("CONT_C"), tmp_path / "TIC104.fmu", GAIN=9.0), tmp_path / "other")
    one, two, plain = preset.start(), other.start(), open_fmu("CONT_C").start()
    assert [one["GAIN"], two["GAIN"], plain["GAIN"]] == [host.real(2.7182817), 9.0, 2.0]
    for instance in (one, two, plain):
        instance.do("fmi2Reset")
    assert [one["GAIN"], two["GAIN"], plain["GAIN"]] == [host.real(2.7182817), 9.0, 2.0]


def test_a_state_belongs_to_the_preset_it_was_saved_from(preset, open_fmu):
    instance, original = preset.start(), open_fmu("CONT_C").start()
    for to, content in ((original, instance.content()), (instance, original.content())):
        buffer = ctypes.create_string_buffer(content, len(content))
        refused(to, "fmi2DeSerializeFMUstate", buffer, len(content), byref(c_void_p()), saying=["another FMU"])


# --- What is refused ------------------------------------------------------------------------------


def instantiate(fmu, resources, guid=None):
    """The component, and what was logged."""
    slave, log = fmu.slave(), host.Log(memory=False)
    guid = fmu.description.guid.encode() if guid is None else guid
    component = slave.dll.fmi2Instantiate(b"x", 1, guid, resources, byref(log.callbacks), 0, 0)
    if component:
        slave.fmi2FreeInstance(component)
    return bool(component), [(message.status, message.text) for message in log.messages]


def refusal(fmu, resources=None):
    is_made, messages = instantiate(fmu, fmu.resources.encode() if resources is None else resources)
    assert not is_made
    ((status, text),) = messages
    assert status == ERROR and text.startswith("fmi2Instantiate: fmuGUID = ")
    return text


def test_a_changed_value_is_refused_with_both_guids(preset):
    file = preset.folder / START
    file.write_text(file.read_text().replace("GAIN = 2.7", "GAIN = 3.7"))
    text = refusal(preset)
    assert preset.description.guid in text and "was changed or replaced" in text and START in text


def test_any_changed_byte_is_refused(preset):
    file = preset.folder / START
    content = file.read_bytes()
    for place in range(0, len(content), 3):
        file.write_bytes(content[:place] + bytes([content[place] ^ 1 << place % 8]) + content[place + 1 :])
        refusal(preset)
    for length in range(0, len(content), 7):
        file.write_bytes(content[:length])
        refusal(preset)
    file.write_bytes(content)
    assert instantiate(preset, preset.resources.encode())[0]


def test_a_missing_file_is_named_with_its_place(preset):
    (preset.folder / START).unlink()
    text = refusal(preset)
    assert "there is no file " in text and str(preset.folder / "resources") in text


def test_a_folder_in_the_place_of_the_file_is_refused(preset):
    (preset.folder / START).unlink()
    (preset.folder / START).mkdir()
    refusal(preset)


def test_a_huge_file_is_refused(preset):
    (preset.folder / START).write_bytes(b"x" * (1 << 21))
    assert "more than 1048576 bytes" in refusal(preset)


def test_the_values_of_another_preset_are_refused_by_its_name(preset, open_fmu, make_preset, tmp_path):
    other = host.Fmu(make_preset(open_fmu("CONT_C"), tmp_path / "TIC105.fmu", GAIN=9.0), tmp_path / "other")
    shutil.copy(other.folder / START, preset.folder / START)
    text = refusal(preset)
    assert '"TIC105"' in text and other.description.guid in text


def test_the_values_of_another_block_are_refused_by_its_name(preset, open_preset):
    shutil.copy(open_preset("CONT_S").folder / START, preset.folder / START)
    assert "for CONT_S" in refusal(preset)


def test_an_original_never_reads_the_file(open_fmu, tmp_path):
    fmu = open_fmu("CONT_C")
    (tmp_path / "start.txt").write_text("hello")
    assert instantiate(fmu, tmp_path.as_uri().encode()) == (True, [])


def test_the_library_with_a_wrong_guid_says_what_a_preset_would_need(open_fmu):
    fmu = open_fmu("CONT_C")
    is_made, ((_, text),) = instantiate(fmu, fmu.resources.encode(), guid=b"{1}")
    assert not is_made and fmu.description.guid in text and "use the modelDescription.xml that came with it" in text
    assert START in text


# --- URIs ------------------------------------------------------------------------------------------


@pytest.fixture
def moved(preset, tmp_path):
    """The preset in a folder whose name has a space, umlauts and a percent sign."""
    folder = tmp_path / "Prüfstand 2 %20 #1" / "ä"
    shutil.copytree(preset.folder, folder)
    preset.folder = folder
    return preset


@pytest.mark.parametrize(
    "form",
    [
        lambda folder, quoted: f"file://{quoted}",
        lambda folder, quoted: f"file://{quoted}/",
        lambda folder, quoted: f"file:{quoted}",
        lambda folder, quoted: f"FILE://{quoted}",
        lambda folder, quoted: f"file:///{quoted}",
        lambda folder, quoted: f"file://localhost{quoted}",
        lambda folder, quoted: f"file://{quoted[1:]}",
        lambda folder, quoted: f"file://{folder}",
        lambda folder, quoted: f"file:{folder}",
        lambda folder, quoted: f"file://{quoted}".replace("%", "%25"),
        lambda folder, quoted: f"file://{quoted}".replace("/", "\\"),
        lambda folder, quoted: quoted.join(["file://", "//"]).lower().replace(quoted.lower(), quoted),
        lambda folder, quoted: folder,
        lambda folder, quoted: folder + "/",
    ],
    ids=itertools.count(),
)
@host.in_fmpy
def test_every_way_to_write_the_uri_leads_to_the_values(moved, form):
    folder = str(moved.folder / "resources")
    quoted = (moved.folder / "resources").as_uri()[len("file://") :]
    uri = form(folder, quoted)
    assert instantiate(moved, uri.encode()) == (True, []), uri


@pytest.mark.parametrize("resources", [b"", b"file:", b"http://host/x", b"file:///%00", b"file:///%ff\xff", b"%", b"/dev/zero",
                                       b"file:///" + b"x" * 100_000, b"file://" + b"/" * 30_000, b"file:///dev/stdin/.."])
def test_a_location_that_leads_nowhere_is_refused(preset, resources):
    text = refusal(preset, resources)
    assert len(text) < 2000


@host.in_fmpy
def test_fmpy_runs_a_preset(preset):
    recorded = fmpy.simulate_fmu(str(preset.path), stop_time=2.0, output_interval=0.1, output=["LMN", "GAIN"])
    assert recorded["GAIN"][-1] == host.real(2.7182817) and recorded["LMN"][-1] == 81.0


@pytest.mark.parametrize("master", test_masters.MASTERS)
@host.in_fmpy
def test_a_closed_loop_of_presets_runs_in_every_master_with_nothing_set(
    master, open_fmu, make_preset, pack, command, tmp_path, monkeypatch
):
    """The same bits as the originals with the values set by hand."""
    loop = test_masters.Loop(test_masters.LOOPS / "furnace.toml")
    folder = tmp_path / "Prüfstand 2"
    presets = {}
    for fmu, start in loop.fmus.items():
        path = make_preset(open_fmu(fmu), folder / f"{fmu}_1.fmu", **start)
        presets[f"{fmu}_1"] = host.Fmu(path, folder / fmu)
    description = tmp_path / "untouched.toml"
    description.write_text("\n".join(
        ['exchange = "parallel"', f"step = {loop.step}", f"stop = {50 * loop.step}", "[fmus]"]
        + [f'{fmu}_1 = "{fmu}_1.fmu"' for fmu in loop.fmus]
        + ["[connections]"]
        + [f'{source}_1.{output} = "{target}_1.{input}"' for source, output, target, input in loop.connections]
        + ["[settings]"]
    ), encoding="utf-8")
    expected = [{name.replace(".", "_1.", 1): value for name, value in row.items()}
                for row in test_masters.by_fmpy(loop, open_fmu)[:50]]
    monkeypatch.setattr(host, "FOLDER", folder)
    untouched = test_masters.Loop(description)
    recorded = test_masters.MASTERS[master](untouched, presets.__getitem__, pack, command)
    test_masters.assert_equal(recorded, expected)


# --- The command -----------------------------------------------------------------------------------


@pytest.fixture
def plcfmu(command, tmp_path):
    def plcfmu(*arguments):
        return subprocess.run([command, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True)

    return plcfmu


@pytest.fixture
def plant(tmp_path):
    """Forty loops in a file."""
    loops = {f"TIC{101 + i}": {"MAN_ON": False, "GAIN": 1.0 + i / 8, "TI": 20.0 + i, "LMN_LLM": 5.0} for i in range(40)}
    path = tmp_path / "plant.json"
    path.write_text(json.dumps(loops))
    return path


def test_all_loops_of_a_file_become_presets(plcfmu, plant, open_fmu, tmp_path):
    done = plcfmu("preset", plant, "--fmus", host.FOLDER, "--out", "presets")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    paths = sorted((tmp_path / "presets").iterdir())
    assert len(lines) == len(paths) == 40
    fmus = [host.Fmu(path, tmp_path / path.stem) for path in paths]
    for i, (fmu, line) in enumerate(zip(fmus, lines)):
        assert line.split() == [f"TIC{101 + i}", "CONT_C", fmu.description.guid, os.path.join("presets", fmu.path.name)]
    assert len({fmu.description.guid for fmu in fmus}) == 40
    assert fmus[3].start().values() == open_fmu("CONT_C").start(
        MAN_ON=0, GAIN=1.375, TI=23.0, LMN_LLM=5.0).values()
    checked = plcfmu("check", *paths)
    assert checked.returncode == 0 and "remark" not in checked.stdout, checked.stdout


def test_the_same_values_give_the_same_bytes(plcfmu, plant, tmp_path):
    for folder in "ab":
        assert plcfmu("preset", plant, "--fmus", host.FOLDER, "--loop", "TIC101", "--out", folder).returncode == 0
    assert (tmp_path / "a/TIC101.fmu").read_bytes() == (tmp_path / "b/TIC101.fmu").read_bytes()


def test_a_preset_has_what_the_original_has_but_the_reference_results_and_the_sources(preset, open_fmu):
    with zipfile.ZipFile(open_fmu("CONT_C").path) as original, zipfile.ZipFile(preset.path) as archive:
        kept = {name for name in original.namelist() if "fmi-ls-ref" not in name and not name.startswith("sources/")}
        assert set(archive.namelist()) == kept | {START}
        changed = {name for name in kept if archive.read(name) != original.read(name)}
        assert changed == {"modelDescription.xml", "documentation/index.html"}
        page = archive.read("documentation/index.html").decode()
    assert page.index("Preset TIC101") < page.index("Ranges are not enforced")
    assert "2.7182817" in page and preset.description.guid in page and "extra/" not in page


def test_loops_without_an_fmu_are_named_and_nothing_is_written(plcfmu, plant, tmp_path):
    done = plcfmu("preset", plant, "--fmus", host.FOLDER / "CONT_S.fmu", "--out", "presets")
    assert done.returncode == 1 and "no FMU for CONT_C (used by TIC101, TIC102" in done.stderr
    assert not (tmp_path / "presets").exists()


def test_loops_that_would_have_the_same_file_are_refused(plcfmu, tmp_path):
    (tmp_path / "two.json").write_text('{"TIC 1": {"GAIN": 1.0, "TI": 20.0, "TD": 1.0}, "tic-1": {"GAIN": 2.0, "TI": 20.0, "TD": 1.0}}')
    done = plcfmu("preset", "two.json", "--fmus", host.FOLDER)
    assert done.returncode == 1 and '"TIC 1" and "tic-1" would both be written as tic_1.fmu' in done.stderr
    done = plcfmu("preset", "two.json", "--fmus", host.FOLDER, "--loop", "tic-1", "-o", "b.fmu")
    assert done.returncode == 0 and done.stdout.startswith("tic_1  CONT_C  {")


def test_a_value_outside_its_range_is_taken_with_a_warning(plcfmu):
    done = plcfmu("preset", host.FOLDER / "CONT_C.fmu", "--set", "DEADB_W=-1", "--set", "GAIN=0", "-o", "a.fmu")
    assert done.returncode == 0, done.stderr
    assert "warning: a: DEADB_W" in done.stderr and "warning: a: GAIN" in done.stderr


@pytest.mark.parametrize("setting, reason", [
    ("GAIN=x", "is not a number"), ("GAINS=1", "has no input or parameter GAINS"), ("LMN=1", "has no input or parameter LMN"),
    ("TI=-1", "a TIME accepts 0 ... 2147483.647 s"), ("CYCLE=0", "at least 0.001 s"), ("MAN_ON=2", "a BOOL accepts 0 and 1"),
    ("PV_PER=70000", "a WORD accepts"),
])
def test_a_value_that_the_fmu_does_not_take_is_refused(plcfmu, setting, reason, tmp_path):
    done = plcfmu("preset", host.FOLDER / "CONT_C.fmu", "--set", setting, "-o", "a.fmu")
    assert done.returncode != 0 and reason in done.stderr and not (tmp_path / "a.fmu").exists(), done.stderr


def test_the_original_is_not_overwritten(plcfmu, open_fmu, tmp_path):
    shutil.copy(open_fmu("CONT_C").path, tmp_path / "CONT_C.fmu")
    done = plcfmu("preset", "CONT_C.fmu", "--set", "GAIN=1", "-o", "CONT_C.fmu")
    assert done.returncode == 1 and "write to another file" in done.stderr


def packed(fmu, path, **files):
    """The preset with other files; None leaves one out."""
    with zipfile.ZipFile(fmu.path) as archive, zipfile.ZipFile(path, "w") as other:
        for name in archive.namelist():
            content = files.get(pathlib.PurePosixPath(name).stem, archive.read(name))
            if content is not None:
                other.writestr(name, content)
    return path


def test_check_says_what_is_wrong_with_a_preset(plcfmu, preset, open_preset, tmp_path):
    start = (preset.folder / START).read_text()
    description = (preset.folder / "modelDescription.xml").read_text()
    other = (open_preset("CONT_S").folder / START).read_text()

    def verdict(**files):
        done = plcfmu("check", packed(preset, tmp_path / "x.fmu", **files))
        assert done.returncode == 1
        return done.stdout

    assert "one of them was changed or replaced" in verdict(start=start.replace("GAIN = 2.7", "GAIN = 3.7"))
    assert "start values, resources/start.txt, are missing" in verdict(start=None)
    assert '"CONT_S_PRESET"' in verdict(start=other)
    assert "resources/start.txt: line 1 is" in verdict(start="hello\n")
    changed = description.replace('start="60.5"', 'start="61.0"')
    assert changed != description
    assert "SP_INT is 60.5 in resources/start.txt, but 61.0 in modelDescription.xml" in verdict(modelDescription=changed)


def test_info_says_of_what_an_fmu_is_a_preset(plcfmu, preset, open_fmu):
    done = plcfmu("info", preset.path)
    assert f"Preset          of CONT_C, {open_fmu('CONT_C').description.guid}" in done.stdout
    assert "Preset" not in plcfmu("info", open_fmu("CONT_C").path).stdout


def test_presets_merge_if_they_are_the_same(plcfmu, preset, open_preset, tmp_path):
    same = plcfmu("merge", preset.path, packed(preset, tmp_path / "b.fmu"), "--out", "c.fmu")
    assert same.returncode == 0, same.stderr
    done = plcfmu("merge", preset.path, open_preset("CONT_C").path, "--out", "d.fmu")
    assert done.returncode == 1 and "model descriptions differ" in done.stderr


@host.in_fmpy
def test_plcfmu_runs_presets(plcfmu, preset):
    done = plcfmu("run", preset.path, "--stop", "2", "--record", "TIC101.LMN")
    assert done.returncode == 0 and "TIC101.LMN  81" in done.stdout, done.stderr


def test_an_fmu_of_another_tool_cannot_be_a_preset(plcfmu, open_fmu, tmp_path):
    """Without the table in its library, as other tools' FMUs are."""
    path = open_fmu("CONT_C").path
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(tmp_path / "foreign.fmu", "w") as other:
        for name in archive.namelist():
            other.writestr(name, archive.read(name).replace(b"plcfmu_interface", b"others_interface"))
    done = plcfmu("preset", "foreign.fmu", "--set", "GAIN=1", "-o", "a.fmu")
    assert done.returncode == 1 and "it was not made by plcfmu" in done.stderr
