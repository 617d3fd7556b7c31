"""Many variations of one simulated run, in virtual time, over processes or a cluster.

Rules
- Variation k of a seed is always the same, and so is its row: nothing depends on which worker
  runs it, on when, or on how many there are.
- A worker that dies costs time, not results: what it was doing is done again. A variation that
  has killed ``MOST_ATTEMPTS`` workers gets a row that says so.
- Only a few runs are handed out at a time, and after a death those that were at work go alone:
  then it is known whose fault the next one is.

Units: metres, radians, seconds; degrees in configurations.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, fields
from typing import Final

import numpy as np

from navigation.config import Config
from navigation.config.values import Pose
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.happenings import arenas_over_time
from planner.scene import FloatArray

MOST_ATTEMPTS: Final = 3
IN_HAND_PER_WORKER: Final = 2

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


@dataclass(frozen=True, slots=True)
class Row:
    """One run and what came of it; None where a thing could not be known."""

    run: int
    seed: int
    state: str
    reason: str
    duration_s: float | None = None
    min_clearance_m: float | None = None
    tracking_rms_m: float | None = None
    tracking_max_m: float | None = None
    goal_error_m: float | None = None
    goal_error_deg: float | None = None
    stations_visited: int | None = None
    replans: int | None = None
    waypoints_executed: int | None = None
    retransmits: int | None = None
    crc_errors: int | None = None
    start_x_m: float = 0.0
    start_y_m: float = 0.0
    start_heading_deg: float = 0.0
    wheel_error_left: float = 0.0
    wheel_error_right: float = 0.0
    track_error: float = 0.0
    slip: float = 0.0
    noise_grey: float = 0.0
    blur_px: float = 0.0


COLUMNS: Final = tuple(field.name for field in fields(Row))


def variation(config: Config, seed: int, run: int, spread: float = 1.0) -> Variation:
    """Variation ``run`` (from 0) of a sweep's ``seed``; ``spread`` 0 changes the seed only.

    Errors are uniform up to the limits above times ``spread``, around the configured start; a
    start that would not be free is drawn towards the configured one. ``SweepError`` without a
    simulation and for a spread outside [0, 16], beyond which no configuration allows the errors.
    """
    if config.simulation is None:
        raise SweepError("a sweep needs a section 'simulation'")
    if not 0.0 <= spread <= MOST_SPREAD:
        raise SweepError(f"spread {spread:g}: must be >= 0 and <= {MOST_SPREAD:g}")
    rng = np.random.default_rng([seed, run])
    # each drawn whatever the spread is, so that a wider sweep is the same one, only wider
    unit = rng.uniform(-1.0, 1.0, 9)
    share = 0.5 + 0.5 * unit
    simulation, camera, robot = config.simulation, config.simulation.camera, config.simulation.robot
    start = simulation.start
    start_x_m, start_y_m = _free_start(config, START_M * spread * unit[:2])
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


def _free_start(config: Config, offset_m: FloatArray) -> tuple[float, float]:
    """The configured start moved by the offset (2,), or by as many halves of it as it takes to
    be as free as planning wants, or as the configured one where that is less."""
    assert config.simulation is not None
    start = config.simulation.start
    at_m = np.array([start.x_m, start.y_m])
    arena = _arena_at_the_start(config)
    wanted_m = config.robot.radius_m + config.planning.margin_m
    wanted_m = min(wanted_m, float(arena.clearances(at_m[None])[0]))
    tried_m = at_m + offset_m * 0.5 ** np.arange(HALVINGS)[:, None]
    free = np.flatnonzero(arena.clearances(tried_m) >= wanted_m)
    x_m, y_m = tried_m[free[0]] if len(free) else at_m
    return float(x_m), float(y_m)


def _arena_at_the_start(config: Config) -> SimulatedArena:
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


def run_one(config: Config, v: Variation) -> Row:
    """One run of the sweep, in a worker."""
    import cv2

    from navigation.run.virtual_run import run_virtually

    cv2.setNumThreads(1)  # the other cores have runs of their own
    report = run_virtually(varied(config, v))
    return Row(
        state=report.state,
        reason=report.reason,
        duration_s=report.duration_s,
        min_clearance_m=report.min_clearance_m,
        tracking_rms_m=report.tracking_error_m.rms,
        tracking_max_m=report.tracking_error_m.max,
        goal_error_m=report.goal_error_m,
        goal_error_deg=report.goal_error_deg,
        stations_visited=report.stations_visited,
        replans=report.replans,
        waypoints_executed=report.waypoints_executed,
        retransmits=report.link.retransmits,
        crc_errors=report.link.crc_errors,
        **asdict(v),
    )


class Sweep:
    """Hands variations out to workers and takes rows, whatever becomes of the workers.

    ``open_executor`` makes the executor, and another when it broke; ``work`` is `run_one`, or
    another function of the same arguments in tests.
    """

    def __init__(
        self,
        config: Config,
        variations: list[Variation],
        open_executor: Callable[[], Executor],
        workers: int,
        work: Callable[[Config, Variation], Row] = run_one,
    ) -> None:
        self._config = config
        self._left = deque(variations)
        self._suspects: deque[Variation] = deque()
        self._open_executor = open_executor
        self._most_in_hand = max(1, workers * IN_HAND_PER_WORKER)
        self._work = work
        self._attempts: dict[int, int] = {}
        self.deaths = 0
        """How often workers died."""

    def rows(self) -> Iterator[Row]:
        """A row for every variation, in the order in which they are done."""
        executor = self._open_executor()
        running: dict[Future[Row], Variation] = {}
        try:
            while self._left or self._suspects or running:
                for chosen in self._next(len(running)):
                    running[executor.submit(self._work, self._config, chosen)] = chosen
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                died = [future for future in done if _is_death(future.exception())]
                for future in done:
                    chosen, error = running.pop(future), future.exception()
                    if error is None:
                        yield future.result()
                    elif future not in died:
                        sentence = f"{type(error).__name__}: {error}"
                        yield _failed_row(chosen, "crashed", sentence)
                    else:
                        yield from self._again(chosen)
                if died:
                    self.deaths += 1
                    # a broken pool has forgotten the others too
                    for chosen in running.values():
                        yield from self._again(chosen)
                    running.clear()
                    executor.shutdown(wait=False)
                    executor = self._open_executor()
        finally:
            for future in running:
                future.cancel()
            executor.shutdown(wait=False)

    def _next(self, running: int) -> Iterator[Variation]:
        """What to hand out now; one that was at work when a worker died goes alone."""
        if self._suspects:
            if running == 0:
                yield self._suspects.popleft()
            return
        while self._left and running < self._most_in_hand:
            running += 1
            yield self._left.popleft()

    def _again(self, chosen: Variation) -> Iterator[Row]:
        """Try a variation again whose worker died; a row where that was too often."""
        attempts = self._attempts[chosen.run] = self._attempts.get(chosen.run, 0) + 1
        if attempts < MOST_ATTEMPTS:
            self._suspects.append(chosen)
        else:
            yield _failed_row(chosen, "killed", f"its worker died {attempts} times")


def _is_death(error: BaseException | None) -> bool:
    """Whether the worker died, not the run: of a process, or a cluster's KilledWorker."""
    return isinstance(error, BrokenProcessPool) or type(error).__name__ in (
        "KilledWorker",
        "CancelledError",
        "FutureCancelledError",
    )


def _failed_row(v: Variation, state: str, reason: str) -> Row:
    return Row(state=state, reason=reason, **asdict(v))
