"""Zones in a recording: a JSON message for `clearway replay`, read back without loss.

A mask is written as a scene text, since its file is not recorded.
"""

from __future__ import annotations

from typing import Any, Final

from navigation.recording.events import ZonesChanged
from planner.zones.areas import Area, BandArea, CircleArea, MaskArea, PolygonArea
from planner.zones.masks import mask_of_text, mask_text
from planner.zones.zone import Zone

MOST_ZONES: Final = 1000
"""Zones of one message that are read: chosen, far beyond any run's."""


def zones_body(changed: ZonesChanged) -> dict[str, Any]:
    """All zones in force, and the scene's revision with them."""
    zones = [_plain(one) for one in changed.zones]
    return {"time_s": changed.time_s, "revision": changed.revision, "zones": zones}


def zones_of(body: dict[str, Any]) -> ZonesChanged:
    """Read the zones; ``SceneError``, ValueError or LookupError if invalid."""
    written = body["zones"]
    if len(written) > MOST_ZONES:
        raise ValueError(f"{len(written)} zones: must be at most {MOST_ZONES}")
    zones = tuple(_zone(one) for one in written)
    return ZonesChanged(float(body["time_s"]), int(body["revision"]), zones)


def _plain(zone: Zone) -> dict[str, Any]:
    plain: dict[str, Any] = {"name": zone.name, "kind": zone.kind, "area": area_body(zone.area)}
    plain["robots"] = list(zone.robots)
    plain["speed_m_s"], plain["cost"] = zone.speed, zone.cost
    return plain


def area_body(area: Area) -> dict[str, Any]:
    """Keys of an area as in a configuration; a mask's cells are a scene text."""
    match area:
        case PolygonArea(corners):
            return {"polygon": [list(corner) for corner in corners]}
        case CircleArea((x, y), radius):
            return {"circle": [x, y, radius]}
        case BandArea(line, width):
            return {"line": [list(place) for place in line], "width_m": width}
        case MaskArea(_, source):
            return {"mask": source, "scene": mask_text(area)}


def _zone(plain: dict[str, Any]) -> Zone:
    return Zone(
        plain["name"],
        plain["kind"],
        _area_of(plain["area"]),
        tuple(str(name) for name in plain["robots"]),
        plain["speed_m_s"],
        plain["cost"],
    )


def _area_of(plain: dict[str, Any]) -> Area:
    if "polygon" in plain:
        return PolygonArea(plain["polygon"])
    if "circle" in plain:
        x, y, radius = plain["circle"]
        return CircleArea((x, y), radius)
    if "line" in plain:
        return BandArea(plain["line"], plain["width_m"])
    return mask_of_text(plain["scene"], str(plain["mask"]))
