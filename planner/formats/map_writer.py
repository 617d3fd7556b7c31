"""A scene as a ROS map: a YAML header and a PGM picture that Nav2's map_server loads.

A cell is occupied if it contains part of an obstacle or its border, so no obstacle shrinks; a
border along the cell's edge does not count. Cells across the bounds are occupied too. Map and scene
are in metres with y up. A scene read from a ROS map gives the same cells again at its own
resolution.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SceneError,
    Vec,
    object_records,
    record_edges,
)

OCCUPIED, FREE_BYTE = 0, 254
TRINARY = "mode: trinary\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
MOST_CELLS = 100_000_000
ON_EDGE = 1e-6
"""A border nearer to a cell's edge, in cells, runs along it."""
SAGITTA = 0.01
"""Largest gap between arc and chords, in cells, which are occupied to the outside of that."""


def write_map(scene: Scene, path: str | os.PathLike[str], resolution: float) -> None:
    """Write ``path``, a ``.yaml`` file, and its picture beside it.

    ``resolution`` is a cell's side in metres. Raises :class:`SceneError` if the scene is not in
    metres, the resolution is senseless, or writing fails.
    """
    file = Path(path)
    occupied = occupied_cells(scene, resolution)
    shades = np.where(occupied, OCCUPIED, FREE_BYTE).astype(np.uint8)
    b = scene.bounds
    write_picture(file, shades, resolution, (b.x_min, b.y_min), TRINARY)


def write_picture(
    file: Path, shades: NDArray[np.uint8], resolution: float, origin: Vec, thresholds: str
) -> None:
    """Write a map's YAML and its PGM; row 0 of ``shades`` is at the least y.

    ``thresholds`` are the YAML's lines with mode and thresholds. :class:`SceneError` if writing
    fails.
    """
    picture = file.with_suffix(".pgm")
    header = (
        f"image: {picture.name}\nresolution: {resolution!r}\n"
        f"origin: [{origin[0]!r}, {origin[1]!r}, 0.0]\nnegate: 0\n{thresholds}"
    )
    rows, columns = shades.shape
    try:
        picture.write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + shades[::-1].tobytes())
        file.write_text(header, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{file}: {error.strerror or error}") from None


def occupied_cells(scene: Scene, resolution: float) -> NDArray[np.bool_]:
    """Occupied cells as (rows, columns), row 0 at the bounds' least y.

    Errors as :func:`write_map`.
    """
    occupied = covered_cells(scene, scene.bounds, resolution)
    rows, columns = occupied.shape
    b = scene.bounds
    occupied[:, b.width / resolution + ON_EDGE < np.arange(1, columns + 1)] = True
    occupied[b.height / resolution + ON_EDGE < np.arange(1, rows + 1)] = True
    return occupied


def covered_cells(scene: Scene, b: Bounds, resolution: float) -> NDArray[np.bool_]:
    """Cells that contain part of an object, as (rows, columns), row 0 at ``b``'s least y.

    Errors as :func:`write_map`.
    """
    if scene.units != "m":
        raise SceneError(f"a scene in {scene.units}: a ROS map is in metres, calibrate it first")
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise SceneError(f"resolution = {resolution:g}: must be > 0 and finite")
    columns, rows = (max(1, math.ceil(side / resolution - ON_EDGE)) for side in (b.width, b.height))
    if columns * rows > MOST_CELLS:
        raise SceneError(
            f"resolution = {resolution:g}: {columns} x {rows} cells, the limit is {MOST_CELLS:g}"
        )
    occupied = np.zeros((rows, columns), dtype=np.bool_)
    origin = np.array([b.x_min, b.y_min])
    for obj in scene.objects:
        rings = []
        for record in object_records(obj):
            line = (_chain(record, scene.y_down, SAGITTA * resolution) - origin) / resolution
            _mark(occupied, _cells_along(line))
            if isinstance(record, PolygonRecord | CircleRecord):
                rings.append(line)
        if rings:
            _fill(occupied, rings)
    return occupied


def _chain(record: Record, y_down: bool, sagitta: float) -> FloatArray:
    """Border as (n, 2); chords of an arc lie at most sagitta outside it."""
    if isinstance(record, PointRecord):
        return np.array([record.at, record.at])
    points: list[FloatArray] = []
    for edge in record_edges(record):
        if not isinstance(edge, Arc):
            points += [np.array([edge.start]), np.array([edge.end])]
            continue
        begin, sweep = edge.sweep(y_down)
        step = 2.0 * math.acos(1.0 / (1.0 + min(sagitta / edge.radius, 1.0)))
        count = max(2, math.ceil(abs(sweep) / step))
        middles = begin + sweep * (np.arange(count) + 0.5) / count
        out = edge.radius / math.cos(0.5 * sweep / count)
        bent = np.array(edge.center) + out * np.c_[np.cos(middles), np.sin(middles)]
        points += [np.array([edge.start]), bent, np.array([edge.end])]
    return np.concatenate(points)


def _cells_along(line: FloatArray) -> FloatArray:
    """One place (n, 2) inside each cell that the line crosses, in units of cells."""
    return np.concatenate([*(_crossed(a, b) for a, b in pairwise(line)), line])


def _crossed(a: FloatArray, b: FloatArray) -> FloatArray:
    cuts = [np.array([0.0, 1.0])]
    for axis in range(2):
        low, high = sorted((a[axis], b[axis]))
        lines = np.arange(math.ceil(low), math.floor(high) + 1)
        if high > low:
            cuts.append((lines - a[axis]) / (b[axis] - a[axis]))
    t = np.sort(np.concatenate(cuts).clip(0.0, 1.0))
    middles: FloatArray = a + 0.5 * (t[1:] + t[:-1])[:, None] * (b - a)
    return middles


def _mark(occupied: NDArray[np.bool_], places: FloatArray) -> None:
    off = np.abs(places - np.rint(places))
    inside = places[(off > ON_EDGE).all(axis=1)]
    cell = np.floor(inside).astype(np.int64)
    rows, columns = occupied.shape
    ok = ((cell >= 0) & (cell < (columns, rows))).all(axis=1)
    occupied[cell[ok, 1], cell[ok, 0]] = True


def _fill(occupied: NDArray[np.bool_], rings: list[FloatArray]) -> None:
    """Occupy cells with their centre inside the rings, by even-odd along every row."""
    rows, columns = occupied.shape
    crossings: dict[int, list[float]] = {}
    for row, x in _row_crossings(rings):
        if 0 <= row < rows:
            crossings.setdefault(row, []).append(x)
    for row, xs in crossings.items():
        xs.sort()
        for low, high in zip(xs[::2], xs[1::2], strict=True):
            first = max(0, math.ceil(low - 0.5))
            last = min(columns, math.floor(high - 0.5) + 1)
            occupied[row, first : max(first, last)] = True


def _row_crossings(rings: list[FloatArray]) -> Iterator[tuple[int, float]]:
    """Row and x of the rings' crossings with the lines through the cells' centres."""
    for ring in rings:
        for (ax, ay), (bx, by) in zip(ring.tolist(), np.roll(ring, -1, 0).tolist(), strict=True):
            low, high = min(ay, by), max(ay, by)
            for row in range(math.ceil(low - 0.5), math.ceil(high - 0.5)):
                yield row, ax + (row + 0.5 - ay) * (bx - ax) / (by - ay)
