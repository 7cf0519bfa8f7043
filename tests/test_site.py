"""The site of `cargo xtask docs`: complete, its links lead somewhere, and its programs do what it says of them."""

import json
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
        if path.name == site_pages.TOOL:
            continue  # A program of its own.
        loaded = page.xpath("//@src | //link/@href | //style/text()")
        assert not [one for one in loaded if re.search(r"https?:|//[a-z]", one)], path.relative_to(site)
        scripts = {(path.parent / source).resolve() for source in page.xpath("//script/@src")}
        assert scripts == {site / "site.js"} and not page.xpath("//script/text()"), path.relative_to(site)


def test_the_front_page_leads_to_all_fmus_all_loops_and_all_tools(site, documents):
    page = documents[site / "index.html"]
    links = page.xpath("//main//a/@href")
    for name in host.names():
        assert f"fmu/{name}/documentation/index.html" in links
    headings = documents[site / "examples/index.html"].xpath("//h2[following-sibling::p[1]/img]/@id")
    assert len(headings) > 5
    assert {f"examples/index.html#{heading}" for heading in headings} <= set(links)
    thumbnails = page.xpath("//ul[@class='gallery']//img")
    assert {image.get("loading") for image in thumbnails} == {"lazy"}
    assert sum((site / image.get("src")).stat().st_size for image in thumbnails) < 400_000
    tools = documents[site / "docs/import.html"].xpath("//h2/@id")
    assert len(tools) > 5 and {f"docs/import.html#{tool}" for tool in tools} <= set(links)


def test_every_page_has_the_menu_with_every_guide_and_every_fmu_and_says_where_one_is(site, documents):
    guides = {f"docs/{path.stem}.html" for path in (site_pages.ROOT / "docs").glob("*.md")}
    fmus = {f"fmu/{name}/documentation/index.html" for name in host.names()}
    for path, page in documents.items():
        if path.name == site_pages.TOOL:
            continue
        name = path.relative_to(site).as_posix()
        leads = {link: (path.parent / link).resolve().relative_to(site).as_posix() for link in page.xpath("//details//@href")}
        assert guides | fmus | {"parameters/index.html", "plcfmu/index.html"} <= set(leads.values()), name
        current = [leads.get(link, "index.html") for link in page.xpath("//*[@aria-current]/@href")]
        assert current == ([name] if name in {*leads.values(), "index.html"} else []), name


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
    (absent,) = re.findall(r"real block\. (.*?)\s+were not tried", readme, re.DOTALL)
    assert named(absent) == not_tried


def test_next_leads_through_the_whole_menu_and_previous_back(site, documents):
    menu = documents[site / "index.html"].xpath("//details//@href")
    there = [documents[site / page].xpath("//a[@rel='next']/@href") for page in menu]
    back = [documents[site / page].xpath("//a[@rel='prev']/@href") for page in menu]

    def led(links):
        return [str((site / page).parent.joinpath(*link).resolve().relative_to(site)) for page, link in zip(menu, links) if link]

    assert led(there) == menu[1:] and led(back) == menu[:-1]
    assert there[-1] == back[0] == []


def test_a_row_about_an_fmu_leads_to_its_page(site, documents):
    for page, name in [("plants/index.html", "HEATER"), ("overview.html", "CONT_C")]:
        (link,) = documents[site / page].xpath("//td[1]/code/a[text()=$name]/@href", name=name)
        assert (site / page).parent.joinpath(link).resolve() == site / f"fmu/{name}/documentation/index.html"


def test_long_names_in_code_are_broken_between_their_words_and_short_ones_are_not(site, documents):
    text = (site / "tests/index.html").read_text("utf-8")
    assert "<code>blocks/<wbr>tests/<wbr>traces.rs</code>" in text and "<code>test_time.py</code>" in text


def test_every_page_has_a_title_and_a_description_for_search_engines_and_previews(site, documents):
    titles = []
    for path, page in documents.items():
        if path.name == site_pages.TOOL:
            continue
        name = path.relative_to(site)
        titles.append(page.findtext(".//title"))
        assert titles[-1].endswith(" - plcfmu"), name
        (about,) = page.xpath("//meta[@name='description']/@content")
        assert 20 < len(about) <= 160 and not re.search(r"[`\[|]", about), (name, about)
        assert [one for one in page.xpath("//link[@rel='icon']/@href") if one.endswith("favicon.svg")], name
        assert page.xpath("//meta[@property='og:description']/@content") == [about], name
        assert page.xpath("//meta[@property='og:image']") == [], "a preview's picture needs the address of the site"
    assert len(titles) == len(set(titles))


def test_with_its_address_the_site_has_previews_a_sitemap_and_a_missing_page_for_any_folder(tmp_path):
    address = "https://plcfmu.example/docs"
    site_pages.build().Site(host.FOLDER, tmp_path / "site", address=address).write()
    page = html.parse(str(tmp_path / "site/docs/tool.html"))
    assert page.xpath("//meta[@property='og:url']/@content") == [f"{address}/docs/tool.html"]
    (picture,) = page.xpath("//meta[@property='og:image']/@content")
    listed = (tmp_path / "site/sitemap.txt").read_text("utf-8").splitlines()
    assert all((tmp_path / "site" / link.removeprefix(f"{address}/")).is_file() for link in [picture, *listed])
    assert f"{address}/examples/index.html" in listed and not any("404" in link for link in listed)
    links = html.parse(str(tmp_path / "site/404.html")).xpath("//@href | //@src")
    assert all(link.startswith(f"{address}/") or link.startswith("#") for link in links)


def test_the_search_knows_every_heading_and_every_variable_and_where_they_are(site, documents):
    text = (site / "search.js").read_text("utf-8")
    index = json.loads(text.removeprefix("window.plcfmuIndex = ").removesuffix(";\n"))
    places = {(index["pages"][page][0], anchor): (heading, said) for page, anchor, heading, said in index["entries"]}
    for page, anchor in places:
        assert anchor == "" or documents[site / page].xpath("//*[@id=$id]", id=anchor), (page, anchor)
    heading, said = places["fmu/CONT_C/documentation/index.html", "MAN_ON"]
    assert heading == "MAN_ON" and said.startswith("Manual mode: the loop is open and MAN is the manipulated value. LMN does not jump ")
    assert "fmu/HEATER/documentation/index.html", "DOOR" in places
    assert "zombie" not in text and "Instance.step" in text
    # The name on a card and what stands below it are two words.
    assert "CONT_S PI step controller" in text and "CONT_SPI" not in text
    for guide in ("docs/import.html", "docs/studies.html", "plcfmu/index.html"):
        for anchor in documents[site / guide].xpath("//h2[following-sibling::*[1][self::p]]/@id"):
            assert (guide, anchor) in places


def test_the_tool_is_a_part_of_the_site_where_it_was_made(tmp_path):
    (tmp_path / "tool.html").write_text("<title>tool</title>")
    site = tmp_path / "site"
    site_pages.build().Site(host.FOLDER, site, tool=tmp_path / "tool.html").write()
    assert (site / site_pages.TOOL).read_text() == "<title>tool</title>"
    for page in ("index.html", "fmu/CONT_C/documentation/index.html"):
        links = html.parse(str(site / page)).xpath("//a[text()='Try it in the browser']/@href")
        assert links and {(site / page).parent.joinpath(link).resolve() for link in links} == {site / site_pages.TOOL}


def test_the_reference_has_what_the_python_package_exports(site, documents):
    import plcfmu

    ids = documents[site / "python/index.html"].xpath("//@id")
    assert set(plcfmu.__all__) <= set(ids)
    # What one calls stands before what one catches.
    first, *_ = documents[site / "python/index.html"].xpath("//nav[@class='contents']//@href")
    assert not first.endswith("Error")
    assert {"Instance.step", "Fmus.start", "Result.figures", "figures.step_figures"} <= set(ids)
    signatures = documents[site / "python/index.html"].xpath("//*[@class='signature']")
    texts = [signature.text_content() for signature in signatures]
    assert texts and not [text for text in texts if re.search(r"\(cls\b|\(self\b|dtype", text)]
    # On a phone a line may end behind a hyphen, but not within an arrow.
    unbroken = documents[site / "python/index.html"].xpath("//*[@class='signature']//*[@class='option']")
    assert [arrow.text for arrow in unbroken] == ["->"] * sum(text.count("->") for text in texts)


def test_the_loop_of_the_front_page_settles_at_its_setpoint_in_25_lines():
    program = site_pages.FOLDER / "minimal_loop.py"
    assert len([line for line in program.read_text("utf-8").splitlines() if line.strip()]) <= 25
    run = subprocess.run([sys.executable, str(program)], cwd=host.FOLDER, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) == pytest.approx(60.0, abs=0.01)


def test_the_same_sources_give_the_same_bytes(site, tmp_path):
    site_pages.write(tmp_path / "again")
    files = {path.relative_to(site): path for path in site.rglob("*") if path.is_file()}
    again = {path.relative_to(tmp_path / "again") for path in (tmp_path / "again").rglob("*") if path.is_file()}
    assert set(files) == again
    assert [name for name, path in files.items() if path.read_bytes() != (tmp_path / "again" / name).read_bytes()] == []


def test_a_link_of_a_document_to_what_does_not_exist_stops_the_build(tmp_path):
    build = site_pages.build()
    site = build.Site(host.FOLDER, tmp_path / "site")
    with pytest.raises(build.SourceError, match=r"^README.md links to no/such.md, but there is no no/such.md"):
        site.html("[x](no/such.md)", "README.md", "overview.html")


def test_a_folder_with_other_files_is_not_replaced_by_a_site(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    build = site_pages.build()
    with pytest.raises(FileExistsError, match="is neither empty nor a site"):
        build.Site(host.FOLDER, tmp_path).write()
    assert (tmp_path / "mine.txt").read_text() == "mine"
