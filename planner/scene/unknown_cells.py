"""Unseen cells of a grid map: obstacles to the planner, but named as unknown."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class UnknownCells:
    """Mask (h, w) of unknown cells, row 0 the top, and its place.

    ``x``, ``y`` and ``yaw_rad`` are the pose of the lower left corner of the lower left cell in the
    scene, y up; ``resolution`` is a cell's side.
    """

    mask: NDArray[np.bool_]
    resolution: float
    x: float
    y: float
    yaw_rad: float

    def __post_init__(self) -> None:
        mask = np.array(self.mask, dtype=np.bool_)
        mask.setflags(write=False)
        object.__setattr__(self, "mask", mask)

    def holds(self, x: float, y: float) -> bool:
        """True if the place lies in an unknown cell, or off the map."""
        dx, dy = x - self.x, y - self.y
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        column = math.floor((cos * dx + sin * dy) / self.resolution)
        row = len(self.mask) - 1 - math.floor((cos * dy - sin * dx) / self.resolution)
        height, width = self.mask.shape
        covered = 0 <= row < height and 0 <= column < width
        return not covered or bool(self.mask[row, column])
