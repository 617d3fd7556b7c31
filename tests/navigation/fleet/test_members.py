"""Which places a robot keeps that does not take part, and when another one's body is in the way."""

import math

import numpy as np
import pytest

from navigation.fleet.members import Member, comes_too_near, places_kept
from navigation.fleet.releases import Held
from navigation.mission.mission import State
from planner.motion.trajectory import default_limits
from tests.navigation.fleet.test_releases import promise

RADIUS_M = 0.1


def member(
    pose: tuple[float, float, float] | None = (0.0, 0.0, 0.0), *, age_s: float = 0.0
) -> Member:
    return Member(
        state=State.DRIVING,
        pose=pose,
        pose_age_s=age_s,
        stands=True,
        radius_m=RADIUS_M,
        limits=default_limits(RADIUS_M),
        max_deviation_m=0.05,
        reach_m=0.3,
    )


def test_a_robot_that_is_seen_keeps_its_own_disc_and_no_more() -> None:
    (taken,) = places_kept("a", member((0.4, 0.2, 1.0)), Held(promise("a", 20)))
    assert (taken.name, taken.x_m, taken.y_m, taken.radius_m) == ("a", 0.4, 0.2, RADIUS_M)


def test_a_robot_that_was_never_seen_keeps_nothing_that_is_known() -> None:
    assert list(places_kept("a", member(None), None)) == []


@pytest.mark.parametrize("executed", [0, 3])
def test_one_that_is_lost_keeps_every_place_that_it_can_have_driven_to(executed: int) -> None:
    held = Held(promise("a", 20), executed=executed)
    x = 0.05 * executed
    taken = list(places_kept("a", member((x, 0.0, 0.0), age_s=1.0), held))
    for driven_m in np.linspace(0.0, 0.3, 31):
        place = (x + driven_m, 0.0)
        inside = [t.radius_m - math.dist((t.x_m, t.y_m), place) for t in taken]
        assert max(inside) >= RADIUS_M, f"the body at {place} is outside all that is kept"


def test_a_body_in_the_way_is_named_with_the_room_that_it_leaves() -> None:
    members = {"a": member(), "b": member((0.5, 0.02, 0.0))}
    way = np.array([(0.0, 0.0), (1.0, 0.0)])
    assert comes_too_near(way, "a", members) == "b is in the path: it leaves 0.000 m"


def test_a_body_beside_the_way_or_behind_is_no_reason_to_hold() -> None:
    way = np.array([(0.0, 0.0), (1.0, 0.0)])
    beside = {"a": member(), "b": member((0.5, 2 * RADIUS_M + 0.01, 0.0))}
    behind = {"a": member(), "b": member((-2 * RADIUS_M - 0.001, 0.0, 0.0))}
    assert comes_too_near(way, "a", beside) is None
    assert comes_too_near(way, "a", behind) is None
