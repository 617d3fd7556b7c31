"""Grid maps keep every cell's edge; the oracle is scipy's labelling and winding, cell by cell."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage

import planner
from planner.formats.grid_maps import GridPose, grid_scene, map_scene
from planner.formats.map_files import parse_movingai
from planner.formats.scene_io import load_scene
from planner.scene import PolygonRecord, Scene, SceneError, SceneObject

masks = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=9))


def rings(obj: SceneObject) -> list[list[tuple[float, float]]]:
    found = []
    for border in (obj.records, *obj.holes):
        (record,) = border
        assert isinstance(record, PolygonRecord)
        edges = record.edges
        for edge, after in zip(edges, [*edges[1:], edges[0]], strict=True):
            assert edge.end == after.start
        found.append([edge.start for edge in edges])
    return found


def winding(ring: list[tuple[float, float]], x: float, y: float) -> int:
    """Turns of the ring around a point that is not on it: crossings of the ray to the right."""
    turns = 0
    for (x0, y0), (x1, y1) in zip(ring, [*ring[1:], ring[0]], strict=True):
        if (y0 <= y) != (y1 <= y):
            t = (y - y0) / (y1 - y0)
            if x0 + t * (x1 - x0) > x:
                turns += 1 if y1 > y0 else -1
    return turns


@settings(max_examples=200)
@given(masks)
def test_each_cell_lies_inside_exactly_the_object_it_belongs_to(mask):
    scene = grid_scene(mask)
    labels, count = ndimage.label(mask, structure=np.ones((3, 3)))
    assert len(scene.objects) == count
    label_of = {}
    for obj in scene.objects:
        loops = rings(obj)
        inside = np.zeros(mask.shape, dtype=int)
        for j, i in np.ndindex(mask.shape):
            inside[j, i] = sum(winding(ring, i, j) for ring in loops)
        assert set(np.unique(inside)) <= {0, 1}
        (label,) = set(labels[inside == 1])
        np.testing.assert_array_equal(inside == 1, labels == label)
        label_of[obj.id] = label
    assert len(set(label_of.values())) == count


@settings(max_examples=200)
@given(masks)
def test_holes_are_the_free_regions_that_an_object_encloses(mask):
    scene = grid_scene(mask)
    _, free_regions = ndimage.label(np.pad(~mask, 1, constant_values=True))
    assert sum(len(o.holes) for o in scene.objects) == free_regions - 1


@settings(max_examples=200)
@given(masks)
def test_outlines_run_clockwise_on_the_screen_and_holes_the_other_way(mask):
    for obj in grid_scene(mask).objects:
        for number, ring in enumerate(rings(obj)):
            area = sum(
                a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)
            )
            assert (area > 0) == (number == 0)


@settings(max_examples=200)
@given(masks)
def test_segments_cover_each_border_edge_once_and_are_as_long_as_can_be(mask):
    padded = np.pad(mask, 1).astype(int)
    unit_edges = np.abs(np.diff(padded, axis=0)).sum() + np.abs(np.diff(padded, axis=1)).sum()
    total = 0.0
    for obj in grid_scene(mask).objects:
        for ring in rings(obj):
            steps = [
                (b[0] - a[0], b[1] - a[1]) for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)
            ]
            assert all((dx == 0) != (dy == 0) for dx, dy in steps)
            total += sum(abs(dx) + abs(dy) for dx, dy in steps)
            for (dx, dy), (ex, ey) in zip(steps, [*steps[1:], steps[0]], strict=True):
                assert dx * ex + dy * ey == 0, "two collinear segments in a row"
    assert total == unit_edges


def test_cells_that_touch_at_a_corner_are_one_object_without_a_gap():
    scene = grid_scene(np.array([[1, 0], [0, 1]], dtype=bool))
    (obj,) = scene.objects
    (ring,) = rings(obj)
    assert ring.count((0.5, 0.5)) == 2


def test_a_diagonal_ring_encloses_its_middle():
    mask = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], dtype=bool)
    (obj,) = grid_scene(mask).objects
    assert len(obj.holes) == 1
    assert len(obj.holes[0][0].edges) == 4


def test_an_island_in_a_hole_is_an_object_of_its_own():
    mask = np.ones((7, 7), dtype=bool)
    mask[1:6, 1:6] = False
    mask[3, 3] = True
    outer, island = grid_scene(mask).objects
    assert len(outer.holes) == 1
    assert island.records[0].edges[0].start == (2.5, 2.5)
    assert not island.holes


def test_a_map_in_metres_has_its_origin_at_the_lower_left_corner_and_y_up():
    mask = np.zeros((4, 6), dtype=bool)
    mask[3, 0] = True  # bottom row, leftmost cell
    scene = map_scene(mask, GridPose(0.5, -1.0, 2.0, 0.0))
    assert scene.units == "m"
    assert (scene.bounds.x_min, scene.bounds.y_min) == (-1.0, 2.0)
    assert (scene.bounds.x_max, scene.bounds.y_max) == (2.0, 4.0)
    corners = {edge.start for edge in scene.objects[0].records[0].edges}
    assert corners == {(-1.0, 2.0), (-0.5, 2.0), (-0.5, 2.5), (-1.0, 2.5)}


@given(masks, st.floats(-3.2, 3.2), st.floats(0.01, 2))
def test_turning_a_map_turns_its_free_space_and_blocks_the_rest(mask, yaw, resolution):
    pose = GridPose(resolution, 3.0, -2.0, yaw)
    scene = map_scene(mask, pose)
    if math.sin(yaw) == 0.0 and math.cos(yaw) > 0:
        return
    height, width = mask.shape
    loops = [rings(obj) for obj in scene.objects]

    def solid(x: float, y: float) -> bool:
        return any(sum(winding(ring, x, y) for ring in obj) for obj in loops)

    def world(i: float, j: float) -> tuple[float, float]:
        u, v = (i + 0.5) * resolution, (height - 0.5 - j) * resolution
        return (
            3.0 + math.cos(yaw) * u - math.sin(yaw) * v,
            -2.0 + math.sin(yaw) * u + math.cos(yaw) * v,
        )

    for j, i in np.ndindex(mask.shape):
        assert solid(*world(i, j)) == mask[j, i]
    for i, j in [(-0.75, -0.75), (width - 0.25, 0), (0, height - 0.25), (width - 0.3, -0.8)]:
        assert solid(*world(i, j))


@pytest.mark.parametrize("shape", [(0, 0), (0, 4), (4,)])
def test_a_grid_without_cells_is_refused(shape):
    with pytest.raises(SceneError, match="must have rows and columns"):
        grid_scene(np.zeros(shape, dtype=bool))


# ROS files


def write_map(folder: Path, values: list[list[int]], **keys: object) -> Path:
    data = np.array(values, dtype=np.uint8)
    header = f"P5\n# made here\n{data.shape[1]} {data.shape[0]}\n255\n"
    (folder / "map.pgm").write_bytes(header.encode() + data.tobytes())
    fields = {
        "image": "map.pgm",
        "resolution": 0.5,
        "origin": "[0, 0, 0]",
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    } | keys
    lines = [f"{key}: {value}" for key, value in fields.items() if value is not None]
    (folder / "map.yaml").write_text("\n".join(lines))
    return folder / "map.yaml"


def obstacle_xs(scene: Scene) -> set[int]:
    """The columns, of one row of half-metre cells, whose middles are inside an obstacle."""
    return {
        i
        for i in range(round(scene.bounds.width / 0.5))
        for obj in scene.objects
        if sum(winding(ring, 0.5 * i + 0.25, 0.25) for ring in rings(obj))
    }


@pytest.mark.parametrize(
    ("keys", "obstacles"),
    [
        ({}, {0, 1, 2}),
        ({"free_thresh": 0.25}, {0, 1, 2}),
        ({"mode": "trinary", "negate": 1}, {1, 2, 3, 4}),
        ({"mode": "scale"}, {0, 1, 2}),
        ({"mode": "scale", "free_thresh": 0.25}, {0, 1}),
        ({"mode": "scale", "free_thresh": 0.02}, {0, 1, 2, 3}),
        ({"occupied_thresh": None, "free_thresh": None}, {0, 1, 2}),
        ({"negate": "false"}, {0, 1, 2}),
        ({"mode": "scale", "free_thresh": 0.0, "occupied_thresh": 1.0}, {0, 1, 2, 3}),
        ({"free_thresh": 0.0, "occupied_thresh": 0.0}, {0, 1, 2, 3, 4}),
        ({"negate": 1, "free_thresh": 0.0}, {1, 2, 3, 4}),
    ],
)
def test_thresholds_modes_and_negation_are_those_of_the_map_server(tmp_path, keys, obstacles):
    scene = load_scene(write_map(tmp_path, [[0, 100, 205, 240, 255]], **keys))
    assert obstacle_xs(scene) == obstacles


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
def test_a_cell_at_a_threshold_is_as_the_threshold_says(tmp_path, mode):
    cells = [[20, 40, 60]] if mode == "raw" else [[204, 153, 102]]
    path = write_map(tmp_path, cells, mode=mode, free_thresh=0.2, occupied_thresh=0.6)
    scene = load_scene(path)
    assert obstacle_xs(scene) == {1, 2}
    assert scene.remarks == ("1 unknown cells are obstacles",)


def test_raw_mode_takes_the_bytes_as_percent(tmp_path):
    path = write_map(tmp_path, [[0, 10, 50, 100, 255]], mode="raw")
    scene = load_scene(path)
    assert obstacle_xs(scene) == {2, 3, 4}
    assert scene.remarks == ("2 unknown cells are obstacles",)


def test_unknown_cells_are_counted(tmp_path):
    scene = load_scene(write_map(tmp_path, [[0, 205, 205, 254]], free_thresh=0.25))
    assert any("2 unknown cells" in remark for remark in scene.remarks)
    assert any("205" in remark for remark in scene.remarks)


def test_a_picture_that_is_not_pgm_goes_to_the_given_reader(tmp_path):
    path = write_map(tmp_path, [[0]], image="map.png")
    (tmp_path / "map.png").write_bytes(b"\x89PNG")
    with pytest.raises(SceneError, match="must be PGM"):
        load_scene(path)
    shade = np.array([[0.0, 1.0, 1.0]])
    transparent = np.array([[False, False, True]])
    scene = load_scene(path, read_picture=lambda _: (shade, transparent))
    assert obstacle_xs(scene) == {0, 2}


@pytest.mark.parametrize(
    ("keys", "what"),
    [
        ({"resolution": 0}, "2:13: resolution = 0: must be > 0"),
        ({"resolution": "x"}, "2:13: resolution = x: must be a number"),
        ({"resolution": "[1]"}, "must be a number"),
        ({"resolution": ".nan"}, "resolution"),
        ({"resolution": None}, "needs the key 'resolution'"),
        ({"image": None}, "needs the key 'image'"),
        ({"image": "none.pgm"}, "No such file"),
        ({"origin": "[0, 0]"}, "3:9: origin: must be [x, y, yaw]"),
        ({"origin": "[0, 0, inf]"}, "must lie within"),
        ({"negate": 2}, "must be 0 or 1"),
        ({"mode": "fast"}, "must be trinary, scale or raw"),
        ({"free_thresh": 1.5}, "must lie in 0..1"),
        ({"free_thresh": 0.9}, "must be <= occupied_thresh"),
        ({"image": "'a"}, "not YAML"),
    ],
)
def test_a_bad_map_header_is_named_with_its_place(tmp_path, keys, what):
    with pytest.raises(SceneError) as caught:
        load_scene(write_map(tmp_path, [[0]], **keys))
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "- 1", "just words", "a: [", "a: &b *c", "{" * 5000])
def test_any_other_yaml_is_refused(tmp_path, text):
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(SceneError, match=r"map\.yaml"):
        load_scene(tmp_path / "map.yaml")


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_a_start_in_an_unknown_cell_is_said_to_be_unknown_and_in_a_wall_to_be_in_an_obstacle(yaw):
    obstacle, unknown = np.zeros((40, 60), np.bool_), np.zeros((40, 60), np.bool_)
    obstacle[:, :10] = unknown[:, :10] = True
    obstacle[:, 10:14] = True
    pose = GridPose(0.1, -1.0, 2.0, yaw)
    roadmap = planner.build_roadmap(map_scene(obstacle, pose, unknown=unknown), 0.2)

    def place(column: float, row: float) -> tuple[float, float]:
        x, y = (column + 0.5) * 0.1, (39.5 - row) * 0.1
        cos, sin = math.cos(yaw), math.sin(yaw)
        return -1.0 + cos * x - sin * y, 2.0 + sin * x + cos * y

    goal = place(40, 20)
    for column, words in ((5, "lies in an unknown part of the map"), (12, "inside obstacle 0")):
        for stations in ((place(column, 20), goal), (goal, place(column, 20))):
            refused = roadmap.plan(*stations)
            assert isinstance(refused, planner.NoPath)
            assert refused.reason.endswith(words)


# MovingAI


def test_movingai_cells_have_their_centres_at_integers():
    scene = parse_movingai("type octile\nheight 2\nwidth 3\nmap\n.@G\nTOS\n", "x.map")
    assert scene.units == "cells"
    assert (scene.bounds.x_min, scene.bounds.y_max) == (-0.5, 1.5)
    (obj,) = scene.objects
    solid = {
        (i, j)
        for i in range(3)
        for j in range(2)
        if sum(winding(ring, i, j) for ring in rings(obj))
    }
    assert solid == {(1, 0), (0, 1), (1, 1)}


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("type octile\nheight 1\nwidth 1\n.", "expected 'type'"),
        ("type octile\nheight 1\nwidth 1\n", "no line 'map'"),
        ("type octile\nheight 2\nwidth 1\nmap\n.\n", "height 2, but 1 rows"),
        ("type octile\nheight 1\nwidth 2\nmap\n.\n", "x.map:5:1: width 2, but 1 cells"),
        ("type octile\nheight 1\nwidth 2\nmap\n.x\n", "x.map:5:2: 'x' is no cell"),
        ("type octile\nheight 1\nwidth 2\nmap\n.é\n", "x.map:5:2: 'é' is no cell"),
        ("type octile\nheight 0\nwidth 2\nmap\n", "height = 0"),
        ("type octile\nwidth 2\nmap\n", "height = nothing"),
    ],
)
def test_a_bad_movingai_map_is_named_with_its_place(text, what):
    with pytest.raises(SceneError) as caught:
        parse_movingai(text, "x.map")
    assert what in str(caught.value)


# Real maps

REAL = os.environ.get("CLEARWAY_REAL_DATA")


@pytest.mark.skipif(not REAL, reason="CLEARWAY_REAL_DATA is not set: no real maps to read")
@pytest.mark.parametrize(
    ("name", "units", "obstacle_cells"),
    [
        ("depot.yaml", "m", 5947 + 8894),
        ("tb3_sandbox.yaml", "m", 870 + 138683),
        ("random-32-32-10.map", "cells", None),
    ],
)
def test_real_maps_keep_the_area_of_their_cells(name, units, obstacle_cells):
    path = Path(str(REAL)) / "maps" / name
    scene = load_scene(path)
    assert scene.units == units
    if obstacle_cells is None:
        obstacle_cells = path.read_text().partition("map\n")[2].count("@")
    cell = 1.0 if units == "cells" else 0.05
    sense = 1.0 if units == "cells" else -1.0
    area = 0.0
    for obj in scene.objects:
        for ring in rings(obj):
            points = np.array(ring)
            x, y = points.T
            area += sense * 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area == pytest.approx(obstacle_cells * cell * cell, rel=1e-9)
