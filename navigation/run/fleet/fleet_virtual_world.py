"""Several simulated robots in virtual time: each its own line, wheels and troubles.

Metres, radians, virtual seconds.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import each_robot
from navigation.loop.planning import Answering, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.run.troubled_camera import CameraTroubles, Memory, TroubledCamera, seen_pose
from navigation.run.virtual_link import VirtualLink
from navigation.run.virtual_troubles import ProcessorFaults, Troubles, virtual_loop_of
from navigation.run.virtual_world import VirtualFrames, VirtualPlanner, VirtualTimes
from navigation.run.without_pictures.looking import looking_of
from navigation.run.world import camera_over, floor_plan_of, shown_calibration
from navigation.simulator.arena import load_arena
from navigation.simulator.happenings import arenas_over_time, tracks_of
from navigation.simulator.settings import faults_of
from navigation.simulator.truth import Truth
from navigation.simulator.virtual_loop import VirtualLoop
from navigation.simulator.virtual_robot import VirtualRobot
from vision.camera.camera import Camera, CameraError

_Q = TypeVar("_Q")
_A = TypeVar("_A")


@dataclass(slots=True)
class Body:
    """One simulated robot with its line and what may go wrong with it."""

    config: Config
    loop: VirtualLoop
    robot: VirtualRobot
    processor: ProcessorFaults
    troubles: Troubles = field(default_factory=Troubles)
    frozen: bool = False
    """Its processor does nothing, and its wheels turn on as they did."""
    off: bool = False
    """It has no power."""

    def tick(self, since_s: float) -> None:
        """One millisecond, ``since_s`` after the beginning."""
        loop = self.loop
        self.processor.meet(loop, since_s)
        loop.knobs.frozen |= self.frozen or self.off
        if self.off:
            loop.wheels = WheelSpeeds(0.0, 0.0, powered=False)
        self.troubles.meet(loop)
        loop.tick()


def _body(config: Config) -> Body:
    loop = virtual_loop_of(config)
    return Body(config, loop, VirtualRobot(loop), ProcessorFaults(faults_of(config)))


class FleetVirtualWorld:
    """`parts.Surroundings` in virtual time.

    ``bodies`` by name is what the simulated robots really are, where their errors are each its
    own; else as configured. Without ``pictures`` none is drawn or looked at
    (`navigation.run.without_pictures`).
    """

    def __init__(
        self,
        config: Config,
        times: VirtualTimes | None = None,
        bodies: Mapping[str, Config] | None = None,
        *,
        pictures: bool = True,
    ) -> None:
        assert config.simulation is not None
        self.config = config
        self.times = times or VirtualTimes()
        self.troubles: defaultdict[str | None, CameraTroubles] = defaultdict(CameraTroubles)
        """Of the camera, or of each of several by name."""
        alone = each_robot(config) if bodies is None else bodies
        self.bodies = {name: _body(one) for name, one in alone.items()}
        self._cameras = each_camera(config)
        seed = config.simulation.seed
        self._memories = {
            name: Memory(np.random.default_rng(seed + i))
            for i, name in enumerate(self._cameras or [None])
        }
        self._arenas = arenas_over_time(config, load_arena(config))
        self._looking = looking_of(config, self._arenas, pictures=pictures)
        self._tracks = tracks_of(config)
        self.floor_plan = floor_plan_of(config)
        self.calibration = shown_calibration(config, self.floor_plan)
        self.truths = {name: Truth(self._arenas, body.robot) for name, body in self.bodies.items()}
        self._began_s = self._searched_s = 0.0
        self._due: list[tuple[float, Callable[[], None]]] = []
        self.meet: Callable[[float], None] | None = None
        """Called every millisecond with the time since the start: a test's troubles."""

    def clock(self) -> float:
        """Virtual seconds."""
        return next(iter(self.bodies.values())).loop.now_s

    def wait(self, seconds: float) -> None:
        """Let time pass: bytes travel, the robots drive, and what is due is done."""
        end_s = self.clock() + seconds
        while self.clock() < end_s - 1e-9:
            since_s = self.clock() - self._began_s
            if self.meet is not None:
                self.meet(since_s)
            for body in self.bodies.values():
                body.tick(since_s)
            if self._due:
                self._do_what_is_due()
        for body in self.bodies.values():
            body.robot.keep_track()

    def _do_what_is_due(self) -> None:
        now_s = self.clock()
        for item in [item for item in self._due if item[0] <= now_s]:
            self._due.remove(item)
            item[1]()

    def late_s(self) -> float:
        """There is no thread that could be late."""
        return 0.0

    def after(self, seconds: float, call: Callable[[], None]) -> None:
        """Have something done when so much time has passed."""
        self._due.append((self.clock() + seconds, call))

    def make_frames(self) -> VirtualFrames:
        """The camera, or several as one."""
        return VirtualFrames(self, tuple(self._cameras))

    def make_vision(
        self, config: Config, witness: KnowsLatency, driven: Sequence[RobotSection]
    ) -> VisionStage:
        """Vision, with drawn pictures or without."""
        return VisionStage(
            config,
            self.calibration,
            witness,
            self.clock,
            driven,
            self.floor_plan,
            self._looking.parts,
        )

    def make_link(self, name: str) -> VirtualLink:
        """The link to one robot."""
        body = self.bodies[name]
        return VirtualLink(body.loop, body.troubles)

    def search_clock(self) -> float:
        """Counts the looks at it, so that equal work is limited equally on every computer."""
        self._searched_s += self.times.search_s
        return self._searched_s

    def make_planner(
        self,
        planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> VirtualPlanner[_Q, _A]:
        """The planner."""
        return VirtualPlanner(self, planner, on_scene, on_answer)

    def open_camera(self, name: str | None = None) -> Camera:
        """A new camera over what the arena is by now; ``name`` is one of several."""
        troubles = self.troubles[name]
        if troubles.camera_lost:
            raise CameraError("simulated camera: is unplugged")

        def pose_of(body: Body) -> Callable[[], tuple[float, float, float]]:
            return lambda: seen_pose(body.robot.pose(), body.troubles)

        bodies = list(self.bodies.values())
        camera = camera_over(
            self.config if name is None else self._cameras[name],
            self._arenas,
            self._tracks,
            pose_of(bodies[0]),
            self.clock,
            self._began_s,
            self.wait,
            fleet=[(body.config.robot, pose_of(body)) for body in bodies],
            make=self._looking.make_camera,
        )
        return TroubledCamera(camera, troubles, self._memories[name], self.clock, self.wait)

    def start(self) -> None:
        """What happens in the arena counts from the first start."""
        if self._began_s == 0.0:
            self._began_s = self.clock()
            for truth in self.truths.values():
                truth.began_s = self._began_s

    def stop(self) -> None:
        """The robots stay switched on."""
