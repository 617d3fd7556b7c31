"""A camera's stream of buffers: started, waited for, handed back.

Rules and units
- Format and size are set before the rate: a new format begins at the driver's own.
- The newest filled buffer is taken; older ones go back to the driver unread.
- The node is opened without blocking, so a wait ends in time.
- Seconds of the kernel's monotonic clock; sequence numbers are the driver's own.
"""

from __future__ import annotations

import contextlib
import errno
import mmap
import select
from ctypes import c_int32
from dataclasses import dataclass
from typing import Final

import numpy as np

from vision.camera.camera import Clock, Image
from vision.camera.v4l2 import structs
from vision.camera.v4l2.modes import Choice, Size, fourcc_code, fourcc_text
from vision.camera.v4l2.node import Node

BUFFERS: Final = 4
"""One is filled while one is read; the others bridge a busy moment."""
_RATE_SCALE: Final = 1000
_MOST_FALSE_ALARMS: Final = 1000


@dataclass(frozen=True, slots=True)
class Agreed:
    """The driver's answer to a request; ``rate_hz`` None if it gives none."""

    fourcc: str
    size: Size
    bytes_per_line: int
    rate_hz: float | None


@dataclass(frozen=True, slots=True)
class Filled:
    """A buffer with a picture: its bytes (n,), valid until the next is taken."""

    data: Image
    stamp_s: float
    stamped_at_start: bool
    """True if the stamp is the exposure's beginning, not the transfer's end."""
    is_damaged: bool
    older_stamps_s: tuple[float, ...]
    """Stamps of older pictures, handed back unread."""
    missing: int
    """Number of pictures that the driver skipped before the first of these."""
    were_all: bool
    """True if every buffer that the driver had was filled: it may have waited for any time."""


class Stream:
    """Buffers of an open node. Raises ``OSError`` as the kernel does."""

    def __init__(self, node: Node, clock: Clock) -> None:
        self._node, self._clock = node, clock
        self._maps: list[mmap.mmap] = []
        self._held: structs.Buffer | None = None
        self._sequence: int | None = None

    def agree(self, choice: Choice) -> Agreed:
        """Request format, size and rate; return what the driver gives."""
        form = structs.Format(type=structs.CAPTURE)
        pixels = form.fmt.pix
        pixels.width, pixels.height = choice.size
        pixels.pixelformat = fourcc_code(choice.fourcc)
        self._node.ask(structs.S_FMT, form)
        size = int(pixels.width), int(pixels.height)
        rate_hz = self._set_rate(choice.rate_hz)
        return Agreed(fourcc_text(pixels.pixelformat), size, int(pixels.bytesperline), rate_hz)

    def _set_rate(self, rate_hz: float | None) -> float | None:
        reply = self._node.try_ask(structs.G_PARM, structs.StreamParameters(type=structs.CAPTURE))
        if reply is None:
            return None
        if rate_hz is not None and reply.capability & structs.CAN_SET_RATE:
            wanted = structs.StreamParameters(type=structs.CAPTURE)
            wanted.timeperframe.numerator = _RATE_SCALE
            wanted.timeperframe.denominator = round(rate_hz * _RATE_SCALE)
            reply = self._node.try_ask(structs.S_PARM, wanted) or reply
        span = reply.timeperframe
        return span.denominator / span.numerator if span.numerator and span.denominator else None

    def start(self) -> None:
        """Make the buffers and let the driver fill them."""
        request = structs.BufferRequest(count=BUFFERS, type=structs.CAPTURE, memory=structs.MMAP)
        self._node.ask(structs.REQBUFS, request)
        for index in range(request.count):
            buffer = _buffer(index)
            self._node.ask(structs.QUERYBUF, buffer)
            self._maps.append(mmap.mmap(self._node.fd, buffer.length, offset=buffer.m.offset))
            self._node.ask(structs.QBUF, _buffer(index))
        self._node.ask(structs.STREAMON, c_int32(structs.CAPTURE))

    def stop(self) -> None:
        """Stop and free the buffers; harmless when stopped or the camera is gone."""
        self._held, self._sequence = None, None
        maps, self._maps = self._maps, []
        with contextlib.suppress(OSError):
            if maps:
                self._node.ask(structs.STREAMOFF, c_int32(structs.CAPTURE))
        for memory in maps:
            with contextlib.suppress(BufferError):
                memory.close()
        request = structs.BufferRequest(type=structs.CAPTURE, memory=structs.MMAP)
        with contextlib.suppress(OSError):
            self._node.ask(structs.REQBUFS, request)

    def take(self, timeout_s: float) -> Filled | None:
        """Return the newest picture; None if none comes within ``timeout_s``."""
        lent = len(self._maps) - (self._held is not None)
        self._hand_back()
        waiting = select.poll()
        waiting.register(self._node.fd, select.POLLIN | select.POLLPRI)
        newest = self._wait(waiting, timeout_s)
        if newest is None:
            return None
        missing = self._missing(newest)
        older: list[float] = []
        while len(older) < BUFFERS and waiting.poll(0):
            newer = self._dequeue()
            if newer is None:
                break
            older.append(_stamp_s(newest))
            missing += self._missing(newer)
            self._node.ask(structs.QBUF, _buffer(newest.index))
            newest = newer
        self._held = newest
        used = int(newest.bytesused) or len(self._maps[newest.index])
        data = np.frombuffer(self._maps[newest.index], np.uint8, min(used, newest.length))
        return Filled(
            data=data,
            stamp_s=_stamp_s(newest),
            stamped_at_start=newest.flags & structs.STAMP_SOURCE == structs.STAMPED_AT_START,
            is_damaged=bool(newest.flags & structs.BUFFER_ERROR),
            older_stamps_s=tuple(older),
            missing=missing,
            were_all=len(older) + 1 >= lent,
        )

    def _wait(self, waiting: select.poll, timeout_s: float) -> structs.Buffer | None:
        """Return the next filled buffer; a driver may announce one and then have none."""
        end_s = self._clock() + timeout_s
        for _ in range(_MOST_FALSE_ALARMS):
            left_s = end_s - self._clock()
            if left_s < 0.0 or not waiting.poll(1000.0 * left_s):
                return None
            buffer = self._dequeue()
            if buffer is not None:
                return buffer
        return None

    def _hand_back(self) -> None:
        held, self._held = self._held, None
        if held is not None:
            self._node.ask(structs.QBUF, _buffer(held.index))

    def _dequeue(self) -> structs.Buffer | None:
        try:
            buffer = self._node.ask(structs.DQBUF, _buffer(0))
        except OSError as error:
            if error.errno == errno.EAGAIN:
                return None
            raise
        if buffer.index >= len(self._maps):
            raise OSError(errno.EIO, f"the driver speaks of a buffer {buffer.index}")
        return buffer

    def _missing(self, buffer: structs.Buffer) -> int:
        """Pictures skipped before this one; numbers wrap at 2^32."""
        last, self._sequence = self._sequence, int(buffer.sequence)
        if last is None:
            return 0
        step = (self._sequence - last) % (1 << 32)
        return step - 1 if 1 <= step <= _MOST_MISSING else 0


_MOST_MISSING: Final = 10_000
"""A larger step means that the numbers began again."""


def _buffer(index: int) -> structs.Buffer:
    return structs.Buffer(index=index, type=structs.CAPTURE, memory=structs.MMAP)


def _stamp_s(buffer: structs.Buffer) -> float:
    return float(buffer.timestamp.tv_sec) + 1e-6 * float(buffer.timestamp.tv_usec)
