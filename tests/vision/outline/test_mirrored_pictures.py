"""A picture mirrored, turned or shifted by whole pixels: the same records, there.

Rules and units
- The oracle is the picture's own first record, moved as the picture is. Nothing is allowed for
  but rounding: no search may depend on where a border begins or which way it is walked. Noise is
  told, not estimated: that is done from a sample of rows, which are others in a moved picture.
- Pixels, centres at integers, y down. Shapes of no symmetry of their own, at any place and angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from planner.scene import Arc, CircleRecord, PolygonRecord, Record
from tests.support.drawn.render import draw, polygon
from vision import extract

SIZE = 180
SAME_PX = 1e-5
SHIFT = (5, 3)
MOVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "mirrored": lambda a: a[:, ::-1],
    "upside down": lambda a: a[::-1],
    "transposed": lambda a: a.T,
    "a quarter turn": lambda a: np.rot90(a),
    "half a turn": lambda a: np.rot90(a, 2),
    "shifted": lambda a: np.roll(a, SHIFT[::-1], (0, 1)),
}


def blob(rng: np.random.Generator) -> np.ndarray:
    t = np.arange(400) * math.tau / 400
    r = rng.uniform(35, 60) * (1 + 0.2 * np.cos(3 * t) + 0.1 * np.cos(5 * t + rng.uniform(0, 6)))
    return np.stack([r * np.cos(t), r * np.sin(t)], axis=1)


def ellipse(rng: np.random.Generator) -> np.ndarray:
    t = np.arange(400) * math.tau / 400
    a, b = rng.uniform(40, 70), rng.uniform(15, 40)
    return np.stack([a * np.cos(t), b * np.sin(t)], axis=1)


def round_gear(rng: np.random.Generator) -> np.ndarray:
    teeth, size = int(rng.integers(6, 12)), rng.uniform(40, 70)
    t = np.arange(40 * teeth) * math.tau / (40 * teeth)
    r = np.where(np.arange(40 * teeth) % 40 < 20, size, 0.75 * size)
    return np.stack([r * np.cos(t), r * np.sin(t)], axis=1)


def spiral(rng: np.random.Generator) -> np.ndarray:
    t = np.linspace(0.0, rng.uniform(2.0, 2.8) * math.tau, 500)
    middle, half = 6.0 + rng.uniform(1.9, 2.3) * t, rng.uniform(2.5, 4.0)
    sides = [
        np.stack([(middle + s) * np.cos(t), (middle + s) * np.sin(t)], axis=1)
        for s in (half, -half)
    ]
    return np.concatenate([sides[0], sides[1][::-1]])


def hook(rng: np.random.Generator) -> np.ndarray:
    """An L with one round end."""
    t = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 60)
    end = np.stack([40 + 10 * np.cos(t), 10 + 10 * np.sin(t)], axis=1)
    rest = np.array([(10.0, 20.0), (10.0, rng.uniform(45, 60)), (-10.0, 55.0), (-10.0, 0.0)])
    return np.concatenate([end, rest])


SHAPES = {f.__name__: f for f in (blob, ellipse, round_gear, spiral, hook)}


def numbers(record: Record, places: np.ndarray) -> np.ndarray:
    """A record's edges in numbers, sorted; ``places`` (2, h, w) tells where a pixel came from."""

    def there(point: tuple[float, float]) -> tuple[float, float]:
        # places are linear in x and y
        x, y = point
        base = places[:, 0, 0]
        across, down = places[:, 0, 1] - base, places[:, 1, 0] - base
        moved = base + x * across + y * down
        return float(moved[0]), float(moved[1])

    if isinstance(record, CircleRecord):
        return np.array([[*there(record.center), record.radius]])
    assert isinstance(record, PolygonRecord)
    rows = []
    for edge in record.edges:
        middle, radius = (there(edge.center), edge.radius) if isinstance(edge, Arc) else ((0, 0), 0)
        ends = sorted([there(edge.start), there(edge.end)])
        rows.append([*ends[0], *ends[1], *middle, radius])
    return np.array(sorted(rows))


@pytest.mark.parametrize("noise", [0.0, 10.0, None])
@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_the_records_of_a_moved_picture_are_the_moved_records(
    shape: str, noise: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``noise`` None: drawn in black and white."""
    if noise:
        monkeypatch.setattr("vision.binarise.grey_picture.noise_sigma", lambda grey: noise)
    own = np.stack(np.meshgrid(np.arange(SIZE), np.arange(SIZE))).astype(np.float64)
    for seed in range(3):
        rng = np.random.default_rng([seed, len(shape)])
        angle = rng.uniform(0.0, math.tau)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        outline = SHAPES[shape](rng) @ turn.T
        outline += 0.5 * (SIZE - 1 - outline.min(axis=0) - outline.max(axis=0))
        outline += rng.uniform(-1.0, 1.0, 2)
        picture = draw([polygon(outline)], (SIZE, SIZE), noise=noise or 0.0, rng=rng)
        if noise is None:
            picture = np.where(picture < 128, 0, 255).astype(np.uint8)
        (first,) = extract(picture).objects
        truth = numbers(first.records[0], own)
        for name, move in MOVES.items():
            moved = np.ascontiguousarray(move(picture))
            (again,) = extract(moved).objects
            came = own - np.array(SHIFT, float)[:, None, None] if name == "shifted" else np.stack(
                [move(own[0]), move(own[1])]
            )  # fmt: skip
            found = numbers(again.records[0], came)
            assert found.shape == truth.shape, (name, seed)
            assert np.abs(found - truth).max() < SAME_PX, (name, seed)
