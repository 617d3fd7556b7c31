"""Docstrings open with what a thing is or does, and a folder's says what happens in it.

The rules are those of ``docs/style.md``; the four packages are read as text, nothing is imported.
"""

import ast
import functools
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ["clearway", "firmware_protocol", "navigation", "planner", "vision"]
OPENING = re.compile(r"(What|Who|Whether|How|Where|As|Of)\b")

FOLDER_LINES_MIN = 2
THE_FILE = "the file"

# folders whose docstrings are still to be written again; one that has been leaves the list
PENDING = {
    "vision/binarise",
    "vision/camera",
}


@functools.cache
def _sources(package: str) -> list[tuple[Path, ast.Module]]:
    files = sorted((ROOT / package).rglob("*.py"))
    return [(file, ast.parse(file.read_text(encoding="utf-8"))) for file in files]


def _docstrings(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Each docstring of a file, with its owner's name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "name", THE_FILE), text


def _folder(file: Path) -> str:
    """The package and its folder: ``planner/route``."""
    return "/".join(file.relative_to(ROOT).parent.parts[:2])


def _wrong(package: str) -> dict[str, list[str]]:
    """Docstrings by folder that open wrongly, or that say in one line what a folder does."""
    found = defaultdict[str, list[str]](list)
    for file, tree in _sources(package):
        for name, text in _docstrings(tree):
            short = file.name == "__init__.py" and name == THE_FILE and tree.body
            if OPENING.match(text) or (short and len(text.splitlines()) < FOLDER_LINES_MIN):
                line = f"{file.relative_to(ROOT)}: {name}: {text.splitlines()[0]}"
                found[_folder(file)].append(line)
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_open_with_a_noun_phrase_or_an_imperative(package: str) -> None:
    wrong = [
        line for folder, lines in _wrong(package).items() if folder not in PENDING for line in lines
    ]
    assert not wrong, "\n".join(wrong)


def test_a_folder_leaves_the_list_when_nothing_in_it_is_wrong() -> None:
    wrong = {folder for package in PACKAGES for folder in _wrong(package)}
    assert wrong >= PENDING, f"to be taken off the list: {sorted(PENDING - wrong)}"
