"""Time from a zone's drawing to the new plan: the planner's thread as it runs beside the loop."""

from __future__ import annotations

import queue
import time
from pathlib import Path
from typing import Final

import numpy as np

from navigation.config import load_config
from navigation.loop.planning import ArenaPlanner, PlannerThread, SceneCheck
from navigation.loop.stages import plan_settings
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Station
from navigation.simulator.arena import load_arena
from planner.path import Path as PlannedPath
from planner.scene import Bounds, Scene
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone

CONFIG: Final = Path(__file__).parents[2] / "configs" / "simulation.yaml"
PATIENCE_S: Final = 10.0


def drawn_to_planned_s(scene: Scene, ends: tuple[float, ...], count: int, seed: int) -> list[float]:
    """Seconds (count,) from a keep-out zone on the path to the answer of a plan around it.

    ``ends`` are x, y of the start and of the goal. Each time all earlier zones are there too, up to
    ten of them. The first zone is not counted: a run loads the kernels before it begins.
    """
    rng = np.random.default_rng(seed)
    answers: queue.SimpleQueue[PlanAnswer | SceneCheck] = queue.SimpleQueue()
    thread = PlannerThread(ArenaPlanner(plan_settings(load_config(CONFIG, {}))), answers.put,
                           answers.put)  # fmt: skip
    thread.start()
    start, goal = (ends[0], ends[1], 0.0), Station(ends[2], ends[3])
    taken: list[float] = []
    zones: list[Zone] = []
    revision = 1
    try:
        thread.see(scene, revision, None, ())
        answers.get(timeout=PATIENCE_S)
        while len(taken) <= count:
            thread.ask(PlanRequest(revision, start, (goal,), revision))
            now = answers.get(timeout=PATIENCE_S)
            assert isinstance(now, PlanAnswer)
            if not isinstance(now.path, PlannedPath) or len(zones) == 10:
                zones = []
            else:
                x, y = now.path.points[int(rng.integers(len(now.path.points)))].tolist()
                zones = [*zones, Zone(str(revision), "keep_out", CircleArea((x, y), 0.03))]
            revision += 1
            begun_s = time.perf_counter()
            thread.see(scene, revision, None, tuple(zones))
            answers.get(timeout=PATIENCE_S)
            thread.ask(PlanRequest(revision, start, (goal,), revision))
            answers.get(timeout=PATIENCE_S)
            if zones:
                taken.append(time.perf_counter() - begun_s)
    finally:
        thread.stop()
    return taken[1:]


def laboratory() -> Scene:
    """Return the arena of ``configs/simulation.yaml``."""
    return load_arena(load_config(CONFIG, {})).scene


def crowded(seed: int) -> Scene:
    """Return an arena of 8 x 6 m with a hundred round obstacles."""
    rng = np.random.default_rng(seed)
    discs: list[tuple[float, float, float]] = []
    while len(discs) < 100:
        x, y = rng.uniform((0.6, 0.6), (7.4, 5.4))
        if all(np.hypot(x - u, y - v) > 0.4 for u, v, _ in discs):
            discs.append((float(x), float(y), float(rng.uniform(0.03, 0.1))))
    return Scene.from_polygons([], discs, bounds=Bounds(0.0, 0.0, 8.0, 6.0), units="m")
