"""Frames and cameras as the rest of Clearway sees them.

Rules and units
- With a rolling shutter, a frame's time of capture is that of the last row. - -
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.scene import printable

Image: TypeAlias = NDArray[np.uint8]
Clock: TypeAlias = Callable[[], float]
SourceState: TypeAlias = Literal["closed", "running", "ended"]


class CameraError(ValueError):
    """Error for a camera that cannot be opened or gives no more pictures."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class CameraAbsentError(CameraError):
    """Error for an unplugged camera. Looking again costs nothing."""


class CameraHeldError(CameraError):
    """Error for a camera that cannot be opened: another program may hold it.

    ``seen`` is the source's observation; the message adds ``guess``, the likely holder.
    """

    def __init__(self, seen: str, guess: str = "") -> None:
        super().__init__(f"{seen} ({guess})" if guess else seen)
        self.seen = printable(seen)


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One picture: ``image`` (h, w) or (h, w, 3) BGR uint8, read-only.

    ``captured_s`` is monotonic seconds, ``sequence`` grows by one per frame of the source and
    ``source`` is the camera's name. Raises ``CameraError`` for anything that is not a picture.
    """

    image: Image
    captured_s: float
    sequence: int
    source: str

    def __post_init__(self) -> None:
        image = self.image
        if image.dtype != np.uint8 or not (
            image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)
        ):
            raise CameraError(
                f"{self.source}: a frame of {image.dtype} {image.shape} is no 8-bit grey or "
                "colour picture"
            )
        if image.size == 0:
            raise CameraError(f"{self.source}: an empty picture {image.shape}")
        if image.flags.writeable:
            view = image.view()
            view.setflags(write=False)
            object.__setattr__(self, "image", view)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return int(self.image.shape[1]), int(self.image.shape[0])


class Camera(Protocol):
    """Source of frames; ``vision.camera.sources`` and the simulator implement it."""

    @property
    def name(self) -> str:
        """Name in messages: ``camera 0``, ``rtsp://...``, a file name."""

    @property
    def state(self) -> SourceState:
        """``closed``, ``running`` or ``ended`` (a file without more pictures)."""

    @property
    def reason(self) -> str:
        """Sentence on the state, or on a request that was not met; may be empty."""

    @property
    def rate_hz(self) -> float:
        """Frames a second measured lately; 0.0 before the second frame."""

    @property
    def may_repeat(self) -> bool:
        """True if identical pictures in a row are normal, not a sign of a frozen sensor.

        Files, and any source without noise.
        """

    def open(self) -> None:
        """Start giving frames; raises ``CameraError`` if it cannot."""

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next frame; None if none came in time or the source ended.

        Raises ``CameraError`` if the source is lost.
        """

    def close(self) -> None:
        """Stop and free the device; harmless when closed."""


class RateMeter:
    """Frames a second over the last ``window`` frames, by their times of capture."""

    def __init__(self, window: int = 30) -> None:
        self._times: deque[float] = deque(maxlen=window + 1)

    def add(self, captured_s: float) -> None:
        """Count one frame."""
        if self._times and captured_s < self._times[-1]:
            self._times.clear()
        self._times.append(captured_s)

    @property
    def rate_hz(self) -> float:
        """Mean rate; 0.0 before the second frame."""
        if len(self._times) < 2 or self._times[-1] <= self._times[0]:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])


def identical(a: Image, b: Image) -> bool:
    """True if two pictures are the same to the bit; a sparse comparison comes first."""
    if a.shape != b.shape:
        return False
    return np.array_equal(a[::16, ::16], b[::16, ::16]) and np.array_equal(a, b)
