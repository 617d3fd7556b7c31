"""File names of recordings, for programs that look for one without writing any."""

from __future__ import annotations

from typing import Final

PREFIX: Final = "clearway_"
SUFFIX: Final = ".mcap"
