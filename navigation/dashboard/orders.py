"""Orders from viewers: read, checked against who may, and carried out as those of the socket.

Rules
- STOP is for everybody with a token, whoever holds the arena, and goes straight to the link.
- Everything else is for the operator who holds the arena.
- A stop is left by ``rearm`` only, and ``rearm`` leaves nothing but a stop: a page that has missed
  a stop cannot undo it, and a button pressed twice does not set the robot going.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from navigation.control import Commanded, carry_out
from navigation.dashboard.admission.access import TOKEN_TO_STOP
from navigation.mission.mission import State
from navigation.shared.outside import in_short

MOTIONS: Final = frozenset({"go", "pause", "resume", "rearm", "replan"})


def refusal_of(order: object, *, may_drive: bool, holds: bool, may_stop: bool = True) -> str | None:
    """Why somebody may not give this order; None where they may."""
    if order == "stop":
        return None if may_stop else TOKEN_TO_STOP
    if not isinstance(order, str) or order not in MOTIONS:
        return f"order {in_short(order)}: must be stop, go, pause, resume, rearm or replan"
    if not may_stop:
        return TOKEN_TO_STOP
    if not may_drive:
        return "this token is for looking and stopping only"
    if not holds:
        return "take the arena first"
    return None


def give(request: Mapping[str, Any], daemon: Commanded, who: str) -> dict[str, Any]:
    """Carry out an order; ``{"ok": true, ...}`` or ``{"ok": false, "error": SENTENCE}``."""
    order, whose = request.get("order"), {k: v for k, v in request.items() if k == "robot"}
    if order == "stop":
        return carry_out({"order": "stop", "reason": f"stopped by {who}", **whose}, daemon)
    # asked at this moment: what was published may be a cycle old, and a second press that fast
    told = carry_out({"order": "status", **whose}, daemon)
    if not told["ok"]:
        return told
    if order in ("rearm", "resume") and "robots" in told:
        return _give_each(order, told["robots"], daemon)
    stopped = told["state"] == State.STOPPED.value
    if order == "rearm" and not stopped:
        return {"ok": False, "error": "nothing to re-arm: the robot is not stopped"}
    if order in ("resume", "go") and stopped:
        return {"ok": False, "error": "the robot is stopped: re-arm it first"}
    if order == "rearm":
        return carry_out({"order": "resume", **whose}, daemon)
    passed = ("order", "stations", "robot")
    return carry_out({k: v for k, v in request.items() if k in passed}, daemon)


def _give_each(order: str, robots: Mapping[str, Any], daemon: Commanded) -> dict[str, Any]:
    """Re-arm all robots that are stopped, or resume all that are not."""
    wanted = order == "rearm"
    chosen = [
        name for name, one in robots.items() if (one["state"] == State.STOPPED.value) is wanted
    ]
    if not chosen:
        stopped = "no robot is" if wanted else "every robot is"
        return {"ok": False, "error": f"nothing to {order}: {stopped} stopped"}
    answers = [carry_out({"order": "resume", "robot": name}, daemon) for name in chosen]
    return next((answer for answer in answers if not answer["ok"]), answers[0])
