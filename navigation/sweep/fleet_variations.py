"""Variations of a sweep over several robots: each has a start, wheels and a seed of its own.

They share the camera's errors. Variation k of a seed is always the same. Units: metres, radians;
degrees in configurations.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from navigation.config import Config
from navigation.config.several.each_robot import each_robot
from navigation.config.simulation import RobotStartSection
from navigation.sweep.variations import (
    SweepError,
    Variation,
    arena_at_the_start,
    draw,
    varied,
)

APART_M: Final = 0.02
"""Between two bodies at their starts, or what the configuration leaves where that is less."""


@dataclass(frozen=True, slots=True)
class FleetVariation:
    """One run's variation of each robot, by name; ``run`` and the camera's errors are the same."""

    run: int
    robots: Mapping[str, Variation]


def fleet_variation(config: Config, seed: int, run: int, spread: float = 1.0) -> FleetVariation:
    """Variation ``run`` (from 0) of a sweep's ``seed``, as `variations.variation` for one robot.

    No start is nearer to another robot's than ``APART_M`` between their bodies, or than configured.
    """
    if config.simulation is None:
        raise SweepError("a sweep needs a section 'simulation'")
    alone = each_robot(config)
    starts = {name: _start(one) for name, one in alone.items()}
    arena = arena_at_the_start(config)
    drawn: dict[str, Variation] = {}
    for number, (name, one) in enumerate(alone.items()):
        others = [
            (at, _least_m(one, alone[other], math.dist(starts[name], _start(alone[other]))))
            for other, at in starts.items()
            if other != name
        ]
        found = draw(one, np.random.default_rng([seed, run, number]), run, spread, arena, others)
        starts[name] = found.start_x_m, found.start_y_m
        drawn[name] = found
    first = next(iter(drawn.values()))
    return FleetVariation(
        run,
        {name: v.with_run_of(first) for name, v in drawn.items()},
    )


def _start(config: Config) -> tuple[float, float]:
    assert config.simulation is not None
    start = config.simulation.start
    if start is None:
        raise SweepError("a sweep needs a simulated start for each robot")
    return start.x_m, start.y_m


def _least_m(one: Config, other: Config, configured_m: float) -> float:
    return min(configured_m, one.robot.radius_m + other.robot.radius_m + APART_M)


def fleet_varied(config: Config, v: FleetVariation) -> tuple[Config, dict[str, Config]]:
    """The configuration of one run, and what each simulated robot really is."""
    first = next(iter(v.robots.values()))
    assert config.simulation is not None
    starts = tuple(
        RobotStartSection(
            name=name, x_m=one.start_x_m, y_m=one.start_y_m, heading_deg=one.start_heading_deg
        )
        for name, one in v.robots.items()
    )
    shared = varied(config, first).simulation
    assert shared is not None
    of_all = shared.model_copy(
        update={"start": None, "starts": starts, "robot": config.simulation.robot}
    )
    whole = config.model_copy(update={"simulation": of_all})
    bodies = {name: _body(one, v.robots[name]) for name, one in each_robot(whole).items()}
    return whole, bodies


def _body(alone: Config, v: Variation) -> Config:
    """One robot with the wheels that were drawn for it, and its own seed."""
    assert alone.simulation is not None
    seed = alone.simulation.seed
    simulation = varied(alone, v).simulation
    assert simulation is not None
    return alone.model_copy(update={"simulation": simulation.model_copy(update={"seed": seed})})
