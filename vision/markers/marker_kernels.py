"""Edge points, lines along a marker's sides, and their corners, for
``vision.markers.marker_corners``.

Raw pixels, centres at integers; ``lens`` as in ``vision.calibration.lens_model``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING
from vision.calibration.calibration_kernels import distort, undistort
from vision.calibration.lens_model import STRAIGHT

_ENDS = 0.1  # share of a side left out at each end, where the next side's blur reaches
_STEP_PX = 0.5
_MIN_CONTRAST = 12.0
_OUTLIER_MADS = 4.0

_ROUNDS = 3
_MOST_ROUNDS = 6
"""Rounds in which sides are searched again from where they meet: the detector's covered corners lie
many pixels off."""
_RESTS_PX = 0.5
"""Largest movement of a corner at rest: profiles reach six times as far."""
_MIN_SEEN = 0.7
"""Share of a side's profiles that must show its edge, on one line: a strip over half a side has as
straight and long an edge."""
_FIRST_SEEN = 0.2
"""The same in the first rounds: derived, a corner 10 px off leaves a third of a side within
reach."""
_LEAST_SCATTER_PX = 0.05
"""Least scatter of edge points, of a drawn picture: a pixel's own shape."""
_ALIKE = 1.5
"""Factor on errors of independent points: derived, each pixel is in two profiles."""
_NEARLY_ALL = 0.9
"""Share of a side's edge points on a line from which no other is tried: indifferent."""
_STATIONS = 8
"""Profiles of a side through which, two by two, lines are tried: derived, five are left where a
side just counts as seen."""
_ON_LINE_PX = 0.75
"""Largest distance of an edge point from its line: chosen, about `_MAX_ROUGHNESS_PX`. A line
between a side and a cover's edge has fewer such points than either."""
_MIN_SINE = 0.1
"""Least sine of the angle between neighbouring sides."""

_MAX_ROUGHNESS_PX = 0.7

FITTED, AT_EDGE, FOLDED, HIDDEN, PARALLEL, APART, ROUGH, NO_FLOOR, UNREAD = range(9)
"""Outcomes of a quadrilateral; the last two only for a pattern on a floor."""


@njit(**OWNING)
def fit_quad(grey, seen_px, cells, lens, out_ideal):
    """Intersect a marker's four sides in ``out_ideal`` (4, 2), undistorted.

    ``seen_px`` (4, 2) are raw corners, good to a few pixels, clockwise on the screen. Returns the
    outcome, the edge points' rms distance from the sides, and the worst corner's standard error,
    pixels.
    """
    side_px = 0.0
    for i in range(4):
        dx = seen_px[(i + 1) % 4, 0] - seen_px[i, 0]
        dy = seen_px[(i + 1) % 4, 1] - seen_px[i, 1]
        side_px += 0.25 * np.sqrt(dx * dx + dy * dy)
    widest = max(1.5, 0.75 * side_px / cells)
    corners = seen_px.copy()
    roughness_px = error_px = moved = 0.0
    for turn in range(_MOST_ROUNDS):
        if turn >= _ROUNDS and moved < _RESTS_PX:
            break
        # the detector may be a pixel or two off: look wide first, then close
        reach_px = min(4.0 if turn == 0 else 3.0, widest)
        if not _is_inside(corners, reach_px, grey):
            return AT_EDGE, roughness_px, error_px
        for i in range(4):
            out_ideal[i, 0], out_ideal[i, 1] = undistort(corners[i, 0], corners[i, 1], lens)
        frame, back = np.eye(3), np.eye(3)
        if lens.model != STRAIGHT and not _frame_at(out_ideal, corners, frame, back):
            return FOLDED, roughness_px, error_px
        lines, seen = fit_sides(grey, corners, reach_px, lens, frame)
        if seen.min() < (_MIN_SEEN if turn > 1 else _FIRST_SEEN):
            return HIDDEN, roughness_px, error_px
        if not _intersect(lines, back, out_ideal):
            return PARALLEL, roughness_px, error_px
        farthest = max(4.0, 0.15 * side_px)
        moved = 0.0
        for i in range(4):
            x, y = distort(out_ideal[i, 0], out_ideal[i, 1], lens)
            moved = max(moved, abs(x - corners[i, 0]), abs(y - corners[i, 1]))
            corners[i, 0], corners[i, 1] = x, y
            if not (abs(x - seen_px[i, 0]) <= farthest and abs(y - seen_px[i, 1]) <= farthest):
                return APART, roughness_px, error_px
        roughness_px = np.sqrt(np.mean(lines[:, 3] ** 2))
        error_px = 0.0
        for i in range(4):
            error_px = max(error_px, np.hypot(lines[(i + 3) % 4, 5], lines[i, 4]))
    return (FITTED if roughness_px <= _MAX_ROUGHNESS_PX else ROUGH), roughness_px, error_px


@njit(**OWNING)
def _is_inside(corners, reach_px, grey):
    height, width = grey.shape
    for i in range(4):
        x, y = corners[i, 0], corners[i, 1]
        if not (x >= reach_px and y >= reach_px):
            return False
        if not (x + reach_px <= width - 1 and y + reach_px <= height - 1):
            return False
    return True


@njit(**OWNING)
def _frame_at(ideal, corners, out_frame, out_back):
    """Homography from undistorted to raw corners, and its inverse; False without one.

    Each joins two homographies of a unit square (Heckbert, Fundamentals of texture mapping and
    image warping, 1989).
    """
    first, second = np.empty((3, 3)), np.empty((3, 3))
    if not (_from_square(ideal, first) and _from_square(corners, second)):
        return False
    one, two = np.empty((3, 3)), np.empty((3, 3))
    if not (_invert(first, one) and _invert(second, two)):
        return False
    _multiply(second, one, out_frame)
    _multiply(first, two, out_back)
    return True


@njit(**OWNING)
def _from_square(quad, out):
    sx = quad[0, 0] - quad[1, 0] + quad[2, 0] - quad[3, 0]
    sy = quad[0, 1] - quad[1, 1] + quad[2, 1] - quad[3, 1]
    ax, ay = quad[1, 0] - quad[2, 0], quad[1, 1] - quad[2, 1]
    bx, by = quad[3, 0] - quad[2, 0], quad[3, 1] - quad[2, 1]
    determinant = ax * by - bx * ay
    if not abs(determinant) > 0.0:
        return False
    g, h = (sx * by - bx * sy) / determinant, (ax * sy - sx * ay) / determinant
    for i in range(2):
        out[i, 0] = quad[1, i] * (1.0 + g) - quad[0, i]
        out[i, 1] = quad[3, i] * (1.0 + h) - quad[0, i]
        out[i, 2] = quad[0, i]
    out[2, 0], out[2, 1], out[2, 2] = g, h, 1.0
    return True


@njit(**OWNING)
def _invert(m, out):
    """Invert (3, 3) by cofactors; False if singular."""
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            c, d = (j + 1) % 3, (j + 2) % 3
            out[j, i] = m[a, c] * m[b, d] - m[a, d] * m[b, c]
    determinant = m[0, 0] * out[0, 0] + m[0, 1] * out[1, 0] + m[0, 2] * out[2, 0]
    if not abs(determinant) > 0.0:
        return False
    for i in range(3):
        for j in range(3):
            out[i, j] /= determinant
    return True


@njit(**OWNING)
def _multiply(a, b, out):
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(**OWNING)
def _intersect(lines, homography, out):
    """Intersect sides i - 1 and i in corner i, moved; False if two neighbours are parallel."""
    h = homography
    for i in range(4):
        before = (i + 3) % 4
        a, b, c = lines[before, 0], lines[before, 1], lines[before, 2]
        d, e, f = lines[i, 0], lines[i, 1], lines[i, 2]
        sine = a * e - b * d
        if abs(sine) < _MIN_SINE:
            return False
        x, y = (c * e - b * f) / sine, (a * f - c * d) / sine
        w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
        out[i, 0] = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / w
        out[i, 1] = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / w
    return True


@njit(**OWNING, inline="always")
def fit_sides(grey, corners, reach_px, lens, frame):
    """Fit the four sides of the quadrilateral ``corners`` (4, 2), which must lie inside ``grey``.

    ``frame`` (3, 3) maps undistorted pixels to where lines are fitted. Returns lines (4, 6) there,
    a, b, c, rms with a x + b y = c and the standard errors at both ends, and each side's (4,) share
    of profiles with an edge on it.
    """
    lines = np.zeros((4, 6))
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
            use[i] = use[i] and w == w
            points[side, i, 0] = (frame[0, 0] * x + frame[0, 1] * y + frame[0, 2]) / w
            points[side, i, 1] = (frame[1, 0] * x + frame[1, 1] * y + frame[1, 2]) / w
        if use.sum() < 4:
            continue
        seen[side] = _fit_line(points[side], use, lines[side]) / count
        if seen[side] > 0.0:
            _errors_at(points[side], corners[side], corners[(side + 1) % 4], use, lines[side])
    return lines, seen


@njit(**OWNING)
def _edges_of_side(grey, start, end, reach_px, out_points, out_steps, out_shifts):
    """Locate one side's edge by profiles: the centroid of the rise from dark inside outwards."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = np.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return
    # clockwise on the screen: outwards is left of the direction of travel
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


@njit(**OWNING)
def _bilinear(grey, x, y):
    height, width = grey.shape
    x = min(max(x, 0.0), width - 1.0)
    y = min(max(y, 0.0), height - 1.0)
    x0, y0 = min(int(x), width - 2), min(int(y), height - 2)
    fx, fy = x - x0, y - y0
    above = grey[y0, x0] * (1.0 - fx) + grey[y0, x0 + 1] * fx
    below = grey[y0 + 1, x0] * (1.0 - fx) + grey[y0 + 1, x0 + 1] * fx
    return float(above * (1.0 - fy) + below * fy)


@njit(**OWNING)
def _most_in_line(points, use):
    """Mask of the edge points near the best line through two of a few of them.

    Fischler and Bolles, Random sample consensus, 1981, with all pairs.
    """
    chosen = np.flatnonzero(use)
    stations = min(_STATIONS, len(chosen))
    best = use
    most = 0
    for apart in range(stations - 1, 0, -1):
        for j in range(stations - apart):
            i = j + apart
            first = chosen[(2 * i + 1) * len(chosen) // (2 * stations)]
            second = chosen[(2 * j + 1) * len(chosen) // (2 * stations)]
            dx = points[first, 0] - points[second, 0]
            dy = points[first, 1] - points[second, 1]
            length = np.sqrt(dx * dx + dy * dy)
            if length == 0.0:
                continue
            a, b = -dy / length, dx / length
            c = a * points[first, 0] + b * points[first, 1]
            near = 0
            for k in chosen:
                near += abs(a * points[k, 0] + b * points[k, 1] - c) < _ON_LINE_PX
            if near > most:
                most = near
                best = use & (np.abs(a * points[:, 0] + b * points[:, 1] - c) < _ON_LINE_PX)
                if most >= _NEARLY_ALL * len(chosen):
                    return best
    return best


@njit(**OWNING, inline="always")
def _fit_line(points, use, out_line):
    """Fit one line by total least squares without outliers; return the number of points on it.

    ``use`` becomes those fitted.
    """
    in_line = _most_in_line(points, use)
    if in_line.sum() < 4:
        return 0
    for turn in range(2):
        n = 0
        mx = my = 0.0
        for i in range(len(points)):
            if in_line[i]:
                n += 1
                mx += points[i, 0]
                my += points[i, 1]
        mx, my = mx / n, my / n
        xx = xy = yy = 0.0
        for i in range(len(points)):
            if in_line[i]:
                ax, ay = points[i, 0] - mx, points[i, 1] - my
                xx, xy, yy = xx + ax * ax, xy + ax * ay, yy + ay * ay
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        a, b = -np.sin(angle), np.cos(angle)
        distance = np.abs((points[:, 0] - mx) * a + (points[:, 1] - my) * b)
        chosen = distance[in_line]
        out_line[0], out_line[1], out_line[2] = a, b, a * mx + b * my
        out_line[3] = np.sqrt(np.mean(chosen * chosen))
        limit = _OUTLIER_MADS * max(1.4826 * np.median(chosen), 0.05)
        kept = use & (distance < limit)
        if turn == 1 or kept.sum() < 4:
            break
        in_line = kept
    near = (use & (distance < _ON_LINE_PX)).sum()
    for i in range(len(use)):
        use[i] = in_line[i]
    return int(near)


@njit(**OWNING)
def _errors_at(points, start, end, use, out_line):
    """Write a fitted line's standard errors at a side's two ends to ``out_line[4:]``.

    A regression makes them larger at a covered end.
    """
    a, b = out_line[0], out_line[1]
    along = points[:, 0] * b - points[:, 1] * a
    middle = np.mean(along[use])
    spread = np.sum((along[use] - middle) ** 2)
    scatter_px = _ALIKE * max(out_line[3], _LEAST_SCATTER_PX)
    for i in range(2):
        x, y = (start[0], start[1]) if i == 0 else (end[0], end[1])
        away = x * b - y * a - middle
        out_line[4 + i] = scatter_px * np.sqrt(1.0 / use.sum() + away * away / max(spread, 1e-9))
