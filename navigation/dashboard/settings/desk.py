"""The desk that reads, checks and saves the configuration for the page.

Rules
- It saves nothing that `clearway check` would refuse, and never over a file that has changed since
  the visitor read it.
- Before each save the present text is kept; `undo` puts the newest kept one back, but never over a
  file that was changed in between: an owner's change to a file's name or to `safety` is the last.
- A save takes effect like a reload: the run ends in order and begins again.
"""

from __future__ import annotations

import hashlib
import os
import threading
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from navigation.config import Config
from navigation.config.editing.form import Key, TypedError, form, form_keys
from navigation.config.editing.in_file import ChangedMeanwhileError, write_source
from navigation.config.editing.in_text import EditError, with_values
from navigation.config.errors import ConfigError, key_name
from navigation.config.load import parse_config, read_source
from navigation.config.marks import Location
from navigation.config.secrecy.secrets import hide
from navigation.dashboard.visits import RefusedError
from navigation.shared.whole_file import UnwrittenFileError, write_whole

MOST_KEPT: Final = 20
MOST_CHANGES: Final = 500
_DIGITS: Final = 16
"""Length of the digest in a kept text's name."""


class Around(NamedTuple):
    """Requirements of the desk on the program."""

    file: Path
    state: Path
    """The program's state folder, with the earlier texts."""
    environment: Mapping[str, str]
    file_problems: Callable[[Config], Iterable[tuple[Location, str]]]
    """Search for faults in the files that a configuration names."""
    devices: Callable[[], tuple[Sequence[str], Sequence[str]]]
    """Paths of the cameras and the serial ports."""
    reload: Callable[[], None]
    """Puts the file's text into effect."""


class Desk:
    """Reads, checks and saves one configuration; any thread may call every method."""

    def __init__(self, around: Around) -> None:
        self._around = around
        self._file = around.file.absolute()
        digest = hashlib.sha256(os.fsencode(self._file)).hexdigest()[:8]
        self._lock = threading.Lock()
        self._kept = around.state / "settings" / f"{self._file.stem}-{digest}"

    def show(self) -> dict[str, Any]:
        """The form and its sources; ``ConfigError`` if the file cannot be read."""
        text = read_source(self._file)
        return {
            "file": self._file.name,
            "base": _digest(text),
            "sections": form(text, self._keys(text)),
            "earlier": self._undoable(text),
        }

    def check(self, typed: Mapping[str, str]) -> list[dict[str, str]]:
        """Problems of these values: each a ``key`` ("" for none) and a ``sentence``."""
        return self._changed(read_source(self._file), typed)[1]

    def save(self, typed: Mapping[str, str], base: str) -> str:
        """Save the values and reload; return a sentence for the log.

        ``RefusedError`` if that is impossible; the file is unchanged then.
        """
        with self._lock:
            text = read_source(self._file)
            if _digest(text) != base:
                raise RefusedError(self._read_again)
            changed, problems = self._changed(text, typed)
            if problems:
                raise RefusedError("; ".join(one["sentence"] for one in problems))
            if changed == text:
                raise RefusedError("nothing has changed")
            try:
                kept = self._keep(text, changed)
                try:
                    write_source(self._file, changed, over=text)
                except BaseException:
                    kept.unlink(missing_ok=True)  # it would hide the save before from `undo`
                    raise
            except ChangedMeanwhileError:
                raise RefusedError(self._read_again) from None
            except (OSError, UnwrittenFileError) as error:
                raise RefusedError(f"not saved: {error}") from None
        self._around.reload()
        return f"saved {', '.join(sorted(typed))} in {self._file.name}"

    def undo(self) -> str:
        """Restore the text before the last save and reload; ``RefusedError`` if it cannot."""
        with self._lock:
            earlier = self._earlier()
            if not earlier:
                raise RefusedError("there is no earlier text to go back to")
            present = read_source(self._file)
            try:
                if not self._replaced(earlier[-1], present):
                    raise ChangedMeanwhileError
                text = earlier[-1].read_text(encoding="utf-8")
                parse_config(text, self._file.name, self._file.parent, self._around.environment)
                write_source(self._file, text, over=present)
                earlier[-1].unlink()
            except ChangedMeanwhileError:
                raise RefusedError(
                    f"{self._file.name} was changed by someone else since: change it in the file"
                ) from None
            except (ConfigError, OSError, UnwrittenFileError) as error:
                raise RefusedError(f"not put back: {hide(str(error))}") from None
        self._around.reload()
        return f"the last change of {self._file.name} is undone"

    @property
    def _read_again(self) -> str:
        return f"{self._file.name} was changed by someone else since: read it again first"

    def _keys(self, text: str) -> list[Key]:
        cameras, ports = self._around.devices()
        return list(form_keys(text, cameras, ports))

    def _changed(self, text: str, typed: Mapping[str, str]) -> tuple[str, list[dict[str, str]]]:
        if len(typed) > MOST_CHANGES:
            raise RefusedError(f"more than {MOST_CHANGES} changes")
        keys = {key.name: key for key in self._keys(text)}
        values: dict[Location, Any] = {}
        problems: list[dict[str, str]] = []
        for name, words in typed.items():
            key = keys.get(name)
            if key is None or key.only_shown:
                why = "there is no such key" if key is None else key.only_shown
                problems.append(_problem(name, f"{name}: {why}"))
                continue
            try:
                values[key.where] = key.value_of(words)
            except TypedError as error:
                problems.append(_problem(name, str(error)))
        try:
            changed = with_values(text, values)
        except EditError as error:
            return text, [*problems, _problem("", str(error))]
        return changed, [*problems, *self._problems_of(changed, keys)]

    def _problems_of(self, text: str, keys: Collection[str]) -> list[dict[str, str]]:
        folder, name = self._file.parent, self._file.name
        try:
            config = parse_config(text, name, folder, self._around.environment)
        except ConfigError as error:
            found = [(one.where, "" if one.is_secret else one.message) for one in error.problems]
        else:
            found = list(self._around.file_problems(config))
        return [
            _problem(_field_of(where, keys), hide(f"{key_name(where)}: {what}" if where else what))
            for where, what in found
        ]

    def _undoable(self, text: str) -> int:
        """Number of earlier texts; 0 if the newest is not that of this text."""
        earlier = self._earlier()
        return len(earlier) if earlier and self._replaced(earlier[-1], text) else 0

    def _earlier(self) -> list[Path]:
        return sorted(self._kept.glob("*.yaml"))

    @staticmethod
    def _replaced(kept: Path, text: str) -> bool:
        """True if the save that kept this file wrote ``text`` in its place."""
        return kept.stem.partition("-")[2] == _digest(text)[:_DIGITS]

    def _keep(self, text: str, replacement: str) -> Path:
        """Keep a text; its file is named after its number and the digest of its replacement."""
        self._kept.mkdir(mode=0o700, parents=True, exist_ok=True)
        earlier = self._earlier()
        number = int(earlier[-1].stem.partition("-")[0]) + 1 if earlier else 1
        name = f"{number:06d}-{_digest(replacement)[:_DIGITS]}.yaml"
        kept = self._kept / name
        write_whole(kept, text, private=True)
        for old in self._earlier()[:-MOST_KEPT]:
            old.unlink(missing_ok=True)
        return kept


def _field_of(where: Location, keys: Collection[str]) -> str:
    """Field in which a place is typed: the longest name that leads there."""
    names = [key_name(where[:length]) for length in range(len(where), 0, -1)]
    return next((name for name in names if name in keys), names[-1] if names else "")


def _problem(key: str, sentence: str) -> dict[str, str]:
    return {"key": key, "sentence": sentence}


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
