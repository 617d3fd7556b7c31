"""Access to the dashboard: host names, origins and tokens. Opens nothing.

Rules
- The Host must be an address or a name of this machine: a foreign page whose name points here (DNS
  rebinding) is refused with 400.
- The Origin, if a browser sends one, must be the Host itself: else 403.
- If a token is configured, everything but the page's own files and /healthz needs one.
- Otherwise the program has its own token: without it one may look, not stop or drive.
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections import Counter
from dataclasses import dataclass
from enum import Enum
from urllib.parse import urlsplit

from starlette.responses import PlainTextResponse, Response

from navigation.config.dashboard import DashboardSection

PROTOCOL = "clearway.1"
"""A token travels beside it as ``token.TOKEN``."""
LOCAL_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})


TOKEN_TO_STOP = "stopping and driving need the token: open the link that 'clearway run' has printed"


class Role(Enum):
    """Rights of a visitor, ascending."""

    VISITOR = "visitor"
    """Look, where that needs no token."""
    VIEWER = "viewer"
    """Look and stop."""
    OPERATOR = "operator"
    """Look, stop, and drive while in control."""
    SUPERVISOR = "supervisor"
    """The same, and take control from its holder."""

    @property
    def may_drive(self) -> bool:
        """True for those who may take control."""
        return self in (Role.OPERATOR, Role.SUPERVISOR)

    def may_less_than(self, other: Role) -> bool:
        """True if the other may do more."""
        ranks = list(Role)
        return ranks.index(self) < ranks.index(other)


@dataclass(frozen=True, slots=True)
class Refusal:
    """Reason for turning a visitor away: HTTP status, kind for the count, sentence."""

    status: int
    kind: str
    sentence: str


class AccessGate:
    """Admits or turns away, and counts refusals by kind.

    ``own_token`` replaces ``dashboard.token`` if none is configured; without either anyone who can
    reach the page may drive.
    """

    def __init__(self, section: DashboardSection, own_token: str | None = None) -> None:
        self._section = section
        self._token = section.token or own_token
        self._names = {name.lower() for name in section.names}
        if not section.is_local:
            host = socket.gethostname().lower()
            self._names |= {host, f"{host}.local", section.host.lower()}
        self.refused: Counter[str] = Counter()

    def count(self, kind: str) -> None:
        """Count a refusal."""
        self.refused[kind] += 1

    def admit(self, host: str | None, origin: str | None) -> Refusal | None:
        """None if Host and Origin are in order."""
        if host is None or not self._knows(_name_of(host)):
            return self._refuse(400, "host", "this name is not one of the dashboard's")
        if origin is not None and _place_of(origin) != host.lower():
            return self._refuse(403, "origin", "orders from other pages are not taken")
        return None

    def role(self, token: str | None) -> Role | Refusal:
        """Role of a token's bearer; an operator's without any token."""
        section = self._section
        if self._token is None:
            return Role.OPERATOR
        if token is None and section.token is None:
            return Role.VISITOR
        if token is None:
            return self._refuse(401, "no_token", "a token is needed")
        if _same(token, self._token):
            return Role.OPERATOR
        if section.supervisor_token is not None and _same(token, section.supervisor_token):
            return Role.SUPERVISOR
        if section.viewer_token is not None and _same(token, section.viewer_token):
            return Role.VIEWER
        return self._refuse(403, "token", "the token is wrong")

    def may_stop(self, token: str | None) -> Refusal | None:
        """None if the bearer of a token may stop the robot."""
        role = self.role(token)
        if isinstance(role, Refusal):
            return role
        if role is Role.VISITOR:
            return self._refuse(401, "no_token", TOKEN_TO_STOP)
        return None

    def _knows(self, name: str | None) -> bool:
        if name is None:
            return False
        if name in LOCAL_NAMES or name in self._names:
            return True
        # an address cannot be pointed elsewhere, so it is safe where others may come at all
        return not self._section.is_local and _is_address(name)

    def _refuse(self, status: int, kind: str, sentence: str) -> Refusal:
        self.count(kind)
        return Refusal(status, kind, sentence)


def refused(refusal: Refusal) -> Response:
    """Response to a visitor who is turned away."""
    headers = {"www-authenticate": "Bearer"} if refusal.status == 401 else {}
    return PlainTextResponse(refusal.sentence + "\n", refusal.status, headers=headers)


def token_of(subprotocols: list[str]) -> str | None:
    """Token among a websocket's subprotocols."""
    return next((p[6:] for p in subprotocols if p.startswith("token.")), None)


def bearer_of(authorization: str | None) -> str | None:
    """Token of an Authorization header."""
    if authorization is None or not authorization.lower().startswith("bearer "):
        return None
    return authorization[7:].strip()


def _same(one: str, other: str) -> bool:
    # headers may hold half surrogate pairs, which have no bytes
    return hmac.compare_digest(one.encode(errors="surrogatepass"), other.encode())


def _name_of(host: str) -> str | None:
    try:
        return urlsplit(f"//{host}").hostname
    except ValueError:
        return None


def _place_of(origin: str) -> str | None:
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
