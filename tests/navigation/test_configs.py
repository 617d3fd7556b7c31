"""Every file in configs/ can be used, and shows what it promises."""

from __future__ import annotations

from pathlib import Path

import pytest

from navigation.cli.check import file_problems
from navigation.config import load_config
from navigation.simulator.arena import load_arena
from planner.scene_io import load_scene

CONFIGS = Path(__file__).parents[2] / "configs"
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
    assert config.simulation.time_limit_s <= 60
