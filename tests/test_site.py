"""The site of `cargo xtask docs`: complete, offline, with links that lead somewhere, and found by the words that readers type."""

import json
import re
import zipfile
from urllib.parse import unquote, urlsplit

import pytest
from lxml import html

import host
import site_pages

pytestmark = site_pages.needs_generator


@pytest.fixture(scope="module")
def documents(site):
    """Every page of the site, by its path."""
    return {path: html.parse(str(path)).getroot() for path in sorted(site.rglob("*.html")) if is_page(path)}


def is_page(path):
    # The tool is a program of its own, and what is not found has addresses from the root of a server.
    return path.name not in (site_pages.TOOL, "404.html")


def led(path, link):
    """The file that a link of a page leads to."""
    parts = urlsplit(link)
    return (path.parent / unquote(parts.path)).resolve() if parts.path else path


def menu_of(page):
    """The links of a page's menu, with their texts."""
    links = page.xpath("//nav[contains(@class, 'md-nav--primary')]//a[contains(@class, 'md-nav__link')][not(starts-with(@href, '#'))]")
    return {" ".join(link.text_content().split()): link.get("href") for link in links}


@pytest.fixture(scope="module")
def index(site):
    """The index of the search: its entries by their place."""
    return {entry["location"]: entry for entry in json.loads((site / "search.json").read_text("utf-8"))["items"]}


def test_every_link_and_picture_of_every_page_leads_somewhere(site, documents):
    broken = []
    for path, page in documents.items():
        for link in [*page.xpath("//@href"), *page.xpath("//@src")]:
            parts = urlsplit(link)
            if parts.scheme:
                continue
            target = led(path, link)
            if not target.is_file():
                broken.append(f"{path.relative_to(site)}: {link} leads nowhere")
            elif parts.fragment and target in documents and not documents[target].xpath("//*[@id=$id]", id=unquote(parts.fragment)):
                broken.append(f"{path.relative_to(site)}: no element has the id of {link}")
    assert broken == []


def test_nothing_on_a_page_is_loaded_from_elsewhere(site, documents):
    for path, page in documents.items():
        loaded = page.xpath("//@src | //link/@href | //style/text()")
        assert not [one for one in loaded if re.search(r"https?:|//[a-z]", one)], path.relative_to(site)


def test_the_menu_has_four_parts_with_every_guide_and_every_fmu(site, documents):
    page = documents[site / "index.html"]
    tabs = [" ".join(tab.text_content().split()) for tab in page.xpath("//nav[contains(@class, 'md-tabs')]//a")]
    assert tabs == ["Start", "Guides", "Reference", "Blocks"]
    leads = {led(site / "index.html", link).relative_to(site).as_posix() for link in menu_of(page).values()}
    guides = {f"docs/{path.stem}.html" for path in (site_pages.ROOT / "docs").glob("*.md")}
    fmus = {f"fmu/{name}/documentation/index.html" for name in host.names()}
    assert guides | fmus | {"parameters/index.html", "plcfmu/index.html", "python/index.html"} <= leads


def test_an_fmu_is_downloaded_from_its_page_whole(site, documents):
    for name in host.names():
        path = site / f"fmu/{name}/documentation/index.html"
        (link,) = documents[path].xpath("//main//a[starts-with(text(), 'Download')]/@href")
        assert led(path, link).read_bytes() == (host.FOLDER / f"{name}.fmu").read_bytes()


def test_the_page_of_an_fmu_has_all_of_its_own_page(site, documents):
    for name in host.names():
        with zipfile.ZipFile(host.FOLDER / f"{name}.fmu") as fmu:
            own = html.document_fromstring(fmu.read("documentation/index.html").decode())
        page = documents[site / f"fmu/{name}/documentation/index.html"]
        assert page.xpath("//h1/text()")[0] == name
        headings = "//h2[@id] | //h3[@id]"
        of_site = [(one.get("id"), one.text_content().removesuffix("¶")) for one in page.xpath(headings)]
        assert of_site == [(one.get("id"), one.text_content()) for one in own.xpath(headings)]
        for part in ("table", "svg", "pre", "math", "tr[@id]", "figure"):
            assert len(page.xpath(f"//article//{part}")) == len(own.xpath(f"//main//{part}")), (name, part)


def test_readme_and_every_page_of_an_fmu_name_the_tools_that_the_guide_to_import_calls_tried(documents, site):
    def named(text):
        return set(re.split(r" and | or |, ", text.replace("the Rust crates ", "")))

    tried, not_tried = set(), set()
    for row in documents[site / "docs/import.html"].xpath("//table[1]//tr[td]"):
        tool, answer = (cell.text_content() for cell in row.xpath("td"))
        (tried if answer.startswith("yes") else not_tried).update(named(tool))
    assert "plcfmu run" in tried and "Simulink" in not_tried
    for name in host.names():
        (said,) = documents[site / f"fmu/{name}/documentation/index.html"].xpath("//dt[text()='Tried in']/following-sibling::dd[1]")
        yes, no = re.fullmatch(r"FMUs of this kind: (.*), on Linux; not in (.*)\.", " ".join(said.text_content().split())).groups()
        assert (named(yes), named(no)) == (tried, not_tried), name
    readme = (site_pages.ROOT / "README.md").read_text("utf-8")
    (hosts,) = re.findall(r"^\| the same bits in (?:.*) \| (.*) \|$", readme, re.MULTILINE)
    assert named(hosts.removesuffix(" on Linux").replace("`", "")) == {re.sub(r" [\d.]+$", "", tool) for tool in tried}
    (absent,) = re.findall(r"real block\. (.*?)\W+have\W+not been tried", readme, re.DOTALL)
    assert named(absent) == not_tried


def test_a_row_about_an_fmu_leads_to_its_page(site, documents):
    for page, name in [("plants/index.html", "HEATER"), ("index.html", "CONT_C")]:
        (link,) = documents[site / page].xpath("//td[1]/a[code/text()=$name]/@href", name=name)
        assert led(site / page, link) == site / f"fmu/{name}/documentation/index.html"


def test_every_page_has_a_title_and_a_description_for_search_engines_and_previews(site, documents):
    titles = []
    for path, page in documents.items():
        name = path.relative_to(site)
        titles.append(page.findtext(".//title"))
        assert titles[-1].endswith("plcfmu"), name
        (about,) = page.xpath("//meta[@name='description']/@content")
        assert 20 < len(about) <= 160 and not re.search(r"[`\[|]", about), (name, about)
        assert [one for one in page.xpath("//link[@rel='icon']/@href") if one.endswith("favicon.svg")], name
    assert len(titles) == len(set(titles))


def test_with_its_address_the_site_has_a_sitemap_and_a_missing_page_for_any_folder(tmp_path):
    address = "https://plcfmu.example/docs"
    site_pages.build().Site(host.FOLDER, tmp_path / "site", address=address, repository="https://plcfmu.example/git").write()
    page = html.parse(str(tmp_path / "site/docs/tool.html"))
    assert page.xpath("//link[@rel='canonical']/@href") == [f"{address}/docs/tool.html"]
    assert page.xpath("//a[@rel='edit']/@href") == ["https://plcfmu.example/git/edit/main/docs/tool.md"]
    # What is made of an FMU has no Markdown file.
    assert html.parse(str(tmp_path / "site/fmu/HLG/documentation/index.html")).xpath("//a[@rel='edit']") == []
    listed = re.findall("<loc>(.*?)</loc>", (tmp_path / "site/sitemap.xml").read_text("utf-8"))
    assert f"{address}/examples/index.html" in listed
    assert all((tmp_path / "site" / link.removeprefix(f"{address}/")).exists() for link in listed)
    links = html.parse(str(tmp_path / "site/404.html")).xpath("//link/@href | //script/@src")
    assert all(link.startswith("/docs/") or link.startswith(address) for link in links), links


def test_the_search_knows_every_guide_and_every_variable_and_where_they_are(site, documents, index):
    for location in index:
        page, _, anchor = location.partition("#")
        assert not anchor or documents[site / page].xpath("//*[@id=$id]", id=unquote(anchor)), location
    entry = index["fmu/CONT_C/documentation/index.html#MAN_ON"]
    said = "<p>Manual mode: the loop is open and MAN is the manipulated value. LMN does not jump "
    assert entry["title"] == "MAN_ON" and entry["text"].startswith(said)
    assert "fmu/HEATER/documentation/index.html#DOOR" in index and "python/index.html#plcfmu.Instance.step" in index
    for guide in ("docs/import.html", "docs/studies.html", "plcfmu/index.html"):
        for anchor in documents[site / guide].xpath("//h2/@id"):
            assert f"{guide}#{anchor}" in index
    # Programs of the repository are pages, so that links lead to them, but a search is for what was written for readers.
    assert (site / "examples/cascade.py.html").is_file() and not [one for one in index if one.startswith("examples/cascade.py")]
    assert (site / "search.js").read_text("utf-8").removeprefix("var __index = ") == (site / "search.json").read_text("utf-8")


def test_code_of_the_repository_is_shown_as_it_is(site, documents):
    page = documents[site / "examples/cascade.py.html"]
    (code,) = page.xpath("//article//pre/code")
    assert code.text_content().strip() == (site_pages.ROOT / "examples/cascade.py").read_text("utf-8").strip()


def test_the_tool_is_a_part_of_the_site_where_it_was_made(tmp_path):
    (tmp_path / "tool.html").write_text("<title>tool</title>")
    site = tmp_path / "site"
    site_pages.build().Site(host.FOLDER, site, tool=tmp_path / "tool.html").write()
    assert (site / site_pages.TOOL).read_text() == "<title>tool</title>"
    for name in ("index.html", "fmu/CONT_C/documentation/index.html"):
        page = html.parse(str(site / name)).getroot()
        assert led(site / name, menu_of(page)["Try it in the browser"]) == site / site_pages.TOOL
    front = html.parse(str(site / "index.html")).xpath("//article//a[text()='Try it in the browser']/@href")
    assert front == [site_pages.TOOL]


def test_the_reference_has_what_the_python_package_exports(site, documents):
    import plcfmu

    page = documents[site / "python/index.html"]
    ids = {anchor.removeprefix("plcfmu.") for anchor in page.xpath("//article//@id")}
    assert {*plcfmu.__all__, "Instance.step", "Fmus.start", "Result.figures", "figures.step_figures"} <= ids
    signatures = [" ".join(one.text_content().split()) for one in page.xpath("//*[contains(@class, 'doc-signature')]")]
    assert [one for one in signatures if one.startswith("start(")] and not [one for one in signatures if re.search(r"\((cls|self)\b", one)]


def test_the_same_sources_give_the_same_bytes(site, tmp_path):
    site_pages.write(tmp_path / "again")
    files = {path.relative_to(site): path for path in site.rglob("*") if path.is_file()}
    again = {path.relative_to(tmp_path / "again") for path in (tmp_path / "again").rglob("*") if path.is_file()}
    assert set(files) == again
    assert [name for name, path in files.items() if path.read_bytes() != (tmp_path / "again" / name).read_bytes()] == []


def test_a_link_of_a_document_to_what_does_not_exist_stops_the_build(tmp_path):
    build = site_pages.build()
    site = build.Site(host.FOLDER, tmp_path / "site")
    with pytest.raises(build.SourceError, match=r"^README.md links to no/such.md, but no/such.md does not exist"):
        site.linked("[x](no/such.md)", "README.md")
    assert site.linked("`[x](no/such.md)`", "README.md") == "`[x](no/such.md)`"


def test_a_folder_with_other_files_is_not_replaced_by_a_site(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    build = site_pages.build()
    with pytest.raises(FileExistsError, match="is neither empty nor a site"):
        build.Site(host.FOLDER, tmp_path).write()
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_the_page_of_what_was_tested_has_each_promise_with_the_results_of_each_system(site, documents):
    page = documents[site / "tests/tested.html"]
    systems = page.xpath("//h2[@id='systems']/following-sibling::ul[1]/li/text()")
    assert systems == ["linux64: Linux-6, Python 3.11: 1 failed, 1,010 passed, 3 skipped", "win64 under Wine: 10 passed"]
    rows = [[" ".join(cell.text_content().split()) for cell in row.xpath("td")] for row in page.xpath("//article//tr[td]")]
    readme = (site_pages.ROOT / "tests/README.md").read_text("utf-8").split("## Running them")[0]
    assert len(rows) == len(re.findall(r"^\| (?!\*\*|promise)", readme, re.MULTILINE)) > 50
    results = {row[0]: row[2:] for row in rows}
    assert results["every block computes its law bit for bit, for any inputs and parameters"] == ["1 failed, 1,000 passed, 3 skipped", ""]
    assert results["CONT_C and CONT_S reproduce recordings of the terminals of real blocks, bit for bit"] == ["10 passed", "10 passed"]
