"""A recording at the player's moment, as a daemon would publish it.

Rules
- Capture times are moved to the present, so that pages show each age as it was then;
  ``RunState.time_s`` is seconds from the recording's beginning.
- Unrecorded data is None, never made up. A robot's marker is shown at its pose on the floor.
- Roadmaps are rebuilt in a separate thread.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np

import planner
from navigation.config import Config
from navigation.config.dashboard import DashboardSection
from navigation.config.several.each_robot import robots_of
from navigation.dashboard.replay.player import Player
from navigation.dashboard.replay.taped_robot import Moment, TapedRobot
from navigation.loop.run_state import RunState
from navigation.recording.events import SceneSeen
from navigation.recording.tape import Tape, TapedPicture
from planner.roadmap.roadmap import Roadmap
from planner.zones.zone import Zone
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

ROADMAPS: Final = 8
RATE_OVER_S: Final = 2.0
SPEED_OVER_S: Final = 0.3


@dataclass(frozen=True, slots=True)
class TapedZones:
    """Zones at a moment of a recording; ``revision`` counts the changes until then."""

    held: tuple[Zone, ...]
    revision: int

    def zones(self) -> tuple[Zone, ...]:
        """Return all of them."""
        return self.held


class ReplayedRun:
    """A tape and its player as `Shown`; ``clock`` is the page's."""

    def __init__(
        self, tape: Tape, player: Player, section: DashboardSection, clock: Callable[[], float]
    ) -> None:
        self.tape, self.player, self._clock = tape, player, clock
        folder = tape.recording.path.parent
        recording = tape.recording.config.recording.model_copy(
            update={"runs_dir": folder, "folder": folder, "journal": None}
        )
        self.config: Config = tape.recording.config.model_copy(
            update={"dashboard": section, "recording": recording}
        )
        self.calibration = tape.recording.calibration
        configs = robots_of(self.config)
        self._robots = [TapedRobot(tape, name, one) for name, one in configs.items()]
        self._smallest_m = min(one.robot.radius_m for one in configs.values())
        """Radius that the roadmap is of, as in a run."""
        self._builder = ThreadPoolExecutor(1, thread_name_prefix="roadmaps")
        self._roadmaps: OrderedDict[int, Future[Roadmap]] = OrderedDict()
        self._frame: tuple[TapedPicture | None, Frame | None] = (None, None)
        self.people = None

    def close(self) -> None:
        """Stop building roadmaps."""
        self._builder.shutdown(wait=False, cancel_futures=True)

    @property
    def state(self) -> RunState:
        """The recording at the player's moment."""
        return self.at(self.player.place_s(self._clock()), as_now=True)

    @property
    def zones(self) -> TapedZones:
        """The zones at the player's moment."""
        recording, time_s = self.tape.recording, self._time_s()
        changes = sum(one.time_s <= time_s for one in recording.zones)
        return TapedZones(recording.zones_at(time_s), changes)

    def wall_clock(self) -> float:
        """Wall time of the shown moment, seconds since 1970."""
        return self._time_s() + self.tape.wall_offset_s

    def camera_status(self) -> CameraStatus:
        """The camera, as far as recorded."""
        return self.camera_at(self.player.place_s(self._clock()))

    def camera_at(self, place_s: float) -> CameraStatus:
        """The camera ``place_s`` after the recording's beginning."""
        time_s = self.tape.begin_s + place_s
        seen = self.tape.count_until(time_s)
        lately = seen - self.tape.count_until(time_s - RATE_OVER_S)
        age_s = time_s - self.tape.frame_at(time_s).captured_s
        passed_s = min(RATE_OVER_S, max(0.1, time_s - self.tape.begin_s))
        return CameraStatus("running", "", lately / passed_s, seen, 0, 0, age_s)

    def at(self, place_s: float, *, as_now: bool = False, in_short: bool = False) -> RunState:
        """State ``place_s`` after the recording's beginning, in the run's own times.

        ``as_now``: with its picture, and times shifted to the present. ``in_short``: without
        clearances and plans, the slowest parts.
        """
        time_s = self.tape.begin_s + place_s
        later_s = self._clock() - time_s if as_now else 0.0
        moment = Moment(
            time_s,
            place_s,
            self._poses(time_s, later_s),
            self._roadmap(self.tape.scene_at(time_s)),
            self._picture(time_s, later_s) if as_now else None,
        )
        robots = self._robots
        clearances = [None] * len(robots) if in_short else _clearances(moment, robots)
        states = {
            robot.name: robot.state_at(moment, clearance, in_short=in_short)
            for robot, clearance in zip(robots, clearances, strict=True)
        }
        waits, waits_for = self.tape.waits_at(time_s)
        return RunState(place_s, states, waits, waits_for=waits_for)

    def _time_s(self) -> float:
        return self.tape.begin_s + self.player.place_s(self._clock())

    def _poses(self, time_s: float, later_s: float) -> dict[int, RobotPose]:
        seen = self.tape.frame_at(time_s)
        before = self.tape.frame_at(time_s - SPEED_OVER_S)
        passed_s = seen.captured_s - before.captured_s
        places = np.array([(x, y) for x, y, _ in seen.poses.values()]).reshape(-1, 2)
        pixels = self.calibration.image_from_arena(places)
        poses = {}
        for (robot, (x, y, heading_rad)), pixel in zip(seen.poses.items(), pixels, strict=True):
            vx = vy = 0.0
            if robot in before.poses and passed_s > 0.0:
                was_x, was_y, _ = before.poses[robot]
                vx, vy = (x - was_x) / passed_s, (y - was_y) / passed_s
            captured_s, corners = seen.captured_s + later_s, np.tile(pixel, (4, 1))
            poses[robot] = RobotPose(robot, x, y, heading_rad, captured_s, corners, vx, vy)
        return poses

    def _picture(self, time_s: float, later_s: float) -> Frame | None:
        taped = self.tape.picture_at(time_s)
        if taped is None:
            return None
        if self._frame[0] is not taped:
            image = self.tape.image(taped)
            image.setflags(write=False)
            self._frame = (
                taped,
                Frame(image, taped.captured_s + later_s, taped.number, "recording"),
            )
        return self._frame[1]

    def _roadmap(self, seen: SceneSeen | None) -> Roadmap | None:
        """Roadmap of a scene; the last available one until it is built."""
        if seen is None:
            return None
        if seen.revision not in self._roadmaps:
            self._roadmaps[seen.revision] = self._builder.submit(
                planner.build_roadmap,
                seen.scene,
                self._smallest_m,
                spacing=self.config.planning.spacing_m,
            )
            while len(self._roadmaps) > ROADMAPS:
                self._roadmaps.popitem(last=False)[1].cancel()
        built = self._roadmaps[seen.revision]
        for future in (built, *reversed(self._roadmaps.values())):
            if future.done() and not future.cancelled() and future.exception() is None:
                return future.result()
        return None


def _clearances(moment: Moment, robots: list[TapedRobot]) -> list[float | None]:
    poses = [robot.pose_at(moment) for robot in robots]
    places = [(pose.x, pose.y) for pose in poses if pose is not None]
    if moment.roadmap is None or not places:
        return [None] * len(robots)
    known = iter(moment.roadmap.clearance(places).tolist())
    return [None if pose is None else next(known) for pose in poses]
