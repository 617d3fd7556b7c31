"""Contour following against connected components, brute force and the paper's Laplacian."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vision.borders.contours import Contours, follow_borders, laplacian_border

MASKS = arrays(
    np.uint8,
    st.tuples(st.integers(1, 14), st.integers(1, 14)),
    elements=st.integers(0, 1),
)


def padded(mask: np.ndarray) -> np.ndarray:
    height, width = mask.shape
    result = np.zeros((height + 2, (width + 9) // 8 * 8), np.uint8)
    result[1:-1, 1 : width + 1] = mask
    return result


def followed(mask: np.ndarray) -> Contours:
    return follow_borders(padded(mask))


@settings(max_examples=300, deadline=None)
@given(MASKS)
def test_every_component_has_one_outline_and_every_hole_one_border(mask: np.ndarray) -> None:
    borders = followed(mask)
    objects = cv2.connectedComponents(mask, connectivity=8)[0] - 1
    around = np.pad(1 - mask, 1, constant_values=1)
    holes = cv2.connectedComponents(around, connectivity=4)[0] - 2
    assert int((borders.area > 0).sum()) == objects
    assert int((borders.area < 0).sum()) == holes
    assert int(borders.area.sum()) == int(mask.sum())


@settings(max_examples=300, deadline=None)
@given(MASKS)
def test_a_hole_belongs_to_the_object_around_it(mask: np.ndarray) -> None:
    borders = followed(mask)
    labels = cv2.connectedComponents(mask, connectivity=8)[1]
    for b, owner in enumerate(borders.owner.tolist()):
        x, y, _ = borders.cracks_of(b)
        ox, oy, _ = borders.cracks_of(owner)
        assert borders.area[owner] > 0
        assert labels[y[0], x[0]] == labels[oy[0], ox[0]]


@settings(max_examples=200, deadline=None)
@given(MASKS)
def test_the_walk_visits_exactly_the_pixels_of_the_papers_laplacian(mask: np.ndarray) -> None:
    borders = followed(mask)
    visited = np.zeros(mask.shape, dtype=bool)
    visited[borders.y, borders.x] = True
    assert np.array_equal(visited, laplacian_border(mask))


@settings(max_examples=200, deadline=None)
@given(MASKS)
def test_every_crack_is_walked_once_with_the_obstacle_on_the_right(mask: np.ndarray) -> None:
    borders = followed(mask)
    cracks = list(
        zip(borders.x.tolist(), borders.y.tolist(), borders.direction.tolist(), strict=True)
    )
    assert len(cracks) == len(set(cracks))
    around = np.pad(mask, 1)
    out = [(0, -1), (1, 0), (0, 1), (-1, 0)]
    expected = {
        (x, y, d)
        for y, x in np.argwhere(mask).tolist()
        for d, (dx, dy) in enumerate(out)
        if around[y + 1 + dy, x + 1 + dx] == 0
    }
    assert set(cracks) == expected


@settings(max_examples=200, deadline=None)
@given(MASKS)
def test_contours_step_from_pixel_to_8_neighbour(mask: np.ndarray) -> None:
    contours, starts = followed(mask).contours()
    for a, b in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        contour = contours[a:b].astype(int)
        if len(contour) > 1:
            steps = np.abs(np.roll(contour, -1, axis=0) - contour).max(axis=1)
            assert steps.min() == 1
            assert steps.max() == 1


def test_outlines_run_clockwise_on_the_screen() -> None:
    mask = np.zeros((9, 9), np.uint8)
    mask[2:7, 2:7] = 1
    x, y, _ = followed(mask).cracks_of(0)
    points = np.stack([x, y], axis=1).astype(float)
    following = np.roll(points, -1, axis=0)
    shoelace = (points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]).sum()
    assert shoelace > 0.0  # y down: positive is clockwise


def test_pixels_that_touch_at_a_corner_are_one_object() -> None:
    mask = np.array([[1, 0], [0, 1]], np.uint8)
    borders = followed(mask)
    assert borders.area.tolist() == [2]


@pytest.mark.parametrize("value", [0, 1])
def test_a_uniform_mask_has_no_border_or_one(value: int) -> None:
    borders = followed(np.full((5, 7), value, np.uint8))
    assert borders.area.tolist() == [35] * value
