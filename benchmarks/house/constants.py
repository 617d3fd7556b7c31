"""Named numbers, and what their sources are: derived, measured, chosen, defined or indifferent.

A named number is a constant in capitals of a module with a number in its value. Its source is the
first of these words, before a comma, colon or full stop, in its docstring or a comment above it.
What is derived or defined (a kind, an index, a type, a promise) is no tuned number, and neither is
one of which half and double change nothing (indifferent: ``benchmarks.vision.constants`` fails
where that is not so, and ``benchmarks.vision.binarisation --numbers`` shows it); everything else
is, and what has no source too.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from benchmarks.house.tree import File

NAME = re.compile(r"_?[A-Z][A-Z0-9_]*")
SOURCE = re.compile(r"\b(derived|measured|chosen|defined|indifferent)\b[:,.;)]", re.IGNORECASE)
"""With what follows: not "is measured across"."""
UNTUNED = ("derived", "defined", "indifferent")


@dataclass(frozen=True, slots=True)
class NamedNumber:
    """Where a named number is, and the word for its source; empty without one."""

    place: str
    name: str
    source: str

    @property
    def tuned(self) -> bool:
        return self.source not in UNTUNED

    def __str__(self) -> str:
        return f"{self.place}: {self.name} ({self.source or 'no source'})"


def named_numbers(files: Iterable[File]) -> Iterator[NamedNumber]:
    """Every name once, in the files' order."""
    for file in files:
        lines = file.text.splitlines()
        body = [*file.tree.body, None]
        for node, after in pairwise(body):
            names = names_of(node)
            if not names:
                continue
            assert isinstance(node, ast.Assign | ast.AnnAssign)
            assert node.end_lineno is not None
            said = [docstring(after), *lines[node.lineno - 1 : node.end_lineno]]
            above = node.lineno - 2
            while above >= 0 and lines[above].startswith("#"):
                said.append(lines[above])
                above -= 1
            found = SOURCE.search("\n".join(said))
            for name in names:
                place = f"{file.path}:{node.lineno}"
                yield NamedNumber(place, name, found[1].lower() if found else "")


def names_of(node: ast.stmt | None) -> list[str]:
    """The names that a statement gives to numbers; none for anything else."""
    if isinstance(node, ast.Assign):
        target: ast.expr = node.targets[0]
    elif isinstance(node, ast.AnnAssign) and node.value is not None:
        target = node.target
    else:
        return []
    parts = target.elts if isinstance(target, ast.Tuple) else [target]
    names = [part.id for part in parts if isinstance(part, ast.Name)]
    if len(names) != len(parts) or not all(NAME.fullmatch(name) for name in names):
        return []
    assert node.value is not None
    numbers = (
        type(part.value) in (int, float)
        for part in ast.walk(node.value)
        if isinstance(part, ast.Constant)
    )
    return names if any(numbers) else []


def docstring(node: ast.stmt | None) -> str:
    """The text of a statement that is nothing but text."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return node.value.value if isinstance(node.value.value, str) else ""
    return ""
