"""The calibration's addresses: /api/calibration and its picture to look at, /start, /save, /cancel.

`navigation.dashboard.visits` says who may. A cancel moves nothing and needs no rest: every operator
may, so that a closed page holds no one up. The page of `clearway calibrate --live` only looks, and
has the first two.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any, Final, Protocol

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from navigation.config.secrecy.secrets import hide_in
from navigation.dashboard.admission.access import Refusal, refused
from navigation.dashboard.calibrating.bench import Bench, board_of
from navigation.dashboard.hub import Hub
from navigation.dashboard.visits import Visits

ADDRESS: Final = "/api/calibration"
NO_BENCH: Final = Refusal(
    404, "calibration", "the cameras of this run are calibrated by clearway calibrate --live"
)


class Watched(Protocol):
    """A live calibration to look at; any thread may call every method."""

    def facts(self) -> dict[str, Any]:
        """Everything that the page shows."""
        ...

    def picture(self, number: str) -> bytes | None:
        """Frame of a state, or the newest if it is gone; None without any."""
        ...


def looking_routes(
    watched: Callable[[], Watched],
    refusal: Callable[[Request], Refusal | None],
    workers: Executor | None = None,
) -> list[Route]:
    """The routes that only look; ``watched`` is called for visitors without a refusal alone."""

    def show(_request: Request) -> Response:
        return JSONResponse(hide_in({"ok": True, **watched().facts()}))

    def picture(request: Request) -> Response:
        data = watched().picture(request.query_params.get("frame", ""))
        return (
            Response(status_code=404) if data is None else Response(data, media_type="image/jpeg")
        )

    async def look(request: Request) -> Response:
        why = refusal(request)
        if why is not None:
            return refused(why)
        answer = show if request.url.path == ADDRESS else picture
        return await asyncio.get_running_loop().run_in_executor(workers, answer, request)

    return [Route(ADDRESS, look), Route(f"{ADDRESS}/picture.jpg", look)]


def calibration_routes(hub: Hub, bench: Bench | None) -> list[Route]:
    """The routes; without a bench each names the command that calibrates instead."""
    visits = Visits(hub, "calibrations", None if bench is not None else NO_BENCH)

    def kept() -> Bench:
        """The bench; only for admitted visitors."""
        assert bench is not None
        return bench

    async def start(request: Request) -> Response:
        return await visits.change(request, lambda body: kept().start(board_of(body)))

    async def save(request: Request) -> Response:
        return await visits.change(request, lambda _body: kept().save())

    async def cancel(request: Request) -> Response:
        return await visits.ask(request, lambda _body: {"said": kept().cancel()})

    return [
        *looking_routes(kept, visits.refusal, hub.workers),
        Route(f"{ADDRESS}/start", start, methods=["POST"]),
        Route(f"{ADDRESS}/save", save, methods=["POST"]),
        Route(f"{ADDRESS}/cancel", cancel, methods=["POST"]),
    ]
