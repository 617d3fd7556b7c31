"""A new goal while eight drive: from the request to the first waypoint that may be sent.

    python -m benchmarks.fleet.joining [--goals 40]

Eight robots drive among the obstacles of ``configs/arenas/laboratory.txt``, each somewhere on its
promised path, and a ninth that stands asks for a path. Timed is what lies between: the
coordinator's cycle that makes the request, the fleet's planner, and the cycle that hands out the
answer with its released targets. Pictures, pilots and lines are not part of it: an answer wakes
the control loop, and the upload begins in that cycle. In ms by the wall's clock, and of the
processor, which counts on a busy machine.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from collections import Counter
from pathlib import Path
from typing import Final

import numpy as np

import planner
from navigation.fleet.coordinator import Coordinator
from navigation.fleet.joining import join_promises
from navigation.fleet.members import Member
from navigation.fleet.planning import plan_promises
from navigation.fleet.releases import Held
from navigation.fleet.request import FleetRequest, Traveller
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import State, Station
from planner.formats.scene_io import read_scene_text
from planner.motion.trajectory import default_limits
from planner.scene import Bounds, FloatArray, Scene

LABORATORY = Path(__file__).parents[2] / "configs" / "arenas" / "laboratory.txt"
BOUNDS = Bounds(0.0, 0.0, 2.4, 1.8)
RADIUS_M, KEEP_M, SPEED_M_S = 0.07, 0.03, 0.25
STARTS: Final = (
    (0.2, 0.2), (2.2, 0.2), (2.2, 1.6), (0.2, 1.6), (1.2, 0.18), (1.2, 1.62), (0.15, 0.9),
    (2.25, 0.9),
)  # fmt: skip
GOALS: Final = (
    (2.2, 1.6), (0.2, 1.6), (0.2, 0.2), (2.2, 0.2), (1.2, 1.62), (1.2, 0.18), (1.75, 0.6),
    (0.5, 0.75),
)  # fmt: skip
NINTH: Final = (1.2, 0.6)
WANTED_MS: Final = 100.0


def places(rng: np.random.Generator, roadmap: planner.Roadmap, count: int) -> FloatArray:
    """Goals in free space, clear of all starts and goals of the eight."""
    found: list[FloatArray] = []
    while len(found) < count:
        place = rng.uniform((0.1, 0.1), (2.3, 1.7))
        clear = roadmap.clearance(place[None])[0] > RADIUS_M + 0.02
        if clear and all(math.dist(place, other) > 2 * RADIUS_M + KEEP_M for other in GOALS):
            found.append(place)
    return np.array(found)


class Drive:
    """Eight that drive, each at a random place of its promise, and one that asks."""

    def __init__(self, roadmap: planner.Roadmap, scene: Scene, held: dict[str, Held]) -> None:
        self.roadmap, self.scene = roadmap, scene
        self.coordinator = Coordinator(lambda points: roadmap.path_clearance(points).distance)
        self.coordinator.held = held
        for name in held:
            self.coordinator.release(name)

    def ask(self, goal: FloatArray) -> tuple[float, float, str]:
        """Seconds by the wall's clock and of the processor; why there is no path, else empty."""
        members = {
            name: _member(State.DRIVING, tuple(one.promise.points[one.executed]), one.executed)
            for name, one in self.coordinator.held.items()
        }
        station = Station(*goal.tolist())
        request = PlanRequest(1, (*NINTH, 0.0), (station,), 1)
        members["ninth"] = _member(State.PLANNING, NINTH, None, request)
        began_s, worked_s = time.perf_counter(), time.process_time()
        asked = self.coordinator.step(1.0, members, 1, None)
        assert asked.request is not None
        answer = join_promises(self.roadmap, self.scene, asked.request, KEEP_M)
        orders = self.coordinator.step(1.05, members, 1, answer)
        release = self.coordinator.release("ninth")
        took_s, work_s = time.perf_counter() - began_s, time.process_time() - worked_s
        assert not orders.plan_again
        if answer.cannot:
            return took_s, work_s, f"all had to stop: {answer.cannot}"
        assert ("ninth" in orders.answers) is (release is not None)
        return took_s, work_s, answer.refused.get("ninth", "")


def _member(
    state: State,
    place: tuple[float, float],
    executed: int | None,
    request: PlanRequest | None = None,
) -> Member:
    return Member(
        state=state, pose=(*place, 0.0), pose_age_s=0.0, stands=state is State.PLANNING,
        radius_m=RADIUS_M, limits=default_limits(RADIUS_M), max_deviation_m=0.05, reach_m=0.1,
        executed=executed, request=request,
    )  # fmt: skip


def begin(roadmap: planner.Roadmap, scene: Scene) -> dict[str, Held]:
    """The promises of the eight, the ninth's place kept."""
    limits = default_limits(RADIUS_M)
    travellers = tuple(
        Traveller(f"r{i}", (*start, 0.0), Station(*goal), RADIUS_M, limits)
        for i, (start, goal) in enumerate(zip(STARTS, GOALS, strict=True))
    )
    ninth = Traveller("ninth", (*NINTH, 0.0), Station(*NINTH), RADIUS_M, limits)
    answer = plan_promises(roadmap, scene, FleetRequest(1, 1, (*travellers, ninth)), KEEP_M)
    return {name: Held(one) for name, one in answer.promises.items() if name != "ninth"}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--goals", type=int, default=40)
    goals = parser.parse_args().goals
    scene = read_scene_text(LABORATORY.read_text(), str(LABORATORY)).with_bounds(BOUNDS)
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    rng = np.random.default_rng(5)
    promises = {name: one.promise for name, one in begin(roadmap, scene).items()}
    took_ms, work_ms, whys = list[float](), list[float](), list[str]()
    for n, goal in enumerate(places(rng, roadmap, goals + 1)):
        held = {name: Held(one) for name, one in promises.items()}
        drive_together(held, rng.uniform(0.0, 0.7))
        took_s, work_s, why = Drive(roadmap, scene, held).ask(goal)
        if n == 0:
            continue  # kernels are loaded
        took_ms.append(1e3 * took_s)
        work_ms.append(1e3 * work_s)
        whys.append(why)
    print(f"{len(promises)} drive, {goals} new goals: {whys.count('')} with a path at once")
    for why, count in Counter(filter(None, whys)).most_common():
        print(f"  {count} x {why}")
    for what, ms in (("wall", took_ms), ("processor", work_ms)):
        print(
            f"request to first waypoint, {what}: median {statistics.median(ms):.0f} ms,"
            f" worst {max(ms):.0f} ms (wanted: {WANTED_MS:.0f} ms)"
        )


def drive_together(held: dict[str, Held], share: float) -> None:
    """Everybody as far as the order allows, up to this share of the longest promise."""
    steps = int(share * max(len(one.promise.targets) for one in held.values()))
    coordinator = Coordinator(lambda _points: None)
    coordinator.held = held
    for _ in range(steps):
        for name, one in held.items():
            release = coordinator.release(name)
            if release is not None and one.executed < min(
                release.targets, len(one.promise.targets) - 1
            ):
                one.executed += 1


if __name__ == "__main__":
    main()
