"""What a run of several robots is connected to, in real time: cameras, a port for each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.config.several.each_robot import each_robot
from navigation.link.serial_link import SerialLink
from navigation.loop.planning import Answering, PlannerThread, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.run.devices.cameras import Cameras
from navigation.run.devices.driven import driver_of, end_all, link_of, start_all
from navigation.run.devices.wakeups import Wakeups
from navigation.run.devices.world_clock import WallClock
from navigation.run.fleet.simulated_fleet import is_simulated
from navigation.run.fleet.simulation_apart import RobotApart, SimulationApart
from navigation.run.world import floor_plan_of, shown_calibration
from navigation.simulator.arena import load_arena
from navigation.simulator.happenings import arenas_over_time
from navigation.simulator.truth import Truth
from planner.shared.search_clock import search_clock_s
from vision.camera.camera import Camera
from vision.camera.latest_frame import LatestFrame
from vision.camera.several_frames import SeveralFrames

_Q = TypeVar("_Q")
_A = TypeVar("_A")


class FleetWorld:
    """Makes what the configuration names; `start` switches simulated robots on.

    What is simulated is in a process of its own. ``wait_for_port`` False: a serial port that is
    not ready is a ``PortError`` of its link.
    """

    def __init__(self, config: Config, *, wait_for_port: bool = True) -> None:
        self.config = config
        self._wait_for_port = wait_for_port
        self._simulation = SimulationApart(config) if is_simulated(config) else None
        self.clock = WallClock() if self._simulation is None else self._simulation.clock
        """Monotonic seconds."""
        self._wakeups = Wakeups(self.clock)
        simulated = {} if self._simulation is None else self._simulation.ports
        self._alone = each_robot(config)
        self.ports = {
            name: simulated.get(name, one.serial.port) for name, one in self._alone.items()
        }
        """By name."""
        self._drivers = {
            name: driver
            for name, one in self._alone.items()
            if (driver := driver_of(one, self.ports[name])) is not None
        }
        self.doubts: list[str] = []
        """After the end: what is not known of robots that should stand."""
        self.truths: dict[str, Truth] = {}
        """By name, of the simulated robots."""
        if self._simulation is not None and simulated:
            arenas = arenas_over_time(config, load_arena(config))
            self.truths = {
                name: Truth(arenas, RobotApart(self._simulation, name)) for name in simulated
            }
        self._cameras = Cameras(config, self.clock, self._simulated)
        self.floor_plan = floor_plan_of(config)
        self.calibration = shown_calibration(config, self.floor_plan)

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.wait(seconds)

    def late_s(self) -> float:
        """How late this program's threads were woken, at worst, since the last call."""
        return self._wakeups.worst_s()

    def make_frames(self) -> LatestFrame | SeveralFrames:
        """The camera in a thread of its own, or each of several."""
        return self._cameras.frames()

    def make_vision(
        self, config: Config, witness: KnowsLatency, driven: Sequence[RobotSection]
    ) -> VisionStage:
        """Vision that looks at the camera's pictures."""
        return VisionStage(config, self.calibration, witness, self.clock, driven, self.floor_plan)

    def make_link(self, name: str) -> SerialLink:
        """The serial link to one robot in a thread of its own."""
        driver = self._drivers.get(name)
        if driver is not None:
            return link_of(driver, self.clock)
        baud = self._alone[name].serial.baud
        return SerialLink(
            self.ports[name], baud, clock=self.clock, wait_for_port=self._wait_for_port
        )

    def search_clock(self) -> float:
        """The seconds by which a search for plans is limited: compiling is left out."""
        return search_clock_s()

    def make_planner(
        self,
        planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> PlannerThread[_Q, _A]:
        """The planner in a thread of its own."""
        return PlannerThread(planner, on_scene, on_answer)

    def _simulated(self, name: str | None, _config: Config) -> Camera:
        assert self._simulation is not None
        return self._simulation.open_camera(name)

    def start(self) -> None:
        """Switch the simulated robots and all drivers on; what happens counts from here."""
        self.clock.waits_for_this_thread()
        self._wakeups.start()
        for truth in self.truths.values():
            truth.began_s = self.clock()
        if self._simulation is not None:
            self._simulation.start()
        start_all(self._drivers.values())

    def stop(self) -> None:
        """Switch them off."""
        self._wakeups.stop()
        self.doubts = end_all(self._drivers.values())
        if self._simulation is not None:
            self._simulation.stop()
