"""Small obstacles that a caller asks to leave out: which, how many, and the largest of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

from planner.formats.grid_maps import GridPose, grid_scene, map_scene
from planner.formats.scene_text import read_scene_text
from planner.scene import (
    Arc,
    ArcRecord,
    Bounds,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Scene,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
)
from planner.scene.specks import size_of

BOUNDS = Bounds(-100.0, -100.0, 100.0, 100.0)
EIGHT = np.ones((3, 3))


def scene_with(units: str, *records: object) -> Scene:
    return Scene(units, BOUNDS, tuple(SceneObject(i, (r,)) for i, r in enumerate(records)))


def filled_areas(cells: np.ndarray) -> list[int]:
    """By scipy: what each 8-connected obstacle covers, with what it encloses."""
    labels, count = ndimage.label(cells, structure=EIGHT)
    return [int(ndimage.binary_fill_holes(labels == i).sum()) for i in range(1, count + 1)]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("resolution", [None, 0.05])
def test_what_stays_are_the_components_of_so_many_cells(
    seed: int, resolution: float | None
) -> None:
    rng = np.random.default_rng(seed)
    cells = rng.random((24, 31)) < rng.uniform(0.05, 0.5)
    least = int(rng.integers(1, 9))
    areas = filled_areas(cells)
    if resolution is None:
        scene, cell = grid_scene(cells), 1.0
    else:
        scene = map_scene(cells, GridPose(resolution, -1.0, 2.0, 0.0))
        cell = resolution**2
    # half a cell less, so that rounding decides nothing
    kept = scene.without_specks((least - 0.5) * cell)
    assert len(scene.objects) == len(areas)
    found = sorted(size_of(o, kept.units, y_down=kept.y_down) / cell for o in kept.objects)
    assert found == pytest.approx(sorted(a for a in areas if a >= least))
    assert [o for o in scene.objects if o in kept.objects] == list(kept.objects)
    small = [a for a in areas if a < least]
    sentence = kept.remarks[-1]
    if not small:
        assert sentence.startswith("no obstacle is smaller than ")
        return
    assert sentence.startswith(
        f"left out {len(small)} obstacle{'s' if len(small) > 1 else ''} smaller than "
    )
    if resolution is None:
        assert f"the largest of {max(small)} cells at (" in sentence


def test_the_rest_of_a_scene_stays_as_it_is() -> None:
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 50 50\n#@ size 50 50\n"
        '#@ remark "turned"\nP (3,4)\nC (20,20) 5\nL 4 (30,30) (40,30) (40,40) (30,40)\n'
    )
    kept = scene.without_specks(2.0)
    assert kept.objects == scene.objects[1:]
    assert (kept.bounds, kept.size, kept.units) == (scene.bounds, scene.size, "px")
    assert kept.remarks == (
        "turned",
        "left out 1 obstacle smaller than 2 square px, the largest of 1 square px at (3, 4): paths "
        "may cross them",
    )
    assert scene.without_specks(1.0).objects == scene.objects


@pytest.mark.parametrize("y_down", [True, False])
def test_arcs_count_with_what_they_bulge(y_down: bool) -> None:
    # a square of side 2 with a half disc on one side, bulging out or in
    for ccw, bulge in ((False, 1.0), (True, -1.0)):
        edges = (
            Segment((0.0, 0.0), (2.0, 0.0)),
            Arc((2.0, 0.0), (2.0, 2.0), (2.0, 1.0), 1.0, ccw=ccw == y_down),
            Segment((2.0, 2.0), (0.0, 2.0)),
            Segment((0.0, 2.0), (0.0, 0.0)),
        )
        one = SceneObject(0, (PolygonRecord(edges),))
        size = size_of(one, "px" if y_down else "m", y_down=y_down)
        assert size == pytest.approx(4.0 + bulge * math.pi / 2.0)


def test_a_hole_counts_with_the_wall_around_it() -> None:
    ring = SceneObject(0, (CircleRecord((0.0, 0.0), 10.0),), ((CircleRecord((0.0, 0.0), 9.9),),))
    scene = Scene("m", BOUNDS, (ring,))
    assert scene.without_specks(300.0).objects == (ring,)
    assert scene.without_specks(320.0).objects == ()


def test_a_thin_wall_in_metres_stays_whatever_is_asked() -> None:
    walls = (
        SegmentRecord((0.0, 0.0), (0.01, 0.0)),
        ArcRecord((Segment((0.0, 5.0), (3.0, 5.0)), Segment((3.0, 5.0), (3.0, 7.0)))),
        PolygonRecord((Segment((0.0, 9.0), (3.0, 9.0)), Segment((3.0, 9.0), (0.0, 9.0)))),
    )
    assert len(scene_with("m", *walls).without_specks(1e9).objects) == 3
    assert scene_with("m", PointRecord((1.0, 1.0))).without_specks(1e-9).objects == ()


def test_a_line_of_a_picture_is_one_pixel_wide() -> None:
    lines = (
        SegmentRecord((0.0, 0.0), (2.0, 0.0)),  # three pixels
        ArcRecord((Segment((0.0, 5.0), (30.0, 5.0)), Segment((30.0, 5.0), (30.0, 45.0)))),
        PolygonRecord((Segment((0.0, 9.0), (7.0, 9.0)), Segment((7.0, 9.0), (0.0, 9.0)))),
    )
    scene = scene_with("px", *lines)
    sizes = [size_of(o, "px", y_down=True) for o in scene.objects]
    assert sizes == pytest.approx([3.0, 71.0, 8.0])
    assert [o.id for o in scene.without_specks(4.0).objects] == [1, 2]


def test_a_scene_without_obstacles_says_so() -> None:
    scene = scene_with("cells").without_specks(3.0)
    assert scene.remarks == ("no obstacle is smaller than 3 cells: none was left out",)


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, math.inf])
def test_no_other_number_is_an_area(wrong: float) -> None:
    with pytest.raises(SceneError, match=r"least_area = .*: must be > 0 and finite"):
        scene_with("px").without_specks(wrong)


@pytest.mark.parametrize("wrong", [None, "3", [3.0], (1, 2)])
def test_nothing_but_a_number_is_an_area(wrong: object) -> None:
    with pytest.raises(TypeError, match=r"least_area = .*: must be a number"):
        scene_with("px").without_specks(wrong)
