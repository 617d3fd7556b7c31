"""What a recording's file is called, for those who look for one without writing any."""

from __future__ import annotations

from typing import Final

PREFIX: Final = "clearway_"
SUFFIX: Final = ".mcap"
