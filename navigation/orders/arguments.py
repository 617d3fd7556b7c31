"""Arguments of orders from outside: read and checked, or refused in a sentence.

A stop is never refused for its reason: a long one is shortened, an unprintable one cleaned, and one
that is no text replaced. Nor for its robot: a name that none has stops all.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from navigation.config.values import LONGEST_DWELL_S, MOST_STATIONS
from navigation.config.zone_file import ZoneError, ordered_zone
from navigation.config.zones import ZoneSection
from navigation.mission.mission import Station
from navigation.orders.errors import ControlError
from navigation.shared.outside import finite_number, in_short, printable

if TYPE_CHECKING:
    from navigation.loop.people import People

LONGEST_DWELLS_S: Final = 86_400.0
"""A day, all stays together: they are planned in parts of 25 s, which must stay countable."""
REASON_CHARACTERS: Final = 500
ROBOT_CHARACTERS: Final = 64


def read_robot(request: Mapping[str, Any]) -> str | None:
    """Robot that a request names; None without one.

    Another value than a text is written as one, which no robot has for a name: a stop is not
    refused for it.
    """
    robot = request.get("robot")
    if robot is None:
        return None
    return printable(robot if isinstance(robot, str) else in_short(robot), ROBOT_CHARACTERS)


def _name(request: Mapping[str, Any], key: str) -> str | None:
    value = request.get(key)
    if value is not None and not isinstance(value, str):
        raise ControlError(f"{key}: must be a name, not {in_short(value)}")
    return value


def _reason(request: Mapping[str, Any]) -> str:
    reason = request.get("reason")
    return printable(reason if isinstance(reason, str) else "stopped by order", REASON_CHARACTERS)


def read_stations(value: Any) -> tuple[Station, ...]:
    """Stations from JSON; ControlError if there are none."""
    if not isinstance(value, list) or not 1 <= len(value) <= MOST_STATIONS:
        raise ControlError(f"stations: must be a list of 1 to {MOST_STATIONS} stations")
    stations = tuple(_station(number, item) for number, item in enumerate(value, 1))
    dwell_s = sum(station.dwell_s for station in stations)
    if dwell_s > LONGEST_DWELLS_S:
        raise ControlError(
            f"stations: dwell_s = {dwell_s:g} together: must be at most {LONGEST_DWELLS_S:g}"
        )
    return stations


def _station(number: int, item: Any) -> Station:
    if not isinstance(item, dict) or not set(item) <= {"x_m", "y_m", "heading_rad", "dwell_s"}:
        raise ControlError(
            f"station {number}: must be an object of x_m, y_m, heading_rad and dwell_s"
        )
    x, y = (_number(number, item, key) for key in ("x_m", "y_m"))
    heading_rad = None
    if item.get("heading_rad") is not None:
        heading_rad = math.remainder(_number(number, item, "heading_rad"), math.tau)
    dwell_s = _number(number, item, "dwell_s") if "dwell_s" in item else 0.0
    if dwell_s < 0.0:
        raise ControlError(f"station {number}: dwell_s = {dwell_s:g}: must be >= 0")
    if dwell_s > LONGEST_DWELL_S:
        limit = f"must be <= {LONGEST_DWELL_S:g}"
        raise ControlError(f"station {number}: dwell_s = {dwell_s:g}: {limit}")
    return Station(x, y, heading_rad, dwell_s)


def _number(number: int, item: Mapping[str, Any], key: str) -> float:
    value = item.get(key)
    found = finite_number(value)
    if found is None:
        raise ControlError(f"station {number}: {key} = {in_short(value)}: must be a finite number")
    return found


def _zone(request: Mapping[str, Any], people: People) -> ZoneSection:
    try:
        return ordered_zone(request.get("zone"), people.masks_in)
    except ZoneError as error:
        raise ControlError(str(error)) from None


def _zone_name(request: Mapping[str, Any]) -> str:
    name = _name(request, "name")
    if name is None:
        raise ControlError("name: is missing: must be a zone's")
    return printable(name, ROBOT_CHARACTERS)


def _revision(request: Mapping[str, Any]) -> int | None:
    value = request.get("revision")
    if value is not None and (not isinstance(value, int) or isinstance(value, bool)):
        raise ControlError(f"revision: must be a whole number, not {in_short(value)}")
    return value


READERS: Final[Mapping[str, Callable[[Mapping[str, Any], People], Any]]] = {
    "stations": lambda request, _: read_stations(request.get("stations")),
    "reason": lambda request, _: _reason(request),
    "camera": lambda request, _: _name(request, "camera"),
    "zone": _zone,
    "name": lambda request, _: _zone_name(request),
    "revision": lambda request, _: _revision(request),
}
"""By the name of the argument: its value in a request to people; ``ControlError`` if it has none.
"""
