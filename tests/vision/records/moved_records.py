"""Records beside the truth: which outline is whose, and how far corners, edges and arcs are off."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from planner.scene import (
    Arc,
    CircleRecord,
    Edge,
    PolygonRecord,
    Record,
    Scene,
    Segment,
)
from tests.support.drawn.render import outline_points
from tests.vision.records.moved_shapes import Outline, Thing, Vec

FALSE_SHARE = 0.01
"""False corners to true ones that the issue allows."""
CRISP_PX = 0.05
"""The accuracy that the issue asks of pictures without noise."""
ROUND_PX = 0.1
"""Root mean square of what circles and arcs may miss, at any noise."""
NEAR_PX = 1.5
"""How near to a corner one must be found, be there false ones or not."""


# --- comparing records with the truth


@dataclass
class Errors:
    """Distances from the truth in pixels: of corners (with their angles in radians), of where
    lines run into arcs without one, of centres and of radii.
    """

    corners: list[tuple[float, float]] = field(default_factory=list)
    joints: list[float] = field(default_factory=list)
    centers: list[float] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)

    def usual(self) -> list[float]:
        """Of corners of 60 to 120 degrees, as the figures were taken."""
        degrees = [(e, math.degrees(angle)) for e, angle in self.corners]
        return [e for e, angle in degrees if 59.99 <= angle <= 120.01]

    def most(self) -> float:
        """The largest of all; a joint's only across its edges, along them it may lie anywhere."""
        alone = [e for e, _ in self.corners]
        return max([*alone, *self.joints, *self.centers, *self.radii])

    def check_crisp(self) -> None:
        """None beyond ``CRISP_PX``; of sharp and blunt corners the root mean square."""
        assert max([*self.usual(), *self.joints, *self.centers, *self.radii]) <= CRISP_PX
        assert rms([e for e, _ in self.corners]) <= CRISP_PX


def rms(values: Sequence[float]) -> float:
    return math.sqrt(np.mean(np.square(values)))


def kinds(edges: Sequence[Edge]) -> list[str]:
    return [("ccw" if e.ccw else "cw") if isinstance(e, Arc) else "line" for e in edges]


def said(record: Record) -> str:
    return repr(kinds(record.edges) if isinstance(record, PolygonRecord) else record)


def turns(found: Record, true: Outline) -> list[tuple[Edge, ...]]:
    """The found edges from every edge on from which their kinds are the true ones."""
    if not isinstance(found, PolygonRecord) or not isinstance(true, PolygonRecord):
        return []
    every = [(*found.edges[i:], *found.edges[:i]) for i in range(len(found.edges))]
    return [t for t in every if kinds(t) == kinds(true.edges)]


def of_kind(found: Record, true: Outline) -> bool:
    if isinstance(true, CircleRecord):
        return isinstance(found, CircleRecord)
    return bool(turns(found, true))


def none_missed(found: Record, true: Outline) -> bool:
    """Whether every true corner lies near a found one."""
    if not isinstance(found, PolygonRecord) or not isinstance(true, PolygonRecord):
        return False
    ends = np.array([e.start for e in found.edges])
    return all(np.hypot(*(ends - e.start).T).min() < NEAR_PX for e in true.edges)


def from_edge(edge: Edge, at: Vec) -> float:
    """How far a point lies from the line or circle that an edge is part of."""
    if isinstance(edge, Arc):
        return abs(math.dist(at, edge.center) - edge.radius)
    along = np.subtract(edge.end, edge.start) / edge.length
    off = np.subtract(at, edge.start)
    return abs(float(along[0] * off[1] - along[1] * off[0]))


def heading(edge: Edge, at: Vec) -> float:
    """The way an edge runs at one of its ends, radians."""
    if isinstance(edge, Segment):
        return math.atan2(edge.end[1] - edge.start[1], edge.end[0] - edge.start[0])
    x, y = np.subtract(at, edge.center)
    return math.atan2(y, x) + (-0.5 if edge.ccw else 0.5) * math.pi


def add_errors(errors: Errors, found: Record, true: Outline) -> None:
    """Measure a border of the right kind, edge by edge."""
    if isinstance(true, CircleRecord):
        assert isinstance(found, CircleRecord)
        errors.centers.append(math.dist(found.center, true.center))
        errors.radii.append(abs(found.radius - true.radius))
        return
    pairs = [list(zip(t, true.edges, strict=True)) for t in turns(found, true)]
    best = min(pairs, key=lambda p: sum(math.dist(f.start, e.start) ** 2 for f, e in p))
    for i, (f, e) in enumerate(best):
        before = true.edges[i - 1]
        bend = heading(e, e.start) - heading(before, e.start)
        bend = abs((bend + math.pi) % math.tau - math.pi)
        if bend < 0.01:
            errors.joints.append(max(from_edge(e, f.start), from_edge(before, f.start)))
        else:
            errors.corners.append((math.dist(f.start, e.start), math.pi - bend))
        if isinstance(f, Arc) and isinstance(e, Arc):
            errors.centers.append(math.dist(f.center, e.center))
            errors.radii.append(abs(f.radius - e.radius))


def middle(outline: Record) -> Vec:
    """The middle of an outline's box, roughly; of a circle its centre."""
    if isinstance(outline, CircleRecord):
        return outline.center
    assert isinstance(outline, PolygonRecord)
    points = outline_points(outline, 0.1)
    x, y = (0.5 * (points.min(axis=0) + points.max(axis=0))).tolist()
    return x, y


def borders(scene: Scene, things: Sequence[Thing]) -> list[tuple[Record, Outline]]:
    """Found and true outlines and holes in pairs; fails where they are not equally many."""
    assert len(scene.objects) == len(things)
    pairs: list[tuple[Record, Outline]] = []
    for thing in things:
        at = middle(thing.outline)
        near = [o for o in scene.objects if math.dist(middle(o.records[0]), at) < 5.0]
        assert len(near) == 1
        (outline,), holes = near[0].records, near[0].holes
        assert len(holes) == len(thing.holes)
        pairs += [(outline, thing.outline)]
        pairs += [(found, true) for (found,), true in zip(holes, thing.holes, strict=True)]
    return pairs


def as_things(scene: Scene) -> list[Thing]:
    """What was found, as a truth for others."""
    things = []
    for o in scene.objects:
        outline, *holes = (o.records[0], *(h[0] for h in o.holes))
        assert isinstance(outline, PolygonRecord | CircleRecord)
        held = [h for h in holes if isinstance(h, PolygonRecord | CircleRecord)]
        assert len(held) == len(holes)
        things.append(Thing(outline, tuple(held)))
    return things


def assert_follows(scene: Scene, things: Sequence[Thing], within_px: float) -> None:
    """Every border is of the true one's kinds of edges, and nowhere farther from it."""
    errors = Errors()
    for found, true in borders(scene, things):
        assert of_kind(found, true), f"{said(found)} instead of {said(true)}"
        add_errors(errors, found, true)
    assert errors.most() <= within_px


@dataclass
class Survey:
    """What many scenes came to: errors where kinds are right, and the borders where not."""

    errors: Errors = field(default_factory=Errors)
    wrong: list[str] = field(default_factory=list)

    def look(self, scene: Scene, things: Sequence[Thing], seed: int) -> None:
        """Add a scene; fails where objects or holes are miscounted or a corner is missed."""
        for found, true in borders(scene, things):
            if of_kind(found, true):
                add_errors(self.errors, found, true)
            else:
                self.wrong.append(f"seed {seed}: {said(found)} instead of {said(true)}")
                assert none_missed(found, true), self.wrong[-1]

    def check_kinds(self) -> None:
        """No more borders with a false edge than the share of corners that may be false."""
        corners = len(self.errors.corners)
        assert len(self.wrong) <= FALSE_SHARE * corners, self.wrong
