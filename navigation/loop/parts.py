"""What the control loop needs of camera, eye, planner, link and world, in two kinds of time.

In real time all but the eye are threads (`vision.camera.latest_frame`, `planning.PlannerThread`,
`serial_link.SerialLink`); in virtual time (`run.virtual_world`) the same code without
threads, so that a run takes a fraction of its time and is the same every time. Seconds of the
world's clock, metres, radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, TypeVar

from firmware_protocol.host.events import Event
from firmware_protocol.wire.messages import Waypoint
from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.planning import Answering, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.shared.supervisor import Part
from planner.scene import FloatArray, Scene
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.joined.floor_plan import FloorPlan

if TYPE_CHECKING:
    from navigation.simulator.truth import Truth

_Q = TypeVar("_Q")
_A = TypeVar("_A")
_Q_contra = TypeVar("_Q_contra", contravariant=True)


class Frames(Protocol):
    """The newest frame of a camera that is opened again when it fails."""

    @property
    def turns(self) -> int:
        """Grows while it works, or waits for work as it should."""
        ...

    def start(self) -> None:
        """Begin to read the camera."""

    def stop(self) -> None:
        """Close it."""

    def has_died(self) -> bool:
        """Whether it has ended by an error of the program."""
        ...

    def take(self, timeout_s: float) -> Frame | None:
        """The newest frame that was not yet taken, waiting for it, or until `wake`."""

    def wake(self) -> None:
        """End the wait of `take`, the present one or the next: there is other news."""

    def status(self) -> CameraStatus:
        """What the camera is doing now."""
        ...


def camera_part(frames: Frames) -> Part:
    """The camera's thread as the supervisor looks after it."""

    def restart() -> None:
        frames.stop()
        frames.start()

    return Part(lambda: frames.status().reason if frames.has_died() else None, restart)


class Link(Protocol):
    """The link to the robot; `SerialLink` says what its members mean."""

    @property
    def turns(self) -> int:
        """Grows while it works, or waits for work as it should."""
        ...

    @property
    def capture_to_wire_s(self) -> Sequence[float]:
        """How old pose fixes were when they were sent."""
        ...

    def open(self) -> None:
        """Open the port."""

    def failure(self) -> str | None:
        """The error that ended it, in words."""

    def late_s(self) -> float:
        """How late its thread was woken, at worst, since the last call."""
        ...

    def restart(self) -> None:
        """Start it again after an error."""

    def close(self) -> None:
        """Close it."""

    def upload(
        self,
        mission: int,
        waypoints: Sequence[Waypoint],
        start: bool = True,
        released: int | None = None,
    ) -> object:
        """Replace the robot's mission and drive it, or as much of it as is released."""

    def release(self, mission: int, count: int) -> None:
        """Let the first ``count`` waypoints of this mission be sent."""

    def pause(self) -> None:
        """Stop under control and keep the mission."""

    def clear(self) -> None:
        """Stop under control and drop the mission."""

    def lease(self, permit: bool, pose_age_s: float = math.inf, ttl_s: float = 0.5) -> None:
        """The control loop lives, and the robot may drive."""

    def pose_fix(self, x_m: float, y_m: float, heading_rad: float, captured_s: float) -> None:
        """Where the camera saw the robot."""

    def estop(self) -> None:
        """Emergency stop."""

    def reset_estop(self) -> None:
        """Leave the emergency stop."""

    def snapshot(self) -> LinkSnapshot:
        """The present state."""
        ...

    def events(self) -> Sequence[Event]:
        """What has happened since the last call, oldest first."""
        ...


class PlannerPart(Protocol[_Q_contra]):
    """Something that builds roadmaps and answers requests beside the control loop."""

    @property
    def turns(self) -> int:
        """Grows while it works, or waits for work as it should."""
        ...

    def start(self) -> None:
        """Begin."""

    def stop(self) -> None:
        """End."""

    def see(self, scene: Scene, revision: int, path_points: FloatArray | None) -> None:
        """Hand over a new scene, and the path that the robot is on."""

    def ask(self, request: _Q_contra) -> None:
        """Hand over a request."""

    def failure(self) -> str | None:
        """The error that ended it, in words."""

    def restart(self) -> None:
        """Start it again after an error."""


class Surroundings(Protocol):
    """What every run is connected to; opens and closes the simulated robots."""

    @property
    def calibration(self) -> Calibration:
        """Where pixels lie on the floor, of the picture that people are shown."""
        ...

    @property
    def floor_plan(self) -> FloorPlan | None:
        """The floor under several cameras; None where there is one."""
        ...

    @property
    def truths(self) -> Mapping[str, Truth]:
        """By name, of each simulated robot what only a simulation can know."""
        ...

    def clock(self) -> float:
        """Monotonic seconds."""
        ...

    def wait(self, seconds: float) -> None:
        """Let time pass."""

    def late_s(self) -> float:
        """How late this program's threads were woken, at worst, since the last call."""
        ...

    def make_frames(self) -> Frames:
        """The camera."""
        ...

    def make_vision(
        self, config: Config, witness: KnowsLatency, driven: Sequence[RobotSection]
    ) -> VisionStage:
        """Vision; ``driven`` are the driven robots where there are several."""
        ...

    def search_clock(self) -> float:
        """The seconds by which a search for plans is limited."""
        ...

    def make_link(self, name: str) -> Link:
        """The link to a robot, whose name is empty where it is alone."""
        ...

    def make_planner(
        self,
        planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> PlannerPart[_Q]:
        """The planner beside the control loop."""
        ...

    def start(self) -> None:
        """Switch simulated robots on."""

    def stop(self) -> None:
        """Switch them off."""
