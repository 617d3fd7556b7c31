"""The borders of a run as golden files, of one robot and of several: everything that others read.

    python -m tests.support.runs.boundaries        # writes tests/golden/boundaries/*.json again

Rules
- Words stay, and so do true, false and null. A number is written as "number", in a sentence as #,
  since `python -m benchmarks.same_runs` compares the numbers.
- A list of equal shapes is one of them; times of day and random numbers are numbers.
"""

from __future__ import annotations

import asyncio
import json
import re
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from navigation.config import Config
from navigation.config.several.each_robot import robots_of
from navigation.dashboard.hub import Hub
from navigation.journal.journal import Journal, owner_of
from navigation.loop.daemon import Daemon
from navigation.run.give_missions import GiveMissions
from tests.support.runs.packed import unpack
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import short_config
from tests.support.runs.whole_run import run_whole

GOLDEN: Final = Path(__file__).parents[2] / "golden" / "boundaries"
SEEN_AT_S: Final = 2.0
STATUS: Final = {"order": "status"}
STARTS: Final = {"a": (0.20, 0.20, 90.0), "b": (2.20, 1.60, -90.0)}
GOALS: Final = {"a": (0.20, 0.90), "b": (2.20, 0.80)}
TIME_OF_DAY: Final = re.compile(r"\d{4}-\d\d-\d\dT[\d:.]+Z?")
NUMBER: Final = re.compile(r"(?<![\w.=/])-?\d+(\.\d+)?(e-?\d+)?")


def one_robot() -> Config:
    """A robot with two stations."""
    return short_config([{"x_m": 0.20, "y_m": 0.60}, {"x_m": 0.20, "y_m": 0.90, "dwell_s": 0.2}])


def several_robots() -> Config:
    """Two robots with a station each, in the same arena."""
    values = one_robot().model_dump()
    values["robot"]["marker_id"] = 0
    values["robots"] = [{"name": name, "marker_id": i + 1} for i, name in enumerate(STARTS)]
    values["mission"]["stations"] = []
    values["mission"]["robots"] = [
        {"name": name, "stations": [{"x_m": x, "y_m": y}]} for name, (x, y) in GOALS.items()
    ]
    values["simulation"]["start"] = None
    values["simulation"]["starts"] = [
        {"name": name, "x_m": x, "y_m": y, "heading_deg": turn}
        for name, (x, y, turn) in STARTS.items()
    ]
    return Config.model_validate(values)


def shape(value: Any) -> Any:
    """The value as a golden file has it; see the module's text."""
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, (int, float, np.number)):
        return "number"
    if isinstance(value, str):
        return NUMBER.sub("#", TIME_OF_DAY.sub("time", value))
    if isinstance(value, np.ndarray):
        return f"array of {value.dtype}"
    if isinstance(value, dict):
        return {str(key): shape(one) for key, one in value.items()}
    shapes = [shape(one) for one in value]
    return shapes[:1] if all(one == shapes[0] for one in shapes) else shapes


def seen_of(config: Config) -> dict[str, Any]:
    """Everything that is seen at the borders of one run whose camera is lost for a second.

    With the 30 pictures a second that the golden files were written with.
    """
    with tempfile.TemporaryDirectory() as name, pytest.MonkeyPatch.context() as patch:
        folder = Path(name)
        recording = config.recording.model_copy(update={"journal": folder / "journal"})
        camera = config.camera.model_copy(update={"rate_hz": 30.0})
        config = config.model_copy(update={"recording": recording, "camera": camera})
        happenings = {SEEN_AT_S: STATUS, 3.0: camera_lost(True), 4.0: camera_lost(False)}
        ran = run_whole(config, folder, patch, happenings)
        status = {**ran.answers[0], "socket": "control.sock"}
        return {
            "exit code": ran.exit_code,
            "report": shape(ran.report),
            "status": shape(status),
            "events": without_repeats([shape({**one, "time": "time"}) for one in ran.events]),
            "to systemd": without_repeats([shape(one) for one in ran.notified]),
            "journal": shape(_journals(config)),
            "page": page_of(config),
        }


def camera_lost(lost: bool) -> Callable[[TroubledWorld], None]:
    """Unplugs the camera, or plugs it in again."""

    def happen(world: TroubledWorld) -> None:
        world.cameras[None].camera_lost = lost

    return happen


def without_repeats(lines: list[Any]) -> list[Any]:
    """Each line once, in the order in which they came first."""
    return [one for i, one in enumerate(lines) if one not in lines[:i]]


def _journals(config: Config) -> dict[str, Any]:
    left = {}
    for name, one in robots_of(config).items():
        assert one.recording.journal is not None
        with Journal(one.recording.journal, owner_of(one, None)) as journal:
            mission, plan = journal.mission(), journal.plan()
            assert mission is not None
            left[name] = {
                "mission": {**asdict(mission), "state": mission.state.value},
                "plan": None if plan is None else sorted(asdict(plan)),
            }
    return left if config.robots else left[""]


def page_of(config: Config) -> dict[str, Any]:
    """The page's greeting and its messages of one cycle while the robots drive."""
    with Daemon(config, TroubledWorld(config, pictures=False), first_mission_id=1) as daemon:
        assert GiveMissions(daemon, lambda _line: None).are_given
        while daemon.world.clock() < SEEN_AT_S:
            daemon.cycle()
        return asyncio.run(_messages(daemon))


async def _messages(daemon: Daemon) -> dict[str, Any]:
    hub = Hub(daemon, clock=daemon.world.clock, wall_clock=lambda: 0.0)
    hub.look(daemon.world.clock())
    while not hub.world.number:  # made by a thread beside the hub
        await asyncio.sleep(0.01)
    return {
        "greeting": shape(hub.hello),
        "state": shape(hub.state_now()),
        "world": shape(unpack(hub.world.message)),
        "plan": shape(unpack(hub.plan)),
    }


def text_of(config: Config) -> str:
    """A golden file's text."""
    return json.dumps(seen_of(config), indent=1, ensure_ascii=False) + "\n"


FILES: Final = {"one_robot.json": one_robot, "several_robots.json": several_robots}

if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for name, config_of in FILES.items():
        (GOLDEN / name).write_text(text_of(config_of()), encoding="utf-8")
