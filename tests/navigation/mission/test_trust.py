"""Who may drive: the levels of trust, and what a turn on the spot proves."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from navigation.mission.targets import Target
from navigation.mission.trust import (
    KNOCKED_M,
    LONGEST_PROOF_S,
    PATIENCE_S,
    PROBATION_M,
    SLOWLY_M_S,
    SLOWLY_OVER_M,
    TURN_RAD,
    Level,
    Proof,
    ProofVerdict,
    Trust,
    slow_at_first,
)
from navigation.witness import NO_EVIDENCE, Evidence

PARTED = replace(NO_EVIDENCE, parted="the camera saw nothing move")


def test_a_parting_asks_for_a_proof_and_one_on_probation_is_a_stop() -> None:
    trust = Trust()
    assert trust.look(PARTED, None) is None
    assert (trust.level, trust.why) == (Level.DOUBTED, "the camera saw nothing move")
    trust.proved(replace(NO_EVIDENCE, agreed_m=2.0))
    assert trust.look(replace(NO_EVIDENCE, agreed_m=2.5), None) is None
    said = trust.look(replace(PARTED, agreed_m=2.6), None)
    assert said == "the camera saw nothing move, 0.60 m after it had proved itself"


def test_a_parting_while_the_computer_is_late_asks_for_a_proof_even_on_probation() -> None:
    trust = Trust()
    trust.doubt("lost")
    trust.proved(NO_EVIDENCE)
    parted = replace(NO_EVIDENCE, parted="the camera saw something else")
    assert trust.look(parted, None, "this computer is too busy") is None
    assert trust.level is Level.DOUBTED
    assert trust.why == "this computer is too busy"


def test_probation_ends_after_a_metre_that_both_saw() -> None:
    trust = Trust()
    trust.doubt("lost")
    trust.proved(replace(NO_EVIDENCE, agreed_m=2.0))
    trust.look(replace(NO_EVIDENCE, agreed_m=2.0 + PROBATION_M - 0.01), None)
    assert trust.level is Level.PROBATION
    trust.look(replace(NO_EVIDENCE, agreed_m=2.0 + PROBATION_M), None)
    assert trust.level is Level.SURE


def test_a_loss_asks_for_a_proof_and_the_first_reason_stays() -> None:
    trust = Trust()
    trust.look(NO_EVIDENCE, "the robot was lost from view")
    trust.look(PARTED, None)
    assert (trust.level, trust.why) == (Level.DOUBTED, "the robot was lost from view")


@pytest.mark.parametrize(
    ("moved", "words"),
    [
        (replace(NO_EVIDENCE, slip_m=(0.4, 0.3)), "sees the robot 0.50 m from where its wheels"),
        (replace(NO_EVIDENCE, slip_rad=math.pi), "0.00 m and 180 deg from where its wheels"),
    ],
)
@pytest.mark.parametrize("level", list(Level))
def test_a_robot_far_from_where_its_wheels_brought_it_needs_a_person(
    level: Level, moved: Evidence, words: str
) -> None:
    trust = Trust()
    trust.look(NO_EVIDENCE, None)
    if level is not Level.SURE:
        trust.doubt("lost")
    if level is Level.PROBATION:
        trust.proved(NO_EVIDENCE)
    said = trust.moved(moved)
    assert said is not None
    assert words in said
    trust.vouch()
    trust.look(moved, None)
    assert trust.moved(moved) is None, "a person has looked"
    assert trust.level is Level.SURE


def test_small_knocks_while_nobody_is_sure_add_up() -> None:
    trust = Trust()
    trust.look(NO_EVIDENCE, None)
    trust.doubt("knocked")
    for step in range(1, 4):
        slip_m = (0.4 * KNOCKED_M * step, 0.0)
        trust.look(replace(NO_EVIDENCE, slip_m=slip_m), None)
        said = trust.moved(replace(NO_EVIDENCE, slip_m=slip_m))
        assert (said is None) == (step < 3)


def test_the_creep_of_a_long_drive_is_no_knock() -> None:
    trust = Trust()
    for step in range(100):
        crept = replace(NO_EVIDENCE, slip_m=(0.01 * step, 0.0))
        trust.look(crept, None)
        assert trust.moved(crept) is None


def turned(wheels_rad: float, camera_rad: float, **more: object) -> Evidence:
    return replace(NO_EVIDENCE, wheels_rad=wheels_rad, camera_rad=camera_rad, **more)  # type: ignore[arg-type]


def test_a_turn_that_both_saw_proves_the_robot_once_it_stands() -> None:
    proof = Proof(9, 0.0, turned(5.0, -3.0))
    both = turned(5.0 + TURN_RAD, -3.0 + TURN_RAD)
    assert proof.judge(0.5, both, False)[0] is ProofVerdict.OPEN
    assert proof.judge(0.6, replace(both, wheels_stand=False), True)[0] is ProofVerdict.OPEN
    assert proof.judge(0.7, both, True)[0] is ProofVerdict.PROVED


def test_pictures_may_be_late_but_not_for_ever() -> None:
    proof = Proof(9, 0.0, NO_EVIDENCE)
    wheels_only = turned(TURN_RAD, 0.0)
    assert proof.judge(1.0, wheels_only, True)[0] is ProofVerdict.OPEN
    assert proof.judge(1.0 + PATIENCE_S, wheels_only, True)[0] is ProofVerdict.OPEN
    verdict, said = proof.judge(1.1 + PATIENCE_S, wheels_only, True)
    assert verdict is ProofVerdict.REFUTED
    assert "its wheels turned it 20 deg, the camera saw 0 deg" in said


@pytest.mark.parametrize(
    ("evidence", "done", "verdict"),
    [
        (turned(2.1 * TURN_RAD, 0.0, wheels_stand=False), False, ProofVerdict.REFUTED),
        (turned(TURN_RAD, TURN_RAD, driven_m=0.03), True, ProofVerdict.REFUTED),
        (turned(0.1, 0.1), False, ProofVerdict.STILL),
        (turned(0.1, 0.1), True, ProofVerdict.STILL),
    ],
    ids=["turns on and on", "drives about", "does not turn", "says that it has"],
)
def test_what_is_no_proof(evidence: Evidence, done: bool, verdict: ProofVerdict) -> None:
    proof = Proof(9, 0.0, NO_EVIDENCE)
    proof.judge(0.5, evidence, done)
    assert proof.judge(LONGEST_PROOF_S + 0.1, evidence, done)[0] is verdict


def test_proofs_turn_to_the_left_and_the_right_where_the_robot_is() -> None:
    trust = Trust()
    (first,), (second,) = trust.turn((0.3, 0.4), 3.0), trust.turn((0.3, 0.4), 3.0)
    assert (first.x_m, first.y_m, first.stops) == (0.3, 0.4, True)
    assert first.heading_rad == pytest.approx(3.0 + TURN_RAD - math.tau)
    assert second.heading_rad == pytest.approx(3.0 - TURN_RAD)


def test_the_first_piece_of_a_way_on_probation_is_slow() -> None:
    targets = [Target(0.05 * i, 0.0, 0.3, stops=i == 10) for i in range(1, 11)]
    slowed = slow_at_first((0.0, 0.0), targets)
    early = round(SLOWLY_OVER_M / 0.05)
    assert [t.speed_m_s for t in slowed[:early]] == [SLOWLY_M_S] * early
    assert [t.speed_m_s for t in slowed[early:]] == [0.3] * (10 - early)
    assert slow_at_first((0.0, 0.0), targets[9:])[0].speed_m_s == SLOWLY_M_S
