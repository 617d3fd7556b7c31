"""Observation of a camera for some seconds; keeps data, not pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from planner.scene import FloatArray
from vision.camera.camera import Frame, Image
from vision.camera.v4l2.modes import Size
from vision.markers.marker_search import find_markers, grey_of
from vision.quality.brightness import Flicker, clipped_of, flicker_of, noise_of
from vision.quality.focus import Focus, blur_along, focus_of
from vision.quality.timing import Timing, even_times, timing_of

NOISE_EVERY: Final = 5
"""Step between pairs compared: some show moving things."""
MOST_DIFFERENCES: Final = 40
BANDS: Final = 240
"""Most groups of rows: flicker's bands are tens of rows high."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenMarker:
    """A marker in the last picture; ``blur_px`` is None if its sides are not clear."""

    id: int
    corners_px: FloatArray
    blur_px: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """Quality of a camera. ``timing``, ``noise_grey``, ``flicker`` are None where unknown."""

    picture: Image
    """The last one, grey."""
    size: Size
    timing: Timing | None
    noise_grey: float | None
    flicker: Flicker | None
    brightness: float
    """Mean grey level, 0..255."""
    white: float
    black: float
    """Clipped shares of pixels, of the arena if a mask was given."""
    focus: Focus
    markers: tuple[SeenMarker, ...]


class Watching:
    """Collector of frames; ``judge`` evaluates them. ``mask`` (h, w) is 255 in the arena."""

    def __init__(self, mask: Image | None = None) -> None:
        self._mask = mask
        self._stamps_s: list[float] = []
        self._arrivals_s: list[float] = []
        self._rows: list[FloatArray] = []
        self._differences: list[Image] = []
        self._last: Image | None = None
        self._is_still = True

    def add(self, frame: Frame, arrived_s: float) -> None:
        """Add one picture, in order; one of another size restarts the collection."""
        grey = grey_of(frame.image)
        last = self._last
        if last is not None and last.shape != grey.shape:
            self._stamps_s, self._arrivals_s, self._rows, self._differences = [], [], [], []
            last = None
        self._stamps_s.append(frame.captured_s)
        self._arrivals_s.append(arrived_s)
        rows = cv2.reduce(grey, 1, cv2.REDUCE_AVG, dtype=cv2.CV_32F)
        bands = min(BANDS, len(rows))
        few = cv2.resize(rows, (1, bands), interpolation=cv2.INTER_AREA).ravel()
        self._rows.append(few.astype(np.float64))
        if last is not None and len(self._stamps_s) % NOISE_EVERY == 0:
            difference = cv2.absdiff(grey, last)
            if difference.any():
                self._is_still = False
            if len(self._differences) < MOST_DIFFERENCES:
                self._differences.append(difference[::4, ::2].astype(np.uint8, copy=False))
        self._last = grey

    @property
    def pictures(self) -> int:
        """Number of pictures so far."""
        return len(self._stamps_s)

    def judge(self, dictionary: str | None = None) -> Quality | None:
        """Judge the pictures; None if there are none. ``dictionary``: the markers to look for."""
        grey = self._last
        if grey is None:
            return None
        stamps_s = np.array(self._stamps_s)
        timing = timing_of(stamps_s, np.array(self._arrivals_s))
        # pictures without any noise repeat one file
        is_live = timing is not None and not self._is_still
        fits = self._mask is not None and self._mask.shape == grey.shape
        mask = self._mask if fits else None
        white, black = clipped_of(grey, mask)
        flicker = flicker_of(even_times(stamps_s), np.stack(self._rows)) if is_live else None
        found = find_markers(grey, dictionary) if dictionary else []
        markers = tuple(SeenMarker(i, quad, blur_along(grey, quad)) for i, quad in found)
        return Quality(
            picture=grey,
            size=(int(grey.shape[1]), int(grey.shape[0])),
            timing=timing,
            noise_grey=noise_of(self._differences) if is_live else None,
            flicker=flicker,
            brightness=float(grey.mean()),
            white=white,
            black=black,
            focus=focus_of(grey, mask),
            markers=markers,
        )
