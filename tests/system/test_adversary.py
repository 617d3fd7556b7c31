"""The standing judge: it sees what it has to see, and a few of its attacks on the real program.

`make adversary` runs all of them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.adversary.attacks import ATTACKS, QUICK
from benchmarks.adversary.attacks.attack import Attack
from benchmarks.adversary.bars import (
    Moment,
    Outcome,
    blind_m,
    drove_without_permit_s,
    judge,
    least_gap_m,
    said_to_drive_s,
    stood_after_s,
)
from benchmarks.adversary.run import prepare, run_attack
from navigation.simulator.arena import SimulatedArena
from planner.formats.scene_io import read_scene_text

SPEED_M_S, BRAKING_M_S2 = 0.3, 0.5
PERMITS_S = [0.1 * n for n in range(51)]
"""Ten a second, the last at 5 s."""


def driven(braking_from_s: float, until_s: float = 12.0) -> np.ndarray:
    """A track along x at full speed that brakes from a moment on; 200 rows a second."""
    times = np.arange(0.0, until_s, 0.005)
    speed = np.clip(SPEED_M_S - BRAKING_M_S2 * (times - braking_from_s), 0.0, SPEED_M_S)
    x = np.cumsum(speed) * 0.005
    return np.column_stack([times, x, np.zeros_like(x), np.zeros_like(x)])


# The judge sees.


@pytest.mark.parametrize("late_s", [0.2, 0.5, 0.8, 2.0])
def test_driving_on_after_the_last_permit_is_measured_without_the_braking(late_s: float) -> None:
    found = drove_without_permit_s(driven(5.0 + late_s), Moment(PERMITS_S))
    assert found == pytest.approx(late_s, abs=0.08)


def test_a_robot_that_sets_off_without_a_permit_is_found() -> None:
    stands = driven(2.0)
    leaps = stands.copy()
    late = leaps[:, 0] > 9.0
    leaps[late, 1] += 0.1 * (leaps[late, 0] - 9.0)
    assert drove_without_permit_s(stands, Moment(PERMITS_S)) < 0.55
    assert drove_without_permit_s(leaps, Moment(PERMITS_S)) > 3.5


def test_turning_on_the_spot_is_motion_too() -> None:
    track = driven(-1.0)
    track[:, 3] = np.where(track[:, 0] > 7.0, np.remainder(track[:, 0] - 7.0, math.pi), 0.0)
    assert drove_without_permit_s(track, Moment(PERMITS_S)) > 1.5


def test_what_a_hand_does_is_no_fault_of_the_program() -> None:
    track = driven(4.0)
    track[track[:, 0] > 8.0, 2] += 0.5
    assert drove_without_permit_s(track, Moment(PERMITS_S)) > 2.0
    by_hand = [(7.9, 8.1)]
    assert drove_without_permit_s(track, Moment(PERMITS_S, by_hand)) < 0.55
    arena = SimulatedArena(
        read_scene_text(
            "#@ clearway.scene/1\n#@ units m\n#@ bounds given -9 -9 9 9\nC (1.2,0.5) 0.1", "t"
        )
    )
    assert least_gap_m(track, arena, 0.09, []) < 0.0
    assert least_gap_m(track, arena, 0.09, [(7.9, 12.0)]) > 0.0


def test_a_frozen_robot_may_brake_when_it_is_back() -> None:
    back_s, slept_s = 7.0, 2.0
    track = driven(5.1)
    own_s = np.interp(track[:, 0], [0.0, back_s - slept_s, back_s, 99.0], [0.0, 5.0, 5.0, 97.0])
    track[:, 1] = np.interp(own_s, driven(5.1)[:, 0], driven(5.1)[:, 1])
    asleep = [(back_s - slept_s, back_s)]
    assert drove_without_permit_s(track, Moment(PERMITS_S)) > 1.5
    assert drove_without_permit_s(track, Moment(PERMITS_S, halted_s=asleep)) < 0.65


def test_the_way_that_the_program_does_not_see_is_measured() -> None:
    track = driven(8.0)
    seen = [(0.1 * n, SPEED_M_S * (0.1 * n - 0.02), 0.0) for n in range(80)]
    frozen = [(when_s, min(x, 1.2), y) for when_s, x, y in seen]
    assert blind_m(track, seen) == 0.0
    assert blind_m(track, frozen) == pytest.approx(1.2 - 0.1 + 0.09, abs=0.05)


def test_a_robot_that_stands_must_not_be_said_to_drive() -> None:
    track = driven(5.0)
    driving = [(0.5 * n, "driving") for n in range(22)]
    held = [(at_s, said if at_s < 7.0 else "holding") for at_s, said in driving]
    assert said_to_drive_s(track, driving) == pytest.approx(10.5 - 5.6, abs=0.1)
    assert said_to_drive_s(track, held) == pytest.approx(6.5 - 5.6, abs=0.1)


def test_a_state_that_flutters_while_the_robot_stands_counts_all_together() -> None:
    flutters = [(0.5 * n, "holding" if n % 5 == 4 else "driving") for n in range(24)]
    # it stands from 5.6 s on: 0.9 s until it is said to hold, and twice 1.5 s
    assert said_to_drive_s(driven(5.0), flutters) == pytest.approx(0.9 + 3.0, abs=0.1)


def test_the_time_to_a_stand_counts_from_the_stop_order() -> None:
    assert stood_after_s(driven(5.0), 5.0) == pytest.approx(0.6, abs=0.05)
    assert stood_after_s(driven(5.0), 6.0) == 0.0


def test_every_bar_that_is_not_held_is_said() -> None:
    good = Outcome("x", 1, 0.05, 0.1, 0.2, 0.3, 0.0, 0.5, "holding", "no picture from the camera")
    bad = Outcome("x", 1, -0.05, None, 2.0, 0.9, 0.0, 4.0, "", "")
    slow = Outcome("x", 1, 0.05, 0.4, 0.2, 0.3, 0.0, 0.5, "holding", "no picture from the camera")
    for outcome in (good, bad, slow):
        judge(outcome)
    assert good.failures == []
    assert len(bad.failures) == 6
    assert slow.failures == ["stop was answered after 0.40 s"]


def test_no_two_attacks_have_one_name() -> None:
    names = [(one.kind, one.name) for one in ATTACKS]
    assert len(set(names)) == len(names)
    assert {kind for kind, _ in names} == {
        "line", "camera", "process", "driver", "flood", "disk",
    }  # fmt: skip


# The program holds.


@pytest.fixture(scope="module")
def compiled() -> None:
    prepare()


@pytest.mark.slow
@pytest.mark.timed  # says how far a robot drives, in real time
@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("attack", QUICK, ids=lambda one: f"{one.kind}: {one.name}")
def test_the_program_holds_every_bar(attack: Attack) -> None:
    outcome = run_attack(attack, seed=1)
    assert outcome.failures == [], outcome
