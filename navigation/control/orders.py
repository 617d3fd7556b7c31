"""Orders as they come from outside: checked, carried out by the daemon, answered.

- A request is ``{"order": NAME, ...}``; an answer is ``{"ok": true, ...}`` or
  ``{"ok": false, "error": SENTENCE}``. What is malformed is refused, never raised.
- A stop's reason that is too long or unprintable is shortened and cleaned, never refused.

Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, Protocol, runtime_checkable

from navigation.config.values import LONGEST_DWELL_S, MOST_STATIONS
from navigation.mission.mission import MissionError, Station
from navigation.shared.outside import finite_number, in_short, printable

SCHEMA: Final = "clearway.status/1"
"""Of the answer to any order that was taken."""
LONGEST_DWELLS_S: Final = 86_400.0
"""All stays together: a day. They are planned in parts of 25 s, which must stay countable."""
REASON_CHARACTERS: Final = 500
ROBOT_CHARACTERS: Final = 64


class ControlError(ValueError):
    """An order that cannot be given or taken; the message says why."""


class NoDaemonError(ControlError):
    """An order that nobody takes, because certainly no daemon runs."""


class Commanded(Protocol):
    """What orders are given to: the daemon."""

    def give(self, stations: tuple[Station, ...]) -> None:
        """A new mission; MissionError where it cannot be."""

    def stop(self, reason: str) -> str | None:
        """Emergency stop, latched; the sentence where a restart would not know of it."""

    def pause(self) -> None:
        """Hold until resumed."""

    def resume(self) -> None:
        """End a pause; after a stop re-arm, and the next time go on."""

    def replan(self) -> None:
        """Plan anew from where the robot is."""

    def settle(self) -> None:
        """Return when the orders given so far were acted on, soon in any case."""

    def describe(self) -> Mapping[str, Any]:
        """The present state, as JSON takes it."""
        ...


@runtime_checkable
class HasRobots(Protocol):
    """A daemon of several robots."""

    def of(self, robot: str) -> Commanded:
        """One of them; MissionError where there is none of that name."""
        ...


@runtime_checkable
class CanReanchor(Protocol):
    """A daemon whose camera may be placed anew."""

    @property
    def reanchor(self) -> Callable[[str | None], Sequence[str]] | None:
        """Does it with the camera of a name, or the only one, and says what was found, or
        MissionError; None where a run cannot."""
        ...


def carry_out(request: Mapping[str, Any], daemon: Commanded) -> dict[str, Any]:
    """Do what a request asks for; the answer, never an exception for a bad request."""
    further: dict[str, Any] = {}
    try:
        daemon = _meant(request, daemon)
        match request.get("order"):
            case "go":
                daemon.give(read_stations(request.get("stations")))
            case "stop":
                trouble = daemon.stop(_reason(request))
                further |= {"trouble": trouble} if trouble else {}
            case "pause":
                daemon.pause()
            case "resume":
                daemon.resume()
            case "replan":
                daemon.replan()
            case "reanchor":
                further["anchoring"] = list(_reanchor(request, daemon))
            case "status":
                pass
            case other:
                raise ControlError(
                    f"order {in_short(other)}: must be go, stop, pause, resume, replan, reanchor "
                    "or status"
                )
    except (ControlError, MissionError) as error:
        return {"ok": False, "error": str(error)}
    return {"schema": SCHEMA, "ok": True, **daemon.describe(), **further}


def _reanchor(request: Mapping[str, Any], daemon: Commanded) -> Sequence[str]:
    how = daemon.reanchor if isinstance(daemon, CanReanchor) else None
    if how is None:
        raise ControlError("reanchor: this run cannot place its camera anew")
    camera = request.get("camera")
    if camera is not None and not isinstance(camera, str):
        raise ControlError(f"camera: must be a name, not {in_short(camera)}")
    return how(camera)


def _meant(request: Mapping[str, Any], daemon: Commanded) -> Commanded:
    """The robot that a request names; the daemon, and so all its robots, where it names none."""
    name = request.get("robot")
    if name is None:
        return daemon
    if not isinstance(name, str):
        raise ControlError(f"robot: must be a name, not {in_short(name)}")
    if not isinstance(daemon, HasRobots):
        raise ControlError(f"robot {in_short(name)}: this run has one robot, which has no name")
    return daemon.of(printable(name, ROBOT_CHARACTERS))


def _reason(request: Mapping[str, Any]) -> str:
    reason = request.get("reason", "stopped by order")
    if not isinstance(reason, str):
        raise ControlError(f"reason: must be a text of at most {REASON_CHARACTERS} characters")
    return printable(reason, REASON_CHARACTERS)


def read_stations(value: Any) -> tuple[Station, ...]:
    """Stations from JSON; ControlError where they are none."""
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
