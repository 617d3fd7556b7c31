"""Texts under a line ``clearway KIND VERSION LENGTH SHA256``.

The sum covers the rest of the line and the text: one flipped bit or lost byte makes the whole
unusable.
"""

from __future__ import annotations

import hashlib


class SealError(ValueError):
    """Error: the text is not what was sealed."""


def seal(kind: str, version: int, text: str) -> bytes:
    """The text with its line in front."""
    body = text.encode()
    head = f"clearway {kind} {version} {len(body)}"
    return f"{head} {_sum(head, body)}\n".encode() + body


def unseal(kind: str, version: int, data: bytes) -> str:
    """The text; ``SealError`` if it or its line has changed."""
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
