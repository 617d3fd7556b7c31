"""Run vision and planner again on a recording and report differences.

Rules
- Pictures and requests go through a run's own parts, with the recorded configuration, calibration,
  zones, starts and stations.
- A recording may hold fewer pictures than the run saw: a scene is found if the replay produces it
  while it was the newest, or within ``SCENE_LAG_S`` after.
- The scene with which a file begins was seen in an earlier one. What a robot hides in this file's
  pictures is nowhere in them: that scene is compared only if it comes out again.
- Tracking may find a robot later than the run: only one missed for ``SEARCH_S`` is a difference.
- Scenes equal within the tolerance may lead to either of two almost equal paths: a plan that comes
  out as recorded in the recorded scene is no difference.

Metres, radians, seconds of the recorded run's clock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

from navigation.config.several.each_robot import each_robot
from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.loop.planning import ArenaPlanner
from navigation.loop.seeing.eye import Eye
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots
from navigation.loop.stages import plan_settings
from navigation.loop.traffic.fleet_planner import FleetPlanner
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.recording.compare import (
    ComparisonTolerances,
    Difference,
    gates_problem,
    plan_offset_m,
    plan_problem,
    pose_offset,
    pose_problem,
    scene_distance_m,
)
from navigation.recording.events import SceneSeen
from navigation.recording.files import RecordingError
from navigation.recording.reader import Planned, Recording, SeenFrame
from planner.path import NoPath
from planner.scene import Scene
from planner.zones.zone import Zone
from vision.camera.camera import Frame
from vision.markers.markers import MarkerTracker

SCENE_LAG_S: Final = 1.0
SEARCH_S: Final = 0.6


@dataclass(slots=True)
class Largest:
    """Largest distances, within tolerance or not."""

    position_m: float = 0.0
    heading_rad: float = 0.0
    scene_m: float = 0.0
    path_m: float = 0.0


@dataclass(slots=True)
class ReplayResult:
    """Numbers of things compared, and every difference in order of time."""

    pictures: int = 0
    poses: int = 0
    scenes: int = 0
    plans: int = 0
    not_compared: int = 0
    """Scenes and plans for which the recording has no pictures."""
    near_ties: int = 0
    """Plans that come out as recorded only in the recorded scene, equal within the tolerance."""
    largest: Largest = field(default_factory=Largest)
    differences: list[Difference] = field(default_factory=list)

    @property
    def is_equal(self) -> bool:
        """True if nothing differs."""
        return not self.differences


class _Plans(Protocol):
    @property
    def revision(self) -> int: ...

    def see(self, scene: Scene, revision: int, zones: Sequence[Zone] = ()) -> None:
        """Take over a scene and its zones."""

    def compare(self, planned: Planned, limits: ComparisonTolerances) -> tuple[float, str | None]:
        """Return the plan's distance from the recorded one, and the difference or None."""
        ...


class _PlansOfOne(ArenaPlanner):
    def compare(self, planned: Planned, limits: ComparisonTolerances) -> tuple[float, str | None]:
        assert isinstance(planned.request, PlanRequest)
        answer: PlanAnswer = self.answer(planned.request)
        off_m = plan_offset_m(planned.answer, answer.path)
        return off_m, plan_problem(planned.answer, answer.path, off_m, limits)


class _PlansOfSeveral(FleetPlanner):
    def compare(self, planned: Planned, limits: ComparisonTolerances) -> tuple[float, str | None]:
        assert isinstance(planned.request, FleetRequest)
        answer: FleetAnswer = self.answer(planned.request)
        farthest_m, first = 0.0, None
        for name, recorded in sorted(planned.answer["robots"].items()):
            promise = answer.promises.get(name)
            why = answer.refused.get(name, "it was not asked for")
            path = NoPath(why) if promise is None else promise.path
            off_m = plan_offset_m(recorded, path)
            farthest_m = max(farthest_m, off_m)
            problem = plan_problem(recorded, path, off_m, limits)
            if problem is None and promise is not None:
                problem = gates_problem(recorded["gates"], [gate.other for gate in promise.gates])
            if problem is not None and first is None:
                first = f"of {name} {problem}"
        return farthest_m, first


class Replay:
    """Replay of one recording; ``RecordingError`` if it is of several cameras."""

    def __init__(self, recording: Recording, tolerances: ComparisonTolerances) -> None:
        self.recording, self.tolerances = recording, tolerances
        self.result = ReplayResult()
        config = recording.config
        if config.cameras:
            raise RecordingError(
                f"{recording.path}: is of {len(config.cameras)} cameras, whose pictures are "
                "recorded as one: a replay needs each camera's own"
            )
        alone = each_robot(config)
        driven = [one.robot for one in alone.values()]
        tracker = MarkerTracker(
            recording.calibration,
            marked_robots(config, driven),
            config.robot.dictionary,
            config.camera.rolling_shutter_ms / 1000.0,
        )
        self._eye = Eye(recording.calibration, tracker, eye_settings(config, driven))

        def planner() -> _Plans:
            return _PlansOfSeveral(alone) if alone else _PlansOfOne(plan_settings(config))

        self._planner, self._planner_of_recorded = planner(), planner()
        """The second sees only the recorded scenes: each of the two keeps its own last path."""
        self._found: list[tuple[float, Scene]] = []
        self._last_s = -math.inf
        self._first_s: float | None = None
        self._unlike_since_s: dict[int, float] = {}
        self._told: set[int] = set()
        self._equal_scenes: set[int] = set()

    def run(self) -> ReplayResult:
        """Compare every picture, then scenes and plans."""
        for number, (time_ns, image) in enumerate(self.recording.pictures()):
            seen = self.recording.frames.get(time_ns)
            if seen is None:
                continue  # the file was cut between a picture and the result for it
            self._look(Frame(image, seen.captured_s, number, "recording"), seen)
        by_revision = self._compare_scenes()
        self._compare_plans(by_revision)
        self.result.differences.sort(key=lambda difference: difference.time_s)
        return self.result

    def _differ(self, kind: str, time_s: float, sentence: str) -> None:
        self.result.differences.append(Difference(kind, time_s, sentence))

    def _look(self, frame: Frame, seen: SeenFrame) -> None:
        glimpse = self._eye.look(frame)
        self.result.pictures += 1
        self._last_s = frame.captured_s
        if self._first_s is None:
            self._first_s = frame.captured_s
        if glimpse.scene is not None:
            self._found.append((frame.captured_s, glimpse.scene))
        poses = {i: (pose.x, pose.y, pose.heading_rad) for i, pose in glimpse.poses.items()}
        for robot_id in sorted({*poses, *seen.poses}):
            recorded, here = seen.poses.get(robot_id), poses.get(robot_id)
            if recorded is None or here is None:
                self._seen_by_one_only(robot_id, frame.captured_s, recorded is not None)
                continue
            self._unlike_since_s.pop(robot_id, None)
            self._told.discard(robot_id)
            self.result.poses += 1
            off_m, off_rad = pose_offset(recorded, here)
            largest = self.result.largest
            largest.position_m = max(largest.position_m, off_m)
            largest.heading_rad = max(largest.heading_rad, off_rad)
            problem = pose_problem(off_m, off_rad, self.tolerances)
            if problem is not None:
                self._differ("pose", frame.captured_s, f"robot {robot_id} {problem}")

    def _seen_by_one_only(self, robot_id: int, time_s: float, was_recorded: bool) -> None:
        since_s = self._unlike_since_s.setdefault(robot_id, time_s)
        if time_s - since_s > SEARCH_S and robot_id not in self._told:
            self._told.add(robot_id)
            where = "in the recording" if was_recorded else "in the replay"
            self._differ("pose", since_s, f"robot {robot_id} is seen {where} only")

    def _compare_scenes(self) -> dict[int, Scene]:
        """Return the replay's scene for each revision."""
        by_revision: dict[int, Scene] = {}
        scenes = self.recording.scenes
        ends = [*(scene.time_s for scene in scenes), math.inf][1:]
        for recorded, end_s in zip(scenes, ends, strict=True):
            begin_s = recorded.time_s
            if recorded.carried and self._first_s is not None:
                begin_s = max(begin_s, self._first_s)
            # a short file may end before its carried-over first scene is seen again
            is_short = recorded.carried and self._last_s < begin_s + SCENE_LAG_S
            if self._last_s < begin_s or (is_short and not self._found):
                self.result.not_compared += 1
                continue
            self.result.scenes += 1
            best, off_m = self._nearest(recorded, begin_s, end_s + SCENE_LAG_S)
            if best is not None:
                by_revision[recorded.revision] = best
            problem = self._scene_problem(recorded, best, off_m)
            if problem is None:
                self._equal_scenes.add(recorded.revision)
            elif recorded.carried:
                self.result.scenes -= 1
                self.result.not_compared += 1
                by_revision[recorded.revision] = recorded.scene
            else:
                self._differ("scene", begin_s, f"scene {recorded.revision} {problem}")
        return by_revision

    def _scene_problem(self, recorded: SceneSeen, best: Scene | None, off_m: float) -> str | None:
        if best is None:
            return "is not seen"
        here, there = len(best.objects), len(recorded.scene.objects)
        if here != there:
            return f"has {here} objects, the recorded one {there}"
        self.result.largest.scene_m = max(self.result.largest.scene_m, off_m)
        limit_m = self.tolerances.scene_m
        if off_m <= limit_m:
            return None
        return f"has a border {off_m * 1e3:.1f} mm off: at most {limit_m * 1e3:g} mm"

    def _nearest(
        self, recorded: SceneSeen, begin_s: float, end_s: float
    ) -> tuple[Scene | None, float]:
        """Nearest of the replay's scenes that were newest in an interval."""
        before = [scene for at_s, scene in self._found if at_s <= begin_s][-1:]
        between = [scene for at_s, scene in self._found if begin_s < at_s <= end_s]
        best: Scene | None = None
        least_m = math.inf
        for found in (*before, *between):
            off_m = scene_distance_m(recorded.scene, found)
            if best is None or off_m < least_m:
                best, least_m = found, off_m
        return best, least_m

    def _compare_plans(self, by_revision: dict[int, Scene]) -> None:
        for planned in self.recording.plans:
            if planned.carried:
                continue  # compared in the file in which it was planned
            recorded = self.recording.scene_in(int(planned.answer["revision"]))
            scene = None if recorded is None else by_revision.get(recorded.revision)
            if recorded is None or scene is None:
                self.result.not_compared += 1
                continue
            self.result.plans += 1
            off_m, problem = self._offset(self._planner, planned, scene)
            _, in_recorded = self._offset(self._planner_of_recorded, planned, recorded.scene)
            self.result.largest.path_m = max(self.result.largest.path_m, off_m)
            if problem is None:
                continue
            if in_recorded is None and recorded.revision in self._equal_scenes:
                # equal input gives an equal plan; here a hair's breadth decides
                self.result.near_ties += 1
                continue
            sentence = f"plan {planned.request.id} {problem}"
            self._differ("plan", planned.answer["time_s"], sentence)

    def _offset(self, planner: _Plans, planned: Planned, scene: Scene) -> tuple[float, str | None]:
        revision = int(planned.answer["revision"])
        if planner.revision != revision:
            planner.see(scene, revision, self.recording.zones_in(revision))
        return planner.compare(planned, self.tolerances)


def replay(recording: Recording, tolerances: ComparisonTolerances | None = None) -> ReplayResult:
    """Replay a recording; see `Replay`."""
    return Replay(recording, tolerances or ComparisonTolerances()).run()
