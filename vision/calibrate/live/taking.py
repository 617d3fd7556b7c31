"""Loop that takes and shows views of a board from a camera.

It ends with enough views, with the source, on Ctrl-C, or when cancelled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import cv2
import numpy as np

from vision.calibrate.board import BoardSpec, BoardView, refuse_part
from vision.calibrate.live.following import SEARCH_PX
from vision.calibrate.live.session import LiveSession, LiveState
from vision.camera.camera import Camera, CameraError, Clock, Frame, Image
from vision.markers.marker_search import grey_of

READ_S: Final = 0.5
SILENT_S: Final = 5.0
"""A camera without a picture for this time has failed."""


class Shows(Protocol):
    """Display of a live calibration."""

    def show(self, state: LiveState, frame: Frame) -> None:
        """Show a frame and the state after it."""


@dataclass(frozen=True, slots=True, eq=False)
class LiveTaken:
    """The views taken; ``ended`` is the reason for the end, ``last`` the last state, if any."""

    views: tuple[BoardView, ...]
    last: LiveState | None
    ended: str


def _reduced(image: Image) -> Image:
    grey = grey_of(image)
    scale = min(1.0, SEARCH_PX / max(grey.shape))
    small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def take_live(
    camera: Camera,
    spec: BoardSpec,
    session: LiveSession,
    shows: Sequence[Shows],
    clock: Clock,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> LiveTaken:
    """Take views of the board until they are enough; opens and closes ``camera``.

    ``is_cancelled`` is called at each frame. Raises ``CameraError`` if the camera fails,
    ``CalibrationError`` if its pictures change size or the board is part of a larger one.
    """
    last: LiveState | None = None
    ended = "enough views"
    camera.open()
    try:
        heard_s = clock()
        while last is None or not last.done:
            if is_cancelled():
                ended = "cancelled"
                break
            frame = camera.read(READ_S)
            if frame is None:
                if camera.state == "ended":
                    ended = camera.reason or f"{camera.name} has ended"
                    break
                if clock() - heard_s > SILENT_S:
                    raise CameraError(f"{camera.name}: no picture within {SILENT_S:g} s")
                continue
            heard_s = clock()
            last = session.look(frame)
            for one in shows:
                one.show(last, frame)
    except KeyboardInterrupt:
        ended = "ended by Ctrl-C"
    finally:
        camera.close()
    refuse_part([_reduced(image) for _, image in session.pictures], spec)
    return LiveTaken(tuple(session.views), last, ended)
