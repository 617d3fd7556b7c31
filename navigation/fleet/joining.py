"""New goals while others drive: promises for the robots that ask, more gates for the rest.

- Everything sent to a robot stays: it never has to wait earlier, and a driving robot's path never
  changes. Robots that ask pass behind what was sent. If none can be added, nothing changes.
- A robot waits for a driving one that would have to step aside until that has arrived; robots at
  rest without a mission step aside and come back.
- If the promises do not fit the arena, nothing can be added (`FleetAnswer.cannot`), and all are
  planned together.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from navigation.fleet.planning import (
    OVERLAP_M,
    PIECE_M,
    SLACK_M,
    Attempt,
    in_the_way,
    make_promise,
    point_numbers,
    rules_of,
)
from navigation.fleet.refusals import listed, with_names
from navigation.fleet.request import (
    Driving,
    FleetAnswer,
    FleetRequest,
    Gate,
    Promise,
    Traveller,
)
from navigation.fleet.rounding import CutTrack, rounded
from planner.borders.polyline import arc_lengths, distance_to_polyline
from planner.fleet.dependencies import find_dependencies, is_live
from planner.fleet.fleet_plan import Dependency, FleetPlan, NoFleetPlan
from planner.fleet.no_waiting import wait_before
from planner.fleet.schedule import FleetSchedule
from planner.motion.trajectory import TrajectoryError
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Scene
from planner.shared.search_clock import Clock, search_clock_s

TIME_LIMIT_S: Final = 1.0
"""For each goal, and once more for those refused, together. Meanwhile no robot gets more waypoints;
it usually has 2 m, or 8 s, and stops at their end. A shorter limit refuses some for good."""


class CannotJoinError(Exception):
    """Error: nothing can be added to the promises; the text says why."""


class _CannotDriveError(Exception):
    def __init__(self, one: Traveller, why: str) -> None:
        super().__init__(why)
        self.one = one


@dataclass(frozen=True, slots=True)
class _Party:
    driving: tuple[Driving, ...]
    asking: tuple[Traveller, ...]
    idle: tuple[Traveller, ...]
    attempt: Attempt
    """All of them, with what each search needs."""

    @property
    def standing(self) -> tuple[Traveller, ...]:
        return (*self.asking, *self.idle)

    @property
    def names(self) -> list[str]:
        return [one.promise.name for one in self.driving] + [one.name for one in self.standing]

    @property
    def offsets(self) -> list[int]:
        """Target at which each new track begins."""
        return [one.executed for one in self.driving] + [0] * len(self.standing)


def join_promises(
    roadmap: Roadmap,
    scene: Scene,
    request: FleetRequest,
    keep_m: float,
    clock: Clock = search_clock_s,
) -> FleetAnswer:
    """Make promises for robots that ask, and gates for driving ones.

    ``roadmap`` is the smallest robot's in ``scene``; ``clock`` limits each search.
    """
    taken, out = request.taken, dict[str, str]()
    while True:
        asking, idle = (
            tuple(one for one in standing if one.name not in out)
            for standing in (request.travellers, request.idle)
        )
        everybody = (*(one.as_traveller for one in request.driving), *asking, *idle)
        attempt = Attempt(roadmap, scene, everybody, taken, keep_m, clock)
        try:
            answer = _join(_Party(request.driving, asking, idle, attempt), request)
        except CannotJoinError as error:
            return FleetAnswer(request.id, request.scene_revision, {}, {}, cannot=str(error))
        except _CannotDriveError as error:  # it stays in place, and the others are tried again
            one = error.one
            out[one.name] = str(error)
            taken = (*taken, one.as_taken)
            continue
        asked = {one.name for one in request.travellers}
        refused = {name: why for name, why in out.items() if name in asked}
        return replace(answer, refused={**answer.refused, **refused})


def _join(party: _Party, request: FleetRequest) -> FleetAnswer:
    here = party.attempt.around_taken()
    sizes = _sizes(here, party)
    first = len(party.driving)
    schedule, refused = _with_goals(_promised(here, party, sizes), party)
    if not any(one.name not in refused for one in party.asking):
        return FleetAnswer(request.id, request.scene_revision, {}, refused)
    tracks, waits = _in_pieces(here, schedule, party, sizes)
    numbers = [point_numbers(track.targets) for track in tracks]
    gates = _gates(party, numbers, waits)
    promises: dict[str, Promise] = {}
    for k, one in enumerate(party.standing, first):
        if one.name in refused or (len(numbers[k]) < 2 and k >= first + len(party.asking)):
            continue  # an idle robot that need not move
        try:
            margin_m = sizes[k] - one.radius_m
            promises[one.name] = make_promise(here, one, tracks[k], gates[k], margin_m)
        except TrajectoryError as error:
            raise _CannotDriveError(one, str(error)) from error
    coming = {*promises, *(one.promise.name for one in party.driving)}
    missing = {gate.other for rows in gates for gate in rows} - coming
    if missing:
        raise CannotJoinError(f"{listed(sorted(missing))} would be waited for, and has no path")
    return FleetAnswer(
        request.id,
        request.scene_revision,
        promises,
        refused,
        driving=tuple(
            # the next order gets no more room than this one
            replace(one.promise, gates=tuple(gates[j]), margin_m=sizes[j] - one.promise.radius_m)
            for j, one in enumerate(party.driving)
        ),
    )


def _with_goals(schedule: FleetSchedule, party: _Party) -> tuple[FleetSchedule, dict[str, str]]:
    """Add the goals of robots that ask, one by one, then failed ones together.

    Return the schedule and each refusal's reason.
    """
    first, names = len(party.driving), party.names
    goals = {k: (one.station.x, one.station.y) for k, one in enumerate(party.asking, first)}
    sent = [one.sent - one.executed for one in party.driving] + [0] * len(party.standing)
    refused: dict[int, NoFleetPlan] = {}
    may_move = {*range(first + len(party.asking), len(names))}
    for k, goal in goals.items():
        found = _with_goals_at_once(schedule, {k: goal}, sent, party, {*may_move, k})
        if isinstance(found, NoFleetPlan):
            refused[k] = found
        else:
            may_move.add(k)
            schedule, sent = found, list(found.sent)
    together = {k: goals[k] for k, why in refused.items() if why.blocking != (k,)}
    if len(together) > 1:
        found = _with_goals_at_once(schedule, together, sent, party, {*may_move, *together})
        if isinstance(found, FleetSchedule):
            schedule = found
            refused = {k: why for k, why in refused.items() if k not in together}
    alone = {
        k: in_the_way(replace(party.attempt, moving=(party.asking[k - first],)))
        for k in refused.keys() - together.keys()
    }
    return schedule, {
        names[k]: with_names(why.reason, names) + alone.get(k, "") for k, why in refused.items()
    }


def _with_goals_at_once(
    schedule: FleetSchedule,
    goals: Mapping[int, tuple[float, float]],
    sent: Sequence[int],
    party: _Party,
    may_move: Container[int],
) -> FleetSchedule | NoFleetPlan:
    """Add goals at once, if no robot outside ``may_move`` has to step aside."""
    try:
        found = schedule.with_goals(
            goals, sent=sent, time_limit_s=TIME_LIMIT_S, clock=party.attempt.clock
        )
    except ValueError as error:
        raise CannotJoinError(str(error)) from error
    if isinstance(found, NoFleetPlan):
        return found
    aside = tuple(i for i in found.changed if i not in may_move)
    if not aside:
        return found
    has = "have" if len(aside) > 1 else "has"
    who = listed([party.names[i] for i in aside])
    return NoFleetPlan(f"the path is free once {who} {has} arrived", aside, proved=False)


def _promised(here: Roadmap, party: _Party, sizes: Sequence[float]) -> FleetSchedule:
    """Present promises as the planner's schedule; time zero is now."""
    names, offsets = party.names, party.offsets
    tracks = [_timed(one) for one in party.driving]
    tracks += [np.array([[0.0, *one.start[:2]]]) for one in party.standing]
    waits = []
    for j, one in enumerate(party.driving):
        for gate in one.promise.gates:
            if gate.other not in names[: len(party.driving)]:
                continue  # it has arrived, or asks for another path
            i = names.index(gate.other)
            passed, row = gate.passed - offsets[i], gate.before - offsets[j]
            if passed > 0:
                waits.append((i, passed, j, max(row, 0)))
    plan = FleetPlan(tuple(tracks), tuple(waits), 0.0, 0.0)
    try:
        return FleetSchedule.of(
            here,
            plan,
            list(sizes),
            [one.limits for one in party.attempt.moving],
            [one.zones for one in party.attempt.moving],
        )
    except ValueError as error:
        raise CannotJoinError(str(error)) from error


def _timed(one: Driving) -> FloatArray:
    points = one.promise.points[one.executed :]
    return np.column_stack([arc_lengths(points) / one.limits.speed, points])


def _sizes(here: Roadmap, party: _Party) -> list[float]:
    """Radii with their promised margins, or with what fits."""
    sizes = []
    for one in party.driving:
        rest = np.ascontiguousarray(one.promise.points[one.executed :])
        room_m = float(here.clearance(rest).min())
        if len(rest) > 1:
            room_m = min(room_m, here.path_clearance(rest).distance)
        radius_m = one.promise.radius_m
        if room_m < radius_m - OVERLAP_M:
            raise CannotJoinError(f"the path of {one.promise.name} is not free any more")
        sizes.append(min(radius_m + one.promise.margin_m, room_m))
    margins = [_margin_m(here, one, party, sizes) for one in party.standing]
    more = [one.radius_m + m for one, m in zip(party.standing, margins, strict=True)]
    return [*sizes, *more]


def _margin_m(here: Roadmap, one: Traveller, party: _Party, sizes: Sequence[float]) -> float:
    ends = np.array([one.start[:2], (one.station.x, one.station.y)])
    room_m = float(here.clearance(ends).min()) - one.radius_m - SLACK_M
    margin_m = min(0.5 * party.attempt.keep_m, room_m)
    for driving, size in zip(party.driving, sizes, strict=False):
        rest = driving.promise.points[driving.executed :]
        past_m = distance_to_polyline(rest, one.start[:2]) - size - one.radius_m
        if past_m < -OVERLAP_M:  # it should be gone by then, and has another goal now
            raise CannotJoinError(f"{one.name} is in the path of {driving.promise.name}")
        end_m = math.dist(rest[-1], ends[1]) - size - one.radius_m
        margin_m = min(margin_m, past_m - SLACK_M, end_m - SLACK_M)
    for other in party.standing:
        if other is not one:
            apart_m = math.dist(other.start[:2], one.start[:2]) - other.radius_m - one.radius_m
            margin_m = min(margin_m, 0.5 * apart_m - SLACK_M)
    return max(margin_m, -OVERLAP_M)


def _in_pieces(
    here: Roadmap, schedule: FleetSchedule, party: _Party, sizes: Sequence[float]
) -> tuple[list[CutTrack], Sequence[Dependency]]:
    """Cut new tracks into short pieces if the order still takes back nothing sent.

    Corners are rounded for robots that cannot turn at them.
    """
    plan, everybody, first = schedule.plan, party.attempt.moving, len(party.driving)
    rules = rules_of(here, [one.zones for one in everybody], sizes)
    whole = [CutTrack.whole(track) for track in plan.tracks]
    pieces = [*whole[:first], *(CutTrack.of(track, PIECE_M) for track in plan.tracks[first:])]
    bends = {
        k: one.limits.turning_radius
        for k, one in enumerate(everybody)
        if k >= first and not one.limits.turns_on_spot
    }
    round_all = (rounded(here, pieces, sizes, PIECE_M, bends, rules), pieces)
    for cut in round_all if bends else (pieces,):
        tracks = [one.targets for one in cut]
        waits = wait_before(tracks, find_dependencies(tracks, sizes), rules)
        takes_back = any(row < schedule.sent[j] for _, _, j, row in waits)
        if not takes_back and is_live(tracks, waits):
            return cut, waits
    tracks = [one.targets for one in whole]
    if wait_before(tracks, plan.dependencies, rules) != list(plan.dependencies):
        raise CannotJoinError("a robot would wait in a no-waiting zone")
    return whole, plan.dependencies


def _gates(
    party: _Party, numbers: Sequence[FloatArray], waits: Sequence[Dependency]
) -> list[list[Gate]]:
    names, offsets = party.names, party.offsets
    for one, number in zip(party.driving, numbers, strict=False):
        if int(number[-1]) != len(one.promise.points) - 1 - one.executed:
            raise CannotJoinError(f"the targets of {one.promise.name} would change")
    gates: list[list[Gate]] = [[] for _ in names]
    for i, passed, j, row in waits:
        if row < len(numbers[j]) and numbers[j][row] < numbers[j][-1]:
            before = offsets[j] + int(numbers[j][row])
            done = offsets[i] + int(numbers[i][min(passed, len(numbers[i]) - 1)])
            gates[j].append(Gate(before, names[i], done))
    for j, one in enumerate(party.driving):
        if any(gate.before < one.sent for gate in gates[j]):
            raise CannotJoinError(f"{one.promise.name} would have to wait before what it was sent")
    return gates
