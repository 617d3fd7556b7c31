"""The picture of an audit: the map, its zones, the graph, and its numbered findings.

An edge has the colour of its worst finding, a pale band as wide as the robot, and an arrow head
where it leads one way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from navigation.cli.pictures.audit_answer import PLURALS
from navigation.draw.layers import Content, layers
from navigation.draw.legend import scale_bar, wrapped
from navigation.draw.outlines import ring_points
from navigation.draw.picture import LEAST_HEIGHT, MARGIN, PLOT_HEIGHT, PLOT_WIDTH
from navigation.draw.shapes import (
    BOTTLENECK,
    FAINT_INK,
    GOAL,
    INK,
    PAGE,
    PATH,
    TRACK,
    Area,
    Colour,
    DiscShape,
    Drawing,
    Label,
    Layer,
    Screen,
    Shape,
    Strokes,
    fit_screen,
)
from planner.formats.mask_files import SpeedLevel
from planner.graph_audit.audit import GraphAudit
from planner.graph_audit.findings import SEVERITIES, GraphFinding
from planner.scene import Bounds, FloatArray, Scene
from planner.shared.figures import sized

COLOURS: dict[str, Colour] = {"unsafe": BOTTLENECK, "error": TRACK, "warning": GOAL}
SOUND, SLOW = PATH, GOAL
MOST_NUMBERED = 14
WORDS_WIDTH, ROW, LINE = 420, 22.0, 15.0
MOST_LETTERS = 62
FAR = 0.5
"""Nodes off the map are shown up to this part of its size away."""
ARROW_PX = 7.0


def audit_drawing(
    audit: GraphAudit,
    scene: Scene,
    zones: Scene | None = None,
    levels: Sequence[SpeedLevel] = (),
) -> Drawing:
    """Draw an audit with the scene, the keep-out zones and slow areas that it was made with."""
    content = Content(scene, None, None, None, None, None, (), (), (), (), "Audit")
    window = _window(audit, scene)
    screen = fit_screen(window, scene.y_down, PLOT_WIDTH, PLOT_HEIGHT, MARGIN, MARGIN)
    width, height = screen.scale * window.width, screen.scale * window.height
    numbered = [one for one in audit.findings if one.at is not None][:MOST_NUMBERED]
    left = 2 * MARGIN + width
    areas = [("keep-out zones", BOTTLENECK)] if zones is not None else []
    areas += [("slow areas", SLOW)] if levels else []
    words = list(_words(audit, numbered, areas, left))
    lowest = max((s.y for s in words if isinstance(s, Label)), default=0.0)
    bottom = max(MARGIN + height, LEAST_HEIGHT, lowest + 50.0)
    return Drawing(
        width=round(left + WORDS_WIDTH + MARGIN),
        height=round(bottom + MARGIN),
        view=(MARGIN, MARGIN, MARGIN + width, MARGIN + height),
        layers=(
            *(one for one in layers(content, screen) if one.name != "numbers"),
            Layer("slow", tuple(s for one in levels for s in _areas(one.area, SLOW, screen))),
            Layer("zones", () if zones is None else tuple(_areas(zones, BOTTLENECK, screen))),
            Layer("edges", tuple(_edges(audit, screen))),
            Layer("nodes", tuple(_nodes(audit, screen))),
            Layer("findings", tuple(_marks(numbered, screen))),
            Layer("legend", (*words, *scale_bar(screen, scene.units, left, bottom)), clipped=False),
        ),
        title="Audit",
    )


def _window(audit: GraphAudit, scene: Scene) -> Bounds:
    """Part of the plane to show: the map and the nodes near it, or the graph if that is small."""
    b = scene.bounds
    reach_x, reach_y = FAR * b.width, FAR * b.height
    points = np.array([(n.x, n.y) for n in audit.graph.nodes]).reshape(-1, 2)
    near = (points >= (b.x_min - reach_x, b.y_min - reach_y)).all(axis=1)
    points = points[near & (points <= (b.x_max + reach_x, b.y_max + reach_y)).all(axis=1)]
    if not len(points):
        return b
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    rim = 2.0 * audit.radius + 0.08 * max(x1 - x0, y1 - y0)
    part = Bounds(x0 - rim, y0 - rim, x1 + rim, y1 + rim)
    if not scene.bounds_given or part.width * part.height < 0.5 * b.width * b.height:
        return part
    low = min(b.x_min, part.x_min if x0 < b.x_min else b.x_min)
    bottom = min(b.y_min, part.y_min if y0 < b.y_min else b.y_min)
    high = max(b.x_max, part.x_max if x1 > b.x_max else b.x_max)
    top = max(b.y_max, part.y_max if y1 > b.y_max else b.y_max)
    return Bounds(low, bottom, high, top)


def _areas(areas: Scene, colour: Colour, screen: Screen) -> Iterator[Shape]:
    for area in areas.objects:
        rings = tuple(screen.points(ring) for ring in ring_points(area, areas.y_down))
        yield Area(rings, colour, opacity=0.16)


def _worst(audit: GraphAudit, subject: str) -> dict[str, str]:
    """Worst severity by name; the findings are sorted by it."""
    return {one.name: one.severity for one in reversed(audit.findings) if one.subject == subject}


def _edges(audit: GraphAudit, screen: Screen) -> Iterator[Shape]:
    worst = _worst(audit, "edge")
    lines = [screen.points(line) for line in audit.lines]
    wide = 2.0 * audit.radius * screen.scale
    yield Strokes(tuple(lines), SOUND, wide, opacity=0.10)
    pairs = {(edge.start, edge.end) for edge in audit.edges}
    for severity, colour in ((None, SOUND), *reversed(COLOURS.items())):
        own = [k for k, e in enumerate(audit.edges) if worst.get(e.name) == severity]
        if not own:
            continue
        yield Strokes(tuple(lines[k] for k in own), colour, 1.6 if severity is None else 3.0)
        heads = [
            _arrow(lines[k])
            for k in own
            if not audit.edges[k].both_ways
            and (audit.edges[k].end, audit.edges[k].start) not in pairs
        ]
        if heads:
            yield Strokes(tuple(heads), colour, 1.6)


def _arrow(line: FloatArray) -> FloatArray:
    """Arrow head in the middle of a line's longest piece."""
    steps = np.diff(line, axis=0)
    lengths = np.hypot(*steps.T)
    k = int(np.argmax(lengths))
    at = line[k] + 0.55 * steps[k]
    along = steps[k] / max(float(lengths[k]), 1e-9) * ARROW_PX
    across = np.array([-along[1], along[0]]) * 0.5
    return np.array([at - along + across, at, at - along - across])


def _nodes(audit: GraphAudit, screen: Screen) -> Iterator[Shape]:
    worst = _worst(audit, "node")
    for node in audit.graph.nodes:
        ((x, y),) = screen.points([(node.x, node.y)]).tolist()
        colour = COLOURS.get(worst.get(str(node.id), ""), SOUND)
        yield DiscShape(x, y, 3.0, fill=colour, stroke=PAGE, width=0.8)


def _marks(numbered: list[GraphFinding], screen: Screen) -> Iterator[Shape]:
    """Numbers at the findings' places, side by side where several are at one."""
    taken: list[tuple[float, float]] = []
    for number, one in enumerate(numbered, start=1):
        ((x, y),) = screen.points([one.at or (0.0, 0.0)]).tolist()
        y -= 14.0
        while any(abs(x - a) < 18.0 and abs(y - b) < 18.0 for a, b in taken):
            x += 19.0
        taken.append((x, y))
        yield DiscShape(x, y, 9.0, fill=COLOURS[one.severity], stroke=PAGE, width=1.2)
        yield Label(x, y + 4.0, str(number), 11.0, PAGE, "middle", bold=True)


def _words(
    audit: GraphAudit, numbered: list[GraphFinding], areas: list[tuple[str, Colour]], left: float
) -> Iterator[Shape]:
    y = MARGIN + 16.0
    yield Label(left, y, "Audit", 18.0, INK, bold=True)
    y += 20.0
    size = f"{len(audit.graph.nodes)} nodes, {len(audit.graph.edges)} edges"
    words = f"{size}, robot radius {sized(audit.radius, audit.units)}"
    yield Label(left, y, words, 12.0, FAINT_INK)
    y += 26.0
    rows = [(COLOURS[one], 3.0, f"{PLURALS[one]} ({len(audit.of(one))})") for one in SEVERITIES]
    for colour, width, words in (*rows, (SOUND, 1.6, "without a finding")):
        bar = np.array([(left + 2.0, y - 4.0), (left + 30.0, y - 4.0)])
        yield Strokes((bar,), colour, width)
        yield Label(left + 40.0, y, words, 13.0)
        y += ROW
    for words, colour in areas:
        low, high = (left + 2.0, y - 10.0), (left + 30.0, y + 2.0)
        swatch = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        yield Area((swatch,), colour, opacity=0.16)
        yield Label(left + 40.0, y, words, 13.0)
        y += ROW
    y += 8.0
    for number, one in enumerate(numbered, start=1):
        yield DiscShape(left + 9.0, y - 4.0, 9.0, fill=COLOURS[one.severity])
        yield Label(left + 9.0, y, str(number), 11.0, PAGE, "middle", bold=True)
        for line in wrapped(str(one), MOST_LETTERS):
            yield Label(left + 26.0, y, line, 12.0)
            y += LINE
        y += 7.0
    rest = len(audit.findings) - len(numbered)
    if rest:
        yield Label(left, y, f"and {rest} more", 12.0, FAINT_INK)
