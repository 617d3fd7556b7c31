"""The safety rules: each fact that must hold, taken away one at a time."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.mission.watch import Action, Facts, SafetyLimits, judge

LIMITS = SafetyLimits(
    pose_stale_s=0.2,
    frame_stale_s=0.2,
    link_stale_s=0.3,
    max_deviation_m=0.05,
    robot_radius_m=0.1,
    clearance_slack_m=0.01,
)
WELL = Facts(
    frame_age_s=0.03,
    pose_age_s=0.04,
    link_age_s=0.05,
    link_down_reason=None,
    robot_estopped=False,
    robot_disarmed=False,
    robot_idle_reason=None,
    position_m=(1.0, 1.0),
    inside_arena=True,
    clearance_m=0.3,
    deviation_m=0.004,
    paused=False,
)


def test_a_lost_picture_is_told_with_the_camera_s_own_words() -> None:
    lost = replace(WELL, frame_age_s=1.0, camera_reason="camera 0: unplugged; trying again in 2 s")
    said = "no picture from the camera for 1000 ms (camera 0: unplugged; trying again in 2 s)"
    assert judge(lost, LIMITS).sentence == said


def test_a_robot_with_nothing_wrong_may_go() -> None:
    verdict = judge(WELL, LIMITS)
    assert (verdict.action, verdict.sentence) == (Action.GO, "")


@pytest.mark.parametrize(
    ("changed", "action", "words"),
    [
        ({"frame_age_s": 0.21}, Action.HOLD, "no picture from the camera for 210 ms"),
        ({"frame_age_s": math.inf}, Action.HOLD, "no picture from the camera at all yet"),
        ({"pose_age_s": 0.201}, Action.HOLD, "marker was not seen for 201 ms"),
        ({"link_age_s": 0.4}, Action.HOLD, "did not report for 400 ms"),
        ({"link_down_reason": "the port vanished"}, Action.HOLD, "down: the port vanished"),
        ({"robot_disarmed": True}, Action.HOLD, "its lease lapsed"),
        (
            {"robot_idle_reason": "its queue ran dry"},
            Action.HOLD,
            "stands still: its queue ran dry",
        ),
        ({"paused": True}, Action.HOLD, "paused by the operator"),
        ({"deviation_m": 0.06}, Action.HOLD, "0.060 m off its path"),
        ({"robot_estopped": True}, Action.STOP, "reports an emergency stop"),
        ({"inside_arena": False}, Action.STOP, "outside the arena at (1.000, 1.000) m"),
        ({"clearance_m": 0.08}, Action.STOP, "clearance is 0.080 m"),
    ],
)
def test_each_broken_rule_holds_or_stops_and_says_why(
    changed: dict[str, object], action: Action, words: str
) -> None:
    verdict = judge(replace(WELL, **changed), LIMITS)  # type: ignore[arg-type]
    assert verdict.action is action
    assert words in verdict.sentence


def test_the_most_severe_reason_comes_first() -> None:
    verdict = judge(replace(WELL, paused=True, inside_arena=False), LIMITS)
    assert verdict.action is Action.STOP
    assert verdict.reasons[0].startswith("the robot is outside")
    assert len(verdict.reasons) == 2


ages = st.floats(0.0, 10.0) | st.just(math.inf)


@given(frame=ages, pose=ages, link=ages, clearance=st.floats(-1.0, 1.0), off=st.floats(0.0, 1.0))
def test_going_needs_every_number_within_its_limit(
    frame: float, pose: float, link: float, clearance: float, off: float
) -> None:
    facts = replace(
        WELL,
        frame_age_s=frame,
        pose_age_s=pose,
        link_age_s=link,
        clearance_m=clearance,
        deviation_m=off,
    )
    fine = frame <= 0.2 and pose <= 0.2 and link <= 0.3 and clearance >= 0.09 and off <= 0.05
    # the radius less the slack is not exactly 0.09 in binary
    assert abs(clearance - 0.09) < 1e-12 or (judge(facts, LIMITS).action is Action.GO) == fine


def test_a_robot_that_stopped_itself_says_what_it_feels() -> None:
    felt = replace(WELL, robot_estopped=True, robot_fault="iRobot Create 2: its bumper is pressed")
    verdict = judge(felt, LIMITS)
    assert verdict.action is Action.STOP
    assert verdict.sentence == (
        "the robot reports an emergency stop: iRobot Create 2: its bumper is pressed"
    )
