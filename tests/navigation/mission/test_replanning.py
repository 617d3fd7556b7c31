"""A plan is made again for what makes it unsafe or too fast, and for nothing less."""

from dataclasses import replace

import pytest

from navigation.mission.replanning import later_pictures, nearer_obstacle, robot_ahead
from navigation.mission.traffic import Encounter
from tests.navigation.mission.world import SETTINGS

RADIUS_M = SETTINGS.limits.robot_radius_m
SLACK_M = SETTINGS.limits.clearance_slack_m
FAR_M = replace(SETTINGS, replan_distance_m=RADIUS_M + 0.2)


@pytest.mark.parametrize(
    ("clearance_m", "planned_m", "again"),
    [
        (RADIUS_M - 1e-6, RADIUS_M, True),  # it does not fit
        (RADIUS_M, RADIUS_M, False),
        (RADIUS_M + 0.1, RADIUS_M + 0.15, True),  # nearer than planned, and near
        (RADIUS_M + 0.15 - SLACK_M, RADIUS_M + 0.15, False),  # what the camera cannot tell apart
        (RADIUS_M + 0.25, RADIUS_M + 0.5, False),  # nearer than planned, and far
    ],
)
def test_an_obstacle_matters_where_the_robot_fits_no_more_or_it_came_near(
    clearance_m: float, planned_m: float, again: bool
) -> None:
    reason = nearer_obstacle(clearance_m, planned_m, FAR_M)
    assert (reason is not None) == again
    if reason is not None:
        assert f"{clearance_m:.3f} m of clearance" in reason


def test_later_pictures_matter_from_a_speed_that_is_worth_a_plan_on() -> None:
    assert later_pictures(0.31, 0.26, 0.3) is None
    assert "0.31 s old" in str(later_pictures(0.31, 0.25, 0.3))


def test_a_robot_is_driven_around_where_it_is_at_rest() -> None:
    assert robot_ahead(None) is None
    assert robot_ahead(Encounter(8, stands=False, sentence="robot 8 crosses")) is None
    assert robot_ahead(Encounter(8, stands=True, sentence="robot 8 is in the way")) == (
        "robot 8 is in the way: planning around it"
    )
