"""The watch on the camera's place: the common movement of the picture's fixed points.

Rules and units
- Fixed points are the configured floor markers; if fewer than ``LEAST_POINTS`` are seen, the
  corners of ``vision.watch.fixed_points`` too. They are learned from one picture; a point that
  trembles is left out.
- The camera has moved when more than half of the visible points have. A single moved or covered
  point is reported.
- Markers with configured places must be seen there when they are learned: otherwise the camera was
  moved unwatched, or its place is unclear, which holds the robot as well.
- A sentence changes only with its content. Raw pixels, metres, seconds of the frames.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from planner.scene import Bounds
from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.markers.reading import Marker, crossing, find_markers
from vision.watch.drift import LEAST_NOISE_PX, DriftTest, of_most
from vision.watch.fixed_points import (
    CORNER_NAME,
    MARKER_HALF_PX,
    FixedPoint,
    PointMeter,
    Readings,
    corners_of,
    point_at,
)

LEAST_POINTS = 3
"""With two that disagree the moved one is unknown."""
LEARNED_FRAMES = 30
LEARN_AGAIN_S = 2.0
"""Pause between searches for lost markers; a search takes some 20 ms."""
MOST_NOISE_PX = 0.3
"""Largest noise of one point, along each axis; corners at 2.5 grey levels of noise have 0.03."""
_SAID_AGAIN = 0.25
"""Relative change of a movement, besides half a pixel, that is reported again."""
_NAMED = 4
_NO_DISCS = np.empty((0, 3))


@dataclass(frozen=True, slots=True)
class FloorMarker:
    """A marker on the floor; ``place_m`` is its centre's, None if not measured."""

    id: int
    place_m: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class PlaceSettings:
    """Settings of the watch: the camera may move by ``limit_px``; 0 watches nothing."""

    bounds_m: Bounds
    markers: tuple[FloorMarker, ...]
    dictionary: str
    limit_px: float


@dataclass(frozen=True, slots=True)
class PlaceReport:
    """A frame's findings; sentences without a cause are empty."""

    moved: str = ""
    """The camera has moved."""
    lost: str = ""
    """More than half of the fixed points are unseen: it has moved far, or they are hidden."""
    remarks: tuple[str, ...] = ()
    """Single points that moved or vanished, and a camera that cannot be watched."""
    moved_px: float | None = None
    """Distance from their places that more than half of the points reach."""


NOTHING_KNOWN = PlaceReport()


def said_together(reports: Iterable[PlaceReport]) -> PlaceReport:
    """Join several cameras' reports: each that has moved or is lost counts."""
    reports = tuple(reports)
    return PlaceReport(
        "; ".join(one.moved for one in reports if one.moved),
        "; ".join(one.lost for one in reports if one.lost),
        tuple(text for one in reports for text in one.remarks),
        max((one.moved_px for one in reports if one.moved_px is not None), default=None),
    )


class CameraPlace:
    """Watch that learns the fixed points of one picture and follows them.

    Its sentences count from ``began_s``; ``name`` is set for one of several cameras.
    """

    def __init__(
        self,
        calibration: Calibration,
        settings: PlaceSettings,
        began_s: float = 0.0,
        name: str = "",
    ) -> None:
        self._of = f"camera {name}" if name else "the camera"
        self._renewal = f"clearway reanchor --camera {name}" if name else "clearway reanchor"
        self._calibration, self._settings = calibration, settings
        self._meter: PointMeter | None = None
        self._zero: FloatArray = np.empty((0, 2))
        """Readings for points in their places: not 0 if learned elsewhere."""
        self._learned: list[Readings] | None = []
        self._began_s = self._last_s = began_s
        self._misplaced = False
        self._unclear = ""
        self._tried_s = -np.inf
        self._unseen_ids: tuple[int, ...] = ()
        self._said: dict[str, tuple[float, str]] = {}
        self._reset(0)

    @property
    def points(self) -> tuple[FixedPoint, ...]:
        """Watched points; empty before they are learned."""
        return () if self._meter is None else self._meter.points

    def look(
        self, grey: Image, discs: FloatArray | None, captured_s: float, *, may_learn: bool
    ) -> PlaceReport:
        """Measure a frame (h, w); robots cover ``discs`` (k, 3), as far as known.

        ``may_learn``: the robots' places are known, so points may be learned.
        """
        settings = self._settings
        if settings.limit_px <= 0.0:
            return NOTHING_KNOWN
        discs = _NO_DISCS if discs is None else discs
        wanted = may_learn if self._meter is None else bool(self._lost.moved[0])
        if wanted and captured_s > self._tried_s + LEARN_AGAIN_S:
            self._learn(grey, discs, captured_s)
        if self._meter is None or len(self.points) < LEAST_POINTS:
            return self._report(None)
        readings = self._meter.measure(grey, discs)
        passed_s, self._last_s = captured_s - self._last_s, captured_s
        away = np.hypot(*(readings.moved_px - self._zero).T)
        open_to_see = np.count_nonzero(~readings.covered)
        seen = np.count_nonzero(readings.seen)
        most = of_most(away[readings.seen]) if seen >= LEAST_POINTS else None
        gone = np.nan if open_to_see < LEAST_POINTS else np.inf if 2 * seen < open_to_see else 0.0
        self._camera.update(np.array([np.nan if most is None else most]), passed_s, captured_s)
        self._lost.update(np.array([gone]), passed_s, captured_s)
        self._each.update(np.where(readings.seen, away, np.nan), passed_s, captured_s)
        unseen = np.where(readings.covered, np.nan, np.where(readings.seen, 0.0, np.inf))
        self._gone.update(unseen, passed_s, captured_s)
        self._measure_noise(readings)
        report = self._report(most, away)
        if self._misplaced and not report.moved and not report.lost:
            self._meter, self._tried_s = None, -np.inf
        return report

    def _reset(self, count: int, noise_px: float = LEAST_NOISE_PX) -> None:
        limit_px = max(self._settings.limit_px, 1e-9)
        self._camera = DriftTest(1, limit_px, noise_px)
        self._lost, self._gone = DriftTest(1, limit_px), DriftTest(count, limit_px)
        self._each = DriftTest(count, limit_px, noise_px)

    def _learn(self, grey: Image, discs: FloatArray, now_s: float) -> None:
        """Learn this picture's points; again only if markers' places judge them."""
        self._last_s = self._tried_s = now_s
        points, offsets = self._floor_markers(grey)
        placed = np.isfinite(offsets[:, 0])
        away = np.hypot(*offsets[placed].T)
        in_place = len(away) > 0 and of_most(away) <= self._settings.limit_px
        misplaced = len(away) >= LEAST_POINTS and not in_place
        if self._meter is not None and len(away) < LEAST_POINTS:  # the learned ones are better
            return
        seen_ids = set(_marker_ids(points))
        self._unseen_ids = tuple(sorted({m.id for m in self._settings.markers} - seen_ids))
        self._unclear = self._why_unclear(away, in_place or misplaced)
        if self._unclear:
            return
        self._misplaced = misplaced
        if misplaced:
            points = [point for point, known in zip(points, placed, strict=True) if known]
            self._zero = -offsets[placed]
        else:
            if len(points) < LEAST_POINTS:
                points += corners_of(grey, discs, self._calibration, self._settings.bounds_m)
            self._zero = np.zeros((len(points), 2))
        self._meter, self._learned = PointMeter(points), []
        self._reset(len(points))
        if misplaced:
            self._camera.begin_moved(now_s)
            self._each.begin_moved(now_s)

    def _why_unclear(self, away_px: FloatArray, is_clear: bool) -> str:
        surveyed = sum(one.place_m is not None for one in self._settings.markers)
        if is_clear or (not len(away_px) and surveyed < LEAST_POINTS):
            return ""
        where = f", {away_px.max():.1f} px from where they belong" if len(away_px) else ""
        return (
            f"{len(away_px)} of {surveyed} floor markers are seen{where}: whether {self._of} is "
            f"where it was calibrated takes one in its place, or {LEAST_POINTS} that tell where it "
            "is now"
        )

    def _floor_markers(self, grey: Image) -> tuple[list[FixedPoint], FloatArray]:
        wanted = {one.id: one.place_m for one in self._settings.markers}
        if not wanted:
            return [], np.empty((0, 2))
        found = find_markers(grey, self._settings.dictionary, calibration=self._calibration)
        ids = [marker.id for marker in found]
        # of two with one number, it is unclear which is meant
        markers = [m for m in found if m.id in wanted and ids.count(m.id) == 1]
        points = [point for m in markers if (point := _marker_point(grey, m)) is not None]
        return points, self._offsets(points, [wanted[i] for i in _marker_ids(points)])

    def _offsets(
        self, points: Sequence[FixedPoint], expected: Sequence[tuple[float, float] | None]
    ) -> FloatArray:
        offsets = np.full((len(points), 2), np.nan)
        for i, (point, place) in enumerate(zip(points, expected, strict=True)):
            if place is not None:
                offsets[i] = point.place_px - self._calibration.image_from_arena([place])[0]
        return offsets

    def _measure_noise(self, readings: Readings) -> None:
        """After the first second, leave out points that tremble or come and go."""
        if self._learned is None or self._meter is None:
            return
        if self._camera.sums[0] > 0.0 or self._lost.sums[0] > 0.0:
            self._learned = []  # movement now is not noise
            return
        self._learned.append(readings)
        if len(self._learned) < LEARNED_FRAMES:
            return
        moved = np.stack([one.moved_px for one in self._learned])
        covered = np.stack([one.covered for one in self._learned])
        self._learned = None
        known = ~covered.any(axis=0)
        steady = np.ones(len(self.points), dtype=np.bool_)
        for i in np.flatnonzero(known).tolist():
            seen = moved[np.isfinite(moved[:, i, 0]), i]
            noise_px = float(seen.std(axis=0).max()) if len(seen) > LEARNED_FRAMES // 2 else np.inf
            steady[i] = noise_px <= MOST_NOISE_PX
        if steady.all():
            return
        kept = [point for point, stays in zip(self.points, steady, strict=True) if stays]
        self._unseen_ids = tuple(
            sorted({*self._unseen_ids, *_marker_ids(self.points)} - {*_marker_ids(kept)})
        )
        self._meter, self._zero = PointMeter(kept), self._zero[steady]
        self._reset(len(kept))

    def _report(self, most_px: float | None, away_px: FloatArray | None = None) -> PlaceReport:
        remarks = []
        count = len(self.points)
        if self._meter is not None and count < LEAST_POINTS:
            remarks.append(
                f"a knocked {self._of.removeprefix('the ')} would not be noticed: "
                f"{count} fixed point{'s' * (count != 1)} "
                f"in the picture, at least {LEAST_POINTS} are needed: lay floor markers "
                "(arena.floor_markers)"
            )
        if self._unseen_ids:
            numbers = ", ".join(map(str, self._unseen_ids))
            plural = "s" * (len(self._unseen_ids) != 1)
            remarks.append(
                f"floor marker{plural} {numbers}: not seen steadily when {self._of}'s place was "
                "learned, and not watched"
            )
        if away_px is None:
            return PlaceReport(lost=self._unclear, remarks=tuple(remarks))
        moved, lost = bool(self._camera.moved[0]), bool(self._lost.moved[0])
        said = set()
        if moved:
            said.add("moved")
            self._say_moved(most_px, away_px)
        if lost:
            said.add("lost")
            self._say_lost()
        if not moved and not lost:
            said |= self._say_single(away_px)
        self._said = {key: what for key, what in self._said.items() if key in said}
        singles = [text for key, (_, text) in self._said.items() if key not in ("moved", "lost")]
        return PlaceReport(
            self._said["moved"][1] if moved else "",
            self._said["lost"][1] if lost else "",
            (*remarks, *singles),
            most_px,
        )

    def _say_moved(self, most_px: float | None, away_px: FloatArray) -> None:
        before = self._said.get("moved")
        limit_px = 0.5 * self._settings.limit_px
        size_px = most_px or 0.0
        if before is not None:
            change_px = abs(size_px - before[0])
            if size_px < limit_px or change_px <= max(0.5, _SAID_AGAIN * before[0]):
                return
        which = [p for p, px in zip(self.points, away_px, strict=True) if px > limit_px]
        size_mm = 1000.0 * size_px * self._calibration.metres_per_pixel
        when = self._into_the_run(self._camera.since_s[0])
        self._said["moved"] = (
            size_px,
            f"{self._of} has moved: {len(which)} of {len(self.points)} fixed points "
            f"({_listed(which)}) are seen {size_px:.1f} px ({size_mm:.0f} mm on the floor) or "
            f"more from their places, since {'before the run' if self._misplaced else when}: put "
            f"the camera back, or renew its anchoring by {self._renewal}",
        )

    def _say_lost(self) -> None:
        if "lost" in self._said:
            return
        count = int(np.count_nonzero(self._gone.moved))
        self._said["lost"] = (
            0.0,
            f"{count} of {len(self.points)} fixed points are not seen where they were, since "
            f"{self._into_the_run(self._lost.since_s[0])}: {self._of} was knocked, or they are "
            "hidden",
        )

    def _say_single(self, away_px: FloatArray) -> set[str]:
        """Report floor markers moved by themselves or hidden; corners may be anything's."""
        said = set()
        for i, point in enumerate(self.points):
            if point.marker_id is None:
                continue
            if self._each.moved[i]:
                key = f"moved {i}"
                since = self._into_the_run(self._each.since_s[i])
                text = f"was moved by {away_px[i]:.1f} px, since {since}: put it back"
                if not np.isfinite(away_px[i]):
                    text = f"was moved, since {since}: put it back"
            elif self._gone.moved[i]:
                key = f"gone {i}"
                text = f"is not seen, since {self._into_the_run(self._gone.since_s[i])}"
            else:
                continue
            said.add(key)
            self._said.setdefault(key, (0.0, f"{point.name} {text}; {self._of} has not moved"))
        return said

    def _into_the_run(self, at_s: float) -> str:
        return f"{at_s - self._began_s:.1f} s into the run"


def _marker_point(grey: Image, marker: Marker) -> FixedPoint | None:
    from_diagonals = crossing(marker.corners_px)
    side_px = float(np.linalg.norm(marker.corners_px[1] - marker.corners_px[0]))
    half_px = max(4, min(MARKER_HALF_PX, round(0.5 * side_px)))
    return point_at(grey, from_diagonals, f"floor marker {marker.id}", half_px, marker.id)


def _marker_ids(points: Sequence[FixedPoint]) -> list[int]:
    return [point.marker_id for point in points if point.marker_id is not None]


def _listed(points: Sequence[FixedPoint]) -> str:
    markers = ", ".join(map(str, _marker_ids(points)[:_NAMED]))
    corners = [p.name.removeprefix(CORNER_NAME) for p in points if p.marker_id is None]
    said = f"floor marker{'s' * (len(_marker_ids(points)) > 1)} {markers}" if markers else ""
    if corners:
        at = f"corner{'s' * (len(corners) > 1)} {CORNER_NAME}{', '.join(corners[:_NAMED])}"
        said = f"{said}, {at}" if said else at
    hidden = len(points) - min(len(_marker_ids(points)), _NAMED) - min(len(corners), _NAMED)
    return f"{said} and {hidden} more" if hidden else said
