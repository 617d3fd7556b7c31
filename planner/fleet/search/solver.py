"""Plans for all robots: one after the other, failing robots push others out; then shortened.

- Each robot is planned optimally among the moves of those already planned (prioritised planning;
  Silver, "Cooperative pathfinding", AIIDE 2005).
- A robot without a path removes as few planned robots as it can, those pushed out most often last;
  they are planned again after it (MAPF-LNS2; Li et al., AAAI 2022).
- Shortening plans a few robots again in another order (large neighbourhood search; Li et al.,
  "Anytime multi-agent path finding via large neighborhood search", IJCAI 2021).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from planner.fleet.motions.interval_search_kernels import HORIZON, do_touch, find_way, moves_along
from planner.fleet.search.team import Route, TeamRobot
from planner.scene import FloatArray

TAKEN_OUT = (2, 8)
"""Robots taken out at once: Li et al. 2021 found 8 best; fewer are quicker."""
SAME_TIME = 1e-9
"""Sums of times that differ by less are equal."""
NO_MOVES = np.empty((0, 7))

Expired = Callable[[], bool]


class Solver:
    """Routes of a fleet during the search."""

    def __init__(self, robots: Sequence[TeamRobot], rng: np.random.Generator) -> None:
        self.robots = list(robots)
        self.rng = rng
        self.routes: dict[int, Route] = {}
        self.pushed = np.zeros(len(self.robots), np.int64)
        self._alone: dict[int, Route] = {}

    @property
    def flowtime_s(self) -> float:
        """Sum of all planned arrivals."""
        return sum(route.arrival_s for route in self.routes.values())

    def plan_one(
        self, i: int, others: Sequence[int], latest_s: float = HORIZON, trail_s: float = 0.0
    ) -> Route | None:
        """Best route of one robot among the others' routes; None if there is none.

        The others also occupy their places of ``trail_s`` earlier.
        """
        robot = self.robots[i]
        if others:
            moves = np.concatenate([self.routes[j].moves for j in others])
            moves[:, 6] += robot.radius
            if trail_s > 0.0:
                later = moves.copy()
                later[:, 4] += trail_s
                moves = np.concatenate([moves, later])
        else:
            moves = NO_MOVES
        way, arrivals, departures = find_way(
            robot.graph, robot.to_goal, robot.start, robot.goal, moves, latest_s
        )
        if not len(way):
            return None
        rows = moves_along(robot.graph.places, way, arrivals, departures, robot.radius)
        return Route(way, arrivals, departures, rows)

    def plan_all(self, expired: Expired, tries: int) -> bool:
        """Plan all, the longest path first, in at most ``tries`` calls of the search."""
        queue = sorted(range(len(self.robots)), key=lambda i: -self.robots[i].alone_s)
        self.routes.clear()
        while queue:
            if expired() or tries <= 0:
                return False
            i = queue.pop(0)
            tries -= 1
            route = self.plan_one(i, list(self.routes))
            if route is None:
                self.pushed[i] += 1
                route, calls = self._push_in(i)
                tries -= calls
                out = [j for j in self.routes if self._touch(i, route, j)]
                for j in out:
                    del self.routes[j]
                self.rng.shuffle(out)
                # the first pushed out comes first again: no robot waits for ever
                queue.extend(sorted(out, key=lambda j: -self.robots[j].alone_s))
            self.routes[i] = route
        return True

    def _push_in(self, i: int) -> tuple[Route, int]:
        chance = self.rng.random(len(self.robots))
        keep = sorted(self.routes, key=lambda j: -self.pushed[j] - 2.0 * chance[j])
        low, high, calls = 0, len(keep), 0
        best = self.alone(i)
        while high - low > 1:
            middle = (low + high) // 2
            route = self.plan_one(i, keep[:middle])
            calls += 1
            if route is None:
                high = middle
            else:
                low, best = middle, route
        return best, calls

    def alone(self, i: int) -> Route:
        """Route of a robot without others."""
        if i not in self._alone:
            route = self.plan_one(i, ())
            if route is None:
                raise ValueError(f"robot {i}: no path even alone")
            self._alone[i] = route
        return self._alone[i]

    def _touch(self, i: int, route: Route, j: int) -> bool:
        gap = self.robots[i].radius + self.robots[j].radius
        return bool(do_touch(route.moves, self.routes[j].moves, gap))

    def can_pass(self, i: int, j: int, node: int) -> bool:
        """True if a robot has a path while another stays at a node for ever."""
        one, other = self.robots[i], self.robots[j]
        x, y = other.graph.places[node].tolist()
        standing = np.array([[x, y, 0.0, 0.0, 0.0, HORIZON, one.radius + other.radius]])
        way, _, _ = find_way(one.graph, one.to_goal, one.start, one.goal, standing, HORIZON)
        return len(way) > 0

    def shorten_each(self) -> None:
        """Plan each robot again among all others if that is quicker."""
        for i in sorted(self.routes, key=lambda i: self.robots[i].alone_s):
            others = [j for j in self.routes if j != i]
            route = self.plan_one(i, others, self.routes[i].arrival_s - SAME_TIME)
            if route is not None:
                self.routes[i] = route

    def improve(self, rounds: int, expired: Expired) -> int:
        """Shorten the sum of arrivals; return the number of rounds made."""
        for done in range(rounds):
            delay = self._delays()
            if delay.sum() <= SAME_TIME or expired():
                return done
            self._replan(self._neighbourhood(delay))
        return rounds

    def _delays(self) -> FloatArray:
        return np.array(
            [self.routes[i].arrival_s - r.alone_s for i, r in enumerate(self.robots)]
        ).clip(0.0)

    def _neighbourhood(self, delay: FloatArray) -> list[int]:
        count = len(self.robots)
        late = int(self.rng.choice(count, p=delay / delay.sum()))
        size = min(int(self.rng.integers(TAKEN_OUT[0], TAKEN_OUT[1] + 1)), count)
        others = [int(j) for j in self.rng.permutation(count) if j != late]
        # both with equal chance
        if self.rng.random() < 0.5:
            route = self.alone(late)
            others.sort(key=lambda j: not self._touch(late, route, j))
        chosen = [late, *others[: size - 1]]
        self.rng.shuffle(chosen)
        return chosen

    def _replan(self, chosen: list[int]) -> None:
        """Plan the chosen again in this order, unless that is no better."""
        old = {i: self.routes[i] for i in chosen}
        left = sum(route.arrival_s for route in old.values()) - SAME_TIME
        left -= sum(self.robots[i].alone_s for i in chosen)
        done = [j for j in self.routes if j not in old]
        for i in chosen:
            route = self.plan_one(i, done, self.robots[i].alone_s + left)
            if route is None:
                self.routes.update(old)
                return
            left -= route.arrival_s - self.robots[i].alone_s
            self.routes[i] = route
            done.append(i)
