"""All robots at once, step by step: a plan, or the proof that there is none in this model.

- A configuration is a node for each robot. In a step each robot drives along one edge or rests; all
  begin together, and the next step begins when the last has arrived. No two discs ever come too
  near during it, in continuous time.
- Depth first over configurations, each with a tree of constraints (destinations of robots) that
  grows by one robot at a time: once it is used up, every step out of the configuration has been
  examined (Okumura, "LaCAM: search-based algorithm for quick multi-agent pathfinding", AAAI 2023).
- A step is filled in robot by robot, by priority; a robot in the path is asked to move first (PIBT;
  Okumura et al., Artificial Intelligence 310, 2022).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from planner.fleet.motions.interval_search_kernels import HORIZON, moves_along
from planner.fleet.motions.motion_kernels import do_steps_touch
from planner.fleet.search.team import Route, TeamRobot

ASKED_MOST = 400
"""Choices tried to fill in one step, ten a robot for 40; the constraints do the rest."""

Configuration = tuple[int, ...]
Constraint = tuple[tuple[int, int], ...]
Expired = Callable[[], bool]


@dataclass(slots=True)
class Visit:
    """A reached configuration, and the constraints left to try."""

    at: Configuration
    parent: Visit | None
    waits: tuple[int, ...]
    order: list[int]
    open: deque[Constraint] = field(default_factory=lambda: deque([()]))


class JointSearch:
    """A resumable search; ``steps`` holds the plan's configurations once found."""

    def __init__(self, robots: Sequence[TeamRobot], rng: np.random.Generator) -> None:
        self.robots = list(robots)
        self.rng = rng
        self.goal = tuple(robot.goal for robot in robots)
        start = tuple(robot.start for robot in robots)
        first = Visit(start, None, (0,) * len(robots), self._order((0,) * len(robots), start))
        self.seen = {start: first}
        self.stack = [first]
        self.steps: list[Configuration] = []
        self._kinds = self._kinds_of_robot()
        self._touches: dict[tuple[int, ...], bool] = {}
        self._choices: dict[tuple[int, int], list[tuple[int, float]]] = {}
        self._asked = 0

    @property
    def exhausted(self) -> bool:
        """True if everything was examined without a plan."""
        return not self.stack and not self.steps

    def run(self, rounds: int, expired: Expired) -> bool:
        """Examine at most this number of constraints; return True if there is a plan."""
        while rounds > 0 and self.stack and not self.steps and not expired():
            rounds -= 1
            visit = self.stack[-1]
            if visit.at == self.goal:
                self._trace(visit)
            elif not visit.open:
                self.stack.pop()
            else:
                self._try(visit)
        return bool(self.steps)

    def _try(self, visit: Visit) -> None:
        fixed = visit.open.popleft()
        if len(fixed) < len(self.robots):
            i = visit.order[len(fixed)]
            ends = [v for v, _ in self.ends(i, visit.at[i])]
            self.rng.shuffle(ends)
            for v in ends:
                if not any(self._touch(visit.at, i, v, j, w) for j, w in fixed):
                    visit.open.append((*fixed, (i, v)))
        new = self._fill_in(visit, fixed)
        if new is None:
            return
        known = self.seen.get(new)
        if known is None:
            waits = tuple(
                0 if new[i] == goal else visit.waits[i] + 1 for i, goal in enumerate(self.goal)
            )
            known = Visit(new, visit, waits, self._order(waits, new))
            self.seen[new] = known
            self.stack.append(known)
        elif known.open and known is not visit:
            self.stack.append(known)

    def _order(self, waits: Sequence[int], at: Configuration) -> list[int]:
        to_go = [robot.to_goal[n] for robot, n in zip(self.robots, at, strict=True)]
        return sorted(range(len(at)), key=lambda i: (-waits[i], -to_go[i]))

    def _fill_in(self, visit: Visit, fixed: Constraint) -> Configuration | None:
        ends = dict(fixed)
        self._asked = 0
        for i in visit.order:
            if i not in ends and not self._decide(i, visit.at, ends):
                return None
        return tuple(ends[i] for i in range(len(self.robots)))

    def _decide(self, i: int, at: Configuration, ends: dict[int, int]) -> bool:
        chance = self.rng.random(len(self.ends(i, at[i]))).tolist()
        choices = sorted(
            (to_go, tie, v) for (v, to_go), tie in zip(self.ends(i, at[i]), chance, strict=True)
        )
        for _, _, v in choices:
            self._asked += 1
            if self._asked > ASKED_MOST:
                return False
            if any(self._touch(at, i, v, j, w) for j, w in ends.items()):
                continue
            before = list(ends)
            ends[i] = v
            pushed = [
                j for j in range(len(at)) if j not in ends and self._touch(at, i, v, j, at[j])
            ]
            if all(j in ends or self._decide(j, at, ends) for j in pushed):
                return True
            for j in set(ends) - set(before):
                del ends[j]
        return False

    def ends(self, i: int, n: int) -> list[tuple[int, float]]:
        """Nodes that a robot can reach in a step, and the time to go from each."""
        key = (i, n)
        if key not in self._choices:
            graph, to_goal = self.robots[i].graph, self.robots[i].to_goal
            ends = {n, *graph.to[graph.starts[n] : graph.starts[n + 1]].tolist()}
            # from a node that cannot reach the goal, no step helps
            self._choices[key] = [
                (v, float(to_goal[v])) for v in sorted(ends) if to_goal[v] < HORIZON
            ]
        return self._choices[key]

    def _touch(self, at: Configuration, i: int, v: int, j: int, w: int) -> bool:
        key = (self._kinds[i], at[i], v, self._kinds[j], at[j], w)
        if key not in self._touches:
            gap = self.robots[i].radius + self.robots[j].radius
            one, other = self._motion(i, at[i], v), self._motion(j, at[j], w)
            self._touches[key] = bool(do_steps_touch(one, other, gap))
        return self._touches[key]

    def is_allowed(self, at: Configuration, then: Configuration) -> bool:
        """True if all robots can do these moves in one step."""
        return not any(
            self._touch(at, i, then[i], j, then[j])
            for i in range(len(at))
            for j in range(i + 1, len(at))
        )

    def _motion(self, i: int, u: int, v: int) -> tuple[float, float, float, float, float]:
        """(x, y, vx, vy, lasts) along an edge; at rest if both ends are one."""
        places = self.robots[i].graph.places
        x, y = places[u].tolist()
        lasts = self._lasts(i, u, v)
        if lasts <= 0.0:
            return x, y, 0.0, 0.0, 0.0
        vx, vy = ((places[v] - places[u]) / lasts).tolist()
        return x, y, vx, vy, lasts

    def _lasts(self, i: int, u: int, v: int) -> float:
        if u == v:
            return 0.0
        graph = self.robots[i].graph
        row = slice(graph.starts[u], graph.starts[u + 1])
        return float(graph.lasts[row][graph.to[row] == v].min())

    def _kinds_of_robot(self) -> list[int]:
        kinds: dict[tuple[int, float], int] = {}
        return [kinds.setdefault((id(r.graph.lasts), r.radius), len(kinds)) for r in self.robots]

    def _trace(self, visit: Visit) -> None:
        back: Visit | None = visit
        while back is not None:
            self.steps.append(back.at)
            back = back.parent
        self.steps.reverse()

    def routes(self) -> dict[int, Route]:
        """Route for each robot, each step begun when the last has ended."""
        begin = [0.0]
        for at, then in pairwise(self.steps):
            lasts = [self._lasts(i, u, v) for i, (u, v) in enumerate(zip(at, then, strict=True))]
            begin.append(begin[-1] + max(lasts))
        return {i: self._route(i, begin) for i in range(len(self.robots))}

    def _route(self, i: int, begin: list[float]) -> Route:
        way, arrivals, departures = [self.steps[0][i]], [0.0], []
        for k, (at, then) in enumerate(pairwise(self.steps)):
            if at[i] != then[i]:
                way.append(then[i])
                departures.append(begin[k])
                arrivals.append(begin[k] + self._lasts(i, at[i], then[i]))
        nodes, at_s = np.array(way, np.int64), np.array(arrivals)
        left_s = np.array(departures, np.float64)
        robot = self.robots[i]
        moves = moves_along(robot.graph.places, nodes, at_s, left_s, robot.radius)
        return Route(nodes, at_s, left_s, moves)
