"""The samples that the guides print: commands, programs and files, with what they show of the output.

A block of code in a guide is one of these:

- commands: its first line begins with `$ ` or with a program of `PROGRAMS`. Behind `$ ` stands a command, and the lines
  behind that are its output, `...` standing for anything;
- a program in Python;
- a sample of what a comment in front of it says, which no reader sees:

| comment | what it says |
|---|---|
| `<!-- not run: WHY -->` | not run here, and why |
| `<!-- file NAME -->` | the block is this file of the reader's |
| `<!-- add to NAME -->` | the block is a part of this file, behind what is in it |
| `<!-- from PATH -->` | the block stands so in this file of the repository |
| `<!-- shows: COMMAND -->` | the block is output of this command |
| `<!-- output -->` | the block is output of the command before |

- neither: it has the language `text`, or that of a drawing.

More comments prepare what a reader has by then: `<!-- file NAME`, with the lines of the file up to the `-->`;
`<!-- run: COMMAND -->`; `<!-- before`, with Python that stands in front of the next block. `<!-- none run: WHY -->` leaves out
all blocks of a guide.
"""

import pathlib
import re
from collections import namedtuple

import markdown_it

ROOT = pathlib.Path(__file__).parents[1]

PROGRAMS = ("cargo", "cc", "dask", "fmpy", "git", "helm", "pip", "plcfmu", "python", "sbatch", "target/venv/bin/python")

# What is no sample: drawings, formulas, and the rows of a block's table.
DRAWN = {"diagram", "dialog", "math", "text"}

Step = namedtuple("Step", "line kind name text output")
"""What the runner does: the line in the guide; `command`, `python`, `file`, `add`, `from`, `left out` or `unknown`; the name
of a file, or why it is left out; the text of the command, program or file; and the lines shown of the output."""


def steps(markdown):
    """What a runner does for the samples of a guide, in their order."""
    found, marks, before = [], {}, ""
    for token in markdown_it.MarkdownIt("commonmark").parse(markdown):
        line = token.map[0] + 1 if token.map else 0
        if token.type == "html_block":
            for comment in re.findall(r"<!--\s*(.*?)\s*-->", token.content, re.DOTALL):
                head, _, body = comment.partition("\n")
                kind, _, rest = re.match(r"(not run:|none run:|file|add to|from|shows:|output|run:|before)?( ?)(.*)", head).groups("")
                if kind == "before":
                    before = body + "\n"
                elif kind == "run:":
                    found.append(Step(line, "command", "", comment.removeprefix("run: "), []))
                elif kind in ("file", "add to") and body:
                    found.append(Step(line, kind.split()[0], rest, body + "\n", []))
                elif kind:
                    marks[kind] = rest
        elif token.type in ("fence", "code_block"):
            if "output" in marks:
                found[-1].output.extend(filter(None, token.content.splitlines()))
            else:
                found += of_block(line, token.info, token.content, marks, before)
            marks, before = {why: marks[why] for why in marks if why == "none run:"}, ""
    return found


def of_block(line, language, text, marks, before):
    """The steps of a block of code."""
    lines = text.splitlines()
    for mark in ("not run:", "none run:"):
        if mark in marks:
            return [Step(line, "left out", marks[mark], text, [])]
    if "shows:" in marks:
        return [Step(line, "command", "", marks["shows:"], [one for one in lines if one])]
    for mark in ("file", "add to", "from"):
        if mark in marks:
            return [Step(line, mark.split()[0], marks[mark], text, [])]
    if language == "python":
        return [Step(line, "python", "", before + text, [])]
    if lines[0].startswith("$ ") or lines[0].split()[0] in PROGRAMS:
        return commands(line, lines)
    return [] if language in DRAWN else [Step(line, "unknown", "", text, [])]


def commands(first, lines):
    """The commands of a block. A line that ends with a backslash goes on."""
    found, prompts = [], lines[0].startswith("$ ")
    goes_on = False
    for number, line in enumerate(lines, start=first):
        if goes_on:
            found[-1] = found[-1]._replace(text=f"{found[-1].text}\n{line}")
        elif line.startswith("$ ") or (line and not prompts):
            found.append(Step(number, "command", "", line.removeprefix("$ "), []))
        elif line:
            found[-1].output.append(line)
        goes_on = line.endswith("\\") and (goes_on or not found[-1].output)
    return found


def missing(shown, output):
    """The first line that a guide shows and the output does not have behind those before; None if it has all of them.
    `...` stands for anything."""
    lines = output.splitlines()
    for line in shown:
        pattern = ".*".join(re.escape(part.strip()) for part in line.split("..."))
        while lines and not re.fullmatch(rf"\s*{pattern}\s*", lines[0]):
            lines.pop(0)
        if line.strip() != "..." and not lines:
            return line
        lines = lines[1:] if line.strip() != "..." else lines
    return None
