"""What the simulated camera draws: areas, holes, the robot's body and its marker."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navigation.config import Config
from navigation.simulator.picture.camera import SimulatedCamera
from navigation.simulator.picture.drawing import ArenaPainter
from navigation.simulator.picture.pinhole import Pinhole
from planner.scene import (
    CircleRecord,
    SceneError,
    SceneObject,
    SegmentRecord,
)
from tests.navigation.simulator.drawn import (
    PLACES,
    PLAIN,
    darkness,
    detector,
    scene_of,
    square,
    straight_down,
)


@settings(max_examples=25, deadline=None)
@given(st.floats(1.0, 1.1), st.floats(1.0, 1.1), st.floats(0.05, 0.5))
def test_a_square_covers_its_area_and_has_its_centre(x: float, y: float, side: float) -> None:
    painter = ArenaPainter(straight_down(), PLAIN)
    dark = darkness(painter.picture(scene_of(SceneObject(0, (square(x, y, side),)))))
    rows, columns = np.nonzero(dark > 0.001)
    weights = dark[rows, columns]
    assert weights.sum() * 1e-4 == pytest.approx(side**2, abs=4 * side * 2e-4)
    centre = np.array([columns @ weights, 299 * weights.sum() - rows @ weights]) / weights.sum()
    assert centre * 0.01 == pytest.approx([x + side / 2, y + side / 2], abs=5e-4)


@pytest.mark.parametrize("radius", [0.03, 0.2, 0.7])
def test_a_circle_covers_its_area(radius: float) -> None:
    painter = ArenaPainter(straight_down(), PLAIN)
    picture = painter.picture(scene_of(SceneObject(0, (CircleRecord((1.503, 1.507), radius),))))
    assert darkness(picture).sum() * 1e-4 == pytest.approx(math.pi * radius**2, rel=2e-2)


def test_a_hole_shows_the_floor() -> None:
    ring = SceneObject(0, (square(1, 1, 1.0),), ((square(1.25, 1.25, 0.5),),))
    dark = darkness(ArenaPainter(straight_down(), PLAIN).picture(scene_of(ring)))
    assert dark.sum() * 1e-4 == pytest.approx(1.0 - 0.25, abs=2e-3)
    assert dark[299 - 150, 150] == 0.0


def test_obstacles_that_overlap_do_not_cancel() -> None:
    things = (SceneObject(0, (square(1, 1, 1.0),)), SceneObject(1, (square(1.5, 1, 1.0),)))
    dark = darkness(ArenaPainter(straight_down(), PLAIN).picture(scene_of(*things)))
    assert dark.sum() * 1e-4 == pytest.approx(1.5, abs=3e-3)


def test_an_obstacle_outside_the_picture_is_not_seen_and_one_at_its_edge_is_cut() -> None:
    painter = ArenaPainter(straight_down(), PLAIN)
    away = painter.picture(scene_of(SceneObject(0, (CircleRecord((-3, -3), 0.5),))))
    assert (away == 205).all()
    cut = painter.picture(scene_of(SceneObject(0, (square(3.5, 1, 1.0),))))
    assert darkness(cut).sum() * 1e-4 == pytest.approx(0.495, abs=2e-3)


def test_light_obstacles_on_a_dark_floor() -> None:
    look = replace(PLAIN, polarity="light")
    picture = ArenaPainter(straight_down(), look).picture(
        scene_of(SceneObject(0, (square(1, 1, 1),)))
    )
    assert (picture[150, 150], picture[10, 10]) == (205, 45)


def test_what_has_no_area_cannot_be_drawn() -> None:
    thing = SceneObject(4, (SegmentRecord((1, 1), (2, 2)),))
    with pytest.raises(SceneError, match="object 4: a SegmentRecord has no area"):
        ArenaPainter(straight_down(), PLAIN).picture(scene_of(thing))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("heading_deg", [0.0, 37.0, 90.0, -150.0])
def test_the_marker_is_seen_where_the_robot_is(
    place: tuple[float, float],
    heading_deg: float,
    config: Config,
    still: SimulatedCamera,
    pinhole: Pinhole,
) -> None:
    """OpenCV's detector is the oracle; its own error is 0.06 mm and 0.12 degrees rms here."""
    pose = (*place, math.radians(heading_deg))
    picture = still.render([pose], np.random.default_rng(4))
    corners, ids, _ = detector().detectMarkers(picture)
    assert ids is not None
    assert ids.ravel().tolist() == [config.robot.marker_id]
    on_top = pinhole.arena_from_image(
        np.array(corners[0], dtype=np.float64).reshape(-1, 2), config.robot.marker_height_m
    )
    assert on_top.mean(axis=0) == pytest.approx(place, abs=3e-4)
    forward = on_top[1] + on_top[2] - on_top[0] - on_top[3]
    turned = math.atan2(forward[1], forward[0]) - pose[2]
    assert abs(math.remainder(turned, math.tau)) < math.radians(0.5)


def test_the_body_is_seen_as_a_cylinder_from_its_foot_to_its_top(
    config: Config, still: SimulatedCamera, pinhole: Pinhole
) -> None:
    pose = (2.2, 1.6, 0.0)
    with_robot = still.render([pose], None).astype(int)
    without = still.render([(50.0, 50.0, 0.0)], None).astype(int)
    changed = np.abs(with_robot - without) > 40
    turns = np.linspace(0, math.tau, 64)
    inner = 0.97 * config.robot.radius_m * np.column_stack([np.cos(turns), np.sin(turns)])
    outer = inner / 0.97 * 1.06
    # The white around the marker is as light as the floor.
    half = config.robot.marker_size_m * (0.5 + 1 / 6)
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    white = pinhole.image_from_arena(square + pose[:2], 0.12).astype(np.float32)
    for height_m in (0.0, 0.06, 0.12):
        body = np.rint(pinhole.image_from_arena(inner + pose[:2], height_m)).astype(int)
        on_marker = (
            np.array([cv2.pointPolygonTest(white, (float(x), float(y)), True) for x, y in body])
            > -2.0
        )
        assert changed[body[:, 1], body[:, 0]][~on_marker].all()
    hull = cv2.convexHull(
        np.concatenate([pinhole.image_from_arena(outer + pose[:2], h) for h in (0.0, 0.12)]).astype(
            np.float32
        )
    )
    rows, columns = np.nonzero(changed)
    assert all(
        cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0
        for x, y in zip(columns, rows, strict=True)
    )


def test_a_robot_outside_the_picture_changes_nothing(still: SimulatedCamera) -> None:
    away, further = still.render([(9.0, 9.0, 0.0)], None), still.render([(-9.0, 1.0, 1.0)], None)
    assert np.array_equal(away, further)


def test_a_robot_cut_by_the_picture_s_edge_is_drawn(still: SimulatedCamera) -> None:
    picture = still.render([(-0.1, 0.9, 0.5)], None)
    assert (picture != still.render([(9.0, 9.0, 0.0)], None)).any()
