"""Last position and track of each of the other robots, by marker id. Metres, radians, seconds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from navigation.mission.traffic import LOST_S, Mover
from navigation.shared.track import Track
from vision.markers.markers import RobotPose

TRACK_ROWS: Final = 20_000
TRACK_STEP_M: Final = 0.005
"""For drawing only: a row every 5 mm, for 100 m."""


class OtherRobots:
    """Other robots, fed with each picture."""

    def __init__(self, radii_m: Mapping[int, float]) -> None:
        self._radii_m = dict(radii_m)
        self._last: dict[int, RobotPose] = {}
        self.tracks = {marker_id: Track(TRACK_ROWS, TRACK_STEP_M) for marker_id in radii_m}

    def see(self, poses: Mapping[int, RobotPose]) -> None:
        """Take the poses of other robots."""
        for marker_id, pose in poses.items():
            if marker_id in self._radii_m:
                self._last[marker_id] = pose
                self.tracks[marker_id].add(pose.captured_s, pose.x, pose.y, pose.heading_rad)

    def movers(self, now_s: float) -> tuple[Mover, ...]:
        """Every robot ever seen, extrapolated while its velocity can be trusted."""
        return tuple(mover_of(one, self._radii_m[one.id], now_s) for one in self._last.values())


def mover_of(other: RobotPose, radius_m: float, now_s: float) -> Mover:
    """A seen robot, extrapolated while its velocity can be trusted."""
    age_s = now_s - other.captured_s
    x, y, _ = other.at(now_s) if age_s < LOST_S else (other.x, other.y, 0.0)
    return Mover(other.id, x, y, other.vx, other.vy, radius_m, age_s)
