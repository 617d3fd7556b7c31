"""Short missions of the real daemon in virtual time, for tests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld

CONFIGS = Path(__file__).parents[3] / "configs"
SMALL_CAMERA = {
    "size_px": (640, 480), "rate_hz": 10.0, "calibration": None, "source": "simulated"
}  # fmt: skip
"""Half the pixels each way, and a third as often: for runs whose pictures are not the subject."""


def short_config(
    stations: list[dict[str, float]], *, simulation: dict[str, Any] | None = None, **sections: Any
) -> Config:
    """configs/simulation.yaml with a small camera, these stations and changed keys."""
    base = _shipped().model_dump()
    base["camera"].update(SMALL_CAMERA)
    base["mission"]["stations"] = stations
    base["simulation"]["camera"].update(focal_px=617.5, centre_offset_px=(2.6, -1.9))
    for name, keys in {**sections, "simulation": simulation or {}}.items():
        if isinstance(keys, dict):
            base[name].update(keys)
        else:
            base[name] = keys
    return Config.model_validate(base)


@cache
def alcove() -> Config:
    """configs/alcove.yaml with half as many pictures, as many as the other fleets' cameras take."""
    return load_config(CONFIGS / "alcove.yaml", {"CLEARWAY_CAMERA__RATE_HZ": "10"})


@cache
def _shipped() -> Config:
    return load_config(CONFIGS / "simulation.yaml", {})


def cycle_until(
    daemon: Daemon,
    reached: Callable[[RobotSnapshot], bool],
    seconds: float = 40.0,
    each: Callable[[RobotSnapshot], None] = lambda _: None,
) -> RobotSnapshot:
    """Cycle until ``reached``, at most so many virtual seconds."""
    until_s = daemon.world.clock() + seconds
    while True:
        now = daemon.cycle().only
        each(now)
        if reached(now):
            return now
        assert daemon.world.clock() < until_s, f"not within {seconds} s: {now.sentence}"


def set_trouble(world: TroubledWorld, name: str, value: object) -> None:
    """Switch a trouble of the only robot, or of the only camera."""
    of_robot = world.body.troubles
    setattr(of_robot if hasattr(of_robot, name) else world.cameras[None], name, value)


def is_driving(now: RobotSnapshot) -> bool:
    """The robot is on its way."""
    return now.mission.state is State.DRIVING and now.link.executed >= 1
