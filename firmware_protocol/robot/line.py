"""The line through the queued waypoints: where the robot is on it, and what lies ahead.

Whole numbers only, as in `follower`: lengths are counts of 64 um and end at 2 m, further than
any brake or look ahead; angles 2**16 a turn; speeds eighths of mm/s, those of waypoints mm/s.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Final, NamedTuple

from firmware_protocol.robot.pose_estimate import RobotPose
from firmware_protocol.wire.drive_settings import DriveConstants
from firmware_protocol.wire.fixed_point import (
    Place,
    aside,
    between,
    clip,
    measured,
    mrad,
    root,
    turned,
)
from firmware_protocol.wire.waypoint_record import Target


def length(micrometres: int) -> int:
    """A count of 64 um."""
    return micrometres // 64


TURN_ENTER: Final = mrad(800)
SHORT: Final = length(1_000)
"""A line shorter than this has no direction."""
NOWHERE: Final = length(128)
"""A line shorter than this is none."""
FAR: Final = 32_000
"""2 m; a length counts as no longer."""


class Sight(NamedTuple):
    """The way to the waypoint at the queue's head, and where the robot is on it."""

    leg: tuple[int, int]
    """Length and direction."""
    distance: int
    """Of the robot from the waypoint."""
    remaining: int
    """Along the leg; negative behind the waypoint."""
    beside: int
    """Beside the leg, or behind its beginning."""


def look(start: Place, pose: RobotPose, target: Target) -> Sight:
    """The way from the pose to a target, on the line that begins at ``start``."""
    leg = leg_between(start, target.place)
    distance, bearing = measured(*between(target.place, pose.place))
    if leg[0] < NOWHERE:
        return Sight(leg, clip(distance >> 4, FAR), 0, 0)
    x, y = turned(distance, 0, bearing - leg[1])
    remaining, beside = -clip(x >> 4, FAR), abs(clip(y >> 4, FAR))
    return Sight(leg, clip(distance >> 4, FAR), remaining, max(beside, remaining - leg[0]))


def walk(
    constants: DriveConstants,
    speed: int,
    start_mm_s: int,
    pose: RobotPose,
    targets: Sequence[Target],
    sight: Sight,
) -> tuple[tuple[int, int], int, int]:
    """Along the line ahead: the way to the pursued point, and what the waypoints allow: the
    square of the speed in mm/s, and the way to a stop, 0xFFFF where there is none yet.

    ``speed`` is the robot's, ``start_mm_s`` that of the line's start. Each waypoint allows its own
    speed plus what the brakes take back on the way there.
    """
    lookahead = constants.lookahead + (abs(speed) * constants.lookahead_ms >> 9)
    either = max(start_mm_s, targets[0].speed_mm_s)
    fast = constants.max_speed_mm_s
    # a line is driven at the speed of its faster end
    fast = min(fast, either) if either else fast
    square = fast * fast
    leg, ahead = sight.leg, max(0, sight.remaining)
    pursued: tuple[int, int] | None = None
    for index, target in enumerate(targets):
        corner, following = False, leg
        last = index + 1 >= len(targets) or target.flags != 0
        if not last:
            corner, following = next_leg(leg, target, targets[index + 1])
        last = last or corner
        allowed = braked(ahead, constants.brake_mm_s2)
        if pursued is None and (last or ahead >= lookahead):
            dx, dy = turned((lookahead - ahead) * 16, 0, leg[1])
            x, y = between(pose.place, target.place)
            pursued = x + dx, y + dy
        if pursued is not None and (last or allowed >= square):
            return pursued, min(allowed, square), ahead if last else 0xFFFF
        square = min(square, allowed + target.speed_mm_s * target.speed_mm_s)
        ahead = min(FAR, ahead + following[0])
        leg = following
    raise AssertionError("a line without an end")


@lru_cache(maxsize=4096)
def leg_between(start: Place, end: Place) -> tuple[int, int]:
    """Length and direction of the line from one place to another."""
    distance, direction = measured(*between(start, end))
    return clip(distance >> 4, FAR), direction


def next_leg(
    leg: tuple[int, int], target: Target, following: Target
) -> tuple[bool, tuple[int, int]]:
    """Whether the line bends at ``target`` too much to be driven, and the leg behind it.

    A short leg keeps the direction of the one before.
    """
    leg_length, direction = ahead = leg_between(target.place, following.place)
    if leg_length < SHORT:
        return False, (leg_length, leg[1])
    return leg[0] >= SHORT and aside(direction - leg[1]) > TURN_ENTER, ahead


def braked(distance: int, brake_mm_s2: int) -> int:
    """The square of the speed in mm/s that brakes take back within a distance.

    Brakes are believed to be 2 % weaker than they are, so that a thousand may be 1024.
    """
    return distance * brake_mm_s2 >> 4


def approach(square: int, distance: int) -> int:
    """The speed towards a stop, from the square of what the brakes allow.

    The square root alone would arrive with a jerk that slow motors cannot follow, so near the
    stop the speed is four times the distance left, a second.
    """
    speed = root(square) * 8
    return distance << 1 if distance < speed >> 1 else speed
