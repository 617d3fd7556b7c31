"""Cameras behind OpenCV's capture: V4L2 devices and network streams.

Rules and units
- What a driver made of the rate and size asked for is compared with what it gives; the
  difference is said in ``reason``, as the real rate is measured and never taken on trust.
- No wait for a picture is longer than five seconds: then a device or stream has failed.
- Times are seconds on the clock passed in; sizes are (width, height) in pixels.
"""

from __future__ import annotations

import glob
import math
import os
from pathlib import Path

import cv2
import numpy as np

from vision.camera.arrival_clock import ArrivalClock
from vision.camera.camera import (
    CameraError,
    CameraHeldError,
    Clock,
    Frame,
    Image,
    RateMeter,
    SourceState,
)
from vision.camera.v4l2 import gives_pictures

_LONGEST_WAIT_S = 5
"""Below ``WatchLimits.hung_s``; webcams may take three seconds to their first picture."""
_SELECT_TIMEOUT = "OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT"
"""For how many whole seconds OpenCV waits for a V4L2 device, 10 by itself. It has no property for
that (the timeouts in milliseconds are FFmpeg's and GStreamer's), and reads this variable once in
a process, when it first waits."""
_DRIVER_CLOCK_LIMIT_S = 0.5
_FRAMES_FOR_RATE = 30
_LONGEST_HOLD_UP_S = 2.0
"""A picture that its stamp makes older than this has a stamp that cannot be trusted."""
_BURST_S = 1.0
"""How long after opening a stream's frames say nothing of its rate: what its server or FFmpeg had
kept comes all at once."""


class Capture:
    """What devices, streams and video files share: an OpenCV capture and its frames."""

    may_repeat = False

    def __init__(self, name: str, clock: Clock) -> None:
        self.name = name
        self.state: SourceState = "closed"
        self.reason = ""
        self._clock = clock
        self._rate = RateMeter()
        self._capture: cv2.VideoCapture | None = None
        self._sequence = 0

    @property
    def rate_hz(self) -> float:
        """Frames a second really got."""
        return self._rate.rate_hz

    def close(self) -> None:
        """Free the device; harmless when closed."""
        capture, self._capture = self._capture, None
        if capture is not None:
            capture.release()
        self.state = "closed"

    def _start(self, target: str | int, backend: int, parameters: list[int]) -> cv2.VideoCapture:
        self.close()
        capture = cv2.VideoCapture()
        try:
            opened = capture.open(target, backend, parameters)
        except cv2.error as error:
            raise CameraError(f"{self.name}: cannot be opened: {error.err}") from error
        if not opened:
            capture.release()
            raise self._refused()
        # The sensor's own pixels, as of pictures: a film's turn says how its camera was held.
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        self._capture = capture
        self._rate = RateMeter()
        self.state, self.reason = "running", ""
        return capture

    def _refused(self) -> CameraError:
        return CameraError(f"{self.name}: cannot be opened")

    def _grab(self) -> tuple[Image, float] | None:
        """The next picture and when it was captured; None where the capture gave none."""
        capture = self._capture
        if capture is None:
            raise CameraError(f"{self.name}: read while closed")
        try:
            if not capture.grab():
                return None
            captured_s = self._clock()
            got, image = capture.retrieve()
        except cv2.error as error:
            raise CameraError(f"{self.name}: {error.err}") from error
        if not got or image is None or image.size == 0:
            return None
        return image.astype(np.uint8, copy=False), captured_s

    def _frame(self, image: Image, captured_s: float, *, count: bool = True) -> Frame:
        if count:
            self._rate.add(captured_s)
        frame = Frame(image, captured_s, self._sequence, self.name)
        self._sequence += 1
        return frame


class DeviceCamera(Capture):
    """A V4L2 camera by its index (``0``) or path (``/dev/video0``, ``/dev/v4l/by-id/...``)."""

    def __init__(
        self, device: str, clock: Clock, rate_hz: float | None, size: tuple[int, int] | None
    ) -> None:
        super().__init__(f"camera {device}", clock)
        self._path = f"/dev/video{device}" if device.isdecimal() else device
        self._rate_wanted_hz = rate_hz
        self._size_wanted = size
        self._promise = ""

    def open(self) -> None:
        """Open the device; ``CameraError`` where it is missing, busy or no camera.

        A value of the variable that bounds OpenCV's waits is left as its user has set it.
        """
        os.environ.setdefault(_SELECT_TIMEOUT, str(_LONGEST_WAIT_S))
        if not os.path.exists(self._path):
            raise CameraError(f"{self.name}: {self._path} does not exist; is it plugged in?")
        if not os.access(self._path, os.R_OK | os.W_OK):
            raise CameraError(
                f"{self.name}: no permission for {self._path}; add the user to the group 'video'"
            )
        parameters: list[int] = []
        if self._size_wanted is not None:
            width, height = self._size_wanted
            parameters += [cv2.CAP_PROP_FRAME_WIDTH, width, cv2.CAP_PROP_FRAME_HEIGHT, height]
        # A stable path is a link; V4L2 is opened by the device's own name.
        capture = self._start(os.path.realpath(self._path), cv2.CAP_V4L2, parameters)
        if self._rate_wanted_hz is not None:
            capture.set(cv2.CAP_PROP_FPS, self._rate_wanted_hz)
        # One buffer would be the newest frame, but many drivers need two to run at all.
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 2)
        self._promise = self.reason = self._not_as_asked(capture)

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame; OpenCV bounds the wait by five seconds, ``timeout_s`` is not needed."""
        grabbed = self._grab()
        if grabbed is None:
            if not os.path.exists(self._path):
                raise CameraError(f"{self.name}: unplugged ({self._path} is gone)")
            raise CameraError(f"{self.name}: the camera delivers no picture")
        image, captured_s = grabbed
        frame = self._frame(image, self._driver_time_s(captured_s))
        self.reason = self._rate_really_got() or self._promise
        return frame

    def _rate_really_got(self) -> str:
        """What to say where the measured rate is not the one asked for; drivers may promise it."""
        wanted_hz = self._rate_wanted_hz
        if wanted_hz is None or self._sequence < _FRAMES_FOR_RATE:
            return ""
        if abs(self.rate_hz - wanted_hz) <= 0.1 * wanted_hz:
            return ""
        return f"asked for {wanted_hz:g} frames/s, gets {self.rate_hz:.1f}"

    def _driver_time_s(self, grabbed_s: float) -> float:
        """The driver's time of exposure where it is on our clock, else the time of the grab."""
        if self._capture is None:
            return grabbed_s
        return driver_time_s(self._capture.get(cv2.CAP_PROP_POS_MSEC), grabbed_s)

    def _not_as_asked(self, capture: cv2.VideoCapture) -> str:
        said = []
        if self._size_wanted is not None:
            got = (
                round(capture.get(cv2.CAP_PROP_FRAME_WIDTH)),
                round(capture.get(cv2.CAP_PROP_FRAME_HEIGHT)),
            )
            if got != self._size_wanted:
                wanted = f"{self._size_wanted[0]}x{self._size_wanted[1]}"
                said.append(f"asked for {wanted} pixels, the driver gives {got[0]}x{got[1]}")
        if self._rate_wanted_hz is not None:
            rate_hz = capture.get(cv2.CAP_PROP_FPS)
            if abs(rate_hz - self._rate_wanted_hz) > 0.05 * self._rate_wanted_hz:
                said.append(
                    f"asked for {self._rate_wanted_hz:g} frames/s, the driver promises {rate_hz:g}"
                )
        return "; ".join(said)

    def _refused(self) -> CameraError:
        if gives_pictures(self._path) is False:
            return CameraError(
                f"{self.name}: {self._path} gives no pictures; `clearway devices` lists what does"
            )
        return CameraHeldError(f"{self.name}: {self._path} is busy", "another program uses it")


def driver_time_s(position_ms: float, grabbed_s: float) -> float:
    """A V4L2 time stamp (ms) in seconds if it is on the clock of ``grabbed_s``, else that time.

    Drivers stamp with the monotonic clock or with one of their own; a stamp that lies in the
    future or more than half a second back is on another clock.
    """
    stamp_s = position_ms / 1000.0
    return stamp_s if 0.0 <= grabbed_s - stamp_s <= _DRIVER_CLOCK_LIMIT_S else grabbed_s


class StreamCamera(Capture):
    """An RTSP or HTTP stream, through FFmpeg, with bounded waits.

    Its rate is known a second after it was opened. The pictures of an RTSP stream carry the
    sender's times (RTP): what the network holds up is dated by them. No stream reports what
    every picture takes at least.
    """

    def __init__(self, url: str, clock: Clock) -> None:
        super().__init__(without_password(url), clock)
        self._url = url
        self._opened_s = 0.0
        self._sender: ArrivalClock | None = None
        self._stamp_s = -math.inf

    def open(self) -> None:
        """Connect; ``CameraError`` where nobody answers within five seconds."""
        timeouts = [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
            1000 * _LONGEST_WAIT_S,
            cv2.CAP_PROP_READ_TIMEOUT_MSEC,
            1000 * _LONGEST_WAIT_S,
        ]
        self._start(self._url, cv2.CAP_FFMPEG, timeouts)
        self._opened_s = self._clock()
        is_rtp = self._url.lower().startswith(("rtsp://", "rtsps://"))
        self._sender = ArrivalClock() if is_rtp else None
        self._stamp_s = -math.inf

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame; FFmpeg bounds the wait by five seconds."""
        grabbed = self._grab()
        if grabbed is None:
            raise CameraError(f"{self.name}: the stream ended or its peer is gone")
        image, arrived_s = grabbed
        count = arrived_s - self._opened_s >= _BURST_S
        return self._frame(image, self._sent_s(arrived_s), count=count)

    def _sent_s(self, arrived_s: float) -> float:
        """When the picture was sent, by its own stamp; the arrival where it has none."""
        if self._sender is None or self._capture is None:
            return arrived_s
        stamp_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        if not math.isfinite(stamp_s) or stamp_s <= self._stamp_s:
            self._sender, self._stamp_s = ArrivalClock(), -math.inf  # it counts from elsewhere now
            return arrived_s
        self._stamp_s = stamp_s
        return max(self._sender.time_of(stamp_s, arrived_s), arrived_s - _LONGEST_HOLD_UP_S)

    def _refused(self) -> CameraError:
        # many network cameras serve few clients: one that hangs may be the last they allow
        return CameraHeldError(
            f"{self.name}: no stream there, or nobody answered within {_LONGEST_WAIT_S} s"
        )


def without_password(url: str) -> str:
    """The URL as messages may show it: user and password left out; other texts as they are."""
    scheme, mark, rest = url.partition("://")
    if not mark:
        return url
    host, slash, path = rest.partition("/")
    port = host.partition(":")[2]
    if "@" not in host and port and not port.isdecimal() and "@" in path:
        # A password with a slash that should have been written %2F: nothing of it is shown.
        host, slash, path = path.rpartition("@")[2].partition("/")
    return f"{scheme}://{host.rpartition('@')[2]}{slash}{path}"


def list_devices() -> list[tuple[str, str]]:
    """The V4L2 capture devices of this machine: (path, what it is called).

    A device is listed by its stable path under /dev/v4l/by-id where it has one. A camera's other
    nodes, which give no pictures, are left out; what cannot be asked, for want of permission, is
    listed.
    """
    stable = {os.path.realpath(p): p for p in sorted(glob.glob("/dev/v4l/by-id/*"))}
    found = []
    for device in sorted(glob.glob("/dev/video*")):
        if gives_pictures(device) is False:
            continue
        label = Path("/sys/class/video4linux", Path(device).name, "name")
        name = label.read_text(errors="replace").strip() if label.is_file() else device
        found.append((stable.get(device, device), name))
    return found
