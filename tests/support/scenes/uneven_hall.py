"""A map that fits onto itself in one place only: for graphs of other frames."""

from __future__ import annotations

import numpy as np

from planner.formats.grid_maps import GridPose, map_scene
from planner.scene import Scene

CELL = 0.05


def hall() -> Scene:
    """A map of 16 m x 12 m with rooms and pillars, and no symmetry."""
    cells = np.zeros((240, 320), bool)
    cells[:4] = cells[-4:] = cells[:, :4] = cells[:, -4:] = True
    cells[100:106, :200] = True
    cells[100:106, 60:90] = False
    cells[:100, 150:156] = True
    cells[40:70, 150:156] = False
    cells[106:, 230:236] = True
    cells[180:210, 230:236] = False
    cells[150:190, 60:110] = True
    cells[30:60, 230:290] = True
    return map_scene(cells, GridPose(CELL, -3.0, 2.0, 0.0))
