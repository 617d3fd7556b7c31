"""The page's listening socket: no client keeps descriptors or the event loop from others.

uvicorn accepts from it as from any other socket; the wrapped application (`watched`) reports each
connection's state. Rules
- A request has ``REQUEST_WITHIN_S`` from its first byte (the first one from the connection's
  beginning) to the end of its answer, and a connection may be idle for that time.
- A round of the loop reads ``BYTES_A_ROUND`` from a viewer: a thousand tiny frames hold no one up.
- A viewer's bytes become messages. Others (pings, pongs, a message that is never complete) are
  limited to one message's size and ``STRAY_BYTES_S`` a second, or the connection is cut.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import struct
import time
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any, Final

import uvicorn

from navigation.dashboard.admission.connections import OpenConnection, OpenConnections
from navigation.machine.descriptors import descriptor_limit

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Any, Any, Any], Awaitable[None]]

REQUEST_WITHIN_S: Final = 5.0
BYTES_A_ROUND: Final = 1024
MOST_MESSAGE_BYTES: Final = 80 * 1024
"""websockets refuses longer messages; the `viewer` takes less."""
FRAME_BYTES: Final = 14
"""The longest head of a frame (RFC 6455, 5.2)."""
STRAY_BYTES_S: Final = 256.0
"""A page answers a ping of ours every few seconds with ten bytes."""
BACKLOG: Final = 4096
"""Linux's own limit. In a full queue a connection is dropped and tried again after a second: with
512 places a burst took 600 connections a second, with 4096 1,400."""
ACCEPTS_A_ROUND: Final = 32
"""Most connections accepted in a row; then places of closed ones are freed first."""
MOST_CONNECTIONS: Final = 256
LEAST_CONNECTIONS: Final = 16
SHARE_OF_DESCRIPTORS: Final = 4
"""One in this number of the process's descriptors, at most, is for the page."""
AN_ADDRESS: Final = 0.625
"""Share of the connections that one address may have."""
SWEEP_EVERY_S: Final = 0.25
RESET_AT_CLOSE: Final = struct.pack("ii", 1, 0)


class Listener(socket.socket):
    """Listens on an address; ``OSError`` if it is not available.

    Belongs to one event loop, whose thread alone calls it.
    """

    def __init__(self, host: str, port: int, clock: Callable[[], float] = time.monotonic) -> None:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        super().__init__(family, kind, protocol)
        self.clock = clock
        self.connections = make_connections()
        self._connections: dict[tuple[str, int], Connection] = {}
        try:
            self.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self.bind(address)
            self.listen(BACKLOG)
            self.setblocking(False)
        except OSError:
            self.close()
            raise

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection and give it a place; another may lose its own."""
        accepted, address = super().accept()
        connection = Connection(accepted, address[:2], self)
        self._connections[connection.peer] = connection
        self.connections.come(connection.place)
        return connection, address

    def forget(self, connection: Connection) -> None:
        """Free the place of a closed connection."""
        self.connections.go(connection.place)
        if self._connections.get(connection.peer) is connection:
            del self._connections[connection.peer]

    def watched(self, app: App) -> App:
        """Wrap the application to report its connections' states here.

        Must be outside anything that changes ``scope["client"]``, which identifies a connection.
        """

        async def watch(scope: Any, receive: Receive, send: Send) -> None:
            connection = self._connections.get(tuple(scope.get("client") or ()))
            if connection is None:  # it has gone
                await app(scope, receive, send)
            elif scope["type"] == "websocket":
                await connection.serve_viewer(app, scope, receive, send)
            else:
                await app(scope, receive, connection.noting_the_end(send))

        return watch

    async def look_after(self, server: uvicorn.Server) -> None:
        """Cut late connections until cancelled; ``server`` accepts from this socket."""
        while not server.started:
            await asyncio.sleep(0.01)  # uvicorn has no event for it
        self.listen(BACKLOG)  # the queue may be longer than one round takes from it
        while True:
            self.connections.sweep(self.clock())
            await asyncio.sleep(SWEEP_EVERY_S)

    async def hang_up(self, within_s: float) -> None:
        """Wait for the last words, then cut all connections."""
        for cut in (False, True):
            until_s = time.monotonic() + within_s
            if cut:
                for connection in list(self._connections.values()):
                    connection.abort()
            while self._connections and time.monotonic() < until_s:
                await asyncio.sleep(0.01)  # the loop ends connections meanwhile


class Connection(socket.socket):
    """One accepted connection and its state."""

    def __init__(self, accepted: socket.socket, peer: tuple[str, int], listener: Listener) -> None:
        super().__init__(accepted.family, accepted.type, accepted.proto, accepted.detach())
        self.peer = peer
        self._listener = listener
        self._is_viewer = False
        self._is_idle = False
        self._is_over = False
        self._stray = 0.0
        self._counted_s = listener.clock()
        self.place = OpenConnection(self, peer[0], self._counted_s + REQUEST_WITHIN_S)

    def recv(self, size: int, flags: int = 0, /) -> bytes:
        """Receive bytes; a viewer's are read in parts.

        ``ConnectionAbortedError`` if a viewer's bytes become no message.
        """
        if self._is_viewer:
            data = super().recv(min(size, BYTES_A_ROUND), flags)
            self._count(len(data))
            if self._stray > MOST_MESSAGE_BYTES + FRAME_BYTES:
                self._listener.connections.cut += 1
                raise ConnectionAbortedError("bytes that become no message")
            return data
        data = super().recv(size, flags)
        if self._is_idle:
            self._is_idle = False
            self._set_time()
        return data

    def close(self) -> None:
        """Close it and free its place."""
        self._listener.forget(self)
        super().close()

    def abort(self) -> None:
        """Cut it: the event loop reads its end, or cannot write, and closes it."""
        with contextlib.suppress(OSError):  # the other end was faster
            self.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET_AT_CLOSE)
            self.shutdown(socket.SHUT_RDWR)

    def is_closing(self) -> bool:
        """True if nothing serves it any more."""
        return self._is_over

    async def serve_viewer(self, app: App, scope: Any, receive: Receive, send: Send) -> None:
        """Serve a websocket: it may stay, and has a moment after its end."""

        async def hear() -> Message:
            message = await receive()
            text = message.get("text") or ""
            self._count(-len(text.encode("utf-8", "surrogatepass")) - FRAME_BYTES)
            return message

        async def say(message: Message) -> None:
            if message["type"] in ("websocket.close", "websocket.http.response.start"):
                self._is_over = True
            await send(message)

        self._listener.connections.look(self.place)
        self._is_viewer = True
        try:
            await app(scope, hear, say)
        finally:
            self._is_over = True

    def noting_the_end(self, send: Send) -> Send:
        """Make the connection idle after the last part of an answer."""

        async def say(message: Message) -> None:
            await send(message)
            if message["type"] == "http.response.body" and not message.get("more_body"):
                self._is_idle = True
                self._set_time()

        return say

    def _set_time(self) -> None:
        self.place.until_s = self._listener.clock() + REQUEST_WITHIN_S

    def _count(self, size: int) -> None:
        """Count received bytes; a negative size takes off a message."""
        now_s = self._listener.clock()
        allowed = STRAY_BYTES_S * (now_s - self._counted_s)
        self._counted_s = now_s
        self._stray = max(0.0, self._stray - allowed + size)


def make_connections() -> OpenConnections:
    """Room for as many as this process can have beside everything else."""
    most = min(MOST_CONNECTIONS, max(LEAST_CONNECTIONS, descriptor_limit() // SHARE_OF_DESCRIPTORS))
    return OpenConnections(most, round(most * AN_ADDRESS))
