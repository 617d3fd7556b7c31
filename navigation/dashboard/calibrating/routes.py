"""The calibration's addresses: /api/calibration and its picture to look at, /start, /save, /cancel.

`navigation.dashboard.visits` says who may. A cancel moves nothing and needs no rest: every operator
may, so that a closed page holds no one up.
"""

from __future__ import annotations

import asyncio
from typing import Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from navigation.dashboard.admission.access import Refusal
from navigation.dashboard.calibrating.bench import Bench, board_of
from navigation.dashboard.hub import Hub
from navigation.dashboard.visits import Visits, refused

NO_BENCH: Final = Refusal(
    404, "calibration", "the cameras of this run are calibrated by clearway calibrate --live"
)


def calibration_routes(hub: Hub, bench: Bench | None) -> list[Route]:
    """The routes; without a bench each names the command that calibrates instead."""
    pages = _Calibration(hub, bench)
    return [
        Route("/api/calibration", pages.show),
        Route("/api/calibration/picture.jpg", pages.picture),
        Route("/api/calibration/start", pages.start, methods=["POST"]),
        Route("/api/calibration/save", pages.save, methods=["POST"]),
        Route("/api/calibration/cancel", pages.cancel, methods=["POST"]),
    ]


class _Calibration:
    def __init__(self, hub: Hub, bench: Bench | None) -> None:
        self._hub = hub
        self._visits = Visits(hub, "calibrations", None if bench is not None else NO_BENCH)
        self._kept = bench

    @property
    def _bench(self) -> Bench:
        """The bench; only for admitted visitors."""
        assert self._kept is not None
        return self._kept

    async def show(self, request: Request) -> Response:
        """Report the progress."""
        return await self._visits.read(request, lambda: self._bench.told())

    async def picture(self, request: Request) -> Response:
        """Picture that belongs to a state."""
        refusal = self._visits.refusal(request)
        if refusal is not None:
            return refused(refusal)
        number = request.query_params.get("frame", "")
        loop = asyncio.get_running_loop()
        data = await loop.run_in_executor(self._hub.workers, self._bench.picture, number)
        return (
            Response(status_code=404) if data is None else Response(data, media_type="image/jpeg")
        )

    async def start(self, request: Request) -> Response:
        """Borrow the camera."""
        return await self._visits.change(request, lambda body: self._bench.start(board_of(body)))

    async def save(self, request: Request) -> Response:
        return await self._visits.change(request, lambda _body: self._bench.save())

    async def cancel(self, request: Request) -> Response:
        """Give the camera back."""
        return await self._visits.ask(request, lambda _body: {"said": self._bench.cancel()})
