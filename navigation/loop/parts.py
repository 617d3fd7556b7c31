"""Protocols of the loop's parts, in real or in virtual time.

In real time every part except the eye is a thread. In virtual time (`run.virtual_world`) the same
code runs without threads, so a run repeats exactly. Metres, radians, seconds of the world's clock.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, TypeVar

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.link.robot_link import RobotLink
from navigation.loop.planning import Answering, SceneCheck
from navigation.loop.seeing.vision_stage import KnowsLatency, VisionStage
from navigation.shared.supervisor import SupervisedPart
from planner.scene import FloatArray, Scene
from planner.zones.zone import Zone
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.joined.floor_plan import FloorPlan

if TYPE_CHECKING:
    from navigation.simulator.truth import Truth

_Q = TypeVar("_Q")
_A = TypeVar("_A")
_Q_contra = TypeVar("_Q_contra", contravariant=True)


class FrameSource(Protocol):
    """Newest frame of a camera, reopened when it fails."""

    @property
    def turns(self) -> int:
        """Counter that grows while it works or rightly waits for work."""
        ...

    def start(self) -> None:
        """Start it."""

    def stop(self) -> None:
        """Close it."""

    def has_died(self) -> bool:
        """True if an error ended it."""
        ...

    def take(self, timeout_s: float) -> Frame | None:
        """Wait for the newest frame not yet taken; `wake` ends the wait."""

    def wake(self) -> None:
        """End the present wait of `take`, or the next."""

    def status(self) -> CameraStatus:
        """Its state."""
        ...


def camera_part(frames: FrameSource) -> SupervisedPart:
    """The camera's thread as a part for the supervisor."""

    def restart() -> None:
        frames.stop()
        frames.start()

    return SupervisedPart(lambda: frames.status().reason if frames.has_died() else None, restart)


class PlannerPart(Protocol[_Q_contra]):
    """Builder of roadmaps and answers beside the control loop."""

    @property
    def turns(self) -> dict[str, int]:
        """Counters like `FrameSource.turns`, by thread."""
        ...

    def start(self) -> None:
        """Begin."""

    def stop(self) -> None:
        """End."""

    def see(
        self,
        scene: Scene,
        revision: int,
        path_points: FloatArray | None,
        zones: Sequence[Zone] = (),
    ) -> None:
        """Hand over scene, present path and zones."""

    def ask(self, request: _Q_contra) -> None:
        """Hand over a request."""

    def failure(self) -> str | None:
        """Error that ended it, in words."""

    def restart(self) -> None:
        """Restart it."""


class Surroundings(Protocol):
    """Everything outside a run; opens and closes the simulated robots."""

    @property
    def calibration(self) -> Calibration:
        """Calibration of the picture shown to people."""
        ...

    @property
    def floor_plan(self) -> FloorPlan | None:
        """Floor under several cameras; None with one camera."""
        ...

    @property
    def truths(self) -> Mapping[str, Truth]:
        """Ground truth of the simulated robots, by name."""
        ...

    def clock(self) -> float:
        """Monotonic seconds."""
        ...

    def wait(self, seconds: float) -> None:
        """Let time pass."""

    def late_s(self) -> float:
        """Longest delay in waking a thread since the last call."""
        ...

    def make_frames(self) -> FrameSource:
        """Make the camera."""
        ...

    def make_vision(
        self, config: Config, witness: KnowsLatency, driven: Sequence[RobotSection]
    ) -> VisionStage:
        """Make vision for the driven robots."""
        ...

    def search_clock(self) -> float:
        """Seconds that limit a search for plans."""
        ...

    def make_link(self, name: str) -> RobotLink:
        """Make the link to a robot."""
        ...

    def make_planner(
        self,
        planner: Answering[_Q, _A],
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[_A], None],
    ) -> PlannerPart[_Q]:
        """Make the planner."""
        ...

    def start(self) -> None:
        """Switch simulated robots on."""

    def stop(self) -> None:
        """Switch them off."""
