"""A zone in words, and as it is written in a configuration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from navigation.config.zones.section import ZoneSection
from planner.zones.zone import KIND_NAMES, LANE_COST


def in_words(zone: ZoneSection) -> str:
    """Kind, name, area, speed or cost, and the robots, in a line."""
    parts = [_area(zone)]
    if zone.speed_m_s is not None:
        parts.append(f"{zone.speed_m_s:g} m/s")
    if zone.kind == "lane":
        parts.append(f"cost {LANE_COST if zone.cost is None else zone.cost:g}")
    if zone.robots:
        parts.append(f"for {', '.join(zone.robots)}")
    return f"{KIND_NAMES[zone.kind]} '{zone.name}': {', '.join(parts)}"


def _area(zone: ZoneSection) -> str:
    if zone.polygon is not None:
        return f"polygon of {len(zone.polygon)} corners"
    if zone.circle is not None:
        x, y, radius = zone.circle
        return f"circle of {radius:g} m around ({x:g}, {y:g}) m"
    if zone.line is not None:
        (x0, y0), (x1, y1) = zone.line[0], zone.line[-1]
        return f"band {zone.width_m:g} m wide from ({x0:g}, {y0:g}) to ({x1:g}, {y1:g}) m"
    return f"mask {zone.mask}"


def as_written(zone: ZoneSection) -> dict[str, Any]:
    """Keys as in a configuration, in JSON's types; a mask's file is absolute."""
    return zone.model_dump(mode="json", exclude_defaults=True)


def as_yaml(written: Sequence[Mapping[str, Any]]) -> str:
    """The list `zones` of a configuration, of zones as written."""
    if not written:
        return "zones: []\n"
    return yaml.safe_dump(
        {"zones": list(written)}, sort_keys=False, default_flow_style=None, width=100
    )
