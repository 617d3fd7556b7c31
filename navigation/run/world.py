"""What a run is connected to: a camera, a serial port, and, where simulated, the truth.

The rest of the program gets a camera and a port and cannot tell which they are; only the
report asks for the truth. Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

from navigation.config import Config
from navigation.config.sections import SIMULATED, RobotSection
from navigation.config.several.each_camera import each_camera
from navigation.config.simulation import SimulatedKnockSection
from navigation.link.serial_link import SerialLink
from navigation.loop.planning import Answering, PlannerThread, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.run.devices.cameras import Cameras
from navigation.run.devices.driven import driver_of, end_all, link_of
from navigation.run.devices.simulated import (
    AnySimulatedRobot,
    pose_of,
    shared_pose,
    simulated_robot,
)
from navigation.run.devices.wakeups import Wakeups
from navigation.run.devices.world_clock import wait_for_camera, wait_for_robot, world_clock
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.happenings import ScriptedTrack, arenas_over_time, tracks_of
from navigation.simulator.picture.camera import make_camera
from navigation.simulator.picture.knocked_camera import Knock, KnockedCamera
from navigation.simulator.picture.pinhole import pinhole_of
from navigation.simulator.picture.timed_camera import TimedCamera
from navigation.simulator.truth import Truth
from planner.scene import Bounds
from planner.shared.search_clock import search_clock_s
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import load_calibration
from vision.camera.camera import Camera
from vision.camera.latest_frame import LatestFrame
from vision.camera.several_frames import SeveralFrames
from vision.joined.floor_plan import FloorPlan

Clock = Callable[[], float]
_Q = TypeVar("_Q")
_A = TypeVar("_A")


class World:
    """Makes what the configuration names, in real time; `start` switches the robot on.

    ``wait_for_port`` False: a serial port that is not ready is a ``PortError`` of the link.
    """

    def __init__(self, config: Config, *, wait_for_port: bool = True) -> None:
        self.config = config
        self._wait_for_port = wait_for_port
        self.clock = clock = world_clock(config)
        """Monotonic seconds."""
        self.truth: Truth | None = None
        simulated_port = config.serial.port == SIMULATED
        sources = [one.camera.source for one in (each_camera(config) or {"": config}).values()]
        simulated_camera = SIMULATED in sources
        self._robot: AnySimulatedRobot | None = None
        self.arenas: list[tuple[float, SimulatedArena]] = []
        self.tracks = tracks_of(config)
        if simulated_port or simulated_camera:
            self.arenas = arenas_over_time(config, load_arena(config))
        if simulated_port:
            self._robot = simulated_robot(config, clock)
            wait_for_robot(clock, "", self._robot)
            self.truth = Truth(self.arenas, self._robot, others_of(config, self.tracks))
        self._shared = shared_pose(config) if self._robot is None and simulated_camera else None
        self._cameras = Cameras(config, clock, self._simulated)
        self._began_s = clock()
        self._wakeups = Wakeups(clock)
        self.port = config.serial.port if self._robot is None else self._robot.port
        self._driver = driver_of(config, self.port)
        self.doubts: list[str] = []
        """After the end: what is not known of a robot that should stand."""

    @cached_property
    def floor_plan(self) -> FloorPlan | None:
        """The floor under several cameras; None where there is one."""
        return floor_plan_of(self.config)

    @cached_property
    def calibration(self) -> Calibration:
        """Where pixels lie on the floor, of the picture that people are shown."""
        return shown_calibration(self.config, self.floor_plan)

    @property
    def truths(self) -> dict[str, Truth]:
        """By name, of each simulated robot what only a simulation can know."""
        return {} if self.truth is None else {"": self.truth}

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

    def make_link(self, _name: str) -> SerialLink:
        """The serial link in a thread of its own; it waits for a robot that is plugged in later."""
        if self._driver is not None:
            return link_of(self._driver, self.clock)
        baud = self.config.serial.baud
        return SerialLink(self.port, baud, clock=self.clock, wait_for_port=self._wait_for_port)

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

    def open_camera(self, name: str | None = None) -> Camera:
        """A new camera, closed; the same source each time. ``name`` is one of several cameras."""
        return self._cameras.open(name)

    def _simulated(self, name: str | None, config: Config) -> Camera:
        camera = camera_over(
            config,
            self.arenas,
            self.tracks,
            self.pose_now,
            self.clock,
            self._began_s,
            self.clock.wait,
        )
        wait_for_camera(self.clock, name, camera)
        return camera

    def pose_now(self) -> tuple[float, float, float]:
        """Where the simulated robot is, as the simulated camera sees it."""
        return pose_of(self.config, self._robot, self._shared)

    def start(self) -> None:
        """Switch the simulated robot and its driver on; what happens counts from here."""
        self.clock.waits_for_this_thread()
        self._wakeups.start()
        self._began_s = self.clock()
        if self.truth is not None:
            self.truth.began_s = self._began_s
        if self._robot is not None:
            self._robot.start()
        if self._driver is not None:
            self._driver.start()

    def stop(self) -> None:
        """Switch it off."""
        self._wakeups.stop()
        if self._driver is not None:
            self.doubts = end_all([self._driver])
        if self._robot is not None:
            self._robot.stop()


def others_of(
    config: Config, tracks: Mapping[int, ScriptedTrack]
) -> dict[int, tuple[ScriptedTrack, float]]:
    """By marker id: the track and the body's radius of each other robot that is there."""
    return {
        one.marker_id: (tracks[one.marker_id], one.radius_m)
        for one in config.other_robots
        if one.marker_id in tracks
    }


def camera_over(
    config: Config,
    arenas: Sequence[tuple[float, SimulatedArena]],
    tracks: Mapping[int, ScriptedTrack],
    pose_now: Callable[[], tuple[float, float, float]],
    clock: Clock,
    began_s: float,
    wait: Callable[[float], None] = time.sleep,
    doubles: Sequence[Callable[[], tuple[float, float, float]]] = (),
    fleet: Sequence[tuple[RobotSection, Callable[[], tuple[float, float, float]]]] = (),
    make: Callable[..., TimedCamera[Any]] = make_camera,
) -> TimedCamera[Any] | KnockedCamera:
    """The simulated camera above an arena in which things happen, to the camera itself too.

    ``doubles`` say where other things with the robot's own marker are; ``fleet`` where each of
    several driven robots is; ``make`` makes the cameras, as `make_camera` does.
    """

    def follow(track: ScriptedTrack) -> Callable[[], tuple[float, float, float]]:
        return lambda: track.pose(clock() - began_s)

    now_s = clock() - began_s
    past = [arena for from_s, arena in arenas if from_s <= now_s]

    def hanging(knock: SimulatedKnockSection | None) -> TimedCamera[Any]:
        return make(
            config,
            past[-1],
            pose_now,
            clock,
            wait,
            [
                follow(tracks[one.marker_id]) if one.marker_id in tracks else None
                for one in config.other_robots
            ],
            [(began_s + from_s, arena.scene) for from_s, arena in arenas if from_s > now_s],
            doubles,
            fleet,
            knock,
        )

    knocks = () if config.simulation is None else config.simulation.camera.knocks
    if not knocks:
        return hanging(None)
    return KnockedCamera(
        hanging(None),
        [
            Knock(
                began_s + one.from_s,
                math.inf if one.until_s is None else began_s + one.until_s,
                hanging(one),
            )
            for one in sorted(knocks, key=lambda one: one.from_s)
        ],
        clock,
    )


def calibration_of(config: Config) -> Calibration:
    """The configured calibration; a simulated camera's true values where there is none."""
    camera = config.camera
    if camera.calibration is not None:
        return load_calibration(camera.calibration)
    if camera.metres_per_pixel is not None:
        return Calibration.from_scale(camera.metres_per_pixel, camera.size_px)
    return pinhole_of(config).calibration()


def floor_plan_of(config: Config) -> FloorPlan | None:
    """The floor under the configuration's several cameras; None where there is one.

    Raises ``CalibrationError`` with the camera's name where one sees nothing of the arena.
    """
    cameras = each_camera(config)
    if not cameras:
        return None
    calibrations = [calibration_of(one) for one in cameras.values()]
    return FloorPlan.of(calibrations, Bounds(*config.arena.bounds_m), tuple(cameras))


def shown_calibration(config: Config, plan: FloorPlan | None) -> Calibration:
    """Where the pixels of the picture that people are shown lie on the floor."""
    return calibration_of(config) if plan is None else plan.calibration


def camera_words(config: Config) -> str:
    """The camera, or each of several with its name, as a run says it."""
    named = [f"{name} {one.camera.source}" for name, one in each_camera(config).items()]
    return f"cameras {', '.join(named)}" if named else f"camera {config.camera.source}"
