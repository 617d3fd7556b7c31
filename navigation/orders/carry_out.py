"""Orders from outside: checked, carried out by the run, answered.

A request is ``{"order": NAME, ...}``; an answer is ``{"ok": true, ...}`` or ``{"ok": false,
"error": SENTENCE}``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from navigation.mission.mission import MissionError
from navigation.orders.arguments import READERS, read_robot
from navigation.orders.errors import ControlError
from navigation.orders.table import ORDERS, Order
from navigation.shared.outside import in_short

if TYPE_CHECKING:
    from navigation.loop.people import People

SCHEMA: Final = "clearway.status/1"
"""Schema of the answer to an order that was taken."""


def carry_out(request: Mapping[str, Any], people: People) -> dict[str, Any]:
    """Carry out a request; return the answer, a refusal too."""
    try:
        order = _order_of(request)
        robot = read_robot(request)
        given = {name: READERS[name](request, people) for name in order.arguments}
        further = order.act(people, robot, given) or {}
        status = people.describe(robot)
    except (ControlError, MissionError) as error:
        return {"ok": False, "error": str(error)}
    return {"schema": SCHEMA, "ok": True, **status, **further}


def _order_of(request: Mapping[str, Any]) -> Order:
    name = request.get("order")
    order = ORDERS.get(name) if isinstance(name, str) else None
    if order is None:
        *names, last = ORDERS
        raise ControlError(f"order {in_short(name)}: must be {', '.join(names)} or {last}")
    return order
