"""The legend beside the plot, and a scale."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from navigation.draw.driven import PLAN_DASH, PLAN_WIDTH, colour_of
from navigation.draw.layers import Content
from navigation.draw.numbers import MOST_BESIDE
from navigation.draw.robot_marks import lines_of
from navigation.draw.shapes import (
    BOTTLENECK,
    FAINT_INK,
    INK,
    OBSTACLE,
    OTHER_PATH,
    OTHER_ROBOT,
    PAGE,
    PATH,
    RAMP_STEPS,
    TRACK,
    Area,
    Colour,
    DiscShape,
    Label,
    Layer,
    Screen,
    Shape,
    Strokes,
    ramp_colour,
)
from navigation.draw.zones import zone_kinds, zone_mark
from planner.borders.polyline import arc_lengths
from planner.path import NoPath, Path
from planner.scene import FloatArray
from planner.shared.figures import at_most, sized

LEGEND_WIDTH = 236
ROW = 26.0
"""Pixels between rows."""
_TEXT = 40.0
"""Left side of the words."""
_Mark: TypeAlias = Callable[[float], Sequence[Shape]]
"""A row's mark at its height."""


def legend(content: Content, screen: Screen, left: float, top: float, bottom: float) -> Layer:
    """Draw the legend from ``top`` down, with the scale at ``bottom``."""
    shapes: list[Shape] = [Label(left, top + 16.0, content.title, 18.0, INK, bold=True)]
    y = top + 34.0
    for line in _subtitle(content):
        shapes.append(Label(left, y + 4.0, line, 12.0, FAINT_INK))
        y += 17.0
    y += 14.0
    for mark, words in _rows(content, left):
        shapes += mark(y)
        shapes.append(Label(left + _TEXT, y + 4.5, words, 13.0))
        y += ROW
    shapes += _ramp(content, left, y)
    shapes += scale_bar(screen, content.scene.units, left, bottom)
    return Layer("legend", tuple(shapes), clipped=False)


def _subtitle(content: Content) -> Iterator[str]:
    radius, units = content.robot_radius, content.scene.units
    if radius is not None:
        yield f"robot radius {sized(radius, units)}"
    if isinstance(content.path, NoPath):
        yield from wrapped(f"no path: {content.path.reason}", 36)
        if content.path.widest_radius is not None:
            yield f"widest robot: radius {at_most(content.path.widest_radius, units)}"


def wrapped(text: str, width: int) -> list[str]:
    """Lines of whole words, of at most ``width`` characters if every word fits."""
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)


def _rows(content: Content, left: float) -> Iterator[tuple[_Mark, str]]:
    units, found = content.scene.units, content.found

    def bar(colour: Colour, width: float, **further: Any) -> _Mark:
        ends = ((left + 2.0, 0.0), (left + 30.0, 0.0))
        return lambda y: [Strokes((np.add(ends, (0.0, y)),), colour, width, **further)]

    def discs(*marks: tuple[float, float, dict[str, Any]]) -> _Mark:
        return lambda y: [DiscShape(left + x, y, radius, **how) for x, radius, how in marks]

    def both(one: _Mark, other: _Mark) -> _Mark:
        return lambda y: [*one(y), *other(y)]

    count = len(content.scene.objects)
    numbers = ", numbered from 0" if 1 < count <= MOST_BESIDE else ""
    yield (
        lambda y: [Area((_box(left + 2.0, y - 7.0, left + 30.0, y + 7.0),), OBSTACLE)],
        f"obstacles ({count}){numbers}",
    )
    for kind, words in zone_kinds(content.zones):
        yield partial(zone_mark, kind, left), words
    if found:
        mark = both(bar(PATH, 13.0, opacity=0.14), bar(PATH, 3.5))
        yield mark, f"path, {sized(found.length, units)}" + _cost(found, units)
        if found.alternatives:
            mark = bar(OTHER_PATH, 2.5, dash=(8.0, 5.0))
            yield mark, f"alternatives ({len(found.alternatives)})"
    before = [line for line in content.earlier if len(line) > 1]
    if before:
        length = sum(arc_lengths(line)[-1] for line in before)
        yield bar(OTHER_PATH, 3.5), f"replaced plans ({len(before)}), {sized(length, units)}"
    if content.trajectory:
        told = f"({len(content.trajectory.waypoints)}), {content.trajectory.duration_s:.3g} s"
        dot = {"fill": PAGE, "stroke": PATH, "width": 1.3}
        yield discs(*((x, 2.6, dot) for x in (4, 16, 28))), f"waypoints {told}"
    if driven_lines := lines_of(content.track):
        driven = sum(arc_lengths(line)[-1] for line in driven_lines)
        yield bar(TRACK, 2.0), f"driven track, {sized(driven, units)}"
    for number, one in enumerate(content.driven):
        length = sum(arc_lengths(line[:, :2])[-1] for line in lines_of(one.track))
        yield bar(colour_of(number), 2.5), f"{number + 1} {one.name}, {sized(length, units)}"
    if any(len(one.plan) > 1 for one in content.driven):
        yield bar(INK, PLAN_WIDTH, dash=PLAN_DASH), "what was planned last"
    if any(one.goals for one in content.driven):
        yield discs((16.0, 7.0, {"stroke": INK, "width": 1.5})), "where each was to go"
    seen = [other for other in content.others if len(other.track)]
    if seen:
        robot = discs(
            (22.0, 8.0, {"fill": OTHER_ROBOT, "opacity": 0.22}),
            (22.0, 8.0, {"stroke": OTHER_ROBOT, "width": 2.0}),
        )
        words = f"other robots ({len(seen)}), as seen last"
        yield both(bar(OTHER_ROBOT, 2.0), robot), words
    gap = content.bottleneck()
    if gap is not None:
        ring = (16.0, 8.0, {"stroke": BOTTLENECK, "width": 2.0})
        mark = discs(ring, (16.0, 2.4, {"fill": BOTTLENECK}))
        yield mark, f"bottleneck, {sized(gap[2], units)} wide"


def _cost(path: Path, units: str) -> str:
    return "" if path.cost is None else f", cost {sized(path.cost, units)}"


def _ramp(content: Content, left: float, top: float) -> Iterator[Shape]:
    span = content.clearance_span()
    if span is None:
        return
    yield Label(left, top + 14.0, f"roadmap, clearance in {content.scene.units}", 13.0)
    width = 200.0 / RAMP_STEPS
    for step in range(RAMP_STEPS):
        x0 = left + 2.0 + step * width
        box = _box(x0, top + 24.0, x0 + width + 0.5, top + 34.0)
        yield Area((box,), ramp_colour(step))
    middle = 0.5 * (span[0] + span[1])
    ends = ((0.0, span[0], "start"), (0.5, middle, "middle"), (1, span[1], "end"))
    for part, value, anchor in ends:
        x = left + 2.0 + 200.0 * part
        yield Label(x, top + 49.0, f"{value:.3g}", 12.0, FAINT_INK, anchor)


def _box(x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def scale_bar(screen: Screen, units: str, left: float, bottom: float) -> Iterator[Shape]:
    """Draw a bar of a round length, about 120 pixels long."""
    wanted = 120.0 / screen.scale
    power = 10.0 ** math.floor(math.log10(wanted))
    length = power * max(m for m in (1.0, 2.0, 5.0) if m * power <= wanted)
    pixels = length * screen.scale
    x, y = left + 2.0, bottom - 4.0
    bar = np.array([(x, y - 5.0), (x, y), (x + pixels, y), (x + pixels, y - 5.0)])
    yield Strokes((bar,), INK, 1.5)
    yield Label(x + 0.5 * pixels, y - 8.0, f"{length:g} {units}", 12.0, INK, "middle")
