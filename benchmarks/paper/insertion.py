"""Figures 1 and 2: the diagram of 14 points, and the insertion of the 15th, step by step.

The walk of the paper's section 2.3 is made here from the 14 points' half-edges alone, so that
the kernel's diagram of the 15 points can be checked against it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import planner
from benchmarks.paper import canvas, inputs
from navigation.draw.shapes import FAINT_INK, FLOOR, PATH, Area, Strokes
from planner.delaunay.half_edges import HalfEdges
from planner.delaunay.voronoi_diagram import voronoi_arrays

Points = NDArray[np.float64]
NEW = (118, 42, 190)


@dataclass(frozen=True, slots=True)
class Walk:
    """The new site's region: ``around`` (k,), the sites whose bisectors bound it, in the order
    of the walk; ``corners`` (k, 2), where the bisector with each of them begins."""

    around: tuple[int, ...]
    corners: Points


def walk_around(diagram: HalfEdges, new: Points) -> Walk:
    """The paper's walk: from the bisector with the nearest site's region on to its neighbours'.

    ``new`` must be such that its region is bounded; ``ValueError`` otherwise.
    """
    first = int(np.argmin(np.linalg.norm(diagram.sites - new, axis=1)))
    cell, at = first, None
    around, corners = [], []
    while True:
        leaves, half_edge = _exit(diagram, cell, new, at)
        if at is not None:
            around.append(cell)
            corners.append(at)
            if cell == first:
                break
        at = leaves
        cell = int(diagram.cell[half_edge ^ 1])
        if len(around) > len(diagram.sites):
            raise ValueError("the walk does not close: the new region is not bounded")
    return Walk((around[-1], *around[:-1]), np.array([corners[-1], *corners[:-1]]))


def _exit(d: HalfEdges, cell: int, new: Points, begin: Points | None) -> tuple[Points, int]:
    """Where the bisector of ``new`` and a site, walked with ``new`` on its left, leaves the
    site's region, and through which half-edge."""
    site = d.sites[cell]
    toward = new - site
    along = np.array([toward[1], -toward[0]])
    middle = 0.5 * (new + site)
    best, through = np.inf, -1
    for e in np.flatnonzero(d.cell == cell):
        other = d.sites[d.cell[e ^ 1]]
        # on the line middle + t along: nearer to `other` than to `site` beyond the crossing
        slope = float(along @ (other - site))
        if slope <= 0.0:
            continue
        t = float((0.5 * (other + site) - middle) @ (other - site)) / slope
        if t < best:
            best, through = t, int(e)
    if through < 0:
        raise ValueError("the bisector never leaves the region: the new region is not bounded")
    return middle + best * along, through


def new_region(new: Points, sites: Points) -> tuple[set[int], Points]:
    """Neighbours and vertices (k, 2) of ``new`` in the kernel's diagram of all points."""
    d = planner.voronoi(np.vstack([sites, new]))
    mine = np.flatnonzero(d.cell == len(sites))
    return {int(i) for i in d.cell[mine ^ 1]}, d.vertices[d.origin[mine]]


def figure_1() -> str:
    """The ordinary diagram of 14 generators."""
    sites = inputs.fourteen_sites()
    caption = "The ordinary Voronoi diagram of 14 generators"
    page, (panel,) = canvas.panels(inputs.SQUARE, [caption], 1, 400.0, "Figure 1")
    panel.floor()
    _diagram(panel, sites)
    panel.frame()
    panel.dots(sites, 3.2, canvas.SITE)
    for i, site in enumerate(sites):
        panel.label(site, f"p{i + 1}")
    return page.svg()


def figure_2() -> str:
    """The 15th generator is inserted: one panel a stage of the walk."""
    sites, new = inputs.fourteen_sites(), inputs.fifteenth_site()
    walk = walk_around(planner.voronoi(sites), new)
    k = len(walk.around)
    names = [f"p{i + 1}" for i in walk.around]
    captions = (
        f"1. p15 lies in the region of {names[0]}",
        f"2. its bisector with {names[0]}, to both edges",
        f"3. from its end on with {names[1]}",
        f"4. and {', '.join(names[2:])}: closed",
        "5. what is enclosed is removed",
        "6. the region of p15",
    )
    page, made = canvas.panels(inputs.SQUARE, captions, 3, 300.0, "Figure 2")
    d = planner.voronoi(sites)
    cell = _cell_polygon(d, walk.around[0])
    closed = np.vstack([walk.corners, walk.corners[:1]])
    old, _ = canvas.diagram_segments(voronoi_arrays(sites), sites, 2000.0)
    done = (0, 1, 2, k, k, k)
    for step, panel in enumerate(made):
        panel.floor()
        if step == 0:
            panel.draw(Area((panel.screen.points(cell),), PATH, 0.16))
        if done[step] == k:
            panel.draw(Area((panel.screen.points(walk.corners),), NEW, 0.14))
        _diagram(panel, np.vstack([sites, new]) if step > 3 else sites)
        if step == 4:
            enclosed = _inside(old, walk.corners)
            panel.lines(enclosed, FAINT_INK, 1.2, dash=(3.0, 4.0))
        for i in range(done[step]):
            line = panel.screen.points(closed[i : i + 2])
            panel.draw(Strokes((line,), NEW, 2.6))
        if 0 < done[step] < k:
            panel.dots(closed[: done[step] + 1], 3.2, FLOOR, NEW)
        panel.frame()
        panel.dots(sites, 3.2, canvas.SITE)
        panel.dots(new[None], 4.2, NEW)
        panel.label(new, "p15", 7.0, 4.0)
        for i in walk.around:
            panel.label(sites[i], f"p{i + 1}")
    return page.svg()


def _diagram(panel: canvas.Panel, sites: Points) -> None:
    segments, _ = canvas.diagram_segments(voronoi_arrays(sites), sites, 2000.0)
    panel.lines(segments, canvas.REDUCED, 1.5)


def _inside(segments: Points, corners: Points) -> Points:
    """The parts of segments (n, 4) inside a convex polygon (k, 2), whichever way it turns."""
    middle = corners.mean(axis=0)
    parts = []
    for segment in segments:
        a, along = segment[:2], segment[2:] - segment[:2]
        low, high = 0.0, 1.0
        for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            inward = np.array([p[1] - q[1], q[0] - p[0]])
            if inward @ (middle - p) < 0.0:
                inward = -inward
            here, slope = float(inward @ (a - p)), float(inward @ along)
            if slope > 0.0:
                low = max(low, -here / slope)
            elif slope < 0.0:
                high = min(high, -here / slope)
            elif here < 0.0:
                low = 2.0
        if low < high:
            parts.append([*(a + low * along), *(a + high * along)])
    return np.array(parts).reshape(-1, 4)


def _cell_polygon(d: HalfEdges, cell: int) -> Points:
    """The corners of a bounded cell, in order."""
    e = first = int(np.flatnonzero(d.cell == cell)[0])
    corners = []
    while True:
        corners.append(d.vertices[d.origin[e]])
        e = int(d.next[e])
        if e == first:
            return np.array(corners)
