"""Stamp of a compiled kernel's dependencies: its file and all of ours that it imports.

Numba checks only the kernel's own file: after a change in a kernel that it calls, or in an imported
constant, it would load the old machine code. This stamp covers every file that imports reach.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

_IMPORT = re.compile(rb"^\s*(?:from|import) ([a-z_][\w.]*)(?: import ([^#\n(]+|\([^)]*\)))?", re.M)


def stamp_of(
    file: Path, packages: tuple[str, ...], versions: str, apart: Path | None = None
) -> str:
    """Hex digest of a source file, all its imports from some packages, and versions.

    ``file`` is inside a package; the others are beside it. Other packages there are not followed,
    and the folder ``apart`` does not count.
    """
    root = file.parent
    while (root / "__init__.py").exists():
        root = root.parent
    digest = hashlib.sha256(versions.encode())
    for part in sorted(_reachable(file, root, packages)):
        if apart is not None and part.is_relative_to(apart):
            continue
        digest.update(part.relative_to(root).as_posix().encode())
        digest.update(_content(part)[0])
    return digest.hexdigest()


@cache
def _content(file: Path) -> tuple[bytes, tuple[tuple[str, ...], ...]]:
    """Digest of a file, and the dotted names that it may import, in parts."""
    source = file.read_bytes()
    names = []
    for module, members in _IMPORT.findall(source):
        parts = tuple(module.decode().split("."))
        names.append(parts)
        names += [(*parts, member) for member in re.findall(r"\w+", members.decode())]
    return hashlib.sha256(source).digest(), tuple(names)


def _reachable(file: Path, root: Path, packages: tuple[str, ...]) -> set[Path]:
    found = {file}
    waiting = [file]
    while waiting:
        for parts in _content(waiting.pop())[1]:
            imported = _file_of(root, parts) if parts[0] in packages else None
            if imported is not None and imported not in found:
                found.add(imported)
                waiting.append(imported)
    return found


@cache
def _file_of(root: Path, parts: tuple[str, ...]) -> Path | None:
    """Source of a module or package below ``root``; None for any other name."""
    place = root.joinpath(*parts)
    for candidate in (place.with_suffix(".py"), place / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None
