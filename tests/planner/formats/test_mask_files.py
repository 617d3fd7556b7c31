"""Nav2's masks: cells mean what its map server and filters make of them, and are written so."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from planner import Scene, SceneError, SpeedLevel, load_mask, load_speed_mask, save_mask
from planner.formats.map_files import parse_map_header
from planner.formats.mask_files import cell_data
from planner.formats.pgm import parse_pgm


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


@pytest.mark.parametrize("seed", range(6))
def test_what_is_written_is_read_again_cell_by_cell(seed, tmp_path):
    rng = np.random.default_rng(seed)
    numbers = rng.choice([0, 1, 20, 50, 99], (7, 9))
    shades = np.rint(255 * (1 - numbers / 100))
    path = write(tmp_path, shades, "scale", 0.0, 1.0)
    levels = load_speed_mask(path)
    save_mask(levels, tmp_path / "again.yaml", 0.5)
    again = load_speed_mask(tmp_path / "again.yaml")
    assert [level.limit for level in again] == [level.limit for level in levels]
    assert [level.area.objects for level in again] == [level.area.objects for level in levels]
    pixels = parse_pgm((tmp_path / "again.pgm").read_bytes(), "again")
    np.testing.assert_array_equal(np.rint(255 * pixels), shades)
    zones = load_mask(write(tmp_path, np.where(numbers > 20, 0, 255), "trinary", 0.25, 0.65))
    save_mask(zones, tmp_path / "zones.yaml", 0.5)
    again = load_mask(tmp_path / "zones.yaml")
    assert again.objects == zones.objects
    assert again.bounds == zones.bounds


def test_areas_of_any_shape_cover_the_cells_that_they_reach_into_and_the_slowest_counts(tmp_path):
    bounds = (0.0, 0.0, 4.0, 2.0)
    wide = Scene.from_polygons([[(0.2, 0.2), (3.5, 0.2), (3.5, 0.9), (0.2, 0.9)]], bounds=bounds)
    disc = Scene.from_polygons(circles=[(2.5, 0.5, 0.2)], bounds=bounds)
    levels = [SpeedLevel(wide, 60.0), SpeedLevel(disc, 33.3)]
    save_mask(levels, tmp_path / "m.yaml", 1.0)
    pixels = np.rint(255 * parse_pgm((tmp_path / "m.pgm").read_bytes(), "m")).astype(int)
    # the upper row is free; of 33.3 % the next slower is 33 %
    assert pixels.tolist() == [[255] * 4, [153, 153, 84, 153]]
    assert [one.limit for one in load_speed_mask(tmp_path / "m.yaml")] == [33.0, 60.0]
    save_mask([SpeedLevel(disc, None, 0.75)], tmp_path / "m.yaml", 1.0, base=0.0, multiplier=0.02)
    (one,) = load_speed_mask(tmp_path / "m.yaml", percent=False, base=0.0, multiplier=0.02)
    assert one.speed_m_s == pytest.approx(0.74)


def test_senseless_masks_are_refused_with_the_limit(tmp_path):
    area = Scene.from_polygons(circles=[(1, 1, 0.5)], bounds=(0, 0, 2, 2))
    path = tmp_path / "m.yaml"
    with pytest.raises(SceneError, match="levels: must be at least one"):
        save_mask([], path, 0.1)
    with pytest.raises(SceneError, match="must all be in percent, or all in m/s"):
        save_mask([SpeedLevel(area, 50.0), SpeedLevel(area, None, 1.0)], path, 0.1)
    with pytest.raises(SceneError, match=r"a limit of 0\.001 m/s: must be base 0 \+ multiplier"):
        save_mask([SpeedLevel(area, None, 0.001)], path, 0.1, base=0.0, multiplier=0.02)
    with pytest.raises(SceneError, match=r"resolution = 0: must be > 0"):
        save_mask(area, path, 0.0)
    with pytest.raises(SceneError, match="in px"):
        save_mask(Scene.from_polygons(circles=[(1, 1, 0.5)], units="px"), path, 0.1)
    with pytest.raises(ValueError, match="multiplier = 0: must be finite and not 0"):
        save_mask(area, path, 0.1, multiplier=0.0)
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
