"""A crowd at the program's doors, in a process of its own; bounded in number and time.

    python -m benchmarks.adversary.stage.crowd half_open PORT COUNT SECONDS
    python -m benchmarks.adversary.stage.crowd viewers PORT COUNT SECONDS
    python -m benchmarks.adversary.stage.crowd drip SOCKET COUNT SECONDS
    python -m benchmarks.adversary.stage.crowd silent SOCKET COUNT SECONDS
    python -m benchmarks.adversary.stage.crowd nonsense SOCKET COUNT SECONDS

Says a line when everybody is there. Loopback and Unix sockets only.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import resource
import socket
import sys
import time
from itertools import cycle

from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

MOST = 1200
MOST_SECONDS = 30.0
GOOD_WORDS = b'{"order": "status"}\n'
NONSENSE = (
    b"\xff\xfe\x00 no text\n",
    b"[" * 60_000 + b"\n",
    b'{"order": "go", "stations": [{"x_m": ' + b"9" * 400 + b', "y_m": 1}]}\n',
    b'{"order": "go", "stations": [{"x_m": 1e999, "y_m": NaN}]}\n',
    b'{"order": ' * 5_000 + b"\n",
    b"x" * 70_000 + b"\n",
    b'{"order": "stop", "reason": ' + b"7" * 5_000 + b"}\n",
    b'{"order": {"order": "go"}}\n',
    b"\n",
)


def half_open(port: int, count: int, end_s: float) -> None:
    """Connections whose request never ends."""
    visitors = []
    for number in range(count):
        visitor = socket.socket()
        visitor.setblocking(False)
        visitor.connect_ex(("127.0.0.1", port))
        visitors.append(visitor)
        if number % 50 == 49:
            time.sleep(0.01)  # not faster than the listener's backlog empties
    time.sleep(0.2)  # the connections that are under way are made by then
    for visitor in visitors:
        with contextlib.suppress(OSError):
            visitor.send(b"GET / HTTP/1.1\r\nHost: 127.0")
    print("there", flush=True)
    time.sleep(max(0.0, end_s - time.monotonic()))  # half open as long as the attack lasts


async def _view(port: int, end_s: float, polite: bool) -> None:
    """One page that looks at the picture; a rude one never says what it has drawn."""
    with contextlib.suppress(OSError, WebSocketException, TimeoutError):
        address = f"ws://127.0.0.1:{port}/live"
        async with connect(address, subprotocols=["clearway.1"], max_size=None) as line:  # type: ignore[list-item]
            await line.send(json.dumps({"type": "watch", "on": True}))
            while time.monotonic() < end_s:
                got = await asyncio.wait_for(line.recv(), 1.0)
                if polite and isinstance(got, bytes):
                    await line.send('{"type": "ack"}')


async def _views(port: int, count: int, end_s: float) -> None:
    visits = [asyncio.ensure_future(_view(port, end_s, n % 2 == 0)) for n in range(count)]
    await asyncio.sleep(1.0)  # the visits are under way by then
    print("there", flush=True)
    await asyncio.gather(*visits)


def viewers(port: int, count: int, end_s: float) -> None:
    asyncio.run(_views(port, count, end_s))


def _clients(path: str, count: int) -> list[socket.socket]:
    """As many as get in."""
    clients = []
    for _ in range(count):
        client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        client.settimeout(0.2)
        with contextlib.suppress(OSError):
            client.connect(path)
        client.setblocking(False)
        clients.append(client)
    return clients


def drip(path: str, count: int, end_s: float) -> None:
    """Clients that send a byte now and then; whoever is thrown out comes again."""
    clients = _clients(path, count)
    print("there", flush=True)
    words = cycle(GOOD_WORDS[:-1])
    while time.monotonic() < end_s:
        byte = bytes([next(words)])
        for index, client in enumerate(clients):
            try:
                client.send(byte)
            except OSError:
                client.close()
                clients[index] = _clients(path, 1)[0]
        time.sleep(0.3)  # a dripping client: a byte now and then


def silent(path: str, count: int, end_s: float) -> None:
    """Clients that say nothing at all."""
    clients = _clients(path, count)
    print("there", flush=True)
    time.sleep(max(0.0, end_s - time.monotonic()))  # silence is the attack
    for client in clients:
        client.close()


def nonsense(path: str, count: int, end_s: float) -> None:
    """One malformed request after the other, ``count`` at most."""
    print("there", flush=True)
    for number, words in zip(range(count), cycle(NONSENSE), strict=False):
        if time.monotonic() > end_s:
            return
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
            client.settimeout(1.0)
            with contextlib.suppress(OSError):
                client.connect(path)
                client.sendall(words)
                client.recv(4096)
        if number % 20 == 19:
            time.sleep(0.01)  # not faster than the listener's backlog empties


def main() -> int:
    kind, where, count, seconds = sys.argv[1:]
    most = min(int(count), MOST)
    end_s = time.monotonic() + min(float(seconds), MOST_SECONDS)
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    wanted = MOST + 100
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted if hard < 0 else min(wanted, hard), hard))
    doors = {"half_open": half_open, "viewers": viewers}
    if kind in doors:
        doors[kind](int(where), most, end_s)
    else:
        {"drip": drip, "silent": silent, "nonsense": nonsense}[kind](where, most, end_s)
    return 0


if __name__ == "__main__":
    sys.exit(main())
