"""Trust that the robot seen is the one whose wheels turn, and its proof.

- SURE: a person has armed the robot, or camera and wheels have agreed for ``PROBATION_M``.
- DOUBTED: they differed, the motion was not seen, or it may be another robot. It may only prove
  itself: turn a little on the spot, which leaves its disc in place, and be seen to turn as its
  wheels do.
- PROBATION: it has proved itself and drives, slowly at first. A difference is now a stop.

A robot seen far from where its wheels brought it always needs a person. One that cannot turn on the
spot proves itself by the first, slow piece of its path. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

from navigation.mission.targets import Target
from navigation.witness import Evidence

TURN_RAD: Final = 0.35
"""Clearly more than the camera's noise and the follower's tolerance."""
TURNED: Final = 0.7
"""Share of the turn that must be made; the rest is the follower's business."""
TURN_SLACK_RAD: Final = 0.1
TURN_ERROR: Final = 0.1
SLOWLY_M_S: Final = 0.08
SLOWLY_OVER_M: Final = 0.2
"""Braking from this speed takes 6 mm at 0.5 m/s2."""
PROBATION_M: Final = 1.0
ON_THE_SPOT_M: Final = 0.025
"""A turn on the spot drives a few millimetres; with more, the place itself moves."""
APART_RAD: Final = 2.0 * TURN_RAD
"""Late pictures of a whole turn make less; a frozen one lets the robot turn for ever."""
PATIENCE_S: Final = 3.0
"""Time that pictures may take to show the turn: longer than any latency measured."""
LONGEST_PROOF_S: Final = 8.0
BEGINS_WITHIN_S: Final = 3.0
"""A robot whose wheels have not turned by then will not turn."""
BEGUN_RAD: Final = 0.02
KNOCKED_M: Final = 0.1
KNOCKED_RAD: Final = 0.7
"""A robot knocked no further may prove itself; farther from where its wheels brought it, it was
carried or is seen wrongly, and a person must look."""
NEAR_M: Final = 0.02
"""The robot's own estimate has followed the camera when they are this near; otherwise it would
drive to the place of its turn."""


class Level(Enum):
    """Trust in the robot's identity."""

    SURE = "sure"
    DOUBTED = "doubted"
    PROBATION = "probation"


class ProofVerdict(Enum):
    """Result of a proof."""

    OPEN = "not decided yet"
    PROVED = "camera and wheels turned alike"
    REFUTED = "the wheels turned, the camera saw something else"
    STILL = "the wheels did not turn"


@dataclass(slots=True)
class Proof:
    """A turn on the spot under way: its mission on the wire, and the evidence before it."""

    mission_id: int
    began_s: float
    before: Evidence
    stands_since_s: float | None = None

    def judge(self, now_s: float, evidence: Evidence, done: bool) -> tuple[ProofVerdict, str]:
        """Judge the turn so far; return a sentence for a failed proof.

        ``done``: the robot reports that it has turned.
        """
        wheels_rad = evidence.wheels_rad - self.before.wheels_rad
        camera_rad = evidence.camera_rad - self.before.camera_rad
        driven_m = evidence.driven_m - self.before.driven_m
        if driven_m > ON_THE_SPOT_M:
            return ProofVerdict.REFUTED, (
                f"the robot did not prove itself: it drove {driven_m:.3f} m where it was to turn "
                "on the spot; the camera moves it about"
            )
        turned = abs(wheels_rad) >= TURNED * TURN_RAD
        if not (done and evidence.wheels_stand):
            self.stands_since_s = None
        elif self.stands_since_s is None:
            self.stands_since_s = now_s
        stands = self.stands_since_s is not None
        alike = abs(camera_rad - wheels_rad) <= TURN_SLACK_RAD + TURN_ERROR * abs(wheels_rad)
        if stands and turned and alike:
            return ProofVerdict.PROVED, ""
        waited = self.stands_since_s is not None and now_s - self.stands_since_s > PATIENCE_S
        if (waited and turned) or abs(camera_rad - wheels_rad) > APART_RAD:
            return ProofVerdict.REFUTED, (
                f"the robot did not prove itself: its wheels turned it "
                f"{math.degrees(wheels_rad):.0f} deg, the camera saw {math.degrees(camera_rad):.0f}"
                " deg: a frozen picture, another robot's marker, or wheels that slip"
            )
        over_s = BEGINS_WITHIN_S if abs(wheels_rad) < BEGUN_RAD else LONGEST_PROOF_S
        if waited or now_s - self.began_s > over_s:
            return ProofVerdict.STILL, "the robot did not turn when it had to prove itself"
        return ProofVerdict.OPEN, ""


class Trust:
    """The level and its reason; `look` once a cycle, before any decision."""

    def __init__(self) -> None:
        self.level = Level.SURE
        self.why = ""
        """Why the robot is doubted; empty while it is not."""
        self.proofs = 0
        self._since_m = 0.0
        self._slip_m, self._slip_rad = (0.0, 0.0), 0.0
        self._may_be_another = False

    def arm(self) -> None:
        """Trust the robot fully."""
        self.level, self.why = Level.SURE, ""
        self._may_be_another = False

    def vouch(self) -> None:
        """Trust a person, who has seen the robot where the camera shows it."""
        self.arm()

    def doubt(self, why: str) -> None:
        """Ask for a proof; the first reason stays."""
        if self.level is not Level.DOUBTED:
            self.level, self.why = Level.DOUBTED, why

    def may_be_another(self, why: str) -> None:
        """Ask for a proof of a robot whose place is not known from its wheels.

        A doubted one keeps the place where it was trusted last.
        """
        self._may_be_another |= self.level is not Level.DOUBTED
        self.doubt(why)

    def look(self, evidence: Evidence, lost: str | None, late: str | None = None) -> str | None:
        """Take new evidence; return a stop's sentence if a robot on probation differs again.

        ``lost``: why the robot's motion was not seen. ``late``: why pictures or reports may be
        dated late, so that a difference only asks for a proof.
        """
        if evidence.parted is not None and late is not None:
            self.doubt(late)
        elif evidence.parted is not None:
            if self.level is Level.PROBATION:
                driven_m = evidence.agreed_m - self._since_m
                return f"{evidence.parted}, {driven_m:.2f} m after it had proved itself"
            self.doubt(evidence.parted)
        elif lost is not None:
            self.doubt(lost)
        elif self.level is Level.PROBATION and evidence.agreed_m - self._since_m >= PROBATION_M:
            self.arm()
        if self.level is Level.SURE or self._may_be_another:
            self._slip_m, self._slip_rad = evidence.slip_m, evidence.slip_rad
        return None

    def moved(self, evidence: Evidence) -> str | None:
        """Sentence about a robot at rest too far from where its wheels brought it, or None.

        It was carried, or the camera shows it wrongly; no motion separates the two. Ask once the
        pictures have caught up.
        """
        self._may_be_another = False
        off_m = math.dist(evidence.slip_m, self._slip_m)
        off_rad = abs(math.remainder(evidence.slip_rad - self._slip_rad, math.tau))
        if off_m <= KNOCKED_M and off_rad <= KNOCKED_RAD:
            return None
        turned = f" and {math.degrees(off_rad):.0f} deg" if off_rad > KNOCKED_RAD else ""
        return (
            f"the camera sees the robot {off_m:.2f} m{turned} from where its wheels brought it: "
            "it was carried or is stuck, or the picture is frozen or shows another robot; look, "
            "then re-arm it"
        )

    def proved(self, evidence: Evidence) -> None:
        """Begin probation after a proof."""
        self.level, self.why, self._since_m = Level.PROBATION, "", evidence.agreed_m

    def turn(
        self,
        here: tuple[float, float],
        heading_rad: float,
    ) -> tuple[Target, ...]:
        """Next proof: a turn at the robot's own estimate, to the other side each time."""
        self.proofs += 1
        side = 1.0 if self.proofs % 2 else -1.0
        towards = math.remainder(heading_rad + side * TURN_RAD, math.tau)
        return (Target(*here, SLOWLY_M_S, stops=True, heading_rad=towards),)


def slow_at_first(here: tuple[float, float], targets: Sequence[Target]) -> tuple[Target, ...]:
    """Targets with at most ``SLOWLY_M_S`` over the first ``SLOWLY_OVER_M``."""
    slowed, gone_m, before = [], 0.0, here
    for target in targets:
        early = gone_m < SLOWLY_OVER_M
        speed_m_s = min(target.speed_m_s, SLOWLY_M_S) if early else target.speed_m_s
        slowed.append(replace(target, speed_m_s=speed_m_s))
        gone_m += math.dist(before, (target.x_m, target.y_m))
        before = (target.x_m, target.y_m)
    return tuple(slowed)
