"""Two simulated cameras in virtual time: the configuration, and a daemon with what it said."""

from __future__ import annotations

from typing import Any

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import CONFIGS, cycle_until, is_driving

RADIUS_M = 0.09


def config_of(
    *stations: tuple[float, float],
    start: tuple[float, float] = (0.2, 0.2),
    cameras: dict[str, dict[str, Any]] | None = None,
    **sections: dict[str, Any],
) -> Config:
    """configs/two_cameras.yaml with pictures of half the size, these stations and changed keys.

    ``cameras``: by name, what differs of a simulated one.
    """
    base = load_config(CONFIGS / "two_cameras.yaml", {}).model_dump()
    base["camera"].update(size_px=(640, 480), rate_hz=10.0)
    base["mission"]["stations"] = [{"x_m": x, "y_m": y} for x, y in stations]
    base["simulation"]["start"].update(x_m=start[0], y_m=start[1])
    base["simulation"]["camera"].update(focal_px=617.5, centre_offset_px=(2.6, -1.9))
    for one in base["simulation"]["cameras"]:
        one.update((cameras or {}).get(one["name"], {}))
    for name, keys in sections.items():
        base[name].update(keys)
    return Config.model_validate(base)


class Stage:
    """A daemon, its world and what it said."""

    def __init__(self, config: Config, *, pictures: bool = True) -> None:
        self.world = TroubledWorld(config, pictures=pictures)
        self.daemon = Daemon(config, self.world, first_mission_id=1)
        self.troubles: list[str] = []
        self.said: list[str] = []

    def watch(self, now: RobotSnapshot) -> None:
        self.troubles += [one for one in now.troubles if one not in self.troubles]
        if now.sentence not in self.said[-1:]:
            self.said.append(now.sentence)

    def set_off(self) -> None:
        self.daemon.people.give(stations_of(self.daemon.config))
        cycle_until(self.daemon, is_driving, each=self.watch)

    def until(self, *states: State, seconds: float = 45.0) -> RobotSnapshot:
        return cycle_until(
            self.daemon, lambda now: now.mission.state in states, seconds, self.watch
        )

    def wait(self, seconds: float) -> RobotSnapshot:
        end_s = self.world.clock() + seconds
        return cycle_until(
            self.daemon, lambda _: self.world.clock() > end_s, seconds + 1.0, self.watch
        )

    def where(self) -> tuple[float, float]:
        pose = self.world.body.pose()
        return pose.x_m, pose.y_m

    def clearance_m(self) -> float:
        return self.world.truths[""].track_clearance(self.world.truths[""].track()) - RADIUS_M
