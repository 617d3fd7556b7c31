"""A live calibration for pages: the state as JSON, the picture as JPEG, the remarks.

The thread that takes views leaves its last state and frame here and continues; a picture is encoded
only when a page asks.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Final

import cv2
import numpy as np

from navigation.dashboard.calibrating.said import (
    board_line,
    cells_line,
    figure_px,
    focal_line,
    wanted_line,
)
from vision.calibrate.live.session import LiveState
from vision.camera.camera import Frame

LARGEST_PX: Final = 1280
JPEG_QUALITY: Final = 80
MOST_REMARKS: Final = 50
FRAMES_KEPT: Final = 16
"""A page asks for the picture of a state some time after the state."""


class ShownViews:
    """One live calibration for pages; the thread that takes views calls `show`."""

    def __init__(self) -> None:
        self.remarks: list[str] = []
        """Views taken and not taken, the newest last."""
        self._shown: tuple[LiveState, Frame] | None = None
        self._frames: deque[Frame] = deque(maxlen=FRAMES_KEPT)

    def show(self, state: LiveState, frame: Frame) -> None:
        """Store the next frame; it costs nothing until a page asks."""
        if (state.taken or "not taken" in state.remark) and state.remark not in self.remarks[-1:]:
            self.remarks = [*self.remarks, state.remark][-MOST_REMARKS:]
        self._frames.append(frame)
        self._shown = state, frame

    def facts(self) -> dict[str, Any]:
        """The newest state, None before the first frame, and the remarks."""
        shown = self._shown
        return {"state": None if shown is None else as_json(*shown), "remarks": self.remarks}

    def picture(self, number: str) -> bytes | None:
        """Frame of a state, or the newest if it is gone; None without any."""
        frames = list(self._frames)
        if not frames:
            return None
        return jpeg_of(next((one for one in frames if str(one.sequence) == number), frames[-1]))


def as_json(state: LiveState, frame: Frame) -> dict[str, Any]:
    """Data that the page draws, in pixels of the frame; unknown spreads are null."""
    cells = state.cells
    outline = None
    if state.view is not None:
        hull = cv2.convexHull(state.view.corners_px.astype(np.float32)).reshape(-1, 2)
        outline = np.round(hull, 1).tolist()
    corners = [] if state.view is None else np.round(state.view.corners_px, 1).tolist()
    return {
        "frame": frame.sequence,
        "size": list(state.size),
        "cells": [
            [
                {
                    "px": round(sigma, 3) if math.isfinite(sigma) else None,
                    "seen": bool(state.cells.seen[row, column]),
                    "done": bool(cells.done[row, column]),
                }
                for column, sigma in enumerate(line)
            ]
            for row, line in enumerate(cells.sigma_px.tolist())
        ],
        "outline": outline,
        "corners": corners,
        "wanted": None if state.wanted is None else state.wanted.outline_px.round(1).tolist(),
        "sentence": wanted_line(state),
        "board": board_line(state),
        "focal": focal_line(state),
        "parts": cells_line(state),
        "spread": figure_px(cells.worst_px),
        "worst_px": cells.worst_px if math.isfinite(cells.worst_px) else None,
        "limit_px": cells.limit_px,
        "still": state.still,
        "count": state.count,
        "done": state.done,
    }


def jpeg_of(frame: Frame) -> bytes:
    """The frame for a page, no larger than shown."""
    image = frame.image
    scale = min(1.0, LARGEST_PX / max(frame.size))
    if scale < 1.0:
        image = np.asarray(
            cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8
        )
    _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data.tobytes()
