"""Stillness of a board: its corners' common movement compared with their noise.

Rules and units
- Pixels from one frame to the next, seconds by the frames' own times.
- An affine map's part of the corners' change is movement, the rest noise. Still means, for
  ``STILL_S``, less than ``STILL_PX`` or than noise can feign.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from vision.calibrate.board import BoardView, common_corners

STILL_S: Final = 0.5
"""Longer than a hand passes a place, shorter than one can hold a board."""
STILL_PX: Final = 0.75
"""1 mm of tremor at 1.5 m; it blurs less than a lens does."""
LONGEST_GAP_S: Final = 0.4
"""Frames further apart show nothing between them."""
FEWEST_CORNERS: Final = 8
_NOISES: Final = 3.0


class BoardStillness:
    """Tracker of a board's stillness; give it each view in turn."""

    def __init__(self) -> None:
        self._last: tuple[float, BoardView] | None = None
        self._since_s: float | None = None

    def add(self, now_s: float, view: BoardView | None) -> float:
        """Stillness, from 0 (moving) to 1 (still for ``STILL_S``)."""
        last, self._last = self._last, None if view is None else (now_s, view)
        if view is None or last is None or not 0.0 < now_s - last[0] <= LONGEST_GAP_S:
            self._since_s = None
            return 0.0
        movement = _movement(last[1], view)
        if movement is None or movement[0] > max(STILL_PX, movement[1]):
            self._since_s = None
            return 0.0
        if self._since_s is None:
            self._since_s = last[0]
        return min(1.0, (now_s - self._since_s) / STILL_S)

    def begin_again(self) -> None:
        """Restart the time of stillness."""
        self._since_s = None


def _movement(before: BoardView, after: BoardView) -> tuple[float, float] | None:
    """Common movement and the most that noise feigns of it, rms px; None with few corners.

    An affine map fitted to noise of spread s on n corners moves them by s sqrt(6 / n) rms.
    """
    here, there = common_corners(before, after)
    if len(here) < FEWEST_CORNERS:
        return None
    start = before.corners_px[here]
    steps = after.corners_px[there] - start
    basis = np.column_stack([start - start.mean(axis=0), np.ones(len(start))])
    together = basis @ np.linalg.lstsq(basis, steps, rcond=None)[0]
    n = len(start)
    noise = math.sqrt(float(np.sum((steps - together) ** 2)) / (2 * n - 6))
    movement = math.sqrt(float(np.mean(np.sum(together**2, axis=1))))
    return movement, _NOISES * noise * math.sqrt(6.0 / n)
