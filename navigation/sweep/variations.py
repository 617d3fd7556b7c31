"""Draws the variations of a sweep and makes each one's configuration.

Variation k of a seed is always the same, whatever is asked of the sweep besides.
Units: metres, radians; degrees in configurations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from navigation.config import Config
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
HALVINGS: Final = 10
"""After so many the start has moved by a few hundredths of a millimetre: it stays."""


class SweepError(ValueError):
    """A sweep cannot be made; the message says why."""


@dataclass(frozen=True, slots=True)
class Variation:
    """What one run of a sweep changes: everything random, and the world's errors."""

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

    def with_run_of(self, other: Variation) -> Variation:
        """The same robot in another one's run: its seed and its camera."""
        return replace(self, seed=other.seed, noise_grey=other.noise_grey, blur_px=other.blur_px)


def variation(config: Config, seed: int, run: int, spread: float = 1.0) -> Variation:
    """Variation ``run`` (from 0) of a sweep's ``seed``; ``spread`` 0 changes the seed only.

    Errors are uniform up to the limits above times ``spread``, around the configured start; a
    start that would not be free is drawn towards the configured one. ``SweepError`` without a
    simulation and for a spread outside [0, 16], beyond which no configuration allows the errors.
    """
    if config.simulation is None:
        raise SweepError("a sweep needs a section 'simulation'")
    return draw(
        config, np.random.default_rng([seed, run]), run, spread, arena_at_the_start(config), ()
    )


def draw(
    config: Config,
    rng: np.random.Generator,
    run: int,
    spread: float,
    arena: SimulatedArena,
    others: Sequence[tuple[Vec, float]],
) -> Variation:
    """One robot's variation; ``others`` are places, and how far its start must be from each."""
    assert config.simulation is not None
    if not 0.0 <= spread <= MOST_SPREAD:
        raise SweepError(f"spread {spread:g}: must be >= 0 and <= {MOST_SPREAD:g}")
    # each drawn whatever the spread is, so that a wider sweep is the same one, only wider
    unit = rng.uniform(-1.0, 1.0, 9)
    share = 0.5 + 0.5 * unit
    simulation, camera, robot = config.simulation, config.simulation.camera, config.simulation.robot
    start = simulation.start
    if start is None:
        raise SweepError("a sweep needs simulation.start")
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
    return Variation(
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
    """The configured start moved by the offset (2,), or by as many halves of it as it takes to
    be as free as planning wants and as far from other starts, or as the configured one is."""
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


def arena_at_the_start(config: Config) -> SimulatedArena:
    """What the simulated arena is when a run begins."""
    return arenas_over_time(config, load_arena(config))[0][1]


def varied(config: Config, v: Variation) -> Config:
    """The configuration of one run of the sweep."""
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
