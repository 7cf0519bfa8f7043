"""The tapes of the blocks: `clauses.txt` in the folder of each, one case for each clause of its documentation.

blocks/README.md says how to read one. A run is played call by call: on the law by blocks/tests/tapes.rs, on the FMU and on
the second version of the law by test_tapes.py.
"""

import dataclasses
import itertools
import pathlib
import re

from host import real

FILES = sorted((pathlib.Path(__file__).parents[1] / "blocks" / "src").glob("*/*/clauses.txt"))

ANYTHING = object()


@dataclasses.dataclass(frozen=True)
class Nearly:
    """A number that may be off by 1 part in 10 000, or by 0.0001 if that is more."""

    number: float


@dataclasses.dataclass
class Run:
    """What is set before the restart and before later calls, and what the block answers: values call by call by name. A
    TIME is in seconds, a BOOL 0 or 1."""

    block: str
    title: str
    settings: dict
    answers: dict

    def __str__(self):
        return f"{self.block}: {self.title}"

    def calls(self):
        """Of each call what is set before it and what is looked at after it."""
        count = max(map(len, (*self.settings.values(), *self.answers.values())))
        for call in range(count):
            yield at(self.settings, call), {
                name: value for name, value in at(self.answers, call).items() if value is not ANYTHING
            }


def at(sequences, call):
    return {name: values[call] for name, values in sequences.items() if call < len(values)}


def all_runs():
    """All but those of the documentation, whose settings stand in the Rust table alone."""
    every = [run for file in FILES for run in runs(file.parent.name.upper(), file.read_text(encoding="utf-8"))]
    return [run for run in every if not run.title.startswith(("Response ", "Characteristic "))]


def runs(block, text):
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    common = {}
    for case in filter(None, map(str.strip, "\n".join(lines).split("\n\n"))):
        title, *body = case.splitlines()
        settings = [one.split("=") for line in body if "->" not in line for one in line.split(",")]
        answers = [line.split("->") for line in body if "->" in line]
        count = max([len(values.split("|")) for _, values in settings], default=1)
        for variant in range(count):
            own, told = ({k: v for side in sides for k, v in sequences(*side, variant)} for sides in (settings, answers))
            if told:
                yield Run(block, f"{title} [{variant + 1}]" if count > 1 else title, {**common, **own}, told)
            else:
                common = own


def sequences(names, values, variant):
    """The sequence of a name, or of two with a slash between them: `+` is TRUE of the first, `-` of the second."""
    names = names.strip().split("/")
    variants = values.split("|")
    tokens = variants[variant if len(variants) > 1 else 0].split()
    for name, sign in zip(names, "+-"):
        yield name, list(itertools.chain.from_iterable(repeated(token, sign) for token in tokens))


def repeated(token, sign):
    """`0.5*3` is 0.5 in three calls, `+.*3` is TRUE and FALSE three times."""
    token, _, count = token.partition("*")
    if re.fullmatch(r"[+.-]+", token):
        values = [int(letter == sign) for letter in token]
    else:
        values = [value(token)]
    return values * int(count or 1)


def value(token):
    if token == "_":
        return ANYTHING
    if token in ("TRUE", "FALSE"):
        return int(token == "TRUE")
    if token.startswith("~"):
        return Nearly(float(token[1:]))
    if token.endswith("ms"):
        return float(token[:-2]) / 1000
    return float(token.removesuffix("s"))


def is_right(told, expected, kind):
    if isinstance(expected, Nearly):
        return abs(told - expected.number) <= 1e-4 * max(1.0, abs(expected.number))
    return told == (real(expected) if kind == "REAL" else expected)
