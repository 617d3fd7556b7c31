"""The compiled loops of ``vision.markers.marker_corners``: edge points and lines along a marker's
sides.

Raw pixels, centres at integers; ``lens`` as ``vision.calibration.lens_model`` has it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

import planner.scene.compile_options  # noqa: F401 (chooses how kernels are compiled and kept)
from vision.calibration.calibration_kernels import undistort
from vision.calibration.lens_model import LensArrays

_ENDS = 0.1  # share of a side left out at each end: the neighbouring side's blur reaches there
_STEP_PX = 0.5
_MIN_CONTRAST = 12.0
_OUTLIER_MADS = 4.0


@njit(cache=True, nogil=True, fastmath=False)
def fit_sides(
    grey: NDArray[np.uint8],
    corners: NDArray[np.float64],
    reach_px: float,
    lens: LensArrays,
    frame: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The four sides of the quadrilateral ``corners`` (4, 2), which must lie inside ``grey``.

    ``frame`` (3, 3) is a homography of undistorted pixels, in which lines are fitted. Returns lines
    (4, 4) there, a, b, c, rms with a x + b y = c, and for each side (4,) the share of its profiles
    that show an edge and have a ray.
    """
    lines = np.zeros((4, 4))
    seen = np.zeros(4)
    longest = 0.0
    for side in range(4):
        nx = corners[(side + 1) % 4, 0] - corners[side, 0]
        ny = corners[(side + 1) % 4, 1] - corners[side, 1]
        longest = max(longest, np.sqrt(nx * nx + ny * ny))
    count = min(max(int(np.ceil(longest)), 12), 96)
    points = np.zeros((4, count, 2))
    steps = np.zeros((4, count))
    shifts = np.zeros((4, count))
    for side in range(4):
        _edges_of_side(
            grey,
            corners[side],
            corners[(side + 1) % 4],
            reach_px,
            points[side],
            steps[side],
            shifts[side],
        )
    enough = max(_MIN_CONTRAST, 0.4 * np.median(steps))
    for side in range(4):
        use = (steps[side] > enough) & (np.abs(shifts[side]) < 0.8 * reach_px)
        for i in range(count):
            x, y = undistort(points[side, i, 0], points[side, i, 1], lens)
            w = frame[2, 0] * x + frame[2, 1] * y + frame[2, 2]
            use[i] = use[i] and w == w  # a pixel without a ray is NaN
            points[side, i, 0] = (frame[0, 0] * x + frame[0, 1] * y + frame[0, 2]) / w
            points[side, i, 1] = (frame[1, 0] * x + frame[1, 1] * y + frame[1, 2]) / w
        seen[side] = use.sum() / count
        if use.sum() < 4:
            continue
        _fit_line(points[side], use, lines[side])
    return lines, seen


@njit(cache=True, nogil=True, fastmath=False)
def _edges_of_side(
    grey: NDArray[np.uint8],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    reach_px: float,
    out_points: NDArray[np.float64],
    out_steps: NDArray[np.float64],
    out_shifts: NDArray[np.float64],
) -> None:
    """Profiles across one side: the centroid of the rise from the dark inside outwards."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = np.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return
    # Corners run clockwise on the screen, so outwards is to the left of the direction of travel.
    nx, ny = dy / length, -dx / length
    count = len(out_points)
    half = int(np.floor(reach_px / _STEP_PX + 0.5))
    for i in range(count):
        t = _ENDS + (1.0 - 2.0 * _ENDS) * i / (count - 1)
        fx, fy = start[0] + dx * t, start[1] + dy * t
        total = 0.0
        moment = 0.0
        darkest, brightest = 255.0, 0.0
        before = 0.0
        for j in range(-half, half + 1):
            value = _bilinear(grey, fx + nx * j * _STEP_PX, fy + ny * j * _STEP_PX)
            if j <= 0:
                darkest = min(darkest, value)
            if j >= 0:
                brightest = max(brightest, value)
            if j > -half and value > before:
                total += value - before
                moment += (value - before) * (j - 0.5) * _STEP_PX
            before = value
        shift = moment / total if total > 0.0 else 0.0
        out_points[i, 0] = fx + nx * shift
        out_points[i, 1] = fy + ny * shift
        out_shifts[i] = shift
        out_steps[i] = brightest - darkest


@njit(cache=True, nogil=True, fastmath=False)
def _bilinear(grey: NDArray[np.uint8], x: float, y: float) -> float:
    height, width = grey.shape
    x = min(max(x, 0.0), width - 1.0)
    y = min(max(y, 0.0), height - 1.0)
    x0, y0 = min(int(x), width - 2), min(int(y), height - 2)
    fx, fy = x - x0, y - y0
    above = grey[y0, x0] * (1.0 - fx) + grey[y0, x0 + 1] * fx
    below = grey[y0 + 1, x0] * (1.0 - fx) + grey[y0 + 1, x0 + 1] * fx
    return float(above * (1.0 - fy) + below * fy)


@njit(cache=True, nogil=True, fastmath=False)
def _fit_line(
    points: NDArray[np.float64], use: NDArray[np.bool_], out_line: NDArray[np.float64]
) -> None:
    """Total least squares twice; the second time without the first one's outliers."""
    for _ in range(2):
        n = 0
        mx = my = 0.0
        for i in range(len(points)):
            if use[i]:
                n += 1
                mx += points[i, 0]
                my += points[i, 1]
        mx, my = mx / n, my / n
        xx = xy = yy = 0.0
        for i in range(len(points)):
            if use[i]:
                ax, ay = points[i, 0] - mx, points[i, 1] - my
                xx, xy, yy = xx + ax * ax, xy + ax * ay, yy + ay * ay
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        a, b = -np.sin(angle), np.cos(angle)
        distance = np.abs((points[:, 0] - mx) * a + (points[:, 1] - my) * b)
        chosen = distance[use]
        out_line[0], out_line[1], out_line[2] = a, b, a * mx + b * my
        out_line[3] = np.sqrt(np.mean(chosen * chosen))
        limit = _OUTLIER_MADS * max(1.4826 * np.median(chosen), 0.05)
        kept = use & (distance < limit)
        if kept.sum() < 4:
            return
        use = kept
