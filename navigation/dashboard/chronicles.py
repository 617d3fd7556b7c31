"""The recent past of one robot or several: a common log, tracks and charts for each.

With several, each robot's chronicle has a name; the one without has what concerns all.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from navigation.config import Config
from navigation.config.several.each_robot import each_robot
from navigation.dashboard.messages.chronicle import Chronicle
from navigation.loop.run_state import RunState
from vision.camera.latest_frame import CameraStatus


class Chronicles:
    """Fed with each cycle's states; ``all`` is the one without a name."""

    def __init__(self, config: Config) -> None:
        self.configs: Mapping[str, Config] = each_robot(config)
        self.all = Chronicle(config.robot.speed_m_s)
        self.each: Mapping[str, Chronicle] = {
            name: Chronicle(one.robot.speed_m_s, name, self.all.log)
            for name, one in self.configs.items()
        }

    def rings(self) -> Iterator[tuple[str | None, Chronicle]]:
        """Yield the chronicles with tracks and charts, by name (None for a single robot)."""
        yield from self.each.items() if self.each else ((None, self.all),)

    def see(
        self,
        state: RunState,
        camera: CameraStatus,
        wall_s: float,
        *,
        charted: bool = True,
    ) -> None:
        """Record the news; ``charted`` False leaves the charts unchanged."""
        for name, chronicle in self.rings():
            mine = state.robots[name or ""]
            chronicle.see_robot(mine, wall_s)
            if charted:
                chronicle.sample(mine, camera)
        self.all.see_arena(state.together, camera, wall_s)
