"""Figure 5 and the reduction: a picture like the paper's arena, and how few points carry it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

import planner
import vision
from benchmarks.paper import canvas, diagrams, inputs
from navigation.draw.shapes import OBSTACLE, OBSTACLE_EDGE, Area
from planner.borders.generators import gather_borders, place_generators
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds, CircleRecord, PolygonRecord, Scene, Segment
from vision.binarise.binarise import binarise
from vision.borders.contours import laplacian_border

OUTSIDE = Bounds(-0.5, -0.5, inputs.PICTURE_SIZE[0] - 0.5, inputs.PICTURE_SIZE[1] - 0.5)


@dataclass(frozen=True, slots=True)
class Reduction:
    """n, m and p of one picture; ``walls`` are the generators on the bounds, not in p."""

    border_pixels: int
    vertices: int
    generators: int
    walls: int
    spacing: float

    @property
    def share(self) -> float:
        """p / n."""
        return self.generators / self.border_pixels


def generators_of(scene: Scene, spacing: float, mode: str) -> tuple[int, int]:
    """How many generators lie on the objects, and on the bounds."""
    made = place_generators(gather_borders(scene, mode), spacing)  # type: ignore[arg-type]
    walls = int(np.count_nonzero(made.owner < 0))
    return len(made.sites) - walls, walls


def spacing_for(scene: Scene, generators: int) -> float:
    """The delta at which the paper's way takes just so many generators, or nearly so."""
    deltas = np.arange(8.0, 40.0, 0.1)
    counts = [generators_of(scene, float(d), "paper")[0] for d in deltas]
    return round(float(deltas[int(np.argmin(np.abs(np.array(counts) - generators)))]), 1)


def reduce(arena: inputs.Picture) -> tuple[Reduction, Reduction]:
    """The reduction of the arena's picture, the paper's way and by default, at one delta."""
    scenes = {mode: vision.extract(arena.image, mode=mode) for mode in ("paper", "exact")}
    spacing = spacing_for(scenes["paper"], inputs.PAPER_GENERATORS)
    made = []
    for mode, scene in scenes.items():
        on_objects, walls = generators_of(scene, spacing, mode)
        n = arena.border_pixels
        made.append(Reduction(n, scene.vertex_count, on_objects, walls, spacing))
    return made[0], made[1]


def kinds(scene: Scene) -> tuple[int, int, int]:
    """How many simple polygons, generalized polygons and circles a scene holds."""
    records = [r for o in scene.objects for r in o.records]
    circles = sum(isinstance(r, CircleRecord) for r in records)
    simple = sum(
        isinstance(r, PolygonRecord) and all(isinstance(e, Segment) for e in r.edges)
        for r in records
    )
    return simple, len(records) - simple - circles, circles


def figure_5(arena: inputs.Picture, spacing: float) -> str:
    """The picture; what the paper's recipe makes of it; its AGVD; and the default mode's."""
    radius = 0.55 * spacing
    seen = vision.extract(arena.image, mode="paper")
    ours = vision.extract(arena.image)
    paper = diagrams.approximate(seen, spacing, radius)
    exact = planner.build_roadmap(ours, radius, spacing=spacing)
    on_objects, _ = generators_of(seen, spacing, "paper")
    captions = (
        f"The picture: n = {arena.border_pixels} border pixels",
        f"The paper's structure: m = {seen.vertex_count}, p = {on_objects}",
        "Its AGVD",
        f"By default: m = {ours.vertex_count}, exact bisectors",
    )
    page, made = canvas.panels(OUTSIDE, captions, 2, 430.0, "Figure 5")
    left, top = made[0].screen.frame[0].tolist()
    size = (made[0].screen.frame[2] - made[0].screen.frame[0]).tolist()
    page.add_picture(arena.image, (left, top, size[0], size[1]))
    made[0].frame()
    _structure(made[1], arena.image, seen, paper)
    for panel, scene, roadmap in ((made[2], seen, paper), (made[3], ours, exact)):
        panel.floor()
        panel.scene(scene)
        panel.by_clearance(*diagrams.chain_segments(roadmap))
        panel.frame()
    canvas.note(
        page,
        f"dark dots: vertices; red: generators every delta = {spacing:g} px; diagrams coloured by"
        " exact clearance, warm is tight; walls count as an object",
    )
    return page.svg()


def _structure(
    panel: canvas.Panel, image: NDArray[np.uint8], scene: Scene, roadmap: Roadmap
) -> None:
    """The border pixels pale, the vertices dark, the generators between them red."""
    panel.floor()
    border = laplacian_border(binarise(image, method="otsu").inside).astype(np.uint8)
    found = cv2.findContours(border, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]
    for ring in found:
        points = panel.screen.points(ring.reshape(-1, 2).astype(np.float64))
        panel.draw(Area((points,), (205, 208, 212), stroke=(150, 155, 162)))
    generators = roadmap.agvd.generators
    panel.dots(generators.sites[generators.owner >= 0], 2.0, canvas.SITE)
    vertices = [
        edge.start
        for o in scene.objects
        for r in o.records
        if isinstance(r, PolygonRecord)
        for edge in r.edges
    ]
    panel.dots(np.array(vertices), 2.6, OBSTACLE, OBSTACLE_EDGE)
    for o in scene.objects:
        for r in o.records:
            if isinstance(r, CircleRecord):
                panel.dots(np.array([r.center]), 2.6, OBSTACLE, OBSTACLE_EDGE)
    panel.frame()
