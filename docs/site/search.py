"""The index of the site's search: every section and every variable, with its text, for the script in the page."""

import json
import re

from lxml import html

# Sections that say the same on the page of every FMU.
COMMON = {"host", "licence", "calls"}
LONGEST = 160


class Index:
    """What can be found: `pages` are addresses and titles, `entries` the number of a page, an anchor, a heading and a text."""

    def __init__(self):
        self.pages = []
        self.entries = []

    def add_page(self, target, title, text):
        """Takes up a page: what stands under each of its headings, and each row of a table that has an anchor."""
        number = len(self.pages)
        self.pages.append([target, title])
        main = html.document_fromstring(text).find(".//main")
        for drawing in main.xpath(".//svg | .//nav | .//math"):
            drawing.drop_tree()
        anchor, heading, words = "", title, []
        has_common = any(address.startswith("fmu/") for address, _ in self.pages[:-1]) and target.startswith("fmu/")

        def close():
            said = " ".join(" ".join(words).split())
            if said and not (has_common and anchor in COMMON):
                self.entries.append([number, anchor, heading, said])

        for element in main.iter():
            if not isinstance(element.tag, str):
                continue
            if element.tag in ("h1", "h2", "h3"):
                close()
                anchor, heading, words = element.get("id", ""), element.text_content().strip(), []
            elif element.tag == "tr" and element.get("id"):
                short = element.find(".//td/span[@class='short']")
                said = [short.text_content() + ".", *(more.text_content() for more in short.itersiblings())]
                self.entries.append([number, element.get("id"), element.get("id"), " ".join(" ".join(said).split())])
            elif element.tag in ("p", "li", "dt", "dd", "pre", "td", "th") and not is_inside(element):
                words.append(element.text_content())
        close()

    def script(self):
        """The index as a script, because a page that was opened from a disk cannot fetch a file."""
        data = json.dumps({"pages": self.pages, "entries": self.entries}, ensure_ascii=False, separators=(",", ":"))
        return f"window.plcfmuIndex = {data};\n"


def is_inside(element):
    """Whether the text of an element was taken with that of another one, or is that of a variable."""
    return any(
        parent.tag in ("p", "li", "dd", "td", "th") or parent.tag == "tr" and parent.get("id")
        for parent in element.iterancestors()
    )


def shortened(text):
    """A text as search engines and previews show it: its first words."""
    text = re.sub(r"\s+", " ", text).strip()
    return text if len(text) <= LONGEST else text[: text.rfind(" ", 0, LONGEST - 2)].rstrip(",;:.") + " …"
