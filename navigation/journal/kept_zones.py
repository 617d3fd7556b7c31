"""Changes of zones on disk, beside the journal: the next run begins with them.

Rules
- Only what differs from the configuration is kept: each zone as it was configured, and as it is in
  force. A zone that the configuration has changed since keeps that later form.
- A mask is kept whole: its file may be another one by then, or gone.
- A file that cannot be used is an error, since a keep-out zone may be lost with it. It stays where
  it is until the robots' stop is on the disk, and is then put aside.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from navigation.config.recording import ZONES_FILE
from navigation.config.zone_file import ZoneError, zone_of
from navigation.config.zones import ZoneSection
from navigation.config.zones.in_words import as_written
from navigation.shared.outside import printable
from navigation.shared.sealed import SealError, seal, unseal
from navigation.shared.whole_file import UnwrittenFileError, sync_folder, write_whole
from planner.scene import SceneError
from planner.zones.areas import MaskArea
from planner.zones.masks import mask_of_text, mask_text

KIND: Final = "zones"
VERSION: Final = 1
MOST_BYTES: Final = 16_000_000
"""Chosen: all corners that zones may have take 0.2 MB, and a mask of 11 000 islands 1.1 MB."""
MOST_ASIDE: Final = 1000


class KeptZonesError(ValueError):
    """Error: the changes cannot be read or written."""


@dataclass(frozen=True, slots=True)
class ZoneChange:
    """One zone that differs: as configured, and as in force; None where it is not."""

    configured: ZoneSection | None
    in_force: ZoneSection | None

    @property
    def name(self) -> str:
        """Name of the zone."""
        zone = self.in_force or self.configured
        assert zone is not None
        return zone.name

    @property
    def in_a_word(self) -> str:
        """``added``, ``changed`` or ``removed``."""
        if self.configured is None:
            return "added"
        return "removed" if self.in_force is None else "changed"


def changes_between(
    configured: Sequence[ZoneSection], in_force: Sequence[ZoneSection]
) -> tuple[ZoneChange, ...]:
    """Return the zones that differ; their order is no difference."""
    before = {one.name: one for one in configured}
    after = {one.name: one for one in in_force}
    names = dict.fromkeys((*before, *after))
    pairs = ((before.get(name), after.get(name)) for name in names)
    return tuple(ZoneChange(was, now) for was, now in pairs if was != now)


def with_changes(
    configured: Sequence[ZoneSection], changes: Sequence[ZoneChange], robots: Collection[str]
) -> tuple[tuple[ZoneSection, ...], list[str]]:
    """Return the configured zones with an earlier run's changes, and a sentence for each.

    ``robots`` are this run's names: a zone is left out if none of its robots is among them. So is
    one that is configured otherwise meanwhile.
    """
    zones = {one.name: one for one in configured}
    said = []
    for change in changes:
        now = change.in_force
        what = f"zone '{change.name}', {change.in_a_word} while an earlier run was under way"
        gone = () if now is None else tuple(one for one in now.robots if one not in robots)
        if zones.get(change.name) != change.configured:
            said.append(f"{what}: the configuration has changed it since, and holds")
        elif now is None:
            del zones[change.name]
            said.append(f"{what}: stays removed")
        elif gone and len(gone) == len(now.robots):
            said.append(f"{what}: dropped: there is no robot '{min(gone)}' in this run")
        elif gone:
            left = tuple(one for one in now.robots if one in robots)
            zones[change.name] = now.model_copy(update={"robots": left})
            who = f"for {', '.join(left)}; there is no robot '{min(gone)}' in this run"
            said.append(f"{what}: holds again {who}")
        else:
            zones[change.name] = now
            said.append(f"{what}: holds again")
    return tuple(zones.values()), said


class KeptZones:
    """The file of the changes; one program at a time, which has locked the journal beside it."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def beside(cls, journal: Path) -> KeptZones:
        """Return the file beside a journal."""
        return cls(journal.with_name(f"{journal.name}.{ZONES_FILE}"))

    def read(self) -> tuple[ZoneChange, ...]:
        """Return the changes, none without a file; ``KeptZonesError`` if it is unusable."""
        try:
            with self.path.open("rb") as file:
                data = file.read(MOST_BYTES)
        except FileNotFoundError:
            return ()
        except OSError as error:
            raise KeptZonesError(f"{self.path}: {error.strerror or error}") from None
        try:
            records = json.loads(unseal(KIND, VERSION, data))
            return tuple(_change(one) for one in records)
        except (SealError, ZoneError, SceneError, ValueError, TypeError, KeyError) as error:
            raise KeptZonesError(f"{self.path}: {printable(str(error), 300)}") from None

    def put_aside(self) -> str:
        """Rename the file; return what became of it. ``KeptZonesError`` if it stays in place."""
        for number in range(1, MOST_ASIDE + 1):
            aside = self.path.with_name(f"{self.path.name}.damaged-{number}")
            if not aside.exists():
                break
        else:
            most = f"{MOST_ASIDE} files are kept already"
            raise KeptZonesError(f"{self.path}: cannot be put aside: {most}")
        try:
            self.path.rename(aside)
        except OSError as error:
            why = error.strerror or error
            raise KeptZonesError(f"{self.path}: cannot be put aside: {why}") from None
        return f"{self.path}: kept as {aside.name}"

    def encoded(self, changes: Sequence[ZoneChange]) -> bytes:
        """Return the file's content, empty without a change; ``KeptZonesError`` if too long."""
        if not changes:
            return b""
        data = seal(KIND, VERSION, json.dumps([_record(one) for one in changes]))
        if len(data) > MOST_BYTES:
            most = f"must be at most {MOST_BYTES}"
            raise KeptZonesError(f"{self.path}: {len(data)} bytes of zones: {most}")
        return data

    def write(self, data: bytes) -> None:
        """Keep what `encoded` returned; it is on disk when this returns. ``KeptZonesError``."""
        try:
            if not data:
                with contextlib.suppress(FileNotFoundError):
                    self.path.unlink()
                    sync_folder(self.path.parent)
                return
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self.path, data, private=True, durable=True)
        except UnwrittenFileError as error:
            raise KeptZonesError(str(error)) from None
        except OSError as error:
            raise KeptZonesError(f"{self.path}: {error.strerror or error}") from None


def _record(change: ZoneChange) -> dict[str, Any]:
    return {"configured": _written(change.configured), "in_force": _written(change.in_force)}


def _written(zone: ZoneSection | None) -> dict[str, Any] | None:
    if zone is None:
        return None
    area = zone.zone().area
    scene = {"scene": mask_text(area)} if isinstance(area, MaskArea) else {}
    return as_written(zone) | scene


def _change(record: dict[str, Any]) -> ZoneChange:
    was, now = _zone(record["configured"]), _zone(record["in_force"])
    if was is None and now is None:
        raise ValueError("a change of no zone")
    return ZoneChange(was, now)


def _zone(written: dict[str, Any] | None) -> ZoneSection | None:
    if written is None:
        return None
    keys = dict(written)
    area = mask_of_text(keys.pop("scene"), str(keys["mask"])) if "mask" in keys else None
    return zone_of(keys, area)
