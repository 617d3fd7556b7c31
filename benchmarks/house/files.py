"""A page that names every source file with the first sentence of its docstring.

The sentence is written once, at the head of the file that it is about, so that the page cannot
say something else. Folders come in the order of their names, their own sentence above the table.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import PurePosixPath

from benchmarks.house.tree import File

HEAD = """# Every source file

What each file of the four packages is for, in the first sentence of its own docstring.
[How they work together](architecture.md).
"""


def page(files: Sequence[File]) -> str:
    """The whole page in Markdown: a section a folder, a row a file."""
    parts = [HEAD]
    for package, own in groupby(files, key=lambda file: file.package):
        parts.append(f"## {package}\n")
        folders = sorted(own, key=lambda file: (file.path.parent, file.path.name))
        for folder, inside in groupby(folders, key=lambda file: file.path.parent):
            parts += section(folder, list(inside))
    return "\n".join(parts).rstrip("\n") + "\n"


def section(folder: PurePosixPath, files: Sequence[File]) -> Iterable[str]:
    purpose = next((sentence(file) for file in files if file.is_init), "")
    rows = [
        f"| [`{file.path.name}`](../{file.path}) | {sentence(file).replace('|', chr(92) + '|')} |"
        for file in files
        if not file.is_init
    ]
    if len(folder.parts) > 1:
        yield f"### {folder}\n"
    if purpose:
        yield f"{purpose}\n"
    if rows:
        yield "\n".join(["| file | what it does |", "|---|---|", *rows]) + "\n"


def sentence(file: File) -> str:
    """The first sentence of a file's docstring, on one line; empty where there is none."""
    paragraph = (ast.get_docstring(file.tree) or "").partition("\n\n")[0]
    line = re.sub(r"``?", "`", " ".join(paragraph.split()))
    found = re.match(r".*?[.:](?= [A-Z(`]|$)", line)
    return (found.group() if found else line).rstrip(".:")
