"""Other robots: when ours goes, holds, or looks for a way around, against a simulated encounter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from navigation.mission.traffic import Mover, TrafficLimits, cut, discs_to_avoid, encounter

LIMITS = TrafficLimits(radius_m=0.1, speed_m_s=0.3, acceleration_m_s2=0.5, keep_m=0.03)
HERE = (0.0, 0.0)
EAST = np.array([(0.5, 0.0), (2.0, 0.0)])
NOWHERE = np.empty((0, 2))


def mover(x: float, y: float, vx: float = 0.0, vy: float = 0.0, age_s: float = 0.03) -> Mover:
    return Mover(8, x, y, vx, vy, 0.08, age_s)


def test_an_empty_road_is_clear() -> None:
    assert encounter(HERE, EAST, [], LIMITS) is None
    assert encounter(HERE, EAST, [mover(1.0, 0.5)], LIMITS) is None
    assert encounter(HERE, EAST, [mover(-0.5, 0.0)], LIMITS) is None


def test_a_robot_that_stands_on_the_way_asks_for_another_way() -> None:
    met = encounter(HERE, EAST, [mover(0.8, 0.1)], LIMITS)
    assert met is not None
    assert (met.id, met.stands) == (8, True)
    assert met.sentence == "robot 8 blocks the path: it leaves 0.000 m"


def test_a_robot_that_stands_far_along_the_way_is_none_of_ours_yet() -> None:
    assert encounter(HERE, EAST, [mover(1.5, 0.1)], LIMITS) is None


def test_a_robot_that_crosses_right_before_us_holds_ours() -> None:
    met = encounter(HERE, EAST, [mover(0.3, -0.3, 0.0, 0.3)], LIMITS)
    assert met is not None
    assert not met.stands
    assert met.sentence.startswith("robot 8 comes too near: it leaves ")


def test_a_robot_that_drives_away_is_let_go() -> None:
    assert encounter(HERE, EAST, [mover(0.5, 0.0, 0.4, 0.0)], LIMITS) is None
    assert encounter(HERE, EAST, [mover(-0.25, 0.0, -0.3, 0.0)], LIMITS) is None


def test_a_robot_that_comes_at_one_that_stands_is_told() -> None:
    assert encounter(HERE, NOWHERE, [mover(0.5, 0.0, -0.4, 0.0)], LIMITS) is not None
    assert encounter(HERE, NOWHERE, [mover(0.5, 0.0, 0.0, 0.4)], LIMITS) is None


def test_one_that_was_lost_from_view_is_taken_to_stand_where_it_was() -> None:
    met = encounter(HERE, EAST, [mover(0.8, 0.1, 0.0, 0.5, age_s=3.0)], LIMITS)
    assert met is not None
    assert met.stands


def test_two_robots_side_by_side_do_not_stand_for_ever() -> None:
    assert encounter(HERE, EAST, [mover(0.0, 0.185)], LIMITS) is None


def test_the_way_is_cut_at_its_length() -> None:
    assert cut(HERE, EAST, 0.7) == pytest.approx(np.array([(0, 0), (0.5, 0), (0.7, 0)]))
    assert cut(HERE, EAST, 9.0) == pytest.approx(np.array([(0, 0), (0.5, 0), (2.0, 0)]))
    assert cut(HERE, NOWHERE, 1.0) == pytest.approx(np.array([HERE]))


def test_a_plan_keeps_further_off_than_the_robot_holds() -> None:
    (disc,) = discs_to_avoid(HERE, [mover(0.8, 0.1)], LIMITS)
    assert (disc.x_m, disc.y_m, disc.robot_id, disc.moves) == (0.8, 0.1, 8, False)
    assert disc.radius_m > 0.08 + LIMITS.keep_m


def test_a_plan_keeps_clear_of_where_a_robot_is_and_of_where_it_will_be() -> None:
    (disc,) = discs_to_avoid(HERE, [mover(0.8, 0.5, 0.3, 0.0)], LIMITS)
    assert disc.moves
    for x in (0.8, 1.1):
        assert math.dist((disc.x_m, disc.y_m), (x, 0.5)) + 0.08 <= disc.radius_m


places = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
speeds = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


@given(place=places, speed=speeds)
def test_a_disc_to_avoid_never_holds_our_own_body(
    place: tuple[float, float], speed: tuple[float, float]
) -> None:
    for disc in discs_to_avoid(HERE, [mover(*place, *speed)], LIMITS):
        assert math.dist(HERE, (disc.x_m, disc.y_m)) > disc.radius_m + LIMITS.radius_m


@given(place=places, speed=speeds)
@example(place=(1.5, 0.0), speed=(-0.125, 0.0))
def test_ours_stands_before_a_robot_that_keeps_its_course_is_met(
    place: tuple[float, float], speed: tuple[float, float]
) -> None:
    """Drive along the way and look every 50 ms, braking when told; the bodies never touch while
    ours moves. The other one is a metre away or more in the beginning."""
    assume(math.hypot(*place) > 1.0)
    x, v, now_s, step_s = 0.0, LIMITS.speed_m_s, 0.0, 0.01
    pending: list[float] = []
    for tick in range(400):
        now_s = tick * step_s
        other = mover(place[0] + speed[0] * now_s, place[1] + speed[1] * now_s, *speed)
        ahead = EAST[EAST[:, 0] > x]
        if tick % 5 == 0 and encounter((x, 0.0), ahead, [other], LIMITS) is not None:
            pending.append(now_s + 0.1)
        if pending and now_s >= pending[0]:
            v = max(0.0, v - LIMITS.acceleration_m_s2 * step_s)
        if v == 0.0:
            return
        x += v * step_s
        assert math.dist((x, 0.0), (other.x_m, other.y_m)) > LIMITS.radius_m + 0.08
        if x > 1.5:
            return
