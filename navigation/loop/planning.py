"""The daemon's planner: from the newest scene and a request to a plan. Metres, radians, seconds."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, Literal, Protocol, TypeVar

import numpy as np

import planner
from navigation.fleet.refusals import because_of
from navigation.fleet.request import FleetRequest
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Station
from navigation.mission.targets import drop_steered_heading, targets_of, within_caps
from navigation.mission.traffic import Disc
from navigation.shared.supervisor import in_words
from planner.motion.smooth import SmoothError, smooth_path
from planner.motion.trajectory import TrajectoryError
from planner.path import Limits, NoPath, Path
from planner.roadmap.roadmap import Roadmap
from planner.scene import CircleRecord, FloatArray, Scene, SceneObject, Vec
from planner.zones.rules import Rules
from planner.zones.zone import Zone, zones_for
from planner.zones.zoned_roadmap import ZonedRoadmap, with_objects, with_zones

LONGEST_WAIT_S = 0.25
"""Longest wait of an idle planner, which distinguishes it from one that hangs."""


@dataclass(frozen=True, slots=True)
class PlanSettings:
    """Requirements on a plan, from the configuration."""

    radius_m: float
    margin_m: float
    spacing_m: float | None
    prefer: str | float
    limits: Limits
    margin: Literal["relaxed", "strict"] = "relaxed"
    """Treatment of a start or goal within the margin: planned from and to, or refused."""


@dataclass(frozen=True, slots=True)
class SceneCheck:
    """A scene's revision, and the running path's clearance in it."""

    revision: int
    path_clearance_m: float | None
    zones_changed: bool = False
    """True if the zones differ from the last ones."""
    zones: tuple[Zone, ...] = ()
    """Zones in force, of all robots."""


class ArenaPlanner:
    """Roadmap of the newest scene with the zones for robot ``name``, and answers from it."""

    def __init__(self, settings: PlanSettings, name: str = "") -> None:
        self.settings, self.name = settings, name
        self.revision = 0
        self.zoned: ZonedRoadmap | None = None
        self._scene: Scene | None = None
        self._stations: tuple[Station, ...] = ()
        self._way: Path | None = None
        """Path of the last answer through ``_stations``."""

    def see(self, scene: Scene, revision: int, zones: Sequence[Zone] = ()) -> None:
        """Take over a scene and its zones; only their changes change the roadmap."""
        known, mine = self.zoned, zones_for(zones, self.name)
        if known is None:
            speed_m_s = self.settings.limits.speed
            known = with_zones(self._build(scene), mine, speed=speed_m_s)
        elif scene is not self._scene:
            known = known.updated(scene)
        self.zoned = known if known.zones == mine else known.with_zones(mine)
        self._scene = scene
        self.revision = revision

    @property
    def roadmap(self) -> Roadmap | None:
        """Newest roadmap, without zones; None before the first scene."""
        return None if self.zoned is None else self.zoned.walls

    def _build(self, scene: Scene) -> Roadmap:
        return planner.build_roadmap(scene, self.settings.radius_m, spacing=self.settings.spacing_m)

    def answer(self, request: PlanRequest, *, preview: bool = False) -> PlanAnswer:
        """Plan from the request's start through its stations; `NoPath` gives the reason.

        Among paths equal within noise the one of the last answer through these stations wins; a
        ``preview`` is no such answer. A failure of the planner gives `NoPath`.
        """
        try:
            return self._answer(request, preview=preview)
        except (SmoothError, TrajectoryError) as error:  # no path for this robot and its limits
            return PlanAnswer(request.id, self.revision, NoPath(str(error)))
        except Exception as error:  # noqa: BLE001 - said where the answer is, which is asked again
            reason = f"the planner failed on this request ({in_words(error)})"
            return PlanAnswer(request.id, self.revision, NoPath(reason))

    def _answer(self, request: PlanRequest, *, preview: bool) -> PlanAnswer:
        roadmap, scene = self.zoned, self._scene
        if roadmap is None or scene is None:
            return PlanAnswer(request.id, 0, NoPath("no scene was seen yet"))
        roadmap, path = self._around_robots(roadmap, scene, request)
        if isinstance(path, NoPath):
            return PlanAnswer(request.id, self.revision, path)
        *vias, goal = request.stations
        if not preview:
            self._way, self._stations = path, request.stations
            if request.any_order:
                self._stations = (*(vias[i] for i in path.order), goal)
        visits = [vias[i] for i in path.order] if request.any_order else vias
        limits = self.settings.limits
        if request.speed_m_s is not None:
            limits = replace(limits, speed=min(limits.speed, request.speed_m_s))
        path = smooth_path(
            path,
            roadmap.path_clearance,
            roadmap.clearance,
            keep=self.settings.radius_m + self.settings.margin_m,
            turning_radius=limits.turning_radius,
            permits=roadmap.permits,
        )
        trajectory = planner.time_path(
            path if limits.turns_on_spot else drop_steered_heading(path),
            limits,
            clearance=roadmap.clearance,
            dwell_s=[0.0, *(s.dwell_s for s in visits), goal.dwell_s],
            speed_limits=roadmap.speed_limits if roadmap.zones else None,
        )
        targets = within_caps(request.start[:2], targets_of(path, trajectory), roadmap.rules)
        return PlanAnswer(request.id, self.revision, path, trajectory, targets)

    def _around_robots(
        self, roadmap: ZonedRoadmap, scene: Scene, request: PlanRequest
    ) -> tuple[ZonedRoadmap, Path | NoPath]:
        """The route and its roadmap: around all robots, or at least around those at rest.

        The robot waits for moving robots when it meets them. A refusal names those at rest that it
        depends on.
        """

        def is_refused(names: Sequence[str]) -> bool:
            left = [disc for disc in standing if _name_of(disc) in names]
            here = roadmap.updated(with_discs(scene, left)) if left else roadmap
            return isinstance(self._route(here, request), NoPath)

        standing = tuple(disc for disc in request.avoid if not disc.moves)
        for discs in dict.fromkeys((request.avoid, standing)):
            here = roadmap.updated(with_discs(scene, discs)) if discs else roadmap
            path = self._route(here, request)
            if isinstance(path, Path):
                break
        if isinstance(path, NoPath):
            cause = because_of(map(_name_of, standing), is_refused)
            path = replace(path, reason=f"{path.reason}{cause}")
        return here, path

    def path_clearance_m(self, points: FloatArray) -> float | None:
        """Exact clearance of a polyline in the newest scene; None before the first."""
        if self.roadmap is None:
            return None
        return self.roadmap.path_clearance(points).distance

    def clearance_m(self, position: Vec) -> float | None:
        """Exact clearance of a place in the newest scene; None before the first."""
        if self.roadmap is None:
            return None
        return float(self.roadmap.clearance(np.array([position]))[0])

    def rules(self, _robot: str) -> Rules | None:
        """Zones for its robot in the newest scene; None before the first."""
        return None if self.zoned is None else self.zoned.rules

    def _route(self, roadmap: ZonedRoadmap, request: PlanRequest) -> Path | NoPath:
        *vias, goal = [
            (s.x, s.y) if s.heading_rad is None else (s.x, s.y, s.heading_rad)
            for s in request.stations
        ]

        return roadmap.plan(
            request.start,
            goal,
            via=vias,
            order="best" if request.any_order else "fixed",
            prefer=self.settings.prefer,
            margin=self.settings.margin_m,
            relaxed=self.settings.margin == "relaxed",
            near=self._last_way(request),
        )

    def _last_way(self, request: PlanRequest) -> Path | None:
        """Last path, if the request is for the rest of the same stations in order."""
        rest = self._stations[-len(request.stations) :]
        return self._way if rest == request.stations and not request.any_order else None


def _name_of(disc: Disc) -> str:
    return f"robot {disc.robot_id}"


def with_discs(scene: Scene, discs: Sequence[Disc]) -> Scene:
    """The scene with other robots as round obstacles."""
    robots = [
        SceneObject(0, (CircleRecord((disc.x_m, disc.y_m), disc.radius_m),)) for disc in discs
    ]
    return with_objects(scene, robots)


_Q = TypeVar("_Q")
_A = TypeVar("_A")
_Q_contra = TypeVar("_Q_contra", contravariant=True)
_A_co = TypeVar("_A_co", covariant=True)


class Answering(Protocol[_Q_contra, _A_co]):
    """Planner for one robot or for a fleet."""

    def see(self, scene: Scene, revision: int, zones: Sequence[Zone] = ()) -> None:
        """Take over a new scene and its zones."""

    def path_clearance_m(self, points: FloatArray) -> float | None:
        """Exact clearance of a polyline; None before the first scene."""

    def answer(self, request: _Q_contra) -> _A_co:
        """Plan for the request."""
        ...


class PlannerThread(Generic[_Q, _A]):
    """A planner in its own thread; the newest scene and request win.

    Paths of several robots are searched for in a second thread, since some may drive meanwhile:
    driven paths are checked in each new scene and in changed zones. Answers come in the order of
    their requests. ``on_scene`` and ``on_answer`` are called in the threads. `failure` names a
    scene's error until `restart`.
    """

    def __init__(
        self,
        arena_planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> None:
        self.planner = arena_planner
        self._on_scene, self._on_answer = on_scene, on_answer
        self._wake = threading.Condition()
        self._scene: tuple[Scene, int, FloatArray | None, Sequence[Zone]] | None = None
        self._zones: Sequence[Zone] = ()
        self._request: _Q | None = None
        self._search: _Q | None = None
        """The request for the second thread."""
        self._stopping = False
        self._error: Exception | None = None
        self._rounds = {"planner": self._one_round, "search": self._one_search}
        self.turns = dict.fromkeys(self._rounds, 0)
        self._threads = [
            threading.Thread(target=self._run, args=(name,), name=name, daemon=True)
            for name in self._rounds
        ]

    def start(self) -> None:
        """Start the threads."""
        for thread in self._threads:
            thread.start()

    def stop(self, timeout_s: float = 1.0) -> None:
        """End the threads after their present work."""
        with self._wake:
            self._stopping = True
            self._wake.notify_all()
        for thread in self._threads:
            if thread.ident is not None:  # a daemon whose port failed never started it
                thread.join(timeout_s)

    def see(
        self,
        scene: Scene,
        revision: int,
        path_points: FloatArray | None,
        zones: Sequence[Zone] = (),
    ) -> None:
        """Hand over scene, present path and zones."""
        with self._wake:
            self._scene = (scene, revision, path_points, zones)
            self._wake.notify_all()

    def ask(self, request: _Q) -> None:
        """Hand over a request."""
        with self._wake:
            if isinstance(request, FleetRequest):
                self._search = request
            else:
                self._request = request
            self._wake.notify_all()

    def failure(self) -> str | None:
        """Error of the last scene that failed, in words."""
        return None if self._error is None else in_words(self._error)

    def restart(self) -> None:
        """Forget an error; what waits is dropped."""
        with self._wake:
            self._scene = self._request = self._search = None
        self._error = None

    def _run(self, name: str) -> None:
        goes_on = True
        while goes_on:
            try:
                goes_on = self._rounds[name]()
            except Exception as error:  # noqa: BLE001 - said by the control loop, which restarts the planner
                self._error = error
            self.turns[name] += 1

    def _one_search(self) -> bool:
        with self._wake:
            self._wake.wait_for(lambda: self._search or self._stopping, LONGEST_WAIT_S)
            request, self._search = self._search, None
            if self._stopping:
                return False
        if request is not None:
            self._on_answer(self.planner.answer(request))
        return True

    def _one_round(self) -> bool:
        with self._wake:
            self._wake.wait_for(
                lambda: self._scene or self._request or self._stopping, LONGEST_WAIT_S
            )
            scene, self._scene = self._scene, None
            request, self._request = self._request, None
            if self._stopping:
                return False
        if scene is not None:
            self.planner.see(scene[0], scene[1], scene[3])
            points = scene[2]
            clearance = None if points is None else self.planner.path_clearance_m(points)
            changed, self._zones = scene[3] != self._zones, scene[3]
            self._on_scene(SceneCheck(scene[1], clearance, changed, tuple(scene[3])))
        if request is not None:
            self._on_answer(self.planner.answer(request))
        return True
