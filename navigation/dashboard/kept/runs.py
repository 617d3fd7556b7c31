"""Earlier runs: the list, the files of each, and the path from a name to a file.

Rules
- A run is a folder in ``recording.runs_dir`` named by a local time, with the files of `RUN_FILES`.
  A recording is an MCAP file with a recording's name. Nothing else is seen, and no link.
- A recording belongs to the last run that began before it.
"""

from __future__ import annotations

import json
import os
import re
import stat
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO, Final

from navigation.recording.names import PREFIX, SUFFIX

RUN_FILES: Final = ("report.json", "track.svg", "events.jsonl")
MOST_REPORT_BYTES: Final = 262_144
_STAMP: Final = "%Y-%m-%d_%H-%M-%S"
_TIME: Final = r"(\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d)"
_RUN: Final = re.compile(rf"{_TIME}(?:_(\d{{1,3}}))?", re.ASCII)
_RECORDING: Final = re.compile(
    rf"{re.escape(PREFIX)}{_TIME}_\d{{3,6}}{re.escape(SUFFIX)}", re.ASCII
)


@dataclass(frozen=True, slots=True)
class KeptFile:
    """A file that a run left behind."""

    name: str
    size_bytes: int


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A run, by its folder's name; ``is_running``: it serves the page."""

    name: str
    began: datetime
    report: dict[str, Any] | None
    files: tuple[KeptFile, ...]
    recordings: tuple[KeptFile, ...]
    is_running: bool


@dataclass(frozen=True, slots=True)
class RunPage:
    """Some runs, newest first; ``total`` counts all, ``following`` says if more come."""

    runs: tuple[KeptRun, ...]
    total: int
    following: bool


@dataclass(frozen=True, slots=True)
class KeptRuns:
    """The folders; ``running`` is the name of the present run's own, if any."""

    runs_dir: Path
    recordings_dir: Path
    running: str | None = None

    def page(self, before: str | None, count: int) -> RunPage:
        """The newest ``count`` runs, or those older than the run named ``before``."""
        names = sorted(_names(self.runs_dir, is_run), key=_order)
        end = len(names)
        if before is not None:
            end = next((k for k, name in enumerate(names) if _order(name) >= _order(before)), end)
        first = max(0, end - count)
        recordings = self._recordings(names)
        shown = tuple(self._run(name, recordings) for name in reversed(names[first:end]))
        return RunPage(shown, len(names), first > 0)

    @contextmanager
    def opened(self, run: str, file: str) -> Iterator[BinaryIO]:
        """Open a run's file or one of its recordings; FileNotFoundError otherwise."""
        if not is_run(run):
            raise FileNotFoundError(run)
        if file in RUN_FILES:
            path = self.runs_dir / run / file
        elif is_recording(file):
            path = self.recordings_dir / file
        else:
            raise FileNotFoundError(file)
        if (self.runs_dir / run).is_symlink() or not (self.runs_dir / run).is_dir():
            raise FileNotFoundError(run)
        with _opened(path) as opened:
            yield opened

    def _run(self, name: str, recordings: dict[str, list[str]]) -> KeptRun:
        folder = self.runs_dir / name
        return KeptRun(
            name,
            datetime.strptime(_order(name)[0], _STAMP),
            _report(folder / RUN_FILES[0]),
            tuple(_sized(folder, RUN_FILES)),
            tuple(_sized(self.recordings_dir, recordings.get(name, []))),
            name == self.running,
        )

    def _recordings(self, runs: list[str]) -> dict[str, list[str]]:
        begins = [_order(name)[0] for name in runs]
        found: dict[str, list[str]] = {}
        for name in sorted(_names(self.recordings_dir, is_recording)):
            match = _RECORDING.fullmatch(name)
            at = bisect_right(begins, match[1] if match else "")
            if at:
                found.setdefault(runs[at - 1], []).append(name)
        return found


def is_run(name: str) -> bool:
    """True for a run's folder name: a valid time."""
    return _is_time(_RUN.fullmatch(name))


def is_recording(name: str) -> bool:
    """True for a recording's name."""
    return _is_time(_RECORDING.fullmatch(name))


def _is_time(match: re.Match[str] | None) -> bool:
    try:
        return match is not None and datetime.strptime(match[1], _STAMP) is not None
    except ValueError:
        return False


def _order(name: str) -> tuple[str, int]:
    match = _RUN.fullmatch(name)
    return ("", 0) if match is None else (match[1], int(match[2] or 1))


def _names(folder: Path, wanted: Any) -> list[str]:
    try:
        with os.scandir(folder) as entries:
            return [entry.name for entry in entries if wanted(entry.name) and _is_own(entry)]
    except OSError:
        return []


def _is_own(entry: os.DirEntry[str]) -> bool:
    if is_run(entry.name):
        return entry.is_dir(follow_symlinks=False)
    return entry.is_file(follow_symlinks=False)


def _sized(folder: Path, names: tuple[str, ...] | list[str]) -> Iterator[KeptFile]:
    for name in names:
        try:
            found = (folder / name).lstat()
        except OSError:
            continue  # a recording removed meanwhile, a run without a scene
        if stat.S_ISREG(found.st_mode):
            yield KeptFile(name, found.st_size)


def _report(path: Path) -> dict[str, Any] | None:
    try:
        with _opened(path) as file:
            found = json.loads(file.read(MOST_REPORT_BYTES))
        json.dumps(found, ensure_ascii=False).encode()  # half a surrogate could not be sent
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """Open an ordinary file, no link and no pipe; ``OSError``."""
    flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    with open(os.open(path, flags), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise FileNotFoundError(path)
        yield file
