"""Docstrings say what a thing is or does, a folder's what happens in it; class names are unique.

The rules are those of ``docs/style.md``; the four packages are read as text, nothing is imported.
"""

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ["clearway", "firmware_protocol", "navigation", "planner", "vision"]
OPENING = re.compile(r"(What|Who|Whether|How|Where|As|Of)\b")

WORDS = re.compile(
    r"\b(anew|mend(s|ed|ing)?|[Ss]o many|[Ss]o long(?! as)|goes on|go on|went on|[Ww]hoever|"
    r"of before|of late|what is wanted)\b"
)
"""Words of the table in ``docs/style.md`` that have no other use in this project."""
STYLE_PAGE = ROOT / "docs" / "style.md"

FOLDER_LINES_MIN = 2
BOARDS = ROOT / "firmware_protocol" / "robot" / "boards"
"""Each of its files defines ``Board``: one of them is copied to the robot as ``board.py``."""
THE_FILE = "the file"


@functools.cache
def _sources(package: str) -> list[tuple[Path, ast.Module]]:
    files = sorted((ROOT / package).rglob("*.py"))
    return [(file, ast.parse(file.read_text(encoding="utf-8"))) for file in files]


def _docstrings(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Each docstring of a file, with its owner's name; statements are searched, not expressions."""
    open_ends: list[ast.AST] = [tree]
    while open_ends:
        node = open_ends.pop()
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "name", THE_FILE), text
        for block in ("body", "orelse", "finalbody", "handlers", "cases"):
            inner = getattr(node, block, None)
            if isinstance(inner, list):
                open_ends += inner


def _prose() -> Iterator[tuple[Path, str]]:
    """Every document and every source of the packages and of the page, with its text."""
    yield from ((file, file.read_text("utf-8")) for file in ROOT.glob("*.md"))
    yield from ((file, file.read_text("utf-8")) for file in (ROOT / "docs").rglob("*.md"))
    for package in PACKAGES:
        for suffix in ("py", "js", "html", "css"):
            for file in (ROOT / package).rglob(f"*.{suffix}"):
                yield file, file.read_text("utf-8")


def _wrong(package: str) -> list[str]:
    """Docstrings that open wrongly, or that say in one line what a folder does."""
    found = list[str]()
    for file, tree in _sources(package):
        for name, text in _docstrings(tree):
            short = file.name == "__init__.py" and name == THE_FILE and tree.body
            if OPENING.match(text) or (short and len(text.splitlines()) < FOLDER_LINES_MIN):
                found.append(f"{file.relative_to(ROOT)}: {name}: {text.splitlines()[0]}")
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_open_with_a_noun_phrase_or_an_imperative(package: str) -> None:
    wrong = _wrong(package)
    assert not wrong, "\n".join(wrong)


def test_a_public_class_name_stands_for_one_class() -> None:
    places: dict[str, list[str]] = {}
    for package in PACKAGES:
        for file, tree in _sources(package):
            for node in tree.body:
                if isinstance(node, ast.ClassDef) and file.parent != BOARDS:
                    places.setdefault(node.name, []).append(str(file.relative_to(ROOT)))
    twice = {name: files for name, files in places.items() if len(files) > 1 and name[0] != "_"}
    assert not twice


def test_no_text_has_a_word_that_the_style_page_replaces() -> None:
    found = [
        f"{file.relative_to(ROOT)}: {match.group()}"
        for file, text in _prose()
        if file != STYLE_PAGE
        for match in WORDS.finditer(text)
    ]
    assert not found, "\n".join(found)
