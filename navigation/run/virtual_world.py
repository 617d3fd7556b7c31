"""The running program's world in virtual time, without threads or waiting.

Time passes only while the control loop waits for a frame: then bytes travel, robots drive and
cameras take pictures. `LatestFrame`, both ends of the wire and the drive model are the real ones.
`VirtualTimes` sets the time for computing, so a run is always the same. Metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import robots_of
from navigation.loop.planning import Answering, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.run.calibrations import floor_plan_of, shown_calibration
from navigation.run.simulated_camera import camera_over
from navigation.run.virtual_body import VirtualBody
from navigation.run.virtual_link import VirtualLink
from navigation.run.without_pictures.looking import looking_of
from navigation.shared.supervisor import in_words
from navigation.simulator.arena import load_arena
from navigation.simulator.happenings import arenas_over_time, tracks_of
from navigation.simulator.picture.camera import Driven
from navigation.simulator.truth import Truth
from navigation.simulator.virtual_loop import TICK_S
from planner.scene import FloatArray, Scene
from planner.zones.zone import Zone
from vision.camera.camera import Camera, Frame
from vision.camera.latest_frame import CameraStatus, LatestFrame, WatchLimits
from vision.camera.several_frames import SeveralFrames

WATCH_EVERY_S = 0.005
"""Longest wait of the control loop for a read of the camera."""
VIRTUAL_LIMITS = WatchLimits(read_timeout_s=WATCH_EVERY_S)


@dataclass(frozen=True, slots=True)
class VirtualTimes:
    """Time for a picture's vision, a scene, a plan, and between looks at a search's clock."""

    look_s: float = 0.008
    scene_s: float = 0.03
    plan_s: float = 0.03
    search_s: float = 0.001
    """0.4 to 1.8 ms of processor time per look in the shipped configurations."""


_Q = TypeVar("_Q")
_A = TypeVar("_A")


class VirtualWorld:
    """`parts.Surroundings` in virtual time.

    Robots outlive a daemon: another may follow, as after a restart. ``bodies`` gives robots with
    errors of their own, by name. Without ``pictures`` none is drawn or analysed.
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
        alone = bodies or robots_of(config)
        self.bodies = {name: self.make_body(one) for name, one in alone.items()}
        """By name, which is empty for a lone robot."""
        self.ports = dict.fromkeys(self.bodies, "virtual")
        self._configs_of_cameras = each_camera(config)
        self._arenas = arenas_over_time(config, load_arena(config))
        self._looking = looking_of(config, self._arenas, pictures=pictures)
        self._tracks = tracks_of(config)
        self.floor_plan = floor_plan_of(config)
        self.calibration = shown_calibration(config, self.floor_plan)
        self.truths = {name: Truth(self._arenas, body) for name, body in self.bodies.items()}
        self._time = next(iter(self.bodies.values())).loop
        self._began_s = self._searched_s = 0.0
        self._due: list[tuple[float, Callable[[], None]]] = []
        self.meet: Callable[[float], None] | None = None
        """Called every millisecond with the time since the start."""

    @property
    def body(self) -> VirtualBody:
        """The only robot of a run of one."""
        (body,) = self.bodies.values()
        return body

    def make_body(self, config: Config) -> VirtualBody:
        """Make one robot."""
        return VirtualBody.of(config)

    def clock(self) -> float:
        """Virtual seconds."""
        return self._time.now_s

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        end_s = self._time.now_s + seconds
        bodies = list(self.bodies.values())
        while self._time.now_s < end_s - 1e-9:
            since_s = self._time.now_s - self._began_s
            if self.meet is not None:
                self.meet(since_s)
            for body in bodies:
                body.tick(since_s)
            if self._due:
                self._do_what_is_due()
        for body in bodies:
            body.keep_track()

    def _do_what_is_due(self) -> None:
        now_s = self.clock()
        for item in [item for item in self._due if item[0] <= now_s]:
            self._due.remove(item)
            item[1]()

    def late_s(self) -> float:
        """0: no thread can be late."""
        return 0.0

    def after(self, seconds: float, call: Callable[[], None]) -> None:
        """Call ``call`` after ``seconds``."""
        self._due.append((self.clock() + seconds, call))

    def make_frames(self) -> VirtualFrames:
        """Make the camera, or several as one."""
        return VirtualFrames(self, tuple(self._configs_of_cameras))

    def make_vision(
        self, config: Config, witness: KnowsLatency, driven: Sequence[RobotSection]
    ) -> VisionStage:
        """Make vision, with drawn pictures or without."""
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
        """Make the link to one robot."""
        return VirtualLink(self.bodies[name].loop)

    def search_clock(self) -> float:
        """Count the looks at it, so that equal work has an equal limit on every computer."""
        self._searched_s += self.times.search_s
        return self._searched_s

    def make_planner(
        self,
        planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> VirtualPlanner[_Q, _A]:
        """Make the planner."""
        return VirtualPlanner(self, planner, on_scene, on_answer)

    def open_camera(self, name: str | None = None) -> Camera:
        """Make a camera over the arena as it is now."""
        return camera_over(
            self.config if name is None else self._configs_of_cameras[name],
            self._arenas,
            self._tracks,
            self._driven(),
            self.clock,
            self._began_s,
            self.wait,
            self._looking.make_camera,
        )

    def _driven(self) -> Driven:
        bodies = self.bodies.values()
        return [
            *((body.config.robot, body.seen) for body in bodies),
            *((body.config.robot, body.double) for body in bodies),
        ]

    def start(self) -> None:
        """Set the time from which the arena's events count; only the first start does."""
        if self._began_s == 0.0:
            self._began_s = self.clock()
            for truth in self.truths.values():
                truth.began_s = self._began_s

    def stop(self) -> None:
        """Leave the robots switched on."""


class VirtualFrames:
    """`LatestFrame`, or several of these names, whose loop turns while the control loop waits."""

    def __init__(self, world: VirtualWorld, names: Sequence[str] = ()) -> None:
        self._world = world
        openers = {name: partial(world.open_camera, name) for name in names}
        self._latest = (
            SeveralFrames(openers, world.clock, VIRTUAL_LIMITS)
            if openers
            else LatestFrame(world.open_camera, world.clock, VIRTUAL_LIMITS)
        )
        self._woken = False
        self.turns = 0

    def start(self) -> None:
        """Nothing to do: the first `take` opens the camera."""

    def stop(self) -> None:
        """Close the camera."""
        self._latest.stop()

    def has_died(self) -> bool:
        """False: no thread can die."""
        return False

    def take(self, timeout_s: float) -> Frame | None:
        """Return the next frame after the time that vision takes; None on a timeout or `wake`."""
        self.turns += 1
        end_s = self._world.clock() + timeout_s
        while self._world.clock() < end_s and not self._woken:
            frame = self._latest.take(0.0)
            if frame is not None:
                self._world.wait(self._world.times.look_s)
                return frame
            pause_s = self._latest.step()
            if pause_s > 0.0:
                left_s = end_s - self._world.clock()
                self._world.wait(max(TICK_S, min(pause_s, left_s)))  # time always passes
        self._woken = False
        return None

    def wake(self) -> None:
        """End the present wait of `take`, or the next one."""
        self._woken = True

    def status(self) -> CameraStatus:
        """Present status of the camera."""
        return self._latest.status()


class VirtualPlanner(Generic[_Q, _A]):
    """A planner that plans at once and answers when a thread would have."""

    def __init__(
        self,
        world: VirtualWorld,
        arena_planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> None:
        self._world, self.planner = world, arena_planner
        self._on_scene, self._on_answer = on_scene, on_answer
        self._failure: str | None = None
        self._zones: Sequence[Zone] = ()
        self.turns = {"planner": 0}

    def start(self) -> None:
        """Nothing to do."""

    def stop(self) -> None:
        """Nothing to do."""

    def failure(self) -> str | None:
        """Error of the last scene or plan, in words."""
        return self._failure

    def restart(self) -> None:
        """Forget the error."""
        self._failure = None

    def _try(self, work: Callable[[], None]) -> None:
        self.turns["planner"] += 1
        if self._failure is not None:
            return
        try:
            work()
        except Exception as error:  # noqa: BLE001 - said by the control loop
            self._failure = in_words(error)

    def see(
        self,
        scene: Scene,
        revision: int,
        path_points: FloatArray | None,
        zones: Sequence[Zone] = (),
    ) -> None:
        """Build the roadmap; it is available after ``scene_s``."""

        def built() -> None:
            self.planner.see(scene, revision, zones)
            clearance = None
            if path_points is not None:
                clearance = self.planner.path_clearance_m(path_points)
            changed, self._zones = zones != self._zones, zones
            self._on_scene(SceneCheck(revision, clearance, changed, tuple(zones)))

        self._world.after(self._world.times.scene_s, lambda: self._try(built))

    def ask(self, request: _Q) -> None:
        """Plan; the answer comes after ``plan_s``."""

        def planned() -> None:
            self._on_answer(self.planner.answer(request))

        self._world.after(self._world.times.plan_s, lambda: self._try(planned))
