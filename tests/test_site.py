"""The site of `cargo xtask docs`: complete, its links lead somewhere, and its programs do what it says of them."""

import re
import subprocess
import sys
from urllib.parse import unquote, urlsplit

import pytest
from lxml import html

import host
import site_pages


@pytest.fixture(scope="module")
def documents(site):
    """Every page of the site, by its path."""
    return {path: html.parse(str(path)).getroot() for path in sorted(site.rglob("*.html"))}


def test_every_link_and_picture_of_every_page_leads_somewhere(site, documents):
    broken = []
    for path, page in documents.items():
        for link in [*page.xpath("//@href"), *page.xpath("//@src")]:
            parts = urlsplit(link)
            if parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file():
                broken.append(f"{path.relative_to(site)}: there is no {link}")
            elif parts.fragment and not documents[target].xpath("//*[@id=$id]", id=unquote(parts.fragment)):
                broken.append(f"{path.relative_to(site)}: no element has the id of {link}")
    assert broken == []


def test_no_anchor_of_a_page_occurs_twice(site, documents):
    for path, page in documents.items():
        ids = page.xpath("//@id")
        assert sorted(set(ids)) == sorted(ids), path.relative_to(site)


def test_nothing_on_a_page_is_loaded_from_elsewhere(site, documents):
    for path, page in documents.items():
        loaded = page.xpath("//@src | //link/@href | //style/text()")
        assert not [one for one in loaded if re.search(r"https?:|//[a-z]", one)], path.relative_to(site)
        assert not page.xpath("//script"), path.relative_to(site)


def test_the_front_page_leads_to_all_fmus_all_loops_and_all_guides(site, documents):
    links = documents[site / "index.html"].xpath("//main//a/@href")
    for name in host.names():
        assert f"fmu/{name}/documentation/index.html" in links
    headings = documents[site / "examples/README.html"].xpath("//h2[following-sibling::p[1]/img]/@id")
    assert len(headings) > 5
    assert {f"examples/README.html#{heading}" for heading in headings} <= set(links)
    tools = ("fmpy", "simulink", "dymola", "openmodelica-and-omsimulator", "simit")
    assert {f"docs/import.html#{tool}" for tool in tools} <= set(links)


def test_the_reference_has_what_the_python_package_exports(site, documents):
    import plcfmu

    ids = documents[site / "python/index.html"].xpath("//@id")
    assert set(plcfmu.__all__) <= set(ids)
    assert {"Instance.step", "Fmus.start", "Result.figures", "figures.step_figures"} <= set(ids)


def test_the_loop_of_the_front_page_settles_at_its_setpoint_in_25_lines():
    program = site_pages.FOLDER / "minimal_loop.py"
    assert len([line for line in program.read_text("utf-8").splitlines() if line.strip()]) <= 25
    run = subprocess.run([sys.executable, str(program)], cwd=host.FOLDER, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) == pytest.approx(60.0, abs=0.01)


def test_the_same_sources_give_the_same_bytes(site, tmp_path):
    site_pages.write(tmp_path / "again")
    files = {path.relative_to(site): path for path in site.rglob("*") if path.is_file()}
    files = {name: path for name, path in files.items() if name.parts[0] != "screenshots"}
    again = {path.relative_to(tmp_path / "again") for path in (tmp_path / "again").rglob("*") if path.is_file()}
    assert set(files) == again
    assert [name for name, path in files.items() if path.read_bytes() != (tmp_path / "again" / name).read_bytes()] == []


def test_a_link_of_a_document_to_what_does_not_exist_stops_the_build(tmp_path):
    build = site_pages.build()
    site = build.Site(host.FOLDER, tmp_path / "site")
    with pytest.raises(build.SourceError, match=r"^README.md links to no/such.md, but there is no no/such.md"):
        site.html("[x](no/such.md)", "README.md", "README.html")


def test_a_folder_with_other_files_is_not_replaced_by_a_site(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    build = site_pages.build()
    with pytest.raises(FileExistsError, match="is neither empty nor a site"):
        build.Site(host.FOLDER, tmp_path).write()
    assert (tmp_path / "mine.txt").read_text() == "mine"
