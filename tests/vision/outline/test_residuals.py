"""What a record's residual says: how far the outline that is written lies from the border.

Rules and units
- The oracle is the truth that a picture without noise is drawn from: what an outline misses there
  is what its fit left over, but for what blur moves. Pixels, centres at integers, y down.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.scene import PolygonRecord
from tests.support.drawn.render import draw, outline_points, polygon
from tests.vision.outline.test_mirrored_pictures import SIZE, blob, ellipse, spiral
from vision import extract

SAME = 1.25
"""By how much the residual may differ from the truth's: both are of the same cause."""
STEP_PX = 0.5


def along(outline: np.ndarray) -> np.ndarray:
    """Points at equal distances along a closed outline (n, 2)."""
    closed = np.concatenate([outline, outline[:1]])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.arange(0.0, way[-1], STEP_PX)
    return np.stack([np.interp(at, way, closed[:, c]) for c in (0, 1)], axis=1)


def off(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """How far each of the points (k, 2) lies from a closed outline (n, 2): (k,)."""
    sides = np.roll(outline, -1, axis=0) - outline
    squares = np.maximum((sides**2).sum(axis=1), 1e-18)
    away = points[:, None] - outline[None]
    t = np.clip((away * sides).sum(axis=2) / squares, 0.0, 1.0)
    nearest: np.ndarray = np.hypot(*np.moveaxis(away - t[..., None] * sides, 2, 0)).min(axis=1)
    return nearest


@pytest.mark.parametrize("shape", [blob, ellipse, spiral])
def test_the_residual_is_that_of_the_written_outline(shape) -> None:
    shares = []
    for seed in range(6):
        rng = np.random.default_rng([seed, 7])
        angle = rng.uniform(0.0, math.tau)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        outline = shape(rng) @ turn.T
        outline += 0.5 * (SIZE - 1 - outline.min(axis=0) - outline.max(axis=0))
        (only,) = extract(draw([polygon(outline)], (SIZE, SIZE), rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        away = off(along(outline_points(record)), outline)
        shares.append(record.residual_px / math.sqrt(float(np.mean(away**2))))
    assert min(shares) > 1.0 / SAME, shares
    assert max(shares) < SAME, shares
