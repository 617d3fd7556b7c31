"""Areas: exact distances against plain formulas, and what is refused."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from planner.scene import Bounds, Scene, SceneError, Units
from planner.zones.areas import Area, BandArea, CircleArea, PolygonArea
from planner.zones.zone import Zone, zones_for
from planner.zones.zone_ground import ZoneGround
from tests.planner.zones.plain_geometry import distances

STAR = tuple(
    (2.0 + r * math.cos(k * math.pi / 5), 1.0 + r * math.sin(k * math.pi / 5))
    for k, r in enumerate((0.8, 0.3) * 5)
)
AREAS: dict[str, Area] = {
    "circle": CircleArea((1.0, 0.7), 0.4),
    "square": PolygonArea(((0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5))),
    "square the other way round": PolygonArea(((0.5, 1.5), (1.5, 1.5), (1.5, 0.5), (0.5, 0.5))),
    "star": PolygonArea(STAR),
    "band": BandArea(((0.3, 0.3), (2.0, 1.5)), 0.3),
    "bent band": BandArea(((0.3, 0.3), (2.0, 0.4), (2.1, 1.6), (0.4, 1.5)), 0.5),
    "band that crosses itself": BandArea(((0.2, 0.2), (2.0, 1.6), (2.0, 0.2), (0.2, 1.6)), 0.2),
    "outside the bounds": CircleArea((9.0, 9.0), 0.4),
}


def ground_of(area: Area, units: Units = "m") -> ZoneGround:
    scene = Scene(units, Bounds(0.0, 0.0, 3.0, 2.0), ())
    return ZoneGround.of(Zone("a", "keep_out", area), scene)


@pytest.mark.parametrize("units", ["m", "px"])
@pytest.mark.parametrize("name", AREAS)
def test_distances_are_exact_outside_and_signed(name: str, units: Units) -> None:
    points = np.random.default_rng(1).uniform(-1.0, 3.5, (4000, 2))
    found, true = ground_of(AREAS[name], units).distances(points), distances(AREAS[name], points)
    assert (np.sign(found) == np.sign(true)).all()
    outside = true > 0.0
    assert found[outside] == pytest.approx(true[outside], abs=1e-12)
    # inside a band of several pieces the borders of the capsules are nearer
    assert (np.abs(found[~outside]) <= np.abs(true[~outside]) + 1e-12).all()


@pytest.mark.parametrize("name", AREAS)
def test_the_clearance_of_a_line_is_that_of_its_nearest_place(name: str) -> None:
    ground, rng = ground_of(AREAS[name]), np.random.default_rng(2)
    for _ in range(30):
        line = rng.uniform(0.0, 3.0, (3, 2))
        share = np.linspace(0.0, 1.0, 4001)[:, None]
        near = np.concatenate([a + share * (b - a) for a, b in pairwise(line)])
        least = max(float(distances(AREAS[name], near).min()), 0.0)
        assert ground.clearance(line) == pytest.approx(least, abs=2e-3)
        assert ground.clearance(line) <= least + 1e-12


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: CircleArea((0.0, 0.0), 0.0), "circle: radius = 0: must be > 0 and finite"),
        (lambda: CircleArea((0.0, math.nan), 1.0), "circle: all coordinates must be finite"),
        (lambda: BandArea(((1.0, 1.0), (1.0, 1.0)), 0.2), "1 different places"),
        (lambda: BandArea(((1.0, 1.0), (2.0, 1.0)), -0.2), "line: width = -0.2: must be > 0"),
        (lambda: PolygonArea(((0.0, 0.0), (1.0, 1.0))), "2 different vertices"),
        (lambda: PolygonArea(((0, 0), (1, 1), (1, 0), (0, 1))), "sides 0 and 2 cross"),
        (lambda: PolygonArea(((0, 0), (1, 1), (2, 2))), "its area is 0"),
    ],
)
def test_what_is_no_area_is_refused(make: Any, sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        make()


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"kind": "slow"}, "slow zone 'a': needs a speed"),
        ({"kind": "keep_out", "speed": 0.1}, "keep-out zone 'a': has no speed"),
        ({"kind": "slow", "speed": -1.0}, "speed = -1: must be > 0"),
        ({"kind": "lane"}, "lane 'a': needs a line with a width"),
        ({"kind": "one_way"}, "one-way zone 'a': needs a line"),
        ({"kind": "wait", "cost": 0.5}, "no-waiting zone 'a': has no cost"),
        ({"kind": "lane", "area": AREAS["band"], "cost": 2.0}, "cost = 2: must be from 0.05 to 1"),
        ({"kind": "slow", "speed": 1.0, "name": "\n"}, "must be printable text"),
    ],
)
def test_what_does_not_fit_a_zone_is_refused(keys: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        Zone(**{"name": "a", "area": AREAS["circle"], **keys})


def test_zones_hold_for_all_robots_or_for_those_named() -> None:
    all_, some = (Zone(n, "wait", AREAS["circle"], r) for n, r in (("a", ()), ("b", ("ada",))))
    assert zones_for([all_, some], "ada") == (all_, some)
    assert zones_for([all_, some], "bob") == (all_,)
    assert zones_for([all_, some], "") == (all_,)
