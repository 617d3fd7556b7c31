"""Zones as Nav2's masks: written, and read again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planner
from planner import Bounds, Scene, SceneError
from planner.zones.areas import BandArea, CircleArea, MaskArea, PolygonArea
from planner.zones.masks import save_keepout_mask, save_speed_mask, speed_zones
from planner.zones.zone import Zone
from planner.zones.zone_ground import ZoneGround
from tests.planner.zones.plain_geometry import distances

HALL = Scene("m", Bounds(0.0, 0.0, 4.0, 2.0), ())
CELL = 0.02
ZONES = (
    Zone("desk", "keep_out", CircleArea((1.0, 1.0), 0.4)),
    Zone("wall", "keep_out", PolygonArea(((2.5, 0.2), (3.5, 0.2), (3.0, 1.2)))),
    Zone("ramp", "slow", CircleArea((2.0, 1.5), 0.4), speed=0.2),
    Zone("road", "lane", BandArea(((0.5, 0.3), (2.0, 0.3)), 0.3), speed=0.4),
)


def test_keep_out_zones_come_back_to_a_cell(tmp_path: Path) -> None:
    save_keepout_mask(ZONES, HALL, tmp_path / "keepout.yaml", CELL)
    mask = planner.load_mask(tmp_path / "keepout.yaml")
    back = ZoneGround.of(Zone("back", "keep_out", MaskArea(mask.objects)), HALL)
    points = np.random.default_rng(1).uniform((0.0, 0.0), (4.0, 2.0), (3000, 2))
    true = np.minimum(*(distances(one.area, points) for one in ZONES[:2]))
    sure = np.abs(true) > CELL
    assert ((back.distances(points) < 0.0) == (true < 0.0))[sure].all()


def test_speeds_come_back_and_percent_need_the_robots_speed(tmp_path: Path) -> None:
    file = tmp_path / "speed.yaml"
    save_speed_mask(ZONES, HALL, file, CELL, base=0.0, multiplier=0.01)
    levels = planner.load_speed_mask(file, percent=False, base=0.0, multiplier=0.01)
    back = speed_zones(levels, "mask")
    assert [f"{one} {one.speed:.2f}" for one in back] == [
        "slow zone 'mask-1' 0.20",
        "slow zone 'mask-2' 0.40",
    ]
    for one, true in zip(back, ZONES[2:], strict=True):
        ground = ZoneGround.of(one, HALL)
        points = np.random.default_rng(2).uniform((0.0, 0.0), (4.0, 2.0), (2000, 2))
        apart = distances(true.area, points)
        sure = np.abs(apart) > 1.5 * CELL
        assert ((ground.distances(points) < 0.0) == (apart < 0.0))[sure].all()
    percent = [planner.SpeedLevel(levels[0].area, speed_percent=50.0)]
    assert speed_zones(percent, "half", robot_speed=0.3)[0].speed == pytest.approx(0.15)
    with pytest.raises(SceneError, match="robot_speed must be given"):
        speed_zones(percent, "half")
