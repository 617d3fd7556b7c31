"""Table 1 and figure 6: full pixels against reduced pixels, from the picture to the diagram.

Both ways start at the same binarised picture. Full: every border pixel is a generator, and
edges between pixels of one object are dropped. Reduced: corners and circles, generators every
delta, their diagram, invalid edges omitted. The default way is timed beside them: its diagram
is exact. Medians of one thread's processor time, after a first run that compiles: other
programs on the machine are not counted, though they still crowd its caches.
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from time import thread_time

import cv2
import numpy as np
from numpy.typing import NDArray

import planner
import vision
from benchmarks.paper import canvas, charts, inputs
from benchmarks.paper.charts import Fit, fit
from navigation.draw.shapes import Colour
from planner.borders.generators import gather_borders, place_generators
from planner.delaunay.voronoi_diagram import voronoi_arrays
from planner.diagram.agvd import omit_invalid
from planner.diagram.mesh import make_mesh
from planner.scene import Bounds, Primitives, Scene
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders
from vision.paper.corners import find_corners
from vision.paper.paper import paper_objects

PAPER_TABLE = (
    (260, 2690, 24, 110),
    (393, 5600, 33, 270),
    (559, 10660, 47, 380),
    (691, 15600, 55, 490),
    (763, 18790, 66, 660),
)
"""Table 1 of the paper: full pixels, ms, reduced pixels, ms."""
LARGER = (1_661, 10_000, 100_000, 1_000_000)
SAID_GAIN = 0.38
"""The paper: "better than the full pixel approach by an order of 38%"."""
DEFAULT_RADIUS_PER_SPACING = 0.55


@dataclass(frozen=True, slots=True)
class Row:
    """One picture. Times are medians in ms; ``runs`` of them.

    ``seeing`` (binarise and follow contours) is part of all three chains, ``corners`` (corners,
    circles and records) of the reduced one; ``eigenvalues`` are the corners' compiled part.
    """

    border_pixels: int
    runs: int
    seeing_ms: float
    full_diagram_ms: float
    full_chain_ms: float
    vertices: int
    generators: int
    eigenvalues_ms: float
    corners_ms: float
    reduced_diagram_ms: float
    reduced_chain_ms: float
    default_chain_ms: float


class _ObjectsOnly:
    """A scene without the walls of its bounds: neither way of the paper counts them."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def primitives(self) -> Primitives:
        """The borders of the objects."""
        return self._scene.primitives(include_bounds=False)


def measure(wanted: int, spacing: float, runs: int) -> Row:
    """Time both ways on a picture of about ``wanted`` border pixels."""
    picture = inputs.crowd_picture(wanted)
    laps: list[dict[str, float]] = []
    for _ in range(runs + 1):
        lap: dict[str, float] = {}
        _full_and_reduced(picture.image, spacing, lap)
        laps.append(lap)
    counts = laps[0]

    def of(*names: str) -> float:
        return statistics.median(sum(lap[name] for name in names) for lap in laps[1:])

    return Row(
        border_pixels=picture.border_pixels,
        runs=runs,
        seeing_ms=of("see"),
        full_diagram_ms=of("full diagram"),
        full_chain_ms=of("see", "full points", "full diagram", "full omit"),
        vertices=int(counts["m"]),
        generators=int(counts["p"]),
        eigenvalues_ms=of("eigenvalues"),
        corners_ms=of("corners"),
        reduced_diagram_ms=of("reduced diagram"),
        reduced_chain_ms=of("see", "corners", "generators", "reduced diagram", "reduced omit"),
        default_chain_ms=of("default"),
    )


def _full_and_reduced(image: NDArray[np.uint8], spacing: float, lap: dict[str, float]) -> None:
    clock = _Laps(lap)
    borders = follow_borders(binarise(image, method="otsu").mask)
    clock("see")
    contours, starts = borders.contours()
    sites = contours.astype(np.float64)
    owner = np.repeat(borders.owner, np.diff(starts))
    clock("full points")
    full = voronoi_arrays(sites)
    clock("full diagram")
    _between_objects = full.edges[owner[full.edges[:, 0]] != owner[full.edges[:, 1]]]
    clock("full omit")
    height, width = image.shape
    bounds = Bounds(-0.5, -0.5, width - 0.5, height - 0.5)
    find_corners(*borders.contours())
    clock("eigenvalues")
    scene = Scene("px", bounds, paper_objects(borders))
    clock("corners")
    made = place_generators(gather_borders(_ObjectsOnly(scene), "paper"), spacing)
    clock("generators")
    voronoi_arrays(made.sites)
    clock("reduced diagram")
    mesh = make_mesh(made)
    clock("the same diagram, as triangles")
    omit_invalid(mesh, made, "paper")
    clock("reduced omit")
    seen = vision.extract(image)
    planner.build_roadmap(seen, DEFAULT_RADIUS_PER_SPACING * spacing, spacing=spacing)
    clock("default")
    lap["m"], lap["p"] = scene.vertex_count, len(made.sites)


class _Laps:
    """Milliseconds since the last call, under a name."""

    def __init__(self, laps: dict[str, float]) -> None:
        self._laps = laps
        self._last = thread_time()

    def __call__(self, name: str) -> None:
        self._laps[name] = (thread_time() - self._last) * 1e3
        self._last = thread_time()


def table(spacing: float, largest: int = 1_000_000) -> list[Row]:
    """All rows up to ``largest`` border pixels: many runs where they are quick."""
    sizes = [row[0] for row in PAPER_TABLE] + [n for n in LARGER if n <= largest]
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return [measure(n, spacing, 41 if n < 5_000 else 7 if n < 500_000 else 3) for n in sizes]
    finally:
        cv2.setNumThreads(threads)


Fits = tuple[Fit, Fit]


def paper_fits() -> Fits:
    """Of the paper's own table: full over full pixels, reduced over reduced pixels."""
    full_n, full_ms, reduced_n, reduced_ms = (
        list(map(float, c)) for c in zip(*PAPER_TABLE, strict=True)
    )
    return fit(full_n, full_ms), fit(reduced_n, reduced_ms)


def our_fits(rows: Sequence[Row], what: str) -> Fits:
    """The same of our rows; ``what`` is "diagram" or "chain"."""
    full = fit([r.border_pixels for r in rows], [getattr(r, f"full_{what}_ms") for r in rows])
    reduced = fit([r.generators for r in rows], [getattr(r, f"reduced_{what}_ms") for r in rows])
    return full, reduced


def figure_6(rows: Sequence[Row]) -> str:
    """The paper's table with its lines, ours at the same sizes, and ours over all sizes."""
    page = canvas.Page(740.0, 770.0, "Figure 6")
    small = [r for r in rows if r.border_pixels < 1_000]
    left, right, top, low = 66.0, 440.0, 44.0, 420.0
    said = charts.Chart(page, left, top, "The paper's Table 1", "generators", "ms")
    said.plain(
        [(float(a), float(b)) for a, b, _, _ in PAPER_TABLE],
        [(float(a), float(b)) for _, _, a, b in PAPER_TABLE],
    )
    here = charts.Chart(page, right, top, "The same sizes here", "generators", "ms")
    here.plain(
        [(r.border_pixels, r.full_diagram_ms) for r in small],
        [(r.generators, r.reduced_diagram_ms) for r in small],
    )
    alone = charts.Chart(page, left, low, "Diagram alone", "border pixels n", "ms")
    alone.logarithmic([_line(rows, "full_diagram_ms"), _line(rows, "reduced_diagram_ms")])
    chain = charts.Chart(page, right, low, "From the picture on", "border pixels n", "ms")
    names = ("full_chain_ms", "reduced_chain_ms", "default_chain_ms")
    chain.logarithmic([_line(rows, name) for name in names])
    charts.key(
        page,
        746.0,
        (66.0, canvas.FULL, "full pixels"),
        (200.0, canvas.REDUCED, "reduced, the paper's way"),
        (440.0, canvas.DEFAULT, "reduced, default mode: exact, to the roadmap"),
    )
    return page.svg()


def _line(rows: Sequence[Row], name: str) -> tuple[list[tuple[float, float]], Colour]:
    """One time over the border pixels, and its colour."""
    colours = {"full": canvas.FULL, "reduced": canvas.REDUCED, "default": canvas.DEFAULT}
    dots = [(float(r.border_pixels), float(getattr(r, name))) for r in rows]
    return dots, colours[name.split("_")[0]]
