"""Tests, benchmarks, commands and options that texts name exist; tests select something."""

import ast
import importlib.util
import re
import shlex
from pathlib import Path

import click
import pytest

from navigation.cli.main import clearway

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if "pictures" not in page.parts),
    *sorted((ROOT / "benchmarks/results").glob("*.md")),
]
FENCE = re.compile(r"```[^\n]*\n(.*?)```", re.DOTALL)
COMMAND = re.compile(r"(?<![./\w-])clearway ([a-z][a-z-]*)((?: (?!clearway\b)[^`|;&#\n]*)?)")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
WORD = re.compile(r"\b(?!and\b|or\b|not\b)\w+")


def _named(page: Path, first: str) -> list[str]:
    """What the page sets in code and begins so, on one line."""
    text = page.read_text(encoding="utf-8")
    return sorted(set(re.findall(rf"`({re.escape(first)}[^`\n]*)`", text)))


def _names_in(place: Path) -> list[str]:
    """What tests are selected by in a file or folder: functions, for cases are named by some."""
    files = [place] if place.is_file() else sorted(place.rglob("test_*.py"))
    return [
        f"{file.name}::{node.name}"
        for file in files
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_tests_that_a_page_names_are_there(page: Path) -> None:
    for command in _named(page, "pytest tests"):
        words = shlex.split(command)
        assert words.count("-k") <= 1, f"{command}: pytest takes the last -k only"
        wanted = words[words.index("-k") + 1] if "-k" in words else ""
        places = [ROOT / word for word in words[1:] if word.startswith("tests")]
        names = list[str]()
        for place in places:
            assert place.exists(), f"{command}: no {place.relative_to(ROOT)}"
            names += _names_in(place)
        assert any("::test_" in name for name in names), f"{command}: no test there"
        for word in WORD.findall(wanted):
            assert any(word in name for name in names), f"{command}: no test is named {word}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_benchmarks_that_a_page_names_are_there(page: Path) -> None:
    for command in _named(page, "python -m benchmarks"):
        module = command.split()[2].rstrip(".,")
        assert importlib.util.find_spec(module) is not None, f"{command}: no such module"


def test_each_promise_stands_once() -> None:
    rows = [
        line.split("|")[1].strip()
        for line in (ROOT / "docs/safety.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| ")
    ]
    promises = [row for row in rows if row != "promise"]
    assert len(promises) > 50
    twice = {row for row in promises if promises.count(row) > 1}
    assert not twice


def _code_in(text: str) -> list[str]:
    """Code between single backticks, and the lines of fenced blocks."""
    blocks = [block.replace("\\\n", " ") for block in FENCE.findall(text)]
    spans = re.findall(r"`([^`\n]+)`", FENCE.sub("", text))
    return [*spans, *(line for block in blocks for line in block.splitlines())]


def _options_of(name: str, words: list[str]) -> set[str]:
    """Options of a command, or of the command of its group that the first word names."""
    with click.Context(clearway) as context:
        command = clearway.get_command(context, name)
        assert command is not None, f"clearway {name}: no such command"
        if isinstance(command, click.Group) and words:
            command = command.get_command(context, words[0]) or command
    return {"--help"}.union(*([*one.opts, *one.secondary_opts] for one in command.params))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_commands_and_options_that_a_page_names_are_there(page: Path) -> None:
    for code in _code_in(page.read_text(encoding="utf-8")):
        for name, rest in COMMAND.findall(code):
            unknown = set(OPTION.findall(rest)) - _options_of(name, rest.split())
            assert not unknown, f"{code}: {unknown}"
