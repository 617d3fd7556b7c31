"""A configuration broken on purpose."""

from __future__ import annotations

from pathlib import Path


def break_file(file: Path) -> None:
    file.write_text(file.read_text().replace("speed_m_s: 0.3", "speed_m_s: fast"))
