"""Windows of corner refinement, and foreign pictures, on folders of real chessboard pictures.

    python -m benchmarks.camera.boards FOLDER [FOLDER ...] [--squares 9x6]

For each folder, one camera's: the rms in pixels with a plain ``cornerSubPix`` window of 7, and with
several shares of the distance to the next corner, in the fit and on left-out views. For several:
how many are named when pictures of two cameras are mixed.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from vision.calibrate.board import (
    WINDOW_SHARE,
    BoardSpec,
    BoardView,
    find_boards,
    refine_corners,
)
from vision.calibrate.left_out import left_out_px
from vision.calibrate.lens import estimate_for, estimate_lens
from vision.calibrate.suspects import suspects
from vision.camera.camera import Image
from vision.camera.sources import PICTURE_SUFFIXES, read_picture
from vision.markers.marker_search import grey_of

PLAIN_HALF_PX = 7
SHARES = (0.2, 0.25, WINDOW_SHARE, 0.35, 0.4)
STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-4)


def found_in(folder: Path, spec: BoardSpec) -> tuple[list[Image], list[BoardView]]:
    """The folder's pictures that show the board, grey, and its views."""
    files = sorted(p for p in folder.iterdir() if p.suffix.lower() in PICTURE_SUFFIXES)
    taken = [(f"{folder.name}/{p.name}", read_picture(p)) for p in files]
    views, _ = find_boards(taken, spec)
    named = dict(taken)
    return [named[view.name] for view in views], views


def plain(images: list[Image], views: list[BoardView]) -> list[BoardView]:
    """The corners of OpenCV's refinement in a window of fixed size."""
    found = []
    for image, view in zip(images, views, strict=True):
        grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        start = view.corners_px.astype(np.float32).reshape(-1, 1, 2)
        half = (PLAIN_HALF_PX, PLAIN_HALF_PX)
        corners = cv2.cornerSubPix(np.asarray(grey, np.uint8), start, half, (-1, -1), STOP)
        refined = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
        found.append(BoardView(view.name, view.size, refined, view.points_m))
    return found


def refined(images: list[Image], views: list[BoardView], share: float) -> list[BoardView]:
    """The corners refined once more, in a window of this share."""
    return [
        BoardView(
            view.name,
            view.size,
            refine_corners(grey_of(image), view.corners_px, share),
            view.points_m,
        )
        for image, view in zip(images, views, strict=True)
    ]


def row(name: str, views: list[BoardView]) -> str:
    """A line of the table: in the fit, and on left-out views."""
    left_out = np.sqrt(np.mean(left_out_px(views, estimate_for(views)) ** 2))
    return f"| {name} | {estimate_lens(views).rms_px:.3f} | {left_out:.3f} |"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.camera.boards", description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--squares", default="9x6", help="inner corners")
    options = parser.parse_args()
    columns, rows = (int(word) for word in options.squares.split("x"))
    spec = BoardSpec("chessboard", columns, rows, 0.025)
    cameras = []
    for folder in options.folders:
        images, views = found_in(folder, spec)
        cameras.append(views)
        print(f"\n{folder.name}: {len(views)} views\n")
        print("| window | rms of the fit, px | on left-out views, px |")
        print("|---|---|---|")
        print(row(f"cornerSubPix {PLAIN_HALF_PX}", plain(images, views)))
        for share in SHARES:
            print(row(f"{share:g} of the distance", refined(images, views, share)))
    for first, one in enumerate(cameras):
        for other in cameras[first + 1 :]:
            for count in (1, 3, 5, len(other)):
                mixed = [*one, *other[:count]]
                named = suspects(mixed, estimate_for(mixed))
                wrong = sum(s.index < len(one) for s in named)
                right = len(named) - wrong
                print(f"{len(one)} views and {count} of another: {right} named, {wrong} wrongly")


if __name__ == "__main__":
    main()
