"""The zones of a run for viewers: the keys of a configuration, with what only a page needs.

Metres. ``title`` is the zone as sentences name it; a mask has ``outlines``, closed polylines, and
the name of its file without the folder.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from navigation.dashboard.messages.packed import pack
from navigation.draw.outlines import chain_points
from navigation.recording.zone_bodies import area_body
from planner.zones.areas import Area, MaskArea
from planner.zones.zone import Zone


def zones_message(zones: Sequence[Zone], revision: int, number: int) -> bytes:
    """All zones; ``revision`` counts the changes that people have made."""
    listed = [_zone(zone) for zone in zones]
    return pack("zones", {"number": number, "revision": revision, "zones": listed}, {})


def _zone(zone: Zone) -> dict[str, Any]:
    further = {"robots": list(zone.robots), "speed_m_s": zone.speed, "cost": zone.cost}
    return {
        "name": zone.name,
        "kind": zone.kind,
        "title": str(zone),
        **_area(zone.area),
        **{key: value for key, value in further.items() if value},
    }


def _area(area: Area) -> dict[str, Any]:
    if isinstance(area, MaskArea):
        return {"mask": Path(area.source).name or "a mask", "outlines": _outlines(area)}
    return area_body(area)


def _outlines(area: MaskArea) -> list[list[list[float]]]:
    records = (
        record
        for one in area.outlines(y_down=False)
        for record in (*one.records, *(r for hole in one.holes for r in hole))
    )
    return [chain_points(record, False).round(4).tolist() for record in records]
