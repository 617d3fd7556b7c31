"""Scripted events in the simulated arena: robots drive past, obstacles come and go.

Times count from the beginning of the run. Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from navigation.config import Config
from navigation.config.simulation import SimulatedObstacleSection, SimulatedTrackSection
from navigation.simulator.arena import SimulatedArena
from planner.formats.scene_io import read_scene_text
from planner.scene import FloatArray, SceneError, SceneObject, Vec

TURN_RATE_RAD_S = 2.0
"""Rate at which another robot turns on the spot."""


@dataclass(frozen=True, slots=True, eq=False)
class ScriptedTrack:
    """Pose of a robot over time: ``knots`` (n, 4) of time_s, x_m, y_m, unwrapped heading_rad.

    ``back_and_forth``: it drives the track back from the end, and so on.
    """

    knots: FloatArray
    start_s: float
    back_and_forth: bool

    def pose(self, since_s: float) -> tuple[float, float, float]:
        """Return (x, y, heading) at ``since_s`` after the beginning."""
        gone_s, whole_s = max(0.0, since_s - self.start_s), float(self.knots[-1, 0])
        if self.back_and_forth and whole_s > 0.0:
            gone_s %= 2.0 * whole_s
            gone_s = min(gone_s, 2.0 * whole_s - gone_s)
        times = self.knots[:, 0]
        x, y, heading = (float(np.interp(gone_s, times, self.knots[:, i])) for i in (1, 2, 3))
        return x, y, math.remainder(heading, math.tau)


def scripted_track(section: SimulatedTrackSection) -> ScriptedTrack:
    """Track of a configured robot: straight from place to place, turning on the spot."""
    places = [(place.x_m, place.y_m) for place in section.track]
    heading = _direction(*places[:2]) if len(places) > 1 else 0.0
    knots = [(0.0, *places[0], heading)]
    for a, b in pairwise(places):
        turn = math.remainder(_direction(a, b) - heading, math.tau)
        heading += turn
        turned_s = knots[-1][0] + abs(turn) / TURN_RATE_RAD_S
        knots.append((turned_s, *a, heading))
        knots.append((turned_s + math.dist(a, b) / section.speed_m_s, *b, heading))
    return ScriptedTrack(np.array(knots), section.start_s, section.back_and_forth)


def _direction(a: Vec, b: Vec) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])


def tracks_of(config: Config) -> dict[int, ScriptedTrack]:
    """Scripted tracks by marker id."""
    if config.simulation is None:
        return {}
    return {one.marker_id: scripted_track(one) for one in config.simulation.other_robots}


def arenas_over_time(config: Config, arena: SimulatedArena) -> list[tuple[float, SimulatedArena]]:
    """The arena with its present obstacles, each from its time after the beginning.

    The first begins at 0. Raises ``SceneError`` for an unreadable record.
    """
    sections = () if config.simulation is None else config.simulation.obstacles
    things = [(section, object_of(section, arena)) for section in sections]
    times = {0.0, *(s.from_s for s in sections)}
    times |= {s.until_s for s in sections if s.until_s is not None}
    return [(at_s, _with(arena, things, at_s)) for at_s in sorted(times)]


def object_of(section: SimulatedObstacleSection, arena: SimulatedArena) -> SceneObject:
    """Obstacle of a record; ``SceneError`` if unreadable or not exactly one."""
    try:
        scene = read_scene_text(f"#@ clearway.scene/1\n#@ units m\n{section.record}\n", "record")
    except SceneError as error:
        # the record has no place in a file to cite
        raise SceneError(re.sub(r"^record:\d+:\d+: ", "", str(error))) from None
    if len(scene.objects) != 1:
        raise SceneError(f"must be one record, not {len(scene.objects)}")
    number = 1 + max((thing.id for thing in arena.scene.objects), default=-1)
    return replace(scene.objects[0], id=number)


def _with(
    arena: SimulatedArena,
    things: Sequence[tuple[SimulatedObstacleSection, SceneObject]],
    at_s: float,
) -> SimulatedArena:
    there = [
        thing
        for section, thing in things
        if section.from_s <= at_s and (section.until_s is None or at_s < section.until_s)
    ]
    first = 1 + max((thing.id for thing in arena.scene.objects), default=-1)
    numbered = tuple(replace(thing, id=first + i) for i, thing in enumerate(there))
    return replace(arena, scene=replace(arena.scene, objects=(*arena.scene.objects, *numbered)))
