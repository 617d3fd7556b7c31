"""The zones of a run for viewers: as a configuration has them, with what only a page needs.

Metres in the arena's frame. ``title`` is the zone as sentences name it; a mask has ``outlines``,
closed polylines, and the name of its file without the folder.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from navigation.config.zones import ZoneSection
from navigation.dashboard.messages.packed import pack
from navigation.draw.layers import chain_points
from planner.zones.areas import MaskArea


def zones_message(zones: Sequence[ZoneSection], revision: int, number: int) -> bytes:
    """All zones; ``revision`` counts the changes that people have made."""
    told = [_zone(zone) for zone in zones]
    return pack("zones", {"number": number, "revision": revision, "zones": told}, {})


def _zone(section: ZoneSection) -> dict[str, Any]:
    zone = section.zone()
    written = section.model_dump(mode="json", exclude={"mask"}, exclude_defaults=True)
    shown: dict[str, Any] = {"title": str(zone)}
    if section.mask is not None and isinstance(zone.area, MaskArea):
        shown |= {"mask": section.mask.name, "outlines": _outlines(zone.area)}
    return {**written, **shown}


def _outlines(area: MaskArea) -> list[list[list[float]]]:
    records = (
        record
        for one in area.outlines(y_down=False)
        for record in (*one.records, *(r for hole in one.holes for r in hole))
    )
    return [chain_points(record, False).round(4).tolist() for record in records]
