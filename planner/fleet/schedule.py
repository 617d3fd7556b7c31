"""Goals that come at any time while others drive, planned against the promised tracks.

- A new goal is first planned among the promised tracks, behind everything sent: unless a parked
  robot cuts the arena apart, such a path always exists (COBRA; Cap et al., ICRA 2015).
- If that fails, or several goals come at once, all keep their promises to the end, and then the
  fleet is planned as a whole: robots parked in the path step aside, or there is a reason.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.fleet.execution import deadlocked, releases
from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
from planner.fleet.ground.shared_graph import GroundPlaces, lay_places, with_paths
from planner.fleet.motions.interval_search_kernels import HORIZON, find_way
from planner.fleet.on_graph import check_effort
from planner.fleet.on_roadmap import (
    Grounds,
    check_places,
    check_radii,
    check_speeds,
    check_walls,
    check_zones,
    plan_fleet,
    team_on,
)
from planner.fleet.retiming import moves_of, retimed
from planner.fleet.search.fleet_search import (
    Effort,
    OutOfTime,
    checked_tracks,
    touching,
    track_of,
)
from planner.fleet.search.team import Route
from planner.motion.trajectory import default_limits
from planner.path import Limits, NoPath
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray
from planner.shared.arguments import of_kind
from planner.shared.search_clock import Clock, search_clock_s
from planner.zones.zone import Zone

ZONE = 8.0
"""Discs in a gap's length that keep a sent piece free: 0.2 % wider than the piece."""
BEFORE_S = 1e6
"""Time before a plan's beginning from which sent pieces are kept free."""
WAITS_IN_A_CIRCLE = (
    "the robots pass shared places all at once: no goal can be added until they have"
)


@dataclass(frozen=True, slots=True)
class FleetSchedule:
    """Promised tracks of a fleet on one roadmap, immutable; nothing sent is taken back.

    ``plan`` holds tracks and dependencies from now on; ``sent`` is the row of each track up to
    which waypoints were sent. ``changed`` are the robots with a new path.
    """

    plan: FleetPlan
    sent: tuple[int, ...]
    changed: tuple[int, ...]
    roadmap: Roadmap
    radii: tuple[float, ...]
    speeds: tuple[float, ...]
    zones: tuple[tuple[Zone, ...], ...]
    _base: GroundPlaces
    _grounds: Grounds

    @staticmethod
    def parked(
        roadmap: Roadmap,
        places: Sequence[Sequence[float]],
        radii: float | Sequence[float] | None = None,
        limits: Limits | Sequence[Limits] | None = None,
        zones: Sequence[Sequence[Zone]] | None = None,
    ) -> FleetSchedule:
        """Return the schedule of robots all at rest; options as in :func:`planner.plan_fleet`.

        ``ValueError`` on senseless input or robots that touch each other or a border.
        """
        of_kind("roadmap", roadmap, Roadmap)
        at = check_places("places", places)
        if not len(at):
            raise ValueError("places: must hold a robot at least")
        sizes = check_radii(radii, roadmap.radius, len(at))
        speeds = check_speeds(limits, sizes)
        ruled = check_zones(zones, len(at))
        refused = touching("places", at, sizes)
        if refused is not None:
            raise ValueError(refused.reason)
        for i, clearance in enumerate(roadmap.clearance(at).tolist()):
            if clearance < sizes[i] * (1.0 - 1e-9):
                raise ValueError(
                    f"places[{i}]: its clearance is {clearance:g}, must be {sizes[i]:g} (radius)"
                )
        tracks = [np.array([[0.0, x, y]]) for x, y in at.tolist()]
        grounds, smallest = Grounds(roadmap), min(sizes)
        base = lay_places(
            grounds.walls(smallest), [at[i : i + 1] for i in range(len(at))], sizes,
            chains=grounds.closed(smallest, ruled),
        )  # fmt: skip
        return FleetSchedule(
            _plan(tracks, sizes), (0,) * len(at), (), roadmap, tuple(sizes), tuple(speeds),
            tuple(ruled), base, grounds,
        )  # fmt: skip

    @staticmethod
    def of(
        roadmap: Roadmap,
        plan: FleetPlan,
        radii: float | Sequence[float] | None = None,
        limits: Limits | Sequence[Limits] | None = None,
        zones: Sequence[Sequence[Zone]] | None = None,
    ) -> FleetSchedule:
        """Return the schedule of a plan of :func:`planner.plan_fleet` with nothing sent yet."""
        starts = [track[0, 1:].tolist() for track in plan.tracks]
        return replace(FleetSchedule.parked(roadmap, starts, radii, limits, zones), plan=plan)

    def with_goals(
        self,
        goals: Mapping[int, Sequence[float]],
        passed: Sequence[int] | None = None,
        sent: Sequence[int] | None = None,
        *,
        time_limit_s: float = 30.0,
        clock: Clock = search_clock_s,
    ) -> FleetSchedule | NoFleetPlan:
        """Return the schedule from now on with new goals for some robots, or a reason for none.

        Robots on each other's goals get a schedule together, but none one after the other.

        ``passed`` is the row that each robot reached last, by default its start, ``sent`` the last
        that it was given, by default ``passed``; new tracks begin at ``passed`` and are the same up
        to ``sent``. ``ValueError`` if :func:`planner.fleet.execution.releases` did not allow what
        was sent. ``clock`` gives the seconds of the time limit.
        """
        effort = check_effort(time_limit_s, 0, 0, clock)
        places = {robot: check_places("goal", [goal]) for robot, goal in goals.items()}
        for robot in places:
            if not 0 <= robot < len(self.radii):
                raise ValueError(f"robot = {robot}: must be 0 to {len(self.radii) - 1}")
        begun = [0] * len(self.radii) if passed is None else list(passed)
        given = list(begun) if sent is None else list(sent)
        self._check_sent(begun, given)
        now = retimed(self.plan, begun)
        if now is None:
            return NoFleetPlan(WAITS_IN_A_CIRCLE, deadlocked(self.plan), proved=False)
        tracks = [track for track, _ in now]
        kept = tuple(number[row] for (_, number), row in zip(now, given, strict=True))
        ends = np.array([track[-1, 1:] for track in tracks])
        for robot, place in places.items():
            ends[robot] = place[0]
        refused = touching("goals", ends, self.radii)
        if refused is not None:
            return refused
        new = None
        try:
            for robot, place in places.items():
                alone = self._alone(robot, tracks[robot], kept[robot], place, effort.check)
                if isinstance(alone, NoFleetPlan):
                    return alone
                if len(places) == 1:
                    new = self._among_promises(robot, tracks, kept, alone, effort.check)
        except OutOfTime:
            return effort.out_of_time(tuple(places))
        return new or self._after_promises(tracks, kept, ends, effort)

    def _check_sent(self, passed: Sequence[int], sent: Sequence[int]) -> None:
        allowed = releases(self.plan, passed)
        if len(sent) != len(allowed):
            raise ValueError(f"{len(sent)} rows sent for {len(allowed)} robots: must be one each")
        for i, (row, begun, release) in enumerate(zip(sent, passed, allowed, strict=True)):
            most = max(release.row, begun)
            if not begun <= row <= most:
                raise ValueError(f"sent[{i}] = {row}: must be a row that was allowed, to {most}")

    def _alone(
        self, robot: int, track: FloatArray, kept: int, goal: FloatArray, check: Callable[[], None]
    ) -> FloatArray | NoFleetPlan:
        begin = track[kept, 1:]
        size, speed, own = self.radii[robot], self.speeds[robot], self.zones[robot]
        path = self._grounds.path(begin, goal[0], size, speed, own, check)
        if isinstance(path, NoPath):
            return NoFleetPlan(f"robot {robot}: no path even alone: {path.reason}", (robot,))
        return np.concatenate([begin[None], path.points[1:-1], goal])

    def _among_promises(
        self,
        robot: int,
        tracks: list[FloatArray],
        kept: tuple[int, ...],
        path: FloatArray,
        check: Callable[[], None],
    ) -> FleetSchedule | None:
        size, speed = self.radii[robot], self.speeds[robot]
        smallest = self._grounds.walls(min(self.radii))
        shared = with_paths(smallest, self._base, [path], self.radii)
        own = self.zones[robot]
        one = next(team_on(shared, [size], [speed], self._grounds, [own], [path], check))
        prefix = tracks[robot][: kept[robot] + 1]
        ready_s = float(prefix[-1, 0])
        others = [j for j in range(len(tracks)) if j != robot]
        moves = [moves_of(tracks[j], self.radii[j] + size) for j in others]
        zones = [_zone(tracks[j][: kept[j] + 1], self.radii[j] + size) for j in others]
        for rows in ([*moves, *zones], moves):
            among = np.concatenate([*rows, np.empty((0, 7))])
            among[:, 4] -= ready_s
            among = among[among[:, 4] + among[:, 5] > 0.0]
            way, arrivals, departures = find_way(
                one.graph, one.to_goal, one.start, one.goal, among, HORIZON
            )
            if not len(way):
                continue
            new = track_of(one, Route(way, arrivals, departures, np.empty((0, 7)))).copy()
            new[:, 0] += ready_s
            joined = [*tracks]
            joined[robot] = np.concatenate([prefix, new[1:] if _same(prefix, new) else new])
            plan = _plan(joined, self.radii)
            if not _takes_back(plan, kept) and not deadlocked(plan):
                check_walls(self.roadmap, plan, self.radii)
                breach = self._grounds.zoned(size, speed, own).rules.breach(new[:, 1:])
                assert breach is None, f"the new path of robot {robot} {breach}"
                return replace(self, plan=plan, sent=kept, changed=(robot,))
        return None

    def _after_promises(
        self, tracks: list[FloatArray], kept: tuple[int, ...], ends: FloatArray, effort: Effort
    ) -> FleetSchedule | NoFleetPlan:
        left_s = effort.end_s - effort.clock()
        if left_s <= 0.0:
            return effort.out_of_time(range(len(tracks)))
        parked = [track[-1, 1:].tolist() for track in tracks]
        limits = [
            replace(default_limits(size), speed=speed)
            for size, speed in zip(self.radii, self.speeds, strict=True)
        ]
        later = plan_fleet(
            self.roadmap,
            parked,
            ends.tolist(),
            self.radii,
            limits,
            time_limit_s=left_s,
            clock=effort.clock,
            zones=self.zones,
        )
        if isinstance(later, NoFleetPlan):
            return later
        end_s = max(float(track[-1, 0]) for track in tracks)
        joined = []
        for track, after in zip(tracks, later.tracks, strict=True):
            rest = np.add(after, (end_s, 0.0, 0.0))
            joined.append(np.concatenate([track, rest]) if len(after) > 1 else track)
        changed = tuple(i for i, after in enumerate(later.tracks) if len(after) > 1)
        plan = _plan(joined, self.radii)
        plan = replace(plan, remarks=tuple(dict.fromkeys((*plan.remarks, *later.remarks))))
        return replace(self, plan=plan, sent=kept, changed=changed)


def _same(prefix: FloatArray, new: FloatArray) -> bool:
    return bool((prefix[-1] == new[0]).all())


def _plan(tracks: Sequence[FloatArray], radii: Sequence[float]) -> FleetPlan:
    for track in tracks:
        track.setflags(write=False)
    return checked_tracks(tracks, radii)


def _zone(track: FloatArray, gap: float) -> FloatArray:
    rows = []
    for (_, x, y), (until, u, v) in zip(track[:-1].tolist(), track[1:].tolist(), strict=True):
        parts = int(np.ceil(ZONE * np.hypot(u - x, v - y) / gap))
        wide = gap * float(np.hypot(1.0, 0.5 / ZONE))
        for share in np.linspace(0.0, 1.0, parts + 1).tolist() if parts else ():
            at = (x + share * (u - x), y + share * (v - y))
            rows.append((*at, 0.0, 0.0, -BEFORE_S, BEFORE_S + until, wide))
    return np.array(rows).reshape(-1, 7)


def _takes_back(plan: FleetPlan, sent: Sequence[int]) -> bool:
    return any(row < sent[waiting] for _, _, waiting, row in plan.dependencies)
