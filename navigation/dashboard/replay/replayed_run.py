"""A recording at the player's moment, as a daemon would publish it: it shows, and takes no orders.

Rules
- Times that pages turn into ages (captures) are moved to the present, so that an age is what it
  was then; ``DaemonState.time_s`` is seconds from the recording's beginning.
- What was not recorded is unknown here too: it is None, never made up. A robot's marker is shown
  where its pose is, on the floor.
- Roadmaps are built again from the recorded scenes in a thread beside, the newest few are kept.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import fields
from typing import Any, Final

import numpy as np

import planner
from firmware_protocol.host.counters import HostCounters
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.framing import ParserCounters
from navigation.config import Config
from navigation.config.dashboard import DashboardSection
from navigation.dashboard.replay.player import Player
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.daemon_state import DaemonState, StageTimes
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Mission, MissionError, State, Station
from navigation.mission.watch import Action, Verdict
from navigation.recording.files import RecordingError
from navigation.recording.reader import Planned, SeenScene
from navigation.recording.tape import Tape, TapedPicture
from planner.borders.polyline import arc_lengths
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

IT_IS_A_RECORDING: Final = "this is a recording: nothing here drives or stops a robot"
ROADMAPS: Final = 8
RATE_OVER_S: Final = 2.0
SPEED_OVER_S: Final = 0.3
DRIVEN: Final = frozenset((State.DRIVING, State.PROVING, State.HOLDING))


class ReplayedRun:
    """A tape and its player as `Shown`; ``clock`` is that of the page."""

    def __init__(
        self, tape: Tape, player: Player, section: DashboardSection, clock: Callable[[], float]
    ) -> None:
        robots = tape.recording.config.robots
        if robots:
            raise RecordingError(
                f"{tape.recording.path}: is of {len(robots)} robots; the page replays one: "
                "`clearway replay` and Foxglove show several"
            )
        self.tape, self.player, self._clock = tape, player, clock
        folder = tape.recording.path.parent
        recording = tape.recording.config.recording.model_copy(
            update={"runs_dir": folder, "folder": folder, "journal": None}
        )
        self.config: Config = tape.recording.config.model_copy(
            update={"dashboard": section, "recording": recording}
        )
        self.calibration = tape.recording.calibration
        self._builder = ThreadPoolExecutor(1, thread_name_prefix="roadmaps")
        self._roadmaps: OrderedDict[int, Future[Roadmap]] = OrderedDict()
        self._path: tuple[Planned | None, Roadmap | None, Path | None] = (None, None, None)
        self._frame: tuple[TapedPicture | None, Frame | None] = (None, None)

    fleet = None
    """A recording of several robots is none of this page's."""

    def close(self) -> None:
        """Build nothing more."""
        self._builder.shutdown(wait=False, cancel_futures=True)

    @property
    def state(self) -> DaemonState:
        """The recording at the player's moment."""
        return self.state_at(self.player.place_s(self._clock()), as_now=True)

    def wall_clock(self) -> float:
        """The wall time of the moment that is shown, seconds since 1970."""
        return self._time_s() + self.tape.wall_offset_s

    def camera_status(self) -> CameraStatus:
        """The camera, as far as the recording knows it."""
        return self.camera_at(self.player.place_s(self._clock()))

    def camera_at(self, place_s: float) -> CameraStatus:
        """The camera ``place_s`` after the recording's beginning."""
        time_s = self.tape.begin_s + place_s
        seen = self.tape.count_until(time_s)
        lately = seen - self.tape.count_until(time_s - RATE_OVER_S)
        age_s = time_s - self.tape.frame_at(time_s).captured_s
        passed_s = min(RATE_OVER_S, max(0.1, time_s - self.tape.begin_s))
        return CameraStatus("running", "", lately / passed_s, seen, 0, 0, age_s)

    def last_wire_s(self) -> float | None:
        """Not recorded."""
        return None

    def state_at(self, place_s: float, *, as_now: bool = False) -> DaemonState:
        """The state ``place_s`` after the recording's beginning, in the run's own times.

        ``as_now``: with its picture, and with times by which it is as old now as it was then.
        """
        time_s = self.tape.begin_s + place_s
        later_s = self._clock() - time_s if as_now else 0.0
        roadmap = self._roadmap(self.tape.scene_at(time_s))
        mission = self._mission(time_s)
        poses = self._poses(time_s, later_s)
        pose = poses.get(self.config.robot.marker_id)
        path = self._path_of(self.tape.plan_at(time_s), roadmap)
        if mission.state not in DRIVEN and mission.state is not State.PLANNING:
            path = None
        clearance_m = None
        if roadmap is not None and pose is not None:
            clearance_m = float(roadmap.clearance([(pose.x, pose.y)])[0])
        return DaemonState(
            time_s=place_s,
            mission=mission,
            sentence=mission.reason,
            pose=pose,
            link=self._link(time_s),
            to_go_m=None if path is None or pose is None else _to_go_m(path, pose),
            clearance_m=clearance_m,
            verdict=Verdict(Action.GO, ()),
            frame=self._picture(time_s, later_s) if as_now else None,
            poses=poses,
            roadmap=roadmap,
            path=path,
            times=StageTimes(),
        )

    def _time_s(self) -> float:
        return self.tape.begin_s + self.player.place_s(self._clock())

    def _mission(self, time_s: float) -> Mission:
        said = self.tape.said_at(time_s)
        planned = self.tape.plan_at(time_s)
        request = None if planned is None else planned.request
        stations = request.stations if isinstance(request, PlanRequest) else ()
        if said is None:
            return Mission(stations, reason="nothing was said of the mission yet")
        name, _, sentence = said.partition(": ")
        try:
            return Mission(stations, state=State(name), reason=sentence)
        except ValueError:  # of a program that has other states
            return Mission(stations, reason=said)

    def _poses(self, time_s: float, later_s: float) -> dict[int, RobotPose]:
        seen = self.tape.frame_at(time_s)
        before = self.tape.frame_at(time_s - SPEED_OVER_S)
        passed_s = seen.captured_s - before.captured_s
        poses = {}
        for robot, (x, y, heading_rad) in seen.poses.items():
            corner = self.calibration.image_from_arena(np.array([[x, y]]))
            vx = vy = 0.0
            if robot in before.poses and passed_s > 0.0:
                was_x, was_y, _ = before.poses[robot]
                vx, vy = (x - was_x) / passed_s, (y - was_y) / passed_s
            corners = np.repeat(corner, 4, axis=0)
            poses[robot] = RobotPose(
                robot, x, y, heading_rad, seen.captured_s + later_s, corners, vx, vy
            )
        return poses

    def _link(self, time_s: float) -> LinkSnapshot:
        known = self.tape.link_at(time_s)
        if known is None:
            return LinkSnapshot(LinkState.CLOSED, "nothing was recorded of the link yet", math.inf)
        down = known.get("down_reason")
        state = known.get("state")
        names = {one.value for one in LinkState}
        return LinkSnapshot(
            LinkState(state) if state in names else LinkState.CLOSED,
            str(down) if down is not None else None,
            math.inf,
            moving=self._mission(time_s).state is State.DRIVING,
            executed=int(known.get("executed") or 0),
            rtt_s=known.get("rtt_s"),
            sent=HostCounters(**_known(HostCounters, known.get("sent"))),
            received=ParserCounters(**_known(ParserCounters, known.get("received"))),
        )

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

    def _roadmap(self, seen: SeenScene | None) -> Roadmap | None:
        """The roadmap of a scene; of the last one that there is until it is built."""
        if seen is None:
            return None
        if seen.revision not in self._roadmaps:
            self._roadmaps[seen.revision] = self._builder.submit(
                planner.build_roadmap,
                seen.scene,
                self.config.robot.radius_m,
                spacing=self.config.planning.spacing_m,
            )
            while len(self._roadmaps) > ROADMAPS:
                self._roadmaps.popitem(last=False)[1].cancel()
        built = self._roadmaps[seen.revision]
        for future in (built, *reversed(self._roadmaps.values())):
            if future.done() and not future.cancelled() and future.exception() is None:
                return future.result()
        return None

    def _path_of(self, planned: Planned | None, roadmap: Roadmap | None) -> Path | None:
        if planned is None or roadmap is None or planned.answer.get("status") != "ok":
            return None
        if self._path[0] is not planned or self._path[2] is None:
            points = np.asarray(planned.answer["path"], dtype=np.float64).reshape(-1, 2)
            if len(points) < 2:
                return None
            least = roadmap.path_clearance(points)
            path = Path(
                points,
                roadmap.clearance(points),
                float(planned.answer["length_m"]),
                float(planned.answer["min_clearance_m"]),
                least.at,
                self.config.robot.radius_m,
                (0, len(points) - 1),
                (None, None),
            )
            self._path = (planned, roadmap, path)
        return self._path[2]

    # Orders: none.

    def preview(self, _stations: tuple[Station, ...], _robot: str | None = None) -> PlanAnswer:
        """Refused."""
        raise MissionError(IT_IS_A_RECORDING)

    def give(self, _stations: tuple[Station, ...]) -> None:
        """Refused."""
        raise MissionError(IT_IS_A_RECORDING)

    def stop(self, _reason: str) -> None:
        """Refused: there is nothing to stop."""
        raise MissionError(IT_IS_A_RECORDING)

    def pause(self) -> None:
        """Refused."""
        raise MissionError(IT_IS_A_RECORDING)

    def resume(self) -> None:
        """Refused."""
        raise MissionError(IT_IS_A_RECORDING)

    def replan(self) -> None:
        """Refused."""
        raise MissionError(IT_IS_A_RECORDING)

    def settle(self) -> None:
        """Nothing to wait for."""

    def describe(self) -> Mapping[str, Any]:
        """The state that is shown."""
        mission = self._mission(self._time_s())
        return {"state": mission.state.value, "reason": mission.reason}


def _to_go_m(path: Path, pose: RobotPose) -> float:
    """What is left of the path from its place nearest to the robot."""
    begins, steps = path.points[:-1], np.diff(path.points, axis=0)
    squares = np.maximum((steps**2).sum(axis=1), np.finfo(float).tiny)
    off = np.array((pose.x, pose.y)) - begins
    shares = np.clip((off * steps).sum(axis=1) / squares, 0.0, 1.0)
    nearest = int(np.hypot(*(off - shares[:, None] * steps).T).argmin())
    lengths = arc_lengths(path.points)
    passed_m = lengths[nearest] + shares[nearest] * (lengths[nearest + 1] - lengths[nearest])
    return float(lengths[-1] - passed_m)


def _known(kind: Any, values: object) -> dict[str, Any]:
    """Of recorded counters those that there are, whole numbers."""
    names = {one.name for one in fields(kind)}
    given = values if isinstance(values, dict) else {}
    return {name: value for name, value in given.items() if name in names}
