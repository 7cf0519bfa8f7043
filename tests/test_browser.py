"""The pages of the FMUs and of the site as a browser shows them: Debian's chromium, driven by Playwright.

Screenshots of the pages are in target/screenshots afterwards.
"""


import pytest

import host
import site_pages
from tool import CHROMIUM, needs_browser

pytestmark = needs_browser

FMU_PAGES = [f"fmu/{name}/documentation/index.html" for name in host.names()]
# One of each kind of the site's own pages, and the longest ones.
PAGES = [
    "index.html",
    "404.html",
    *(f"{name}.html" for name in ("overview", "docs/import", "docs/studies", "docs/tool", "CHANGELOG")),
    *(f"{folder}/index.html" for folder in ("blocks", "examples", "fmu", "parameters", "plants", "plcfmu", "python", "tests")),
    "examples/cascade.py.html",
    "examples/programs/index.html",
    *FMU_PAGES,
]
SHOWN = ["index.html", "overview.html", "docs/studies.html", "examples/index.html", "python/index.html", *FMU_PAGES]

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
                page.on("console", lambda message: messages.append(message.text))
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
    return not url.startswith(("file:", "data:"))


@pytest.mark.parametrize("name", PAGES)
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


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_on_a_page(show, name):
    for scheme, options in [("light", None), ("dark", {"runOnly": ["color-contrast"]})]:
        findings = axe(show(name, scheme=scheme), options)
        nodes = [(one["id"], node["html"][:120], node["failureSummary"]) for one in findings for node in one["nodes"]]
        assert nodes == [], scheme


def test_axe_finds_nothing_on_any_other_document_of_the_site(show, site):
    # Files of the repository are pages too, long ones of one kind: PAGES has one of them.
    documents = {path.relative_to(site).as_posix() for path in site.rglob("*.html") if "." not in path.stem}
    others = sorted(documents - {site_pages.TOOL, *PAGES})
    assert len(others) > 5
    for name in others:
        for scheme, options in [("light", None), ("dark", {"runOnly": ["color-contrast"]})]:
            found = [(one["id"], node["html"][:120]) for one in axe(show(name, scheme=scheme), options) for node in one["nodes"]]
            assert found == [], (name, scheme)


def test_axe_finds_nothing_on_open_menus_and_found_places(show):
    for width in (DESKTOP, PHONE):
        page = show("docs/tool.html", width)
        for menu in page.locator("details.menu").all():
            menu.locator("summary").click()
            assert axe(page, None) == []
            assert page.evaluate("document.documentElement.scrollWidth") <= width
        page.get_by_role("searchbox").fill("anti-windup")
        page.locator(".found a").first.wait_for()
        assert axe(page, None) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        page.goto("about:blank")


@pytest.mark.parametrize("width", [DESKTOP, 760])
def test_a_menu_opens_below_its_word_and_within_the_page(show, width):
    page = show("docs/tool.html", width)
    for menu in page.locator("details.menu").all():
        menu.locator("summary").click()
        word, opened = menu.locator("summary").bounding_box(), menu.locator(".parts").bounding_box()
        assert opened["x"] == word["x"] and opened["y"] >= word["y"] + word["height"]
        assert opened["x"] + opened["width"] <= width
    page.goto("about:blank")


def test_what_is_found_is_cut_between_words_and_says_so(show):
    page = show("docs/tool.html")
    page.get_by_role("searchbox").fill("CONT_C holds a process value")
    page.locator(".found a").first.wait_for()
    texts = page.locator(".found span").all_text_contents()
    assert [text for text in texts if not text.endswith((".", " …"))] == []
    page.goto("about:blank")


def test_one_finds_a_variable_and_a_section_by_words_and_by_keys(show, site):
    page = show("fmu/CONT_C/documentation/index.html")
    page.keyboard.press("/")
    page.keyboard.type("tm_lag")
    first = page.locator(".found a").first
    first.wait_for()
    assert first.get_attribute("href").endswith("fmu/CONT_C/documentation/index.html#TM_LAG")
    page.keyboard.press("Escape")
    assert not page.locator(".found").is_visible()
    page.get_by_role("searchbox").fill("percentile expectation zombie")
    page.locator(".found p").wait_for()
    assert page.locator(".found").inner_text() == "Nothing has all words of “percentile expectation zombie”."
    page.get_by_role("searchbox").fill("job arrays")
    page.locator(".found a", has_text="Slurm").first.wait_for()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    page.wait_for_url("**/docs/clusters.html#*")
    page.goto("about:blank")


@pytest.mark.parametrize(
    "words, place",
    [
        ("anti-windup", "fmu/CONT_C/documentation/index.html"),
        ("SCL", "docs/scl.html#plc-programs-in-scl"),
        ("C sources", "docs/c_sources.html#c-sources"),
        ("prove", "docs/prove.html#prove-it-on-your-own-cpu"),
        ("studies", "docs/studies.html#studies"),
    ],
)
def test_what_a_page_is_about_is_found_first(show, words, place):
    page = show("docs/tool.html")
    page.get_by_role("searchbox").fill(words)
    first = page.locator(".found a").first
    first.wait_for()
    assert first.get_attribute("href") == f"../{place}"
    page.goto("about:blank")


@pytest.mark.parametrize("name, heading", [("docs/import.html", "Simulink"), ("fmu/CONT_C/documentation/index.html", "Clauses")])
def test_a_heading_is_a_link_to_itself_and_no_stop_of_the_tab_key(show, name, heading):
    page = show(name)
    link = page.get_by_role("heading", name=heading, exact=True).get_by_role("link")
    assert link.get_attribute("tabindex") == "-1"
    link.click()
    assert page.url.endswith(f"#{heading.lower()}")
    page.goto("about:blank")


def test_a_sample_is_copied_by_its_button(show):
    page = show("docs/import.html")
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    sample = page.locator(".sample").first
    sample.hover()
    sample.get_by_role("button").click()
    sample.get_by_role("button", name="Copied").wait_for()
    assert page.evaluate("navigator.clipboard.readText()") == sample.locator("pre").inner_text()
    page.goto("about:blank")


def test_axe_finds_what_is_wrong(show):
    page = show("index.html")
    page.evaluate("document.querySelector('img').removeAttribute('alt')")
    assert [finding["id"] for finding in axe(page, None)] == ["image-alt"]
    page.goto("about:blank")


def axe(page, options):
    """What axe finds on a page, by its rules."""
    from axe_playwright_python.sync_playwright import Axe

    return Axe().run(page, options=options).response["violations"]


@pytest.mark.parametrize("name", PAGES)
def test_the_dark_scheme_is_dark_everywhere(show, name):
    page = show(name, scheme="dark")
    brightness = "element => Math.max(...getComputedStyle(element).backgroundColor.match(/[0-9.]+/g).slice(0, 3))"
    assert page.eval_on_selector("body", brightness) < 64
    papers = "papers => papers.map(paper => Math.max(...getComputedStyle(paper).fill.match(/[0-9.]+/g)))"
    assert all(paper < 64 for paper in page.eval_on_selector_all("svg .paper", papers))


@pytest.mark.parametrize("name", FMU_PAGES)
def test_drawings_and_formulas_are_shown(show, name):
    page = show(name)
    large = """elements => elements.map(one => one.getBoundingClientRect())
        .filter(box => box.width > 20 && box.height > 10).length"""
    drawings = page.locator("svg").count()
    assert drawings >= 2, "a diagram and a response"
    assert page.eval_on_selector_all("svg", large) == drawings
    formulas = page.locator("math").count()
    assert page.eval_on_selector_all("math", large) == formulas
    assert formulas > 0 or "class=\"formula\"" not in page.content()
    assert page.locator("merror").count() == 0


@pytest.mark.parametrize("name", FMU_PAGES)
def test_lines_of_a_formula_meet_at_their_signs_of_equality_and_no_name_of_a_lane_is_struck(show, name):
    page = show(name)
    left_sides = """cells => cells.filter(cell => cell.firstElementChild).map(cell => cell.getBoundingClientRect().right
        - Math.max(...[...cell.querySelectorAll('*')].map(part => part.getBoundingClientRect().right)))"""
    assert all(gap < 1 for gap in page.eval_on_selector_all(".menv-alignlike > mtr > mtd:first-child", left_sides))
    below = """names => names.map(name => name.previousElementSibling.getBBox().y - name.getBBox().y - name.getBBox().height)"""
    assert all(gap > 0 for gap in page.eval_on_selector_all('svg.chart g[class^="curve"] + text', below))


@pytest.mark.parametrize("name", FMU_PAGES)
def test_an_anchor_opens_the_help_of_a_variable(show, name):
    page = show(name)
    variable = page.locator("tr[id]").last.get_attribute("id")
    page.goto(f"{page.url}#{variable}")
    assert page.locator(f'tr[id="{variable}"]').evaluate("row => row.getBoundingClientRect().top < innerHeight")


@pytest.mark.parametrize("name", FMU_PAGES)
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
