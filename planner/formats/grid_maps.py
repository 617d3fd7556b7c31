"""Exact grid maps: an obstacle is the union of its cells.

Cell (i, j) is column i, row j from the top; it covers [i - 1/2, i + 1/2] x [j - 1/2, j + 1/2] in
cells, y down. Cells that touch, even at a corner only, belong to one object; free cells that touch
only at a corner are not connected. Outlines run clockwise on the screen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.scene import (
    Bounds,
    FloatArray,
    PolygonRecord,
    Scene,
    SceneError,
    SceneObject,
    Segment,
    UnknownCells,
    Vec,
)

EAST, SOUTH, WEST, NORTH = 0, 1, 2, 3

IndexArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class GridPose:
    """A map's lower left corner, its rotation, and the size of a cell."""

    resolution: float
    x: float
    y: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class _Borders:
    """Segments of all borders."""

    start: IndexArray  # (k, 2) column, row of grid vertices
    end: IndexArray  # (k, 2)
    heading: IndexArray  # (k,)
    loops: list[list[int]]  # segments, in order


def grid_scene(obstacle: NDArray[np.bool_], remarks: tuple[str, ...] = ()) -> Scene:
    """Return the scene of an (h, w) grid in units of cells; True is an obstacle.

    O(cells) in numpy, O(segments) in Python. Raises :class:`SceneError` on an empty grid.
    """
    height, width = _checked_shape(obstacle)

    def place(vertices: IndexArray) -> FloatArray:
        corners: FloatArray = np.subtract(vertices, 0.5, dtype=np.float64)
        return corners

    return Scene(
        units="cells",
        bounds=Bounds(-0.5, -0.5, width - 0.5, height - 0.5),
        objects=_objects(obstacle, place),
        size=(width, height),
        border_pixels=_border_cells(obstacle),
        remarks=remarks,
    )


def map_scene(
    obstacle: NDArray[np.bool_],
    pose: GridPose,
    remarks: tuple[str, ...] = (),
    unknown: NDArray[np.bool_] | None = None,
    *,
    rim: bool = True,
) -> Scene:
    """Return the scene of an (h, w) grid in metres, y up, as a ROS map: row 0 is the top.

    ``unknown`` (h, w) marks obstacle cells of unknown content. A turned map lies in an upright
    rectangle; the outside is an obstacle with a rim one cell wide, unless ``rim`` is False. Raises
    :class:`SceneError` on an empty grid.
    """
    height, width = _checked_shape(obstacle)
    turned = math.sin(pose.yaw_rad) != 0.0 or math.cos(pose.yaw_rad) < 0.0
    cos, sin = (math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)) if turned else (1.0, 0.0)
    wide = 1 if turned and rim else 0

    def place(vertices: IndexArray) -> FloatArray:
        x = (vertices[:, 0] - wide) * pose.resolution
        y = (height - (vertices[:, 1] - wide)) * pose.resolution
        return np.stack([pose.x + (cos * x - sin * y), pose.y + (sin * x + cos * y)], axis=1)

    corners = [(c, r) for c in (0, width + 2 * wide) for r in (0, height + 2 * wide)]
    xs, ys = place(np.array(corners)).T.tolist()
    bounds = Bounds(min(xs), min(ys), max(xs), max(ys))
    objects = _objects(np.pad(obstacle, wide, constant_values=True), place)
    if wide:
        objects = (_fill_rectangle(objects[0], bounds), *objects[1:])
    return Scene(
        units="m",
        bounds=bounds,
        objects=objects,
        size=(width, height),
        border_pixels=_border_cells(obstacle),
        remarks=remarks,
        unknown=_placed(obstacle & False if unknown is None else unknown, pose),
    )


def _placed(unknown: NDArray[np.bool_], pose: GridPose) -> UnknownCells:
    return UnknownCells(unknown, pose.resolution, pose.x, pose.y, pose.yaw_rad)


def _checked_shape(obstacle: NDArray[np.bool_]) -> tuple[int, int]:
    if obstacle.ndim != 2 or obstacle.size == 0:
        raise SceneError(f"grid of shape {obstacle.shape}: must have rows and columns")
    return obstacle.shape[0], obstacle.shape[1]


def _fill_rectangle(rim: SceneObject, bounds: Bounds) -> SceneObject:
    x0, y0, x1, y1 = bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max
    corners = [(x0, y1), (x1, y1), (x1, y0), (x0, y0)]
    sides = tuple(Segment(corners[k], corners[(k + 1) % 4]) for k in range(4))
    return SceneObject(rim.id, (PolygonRecord(sides),), rim.holes)


def _border_cells(obstacle: NDArray[np.bool_]) -> int:
    """Obstacle cells with a free side neighbour or on the map's edge: the paper's n."""
    free = np.pad(~obstacle, 1, constant_values=True)
    beside = free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:]
    return int(np.count_nonzero(obstacle & beside))


def _objects(
    obstacle: NDArray[np.bool_], place: Callable[[IndexArray], FloatArray]
) -> tuple[SceneObject, ...]:
    borders = _trace(np.ascontiguousarray(obstacle, dtype=np.bool_))
    positions: list[Vec] = [(x, y) for x, y in place(borders.start).tolist()]
    outlines: list[PolygonRecord] = []
    holes: list[list[tuple[PolygonRecord, ...]]] = []
    for segments, parent in zip(borders.loops, _parents(obstacle, borders), strict=True):
        ring = [positions[s] for s in segments]
        after = [*ring[1:], ring[0]]
        record = PolygonRecord(tuple(map(Segment, ring, after)))
        if parent < 0:
            outlines.append(record)
            holes.append([])
        else:
            holes[parent].append((record,))
    return tuple(
        SceneObject(number, (outline,), tuple(inside))
        for number, (outline, inside) in enumerate(zip(outlines, holes, strict=True))
    )


def _trace(obstacle: NDArray[np.bool_]) -> _Borders:
    """Every border as a closed loop of longest segments, the obstacle on the right."""
    cell = np.pad(obstacle, 1).view(np.int8)
    across = cell[1:, :] - cell[:-1, :]  # +1: the obstacle begins below this row of edges
    along = cell[:, 1:] - cell[:, :-1]  # +1: the obstacle begins right of this edge
    # horizontal edges run east above an obstacle and west below; vertical ones north left of it and
    # south right of it
    h_first, h_last, h_sign = _runs(across)
    v_first, v_last, v_sign = _runs(np.ascontiguousarray(along.T))
    # a run of sign s between vertices: (row, column) for across, (column, row) for along
    h_heading = np.where(h_sign > 0, EAST, WEST)
    v_heading = np.where(v_sign > 0, NORTH, SOUTH)
    h0 = np.stack([h_first[:, 1] - 1, h_first[:, 0]], axis=1)
    h1 = np.stack([h_last[:, 1], h_last[:, 0]], axis=1)
    v0 = np.stack([v_first[:, 0], v_first[:, 1] - 1], axis=1)
    v1 = np.stack([v_last[:, 0], v_last[:, 1]], axis=1)
    start = np.concatenate(
        [
            np.where((h_sign > 0)[:, None], h0, h1),
            np.where((v_sign > 0)[:, None], v1, v0),
        ]
    )
    end = np.concatenate(
        [
            np.where((h_sign > 0)[:, None], h1, h0),
            np.where((v_sign > 0)[:, None], v0, v1),
        ]
    )
    heading = np.concatenate([h_heading, v_heading]).astype(np.int64)
    order = np.lexsort((heading, start[:, 0], start[:, 1]))
    start, end, heading = start[order], end[order], heading[order]
    follower = _followers(start, end, heading, obstacle.shape[1] + 1)
    return _Borders(start, end, heading, _loops(follower))


def _runs(sign: NDArray[np.int8]) -> tuple[IndexArray, IndexArray, IndexArray]:
    """First and last (row, column) and sign of equal non-zero runs along the rows.

    Where four cells meet like a chess board the sign flips, so a run ends there.
    """
    edge = np.pad(sign, ((0, 0), (1, 1)))
    change = edge[:, 1:] != edge[:, :-1]
    first = np.argwhere(change[:, :-1] & (sign != 0))
    last = np.argwhere(change[:, 1:] & (sign != 0))
    return first, last, sign[first[:, 0], first[:, 1]].astype(np.int64)


def _followers(start: IndexArray, end: IndexArray, heading: IndexArray, columns: int) -> list[int]:
    """Follower of each segment: left if both turns are open, so that corners join cells."""
    key = (start[:, 1] * columns + start[:, 0]) * 4 + heading
    at_end = (end[:, 1] * columns + end[:, 0]) * 4
    left = _find(key, at_end + (heading + 3) % 4)
    right = _find(key, at_end + (heading + 1) % 4)
    follower: list[int] = np.where(left >= 0, left, right).tolist()
    return follower


def _find(sorted_keys: IndexArray, wanted: IndexArray) -> IndexArray:
    if sorted_keys.size == 0:
        return np.empty(0, dtype=np.int64)
    index = np.minimum(np.searchsorted(sorted_keys, wanted), sorted_keys.size - 1)
    return np.where(sorted_keys[index] == wanted, index, -1)


def _loops(follower: list[int]) -> list[list[int]]:
    loops = []
    done = bytearray(len(follower))
    for first in range(len(follower)):
        if done[first]:
            continue
        loop, segment = [], first
        while not done[segment]:
            done[segment] = 1
            loop.append(segment)
            segment = follower[segment]
        loops.append(loop)
    return loops


def _parents(obstacle: NDArray[np.bool_], borders: _Borders) -> list[int]:
    """For each loop, -1 if it is an outline, else the number of the outline around it.

    A loop's first vertex is its topmost, leftmost one: an outline leaves it eastwards. Steps to the
    left of a hole end at its outline.
    """
    loop_of = np.empty(len(borders.heading), dtype=np.int64)
    for number, loop in enumerate(borders.loops):
        loop_of[loop] = number
    outline_number: dict[int, int] = {}
    holes: list[int] = []
    for number, loop in enumerate(borders.loops):
        if borders.heading[loop[0]] == EAST:
            outline_number[number] = len(outline_number)
        else:
            holes.append(number)
    parent = [-1] * len(borders.loops)
    if not holes:
        return parent
    left_loop = _left_neighbours(obstacle, borders, loop_of, holes)
    for hole in holes:
        outer = hole
        while outer not in outline_number:
            outer = left_loop[outer]
        parent[hole] = outline_number[outer]
    return parent


def _left_neighbours(
    obstacle: NDArray[np.bool_], borders: _Borders, loop_of: IndexArray, holes: list[int]
) -> dict[int, int]:
    height, width = obstacle.shape
    flat = obstacle.ravel()
    begins = obstacle.copy()
    begins[:, 1:] &= ~obstacle[:, :-1]
    run_starts = np.flatnonzero(begins.ravel())
    # edges with the obstacle on their right run north; sorted by column and row of their top
    north = np.flatnonzero(borders.heading == NORTH)
    top = borders.end[north, 1]
    order = np.lexsort((top, borders.start[north, 0]))
    north, top = north[order], top[order]
    keys = borders.start[north, 0] * (height + 1) + top
    result = {}
    for hole in holes:
        loop = np.array(borders.loops[hole])
        south = loop[borders.heading[loop] == SOUTH]
        leftmost = south[np.argmin(borders.start[south, 0])]
        column, row = borders.start[leftmost].tolist()
        cell = row * width + column - 1
        if not flat[cell]:
            raise SceneError("grid border tracing lost its way: please report the map")
        begin = int(run_starts[np.searchsorted(run_starts, cell, side="right") - 1])
        key = (begin % width) * (height + 1) + row
        edge = north[np.searchsorted(keys, key, side="right") - 1]
        result[hole] = int(loop_of[edge])
    return result
