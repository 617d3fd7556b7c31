"""The robots of a fleet on one graph.

Lengths are in the graph's units, times in seconds; starts and goals are node numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.fleet.motions.interval_search_kernels import HORIZON, MotionGraph, times_to
from planner.scene import FloatArray


@dataclass(frozen=True, slots=True)
class TeamRobot:
    """A robot, its graph with driving times, and the times to its goal alone."""

    graph: MotionGraph
    radius: float
    start: int
    goal: int
    to_goal: FloatArray

    @property
    def alone_s(self) -> float:
        """Time to the goal without others."""
        return float(self.to_goal[self.start])


@dataclass(frozen=True, slots=True)
class Route:
    """A robot's nodes (k,), arrivals (k,), departures (k - 1,), and moves (m, 7).

    It stays at its last node for ever; the moves are rows as in ``interval_search_kernels``, with
    the robot's radius in place of the gap.
    """

    way: NDArray[np.int64]
    arrivals: FloatArray
    departures: FloatArray
    moves: FloatArray

    @property
    def arrival_s(self) -> float:
        """Time of its arrival at the goal."""
        return float(self.arrivals[-1])


def make_graph(
    places: FloatArray,
    edges: NDArray[np.int64],
    speed: float = 1.0,
    factors: FloatArray | None = None,
) -> MotionGraph:
    """Graph of a robot of one speed; ``edges`` (m, 2) from and to, directed.

    ``factors`` (m,) multiply the edges' times.
    """
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    row = edges[order]
    step = places[row[:, 1]] - places[row[:, 0]]
    starts = np.searchsorted(row[:, 0], np.arange(len(places) + 1)).astype(np.int64)
    lasts = np.hypot(step[:, 0], step[:, 1]) / speed
    if factors is not None:
        lasts *= factors[order]
    return MotionGraph(places, starts, np.ascontiguousarray(row[:, 1]), lasts)


def edges_of(graph: MotionGraph) -> NDArray[np.int64]:
    """Edges (m, 2), from and to."""
    row = np.repeat(np.arange(len(graph.places)), np.diff(graph.starts))
    return np.column_stack([row, graph.to]).astype(np.int64)


def make_robot(
    graph: MotionGraph, edges: NDArray[np.int64], radius: float, start: int, goal: int
) -> TeamRobot:
    """Robot with its times to the goal; ``edges`` from :func:`edges_of`."""
    to_goal = times_to(goal, len(graph.places), edges, graph.lasts)
    return TeamRobot(graph, radius, start, goal, to_goal)


def cut_off(robots: Sequence[TeamRobot]) -> list[int]:
    """Robots that cannot reach their goal even alone."""
    return [i for i, robot in enumerate(robots) if robot.alone_s >= HORIZON]
