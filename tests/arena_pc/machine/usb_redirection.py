"""The device's side of usbredir: a USB device that a program is, for QEMU's ``usb-redir``.

Packets have a kind, a number that an answer repeats, and a body; all numbers are little-endian.
Only what a high-speed device with one bulk endpoint needs is here.

Source: usbredirproto.h, version 0.7.
"""

from __future__ import annotations

import contextlib
import enum
import socket
import struct
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

from tests.arena_pc.machine.json_lines import connected

CONNECT_WITHIN_S = 10.0
HELLO_HEADER, HEADER = struct.Struct("<III"), struct.Struct("<IIQ")
"""Both ends number their packets with 64 bits, once they have said hello."""
CAN = 1 << 1 | 1 << 3 | 1 << 4 | 1 << 5 | 1 << 6
"""What an xHCI controller wants: device versions, acknowledged disconnection, sizes of packets,
long numbers of packets, long bulk transfers."""
ENDPOINTS = 32
NO_ENDPOINT = 255
HIGH_SPEED = 2


class Kind(enum.IntEnum):
    """What a packet is."""

    HELLO = 0
    DEVICE_CONNECT = 1
    RESET = 3
    INTERFACES = 4
    ENDPOINTS = 5
    SET_CONFIGURATION = 6
    GET_CONFIGURATION = 7
    CONFIGURATION_STATUS = 8
    SET_ALTERNATE = 9
    GET_ALTERNATE = 10
    ALTERNATE_STATUS = 11
    CANCEL = 21
    CONTROL = 100
    BULK = 101


class Status(enum.IntEnum):
    """How a transfer ended."""

    SUCCESS = 0
    CANCELLED = 1
    STALL = 4


@dataclass(frozen=True, slots=True)
class Packet:
    """What the host's end has sent."""

    kind: int
    number: int
    body: bytes


@dataclass(frozen=True, slots=True)
class ControlRequest:
    """A control transfer, its names as in USB 2.0, 9.3; ``data`` is what the host sends along."""

    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<BBBBHHH")

    request: int
    request_type: int
    value: int
    index: int
    length: int
    data: bytes

    @classmethod
    def of(cls, packet: Packet) -> Self:
        """Read it from a packet."""
        _, request, kind, _, value, index, length = cls.LAYOUT.unpack_from(packet.body)
        return cls(request, kind, value, index, length, packet.body[cls.LAYOUT.size :])

    @property
    def is_question(self) -> bool:
        """Whether data goes to the host."""
        return bool(self.request_type & 0x80)

    def answer(self, data: bytes | None) -> bytes:
        """The answer's body; None: the device refuses."""
        status = Status.STALL if data is None else Status.SUCCESS
        sent = (data or b"")[: self.length] if self.is_question else b""
        done = len(sent) if self.is_question else self.length
        head = (0x80 if self.is_question else 0, self.request, self.request_type, status)
        return self.LAYOUT.pack(*head, self.value, self.index, done) + sent


@dataclass(frozen=True, slots=True)
class BulkRequest:
    """A buffer that the host wants filled with ``room`` bytes at most."""

    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<BBHIH")

    number: int
    endpoint: int
    room: int

    @classmethod
    def of(cls, packet: Packet) -> Self:
        """Read it from a packet."""
        endpoint, _, low, _, high = cls.LAYOUT.unpack_from(packet.body)
        return cls(packet.number, endpoint, high << 16 | low)

    def answer(self, data: bytes, status: Status = Status.SUCCESS) -> bytes:
        """The answer's body."""
        size = len(data)
        return self.LAYOUT.pack(self.endpoint, status, size & 0xFFFF, 0, size >> 16) + data


class DeviceEnd:
    """The line to the emulator. ``close`` is what pulling the plug is."""

    def __init__(self, path: Path) -> None:
        self._socket = connected(path, CONNECT_WITHIN_S)
        self._one_sends = threading.Lock()
        hello = b"clearway arena pc".ljust(64, b"\0") + struct.pack("<I", CAN)
        self._socket.sendall(HELLO_HEADER.pack(Kind.HELLO, len(hello), 0) + hello)
        self._next_header = HELLO_HEADER

    def send(self, kind: Kind, number: int, body: bytes) -> None:
        """Send a packet; ``OSError`` where the line is cut."""
        with self._one_sends:
            self._socket.sendall(HEADER.pack(kind, len(body), number) + body)

    def receive(self) -> Packet | None:
        """The next packet; None where the line is cut."""
        head = self._exactly(self._next_header.size)
        if head is None:
            return None
        kind, size, number = self._next_header.unpack(head)
        self._next_header = HEADER
        body = self._exactly(size)
        return None if body is None else Packet(kind, number, body)

    def _exactly(self, size: int) -> bytes | None:
        got = bytearray()
        while len(got) < size:
            try:
                more = self._socket.recv(size - len(got))
            except OSError:
                return None
            if not more:
                return None
            got += more
        return bytes(got)

    def close(self) -> None:
        """Cut the line; harmless when it is cut."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def announce(self, interfaces: list[tuple[int, int, int]], endpoint: int, size: int) -> None:
        """Say which interfaces (class, subclass, protocol) there are, and the one endpoint.

        The endpoint is a bulk one towards the host, of the last interface.
        """
        columns = [range(len(interfaces)), *zip(*interfaces, strict=True)]
        body = struct.pack("<I", len(interfaces))
        self.send(Kind.INTERFACES, 0, body + b"".join(bytes(c).ljust(32, b"\0") for c in columns))
        types, owners, sizes = [NO_ENDPOINT] * ENDPOINTS, [0] * ENDPOINTS, [0] * ENDPOINTS
        for control in (0, 16):
            types[control], sizes[control] = 0, 64
        at = endpoint & 0x0F | (endpoint & 0x80) >> 3
        types[at], owners[at], sizes[at] = 2, len(interfaces) - 1, size
        body = bytes(types) + bytes(ENDPOINTS) + bytes(owners)
        self.send(Kind.ENDPOINTS, 0, body + struct.pack(f"<{ENDPOINTS}H", *sizes))

    def plug_in(self, device_class: tuple[int, int, int], vendor: int, product: int) -> None:
        """Say that the device is there."""
        head = bytes([HIGH_SPEED, *device_class])
        self.send(Kind.DEVICE_CONNECT, 0, head + struct.pack("<HHH", vendor, product, 0x0100))
