"""A sweep's runs in processes or a cluster, in virtual time, and their rows.

Rules
- A variation's row is always the same, whatever worker runs it, when, and among how many.
- A worker's death costs time, not results: its run is repeated. A variation that has killed
  ``MOST_ATTEMPTS`` workers gets a row that says so.
- Only a few runs are handed out at a time. After a death the runs at work are repeated alone, so
  that the next death has a known culprit.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, fields, replace
from typing import TYPE_CHECKING, Final, TypeAlias

from navigation.config import Config
from navigation.sweep.variations import RobotVariation, Variation, varied

if TYPE_CHECKING:
    from navigation.run.robot_report import Report

MOST_ATTEMPTS: Final = 3
IN_HAND_PER_WORKER: Final = 2
IDLE: Final = "idle"
"""The state in the row of a robot that had no mission."""


@dataclass(frozen=True, slots=True)
class Row:
    """One run and its results; unknown ones are None."""

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
    robot: str = ""
    """Name of the row's robot, if there are several."""
    least_gap_m: float | None = None
    """Least gap between two bodies in the run, if there are several robots."""


Work: TypeAlias = Callable[[Config, Variation], tuple[Row, ...]]
FLEET_COLUMNS: Final = tuple(field.name for field in fields(Row))
COLUMNS: Final = tuple(name for name in FLEET_COLUMNS if name not in ("robot", "least_gap_m"))


def run_rows(config: Config, v: Variation, *, pictures: bool = True) -> tuple[Row, ...]:
    """Do one run of a sweep, in a worker; one row per robot."""
    import cv2

    from navigation.run.virtual_run import run_virtually

    cv2.setNumThreads(1)  # the other cores have their own runs
    whole, bodies = varied(config, v)
    report = run_virtually(whole, bodies=bodies, pictures=pictures)
    rows = {
        name: _row(one, v.robots[name], name, report.least_gap_m)
        for name, one in report.robots.items()
    }
    return tuple(
        row if report.robots[name].stations else replace(row, state=IDLE)
        for name, row in rows.items()
    )


def _row(report: Report, v: RobotVariation, robot: str, least_gap_m: float | None) -> Row:
    return Row(
        robot=robot,
        least_gap_m=least_gap_m,
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
    """Distributor of variations to workers and collector of rows, even if workers die.

    ``open_executor`` makes the executor, and a new one after it broke; ``work`` is `run_rows`, or a
    test's substitute.
    """

    def __init__(
        self,
        config: Config,
        variations: Sequence[Variation],
        open_executor: Callable[[], Executor],
        workers: int,
        work: Work = run_rows,
    ) -> None:
        self._config = config
        self._left = deque(variations)
        self._suspects: deque[Variation] = deque()
        self._open_executor = open_executor
        self._most_in_hand = max(1, workers * IN_HAND_PER_WORKER)
        self._work = work
        self._attempts: dict[int, int] = {}
        self.deaths = 0
        """Number of times that workers died."""

    def rows(self) -> Iterator[Row]:
        """Yield a row for every variation and each of its robots, in order of completion."""
        executor = self._open_executor()
        running: dict[Future[tuple[Row, ...]], Variation] = {}
        try:
            while self._left or self._suspects or running:
                for chosen in self._next(len(running)):
                    running[executor.submit(self._work, self._config, chosen)] = chosen
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                died = [future for future in done if _is_death(future.exception())]
                for future in done:
                    chosen, error = running.pop(future), future.exception()
                    if error is None:
                        yield from future.result()
                    elif future not in died:
                        sentence = f"{type(error).__name__}: {error}"
                        yield from _failed_rows(chosen, "crashed", sentence)
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
        """Yield the variations to hand out now; one at work when a worker died runs alone."""
        if self._suspects:
            if running == 0:
                yield self._suspects.popleft()
            return
        while self._left and running < self._most_in_hand:
            running += 1
            yield self._left.popleft()

    def _again(self, chosen: Variation) -> Iterator[Row]:
        """Retry a variation whose worker died, or yield its row after too many deaths."""
        attempts = self._attempts[chosen.run] = self._attempts.get(chosen.run, 0) + 1
        if attempts < MOST_ATTEMPTS:
            self._suspects.append(chosen)
        else:
            yield from _failed_rows(chosen, "killed", f"its worker died {attempts} times")


def _is_death(error: BaseException | None) -> bool:
    """True if the worker died, not the run."""
    return isinstance(error, BrokenProcessPool) or type(error).__name__ in (
        "KilledWorker",
        "CancelledError",
        "FutureCancelledError",
    )


def _failed_rows(chosen: Variation, state: str, reason: str) -> Iterator[Row]:
    for name, one in chosen.robots.items():
        yield Row(state=state, reason=reason, robot=name, **asdict(one))
