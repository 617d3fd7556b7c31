"""Records with edges of no length, circles of no radius and repeated vertices."""

from __future__ import annotations

import numpy as np
import pytest

import planner
from planner.borders.generators import Mode
from planner.scene import (
    Arc,
    ArcRecord,
    Bounds,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Record,
    Segment,
    SegmentRecord,
    Vec,
)
from tests.support.scenes.planner_scenes import polygon, scene_of

A, B, C, D = (50.0, 30.0), (60.0, 35.0), (60.0, 35.0), (59.0, 30.0)
BOUNDS = Bounds(0.0, 0.0, 100.0, 80.0)


def ring(*vertices: Vec) -> PolygonRecord:
    """A closed outline through the vertices as they are, repeated ones too."""
    return PolygonRecord(
        tuple(Segment(a, b) for a, b in zip(vertices, vertices[1:] + vertices[:1], strict=True))
    )


def dot(radius: float) -> Arc:
    """A whole circle as an edge."""
    rim = (A[0] + radius, A[1])
    return Arc(rim, rim, A, radius, ccw=True)


SAME = {
    "vertex twice": (ring(A, B, C, D), polygon([A, B, D])),
    "first vertex twice": (ring(A, A, B, D), polygon([A, B, D])),
    "last vertex twice": (ring(A, B, D, D), polygon([A, B, D])),
    "every vertex three times": (ring(A, A, A, B, B, B, D, D, D), polygon([A, B, D])),
    "edge shorter than floats tell": (ring(A, (50.0, 30.0 + 1e-14), B, D), polygon([A, B, D])),
    "one vertex": (ring(A), PointRecord(A)),
    "one vertex thrice": (ring(A, A, A), PointRecord(A)),
    "segment of no length": (SegmentRecord(A, A), PointRecord(A)),
    "circle of no radius": (CircleRecord(A, 0.0), PointRecord(A)),
    "arc of no radius": (ArcRecord((dot(0.0),)), PointRecord(A)),
    "line with its ends twice": (
        ArcRecord((Segment(A, A), Segment(A, B), Segment(B, B))),
        ArcRecord((Segment(A, B),)),
    ),
    "outline with an arc of no radius": (
        PolygonRecord((dot(0.0), Segment(A, B), Segment(B, D), Segment(D, A))),
        polygon([A, B, D]),
    ),
}


@pytest.mark.parametrize("mode", ["exact", "paper"])
@pytest.mark.parametrize("name", list(SAME))
def test_degenerate_records_are_as_if_they_were_written_without(name: str, mode: Mode) -> None:
    one, other = (
        planner.build_roadmap(scene_of(record, bounds=BOUNDS), 3.0, mode=mode)
        for record in SAME[name]
    )
    assert one.counts == other.counts
    assert np.array_equal(one.borders.pieces.solid, other.borders.pieces.solid)
    places = np.random.default_rng(0).uniform((0.0, 0.0), (100.0, 80.0), (200, 2))
    assert one.clearance(places) == pytest.approx(other.clearance(places), abs=1e-9)
    assert isinstance(one.plan((10.0, 10.0), (90.0, 70.0)), planner.Path)


@pytest.mark.parametrize("record", [ArcRecord(()), PolygonRecord(())])
def test_a_record_without_edges_is_no_obstacle(record: Record) -> None:
    roadmap = planner.build_roadmap(scene_of(record, bounds=BOUNDS), 3.0)
    assert roadmap.clearance([(50.0, 30.0)]) == pytest.approx([30.0])


def test_points_apart_in_one_object_all_stay() -> None:
    from planner.scene import SceneObject

    apart = SceneObject(0, (PointRecord(A), PointRecord(D), SegmentRecord(D, B)))
    roadmap = planner.build_roadmap(scene_of(apart, bounds=BOUNDS), 3.0)
    assert roadmap.clearance([A, D, B, (54.5, 30.0)]) == pytest.approx([0.0, 0.0, 0.0, 4.5])


def test_two_objects_that_coincide_have_the_roadmap_of_one() -> None:
    """Of coincident sites the same border stands for both: no chain runs between the two."""
    head = "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
    arc = "A 2 (290,150)(155,227.9423)\n#@ arc 1 200 150 90 ccw\n"
    once = planner.read_scene_text(head + "#@ object 1\n" + arc)
    twice = planner.read_scene_text(head + "#@ object 1\n" + arc + "#@ object 2\n" + arc)
    one, two = (planner.build_roadmap(scene, 16.3) for scene in (once, twice))
    assert len(two.chains) == len(one.chains)
    # the polylines' points may differ, within their tolerance of the bisectors
    assert np.sort(two.chains.length) == pytest.approx(np.sort(one.chains.length), rel=1e-3)
