"""Robots' poses from the markers on their backs, in frame after frame.

Rules and units
- Poses, markers and pixels are as in `marked_robot`.
- Position and heading come from the homography, corrected for the marker's height: under an
  overhead camera a marker's two poses in space look alike.
- With a rolling shutter a pose has the time of its marker's rows.
- Each robot's marker is fitted at its expected place (`sighting`), then searched for around it,
  then in the whole picture. A marker that has jumped is not a robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import cv2
import numpy as np

from vision.calibration.blind import coarsest_pixel_m
from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Frame, Image
from vision.markers.marked_robot import (
    MarkedRobot,
    RobotPose,
    body_discs_px,
    marker_pose,
    robot_pose,
)
from vision.markers.marker_pattern import pattern_bits
from vision.markers.marker_search import (
    MarkerError,
    dictionary_by_name,
    dictionary_names,
    find_markers,
    find_with,
    finder_of,
    grey_of,
)
from vision.markers.sighting import RobotMarker, Sighting, warm_up
from vision.markers.tracking import MarkerTrack, Pose

__all__ = [
    "MarkedRobot",
    "MarkerError",
    "MarkerTracker",
    "RobotPose",
    "body_discs_px",
    "dictionary_by_name",
    "dictionary_names",
    "find_markers",
    "marker_pose",
    "robot_pose",
]

_COARSE_SIDE_PX = 24.0
"""Side at which a marker is still decoded: a picture is searched no finer."""

_DOUBLES_EVERY = 6
"""Frames from one search of the whole picture for doubled markers to the next: it costs ten
looks."""
_APART_SIZES = 1.0
"""Sightings of one marker are nearer to each other than its side."""
_LOST_SEARCH_S = 1.0
_LOST_SEARCH_EVERY = 3


class MarkerTracker:
    """Finder of known robots' markers in frame after frame.

    ``dictionary`` is OpenCV's name, ``rolling_shutter_s`` the time from the first row's exposure to
    the last row's, which is the frame's.
    """

    def __init__(
        self,
        calibration: Calibration,
        robots: Sequence[MarkedRobot],
        dictionary: str = "DICT_4X4_50",
        rolling_shutter_s: float = 0.0,
    ) -> None:
        self._calibration = calibration
        self._row_s = rolling_shutter_s / max(1, calibration.size[1] - 1)
        self._robots = {robot.id: robot for robot in robots}
        if len(self._robots) != len(robots):
            raise MarkerError("two robots have the same marker id")
        book = dictionary_by_name(dictionary)
        for robot in robots:
            if robot.id >= len(book.bytesList):
                raise MarkerError(
                    f"marker id = {robot.id}: {dictionary} has ids 0 to {len(book.bytesList) - 1}"
                )
        self._markers = {
            robot.id: RobotMarker(robot, pattern_bits(book, robot.id), calibration, self._row_s)
            for robot in robots
        }
        self._pixel_m = calibration.metres_per_pixel
        self._late_s = dict.fromkeys(self._robots, 0.0)
        warm_up()
        recipes = ((23, 15.0), (11, 7.0), (45, 10.0))
        self._finders = [finder_of(book, window, constant) for window, constant in recipes]
        self._near = self._finders[:2]
        self._tracks = {robot.id: MarkerTrack(robot.limits) for robot in robots}
        self._first_s: float | None = None
        self._frames = 0
        self.refusals: tuple[str, ...] = ()
        """Reasons why markers in the last frame were not robots."""
        self.strangers: frozenset[int] = frozenset()
        """Ids of markers of no robot in the last search of a whole picture."""
        self.doubles: dict[int, tuple[Pose, ...]] = {}
        """Places of robots' markers seen in several places of one picture, in both of the last two
        searches of a whole picture."""
        self._suspects: frozenset[int] = frozenset()
        self._searches = 0

    def update(
        self, frame: Frame, tell: Callable[[RobotPose], None] = lambda _: None
    ) -> tuple[RobotPose, ...]:
        """Return the poses of the robots seen in this frame, ordered by id.

        ``tell`` gets each pose at once. Raises ``MarkerError`` for a frame whose size is not the
        calibration's.
        """
        grey = self._grey_of(frame)
        self._frames += 1
        self._first_s = frame.captured_s if self._first_s is None else self._first_s
        refusals: list[str] = []
        found: dict[int, Sighting] = {}
        poses: dict[int, RobotPose] = {}

        def find(sighting: Sighting | None) -> None:
            if sighting is None:
                return
            found[sighting.id] = sighting
            pose = self._believe(sighting, frame.captured_s, refusals)
            if pose is not None:
                poses[pose.id] = pose
                tell(pose)

        for robot in self._robots.values():
            find(self._look_near(grey, robot, frame.captured_s, refusals))
        missing = [i for i in self._robots if i not in found]
        worth = bool(missing) and self._worth_searching(missing, frame.captured_s)
        if worth or self._frames % _DOUBLES_EVERY == 0:
            everywhere = self._search(grey, found, refusals)
            for robot_id in missing if worth else ():
                find(self._best(everywhere[robot_id], robot_id, frame.captured_s))
            self._look_for_doubles(everywhere, found)
        self.refusals = tuple(refusals)
        return tuple(poses[i] for i in sorted(poses))

    def _grey_of(self, frame: Frame) -> Image:
        height, width = frame.image.shape[:2]
        if (width, height) != tuple(self._calibration.size):
            fits = self._calibration.size
            raise MarkerError(
                f"the frame is {width} x {height} pixels: its calibration is for "
                f"{fits[0]} x {fits[1]}"
            )
        grey = grey_of(frame.image)
        grey.setflags(write=False)
        return grey

    def _worth_searching(self, missing: list[int], now_s: float) -> bool:
        """True within a second of the loss, then for every third frame."""
        first_s = now_s if self._first_s is None else self._first_s
        last_s = [self._tracks[i].last_s for i in missing]
        latest_s = max(first_s if t is None else t for t in last_s)
        return now_s - latest_s <= _LOST_SEARCH_S or self._frames % _LOST_SEARCH_EVERY == 0

    def _look_near(
        self, grey: Image, robot: MarkedRobot, now_s: float, refusals: list[str]
    ) -> Sighting | None:
        expected = self._tracks[robot.id].predict(now_s - self._late_s[robot.id])
        if expected is None:
            return None
        marker = marker_pose(expected, robot)
        moves = self._tracks[robot.id].velocity
        followed = self._markers[robot.id].follow(grey, marker, moves)
        if followed is not None:
            return followed
        around = self._window(robot, now_s)
        if around is None:
            return None
        x0, y0, x1, y1 = around
        window = np.ascontiguousarray(grey[y0:y1, x0:x1])
        for finder in self._near:
            seen = [q for i, q in find_with(finder, window) if i == robot.id]
            sightings = [self._sight(grey, robot, q + np.array([x0, y0]), refusals) for q in seen]
            best = self._best([s for s in sightings if s is not None], robot.id, now_s)
            if best is not None:
                return best
        return None

    def _window(self, robot: MarkedRobot, now_s: float) -> tuple[int, int, int, int] | None:
        track = self._tracks[robot.id]
        expected = track.predict(now_s - self._late_s[robot.id])
        if expected is None or track.last_s is None:
            return None
        marker = marker_pose(expected, robot)
        seen_px = self._calibration.image_from_arena([marker[:2]], robot.marker_height_m)
        center = seen_px[0].tolist()
        if not all(map(math.isfinite, center)):
            return None
        side_px = self._side_px(robot)
        reach_m = robot.limits.slack_m + 0.5 * robot.limits.max_speed_m_s * (now_s - track.last_s)
        half = 1.1 * side_px + 8.0 + reach_m / self._pixel_m
        x0, y0 = (max(0, math.floor(v - half)) for v in center)
        x1, y1 = (
            min(limit, math.ceil(v + half) + 1)
            for v, limit in zip(center, self._calibration.size, strict=True)
        )
        return None if x1 - x0 < 8 or y1 - y0 < 8 else (x0, y0, x1, y1)

    def _look_for_doubles(
        self, everywhere: dict[int, list[Sighting]], found: dict[int, Sighting]
    ) -> None:
        places = {}
        for robot_id, sightings in everywhere.items():
            known = [found[robot_id]] if robot_id in found else []
            apart_m = _APART_SIZES * self._robots[robot_id].marker_size_m
            for sighting in sightings:
                if all(math.dist(sighting.pose[:2], k.pose[:2]) > apart_m for k in known):
                    known.append(sighting)
            if len(known) > 1:
                places[robot_id] = tuple(one.pose for one in known)
        self.doubles = {i: poses for i, poses in places.items() if i in self._suspects}
        self._suspects = frozenset(places)

    def _search(
        self, grey: Image, found: Mapping[int, Sighting], refusals: list[str]
    ) -> dict[int, list[Sighting]]:
        """Find every robot's sightings in the whole picture, by another recipe each time.

        Sightings ``found`` there are skipped.
        """
        # where the picture is coarsest: a wide lens shrinks its rim
        least_m = min(robot.marker_size_m for robot in self._robots.values())
        smallest = least_m / coarsest_pixel_m(self._calibration)
        factor = 2 if smallest >= 2.0 * _COARSE_SIDE_PX and min(grey.shape) > 1 else 1
        picture = grey
        if factor > 1:
            height, width = grey.shape
            picture = cv2.resize(
                grey, (width // factor, height // factor), interpolation=cv2.INTER_AREA
            ).astype(np.uint8, copy=False)
        scale = np.array(grey.shape[::-1]) / np.array(picture.shape[::-1])
        finder = self._finders[self._searches % len(self._finders)]
        self._searches += 1
        seen = [(i, (q + 0.5) * scale - 0.5) for i, q in find_with(finder, picture)]
        self.strangers = frozenset(i for i, _ in seen if i not in self._robots)
        return {
            robot_id: [
                sighting
                for i, quad in seen
                if i == robot_id
                and not _is_there(quad, found.get(i))
                and (sighting := self._sight(grey, robot, quad, refusals)) is not None
            ]
            for robot_id, robot in self._robots.items()
        }

    def _best(self, sightings: list[Sighting], robot_id: int, now_s: float) -> Sighting | None:
        if not sightings:
            return None
        expected = self._tracks[robot_id].predict(now_s)
        if expected is None:
            return min(sightings, key=lambda s: s.residual_m)
        return min(sightings, key=lambda s: math.dist(s.pose[:2], expected[:2]))

    def _sight(
        self, grey: Image, robot: MarkedRobot, quad_px: FloatArray, refusals: list[str]
    ) -> Sighting | None:
        moves = self._tracks[robot.id].velocity
        return self._markers[robot.id].look(grey, quad_px, moves, refusals)

    def _believe(self, sighting: Sighting, frame_s: float, refusals: list[str]) -> RobotPose | None:
        rows_after = self._calibration.size[1] - 1 - float(sighting.corners_px[:, 1].mean())
        before_s = self._late_s[sighting.id] = self._row_s * rows_after
        now_s = frame_s - before_s
        track = self._tracks[sighting.id]
        velocity = track.offer(sighting.pose, now_s)
        if velocity is None:
            if track.refused:
                refusals.append(f"marker {sighting.id}: jumped farther than the robot can drive")
            return None
        return RobotPose(
            sighting.id,
            *sighting.pose,
            now_s,
            sighting.corners_px,
            velocity.vx,
            velocity.vy,
            velocity.turn_rate_rad_s,
            sighting.residual_m,
            before_s,
            sighting.error_px,
        )

    def _side_px(self, robot: MarkedRobot) -> float:
        return robot.marker_size_m / self._pixel_m


def _is_there(quad_px: FloatArray, known: Sighting | None) -> bool:
    if known is None:
        return False
    middle = known.corners_px.mean(axis=0)
    side_px = math.dist(known.corners_px[0], known.corners_px[1])
    return math.dist(quad_px.mean(axis=0), middle) < 0.5 * side_px
