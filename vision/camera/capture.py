"""Cameras behind OpenCV's capture: network streams, and the base of video files.

A stream without a picture for five seconds has failed. Times are seconds on the clock passed in.
"""

from __future__ import annotations

import math
import re

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

_LONGEST_WAIT_S = 5
"""Below ``WatchLimits.hung_s``."""
_LONGEST_HOLD_UP_S = 2.0
"""Largest age of a picture by its stamp; beyond it the stamp is not believed."""
_BURST_S = 1.0
"""Time after opening in which a stream's kept frames come at once and give no rate."""


class Capture:
    """An OpenCV capture and its frames: base of streams and video files."""

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
        """Measured frames a second."""
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
        # the sensor's own pixels, as for pictures
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        self._capture = capture
        self._rate = RateMeter()
        self.state, self.reason = "running", ""
        return capture

    def _refused(self) -> CameraError:
        return CameraError(f"{self.name}: cannot be opened")

    def _grab(self) -> tuple[Image, float] | None:
        """Return the next picture and its time of capture; None if the capture gave none."""
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


class StreamCamera(Capture):
    """RTSP or HTTP stream, through FFmpeg, with bounded waits.

    Its rate is known a second after opening. The sender's times (RTP) date pictures of RTSP that
    the network delays, but for the least delay.
    """

    def __init__(self, url: str, clock: Clock) -> None:
        super().__init__(without_password(url), clock)
        self._url = url
        self._opened_s = 0.0
        self._sender: ArrivalClock | None = None
        self._stamp_s = -math.inf

    def open(self) -> None:
        """Connect; ``CameraError`` if there is no answer within five seconds."""
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
        """Return the next frame; FFmpeg limits the wait to five seconds."""
        grabbed = self._grab()
        if grabbed is None:
            raise CameraError(f"{self.name}: the stream ended or its peer is gone")
        image, arrived_s = grabbed
        count = arrived_s - self._opened_s >= _BURST_S
        return self._frame(image, self._sent_s(arrived_s), count=count)

    def _sent_s(self, arrived_s: float) -> float:
        """Return when the picture was sent, by its own stamp, or its arrival without one."""
        if self._sender is None or self._capture is None:
            return arrived_s
        stamp_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        if not math.isfinite(stamp_s) or stamp_s <= self._stamp_s:
            self._sender, self._stamp_s = ArrivalClock(), -math.inf  # its stamps have a new origin
            return arrived_s
        self._stamp_s = stamp_s
        return max(self._sender.time_of(stamp_s, arrived_s), arrived_s - _LONGEST_HOLD_UP_S)

    def _refused(self) -> CameraError:
        # many network cameras serve few clients: a hanging one may be the last
        return CameraHeldError(
            f"{self.name}: no stream there, or no answer within {_LONGEST_WAIT_S} s"
        )


def without_password(url: str) -> str:
    """URL for messages, without user, password, fragment and the query's values.

    A text that is not a URL is unchanged.
    """
    if "://" not in url:
        return url
    place, mark, query = without_user(url).partition("#")[0].partition("?")
    return place + mark + "&".join(map(_only_name, re.split("[&;]", query)))


def _only_name(part: str) -> str:
    if not part:
        return ""
    name, mark, _ = part.partition("=")
    return f"{name}=(left out)" if mark else "(left out)"


def without_user(url: str) -> str:
    """URL without user and password; a text that is not a URL is unchanged."""
    scheme, mark, rest = url.partition("://")
    if not mark:
        return url
    host, slash, path = rest.partition("/")
    port = host.partition(":")[2]
    if "@" not in host and port and not port.isdecimal() and "@" in path:
        # a password with a slash not written %2F: show nothing of it
        host, slash, path = path.rpartition("@")[2].partition("/")
    return f"{scheme}://{host.rpartition('@')[2]}{slash}{path}"
