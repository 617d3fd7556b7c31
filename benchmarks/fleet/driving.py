"""Several robots through the daemon in virtual time: contacts, deadlocks, and who arrives.

    python -m benchmarks.fleet.driving [--arenas 300] [--seed 1] [--robots 2-12] [--processes 1]
        [--rows ROWS.jsonl] [--minutes 60] [--output benchmarks/results/fleet_driving.md]

Each arena is drawn at random: walls and discs, starts and goals anywhere in the free space. Its
robots drive through the whole running program: simulated camera and vision, planner, pilots, links
and wheels, in virtual time. Meanwhile every robot stalls at random for up to 5 s (its link says
nothing and hears nothing), all lines lose and damage frames, the camera loses a marker now and
then, and one robot in ten dies for good. Judged by ground truth: a contact is a gap of bodies
below 0 m; a deadlock is a living robot that is not at its goal in the end although there is a plan
by which all living ones get there around the dead, or although nobody has proved that there is
none. A robot that asks for a person (its emergency stop is latched) gets one after 2 s, who
re-arms it; how often is counted.

With ``--rows`` every arena's row is appended to a file as it ends, and an arena that is in it is
not driven again: a run that was cut short continues. ``--minutes`` begins no arena after that time;
the page says how many of those asked for were driven.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import planner
from navigation.config import Config, parse_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from navigation.run.virtual_run import run_virtually
from navigation.simulator.arena import load_arena
from planner.scene import CircleRecord, SceneObject
from tests.support.runs.troubled_world import TroubledWorld

SIZE_M = (2.4, 1.8)
RADIUS_M = 0.07
Place = tuple[float, float]
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
    deadlocked: bool
    """Whether a living robot is not at its goal although it could be."""
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

    def meet(self, world: TroubledWorld, since_s: float) -> None:
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
        self.places: dict[str, Place] = {}
        """Where the camera saw each robot last."""

    def look(self, daemon: Daemon, now: RunState) -> bool:
        """After each cycle; never ends the run."""
        for name, one in now.robots.items():
            if one.pose is not None:
                self.places[name] = one.pose.x, one.pose.y
        for name, one in now.robots.items():
            waits = one.mission.state is State.STOPPED or (
                one.mission.state is State.IDLE and one.mission.remaining
            )
            if name in self._dead or not waits or self.called >= MOST_CALLS:
                continue
            if now.time_s - self._last_s.setdefault(name, now.time_s) > CALLED_S:
                self._last_s[name] = now.time_s
                self.called += one.mission.state is State.STOPPED
                daemon.people.resume(name)
        return False


def could_arrive(config: Config, dead: set[str], places: dict[str, Place]) -> bool:
    """Whether the living could all get from where they are to their goals, around the dead.

    True too where the planner cannot tell: only what is proved excuses a robot.
    """
    scene = load_arena(config).scene
    first = 1 + max((thing.id for thing in scene.objects), default=-1)
    bodies = tuple(
        SceneObject(first + i, (CircleRecord(places[name], RADIUS_M),))
        for i, name in enumerate(sorted(dead & places.keys()))
    )
    roadmap = planner.build_roadmap(
        replace(scene, objects=(*scene.objects, *bodies)), radius=RADIUS_M
    )
    goals = {one.name: (one.stations[0].x_m, one.stations[0].y_m) for one in config.mission.robots}
    living = [name for name in goals if name in places and name not in dead]
    plan = planner.plan_fleet(
        roadmap, [places[name] for name in living], [goals[name] for name in living]
    )
    return isinstance(plan, planner.FleetPlan) or not plan.proved


def drive(seed: int, least: int, most: int) -> Outcome:
    """One arena from its start to its end."""
    config = config_of(seed, least, most)
    troubles = Troubles(config, seed)
    began_s = time.perf_counter()
    person = Person(set(troubles.dies_s))
    report = run_virtually(
        config,
        meet=troubles.meet,
        look=person.look,
        linger_s=LINGER_S,
        make_world=TroubledWorld,
    )
    dead = set(troubles.dies_s)
    living = [name for name in report.robots if name not in dead]
    arrived = sum(report.robots[name].state == "done" for name in living)
    stuck = arrived < len(living) and could_arrive(config, dead, person.places)
    return Outcome(
        seed=seed,
        robots=len(config.robots),
        dead=len(troubles.dies_s),
        arrived=arrived,
        living=len(living),
        least_gap_m=math.inf if report.least_gap_m is None else report.least_gap_m,
        min_clearance_m=math.inf if report.min_clearance_m is None else report.min_clearance_m,
        duration_s=report.duration_s,
        rounds=report.rounds,
        called=person.called,
        deadlocked=stuck,
        reason="; ".join(
            f"{name}: {report.robots[name].reason}"
            for name in living
            if report.robots[name].state != "done"
        ),
        took_s=time.perf_counter() - began_s,
    )


def page(outcomes: list[Outcome], asked: int) -> str:
    """The table and its sums."""
    hit = sum(one.min_clearance_m < RADIUS_M for one in outcomes)
    arrived, living = sum(one.arrived for one in outcomes), sum(one.living for one in outcomes)
    gaps = [one.least_gap_m for one in outcomes]
    lines = [
        "# Several robots through the daemon",
        "",
        "Made by `python -m benchmarks.fleet.driving`; see its text for what goes wrong meanwhile.",
        "",
        "| arenas | robots | dead | contacts | deadlocks | obstacles touched |"
        " living at their goals | least gap, mm | person called |",
        "|---|---|---|---|---|---|---|---|---|",
        f"| {len(outcomes)} of {asked} | {sum(one.robots for one in outcomes)}"
        f" | {sum(one.dead for one in outcomes)} | {sum(one.touched for one in outcomes)}"
        f" | {sum(one.deadlocked for one in outcomes)} | {hit}"
        f" | {arrived} of {living} | {min(gaps) * 1e3:.1f}"
        f" | {sum(one.called for one in outcomes)} |",
        "",
        "Arenas in which something touched, or a living robot is not at its goal:",
        "",
        "| seed | robots | dead | arrived | least gap, mm | duration, s | plans | reason |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one.seed} | {one.robots} | {one.dead} | {one.arrived} of {one.living}"
        f" | {one.least_gap_m * 1e3:.1f} | {one.duration_s:.1f} | {one.rounds}"
        f" | {one.reason[:160]} |"
        for one in outcomes
        if one.touched or one.arrived < one.living or one.min_clearance_m < RADIUS_M
    ]
    took = statistics.median(one.took_s for one in outcomes)
    return "\n".join([*lines, "", f"A run took {took:.0f} s of the wall's time in the middle.", ""])


def rows_of(file: Path | None) -> dict[int, Outcome]:
    """By seed: what was driven before."""
    if file is None or not file.exists():
        return {}
    rows = [Outcome(**json.loads(line)) for line in file.read_text().splitlines()]
    return {one.seed: one for one in rows}


def main() -> None:
    """Run the arenas; see the module's text."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arenas", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robots", default="2-12")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--minutes", type=float, default=math.inf)
    parser.add_argument("--output", type=Path)
    given = parser.parse_args()
    least, _, most = given.robots.partition("-")
    known = rows_of(given.rows)
    seeds = range(given.seed, given.seed + given.arenas)
    until_s = time.monotonic() + 60.0 * given.minutes
    jobs = [(seed, int(least), int(most or least), until_s) for seed in seeds if seed not in known]
    with get_context("spawn").Pool(given.processes) as pool:
        for one in pool.imap(_drive, jobs):
            if one is None:
                continue
            known[one.seed] = one
            line = f"{json.dumps(asdict(one))}\n"
            sys.stderr.write(line)
            if given.rows is not None:
                with given.rows.open("a") as file:
                    file.write(line)
    text = page([known[seed] for seed in seeds if seed in known], given.arenas)
    if given.output is not None:
        given.output.write_text(text)
    sys.stdout.write(text)


def _drive(job: tuple[int, int, int, float]) -> Outcome | None:
    seed, least, most, until_s = job
    return None if time.monotonic() > until_s else drive(seed, least, most)


if __name__ == "__main__":
    main()
