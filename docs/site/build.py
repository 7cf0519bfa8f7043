"""Builds the project's site with Zensical, from the documents, the FMU pages and the parameter tool.

The site is a folder of static files. It loads nothing from elsewhere, and the same sources yield the same bytes.
"""

import argparse
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections import namedtuple
from pathlib import Path
from urllib.parse import urlsplit
from xml.etree import ElementTree

import yaml
from lxml import html as lxml_html

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

import tested  # noqa: E402

TOOL = "plcfmu-tool.html"
TRY = "Try it in the browser"
LONGEST_DESCRIPTION = 160
# Files that are copied instead of becoming pages.
FILES = {".gif", ".png", ".svg"}
# The target of a link or picture.
TARGET = re.compile(r"(?<=\]\()[^)\s]+(?=\))")
# The heading of a section in an FMU page.
SECTION = re.compile(r'^<h([23]) id="([^"]+)">(.*?)</h\1>$', re.MULTILINE)

Fmu = namedtuple("Fmu", "name description kind")


class SourceError(Exception):
    """A document in the repository cannot be converted to a page."""


class Site:
    """A site to be written.

    `fmus` is the folder of the FMUs; `out` is the folder of the site, which is replaced. `tool` is the page of the
    parameter tool, if the site includes it. `address` is the URL at which the site will be published, such as
    https://example.org/plcfmu/. `repository` is the URL of the sources; if set, each page has a link to edit it.
    `results` is the folder with the test results.
    """

    def __init__(self, fmus, out, tool=None, address="", repository="", results=None):
        self.fmus = Path(fmus)
        self.out = Path(out)
        self.tool = tool
        self.address = address and address.rstrip("/") + "/"
        self.repository = repository
        self.tested = results and tested.page((ROOT / "tests/README.md").read_text("utf-8"), Path(results))
        self.config = yaml.safe_load((HERE / "mkdocs.yml").read_text("utf-8"))
        self.pending = []
        self.known = set()
        self.variables = []

    def write(self):
        """Builds the site and replaces `out`."""
        if self.out.exists() and any(self.out.iterdir()) and not (self.out / "search.json").is_file():
            raise FileExistsError(f"{self.out} is neither empty nor a site: choose another folder")
        paths = sorted(self.fmus.glob("*.fmu"))
        if not paths:
            raise FileNotFoundError(f"no FMU in {self.fmus}: `cargo xtask fmu` builds them")
        with tempfile.TemporaryDirectory() as folder:
            self.stage(Path(folder), paths)
            build(folder)
            self.index_variables(Path(folder) / "site")
            shutil.rmtree(self.out, ignore_errors=True)
            shutil.copytree(Path(folder) / "site", self.out)

    def stage(self, folder, paths):
        """Collects the sources of the site in a folder."""
        self.docs = folder / "docs"
        self.pages = {path.stem: described(path) for path in paths}
        shutil.copytree(HERE / "overrides", folder / "overrides")
        for name in ("favicon.svg", "iframe-worker.js"):
            self.place(name, (HERE / name).read_bytes())
        self.place("site.css", style())
        self.place("python/index.md", page("The Python package plcfmu", "Classes and functions of the Python package plcfmu.", "::: plcfmu"))
        if self.tool:
            self.place(TOOL, Path(self.tool).read_bytes())
        if self.tested:
            text = self.linked(self.tested, "tests/README.md")
            self.place("tests/tested.md", page("What was tested, on which system", "The test results for each promise.", text))
        for source in sources(self.menu()):
            if source.endswith(".md") and (ROOT / source).is_file():
                self.need(source)
        for path in paths:
            self.fmu(path)
        while self.pending:
            source = self.pending.pop()
            if source.endswith(".md"):
                self.document(source)
            elif (ROOT / source).is_dir():
                self.folder(source)
            else:
                self.source(source)
        (folder / "mkdocs.yml").write_text(yaml.safe_dump(self.config, sort_keys=False), "utf-8")

    def menu(self):
        """Completes the configuration, including the menu, and returns the menu."""
        self.config["plugins"]["mkdocstrings"]["handlers"]["python"]["paths"] = [str(ROOT / "plcfmu/python")]
        if self.address:
            self.config["site_url"] = self.address
        if self.repository:
            self.config |= {"repo_url": self.repository, "edit_uri": "edit/main/"}
        start, guides, reference, blocks = (part for entry in self.config["nav"] for part in entry.values())
        if self.tool:
            start.insert(1, {TRY: TOOL})
        if self.tested:
            place = next(place for place, entry in enumerate(reference) if "tests/README.md" in entry.values())
            reference.insert(place, {"What was tested": "tests/tested.md"})
        listed = set(sources(self.config["nav"]))
        for path in sorted((ROOT / "docs").glob("*.md")):
            if f"docs/{path.name}" not in listed:
                guides.append({first_heading(path.read_text("utf-8")): f"docs/{path.name}"})
        entries = {kind: [{fmu.name: page_of_fmu(fmu.name)} for fmu in self.pages.values() if fmu.kind == kind] for kind in ("block", "plant", "own")}
        blocks[0]["Plants"] += entries["plant"]
        blocks[:0] = entries["block"]
        if entries["own"]:
            blocks.append({"Examples": entries["own"]})
        return self.config["nav"]

    def fmu(self, path):
        """Unpacks an FMU except its libraries, offers it for download, and adds its page to the site."""
        name = path.stem
        with zipfile.ZipFile(path) as package:
            for entry in package.namelist():
                if not entry.startswith("binaries/"):
                    package.extract(entry, self.docs / "fmu" / name)
        shutil.copyfile(path, self.docs / "fmu" / path.name)
        target = page_of_fmu(name)
        made = (self.docs / target).with_suffix(".html")
        text = re.search(r'<main id="main">\n(.*)</main>', made.read_text("utf-8"), re.DOTALL)[1]
        made.unlink()
        self.variables += [(target, row) for row in lxml_html.fromstring(f"<main>{text}</main>").xpath("//tr[@id]")]
        # The theme adds a title and a table of contents.
        text = re.sub(r"<h1>.*?</h1>\n|<nav class=\"contents\".*?</nav>\n", "", text, flags=re.DOTALL)
        intro, *sections = SECTION.split(text)
        size = f"{path.stat().st_size / 1e6:.1f}".rstrip("0").rstrip(".")
        parts = [f"[Download {path.name}](../../{path.name}){{ .md-button .md-button--primary download }} {size} MB", raw(intro)]
        for level, anchor, title, content in zip(*[iter(sections)] * 4):
            parts += [f"{'#' * int(level)} {title} {{ #{anchor} }}", raw(content)]
        self.place(target, page(name, self.pages[name].description, "\n\n".join(parts)))

    def document(self, source):
        """Adds a document in the repository."""
        text = self.linked((ROOT / source).read_text("utf-8"), source)
        # Links table rows about FMUs to their pages, which do not exist in the repository.
        names = "|".join(self.pages)
        to_root = "../" * source.count("/")
        text = re.sub(rf"^\| `({names})` \|", lambda row: f"| [`{row[1]}`]({to_root}{page_of_fmu(row[1])}) |", text, flags=re.MULTILINE)
        if source == "README.md" and self.tool:
            text = re.sub(r"^!\[.*\n", rf"\g<0>\n[{TRY}]({TOOL}){{ .md-button .md-button--primary }}\n", text, count=1, flags=re.MULTILINE)
        about = next(paragraphs(text), source)
        self.place(source, front_matter(description=shortened(about)) + text)

    def folder(self, source):
        """Adds a page that lists the files of a folder without a README.md."""
        entries = sorted(entry.name for entry in (ROOT / source).iterdir() if not entry.name.startswith(("__", ".")))
        listed = "\n".join(f"- [{name}]({self.link(name, f'{source}/x')})" for name in entries)
        self.place(f"{source}/index.md", page(source, f"The folder {source} in the plcfmu repository.", listed, is_found=False))

    def source(self, source):
        """Adds a page that shows a file in the repository."""
        text = (ROOT / source).read_text("utf-8")
        language = Path(source).suffix[1:] or "text"
        fence = "~" * 12
        content = f"{fence}{{.{language}}}\n{text}\n{fence}"
        self.place(f"{source}.md", page(source, f"The file {source} in the plcfmu repository.", content, is_found=False))

    def linked(self, markdown, source):
        """A document with its links adapted to the site; code is left unchanged."""
        parts = re.split(r"(^```.*?^```|^~~~.*?^~~~|`[^`\n]+`)", markdown, flags=re.MULTILINE | re.DOTALL)
        return "".join(part if number % 2 else TARGET.sub(lambda found: self.link(found[0], source), part) for number, part in enumerate(parts))

    def link(self, href, source):
        """The link `href` in the document `source`, adapted to the site. Its target is added to the site."""
        parts = urlsplit(href)
        if parts.scheme or not parts.path:
            return href
        path = os.path.normpath(os.path.join(os.path.dirname(source), parts.path)).replace(os.sep, "/")
        if not (ROOT / path).exists():
            raise SourceError(f"{source} links to {href}, but {path} does not exist: correct the link")
        link = os.path.relpath(self.need(path), os.path.dirname(source) or ".").replace(os.sep, "/")
        return f"{link}#{parts.fragment}" if parts.fragment else link

    def need(self, path):
        """The path on the site of a file or folder in the repository, which is added to the site."""
        if (ROOT / path / "README.md").is_file():
            path = f"{path}/README.md"
        is_file = Path(path).suffix in FILES
        if path not in self.known:
            self.known.add(path)
            if is_file:
                self.place(path, (ROOT / path).read_bytes())
            else:
                self.pending.append(path)
        if is_file or path.endswith(".md"):
            return path
        return f"{path}/index.md" if (ROOT / path).is_dir() else f"{path}.md"

    def index_variables(self, site):
        """Adds the FMU variables to the search index, which otherwise contains only headings."""
        index = json.loads((site / "search.json").read_text("utf-8"))
        for target, row in self.variables:
            name, location = row.get("id"), target.removesuffix(".md") + ".html"
            short = row.find(".//td/span[@class='short']")
            words = [short.text_content() + ".", *(more.text_content() for more in short.itersiblings())]
            text = f"<p>{html.escape(' '.join(' '.join(words).split()), quote=False)}</p>"
            fmu = target.split("/")[1]
            index["items"].append({"location": f"{location}#{name}", "level": 3, "title": name, "text": text, "path": ["Blocks", fmu, "Variables"], "tags": []})
        written = json.dumps(index, ensure_ascii=False, separators=(",", ":"))
        (site / "search.json").write_text(written, "utf-8")
        # A page opened from disk may not fetch files, so the index is also written as a script.
        (site / "search.js").write_text(f"var __index = {written}", "utf-8")

    def place(self, path, content):
        target = self.docs / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content.encode() if isinstance(content, str) else content)


def build(folder):
    """Builds the site in a folder with Zensical. Warnings count as errors."""
    command = [sys.executable, "-m", "zensical", "build", "--strict", "--config-file", "mkdocs.yml"]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise SourceError(f"Zensical could not build the site:\n{done.stdout.split('Traceback')[0]}")


def sources(menu):
    """The sources of the pages in a menu, in order."""
    for entry in menu:
        for target in entry.values():
            yield from [target] if isinstance(target, str) else sources(target)


def page(title, description, content, is_found=True):
    """A page without a document in the repository. `is_found` is whether the search finds it."""
    facts = {"description": shortened(description), "generated": True}
    if not is_found:
        facts["search"] = {"exclude": True}
    return f"{front_matter(**facts)}# {title}\n\n{content}\n"


def front_matter(**facts):
    return f"---\n{yaml.safe_dump(facts, allow_unicode=True, width=1000)}---\n\n"


def raw(text):
    """HTML from an FMU page, which Markdown leaves unchanged."""
    return f'<div class="fmu">\n{text.strip()}\n</div>'


def page_of_fmu(name):
    """The path of an FMU page: the same as in the FMU, so that its links to the FMU's files work."""
    return f"fmu/{name}/documentation/index.md"


def described(path):
    """The name, description and kind of an FMU."""
    with zipfile.ZipFile(path) as package:
        root = ElementTree.fromstring(package.read("modelDescription.xml"))
    return Fmu(path.stem, root.get("description").split("\n")[0], kind(path.stem))


def kind(name):
    """The kind of an FMU, according to the location of its source: PLC block, plant, or example of a user's own block."""
    if (ROOT / "plants" / "src" / f"{name.lower()}.rs").is_file():
        return "plant"
    return "block" if (ROOT / "fmu" / "libraries" / name.lower()).is_dir() else "own"


def first_heading(markdown):
    """A document's title."""
    return re.search(r"^# (.*)", markdown, re.MULTILINE)[1].replace("`", "")


def paragraphs(markdown):
    """The paragraphs of a document as plain text, without headings, pictures, tables and code."""
    for block in re.split(r"\n\s*\n", markdown):
        if re.match(r"[A-Z`*\[]", block):
            text = re.sub(r"\[([^]]*)\]\([^)]*\)(\{[^}]*\})?", r"\1", block)
            yield re.sub(r"[`*|]", "", text)


def shortened(text):
    """The beginning of a text, short enough for search engines and previews."""
    text = " ".join(text.split())
    if len(text) <= LONGEST_DESCRIPTION:
        return text
    return text[: text.rfind(" ", 0, LONGEST_DESCRIPTION - 2)].rstrip(",;:.") + " …"


def style():
    """The site's own rules, and those of the FMU pages for the content from there, in the colour scheme chosen by the reader."""
    templates = ROOT / "draw" / "src" / "templates"
    rules = (templates / "style.css").read_text("utf-8")
    rules = rules.replace("@media screen and (prefers-color-scheme: dark) {", '[data-md-color-scheme="slate"] & {')
    rules = rules.replace(":root {", "& {")
    # The theme has a different root font size.
    rules = re.sub(r"([\d.]+)rem\b", lambda size: f"{16 * float(size[1]):g}px", rules)
    palette = (ROOT / "plcfmu/python/plcfmu/palette.css").read_text("utf-8")
    return f"{palette}{(HERE / 'site.css').read_text('utf-8')}.fmu {{\n{rules}}}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--fmus", default=ROOT / "target" / "fmu", help="folder of the FMUs [default: target/fmu]")
    parser.add_argument("--out", default=ROOT / "target" / "docs", help="folder of the site, which is replaced [default: target/docs]")
    parser.add_argument("--tool", help="page of the parameter tool, to include in the site")
    parser.add_argument("--address", default="", help="URL at which the site will be published, for absolute links")
    parser.add_argument("--repository", default="", help="URL of the published sources, for links to edit a page")
    parser.add_argument("--results", help="folder with the test results, for the page 'What was tested'")
    arguments = parser.parse_args()
    try:
        Site(**vars(arguments)).write()
    except (SourceError, FileExistsError, FileNotFoundError) as error:
        sys.exit(f"error: {error}")
    print(Path(arguments.out) / "index.html")


if __name__ == "__main__":
    main()
