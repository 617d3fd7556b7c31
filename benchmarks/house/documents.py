"""Which source files a document names."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath

from benchmarks.house.tree import File


def texts(root: Path) -> str:
    """README, CONTRIBUTING and every Markdown file below docs, one after the other."""
    files = [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]
    return "\n".join(file.read_text(encoding="utf-8") for file in files if file.exists())


def unnamed(files: Sequence[File], text: str) -> list[str]:
    """Files of which no document holds the dotted name or an end of the path.

    The end has to be long enough that no other file shares it: where ten folders have a
    ``state.py``, ``mission/state.py`` names one of them. An ``__init__.py`` is not asked for.
    """
    shared = Counter(end for file in files for end in ends(file.path))
    words = set(re.findall(r"[\w/]+\.py\b|[\w.]+", text.replace("../", "")))
    return [
        str(file.path)
        for file in files
        if not file.is_init
        and file.module not in words
        and not any(end in words for end in ends(file.path) if shared[end] == 1)
    ]


def ends(path: PurePosixPath) -> Iterable[str]:
    """``c.py``, ``b/c.py``, ``a/b/c.py``."""
    parts = path.parts
    return ("/".join(parts[i:]) for i in range(len(parts)))
