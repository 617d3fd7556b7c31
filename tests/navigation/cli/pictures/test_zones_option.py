"""`--zones` of the commands that plan: read in the scene's units, drawn, and refused in words."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from navigation.config.zone_file import ZoneError, read_zones
from planner.zones.areas import CircleArea, PolygonArea
from planner.zones.zone import Zone
from tests.navigation.cli.pictures.test_plan import ARENA, GOOD

ZONES = """\
- {name: desk, kind: keep_out, polygon: [[-1.8, 0.4], [-1.4, 0.4], [-1.6, 0.8]]}
- {name: bend, kind: slow, circle: [1.5, -0.5, 0.2], speed_m_s: 0.1}
"""
ROBOTS = "start_x,start_y,goal_x,goal_y,radius\n-1.5,-0.5,1.5,0.5,0.1\n1.5,-0.5,-1.5,0.5,0.1\n"


@pytest.fixture
def files(tmp_path: Path) -> Path:
    (tmp_path / "arena.txt").write_text(ARENA)
    (tmp_path / "zones.yaml").write_text(ZONES)
    (tmp_path / "robots.csv").write_text(ROBOTS)
    return tmp_path


def commands(folder: Path, picture: str) -> list[list[str]]:
    """Each command that takes zones, with its picture."""
    arena, out, render = (str(folder / name) for name in ("arena.txt", "out.json", picture))
    ends = ["--zones", str(folder / "zones.yaml"), "-o", out, "--render", render]
    robots = ["--robots", str(folder / "robots.csv")]
    return [
        ["plan", arena, *GOOD, *ends],
        ["roadmap", arena, "--radius", "0.1", *ends],
        ["fleet", arena, *robots, *ends],
    ]


@pytest.mark.parametrize("picture", ["picture.svg", "picture.png"])
@pytest.mark.parametrize("number", range(3), ids=["plan", "roadmap", "fleet"])
def test_zones_are_drawn(files: Path, number: int, picture: str) -> None:
    arguments = commands(files, picture)[number]
    assert run(arguments) == 0
    with_zones = (files / picture).read_bytes()
    (files / "zones.yaml").write_text("zones: []")
    assert run(arguments) == 0
    without = (files / picture).read_bytes()
    if picture.endswith(".svg"):
        assert b'id="zones"' in with_zones
        assert b">bend, 0.1 m/s<" in with_zones
        assert b'id="zones"' not in without
    else:
        one, other = (cv2.imdecode(np.frombuffer(b, np.uint8), 1) for b in (with_zones, without))
        assert one.shape[1] == other.shape[1]
        assert (one[: len(other)] != other[: len(one)]).any(axis=2).sum() > 1000


@pytest.mark.parametrize("number", range(3), ids=["plan", "roadmap", "fleet"])
def test_a_wrong_file_is_refused_before_anything_is_planned(
    files: Path, number: int, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = commands(files, "p.svg")[number]
    (files / "zones.yaml").write_text(ZONES.replace("slow", "fast"))
    assert run(arguments) == 2
    assert f"{files / 'zones.yaml'}:2:22: zones[1].kind" in capsys.readouterr().err
    (files / "zones.yaml").unlink()
    assert run(arguments) == 2
    assert "zones.yaml: No such file" in capsys.readouterr().err
    assert not (files / "out.json").exists()


def test_an_output_never_overwrites_the_zones(files: Path) -> None:
    zones = str(files / "zones.yaml")
    arguments = ["plan", str(files / "arena.txt"), *GOOD, "--zones", zones, "-o", zones]
    assert run(arguments) == 2
    assert (files / "zones.yaml").read_text() == ZONES


def test_pixels_beyond_a_thousand_are_places_too(tmp_path: Path) -> None:
    file = tmp_path / "zones.yaml"
    file.write_text(
        "zones:\n  - {name: a, kind: keep_out, circle: [1900, 1200, 80]}\n"
        "  - {name: b, kind: wait, polygon: [[1, 1], [3000, 1], [1, 2000]]}\n"
    )
    assert read_zones(file) == (
        Zone("a", "keep_out", CircleArea((1900.0, 1200.0), 80.0)),
        Zone("b", "wait", PolygonArea(((1.0, 1.0), (3000.0, 1.0), (1.0, 2000.0)))),
    )
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(ZoneError, match="UTF-8"):
        read_zones(file)
