"""The Python files of some folders, read once."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

PACKAGES = ("clearway", "vision", "planner", "navigation", "firmware_protocol")
"""What is shipped."""
ALL = (*PACKAGES, "tests", "benchmarks")

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True, slots=True)
class File:
    """A Python file: its path from the root, its text and what the text means."""

    path: PurePosixPath
    text: str
    tree: ast.Module

    @property
    def module(self) -> str:
        """Its dotted name; of an ``__init__.py`` that of its folder."""
        parts = self.path.with_suffix("").parts
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    @property
    def is_init(self) -> bool:
        return self.path.name == "__init__.py"

    @property
    def lines(self) -> int:
        return len(self.text.splitlines())

    @property
    def package(self) -> str:
        return self.path.parts[0]

    def functions(self) -> Iterator[Function]:
        """Every function and method, those within others too."""
        for node in ast.walk(self.tree):
            if isinstance(node, Function):
                yield node


def read(root: Path, folders: Iterable[str] = ALL) -> list[File]:
    """Every ``*.py`` below the folders, in the order of the paths."""
    found = []
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            inside = PurePosixPath(path.relative_to(root).as_posix())
            if any(part.startswith(".") or part == "__pycache__" for part in inside.parts):
                continue
            text = path.read_text(encoding="utf-8")
            found.append(File(inside, text, ast.parse(text, filename=str(path))))
    return found
