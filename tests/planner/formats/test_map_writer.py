"""ROS maps out: no obstacle gets smaller, and a map read and written is the same map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from planner.formats.map_writer import occupied_cells, write_map
from planner.formats.pgm import parse_pgm
from planner.formats.scene_io import load_scene
from planner.scene import (
    Bounds,
    CircleRecord,
    PointRecord,
    Scene,
    SceneError,
    SceneObject,
    SegmentRecord,
)
from tests.support.scenes.planner_scenes import (
    box,
    random_scene,
    slow_distance,
    slow_inside,
    with_hole,
)

METRES = Bounds(-1.0, 2.0, 3.0, 5.0)


def scene_in_metres(*objects: SceneObject) -> Scene:
    return Scene("m", METRES, objects)


def centres(scene: Scene, shape: tuple[int, int], resolution: float) -> np.ndarray:
    ys, xs = np.mgrid[: shape[0], : shape[1]] + 0.5
    origin = (scene.bounds.x_min, scene.bounds.y_min)
    return np.c_[xs.ravel(), ys.ravel()] * resolution + origin


@pytest.mark.parametrize("seed", range(15))
def test_cells_are_occupied_where_an_obstacle_reaches_into_them(seed: int) -> None:
    drawn = random_scene(np.random.default_rng(seed))
    scene = Scene("m", Bounds(0.0, 0.0, 160.0, 120.0), drawn.objects)
    cells = occupied_cells(scene, 1.0)
    at = centres(scene, cells.shape, 1.0)
    far = slow_distance(Scene("m", Bounds(-999, -999, 999, 999), scene.objects), at)
    inside = slow_inside(scene, at)
    must = (inside & (far > 1e-3)) | (far < 0.5 - 0.02)
    may = inside | (far < np.sqrt(0.5) + 0.02)
    assert cells.ravel()[must].all()
    assert not cells.ravel()[~may].any()


def test_an_obstacle_on_the_grid_takes_its_own_cells_only(tmp_path: Path) -> None:
    scene = scene_in_metres(SceneObject(0, (box(0.0, 3.0, 1.0, 4.0),)))
    cells = occupied_cells(scene, 0.25)
    assert cells.shape == (12, 16)
    assert cells.sum() == 16
    assert cells[4:8, 4:8].all()
    write_map(scene, tmp_path / "map.yaml", 0.25)
    back = load_scene(tmp_path / "map.yaml")
    assert back.bounds == METRES
    (obj,) = back.objects
    corners = {edge.start for edge in obj.records[0].edges}
    assert corners == {(0.0, 3.0), (1.0, 3.0), (1.0, 4.0), (0.0, 4.0)}


def test_a_hole_stays_free_and_points_and_lines_take_their_cells() -> None:
    ring = with_hole(box(0.0, 2.5, 2.5, 4.5), box(0.5, 3.0, 2.0, 4.0))
    point = SceneObject(1, (PointRecord((-0.6, 2.1)),))
    line = SceneObject(2, (SegmentRecord((-0.9, 4.9), (-0.1, 4.9)),))
    cells = occupied_cells(scene_in_metres(ring, point, line), 0.25)
    assert not cells[4:8, 6:12].any()
    assert cells[0, 1]
    assert cells[11, :4].tolist() == [True] * 4
    assert cells.sum() == 10 * 8 - 6 * 4 + 1 + 4


def test_bounds_that_cut_a_cell_occupy_it() -> None:
    cells = occupied_cells(scene_in_metres(), 0.7)
    assert cells.shape == (5, 6)
    assert cells[:, 5].all()
    assert cells[4].all()
    assert not cells[:4, :5].any()


def test_the_header_is_what_map_server_reads(tmp_path: Path) -> None:
    write_map(scene_in_metres(SceneObject(0, (CircleRecord((1.0, 3.5), 0.5),))),
              tmp_path / "arena.yaml", 0.05)  # fmt: skip
    header = yaml.safe_load((tmp_path / "arena.yaml").read_text())
    assert header["image"] == "arena.pgm"
    assert header["resolution"] == 0.05
    assert header["origin"] == [-1.0, 2.0, 0.0]
    assert header["negate"] == 0
    assert header["free_thresh"] < header["occupied_thresh"]
    shades = parse_pgm((tmp_path / "arena.pgm").read_bytes(), "arena.pgm")
    assert shades.shape == (60, 80)
    assert shades[30, 40] == 0.0
    assert shades[0, 0] > 0.99


@pytest.mark.parametrize("name", ["tb3_sandbox.yaml", "depot.yaml"])
def test_a_real_map_read_and_written_is_the_same_map(
    real_data: Path, tmp_path: Path, name: str
) -> None:
    scene = load_scene(real_data / "maps" / name)
    resolution = yaml.safe_load((real_data / "maps" / name).read_text())["resolution"]
    write_map(scene, tmp_path / "again.yaml", resolution)
    again = load_scene(tmp_path / "again.yaml")
    assert len(again.objects) == len(scene.objects)
    for a, b in zip(scene.objects, again.objects, strict=True):
        ours = sorted(e.start for r in a.records for e in r.edges)
        theirs = sorted(e.start for r in b.records for e in r.edges)
        np.testing.assert_allclose(theirs, ours, atol=1e-9)


@pytest.mark.parametrize(
    ("units", "resolution", "words"),
    [("px", 1.0, "metres"), ("m", 0.0, "> 0"), ("m", float("nan"), "> 0"), ("m", 1e-6, "limit")],
)
def test_what_is_no_ros_map_is_refused(units: str, resolution: float, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        occupied_cells(Scene(units, METRES, ()), resolution)


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="nowhere"):
        write_map(scene_in_metres(), tmp_path / "nowhere" / "map.yaml", 0.5)
