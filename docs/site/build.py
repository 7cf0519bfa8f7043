"""Writes the project's site: the FMUs' pages, the repository's documents, the reference of the Python package.

The site is a folder of files. Nothing in it is loaded from elsewhere, and the same sources give the same bytes.
"""

import argparse
import html
import importlib
import io
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
import PIL.Image
import pygments
import pygments.formatters
import pygments.lexers
import pygments.util

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE))

from menu import Menu  # noqa: E402
from search import Index, shortened  # noqa: E402

TOOL = "plcfmu-tool.html"
THUMBNAIL = (640, 360)
PICTURES = {".gif", ".png", ".svg"}
# A picture in Markdown: its text and its file.
PICTURE = re.compile(r"!\[(.*?)\]\((.*?)\)", re.DOTALL)

Heading = namedtuple("Heading", "level id text")
Fmu = namedtuple("Fmu", "name description kind")
Loop = namedtuple("Loop", "title picture id")

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

    `fmus` is the folder of the FMUs; `out` is the folder of the site, which is made anew. `tool` is the page of the
    parameter tool, if the site is to have it. `address` is where the site will be published, such as
    https://example.org/plcfmu/: what needs whole addresses (previews, the sitemap, the links of the page for what is not
    found) is made with it.
    """

    def __init__(self, fmus, out, tool=None, address=""):
        self.fmus = Path(fmus)
        self.out = Path(out)
        self.tool = tool
        self.address = address and address.rstrip("/") + "/"
        self.pending = []  # documents and folders that a page links to
        self.known = set()
        self.pages = []
        self.index = Index()
        self.version = re.search(r'^version = "(.+)"$', (ROOT / "Cargo.toml").read_text("utf-8"), re.MULTILINE)[1]

    def write(self):
        """Writes everything."""
        if self.out.exists():
            if any(self.out.iterdir()) and not (self.out / "site.css").is_file():
                raise FileExistsError(f"{self.out} is neither empty nor a site: choose another folder")
            shutil.rmtree(self.out)
        self.out.mkdir(parents=True)
        self.place("site.css", style())
        for name in ("site.js", "favicon.svg"):
            self.place(name, (HERE / name).read_bytes())
        if self.tool:
            self.place(TOOL, Path(self.tool).read_bytes())
        paths = sorted(self.fmus.glob("*.fmu"))
        if not paths:
            raise FileNotFoundError(f"there is no FMU in {self.fmus}: make them with `cargo xtask fmu`")
        fmus = [described(path) for path in paths]
        self.menu = Menu(ROOT, fmus, page_of)
        self.fmu_pages = {fmu.name: self.menu.page(fmu) for fmu in fmus}
        for source in self.menu.sources:
            self.need(source)
        for path, fmu in zip(paths, fmus):
            self.fmu(path, fmu)
        self.front(fmus)
        self.reference()
        while self.pending:
            source = self.pending.pop()
            if (ROOT / source).is_dir():
                self.folder(source)
            elif source.endswith(".md"):
                self.document(source)
            else:
                self.source(source)
        self.render("missing.html", "404.html", "This page does not exist", headings=[], about="There is no such page.")
        self.place("search.js", self.index.script())
        if self.address:
            self.place("sitemap.txt", "".join(f"{self.address}{page}\n" for page in sorted(self.pages)))

    def front(self, fmus):
        """The front page. Its texts are those of the documents, so that they stand in one place."""
        documents = ("README.md", "fmu/README.md", "examples/README.md", "docs/import.md")
        readme, fmu, examples, guides = (sections((ROOT / name).read_text("utf-8")) for name in documents)
        if "In short" not in fmu:
            raise SourceError("fmu/README.md has no section 'In short': the front page shows it")

        # The tools, with links to their sections: those that were tried stand first.
        tools = re.search(r"(?:^\|.*\n)+", guides[""], re.MULTILINE)[0].replace("(#", "(import.md#")

        alternative, picture = PICTURE.search(readme[""]).groups()
        page = {
            "intro": self.html(readme[""].split("\n\n")[1], "README.md", "index.html")[0],
            "picture": (alternative, self.link(picture, "README.md", "index.html")),
            "promises": self.html(fmu["In short"], "fmu/README.md", "index.html")[0],
            "fmus": fmus,
            "loops": [
                Loop(title, self.thumbnail(os.path.join("examples", found[2])), slug(title))
                for title, text in examples.items()
                if (found := PICTURE.search(text))
            ],
            "tools": self.html(tools, "docs/import.md", "index.html")[0],
            "minimal": highlighted((HERE / "minimal_loop.py").read_text("utf-8"), "python"),
        }
        about = plain(readme[""].split("\n\n")[1])
        self.render("index.html", "index.html", "PLC control blocks as FMUs", headings=[], about=about, **page)

    def fmu(self, path, fmu):
        """Unpacks all of an FMU but its libraries; its page becomes one of the site's."""
        with zipfile.ZipFile(path) as package:
            for entry in package.namelist():
                if not entry.startswith("binaries/"):
                    package.extract(entry, self.out / "fmu" / fmu.name)
        target = self.menu.page(fmu)
        text = (self.out / target).read_text("utf-8")
        self.index.add_page(target, fmu.name, text)
        frame = self.frame(target, fmu.name, fmu.description)
        head, top, bottom = (ESCAPED.get_template(f"{part}.html").render(frame) for part in ("head", "top", "bottom"))
        text = re.sub(r"<title>.*?</title>", lambda _: f"<title>{html.escape(fmu.name)} - plcfmu</title>", text, count=1)
        # The frame has its own.
        text = text.replace('<a class="skip" href="#main">Skip to the text</a>\n', "", 1)
        text = re.sub(r'<meta name="description".*\n', "", text, count=1)
        text = text.replace("</head>", f"{head}\n</head>", 1).replace("<body>\n", f"<body>\n{top}\n", 1)
        self.place(target, text.replace("</body>", f"{bottom}\n</body>", 1))

    def document(self, source):
        """A document of the repository."""
        target = page_of(source)
        text, headings = self.html((ROOT / source).read_text("utf-8"), source, target)
        title = next((heading.text for heading in headings if heading.level == 1), source)
        self.index.add_page(target, title, f"<main>{text}</main>")
        about = plain(next(iter(paragraphs((ROOT / source).read_text("utf-8"))), title))
        self.render("document.html", target, title, headings=headings, text=text, about=about)

    def folder(self, source):
        """A folder without a document: its files."""
        entries = sorted(entry.name for entry in (ROOT / source).iterdir() if not entry.name.startswith(("__", ".")))
        links = [(name, self.link(name, f"{source}/folder", page_of(source))) for name in entries]
        about = f"The folder {source} of the repository of plcfmu."
        self.render("folder.html", page_of(source), source, headings=[], entries=links, about=about)

    def source(self, source):
        """A file of the repository."""
        text = (ROOT / source).read_text("utf-8")
        try:
            language = pygments.lexers.get_lexer_for_filename(source).aliases[0]
        except pygments.util.ClassNotFound:
            language = "text"
        page = f'<h1>{html.escape(source)}</h1>\n{highlighted(text, language)}'
        about = f"The file {source} of the repository of plcfmu."
        self.render("document.html", page_of(source), source, headings=[], text=page, about=about)

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

        # What one calls stands before what one catches.
        members = sorted(public(package), key=lambda member: member.name.endswith("Error"))
        modules = package.submodules
        headings = [Heading(2, anchor(member), member.name) for member in members + modules]
        self.render(
            "reference.html",
            "python/index.html",
            "The Python package plcfmu",
            about="Classes and functions of the Python package plcfmu: closed loops of FMUs, figures, plots, studies.",
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
        parser.add_render_rule("code_inline", unbroken)
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
                if child.type == "text":
                    # A number is not parted from its percent sign, its unit or its tolerance at the end of a line, nor
                    # behind its thousands.
                    parting = r"(?<=\d) (?=(?:%|°C|K|s|ms|h|KB|MB|\d{3}(?!\d))(?!\w))|(?<=±) (?=\d)"
                    child.content = re.sub(parting, "\u00a0", child.content)
                elif child.type == "link_open":
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
        # A row about an FMU leads to its page, which the repository does not have.
        text = re.sub(r"(?<=<td><code>)\w+(?=</code></td>)", lambda name: self.led(name[0], target), text)
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

    def led(self, name, target):
        """The name of an FMU with a link to its page; any other name as it is."""
        page = self.fmu_pages.get(name)
        return f'<a href="{os.path.relpath(page, os.path.dirname(target) or ".")}">{name}</a>' if page else name

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

    def frame(self, target, title, about):
        """What the frame of a page shows: the menu, the neighbours, what other programs are told of the page."""
        if target != "404.html":
            self.pages.append(target)
        return {
            "title": title,
            "about": shortened(about),
            "root": self.address if target == "404.html" and self.address else "../" * target.count("/"),
            "address": self.address,
            "target": target,
            "menu": self.menu.groups,
            "neighbours": self.menu.neighbours(target),
            "version": self.version,
            "tool": TOOL if self.tool else "",
            "to": page_of,
        }

    def render(self, template, target, title, about, **content):
        contents = [heading for heading in content["headings"] if heading.level == 2]
        page = ESCAPED.get_template(template).render(self.frame(target, title, about), contents=contents, **content)
        if template in ("index.html", "reference.html"):
            self.index.add_page(target, title, page)
        self.place(target, page)

    def thumbnail(self, source):
        """A small copy of a picture, for the front page."""
        target = f"thumbnails/{Path(source).name}"
        picture = PIL.Image.open(ROOT / source).convert("RGB")
        picture.thumbnail(THUMBNAIL, PIL.Image.Resampling.LANCZOS)
        small = io.BytesIO()
        picture.quantize(64).save(small, "PNG", optimize=True)
        self.place(target, small.getvalue())
        return target

    def place(self, path, content):
        target = self.out / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content.encode() if isinstance(content, str) else content)


def unbroken(renderer, tokens, place, options, env):
    """Code in a line, in which an option is not broken behind its hyphens; a path and a long name are, between their words."""
    code = re.sub(r"(?<!\S)--?[\w-]+", r'<span class="option">\g<0></span>', html.escape(tokens[place].content))
    if len(tokens[place].content) > 12:
        code = re.sub(r"[/_,:=(](?=[\w{*])(?![^<]*>)", r"\g<0><wbr>", code)
    return f"<code>{code}</code>"


def page_of(source):
    """The page of a file or folder of the repository. A folder's README is the page of the folder."""
    if Path(source).suffix in PICTURES:
        return source
    if source == "README.md":
        return "overview.html"
    if source.endswith("/README.md"):
        return source.removesuffix("README.md") + "index.html"
    if source.endswith(".md"):
        return source[:-3] + ".html"
    return f"{source}/index.html" if (ROOT / source).is_dir() else f"{source}.html"


def described(path):
    """What an FMU says that it is."""
    with zipfile.ZipFile(path) as package:
        root = ElementTree.fromstring(package.read("modelDescription.xml"))
    return Fmu(path.stem, root.get("description").split("\n")[0], kind(path.stem))


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
        is_method = "." in member.qualname and not member.is_staticmethod
        text = str(member.signature_without_self if is_method else member.signature)
    text = re.sub(r"ForwardRef\('(.*?)'\)", r"\1", " ".join(text.split()))
    text = re.sub(r"plcfmu\.\w+\.(?=[A-Z])", "", text)
    text = re.sub(r"ndarray\[tuple\[(?:typing\.)?Any, \.\.\.\], numpy\.dtype\[[\w.]+\]\]", "ndarray", text)
    text = text.replace("typing.", "").replace("( ", "(").replace(" )", ")").replace("NoneType", "None")
    return text and member.name + text


def slug(heading):
    """The anchor of a heading, as on GitHub."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def sections(markdown):
    """A document by its headings of the second level; what is above the first one has the empty heading."""
    pieces = re.split(r"^## (.*)\n", markdown, flags=re.MULTILINE)
    return {"": pieces[0], **dict(zip(pieces[1::2], pieces[2::2]))}


def paragraphs(markdown):
    """The paragraphs of a document that are plain text."""
    return [piece for piece in markdown.split("\n\n") if re.match(r"[A-Za-z`\[*]", piece)]


def plain(markdown):
    """A paragraph of Markdown without its marks."""
    return re.sub(r"[`*]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", markdown))


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
    # Documentation in a program is a comment, as it is in the dark; red would say that something is wrong.
    light += "\n.source .sd { color: #177500 }"
    dark = f"@media screen and (prefers-color-scheme: dark) {{\n{dark}\n}}\n"
    return "\n".join([pages, (HERE / "site.css").read_text("utf-8"), light, dark])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--fmus", default=ROOT / "target" / "fmu", help="folder of the FMUs [target/fmu]")
    parser.add_argument("--out", default=ROOT / "target" / "docs", help="folder of the site, made anew [target/docs]")
    parser.add_argument("--tool", help="page of the parameter tool, which becomes a part of the site [none]")
    parser.add_argument("--address", default="", help="where the site will be published, for previews and the sitemap")
    arguments = parser.parse_args()
    try:
        Site(arguments.fmus, arguments.out, arguments.tool, arguments.address).write()
    except (SourceError, FileExistsError, FileNotFoundError) as error:
        sys.exit(f"error: {error}")
    print(Path(arguments.out) / "index.html")


if __name__ == "__main__":
    main()
