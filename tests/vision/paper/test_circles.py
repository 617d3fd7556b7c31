"""Digital circles: the paper's test on drawn discs, the exact fit on rendered ones."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from planner.scene import CircleRecord
from tests.support.drawn.render import draw, polygon
from vision.borders.contours import follow_borders
from vision.paper.circles import digital_circle
from vision.pipeline import extract


def contour_of(mask: np.ndarray) -> np.ndarray:
    height, width = mask.shape
    padded = np.zeros((height + 2, (width + 9) // 8 * 8), np.uint8)
    padded[1:-1, 1 : width + 1] = mask
    return follow_borders(padded).contours()[0]


@pytest.mark.parametrize("radius", [4, 7, 12, 20])
def test_sauers_test_takes_a_digital_disc_and_finds_its_centre(radius: int) -> None:
    y, x = np.mgrid[0 : 2 * radius + 9, 0 : 2 * radius + 9]
    c = radius + 4
    found = digital_circle(contour_of(((x - c) ** 2 + (y - c) ** 2 <= radius**2).astype(np.uint8)))
    assert found is not None
    assert math.dist(found.center, (c, c)) < 0.2
    assert abs(found.radius - radius) < 0.75


@pytest.mark.parametrize("side", [9, 15, 30])
def test_sauers_test_refuses_a_square(side: int) -> None:
    mask = np.zeros((side + 6, side + 6), np.uint8)
    mask[3:-3, 3:-3] = 1
    assert digital_circle(contour_of(mask)) is None


@pytest.mark.parametrize("noise", [0.0, 10.0, 20.0])
@pytest.mark.parametrize("radius", [5.0, 8.0, 20.0, 50.0])
def test_every_circle_is_found_with_its_centre_and_radius(radius: float, noise: float) -> None:
    errors = []
    size = int(2 * radius + 40)
    for seed in range(6):
        rng = np.random.default_rng([seed, int(radius), int(noise)])
        center = tuple((size / 2 + rng.uniform(-0.5, 0.5, 2)).tolist())
        picture = draw([CircleRecord(center, radius)], (size, size), noise=noise, rng=rng)
        scene = extract(picture)
        assert len(scene.objects) == 1
        record = scene.objects[0].records[0]
        assert isinstance(record, CircleRecord)
        errors.append((math.dist(record.center, center), record.radius - radius))
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert rms.max() < (0.12 if radius < 8 else 0.1)


@pytest.mark.parametrize(
    ("sides", "radius", "noise"),
    [
        (4, 8, 20.0), (4, 12, 0.0), (4, 12, 20.0), (6, 12, 20.0), (6, 20, 0.0), (6, 20, 20.0),
        (8, 12, 0.0), (8, 12, 5.0), (8, 16, 20.0), (8, 30, 0.0), (8, 30, 20.0),
        (12, 20, 5.0), (12, 30, 10.0), (12, 50, 0.0), (12, 50, 20.0),
    ],
)  # fmt: skip
def test_no_polygon_is_taken_for_a_circle(sides: int, radius: float, noise: float) -> None:
    size = int(2 * radius + 40)
    rng = np.random.default_rng(sides)
    angles = rng.uniform(0, math.tau) + np.arange(sides) * math.tau / sides
    vertices = size / 2 + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    picture = draw([polygon(vertices)], (size, size), noise=noise, rng=rng)
    record = extract(picture).objects[0].records[0]
    assert not isinstance(record, CircleRecord)
    assert len(record.edges) == sides


@pytest.mark.parametrize("radius", [5.0, 8.0, 12.0])
@pytest.mark.parametrize("blur", [0.7, 1.0, 1.5])
def test_what_blur_takes_from_a_circle_is_given_back(radius: float, blur: float) -> None:
    off = []
    for seed in range(4):
        rng = np.random.default_rng([seed, int(radius)])
        center = tuple((40.0 + rng.uniform(-0.5, 0.5, 2)).tolist())
        picture = draw([CircleRecord(center, radius)], (80, 80), blur=blur, rng=rng)
        (only,) = extract(picture).objects
        (record,) = only.records
        assert isinstance(record, CircleRecord)
        off.append(record.radius - radius)
    assert abs(float(np.mean(off))) < 0.05


def test_no_circle_is_written_that_its_own_border_leaves() -> None:
    """A circle's place once served as room for the edges that were tried instead of it."""
    for seed in range(60):
        rng = np.random.default_rng([12, seed])
        center, radius = tuple(rng.uniform(38.0, 42.0, 2).tolist()), rng.uniform(10.0, 30.0)
        picture = draw([CircleRecord(center, radius)], (80, 80), blur=0.7, noise=10.0, rng=rng)
        _, packed = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 20])
        for found in extract(cv2.imdecode(packed, 0)).objects:
            for record in found.records:
                if isinstance(record, CircleRecord):
                    assert record.residual_px < 1.0, seed


def test_a_blurred_disc_of_whole_pixels_is_the_circle_it_was_drawn_by() -> None:
    """Where edges were dearer the second time, what took their place was once any circle."""
    y, x = np.mgrid[0:200, 0:200].astype(float)
    circles = 0
    for seed in range(25):
        rng = np.random.default_rng([97, seed])
        (cx, cy), radius = rng.uniform(99.0, 101.0, 2), rng.uniform(12.0, 85.0)
        drawn = np.where(np.hypot(x - cx, y - cy) <= radius, 0, 255).astype(np.uint8)
        seen = cv2.GaussianBlur(drawn, (0, 0), 0.7).astype(np.float32) * np.float32(0.7) + 40.0
        (only,) = extract(np.rint(seen).astype(np.uint8)).objects
        (record,) = only.records
        if isinstance(record, CircleRecord):
            circles += 1
            assert math.hypot(record.center[0] - cx, record.center[1] - cy) < 0.2, f"seed {seed}"
            assert abs(record.radius - radius) < 0.2, f"seed {seed}"
            assert record.residual_px < 0.3, f"seed {seed}"
    assert circles >= 4
