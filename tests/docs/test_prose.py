"""Docstrings say what a thing is or does, a folder's what happens in it; names are unique and true.

The rules are those of ``docs/style.md``; the four packages are read as text, nothing is imported.
"""

import ast
import functools
import os
import re
from collections.abc import Iterator
from itertools import pairwise
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

SUFFIXES = (".py", ".c", ".h", ".md", ".yaml", ".js", ".css", ".html")
"""Endings of the file names that prose cites."""
IN_FRONT = re.compile(r"[\w./-]*\w$")
LONGEST = 100
"""Characters of the longest path, to look back."""
SPOKEN = {
    ".py": re.compile(r'"""(.*?)"""|(?<=\s)#\s([^\n]*)', re.DOTALL),
    ".js": re.compile(r"//([^\n]*)|/\*(.*?)\*/", re.DOTALL),
    ".css": re.compile(r"/\*()(.*?)\*/", re.DOTALL),
    ".html": re.compile(r"<!--()(.*?)-->", re.DOTALL),
}
"""What a source says: docstrings, those of constants included, and comments."""
PLACEHOLDER = re.compile(r"(.*/)?[A-Z]+\.\w+")
"""As in ``configs/NAME.yaml``."""
USERS_OWN = {
    *("arena.yaml", "real.yaml", "x.yaml", "broken.yaml", "clearway.yaml"),
    *("calibration.yaml", "lens.yaml", "left.yaml", "right.yaml"),
    *("map.yaml", "depot.yaml", "depot_keepout.yaml", "roadmap.yaml"),
    *("keepout.yaml", "speed.yaml", "slow.yaml", "zone.yaml", "my_robot.h"),
}
"""What the reader has or makes: configurations, calibrations, maps, masks, a robot's header."""
OF_OTHERS = {
    *("linux/videodev2.h", "linux/v4l2-controls.h", "v4l_id.c"),
    *("Wire.h", "usbredirproto.h"),
}
"""Sources that ours cite: of the kernel and systemd, of Arduino and QEMU."""
SERVED = {"palette.css"}
"""Made by the program when it is asked for."""
MADE_ON_DEMAND = "benchmarks/results/"
"""Folder of the tables that benchmarks write; not all are committed."""


@functools.cache
def _sources(package: str) -> list[tuple[Path, ast.Module]]:
    files = sorted((ROOT / package).rglob("*.py"))
    return [(file, ast.parse(file.read_text(encoding="utf-8"))) for file in files]


def _docstrings(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Each docstring of a file and each text below a constant or a field, with the owner's name."""
    open_ends: list[ast.AST] = [tree]
    while open_ends:
        node = open_ends.pop()
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "name", THE_FILE), text
            for before, after in pairwise(node.body):
                match after:
                    case ast.Expr(ast.Constant(str(text))) if not isinstance(before, ast.Expr):
                        yield ast.unparse(before).split("\n")[0], text
        for block in ("body", "orelse", "finalbody", "handlers", "cases"):
            inner = getattr(node, block, None)
            if isinstance(inner, list):
                open_ends += inner


@functools.cache
def _prose() -> list[tuple[Path, str]]:
    """Every document and every source of the packages and of the page, with its text."""
    return list(_read_prose())


def _read_prose() -> Iterator[tuple[Path, str]]:
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


def _files() -> str:
    """Paths of the repository's files, each after a slash and on a line of its own."""
    found = list[str]()
    for folder, inner, names in os.walk(ROOT):
        at = folder[len(str(ROOT)) :]
        inner[:] = [name for name in inner if name[0] not in "._" and (at or name != "build")]
        found += [f"{at}/{name}\n" for name in names]
    return "".join(found)


def _cited(text: str) -> Iterator[str]:
    """File names in a text, without the dots of relative links; those of other sites are not."""
    for suffix in SUFFIXES:
        for ending in re.finditer(rf"{re.escape(suffix)}\b(?![\w(])", text):
            at = ending.start()
            front = IN_FRONT.search(text[max(at - LONGEST, 0) : at])
            if front and text[max(at - LONGEST, 0) : at][: front.start()][-1:] not in (
                "*",
                ":",
                "$",
            ):
                yield re.sub(r"^(\.{0,2}/)+", "", front.group()) + suffix


def _beside_the_packages() -> Iterator[tuple[Path, str]]:
    results = (ROOT / "benchmarks" / "results").glob("*.md")
    yield from ((file, file.read_text("utf-8")) for file in results)
    for folder in ("benchmarks", "examples", "tests"):
        yield from ((file, file.read_text("utf-8")) for file in (ROOT / folder).rglob("*.py"))


def _said(file: Path, text: str) -> str:
    """Docstrings and comments of a source; of a test its docstrings, as strings have others."""
    if file.suffix not in SPOKEN:
        return text
    if file.is_relative_to(ROOT / "tests"):
        return "\n".join(said for _, said in _docstrings(ast.parse(text)))
    return "\n".join(group for pair in SPOKEN[file.suffix].findall(text) for group in pair)


def test_every_file_that_prose_names_is_there() -> None:
    """In docstrings, comments, documents and the page, and in docstrings of tests."""
    there = _files()

    def is_there(name: str) -> bool:
        if f"/{name}\n" in there or name in USERS_OWN | OF_OTHERS | SERVED:
            return True
        return name.startswith(MADE_ON_DEMAND) or PLACEHOLDER.fullmatch(name) is not None

    missing = list[str]()
    for file, text in [*_prose(), *_beside_the_packages()]:
        lacking = {n for n in _cited(text) if not is_there(n)}
        if lacking:
            lacking &= set(_cited(_said(file, text)))
        missing += [f"{file.relative_to(ROOT)}: {name}" for name in sorted(lacking)]
    assert not missing, "\n".join(missing)
