"""The flat shapes of pictures, in screen pixels, and their shared colours.

x is right, y down; (0, 0) is the picture's upper left corner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds, FloatArray

Colour: TypeAlias = tuple[int, int, int]
"""Red, green, blue, 0..255."""

PAGE: Colour = (255, 255, 255)
FLOOR: Colour = (247, 247, 244)
OBSTACLE: Colour = (58, 64, 72)
OBSTACLE_EDGE: Colour = (30, 34, 40)
FRAME: Colour = (120, 126, 134)
INK: Colour = (38, 42, 48)
FAINT_INK: Colour = (110, 116, 124)
PATH: Colour = (10, 122, 62)
OTHER_PATH: Colour = (126, 176, 140)
OTHER_PATH_INK: Colour = (52, 112, 72)
TRACK: Colour = (118, 42, 190)
OTHER_ROBOT: Colour = (186, 156, 222)
OTHER_ROBOT_INK: Colour = (124, 84, 168)
BOTTLENECK: Colour = (214, 28, 78)
START: Colour = (10, 122, 62)
GOAL: Colour = (184, 92, 0)

ROBOTS: tuple[Colour, ...] = (
    (23, 0, 216),
    (207, 69, 0),
    (0, 115, 144),
    (115, 0, 0),
    (161, 69, 216),
    (115, 115, 96),
    (0, 0, 72),
    (46, 0, 24),
)
"""Colours of several robots, repeated from the ninth on: names and numbers differ too. White on
each has a contrast of 4.5 at least, and any two differ by 28 (CIE 1976), also for people who lack
one kind of cones: found by search, and tested."""

CLEARANCE_RAMP: tuple[Colour, ...] = (
    (202, 40, 36),
    (236, 124, 44),
    (214, 172, 60),
    (96, 170, 140),
    (44, 128, 184),
    (30, 66, 140),
)
"""From tight to wide; brightness distinguishes them too."""
RAMP_STEPS = 24


@dataclass(frozen=True, slots=True)
class Area:
    """The inside of closed rings, (n, 2) each, by the even-odd rule."""

    rings: tuple[FloatArray, ...]
    fill: Colour
    opacity: float = 1.0
    stroke: Colour | None = None


@dataclass(frozen=True, slots=True)
class Strokes:
    """Open polylines (n, 2); ``dash`` is on and off in pixels."""

    lines: tuple[FloatArray, ...]
    colour: Colour
    width: float
    opacity: float = 1.0
    dash: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Motion:
    """A disc's places (n, 2), each at a share of a film of ``film_s`` seconds, which repeats."""

    places: FloatArray
    shares: FloatArray
    film_s: float


@dataclass(frozen=True, slots=True)
class DiscShape:
    """A circle, filled, stroked or both; one with a ``motion`` is in films only."""

    x: float
    y: float
    radius: float
    fill: Colour | None = None
    stroke: Colour | None = None
    width: float = 1.0
    opacity: float = 1.0
    motion: Motion | None = None


@dataclass(frozen=True, slots=True)
class Label:
    """A line of text; (x, y) is the ``anchor`` of its base line."""

    x: float
    y: float
    text: str
    size: float = 13.0
    colour: Colour = INK
    anchor: str = "start"
    bold: bool = False
    halo: bool = False


@dataclass(frozen=True, slots=True)
class Photo:
    """Pixels (h, w, 3) uint8, BGR, over the rectangle from (x, y); each is a sharp square."""

    pixels: NDArray[np.uint8]
    x: float
    y: float
    width: float
    height: float
    opacity: float = 1.0


Shape: TypeAlias = Area | Strokes | DiscShape | Label | Photo


@dataclass(frozen=True, slots=True)
class Layer:
    """A named group of shapes; ``clipped`` to the drawing's ``view``."""

    name: str
    shapes: tuple[Shape, ...]
    clipped: bool = True


@dataclass(frozen=True, slots=True)
class Drawing:
    """A whole picture: size in pixels, layers bottom up, ``view`` left, top, right, bottom."""

    width: int
    height: int
    view: tuple[float, float, float, float]
    layers: tuple[Layer, ...]
    title: str = ""


@dataclass(frozen=True, slots=True)
class Screen:
    """Window of the scene on the page, at ``scale`` pixels a unit."""

    bounds: Bounds
    y_down: bool
    scale: float
    left: float
    top: float
    frame: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        corners = self.points(self.bounds.corners())
        corners.setflags(write=False)
        object.__setattr__(self, "frame", corners)

    def points(self, scene_points: FloatArray | Sequence[Sequence[float]]) -> FloatArray:
        """(n, 2) screen pixels of (n, 2) scene points."""
        xy = np.asarray(scene_points, dtype=np.float64).reshape(-1, 2)
        x = self.left + (xy[:, 0] - self.bounds.x_min) * self.scale
        down = xy[:, 1] - self.bounds.y_min if self.y_down else self.bounds.y_max - xy[:, 1]
        return np.stack([x, self.top + down * self.scale], axis=1)

    def heading(self, heading_rad: float) -> float:
        """Angle on the screen, clockwise from the right."""
        return heading_rad if self.y_down else -heading_rad


def fit_screen(
    window: Bounds, y_down: bool, width: float, height: float, left: float, top: float
) -> Screen:
    """Fit the window into ``width`` x ``height`` pixels, as large as possible."""
    scale = min(width / window.width, height / window.height)
    return Screen(window, y_down, scale, left, top)


def ramp_colour(step: int) -> Colour:
    """Colour of one of ``RAMP_STEPS`` steps from tight (0) to wide."""
    at = step / (RAMP_STEPS - 1) * (len(CLEARANCE_RAMP) - 1)
    low = min(int(at), len(CLEARANCE_RAMP) - 2)
    part = at - low
    r, g, b = (
        round(p + part * (q - p))
        for p, q in zip(CLEARANCE_RAMP[low], CLEARANCE_RAMP[low + 1], strict=True)
    )
    return r, g, b
