"""The packed FMUs: what is in the archive, and that it says the truth."""

import hashlib
import html.parser
import re
import struct
import subprocess
import zipfile
import zlib

import fmpy
import fmpy.util
import pytest
from elftools.elf.elffile import ELFFile
from lxml import etree

import host
from files import rows
from host import CONTROLLERS
from libraries import exports

REFERENCES = "extra/org.fmi-standard.fmi-ls-ref"
PLATFORM = re.compile(
    r"(linux(32|64)|win(32|64)|darwin64|(aarch64|x86_64|x86|aarch32)-(linux|windows|darwin))"
)
EXTENSION = {"linux": ".so", "win": ".dll", "darwin": ".dylib"}


@pytest.fixture
def entries(fmu):
    with zipfile.ZipFile(fmu.path) as archive:
        return archive.infolist()


# --- The archive ---------------------------------------------------------------------------------------


def test_entries_are_sorted_and_unique(entries):
    names = [entry.filename for entry in entries]
    assert names == sorted(set(names))


def test_paths_are_relative_with_slashes_and_without_surprises(entries):
    for entry in entries:
        assert "\\" not in entry.orig_filename
        assert re.fullmatch(r"[A-Za-z0-9_.+/-]+", entry.filename)
        parts = entry.filename.split("/")
        assert all(part not in ("", ".", "..") for part in parts)


def test_entries_have_one_fixed_time(entries):
    """The same sources give the same bytes."""
    assert {entry.date_time for entry in entries} == {(1980, 1, 1, 0, 0, 0)}


def test_entries_are_stored_or_deflated_and_whole(fmu, entries):
    assert {entry.compress_type for entry in entries} <= {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
    with zipfile.ZipFile(fmu.path) as archive:
        assert archive.testzip() is None
        assert archive.comment == b""


def test_the_archive_has_only_the_folders_of_the_standard(entries):
    roots = {entry.filename.split("/")[0] for entry in entries}
    assert roots - {"sources"} == {"modelDescription.xml", "binaries", "documentation", "extra", "model.png"}


# --- The libraries ---------------------------------------------------------------------------------------


def libraries(fmu):
    return sorted(path for path in (fmu.folder / "binaries").rglob("*") if path.is_file())


def test_libraries_lie_in_the_folders_of_the_standard(fmu):
    for library in libraries(fmu):
        platform = library.parent.name
        assert PLATFORM.fullmatch(platform), platform
        # Not "in": there is a "win" in "darwin64".
        (extension,) = (e for system, e in EXTENSION.items() if re.search(rf"(^|-){system}", platform))
        assert library.name == fmu.name + extension


def elf_libraries(fmu):
    found = [path for path in libraries(fmu) if path.read_bytes()[:4] == b"\x7fELF"]
    if not found:
        pytest.skip("no library for Linux in this FMU")
    return found


def test_a_library_exports_the_34_functions_and_the_packers(fmu):
    for library in libraries(fmu):
        exported = exports(library)
        if exported is not None:
            assert exported == {*host.FUNCTIONS, *host.FMI3, "plcfmu_interface"}, library.parent.name


def test_a_linux_library_needs_nothing_newer_than_glibc_2_17(fmu):
    for library in elf_libraries(fmu):
        with library.open("rb") as file:
            needed = ELFFile(file).get_section_by_name(".gnu.version_r")
            versions = {a.name for _, auxiliaries in needed.iter_versions() for a in auxiliaries}
        for version in versions:
            number = re.fullmatch(r"GLIBC_(\d+)\.(\d+)(\.\d+)?", version)
            assert number, f"{library.parent.name} needs {version}"
            assert (int(number[1]), int(number[2])) <= (2, 17), f"{library.parent.name} needs {version}"


def test_a_linux_library_needs_only_what_every_linux_has(fmu):
    """Not libgcc_s: it is not on every machine, and it would not be ours."""
    for library in elf_libraries(fmu):
        with library.open("rb") as file:
            tags = list(ELFFile(file).get_section_by_name(".dynamic").iter_tags())
        needed = {tag.needed for tag in tags if tag.entry.d_tag == "DT_NEEDED"}
        glibc = r"(libc|libm|libpthread|libdl|ld-linux[-a-z0-9_]*)\.so\."
        assert {name for name in needed if not re.match(glibc, name)} == set()
        assert not any(tag.entry.d_tag in ("DT_RPATH", "DT_RUNPATH", "DT_TEXTREL") for tag in tags)


def test_a_library_has_no_path_of_the_machine_that_built_it(fmu):
    for library in libraries(fmu):
        content = library.read_bytes()
        for path in (rb"/home/", rb"/root/", rb"/Users/", rb"/tmp/", rb"C:\Users", rb"/target/release", rb"/target/library"):
            assert path not in content


# --- Documentation ------------------------------------------------------------------------------------


class Page(html.parser.HTMLParser):
    """The text of a page and what it refers to."""

    def __init__(self, text):
        super().__init__()
        self.words = []
        self.references = []
        self.anchors = set()
        self.tags = []
        self.feed(text)
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        attributes = dict(attributes)
        self.references += [attributes[name] for name in ("src", "href", "data") if attributes.get(name)]
        if "id" in attributes:
            self.anchors.add(attributes["id"])

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture
def page(fmu):
    return Page((fmu.folder / "documentation" / "index.html").read_text(encoding="utf-8"))


def test_the_documentation_names_and_describes_every_variable(fmu, page):
    for name, variable in fmu.variables.items():
        assert re.search(rf"\b{re.escape(name)}\b", page.text), name
        # A range in words has a column of its own.
        for text in variable.description.split("; range: "):
            assert " ".join(text.replace(">=", "≥").split()) in page.text, name


def test_the_documentation_says_what_it_is_and_where_it_comes_from(fmu, page):
    assert fmu.name in page.text
    assert fmu.xml.get("description") in page.text
    assert fmu.xml.get("guid") in page.text


def test_the_documentation_of_a_controller_has_its_algorithm_and_the_sources_of_each_rule(fmu, page):
    if fmu.name in CONTROLLERS:
        for section in ("purpose", "quick-start", "diagram", "calls", "algorithm", "clauses", "limits-of-use", "sources"):
            assert section in page.anchors
        assert "Restart" in page.text
        assert re.search(r"\((manual|vendor|measured|decided|observed)", page.text)


def test_the_documentation_shows_a_diagram_and_a_response(fmu, page):
    pictures = [r for r in page.references if r.lower().endswith((".png", ".svg"))]
    assert len(pictures) + page.tags.count("svg") >= 2


def test_every_reference_of_the_documentation_is_in_the_package(fmu, page):
    for reference in page.references:
        path, _, anchor = reference.partition("#")
        if not path:
            assert anchor in page.anchors, reference
        elif not path.startswith(("https:", "mailto:")):
            assert (fmu.folder / "documentation" / path).resolve().is_file(), reference


def test_the_documentation_needs_no_network_and_runs_no_script(fmu):
    text = (fmu.folder / "documentation" / "index.html").read_text(encoding="utf-8")
    assert "<script" not in text.lower()
    assert not re.search(r"""(src|data)\s*=\s*["']?(https?:)?//""", text)
    assert not re.search(r"<link[^>]+https?:", text)


def test_the_documentation_is_html_5_in_utf_8(fmu):
    text = (fmu.folder / "documentation" / "index.html").read_bytes()
    assert text.lower().startswith(b"<!doctype html>")
    assert b"utf-8" in text[:500].lower()


def test_the_licences_are_in_the_package(fmu):
    folder = fmu.folder / "documentation" / "licenses"
    texts = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
    assert any("Apache License" in text for text in texts.values())
    assert any("Permission is hereby granted, free of charge" in text for text in texts.values())


# --- The picture ----------------------------------------------------------------------------------------


def test_model_png_is_a_picture(fmu):
    png = (fmu.folder / "model.png").read_bytes()
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    kinds, data, place = [], b"", 8
    while place < len(png):
        length, kind = struct.unpack(">I4s", png[place : place + 8])
        content = png[place + 8 : place + 8 + length]
        (checksum,) = struct.unpack(">I", png[place + 8 + length : place + 12 + length])
        assert zlib.crc32(kind + content) == checksum
        kinds.append(kind)
        data += content if kind == b"IDAT" else b""
        place += 12 + length
    assert kinds[0] == b"IHDR" and kinds[-1] == b"IEND"
    width, height = struct.unpack(">II", png[16:24])
    assert 50 <= width <= 2000 and 50 <= height <= 2000
    assert len(set(zlib.decompress(data))) > 10  # not of one colour


def test_every_fmu_has_a_picture_of_its_own(fmu, open_fmu):
    def digest(name):
        return hashlib.sha256((open_fmu(name).folder / "model.png").read_bytes()).digest()

    assert [name for name in host.names() if digest(name) == digest(fmu.name)] == [fmu.name]


# --- Reference results, after fmi-ls-ref ------------------------------------------------------------------


@pytest.fixture
def manifest(fmu):
    return etree.parse(str(fmu.folder / REFERENCES / "fmi-ls-manifest.xml")).getroot()


def table(fmu, name):
    recorded = rows(fmu.folder / REFERENCES / name)
    assert next(iter(recorded[0])) == "time"
    return recorded


def related(manifest, role):
    (element,) = manifest.findall(f"Related[@role='{role}']")
    assert element.get("type") == "text/csv"
    return element.get("source")


def test_the_manifest_is_the_layered_standards(manifest):
    namespace = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert manifest.tag == "fmiReferences"
    assert manifest.get(f"{namespace}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    assert re.match(r"1\.0\.0", manifest.get(f"{namespace}fmi-ls-version"))
    assert manifest.get(f"{namespace}fmi-ls-description") == (
        "Layered Standard providing information on related files included in an FMU."
    )


def test_every_file_of_the_references_is_listed_and_there(fmu, manifest):
    listed = {(fmu.folder / REFERENCES / r.get("source")).resolve() for r in manifest.findall("Related")}
    assert all(path.is_file() for path in listed)
    there = {path.resolve() for path in (fmu.folder / REFERENCES).iterdir()}
    assert there - listed == {(fmu.folder / REFERENCES / "fmi-ls-manifest.xml").resolve()}


def settings(fmu):
    """Fixed parameters cannot be in the input file: the text beside it names them."""
    text = (fmu.folder / "documentation" / "fmi-ls-ref.txt").read_text(encoding="utf-8")
    found = re.findall(r"^Set before the initialization ends: (\S+) = (\S+)$", text, re.MULTILINE)
    return {name: as_typed(fmu, name, value) for name, value in found}


def as_typed(fmu, name, text):
    if text in ("true", "false"):
        assert fmu.variables[name].type == "Boolean", f"{name} = {text}"
        return int(text == "true")
    return float(text) if fmu.variables[name].type == "Real" else int(float(text))


def test_the_reference_results_come_out_again_bit_for_bit(fmu, manifest):
    """Values hold from row to row; of several rows at one time the last counts."""
    inputs = table(fmu, related(manifest, "testcase"))
    results = table(fmu, related(manifest, "result"))
    shown = list(results[0])[1:]

    def row_values(row):
        return {name: as_typed(fmu, name, text) for name, text in row.items() if name != "time"}

    instance = fmu.instance()
    start = float(results[0]["time"])
    waiting = list(inputs)

    def due(time):
        values = {}
        while waiting and float(waiting[0]["time"]) <= time:
            values = row_values(waiting.pop(0))
        return values

    instance.start(start_time=start, **{**settings(fmu), **due(start)})
    for number, expected in enumerate(results):
        if number > 0:
            instance.set(**due(instance.time))
            time = float(expected["time"])
            instance.step(time - instance.time)
            instance.time = time
        got = instance.get(shown)
        assert host.exact(got) == host.exact({n: as_typed(fmu, n, expected[n]) for n in shown}), expected[
            "time"
        ]
    assert len(results) > 10
    assert any(len({row[name] for row in results}) > 1 for name in set(shown) & set(fmu.of("output")))


def test_fmpy_gets_the_reference_results_from_the_files(fmu, manifest):
    """As anybody would: input file, settings of the text beside it, communication step."""
    results = table(fmu, related(manifest, "result"))
    shown = list(results[0])[1:]
    inputs = fmpy.util.read_csv(str(fmu.folder / REFERENCES / related(manifest, "testcase")))
    step = float(results[1]["time"])
    simulated = fmpy.simulate_fmu(
        str(fmu.path),
        stop_time=float(results[-1]["time"]),
        output_interval=step,
        start_values=settings(fmu),
        input=inputs,
        output=shown,
    )
    # FMPy divides a step where an input changes; there it records a row that the results do not have.
    expected = {round(float(row["time"]) / step): row for row in results}
    compared = 0
    for row in simulated:
        point = round(row["time"] / step)
        if abs(row["time"] - point * step) < 1e-6 * step:
            got = {name: as_typed(fmu, name, repr(float(row[name]))) for name in shown}
            assert host.exact(got) == host.exact({n: as_typed(fmu, n, expected[point][n]) for n in shown}), (
                point
            )
            compared += 1
    assert compared >= len(results)


# --- What the command says of it ------------------------------------------------------------------------


@pytest.mark.parametrize("what", ["info", "check"])
def test_the_command_tells_what_is_in_it(command, open_fmu, expect, what):
    """All but the library, which differs with the machine, and the GUID."""
    path = open_fmu("HLG").path
    done = subprocess.run([command, what, path.name], cwd=path.parent, capture_output=True, text=True, encoding="utf-8")
    assert (done.returncode, done.stderr) == (0, "")
    text = re.sub(r"\{[0-9a-f-]{36}\}", "{GUID}", done.stdout)
    text = re.sub(r"(?m)^  (Libraries .*\n( {10,}.*\n)*|binaries/.*\n)", "", text)
    expect(f"{what}/HLG.txt", "".join(f"{line.rstrip()}\n" for line in text.splitlines()))
