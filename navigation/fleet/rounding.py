"""Rounded corners of a fleet's tracks, at which robots need not stop and turn.

Each track is rounded like a lone robot's path if it keeps its clearance. If it then comes nearer to
another robot than the plan allows, the legs between its waits are tried one by one. Metres,
seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from planner.borders.polyline import arc_lengths
from planner.fleet.motions.track_kernels import least_distance
from planner.motion.smooth import smooth_path
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray
from planner.zones.rules import Rules

CHORD_M: Final = 0.001
"""Largest gap between a rounded corner and the lines between targets: the camera's error."""

ROUNDING_M: Final = 1e-9
"""Difference between two computations of one distance."""


@dataclass(frozen=True, slots=True)
class CutTrack:
    """Track (k, 3) of t, x, y in short pieces, and the rows given to a robot as targets."""

    fine: FloatArray
    rows: NDArray[np.int64]

    @property
    def targets(self) -> FloatArray:
        """Straight lines between the targets: the track that is driven and judged."""
        return np.ascontiguousarray(self.fine[self.rows])

    @classmethod
    def whole(cls, track: FloatArray) -> CutTrack:
        """Track whose every point is a target."""
        return cls(track, np.arange(len(track), dtype=np.int64))

    @classmethod
    def of(cls, track: FloatArray, piece_m: float) -> CutTrack:
        """Track in pieces, with a target at each of its points."""
        return cls.whole(split_track(np.asarray(track), piece_m))

    @classmethod
    def thinned(cls, track: FloatArray, piece_m: float) -> CutTrack:
        """Smooth track with no more targets than it needs."""
        fine = split_track(track, piece_m)
        return cls(fine, thinned(fine, piece_m))


def rounded(
    here: Roadmap,
    tracks: Sequence[CutTrack],
    sizes: Sequence[float],
    piece_m: float,
    turning_m: Mapping[int, float],
    rules: Sequence[Rules],
) -> list[CutTrack]:
    """Round corners where no robot comes too near and each one's zones permit it.

    Only tracks in ``turning_m`` are rounded, by bends no tighter than its radii.
    """
    now = list(tracks)
    for i, radius_m in turning_m.items():
        legs = legs_of(tracks[i].fine)
        smooth = [_rounded_leg(here, leg, sizes[i], radius_m, rules[i]) for leg in legs]
        found = CutTrack.thinned(np.concatenate(smooth), piece_m)
        if _is_clear(found, i, now, sizes):
            now[i] = found
            continue
        chosen = list(legs)
        for k, leg in enumerate(smooth):
            tried = [*chosen[:k], leg, *chosen[k + 1 :]]
            found = CutTrack.thinned(np.concatenate(tried), piece_m)
            if leg is not legs[k] and _is_clear(found, i, now, sizes):
                chosen, now[i] = tried, found
    return now


def legs_of(track: FloatArray) -> list[FloatArray]:
    """Cut the track at its waits."""
    stands = np.flatnonzero(~np.any(track[1:, 1:] != track[:-1, 1:], axis=1))
    cuts = [0, *(int(row) + 1 for row in stands), len(track)]
    return [track[a:b] for a, b in pairwise(cuts)]


def _rounded_leg(
    here: Roadmap, leg: FloatArray, size: float, turning_m: float, rules: Rules
) -> FloatArray:
    if len(leg) < 3:
        return leg
    points = np.ascontiguousarray(leg[:, 1:])
    least = here.path_clearance(points)
    path = Path(
        points=points,
        clearances=here.clearance(points),
        length=float(arc_lengths(points)[-1]),
        min_clearance=float(least.distance),
        min_clearance_at=least.at,
        robot_radius=min(size, float(least.distance)),
        stations=(0, len(points) - 1),
        headings_rad=(None, None),
    )
    smooth = smooth_path(
        path,
        here.path_clearance,
        here.clearance,
        keep=max(size, path.robot_radius),
        turning_radius=turning_m,
        permits=rules.permits,
    )
    along = arc_lengths(smooth.points)
    share = along / max(along[-1], 1e-12)
    times = leg[0, 0] + (leg[-1, 0] - leg[0, 0]) * share
    times[-1] = leg[-1, 0]
    return np.column_stack([times, smooth.points])


def _is_clear(track: CutTrack, i: int, tracks: Sequence[CutTrack], sizes: Sequence[float]) -> bool:
    mine = track.targets
    return all(
        least_distance(mine, other.targets)[0] >= sizes[i] + sizes[j] - ROUNDING_M
        for j, other in enumerate(tracks)
        if j != i
    )


def split_track(track: FloatArray, piece_m: float) -> FloatArray:
    """Track (k, 3) of t, x, y with rows no further apart than a piece."""
    rows = [track[:1]]
    for a, b in pairwise(track):
        parts = max(1, math.ceil(math.dist(a[1:], b[1:]) / piece_m - 1e-9))
        share = np.arange(1, parts + 1)[:, None] / parts
        rows.append(a + share * (b - a))
        rows[-1][-1] = b
    return np.concatenate(rows)


def thinned(track: FloatArray, piece_m: float) -> NDArray[np.int64]:
    """Rows of a track given to a robot as targets, in order.

    No two are further apart than a piece, the line between them leaves the track by at most
    ``CHORD_M``, and every row at rest is included.
    """
    points = track[:, 1:]
    stands = {0, len(track) - 1}
    for row in np.flatnonzero(~np.any(points[1:] != points[:-1], axis=1)).tolist():
        stands |= {row, row + 1}
    rows = [0]
    while rows[-1] < len(track) - 1:
        first = last = rows[-1]
        while last + 1 < len(track) and _is_straight(points[first : last + 2], piece_m):
            last += 1
            if last in stands:
                break
        rows.append(max(last, first + 1))
    return np.array(rows, dtype=np.int64)


def _is_straight(points: FloatArray, piece_m: float) -> bool:
    chord = points[-1] - points[0]
    length = float(np.hypot(*chord))
    if len(points) > 2 and length > piece_m + 1e-9:
        return False
    if len(points) == 2:
        return True
    off = points[1:-1] - points[0]
    if length == 0.0:
        return False
    across = np.abs(off[:, 0] * chord[1] - off[:, 1] * chord[0]) / length
    return float(across.max()) <= CHORD_M
