"""A text with a first line that says what it is and sums it up: any change of it is noticed.

The line is ``clearway KIND VERSION LENGTH SHA256``; the sum is over the rest of the line and the
text, so that a flipped bit or a lost byte anywhere makes the whole unusable.
"""

from __future__ import annotations

import hashlib


class SealError(ValueError):
    """The text is not what was sealed; the message says why."""


def seal(kind: str, version: int, text: str) -> bytes:
    """The text behind its line."""
    body = text.encode()
    head = f"clearway {kind} {version} {len(body)}"
    return f"{head} {_sum(head, body)}\n".encode() + body


def unseal(kind: str, version: int, data: bytes) -> str:
    """The text; ``SealError`` where anything of it, or of its line, is another."""
    line, _, body = data.partition(b"\n")
    head = f"clearway {kind} {version} {len(body)}"
    if line != f"{head} {_sum(head, body)}".encode():
        raise SealError("is damaged (its checksum)" if data else "is empty")
    try:
        return body.decode()
    except UnicodeDecodeError:
        raise SealError("is damaged (no text)") from None


def _sum(head: str, body: bytes) -> str:
    return hashlib.sha256(head.encode() + b"\n" + body).hexdigest()
