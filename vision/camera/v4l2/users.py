"""Other programs that have a device open, by their lists of open files.

Without root, only the user's own processes are seen.
"""

from __future__ import annotations

import os
from pathlib import Path


def users_of(path: str, proc: Path = Path("/proc"), own: int | None = None) -> list[str]:
    """Other programs that have a device open: ``firefox (process 1234)``."""
    own = os.getpid() if own is None else own
    device = os.path.realpath(path)
    found = []
    for folder in sorted(proc.glob("[0-9]*"), key=lambda each: int(each.name)):
        if int(folder.name) != own and _has_open(folder, device):
            found.append(f"{_name(folder)} (process {folder.name})")
    return found


def who_uses(path: str) -> str:
    """The same in words, for a message."""
    found = users_of(path)
    if found:
        return f"{' and '.join(found)} {'uses' if len(found) == 1 else 'use'} it"
    return "another program uses it"


def _has_open(folder: Path, device: str) -> bool:
    try:
        return any(os.readlink(each) == device for each in (folder / "fd").iterdir())
    except OSError:
        return False


def _name(folder: Path) -> str:
    try:
        return (folder / "comm").read_text(errors="replace").strip()
    except OSError:
        return "a program"
