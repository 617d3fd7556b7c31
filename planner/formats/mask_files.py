"""Nav2's filter masks: keep-out zones and speed limits as a map's YAML with its picture.

- A speed mask's cell holds a number d from 0 to 100, as the map server reads the picture. Nav2's
  SpeedFilter limits a robot whose centre is there to base + multiplier * d, in percent of its
  largest speed or in m/s. There is no limit where d is 0 or unknown, where the result is 0 (Nav2's
  NO_SPEED_LIMIT), negative, or above 100 %, and off the mask.
- Masks are written in the mode ``scale``; of several limits in a cell the slowest is kept. A mask
  read from a file without yaw gives the same cells again at its own resolution.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from planner.formats.grid_maps import map_scene
from planner.formats.map_files import (
    MapHeader,
    ReadPicture,
    parse_map_header,
    read_cells,
    read_map_picture,
    read_text,
)
from planner.formats.map_writer import ON_EDGE, covered_cells, write_picture
from planner.scene import Bounds, Scene, SceneError

NO_LIMIT, MOST_DATA = 0, 100
"""Numbers of a cell without a limit, and of a wholly occupied one."""
BASE_PERCENT, MULTIPLIER_PERCENT = 100.0, -1.0
"""Nav2's own example: an occupied cell is slow, in percent (defined by nav2_bringup)."""
SCALE = "mode: scale\noccupied_thresh: 1.0\nfree_thresh: 0.0\n"


@dataclass(frozen=True, slots=True)
class SpeedLevel:
    """An area with one speed limit; the objects of ``area`` are its parts.

    ``speed_percent``, of the robot's largest speed, or ``speed_m_s`` is given.
    """

    area: Scene
    speed_percent: float | None = None
    speed_m_s: float | None = None

    def __post_init__(self) -> None:
        if (self.speed_percent is None) == (self.speed_m_s is None):
            raise ValueError("speed_percent, speed_m_s: must be one of them")
        name, most = ("speed_m_s", math.inf) if self.speed_percent is None else ("percent", 100.0)
        if not 0.0 < self.limit <= most or math.isinf(self.limit):
            limit = "> 0" if math.isinf(most) else "in 0..100, and not 0"
            raise ValueError(f"{name} = {self.limit:g}: must be {limit}")

    @property
    def limit(self) -> float:
        """The given limit, in its own unit."""
        given = self.speed_m_s if self.speed_percent is None else self.speed_percent
        return float(given or 0.0)

    def __str__(self) -> str:
        return f"{self.limit:.4g} {'m/s' if self.speed_percent is None else '%'}"


def load_mask(path: str | os.PathLike[str], *, read_picture: ReadPicture | None = None) -> Scene:
    """Load a keep-out mask of Nav2, a YAML file with its picture: each zone becomes an object.

    Raises :class:`SceneError` as :func:`load_scene`.
    """
    file = Path(path)
    free, unknown, _, pose = read_cells(read_text(file), file, read_picture)
    return map_scene(~free & ~unknown, pose, rim=False)


def mask_picture(path: str | os.PathLike[str]) -> Path:
    """Return the file of the picture that a mask's YAML names; errors as :func:`load_mask`."""
    file = Path(path)
    return file.parent / parse_map_header(read_text(file), str(file)).image


def load_speed_mask(
    path: str | os.PathLike[str],
    *,
    percent: bool = True,
    base: float = BASE_PERCENT,
    multiplier: float = MULTIPLIER_PERCENT,
    read_picture: ReadPicture | None = None,
) -> tuple[SpeedLevel, ...]:
    """Load a speed mask of Nav2: the areas of each limit, the slowest first.

    ``percent``, ``base`` and ``multiplier`` are those of Nav2's filter info server, whose types 1
    and 2 are percent and m/s. Raises :class:`SceneError` as :func:`load_scene`, and ``ValueError``
    unless base and multiplier are finite.
    """
    _check_scale(base, multiplier)
    file = Path(path)
    shade, transparent, header = read_map_picture(read_text(file), file, read_picture)
    data = cell_data(shade, transparent, header)
    areas: dict[float, NDArray[np.bool_]] = {}
    for number in np.unique(data[data > NO_LIMIT]).tolist():
        limit = _limit(number, base, multiplier, percent)
        if limit is not None:
            areas[limit] = areas.get(limit, np.zeros(data.shape, np.bool_)) | (data == number)
    return tuple(
        _level(map_scene(cells, header.pose, rim=False), limit, percent)
        for limit, cells in sorted(areas.items())
    )


def _level(area: Scene, limit: float, percent: bool) -> SpeedLevel:
    return SpeedLevel(area, limit, None) if percent else SpeedLevel(area, None, limit)


def _check_scale(base: float, multiplier: float) -> None:
    if not math.isfinite(base):
        raise ValueError(f"base = {base:g}: must be finite")
    if not math.isfinite(multiplier) or multiplier == 0.0:
        raise ValueError(f"multiplier = {multiplier:g}: must be finite and not 0")


def _limit(number: int, base: float, multiplier: float, percent: bool) -> float | None:
    limit = base + multiplier * number
    return limit if limit > 0.0 and (limit <= 100.0 or not percent) else None


def cell_data(
    shade: NDArray[np.float64], transparent: NDArray[np.bool_], header: MapHeader
) -> NDArray[np.int64]:
    """Return the numbers that Nav2's map server publishes, 0 to 100, -1 for unknown; row 0 the top.

    Like the server, it computes in 32 bits.
    """
    byte = np.rint(shade * 255.0)
    if header.mode == "raw":
        data = np.where(byte <= MOST_DATA, byte, -1.0)
    else:
        tone = byte.astype(np.float32) / np.float32(255.0)
        part = tone if header.negate else np.float32(1.0) - tone
        low, high = np.float32(header.free_thresh), np.float32(header.occupied_thresh)
        data = np.full(part.shape, -1.0)
        if header.mode == "scale" and high > low:
            between = (part > low) & (part < high)
            scaled = np.floor((part - low) / (high - low) * np.float32(100.0) + np.float32(0.5))
            data[between] = scaled[between]
        data[part >= high] = MOST_DATA
        data[part <= low] = NO_LIMIT
    data[transparent] = -1.0
    return data.astype(np.int64)


def save_mask(
    areas: Scene | Sequence[SpeedLevel],
    path: str | os.PathLike[str],
    resolution: float,
    *,
    base: float = BASE_PERCENT,
    multiplier: float = MULTIPLIER_PERCENT,
) -> None:
    """Write a keep-out mask of a scene's objects, or a speed mask of levels, for Nav2.

    ``path`` is a ``.yaml`` file; its picture is written beside it. The mask covers the bounds of
    the areas in cells of ``resolution`` metres. A limit that ``base`` and ``multiplier`` cannot
    express is rounded to the next slower one. Raises :class:`SceneError` if the areas are not in
    metres, a limit cannot be expressed, or writing fails.
    """
    _check_scale(base, multiplier)
    if isinstance(areas, Scene):
        data = np.where(covered_cells(areas, areas.bounds, resolution), MOST_DATA, NO_LIMIT)
        bounds = areas.bounds
    else:
        bounds = _bounds_of(areas)
        data = _speed_data(areas, bounds, resolution, base, multiplier)
    shades = np.rint(255.0 * (1.0 - data / MOST_DATA)).astype(np.uint8)
    write_picture(Path(path), shades, resolution, (bounds.x_min, bounds.y_min), SCALE)


def _bounds_of(levels: Sequence[SpeedLevel]) -> Bounds:
    if not levels:
        raise SceneError("levels: must be at least one")
    boxes = np.array([level.area.view for level in levels])
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    return Bounds(*low.tolist(), *high.tolist())


def _speed_data(
    levels: Sequence[SpeedLevel],
    bounds: Bounds,
    resolution: float,
    base: float,
    multiplier: float,
) -> NDArray[np.int64]:
    if len({level.speed_percent is None for level in levels}) > 1:
        raise SceneError("levels: must all be in percent, or all in m/s")
    data: NDArray[np.int64] | None = None
    for level in sorted(levels, key=lambda one: -one.limit):
        covered = covered_cells(level.area, bounds, resolution)
        data = np.zeros(covered.shape, np.int64) if data is None else data
        data[covered] = _number(level, base, multiplier)
    assert data is not None
    return data


def _number(level: SpeedLevel, base: float, multiplier: float) -> int:
    """Number of the fastest cell that is not faster than a limit."""
    percent = level.speed_percent is not None
    exact = (level.limit - base) / multiplier
    number = math.ceil(exact - ON_EDGE) if multiplier < 0.0 else math.floor(exact + ON_EDGE)
    number = max(number, 1) if multiplier < 0.0 else min(number, MOST_DATA)
    if not 1 <= number <= MOST_DATA or _limit(number, base, multiplier, percent) is None:
        raise SceneError(
            f"a limit of {level}: must be base {base:g} + multiplier {multiplier:g} x a number"
            " in 1..100"
        )
    return number
