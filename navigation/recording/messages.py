"""Messages of an MCAP file, with bounds: a few bytes can claim gigabytes.

Rules
- A length that points past its record's end ends the file there, as a kill does.
- Unused kinds of records are skipped unread.
- A chunk is unpacked no further than the size that it declares, which is limited too.

Source: the MCAP specification, mcap.dev/spec.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message

from navigation.recording.files import RecordingError

MAGIC: Final = b"\x89MCAP0\r\n"
MOST_RECORD_BYTES: Final = 1 << 28
"""The recorder closes a chunk when it has 0.8 MB; a single message may be larger, and the largest,
an 8K picture without loss, has 100 MB."""
MOST_TIMES: Final = 1000
"""Largest factor of unpacked data over its chunk. Others may pack a recording; the same small
picture over and over becomes 250 times smaller, everything else 30 times."""
_HEAD: Final = struct.Struct("<BQ")
"""Kind and length."""


class Messages:
    """Messages of a file in order, each with its topic and the place of its record.

    ``cut`` is True if the file's end was missing. Raises ``RecordingError`` for what is no MCAP, or
    claims more than the bounds.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.cut = True

    def __iter__(self) -> Iterator[tuple[int, str, Message]]:
        topics: dict[int, str] = {}
        try:
            with self.path.open("rb") as file:
                if file.read(len(MAGIC)) != MAGIC:
                    raise McapError("it does not begin as one")
                for place, opcode, body in _records(file, self.path):
                    for one in _parsed(opcode, body, self.path):
                        if isinstance(one, Channel):
                            topics[one.id] = one.topic
                        else:
                            yield place, topics.get(one.channel_id, ""), one
            self.cut = False
        except OSError as error:
            raise RecordingError(f"{self.path}: {error.strerror or error}") from None
        except (McapError, UnicodeDecodeError) as error:
            if not topics:
                raise RecordingError(f"{self.path}: not an MCAP recording: {error}") from None


def messages_at(path: Path, place: int) -> list[Message]:
    """Read the messages in the record at a place; ``RecordingError`` if damaged."""
    try:
        with path.open("rb") as file:
            file.seek(place)
            for _, opcode, body in _records(file, path):
                return [one for one in _parsed(opcode, body, path) if isinstance(one, Message)]
    except (OSError, McapError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: a message in it cannot be read: {error}") from None
    return []


def _records(file: BinaryIO, path: Path) -> Iterator[tuple[int, int, bytes]]:
    size = os.fstat(file.fileno()).st_size
    while True:
        place = file.tell()
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise McapError("its end is missing")
        opcode, length = _HEAD.unpack(head)
        if length > size - file.tell():
            raise McapError(f"a record of {length} bytes in a file of {size}")
        if opcode in (Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK):
            _refuse_beyond(length, MOST_RECORD_BYTES, path)
            yield place, opcode, file.read(length)
        else:
            file.seek(length, os.SEEK_CUR)
        if opcode == Opcode.FOOTER:
            if file.read(len(MAGIC)) != MAGIC:
                raise McapError("its end is missing")
            return


def _parsed(opcode: int, body: bytes, path: Path) -> Iterator[Channel | Message]:
    if opcode == Opcode.CHANNEL:
        yield Channel.read(_Body(body))
    elif opcode == Opcode.MESSAGE:
        yield Message.read(_Body(body), len(body))
    elif opcode == Opcode.CHUNK:
        # parsed fully before the first is given: a chunk counts whole or not at all
        yield from list(_inner(_unpacked(Chunk.read(_Body(body)), path), path))


def _inner(data: bytes, path: Path) -> Iterator[Channel | Message]:
    stream = _Body(data)
    while stream.count < len(data):
        opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
        body = stream.read(length)
        if opcode != Opcode.CHUNK:  # no chunk may hold another
            yield from _parsed(opcode, body, path)


def _unpacked(chunk: Chunk, path: Path) -> bytes:
    size = chunk.uncompressed_size
    if chunk.compression:
        _refuse_beyond(size, min(MOST_RECORD_BYTES, MOST_TIMES * len(chunk.data)), path)
    data = _unpack(chunk.compression, chunk.data, size + 1)
    if len(data) != size:
        raise McapError(f"a chunk declares {size} bytes and holds others")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise McapError("a chunk's check sum is wrong")
    return data


def _unpack(compression: str, data: bytes, most: int) -> bytes:
    if not compression:
        return data
    try:
        if compression == "lz4":
            unpacked: Any = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most)
        elif compression == "zstd":
            # a frame's own header is not trusted: `decompress` would allocate what it claims
            with zstandard.ZstdDecompressor().stream_reader(data) as stream:
                unpacked = stream.read(most)
        else:
            raise McapError(f"a chunk is packed by {compression[:20]!r}: must be by lz4 or zstd")
    except (RuntimeError, zstandard.ZstdError) as error:
        raise McapError(f"a chunk cannot be unpacked: {error}") from None
    return bytes(unpacked)


def _refuse_beyond(size: int, most: int, path: Path) -> None:
    if size > most:
        raise RecordingError(
            f"{path}: a part of it claims {size} bytes, must be at most {most}: damaged, or not a "
            "recording of Clearway"
        )


class _Body(ReadDataStream):
    """Source of bytes for mcap's records; no length leads past its end."""

    def __init__(self, data: bytes) -> None:
        super().__init__(BytesIO(data))
        self._size = len(data)

    def read(self, length: int) -> bytes:
        left = self._size - self.count
        if not 0 <= length <= left:
            raise McapError(f"a length of {length} bytes where {left} are left")
        return super().read(length)
