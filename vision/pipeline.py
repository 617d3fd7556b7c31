"""From a picture to a scene.

Rules and units
- A scene is in pixels, centres at integers, y down; its bounds are the picture's edges.
- With a calibration, the fit works on the floor, in rectified pixels of the nominal size, each
  border shrunk to its size in the picture, so that tolerances stay in pixels; records are in
  metres, y up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds, Scene, SceneObject, of_kind
from vision.binarise import Method, Polarity
from vision.binarise.colour import binarise_by_colour
from vision.binarise.grey_picture import SMOOTHED_NOISE, Binary, as_array
from vision.borders.contours import Contours, follow_borders, laplacian_border, locate_edges
from vision.doubts import with_doubts
from vision.outline.fitting import fit_edges, is_bilevel, tolerance_of
from vision.outline.thin_walls import keep_thin_walls
from vision.paper.paper import paper_objects
from vision.picture_error import PictureError
from vision.records.placement import (
    PixelsToFloor,
    Placement,
    drop_outside,
    ignored_pixels,
)
from vision.records.records import build_objects, find_specks
from vision.records.unseen import blind_of, hidden_by_lens, with_unseen, without_blind
from vision.shared.array_pool import ArrayPool

Mode: TypeAlias = Literal["exact", "paper"]
_POOL = ArrayPool()


def extract(
    image: NDArray[Any] | Sequence[Any],
    *,
    mode: Mode = "exact",
    polarity: Polarity = "dark",
    method: Method = "auto",
    threshold: float | None = None,
    calibration: PixelsToFloor | None = None,
    bounds: Bounds | Sequence[float] | NDArray[np.float64] | None = None,
    ignore: NDArray[np.bool_] | Sequence[tuple[float, float, float]] | None = None,
) -> Scene:
    """Extract a picture's obstacles as records P, S, C, A, L.

    ``image`` (h, w), (h, w, 1), (h, w, 3) BGR or (h, w, 4) BGRA, uint8, uint16 or sequences of
    whole numbers, is never changed. ``mode`` is ``exact`` or ``paper``, the paper's recipe
    verbatim. ``polarity`` is the side of the level that is obstacle; ``method`` and ``threshold``
    find the level (``vision.binarise.binarise``). ``calibration`` and ``bounds`` (in metres, or
    x_min, y_min, x_max, y_max) make a scene in metres; objects wholly outside are dropped, with a
    remark. ``vision.doubts`` adds remarks. ``ignore`` marks pixels that are not obstacles: (h, w)
    bool, or discs (x, y, radius) in pixels. Raises ``PictureError`` for an unusable picture or
    option, and if no pixel is free. Thread-safe. O(pixels) to threshold, then O(border pixels).
    """
    for name, word in (("mode", mode), ("polarity", polarity), ("method", method)):
        of_kind(name, word, str)
    _refuse(mode, calibration, bounds)
    clock = _StopWatch()
    image = as_array(image)
    blind = blind_of(calibration)
    if blind is not None:
        image = without_blind(image, blind)
    skip = ignored_pixels(ignore, image)
    binary = binarise_by_colour(
        image, polarity=polarity, method=method, threshold=threshold, ignore=skip, pool=_POOL
    )
    clock.lap("binarise")
    borders = follow_borders(binary.mask, _POOL)
    if mode == "paper":
        return _by_the_paper(binary, borders, clock)
    edges = locate_edges(binary, borders, _POOL)
    clock.lap("contours")
    tolerance = tolerance_of(edges, binary.noise, binary.contrast)
    placement = Placement.of(calibration, bounds, binary.size)
    rectified = placement.rectified(edges.points)
    stretches = placement.stretches(edges.points, rectified, edges.starts)
    bilevel = tolerance.crisp or is_bilevel(binary.grey, borders)
    even = calibration is None or bool((stretches == 1.0).all())
    shrunk = rectified
    if not even:
        shrunk = rectified / np.repeat(stretches, np.diff(edges.starts))[:, None]
    # on the floor, there are no pixels for edges to separate
    fitted = fit_edges(
        shrunk, edges.starts, borders, tolerance, bilevel=calibration is None and bilevel
    )
    fitted = fitted if even else fitted.stretched(stretches)
    if binary.fine or bilevel or binary.noise >= SMOOTHED_NOISE:
        fitted = keep_thin_walls(fitted, borders, placement.rectified, fine=binary.fine)
    specks = find_specks(borders, binary.noise, binary.contrast if binary.doubtful else math.inf)
    objects = build_objects(borders, fitted, placement, specks.borders)
    objects, outside = drop_outside(objects, placement)
    clock.lap("geometry")
    remarks = (*specks.remarks, *outside)
    scene = _scene(binary, objects, placement, borders.pixels, clock, remarks)
    if blind is None:
        return scene
    return with_unseen(scene, hidden_by_lens(calibration, placement.bounds, extract))


def _refuse(
    mode: str,
    calibration: PixelsToFloor | None,
    bounds: Bounds | Sequence[float] | NDArray[np.float64] | None,
) -> None:
    if mode not in ("exact", "paper"):
        raise PictureError(f"mode {mode!r}: must be exact or paper")
    if bounds is not None and calibration is None:
        raise PictureError("bounds: a picture in pixels has its own; only a calibration takes them")
    if mode == "paper" and calibration is not None:
        raise PictureError("mode paper: works in pixels, without a calibration")


def _by_the_paper(binary: Binary, borders: Contours, clock: _StopWatch) -> Scene:
    border_pixels = int(np.count_nonzero(laplacian_border(binary.inside)))
    clock.lap("contours")
    objects = paper_objects(borders)
    clock.lap("geometry")
    return _scene(binary, objects, Placement.of(None, None, binary.size), border_pixels, clock, ())


def _scene(
    binary: Binary,
    objects: tuple[SceneObject, ...],
    placement: Placement,
    border_pixels: int,
    clock: _StopWatch,
    remarks: tuple[str, ...],
) -> Scene:
    scene = Scene(
        units=placement.units,
        bounds=placement.bounds,
        objects=objects,
        bounds_given=placement.bounds_given,
        size=binary.size,
        border_pixels=border_pixels,
        binarisation=binary.how,
        timings_ms=clock.laps,
        remarks=(*binary.remarks, *remarks),
    )
    return with_doubts(scene)


class _StopWatch:
    def __init__(self) -> None:
        self._times: dict[str, float] = {}
        self._begin = self._last = perf_counter()

    def lap(self, name: str) -> None:
        now = perf_counter()
        self._times[name] = (now - self._last) * 1e3
        self._last = now

    @property
    def laps(self) -> Mapping[str, float]:
        return {**self._times, "total": (self._last - self._begin) * 1e3}
