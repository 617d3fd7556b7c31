"""What one picture costs the control loop, in processor time, with several robots and with one.

    python -m benchmarks.fleet.looking [--config configs/crossing.yaml] [--robots 1,8]
        [--seconds 15]

The first seconds of a run in virtual time, with all simulated robots and links outside of what is
measured. ``markers`` is from a picture to the last robot's pose, ``the rest of looking`` what the
arena is looked at for, ``deciding`` all else of a cycle but its wait for a picture: pilots,
coordinator, orders to the links. Milliseconds of the processor in the middle, so that other work
on the machine hardly shows; a robot that was lost and is searched for shows in the mean.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from functools import wraps
from pathlib import Path
from typing import Any
from unittest import mock

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.seeing.vision_stage import VisionStage
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualFrames
from vision.markers.markers import MarkerTracker

CROSSING = Path(__file__).parents[2] / "configs" / "crossing.yaml"
PARTS = {
    "markers": (MarkerTracker, "update"),
    "look": (VisionStage, "look"),
    "wait": (VirtualFrames, "take"),
    "cycle": (Daemon, "cycle"),
}


def with_robots(config: Config, count: int) -> Config:
    """The same with its first robots only."""
    names = {one.name for one in config.robots[:count]}
    assert config.simulation is not None

    def of_these(entries: Any) -> Any:
        return tuple(one for one in entries if one.name in names)

    return config.model_copy(
        update={
            "robots": of_these(config.robots),
            "mission": config.mission.model_copy(
                update={"robots": of_these(config.mission.robots)}
            ),
            "simulation": config.simulation.model_copy(
                update={"starts": of_these(config.simulation.starts)}
            ),
        }
    )


def measure(config: Config, seconds: float) -> dict[str, list[float]]:
    """For each part its processor times of every picture, in ms."""
    spent = dict.fromkeys(PARTS, 0.0)
    rows: dict[str, list[float]] = defaultdict(list)

    def timed(part: str, call: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(call)
        def run(*arguments: Any) -> Any:
            began_s = time.process_time()
            try:
                return call(*arguments)
            finally:
                spent[part] += 1e3 * (time.process_time() - began_s)

        return run

    def after(_daemon: Daemon, now: Any) -> bool:
        if spent["look"]:
            rows["markers"].append(spent["markers"])
            rows["the rest of looking"].append(spent["look"] - spent["markers"])
            rows["deciding"].append(spent["cycle"] - spent["look"] - spent["wait"])
        spent.update(dict.fromkeys(PARTS, 0.0))
        return bool(now.time_s > seconds)

    with ExitStack() as patched:
        for part, (owner, name) in PARTS.items():
            call = timed(part, getattr(owner, name))
            patched.enter_context(mock.patch.object(owner, name, call))
        run_virtually(config, look=after)
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=CROSSING)
    parser.add_argument("--robots", default="1,8")
    parser.add_argument("--seconds", type=float, default=15.0)
    given = parser.parse_args()
    config = load_config(given.config, {})
    print("| robots | part | in the middle, ms | mean, ms | pictures |\n|---|---|---|---|---|")
    for count in map(int, given.robots.split(",")):
        for part, times in measure(with_robots(config, count), given.seconds).items():
            middle, mean = statistics.median(times), statistics.fmean(times)
            print(f"| {count} | {part} | {middle:.2f} | {mean:.2f} | {len(times)} |", flush=True)


if __name__ == "__main__":
    main()
