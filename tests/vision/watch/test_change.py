"""A static arena is silent; a changed one is reported within three frames, and only it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vision.watch.change import Change, SceneWatcher

WIDTH, HEIGHT = 640, 480
NOBODY = np.empty((0, 3))
Picture = NDArray[np.uint8]


def arena(*boxes: tuple[int, int, int, int], floor: int = 190) -> Picture:
    picture = np.full((HEIGHT, WIDTH), floor, np.uint8)
    for x, y, w, h in ((60, 60, 80, 60), (400, 300, 120, 70), *boxes):
        picture[y : y + h, x : x + w] = 40
    return cv2.GaussianBlur(picture, (0, 0), 0.8).astype(np.uint8)


def shot(
    picture: Picture,
    rng: np.random.Generator,
    noise: float = 5.0,
    robot: tuple[int, int, int] | None = None,
    gain: float = 1.0,
) -> Picture:
    seen = picture.copy()
    if robot is not None:
        x, y, r = robot
        cv2.circle(seen, (x, y), r, 90, -1)
        cv2.rectangle(seen, (x - r // 2, y - r // 2), (x + r // 2, y + r // 2), 10, -1)
    return np.clip(seen * gain + rng.normal(0.0, noise, seen.shape), 0, 255).astype(np.uint8)


def covers(change: Change, box: tuple[int, int, int, int]) -> bool:
    x, y, w, h = box
    return any(
        rx <= x and ry <= y and rx + rw >= x + w and ry + rh >= y + h
        for rx, ry, rw, rh in change.rectangles
    )


def report_within(
    watcher: SceneWatcher, frames: int, picture: Picture, rng: np.random.Generator, **how: float
) -> Change | None:
    for _ in range(frames):
        change = watcher.update(shot(picture, rng, **how), NOBODY)
        if change is not None:
            return change
    return None


def settled(rng: np.random.Generator, noise: float = 5.0, frames: int = 3) -> SceneWatcher:
    watcher = SceneWatcher()
    for _ in range(frames):
        watcher.update(shot(arena(), rng, noise), NOBODY)
    return watcher


def test_the_first_frame_is_a_change_of_everything() -> None:
    change = SceneWatcher().update(arena(), NOBODY)
    assert change is not None
    assert change.first
    assert change.rectangles == ((0, 0, WIDTH, HEIGHT),)


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0, 20.0])
def test_noise_is_never_a_change(noise: float) -> None:
    rng = np.random.default_rng(3)
    watcher = settled(rng, noise, frames=1)
    assert report_within(watcher, 40, arena(), rng, noise=noise) is None


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.integers(0, WIDTH - 40),
    st.integers(0, HEIGHT - 40),
    st.integers(10, 40),
    st.sampled_from([0.0, 5.0, 20.0]),
)
def test_an_added_obstacle_is_reported_within_three_frames(
    x: int, y: int, side: int, noise: float
) -> None:
    rng = np.random.default_rng(x + 1000 * y)
    watcher = settled(rng, noise)
    with_it = arena((x, y, side, side))
    if np.count_nonzero(np.abs(with_it.astype(int) - arena()) > 100) < 60:
        return  # it lies within another obstacle
    change = report_within(watcher, 3, with_it, rng, noise=noise)
    assert change is not None
    cells = sum(w * h for _, _, w, h in change.rectangles)
    assert cells < (side + 40) * (side + 40) * 2
    assert report_within(watcher, 10, with_it, rng, noise=noise) is None, "reported twice"
    shown = watcher.background.astype(int) - with_it
    assert np.abs(cv2.blur(shown.astype(np.float32), (9, 9))).max() < 30.0


def test_a_removed_obstacle_is_reported_and_gone_from_the_background() -> None:
    rng = np.random.default_rng(1)
    box = (250, 200, 50, 40)
    watcher = SceneWatcher()
    for _ in range(4):
        watcher.update(shot(arena(box), rng), NOBODY)
    change = report_within(watcher, 3, arena(), rng)
    assert change is not None
    assert covers(change, box)
    assert watcher.background[200:240, 250:300].min() > 150


def test_an_obstacle_moved_by_three_pixels_is_reported() -> None:
    rng = np.random.default_rng(2)
    watcher = SceneWatcher()
    for _ in range(4):
        watcher.update(shot(arena((250, 200, 50, 40)), rng), NOBODY)
    change = report_within(watcher, 3, arena((253, 200, 50, 40)), rng)
    assert change is not None


def test_an_obstacle_that_creeps_is_reported_before_it_has_gone_far() -> None:
    rng = np.random.default_rng(4)
    watcher = SceneWatcher()
    watcher.update(shot(arena((250, 200, 50, 40)), rng), NOBODY)
    for frame in range(400):
        step = frame // 40
        change = watcher.update(shot(arena((250 + step, 200, 50, 40)), rng), NOBODY)
        if change is not None:
            break
    assert step <= 3


def test_a_robot_that_drives_about_is_never_a_change() -> None:
    rng = np.random.default_rng(5)
    watcher = SceneWatcher()
    for frame in range(60):
        robot = (200 + 2 * frame, 150 + frame, 25)
        body = np.array([[robot[0], robot[1], robot[2] + 3.0]])
        change = watcher.update(shot(arena(), rng, robot=robot), body)
        assert (change is None) == (frame > 0), frame
    error = watcher.background.astype(int) - arena()
    assert np.abs(error).max() < 40


def test_an_obstacle_set_down_under_the_robot_is_reported_when_it_drives_off() -> None:
    rng = np.random.default_rng(6)
    watcher = SceneWatcher()
    box = (290, 190, 20, 20)
    for _ in range(5):
        watcher.update(shot(arena(), rng, robot=(300, 200, 30)), np.array([[300, 200, 33.0]]))
    changes = []
    for frame in range(40):
        robot = (300 + 3 * frame, 200, 30)
        changes.append(
            watcher.update(
                shot(arena(box), rng, robot=robot), np.array([[robot[0], robot[1], 33.0]])
            )
        )
    assert any(c is not None for c in changes)
    assert watcher.background[195:205, 295:305].max() < 90


def test_an_obstacle_below_the_edge_of_a_robot_is_kept_whole() -> None:
    rng = np.random.default_rng(7)
    box = (320, 180, 60, 60)
    watcher = SceneWatcher()
    for frame in range(60):
        robot = (220 + 3 * frame, 200, 30)  # drives over and past it
        body = np.array([[robot[0], robot[1], 33.0]])
        change = watcher.update(shot(arena(box), rng, robot=robot), body)
        assert change is None or frame == 0, frame
    assert watcher.background[185:235, 325:375].max() < 90


def test_what_was_never_seen_is_filled_from_around_it() -> None:
    watcher = SceneWatcher()
    robot = (300, 200, 30)
    picture = shot(arena(), np.random.default_rng(0), 0.0, robot)
    watcher.update(picture, np.array([[300.0, 200.0, 33.0]]))
    assert np.abs(watcher.background[170:230, 270:330].astype(int) - 190).max() <= 2


@pytest.mark.parametrize("gain", [0.7, 0.9, 1.2])
def test_another_light_is_no_change(gain: float) -> None:
    rng = np.random.default_rng(8)
    watcher = settled(rng)
    assert report_within(watcher, 20, arena(), rng, gain=gain) is None


def test_an_obstacle_in_another_light_is_still_a_change() -> None:
    rng = np.random.default_rng(9)
    watcher = settled(rng)
    report_within(watcher, 5, arena(), rng, gain=0.75)
    change = report_within(watcher, 3, arena((200, 380, 40, 40)), rng, gain=0.75)
    assert change is not None
    assert covers(change, (200, 380, 40, 40))
    floor = watcher.background[20:40, 300:500].mean()
    assert abs(floor - watcher.background[350:370, 205:235].mean()) < 6.0


def test_an_unknown_robot_place_suspends_the_judgement() -> None:
    rng = np.random.default_rng(10)
    watcher = settled(rng)
    before = watcher.background
    for _ in range(5):
        assert watcher.update(shot(arena((0, 0, 300, 300)), rng), None) is None
    assert np.array_equal(watcher.background, before)


def test_a_frame_of_another_size_starts_again() -> None:
    watcher = SceneWatcher()
    watcher.update(arena(), NOBODY)
    change = watcher.update(np.full((100, 100, 3), 90, np.uint8), NOBODY)
    assert change is not None
    assert change.first
    assert watcher.background.shape == (100, 100, 3)


def test_the_background_is_a_copy_that_cannot_be_written() -> None:
    watcher = SceneWatcher()
    with pytest.raises(ValueError, match="before the first frame"):
        _ = watcher.background
    picture = arena()
    kept = picture.copy()
    watcher.update(picture, np.array([[300.0, 200.0, 33.0], [-50.0, 900.0, 10.0]]))
    assert not watcher.background.flags.writeable
    assert np.array_equal(picture, kept)


@pytest.mark.parametrize("shape", [(1, 1), (3, 700), (241, 243), (480, 640, 3)])
def test_any_size_of_picture_is_watched(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(11)
    watcher = SceneWatcher()
    for _ in range(4):
        watcher.update(rng.integers(90, 110, shape).astype(np.uint8), np.array([[5, 5, 2.0]]))
    assert watcher.background.shape == shape
