"""From a fleet's plan to promises: each robot's targets, and gates at shared places.

- Every radius gets a margin, so that robots that follow their paths to within it never touch. It
  shrinks where starts, goals or walls are nearer.
- Corners are rounded where no robot comes too near (`rounding`): at sharp ones a robot stops.
- Tracks are cut into short pieces first, so that a robot waits no longer than it must.
- A robot without a path is left out and keeps its place; the others are planned around it.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

import planner
from navigation.fleet.refusals import because_of, with_names
from navigation.fleet.request import (
    FleetAnswer,
    FleetRequest,
    Gate,
    Promise,
    Taken,
    Traveller,
)
from navigation.fleet.rounding import CutTrack, rounded
from navigation.mission.mission import Station
from navigation.mission.targets import Target, drop_steered_heading, within_caps
from planner.borders.polyline import arc_lengths, length_of
from planner.fleet.dependencies import find_dependencies, is_live
from planner.fleet.fleet_plan import Dependency, FleetPlan, NoFleetPlan
from planner.fleet.no_waiting import wait_before
from planner.motion.trajectory import TrajectoryError
from planner.path import Limits, Path, Trajectory
from planner.roadmap.roadmap import Roadmap
from planner.scene import CircleRecord, FloatArray, Scene, SceneObject
from planner.shared.search_clock import Clock, search_clock_s
from planner.zones.rules import Rules, listed_zones, rules_for
from planner.zones.zone import Zone

PIECE_M: Final = 0.05
"""Spacing of targets, the default of `planning.waypoint_spacing_m`."""
SLACK_M: Final = 1e-4
"""Less room is none: a tenth of the camera's resolution."""
OVERLAP_M: Final = 0.003
"""Two poses' noise: robots that overlap by less are side by side."""
STANDS_M_S: Final = 1e-3
"""A slower waypoint is a stop."""
TIME_LIMIT_S: Final = 3.0
"""Time limit of one search; the robots stand still meanwhile."""
CAUSE_S: Final = 1.0
"""Time limit of finding the robots that a refusal depends on: chosen, a third of a search's."""
SEEDS: Final = 4
"""Beginnings tried until a plan does not need its timing."""
LESS_ROOM: Final = 0.3
"""Share of the distance between bodies, if no plan with all of it is live."""
ROUNDS: Final = 10
"""Rounds of shortening: 40 ms with six robots."""
NOT_LIVE: Final = "every plan that was found has robots wait for each other in a ring"


@dataclass(frozen=True, slots=True)
class Attempt:
    """Robots that are to move together, and the places that others keep meanwhile.

    ``roadmap`` is the smallest robot's in ``scene``; bodies are to be ``keep_m`` apart, and
    ``clock`` limits each search.
    """

    roadmap: Roadmap
    scene: Scene
    moving: tuple[Traveller, ...]
    taken: tuple[Taken, ...]
    keep_m: float
    clock: Clock

    def around_taken(self) -> Roadmap:
        """Roadmap with the taken places as round obstacles."""
        if not self.taken:
            return self.roadmap
        return self.roadmap.updated(with_taken(self.scene, self.taken, self.moving))

    def without(self, out: Traveller) -> Attempt:
        """The same with one robot that keeps its place instead."""
        moving = tuple(one for one in self.moving if one is not out)
        return replace(self, moving=moving, taken=(*self.taken, out.as_taken))


def plan_promises(
    roadmap: Roadmap,
    scene: Scene,
    request: FleetRequest,
    keep_m: float,
    clock: Clock = search_clock_s,
) -> FleetAnswer:
    """Make promises for all travellers that can move, bodies ``keep_m`` apart where that fits.

    If robots at rest without a mission block one, they step aside and come back. ``roadmap`` is the
    smallest robot's in ``scene``; ``clock`` limits each search.
    """
    taken = (*request.taken, *(one.as_taken for one in request.idle))
    first = Attempt(roadmap, scene, request.travellers, taken, keep_m, clock)
    answer = _plan_for(request, first)
    if not answer.refused or not request.idle:
        return answer
    everybody = (*request.travellers, *request.idle)
    more = _plan_for(request, replace(first, moving=everybody, taken=request.taken))
    asked = {one.name for one in request.travellers}
    if len(asked & more.refused.keys()) >= len(answer.refused):
        return answer
    standing = {one.name for one in request.idle}
    promises = {
        name: promise
        for name, promise in more.promises.items()
        if name in asked or len(promise.points) > 1
    }
    refused = {name: why for name, why in more.refused.items() if name not in standing}
    return FleetAnswer(request.id, request.scene_revision, promises, refused)


def _plan_for(request: FleetRequest, attempt: Attempt) -> FleetAnswer:
    """Promises for as many as can move, the others left out one by one."""
    refused: dict[str, str] = {}
    while attempt.moving:
        found = _try(attempt)
        if isinstance(found, dict):
            return FleetAnswer(request.id, request.scene_revision, found, refused)
        out, reason = found
        refused[out.name] = reason
        attempt = attempt.without(out)
    return FleetAnswer(request.id, request.scene_revision, {}, refused)


def _try(attempt: Attempt) -> dict[str, Promise] | tuple[Traveller, str]:
    """Promises, or the one to leave out and why."""
    moving = attempt.moving
    for one in moving:
        for other in attempt.taken:
            gap_m = math.dist((one.station.x, one.station.y), (other.x_m, other.y_m))
            if gap_m < one.radius_m + other.radius_m:
                return one, f"{other.name} is at its goal"
    here = attempt.around_taken()
    found = _ordered(here, attempt)
    if isinstance(found, NoFleetPlan):
        who = found.blocking or tuple(range(len(moving)))
        reason = with_names(found.reason, [one.name for one in moving])
        if found.proved:
            reason += in_the_way(replace(attempt, moving=tuple(moving[i] for i in who)))
        return moving[who[-1]], reason
    tracks, waits, sizes = found
    promises = {}
    numbers = [point_numbers(track.targets) for track in tracks]
    for j, one in enumerate(moving):
        last = int(numbers[j][-1])
        gates = [
            Gate(int(numbers[j][row]), moving[i].name, _number(numbers[i], passed))
            for i, passed, waiting, row in waits
            if waiting == j and row < len(numbers[j]) and numbers[j][row] < last
        ]
        margin_m = sizes[j] - one.radius_m - SLACK_M  # chords of rounded corners: 25 um nearer
        try:
            promises[one.name] = make_promise(here, one, tracks[j], gates, margin_m)
        except TrajectoryError as error:
            return one, str(error)
    return promises


def in_the_way(attempt: Attempt) -> str:
    """End of the sentence that refuses an attempt's robots: the taken places it depends on.

    Empty if that is not known within ``CAUSE_S``.
    """
    moving, clock = attempt.moving, attempt.clock
    end_s = clock() + CAUSE_S

    def is_refused(names: Sequence[str]) -> bool:
        named = tuple(one for one in attempt.taken if one.name in names)
        here = replace(attempt, taken=named).around_taken()
        sizes = _sizes(here, moving, LESS_ROOM * attempt.keep_m)
        left_s = end_s - clock()
        plan = _plan(here, moving, sizes, clock, time_limit_s=left_s) if left_s > 0.0 else None
        if plan is None or (isinstance(plan, NoFleetPlan) and not plan.proved):
            raise TimeoutError
        return isinstance(plan, NoFleetPlan)

    try:
        return because_of((one.name for one in attempt.taken), is_refused)
    except TimeoutError:
        return ""


def _plan(
    here: Roadmap,
    moving: Sequence[Traveller],
    sizes: Sequence[float],
    clock: Clock,
    seed: int = 0,
    time_limit_s: float = TIME_LIMIT_S,
) -> FleetPlan | NoFleetPlan:
    return planner.plan_fleet(
        here,
        [one.start[:2] for one in moving],
        [(one.station.x, one.station.y) for one in moving],
        radii=sizes,
        limits=[one.limits for one in moving],
        time_limit_s=time_limit_s,
        improve=ROUNDS,
        seed=seed,
        clock=clock,
        zones=[one.zones for one in moving],
    )


def _ordered(
    here: Roadmap, attempt: Attempt
) -> tuple[list[CutTrack], list[Dependency], list[float]] | NoFleetPlan:
    """Tracks in short pieces, a live order at shared places, and the radii planned with.

    Without a live order, less distance between bodies is tried, then other seeds.
    """
    moving, clock = attempt.moving, attempt.clock
    refused: NoFleetPlan | None = None
    zones = [one.zones for one in moving]
    for share, seed in ((1.0, 0), (LESS_ROOM, 0), *((1.0, seed) for seed in range(1, SEEDS))):
        sizes = _sizes(here, moving, share * attempt.keep_m)
        plan = _plan(here, moving, sizes, clock, seed)
        if isinstance(plan, FleetPlan):
            rules = rules_of(here, zones, sizes)
            as_planned = [CutTrack.of(track, PIECE_M) for track in plan.tracks]
            bends = {i: one.limits.turning_radius for i, one in enumerate(moving)}
            for cut in (rounded(here, as_planned, sizes, PIECE_M, bends, rules), as_planned):
                tracks = [one.targets for one in cut]
                waits = wait_before(tracks, find_dependencies(tracks, sizes), rules)
                if is_live(tracks, waits):
                    return cut, waits, sizes
            refused = refused or NoFleetPlan(NOT_LIVE, proved=False)
        elif seed == 0:
            refused = plan
            if share < 1.0:
                return refused
    return refused or NoFleetPlan(NOT_LIVE, proved=False)


def rules_of(
    here: Roadmap, zones: Sequence[tuple[Zone, ...]], sizes: Sequence[float]
) -> list[Rules]:
    """Index each robot's zones for its planned radius."""
    assert isinstance(here.scene, Scene)
    scene = here.scene
    return [rules_for(own, scene, size) for own, size in zip(zones, sizes, strict=True)]


def make_promise(
    here: Roadmap, one: Traveller, track: CutTrack, gates: Sequence[Gate], margin_m: float
) -> Promise:
    """Promise of one robot's track; ``TrajectoryError`` if the robot cannot drive it."""
    numbers = point_numbers(track.fine)
    smooth = np.ascontiguousarray(track.fine[np.unique(numbers, return_index=True)[1], 1:])
    at = np.unique(numbers[track.rows])
    points = np.ascontiguousarray(smooth[at])
    (rules,) = rules_of(here, [one.zones], [one.radius_m])
    path = path_of(here, points, one)
    left = [zone for zone in rules.of("keep_out") if rules.is_held_by(zone, one.start[:2])]
    if left and len(points) > 1:
        said = f"leaves {listed_zones(left)} by the shortest path out"
        path = replace(path, remarks=(said,))
    trajectory = None
    if len(points) > 1:
        driven = path_of(here, smooth, one)
        if not one.limits.turns_on_spot:
            headings = (one.start[2], *driven.headings_rad[1:])
            driven = drop_steered_heading(replace(driven, headings_rad=headings))
        trajectory = planner.time_path(
            driven,
            one.limits,
            clearance=here.clearance,
            dwell_s=[0.0, one.station.dwell_s],
            speed_limits=rules.speed_limits,
        )
    targets = _targets(points, arc_lengths(smooth)[at], trajectory, one.station, one.limits)
    targets = within_caps((float(points[0, 0]), float(points[0, 1])), targets, rules)
    return Promise(
        one.name,
        one.station,
        points,
        targets,
        tuple(gates),
        path,
        trajectory,
        one.radius_m,
        margin_m,
    )


def path_of(roadmap: Roadmap, points: FloatArray, one: Traveller) -> Path:
    """Polyline as a path with its clearances."""
    found = roadmap.path_clearance(points)
    clearances = roadmap.clearance(points)
    for array in (points, clearances):
        array.flags.writeable = False
    nearest = int(clearances.argmin())
    least, at = found.distance, found.at
    if clearances[nearest] < least:
        least, at = (
            float(clearances[nearest]),
            (float(points[nearest, 0]), float(points[nearest, 1])),
        )
    return Path(
        points=points,
        clearances=clearances,
        length=length_of(points),
        min_clearance=least,
        min_clearance_at=at,
        robot_radius=one.radius_m,
        stations=(0, len(points) - 1),
        headings_rad=(None, one.station.heading_rad),
    )


def _targets(
    points: FloatArray,
    along: FloatArray,
    trajectory: Trajectory | None,
    station: Station,
    limits: Limits,
) -> tuple[Target, ...]:
    """A target at every point except the first; one if the robot is there already.

    ``along`` (n,): distance of each point along the trajectory's path.
    """
    (x, y) = points[-1].tolist()
    end = Target(x, y, limits.speed, True, station.heading_rad, station.dwell_s, 1)
    if trajectory is None or len(points) < 2:
        return (end,)
    way = np.array([(w.x, w.y) for w in trajectory.waypoints])
    speeds = np.array([w.speed for w in trajectory.waypoints])
    along_way = arc_lengths(way)
    along_way *= along[-1] / max(along_way[-1], 1e-12)
    at = np.interp(along, along_way, speeds)
    targets = [
        Target(px, py, 0.0 if v < STANDS_M_S else v, bool(v < STANDS_M_S))
        for (px, py), v in zip(points[1:-1].tolist(), at[1:-1].tolist(), strict=True)
    ]
    return (*targets, replace(end, speed_m_s=0.0))


def point_numbers(track: FloatArray) -> FloatArray:
    """Number of each row's place along the track; rows at one place share it."""
    moves = np.any(track[1:, 1:] != track[:-1, 1:], axis=1)
    return np.concatenate([[0], np.cumsum(moves)]).astype(np.int64)


def _number(numbers: FloatArray, row: int) -> int:
    return int(numbers[min(row, len(numbers) - 1)])


def _sizes(here: Roadmap, moving: Sequence[Traveller], keep_m: float) -> list[float]:
    margins = [0.5 * keep_m] * len(moving)
    for i, j in combinations(range(len(moving)), 2):
        a, b = moving[i], moving[j]
        both_m = a.radius_m + b.radius_m
        goals_m = math.dist((a.station.x, a.station.y), (b.station.x, b.station.y))
        apart_m = min(math.dist(a.start[:2], b.start[:2]), goals_m)
        for k in (i, j):
            margins[k] = min(margins[k], 0.5 * (apart_m - both_m) - SLACK_M)
    sizes = []
    for one, margin_m in zip(moving, margins, strict=True):
        ends = np.array([one.start[:2], (one.station.x, one.station.y)])
        room_m = float(here.clearance(ends).min()) - one.radius_m - SLACK_M
        sizes.append(one.radius_m + max(min(margin_m, room_m), -OVERLAP_M))
    return sizes


def with_taken(scene: Scene, taken: Sequence[Taken], moving: Sequence[Traveller]) -> Scene:
    """Scene with taken places as round obstacles, smaller where a moving robot is beside one."""
    first = 1 + max((thing.id for thing in scene.objects), default=-1)
    things = []
    for i, one in enumerate(taken):
        at = (one.x_m, one.y_m)
        room_m = min(
            (math.dist(at, m.start[:2]) - m.radius_m - 2.0 * SLACK_M for m in moving),
            default=math.inf,
        )
        radius_m = min(one.radius_m, room_m)
        if radius_m > 0.0:
            things.append(SceneObject(first + i, (CircleRecord(at, radius_m),)))
    return replace(scene, objects=(*scene.objects, *things))
