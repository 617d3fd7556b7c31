"""Detection of calibration boards, chessboards and ChArUco boards, with sub-pixel corners.

Rules and units
- Corners are raw pixels, centres at integers. Board points are metres in the board's plane, x along
  its rows, y up, the first corner at (0, 0).
- Neighbours bound a corner's refinement window (``WINDOW_SHARE``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.calibration import CalibrationError, FloatArray
from vision.camera.camera import Image
from vision.markers.marker_search import MarkerError, dictionary_by_name, grey_of

WINDOW_SHARE = 0.3
"""Half the refinement window, as a share of the distance to the nearest corner: chosen, by ``python
-m benchmarks.camera.boards``. A smaller window has more noise, a larger one reaches the next
corners of a tilted board: on left-out views 0.187 px at 0.2, 0.181 at 0.3, 0.220 at 0.4."""

_MIN_CHARUCO_CORNERS = 8

MOST_LOOKED_AT = 5
"""Pictures searched for a larger board, at about 0.1 s each."""


@dataclass(frozen=True, slots=True)
class BoardSpec:
    """A board: ``chessboard`` with (columns, rows) inner corners, or ``charuco`` with squares.

    ``square_m`` is the side of a square, ``marker_m`` of a ChArUco marker (None: half a square),
    ``dictionary`` the markers' OpenCV name.
    """

    kind: Literal["chessboard", "charuco"]
    columns: int
    rows: int
    square_m: float
    marker_m: float | None = None
    dictionary: str = "DICT_6X6_250"

    def __post_init__(self) -> None:
        least = 3 if self.kind == "charuco" else 2
        if not (least <= self.columns <= 200 and least <= self.rows <= 200):
            raise CalibrationError(
                f"board of {self.columns}x{self.rows}: both must be in {least}..200"
            )
        if not 1e-4 <= self.square_m <= 10.0:
            raise CalibrationError(f"square = {self.square_m} m: must be in 0.0001..10 m")
        if self.marker_m is not None and not 0.0 < self.marker_m < self.square_m:
            raise CalibrationError(
                f"marker = {self.marker_m} m: must be smaller than the square, {self.square_m} m"
            )

    @property
    def inner(self) -> tuple[int, int]:
        """(columns, rows) of inner corners."""
        if self.kind == "charuco":
            return self.columns - 1, self.rows - 1
        return self.columns, self.rows

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height of all squares together."""
        columns, rows = self.inner
        return (columns + 1) * self.square_m, (rows + 1) * self.square_m

    @property
    def points_m(self) -> FloatArray:
        """Inner corners (n, 2), row by row, y up."""
        x, y = np.meshgrid(*map(np.arange, self.inner))
        return np.stack([x.ravel() * self.square_m, -y.ravel() * self.square_m], axis=1)

    def charuco(self) -> cv2.aruco.CharucoBoard:
        """OpenCV's object for a ChArUco board; ``MarkerError`` for an unknown dictionary."""
        book = dictionary_by_name(self.dictionary)
        shape = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(shape, self.square_m, self.marker_side_m, book)

    @property
    def marker_side_m(self) -> float:
        """Side of a ChArUco marker."""
        return self.square_m / 2.0 if self.marker_m is None else self.marker_m

    @property
    def window_share(self) -> float:
        """Half the refinement window, as a share of a square's side.

        A window that reaches a marker's edge pulls the corner there: 0.65 px on a tilted board.
        """
        if self.kind == "chessboard":
            return WINDOW_SHARE
        return min(WINDOW_SHARE, (1.0 - self.marker_side_m / self.square_m) / 2.0)

    @property
    def looks_the_same_turned(self) -> bool:
        """True if half a turn maps the pattern to itself: its first corner is unknown.

        A chessboard's does, unless one side has an even and the other an odd number of squares.
        """
        return self.kind == "chessboard" and (self.columns + self.rows) % 2 == 0


@dataclass(frozen=True, slots=True, eq=False)
class BoardView:
    """A board found in one picture: ``corners_px`` (n, 2), ``points_m`` (n, 2) on the board."""

    name: str
    size: tuple[int, int]
    corners_px: FloatArray
    points_m: FloatArray


def in_space(points_m: FloatArray) -> FloatArray:
    """Places (n, 3) of points (n, 2) on the board."""
    return np.column_stack([points_m, np.zeros(len(points_m))])


def common_corners(
    view: BoardView, other: BoardView
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices (n,) in each view of the board's corners that both show, in the other's order."""
    places = {tuple(p): i for i, p in enumerate(np.round(view.points_m, 6).tolist())}
    found = [places.get(tuple(p), -1) for p in np.round(other.points_m, 6).tolist()]
    seen = np.array(found, dtype=np.int64)
    there = np.flatnonzero(seen >= 0)
    return seen[there], there


@dataclass(frozen=True, slots=True)
class NoBoard:
    """A picture without the board, or with too little of it."""

    name: str
    reason: str


def find_board(image: Image, spec: BoardSpec, name: str) -> BoardView | NoBoard:
    """Find the board in a picture called ``name`` in messages."""
    grey = grey_of(image)
    if min(grey.shape) < 32:
        return NoBoard(name, f"a picture of {grey.shape[1]}x{grey.shape[0]} pixels is too small")
    found = _find_chessboard(grey, spec) if spec.kind == "chessboard" else _find_charuco(grey, spec)
    if isinstance(found, str):
        return NoBoard(name, found)
    corners, points = found
    refined = refine_corners(grey, corners, spec.window_share)
    refined.setflags(write=False)
    points.setflags(write=False)
    return BoardView(name, (grey.shape[1], grey.shape[0]), refined, points)


def _find_chessboard(grey: Image, spec: BoardSpec) -> tuple[FloatArray, FloatArray] | str:
    columns, rows = spec.inner
    found, corners = cv2.findChessboardCorners(grey, (columns, rows))
    if not found or corners is None:
        found, corners = cv2.findChessboardCornersSB(grey, (columns, rows))
    if not found or corners is None:
        return f"no chessboard of {columns}x{rows} inner corners"
    grid = np.asarray(corners, dtype=np.float64).reshape(rows, columns, 2)
    along, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if along[0] * down[1] - along[1] * down[0] < 0.0:
        grid = grid[::-1]
    if _first_square_is_light(grey, grid):
        grid = grid[::-1, ::-1]
    return grid.reshape(-1, 2), spec.points_m


def _first_square_is_light(grey: Image, grid: FloatArray) -> bool:
    """True if the inner square at the first corner is lighter than its neighbour.

    Fixes the first corner in every picture, if the board allows.
    """
    if grid.shape[0] < 2 or grid.shape[1] < 3:
        return False
    squares = [grid[0:2, i : i + 2].mean(axis=(0, 1)) for i in (0, 1)]
    (ax, ay), (bx, by) = (np.round(s).astype(int) for s in squares)
    return bool(grey[ay, ax] > grey[by, bx])


def _find_charuco(grey: Image, spec: BoardSpec) -> tuple[FloatArray, FloatArray] | str:
    try:
        board = spec.charuco()
    except MarkerError as error:
        raise CalibrationError(str(error)) from error
    best: tuple[FloatArray, FloatArray] | None = None
    # since OpenCV 4.6, boards with even rows begin with the other colour
    for legacy in (False, True) if spec.rows % 2 == 0 else (False,):
        board.setLegacyPattern(legacy)
        corners, ids, *_ = cv2.aruco.CharucoDetector(board).detectBoard(grey)
        seen: object = ids
        if seen is None:
            continue
        if best is None or len(ids) > len(best[0]):
            places = np.asarray(board.getChessboardCorners(), dtype=np.float64).reshape(-1, 3)
            # OpenCV counts from the outer corner
            points = (places[np.ravel(ids), :2] - places[0, :2]) * (1.0, -1.0)
            best = np.asarray(corners, dtype=np.float64).reshape(-1, 2), points
    if best is None:
        if _is_mirrored(grey, board.getDictionary()):
            return "the picture is mirrored: its markers can be read in a mirror only"
        return (
            f"no ChArUco board of {spec.columns}x{spec.rows} squares with {spec.dictionary}, or "
            "one too small in the picture"
        )
    if len(best[0]) < _MIN_CHARUCO_CORNERS:
        return (
            f"only {len(best[0])} corners of the ChArUco board: must be {_MIN_CHARUCO_CORNERS}; "
            "come nearer, or show more of it"
        )
    if np.linalg.matrix_rank(best[1] - best[1].mean(axis=0)) < 2:
        return "the corners seen of the ChArUco board lie in one line"
    return best


def _is_mirrored(grey: Image, book: cv2.aruco.Dictionary) -> bool:
    """True if a mirror shows more markers; one alone may be chance."""
    detector = cv2.aruco.ArucoDetector(book)
    mirror = np.ascontiguousarray(grey[:, ::-1])
    counts = [len(detector.detectMarkers(picture)[0]) for picture in (grey, mirror)]
    return counts[1] >= 2 and counts[1] > 2 * counts[0]


def refine_corners(grey: Image, corners_px: FloatArray, share: float = WINDOW_SHARE) -> FloatArray:
    """Refine each corner (n, 2) in its own window, a share of its neighbour's distance."""
    corners = np.asarray(corners_px, dtype=np.float64).reshape(-1, 2)
    away = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    np.fill_diagonal(away, np.inf)
    halves = np.clip(np.round(away.min(axis=1) * share), 2, 11).astype(int)
    refined = corners.copy()
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    for half in np.unique(halves):
        chosen = halves == half
        start = corners[chosen].astype(np.float32).reshape(-1, 1, 2)
        found = cv2.cornerSubPix(grey, start, (int(half), int(half)), (-1, -1), stop)
        moved = np.asarray(found, dtype=np.float64).reshape(-1, 2)
        # a corner that leaves its window has found something else
        kept = np.abs(moved - corners[chosen]).max(axis=1) <= half
        refined[chosen] = np.where(kept[:, None], moved, corners[chosen])
    return refined


def find_boards(
    pictures: Sequence[tuple[str, Image]], spec: BoardSpec
) -> tuple[list[BoardView], list[NoBoard]]:
    """Find the board in each picture, and list the pictures without it.

    Raises ``CalibrationError`` as ``refuse_part``.
    """
    found = [find_board(image, spec, name) for name, image in pictures]
    views = [f for f in found if isinstance(f, BoardView)]
    seen = {view.name for view in views}
    refuse_part([grey_of(image) for name, image in pictures if name in seen], spec)
    return views, [f for f in found if isinstance(f, NoBoard)]


def refuse_part(pictures: Sequence[Image], spec: BoardSpec) -> None:
    """Raise ``CalibrationError`` if the board found is part of a larger chessboard.

    The search accepts a part too. Most of the grey pictures must agree, as a shadow may pass for
    another row.
    """
    if spec.kind != "chessboard":
        return
    looked_at = pictures[:MOST_LOOKED_AT]
    larger: list[tuple[int, int]] = []
    for number, grey in enumerate(looked_at, start=1):
        size = _larger_board(grey, *spec.inner)
        if size is not None:
            larger.append(size)
        elif 2 * (number - len(larger)) >= len(looked_at):
            return
    for size in set(larger):
        if 2 * larger.count(size) > len(looked_at):
            columns, rows = spec.inner
            raise CalibrationError(
                f"the board has more corners than {columns}x{rows}: is it {size[0]}x{size[1]}?"
            )


def _larger_board(grey: Image, columns: int, rows: int) -> tuple[int, int] | None:
    # quick, and as good as sure where nothing is added; a search that finds nothing takes 0.15 s
    _, _, grown = cv2.findChessboardCornersSBWithMeta(grey, (columns, rows), cv2.CALIB_CB_LARGER)
    if grown is not None and sorted(grown.shape[:2]) == sorted((columns, rows)):
        return None
    for wider in ((columns + 1, rows), (columns, rows + 1), (columns + 1, rows + 1)):
        if cv2.findChessboardCorners(grey, wider)[0]:
            return wider
    return None
