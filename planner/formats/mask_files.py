"""Nav2's filter masks: keep-out zones and speed limits as a map's YAML with its picture.

- A speed mask's cell holds a number d from 0 to 100, as the map server reads the picture. Nav2's
  SpeedFilter limits a robot whose centre is there to base + multiplier * d, in percent of its
  largest speed or in m/s. There is no limit where d is 0 or unknown, where the result is 0 (Nav2's
  NO_SPEED_LIMIT), negative, or above 100 %, and off the mask.
"""

from __future__ import annotations

import math
import os
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
from planner.scene import Scene

NO_LIMIT, MOST_DATA = 0, 100
"""Numbers of a cell without a limit, and of a wholly occupied one."""
BASE_PERCENT, MULTIPLIER_PERCENT = 100.0, -1.0
"""Nav2's own example: an occupied cell is slow, in percent (defined by nav2_bringup)."""


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
