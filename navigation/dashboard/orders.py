"""Orders from viewers: read, checked for permission, and carried out like the socket's.

Rules
- Anyone with a token may STOP; it goes straight to the link. Every other change is for the operator
  who holds the arena.
- Only ``rearm`` leaves a stop, and it does nothing else: a page that has missed a stop cannot undo
  it, and a button pressed twice does not set the robot going.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from navigation.dashboard.admission.access import TOKEN_TO_STOP
from navigation.mission.mission import MissionProgress, State
from navigation.orders.carry_out import carry_out
from navigation.orders.table import ORDERS, Who
from navigation.shared.outside import finite_number, in_short, printable

if TYPE_CHECKING:
    from navigation.loop.people import People

REARM: Final = "rearm"
WHO: Final[Mapping[str, Who]] = {
    **{name: order.who for name, order in ORDERS.items() if order.who is not Who.SOCKET},
    REARM: Who.OPERATOR,
}
SAID_CHARACTERS: Final = 40
"""Characters of a name in the log."""
ZONE_ORDERS: Final = frozenset(("zone_put", "zone_remove", "zone_undo"))
BUTTONS: Final = {name: order.button for name, order in ORDERS.items() if order.button is not None}


def refusal_of(order: object, *, may_drive: bool, holds: bool, may_stop: bool = True) -> str | None:
    """Reason for refusing this order; None if it is allowed."""
    who = WHO.get(order) if isinstance(order, str) else None
    if who is None:
        *names, last = WHO
        return f"order {in_short(order)}: must be {', '.join(names)} or {last}"
    if not may_stop:
        return TOKEN_TO_STOP
    if who is Who.ANYONE:
        return None
    if not may_drive:
        return "this token is for looking and stopping only"
    if not holds:
        return "take control first"
    return None


def give(request: Mapping[str, Any], people: People, who: str) -> dict[str, Any]:
    """Carry out an order; return ``ok``, and ``error`` with a sentence."""
    name, whose = request.get("order"), {k: v for k, v in request.items() if k == "robot"}
    if name == "stop":
        return carry_out({"order": "stop", "reason": f"stopped by {who}", **whose}, people)
    # asked now: the published state may be a cycle old, and a second press that fast
    status = carry_out({"order": "status", **whose}, people)
    if not status["ok"]:
        return status
    if name in (REARM, "resume") and "robots" in status:
        return _give_each(name, status["robots"], people)
    stopped = status["state"] == State.STOPPED.value
    if name == REARM:
        if not stopped:
            return {"ok": False, "error": "nothing to re-arm: the robot is not stopped"}
        return carry_out({"order": "resume", **whose}, people)
    order = ORDERS.get(name) if isinstance(name, str) and name in WHO else None
    if order is None:
        return {"ok": False, "error": f"order {in_short(name)}: is none of the page's"}
    if order.sets_going and stopped:
        return {"ok": False, "error": "the robot is stopped: re-arm it first"}
    zone = request.get("zone")
    if name == "zone_put" and isinstance(zone, dict) and "mask" in zone:
        # a page may name no file of this computer
        sentence = "zone: mask: a file is named in the configuration, not on the page"
        return {"ok": False, "error": sentence}
    passed = ("order", "robot", *order.arguments)
    return carry_out({k: v for k, v in request.items() if k in passed}, people)


def _give_each(order: str, robots: Mapping[str, Any], people: People) -> dict[str, Any]:
    """Re-arm all stopped robots, or resume all others."""
    wanted = order == REARM
    chosen = [
        name for name, one in robots.items() if (one["state"] == State.STOPPED.value) is wanted
    ]
    if not chosen:
        stopped = "no robot is" if wanted else "every robot is"
        return {"ok": False, "error": f"nothing to {order}: {stopped} stopped"}
    answers = [carry_out({"order": "resume", "robot": name}, people) for name in chosen]
    return next((answer for answer in answers if not answer["ok"]), answers[0])


def order_told(message: Mapping[str, Any]) -> str:
    """Line of the log for an admitted order."""
    robot = message.get("robot")
    whom = f"{printable(robot, SAID_CHARACTERS)}: " if isinstance(robot, str) else ""
    return whom + _without_robot(message)


def _without_robot(message: Mapping[str, Any]) -> str:
    if message.get("order") in ZONE_ORDERS:
        return _zone_order_told(message)
    if message.get("order") != "go" or not isinstance(message.get("stations"), list):
        return str(message.get("order")).upper()  # only admitted orders get here
    stations = message["stations"]
    last = stations[-1] if stations and isinstance(stations[-1], dict) else {}
    x, y = (finite_number(last.get(name)) for name in ("x_m", "y_m"))
    if x is None or y is None:
        return "GO"
    more = f" by {len(stations) - 1} more" if len(stations) > 1 else ""
    return f"GO to ({x:.3f}, {y:.3f}) m{more}"


def _zone_order_told(message: Mapping[str, Any]) -> str:
    zone = message.get("zone")
    name = zone.get("name") if isinstance(zone, dict) else message.get("name")
    which = f" '{printable(name, SAID_CHARACTERS)}'" if isinstance(name, str) else ""
    return str(message["order"]).replace("_", " ").upper() + which


def cannot(mission: MissionProgress) -> dict[str, str]:
    """Buttons that would do nothing for a mission, with the reason."""
    if mission.state is State.STOPPED:
        return dict.fromkeys(BUTTONS, "the robot is stopped; re-arm it first")
    reasons = {name: button.why_not(mission) for name, button in BUTTONS.items()}
    return {name: reason for name, reason in reasons.items() if reason}


def buttons() -> str:
    """HTML of the orders' buttons."""
    quiet = {True: ' class="quiet"', False: ""}
    return "\n        ".join(
        f'<button id="{name}" type="button"{quiet[button.is_quiet]}>{button.label}</button>'
        for name, button in BUTTONS.items()
    )
