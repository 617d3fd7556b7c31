"""The last good configuration: kept beside the program's state whenever one was fit to run.

- It is never used silently: a broken file is an error that says where the last good one is, and
  `clearway run --last-good` runs it.
- Only the file's text is kept; the files that it names stay where they are.
- If the state folder cannot be written, the roll-back is lost, not the run.
"""

from __future__ import annotations

import difflib
import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from navigation.config.errors import ConfigError
from navigation.config.load import parse_config, read_source
from navigation.config.secrecy.secret_places import masked
from navigation.config.sections import Config
from navigation.config.unknown_keys import values_of_unknown_keys
from navigation.shared.whole_file import UnwrittenFileError, write_whole

FOLDER: Final = "last_good"
MOST_LINES: Final = 12


def state_folder(environment: Mapping[str, str]) -> Path:
    """Folder for data that outlives a run: systemd's, XDG's, or the home's."""
    if service := environment.get("STATE_DIRECTORY"):
        return Path(service.split(":")[0])
    if xdg := environment.get("XDG_STATE_HOME"):
        return Path(xdg) / "clearway"
    return Path(environment.get("HOME") or "/") / ".local" / "state" / "clearway"


class LastGood:
    """The kept copy of one configuration file."""

    def __init__(self, file: Path, state: Path) -> None:
        self.file = file.absolute()
        number = hashlib.sha256(os.fsencode(self.file)).hexdigest()[:8]
        self.kept = state / FOLDER / f"{self.file.stem}-{number}.yaml"

    def keep(self, text: str) -> str | None:
        """Keep a good text; return the reason if that fails."""
        try:
            if self.kept.exists() and self.kept.read_text(encoding="utf-8") == text:
                return None
            self.kept.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            write_whole(self.kept, text, private=True)
        except OSError as error:
            return f"{self.kept}: {error.strerror or error}"
        except UnwrittenFileError as error:
            return str(error)
        return None

    def load(self, environment: Mapping[str, str]) -> Config:
        """Parse the kept configuration; ``ConfigError`` if it is not valid any more, OSError if
        gone.
        """
        text = self.kept.read_text(encoding="utf-8")
        return parse_config(text, str(self.kept), self.file.parent, environment)

    def changes(self) -> list[str]:
        """Unified diff between the kept text and the present file, without secrets."""
        try:
            old = _shown(self.kept.read_text(encoding="utf-8"))
            new = _shown(read_source(self.file))
        except (OSError, UnicodeDecodeError, ConfigError):
            return []
        lines = list(difflib.unified_diff(old, new, "last good", str(self.file), lineterm="", n=0))
        if len(lines) > MOST_LINES:
            lines = [*lines[:MOST_LINES], f"... and {len(lines) - MOST_LINES} lines more"]
        return lines

    def advice(self) -> str | None:
        """A hint at the way back for an error's text, if there is one."""
        if not self.kept.exists():
            return None
        lines = [
            f"the last good configuration is kept in {self.kept};",
            f"clearway run --last-good {self.file} runs it. Since then:",
            *(f"    {line}" for line in self.changes()),
        ]
        return "\n".join(lines)


def _shown(text: str) -> list[str]:
    return masked(text, values_of_unknown_keys(text, Config)).splitlines()
