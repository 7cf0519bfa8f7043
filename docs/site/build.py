"""Writes the project's site: the FMUs' pages, the repository's documents, the reference of the Python package.

The site is a folder of files. Nothing in it is loaded from elsewhere, and the same sources give the same bytes.
"""

import argparse
import html
import importlib
import os
import re
import shutil
import sys
import warnings
import zipfile
from collections import namedtuple
from pathlib import Path
from urllib.parse import urlsplit
from xml.etree import ElementTree

import jinja2
import markdown_it
import pdoc.doc
import pygments
import pygments.formatters
import pygments.lexers
import pygments.util

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PICTURES = {".png", ".svg"}
# A picture in Markdown: its text and its file.
PICTURE = re.compile(r"!\[(.*?)\]\((.*?)\)", re.DOTALL)

Heading = namedtuple("Heading", "level id text")
Fmu = namedtuple("Fmu", "name description kind")
Loop = namedtuple("Loop", "title picture id")
Guide = namedtuple("Guide", "title id state")

ESCAPED = jinja2.Environment(
    loader=jinja2.FileSystemLoader(HERE / "templates"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
)


class SourceError(Exception):
    """A document of the repository cannot be shown as it is."""


class Site:
    """A site that is being written.

    `fmus` is the folder of the FMUs; `out` is the folder of the site, which is made anew.
    """

    def __init__(self, fmus, out):
        self.fmus = Path(fmus)
        self.out = Path(out)
        self.pending = []  # documents and folders that a page links to
        self.known = set()

    def write(self):
        """Writes everything."""
        if self.out.exists():
            if any(self.out.iterdir()) and not (self.out / "site.css").is_file():
                raise FileExistsError(f"{self.out} is neither empty nor a site: choose another folder")
            shutil.rmtree(self.out)
        self.out.mkdir(parents=True)
        self.place("site.css", style())
        fmus = [self.fmu(path) for path in sorted(self.fmus.glob("*.fmu"))]
        if not fmus:
            raise FileNotFoundError(f"there is no FMU in {self.fmus}: make them with `cargo xtask fmu`")
        self.index(fmus)
        self.reference()
        self.need("README.md")
        self.need("docs/tool.md")
        self.need("docs/studies.md")
        while self.pending:
            source = self.pending.pop()
            if (ROOT / source).is_dir():
                self.folder(source)
            elif source.endswith(".md"):
                self.document(source)
            else:
                self.source(source)

    def index(self, fmus):
        """The front page. Its texts are those of the documents, so that they stand in one place."""
        readme, examples, guides = (
            sections((ROOT / name).read_text("utf-8")) for name in ("README.md", "examples/README.md", "docs/import.md")
        )

        def of_readme(word):
            """The section with this word in its heading."""
            titles = [title for title in readme if word in title]
            if len(titles) != 1:
                raise SourceError(f"README.md has {len(titles)} headings with {word!r}: the front page shows the one")
            return titles[0], self.html(readme[titles[0]], "README.md", "index.html")[0]

        alternative, picture = PICTURE.search(readme[""]).groups()
        page = {
            "intro": self.html(readme[""].split("\n\n")[1], "README.md", "index.html")[0],
            "picture": (alternative, self.link(picture, "README.md", "index.html")),
            "promises": of_readme("promises"),
            "surprises": of_readme("surprise"),
            "fmus": fmus,
            "loops": [
                Loop(title, self.link(found[2], "examples/README.md", "index.html"), slug(title))
                for title, text in examples.items()
                if (found := PICTURE.search(text))
            ],
            "guides": [
                Guide(title, slug(title), re.split(r"[.:](?:\s|$)", text.strip())[0])
                for title, text in guides.items()
                if text.strip().lower().startswith(("tried", "not tried"))
            ],
            "minimal": highlighted((HERE / "minimal_loop.py").read_text("utf-8"), "python"),
        }
        self.render("index.html", "index.html", "PLC control blocks as FMUs", headings=[], **page)

    def fmu(self, path):
        """Unpacks all of an FMU but its libraries; its page gets a link to the site."""
        name = path.stem
        with zipfile.ZipFile(path) as package:
            for entry in package.namelist():
                if not entry.startswith("binaries/"):
                    package.extract(entry, self.out / "fmu" / name)
        page = self.out / "fmu" / name / "documentation" / "index.html"
        text = page.read_text("utf-8")
        home = '<nav class="site" aria-label="Site"><a href="../../../index.html">plcfmu</a></nav>'
        page.write_text(text.replace("<body>\n", f"<body>\n{home}\n", 1), "utf-8")
        description = ElementTree.parse(self.out / "fmu" / name / "modelDescription.xml").getroot().get("description")
        return Fmu(name, description.split("\n")[0], kind(name))

    def document(self, source):
        """A document of the repository."""
        target = page_of(source)
        text, headings = self.html((ROOT / source).read_text("utf-8"), source, target)
        title = next((heading.text for heading in headings if heading.level == 1), source)
        self.render("document.html", target, title, headings=headings, text=text)

    def folder(self, source):
        """A folder without a document: its files."""
        entries = sorted(entry.name for entry in (ROOT / source).iterdir() if not entry.name.startswith(("__", ".")))
        links = [(name, self.link(name, f"{source}/folder", page_of(source))) for name in entries]
        self.render("folder.html", page_of(source), source, headings=[], entries=links)

    def source(self, source):
        """A file of the repository."""
        text = (ROOT / source).read_text("utf-8")
        try:
            language = pygments.lexers.get_lexer_for_filename(source).aliases[0]
        except pygments.util.ClassNotFound:
            language = "text"
        page = f'<h1>{html.escape(source)}</h1>\n{highlighted(text, language)}'
        self.render("document.html", page_of(source), source, headings=[], text=page)

    def reference(self):
        """The reference of the Python package, from its docstrings."""
        sys.path.insert(0, str(ROOT / "plcfmu" / "python"))
        # pdoc looks for the types of named tuples in the wrong module, says so, and shows them as they are written.
        warnings.filterwarnings("ignore", "Error parsing type annotation", module="pdoc")
        package = pdoc.doc.Module(importlib.import_module("plcfmu"))

        def public(owner):
            members = owner.members.values() if owner.kind == "module" else owner.own_members
            named = [one for one in members if not one.name.startswith("_")]
            # A variable of which nothing is said is in its class' signature.
            return [one for one in named if one.kind != "variable" or said_of(one)]

        def docs(member):
            return self.html(said_of(member), "plcfmu/python/README.md", "python/index.html", code="python")[0]

        def anchor(member):
            return member.fullname.removeprefix("plcfmu.")

        members, modules = public(package), package.submodules
        headings = [Heading(2, anchor(member), member.name) for member in members + modules]
        self.render(
            "reference.html",
            "python/index.html",
            "The Python package plcfmu",
            headings=headings,
            package=package,
            members=members,
            modules=modules,
            public=public,
            docs=docs,
            anchor=anchor,
            signature=signature,
        )

    def html(self, markdown, source, target, code=""):
        """Markdown as HTML for the page `target`, with the links of the document `source` rewritten; and its headings.

        `code` is the language of indented code.
        """
        options = {"highlight": lambda text, language, _: highlighted(text, language)}
        parser = markdown_it.MarkdownIt("commonmark", options).enable("table")
        tokens = parser.parse(markdown)
        headings = []
        for place, token in enumerate(tokens):
            if token.type == "heading_open":
                text = "".join(child.content for child in tokens[place + 1].children)
                headings.append(Heading(int(token.tag[1]), slug(text), text))
                token.attrSet("id", slug(text))
            elif token.type == "code_block":
                token.type, token.info = "fence", code
            for child in token.children or []:
                if child.type == "link_open":
                    child.attrSet("href", self.link(child.attrGet("href"), source, target))
                elif child.type == "image":
                    child.attrSet("src", self.link(child.attrGet("src"), source, target))
                    if not child.content and headings:
                        # A picture without a text is named by the heading that it stands under.
                        child.children = [markdown_it.token.Token("text", "", 0, content=headings[-1].text)]
        text = parser.renderer.render(tokens, parser.options, {})
        text = text.replace("<table>", '<div class="scroll" tabindex="0"><table>').replace("</table>", "</table></div>")
        # The corner of a table may be empty, but is no heading then.
        text = text.replace("<th></th>", "<td></td>")
        return text.replace("<pre>", '<pre tabindex="0">'), headings

    def link(self, href, source, target):
        """The link `href` of the document `source` as it has to be on the page `target`; what it leads to is needed."""
        parts = urlsplit(href)
        if parts.scheme or not parts.path:
            return href
        path = os.path.normpath(os.path.join(os.path.dirname(source), parts.path)).replace(os.sep, "/")
        if not (ROOT / path).exists():
            raise SourceError(f"{source} links to {href}, but there is no {path}: correct the link")
        page = self.need(path)
        link = os.path.relpath(page, os.path.dirname(target) or ".").replace(os.sep, "/")
        return f"{link}#{parts.fragment}" if parts.fragment else link

    def need(self, path):
        """The place of a file or folder on the site; it will be there."""
        if (ROOT / path / "README.md").is_file():
            path = f"{path}/README.md"
        if path in self.known:
            return page_of(path)
        self.known.add(path)
        if Path(path).suffix in PICTURES:
            self.place(path, (ROOT / path).read_bytes())
        else:
            self.pending.append(path)
        return page_of(path)

    def render(self, template, target, title, **content):
        root = "../" * target.count("/")
        contents = [heading for heading in content["headings"] if heading.level == 2]
        page = ESCAPED.get_template(template).render(title=title, root=root, contents=contents, **content)
        self.place(target, page)

    def place(self, path, content):
        target = self.out / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content.encode() if isinstance(content, str) else content)


def page_of(source):
    """The page of a file or folder of the repository."""
    if Path(source).suffix in PICTURES:
        return source
    if source.endswith(".md"):
        return source[:-3] + ".html"
    return f"{source}/index.html" if (ROOT / source).is_dir() else f"{source}.html"


def kind(name):
    """Whether an FMU is a PLC block, a plant, or an example of a user's own block; told by where it stands."""
    if (ROOT / "plants" / "src" / f"{name.lower()}.rs").is_file():
        return "plant"
    return "block" if (ROOT / "fmu" / "libraries" / name.lower()).is_dir() else "own"


def said_of(member):
    """The docstring of a member of the Python package, without what Python says of the fields of every named tuple."""
    return "" if member.docstring.startswith("Alias for field number") else member.docstring


def signature(member):
    """How a member of the Python package is used: its parameters with their types; empty if it has none."""
    if member.kind == "variable":
        text = member.annotation_str
    elif member.kind == "class":
        made_by = member.members.get("__init__")
        text = str(made_by.signature_without_self) if made_by else ""
        # Such a class is made by the package, or as any exception is.
        if "._" in text or "*args" in text:
            text = ""
    else:
        is_method = "." in member.qualname and not (member.is_classmethod or member.is_staticmethod)
        text = str(member.signature_without_self if is_method else member.signature)
    text = re.sub(r"ForwardRef\('(.*?)'\)", r"\1", " ".join(text.split()))
    text = re.sub(r"plcfmu\.\w+\.(?=[A-Z])", "", text)
    text = re.sub(r"ndarray\[tuple\[typing\.Any, \.\.\.\], numpy\.dtype\[[\w.]+\]\]", "ndarray", text)
    text = text.replace("typing.", "").replace("( ", "(").replace(" )", ")").replace("NoneType", "None")
    return text and member.name + text


def slug(heading):
    """The anchor of a heading, as on GitHub."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def sections(markdown):
    """A document by its headings of the second level; what is above the first one has the empty heading."""
    pieces = re.split(r"^## (.*)\n", markdown, flags=re.MULTILINE)
    return {"": pieces[0], **dict(zip(pieces[1::2], pieces[2::2]))}


def highlighted(code, language):
    """A program as HTML, with its words in colours."""
    language = {"rust": "rust", "python": "python", "lua": "lua", "toml": "toml"}.get(language, "text")
    formatter = pygments.formatters.HtmlFormatter(nowrap=True)
    inner = pygments.highlight(code, pygments.lexers.get_lexer_by_name(language), formatter)
    return f'<pre tabindex="0"><code class="source">{inner}</code></pre>\n'


def style():
    """The stylesheet: that of the FMUs' pages, that of the site, and the colours of programs.

    These two of Pygments' styles are the ones with enough contrast on the panels.
    """
    pages = (ROOT / "draw" / "src" / "templates" / "style.css").read_text("utf-8")
    light, dark = (
        pygments.formatters.HtmlFormatter(style=name, nobackground=True).get_style_defs(".source")
        for name in ("xcode", "lightbulb")
    )
    dark = f"@media screen and (prefers-color-scheme: dark) {{\n{dark}\n}}\n"
    return "\n".join([pages, (HERE / "site.css").read_text("utf-8"), light, dark])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--fmus", default=ROOT / "target" / "fmu", help="folder of the FMUs [target/fmu]")
    parser.add_argument("--out", default=ROOT / "target" / "docs", help="folder of the site, made anew [target/docs]")
    arguments = parser.parse_args()
    try:
        Site(arguments.fmus, arguments.out).write()
    except (SourceError, FileExistsError, FileNotFoundError) as error:
        sys.exit(f"error: {error}")
    print(Path(arguments.out) / "index.html")


if __name__ == "__main__":
    main()
