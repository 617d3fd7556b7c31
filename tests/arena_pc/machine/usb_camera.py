"""A USB camera in a program: the guest's own ``uvcvideo`` takes it for a real one.

It has formats, rates and controls of its own choice, and can fall silent, hang, refuse controls
and be pulled out. Pictures are sent at the rate that was agreed on, by the host's clock.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.arena_pc.machine import uvc_descriptors as uvc
from tests.arena_pc.machine.usb_redirection import (
    BulkRequest,
    ControlRequest,
    DeviceEnd,
    Kind,
    Packet,
    Status,
)

Picture = Callable[[str, int, int, int], bytes]
"""The bytes of a picture: of a pixel format, width, height and number."""

VENDOR, PRODUCT = 0x1BCF, 0x0B09
MAKER = "Clearway test"
LOOK_EVERY_S = 0.2
STREAM_HEADER = 2
SET_CUR, GET_CUR, GET_MIN, GET_MAX, GET_RES, GET_LEN, GET_INFO, GET_DEF = (
    *(0x01, 0x81, 0x82, 0x83, 0x84, 0x85, 0x86),
    0x87,
)
CAN_READ_AND_WRITE = b"\x03"
STANDARD_IN, CLASS, ENDPOINT_OUT = 0x80, 0x21, 0x02
CLEAR_FEATURE, GET_STATUS, GET_DESCRIPTOR = 1, 0, 6
PROBE, COMMIT = 1, 2


@dataclass(slots=True)
class Control:
    """A control of a unit; ``obeys`` False: it stalls what is asked of it."""

    size: int
    least: int
    most: int
    step: int
    default: int
    obeys: bool = True
    value: int = field(init=False)

    def __post_init__(self) -> None:
        self.value = self.default

    def answer(self, request: ControlRequest) -> bytes | None:
        """What it answers; None: it refuses."""
        if request.request == SET_CUR:
            if not self.obeys:
                return None
            self.value = int.from_bytes(request.data[: self.size], "little")
            return b""
        numbers = {
            GET_CUR: self.value,
            GET_MIN: self.least,
            GET_MAX: self.most,
            GET_RES: self.step,
            GET_DEF: self.default,
        }
        if request.request in numbers:
            return numbers[request.request].to_bytes(self.size, "little")
        length = self.size.to_bytes(2, "little")
        return {GET_LEN: length, GET_INFO: CAN_READ_AND_WRITE}.get(request.request)


def usual_controls() -> dict[str, Control]:
    """What a webcam has: exposure's mode (1: by hand) and time (100 us), brightness, gain."""
    return {
        "exposure_mode": Control(1, 1, 15, 9, 8),
        "exposure": Control(4, 3, 2047, 1, 250),
        "brightness": Control(2, 0, 255, 1, 128),
        "gain": Control(2, 0, 255, 1, 64),
    }


PLACES = {
    (uvc.CAMERA, 2): "exposure_mode",
    (uvc.CAMERA, 4): "exposure",
    (uvc.PROCESSING, 2): "brightness",
    (uvc.PROCESSING, 4): "gain",
}
"""Unit and selector of each control."""


class UsbCamera:
    """A camera that is plugged into the end of a usbredir line, until it is unplugged."""

    def __init__(
        self, path: Path, picture: Picture, formats: Sequence[uvc.PictureFormat], serial: str
    ) -> None:
        self.controls = usual_controls()
        self.chosen: list[tuple[str, int, int, float]] = []
        """Each start of a stream: pixel format, width, height, pictures a second."""
        self.sent = 0
        """Whole pictures."""
        self.is_silent = False
        """It sends no more pictures, and answers questions."""
        self.is_hung = False
        """It answers nothing at all."""
        self._picture, self._formats = picture, tuple(formats)
        self._strings = ("", MAKER, "Arena Camera", serial)
        self._choice = uvc.choose(self._formats, bytes(8))
        self._streams = False
        self._wanted: deque[BulkRequest] = deque()
        self._changed = threading.Condition()
        self._is_in = True
        self._line = DeviceEnd(path)
        self._threads = [threading.Thread(target=f) for f in (self._serve, self._send_pictures)]
        for thread in self._threads:
            thread.start()

    def unplug(self) -> None:
        """Pull it out; harmless when it is out."""
        with self._changed:
            self._is_in = False
            self._changed.notify_all()
        self._line.close()
        for thread in self._threads:
            thread.join()

    def _serve(self) -> None:
        while (packet := self._line.receive()) is not None:
            if not self.is_hung:
                with contextlib.suppress(OSError):
                    self._answer(packet)
        with self._changed:
            self._is_in = False
            self._changed.notify_all()

    def _answer(self, packet: Packet) -> None:
        number, body = packet.number, packet.body
        match packet.kind:
            case Kind.HELLO:
                self._announce()
                self._line.plug_in(uvc.DEVICE_CLASS, VENDOR, PRODUCT)
            case Kind.SET_CONFIGURATION:
                self._announce()
                self._line.send(Kind.CONFIGURATION_STATUS, number, bytes([0, body[0]]))
            case Kind.GET_CONFIGURATION:
                self._line.send(Kind.CONFIGURATION_STATUS, number, bytes([0, 1]))
            case Kind.SET_ALTERNATE:
                self._stop()
                self._line.send(Kind.ALTERNATE_STATUS, number, bytes([0, *body[:2]]))
            case Kind.GET_ALTERNATE:
                self._line.send(Kind.ALTERNATE_STATUS, number, bytes([0, body[0], 0]))
            case Kind.RESET:
                self._stop()
            case Kind.CONTROL:
                request = ControlRequest.of(packet)
                self._line.send(Kind.CONTROL, number, request.answer(self._control(request)))
            case Kind.BULK:
                with self._changed:
                    self._wanted.append(BulkRequest.of(packet))
                    self._changed.notify_all()
            case Kind.CANCEL:
                self._cancel(number)

    def _announce(self) -> None:
        self._line.announce(uvc.INTERFACES, uvc.ENDPOINT, uvc.PACKET_SIZE)

    def _cancel(self, number: int) -> None:
        with self._changed:
            found = [request for request in self._wanted if request.number == number]
            for request in found:
                self._wanted.remove(request)
        for request in found:
            self._line.send(Kind.BULK, number, request.answer(b"", Status.CANCELLED))

    def _stop(self) -> None:
        with self._changed:
            self._streams = False
            self._changed.notify_all()

    def _control(self, request: ControlRequest) -> bytes | None:
        if request.request_type == STANDARD_IN:
            if request.request == GET_DESCRIPTOR:
                return self._descriptor(request.value >> 8, request.value & 0xFF)
            return b"\0\0" if request.request == GET_STATUS else None
        if request.request_type == ENDPOINT_OUT and request.request == CLEAR_FEATURE:
            self._stop()  # so uvcvideo ends a stream over a bulk endpoint
            return b""
        if request.request_type & 0x7F != CLASS:
            return None
        unit, selector = request.index >> 8, request.value >> 8
        if request.index & 0xFF == 1:
            return self._stream_control(request, selector)
        name = PLACES.get((unit, selector))
        return None if name is None else self.controls[name].answer(request)

    def _descriptor(self, kind: int, number: int) -> bytes | None:
        if kind == 1:
            return uvc.device_descriptor(VENDOR, PRODUCT)
        if kind == 2:
            return uvc.configuration_descriptor(self._formats)
        if kind == 3 and number < len(self._strings):
            return uvc.string_descriptor(self._strings[number])
        return None

    def _stream_control(self, request: ControlRequest, selector: int) -> bytes | None:
        if request.request == SET_CUR:
            with self._changed:
                self._choice = choice = uvc.choose(self._formats, request.data)
                if selector == COMMIT:
                    size = choice.size.width, choice.size.height
                    self.chosen.append((choice.fourcc, *size, choice.rate_hz))
                    self._streams = True
                    self._changed.notify_all()
            return b""
        if request.request in (GET_CUR, GET_MIN, GET_MAX, GET_DEF):
            return self._choice.to_bytes()
        length = uvc.StreamChoice.LAYOUT.size.to_bytes(2, "little")
        return {GET_LEN: length, GET_INFO: CAN_READ_AND_WRITE}.get(request.request)

    def _send_pictures(self) -> None:
        number = 0
        due_s = time.monotonic()
        while self._wait_for_stream():
            choice = self._choice
            span_s = 1.0 / choice.rate_hz
            due_s = max(due_s + span_s, time.monotonic() - span_s)
            time.sleep(max(0.0, due_s - time.monotonic()))  # the rate that it offers
            size = choice.size
            picture = self._picture(choice.fourcc, size.width, size.height, number)
            with contextlib.suppress(OSError):  # unplugged
                self.sent += self._send_picture(picture, number & 1)
            number += 1

    def _wait_for_stream(self) -> bool:
        """Wait until pictures are wanted; False: the camera was unplugged."""
        with self._changed:
            while self._is_in and not (
                self._streams and self._wanted and not self.is_silent and not self.is_hung
            ):
                self._changed.wait(LOOK_EVERY_S)
            return self._is_in

    def _send_picture(self, picture: bytes, toggle: int) -> bool:
        """Whether the whole picture went out before the stream ended."""
        at = 0
        while at < len(picture):
            with self._changed:
                while self._is_in and self._streams and not self._wanted:
                    self._changed.wait(LOOK_EVERY_S)
                if not (self._is_in and self._streams):
                    return False
                request = self._wanted.popleft()
            part = picture[at : at + min(request.room, uvc.TRANSFER_SIZE) - STREAM_HEADER]
            at += len(part)
            ends = at >= len(picture)
            header = bytes([STREAM_HEADER, 0x80 | ends << 1 | toggle])
            self._line.send(Kind.BULK, request.number, request.answer(header + part))
        return True
