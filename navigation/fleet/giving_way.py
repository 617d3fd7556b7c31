"""Clearing the path of a runaway: which robots hold, drive on, or drive aside.

- A robot drives on if that stays clear of every runaway for `HORIZON_S`; otherwise it holds if
  standing still does. Otherwise it leaves its promise and drives aside on a straight line: the
  shortest of the clear ones, or the clearest.
- Before a runaway that is only possible, robots hold, but none leaves its path.
- Lines aside keep to ground that the roadmap knows to be free and no zone forbids, at the usual
  distance from other robots and from all that these were sent, or no nearer than now.
- Without a better line, the robot drives on only if that touches no runaway and is no worse than
  standing still.
- While one drives aside no robot is sent more than it has, and none is planned.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from navigation.fleet.members import NEARER_M, SEEN_S, TOUCH_M, Member
from navigation.fleet.orders import TrafficOrders, ahead
from navigation.fleet.releases import Held
from navigation.fleet.runaways import Runaway
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import State, Station
from navigation.mission.targets import STEERED_RAD, Target
from planner.borders.polyline import arc_lengths, length_of
from planner.path import Path
from planner.scene import FloatArray
from planner.zones.rules import Rules

HORIZON_S: Final = 4.0
"""Foresight of a runaway: to stop, turn and drive a diameter aside takes 3 s."""
STEPS: Final = 40
BEGINS_S: Final = 0.25
"""From the picture to wheels that turn: two cycles, the line, and the camera."""
HEADINGS: Final = 24
LENGTHS_M: Final = np.linspace(0.05, 0.6, 12)
STEERS_RAD: Final = 0.3
"""Largest turn that a robot drives without a stop."""
PIECE_M: Final = 0.05
CERTAIN_M: Final = 0.01
"""Kept from walls beyond the radius by a robot that drives aside: the camera's error."""
ASK_AGAIN_S: Final = 0.5

Clearance = Callable[[FloatArray], float | None]
RulesOf = Callable[[str], Rules | None]
"""A robot's zones by its name; None before the first scene."""


def no_rules(_robot: str) -> Rules | None:
    """Return None: no zones are known."""
    return None


@dataclass(slots=True)
class Aside:
    """A line aside, and the request answered."""

    points: FloatArray
    request_id: int
    targets: int


class GivingWay:
    """Robots that drive aside."""

    def __init__(self, clearance_m: Clearance, rules: RulesOf = no_rules) -> None:
        self.aside: dict[str, Aside] = {}
        self._clearance_m, self._rules = clearance_m, rules
        self._asked_s: dict[str, float] = {}

    def step(
        self,
        now_s: float,
        members: Mapping[str, Member],
        held: Mapping[str, Held],
        asking: Mapping[str, PlanRequest],
        runaways: Sequence[Runaway],
    ) -> TrafficOrders:
        """Run one cycle by the rules above; ``asking`` are the open requests."""
        for name, driven in list(self.aside.items()):
            one = members[name]
            asks = name in asking and asking[name].id != driven.request_id
            if asks or one.state not in (State.DRIVING, State.PLANNING):
                del self.aside[name]
        if not runaways:
            return TrafficOrders()
        again: list[tuple[str, str]] = []
        answers: dict[str, PlanAnswer] = {}
        errands: dict[str, Station] = {}
        holds: dict[str, str] = {}
        for name, one in members.items():
            others = [other for other in runaways if other.name != name]
            if name in self.aside or len(others) < len(runaways) or not _can_move(one):
                continue
            assert one.pose is not None
            way = ahead(held, name, one.pose) if name in held else np.array([one.pose[:2]])
            stands = _least_gap(one, _standing(one), others)
            drives = stands
            if one.state in (State.DRIVING, State.HOLDING):
                drives = _least_gap(one, _driving_on(one, way), others)
            if drives.gap_m >= one.keep_m:
                continue
            certain = any(other.certain for other in others)
            if stands.gap_m >= one.keep_m or (not certain and stands.gap_m > drives.gap_m):
                holds[name] = drives.sentence
                continue
            if not certain:
                continue
            goes_on = one.state is State.DRIVING and drives.gap_m >= max(TOUCH_M, stands.gap_m)
            better_m = max(stands.gap_m, drives.gap_m) if goes_on else stands.gap_m
            line = self._line_aside(name, members, held, others, better_m)
            if line is None:
                if not goes_on:
                    holds[name] = stands.sentence
            elif name in asking:
                answers[name] = self._answer(name, one, asking[name], line)
            elif now_s - self._asked_s.get(name, -math.inf) > ASK_AGAIN_S:
                self._asked_s[name] = now_s
                if one.obliging:
                    errands[name] = Station(*one.pose)
                else:
                    again.append((name, f"{stands.sentence}: driving aside"))
        return TrafficOrders(tuple(again), answers=answers, errands=errands, holds=holds)

    def _line_aside(
        self,
        name: str,
        members: Mapping[str, Member],
        held: Mapping[str, Held],
        runaways: Sequence[Runaway],
        stays_m: float,
    ) -> FloatArray | None:
        """Points (n, 2) of the path aside; None if none is better than rest."""
        one = members[name]
        lines, tracks, cost = _lines(one)
        gaps = np.array([_least_gap(one, track, runaways).gap_m for track in tracks])
        enough_m = 2.0 * one.keep_m
        known = [
            (other, self._sent_to(who, other, held))
            for who, other in members.items()
            if who != name and other.pose is not None
            and all(who != runs.name for runs in runaways)
        ]  # fmt: skip
        for k in np.lexsort([cost, -np.minimum(gaps, enough_m)]):
            if gaps[k] < max(TOUCH_M, stays_m + NEARER_M):
                return None
            line: FloatArray = lines[k]
            rules = self._rules(name)
            if rules is not None and not rules.permits(line, one.radius_m):
                continue
            if rules is not None and rules.breach(line) is not None:  # as the driven line is judged
                continue
            fast = np.full(len(line), one.limits.speed)  # as it was judged to get away in time
            if rules is not None and rules.too_fast(line, fast) is not None:
                continue
            if self._is_free(one, line, known):
                return line
        return None

    def _sent_to(self, name: str, one: Member, held: Mapping[str, Held]) -> FloatArray:
        assert one.pose is not None
        here = np.array([one.pose[:2]])
        if name in self.aside:
            return np.vstack([here, self.aside[name].points])
        if name not in held or held[name].broken:
            return here
        mine = held[name]
        return np.vstack([here, mine.promise.points[mine.executed + 1 : mine.sent + 1]])

    def _is_free(
        self, one: Member, line: FloatArray, known: Sequence[tuple[Member, FloatArray]]
    ) -> bool:
        clearance_m = self._clearance_m(line)
        if clearance_m is None or clearance_m < one.radius_m + CERTAIN_M:
            return False
        for other, way in known:
            bodies_m = one.radius_m + other.radius_m
            now_m = _apart(line[:1], way) - bodies_m
            if _apart(line, way) - bodies_m < min(one.keep_m, now_m - NEARER_M):
                return False
        return True

    def _answer(self, name: str, one: Member, request: PlanRequest, line: FloatArray) -> PlanAnswer:
        points = line.copy()
        clearance_m = self._clearance_m(points) or 0.0
        clearances = np.full(len(points), clearance_m)
        for array in (points, clearances):
            array.flags.writeable = False
        first, last = points[0].tolist(), points[-1].tolist()
        path = Path(
            points=points,
            clearances=clearances,
            length=length_of(points),
            min_clearance=clearance_m,
            min_clearance_at=(first[0], first[1]),
            robot_radius=one.radius_m,
            stations=(0, len(points) - 1),
            headings_rad=(None, None),
        )
        speed = one.limits_at(request).speed
        targets = [Target(x, y, speed, False) for x, y in points[1:-1].tolist()]
        targets.append(Target(last[0], last[1], 0.0, True))
        self.aside[name] = Aside(points, request.id, len(targets))
        return PlanAnswer(request.id, request.scene_revision, path, None, tuple(targets))


@dataclass(frozen=True, slots=True)
class _Gap:
    gap_m: float
    name: str

    @property
    def sentence(self) -> str:
        return f"{self.name} runs away and comes near: it leaves {max(self.gap_m, 0.0):.3f} m"


def _can_move(one: Member) -> bool:
    if one.pose is None or one.pose_age_s > SEEN_S:
        return False
    return one.obliging or one.state in (State.DRIVING, State.HOLDING, State.PLANNING)


def _times() -> FloatArray:
    return np.linspace(0.0, HORIZON_S, STEPS)


def _least_gap(one: Member, track: FloatArray, runaways: Sequence[Runaway]) -> _Gap:
    """Least gap to a runaway on a track (STEPS, 2) of places at `_times`."""
    least = _Gap(math.inf, "")
    for other in runaways:
        apart = np.hypot(*(other.places(_times()) - track).T)
        gap_m = float(apart.min()) - one.radius_m - other.radius_m
        if gap_m < least.gap_m:
            least = _Gap(gap_m, other.name)
    return least


def _standing(one: Member) -> FloatArray:
    assert one.pose is not None
    speed = _speed(one)
    t = np.minimum(_times(), BEGINS_S + speed / one.limits.acceleration)
    gone = speed * t - 0.5 * one.limits.acceleration * np.maximum(t - BEGINS_S, 0.0) ** 2
    x, y, heading = one.pose
    return np.column_stack([x + gone * math.cos(heading), y + gone * math.sin(heading)])


def _driving_on(one: Member, way: FloatArray) -> FloatArray:
    """Positions along its path (n >= 1, 2), driven as fast as it can."""
    along = arc_lengths(way)
    gone = _gone(np.array([along[-1]]), np.zeros(1), _speed(one), one)[0]
    return np.column_stack([np.interp(gone, along, way[:, k]) for k in range(2)])


def _lines(one: Member) -> tuple[list[FloatArray], FloatArray, FloatArray]:
    """Straight lines aside in pieces; positions on each at `_times`; duration of each.

    A moving robot first brakes for a line to the side.
    """
    assert one.pose is not None
    x, y, heading = one.pose
    speed = _speed(one)
    headings = np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False)
    if not one.limits.turns_on_spot:
        headings = headings[np.abs(headings) <= STEERED_RAD]
    turns = np.repeat(headings, len(LENGTHS_M))
    lengths = np.tile(LENGTHS_M, len(headings))
    brakes_m = BEGINS_S * speed + 0.5 * speed**2 / one.limits.acceleration
    first_m = np.where(np.abs(turns) > STEERS_RAD, brakes_m, 0.0)
    here = x + 1j * y
    corner = here + first_m * np.exp(1j * heading)
    end = corner + lengths * np.exp(1j * (heading + turns))
    gone = _gone(first_m + lengths, turns, speed, one)
    on_first = np.minimum(gone, first_m[:, None])
    at = (
        here
        + on_first * np.exp(1j * heading)
        + (gone - on_first) * np.exp(1j * (heading + turns))[:, None]
    )
    lines = [_cut_in_pieces(np.array([here, c, e])) for c, e in zip(corner, end, strict=True)]
    turn_s = np.abs(turns) / one.limits.angular_rate_rad_s
    return lines, np.stack([at.real, at.imag], axis=-1), lengths / one.limits.speed + turn_s


def _cut_in_pieces(corners: FloatArray) -> FloatArray:
    points = [corners[:1]]
    for a, b in pairwise(corners):
        parts = math.ceil(abs(b - a) / PIECE_M - 1e-9)
        points.append(a + (b - a) * np.arange(1, parts + 1) / max(parts, 1))
    places = np.concatenate(points)
    return np.ascontiguousarray(np.column_stack([places.real, places.imag]))


def _gone(lengths_m: FloatArray, turns: FloatArray, speed: float, one: Member) -> FloatArray:
    """Distances (n, STEPS) covered at `_times` on paths of these lengths, with a turn."""
    limits = one.limits
    sharp = np.abs(turns) > STEERS_RAD
    rate = limits.angular_rate_rad_s
    turn_s = np.abs(turns) / rate + rate / limits.angular_acceleration_rad_s2
    goes_s = BEGINS_S + np.where(sharp, speed / limits.acceleration + turn_s, 0.0)
    step_s = HORIZON_S / (STEPS - 1)
    gone, v = np.zeros((len(lengths_m), STEPS)), np.full(len(lengths_m), speed)
    most = limits.acceleration * step_s
    for k in range(1, STEPS):
        left = np.maximum(lengths_m - gone[:, k - 1], 0.0)
        wanted = np.minimum(limits.speed, np.sqrt(2.0 * limits.acceleration * left))
        t = k * step_s
        wanted = np.where(t < BEGINS_S, v, np.where(t < goes_s, np.where(sharp, 0.0, v), wanted))
        v = np.clip(wanted, v - most, v + most)
        gone[:, k] = np.minimum(gone[:, k - 1] + v * step_s, lengths_m)
    return gone


def _speed(one: Member) -> float:
    return min(math.hypot(*one.velocity[:2]), one.limits.speed)


def _apart(line: FloatArray, way: FloatArray) -> float:
    places = np.concatenate([way, 0.5 * (way[1:] + way[:-1])])
    return float(np.hypot(*(line[:, None] - places[None]).T).min())
