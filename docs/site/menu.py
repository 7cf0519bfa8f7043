"""The menu of the site: which page stands in which part of it, and which one comes before and after."""

import re
from collections import namedtuple

# Documents by part, with the names that they have in the menu. A document of docs/ that is not here is a guide.
TUTORIAL = {
    "README.md": "What it is, and a first loop",
    "examples/README.md": "Closed loops, with what theory predicts",
    "docs/tune_study.md": "Settings for many plants",
}
GUIDES = {
    "docs/import.md": "Import into your tool",
    "docs/tool.md": "Parameter tool",
    "parameters/README.md": "PLC files",
    "docs/tia.md": "From TIA Portal to an FMU",
    "docs/scl.md": "PLC programs in SCL",
    "docs/fmi3.md": "FMI 3.0",
    "docs/c_sources.md": "C sources",
    "docs/prove.md": "Proof on your CPU",
    "docs/studies.md": "Studies",
    "docs/clusters.md": "Studies on clusters",
    "blocks/README.md": "How blocks are made",
}
REFERENCE = {
    "plcfmu/README.md": "Command",
    "python/index.html": "Python",
    "plcfmu/python/README.md": "Python: install",
    "plants/README.md": "Plants",
    "fmu/README.md": "What every FMU promises",
    "tests/README.md": "Tests",
    "docs/architecture.md": "Architecture",
    "CHANGELOG.md": "Changes",
    "CONTRIBUTING.md": "Take part",
}

Entry = namedtuple("Entry", "title page")
Group = namedtuple("Group", "title parts")
Part = namedtuple("Part", "title entries")


class Menu:
    """The menu, for a repository and its FMUs. `page_of` tells the page of a document."""

    def __init__(self, root, fmus, page_of):
        guides = dict(GUIDES)
        for path in sorted((root / "docs").glob("*.md")):
            source = f"docs/{path.name}"
            if source not in TUTORIAL | REFERENCE:
                guides.setdefault(source, first_heading(path.read_text("utf-8")))
        documents = {**TUTORIAL, **guides, **REFERENCE}
        self.sources = [source for source in documents if source.endswith(".md")]

        def entries(sources):
            return [Entry(title, page_of(source) if source.endswith(".md") else source) for source, title in sources.items()]

        def pages(kind):
            return [Entry(fmu.name, self.page(fmu)) for fmu in fmus if fmu.kind == kind]

        parts = [Part(title, pages(kind)) for kind, title in [("block", "Blocks"), ("plant", "Plants"), ("own", "Examples")]]
        self.groups = [
            Group("Tutorial", [Part("", entries(TUTORIAL))]),
            Group("Guides", [Part("", entries(guides))]),
            Group("Reference", [*(part for part in parts if part.entries), Part("More", entries(REFERENCE))]),
        ]
        self.order = [entry for group in self.groups for part in group.parts for entry in part.entries]

    def page(self, fmu):
        """The page of an FMU."""
        return f"fmu/{fmu.name}/documentation/index.html"

    def neighbours(self, page):
        """The entries before and after a page; None at the ends, and for a page that is not in the menu."""
        place = next((place for place, entry in enumerate(self.order) if entry.page == page), None)
        if place is None:
            return None, None
        return (self.order[place - 1] if place else None), next(iter(self.order[place + 1:]), None)


def first_heading(markdown):
    """The title of a document."""
    return re.search(r"^# (.*)", markdown, re.MULTILINE)[1].replace("`", "")
