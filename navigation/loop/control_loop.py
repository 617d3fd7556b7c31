"""The control loop of one robot or several: newest frame, eye, decisions, orders, once a cycle.

Threads: the camera's (newest frame wins), the planner's (newest scene and request win), the
links', each of which alone owns its port, and this one. A cycle runs once a frame, at once when
the planner has news, and at least every ``LONGEST_CYCLE_S`` without either, so that a lost camera
stops the robots too. The leases that let robots move are given by this loop only: should it hang,
all stop.

The clock is the world's: real, or virtual in a simulation that runs as fast as it can.
Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.loop.daemon_state import StageTimes
from navigation.loop.driven_robot import DrivenRobot
from navigation.loop.parts import AnySurroundings, PlannerPart, camera_part
from navigation.loop.planner_news import PlannerNews, SeesScenes
from navigation.loop.planning import SceneCheck
from navigation.loop.punctuality import Punctuality
from navigation.loop.reports import camera_openings
from navigation.loop.seeing.arena_view import ArenaView
from navigation.loop.seeing.other_robots import OtherRobots
from navigation.loop.seeing.vision_stage import KnowsLatency
from navigation.loop.stopping import Stopping
from navigation.shared.supervisor import Part, Supervisor
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Scene
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder

LONGEST_CYCLE_S: Final = 0.05
SETTLE_S: Final = 0.3
"""An order's answer waits so long at most for a cycle that acts on it."""

_StateT = TypeVar("_StateT")
_AskT = TypeVar("_AskT")
_AnswerT = TypeVar("_AnswerT")
_Self = TypeVar("_Self", bound="ControlLoop[Any, Any, Any]")


class ControlLoop(ABC, Generic[_StateT, _AskT, _AnswerT]):
    """Runs a configuration; a context manager that opens and closes everything.

    ``robots`` by name; ``planner`` answers beside the loop what it is asked, by the thread that
    ``make_planner`` makes of it. A ``recorder`` is told all that is seen, planned and decided.
    """

    def __init__(
        self,
        config: Config,
        world: AnySurroundings,
        robots: Mapping[str, DrivenRobot],
        witness: KnowsLatency,
        driven: Sequence[RobotSection] = (),
        recorder: Recorder | None = None,
    ) -> None:
        self.config, self._world, self._robots = config, world, robots
        self._clock = world.clock
        self._recorder = recorder
        self.camera = world.make_frames()
        vision = world.make_vision(config, witness, driven)
        self.newest = vision.newest
        self.view = ArenaView(config, vision, self._clock, recorder)
        self._supervisor = Supervisor(
            {
                "vision": Part(vision.failure, vision.restart),
                "camera's thread": camera_part(self.camera),
                **{
                    f"{_of(name)}serial link": Part(one.link.failure, one.link.restart)
                    for name, one in robots.items()
                },
            }
        )
        self.lock = threading.Lock()
        """Held while pilots decide or people give them orders."""
        self.stopping = Stopping(self.lock)
        self.punctuality = Punctuality()
        self._cycled_s, self._looked = math.inf, 0
        self.lent: str | None = None
        """Why the robots hold while the camera serves something else."""
        self.state: _StateT | None = None
        """What the last cycle ended with; replaced as a whole, so any thread may read it."""
        self.troubles: dict[str, str] = {}
        """What people must know although the run goes on, by subject; set by the loop's thread."""
        self.started_s = self._clock()
        self._reopened, self._forget_latency = 0, False
        self._cycles = self._ended = 0
        self._further_turns: dict[str, Callable[[], int]] = {}
        self._turned = threading.Condition()

    def _set_planner(
        self,
        planner: SeesScenes,
        make_part: Callable[
            [Callable[[SceneCheck], None], Callable[[_AnswerT], None]], PlannerPart[_AskT]
        ],
    ) -> None:
        self._roadmaps = planner
        self._news = PlannerNews[_AnswerT](planner, self._clock, self.camera.wake, self._recorder)
        self._planner = make_part(self._news.on_scene, self._news.on_answer)
        self._supervisor.add("planner", Part(self._planner.failure, self._restart_planner))

    # Life.

    def __enter__(self: _Self) -> _Self:
        self._world.start()
        try:
            for one in self._robots.values():
                one.link.open()
            self.camera.start()
            self._planner.start()
        except BaseException:
            self.__exit__()
            raise
        self.started_s = self._clock()
        return self

    def __exit__(self, *_error: object) -> None:
        self.let_the_robots_stop()
        self._planner.stop()
        for one in self._robots.values():
            one.link.close()
        self._world.stop()

    def halt(self) -> None:
        """Withdraw all leases: the robots begin to brake. No `cycle` may follow."""
        for one in self._robots.values():
            one.orders.halt(self._clock())

    def let_the_robots_stop(self) -> None:
        """`halt`, and wait until all robots say that they stand, or should by now.

        The camera is closed meanwhile; no decision needs it any more.
        """
        self.halt()
        self.camera.stop()
        for one in self._robots.values():
            while self._clock() < one.orders.stands_s and one.link.snapshot().moving:
                self._world.wait(0.01)

    # Restarts after errors of the program; the supervisor says when.

    def _restart_planner(self) -> None:
        self._planner.restart()
        if self.scene is not None:
            self._planner.see(self.scene, self.view.revision, None)

    def look_after(self, name: str, part: Part, turns: Callable[[], int]) -> None:
        """Watch one more stage like those of the loop: its failures, and whether it turns."""
        self._supervisor.add(name, part)
        self._further_turns[name] = turns

    def turns(self) -> dict[str, int]:
        """For each stage a number that grows while it works, or waits for work as it should."""
        turns = {
            "control loop": self._cycles,
            "camera": self.camera.turns,
            "planner": self._planner.turns,
            **{f"{_of(name)}link": one.link.turns for name, one in self._robots.items()},
        }
        if self._recorder is not None and not self._recorder.has_ended():
            turns["recorder"] = self._recorder.turns
        return turns | {name: count() for name, count in self._further_turns.items()}

    # Words of people, from any thread.

    def accept_arena(self) -> None:
        """A person says that arena and camera are as they are seen now."""
        self.view.doubt.accept()
        self._forget_latency = True

    def settle(self) -> None:
        """Wait, in another thread, until a cycle has acted on the orders so far; not for long."""
        wanted = self._ended + 2  # the cycle under way may have decided already
        self.camera.wake()
        with self._turned:
            self._turned.wait_for(lambda: self._ended >= wanted, SETTLE_S)

    # What is known; any thread may look.

    @property
    def scene(self) -> Scene | None:
        """The newest scene."""
        return self.view.scene

    @property
    def others(self) -> OtherRobots:
        """The robots that nobody here drives."""
        return self.view.others

    @property
    def processed(self) -> int:
        """How many pictures were looked at."""
        return self.view.processed

    @property
    def frame(self) -> Frame | None:
        """The newest picture."""
        return self.view.frame

    @property
    def roadmap(self) -> Roadmap | None:
        """The newest roadmap, of several robots that of the smallest, for pictures."""
        return self._roadmaps.roadmap

    # The cycle.

    def cycle(self) -> _StateT:
        """Wait for a frame or the planner's news, at most ``LONGEST_CYCLE_S``, and decide."""
        self._cycles += 1
        self._note_lateness()
        frame = self.camera.take(LONGEST_CYCLE_S)
        if frame is not None and self.view.see(frame, self._tell_poses):
            assert self.scene is not None
            self._news.gets_scene()
            self._planner.see(self.scene, self.view.revision, self._driven_points())
        now_s = self._clock()
        failed = self._supervisor.look(now_s)
        camera = self.camera.status()
        self._look_at_camera(camera)
        self.state = self._decide(now_s, failed, camera)
        with self._turned:
            self._ended += 1
            self._turned.notify_all()
        return self.state

    def _note_lateness(self) -> None:
        """By how much the threads were late, this one's own look at a picture left out."""
        now_s = self._clock()
        looked_s = (self.view.vision.look_s or 0.0) if self.view.processed != self._looked else 0.0
        self._looked = self.view.processed
        cycle_s, self._cycled_s = now_s - self._cycled_s, now_s
        note = self.punctuality.note
        note("the control loop", cycle_s - LONGEST_CYCLE_S - looked_s, now_s)
        note("a thread", self._world.late_s(), now_s)
        for name, one in self._robots.items():
            note(f"{_of(name) or 'the '}link's thread", one.link.late_s(), now_s)

    def _tell_poses(self, poses: Mapping[int, RobotPose]) -> None:
        """The newest thing that anybody knows goes to the robots at once."""
        for one in self._robots.values():
            one.sees(poses, self.view.frame_s)

    def _look_at_camera(self, camera: CameraStatus) -> None:
        """Whether the camera is another one than before, for which latency counts again."""
        reopened = camera_openings(camera)
        forget = reopened != self._reopened or self._forget_latency
        self._reopened, self._forget_latency = reopened, False
        if forget:
            for one in self._robots.values():
                one.witness.forget_latency()

    def _driven_points(self) -> FloatArray | None:
        """The path whose clearance the planner's thread measures in each new scene, (n, 2)."""
        return None

    @abstractmethod
    def _decide(self, now_s: float, failed: str | None, camera: CameraStatus) -> _StateT:
        """What follows from what is known: orders to robots and planner, and the new state."""

    def _times(self) -> StageTimes:
        return StageTimes(self.view.vision.look_s, self._news.roadmap_s, self._news.plan_s)

    @property
    def _hold(self) -> str | None:
        """Why all robots have to hold; None where they need not."""
        return self.lent or self.view.hold or self.punctuality.hold(self._clock())

    @property
    def _troubles(self) -> tuple[str, ...]:
        troubles = self.view.troubles | self.troubles | {"stops": self.stopping.trouble}
        return tuple(filter(None, troubles.values()))


def _of(name: str) -> str:
    """Whose part it is, where there are several robots."""
    return f"{name}'s " if name else ""
