"""The records of a scene, drawn over the picture they were found in.

The scene is in pixels. The picture is enlarged, in lower contrast so that the lines stand out.
Segments are crimson, arcs violet, circles green, corners dots of ink.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from navigation.draw.layers import screen_borders
from navigation.draw.legend import LEGEND_WIDTH, scale_bar
from navigation.draw.numbers import obstacle_labels
from navigation.draw.outlines import chain_points
from navigation.draw.shapes import (
    BOTTLENECK,
    FAINT_INK,
    FRAME,
    INK,
    PAGE,
    PATH,
    TRACK,
    Colour,
    DiscShape,
    Drawing,
    Label,
    Layer,
    Photo,
    Screen,
    Shape,
    Strokes,
)
from planner.scene import (
    Arc,
    ArcRecord,
    CircleRecord,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SegmentRecord,
    object_records,
    record_edges,
)

SEGMENT, ARC, CIRCLE, CORNER = BOTTLENECK, TRACK, PATH, INK
LARGEST_PX, MOST_SCALE = 1920, 4
"""Width or height that an enlarged picture stays below, and its largest enlargement."""
MARGIN, LEAST_HEIGHT = 24, 380
LETTERS: dict[type[Record], tuple[str, str, str]] = {
    PointRecord: ("P", "point", "points"),
    SegmentRecord: ("S", "segment", "segments"),
    CircleRecord: ("C", "circle", "circles"),
    ArcRecord: ("A", "open chain", "open chains"),
    PolygonRecord: ("L", "polygon", "polygons"),
}


def overlay_drawing(image: NDArray[Any], scene: Scene, title: str = "Clearway") -> Drawing:
    """Draw every record over the enlarged, pale picture."""
    rows, columns = image.shape[:2]
    scale = max(1, min(MOST_SCALE, LARGEST_PX // max(rows, columns)))
    screen = Screen(scene.bounds, True, float(scale), MARGIN, MARGIN)
    width, height = float(columns * scale), float(rows * scale)
    page_height = round(max(height, LEAST_HEIGHT) + 2 * MARGIN)
    left = 2 * MARGIN + width
    lines = tuple(_records(scene, screen))
    outline = np.vstack([screen.frame, screen.frame[:1]])
    letters = ["".join(LETTERS[type(r)][0] for r in obj.records) for obj in scene.objects]
    texts = [f"{number} {kinds}" for number, kinds in enumerate(letters)]
    labels = obstacle_labels(screen_borders(scene, screen), texts, screen, INK)
    return Drawing(
        width=round(left + LEGEND_WIDTH + MARGIN),
        height=page_height,
        view=(MARGIN, MARGIN, MARGIN + width, MARGIN + height),
        layers=(
            Layer("picture", (Photo(_pale(image), MARGIN, MARGIN, width, height),)),
            Layer("bounds", (Strokes((outline,), FRAME, 1.5),)),
            Layer("records", lines),
            Layer("labels", tuple(labels)),
            Layer("legend", tuple(_legend(scene, screen, title, page_height - MARGIN)), False),
        ),
        title=title,
    )


def _pale(image: NDArray[Any]) -> NDArray[np.uint8]:
    top = max(int(image.max()), 1) if image.dtype == np.uint16 else 255
    eight = np.asarray(image * (255.0 / top), dtype=np.uint8)
    if eight.ndim == 2 or eight.shape[2] == 1:
        eight = np.repeat(eight.reshape(*eight.shape[:2], 1), 3, axis=2)
    return np.asarray(128 + eight[:, :, :3] // 2, dtype=np.uint8)


def _records(scene: Scene, screen: Screen) -> Iterator[Shape]:
    by_colour: dict[Colour, list[FloatArray]] = {SEGMENT: [], ARC: [], CIRCLE: []}
    corners: list[tuple[float, float]] = []
    for obj in scene.objects:
        for record in object_records(obj):
            if isinstance(record, CircleRecord):
                line = chain_points(record, scene.y_down)
                by_colour[CIRCLE].append(screen.points(line))
                continue
            for edge in record_edges(record):
                one = chain_points(ArcRecord((edge,)), scene.y_down)
                by_colour[ARC if isinstance(edge, Arc) else SEGMENT].append(screen.points(one))
                corners += [edge.start, edge.end]
            if isinstance(record, PointRecord):
                corners.append(record.at)
    for lines in by_colour.values():
        if lines:
            yield Strokes(tuple(lines), PAGE, 4.2)
    for colour, lines in by_colour.items():
        if lines:
            yield Strokes(tuple(lines), colour, 2.2)
    places = np.unique(np.array(corners).reshape(-1, 2), axis=0)
    for x, y in screen.points(places).tolist():
        yield DiscShape(x, y, 3.4, fill=CORNER, stroke=PAGE, width=1.0)


def _legend(scene: Scene, screen: Screen, title: str, bottom: float) -> Iterator[Shape]:
    left = float(screen.frame[:, 0].max()) + MARGIN
    y = MARGIN + 16.0
    yield Label(left, y, title, 18.0, INK, bold=True)
    y += 22.0
    count = len(scene.objects)
    yield Label(left, y, f"{count} obstacle{'' if count == 1 else 's'}", 12.0, FAINT_INK)
    y += 28.0
    records = [r for obj in scene.objects for r in object_records(obj)]
    edges = [e for r in records if not isinstance(r, CircleRecord) for e in record_edges(r)]
    arcs = sum(isinstance(edge, Arc) for edge in edges)
    found = Counter(type(r) for r in records)
    for words, colour, number in (
        ("segments", SEGMENT, len(edges) - arcs),
        ("arcs", ARC, arcs),
        ("circles", CIRCLE, found[CircleRecord]),
    ):
        if number:
            bar = np.array([(left + 2.0, y), (left + 30.0, y)])
            yield Strokes((bar,), colour, 2.2)
            yield Label(left + 40.0, y + 4.5, f"{words} ({number})", 13.0)
            y += 24.0
    if edges or found[PointRecord]:
        yield DiscShape(left + 16.0, y, 3.4, fill=CORNER, stroke=PAGE, width=1.0)
        yield Label(left + 40.0, y + 4.5, "corners, ends and points", 13.0)
        y += 24.0
    y += 8.0
    for kind, (letter, one, many) in LETTERS.items():
        if found[kind]:
            yield Label(left + 16.0, y + 4.5, letter, 13.0, INK, "middle", bold=True)
            words = f"{found[kind]} {one if found[kind] == 1 else many}"
            yield Label(left + 40.0, y + 4.5, words, 13.0)
            y += 20.0
    residuals = [r.residual_px for r in records]
    if residuals:
        y += 10.0
        worst = f"largest residual {max(residuals):.2f} px"
        yield Label(left, y + 4.5, worst, 12.0, FAINT_INK)
    yield from scale_bar(screen, scene.units, left, bottom)
