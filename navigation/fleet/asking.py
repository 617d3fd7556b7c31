"""Request of the robots that ask for a path: travellers, driving robots, and taken places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from navigation.fleet.members import Member, places_kept
from navigation.fleet.releases import Held
from navigation.fleet.request import Driving, FleetRequest, Taken, Traveller
from navigation.fleet.runaways import Runaway
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from navigation.mission.traffic import AHEAD_S

SOON: Final = 4
"""Places that a plan keeps free of a runaway, within ``AHEAD_S``."""


def request_of(
    number: int,
    revision: int,
    members: Mapping[str, Member],
    held: Mapping[str, Held],
    wishes: Mapping[str, PlanRequest],
    driving: tuple[Driving, ...],
    runaways: Sequence[Runaway],
) -> FleetRequest:
    """Request of the robots with a wish; every robot was seen."""
    travellers = tuple(
        Traveller(
            name,
            pose,
            request.stations[0],
            one.radius_m,
            one.limits_at(request),
            request.stations if request.any_order else (),
        )
        for name, request in sorted(wishes.items())
        if (one := members[name]) and (pose := one.pose) is not None
    )
    idle = tuple(
        Traveller(name, pose, Station(*pose), one.radius_m, one.limits)
        for name, one in members.items()
        if name not in wishes and one.obliging and (pose := one.pose) is not None
    )
    known = {*wishes, *(one.promise.name for one in driving), *(one.name for one in idle)}
    taken = [
        place
        for name, one in members.items()
        if name not in known
        for place in places_kept(name, one, held.get(name))
    ]
    taken += [place for one in runaways for place in _soon(one)]
    strangers = {
        disc.robot_id: Taken(f"robot {disc.robot_id}", disc.x_m, disc.y_m, disc.radius_m)
        for request in wishes.values()
        for disc in request.avoid
    }
    taken += strangers.values()
    return FleetRequest(number, revision, travellers, tuple(taken), driving, idle)


def _soon(one: Runaway) -> Iterator[Taken]:
    for x, y in one.places(np.linspace(0.0, AHEAD_S, SOON)).tolist():
        yield Taken(one.name, x, y, one.radius_m)
