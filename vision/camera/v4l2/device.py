"""A V4L2 device as a camera: found, set, started and read.

Rules and units
- Format, size and rate are chosen from the device's list (`modes`) and requested, then controls are
  set (`controls`). ``reason`` reports differences; the rate is measured. -
- A picture's time is that of its last row: a stamp of the exposure's begin is shifted.
- A picture without a believable stamp has the time of its reading, unless every buffer was filled:
  then it waited for a program that was frozen, and is dropped.
- Times are seconds on the clock passed in; sizes are (width, height) in pixels.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from vision.camera.camera import (
    CameraAbsentError,
    CameraError,
    CameraHeldError,
    Clock,
    Frame,
    RateMeter,
    SourceState,
)
from vision.camera.rate_remark import RIGHT, RateRemark
from vision.camera.v4l2 import structs
from vision.camera.v4l2.controls import CameraControls, set_controls
from vision.camera.v4l2.identity import KnownCamera
from vision.camera.v4l2.modes import ORDER, Choice, Size, Wanted, list_modes, rank_modes
from vision.camera.v4l2.node import Node
from vision.camera.v4l2.pixels import picture_of
from vision.camera.v4l2.stream import Agreed, Filled, Stream
from vision.camera.v4l2.users import who_uses

FIRST_PICTURE_S: Final = 5.0
"""Below ``WatchLimits.hung_s``; webcams may take three seconds."""
_DRIVER_CLOCK_LIMIT_S: Final = 0.5
_FRAMES_FOR_RATE: Final = 30
_DAMAGED_A_READ: Final = 5
"""Damaged pictures that one read skips: webcams begin with one or two."""
MOST_DAMAGED: Final = 60
"""Damaged pictures in a row, two seconds of them, after which the camera has failed."""
_DAMAGED_WINDOW: Final = 300
_DAMAGED_SHARE: Final = 0.01
_MUTE: Final = (errno.EIO, errno.ETIMEDOUT, errno.EPROTO, errno.EPIPE)
"""Errors of USB's driver for a plugged device that hangs."""
_GONE: Final = (errno.ENODEV, errno.ENXIO, errno.ENOENT, errno.EBADF)


@dataclass(frozen=True, slots=True)
class DeviceSettings:
    """Requests to a device beside size and rate; ``controls`` None leaves them alone.

    ``rolling_shutter_s`` is the time from the first row's exposure to the last row's.
    """

    format: Wanted = "auto"
    controls: CameraControls | None = None
    colour: bool = True
    rolling_shutter_s: float = 0.0


@dataclass(slots=True)
class _Damage:
    total: int = 0
    in_a_row: int = 0
    _seen: int = 0
    _damaged: int = 0
    said: str = field(default="")

    def add(self, is_damaged: bool) -> None:
        self.total += is_damaged
        self.in_a_row = self.in_a_row + 1 if is_damaged else 0
        self._seen += 1
        self._damaged += is_damaged
        if self._seen >= _DAMAGED_WINDOW:
            much = self._damaged > _DAMAGED_SHARE * self._seen
            # without its number, which would make a new line for each window
            self.said = "more than 1 % of its pictures are damaged and dropped" if much else ""
            self._seen = self._damaged = 0


class DeviceCamera:
    """V4L2 camera by its index (``0``) or path (``/dev/video0``, ``/dev/v4l/by-id/...``).

    ``known`` remembers the camera from one object to the next.
    """

    may_repeat = False

    def __init__(
        self,
        device: str,
        clock: Clock,
        rate_hz: float | None,
        size: Size | None,
        settings: DeviceSettings | None = None,
        known: KnownCamera | None = None,
    ) -> None:
        self.name = f"camera {device}"
        self.state: SourceState = "closed"
        self.reason = ""
        self.mode: Agreed | None = None
        """Mode agreed on with the driver, while the device is open."""
        self.missing = 0
        """Pictures that the driver skipped, by its own numbers."""
        self._path = f"/dev/video{device}" if device.isdecimal() else device
        self._clock = clock
        self._rate_wanted_hz, self._size_wanted = rate_hz, size
        self._settings = settings or DeviceSettings()
        self._known = known or KnownCamera()
        self._node: Node | None = None
        self._stream: Stream | None = None
        self._reset()

    def _reset(self) -> None:
        self._rate = RateMeter()
        self._remark = RateRemark(self._rate_wanted_hz)
        self._damage = _Damage()
        self._sequence = 0
        self._promise: list[str] = []
        self._promised_rate = ""

    @property
    def rate_hz(self) -> float:
        """Measured frames a second."""
        return self._rate.rate_hz

    @property
    def damaged(self) -> int:
        """Number of damaged pictures dropped since opening."""
        return self._damage.total

    @property
    def node(self) -> Node | None:
        """Open device, for its controls; None while closed."""
        return self._node

    def open(self) -> None:
        """Open the device; ``CameraError`` if it is missing, busy or not a camera."""
        self.close()
        self._reset()
        path, found = self._known.find(self._path)
        if not os.path.exists(path):
            raise CameraAbsentError(f"{self.name}: {path} does not exist; is it plugged in?")
        if not os.access(path, os.R_OK | os.W_OK):
            raise CameraError(
                f"{self.name}: no permission for {path}; add the user to the group 'video'"
            )
        try:
            node = Node(path)
        except OSError as error:
            raise self._refused(path, error) from error
        self._node = node
        try:
            self._begin(node)
        except OSError as error:
            self.close()
            raise self._refused(path, error) from error
        except CameraError:
            self.close()
            raise
        self._known.remember(path)
        self.state = "running"
        self._promise = [text for text in (found, *self._promise) if text]
        self.reason = self._said(self._promised_rate)

    def _begin(self, node: Node) -> None:
        choices = self._choices(node)
        for number, choice in enumerate(choices):
            stream = Stream(node, self._clock)
            agreed = stream.agree(choice)
            if agreed.fourcc not in ORDER:
                continue
            try:
                stream.start()
            except OSError as error:
                stream.stop()
                # USB has no room for raw pictures beside another camera's: packed ones may fit
                if error.errno == errno.ENOSPC and number + 1 < len(choices):
                    continue
                raise
            self._stream, self.mode = stream, agreed
            self._promise = self._other_size(agreed)
            self._promised_rate = self._other_rate(agreed)
            if self._settings.controls is not None:
                self._promise += set_controls(node, self._settings.controls)
            return
        raise CameraError(f"{self.name}: gives no pixel format that Clearway reads")

    def _choices(self, node: Node) -> Sequence[Choice]:
        about = node.about()
        if not about.gives_pictures:
            raise CameraError(
                f"{self.name}: {node.path} gives no pictures; `clearway devices` lists what does"
            )
        if not about.can & structs.CAN_CAPTURE:
            raise CameraError(
                f"{self.name}: {node.path} gives its pictures in several planes, which Clearway "
                "does not read; serve it as a stream (rtsp://)"
            )
        size = self._size_wanted or current_size(node)
        modes = list_modes(node, size)
        choices = rank_modes(modes, size, self._rate_wanted_hz, self._settings.format)
        if not choices:
            offered = ", ".join(dict.fromkeys(mode.fourcc for mode in modes)) or "nothing"
            wanted = self._settings.format
            asked = "a format that Clearway reads" if wanted == "auto" else f"format {wanted}"
            raise CameraError(f"{self.name}: asked for {asked}, the camera offers {offered}")
        return choices

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next frame; None if none came in ``timeout_s``, five seconds for the first."""
        stream, agreed = self._stream, self.mode
        if stream is None or agreed is None:
            raise CameraError(f"{self.name}: read while closed")
        is_first = self._sequence == 0 and self._damage.total == 0
        for _ in range(_DAMAGED_A_READ):
            filled = self._take(stream, FIRST_PICTURE_S if is_first else timeout_s)
            if filled is None:
                if is_first:
                    raise CameraError(f"{self.name}: the camera delivers no picture")
                return None
            frame = self._frame_of(filled, agreed)
            if frame is not None:
                return frame
        return None

    def _take(self, stream: Stream, timeout_s: float) -> Filled | None:
        try:
            filled = stream.take(timeout_s)
        except OSError as error:
            raise self._lost(error) from error
        if filled is None and not os.path.exists(self._node.path if self._node else ""):
            raise CameraAbsentError(f"{self.name}: unplugged ({self._path} is gone)")
        return filled

    def _lost(self, error: OSError) -> CameraError:
        if error.errno in _GONE or (self._node and not os.path.exists(self._node.path)):
            return CameraAbsentError(f"{self.name}: unplugged ({self._path} is gone)")
        return CameraError(f"{self.name}: the driver gives no picture: {error.strerror or error}")

    def _frame_of(self, filled: Filled, agreed: Agreed) -> Frame | None:
        grabbed_s = self._clock()
        self.missing += filled.missing
        if filled.were_all and not is_on_our_clock(filled.stamp_s, grabbed_s):
            return None
        image = None
        if not filled.is_damaged:
            image = picture_of(
                filled.data, agreed.fourcc, agreed.size, agreed.bytes_per_line,
                colour=self._settings.colour,
            )  # fmt: skip
        self._damage.add(image is None)
        if image is None:
            if self._damage.in_a_row >= MOST_DAMAGED:
                raise CameraError(
                    f"{self.name}: {MOST_DAMAGED} damaged pictures in a row; try a shorter cable "
                    "or another USB port"
                )
            return None
        for stamp_s in filled.older_stamps_s:
            self._rate.add(self._time_s(stamp_s, filled, grabbed_s))
        captured_s = self._time_s(filled.stamp_s, filled, grabbed_s)
        self._rate.add(captured_s)
        frame = Frame(image, captured_s, self._sequence, self.name)
        self._sequence += 1
        rate_hz = self.rate_hz if self._sequence >= _FRAMES_FOR_RATE else 0.0
        rate = self._remark.of(rate_hz, grabbed_s)
        # a measured rate counts more than a promised one
        self.reason = self._said(rate if rate_hz > 0.0 else self._promised_rate)
        return frame

    def _said(self, rate: str) -> str:
        return "; ".join(text for text in (*self._promise, rate, self._damage.said) if text)

    def _time_s(self, stamp_s: float, filled: Filled, grabbed_s: float) -> float:
        """Time of the last row's exposure, by the driver's stamp if it is on our clock."""
        captured_s = driver_time_s(1000.0 * stamp_s, grabbed_s)
        if filled.stamped_at_start and captured_s < grabbed_s:
            return min(captured_s + self._settings.rolling_shutter_s, grabbed_s)
        return captured_s

    def close(self) -> None:
        """Free the device; harmless when closed."""
        stream, self._stream = self._stream, None
        node, self._node = self._node, None
        self.mode = None
        if stream is not None:
            stream.stop()
        if node is not None:
            node.close()
        self.state = "closed"

    def _other_size(self, agreed: Agreed) -> list[str]:
        if self._size_wanted is None or agreed.size == self._size_wanted:
            return []
        (wide, high), (width, height) = self._size_wanted, agreed.size
        return [f"asked for {wide}x{high} pixels, the driver gives {width}x{height}"]

    def _other_rate(self, agreed: Agreed) -> str:
        wanted_hz, rate_hz = self._rate_wanted_hz, agreed.rate_hz
        if wanted_hz is None or rate_hz is None or abs(rate_hz / wanted_hz - 1.0) <= RIGHT:
            return ""
        return f"asked for {wanted_hz:g} frames/s, the driver promises {rate_hz:g}"

    def _refused(self, path: str, error: OSError) -> CameraError:
        if error.errno == errno.EBUSY:
            return CameraHeldError(f"{self.name}: {path} is busy", who_uses(path))
        if error.errno in _GONE:
            return CameraAbsentError(f"{self.name}: unplugged ({path} is gone)")
        if error.errno == errno.ENOSPC:
            return CameraError(
                f"{self.name}: USB has no room for its pictures; plug it into another port, or "
                "lower size_px or rate_hz"
            )
        if error.errno in (errno.ENOTTY, errno.EINVAL):
            return CameraError(
                f"{self.name}: {path} gives no pictures; `clearway devices` lists what does"
            )
        if error.errno in _MUTE:
            return CameraError(
                f"{self.name}: does not answer ({error.strerror}); unplug it and plug it in again"
            )
        return CameraError(f"{self.name}: cannot be opened: {error.strerror or error}")


def driver_time_s(position_ms: float, grabbed_s: float) -> float:
    """Convert a V4L2 stamp (ms) to seconds, or return ``grabbed_s`` if it is on another clock."""
    stamp_s = position_ms / 1000.0
    return stamp_s if is_on_our_clock(stamp_s, grabbed_s) else grabbed_s


def is_on_our_clock(stamp_s: float, grabbed_s: float) -> bool:
    """True unless a driver's stamp is in the future, or more than half a second back."""
    return 0.0 <= grabbed_s - stamp_s <= _DRIVER_CLOCK_LIMIT_S


def current_size(node: Node) -> Size:
    """Size that the device is set to."""
    pixels = node.ask(structs.G_FMT, structs.Format(type=structs.CAPTURE)).fmt.pix
    return int(pixels.width), int(pixels.height)
