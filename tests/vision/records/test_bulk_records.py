"""Records made in bulk are those that their constructors make."""

from __future__ import annotations

import dataclasses
import pickle

import pytest

from planner.scene import Arc, PolygonRecord, SceneObject, Segment
from vision.records.bulk_records import new_arcs, new_object, new_polygon, new_segments

STARTS = [(0.0, 1.0), (2.0, 3.0), (4.0, 5.0)]
ENDS = [(2.0, 3.0), (4.0, 5.0), (0.0, 1.0)]
CENTERS = [(6.0, 7.0), (8.0, 9.0), (10.0, 11.0)]
RADII = [1.5, 2.5, 3.5]
CCWS = [True, False, True]


def test_bulk_records_are_those_of_the_constructors() -> None:
    segments = new_segments(STARTS, ENDS)
    arcs = new_arcs(STARTS, ENDS, CENTERS, RADII, CCWS)
    polygon = new_polygon((segments[0], arcs[1]), 0.25)
    assert segments == [Segment(*ends) for ends in zip(STARTS, ENDS, strict=True)]
    assert arcs == [Arc(*five) for five in zip(STARTS, ENDS, CENTERS, RADII, CCWS, strict=True)]
    assert polygon == PolygonRecord((segments[0], arcs[1]), 0.25)
    assert new_object(3, (polygon,), ((polygon,),)) == SceneObject(3, (polygon,), ((polygon,),))


def test_bulk_records_have_every_field_and_are_frozen() -> None:
    segment = new_segments(STARTS[:1], ENDS[:1])[0]
    arc = new_arcs(STARTS[:1], ENDS[:1], CENTERS[:1], RADII[:1], CCWS[:1])[0]
    polygon = new_polygon((segment,), 0.0)
    for record in (segment, arc, polygon, new_object(0, (polygon,), ())):
        assert pickle.loads(pickle.dumps(record)) == record
        getattr(record, "__post_init__", lambda: None)()  # what a constructor checks holds here too
        first = dataclasses.fields(record)[0].name
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(record, first, None)


def test_no_records_in_bulk_are_none() -> None:
    assert new_segments([], []) == []
    assert new_arcs([], [], [], [], []) == []
