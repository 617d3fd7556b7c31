"""What `clearway extract` answers: every field, where things were drawn, pixel by pixel."""

from __future__ import annotations

from pathlib import Path

import cv2
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
)
from tests.support.pictures import FREE, SOLID, box_and_disc, call, save
from tests.system.answers.asked import extract, strict, zoo

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
