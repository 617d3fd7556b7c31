"""Requests of operators beside orders.

Rules
- Changes need the holder of the arena, and are refused while a mission is under way or a robot is
  stopped: they can neither set a robot going nor leave a stop.
- A body is JSON; its ``key`` is the seat's.
- Work is done in a worker thread: neither the page nor the control loop waits.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from navigation.config.errors import ConfigError
from navigation.config.secrecy.secrets import hide, hide_in
from navigation.dashboard.admission.access import Refusal, bearer_of, refused
from navigation.dashboard.hub import Hub
from navigation.dashboard.shown import IT_IS_A_RECORDING
from navigation.mission.mission import State
from navigation.shared.outside import OutsideError, read_object

MOST_BODY_BYTES: Final = 65_536
AT_REST: Final = frozenset(one.value for one in (State.IDLE, State.DONE, State.FAILED))


class RefusedError(ValueError):
    """Error: a request cannot be done."""


class Visits:
    """Answers operators' requests; ``subject`` names their topic, in the plural.

    ``closed``: why no one is admitted.
    """

    def __init__(self, hub: Hub, subject: str, closed: Refusal | None) -> None:
        self._hub, self._subject, self._closed = hub, subject, closed

    async def read(self, request: Request, work: Callable[[], dict[str, Any]]) -> Response:
        """Answer with the result of ``work``; reading needs no hold of the arena."""
        refusal = self.refusal(request)
        if refusal is not None:
            return refused(refusal)
        return (await self._tried(lambda: {"ok": True, **work()}))[0]

    async def ask(
        self, request: Request, work: Callable[[dict[str, Any]], dict[str, Any]]
    ) -> Response:
        """Answer a question that comes with a body."""
        body = self.refusal(request) or await self._body(request)
        if isinstance(body, Refusal):
            return refused(body)
        return (await self._tried(lambda: {"ok": True, **work(body)}))[0]

    async def change(self, request: Request, act: Callable[[dict[str, Any]], str]) -> Response:
        """Let the holder of the arena change something; ``act`` returns a sentence for the log."""
        body = self.refusal(request) or await self._body(request)
        if isinstance(body, Refusal):
            return refused(body)
        hub = self._hub
        holder = hub.seat.holder
        if holder is None or holder.key != body.get("key"):
            return JSONResponse({"ok": False, "error": "take control first"})

        def work() -> dict[str, Any]:
            people = hub.daemon.people
            if people is None:
                raise RefusedError(IT_IS_A_RECORDING)
            people.settle()  # a stop ordered just before counts
            status = people.describe()
            robots = status.get(
                "robots", {"": status}
            )  # one per robot if there are several, asked now
            states = {one["state"] for one in robots.values()}
            if not states <= AT_REST:
                first = "re-arm the robot" if State.STOPPED.value in states else "stop"
                raise RefusedError(
                    f"{self._subject} are changed while no mission is under way and no robot is "
                    f"stopped: {first} first"
                )
            return {"ok": True, "said": act(body)}

        response, said = await self._tried(work)
        if said is not None:
            hub.note("order", hide(f"{holder.name}: {said['said']}"))
        return response

    def refusal(self, request: Request) -> Refusal | None:
        """Reason for turning the visitor away; None for operators."""
        gate = self._hub.gate
        role = gate.role(bearer_of(request.headers.get("authorization")))
        if isinstance(role, Refusal):
            return role
        if not role.may_drive:
            gate.count("settings")
            return Refusal(403, "settings", f"{self._subject} are for operators")
        return self._closed

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

    async def _tried(
        self, work: Callable[[], dict[str, Any]]
    ) -> tuple[Response, dict[str, Any] | None]:
        """Do the work in a worker thread; return the answer too if it succeeded."""
        loop = asyncio.get_running_loop()
        try:
            answer = await loop.run_in_executor(self._hub.workers, work)
        except (RefusedError, ConfigError) as error:
            return JSONResponse({"ok": False, "error": hide(str(error))}), None
        return JSONResponse(hide_in(answer)), answer
