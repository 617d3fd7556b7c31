"""What a run of several robots is connected to, in real time: one camera, a port for each robot."""

from __future__ import annotations

import time
from collections.abc import Callable

from navigation.config import Config
from navigation.config.sections import SIMULATED
from navigation.config.several.each_robot import each_robot
from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.link.serial_link import SerialLink
from navigation.loop.fleet.fleet_planner import FleetPlanner
from navigation.loop.planning import PlannerThread, SceneCheck
from navigation.run.world import Clock, World, calibration_of, camera_over
from navigation.simulator.truth import Truth
from vision.camera.camera import Camera
from vision.camera.latest_frame import LatestFrame
from vision.camera.sources import camera_for


class FleetWorld:
    """Makes what the configuration names; `start` switches simulated robots on.

    ``wait_for_port`` False: a serial port that is not ready is a ``PortError`` of its link.
    """

    def __init__(
        self, config: Config, clock: Clock = time.monotonic, *, wait_for_port: bool = True
    ) -> None:
        self.config = config
        self._clock = clock
        self._worlds = {
            name: World(one, clock, wait_for_port=wait_for_port)
            for name, one in each_robot(config).items()
        }
        self._began_s = clock()
        self.calibration = calibration_of(config)

    @property
    def ports(self) -> dict[str, str]:
        """By name."""
        return {name: world.port for name, world in self._worlds.items()}

    @property
    def truths(self) -> dict[str, Truth]:
        """By name, of the simulated robots."""
        return {
            name: world.truth for name, world in self._worlds.items() if world.truth is not None
        }

    def clock(self) -> float:
        """Monotonic seconds."""
        return self._clock()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        time.sleep(seconds)  # what `wait` is for

    def make_frames(self) -> LatestFrame:
        """The camera in a thread of its own."""
        return LatestFrame(self.open_camera, self._clock)

    def make_link(self, name: str) -> SerialLink:
        """The serial link to one robot in a thread of its own."""
        return self._worlds[name].make_link()

    def make_fleet_planner(
        self,
        planner: FleetPlanner,
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[FleetAnswer], None],
    ) -> PlannerThread[FleetRequest, FleetAnswer]:
        """The planner in a thread of its own."""
        return PlannerThread(planner, on_scene, on_answer)

    def open_camera(self) -> Camera:
        """A new camera, closed; the same source each time."""
        camera = self.config.camera
        if camera.source == SIMULATED:
            first = next(iter(self._worlds.values()))
            return camera_over(
                self.config,
                first.arenas,
                first.tracks,
                first.pose_now,
                self._clock,
                self._began_s,
                fleet=[(world.config.robot, world.pose_now) for world in self._worlds.values()],
            )
        return camera_for(
            camera.source,
            clock=self._clock,
            rate_hz=camera.rate_hz,
            size=camera.size_px,
            loop=camera.loop,
        )

    def start(self) -> None:
        """Switch the simulated robots on; what happens in the arena counts from here."""
        self._began_s = self._clock()
        for world in self._worlds.values():
            world.start()

    def stop(self) -> None:
        """Switch them off."""
        for world in self._worlds.values():
            world.stop()
