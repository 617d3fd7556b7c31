"""The page of a live calibration: the dashboard's panel alone, at a port of this machine.

The page only looks and needs no token, since everything is done with the board; the gate of the
dashboard (`dashboard.admission.access`) refuses names that are not this machine's.
"""

from __future__ import annotations

import asyncio
import threading
from typing import Any, Final

from starlette.applications import Starlette

from navigation.config.dashboard import DashboardSection
from navigation.dashboard.admission.access import AccessGate
from navigation.dashboard.admission.listener import Listener
from navigation.dashboard.app import Gatekeeper, file_routes
from navigation.dashboard.calibrating.routes import looking_routes
from navigation.dashboard.calibrating.shown import ShownViews
from navigation.dashboard.server import server_on
from vision.calibrate.live.session import LiveState
from vision.camera.camera import Frame

HOST: Final = "127.0.0.1"
LAST_WORDS_S: Final = 1.0
CLOSE_WITHIN_S: Final = 2.0


class LivePage:
    """Serves the page at ``url`` in its own thread; a context manager.

    Raises ``OSError`` if the port is not available.
    """

    def __init__(self, port: int) -> None:
        self._socket = Listener(HOST, port)
        number = self._socket.getsockname()[1]
        self.url = f"http://{HOST}:{number}/"
        self._views = ShownViews()
        self._asked = False
        self._heard = threading.Event()
        self._ended = ""
        routes = [*file_routes("calibrate.html"), *looking_routes(lambda: self, lambda _: None)]
        gate = AccessGate(DashboardSection(host=HOST, port=number))
        self._server = server_on(self._socket, Gatekeeper(Starlette(routes=routes), gate))
        self._thread = threading.Thread(target=self._run, name="page", daemon=True)

    def __enter__(self) -> LivePage:
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        if self._asked and self._ended:
            self._heard.wait(LAST_WORDS_S)
        self._server.should_exit = True
        self._thread.join(CLOSE_WITHIN_S)
        self._socket.close()

    def show(self, state: LiveState, frame: Frame) -> None:
        """Store the next frame."""
        self._views.show(state, frame)

    def end(self, sentence: str) -> None:
        """Store the outcome."""
        self._ended = sentence

    def facts(self) -> dict[str, Any]:
        """Everything that the page shows; no order has any effect on it."""
        ended = self._ended
        self._asked = True
        if ended:
            self._heard.set()
        phase = "ended" if ended else "taking"
        return {"refusal": "", "phase": phase, "said": ended, **self._views.facts()}

    def picture(self, number: str) -> bytes | None:
        """Frame of a state, or the newest if it is gone; None without any."""
        return self._views.picture(number)

    def _run(self) -> None:
        asyncio.run(self._serve())

    async def _serve(self) -> None:
        sweeping = asyncio.ensure_future(self._socket.look_after(self._server))
        await self._server.serve(sockets=[self._socket])
        sweeping.cancel()
