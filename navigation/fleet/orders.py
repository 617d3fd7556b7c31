"""Results of one cycle of the coordinator, and which robots wait or hold. Metres."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from navigation.fleet.members import Member, comes_too_near, why_nobody_moves
from navigation.fleet.releases import Held, release_of
from navigation.fleet.request import FleetRequest, Promise, Request
from navigation.mission.cycle import PlanAnswer
from navigation.mission.mission import State, Station
from planner.borders.polyline import distance_to_polyline
from planner.scene import FloatArray

ON_TRACK_M: Final = 0.02
"""A robot this near to its promised path continues on it; one farther off is planned again."""


@dataclass(frozen=True, slots=True)
class TrafficOrders:
    """Results of one cycle for the planner, and for robots by name."""

    plan_again: tuple[tuple[str, str], ...] = ()
    """Robots that are to leave their paths and ask, and why."""
    request: Request | None = None
    answers: Mapping[str, PlanAnswer] = field(default_factory=dict)
    """For the pilots."""
    waits: Mapping[str, str] = field(default_factory=dict)
    """Sentences of waiting robots."""
    waits_for: Mapping[str, str] = field(default_factory=dict)
    """Robot awaited, if it is one."""
    holds: Mapping[str, str] = field(default_factory=dict)
    """Reasons not to move now."""
    errands: Mapping[str, Station] = field(default_factory=dict)
    """Robots that step aside, and the places that they come back to."""


def waits_of(
    members: Mapping[str, Member],
    held: Mapping[str, Held],
    refused: Mapping[str, str],
    aside: Container[str],
    asked: FleetRequest | None = None,
) -> tuple[dict[str, str], dict[str, str]]:
    """Sentences of waiting robots, and the one robot each of them waits for, if any.

    ``refused`` have no path yet; a robot driving ``aside`` waits for none. Until ``asked`` is
    answered, robots that drive stop where their waypoints end.
    """
    waits = {name: f"has no path yet: {why}" for name, why in refused.items()}
    waits_for = {}
    for name, one in members.items():
        if one.state is not State.DRIVING or name not in held or name in aside:
            continue
        count, gate = release_of(name, held)
        if gate is not None and held[name].executed >= count:
            x, y = held[name].promise.points[count].tolist()
            why = members[gate.other].waits_because if gate.other in members else "is gone"
            waits[name] = f"waits at ({x:.2f}, {y:.2f}) m for {gate.other}, which {why}"
            waits_for[name] = gate.other
        elif asked is not None and asked.driving and held[name].sent <= held[name].executed < count:
            who = ", ".join(traveller.name for traveller in asked.travellers)
            waits[name] = f"waits while a path is planned for {who}"
    return waits, waits_for


def holds_of(
    members: Mapping[str, Member],
    held: Mapping[str, Held],
    aside: Mapping[str, FloatArray],
    runaways: Container[str] = (),
) -> dict[str, str]:
    """Robots that may not drive now, and why: another robot is in the path, or may be anywhere.

    ``aside`` are the remaining places (n, 2) of lines aside. They were chosen with the runaways'
    motion, so only other robots stop those who drive them.
    """
    holds = {}
    known = {name: one for name, one in members.items() if name not in runaways}
    astray = [name for name, one in members.items() if one.at_large]
    for name, one in members.items():
        if one.state is State.DRIVING and astray and name not in astray:
            holds[name] = why_nobody_moves(members) or ""
            continue
        if one.state is not State.DRIVING or one.pose is None:
            continue
        if name in aside:
            way = np.vstack([one.pose[:2], aside[name][one.executed or 0 :]])
            near = comes_too_near(way, name, known | {name: one})
        elif name in held:
            near = comes_too_near(ahead(held, name, one.pose), name, members)
        else:
            continue
        if near is not None:
            holds[name] = near
    return holds


def ahead(held: Mapping[str, Held], name: str, here: tuple[float, float, float]) -> FloatArray:
    """Places (n >= 1, 2) from here through everything the robot may drive, or was given."""
    mine = held[name]
    count = max(release_of(name, held).targets, mine.sent)
    return np.vstack([here[:2], mine.promise.points[mine.executed + 1 : count + 1]])


def is_seen_there(one: Member, promise: Promise, executed: int) -> bool:
    """True if the camera sees the robot where its report places it."""
    if one.pose is None:
        return False
    around = promise.points[max(0, executed - 1) : executed + 2]
    return distance_to_polyline(around, one.pose[:2]) <= one.max_deviation_m
