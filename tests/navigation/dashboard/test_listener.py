"""The page's listening socket: what it reads, whom it keeps, and when it hangs up."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from navigation.dashboard.admission import listener as listener_module
from navigation.dashboard.admission.connections import CLOSE_WITHIN_S
from navigation.dashboard.admission.listener import (
    BYTES_A_ROUND,
    FRAME_BYTES,
    MOST_MESSAGE_BYTES,
    REQUEST_WITHIN_S,
    STRAY_BYTES_S,
    Connection,
    Listener,
)
from tests.navigation.dashboard.site import Site
from tests.support.runs.shown import FakeDaemon, laboratory
from tests.support.waiting import wait_until

MASKED_PING = b"\x89\x80\0\0\0\0"


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def listener(clock: Clock) -> Iterator[Listener]:
    with Listener("127.0.0.1", 0, clock) as one:
        yield one


@pytest.fixture
def ends(listener: Listener) -> Iterator[tuple[Connection, socket.socket]]:
    """A connection as it was accepted, and its other end."""
    with socket.create_connection(listener.getsockname(), 5.0) as client:
        listener.setblocking(True)
        accepted, _ = listener.accept()
        assert isinstance(accepted, Connection)
        with accepted:
            accepted.settimeout(5.0)
            yield accepted, client


async def nothing(*_: Any) -> Any:
    return {"type": "websocket.connect"}


def become_viewer(one: Connection, listener: Listener, heard: list[dict[str, Any]]) -> None:
    """Hear some messages as a viewer, in an application that then hangs."""

    async def serve() -> None:
        async def app(_scope: Any, receive: Any, _send: Any) -> None:
            for _ in heard:
                await receive()
            await asyncio.Event().wait()

        coming = iter(heard)

        async def receive() -> dict[str, Any]:
            return next(coming)

        scope = {"type": "websocket", "client": one.peer}
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(listener.watched(app)(scope, receive, nothing), 0.01)

    asyncio.run(serve())


def test_a_request_has_its_time_from_its_first_byte_and_no_later_byte_gives_more(
    ends: tuple[Connection, socket.socket], clock: Clock
) -> None:
    accepted, client = ends
    begin_s = clock.now_s
    for part in (b"POST /api/stop HTTP/1.1\r\n", b"Content-Length: 9\r\n\r\n", b"1"):
        clock.now_s += 1.0
        client.sendall(part)
        assert accepted.recv(65_536) == part
        assert accepted.place.until_s == begin_s + REQUEST_WITHIN_S


def test_after_an_answer_a_connection_is_idle_and_a_request_begins_anew(
    ends: tuple[Connection, socket.socket], listener: Listener, clock: Clock
) -> None:
    accepted, client = ends

    async def app(_scope: Any, _receive: Any, send: Any) -> None:
        clock.now_s += 3.0
        await send({"type": "http.response.start", "status": 200})
        await send({"type": "http.response.body", "body": b"1", "more_body": True})
        assert accepted.place.until_s == begin_s + REQUEST_WITHIN_S
        await send({"type": "http.response.body", "body": b"2"})

    begin_s = clock.now_s
    scope = {"type": "http", "client": accepted.peer}
    asyncio.run(listener.watched(app)(scope, nothing, nothing))
    assert accepted.place.until_s == begin_s + 3.0 + REQUEST_WITHIN_S
    clock.now_s += 4.0
    client.sendall(b"G")
    accepted.recv(10)
    assert accepted.place.until_s == begin_s + 7.0 + REQUEST_WITHIN_S


def test_of_a_viewer_a_part_is_read_at_a_time(
    ends: tuple[Connection, socket.socket], listener: Listener
) -> None:
    accepted, client = ends
    client.sendall(bytes(5000))
    time.sleep(0.05)  # until all of it is there: otherwise less is read anyway
    assert len(accepted.recv(65_536)) == 5000
    become_viewer(accepted, listener, [])
    client.sendall(bytes(5000))
    time.sleep(0.05)  # the same
    assert len(accepted.recv(65_536)) == BYTES_A_ROUND


def stray(accepted: Connection, client: socket.socket, size: int) -> None:
    client.sendall(bytes(size))
    while size:
        size -= len(accepted.recv(65_536))


def test_bytes_that_become_no_message_are_few_or_the_connection_is_cut(
    ends: tuple[Connection, socket.socket], listener: Listener, clock: Clock
) -> None:
    accepted, client = ends
    become_viewer(accepted, listener, [])
    stray(accepted, client, MOST_MESSAGE_BYTES)
    clock.now_s += 2.0
    stray(accepted, client, round(2 * STRAY_BYTES_S) + FRAME_BYTES)
    with pytest.raises(ConnectionAbortedError):
        stray(accepted, client, 1)
    assert listener.connections.cut == 1


def test_messages_may_be_any_number_and_a_pong_now_and_then_is_no_matter(
    ends: tuple[Connection, socket.socket], listener: Listener, clock: Clock
) -> None:
    accepted, client = ends
    for _ in range(10):
        become_viewer(accepted, listener, [])
        stray(accepted, client, MOST_MESSAGE_BYTES - 10)
        become_viewer(accepted, listener, [{"type": "websocket.receive", "text": "x" * 81_900}])
    for _ in range(5000):
        stray(accepted, client, 10)
        clock.now_s += 5.0


def test_a_viewer_stays_and_has_a_moment_after_its_end(
    ends: tuple[Connection, socket.socket], listener: Listener, clock: Clock
) -> None:
    accepted, client = ends
    seen = []

    async def app(_scope: Any, _receive: Any, send: Any) -> None:
        seen.append(accepted.place.until_s)
        await send({"type": "websocket.accept"})
        seen.append(accepted.is_closing())
        await send({"type": "websocket.close"})
        seen.append(accepted.is_closing())

    scope = {"type": "websocket", "client": accepted.peer}
    asyncio.run(listener.watched(app)(scope, nothing, nothing))
    assert seen == [inf, False, True]
    listener.connections.sweep(clock.now_s)
    listener.connections.sweep(clock.now_s + CLOSE_WITHIN_S - 0.01)
    assert listener.connections.cut == 0
    listener.connections.sweep(clock.now_s + CLOSE_WITHIN_S + 0.01)
    assert listener.connections.cut == 1
    client.settimeout(5.0)
    with contextlib.suppress(ConnectionResetError):
        assert client.recv(1) == b""


def test_connections_far_beyond_the_places_cut_no_viewer(
    ends: tuple[Connection, socket.socket], listener: Listener
) -> None:
    accepted, client = ends
    become_viewer(accepted, listener, [])
    accepted._is_over = False  # its application was only stopped for this test
    places = listener.connections
    places.most = places.most_an_address = 20
    with contextlib.ExitStack() as opened:
        for _ in range(2 * places.most):
            opened.enter_context(socket.create_connection(listener.getsockname(), 5.0))
            opened.enter_context(listener.accept()[0])
    client.sendall(b"1")
    assert accepted.recv(10) == b"1"


def test_a_closed_connection_has_no_place(listener: Listener) -> None:
    listener.setblocking(True)
    with socket.create_connection(listener.getsockname(), 5.0):
        accepted, _ = listener.accept()
        assert len(listener.connections) == 1
        accepted.close()
        accepted.close()
    assert len(listener.connections) == 0


def test_a_burst_of_connections_waits_in_the_queue_and_none_is_dropped(listener: Listener) -> None:
    """A dropped one is tried again by its system after a second: too late for a stop."""
    longest = int(Path("/proc/sys/net/core/somaxconn").read_text())
    with contextlib.ExitStack() as open_ones:
        for _ in range(min(600, longest)):  # a process may have 1024 files
            client = open_ones.enter_context(socket.socket())
            client.settimeout(0.5)
            client.connect(listener.getsockname())


def test_an_address_that_is_taken_is_an_error(listener: Listener) -> None:
    with pytest.raises(OSError, match="in use"):
        Listener(*listener.getsockname())


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> Iterator[Site]:
    monkeypatch.setattr(listener_module, "REQUEST_WITHIN_S", 0.5)
    with Site(FakeDaemon(roadmap=laboratory())) as site:
        yield site


@pytest.mark.parametrize("headers", [{}, {"X-Forwarded-For": "192.0.2.7"}])
def test_a_viewer_is_kept_behind_a_proxy_too(headers: dict[str, str], site: Site) -> None:
    places = site.dashboard.connections
    assert places is not None
    with site.live(additional_headers=headers) as page:
        page.hear("hello")
        time.sleep(1.2)  # two times what a connection has that is no viewer, and a sweep
        page.join()
        assert len(places) == 1


def test_who_stops_behind_a_proxy_is_named_by_their_own_address(site: Site) -> None:
    site.get("/api/stop", "POST", X_Forwarded_For="192.0.2.7")
    assert "192.0.2.7" in str(site.daemon.orders)


def test_pings_for_ever_end_a_viewer_and_its_place(site: Site) -> None:
    places = site.dashboard.connections
    assert places is not None
    with connect(f"ws://{site.address}/live", subprotocols=["clearway.1"]) as line:  # type: ignore[list-item]
        with contextlib.suppress(OSError):
            line.socket.sendall(MASKED_PING * 20_000)
        with contextlib.suppress(ConnectionClosed):
            for _ in line:
                pass
        assert wait_until(lambda: len(places) == 0)
