"""Guide to the parts of the picture that still need a board, and to its next pose.

Rules and units
- A cell of the picture is done when a board's corner was seen in it and the lens is known there to
  the limit (`covariance.KnownLens.sigma_px`).
- Of some hundred (place, tilt, distance), the next pose leaves the fewest cells without a board
  and, among equals, the smallest worst spread: the guide of Peng and Sturm (Calibration Wizard,
  2019) without its search.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardSpec, BoardView, common_corners, in_space
from vision.calibrate.covariance import KnownLens, information
from vision.calibration.calibration import FloatArray

LONG_SIDE_CELLS: Final = 6
POINTS_A_CELL: Final = 3
"""Along each side of a cell, its rim included."""
TILT_DEG: Final = 35
TILTS: Final = {
    "": (0.0, 0.0),
    "left": (0.0, -1.0),
    "right": (0.0, 1.0),
    "upper": (1.0, 0.0),
    "lower": (-1.0, 0.0),
}
"""Edges that come towards the camera, and the turns about the picture's x and y axes."""
SIZES: Final = {"far": 0.25, "at middle distance": 0.4, "near": 0.55}
"""Half the board's longer side as a share of the picture's shorter one."""
NEW_SHARE: Final = 0.025
"""Least distance of a new view's corners from any other's, as a share of the picture."""
_PLACES: Final = (0.0, 1 / 3, 2 / 3, 1.0)
_MARGIN_PX: Final = 8.0
_FACING: Final = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Cells of the picture: ``sigma_px`` (rows, columns), ``seen`` where a board was."""

    sigma_px: FloatArray
    seen: NDArray[np.bool_]
    limit_px: float

    @property
    def done(self) -> NDArray[np.bool_]:
        """(rows, columns) True if no further board is needed."""
        return np.asarray(self.seen & (self.sigma_px <= self.limit_px))

    @property
    def worst_px(self) -> float:
        """The largest spread in the picture."""
        return float(self.sigma_px.max())


@dataclass(frozen=True, slots=True, eq=False)
class HeldPose:
    """A pose of the board, camera from board, and the camera's ``view`` of it.

    ``edge`` comes towards the camera ("" for none), ``distance`` is a name of ``SIZES``.
    """

    edge: str
    distance: str
    turn: FloatArray
    shift: FloatArray
    view: BoardView


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """The board's next pose, a sentence for it, and its outline (4, 2) in the picture."""

    sentence: str
    outline_px: FloatArray
    pose: HeldPose


def is_new(view: BoardView, views: Sequence[BoardView]) -> bool:
    """True if a view shows the board where no other view does."""
    least_px = NEW_SHARE * max(view.size)
    return all(_apart_px(view, other) >= least_px for other in views)


def _apart_px(view: BoardView, other: BoardView) -> float:
    there, here = common_corners(other, view)
    if len(here) < 4:
        return math.inf
    steps = view.corners_px[here] - other.corners_px[there]
    return float(np.linalg.norm(steps, axis=1).mean())


def cell_shape(size: tuple[int, int]) -> tuple[int, int]:
    """(rows, columns) of nearly square cells."""
    side = max(size) / LONG_SIDE_CELLS
    return max(1, round(size[1] / side)), max(1, round(size[0] / side))


def judge_cells(
    lens: KnownLens | None, views: Sequence[BoardView], size: tuple[int, int], limit_px: float
) -> Cells:
    """State of the cells after some views; without a lens nothing is known."""
    shape = cell_shape(size)
    sigma = np.full(shape, np.inf)
    if lens is not None:
        sigma = _worst_of_cells(lens.sigma_px(_points(size)), shape)
    return Cells(sigma, _seen(views, size, shape), limit_px)


def next_place(lens: KnownLens, spec: BoardSpec, views: Sequence[BoardView]) -> Wanted | None:
    """The board's next pose; None if no new one is wholly in the picture."""
    size = lens.size
    shape = cell_shape(size)
    seen, points = _seen(views, size, shape), _points(size)
    best: tuple[tuple[int, float], Wanted] | None = None
    for pose in held_poses(lens, spec):
        if not is_new(pose.view, views):
            continue
        there = seen | _seen([pose.view], size, shape)
        more = information(lens, pose.view.points_m, pose.turn, pose.shift)
        worst_px = float(lens.sigma_px(points, more).max())
        rank = (int(np.count_nonzero(~there)), worst_px)
        if best is None or rank < best[0]:
            best = rank, Wanted(_sentence(pose, size), _outline(lens, spec, pose), pose)
    return None if best is None else best[1]


def held_poses(lens: KnownLens, spec: BoardSpec) -> list[HeldPose]:
    """Poses with the whole board in the picture."""
    columns, rows = spec.inner
    points = spec.points_m
    middle = np.array([(columns - 1) / 2, -(rows - 1) / 2, 0.0]) * spec.square_m
    rim = _rim(spec)
    focal, centre = float(lens.camera_matrix[0, 0]), lens.camera_matrix[:2, 2]
    found = []
    for distance, share in SIZES.items():
        length_px = 2.0 * share * min(lens.size)
        z = focal * max(columns, rows) * spec.square_m / length_px
        for edge, about in TILTS.items():
            tilt = cv2.Rodrigues(np.array([*about, 0.0]) * math.radians(TILT_DEG))[0]
            rotation = np.asarray(tilt @ _FACING, dtype=np.float64)
            for right in _PLACES:
                for down in _PLACES:
                    at = np.array([right * (lens.size[0] - 1), down * (lens.size[1] - 1)])
                    for _ in range(4):
                        shift = np.array([*((at - centre) / focal * z), z]) - rotation @ middle
                        turn = np.asarray(cv2.Rodrigues(rotation)[0], dtype=np.float64).ravel()
                        beyond = _beyond(_project(lens, rim, turn, shift), lens.size)
                        if not beyond.any():
                            break
                        at = at + beyond
                    else:
                        continue
                    corners = _project(lens, points, turn, shift)
                    view = BoardView("wanted", lens.size, corners, points)
                    found.append(HeldPose(edge, distance, turn, shift, view))
    return found


def _project(
    lens: KnownLens, points: FloatArray, turn: FloatArray, shift: FloatArray
) -> FloatArray:
    seen, _ = cv2.projectPoints(in_space(points), turn, shift, lens.camera_matrix, lens.distortion)
    return np.asarray(seen.reshape(-1, 2), dtype=np.float64)


def _beyond(corners: FloatArray, size: tuple[int, int]) -> FloatArray:
    low = np.maximum(0.0, _MARGIN_PX - corners.min(axis=0))
    high = np.maximum(0.0, corners.max(axis=0) - (np.array(size) - 1.0 - _MARGIN_PX))
    return np.asarray(low - high)


def _outline(lens: KnownLens, spec: BoardSpec, pose: HeldPose) -> FloatArray:
    return _project(lens, _rim(spec), pose.turn, pose.shift)


def _rim(spec: BoardSpec) -> FloatArray:
    """Outer squares' corners (4, 2), metres."""
    columns, rows = spec.inner
    rim = np.array([[-1, 1], [columns, 1], [columns, -rows], [-1, -rows]], dtype=np.float64)
    return rim * spec.square_m


def _sentence(pose: HeldPose, size: tuple[int, int]) -> str:
    x, y = pose.view.corners_px.mean(axis=0) / np.array(size)
    words = [w for w in (_third(y, "upper", "lower"), _third(x, "left", "right")) if w]
    if len(words) == 2:
        where = f"in the {words[0]} {words[1]} corner"
    elif words:
        where = f"at the {words[0]} edge"
    else:
        where = "in the middle"
    how = "facing the camera"
    if pose.edge:
        how = f"tilted by {TILT_DEG} degrees, its {pose.edge} edge towards the camera"
    return f"hold the board {where} of the picture, {pose.distance}, {how}"


def _third(share: float, low: str, high: str) -> str:
    if share < 0.42:
        return low
    return high if share > 0.58 else ""


def _points(size: tuple[int, int]) -> FloatArray:
    rows, columns = cell_shape(size)
    x = np.linspace(0.0, size[0] - 1.0, columns * (POINTS_A_CELL - 1) + 1)
    y = np.linspace(0.0, size[1] - 1.0, rows * (POINTS_A_CELL - 1) + 1)
    return np.stack(np.meshgrid(x, y), axis=2).reshape(-1, 2)


def _worst_of_cells(sigma: FloatArray, shape: tuple[int, int]) -> FloatArray:
    step = POINTS_A_CELL - 1
    rows, columns = shape
    grid = sigma.reshape(rows * step + 1, columns * step + 1)
    found = np.empty(shape)
    for row in range(rows):
        for column in range(columns):
            part = grid[row * step : (row + 1) * step + 1, column * step : (column + 1) * step + 1]
            found[row, column] = part.max()
    return found


def _seen(
    views: Sequence[BoardView], size: tuple[int, int], shape: tuple[int, int]
) -> NDArray[np.bool_]:
    seen = np.zeros(shape, dtype=np.bool_)
    for view in views:
        place = view.corners_px / np.array(size) * np.array(shape[::-1])
        columns, rows = np.clip(place.astype(int), 0, np.array(shape[::-1]) - 1).T
        seen[rows, columns] = True
    return seen
