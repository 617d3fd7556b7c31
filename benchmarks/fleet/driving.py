"""Several robots through the daemon in virtual time: contacts, deadlocks, and who arrives.

    python -m benchmarks.fleet.driving [--arenas 20] [--seed 1] [--robots 2-12] [--processes 1]
        [--output benchmarks/results/fleet_driving.md]

Each arena is drawn at random: walls and discs, starts and goals anywhere in the free space. Its
robots drive through the whole running program: simulated camera and vision, planner, pilots, links
and wheels, in virtual time. Meanwhile every robot stalls at random for up to 5 s (its link says
nothing and hears nothing), all lines lose and damage frames, the camera loses a marker now and
then, and one robot in ten dies for good. Judged by ground truth: a contact is a gap of bodies
below 0 m; a deadlock is a living robot that is not at its goal in the end although a path was
free. A robot that asks for a person (its emergency stop is latched) gets one after 2 s, who
re-arms it; how often is counted.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from navigation.config import Config, parse_config
from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.loop.fleet.fleet_state import FleetState
from navigation.loop.fleet.people import People
from navigation.mission.mission import State
from navigation.run.fleet.fleet_virtual_run import run_fleet_virtually
from navigation.run.fleet.fleet_virtual_world import FleetVirtualWorld

SIZE_M = (2.4, 1.8)
RADIUS_M = 0.07
APART_M = 0.06
"""Between the bodies of two robots at their starts and at their goals, at least."""
STALLS_A_MINUTE = 3.0
LONGEST_STALL_S = 5.0
DIES = 0.1
CALLED_S = 2.0
"""A person comes to a robot that has stopped."""
MOST_CALLS = 20
LINGER_S = 3.0
"""A run does not end before the person has come."""
TIME_LIMIT_S = 150.0
FAULTS = "drop=0.002,flip=0.0002"
RATE_HZ = 15


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one arena."""

    seed: int
    robots: int
    dead: int
    arrived: int
    living: int
    least_gap_m: float
    min_clearance_m: float
    duration_s: float
    rounds: int
    called: int
    """How often a person had to re-arm a robot."""
    reason: str
    took_s: float

    @property
    def touched(self) -> bool:
        """Whether two bodies overlapped."""
        return self.least_gap_m < 0.0


def arena_text(rng: np.random.Generator) -> tuple[str, list[tuple[float, float, float]]]:
    """Two to five discs and squares, and where they are: (x, y, radius that holds each)."""
    records, things = [], []
    for _ in range(int(rng.integers(2, 6))):
        radius_m = float(rng.uniform(0.08, 0.16))
        x, y = (float(rng.uniform(0.45, size - 0.45)) for size in SIZE_M)
        if any(math.dist((x, y), (a, b)) < radius_m + r + 0.06 for a, b, r in things):
            continue
        things.append((x, y, radius_m))
        if rng.random() < 0.5:
            records.append(f"C ({x:.3f},{y:.3f}) {radius_m:.3f}")
        else:
            turn = float(rng.uniform(0.0, math.tau))
            corners = [
                (x + radius_m * math.cos(turn - i * math.pi / 2),
                 y + radius_m * math.sin(turn - i * math.pi / 2))
                for i in range(4)
            ]  # fmt: skip
            records.append("L 4 " + " ".join(f"({a:.3f},{b:.3f})" for a, b in corners))
    return "\n".join(["#@ clearway.scene/1", "#@ units m", *records]), things


def free_places(
    rng: np.random.Generator, things: list[tuple[float, float, float]], count: int
) -> list[tuple[float, float]]:
    """Places for as many bodies, clear of each other, of all things and the walls."""
    for _ in range(100):
        places: list[tuple[float, float]] = []
        for _ in range(400):
            x, y = (float(rng.uniform(RADIUS_M + 0.05, s - RADIUS_M - 0.05)) for s in SIZE_M)
            clear = all(math.dist((x, y), (a, b)) > r + RADIUS_M + 0.04 for a, b, r in things)
            if clear and all(math.dist((x, y), p) > 2 * RADIUS_M + APART_M for p in places):
                places.append((x, y))
            if len(places) == count:
                return places
    raise RuntimeError(f"no room for {count} robots")


def config_of(seed: int, least: int, most: int) -> Config:
    """A random arena with its robots."""
    rng = np.random.default_rng([seed, 7])
    count = int(rng.integers(least, most + 1))
    text, things = arena_text(rng)
    starts, goals = (free_places(rng, things, count) for _ in range(2))
    names = [f"r{i}" for i in range(count)]
    body = {
        "arena": {"bounds_m": [0.0, 0.0, *SIZE_M]},
        "camera": {"source": "simulated", "size_px": [1280, 960], "rate_hz": RATE_HZ},
        "robot": {
            "marker_id": 0, "marker_size_m": 0.07, "marker_height_m": 0.1, "radius_m": RADIUS_M,
            "speed_m_s": 0.25, "acceleration_m_s2": 0.5, "track_m": 0.1,
        },
        "robots": [{"name": name, "marker_id": i + 1} for i, name in enumerate(names)],
        "mission": {
            "robots": [
                {"name": name, "stations": [{"x_m": round(x, 4), "y_m": round(y, 4)}]}
                for name, (x, y) in zip(names, goals, strict=True)
            ]
        },
        "simulation": {
            "seed": seed, "arena_text": text, "time_limit_s": TIME_LIMIT_S,
            "robot": {"faults": FAULTS},
            "starts": [
                {"name": name, "x_m": round(x, 4), "y_m": round(y, 4),
                 "heading_deg": float(rng.uniform(-180, 180))}
                for name, (x, y) in zip(names, starts, strict=True)
            ],
        },
    }  # fmt: skip
    return parse_config(json.dumps(body), f"arena {seed}")


class Troubles:
    """Stalls, lost markers and deaths, all drawn before the run."""

    def __init__(self, config: Config, seed: int) -> None:
        rng = np.random.default_rng([seed, 11])
        self.stalls: dict[str, list[tuple[float, float, bool]]] = {}
        self.dies_s: dict[str, float] = {}
        for entry in config.robots:
            count = int(rng.poisson(STALLS_A_MINUTE * 1.0))
            begin = np.sort(rng.uniform(2.0, 60.0, count))
            last = rng.uniform(0.3, LONGEST_STALL_S, count)
            hidden = rng.random(count) < 0.4
            self.stalls[entry.name] = list(
                zip(begin.tolist(), last.tolist(), hidden.tolist(), strict=True)
            )
            if rng.random() < DIES:
                self.dies_s[entry.name] = float(rng.uniform(3.0, 25.0))

    def meet(self, world: FleetVirtualWorld, since_s: float) -> None:
        """What is wrong at this moment."""
        for name, body in world.bodies.items():
            body.off = since_s >= self.dies_s.get(name, math.inf)
            now = [
                hidden
                for begin_s, last_s, hidden in self.stalls[name]
                if begin_s <= since_s < begin_s + last_s
            ]
            body.troubles.cable_out = any(not hidden for hidden in now)
            body.troubles.marker_hidden = any(now)


class Person:
    """Re-arms a living robot that has stopped for one, as its sentence asks for."""

    def __init__(self, dead: set[str]) -> None:
        self._dead = dead
        self._last_s = dict[str, float]()
        self.called = 0

    def look(self, daemon: FleetDaemon, now: FleetState) -> bool:
        """After each cycle; never ends the run."""
        for name, one in now.robots.items():
            waits = one.mission.state is State.STOPPED or (
                one.mission.state is State.IDLE and one.mission.remaining
            )
            if name in self._dead or not waits or self.called >= MOST_CALLS:
                continue
            if now.time_s - self._last_s.setdefault(name, now.time_s) > CALLED_S:
                self._last_s[name] = now.time_s
                self.called += one.mission.state is State.STOPPED
                People(daemon).resume(name)
        return False


def drive(seed: int, least: int, most: int) -> Outcome:
    """One arena from its start to its end."""
    config = config_of(seed, least, most)
    troubles = Troubles(config, seed)
    began_s = time.perf_counter()
    person = Person(set(troubles.dies_s))
    report = run_fleet_virtually(config, meet=troubles.meet, look=person.look, linger_s=LINGER_S)
    living = [name for name in report.robots if name not in troubles.dies_s]
    return Outcome(
        seed=seed,
        robots=len(config.robots),
        dead=len(troubles.dies_s),
        arrived=sum(report.robots[name].state == "done" for name in living),
        living=len(living),
        least_gap_m=math.inf if report.least_gap_m is None else report.least_gap_m,
        min_clearance_m=math.inf if report.min_clearance_m is None else report.min_clearance_m,
        duration_s=report.duration_s,
        rounds=report.rounds,
        called=person.called,
        reason="; ".join(
            f"{name}: {report.robots[name].reason}"
            for name in living
            if report.robots[name].state != "done"
        ),
        took_s=time.perf_counter() - began_s,
    )


def page(outcomes: list[Outcome]) -> str:
    """The table and its sums."""
    touched = [one for one in outcomes if one.touched]
    hit = [one for one in outcomes if one.min_clearance_m < RADIUS_M]
    arrived, living = sum(one.arrived for one in outcomes), sum(one.living for one in outcomes)
    gaps = [one.least_gap_m for one in outcomes]
    lines = [
        "# Several robots through the daemon",
        "",
        "Made by `python -m benchmarks.fleet.driving`; see its text for what goes wrong meanwhile.",
        "",
        "| arenas | robots | dead | contacts | obstacles touched | living at their goals |"
        " least gap, mm | person called |",
        "|---|---|---|---|---|---|---|---|",
        f"| {len(outcomes)} | {sum(one.robots for one in outcomes)}"
        f" | {sum(one.dead for one in outcomes)} | {len(touched)} | {len(hit)}"
        f" | {arrived} of {living} | {min(gaps) * 1e3:.1f}"
        f" | {sum(one.called for one in outcomes)} |",
        "",
        "| seed | robots | dead | arrived | least gap, mm | duration, s | plans | reason |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one.seed} | {one.robots} | {one.dead} | {one.arrived} of {one.living}"
        f" | {one.least_gap_m * 1e3:.1f} | {one.duration_s:.1f} | {one.rounds}"
        f" | {one.reason[:160]} |"
        for one in outcomes
    ]
    took = statistics.median(one.took_s for one in outcomes)
    return "\n".join([*lines, "", f"A run took {took:.0f} s of the wall's time in the middle.", ""])


def main() -> None:
    """Run the arenas; see the module's text."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arenas", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robots", default="2-12")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--output", type=Path)
    given = parser.parse_args()
    least, _, most = given.robots.partition("-")
    jobs = [(given.seed + i, int(least), int(most or least)) for i in range(given.arenas)]
    outcomes = []
    with get_context("spawn").Pool(given.processes) as pool:
        for one in pool.imap(_drive, jobs):
            outcomes.append(one)
            sys.stderr.write(f"{json.dumps(asdict(one))}\n")
    text = page(outcomes)
    if given.output is not None:
        given.output.write_text(text)
    sys.stdout.write(text)


def _drive(job: tuple[int, int, int]) -> Outcome:
    return drive(*job)


if __name__ == "__main__":
    main()
