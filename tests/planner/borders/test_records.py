"""A record of a scene that cannot be is refused where it is made, in one sentence."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from planner.scene import (
    Arc,
    ArcRecord,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    SceneError,
    Segment,
    SegmentRecord,
)

HERE, THERE = (0.0, 0.0), (1.0, 0.0)
SIDE = Segment(HERE, THERE)
NO_NUMBERS = (math.nan, math.inf, -math.inf)
NO_RADII = (*NO_NUMBERS, -1.0, -5e-324)
WITH_A_COORDINATE: dict[str, Callable[[float], object]] = {
    "P": lambda v: PointRecord((v, 0.0)),
    "S": lambda v: SegmentRecord(HERE, (1.0, v)),
    "S start": lambda v: SegmentRecord((v, 1.0), THERE),
    "segment": lambda v: Segment((0.0, v), THERE),
    "segment end": lambda v: Segment(HERE, (v, 0.0)),
    "C": lambda v: CircleRecord((v, v), 1.0),
    "arc start": lambda v: Arc((v, 0.0), THERE, HERE, 1.0, True),
    "arc end": lambda v: Arc(THERE, (0.0, v), HERE, 1.0, True),
    "arc centre": lambda v: Arc(THERE, THERE, (0.0, v), 1.0, True),
    "P residual": lambda v: PointRecord(HERE, v),
    "S residual": lambda v: SegmentRecord(HERE, THERE, v),
    "C residual": lambda v: CircleRecord(HERE, 1.0, v),
    "A residual": lambda v: ArcRecord((SIDE,), v),
    "L residual": lambda v: PolygonRecord((SIDE,), v),
}


@pytest.mark.parametrize("value", NO_NUMBERS)
@pytest.mark.parametrize("name", WITH_A_COORDINATE)
def test_coordinates_that_are_not_finite_are_refused(name: str, value: float) -> None:
    with pytest.raises(SceneError, match=r"must be finite$"):
        WITH_A_COORDINATE[name](value)


@pytest.mark.parametrize("radius", NO_RADII)
def test_radii_below_none_are_refused(radius: float) -> None:
    with pytest.raises(SceneError, match=r"radius of a circle = .*: must be >= 0 and finite$"):
        CircleRecord(HERE, radius)
    with pytest.raises(SceneError, match=r"radius of an arc = .*: must be >= 0 and finite$"):
        Arc(THERE, THERE, HERE, radius, True)


@pytest.mark.parametrize("value", [0.0, -0.0, 5e-324, 1e300, -1e308, 7])
def test_every_finite_coordinate_is_a_coordinate(value: float) -> None:
    assert Segment((value, value), (value, -value)).start == (value, value)
    assert CircleRecord((value, -value), 5e-324).center == (value, -value)
