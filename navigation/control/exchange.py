"""One request to a local socket and its answer, from a process that may be this user's daemon."""

from __future__ import annotations

import socket
import time
from typing import Final

from navigation.control.peers import may_answer, peer_of
from navigation.shared.outside import OutsideError

MOST_ANSWER_BYTES: Final = 1_000_000


class CrowdedError(OSError):
    """Error: the daemon had no place for us; nothing was sent."""


class NobodyError(OSError):
    """Error: no daemon of this user listens there."""


def exchange(address: str, line: bytes, until_s: float) -> bytes:
    """Answer to a line; `CrowdedError`, `NobodyError`, another OSError, or OutsideError."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
        client.settimeout(_left_s(until_s))
        _connect(client, address)
        client.sendall(line)
        answer = bytearray()
        while not answer.endswith(b"\n"):
            client.settimeout(_left_s(until_s))
            part = client.recv(4096)
            if not part:
                break
            answer += part
            if len(answer) > MOST_ANSWER_BYTES:
                raise OutsideError(f"its answer is longer than {MOST_ANSWER_BYTES} bytes")
    if not answer:
        raise ConnectionResetError("it hung up")
    return bytes(answer)


def _connect(client: socket.socket, address: str) -> None:
    try:
        client.connect(address)
    except BlockingIOError:  # its queue is full at this moment
        raise CrowdedError("too many wait for it") from None
    except (FileNotFoundError, ConnectionRefusedError, NotADirectoryError) as error:
        raise NobodyError(str(error)) from None
    peer = peer_of(client)
    if not may_answer(peer) or peer.has_ended:
        raise NobodyError(f"user {peer.uid} listens there")


def _left_s(until_s: float) -> float:
    left_s = until_s - time.monotonic()
    if left_s <= 0.0:
        raise TimeoutError("timed out")
    return left_s
