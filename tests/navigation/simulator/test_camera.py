"""The simulated camera: exact geometry, honest timing, and nothing that gives it away."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navigation.config import Config, load_config
from navigation.config.sections import MarkerSection
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.picture.camera import SimulatedCamera, make_camera
from navigation.simulator.picture.drawing import ArenaPainter, Look
from navigation.simulator.picture.pinhole import Pinhole, distort, pinhole_of, undistort
from planner.scene import (
    Bounds,
    CircleRecord,
    FloatArray,
    PolygonRecord,
    Scene,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
)
from vision.camera.camera import CameraError, Image
from vision.camera.latest_frame import LatestFrame

PLACES = [(0.25, 0.25), (1.2, 0.95), (2.2, 1.6), (2.2, 0.2), (0.2, 1.6), (1.3, 0.55)]


class Clock:
    """Virtual time."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def wait(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now_s += seconds


@pytest.fixture(scope="module")
def config() -> Config:
    return load_config("configs/simulation.yaml", {})


@pytest.fixture(scope="module")
def arena(config: Config) -> SimulatedArena:
    return load_arena(config)


@pytest.fixture(scope="module")
def pinhole(config: Config) -> Pinhole:
    return pinhole_of(config)


@pytest.fixture(scope="module")
def still(config: Config, arena: SimulatedArena) -> SimulatedCamera:
    clock = Clock()
    return make_camera(config, arena, lambda: (0.2, 0.2, 0.0), clock, clock.wait)


# Geometry.


@cache
def _laboratory_pinhole() -> Pinhole:
    return pinhole_of(load_config("configs/simulation.yaml", {}))


@given(st.floats(0.0, 2.4), st.floats(0.0, 1.8), st.floats(0.0, 0.3))
def test_projection_agrees_with_opencv(x: float, y: float, z: float) -> None:
    pinhole = _laboratory_pinhole()
    turn, _ = cv2.Rodrigues(np.array(pinhole.camera_from_arena))
    shift = -pinhole.camera_from_arena @ pinhole.position_m
    expected, _ = cv2.projectPoints(
        np.array([[x, y, z]]), turn, shift, np.array(pinhole.matrix), np.array(pinhole.distortion)
    )
    assert pinhole.image_from_arena([[x, y, z]]) == pytest.approx(expected.reshape(-1, 2), abs=1e-8)


def test_pixels_and_places_are_each_other_s_inverse(pinhole: Pinhole) -> None:
    pixels = np.random.default_rng(0).uniform((-0.5, -0.5), (1279.5, 959.5), (200, 2))
    for height_m in (0.0, 0.12):
        there = pinhole.arena_from_image(pixels, height_m)
        assert pinhole.image_from_arena(there, height_m) == pytest.approx(pixels, abs=1e-7)


@given(st.floats(-0.3, 0.1), st.floats(-0.05, 0.05), st.floats(-0.001, 0.001))
def test_distortion_is_undone(k1: float, k2: float, p1: float) -> None:
    terms = np.array([k1, k2, p1, -p1, 0.0])
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (20, 2))
    assert undistort(distort(points, terms), terms) == pytest.approx(points, abs=1e-10)


def test_a_lens_that_folds_the_picture_over_is_refused() -> None:
    with pytest.raises(ValueError, match="folds over"):
        undistort(np.array([[2.0, 0.0]]), np.array([-1.0, 0.0, 0.0, 0.0, 0.0]))


def test_the_true_calibration_maps_as_the_pinhole_does(pinhole: Pinhole) -> None:
    calibration = pinhole.calibration()
    pixels = np.random.default_rng(2).uniform((0, 0), (1279, 959), (50, 2))
    for height_m in (0.0, 0.12):
        expected = pinhole.arena_from_image(pixels, height_m)
        assert calibration.arena_from_image(pixels, height_m) == pytest.approx(expected, abs=1e-8)


def test_the_whole_arena_and_robots_at_its_walls_are_in_the_picture(
    config: Config, pinhole: Pinhole
) -> None:
    x0, y0, x1, y1 = config.arena.bounds_m
    corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    for height_m in (0.0, config.robot.marker_height_m):
        seen = pinhole.image_from_arena(corners, height_m)
        assert (seen > 1).all()
        assert (seen < (1278, 958)).all()


# What is drawn.

PLAIN = Look(blur_px=0.0, noise_grey=0.0, light_fall=0.0)


def _straight_down(
    size_px: tuple[int, int] = (400, 300), metres_per_pixel: float = 0.01
) -> Pinhole:
    """No distortion, looking straight down: pixel (0, h - 1) is the place (0, 0)."""
    height_m = 2.0
    focal = height_m / metres_per_pixel
    width, height = size_px
    centre = ((width - 1) / 2, (height - 1) / 2)
    matrix = np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1.0]])
    position = np.array([centre[0] * metres_per_pixel, centre[1] * metres_per_pixel, height_m])
    return Pinhole(size_px, matrix, np.zeros(5), np.diag([1.0, -1.0, -1.0]), position)


def _scene(*things: SceneObject) -> Scene:
    return Scene("m", Bounds(0, 0, 4, 3), things)


def _darkness(picture: Image) -> FloatArray:
    """The part of each pixel that an obstacle covers, from its grey value."""
    return (205.0 - picture) / (205.0 - 45.0)


def _square(x0: float, y0: float, side: float) -> PolygonRecord:
    c = ((x0, y0), (x0, y0 + side), (x0 + side, y0 + side), (x0 + side, y0))
    return PolygonRecord(tuple(Segment(c[i], c[(i + 1) % 4]) for i in range(4)))


@settings(max_examples=25, deadline=None)
@given(st.floats(1.0, 1.1), st.floats(1.0, 1.1), st.floats(0.05, 0.5))
def test_a_square_covers_its_area_and_has_its_centre(x: float, y: float, side: float) -> None:
    painter = ArenaPainter(_straight_down(), PLAIN)
    dark = _darkness(painter.picture(_scene(SceneObject(0, (_square(x, y, side),)))))
    rows, columns = np.nonzero(dark > 0.001)
    weights = dark[rows, columns]
    assert weights.sum() * 1e-4 == pytest.approx(side**2, abs=4 * side * 2e-4)
    centre = np.array([columns @ weights, 299 * weights.sum() - rows @ weights]) / weights.sum()
    assert centre * 0.01 == pytest.approx([x + side / 2, y + side / 2], abs=5e-4)


@pytest.mark.parametrize("radius", [0.03, 0.2, 0.7])
def test_a_circle_covers_its_area(radius: float) -> None:
    painter = ArenaPainter(_straight_down(), PLAIN)
    picture = painter.picture(_scene(SceneObject(0, (CircleRecord((1.503, 1.507), radius),))))
    assert _darkness(picture).sum() * 1e-4 == pytest.approx(math.pi * radius**2, rel=2e-2)


def test_a_hole_shows_the_floor() -> None:
    ring = SceneObject(0, (_square(1, 1, 1.0),), ((_square(1.25, 1.25, 0.5),),))
    dark = _darkness(ArenaPainter(_straight_down(), PLAIN).picture(_scene(ring)))
    assert dark.sum() * 1e-4 == pytest.approx(1.0 - 0.25, abs=2e-3)
    assert dark[299 - 150, 150] == 0.0


def test_obstacles_that_overlap_do_not_cancel() -> None:
    things = (SceneObject(0, (_square(1, 1, 1.0),)), SceneObject(1, (_square(1.5, 1, 1.0),)))
    dark = _darkness(ArenaPainter(_straight_down(), PLAIN).picture(_scene(*things)))
    assert dark.sum() * 1e-4 == pytest.approx(1.5, abs=3e-3)


def test_an_obstacle_outside_the_picture_is_not_seen_and_one_at_its_edge_is_cut() -> None:
    painter = ArenaPainter(_straight_down(), PLAIN)
    away = painter.picture(_scene(SceneObject(0, (CircleRecord((-3, -3), 0.5),))))
    assert (away == 205).all()
    cut = painter.picture(_scene(SceneObject(0, (_square(3.5, 1, 1.0),))))
    assert _darkness(cut).sum() * 1e-4 == pytest.approx(0.495, abs=2e-3)


def test_light_obstacles_on_a_dark_floor() -> None:
    look = replace(PLAIN, polarity="light")
    picture = ArenaPainter(_straight_down(), look).picture(
        _scene(SceneObject(0, (_square(1, 1, 1),)))
    )
    assert (picture[150, 150], picture[10, 10]) == (205, 45)


def test_what_has_no_area_cannot_be_drawn() -> None:
    thing = SceneObject(4, (SegmentRecord((1, 1), (2, 2)),))
    with pytest.raises(SceneError, match="object 4: a SegmentRecord has no area"):
        ArenaPainter(_straight_down(), PLAIN).picture(_scene(thing))


def _detector() -> cv2.aruco.ArucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.ArucoDetector(dictionary, parameters)


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
    corners, ids, _ = _detector().detectMarkers(picture)
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


# Light and noise.


def test_the_noise_has_the_spread_asked_for_and_changes_each_frame(
    config: Config, still: SimulatedCamera
) -> None:
    pose, rng = (0.2, 0.2, 0.0), np.random.default_rng(9)
    clean = still.render([pose], None).astype(float)
    noisy = [still.render([pose], rng).astype(float) - clean for _ in range(8)]
    assert config.simulation is not None
    sigma = config.simulation.camera.noise_grey
    spread = np.std(noisy)
    assert spread == pytest.approx(math.hypot(sigma, math.sqrt(1 / 12)), rel=0.03)
    assert abs(np.mean(noisy)) < 0.02
    assert all(
        abs(np.corrcoef(noisy[0].ravel(), other.ravel())[0, 1]) < 0.02 for other in noisy[1:]
    )


@pytest.mark.parametrize(
    ("noise_grey", "repeats"),
    [(0.0, True), (0.00123, True), (0.1, True), (0.2, False), (2.5, False)],
)
def test_pictures_may_repeat_where_their_noise_changes_hardly_a_pixel(
    noise_grey: float, repeats: bool, config: Config, arena: SimulatedArena
) -> None:
    """A sweep drew 0.00123 grey levels: the standing robot's pictures passed for a frozen camera.

    One of 0.1 changes a pixel or none in each picture of 1.2 million.
    """
    assert config.simulation is not None
    look = config.simulation.camera.model_copy(update={"noise_grey": noise_grey})
    noisy = config.simulation.model_copy(update={"camera": look})
    clock = Clock()
    changed = config.model_copy(update={"simulation": noisy})
    camera = make_camera(changed, arena, lambda: (0.2, 0.2, 0.0), clock, clock.wait)
    assert camera.may_repeat == repeats
    frames = LatestFrame(lambda: camera, clock)
    pictures = []
    for _ in range(60):
        frames.step()
        frame = frames.take()
        pictures += [] if frame is None else [frame.image]
    assert frames.status().state == "running"
    assert len(pictures) == 59, "one step opens the camera"
    same = [np.array_equal(a, b) for a, b in pairwise(pictures)]
    assert repeats or not any(same)
    assert all(same) or noise_grey > 0.01


def test_the_floor_is_lit_unevenly_as_configured(config: Config) -> None:
    assert config.simulation is not None
    fall = config.simulation.camera.light_fall
    look = replace(PLAIN, light_fall=fall)
    picture = ArenaPainter(_straight_down(), look).picture(_scene()).astype(float)
    corners = picture[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert picture.max() == 205
    assert corners.min() == picture.min() == pytest.approx((1 - fall) * 205, abs=1)


def test_the_same_seed_gives_the_same_pictures(config: Config, arena: SimulatedArena) -> None:
    def pictures() -> list[Image]:
        clock = Clock()
        camera = make_camera(config, arena, lambda: (0.3, 0.3, 0.1), clock, clock.wait)
        camera.open()
        frames = [camera.read(1.0) for _ in range(3)]
        return [frame.image for frame in frames if frame is not None]

    first, second = pictures(), pictures()
    assert len(first) == 3
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


# Time.


def _camera(
    config: Config, arena: SimulatedArena, clock: Clock, latency_s: float = 0.0
) -> SimulatedCamera:
    assert config.simulation is not None
    lens = config.simulation.camera.model_copy(update={"latency_s": latency_s, "focal_px": 310.0})
    simulation = config.simulation.model_copy(update={"camera": lens})
    small = config.camera.model_copy(update={"size_px": (320, 240)})
    changed = config.model_copy(update={"simulation": simulation, "camera": small})
    return make_camera(changed, arena, lambda: (clock.now_s - 100.0, 0.5, 0.0), clock, clock.wait)


def test_frames_come_at_the_rate_and_are_numbered(config: Config, arena: SimulatedArena) -> None:
    clock = Clock()
    camera = _camera(config, arena, clock)
    camera.open()
    frames = [camera.read(1.0) for _ in range(31)]
    assert all(frame is not None for frame in frames)
    times = [frame.captured_s for frame in frames if frame is not None]
    assert np.diff(times) == pytest.approx(1 / 30, abs=1e-9)
    assert [frame.sequence for frame in frames if frame is not None] == list(range(31))
    assert camera.rate_hz == pytest.approx(30.0)


def test_a_read_that_is_too_short_gives_none_and_waits_no_longer(
    config: Config, arena: SimulatedArena
) -> None:
    clock = Clock()
    camera = _camera(config, arena, clock)
    camera.open()
    assert camera.read(0.0) is not None
    before = clock.now_s
    assert camera.read(0.01) is None
    assert clock.now_s == pytest.approx(before + 0.01)
    assert camera.read(0.03) is not None


def test_a_late_reader_misses_frames_and_keeps_the_rhythm(
    config: Config, arena: SimulatedArena
) -> None:
    clock = Clock()
    camera = _camera(config, arena, clock)
    camera.open()
    assert camera.read(1.0) is not None
    clock.wait(10.5 / 30)
    late = camera.read(1.0)
    following = camera.read(1.0)
    assert late is not None
    assert following is not None
    assert late.captured_s == pytest.approx(100.0 + 10.5 / 30)
    assert following.captured_s == pytest.approx(100.0 + 11 / 30)


def test_latency_delays_the_picture_and_not_its_time_stamp(
    config: Config, arena: SimulatedArena
) -> None:
    clock = Clock()
    camera = _camera(config, arena, clock, latency_s=0.02)
    camera.open()
    frame = camera.read(1.0)
    assert frame is not None
    assert frame.captured_s == 100.0
    assert clock.now_s == pytest.approx(100.02)


def test_a_closed_camera_says_so_and_can_be_opened_again(
    config: Config, arena: SimulatedArena
) -> None:
    camera = _camera(config, arena, Clock())
    assert camera.state == "closed"
    with pytest.raises(CameraError, match="is not open"):
        camera.read(0.1)
    for _ in range(2):
        camera.open()
        assert camera.state == "running"
        assert camera.read(0.1) is not None
        camera.close()
    assert camera.state == "closed"


def test_a_changed_scene_is_seen_from_the_next_frame_on(
    config: Config, arena: SimulatedArena
) -> None:
    clock = Clock()
    camera = _camera(config, arena, clock)
    camera.open()
    with_all = camera.render([(9.0, 9.0, 0.0)], None)
    camera.set_scene(replace(arena.scene, objects=arena.scene.objects[1:]))
    with_fewer = camera.render([(9.0, 9.0, 0.0)], None)
    assert with_all.shape == with_fewer.shape == (240, 320)
    assert (with_fewer.astype(int) - with_all > 100).sum() > 20
    assert not (with_fewer.astype(int) - with_all < -5).any()


def test_the_background_stays_as_it_was_whatever_is_drawn_on_it(still: SimulatedCamera) -> None:
    before = still.render([(9.0, 9.0, 0.0)], None)
    still.render([(1.2, 0.9, 0.3)], np.random.default_rng(0))
    assert np.array_equal(still.render([(9.0, 9.0, 0.0)], None), before)


def test_other_robots_are_drawn_where_they_are(config: Config, arena: SimulatedArena) -> None:
    other = MarkerSection(marker_id=9, marker_size_m=0.08, marker_height_m=0.2, radius_m=0.08)
    two = config.model_copy(update={"other_robots": (other,)})
    clock = Clock()
    camera = make_camera(
        two, arena, lambda: (0.25, 0.25, 0.0), clock, clock.wait, [lambda: (1.4, 1.0, 1.0)]
    )
    camera.open()
    frame = camera.read(1.0)
    assert frame is not None
    corners, ids, _ = _detector().detectMarkers(frame.image)
    assert ids is not None
    seen = dict(zip(ids.ravel().tolist(), corners, strict=True))
    assert set(seen) == {config.robot.marker_id, 9}
    there = np.array(seen[9], dtype=np.float64).reshape(-1, 2)
    place = pinhole_of(config).arena_from_image(there, 0.2).mean(axis=0)
    assert place == pytest.approx((1.4, 1.0), abs=5e-4)


def test_every_other_robot_needs_its_place(config: Config, arena: SimulatedArena) -> None:
    with pytest.raises(ValueError, match="zip"):
        make_camera(
            config, arena, lambda: (0.2, 0.2, 0.0), Clock(), others=[lambda: (1.0, 1.0, 0.0)]
        )
