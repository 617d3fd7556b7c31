"""How large a window corners are refined in: the one whose lens predicts left-out views best.

Rules
- A small window has few pixels and much noise, a large one reaches the next corners of a tilted
  board; which is best depends on the pictures' sharpness, noise and tilts, so they decide.
- A view that no window helps counts as far off, not by how far: it is another's to judge
  (`suspects`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vision.calibrate.board import WINDOW_SHARE, BoardView, refine_corners
from vision.calibrate.left_out import Estimate, left_out_px
from vision.camera.camera import Image
from vision.markers.marker_search import grey_of

WINDOW_SHARES = (0.2, 0.25, 0.3, WINDOW_SHARE)
"""Half a window as a share of the distance to the nearest corner. Larger ones reach the next corner
of a tilted board (0.41 px rms instead of 0.18 on real pictures)."""
FEWEST_VIEWS = 6
"""From fewer views the residuals of left-out ones are a guess."""
_FAR_OFF = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class WindowChoice:
    """The ``views`` refined in the best window, its ``share``, and what each share gave.

    ``left_out_px`` is (share, rms in pixels of left-out views) for each that was tried; empty where
    there were too few views to choose.
    """

    views: tuple[BoardView, ...]
    share: float
    left_out_px: tuple[tuple[float, float], ...]


def choose_window(
    pictures: Sequence[Image],
    views: Sequence[BoardView],
    estimate: Estimate,
    largest: float = WINDOW_SHARE,
) -> WindowChoice:
    """The views of these pictures, in the window that suits them; ``estimate`` makes a lens.

    ``largest`` is the share that the views are refined with, ``BoardSpec.window_share``.
    Takes some 40 estimates. Raises ``CalibrationError`` where the views determine no lens.
    """
    sizes = {view.size for view in views}
    if len(views) < FEWEST_VIEWS or len(sizes) > 1:
        return WindowChoice(tuple(views), largest, ())
    shares = [share * largest / WINDOW_SHARE for share in WINDOW_SHARES[:-1]]
    refined = [
        [_refined(image, view, share) for image, view in zip(pictures, views, strict=True)]
        for share in shares
    ]
    refined.append(list(views))
    shares.append(largest)
    errors = np.array([left_out_px(these, estimate) for these in refined])
    far_off_px = _FAR_OFF * float(np.median(errors, axis=1).min())
    scores = np.sqrt(np.mean(np.minimum(errors, far_off_px) ** 2, axis=1))
    best = int(np.argmin(scores))
    table = tuple(zip(shares, scores.tolist(), strict=True))
    return WindowChoice(tuple(refined[best]), shares[best], table)


def _refined(image: Image, view: BoardView, share: float) -> BoardView:
    corners = refine_corners(grey_of(image), view.corners_px, share)
    corners.setflags(write=False)
    return BoardView(view.name, view.size, corners, view.points_m)
