"""The states of the host's end of the link, as a table: ``TRANSITIONS[state, event]``.

CLOSED: no port. HELLO: asking for a robot. VERIFY: a robot has answered; its mission is compared
with ours. STREAM: up. DRAIN: up, the robot has the whole mission. LINK_LOST: it fell silent; asking
again. REBOOTED: up, but the robot's memory is gone; its mission is void. REFUSED: a robot of
another version or schema has answered. A missing pair is a mistake of this program.
"""

from __future__ import annotations

from enum import Enum
from typing import Final

from firmware_protocol.wire.errors import LocalError


class LinkState(Enum):
    """State of the link."""

    CLOSED = "closed"
    HELLO = "hello"
    VERIFY = "verify"
    STREAM = "stream"
    DRAIN = "drain"
    LINK_LOST = "link lost"
    REBOOTED = "rebooted"
    REFUSED = "refused"

    @property
    def is_up(self) -> bool:
        """True if frames of the session flow both ways."""
        return self in _UP

    @property
    def is_asking(self) -> bool:
        """True if no usable robot has answered yet."""
        return self in _ASKING


class LinkEvent(Enum):
    """Events of the link."""

    OPEN = "the port was opened"
    CLOSE = "the port was closed"
    GREETED = "HELLO_ACK of our session, same schema"
    REFUSED = "HELLO_ACK with another version or schema"
    VERIFIED = "first STATUS of the session; the mission's prefix agrees or there is none"
    REBOOT = "first STATUS of the session; another boot_id than before"
    ALL_ACCEPTED = "the robot has the whole mission"
    MISSION_OVER = "mission executed, void, or replaced"
    SILENCE = "no frame of the session, or no refusal, for too long"
    RENEW = "a fresh session is wanted, to leave an emergency stop"


_EMPTIED: Final = (LinkState.DRAIN, LinkState.REBOOTED)
"""States that a mission's end turns into STREAM."""
_UP: Final = (LinkState.STREAM, LinkState.DRAIN, LinkState.REBOOTED)
_ASKING: Final = (LinkState.HELLO, LinkState.LINK_LOST, LinkState.REFUSED)

TRANSITIONS: Final[dict[tuple[LinkState, LinkEvent], LinkState]] = {
    (LinkState.CLOSED, LinkEvent.OPEN): LinkState.HELLO,
    **{(state, LinkEvent.GREETED): LinkState.VERIFY for state in _ASKING},
    **{(state, LinkEvent.REFUSED): LinkState.REFUSED for state in _ASKING},
    (LinkState.REFUSED, LinkEvent.SILENCE): LinkState.HELLO,
    (LinkState.VERIFY, LinkEvent.VERIFIED): LinkState.STREAM,
    (LinkState.VERIFY, LinkEvent.REBOOT): LinkState.REBOOTED,
    (LinkState.VERIFY, LinkEvent.SILENCE): LinkState.LINK_LOST,
    (LinkState.STREAM, LinkEvent.ALL_ACCEPTED): LinkState.DRAIN,
    (LinkState.DRAIN, LinkEvent.ALL_ACCEPTED): LinkState.DRAIN,
    (LinkState.DRAIN, LinkEvent.MISSION_OVER): LinkState.STREAM,
    (LinkState.REBOOTED, LinkEvent.MISSION_OVER): LinkState.STREAM,
    **{(state, LinkEvent.MISSION_OVER): state for state in LinkState if state not in _EMPTIED},
    **{(state, LinkEvent.SILENCE): LinkState.LINK_LOST for state in _UP},
    **{(state, LinkEvent.RENEW): LinkState.HELLO for state in _UP},
    **{(state, LinkEvent.CLOSE): LinkState.CLOSED for state in LinkState},
}


def state_after(state: LinkState, event: LinkEvent) -> LinkState:
    """State after an event; LocalError for one that cannot happen."""
    if (state, event) not in TRANSITIONS:
        raise LocalError(f"{event.name} ({event.value}) cannot happen to a link in {state.name}")
    return TRANSITIONS[state, event]
