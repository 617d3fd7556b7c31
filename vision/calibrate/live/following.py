"""A board in consecutive frames: found in a reduced picture, then followed.

Rules
- The corners' optical flow (Lucas and Kanade, pyramids by Bouguet) follows a board, each refined in
  the whole picture, until they no longer move as one plane.
- The reduced picture hides small boards: some searches use the whole one (ChArUco boards).
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from vision.calibrate.board import BoardSpec, BoardView, NoBoard, find_board, refine_corners
from vision.calibration.calibration import FloatArray
from vision.camera.camera import Image
from vision.markers.marker_search import grey_of

SEARCH_PX: Final = 640
"""Longer side of the searched picture: a chessboard takes seconds in large ones."""
WHOLE_EVERY: Final = 15
"""Unsuccessful searches to one of the whole picture, for markers only."""
FOLLOWED_AT_MOST: Final = 30
"""Frames after which the board is searched again, for corners that came into sight."""
_PLANE_PX: Final = 1.5
_FLOW_WINDOW: Final = (21, 21)


class BoardFollower:
    """Finder of a board in consecutive frames."""

    def __init__(self, spec: BoardSpec) -> None:
        self._spec = spec
        self._last: tuple[Image, BoardView] | None = None
        self._followed = 0
        self._missed = 0

    def look(self, image: Image, name: str) -> BoardView | NoBoard:
        """Find the board in the next frame, called ``name`` in messages."""
        grey = grey_of(image)
        followed = self._follow(grey, name)
        found = self._search(grey, name) if followed is None else followed
        if followed is None:
            self._followed = 0
        if isinstance(found, BoardView):
            self._last = grey, found
            self._missed = 0
        else:
            self._last = None
            self._missed += 1
        return found

    def _search(self, grey: Image, name: str) -> BoardView | NoBoard:
        scale = min(1.0, SEARCH_PX / max(grey.shape))
        whole = self._spec.kind == "charuco" and self._missed % WHOLE_EVERY == WHOLE_EVERY - 1
        if scale == 1.0 or whole:
            return find_board(grey, self._spec, name)
        small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        found = find_board(np.asarray(small, dtype=np.uint8), self._spec, name)
        if isinstance(found, NoBoard):
            return found
        ratio = np.array([grey.shape[1] / small.shape[1], grey.shape[0] / small.shape[0]])
        start_px = (found.corners_px + 0.5) * ratio - 0.5
        corners = refine_corners(grey, start_px, self._spec.window_share)
        return _view(name, grey, corners, found.points_m)

    def _follow(self, grey: Image, name: str) -> BoardView | None:
        if self._last is None or self._followed >= FOLLOWED_AT_MOST:
            return None
        before, view = self._last
        if before.shape != grey.shape:
            return None
        start = view.corners_px.astype(np.float32).reshape(-1, 1, 2)
        moved, met, _ = cv2.calcOpticalFlowPyrLK(
            before, grey, start, start.copy(), winSize=_FLOW_WINDOW
        )
        if not np.all(np.ravel(met) == 1):
            return None
        start_px = np.asarray(moved, dtype=np.float64).reshape(-1, 2)
        if not ((start_px > 0.0) & (start_px < np.array(grey.shape[::-1]) - 1.0)).all():
            return None
        corners = refine_corners(grey, start_px, self._spec.window_share)
        if not _moved_as_a_plane(view.corners_px, corners):
            return None
        self._followed += 1
        return _view(name, grey, corners, view.points_m)


def _view(name: str, grey: Image, corners: FloatArray, points: FloatArray) -> BoardView:
    corners.setflags(write=False)
    return BoardView(name, (grey.shape[1], grey.shape[0]), corners, points)


def _moved_as_a_plane(before: FloatArray, after: FloatArray) -> bool:
    found: object = cv2.findHomography(before, after, 0)[0]
    if not isinstance(found, np.ndarray):
        return False
    plane = np.asarray(found, dtype=np.float64)
    seen = cv2.perspectiveTransform(before.reshape(-1, 1, 2), plane).reshape(-1, 2)
    return bool(np.linalg.norm(seen - after, axis=1).max() < _PLANE_PX)
