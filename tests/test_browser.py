"""The site, with the pages of the FMUs, as a browser shows it from a disk: Debian's chromium, driven by Playwright.

Screenshots of the pages are in target/screenshots afterwards.
"""

import re
import zipfile

import pytest

import host
import site_pages
from tool import CHROMIUM, needs_browser

pytestmark = [*needs_browser, site_pages.needs_generator]

FMU_PAGES = [f"fmu/{name}/documentation/index.html" for name in host.names()]
# One of each kind of the site's own pages, and the longest ones.
OWN_PAGES = [
    "index.html",
    *(f"{name}.html" for name in ("docs/import", "docs/studies", "docs/tool", "CHANGELOG")),
    *(f"{folder}/index.html" for folder in ("blocks", "examples", "fmu", "parameters", "plants", "plcfmu", "python", "tests")),
    "examples/cascade.py.html",
    "examples/programs/index.html",
]
# Pages of FMUs are of one kind: the longest have what the others have.
LONGEST = sorted(host.names(), key=lambda name: zipfile.ZipFile(host.FOLDER / f"{name}.fmu").getinfo("documentation/index.html").file_size)[-4:]
LONGEST_PAGES = [page for page in FMU_PAGES if page.split("/")[1] in LONGEST]
# `cargo xtask test --deep` looks at all of them.
EACH_FMU_PAGE = [page if page in LONGEST_PAGES else pytest.param(page, marks=pytest.mark.deep) for page in FMU_PAGES]
EACH_PAGE = [*OWN_PAGES, *EACH_FMU_PAGE]
AXED = [*OWN_PAGES, *LONGEST_PAGES]
SHOWN = ["index.html", "docs/studies.html", "examples/index.html", "python/index.html", *LONGEST_PAGES]

DESKTOP, PHONE = 1280, 390
# A4 less the margins of the browser, at 96 pixels an inch.
PAPER = 718


@pytest.fixture(scope="module")
def windows(site):
    """Opens a page at a width in a colour scheme; and what the browser has said meanwhile. Windows are used again."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        # axe reads stylesheets, which a browser keeps files from.
        arguments = ["--no-sandbox", "--allow-file-access-from-files"]
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=arguments)
        opened, messages = {}, []

        def failed(request):
            # What is still on its way when the next page is opened is aborted.
            if request.failure != "net::ERR_ABORTED":
                messages.append(f"{request.url} cannot be loaded")

        def window(width, scheme):
            if (width, scheme) not in opened:
                page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
                # An address with an anchor takes the focus, as it should: chromium says so where the search has a field.
                is_usual = "Autofocus processing was blocked"
                page.on("console", lambda message: is_usual in message.text or messages.append(message.text))
                page.on("pageerror", lambda error: messages.append(str(error)))
                page.on("requestfailed", failed)
                page.on("request", lambda request: messages.append(request.url) if is_outside(request.url) else None)
                opened[width, scheme] = page
            return opened[width, scheme]

        yield window, messages
        browser.close()


@pytest.fixture
def show(windows, site):
    """Opens a page. Any message of the browser, and any request to elsewhere, is a failure."""
    window, messages = windows
    messages.clear()

    def show(name, width=DESKTOP, scheme="light"):
        page = window(width, scheme)
        page.emulate_media(media="screen", color_scheme=scheme)
        if page.url != (site / name).as_uri():
            page.goto((site / name).as_uri())
        return page

    yield show
    assert messages == []


def is_outside(url):
    return not url.startswith(("file:", "data:", "blob:"))


@pytest.mark.parametrize("name", EACH_PAGE)
def test_a_page_is_as_wide_as_its_window_and_shows_its_pictures(show, name):
    for width in (DESKTOP, PHONE):
        page = show(name, width)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        # A picture that is loaded when one comes to it is loaded now.
        page.evaluate("Promise.all([...document.images].map(image => (image.loading = 'eager', image.decode())))")
        assert page.evaluate("[...document.images].filter(image => !image.naturalWidth).map(image => image.src)") == []
        share = """codes => codes.map(code => [code, code.parentElement].map(one => parseFloat(getComputedStyle(one).fontSize)))
            .map(([code, heading]) => code / heading)"""
        assert all(size > 0.9 for size in page.eval_on_selector_all(":is(h1, h2) code", share))


@pytest.mark.parametrize("name", AXED)
def test_axe_finds_nothing_on_a_page(show, name):
    for scheme, options in [("light", None), ("dark", {"runOnly": ["color-contrast"]})]:
        findings = axe(show(name, scheme=scheme), options)
        nodes = [(one["id"], node["html"][:120], node["failureSummary"]) for one in findings for node in one["nodes"]]
        assert nodes == [], scheme


def test_axe_finds_nothing_on_any_other_document_of_the_site(show, site):
    # Files of the repository are pages too, long ones of one kind: OWN_PAGES has one of them.
    documents = {path.relative_to(site).as_posix() for path in site.rglob("*.html") if "." not in path.stem}
    others = sorted(documents - {site_pages.TOOL, "404.html", *OWN_PAGES, *FMU_PAGES})
    assert len(others) > 5
    # Their colours in the dark are those of OWN_PAGES.
    for name in others:
        assert [(one["id"], node["html"][:120]) for one in axe(show(name), None) for node in one["nodes"]] == [], name


def found(page, words):
    """The places that the search finds, best first."""
    page.keyboard.press("/")
    page.get_by_role("combobox", name="Search").fill(words)
    return page.get_by_role("option")


@pytest.mark.parametrize(
    "words, place",
    [
        ("tm_lag", "fmu/CONT_C/documentation/index.html#TM_LAG"),
        ("anti-windup", "fmu/CONT_C/documentation/index.html"),
        ("scaling", "fmu/CONT_C/documentation/index.html#PV_FAC"),
        ("normalize", "fmu/CONT_C/documentation/index.html#PV_FAC"),
        ("TI = 0", "fmu/CONT_C/documentation/index.html#TI"),
        ("SCL", "docs/scl.html"),
        ("C sources", "docs/c_sources.html"),
        ("studies", "docs/studies.html"),
    ],
)
def test_what_one_looks_for_is_among_the_first_found(show, words, place):
    page = show("docs/tool.html")
    results = found(page, words)
    results.first.wait_for()
    links = [re.sub(r"\?h=[^#]*", "", result.get_attribute("href")) for result in results.all()[:4]]
    assert [link for link in links if place in link], links
    page.goto("about:blank")


def test_axe_finds_nothing_on_the_open_search_and_enter_opens_what_is_found(show):
    page = show("docs/tool.html")
    found(page, "job arrays").first.wait_for()
    assert axe(page, None) == []
    page.keyboard.press("Enter")
    page.wait_for_url("**/docs/*.html?h=*#*")
    assert "Slurm" in page.locator("article").inner_text()
    page.goto("about:blank")


def test_the_switch_makes_the_page_dark_and_the_next_page_too(show):
    page = show("index.html")
    page.locator("label[title='Switch to dark mode']").click()
    show("docs/import.html")
    assert page.eval_on_selector("body", "element => getComputedStyle(element).colorScheme") == "dark"
    page.evaluate("localStorage.clear()")
    page.goto("about:blank")


def test_axe_finds_what_is_wrong(show):
    page = show("index.html")
    page.evaluate("document.querySelector('img').removeAttribute('alt')")
    assert [finding["id"] for finding in axe(page, None)] == ["image-alt"]
    page.goto("about:blank")


def axe(page, options):
    """What axe finds on a page, by its rules but one: the theme's contents are marks within marks, without names of their own."""
    from axe_playwright_python.sync_playwright import Axe

    options = options or {"rules": {"landmark-unique": {"enabled": False}}}
    # What fades in has its contrast at the end. The search lives in a shadow tree, which `document.getAnimations()` does not enter.
    page.evaluate("""() => {
        const trees = root => [root, ...[...root.querySelectorAll("*")].flatMap(one => one.shadowRoot ? trees(one.shadowRoot) : [])];
        return Promise.allSettled(trees(document).flatMap(root => root.getAnimations()).map(animation => animation.finished));
    }""")
    return Axe().run(page, options=options).response["violations"]


@pytest.mark.parametrize("name", EACH_PAGE)
def test_the_dark_scheme_is_dark_everywhere(show, name):
    page = show(name, scheme="dark")
    brightness = "element => Math.max(...getComputedStyle(element).backgroundColor.match(/[0-9.]+/g).slice(0, 3))"
    assert page.eval_on_selector("body", brightness) < 64
    papers = "papers => papers.map(paper => Math.max(...getComputedStyle(paper).fill.match(/[0-9.]+/g)))"
    assert all(paper < 64 for paper in page.eval_on_selector_all("svg .paper", papers))


@pytest.mark.parametrize("name", EACH_FMU_PAGE)
def test_drawings_and_formulas_are_shown(show, name):
    page = show(name)
    large = """elements => elements.map(one => one.getBoundingClientRect())
        .filter(box => box.width > 20 && box.height > 10).length"""
    drawings = page.locator(".fmu svg").count()
    assert drawings >= 2, "a diagram and a response"
    assert page.eval_on_selector_all(".fmu svg", large) == drawings
    formulas = page.locator("math").count()
    assert page.eval_on_selector_all("math", large) == formulas
    assert formulas > 0 or "class=\"formula\"" not in page.content()
    assert page.locator("merror").count() == 0


@pytest.mark.parametrize("name", EACH_FMU_PAGE)
def test_lines_of_a_formula_meet_at_their_signs_of_equality_and_no_name_of_a_lane_is_struck(show, name):
    page = show(name)
    left_sides = """cells => cells.filter(cell => cell.firstElementChild).map(cell => cell.getBoundingClientRect().right
        - Math.max(...[...cell.querySelectorAll('*')].map(part => part.getBoundingClientRect().right)))"""
    assert all(gap < 1 for gap in page.eval_on_selector_all(".menv-alignlike > mtr > mtd:first-child", left_sides))
    below = """names => names.map(name => name.previousElementSibling.getBBox().y - name.getBBox().y - name.getBBox().height)"""
    assert all(gap > 0 for gap in page.eval_on_selector_all('svg.chart g[class^="curve"] + text', below))


@pytest.mark.parametrize("name", EACH_FMU_PAGE)
def test_an_anchor_opens_the_help_of_a_variable(show, name):
    page = show(name)
    variable = page.locator("tr[id]").last.get_attribute("id")
    page.goto(f"{page.url}#{variable}")
    assert page.locator(f'tr[id="{variable}"]').evaluate("row => row.getBoundingClientRect().top < innerHeight")


@pytest.mark.parametrize("name", EACH_FMU_PAGE)
def test_print_cuts_nothing(show, name):
    page = show(name, PAPER)
    page.emulate_media(media="print")
    beyond = """elements => elements.filter(one => one.getBoundingClientRect().right > innerWidth + 1 ||
        one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflowX != "visible")
        .map(one => one.outerHTML.slice(0, 200))"""
    assert page.eval_on_selector_all("svg, math *, pre, table, figure, dl, p", beyond) == []
    # The height of a page less its margins, in pixels.
    high = "elements => elements.filter(one => one.getBoundingClientRect().height > 1040).length"
    assert page.eval_on_selector_all("svg", high) == 0
    assert page.pdf(format="A4").startswith(b"%PDF")


@pytest.mark.parametrize("name", SHOWN)
def test_screenshots_are_there_to_be_looked_at(show, name):
    folder = site_pages.SITE.parent / "screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    title = name.replace("/documentation/index.html", "").removesuffix(".html").replace("/", "-").removesuffix("-index")
    for width in (DESKTOP, PHONE):
        for scheme in ("light", "dark"):
            page = show(name, width, scheme)
            path = folder / f"{title}-{width}-{scheme}.png"
            page.set_viewport_size({"width": width, "height": 2000})
            page.screenshot(path=path)
            page.set_viewport_size({"width": width, "height": 900})
            assert path.stat().st_size > 10_000
