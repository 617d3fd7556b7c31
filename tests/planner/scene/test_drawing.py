"""Scenes, roadmaps and paths show themselves: as SVG, and on Matplotlib axes."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import planner
from planner.path import Path
from planner.scene import Arc, ArcRecord, Bounds, PolygonRecord, Scene, SceneObject, Segment
from planner.scene.drawing import MARGIN, WIDTH_PX, obstacle_layers

TEXT = """#@ clearway.scene/1
#@ units {units}
#@ bounds given 0 0 100 50
C (30,25) 10
S (60,5) (60,20)
P (80,30)
A 3 (70,40) (75,45) (85,40)
"""


def scene(units: str) -> Scene:
    return planner.read_scene_text(TEXT.format(units=units))


def places(svg: str) -> list[np.ndarray]:
    """The coordinates of each path element, in pixels."""
    root = ElementTree.fromstring(svg)
    found = []
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        numbers = [float(n) for n in re.findall(r"[-\d.]+", path.attrib["d"])]
        found.append(np.reshape(numbers, (-1, 2)))
    return found


@pytest.mark.parametrize(("units", "from_top"), [("px", 5.0), ("m", 30.0)])
def test_y_grows_as_the_scene_says(units: str, from_top: float) -> None:
    # the segment's upper end on the screen: y = 5 of 50 downwards, or y = 20 upwards
    left = MARGIN * WIDTH_PX
    scale = (WIDTH_PX - 2.0 * left) / 100.0
    drawn = places(scene(units)._repr_svg_())
    upper = min(y for path in drawn for x, y in path if abs(x - left - 60.0 * scale) < 0.2)
    assert (upper - left) / scale == pytest.approx(from_top, abs=0.1)


def test_a_drawn_circle_lies_on_its_circle() -> None:
    shown = scene("px")
    circle = obstacle_layers(shown.objects, shown.view, True)[0].lines[0]
    distance = np.hypot(circle[:, 0] - 30.0, circle[:, 1] - 25.0)
    assert np.allclose(distance, 10.0)
    assert len(circle) > 100


@pytest.mark.parametrize("y_down", [True, False])
def test_a_drawn_arc_bulges_to_its_own_side(y_down: bool) -> None:
    edges = (
        Segment((0.0, 0.0), (10.0, 0.0)),
        Arc((10.0, 0.0), (0.0, 0.0), (5.0, 0.0), 5.0, ccw=not y_down),
    )
    (layer, _) = obstacle_layers([SceneObject(0, (PolygonRecord(edges),))], (0, 0, 10, 10), y_down)
    assert layer.lines[0][:, 1].max() == pytest.approx(5.0, abs=0.01)
    assert layer.lines[0][:, 1].min() == 0.0


@pytest.mark.parametrize("sweep_deg", [0.5, 2.9, 3.1, 5.9, 6.1, 45.0, 200.0, 359.0])
def test_a_drawn_arc_leaves_its_arc_by_a_2500th_of_the_radius(sweep_deg: float) -> None:
    end = math.radians(sweep_deg)
    radius, center = 20.0, (3.0, -1.0)
    ends = [
        (center[0] + radius * math.cos(a), center[1] + radius * math.sin(a)) for a in (0.0, end)
    ]
    arc = ArcRecord((Arc(ends[0], ends[1], center, radius, ccw=True),))
    (layer,) = obstacle_layers([SceneObject(0, (arc,))], (-30, -30, 30, 30), False)
    (line,) = layer.lines
    share = np.linspace(0.0, 1.0, 101)[:, None, None]
    along = ((1.0 - share) * line[:-1] + share * line[1:]).reshape(-1, 2)
    off = radius - np.hypot(*(along - center).T)
    assert off.max() <= 0.0004 * radius
    assert off.min() >= -1e-9


def test_a_roadmap_and_a_path_show_what_is_below_them() -> None:
    roadmap = planner.build_roadmap(scene("px"), 2.0)
    path = roadmap.plan((5, 5), (95, 45), alternatives=1)
    assert isinstance(path, Path)
    below = len(places(scene("px")._repr_svg_()))
    assert len(places(roadmap._repr_svg_() or "")) == below + 1
    assert len(places(path._repr_svg_() or "")) == below + 1 + bool(path.alternatives)
    assert replace(path, scene=None) == path


def test_an_empty_scene_is_its_walls() -> None:
    (walls,) = places(Scene("px", Bounds(0.0, 0.0, 10.0, 10.0), ())._repr_svg_())
    assert len(walls) == 5


def test_on_axes_pictures_hang_the_right_way_up() -> None:
    figure = pytest.importorskip("matplotlib.figure")
    for units, inverted in (("px", True), ("m", False)):
        axes = figure.Figure().subplots()
        assert scene(units).plot(axes) is axes
        assert bool(axes.yaxis_inverted()) is inverted
        assert axes.get_xlim()[1] >= 100.0
        roadmap = planner.build_roadmap(scene(units), 2.0)
        lines = len(axes.lines)
        roadmap.plot(axes)
        path = roadmap.plan((5, 5), (95, 45))
        assert isinstance(path, Path)
        path.plot(axes)
        assert len(axes.lines) > lines + 2
        assert bool(axes.yaxis_inverted()) is inverted
