"""From a picture to a scene: accuracy, coverage, small things, symmetry, errors."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planner.scene import (
    Arc,
    ArcRecord,
    Bounds,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Scene,
    Segment,
    SegmentRecord,
    object_records,
)
from tests.support.drawn.render import (
    coverage,
    cut_disc,
    draw,
    outline_points,
    polygon,
    ramp,
    rounded,
)
from vision import Calibration, PictureError, extract


def drawn_again(scene: Scene) -> np.ndarray:
    """The pixels whose centres the records cover."""
    width, height = scene.size
    mask = np.zeros((height, width), dtype=bool)
    for obj in scene.objects:
        outlines = []
        for record in object_records(obj):
            if isinstance(record, PointRecord):
                mask[round(record.at[1]), round(record.at[0])] = True
            elif isinstance(record, SegmentRecord):
                for t in np.linspace(0.0, 1.0, 200):
                    x, y = np.array(record.start) * (1.0 - t) + np.array(record.end) * t
                    mask[round(y), round(x)] = True
            elif isinstance(record, ArcRecord):
                for x, y in along(record):
                    # a curve may leave its pixels' middles by NEAR_PX, and so the picture
                    mask[min(max(round(y), 0), height - 1), min(max(round(x), 0), width - 1)] = True
            else:
                outlines.append(outline_points(record, 0.01))
        if outlines:
            mask |= coverage(outlines, (width, height), lines=1) >= 0.5
    return mask


def along(record: ArcRecord) -> np.ndarray:
    """Points along an open chain of edges, close to each other, (n, 2)."""
    points = []
    for edge in record.edges:
        share = np.linspace(0.0, 1.0, 200)[:, None]
        if isinstance(edge, Arc):
            begin, sweep = edge.sweep(y_down=True)
            angles = (begin + sweep * share)[:, 0]
            circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            points.append(np.array(edge.center) + edge.radius * circle)
        else:
            points.append(np.array(edge.start) * (1.0 - share) + np.array(edge.end) * share)
    return np.concatenate(points)


def farthest(a: np.ndarray, b: np.ndarray) -> float:
    """The symmetric Hausdorff distance of two masks, in pixels."""
    if not a.any() or not b.any():
        return 0.0 if a.any() == b.any() else math.inf
    to_a = cv2.distanceTransform((~a).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    to_b = cv2.distanceTransform((~b).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return float(max(to_a[b].max(), to_b[a].max()))


def corners(scene: Scene) -> np.ndarray:
    return np.array(
        [e.start for o in scene.objects for r in object_records(o) for e in r.edges]
    ).reshape(-1, 2)


def turned_square(rng: np.random.Generator, half: float = 22.0) -> np.ndarray:
    angle = rng.uniform(0, math.tau)
    c, s = math.cos(angle), math.sin(angle)
    square = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    return square @ np.array([[c, s], [-s, c]]) + 50.0 + rng.uniform(-0.5, 0.5, 2)


@pytest.mark.parametrize(("noise", "limit"), [(0.0, 0.02), (5.0, 0.05), (20.0, 0.15)])
def test_corners_of_turned_squares_are_found_to_a_fraction_of_a_pixel(
    noise: float, limit: float
) -> None:
    errors = []
    for seed in range(25):
        rng = np.random.default_rng([seed, int(noise)])
        truth = turned_square(rng)
        scene = extract(draw([polygon(truth)], (100, 100), noise=noise, rng=rng))
        found = corners(scene)
        assert len(found) == 4
        errors += [np.hypot(*(found - corner).T).min() for corner in truth]
    assert np.sqrt(np.mean(np.square(errors))) < limit


def test_a_stadium_is_two_lines_and_two_arcs() -> None:
    stadium = rounded(np.array([[40.0, 50.0], [90.0, 60.0]]), 20.0)
    record = extract(draw([stadium], (130, 110))).objects[0].records[0]
    arcs = [e for e in record.edges if isinstance(e, Arc)]
    assert len(record.edges) == 4
    assert len(arcs) == 2
    assert all(abs(a.radius - 20.0) < 0.1 and not a.ccw for a in arcs)


def test_a_cut_disc_is_an_arc_and_a_line() -> None:
    disc = cut_disc(np.array([60.0, 60.0]), 35.0, 0.4, 1.6)
    record = extract(draw([disc], (120, 120))).objects[0].records[0]
    (arc,) = (e for e in record.edges if isinstance(e, Arc))
    assert len(record.edges) == 2
    assert math.dist(arc.center, (60.0, 60.0)) < 0.1
    assert abs(arc.radius - 35.0) < 0.1


def test_a_wall_around_the_picture_is_an_outline_and_a_hole() -> None:
    picture = np.zeros((60, 80), np.uint8)
    picture[4:-4, 4:-4] = 255
    (wall,) = extract(picture).objects
    outline = {e.start for e in wall.records[0].edges}
    hole = {e.start for e in wall.holes[0][0].edges}
    assert np.allclose(sorted(outline), [(-0.5, -0.5), (-0.5, 59.5), (79.5, -0.5), (79.5, 59.5)])
    assert np.allclose(sorted(hole), [(3.5, 3.5), (3.5, 55.5), (75.5, 3.5), (75.5, 55.5)])


def test_a_single_pixel_is_a_point_and_a_thin_line_a_segment() -> None:
    picture = np.full((40, 60), 255, np.uint8)
    picture[10, 20] = 0
    picture[30, 5:25] = 0
    point, line = (o.records[0] for o in extract(picture).objects)
    assert point == PointRecord((20.0, 10.0))
    assert isinstance(line, SegmentRecord)
    assert (line.start, line.end) == ((5.0, 30.0), (24.0, 30.0))


def test_the_edge_is_where_the_object_is_whatever_its_darkness() -> None:
    picture = draw([polygon([(20.3, 20.3), (60.3, 20.3), (60.3, 60.3), (20.3, 60.3)])], (160, 80))
    pale = draw(
        [polygon([(100.3, 20.3), (140.3, 20.3), (140.3, 60.3), (100.3, 60.3)])],
        (160, 80),
        dark=90.0,
    )
    scene = extract(np.minimum(picture, pale))
    assert len(scene.objects) == 2
    xs = corners(scene)[:, 0]
    assert np.abs(np.sort(xs) - np.repeat([20.3, 60.3, 100.3, 140.3], 2)).max() < 0.05


@pytest.mark.parametrize("fall", [0.5, 0.8])
def test_uneven_light_is_divided_out(fall: float) -> None:
    shapes = [
        polygon([(x, 30.0), (x + 40.0, 30.0), (x + 40.0, 80.0), (x, 80.0)]) for x in (20, 90, 160)
    ]
    picture = draw(shapes, (220, 110), lit=ramp((220, 110), fall), noise=2.0,
                   rng=np.random.default_rng(1))  # fmt: skip
    scene = extract(picture)
    assert [len(o.records[0].edges) for o in scene.objects] == [4, 4, 4]
    assert scene.binarisation.method == "background"
    assert "uneven light" in scene.binarisation.reason


def test_an_empty_arena_with_noise_has_no_objects() -> None:
    rng = np.random.default_rng(2)
    picture = np.clip(rng.normal(215, 20, (120, 160)), 0, 255).astype(np.uint8)
    assert extract(picture).objects == ()
    assert extract(np.full((50, 60), 255, np.uint8)).objects == ()


def cells_of(*rows: str) -> np.ndarray:
    return np.array([[letter == "#" for letter in row] for row in rows])


LOST_CELL = cells_of(".......", ".#.....", ".#.....", "#.#....", "...#...", ".......")
"""A sliver beside the cell on the left once passed for a tip, within which nothing was asked."""


@settings(max_examples=150, deadline=None)
@given(
    arrays(np.bool_, st.tuples(st.integers(2, 24), st.integers(2, 24)), elements=st.booleans()),
    st.integers(1, 4),
)
@example(LOST_CELL, 4)
def test_records_of_any_drawing_cover_it_within_two_pixels(cells: np.ndarray, scale: int) -> None:
    mask = cells.repeat(scale, axis=0).repeat(scale, axis=1)
    if mask.all():
        mask[0, 0] = False
    scene = extract(np.where(mask, 0, 255).astype(np.uint8), method="fixed", threshold=128)
    count = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)[0] - 1
    assert len(scene.objects) == count
    assert farthest(mask, drawn_again(scene)) <= 2.0


@pytest.mark.parametrize("turns", [1, 2, 3])
@pytest.mark.parametrize("mirror", [False, True])
def test_turning_or_mirroring_the_picture_turns_or_mirrors_the_records(
    turns: int, mirror: bool
) -> None:
    rng = np.random.default_rng(8)
    picture = draw([polygon(turned_square(rng)), CircleRecord((85.0, 15.0), 9.0)], (100, 100))
    other = np.rot90(picture[:, ::-1] if mirror else picture, turns)
    found = corners(Scene("px", Bounds(0, 0, 1, 1), polygons(extract(np.ascontiguousarray(other)))))
    expected = corners(Scene("px", Bounds(0, 0, 1, 1), polygons(extract(picture)))) - 49.5
    if mirror:
        expected[:, 0] *= -1.0
    for _ in range(turns):
        expected = np.stack([expected[:, 1], -expected[:, 0]], axis=1)
    gaps = np.hypot(*(found[:, None] - 49.5 - expected[None]).transpose(2, 0, 1))
    assert len(found) == len(expected) == 4
    assert gaps.min(axis=1).max() < 0.01


def polygons(scene: Scene) -> tuple:
    return tuple(o for o in scene.objects if isinstance(o.records[0], PolygonRecord))


def test_colour_16_bits_and_light_obstacles_give_the_same_records() -> None:
    picture = draw([polygon(turned_square(np.random.default_rng(3)))], (100, 100))
    expected = corners(extract(picture))
    colour = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    deep = picture.astype(np.uint16) * 257
    for other, polarity in ((colour, "dark"), (deep, "dark"), (255 - picture, "light")):
        assert np.abs(corners(extract(other, polarity=polarity)) - expected).max() < 0.02


def test_the_picture_is_never_changed_and_may_be_read_only() -> None:
    picture = draw([CircleRecord((30.0, 30.0), 12.0)], (60, 60))
    before = picture.copy()
    picture.setflags(write=False)
    extract(picture)
    extract(picture, mode="paper")
    assert np.array_equal(picture, before)


@dataclass(frozen=True)
class Flat:
    """A camera that looks straight down: 2 mm a pixel, y up."""

    metres_per_pixel: float = 0.002

    def arena_from_image(self, points_px: np.ndarray) -> np.ndarray:
        return np.stack([points_px[:, 0] * 0.002, 0.2 - points_px[:, 1] * 0.002], axis=1)


def test_a_calibration_gives_metres_with_y_up_and_the_same_turning_sense() -> None:
    picture = draw(
        [CircleRecord((25.0, 30.0), 12.0), cut_disc(np.array([70.0, 60.0]), 20.0, 0.0, 1.2)],
        (100, 100),
    )
    scene = extract(picture, calibration=Flat(), bounds=Bounds(0.0, 0.0, 0.2, 0.2))
    circle, disc = (o.records[0] for o in scene.objects)
    assert scene.units == "m"
    assert math.dist(circle.center, (0.05, 0.14)) < 2e-4
    assert abs(circle.radius - 0.024) < 2e-4
    assert [e.ccw for e in disc.edges if isinstance(e, Arc)] == [False]


@pytest.mark.parametrize("kind", [tuple, list, np.array])
def test_bounds_are_four_numbers_in_any_sequence(kind: Callable[[Any], Any]) -> None:
    picture = draw([CircleRecord((25.0, 30.0), 12.0)], (100, 100))
    scene = extract(picture, calibration=Flat(), bounds=kind([0.0, 0.0, 0.2, 0.2]))
    assert scene.bounds == Bounds(0.0, 0.0, 0.2, 0.2)
    assert scene.objects == extract(picture, calibration=Flat(), bounds=scene.bounds).objects


@pytest.mark.parametrize(
    "bounds", [(0.0, 0.0, 0.2), "abcd", 3.0, (0.2, 0.0, 0.0, 0.2), (0.0, 0.0, math.nan, 0.2)]
)
def test_bounds_that_are_none_are_refused(bounds: Any) -> None:
    with pytest.raises(PictureError, match="bounds"):
        extract(np.full((100, 100), 220, np.uint8), calibration=Flat(), bounds=bounds)


def test_objects_outside_the_bounds_are_left_out_with_a_remark() -> None:
    picture = draw([CircleRecord((25.0, 30.0), 12.0), CircleRecord((80.0, 80.0), 9.0)], (100, 100))
    scene = extract(picture, calibration=Flat(), bounds=Bounds(0.0, 0.1, 0.1, 0.2))
    assert len(scene.objects) == 1
    assert any("outside the bounds" in remark for remark in scene.remarks)


def test_ignored_pixels_are_no_obstacle() -> None:
    picture = draw([CircleRecord((25.0, 30.0), 12.0), CircleRecord((70.0, 70.0), 9.0)], (100, 100))
    assert len(extract(picture, ignore=[(70.0, 70.0, 14.0)]).objects) == 1
    mask = np.zeros((100, 100), dtype=bool)
    mask[50:, 50:] = True
    assert len(extract(picture, ignore=mask).objects) == 1


def test_the_papers_mode_finds_squares_and_circles_on_border_pixels() -> None:
    picture = np.full((80, 140), 255, np.uint8)
    picture[20:61, 20:61] = 0
    y, x = np.mgrid[0:80, 0:140]
    picture[(x - 100) ** 2 + (y - 40) ** 2 <= 15**2] = 0
    square, circle = (o.records[0] for o in extract(picture, mode="paper").objects)
    assert sorted(e.start for e in square.edges) == [(20, 20), (20, 60), (60, 20), (60, 60)]
    assert isinstance(circle, CircleRecord)
    assert math.dist(circle.center, (100.0, 40.0)) < 0.1


@pytest.mark.parametrize(
    ("picture", "word"),
    [
        (np.zeros((40, 50), np.uint8), "no free space"),
        (np.zeros((0, 50), np.uint8), "empty"),
        (np.zeros((4, 5), np.float32), "float32"),
        (np.zeros((4, 5, 2), np.uint8), "shape"),
        (np.zeros((4,), np.uint8), "shape"),
        ("no picture", "NumPy"),
    ],
)
def test_what_is_no_usable_picture_is_refused_in_one_sentence(picture: object, word: str) -> None:
    with pytest.raises(PictureError, match=word) as caught:
        extract(picture)
    assert "\n" not in str(caught.value)


def test_wrong_options_are_refused() -> None:
    picture = np.full((20, 20), 255, np.uint8)
    with pytest.raises(PictureError, match="mode"):
        extract(picture, mode="best")
    with pytest.raises(PictureError, match="polarity"):
        extract(picture, polarity="grey")
    with pytest.raises(PictureError, match="method"):
        extract(picture, method="magic")
    with pytest.raises(PictureError, match="threshold"):
        extract(picture, threshold=700)
    for threshold in ("a", True, [100.0]):
        with pytest.raises(PictureError, match="must be a number"):
            extract(picture, threshold=threshold)
    with pytest.raises(PictureError, match="calibration: a str"):
        extract(picture, calibration="camera.yaml")
    with pytest.raises(PictureError, match="ignore"):
        extract(picture, ignore=np.zeros((3, 3), dtype=bool))


@pytest.mark.parametrize(
    ("name", "polarity", "objects"),
    [("silhouette_1.png", "light", 1), ("pic1.png", "dark", 7)],
)
def test_real_pictures_give_their_objects(name: str, polarity: str, objects: int) -> None:
    folder = os.environ.get("CLEARWAY_REAL_DATA")
    if folder is None:
        pytest.skip("CLEARWAY_REAL_DATA is not set")
    picture = cv2.imread(str(Path(folder) / "shapes" / name), cv2.IMREAD_UNCHANGED)
    scene = extract(picture, polarity=polarity)
    assert len(scene.objects) == objects


def test_a_picture_of_another_size_than_its_calibration_s_is_refused() -> None:
    plan = Calibration.from_scale(0.01, (64, 48))
    picture = np.full((48, 64), 220, np.uint8)
    assert extract(picture, calibration=plan).size == (64, 48)
    with pytest.raises(PictureError, match="32 x 48 pixels: its calibration is for 64 x 48"):
        extract(picture[:, :32], calibration=plan)


def test_discs_to_ignore_that_are_none_are_refused() -> None:
    with pytest.raises(PictureError, match="discs"):
        extract(np.full((48, 64), 220, np.uint8), ignore=[(1, 2)])  # type: ignore[list-item]
    with pytest.raises(PictureError, match="radius >= 0"):
        extract(np.full((48, 64), 220, np.uint8), ignore=[(1.0, 2.0, -3.0)])


def test_an_outlines_segments_are_those_that_their_class_makes() -> None:
    """They are made without its constructor, field by field."""
    image = np.full((60, 80), 255, np.uint8)
    image[20:40, 20:60] = 0
    (only,) = extract(image).objects
    (record,) = only.records
    assert isinstance(record, PolygonRecord)
    assert [field.name for field in dataclasses.fields(Segment)] == ["start", "end"]
    for edge, after in zip(record.edges, (*record.edges[1:], record.edges[0]), strict=True):
        assert isinstance(edge, Segment)
        assert edge == Segment(edge.start, after.start)
