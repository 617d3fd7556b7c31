"""Several cameras' pictures as one floor: against the rendered truth and against one big camera."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vision
from planner.scene import Bounds, Scene
from tests.vision.joined.floor_truth import (
    BOUNDS,
    Picture,
    Points,
    camera,
    disc,
    farthest_m,
    outlines_of,
    picture,
    polygon,
)
from vision.calibration.calibration import Calibration, CalibrationError
from vision.joined.floor_plan import PLAN_MARGIN_PX, FloorPlan
from vision.records.unseen import Unseen, unseen_ground, with_unseen

LEFT = camera(0.62, 0.62, tilt_deg=(1.2, -0.8), turn_deg=0.7)
RIGHT = camera(1.40, 0.58, tilt_deg=(-0.6, 1.1), turn_deg=-1.3)
BIG = camera(1.0, 0.6, size=(1024, 640))
PLAN = FloorPlan.of((LEFT, RIGHT), BOUNDS)
PIXEL_M = PLAN.calibration.metres_per_pixel


def joined(plan: FloorPlan, pictures: Sequence[Picture | None]) -> Scene:
    live = [one is not None for one in pictures]
    image = plan.picture(pictures, plan.owners(live), plan.gains(pictures))
    scene = vision.extract(image, calibration=plan.calibration, bounds=BOUNDS)
    unknown = plan.unknown(live)
    if unknown is None:
        return scene
    ground = unseen_ground(unknown, plan.calibration, BOUNDS, vision.extract)
    return with_unseen(scene, Unseen(ground, "not seen"))


def pictures_of(cameras: Sequence[Calibration], shapes: list[Points]) -> list[Picture]:
    return [picture(one, shapes, seed=i) for i, one in enumerate(cameras)]


def pentagon(x: float, y: float, radius: float, turn: float) -> Points:
    angles = [turn + math.tau * k / 5 for k in range(5)]
    return polygon([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles])


shapes_on_the_seam = st.builds(
    lambda kind, x, y, r, turn: disc(x, y, r) if kind else pentagon(x, y, r, turn),
    st.booleans(),
    st.floats(0.85, 1.15),
    st.floats(0.3, 0.9),
    st.floats(0.08, 0.2),
    st.floats(0.0, math.tau),
)


@settings(max_examples=15, deadline=None)
@given(shape=shapes_on_the_seam, light=st.floats(0.85, 1.0))
def test_an_obstacle_on_the_seam_is_one_object_within_a_pixel_of_the_truth(
    shape: Points, light: float
) -> None:
    two = [picture(LEFT, [shape], seed=1), picture(RIGHT, [shape], light=light, seed=2)]
    (found,) = outlines_of(joined(PLAN, two))
    (alone,) = outlines_of(
        vision.extract(picture(BIG, [shape], seed=3), calibration=BIG, bounds=BOUNDS)
    )
    assert farthest_m(found, shape) < PIXEL_M
    assert farthest_m(shape, found) < PIXEL_M
    assert farthest_m(found, alone) < PIXEL_M


@settings(max_examples=8, deadline=None)
@given(
    tilt=st.tuples(st.floats(-6, 6), st.floats(-6, 6)),
    turn=st.floats(-180, 180),
    x=st.floats(1.2, 1.4),
)
def test_however_the_second_camera_hangs_the_outline_is_the_same(
    tilt: tuple[float, float], turn: float, x: float
) -> None:
    other = camera(x, 0.6, tilt_deg=tilt, turn_deg=turn)
    plan = FloorPlan.of((LEFT, other), BOUNDS)
    shape = pentagon(1.0, 0.6, 0.15, 0.3)
    objects = outlines_of(joined(plan, pictures_of((LEFT, other), [shape])))  # and a fence, perhaps
    found = min(objects, key=lambda one: farthest_m(shape, one))
    assert farthest_m(found, shape) < plan.calibration.metres_per_pixel
    assert farthest_m(shape, found) < plan.calibration.metres_per_pixel


def test_every_pixel_has_the_owner_that_sees_it_best() -> None:
    owners = PLAN.owners((True, True))
    assert set(np.unique(owners)) == {0, 1}
    for index in (0, 1):
        own = owners == index
        assert (PLAN.depth_px[index][own] > 0.0).all()
        assert (PLAN.error_m[index][own] <= PLAN.error_m[1 - index][own]).all()


def test_equal_cameras_part_the_floor_by_the_bisector_of_their_feet() -> None:
    cameras = (camera(0.6, 0.6), camera(1.4, 0.6))
    plan = FloorPlan.of(cameras, BOUNDS)
    owners = plan.owners((True, True))
    middle = plan.calibration.image_from_arena([(1.0, 0.6)])[0, 0]
    columns = np.arange(owners.shape[1])
    assert (owners[:, columns < middle - 1.0] == 0).all()
    assert (owners[:, columns > middle + 1.0] == 1).all()


def test_a_camera_that_looks_closer_keeps_its_part_within_another_ones() -> None:
    wide = camera(1.0, 0.6, size=(1024, 640))
    near = camera(1.3, 0.6, high_m=2.0, focal_px=1400.0)
    plan = FloorPlan.of((wide, near), BOUNDS)
    inner = np.s_[PLAN_MARGIN_PX:-PLAN_MARGIN_PX, PLAN_MARGIN_PX:-PLAN_MARGIN_PX]
    seen = plan.depth_px[1][inner] > 0.0
    own = plan.owners((True, True))[inner] == 1
    beyond = np.arange(own.shape[1]) > 0.7 * own.shape[1]  # on the far side of the middle
    assert own[seen & beyond].all()
    assert plan.unknown((True, True)) is None
    shape = pentagon(1.1, 0.6, 0.2, 0.1)
    (found,) = outlines_of(joined(plan, pictures_of((wide, near), [shape])))
    assert farthest_m(found, shape) < wide.metres_per_pixel


def test_three_cameras_in_a_row_are_one_arena() -> None:
    cameras = tuple(camera(x, 0.6, turn_deg=t) for x, t in ((0.55, 1.0), (1.0, -90.0), (1.45, 2.0)))
    plan = FloorPlan.of(cameras, BOUNDS)
    shapes = [pentagon(0.78, 0.5, 0.14, 0.2), disc(1.22, 0.7, 0.12)]
    found = outlines_of(joined(plan, pictures_of(cameras, shapes)))
    assert len(found) == 2
    for shape in shapes:
        assert min(farthest_m(one, shape) for one in found) < plan.calibration.metres_per_pixel


def test_between_cameras_without_overlap_the_floor_is_closed() -> None:
    cameras = (camera(0.35, 0.6, high_m=1.2), camera(1.65, 0.6, high_m=1.2))
    plan = FloorPlan.of(cameras, BOUNDS)
    unknown = plan.unknown((True, True))
    assert unknown is not None
    assert plan.is_unknown(unknown, 1.0, 0.6, 0.01)
    assert not plan.is_unknown(unknown, 0.35, 0.6, 0.1)
    assert (plan.gains(pictures_of(cameras, [])) == 1.0).all()
    fences = outlines_of(joined(plan, pictures_of(cameras, [])))
    assert all(not plan.is_unknown(unknown, x, 0.6, 0.1) for x in (0.5, 1.5))
    at = np.rint(plan.calibration.image_from_arena(np.concatenate(fences))).astype(int)
    columns, rows = np.clip(at, 4, np.array(plan.calibration.size) - 5).T
    rims = [unknown[rows + dy, columns + dx] for dx in (-4, 0, 4) for dy in (-4, 0, 4)]
    assert (np.max(rims, axis=0) > 0.5).all()  # every outline is the border of the unknown


@pytest.mark.parametrize("lost", [0, 1])
def test_without_a_camera_what_only_it_sees_is_an_obstacle_and_nothing_else(lost: int) -> None:
    shape = pentagon(1.0, 0.6, 0.12, 0.3)
    pictures: list[Picture | None] = list(pictures_of((LEFT, RIGHT), [shape]))
    pictures[lost] = None
    scene = joined(PLAN, pictures)
    assert len(scene.objects) == 2
    seen_by = PLAN.cameras[1 - lost]
    width, height = seen_by.size
    for outline in outlines_of(scene):
        if farthest_m(outline, shape) < PIXEL_M:
            continue
        inside = outline[
            (outline > (BOUNDS.x_min, BOUNDS.y_min)).all(axis=1)
            & (outline < (BOUNDS.x_max, BOUNDS.y_max)).all(axis=1)
        ]
        at = seen_by.image_from_arena(inside)
        rim = np.minimum(at, np.array([width - 1, height - 1]) - at).min(axis=1)
        assert len(inside)
        assert (np.abs(rim) < 6.0).all()  # the fence runs along the picture's rim


def test_a_fence_stands_where_there_is_nothing_else() -> None:
    scene = joined(PLAN, [picture(LEFT, []), None])
    (fence,) = outlines_of(scene)
    assert fence[:, 0].max() > BOUNDS.x_max


def test_cameras_of_unlike_light_show_one_floor() -> None:
    shape = disc(1.0, 0.6, 0.1)
    two = [picture(LEFT, [shape]), picture(RIGHT, [shape], light=0.7)]
    gains = PLAN.gains(two)
    assert gains[1] / gains[0] == pytest.approx(1 / 0.7, rel=0.02)
    image = PLAN.picture(two, PLAN.owners((True, True)), gains)
    left, right = (np.median(image[PLAN.owners((True, True)) == i]) for i in (0, 1))
    assert abs(left - right) < 3.0


def test_a_camera_that_sees_nothing_of_the_arena_is_refused_by_its_name() -> None:
    with pytest.raises(CalibrationError, match="camera far sees nothing of the arena"):
        FloorPlan.of((LEFT, camera(9.0, 9.0)), BOUNDS, ("left", "far"))
    with pytest.raises(CalibrationError, match="needs a camera"):
        FloorPlan.of((), BOUNDS)


def test_a_rectangle_of_a_camera_lies_where_its_pixels_do() -> None:
    box = PLAN.rectangle(1, (200, 150, 40, 30))
    assert box is not None
    x, y, w, h = box
    corners = RIGHT.arena_from_image([(199.5, 149.5), (239.5, 149.5), (239.5, 179.5)])
    at = PLAN.calibration.image_from_arena(corners)
    assert (at >= (x, y)).all()
    assert (at <= (x + w, y + h)).all()
    assert PLAN.rectangle(0, (0, 0, 2, 2)) is None or LEFT.arena_from_image([(0, 0)])[0, 0] > 0.0


def test_where_the_lens_of_a_camera_is_blind_the_floor_is_unknown() -> None:
    """Low above the floor: towards the horizon a pixel covers too much of it."""
    lens = np.array([[100.0, 0.0, 319.5], [0.0, 100.0, 239.5], [0.0, 0.0, 1.0]])
    down = np.array([[1.0, 0.0, 0.0, -0.5], [0.0, -1.0, 0.0, 0.6], [0.0, 0.0, -1.0, 0.3]])
    wide = Calibration.from_camera((640, 480), lens, np.zeros(4), down, "fisheye")
    plan = FloorPlan.of((wide,), Bounds(0.0, 0.0, 6.0, 1.2))
    unknown = plan.unknown((True,))
    assert unknown is not None
    assert wide.blind is not None
    assert not plan.is_unknown(unknown, 0.5, 0.6, 0.1)
    ((x, y),) = wide.image_from_arena([(5.5, 0.6)])
    assert 0.0 < x < 639.0
    assert wide.blind[round(y), round(x)]
    assert plan.is_unknown(unknown, 5.5, 0.6, 0.05)
