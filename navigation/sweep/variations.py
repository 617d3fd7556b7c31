"""Variations of a sweep: each robot has its own start and wheels.

Several robots share the camera's errors. Variation k of a seed is always the same, whatever else
the sweep is asked for. Units: metres, radians; degrees in configurations.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from navigation.config import Config
from navigation.config.several.each_robot import each_robot, robots_of
from navigation.config.simulation import RobotStartSection
from navigation.config.values import Pose
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.happenings import arenas_over_time
from planner.scene import FloatArray, Vec

WHEEL_ERROR: Final = 0.03
TRACK_ERROR: Final = 0.02
SLIP: Final = 0.02
NOISE_GREY: Final = 4.0
BLUR_PX: Final = 1.2
START_M: Final = 0.02
START_DEG: Final = 30.0
MOST_SPREAD: Final = 16.0
"""A wheel's error is then 0.48: a configuration takes less than 0.5."""
APART_M: Final = 0.02
"""Least gap between two bodies at their starts, or the configured one if that is less."""
HALVINGS: Final = 10
"""Number of tries; the last one moves the start by hundredths of a millimetre."""


class SweepError(ValueError):
    """A sweep that cannot be made; the message says why."""


@dataclass(frozen=True, slots=True)
class RobotVariation:
    """Changes of one run to one robot: everything random, and the world's errors."""

    run: int
    seed: int
    start_x_m: float
    start_y_m: float
    start_heading_deg: float
    wheel_error_left: float
    wheel_error_right: float
    track_error: float
    slip: float
    noise_grey: float
    blur_px: float

    def with_run_of(self, other: RobotVariation) -> RobotVariation:
        """The same robot with another one's seed and camera."""
        return replace(self, seed=other.seed, noise_grey=other.noise_grey, blur_px=other.blur_px)


@dataclass(frozen=True, slots=True)
class Variation:
    """One run's variation of each robot, by name, with one seed and one set of camera errors."""

    run: int
    robots: Mapping[str, RobotVariation]


def variation(config: Config, seed: int, run: int, spread: float = 1.0) -> Variation:
    """Variation ``run`` (from 0) of a sweep's ``seed``; ``spread`` 0 changes the seed only.

    Errors are uniform up to the limits above times ``spread``, around the configured starts. A
    start that would not be free is drawn towards the configured one. Starts keep ``APART_M``
    between two robots' bodies, or the configured distance if that is less. ``SweepError`` without a
    simulation and for a spread outside [0, 16], beyond which no configuration allows the errors.
    """
    if config.simulation is None:
        raise SweepError("a sweep needs a section 'simulation'")
    alone = robots_of(config)
    starts = {name: _start(one) for name, one in alone.items()}
    arena = arenas_over_time(config, load_arena(config))[0][1]
    drawn: dict[str, RobotVariation] = {}
    for number, (name, one) in enumerate(alone.items()):
        others = [
            (at, _least_m(one, alone[other], math.dist(starts[name], _start(alone[other]))))
            for other, at in starts.items()
            if other != name
        ]
        rng = np.random.default_rng([seed, run, number])
        drawn[name] = _draw(one, rng, run, spread, arena, others)
        starts[name] = drawn[name].start_x_m, drawn[name].start_y_m
    first = next(iter(drawn.values()))
    return Variation(run, {name: v.with_run_of(first) for name, v in drawn.items()})


def varied(config: Config, v: Variation) -> tuple[Config, dict[str, Config] | None]:
    """One run's configuration, and the true configuration of each of several robots."""
    first = next(iter(v.robots.values()))
    whole = _varied_one(config, first)
    if not config.robots:
        return whole, None
    assert config.simulation is not None
    assert whole.simulation is not None
    starts = tuple(
        RobotStartSection(
            name=name, x_m=one.start_x_m, y_m=one.start_y_m, heading_deg=one.start_heading_deg
        )
        for name, one in v.robots.items()
    )
    of_all = whole.simulation.model_copy(
        update={"start": None, "starts": starts, "robot": config.simulation.robot}
    )
    whole = config.model_copy(update={"simulation": of_all})
    return whole, {name: _body(one, v.robots[name]) for name, one in each_robot(whole).items()}


def _body(alone: Config, v: RobotVariation) -> Config:
    assert alone.simulation is not None
    seed = alone.simulation.seed
    simulation = _varied_one(alone, v).simulation
    assert simulation is not None
    return alone.model_copy(update={"simulation": simulation.model_copy(update={"seed": seed})})


def _start(config: Config) -> tuple[float, float]:
    assert config.simulation is not None
    start = config.simulation.start
    if start is None:
        raise SweepError("a sweep needs a simulated start for each robot")
    return start.x_m, start.y_m


def _least_m(one: Config, other: Config, configured_m: float) -> float:
    return min(configured_m, one.robot.radius_m + other.robot.radius_m + APART_M)


def _draw(
    config: Config,
    rng: np.random.Generator,
    run: int,
    spread: float,
    arena: SimulatedArena,
    others: Sequence[tuple[Vec, float]],
) -> RobotVariation:
    """Draw one robot's variation; ``others`` are places and their least distances to its start."""
    assert config.simulation is not None
    if not 0.0 <= spread <= MOST_SPREAD:
        raise SweepError(f"spread {spread:g}: must be >= 0 and <= {MOST_SPREAD:g}")
    # draw all, whatever the spread: a wider sweep is the same one, only wider
    unit = rng.uniform(-1.0, 1.0, 9)
    share = 0.5 + 0.5 * unit
    simulation, camera, robot = config.simulation, config.simulation.camera, config.simulation.robot
    start = simulation.start
    if start is None:
        raise SweepError("a sweep needs a simulated start for each robot")
    start_x_m, start_y_m = _free_start(config, START_M * spread * unit[:2], arena, others)
    if spread == 0.0:
        left, right = robot.wheel_radius_error
        errors = (left, right, robot.track_error, robot.slip, camera.noise_grey, camera.blur_px)
    else:
        errors = (
            WHEEL_ERROR * spread * unit[3],
            WHEEL_ERROR * spread * unit[4],
            TRACK_ERROR * spread * unit[5],
            SLIP * spread * share[6],
            NOISE_GREY * spread * share[7],
            BLUR_PX * spread * share[8],
        )
    return RobotVariation(
        run,
        int(rng.integers(0, 1 << 31)),
        start_x_m,
        start_y_m,
        float(start.heading_deg + START_DEG * spread * unit[2]),
        *(float(error) for error in errors),
    )


def _free_start(
    config: Config,
    offset_m: FloatArray,
    arena: SimulatedArena,
    others: Sequence[tuple[Vec, float]],
) -> tuple[float, float]:
    """Move the configured start by the offset (2,), halved until the place is as free as planning
    requires and as far from other starts, or as the configured one is."""
    assert config.simulation is not None
    start = config.simulation.start
    assert start is not None
    at_m = np.array([start.x_m, start.y_m])
    wanted_m = config.robot.radius_m + config.planning.margin_m
    wanted_m = min(wanted_m, float(arena.clearances(at_m[None])[0]))
    tried_m = at_m + offset_m * 0.5 ** np.arange(HALVINGS)[:, None]
    is_free = arena.clearances(tried_m) >= wanted_m
    for place, apart_m in others:
        is_free &= np.hypot(*(tried_m - np.array(place)).T) >= apart_m
    free = np.flatnonzero(is_free)
    x_m, y_m = tried_m[free[0]] if len(free) else at_m
    return float(x_m), float(y_m)


def _varied_one(config: Config, v: RobotVariation) -> Config:
    assert config.simulation is not None
    camera = config.simulation.camera.model_copy(
        update={"noise_grey": v.noise_grey, "blur_px": v.blur_px}
    )
    robot = config.simulation.robot.model_copy(
        update={
            "wheel_radius_error": (v.wheel_error_left, v.wheel_error_right),
            "track_error": v.track_error,
            "slip": v.slip,
        }
    )
    start = Pose(x_m=v.start_x_m, y_m=v.start_y_m, heading_deg=v.start_heading_deg)
    changed = {"seed": v.seed, "start": start, "camera": camera, "robot": robot}
    return config.model_copy(update={"simulation": config.simulation.model_copy(update=changed)})
