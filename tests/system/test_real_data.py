"""Pictures and maps that nobody in this project made: sensible answers, never a traceback."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tests.support.oracles.brute_clearance import borders, distances, inside, outline, walk
from tests.support.pictures import call


def extract(file: Path, *options: str) -> Any:
    told = call("extract", file, "--format", "json", *options)
    assert (told.code, told.err) == (0, "")
    return json.loads(told.out)


def plan(file: Path, *options: object) -> Any:
    told = call("plan", file, "--format", "json", *options)
    answer = json.loads(told.out)
    assert told.code == (0 if answer["status"] == "ok" else 3)
    assert "Traceback" not in told.err
    return answer


def agreement(scene: dict[str, Any], solid: np.ndarray, away_px: float) -> float:
    """Of random pixels further than ``away_px`` from a border, how many the scene tells right."""
    height, width = solid.shape
    rng = np.random.default_rng(5)
    points = rng.integers((0, 0), (width, height), (2000, 2)).astype(np.float64)
    told = np.zeros(len(points), dtype=np.bool_)
    for item in scene["objects"]:
        for records in (item["records"], *item["holes"]):
            told ^= inside(points, outline(records, True))
    off = distances(points, scene) > away_px
    right = told[off] == solid[points[off, 1].astype(int), points[off, 0].astype(int)]
    return float(right.mean())


@pytest.mark.parametrize("number", [1, 2, 5, 6])
def test_a_silhouette_is_one_light_object_that_fits_its_pixels(
    real_data: Path, number: int
) -> None:
    file = real_data / "shapes" / f"silhouette_{number}.png"
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    scene = extract(file, "--polarity", "light")
    (item,) = scene["objects"]
    assert [r["type"] for r in item["records"]] == ["L"]
    assert agreement(scene, picture > 127, 1.5) == 1.0


def test_a_silhouette_taken_for_dark_is_the_background(real_data: Path) -> None:
    """The wrong polarity is an answer too: the ground is then solid, the shape is a hole."""
    file = real_data / "shapes" / "silhouette_1.png"
    scene = extract(file)
    assert sum(len(item["holes"]) for item in scene["objects"]) >= 1
    told = call("plan", file, "--start", "10,10", "--goal", "240,240", "--radius", "4")
    assert told.code == 3
    assert "inside obstacle" in told.err


def test_a_robot_goes_round_a_silhouette(real_data: Path) -> None:
    file = real_data / "shapes" / "silhouette_1.png"
    light = ("--polarity", "light")
    answer = plan(file, *light, "--start", "10,10", "--goal", "240,240", "--radius", "4")
    assert answer["status"] == "ok"
    points = walk(answer["path"], 0.5)
    assert distances(points, extract(file, *light)).min() >= 4.0 - 0.25
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    assert (picture[points[:, 1].round().astype(int), points[:, 0].round().astype(int)] < 128).all()


def test_six_parts_and_the_dark_surroundings_of_a_light_table_are_found(real_data: Path) -> None:
    file = real_data / "shapes" / "pca_test1.jpg"
    scene = extract(file)
    large = [i for i in scene["objects"] if len(i["records"][0].get("edges", [])) >= 4]
    assert len(large) == 7
    answer = plan(file, "--start", "140,60", "--goal", "600,470", "--radius", "9")
    assert answer["status"] == "ok"
    assert answer["min_clearance"] >= 9.0
    points = walk(answer["path"], 0.5)
    assert distances(points, scene).min() >= answer["min_clearance"] - 0.01
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    along = picture[points[:, 1].round().astype(int), points[:, 0].round().astype(int)]
    assert along.min() > 150, "the path runs over light table only"


def test_polygons_and_their_holes_are_found_in_a_drawing(real_data: Path) -> None:
    scene = extract(real_data / "shapes" / "pic1.png")
    assert len(scene["objects"]) == 7
    holes = [hole[0] for item in scene["objects"] for hole in item["holes"]]
    discs = [hole["radius"] for hole in holes if hole["type"] == "C"]
    assert discs == pytest.approx([6.36] * 7, abs=0.15)
    picture = cv2.imread(str(real_data / "shapes" / "pic1.png"), cv2.IMREAD_GRAYSCALE)
    assert agreement(scene, picture < 128, 2.0) == 1.0


@pytest.mark.parametrize(
    ("name", "start", "goal", "radius"),
    [
        ("depot", (3.0, 3.0), (25.0, 8.0), 0.2),
        ("tb3_sandbox", (-2.0, -0.5), (1.0, 1.8), 0.15),
    ],
)
def test_a_ros_map_is_planned_over_free_cells_only(
    real_data: Path,
    name: str,
    start: tuple[float, float],
    goal: tuple[float, float],
    radius: float,
) -> None:
    file = real_data / "maps" / f"{name}.yaml"
    (a, b), (c, d) = start, goal
    answer = plan(file, f"--start={a},{b}", f"--goal={c},{d}", "--radius", radius)
    assert (answer["status"], answer["units"]) == ("ok", "m")
    assert answer["min_clearance"] >= radius
    assert math.dist(start, goal) <= answer["length"] <= 2.0 * math.dist(start, goal)
    shade, resolution, origin = _ros_picture(file)
    rows, columns = np.nonzero(shade != 254)
    height = len(shade)
    low = np.stack((columns, height - 1 - rows), axis=1) * resolution + origin
    least = math.inf
    for point in walk(answer["path"], radius / 10):
        off = np.maximum(np.maximum(low - point, point - low - resolution), 0.0)
        least = min(least, float(np.hypot(*off.T).min()))
    assert answer["min_clearance"] == pytest.approx(least, abs=radius / 20 + 1e-9)


def _ros_picture(file: Path) -> tuple[np.ndarray, float, np.ndarray]:
    """The picture, the resolution and the origin, read by hand."""
    words = dict(line.split(":", 1) for line in file.read_text().splitlines() if ":" in line)
    shade = cv2.imread(str(file.parent / words["image"].strip()), cv2.IMREAD_UNCHANGED)
    origin = [float(v) for v in words["origin"].strip(" []").split(",")]
    return shade, float(words["resolution"]), np.array(origin[:2])


def test_places_of_a_ros_map_that_are_no_places_are_told(real_data: Path) -> None:
    file = real_data / "maps" / "tb3_sandbox.yaml"
    for start, words in (
        ("-100,0", "outside"),
        ("-9,-9", "unknown part"),
        ("-0.975,-0.025", "obstacle"),
    ):
        told = call("plan", file, f"--start={start}", "--goal", "1,1.8", "--radius", "0.15")
        assert told.code == 3
        assert words in told.err


def test_scenarios_of_a_movingai_map_are_planned_near_their_known_lengths(real_data: Path) -> None:
    """A robot that just passes between cells is never much longer than the 8-connected optimum.

    Its cells' corners may be cut a little closer than a grid path cuts them, so it may also be
    a little shorter.
    """
    file = real_data / "maps" / "random-32-32-10.map"
    rows = (real_data / "maps" / "random-32-32-10-random-1.scen").read_text().splitlines()[1:]
    radius, tried = 0.3, 0
    for row in rows[::40]:
        words = row.split()
        x0, y0, x1, y1 = (int(v) for v in words[4:8])
        best = float(words[8])
        answer = plan(
            *(file, "--start", f"{x0},{y0}", "--goal", f"{x1},{y1}", "--radius", radius),
            *("--prefer", "length"),
        )
        if answer["status"] == "unreachable":
            assert answer["reason"]
            continue
        tried += 1
        assert answer["min_clearance"] >= radius
        assert answer["length"] <= 1.6 * best + 2.0
        assert answer["length"] >= math.dist((x0, y0), (x1, y1)) - 1e-9
    assert tried >= 8


@pytest.mark.parametrize(
    "name",
    ["markers/singlemarkersoriginal.jpg", "markers/choriginal.jpg", "calibration/left01.jpg"],
)
def test_a_photograph_that_is_no_arena_is_answered_all_the_same(real_data: Path, name: str) -> None:
    told = call("extract", real_data / name, "--format", "json")
    assert told.code == 0
    scene = json.loads(told.out)
    assert scene["objects"]
    for records in borders(scene):
        for record in records:
            assert math.isfinite(record["residual_px"])


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("shapes/silhouette_3.png", ["--polarity", "light", "--radius", "5"]),
        ("shapes/pca_test1.jpg", ["--radius", "9"]),
        ("shapes/pic1.png", ["--radius", "5"]),
        ("maps/depot.yaml", ["--radius", "0.2"]),
        ("maps/tb3_sandbox.yaml", ["--radius", "0.15"]),
        ("maps/random-32-32-10.map", ["--radius", "0.3"]),
    ],
)
def test_a_roadmap_of_real_data_keeps_the_radius(
    real_data: Path, tmp_path: Path, name: str, options: list[str]
) -> None:
    file = tmp_path / "roadmap.json"
    told = call("roadmap", real_data / name, *options, "-o", file, "--render", tmp_path / "r.svg")
    assert (told.code, told.err) == (0, "")
    graph = json.loads(file.read_text())
    if name == "shapes/silhouette_3.png":
        # one obstacle in an open frame: a ring, which a graph without double edges cuts in three
        assert sorted(Counter(_ends(graph)).values()) == [2, 2, 2]
    else:
        assert len(graph["nodes"]) >= 4
        assert len(graph["edges"]) >= 4
    radius = float(options[-1])
    assert min(edge["clearance"] for edge in graph["edges"]) >= radius * (1.0 - 1e-9)


def _ends(graph: dict[str, Any]) -> list[int]:
    return [edge[end] for edge in graph["edges"] for end in ("source", "target")]


def test_a_yaml_that_is_no_map_is_refused(real_data: Path) -> None:
    told = call(
        *("plan", real_data / "markers" / "tutorial_camera_charuco.yml"),
        *("--start", "0,0", "--goal", "1,1", "--radius", "1"),
    )
    assert told.code == 2
    assert told.err.startswith("clearway: error: ")
    assert len(told.err.splitlines()) == 1
