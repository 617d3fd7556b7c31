"""A plan's legs as one path, measured as a whole."""

from __future__ import annotations

import numpy as np

from planner.borders import box_tree_kernels
from planner.borders.generators import Borders
from planner.borders.polyline import length_of
from planner.path import Path
from planner.route.plan_request import Request
from planner.route.taut import judge
from planner.scene import FloatArray


def as_path(
    borders: Borders,
    legs: list[FloatArray],
    radius: float,
    request: Request,
    order: tuple[int, ...],
) -> Path:
    """Join the legs (n, 2) into one proved path."""
    points = [legs[0][:1]]
    stations = [0]
    for leg in legs:
        points.append(leg[1:])
        stations.append(stations[-1] + len(leg) - 1)
    polyline = np.concatenate(points)
    gap, x, y, _, _ = box_tree_kernels.polyline_clearance(borders.tree, polyline)
    rho, _ = borders.distances(polyline)
    # writable arrays: others would compile the kernel once more
    cost = judge(borders, polyline, radius + request.margin, request.preference)
    for array in (polyline, rho):
        array.setflags(write=False)
    return Path(
        points=polyline,
        clearances=rho,
        length=length_of(polyline),
        min_clearance=gap,
        min_clearance_at=(x, y),
        robot_radius=radius,
        stations=tuple(stations),
        headings_rad=request.headings_rad,
        order=order,
        cost=cost,
    )
