"""The real-time world of a run: cameras, serial ports and, if simulated, the truth.

The program cannot distinguish simulated devices; only the report asks for the truth. Metres,
radians, seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import TypeVar

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.config.several.each_robot import robots_of
from navigation.link.serial_link import SerialLink
from navigation.loop.planning import Answering, PlannerThread, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.run.calibrations import floor_plan_of, shown_calibration
from navigation.run.devices.cameras import Cameras
from navigation.run.devices.driven import driver_of, end_all, link_of, start_all
from navigation.run.devices.wakeups import Wakeups
from navigation.run.devices.world_clock import (
    LINK_SLACK_S,
    WAKEUP_SLACK_S,
    WallClock,
    world_clock,
)
from navigation.run.simulation import Simulation, is_simulated
from navigation.run.simulation_apart import SimulationApart
from navigation.simulator.arena import load_arena
from navigation.simulator.drive_model import TruePose
from navigation.simulator.happenings import arenas_over_time
from navigation.simulator.truth import Truth
from planner.scene import FloatArray
from planner.shared.search_clock import search_clock_s
from vision.calibration.calibration import Calibration
from vision.camera.camera import Camera
from vision.camera.latest_frame import LatestFrame
from vision.camera.several_frames import SeveralFrames
from vision.joined.floor_plan import FloorPlan

_Q = TypeVar("_Q")
_A = TypeVar("_A")


class World:
    """The configured devices; `start` switches simulated robots on.

    ``wait_for_port`` False: a serial port that is not ready is a ``PortError`` of its link.
    """

    def __init__(self, config: Config, *, wait_for_port: bool = True) -> None:
        self.config = config
        self._wait_for_port = wait_for_port
        self._robots = robots_of(config)
        self.simulation = _simulation_of(config)
        """None where nothing is simulated."""
        self.clock = WallClock() if self.simulation is None else self.simulation.clock
        """Monotonic seconds."""
        self._wakeups = Wakeups(self.clock)
        self.clock.waits_for("wakeups", self._wakeups.late_since_s, WAKEUP_SLACK_S)
        simulated = {} if self.simulation is None else self.simulation.ports
        self.ports = {
            name: simulated.get(name, one.serial.port) for name, one in self._robots.items()
        }
        """By name, which is empty for a lone robot."""
        self._drivers = {
            name: driver
            for name, one in self._robots.items()
            if (driver := driver_of(one, self.ports[name])) is not None
        }
        self.doubts: list[str] = []
        """After `stop`: doubts about robots behind drivers."""
        self.truths = self._truths(simulated)
        """Ground truth of the simulated robots, by name."""
        self._cameras = Cameras(config, self.clock, self._simulated)

    @cached_property
    def floor_plan(self) -> FloorPlan | None:
        """Floor under several cameras; None for one camera."""
        return floor_plan_of(self.config)

    @cached_property
    def calibration(self) -> Calibration:
        """Calibration of the picture shown to people."""
        return shown_calibration(self.config, self.floor_plan)

    def _truths(self, simulated: Iterable[str]) -> dict[str, Truth]:
        if self.simulation is None or not simulated:
            return {}
        arenas = arenas_over_time(self.config, load_arena(self.config))
        return {name: Truth(arenas, _RobotOf(self.simulation, name)) for name in simulated}

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.wait(seconds)

    def late_s(self) -> float:
        """Worst delay in waking this program's threads since the last call."""
        return self._wakeups.worst_s()

    def make_frames(self) -> LatestFrame | SeveralFrames:
        """Make the camera in a thread of its own, or each of several."""
        return self._cameras.frames()

    def make_vision(
        self, config: Config, witness: KnowsLatency, driven: Sequence[RobotSection]
    ) -> VisionStage:
        """Make the vision that analyses the camera's pictures."""
        return VisionStage(config, self.calibration, witness, self.clock, driven, self.floor_plan)

    def make_link(self, name: str) -> SerialLink:
        """Make the link to one robot, in a thread of its own."""
        driver = self._drivers.get(name)
        if driver is not None:
            return link_of(driver, self.clock)
        baud = self._robots[name].serial.baud
        link = SerialLink(
            self.ports[name], baud, clock=self.clock, wait_for_port=self._wait_for_port
        )
        self.clock.waits_for(f"link {name}", link.late_since_s, LINK_SLACK_S)
        return link

    def search_clock(self) -> float:
        """Seconds that limit a search for plans, without the time for compiling."""
        return search_clock_s()

    def make_planner(
        self,
        planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> PlannerThread[_Q, _A]:
        """Make the planner in a thread of its own."""
        return PlannerThread(planner, on_scene, on_answer)

    def open_camera(self, name: str | None = None) -> Camera:
        """Make a closed camera, always of the same source."""
        return self._cameras.open(name)

    def _simulated(self, name: str | None, _config: Config) -> Camera:
        assert self.simulation is not None
        return self.simulation.open_camera(name)

    def start(self) -> None:
        """Switch simulated robots and all drivers on; times in the arena count from here."""
        self.clock.waits_for_this_thread()
        self._wakeups.start()
        for truth in self.truths.values():
            truth.began_s = self.clock()
        if self.simulation is not None:
            self.simulation.start()
        start_all(self._drivers.values())

    def stop(self) -> None:
        """Switch robots and drivers off."""
        self._wakeups.stop()
        self.doubts = end_all(self._drivers.values())
        if self.simulation is not None:
            self.simulation.stop()


class _RobotOf:
    def __init__(self, simulation: Simulation | SimulationApart, name: str) -> None:
        self._simulation, self._name = simulation, name

    def pose(self) -> TruePose:
        return TruePose(*self._simulation.pose(self._name))

    def track(self) -> FloatArray:
        return self._simulation.track(self._name)


def _simulation_of(config: Config) -> Simulation | SimulationApart | None:
    """Several robots are simulated in another process, which does not delay this one."""
    if not is_simulated(config):
        return None
    if len(config.robots) > 1:
        return SimulationApart(config)
    return Simulation(config, world_clock(config))
