"""A world in virtual time whose robots and cameras have the faults of real ones.

A test switches `RobotTroubles` and `CameraTroubles` during a run; of the latter only pictures and
their stamps change. Seconds.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.troubled_robot import TroubledLink, TroubledRobot
from vision.camera.camera import Camera, CameraError, Frame, Image, SourceState

NOISE_GREY = 2.0


@dataclass(slots=True)
class CameraTroubles:
    """Faults that a test may switch during a run; none at first."""

    camera_lost: bool = False
    """Reading fails, and so does opening it again."""
    camera_silent: bool = False
    """It gives no picture, without an error."""
    camera_frozen: bool = False
    """It repeats its last picture with new times."""
    frozen_noise: bool = False
    """A frozen picture has fresh noise."""
    clock_in_the_corner: bool = False
    """Every picture shows the time: no two are the same."""
    stream_latency_s: float = 0.0
    """Pictures come this late, stamped when they arrive."""
    future_s: float = 0.0
    """Pictures are stamped this far in the future."""
    looping: bool = False
    """It repeats its last `RECORDED` pictures."""


RECORDED = 90


class TroubledCamera:
    """A camera between the simulated one and the program."""

    def __init__(
        self,
        camera: Camera,
        troubles: CameraTroubles,
        memory: SeenPictures,
        now: Callable[[], float],
        wait: Callable[[float], None],
    ) -> None:
        self._camera, self._troubles, self._memory = camera, troubles, memory
        self._now, self._wait = now, wait
        self.name = camera.name

    @property
    def state(self) -> SourceState:
        """State of the simulated camera."""
        return self._camera.state

    @property
    def reason(self) -> str:
        """Reason given by the simulated camera."""
        return self._camera.reason

    @property
    def rate_hz(self) -> float:
        """Rate of the simulated camera."""
        return self._camera.rate_hz

    @property
    def may_repeat(self) -> bool:
        """True if the simulated camera may repeat pictures."""
        return self._camera.may_repeat

    def open(self) -> None:
        """Open it."""
        self._camera.open()

    def close(self) -> None:
        """Close it; pictures under way still arrive, as from a stream."""
        self._camera.close()

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next picture, with its faults."""
        troubles = self._troubles
        if troubles.camera_lost:
            raise CameraError(f"{self.name}: is unplugged")
        if troubles.camera_silent:
            self._wait(timeout_s)
            return None
        frame = self._camera.read(timeout_s)
        if frame is not None:
            self._memory.under_way.append(self._with_troubles(frame))
        under_way, now_s = self._memory.under_way, self._now()
        if not under_way or under_way[0].captured_s + troubles.stream_latency_s > now_s:
            return None
        frame = under_way.popleft()
        if troubles.stream_latency_s > 0.0:
            frame = replace(frame, captured_s=now_s)
        return replace(frame, captured_s=frame.captured_s + troubles.future_s)

    def _with_troubles(self, frame: Frame) -> Frame:
        troubles, memory = self._troubles, self._memory
        image = frame.image
        if troubles.camera_frozen and memory.last is not None:
            image = memory.last
            if troubles.frozen_noise:
                image = memory.noisy(image)
        elif troubles.looping and memory.recorded:
            image = memory.recorded[memory.played % len(memory.recorded)]
            memory.played += 1
        else:
            memory.last = image
            memory.recorded.append(image)
        if troubles.clock_in_the_corner:
            image = with_clock(image, frame.captured_s)
        return replace(frame, image=image)


class SeenPictures:
    """Pictures seen before: opening a frozen camera again does not thaw it."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.last: Image | None = None
        self.recorded: deque[Image] = deque(maxlen=RECORDED)
        self.played = 0
        self.under_way: deque[Frame] = deque()
        self._rng = rng

    def noisy(self, image: Image) -> Image:
        """Return the picture with fresh noise."""
        noise = self._rng.normal(0.0, NOISE_GREY, image.shape)
        return np.clip(image + noise, 0, 255).astype(np.uint8)


def with_clock(image: Image, time_s: float) -> Image:
    """Draw the time into the picture's corner."""
    shown = image.copy()
    cv2.rectangle(shown, (0, 0), (120, 14), 230, -1)
    cv2.putText(shown, f"12:00:{time_s:06.3f}", (2, 11), cv2.FONT_HERSHEY_PLAIN, 0.9, 20, 1)
    return shown


class TroubledWorld(VirtualWorld):
    """The world, with troubles of each robot, and of each camera by name in ``cameras``."""

    bodies: dict[str, TroubledRobot]  # type: ignore[assignment]

    def __init__(self, config: Config, *given: Any, **named: Any) -> None:
        super().__init__(config, *given, **named)
        assert config.simulation is not None
        self.cameras: defaultdict[str | None, CameraTroubles] = defaultdict(CameraTroubles)
        self._memories = {
            name: SeenPictures(np.random.default_rng(config.simulation.seed + i))
            for i, name in enumerate(each_camera(config) or [None])
        }

    def make_body(self, config: Config) -> TroubledRobot:
        """Make one robot with troubles."""
        return TroubledRobot.of(config)

    def make_link(self, name: str) -> TroubledLink:
        """Make the link to one robot."""
        return TroubledLink(self.bodies[name])

    def open_camera(self, name: str | None = None) -> Camera:
        """Make a camera over the arena as it is now, unless it is unplugged."""
        troubles = self.cameras[name]
        if troubles.camera_lost:
            raise CameraError("simulated camera: is unplugged")
        camera = super().open_camera(name)
        return TroubledCamera(camera, troubles, self._memories[name], self.clock, self.wait)
