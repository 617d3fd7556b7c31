"""Every outline lies on its border and every border has its outline, whatever the picture.

Rules and units
- The judge is ``tests.support.drawn.outline_judge``: it knows the black and white picture and the
  written records only. ``python -m benchmarks.outlines`` runs it over thousands of pictures more.
- Pixels, centres at integers, y down.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from planner import NoPath, build_roadmap
from planner.scene import (
    Arc,
    CircleRecord,
    Edge,
    PointRecord,
    Record,
    Scene,
    Segment,
    SegmentRecord,
    Vec,
    object_records,
)
from tests.support.drawn.outline_judge import failures, judge, mask_of
from tests.support.drawn.outline_pictures import FAMILIES, LOOKS, every_look, shown, slits
from vision import Calibration, extract
from vision.outline.check.stray_kernels import outline_strays
from vision.outline.fit.edge_shape_kernels import goes_round
from vision.outline.fitted_borders import ARC_CCW, ARC_CW, LINE
from vision.outline.outline_types import BorderPoints, FinishedEdges

SEED = 31


def a_scratched_block() -> np.ndarray:
    """A block with one bright scratch: its border was once a circle of a radius of hundreds."""
    rng = np.random.default_rng(10)
    image = np.full((300, 400), 215.0)
    image[60:240, 60:340] = 50
    x, y = rng.uniform(90, 240), rng.uniform(80, 220)
    angle, length = rng.uniform(-0.25, 0.25), rng.uniform(30, 70)
    end = int(x + length * np.cos(angle)), int(y + length * np.sin(angle))
    cv2.line(image, (int(x), int(y)), end, float(rng.integers(130, 215)), 1)
    blurred = cv2.GaussianBlur(image, (0, 0), 0.7)
    return np.clip(blurred + rng.normal(0, 3, image.shape), 0, 255).astype(np.uint8)


def test_a_scratch_in_a_block_leaves_the_floor_beside_it_free() -> None:
    path = build_roadmap(extract(a_scratched_block()), radius=5).plan((20, 20), (380, 280))
    assert not isinstance(path, NoPath)


def test_the_inside_of_a_scratched_block_is_not_free() -> None:
    picture = a_scratched_block()
    assert failures(mask_of(picture), extract(picture)) == []


def test_no_slit_becomes_a_circle_elsewhere() -> None:
    for seed in range(24):
        picture = slits(np.random.default_rng([SEED, seed]))
        assert failures(mask_of(picture), extract(picture)) == [], f"seed {seed}"


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_every_outline_lies_on_its_border_in_every_look(family: str) -> None:
    for name, picture, look in every_look(family, 1, SEED):
        scene = extract(picture, polarity=look.polarity)
        assert failures(mask_of(picture, look.polarity), scene) == [], name


def in_pixels(scene: Scene, plan: Calibration) -> Scene:
    """A scene in metres as one in the pixels of its picture; ``plan`` is a scale alone."""

    def there(point: Vec) -> Vec:
        x, y = plan.image_from_arena(np.array([point]))[0].tolist()
        return x, y

    def edge(one: Edge) -> Edge:
        if isinstance(one, Segment):
            return Segment(there(one.start), there(one.end))
        radius = one.radius / plan.metres_per_pixel
        return Arc(there(one.start), there(one.end), there(one.center), radius, one.ccw)

    def record(one: Record) -> Record:
        match one:
            case PointRecord(at):
                return PointRecord(there(at))
            case SegmentRecord(start, end):
                return SegmentRecord(there(start), there(end))
            case CircleRecord(center, radius):
                return CircleRecord(there(center), radius / plan.metres_per_pixel)
            case _:
                return replace(one, edges=tuple(edge(e) for e in one.edges))

    return replace(
        scene,
        units="px",
        objects=tuple(
            replace(
                o,
                records=tuple(record(r) for r in o.records),
                holes=tuple(tuple(record(r) for r in hole) for hole in o.holes),
            )
            for o in scene.objects
        ),
    )


def test_no_slit_becomes_a_circle_elsewhere_in_metres() -> None:
    plan = Calibration.from_scale(0.004, (400, 300))
    for seed in range(12):
        picture = slits(np.random.default_rng([SEED, seed]))
        scene = in_pixels(extract(picture, calibration=plan), plan)
        assert failures(mask_of(picture), scene) == [], f"seed {seed}"


FINDS = (
    # an arm of a slit's border, 6 px long, that no edge ran along
    ("scratches", 6, 6),
    ("scratches", 3, 0),
    ("combs", 8, 3),
    ("rags", 3, 11),
    # sides that ran on past the border, 16 and 17 px far
    ("round", 9, 10),
    ("threads", 7, 10),
    # sides that met 4 px off the border, at no pointed corner
    ("combs", 0, 11),
    ("combs", 9, 4),
    ("threads", 0, 2),
)


@pytest.mark.parametrize(("family", "mask", "number"), FINDS)
def test_borders_that_once_had_no_outline_of_their_own(family: str, mask: int, number: int) -> None:
    look = LOOKS[number]
    share = FAMILIES[family](np.random.default_rng([SEED, mask]))
    picture = shown(share, look, np.random.default_rng([SEED, mask, number]))
    scene = extract(picture, polarity=look.polarity)
    assert failures(mask_of(picture, look.polarity), scene) == []


@pytest.mark.parametrize("name", ["calibration/left07.jpg", "shapes/pca_test1.jpg"])
@pytest.mark.parametrize("polarity", ["dark", "light"])
def test_outlines_lie_on_their_borders_in_real_pictures(
    name: str, polarity: str, real_data: Path
) -> None:
    picture = cv2.imread(str(real_data / name))
    assert failures(mask_of(picture, polarity), extract(picture, polarity=polarity)) == []


def test_the_judge_finds_a_circle_that_is_none() -> None:
    """The judge itself: a disc's record passes, the same a few pixels larger fails."""
    picture = np.full((120, 120), 255, np.uint8)
    cv2.circle(picture, (60, 60), 30, 0, -1)
    scene = extract(picture)
    mask = mask_of(picture)
    assert not any(v.fails() for v in judge(mask, scene))
    (only,) = (r for o in scene.objects for r in object_records(o))
    assert isinstance(only, CircleRecord)
    for radius in (only.radius - 6.0, only.radius + 6.0):
        wrong = CircleRecord(only.center, radius)
        assert any(v.fails() for v in judge(mask, replaced(scene, wrong)))


def replaced(scene: Scene, record: CircleRecord) -> Scene:
    (obj,) = scene.objects
    return replace(scene, objects=(replace(obj, records=(record,)),))


def border_of(corners: list[tuple[float, float]]) -> np.ndarray:
    """Points a pixel apart along a closed polygon, (n, 2), its corners among them."""
    points = []
    for i, (x0, y0) in enumerate(corners):
        x1, y1 = corners[(i + 1) % len(corners)]
        steps = max(1, round(math.hypot(x1 - x0, y1 - y0)))
        t = np.arange(steps) / steps
        points.append(np.stack([x0 + t * (x1 - x0), y0 + t * (y1 - y0)], axis=1))
    return np.concatenate(points)


def strays(border: np.ndarray, kinds: list[int], rows: list[list[float]], at: list[int]) -> bool:
    twice = np.concatenate([border, border, border[:1]])
    table = np.zeros((len(rows), 6))
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
    x, y = (np.ascontiguousarray(twice[:, c]) for c in (0, 1))
    edges = FinishedEdges(np.array(kinds, np.int8), table, np.array(at, np.int64))
    return bool(outline_strays(BorderPoints(x, y, len(border)), edges, len(rows)))


SQUARE = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0)]
AT = [0, 40, 80, 120]


def test_an_outline_on_its_border_does_not_stray() -> None:
    assert not strays(border_of(SQUARE), [LINE] * 4, [list(c) for c in SQUARE], AT)


@pytest.mark.parametrize("corner", [(46.0, -6.0), (20.0, 20.0), (46.0, 0.0)])
def test_a_corner_off_the_border_strays(corner: tuple[float, float]) -> None:
    rows = [list(c) for c in SQUARE]
    rows[1] = list(corner)
    assert strays(border_of(SQUARE), [LINE] * 4, rows, AT)


def test_an_arc_the_long_way_round_strays() -> None:
    """Both its ends and all its points are where they should be: its length is not."""
    turns = {ARC_CW: False, ARC_CCW: True}
    for kind, wrong in turns.items():
        rows = [list(c) for c in SQUARE]
        # clockwise on the screen it bulges a pixel, the other way it is nearly the whole circle
        radius = 200.5
        rows[0] += [20.0, math.sqrt(radius**2 - 400.0), radius]
        assert strays(border_of(SQUARE), [kind, LINE, LINE, LINE], rows, AT) is wrong


def test_a_part_of_a_border_without_an_edge_strays() -> None:
    """A spur of 8 pixels: all of the outline lies on the border, but not the border on that."""
    spur = [SQUARE[0], (20.0, 0.0), (20.0, -8.0), (21.0, -8.0), (21.0, 0.0), *SQUARE[1:]]
    rows = [list(c) for c in SQUARE]
    assert strays(border_of(spur), [LINE] * 4, rows, [0, 56, 96, 136])


def test_a_tip_that_blur_rounded_back_does_not_stray_and_a_wide_one_does() -> None:
    """The border ends where the sides are still 1.4 px apart, or 7 px."""
    for half_width, wrong in ((4.0, False), (30.0, True)):
        whole = [(0.0, -half_width), (60.0, 0.0), (0.0, half_width)]
        share = 1.0 - 8.0 / 60.0
        cut = half_width * (1.0 - share)
        border = border_of([whole[0], (60.0 * share, -cut), (60.0 * share, cut), whole[2]])
        first = round(math.hypot(60.0 * share, half_width - cut))
        at = [0, first + 1, 2 * first + max(1, round(2 * cut))]
        assert strays(border, [LINE] * 3, [list(c) for c in whole], at) is wrong


def test_a_border_winds_round_a_place_within_it_only() -> None:
    border = border_of(SQUARE)
    twice = np.concatenate([border, border, border[:1]])
    for points in (twice, twice[::-1]):
        px, py = (np.ascontiguousarray(points[:, c]) for c in (0, 1))
        assert goes_round(px, py, len(border), 20.0, 20.0)
        assert goes_round(px, py, len(border), 1.0, 39.0)
        assert not goes_round(px, py, len(border), 20.0, -1.0)
        assert not goes_round(px, py, len(border), 500.0, 20.0)
