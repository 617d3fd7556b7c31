"""Proof of a doubted robot: it turns on the spot, and the camera must see it turn.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from navigation.mission.cycle import RobotReport, Sight
from navigation.mission.mission import Event
from navigation.mission.targets import Target
from navigation.mission.trust import NEAR_M, Proof, ProofVerdict, Trust
from navigation.witness import Evidence

LATE_S: Final = 1.0
"""Time that wheels must be at rest before a proof, for pictures to catch up."""


class ProofStep(NamedTuple):
    """Orders of one cycle of a proof; empty while it continues."""

    event: Event | None = None
    sentence: str = ""
    stop: str | None = None
    """Why the robot has to be stopped."""
    targets: tuple[Target, ...] | None = None
    """The turn to drive."""


_NOTHING = ProofStep()


class Proving:
    """The proof under way, if any.

    ``turns_on_spot`` is False if the robot cannot turn so: it is then put on probation at rest
    where its wheels brought it.
    """

    def __init__(self, trust: Trust, turns_on_spot: bool) -> None:
        self._trust, self._turns_on_spot = trust, turns_on_spot
        self._proof: Proof | None = None
        self._stood_s = self._asked_s = -math.inf
        """Since when the wheels are at rest, and the last time of asking."""

    def begin(self, now_s: float, mission_id: int, sight: Sight, robot: RobotReport) -> ProofStep:
        """Let a doubted robot turn as mission ``mission_id``, once it can be asked to."""
        trust, evidence = self._trust, sight.evidence
        if not self._pictures_have_caught_up(now_s, evidence):
            return _NOTHING
        if sight.pose is None or robot.place_m is None:
            return _NOTHING
        stop = trust.moved(evidence)
        if stop is not None:
            return ProofStep(stop=stop)
        if not self._turns_on_spot:
            trust.proved(evidence)
            return _NOTHING
        if math.dist(robot.place_m, sight.pose[:2]) > NEAR_M:
            return _NOTHING
        self._proof = Proof(mission_id, now_s, evidence)
        return ProofStep(
            Event.PROVE,
            f"{trust.why}: the robot turns a little to prove itself",
            targets=trust.turn(robot.place_m, sight.pose[2]),
        )

    def _pictures_have_caught_up(self, now_s: float, evidence: Evidence) -> bool:
        if not evidence.wheels_stand or now_s - self._asked_s > LATE_S:
            self._stood_s = now_s
        self._asked_s = now_s
        return now_s - self._stood_s >= LATE_S

    def judge(self, now_s: float, sight: Sight, robot: RobotReport) -> ProofStep:
        """Judge the turn under way."""
        assert self._proof is not None
        evidence = sight.evidence
        done = robot.mission_id == self._proof.mission_id and robot.executed >= 1
        verdict, sentence = self._proof.judge(now_s, evidence, done)
        match verdict:
            case ProofVerdict.PROVED:
                stop = self._trust.moved(evidence)
                if stop is not None:
                    return ProofStep(stop=stop)
                self._trust.proved(evidence)
                return ProofStep(Event.PROVED, "the robot has proved itself")
            case ProofVerdict.REFUTED:
                return ProofStep(stop=sentence)
            case ProofVerdict.STILL:
                return ProofStep(Event.HOLD, f"{sentence}: {self._trust.why}")
            case ProofVerdict.OPEN:
                return _NOTHING
