"""The configured cameras in real time: one, or several as one.

Knowledge of a device is kept between openings.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import partial

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.config.values import SIMULATED
from navigation.run.devices.device_settings import device_settings
from vision.camera.camera import Camera, Clock
from vision.camera.latest_frame import LatestFrame
from vision.camera.several_frames import SeveralFrames
from vision.camera.sources import KnownCamera, camera_for


class Cameras:
    """The cameras; ``simulated`` makes one from its name and configuration."""

    def __init__(
        self, config: Config, clock: Clock, simulated: Callable[[str | None, Config], Camera]
    ) -> None:
        self._config, self._named = config, each_camera(config)
        self._known: defaultdict[str | None, KnownCamera] = defaultdict(KnownCamera)
        self._clock, self._simulated = clock, simulated

    def open(self, name: str | None = None) -> Camera:
        """Make a closed camera, always of the same source."""
        config = self._config if name is None else self._named[name]
        camera = config.camera
        if camera.source == SIMULATED:
            return self._simulated(name, config)
        return camera_for(
            camera.source,
            clock=self._clock,
            rate_hz=camera.rate_hz,
            size=camera.size_px,
            loop=camera.loop,
            device=device_settings(camera),
            known=self._known[name],
        )

    def frames(self) -> LatestFrame | SeveralFrames:
        """Make the camera in a thread of its own, or each of several."""
        if not self._named:
            return LatestFrame(self.open, self._clock)
        return SeveralFrames({name: partial(self.open, name) for name in self._named}, self._clock)
