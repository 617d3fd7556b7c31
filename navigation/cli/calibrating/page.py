"""A live calibration on a page: the picture with the board, the parts still needed, the spread.

Rules
- The page only looks and needs no token, since everything is done with the board; the gate of the
  dashboard (`dashboard.admission.access`) refuses names that are not this machine's.
- It shows the same as a panel of the dashboard (`dashboard.calibrating.shown`).
"""

from __future__ import annotations

import asyncio
import threading
from importlib.resources import files
from typing import Final

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

from navigation.config.dashboard import DashboardSection
from navigation.dashboard.admission.access import AccessGate
from navigation.dashboard.admission.listener import ACCEPTS_A_ROUND, Listener
from navigation.dashboard.app import HEADERS, TYPES
from navigation.dashboard.calibrating.shown import ShownViews
from navigation.dashboard.messages.palette import stylesheet
from vision.calibrate.live.session import LiveState
from vision.camera.camera import Frame

HOST: Final = "127.0.0.1"
LAST_WORDS_S: Final = 1.0
CLOSE_WITHIN_S: Final = 2.0
SHARED_FILES: Final = ("board.js", "board.css")
"""Files of the dashboard, which draws a live calibration, too."""


class LivePage:
    """Serves the page at ``url`` in its own thread; a context manager.

    Raises ``OSError`` if the port is not available.
    """

    def __init__(self, port: int) -> None:
        self._socket = Listener(HOST, port)
        number = self._socket.getsockname()[1]
        self.url = f"http://{HOST}:{number}/"
        self._gate = AccessGate(DashboardSection(host=HOST, port=number))
        self._views = ShownViews()
        self._asked = False
        self._told = threading.Event()
        self._ended = ""
        self._files = _page_files()
        self._server = uvicorn.Server(
            uvicorn.Config(
                self._socket.watched(self._app()), proxy_headers=False, http="h11", ws="none",
                backlog=ACCEPTS_A_ROUND, lifespan="off", log_config=None, log_level="critical",
                access_log=False, server_header=False, timeout_graceful_shutdown=1,
            )
        )  # fmt: skip
        self._thread = threading.Thread(target=self._run, name="page", daemon=True)

    def __enter__(self) -> LivePage:
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        if self._asked and self._ended:
            self._told.wait(LAST_WORDS_S)
        self._server.should_exit = True
        self._thread.join(CLOSE_WITHIN_S)
        self._socket.close()

    def show(self, state: LiveState, frame: Frame) -> None:
        """Store the next frame."""
        self._views.show(state, frame)

    def end(self, sentence: str) -> None:
        """Store the outcome."""
        self._ended = sentence

    def _run(self) -> None:
        asyncio.run(self._serve())

    async def _serve(self) -> None:
        sweeping = asyncio.ensure_future(self._socket.look_after(self._server))
        await self._server.serve(sockets=[self._socket])
        sweeping.cancel()

    def _app(self) -> ASGIApp:
        app = Starlette(
            routes=[
                *[Route(address, self._file) for address in self._files],
                Route("/state", self._state),
                Route("/picture.jpg", self._picture),
            ]
        )

        async def gated(scope: Scope, receive: Receive, send: Send) -> None:
            if scope["type"] != "http":
                return
            headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
            refusal = self._gate.admit(headers.get(b"host"), headers.get(b"origin"))
            if refusal is None:
                await app(scope, receive, send)
            else:
                await Response(refusal.sentence, refusal.status)(scope, receive, send)

        return gated

    async def _file(self, request: Request) -> Response:
        body, kind = self._files[request.url.path]
        return Response(body, media_type=kind, headers=HEADERS)

    async def _state(self, _request: Request) -> Response:
        ended = self._ended
        self._asked = True
        if ended:
            self._told.set()
        body = {"state": self._views.state, "remarks": self._views.remarks, "ended": ended}
        return JSONResponse(body, headers=HEADERS)

    async def _picture(self, request: Request) -> Response:
        """Frame of a state, or the newest if it is gone."""
        data = self._views.picture(request.query_params.get("frame", ""))
        if data is None:
            return Response(status_code=404, headers=HEADERS)
        return Response(data, media_type="image/jpeg", headers=HEADERS)


def _page_files() -> dict[str, tuple[bytes, str]]:
    here = files("navigation.cli.calibrating") / "static"
    shared = files("navigation.dashboard") / "static"
    items = [*here.iterdir(), *(shared / name for name in SHARED_FILES)]
    found = {
        f"/{item.name}": (item.read_bytes(), TYPES["." + item.name.rsplit(".", 1)[-1]])
        for item in items
        if "." + item.name.rsplit(".", 1)[-1] in TYPES
    }
    found["/"] = found["/calibrate.html"]
    found["/palette.css"] = (stylesheet().encode(), TYPES[".css"])
    return found
