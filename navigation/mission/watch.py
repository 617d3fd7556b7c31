"""Safety rules: conditions for the robot to move, each with the sentence of its failure.

`judge` looks at one cycle's facts and keeps nothing. Metres, seconds.

- hold: the cause may pass by itself (a hidden marker, a lost frame); driving then resumes with a
  new plan.
- stop: the world is not what the plan assumed; latched, and only a person re-arms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum


class Action(IntEnum):
    """Permitted action, ordered by severity."""

    GO = 0
    HOLD = 1
    STOP = 2


@dataclass(frozen=True, slots=True)
class SafetyLimits:
    """The rules' configuration."""

    pose_stale_s: float
    frame_stale_s: float
    link_stale_s: float
    max_deviation_m: float
    robot_radius_m: float
    clearance_slack_m: float
    """Tolerated shortfall of the measured clearance below the radius: the camera's uncertainty."""
    latency_s: float = 0.25
    """Highest age of pictures at arrival."""


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts of one control cycle; ages are infinite for things never seen.

    Texts are sentences for people; empty or None without a cause.
    """

    frame_age_s: float
    pose_age_s: float
    link_age_s: float
    link_down_reason: str | None
    robot_estopped: bool
    robot_disarmed: bool
    robot_idle_reason: str | None
    position_m: tuple[float, float] | None
    inside_arena: bool
    clearance_m: float | None
    deviation_m: float | None
    paused: bool
    robot_fault: str | None = None
    """A bumper, a cliff: the robot has stopped itself."""
    near_robot: str | None = None
    failed: str | None = None
    camera_reason: str = ""
    doubles: tuple[str, ...] = ()
    parted: str | None = None
    latency_s: float | None = None
    """Measured age of pictures at arrival; None while it does not matter."""
    partner: str | None = None
    scene_doubt: str | None = None


@dataclass(frozen=True, slots=True)
class Verdict:
    """The most severe action, and the sentences of all reasons."""

    action: Action
    reasons: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """All reasons in one line, most severe first; empty if the robot may move."""
        return "; ".join(self.reasons)


def judge(facts: Facts, limits: SafetyLimits) -> Verdict:
    """Decide if the robot may move in this cycle."""
    found = [
        *_camera(facts, limits),
        *_identity(facts, limits),
        *_link(facts, limits),
        *_place(facts, limits),
    ]
    holding = (facts.near_robot, facts.partner, facts.failed, facts.scene_doubt)
    found += [(Action.HOLD, text) for text in holding if text is not None]
    if facts.paused:
        found.append((Action.HOLD, "paused by the operator"))
    found.sort(key=lambda item: -item[0])
    action = found[0][0] if found else Action.GO
    return Verdict(action, tuple(text for _, text in found))


def _camera(facts: Facts, limits: SafetyLimits) -> list[tuple[Action, str]]:
    if facts.frame_age_s > limits.frame_stale_s:
        why = f" ({facts.camera_reason})" if facts.camera_reason else ""
        return [(Action.HOLD, f"no picture from the camera {_since(facts.frame_age_s)}{why}")]
    if facts.pose_age_s > limits.pose_stale_s:
        return [(Action.HOLD, f"the robot's marker was not seen {_since(facts.pose_age_s)}")]
    return []


def _identity(facts: Facts, limits: SafetyLimits) -> list[tuple[Action, str]]:
    found = [(Action.STOP, text) for text in facts.doubles]
    if facts.parted is not None:
        found.append((Action.HOLD, facts.parted))
    if facts.latency_s is not None and facts.latency_s > limits.latency_s:
        found.append(
            (
                Action.HOLD,
                f"the camera's pictures are {facts.latency_s:.2f} s old when they arrive: "
                f"the limit is {limits.latency_s:g} s",
            )
        )
    return found


def _link(facts: Facts, limits: SafetyLimits) -> list[tuple[Action, str]]:
    if facts.robot_estopped:
        why = f": {facts.robot_fault}" if facts.robot_fault is not None else ""
        return [(Action.STOP, f"the robot reports an emergency stop{why}")]
    if facts.link_down_reason is not None:
        return [(Action.HOLD, f"the link to the robot is down: {facts.link_down_reason}")]
    if facts.link_age_s > limits.link_stale_s:
        return [(Action.HOLD, f"the robot did not report {_since(facts.link_age_s)}")]
    if facts.robot_disarmed:
        return [(Action.HOLD, "the robot has disarmed itself: its lease lapsed")]
    if facts.robot_idle_reason is not None:
        return [(Action.HOLD, f"the robot stands still: {facts.robot_idle_reason}")]
    return []


def _place(facts: Facts, limits: SafetyLimits) -> list[tuple[Action, str]]:
    if facts.position_m is None:
        return []
    x, y = facts.position_m
    where = f"at ({x:.3f}, {y:.3f}) m"
    if not facts.inside_arena:
        return [(Action.STOP, f"the robot is outside the arena {where}")]
    least = limits.robot_radius_m - limits.clearance_slack_m
    if facts.clearance_m is not None and facts.clearance_m < least:
        return [
            (
                Action.STOP,
                f"the robot's clearance is {facts.clearance_m:.3f} m {where}: "
                f"must be at least {least:.3f} m",
            )
        ]
    if facts.deviation_m is not None and facts.deviation_m > limits.max_deviation_m:
        return [
            (
                Action.HOLD,
                f"the robot is {facts.deviation_m:.3f} m off its path {where}: "
                f"the limit is {limits.max_deviation_m:.3f} m",
            )
        ]
    return []


def _since(age_s: float) -> str:
    return "at all yet" if math.isinf(age_s) else f"for {age_s * 1e3:.0f} ms"
