"""Random runs among zones, in virtual time and without pictures."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from benchmarks.zones.judge import REACTS_S, Violation, violations
from navigation.config import Config, load_config
from navigation.config.several.each_robot import robots_of, settled
from navigation.config.zones import ZoneSection
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualWorld
from navigation.simulator.arena import load_arena

CONFIG: Final = Path(__file__).parents[2] / "configs" / "fleet.yaml"
KINDS: Final = ("keep_out", "slow", "one_way", "lane", "wait")


@dataclass(frozen=True, slots=True)
class JudgedRun:
    """One run: how many robots reached their goals, and what they violated."""

    seed: int
    robots: int
    arrived: int
    zones: tuple[ZoneSection, ...]
    violations: tuple[Violation, ...]
    ended: str


def judged_run(seed: int) -> JudgedRun:
    """Drive a random run to its end and judge it."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 7))
    free = _free_places(rng, 2 * count)
    drawn = _zones(rng, [f"r{i}" for i in range(count)] if count > 1 else [])
    later = [zone for zone in drawn if rng.random() < 0.4]
    config = settled(_config(rng, count, free, [zone for zone in drawn if zone not in later]))
    when = {zone.name: float(rng.uniform(1.0, 6.0)) for zone in later}
    since: dict[str, float] = {}

    def look(daemon: Daemon, now: RunState) -> bool:
        for zone in later:
            if zone.name not in since and now.time_s >= when[zone.name]:
                daemon.zones.put(zone)
                since[zone.name] = daemon.world.clock()
        return False

    worlds: list[VirtualWorld] = []

    def make(*args: Any, **how: Any) -> VirtualWorld:
        worlds.append(VirtualWorld(*args, **how))
        return worlds[0]

    report = run_virtually(config, look=look, pictures=False, make_world=make)
    found: list[Violation] = []
    arrived = 0
    truths = worlds[0].truths
    for name, one in robots_of(config).items():
        track = truths[name].track()
        goal = one.mission.stations[-1]
        arrived += math.dist(track[-1, 1:3], (goal.x_m, goal.y_m)) < 0.02
        for zone in drawn:
            if zone in later and zone.name not in since:
                continue
            begins_s = since[zone.name] + REACTS_S if zone in later else -math.inf
            drawn_s = [at for other, at in since.items() if other != zone.name]
            found += violations(zone, name, one.robot.radius_m, track, begins_s, drawn_s)
    return JudgedRun(seed, count, arrived, drawn, tuple(found), report.reason)


def _free_places(rng: np.random.Generator, count: int) -> list[tuple[float, float]]:
    config = load_config(CONFIG, {})
    assert config.simulation is not None
    arena = load_arena(config)
    places: list[tuple[float, float]] = []
    while len(places) < count:
        x, y = float(rng.uniform(0.15, 2.25)), float(rng.uniform(0.15, 1.65))
        apart = all(math.dist((x, y), other) > 0.25 for other in places)
        if apart and arena.track_clearance(np.array([[x, y]]))[0] > 0.11:
            places.append((x, y))
    return places


def _config(
    rng: np.random.Generator,
    count: int,
    free: list[tuple[float, float]],
    zones: list[ZoneSection],
) -> Config:
    base = load_config(CONFIG, {}).model_dump()
    names = [f"r{i}" for i in range(count)]
    base["robots"] = [
        {"name": name, "marker_id": i, "port": "simulated"} for i, name in enumerate(names)
    ]
    base["mission"]["robots"] = [
        {"name": name, "stations": [{"x_m": x, "y_m": y}]}
        for name, (x, y) in zip(names, free[count:], strict=True)
    ]
    base["simulation"].update(
        seed=int(rng.integers(1 << 31)),
        time_limit_s=60.0,
        starts=[
            {"name": name, "x_m": x, "y_m": y, "heading_deg": float(rng.uniform(-180.0, 180.0))}
            for name, (x, y) in zip(names, free[:count], strict=True)
        ],
    )
    base["safety"]["give_up_s"] = 8.0
    base["zones"] = [zone.model_dump() for zone in zones]
    return Config.model_validate(base)


def _zones(rng: np.random.Generator, names: list[str]) -> tuple[ZoneSection, ...]:
    zones: list[ZoneSection] = []
    wanted = int(rng.integers(1, 6))
    while len(zones) < wanted:
        number = len(zones)
        kind = str(rng.choice(KINDS))
        zone: dict[str, Any] = {"name": f"z{number}", "kind": kind}
        center = rng.uniform((0.2, 0.2), (2.2, 1.6))
        if kind in ("one_way", "lane"):
            turn = rng.uniform(0.0, math.tau)
            half = rng.uniform(0.2, 0.7) * np.array([math.cos(turn), math.sin(turn)])
            zone["line"] = [(center - half).tolist(), (center + half).tolist()]
            zone["width_m"] = float(rng.uniform(0.1, 0.4))
        elif rng.random() < 0.5:
            zone["circle"] = [*center.tolist(), float(rng.uniform(0.08, 0.3))]
        else:
            turns = np.sort(rng.uniform(0.0, math.tau, int(rng.integers(3, 7))))
            radii = rng.uniform(0.1, 0.35, len(turns))
            zone["polygon"] = np.column_stack(
                [center[0] + radii * np.cos(turns), center[1] + radii * np.sin(turns)]
            ).tolist()
        if kind == "slow" or (kind != "keep_out" and rng.random() < 0.2):
            zone["speed_m_s"] = float(rng.uniform(0.05, 0.15))
        if names and rng.random() < 0.3:
            zone["robots"] = [str(rng.choice(names))]
        with suppress(ValidationError):  # two sides cross
            zones.append(ZoneSection.model_validate(_tuples(zone)))
    return tuple(zones)


def _tuples(zone: dict[str, Any]) -> dict[str, Any]:
    """Lists as tuples, as sections are compared."""
    return {
        key: tuple(tuple(one) if isinstance(one, list) else one for one in value)
        if isinstance(value, list)
        else value
        for key, value in zone.items()
    }
