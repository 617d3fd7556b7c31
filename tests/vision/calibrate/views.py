"""Views of a chessboard before a camera whose lens is known, with noise on their corners."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardView

SIZE = (640, 480)
CAMERA = np.array([[620.0, 0.0, 334.0], [0.0, 622.0, 229.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.28, 0.09, 0.0008, -0.0005, 0.0])
OTHER_CAMERA = np.array([[560.0, 0.0, 318.0], [0.0, 561.0, 246.0], [0.0, 0.0, 1.0]])
INNER, SQUARE_M = (9, 6), 0.025
FLIP = np.diag([1.0, -1.0, -1.0])
Poses = list[tuple[NDArray[np.float64], NDArray[np.float64]]]


def board_points() -> NDArray[np.float64]:
    """(54, 2) metres, the first corner at the origin, y up."""
    x, y = np.meshgrid(np.arange(INNER[0]), np.arange(INNER[1]))
    return np.stack([x.ravel() * SQUARE_M, -y.ravel() * SQUARE_M], axis=1)


def poses(count: int, seed: int = 0, tilt: float = 0.5) -> Poses:
    """Rotations and places of the board that are wholly in the picture."""
    rng = np.random.default_rng(seed)
    found: Poses = []
    while len(found) < count:
        rotation = cv2.Rodrigues(rng.uniform(-tilt, tilt, 3))[0] @ FLIP
        middle = np.array([*rng.uniform(-0.09, 0.09, 2), rng.uniform(0.3, 0.45)])
        corners = seen((rotation, middle), CAMERA, LENS)
        if corners.min() > 8 and (corners < np.array(SIZE) - 9.0).all():
            found.append((rotation, middle))
    return found


def seen(
    pose: tuple[NDArray[np.float64], NDArray[np.float64]],
    camera: NDArray[np.float64],
    lens: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The board's corners in the picture, without noise."""
    points = board_points()
    space = np.column_stack([points - points.mean(axis=0), np.zeros(len(points))])
    corners, _ = cv2.projectPoints(space, cv2.Rodrigues(pose[0])[0], pose[1], camera, lens)
    return corners.reshape(-1, 2)


def views(
    count: int,
    noise_px: float = 0.1,
    seed: int = 0,
    camera: NDArray[np.float64] = CAMERA,
    lens: NDArray[np.float64] = LENS,
    name: str = "picture",
) -> list[BoardView]:
    """``count`` views; ``noise_px`` is the spread of each coordinate."""
    rng = np.random.default_rng(1000 + seed)
    return [
        BoardView(
            f"{name} {i}",
            SIZE,
            seen(pose, camera, lens) + rng.normal(0.0, noise_px, (len(board_points()), 2)),
            board_points(),
        )
        for i, pose in enumerate(poses(count, seed))
    ]
