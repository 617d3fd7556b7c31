"""The bars, and what is measured against them. Metres, seconds.

Motion after the permit: a robot whose permit ends brakes; how long after the last valid permit
it began to is what counts. Each sample of its speed v, ``age`` after the permit, shows that it
began no earlier than ``age - (v_before - v) / braking - lag``; the latest such moment is judged.
A permit is valid from when the program has sent it, provided that it was let through.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from navigation.simulator.arena import SimulatedArena
from planner.scene import FloatArray

PERMIT_LIMIT_S = 0.55
STOP_LIMIT_S = 0.3
DRIVER_LIMIT_S = 0.3
"""A robot behind a driver drives so long, at its speed, after its driver's last sign of life."""
END_LIMIT_S = 5.0
"""From SIGTERM to the end of the program, whatever its driver does."""
STAND_LIMIT_S = 1.4
"""From a stop order to rest where the emergency stop is lost: the lease, and 0.6 s of braking."""
SAID_LIMIT_S = 3.0
"""A robot that stands for longer is not said to be driving."""
STANDS_M_S = 0.01
BRAKING_M_S2 = 0.4
"""Four fifths of the robot's own 0.5: its motors lag."""
LAG_S = 0.05
"""The motors' time constant: so long a wheel keeps its speed after it was told to brake."""
ELSEWHERE_M = 0.1
"""A pose that is so far from the truth leads astray; the eye is right to a few millimetres."""
TRACK_M = 0.12
STEP_S = 0.01
WINDOW = 3
"""Speeds are taken over two of these steps each way around a moment."""


@dataclass(frozen=True, slots=True)
class Moment:
    """What happened at what time besides: all monotonic seconds."""

    permits_s: Sequence[float]
    by_hand_s: Sequence[tuple[float, float]] = ()
    halted_s: Sequence[tuple[float, float]] = ()
    """From when to when the robot's own process did not run."""


@dataclass(slots=True)
class Outcome:
    """One run as it was measured."""

    attack: str
    seed: int
    least_gap_m: float = math.inf
    """The least true clearance of the robot's disc, its radius taken off."""
    stop_s: float | None = None
    """How long the answer to `stop` took; None where there was none."""
    stood_s: float = 0.0
    """From the stop order until the robot stood."""
    drove_s: float = 0.0
    """Time that it drove without braking after its last valid permit; a robot behind a driver,
    after its driver's last sign of life.
    """
    blind_m: float = 0.0
    """How far it went while the program took it for elsewhere: no bar, but a warning."""
    said_s: float = 0.0
    """Seconds of one stand in which it was said to be driving."""
    state: str = ""
    sentence: str = ""
    failures: list[str] = field(default_factory=list)
    took_s: float = 0.0


def least_gap_m(
    rows: FloatArray, arena: SimulatedArena, radius_m: float, by_hand: Sequence[tuple[float, float]]
) -> float:
    """The least clearance of the disc while nobody's hand held it."""
    free = np.ones(len(rows), dtype=bool)
    for begin_s, end_s in by_hand:
        free &= (rows[:, 0] < begin_s) | (rows[:, 0] > end_s)
    if not free.any():
        return math.inf
    return float(arena.clearances(rows[free, 1:3]).min()) - radius_m


def speeds(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Times (n,) and the faster wheel's speed (n,) of a sampled track (m, 4)."""
    if len(rows) < 2:
        return np.empty(0), np.empty(0)
    times = np.arange(rows[0, 0], rows[-1, 0], STEP_S)
    x, y = (np.interp(times, rows[:, 0], rows[:, i]) for i in (1, 2))
    heading = np.interp(times, rows[:, 0], np.unwrap(rows[:, 3]))
    apart_s = 2 * WINDOW * STEP_S
    way, turn = (
        np.hypot(x[2 * WINDOW :] - x[: -2 * WINDOW], y[2 * WINDOW :] - y[: -2 * WINDOW]),
        np.abs(heading[2 * WINDOW :] - heading[: -2 * WINDOW]) * TRACK_M / 2,
    )
    return times[WINDOW:-WINDOW], (way + turn) / apart_s


def drove_without_permit_s(rows: FloatArray, moment: Moment) -> float:
    """The latest, over the run, that braking began after a permit; see the module's text.

    0.0 where the robot always had a permit or stood.
    """
    times, speed = speeds(rows)
    if len(times) == 0:
        return 0.0
    permits = np.array(sorted(moment.permits_s)) if moment.permits_s else np.array([times[0]])
    last = np.searchsorted(permits, times, side="right") - 1
    since = np.where(last >= 0, permits[np.maximum(last, 0)], times[0])
    for _, back_s in moment.halted_s:
        # wheels can brake only when the processor is back: from then on they have to
        since = np.where(times >= back_s - WINDOW * STEP_S, np.maximum(since, back_s - 0.5), since)
    excused = np.zeros(len(times), dtype=bool)
    for begin_s, end_s in [*moment.by_hand_s, *moment.halted_s]:
        margin_s = (WINDOW + 2) * STEP_S
        excused |= (times > begin_s - margin_s) & (times < end_s + margin_s)
    worst = 0.0
    for start_s in np.unique(since):
        part = (since == start_s) & ~excused
        before = speed[(times >= start_s - 0.1) & (times <= start_s + PERMIT_LIMIT_S)]
        fastest = float(before.max()) if len(before) else 0.0
        moving = part & (speed > STANDS_M_S)
        if not moving.any():
            continue
        age = times[moving] - start_s
        braked_s = LAG_S + np.maximum(0.0, fastest - speed[moving]) / BRAKING_M_S2
        worst = max(worst, float((age - braked_s).max()))
    return worst


def way_to_rest_m(rows: FloatArray, since_s: float) -> float:
    """The way that the robot went from a moment until it first stood."""
    times, speed = speeds(rows)
    stands = times[(times >= since_s) & (speed <= STANDS_M_S)]
    until_s = stands[0] if len(stands) else math.inf
    part = rows[(rows[:, 0] >= since_s) & (rows[:, 0] <= until_s)]
    return float(np.hypot(*np.diff(part[:, 1:3], axis=0).T).sum())


def blind_m(rows: FloatArray, fixes: Sequence[tuple[float, float, float]]) -> float:
    """How far the robot went, in metres, while the program took it for elsewhere.

    ``fixes``: each pose that the program told: when, x_m, y_m. What the eye needs to see, some
    centiseconds, is no error of ``ELSEWHERE_M``.
    """
    if not fixes or len(rows) < 2:
        return 0.0
    told = np.array(fixes)
    x, y = (np.interp(told[:, 0], rows[:, 0], rows[:, i]) for i in (1, 2))
    wrong = np.hypot(told[:, 1] - x, told[:, 2] - y) > ELSEWHERE_M
    last = np.searchsorted(told[:, 0], rows[:-1, 0], side="right") - 1
    ways = np.hypot(*np.diff(rows[:, 1:3], axis=0).T)
    return float(ways[(last >= 0) & wrong[np.maximum(last, 0)]].sum())


def said_to_drive_s(rows: FloatArray, said: Sequence[tuple[float, str]]) -> float:
    """The longest, in one stand of the robot, that it was ``said`` to be 'driving', all together.

    Between two answers that say so it was; a state that flutters is no better than one that lasts.
    """
    times, speed = speeds(rows)
    longest = told_s = 0.0
    for (before_s, before), (now_s, now) in pairwise(said):
        moving = times[(times >= before_s) & (times <= now_s) & (speed > STANDS_M_S)]
        since_s = before_s
        if len(moving):
            told_s, since_s = 0.0, float(moving.max())
        if before == now == "driving":
            told_s += now_s - since_s
        longest = max(longest, told_s)
    return longest


def stood_after_s(rows: FloatArray, moment_s: float) -> float:
    """How long after a moment the robot was last seen moving."""
    times, speed = speeds(rows)
    moving = times[(times > moment_s) & (speed > STANDS_M_S)]
    return float(moving.max()) - moment_s if len(moving) else 0.0


def judge_driver(outcome: Outcome, ended: bool) -> None:
    """`judge` for a robot behind a driver; ``ended``: its stop was the end of the program."""
    found = outcome.failures
    if outcome.drove_s > DRIVER_LIMIT_S:
        found.append(f"drove {outcome.drove_s:.2f} s after its driver's last sign of life")
    if ended and outcome.stop_s is None:
        found.append("the program did not end")
    elif ended and outcome.stop_s is not None and outcome.stop_s > END_LIMIT_S:
        found.append(f"the program ended after {outcome.stop_s:.1f} s")
    others = replace(outcome, drove_s=0.0, stop_s=0.0 if ended else outcome.stop_s, failures=[])
    judge(others)
    found += others.failures


def judge(outcome: Outcome) -> None:
    """Add a sentence to ``failures`` for each bar that was not held."""
    found = outcome.failures
    if outcome.least_gap_m < 0.0:
        found.append(f"contact: {-outcome.least_gap_m * 1e3:.0f} mm inside an obstacle")
    if outcome.drove_s > PERMIT_LIMIT_S:
        found.append(f"drove {outcome.drove_s:.2f} s after its last valid permit")
    if outcome.stop_s is None:
        found.append("stop was not answered")
    elif outcome.stop_s > STOP_LIMIT_S:
        found.append(f"stop was answered after {outcome.stop_s:.2f} s")
    if outcome.stood_s > STAND_LIMIT_S:
        found.append(f"still moved {outcome.stood_s:.2f} s after the stop order")
    if outcome.said_s > SAID_LIMIT_S:
        found.append(f"was said to drive for {outcome.said_s:.1f} s of one stand")
    if not outcome.state or len(outcome.sentence) < 10:
        found.append("the end was not said in a sentence")
