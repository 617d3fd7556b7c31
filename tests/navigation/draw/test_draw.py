"""Pictures show what is where: pixels are asked at places of the scene, the SVG is parsed."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path

import cv2
import numpy as np
import pytest

from navigation.draw import DrawError, OtherRobot, draw_png, draw_svg, save_picture
from navigation.draw.picture import MARGIN
from navigation.draw.shapes import (
    BOTTLENECK,
    CLEARANCE_RAMP,
    FLOOR,
    OBSTACLE,
    OTHER_PATH,
    OTHER_ROBOT,
    PATH,
    RAMP_STEPS,
    TRACK,
    ramp_colour,
)
from planner.formats.scene_io import read_scene_text
from planner.motion.trajectory import default_limits, time_path
from planner.path import Bottleneck, NoPath
from planner.path import Path as PlannedPath
from planner.roadmap.curves import curves_of, followed
from planner.roadmap.roadmap import Roadmap, build_roadmap
from planner.scene import Scene
from planner.shared.figures import sized

PIXELS = """\
#@ clearway.scene/1
#@ units px
#@ bounds given 0 0 200 100
#@ object 0
L 4 (20,20)(80,20)(80,80)(20,80)
#@ hole
L 4 (40,40)(40,60)(60,60)(60,40)
#@ object 1
A 2 (120,20)(120,60)
#@ arc 1 120 40 20 cw
#@ object 2
L 2 (150,50)(190,50)
#@ arc 1 170 50 20 cw
#@ arc 2 170 50 20 cw
#@ object 3
P (110,90)
#@ object 4
S (130,85) (180,85)
"""
METRES = PIXELS.replace("units px", "units m")
SVG = "{http://www.w3.org/2000/svg}"


def pixel(image: np.ndarray, scene: Scene, x: float, y: float) -> tuple[int, int, int]:
    """Colour (RGB) at a place of the scene that fills the plot."""
    scale = min(1000 / scene.bounds.width, 760 / scene.bounds.height)
    down = y - scene.bounds.y_min if scene.y_down else scene.bounds.y_max - y
    column = MARGIN + (x - scene.bounds.x_min) * scale
    b, g, r = image[round(MARGIN + down * scale), round(column)]
    return int(r), int(g), int(b)


def near(colour: tuple[int, int, int], wanted: tuple[int, int, int]) -> bool:
    return max(abs(a - b) for a, b in zip(colour, wanted, strict=True)) < 40


@pytest.fixture(scope="module")
def arena() -> tuple[Scene, Roadmap, PlannedPath]:
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 4 3\nC (2,1.2) 0.5\n"
    )
    roadmap = build_roadmap(scene, 0.2)
    path = roadmap.plan((0.5, 0.5), (3.5, 0.5, math.pi / 2))
    assert isinstance(path, PlannedPath)
    return scene, roadmap, path


@pytest.mark.parametrize("text", [PIXELS, METRES])
def test_obstacles_are_dark_holes_and_floor_are_light(text):
    scene = read_scene_text(text)
    image = draw_png(scene)
    for x, y in [(30, 30), (70, 70), (170, 45), (170, 55), (155, 50), (160, 85), (110, 90)]:
        assert near(pixel(image, scene, x, y), OBSTACLE), (x, y)
    for x, y in [(50, 50), (10, 10), (100, 50), (152, 33), (188, 67)]:
        assert near(pixel(image, scene, x, y), FLOOR), (x, y)


def test_an_arc_bulges_to_its_own_side_whichever_way_y_points():
    # from (120, 20) to (120, 60) clockwise on the screen: with y down from the upper end to
    # the right; with y up from the lower end to the left
    for text, x in ((PIXELS, 140), (METRES, 100)):
        scene = read_scene_text(text)
        image = draw_png(scene)
        assert near(pixel(image, scene, x, 40), OBSTACLE)
        assert near(pixel(image, scene, 240 - x, 40), FLOOR)


def test_y_points_up_in_metres_and_down_in_pixels():
    for text, light_y in ((PIXELS, 95), (METRES, 95)):
        scene = read_scene_text(text)
        image = draw_png(scene)
        assert near(pixel(image, scene, 50, light_y), FLOOR)
    top = draw_png(read_scene_text(METRES))[MARGIN + 25, MARGIN + 25 * 5]
    assert near(tuple(int(v) for v in top[::-1]), FLOOR)


def test_replaced_plans_are_drawn_pale_and_named(arena):
    scene, roadmap, path = arena
    earlier = [np.array([[0.3, 2.9], [1.3, 2.9]])]
    image = draw_png(scene, roadmap, path, earlier=earlier)
    assert near(pixel(image, scene, 0.8, 2.9), OTHER_PATH)
    assert not near(pixel(draw_png(scene, roadmap, path), scene, 0.8, 2.9), OTHER_PATH)
    assert "replaced plans (1), 1 m" in draw_svg(scene, roadmap, path, earlier=earlier)


def test_path_track_and_bottleneck_are_drawn_where_they_are(arena):
    scene, roadmap, path = arena
    track = np.array([[0.5, 0.5], [0.5, 2.8], [3.5, 2.8]])
    image = draw_png(scene, roadmap, path, track=track)
    middle = path.points[: len(path.points) // 2 + 1].mean(axis=0)
    on_path = path.points[np.argmin(np.hypot(*(path.points - middle).T))]
    assert near(pixel(image, scene, *on_path), PATH)
    assert near(pixel(image, scene, 2.0, 2.8), TRACK)
    assert near(pixel(image, scene, *path.min_clearance_at), BOTTLENECK)
    plain = draw_png(scene)
    assert not near(pixel(plain, scene, 2.0, 2.8), TRACK)


def test_a_track_breaks_where_the_robot_did_not_drive(arena):
    scene, roadmap, path = arena
    track = np.array([[0.5, 2.8], [1.5, 2.8], [np.nan, np.nan], [2.5, 2.8], [3.5, 2.8]])
    other = OtherRobot("robot 8", 0.15, np.c_[track - [0.0, 0.2], np.zeros(5)])
    image = draw_png(scene, roadmap, path, track=track, others=[other])
    for y in (2.8, 2.6):
        drawn = [
            not near(pixel(image, scene, x, y), pixel(image, scene, 2.0, 2.7))
            for x in (1.0, 2.0, 3.0)
        ]
        assert drawn == [True, False, True], y
    assert "driven track, 2 " in draw_svg(scene, roadmap, path, track=track)


def test_the_svg_has_a_layer_for_everything_and_nothing_from_outside(arena):
    scene, roadmap, path = arena
    trajectory = time_path(path, default_limits(0.2))
    svg = draw_svg(
        scene,
        roadmap,
        path,
        trajectory=trajectory,
        track=path.points,
        stations=[(0.5, 0.5), (3.5, 0.5, math.pi / 2)],
        title="A < B & C",
    )
    root = ET.fromstring(svg)
    layers = {g.get("id"): g for g in root.iter(f"{SVG}g")}
    assert list(layers) == [
        "floor",
        "corridor",
        "obstacles",
        "bounds",
        "roadmap",
        "path",
        "driven-track",
        "waypoints",
        "bottleneck",
        "numbers",
        "stations",
        "legend",
    ]
    assert len(layers["waypoints"].findall(f"{SVG}circle")) == len(trajectory.waypoints)
    words = [t.text for t in root.iter(f"{SVG}text")]
    assert {"start", "goal", "A < B & C"} <= set(words)
    assert any("bottleneck" in str(w) for w in words)
    assert any("robot radius 0.2 m" in str(w) for w in words)
    assert "href" not in svg
    assert "script" not in svg
    assert "nan" not in svg.lower()


def test_the_colour_ramp_runs_from_tight_to_wide_and_is_told_apart():
    colours = [ramp_colour(step) for step in range(RAMP_STEPS)]
    assert colours[0] == CLEARANCE_RAMP[0]
    assert colours[-1] == CLEARANCE_RAMP[-1]
    assert len(set(colours)) == RAMP_STEPS


def test_the_roadmap_is_coloured_by_clearance(arena):
    scene, roadmap, _ = arena
    root = ET.fromstring(draw_svg(scene, roadmap))
    (layer,) = [g for g in root.iter(f"{SVG}g") if g.get("id") == "roadmap"]
    used = {p.get("stroke") for p in layer.findall(f"{SVG}path")}
    assert len(used) > 5
    assert used <= {"#{:02x}{:02x}{:02x}".format(*ramp_colour(s)) for s in range(RAMP_STEPS)}


def test_a_missing_path_is_explained(arena):
    scene, roadmap, _ = arena
    answer = NoPath("the goal lies inside obstacle 0", Bottleneck(1.0, 1.0, 0.3), 0.15)
    words = [t.text for t in ET.fromstring(draw_svg(scene, roadmap, answer)).iter(f"{SVG}text")]
    assert "no path: the goal lies inside" in words
    assert "widest robot: radius 0.15 m" in words
    assert "bottleneck, 0.3 m wide" in words


def test_a_small_island_of_free_space_fills_the_picture():
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ bounds given 0 0 1000 1000\n#@ object 0\n"
        "L 4 (2,2)(998,2)(998,998)(2,998)\n#@ hole\n"
        "L 4 (100,100)(100,200)(300,200)(300,100)\n"
    )
    roadmap = build_roadmap(scene, 5.0)
    window_wide = draw_png(scene).shape
    image = draw_png(scene, roadmap, stations=[(120, 150), (280, 150)])
    assert image.shape != window_wide
    dark = np.all(np.abs(image.astype(int) - OBSTACLE[::-1]) < 30, axis=2).mean()
    assert dark < 0.6


def test_what_lies_outside_the_plot_does_not_spill_over_the_legend(arena):
    scene, roadmap, _ = arena
    track = np.array([[2.0, 2.8], [30.0, 2.8]])
    image = draw_png(scene, roadmap, track=track)
    plot_right = MARGIN + round(4 * min(250, 760 / 3)) + 4
    violet = np.all(np.abs(image[:, plot_right:].astype(int) - TRACK[::-1]) < 40, axis=2)
    # the legend's own mark is 28 pixels long
    assert violet.any(axis=0).sum() <= 32


def test_pictures_are_saved_by_their_suffix(tmp_path: Path, arena):
    scene, roadmap, path = arena
    save_picture(tmp_path / "a.svg", scene, roadmap, path)
    save_picture(tmp_path / "a.PNG", scene, roadmap, path)
    assert (tmp_path / "a.svg").read_text(encoding="utf-8") == draw_svg(scene, roadmap, path)
    np.testing.assert_array_equal(
        cv2.imread(str(tmp_path / "a.PNG")), draw_png(scene, roadmap, path)
    )
    with pytest.raises(DrawError, match=r"\.svg or \.png"):
        save_picture(tmp_path / "a.gif", scene)
    with pytest.raises(DrawError, match="No such file"):
        save_picture(tmp_path / "none" / "a.svg", scene)


def test_an_empty_scene_is_a_picture_too():
    scene = read_scene_text("#@ clearway.scene/1\n#@ bounds given 0 0 1 1000\n")
    assert draw_png(scene).shape[2] == 3
    ET.fromstring(draw_svg(scene, build_roadmap(scene, 0.2)))


def test_another_robot_is_drawn_where_it_was_last_with_its_track_and_name(
    arena: tuple[Scene, Roadmap, PlannedPath],
) -> None:
    scene, roadmap, path = arena
    track = np.array([(0.4, 2.6, 0.0), (1.0, 2.6, 0.0), (1.0, 2.2, -math.pi / 2)])
    other = OtherRobot("robot 8", 0.15, track)
    image = draw_png(scene, others=[other])
    plain = draw_png(scene)
    assert near(pixel(image, scene, 0.7, 2.6), OTHER_ROBOT)
    assert near(pixel(image, scene, 1.0, 2.2 + 0.15), OTHER_ROBOT), "the rim of its body"
    assert near(pixel(image, scene, 1.0, 2.2 - 0.1), OTHER_ROBOT), "where it looks"
    assert pixel(image, scene, 0.4, 2.4) == pixel(plain, scene, 0.4, 2.4)
    svg = draw_svg(scene, roadmap, path, others=[other])
    assert "robot 8" in svg
    assert "other robots (1), as seen last" in svg
    never_seen = OtherRobot("robot 9", 0.15, np.empty((0, 3)))
    assert draw_svg(scene, others=[never_seen]) == draw_svg(scene)


def words_of(svg: str, layer: str) -> list[tuple[str, float, float]]:
    """The words of a layer and where they are."""
    root = ET.fromstring(svg)
    (group,) = (g for g in root.iter(f"{SVG}g") if g.get("id") == layer)
    return [
        (text.text or "", float(text.get("x", "nan")), float(text.get("y", "nan")))
        for text in group.iter(f"{SVG}text")
    ]


def test_every_obstacle_bears_the_number_that_messages_name_it_by():
    scene = read_scene_text(PIXELS)
    numbers = words_of(draw_svg(scene), "numbers")
    assert [text for text, _, _ in numbers] == ["0", "1", "2", "3", "4"]
    scale = min(1000 / scene.bounds.width, 760 / scene.bounds.height)
    x, y = ((v - MARGIN) / scale for v in numbers[0][1:])
    assert 20 < x < 80, "obstacle 0 has room for its number"
    assert 20 < y < 80
    assert not (40 < x < 60 and 40 < y < 60), "in the solid, not in its hole"


def test_of_thousands_of_obstacles_only_those_with_room_bear_their_number():
    circles = "".join(f"C ({5 * i},{5 * k}) 1\n" for i in range(1, 30) for k in range(1, 30))
    text = f"#@ clearway.scene/1\n#@ bounds given 0 0 400 200\n{circles}C (300,100) 60\n"
    numbers = words_of(draw_svg(read_scene_text(text)), "numbers")
    assert [number for number, _, _ in numbers] == ["841"]


def test_alternatives_bear_their_cost(arena):
    scene, roadmap, _ = arena
    path = roadmap.plan((0.5, 0.5), (3.5, 0.5), alternatives=1)
    svg = draw_svg(scene, roadmap, path)
    (other,) = path.alternatives
    assert f"1: cost {sized(other.cost, 'm')}" in [text for text, _, _ in words_of(svg, "numbers")]
    assert f"path, {sized(path.length, 'm')}, cost {sized(path.cost, 'm')}" in svg


def test_the_roadmap_of_a_picture_is_that_of_the_graph(arena):
    _, roadmap, _ = arena
    curves = curves_of(roadmap)
    assert curves is not None
    drawn = followed(roadmap, curves, 1e-4)
    assert len(curves.first) - 1 >= roadmap.graph.number_of_edges()
    lengths = np.hypot(*np.diff(drawn.points, axis=0).T)
    lengths[drawn.first[1:-1] - 1] = 0.0  # from line to line
    wanted = sum(data["length"] for _, _, data in roadmap.graph.edges(data=True))
    assert lengths.sum() == pytest.approx(wanted, rel=1e-2)
    np.testing.assert_allclose(drawn.clearances, roadmap.clearance(drawn.points), atol=1e-9)
    least = min(data["clearance"] for _, _, data in roadmap.graph.edges(data=True))
    assert curves.narrowest == pytest.approx(least)
