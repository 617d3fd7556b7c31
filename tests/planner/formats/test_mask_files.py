"""Nav2's masks: cells mean what its map server and filters make of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from planner import Scene, SceneError, SpeedLevel, load_mask, load_speed_mask
from planner.formats.map_files import parse_map_header
from planner.formats.mask_files import cell_data


def write(folder: Path, cells: np.ndarray, mode: str, free: float, occupied: float) -> Path:
    rows, columns = cells.shape
    header = b"P5\n%d %d\n255\n" % (columns, rows)
    (folder / "mask.pgm").write_bytes(header + cells.astype(np.uint8).tobytes())
    (folder / "mask.yaml").write_text(
        f"image: mask.pgm\nmode: {mode}\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"
        f"occupied_thresh: {occupied}\nfree_thresh: {free}\n"
    )
    return folder / "mask.yaml"


def published(byte: int, mode: str, free: float, occupied: float, negate: bool) -> int:
    """The number that nav2_map_server publishes for a byte, from its documents, one by one."""
    if mode == "raw":
        return byte if byte <= 100 else -1
    p = byte / 255.0 if negate else (255.0 - byte) / 255.0
    if p >= occupied:
        return 100
    if p <= free:
        return 0
    if mode == "trinary":
        return -1
    return math.floor((p - free) / (occupied - free) * 100.0 + 0.5)


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize(
    ("mode", "free", "occupied"),
    [("scale", 0.0, 1.0), ("scale", 0.2, 0.7), ("trinary", 0.25, 0.65), ("raw", 0.0, 1.0)],
)
def test_every_byte_is_the_number_that_the_map_server_publishes(mode, free, occupied, negate):
    text = (
        f"image: a.pgm\nmode: {mode}\nresolution: 1\norigin: [0, 0, 0]\nnegate: {int(negate)}\n"
        f"free_thresh: {free}\noccupied_thresh: {occupied}\n"
    )
    shade = np.arange(256).reshape(16, 16) / 255.0
    data = cell_data(shade, np.zeros(shade.shape, bool), parse_map_header(text, "a.yaml"))
    wanted = [published(byte, mode, free, occupied, negate) for byte in range(256)]
    assert data.ravel().tolist() == wanted
    clear = cell_data(shade, np.ones(shade.shape, bool), parse_map_header(text, "a.yaml"))
    assert (clear == -1).all()


def test_limits_are_base_and_multiplier_times_the_number_and_none_where_nav2_has_none(tmp_path):
    cells = np.array([[0, 127, 191, 254, 255]])  # the numbers 100, 50, 25, 0 and 0
    levels = load_speed_mask(write(tmp_path, cells, "scale", 0.0, 1.0))
    assert [level.speed_percent for level in levels] == [50.0, 75.0]  # 0 is Nav2's NO_SPEED_LIMIT
    assert [level.area.objects[0].records[0].edges[0].start[0] for level in levels] == [-0.5, 0.0]
    path = write(tmp_path, cells, "scale", 0.0, 1.0)
    levels = load_speed_mask(path, percent=False, base=0.0, multiplier=0.02)
    assert [level.speed_m_s for level in levels] == [0.5, 1.0, 2.0]
    assert load_speed_mask(path, base=100.0, multiplier=1.0) == ()  # above 100 %
    assert load_speed_mask(path, percent=False, base=-3.0, multiplier=0.02) == ()


def test_occupied_cells_are_zones_and_unknown_ones_are_none(tmp_path):
    cells = np.array([[0, 205, 254, 0]])
    zones = load_mask(write(tmp_path, cells, "trinary", 0.25, 0.65))
    corners = [one.records[0].edges[0].start for one in zones.objects]
    assert corners == [(-1.0, 2.5), (0.5, 2.5)]


def test_senseless_limits_and_missing_files_are_refused(tmp_path):
    area = Scene.from_polygons(circles=[(1, 1, 0.5)], bounds=(0, 0, 2, 2))
    for wrong in ({}, {"speed_percent": 50.0, "speed_m_s": 1.0}):
        with pytest.raises(ValueError, match="must be one of them"):
            SpeedLevel(area, **wrong)
    for wrong, sentence in (
        ({"speed_percent": 101.0}, "percent = 101"),
        ({"speed_percent": 0.0}, "percent = 0"),
        ({"speed_m_s": -1.0}, "speed_m_s = -1: must be > 0"),
        ({"speed_m_s": math.inf}, "speed_m_s = inf"),
    ):
        with pytest.raises(ValueError, match=sentence):
            SpeedLevel(area, **wrong)
    with pytest.raises(SceneError, match="No such file"):
        load_speed_mask(tmp_path / "none.yaml")
    with pytest.raises(ValueError, match="multiplier = 0: must be finite and not 0"):
        load_speed_mask(tmp_path / "none.yaml", multiplier=0.0)
