"""Global Vision on one screen: from a picture to a scene.

Rules and units
- A picture's scene is in pixels, centres at integers, y down, its bounds the picture's edges.
- With a calibration the edge points are mapped before anything is fitted, and the records
  come out in metres, y up, inside the bounds that the caller gives.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds, Scene
from vision.binarise import Method, PictureError, Polarity, binarise
from vision.contours import follow_borders, locate_edges
from vision.fitting import fit_edges, tolerance_of
from vision.structure import build_objects

Mode: TypeAlias = Literal["exact", "paper"]


class Calibration(Protocol):
    """What turns pixels into metres."""

    @property
    def metres_per_pixel(self) -> float:
        """The nominal size of a pixel on the floor."""
        ...

    def arena_from_image(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points of the picture (n, 2) in pixels to the arena's metres (n, 2), y up."""
        ...


def extract(
    image: NDArray[Any],
    *,
    mode: Mode = "exact",
    polarity: Polarity = "dark",
    method: Method = "auto",
    threshold: float | None = None,
    calibration: Calibration | None = None,
    bounds: Bounds | None = None,
    ignore: NDArray[np.bool_] | None = None,
) -> Scene:
    """The minimum geometric structure of a picture.

    ``image`` (h, w), (h, w, 3) BGR or (h, w, 4) BGRA, uint8 or uint16, is never changed.
    ``polarity`` says which side of the threshold is obstacle. ``ignore`` (h, w) marks pixels
    that are no obstacle. Raises ``PictureError``. O(pixels) to threshold, then O(border).
    """
    if mode not in ("exact", "paper"):
        raise PictureError(f"mode {mode!r}: must be exact or paper")
    begin = perf_counter()
    binary = binarise(image, polarity=polarity, method=method, threshold=threshold, ignore=ignore)
    binarised = perf_counter()
    borders = follow_borders(binary.mask)
    edges = locate_edges(binary, borders)
    followed = perf_counter()
    tolerance = tolerance_of(edges, binary.noise, binary.contrast)
    fitted = fit_edges(edges.points, edges.starts, tolerance)
    objects = build_objects(borders, fitted)
    done = perf_counter()
    height, width = image.shape[:2]
    return Scene(
        units="px",
        bounds=Bounds(-0.5, -0.5, width - 0.5, height - 0.5),
        objects=objects,
        size=(width, height),
        border_pixels=len(borders.contours()[0]),
        binarisation=binary.how,
        timings_ms={
            "binarise": (binarised - begin) * 1e3,
            "contours": (followed - binarised) * 1e3,
            "geometry": (done - followed) * 1e3,
        },
        remarks=binary.remarks,
    )
