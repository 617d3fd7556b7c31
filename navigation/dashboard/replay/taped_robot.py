"""One robot of a recording at any moment, as its daemon published it.

Unrecorded data is None or empty. Metres, radians, seconds of the run's clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from firmware_protocol.host.counters import HostCounters
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.framing import ParserCounters
from navigation.config import Config
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.run_state import RobotSnapshot, StageTimes
from navigation.mission.mission import MissionProgress, State
from navigation.mission.watch import Action, Verdict
from navigation.recording.tape import Tape, TapedPlan
from planner.borders.polyline import arc_lengths, nearest_length
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

DRIVEN: Final = frozenset((State.DRIVING, State.PROVING, State.HOLDING, State.PLANNING))
"""States in which a plan is shown."""


@dataclass(frozen=True, slots=True)
class Moment:
    """Data common to all robots at a moment, ``place_s`` after the recording's beginning."""

    time_s: float
    place_s: float
    poses: Mapping[int, RobotPose]
    roadmap: Roadmap | None
    frame: Frame | None


class TapedRobot:
    """A robot of a tape; ``name`` is "" for a single robot, ``config`` its own."""

    def __init__(self, tape: Tape, name: str, config: Config) -> None:
        self.tape, self.name, self.config = tape, name, config
        self._path: tuple[TapedPlan | None, Path | None] = (None, None)

    def pose_at(self, moment: Moment) -> RobotPose | None:
        """Last seen pose."""
        return moment.poses.get(self.config.robot.marker_id)

    def state_at(
        self, moment: Moment, clearance_m: float | None, *, in_short: bool = False
    ) -> RobotSnapshot:
        """Snapshot in the times of ``moment``; ``in_short`` without a plan."""
        mission, pose = self.mission_at(moment.time_s), self.pose_at(moment)
        path = None
        if mission.state in DRIVEN and not in_short:
            path = self._path_of(self.tape.plan_at(moment.time_s, self.name), moment.roadmap)
        return RobotSnapshot(
            time_s=moment.place_s,
            mission=mission,
            sentence=mission.reason,
            pose=pose,
            link=self._link_at(moment.time_s, mission.state),
            to_go_m=None if path is None or pose is None else _to_go_m(path, pose),
            clearance_m=clearance_m,
            verdict=Verdict(Action.GO, ()),
            frame=moment.frame,
            poses=moment.poses,
            roadmap=moment.roadmap,
            path=path,
            times=StageTimes(),
        )

    def mission_at(self, time_s: float) -> MissionProgress:
        """Recorded mission, with the last planned stations."""
        said = self.tape.said_at(time_s, self.name)
        planned = self.tape.plan_at(time_s, self.name)
        stations = () if planned is None else planned.stations
        if said is None:
            return MissionProgress(stations, reason="nothing was said of the mission yet")
        name, _, sentence = said.partition(": ")
        try:
            return MissionProgress(stations, state=State(name), reason=sentence)
        except ValueError:  # from a program with other states
            return MissionProgress(stations, reason=said)

    def _link_at(self, time_s: float, state: State) -> LinkSnapshot:
        known = self.tape.link_at(time_s, self.name)
        if known is None:
            return LinkSnapshot(LinkState.CLOSED, "nothing was recorded of the link yet", math.inf)
        names = {one.value for one in LinkState}
        return LinkSnapshot(
            LinkState(known.state) if known.state in names else LinkState.CLOSED,
            known.down_reason,
            math.inf,
            moving=state is State.DRIVING,
            executed=known.executed or 0,
            rtt_s=known.rtt_s,
            sent=HostCounters(**_known(HostCounters, known.sent)),
            received=ParserCounters(**_known(ParserCounters, known.received)),
        )

    def _path_of(self, planned: TapedPlan | None, roadmap: Roadmap | None) -> Path | None:
        if planned is None or roadmap is None or planned.answer.get("status") != "ok":
            return None
        if self._path[0] is not planned or self._path[1] is None:
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
            self._path = (planned, path)
        return self._path[1]


def _to_go_m(path: Path, pose: RobotPose) -> float:
    """Length of the path left from its place nearest to the robot."""
    lengths = arc_lengths(path.points)
    return float(lengths[-1]) - nearest_length(path.points, lengths, (pose.x, pose.y))


def _known(kind: Any, values: Mapping[str, int]) -> dict[str, int]:
    names = {one.name for one in fields(kind)}
    return {name: value for name, value in values.items() if name in names}
