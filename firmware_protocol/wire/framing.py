"""Frames on a byte stream: ``00 | COBS(header | payload | CRC-32C) | 00``.

- The header has 8 bytes, the payload at most 112, the check 4; a frame is at most 124 bytes
  decoded and 127 on the wire, 15 of them overhead.
- The CRC also covers one unsent byte, ``H`` from the host and ``R`` from the robot, so that an
  echoed frame never validates.
- A parser takes bytes in any portions and counts every kind of fault; it never raises.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from enum import IntEnum
from struct import Struct
from struct import error as struct_error
from typing import Final

from cobs import cobs

from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.errors import LocalError

VERSION: Final = 1
"""Major version of the protocol, in the upper half of a frame's first byte."""
MAX_PAYLOAD: Final = 112
HEADER_BYTES: Final = 8
CHECK_BYTES: Final = 4
MAX_DECODED: Final = HEADER_BYTES + MAX_PAYLOAD + CHECK_BYTES
MAX_ENCODED: Final = MAX_DECODED + 1
"""COBS adds one byte up to 254."""
MAX_WIRE: Final = MAX_ENCODED + 2
OVERHEAD: Final = HEADER_BYTES + CHECK_BYTES + 3

FLAG_RELIABLE: Final = 0x01
FLAG_NAK: Final = 0x02
_KNOWN_FLAGS: Final = FLAG_RELIABLE | FLAG_NAK
_HEADER: Final = Struct("<BBHBBBB")
_FROZEN_TYPES: Final = frozenset((0x01, 0x81))
"""HELLO and HELLO_ACK are read from any version, to report a mismatch."""


class Sender(IntEnum):
    """Sender of a frame: the byte that the CRC covers and the wire does not carry."""

    HOST = ord("H")
    ROBOT = ord("R")

    @property
    def other(self) -> Sender:
        """The opposite end."""
        return Sender.ROBOT if self is Sender.HOST else Sender.HOST


@dataclass(frozen=True, slots=True)
class WireFrame:
    """One frame: ``kind`` is the message type; all numbers are bytes but ``session`` (u16)."""

    kind: int
    session: int
    payload: bytes = b""
    sequence: int = 0
    acknowledged: int = 0
    credit: int = 0
    reliable: bool = False
    nak: bool = False
    version: int = VERSION


@dataclass(slots=True)
class ParserCounters:
    """Counts of a parser, by kind of fault."""

    bytes: int = 0
    frames: int = 0
    cobs_errors: int = 0
    short_frames: int = 0
    crc_errors: int = 0
    length_errors: int = 0
    oversize: int = 0
    echoes: int = 0
    version_errors: int = 0

    @property
    def faults(self) -> int:
        """Sum of all faults."""
        counted: tuple[int, ...] = astuple(self)
        return sum(counted) - self.bytes - self.frames


def encode_frame(frame: WireFrame, sender: Sender) -> bytes:
    """Encode a frame with both delimiters.

    Raises LocalError if a field does not fit.
    """
    if len(frame.payload) > MAX_PAYLOAD:
        raise LocalError(f"payload of {len(frame.payload)} bytes: at most {MAX_PAYLOAD} fit")
    flags = FLAG_RELIABLE * frame.reliable | FLAG_NAK * frame.nak
    try:
        header = _HEADER.pack(
            frame.version << 4 | flags,
            frame.kind,
            frame.session,
            frame.sequence,
            frame.acknowledged,
            frame.credit,
            len(frame.payload),
        )
    except struct_error as error:
        raise LocalError(f"frame {frame}: {error}") from error
    body = header + frame.payload
    check = crc32c(body, _DIRECTION_CRC[sender])
    encoded: bytes = cobs.encode(body + check.to_bytes(4, "little"))
    return b"\0" + encoded + b"\0"


def wire_bytes(payload_bytes: int) -> int:
    """Number of bytes on the wire for a payload."""
    return payload_bytes + OVERHEAD


class FrameParser:
    """Parser of the other end's byte stream."""

    def __init__(self, sender: Sender) -> None:
        self.sender = sender
        self.counters = ParserCounters()
        self._partial = bytearray()
        self._too_long = False

    def feed(self, data: bytes) -> list[WireFrame]:
        """Take the next bytes, in any portion; return the frames completed, in order."""
        self.counters.bytes += len(data)
        frames: list[WireFrame] = []
        pieces = data.split(b"\0")
        for piece in pieces[:-1]:
            self._collect(piece)
            frame = self._finish()
            if frame is not None:
                frames.append(frame)
        self._collect(pieces[-1])
        return frames

    def _collect(self, piece: bytes) -> None:
        if not self._too_long:
            self._partial += piece
            if len(self._partial) > MAX_ENCODED:
                self.counters.oversize += 1
                self._too_long = True
                self._partial.clear()

    def _finish(self) -> WireFrame | None:
        too_long, self._too_long = self._too_long, False
        encoded = bytes(self._partial)
        self._partial.clear()
        if too_long or not encoded:
            return None
        return self._decode(encoded)

    def _decode(self, encoded: bytes) -> WireFrame | None:
        count = self.counters
        try:
            raw: bytes = cobs.decode(encoded)
        except cobs.DecodeError:
            count.cobs_errors += 1
            return None
        if len(raw) < HEADER_BYTES + CHECK_BYTES:
            count.short_frames += 1
            return None
        body, check = raw[:-CHECK_BYTES], int.from_bytes(raw[-CHECK_BYTES:], "little")
        if crc32c(body, _DIRECTION_CRC[self.sender]) != check:
            if crc32c(body, _DIRECTION_CRC[self.sender.other]) == check:
                count.echoes += 1
            else:
                count.crc_errors += 1
            return None
        first, kind, session, sequence, acknowledged, credit, length = _HEADER.unpack_from(body)
        if length != len(body) - HEADER_BYTES:
            count.length_errors += 1
            return None
        if (first >> 4 != VERSION or first & 0x0F & ~_KNOWN_FLAGS) and kind not in _FROZEN_TYPES:
            count.version_errors += 1
            return None
        count.frames += 1
        return WireFrame(
            kind=kind,
            session=session,
            payload=body[HEADER_BYTES:],
            sequence=sequence,
            acknowledged=acknowledged,
            credit=credit,
            reliable=bool(first & FLAG_RELIABLE),
            nak=bool(first & FLAG_NAK),
            version=first >> 4,
        )


_DIRECTION_CRC: Final = {sender: crc32c(bytes([sender])) for sender in Sender}
"""The running CRC after the direction byte."""
