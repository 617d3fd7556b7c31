"""Every file in configs/ can be used, and shows what it promises."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from navigation.cli.setup.check import file_problems
from navigation.config import load_config
from navigation.simulator.arena import load_arena
from navigation.simulator.picture.pinhole import pinhole_of
from planner.formats.scene_io import load_scene
from vision.calibration.calibration_file import load_calibration

CONFIGS = Path(__file__).parents[3] / "configs"
RUNS = sorted(
    file
    for file in CONFIGS.glob("*.yaml")
    if "schema: clearway.calibration" not in file.read_text()
)
ARENAS = sorted(CONFIGS.glob("arenas/*.txt"))


def test_there_are_configurations_and_arenas() -> None:
    assert CONFIGS / "simulation.yaml" in RUNS
    assert ARENAS


@pytest.mark.parametrize("file", RUNS, ids=lambda file: file.name)
def test_each_configuration_loads_with_all_its_files(file: Path) -> None:
    assert list(file_problems(load_config(file, {}))) == []


@pytest.mark.parametrize("file", ARENAS, ids=lambda file: file.name)
def test_each_arena_is_a_scene_in_metres(file: Path) -> None:
    scene = load_scene(file)
    assert scene.units == "m"
    assert len(scene.objects) >= 6


def test_the_simulated_run_is_as_large_as_promised() -> None:
    config = load_config(CONFIGS / "simulation.yaml", {})
    x0, y0, x1, y1 = config.arena.bounds_m
    assert (x1 - x0, y1 - y0) == (2.4, 1.8)
    assert len(load_arena(config).scene.objects) >= 6
    assert config.camera.rate_hz == 30
    assert config.simulation is not None
    assert config.simulation.time_limit_s <= 90


@pytest.mark.parametrize("height_m", [0.0, 0.12])
def test_the_estimated_calibration_is_near_the_simulated_camera_s_truth(height_m: float) -> None:
    """Fails too where the simulated camera was changed and not calibrated again."""
    config = load_config(CONFIGS / "simulation.yaml", {})
    assert config.camera.calibration is not None
    x, y = np.meshgrid(np.linspace(0, 2.4, 25), np.linspace(0, 1.8, 19))
    places = np.column_stack([x.ravel(), y.ravel()])
    seen = pinhole_of(config).image_from_arena(places, height_m)
    found = load_calibration(config.camera.calibration).arena_from_image(seen, height_m)
    errors_m = np.hypot(*(found - places).T)
    assert 0.0 < errors_m.mean() < 0.3e-3
    assert errors_m.max() < 1.0e-3
