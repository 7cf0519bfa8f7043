"""The commands that the guides print, in their order, with what they print of the output."""

import itertools
import pathlib
import re
import shlex

ROOT = pathlib.Path(__file__).parents[1]


class Sample:
    """A command as it is printed, with the lines that the guide shows of its output."""

    def __init__(self, words, output, line):
        self.words = words
        self.output = output
        self.line = line

    def __repr__(self):
        return f"line {self.line}: {' '.join(self.words)}"

    @property
    def fails(self):
        """Whether the guide shows an error of it."""
        return any(line.startswith("error: ") for line in self.output)


def code(markdown):
    """The blocks of code of a document: the number of the first line, and the lines without their indent."""
    blocks, block, fenced = [], None, False
    for number, line in enumerate(markdown.splitlines(), start=1):
        if line.startswith("```"):
            fenced = not fenced
            block = None
        elif fenced or line.startswith("    "):
            if block is None:
                block = (number, [])
                blocks.append(block)
            block[1].append(line if fenced else line[4:])
        elif line:
            block = None
        elif block and not fenced:
            block[1].append("")
    return blocks


def commands(markdown, programs=("plcfmu", "fmpy")):
    """The samples of a document that run these programs."""
    samples = []
    for first, lines in code(markdown):
        sample, text = None, ""
        for number, line in enumerate(lines, start=first):
            begins = re.match(rf"(\$ )?({'|'.join(programs)}) ", line)
            if text or begins:
                text = (text or "") + line.removeprefix("$ ").removesuffix("\\")
                if line.endswith("\\"):
                    continue
                sample = Sample(shlex.split(text, comments=True), [], number)
                samples.append(sample)
                text = ""
            elif sample and line:
                sample.output.append(line)
    return samples


def block_after(markdown, words):
    """The first block of code after these words, up to a command in it."""
    place = markdown.index(words)
    skipped = markdown[:place].count("\n") + 1
    _, lines = next(block for block in code(markdown) if block[0] > skipped)
    return "\n".join(itertools.takewhile(lambda line: not line.startswith("$ "), lines)) + "\n"


def shown_in(expected, output):
    """The first line that a guide shows and the output does not have behind those before; None if it has all of them.
    `...` stands for anything."""
    lines = output.splitlines()
    for line in expected:
        pattern = ".*".join(re.escape(part.rstrip()) for part in line.split("..."))
        while lines and not re.fullmatch(rf"\s*{pattern.strip()}\s*", lines[0]):
            lines.pop(0)
        if not lines and line.strip() != "...":
            return line
    return None
