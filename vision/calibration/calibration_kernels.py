"""Removing and applying a lens.

Raw and undistorted pixels, centres at integers; ``lens`` from
``vision.calibration.lens_model.lens_arrays``. NaN for a pixel that no ray within the lens's reach
produces.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING
from vision.calibration.lens_model import FISHEYE, STRAIGHT

_MOST_STEPS = 50
_DONE, _GOOD = 1e-12, 1e-9
"""Normalised units: Newton's method stops, and must have reached this."""
_MOST_OVERSHOOT = 1.02
"""Brown's Jacobian is still positive definite so far beyond the reach."""


@njit(**OWNING)
def undistort(x_px, y_px, lens):
    """One raw pixel to an undistorted one."""
    if lens.model == STRAIGHT:
        return x_px, y_px
    camera = lens.camera
    tx, ty = (x_px - camera[2]) / camera[0], (y_px - camera[3]) / camera[1]
    if lens.model == FISHEYE:
        x, y = _undo_fisheye(tx, ty, lens.terms, lens.reach)
    else:
        x, y = _undo_brown(tx, ty, lens.terms, lens.reach)
    return x * camera[0] + camera[2], y * camera[1] + camera[3]


@njit(**OWNING)
def _undo_fisheye(tx, ty, terms, reach):
    """Newton's method on theta_d(theta), which grows, between closing bounds."""
    wanted = math.hypot(tx, ty)
    if wanted < _DONE:
        return tx, ty
    low, high = 0.0, math.atan(reach)
    if wanted > _angle_seen(high, terms):
        return math.nan, math.nan
    angle = min(wanted, high)
    error = math.inf
    for _ in range(_MOST_STEPS):
        error = _angle_seen(angle, terms) - wanted
        if abs(error) < _DONE:
            break
        if error > 0.0:
            high = angle
        else:
            low = angle
        a2 = angle * angle
        slope = 5.0 * terms[1] + a2 * (7.0 * terms[2] + a2 * 9.0 * terms[3])
        angle -= error / (1.0 + a2 * (3.0 * terms[0] + a2 * slope))
        if not low <= angle <= high:
            angle = 0.5 * (low + high)
    if abs(error) > _GOOD:
        return math.nan, math.nan
    ratio = math.tan(angle) / wanted
    return tx * ratio, ty * ratio


@njit(**OWNING)
def _angle_seen(angle, terms):
    """theta_d."""
    a2 = angle * angle
    even = 1.0 + a2 * (terms[0] + a2 * (terms[1] + a2 * (terms[2] + a2 * terms[3])))
    return float(angle * even)


@njit(**OWNING)
def _undo_brown(tx, ty, terms, reach):
    """Newton's method; a step that leaves the reach, or comes no nearer, is halved."""
    k1, k2, p1, p2, k3 = terms[0], terms[1], terms[2], terms[3], terms[4]
    limit = _MOST_OVERSHOOT * reach
    shrink = min(1.0, reach / max(math.hypot(tx, ty), _DONE))
    x, y = tx * shrink, ty * shrink
    step_x = step_y = 0.0
    before = error = math.inf
    for _ in range(_MOST_STEPS):
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        ex = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) - tx
        ey = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y - ty
        error = max(abs(ex), abs(ey))
        if error < _DONE:
            break
        if (r2 > limit * limit or error > before) and before > _GOOD:
            step_x, step_y = 0.5 * step_x, 0.5 * step_y
            x, y = x + step_x, y + step_y
            continue
        before = error
        slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
        a = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
        d = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
        b = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
        determinant = a * d - b * b
        if not determinant > 0.0:
            return math.nan, math.nan
        step_x, step_y = (d * ex - b * ey) / determinant, (a * ey - b * ex) / determinant
        x, y = x - step_x, y - step_y
    if error > _GOOD or x * x + y * y > reach * reach:
        return math.nan, math.nan
    return x, y


@njit(**OWNING)
def distort(x_px, y_px, lens):
    """One undistorted pixel to a raw one; NaN beyond the lens's reach."""
    if lens.model == STRAIGHT:
        return x_px, y_px
    camera, terms = lens.camera, lens.terms
    x, y = (x_px - camera[2]) / camera[0], (y_px - camera[3]) / camera[1]
    radius = math.hypot(x, y)
    if not radius <= lens.reach:
        return math.nan, math.nan
    if lens.model == FISHEYE:
        ratio = _angle_seen(math.atan(radius), terms) / radius if radius > 0.0 else 1.0
        tx, ty = x * ratio, y * ratio
    else:
        k1, k2, p1, p2, k3 = terms[0], terms[1], terms[2], terms[3], terms[4]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        tx = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        ty = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return tx * camera[0] + camera[2], ty * camera[1] + camera[3]


@njit(**OWNING)
def image_from_plane(points, homography, front, lens):
    """Points (n, 2) of a plane to raw pixels; NaN out of sight.

    ``homography`` (3, 3) leads to undistorted pixels; its third coordinate has the sign of
    ``front`` in front of the camera.
    """
    found = np.empty_like(points)
    for i in range(len(points)):
        x, y = _moved(points[i, 0], points[i, 1], homography, front)
        found[i, 0], found[i, 1] = distort(x, y, lens)
    return found


@njit(**OWNING)
def plane_from_image(points, homography, front, lens):
    """Raw pixels (n, 2) to points of a plane; NaN if they show none."""
    found = np.empty_like(points)
    for i in range(len(points)):
        x, y = undistort(points[i, 0], points[i, 1], lens)
        found[i, 0], found[i, 1] = _moved(x, y, homography, front)
    return found


@njit(**OWNING)
def _moved(x, y, h, front):
    """Move through a homography; NaN if the third coordinate lacks the sign of ``front``."""
    w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
    if not w * front > 0.0:
        return math.nan, math.nan
    return (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / w, (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / w


@njit(**OWNING)
def seen_at(x_m, y_m, view):
    """Raw pixel of one point of a plane; NaN out of sight."""
    x, y = _moved(x_m, y_m, view.to_pixel, view.front)
    return distort(x, y, view.lens)


@njit(**OWNING)
def placed_at(x_px, y_px, view):
    """Point of a plane that one raw pixel shows; NaN if it shows none."""
    x, y = undistort(x_px, y_px, view.lens)
    return _moved(x, y, view.from_pixel, view.front)
