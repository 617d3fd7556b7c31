"""The other robots as seen: told from the driven one, carried on, kept for the picture."""

from __future__ import annotations

import numpy as np
import pytest

from navigation.loop.seeing.other_robots import OtherRobots
from navigation.mission.traffic import LOST_S
from vision.markers.markers import RobotPose


def pose(marker_id: int, time_s: float, x: float, vx: float = 0.0) -> RobotPose:
    return RobotPose(marker_id, x, 1.0, 0.5, time_s, np.zeros((4, 2)), vx=vx)


def test_only_those_named_are_other_robots() -> None:
    others = OtherRobots({8: 0.1})
    others.see({7: pose(7, 1.0, 0.2), 8: pose(8, 1.0, 0.4)})
    (mover,) = others.movers(1.0)
    assert (mover.id, mover.x_m, mover.radius_m) == (8, 0.4, 0.1)
    assert list(others.tracks) == [8]


def test_one_is_carried_on_with_its_velocity_until_it_is_lost() -> None:
    others = OtherRobots({8: 0.1})
    others.see({8: pose(8, 1.0, 0.4, vx=0.2)})
    (soon,) = others.movers(1.0 + 0.5 * LOST_S)
    assert soon.x_m == pytest.approx(0.4 + 0.1 * LOST_S)
    (lost,) = others.movers(1.0 + 2.0 * LOST_S)
    assert lost.x_m == 0.4
    assert lost.age_s == pytest.approx(2.0 * LOST_S)


def test_a_track_ends_where_the_robot_was_last_even_when_it_is_out_of_view() -> None:
    others = OtherRobots({8: 0.1, 9: 0.1})
    for n in range(100):
        others.see({8: pose(8, 0.1 * n, 0.001 * n)})
    others.see({})
    rows = others.tracks[8].rows()
    assert len(rows) < 30
    np.testing.assert_allclose(rows[-1], [9.9, 0.099, 1.0, 0.5])
    assert len(others.tracks[9].rows()) == 0
