"""Random runs among zones whose robots once broke a rule, and a judge that finds one that does."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.zones.judge import violations
from benchmarks.zones.random_runs import judged_run
from navigation.config.zones import ZoneSection


@pytest.mark.parametrize("seed", [50, 89, 95, 298])
def test_runs_that_once_broke_a_rule_keep_all(seed: int) -> None:
    """A wait in a zone drawn later, a promise continued into one, two stops in a slow one.

    In the first, a robot stops inside a no-waiting zone for a zone that is drawn elsewhere.
    """
    run = judged_run(seed)
    assert run.arrived == run.robots
    assert run.violations == ()


def straight(speed_m_s: float) -> np.ndarray:
    """A robot's true track from (0, 0) to (2, 0), a row each 10 ms."""
    times = np.arange(0.0, 2.0 / speed_m_s, 0.01)
    return np.column_stack([times, speed_m_s * times, 0.0 * times, 0.0 * times])


@pytest.mark.parametrize(
    ("keys", "broken"),
    [
        ({"kind": "keep_out", "circle": (1.0, 0.2, 0.15)}, True),
        ({"kind": "keep_out", "circle": (1.0, 0.3, 0.15)}, False),
        ({"kind": "slow", "circle": (1.0, 0.0, 0.3), "speed_m_s": 0.15}, True),
        ({"kind": "slow", "circle": (1.0, 0.0, 0.3), "speed_m_s": 0.25}, False),
        ({"kind": "one_way", "line": ((2.0, 0.0), (0.0, 0.0)), "width_m": 0.3}, True),
        ({"kind": "one_way", "line": ((0.0, 0.0), (2.0, 0.0)), "width_m": 0.3}, False),
        ({"kind": "one_way", "line": ((1.0, -1.0), (1.0, 1.0)), "width_m": 0.3}, False),
        ({"kind": "wait", "circle": (1.0, 0.0, 0.2)}, False),
    ],
)
def test_the_judge_finds_what_breaks_a_rule_and_nothing_else(
    keys: dict[str, object], broken: bool
) -> None:
    zone = ZoneSection.model_validate({"name": "z", **keys})
    assert bool(violations(zone, "a", 0.1, straight(0.2), 0.0)) == broken


def test_the_judge_finds_one_that_waits_in_a_no_waiting_zone() -> None:
    zone = ZoneSection.model_validate({"name": "z", "kind": "wait", "circle": (1.0, 0.0, 0.2)})
    track = straight(0.2)
    half = len(track) // 2
    stands = np.repeat(track[half : half + 1], 100, axis=0)
    stands[:, 0] += 0.01 * np.arange(100)
    after = np.add(track[half:], (1.0, 0.0, 0.0, 0.0))
    (found,) = violations(zone, "a", 0.1, np.vstack([track[:half], stands, after]), 0.0)
    assert found.kind == "wait"


@pytest.mark.parametrize(
    ("rest_s", "drawn_before_s", "broken"),
    [(2.0, 0.5, False), (4.0, 0.5, True), (2.0, 1.5, True), (2.0, -0.1, True)],
)
def test_a_stop_for_a_zone_just_drawn_is_no_wait_until_there_is_a_plan(
    rest_s: float, drawn_before_s: float, broken: bool
) -> None:
    zone = ZoneSection.model_validate({"name": "z", "kind": "wait", "circle": (1.0, 0.0, 0.2)})
    track = straight(0.2)
    half = len(track) // 2
    stands = np.repeat(track[half : half + 1], int(100 * rest_s), axis=0)
    stands[:, 0] += 0.01 * np.arange(len(stands))
    after = np.add(track[half:], (rest_s, 0.0, 0.0, 0.0))
    drawn_s = (track[half, 0] - drawn_before_s,)
    whole = np.vstack([track[:half], stands, after])
    assert bool(violations(zone, "a", 0.1, whole, 0.0, drawn_s)) == broken
