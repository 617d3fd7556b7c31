"""Tracker of markers with known corners: it accepts and refuses like the real one.

Metres, radians, seconds, raw pixels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from navigation.run.without_pictures.sights import Sights
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image
from vision.markers.markers import MarkedRobot, MarkerTracker
from vision.markers.sighting import Sighting


class TrueTracker(MarkerTracker):
    """`MarkerTracker` that gets the places of markers."""

    def __init__(
        self,
        calibration: Calibration,
        robots: Sequence[MarkedRobot],
        dictionary: str,
        rolling_shutter_s: float,
        *,
        sights: Sights,
    ) -> None:
        super().__init__(calibration, robots, dictionary, rolling_shutter_s)
        self._sights = sights

    def _grey_of(self, frame: Frame) -> Image:
        return frame.image

    def _look_near(
        self, grey: Image, robot: MarkedRobot, now_s: float, refusals: list[str]
    ) -> Sighting | None:
        around = self._window(robot, now_s)
        if around is None:
            return None
        x0, y0, x1, y1 = around
        near = [
            one
            for one in self._sightings(grey, robot, refusals)
            if all(x0 <= x < x1 and y0 <= y < y1 for x, y in one.corners_px.tolist())
        ]
        return self._best(near, robot.id, now_s)

    def _search(
        self, grey: Image, found: Mapping[int, Sighting], refusals: list[str]
    ) -> dict[int, list[Sighting]]:
        seen = self._sights.of(grey).markers
        self.strangers = frozenset(i for i, _ in seen if i not in self._robots)
        return {i: self._sightings(grey, robot, refusals) for i, robot in self._robots.items()}

    def _sightings(self, grey: Image, robot: MarkedRobot, refusals: list[str]) -> list[Sighting]:
        marker, moves = self._markers[robot.id], self._tracks[robot.id].velocity
        sightings = [
            marker.at(corners, moves, refusals)
            for i, corners in self._sights.of(grey).markers
            if i == robot.id
        ]
        return [one for one in sightings if one is not None]
