"""A board that stands still is told from one that moves, whatever the noise."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision.calibrate.views import views
from vision.calibrate.board import BoardView
from vision.calibrate.live.board_stillness import STILL_S, BoardStillness

FRAME_S = 1 / 30


def watched(step_px: float, noise_px: float, frames: int = 40, seed: int = 0) -> float:
    (view,) = views(1, noise_px=0.0)
    rng = np.random.default_rng(seed)
    stillness, found = BoardStillness(), 0.0
    for i in range(frames):
        corners = (
            view.corners_px + np.array([i * step_px, 0.0]) + rng.normal(0.0, noise_px, (54, 2))
        )
        found = stillness.add(i * FRAME_S, BoardView("v", view.size, corners, view.points_m))
    return found


@pytest.mark.parametrize("noise_px", [0.0, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_is_no_movement(noise_px: float, seed: int) -> None:
    assert watched(0.0, noise_px, seed=seed) == 1.0


@pytest.mark.parametrize("noise_px", [0.0, 0.1, 1.0])
def test_a_movement_is_seen_through_noise(noise_px: float) -> None:
    assert watched(2.0, noise_px) == 0.0


def test_it_takes_its_time_and_begins_again() -> None:
    (view,) = views(1)
    stillness = BoardStillness()
    shares = [stillness.add(i * 0.1, view) for i in range(8)]
    assert shares == pytest.approx([min(1.0, 0.1 * i / STILL_S) for i in range(8)])
    stillness.begin_again()
    assert stillness.add(0.8, view) == pytest.approx(0.1 / STILL_S)
    assert stillness.add(0.9, None) == 0.0
    assert stillness.add(1.0, view) == 0.0


def test_a_gap_or_another_part_of_the_board_is_not_stillness() -> None:
    (view,) = views(1)
    stillness = BoardStillness()
    stillness.add(0.0, view)
    assert stillness.add(0.1, view) > 0.0
    assert stillness.add(2.0, view) == 0.0
    parts = [BoardView("v", view.size, view.corners_px[s], view.points_m[s])
             for s in (slice(0, 20), slice(16, 54))]  # fmt: skip
    stillness.add(2.1, parts[0])
    assert stillness.add(2.2, parts[1]) == 0.0
