"""What a USB camera says of itself: its descriptors, and the answer to what is asked of its stream.

A camera has a control interface (sensor, processing unit, output) and a streaming interface with
one bulk endpoint. Times in descriptors are units of 100 ns, rates here frames a second.

Sources: USB 2.0, chapter 9; USB Video Class 1.0, chapters 3 and 4.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

ENDPOINT = 0x81
PACKET_SIZE = 512
TRANSFER_SIZE = 16384
"""The most in one bulk transfer, its header included."""
CAMERA, PROCESSING, OUTPUT = 1, 2, 3
"""The units of the control interface, by their numbers."""
UVC_VERSION = 0x0100
VIDEO = 0x0E
DEVICE_CLASS = (0xEF, 2, 1)
"""A device whose functions have several interfaces each."""
INTERFACES = [(VIDEO, 1, 0), (VIDEO, 2, 0)]
CAPTURE_TERMINAL, STREAM_TERMINAL = 0x0201, 0x0101
SENSOR_CONTROLS = 0b1010
"""Exposure's mode and its time."""
PROCESSING_CONTROLS = 0b10_0000_0001
"""Brightness and gain."""
YUYV_GUID = b"YUY2" + bytes.fromhex("00001000800000aa00389b71")


@dataclass(frozen=True, slots=True)
class PictureSize:
    """A size in pixels and the rates that it has, the default first."""

    width: int
    height: int
    rates_hz: tuple[float, ...]

    @property
    def spans(self) -> tuple[int, ...]:
        """Between two pictures, in units of 100 ns."""
        return tuple(round(1e7 / rate) for rate in self.rates_hz)


@dataclass(frozen=True, slots=True)
class PictureFormat:
    """A pixel format with its sizes."""

    fourcc: Literal["YUYV", "MJPG"]
    sizes: tuple[PictureSize, ...]


@dataclass(frozen=True, slots=True)
class StreamChoice:
    """Format, size and span between pictures that are agreed on, and their numbers from one."""

    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<HBBIHHHHHII")

    format_number: int
    size_number: int
    span: int
    fourcc: str
    size: PictureSize

    @property
    def rate_hz(self) -> float:
        """Pictures a second."""
        return 1e7 / self.span

    def to_bytes(self) -> bytes:
        """As the probe and commit controls have it."""
        most = 2 * self.size.width * self.size.height
        head = (1, self.format_number, self.size_number, self.span)
        return self.LAYOUT.pack(*head, 0, 0, 0, 0, 0, most, TRANSFER_SIZE)


def choose(formats: Sequence[PictureFormat], asked: bytes) -> StreamChoice:
    """What a camera makes of a probe: the nearest that it has."""
    _, number, size_number, span = struct.unpack_from("<HBBI", asked)
    number = min(max(number, 1), len(formats))
    form = formats[number - 1]
    size_number = min(max(size_number, 1), len(form.sizes))
    size = form.sizes[size_number - 1]
    span = min(size.spans, key=lambda one: abs(one - span)) if span else size.spans[0]
    return StreamChoice(number, size_number, span, form.fourcc, size)


def device_descriptor(vendor: int, product: int) -> bytes:
    """Who made it, and which strings name maker, product and serial number."""
    ids = struct.pack("<HHH", vendor, product, 0x0100)
    return _descriptor(1, struct.pack("<H", 0x0200), bytes([*DEVICE_CLASS, 64]), ids, b"\1\2\3\1")


def string_descriptor(text: str) -> bytes:
    """A text; the empty one stands for the list of languages, which is American English."""
    return _descriptor(3, text.encode("utf-16-le") if text else b"\x09\x04")


def configuration_descriptor(formats: Sequence[PictureFormat]) -> bytes:
    """The whole configuration with its interfaces."""
    association = _descriptor(11, bytes([0, 2, VIDEO, 3, 0, 2]))
    parts = association + _control_interface() + _streaming_interface(formats)
    head = struct.pack("<HBBBBB", 9 + len(parts), len(INTERFACES), 1, 0, 0x80, 250)
    return _descriptor(2, head) + parts


def _control_interface() -> bytes:
    sensor = struct.pack("<BHBBHHHB", CAMERA, CAPTURE_TERMINAL, 0, 0, 0, 0, 0, 3)
    units = _video(2, sensor, SENSOR_CONTROLS.to_bytes(3, "little"))
    processing = struct.pack("<BBHB", PROCESSING, CAMERA, 0, 2)
    units += _video(5, processing, PROCESSING_CONTROLS.to_bytes(2, "little"), b"\0")
    units += _video(3, struct.pack("<BHBBB", OUTPUT, STREAM_TERMINAL, 0, PROCESSING, 0))
    head = struct.pack("<HHIBB", UVC_VERSION, 13 + len(units), 48_000_000, 1, 1)
    return _descriptor(4, bytes([0, 0, 0, *INTERFACES[0], 2])) + _video(1, head) + units


def _streaming_interface(formats: Sequence[PictureFormat]) -> bytes:
    body = b"".join(_format(number, form) for number, form in enumerate(formats, 1))
    count = len(formats)
    size = 13 + count + len(body)
    head = struct.pack("<BHBBBBBBB", count, size, ENDPOINT, 0, OUTPUT, 0, 0, 0, 1)
    endpoint = _descriptor(5, struct.pack("<BBHB", ENDPOINT, 2, PACKET_SIZE, 0))
    interface = _descriptor(4, bytes([1, 0, 1, *INTERFACES[1], 2]))
    return interface + _video(1, head, bytes(count)) + body + endpoint


def _format(number: int, form: PictureFormat) -> bytes:
    begin = bytes([number, len(form.sizes)])
    if form.fourcc == "MJPG":
        kind, text = 7, _video(6, begin, bytes([1, 1, 0, 0, 0, 0]))
    else:
        kind, text = 5, _video(4, begin, YUYV_GUID, bytes([16, 1, 0, 0, 0, 0]))
    for index, size in enumerate(form.sizes, 1):
        pixels = size.width * size.height
        slow, fast = 16 * pixels, 16 * pixels * 30
        numbers = (index, 0, size.width, size.height, slow, fast, 2 * pixels, size.spans[0])
        spans = struct.pack(f"<B{len(size.spans)}I", len(size.spans), *size.spans)
        text += _video(kind, struct.pack("<BBHHIIII", *numbers), spans)
    return text


def _descriptor(kind: int, *parts: bytes) -> bytes:
    body = b"".join(parts)
    return bytes([2 + len(body), kind]) + body


def _video(kind: int, *parts: bytes) -> bytes:
    """A descriptor of the video class."""
    return _descriptor(0x24, bytes([kind]), *parts)
