"""Stops as files: each is in force until a person re-arms, whatever happens to the program.

A run is held by every stop that shares its socket, its configuration or one of its ports. A file
that cannot be read whole is a stop of every robot.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from navigation.config.values import SIMULATED
from navigation.shared.outside import printable
from navigation.shared.sealed import SealError, seal, unseal
from navigation.shared.whole_file import sync_folder, write_whole
from vision.camera.sources import without_password

FOLDER: Final = "stops"
"""In the program's state folder."""
KIND: Final = "stop"
VERSION: Final = 1
MOST_BYTES: Final = 65_536


@dataclass(frozen=True, slots=True)
class Latch:
    """One stop; ``robot`` is empty for all, or for the only one. ``when`` is ISO 8601."""

    robot: str
    reason: str
    when: str
    socket: str
    configuration: str = ""
    ports: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """Sentence of a run held by it."""
        return (
            f"stopped before this run began ({self.reason}, {self.when}): "
            "waits for `clearway resume`"
        )


@dataclass(frozen=True, slots=True)
class Kept:
    """A stop's file and content; ``latch`` is None if it cannot be read."""

    file: Path
    latch: Latch | None
    trouble: str = ""

    @property
    def sentence(self) -> str:
        """Reason why a robot waits."""
        if self.latch is not None:
            return self.latch.sentence
        return (
            f"the stop {self.file} {self.trouble}, which counts as a stop of every robot: "
            "waits for `clearway resume`"
        )


def write_latch(folder: Path, latch: Latch) -> Path:
    """Store a stop; its file is on disk when this returns. ``OSError``, UnwrittenFileError."""
    text = json.dumps(asdict(latch))
    file = folder / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.stop"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_whole(file, seal(KIND, VERSION, text), private=True, durable=True)
    return file


def remove_latch(file: Path) -> None:
    """Remove a stop's file for good; ``OSError``."""
    file.unlink(missing_ok=True)
    sync_folder(file.parent)


def read_latches(folder: Path) -> list[Kept]:
    """Every stop in a folder; an unreadable file or folder counts as one."""
    try:
        names = sorted(os.listdir(folder))
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as error:
        return [Kept(folder, None, f"cannot be read ({error.strerror or error})")]
    # a leading dot: a stop being written
    return [_read(folder / name) for name in names if not name.startswith(".")]


def _read(file: Path) -> Kept:
    try:
        with file.open("rb") as opened:
            text = unseal(KIND, VERSION, opened.read(MOST_BYTES))
        read = json.loads(text)
        latch = Latch(**{**read, "ports": tuple(read["ports"])})
    except OSError as error:
        return Kept(file, None, f"cannot be read ({error.strerror or error})")
    except (SealError, ValueError, TypeError, KeyError) as error:
        return Kept(file, None, printable(str(error), 100))
    return Kept(file, latch)


def ports_of(port: str) -> tuple[str, ...]:
    """Names of a real port, without passwords; none if it is simulated."""
    if port == SIMULATED:
        return ()
    own = without_password(port)
    return (own, *({os.path.realpath(own)} - {own})) if own.startswith("/") else (own,)


def held_by(
    kept: Kept, socket: str, configuration: str, ports: Mapping[str, tuple[str, ...]]
) -> set[str]:
    """Names of a run's robots, of ``ports``, that a stop holds.

    A stop of a robot unknown to the run holds them all: it may be any of them.
    """
    latch, everyone = kept.latch, set(ports)
    if latch is None:
        return everyone
    on_port = {name for name, own in ports.items() if set(own) & set(latch.ports)}
    same_arena = latch.socket == socket or (
        latch.configuration != "" and latch.configuration == configuration
    )
    if not same_arena:
        return on_port
    if not latch.robot:
        return everyone
    named = {latch.robot} & everyone
    return (named | on_port) or everyone
