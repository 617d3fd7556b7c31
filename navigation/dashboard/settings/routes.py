"""The settings' addresses: /api/settings to read, /check, /save and /undo below it to change.

A body is JSON: ``key`` (the seat's), ``changes`` (typed text by key) and ``base`` (the digest of
the text that the form was made from).
"""

from __future__ import annotations

from typing import Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from navigation.dashboard.admission.access import Refusal
from navigation.dashboard.hub import Hub
from navigation.dashboard.settings.desk import Desk
from navigation.dashboard.visits import RefusedError, Visits

NO_SETTINGS: Final = Refusal(404, "settings", "the settings of this run are changed in its file")


def settings_routes(hub: Hub, desk: Desk | None) -> list[Route]:
    """The routes; without a desk there is nothing to change."""
    pages = _Settings(hub, desk)
    return [
        Route("/api/settings", pages.show),
        Route("/api/settings/check", pages.check, methods=["POST"]),
        Route("/api/settings/save", pages.save, methods=["POST"]),
        Route("/api/settings/undo", pages.undo, methods=["POST"]),
    ]


class _Settings:
    def __init__(self, hub: Hub, desk: Desk | None) -> None:
        self._visits = Visits(hub, "settings", None if desk is not None else NO_SETTINGS)
        self._kept = desk

    @property
    def _desk(self) -> Desk:
        assert self._kept is not None
        return self._kept

    async def show(self, request: Request) -> Response:
        return await self._visits.read(request, lambda: self._desk.show())

    async def check(self, request: Request) -> Response:
        return await self._visits.ask(
            request, lambda body: {"problems": self._desk.check(_changes(body))}
        )

    async def save(self, request: Request) -> Response:
        return await self._visits.change(
            request, lambda body: self._desk.save(_changes(body), str(body.get("base")))
        )

    async def undo(self, request: Request) -> Response:
        return await self._visits.change(request, lambda _body: self._desk.undo())


def _changes(body: dict[str, Any]) -> dict[str, str]:
    changes = body.get("changes")
    if not isinstance(changes, dict):
        raise RefusedError("changes: must be keys with what was typed")
    if not all(isinstance(k, str) and isinstance(v, str) for k, v in changes.items()):
        raise RefusedError("changes: what was typed must be text")
    return changes
