"""`clearway extract`, `plan` and `roadmap` against their contract, field by field.

The oracles are what was drawn, and distances computed slowly from the printed JSON alone.
"""

from __future__ import annotations

import itertools
import json
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, NoReturn

import cv2
import networkx as nx
import numpy as np
import pytest

from planner.formats.scene_io import read_scene_text
from tests.support.oracles.brute_clearance import (
    borders,
    distances,
    edges_of,
    inside,
    outline,
    signed_area,
    walk,
)
from tests.support.pictures import FREE, SOLID, blank, box_and_disc, call, gate, save

STAGES = (
    *("load", "binarise", "contours", "geometry", "voronoi", "roadmap", "path", "trajectory"),
    "total",
)
COUNTS = (
    *("border_pixels", "vertices", "generators", "voronoi_vertices", "roadmap_nodes"),
    "roadmap_edges",
)
RADIUS = 9.0
STEP = 0.25


def _no_constant(word: str) -> NoReturn:
    raise AssertionError(f"{word} is not JSON")


def strict(text: str) -> Any:
    """Parse JSON that holds no NaN and no infinity, and ends in one line feed."""
    assert text.endswith("}\n")
    return json.loads(text, parse_constant=_no_constant)


def extract(file: Path, *options: object) -> Any:
    told = call("extract", file, "--format", "json", *options)
    assert (told.code, told.err) == (0, "")
    return strict(told.out)


def plan(file: Path, start: str, goal: str, *options: object, radius: float = RADIUS) -> Any:
    told = call(
        *("plan", file, "--start", start, "--goal", goal, "--radius", radius),
        *("--format", "json", *options),
    )
    answer = strict(told.out)
    assert told.code == (0 if answer["status"] == "ok" else 3)
    return answer


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    save(folder, "two.png", box_and_disc())
    save(folder, "gate.png", gate())
    save(folder, "zoo.png", zoo())
    return folder


def zoo() -> Any:
    """A rectangle with a round hole, a D (arc and chord), an L, a triangle and a single pixel."""
    picture = blank()
    cv2.rectangle(picture, (40, 40), (200, 180), SOLID, -1)
    cv2.circle(picture, (120, 110), 40, FREE, -1)
    y, x = np.ogrid[:480, :640]
    picture[((x - 420) ** 2 + (y - 110) ** 2 <= 70**2) & (x >= 420)] = SOLID
    picture[280:440, 60:91] = SOLID
    picture[410:440, 60:200] = SOLID
    cv2.fillPoly(picture, [np.array([[300, 420], [420, 400], [340, 280]])], SOLID)
    picture[300, 560] = SOLID
    return picture


# Extract.


def test_extract_prints_every_field_of_the_scene_schema(folder: Path) -> None:
    scene = extract(folder / "two.png")
    assert scene["schema"] == "clearway.scene/1"
    assert scene["units"] == "px"
    assert scene["size"] == [640, 480]
    assert scene["bounds"] == [-0.5, -0.5, 639.5, 479.5]
    assert set(scene["binarisation"]) >= {"method", "threshold", "polarity", "reason"}
    assert scene["binarisation"]["polarity"] == "dark"
    assert SOLID < scene["binarisation"]["threshold"] < FREE
    assert scene["binarisation"]["reason"]
    assert all(isinstance(n, int) and n >= 0 for n in scene["counts"].values())
    assert scene["counts"]["border_pixels"] > 4 * 100
    assert all(isinstance(t, float) and t >= 0.0 for t in scene["timings_ms"].values())
    assert {"load", "binarise", "contours", "total"} <= set(scene["timings_ms"])
    parts = sum(t for name, t in scene["timings_ms"].items() if name != "total")
    assert parts <= scene["timings_ms"]["total"] * 1.001 + 0.01
    assert [item["id"] for item in scene["objects"]] == [0, 1]


def test_every_record_and_edge_has_its_fields(folder: Path) -> None:
    wanted = {
        "P": {"at"},
        "S": {"from", "to"},
        "C": {"center", "radius"},
        "A": {"edges"},
        "L": {"edges"},
    }
    seen = set()
    for records in borders(extract(folder / "zoo.png")):
        for record in records:
            seen.add(record["type"])
            assert set(record) == {"type", "residual_px"} | wanted[record["type"]]
            assert 0.0 <= record["residual_px"] < 1.0
            for edge in record.get("edges", []):
                arc = {"center", "radius", "ccw"} if edge["kind"] == "arc" else set()
                assert set(edge) == {"kind", "from", "to"} | arc
                assert edge["kind"] in ("segment", "arc")
                seen.add(edge["kind"])
    assert {"P", "C", "L", "segment", "arc"} <= seen


def test_the_drawn_rectangle_and_disc_are_found_where_they_were_drawn(folder: Path) -> None:
    box, disc = (item["records"] for item in extract(folder / "two.png")["objects"])
    assert [r["type"] for r in box] == ["L"]
    corners = sorted(tuple(edge["from"]) for edge in box[0]["edges"])
    drawn = [(199.5, 149.5), (199.5, 300.5), (300.5, 149.5), (300.5, 300.5)]
    np.testing.assert_allclose(corners, drawn, atol=0.3)
    assert [r["type"] for r in disc] == ["C"]
    np.testing.assert_allclose(disc[0]["center"], (450.0, 240.0), atol=0.15)
    assert disc[0]["radius"] == pytest.approx(60.25, abs=0.4)


def test_outlines_are_closed_and_run_clockwise_on_the_screen_and_holes_the_other_way(
    folder: Path,
) -> None:
    scene = extract(folder / "zoo.png")
    closed = 0
    for item in scene["objects"]:
        for records, sign in [(item["records"], 1.0), *((hole, -1.0) for hole in item["holes"])]:
            for record in records:
                if record["type"] != "L":
                    continue
                edges = record["edges"]
                for edge, following in zip(edges, edges[1:] + edges[:1], strict=True):
                    assert edge["to"] == following["from"]
                # y points down, so clockwise on the screen is a growing angle
                assert sign * signed_area(outline([record], y_down=True)) > 0.0
                closed += 1
    assert closed >= 4


def test_the_zoo_holds_the_hole_the_arc_and_the_pixel(folder: Path) -> None:
    items = extract(folder / "zoo.png")["objects"]
    assert len(items) == 5
    (frame,) = (item for item in items if item["holes"])
    (hole,) = frame["holes"]
    assert [r["type"] for r in hole] == ["C"]
    np.testing.assert_allclose(hole[0]["center"], (120.0, 110.0), atol=0.2)
    assert hole[0]["radius"] == pytest.approx(39.7, abs=0.6)
    (pixel,) = (r for item in items for r in item["records"] if r["type"] == "P")
    assert pixel["at"] == [560.0, 300.0]
    arcs = [e for b in borders({"objects": items}) for r in b for e in edges_of(r) if "center" in e]
    half = next(e for e in arcs if e["from"] != e["to"])
    np.testing.assert_allclose(half["center"], (420.0, 110.0), atol=1.0)
    assert half["radius"] == pytest.approx(70.0, abs=1.0)
    assert half["ccw"] is False


def test_the_scene_fits_the_picture_pixel_by_pixel(folder: Path) -> None:
    """Points in solid pixels off the border lie inside an outline, free ones outside of all."""
    scene, picture = extract(folder / "zoo.png"), zoo()
    rng = np.random.default_rng(3)
    points = rng.integers((0, 0), (640, 480), (4000, 2)).astype(np.float64)
    solid = np.zeros(len(points), dtype=np.bool_)
    for item in scene["objects"]:
        if item["records"][0]["type"] == "P":
            continue
        solid |= inside(points, outline(item["records"], True))
        for hole in item["holes"]:
            solid &= ~inside(points, outline(hole, True))
    off = distances(points, scene) > 1.5
    drawn = picture[points[:, 1].astype(int), points[:, 0].astype(int)] == SOLID
    assert off.sum() > 3000
    assert drawn[off].any()
    np.testing.assert_array_equal(solid[off], drawn[off])


@pytest.mark.parametrize("name", ["two.png", "zoo.png"])
@pytest.mark.parametrize("mode", [[], ["--paper"]])
def test_the_text_read_again_is_the_same_scene(folder: Path, name: str, mode: list[str]) -> None:
    told = call("extract", folder / name, *mode)
    assert told.code == 0
    scene, printed = read_scene_text(told.out), extract(folder / name, *mode)
    assert [o.id for o in scene.objects] == [o["id"] for o in printed["objects"]]
    ours = scene.primitives(include_bounds=False)
    count = sum(len(edges_of(r)) for b in borders(printed) for r in b)
    assert len(ours.kind) == count
    assert scene.vertex_count == printed["counts"]["vertices"]
    mine = np.sort(np.abs(ours.data[:, :2]).sum(axis=1))
    theirs = []
    for records in borders(printed):
        for record in records:
            for edge in edges_of(record):
                theirs.append(sum(map(abs, edge.get("center", edge["from"]))))
    np.testing.assert_allclose(mine, np.sort(theirs), atol=1e-9)


def test_light_obstacles_on_dark_give_the_same_scene(folder: Path, tmp_path: Path) -> None:
    negative = save(tmp_path, "negative.png", 255 - box_and_disc())
    light = extract(negative, "--polarity", "light")
    assert light["binarisation"]["polarity"] == "light"
    for a, b in zip(light["objects"], extract(folder / "two.png")["objects"], strict=True):
        for one, other in zip(a["records"], b["records"], strict=True):
            assert one["type"] == other["type"]
            for e, f in zip(edges_of(one), edges_of(other), strict=True):
                np.testing.assert_allclose(e["from"], f["from"], atol=0.1)


def test_extract_writes_what_it_would_print_and_draws_a_picture(
    folder: Path, tmp_path: Path
) -> None:
    answer, drawn = tmp_path / "scene.json", tmp_path / "scene.png"
    told = call(
        *("extract", folder / "two.png", "--format", "json"), *("-o", answer, "--render", drawn)
    )
    assert told == (0, "", "")
    objects = strict(answer.read_text())["objects"]
    assert objects == extract(folder / "two.png")["objects"]
    image = cv2.imread(str(drawn))
    assert image is not None
    assert min(image.shape[:2]) >= 480


# Plan.


def test_plan_prints_every_field_of_the_plan_schema(folder: Path) -> None:
    answer = plan(folder / "two.png", "40,40", "600,440", "--alternatives", "2")
    assert set(answer) >= {
        *("schema", "status", "units", "robot_radius", "path", "length", "min_clearance"),
        *("waypoints", "duration", "alternatives", "order", "reason", "bottleneck"),
        *("widest_radius", "counts", "timings_ms"),
    }
    assert answer["schema"] == "clearway.plan/1"
    assert (answer["status"], answer["units"]) == ("ok", "px")
    assert answer["robot_radius"] == RADIUS
    assert set(answer["counts"]) == set(COUNTS)
    assert all(isinstance(answer["counts"][name], int) for name in COUNTS)
    assert all(answer["counts"][name] > 0 for name in COUNTS)
    assert set(answer["timings_ms"]) == set(STAGES)
    assert all(answer["timings_ms"][name] >= 0.0 for name in STAGES)
    parts = sum(answer["timings_ms"][name] for name in STAGES if name != "total")
    assert parts <= answer["timings_ms"]["total"] * 1.001 + 0.1
    for waypoint in answer["waypoints"]:
        assert set(waypoint) == {"x", "y", "heading", "speed", "time"}
    assert answer["reason"] is None


JOURNEYS = [
    ("two.png", "40,40", "600,440"),
    ("two.png", "380,240", "180,225"),
    ("gate.png", "50,50", "600,400"),
    ("zoo.png", "20,460", "620,20"),
    ("zoo.png", "230,110", "330,110"),
]


@pytest.mark.parametrize(("name", "start", "goal"), JOURNEYS)
@pytest.mark.parametrize("prefer", ["clearance", "length", "balanced", "0.25"])
def test_a_path_keeps_its_clearance_by_an_independent_count(
    folder: Path, name: str, start: str, goal: str, prefer: str
) -> None:
    answer = plan(folder / name, start, goal, "--prefer", prefer)
    assert answer["status"] == "ok"
    path = answer["path"]
    assert path[0] == [float(v) for v in start.split(",")]
    assert path[-1] == [float(v) for v in goal.split(",")]
    length = sum(math.dist(a, b) for a, b in itertools.pairwise(path))
    assert answer["length"] == pytest.approx(length, rel=1e-9)
    scene = extract(folder / name)
    points = walk(path, STEP)
    for item in scene["objects"]:
        if len(outer := outline(item["records"], True)) > 2:
            assert not inside(points, outer).any()
    least = distances(points, scene).min()
    assert RADIUS <= answer["min_clearance"] <= least + 1e-3
    assert answer["min_clearance"] >= least - STEP / 2.0 - 1e-3
    gap = answer["bottleneck"]
    assert gap["width"] == pytest.approx(2.0 * answer["min_clearance"])
    there = distances(np.array([[gap["x"], gap["y"]]]), scene)
    assert there[0] == pytest.approx(answer["min_clearance"], abs=1e-2)


def test_the_preference_trades_length_for_clearance(folder: Path) -> None:
    by_name = {
        prefer: plan(folder / "two.png", "330,225", "380,460", "--prefer", prefer)
        for prefer in ("length", "balanced", "clearance")
    }
    lengths = [by_name[p]["length"] for p in ("length", "balanced", "clearance")]
    assert lengths == sorted(lengths)
    assert by_name["clearance"]["min_clearance"] >= by_name["length"]["min_clearance"] - 1e-6
    straight = plan(folder / "two.png", "40,40", "600,40", "--prefer", "length")
    assert 560.0 <= straight["length"] <= 1.1 * 560.0


@pytest.mark.parametrize(("name", "start", "goal"), JOURNEYS)
def test_waypoints_follow_the_path_in_time(folder: Path, name: str, start: str, goal: str) -> None:
    answer = plan(folder / name, start, goal)
    waypoints = answer["waypoints"]
    times = [w["time"] for w in waypoints]
    assert times[0] == 0.0
    assert all(a < b for a, b in itertools.pairwise(times))
    assert answer["duration"] == pytest.approx(times[-1])
    assert waypoints[0]["speed"] == waypoints[-1]["speed"] == 0.0
    assert all(w["speed"] >= 0.0 for w in waypoints)
    assert all(-math.pi <= w["heading"] <= math.pi for w in waypoints)
    for waypoint, place in ((waypoints[0], start), (waypoints[-1], goal)):
        x, y = (float(v) for v in place.split(","))
        assert (waypoint["x"], waypoint["y"]) == pytest.approx((x, y), abs=1e-6)
    chords = walk([(w["x"], w["y"]) for w in waypoints], STEP)
    assert distances(chords, extract(folder / name)).min() >= RADIUS - 0.05


def test_headings_asked_for_are_kept(folder: Path) -> None:
    answer = plan(folder / "two.png", "40,40,90", "600,440,-30")
    first, last = answer["waypoints"][0], answer["waypoints"][-1]
    assert first["heading"] == pytest.approx(math.pi / 2, abs=1e-6)
    assert last["heading"] == pytest.approx(-math.pi / 6, abs=1e-6)


def test_a_gap_too_narrow_has_a_reason_a_bottleneck_and_the_widest_radius(folder: Path) -> None:
    """The gate's free gap is the rows 220 .. 259: 40 px wide around (320, 239.5)."""
    file = folder / "gate.png"
    answer = plan(file, "150,240", "500,240", radius=21.0)
    assert answer["status"] == "unreachable"
    assert "20" in answer["reason"] or "wide" in answer["reason"]
    for name in ("path", "length", "min_clearance", "waypoints", "duration"):
        assert answer[name] is None
    widest = answer["widest_radius"]
    assert widest == pytest.approx(20.0, abs=0.3)
    gap = answer["bottleneck"]
    assert gap["width"] == pytest.approx(2.0 * widest, rel=1e-6)
    assert 298.0 <= gap["x"] <= 342.0
    assert gap["y"] == pytest.approx(239.5, abs=0.5)
    assert plan(file, "150,240", "500,240", radius=widest * 0.999)["status"] == "ok"
    assert plan(file, "150,240", "500,240", radius=widest * 1.001)["status"] == "unreachable"


def test_a_margin_counts_like_radius(folder: Path) -> None:
    file = folder / "gate.png"
    assert plan(file, "150,240", "500,240", "--margin", "5", radius=14.0)["status"] == "ok"
    answer = plan(file, "150,240", "500,240", "--margin", "7", radius=14.0)
    assert answer["status"] == "unreachable"
    assert answer["robot_radius"] == 14.0
    with_margin = plan(
        folder / "two.png", "40,40", "600,440", "--margin", "8", "--prefer", "length"
    )
    assert with_margin["min_clearance"] >= RADIUS + 8.0


def test_stations_are_visited_in_the_order_asked_or_the_best(folder: Path) -> None:
    vias = [(600.0, 40.0), (350.0, 60.0), (120.0, 60.0)]
    options = [word for x, y in vias for word in ("--via", f"{x},{y}")]
    fixed = plan(folder / "two.png", "40,40", "600,440", *options)
    assert fixed["order"] == [0, 1, 2]
    best = plan(folder / "two.png", "40,40", "600,440", *options, "--order", "best")
    assert best["order"] == [2, 1, 0]
    assert best["length"] < fixed["length"]
    for answer in (fixed, best):
        points = [tuple(p) for p in answer["path"]]
        places = [points.index(vias[k]) for k in answer["order"]]
        assert places == sorted(places)


def test_alternatives_go_another_way_round_and_keep_the_clearance(folder: Path) -> None:
    scene = extract(folder / "two.png")
    answer = plan(folder / "two.png", "40,240", "600,240", "--alternatives", "3")
    ways = [answer, *answer["alternatives"]]
    assert 3 <= len(ways) <= 4
    sides = set()
    for way in ways:
        path = way["path"]
        assert path[0] == [40.0, 240.0]
        assert path[-1] == [600.0, 240.0]
        points = walk(path, STEP)
        assert distances(points, scene).min() >= RADIUS - STEP
        assert way["min_clearance"] >= RADIUS
        above = [bool(points[np.abs(points[:, 0] - x).argmin(), 1] < 240.0) for x in (250, 450)]
        sides.add(tuple(above))
    assert len(sides) == len(ways), "two alternatives pass the obstacles on the same sides"
    assert plan(folder / "two.png", "40,240", "600,240")["alternatives"] == []


def test_the_answer_is_written_and_drawn(folder: Path, tmp_path: Path) -> None:
    for suffix in (".svg", ".png"):
        answer, drawn = tmp_path / "answer.json", tmp_path / f"plan{suffix}"
        told = call(
            *("plan", folder / "zoo.png", "--start", "20,460", "--goal", "620,20"),
            *("--radius", "9", "--format", "json", "-o", answer, "--render", drawn),
        )
        assert told == (0, "", "")
        assert strict(answer.read_text())["status"] == "ok"
        if suffix == ".svg":
            root = ElementTree.fromstring(drawn.read_text())
            assert root.tag == "{http://www.w3.org/2000/svg}svg"
            assert "nan" not in drawn.read_text().lower().replace("dominant", "")
        else:
            image = cv2.imread(str(drawn))
            assert image is not None
            assert image.std() > 5.0


def test_no_path_is_drawn_too(folder: Path, tmp_path: Path) -> None:
    drawn = tmp_path / "none.svg"
    answer = plan(folder / "gate.png", "150,240", "500,240", "--render", drawn, radius=25.0)
    assert answer["status"] == "unreachable"
    ElementTree.fromstring(drawn.read_text())


def test_a_plan_through_the_extracted_text_is_the_plan_through_the_picture(
    folder: Path, tmp_path: Path
) -> None:
    text = tmp_path / "scene.txt"
    assert call("extract", folder / "zoo.png", "-o", text).code == 0
    one = plan(folder / "zoo.png", "20,460", "620,20")
    other = plan(text, "20,460", "620,20")
    assert other["units"] == "px"
    assert other["length"] == pytest.approx(one["length"], rel=1e-9)
    assert other["counts"]["generators"] == one["counts"]["generators"]


def test_moving_the_picture_moves_the_plan(tmp_path: Path) -> None:
    shifted = np.roll(box_and_disc(), (17, 23), axis=(0, 1))
    here = plan(save(tmp_path, "a.png", box_and_disc()), "330,225", "380,300", "--prefer", "length")
    there = plan(save(tmp_path, "b.png", shifted), "353,242", "403,317", "--prefer", "length")
    assert there["length"] == pytest.approx(here["length"], abs=0.5)
    assert there["min_clearance"] == pytest.approx(here["min_clearance"], abs=0.5)


# Maps.

ROS_ROWS = [
    "##########",
    "#........#",
    "#...##...#",
    "#...##...#",
    "#........#",
    "##########",
]


@pytest.fixture
def ros_map(tmp_path: Path) -> Path:
    shade = np.array([[0 if c == "#" else 254 for c in row] for row in ROS_ROWS], np.uint8)
    save(tmp_path, "map.pgm", shade)
    file = tmp_path / "map.yaml"
    file.write_text(
        "image: map.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    return file


def test_a_ros_map_is_planned_in_metres_with_its_origin(ros_map: Path) -> None:
    """The free inside is x in [-0.5, 3.5], y in [2.5, 4.5]; the block x 1..2, y 3..4."""
    answer = plan(ros_map, "-0.2,3.5", "3.2,3.5", radius=0.1)
    assert (answer["status"], answer["units"]) == ("ok", "m")
    middle = min(answer["path"], key=lambda p: abs(p[0] - 1.5))
    assert abs(middle[1] - 3.5) > 0.5 + 0.1
    assert 0.1 <= answer["min_clearance"] <= 0.25 + 1e-9
    blocked = plan(ros_map, "-0.2,3.5", "3.2,3.5", radius=0.26)
    assert blocked["widest_radius"] == pytest.approx(0.25, rel=1e-6)
    assert "obstacle" in plan(ros_map, "1.5,3.5", "3,3", radius=0.1)["reason"]


def test_a_movingai_map_has_its_cell_centres_at_integers_and_no_diagonal_gaps(
    tmp_path: Path,
) -> None:
    file = tmp_path / "small.map"
    file.write_text("type octile\nheight 4\nwidth 6\nmap\n......\n..@...\n...@..\n......\n")
    answer = plan(file, "0,0", "5,3", radius=0.3)
    assert (answer["status"], answer["units"]) == ("ok", "cells")
    scene = {
        "bounds": [-0.5, -0.5, 5.5, 3.5],
        "objects": [
            {"records": [_square(2.0, 1.0)], "holes": []},
            {"records": [_square(3.0, 2.0)], "holes": []},
        ],
    }
    least = distances(walk(answer["path"], 0.01), scene).min()
    assert answer["min_clearance"] == pytest.approx(least, abs=0.006)
    shut = tmp_path / "shut.map"
    shut.write_text("type octile\nheight 3\nwidth 3\nmap\n..@\n.@.\n@..\n")
    assert plan(shut, "0,0", "2,2", radius=0.01)["status"] == "unreachable"


def _square(x: float, y: float) -> dict[str, Any]:
    corners = [[x + dx, y + dy] for dx, dy in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    ends = corners[1:] + corners[:1]
    edges = [{"kind": "segment", "from": a, "to": b} for a, b in zip(corners, ends, strict=True)]
    return {"type": "L", "edges": edges}


# Roadmap.


@pytest.fixture
def exported(folder: Path, tmp_path: Path) -> Path:
    for suffix in ("graphml", "geojson", "json"):
        told = call("roadmap", folder / "zoo.png", "--radius", "9", "-o", tmp_path / f"r.{suffix}")
        assert (told.code, told.err) == (0, "")
        assert str(tmp_path / f"r.{suffix}") in told.out
    return tmp_path


def test_the_exported_graphs_are_the_same_and_keep_the_radius(exported: Path, folder: Path) -> None:
    scene = extract(folder / "zoo.png")
    xml = nx.read_graphml(exported / "r.graphml")
    link = nx.node_link_graph(json.loads((exported / "r.json").read_text()), edges="edges")
    assert len(xml) == len(link) > 4
    assert xml.number_of_edges() == link.number_of_edges() > 4
    for _, _, data in link.edges(data=True):
        assert data["clearance"] >= RADIUS
        assert data["length"] > 0.0
    for _, data in link.nodes(data=True):
        there = distances(np.array([[data["x"], data["y"]]]), scene)[0]
        assert data["clearance"] == pytest.approx(there, abs=0.02)
    for _, _, data in xml.edges(data=True):
        assert float(data["clearance"]) >= RADIUS


def test_the_geojson_is_a_route_graph_of_points_and_directed_lines(exported: Path) -> None:
    data = json.loads((exported / "r.geojson").read_text(), parse_constant=_no_constant)
    assert data["type"] == "FeatureCollection"
    kinds = [f["geometry"]["type"] for f in data["features"]]
    nodes = {f["properties"]["id"] for f in data["features"] if f["geometry"]["type"] == "Point"}
    lines = [f["properties"] for f in data["features"] if f["geometry"]["type"] != "Point"]
    assert len(nodes) == kinds.count("Point") > 4
    assert lines
    for line in lines:
        assert line["startid"] in nodes
        assert line["endid"] in nodes
    ways = {(line["startid"], line["endid"]) for line in lines}
    assert all((b, a) in ways for a, b in ways)
