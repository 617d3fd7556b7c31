"""The simulated camera's light, noise and time."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from navigation.config import Config
from navigation.config.sections import MarkerSection
from navigation.simulator.arena import SimulatedArena
from navigation.simulator.picture.camera import SimulatedCamera, make_camera
from navigation.simulator.picture.drawing import ArenaPainter
from navigation.simulator.picture.pinhole import pinhole_of
from tests.navigation.simulator.drawn import PLAIN, Clock, detector, scene_of, straight_down
from vision.camera.camera import CameraError, Image
from vision.camera.latest_frame import LatestFrame

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
    camera = make_camera(
        changed, arena, [(changed.robot, lambda _at_s: (0.2, 0.2, 0.0))], clock, clock.wait
    )
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
    picture = ArenaPainter(straight_down(), look).picture(scene_of()).astype(float)
    corners = picture[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert picture.max() == 205
    assert corners.min() == picture.min() == pytest.approx((1 - fall) * 205, abs=1)


def test_the_same_seed_gives_the_same_pictures(config: Config, arena: SimulatedArena) -> None:
    def pictures() -> list[Image]:
        clock = Clock()
        camera = make_camera(
            config, arena, [(config.robot, lambda _at_s: (0.3, 0.3, 0.1))], clock, clock.wait
        )
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
    return make_camera(
        changed,
        arena,
        [(changed.robot, lambda _at_s: (clock.now_s - 100.0, 0.5, 0.0))],
        clock,
        clock.wait,
    )


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


def test_a_picture_shows_robots_at_its_exposure_however_late_its_thread_draws_it(
    config: Config, arena: SimulatedArena, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, asked = Clock(), list[float]()

    def pose_at(at_s: float) -> tuple[float, float, float]:
        asked.append(at_s)
        return (0.5, 0.5, 0.0)

    camera = make_camera(config, arena, [(config.robot, pose_at)], clock, clock.wait)
    expose = camera._expose

    def late(prepared: Any, captured_s: float) -> Image:
        clock.now_s += 0.04
        return expose(prepared, captured_s)

    monkeypatch.setattr(camera, "_expose", late)
    camera.open()
    frames = [camera.read(1.0) for _ in range(3)]
    assert asked == [frame.captured_s for frame in frames if frame is not None]


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


def test_what_was_drawn_before_changes_no_picture(config: Config, arena: SimulatedArena) -> None:
    used = _camera(config, arena, Clock())
    fewer = replace(arena.scene, objects=arena.scene.objects[1:])
    here, there, outside = (0.2, 0.2, 0.0), (0.2, 0.2, 0.1), (9.0, 9.0, 0.0)
    for pose, scene in [
        (here, arena.scene), (here, fewer), (there, fewer), (outside, fewer), (here, arena.scene)
    ]:  # fmt: skip
        used.set_scene(scene)
        fresh = _camera(config, arena, Clock())
        fresh.set_scene(scene)
        assert np.array_equal(used.render([pose], None), fresh.render([pose], None))


def test_other_robots_are_drawn_where_they_are(config: Config, arena: SimulatedArena) -> None:
    other = MarkerSection(marker_id=9, marker_size_m=0.08, marker_height_m=0.2, radius_m=0.08)
    two = config.model_copy(update={"other_robots": (other,)})
    clock = Clock()
    camera = make_camera(
        two,
        arena,
        [(two.robot, lambda _at_s: (0.25, 0.25, 0.0))],
        clock,
        clock.wait,
        [lambda _at_s: (1.4, 1.0, 1.0)],
    )
    camera.open()
    frame = camera.read(1.0)
    assert frame is not None
    corners, ids, _ = detector().detectMarkers(frame.image)
    assert ids is not None
    seen = dict(zip(ids.ravel().tolist(), corners, strict=True))
    assert set(seen) == {config.robot.marker_id, 9}
    there = np.array(seen[9], dtype=np.float64).reshape(-1, 2)
    place = pinhole_of(config).arena_from_image(there, 0.2).mean(axis=0)
    assert place == pytest.approx((1.4, 1.0), abs=5e-4)


@pytest.mark.parametrize("outer_first", [True, False])
def test_who_is_nearer_to_the_lens_covers_the_other_whatever_their_order(
    outer_first: bool, config: Config, arena: SimulatedArena
) -> None:
    """The outer of two robots side by side was drawn over the other one's marker."""
    other = MarkerSection(marker_id=9, marker_size_m=0.08, marker_height_m=0.2, radius_m=0.08)
    two = config.model_copy(update={"other_robots": (other,)})
    x_m, y_m, _ = pinhole_of(config).position_m
    reach_m = config.robot.radius_m + 0.08 + 0.002
    inner = (x_m - 0.6, y_m - 0.45, 0.0)
    outer = (inner[0] - 0.8 * reach_m, inner[1] - 0.6 * reach_m, 0.0)
    poses = (outer, inner) if outer_first else (inner, outer)
    camera = make_camera(
        two, arena, [(two.robot, lambda _at_s: poses[0])], Clock(), others=[lambda _at_s: poses[1]]
    )
    away = (x_m + 0.5, y_m + 0.4, 0.0)
    alone = camera.render([away, inner] if outer_first else [inner, away], None)
    corners, ids, _ = detector().detectMarkers(alone)
    assert ids is not None
    seen = dict(zip(ids.ravel().tolist(), corners, strict=True))
    at = np.asarray(seen[9 if outer_first else config.robot.marker_id], np.int32).reshape(-1, 2)
    (x0, y0), (x1, y1) = at.min(axis=0) - 4, at.max(axis=0) + 4
    both = camera.render(poses, None)
    assert np.array_equal(both[y0:y1, x0:x1], alone[y0:y1, x0:x1])


def test_every_other_robot_needs_its_place(config: Config, arena: SimulatedArena) -> None:
    with pytest.raises(ValueError, match="zip"):
        make_camera(
            config,
            arena,
            [(config.robot, lambda _at_s: (0.2, 0.2, 0.0))],
            Clock(),
            others=[lambda _at_s: (1.0, 1.0, 0.0)],
        )
