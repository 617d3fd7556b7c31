"""Zones in a picture: each where it is, in its colour, with its name, the same in SVG and PNG."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from navigation.draw import draw_png, draw_svg
from navigation.draw.shapes import FLOOR, Screen
from navigation.draw.zones import COLOURS, zone_shapes
from planner.scene import Bounds, Scene
from planner.zones.areas import Area, BandArea, CircleArea, MaskArea, PolygonArea
from planner.zones.zone import KIND_NAMES, Zone
from tests.navigation.draw.test_draw import near, pixel, words_of

SQUARE = PolygonArea(((1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)))
BAND = BandArea(((1.0, 1.0), (3.0, 1.0), (3.0, 3.0)), 0.8)
BOTH = pytest.mark.parametrize("units", ["m", "px"])


def floor(units: str = "m") -> Scene:
    return Scene.from_polygons([], bounds=Bounds(0.0, 0.0, 6.0, 4.0), units=units)


def share_of_colour(zone: Zone, scene: Scene, low: tuple[float, float], size: float) -> float:
    """Share of the places of a square that are not the bare floor."""
    image = draw_png(scene, zones=[zone])
    steps = np.linspace(0.0, size, 20).tolist()
    places = [(low[0] + dx, low[1] + dy) for dx, dy in itertools.product(steps, steps)]
    return sum(pixel(image, scene, *place) != FLOOR for place in places) / len(places)


@BOTH
@pytest.mark.parametrize(
    ("area", "inside", "outside"),
    [
        (SQUARE, (1.2, 1.2), (4.0, 1.2)),
        (CircleArea((2.0, 2.0), 1.0), (1.6, 1.6), (3.1, 3.1)),
        (BAND, (2.8, 2.0), (1.4, 2.2)),
        (MaskArea(SQUARE.outlines(y_down=False)), (1.2, 1.2), (4.0, 1.2)),
    ],
)
def test_an_area_is_tinted_where_it_is_and_nowhere_else(
    units: str, area: Area, inside: tuple[float, float], outside: tuple[float, float]
) -> None:
    zone, scene = Zone("a", "keep_out", area), floor(units)
    assert share_of_colour(zone, scene, inside, 0.3) > 0.95
    assert share_of_colour(zone, scene, outside, 0.3) == 0.0


def test_each_kind_has_its_own_colour() -> None:
    assert set(COLOURS) == set(KIND_NAMES)
    for one, other in itertools.combinations(COLOURS.values(), 2):
        assert math.dist(one, other) > 60.0


def test_a_band_is_one_area_with_one_edge() -> None:
    """No edge is inside it: away from its rim there is only the fill, the same at a bend."""
    scene = floor()
    image = draw_png(scene, zones=[Zone("a", "slow", BAND, speed=0.1)]).astype(int)
    plain = pixel(image, scene, 1.5, 1.15)
    for place in [(3.0, 0.85), (2.8, 1.2), (3.2, 1.2), (2.9, 2.0)]:
        assert near(pixel(image, scene, *place), plain)


def test_keep_out_and_no_waiting_are_hatched_the_two_ways_round() -> None:
    screen = Screen(Bounds(0.0, 0.0, 6.0, 4.0), False, 100.0, 0.0, 0.0)

    def slopes(kind: str) -> set[int]:
        zone = Zone("a", kind, SQUARE)  # type: ignore[arg-type]
        *_, hatching = zone_shapes([zone], screen)
        ends = [line[1] - line[0] for line in hatching.lines if len(line) == 2]  # type: ignore[union-attr]
        assert len(ends) > 10
        for line in hatching.lines:  # type: ignore[union-attr]
            assert (line >= 100.0 - 1e-6).all()
            assert (line <= 300.0 + 1e-6).all()
        return {round(math.degrees(math.atan2(dy, dx))) for dx, dy in ends}

    assert slopes("keep_out") == {45}
    assert slopes("wait") == {-45}


@BOTH
def test_arrows_point_along_a_one_way_line(units: str) -> None:
    screen = Screen(Bounds(0.0, 0.0, 6.0, 4.0), units == "px", 100.0, 0.0, 0.0)
    *_, arrows = zone_shapes([Zone("a", "one_way", BAND)], screen)
    line = screen.points(BAND.line)
    first, last = line[1] - line[0], line[2] - line[1]
    for barb in arrows.lines:  # type: ignore[union-attr]
        tip, back = barb[1], 0.5 * (barb[0] + barb[2])
        along = first if np.allclose(tip[1], line[0][1]) else last
        assert float((tip - back) @ along) > 0.0
    assert len(arrows.lines) >= 4  # type: ignore[union-attr]


def test_names_speeds_and_robots_are_written_and_the_legend_counts_kinds() -> None:
    zones = [
        Zone("desk", "keep_out", SQUARE),
        Zone("bend", "slow", CircleArea((5.0, 1.0), 0.8), speed=0.12),
        Zone("road", "lane", BandArea(((0.5, 3.5), (5.5, 3.5)), 0.4), ("ada",)),
        Zone("shelf", "keep_out", CircleArea((5.0, 3.0), 0.05)),
    ]
    svg = draw_svg(floor(), zones=zones)
    assert [text for text, *_ in words_of(svg, "zone-names")] == [
        "desk", "bend, 0.12 m/s", "road (ada)", "shelf",
    ]  # fmt: skip
    legend = [text for text, *_ in words_of(svg, "legend")]
    assert {"keep-out zones (2)", "slow zone (1)", "lane (1)"} <= set(legend)
    assert not any("one-way" in text for text in legend)


def test_a_picture_without_zones_is_as_it_was() -> None:
    assert draw_svg(floor(), zones=[]) == draw_svg(floor())
    assert 'id="zones"' not in draw_svg(floor())


def test_the_legend_of_every_kind_fits_onto_the_page() -> None:
    line = BandArea(((0.5, 3.5), (5.5, 3.5)), 0.4)
    zones = [
        Zone("a", "keep_out", line), Zone("b", "slow", line, speed=1.0), Zone("c", "one_way", line),
        Zone("d", "lane", line), Zone("e", "wait", line),
    ]  # fmt: skip
    flat = Scene.from_polygons([], bounds=Bounds(0.0, 3.0, 6.0, 4.0), units="m")
    svg = draw_svg(flat, zones=zones)
    height = float(svg.split('height="', 1)[1].split('"', 1)[0])
    *rows, scale = [y for _, _, y in words_of(svg, "legend")]
    assert max(rows) < scale < height
