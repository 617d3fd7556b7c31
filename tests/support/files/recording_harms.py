"""Harms to what a recording says: one message's body, with the lengths around it right.

A byte that is flipped anywhere mostly hits a picture or breaks a chunk's check sum, and a reader
stops there. Source: the MCAP specification, mcap.dev/spec.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.support.files.picture_harms import cut, flip, put_number, splice
from tests.support.files.text_harms import TEXT_HARMS

MAGIC = b"\x89MCAP0\r\n"
MESSAGE, CHUNK = 5, 6
MESSAGE_HEAD = 2 + 4 + 8 + 8
CHUNK_HEAD = 8 + 8 + 8 + 4 + 4 + 8
"""Times, size, check sum, the empty name of no compression, and the length."""
JSON_VALUES = (
    *("null", "true", "0", "-1", "0.5", "1e308", "1e999", "-1e999", "NaN", "9" * 30, "9" * 400),
    *('""', '"0"', '"x"', '"\\ud800"', '"\\u001b[2J"', "[]", "[0]", "[[]]", "{}", '{"": 0}'),
)
PICTURE_BYTES = 10_000
"""A larger message is a picture: those are harmed rarely."""


def message_body(data: bytes, rng: np.random.Generator) -> bytes:
    """One message harmed, or its times; its chunk has the right lengths and no check sum."""
    records = list(_records(data[len(MAGIC) :]))
    chunks = [i for i, (kind, _) in enumerate(records) if kind == CHUNK]
    if not chunks:
        return flip(data, rng)
    number = chunks[int(rng.integers(len(chunks)))]
    inner = list(_records(records[number][1][CHUNK_HEAD:]))
    large = rng.random() < 0.1
    messages = [
        i for i, (k, b) in enumerate(inner) if k == MESSAGE and (len(b) > PICTURE_BYTES) == large
    ]
    if not messages:
        return flip(data, rng)
    chosen = messages[int(rng.integers(len(messages)))]
    inner[chosen] = MESSAGE, _harmed(inner[chosen][1], rng)
    packed = b"".join(_record(*one) for one in inner)
    size = struct.pack("<QQQII", 0, 0, len(packed), 0, 0) + struct.pack("<Q", len(packed))
    records[number] = CHUNK, size + packed
    whole = b"".join(_record(*one) for one in records)
    return MAGIC + whole + MAGIC


def _harmed(body: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.1:
        return put_number(body[:MESSAGE_HEAD], rng) + body[MESSAGE_HEAD:]
    harms = (cut, flip, splice, *TEXT_HARMS, *[json_value] * 20)
    said = harms[int(rng.integers(len(harms)))](body[MESSAGE_HEAD:], rng)
    return body[:MESSAGE_HEAD] + said


def json_value(data: bytes, rng: np.random.Generator) -> bytes:
    """JSON with one value anywhere in it made another, or left out."""
    try:
        said = json.loads(data)
    except ValueError:
        return flip(data, rng)
    inside, key = {"": said}, ""
    outer: Any = inside
    while isinstance(outer[key], dict | list) and outer[key] and rng.random() < 0.8:
        outer = outer[key]
        keys = list(outer) if isinstance(outer, dict) else range(len(outer))
        key = keys[int(rng.integers(len(keys)))]
    if rng.random() < 0.1 and outer is not inside:
        del outer[key]
        return json.dumps(said).encode()
    outer[key] = "@"
    other = JSON_VALUES[int(rng.integers(len(JSON_VALUES)))]
    return json.dumps(inside[""]).replace('"@"', other).encode()


def _records(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Kind and body of each whole record."""
    at = 0
    while at + 9 <= len(data):
        kind, length = struct.unpack_from("<BQ", data, at)
        if length > len(data) - at - 9:
            return
        yield kind, data[at + 9 : at + 9 + length]
        at += 9 + length


def _record(kind: int, body: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(body)) + body
