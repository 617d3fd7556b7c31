"""Output of commands: files, never over their inputs, and warnings of doubtful pictures."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from navigation.cli.options import STANDARD_STREAM

if TYPE_CHECKING:
    from planner.scene import Scene


class CommandError(ValueError):
    """Error: a command's input, request or output cannot be used."""


def keep_apart(outputs: Iterable[tuple[str, Path | None]], inputs: Iterable[Path | None]) -> None:
    """Raise click's usage error if an output, named by its option, is also read or written.

    Only files count: a terminal or /dev/null may be named repeatedly, standard input once.
    """
    read = [path for path in inputs if path is not None]
    if read.count(STANDARD_STREAM) > 1:
        raise click.UsageError("-: only one input can be standard input")
    taken = {
        _identity(path): f"overwrite {path}, which is read"
        for path in read
        if path != STANDARD_STREAM
    }
    for option, path in outputs:
        if path in (None, STANDARD_STREAM) or (path.exists() and not path.is_file()):
            continue
        here = _identity(path)
        if here in taken:
            raise click.UsageError(f"{option} {path}: would {taken[here]}")
        taken[here] = f"overwrite the file of {option}"


def write_text(path: Path | None, text: str) -> None:
    """Write a whole file as UTF-8, or to standard output for None or ``-``; ``CommandError``."""
    if path is None or path == STANDARD_STREAM:
        click.echo(text, nl=False)
        return
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """Write a whole file; ``CommandError``."""
    try:
        path.write_bytes(data)
    except OSError as error:
        raise CommandError(f"{path}: cannot be written: {error.strerror or error}") from error


class Stopwatch(dict[str, float]):
    """Milliseconds of a command's stages by name, each from the end of the one before."""

    def __init__(self) -> None:
        super().__init__()
        self._begin_s = self._last_s = time.perf_counter()

    def begin(self) -> None:
        """Leave out the time since the last stage."""
        self._last_s = time.perf_counter()

    def end(self, stage: str) -> None:
        """Add the time since the last stage to this one."""
        last_s = self._last_s
        self.begin()
        self[stage] = self.get(stage, 0.0) + 1e3 * (self._last_s - last_s)

    def end_all(self) -> None:
        """Add the total, pauses included."""
        self["total"] = 1e3 * (time.perf_counter() - self._begin_s)


def tell_times(timings_ms: Mapping[str, float]) -> None:
    """Print each stage's time on standard error, if that is a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        return
    stages = (f"{stage} {time_ms:.1f}" for stage, time_ms in timings_ms.items())
    click.echo(f"ms: {', '.join(stages)}", err=True)


def warn_of_doubts(scene: Scene, source: Path) -> None:
    """Warn on standard error if a picture shows nothing, or hardly an arena."""
    if scene.binarisation is None:
        return
    from vision.doubts import doubts_about

    for doubt in doubts_about(scene):
        click.echo(f"clearway: warning: {named(source)}: {doubt}", err=True)


def named(source: Path) -> Path:
    """Name of a source in messages."""
    return Path("standard input") if source == STANDARD_STREAM else source


def _identity(path: Path) -> object:
    try:
        told = path.stat()
    except OSError:
        return path.absolute()
    return told.st_dev, told.st_ino
