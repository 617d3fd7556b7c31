"""Walls and gaps three to five pixels wide: neither plateau beside an edge may be reached."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from planner.scene import PolygonRecord, Scene, object_records
from tests.support.drawn.render import coverage, outline_points
from vision import extract

DARK, LIGHT = 40.0, 215.0


def box(half_width: float, half_height: float, angle: float) -> np.ndarray:
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (half_width, half_height)
    turn = np.array(
        [[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]]
    )  # fmt: skip
    placed: np.ndarray = corners @ turn + (100.3, 99.6)
    return placed


def picture_of(covered: np.ndarray, blur_px: float, dark: float = DARK) -> np.ndarray:
    grey = cv2.GaussianBlur(LIGHT + (dark - LIGHT) * covered, (0, 0), blur_px)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def farthest_side_px(scene: Scene, truth: list[np.ndarray]) -> float:
    """The worst distance of the true sides' middle parts from the outlines found."""
    records = [r for o in scene.objects for r in object_records(o)]
    found = [outline_points(r) for r in records if isinstance(r, PolygonRecord)]
    begin = np.concatenate(found)
    way = np.concatenate([np.roll(points, -1, axis=0) for points in found]) - begin
    square = np.maximum((way**2).sum(axis=1), 1e-12)
    worst = 0.0
    for corners in truth:
        for share in (0.15, 0.35, 0.5, 0.65, 0.85):
            for place in corners + share * (np.roll(corners, -1, axis=0) - corners):
                along = np.clip(((place - begin) * way).sum(axis=1) / square, 0.0, 1.0)
                away = np.linalg.norm(place - begin - along[:, None] * way, axis=1)
                worst = max(worst, float(away.min()))
    return worst


@pytest.mark.parametrize("wall_px", [3.0, 3.5, 4.0, 5.0])
@pytest.mark.parametrize("blur_px", [0.5, 0.7, 1.0])
def test_a_narrow_wall_is_as_wide_as_it_is(wall_px: float, blur_px: float) -> None:
    outer, inner = box(66, 61, 0.09), box(66 - wall_px, 61 - wall_px, 0.09)
    covered = coverage([outer], (200, 200)) - coverage([inner], (200, 200))
    scene = extract(picture_of(covered, blur_px), method="fixed", threshold=127.5)
    assert farthest_side_px(scene, [outer, inner]) < 0.05


@pytest.mark.parametrize("gap_px", [3.0, 4.0, 5.0])
def test_a_narrow_gap_is_as_wide_as_it_is(gap_px: float) -> None:
    outer, inner = box(66, 61, 0.09), box(66 - gap_px, 61 - gap_px, 0.09)
    covered = 1.0 - coverage([outer], (200, 200)) + coverage([inner], (200, 200))
    scene = extract(picture_of(covered, 0.7), method="fixed", threshold=127.5)
    assert farthest_side_px(scene, [outer, inner]) < 0.05


def test_a_narrow_wall_lighter_than_the_level_supposes_keeps_its_own_half() -> None:
    outer, inner = box(66, 61, 0.09), box(62, 57, 0.09)
    covered = coverage([outer], (200, 200)) - coverage([inner], (200, 200))
    scene = extract(picture_of(covered, 0.7, dark=80.0), method="fixed", threshold=127.5)
    assert farthest_side_px(scene, [outer, inner]) < 0.1
