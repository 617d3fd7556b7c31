"""The dashboard's port and thread.

An unavailable port is reported, never raised: the robot needs no page. The thread has its own event
loop, which no other thread touches.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import uvicorn
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from navigation.config.secrecy.secrets import hide
from navigation.dashboard.admission.connections import OpenConnections
from navigation.dashboard.admission.listener import (
    ACCEPTS_A_ROUND,
    MOST_MESSAGE_BYTES,
    App,
    Listener,
)
from navigation.dashboard.app import make_app
from navigation.dashboard.calibrating.bench import Bench
from navigation.dashboard.hub import Hub
from navigation.dashboard.kept.runs import KeptRuns
from navigation.dashboard.settings.desk import Desk
from navigation.dashboard.shown import Shown
from navigation.machine.descriptors import NONE_LEFT
from navigation.shared.supervisor import in_words

PING_EVERY_S, PONG_WITHIN_S = 5.0, 10.0
CLOSE_WITHIN_S: Final = 1.0
LAST_WORDS_S: Final = 0.2


class Dashboard:
    """Serves the page of a running daemon; a context manager.

    ``say`` gets the address, or why there is none; ``show_token`` puts the token into the address's
    fragment, which browsers keep to themselves. ``own_token`` is needed to stop and drive if no
    token is configured. ``runs`` are by default the configuration's; ``hub`` makes another one than
    a daemon's.
    """

    def __init__(
        self,
        daemon: Shown,
        *,
        say: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        wall_clock: Callable[[], float] = time.time,
        show_token: bool = False,
        own_token: str | None = None,
        desk: Desk | None = None,
        bench: Bench | None = None,
        runs: KeptRuns | None = None,
        hub: Callable[[], Hub] | None = None,
    ) -> None:
        self._daemon, self._say, self._desk, self._bench = daemon, say, desk, bench
        kept = daemon.config.recording
        self._make_hub = hub or partial(
            Hub, daemon, clock=clock, wall_clock=wall_clock, own_token=own_token
        )
        self._runs = runs or KeptRuns(kept.runs_dir, kept.folder)
        self._show_token, self._own_token = show_token, own_token
        self._section = daemon.config.dashboard
        self.url: str | None = None
        """None if it does not listen."""
        self.hub: Hub | None = None
        self._socket: Listener | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="dashboard", daemon=True)

    @property
    def connections(self) -> OpenConnections | None:
        """The connections; None if it does not listen."""
        return self._socket.connections if self._socket else None

    def __enter__(self) -> Dashboard:
        section = self._section
        try:
            self._socket = Listener(section.host, section.port)
        except OSError as error:
            where = f"{section.host}:{section.port}"
            self._say(f"no dashboard: {where}: {error.strerror or error}; the run continues")
            return self
        self.url = self._address(self._socket.getsockname()[1])
        self._thread.start()
        self._say(f"dashboard at {self.url}")
        return self

    def begin_closing(self) -> None:
        """Begin to close the page, without waiting."""
        self._closing.set()
        loop, hub = self._loop, self.hub
        if loop is not None and hub is not None:
            # the loop may have ended by itself
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(hub.closing.set)

    def __exit__(self, *_exc: object) -> None:
        if self._socket is None:
            return
        self.begin_closing()
        self._thread.join(CLOSE_WITHIN_S + 1.0)
        self._socket.close()

    def _address(self, port: int) -> str:
        section = self._section
        host = socket.gethostname() if section.host in ("0.0.0.0", "::") else section.host
        shown = f"[{host}]" if ":" in host else host
        token = section.token or self._own_token
        fragment = f"#token={token}" if token and self._show_token else ""
        return f"http://{shown}:{port}/{fragment}"

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except Exception as error:  # noqa: BLE001 - the run continues without its page
            self._say(hide(f"the dashboard has ended: {error}"))

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        self.hub = hub = self._make_hub()
        listener = self._socket
        assert listener is not None
        # here, since uvicorn would change the client before the listener has seen it
        app = ProxyHeadersMiddleware(
            make_app(hub, self._runs, self._desk, self._bench)  # type: ignore[arg-type]
        )
        server = server_on(listener, app)
        if self._closing.is_set():  # the run ended before its page was ready
            return
        self._loop.set_exception_handler(partial(_on_error, hub, listener.connections))
        serving = asyncio.ensure_future(server.serve(sockets=[listener]))
        sweeping = asyncio.ensure_future(listener.look_after(server))
        await hub.run()
        server.should_exit = True
        sweeping.cancel()
        await serving
        await listener.hang_up(LAST_WORDS_S)
        hub.workers.shutdown(wait=False, cancel_futures=True)


def server_on(listener: Listener, app: App) -> uvicorn.Server:
    """Server of an application, which accepts from this socket."""
    return uvicorn.Server(
        uvicorn.Config(
            listener.watched(app),
            proxy_headers=False,
            http="h11",
            ws="websockets-sansio",
            ws_max_size=MOST_MESSAGE_BYTES,
            ws_ping_interval=PING_EVERY_S,
            ws_ping_timeout=PONG_WITHIN_S,
            ws_per_message_deflate=False,
            lifespan="off",
            log_config=None,
            log_level="critical",
            access_log=False,
            server_header=False,
            backlog=ACCEPTS_A_ROUND,
            timeout_graceful_shutdown=round(CLOSE_WITHIN_S),
        )
    )


def _on_error(
    hub: Hub, places: OpenConnections, _loop: asyncio.AbstractEventLoop, context: dict[str, Any]
) -> None:
    """Report an error of the loop itself, and free a place if descriptors run out."""
    error = context.get("exception")
    if isinstance(error, OSError) and error.errno in NONE_LEFT:
        places.make_room()
    hub.complain(f"dashboard: {in_words(error) if error is not None else context['message']}")
