"""Pictures of a scene, its roadmap and path, as SVG or PNG.

Obstacles are dark on a light floor; zones are tinted and patterned. The roadmap's colour goes from
warm (tight) to cool (wide). The path is green with the corridor that the robot sweeps; replaced
plans are pale green as far as they were driven. Waypoints are dots; the driven track is violet,
other robots pale violet. A red circle marks the narrowest place.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from navigation.draw.driven import DrawnRobot
from navigation.draw.layers import Content, OtherRobot, layers
from navigation.draw.legend import LEGEND_WIDTH, ROW, legend
from navigation.draw.shapes import Drawing, fit_screen
from navigation.draw.zones import zone_kinds
from planner.path import NoPath, Path, Trajectory
from planner.scene import FloatArray, Scene
from planner.zones.zone import Zone

if TYPE_CHECKING:
    from planner.roadmap.roadmap import Roadmap

PLOT_WIDTH, PLOT_HEIGHT = 1000, 760
"""Most pixels of the scene."""
LEAST_HEIGHT = 420
"""Room for the legend."""
MARGIN = 24
PIXEL_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp")


class DrawError(ValueError):
    """A picture cannot be written."""


class PictureOptions(TypedDict, total=False):
    """Optional contents of a picture besides scene, roadmap and path."""

    trajectory: Trajectory | None
    track: ArrayLike | None
    """(n, 2) in the scene's units; a row of NaN where the line breaks."""
    earlier: Sequence[ArrayLike]
    """Driven stretches (n, 2) of replaced plans."""
    others: Sequence[OtherRobot]
    driven: Sequence[DrawnRobot]
    """Several robots in their own colours."""
    stations: Sequence[Sequence[float]]
    """(x, y) or (x, y, heading_rad) each: start, vias, goal."""
    title: str
    zones: Sequence[Zone]


def draw_svg(
    scene: Scene,
    roadmap: Roadmap | None = None,
    path: Path | NoPath | None = None,
    **shown: Unpack[PictureOptions],
) -> str:
    """The picture as SVG text."""
    from navigation.draw.svg import to_svg

    return to_svg(_drawing(scene, roadmap, path, shown))


def draw_png(
    scene: Scene,
    roadmap: Roadmap | None = None,
    path: Path | NoPath | None = None,
    **shown: Unpack[PictureOptions],
) -> NDArray[np.uint8]:
    """The same picture as (height, width, 3) uint8 pixels, BGR."""
    from navigation.draw.png import to_pixels

    return to_pixels(_drawing(scene, roadmap, path, shown))


def save_picture(
    file: str | os.PathLike[str],
    scene: Scene,
    roadmap: Roadmap | None = None,
    path: Path | NoPath | None = None,
    **shown: Unpack[PictureOptions],
) -> None:
    """Write a picture; :class:`DrawError` if that fails."""
    save_drawing(file, _drawing(scene, roadmap, path, shown))


def save_drawing(file: str | os.PathLike[str], drawing: Drawing) -> None:
    """Write ``.svg`` or pixels; :class:`DrawError` if that fails."""
    target = FilePath(file)
    suffix = target.suffix.lower()
    if suffix == ".svg":
        from navigation.draw.svg import to_svg

        data = to_svg(drawing).encode("utf-8")
    elif suffix in PIXEL_SUFFIXES:
        import cv2

        from navigation.draw.png import to_pixels

        _, encoded = cv2.imencode(suffix, to_pixels(drawing))
        data = encoded.tobytes()
    else:
        raise DrawError(f"{target}: cannot draw {suffix or 'without a suffix'}: .svg or .png")
    try:
        target.write_bytes(data)
    except OSError as error:
        with contextlib.suppress(OSError):  # remove half a picture, but keep a device
            if target.is_file():
                target.unlink()
        raise DrawError(f"{target}: cannot be written: {error.strerror or error}") from None


def _drawing(
    scene: Scene, roadmap: Roadmap | None, path: Path | NoPath | None, shown: PictureOptions
) -> Drawing:
    track = shown.get("track")
    curves = None
    if roadmap is not None:
        from planner.roadmap.curves import curves_of

        curves = curves_of(roadmap)
    content = Content(
        scene,
        roadmap,
        curves,
        path,
        shown.get("trajectory"),
        None if track is None else _line(track),
        tuple(_line(line) for line in shown.get("earlier", ())),
        tuple(shown.get("others", ())),
        tuple(shown.get("driven", ())),
        tuple(tuple(float(v) for v in station) for station in shown.get("stations", ())),
        shown.get("title", "Clearway"),
        tuple(shown.get("zones", ())),
    )
    window = content.window()
    screen = fit_screen(window, scene.y_down, PLOT_WIDTH, PLOT_HEIGHT, MARGIN, MARGIN)
    width, height = screen.scale * window.width, screen.scale * window.height
    left = 2 * MARGIN + width
    least = LEAST_HEIGHT + ROW * (len(content.driven) + len(zone_kinds(content.zones)))
    page_height = round(max(height, least) + 2 * MARGIN)
    shapes = legend(content, screen, left, MARGIN, page_height - MARGIN)
    return Drawing(
        width=round(left + LEGEND_WIDTH + MARGIN),
        height=page_height,
        view=(MARGIN, MARGIN, MARGIN + width, MARGIN + height),
        layers=(*layers(content, screen), shapes),
        title=content.title,
    )


def _line(points: ArrayLike) -> FloatArray:
    return np.asarray(points, dtype=np.float64).reshape(-1, 2)
