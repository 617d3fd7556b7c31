"""A fleet's plan as driven robots for a picture; in an SVG each moves along its track."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navigation.cli.pictures.fleet_robots import FleetRobot
from navigation.draw.driven import DrawnRobot
from planner.fleet.fleet_plan import FleetPlan
from planner.scene import FloatArray


def drawn_robots(robots: Sequence[FleetRobot], plan: FleetPlan) -> tuple[DrawnRobot, ...]:
    """The robots at their goals with their paths, and when they are where."""
    return tuple(
        DrawnRobot(
            robot.name, robot.radius, _with_headings(track), [robot.goal], times_s=track[:, 0]
        )
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
