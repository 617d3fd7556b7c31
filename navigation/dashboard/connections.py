"""uvicorn's protocols with a place each: whoever keeps a request back does not keep a descriptor.

A request has ``REQUEST_WITHIN_S`` from its first byte (the first one from the connection's
beginning) to the end of its answer, and a connection is idle for as long at most. Seconds.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from navigation.dashboard.places import Place, Places

REQUEST_WITHIN_S: Final = 5.0


class PlacedRequests(H11Protocol):
    """HTTP on one connection."""

    def __init__(self, *args: Any, places: Places, clock: Callable[[], float], **rest: Any) -> None:
        super().__init__(*args, **rest)
        self._places, self._clock = places, clock
        self._is_idle = False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """A place for it; somebody else may lose theirs."""
        super().connection_made(transport)
        address = self.client[0] if self.client else ""
        self._place = Place(transport, address, self._clock() + REQUEST_WITHIN_S)
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

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """It becomes a viewer, or is refused at once."""
        self._places.look(self._place)
        self.ws_protocol_class = partial(  # type: ignore[assignment]
            PlacedViewer, place=self._place, places=self._places
        )
        super().handle_websocket_upgrade(event)


class PlacedViewer(WebSocketsSansIOProtocol):
    """A websocket on one connection."""

    def __init__(self, *args: Any, place: Place, places: Places, **rest: Any) -> None:
        super().__init__(*args, **rest)
        self._place, self._places = place, places

    def connection_lost(self, exc: Exception | None) -> None:
        """Its place is free."""
        self._places.go(self._place)
        super().connection_lost(exc)
