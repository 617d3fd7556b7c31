"""Random arenas that can be crossed, and the configuration of a run through each."""

from __future__ import annotations

import math

import numpy as np

import planner
from navigation.config import Config
from navigation.simulator.arena import SimulatedArena
from planner.formats.scene_io import read_scene_text
from planner.path import NoPath
from planner.scene import Bounds
from tests.support.runs.virtual import short_config

SIZE_M = (2.4, 1.8)
RADIUS_M = 0.09
ROOM_M = 0.03
"""Start, goal and the way between them have this much more than the radius."""
APART_M = 0.04
WHEEL_ERROR = 0.03


def random_config(seed: int) -> Config:
    """A run through a random arena: wrong wheels, slip, a noisy camera."""
    rng = np.random.default_rng(seed)
    while True:
        text = _arena_text(rng)
        start, goal = (_place(rng) for _ in range(2))
        if math.dist(start, goal) > 1.2 and _can_be_crossed(text, start, goal):
            break
    left, right = rng.uniform(-WHEEL_ERROR, WHEEL_ERROR, 2)
    return short_config(
        camera={"rate_hz": 30.0},
        stations=[
            {"x_m": goal[0], "y_m": goal[1], "heading_deg": float(rng.uniform(-180.0, 180.0))}
        ],
        simulation={
            "seed": seed,
            "arena": None,
            "arena_text": text,
            "start": {
                "x_m": start[0],
                "y_m": start[1],
                "heading_deg": float(rng.uniform(-180.0, 180.0)),
            },
            "robot": {
                "wheel_radius_error": (float(left), float(right)),
                "track_error": float(rng.uniform(-0.01, 0.01)),
                "slip": 0.02,
            },
        },
    )


def _place(rng: np.random.Generator) -> tuple[float, float]:
    edge = RADIUS_M + ROOM_M
    x, y = rng.uniform(edge, SIZE_M[0] - edge), rng.uniform(edge, SIZE_M[1] - edge)
    return round(float(x), 3), round(float(y), 3)


def _arena_text(rng: np.random.Generator) -> str:
    """3 to 9 circles and polygons, none of which touches another."""
    placed: list[tuple[float, float, float]] = []
    lines = ["#@ clearway.scene/1", "#@ units m"]
    for number in range(int(rng.integers(3, 10))):
        r = float(rng.uniform(0.06, 0.22))
        for _ in range(100):
            x, y = float(rng.uniform(r, SIZE_M[0] - r)), float(rng.uniform(r, SIZE_M[1] - r))
            if all(math.dist((x, y), (u, v)) > r + s + APART_M for u, v, s in placed):
                placed.append((x, y, r))
                lines += [f"#@ object {number}", _record(rng, x, y, r)]
                break
    return "\n".join(lines) + "\n"


def _record(rng: np.random.Generator, x: float, y: float, r: float) -> str:
    if rng.random() < 0.3:
        return f"C ({x:.4f},{y:.4f}) {r:.4f}"
    count = int(rng.integers(3, 8))
    turns = -(np.arange(count) + rng.uniform(-0.25, 0.25, count)) * math.tau / count
    reach = rng.uniform(0.6, 1.0, count) * r
    corners = " ".join(
        f"({x + d * math.cos(t):.4f},{y + d * math.sin(t):.4f})"
        for d, t in zip(reach, turns, strict=True)
    )
    return f"L {count} {corners}"


def _can_be_crossed(text: str, start: tuple[float, float], goal: tuple[float, float]) -> bool:
    bounds = Bounds(0.0, 0.0, *SIZE_M)
    arena = SimulatedArena(read_scene_text(text, "random").with_bounds(bounds))
    if arena.clearances([start, goal]).min() < RADIUS_M + ROOM_M:
        return False
    roadmap = planner.build_roadmap(arena.scene, RADIUS_M)
    return not isinstance(roadmap.plan(start, goal, margin=ROOM_M), NoPath)
