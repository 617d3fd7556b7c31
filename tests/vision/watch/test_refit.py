"""A scene brought up to date equals one extracted anew, and leaves alone what did not change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import vision
from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    PolygonRecord,
    Scene,
    SceneObject,
    record_edges,
)
from tests.support.drawn.render import draw, polygon
from vision.calibration.calibration import Calibration
from vision.doubts import doubts_about
from vision.watch.refit import KnownScene

SIZE = (480, 360)
SCALE = 0.005
PLAN = Calibration.from_scale(SCALE, SIZE)
BENT = Calibration.from_camera(
    SIZE,
    [[460.0, 0.0, 239.5], [0.0, 460.0, 179.5], [0.0, 0.0, 1.0]],
    [-0.2, 0.05, 0.0, 0.0, 0.0],
    [[1.0, 0.0, 0.0, -1.2], [0.0, -1.0, 0.0, 0.9], [0.0, 0.0, -1.0, 2.3]],
)
BOUNDS = Bounds(-0.5, -0.5, 3.0, 2.5)
Shape = PolygonRecord | CircleRecord


def box(x: float, y: float, w: float, h: float) -> PolygonRecord:
    return polygon([(x, y), (x + w, y), (x + w, y + h), (x, y + h)])


FIXED: list[Shape] = [
    box(40.3, 40.2, 60.0, 45.0),
    CircleRecord((400.4, 80.7), 30.0),
    polygon([(60.0, 250.0), (120.5, 240.0), (90.2, 310.4)]),
    CircleRecord((240.0, 180.0), 12.5),
    box(380.7, 260.3, 70.0, 40.0),
]


def picture(shapes: list[Shape], seed: int = 0) -> NDArray[np.uint8]:
    """Always the same noise, as what did not change in a background has not changed at all."""
    return draw(shapes, SIZE, noise=2.0, rng=np.random.default_rng(seed))


def seen(image: NDArray[np.uint8], calibration: Calibration = PLAN) -> Scene:
    return vision.extract(image, polarity="dark", calibration=calibration, bounds=BOUNDS)


def refit(
    scene: Scene,
    image: NDArray[np.uint8],
    rectangles: list[tuple[int, int, int, int]],
    calibration: Calibration,
) -> Scene | None:
    known = KnownScene.of(scene, calibration).refitted(image, rectangles)
    if known is None:
        return None
    assert known.boxes == KnownScene.of(known.scene, calibration).boxes
    return known.scene


def changed(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> list[tuple[int, int, int, int]]:
    """The rectangle of the pixels that differ."""
    rows, columns = np.nonzero(a != b)
    x, y = int(columns.min()), int(rows.min())
    return [(x, y, int(columns.max()) - x + 1, int(rows.max()) - y + 1)]


def middle_and_size(obj: SceneObject) -> tuple[float, float, float]:
    """The centroid and the area of an outline, arcs and all."""
    outline: list[tuple[float, float]] = []
    for edge in record_edges(obj.records[0]):
        outline.append(edge.start)
        if isinstance(edge, Arc):
            begin, sweep = edge.sweep(y_down=False)
            angles = begin + sweep * np.linspace(0.0, 1.0, 200)[1:-1]
            (x, y), r = edge.center, edge.radius
            outline += zip(x + r * np.cos(angles), y + r * np.sin(angles), strict=True)
    here = np.array(outline)
    there = np.roll(here, -1, axis=0)
    cross = here[:, 0] * there[:, 1] - there[:, 0] * here[:, 1]
    area = 0.5 * float(cross.sum())
    x, y = ((here + there) * cross[:, None]).sum(axis=0) / (6.0 * area)
    return float(x), float(y), abs(area)


def assert_same(a: Scene, b: Scene) -> None:
    """The same objects, to a tenth of a pixel."""
    assert len(a.objects) == len(b.objects)
    rest = [middle_and_size(o) for o in b.objects]
    for obj in a.objects:
        x, y, area = middle_and_size(obj)
        nearest = min(rest, key=lambda m: (m[0] - x) ** 2 + (m[1] - y) ** 2)
        assert np.hypot(nearest[0] - x, nearest[1] - y) < 0.1 * SCALE
        assert nearest[2] == pytest.approx(area, rel=0.01)
        rest.remove(nearest)
    assert len({o.id for o in a.objects}) == len(a.objects)


@settings(max_examples=15, deadline=None)
@given(
    st.floats(20.0, 430.0),
    st.floats(20.0, 310.0),
    st.floats(8.0, 28.0),
    st.booleans(),
    st.sampled_from([PLAN, BENT]),
)
def test_an_added_obstacle_gives_the_scene_of_a_whole_extraction(
    x: float, y: float, size: float, round_one: bool, calibration: Calibration
) -> None:
    before = picture(FIXED)
    new: Shape = CircleRecord((x, y), size) if round_one else box(x, y, 2.0 * size, size)
    after = picture([*FIXED, new])
    if np.array_equal(before, after):
        return  # it lies within another
    old = seen(before, calibration)
    scene = refit(old, after, changed(before, after), calibration)
    assert scene is not None
    whole = seen(after, calibration)
    assert len(scene.objects) == len(whole.objects)
    if len(whole.objects) > len(old.objects):
        assert_same(scene, whole)
    back = refit(scene, before, changed(before, after), calibration)
    assert back is not None
    assert_same(back, old)


def test_what_did_not_change_keeps_its_very_records_and_its_id() -> None:
    before, after = picture(FIXED), picture([*FIXED, CircleRecord((250.0, 320.0), 15.0)])
    old = seen(before)
    scene = refit(old, after, changed(before, after), PLAN)
    assert scene is not None
    assert all(any(o is k for k in scene.objects) for o in old.objects)
    (new,) = [o for o in scene.objects if not any(o is k for k in old.objects)]
    assert isinstance(new.records[0], CircleRecord)
    assert scene.border_pixels < 0.2 * old.border_pixels


def test_an_obstacle_that_joins_two_makes_them_one_and_its_removal_two_again() -> None:
    pair: list[Shape] = [box(100.0, 100.0, 60.0, 40.0), box(250.0, 105.0, 60.0, 40.0)]
    bridge = box(150.0, 110.0, 110.0, 15.0)
    apart, joined = picture([*FIXED, *pair]), picture([*FIXED, *pair, bridge])
    old = seen(apart)
    one = refit(old, joined, changed(apart, joined), PLAN)
    assert one is not None
    assert len(one.objects) == len(old.objects) - 1
    assert len(one.objects) == len(seen(joined).objects)
    two = refit(one, apart, changed(apart, joined), PLAN)
    assert two is not None
    assert_same(two, old)


def test_a_moved_obstacle_is_fitted_where_it_stands_now() -> None:
    before = picture([*FIXED, CircleRecord((300.0, 320.0), 15.0)])
    after = picture([*FIXED, CircleRecord((170.0, 60.0), 15.0)])
    rectangles = [(280, 300, 40, 40), (150, 40, 40, 40)]
    scene = refit(seen(before), after, rectangles, PLAN)
    assert scene is not None
    assert_same(scene, seen(after))


def test_an_obstacle_inside_another_s_hole_is_found() -> None:
    ring: list[Shape] = [CircleRecord((240.0, 180.0), 120.0)]
    hole, inside = CircleRecord((240.0, 180.0), 90.0), CircleRecord((240.0, 180.0), 20.0)

    def with_hole(*more: Shape) -> NDArray[np.uint8]:
        image = picture(ring)
        free = draw([hole], SIZE, dark=215.0, light=40.0)
        image = np.maximum(image, free)
        return np.minimum(image, draw(list(more), SIZE)) if more else image

    before, after = with_hole(), with_hole(inside)
    scene = refit(seen(before), after, changed(before, after), PLAN)
    assert scene is None or len(scene.objects) == len(seen(after).objects) == 2


def test_where_it_cannot_be_trusted_there_is_no_answer() -> None:
    image = picture(FIXED)
    old = seen(image)
    somewhere = [(200, 30, 20, 20)]
    assert refit(old, image, somewhere, PLAN) is not None
    assert refit(old, image, [(0, 0, 480, 300)], PLAN) is None
    assert refit(old, image[:, :400], somewhere, PLAN) is None
    assert refit(replace(old, binarisation=None), image, somewhere, PLAN) is None
    uneven = vision.extract(image, method="background", calibration=PLAN, bounds=BOUNDS)
    assert refit(uneven, image, somewhere, PLAN) is None
    # An object that is longer than what was told of it runs out of its part.
    assert refit(replace(old, objects=()), image, [(60, 50, 10, 10)], PLAN) is None


def test_nothing_is_changed_and_an_empty_part_stays_empty() -> None:
    image = picture(FIXED)
    kept, old = image.copy(), seen(image)
    image.setflags(write=False)
    scene = refit(old, image, [(200, 30, 20, 20)], PLAN)
    assert scene is not None
    assert scene.objects == old.objects
    assert np.array_equal(image, kept)


def test_a_scene_changed_a_hundred_times_does_not_grow() -> None:
    image = picture(FIXED)
    known = KnownScene.of(replace(seen(image), remarks=("1 object lies outside",)), PLAN)
    for i in range(100):
        again = known.refitted(image, [(30 + 4 * i, 30, 20, 20)])
        assert again is not None
        known = again
    assert len(known.scene.objects) == len(known.boxes) == len(FIXED)
    assert known.scene.remarks == ()
    assert_same(known.scene, seen(image))


def test_an_emptied_part_is_no_doubt_and_an_emptied_arena_is() -> None:
    """Where the last obstacle went, whoever drives has to learn that nothing is seen any more."""
    before, after = picture(FIXED), picture(FIXED[:-1])
    fewer = refit(seen(before), after, changed(before, after), PLAN)
    assert fewer is not None
    assert doubts_about(fewer) == ()
    assert not any("no obstacle" in remark for remark in fewer.remarks)
    one, none = picture(FIXED[:1]), picture([])
    empty = refit(seen(one), none, changed(one, none), PLAN)
    assert empty is not None
    assert empty.objects == ()
    (doubt,) = doubts_about(empty)
    assert empty.remarks == (doubt,)


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.5])
def test_a_faint_bar_is_no_change_that_the_scene_s_own_level_can_show(angle: float) -> None:
    """At that level the floor with the bar on it is as empty as before."""
    c, s = np.cos(angle), np.sin(angle)
    corners = [(-15.0, -1.3), (15.0, -1.3), (15.0, 1.3), (-15.0, 1.3)]
    bar = polygon([(150.0 + x * c - y * s, 180.0 + x * s + y * c) for x, y in corners])
    before = picture(FIXED)
    faint = before - np.rint(0.2 * (picture([]).astype(float) - picture([bar]))).astype(np.uint8)
    scene = seen(before)
    assert len(scene.objects) == len(FIXED)
    assert refit(scene, faint, changed(before, faint), PLAN) is None
    with_bar = seen(faint)
    assert len(with_bar.objects) == len(FIXED) + 1
    added = picture([*FIXED, box(150.0, 150.0, 20.0, 20.0)])
    assert refit(scene, added, changed(before, added), PLAN) is not None
    assert refit(with_bar, before, changed(before, faint), PLAN) is not None
