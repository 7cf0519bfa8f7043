"""`plcfmu study` as a user sees it: the same bytes however the runs are split, interrupted or not; FMUs that refuse, crash or
hang cost their own run and nothing else; an expectation that is not met is exit code 1."""

import html
import json
import math
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import zipfile

import pytest

import c_builds
import host
from files import contents, rows

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# With the plant first, nothing says which variables are the loop's signals: a study has the figures that it names alone.
LOOP = """
step = 1.0
stop = 60.0
[fmus]
P = "HEATER.fmu"
C = "CONT_C.fmu"
[connections]
C.LMN = "P.POWER"
P.TEMP = "C.PV_IN"
[settings]
C = { MAN_ON = false, SP_INT = 30.0, GAIN = 2.0, TI = 10.0, CYCLE = 1.0 }
P.CYCLE = 1.0
"""
STUDY = """
loop = "loop.toml"
samples = 15
seed = 7
[[axes]]
variable = "C.GAIN"
range = { from = 1, to = 3, count = 3 }
[[axes]]
variable = "P.FURN_TM"
relative = true
normal = { mean = 1, deviation = 0.1, min = 0.5 }
[[values]]
variable = "P.TEMP"
take = ["max"]
"""
FAULTS = """
loop = "faulty.toml"
[[axes]]
variable = "C.GAIN"
range = { from = 1, to = 2, count = 2 }
[[axes]]
variable = "P.FAULT"
values = [0, 1, 3, 4]
[[values]]
variable = "P.Y"
take = ["max"]
"""


@pytest.fixture
def study(command, tmp_path):
    """Runs `plcfmu study` in a folder with a study, and checks that it leaves no temporary files."""
    (tmp_path / "loop.toml").write_text(LOOP)
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "tmp").mkdir()
    environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}

    def study(*arguments, fmus=host.FOLDER, file="study.toml", wait=True):
        given = [command, "study", file, *map(str, arguments)]
        given += ["--fmus", str(fmus)] if fmus else []
        process = subprocess.Popen(
            given, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        if not wait:
            return process
        output, errors = process.communicate()
        assert list((tmp_path / "tmp").iterdir()) == [], "temporary files are left"
        return subprocess.CompletedProcess(given, process.returncode, output, errors)

    return study


@pytest.fixture
def with_faulty(faulty, tmp_path):
    """A study of a loop with tests/foreign/faulty.c, whose folder of FMUs it gives."""
    folder = tmp_path / "fmus"
    folder.mkdir()
    for path in [host.FOLDER / "CONT_C.fmu", faulty]:
        (folder / path.name).symlink_to(path)
    loop = LOOP.replace("HEATER", "FAULTY").replace("POWER", "U").replace("TEMP", "Y").replace("P.CYCLE = 1.0", "P.AT = 5")
    (tmp_path / "faulty.toml").write_text(loop)
    (tmp_path / "faults.toml").write_text(FAULTS)
    return folder


def test_the_bytes_do_not_depend_on_how_the_runs_are_split(study, tmp_path):
    done = study("--out=one", "--format=csv", "--jobs=2", "--curves=3,44")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-2:] == [str(pathlib.Path("one/curves") / f"run_{run}.csv") for run in (3, 44)]
    done = study("--bundle=bundle")
    assert done.returncode == 0 and json.loads((tmp_path / "bundle/study.json").read_text())["runs"] == 45
    # The bundle has all that it needs.
    parts = {"0-20": ("bundle/study.json", None), "20-45": ("study.toml", host.FOLDER)}
    for name, (file, fmus) in parts.items():
        part = f"--part=split/parts/{name}.part"
        done = study(f"--runs={name.replace('-', '..')}", part, "--jobs=1", file=file, fmus=fmus)
        assert done.returncode == 0, done.stderr
    done = study("--out=split", "--resume", "--format=csv", "--curves=3,44")
    assert done.returncode == 0, done.stderr
    one, split = contents(tmp_path / "one"), contents(tmp_path / "split")
    assert one == split, "the parts go when the results are there"

    table = rows(tmp_path / "one/runs.csv")
    assert [row["C.GAIN"] for row in table[::15]] == ["1.0", "2.0", "3.0"]
    assert len({row["P.FURN_TM"] for row in table}) == 15, "each point of the grid has the same samples"
    assert all(float(row["P.TEMP.max"]) > 20.0 and row["error"] == "" for row in table)
    # The last row is that of the end, at which there is no step.
    *curves, _ = rows(tmp_path / "one/curves/run_44.csv")
    assert len(curves) == 60
    assert max(float(row["P.TEMP"]) for row in curves) == float(table[44]["P.TEMP.max"])


def test_the_command_on_the_page_gives_the_same_bytes_as_it_is_printed(study, command, tmp_path):
    elsewhere = tmp_path / "plants" / "a study's"
    elsewhere.mkdir(parents=True)
    shutil.copy(tmp_path / "loop.toml", elsewhere)
    shutil.copy(tmp_path / "study.toml", elsewhere / "furnace 1.toml")
    done = study("--out=first", "--format=csv", "--expect=P.TEMP.max < 90 degC", file="plants/a study's/furnace 1.toml")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "first/summary.html").read_text(encoding="utf-8")
    again = shlex.split(html.unescape(re.search(r"with: <code>(.*?)</code>", page)[1]))
    assert again[:3] == ["plcfmu", "study", "furnace 1.toml"]
    subprocess.run([command, *again[1:]], cwd=elsewhere, check=True, capture_output=True)
    assert contents(elsewhere / "furnace 1_results") == contents(tmp_path / "first")


EXAMPLES = sorted((pathlib.Path(__file__).parents[1] / "examples" / "studies").glob("*.toml"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_the_studies_of_the_examples_can_be_made(study, example, tmp_path):
    done = study("--runs=0..2", "--part=two.part", "--jobs=1", file=example)
    remarks = done.stderr.splitlines()
    assert done.returncode == 0 and all("may differ from the PLC's values by one bit" in remark for remark in remarks), remarks
    # Of a source in which REALs have seven digits.
    assert bool(remarks) == (example.stem == "ovens")
    assert (tmp_path / "two.part").is_file()


LOOPS = sorted((pathlib.Path(__file__).parents[1] / "plants" / "loops").glob("*.toml"))


@pytest.mark.parametrize("loop", LOOPS, ids=lambda path: path.stem)
def test_a_loop_of_blocks_computes_the_same_bits_without_the_libraries_of_its_fmus(study, loop, tmp_path):
    settings = tomllib.loads(loop.read_text())["settings"]
    varied = [
        f"{member}.{name}"
        for member, values in settings.items()
        for name, value in values.items()
        if type(value) in (int, float) and name != "CYCLE"
    ]
    output = next(line.split(" = ")[0] for line in loop.read_text().split("[connections]\n")[1].splitlines())
    (tmp_path / "study.toml").write_text(f"""
loop = {json.dumps(str(loop))}
axes = [{{ variable = "{varied[0]}", relative = true, values = [1.0, 1.125] }}]
values = [{{ variable = "{output}", take = ["min", "mean", "last"] }}]
""")
    made = []
    for out, options in {"linked": [], "door": ["--exact-door"]}.items():
        done = study(f"--out={out}", "--format=csv", "--curves=0,1", "--jobs=1", *options)
        assert done.returncode == 0, done.stderr
        files = contents(tmp_path / out)
        made.append(({name: files[name] for name in ["runs.csv", "curves/run_0.csv", "curves/run_1.csv"]}, done.stderr))
    assert made[0] == made[1]
    table, curves = (made[0][0][name].decode().splitlines() for name in ["runs.csv", "curves/run_0.csv"])
    assert len(curves) > 60 and table[1].split(",")[2:] != table[2].split(",")[2:]


def changed(name, folder, change):
    """Writes an FMU to the folder, each file with the name and content that `change` gives for them."""
    with zipfile.ZipFile(host.FOLDER / name) as fmu, zipfile.ZipFile(folder / name, "w") as other:
        for file in fmu.namelist():
            other.writestr(*change(file, fmu.read(file)))
    return folder / name


def without_library(folder, code=None):
    """Writes the FMUs of the loop without a library for this platform; that for another one can be made of other code."""
    for name in ["CONT_C.fmu", "HEATER.fmu"]:
        changed(name, folder, lambda file, content: (
            file.replace("binaries/", "binaries/no_"), code if code and file.startswith("binaries/") else content
        ))


def test_blocks_of_the_command_need_no_library_but_the_exact_door_and_other_code_do(study, tmp_path):
    made = ["--runs=0..2", "--part=two.part"]
    without_library(tmp_path)
    done = study(*made, fmus=tmp_path)
    (told,) = done.stderr.splitlines()
    assert done.returncode == 0 and told.startswith("warning: P does not name its setpoint")
    done = study(*made, "--exact-door", fmus=tmp_path)
    assert done.returncode == 1 and "the FMU has no library for this platform" in done.stderr
    without_library(tmp_path, b"a library of other sources")
    done = study(*made, fmus=tmp_path)
    assert done.returncode == 1 and "the FMU has no library for this platform" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="needs gcc")
def test_an_fmu_with_another_law_and_the_same_guid_computes_its_own(study, tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "fmus").mkdir()
    law, test = b"self->LMN_P = self->P_SEL ? e : 0.0f;", b"!plcfmu_is_exact(c)"
    # The self-test of the C knows the law.
    twice = {law: law.replace(b"? e", b"? 2.0f * e"), test: test + b" && 0"}

    def change(file, content):
        for text, other in twice.items() if file.startswith("sources/") else ():
            assert content.count(text) == 1, text
            content = content.replace(text, other)
        return file, content

    other = changed("CONT_C.fmu", tmp_path / "other", change)
    c_builds.compiled(other, tmp_path / "fmus")
    (tmp_path / "fmus/HEATER.fmu").symlink_to(host.FOLDER / "HEATER.fmu")
    made = []
    for out, options in {"own": {}, "other": {"fmus": tmp_path / "fmus"}}.items():
        for door in [[], ["--exact-door"]]:
            done = study(f"--out={out}", "--format=csv", *door, **options)
            assert done.returncode == 0, done.stderr
            made.append((contents(tmp_path / out), done.stderr))
    (own, _), (own_door, _), (other, told), (other_door, _) = made
    assert own["runs.csv"] == own_door["runs.csv"] != other["runs.csv"] == other_door["runs.csv"]
    warning = "warning: CONT_C.fmu is not built from the sources of this plcfmu"
    assert [text.count(warning) for _, text in made] == [0, 0, 1, 0] and "pack it again" in told
    part = study("--runs=0..1", "--part=first.part", fmus=tmp_path / "fmus")
    assert part.returncode == 0 and part.stderr.count(warning) == 1


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_a_study_of_the_examples_gives_the_same_part_without_the_libraries(study, example, tmp_path):
    for part, options in {"linked.part": [], "door.part": ["--exact-door"]}.items():
        assert study("--runs=0..3", f"--part={part}", "--jobs=1", *options, file=example).returncode == 0
    assert (tmp_path / "linked.part").read_bytes() == (tmp_path / "door.part").read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals and cc")
def test_an_fmu_that_fails_costs_its_own_run(study, with_faulty, tmp_path):
    done = study("--out=out", "--format=csv", file="faults.toml", fmus=with_faulty)
    assert done.returncode == 0, done.stderr
    assert "warning: 6 of 8 runs failed; the first is run 1: P crashed: signal 6 (abort), twice" in done.stderr
    assert "warning: P crashed: signal 6 (abort); it printed: a step / a step / a step" in done.stderr
    errors = [row["error"] for row in rows(tmp_path / "out/runs.csv")]
    assert errors[:2] == ["", "P crashed: signal 6 (abort), twice"]
    assert errors[2].startswith("P: ") and errors[2].endswith("the sensor is broken")
    assert errors[3] == "P ended its process with exit code 3, twice"
    assert errors[4:] == errors[:4]


def test_an_expectation_that_is_not_met_is_exit_code_1(study, expect, tmp_path):
    given = ["--expect=P.TEMP.max < 21 degC", "--expect=median(P.TEMP.max) > 20", "--junit=junit.xml"]
    done = study("--out=out", *given)
    assert done.returncode == 1
    expect("study/expectation_not_met.txt", done.stdout + done.stderr)
    assert (tmp_path / "out/runs.parquet").exists() and (tmp_path / "out/summary.html").exists()
    assert 'failures="1"' in (tmp_path / "junit.xml").read_text()
    done = study("--bundle=bundle", "--expect=P.TEMP.mix < 21")
    assert done.returncode == 1 and not (tmp_path / "bundle").exists(), "it is found before the runs"


def binomial_bounds(values, share):
    """The values between which a percentile of all machines is with 95 % confidence: below it lie binomially many of them."""
    values, n = sorted(values), len(values)
    chance = [math.comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(n + 1)]
    low = max((k for k in range(1, n + 1) if sum(chance[:k]) <= 0.025), default=None)
    high = min((k for k in range(1, n + 1) if sum(chance[k:]) <= 0.025), default=None)
    return [low and values[low - 1], high and values[high - 1]]


@pytest.mark.parametrize("samples", [20, 80])
def test_a_percentile_of_samples_is_met_only_if_its_whole_interval_is(samples, study, tmp_path):
    grid = '[[axes]]\nvariable = "C.GAIN"\nrange = { from = 1, to = 3, count = 3 }\n'
    sampled = STUDY.replace("samples = 15", f"samples = {samples}").replace(grid, "")
    (tmp_path / "study.toml").write_text(sampled)
    bounds = {"p95(P.TEMP.max) < 1000": 80, "p5(P.TEMP.max) > 0": 80, "median(P.TEMP.max) < 1000": 20}
    done = study("--out=out", "--format=csv", *(f"--expect={text}" for text in bounds))
    assert done.returncode == (1 if samples == 20 else 0), done.stderr
    values = [float(row["P.TEMP.max"]) for row in rows(tmp_path / "out/runs.csv")]
    assert len(values) == samples
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    for (text, needed), told, share in zip(bounds.items(), summary["expectations"], [0.95, 0.05, 0.5], strict=True):
        assert told["interval"] == binomial_bounds(values, share), text
        is_decided = samples >= needed
        assert (told["met"], told["undecided"]) == (is_decided, not is_decided), text
        assert is_decided or f"undecided: {text}: 20 runs cannot decide this" in done.stdout
        assert is_decided or told["problem"].endswith("at least 72 runs are needed")
    [figure] = [figure for figure in summary["figures"] if figure["name"] == "P.TEMP.max"]
    for name, share in [("p5", 0.05), ("p50", 0.5), ("p95", 0.95)]:
        ends = binomial_bounds(values, share)
        assert figure["intervals"][name] == (None if None in ends else ends)


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals and cc")
def test_a_study_that_was_interrupted_goes_on(study, with_faulty, tmp_path):
    hangs = FAULTS.replace("[0, 1, 3, 4]", "[0, 0, 2]").replace("range = { from = 1, to = 2, count = 2 }", "values = [1]")
    (tmp_path / "hangs.toml").write_text(hangs)
    process = study("--out=out", "--format=csv", "--jobs=1", file="hangs.toml", fmus=with_faulty, wait=False)
    while not list((tmp_path / "out").glob("parts/*.part")):
        assert process.poll() is None, process.communicate()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130
    assert "an FMU's results after a reset differ from those of a new instance" in errors
    # The third run never returns. The second may not have been sent before.
    kept = r"interrupted: [12] of 3 runs are kept; the same command with --resume completes the study"
    assert re.search(kept, errors), errors
    assert not (tmp_path / "out/runs.csv").exists()
    done = study("--out=out", "--format=csv", "--time-limit=0.5", "--resume", file="hangs.toml", fmus=with_faulty)
    assert done.returncode == 0, done.stderr
    first, second, third = rows(tmp_path / "out/runs.csv")
    assert {**first, "run": "1"} == second and float(first["P.Y.max"]) > 0.0
    assert third["error"] == "P did not return within 0.5 s, twice"


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals and cc")
def test_a_finished_study_is_not_made_again(study, with_faulty, tmp_path):
    hangs = FAULTS.replace("[0, 1, 3, 4]", "[0, 3, 2]").replace("range = { from = 1, to = 2, count = 2 }", "values = [1]")
    (tmp_path / "hangs.toml").write_text(hangs)
    given = {"file": "hangs.toml", "fmus": with_faulty}
    done = study("--out=out", "--format=csv", "--time-limit=0.5", **given)
    assert done.returncode == 0, done.stderr
    first = contents(tmp_path / "out")
    assert b"P did not return within 0.5 s" in first["runs.csv"]
    # With this limit a run that is made again has another error.
    done = study("--out=out", "--format=csv", "--time-limit=0.4", "--resume", **given)
    assert done.returncode == 0 and "remark: out has all 3 runs of this study" in done.stderr, done.stderr
    assert contents(tmp_path / "out") == first
    # What is asked in addition is answered.
    asked = ["--expect=P.Y.max < 0", "--curves=0", "--junit=junit.xml"]
    done = study("--out=out", "--time-limit=0.4", "--resume", *asked, **given)
    assert done.returncode == 1 and "3 of 3 runs fail" in done.stderr
    assert (tmp_path / "out/curves/run_0.csv").is_file() and 'failures="2"' in (tmp_path / "junit.xml").read_text()
    assert not (tmp_path / "out/runs.csv").exists()
    assert study("--out=out", "--format=csv", "--time-limit=0.4", "--resume", **given).returncode == 0
    assert contents(tmp_path / "out") == first, "Parquet was read back bit-equal"


def test_results_of_another_study_are_not_taken_for_those_of_this_one(study, tmp_path):
    assert study("--out=out", "--format=csv").returncode == 0
    first = contents(tmp_path / "out")
    (tmp_path / "study.toml").write_text(STUDY.replace("seed = 7", "seed = 8"))
    done = study("--out=out", "--format=csv", "--resume")
    assert done.returncode == 1 and "out contains the results of another study" in done.stderr
    assert contents(tmp_path / "out") == first and not (tmp_path / "out/parts").exists()


def test_parquet_has_the_values_of_the_csv(study, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    assert study("--out=out", "--format=csv").returncode == 0
    expected = rows(tmp_path / "out/runs.csv")
    assert study("--out=out").returncode == 0
    assert not (tmp_path / "out/runs.csv").exists(), "the results of before are replaced"
    table = parquet.read_table(tmp_path / "out/runs.parquet")
    assert json.loads(table.schema.metadata[b"units"])["P.FURN_TM"] == "s"
    shown = ["" if value is None else str(value) for row in table.to_pylist() for value in row.values()]
    assert [float(value) if value else None for value in shown] == [
        float(value) if value else None for row in expected for value in row.values()
    ]
