"""The settings' addresses: /api/settings to read, /check, /save and /undo below it to change.

Rules
- All of them are for operators, and what changes something is for the one who holds the arena.
- Something is changed while no mission is under way and the robot is not stopped, and the run that
  begins again waits for orders: nobody sets the robot going, or leaves a stop, by saving.
- A body is JSON: ``key`` (the seat's), ``changes`` (each key with what was typed) and ``base``
  (the digest of the text that the form was made from).
- Files are read and written in a worker thread: neither the page nor the control loop waits.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from navigation.config.errors import ConfigError
from navigation.config.secrecy.secrets import hide, hide_in
from navigation.dashboard.admission.access import Refusal, Role, bearer_of
from navigation.dashboard.hub import Hub
from navigation.dashboard.settings.desk import Desk, RefusedError
from navigation.mission.mission import State
from navigation.shared.outside import OutsideError, read_object

MOST_BODY_BYTES: Final = 65_536
OPERATORS_ONLY: Final = Refusal(403, "settings", "settings are for operators")
AT_REST: Final = frozenset(one.value for one in (State.IDLE, State.DONE, State.FAILED))
NO_SETTINGS: Final = Refusal(404, "settings", "the settings of this run are changed in its file")


def settings_routes(hub: Hub, desk: Desk | None) -> list[Route]:
    """The addresses; without a desk each says that there is nothing to change."""
    visits = _Visits(hub, desk)
    return [
        Route("/api/settings", visits.show),
        Route("/api/settings/check", visits.check, methods=["POST"]),
        Route("/api/settings/save", visits.save, methods=["POST"]),
        Route("/api/settings/undo", visits.undo, methods=["POST"]),
    ]


class _Visits:
    def __init__(self, hub: Hub, desk: Desk | None) -> None:
        self._hub, self._desk = hub, desk

    async def show(self, request: Request) -> Response:
        """The form."""
        desk = self._let_in(request)
        if isinstance(desk, Refusal):
            return _refused(desk)
        return await self._answer(lambda: {"ok": True, **desk.show()})

    async def check(self, request: Request) -> Response:
        """What would be wrong; nothing is changed, so nobody has to hold the arena."""
        desk, body = self._let_in(request), await self._body(request)
        if isinstance(desk, Refusal) or isinstance(body, Refusal):
            return _refused(next(one for one in (desk, body) if isinstance(one, Refusal)))
        return await self._answer(lambda: {"ok": True, "problems": desk.check(_changes(body))})

    async def save(self, request: Request) -> Response:
        """Into the file, and taken over."""
        return await self._change(
            request, lambda desk, body: desk.save(_changes(body), str(body.get("base")))
        )

    async def undo(self, request: Request) -> Response:
        """As it was before the last change."""
        return await self._change(request, lambda desk, _body: desk.undo())

    async def _change(
        self, request: Request, act: Callable[[Desk, dict[str, Any]], str]
    ) -> Response:
        desk, body = self._let_in(request), await self._body(request)
        if isinstance(desk, Refusal) or isinstance(body, Refusal):
            return _refused(next(one for one in (desk, body) if isinstance(one, Refusal)))
        hub, key = self._hub, body.get("key")
        holder = hub.seat.holder
        if holder is None or holder.key != key:
            return JSONResponse({"ok": False, "error": "take the arena first"})

        def work() -> dict[str, Any]:
            if hub.daemon.describe()["state"] not in AT_REST:
                raise RefusedError("settings are changed while no mission is under way: stop first")
            return {"ok": True, "said": act(desk, body)}

        response, said = await self._tried(work)
        if said is not None:
            hub.note("order", hide(f"{holder.name}: {said['said']}"))
        return response

    def _let_in(self, request: Request) -> Desk | Refusal:
        gate = self._hub.gate
        role = gate.role(bearer_of(request.headers.get("authorization")))
        if isinstance(role, Refusal):
            return role
        if role is not Role.OPERATOR:
            gate.count("settings")
            return OPERATORS_ONLY
        return self._desk or NO_SETTINGS

    async def _body(self, request: Request) -> dict[str, Any] | Refusal:
        text = b""
        async for part in request.stream():
            text += part
            if len(text) > MOST_BODY_BYTES:
                self._hub.gate.count("oversized")
                return Refusal(413, "oversized", "the request is too long")
        try:
            return read_object(text)
        except OutsideError as error:
            self._hub.gate.count("malformed")
            return Refusal(400, "malformed", str(error))

    async def _answer(self, work: Callable[[], dict[str, Any]]) -> Response:
        return (await self._tried(work))[0]

    async def _tried(
        self, work: Callable[[], dict[str, Any]]
    ) -> tuple[Response, dict[str, Any] | None]:
        """What came of it in a worker thread, as an answer and, where it went well, as it is."""
        loop = asyncio.get_running_loop()
        try:
            answer = await loop.run_in_executor(self._hub.workers, work)
        except (RefusedError, ConfigError) as error:
            return JSONResponse({"ok": False, "error": hide(str(error))}), None
        return JSONResponse(hide_in(answer)), answer


def _changes(body: dict[str, Any]) -> dict[str, str]:
    changes = body.get("changes")
    if not isinstance(changes, dict):
        raise RefusedError("changes: must be keys with what was typed")
    if not all(isinstance(k, str) and isinstance(v, str) for k, v in changes.items()):
        raise RefusedError("changes: what was typed must be text")
    return changes


def _refused(refusal: Refusal) -> Response:
    headers = {"www-authenticate": "Bearer"} if refusal.status == 401 else {}
    return PlainTextResponse(refusal.sentence + "\n", refusal.status, headers=headers)
