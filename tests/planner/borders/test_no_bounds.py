"""Borders without bounds: the free space is a generous rectangle around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import planner
from planner.borders.generators import gather_borders
from planner.path import Path
from planner.scene import CircleRecord, PointRecord, Primitives, Record, SegmentRecord
from tests.support.scenes.planner_scenes import bay, scene_of


@dataclass(frozen=True)
class Unbounded:
    """Borders alone, without walls."""

    records: tuple[Record, ...]

    def primitives(self) -> Primitives:
        return scene_of(*self.records).primitives(include_bounds=False)


CIRCLE = CircleRecord((10.0, 20.0), 5.0)
SEGMENT = SegmentRecord((0.0, 0.0), (40.0, 30.0))


@pytest.mark.parametrize(
    ("records", "low", "high"),
    [
        ((CIRCLE,), (5.0, 15.0), (15.0, 25.0)),
        ((SEGMENT,), (0.0, 0.0), (40.0, 30.0)),
        ((PointRecord((3.0, 4.0)), CIRCLE), (3.0, 4.0), (15.0, 25.0)),
        ((bay(70, 60, 35, 0.9, 6),), (29.0, 19.0), (111.0, 101.0)),
    ],
)
def test_box_lies_around_every_border_and_a_diagonal_more(
    records: tuple[Record, ...], low: tuple[float, float], high: tuple[float, float]
) -> None:
    box = gather_borders(Unbounded(records)).box
    grow = np.hypot(high[0] - low[0], high[1] - low[1])
    assert box == pytest.approx([low[0] - grow, low[1] - grow, high[0] + grow, high[1] + grow])


def test_the_way_round_the_outermost_obstacle_is_free() -> None:
    posts = Unbounded((CIRCLE, CircleRecord((60.0, 20.0), 5.0)))
    roadmap = planner.build_roadmap(posts, 2.0)
    path = roadmap.plan((10.0, 28.0), (10.0, 12.0), prefer="length")
    assert isinstance(path, Path)
    assert path.points[:, 0].min() < 5.0
    assert "outside the bounds" in roadmap.plan((10.0, 28.0), (1e4, 12.0)).reason


def test_nothing_at_all_is_refused() -> None:
    with pytest.raises(ValueError, match="neither objects nor bounds"):
        gather_borders(Unbounded(()))
