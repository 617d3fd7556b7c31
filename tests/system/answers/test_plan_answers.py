"""What `clearway plan` answers: every field, and clearances counted on their own."""

from __future__ import annotations

import itertools
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.support.oracles.brute_clearance import (
    distances,
    inside,
    outline,
    walk,
)
from tests.support.pictures import box_and_disc, call, save
from tests.system.answers.asked import COUNTS, RADIUS, STAGES, STEP, extract, plan, strict

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
