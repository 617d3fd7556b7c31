"""A roadmap with zones: it plans and measures as a roadmap does, and keeps the zones' rules.

- Keep-out zones are obstacles to the search only, in an updated roadmap of its own.
- Every path is checked against all rules as a whole before it is answered.
- A robot in a keep-out zone leaves it by the shortest path out first, which a remark reports.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from planner.borders.polyline import length_of
from planner.path import NoPath, Path
from planner.roadmap.roadmap import Clearance, Roadmap
from planner.route.plan_request import Request
from planner.route.whole_path import as_path
from planner.scene import FloatArray, Scene, SceneObject, Vec
from planner.shared.arguments import as_float, as_list, of_kind
from planner.shared.figures import sized
from planner.zones.lanes import cheapest
from planner.zones.rules import Rules, listed_zones, rules_for
from planner.zones.way_out import way_out
from planner.zones.zone import Zone
from planner.zones.zone_ground import ZoneGround

if TYPE_CHECKING:
    import networkx as nx

MOST_CLOSED = 4
"""Times that more one-way zones are closed for a connection: chosen, one for each that is met."""


def _go_on() -> None:
    """End no plan."""


@dataclass(frozen=True, slots=True)
class ZonedRoadmap:
    """A roadmap and its robot's zones; see :func:`with_zones`."""

    walls: Roadmap
    zones: tuple[Zone, ...]
    speed: float | None = None
    check: Callable[[], None] = field(default=_go_on, repr=False, compare=False)
    """Called before each piece of a plan's work; it may raise to end it."""
    _made: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def radius(self) -> float:
        """Radius of the robot."""
        return self.walls.radius

    @property
    def scene(self) -> Scene:
        """Scene without the zones."""
        scene = self.walls.scene
        assert isinstance(scene, Scene)
        return scene

    @property
    def rules(self) -> Rules:
        """The zones, indexed."""
        if "rules" not in self._made:
            self._made["rules"] = rules_for(self.zones, self.scene, self.radius, self.speed)
        return self._made["rules"]  # type: ignore[no-any-return]

    @property
    def closed(self) -> Roadmap:
        """Roadmap on which keep-out zones are obstacles."""
        return self._without(self.rules.of("keep_out"))

    @property
    def graph(self) -> nx.Graph[int]:
        """Graph of the ground that the robot may use."""
        return self.closed.graph

    def _without(self, shut: Sequence[ZoneGround]) -> Roadmap:
        key = tuple(sorted(one.zone.name for one in shut))
        if not key:
            return self.walls
        if key not in self._made:
            self.check()
            scene = with_objects(self.scene, [thing for one in shut for thing in one.objects])
            before: Roadmap = self._made.pop("before", self.walls)
            self._made[key] = before.updated(scene)
        return self._made[key]  # type: ignore[no-any-return]

    def updated(self, scene: Scene, walls: Roadmap | None = None) -> ZonedRoadmap:
        """Return it for another scene, as :meth:`Roadmap.updated`."""
        return self._changed(walls or self.walls.updated(scene), self.zones)

    def with_zones(self, zones: Sequence[Zone]) -> ZonedRoadmap:
        """Return it with other zones."""
        return self._changed(self.walls, tuple(zones))

    def _changed(self, walls: Roadmap, zones: tuple[Zone, ...]) -> ZonedRoadmap:
        changed = ZonedRoadmap(walls, zones, self.speed, self.check)
        if self.rules.of("keep_out"):
            changed._made["before"] = self.closed  # which differs by less than the walls do
        return changed

    def clearance(self, points: ArrayLike) -> FloatArray:
        """Exact clearance, as :meth:`Roadmap.clearance`."""
        return self.walls.clearance(points)

    def path_clearance(self, polyline: ArrayLike) -> Clearance:
        """Least distance of a polyline (n, 2), as :meth:`Roadmap.path_clearance`."""
        return self.walls.path_clearance(polyline)

    def permits(self, polyline: FloatArray, keep: float) -> bool:
        """True if a polyline (n, 2) keeps a distance from keep-out zones, and all rules."""
        return self.rules.permits(polyline, keep)

    def speed_limits(self, points: FloatArray, reach: FloatArray) -> FloatArray:
        """Highest speeds (n,) within ``reach`` of points, infinite without a limit."""
        return self.rules.speed_limits(points, reach)

    def plan(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        *,
        prefer: str | float = "balanced",
        via: Sequence[Sequence[float]] = (),
        order: Literal["fixed", "best"] = "fixed",
        alternatives: int = 0,
        margin: float = 0.0,
        relaxed: bool = False,
        near: Path | NoPath | None = None,
    ) -> Path | NoPath:
        """Plan a path that keeps the zones' rules, or explain why there is none.

        Arguments and errors are those of :meth:`Roadmap.plan`. Lanes and slow zones are weighed by
        their cost and time on the best path; ``alternatives`` weigh clear ground only. A refusal
        names the zone at fault.
        """
        kept: dict[str, Any] = {"prefer": prefer, "margin": margin, "relaxed": relaxed}
        if not self.zones:
            return self.walls.plan(
                start, goal, via=via, order=order, alternatives=alternatives, near=near, **kept
            )
        request = Request.of(start, goal, prefer, via, order, alternatives, margin, relaxed=relaxed)
        refused = self._refused(request)
        if refused is not None:
            return NoPath(refused)
        out, remark = self._way_out(request)
        if out is None:
            return NoPath(remark)
        begin: list[float] = [*out[-1].tolist(), *list(start)[2:]]
        found = self.closed.plan(
            begin, goal, via=via, order=order, alternatives=alternatives,
            near=near if len(out) == 1 else None, **kept
        )  # fmt: skip
        if isinstance(found, NoPath):
            return self._explained(found, begin, goal, via, kept)
        request = request.in_order(found.order)
        legs = self._legs(found, request)
        if isinstance(legs, str):
            return NoPath(legs)
        legs[0] = np.concatenate([out[:-1], legs[0]])
        best = self._as_path(legs, request, found.order)
        breach = self.rules.breach(best.points)
        if breach is not None:  # legs that each keep the rules may together break one
            return NoPath(f"the only path {breach}")
        others = tuple(
            self._as_path(_legs_of(other), request, other.order)
            for other in found.alternatives
            if self.rules.breach(other.points) is None and len(out) == 1
        )
        said = tuple(filter(None, (remark, *found.remarks)))
        return replace(best, alternatives=others, remarks=said)

    def _refused(self, request: Request) -> str | None:
        last = len(request.stations) - 1
        for number, place in enumerate(request.stations[1:], 1):
            name = "the goal" if number == last else f"station {number}"
            reason = self.rules.station_breach(name, place)
            if reason is not None:
                return reason
        return None

    def _way_out(self, request: Request) -> tuple[FloatArray | None, str]:
        """Polyline out of the keep-out zones around the start, of one place if there are none.

        None, with the reason, if no path leads out.
        """
        start = request.stations[0]
        shut = self.rules.of("keep_out")
        around = [one for one in shut if self.rules.is_held_by(one, start)]
        if not around:
            return np.array([start]), ""
        others = [one for one in shut if one not in around]
        need = self.radius + request.margin
        names = listed_zones(around)
        for keep in dict.fromkeys((need, self.radius)):
            line = way_out(self._without(others), self.closed, start, keep, self._is_with)
            if line is not None:
                length = sized(length_of(line), self.scene.units)
                return line, f"leaves {names} by the shortest path out, {length}"
        return None, f"the robot is in {names}, and no path leads out"

    def _is_with(self, line: FloatArray) -> bool:
        """True if a polyline (n, 2) is driven against no one-way zone."""
        return not self.rules.against(line)

    def _legs(self, found: Path, request: Request) -> list[FloatArray] | str:
        """Legs that keep all rules, at the least cost; or the sentence about a rule."""
        legs = _legs_of(found)
        if not self.rules.directed:
            return legs
        for number, ((a, b), leg) in enumerate(zip(pairwise(request.stations), legs, strict=True)):
            first = tuple(leg[0].tolist()) if number == 0 else a
            best = self._over_lanes((first[0], first[1]), b, leg, request)
            if best is None:
                against = listed_zones(self.rules.against(leg))
                return f"the only path leads against {against}"
            legs[number] = best
        return legs

    def _over_lanes(
        self, start: Vec, goal: Vec, direct: FloatArray, request: Request
    ) -> FloatArray | None:
        need = self.radius + request.margin

        def keeps(line: FloatArray) -> bool:
            self.check()
            closed = self.closed
            inside = float(closed.clearance(line[:1])[0])
            least = self.radius * (1.0 - 1e-9)
            free = min(inside, closed.path_clearance(line).distance) >= least
            return free and self._is_with(line)

        def connect(one: FloatArray, other: FloatArray) -> FloatArray | None:
            ends = (one[0], one[1]), (other[0], other[1])
            line = direct if ends == (start, goal) else None
            return self._connection(ends, line, request)

        if start == goal:
            return direct
        return cheapest(start, goal, self.rules, keeps, connect, need)

    def _connection(
        self, ends: tuple[Vec, Vec], line: FloatArray | None, request: Request
    ) -> FloatArray | None:
        """Connection that breaks no rule, and avoids slow zones where that is faster."""
        if line is None:
            line = self._free(self.closed, ends, request)
        shut = self.rules.of("keep_out")
        for _ in range(MOST_CLOSED):
            if line is None:
                return None
            against = [one for one in self.rules.against(line) if not self._holds(one, ends)]
            if not against:
                break
            shut = (*shut, *against)
            line = self._free(self._without(shut), ends, request)
        if line is None or self.rules.against(line):
            return None
        slow = [one for one in self.rules.of("slow") if not self._holds(one, ends)]
        if self.speed is not None and any(one.clearance(line) < self.radius for one in slow):
            around = self._free(self._without((*shut, *slow)), ends, request)
            if around is not None and not self.rules.against(around):
                return min((line, around), key=self.rules.cost)
        return line

    def _holds(self, one: ZoneGround, ends: tuple[Vec, Vec]) -> bool:
        return any(self.rules.is_held_by(one, end) for end in ends)

    def _free(self, roadmap: Roadmap, ends: tuple[Vec, Vec], request: Request) -> FloatArray | None:
        self.check()
        path = roadmap.plan(
            *ends, prefer=request.preference, margin=request.margin, relaxed=request.relaxed
        )
        return path.points if isinstance(path, Path) else None

    def _as_path(self, legs: list[FloatArray], request: Request, order: tuple[int, ...]) -> Path:
        whole = as_path(self.walls.borders, legs, self.radius, request, order)
        return replace(whole, scene=self.scene)

    def _explained(
        self,
        refused: NoPath,
        start: Sequence[float],
        goal: Sequence[float],
        via: Sequence[Sequence[float]],
        kept: dict[str, Any],
    ) -> NoPath:
        """Name the keep-out zones, if there is a path without them."""
        path = self.walls.plan(start, goal, via=via, **kept)
        if isinstance(path, NoPath):
            return path
        need = self.radius * (1.0 - 1e-6)
        met = [one for one in self.rules.of("keep_out") if one.clearance(path.points) < need]
        if not met:
            return refused
        return replace(refused, reason=f"the only path leads through {listed_zones(met)}")


def _legs_of(path: Path) -> list[FloatArray]:
    return [np.array(path.points[a : b + 1]) for a, b in pairwise(path.stations)]


def with_objects(scene: Scene, objects: Sequence[SceneObject]) -> Scene:
    """Scene with more objects, numbered last."""
    first = 1 + max((thing.id for thing in scene.objects), default=-1)
    more = (replace(one, id=first + i) for i, one in enumerate(objects))
    return replace(scene, objects=(*scene.objects, *more))


def with_zones(
    roadmap: Roadmap, zones: Sequence[Zone], *, speed: float | None = None
) -> ZonedRoadmap:
    """Return a roadmap that plans by the zones' rules too.

    ``zones`` are its robot's, in the units and frame of its scene. ``speed`` > 0 is the fastest
    that the robot drives, in units a second: with it, slow zones are driven around where that is
    faster. ``ValueError`` for a roadmap of anything but a scene.
    """
    of_kind("roadmap", roadmap, Roadmap)
    if not isinstance(roadmap.scene, Scene):
        raise ValueError("the roadmap's scene must be a Scene: zones are added to it")
    given = tuple(of_kind("zones", one, Zone) for one in as_list("zones", zones, "Zone"))
    names = [one.name for one in given]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"zones: two zones have the name {name!r}")
    if speed is not None and not as_float("speed", speed) > 0.0:
        raise ValueError(f"speed = {speed:g}: must be > 0")
    return ZonedRoadmap(roadmap, given, speed)
