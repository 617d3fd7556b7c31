"""Warming up: every kernel of a run is compiled before the robot may move, and that is said."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from navigation.config import load_config
from navigation.run.kernels import warm_up
from navigation.run.kernels.compiling import compile_parts

pytestmark = pytest.mark.slow

CONFIG = load_config(Path(__file__).parents[4] / "configs" / "simulation.yaml", environment={})


def test_with_compiled_kernels_nothing_is_said() -> None:
    warm_up.compile_planner()
    said: list[str] = []
    warm_up.warm_up(CONFIG, said.append)
    assert said == []


def test_without_them_it_is_said_and_two_processes_compile(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(warm_up, "kernels_are_cold", lambda: True)
    said: list[str] = []
    warm_up.warm_up(CONFIG, said.append)
    assert said[0].startswith("compiling the kernels")
    assert re.fullmatch(r"  \d+ kernels compiled after \d+ s", said[-1])


def test_a_process_that_cannot_compile_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = {"eye": (sys.exit, (3,)), "planner": (sys.exit, (3,))}
    monkeypatch.setattr(warm_up, "kernels_are_cold", lambda: True)
    monkeypatch.setattr(warm_up, "compile_kernels", lambda _: compile_parts(parts))
    said: list[str] = []
    warm_up.warm_up(CONFIG, said.append)
    assert any("not compiled: it is done here" in line for line in said)


COLD = "from navigation.run.kernels.warm_up import kernels_are_cold; print(kernels_are_cold())"


@pytest.mark.parametrize(
    ("environment", "cold"),
    [({}, False), ({"NUMBA_CACHE_DIR": "{empty}"}, True), ({"NUMBA_CPU_NAME": "nocona"}, True)],
    ids=["compiled", "empty cache", "compiled for another processor"],
)
def test_kernels_are_cold_where_they_would_be_compiled(
    environment: dict[str, str], cold: bool, tmp_path: Path
) -> None:
    warm_up.warm_up(CONFIG, print)
    variables = {name: text.format(empty=tmp_path) for name, text in environment.items()}
    told = subprocess.run(
        [sys.executable, "-c", COLD],
        env={**os.environ, **variables},
        cwd=Path(__file__).parents[4],
        capture_output=True,
        text=True,
    )
    assert told.stdout.strip() == str(cold), told.stderr


@pytest.mark.parametrize("polarity", ["dark", "light"])
def test_in_the_drawn_arena_a_third_obstacle_comes_and_goes(polarity: str) -> None:
    vision = CONFIG.vision.model_copy(update={"polarity": polarity})
    scenes = warm_up._see(vision, CONFIG.robot)
    assert [len(scene.objects) for scene in scenes] == [2, 3, 2]


KERNELS_LOADED_LATE = """
import sys
from numba.extending import is_jitted
from navigation.run.virtual_run import run_virtually
from navigation.run.kernels.warm_up import warm_up
from tests.support.runs.virtual import short_config

def loaded():
    kernels = [module for name, module in sys.modules.items() if name.endswith("_kernels")]
    functions = [f for module in kernels for f in vars(module).values()]
    return {
        f"{f.py_func.__module__}.{f.py_func.__name__}{signature}"
        for f in functions if is_jitted(f) for signature in f.signatures
    }

config = short_config(
    [{"x_m": 0.15, "y_m": 1.15}, {"x_m": 0.20, "y_m": 0.80}, {"x_m": 0.20, "y_m": 1.60}],
    mission={"order": "best"},
    simulation={"obstacles": [{"record": "C (0.10,1.50) 0.08", "from_s": 4.0, "until_s": 9.0}]},
)
warm_up(config, print)
before = loaded()
report = run_virtually(config)
print(report.state, report.only.replans > 0, *sorted(loaded() - before), sep="\\n")
"""


def test_no_kernel_is_compiled_or_loaded_while_the_robot_drives() -> None:
    """Each would cost half a second just when an obstacle has come. In a process of its own."""
    told = subprocess.run(
        [sys.executable, "-c", KERNELS_LOADED_LATE],
        cwd=Path(__file__).parents[4],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert told.returncode == 0, told.stderr
    assert told.stdout.split("\n")[-3:] == ["done", "True", ""], told.stdout
