"""A virtual loop that drives by itself: a camera sees the robot, a control loop gives leases."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from navigation.simulator.drive_model import TruePose
from navigation.simulator.virtual_loop import TICK_S, Knobs, VirtualLoop


@dataclass(frozen=True)
class CameraModel:
    """Poses of the simulated camera: rate, delay, noise (standard deviations)."""

    rate_hz: float = 30.0
    delay_s: float = 0.04
    noise_m: float = 0.0008
    noise_rad: float = 0.006


@dataclass(slots=True)
class ScenarioKnobs(Knobs):
    """Switches of a scenario, those of its camera and control loop included."""

    camera: bool = True
    lease: bool = True
    permit: bool = True
    echo: bool = False


@dataclass(slots=True)
class ScenarioLoop(VirtualLoop):
    """The whole loop; :meth:`run` it, and look at ``host``, ``robot``, ``drive``, ``track``."""

    camera: CameraModel = field(default_factory=CameraModel)
    lease_hz: float = 10.0
    knobs: ScenarioKnobs = field(default_factory=ScenarioKnobs, init=False)
    _seen: deque[tuple[float, TruePose]] = field(default_factory=deque, init=False)
    _captured_s: float = field(default=0.0, init=False)
    _lease_ticks: int = field(init=False)
    _camera_ticks: int = field(init=False)

    def __post_init__(self) -> None:
        VirtualLoop.__post_init__(self)
        self._lease_ticks = round(1.0 / self.lease_hz / TICK_S)
        self._camera_ticks = round(1.0 / self.camera.rate_hz / TICK_S)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> bool:
        """Let time pass; True as soon as ``until`` holds (checked every 10 ms)."""
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.tick()
            if until is not None and self._ticks % 10 == 0 and until():
                return True
        return until is None

    def tick(self) -> None:
        """One millisecond, in which the camera may look and the control loop may give a lease."""
        VirtualLoop.tick(self)
        knobs = self.knobs
        if knobs.camera or self._seen:
            self._look()
        if knobs.lease and self._ticks % self._lease_ticks == 0:
            self.host.lease(self.now_s, 0.5, knobs.permit, self.now_s - self._captured_s)

    def _bytes_to_robot(self, now_s: float) -> bytes:
        arrived = VirtualLoop._bytes_to_robot(self, now_s)
        if arrived and self.knobs.echo:
            self.to_host.put(arrived, now_s)
        return arrived

    def _look(self) -> None:
        if self.knobs.camera and self._ticks % self._camera_ticks == 0:
            x, y, heading = self.drive.pose
            x += self.camera.noise_m * float(self._rng.standard_normal())
            y += self.camera.noise_m * float(self._rng.standard_normal())
            heading += self.camera.noise_rad * float(self._rng.standard_normal())
            self._seen.append((self.now_s, TruePose(x, y, heading)))
        while self._seen and self._seen[0][0] + self.camera.delay_s <= self.now_s:
            self._captured_s, pose = self._seen.popleft()
            self.host.pose_fix(*pose, self._captured_s)
