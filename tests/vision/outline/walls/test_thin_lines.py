"""Lines one pixel wide, spurs, and objects that touch a corner or the picture's edge."""

from __future__ import annotations

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

from planner.scene import Arc, ArcRecord, PolygonRecord, SegmentRecord
from vision import extract


def white(width: int = 120, height: int = 120) -> np.ndarray:
    return np.full((height, width), 255, np.uint8)


def only_record(picture: np.ndarray) -> object:
    (only,) = extract(picture).objects
    (record,) = only.records
    assert only.holes == ()
    return record


@pytest.mark.parametrize(("begin", "end"), [(20, 160), (200, 350), (95, 100 + 75)])
def test_a_thin_arc_is_a_record_a_with_its_circle(begin: int, end: int) -> None:
    picture = white()
    angles = np.radians(np.linspace(begin, end, 2000))
    xs = np.rint(60.0 + 40.0 * np.cos(angles)).astype(int)
    ys = np.rint(60.0 + 40.0 * np.sin(angles)).astype(int)
    picture[ys, xs] = 0
    record = only_record(picture)
    assert isinstance(record, ArcRecord)
    (arc,) = record.edges
    assert isinstance(arc, Arc)
    assert math.dist(arc.center, (60.0, 60.0)) < 0.5
    assert abs(arc.radius - 40.0) < 0.5
    # halfway along the arc lies a drawn pixel, so that it turns the right way
    first, sweep = arc.sweep(y_down=True)
    assert abs(abs(math.degrees(sweep)) - (end - begin)) < 4.0
    middle = first + 0.5 * sweep
    x = round(arc.center[0] + arc.radius * math.cos(middle))
    y = round(arc.center[1] + arc.radius * math.sin(middle))
    assert (picture[y - 1 : y + 2, x - 1 : x + 2] == 0).any()


def test_a_thin_bent_line_is_an_open_chain_of_segments() -> None:
    picture = white()
    cv2.polylines(picture, [np.array([(20, 20), (90, 40), (60, 100)])], False, 0, 1)
    record = only_record(picture)
    assert isinstance(record, ArcRecord)
    assert record.edges[0].start == (20.0, 20.0)
    assert record.edges[-1].end == (60.0, 100.0)
    gaps = [math.dist(e.start, (90.0, 40.0)) for e in record.edges]
    assert min(gaps) <= 1.5
    assert all(a.end == b.start for a, b in pairwise(record.edges))


def test_a_thin_slanted_line_is_still_a_segment() -> None:
    picture = white()
    cv2.line(picture, (20, 30), (100, 61), 0, 1)
    assert isinstance(only_record(picture), SegmentRecord)


def test_a_thin_ring_is_an_outline_and_a_hole() -> None:
    picture = white()
    cv2.circle(picture, (60, 60), 30, 0, 1)
    (ring,) = extract(picture).objects
    assert len(ring.holes) == 1


def test_a_fork_is_a_polygon_around_its_pixels() -> None:
    picture = white()
    picture[60, 20:100] = 0
    picture[20:60, 60] = 0
    assert isinstance(only_record(picture), PolygonRecord)


def test_a_spur_stays_on_its_object() -> None:
    picture = white()
    picture[40:80, 40:80] = 0
    picture[60, 80:95] = 0
    record = only_record(picture)
    assert isinstance(record, PolygonRecord)
    reach = max(edge.start[0] for edge in record.edges)
    assert abs(reach - 94.5) <= 1.0


def test_squares_that_touch_at_a_corner_are_one_object() -> None:
    picture = white()
    picture[20:50, 20:50] = 0
    picture[50:80, 50:80] = 0
    assert len(extract(picture).objects) == 1


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_an_object_at_the_pictures_edge_ends_there(turns: int) -> None:
    picture = white(120, 90)
    picture[30:60, :25] = 0
    picture = np.ascontiguousarray(np.rot90(picture, turns))
    record = only_record(picture)
    corners = np.array([edge.start for edge in record.edges])
    width, height = corners.max(axis=0) - corners.min(axis=0)
    assert len(corners) == 4
    assert np.allclose(sorted((width, height)), (25.0, 30.0), atol=0.1)
    low = np.minimum(corners.min(axis=0) + 0.5, picture.shape[1::-1] - corners.max(axis=0) - 0.5)
    assert abs(low.min()) < 0.1
