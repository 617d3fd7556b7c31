"""Several driven robots: their goals, plans, tracks and last places.

Each has the page's colour, its number from 1, and its name. Robots with times move in an SVG: the
film takes as long as the last one, limited to 1 s to ``FILM_S``, holds its end and begins again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from navigation.draw.robot_marks import lines_of, name_beside, nose
from navigation.draw.shapes import (
    PAGE,
    ROBOTS,
    Colour,
    DiscShape,
    Motion,
    Screen,
    Shape,
    Strokes,
)
from planner.scene import FloatArray

PLAN_WIDTH: Final = 4.0
PLAN_DASH: Final = (3.0, 5.0)
FILM_S: Final = 12.0
HOLD: Final = 0.1
"""Part of the animation in which all robots stand at their goals, between 0 and 1."""


@dataclass(frozen=True, slots=True)
class DrawnRobot:
    """One of several robots, with its track (n, 3) of x, y, heading_rad; a row of NaN breaks it.

    ``goals`` (x, y) are of its last mission, ``plan`` (n, 2) is its last planned path; ``times_s``
    (n,) are those of the track's rows, for a film.
    """

    name: str
    radius: float
    track: FloatArray
    goals: Sequence[tuple[float, float]]
    plan: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    times_s: FloatArray | None = None


def colour_of(number: int) -> Colour:
    """Colour of a robot by its number from 0."""
    return ROBOTS[number % len(ROBOTS)]


def plan_shapes(robots: Sequence[DrawnRobot], screen: Screen) -> Iterator[Shape]:
    """Draw each last plan dashed."""
    for number, robot in enumerate(robots):
        if len(robot.plan) > 1:
            line = (screen.points(robot.plan),)
            yield Strokes(line, colour_of(number), PLAN_WIDTH, dash=PLAN_DASH)


def driven_shapes(robots: Sequence[DrawnRobot], screen: Screen) -> Iterator[Shape]:
    """Draw all tracks, then all robots over them, and those that move in a film."""
    for number, robot in enumerate(robots):
        lines = tuple(screen.points(line[:, :2]) for line in lines_of(robot.track))
        if lines:
            yield Strokes(lines, PAGE, 5.0)
            yield Strokes(lines, colour_of(number), 2.5)
    for number, robot in enumerate(robots):
        yield from _robot(number, robot, screen)
    last_s = max((float(r.times_s[-1]) for r in robots if r.times_s is not None), default=0.0)
    for number, robot in enumerate(robots):
        if last_s > 0.0 and robot.times_s is not None and len(robot.track) > 1:
            places = screen.points(robot.track[:, :2])
            film_s = min(max(last_s, 1.0), FILM_S) / (1.0 - HOLD)
            motion = Motion(places, robot.times_s / last_s * (1.0 - HOLD), film_s)
            (x, y), size = places[-1].tolist(), robot.radius * screen.scale
            colour = colour_of(number)
            yield DiscShape(x, y, size, colour, PAGE, opacity=0.85, motion=motion)


def _robot(number: int, robot: DrawnRobot, screen: Screen) -> Iterator[Shape]:
    colour, size = colour_of(number), robot.radius * screen.scale
    for x, y in screen.points(np.array(robot.goals).reshape(-1, 2)).tolist():
        yield DiscShape(x, y, 0.6 * size, stroke=colour, width=1.5)
    if not len(robot.track):
        return
    x, y = screen.points(robot.track[-1:, :2])[0].tolist()
    yield DiscShape(x, y, size, fill=colour, opacity=0.25)
    yield DiscShape(x, y, size, stroke=colour, width=2.5)
    yield nose(x, y, size, float(robot.track[-1, 2]), colour, screen)
    words = f"{number + 1} {robot.name}"
    yield name_beside(words, x, y, size, colour, screen, np.empty((0, 2)))
