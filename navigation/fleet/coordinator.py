"""Order of driving: new goals join driving robots, each of which follows the common order.

- A robot that asks for a path and is still on its promise continues there.
- Any other is planned against the promises of driving robots, which drive on; until the planner
  answers they are sent no more than they have.
- If that fails, or a robot waits at a gate for one that will not come (stopped, failed, refused, or
  held for too long, `gate_waits`), driving robots stop under control, and once all are at rest, one
  plan is made for every robot that wants to move.
- Other robots keep their places, an unseen one everything that it may have driven to since. A robot
  without a mission may have to step aside and come back.
- A refused robot waits until the reasons change. A plan of all waits for refused robots that hold,
  until they ask again: two robots on each other's goals have paths together, but none one by one.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np

from navigation.fleet.asking import request_of
from navigation.fleet.gate_waits import GOING, GateWaits
from navigation.fleet.giving_way import GivingWay, RulesOf, no_rules
from navigation.fleet.members import Member, comes_too_near, line_kept, why_nobody_moves
from navigation.fleet.orders import (
    ON_TRACK_M,
    TrafficOrders,
    ahead,
    holds_of,
    is_seen_there,
    waits_of,
)
from navigation.fleet.refusals import Refusals
from navigation.fleet.releases import Held, Release, breach_of_rest, release_of
from navigation.fleet.request import Driving, FleetAnswer, FleetRequest
from navigation.fleet.runaways import Runaway, runaways_of
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.late_pictures import WORTH_A_PLAN
from navigation.mission.mission import State, Station
from navigation.mission.targets import within_caps
from planner.borders.polyline import distance_to_polyline
from planner.path import NoPath
from planner.scene import FloatArray

ASK_S: Final = 0.6
"""A robot that has to plan again asks within this time, or takes no part."""
REFUSED_S: Final = 1.5
"""The same after a refusal: pilots ask again after a second."""
AHEAD: Final = 40
"""Targets that a robot has beyond the one it drives to: 2 m, a second's upload."""
SLACK_M: Final = 0.01
"""Tolerated shortfall of a path's clearance below the radius: the camera's error."""
OVER: Final = (State.FAILED, State.STOPPED, State.IDLE)

Clearance = Callable[[FloatArray], float | None]


class Coordinator:
    """The promises, and the fleet's state between two plans."""

    def __init__(self, clearance_m: Clearance, rules: RulesOf = no_rules) -> None:
        self.held: dict[str, Held] = {}
        self._left: dict[str, Held] = {}
        """An unseen robot may be driving one of these."""
        self._lines: dict[str, Held] = {}
        """An unseen robot may be on its line aside."""
        self.rounds = 0
        """Plans requested."""
        self._clearance_m, self._rules = clearance_m, rules
        self._open: dict[str, PlanRequest] = {}
        self._gathering_s: float | None = None
        self._why = ""
        self._asked: FleetRequest | None = None
        self._asked_ids: dict[str, int] = {}
        self._refusals = Refusals()
        self._gate_waits = GateWaits()
        self._runaways: list[Runaway] = []
        self._giving_way = GivingWay(clearance_m, rules)

    def step(
        self,
        now_s: float,
        members: Mapping[str, Member],
        revision: int,
        answer: FleetAnswer | None,
        zones_since: int = 0,
    ) -> TrafficOrders:
        """Run one cycle by the rules above; the zones hold since revision ``zones_since``."""
        self._follow(members)
        answers: dict[str, PlanAnswer] = {}
        errands: dict[str, Station] = {}
        if answer is not None and self._asked is not None and answer.id == self._asked.id:
            answers |= self._take(now_s, answer, members, zones_since)
            errands = {n: one.promise.station for n, one in self.held.items() if one.errand}
        astray = any(one.at_large for one in members.values())
        self._runaways = [] if astray else runaways_of(members, self.held)
        aside = self._giving_way.step(now_s, members, self.held, self._open, self._runaways)
        for name in (*aside.errands, *aside.answers, *(name for name, _ in aside.plan_again)):
            self.forget(name)
        self._lines |= {name: line_kept(name, one) for name, one in aside.answers.items()}
        answers |= aside.answers
        errands |= aside.errands
        plan_again: tuple[tuple[str, str], ...] = aside.plan_again
        request = None
        if self._giving_way.aside:
            pass  # its line is not promised: the others wait until it asks
        elif self._gathering_s is None and self._asked is None:
            if not astray:
                answers |= self._continued(members, revision)
            if self._begin_round(now_s, members, revision, answers):
                request, refusals = self._joining(members, revision, answers)
                answers |= refusals
        elif self._gathering_s is not None:
            plan_again += tuple(
                (name, self._why)
                for name, one in members.items()
                if one.state is State.DRIVING
                # a robot at its end has no new path to its own place without a turn on the spot
                and (one.limits.turns_on_spot or self._drives(name, one))
            )
            if not plan_again:
                request, refusals = self._gathered(now_s, members, revision)
                answers |= refusals
        for name in answers:
            self._open.pop(name, None)
        refused = {
            name: why
            for name, why in self._refusals.reasons.items()
            if name in self._open and name not in answers and self._gathering_s is None
        }
        waits, waits_for = waits_of(
            members, self.held, refused, self._giving_way.aside, self._asked
        )
        lines = {name: one.points[1:] for name, one in self._giving_way.aside.items()}
        runaways = [one.name for one in self._runaways]
        holds = holds_of(members, self.held, lines, runaways) | dict(aside.holds)
        return TrafficOrders(plan_again, request, answers, waits, waits_for, holds, errands)

    def forget(self, name: str) -> None:
        """Void a robot's promise: all are planned again."""
        if name in self.held:
            self.held[name].broken = True

    def release(self, name: str) -> Release | None:
        """Targets of the present plan that may be sent; None without a promise."""
        if name in self._giving_way.aside:
            return Release(self._giving_way.aside[name].targets, None)
        held = self.held.get(name)
        if held is None:
            return None
        count, gate = release_of(name, self.held)
        if self._giving_way.aside or (self._asked is not None and self._asked.driving):
            count = min(count, held.sent)
        else:
            count = min(count, held.executed + AHEAD)
        held.sent = max(held.sent, count)
        return Release(max(0, count - held.base), gate)

    # Promises.

    def _follow(self, members: Mapping[str, Member]) -> None:
        for name, one in members.items():
            if one.request is not None:
                self._open[name] = one.request
            if name in self._open and one.state is not State.PLANNING:
                del self._open[name]
            held = self.held.get(name)
            if held is None or name in self._giving_way.aside:
                continue
            if held.errand and one.obliging:
                continue  # its pilot is given the errand in this cycle
            held.errand = False
            targets = len(held.promise.targets)
            if one.state is State.DONE and is_seen_there(one, held.promise, targets):
                held.executed = targets
            elif one.state in (*OVER, State.DONE):
                held.broken = not held.is_finished
            elif one.executed is not None and one.state is State.DRIVING:
                executed = held.base + one.executed
                if executed > held.executed and is_seen_there(one, held.promise, executed):
                    held.executed = executed
        asked = self._asked_ids.items()
        if not any(name in self._open and self._open[name].id == number for name, number in asked):
            self._asked = None  # no robot asks for it; a failed planner never answers

    def _continued(self, members: Mapping[str, Member], revision: int) -> dict[str, PlanAnswer]:
        answers = {}
        for name, request in self._open.items():
            held = self.held.get(name)
            if held is None or held.broken or held.is_finished:
                continue
            if request.scene_revision != revision or not self._fits(held, request):
                continue
            if comes_too_near(ahead(self.held, name, request.start), name, members) is not None:
                continue
            held.base = held.executed
            promise, rules = held.promise, self._rules(name)
            left = promise.targets[held.base :]
            if rules is not None:  # it begins at rest, and the first of these may be a stop
                left = within_caps(request.start[:2], left, rules)
            answers[name] = PlanAnswer(request.id, revision, promise.path, promise.trajectory, left)
        return answers

    def _fits(self, held: Held, request: PlanRequest) -> bool:
        promise, here = held.promise, request.start[:2]
        if not request.stations or request.stations[0] != promise.station:
            return False
        fastest = max(target.speed_m_s for target in promise.targets[held.executed :])
        if request.speed_m_s is not None and request.speed_m_s < WORTH_A_PLAN * fastest:
            return False
        around = promise.points[max(0, held.executed - 1) : held.executed + 2]
        if distance_to_polyline(around, here) > ON_TRACK_M:
            return False
        rest = np.vstack([here, promise.points[held.executed + 1 :]])
        clearance_m = self._clearance_m(rest)
        if clearance_m is None or clearance_m < promise.radius_m - SLACK_M:
            return False
        rules = self._rules(promise.name)
        return rules is None or breach_of_rest(rest, promise, held.executed, rules) is None

    def breach(self, name: str) -> str | None:
        """Sentence on a zone's rule that the rest of a promise breaks, its waits included."""
        held, rules = self.held.get(name), self._rules(name)
        if held is None or held.broken or held.is_finished or rules is None:
            return None
        rest = held.promise.points[held.executed :]
        return breach_of_rest(rest, held.promise, held.executed, rules)

    # A plan for all.

    def _begin_round(
        self,
        now_s: float,
        members: Mapping[str, Member],
        revision: int,
        answers: dict[str, PlanAnswer],
    ) -> bool:
        """True if robots are to join driving ones; otherwise gathers all if needed."""
        at_rest = self._at_rest(members)
        refused = self._refusals.reasons
        if not self._refusals.still_hold(members, self._open, revision, at_rest):
            refused = {}
        drives = any(self._drives(name, one) for name, one in members.items())
        joins = False
        for name, request in self._open.items():
            if name in answers:
                continue
            if name not in refused:
                if drives:
                    joins = True
                    continue
                self._gather(now_s, f"planning together with {name}")
                return False
            if not drives:
                answers[name] = PlanAnswer(request.id, revision, NoPath(refused[name]))
        out = self._refusals.reasons.keys() & self._open.keys()
        in_vain = self._gate_waits.in_vain(now_s, members, self.held, out)
        if in_vain is not None:
            self._gather(now_s, in_vain)
            return False
        return joins

    def _gather(self, now_s: float, why: str) -> None:
        self._why, self._gathering_s = why, now_s

    def _gathered(
        self, now_s: float, members: Mapping[str, Member], revision: int
    ) -> tuple[FleetRequest | None, dict[str, PlanAnswer]]:
        assert self._gathering_s is not None
        late = now_s - self._gathering_s > ASK_S
        for name, one in members.items():
            if not one.stands:
                return None, {}
            if one.state is State.PLANNING and name not in self._open and not late:
                return None, {}
            if name in self._open and one.pose is None:
                return None, {}
        soon = now_s - self._gathering_s <= REFUSED_S
        if soon and self._refusals.will_ask(members, self._open):
            return None, {}
        self._gathering_s = None
        if not self._open:
            return None, {}
        return self._ask(members, revision, list(self._open), ())

    def _joining(
        self, members: Mapping[str, Member], revision: int, answers: Mapping[str, PlanAnswer]
    ) -> tuple[FleetRequest | None, dict[str, PlanAnswer]]:
        asking = [name for name in self._open if name not in answers]
        if not all(members[name].stands for name in asking):
            return None, {}
        ready = [name for name in asking if members[name].pose is not None]
        driving = tuple(
            Driving(held.promise, held.executed, max(held.sent, held.executed), one.limits)
            for name, one in members.items()
            if name not in ready and (held := self.held.get(name)) is not None
            and not (held.is_finished or held.broken or held.errand)
            and one.state in (*GOING, State.HOLDING)
        )  # fmt: skip
        if not ready or not driving or any(held.errand for held in self.held.values()):
            return None, {}
        return self._ask(members, revision, ready, driving)

    def _ask(
        self,
        members: Mapping[str, Member],
        revision: int,
        asking: Sequence[str],
        driving: tuple[Driving, ...],
    ) -> tuple[FleetRequest | None, dict[str, PlanAnswer]]:
        wishes = {name: self._open[name] for name in asking}
        why = why_nobody_moves(members)
        if why is not None:
            self._refusals.refuse(wishes, why)
            return None, {
                name: PlanAnswer(request.id, revision, NoPath(why))
                for name, request in wishes.items()
            }
        self.rounds += 1
        self._asked = request_of(
            self.rounds, revision, members, self._left | self.held | self._lines,
            wishes, driving,
            self._runaways,
        )  # fmt: skip
        self._asked_ids = {name: request.id for name, request in wishes.items()}
        self._refusals.ask(wishes, revision, self._at_rest(members))
        return self._asked, {}

    def _take(
        self, now_s: float, answer: FleetAnswer, members: Mapping[str, Member], zones_since: int
    ) -> dict[str, PlanAnswer]:
        assert self._asked is not None
        asked, self._asked = self._asked, None
        if answer.scene_revision < zones_since:
            return {}  # other zones: robots that ask will ask again
        starts = {one.name: one.start for one in (*asked.travellers, *asked.idle)}
        if answer.cannot:
            self._gather(now_s, f"planning together with {asked.travellers[0].name}")
            return {}
        if any(self._left_its_promise(one) for one in asked.driving):
            return {}  # its plan is out of date: robots that ask will ask again
        moved = [
            one.name for one in asked.idle
            if one.name in answer.promises and not members[one.name].obliging
        ]  # fmt: skip
        if moved:
            return {}
        new = {
            name: Held(promise, errand=name not in self._asked_ids)
            for name, promise in answer.promises.items()
        }
        if asked.driving:
            for promise in answer.driving:
                self.held[promise.name].promise = promise
            for name in self._asked_ids if new else ():
                self.forget(name)  # the others' order assumes it where it asked
            self.held |= new
        else:
            self._left |= self.held
            self.held = new
        for name in new:
            self._left.pop(name, None)
            self._lines.pop(name, None)
        self._refusals.take(answer.refused)
        answers = {}
        for name, request_id in self._asked_ids.items():
            request = self._open.get(name)
            if request is None or request.id != request_id or name not in new:
                continue  # it holds, or has another mission: it asks again
            pose = members[name].pose
            if pose is None or math.dist(pose[:2], starts[name][:2]) > ON_TRACK_M:
                continue
            promise = new[name].promise
            answers[name] = PlanAnswer(
                request.id, answer.scene_revision, promise.path, promise.trajectory, promise.targets
            )
        return answers

    def _left_its_promise(self, one: Driving) -> bool:
        held = self.held.get(one.promise.name)
        return held is None or held.promise is not one.promise or held.broken

    def _at_rest(self, members: Mapping[str, Member]) -> dict[str, tuple[float, float]]:
        return {
            name: one.pose[:2]
            for name, one in members.items()
            if one.pose is not None and not self._drives(name, one)
        }

    def _drives(self, name: str, one: Member) -> bool:
        """True if it is on its promise and asks for no other path."""
        held = self.held.get(name)
        if held is None or held.is_finished or held.broken or name in self._open:
            return False
        return one.state in GOING
