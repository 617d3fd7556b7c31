"""How a generalized diagram comes about: sampled, solved, refined. Pixels, y down."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

import planner
from benchmarks.paper import canvas, inputs
from benchmarks.paper.canvas import DEFAULT, FULL, INVALID, REDUCED, SITE, Panel
from benchmarks.paper.diagrams import all_edges, chain_segments
from navigation.draw.shapes import Strokes
from planner.borders.generators import Generators, gather_borders, place_generators
from planner.diagram.agvd import omit_invalid
from planner.diagram.mesh import make_mesh
from planner.roadmap.roadmap import Roadmap
from planner.scene import CircleRecord, PolygonRecord, Scene, SceneObject, primitive_kernels
from tests.support.drawn.render import polygon

Points = NDArray[np.float64]
SPACING, RADIUS = 22.0, 12.0
COARSE = 80.0
"""Generators so far apart that the sampled diagram is wrong in places."""
CIRCLES = 3
"""As many empty circles are shown."""


def long_walls() -> Scene:
    """Long sides that pass each other closely, beside a small disc."""
    outlines = (
        [(40.0, 120.0), (360.0, 60.0), (360.0, 85.0), (40.0, 145.0)],
        [
            (60.0, 190.0),
            (350.0, 130.0),
            (352.0, 300.0),
            (325.0, 300.0),
            (324.0, 162.0),
            (64.0, 215.0),
        ],
        [(50.0, 330.0), (230.0, 230.0), (250.0, 345.0)],
    )
    records: list[PolygonRecord | CircleRecord] = [polygon(outline) for outline in outlines]
    records.append(CircleRecord((290.0, 350.0), 12.0))
    objects = tuple(SceneObject(i, (record,)) for i, record in enumerate(records))
    return Scene("px", inputs.SQUARE, objects)


def sampled(scene: Scene, spacing: float) -> tuple[Generators, Points, NDArray[np.bool_]]:
    """The generators, their ordinary diagram's edges (n, 4), and which are valid (n,)."""
    generators = place_generators(gather_borders(scene), spacing)
    agvd = omit_invalid(make_mesh(generators), generators, "exact")
    segments, valid = all_edges(agvd)
    return generators, segments, valid


def solved(scene: Scene, spacing: float) -> Roadmap:
    """The roadmap on the solved diagram."""
    return planner.build_roadmap(scene, 0.5 * spacing + 1.0, spacing=spacing)


def links(roadmap: Roadmap) -> Points:
    """All links of the chains (n, 4), however narrow."""
    chains = roadmap.chains
    inner = np.ones(len(chains.points), np.bool_)
    inner[chains.first[1:] - 1] = False
    at = np.flatnonzero(inner)
    return np.hstack([chains.points[at], chains.points[at + 1]])


def ring(center: Points, radius: float) -> Points:
    """A circle as a polyline."""
    angle = np.linspace(0.0, math.tau, 96)
    return np.asarray(center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def empty_circles(panel: Panel, roadmap: Roadmap, count: int) -> None:
    """The widest vertices in the panel, with their circles and the feet that these touch."""
    nodes, rho = roadmap.chains.node_xy, roadmap.chains.node_rho
    wide = np.argsort(-rho)[:count]
    borders = roadmap.borders
    for i in wide:
        panel.draw(Strokes((panel.screen.points(ring(nodes[i], rho[i])),), REDUCED, 1.2))
        feet = [
            primitive_kernels.foot(borders.kind, borders.data, p, *nodes[i])
            for p in range(borders.primitive_count)
            if primitive_kernels.distance(borders.kind, borders.data, p, *nodes[i])
            <= rho[i] * (1.0 + 1e-6)
        ]
        spokes = np.array([[*nodes[i], *foot] for foot in feet])
        panel.lines(spokes, REDUCED, 0.9)
    panel.dots(nodes[wide], 3.2, (255, 255, 255), REDUCED)


def sampled_figure() -> str:
    """The generators' diagram, and what of it is valid."""
    scene = inputs.drawn_objects()
    generators, segments, valid = sampled(scene, SPACING)
    captions = ("The generators' Voronoi diagram", "Its valid edges")
    page, (left, right) = canvas.panels(inputs.SQUARE, captions, 2, 400.0, "The sampled diagram")
    for panel in (left, right):
        panel.floor()
        panel.scene(scene, 0.25)
    left.lines(segments[~valid], INVALID, 0.9)
    for panel in (left, right):
        panel.lines(segments[valid], FULL, 1.6)
        panel.frame()
        panel.dots(generators.sites, 2.0, SITE)
    canvas.note(page, f"dots: generators, at most {SPACING:g} px apart; pale: invalid edges")
    return page.svg()


def solved_figure() -> str:
    """Vertices on the borders, and chains bent onto the bisectors."""
    scene = inputs.drawn_objects()
    _, segments, valid = sampled(scene, SPACING)
    roadmap = solved(scene, SPACING)
    captions = ("Vertices: as far from three pieces", "Chains: bent onto the bisectors")
    page, (left, right) = canvas.panels(inputs.SQUARE, captions, 2, 400.0, "The solved diagram")
    for panel in (left, right):
        panel.floor()
        panel.scene(scene)
    left.lines(segments[valid], FULL, 1.2)
    empty_circles(left, roadmap, CIRCLES)
    right.by_clearance(*chain_segments(roadmap))
    for panel in (left, right):
        panel.frame()
    canvas.note(page, "left: empty circles and their feet; right: warm is tight, cool is wide")
    return page.svg()


def refined_figure() -> str:
    """Where sampling was too coarse, generators are added at the feet around a vertex."""
    scene = long_walls()
    generators, segments, valid = sampled(scene, COARSE)
    roadmap = solved(scene, COARSE)
    captions = ("Sampled: generators far apart", "Refined at the feet until proved")
    page, (left, right) = canvas.panels(inputs.SQUARE, captions, 2, 400.0, "Refinement")
    for panel in (left, right):
        panel.floor()
        panel.scene(scene, 0.6)
    left.lines(segments[valid], FULL, 1.6)
    right.lines(links(roadmap), DEFAULT, 1.8)
    for panel in (left, right):
        panel.frame()
        panel.dots(generators.sites, 2.4, SITE)
    known = {tuple(site) for site in np.round(generators.sites, 6).tolist()}
    sites = roadmap.agvd.generators.sites
    added = [tuple(np.round(s, 6).tolist()) not in known for s in sites]
    right.dots(sites[np.array(added)], 2.8, (255, 255, 255), REDUCED)
    canvas.note(page, f"red: generators at most {COARSE:g} px apart; rings: those that were added")
    return page.svg()
