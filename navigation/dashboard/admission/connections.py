"""uvicorn's protocols with a place each, so that nobody keeps descriptors or the loop from others.

- A request has ``REQUEST_WITHIN_S`` from its first byte (the first one from the connection's
  beginning) to the end of its answer, and a connection is idle for as long at most.
- Of what a viewer sends ``BYTES_A_ROUND`` are read in a round of the loop: thousands of tiny frames
  at once hold up nobody else. Frames that no page sends are few, or the connection is cut.

Units: seconds.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any, Final

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from navigation.dashboard.admission.allowance import Allowance
from navigation.dashboard.admission.places import OpenConnection, OpenConnections

REQUEST_WITHIN_S: Final = 5.0
BYTES_A_ROUND: Final = 1024
ODD_FRAMES_S, ODD_BURST_S = 20.0, 5.0
"""Pings, pongs and parts of messages: so many a second, for so long at once."""
MOST_AFTER_CLOSE: Final = 16_384
"""Bytes that are still read when a viewer was hung up on, in search of its consent."""
MOST_UNREAD: Final = 512
"""Messages that wait for the page's task, which takes them faster than pages send."""


class PlacedRequests(H11Protocol):
    """HTTP on one connection."""

    def __init__(
        self, *args: Any, places: OpenConnections, clock: Callable[[], float], **rest: Any
    ) -> None:
        super().__init__(*args, **rest)
        self._places, self._clock = places, clock
        self._is_idle = False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """A place for it; somebody else may lose theirs."""
        super().connection_made(transport)
        address = self.client[0] if self.client else ""
        self._place = OpenConnection(transport, address, self._clock() + REQUEST_WITHIN_S)
        self._places.come(self._place)

    def connection_lost(self, exc: Exception | None) -> None:
        """Its place is free."""
        self._places.go(self._place)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """A request begins with its first byte."""
        if self._is_idle:
            self._is_idle = False
            self._place.until_s = self._clock() + REQUEST_WITHIN_S
        super().data_received(data)

    def on_response_complete(self) -> None:
        """From now on it is idle."""
        self._is_idle = True
        self._place.until_s = self._clock() + REQUEST_WITHIN_S
        super().on_response_complete()

    def handle_websocket_upgrade(self, event: Any) -> None:
        """It becomes a viewer, or is refused at once."""
        self._places.look(self._place)
        self.ws_protocol_class = partial(  # type: ignore[assignment]
            PlacedViewer, place=self._place, places=self._places
        )
        super().handle_websocket_upgrade(event)


class PlacedViewer(WebSocketsSansIOProtocol):
    """A websocket on one connection."""

    def __init__(
        self, *args: Any, place: OpenConnection, places: OpenConnections, **rest: Any
    ) -> None:
        super().__init__(*args, **rest)
        self._place, self._places = place, places
        self._odd = Allowance(ODD_FRAMES_S, ODD_BURST_S, self.loop.time())
        self._unread = bytearray()
        self._after_close = 0

    def data_received(self, data: bytes) -> None:
        """A part now, the rest in the next rounds; nothing more is read until then."""
        waits = bool(self._unread)
        self._unread += data
        if not waits:
            self._read_on()

    def _read_on(self) -> None:
        part = bytes(self._unread[:BYTES_A_ROUND])
        del self._unread[:BYTES_A_ROUND]
        if self.transport.is_closing():
            self._unread.clear()
            return
        super().data_received(part)
        self._after_close += len(part) if self.close_sent else 0
        if self.queue.qsize() > MOST_UNREAD or self._after_close > MOST_AFTER_CLOSE:
            self._unread.clear()
            self.transport.abort()
        elif self._unread:
            self.transport.pause_reading()
            self.loop.call_soon(self._read_on)
        elif not self.read_paused:
            self.transport.resume_reading()

    def handle_ping(self) -> None:
        """Pages send none."""
        if self._is_allowed():
            super().handle_ping()

    def handle_pong(self, event: Frame) -> None:
        """One for each ping of ours."""
        if self._is_allowed():
            super().handle_pong(event)

    def handle_cont(self, event: Frame) -> None:
        """A further part of a message, which pages send whole."""
        if self._is_allowed():
            super().handle_cont(event)

    def _is_allowed(self) -> bool:
        if self._odd.take(self.loop.time()):
            return True
        self._unread.clear()
        self.transport.abort()
        return False

    def connection_lost(self, exc: Exception | None) -> None:
        """Its place is free."""
        self._places.go(self._place)
        super().connection_lost(exc)
