"""Warming up: every kernel of a run is compiled before the robot may move, and that is said."""

from pathlib import Path

import pytest

from navigation import warm_up
from navigation.config import load_config

CONFIG = load_config(Path(__file__).parents[2] / "configs" / "simulation.yaml", environment={})


def test_with_compiled_kernels_nothing_is_said() -> None:
    warm_up.compile_planner()
    said: list[str] = []
    warm_up.warm_up(CONFIG, said.append)
    assert said == []


def test_without_them_it_is_said_and_a_second_process_helps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    started: list[list[str]] = []

    class Beside:
        def __init__(self, command: list[str]) -> None:
            started.append(command)

        def wait(self) -> int:
            return 0

        def kill(self) -> None:
            pass

    monkeypatch.setattr(warm_up, "kernels_are_cold", lambda: True)
    monkeypatch.setattr(warm_up.subprocess, "Popen", Beside)
    said: list[str] = []
    warm_up.warm_up(CONFIG, said.append)
    assert len(started) == 1
    assert "compile_planner" in started[0][-1]
    assert len(said) == 3


def test_an_empty_cache_is_cold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert warm_up.kernels_are_cold()
    (tmp_path / "planner_x").mkdir()
    (tmp_path / "planner_x" / "insertion_kernels.diagram-1.py311.nbi").touch()
    assert not warm_up.kernels_are_cold()


@pytest.mark.parametrize("polarity", ["dark", "light"])
def test_the_drawn_arena_shows_a_robot_and_obstacles(polarity: str) -> None:
    vision = CONFIG.vision.model_copy(update={"polarity": polarity})
    scene = warm_up._see(CONFIG.model_copy(update={"vision": vision}))
    assert len(scene.objects) == 2
