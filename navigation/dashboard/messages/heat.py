"""The clearance of every place as a picture: exact at the middle of each cell.

Any thread may do this: a roadmap never changes, the kernel releases the interpreter, and `CELLS`
bounds its work.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from navigation.dashboard.messages.geometry import chain_clearances
from navigation.dashboard.messages.packed import pack
from navigation.draw.shapes import RAMP_STEPS
from planner.scene import Bounds
from planner.zones.zoned_roadmap import ZonedRoadmap

CELLS: Final = 20_000
BLOCKED: Final = 255
"""In an obstacle or out of the arena."""
TIGHT: Final = 254
"""Free, and too tight for the robot."""


def heat_message(zoned: ZonedRoadmap, window: Bounds, number: int) -> bytes:
    """``steps`` of the ramp, row by row from the top left, `TIGHT` or `BLOCKED`."""
    side = math.sqrt(window.width * window.height / CELLS)
    columns = max(1, math.floor(window.width / side))
    rows = max(1, math.floor(window.height / side))
    x = window.x_min + (np.arange(columns) + 0.5) * (window.width / columns)
    y = window.y_max - (np.arange(rows) + 0.5) * (window.height / rows)
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    clearances = zoned.clearance(places)
    low, high = _span(zoned)
    shares = (clearances - low) / max(high - low, 1e-9)
    steps = np.clip(np.rint(shares * (RAMP_STEPS - 1)), 0, RAMP_STEPS - 1).astype(np.uint8)
    steps[clearances < zoned.radius] = TIGHT
    steps[clearances < 0.0] = BLOCKED
    return pack("heat", {"number": number, "columns": columns, "rows": rows}, {"steps": steps})


def _span(zoned: ZonedRoadmap) -> tuple[float, float]:
    """Least and largest clearance on the robot's roadmap: the page's ramp."""
    first, rho = zoned.closed.clipped.chains.first, chain_clearances(zoned)
    pieces = [rho[first[c] : first[c + 1]] for c in zoned.closed.kept]
    if not pieces:
        return zoned.radius, 2.0 * zoned.radius
    values = np.concatenate(pieces)
    return float(values.min()), float(values.max())
