"""Changes in the arena; a static one costs a millisecond a frame and no new fitting.

Rules and units
- Pixels are raw, centres at integers; rectangles are (x, y, width, height).
- Cells of a few pixels are compared with a reference, the mean of earlier ones. The threshold
  follows the frame's noise, edges may tremble a little, and a change of the whole light is divided
  out.
- After the first frames of a place the reference changes only where a change was reported, or
  something slow would be absorbed.
- Ground under a robot is unknown: ``background`` keeps its last picture. Ground never seen is
  filled from around it until the robot drives off.
- A change is reported after two frames in a row.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from vision.camera.camera import Image

Rectangle: TypeAlias = tuple[int, int, int, int]
_Cells: TypeAlias = NDArray[np.float32]
_Mask: TypeAlias = NDArray[np.uint8]

_CELLS_ACROSS = 240
_MAX_CELL_PX = 8
_AVERAGED_FRAMES = 16
_DARKEST_FOR_GAIN = 30.0
_NOISE_FACTOR = 5.5
_REFRESH_GAIN = 0.1
_RIM_CELLS = 2
_LEAST_CONTRAST = 6.0
"""Grey levels."""
_LEAST_CELLS = 3
"""Connected ones."""
_TREMOR = 0.15
"""Share of the local contrast that an edge may differ by; 0.15 is a shake of half a pixel."""
_SPARSE = 23
"""Every 23rd cell is in a median's sample; a prime, so that all columns take part."""


@dataclass(frozen=True, slots=True)
class Change:
    """Rectangles in which something was added, removed or moved.

    ``first``: the first frame. ``relit``: the background is at another exposure, so that all its
    grey values differ.
    """

    rectangles: tuple[Rectangle, ...]
    first: bool = False
    relit: bool = False


class SceneWatcher:
    """Comparison of each frame with the arena as last reported."""

    def __init__(self) -> None:
        self._background: Image | None = None
        self._cell_px = 1
        self._reference: _Cells = np.empty((0, 0), np.float32)
        self._counts: _Cells = np.empty((0, 0), np.float32)
        self._tolerance: _Cells = np.empty((0, 0), np.float32)
        self._unseen: _Mask = np.empty((0, 0), np.uint8)
        self._pending: _Mask = np.empty((0, 0), np.uint8)
        self._pending_frames = 0
        self._frames = 0

    @property
    def background(self) -> Image:
        """Read-only copy of the arena without robots; raises ``ValueError`` before a frame."""
        if self._background is None:
            raise ValueError("there is no background before the first frame")
        copy = self._background.copy()
        copy.setflags(write=False)
        return copy

    def update(self, image: Image, bodies: ArrayLike | None) -> Change | None:
        """Compare a frame; return the change, or None.

        ``image`` (h, w) or (h, w, 3) uint8; ``bodies`` (k, 3): x, y, radius of the discs that
        robots cover, ``markers.body_discs_px``. With None, for an unknown place, the frame is not
        judged: the robot would look like an obstacle. The first frame, and one of another size, is
        a change of everything.
        """
        if bodies is None:
            return None
        discs = np.asarray(bodies, dtype=np.float64).reshape(-1, 3)
        if self._background is None or self._background.shape != image.shape:
            return self._begin(image, discs)
        cells = self._shrink(image)
        covered = self._covered(discs)
        gain = self._gain(cells, covered)
        difference = self._reference * np.float32(gain)
        np.abs(np.subtract(cells, difference, out=difference), out=difference)
        changed = self._changed(difference, covered)
        confirmed = self._confirm(changed)
        self._reveal(image, covered, changed)
        if confirmed is None:
            self._average(cells, covered, changed, gain)
            return None
        return self._adopt(image, cells, covered, confirmed, gain)

    def _begin(self, image: Image, discs: NDArray[np.float64]) -> Change:
        height, width = image.shape[:2]
        wanted = min(max(1, min(height, width) // _CELLS_ACROSS), _MAX_CELL_PX)
        self._cell_px = 1 << (wanted.bit_length() - 1)
        cells = self._shrink(image)
        self._unseen = self._covered_in(cells.shape, discs)
        self._background = _fill(image, self._pixels_of(self._unseen, image.shape[:2]))
        self._reference = self._shrink(self._background)
        self._counts = np.where(self._unseen > 0, 0.0, 1.0).astype(np.float32)
        self._pending = np.zeros(cells.shape, np.uint8)
        self._pending_frames = 0
        self._frames = 0
        self._measure_tolerance()
        return Change(((0, 0, width, height),), first=True)

    def _shrink(self, image: Image) -> _Cells:
        """Mean grey of each whole cell, float32; the cell's side is a power of two."""
        n = self._cell_px
        height, width = image.shape[0] // n, image.shape[1] // n
        part = image[: height * n, : width * n]
        small = np.asarray(part)
        # repeated halving is vectorised and seven times as fast as one step
        while n > 1:
            n //= 2
            size = (width * n, height * n)
            small = np.asarray(cv2.resize(small, size, interpolation=cv2.INTER_AREA))
        grey = cv2.cvtColor(small, cv2.COLOR_BGR2GRAY) if small.ndim == 3 else small
        return np.asarray(grey, dtype=np.float32)

    def _covered(self, discs: NDArray[np.float64]) -> _Mask:
        return self._covered_in(self._reference.shape, discs)

    def _covered_in(self, shape: tuple[int, ...], discs: NDArray[np.float64]) -> _Mask:
        mask = np.zeros(shape, np.uint8)
        n = self._cell_px
        for x, y, radius in discs:
            if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(radius)):
                raise ValueError(f"body disc ({x}, {y}, {radius}): must be finite")
            column, row = (x + 0.5) / n - 0.5, (y + 0.5) / n - 0.5
            reach = radius / n + 0.75
            x0, x1 = max(0, math.floor(column - reach)), math.ceil(column + reach) + 1
            y0, y1 = max(0, math.floor(row - reach)), math.ceil(row + reach) + 1
            part = mask[y0 : max(y1, 0), x0 : max(x1, 0)]
            rows, columns = np.ogrid[y0 : y0 + part.shape[0], x0 : x0 + part.shape[1]]
            part[(columns - column) ** 2 + (rows - row) ** 2 <= reach * reach] = 255
        return mask

    def _gain(self, cells: _Cells, covered: _Mask) -> float:
        """Gain of the whole picture's light: the median ratio of a few thousand cells."""
        now, before = cells.ravel()[::_SPARSE], self._reference.ravel()[::_SPARSE]
        usable = (before > _DARKEST_FOR_GAIN) & (covered.ravel()[::_SPARSE] == 0)
        if np.count_nonzero(usable) < 16:
            return 1.0
        gain = _median(now[usable] / before[usable])
        return min(max(gain, 0.25), 4.0)

    def _changed(self, difference: _Cells, covered: _Mask) -> _Mask:
        noise = 1.4826 * _median(difference.ravel()[::_SPARSE])
        limit = max(_LEAST_CONTRAST, _NOISE_FACTOR * noise)
        changed = (difference - self._tolerance > np.float32(limit)).view(np.uint8)
        changed *= 255
        changed[covered > 0] = 0
        return changed

    def _confirm(self, changed: _Mask) -> _Mask | None:
        """Connected cells that differ now and in the last frame, or None."""
        before, self._pending = self._pending, changed
        if cv2.countNonZero(changed) < _LEAST_CELLS:
            self._pending_frames = 0
            return None
        count, labels, stats, _ = cv2.connectedComponentsWithStats(changed, connectivity=8)
        big = stats[:, cv2.CC_STAT_AREA] >= _LEAST_CELLS
        big[0] = False
        if not big.any():
            self._pending_frames = 0
            return None
        self._pending_frames += 1
        # something fast overlaps nothing of the last frame, but is there
        if self._pending_frames < 3:
            near = cv2.dilate(before, np.ones((5, 5), np.uint8))
            met = np.zeros(count, dtype=np.bool_)
            met[np.unique(labels[near > 0])] = True
            big &= met
        if not big.any():
            return None
        return np.asarray(big[labels] * np.uint8(255), dtype=np.uint8)

    def _average(self, cells: _Cells, covered: _Mask, changed: _Mask, gain: float) -> None:
        """Take unchanged cells into the reference's mean, while it is young.

        Later only uncovered ground is young, and every fourth frame is enough.
        """
        self._frames += 1
        if self._frames > _AVERAGED_FRAMES and self._frames % 4 != 0:
            return
        young = (self._counts < _AVERAGED_FRAMES) & (covered == 0) & (changed == 0)
        if not young.any():
            return
        self._counts[young] += 1.0
        step = (cells[young] / np.float32(gain) - self._reference[young]) / self._counts[young]
        self._reference[young] += step
        self._measure_tolerance()

    def _reveal(self, image: Image, covered: _Mask, changed: _Mask) -> None:
        """Replace filled pixels by real ones where the floor is seen for the first time.

        A difference is a change like any other.
        """
        if not self._unseen.any():
            return
        shown = (self._unseen > 0) & (covered == 0) & (changed == 0)
        if shown.any():
            mask = shown.astype(np.uint8) * np.uint8(255)
            self._unseen[shown] = 0
            self._copy(image, mask, 1.0)

    def _adopt(
        self, image: Image, cells: _Cells, covered: _Mask, confirmed: _Mask, gain: float
    ) -> Change:
        size = 2 * _RIM_CELLS + 1
        region = cv2.dilate(confirmed, np.ones((size, size), np.uint8)).astype(np.uint8)
        rectangles = self._rectangles(region, image)
        region[covered > 0] = 0
        relit = abs(gain - 1.0) > _REFRESH_GAIN
        if relit:
            # the light has changed: one picture must not mix two exposures
            region[covered == 0] = 255
            self._reference *= np.float32(gain)
            if self._background is not None:
                self._background = cv2.convertScaleAbs(self._background, alpha=gain).astype(
                    np.uint8, copy=False
                )
            gain = 1.0
        inside = region > 0
        self._reference[inside] = cells[inside] / np.float32(gain)
        self._counts[inside] = 1.0
        self._unseen[inside] = 0
        self._frames = 0
        self._copy(image, region, gain)
        self._measure_tolerance()
        self._pending = np.zeros_like(self._pending)
        self._pending_frames = 0
        return Change(rectangles, relit=relit)

    def _rectangles(self, region: _Mask, image: Image) -> tuple[Rectangle, ...]:
        count, _, stats, _ = cv2.connectedComponentsWithStats(region, connectivity=8)
        n, (height, width) = self._cell_px, image.shape[:2]
        found = []
        for x, y, w, h, _ in stats[1:count].tolist():
            x0, y0 = x * n, y * n
            # the last whole cell covers the pixels behind it too
            x1 = width if x + w == region.shape[1] else (x + w) * n
            y1 = height if y + h == region.shape[0] else (y + h) * n
            found.append((x0, y0, x1 - x0, y1 - y0))
        return tuple(found)

    def _copy(self, image: Image, mask: _Mask, gain: float) -> None:
        """Copy a mask's cells into the background, at the reference's exposure."""
        x, y, w, h = cv2.boundingRect(mask)
        if self._background is None or w == 0:
            return
        n, (height, width) = self._cell_px, image.shape[:2]
        rows = slice(y * n, height if y + h == mask.shape[0] else (y + h) * n)
        columns = slice(x * n, width if x + w == mask.shape[1] else (x + w) * n)
        source = image[rows, columns]
        if gain != 1.0:
            source = cv2.convertScaleAbs(source, alpha=1.0 / gain).astype(np.uint8, copy=False)
        chosen = self._pixels_of(mask[y : y + h, x : x + w], source.shape[:2]) > 0
        self._background[rows, columns][chosen] = source[chosen]

    def _pixels_of(self, mask: _Mask, shape: tuple[int, ...]) -> _Mask:
        rows = np.minimum(np.arange(shape[0]) // self._cell_px, mask.shape[0] - 1)
        columns = np.minimum(np.arange(shape[1]) // self._cell_px, mask.shape[1] - 1)
        return mask[np.ix_(rows, columns)]

    def _measure_tolerance(self) -> None:
        box = np.ones((3, 3), np.uint8)
        contrast = cv2.morphologyEx(self._reference, cv2.MORPH_GRADIENT, box)
        self._tolerance = (contrast * np.float32(_TREMOR)).astype(np.float32)


def _median(values: _Cells) -> float:
    """Upper median, in a third of the time of numpy's."""
    middle = len(values) // 2
    return float(np.partition(values, middle)[middle])


def _fill(image: Image, hidden: _Mask) -> Image:
    """Copy of the picture with hidden pixels filled from around them.

    Each connected part gets the median of a ring around it, which is floor.
    """
    filled = image.copy()
    count, labels, stats, _ = cv2.connectedComponentsWithStats(hidden, connectivity=8)
    for label in range(1, count):
        x, y, w, h, _ = stats[label].tolist()
        rim = 6
        rows = slice(max(0, y - rim), y + h + rim)
        columns = slice(max(0, x - rim), x + w + rim)
        part = (labels[rows, columns] == label).astype(np.uint8)
        ring = cv2.dilate(part, np.ones((2 * rim + 1, 2 * rim + 1), np.uint8))
        around = (ring > 0) & (hidden[rows, columns] == 0)
        if around.any():
            value = np.median(image[rows, columns][around], axis=0)
            filled[rows, columns][part > 0] = np.round(value).astype(np.uint8)
    return filled
