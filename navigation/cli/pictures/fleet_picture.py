"""The picture of a fleet's plan: an SVG in which each robot moves along its track (SMIL).

The scene below is that of ``navigation.draw``. The film takes the plan's duration, limited to 1 s
to ``FILM_S``; it loops, and holds its end for a moment.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Iterator, Sequence
from xml.sax.saxutils import escape

import numpy as np

from navigation.cli.pictures.fleet_robots import FleetRobot
from navigation.draw.driven import DrawnRobot
from navigation.draw.layers import Content, layers
from navigation.draw.legend import LEGEND_WIDTH
from navigation.draw.picture import LEAST_HEIGHT, MARGIN, PLOT_HEIGHT, PLOT_WIDTH
from navigation.draw.shapes import Drawing, Screen, fit_screen
from navigation.draw.svg import FONT, to_svg
from planner.fleet.fleet_plan import FleetPlan
from planner.scene import FloatArray, Scene
from planner.zones.zone import Zone

FILM_S = 12.0
HOLD = 0.1
"""Share of the film in which all stand at their goals."""
ROW = 22.0


def draw_fleet(
    scene: Scene, robots: Sequence[FleetRobot], plan: FleetPlan, zones: Sequence[Zone] = ()
) -> str:
    """The picture as SVG text."""
    content = Content(scene, None, None, None, None, None, (), (), (), (), "Fleet", tuple(zones))
    window = content.window()
    screen = fit_screen(window, scene.y_down, PLOT_WIDTH, PLOT_HEIGHT, MARGIN, MARGIN)
    width, height = screen.scale * window.width, screen.scale * window.height
    page_height = round(max(height, LEAST_HEIGHT, ROW * (len(robots) + 4)) + 2 * MARGIN)
    drawing = Drawing(
        width=round(3 * MARGIN + width + LEGEND_WIDTH),
        height=page_height,
        view=(MARGIN, MARGIN, MARGIN + width, MARGIN + height),
        layers=layers(content, screen),
        title="Fleet",
    )
    below = to_svg(drawing).rstrip().removesuffix("</svg>")
    film_s = min(max(plan.makespan_s, 1.0), FILM_S) / (1.0 - HOLD)
    lines = [below.rstrip(), *_legend(robots, plan, 2 * MARGIN + width, film_s)]
    tracks = [_on_screen(track, screen) for track in plan.tracks]
    lines += [_way(i, track, len(robots)) for i, track in enumerate(tracks)]
    for i, (robot, track) in enumerate(zip(robots, tracks, strict=True)):
        radius = robot.radius * screen.scale
        lines.append(_disc(i, robot, track, radius, len(robots), plan.makespan_s, film_s))
    return "\n".join([*lines, "</svg>"]) + "\n"


def drawn_robots(robots: Sequence[FleetRobot], plan: FleetPlan) -> tuple[DrawnRobot, ...]:
    """The robots at their goals with their paths, for a still picture."""
    return tuple(
        DrawnRobot(robot.name, robot.radius, _with_headings(track), [robot.goal])
        for robot, track in zip(robots, plan.tracks, strict=True)
    )


def _with_headings(track: FloatArray) -> FloatArray:
    """Rows x, y, heading_rad of a track; a robot keeps the heading it drove last."""
    steps = np.diff(track[:, 1:], axis=0)
    headings_rad = np.zeros(len(track))
    last_rad = 0.0
    for k, (dx, dy) in enumerate(steps.tolist(), start=1):
        last_rad = math.atan2(dy, dx) if (dx, dy) != (0.0, 0.0) else last_rad
        headings_rad[k] = last_rad
    return np.column_stack([track[:, 1:], headings_rad])


def _on_screen(track: FloatArray, screen: Screen) -> list[tuple[float, float, float]]:
    places = screen.points(track[:, 1:])
    return [(t, x, y) for t, (x, y) in zip(track[:, 0].tolist(), places.tolist(), strict=True)]


def colour_of(i: int, count: int) -> str:
    """Colour of a robot: hues as far apart as possible, two shades in turn."""
    value = (0.75, 0.55)[i % 2]
    r, g, b = colorsys.hsv_to_rgb(i / max(count, 1), 0.85, value)
    return f"#{round(255 * r):02x}{round(255 * g):02x}{round(255 * b):02x}"


def _way(i: int, track: list[tuple[float, float, float]], count: int) -> str:
    colour = colour_of(i, count)
    points = " ".join(f"{x:.1f},{y:.1f}" for _, x, y in track)
    gx, gy = track[-1][1:]
    return (
        f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"'
        f' opacity="0.5"/><path d="M{gx - 5:.1f},{gy - 5:.1f}l10,10m0,-10l-10,10"'
        f' stroke="{colour}" stroke-width="2.5" fill="none"/>'
    )


def _disc(
    i: int,
    robot: FleetRobot,
    track: list[tuple[float, float, float]],
    radius: float,
    count: int,
    makespan_s: float,
    film_s: float,
) -> str:
    colour = colour_of(i, count)
    _, x, y = track[0]
    ring = (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="none" stroke="{colour}"'
        ' stroke-dasharray="3 3" opacity="0.6"/>'
    )
    label = (
        f'<text y="{min(radius, 6.0) * 0.75:.1f}" font-size="{min(max(radius, 9.0), 14.0):.1f}"'
        f' text-anchor="middle" fill="#fff" font-weight="600">{i + 1}</text>'
    )
    return (
        f'{ring}<g transform="translate({x:.1f},{y:.1f})"><title>{escape(robot.name)}</title>'
        f'<circle r="{radius:.2f}" fill="{colour}" fill-opacity="0.85" stroke="#fff"/>{label}'
        f"{_animation(track, makespan_s, film_s)}</g>"
    )


def _animation(track: list[tuple[float, float, float]], makespan_s: float, film_s: float) -> str:
    if len(track) == 1 or makespan_s <= 0.0:
        return ""
    shares = [t / makespan_s * (1.0 - HOLD) for t, _, _ in track]
    values = [f"{x:.1f},{y:.1f}" for _, x, y in track]
    times = [f"{share:.5f}" for share in shares]
    times[0] = "0"
    return (
        f'<animateTransform attributeName="transform" type="translate" dur="{film_s:.3f}s"'
        f' repeatCount="indefinite" calcMode="linear" values="{";".join([*values, values[-1]])}"'
        f' keyTimes="{";".join([*times, "1"])}"/>'
    )


def _legend(
    robots: Sequence[FleetRobot], plan: FleetPlan, left: float, film_s: float
) -> Iterator[str]:
    y = MARGIN + 16.0
    faster = plan.makespan_s / (film_s * (1.0 - HOLD))
    yield f'<g id="legend" font-family="{FONT}" fill="#222">'
    yield f'<text x="{left:.1f}" y="{y:.1f}" font-size="18" font-weight="600">Fleet</text>'
    told = f"all there after {plan.makespan_s:.3g} s; film {faster:.2g} x"
    yield f'<text x="{left:.1f}" y="{y + ROW:.1f}" font-size="12">{told}</text>'
    for i, (robot, arrival_s) in enumerate(zip(robots, plan.arrivals_s, strict=True)):
        at = y + ROW * (i + 2.3)
        colour = colour_of(i, len(robots))
        name = escape(f"{i + 1}  {robot.name}, {arrival_s:.3g} s")
        yield (
            f'<circle cx="{left + 7:.1f}" cy="{at - 4:.1f}" r="7" fill="{colour}"/>'
            f'<text x="{left + 22:.1f}" y="{at:.1f}" font-size="13">{name}</text>'
        )
    yield "</g>"
