"""The page "What was tested": the promises in tests/README.md, with the results of their tests on each system."""

import json
import re

HEAD = """The promises of this project, each with its tests and their results: how many passed, and how many were skipped because a tool was
missing. `cargo xtask test` writes the results for the system on which it runs, `.ci/platforms` those for emulated systems, and
`cargo xtask docs` builds this page from them. To repeat the tests in a row: `cargo xtask test -- -k MODULE`. Rust tests are not counted
here: `cargo xtask test` runs them first, and stops at the first failure.
"""
MODULE = re.compile(r"`(test_\w+\.py)`")


def page(tests_readme, folder):
    """The page in Markdown, or None if there are no results."""
    found = [json.loads(path.read_text("utf-8")) for path in sorted(folder.glob("*.json"))]
    if not found:
        return None
    systems = [result["system"] for result in found]
    lines = [HEAD, "## Systems\n", *(f"- {system}: {total(result)}" for system, result in zip(systems, found)), ""]
    promises = tests_readme.split("## The map: promise and test\n")[1].split("\n## ")[0]
    # Skip the header of the table and the line below it.
    rows = [line[1:-1].split("|", 1) for line in promises.splitlines() if line.startswith("|")][2:]
    for promise, tests in ([cell.strip() for cell in row] for row in rows):
        if not tests:
            names = " | ".join(system.split(":")[0] for system in systems)
            lines += [f"\n## {promise.strip('*')}\n", f"| promise | tests | {names} |", f"|---|---|{'---|' * len(systems)}"]
        else:
            modules = MODULE.findall(tests)
            lines.append(f"| {promise} | {tests} | {' | '.join(said(modules, result) for result in found)} |")
    return "\n".join(lines).replace("](#", "](README.md#")


def said(modules, result):
    """The results of a promise's tests on a system."""
    counts = [result["modules"][module] for module in dict.fromkeys(modules) if module in result["modules"]]
    return in_words(counts) if counts else ""


def total(result):
    return in_words(result["modules"].values())


def in_words(counts):
    words = ("failed", "passed", "skipped")
    sums = [sum(count.get(word, 0) for count in counts) for word in words]
    return ", ".join(f"{number:,} {word}" for number, word in zip(sums, words) if number)
