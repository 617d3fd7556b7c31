"""Figures 3 and 4: the AGVD of generalized polygons, with and without its invalid edges.

Figure 4 has a second panel, the default mode: arcs as arcs, vertices solved on the borders, and
the edges that lead into what an object encloses.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import planner
from benchmarks.paper import canvas, inputs
from planner.diagram.agvd import Agvd
from planner.roadmap.roadmap import Roadmap
from planner.scene import Scene

SPACING = 14.0
RADIUS = 8.0
"""delta < 2 r, as the paper asks."""

Points = NDArray[np.float64]


def approximate(scene: Scene, spacing: float = SPACING, radius: float = RADIUS) -> Roadmap:
    """The roadmap the paper's way."""
    return planner.build_roadmap(scene, radius, spacing=spacing, mode="paper")


def all_edges(agvd: Agvd) -> tuple[Points, NDArray[np.bool_]]:
    """Every edge of the generators' diagram (n, 4), and whether it is valid (n,)."""
    sites = agvd.generators.sites
    segments, rows = canvas.diagram_segments(agvd.ordinary, sites, 3000.0)
    return segments, agvd.valid[rows]


def chain_segments(roadmap: Roadmap) -> tuple[Points, Points]:
    """The links of the roadmap's chains (n, 4) that keep the robot's radius, and the clearance
    of each (n,)."""
    chains = roadmap.chains
    inner = np.ones(len(chains.points), np.bool_)
    inner[chains.first[1:] - 1] = False
    inner &= chains.gap >= roadmap.radius
    at = np.flatnonzero(inner)
    links = np.hstack([chains.points[at], chains.points[at + 1]])
    return links, chains.gap[at]


def figure_3() -> str:
    """All edges: valid and invalid."""
    scene = inputs.drawn_objects()
    roadmap = approximate(scene)
    generators = roadmap.agvd.generators
    caption = f"All edges of the diagram of {len(generators.sites)} generators"
    page, (panel,) = canvas.panels(inputs.SQUARE, [caption], 1, 560.0, "Figure 3")
    segments, valid = all_edges(roadmap.agvd)
    panel.floor()
    panel.scene(scene, 0.25)
    panel.lines(segments[~valid], canvas.INVALID, 0.9)
    panel.lines(segments[valid], canvas.REDUCED, 1.7)
    panel.frame()
    panel.dots(generators.sites, 1.7, canvas.SITE)
    canvas.note(
        page, f"dots: generators, at most {SPACING:g} apart; blue: valid edges; pale: invalid ones"
    )
    return page.svg()


def figure_4() -> str:
    """The valid edges, the paper's way and by default."""
    scene = inputs.drawn_objects()
    ways = (approximate(scene), planner.build_roadmap(scene, RADIUS, spacing=SPACING))
    captions = ("The paper's way: invalid edges omitted", "The default mode: exact bisectors")
    page, made = canvas.panels(inputs.SQUARE, captions, 2, 430.0, "Figure 4")
    for panel, roadmap in zip(made, ways, strict=True):
        panel.floor()
        panel.scene(scene)
        panel.by_clearance(*chain_segments(roadmap))
        panel.frame()
    canvas.note(page, "coloured by exact clearance: warm is tight, cool is wide")
    return page.svg()
