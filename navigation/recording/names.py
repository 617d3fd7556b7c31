"""File names of recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Final

PREFIX: Final = "clearway_"
SUFFIX: Final = ".mcap"


def place_of(asked: Path | None, usual: Path) -> tuple[Path, str | None]:
    """Folder of recordings, and the name of the only file in it, if ``asked`` is FILE.mcap."""
    if asked is not None and asked.suffix.lower() == SUFFIX:
        return asked.parent, asked.name
    return asked or usual, None
