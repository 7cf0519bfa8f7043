"""Files as tests compare them: the rows of a CSV, and what a folder holds."""

import csv
import pathlib


def rows(table):
    """The rows of a CSV, texts by column: of a file, or of its text. Lines that begin with # are comments."""
    text = table.read_text(encoding="utf-8") if isinstance(table, pathlib.Path) else table
    return list(csv.DictReader(line for line in text.splitlines(keepends=True) if not line.startswith("#")))


def contents(folder):
    """All files of a folder with their bytes."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
