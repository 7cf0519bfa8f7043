"""The Python wheel: built, installed in an empty environment, and used as a user does: the command, the FMUs by name, a
closed loop in ten lines. And the archive with the command alone."""

import importlib.util
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile

import pytest
from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection

import forty_loops
import host
from files import rows

ROOT = pathlib.Path(__file__).parents[1]
BUILD = ROOT / "plcfmu" / "python" / "build_wheel.py"
TRY = BUILD.with_name("try_release.py")
MISSING = [module for module in ("maturin", "ziglang") if importlib.util.find_spec(module) is None]

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="the wheel is made for Linux only"),
    pytest.mark.skipif(bool(MISSING), reason=f"{' and '.join(MISSING)} not installed (tests/requirements.txt)"),
]


def build(out, **variables):
    """The wheel, the archive and its bill of materials; not optimized, which takes less time and changes nothing that is tested here."""
    command = [sys.executable, str(BUILD), "--fmus", str(host.FOLDER), "--out", str(out), "--archive"]
    quick = {"CARGO_PROFILE_COMMAND_OPT_LEVEL": "0", "CARGO_PROFILE_COMMAND_LTO": "off"}
    variables = {**os.environ, **quick, **variables}
    built = subprocess.run(command, env=variables, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    wheel, archive, bill = map(pathlib.Path, built.stdout.splitlines()[-3:])
    assert {wheel, archive, bill} == set(out.iterdir())
    return wheel, archive, bill


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return build(tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def wheel(files):
    return files[0]


class Installation:
    """A Python environment with nothing but the wheel, and what the wheel depends on."""

    def __init__(self, folder, wheel):
        self.folder = folder
        venv.create(folder / "venv", with_pip=False)
        self.programs = folder / "venv" / "bin"
        (self.packages,) = (folder / "venv" / "lib").glob("python*/site-packages")
        # The dependencies are those of this environment, so that the test needs no connection.
        (self.packages / "dependencies.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
        pip = [sys.executable, "-m", "pip", "--python", str(self.programs / "python"), "install"]
        subprocess.run([*pip, "--quiet", "--no-deps", "--no-index", str(wheel)], check=True)

    def run(self, program, *arguments):
        """What a program of the environment writes, started in an empty folder."""
        here = self.folder / "somewhere"
        here.mkdir(exist_ok=True)
        hidden = ("PYTHONPATH", "PLCFMU_COMMAND", "PLCFMU_FMUS", "VIRTUAL_ENV")
        variables = {name: value for name, value in os.environ.items() if name not in hidden}
        command = [str(self.programs / program), *map(str, arguments)]
        done = subprocess.run(command, cwd=here, env=variables, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def python(self, code):
        return self.run("python", "-c", code)


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    return Installation(tmp_path_factory.mktemp("a user's"), wheel)


def metadata(archive, name):
    (path,) = (path for path in archive.namelist() if path.endswith(f".dist-info/{name}"))
    return archive.read(path).decode()


def test_the_wheel_is_for_any_python_3_on_any_linux_since_2014(wheel):
    version, python, abi, platforms = wheel.name.removeprefix("plcfmu-").removesuffix(".whl").split("-")
    assert (python, abi) == ("py3", "none")
    machine = os.uname().machine
    assert set(platforms.split(".")) == {f"manylinux_2_17_{machine}", f"manylinux2014_{machine}"}
    with zipfile.ZipFile(wheel) as archive:
        assert f"Version: {version}\n" in metadata(archive, "METADATA")
        assert f'\nversion = "{version}"\n' in (ROOT / "Cargo.toml").read_text(encoding="utf-8")
        (command,) = (name for name in archive.namelist() if name.endswith("/scripts/plcfmu"))
        elf = ELFFile(io.BytesIO(archive.read(command)))
    needed = [
        tuple(map(int, version.name.removeprefix("GLIBC_").split(".")))
        for section in elf.iter_sections()
        if isinstance(section, GNUVerNeedSection)
        for _, versions in section.iter_versions()
        for version in versions
        if re.fullmatch(r"GLIBC_[0-9.]+", version.name)
    ]
    assert max(needed) <= (2, 17)


def test_the_wheel_has_every_fmu_and_the_licences(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = [name for name in archive.namelist() if name.startswith("plcfmu/fmus/")]
        assert names == [f"plcfmu/fmus/{name}.fmu" for name in host.names()]
        for name in names:
            assert archive.read(name) == (host.FOLDER / pathlib.PurePosixPath(name).name).read_bytes()
        licenses = {pathlib.PurePosixPath(name).name for name in archive.namelist() if ".dist-info/licenses/" in name}
        notice = archive.read(next(name for name in archive.namelist() if name.endswith("/licenses/NOTICE.txt"))).decode()
    assert licenses == {"LICENSE-APACHE", "LICENSE-MIT", "NOTICE.txt"}
    # Crates that are linked, also through others, and what is no crate; but not what tests and build scripts need.
    for crate in ("clap_builder", "epaint_default_fonts", "libloading", "usvg"):
        assert re.search(rf"^- {crate} [0-9.]+: .", notice, re.M), crate
    for text in ("Copyright © 2015, Simonas Kazlauskas", "UBUNTU FONT LICENCE", "UNICODE LICENSE V3", "Rust standard library"):
        assert text in notice, text
    for crate in ("bindgen", "clap_derive", "plcfmu"):
        assert not re.search(rf"^- {crate} ", notice, re.M), crate


def test_the_same_command_and_fmus_give_the_same_wheel_and_archive(files, tmp_path):
    again = build(tmp_path / "again", TZ="Asia/Tokyo")
    assert [path.read_bytes() for path in again] == [path.read_bytes() for path in files]


def test_the_archive_has_the_command_of_the_wheel_and_the_licences(files, tmp_path):
    wheel, packed, _ = files
    version = wheel.name.split("-")[1]
    with tarfile.open(packed) as archive:
        archive.extractall(tmp_path)
    (folder,) = tmp_path.iterdir()
    assert folder.name.startswith(f"plcfmu-{version}-") and packed.name == f"{folder.name}.tar.gz"
    names = {"LICENSE-APACHE", "LICENSE-MIT", "NOTICE.txt", "README.md", "plcfmu", "programs"}
    assert {path.name for path in folder.iterdir()} == names
    shown = subprocess.run([folder / "plcfmu", "--version"], stdout=subprocess.PIPE, text=True, check=True)
    assert shown.stdout == f"plcfmu {version}\n"
    with zipfile.ZipFile(wheel) as archive:
        (command,) = (name for name in archive.namelist() if name.endswith("/scripts/plcfmu"))
        assert archive.read(command) == (folder / "plcfmu").read_bytes()


def test_the_bill_of_materials_names_the_crates_of_the_notice_with_their_licences(files):
    wheel, _, bill = files
    with zipfile.ZipFile(wheel) as archive:
        notice = archive.read(next(name for name in archive.namelist() if name.endswith("/licenses/NOTICE.txt"))).decode()
    content = json.loads(bill.read_text())
    assert (content["bomFormat"], content["specVersion"], bill.name.endswith("-linux64.cdx.json")) == ("CycloneDX", "1.6", True)
    listed = [f"- {c['name']} {c['version']}: {c['licenses'][0]['expression']}" for c in content["components"]]
    assert listed == re.findall(r"^- \S+ [0-9]\S*: .*$", notice, re.M)
    assert all(c["purl"] == f"pkg:cargo/{c['name']}@{c['version']}" for c in content["components"])


def test_plcfmu_info_shows_an_fmu_of_the_wheel(installed):
    fmu = installed.packages / "plcfmu" / "fmus" / "CONT_C.fmu"
    text = installed.run("plcfmu", "info", fmu)
    assert text.startswith(f"{fmu}\n")
    assert "Continuous PID controller" in text
    assert re.search(r"^\s+GAIN\s", text, re.M)


def test_plcfmu_run_closes_a_loop_of_two_fmus_of_the_wheel(installed):
    fmus = installed.packages / "plcfmu" / "fmus"
    values = ["MAN_ON=false", "SP_INT=60", "PVPER_ON=true", "PV_FAC=4", "GAIN=1.4", "TI=80", "CYCLE=1"]
    text = installed.run(
        "plcfmu", "run", fmus / "CONT_C.fmu", fmus / "HEATER.fmu",
        "--connect=CONT_C.LMN=HEATER.POWER", "--connect=HEATER.T_PER=CONT_C.PV_PER",
        *(f"--set=CONT_C.{value}" for value in values),
        "--step=1", "--stop=900", "--out=-", "--record=HEATER.TEMP", "--record=CONT_C.LMN",
    )  # fmt: skip
    recorded = rows(text)
    assert len(recorded) == 901
    assert float(recorded[0]["HEATER.TEMP"]) == 20.0
    assert abs(float(recorded[-1]["HEATER.TEMP"]) - 60.0) < 0.5


def tried(folder):
    """What is said of the wheel and the archive in a folder, tried as a release is before it is attached."""
    return subprocess.run([sys.executable, str(TRY), str(folder)], capture_output=True, text=True)


def test_wheel_and_archive_build_a_program_and_run_it_with_nothing_around(files):
    done = tried(files[0].parent)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "".join(f"{path.name}: builds a program and runs it\n" for path in files[:2])


def test_an_archive_without_the_library_of_programs_does_not_pass(files, tmp_path):
    wheel, packed, _ = files
    shutil.copy(wheel, tmp_path)
    with tarfile.open(packed) as archive, tarfile.open(tmp_path / packed.name, "w:gz") as lacking:
        for member in archive:
            if "/programs/" not in member.name:
                lacking.addfile(member, archive.extractfile(member))
    done = tried(tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith(f"error: {packed.name}: plcfmu build tank.scl --cycle=500ms exited with status 1:\n")
    assert "the program library is missing: it belongs in the folder programs next to " in done.stderr


def test_the_package_of_the_wheel_finds_the_fmus_of_the_wheel(installed):
    lines = installed.python("import plcfmu; print(plcfmu.fmu('CONT_C'), *plcfmu.fmu_names(), sep='\\n')").splitlines()
    assert pathlib.Path(lines[0]) == installed.packages / "plcfmu" / "fmus" / "CONT_C.fmu"
    assert lines[1:] == host.names()


def test_the_package_of_the_wheel_reads_parameters_with_the_command_of_the_wheel(installed):
    code = (
        "import plcfmu; from plcfmu import parameters; print(parameters.command());"
        f"print(len(plcfmu.params({str(forty_loops.FILE)!r})))"
    )
    assert installed.python(code).splitlines() == [str(installed.programs / "plcfmu"), "40"]


def test_the_ten_lines_of_the_readme_close_a_loop(installed):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```$", readme, re.M | re.S)
    assert code.count("\n") <= 10
    # The setpoint in the text is 60 degC.
    assert abs(float(installed.python(code)) - 60.0) < 0.5


def test_a_folder_without_fmus_is_refused_in_one_sentence(tmp_path):
    command = [sys.executable, str(BUILD), "--fmus", str(tmp_path), "--out", str(tmp_path / "out")]
    refused = subprocess.run(command, capture_output=True, text=True)
    assert refused.returncode == 1
    assert refused.stderr == (
        f"error: no FMU in {tmp_path}: build them with `cargo xtask fmu`, or name another folder with --fmus\n"
    )
    assert not (tmp_path / "out").exists()


def test_fmus_without_a_library_of_programs_are_refused(tmp_path):
    (tmp_path / "PUMP.fmu").write_bytes(b"")
    command = [sys.executable, str(BUILD), "--fmus", str(tmp_path), "--out", str(tmp_path / "out")]
    refused = subprocess.run(command, capture_output=True, text=True)
    assert refused.returncode == 1
    assert refused.stderr.startswith(f"error: no program library in {tmp_path / 'programs'}")
    assert not (tmp_path / "out").exists()
