"""Patches of a picture, found again where they are, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.drawn.floor import BOUNDS, floor_texture, hanging, photograph
from vision.watch.fixed_points import FixedPoint, PointMeter, corners_of, point_at

NO_DISCS = np.empty((0, 3))
CAMERA = hanging()
FLOOR = floor_texture({})
PICTURE = photograph(CAMERA, FLOOR, np.random.default_rng(1))


def corners() -> list[FixedPoint]:
    return corners_of(PICTURE, NO_DISCS, CAMERA, BOUNDS)


def truly_moved(points: list[FixedPoint], other: object) -> np.ndarray:
    places = CAMERA.arena_from_image([p.place_px for p in points])
    return other.image_from_arena(places) - [p.place_px for p in points]  # type: ignore[attr-defined]


def test_corners_are_those_of_the_boxes_and_far_apart() -> None:
    points = corners()
    assert 6 <= len(points) <= 12
    places = np.array([p.place_px for p in points])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 1e9 * np.eye(len(points))
    assert apart.min() >= 640 / 12


def test_corners_at_the_border_come_first() -> None:
    """The box at x = 0.02 stands at the arena's border."""
    first = CAMERA.arena_from_image([corners()[0].place_px])[0]
    assert first[0] < 0.15


@pytest.mark.parametrize("tilt_deg", [(0.3, 0.0), (0.0, -0.4), (0.25, 0.25)])
@pytest.mark.parametrize("gain", [1.0, 0.8])
def test_a_tilt_is_measured_to_a_tenth_of_a_pixel(
    tilt_deg: tuple[float, float], gain: float
) -> None:
    points = corners()
    other = hanging((1.0 + tilt_deg[0], -1.5 + tilt_deg[1]))
    picture = photograph(other, FLOOR, np.random.default_rng(2), gain)
    readings = PointMeter(points).measure(picture, NO_DISCS)
    assert readings.seen.all()
    wanted = truly_moved(points, other)
    assert np.abs(wanted).max() > 2.0
    assert np.abs(readings.moved_px - wanted).max() < 0.15


def test_one_picture_and_the_next_differ_by_hundredths() -> None:
    points = corners()
    meter = PointMeter(points)
    rng = np.random.default_rng(3)
    moved = np.stack(
        [meter.measure(photograph(CAMERA, FLOOR, rng), NO_DISCS).moved_px for _ in range(6)]
    )
    assert moved.std(axis=0).max() < 0.1
    assert np.abs(moved).max() < 0.3


def test_a_point_farther_away_is_found_within_a_second_by_turns() -> None:
    points = corners()
    meter = PointMeter(points)
    other = hanging((3.5, -1.5))  # 25 px
    picture = photograph(other, FLOOR, np.random.default_rng(2))
    for _ in range(30):
        readings = meter.measure(picture, NO_DISCS)
    wanted = truly_moved(points, other)
    inside = readings.seen
    assert np.count_nonzero(inside) > len(points) // 2
    assert np.abs(readings.moved_px - wanted)[inside].max() < 0.3


def test_what_is_under_a_robot_is_covered_and_what_is_painted_over_is_gone() -> None:
    points = corners()
    x, y = points[0].place_px
    picture = PICTURE.copy()
    column, row = round(points[1].place_px[0]), round(points[1].place_px[1])
    picture[row - 30 : row + 30, column - 30 : column + 30] = 205
    readings = PointMeter(points).measure(picture, np.array([[x, y, 20.0]]))
    assert readings.covered[0]
    assert not readings.seen[0]
    assert not readings.covered[1]
    # what is left of the box may look like it, but not there
    assert not np.hypot(*readings.moved_px[1]) < 5.0
    assert readings.seen[2:].sum() >= len(points) - 4


def test_a_plain_floor_has_no_fixed_points_and_neither_has_a_repeated_pattern() -> None:
    plain = photograph(CAMERA, floor_texture({}, ()), np.random.default_rng(4))[80:400, 120:520]
    assert corners_of(np.ascontiguousarray(plain), NO_DISCS, CAMERA, BOUNDS) == []
    tiles = np.kron(np.indices((24, 32)).sum(axis=0) % 2, np.ones((20, 20)))
    chess = (45 + 160 * tiles).astype(np.uint8)
    assert corners_of(chess, NO_DISCS, CAMERA, BOUNDS) == []


def test_a_patch_that_leaves_the_picture_is_none() -> None:
    assert point_at(PICTURE, (5.0, 200.0), "x", 12, None) is None
