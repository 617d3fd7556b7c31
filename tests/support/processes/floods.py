"""Hostile clients in a process of their own: connections by the hundred that keep back or drip.

    python -m tests.support.processes.floods unix PATH COUNT | tcp HOST:PORT COUNT

holds ``COUNT`` connections and opens again what is hung up on, a byte to each in turn where it
can, until its standard input is closed. It says ``full`` when all were open for the first time.
Only this machine's own addresses are connected to.
"""

from __future__ import annotations

import contextlib
import resource
import select
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[3]
REST_S: Final = 0.001
"""Between two bytes: other processes need this machine too."""


@contextlib.contextmanager
def flood(kind: str, address: str, count: int) -> Iterator[None]:
    """Such a process, from the moment at which all its connections are open."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.support.processes.floods", kind, address, str(count)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == "full\n"
            yield
        finally:
            process.stdin.close()
            process.wait(30.0)


def connect(kind: str, address: str) -> socket.socket | None:
    """One connection; None where there is no place for it now."""
    host, _, port = address.rpartition(":")
    family = socket.AF_UNIX if kind == "unix" else socket.AF_INET
    if kind == "tcp" and host != "127.0.0.1":
        raise SystemExit(f"{address}: must be at 127.0.0.1")
    client = socket.socket(family, socket.SOCK_STREAM)
    client.settimeout(5.0)
    try:
        client.connect(address if kind == "unix" else (host, int(port)))
    except OSError:
        client.close()
        return None
    client.setblocking(False)
    return client


def main() -> None:
    """Until standard input is closed."""
    kind, address, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    clients: list[socket.socket | None] = [connect(kind, address) for _ in range(count)]
    print("full", flush=True)
    while True:
        for number, client in enumerate(clients):
            if select.select([sys.stdin], [], [], REST_S)[0]:
                return
            clients[number] = client if drip(client) else connect(kind, address)


def drip(client: socket.socket | None) -> bool:
    """One more byte; whether the connection is there still."""
    if client is None:
        return False
    try:
        client.send(b"x")
    except OSError:
        client.close()
        return False
    return True


if __name__ == "__main__":
    main()
